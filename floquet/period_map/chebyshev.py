"""One scalar equation over a tensor grid of parameters: Φ at Chebyshev nodes, polynomials between them.

The entries of Φ are entire functions of the coefficients of q, and these are smooth functions of the parameters, so
that twenty nodes an axis carry a grid of a thousand values an axis.

A region of the grid is tried with some nodes an axis.  With c_k the coefficients of Chebyshev's polynomials on a line
of nodes, it becomes a box when the last c_k are no more than the rounding of the nodes, and when points solved directly
(its corners, and others at random) lie within the bounds.  Else there are more nodes, or the region is cut in two, down
to where all its points are solved directly in the time of the nodes.

See :mod:`floquet.kernels.grid` for the polynomials, the bounds and the branch.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from ..kernels import available
from ..kernels.grid import cardinals, judged, within, zeros_of
from ..kernels.hill import EPS
from ..periodic import PeriodicSystem
from .hill import hill_map
from .precise import TOLERANCE
from .tensor import Region

__all__ = ["Box", "boxes"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

FIRST = {1: 24, 2: 24, 3: 16}  # nodes an axis to begin with, for so many axes: most grids need no others
MOST = 48  # before the axis is cut
GAIN = 4  # points a node: fewer are as fast solved directly
LEAST, LEAST_IN_PIECES = 4096, 1024  # points of a box: its nodes cost as much as so many points solved directly
RESOLVED = 5e-15  # of the last coefficients, relative to the largest entry on their line: their rounding, at worst
ROUNDED = 1e-15  # and in the mean, which more nodes are to reach
ROUNDING = 8.0  # eps of τ: some forty products and weights, rounded at random
TURNING = 0.2  # quarter turns in the last coefficients of ω; one and a half in all are allowed
#: Bounds, and how many points above them pay for cutting a region: solved directly, or for the better bounds alone.
ROUGH = ((TOLERANCE, 1 << 14), (1e-12, 1 << 17))
ATTEMPTS = 6
SPOTS = 8  # points solved directly within a region, beside its corners


@dataclass(frozen=True, eq=False, kw_only=True)
class Box:
    """A region with its nodes.

    Attributes
    ----------
    nodes, weights : tuple of (m_k,)
        Of each axis, in barycentric form.
    values : (7, m_0, …)
        :data:`~floquet.kernels.grid.FIELDS` at the nodes.
    unit : float
        Length that makes y' comparable with y.
    panels : int
        Of each node.
    """

    region: Region
    nodes: tuple[Array, ...]
    weights: tuple[Array, ...]
    values: Array
    unit: float
    panels: int


def boxes(region: Region, least: int = LEAST) -> list[Box]:
    """Boxes of a region; ``least`` points are worth nodes."""
    counts = (FIRST[len(region.spans)],) * len(region.spans)
    for _ in range(ATTEMPTS):
        if region.points < max(least, GAIN * math.prod(counts)) or not region.long:
            return []
        tried = Attempt(region, counts)
        if max(tried.wanted) > MOST:
            return _halves(region, int(np.argmax(tried.wanted)), tried.least)
        if tried.wanted != counts:
            counts = tried.wanted
        elif not tried.turns_known:
            break
        elif not tried.agrees:
            counts = tuple(m + 8 for m in counts)
        elif tried.rough:
            return _halves(region, tried.steepest, tried.least)
        else:
            return [tried.box]
    return _halves(region, int(np.argmax(counts)), tried.least)


def _halves(region: Region, k: int, least: int) -> list[Box]:
    return [box for half in region.cut(k) for box in boxes(half, least)]


class Attempt:
    """So many nodes an axis on a region, solved together with some of its points."""

    def __init__(self, region: Region, counts: tuple[int, ...]) -> None:
        self.counts = counts
        self.nodes = tuple(_nodes(x[0], x[-1], m) for x, m in zip(region.values, counts, strict=True))
        self.spots = _spots(region)
        mesh = tuple(x.ravel() for x in np.meshgrid(*self.nodes, indexing="ij"))
        self.system = _system(region, self.spots, mesh)
        phi = hill_map(self.system, precise=False, compiled=available(), alike=True)
        assert phi.rows is not None
        self.good = bool(np.all(np.isfinite(phi.rows)) and np.all(phi.rows[7] == 0.0))
        self.direct, rows = np.split(np.nan_to_num(phi.rows), [len(self.spots[0])], axis=1)
        unit = _unit(rows)
        alpha = phi.mean[len(self.spots[0]) :]
        self.values = np.stack([*rows[:4], _quarters(rows, unit), alpha, rows[4]]).reshape(-1, *counts)
        self.box = Box(
            region=region,
            nodes=self.nodes,
            weights=tuple(_weights(x) for x in self.nodes),
            values=np.concatenate([self.values[:-1], self._bound(region)[None]]),
            unit=unit,
            panels=int(phi.panels.max()),
        )

    def _bound(self, region: Region) -> Array:
        """Of τ at the nodes: their own, of rounding, and on the lines through them."""
        tau = 0.5 * (self.values[0] + self.values[3])
        bound = self.values[6] + ROUNDING * EPS * np.abs(tau)
        for k, (axis, x) in enumerate(zip(region.grid.axes, self.nodes, strict=True)):
            bound = bound + _tail(_coefficients(tau, k), 2.0 * axis.slack / (x[-1] - x[0]), k)
        return np.asarray(bound)

    @property
    def least(self) -> int:
        """Points worth nodes: fewer where they take long."""
        assert self.system.stiffness is not None
        return LEAST if self.system.stiffness.edges is None else LEAST_IN_PIECES

    @cached_property
    def wanted(self) -> tuple[int, ...]:
        """Nodes an axis that bring the last coefficients down to rounding; too many where they do not fall."""
        if not self.good:  # motions beyond the doubles, or kinks that are not declared
            return (MOST + 1,) * len(self.counts)
        return tuple(_wanted(self._falling(k)) for k in range(len(self.counts)))

    def _falling(self, k: int) -> Array:
        """Sizes of the coefficients along axis k: of Φ relative to the largest entry on a line, and of α."""
        tiny, unit, ndim = np.finfo(float).tiny, self.box.unit, len(self.counts)
        phi = self.values[:4] * np.array([1.0, 1.0 / unit, unit, 1.0]).reshape(4, *[1] * ndim)
        alpha, m = self.values[5], self.counts[k]
        of_phi = np.abs(_coefficients(phi, k + 1)) / np.maximum(np.abs(phi).max(axis=(0, k + 1)), tiny)
        of_alpha = np.abs(_coefficients(alpha, k)) / max(float(np.abs(alpha).max()), tiny)
        return np.maximum(of_phi.reshape(m, -1).max(axis=1), of_alpha.reshape(m, -1).max(axis=1))

    @property
    def turns_known(self) -> bool:
        """Whether ω is resolved."""
        return all(np.abs(_coefficients(self.values[4], k)[-2:]).max() <= TURNING for k in range(len(self.counts)))

    @property
    def agrees(self) -> bool:
        """Whether the direct points lie within the bounds of both, on the same branch."""
        box, rows = self.box, self.direct
        signed, bound = box.values[:-1], box.values[-1:]
        for k, (x, i) in enumerate(zip(box.region.values, self.spots, strict=True)):
            e = cardinals(x[i], box.nodes[k], box.weights[k])
            along = "sa,fsa...->fs..." if k else "sa,fa...->fs..."
            signed, bound = np.einsum(along, e, signed), np.einsum(along, np.abs(e), bound)
        m, quarters, tau_error = tuple(signed[:4]), signed[4], bound[0]
        D, b = judged(m, tau_error)
        zeros, certain = zeros_of(m, quarters, box.unit)
        near = np.abs(0.5 * (m[0] + m[3]) - 0.5 * (rows[0] + rows[3])) <= tau_error + rows[4]
        return bool(np.all(near & (np.abs(D - rows[8]) <= b + rows[5]) & ((zeros == rows[6]) | ~certain)))

    @property
    def rough(self) -> bool:
        """Whether many points have wide bounds, as midway between the nodes of all axes, where bounds are widest."""
        box = self.box
        tau, bound = 0.5 * (box.values[0] + box.values[3]), box.values[6]
        for k, (x, weights) in enumerate(zip(box.nodes, box.weights, strict=True)):
            e = cardinals(0.5 * (x[1:] + x[:-1]), x, weights)
            tau = np.moveaxis(np.tensordot(e, tau, axes=(1, k)), 0, k)
            bound = np.moveaxis(np.tensordot(np.abs(e), bound, axes=(1, k)), 0, k)
        D, b = tau * tau - 1.0, (2.0 * np.abs(tau) + bound) * bound
        wide = [~within(D, b, bound, most, self.system.period) for most, _ in ROUGH]
        return any(np.mean(w) * box.region.points > many for w, (_, many) in zip(wide, ROUGH, strict=True))

    @property
    def steepest(self) -> int:
        """The axis along which motions grow most: by the mean bounds of its two halves."""
        w = self.box.values[-1]
        halves = (np.array_split(w, 2, axis=k) for k in range(w.ndim))
        return int(np.argmax([abs(math.log(a.mean() / b.mean())) for a, b in halves]))


def _system(region: Region, spots: tuple[Places, ...], mesh: tuple[Array, ...]) -> PeriodicSystem:
    """Points and nodes as cases along one axis."""
    system = region.grid.system
    assert system.equation is not None
    d, k = system.equation.build(region.parameters(spots, mesh))
    return replace(system, damping=d, stiffness=k, equation=None, blade=None)


def _spots(region: Region) -> tuple[Places, ...]:
    """Index of the corners of a region and of some points within, the same ones every time."""
    rng = np.random.default_rng([*region.fixed, *(i for span in region.spans for i in (span.start, span.stop))])
    corners = itertools.product(*((0, n - 1) for n in region.lengths))
    within_it = zip(*(rng.integers(0, n, SPOTS) for n in region.lengths), strict=True)
    return tuple(np.array(i, np.intp) for i in zip(*corners, *within_it, strict=True))


def _unit(rows: Array) -> float:
    """Length that makes Φ₁₂ and Φ₂₁ of one size."""
    above, below = float(np.abs(rows[1]).sum()), float(np.abs(rows[2]).sum())
    return math.sqrt(above / below) if 0.0 < above < math.inf and 0.0 < below < math.inf else 1.0


def _quarters(rows: Array, unit: float) -> Array:
    """ω in quarter turns: within one of the first solution's angle, which its zeros tell."""
    first = np.arctan2(-rows[2] * unit, rows[0])
    first += 2.0 * math.pi * np.round((rows[6] * math.pi - first) / (2.0 * math.pi))
    omega = np.arctan2(rows[1] / unit - rows[2] * unit, rows[0] + rows[3])
    omega += 2.0 * math.pi * np.round((first - omega) / (2.0 * math.pi))
    return np.asarray(omega / (0.5 * math.pi))


# ---------------------------------------------------------------------- polynomials on a line of nodes
def _nodes(a: float, b: float, m: int) -> Array:
    """Zeros of Chebyshev's m-th polynomial on [a, b], ascending."""
    return np.asarray(0.5 * (a + b) - 0.5 * (b - a) * np.cos(math.pi * (np.arange(m) + 0.5) / m))


def _weights(nodes: Array) -> Array:
    """Barycentric weights of nodes as they are in doubles, the largest 1."""
    apart = (nodes[:, None] - nodes) * (4.0 / (nodes[-1] - nodes[0]))  # capacity 1: the products stay near 1
    np.fill_diagonal(apart, 1.0)
    weights = 1.0 / apart.prod(axis=1)
    return np.asarray(weights / np.abs(weights).max())


@cache
def _transform(m: int) -> Array:
    """Coefficients (m,) from values at nodes (m,)."""
    matrix = (2.0 / m) * np.cos(np.arange(m)[:, None] * (math.pi * (1.0 - (np.arange(m) + 0.5) / m)))
    matrix[0] *= 0.5
    return matrix


def _coefficients(values: Array, k: int) -> Array:
    """Along axis k, (m_k, other axes)."""
    return np.tensordot(_transform(values.shape[k]), values, axes=(1, k))


def _wanted(sizes: Array) -> int:
    """Nodes by which coefficients of these sizes come down to rounding: as many as now if they have."""
    m, pairs = len(sizes), np.maximum(sizes[1:], sizes[:-1])  # a function may be even or odd
    last = float(pairs[-1])
    if last <= RESOLVED:
        return m
    rate, more = 0.5 * math.log(max(float(pairs[-3]) / last, 1.0)), 0
    while last > ROUNDED and m + more <= MOST:
        last *= m / (m + more) * math.exp(-rate)  # of an entire function: faster and faster
        more += 1
    return 4 * math.ceil((m + more) / 4)


def _tail(c: Array, slack: float, k: int) -> Array:
    """What τ lacks on the lines along axis k, from its coefficients there: what is beyond, twice, falling by half.

    And what a change ``slack`` of the parameter does to it, in parts of half the range: |T_j'| ≤ j².
    """
    size = np.abs(c)
    beyond = 2.0 * size[-3:].sum(axis=0)
    if slack:
        beyond = beyond + slack * np.tensordot(np.arange(len(c)) ** 2.0, size, axes=1)
    return np.asarray(np.expand_dims(beyond, k))
