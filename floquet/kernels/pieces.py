"""Maps of y'' + q(ψ) y = 0 for q in pieces, a trigonometric polynomial of any order on each.

Every piece of every point has panels of its own: s of m on a piece from a to b is about a + (2s+1)h with h =
(b-a)/(2m).  Many points run compiled, sixteen at a time (``pieces_lanes.py``), few as arrays of panels; both use the
arithmetic of ``hill.py``.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import available, worth_compiling
from .hill import Panels, map_panels
from .taylor import ORDER

__all__ = ["Pieces", "map_pieces"]

Array = NDArray[np.float64]


class Pieces(NamedTuple):
    """q in pieces, for many points.

    ``polynomials`` (2H+1, n) are the mean, cos ωψ, sin ωψ, cos 2ωψ … of q, and ``places`` says which of them stands on
    each piece; ``edges`` (pieces+1, n) begin with 0; ``kicks`` (pieces, n) is what y adds to y' where a piece begins,
    nothing if it has no length; harmonic 1 repeats after ``turn``.
    """

    polynomials: tuple[Array, ...]
    places: tuple[int, ...]
    edges: Array
    kicks: Array | None
    turn: float

    @property
    def lengths(self) -> Array:
        """(pieces, n)."""
        return np.diff(self.edges, axis=0)


def map_pieces(
    q: Pieces, size: Array, index: NDArray[np.intp], counts: NDArray[np.int64], out: Array, *, compiled: bool | None
) -> None:
    """Fill the rows ``index`` of ``out`` (:data:`~floquet.kernels.hill.ROWS`, n), see ``map_equal_panels``.

    ``counts`` (pieces, m) are the panels of the points ``index`` (m,) on each piece, none on a piece without length; a
    point's bits do not depend on the others.
    """
    if worth_compiling(q.edges.shape[1]) if compiled is None else compiled and available():
        _map_lanes(q, size, index, counts, out)
    else:
        total = counts.sum(axis=0)
        unit = 0.5 * q.edges[-1, index] / total
        map_panels(_panels(q, index, counts), size[index], unit, index, out)


# ---------------------------------------------------------------------- compiled
def _map_lanes(q: Pieces, size: Array, index: NDArray[np.intp], counts: NDArray[np.int64], out: Array) -> None:
    from . import pieces_lanes

    orders = np.array([len(p) // 2 for p in q.polynomials])
    first, places = np.cumsum([0, *(2 * orders[:-1] + 1)]), list(q.places)
    terms = np.ascontiguousarray(q.polynomials[0] if len(q.polynomials) == 1 else np.concatenate(q.polynomials))
    edges, kicks = np.ascontiguousarray(q.edges), np.zeros((len(places), 0)) if q.kicks is None else q.kicks
    order, table = _alike(counts), weights(int(orders.max()))
    pieces_lanes.map_blocks(
        terms, edges, kicks, np.ascontiguousarray(size), first[places], orders[places], table, 2.0 * math.pi / q.turn,
        index[order], np.ascontiguousarray(counts[:, order]), int(counts.max(axis=1).sum()), out,
    )  # fmt: skip


def _alike(counts: NDArray[np.int64]) -> NDArray[np.intp]:
    """Points in an order that puts equal numbers of panels side by side: lanes then have little to wait for."""
    order = np.arange(counts.shape[1])
    for row in counts.astype(np.int16):
        order = order[np.argsort(row[order], kind="stable")]
    return order


@cache
def weights(order: int) -> Array:
    """±n^k/k! (K, order): what harmonic n of q adds to p_k = -h² q_k, times h² (ωh)^k."""
    k = np.arange(ORDER - 1)
    scale = np.where(k % 4 < 2, -1.0, 1.0) / np.array([float(math.factorial(j)) for j in k])
    return scale[:, None] * np.arange(1.0, order + 1.0) ** k[:, None]


# ---------------------------------------------------------------------- on arrays
def _panels(q: Pieces, index: NDArray[np.intp], counts: NDArray[np.int64]) -> Panels:
    """The panels of all points, one point after the other."""
    rows = max(len(p) for p in q.polynomials)
    wide = [np.concatenate([p[:, index], np.zeros((rows - len(p), len(index)))]) for p in q.polynomials]
    terms = np.stack([wide[place] for place in q.places], axis=-1)  # (2H+1, m, pieces)
    start, length = q.edges[:-1, index].T, q.lengths[:, index].T
    flat = counts.T.ravel()
    piece = np.repeat(np.arange(flat.size), flat)  # of each panel, all points' pieces in a row
    place = np.arange(len(piece)) - np.repeat(np.cumsum(flat) - flat, flat)
    half = (length / (2 * np.maximum(counts.T, 1))).ravel()[piece]
    kick = np.zeros(len(piece))
    if q.kicks is not None:
        kick = np.where(place == 0, q.kicks[:, index].T.ravel()[piece], 0.0)
    return Panels(
        terms=terms.reshape(rows, -1)[:, piece],
        centre=start.ravel()[piece] + (2 * place + 1) * half,
        half=half,
        kick=kick,
        counts=counts.sum(axis=0),
        frequency=2.0 * math.pi / q.turn,
    )
