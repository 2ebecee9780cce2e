"""Eigenvalues and eigenvectors of real matrices, sixteen at a time.

Householder reflections make a matrix B Hessenberg, QR steps with two shifts (J. G. F. Francis) triangular but for
2×2 blocks, each a pair of eigenvalues, and rotations of these make it triangular over the complex numbers,
T = (Q R)ᴴ B Q R.  Vectors with T x = λ x and y T = λ y follow by substitution; those of B are Q R x and y (Q R)ᴴ.

Vectors of a conjugate pair stand in two columns, real and imaginary part.  Every lane works at a block of its own, rows
``low`` … ``high``; steps outside it are reflections with nothing in them, so that no lane depends on another one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .compiler import inlined
from .factors import multiplied
from .lanes import any_lane, spread, where

__all__ = ["hessenberg", "lengths", "pairs", "rotate", "row_lengths", "triangle", "vectors"]

EPS = float(np.finfo(float).eps)
STEPS = 30  # QR steps an eigenvalue before a matrix is given up, as in EISPACK; two or three are usual
UNUSUAL = 10  # after so many steps without success, and twice as many, the shifts are others


def _hessenberg(H: Any, Q: Any, n: int, v: Any) -> None:
    """H becomes Hessenberg by reflections from both sides, Q their product."""
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
            total, other = spread(0.0), spread(0.0)
            for j in range(k + 1, n):
                total += v[j] * H[i, j]
                other += v[j] * Q[i, j]
            total *= weight
            other *= weight
            for j in range(k + 1, n):
                H[i, j] -= total * v[j]
                Q[i, j] -= other * v[j]


def _cut(H: Any, n: int, floor: Any) -> None:
    """Entries below the diagonal that are nothing beside their neighbours on it become zero."""
    for k in range(1, n):
        beside = abs(H[k - 1, k - 1]) + abs(H[k, k]) + floor
        H[k, k - 1] = where(abs(H[k, k - 1]) <= EPS * beside, 0.0, H[k, k - 1])


def _lowest(H: Any, n: int, state: Any) -> None:
    """state[0], state[1]: first and last row of the lowest block above 2×2; if there is none, the last is 0 or less."""
    low, high = spread(0.0), spread(n - 1.0)
    for k in range(n - 1, 0, -1):
        single, pair = H[k, k - 1] == 0.0, (H[k - 1, k - 2] if k > 1 else spread(0.0)) == 0.0
        high = where(high == k, where(single, k - 1.0, where(pair, k - 2.0, high)), high)
    for k in range(1, n):
        low = where((H[k, k - 1] == 0.0) & (high >= k), spread(k), low)
    state[0], state[1] = low, high


def _shifts(H: Any, n: int, state: Any) -> None:
    """state[2], state[3]: sum and product of the shifts, eigenvalues of the block's last 2×2; state[4]: steps made."""
    high, steps = state[1], state[4]
    a, b, c, d, e = spread(0.0), spread(0.0), spread(0.0), spread(0.0), spread(0.0)
    for k in range(2, n):
        here = high == k
        a, b, c = where(here, H[k - 1, k - 1], a), where(here, H[k - 1, k], b), where(here, H[k, k - 1], c)
        d, e = where(here, H[k, k], d), where(here, H[k - 1, k - 2], e)
    unusual, size = (steps == UNUSUAL) | (steps == 2 * UNUSUAL), abs(c) + abs(e)
    state[2] = where(unusual, 1.5 * size, a + d)
    state[3] = where(unusual, size * size, a * d - b * c)


def _step(H: Any, Q: Any, n: int, state: Any) -> None:
    """One QR step with both shifts on every lane's block; H has a row and a column of zeros beyond n, Q a column."""
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
            for i in range(n):
                t = weight * (Q[i, k] + q * Q[i, k + 1] + r * Q[i, k + 2])
                Q[i, k] -= t
                Q[i, k + 1] -= q * t
                Q[i, k + 2] -= r * t


def _triangle(H: Any, Q: Any, n: int, state: Any, floor: Any) -> Any:
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
        step(H, Q, n, state)
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


def _rotate(T: Any, U: Any, n: int, re: Any, im: Any, turn: Any) -> None:
    """T + iU becomes triangular: the first vector of a block's basis is the eigenvector (λ - d, c) of [a b; c d].

    turn[0, k] + i turn[1, k] and turn[2, k] are its entries for the block of rows k-1, k; 1 and 0 where there is none.
    """
    for k in range(1, n):
        pair = T[k, k - 1] != 0.0
        x, y, s = re[k - 1] - T[k, k], im[k - 1], T[k, k - 1]
        size = math.sqrt(x * x + y * y + s * s)
        x, y, s = where(pair, x / size, 1.0), where(pair, y / size, 0.0), where(pair, s / size, 0.0)
        turn[0, k], turn[1, k], turn[2, k] = x, y, s
        if any_lane(pair):
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


def _right(T: Any, U: Any, n: int, i: int, re: Any, im: Any, floor: Any, turn: Any, x: Any, y: Any) -> None:
    """x + iy with (T + iU) x = λ_i x, turned back from the bases of the blocks."""
    for j in range(i + 1, n):
        x[j], y[j] = spread(0.0), spread(0.0)
    x[i], y[i] = spread(1.0), spread(0.0)
    for j in range(i - 1, -1, -1):
        a, b = T[j, i], U[j, i]
        for m in range(j + 1, i):
            a += T[j, m] * x[m] - U[j, m] * y[m]
            b += T[j, m] * y[m] + U[j, m] * x[m]
        x[j], y[j] = quotient(a, b, re[j] - re[i], im[j] - im[i], floor)
    for k in range(1, n):
        a, b, c, d, p, q, s = x[k - 1], y[k - 1], x[k], y[k], turn[0, k], turn[1, k], turn[2, k]
        x[k - 1], y[k - 1] = p * a - q * b - s * c, p * b + q * a - s * d
        x[k], y[k] = p * c + q * d + s * a, p * d - q * c + s * b


def _left(T: Any, U: Any, n: int, i: int, re: Any, im: Any, floor: Any, turn: Any, x: Any, y: Any) -> None:
    """x + iy with x (T + iU) = λ_i x, turned back from the bases of the blocks."""
    for j in range(i):
        x[j], y[j] = spread(0.0), spread(0.0)
    x[i], y[i] = spread(1.0), spread(0.0)
    for j in range(i + 1, n):
        a, b = T[i, j], U[i, j]
        for m in range(i + 1, j):
            a += T[m, j] * x[m] - U[m, j] * y[m]
            b += T[m, j] * y[m] + U[m, j] * x[m]
        x[j], y[j] = quotient(a, b, re[j] - re[i], im[j] - im[i], floor)
    for k in range(1, n):
        a, b, c, d, p, q, s = x[k - 1], y[k - 1], x[k], y[k], turn[0, k], turn[1, k], turn[2, k]
        x[k - 1], y[k - 1] = p * a + q * b - s * c, p * b - q * a - s * d
        x[k], y[k] = p * c - q * d + s * a, p * d + q * c + s * b


def _vectors(T: Any, U: Any, Q: Any, n: int, re: Any, im: Any, floor: Any, room: Any, X: Any, Y: Any) -> None:
    """Columns of X, of length 1, and rows of Y, y_i x_i = 1: eigenvectors of Q (T + iU) Qᵀ."""
    turn, x, y, size, work = room
    for i in range(n):
        right(T, U, n, i, re, im, floor, turn, x, y)
        for j in range(n):
            work[j, i] = where(im[i] < 0.0, work[j, i], x[j]) if i > 0 else x[j]
            if i < n - 1:
                work[j, i + 1] = y[j]
    multiplied(Q, work, n, X)
    for i in range(n):
        left(T, U, n, i, re, im, floor, turn, x, y)
        for j in range(n):
            work[j, i] = where(im[i] < 0.0, work[j, i], x[j]) if i > 0 else x[j]
            if i < n - 1:
                work[j, i + 1] = y[j]
    multiplied(Q, work, n, T)
    lengths(X, n, im, size)
    for i in range(n):
        for j in range(n):
            Y[i, j] = T[j, i] * size[i]
            X[j, i] /= size[i]


def _lengths(X: Any, n: int, im: Any, out: Any) -> None:
    """Lengths of the vectors in the columns of X, both columns of a pair together."""
    for i in range(n):
        total = spread(0.0)
        for j in range(n):
            total += X[j, i] * X[j, i]
        out[i] = total
    together(n, im, out)


def _row_lengths(Y: Any, n: int, im: Any, out: Any) -> None:
    """Lengths of the vectors in the rows of Y."""
    for i in range(n):
        total = spread(0.0)
        for j in range(n):
            total += Y[i, j] * Y[i, j]
        out[i] = total
    together(n, im, out)


def _together(n: int, im: Any, out: Any) -> None:
    """Lengths from squares, those of a pair added."""
    for i in range(n - 1):
        both = out[i] + out[i + 1]
        pair = im[i] > 0.0
        out[i], out[i + 1] = where(pair, both, out[i]), where(pair, both, out[i + 1])
    for i in range(n):
        out[i] = math.sqrt(out[i])


hessenberg: Any = inlined(_hessenberg)
cut: Any = inlined(_cut)
lowest: Any = inlined(_lowest)
shifts: Any = inlined(_shifts)
step: Any = inlined(_step)
triangle: Any = inlined(_triangle)
pairs: Any = inlined(_pairs)
rotate: Any = inlined(_rotate)
quotient: Any = inlined(_quotient)
right: Any = inlined(_right)
left: Any = inlined(_left)
vectors: Any = inlined(_vectors)
lengths: Any = inlined(_lengths)
row_lengths: Any = inlined(_row_lengths)
together: Any = inlined(_together)
