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

__all__ = [
    "Rule", "first_order_nodes", "first_order_panel", "gauss_rule", "second_order_nodes", "second_order_panel",
]  # fmt: skip

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
    n, columns = K.shape[-1], 2 * K.shape[-1] + (0 if F is None else F.shape[-1])
    g = _second_order(D, K, h, rule, F)
    position, rate = _weighted(rule.weights * (1.0 - rule.nodes), g), _weighted(rule.weights, g)
    h2, eye = h[:, None, None], np.eye(n)
    out = np.empty((len(K), 2 * n, columns))
    out[:, :n, :n] = eye + h2 * position[..., :n]
    out[:, :n, n : 2 * n] = h2 * (2.0 * eye + position[..., n : 2 * n])
    out[:, n:, :n] = rate[..., :n]
    out[:, n:, n : 2 * n] = eye + rate[..., n : 2 * n]
    out[:, :n, 2 * n :] = h2 * position[..., 2 * n :]
    out[:, n:, 2 * n :] = rate[..., 2 * n :]
    return out


def second_order_nodes(D: Array | None, K: Array, h: Array, rule: Rule) -> Array:
    """Maps (cases, p+1, 2n, 2n) of (q, q') from the start of a panel to its nodes and its end.

    At the nodes the error is of the order p + 1 of the polynomials, at the end of 2p; see :func:`second_order_panel`.
    """
    n, h2, eye = K.shape[-1], h[:, None, None, None], np.eye(K.shape[-1])
    places = np.append(rule.nodes, 1.0)
    once = np.vstack([rule.once, rule.weights])
    twice = np.vstack([rule.twice, rule.weights * (1.0 - rule.nodes)])
    g = _second_order(D, K, h, rule)
    position, rate = _integrated(twice, g), _integrated(once, g)
    out = np.empty((len(K), len(places), 2 * n, 2 * n))
    out[..., :n, :n] = eye + h2 * position[..., :n]
    out[..., :n, n:] = h2 * ((1.0 + places)[:, None, None] * eye + position[..., n:])
    out[..., n:, :n] = rate[..., :n]
    out[..., n:, n:] = eye + rate[..., n:]
    return out


def _second_order(D: Array | None, K: Array, h: Array, rule: Rule, F: Array | None = None) -> Array:
    """The highest derivative at the nodes, (cases, p, n, 2n + m): of q₀, h q'₀ and u, divided by h."""
    cases, p, n, _ = K.shape
    columns = 2 * n + (0 if F is None else F.shape[-1])
    h1 = h[:, None, None, None]
    hK = h1 * K
    system = h1[..., None] * (hK[:, :, :, None, :] * rule.twice[None, :, None, :, None])
    if D is not None:
        system += h1[..., None] * (D[:, :, :, None, :] * rule.once[None, :, None, :, None])
    system = system.reshape(cases, p * n, p * n)
    system[:, np.arange(p * n), np.arange(p * n)] += 1.0
    right = np.empty((cases, p, n, columns))
    right[..., :n] = -hK
    right[..., n : 2 * n] = -h1 * (1.0 + rule.nodes)[:, None, None] * hK
    if D is not None:
        right[..., n : 2 * n] -= h1 * D
    if F is not None:
        right[..., 2 * n :] = h1 * F
    found: NDArray[Any] = np.linalg.solve(system, right.reshape(cases, p * n, columns))
    return found.reshape(cases, p, n, columns)


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
    n, g = A.shape[-1], _first_order(A, h, rule, F)
    return np.eye(n, g.shape[-1]) + _weighted(rule.weights, g)


def first_order_nodes(A: Array, h: Array, rule: Rule) -> Array:
    """Maps (cases, p+1, n, n) of x from the start of a panel to its nodes and its end; see above."""
    return np.eye(A.shape[-1]) + _integrated(np.vstack([rule.once, rule.weights]), _first_order(A, h, rule))


def _first_order(A: Array, h: Array, rule: Rule, F: Array | None = None) -> Array:
    """The derivative at the nodes, (cases, p, n, n + m)."""
    cases, p, n, _ = A.shape
    hA = h[:, None, None, None] * A
    system = (-hA[:, :, :, None, :] * rule.once[None, :, None, :, None]).reshape(cases, p * n, p * n)
    system[:, np.arange(p * n), np.arange(p * n)] += 1.0
    right = hA if F is None else np.concatenate([hA, h[:, None, None, None] * F], axis=-1)
    columns = right.shape[-1]
    found: NDArray[Any] = np.linalg.solve(system, right.reshape(cases, p * n, columns))
    return found.reshape(cases, p, n, columns)


def _integrated(matrix: Array, g: Array) -> Array:
    """Σ_k matrix[j, k] g[:, k], one j after the other, (cases, rows, ...)."""
    return np.stack([_weighted(row, g) for row in matrix], axis=1)


def _weighted(weights: Array, g: NDArray[Any]) -> Array:
    """Σ weights[j] g[:, j] one node after the other, so that a case's bits do not depend on its neighbours."""
    total = weights[0] * g[:, 0]
    for j in range(1, len(weights)):
        total += weights[j] * g[:, j]
    return total
