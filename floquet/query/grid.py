"""Columns of a design between the rotors of a grid: the product of polynomials in its parameters and in μ.

The rotors of a study may be every combination of the values of some parameters. About a point x of that grid and of the
advance ratios, with the weights of :mod:`floquet.query.between` on each axis a of k_a nodes, nearest first::

    p = Σ_i … Σ_j  w_i(x_1) … w_j(x_d) y_i…j        p_a, q_a: the same with k_a - 1 and k_a - 2 nodes on the axis a
    error = c (Σ_a max(|p - p_a|, |p_a - q_a|)  +  4 ε Σ |w y|)        c = 4 where the box ends at an edge, else 1

All nodes of the box that is taken are of one kind (lock, half-interval of the rotation number, ``rule`` and ``cause``
of a mode).  It begins as the cell about the point, which is refused if it is of several kinds, and grows by a layer at
a time on the axis with the fewest nodes, as long as the layer is of that kind.  An axis on which the point has a node's
value keeps that node.

The error is an estimate, no bound.  Next to an edge, where columns have square roots, polynomials converge slowly: at
1000 random designs (γ of 4 to 12 by ¼, ε of 0 to 0.08 by 0.01, μ of 0 to 0.5 by 0.01) the sum without c was too small
for 6 to 13 % of a column's values where the box ends at an edge, by up to 5 times, and elsewhere for less than 1 %.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquet.errors import ParameterError, did_you_mean
from floquet.query.between import LEAST, LOCK, MU, ROTATION, SAME, Interpolated, refusal, weights
from floquet.query.frames import DERIVED, DESIGN, is_grid
from floquet.query.language import KNOWN, ROTOR, Array, Column, Rows, short

WHOLE = ("blades", "hub")
NAMES = tuple(name for name in (*DESIGN, DERIVED) if name not in WHOLE)
"""The parameters of a design that may lie between those of rotors."""
ROUNDING = 4 * float(np.finfo(float).eps)
AT_EDGE = 4.0


@dataclass(frozen=True, kw_only=True)
class Axis:
    """A parameter, its values in the grid, and the number at which columns are asked for."""

    name: str
    nodes: Array
    at: float

    @property
    def node(self) -> int | None:
        """The node that the number is, if it is one."""
        nearest = int(np.argmin(np.abs(self.nodes - self.at)))
        return nearest if np.isclose(self.nodes[nearest], self.at, rtol=SAME, atol=0) else None

    @property
    def cell(self) -> tuple[int, int]:
        """The first and last of the nodes about the number."""
        if self.node is not None:
            return self.node, self.node
        above = int(np.searchsorted(self.nodes, self.at))
        return above - 1, above

    def reach(self, rows: int) -> Axis:
        """The nodes that so many rows about the number may take."""
        low, high = self.cell
        more = 0 if self.node is not None else rows - 2
        return Axis(name=self.name, nodes=self.nodes[max(low - more, 0) : high + more + 1], at=self.at)

    def next(self, low: int, high: int) -> list[int]:
        """The nodes beside low … high, the nearer first."""
        beside = [i for i in (low - 1, high + 1) if 0 <= i < self.nodes.size]
        return sorted(beside, key=lambda i: abs(float(self.nodes[i]) - self.at))


def checked_design(design: Mapping[str, object]) -> dict[str, float]:
    """Parameters by their names, each a finite number."""
    for name, value in design.items():
        if name not in NAMES:
            near = f"; {known}" if (known := KNOWN.get(name.lower())) else did_you_mean(name, NAMES)
            near = near or f"; there are {', '.join(NAMES)}"
            why = "; put it into the expression, as in blades == 4" if name in WHOLE else near
            raise ParameterError("at", name, f"{short(name)!r} is no parameter that lies between rotors{why}")
        finite(name, value)
    return {name: float(value) for name, value in design.items()}  # type: ignore[arg-type]


def finite(name: str, value: object) -> float:
    """A finite number, or a sentence."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not np.isfinite(value):
        raise ParameterError(name, value, f"{short(repr(value))} was given; it must be a finite number")
    return float(value)


def axes_of(rotors: Rows, design: Mapping[str, float]) -> list[Axis]:
    """The axes of the grid that some rotors form, those on which they differ; the design lies inside of it."""
    for name in design:
        if name not in rotors:
            raise ParameterError(name, design[name], "this database has no column of that name")
    nodes = {name: np.unique(values) for name, values in rotors.items() if name != ROTOR}
    varying = [name for name in (*DESIGN, DERIVED) if name in nodes and nodes[name].size > 1]
    for name in varying:
        if name not in design and name != DERIVED:
            raise ParameterError(name, None, _also(name, nodes[name]))
    axes = [Axis(name=name, nodes=nodes[name], at=design[name]) for name in design]
    for axis in axes:
        low, high = axis.nodes[0], axis.nodes[-1]
        if axis.node is None and not low < axis.at < high:
            raise ParameterError(
                axis.name, axis.at, f"{axis.at} lies outside of the rotors' values, which go from {float(low)} "
                f"to {float(high)}; nothing is said beyond them: floquet.compare computes there",
            )  # fmt: skip
    axes = [axis for axis in axes if axis.nodes.size > 1]
    names = [axis.name for axis in axes]
    count = rotors[ROTOR].size
    if count > 1 and not (names and is_grid(rotors, names)):
        sizes = " × ".join(str(axis.nodes.size) for axis in axes)
        raise ParameterError(
            "at", names, f"{count} rotors are no grid of {sizes} values in {' and '.join(names)}; give an expression "
            "that leaves those of a grid"
        )  # fmt: skip
    return axes


def _also(name: str, nodes: Array) -> str:
    ways = "" if name in WHOLE else f"give {name}=…, or "
    return (
        f"the rotors differ in it, too ({nodes.size} values, {nodes[0]:g} to {nodes[-1]:g}); {ways}put it into the "
        f"expression, as in {name} == {nodes[0]:g}"
    )


def speeds_of(rows: Array, mu: float) -> Axis:
    """The advance ratios of a rotor's rows as an axis."""
    axis = Axis(name=MU, nodes=np.unique(rows), at=mu)
    low, high = axis.nodes[0], axis.nodes[-1]
    if axis.node is None and not low < mu < high:
        raise ParameterError(MU, mu, f"{mu} lies outside of the rows, which go from {float(low)} to {float(high)}")
    return axis


def conditions(axes: Sequence[Axis]) -> str:
    """The expression of the rows of a box."""
    return " and ".join(f"{float(a.nodes[0])!r} <= {a.name} <= {float(a.nodes[-1])!r}" for a in axes)


def between(rows: Rows, names: Sequence[str], kinds: Sequence[str], present: Mapping[str, Column],
            axes: Sequence[Axis], count: int) -> Interpolated:  # fmt: skip
    """The columns ``names`` at the numbers of the axes, the last of which is μ, from the rows of a box of the grid."""
    places = [np.searchsorted(axis.nodes, rows[axis.name]) for axis in axes]
    shape = tuple(axis.nodes.size for axis in axes)
    index = np.ravel_multi_index(places, shape)
    if index.size != np.prod(shape) or np.unique(index).size != index.size:
        raise ParameterError(MU, axes[-1].at, "the rotors about it do not have the same advance ratios there")
    order = np.argsort(index)
    box = {name: rows[name][order].reshape(shape) for name in (*names, *kinds)}
    ends, at_edge = _grown(axes, {name: box[name] for name in kinds}, present, count)
    cut = tuple(slice(low, high + 1) for low, high in ends)
    taken = [axis.nodes[part] for axis, part in zip(axes, cut, strict=True)]
    nodes = {axis.name: tuple(x.tolist()) for axis, x in zip(axes, taken, strict=True)}
    at = {axis.name: axis.at if axis.node is None else float(axis.nodes[axis.node]) for axis in axes}
    values, errors = {}, {}
    with np.errstate(all="ignore"):
        for name in names:
            if name in at:
                values[name], errors[name] = at[name], 0.0
                continue
            values[name], error = _product(taken, list(at.values()), box[name][cut])
            errors[name] = AT_EDGE * error if at_edge else error
    mu = at.pop(MU)
    return Interpolated(
        advance_ratio=mu, rotor=-1, rotor_name="", rows=nodes.pop(MU), values=values, errors=errors, design=at,
        nodes=nodes,
    )  # fmt: skip


def _grown(
    axes: Sequence[Axis], kinds: Rows, present: Mapping[str, Column], count: int
) -> tuple[list[tuple[int, int]], bool]:
    """The first and last node on each axis of the box of one kind about the point; whether it ends at an edge."""
    kind = _kind(kinds)
    ends = [axis.cell for axis in axes]
    _check_cell(axes, ends, kinds, present)
    own = kind[tuple(low for low, _ in ends)]
    stuck: set[tuple[int, int]] = set()
    while True:
        growing = [
            (high - low, a, beside)
            for a, (axis, (low, high)) in enumerate(zip(axes, ends, strict=True))
            if axis.node is None and high - low + 1 < count
            for beside in [[i for i in axis.next(low, high) if (a, i) not in stuck]]
            if beside
        ]
        if not growing:
            break
        _, a, (new, *_) = min(growing)
        layer = tuple(new if b == a else slice(low, high + 1) for b, (low, high) in enumerate(ends))
        if (kind[layer] == own).all():
            ends[a] = min(ends[a][0], new), max(ends[a][1], new)
        else:
            stuck.add((a, new))  # other axes only grow, and the layer with them
    for axis, (low, high) in zip(axes, ends, strict=True):
        if axis.node is None and high - low + 1 < LEAST:
            few, x = high - low + 1, axis.nodes
            raise ParameterError(
                axis.name, axis.at, f"only {few} values of {axis.name} about {axis.at:g} have rows of one kind "
                f"({x[low]:g} to {x[high]:g}), and a value with its error takes {LEAST}; compute there, or run the "
                "study with more values",
            )  # fmt: skip
    return ends, bool(stuck)


def _kind(kinds: Rows) -> Array:
    """A number for each node, equal where all kinds are."""
    code = np.zeros(next(iter(kinds.values())).shape, dtype=np.int64)
    for name, values in kinds.items():
        met, place = np.unique(_half(name, values, kinds), return_inverse=True)
        code = np.unique(code * len(met) + place.reshape(code.shape), return_inverse=True)[1].reshape(code.shape)
    return code


def _half(name: str, values: Array, kinds: Rows) -> Array:
    """Of the rotation number outside of locks the half-interval that it lies in."""
    return np.where(np.isnan(kinds[LOCK]), np.floor(2 * values), np.nan) if name == ROTATION else values


def _check_cell(
    axes: Sequence[Axis], ends: Sequence[tuple[int, int]], kinds: Rows, present: Mapping[str, Column]
) -> None:
    """All nodes about the point are of one kind, or the first edge between two of them is told."""
    cut = tuple(slice(low, high + 1) for low, high in ends)
    for name, values in kinds.items():
        corners = _half(name, values, kinds)[cut]
        for a, axis in enumerate(axes):
            before, after = (np.take(corners, [i], axis=a) for i in (0, -1))
            differ = (before != after) & ~(np.isnan(before) & np.isnan(after))
            if differ.any():
                where = np.unravel_index(int(np.argmax(differ)), differ.shape)
                here = [low + int(i) for (low, _), i in zip(ends, where, strict=True)]
                there = [ends[a][1] if b == a else i for b, i in enumerate(here)]
                others = ", ".join(f"{o.name} {o.nodes[i]:g}" for o, i in zip(axes, here, strict=True) if o is not axis)
                between = f"between {axis.name} {axis.nodes[here[a]]:g} and {axis.nodes[there[a]]:g} (at {others})"
                pair = values[tuple(here)], values[tuple(there)]
                more = "advance ratios" if axis.name == MU else f"values of {axis.name}"
                raise ParameterError(axis.name, axis.at, refusal(name, pair, present, between, more))


def _product(x: Sequence[Array], at: Sequence[float], y: Array) -> tuple[Any, float]:
    """Value and error of the product of polynomials through the nodes x of each axis."""
    if (y == y.flat[0]).all():
        return y.flat[0].item(), 0.0
    full = [_axis_weights(nodes, value, 0) for nodes, value in zip(x, at, strict=True)]
    best = _contracted(full, y)
    error = ROUNDING * float(_contracted([np.abs(w) for w in full], np.abs(y)))
    for a, nodes in enumerate(x):
        if nodes.size > 1:
            less, least = (
                _contracted([_axis_weights(nodes, at[a], drop) if b == a else w for b, w in enumerate(full)], y)
                for drop in (1, 2)
            )
            error += float(max(abs(best - less), abs(less - least)))
    return best.item(), error if np.isfinite(best) and np.isfinite(error) else float("inf")


def _axis_weights(x: Array, at: float, drop: int) -> Array:
    """The weights of an axis, 0 for the farthest ``drop`` nodes."""
    if x.size == 1:
        return np.ones(1)
    near = np.argsort(np.abs(x - at), kind="stable")[: x.size - drop]
    out = np.zeros(x.size)
    out[near] = weights(x[near], at)
    return out


def _contracted(by_axis: Sequence[Array], y: Array) -> Any:
    for w in by_axis:
        y = np.tensordot(w, y, axes=(0, 0))
    return y
