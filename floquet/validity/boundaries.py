"""Boundaries of locks and of growth along any parameter, and as curves in the plane of any two.

Along a parameter every boundary is found as along μ, see :mod:`floquet.validity.curves`.  In a plane the lines of a
net are searched in the same way, so that every passage of a boundary through a line is known to rounding, and within a
mesh of the net a curve joins two passages::

    two on different sides      they are joined, unless a diagonal shows the tip of a tongue across a corner
    one on each of four         joined so that a diagonal is not passed
    two close ones on each      the sides of a narrow tongue: they go on side by side, if lines across it say so
    two on one side             the tip of a tongue, or a bulge: the mesh is cut in four, down to a part of the net
    others                      cut likewise

What lies within one mesh whole, as an island, is not seen; a narrower net sees it.  A boundary along the border of the
range is followed by the ends of the lines that meet the border.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError, did_you_mean
from ..exponents import exponents
from ..period_map import PeriodMap, hill_map
from ..periodic import PeriodicSystem
from .curves import Curve, crossings
from .levels import BOUNDARIES, Boundary

__all__ = ["BoundaryCurve", "boundaries", "transitions"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Ends = tuple[float, float]
Line = tuple[float, float, float, float]  # x and y of its start, x and y of its end

LEVELS = (1.0, -1.0)
OFFSET = 0.38196601125010515  # of the net's lines, of which none is at a place that a problem would choose
DEPTH = 7  # a mesh is cut in four so often at most
NARROW = 0.05  # of a side: passages closer than this are the two sides of a tongue
WIDTH = 1e-9  # of a line: two passages closer than this are none
ACROSS = [0.04, 0.31, 0.69, 0.96]  # from one end of a tongue to the other: where it is looked at first,
LOOKS = 10  # and how often at most
BULGE = 1.6  # way over distance: half a circle has 1.57
NEAR, AT = 1e-12, 4e-15  # distance from a level: worth more digits, and none
ALONG = np.array([0.13, 0.38196601125010515, 0.71])  # of a line that may lie in a boundary


@dataclass(frozen=True, eq=False, kw_only=True)
class BoundaryCurve:
    """A curve of a boundary.

    Attributes
    ----------
    x, y : (k,)
        Points of it, each right to rounding, in order; the first is the last of a closed one.
    rotation_number : (k,)
        ρ there; on the edge of a lock that of the lock.
    """

    x: Array
    y: Array
    rotation_number: Array


def transitions(
    family: Callable[[Array], PeriodicSystem], low: float, high: float, *, kind: Boundary = "lock"
) -> tuple[Array, Array]:
    """Every value of a parameter at which a system enters or leaves a lock, or growth begins or ends.

    Parameters
    ----------
    family : callable
        The system, one scalar equation or identical blades, for an array of values (k,) of the parameter.
    low, high : float
        Range of the parameter.
    kind : {"lock", "growth"}

    Returns
    -------
    values : (r,)
        Of the parameter, in order; windows narrower than 1e-9 of the range are left out.  An end of the range that lies
        on a boundary to rounding is one of them.
    rotation_number : (r,)
        ρ per unit of t.
    """
    a, b = _range("low, high", (low, high))
    _check_family(family)
    plane = _Plane(lambda x, y: family(x), kind)
    t, _ = plane.passages([(a, 0.0, b, 0.0)])[0]
    x = a + (b - a) * t
    return x, plane.rotation(x, 0.0 * x)


def boundaries(
    family: Callable[[Array, Array], PeriodicSystem],
    x: Ends,
    y: Ends,
    *,
    kind: Boundary = "lock",
    meshes: int = 48,
) -> tuple[BoundaryCurve, ...]:
    """Curves in the plane of two parameters on which a system enters or leaves a lock, or growth begins or ends.

    Parameters
    ----------
    family : callable
        The system, one scalar equation or identical blades, for arrays of values (k,) of the two parameters.
    x, y : (low, high)
        Their ranges.
    kind : {"lock", "growth"}
    meshes : int
        Of the net, each way.
    """
    (a, b), (c, d) = _range("x", x), _range("y", y)
    _check_family(family)
    if isinstance(meshes, bool) or not isinstance(meshes, (int, np.integer)) or meshes < 2:
        raise ParameterError("meshes", meshes, f"{meshes!r} is no net: give a whole number of meshes, 2 or more")
    plane = _Plane(family, kind)
    segments = list(_segments(plane, _net(plane, _lines(a, b, meshes, OFFSET), _lines(c, d, meshes, 0.7 * OFFSET))))
    chains = [np.array(chain) for chain in _chains(segments)]
    if not chains:
        return ()
    everything = np.concatenate(chains)
    rho = plane.rotation(everything[:, 0], everything[:, 1])
    ends = np.cumsum([len(chain) for chain in chains])[:-1]
    return tuple(
        BoundaryCurve(x=chain[:, 0], y=chain[:, 1], rotation_number=r)
        for chain, r in zip(chains, np.split(rho, ends), strict=True)
    )


def _check_family(family: object) -> None:
    if not callable(family):
        raise ParameterError(
            "family", family, f"{family!r} is no family: give a function of the parameter that returns the system"
        )


def _range(name: str, ends: Ends) -> Ends:
    try:
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError):
        low = high = math.nan
    if not -math.inf < low < high < math.inf:
        raise ParameterError(name, ends, f"{ends!r} is no range: give two numbers, the lower first")
    return low, high


def _lines(a: float, b: float, meshes: int, offset: float) -> Array:
    """Places of a net's lines, those at the ends included."""
    return np.concatenate([[a], a + (b - a) * (np.arange(meshes - 1) + 1.0 - offset) / (meshes - 2 * offset + 1), [b]])


# ---------------------------------------------------------------------- passages through lines
class _Plane:
    """A system by two parameters, and where a boundary passes lines."""

    def __init__(self, family: Callable[[Array, Array], PeriodicSystem], kind: Boundary) -> None:
        if kind not in BOUNDARIES:
            known = " or ".join(BOUNDARIES)
            raise ParameterError(
                "kind", kind, f"{kind!r} is no boundary{did_you_mean(str(kind), BOUNDARIES)}: it is {known}"
            )
        self.family, self.level = family, BOUNDARIES[kind]

    def map(self, x: Array, y: Array, *, precise: bool) -> PeriodMap:
        system = self.family(x, y)
        if not isinstance(system, PeriodicSystem):
            raise ParameterError(
                "family", self.family, f"the family gives {type(system).__name__}, not a PeriodicSystem"
            )
        system = system if system.blade is None else system.blade
        if not (system.second_order and system.degrees == 1) or system.constant:
            raise ParameterError(
                "family",
                system.name,
                "boundaries are those of one scalar equation q'' + d q' + k q = 0 or of identical blades: follow the "
                "modes of other systems with track(family, values)",
            )
        if system.cases != x.shape:
            raise ParameterError(
                "family",
                system.cases,
                f"the family gives cases of shape {system.cases} for values of shape {x.shape}: it is to be made of "
                "arrays, one case a value",
            )
        phi = hill_map(system, precise=precise)
        if self.level is BOUNDARIES["growth"] and np.any(np.asarray(phi.mean) > 0.0):
            raise ParameterError(
                "kind",
                "growth",
                "the mean damping is negative somewhere in the range: there one motion grows on both sides of the "
                "level of growth; keep the damping at 0 or above",
            )
        return phi

    def rotation(self, x: Array, y: Array) -> Array:
        """ρ at points of the boundary."""
        if not len(x):
            return np.zeros(0)
        phi = self.map(x, y, precise=True)
        rho = np.atleast_1d(exponents(phi).rotation_number)
        half_turn = math.pi / phi.period
        return half_turn * np.round(rho / half_turn) if self.level is BOUNDARIES["lock"] else rho

    def passages(self, lines: Sequence[Line]) -> list[tuple[Array, Array]]:
        """For each line the places, 0 at its start and 1 at its end, and which of the two levels is passed."""
        x0, y0, x1, y1 = np.array(lines, float).reshape(-1, 4).T

        def at(case: Places, t: Array, *, precise: bool) -> PeriodMap:
            return self.map(x0[case] + (x1 - x0)[case] * t, y0[case] + (y1 - y0)[case] * t, precise=precise)

        def value(case: Places, t: Array) -> Array:
            return self.level.value(at(case, t, precise=False))

        def beyond(level: float) -> Curve:
            return lambda case, t: self.level.beyond(at(case, t, precise=True), level)

        found = crossings(
            value,
            np.zeros(len(lines)),
            np.ones(len(lines)),
            LEVELS,
            exact=beyond,
            least=WIDTH,
        )

        def on(level: float, t: float, lines: Places) -> Places:
            """Those of some lines that are at a level at t."""
            near = lines[np.abs(value(lines, np.full(len(lines), t)) - level) < NEAR]
            return near[np.abs(beyond(level)(near, np.full(len(near), t))) < AT] if len(near) else near

        case, place, reached = found.case, found.x, found.level
        for level in LEVELS:
            first, last = (on(level, end, np.arange(len(lines))) for end in (0.0, 1.0))
            along = np.intersect1d(first, last)
            for t in ALONG:
                along = on(level, t, along)
            twice = (
                np.isin(case, along)
                | (np.isin(case, first) & (place < WIDTH))
                | (np.isin(case, last) & (place > 1.0 - WIDTH))
            )
            kept = ~(twice & (reached == level))
            ends = [np.setdiff1d(some, along) for some in (first, last)]
            case = np.concatenate([case[kept], *ends])
            place = np.concatenate([place[kept], *(np.full(len(some), t) for t, some in enumerate(ends))])
            reached = np.concatenate([reached[kept], *(np.full(len(some), level) for some in ends)])
        order = np.lexsort((place, case))
        of = np.searchsorted(case[order], np.arange(len(lines) + 1))
        return [(place[order[i:j]], reached[order[i:j]]) for i, j in pairwise(of)]


@dataclass(frozen=True, slots=True)
class _Point:
    """A passage: where, and through which level."""

    x: float
    y: float
    level: float


Side = tuple[_Point, ...]
Segment = tuple[_Point, _Point]


def _points(line: Line, found: tuple[Array, Array]) -> Side:
    x0, y0, x1, y1 = line
    places = zip(*(part.tolist() for part in found), strict=True)
    return tuple(_Point(x0 + (x1 - x0) * t, y0 + (y1 - y0) * t, level) for t, level in places)


# ---------------------------------------------------------------------- meshes
@dataclass(frozen=True)
class _Mesh:
    """A rectangle, and the passages through its sides: below, right, above, left."""

    x: Ends
    y: Ends
    sides: tuple[Side, Side, Side, Side]
    depth: int = 0
    levels: tuple[float, ...] = LEVELS

    def around(self, level: float) -> list[tuple[_Point, int]]:
        """Passages through one level in the order of the circumference, with the number of their side."""
        below, right, above, left = ([p for p in side if p.level == level] for side in self.sides)
        ordered = (
            sorted(below, key=lambda p: p.x),
            sorted(right, key=lambda p: p.y),
            sorted(above, key=lambda p: -p.x),
            sorted(left, key=lambda p: -p.y),
        )
        found = {point: k for k, side in enumerate(ordered) for point in side}  # one of a corner is one
        return list(found.items())

    def clear(self, level: float) -> bool:
        """Whether it is plain which passages belong together."""
        sides = [k for _, k in self.around(level)]
        return not sides or (len(sides) == 2 and sides[0] != sides[1])

    def corner(self, level: float) -> int | None:
        """Which diagonal begins where two sides meet that are passed once each, and no others are; or None."""
        sides = [k for _, k in self.around(level)]
        return {(0, 1): 1, (1, 2): 0, (2, 3): 1, (0, 3): 0}.get((sides[0], sides[1])) if len(sides) == 2 else None

    def tongue(self, level: float) -> tuple[Array, Array] | None:
        """Ends, in units of the sides, of what may be a narrow tongue: two close passages on each of two sides."""
        points = self.around(level)
        pairs = [pair for side in range(4) if (pair := [p for p, k in points if k == side])]
        if [len(pair) for pair in pairs] != [2, 2] or max(self.apart(*pair) for pair in pairs) > NARROW:
            return None
        (a, b), (c, d) = self.x, self.y
        start, end = (
            np.array([(0.5 * (p.x + q.x) - a) / (b - a), (0.5 * (p.y + q.y) - c) / (d - c)]) for p, q in pairs
        )
        return start, end

    def across(self, start: Array, end: Array, share: float) -> Line:
        """The line through the mesh across that from start to end, so far from its start; all in units of the sides."""
        point, direction = start + share * (end - start), np.array([start[1] - end[1], end[0] - start[0]])
        to = [(edge - p) / step for p, step in zip(point, direction, strict=True) if step for edge in (0.0, 1.0)]
        ends = [point + reach * direction for reach in (max(t for t in to if t <= 0.0), min(t for t in to if t >= 0.0))]
        (a, b), (c, d) = self.x, self.y
        (x0, y0), (x1, y1) = np.clip(ends, 0.0, 1.0).tolist()
        return a + (b - a) * x0, c + (d - c) * y0, a + (b - a) * x1, c + (d - c) * y1

    def apart(self, p: _Point, q: _Point) -> float:
        """Distance in units of the sides."""
        return math.hypot((p.x - q.x) / (self.x[1] - self.x[0]), (p.y - q.y) / (self.y[1] - self.y[0]))

    def diagonals(self) -> list[Line]:
        """That which rises and that which falls."""
        (a, b), (c, d) = self.x, self.y
        return [(a, c, b, d), (a, d, b, c)]

    def middle(self) -> tuple[float, float]:
        """Where it is cut."""
        (a, b), (c, d) = self.x, self.y
        share = 0.5 + 0.1 * (OFFSET - 0.5)
        return a + share * (b - a), c + share * (d - c)

    def cross(self) -> list[Line]:
        """The four lines that cut it: to the left, the right, below and above of the middle."""
        (a, b), (c, d), (u, v) = self.x, self.y, self.middle()
        return [(a, v, u, v), (u, v, b, v), (u, c, u, v), (u, v, u, d)]

    def quarters(self, cut: Sequence[Side]) -> Iterator[_Mesh]:
        """The four parts, with the passages through what cuts them."""
        (a, b), (c, d), (u, v) = self.x, self.y, self.middle()
        below, right, above, left = self.sides
        to_left, to_right, under, over = cut
        low, high = (tuple(p for p in below if (p.x < u) == first) for first in (True, False))
        top = [tuple(p for p in above if (p.x < u) == first) for first in (True, False)]
        near = [tuple(p for p in left if (p.y < v) == first) for first in (True, False)]
        far = [tuple(p for p in right if (p.y < v) == first) for first in (True, False)]
        deeper = self.depth + 1
        yield _Mesh((a, u), (c, v), (low, under, to_left, near[0]), deeper, self.levels)
        yield _Mesh((u, b), (c, v), (high, far[0], to_right, under), deeper, self.levels)
        yield _Mesh((a, u), (v, d), (to_left, over, top[0], near[1]), deeper, self.levels)
        yield _Mesh((u, b), (v, d), (to_right, far[1], top[1], over), deeper, self.levels)


def _net(plane: _Plane, x: Array, y: Array) -> list[_Mesh]:
    """All meshes through whose sides something passes."""
    along = [(float(x[0]), float(v), float(x[-1]), float(v)) for v in y]
    across = [(float(u), float(y[0]), float(u), float(y[-1])) for u in x]
    lines = [*along, *across]
    points = _cuts(plane, lines)
    level = [_cut(side, [p.x for p in side], x) for side in points[: len(along)]]
    upright = [_cut(side, [p.y for p in side], y) for side in points[len(along) :]]
    found = []
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            sides = (level[j][i], upright[i + 1][j], level[j + 1][i], upright[i][j])
            if any(sides):
                found.append(_Mesh((float(x[i]), float(x[i + 1])), (float(y[j]), float(y[j + 1])), sides))
    return found


def _cut(side: Side, places: Sequence[float], ends: Array) -> list[Side]:
    """The passages through the parts of a line."""
    part = np.clip(np.searchsorted(ends, places, side="right") - 1, 0, len(ends) - 2)
    return [tuple(p for p, k in zip(side, part, strict=True) if k == i) for i in range(len(ends) - 1)]


def _segments(plane: _Plane, meshes: Iterable[_Mesh]) -> Iterator[Segment]:
    """Passages that belong together, two a piece."""
    waiting = list(meshes)
    while waiting:
        settled, tips = _saddles(plane, waiting) | _tongues(plane, waiting), _tips(plane, waiting)
        unclear = []
        for mesh in waiting:
            joined = {
                v for v in mesh.levels if (id(mesh), v) not in tips and (mesh.clear(v) or (id(mesh), v) in settled)
            }
            open_levels = tuple(v for v in mesh.levels if mesh.depth < DEPTH and v not in joined)
            for level in mesh.levels:
                if level not in open_levels:
                    yield from settled.get((id(mesh), level)) or _joined(mesh.around(level))
            if open_levels:
                unclear.append(_Mesh(mesh.x, mesh.y, mesh.sides, mesh.depth, open_levels))
        sides = _cuts(plane, [line for mesh in unclear for line in mesh.cross()])
        waiting = [part for k, mesh in enumerate(unclear) for part in mesh.quarters(sides[4 * k : 4 * k + 4])]


def _cuts(plane: _Plane, lines: Sequence[Line]) -> list[Side]:
    """The passages through lines."""
    return [_points(line, found) for line, found in zip(lines, plane.passages(lines) if lines else [], strict=True)]


@dataclass(frozen=True, eq=False)
class _Tongue:
    """What may be a narrow tongue through a mesh, and its width squared at shares of its way."""

    mesh: _Mesh
    level: float
    ends: tuple[Array, Array]
    shares: list[float] = field(default_factory=list)
    squares: list[float] = field(default_factory=list)

    def line(self, share: float) -> Line:
        """Across it."""
        return self.mesh.across(*self.ends, share)

    def passed(self, share: float, side: Side) -> bool:
        """Keep its width on a line across; False if it is not two passages that are there."""
        pair = [p for p in side if p.level == self.level]
        if len(pair) != 2:
            return False
        self.shares.append(share)
        self.squares.append(self.mesh.apart(*pair) ** 2)
        return True

    def doubt(self) -> list[float]:
        """Where it may be pinched off: its width squared is as smooth as what passes the level there.

        So the polynomial through the squares is below zero where there is a gap between two lines.
        """
        places = np.linspace(0.02, 0.98, 65)
        from scipy.interpolate import BarycentricInterpolator

        through = BarycentricInterpolator(self.shares, self.squares)(places)
        lowest = int(np.argmin(through))
        return [float(places[lowest])] if through[lowest] <= 0.0 and len(self.shares) < LOOKS else []


def _tips(plane: _Plane, meshes: Sequence[_Mesh]) -> set[tuple[int, float]]:
    """Meshes, by their id, and levels of which a tongue comes in across a corner, with a side of it on each side.

    A curve that cuts a corner off bulges less than its ends are apart: the diagonal from there tells.
    """
    asked = [(mesh, v) for mesh in meshes if mesh.depth < DEPTH for v in mesh.levels if mesh.corner(v) is not None]
    cuts = _cuts(plane, [mesh.diagonals()[mesh.corner(v) or 0] for mesh, v in asked])
    found = set()
    for (mesh, v), cut in zip(asked, cuts, strict=True):
        (p, _), (q, _) = mesh.around(v)
        passed = [point for point in cut if point.level == v]
        if any(mesh.apart(p, at) + mesh.apart(at, q) > BULGE * mesh.apart(p, q) for at in passed):
            found.add((id(mesh), v))
    return found


def _saddles(plane: _Plane, meshes: Sequence[_Mesh]) -> dict[tuple[int, float], list[Segment]]:
    """What belongs together where each of four sides is passed once, if a diagonal is not passed and one is twice."""
    asked = [(mesh, v) for mesh in meshes for v in mesh.levels if [k for _, k in mesh.around(v)] == [0, 1, 2, 3]]
    cuts = _cuts(plane, [line for mesh, _ in asked for line in mesh.diagonals()])
    found = {}
    for k, (mesh, v) in enumerate(asked):
        below, right, above, left = (point for point, _ in mesh.around(v))
        rising, falling = (sum(p.level == v for p in cut) for cut in cuts[2 * k : 2 * k + 2])
        if (rising, falling) == (0, 2):
            found[id(mesh), v] = [(below, right), (above, left)]
        elif (rising, falling) == (2, 0):
            found[id(mesh), v] = [(below, left), (above, right)]
    return found


def _tongues(plane: _Plane, meshes: Sequence[_Mesh]) -> dict[tuple[int, float], list[Segment]]:
    """What belongs together where a narrow tongue goes through from side to side."""
    waiting = [(_Tongue(mesh, v, ends), ACROSS) for mesh in meshes for v in mesh.levels if (ends := mesh.tongue(v))]
    found = {}
    while waiting:
        asked = [(tongue, share) for tongue, shares in waiting for share in shares]
        cuts = _cuts(plane, [tongue.line(share) for tongue, share in asked])
        pinched = {
            id(tongue) for (tongue, share), cut in zip(asked, cuts, strict=True) if not tongue.passed(share, cut)
        }
        left = [tongue for tongue, _ in waiting if id(tongue) not in pinched]
        waiting = [(tongue, doubt) for tongue in left if (doubt := tongue.doubt())]
        for tongue in left:
            if not tongue.doubt():
                found[id(tongue.mesh), tongue.level] = list(_joined(tongue.mesh.around(tongue.level)))
    return found


def _joined(points: Sequence[tuple[_Point, int]]) -> Iterator[Segment]:
    """Curves that do not cross: fewest that return to the side they come from, then the shortest."""

    @cache
    def best(i: int, j: int) -> tuple[int, int, float, tuple[tuple[int, int], ...]]:
        """Of the passages i … j-1: those without a partner, those that return, length, and the pairs."""
        if i >= j:
            return 0, 0, 0.0, ()
        alone, back, length, pairs = best(i + 1, j)
        found = [(alone + 1, back, length, pairs)]
        for k in range(i + 1, j):
            inner, outer = best(i + 1, k), best(k + 1, j)
            (p, side), (q, other) = points[i], points[k]
            found.append(
                (
                    inner[0] + outer[0],
                    inner[1] + outer[1] + (side == other),
                    inner[2] + outer[2] + math.hypot(p.x - q.x, p.y - q.y),
                    ((i, k), *inner[3], *outer[3]),
                )
            )
        return min(found)

    for i, k in best(0, len(points))[3]:
        yield points[i][0], points[k][0]


def _chains(segments: Sequence[Segment]) -> list[list[tuple[float, float]]]:
    """Segments end to end, the ends of open curves first."""
    beside: dict[_Point, list[_Point]] = {}
    for p, q in segments:
        beside.setdefault(p, []).append(q)
        beside.setdefault(q, []).append(p)
    chains = []
    for start in [*(p for p, others in beside.items() if len(others) == 1), *beside]:
        if not beside[start]:
            continue
        chain, here = [start], start
        while beside[here]:
            there = beside[here].pop()
            beside[there].remove(here)
            chain.append(here := there)
        chains.append([(p.x, p.y) for p in chain])
    return chains
