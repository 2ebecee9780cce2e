"""The Hill form of one scalar equation.

With β = exp(-½∫d) y the equation β'' + d β' + k β = 0 becomes::

    y'' + q y = 0,     q = k - d'/2 - d²/4,     det Φ = 1,    exponents = α ± ν,  α = -mean(d)/2

so that both exponents keep all their digits; where d jumps by Δ, y' jumps by ½Δ y.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.pieces import Pieces
from ..periodic import Parts, PeriodicMatrix, PeriodicSystem, on_common_pieces

__all__ = ["HillForm", "hill_form", "mean_growth", "polynomial", "term_size"]

Array = NDArray[np.float64]
ROUNDED = 1e-14  # a jump of d below this part of d is the rounding of equal values


class HillForm(NamedTuple):
    """q, α (n,), and the size of the terms that q is made of (n,): its rounding is relative to that."""

    q: Pieces
    alpha: Array
    size: Array


def hill_form(system: PeriodicSystem) -> HillForm:
    """The form of n cases along one axis."""
    n, period = math.prod(system.cases), system.period
    if (parts := _parts(system)) is None:
        return _of_one_polynomial(system, n)
    edges = np.broadcast_to(parts.edges, (n, len(parts.places) + 1)).T
    q = Pieces(
        polynomials=tuple(_trimmed(_rows(polynomial(*pair), n)) for pair in parts.pairs),
        places=parts.places,
        edges=np.minimum(edges, period),
        kicks=_kicks(parts, edges, period),
        turn=parts.pairs[0][1].period,
    )
    size = np.maximum.reduce(np.broadcast_arrays(*(term_size(*pair) for pair in parts.pairs)))
    return HillForm(q, _alpha(parts, edges), np.broadcast_to(size, (n,)))


def _of_one_polynomial(system: PeriodicSystem, n: int) -> HillForm:
    k, d = system.stiffness, system.damping
    assert k is not None
    edges = np.broadcast_to(np.array([[0.0], [system.period]]), (2, n))
    q = Pieces(polynomials=(_rows(polynomial(d, k), n),), places=(0,), edges=edges, kicks=None, turn=k.period)
    alpha = np.zeros(k.cases) if d is None else mean_growth(d)
    return HillForm(q, np.broadcast_to(alpha, (n,)), np.broadcast_to(term_size(d, k), (n,)))


def _parts(system: PeriodicSystem) -> Parts | None:
    """D and K in pieces, where there are pieces: of a model each polynomial once, else one a piece."""
    if (parts := system.parts) is not None:
        return parts
    k, d = system.stiffness, system.damping
    assert k is not None
    if d is not None:
        d, k = on_common_pieces(d, k)
    if k.edges is None:
        return None
    pieces = range(k.edges.shape[-1] - 1)
    return Parts(pairs=[(d and d.piece(j), k.piece(j)) for j in pieces], places=tuple(pieces), edges=k.edges)


def polynomial(d: PeriodicMatrix | None, k: PeriodicMatrix) -> PeriodicMatrix:
    """q of a piece."""
    return k if d is None else k - d.derivative() / 2 - (d @ d) / 4


def mean_growth(d: PeriodicMatrix) -> NDArray[Any]:
    """α of a single piece."""
    return np.asarray(-d.mean()[..., 0, 0] / 2)


def term_size(d: PeriodicMatrix | None, k: PeriodicMatrix) -> NDArray[Any]:
    """Of the terms that q of a piece is made of: rounding of q is relative to it."""
    size = k.magnitude()[..., 0, 0]
    if d is None:
        return size
    damping = d.magnitude()[..., 0, 0]
    return np.asarray(size + (2 + damping) * damping / 4)


def _rows(q: PeriodicMatrix, n: int) -> Array:
    """Terms (2H+1, n) of a piece."""
    return np.ascontiguousarray(q.flat((n,)).coefficients[:, 0, :, 0, 0].T)


def _trimmed(terms: Array) -> Array:
    """Terms without the last harmonics if they are zero in all cases."""
    while len(terms) > 1 and not np.any(terms[-2:]):
        terms = terms[:-2]
    return terms


def _alpha(parts: Parts, edges: Array) -> Array:
    """-mean(d)/2."""
    total = np.zeros(edges.shape[1])
    for place, a, b in zip(parts.places, edges[:-1], edges[1:], strict=True):
        if (d := parts.pairs[place][0]) is not None:
            total += d.integral(a, b)[..., 0, 0]
    return 0.0 - total / (2.0 * parts.pairs[0][1].period)  # no -0


def _kicks(parts: Parts, edges: Array, period: float) -> Array | None:
    """What y adds to y' where a piece begins, (pieces, n): half the jump of d; None where there is none.

    A piece without length leaves its jump to the next, the last one to the first: there and back again is no jump.
    """
    kicks, largest = np.zeros(edges[:-1].shape), np.ones(edges.shape[1])
    for j, place in enumerate(parts.places):
        after, before = (parts.pairs[i][0] for i in (place, parts.places[j - 1]))
        if after is None or before is None or after is before:
            continue
        kicks[j] = 0.5 * (after - before).at(edges[j])[..., 0, 0]
        largest = np.maximum(largest, after.magnitude()[..., 0, 0])
    for j in [*range(len(kicks))] * 2:
        empty = edges[j + 1] == edges[j]
        kicks[(j + 1) % len(kicks)] += np.where(empty, kicks[j], 0.0)
        kicks[j][empty] = 0.0
    kicks[(np.abs(kicks) <= ROUNDED * largest) | (edges[:-1] >= period)] = 0.0
    return kicks if np.any(kicks) else None
