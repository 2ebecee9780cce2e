"""Where errors of the modes pass tolerances, for many rotors at once.

Errors are smooth between locks' ends, splits and kinks, with square roots at both ends of a span; they are sampled in
points graded to the ends, extrema between samples that may hide two crossings are sought, and crossings of every
tolerance solved, all rotors, modes and tolerances in step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ..comparison import Cause, Metric, Rule
from .curves import Crossings
from .designs import Designs, Windows

__all__ = ["Limit", "Limits", "Wanted", "found"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Wanted = Sequence[tuple[str, Metric, float]]

SAMPLES = 96  # graded points between two edges
HUGE = 1e3  # errors beyond are all the same failure (and inf has no roots)
TOGETHER = 512  # rotors: their samples are in memory at once
ROOT = {"xatol": 1e-13, "xrtol": 1e-13, "fatol": 0.0, "frtol": 0.0}
BEYOND = 1e-12  # of the limit, where mode and cause are looked at


@dataclass(frozen=True, kw_only=True)
class Limit:
    """Where a mode of the simple model fails a tolerance.

    Attributes
    ----------
    mode, metric, tolerance
        What was asked.
    limit : float
        The first μ at which the error passes the tolerance; inf = not up to ``mu_max``.
    intervals : tuple of (μ_in, μ_out)
        Every interval where it fails; μ_out = inf: still failing at ``mu_max``.
    cause : Cause
        How exact and simple model differ in kind at the limit.
    rule : Rule
        What the mode is compared with at the limit (at ``mu_max`` without one); MEAN is no exponent of the rotor.
    lock : float
        ρ per rev of the exact lock at the limit, nan outside a lock.
    lock_edge, split_edge : float
        The lock edge and the TPP split nearest to the limit (to ``mu_max`` without a limit), nan where there is none.
    mu_max : float
    """

    mode: str
    metric: Metric
    tolerance: float
    limit: float
    intervals: tuple[tuple[float, float], ...]
    cause: Cause
    rule: Rule
    lock: float
    lock_edge: float
    split_edge: float
    mu_max: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Limits:
    """The limits of n rotors for w wanted (mode, metric, tolerance); arrays (n, w) as in :class:`Limit`.

    ``starts`` and ``ends`` hold the intervals of all, one after another, ``counts`` (n, w) how many each has.
    """

    wanted: tuple[tuple[str, Metric, float], ...]
    limit: Array
    cause: NDArray[np.int8]
    rule: NDArray[np.int8]
    lock: Array
    lock_edge: Array
    split_edge: Array
    counts: NDArray[np.int64]
    starts: Array
    ends: Array
    mu_max: float

    def intervals(self, count: int) -> tuple[Array, Array]:
        """Starts and ends of the first so many intervals, (n, w, count) each; nan where there are fewer."""
        first = np.cumsum(self.counts.ravel()) - self.counts.ravel()
        index = first[:, None] + np.arange(count)
        there = np.arange(count) < self.counts.reshape(-1, 1)
        shape = (*self.counts.shape, count)
        starts, ends = (
            np.where(there, np.append(x, math.nan)[np.where(there, index, -1)], math.nan).reshape(shape)
            for x in (self.starts, self.ends)
        )
        return starts, ends

    def of(self, case: int) -> tuple[Limit, ...]:
        """Those of one rotor."""
        starts, ends = self.intervals(int(self.counts.max(initial=0)))
        out = []
        for i, (mode, metric, tolerance) in enumerate(self.wanted):
            count = self.counts[case, i]
            spans = zip(starts[case, i, :count].tolist(), ends[case, i, :count].tolist(), strict=True)
            numbers = ("limit", "lock", "lock_edge", "split_edge")
            out.append(
                Limit(
                    mode=mode,
                    metric=metric,
                    tolerance=tolerance,
                    intervals=tuple(spans),
                    cause=Cause(int(self.cause[case, i])),
                    rule=Rule(int(self.rule[case, i])),
                    mu_max=self.mu_max,
                    **{name: float(getattr(self, name)[case, i]) for name in numbers},
                )
            )
        return tuple(out)


def found(designs: Designs, wanted: Wanted) -> Limits:
    """The limits of all designs."""
    parts = [_of_some(designs.part(start, start + TOGETHER), wanted) for start in range(0, designs.count, TOGETHER)]
    if len(parts) == 1:
        return parts[0]
    arrays = [f.name for f in fields(Limits) if f.name not in ("wanted", "mu_max")]
    joined = {name: np.concatenate([getattr(p, name) for p in parts]) for name in arrays}
    return Limits(wanted=parts[0].wanted, mu_max=designs.mu_max, **joined)


def _of_some(designs: Designs, wanted: Wanted) -> Limits:
    """The same for a batch."""
    windows, splits = designs.windows(), designs.splits()
    locks = _edges_of(windows)
    samples = _Samples(designs, *_graded(designs, locks, splits), wanted)
    which, case, x = samples.crossings()

    n, w = designs.count, len(wanted)
    failing = samples.failing_at_start()  # (n, w)
    owner = case * w + which
    order = np.lexsort((x, owner))
    starts, ends, counts = _intervals(failing.ravel(), owner[order], x[order], designs.mu_max)
    limit = np.full(n * w, math.inf)
    has = counts > 0
    limit[has] = starts[(np.cumsum(counts) - counts)[has]]

    place = np.where(has, limit, designs.mu_max)
    everyone = np.repeat(np.arange(n), w)
    there = designs.comparison(everyone, np.minimum(place + BEYOND, designs.mu_max))
    rule, cause, lock = np.empty(n * w, np.int8), np.empty(n * w, np.int8), np.empty(n * w)
    for i, (mode, _, _) in enumerate(wanted):
        some = slice(i, None, w)
        rule[some], cause[some], lock[some] = there[mode].rule[some], there[mode].cause[some], there[mode].lock[some]
    full = {
        "limit": limit,
        "cause": np.where(has, cause, int(Cause.NONE)).astype(np.int8),
        "rule": rule,
        "lock": np.where(has, lock, math.nan),
        "lock_edge": _nearest(locks, everyone, place),
        "split_edge": _nearest(splits, everyone, place),
        "counts": counts,
    }
    return Limits(
        wanted=tuple((mode, Metric(metric), float(t)) for mode, metric, t in wanted),
        starts=starts,
        ends=ends,
        mu_max=designs.mu_max,
        **{name: value.reshape(n, w) for name, value in full.items()},
    )


# ---------------------------------------------------------------------- edges
def _edges_of(windows: Windows) -> Crossings:
    """The ends of locks between hover and the last μ."""
    case, x = np.tile(windows.case, 2), np.concatenate([windows.enter, windows.leave])
    inner = (x > 0.0) & (x < math.inf)
    order = np.lexsort((x[inner], case[inner]))
    return Crossings(case=case[inner][order], x=x[inner][order], level=np.zeros(inner.sum()))


def _graded(designs: Designs, locks: Crossings, splits: Crossings) -> tuple[Places, Array]:
    """Cases and places of the samples, in order: each end of a span once."""
    ranged, start, stop = designs.ranges()
    case = np.concatenate([ranged, ranged, locks.case, splits.case])
    edge = np.concatenate([start, stop, locks.x, splits.x])
    order = np.lexsort((edge, case))
    case, edge = case[order], edge[order]
    inner = (case[1:] == case[:-1]) & (edge[1:] > edge[:-1])
    case, a, b = case[:-1][inner], edge[:-1][inner], edge[1:][inner]
    t = 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, SAMPLES)))[1:]
    x = a[:, None] + (b - a)[:, None] * t
    x[:, -1] = b
    first = np.unique(case, return_index=True)[1]
    cases = np.concatenate([case[first], np.repeat(case, SAMPLES - 1)])
    places = np.concatenate([a[first], x.ravel()])
    order = np.lexsort((places, cases))
    return cases[order], places[order]


def _nearest(edges: Crossings, case: Places, x: Array) -> Array:
    """Of the edges of its case the one nearest to each place, nan where there is none."""
    out = np.full(len(x), math.nan)
    if not len(edges.x):
        return out
    key = edges.case + 0.5 * edges.x / (1.0 + edges.x)  # in order of case, then place
    right = np.searchsorted(key, case + 0.5 * x / (1.0 + x))
    for side in (right - 1, right):
        i = np.clip(side, 0, len(edges.x) - 1)
        better = (edges.case[i] == case) & ~(np.abs(out - x) <= np.abs(edges.x[i] - x))
        out = np.where(better, edges.x[i], out)
    return out


def _intervals(failing: NDArray[np.bool_], owner: Places, x: Array, mu_max: float) -> tuple[Array, Array, Places]:
    """Intervals of failure from the state at 0 and the crossings of each owner, in order: starts, ends, counts."""
    n = len(failing)
    extra = np.flatnonzero(failing)
    owners = np.concatenate([owner, extra])
    places = np.concatenate([x, np.zeros(len(extra))])
    odd = (np.bincount(owners, minlength=n) % 2).astype(bool)  # still failing at the end
    last = np.flatnonzero(odd)
    owners, places = np.concatenate([owners, last]), np.concatenate([places, np.full(len(last), math.inf)])
    order = np.lexsort((places, owners))
    owners, places = owners[order], places[order]
    starts, ends, whose = places[::2], places[1::2], owners[::2]
    ends = np.where(ends >= mu_max, math.inf, ends)
    kept = (ends > starts) & (starts < mu_max)
    return starts[kept], ends[kept], np.bincount(whose[kept], minlength=n)


# ---------------------------------------------------------------------- curves of errors
class _Samples:
    """Errors of all wanted modes and metrics at graded places."""

    def __init__(self, designs: Designs, case: Places, x: Array, wanted: Wanted) -> None:
        self.designs, self.case, self.x = designs, case, x
        self.curves = sorted({(mode, Metric(metric)) for mode, metric, _ in wanted})
        self.which = np.array([self.curves.index((mode, Metric(metric))) for mode, metric, _ in wanted])
        self.tolerances = np.array([float(tolerance) for _, _, tolerance in wanted])
        self.errors = self.at(case, x)

    def at(self, case: Places, x: Array) -> Array:
        """The errors of every curve, (curves, k)."""
        there = self.designs.comparison(case, x)
        table = np.stack([np.minimum(there[mode].by(metric), HUGE) for mode, metric in self.curves])
        if np.any(np.isnan(table)):
            wrong = case[np.flatnonzero(np.isnan(table).any(axis=0))[0]]
            raise self.designs.overflow(int(wrong))
        return table

    def one(self, case: Array, x: Array, curve: Array) -> Array:
        """The error of one curve a place."""
        shape = x.shape
        some = self.at(case.ravel().astype(np.intp), x.ravel())
        return np.asarray(some[curve.ravel().astype(np.intp), np.arange(x.size)].reshape(shape))

    def failing_at_start(self) -> NDArray[np.bool_]:
        """Whether each wanted error is above its tolerance in hover, (n, w)."""
        first = np.unique(self.case, return_index=True)[1]
        return (self.errors[self.which][:, first] > self.tolerances[:, None]).T

    def crossings(self) -> tuple[Places, Places, Array]:
        """Which of the wanted, case and place of every crossing."""
        case, x, errors = self._with_extrema()
        parts = []
        for i, (curve, tolerance) in enumerate(zip(self.which, self.tolerances, strict=True)):
            c, t, y = case[curve], x[curve], errors[curve]
            j = np.flatnonzero((c[1:] == c[:-1]) & ((y[1:] > tolerance) != (y[:-1] > tolerance)))
            parts.append((np.full(len(j), i), c[j], t[j], t[j + 1]))
        which, cases, low, high = (np.concatenate([p[k] for p in parts]) for k in range(4))
        return which, cases, self._solved(which, cases, low, high)

    def _solved(self, which: Places, case: Places, low: Array, high: Array) -> Array:
        from scipy.optimize import elementwise

        if not len(which):
            return low
        args = (case.astype(float), self.which[which].astype(float), self.tolerances[which])
        found = elementwise.find_root(
            lambda x, c, curve, tolerance: self.one(c, x, curve) - tolerance, (low, high), args=args, tolerances=ROOT
        )
        return np.asarray(found.x)

    def _with_extrema(self) -> tuple[list[Places], list[Array], list[Array]]:
        """Samples of every curve, with the extrema between them that may lie beyond a tolerance."""
        from scipy.optimize import elementwise

        found = list(self._hidden())
        curve, i, sign = (np.concatenate([f[k] for f in found]) for k in range(3))
        value, place = np.zeros(0), np.zeros(0)
        if len(curve):
            args = (self.case[i].astype(float), curve.astype(float), sign)
            least = elementwise.find_minimum(
                lambda x, c, k, s: s * self.one(c, x, k), (self.x[i - 1], self.x[i], self.x[i + 1]),
                args=args, maxiter=30,
            )  # fmt: skip
            value, place = sign * least.f_x, least.x
        cases, places, errors = [], [], []
        for k in range(len(self.curves)):
            mine = curve == k
            c, x = np.concatenate([self.case, self.case[i[mine]]]), np.concatenate([self.x, place[mine]])
            y = np.concatenate([self.errors[k], value[mine]])
            order = np.lexsort((x, c))
            cases.append(c[order])
            places.append(x[order])
            errors.append(y[order])
        return cases, places, errors

    def _hidden(self) -> Iterator[tuple[Places, Places, Array]]:
        """Curve, sample and sign (1: a least value) of turning points between samples that a tolerance may cut.

        A parabola through three samples goes beyond the middle one by an eighth of the differences at most; here by
        all of them.
        """
        yield np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
        same = (self.case[2:] == self.case[1:-1]) & (self.case[1:-1] == self.case[:-2])
        for k, y in enumerate(self.errors):
            tolerances = np.unique(self.tolerances[self.which == k])
            for sign in (1.0, -1.0):
                before, there, after = sign * y[:-2], sign * y[1:-1], sign * y[2:]
                turning = same & (there <= before) & (there <= after) & (y[1:-1] < HUGE)
                reach = np.maximum(before, after) - there
                may = np.zeros(len(there), bool)
                for t in sign * tolerances:
                    may |= (there > t) & (there - reach <= t)
                i = np.flatnonzero(turning & may) + 1
                yield np.full(len(i), k), i, np.full(len(i), sign)
