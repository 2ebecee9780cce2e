"""One scalar equation, mapped in its Hill form.

How many panels a point needs follows from its q alone (:mod:`floquet.kernels.ladder`); points that need more go up.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..kernels import available, worth_compiling
from ..kernels.hill import ROWS, map_equal_panels
from ..kernels.ladder import LADDER, first_rung
from ..kernels.pieces import Pieces, map_pieces
from ..periodic import PeriodicSystem
from .form import hill_form
from .precise import make_precise
from .recorded import Smooth, smooth_form
from .result import Method, PeriodMap

__all__ = ["hill_map"]

Array = NDArray[np.float64]

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
    part = system.part(slice(None))
    n = math.prod(shape)
    rows, used, kicked = np.empty((len(ROWS), n)), np.empty(n, np.int32), None
    fast = worth_compiling(n) if compiled is None else compiled and available()
    if (smooth := smooth_form(part) if fast else None) is None:
        q, alpha, size = hill_form(part)
        if len(q.places) == 1 and len(q.polynomials[0]) <= 5 and q.kicks is None:
            smooth = Smooth.of(q.polynomials[0], q.turn, size, alpha)
        else:
            _map_pieces(q, size, panels, rows, used, compiled=fast)
            # a jump of the damping is known in doubles only
            kicked = None if q.kicks is None else np.any(q.kicks, axis=0)
    if smooth is not None:
        alpha = smooth.alpha
        _map_smooth(smooth, system.period, panels, rows, used, compiled=fast, alike=alike)
    phi = PeriodMap(
        method=Method.HILL,
        period=system.period,
        shape=shape,
        mean=alpha,
        panels=used,
        rows=rows,
        methods=np.full(n, Method.HILL, np.int8),
    )
    return phi if panels or not precise else make_precise(phi, system, kicked, compiled=fast)


def _refined(
    rung: NDArray[np.int16], rows: Array, fixed: bool, solve: Callable[[NDArray[np.intp], NDArray[np.int64]], None]
) -> None:
    """Solve all points on the first steps of the ladder that resolve them: ``solve(points, panels a turn)``.

    ``rung`` (n,), or (pieces, n), is where each begins; all pieces of a point go up together.
    """
    pending, raised = np.arange(rung.shape[-1]), 0
    while pending.size:
        solve(pending, LADDER[np.minimum(rung[..., pending] + raised, len(LADDER) - 1)])
        if fixed or raised == RUNGS:
            return
        pending = np.flatnonzero(rows[7] > 0)
        raised += 2


def _map_smooth(
    form: Smooth,
    period: float,
    panels: int | None,
    rows: Array,
    used: NDArray[np.int32],
    *,
    compiled: bool,
    alike: int,
) -> None:
    """One trigonometric polynomial over the period: equal panels."""
    angle = period / form.period

    def solve(points: NDArray[np.intp], ladder: NDArray[np.int64]) -> None:
        counts = np.full(len(points), panels) if panels else np.ceil(ladder * angle - 1e-9).astype(np.int64)
        map_equal_panels(form.terms, form.size, points, counts, period, angle, rows, compiled=compiled)
        used[points] = counts

    rung = form.rung
    if alike > 1:
        rung = rung.reshape(-1, alike).max(axis=1).repeat(alike)
    _refined(rung, rows, bool(panels), solve)


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

    rungs = [first_rung(p, 2.0 * math.pi / q.turn) for p in q.polynomials]
    _refined(np.stack([rungs[place] for place in q.places]), rows, bool(panels), solve)
