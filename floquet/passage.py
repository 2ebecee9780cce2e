"""Maps of state and inputs between given azimuths.

Over a step from ψ_k to ψ_(k+1) the system ``x' = A(ψ) x + F(ψ) u`` with constant u moves the state by::

    x_(k+1) = Φ_k x_k + Γ_k u

Steps are cut where coefficients have kinks and into panels short enough for Gauss collocation to be exact to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .collocation import Rule, first_order_panel, gauss_rule, second_order_panel
from .period_map import EPS
from .periodic import PeriodicMatrix, PeriodicSystem

__all__ = ["Passage", "passage"]

Array = NDArray[np.float64]
DOUBLES = 2**22  # of the systems of equations that are solved at once: 32 MB
PHASE = 1.0  # the longest panel times the largest frequency
RULES = ((5, 4), (7, 5), (10, 7), (16, 12))  # nodes of a panel and of the coarser rule beside it


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


def passage(system: PeriodicSystem, azimuths: Array, *, forced: bool = False, coarse: bool = False) -> Passage:
    """Maps of ``system`` between ascending ``azimuths`` (steps+1,).

    Without ``forced`` there are no inputs: m = 0.  ``coarse`` takes a rule of fewer nodes: the difference from it is
    the error of the worse of the two.
    """
    forcing = system.forcing if forced else None
    cases = system.cases if forcing is None else np.broadcast_shapes(system.cases, forcing.cases)
    size = float(np.max(_largest(system, forcing), initial=1.0))
    points = _panel_ends(system, forcing, azimuths, size)
    centre, half = 0.5 * (points[..., 1:] + points[..., :-1]), 0.5 * np.diff(points, axis=-1)
    rule = gauss_rule(_nodes(size * float(half.max()))[coarse])
    psi = centre[..., None] + half[..., None] * rule.nodes  # (cases or none, panels, p)
    parts = [_sampled(part, psi, cases) for part in _parts(system, forcing)]
    h = np.broadcast_to(half, (*cases, half.shape[-1])).reshape(-1)
    maps = _mapped(system.second_order, parts, h, rule).reshape(*cases, psi.shape[-2], system.states, -1)
    Phi, Gamma = _joined(maps[..., : system.states], maps[..., system.states :], points, azimuths)
    return Passage(azimuths, Phi, Gamma, psi.shape[-2])


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


def _sampled(part: Part, psi: Array, cases: tuple[int, ...]) -> Array | None:
    """Samples (cases · panels, p, n, m)."""
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


def _largest(system: PeriodicSystem, forcing: PeriodicMatrix | None) -> Array:
    """A frequency that neither motion nor coefficients exceed."""
    parts = [p for p in (system.damping, system.stiffness, system.matrix, forcing) if p is not None]
    sizes = [np.array(2.0 * math.pi / part.period * part.order) for part in parts]
    sizes += [p.bound().sum(axis=-1).max(axis=-1) for p in (system.damping, system.matrix) if p is not None]
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
