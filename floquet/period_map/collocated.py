"""Maps of panels by Gauss collocation, all panels of many cases at once.

The error of a map is the difference between p = 16 and p = 12 nodes, which is the error of the worse of the two, plus
an allowance for rounding.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..collocation import Rule, first_order_panel, gauss_rule, second_order_panel
from ..periodic import PeriodicMatrix, PeriodicSystem
from .panels import COARSE_NODES, EPS, NODES, ROUNDING, SWEEP, TRUNCATION, piece_lengths

__all__ = ["Collocation", "balance", "common_pieces"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]
AT_ONCE = 2**22  # doubles of the systems of equations that are solved at once: 32 MB
NEXT = 1.01  # times more panels: the next rung, whatever is missing


class Collocation:
    """Panels of a system by collocation."""

    def __init__(self, system: PeriodicSystem) -> None:
        self.period, self.states = system.period, system.states
        self.system = _flat(system)
        self.anchor = _anchor(self.system)
        self.lengths = piece_lengths(self.anchor, system.period)
        frequency, self.trace = _frequency_and_trace(self.system)
        self.wanted = system.period * np.maximum(frequency, 1.0) / SWEEP
        self.scale = np.ones((1, self.states))
        if (K := self.system.stiffness) is not None:
            s = balance(K.bound().sum(axis=-1))
            self.scale = np.concatenate([np.ones(s.shape), s], axis=-1)

    def maps(self, cases: Index, counts: list[int]) -> tuple[Array, Array, Array]:
        """Of ``cases``, lanes of one case each; see :class:`.factors.Solver`."""
        n, size = self.states, (NODES * self.states) ** 2 * sum(counts)
        maps, errors = np.empty((len(cases), sum(counts), n, n, 1)), np.empty((len(cases), sum(counts), 1))
        step = max(AT_ONCE // size, 1)
        for some in (slice(i, i + step) for i in range(0, len(cases), step)):
            F = self._mapped(cases[some], counts, gauss_rule(NODES))
            difference = F - self._mapped(cases[some], counts, gauss_rule(COARSE_NODES))
            maps[some, ..., 0] = F
            errors[some, :, 0] = _norm(difference) + ROUNDING * EPS * _norm(F)
        resolved = errors <= (TRUNCATION + ROUNDING * EPS) * _norm(np.moveaxis(maps, -1, 1))[:, 0, :, None]
        return maps, errors, np.where(resolved.all(axis=(1, 2)), 1.0, NEXT)

    def _mapped(self, cases: Index, counts: list[int], rule: Rule) -> Array:
        """Maps of all panels, (cases, panels, n, n)."""
        n, k = self.states, len(cases)
        ends = np.array([[0.0, self.period]])
        if self.anchor.edges is not None:
            edges = np.minimum(self.anchor.edges, self.period)
            ends = edges[cases] if len(edges) > 1 else edges
        ends = np.broadcast_to(ends, (k, ends.shape[-1]))
        out = []
        for piece, count in enumerate(counts):
            half = (ends[:, piece + 1] - ends[:, piece]) / (2 * count)
            centre = ends[:, piece, None] + (2 * np.arange(count) + 1) * half[:, None]
            psi = centre[..., None] + half[:, None, None] * rule.nodes
            h = np.repeat(half, count)
            samples = [self._sampled(part, psi, cases, piece) for part in ("damping", "stiffness", "matrix")]
            D, K, A = samples
            if K is not None:
                F = second_order_panel(D, K, h, rule)
            else:
                F = first_order_panel(A if A is not None else self._of_function(psi, cases), h, rule)
            out.append(F.reshape(k, count, n, n))
        s = self.scale[cases, None] if len(self.scale) > 1 else self.scale[:, None]
        return np.concatenate(out, axis=1) * (s[..., None, :] / s[..., None])

    def _sampled(self, name: str, psi: Array, cases: Index, piece: int) -> Array | None:
        """A part of the system on one piece at psi (cases, panels, p), (cases · panels, p, n, n)."""
        part: PeriodicMatrix | None = getattr(self.system, name)
        if part is None:
            return None
        one = slice(piece, piece + 1) if part.coefficients.shape[-4] > 1 else slice(None)
        values = replace(part, coefficients=part.coefficients[cases, one], edges=None).sample(psi.reshape(len(psi), -1))
        return values.reshape(-1, psi.shape[-1], *values.shape[-2:])

    def _of_function(self, psi: Array, cases: Index) -> Array:
        """The same of a function: its azimuths are the same for every case."""
        values = _flat_samples(self.system, psi[0].ravel())[cases]
        return values.reshape(-1, psi.shape[-1], *values.shape[-2:])


def balance(stiffness: Array) -> Array:
    """Powers of two between the square root of sums of rows of K and half of it; 1 where there is none."""
    exponent = np.frexp(np.where(stiffness > 0.0, stiffness, 1.0))[1]
    return np.ldexp(1.0, (exponent - 1) // 2)


def common_pieces(system: PeriodicSystem) -> PeriodicSystem:
    """D and K of a second-order system on the same pieces, D there even if it is zero."""
    if system.stiffness is None:
        return system
    D = system.damping if system.damping is not None else 0.0 * system.stiffness
    if D.edges is None and system.stiffness.edges is None:
        return replace(system, damping=D)
    return replace(system, stiffness=system.stiffness + 0.0 * D, damping=D + 0.0 * system.stiffness)


def _flat(system: PeriodicSystem) -> PeriodicSystem:
    """Cases along one axis, all matrices on the same pieces."""
    parts = {n: m for n in ("damping", "stiffness", "matrix") if (m := getattr(common_pieces(system), n)) is not None}
    return replace(system, **{n: m.flat(system.cases) for n, m in parts.items()})


def _flat_samples(system: PeriodicSystem, psi: Array) -> Array:
    """A(ψ) of a function for all its cases along one axis."""
    assert system.function is not None
    A = system.function(psi)
    return np.broadcast_to(A, (*system.cases, *A.shape[-3:])).reshape(-1, *A.shape[-3:])


def _anchor(system: PeriodicSystem) -> PeriodicMatrix:
    """A matrix that carries the pieces of the system."""
    if system.function is None:
        part = system.stiffness if system.stiffness is not None else system.matrix
        assert part is not None
        return part
    zero = PeriodicMatrix.constant(np.zeros((math.prod(system.cases), 1, 1)), system.period)
    inner = np.asarray(system.kinks if system.kinks is not None else [], float)
    return replace(zero, edges=np.concatenate([[0.0], inner, [system.period]])[None, :]) if inner.size else zero


def _frequency_and_trace(system: PeriodicSystem) -> tuple[Array, Array]:
    """Largest local frequency, which sets the panels, and the mean trace of A."""
    if system.stiffness is not None:
        assert system.damping is not None
        K, D = (part.bound().sum(axis=-1).max(axis=-1) for part in (system.stiffness, system.damping))
        return np.maximum(np.sqrt(K), D), -np.trace(system.damping.mean(), axis1=-2, axis2=-1)
    if system.matrix is not None:
        return system.matrix.bound().sum(axis=-1).max(axis=-1), np.trace(system.matrix.mean(), axis1=-2, axis2=-1)
    kinks = np.asarray(system.kinks if system.kinks is not None else [], float)
    edges = np.concatenate([[0.0], kinks, [system.period]])
    rule = gauss_rule(32)
    frequency = trace = np.zeros(math.prod(system.cases))
    for a, b in pairwise(edges):
        for s in range(4):
            half = (b - a) / 8
            A = _flat_samples(system, a + (2 * s + 1 + rule.nodes) * half)
            frequency = np.maximum(frequency, np.abs(A).sum(axis=-1).max(axis=(-1, -2)))
            trace = trace + half * np.trace(A, axis1=-2, axis2=-1) @ rule.weights
    return frequency, trace / system.period


def _norm(m: Array) -> Array:
    """Frobenius norm."""
    return np.sqrt(np.sum(m * m, axis=(-2, -1)))
