"""Where the simple model stops: locks, splits, onset of growth and limits in μ, by root-finding.

With the half trace τ and the discriminant D = τ² - 1 of the blade's Hill form, over the period T with mean damping
-2α::

    lock              D > 0
    growth            D > sinh² αT
    split of the TPP  discriminant of its characteristic polynomial changes sign

are signs of smooth functions of μ (analytic, but where reversed flow reaches root or tip).  The discriminant of the
polynomial, and for the others asinh τ, is interpolated in Chebyshev points on panels, halved until the coefficients
fall to rounding (at most 64 panels); between the extrema and zeros of the interpolant the function is monotone, so
every change of sign is bracketed, and solved on the function itself.  Where two locks meet almost, ρ tells them apart
and the gap is found by bisection.  A window is missed only if D stays below the interpolation error (about 1e-12 of
its scale) inside it.

Errors of modes are smooth between those edges, with square roots at both ends; they are sampled in points graded to the
ends, extrema between samples are sought, and crossings of the tolerance solved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Unpack

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from .comparison import (
    Cause,
    Comparison,
    Metric,
    Model,
    Rule,
    compare,
    eigenvalues,
    exact_model,
    mode_names,
    simple_model,
)
from .errors import ParameterError, did_you_mean
from .exponents import exponents
from .models import PhysicsKeywords, teetering
from .models.flapping import blade
from .models.physics import HIGHEST
from .period_map import PeriodMap, period_map
from .rotor import Rotor

__all__ = [
    "Limit",
    "instability_onset",
    "limits",
    "lock_windows",
    "split_edges",
    "validity_intervals",
    "validity_limit",
]

Array = NDArray[np.float64]
Function = Callable[[Array], Array]
NODES = 33  # Chebyshev points a panel
DEPTH = 6  # halvings of a panel at most
RESOLVED = 1e-12  # coefficients relative to the largest: above the noise of D, below any window that matters
PROBES = 19  # places in a locked span where ρ is looked at
SAMPLES = 96  # graded points between two edges
HUGE = 1e3  # errors beyond are all the same failure (and inf has no roots)
WIDTH = 1e-9  # windows narrower than this are not reported
ROOT = {"xatol": 1e-13, "xrtol": 1e-13, "fatol": 0.0, "frtol": 0.0}


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


# ---------------------------------------------------------------------- public
def validity_limit(
    rotor: Rotor,
    tolerance: float = 0.05,
    mode: str = "regressing",
    mu_max: float = 1.0,
    *,
    metric: Metric = Metric.RELATIVE,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Any:
    """The first μ at which the TPP error of ``mode`` passes ``tolerance``; inf = not up to ``mu_max``.

    Arrays of rotor parameters give an array of limits.
    """
    return _each(
        rotor,
        lambda r: (
            limits(r, tolerances=((metric, tolerance),), modes=(mode,), mu_max=mu_max, model=model, **options)[0].limit
        ),
        float,
    )


def validity_intervals(
    rotor: Rotor,
    tolerance: float = 0.05,
    mode: str = "regressing",
    mu_max: float = 1.0,
    *,
    metric: Metric = Metric.RELATIVE,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Any:
    """Every (μ_in, μ_out) where the TPP error of ``mode`` passes ``tolerance``; μ_out = inf: failing at ``mu_max``.

    Arrays of rotor parameters give a list, one list of intervals a rotor.
    """
    return _each(
        rotor,
        lambda r: list(
            limits(r, tolerances=((metric, tolerance),), modes=(mode,), mu_max=mu_max, model=model, **options)[
                0
            ].intervals
        ),
        list,
    )


def lock_windows(
    rotor: Rotor, mu_max: float = 1.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """Windows [(enter, leave, per_rev)] in μ where the exact pair is locked at ρ = per_rev, in order.

    enter = 0.0: locked in hover; leave = inf: still locked at ``mu_max``.  Arrays of parameters give a list of such
    lists.
    """
    return _each(rotor, lambda r: _Rotor(r, mu_max, model, options).windows(), list)


def instability_onset(
    rotor: Rotor, mu_max: float = 3.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """The first μ with growth; 0.0 if already in hover, inf if none up to ``mu_max``."""
    return _each(rotor, lambda r: _Rotor(r, mu_max, model, options).onset(), float)


def split_edges(
    rotor: Rotor, mu_max: float = 1.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """Every μ where a pair of TPP eigenvalues splits on the real axis or merges again."""
    return _each(rotor, lambda r: _Rotor(r, mu_max, model, options).splits(), list)


def limits(
    rotor: Rotor,
    *,
    tolerances: Sequence[tuple[Metric, float]] = ((Metric.RELATIVE, 0.05),),
    modes: Sequence[str] | None = None,
    mu_max: float = 1.0,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> tuple[Limit, ...]:
    """Limits of one rotor (no arrays) for every mode and (metric, tolerance), with intervals and causes."""
    if rotor.shape:
        raise ParameterError(
            "rotor",
            rotor.shape,
            f"limits() takes one rotor, not an array of shape {rotor.shape}: use validity_limit, or index the rotor",
        )
    for metric, tolerance in tolerances:
        if not (isinstance(tolerance, (int, float, np.number)) and 0 < tolerance < math.inf):
            raise ParameterError(
                "tolerance",
                tolerance,
                f"{tolerance!r} is no tolerance: give a positive number (0.05 is 5 % for a relative metric)",
            )
        if metric not in tuple(Metric):
            known_metrics = ", ".join(f"Metric.{m.name}" for m in Metric)
            raise ParameterError("metric", metric, f"{metric!r} is no metric: give one of {known_metrics}")
    one = _Rotor(rotor, mu_max, model, options)
    known = mode_names(rotor, model)
    for mode in modes or ():
        if mode not in known:
            raise ParameterError(
                "mode",
                mode,
                f"{mode!r} is not a mode of this rotor{did_you_mean(mode, known)}; it has {', '.join(known)}",
            )
    return one.limits([(mode, Metric(m), float(t)) for mode in (modes or known) for m, t in tolerances])


# ---------------------------------------------------------------------- one rotor
class _Rotor:
    """One rotor along μ from 0 to ``mu_max``."""

    def __init__(self, rotor: Rotor, mu_max: float, model: Model | None, options: PhysicsKeywords) -> None:
        if not (isinstance(mu_max, (int, float, np.number)) and 0 < mu_max <= HIGHEST):
            raise ParameterError(
                "mu_max",
                mu_max,
                f"{mu_max!r} is no end of the search: give an advance ratio above 0, {HIGHEST:g} at most",
            )
        self.rotor, self.mu_max, self.options = rotor, float(mu_max), options
        self.model: Model = exact_model(rotor, model)

    def map(self, mu: Array) -> PeriodMap:
        return period_map((teetering if self.model == "teetering" else blade)(self.rotor, mu, **self.options))

    def comparison(self, mu: Array) -> Comparison:
        return compare(self.rotor, mu, model=self.model, **self.options)

    def breaks(self) -> list[float]:
        """Where the functions of μ are not analytic: reversed flow reaching root and tip."""
        if not self.options.get("reversed_flow", False):
            return [0.0, self.mu_max]
        root, tip = (
            max(float(self.rotor.hinge_offset), float(self.rotor.root_cutout)),
            float(self.options.get("tip_loss", 1.0)),
        )
        return [0.0, *(x for x in sorted({root, tip}) if 0.0 < x < self.mu_max), self.mu_max]

    def changes(self, f: Function, guide: Function | None = None) -> list[float]:
        """Every change of sign of ``f``."""
        return [x for a, b in pairwise(self.breaks()) for x in sign_changes(f, a, b, guide)]

    def discriminant(self, mu: Array) -> Array:
        """D, bounded."""
        return _bounded(self.map(mu).discriminant, 0.0)

    def half_trace(self, mu: Array) -> Array:
        """asinh of τ over its value at the onset of growth: zeros and extrema as τ has, but no decades."""
        phi = self.map(mu)
        return np.arcsinh(phi.half_trace / np.cosh(phi.mean * phi.period))

    def windows(self) -> list[tuple[float, float, float]]:
        edges = [0.0, *self.changes(self.discriminant, self.half_trace), self.mu_max]
        spans = [(a, b) for a, b in pairwise(edges) if b - a > WIDTH]
        locked = self.locks(np.array([0.5 * (a + b) for a, b in spans]))
        found = [
            w for (a, b), rho in zip(spans, locked, strict=True) if not math.isnan(rho) for w in self._separated(a, b)
        ]
        return [(a, math.inf if b == self.mu_max else b, rho) for a, b, rho in found]

    def locks(self, mu: Array) -> Array:
        """ρ of the lock at each μ, nan outside."""
        return np.atleast_1d(exponents(self.map(mu)).lock)

    def _separated(self, a: float, b: float) -> list[tuple[float, float, float]]:
        """A span that seems locked throughout, cut where ρ shows that a narrow gap parts two locks."""
        mu = a + (b - a) * 0.5 * (1.0 - np.cos(np.linspace(0.02, math.pi - 0.02, PROBES)))
        rho = self.locks(mu)
        mu, rho = mu[~np.isnan(rho)], rho[~np.isnan(rho)]
        changes = np.flatnonzero(rho[:-1] != rho[1:])
        if not changes.size:
            return [(a, b, float(rho[0]))] if rho.size else []
        i = changes[0]
        low, high = self._gap(float(mu[i]), float(mu[i + 1]), 0.5 * float(rho[i] + rho[i + 1]))
        return [*self._separated(a, low), *self._separated(high, b)]

    def _gap(self, low: float, high: float, between: float) -> tuple[float, float]:
        """The ends of the unlocked gap between two locked μ whose ρ lie on either side of ``between``."""
        rising = exponents(self.map(np.array([low]))).rotation_number[0] < between
        while high - low > 1e-14:
            middle = 0.5 * (low + high)
            state = exponents(self.map(np.array([middle])))
            if math.isnan(state.lock[0]):
                points = np.array([low, middle, high])
                ends = _solve(self.discriminant, points, self.discriminant(points))
                return (ends[0], ends[-1]) if ends else (middle, middle)
            low, high = (middle, high) if (state.rotation_number[0] < between) == rising else (low, middle)
        return low, high

    def onset(self) -> float:
        def excess(mu: Array) -> Array:
            phi = self.map(mu)
            return _bounded(phi.discriminant, np.sinh(phi.mean * phi.period) ** 2)

        if excess(np.zeros(1))[0] > 0:
            return 0.0
        found = self.changes(excess, self.half_trace)
        return found[0] if found else math.inf

    def splits(self) -> list[float]:
        return self.changes(
            lambda mu: _polynomial_discriminant(
                eigenvalues(simple_model(self.rotor, mu, model=self.model, **self.options))
            )
        )

    def limits(self, wanted: Sequence[tuple[str, Metric, float]]) -> tuple[Limit, ...]:
        windows, splits = self.windows(), self.splits()
        locks = sorted({x for a, b, _ in windows for x in (a, b) if 0.0 < x < math.inf})
        edges = sorted({*self.breaks(), *locks, *splits})
        graded = [a + (b - a) * 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, SAMPLES))) for a, b in pairwise(edges)]
        crossings = self._crossings(np.unique(np.concatenate(graded)), wanted)
        firsts = np.array([ins[0][0] if ins else self.mu_max for ins in crossings])
        there = self.comparison(np.minimum(firsts + 1e-12, self.mu_max))
        out = []
        for i, ((mode, metric, tolerance), intervals) in enumerate(zip(wanted, crossings, strict=True)):
            limit = intervals[0][0] if intervals else math.inf
            out.append(
                Limit(
                    mode=mode,
                    metric=metric,
                    tolerance=tolerance,
                    limit=limit,
                    intervals=tuple(intervals),
                    mu_max=self.mu_max,
                    cause=Cause(int(there[mode].cause[i])) if intervals else Cause.NONE,
                    rule=Rule(int(there[mode].rule[i])),
                    lock=float(there[mode].lock[i]) if intervals else math.nan,
                    lock_edge=_nearest(locks, firsts[i]),
                    split_edge=_nearest(splits, firsts[i]),
                )
            )
        return tuple(out)

    def _crossings(self, mu: Array, wanted: Sequence[tuple[str, Metric, float]]) -> list[list[tuple[float, float]]]:
        """For each of ``wanted``, the intervals where the error is above the tolerance; all are solved together."""
        curves = sorted({(mode, metric) for mode, metric, _ in wanted})
        which = [curves.index((mode, metric)) for mode, metric, _ in wanted]

        def errors(x: Array) -> Array:
            found = self.comparison(x)
            table = np.stack([np.minimum(found[mode].by(metric), HUGE) for mode, metric in curves])
            if np.any(np.isnan(table)):
                gamma = float(self.rotor.lock_number)
                raise ParameterError(
                    "lock_number", gamma, f"{gamma:g} is beyond what doubles hold: the period map overflows"
                )
            return table

        def error(x: Array, curve: Array) -> Array:
            return errors(x.ravel())[curve.astype(int).ravel(), np.arange(x.size)].reshape(x.shape)

        sampled = [_with_extrema(mu, y, extra) for y, extra in zip(*_all_extrema(error, mu, errors(mu)), strict=True)]
        tolerances = [tolerance for _, _, tolerance in wanted]
        roots = _all_roots(error, [sampled[c] for c in which], which, tolerances)
        return [
            _intervals(sampled[c][1][0] > tolerance, found, self.mu_max)
            for c, tolerance, found in zip(which, tolerances, roots, strict=True)
        ]


# ---------------------------------------------------------------------- roots of smooth functions
def sign_changes(f: Function, a: float, b: float, guide: Function | None = None) -> list[float]:
    """Every change of sign of a smooth vectorised ``f`` in (a, b), to rounding.

    ``guide`` (by default f itself) is interpolated in Chebyshev points on panels, halved until resolved; f must be
    monotone between the ends, the extrema and the zeros of the guide.
    """
    points = np.unique(_turning_points(guide or f, a, b, 0))
    values = f(points)
    if values[0] == 0.0:  # a root at the very start is no change of sign inside
        values[0] = values[1]
    return _solve(f, points, values)


def _turning_points(f: Function, a: float, b: float, depth: int) -> Array:
    """Ends, extrema and zeros of ``f`` on [a, b]."""
    x = chebyshev.chebpts2(NODES)
    y = f(0.5 * (a + b) + 0.5 * (b - a) * x)
    c = chebyshev.chebfit(x, y, NODES - 1)
    if depth < DEPTH and np.abs(c[-4:]).max() > RESOLVED * np.abs(c).max():
        middle = 0.5 * (a + b)
        return np.concatenate([_turning_points(f, a, middle, depth + 1), _turning_points(f, middle, b, depth + 1)])
    keep = np.flatnonzero(np.abs(c) > 1e-15 * np.abs(c).max())
    series = c[: keep[-1] + 1] if keep.size else np.zeros(1)
    roots = [chebyshev.chebroots(p) for p in (series, chebyshev.chebder(series)) if len(p) > 1]
    found = np.concatenate([np.empty(0, complex), *roots])
    real = np.clip(found.real[np.abs(found.imag) < 1e-3], -1.0, 1.0)
    return np.concatenate([[a, b], 0.5 * (a + b) + 0.5 * (b - a) * real])


def _solve(f: Callable[[Array], Array], x: Array, y: Array) -> list[float]:
    """Roots between neighbours of opposite sign."""
    from scipy.optimize import elementwise

    i = np.flatnonzero((y[:-1] > 0) != (y[1:] > 0))
    if not i.size:
        return []
    return [float(r) for r in elementwise.find_root(f, (x[i], x[i + 1]), tolerances=ROOT).x]


# ---------------------------------------------------------------------- many error curves at once
Curve = tuple[Array, Array]


def _all_extrema(error: Callable[[Array, Array], Array], x: Array, y: Array) -> tuple[Array, list[Curve]]:
    """Extrema between samples of every curve y (curves, samples), where a pair of crossings may hide."""
    from scipy.optimize import elementwise

    sign = np.stack([np.ones_like(y), -np.ones_like(y)])  # minima, maxima
    inner = (sign * y)[..., 1:-1]
    turning = (inner <= (sign * y)[..., :-2]) & (inner <= (sign * y)[..., 2:]) & (y[:, 1:-1] < HUGE)
    kind, curve, i = np.nonzero(turning)
    if not i.size:
        return y, [(x[:0], x[:0])] * len(y)
    args = (curve.astype(float), np.where(kind == 0, 1.0, -1.0))
    found = elementwise.find_minimum(lambda t, c, s: s * error(t, c), (x[i], x[i + 1], x[i + 2]), args=args, maxiter=30)
    value = args[1] * found.f_x
    return y, [(found.x[curve == c], value[curve == c]) for c in range(len(y))]


def _with_extrema(x: Array, y: Array, extra: Curve) -> Curve:
    """Samples and extrema in order."""
    x, y = np.concatenate([x, extra[0]]), np.concatenate([y, extra[1]])
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


def _all_roots(
    error: Callable[[Array, Array], Array], sampled: Sequence[Curve], which: Sequence[int], tolerances: Sequence[float]
) -> list[list[float]]:
    """Where each sampled curve crosses its tolerance."""
    from scipy.optimize import elementwise

    brackets = [np.flatnonzero((y[:-1] > t) != (y[1:] > t)) for (_, y), t in zip(sampled, tolerances, strict=True)]
    owner = np.repeat(np.arange(len(sampled)), [len(b) for b in brackets])
    if not owner.size:
        return [[] for _ in sampled]
    low, high = (np.concatenate([x[b + k] for (x, _), b in zip(sampled, brackets, strict=True)]) for k in (0, 1))
    args = (np.array(which, float)[owner], np.array(tolerances)[owner])
    roots = elementwise.find_root(lambda t, c, tol: error(t, c) - tol, (low, high), args=args, tolerances=ROOT).x
    return [[float(r) for r in roots[owner == k]] for k in range(len(sampled))]


def _intervals(failing: bool, roots: Sequence[float], mu_max: float) -> list[tuple[float, float]]:
    """Intervals of failure from the roots and the state at 0."""
    out = []
    for a, b in pairwise([0.0, *roots, mu_max]):
        if failing and b > a:
            out.append((a, math.inf if b == mu_max else b))
        failing = not failing
    return out


def _bounded(D: Array, level: Array | float) -> Array:
    """D - level on a scale from -1 to 1 (D ≥ -1), smooth in both."""
    return np.asarray((D - level) / (np.maximum(2.0 + D, 1.0) + level))


def _polynomial_discriminant(roots: NDArray[np.complex128]) -> Array:
    """Π (s_i - s_j)² of the eigenvalues: real, negative for an odd number of complex pairs."""
    i, j = np.triu_indices(roots.shape[-1], 1)
    return np.asarray(np.prod(roots[..., i] - roots[..., j], axis=-1) ** 2).real


def _nearest(edges: Sequence[float], mu: float) -> float:
    return min(edges, key=lambda e: abs(e - mu)) if edges else math.nan


def _each(rotor: Rotor, f: Callable[[Rotor], Any], kind: type) -> Any:
    """f for a rotor, or for each rotor of an array."""
    if not rotor.shape:
        return f(rotor)
    values = [f(rotor[index]) for index in np.ndindex(rotor.shape)]
    return np.array(values).reshape(rotor.shape) if kind is float else values
