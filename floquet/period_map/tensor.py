"""Tensor grids of parameters: which axes can carry nodes, and the parameters at points and between them.

An axis of the cases can carry nodes where one parameter varies along it, or several that are straight functions of one
(ε and m = 1.5 ε).  Values may be in any order and repeat.  Along the others every place has nodes of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.hill import EPS
from ..periodic import PeriodicSystem

__all__ = ["Axis", "Region", "TensorGrid"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

LEAST = 4096  # points: nodes cost as much as so many points solved directly
SHORTEST = 32  # values on an axis: twice the nodes that it takes at the least
MOST_AXES = 3
AFFINE = 8.0  # eps: values that were computed as straight functions of one another
NARROW = 1e-9  # relative length of an axis: nodes on it must be apart in doubles


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
        How far others are from straight functions of it, as a change of it.
    """

    place: int
    parameter: str
    order: Places
    values: Array
    slack: float

    @staticmethod
    def of(parameters: Mapping[str, NDArray[Any]], place: int, *, alone: bool = False) -> Axis | None:
        """None if no one parameter tells all others that vary along the axis; ``alone``, wherever on other axes."""
        varying = {name: p for name, p in parameters.items() if p.shape[place] > 1}
        name = next((name for name, p in varying.items() if p.size == p.shape[place]), None)
        if name is None:
            return None
        x = varying[name].ravel()
        order = np.argsort(x, kind="stable")
        values = x[order]
        if not _long(values):
            return None
        length, slack = values[-1] - values[0], 0.0
        for other in (np.moveaxis(p, place, -1) for key, p in varying.items() if key != name):
            if alone and other.size > len(x):
                return None
            first, last = other[..., order[:1]], other[..., order[-1:]]
            off, size = np.abs(other - between(first, last, (x - values[0]) / length)).max(), np.abs(other).max()
            if not off <= AFFINE * EPS * size:
                return None
            slack = max(slack, length * float((off + 2.0 * EPS * size) / np.abs(last - first).max()))
        return Axis(place=place, parameter=name, order=order, values=values, slack=slack)


@dataclass(frozen=True, eq=False, kw_only=True)
class TensorGrid:
    """A system whose parameters are a tensor grid; they have as many axes as the cases, of length 1 where constant."""

    system: PeriodicSystem
    shape: tuple[int, ...]
    parameters: Mapping[str, NDArray[Any]]
    axes: tuple[Axis, ...]

    @staticmethod
    def of(system: PeriodicSystem, along: str | None = None) -> TensorGrid | None:
        """None for what is no scalar equation on a grid that is worth nodes, or is in pieces.

        Where pieces meet at places that depend on the parameters, Φ is smooth only between certain values of them, and
        polynomials fall too slowly beside those for what they leave out to be told from their last coefficients.

        ``along`` names the one parameter whose axis is to carry nodes.  What becomes of a point then does not depend on
        how many places there are on the other axes.
        """
        if system.constant or system.equation is None or system.degrees != 1:
            return None
        shape = system.cases
        parameters = {name: _collapsed(p, len(shape)) for name, p in system.equation.parameters.items()}
        found = [Axis.of(parameters, k, alone=along is not None) for k in range(len(shape)) if shape[k] >= SHORTEST]
        axes = [axis for axis in found if axis is not None and along in (None, axis.parameter)]
        if (along is None and math.prod(shape) < LEAST) or not axes or _in_pieces(system):
            return None
        longest = sorted(axes, key=lambda axis: -len(axis.values))[:MOST_AXES]
        chosen = tuple(axis for axis in axes if axis in longest)
        return TensorGrid(system=system, shape=shape, parameters=parameters, axes=chosen)

    def regions(self, together: int) -> Iterator[Region]:
        """All of the grid, so many places on the axes without nodes at a time."""
        carrying = {axis.place for axis in self.axes}
        lengths = [1 if k in carrying else n for k, n in enumerate(self.shape)]
        spans = tuple(slice(0, len(axis.values)) for axis in self.axes)
        for start in range(0, math.prod(lengths), together):
            places = np.arange(start, min(start + together, math.prod(lengths)))
            yield Region(self, np.stack(np.unravel_index(places, lengths), axis=1), spans)


def _in_pieces(system: PeriodicSystem) -> bool:
    """Whether the coefficients have edges."""
    stiffness = system.part(np.zeros(1, np.intp)).stiffness
    return stiffness is not None and stiffness.edges is not None


def between(first: Any, last: Any, t: Any) -> Any:
    """The straight function that is ``first`` at t = 0, ``last`` at 1."""
    return first + (last - first) * t


def _long(x: Array) -> bool:
    """Whether there is room for nodes between ascending values."""
    return bool(x[-1] - x[0] > NARROW * max(abs(x[0]), abs(x[-1])))


def _collapsed(values: NDArray[Any], axes: int) -> NDArray[Any]:
    """The same values with length 1 along axes on which they are constant."""
    values = values.reshape((1,) * (axes - values.ndim) + values.shape)
    for k in range(axes):
        if values.shape[k] > 1 and np.all(values == (first := values.take([0], axis=k))):
            values = first
    return values


@dataclass(frozen=True, eq=False)
class Region:
    """A part of a grid: a span of the ascending values of every axis with nodes, at some places on the others.

    ``fixed`` (b, axes of the cases) are the places, 0 on the axes with nodes.
    """

    grid: TensorGrid
    fixed: Places
    spans: tuple[slice, ...]

    def __len__(self) -> int:
        """The places on the axes without nodes."""
        return len(self.fixed)

    @property
    def lengths(self) -> tuple[int, ...]:
        """Values an axis."""
        return tuple(span.stop - span.start for span in self.spans)

    @property
    def points(self) -> int:
        """All of them at one place."""
        return math.prod(self.lengths)

    @property
    def values(self) -> tuple[Array, ...]:
        """Of the parameter of each axis, ascending."""
        return tuple(axis.values[span] for axis, span in zip(self.grid.axes, self.spans, strict=True))

    @property
    def long(self) -> bool:
        """Whether there is room for nodes."""
        return all(len(x) > 1 and _long(x) for x in self.values)

    def at(self, which: NDArray[Any]) -> Region:
        """The same spans at some of the places."""
        return replace(self, fixed=self.fixed[which])

    def cut(self, k: int) -> list[Region]:
        """Two regions, cut in the middle of the range of axis k."""
        x, span = self.values[k], self.spans[k]
        middle = span.start + int(np.searchsorted(x, 0.5 * (x[0] + x[-1]), side="right"))
        halves = (slice(span.start, middle), slice(middle, span.stop))
        return [replace(self, spans=(*self.spans[:k], half, *self.spans[k + 1 :])) for half in halves]

    def places(self) -> tuple[Places, tuple[Places, ...]]:
        """Places (b,) of the first points among all cases, and what the values of each axis add to them."""
        steps = [math.prod(self.grid.shape[k + 1 :]) for k in range(len(self.grid.shape))]
        added = (axis.order[s] * steps[axis.place] for axis, s in zip(self.grid.axes, self.spans, strict=True))
        return self.fixed @ np.array(steps, np.intp), tuple(added)

    def parameters(self, index: tuple[Places, ...], coordinates: tuple[Array, ...]) -> dict[str, NDArray[Any]]:
        """Of points (s,), by their index in the span of each axis, followed by places (n,) between the points.

        One place on the axes without nodes after the other, b (s + n) values; those that never vary are one number.
        """
        out: dict[str, NDArray[Any]] = {}
        for name, p in self.grid.parameters.items():
            if p.size == 1:
                out[name] = p.reshape(())
                continue
            at = np.broadcast_to(self._at(p, index), (len(self), len(index[0])))
            inner = np.broadcast_to(self._between(name, p, coordinates), (len(self), len(coordinates[0])))
            out[name] = np.concatenate([at, inner], axis=1).ravel()
        return out

    def _where(self) -> list[Any]:
        """The places on every axis, (b, 1) each."""
        return [self.fixed[:, k, None] for k in range(self.fixed.shape[1])]

    def _at(self, p: NDArray[Any], index: tuple[Places, ...]) -> NDArray[Any]:
        """A parameter at points, (b or 1, s or 1)."""
        where = self._where()
        for axis, span, i in zip(self.grid.axes, self.spans, index, strict=True):
            where[axis.place] = axis.order[span][i]
        return _taken(p, where)

    def _between(self, name: str, p: NDArray[Any], coordinates: tuple[Array, ...]) -> NDArray[Any]:
        """A parameter between points: a straight function of the parameter of each axis."""
        for axis, x in zip(self.grid.axes, coordinates, strict=True):
            if axis.parameter == name:
                return x
        parts = [(x - v[0]) / (v[-1] - v[0]) for x, v in zip(coordinates, self.values, strict=True)]

        def value(where: list[Any], k: int) -> Any:
            if k == len(parts):
                return _taken(p, where)
            axis, span = self.grid.axes[k], self.spans[k]
            if p.shape[axis.place] == 1:
                return value(where, k + 1)
            before, after = where[: axis.place], where[axis.place + 1 :]
            first, last = (value([*before, int(axis.order[i]), *after], k + 1) for i in (span.start, span.stop - 1))
            return between(first, last, parts[k])

        return np.asarray(value(self._where(), 0))


def _taken(p: NDArray[Any], where: list[Any]) -> Any:
    """Values by their place on each axis of the cases."""
    return p[tuple(0 if n == 1 else i for n, i in zip(p.shape, where, strict=True))]
