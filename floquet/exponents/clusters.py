"""Bounds of eigenvalues that are close together or defective, matrix by matrix.

A Schur form with the m eigenvalues of a cluster first, T = [T₁ V; 0 T₂], gives the norm p = √(1 + |R|²) of the
projector onto it, T₁ R - R T₂ = -V.  An error ε of the matrix becomes ρ = 2pε in T₁, unless a z in question is also
within ρ of being an eigenvalue of T₂.  With N the strictly upper part of T₁ the distance d of a perturbed eigenvalue to
the nearest one of T₁ is given by P. Henrici (Numerische Mathematik 4, 1962)::

    d = ρ (1 + |N|/d + … + (|N|/d)^(m-1))

and as no more than m can be connected, the other way it is (2m - 1) d at most.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .result import Array

__all__ = ["cluster_bounds"]

Complex = NDArray[np.complex128]
GAPS = 10.0 ** np.arange(-10.0, 0.0, 2.0)  # of the matrix' size: eigenvalues that are nearer are put together


def cluster_bounds(matrix: Array, values: Complex, error: float) -> Array:
    """Bounds (n,) of eigenvalues found for a real matrix that is known to ``error``; inf where nothing is known."""
    from scipy.linalg import schur  # late: it is seldom needed

    size, radius = float(np.linalg.norm(matrix)), np.full(len(values), np.inf)
    for gap in GAPS * size:
        for cluster in _linked(values, gap):
            centre = values[cluster].mean()
            reach = np.abs(values[cluster] - centre).max() + 0.5 * gap
            T, _, m = schur(matrix, output="complex", sort=lambda z, c=centre, r=reach: abs(z - c) <= r)
            if m == len(cluster):
                own = np.diagonal(T)[:m]
                apart = np.abs(values[cluster][:, None] - own).min(axis=1)
                radius[cluster] = np.minimum(radius[cluster], _moved(T, m, error) + apart)
    return radius


def _linked(values: Complex, gap: float) -> list[NDArray[np.intp]]:
    """Eigenvalues by sets whose neighbours are no farther than ``gap``."""
    near = np.abs(values[:, None] - values) <= gap
    for _ in range(len(values).bit_length()):
        near = near @ near
    return [np.flatnonzero(row) for row in np.unique(near, axis=0)]


def _moved(T: Complex, m: int, error: float) -> float:
    """How far errors of a matrix move the first m eigenvalues of its Schur form T."""
    from scipy.linalg import solve_sylvester, svdvals

    first, rest = T[:m, :m], T[m:, m:]
    centre, p = np.trace(first) / m, 1.0
    if len(rest):
        p = float(np.sqrt(1.0 + np.linalg.norm(solve_sylvester(first, -rest, -T[:m, m:]), 2) ** 2))
    bound = 2.0 * p * error
    d = _farthest(bound, float(np.linalg.norm(np.triu(first, 1))), m)
    reach = np.abs(np.diagonal(first) - centre).max() + d
    if len(rest) and svdvals(centre * np.eye(len(rest)) - rest)[-1] <= reach + bound:
        return float(np.inf)
    return float((2 * m - 1) * d)


def _farthest(bound: float, nilpotent: float, m: int) -> float:
    """The root d of Henrici's equation, from above."""
    low, high = bound, bound + m * (nilpotent ** (m - 1) * bound) ** (1.0 / m) + m * bound
    for _ in range(40):  # each halves what is not known of the logarithm, 100 at most
        d = float(np.sqrt(low * high))
        low, high = (low, d) if d >= bound * sum((nilpotent / d) ** k for k in range(m)) else (d, high)
    return high
