"""Period map → multipliers, exponents in log form, bounds, verdict.

One blade: with τ and D the half trace and the discriminant of the Hill form, ``cosh νT = τ``, ``sinh² νT = D``::

    D ≤ 0   α ± iρ, ρ lifted to its branch by the turns of the path (Prüfer rotation number)
    D > 0   a lock: σ₁,₂ + iρ with σ = α ± asinh(√D)/T and ρ a multiple of π/T

An error b in D moves √D by at most b/√|D| away from a branch point and √(|D|+b) next to it; the bound follows both.

Several states: forward QR sweeps sort the factors' product into clusters of like growth without forming it; a cluster's
exponents are the eigenvalues of its own block, and their logarithms add up.  What an error of a factor does to a
cluster is weighed with the projector onto it (from the angle between the growing directions of the map and of its
adjoint).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import ParameterError
from .period_map import Method, PeriodMap, period_map
from .periodic import PeriodicSystem
from .rotor import Word

__all__ = ["Reason", "Stability", "Verdict", "stability"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
SWEEPS = 12  # clusters whose growth differs by more than e³ a period are separated to the last bit
SPREAD = 5.0  # log-spread of multipliers up to which one block is enough: it costs e⁵ eps of the smallest
COUPLING = 1e-13  # what remains below the diagonal of separated clusters


class Verdict(Word):
    """STABLE: all σ + bound < 0.  UNSTABLE: some σ - bound > 0."""

    STABLE = 0
    UNSTABLE = 1
    UNDECIDED = 2


class Reason(Word):
    """Why a verdict is UNDECIDED."""

    NONE = 0
    NEUTRAL = 1  # one undamped scalar equation outside its locks: σ = 0 by the equation, not by its numbers
    BOUND = 2  # the bound of some exponent reaches across zero


@dataclass(frozen=True, eq=False, kw_only=True)
class Stability:
    """Exponents of a periodic or constant system, with what is needed to trust them.

    Arrays have the cases' axes first; a single case has plain numbers.

    Attributes
    ----------
    exponents : complex (..., states)
        η per radian (per rev for rotors).  One scalar equation: [α+iρ, α-iρ], in a lock [σ₁+iρ, σ₂+iρ] with σ₁ ≥ σ₂,
        on the branch of the rotation number.  Larger systems: principal branch, conjugate pairs together, by Im then
        Re.
    multipliers : complex (..., states)
        exp(η·period) (of the twisted passage, where there is a twist); nan for constant systems.
    exponent_errors : float (..., states)
        Bound of the distance to the exact set of exponents modulo 2πi/period.
    determinant_defect : float (...)
        |det Φ - 1| of the Hill form, or |Σσ - mean tr A|: a check that can fail.
    rotation_number, lock : float (...)
        ρ; ρ again inside a lock, else nan.
    verdict, reason, method : int8 (...)
        :class:`Verdict`, :class:`Reason`, :class:`~floquet.period_map.Method`.
    panels : int (...)
    period : float
        Angle of the map; nan for constant systems.
    """

    exponents: Any
    multipliers: Any
    exponent_errors: Any
    determinant_defect: Any
    rotation_number: Any
    lock: Any
    verdict: Any
    reason: Any
    method: Any
    panels: Any
    period: float


def stability(system: PeriodicSystem, *, panels: int | None = None) -> Stability:
    """Exponents, bounds and verdict of ``system``; ``panels`` fixes the resolution (for convergence studies)."""
    if not isinstance(system, PeriodicSystem):
        raise ParameterError(
            "system", system, f"{type(system).__name__} is no system: make one with flapping(rotor, advance_ratio)"
        )
    if system.constant:
        return _of_constant(system)
    return exponents(period_map(system, panels=panels))


def exponents(phi: PeriodMap) -> Stability:
    """Exponents, bounds and verdict of a period map."""
    return _of_hill(phi) if phi.method == Method.HILL else _of_factors(phi)


# ---------------------------------------------------------------------- one scalar equation
def _of_hill(phi: PeriodMap) -> Stability:
    T, alpha, tau, D, b = phi.period, phi.mean, phi.half_trace, phi.discriminant, phi.discriminant_error
    assert phi.hill is not None and b is not None
    locked = D > b
    root = np.sqrt(np.where(locked, D, np.maximum(-D, 0.0)))
    growth = np.where(locked, np.arcsinh(root), 0.0) / T
    rho = rotation_number(phi)
    eta = np.stack([alpha + growth + 1j * rho, alpha - growth + 1j * np.where(locked, rho, -rho)], axis=-1)
    bound = _hill_bound(phi, root) / T + 4.0 * EPS * (np.abs(alpha) + np.abs(growth) + np.abs(rho))
    bound = np.where(np.isfinite(bound), bound, np.inf)  # a map that overflowed
    errors = np.stack([bound, bound], axis=-1)
    Lambda = np.exp(alpha * T)[:, None] * np.stack(
        [
            tau + np.where(locked, np.sign(tau) * root, 1j * root),
            tau - np.where(locked, np.sign(tau) * root, 1j * root),
        ],
        -1,
    )
    det = phi.hill[:, 0, 0] * phi.hill[:, 1, 1] - phi.hill[:, 0, 1] * phi.hill[:, 1, 0]
    # σ = α to rounding outside a lock; the bound of the set must not blur that
    sigma_error = np.where(D < -b, 8.0 * EPS * np.abs(alpha), bound)
    verdict, reason = _verdict(
        eta.real, np.stack([sigma_error, sigma_error], axis=-1), neutral=(alpha == 0.0) & (D < -b)
    )
    return _shaped(phi, eta, Lambda, errors, np.abs(det - 1.0), rho, np.where(locked, rho, np.nan), verdict, reason)


def rotation_number(phi: PeriodMap) -> Array:
    """ρ per radian: the fraction of a turn from Φ, its whole turns from the path."""
    assert phi.hill is not None and phi.turns is not None and phi.discriminant_error is not None
    tau, D = phi.half_trace, phi.discriminant
    unlocked = -np.sign(phi.hill[:, 1, 0]) * np.sqrt(np.maximum(-D, 0.0))
    fraction = np.mod(np.arctan2(np.where(D > phi.discriminant_error, 0.0, unlocked), tau) / (2.0 * math.pi), 1.0)
    return np.asarray(2.0 * math.pi / phi.period * (fraction + np.round(phi.turns - fraction)))


def _hill_bound(phi: PeriodMap, root: Array) -> Array:
    """Bound of the distance between the exact and the computed {±νT}.

    Away from a branch point √D moves by at most b/(√D + √(D-b)) and νT by that over |τ| (asinh) or, between complex
    pairs, by the angle that τ and √-D span together.  Next to it both may lie on either side: √D + √(D+b), through
    asinh and asin.
    """
    D, b = phi.discriminant, phi.discriminant_error
    assert b is not None and phi.half_trace_error is not None
    size = np.abs(D)
    away = size > b
    moved = b / (root + np.sqrt(np.maximum(size - b, 0.0)) + np.where(away, 0.0, 1.0))
    locked = moved / np.sqrt(1.0 + np.maximum(size - b, 0.0))
    angle = np.hypot(moved, phi.half_trace_error)
    near = np.sqrt(size) + np.sqrt(size + b)
    return np.where(away, np.where(D > 0, locked, angle), 0.5 * math.pi * near)


# ---------------------------------------------------------------------- several states, from factors
def _of_factors(phi: PeriodMap) -> Stability:
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
    verdict, reason = _verdict(eta.real, errors, neutral=np.zeros(count, bool))
    nan = np.full(count, np.nan)
    with np.errstate(over="ignore"):  # a multiplier beyond the range of doubles is inf; its exponent is not
        multipliers = np.exp(eta * T)
    return _shaped(phi, eta, multipliers, errors, defect, nan, nan, verdict, reason)


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
def _of_constant(system: PeriodicSystem) -> Stability:
    A = system.sample(np.zeros(1))[..., 0, :, :]
    shape, n = A.shape[:-2], A.shape[-1]
    eta, errors, defect = np.empty((*shape, n), complex), np.empty((*shape, n)), np.empty(shape)
    for case in np.ndindex(shape):
        size = float(_norms(A[case]))
        values, radius = _eigenvalues(A[case], 8.0 * EPS * size)
        order = _pairs_by_frequency(values)
        eta[case], errors[case] = values[order], radius[order]
        defect[case] = abs(math.fsum(values.real) - np.trace(A[case]))
    verdict, reason = _verdict(eta.real, errors, neutral=np.zeros(shape, bool))
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
        multipliers=np.full((*shape, n), np.nan + 0j),
        exponent_errors=errors,
        period=math.nan,
        **_plain(full, shape),
    )


# ---------------------------------------------------------------------- shared
def _verdict(sigma: Array, errors: Array, *, neutral: NDArray[np.bool_]) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
    stable, unstable = np.all(sigma + errors < 0, axis=-1), np.any(sigma - errors > 0, axis=-1)
    verdict = np.where(stable, Verdict.STABLE, np.where(unstable, Verdict.UNSTABLE, Verdict.UNDECIDED))
    reason = np.where(verdict != Verdict.UNDECIDED, Reason.NONE, np.where(neutral, Reason.NEUTRAL, Reason.BOUND))
    return verdict.astype(np.int8), reason.astype(np.int8)


def _shaped(
    phi: PeriodMap,
    eta: Array,
    multipliers: Array,
    errors: Array,
    defect: Array,
    rho: Array,
    lock: Array,
    verdict: NDArray[np.int8],
    reason: NDArray[np.int8],
) -> Stability:
    shape, n = phi.shape, eta.shape[-1]
    full: dict[str, Any] = {
        "determinant_defect": defect,
        "rotation_number": rho,
        "lock": lock,
        "verdict": verdict,
        "reason": reason,
        "method": np.full(len(eta), phi.method, np.int8),
        "panels": phi.panels,
    }
    vectors: dict[str, Any] = {"exponents": eta, "multipliers": multipliers, "exponent_errors": errors}
    return Stability(
        period=phi.period,
        **{k: v.reshape(*shape, n) for k, v in vectors.items()},
        **_plain({k: v.reshape(shape) for k, v in full.items()}, shape),
    )


def _plain(fields: dict[str, Any], shape: tuple[int, ...]) -> dict[str, Any]:
    """Python scalars for a single case; verdict, reason and method as their enums."""
    if shape:
        return fields
    enums = {"verdict": Verdict, "reason": Reason, "method": Method}
    return {k: enums[k](int(v)) if k in enums else v.item() for k, v in fields.items()}
