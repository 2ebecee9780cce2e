"""Several states: exponents from the factors of the map, and of constant systems.

Where multipliers are not widely spread they are eigenvalues of the factors' product.  Where they are, forward QR sweeps
sort the product into clusters of like growth without forming it: a cluster's multipliers are the eigenvalues of its own
product, and logarithms add up.  What an error of a factor does to a cluster is weighed with the projector onto it, from
the angle between the growing directions of the map and of its adjoint.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..period_map import Method, PeriodMap
from ..period_map.factors import FactorMap, Factors
from ..periodic import PeriodicSystem
from .products import Complex, Flags, eigenvalues, multipliers, multipliers_of_lanes, poor, size_of
from .result import EPS, Array, Stability, plain, shaped, verdict_of

Index = NDArray[np.intp]

SWEEPS = 12  # clusters whose growth differs by more than e³ a period are separated to the last bit
SPREAD = 5.0  # log-spread of multipliers up to which one block is enough: it costs e⁵ eps of the smallest
CLOSE, FAR = 1e-12, 15.0  # so it is up to a spread of 15 where bounds are close
COUPLING = 1e-13  # what remains below the diagonal of separated clusters
REFLECTIONS = 4.0  # eps of a column: what a QR factorisation does to it


def of_factors(phi: PeriodMap) -> Stability:
    T, n, count = phi.period, phi.states, math.prod(phi.shape)
    twist = np.ones(n) if phi.twist is None else phi.twist
    groups = phi.groups if isinstance(phi, FactorMap) else _one_by_one(phi)
    logs, errors = np.empty((count, n), complex), np.empty((count, n))
    owner = np.zeros(count, np.intp)
    for k, group in enumerate(groups):
        owner[group.cases] = k
    for k, group in enumerate(groups):
        places = np.flatnonzero(owner[group.cases] == k)
        if places.size:
            logs[group.cases[places]], errors[group.cases[places]] = _log_multipliers(group, places, twist)
    logs, errors = _by_frequency(logs, errors)
    eta: Any = logs / T
    errors = errors / T
    errors += 4.0 * EPS * np.abs(eta)
    errors = np.where(np.isfinite(errors), errors, np.inf)  # a map that overflowed
    defect = np.abs(_sum(eta.real) - phi.mean)
    verdict, reason = verdict_of(eta.real, errors, neutral=np.zeros(count, bool))
    nan = np.full(count, np.nan)
    return shaped(phi, eta, errors, defect, nan, nan, verdict, reason)


def _one_by_one(phi: PeriodMap) -> list[Factors]:
    """Factors that were given case by case."""
    pairs = enumerate(zip(phi.factors, phi.errors, strict=True))
    return [Factors(np.array([k]), maps[None, ..., None], errors[None, :, None]) for k, (maps, errors) in pairs]


def _log_multipliers(group: Factors, places: Index, twist: Array) -> tuple[Complex, Array]:
    """Logarithms (k, n) of the eigenvalues of twist·F_K…F_1 for cases of a group, and bounds of their errors."""
    E, in_lanes = np.diag(twist)[None], group.maps.shape[-1] > 1
    if not in_lanes:
        found = multipliers(E, *group.of(places), closely=False, within=FAR)
    else:
        of_all, clear = multipliers_of_lanes(twist, group.maps, group.errors, len(group.cases))
        found = of_all[0][places], of_all[1][places], of_all[2][places]
        _replace(found, ~clear[places], lambda some: multipliers(E, *group.of(places[some]), closely=False, within=FAR))
    logs, bounds = _logarithms(*found)
    wide = ~(np.ptp(logs.real, axis=-1) <= SPREAD) & ~(bounds.max(axis=-1) <= CLOSE)
    wide &= np.isfinite(found[0]).all(axis=-1)
    near = poor(found[0], found[1]) & ~wide
    _replace((logs, bounds), near, lambda some: _logarithms(*multipliers(E, *group.of(places[some]))))
    _replace((logs, bounds), wide, lambda some: _by_sweeps(*group.of(places[some]), twist, in_lanes=in_lanes))
    return logs, bounds


def _replace(parts: Sequence[Any], where: Flags, by: Callable[[Index], Sequence[Any]]) -> None:
    """Rows of ``parts`` by those that are found for them."""
    some = np.flatnonzero(where)
    if some.size:
        for part, rows in zip(parts, by(some), strict=True):
            part[some] = rows


def _logarithms(values: Complex, radius: Array, scale: Array) -> tuple[Complex, Array]:
    """Logarithms of values·exp(scale), and bounds of their errors from those of the values."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logs, relative = np.log(values), radius / np.abs(values)
    bounds = np.where(relative < 1.0, -np.log1p(-np.minimum(relative, 1.0 - EPS)), np.inf)
    logs = logs + scale[:, None]
    return logs, bounds + 4.0 * EPS * (1.0 + np.abs(logs))


# ---------------------------------------------------------------------- widely spread multipliers
def _by_sweeps(maps: Array, errors: Array, twist: Array, *, in_lanes: bool) -> tuple[Complex, Array]:
    """Logarithms of multipliers (cases, n) of maps (cases, panels, n, n), and bounds, by clusters of like growth."""
    cases, _, n, _ = maps.shape
    start, Q, R, U = (_swept_in_lanes if in_lanes else _swept)(maps, twist)
    W = np.swapaxes(start, -1, -2) @ (twist[:, None] * Q[:, -1])
    below = np.stack([np.abs(W[:, m:, :m]).sum(axis=(-2, -1)) for m in range(1, n)], axis=-1)
    apart = below < COUPLING
    errors = errors.copy()
    errors[:, -1] += np.where(apart, below, 0.0).max(axis=-1) * size_of(R[:, -1])
    logs, bounds = np.empty((cases, n), complex), np.empty((cases, n))
    kinds, member = np.unique(apart, axis=0, return_inverse=True)
    for kind, split in enumerate(kinds):
        some = np.flatnonzero(member.ravel() == kind)
        ends = [0, *(np.flatnonzero(split) + 1).tolist(), n]
        oblique = _projectors(Q[some], U[some], ends[1:-1])
        for c, (i, j) in enumerate(pairwise(ends)):
            own = oblique[..., c] * (errors[some] + REFLECTIONS * EPS * size_of(R[some][..., i:j]))
            parts = multipliers(W[some][:, i:j, i:j], R[some][..., i:j, i:j], own)
            logs[some, i:j], bounds[some, i:j] = _logarithms(*parts)
    return logs, bounds


def _swept(maps: Array, twist: Array) -> tuple[Array, Array, Array, Array]:
    """Q₀ (cases, n, n), Q_k and R_k, F_k Q_{k-1} = Q_k R_k, and U_k, F_kᵀ U_k = U_{k-1} R, (cases, panels, n, n).

    They are those after some periods, when directions are in order of their growth, U_k those of the adjoint.
    """
    Q, R, U = np.empty_like(maps), np.empty_like(maps), np.empty_like(maps)
    now = np.broadcast_to(np.eye(maps.shape[-1]), maps[:, 0].shape)
    for _ in range(SWEEPS + 1):
        start = now = twist[:, None] * now
        for k in range(maps.shape[1]):
            now, R[:, k] = np.linalg.qr(maps[:, k] @ now)
            Q[:, k] = now
    now = np.broadcast_to(np.eye(maps.shape[-1]), maps[:, 0].shape)
    for _ in range(SWEEPS + 1):
        now = twist[:, None] * now
        for k in range(maps.shape[1] - 1, -1, -1):
            U[:, k] = now
            now = np.linalg.qr(np.swapaxes(maps[:, k], -1, -2) @ now)[0]
    return start, Q, R, U


def _swept_in_lanes(maps: Array, twist: Array) -> tuple[Array, Array, Array, Array]:
    """The same for many cases."""
    from ..kernels.lanes import WIDTH, aligned  # loads numba
    from ..kernels.sweeps import sweep_panels

    count, panels, n, _ = maps.shape
    places = np.minimum(np.arange(-(-count // WIDTH) * WIDTH), count - 1)
    blocks = aligned((len(places) // WIDTH, panels, n, n, WIDTH))
    blocks[...] = np.moveaxis(maps[places].reshape(-1, WIDTH, panels, n, n), 1, -1)
    start = aligned((len(blocks), 1, n, n, WIDTH))
    out = [start, *(aligned(blocks.shape) for _ in range(3))]
    sweep_panels(blocks, twist, SWEEPS + 1, start[:, 0], *out[1:])
    start, Q, R, U = (np.moveaxis(part, -1, 1).reshape(-1, *part.shape[1:4])[:count] for part in out)
    return start[:, 0], Q, R, U


def _projectors(Q: Array, U: Array, splits: Sequence[int]) -> Array:
    """Norm bound of the projector onto each cluster after each panel, (cases, panels, clusters)."""
    if not splits:
        return np.ones((*Q.shape[:2], 1))
    inverse = np.zeros((*Q.shape[:2], len(splits) + 2))
    for c, m in enumerate(splits):
        angles = np.swapaxes(U[..., :m], -1, -2) @ Q[..., :m]
        with np.errstate(divide="ignore"):
            inverse[..., c + 1] = 1.0 / np.linalg.svd(angles, compute_uv=False)[..., -1]
    inverse[..., -1] = 1.0
    return inverse[..., 1:] + inverse[..., :-1]


# ---------------------------------------------------------------------- order
def _by_frequency(values: Complex, errors: Array) -> tuple[Complex, Array]:
    """Rows (cases, n) by |Im|, then descending Re; of a conjugate pair, which stands together, Im > 0 first."""
    pair = np.arange(values.shape[-1]) - (values.imag < 0.0)
    order = np.lexsort((pair, -np.round(values.real, 9), np.round(np.abs(values.imag), 9)), axis=-1)
    return np.take_along_axis(values, order, axis=-1), np.take_along_axis(errors, order, axis=-1)


def _sum(values: Array) -> Array:
    """Sum over the last axis, in order: a case's bits do not depend on its neighbours."""
    total = values[..., 0]
    for k in range(1, values.shape[-1]):
        total = total + values[..., k]
    return total


# ---------------------------------------------------------------------- constant systems
def of_constant(system: PeriodicSystem) -> Stability:
    A = system.sample(np.zeros(1))[..., 0, :, :]
    shape, n = A.shape[:-2], A.shape[-1]
    A = A.reshape(-1, n, n)
    eta, errors = _by_frequency(*eigenvalues(A, 8.0 * EPS * size_of(A)))
    defect = np.abs(_sum(eta.real) - _sum(np.diagonal(A, axis1=-2, axis2=-1)))
    verdict, reason = verdict_of(eta.real, errors, neutral=np.zeros(len(A), bool))
    nan = np.full(len(A), np.nan)
    full: dict[str, Any] = {
        "determinant_defect": defect,
        "rotation_number": nan,
        "lock": nan,
        "verdict": verdict,
        "reason": reason,
        "method": np.full(len(A), Method.EIGENVALUES, np.int8),
        "panels": np.zeros(len(A), np.int32),
    }
    return Stability(
        exponents=eta.reshape(*shape, n),
        exponent_errors=errors.reshape(*shape, n),
        period=math.nan,
        **plain({name: value.reshape(shape) for name, value in full.items()}, shape),
    )
