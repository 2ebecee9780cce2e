"""Maps of panels by Taylor series, for trigonometric coefficients: what :mod:`floquet.kernels.factors` takes.

Only entries of A that are not zero in every case are passed on.  How many panels a case needs is told by the series of
two solutions from the middle of each piece: a panel may end where their last terms are small.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from .collocated import balance, common_pieces

__all__ = ["Series"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

ORDER = 22  # even; with more, fewer panels cost as much, and their rounding is more
AHEAD = 4  # more columns of α, which do not matter
SMALL = 3e-17  # last terms of a half panel, beside the start: nearly every case is resolved at once
ENOUGH = 0.5  # truncation beside the allowance for rounding
MARGIN = 1.02  # more panels than the excess of truncation asks for
AT_ONCE = 4096  # cases whose coefficients are packed together: they stay in a cache


class Pattern(NamedTuple):
    """Where A is not zero, as the kernel takes it, and the frequencies ω_m."""

    harmonic: Index
    rows: Index
    sources: Index
    column: Index
    alpha: Array
    omega: Array


class Origin(NamedTuple):
    """Where terms come from: their places, and the row and entry (r, i, j) of a part's coefficients."""

    places: Index
    row: Index
    i: Index
    j: Index


class Layout(NamedTuple):
    """The pattern of a system, the origin of its terms by part, the row and the column of A of each, and q' = q'."""

    pattern: Pattern
    origins: tuple[Origin, ...]
    row: Index
    column: Index
    identity: Index


class Series:
    """Panels of a system by series."""

    def __init__(self, system: PeriodicSystem) -> None:
        system, shape = common_pieces(system), system.cases
        parts = [p for p in (system.stiffness, system.damping, system.matrix) if p is not None]
        self.period, self.states = system.period, system.states
        self.layout = _layout(ORDER, system.degrees, system.second_order, tuple(_outline(part) for part in parts))
        self.values = _values(self.layout, parts, shape)
        if system.second_order:
            _rescale(self.layout, self.values)
        self.edges = np.array([[0.0, self.period]])
        if parts[0].edges is not None:
            edges = np.minimum(parts[0].edges, self.period)
            self.edges = np.broadcast_to(edges, (*shape, edges.shape[-1])).reshape(-1, edges.shape[-1])
        self.lengths = np.diff(self.edges, axis=-1)
        self.trace = _trace(parts[-1], shape) * (-1.0 if system.second_order else 1.0)
        with np.errstate(divide="ignore"):  # what has no reach in doubles is hopeless
            self.wanted = 0.5 * self.period / self._reach()

    def maps(self, cases: Index, counts: list[int]) -> tuple[Array, Array, Array]:
        """Of ``cases``, in lanes; see :class:`.factors.Solver`."""
        from ..kernels.factors import map_panels  # loads numba
        from ..kernels.lanes import WIDTH, aligned

        values, edges = self._packed(cases)
        blocks, panels, n, p = len(values), sum(counts), self.states, self.layout.pattern
        half = np.repeat(np.diff(edges, axis=-1) / (2 * np.asarray(counts)), counts, axis=-1)
        place = np.concatenate([np.arange(1, 2 * count, 2) for count in counts])
        turns = _turns(np.repeat(edges[..., :-1], counts, axis=-1) + place * half, p.omega)
        half = np.ascontiguousarray(np.swapaxes(half, 1, 2))
        maps, errors = aligned((blocks, panels, n, n, WIDTH)), aligned((blocks, panels, WIDTH))
        truncations, piece = aligned(errors.shape), np.repeat(np.arange(len(counts)), counts)
        map_panels(values, *p[:-1], turns, half, piece, maps, errors, truncations)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # what has overflowed is not resolved
            excess = np.max(truncations / (ENOUGH * (errors - truncations)), axis=1).reshape(-1)[: len(cases)]
            times = np.where(excess <= 1.0, 1.0, MARGIN * excess ** (1.0 / (ORDER - 1)))
        return maps, errors, times

    def _packed(self, cases: Index) -> tuple[Array, Array]:
        """Coefficients (blocks, pieces, terms, lanes) and edges (blocks or 1, lanes, pieces+1) of some cases."""
        from ..kernels.lanes import WIDTH, aligned

        blocks, (pieces, terms, _) = -(-len(cases) // WIDTH), self.values.shape
        padded = cases[np.minimum(np.arange(blocks * WIDTH), len(cases) - 1)]
        values = aligned((blocks, pieces, terms, WIDTH))
        values[...] = np.moveaxis(self.values[..., padded].reshape(pieces, terms, blocks, WIDTH), 2, 0)
        edges = self.edges[padded] if len(self.edges) > 1 else np.repeat(self.edges, WIDTH, axis=0)
        return values, edges.reshape(-1, WIDTH, pieces + 1)

    def _reach(self) -> Array:
        """Half a panel's length, (cases,)."""
        from ..kernels.factors import probe
        from ..kernels.lanes import aligned

        cases, pieces = self.values.shape[-1], len(self.values)
        start = np.cos(1.0 + np.arange(2.0 * self.states)).reshape(-1, 2)  # states of no symmetry
        out = np.empty(cases)
        for some in np.split(np.arange(cases), range(AT_ONCE, cases, AT_ONCE)):
            values, edges = self._packed(some)
            turns = _turns(edges[..., :-1] + 0.5 * np.diff(edges, axis=-1), self.layout.pattern.omega)
            sizes = aligned((len(values), pieces, 2, values.shape[-1]))
            probe(values, *self.layout.pattern[:-1], turns, np.arange(pieces), start, sizes)
            size = np.moveaxis(sizes, -1, 1).reshape(-1, pieces, 2)[: len(some)]
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = (SMALL * np.abs(start).sum(axis=0).max() / size) ** (1.0 / np.array([ORDER - 1, ORDER]))
            out[some] = np.fmin.reduce(np.fmin.reduce(reach, axis=-1), axis=-1)
        return out


def _turns(centre: Array, omega: Array) -> Array:
    """cos and sin of ω c, (blocks or 1, panels, M, 2, lanes), of centres (blocks or 1, lanes, panels)."""
    angle = np.swapaxes(centre, 1, 2)[:, :, None, :] * omega[:, None]
    return np.ascontiguousarray(np.stack([np.cos(angle), np.sin(angle)], axis=3))


Outline = tuple[float, tuple[int, ...], bytes]


def _outline(part: PeriodicMatrix) -> Outline:
    """Period, shape (2H+1, n, m) and the entries of a part that are not zero in every case."""
    c = part.coefficients
    return part.period, c.shape[-3:], (c != 0.0).any(axis=tuple(range(c.ndim - 3))).tobytes()


@lru_cache(maxsize=64)
def _layout(order: int, degrees: int, second_order: bool, outlines: tuple[Outline, ...]) -> Layout:
    """The terms of A: row by row, first the constant ones by column, then harmonics by frequency and column."""
    corners = [(degrees, 0), (degrees, degrees)] if second_order else [(0, 0)]
    states = 2 * degrees if second_order else degrees
    entries = [(i, 0.0, degrees + i, -1, 0, 0, 0) for i in range(degrees)] if second_order else []
    for part, ((period, shape, mask), (top, left)) in enumerate(zip(outlines, corners, strict=True)):
        filled = np.frombuffer(mask, bool).reshape(shape)
        for h in range((shape[0] + 1) // 2):
            either, omega = filled[max(2 * h - 1, 0) : 2 * h + 1].any(axis=0), h * (TWO_PI / period)
            entries += [(top + i, omega, left + j, part, h, i, j) for i, j in np.argwhere(either).tolist()]
    entries.sort()
    omegas = sorted({e[1] for e in entries} - {0.0})
    waves = sorted({(e[1], e[2]) for e in entries if e[1]})
    terms, rows = [], np.zeros((states, 3), np.intp)
    for row, omega, column, part, h, i, j in entries:  # harmonic, source, row, column, part, row of coefficients, i, j
        if omega:
            m, wave = omegas.index(omega) + 1, 2 * waves.index((omega, column))
            terms.append((m, wave, row, column, part, 2 * h - 1, i, j))
            terms.append((-m, wave + 1, row, column, part, 2 * h, i, j))
        else:
            terms.append((0, column, row, column, part, 0, i, j))
    table = np.array(terms, np.intp).reshape(-1, 8)
    for row in range(states):
        mine = table[:, 2] == row
        rows[row] = np.searchsorted(table[:, 2], row) + np.array([0, np.sum(mine & (table[:, 0] == 0)), np.sum(mine)])
    pattern = Pattern(
        harmonic=np.ascontiguousarray(table[:, 0]),
        rows=rows,
        sources=np.ascontiguousarray(table[:, 1]),
        column=np.array([column for _, column in waves], np.intp),
        alpha=_alpha(order, [omega for omega, _ in waves]),
        omega=np.array(omegas),
    )
    origins = []
    for part in range(len(outlines)):
        places = np.flatnonzero(table[:, 4] == part)
        origins.append(Origin(places, *table[places, 5:].T))
    return Layout(pattern, tuple(origins), table[:, 2], table[:, 3], np.flatnonzero(table[:, 4] == -1))


def _alpha(order: int, omegas: Sequence[float]) -> Array:
    """Taylor coefficients of cos ωt and sin ωt in turn, (waves, order + 1 and more)."""
    alpha = np.zeros((len(omegas), order + AHEAD))
    for row, omega in zip(alpha, omegas, strict=True):
        row[: order + 1] = [(1, 1, -1, -1)[k % 4] * omega**k / math.factorial(k) for k in range(order + 1)]
    return alpha


def _values(layout: Layout, parts: Sequence[PeriodicMatrix], shape: tuple[int, ...]) -> Array:
    """Coefficients of the terms, (pieces, terms, cases)."""
    pieces, sign = parts[0].coefficients.shape[-4], -1.0 if layout.identity.size else 1.0
    out = np.empty((pieces, len(layout.row), math.prod(shape)))
    out[:, layout.identity] = 1.0
    for part, origin in zip(parts, layout.origins, strict=True):
        c = np.moveaxis(part.coefficients, (-4, -3, -2, -1), (0, 1, 2, 3))
        c = c.reshape(*c.shape[:4], *[1] * (len(shape) + 4 - c.ndim), *c.shape[4:])
        chosen = sign * c[:, origin.row, origin.i, origin.j]
        whole = np.broadcast_to(chosen, (pieces, len(origin.row), *shape))
        out[:, origin.places] = whole.reshape(pieces, len(origin.row), math.prod(shape))
    return out


def _rescale(layout: Layout, values: Array) -> None:
    """From (q_i, q_i') to (q_i, q_i'/s_i)."""
    n, K = len(layout.identity), layout.origins[0]
    total = np.zeros((n, values.shape[-1]))
    for i in range(n):
        for place in K.places[K.i == i]:
            total[i] += np.abs(values[:, place]).max(axis=0)
    s = np.concatenate([np.ones(total.shape), balance(total)])
    values *= s[layout.column] / s[layout.row]


def _trace(part: PeriodicMatrix, shape: tuple[int, ...]) -> Array:
    """Mean of the trace, (cases,)."""
    mean = part.mean()
    total = mean[..., 0, 0]
    for i in range(1, part.shape[0]):
        total = total + mean[..., i, i]
    return np.broadcast_to(total, shape).reshape(-1)
