"""Koopman–Hill projection: Φ from the Hill matrix, a check that shares no mechanism with the period map.

With A(t) = Σ_k A_k e^{ikωt} and x' = A x, the functions z_j = e^{ijωt} x obey equations with constant coefficients::

    z_j' = ijω z_j + Σ_k A_k z_{j+k},        z' = H z,   H_jl = ijω δ_jl I + A_{l-j}

H is Hill's matrix.  Cut at |j| ≤ N it gives the map from t to t + Δ without any of its eigenvalues being sorted::

    F(t) = C expm(H Δ) W(t),     C picks z_0 = x,   W(t) stacks e^{ijωt} I

(F. Bayer and R. I. Leine, Sorting-free Hill-based stability analysis of periodic solutions through Koopman analysis,
Nonlinear Dyn. 111, 2023).  One exponential serves every t: the period is taken in steps of ‖A‖Δ ≤ 1, which need few
harmonics and no large numbers.  N is raised until two agree; their difference is the error estimate.

Nothing but samples of A is asked for.  At equally spaced times their FFT is exact for trigonometric polynomials and
converges geometrically for smooth functions; between declared kinks the harmonics are integrated by Gauss's rule.
Where A or a derivative jumps they fall like a power, and so does what N leaves out: a jump of A leaves 1e-4 to 1e-7 in
the exponents.  ``converged`` is then False, and the errors are what the differences say.  Kinks that nobody declared
are worse, because equally spaced samples do not know where they are.

Exponents come from the cyclic matrix of the G factors, F_g in place (g+1, g): its eigenvalues are the G-th roots of the
multipliers, so that multipliers many decades apart are as many decades over G apart in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, expm
from scipy.optimize import linear_sum_assignment

from .errors import FailedError, ParameterError
from .periodic import PeriodicSystem

__all__ = ["HillCheck", "disagreement", "koopman_hill", "require_agreement"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)
HARMONICS = (12, 18, 27, 40, 60, 90)
LARGEST = 1200  # rows of H: an exponential of a second
PANELS, NODES = 32, 32  # of Gauss's rule, a period: its fastest wave, 180 a period, makes 5.6 turns over a panel
CYCLIC = 1600  # rows of the cyclic matrix: its eigenvectors take some seconds
ENTRIES = 4096  # of matrices whose harmonics are kept at once: 24 MB
STEP = 1.0  # ‖A‖Δ of one exponential
GROUP = (
    3  # steps a factor: e^{±3} spreads a factor's multipliers by two decades, which costs two digits of the smallest
)
AGREED = 64.0 * EPS  # relative difference of maps that is rounding: expm of norm 12 to 100 squares 4 to 7 times
ROUNDING = 8.0 * EPS  # of a factor and of its eigenvalues: 200 random blades reach a fifth of the bound
SUSPECT = 3.0  # what N = 90 may lack over its difference from 60, 40, 27: 200 random jumps reach 0.8 of it


class _Exponents(Protocol):
    """What is checked: a :class:`~floquet.exponents.Stability`."""

    @property
    def exponents(self) -> Any: ...
    @property
    def exponent_errors(self) -> Any: ...


@dataclass(frozen=True, eq=False, kw_only=True)
class HillCheck:
    """Exponents by Koopman–Hill projection; arrays have the cases' axes first.

    Attributes
    ----------
    exponents : complex (..., states)
        η per unit of t, principal branch modulo 2πi/period, in no particular order.
    exponent_errors : float (..., states)
        Estimate of their errors: three times the difference of the last two N (the last four where those do not
        agree), and the bound of rounding.
    monodromy : float (..., states, states)
        Φ over the period, with the twist.
    harmonics : int (...)
        N.
    converged : bool (...)
        Whether two numbers of harmonics agree to rounding; False where A has kinks.
    period : float
    """

    exponents: Complex
    exponent_errors: Array
    monodromy: Array
    harmonics: NDArray[np.int32]
    converged: NDArray[np.bool_]
    period: float


def koopman_hill(system: PeriodicSystem) -> HillCheck:
    """Φ and exponents of every case of ``system`` by Koopman–Hill projection."""
    if system.constant:
        raise ParameterError(
            "system",
            system.name,
            "a constant system has no harmonics to be checked with: its exponents are the eigenvalues of its matrix",
        )
    n, T, shape = system.states, system.period, system.cases
    twist = np.ones(n) if system.twist is None else np.asarray(system.twist, float)
    base = T if system.twist is None else 2.0 * T  # S² = I
    count = math.prod(shape)
    eta, errors = np.empty((count, n), complex), np.empty((count, n))
    phi, used, done = np.empty((count, n, n)), np.empty(count, np.int32), np.empty(count, bool)
    step = max(1, ENTRIES // (n * n)) if system.function is None else max(1, count)
    parts = ((i, system.part(slice(i, i + step))) for i in range(0, count, step))
    spectra = ((i, *_spectrum(part, base)) for i, part in parts)
    for case, harmonics, scale, size in ((i + k, A, S[k], s[k]) for i, A, S, s in spectra for k in range(len(s))):
        maps, used[case], done[case] = _factors(harmonics, case % step, _groups(float(size), T, n), base, T)
        for factors in maps:
            factors[-1] = twist[:, None] * factors[-1]
        phi[case] = _product(maps[-1]) * (scale[:, None] / scale)
        *before, (eta[case], rounding) = (_exponents(factors, T) for factors in maps)
        errors[case] = rounding + SUSPECT * np.max([_paired(eta[case], other, T)[0] for other, _ in before], axis=0)
    return HillCheck(
        exponents=eta.reshape(*shape, n),
        exponent_errors=errors.reshape(*shape, n),
        monodromy=phi.reshape(*shape, n, n),
        harmonics=used.reshape(shape),
        converged=done.reshape(shape),
        period=T,
    )


def disagreement(found: _Exponents, check: HillCheck) -> Array:
    """Largest distance of paired exponents over the sum of both bounds, (...): above 1 one of the two is wrong.

    Pairs are those of least total distance; imaginary parts are compared modulo 2π/period.
    """
    shape = check.harmonics.shape
    out = np.empty(math.prod(shape))
    a, b = (np.asarray(x.exponents, complex).reshape(len(out), -1) for x in (found, check))
    e, f = (np.asarray(x.exponent_errors, float).reshape(len(out), -1) for x in (found, check))
    for case in range(len(out)):
        distance, partner = _paired(a[case], b[case], check.period)
        out[case] = np.max(distance / (e[case] + f[case][partner]))
    return out.reshape(shape)


def require_agreement(found: _Exponents, check: HillCheck) -> None:
    """Raise FailedError where exponents differ by more than the bounds of both."""
    ratio = disagreement(found, check)
    if np.any(ratio > 1.0):
        worst = int(np.argmax(ratio))
        raise FailedError(
            f"exponents and their check by Hill's matrix differ by {np.max(ratio):.3g} times the bounds of both (case "
            f"{worst} of {ratio.size}): the system has a kink that was not declared, or this is a fault of floquet, "
            "please report it"
        )


# ---------------------------------------------------------------------- harmonics
def _spectrum(system: PeriodicSystem, base: float) -> tuple[Callable[[int], Complex], Array, Array]:
    """N → A_k of S⁻¹ A S, k = -2N … 2N, (cases, 4N+1, n, n), S (cases, n), and the largest sum of a row's sizes.

    The states are (q, q'/s), s about the largest frequency, of which two entries of A are then as large.
    """
    n, shape = system.states, system.cases
    scale = np.ones((math.prod(shape), n))

    def flat(A: Array) -> Array:
        A = np.broadcast_to(A, (*shape, *A.shape[-3:])).reshape(math.prod(shape), *A.shape[-3:])
        return A * (scale[:, None, None, :] / scale[:, None, :, None])

    @cache
    def samples(number: int) -> Array:
        return flat(system.sample(base * np.arange(number) / number))

    if system.second_order:
        stiffness = np.abs(samples(128)[..., n // 2 :, : n // 2]).sum(axis=-1).max(axis=(-2, -1))
        scale[:, n // 2 :] = np.exp2(np.round(0.5 * np.log2(np.maximum(stiffness, 1.0))))[:, None]
        samples.cache_clear()
    size = np.max(np.sum(np.abs(samples(128)), axis=-1), axis=(-2, -1))
    breaks = _breaks(system, base)
    if breaks is None:
        return cache(lambda N: _transformed(samples(max(128, 2 ** math.ceil(math.log2(4 * N + 2)))), N)), scale, size
    times, weights = _gauss(breaks)
    A = flat(system.sample(times))
    times, weights = (np.broadcast_to(x.reshape(-1, x.shape[-1]), A.shape[:2]) for x in (times, weights))
    weighted = (weights[..., None, None] / base * A).reshape(*A.shape[:2], n * n)

    @cache
    def integrated(N: int) -> Complex:
        wave = np.exp((-2j * math.pi / base) * np.arange(2 * N + 1)[:, None] * times[:, None, :])
        half = (wave @ weighted).reshape(len(A), 2 * N + 1, n, n)
        return np.concatenate([half[:, :0:-1].conj(), half], axis=1)

    return integrated, scale, size


def _transformed(samples: Array, N: int) -> Complex:
    """A_k, k = -2N … 2N, from equally spaced samples (…, number, n, n)."""
    A = np.fft.fft(samples, axis=-3) / samples.shape[-3]
    return np.asarray(A[..., np.arange(-2 * N, 2 * N + 1), :, :])


def _breaks(system: PeriodicSystem, base: float) -> Array | None:
    """Declared kinks from 0 to ``base``, ends included, (…, pieces+1); None for a smooth system."""
    if system.function is not None:
        inner, own = np.asarray([] if system.kinks is None else system.kinks, float), system.period
        edges = np.concatenate([np.zeros((*inner.shape[:-1], 1)), inner], axis=-1)
    else:
        parts = [p for p in (system.damping, system.stiffness, system.matrix) if p is not None and p.edges is not None]
        if not parts:
            return None
        each = [np.asarray(p.edges)[..., :-1] for p in parts]
        own = parts[0].period
        edges = np.concatenate([np.broadcast_to(e, (*system.cases, e.shape[-1])) for e in each], axis=-1)
    if edges.shape[-1] < 2:
        return None
    tiles = [edges + own * i for i in range(math.ceil(base / own - 1e-9))]  # base is a multiple of own, to rounding
    return np.sort(np.minimum(np.concatenate([*tiles, np.full_like(edges[..., :1], base)], axis=-1), base), axis=-1)


def _gauss(breaks: Array) -> tuple[Array, Array]:
    """Times and weights (…, number) of Gauss's rule on every piece."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    times, weights = [], []
    for start, length in zip(np.moveaxis(breaks, -1, 0)[:-1], np.moveaxis(np.diff(breaks), -1, 0), strict=True):
        panels = max(1, math.ceil(PANELS * np.max(length / breaks[..., -1])))
        inside = (np.arange(panels)[:, None] + 0.5 * (x + 1.0)).ravel() / panels
        times.append(start[..., None] + length[..., None] * inside)
        weights.append(length[..., None] * np.tile(w, panels) / (2.0 * panels))
    return np.concatenate(times, axis=-1), np.concatenate(weights, axis=-1)


# ---------------------------------------------------------------------- maps
def _groups(size: float, T: float, n: int) -> int:
    """Factors of the period."""
    groups = max(1.0, math.ceil(size * T / (STEP * GROUP))) if size * T < math.inf else math.inf
    if groups * n > CYCLIC:
        raise FailedError(
            f"the check by Hill's matrix needs {groups:.0f} factors of {n} states a period where the coefficients are "
            f"as large as {size:.1e}, at most {CYCLIC // n} are taken: leave out check, the bounds do not need it"
        )
    return int(groups)


def _factors(
    harmonics: Callable[[int], Complex], case: int, groups: int, base: float, T: float
) -> tuple[list[Array], int, bool]:
    """Maps (groups, n, n) of the period's parts by growing numbers of harmonics, the last N, and whether it agrees.

    The last two maps, or if they do not agree the last four: differences that fall like a power may be small by chance.
    """
    maps: list[Array] = []
    for N in HARMONICS:
        A = harmonics(N)[case]
        if len(maps) > 1 and A.shape[-1] * (2 * N + 1) > LARGEST:
            break
        used, steps = N, _steps(A, N, 2.0 * math.pi / base, T, groups * GROUP)
        maps.append(np.stack([_product(part) for part in np.split(steps, groups)]))
        if len(maps) > 1 and np.max(_norms(maps[-1] - maps[-2])) <= AGREED * np.max(_norms(maps[-1])):
            return maps[-2:], used, True
    return maps[-4:], used, False


def _steps(A: Complex, N: int, omega: float, T: float, steps: int) -> Array:
    """F(t) = C expm(HΔ) W(t) at t = 0, Δ, 2Δ …, (steps, n, n)."""
    n, order = A.shape[-1], np.arange(-N, N + 1)
    H = A[order[None, :] - order[:, None] + 2 * N]  # (j, l, n, n)
    H[np.arange(2 * N + 1), np.arange(2 * N + 1)] += 1j * omega * order[:, None, None] * np.eye(n)
    delta = T / steps
    flat = np.swapaxes(H, 1, 2).reshape(n * (2 * N + 1), n * (2 * N + 1))
    row = expm(flat * delta)[N * n : (N + 1) * n].reshape(n, 2 * N + 1, n)
    W = np.exp(1j * omega * delta * np.arange(steps)[:, None] * order)
    return np.asarray(np.einsum("sj,ajb->sab", W, row).real)


def _product(factors: Array) -> Array:
    """The last factor times … times the first."""
    out = factors[0]
    for F in factors[1:]:
        out = F @ out
    return out


def _norms(m: Array) -> Array:
    """Frobenius norms."""
    return np.asarray(np.sqrt(np.sum(np.abs(m) ** 2, axis=(-2, -1))))


# ---------------------------------------------------------------------- exponents
def _exponents(factors: Array, T: float) -> tuple[Complex, Array]:
    """η = G log(μ)/T of one eigenvalue μ of the cyclic matrix for each multiplier, and what rounding does to them."""
    G, n, _ = factors.shape
    cyclic = np.zeros((G, n, G, n))
    for g, F in enumerate(factors):
        cyclic[(g + 1) % G, :, g, :] = F
    mu, left, right = eig(cyclic.reshape(G * n, G * n), left=True, right=True)
    condition = 1.0 / np.maximum(np.abs(np.sum(left.conj() * right, axis=0)), EPS)
    size, delta = float(_norms(factors).max()), ROUNDING * float(np.sqrt(np.sum(factors**2)))
    radius = _radii(mu, np.minimum(condition * delta, size * (delta / size) ** (1.0 / n)))
    one = _sector(mu, G, n)
    with np.errstate(divide="ignore"):
        relative = radius[one] / np.abs(mu[one])
        eta = G * np.log(mu[one]) / T
        bound = np.where(relative < 1.0, -np.log1p(-np.minimum(relative, 1.0 - EPS)), np.inf) * G / T
    return _principal(eta, T), bound + 4.0 * EPS * np.abs(eta)


def _radii(mu: Complex, moved: Array) -> Array:
    """Errors of eigenvalues that move by κδ to first order (at most by what n of them do that are one).

    Gershgorin's discs have radius (number of eigenvalues) κδ (Wilkinson, The Algebraic Eigenvalue Problem, ch. 2).  A
    disc that meets no other allows the first order, doubled for what follows it; where discs meet an eigenvalue may be
    anywhere in their union.
    """
    disc = len(mu) * moved
    meet = np.abs(mu[:, None] - mu[None, :]) <= disc[:, None] + disc[None, :]
    for _ in range(math.ceil(math.log2(len(mu))) + 1):
        meet = meet @ meet
    alone = meet.sum(axis=1) == 1
    return np.where(alone, 2.0 * moved, 2.0 * (meet @ disc))


def _sector(mu: Complex, G: int, n: int) -> NDArray[np.intp]:
    """One of the G roots of each multiplier: those whose angle lies between two widest gaps 2π/G apart."""
    turns = np.mod(np.angle(mu) * (G / (2.0 * math.pi)), 1.0)
    order = np.sort(turns)
    gaps = np.diff(np.append(order, order[0] + 1.0))
    cut = order[np.argmax(gaps)] + 0.5 * np.max(gaps)
    place = np.mod(np.angle(mu) * (G / (2.0 * math.pi)) - cut, G)
    chosen = np.argsort(place)[:n]
    return np.asarray(chosen)


def _principal(eta: Complex, T: float) -> Complex:
    """Imaginary parts in (-π/T, π/T]."""
    turn = 2.0 * math.pi / T
    return np.asarray(eta - 1j * turn * np.ceil(eta.imag / turn - 0.5))


def _paired(a: Complex, b: Complex, T: float) -> tuple[Array, NDArray[np.intp]]:
    """Distance of each of ``a`` to its partner in ``b``, modulo 2πi/T, and which that is: least total distance."""
    d, turn = a[:, None] - b[None, :], 2.0 * math.pi / T
    distance = np.hypot(d.real, d.imag - turn * np.round(d.imag / turn))
    rows, partner = linear_sum_assignment(np.minimum(distance, np.finfo(float).max))
    return np.asarray(distance[rows, partner]), np.asarray(partner)
