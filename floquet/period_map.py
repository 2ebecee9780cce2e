"""The map of the motion over one period, as factors with an error each.

One blade (a second-order scalar equation) is mapped in Hill form: with β = exp(-½∫d) y::

    y'' + q y = 0,     q = k - d'/2 - d²/4,     det Φ = 1,    exponents = α ± ν,  α = -mean(d)/2

so that both exponents keep all their digits; where d jumps by Δ, y' jumps by ½Δ y.  Anything else is mapped as it is,
and the factors are kept apart because their product would lose the small multipliers.

Panels follow from the case alone (its stiffness and damping, then the error measured on it), never from its neighbours.
The error of a panel is the difference between p = 16 and p = 12 nodes, which is the error of the worse of the two,
plus an allowance for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .collocation import Rule, first_order_panel, gauss_rule, second_order_panel
from .errors import ParameterError
from .periodic import PeriodicMatrix, PeriodicSystem
from .rotor import Word

__all__ = ["Method", "PeriodMap", "period_map"]

Array = NDArray[np.float64]

NODES, COARSE_NODES = 16, 12
EPS = float(np.finfo(float).eps)
LADDER = tuple(sorted({2**k for k in range(1, 13)} | {3 * 2**k for k in range(11)}))
RUNGS = (
    6  # eight times the first number of panels: what is smooth is resolved by then, other places need kinks declared
)
SWEEP = 3.0  # panel length times the largest local frequency: below half a turn (π), so that turns can be counted
TRUNCATION = 6e-15  # relative to the panel's map, about the noise in the difference of two collocations
ROUNDING = 8.0  # eps a panel, relative to its map: the true errors of 20 000 random blades reach half of the bound
CASES_AT_ONCE = 4096  # (p n)² doubles a case: 8 MB of matrices for one blade


class Method(Word):
    """How exponents were found."""

    HILL = 0  # collocation of the Hill form of one scalar equation
    FACTORS = 1  # collocation of the states, exponents from the factors
    EIGENVALUES = 2  # constant coefficients


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodMap:
    """Φ over one period with its error.

    Attributes
    ----------
    method : Method
    period : float
    twist : (n,) or None
        The motion after a period is twist·Φ.
    hill : (cases, 2, 2)
        Φ of the Hill form (method HILL only), determinant 1.
    factors : tuple of (panels, n, n)
        One a case, first panel first (method FACTORS only).
    half_trace_error, discriminant_error : (cases,)
        Bounds of the errors of τ and D (HILL).
    errors : tuple of (panels,)
        Bound of the Frobenius norm of each factor's error (FACTORS).
    mean : (cases,)
        α = -mean(d)/2 (HILL), or the mean trace of A (FACTORS).
    states : int
    turns : (cases,)
        Revolutions of (y, y') clockwise, less than half a turn from the rotation number (HILL; else nan).
    panels : (cases,)
    shape : tuple
        Shape of the cases.
    """

    method: Method
    period: float
    shape: tuple[int, ...]
    mean: Array
    panels: NDArray[np.int32]
    twist: Array | None = None
    hill: Array | None = None
    factors: tuple[Array, ...] = ()
    half_trace_error: Array | None = None
    discriminant_error: Array | None = None
    errors: tuple[Array, ...] = ()
    turns: Array | None = None
    states: int = 2

    @property
    def half_trace(self) -> Array:
        """τ = ½ tr Φ of the Hill form: |τ| ≤ 1 is a complex pair, |τ| > 1 a lock."""
        assert self.hill is not None
        return 0.5 * (self.hill[:, 0, 0] + self.hill[:, 1, 1])

    @property
    def discriminant(self) -> Array:
        """((Φ₁₁-Φ₂₂)/2)² + Φ₁₂ Φ₂₁ = τ² - 1 without the cancellation; positive in a lock."""
        assert self.hill is not None
        return (0.5 * (self.hill[:, 0, 0] - self.hill[:, 1, 1])) ** 2 + self.hill[:, 0, 1] * self.hill[:, 1, 0]


def period_map(system: PeriodicSystem, *, panels: int | None = None) -> PeriodMap:
    """Map ``system`` over its period.

    Parameters
    ----------
    system : PeriodicSystem
        Not constant.
    panels : int, optional
        Fix the number of panels a period (for convergence studies); the error says what came of it.
    """
    if panels is not None and not 1 <= panels <= LADDER[-1]:
        raise ParameterError(
            "panels", panels, f"{panels} is no number of panels: give 1 to {LADDER[-1]}, or leave it out"
        )
    if system.constant:
        raise ParameterError(
            "system",
            system.name,
            "a constant system has no period to be mapped over: use stability(), which takes its eigenvalues",
        )
    if system.second_order and system.degrees == 1:
        return _hill_map(system, panels)
    return _factor_map(system, panels)


# ---------------------------------------------------------------------- one scalar equation, Hill form
def hill_form(system: PeriodicSystem) -> tuple[PeriodicMatrix, Array, Array | None]:
    """q, α and the kicks ½Δ at the edges (cases, pieces), None where d does not jump."""
    assert system.stiffness is not None
    k = system.stiffness
    d = system.damping if system.damping is not None else PeriodicMatrix.constant(np.zeros((1, 1)), k.period)
    if k.edges is not None:
        d = d + 0 * k  # on the pieces of q
    q = k - d.derivative() / 2 - (d @ d) / 4
    if q.edges is None:
        return q, -0.5 * d.mean()[..., 0, 0], None
    kicks = 0.5 * d.jumps()[..., 0, 0]
    kicks = np.where(np.abs(kicks) <= 1e-14 * (1.0 + d.bound()[..., 0, :]), 0.0, kicks)  # the rounding of equal values
    return q, -0.5 * d.mean()[..., 0, 0], kicks if np.any(kicks) else None


def _hill_map(system: PeriodicSystem, panels: int | None) -> PeriodMap:
    q, alpha, kicks = hill_form(system)
    shape = system.cases
    q = _flat(q, shape)
    n = math.prod(shape)
    if kicks is not None:
        kicks = np.broadcast_to(kicks, (*shape, kicks.shape[-1])).reshape(n, -1)
    hill, tau_error, D_error, turns, used = (
        np.empty((n, 2, 2)),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n, np.int32),
    )

    def solve(index: NDArray[np.intp], counts: tuple[int, ...]) -> NDArray[np.bool_]:
        part = q.case(index)
        maps, own, balances, done = [], [], [], np.ones(len(index), bool)
        for panel in _panels(part, system.period, counts):

            def mapped(rule: Rule, panel: _Panel = panel) -> Array:
                return second_order_panel(None, panel.matrix.sample(panel.nodes(rule)), panel.half, rule)

            balance = _balance(panel.half)
            F, error = _estimated(mapped, balance)
            done &= _resolved(F, error, balance)
            if panel.begins is not None and kicks is not None:
                inside = (
                    panel.centre - panel.half < system.period
                )  # pieces beyond the period have no length, and no kick
                F[:, :, 0] += F[:, :, 1] * np.where(inside, kicks[index, panel.begins], 0.0)[:, None]
            maps.append(F)
            own.append(error)
            balances.append(balance)
        before = _products(maps)
        hill[index], turns[index] = before[-1], _turns(before)
        tau_error[index], D_error[index] = trace_and_discriminant_errors(
            maps, before, [e[:, None, None] / b for e, b in zip(own, balances, strict=True)]
        )
        used[index] = len(maps)
        return done

    _refine(solve, _piece_lengths(q, system.period), np.sqrt(q.bound()[:, 0, 0]), system.period, panels)
    alpha = np.broadcast_to(alpha, shape).reshape(n)
    return PeriodMap(
        method=Method.HILL,
        period=system.period,
        shape=shape,
        mean=alpha,
        panels=used,
        hill=hill,
        half_trace_error=tau_error,
        discriminant_error=D_error,
        turns=turns,
    )


def _balance(h: Array) -> Array:
    """Multiplies maps of (y, y') entry by entry into maps of (y, h y'), in which a panel's rounding is of one size."""
    unit = np.where(h > 0, h, 1.0)
    out = np.ones((len(h), 2, 2))
    out[:, 0, 1], out[:, 1, 0] = 1.0 / unit, unit
    return out


def _products(maps: list[Array]) -> list[Array]:
    """I, F₁, F₂F₁, … Φ."""
    before = [np.broadcast_to(np.eye(2), maps[0].shape)]
    for F in maps:
        before.append(F @ before[-1])
    return before


def trace_and_discriminant_errors(maps: list[Array], before: list[Array], deltas: list[Array]) -> tuple[Array, Array]:
    """Bounds of the errors of τ and D when every entry of every factor may be wrong by ``deltas``.

    With Φ = S F P, the gradient of τ with respect to F is ½ P S and that of D is P (Φ - τI) S; what follows to second
    order is D's own, (dτ)² and the product of the off-diagonal errors.
    """
    phi = before[-1]
    tau = 0.5 * (phi[:, 0, 0] + phi[:, 1, 1])
    traceless = phi - tau[:, None, None] * np.eye(2)
    first, second, entries = np.zeros(len(phi)), np.zeros(len(phi)), np.zeros(phi.shape)
    S = np.broadcast_to(np.eye(2), phi.shape)
    for F, P, delta in zip(maps[::-1], before[-2::-1], deltas[::-1], strict=True):
        weight = np.swapaxes(delta, -1, -2)
        first += 0.5 * _total(np.abs(P @ S) * weight)
        second += _total(np.abs(P @ traceless @ S) * weight)
        entries += np.abs(S) @ delta @ np.abs(P)
        S = S @ F
    spread = 0.5 * (entries[:, 0, 0] + entries[:, 1, 1])
    return first, second + spread * spread + entries[:, 0, 1] * entries[:, 1, 0]


def _turns(before: list[Array]) -> Array:
    """Revolutions of (y, y') clockwise on the way."""
    angle = np.zeros(len(before[0]))
    for a, b in pairwise(m[:, :, 0] for m in before):
        angle += np.arctan2(a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1], a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])
    return np.asarray(angle / (2.0 * math.pi))


def _total(m: Array) -> Array:
    """Sum of the entries of 2×2 matrices."""
    return np.asarray(m[:, 0, 0] + m[:, 0, 1] + m[:, 1, 0] + m[:, 1, 1])


# ---------------------------------------------------------------------- any system, factors kept
def _factor_map(system: PeriodicSystem, panels: int | None) -> PeriodMap:
    shape = system.cases
    n = math.prod(shape)
    factors: list[Array] = [np.empty(0)] * n
    errors: list[Array] = [np.empty(0)] * n
    used = np.empty(n, np.int32)
    flat = _flat_system(system, shape)
    anchor = _anchor(flat)

    def solve(index: NDArray[np.intp], counts: tuple[int, ...]) -> NDArray[np.bool_]:
        part = _case_system(flat, index)
        maps, own, done = [], [], np.ones(len(index), bool)
        for panel in _panels(anchor.case(index), system.period, counts):

            def mapped(rule: Rule, panel: _Panel = panel) -> Array:
                return _state_panel(part, panel, rule, index)

            F, error = _estimated(mapped)
            done &= _resolved(F, error)
            maps.append(F)
            own.append(error)
        for place, case in enumerate(index):
            factors[case] = np.stack([F[place] for F in maps])
            errors[case] = np.stack([e[place] for e in own])
        used[index] = len(maps)
        return done

    frequency, trace = _frequency_and_trace(flat, n)
    _refine(solve, _piece_lengths(anchor, system.period), np.broadcast_to(frequency, (n,)), system.period, panels)
    return PeriodMap(
        method=Method.FACTORS,
        period=system.period,
        shape=shape,
        mean=np.broadcast_to(trace, (n,)),
        panels=used,
        twist=system.twist,
        factors=tuple(factors),
        errors=tuple(errors),
        turns=np.full(n, np.nan),
        states=system.states,
    )


def _state_panel(system: PeriodicSystem, panel: _Panel, rule: Rule, index: NDArray[np.intp]) -> Array:
    """Map of the state over a panel, for the cases ``index`` of the system."""
    psi = panel.nodes(rule)
    if system.stiffness is not None:
        K = system.stiffness.sample(psi)
        D = None if system.damping is None else np.broadcast_to(system.damping.sample(psi), K.shape)
        return second_order_panel(D, K, panel.half, rule)
    if system.matrix is not None:
        return first_order_panel(system.matrix.sample(psi), panel.half, rule)
    A = _flat_samples(system, psi[0])  # the same nodes for every case
    return first_order_panel(A[index], panel.half, rule)


def _flat_samples(system: PeriodicSystem, psi: Array) -> Array:
    """A(ψ) of a function for all its cases along one axis."""
    assert system.function is not None
    A = system.function(psi)
    return np.broadcast_to(A, (*system.cases, *A.shape[-3:])).reshape(-1, *A.shape[-3:])


def _anchor(system: PeriodicSystem) -> PeriodicMatrix:
    """A matrix that carries the pieces of the system."""
    if system.function is None:
        for part in (system.stiffness, system.damping, system.matrix):
            if part is not None and part.edges is not None:
                return part
        part = system.stiffness if system.stiffness is not None else system.matrix
        assert part is not None
        return part
    zero = PeriodicMatrix.constant(np.zeros((math.prod(system.cases), 1, 1)), system.period)
    inner = np.asarray(system.kinks if system.kinks is not None else [], float)
    return replace(zero, edges=np.concatenate([[0.0], inner, [system.period]])[None, :]) if inner.size else zero


def _frequency_and_trace(system: PeriodicSystem, n: int) -> tuple[Array, Array]:
    """Largest local frequency, which sets the panels, and the mean trace of A."""
    if system.stiffness is not None:
        K = system.stiffness.bound().sum(axis=-1).max(axis=-1)
        if system.damping is None:
            return np.sqrt(K), np.zeros(n)
        return np.maximum(np.sqrt(K), system.damping.bound().sum(axis=-1).max(axis=-1)), -np.trace(
            system.damping.mean(), axis1=-2, axis2=-1
        )
    if system.matrix is not None:
        return system.matrix.bound().sum(axis=-1).max(axis=-1), np.trace(system.matrix.mean(), axis1=-2, axis2=-1)
    assert system.function is not None
    edges = np.concatenate(
        [[0.0], np.asarray(system.kinks if system.kinks is not None else [], float), [system.period]]
    )
    rule, pieces = (
        gauss_rule(32),
        [(a + s * (b - a) / 4, (b - a) / 8) for a, b in pairwise(edges) for s in range(4)],
    )
    frequency, trace = np.zeros(n), np.zeros(n)
    for start, half in pieces:
        A = _flat_samples(system, start + half * (1.0 + rule.nodes))
        frequency = np.maximum(frequency, np.abs(A).sum(axis=-1).max(axis=(-1, -2)))
        trace = trace + half * np.trace(A, axis1=-2, axis2=-1) @ rule.weights
    return frequency, trace / system.period


# ---------------------------------------------------------------------- panels
def _flat(matrix: PeriodicMatrix, shape: tuple[int, ...]) -> PeriodicMatrix:
    """Cases along one axis."""
    n = math.prod(shape)
    c = np.broadcast_to(matrix.coefficients, shape + matrix.coefficients.shape[-4:]).reshape(
        n, *matrix.coefficients.shape[-4:]
    )
    edges = matrix.edges
    if edges is not None:
        edges = np.broadcast_to(edges, shape + edges.shape[-1:]).reshape(n, edges.shape[-1])
    return replace(matrix, coefficients=c, edges=edges)


def _flat_system(system: PeriodicSystem, shape: tuple[int, ...]) -> PeriodicSystem:
    """Cases along one axis, all matrices on the same pieces."""
    if system.function is not None:
        return system
    if system.matrix is not None:
        return replace(system, matrix=_flat(system.matrix, shape))
    assert system.stiffness is not None
    D = system.damping if system.damping is not None else 0.0 * system.stiffness
    K = system.stiffness + 0.0 * D
    return replace(system, stiffness=_flat(K, shape), damping=_flat(D + 0.0 * system.stiffness, shape))


def _case_system(system: PeriodicSystem, index: NDArray[np.intp]) -> PeriodicSystem:
    parts = {n: m.case(index) for n in ("damping", "stiffness", "matrix") if (m := getattr(system, n)) is not None}
    return replace(system, **parts) if parts else system


def _piece_lengths(matrix: PeriodicMatrix, period: float) -> Array:
    """Length of every piece inside one period of the system, (cases, pieces)."""
    n = matrix.coefficients.shape[0]
    if matrix.edges is None:
        return np.full((n, 1), period)
    return np.broadcast_to(np.diff(np.minimum(matrix.edges, period), axis=-1), (n, matrix.edges.shape[-1] - 1))


class _Panel(NamedTuple):
    """A panel of every case: its piece, centre and half length (cases,), and the piece it begins, if it does."""

    matrix: PeriodicMatrix
    centre: Array
    half: Array
    begins: int | None

    def nodes(self, rule: Rule) -> Array:
        """Azimuths (cases, p) of a rule's nodes."""
        return self.centre[:, None] + self.half[:, None] * rule.nodes


def _panels(matrix: PeriodicMatrix, period: float, counts: tuple[int, ...]) -> Iterator[_Panel]:
    """The panels of every case in order, ``counts`` of them on each piece."""
    n = matrix.coefficients.shape[0]
    ends = np.array([0.0, period]) if matrix.edges is None else np.minimum(matrix.edges, period)
    edges = np.broadcast_to(ends, (n, len(counts) + 1))
    for j, count in enumerate(counts):
        one = slice(j, j + 1) if matrix.edges is not None else slice(None)
        piece = replace(matrix, coefficients=matrix.coefficients[:, one], edges=None)
        start, half = edges[:, j], (edges[:, j + 1] - edges[:, j]) / (2 * count)
        for s in range(count):
            yield _Panel(piece, start + (2 * s + 1) * half, half, j if s == 0 else None)


def _estimated(panel: Callable[[Rule], Array], balance: Array | float = 1.0) -> tuple[Array, Array]:
    """A panel's map and the bound of its error, in balanced coordinates."""
    F = panel(gauss_rule(NODES))
    return F, _norm((F - panel(gauss_rule(COARSE_NODES))) * balance) + ROUNDING * EPS * _norm(F * balance)


def _resolved(F: Array, error: Array, balance: Array | float = 1.0) -> NDArray[np.bool_]:
    """Whether truncation is at the level of rounding."""
    return np.asarray(error <= (TRUNCATION + ROUNDING * EPS) * _norm(F * balance))


def _refine(
    solve: Callable[[NDArray[np.intp], tuple[int, ...]], NDArray[np.bool_]],
    lengths: Array,
    frequency: Array,
    period: float,
    panels: int | None,
) -> None:
    """Solve every case on the first rung of the ladder that resolves it."""
    wanted = (
        np.full(len(frequency), panels)
        if panels
        else np.maximum(np.ceil(period * np.maximum(frequency, 1.0) / SWEEP), 1)
    )
    rung = np.minimum(np.searchsorted(LADDER, wanted), len(LADDER) - 1)
    last = np.minimum(rung + RUNGS, len(LADDER) - 1)
    pending = np.arange(len(frequency))
    while pending.size:
        total = wanted[pending] if panels else np.asarray(LADDER)[rung[pending]]
        counts = np.maximum(np.ceil(total[:, None] * lengths[pending] / period - 1e-9), 1).astype(int)
        kinds, member = np.unique(counts, axis=0, return_inverse=True)
        unresolved = []
        for kind, count in enumerate(kinds):
            group = pending[member.ravel() == kind]
            for chunk in np.split(group, range(CASES_AT_ONCE, len(group), CASES_AT_ONCE)):
                done = solve(chunk, tuple(int(c) for c in count))
                unresolved.append(chunk[~done])
        pending = np.concatenate(unresolved)
        pending = pending[:0] if panels else pending[rung[pending] < last[pending]]
        rung[pending] += 1


def _norm(m: Array) -> Array:
    """Frobenius norm."""
    return np.sqrt(np.sum(m * m, axis=(-2, -1)))
