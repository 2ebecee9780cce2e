"""One scalar equation, mapped in its Hill form.

How many panels a point needs follows from its q alone: from the frequency √|q| and, for every harmonic n of amplitude
a_n, from the terms (nh)^k of its Taylor series.  The rule below was fitted to what 18 000 random blades and Mathieu
equations needed; points that need more go up the ladder.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..kernels.hill import ROWS, map_equal_panels
from ..kernels.pieces import Pieces, map_pieces
from ..periodic import PeriodicSystem
from .form import hill_form
from .precise import make_precise
from .result import Method, PeriodMap

__all__ = ["hill_map"]

Array = NDArray[np.float64]

#: Numbers of panels a turn of harmonic 1, by about an eighth.
LADDER = np.array([*range(2, 17), *(round(16 * 1.125**k) for k in range(1, 50))], np.int64)
PLACES = np.searchsorted(LADDER, np.arange(LADDER[-1] + 1)).astype(np.int16)  # of a number of panels on the ladder
COUNTABLE = 2.1  # panels a turn over √|q|: less than half a turn (π) of y each, so that its zeros are counted
FREQUENCY, HARMONIC, AMPLITUDE = 0.9, 1.1, 2.2
RUNGS = 16  # a factor of eight: what is smooth is resolved by then, other places need kinks declared


def hill_map(
    system: PeriodicSystem,
    panels: int | None = None,
    *,
    precise: bool = True,
    compiled: bool | None = None,
    alike: int = 1,
) -> PeriodMap:
    """Map of one scalar equation.

    ``precise``: in forty digits next to branch points; ``compiled``: by compiled kernels, however few the points;
    ``alike``: so many points one after another are mapped on the panels of the stiffest of them.
    """
    shape = system.cases
    q, alpha, size = hill_form(system.part(slice(None)))
    n = math.prod(shape)
    rows, used = np.empty((len(ROWS), n)), np.empty(n, np.int32)
    if len(q.places) == 1 and len(q.polynomials[0]) <= 5 and q.kicks is None:
        _map_smooth(q, size, system.period, panels, rows, used, compiled=compiled, alike=alike)
    else:
        _map_pieces(q, size, panels, rows, used, compiled=compiled)
    phi = PeriodMap(
        method=Method.HILL,
        period=system.period,
        shape=shape,
        mean=alpha,
        panels=used,
        rows=rows,
        methods=np.full(n, Method.HILL, np.int8),
    )
    if not precise or panels:
        return phi
    kicked = None if q.kicks is None else np.any(q.kicks, axis=0)  # a jump of the damping is known in doubles only
    return make_precise(phi, system, kicked)


def _refined(
    rung: NDArray[np.int16], rows: Array, fixed: bool, solve: Callable[[NDArray[np.intp], NDArray[np.int64]], None]
) -> None:
    """Solve all points on the first steps of the ladder that resolve them: ``solve(points, panels a turn)``.

    ``rung`` (n,), or (pieces, n), is where each begins; all pieces of a point go up together.
    """
    pending, raised = np.arange(rung.shape[-1]), 0
    while pending.size:
        solve(pending, LADDER[np.minimum(rung[..., pending] + raised, len(LADDER) - 1)])
        pending = pending[rows[7, pending] > 0] if raised < RUNGS and not fixed else pending[:0]
        raised += 2


def _map_smooth(
    q: Pieces,
    size: Array,
    period: float,
    panels: int | None,
    rows: Array,
    used: NDArray[np.int32],
    *,
    compiled: bool | None,
    alike: int,
) -> None:
    """One trigonometric polynomial over the period: equal panels."""
    terms, angle = q.polynomials[0], period / q.turn

    def solve(points: NDArray[np.intp], ladder: NDArray[np.int64]) -> None:
        counts = np.full(len(points), panels) if panels else np.ceil(ladder * angle - 1e-9).astype(np.int64)
        map_equal_panels(terms, size, points, counts, period, angle, rows, compiled=compiled)
        used[points] = counts

    rung = _first_rung(terms, 2.0 * math.pi / q.turn)
    if alike > 1:
        rung = rung.reshape(-1, alike).max(axis=1).repeat(alike)
    _refined(rung, rows, bool(panels), solve)


def _first_rung(terms: Array, omega: float) -> NDArray[np.int16]:
    """Place on the ladder for q as terms (2H+1, n) in harmonics of frequency ω."""
    amplitudes = np.sqrt(terms[1::2] ** 2 + terms[2::2] ** 2)
    frequency = np.sqrt(np.abs(terms[0]) + amplitudes.sum(axis=0)) / omega
    wanted = COUNTABLE * frequency
    if len(amplitudes):
        series = np.zeros(terms.shape[1])
        for n, a in enumerate(amplitudes, start=1):
            relative = np.sqrt(np.sqrt((4.0 / (n * omega) ** 2) * a))
            np.maximum(series, n * np.where(a > 0.0, HARMONIC + AMPLITUDE * relative, 0.0), out=series)
        wanted = np.maximum(wanted, FREQUENCY * frequency + series)
    return PLACES[np.ceil(np.minimum(wanted, len(PLACES) - 1)).astype(np.int64)]


def _map_pieces(
    q: Pieces, size: Array, panels: int | None, rows: Array, used: NDArray[np.int32], *, compiled: bool | None
) -> None:
    """A polynomial a piece: equal panels on each, as many as that piece needs."""
    lengths, period = q.lengths, q.edges[-1]

    def solve(points: NDArray[np.intp], ladder: NDArray[np.int64]) -> None:
        wanted = lengths[:, points] * (panels / period[points] if panels else ladder / q.turn)
        counts = np.maximum(np.ceil(wanted - 1e-9), wanted > 0.0).astype(np.int64)
        map_pieces(q, size, points, counts, rows, compiled=compiled)
        used[points] = counts.sum(axis=0)

    rungs = [_first_rung(p, 2.0 * math.pi / q.turn) for p in q.polynomials]
    _refined(np.stack([rungs[place] for place in q.places]), rows, bool(panels), solve)
