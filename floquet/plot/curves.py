"""Rows of one rotor → curves: exponents and TPP eigenvalues along μ, lock bands, failing intervals.  NumPy only.

The exact exponents of a rotor of identical blades are, outside a lock and in a lock at ρ = L with the mean α and half
the split δ of its two real parts::

    α ± i |ρ + k|      (α ± δ) ± i |L + k|      k = -1 regressing, 0 coning and differential, +1 advancing

so every mode splits in a lock, and all modes share one damping.  These are drawn, from the columns exponent_1,
exponent_2, rotation_number and lock, and not the mean a mode with Rule.MEAN is compared with, which is no exponent.

Between rows, curves have square roots: at lock edges in ρ - L and δ, at TPP splits in the half difference.  Their
squares are analytic there::

    δ² in the lock, -(ρ - L)² outside      ((s₁ - s₂)/2)² of a TPP pair

so the polynomial through the six nearest rows gives the edge as its zero (to 1e-8 in μ for rows 0.01 apart, if no
other edge is within them) and the curves on both sides of it.  A lock narrower than the step of the rows is not seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquet.comparison import Cause, Metric, Rule
from floquet.errors import ParameterError
from floquet.sweep import INTERVALS, MODES

__all__ = [
    "ORDERS", "Band", "Exact", "Failing", "Pair", "Rows", "all_intervals", "checked", "exact_curves", "failing",
    "lock_bands", "modes_of", "ordered", "span", "tpp_curves",
]  # fmt: skip

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Rows = Mapping[str, NDArray[Any]]
Band = tuple[float, float, float]
Pair = tuple[Array, Complex]
Polynomial = Callable[[Any], Array]

ORDERS = {"regressing": -1, "coning": 0, "advancing": 1, "differential": 0}
STENCIL = 3  # rows on either side of an edge
NEAR = 3  # rows next to an edge that get points between them
FEWEST = 4  # rows that make a curve
TOLERANCE = 0.05


# ---------------------------------------------------------------------- rows
def checked(rows: Rows, name: str) -> Rows:
    """The rows in the order of μ, each μ once, if they are enough for a curve."""
    rows = ordered(rows)
    count = int(np.count_nonzero(np.isfinite(np.asarray(rows["rotation_number"], float))))
    if count < FEWEST:
        sentence = f"rotor {name!r} has rows at {count} advance ratios and a curve needs {FEWEST}: run a finer axis"
        raise ParameterError("rotor", name, sentence)
    return rows


def ordered(rows: Rows) -> Rows:
    """The rows in the order of μ, each μ once."""
    _, index = np.unique(np.asarray(rows["advance_ratio"], float), return_index=True)
    return {name: np.asarray(values)[index] for name, values in rows.items()}


def span(rows: Rows) -> tuple[float, float]:
    """The first and the last μ."""
    mu = np.asarray(rows["advance_ratio"], float)
    return float(mu.min()), float(mu.max())


def modes_of(rows: Rows) -> tuple[str, ...]:
    """The modes this rotor has."""
    return tuple(m for m in MODES if f"rule_{m}" in rows and np.any(np.asarray(rows[f"rule_{m}"]) != Rule.ABSENT))


# ---------------------------------------------------------------------- exact exponents
@dataclass(frozen=True, kw_only=True, eq=False)
class Exact:
    """The blade's exponents along μ, refined at lock edges, which stand twice: as the end of either side.

    ``sigma`` is (n, 2), its second column nan where both exponents have one real part; nan rows separate curves.
    """

    mu: Array
    sigma: Array
    rho: Array
    bands: tuple[Band, ...]

    def mode(self, name: str) -> Complex:
        """(n, 2) exponents of a mode in the upper half plane; the second is nan where it is the first."""
        return np.asarray(self.sigma + 1j * np.abs(self.rho + ORDERS[name])[:, None])


class _Run(NamedTuple):
    """Neighbouring rows first … last (inclusive) in one state: lock is nan, or ρ of the lock."""

    first: int
    last: int
    lock: float


@dataclass(frozen=True, kw_only=True)
class _Edge:
    """A lock edge: where it is, and δ² (or minus (ρ - L)²) and α beside it as polynomials in μ."""

    at: float
    lock: float
    square: Polynomial
    mean: Polynomial


@dataclass(frozen=True, kw_only=True, eq=False)
class _Blade:
    """Columns of the blade's exponents."""

    mu: Array
    sigma: Array
    rho: Array
    lock: Array
    good: NDArray[np.bool_]


def lock_bands(rows: Rows) -> tuple[Band, ...]:
    """Lock windows (enter, leave, per_rev) that the rows of one rotor show; leave = inf: locked at the last row."""
    return exact_curves(rows).bands


def exact_curves(rows: Rows) -> Exact:
    """The exact exponents along μ."""
    blade = _blade(ordered(rows))
    runs = _runs(blade)
    edges = [None, *(_edge(a, b, blade) for a, b in pairwise(runs)), None]
    pieces = [np.full((1, 4), np.nan)]
    bands: list[Band] = []
    for run, left, right in zip(runs, edges[:-1], edges[1:], strict=True):
        pieces += [_along(run, left, right, blade)] + ([] if right else [np.full((1, 4), np.nan)])
        if not math.isnan(run.lock):
            leave = math.inf if run.last == len(blade.mu) - 1 else float(blade.mu[run.last])
            bands.append((left.at if left else float(blade.mu[run.first]), right.at if right else leave, run.lock))
    table = np.concatenate(pieces)
    return Exact(mu=table[:, 0], sigma=table[:, 1:3], rho=table[:, 3], bands=tuple(bands))


def _blade(rows: Rows) -> _Blade:
    mu, rho, lock = (np.asarray(rows[name], float) for name in ("advance_ratio", "rotation_number", "lock"))
    sigma = np.stack([np.real(rows["exponent_1"]), np.real(rows["exponent_2"])], axis=-1)
    good = np.isfinite(rho) & np.isfinite(sigma).all(axis=-1)
    return _Blade(mu=mu, sigma=sigma, rho=rho, lock=lock, good=good)


def _runs(blade: _Blade) -> list[_Run]:
    failed, free = -2.0, -1.0
    state = np.where(blade.good, np.where(np.isnan(blade.lock), free, blade.lock), failed)
    starts = np.flatnonzero(np.r_[True, state[1:] != state[:-1]])
    ends = np.r_[starts[1:], len(state)] - 1
    locks = [math.nan if state[a] == free else float(state[a]) for a in starts]
    return [_Run(int(a), int(b), c) for a, b, c in zip(starts, ends, locks, strict=True) if state[a] != failed]


def _edge(before: _Run, after: _Run, blade: _Blade) -> _Edge | None:
    """The edge between two runs; None where rows are missing or one lock follows another within a step."""
    if after.first != before.last + 1 or math.isnan(before.lock) == math.isnan(after.lock):
        return None
    lock = before.lock if math.isnan(after.lock) else after.lock
    free = np.isnan(blade.lock)
    usable = np.flatnonzero(blade.good & (free | (blade.lock == lock)) & (np.abs(blade.rho - lock) < 0.5))
    i, j = before.last, after.first
    near = [*usable[usable <= i][-STENCIL:], *usable[usable >= j][:STENCIL]]
    half = 0.5 * (blade.sigma[:, 0] - blade.sigma[:, 1])
    square = _polynomial(blade.mu[near], np.where(free, -((blade.rho - lock) ** 2), half**2)[near])
    if (square(blade.mu[i]) > 0) == (square(blade.mu[j]) > 0):
        return None
    at = _zero(square, float(blade.mu[i]), float(blade.mu[j]))
    return _Edge(at=at, lock=lock, square=square, mean=_polynomial(blade.mu[near], blade.sigma[near].mean(axis=-1)))


def _along(run: _Run, left: _Edge | None, right: _Edge | None, blade: _Blade) -> Array:
    """(n, 4) of μ, both σ and ρ of a run, with points graded to its edges between its last rows and them."""
    inside = slice(run.first, run.last + 1)
    free = math.isnan(run.lock)
    sigma = _single(blade.sigma[inside].mean(axis=-1)) if free else blade.sigma[inside]
    parts = [np.column_stack([blade.mu[inside], sigma, blade.rho[inside]])]
    for edge, rows, rho in (
        (left, blade.mu[inside][:NEAR], blade.rho[run.first]),
        (right, blade.mu[inside][::-1][:NEAR], blade.rho[run.last]),
    ):
        if edge is None:
            continue
        x = _graded(edge.at, rows)
        size = np.sqrt(np.maximum(-edge.square(x) if free else edge.square(x), 0.0))
        size[0] = 0.0
        mean = edge.mean(x)
        if free:
            parts.append(np.column_stack([x, _single(mean), edge.lock + np.sign(rho - edge.lock) * size]))
        else:
            parts.append(np.column_stack([x, mean + size, mean - size, np.full(len(x), edge.lock)]))
    return _in_order(parts)


def _single(mean: Array) -> Array:
    """Both exponents have one real part: the second is not drawn."""
    return np.stack([mean, np.full(len(mean), np.nan)], axis=-1)


# ---------------------------------------------------------------------- simple model
def tpp_curves(rows: Rows) -> dict[str, Pair]:
    """Mode → μ and the (n, 2) TPP eigenvalues in the upper half plane; the second is nan unless both are real."""
    rows = ordered(rows)
    pairs = _conjugate_pairs(rows)
    return {mode: _tpp_curve(np.asarray(rows["advance_ratio"], float), pair) for mode, pair in pairs.items()}


def _conjugate_pairs(rows: Rows) -> dict[str, Complex]:
    """(n, 2) TPP eigenvalues a mode, where modes that were given members of each other's pairs exchange them.

    The database keeps the assignment of least distance to the exact exponents, which may halve two pairs in a lock.
    """
    z: dict[str, Complex] = {}
    for mode in modes_of(rows):
        z[mode] = np.stack([rows[f"tpp_{mode}_1"], rows[f"tpp_{mode}_2"]], axis=-1)
    coupled = [mode for mode in z if mode != "differential"]
    halved = np.stack([np.abs(z[mode].sum(axis=-1).imag) > 1e-9 for mode in coupled])
    for i in np.flatnonzero(halved.any(axis=0)):
        mixed = [mode for mode, half in zip(coupled, halved[:, i], strict=True) if half]
        whole = _whole_pairs(np.concatenate([z[mode][i] for mode in mixed]))
        if len(whole) == len(mixed):
            before = np.stack([_sorted_pair(z[mode][max(int(i) - 1, 0)]) for mode in mixed])
            orders = [np.array(order) for order in permutations(whole)]
            best: Complex = orders[int(np.argmin([np.abs(order - before).sum() for order in orders]))]
            for mode, pair in zip(mixed, best, strict=True):
                z[mode][i] = pair
    return z


def _whole_pairs(members: Complex) -> list[tuple[complex, complex]]:
    """Conjugates together, reals two and two by size."""
    upper = members[members.imag > 1e-9]
    reals = np.sort(members[np.abs(members.imag) <= 1e-9].real)[::-1]
    return [(u, u.conjugate()) for u in upper.tolist()] + list(zip(reals[::2], reals[1::2], strict=False))


def _sorted_pair(pair: Complex) -> Complex:
    """Upper half plane first, then the larger real part."""
    return np.asarray(pair[np.lexsort((-pair.real, -pair.imag))])


def _tpp_curve(mu: Array, pair: Complex) -> Pair:
    mean, square = 0.5 * pair.sum(axis=-1).real, (0.25 * (pair[:, 0] - pair[:, 1]) ** 2).real
    pieces = [np.full((1, 3), np.nan)]
    for run in _smooth_runs(mean, square):
        pieces += [_with_splits(mu[run], mean[run], square[run]), np.full((1, 3), np.nan)]
    x, m, q = np.concatenate(pieces).T
    real = np.sqrt(np.maximum(q, 0.0))
    first = m + real + 1j * np.sqrt(np.maximum(-q, 0.0))
    return x, np.stack([first, np.where(q >= 0.0, m - real, np.nan) + 0j], axis=-1)


def _smooth_runs(mean: Array, square: Array) -> Iterator[slice]:
    """Stretches of rows without a jump, which a change of names at a crossing of two modes makes."""
    good = np.isfinite(mean) & np.isfinite(square)
    step = np.maximum(np.abs(np.diff(mean)), np.abs(np.diff(square)))
    beside = np.fmax(np.r_[step[1:], 0.0], np.r_[0.0, step[:-1]])
    broken = ~good[1:] | ~good[:-1] | (step > 6.0 * beside + 0.02)
    first = 0
    for last in (*np.flatnonzero(broken), len(good) - 1):
        if good[first]:
            yield slice(first, int(last) + 1)
        first = int(last) + 1


def _with_splits(x: Array, mean: Array, square: Array) -> Array:
    """(n, 3) with points graded to where the square of the half difference changes its sign."""
    parts = [np.column_stack([x, mean, square])]
    for i in np.flatnonzero((square[1:] > 0) != (square[:-1] > 0)):
        near = slice(max(i + 1 - STENCIL, 0), i + 1 + STENCIL)
        q, m = _polynomial(x[near], square[near]), _polynomial(x[near], mean[near])
        at = _zero(q, float(x[i]), float(x[i + 1]))
        for rows in (x[max(i - 1, 0) : i + 1][::-1], x[i + 1 : i + 3]):
            more = _graded(at, rows)
            value = q(more)
            value[0] = 0.0
            parts.append(np.column_stack([more, m(more), value]))
    return _in_order(parts)


# ---------------------------------------------------------------------- between rows
def _polynomial(x: Array, y: Array) -> Polynomial:
    """The polynomial through a few points."""
    middle, scale = float(x.mean()), max(float(np.ptp(x)), 1e-300) / 2.0
    c = np.polynomial.polynomial.polyfit((x - middle) / scale, y, len(x) - 1)
    return lambda at: np.asarray(np.polynomial.polynomial.polyval((np.asarray(at) - middle) / scale, c))


def _zero(f: Polynomial, a: float, b: float) -> float:
    """Where f, of opposite signs in a and b, is zero."""
    rising = f(b) > 0
    for _ in range(60):
        middle = 0.5 * (a + b)
        a, b = (a, middle) if (f(middle) > 0) == rising else (middle, b)
    return 0.5 * (a + b)


def _graded(edge: float, rows: Array) -> Array:
    """The edge, and points from it to some rows beside it, nearest first, dense at it as a square root wants."""
    stops = np.linspace(0.0, 1.0, 14)[1:-1] ** 2
    return np.concatenate([[edge], *(edge + (row - edge) * stops for row in rows)])


def _in_order(parts: Sequence[Array]) -> Array:
    table = np.concatenate(parts)
    return table[np.argsort(table[:, 0], kind="stable")]


# ---------------------------------------------------------------------- limits
class Failing(NamedTuple):
    """Where a mode fails a tolerance: first μ (inf: nowhere), intervals stored, their true count, and the cause."""

    limit: float
    intervals: tuple[tuple[float, float], ...]
    total: int
    cause: Cause
    tolerance: float
    mu_max: float


def failing(limits: Rows | None, mode: str) -> Failing | None:
    """The limit in the relative metric whose tolerance is nearest to 5 %; None where no limits were asked for."""
    if not limits or not len(limits["limit"]):
        return None
    rows = np.flatnonzero((limits["mode"] == MODES.index(mode)) & (limits["metric"] == Metric.RELATIVE))
    if not rows.size:
        return None
    i = rows[np.argmin(np.abs(limits["tolerance"][rows] - TOLERANCE))]
    count = int(limits["intervals"][i])
    ends = [(f"interval_{k}_start", f"interval_{k}_end") for k in range(1, min(count, INTERVALS) + 1)]
    return Failing(
        limit=float(limits["limit"][i]), intervals=tuple((float(limits[a][i]), float(limits[b][i])) for a, b in ends),
        total=count, cause=Cause(int(limits["cause"][i])), tolerance=float(limits["tolerance"][i]),
        mu_max=float(limits["mu_max"][i]),
    )  # fmt: skip


def all_intervals(rows: Rows, mode: str, found: Failing) -> tuple[tuple[float, float], ...]:
    """The intervals of failing that the limits store and, after the last they have room for, those of the rows."""
    if found.total <= len(found.intervals):
        return found.intervals
    rows = ordered(rows)
    mu = np.asarray(rows["advance_ratio"], float)
    bad = (np.asarray(rows[f"error_{mode}"]) > found.tolerance) & (mu > found.intervals[-1][1])
    starts, ends = np.flatnonzero(bad & ~np.r_[False, bad[:-1]]), np.flatnonzero(bad & ~np.r_[bad[1:], False])
    return (*found.intervals, *((float(mu[a]), float(mu[b])) for a, b in zip(starts, ends, strict=True)))
