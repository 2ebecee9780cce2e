"""Modes followed along a parameter: which exponent at one value is which at the next.

With right and left eigenvectors v_i, w_i of the map over a period (of A, for a constant system), w_i v_j = δ_ij, the
spectral projectors are P_i = v_i w_i and two values p, p' of the parameter are linked by::

    C_ij = tr P_i(p) P_j(p') = (w_i v'_j)(w'_j v_i),     every row and every column of C sums to 1

C is a permutation for p' → p, and depends on no normalisation.  What can lie between two values, and what is done::

    crossing   exponents meet, eigenvectors stay apart: C is a permutation right across it, and gives the identity
    veering    exponents turn away from each other within a short distance, and modes exchange their characters: C
               across it would exchange them, so it is resolved; the identity is that of the continuous exponents
    lock       two exponents meet and leave at right angles, at a branch point, where each P is infinite and their sum
               is not: a complex pair turns into two reals and back, or two pairs share a frequency.  Inside, the first
               of the two modes has the larger real part; behind it, C from before to behind it tells them apart

The last is exact for one blade: between any two places outside locks Re C ≥ 1 for solutions that turn the same way and
Re C ≤ 0 for others (P = ½ ± N/(2√D), N the traceless part of the map, and tr N N' has the sign of Φ₂₁ Φ'₂₁), so that C
is the rotation number's branch, over any distance.

Steps are halved until C says which is which.  Where two exponents head for each other the place where they would meet
is looked at: those that come closer than :data:`TOUCH` cross, others are followed round.  All this happens on a mesh of
:data:`MESH` equal steps or more between the lowest and the highest value, both ways from the first place of it where no
lock is near; so the identity depends on neither the order nor the number of the values asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .comparison import mode_name
from .errors import ParameterError
from .exponents import stability
from .modes import characters, modes, numbered, paired
from .passage import passage
from .periodic import PeriodicSystem
from .rotor import Word

__all__ = ["Event", "Meeting", "Track", "track"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Family = Callable[[float], PeriodicSystem]
MESH = 64  # steps between the ends
LEAST = 2.0**-44  # of the range: shorter steps than this are not made, and what is not clear then is not certain
MOST = 5000  # places that are looked at
EDGE = 2.0**-14  # of the range: to which edges of locks are narrowed down
CLEAR = 0.3  # |C - permutation| up to which each mode has one partner
BEYOND = 3.0  # least distances of two exponents: there they have passed each other
TOUCH = 1e-7  # per unit of ψ: exponents closer than this have met
BESIDE = 2.0**-20  # of the range: from a value at which exponents meet to the one that is looked at instead
AHEAD = 0.3  # of the distance at both ends: exponents that would come closer in between are looked at
ALIGNED = 1e-5  # of the distance of two exponents: they differ in growth alone, or in frequency alone


class Meeting(Word):
    """What happens to two modes between two values of the parameter."""

    CROSSING = 0  # exponents meet and go on
    VEERING = 1  # exponents turn away from each other, characters change places
    LOCK = 2  # two exponents meet and differ in growth alone from here on
    UNLOCK = 3  # and here in frequency again


@dataclass(frozen=True, kw_only=True)
class Event:
    """Two modes meet between the values ``low`` and ``high`` of the parameter; ``modes`` are columns of the track."""

    kind: Meeting
    low: float
    high: float
    modes: tuple[int, int]


@dataclass(frozen=True, eq=False, kw_only=True)
class Track:
    """Modes along a parameter; a column is one mode from end to end.

    Attributes
    ----------
    values : float (k,)
        As they were given.
    names : tuple of str
        One a mode, at the lowest value where no lock is near: of identical blades after the blade's rotation number, of
        others after their character there, see :mod:`floquet.modes`.  Members of a pair share a name.  Modes that are
        alike, in a lock from end to end, are numbered, as those of other coordinates are.
    exponents : complex (k, modes)
        η [per radian], as :func:`floquet.stability` has them (all coordinates), on the branch of the dominant harmonic
        at that value, and continuous from there.
    certain : bool (k, modes)
        Whether the identity with the mode where it was named is certain.
    events : tuple of Event
        In order of the parameter.
    """

    values: Array
    names: tuple[str, ...]
    exponents: Complex
    certain: NDArray[np.bool_]
    events: tuple[Event, ...]

    def __getitem__(self, name: str) -> Complex:
        """Exponents (k, 2) of the mode of a name."""
        columns = [i for i, n in enumerate(self.names) if n == name]
        if not columns:
            raise ParameterError(
                "mode", name, f"{name!r} is not among the modes {', '.join(dict.fromkeys(self.names))}"
            )
        return self.exponents[:, columns]


def track(family: Family, values: ArrayLike) -> Track:
    """Follow all modes of a family of systems along its parameter.

    Parameters
    ----------
    family : callable
        The system (periodic or constant, without cases) for a value of the parameter, such as
        ``lambda mu: multiblade(rotor, mu)``.  It must depend on it smoothly, and always have the same period.
    values : float (k,)
        In any order.

    Returns
    -------
    Track
        Of dissimilar blades, one after the other: they are not coupled, so that each is followed alone, and events are
        those of each blade.
    """
    wanted = np.asarray(values, float)
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted)):
        raise ParameterError("values", values, "give one or more finite values of the parameter, along one axis")
    blades = max(len(family(float(value)).blades) for value in (wanted.min(), wanted.max()))
    if blades:
        return _joined([track(_alone_in(family, i, blades), wanted) for i in range(blades)])
    walk = _Walk(family, float(wanted.min()), float(wanted.max()))
    base = np.linspace(walk.low, walk.high, MESH + 1)
    mesh = np.union1d(base, wanted)
    places = [walk.beside(v) for v in (mesh if len(mesh) > 1 else np.repeat(mesh, 2)).tolist()]
    steps = [step for a, b in pairwise(places) for step in walk.steps(a, b)]
    start = _start([walk.beside(v) for v in base.tolist()])
    order, names, lifts = _named(family, start)
    k = next((k for k, step in enumerate(steps) if step.a is start), len(steps))
    back = _Path(start, order, [step.reversed() for step in reversed(steps[:k])])
    path = _Path(start, order, steps[k:]).after(back)
    row = {id(point): k for k, point in enumerate(path.points)}
    rows = [row[id(walk.beside(v))] for v in wanted.tolist()]
    found = [np.asarray(stability(family(v), symmetry=False).exponents) for v in wanted.tolist()]
    exponents = np.stack([_like(path.exponents[k], eta, start.strip) for k, eta in zip(rows, found, strict=True)])
    return Track(
        values=wanted,
        names=names,
        exponents=exponents + 1j * lifts,
        certain=np.stack(path.certain)[rows],
        events=tuple(sorted([*path.events, *_veerings(path)], key=lambda event: event.low)),
    )


def _alone_in(family: Family, i: int, blades: int) -> Family:
    """Blade i of systems of blades that are dissimilar, at some values identical."""

    def alone(value: float) -> PeriodicSystem:
        system = family(value)
        found = system.blades or (() if system.blade is None else (system.blade,) * system.degrees)
        if len(found) != blades:
            raise ParameterError(
                "family",
                value,
                f"it gave {blades} blades at one value and {len(found)} at {value:g}: give as many at every value",
            )
        return found[i]

    return alone


def _joined(tracks: Sequence[Track]) -> Track:
    """Of one blade after the other."""
    events = [
        replace(event, modes=(event.modes[0] + 2 * i, event.modes[1] + 2 * i))
        for i, one in enumerate(tracks)
        for event in one.events
    ]
    return Track(
        values=tracks[0].values,
        names=tuple(f"blade {i}" for i, one in enumerate(tracks) for _ in one.names),
        exponents=np.concatenate([one.exponents for one in tracks], axis=1),
        certain=np.concatenate([one.certain for one in tracks], axis=1),
        events=tuple(sorted(events, key=lambda event: event.low)),
    )


# ---------------------------------------------------------------------- one value, and two
@dataclass(frozen=True, eq=False)
class _Point:
    """Exponents (n,), right eigenvectors as columns, left ones as rows; exponents are known modulo i·strip."""

    value: float
    exponents: Complex
    right: Complex
    left: Complex
    strip: float

    @staticmethod
    def of(system: PeriodicSystem, value: float) -> _Point:
        if system.cases:
            raise ParameterError("family", system.cases, "it gave a system of many cases: give one system for a value")
        if system.constant:
            matrix, T = system.sample(np.zeros(1))[0], 1.0
        else:
            T = system.period
            matrix = passage(system, np.array([0.0, T])).fundamental()[-1]
            matrix = matrix if system.twist is None else system.twist[:, None] * matrix
        multipliers, right = (x.astype(complex) for x in np.linalg.eig(matrix))
        values = multipliers if system.constant else np.log(multipliers) / T
        left = np.linalg.pinv(right)  # of vectors that coincide too: where they do is passed by
        return _Point(value, values, right, left, math.inf if system.constant else 2.0 * math.pi / T)

    @cached_property
    def met(self) -> frozenset[int]:
        """Modes whose exponents have met: their eigenvectors say nothing."""
        pairs = combinations(range(len(self.exponents)), 2)
        return frozenset(k for i, j in pairs if abs(self.distance(i, j)) < TOUCH for k in (i, j))

    def gap(self, where: complex) -> float:
        """Distance of the two exponents that are nearest to ``where``."""
        near = np.argsort([abs(_near(complex(eta - where), self.strip)) for eta in self.exponents], kind="stable")
        return abs(self.distance(int(near[0]), int(near[1])))

    def distance(self, i: int, j: int) -> complex:
        """η_i - η_j, as near to zero as it can be."""
        return _near(complex(self.exponents[i] - self.exponents[j]), self.strip)

    def aligned(self, i: int, j: int) -> int:
        """1: two exponents differ in growth alone; -1: in frequency alone; 0: neither."""
        d = self.distance(i, j)
        if abs(d.imag) <= ALIGNED * abs(d):
            return 1
        return -1 if abs(d.real) <= ALIGNED * abs(d) else 0

    @cached_property
    def locked(self) -> tuple[tuple[int, int], ...]:
        """Pairs of modes that differ in growth alone."""
        return tuple(pair for pair in combinations(range(len(self.exponents)), 2) if self.aligned(*pair) > 0)

    @cached_property
    def separation(self) -> float:
        """The least distance of two exponents."""
        pairs = combinations(range(len(self.exponents)), 2)
        return min((abs(self.distance(i, j)) for i, j in pairs), default=0.0)

    def shared(self) -> set[int]:
        """Modes that are in a lock with one that is not their own conjugate: their characters are the same.

        One that is locked with its conjugate is real, or turns by half a turn a period.
        """
        half = 0.5 * self.strip
        turns = self.exponents.imag / half if math.isfinite(half) else 0.0 * self.exponents.imag
        own = np.abs(turns - np.round(turns)) < 1e-6
        return {k for i, j in self.locked for k in (i, j) if not own[k]}


def _near(d: complex, strip: float) -> complex:
    return complex(d.real, d.imag - strip * round(d.imag / strip)) if math.isfinite(strip) else d


def _like(exponents: Complex, found: Complex, strip: float) -> Complex:
    """``found`` in the order of exponents that are almost the same, and as near to them as they can be."""
    own = found[paired(exponents, found, strip)]
    return own + (1j * strip * np.round((exponents - own).imag / strip) if math.isfinite(strip) else 0.0)


@dataclass(frozen=True, eq=False)
class _Step:
    """From a to b: the mode of b that each mode of a becomes, and pairs of modes of a that lock or unlock."""

    a: _Point
    b: _Point
    partner: NDArray[np.intp]
    edges: tuple[tuple[int, int], ...] = ()
    unclear: tuple[int, ...] = ()
    crossing: tuple[tuple[int, int], ...] = ()

    def reversed(self) -> _Step:
        """From b to a."""
        to = self.partner
        edges, crossing = (tuple((int(to[i]), int(to[j])) for i, j in pairs) for pairs in (self.edges, self.crossing))
        return _Step(self.b, self.a, np.argsort(to), edges, tuple(int(to[i]) for i in self.unclear), crossing)


def _overlap(a: _Point, b: _Point) -> Complex:
    """C."""
    return np.asarray((a.left @ b.right) * (b.left @ a.right).T)


def _linked(a: _Point, b: _Point) -> _Step:
    """Partners by C, and what is not clear."""
    from scipy.optimize import linear_sum_assignment

    C = _overlap(a, b)
    partner = np.asarray(linear_sum_assignment(-C.real)[1])
    rest = np.abs(C[:, partner] - np.eye(len(C)))
    bad = [i for i in range(len(C)) if not (rest[i].max() <= CLEAR and rest[:, i].max() <= CLEAR)]
    edges = []
    for i, j in combinations(bad, 2):
        x, y = partner[[i, j]]
        if a.aligned(i, j) * b.aligned(x, y) < 0 and _alone(C[:, partner], i, j):
            edges.append((i, j))
    met = [i for pair in edges for i in pair]
    unclear = tuple(i for i in bad if met.count(i) != 1)
    return _Step(a, b, partner, tuple(edges), unclear)


def _alone(C: Complex, i: int, j: int) -> bool:
    """Whether two modes become two modes, with no part of any other."""
    block = C[np.ix_([i, j], [i, j])]
    others = [k for k in range(len(C)) if k not in (i, j)]
    outside = np.concatenate([C[np.ix_([i, j], others)].ravel(), C[np.ix_(others, [i, j])].ravel(), [0.0]])
    sums = np.concatenate([block.sum(axis=0), block.sum(axis=1)])
    return bool(np.abs(outside).max() <= CLEAR and np.abs(sums - 1.0).max() <= CLEAR)


# ---------------------------------------------------------------------- steps that are clear
@dataclass(eq=False)
class _Walk:
    """The family with the places that have been looked at."""

    family: Family
    low: float
    high: float
    known: dict[float, _Point] = field(default_factory=dict)

    def at(self, value: float) -> _Point:
        if value not in self.known:
            self.known[value] = _Point.of(self.family(value), value)
        return self.known[value]

    def beside(self, value: float) -> _Point:
        """The place itself, or one beside it where no two exponents meet."""
        inward = math.copysign(BESIDE * (self.high - self.low), self.low + self.high - 2.0 * value)
        return self._clear([value + k * inward for k in range(4)])

    def _clear(self, values: Sequence[float]) -> _Point:
        points = (self.at(value) for value in values)
        return next((point for point in points if not point.met), self.at(values[0]))

    def steps(self, a: _Point, b: _Point) -> list[_Step]:
        """Clear steps from a to b; those that are too short to be made clear say which modes are not."""
        step, width, least = _linked(a, b), b.value - a.value, LEAST * (self.high - self.low)
        if width <= least or len(self.known) > MOST:
            ahead = (k for _, i, j, _ in _approaching(step) for k in (i, j))
            return [replace(step, unclear=(*step.unclear, *ahead))]
        if step.unclear:
            return self._halves(a, b)
        if step.edges and width > EDGE * (self.high - self.low):
            return self._halves(a, b)
        crossing = []
        for t, i, j, where in [] if step.edges else _approaching(step):
            if not a.value < (place := a.value + t * width) < b.value:
                continue
            if (middle := self.at(place)).gap(where) >= TOUCH:
                return [*self.steps(a, middle), *self.steps(middle, b)]
            crossing.append((i, j))
        return [replace(step, crossing=tuple(crossing))]

    def _halves(self, a: _Point, b: _Point) -> list[_Step]:
        width = b.value - a.value
        middle = self._clear([a.value + t * width for t in (0.5, 0.47, 0.54)])
        return [*self.steps(a, middle), *self.steps(middle, b)]


def _approaching(step: _Step) -> list[tuple[float, int, int, complex]]:
    """Pairs (i, j) of modes that head for each other: where on the way, from 0 to 1, and near which exponent."""
    found = []
    for i, j in combinations(range(len(step.partner)), 2):
        start, end = step.a.distance(i, j), step.b.distance(*step.partner[[i, j]])
        change = _near(end - start, step.a.strip)
        t = -(start.conjugate() * change).real / max(abs(change) ** 2, 1e-300)
        if 0.0 < t < 1.0 and abs(start + t * change) < AHEAD * min(abs(start), abs(start + change)):
            moved = _near(complex(step.b.exponents[step.partner[i]] - step.a.exponents[i]), step.a.strip)
            found.append((t, i, j, complex(step.a.exponents[i] + t * moved - 0.5 * (start + t * change))))
    return found


# ---------------------------------------------------------------------- columns
class _Path:
    """Columns along the steps: ``index[c]`` is the mode of the last point that column c is, from ``order`` on."""

    def __init__(self, start: _Point, order: NDArray[np.intp], steps: Sequence[_Step]) -> None:
        self.index = order
        self.points, self.exponents, self.indices = [start], [start.exponents[order]], [order]
        self.certain: list[NDArray[np.bool_]] = [np.ones(len(order), bool)]
        self.before: dict[tuple[int, int], tuple[_Point, NDArray[np.intp]]] = {}
        self.events: list[Event] = []
        for step in steps:
            self.take(step)

    def after(self, back: _Path) -> _Path:
        """This path from the start on, and before it one that leads back from there."""
        for name in ("points", "exponents", "indices", "certain"):
            setattr(self, name, [*getattr(back, name)[:0:-1], *getattr(self, name)])
        self.events = [*back.events, *self.events]
        return self

    def take(self, step: _Step) -> None:
        """One step further."""
        column = {int(mode): c for c, mode in enumerate(self.index)}
        index, certain = step.partner[self.index], self.certain[-1].copy()
        for i, j in step.edges:
            first, second = sorted((column[i], column[j]))
            certain[[first, second]] &= self._edge(step, first, second, index)
        certain[[column[i] for i in (*step.unclear, *step.a.met)]] = False
        for i, j in step.crossing:
            self._record(Meeting.CROSSING, step, (column[i], column[j]))
        eta, last = step.b.exponents[index], self.exponents[-1]
        if math.isfinite(step.b.strip):
            eta = eta + 1j * step.b.strip * np.round((last.imag - eta.imag) / step.b.strip)
        self.index = index
        self.points.append(step.b)
        self.indices.append(index)
        self.exponents.append(eta)
        self.certain.append(certain)

    def _edge(self, step: _Step, first: int, second: int, index: NDArray[np.intp]) -> bool:
        """Into a lock: the first column has the larger growth.  Out of it: by C from before it.

        False where two modes that are not one pair have not come into it together: nothing tells which is which.
        """
        x, y = int(index[first]), int(index[second])
        known, entering = True, step.b.aligned(x, y) > 0
        if entering:
            swap = step.b.exponents[x].real < step.b.exponents[y].real
            self.before[first, second] = (step.a, self.index)
        elif (before := self.before.pop((first, second), None)) is not None:
            point, was = before
            C = _overlap(point, step.b).real
            i, j = was[first], was[second]
            swap = C[i, x] + C[j, y] < C[i, y] + C[j, x]
        else:
            swap = step.b.distance(x, y).imag < 0
            known = abs(_near(complex(step.b.exponents[x] - step.b.exponents[y].conjugate()), step.b.strip)) < TOUCH
        if swap:
            index[[first, second]] = index[[second, first]]
        upwards = step.a.value < step.b.value
        self._record(Meeting.LOCK if entering == upwards else Meeting.UNLOCK, step, (first, second))
        return known

    def _record(self, kind: Meeting, step: _Step, pair: tuple[int, int]) -> None:
        (first, second), (low, high) = sorted(pair), sorted((step.a.value, step.b.value))
        self.events.append(Event(kind=kind, low=low, high=high, modes=(first, second)))


def _veerings(path: _Path) -> list[Event]:
    """Pairs of columns that come nearest to each other in between, and have exchanged their characters beyond."""
    exponents, strip, found = np.stack(path.exponents), path.points[0].strip, []
    for i, j in combinations(range(exponents.shape[1]), 2):
        distance = np.array([abs(_near(complex(d), strip)) for d in exponents[:, i] - exponents[:, j]])
        for k in range(1, len(distance) - 1):
            if not distance[k - 1] > distance[k] <= distance[k + 1]:
                continue
            apart = np.flatnonzero(distance > BEYOND * distance[k])
            if not apart.size or not apart[0] < k < apart[-1]:
                continue
            low, high = apart[apart < k][-1], apart[apart > k][0]
            C = _overlap(path.points[low], path.points[high]).real
            (a, b), (x, y) = path.indices[low][[i, j]], path.indices[high][[i, j]]
            if C[a, y] + C[b, x] - C[a, x] - C[b, y] > 1.0:
                ends = path.points[low].value, path.points[high].value
                found.append(Event(kind=Meeting.VEERING, low=ends[0], high=ends[1], modes=(i, j)))
    return found


def _start(base: Sequence[_Point]) -> _Point:
    """The first place that is in no lock nor near one: its exponents are half as far apart as they are anywhere."""
    free = [point for point in base if not point.locked] or list(base)
    apart = max(point.separation for point in free)
    return next(point for point in free if point.separation >= 0.5 * apart)


def _named(family: Family, start: _Point) -> tuple[NDArray[np.intp], tuple[str, ...], Array]:
    """Order and names of the columns, and what leads their frequencies to the branch of the dominant harmonic.

    By frequency, then decay, the member of a pair that turns forwards first.
    """
    system, eta, lifts = family(start.value), start.exponents, np.zeros(len(start.exponents))
    if system.constant:
        names = list(characters(system, eta, start.right))
    elif system.blade is not None:
        names, lifts = _of_blade(system.blade, system.degrees, eta)
    else:
        found = modes(system)
        order = np.argsort(found.order)[paired(eta, np.asarray(stability(system).exponents), start.strip)]
        names = ["" if found.names[i].startswith("mode ") else found.names[i] for i in order]
        half = 0.5 * start.strip  # what turns over with every passage is counted over two
        lifts = half * np.round((found.exponents[order].imag - eta.imag) / half)
    shared = start.shared()
    names = ["" if i in shared else name for i, name in enumerate(names)]
    omega = eta.imag + lifts
    columns = np.lexsort((omega < 0.0, -np.round(eta.real, 9), np.array(names), np.round(np.abs(omega), 9)))
    return columns, numbered([names[c] for c in columns]), lifts[columns]


def _of_blade(blade: PeriodicSystem, blades: int, eta: Complex) -> tuple[list[str], Array]:
    """Names and branches of identical blades' modes: mode k is σ ± i(ρ + k), β_d of an even number is the blade."""
    own = complex(np.asarray(stability(blade).exponents)[0])
    orders = [k for n in range(1, (blades - 1) // 2 + 1) for k in (-n, n)]
    counted = [(mode_name(k), own + 1j * k, 0.0) for k in (0, *orders)]
    if blades % 2 == 0:
        counted.append(("differential", own + 0.5j * blades, -0.5 * blades))
    both = [each for name, value, lift in counted for each in ((name, value, lift), (name, value.conjugate(), -lift))]
    place = paired(eta, np.array([value for _, value, _ in both]), float(blades))
    turns = np.array([both[i][1].imag for i in place]) - eta.imag
    return [both[i][0] for i in place], np.round(turns / blades) * blades + np.array([both[i][2] for i in place])
