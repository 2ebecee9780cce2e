"""One scalar equation, mapped in its Hill form.

With β = exp(-½∫d) y the equation β'' + d β' + k β = 0 becomes::

    y'' + q y = 0,     q = k - d'/2 - d²/4,     det Φ = 1,    exponents = α ± ν,  α = -mean(d)/2

so that both exponents keep all their digits; where d jumps by Δ, y' jumps by ½Δ y.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..kernels import available, worth_compiling
from ..kernels.hill import ROWS, Panels, map_equal_panels, map_panels
from ..kernels.ladder import LADDER, first_rung
from ..periodic import PeriodicMatrix, PeriodicSystem
from .form import Smooth, hill_form, smooth_form, term_size
from .precise import make_precise
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
    rows, used = np.empty((len(ROWS), n)), np.empty(n, np.int32)
    kicks, fast = None, worth_compiling(n) if compiled is None else compiled and available()
    if (smooth := smooth_form(part) if fast else None) is None:
        q, alpha, kicks = hill_form(part)
        q, size, alpha = q.flat((n,)), np.broadcast_to(term_size(part), (n,)), np.broadcast_to(alpha, (n,))
        if q.edges is None:
            smooth = Smooth.of(q, size, alpha)
        else:
            _map_pieces(q, kicks, size, system.period, panels, rows, used)
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
    # a jump of the damping is known in doubles only
    return make_precise(phi, system) if precise and not panels and kicks is None else phi


def _refined(
    rung: NDArray[np.int16], rows: Array, fixed: bool, solve: Callable[[NDArray[np.intp], NDArray[np.int64]], None]
) -> None:
    """Solve all points on the first step of the ladder that resolves them: ``solve(points, panels a turn)``."""
    last, pending = rung + RUNGS, np.arange(len(rung))
    while pending.size:
        solve(pending, LADDER[np.minimum(rung[pending], len(LADDER) - 1)])
        if fixed:
            return
        pending = np.flatnonzero(rows[7] > 0)
        pending = pending[rung[pending] < last[pending]]
        rung[pending] += 2


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
    q: PeriodicMatrix,
    kicks: Array | None,
    size: Array,
    period: float,
    panels: int | None,
    rows: Array,
    used: NDArray[np.int32],
) -> None:
    """A polynomial a piece: equal panels on each, about as long as those of the others."""
    assert q.edges is not None
    omega = 2.0 * math.pi / q.period
    edges = np.broadcast_to(np.minimum(q.edges, period), (len(size), q.edges.shape[-1]))
    start, length = edges[:, :-1], np.diff(edges, axis=-1)
    kick = np.zeros(start.shape) if kicks is None else np.where(start < period, kicks, 0.0)
    terms = np.moveaxis(q.coefficients[..., 0, 0], -1, 0)  # (2H+1, n, pieces)

    def solve(points: NDArray[np.intp], ladder: NDArray[np.int64]) -> None:
        density = np.full(len(points), panels / period) if panels else ladder * (omega / (2.0 * math.pi))
        counts = np.maximum(np.ceil(density[:, None] * length[points] - 1e-9), 1).astype(np.int64)
        flat = counts.ravel()
        piece = np.repeat(np.arange(flat.size), flat)  # of each panel, all points' pieces in a row
        place = np.arange(len(piece)) - np.repeat(np.cumsum(flat) - flat, flat)
        half = ((length[points] / (2 * counts)).ravel())[piece]
        found = Panels(
            terms=terms[:, points].reshape(len(terms), -1)[:, piece],
            centre=start[points].ravel()[piece] + (2 * place + 1) * half,
            half=half,
            kick=np.where(place == 0, kick[points].ravel()[piece], 0.0),
            counts=counts.sum(axis=1),
            frequency=omega,
        )
        map_panels(found, size[points], 0.5 * period / found.counts, points, rows)
        used[points] = found.counts

    rung = np.max([first_rung(terms[:, :, j], omega) for j in range(terms.shape[2])], axis=0)
    _refined(rung, rows, bool(panels), solve)
