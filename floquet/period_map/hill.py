"""One scalar equation, in Hill form."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..collocation import Rule, second_order_panel
from ..periodic import PeriodicMatrix, PeriodicSystem
from .panels import Panel, estimated, panels_of, piece_lengths, refine, resolved
from .result import Method, PeriodMap

Array = NDArray[np.float64]


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


def hill_map(system: PeriodicSystem, panels: int | None) -> PeriodMap:
    q, alpha, kicks = hill_form(system)
    shape = system.cases
    q = q.flat(shape)
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
        for panel in panels_of(part, system.period, counts):

            def mapped(rule: Rule, panel: Panel = panel) -> Array:
                return second_order_panel(None, panel.matrix.sample(panel.nodes(rule)), panel.half, rule)

            balance = _balance(panel.half)
            F, error = estimated(mapped, balance)
            done &= resolved(F, error, balance)
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

    refine(solve, piece_lengths(q, system.period), np.sqrt(q.bound()[:, 0, 0]), system.period, panels)
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
