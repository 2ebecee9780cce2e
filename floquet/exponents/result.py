"""Exponents of a system with what is needed to trust them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..period_map import Method, PeriodMap
from ..verdict import Reason, Verdict

if TYPE_CHECKING:  # their homes load SciPy and python-flint
    from ..certify import Certificate
    from ..koopman import HillCheck

__all__ = ["Reason", "Stability", "Verdict"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)

PER_STATE = {"exponents": np.complex128, "exponent_errors": np.float64}
PER_CASE = dict.fromkeys(("determinant_defect", "rotation_number", "lock"), np.float64) | dict.fromkeys(
    ("verdict", "reason", "method"), np.int8
) | {"panels": np.int32}  # fmt: skip


@dataclass(frozen=True, eq=False, kw_only=True)
class Stability:
    """Exponents of a periodic or constant system, with what is needed to trust them.

    Arrays have the cases' axes first; a single case has plain numbers.

    Attributes
    ----------
    exponents : complex (..., states)
        η per radian (per rev for rotors).  One scalar equation: [α+iρ, α-iρ], in a lock [σ₁+iρ, σ₂+iρ] with σ₁ ≥ σ₂,
        on the branch of the rotation number.  Larger systems: principal branch, conjugate pairs together, by Im then
        Re.
    exponent_errors : float (..., states)
        Bound of the distance to the exact set of exponents modulo 2πi/period.
    determinant_defect : float (...)
        |det Φ - 1| of the Hill form, or |Σσ - mean tr A|: a check that can fail.
    rotation_number, lock : float (...)
        ρ; ρ again inside a lock, else nan.
    verdict, reason, method : int8 (...)
        :class:`Verdict`, :class:`Reason`, :class:`~floquet.period_map.Method`.
    panels : int (...)
    period : float
        Angle of the map; nan for constant systems.
    check : HillCheck or None
        The same exponents by Koopman–Hill projection, if that was asked for; see :mod:`floquet.koopman`.
    certificates : tuple of Certificate or None
        One a case, if they were asked for: exponents, their errors, verdict and reason are then proven ones.
    """

    exponents: Any
    exponent_errors: Any
    determinant_defect: Any
    rotation_number: Any
    lock: Any
    verdict: Any
    reason: Any
    method: Any
    panels: Any
    period: float
    check: HillCheck | None = None
    certificates: tuple[Certificate, ...] | None = None

    @property
    def multipliers(self) -> Any:
        """exp(η·period), complex (..., states); of the twisted passage, where there is a twist; nan if constant."""
        with np.errstate(over="ignore"):  # a multiplier beyond the range of doubles is inf; its exponent is not
            return np.exp(self.exponents * self.period)


def verdict_of(sigma: Array, errors: Array, *, neutral: NDArray[np.bool_]) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    stable, unstable = np.all(sigma + errors < 0, axis=-1), np.any(sigma - errors > 0, axis=-1)
    verdict = np.where(stable, Verdict.STABLE, np.where(unstable, Verdict.UNSTABLE, Verdict.UNDECIDED))
    reason = np.where(verdict != Verdict.UNDECIDED, Reason.NONE, np.where(neutral, Reason.NEUTRAL, Reason.BOUND))
    return verdict.astype(np.int8), reason.astype(np.int8)


def shaped(
    phi: PeriodMap,
    eta: Array,
    errors: Array,
    defect: Array,
    rho: Array,
    lock: Array,
    verdict: NDArray[np.int8],
    reason: NDArray[np.int8],
) -> Stability:
    shape, n = phi.shape, eta.shape[-1]
    full: dict[str, Any] = {
        "determinant_defect": defect,
        "rotation_number": rho,
        "lock": lock,
        "verdict": verdict,
        "reason": reason,
        "method": np.full(len(eta), phi.method, np.int8),
        "panels": phi.panels,
    }
    vectors: dict[str, Any] = {"exponents": eta, "exponent_errors": errors}
    return Stability(
        period=phi.period,
        **{k: v.reshape(*shape, n) for k, v in vectors.items()},
        **plain({k: v.reshape(shape) for k, v in full.items()}, shape),
    )


def plain(fields: dict[str, Any], shape: tuple[int, ...]) -> dict[str, Any]:
    """Python scalars for a single case; verdict, reason and method as their enums."""
    if shape:
        return fields
    enums = {"verdict": Verdict, "reason": Reason, "method": Method}
    return {k: enums[k](int(v)) if k in enums else v.item() for k, v in fields.items()}
