"""Maps of state and inputs from panel to panel between given azimuths.

Over a panel from ψ_k to ψ_(k+1) the system ``x' = A(ψ) x + F(ψ) u`` with constant u moves the state by::

    x_(k+1) = Φ_k x_k + Γ_k u

Panels end at the azimuths asked for, where coefficients have kinks, and where else it takes for Gauss collocation to be
exact to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .collocation import (
    Rule,
    first_order_nodes,
    first_order_panel,
    gauss_rule,
    second_order_nodes,
    second_order_panel,
)
from .errors import ParameterError
from .period_map import EPS, ROUNDING
from .periodic import PeriodicMatrix, PeriodicSystem

__all__ = ["Nodes", "Passage", "passage", "through_nodes"]

Array = NDArray[np.float64]
DOUBLES = 2**22  # of the systems of equations that are solved at once: 32 MB
PHASE = 1.0  # the longest panel times the largest frequency
RULES = ((5, 4), (7, 5), (10, 7), (16, 12))  # nodes of a panel and of the coarser rule beside it
MOST = 10**7  # panels


@dataclass(frozen=True, eq=False)
class Passage:
    """The maps of all panels.

    Attributes
    ----------
    transitions, inputs : (..., panels, n, n), (..., panels, n, m)
        Φ and Γ.
    outputs : int (..., azimuths)
        Which panel end each azimuth asked for is.
    """

    transitions: Array
    inputs: Array
    outputs: NDArray[np.intp]

    def states(self, start: Array, u: Array | None = None) -> Array:
        """States at all panel ends (..., panels+1, n, k) from ``start`` (..., n, k) under ``u`` (..., m, k).

        Without ``u`` every input is 1 in a column of its own, k = m.
        """
        pushes = self.inputs if u is None else self.inputs @ u[..., None, :, :]
        shape = np.broadcast_shapes(start.shape[:-2], self.transitions.shape[:-3], pushes.shape[:-3])
        x = np.broadcast_to(start, (*shape, *start.shape[-2:]))
        out = [x]
        for k in range(self.transitions.shape[-3]):
            x = self.transitions[..., k, :, :] @ x + pushes[..., k, :, :]
            out.append(x)
        return np.stack(out, axis=-3)

    def fundamental(self) -> Array:
        """Φ(ψ_k, ψ_0) at all panel ends, (..., panels+1, n, n)."""
        n = self.transitions.shape[-1]
        return self.states(np.eye(n), np.zeros((self.inputs.shape[-1], n)))

    def at_outputs(self, values: Array) -> Array:
        """Of values (..., panels+1, n, k) at all panel ends those at the azimuths asked for."""
        index = np.broadcast_to(self.outputs, (*values.shape[:-3], self.outputs.shape[-1]))
        return np.take_along_axis(values, index[..., None, None], axis=-3)

    def rounding(self, x: Array, start: Array | None = None) -> tuple[Array, Array]:
        """Bound (..., panels+1, k) of what rounding has done to states ``x`` of :meth:`states`, and E at the end.

        Each panel adds an error δ_j of ROUNDING eps of what it moves.  With E_l = Σ_j δ_j² Φ(ψ_l, ψ_j) Φ(ψ_l, ψ_j)ᵀ the
        sum of the l errors added before ψ_l, wherever each points, is √l √tr E_l at most (Cauchy and Schwarz).
        ``start`` (..., k, n, n) is E of a start that is itself wrong by the errors of as many panels.
        """
        sizes = np.sqrt(np.sum(x * x, axis=-2))
        stretch = np.sqrt(np.sum(self.transitions**2, axis=(-2, -1)))[..., None]
        added = ROUNDING * EPS * (2.0 * stretch * sizes[..., :-1, :] + sizes[..., 1:, :])
        eye, panels = np.eye(self.transitions.shape[-1]), self.transitions.shape[-3]
        E = np.zeros((*sizes.shape[:-2], sizes.shape[-1], *eye.shape)) if start is None else start
        count = 0.0 if start is None else panels + 1.0
        out = [np.sqrt(count * _size(E))]
        for k in range(panels):
            Phi = self.transitions[..., k, None, :, :]
            E = Phi @ E @ np.swapaxes(Phi, -1, -2) + added[..., k, :, None, None] ** 2 * eye
            out.append(np.sqrt((count + k + 1.0) * _size(E)))
        return np.stack(out, axis=-2), E


def passage(
    system: PeriodicSystem, azimuths: Array, *, forcing: PeriodicMatrix | None = None, coarse: bool = False
) -> Passage:
    """Maps of ``system`` between ascending ``azimuths`` (k,).

    Without ``forcing``, F, there are no inputs: m = 0.  ``coarse`` takes a rule of fewer nodes: the difference from it
    is the truncation error of the worse of the two.
    """
    cases = system.cases if forcing is None else np.broadcast_shapes(system.cases, forcing.cases)
    size = _largest(system, forcing)
    points = _panel_ends(system, forcing, azimuths, size)
    centre, half = 0.5 * (points[..., 1:] + points[..., :-1]), 0.5 * np.diff(points, axis=-1)
    fine, less = RULES[-1] if system.function is not None else _nodes(size * float(half.max()))
    rule = gauss_rule(less if coarse else fine)
    psi = centre[..., None] + half[..., None] * rule.nodes  # (cases or none, panels, p)
    parts = [sampled(part, psi, cases) for part in _parts(system, forcing)]
    h = np.broadcast_to(half, (*cases, half.shape[-1])).reshape(-1)
    maps = _mapped(system.second_order, parts, h, rule).reshape(*cases, psi.shape[-2], system.states, -1)
    outputs = (
        np.sum(points[..., None, :] < azimuths[:, None], axis=-1)
        if points.ndim > 1
        else np.searchsorted(points, azimuths)
    )
    n = system.states
    return Passage(maps[..., :n], maps[..., n:], outputs)


@dataclass(frozen=True, eq=False)
class Nodes:
    """The motion at Gauss nodes of all panels, for integrals along it.

    Attributes
    ----------
    azimuths, weights : (cases or none, panels, p)
        ∫ f dψ is the sum of weights · f(azimuths).
    within : (..., panels, p, n, n)
        Φ from the start of a panel to its nodes.
    transitions : (..., panels, n, n)
        Φ from the start of a panel to its end.
    """

    azimuths: Array
    weights: Array
    within: Array
    transitions: Array


def through_nodes(system: PeriodicSystem, last: float) -> Nodes:
    """The motion of ``system`` from 0 to ``last`` at nodes where polynomials of it are exact to rounding."""
    cases, (D, A, _) = system.cases, _parts(system, None)
    points = _panel_ends(system, None, np.array([0.0, last]), _largest(system, None))
    centre, half = 0.5 * (points[..., 1:] + points[..., :-1]), 0.5 * np.diff(points, axis=-1)
    rule = gauss_rule(RULES[-1][0])
    psi, h = centre[..., None] + half[..., None] * rule.nodes, np.broadcast_to(half, (*cases, half.shape[-1])).ravel()
    samples = sampled(A, psi, cases)
    assert samples is not None
    maps = (
        second_order_nodes(sampled(D, psi, cases), samples, h, rule)
        if system.second_order
        else first_order_nodes(samples, h, rule)
    ).reshape(*cases, *psi.shape[-2:-1], len(rule.nodes) + 1, system.states, system.states)
    return Nodes(psi, half[..., None] * rule.weights, maps[..., :-1, :, :], maps[..., -1, :, :])


def _size(E: Array) -> Array:
    """tr E, of which rounding may have turned a sign where the motion decays by many decades."""
    return np.asarray(np.abs(np.diagonal(E, axis1=-2, axis2=-1)).sum(axis=-1))


def _nodes(phase: float) -> tuple[int, int]:
    """Nodes that make (phase)^2p/(2p)!, about the error of a panel, vanish beside rounding; and fewer."""
    return next(
        rule for rule in RULES if rule == RULES[-1] or phase ** (2 * rule[1]) < EPS * math.factorial(2 * rule[1])
    )


Part = PeriodicMatrix | Callable[[Array], Array] | None


def _parts(system: PeriodicSystem, forcing: PeriodicMatrix | None) -> tuple[Part, Part, Part]:
    """What a panel's map is made of: (D, K, F), or (None, A, F)."""
    if system.second_order:
        return system.damping, system.stiffness, forcing
    return None, system.matrix if system.matrix is not None else system.function, forcing


def sampled(part: Part, psi: Array, cases: tuple[int, ...]) -> Array | None:
    """Samples (cases · panels, p, n, m) of a part at nodes ψ (cases or none, panels, p)."""
    if part is None:
        return None
    flat = psi.reshape(*psi.shape[:-2], -1)
    samples = part.sample(flat) if isinstance(part, PeriodicMatrix) else part(flat)
    samples = samples.reshape(*samples.shape[:-3], *psi.shape[-2:], *samples.shape[-2:])
    return np.broadcast_to(samples, cases + samples.shape[-4:]).reshape(-1, *samples.shape[-3:])


def _mapped(second_order: bool, parts: Sequence[Array | None], h: Array, rule: Rule) -> Array:
    """Maps of all panels, some at a time."""
    _, K, _ = parts
    assert K is not None
    count = max(DOUBLES // (K.shape[1] * K.shape[2]) ** 2, 1)
    out = []
    for some in (slice(i, i + count) for i in range(0, len(h), count)):
        D, K, F = (None if part is None else part[some] for part in parts)
        assert K is not None
        one = second_order_panel(D, K, h[some], rule, F) if second_order else first_order_panel(K, h[some], rule, F)
        out.append(one)
    return np.concatenate(out)


def _panel_ends(system: PeriodicSystem, forcing: PeriodicMatrix | None, azimuths: Array, size: float) -> Array:
    """Azimuths, kinks between them and further points, ascending, (..., panels+1)."""
    parts = np.maximum(np.ceil(np.diff(azimuths) * size / PHASE), 1)
    if parts.sum() > MOST:
        raise ParameterError(
            "azimuths", azimuths[-1], f"from {azimuths[0]:g} to {azimuths[-1]:g} it takes more than {MOST:g} panels"
        )
    steps = [np.linspace(a, b, int(k), endpoint=False) for (a, b), k in zip(pairwise(azimuths), parts, strict=True)]
    ends = np.concatenate([*steps, azimuths[-1:]])
    kinks = [k for k in _kinks(system, forcing, azimuths[0], azimuths[-1]) if k.size]
    if not kinks:
        return ends
    shape = np.broadcast_shapes(*(k.shape[:-1] for k in kinks))
    return np.sort(
        np.concatenate([np.broadcast_to(k, (*shape, k.shape[-1])) for k in (ends, *kinks)], axis=-1), axis=-1
    )


def _largest(system: PeriodicSystem, forcing: PeriodicMatrix | None) -> float:
    """A frequency that neither motion nor trigonometric coefficients exceed; of a function, that of A alone."""
    parts = [p for p in (system.damping, system.stiffness, system.matrix, forcing) if p is not None]
    sizes = [1.0, *(2.0 * math.pi / part.period * part.order for part in parts)]
    sizes += [float(p.bound().sum(axis=-1).max()) for p in (system.damping, system.matrix) if p is not None]
    if system.stiffness is not None:
        sizes.append(math.sqrt(system.stiffness.bound().sum(axis=-1).max()))
    if system.function is not None:
        psi = np.linspace(0.0, 1.0, 64, endpoint=False) * system.period
        sizes.append(float(np.abs(system.sample(psi)).sum(axis=-1).max()))
    return max(sizes)


def _kinks(system: PeriodicSystem, forcing: PeriodicMatrix | None, first: float, last: float) -> list[Array]:
    """Kinks of every part between two azimuths, (..., kinks) each; those outside are moved to the ends."""
    parts = (system.damping, system.stiffness, system.matrix, forcing)
    edges: list[tuple[Array, float]] = []
    for part in parts:
        if part is not None and part.edges is not None and not any(np.array_equal(part.edges, e) for e, _ in edges):
            edges.append((part.edges, part.period))
    if system.function is not None and system.kinks is not None and system.kinks.size:
        edges.append((np.concatenate([[0.0], system.kinks]), system.period))
    out = []
    for edge, period in edges:
        turns = period * np.arange(math.floor(first / period), math.ceil(last / period))
        tiled = edge[..., None, :] + turns[:, None]
        out.append(np.clip(tiled.reshape(*tiled.shape[:-2], -1), first, last))
    return out
