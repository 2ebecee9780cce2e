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
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from ..kernels import available
from ..kernels.grid import cardinals, judged, summed, within, zeros_of
from ..kernels.hill import EPS
from ..periodic import PeriodicSystem
from .hill import hill_map
from .precise import TOLERANCE
from .tensor import Region, TensorGrid

__all__ = ["Box", "boxes", "regions"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

FIRST = {1: 24, 2: 24, 3: 16}  # nodes an axis to begin with, for so many axes: most grids need no others
MOST = 48  # before the axis is cut
GAIN = 4  # points a node: fewer are as fast solved directly
LEAST = 4096  # points of a box of several axes: an attempt takes as long as solving so many
AT_ONCE = 16384  # nodes solved at once, of several places
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
    """A region with its nodes; b are its places on the axes without.

    Attributes
    ----------
    nodes, weights : tuple of (m_k,)
        Of each axis, in barycentric form.
    values : (7, b, m_0, …)
        :data:`~floquet.kernels.grid.FIELDS` at the nodes.
    units : (b,)
        Lengths that make y' comparable with y.
    alpha_errors : (b,)
        Bounds of α between the nodes, beyond the rounding of α itself.
    panels : (b,)
        Of each node.
    """

    region: Region
    nodes: tuple[Array, ...]
    weights: tuple[Array, ...]
    values: Array
    units: Array
    alpha_errors: Array
    panels: NDArray[np.int64]

    def at(self, which: Places) -> Box:
        """Some of the places."""
        return replace(
            self,
            region=self.region.at(which),
            values=self.values[:, which],
            units=self.units[which],
            alpha_errors=self.alpha_errors[which],
            panels=self.panels[which],
        )


def regions(grid: TensorGrid) -> Iterator[Region]:
    """All of a grid, as many places on the axes without nodes at a time as have the nodes of one batch."""
    axes = len(grid.axes)
    return grid.regions(max(AT_ONCE // FIRST[axes] ** axes, 1))


def boxes(region: Region) -> list[Box]:
    """Boxes of a region."""
    axes = len(region.spans)
    return list(_boxes(region, (FIRST[axes],) * axes, ATTEMPTS, LEAST if axes > 1 else 0))


def _boxes(region: Region, counts: tuple[int, ...], attempts: int, least: int) -> Iterator[Box]:
    """``least`` points are worth nodes."""
    if region.points < max(least, GAIN * math.prod(counts)) or not region.long:
        return
    tried = Attempt(region, counts)
    for verdict, which in tried.verdicts():
        some = region.at(which)
        if verdict is None:
            yield tried.box.at(which)
        elif isinstance(verdict, tuple) and attempts > 1:
            yield from _boxes(some, verdict, attempts - 1, least)
        else:
            k = verdict if isinstance(verdict, int) else int(np.argmax(counts))
            for half in some.cut(k):
                yield from _boxes(half, (FIRST[len(counts)],) * len(counts), ATTEMPTS, least)


#: What comes of a place: a box, an attempt with so many nodes an axis, or a cut of an axis.
Verdict = None | tuple[int, ...] | int


class Attempt:
    """So many nodes an axis on a region, solved together with some of its points."""

    def __init__(self, region: Region, counts: tuple[int, ...]) -> None:
        self.counts = counts
        self.nodes = tuple(_nodes(x[0], x[-1], m) for x, m in zip(region.values, counts, strict=True))
        self.spots = _spots(region)
        mesh = tuple(x.ravel() for x in np.meshgrid(*self.nodes, indexing="ij"))
        self.system = _system(region, self.spots, mesh)
        b, spots = len(region), len(self.spots[0])
        phi = hill_map(self.system, precise=False, compiled=available(), alike=spots + len(mesh[0]))
        assert phi.rows is not None
        rows = phi.rows.reshape(-1, b, spots + len(mesh[0]))
        self.good = np.all(np.isfinite(rows), axis=(0, 2)) & np.all(rows[7] == 0.0, axis=1)
        self.direct, rows = np.split(np.where(self.good[:, None], rows, 0.0), [spots], axis=2)
        units = _units(rows)
        self.direct_alpha, alpha = np.split(np.asarray(phi.mean).reshape(b, -1), [spots], axis=1)
        values = np.stack([*rows[:4], _quarters(rows, units[:, None]), alpha, rows[4]])
        self.values = values.reshape(-1, b, *counts)
        self.box = Box(
            region=region,
            nodes=self.nodes,
            weights=tuple(_weights(x) for x in self.nodes),
            values=np.concatenate([self.values[:-1], self._bound(region)[None]]),
            units=units,
            alpha_errors=self._alpha_errors(region),
            panels=phi.panels.reshape(b, -1).max(axis=1).astype(np.int64),
        )

    def _bound(self, region: Region) -> Array:
        """Of τ at the nodes: their own, of rounding, and on the lines through them."""
        tau = 0.5 * (self.values[0] + self.values[3])
        bound = self.values[6] + ROUNDING * EPS * np.abs(tau)
        for k, (axis, x) in enumerate(zip(region.grid.axes, self.nodes, strict=True), start=1):
            bound = bound + _tail(_coefficients(tau, k), 2.0 * axis.slack / (x[-1] - x[0]), k)
        return np.asarray(bound)

    def _alpha_errors(self, region: Region) -> Array:
        """Of α at the nodes and on the lines through them, times the most that weights of nodes add up to."""
        alpha = self.values[5]
        largest = np.abs(alpha).reshape(len(alpha), -1).max(axis=1)
        error, weights = 4.0 * EPS * largest, 1.0
        for k, (axis, x) in enumerate(zip(region.grid.axes, self.nodes, strict=True), start=1):
            tail = _tail(_coefficients(alpha, k), 2.0 * axis.slack / (x[-1] - x[0]), k)
            error = error + tail.reshape(len(alpha), -1).max(axis=1)
            between = np.concatenate([region.values[k - 1][[0, -1]], 0.5 * (x[1:] + x[:-1])])
            weights *= 1.1 * np.abs(cardinals(between, x, _weights(x))).sum(axis=1).max()
        return np.asarray(weights * error)

    def verdicts(self) -> Iterator[tuple[Verdict, Places]]:
        """What comes of the places, those of one kind together."""
        kinds: dict[Verdict, list[int]] = {}
        more = tuple(m + 8 for m in self.counts)
        wanted, turns, agrees, rough = self.wanted, self.turns_known, self.agrees, self.rough
        for i, counts in enumerate(map(tuple, wanted.tolist())):
            verdict: Verdict
            if max(counts) > MOST:
                verdict = int(np.argmax(counts))
            elif counts != self.counts:
                verdict = counts
            elif not turns[i]:
                verdict = int(np.argmax(self.counts))
            elif not agrees[i]:
                verdict = more
            elif rough[i]:
                verdict = int(self.steepest[i])
            else:
                verdict = None
            kinds.setdefault(verdict, []).append(i)
        return ((verdict, np.array(places, np.intp)) for verdict, places in kinds.items())

    @cached_property
    def wanted(self) -> NDArray[np.int64]:
        """Nodes an axis (b, axes) that bring the last coefficients down to rounding; too many where they do not fall.

        Too many where motions are beyond the doubles, or kinks are not declared, too.
        """
        found = np.stack([_wanted(self._falling(k)) for k in range(len(self.counts))], axis=1)
        return np.where(self.good[:, None], found, MOST + 1)

    def _falling(self, k: int) -> Array:
        """Sizes (m_k, b) of the coefficients along axis k: of Φ relative to the largest on a line, and of α."""
        tiny, ones, m = np.finfo(float).tiny, [1] * len(self.counts), self.counts[k]
        scale = np.stack(
            [np.ones_like(self.box.units), 1.0 / self.box.units, self.box.units, np.ones_like(self.box.units)]
        )
        phi, alpha = self.values[:4] * scale.reshape(4, -1, *ones), self.values[5]
        of_phi = np.abs(_coefficients(phi, k + 2)).max(axis=1) / np.maximum(np.abs(phi).max(axis=(0, k + 2)), tiny)
        largest = np.abs(alpha).reshape(len(alpha), -1).max(axis=1)
        of_alpha = np.abs(_coefficients(alpha, k + 1)) / np.maximum(largest, tiny).reshape(-1, *ones[1:])
        return np.maximum(of_phi, of_alpha).reshape(m, len(alpha), -1).max(axis=2)

    @property
    def turns_known(self) -> NDArray[np.bool_]:
        """Where ω is resolved."""
        last = [np.abs(_coefficients(self.values[4], k)[-2:]).max(axis=0) for k in range(1, len(self.counts) + 1)]
        return np.all([x.reshape(len(x), -1).max(axis=1) <= TURNING for x in last], axis=0)

    @property
    def agrees(self) -> NDArray[np.bool_]:
        """Where the direct points lie within the bounds of both, on the same branch."""
        box, rows = self.box, self.direct
        signed, bound = box.values[:-1], box.values[-1:]
        for k, (x, i) in enumerate(zip(box.region.values, self.spots, strict=True)):
            e = cardinals(x[i], box.nodes[k], box.weights[k])
            signed, bound = _at_spots(e, signed, first=not k), _at_spots(np.abs(e), bound, first=not k)
        m, quarters, tau_error = tuple(signed[:4]), signed[4], bound[0]
        D, b = judged(m, tau_error)
        zeros, certain = zeros_of(m, quarters, box.units[:, None])
        near = np.abs(0.5 * (m[0] + m[3]) - 0.5 * (rows[0] + rows[3])) <= tau_error + rows[4]
        near &= np.abs(signed[5] - self.direct_alpha) <= box.alpha_errors[:, None]
        return np.all(near & (np.abs(D - rows[8]) <= b + rows[5]) & ((zeros == rows[6]) | ~certain), axis=1)

    @property
    def rough(self) -> NDArray[np.bool_]:
        """Where many points have wide bounds, as midway between the nodes of all axes, where bounds are widest."""
        box = self.box
        tau, bound = 0.5 * (box.values[0] + box.values[3]), box.values[6]
        for k, (x, weights) in enumerate(zip(box.nodes, box.weights, strict=True), start=1):
            e = cardinals(0.5 * (x[1:] + x[:-1]), x, weights)
            tau, bound = np.moveaxis(summed(e, tau, k), 0, k), np.moveaxis(summed(np.abs(e), bound, k), 0, k)
        D, b = tau * tau - 1.0, (2.0 * np.abs(tau) + bound) * bound
        wide = [~within(D, b, bound, most, self.system.period).reshape(len(D), -1) for most, _ in ROUGH]
        return np.any(
            [w.mean(axis=1) * box.region.points > many for w, (_, many) in zip(wide, ROUGH, strict=True)], axis=0
        )

    @cached_property
    def steepest(self) -> NDArray[np.intp]:
        """The axis along which motions grow most: by the mean bounds of its two halves."""
        w = self.box.values[-1]
        halves = [[h.reshape(len(w), -1).mean(axis=1) for h in np.array_split(w, 2, axis=k)] for k in range(1, w.ndim)]
        with np.errstate(divide="ignore", invalid="ignore"):  # places that are not good have no bounds
            return np.argmax([np.abs(np.log(a / b)) for a, b in halves], axis=0)


def _system(region: Region, spots: tuple[Places, ...], mesh: tuple[Array, ...]) -> PeriodicSystem:
    """Points and nodes as cases along one axis."""
    system = region.grid.system
    assert system.equation is not None
    d, k = system.equation.build(region.parameters(spots, mesh))
    return replace(system, damping=d, stiffness=k, equation=None, blade=None)


def _spots(region: Region) -> tuple[Places, ...]:
    """Index of the corners of a region and of some points within, the same ones every time."""
    rng = np.random.default_rng([i for span in region.spans for i in (span.start, span.stop)])
    corners = itertools.product(*((0, n - 1) for n in region.lengths))
    within_it = zip(*(rng.integers(0, n, SPOTS) for n in region.lengths), strict=True)
    return tuple(np.array(i, np.intp) for i in zip(*corners, *within_it, strict=True))


def _units(rows: Array) -> Array:
    """Lengths that make Φ₁₂ and Φ₂₁ of one size, (b,)."""
    above, below = np.abs(rows[1]).sum(axis=-1), np.abs(rows[2]).sum(axis=-1)
    known = (above > 0.0) & (below > 0.0)
    return np.sqrt(np.divide(above, below, out=np.ones_like(above), where=known))


def _quarters(rows: Array, unit: Array) -> Array:
    """ω in quarter turns: within one of the first solution's angle, which its zeros tell."""
    first = np.arctan2(-rows[2] * unit, rows[0])
    first += 2.0 * math.pi * np.round((rows[6] * math.pi - first) / (2.0 * math.pi))
    omega = np.arctan2(rows[1] / unit - rows[2] * unit, rows[0] + rows[3])
    omega += 2.0 * math.pi * np.round((first - omega) / (2.0 * math.pi))
    return np.asarray(omega / (0.5 * math.pi))


def _at_spots(e: Array, values: Array, *, first: bool) -> Array:
    """Fields (f, b, s, …) at spots from those at an axis' nodes, (f, b, m, …) or, after the first, (f, b, s, m, …)."""
    if first:
        return np.moveaxis(summed(e, values, 2), 0, 2)
    total = np.zeros((*values.shape[:3], *values.shape[4:]))
    for j in range(e.shape[1]):
        total += e[:, j].reshape(-1, *[1] * (values.ndim - 4)) * values[:, :, :, j]
    return total


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
    return summed(_transform(values.shape[k]), values, k)


def _wanted(sizes: Array) -> NDArray[np.int64]:
    """Nodes by which coefficients of these sizes (m, b) come down to rounding: as many as now if they have."""
    m, pairs = len(sizes), np.maximum(sizes[1:], sizes[:-1])  # a function may be even or odd
    out = np.full(sizes.shape[1], m)
    for i in np.flatnonzero(~(pairs[-1] <= RESOLVED)):
        last = float(pairs[-1, i])
        rate, more = 0.5 * math.log(max(float(pairs[-3, i]) / last, 1.0)), 0
        while last > ROUNDED and m + more <= MOST:
            last *= m / (m + more) * math.exp(-rate)  # of an entire function: faster and faster
            more += 1
        out[i] = 4 * math.ceil((m + more) / 4)
    return out


def _tail(c: Array, slack: float, k: int) -> Array:
    """What τ lacks on the lines along axis k, from its coefficients there: what is beyond, twice, falling by half.

    And what a change ``slack`` of the parameter does to it, in parts of half the range: |T_j'| ≤ j².
    """
    size = np.abs(c)
    beyond = 2.0 * size[-3:].sum(axis=0)
    if slack:
        beyond = beyond + slack * summed(np.arange(float(len(c)))[None] ** 2, size, 0)[0]
    return np.asarray(np.expand_dims(beyond, k))
