"""Maps of linear systems over their panels by Taylor series about the panels' centres, sixteen cases at a time.

On a piece ``x' = A(ψ) x`` with ``A = A₀ + Σ_m C_m cos ω_mψ + S_m sin ω_mψ``, n ≥ 2 states.  Let Y(t) be the solution
with Y = I at the panel's centre ψ = c, t = ψ - c, and C, S the coefficients turned to it.  With cos ω_m t and
sin ω_m t = Σ α_i t^i the Taylor coefficients of Y follow one from the other, and the panel's map from their sums::

    (k+1) Y_{k+1} = A₀ Y_k + Σ_m C_m (Σ_{i even} α_i Y_{k-i}) + S_m (Σ_{i odd} α_i Y_{k-i})
    F = Y(h) Y(-h)⁻¹

Only entries of A that are not zero in every case are multiplied.  That makes use of whatever structure there is: of
``q' = q'`` in second-order systems, of harmonics that couple few coordinates.  A case whose entry is zero adds zero, so
that its bits do not depend on the entries of its neighbours.

The error of F has three parts.  The last two terms of the series, τ, bound what is left out.  Sums are rounded, by an
eps of their largest terms, which cancel in one of Y(h) and Y(-h) at most.  The inverse leaves a residual, ρ::

    |δF| ≤ [(|τ| + (1 + 2/n) eps max(|Y(h)|, |Y(-h)|)) (1 + |F|) + |ρ|] |Y(-h)⁻¹|,    ρ = F Y(-h) - Y(h)

A norm is √(largest sum of a row · largest sum of a column), which no 2-norm exceeds, by less the smaller n is.  In
20 000 panels of systems of 2 to 12 states true errors reach two thirds of the bound.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiler import inlined, kernel
from .lanes import WIDTH, as_lanes, scratch, spread, where

__all__ = ["map_panels", "multiplied", "norm", "probe", "square"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
AHEAD = 4  # zeros before the first coefficient, which loops over earlier ones may read


def _turned(values: Any, harmonic: Any, turn: Any, out: Any) -> None:
    """Coefficients about a panel's centre."""
    for s in range(len(harmonic)):
        m = harmonic[s]
        if m == 0:
            out[s] = values[s]
        elif m > 0:
            cosine, sine = turn[m - 1, 0], turn[m - 1, 1]
            out[s] = cosine * values[s] + sine * values[s + 1]
            out[s + 1] = cosine * values[s + 1] - sine * values[s]


def _waves(Y: Any, k: int, column: Any, alpha: Any, out: Any) -> None:
    """Coefficients k of cos ω_m t and sin ω_m t times the rows of Y that they multiply; four of the sums at a time."""
    for r in range(len(column)):
        y, j = Y[column[r]], k + AHEAD
        a0, a1, b0, b1 = y[j, 0], y[j, 1], spread(0.0), spread(0.0)
        for i in range(1, k + 1, 4):
            v, w = spread(alpha[r, i]), spread(alpha[r, i + 1])
            b0 += v * y[j - 1, 0]
            b1 += v * y[j - 1, 1]
            a0 += w * y[j - 2, 0]
            a1 += w * y[j - 2, 1]
            v, w = spread(alpha[r, i + 2]), spread(alpha[r, i + 3])
            b0 += v * y[j - 3, 0]
            b1 += v * y[j - 3, 1]
            a0 += w * y[j - 4, 0]
            a1 += w * y[j - 4, 1]
            j -= 4
        out[2 * r, 0], out[2 * r, 1], out[2 * r + 1, 0], out[2 * r + 1, 1] = a0, a1, b0, b1


def _next(Y: Any, k: int, waves: Any, a: Any, rows: Any, sources: Any) -> None:
    """Y_{k+1} from Y_k: row i adds the terms rows[i, 0] … rows[i, 1] of Y_k, then those to rows[i, 2] of the waves."""
    part, k = spread(1.0 / (k + 1)), k + AHEAD
    for i in range(len(rows)):
        x0, x1, y0, y1 = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
        for s in range(rows[i, 0], rows[i, 1]):
            v, j = a[s], sources[s]
            x0 += v * Y[j, k, 0]
            x1 += v * Y[j, k, 1]
        for s in range(rows[i, 1], rows[i, 2], 2):
            v, w, j = a[s], a[s + 1], sources[s]
            x0 += v * waves[j, 0]
            x1 += v * waves[j, 1]
            y0 += w * waves[j + 1, 0]
            y1 += w * waves[j + 1, 1]
        Y[i, k + 1, 0], Y[i, k + 1, 1] = part * (x0 + y0), part * (x1 + y1)


def _summed(Y: Any, order: int, power: Any, first: int, plus: Any, minus: Any, last: Any) -> None:
    """Two columns of Y(h) and Y(-h), and of the size of the last two terms."""
    for i in range(len(Y)):
        y = Y[i]
        a0, a1, b0, b1 = y[AHEAD, 0], y[AHEAD, 1], spread(0.0), spread(0.0)
        for k in range(order, 0, -2):
            v, w = power[k - 1], power[k]
            b0 += v * y[AHEAD + k - 1, 0]
            b1 += v * y[AHEAD + k - 1, 1]
            a0 += w * y[AHEAD + k, 0]
            a1 += w * y[AHEAD + k, 1]
        plus[i, first], minus[i, first] = a0 + b0, a0 - b0
        plus[i, first + 1], minus[i, first + 1] = a1 + b1, a1 - b1
        v, w = power[order - 1], power[order]
        for c in range(2):
            last[i, first + c] = abs(v * y[AHEAD + order - 1, c]) + abs(w * y[AHEAD + order, c])


def _series(Y: Any, waves: Any, a: Any, rows: Any, sources: Any, column: Any, alpha: Any) -> None:
    """All coefficients from the first one."""
    for i in range(len(rows)):
        for k in range(AHEAD):
            for c in range(2):
                Y[i, k, c] = spread(0.0)
    for k in range(alpha.shape[1] - AHEAD):
        waves_of(Y, k, column, alpha, waves)
        next_order(Y, k, waves, a, rows, sources)


def _inverted(a: Any, n: int) -> None:
    """a⁻¹ in its place by Gauss and Jordan, without pivots: Y(-h) of a short panel is near the identity."""
    for p in range(n):
        d = 1.0 / a[p, p]
        a[p, p] = spread(1.0)
        for j in range(n):
            a[p, j] *= d
        for i in range(n):
            if i != p:
                f = a[i, p]
                a[i, p] = spread(0.0)
                for j in range(n):
                    a[i, j] -= f * a[p, j]


def _multiplied(x: Any, y: Any, n: int, out: Any) -> None:
    """out = x y, two columns at a time."""
    for i in range(n):
        for block in range((n + 1) // 2):
            c = min(2 * block, n - 2)
            a0, a1 = spread(0.0), spread(0.0)
            for j in range(n):
                v = x[i, j]
                a0 += v * y[j, c]
                a1 += v * y[j, c + 1]
            out[i, c], out[i, c + 1] = a0, a1


def _norm(a: Any, n: int, room: Any) -> Any:
    """√(largest sum of a row · largest sum of a column)."""
    of_rows, of_columns = spread(0.0), spread(0.0)
    for c in range(n):
        room[c] = spread(0.0)
    for i in range(n):
        total = spread(0.0)
        for c in range(n):
            size = abs(a[i, c])
            total += size
            room[c] += size
        of_rows = where(total > of_rows, total, of_rows)
    for c in range(n):
        of_columns = where(room[c] > of_columns, room[c], of_columns)
    return math.sqrt(of_rows * of_columns)


turned: Any = inlined(_turned)
waves_of: Any = inlined(_waves)
next_order: Any = inlined(_next)
summed: Any = inlined(_summed)
series: Any = inlined(_series)
inverted: Any = inlined(_inverted)
multiplied: Any = inlined(_multiplied)
norm: Any = inlined(_norm)


def _square(n: int) -> Any:
    """Room for a matrix, doubles (n, n, 16)."""
    return scratch(n * n).reshape(n, n, WIDTH)


square: Any = inlined(_square)


def _map_panels(
    values: Array,
    harmonic: NDArray[np.intp],
    rows: NDArray[np.intp],
    sources: NDArray[np.intp],
    column: NDArray[np.intp],
    alpha: Array,
    turns: Array,
    half: Array,
    piece: NDArray[np.intp],
    maps: Array,
    errors: Array,
    truncations: Array,
) -> None:
    """Maps of all panels with bounds of their errors, and the part of these that more panels would reduce.

    Parameters
    ----------
    values : (blocks, pieces, terms, 16)
        The entries of A, row by row; of each row first the constant ones, then C and S of every other in turn.
    harmonic : (terms,)
        0 for a constant entry, m for C_m, -m for S_m.
    rows : (n, 3)
        Where a row's terms begin, where C and S do, and where they end.
    sources : (terms,)
        The row of Y that a constant entry multiplies; for C the wave, and the next one for S.
    column : (waves / 2,)
        The row of Y that is multiplied by a cosine, wave 2r, and its sine, wave 2r+1.
    alpha : (waves / 2, order + 4)
        Taylor coefficients α of the cosine and the sine in turn; the order is even.  What is beyond it does not matter.
    turns : (blocks or 1, panels, M, 2, 16)
        cos and sin of ω_m c.
    half : (blocks or 1, panels, 16)
        h.
    piece : (panels,)
        The piece of values that holds on a panel.
    maps, errors, truncations : (blocks, panels, n, n, 16), (blocks, panels, 16), (blocks, panels, 16)
        What is written.
    """
    A, turn, h, maps_, errors_ = as_lanes(values), as_lanes(turns), as_lanes(half), as_lanes(maps), as_lanes(errors)
    truncations_ = as_lanes(truncations)
    n, order, shared = len(rows), alpha.shape[1] - AHEAD, len(turns) == 1
    a, power, room = as_lanes(scratch(len(harmonic))), as_lanes(scratch(order + 1)), as_lanes(scratch(n))
    Y = as_lanes(scratch(n * (order + 1 + AHEAD) * 2).reshape(n, order + 1 + AHEAD, 2, WIDTH))
    waves = as_lanes(scratch(2 * len(column) * 2).reshape(2 * len(column), 2, WIDTH))
    plus, minus, last = as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n))
    inverse, F = as_lanes(square(n)), as_lanes(square(n))
    for b in range(len(values)):
        own = 0 if shared else b
        for p in range(len(piece)):
            turned(A[b, piece[p]], harmonic, turn[own, p], a)
            power[0] = spread(1.0)
            for k in range(order):
                power[k + 1] = h[own, p] * power[k]
            for block in range((n + 1) // 2):
                first = min(2 * block, n - 2)
                for i in range(n):
                    for c in range(2):
                        Y[i, AHEAD, c] = spread(1.0 if i == first + c else 0.0)
                series(Y, waves, a, rows, sources, column, alpha)
                summed(Y, order, power, first, plus, minus, last)
            for i in range(n):
                for c in range(n):
                    inverse[i, c] = minus[i, c]
            inverted(inverse, n)
            multiplied(plus, inverse, n, F)
            stretch, back = norm(F, n, room), norm(inverse, n, room)
            multiplied(F, minus, n, inverse)
            for i in range(n):
                for c in range(n):
                    inverse[i, c] -= plus[i, c]
                    maps_[b, p, i, c] = F[i, c]
            truncation = norm(last, n, room) * (1.0 + stretch) * back
            ahead, behind = norm(plus, n, room), norm(minus, n, room)
            rounding = (1.0 + 2.0 / n) * EPS * where(ahead > behind, ahead, behind) * (1.0 + stretch)
            errors_[b, p] = truncation + (rounding + norm(inverse, n, room)) * back
            truncations_[b, p] = truncation


map_panels = kernel(_map_panels)


def _probe(
    values: Array,
    harmonic: NDArray[np.intp],
    rows: NDArray[np.intp],
    sources: NDArray[np.intp],
    column: NDArray[np.intp],
    alpha: Array,
    turns: Array,
    piece: NDArray[np.intp],
    start: Array,
    sizes: Array,
) -> None:
    """Sizes of the last two coefficients of two solutions at some places, which tell how long a panel may be.

    Parameters
    ----------
    values … alpha, turns, piece
        As for :func:`map_panels`, places instead of panels.
    start : (n, 2)
        Two states.
    sizes : (blocks, places, 2, 16)
        What is written: the largest sums |Y_k| of a column, k = order-1 and order.
    """
    A, turn, out = as_lanes(values), as_lanes(turns), as_lanes(sizes)
    n, order = len(rows), alpha.shape[1] - AHEAD
    a = as_lanes(scratch(len(harmonic)))
    Y = as_lanes(scratch(n * (order + 1 + AHEAD) * 2).reshape(n, order + 1 + AHEAD, 2, WIDTH))
    waves = as_lanes(scratch(2 * len(column) * 2).reshape(2 * len(column), 2, WIDTH))
    for b in range(len(values)):
        for p in range(len(piece)):
            turned(A[b, piece[p]], harmonic, turn[0 if len(turns) == 1 else b, p], a)
            for i in range(n):
                Y[i, AHEAD, 0], Y[i, AHEAD, 1] = spread(start[i, 0]), spread(start[i, 1])
            series(Y, waves, a, rows, sources, column, alpha)
            for k in range(2):
                x, y = spread(0.0), spread(0.0)
                for i in range(n):
                    x += abs(Y[i, AHEAD + order - 1 + k, 0])
                    y += abs(Y[i, AHEAD + order - 1 + k, 1])
                out[b, p, k] = where(x > y, x, y)


probe = kernel(_probe)
