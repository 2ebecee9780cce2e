"""Any system: the factors of its map, one a panel, kept apart because their product would lose small multipliers.

Many cases with trigonometric coefficients go to Taylor series (:mod:`.series`), others to Gauss collocation
(:mod:`.collocated`).  Either maps second-order systems in (q, q'/s) with s a power of two about as large as their
frequencies, so that the entries of a map and their errors are of one size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..kernels import worth_compiling
from ..periodic import PeriodicSystem
from .collocated import Collocation
from .result import Method, PeriodMap
from .series import Series

__all__ = ["FactorMap", "Factors", "factor_map"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LADDER = np.array(sorted({k << n for k in (4, 5, 6, 7) for n in range(11)} | {1, 2, 3}))  # numbers of panels
MOST = 8.0  # times the first number: what is smooth is resolved by then, other places need kinks declared
HOPELESS = 16.0  # times fewer panels than wanted: the estimates of errors are of no series that falls
CASES_AT_ONCE = 4096  # 4 MB of coefficients


@dataclass(frozen=True, eq=False)
class Factors:
    """Maps of the panels of cases that have equally many.

    Attributes
    ----------
    cases : (count,)
        Which; number k is lane k % lanes of block k // lanes, and what is left of the last block repeats a case.
    maps : (blocks, panels, n, n, lanes)
        First panel first.
    errors : (blocks, panels, lanes)
        Bounds of the 2-norms of their errors.
    """

    cases: Index
    maps: Array
    errors: Array

    def of(self, places: Index) -> tuple[Array, Array]:
        """Maps (k, panels, n, n) and errors (k, panels) of some of the cases, by their places in ``cases``."""
        block, lane = np.divmod(places, self.maps.shape[-1])
        return self.maps[block, ..., lane], self.errors[block, :, lane]


@dataclass(frozen=True, eq=False, kw_only=True)
class FactorMap(PeriodMap):
    """Φ as factors.

    Attributes
    ----------
    groups : tuple of Factors
        What a later one says of a case replaces what an earlier one did.
    """

    groups: tuple[Factors, ...] = ()


class Solver(Protocol):
    """A way to map panels.

    Attributes
    ----------
    wanted : (cases,) or (1,)
        Panels a period that are probably enough.
    lengths : (cases, pieces) or (1, pieces)
        Of the pieces, as far as they lie within the period.
    trace : (cases,) or (1,)
        Mean trace of A.
    """

    wanted: Array
    lengths: Array
    trace: Array

    def maps(self, cases: Index, counts: list[int]) -> tuple[Array, Array, Array]:
        """Maps and errors as in :class:`Factors`, with so many panels on each piece, and how many times more each case
        would need to be resolved (cases,)."""


def factor_map(system: PeriodicSystem, panels: int | None) -> FactorMap:
    shape, states = system.cases, system.states
    count = math.prod(shape)
    many = worth_compiling(count * states**2 // 2)  # NumPy's time for a blade is less, and grows with states cubed
    solver: Solver = Series(system) if many and system.function is None and states > 1 else Collocation(system)
    groups, used = _refined(solver, system.period, count, panels)
    return FactorMap(
        method=Method.FACTORS,
        period=system.period,
        shape=shape,
        mean=np.broadcast_to(solver.trace, (count,)),
        panels=used,
        twist=system.twist,
        groups=tuple(groups),
        states=states,
    )


def _refined(solver: Solver, period: float, count: int, panels: int | None) -> tuple[list[Factors], NDArray[np.int32]]:
    """Map every case with panels enough, or with ``panels``; their number follows from the case alone."""
    wanted = np.broadcast_to(solver.wanted, (count,))
    lengths = np.broadcast_to(solver.lengths, (count, solver.lengths.shape[-1]))
    rung = np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)
    rung[wanted > HOPELESS * LADDER[-1]] = 0  # so that they take no time
    last = np.minimum(np.searchsorted(LADDER, MOST * LADDER[rung]), len(LADDER) - 1)
    groups: list[Factors] = []
    used = np.zeros(count, np.int32)
    pending = np.arange(count)
    while pending.size:
        total = np.full(len(pending), panels) if panels else LADDER[rung[pending]]
        counts = np.maximum(np.ceil(total[:, None] * lengths[pending] / period - 1e-9), 1).astype(int)
        kinds, member = np.unique(counts, axis=0, return_inverse=True)
        short = []
        for kind, numbers in enumerate(kinds):
            group = pending[member.ravel() == kind]
            for some in np.split(group, range(CASES_AT_ONCE, len(group), CASES_AT_ONCE)):
                maps, errors, times = solver.maps(some, numbers.tolist())
                _without_bounds(errors, wanted[some] > HOPELESS * numbers.sum())
                groups.append(Factors(some, maps, errors))
                used[some] = numbers.sum()
                again = (times > 1.0) & (rung[some] < last[some])
                short.append(some[again])
                further = np.searchsorted(LADDER, LADDER[rung[some]] * np.minimum(times, MOST))
                rung[some] = np.clip(further, rung[some] + again, last[some])
        pending = pending[:0] if panels else np.concatenate(short)
    return groups, used


def _without_bounds(errors: Array, where: NDArray[np.bool_]) -> None:
    """Errors (blocks, panels, lanes) of some cases are not known."""
    block, lane = np.divmod(np.flatnonzero(where), errors.shape[-1])
    errors[block, :, lane] = np.inf
