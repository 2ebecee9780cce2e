"""Eigenvalues of products of real matrices with bounds, sixteen products at a time.

The arithmetic of :mod:`floquet.exponents.products`, where it is explained: B = E·F_K…F_1 is multiplied out and
decomposed, and errors of the factors are followed to the eigenvalues by the vectors F_k…F_1 x_j and y_i E F_K…F_k.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiler import inlined, kernel
from .eigen import hessenberg, lengths, pairs, rotate, row_lengths, triangle, vectors
from .factors import multiplied, norm, square
from .lanes import WIDTH, as_lanes, scratch, spread, where

__all__ = ["multipliers"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)


def _weighted(a: Any, n: int, weight: Any, out: Any) -> None:
    """out = weight·a."""
    for i in range(n):
        for j in range(n):
            out[i, j] = weight * a[i, j]


def _scaled(a: Any, n: int, sizes: Array, exponent: Array) -> Any:
    """The power of two that brings the largest entry of a between ½ and 1; what it divides by is added to exponent."""
    largest, factor = spread(0.0), as_lanes(sizes)
    for i in range(n):
        for j in range(n):
            largest = where(abs(a[i, j]) > largest, abs(a[i, j]), largest)
    factor[0] = largest
    for lane in range(WIDTH):
        power = math.frexp(sizes[0, lane])[1] if 0.0 < sizes[0, lane] < math.inf else 0
        sizes[0, lane] = math.ldexp(1.0, -power)
        exponent[lane] += power
    return factor[0]


def _multiplied_out(F: Any, n: int, noise: float, room: Any, factor: Any, rounding: Any, exponent: Array) -> None:
    """room[0] = F_K…F_1 over 2**exponent; factor[k], a power of two, and rounding[k], an error, of each step."""
    now, other, x, sizes = room
    exponent[:] = 0.0
    for k in range(len(F)):
        if k == 0:
            rounding[k] = spread(0.0)
            weighted(F[k], n, spread(1.0), other)
        else:
            rounding[k] = noise * norm(F[k], n, x) * norm(now, n, x)
            multiplied(F[k], now, n, other)
        factor[k] = scaled(other, n, sizes, exponent)
        weighted(other, n, factor[k], now)


def _decomposed(B: Any, n: int, re: Any, im: Any, room: Any, X: Any, Y: Any) -> Any:
    """Eigenvalues and vectors of B; the lanes in which B is finite and they were found are returned."""
    H, Q, U, turn, x, y, size, work, state = room
    total = spread(0.0)
    for i in range(n):
        for j in range(n):
            total += B[i, j] * B[i, j]
    finite = total - total == 0.0
    floor = where(finite, EPS * math.sqrt(total), 0.0)
    for i in range(n):
        for j in range(n):
            H[i, j], U[i, j], Q[i, j] = where(finite, B[i, j], 0.0), spread(0.0), spread(1.0 if i == j else 0.0)
        H[i, n], H[n, i], Q[i, n] = spread(0.0), spread(0.0), spread(0.0)
    H[n, n] = spread(0.0)
    hessenberg(H, Q, n, x)
    failed = triangle(H, Q, n, state, floor)
    pairs(H, n, re, im)
    rotate(H, U, n, re, im, turn)
    vectors(H, U, Q, n, re, im, floor, (turn, x, y, size, work), X, Y)
    return finite & ~failed


def _residuals(B: Any, X: Any, n: int, re: Any, im: Any, work: Any, out: Any) -> None:
    """|B x_j - λ_j x_j|."""
    multiplied(B, X, n, work)
    for i in range(n):
        other = spread(0.0)
        for j in range(n):
            if i > 0:
                other = where(im[i] < 0.0, X[j, i - 1], 0.0)
            if i < n - 1:
                other = where(im[i] > 0.0, X[j, i + 1], other)
            work[j, i] += im[i] * other - re[i] * X[j, i]
    lengths(work, n, im, out)


def _followed(F: Any, e: Any, n: int, im: Any, factor: Any, rounding: Any, room: Any, G: Any) -> None:
    """Add to G what errors e of the factors and the rounding of the product do; room[0] is X, room[1] is Y E."""
    forward, backward, other, ahead, x = room
    for k in range(len(F)):
        lengths(forward, n, im, ahead[k])
        if k < len(F) - 1:
            multiplied(F[k], forward, n, other)
            weighted(other, n, factor[k], forward)
    for k in range(len(F) - 1, -1, -1):
        row_lengths(backward, n, im, x)
        for i in range(n):
            for j in range(n):
                G[i, j] += factor[k] * x[i] * (e[k] * ahead[k, j] + rounding[k])
        if k > 0:
            multiplied(backward, F[k], n, other)
            weighted(other, n, factor[k], backward)


def _discs(G: Any, n: int, re: Any, im: Any, share: float, rows: Any, out: Any) -> None:
    """(1 + share) G_ii where the disc of that radius meets no other one, else inf."""
    for i in range(n):
        rows[i] = spread(0.0)
        for j in range(n):
            rows[i] += G[i, j]
    for i in range(n):
        own = (1.0 + share) * G[i, i]
        stretch = (rows[i] - G[i, i]) / (share * G[i, i])
        stretch = where(stretch > 1.0, stretch, 1.0)
        clear = own < math.inf
        for j in range(n):
            if j != i:
                x, y, reach = re[i] - re[j], im[i] - im[j], own + rows[j] + stretch * G[j, i]
                clear = clear & (x * x + y * y > reach * reach)
        out[i] = where(clear, own, math.inf)


weighted: Any = inlined(_weighted)
scaled: Any = inlined(_scaled)
multiplied_out: Any = inlined(_multiplied_out)
decomposed: Any = inlined(_decomposed)
residuals: Any = inlined(_residuals)
followed: Any = inlined(_followed)
discs: Any = inlined(_discs)


def _multipliers(
    maps: Array,
    errors: Array,
    twist: Array,
    noise: float,
    share: float,
    values: Array,
    radius: Array,
    exponents: Array,
) -> None:
    """Eigenvalues of E·F_K…F_1 for blocks of sixteen cases of n ≥ 2 states.

    Parameters
    ----------
    maps, errors : (blocks, K, n, n, 16), (blocks, K, 16)
        F_k and bounds of the 2-norms of their errors.
    twist : (n,)
        The diagonal of E, ±1.
    noise : float
        Of |X| |Y|, which the rounding of X Y stays below.
    share : float
        Of G_ii, for what the other entries of a row add to the bound.
    values, exponents : (blocks, 16, n, 2), (blocks, 16)
        What is written: real and imaginary parts of the eigenvalues over 2**exponents, conjugate pairs side by side,
        the one with Im > 0 first; nan where a matrix is not finite or was given up.
    radius : (blocks, 16, n)
        Written as well: bounds on the scale of the values, inf where an eigenvalue is not clear of the others.
    """
    F, e = as_lanes(maps), as_lanes(errors)
    panels, n = F.shape[1], F.shape[2]
    H = as_lanes(scratch((n + 1) * (n + 1)).reshape(n + 1, n + 1, WIDTH))
    Q = as_lanes(scratch(n * (n + 1)).reshape(n, n + 1, WIDTH))
    B, X, Y, G = as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n))
    U, now, other, work = as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n))
    x, y, size, state = as_lanes(scratch(n)), as_lanes(scratch(n)), as_lanes(scratch(n)), as_lanes(scratch(5))
    turn, results, sizes = as_lanes(scratch(3 * n).reshape(3, n, WIDTH)), scratch(3 * n), scratch(1)
    re, im, bound = as_lanes(results[:n]), as_lanes(results[n : 2 * n]), as_lanes(results[2 * n :])
    factor, rounding = as_lanes(scratch(panels)), as_lanes(scratch(panels))
    ahead = as_lanes(scratch(panels * n).reshape(panels, n, WIDTH))
    for b in range(len(maps)):
        multiplied_out(F[b], n, noise, (now, other, x, sizes), factor, rounding, exponents[b])
        for i in range(n):
            for j in range(n):
                B[i, j] = twist[i] * now[i, j]
        good = decomposed(B, n, re, im, (H, Q, U, turn, x, y, size, work, state), X, Y)
        residuals(B, X, n, re, im, work, size)
        row_lengths(Y, n, im, x)
        more = noise * norm(B, n, y)
        for i in range(n):
            for j in range(n):
                G[i, j] = x[i] * (size[j] + more)
                now[i, j], work[i, j] = X[i, j], Y[i, j] * twist[j]
        followed(F[b], e[b], n, im, factor, rounding, (now, work, other, ahead, x), G)
        discs(G, n, re, im, share, size, bound)
        for i in range(n):
            re[i], bound[i] = where(good, re[i], math.nan), where(good, bound[i], math.inf)
        for lane in range(WIDTH):
            for i in range(n):
                values[b, lane, i, 0], values[b, lane, i, 1] = results[i, lane], results[n + i, lane]
                radius[b, lane, i] = results[2 * n + i, lane]


multipliers = kernel(_multipliers)
