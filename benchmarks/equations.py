"""What a user of the peers would write down: the coefficients of one blade and of N in the non-rotating frame.

Nothing of the package is used, so that it is compared with results that owe it nothing.

One blade, eq. (1) of NASA TP-1431 with the integrals of its Appendix A, truncated at ε² as there::

    β'' + d β' + k β = 0,   d = d0 + d1 sin ψ,   k = k0 + c1 cos ψ + s1 sin ψ + c2 cos 2ψ + s2 sin 2ψ

Its Hill form, β = exp(-½∫d) y: ``y'' + q y = 0, q = k - d'/2 - d²/4``, exponents α ± ν with α = -d0/2.

N blades, β = T(ψ) x (eqs. B1 to B6): ``x'' + D x' + K x = 0`` with ``D = T⁻¹(2T' + A T), K = T⁻¹(T'' + A T' + B T)``,
A and B diagonal in d(ψ_i) and k(ψ_i).  The equations repeat after one passage 2π/N, but for the sign of the
differential coordinate of even N, so one passage is what everybody integrates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TWO_PI", "RotorEquations", "blade", "exponents_from_full", "exponents_from_hill", "hill", "multiblade"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
TWO_PI = 2.0 * math.pi
SAMPLES = 32  # of a revolution: harmonics up to 15, and D and K of seven blades end with the 8th
NOTHING = 1e-12  # a coefficient of order one is rounding below this


def blade(points: Array) -> Array:
    """(points, 7): d0, d1, k0, c1, s1, c2, s2."""
    gamma, eps, kappa, K1, mu = points.T
    half = gamma / 2
    arm = 1 / 2 - eps + eps**2 / 2
    d0 = half * (1 / 4 - 2 * eps / 3 + eps**2 / 2)
    d1 = half * mu * (1 / 3 - eps + eps**2)
    k0 = 1 + 1.5 * eps + kappa + half * K1 * (1 / 4 - eps / 3) + half * K1 * mu**2 * arm / 2
    c1 = half * mu * (1 / 3 - eps / 2)
    s1 = half * K1 * mu * (2 / 3 - eps)
    return np.stack([d0, d1, k0, c1, s1, -half * K1 * mu**2 * arm / 2, half * mu**2 * arm / 2], axis=-1)


def hill(coefficients: Array) -> Array:
    """(points, 5): q0 and the cosine and sine of ψ and of 2ψ in q."""
    d0, d1, k0, c1, s1, c2, s2 = coefficients.T
    return np.stack([k0 - d0**2 / 4 - d1**2 / 8, c1 - d1 / 2, s1 - d0 * d1 / 2, c2 + d1**2 / 8, s2], axis=-1)


def exponents_from_full(phi: Array) -> Complex:
    """Of monodromy matrices (points, 2, 2), by the quadratic formula (LAPACK would take longer than heyoka does)."""
    half, D = _trace_and_discriminant(phi)
    root = np.sqrt(D.astype(complex))
    return np.asarray(np.log(np.stack([half + root, half - root], axis=-1)) / TWO_PI)


def exponents_from_hill(phi: Array, mean_damping: Array) -> Complex:
    """α ± ν from the map of the Hill form; its determinant is 1."""
    half, D = _trace_and_discriminant(phi)
    nu = np.log(half + np.where(half < 0, -1.0, 1.0) * np.sqrt(D.astype(complex))) / TWO_PI
    return np.asarray(np.stack([nu, -nu], axis=-1) - 0.5 * mean_damping[:, None])


def _trace_and_discriminant(phi: Array) -> tuple[Array, Array]:
    a, b, c, d = phi[:, 0, 0], phi[:, 0, 1], phi[:, 1, 0], phi[:, 1, 1]
    return 0.5 * (a + d), (0.5 * (a - d)) ** 2 + b * c


@dataclass(frozen=True, eq=False)
class RotorEquations:
    """D and K as trigonometric polynomials, for many points.

    Attributes
    ----------
    orders : tuple of int
        Harmonics of ψ that occur, beside the mean.
    D, K : (points, 1 + 2 len(orders), N, N)
        Mean, then cosine and sine of every order.
    """

    blades: int
    orders: tuple[int, ...]
    D: Array
    K: Array

    @property
    def passage(self) -> float:
        """Azimuth that is integrated."""
        return TWO_PI / self.blades

    def waves(self, psi: float) -> Array:
        """1, then cosine and sine of every order, as D and K have them."""
        return np.array([1.0, *(f(h * psi) for h in self.orders for f in (math.cos, math.sin))])

    def first_order(self) -> Array:
        """(points, 1 + 2 len(orders), 2N, 2N): the matrix of the states (x, x')."""
        N = self.blades
        A = np.zeros((*self.D.shape[:2], 2 * N, 2 * N))
        A[:, 0, :N, N:] = np.eye(N)
        A[..., N:, :N], A[..., N:, N:] = -self.K, -self.D
        return A

    def exponents(self, phi: Array) -> Complex:
        """Of the maps (points, 2N, 2N) over one passage, by LAPACK."""
        sign = np.ones(2 * self.blades)
        if self.blades % 2 == 0:
            sign[[self.blades - 1, -1]] = -1.0
        return np.asarray(np.log(np.linalg.eigvals(sign[:, None] * phi).astype(complex)) / self.passage)


def multiblade(points: Array, blades: int) -> RotorEquations:
    """The equations of N identical blades, their harmonics taken from samples of one revolution."""
    psi = TWO_PI * np.arange(SAMPLES) / SAMPLES
    T, T1, T2 = _transformation(psi, blades)
    d0, d1, k0, c1, s1, c2, s2 = blade(points).T[:, :, None, None]
    at = psi[:, None] + TWO_PI * np.arange(blades) / blades
    d = d0 + d1 * np.sin(at)
    k = k0 + c1 * np.cos(at) + s1 * np.sin(at) + c2 * np.cos(2 * at) + s2 * np.sin(2 * at)
    inverse = np.linalg.inv(T)
    D = inverse @ (2 * T1 + d[..., None] * T)
    K = inverse @ (T2 + d[..., None] * T1 + k[..., None] * T)
    spectra = [np.fft.rfft(M, axis=1) / SAMPLES for M in (D, K)]
    size = np.max([np.abs(s).max(axis=(0, 2, 3)) for s in spectra], axis=0)
    orders = tuple(int(h) for h in np.flatnonzero(size > NOTHING) if h)
    return RotorEquations(blades, orders, *(_harmonics(s, orders) for s in spectra))


def _harmonics(spectrum: Complex, orders: tuple[int, ...]) -> Array:
    parts = [spectrum[:, 0].real]
    for h in orders:
        parts += [2 * spectrum[:, h].real, -2 * spectrum[:, h].imag]
    out = np.stack(parts, axis=1)
    out[np.abs(out) < NOTHING] = 0.0
    return out


def _transformation(psi: Array, blades: int) -> tuple[Array, Array, Array]:
    """T, T', T'' at azimuths (k,), each (k, N, N): columns 1, cos nψ_i, sin nψ_i, …, (-1)^i for even N."""
    at = psi[:, None] + TWO_PI * np.arange(blades) / blades
    one, zero = np.ones_like(at), np.zeros_like(at)
    columns = [(one, zero, zero)]
    for n in range(1, (blades - 1) // 2 + 1):
        cosine, sine = np.cos(n * at), np.sin(n * at)
        columns += [(cosine, -n * sine, -(n**2) * cosine), (sine, n * cosine, -(n**2) * sine)]
    if blades % 2 == 0:
        columns.append(((-1.0) ** np.arange(1, blades + 1) * one, zero, zero))
    T, T1, T2 = (np.stack(part, axis=-1) for part in zip(*columns, strict=True))
    return T, T1, T2
