"""Maps of state and inputs between given azimuths.

Over a step from ψ_k to ψ_(k+1) the system ``x' = A(ψ) x + F(ψ) u`` with constant u moves the state by::

    x_(k+1) = Φ_k x_k + Γ_k u

Steps are cut where coefficients have kinks and into panels short enough for Gauss collocation to be exact to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .collocation import Rule, first_order_panel, gauss_rule
from .period_map import NODES
from .periodic import PeriodicMatrix, PeriodicSystem

__all__ = ["Passage", "passage"]

Array = NDArray[np.float64]
DOUBLES = 2**22  # of the systems of equations that are solved at once: 32 MB
PHASE = 1.0  # a panel's length times the largest entry of A: sixteen nodes leave (½)³²/32!, which is nothing


@dataclass(frozen=True, eq=False)
class Passage:
    """Steps Φ (..., steps, n, n) and Γ (..., steps, n, m) between ``azimuths`` (steps+1,), from ``panels`` panels."""

    azimuths: Array
    transitions: Array
    inputs: Array
    panels: int

    def states(self, start: Array, u: Array | None = None) -> Array:
        """States (..., steps+1, n, k) from ``start`` (..., n, k) under inputs ``u`` (..., m, k); each alone if None."""
        pushes = self.inputs if u is None else self.inputs @ u[..., None, :, :]
        shape = np.broadcast_shapes(start.shape[:-2], self.transitions.shape[:-3], pushes.shape[:-3])
        x = np.broadcast_to(start, (*shape, *start.shape[-2:]))
        out = [x]
        for k in range(self.transitions.shape[-3]):
            x = self.transitions[..., k, :, :] @ x + pushes[..., k, :, :]
            out.append(x)
        return np.stack(out, axis=-3)

    def fundamental(self) -> Array:
        """Φ(ψ_k, ψ_0) (..., steps+1, n, n)."""
        n = self.transitions.shape[-1]
        return self.states(np.eye(n), np.zeros((self.inputs.shape[-1], n)))


def passage(system: PeriodicSystem, azimuths: Array, *, forced: bool = False, nodes: int = NODES) -> Passage:
    """Maps of ``system`` between ascending ``azimuths`` (steps+1,), with ``nodes`` Gauss nodes a panel.

    Without ``forced`` there are no inputs: m = 0.
    """
    forcing = system.forcing if forced else None
    cases = system.cases if forcing is None else np.broadcast_shapes(system.cases, forcing.cases)
    points = _panel_ends(system, forcing, azimuths)
    centre, half = 0.5 * (points[..., 1:] + points[..., :-1]), 0.5 * np.diff(points, axis=-1)
    rule = gauss_rule(nodes)
    psi = centre[..., None] + half[..., None] * rule.nodes  # (cases or none, panels, p)
    panels, n = psi.shape[-2], system.states
    flat = psi.reshape(*psi.shape[:-2], -1)
    shape = (*cases, panels, nodes)
    A = np.broadcast_to(_panelled(system.sample(flat), psi), (*shape, n, n)).reshape(-1, nodes, n, n)
    F = None
    if forcing is not None:
        sampled = _panelled(forcing.sample(flat), psi)
        rows = sampled.shape[-2]
        F = np.zeros((*shape, n, sampled.shape[-1]))
        F[..., n - rows :, :] = sampled
        F = F.reshape(-1, *F.shape[-3:])
    maps = _mapped(A, np.broadcast_to(half, shape[:-1]).reshape(-1), rule, F).reshape(*shape[:-1], n, -1)
    Phi, Gamma = _joined(maps[..., :n], maps[..., n:], points, azimuths)
    return Passage(azimuths, Phi, Gamma, panels)


def _mapped(A: Array, h: Array, rule: Rule, F: Array | None) -> Array:
    """Maps of all panels, some at a time."""
    count = max(DOUBLES // (A.shape[1] * A.shape[2]) ** 2, 1)
    parts = [slice(i, i + count) for i in range(0, len(A), count)]
    return np.concatenate([first_order_panel(A[p], h[p], rule, None if F is None else F[p]) for p in parts])


def _panelled(samples: Array, psi: Array) -> Array:
    """(..., panels · p, n, m) → (..., panels, p, n, m)."""
    return samples.reshape(*samples.shape[:-3], *psi.shape[-2:], *samples.shape[-2:])


def _panel_ends(system: PeriodicSystem, forcing: PeriodicMatrix | None, azimuths: Array) -> Array:
    """Azimuths, kinks between them and further points, ascending, (..., panels+1)."""
    size = float(np.max(_largest(system), initial=1.0))
    parts = np.maximum(np.ceil(np.diff(azimuths) * size / PHASE), 1).astype(int)
    steps = [np.linspace(a, b, k, endpoint=False) for (a, b), k in zip(pairwise(azimuths), parts, strict=True)]
    ends = np.concatenate([*steps, azimuths[-1:]])
    kinks = [k for k in _kinks(system, forcing, azimuths[0], azimuths[-1]) if k.size]
    if not kinks:
        return ends
    shape = np.broadcast_shapes(*(k.shape[:-1] for k in kinks))
    return np.sort(
        np.concatenate([np.broadcast_to(k, (*shape, k.shape[-1])) for k in (ends, *kinks)], axis=-1), axis=-1
    )


def _largest(system: PeriodicSystem) -> Array:
    """A frequency that A does not exceed."""
    parts = [p for p in (system.damping, system.matrix) if p is not None]
    sizes = [p.bound().sum(axis=-1).max(axis=-1) for p in parts]
    if system.stiffness is not None:
        sizes.append(np.sqrt(system.stiffness.bound().sum(axis=-1).max(axis=-1)))
    if system.function is not None:
        psi = np.linspace(0.0, 1.0, 64, endpoint=False) * system.period
        sizes.append(np.abs(system.sample(psi)).sum(axis=-1).max(axis=(-1, -2)))
    return np.concatenate([np.ravel(s) for s in sizes])


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


def _joined(Phi: Array, Gamma: Array, points: Array, azimuths: Array) -> tuple[Array, Array]:
    """The panels between two azimuths as one step."""
    cases = Phi.shape[:-3]
    points = np.broadcast_to(points, (*cases, points.shape[-1]))
    begins = np.stack(
        [np.sum(points < a, axis=-1) for a in azimuths[:-1]] + [np.full(cases, points.shape[-1] - 1)], axis=-1
    )
    steps = [range(int(begins[..., k].min()), int(begins[..., k + 1].max())) for k in range(len(azimuths) - 1)]
    n = Phi.shape[-1]
    out, gathered = np.zeros((*cases, len(steps), n, n)), np.zeros((*cases, len(steps), n, Gamma.shape[-1]))
    out[...] = np.eye(n)
    for k, step in enumerate(steps):
        for j in step:
            mine = ((j >= begins[..., k]) & (j < begins[..., k + 1]))[..., None, None]
            gathered[..., k, :, :] = np.where(
                mine, Phi[..., j, :, :] @ gathered[..., k, :, :] + Gamma[..., j, :, :], gathered[..., k, :, :]
            )
            out[..., k, :, :] = np.where(mine, Phi[..., j, :, :] @ out[..., k, :, :], out[..., k, :, :])
    return out, gathered
