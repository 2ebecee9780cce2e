"""QR sweeps over the factors of many maps, sixteen at a time: the directions that grow, in order of their growth.

One period forward is F_k Q_{k-1} = Q_k R_k, one backward F_kᵀ U_k = U_{k-1} R; after some, the first m columns of Q
span what grows most, for every m at which growth differs, and those of U the same of the adjoint.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiler import inlined, kernel
from .factors import multiplied, square
from .lanes import as_lanes, scratch, spread, where

__all__ = ["sweep_panels"]

Array = NDArray[np.float64]


def _reflected(A: Any, n: int, v: Any, Q: Any) -> None:
    """A becomes triangular, Q orthogonal, and their product what A was."""
    for i in range(n):
        for j in range(n):
            Q[i, j] = spread(1.0 if i == j else 0.0)
    for k in range(n - 1):
        square_ = spread(0.0)
        for i in range(k, n):
            v[i] = A[i, k]
            square_ += v[i] * v[i]
        first, size = v[k], math.sqrt(square_)
        new = where(first > 0.0, -1.0 * size, size)
        v[k] = first - new
        half = square_ - first * new  # of |v|²
        weight = where(half > 0.0, 1.0 / half, 0.0)
        A[k, k] = new
        for i in range(k + 1, n):
            A[i, k] = spread(0.0)
        for j in range(k + 1, n):
            total = spread(0.0)
            for i in range(k, n):
                total += v[i] * A[i, j]
            total *= weight
            for i in range(k, n):
                A[i, j] -= total * v[i]
        for i in range(n):
            total = spread(0.0)
            for j in range(k, n):
                total += Q[i, j] * v[j]
            total *= weight
            for j in range(k, n):
                Q[i, j] -= total * v[j]


def _turned_over(x: Any, n: int, out: Any) -> None:
    """out = xᵀ."""
    for i in range(n):
        for j in range(n):
            out[i, j] = x[j, i]


def _twisted(twist: Array, x: Any, n: int, out: Any) -> None:
    """out = E x."""
    for i in range(n):
        for j in range(n):
            out[i, j] = twist[i] * x[i, j]


reflected: Any = inlined(_reflected)
turned_over: Any = inlined(_turned_over)
twisted: Any = inlined(_twisted)


def _sweep_panels(maps: Array, twist: Array, sweeps: int, starts: Array, Qs: Array, Rs: Array, Us: Array) -> None:
    """The last of some sweeps in either direction.

    Parameters
    ----------
    maps : (blocks, K, n, n, 16)
    twist : (n,)
        The diagonal of E, with which a period ends.
    sweeps : int
    starts, Qs, Rs, Us : (blocks, n, n, 16), (blocks, K, n, n, 16) and twice again
        What is written: Q₀, Q_k and R_k after each panel, U_k before its factor is applied.
    """
    F, start, Q, R, U = as_lanes(maps), as_lanes(starts), as_lanes(Qs), as_lanes(Rs), as_lanes(Us)
    panels, n = F.shape[1], F.shape[2]
    now, A, other, v = as_lanes(square(n)), as_lanes(square(n)), as_lanes(square(n)), as_lanes(scratch(n))
    for b in range(len(maps)):
        for i in range(n):
            for j in range(n):
                now[i, j] = spread(1.0 if i == j else 0.0)
        for s in range(sweeps):
            twisted(twist, now, n, start[b])
            twisted(twist, now, n, now)
            for k in range(panels):
                multiplied(F[b, k], now, n, A)
                reflected(A, n, v, now)
                if s == sweeps - 1:
                    for i in range(n):
                        for j in range(n):
                            Q[b, k, i, j], R[b, k, i, j] = now[i, j], A[i, j]
        for i in range(n):
            for j in range(n):
                now[i, j] = spread(1.0 if i == j else 0.0)
        for s in range(sweeps):
            twisted(twist, now, n, now)
            for k in range(panels - 1, -1, -1):
                if s == sweeps - 1:
                    for i in range(n):
                        for j in range(n):
                            U[b, k, i, j] = now[i, j]
                turned_over(F[b, k], n, other)
                multiplied(other, now, n, A)
                reflected(A, n, v, now)


sweep_panels = kernel(_sweep_panels)
