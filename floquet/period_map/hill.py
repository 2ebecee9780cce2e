"""One scalar equation, mapped in its Hill form.

With β = exp(-½∫d) y the equation β'' + d β' + k β = 0 becomes::

    y'' + q y = 0,     q = k - d'/2 - d²/4,     det Φ = 1,    exponents = α ± ν,  α = -mean(d)/2

so that both exponents keep all their digits; where d jumps by Δ, y' jumps by ½Δ y.

How many panels a point needs follows from its q alone: from the frequency √|q| and, for every harmonic n of amplitude
a_n, from the terms (nh)^k of its Taylor series.  The rule below was fitted to what 18 000 random blades and Mathieu
equations needed; points that need more go up the ladder.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..kernels.hill import ROWS, Panels, map_equal_panels, map_panels
from ..periodic import PeriodicMatrix, PeriodicSystem
from .precise import make_precise
from .result import Method, PeriodMap

__all__ = ["hill_form", "hill_map"]

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
    part = system.part(slice(None))
    q, alpha, kicks = hill_form(part)
    n = math.prod(shape)
    q = q.flat((n,))
    rows, used = np.empty((len(ROWS), n)), np.empty(n, np.int32)
    size = _size(part, n)
    if q.edges is None:
        _map_smooth(q, size, system.period, panels, rows, used, compiled=compiled, alike=alike)
    else:
        _map_pieces(q, kicks, size, system.period, panels, rows, used)
    phi = PeriodMap(
        method=Method.HILL,
        period=system.period,
        shape=shape,
        mean=np.broadcast_to(alpha, (n,)),
        panels=used,
        rows=rows,
        methods=np.full(n, Method.HILL, np.int8),
    )
    # a jump of the damping is known in doubles only
    return make_precise(phi, system) if precise and not panels and kicks is None else phi


def hill_form(system: PeriodicSystem) -> tuple[PeriodicMatrix, Array, Array | None]:
    """q, α and the kicks ½Δ at the edges (cases, pieces), None where d does not jump."""
    k, d = system.stiffness, system.damping
    assert k is not None
    if d is None:
        return k, np.zeros(k.cases), None
    if k.edges is not None:
        d = d + 0 * k  # on the pieces of q
    q = k - d.derivative() / 2 - (d @ d) / 4
    alpha = -0.5 * np.asarray(d.mean()[..., 0, 0], float)
    if q.edges is None:
        return q, alpha, None
    kicks = 0.5 * d.jumps()[..., 0, 0]
    kicks = np.where(np.abs(kicks) <= 1e-14 * (1.0 + d.bound()[..., 0, :]), 0.0, kicks)  # the rounding of equal values
    return q, alpha, kicks if np.any(kicks) else None


def _size(system: PeriodicSystem, n: int) -> Array:
    """Of the terms that q is made of: rounding of q is relative to it."""
    k, d = system.stiffness, system.damping
    assert k is not None
    size = k.magnitude()[..., 0, 0]
    if d is not None:
        damping = d.magnitude()[..., 0, 0]
        size = size + (0.5 + 0.25 * damping) * damping
    return np.broadcast_to(size, (n,))


def _refined(
    rung: NDArray[np.int16], rows: Array, fixed: bool, solve: Callable[[NDArray[np.intp], NDArray[np.int64]], None]
) -> None:
    """Solve all points on the first step of the ladder that resolves them: ``solve(points, panels a turn)``."""
    last, pending = rung + RUNGS, np.arange(len(rung))
    while pending.size:
        solve(pending, LADDER[np.minimum(rung[pending], len(LADDER) - 1)])
        pending = pending[(rows[7, pending] > 0) & (rung[pending] < last[pending])] if not fixed else pending[:0]
        rung[pending] += 2


def _map_smooth(
    q: PeriodicMatrix,
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
    terms = np.ascontiguousarray(q.coefficients[:, 0, :, 0, 0].T)
    angle = period / q.period

    def solve(points: NDArray[np.intp], ladder: NDArray[np.int64]) -> None:
        counts = np.full(len(points), panels) if panels else np.ceil(ladder * angle - 1e-9).astype(np.int64)
        map_equal_panels(terms, size, points, counts, period, angle, rows, compiled=compiled)
        used[points] = counts

    rung = _first_rung(terms, 2.0 * math.pi / q.period)
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

    rung = np.max([_first_rung(terms[:, :, j], omega) for j in range(terms.shape[2])], axis=0)
    _refined(rung, rows, bool(panels), solve)
