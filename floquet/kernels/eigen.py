"""Eigenvalues of many small real matrices and their condition numbers, sixteen matrices at a time.

Householder reflections make a matrix Hessenberg, QR steps with two shifts (J. G. F. Francis) make it triangular but for
2×2 blocks, each a pair of eigenvalues, and rotations make these triangular over the complex numbers.  Of that triangle T
the vectors x_i and y_i with T x_i = λ_i x_i and y_i T = λ_i y_i follow by substitution; with the i-th entry of both 1
the condition number of λ_i is::

    κ_i = |x_i| |y_i|,    an error δ of the matrix moves λ_i by κ_i |δ| to first order

Every lane works at a block of its own, rows ``low`` … ``high``; steps outside it are reflections with nothing in them,
so that nothing done to a lane depends on another one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiler import inlined, kernel
from .lanes import WIDTH, any_lane, as_lanes, scratch, spread, where

__all__ = ["eigenvalues"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
STEPS = 30  # QR steps an eigenvalue before a matrix is given up, as in EISPACK; two or three are usual
UNUSUAL = 10  # after so many steps without success, and twice as many, the shifts are others


def _hessenberg(H: Any, n: int, v: Any) -> None:
    """H becomes Hessenberg by reflections from both sides."""
    for k in range(n - 2):
        square = spread(0.0)
        for i in range(k + 1, n):
            v[i] = H[i, k]
            square += v[i] * v[i]
        first, size = v[k + 1], math.sqrt(square)
        new = where(first > 0.0, -1.0 * size, size)
        v[k + 1] = first - new
        half = square - first * new  # of |v|²
        weight = where(half > 0.0, 1.0 / half, 0.0)
        H[k + 1, k] = new
        for i in range(k + 2, n):
            H[i, k] = spread(0.0)
        for j in range(k + 1, n):
            total = spread(0.0)
            for i in range(k + 1, n):
                total += v[i] * H[i, j]
            total *= weight
            for i in range(k + 1, n):
                H[i, j] -= total * v[i]
        for i in range(n):
            total = spread(0.0)
            for j in range(k + 1, n):
                total += v[j] * H[i, j]
            total *= weight
            for j in range(k + 1, n):
                H[i, j] -= total * v[j]


def _cut(H: Any, n: int, floor: Any) -> None:
    """Entries below the diagonal that are nothing beside their neighbours on it become zero."""
    for k in range(1, n):
        beside = abs(H[k - 1, k - 1]) + abs(H[k, k]) + floor
        H[k, k - 1] = where(abs(H[k, k - 1]) <= EPS * beside, 0.0, H[k, k - 1])


def _lowest(H: Any, n: int, state: Any) -> None:
    """state[0], state[1]: first and last row of the lowest block above 2×2; the last is not positive if there is none."""
    low, high = spread(0.0), spread(n - 1.0)
    for k in range(n - 1, 0, -1):
        single, pair = H[k, k - 1] == 0.0, (H[k - 1, k - 2] if k > 1 else spread(0.0)) == 0.0
        high = where(high == k, where(single, k - 1.0, where(pair, k - 2.0, high)), high)
    for k in range(1, n):
        low = where((H[k, k - 1] == 0.0) & (high >= k), spread(k), low)
    state[0], state[1] = low, high


def _shifts(H: Any, n: int, state: Any) -> None:
    """state[2], state[3]: sum and product of the shifts, the eigenvalues of the block's last 2×2; state[4]: its steps."""
    high, steps = state[1], state[4]
    a, b, c, d, e = spread(0.0), spread(0.0), spread(0.0), spread(0.0), spread(0.0)
    for k in range(2, n):
        here = high == k
        a, b, c = where(here, H[k - 1, k - 1], a), where(here, H[k - 1, k], b), where(here, H[k, k - 1], c)
        d, e = where(here, H[k, k], d), where(here, H[k - 1, k - 2], e)
    unusual, size = (steps == UNUSUAL) | (steps == 2 * UNUSUAL), abs(c) + abs(e)
    state[2] = where(unusual, 1.5 * size, a + d)
    state[3] = where(unusual, size * size, a * d - b * c)


def _step(H: Any, n: int, state: Any) -> None:
    """One QR step with both shifts on every lane's block.  H has a row and a column of zeros more than n."""
    low, high, total, product = state[0], state[1], state[2], state[3]
    for k in range(n - 1):
        active = (low <= k) & (high > k)
        if any_lane(active):
            begins = low == k
            x = H[k, k] * (H[k, k] - total) + H[k, k + 1] * H[k + 1, k] + product
            y = H[k + 1, k] * (H[k, k] + H[k + 1, k + 1] - total)
            z = H[k + 1, k] * H[k + 2, k + 1]
            if k > 0:
                x, y = where(begins, x, H[k, k - 1]), where(begins, y, H[k + 1, k - 1])
                z = where(begins, z, H[k + 2, k - 1])
            z = where(high > k + 1, z, 0.0)
            size = math.sqrt(x * x + y * y + z * z)
            active = active & (size > 0.0)
            first = where(x < 0.0, x - size, x + size)
            q, r = where(active, y / first, 0.0), where(active, z / first, 0.0)
            weight = where(active, abs(first) / size, 0.0)
            if k > 0:
                H[k, k - 1] = where(active & ~begins, where(x < 0.0, size, -1.0 * size), H[k, k - 1])
                H[k + 1, k - 1], H[k + 2, k - 1] = spread(0.0), spread(0.0)
            for j in range(k, n):
                t = weight * (H[k, j] + q * H[k + 1, j] + r * H[k + 2, j])
                H[k, j] -= t
                H[k + 1, j] -= q * t
                H[k + 2, j] -= r * t
            for i in range(min(k + 4, n)):
                t = weight * (H[i, k] + q * H[i, k + 1] + r * H[i, k + 2])
                H[i, k] -= t
                H[i, k + 1] -= q * t
                H[i, k + 2] -= r * t


def _triangle(H: Any, n: int, state: Any, floor: Any) -> Any:
    """H becomes triangular but for 2×2 blocks; the lanes in which it does not are returned."""
    state[1], state[4] = spread(n * 1.0), spread(0.0)
    for _ in range(STEPS * n):
        before = state[1]
        cut(H, n, floor)
        lowest(H, n, state)
        if not any_lane(state[1] > 0.0):
            break
        state[4] = where(state[1] == before, state[4] + 1.0, 1.0)
        shifts(H, n, state)
        step(H, n, state)
    return state[1] > 0.0


def _pairs(H: Any, n: int, re: Any, im: Any) -> None:
    """Eigenvalues from the diagonal and the 2×2 blocks; of a conjugate pair the one with Im > 0 first."""
    for k in range(n):
        re[k], im[k] = H[k, k], spread(0.0)
    for k in range(1, n):
        pair = H[k, k - 1] != 0.0
        p, bc = 0.5 * (H[k - 1, k - 1] - H[k, k]), H[k - 1, k] * H[k, k - 1]
        square = p * p + bc
        root = math.sqrt(abs(square))
        larger = where(p < 0.0, p - root, p + root)
        real = square >= 0.0
        smaller = where(larger != 0.0, -1.0 * bc / larger, 0.0)
        re[k - 1] = where(pair, H[k, k] + where(real, larger, p), re[k - 1])
        im[k - 1] = where(pair, where(real, 0.0, root), im[k - 1])
        re[k] = where(pair, H[k, k] + where(real, smaller, p), re[k])
        im[k] = where(pair, where(real, 0.0, -1.0 * root), im[k])


def _rotate(T: Any, U: Any, n: int, re: Any, im: Any) -> None:
    """T + iU becomes triangular: the first vector of a block's basis is the eigenvector (λ - d, c) of [a b; c d]."""
    for k in range(1, n):
        pair = T[k, k - 1] != 0.0
        if any_lane(pair):
            x, y, s = re[k - 1] - T[k, k], im[k - 1], T[k, k - 1]
            size = math.sqrt(x * x + y * y + s * s)
            x, y, s = where(pair, x / size, 1.0), where(pair, y / size, 0.0), where(pair, s / size, 0.0)
            for j in range(k - 1, n):
                a, b, c, d = T[k - 1, j], U[k - 1, j], T[k, j], U[k, j]
                T[k - 1, j], U[k - 1, j] = x * a + y * b + s * c, x * b - y * a + s * d
                T[k, j], U[k, j] = x * c - y * d - s * a, x * d + y * c - s * b
            for i in range(k + 1):
                a, b, c, d = T[i, k - 1], U[i, k - 1], T[i, k], U[i, k]
                T[i, k - 1], U[i, k - 1] = x * a - y * b + s * c, x * b + y * a + s * d
                T[i, k], U[i, k] = x * c + y * d - s * a, x * d - y * c - s * b
            T[k, k - 1], U[k, k - 1] = where(pair, 0.0, T[k, k - 1]), spread(0.0)


def _quotient(a: Any, b: Any, c: Any, d: Any, floor: Any) -> Any:
    """-(a + ib)/(c + id), the denominator no smaller than ``floor``."""
    square = c * c + d * d
    tiny = square < floor * floor
    c, d, square = where(tiny, floor, c), where(tiny, 0.0, d), where(tiny, floor * floor, square)
    return -1.0 * (a * c + b * d) / square, (a * d - b * c) / square


def _conditions(T: Any, U: Any, n: int, re: Any, im: Any, floor: Any, x: Any, y: Any, out: Any) -> None:
    """κ of every eigenvalue of the triangle T + iU; x and y are room for a vector, real and imaginary parts."""
    for i in range(n):
        right = left = spread(1.0)
        x[i], y[i] = spread(1.0), spread(0.0)
        for j in range(i - 1, -1, -1):
            a, b = T[j, i], U[j, i]
            for m in range(j + 1, i):
                a += T[j, m] * x[m] - U[j, m] * y[m]
                b += T[j, m] * y[m] + U[j, m] * x[m]
            x[j], y[j] = quotient(a, b, re[j] - re[i], im[j] - im[i], floor)
            right += x[j] * x[j] + y[j] * y[j]
        for j in range(i + 1, n):
            a, b = T[i, j], U[i, j]
            for m in range(i + 1, j):
                a += T[m, j] * x[m] - U[m, j] * y[m]
                b += T[m, j] * y[m] + U[m, j] * x[m]
            x[j], y[j] = quotient(a, b, re[j] - re[i], im[j] - im[i], floor)
            left += x[j] * x[j] + y[j] * y[j]
        out[i] = math.sqrt(right) * math.sqrt(left)
        if i > 0:
            out[i] = where(im[i] < 0.0, out[i - 1], out[i])


hessenberg, cut, lowest, shifts, step = map(inlined, (_hessenberg, _cut, _lowest, _shifts, _step))
triangle, pairs, rotate, quotient = map(inlined, (_triangle, _pairs, _rotate, _quotient))
conditions = inlined(_conditions)


def _eigenvalues(matrices: Array, values: Array, condition: Array) -> None:
    """Eigenvalues and condition numbers of blocks of sixteen matrices.

    Parameters
    ----------
    matrices : (blocks, n, n, 16)
    values : (blocks, 2, n, 16)
        What is written: real and imaginary parts, conjugate pairs side by side, the one with Im > 0 first; nan where a
        matrix is not finite or was given up.
    condition : (blocks, n, 16)
        κ, written as well.
    """
    M, V, C = as_lanes(matrices), as_lanes(values), as_lanes(condition)
    n = M.shape[1]
    H = as_lanes(scratch((n + 1) * (n + 1)).reshape(n + 1, n + 1, WIDTH))
    U = as_lanes(scratch(n * n).reshape(n, n, WIDTH))
    x, y, state = as_lanes(scratch(n)), as_lanes(scratch(n)), as_lanes(scratch(5))
    for b in range(len(matrices)):
        square = spread(0.0)
        for i in range(n):
            for j in range(n):
                square += M[b, i, j] * M[b, i, j]
        finite = square - square == 0.0
        size = where(finite, math.sqrt(square), 0.0)
        for i in range(n + 1):
            H[i, n], H[n, i] = spread(0.0), spread(0.0)
        for i in range(n):
            for j in range(n):
                H[i, j], U[i, j] = where(finite, M[b, i, j], 0.0), spread(0.0)
        hessenberg(H, n, x)
        failed = triangle(H, n, state, EPS * size)
        pairs(H, n, V[b, 0], V[b, 1])
        rotate(H, U, n, V[b, 0], V[b, 1])
        conditions(H, U, n, V[b, 0], V[b, 1], EPS * size, x, y, C[b])
        for i in range(n):
            V[b, 0, i] = where(finite & ~failed, V[b, 0, i], math.nan)


eigenvalues = kernel(_eigenvalues)
