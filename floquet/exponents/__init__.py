"""Period map → exponents in log form, bounds, verdict: a file a kind of map."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..errors import ParameterError
from ..kernels import POINTS, cores, keep_memory
from ..period_map import Method, PeriodMap, period_map
from ..periodic import PeriodicSystem
from .factors import of_constant, of_factors
from .hill import of_hill
from .identical import of_identical
from .result import PER_CASE, PER_STATE, Reason, Stability, Verdict

__all__ = ["Reason", "Stability", "Verdict", "exponents", "stability"]

CHUNK = 16384  # cases made and solved at once: their coefficients and maps stay in a cache


def stability(system: PeriodicSystem, *, panels: int | None = None, symmetry: bool = True) -> Stability:
    """Exponents, bounds and verdict of a system.

    Parameters
    ----------
    system : PeriodicSystem
        Many cases are solved by all cores (``FLOQUET_THREADS`` says how many); the answers do not depend on how many.
    panels : int, optional
        Fixes the resolution, for convergence studies.
    symmetry : bool
        Identical blades: take the exponents of one blade, shifted by whole numbers; False integrates all coordinates.
    """
    if not isinstance(system, PeriodicSystem):
        raise ParameterError(
            "system", system, f"{type(system).__name__} is no system: make one with flapping(rotor, advance_ratio)"
        )
    if system.constant:
        return of_constant(system)
    if system.blade is not None and symmetry:
        return of_identical(stability(system.blade, panels=panels), system.degrees, system.period)
    if system.second_order and (cases := math.prod(system.cases)) >= POINTS:
        keep_memory()
        if cases > CHUNK:
            return _in_chunks(system, panels)
    return exponents(period_map(system, panels=panels))


def exponents(phi: PeriodMap) -> Stability:
    """Exponents, bounds and verdict of a period map."""
    return of_hill(phi) if phi.method == Method.HILL else of_factors(phi)


def _in_chunks(system: PeriodicSystem, panels: int | None) -> Stability:
    """Some cases after the other, or on several cores."""
    shape, states = system.cases, system.states
    n = math.prod(shape)
    fields = {name: np.empty(n, kind) for name, kind in PER_CASE.items()}
    fields |= {name: np.empty((n, states), kind) for name, kind in PER_STATE.items()}

    def solve(start: int) -> None:
        some = slice(start, start + CHUNK)
        found = exponents(period_map(system.part(some), panels=panels))
        for name, values in fields.items():
            values[some] = getattr(found, name)

    if system.equation is None:
        system = system.part(slice(None))  # along one axis, once
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(solve, range(0, n, CHUNK)))
    return Stability(
        period=system.period,
        **{name: v.reshape(*shape, states) if name in PER_STATE else v.reshape(shape) for name, v in fields.items()},
    )
