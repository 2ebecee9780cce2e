"""One scalar equation over a tensor grid of parameters: Φ at Chebyshev nodes, polynomials between them.

The entries of Φ are entire functions of the coefficients of q, and these are smooth functions of the parameters, so that
twenty nodes an axis carry a grid of a thousand values an axis.  An axis of the grid can carry nodes where one parameter
varies along it, or several that are straight functions of one (ε and m = 1.5 ε); the grid is gone through value by
value along the others.

A box of the grid is tried with some nodes an axis.  With c_k the coefficients of Chebyshev polynomials along a line of
nodes, it is taken when the last c_k are the rounding of the nodes, and when points solved directly (its corners, and
others at random) lie within the bounds; else there are more nodes, or the box is cut in two, or its points are left to
be solved one by one.  So are single points with bounds above :data:`~floquet.period_map.precise.TOLERANCE`, which lie
next to branch points, or whose branch is in doubt.  See :mod:`floquet.kernels.grid` for the polynomials, the bounds and
the branch.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import available
from ..kernels.grid import FIELDS, Tile, cardinals, judged, tile_rows, zeros_of
from ..kernels.hill import EPS, ROWS
from ..periodic import PeriodicSystem
from .hill import hill_form, hill_map
from .precise import TOLERANCE
from .result import Method, PeriodMap

__all__ = ["Box", "TensorGrid", "boxes", "grid_map", "left_out", "tiles"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

FIRST, MOST = 16, 48  # nodes an axis: to begin with, and before the axis is cut
LEAST = 4096  # points of a box: its nodes cost as much as so many points solved directly
GAIN = 4  # points a node: fewer are as fast solved directly
RESOLVED = 2e-15  # of the last coefficients, relative to the largest entry on their line: ten times their rounding
RATE = 0.2  # nepers a node: coefficients that fall more slowly than by a fifth have a kink, not a tail
ROUNDING = 8.0  # eps of τ: twenty products a polynomial, rounded at random
AFFINE = 8.0  # eps: values that were computed as straight functions of one another
NARROW = 1e-9  # relative length of an axis: its nodes must be apart in doubles
TURNING = 0.3  # quarter turns in the last coefficients of ω, ten times as many beyond: it is wanted to within one
ATTEMPTS = 6
SPOTS = 8  # points solved directly within a box, and its corners
AZIMUTHS = 32  # at which q is looked at for a place to begin


# ---------------------------------------------------------------------- the grid
@dataclass(frozen=True, eq=False, kw_only=True)
class Axis:
    """An axis of the cases that carries nodes.

    Attributes
    ----------
    place : int
        Among the axes of the cases.
    parameter : str
        The one whose values are ``values`` (n,), ascending, at the places ``order`` (n,) of the axis.
    slack : float
        How far others are from straight functions of it, as a change of it: in parts of half the range.
    """

    place: int
    parameter: str
    order: Places
    values: Array
    slack: float


@dataclass(frozen=True, eq=False, kw_only=True)
class TensorGrid:
    """A system whose parameters are a tensor grid; they have as many axes as the cases, of length 1 where constant."""

    system: PeriodicSystem
    shape: tuple[int, ...]
    parameters: Mapping[str, NDArray[Any]]
    axes: tuple[Axis, ...]

    @staticmethod
    def of(system: PeriodicSystem) -> TensorGrid | None:
        """None where nodes would not pay."""
        if system.constant or system.equation is None or system.degrees != 1:
            return None
        shape = system.cases
        if math.prod(shape) < LEAST:
            return None
        parameters = {name: _collapsed(p, len(shape)) for name, p in system.equation.parameters.items()}
        found = [_axis(parameters, k) for k in range(len(shape)) if shape[k] >= 2 * FIRST]
        axes = [axis for axis in found if axis is not None]
        longest = sorted(axes, key=lambda axis: -len(axis.values))[:3]
        chosen = tuple(axis for axis in axes if axis in longest)
        if not chosen:
            return None
        return TensorGrid(system=system, shape=shape, parameters=parameters, axes=chosen)

    def whole(self) -> Iterator[Region]:
        """All of the grid, for every place on the axes without nodes."""
        carrying = {axis.place for axis in self.axes}
        ranges = [range(1 if k in carrying else n) for k, n in enumerate(self.shape)]
        spans = tuple(slice(0, len(axis.values)) for axis in self.axes)
        return (Region(self, fixed, spans) for fixed in itertools.product(*ranges))


def _collapsed(values: NDArray[Any], axes: int) -> NDArray[Any]:
    """The same values with length 1 along axes on which they are constant."""
    values = values.reshape((1,) * (axes - values.ndim) + values.shape)
    for k in range(axes):
        if values.shape[k] > 1 and np.all(values == (first := values.take([0], axis=k))):
            values = first
    return values


def _axis(parameters: Mapping[str, NDArray[Any]], place: int) -> Axis | None:
    """An axis, if one parameter tells all others that vary along it."""
    varying = {name: p for name, p in parameters.items() if p.shape[place] > 1}
    name = next((name for name, p in varying.items() if p.size == p.shape[place]), None)
    if name is None:
        return None
    x = varying[name].ravel()
    order = np.argsort(x, kind="stable")
    values = x[order]
    length = values[-1] - values[0]
    if not length > NARROW * np.abs(values).max():
        return None
    slack = 0.0
    for other in (np.moveaxis(p, place, -1) for key, p in varying.items() if key != name):
        first, last = other[..., order[:1]], other[..., order[-1:]]
        off, size = np.abs(other - _between(first, last, (x - values[0]) / length)).max(), np.abs(other).max()
        if not off <= AFFINE * EPS * size:
            return None
        slack = max(slack, 2.0 * float(off + 2.0 * EPS * size) / float(np.abs(last - first).max()))
    return Axis(place=place, parameter=name, order=order, values=values, slack=slack)


def _between(first: Any, last: Any, t: Any) -> Any:
    """The straight function that is ``first`` at t = 0, ``last`` at 1."""
    return first + (last - first) * t


@dataclass(frozen=True)
class Region:
    """A part of a grid: one place on every axis without nodes, and a span of the values on every axis with nodes."""

    grid: TensorGrid
    fixed: tuple[int, ...]
    spans: tuple[slice, ...]

    @property
    def lengths(self) -> tuple[int, ...]:
        """Values an axis."""
        return tuple(span.stop - span.start for span in self.spans)

    @property
    def values(self) -> tuple[Array, ...]:
        """Of the parameter of each axis, ascending."""
        return tuple(axis.values[span] for axis, span in zip(self.grid.axes, self.spans, strict=True))

    @property
    def slacks(self) -> tuple[float, ...]:
        """The axes' slack in parts of half the region's range."""
        wholes = [axis.values[-1] - axis.values[0] for axis in self.grid.axes]
        parts = [x[-1] - x[0] for x in self.values]
        return tuple(a.slack * w / p for a, w, p in zip(self.grid.axes, wholes, parts, strict=True))

    def worth(self, counts: tuple[int, ...]) -> bool:
        """Whether so many nodes an axis are cheaper than all points."""
        points = math.prod(self.lengths)
        apart = all(x[-1] - x[0] > NARROW * max(abs(x[0]), abs(x[-1])) for x in self.values)
        return apart and points >= max(LEAST, GAIN * math.prod(counts))

    def cut(self, k: int) -> list[Region]:
        """Two regions, cut in the middle of the range of axis k."""
        x, span = self.values[k], self.spans[k]
        middle = span.start + int(np.searchsorted(x, 0.5 * (x[0] + x[-1])))
        halves = (slice(span.start, middle), slice(middle, span.stop))
        return [replace(self, spans=(*self.spans[:k], half, *self.spans[k + 1 :])) for half in halves]

    def places(self) -> tuple[int, tuple[Places, ...]]:
        """Place of the first point among all cases, and what the values of each axis add to it."""
        steps = [math.prod(self.grid.shape[k + 1 :]) for k in range(len(self.grid.shape))]
        first = sum(i * step for i, step in zip(self.fixed, steps, strict=True))
        added = [axis.order[s] * steps[axis.place] for axis, s in zip(self.grid.axes, self.spans, strict=True)]
        return first, tuple(added)

    def points(self, index: tuple[Places, ...]) -> dict[str, NDArray[Any]]:
        """Parameters of some points (s,), by their index in the span of each axis."""
        where: list[Any] = list(self.fixed)
        for axis, span, i in zip(self.grid.axes, self.spans, index, strict=True):
            where[axis.place] = axis.order[span][i]
        return {
            name: p[tuple(0 if n == 1 else i for n, i in zip(p.shape, where, strict=True))]
            for name, p in self.grid.parameters.items()
        }

    def between(self, coordinates: tuple[Array, ...]) -> dict[str, NDArray[Any]]:
        """Parameters at places (s,) between the points."""
        ends = [(axis.order[s.start], axis.order[s.stop - 1]) for axis, s in zip(self.grid.axes, self.spans, strict=True)]
        parts = [(x - v[0]) / (v[-1] - v[0]) for x, v in zip(coordinates, self.values, strict=True)]
        own = {axis.parameter: x for axis, x in zip(self.grid.axes, coordinates, strict=True)}

        def value(p: NDArray[Any], where: list[int], k: int) -> Any:
            if k == len(ends):
                return p[tuple(0 if n == 1 else i for n, i in zip(p.shape, where, strict=True))]
            place = self.grid.axes[k].place
            if p.shape[place] == 1:
                return value(p, where, k + 1)
            first, last = (value(p, [*where[:place], end, *where[place + 1 :]], k + 1) for end in ends[k])
            return _between(first, last, parts[k])

        return {
            name: own[name] if name in own else np.asarray(value(p, list(self.fixed), 0))
            for name, p in self.grid.parameters.items()
        }


# ---------------------------------------------------------------------- polynomials
@dataclass(frozen=True, eq=False, kw_only=True)
class Box:
    """A region with its nodes.

    Attributes
    ----------
    nodes, weights : tuple of (m_k,)
        Of each axis, in barycentric form.
    values : (m_0, 7, m_1) or (m_0, 7, m_1, m_2)
        :data:`~floquet.kernels.grid.FIELDS` at the nodes; m_0 = 1 for a region of one axis.
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Attempt:
    """A box, and whether it is good: nodes ``wanted`` an axis, turns known, direct points within the bounds."""

    box: Box
    wanted: tuple[int, ...]
    turns: bool
    agrees: bool
    highest: float


def boxes(region: Region) -> list[Box]:
    """Boxes of a region; what they leave out is to be solved point by point."""
    counts, begin = (FIRST,) * len(region.spans), 0.0
    for _ in range(ATTEMPTS):
        if not region.worth(counts):
            return []
        tried = _attempt(region, counts, begin)
        if max(tried.wanted) > MOST:
            break
        if any(w > m for w, m in zip(tried.wanted, counts, strict=True)):
            counts = tuple(max(w, m) for w, m in zip(tried.wanted, counts, strict=True))
        elif not tried.turns:
            if begin or (begin := tried.highest) == 0.0:
                break
        elif tried.agrees:
            return [tried.box]
        else:
            counts = tuple(m + 8 for m in counts)
    return [box for half in region.cut(int(np.argmax(tried.wanted))) for box in boxes(half)]


def _attempt(region: Region, counts: tuple[int, ...], begin: float) -> Attempt:
    """Solve the nodes and the direct points of a region, and look."""
    nodes = tuple(_nodes(x[0], x[-1], m) for x, m in zip(region.values, counts, strict=True))
    mesh = tuple(x.ravel() for x in np.meshgrid(*nodes, indexing="ij"))
    spots = _spots(region)
    rows, alpha, panels, highest = _solved(region, mesh, spots, begin)
    n, size = len(mesh[0]), counts if len(counts) > 1 else (1, *counts)
    if not (np.all(np.isfinite(rows)) and np.all(rows[7] == 0.0)):  # motions beyond the doubles, or kinks not declared
        rows = np.where(np.isfinite(rows), rows, 0.0)
        wanted = (MOST + 1,) * len(counts)
    else:
        wanted = ()
    unit = _unit(rows)
    values = np.stack([*rows[:4, :n], _quarters(rows[:, :n], unit), alpha[:n], rows[4, :n]]).reshape(-1, *counts)
    wanted = wanted or tuple(_wanted(values, unit, k) for k in range(len(counts)))
    turns = all(np.abs(_coefficients(values[4], k)[-2:]).max() <= TURNING for k in range(len(counts)))
    tau = 0.5 * (values[0] + values[3])
    values[6] += ROUNDING * EPS * np.abs(tau)
    for k, slack in enumerate(region.slacks):
        values[6] += _tail(_coefficients(tau, k), slack, k)
    box = Box(
        region=region,
        nodes=nodes,
        weights=tuple(_weights(x) for x in nodes),
        values=np.ascontiguousarray(np.moveaxis(values.reshape(-1, *size), 0, 1)),
        unit=unit,
        panels=panels,
    )
    return Attempt(box=box, wanted=wanted, turns=turns, agrees=_agrees(box, spots, rows[:, n:]), highest=highest)


def _solved(
    region: Region, mesh: tuple[Array, ...], spots: tuple[Places, ...], begin: float
) -> tuple[Array, Array, int, float]:
    """Rows and α of nodes and direct points, for periods that begin at ``begin``; and the azimuth where q is largest."""
    system, direct, between = region.grid.system, region.points(spots), region.between(mesh)
    assert system.equation is not None
    n, s = len(mesh[0]), len(spots[0])
    joined = {
        name: np.concatenate([np.broadcast_to(between[name], n), np.broadcast_to(direct[name], s)])
        if np.ndim(between[name]) else between[name]
        for name in between
    }  # fmt: skip
    d, k = system.equation.build(joined)
    if begin:
        d, k = d.shifted(begin), k.shifted(begin)
    part = replace(system, damping=d, stiffness=k, equation=None)
    phi = hill_map(part, compiled=available(), nodes=True)
    assert phi.rows is not None
    return phi.rows, phi.mean, int(phi.panels.max()), _highest(part) if k.edges is None else 0.0


def _highest(system: PeriodicSystem) -> float:
    """Azimuth where q is largest: between there and the next, motions turn first and grow then, not the reverse."""
    q = hill_form(system)[0]
    azimuths = np.arange(AZIMUTHS) * (system.period / AZIMUTHS)
    return float(azimuths[np.argmax(q.sample(azimuths)[..., 0, 0].reshape(-1, AZIMUTHS).sum(axis=0))])


def _spots(region: Region) -> tuple[Places, ...]:
    """Index of the corners of a region and of some points within, the same ones every time."""
    rng = np.random.default_rng([*region.fixed, *(i for span in region.spans for i in (span.start, span.stop))])
    corners = itertools.product(*((0, n - 1) for n in region.lengths))
    within = zip(*(rng.integers(0, n, SPOTS) for n in region.lengths), strict=True)
    return tuple(np.array(i, np.intp) for i in zip(*corners, *within, strict=True))


def _agrees(box: Box, spots: tuple[Places, ...], rows: Array) -> bool:
    """Whether direct points lie within the bounds of both, on the same branch."""
    across = [
        cardinals(x[i], nodes, weights)
        for x, i, nodes, weights in zip(box.region.values, spots, box.nodes, box.weights, strict=True)
    ]
    values = np.moveaxis(box.values, 1, 0)
    if len(across) == 1:
        values = values[:, 0]
    signed, bound = values[:-1], values[-1]
    for k, e in enumerate(across):
        subscripts = ("sa,fa...->fs...", "sa,fsa...->fs...")[k > 0]
        signed = np.einsum(subscripts, e, signed)
        bound = np.einsum(subscripts, np.abs(e), bound[None] if k == 0 else bound)
    m, quarters, tau_error = tuple(signed[:4]), signed[4], bound[0]
    D, b = judged(m, tau_error)
    zeros, certain = zeros_of(m, quarters, box.unit)
    near = np.abs(0.5 * (m[0] + m[3]) - 0.5 * (rows[0] + rows[3])) <= tau_error + rows[4]
    return bool(np.all(near & (np.abs(D - rows[8]) <= b + rows[5]) & ((zeros == rows[6]) | ~certain)))


# ---------------------------------------------------------------------- Chebyshev's polynomials on a line of nodes
def _nodes(a: float, b: float, m: int) -> Array:
    """Zeros of the m-th polynomial on [a, b], ascending."""
    return np.asarray(0.5 * (a + b) - 0.5 * (b - a) * np.cos(math.pi * (np.arange(m) + 0.5) / m))


def _weights(nodes: Array) -> Array:
    """Barycentric weights of nodes as they are in doubles, the largest 1."""
    apart = (nodes[:, None] - nodes) * (4.0 / (nodes[-1] - nodes[0]))  # of capacity 1: the products neither grow nor fall
    np.fill_diagonal(apart, 1.0)
    weights = 1.0 / apart.prod(axis=1)
    return np.asarray(weights / np.abs(weights).max())


@cache
def _transform(m: int) -> Array:
    """Coefficients (m,) from values at nodes (m,)."""
    k, angle = np.arange(m), math.pi * (1.0 - (np.arange(m) + 0.5) / m)
    matrix = (2.0 / m) * np.cos(k[:, None] * angle)
    matrix[0] *= 0.5
    return matrix


def _coefficients(values: Array, k: int) -> Array:
    """Along axis k of the nodes, (m_k, ...); leading axes may be fields."""
    return np.tensordot(_transform(values.shape[k]), values, axes=(1, k))


def _wanted(values: Array, unit: float, k: int) -> int:
    """Nodes on axis k that bring the last coefficients down to rounding, of Φ on the scale of its line and of α."""
    phi = values[:4] * np.array([1.0, 1.0 / unit, unit, 1.0]).reshape(4, *([1] * (values.ndim - 1)))
    alpha, m = values[5:6], values.shape[k + 1]
    size = np.maximum(np.abs(phi).max(axis=(0, k + 1)), np.finfo(float).tiny)
    falls = np.abs(_coefficients(phi, k + 1)).max(axis=1) / size
    steady = np.abs(_coefficients(alpha, k + 1)).max(axis=1) / max(float(np.abs(alpha).max()), np.finfo(float).tiny)
    each = np.maximum(falls.reshape(m, -1).max(axis=1), steady.reshape(m, -1).max(axis=1))
    pairs = np.maximum(each[1:], each[:-1])  # a function may be even or odd
    last = float(pairs[-1])
    if last <= RESOLVED:
        return m
    rate = 0.5 * math.log(max(float(pairs[-3]) / last, 1.0))
    return MOST + 1 if rate < RATE else 4 * math.ceil((m + 1 + math.log(last / RESOLVED) / rate) / 4)


def _tail(c: Array, slack: float, k: int) -> Array:
    """What τ lacks along axis k, of its coefficients there: twice what is beyond the last, which fall by half or more.

    And what a change ``slack`` of the parameter makes: |T_j'| ≤ j².
    """
    size = np.abs(c)
    beyond = 2.0 * size[-3:].sum(axis=0)
    if slack:
        beyond = beyond + slack * np.tensordot(np.arange(len(c)) ** 2.0, size, axes=1)
    return np.asarray(np.expand_dims(beyond, k))


def _unit(rows: Array) -> float:
    """Length that makes Φ₁₂ and Φ₂₁ of one size."""
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = float(np.sqrt(np.abs(rows[1]).sum() / np.abs(rows[2]).sum()))
    return unit if 0.0 < unit < math.inf else 1.0


def _quarters(rows: Array, unit: float) -> Array:
    """ω in quarter turns: within one of the first solution's angle, which its zeros tell."""
    first = np.arctan2(-rows[2] * unit, rows[0])
    first += 2.0 * math.pi * np.round((rows[6] * math.pi - first) / (2.0 * math.pi))
    omega = np.arctan2(rows[1] / unit - rows[2] * unit, rows[0] + rows[3])
    omega += 2.0 * math.pi * np.round((first - omega) / (2.0 * math.pi))
    return np.asarray(omega / (0.5 * math.pi))


# ---------------------------------------------------------------------- all points
ROWS_A_TILE = 64  # the polynomials of the columns are made once for them
POINTS_A_TILE = 65536


def tiles(box: Box) -> Iterator[Tile]:
    """The points of a box, some at a time."""
    region, T = box.region, box.region.grid.system.period
    first, added = region.places()
    x, nodes, weights = region.values, box.nodes, box.weights
    if len(x) == 1:
        one = np.zeros(1)
        yield from _cut(box.values, (one, *x), (one, *nodes), (one + 1.0, *weights), (one.astype(np.intp), *added), first, box)
    elif len(x) == 2:
        yield from _cut(box.values, x, nodes, weights, added, first, box)
    else:
        for value, place in zip(x[0], added[0], strict=True):
            plane = _plane(box, value)
            yield from _cut(plane, x[1:], nodes[1:], weights[1:], added[1:], first + int(place), box)


def _plane(box: Box, value: float) -> Array:
    """The values of a box of three axes at one place of the first, (m_1, 7, m_2)."""
    e = cardinals(np.array([value]), box.nodes[0], box.weights[0])[0]
    weight = np.multiply.outer(e, np.ones(len(FIELDS)))
    weight[:, -1] = np.abs(e)
    plane = np.einsum("af,afbc->bfc", weight, box.values)
    return np.ascontiguousarray(plane)


def _cut(
    values: Array,
    x: tuple[Array, ...],
    nodes: tuple[Array, ...],
    weights: tuple[Array, ...],
    added: tuple[Places, ...],
    first: int,
    box: Box,
) -> Iterator[Tile]:
    rows = min(len(x[0]), ROWS_A_TILE)
    columns = max(POINTS_A_TILE // rows, 1024)
    for i in range(0, len(x[0]), rows):
        for j in range(0, len(x[1]), columns):
            some, part = slice(i, i + rows), slice(j, j + columns)
            yield Tile(
                values=values,
                x=x[0][some],
                x_nodes=nodes[0],
                x_weights=weights[0],
                z=x[1][part],
                z_nodes=nodes[1],
                z_weights=weights[1],
                row_places=first + added[0][some],
                column_places=added[1][part],
                unit=box.unit,
                period=box.region.grid.system.period,
                most=TOLERANCE,
            )


def grid_map(system: PeriodicSystem) -> PeriodMap:
    """The map of all cases: between nodes where that pays, directly elsewhere."""
    grid, shape = TensorGrid.of(system), system.cases
    n = math.prod(shape)
    rows, alpha, panels = np.empty((len(ROWS), n)), np.empty(n), np.zeros(n, np.int32)
    methods = np.full(n, Method.HILL, np.int8)
    for box in () if grid is None else (box for region in grid.whole() for box in boxes(region)):
        for tile in tiles(box):
            places = (tile.row_places[:, None] + tile.column_places).ravel()
            rows[:, places], alpha[places], kept = tile_rows(tile)
            panels[places] = box.panels
            methods[places[kept]] = Method.MAP
    if (rest := np.flatnonzero(methods == Method.HILL)).size:
        phi = left_out(system, rest)
        assert phi.rows is not None and phi.methods is not None
        rows[:, rest], alpha[rest], panels[rest], methods[rest] = phi.rows, phi.mean, phi.panels, phi.methods
    return PeriodMap(
        method=Method.MAP, period=system.period, shape=shape, mean=alpha, panels=panels, rows=rows, methods=methods
    )


def left_out(system: PeriodicSystem, index: Places) -> PeriodMap:
    """The map of some cases, an index along all of them, directly."""
    return hill_map(system.part(index), compiled=available())
