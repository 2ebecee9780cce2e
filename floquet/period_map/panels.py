"""Panels: how many a case needs, from the case alone, and the error of a map over one.

Panels follow from the case alone (its stiffness and damping, then the error measured on it), never from its neighbours.
The error of a panel is the difference between p = 16 and p = 12 nodes, which is the error of the worse of the two,
plus an allowance for rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..collocation import Rule, gauss_rule
from ..periodic import PeriodicMatrix

Array = NDArray[np.float64]

NODES, COARSE_NODES = 16, 12
EPS = float(np.finfo(float).eps)
LADDER = tuple(sorted({2**k for k in range(1, 13)} | {3 * 2**k for k in range(11)}))
RUNGS = (
    6  # eight times the first number of panels: what is smooth is resolved by then, other places need kinks declared
)
SWEEP = 3.0  # panel length times the largest local frequency: below half a turn (π), so that turns can be counted
TRUNCATION = 6e-15  # relative to the panel's map, about the noise in the difference of two collocations
ROUNDING = 8.0  # eps a panel, relative to its map: the true errors of 20 000 random blades reach half of the bound
CASES_AT_ONCE = 4096  # (p n)² doubles a case: 8 MB of matrices for one blade


def piece_lengths(matrix: PeriodicMatrix, period: float) -> Array:
    """Length of every piece inside one period of the system, (cases, pieces)."""
    n = matrix.coefficients.shape[0]
    if matrix.edges is None:
        return np.full((n, 1), period)
    return np.broadcast_to(np.diff(np.minimum(matrix.edges, period), axis=-1), (n, matrix.edges.shape[-1] - 1))


class Panel(NamedTuple):
    """A panel of every case: its piece, centre and half length (cases,), and the piece it begins, if it does."""

    matrix: PeriodicMatrix
    centre: Array
    half: Array
    begins: int | None

    def nodes(self, rule: Rule) -> Array:
        """Azimuths (cases, p) of a rule's nodes."""
        return self.centre[:, None] + self.half[:, None] * rule.nodes


def panels_of(matrix: PeriodicMatrix, period: float, counts: tuple[int, ...]) -> Iterator[Panel]:
    """The panels of every case in order, ``counts`` of them on each piece."""
    n = matrix.coefficients.shape[0]
    ends = np.array([0.0, period]) if matrix.edges is None else np.minimum(matrix.edges, period)
    edges = np.broadcast_to(ends, (n, len(counts) + 1))
    for j, count in enumerate(counts):
        one = slice(j, j + 1) if matrix.edges is not None else slice(None)
        piece = replace(matrix, coefficients=matrix.coefficients[:, one], edges=None)
        start, half = edges[:, j], (edges[:, j + 1] - edges[:, j]) / (2 * count)
        for s in range(count):
            yield Panel(piece, start + (2 * s + 1) * half, half, j if s == 0 else None)


def estimated(panel: Callable[[Rule], Array], balance: Array | float = 1.0) -> tuple[Array, Array]:
    """A panel's map and the bound of its error, in balanced coordinates."""
    F = panel(gauss_rule(NODES))
    return F, _norm((F - panel(gauss_rule(COARSE_NODES))) * balance) + ROUNDING * EPS * _norm(F * balance)


def resolved(F: Array, error: Array, balance: Array | float = 1.0) -> NDArray[np.bool_]:
    """Whether truncation is at the level of rounding."""
    return np.asarray(error <= (TRUNCATION + ROUNDING * EPS) * _norm(F * balance))


def refine(
    solve: Callable[[NDArray[np.intp], tuple[int, ...]], NDArray[np.bool_]],
    lengths: Array,
    frequency: Array,
    period: float,
    panels: int | None,
) -> None:
    """Solve every case on the first rung of the ladder that resolves it."""
    wanted = (
        np.full(len(frequency), panels)
        if panels
        else np.maximum(np.ceil(period * np.maximum(frequency, 1.0) / SWEEP), 1)
    )
    rung = np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)
    last = np.minimum(rung + RUNGS, len(LADDER) - 1)
    pending = np.arange(len(frequency))
    while pending.size:
        total = wanted[pending] if panels else np.asarray(LADDER)[rung[pending]]
        counts = np.maximum(np.ceil(total[:, None] * lengths[pending] / period - 1e-9), 1).astype(int)
        kinds, member = np.unique(counts, axis=0, return_inverse=True)
        unresolved = []
        for kind, count in enumerate(kinds):
            group = pending[member.ravel() == kind]
            for chunk in np.split(group, range(CASES_AT_ONCE, len(group), CASES_AT_ONCE)):
                done = solve(chunk, tuple(int(c) for c in count))
                unresolved.append(chunk[~done])
        pending = np.concatenate(unresolved)
        pending = pending[:0] if panels else pending[rung[pending] < last[pending]]
        rung[pending] += 1


def _norm(m: Array) -> Array:
    """Frobenius norm."""
    return np.sqrt(np.sum(m * m, axis=(-2, -1)))
