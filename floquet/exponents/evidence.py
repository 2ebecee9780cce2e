"""Answers that are checked by another mechanism, or proved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import FailedError
from ..period_map import Method
from ..periodic import PeriodicSystem
from .result import Stability, plain

__all__ = ["certified", "checked"]


def checked(found: Stability, system: PeriodicSystem) -> Stability:
    """``found`` beside the exponents by Koopman–Hill projection; a FailedError where they disagree beyond bounds."""
    from ..koopman import koopman_hill, require_agreement

    hill = koopman_hill(system)
    require_agreement(found, hill)
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
    near = np.any(np.abs(gaps) <= allowed, axis=-1)
    if not np.all(near):
        worst = float(np.min(np.abs(gaps), axis=-1)[~near].max())
        raise FailedError(
            f"computed exponents are up to {worst:.1e} from the proven ones, beyond their bound: the error is in the "
            "program, not in the system; please report it with the system's parameters"
        )
