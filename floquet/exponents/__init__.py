"""Period map → multipliers, exponents in log form, bounds, verdict.

One blade: with τ and D the half trace and the discriminant of the Hill form, ``cosh νT = τ``, ``sinh² νT = D``::

    D ≤ 0   α ± iρ, ρ lifted to its branch by the turns of the path (Prüfer rotation number)
    D > 0   a lock: σ₁,₂ + iρ with σ = α ± asinh(√D)/T and ρ a multiple of π/T

An error b in D moves √D by at most b/√|D| away from a branch point and √(|D|+b) next to it; the bound follows both.

Several states: forward QR sweeps sort the factors' product into clusters of like growth without forming it; a cluster's
exponents are the eigenvalues of its own block, and their logarithms add up.  What an error of a factor does to a
cluster is weighed with the projector onto it (from the angle between the growing directions of the map and of its
adjoint).
"""

from __future__ import annotations

from ..errors import ParameterError
from ..period_map import Method, PeriodMap, period_map
from ..periodic import PeriodicSystem
from .factors import of_constant, of_factors
from .hill import of_hill, rotation_number
from .result import Reason, Stability, Verdict

__all__ = ["Reason", "Stability", "Verdict", "exponents", "rotation_number", "stability"]


def stability(system: PeriodicSystem, *, panels: int | None = None) -> Stability:
    """Exponents, bounds and verdict of ``system``; ``panels`` fixes the resolution (for convergence studies)."""
    if not isinstance(system, PeriodicSystem):
        raise ParameterError(
            "system", system, f"{type(system).__name__} is no system: make one with flapping(rotor, advance_ratio)"
        )
    if system.constant:
        return of_constant(system)
    return exponents(period_map(system, panels=panels))


def exponents(phi: PeriodMap) -> Stability:
    """Exponents, bounds and verdict of a period map."""
    return of_hill(phi) if phi.method == Method.HILL else of_factors(phi)
