"""Period map → exponents in log form, bounds, verdict: a file a kind of map."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..environment import check_environment
from ..errors import ParameterError, did_you_mean
from ..kernels import POINTS, cores, keep_memory, part_of
from ..period_map import Method, PeriodMap, period_map
from ..period_map.tensor import TensorGrid
from ..periodic import PeriodicSystem
from ..verdict import Reason, Verdict
from .evidence import certified, checked
from .factors import of_constant, of_factors
from .grid import of_grid
from .hill import of_hill
from .identical import of_identical
from .result import PER_CASE, PER_STATE, Stability

__all__ = ["BEYOND", "Reason", "Stability", "Verdict", "exponents", "stability"]

CHUNK = 32768  # cases made and solved at once: their maps stay in a cache
LEAST = 4096  # cases worth a thread
#: What NumPy is not to warn of: a parameter beyond doubles gives nan, with a bound of inf.
BEYOND: Any = {"over": "ignore", "invalid": "ignore", "divide": "ignore"}


@np.errstate(**BEYOND)
def stability(
    system: PeriodicSystem,
    *,
    panels: int | None = None,
    symmetry: bool = True,
    map: bool | str = False,
    check: bool = False,
    certify: bool = False,
) -> Stability:
    """Exponents, bounds and verdict of a system.

    Parameters
    ----------
    system : PeriodicSystem
        Many cases are solved by all cores (``FLOQUET_THREADS`` says how many); the answers do not depend on how many.
    panels : int, optional
        Fixes the resolution, for convergence studies.
    symmetry : bool
        Identical blades: take the exponents of one blade, shifted by whole numbers; False integrates all coordinates.
    map : bool or str
        A scalar equation (one blade, a teetering rotor, Mathieu) over a tensor grid of parameters: solve it at nodes
        and take polynomials between them, four to seven times as fast with bounds of 2e-13 instead of 1e-14; what
        no nodes can carry is solved as without.  The name of a parameter has nodes along its axis alone, and answers
        that do not depend on what else is on the grid.  See :mod:`floquet.period_map.chebyshev`.
    check : bool
        Compute the exponents a second time by Koopman–Hill projection, which shares no mechanism with the period map;
        a :class:`~floquet.errors.FailedError` if the two disagree beyond their bounds.
    certify : bool
        Prove exponents and verdict by ball arithmetic (extra ``certify``): milliseconds a blade.
    """
    if not isinstance(system, PeriodicSystem):
        raise ParameterError(
            "system", system, f"{type(system).__name__} is no system: make one with flapping(rotor, advance_ratio)"
        )
    for name, value in (("symmetry", symmetry), ("check", check), ("certify", certify)):
        if not isinstance(value, (bool, np.bool_)):
            raise ParameterError(name, value, f"{value!r} is neither True nor False")
    check_environment()
    if (check or certify) and not math.prod(system.cases):
        raise ParameterError(
            "check" if check else "certify",
            True,
            f"there is no case to be {'checked' if check else 'proved'}: the parameters are empty arrays",
        )
    if map and panels is not None:
        raise ParameterError("panels", panels, "a map chooses the panels of its nodes: give either map or panels")
    _check_map(map, system if system.blade is None else system.blade)
    found = _computed(system, panels, symmetry, map)
    if check:
        found = checked(found, system)
    return certified(found, system) if certify else found


def _check_map(map: bool | str, system: PeriodicSystem) -> None:
    """True, False, or a parameter of the model."""
    known = () if system.equation is None else tuple(system.equation.parameters)
    if not (isinstance(map, (bool, np.bool_)) or map in known):
        raise ParameterError(
            "map",
            map,
            f"{map!r} is no parameter of this system{did_you_mean(str(map), known)}; "
            + (f"it has {', '.join(known)}" if known else "it was made of matrices, which have none"),
        )


def _computed(system: PeriodicSystem, panels: int | None, symmetry: bool, map: bool | str) -> Stability:
    if system.constant:
        return of_constant(system)
    if system.blade is not None and symmetry:
        return of_identical(_computed(system.blade, panels, symmetry, map), system.degrees, system.period)
    if map and (grid := TensorGrid.of(system, None if map is True else map)) is not None:
        return of_grid(grid)
    if system.function is None and (cases := math.prod(system.cases)) >= POINTS:
        keep_memory()
        if len(ends := _ends(cases, CHUNK if system.degrees == 1 else CHUNK // 2)) > 2:
            return _in_chunks(system, panels, ends)
    return exponents(period_map(system, panels=panels))


def exponents(phi: PeriodMap) -> Stability:
    """Exponents, bounds and verdict of a period map."""
    return of_hill(phi) if phi.method in (Method.HILL, Method.MAP) else of_factors(phi)


def _ends(n: int, most: int) -> list[int]:
    """Where chunks of n cases begin and end: as long as one another, as many for every core."""
    workers = cores()
    count = max(1, min(workers * math.ceil(n / (most * workers)), n // LEAST))
    return [n * i // count for i in range(count + 1)]


def _in_chunks(system: PeriodicSystem, panels: int | None, ends: list[int]) -> Stability:
    """Some cases after the other, or on several cores."""
    shape, states = system.cases, system.states
    n = math.prod(shape)
    fields = {name: np.empty(n, kind) for name, kind in PER_CASE.items()}
    fields |= {name: np.empty((n, states), kind) for name, kind in PER_STATE.items()}

    def solve(some: slice) -> None:
        with part_of(n), np.errstate(**BEYOND):
            found = exponents(period_map(system.part(some), panels=panels))
        for name, values in fields.items():
            values[some] = getattr(found, name)

    if system.equation is None:
        system = system.part(slice(None))  # along one axis, once
    with ThreadPoolExecutor(cores()) as pool:
        list(pool.map(solve, map(slice, ends[:-1], ends[1:])))
    shaped: dict[str, Any] = {
        name: v.reshape(*shape, states) if name in PER_STATE else v.reshape(shape) for name, v in fields.items()
    }
    return Stability(period=system.period, **shaped)
