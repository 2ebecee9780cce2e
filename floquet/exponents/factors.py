"""Several states: exponents from the factors of the map, and of constant systems."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..period_map import Method, PeriodMap
from ..periodic import PeriodicSystem
from .result import EPS, Array, Stability, plain, shaped, verdict_of

SWEEPS = 12  # clusters whose growth differs by more than e³ a period are separated to the last bit
SPREAD = 5.0  # log-spread of multipliers up to which one block is enough: it costs e⁵ eps of the smallest
COUPLING = 1e-13  # what remains below the diagonal of separated clusters


def of_factors(phi: PeriodMap) -> Stability:
    T, n = phi.period, phi.states
    count = len(phi.factors)
    twist = np.ones(n) if phi.twist is None else phi.twist
    eta, errors, defect = np.empty((count, n), complex), np.empty((count, n)), np.empty(count)
    for case, (F, e) in enumerate(zip(phi.factors, phi.errors, strict=True)):
        logs, bounds = _log_multipliers(F, e, twist)
        order = _pairs_by_frequency(logs)
        eta[case], errors[case] = logs[order] / T, bounds[order] / T
        defect[case] = abs(math.fsum(logs.real) / T - phi.mean[case])
    errors += 4.0 * EPS * np.abs(eta)
    verdict, reason = verdict_of(eta.real, errors, neutral=np.zeros(count, bool))
    nan = np.full(count, np.nan)
    return shaped(phi, eta, errors, defect, nan, nan, verdict, reason)


def _log_multipliers(factors: Array, errors: Array, twist: Array) -> tuple[NDArray[np.complex128], Array]:
    """Logarithms of the eigenvalues of twist·F_K…F_1 and bounds of their errors."""
    n = factors.shape[-1]
    start = np.eye(n)
    Q, R = _sweep(factors, start)
    logs = np.sum(np.log(np.abs(np.diagonal(R, axis1=-2, axis2=-1))), axis=0)
    splits: list[int] = []
    if np.ptp(logs) > SPREAD:
        for _ in range(SWEEPS):
            start = twist[:, None] * Q[-1]
            Q, R = _sweep(factors, start)
        splits = _separated(Q, start, twist)
    begin = np.concatenate([start[None], Q[:-1]])  # Q before each panel
    ends = [0, *splits, n]
    oblique = _projectors(factors, Q, splits, twist)
    W = begin[0].T @ (twist[:, None] * Q[-1])
    out, bounds = np.empty(n, complex), np.empty(n)
    for c, (i, j) in enumerate(pairwise(ends)):
        block, scale, error = _cluster(
            W[i:j, i:j],
            R[:, i:j, i:j],
            errors * oblique[:, c] + (EPS * n if len(ends) > 2 else 0.0) * _norms(R[:, i:j, i:j]),
        )
        values, radius = _eigenvalues(block, error)
        out[i:j] = np.log(values) + scale
        relative = radius / np.abs(values)
        bounds[i:j] = np.where(relative < 1.0, -np.log1p(-np.minimum(relative, 1.0 - EPS)), np.inf)
    return out, bounds + 4.0 * EPS * (1.0 + np.abs(out))


def _sweep(factors: Array, start: Array) -> tuple[Array, Array]:
    """One period of QR: F_k Q_{k-1} = Q_k R_k.  Returns Q_1…Q_K and R_1…R_K."""
    Q, R = np.empty_like(factors), np.empty_like(factors)
    for k, F in enumerate(factors):
        Q[k], R[k] = np.linalg.qr(F @ (Q[k - 1] if k else start))
    return Q, R


def _separated(Q: Array, start: Array, twist: Array) -> list[int]:
    """Where the flag after a period is the flag before it: the boundaries of clusters."""
    W = start.T @ (twist[:, None] * Q[-1])
    n = len(W)
    return [m for m in range(1, n) if np.abs(W[m:, :m]).max() < COUPLING]


def _projectors(factors: Array, Q: Array, splits: Sequence[int], twist: Array) -> Array:
    """Norm bound of the projector onto each cluster after each panel, (panels, clusters)."""
    K, n, _ = factors.shape
    if not splits:
        return np.ones((K, 1))
    U, now = np.empty_like(factors), np.eye(n)
    for _ in range(SWEEPS + 1):
        now = twist[:, None] * now
        for k in range(K - 1, -1, -1):
            U[k] = now
            now = np.linalg.qr(factors[k].T @ now)[0]
    inverse = np.zeros((K, len(splits) + 2))
    for c, m in enumerate(splits):
        inverse[:, c + 1] = 1.0 / np.linalg.svd(np.swapaxes(U[:, :, :m], -1, -2) @ Q[:, :, :m], compute_uv=False)[:, -1]
    inverse[:, -1] = 1.0
    return inverse[:, 1:] + inverse[:, :-1]


def _cluster(W: Array, R: Array, errors: Array) -> tuple[Array, float, float]:
    """The cluster's block W R_K…R_1 scaled by exp(-scale), and the norm of its error on that scale."""
    m, scales = R.shape[-1], np.zeros(len(R) + 1)
    before = np.empty((len(R) + 1, m, m))
    before[0] = np.eye(m)
    for k, step in enumerate(R):
        product = step @ before[k]
        size = np.abs(product).max()
        before[k + 1], scales[k + 1] = product / size, scales[k] + math.log(size)
    after, later, error = W, 0.0, 0.0
    for k in range(len(R) - 1, -1, -1):  # δ = after · δR_k · before, everything on the scale of the whole
        error += float(_norms(after) * errors[k] * _norms(before[k])) * math.exp(
            min(scales[k] + later - scales[-1], 700.0)
        )
        product = after @ R[k]
        size = np.abs(product).max()
        after, later = product / size, later + math.log(size)
    return W @ before[-1], float(scales[-1]), error


def _eigenvalues(block: Array, error: float) -> tuple[NDArray[np.complex128], Array]:
    """Eigenvalues of a small matrix known to ``error``, with bounds.

    Gershgorin's discs of X⁻¹(B+δ)X have radius m κ_i error (Wilkinson, The Algebraic Eigenvalue Problem, ch. 2);
    where discs meet, an eigenvalue may be anywhere in their union.  Elsner's theorem caps what defective eigenvalues
    can do.
    """
    m = len(block)
    values, X = np.linalg.eig(block)
    values = values.astype(complex)
    if m == 1:
        return values, np.array([error])
    size = float(_norms(block))
    error = error + 4.0 * m * EPS * size
    cap = (2 * m - 1) * (2.0 * size + error) ** (1.0 - 1.0 / m) * error ** (1.0 / m)
    try:
        condition = _norms(np.linalg.inv(X)[:, None, :]) * _norms(X.T[:, None, :])
    except np.linalg.LinAlgError:
        return values, np.full(m, cap)
    return values, np.minimum(_joined(values, m * condition * error), cap)


def _joined(values: NDArray[np.complex128], radius: Array) -> Array:
    """Distance from each eigenvalue to anywhere in the discs connected with its own."""
    meet = np.abs(values[:, None] - values[None, :]) <= radius[:, None] + radius[None, :]
    for _ in range(max(1, math.ceil(math.log2(len(values))))):
        meet = meet @ meet
    alone = meet.sum(axis=1) == 1
    return np.where(alone, radius, 2.0 * (meet * radius[None, :]).sum(axis=1))


def _pairs_by_frequency(values: NDArray[np.complex128]) -> list[int]:
    """Order by |Im| then descending Re, each value with Im > 0 before its conjugate."""
    left = sorted(range(len(values)), key=lambda i: (-values[i].imag, i))
    pairs: list[tuple[int, ...]] = []
    while left:
        i = left.pop(0)
        partner = min(left, key=lambda j: abs(values[j] - np.conj(values[i])), default=None)
        if values[i].imag > 0 and partner is not None and abs(values[partner] - np.conj(values[i])) < 1e-6:
            left.remove(partner)
            pairs.append((i, partner))
        else:
            pairs.append((i,))
    pairs.sort(key=lambda p: (round(float(abs(values[p[0]].imag)), 9), -round(float(values[p[0]].real), 9)))
    return [i for pair in pairs for i in pair]


def _norms(m: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(np.abs(m) ** 2, axis=(-2, -1))))


# ---------------------------------------------------------------------- constant systems
def of_constant(system: PeriodicSystem) -> Stability:
    A = system.sample(np.zeros(1))[..., 0, :, :]
    shape, n = A.shape[:-2], A.shape[-1]
    eta, errors, defect = np.empty((*shape, n), complex), np.empty((*shape, n)), np.empty(shape)
    for case in np.ndindex(shape):
        size = float(_norms(A[case]))
        values, radius = _eigenvalues(A[case], 8.0 * EPS * size)
        order = _pairs_by_frequency(values)
        eta[case], errors[case] = values[order], radius[order]
        defect[case] = abs(math.fsum(values.real) - np.trace(A[case]))
    verdict, reason = verdict_of(eta.real, errors, neutral=np.zeros(shape, bool))
    nan = np.full(shape, np.nan)
    full: dict[str, Any] = {
        "determinant_defect": defect,
        "rotation_number": nan,
        "lock": nan,
        "verdict": verdict,
        "reason": reason,
        "method": np.full(shape, Method.EIGENVALUES, np.int8),
        "panels": np.zeros(shape, np.int32),
    }
    return Stability(
        exponents=eta,
        exponent_errors=errors,
        period=math.nan,
        **plain(full, shape),
    )
