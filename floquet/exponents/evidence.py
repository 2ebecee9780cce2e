"""Answers that are checked by another mechanism, or proved."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from ..errors import FailedError, FloquetWarning
from ..period_map import Method
from ..periodic import PeriodicSystem
from .result import Stability, plain

__all__ = ["certified", "checked"]

COARSER = 1e5  # times the bounds: of smooth systems the check has 1e3
COARSE = 1e-14  # bounds below are as good as this


def checked(found: Stability, system: PeriodicSystem) -> Stability:
    """``found`` beside the exponents by Koopman–Hill projection; a FailedError where they disagree beyond bounds."""
    from ..koopman import koopman_hill, require_agreement

    hill = koopman_hill(system)
    require_agreement(found, hill)
    apart = np.asarray(hill.exponent_errors) / np.maximum(np.asarray(found.exponent_errors), COARSE)
    if np.any(apart > COARSER):
        worst = float(np.asarray(hill.exponent_errors).ravel()[np.argmax(apart)])
        warnings.warn(
            f"Hill's matrix confirms exponents to {worst:.1e} only, {np.max(apart):.0e} times their own bounds: so it "
            "is where coefficients or their derivatives jump; a jump that was not declared is in neither bound",
            FloquetWarning,
            stacklevel=3,
        )
    return replace(found, check=hill)


def certified(found: Stability, system: PeriodicSystem) -> Stability:
    """Proven exponents, errors, verdict and reason in place of computed ones, and the certificates."""
    from ..certify import certify

    certificates = tuple(certify(system))
    shape, states = np.shape(found.verdict), system.states
    eta = np.array([c.exponents for c in certificates]).reshape(*shape, states)
    radii = np.array([c.radii for c in certificates]).reshape(*shape, states)
    _require_containment(found, eta, radii)
    said = {
        "verdict": np.array([c.verdict for c in certificates], np.int8),
        "reason": np.array([c.reason for c in certificates], np.int8),
        "method": np.full(len(certificates), Method.CERTIFIED, np.int8),
    }
    rho = np.asarray(found.rotation_number)
    said["rotation_number"] = np.where(np.isnan(rho), np.nan, eta[..., 0].imag)
    said["lock"] = np.where(np.isnan(found.lock), np.nan, said["rotation_number"])
    fields = plain({name: value.reshape(shape) for name, value in said.items()}, shape)
    return replace(found, exponents=eta, exponent_errors=radii, certificates=certificates, **fields)


def _require_containment(found: Stability, eta: np.ndarray, radii: np.ndarray) -> None:
    """Each computed exponent is within its bound of a proven one, modulo 2πi/period."""
    turn = 0.0 if np.isnan(found.period) else 2.0 * np.pi / found.period
    gaps = np.asarray(found.exponents)[..., :, None] - eta[..., None, :]
    if turn:
        gaps = gaps - 1j * turn * np.round(gaps.imag / turn)
    allowed = np.asarray(found.exponent_errors)[..., :, None] + radii[..., None, :]
    near = np.any(np.abs(gaps) <= allowed, axis=-1) | ~np.isfinite(found.exponent_errors)  # whose map overflowed
    if not np.all(near):
        worst = float(np.min(np.abs(gaps), axis=-1)[~near].max())
        raise FailedError(
            f"computed exponents are up to {worst:.1e} from the proven ones, beyond their bound: the error is in the "
            "program, not in the system; please report it with the system's parameters"
        )
