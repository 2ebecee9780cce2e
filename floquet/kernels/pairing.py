"""Which eigenvalues of a simple model stand for which exponents of the exact one, and how far off they are.

For every point σ₁, σ₂, ρ and lock of the blade and the pairs of the simple model go in; for every mode k its two exact
targets, its two simple eigenvalues, its four errors and the numbers of its rule and cause come out, as
:mod:`floquet.comparison` explains.

The arithmetic is that of one point and stands here once: NumPy runs it on arrays, compiled it runs on lanes.  ``b`` is
a block of points, a pair is four numbers: real and imaginary part of the first, then of the second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import worth_compiling
from .primitives import select, somewhere, sqrt

__all__ = ["ARITHMETIC", "MOST", "REAL", "Pairing", "Tables", "paired", "tables"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
REAL = 1e-9  # two eigenvalues without imaginary parts above this are a split pair: the noise of a double root is √eps
TIE = 1e-9  # of costs: above the rounding of eigenvalues, below any difference that matters
MOST = 3  # modes whose permutations are all tried
PAIRED, REALS, JOINT, MEAN = range(4)
NONE, DRIFT, LOCK, SPLIT, DRIFT_IN_LOCK, STABILITY = range(6)
POINTS_AT_ONCE = 2032  # stay in L2; rows a power of two apart would share the sets of a cache

#: What is compiled for lanes as it stands.
ARITHMETIC = ("larger", "aimed", "distance", "total", "costs", "tried", "picked", "assigned", "named", "ratio",
              "judged", "compared")  # fmt: skip


def groupings(items: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All ways to put an even number of items in twos, as they are first."""
    if not items:
        yield ()
        return
    first, rest = items[0], list(items[1:])
    for second in rest:
        for others in groupings([i for i in rest if i != second]):
            yield (first, second, *others)


class Tables(NamedTuple):
    """Orders of pairs to be tried (none for many modes), ways to put values in twos, and the reals these ask for."""

    orders: NDArray[np.intp]
    twos: NDArray[np.intp]
    needed: NDArray[np.intp]


@cache
def tables(modes: int) -> Tables:
    """For so many modes.  Four reals leave the last two of six values where they are."""
    orders = list(permutations(range(modes))) if modes <= MOST else np.empty((0, modes))
    reals = min(2 * modes, 6)
    twos = np.array([(*some, *range(reals, 2 * modes)) for some in groupings(range(reals))])
    needed = np.where(np.all(twos[:, 4:reals] == range(4, reals), axis=1), 4, 6)
    return Tables(np.asarray(orders, np.intp), twos, needed)


# ---------------------------------------------------------------------- targets
def aimed(state: Any, modes: Any, i: int, exact: Any, b: int) -> Any:
    """The two exact targets of mode i, into ``exact[i]``; gives the rule.

    The state is σ₁, σ₂, ρ, lock (nan outside one).  Of a joint pair the mode with the higher k takes σ₁ until names are
    settled.
    """
    s1, s2, rho, lock, k = state[0, b], state[1, b], state[2, b], state[3, b], modes[i]
    mirror = -2.0 * lock - k
    reals = mirror == k
    joint = reals & (mirror != k)
    for other in modes:
        joint = joint | ((mirror == other) & (mirror != k))
    mean = 0.5 * (s1 + s2)
    higher = mirror < k
    exact[i, 0, b] = select(reals | (joint & higher), s1, select(joint, s2, mean))
    exact[i, 2, b] = select(joint & higher, s1, select(reals | joint, s2, mean))
    frequency = select(reals, 0.0, rho + k)
    exact[i, 1, b], exact[i, 3, b] = frequency, 0.0 - frequency
    return select(lock == lock, select(reals, REALS, select(joint, JOINT, MEAN)), PAIRED)


# ---------------------------------------------------------------------- assignment
def distance(x: Any, y: Any, u: Any, v: Any) -> Any:
    """|x + iy - u - iv|."""
    return sqrt((x - u) * (x - u) + (y - v) * (y - v))


def total(one: Any, other: Any) -> Any:
    """The sum of two distances, of equal sums the one with the smaller largest distance first."""
    return one + other + TIE * select(one > other, one, other)


def costs(exact: Any, modes: Any, i: int, values: Any, p: int, q: int, b: int) -> Any:
    """Distances of values p and q to the two targets of mode i, taken straight and crossed.

    Of orders that cost the same, the one that gives the mode with the higher k the less damped pair is first.
    """
    x, y, u, v = exact[i, 0, b], exact[i, 1, b], exact[i, 2, b], exact[i, 3, b]
    s, t, z, w = values[p, 0, b], values[p, 1, b], values[q, 0, b], values[q, 1, b]
    straight = total(distance(x, y, s, t), distance(u, v, z, w))
    crossed = total(distance(x, y, z, w), distance(u, v, s, t))
    favour = TIE * modes[i] * (s + z)
    return straight - favour, crossed - favour


def cheapest(cost: Any, orders: Any, choice: Any) -> Any:
    """The pair of every mode by the least total cost (m, m), into ``choice`` (m); gives the total."""
    return tried(cost, orders, choice) if len(orders) else matched_by_scipy(cost, choice)


def matched_by_scipy(cost: Array, choice: Array) -> Array:
    """Of many modes, (m, m, points), point by point."""
    from scipy.optimize import linear_sum_assignment

    found = [linear_sum_assignment(c) for c in np.moveaxis(cost, -1, 0)]
    choice[:] = np.array([pair for _, pair in found]).T
    return np.array([c[pair].sum() for c, pair in zip(np.moveaxis(cost, -1, 0), found, strict=True)])


def tried(cost: Any, orders: Any, choice: Any) -> Any:
    """The first of the orders that cost least."""
    modes = len(choice)
    best = cost[0, 0]
    for p in range(len(orders)):
        added = cost[0, orders[p, 0]]
        for i in range(1, modes):
            added = added + cost[i, orders[p, i]]
        better = (added < best) if p > 0 else (added == added) | (added != added)
        for i in range(modes):
            choice[i] = select(better, orders[p, i], choice[i])
        best = select(better, added, best)
    return best


def picked(values: Any, two: Any, chosen: Any, crossed: Any, b: int) -> Any:
    """The chosen of the pairs, crossed or not."""
    p, q = two[0], two[1]
    x, y, u, v = values[p, 0, b], values[p, 1, b], values[q, 0, b], values[q, 1, b]
    cross = crossed[0]
    for j in range(1, len(crossed)):
        here, p, q = chosen == j, two[2 * j], two[2 * j + 1]
        x, y = select(here, values[p, 0, b], x), select(here, values[p, 1, b], y)
        u, v = select(here, values[q, 0, b], u), select(here, values[q, 1, b], v)
        cross = select(here, crossed[j], cross)
    turn = cross > 0.5
    return select(turn, u, x), select(turn, v, y), select(turn, x, u), select(turn, y, v)


def assigned(
    exact: Any, modes: Any, values: Any, orders: Any, twos: Any, needed: Any, room: Any, pairs: Any, b: int
) -> None:
    """The pair of values of every mode, at the least total distance.

    Values (2m, 2) come in twos; four or six reals come first, and are tried in all other twos as well.
    ``room`` (2m+1, m) is scratch: costs, where they are of crossed pairs, and the choice.
    """
    m = len(exact)
    reals = select(values[0, 1, b] == 0.0, 1.0, 0.0)
    for p in range(1, 2 * m):
        reals = reals + select(values[p, 1, b] == 0.0, 1.0, 0.0)
    best = reals
    for g in range(len(twos)):
        free = reals >= (needed[g] if g > 0 else 0)
        if not somewhere(free):
            continue
        for i in range(m):
            for j in range(m):
                straight, crossed = costs(exact, modes, i, values, twos[g, 2 * j], twos[g, 2 * j + 1], b)
                room[i, j] = select(crossed < straight, crossed, straight)
                room[m + i, j] = select(crossed < straight, 1.0, 0.0)
        cost = cheapest(room[:m], orders, room[2 * m])
        better = free & (cost < best) if g > 0 else free
        best = select(better, cost, best)
        for i in range(m):
            x, y, u, v = picked(values, twos[g], room[2 * m, i], room[m + i], b)
            pairs[i, 0, b], pairs[i, 1, b] = select(better, x, pairs[i, 0, b]), select(better, y, pairs[i, 1, b])
            pairs[i, 2, b], pairs[i, 3, b] = select(better, u, pairs[i, 2, b]), select(better, v, pairs[i, 3, b])


def named(state: Any, modes: Any, exact: Any, pairs: Any, b: int) -> None:
    """Of two modes that share four targets, the regressing one (lower k) takes the lower simple frequency."""
    for i in range(len(modes)):
        for j in range(len(modes)):
            if modes[i] < modes[j]:
                one, other = abs(pairs[i, 1, b]) + abs(pairs[i, 3, b]), abs(pairs[j, 1, b]) + abs(pairs[j, 3, b])
                swap = (-2.0 * state[3, b] - modes[i] == modes[j]) & (one > other + REAL)
                if not somewhere(swap):
                    continue
                for rows in (exact, pairs):
                    for c in range(4):
                        x, y = rows[i, c, b], rows[j, c, b]
                        rows[i, c, b], rows[j, c, b] = select(swap, y, x), select(swap, x, y)


# ---------------------------------------------------------------------- errors and causes
def larger(a: Any, b: Any) -> Any:
    """The larger; nan if one is."""
    return select(a > b, a, select(a == a, b, a))


def ratio(a: Any, b: Any) -> Any:
    """a / b; 0 where both vanish, inf where only b does, nan where either is nan."""
    return select(b == 0.0, select(a == 0.0, 0.0, math.inf), a / select(b == 0.0, 1.0, b))


def judged(state: Any, exact: Any, pairs: Any, i: int, errors: Any, b: int) -> Any:
    """The four errors of mode i, in the order of the metrics; gives the cause."""
    x, y, u, v = exact[i, 0, b], exact[i, 1, b], exact[i, 2, b], exact[i, 3, b]
    s, t, z, w = pairs[i, 0, b], pairs[i, 1, b], pairs[i, 2, b], pairs[i, 3, b]
    absolute = larger(distance(s, t, x, y), distance(z, w, u, v))
    real, imaginary = 0.5 * (x * x + u * u), 0.5 * (y * y + v * v)
    errors[i, 0, b] = ratio(absolute, sqrt(real + imaginary))
    errors[i, 1, b] = absolute
    errors[i, 2, b] = ratio(larger(abs(t - y), abs(w - v)), sqrt(imaginary))
    errors[i, 3, b] = ratio(larger(abs(s - x), abs(z - u)), sqrt(real))
    locked = state[3, b] == state[3, b]
    split = (abs(t) < REAL) & (abs(w) < REAL)
    kind = select(locked, select(split, DRIFT_IN_LOCK, LOCK), select(split, SPLIT, DRIFT))
    grows, simple_grows = (x > 0.0) | (u > 0.0), (s > 0.0) | (z > 0.0)
    return select((grows & ~simple_grows) | (simple_grows & ~grows), STABILITY, kind)


def compared(
    state: Any, values: Any, modes: Any, orders: Any, twos: Any, needed: Any, room: Any, b: int,
    exact: Any, pairs: Any, errors: Any, kinds: Any,
) -> None:  # fmt: skip
    """A block of points: targets, pairs, errors, and the rule and the cause of every mode."""
    for i in range(len(modes)):
        kinds[i, 0, b] = aimed(state, modes, i, exact, b)
    assigned(exact, modes, values, orders, twos, needed, room, pairs, b)
    named(state, modes, exact, pairs, b)
    for i in range(len(modes)):
        kinds[i, 1, b] = judged(state, exact, pairs, i, errors, b)


# ---------------------------------------------------------------------- many points
class Pairing(NamedTuple):
    """Of every mode: exact and simple pair (m, 2, points), errors (m, 4, points), rule and cause (m, points)."""

    exact: Complex
    simple: Complex
    errors: Array
    rule: NDArray[np.int8]
    cause: NDArray[np.int8]


def paired(state: Array, values: Complex, modes: Sequence[int]) -> Pairing:
    """Compare the modes k of every point: σ₁, σ₂, ρ, lock (4, points) with values (2m, points) in twos, reals first."""
    m, points = len(modes), state.shape[1]
    pairs = (m, 2, points)
    out = Pairing(
        np.empty(pairs, complex), np.empty(pairs, complex), np.empty((m, 4, points)),
        np.empty((m, points), np.int8), np.empty((m, points), np.int8),
    )  # fmt: skip
    lanes = m <= MOST and worth_compiling(points)
    for some in _parts(values, lanes):
        rows = state[:, some], np.stack([values.real[:, some], values.imag[:, some]], axis=1)
        exact, simple, errors, kinds = (_in_lanes if lanes else _on_arrays)(*rows, np.array(modes, float))
        for target, source in ((out.exact, exact), (out.simple, simple)):
            target.real[:, :, some], target.imag[:, :, some] = source[:, 0::2], source[:, 1::2]
        out.errors[:, :, some], out.rule[:, some], out.cause[:, some] = errors, kinds[:, 0], kinds[:, 1]
    return out


def _parts(values: Complex, lanes: bool) -> Iterator[Any]:
    """Which points are compared at once; on arrays those with four reals apart, because they take more steps."""
    points = values.shape[1]
    if lanes:
        yield from (slice(first, first + POINTS_AT_ONCE) for first in range(0, points, POINTS_AT_ONCE))
        return
    many = np.sum(values.imag == 0.0, axis=0) >= 4
    for group in (np.flatnonzero(~many), np.flatnonzero(many)):
        yield from (group[first : first + POINTS_AT_ONCE] for first in range(0, len(group), POINTS_AT_ONCE))


def _in_lanes(state: Array, values: Array, modes: Array) -> tuple[Array, ...]:
    """:func:`compared` compiled."""
    from . import blocks

    return blocks.compare(state, values, modes)


def _on_arrays(state: Array, values: Array, modes: Array) -> tuple[Array, ...]:
    """:func:`compared` as NumPy runs it: one block of arrays."""
    m, n = len(modes), state.shape[1]
    out = tuple(np.empty((m, rows, 1, n)) for rows in (4, 4, 4, 2))
    with np.errstate(invalid="ignore"):  # a map that overflowed
        compared(state[:, None], values[:, :, None], modes, *tables(m), np.empty((2 * m + 1, m, n)), 0, *out)
    return tuple(x[:, :, 0] for x in out)
