"""Panel maps of linear periodic systems by Gauss collocation: arrays in, arrays out.

On a panel ψ = centre + h x, x in [-1, 1], the highest derivative g is a polynomial through p Gauss nodes.  With
I₁, I₂ the matrices that integrate it once and twice from x = -1::

    second order   g = h² F u - h D q̇ - h² K q,   q̇ = q̇₀ + I₁ g,   q = q₀ + (1+x) q̇₀ + I₂ g
    first order    g = h (A x + F u),             x = x₀ + I₁ g

is a linear system for g at the nodes; the end of the panel follows by Gauss quadrature, with an error O(h^2p).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

__all__ = ["Rule", "first_order_panel", "gauss_rule", "second_order_panel"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Rule:
    """Gauss-Legendre nodes and weights on [-1, 1] with integration matrices from -1 to the nodes."""

    nodes: Array
    weights: Array
    once: Array
    twice: Array


@cache
def gauss_rule(p: int) -> Rule:
    """The rule of ``p`` nodes: weights sum to 2, ``once @ x**k`` is exact to k = p-1."""
    x, w = legendre.leggauss(p)
    to_coefficients = (legendre.legvander(x, p - 1) * w[:, None]).T * (np.arange(p) + 0.5)[:, None]
    once, twice = np.empty((p, p)), np.empty((p, p))
    for k in range(p):
        first = legendre.legint(np.eye(p)[k], lbnd=-1)
        once[:, k] = legendre.legval(x, first)
        twice[:, k] = legendre.legval(x, legendre.legint(first, lbnd=-1))
    return Rule(x, w, once @ to_coefficients, twice @ to_coefficients)


def second_order_panel(D: Array | None, K: Array, h: Array, rule: Rule, F: Array | None = None) -> Array:
    """Map of (q, q') over one panel of ``q'' + D q' + K q = F u`` with constant u.

    Parameters
    ----------
    D, K : (cases, p, n, n)
        Samples at the nodes; D None is zero.
    h : (cases,)
        Half the panel's length.
    F : (cases, p, n, m), optional

    Returns
    -------
    (cases, 2n, 2n + m)
        The columns that multiply q₀, q'₀ and u.
    """
    cases, p, n, _ = K.shape
    columns = 2 * n + (0 if F is None else F.shape[-1])
    h1 = h[:, None, None, None]
    hK = h1 * K
    system = h1[..., None] * (hK[:, :, :, None, :] * rule.twice[None, :, None, :, None])
    if D is not None:
        system += h1[..., None] * (D[:, :, :, None, :] * rule.once[None, :, None, :, None])
    system = system.reshape(cases, p * n, p * n)
    system[:, np.arange(p * n), np.arange(p * n)] += 1.0
    right = np.empty((cases, p, n, columns))  # of q₀, h q'₀ and u; all divided by h
    right[..., :n] = -hK
    right[..., n : 2 * n] = -h1 * (1.0 + rule.nodes)[:, None, None] * hK
    if D is not None:
        right[..., n : 2 * n] -= h1 * D
    if F is not None:
        right[..., 2 * n :] = h1 * F
    g = np.linalg.solve(system, right.reshape(cases, p * n, columns)).reshape(cases, p, n, columns)
    position, rate = _weighted(rule.weights * (1.0 - rule.nodes), g), _weighted(rule.weights, g)
    h2, eye = h[:, None, None], np.eye(n)
    out = np.empty((cases, 2 * n, columns))
    out[:, :n, :n] = eye + h2 * position[..., :n]
    out[:, :n, n : 2 * n] = h2 * (2.0 * eye + position[..., n : 2 * n])
    out[:, n:, :n] = rate[..., :n]
    out[:, n:, n : 2 * n] = eye + rate[..., n : 2 * n]
    out[:, :n, 2 * n :] = h2 * position[..., 2 * n :]
    out[:, n:, 2 * n :] = rate[..., 2 * n :]
    return out


def first_order_panel(A: Array, h: Array, rule: Rule, F: Array | None = None) -> Array:
    """Map of x over one panel of ``x' = A x + F u`` with constant u.

    Parameters
    ----------
    A : (cases, p, n, n)
        Samples at the nodes.
    h : (cases,)
        Half the panel's length.
    F : (cases, p, n, m), optional

    Returns
    -------
    (cases, n, n + m)
        The columns that multiply x₀, then those that multiply u.
    """
    cases, p, n, _ = A.shape
    hA = h[:, None, None, None] * A
    system = (-hA[:, :, :, None, :] * rule.once[None, :, None, :, None]).reshape(cases, p * n, p * n)
    system[:, np.arange(p * n), np.arange(p * n)] += 1.0
    right = hA if F is None else np.concatenate([hA, h[:, None, None, None] * F], axis=-1)
    columns = right.shape[-1]
    g = np.linalg.solve(system, right.reshape(cases, p * n, columns)).reshape(cases, p, n, columns)
    return np.eye(n, columns) + _weighted(rule.weights, g)


def _weighted(weights: Array, g: NDArray[Any]) -> Array:
    """Σ weights[j] g[:, j] one node after the other, so that a case's bits do not depend on its neighbours."""
    total = weights[0] * g[:, 0]
    for j in range(1, len(weights)):
        total += weights[j] * g[:, j]
    return total
