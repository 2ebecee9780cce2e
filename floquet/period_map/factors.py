"""Any system: the factors of its map, one a panel, kept apart because their product would lose small multipliers."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..collocation import Rule, first_order_panel, gauss_rule, second_order_panel
from ..periodic import PeriodicMatrix, PeriodicSystem
from .panels import Panel, estimated, panels_of, piece_lengths, refine, resolved
from .result import Method, PeriodMap

Array = NDArray[np.float64]


def factor_map(system: PeriodicSystem, panels: int | None) -> PeriodMap:
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
        for panel in panels_of(anchor.case(index), system.period, counts):

            def mapped(rule: Rule, panel: Panel = panel) -> Array:
                return _state_panel(part, panel, rule, index)

            F, error = estimated(mapped)
            done &= resolved(F, error)
            maps.append(F)
            own.append(error)
        for place, case in enumerate(index):
            factors[case] = np.stack([F[place] for F in maps])
            errors[case] = np.stack([e[place] for e in own])
        used[index] = len(maps)
        return done

    frequency, trace = _frequency_and_trace(flat, n)
    refine(solve, piece_lengths(anchor, system.period), np.broadcast_to(frequency, (n,)), system.period, panels)
    return PeriodMap(
        method=Method.FACTORS,
        period=system.period,
        shape=shape,
        mean=np.broadcast_to(trace, (n,)),
        panels=used,
        twist=system.twist,
        factors=tuple(factors),
        errors=tuple(errors),
        states=system.states,
    )


def _state_panel(system: PeriodicSystem, panel: Panel, rule: Rule, index: NDArray[np.intp]) -> Array:
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


def _flat_system(system: PeriodicSystem, shape: tuple[int, ...]) -> PeriodicSystem:
    """Cases along one axis, all matrices on the same pieces."""
    if system.function is not None:
        return system
    if system.matrix is not None:
        return replace(system, matrix=system.matrix.flat(shape))
    assert system.stiffness is not None
    D = system.damping if system.damping is not None else 0.0 * system.stiffness
    K = system.stiffness + 0.0 * D
    return replace(system, stiffness=K.flat(shape), damping=(D + 0.0 * system.stiffness).flat(shape))


def _case_system(system: PeriodicSystem, index: NDArray[np.intp]) -> PeriodicSystem:
    parts = {n: m.case(index) for n in ("damping", "stiffness", "matrix") if (m := getattr(system, n)) is not None}
    return replace(system, **parts) if parts else system
