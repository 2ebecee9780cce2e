"""Smooth functions of one variable, for many cases at once, and every place where they pass a value.

A curve is interpolated in Chebyshev points on pieces of its range, halved until the last coefficients are down to
rounding.  With x = cos θ on a piece the polynomial is p = Σ c_k cos kθ, so that bounds of its derivatives are sums::

    |d²p/dθ²| ≤ Σ k² |c_k|,    |d²p/dx²| ≤ Σ k² (k² - 1) |c_k| / 3

A cell of θ has no root where |p - level| at its middle is more than p can change on the way to its ends, and one at
most where the derivative cannot change its sign.  Other cells are halved down to :data:`CLOSE`, where p touches the
level, or nearly: there the curve itself decides, by the parabola about its turning point.  So no root of the polynomial
is missed, however close to another, and one of the curve only if the curve passes the level by less than rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Crossings", "Curve", "crossings"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]
#: Values for cases (k,) at places (k,).
Curve = Callable[[Places, Array], Array]

EPS = float(np.finfo(float).eps)
NODES = (24, 40)  # of a piece, before it is halved
PROMISING = 1e-7  # last coefficients, relative to the largest, that the larger number of nodes brings down
DEPTH = 9  # halvings at most: a piece is then a five-hundredth of the range
PARTED = 6  # halvings at most of a piece that touches a level
CELLS = 24  # of a piece to begin with,
OFFSET = 0.38196601125010515  # of which no end is a place that a problem would choose
CLOSE = 1e-5  # in θ: half a cell where p may touch the level,
TOUCHING = 1e-11  # its turning point as far from it as p is rounded, relative to the largest coefficient
SMALLEST = 1e-11  # half a cell that is not cut again, whatever the slope
NOISE = 2e-14  # of p, relative to the largest coefficient: less is no distance from a level
SAME = 1e-12  # of the longest range: roots closer than this are one that was found twice
CROWD = 48  # cells left in a piece that say that the polynomial is none for its whole range
REACH = 2e-3  # in θ: the two passages about such a turning point are closer
STEP = 1e-6  # of the parabola, relative to the range: its cubic error is below rounding
AT_ONCE = 2048  # pieces
SECANTS = 60  # at most, from there to where the curve itself has it
NEWTON = 6  # steps from the middle of a cell in which the polynomial has one root
OUT = 1e-10  # of a piece: a root so far from its end is not in it
WELL = 1e-5  # slope, relative to the largest value, from which the curve itself is exact enough


@dataclass(frozen=True, eq=False, kw_only=True)
class Crossings:
    """Where curves pass a level: ``case`` (r,), ``x`` (r,), ``level`` (r,), in the order of the cases and of x."""

    case: Places
    x: Array
    level: Array

    def of(self, case: int) -> Array:
        """The places of one case."""
        return self.x[self.case == case]


def crossings(
    curve: Curve,
    start: Array,
    stop: Array,
    levels: Sequence[float] = (0.0,),
    *,
    case: Places | None = None,
    exact: Callable[[float], Curve] | None = None,
    least: float = 0.0,
    rounding: float = 2e-14,
) -> Crossings:
    """Every passage of curves through the levels within their ranges.

    Parameters
    ----------
    curve : callable
        A function of case and place, smooth on each range.
    start, stop : (n,)
        The ranges.
    levels : sequence of float
    case : (n,), optional
        Of the ranges; 0 … n-1 if left out.
    exact : callable, optional
        ``exact(level)`` is the curve less the level, with more digits, for places where the two touch or nearly.
    least : float
        Where a curve all but touches a level, two passages closer than this are none.
    rounding : float
        Of the values, relative to the largest of a piece: where its last coefficients are as small it is resolved.
    """
    case = np.arange(len(start)) if case is None else case
    found: list[tuple[Places, Array, Array]] = []
    waiting = [(case[i : i + AT_ONCE], start[i : i + AT_ONCE], stop[i : i + AT_ONCE], 0)
               for i in range(0, len(case), AT_ONCE)]  # fmt: skip
    while waiting:
        cases, a, b, depth = waiting.pop()
        for pieces in _interpolated(curve, cases, a, b, depth, rounding):
            cells = [_isolated(pieces, level) for level in levels]
            if depth < PARTED:  # on a shorter piece the polynomial has a smaller scale, and less rounding
                again = np.unique(np.concatenate([each.which[each.touching] for each in cells]))
                if len(again):
                    waiting.append((*pieces.halves(again), depth + 1))
                cells = [each.without(again) for each in cells]
            for level, each in zip(levels, cells, strict=True):
                for which, x in _roots(pieces, level, each, curve, exact, least):
                    found.append((pieces.case[which], x, np.full(len(x), level)))
    cases, places, reached = (np.concatenate([np.zeros(0, kind), *(f[i] for f in found)])
                              for i, kind in enumerate((np.intp, float, float)))  # fmt: skip
    order = np.lexsort((places, reached, cases))
    cases, places, reached = cases[order], places[order], reached[order]
    same = (cases[1:] == cases[:-1]) & (reached[1:] == reached[:-1])
    same &= places[1:] - places[:-1] <= max(SAME * np.max(stop - start, initial=0.0), 0.1 * least)
    cases, places, reached = (part[np.append(True, ~same)[: len(part)]] for part in (cases, places, reached))
    order = np.lexsort((places, cases))
    return Crossings(case=cases[order], x=places[order], level=reached[order])


# ---------------------------------------------------------------------- pieces
@dataclass(frozen=True, eq=False)
class _Pieces:
    """Polynomials Σ c_k cos kθ (pieces, m) on [a, b] of cases; θ = 0 at b."""

    case: Places
    a: Array
    b: Array
    c: Array

    def at(self, which: Places, theta: Array) -> tuple[Array, Array]:
        """Values and derivatives by θ of the polynomials ``which`` at ``theta``."""
        c, k = self.c[which], np.arange(self.c.shape[1])
        angle = theta[:, None] * k
        return (c * np.cos(angle)).sum(axis=1), -(c * k * np.sin(angle)).sum(axis=1)

    def halves(self, which: Places) -> tuple[Places, Array, Array]:
        """Cases and ends of two pieces for each of some."""
        a, b = self.a[which], self.b[which]
        middle = 0.5 * (a + b)
        return np.tile(self.case[which], 2), np.concatenate([a, middle]), np.concatenate([middle, b])

    def place(self, which: Places, theta: Array) -> Array:
        """x of θ."""
        a, b = self.a[which], self.b[which]
        return 0.5 * (a + b) + 0.5 * (b - a) * np.cos(theta)


def _interpolated(curve: Curve, case: Places, a: Array, b: Array, halved: int, rounding: float) -> Iterator[_Pieces]:
    """Polynomials of the curves, in groups of equal degree."""
    waiting = [(case, a, b, NODES[0], halved)]
    while waiting:
        case, a, b, m, depth = waiting.pop()
        x = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * np.cos(math.pi * np.arange(m) / (m - 1))
        x[:, 0], x[:, -1] = b, a  # the same for both pieces that meet there
        values = curve(np.repeat(case, m), x.ravel()).reshape(x.shape)
        known = np.all(np.isfinite(values), axis=1)  # a curve beyond the doubles passes no level
        c = (np.where(known[:, None], values, 0.0)[:, None, :] * _transform(m)).sum(axis=2)  # bits of a row are its own
        last, largest = np.abs(c[:, -3:]).max(axis=1), np.abs(c).max(axis=1)
        done = (last <= rounding * largest) | (depth >= DEPTH)
        more = ~done & known & (last <= PROMISING * largest) & (m < NODES[-1])
        cut = ~done & ~more | ~known & (depth < DEPTH)
        keep = done & known
        if keep.any():
            yield _Pieces(case[keep], a[keep], b[keep], c[keep])
        if more.any():
            waiting.append((case[more], a[more], b[more], NODES[-1], depth))
        if cut.any():
            middle = 0.5 * (a + b)[cut]
            ends = np.concatenate([a[cut], middle]), np.concatenate([middle, b[cut]])
            waiting.append((np.tile(case[cut], 2), *ends, NODES[0], depth + 1))


@cache
def _transform(m: int) -> Array:
    """Coefficients (m,) from values (m,) at cos(πj/(m-1))."""
    j = np.arange(m)
    matrix = (2.0 / (m - 1)) * np.cos(np.outer(j, math.pi * j / (m - 1)))
    matrix[:, [0, -1]] *= 0.5
    matrix[[0, -1]] *= 0.5
    return matrix


# ---------------------------------------------------------------------- roots
class _Cells(NamedTuple):
    """Pieces, ends in θ, and whether polynomial and level touch there; else there is one root."""

    which: Places
    low: Array
    high: Array
    touching: NDArray[np.bool_]

    def without(self, pieces: Places) -> _Cells:
        """The cells of other pieces."""
        kept = ~np.isin(self.which, pieces)
        return _Cells(self.which[kept], self.low[kept], self.high[kept], self.touching[kept])


def _roots(
    pieces: _Pieces, level: float, cells: _Cells, curve: Curve, exact: Callable[[float], Curve] | None, least: float
) -> Iterator[tuple[Places, Array]]:
    """Pieces and places of all passages through a level."""
    which, low, high, touching = cells
    beside = np.zeros(len(which), bool)  # passages that the parabola about a turning point gives as well
    for i in np.flatnonzero(touching):
        beside |= (which == which[i]) & (np.abs(low - low[i]) < REACH)
    one = ~touching & ~beside
    if one.any():
        x = _polished(pieces, level, which[one], low[one], high[one], curve, exact)
        yield which[one][np.isfinite(x)], x[np.isfinite(x)]
    if touching.any():
        sharp = exact(level) if exact else lambda case, x: curve(case, x) - level
        yield _parted(pieces, which[touching], 0.5 * (low + high)[touching], sharp, least)


def _isolated(pieces: _Pieces, level: float) -> _Cells:
    """Cells with one root each, and those where polynomial and level touch or nearly."""
    n, m = pieces.c.shape
    k, size = np.arange(m), np.abs(pieces.c)
    by_theta, by_x = ((size * weights).sum(axis=1) for weights in (k**2.0, k**2.0 * (k**2.0 - 1.0) / 3.0))
    ends = np.concatenate([[0.0], (np.arange(CELLS) + OFFSET) * (math.pi / CELLS), [math.pi]])
    which, low, high = np.repeat(np.arange(n), CELLS + 1), np.tile(ends[:-1], n), np.tile(ends[1:], n)
    found: list[tuple[Places, Array, Array, NDArray[np.bool_]]] = []
    noise = NOISE * size.max(axis=1)
    while len(which):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        value, slope = pieces.at(which, middle)
        value, slope = value - level, np.abs(slope)
        reach = np.maximum(np.cos(low) - np.cos(middle), np.cos(middle) - np.cos(high))
        by = np.sin(middle)
        empty = np.abs(value) > half * (slope + 0.5 * half * by_theta[which]) + noise[which]
        single = ~empty & ((slope > half * by_theta[which]) | (slope > by * reach * by_x[which]))
        if single.any():
            i = np.flatnonzero(single)
            values = [pieces.at(which[i], t)[0] - level for t in (low[i], high[i])]
            passed = (values[0] > 0.0) != (values[1] > 0.0)
            # at an end of the piece, where the root may be lost to rounding: no cell beyond it sees the other one
            before, after = (np.abs(value) < noise[which[i]] for value in values)
            doubtful = ~passed & (before & (low[i] == 0.0) | after & (high[i] == math.pi))
            i, doubtful = i[passed | doubtful], doubtful[passed | doubtful]
            found.append((which[i], low[i], high[i], doubtful))
        left = ~empty & ~single
        flat = slope**2 <= 2.0 * TOUCHING * size.max(axis=1)[which] * by_theta[which]
        close = left & (((half < CLOSE) & flat) | (half < SMALLEST))
        if close.any():
            found.append((which[close], low[close], high[close], np.ones(close.sum(), bool)))
        left &= ~close
        crowded = left & (np.bincount(which[left], minlength=n) > CROWD)[which]  # p is small for long: rounding
        if crowded.any():
            i = np.flatnonzero(crowded)[np.unique(which[crowded], return_index=True)[1]]
            found.append((which[i], low[i], high[i], np.ones(len(i), bool)))
        left &= ~crowded
        which, middle = np.repeat(which[left], 2), middle[left]
        low, high = (np.stack(pair, axis=1).ravel() for pair in ((low[left], middle), (middle, high[left])))
    parts = [np.concatenate([np.zeros(0, kind), *(f[i] for f in found)])
             for i, kind in enumerate((np.intp, float, float, bool))]  # fmt: skip
    return _Cells(*parts)


def _polished(
    pieces: _Pieces,
    level: float,
    which: Places,
    low: Array,
    high: Array,
    curve: Curve,
    exact: Callable[[float], Curve] | None,
) -> Array:
    """The only root of each cell: of the polynomial by Newton's method, then a step with the curve itself."""
    falls = pieces.at(which, low)[0] > level  # with θ
    theta = 0.5 * (low + high)
    for _ in range(NEWTON):
        value, slope = pieces.at(which, theta)
        above = value > level
        low, high = np.where(above == falls, theta, low), np.where(above == falls, high, theta)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = theta - (value - level) / slope
        theta = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
    a, b, case = pieces.a[which], pieces.b[which], pieces.case[which]
    x = pieces.place(which, theta)
    slope = pieces.at(which, theta)[1] / (-0.5 * (b - a) * np.sin(theta))
    gentle = np.abs(slope) * (b - a) < WELL * np.abs(pieces.c[which]).max(axis=1)
    for _ in range(2):
        moved = x - (curve(case, x) - level) / slope
        x = np.where(gentle, x, np.clip(moved, a, b))
    if gentle.any() and exact is not None:
        i = np.flatnonzero(gentle)
        x[i] = _by_secants(exact(level), case[i], x[i], slope[i], a[i], b[i])
    return x


def _by_secants(f: Curve, case: Places, x: Array, slope: Array, a: Array, b: Array) -> Array:
    """Roots of a curve that is known better than its polynomial, whose slope serves for the first step only; or nan.

    Towards two roots that are close to each other secants go by a factor of 1.6 until they are nearer than the two are.
    """
    x, value = x.copy(), f(case, x)
    left = np.arange(len(x))
    for _ in range(SECANTS):
        here, before = x[left], value[left]
        with np.errstate(divide="ignore", invalid="ignore"):
            there = np.clip(here - before / slope[left], a[left], b[left])
            there = np.where(np.isfinite(there), there, here)
            further = f(case[left], there)
            chord = (further - before) / (there - here)
        slope[left] = np.where(np.isfinite(chord) & (chord != 0.0), chord, slope[left])
        x[left], value[left] = there, further
        left = left[np.abs(there - here) > 2.0 * EPS * np.maximum(np.abs(there), (b - a)[left])]
        if not len(left):
            break
    with np.errstate(divide="ignore", invalid="ignore"):
        beyond = np.abs(value / slope) > OUT * (b - a)  # only held back by an end: the root is another piece's
    return np.where(((x == a) | (x == b)) & beyond, math.nan, x)


def _parted(pieces: _Pieces, which: Places, theta: Array, f: Curve, least: float) -> tuple[Places, Array]:
    """The two roots about each place where curve and level touch, if the curve passes the level there."""
    order = np.lexsort((theta, which))
    which, theta = which[order], theta[order]
    first = np.flatnonzero(np.concatenate([[True], (np.diff(which) > 0) | (np.diff(theta) > REACH)]))
    theta = np.add.reduceat(theta, first) / np.diff(np.append(first, len(theta)))
    which = which[first]
    case, a, b, x = pieces.case[which], pieces.a[which], pieces.b[which], pieces.place(which, theta)
    h = STEP * (b - a)
    for _ in range(3):  # at last about the turning point itself
        x = np.clip(x, a + h, b - h)
        before, there, after = (f(case, x + s * h) for s in (-1.0, 0.0, 1.0))
        slope, curvature = 0.5 * (after - before), after - 2.0 * there + before  # a step, and a step²
        with np.errstate(divide="ignore", invalid="ignore"):
            turning = -slope / curvature
            width = np.sqrt(np.maximum(turning**2 - 2.0 * there / curvature, 0.0)) * h
        x = x + np.where(np.abs(turning * h) < REACH * (b - a), turning, 0.0) * h
    some = (width > 0.5 * least) & (width < REACH * (b - a))
    ends = np.concatenate([x[some] - width[some], x[some] + width[some]])
    owner = np.tile(which[some], 2)
    inside = (ends >= pieces.a[owner]) & (ends <= pieces.b[owner])
    return owner[inside], ends[inside]
