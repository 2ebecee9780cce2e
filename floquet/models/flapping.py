"""One blade in the rotating frame, eq. (1) of NASA TP-1431.

``β'' + d(ψ) β' + k(ψ) β = f(ψ) u``, primes d/dψ, with U_T = x + u and u = μ sin ψ::

    d = C_β + γ/2 ∫ U_T (x-ε)² dx
    k = 1 + κ + m + γ/2 [ K₁ ∫ U_T² (x-ε) dx + μ cos ψ ∫ U_T (x-ε) dx ]

and the columns of f for u = (θ₀, A₁c, B₁c, θ_t, λ, p_w/Ω, q_w/Ω, ṗ_w/Ω², q̇_w/Ω², ((ẇ-uq+pv)-g)/(Ω²R))::

    θ₀    γ/2 ∫ U_T² (x-ε) dx =: pitch        A₁c  -pitch cos ψ          B₁c  -pitch sin ψ
    θ_t   γ/2 ∫ U_T² x (x-ε) dx               λ     γ/2 ∫ U_T (x-ε) dx
    p_w   rate sin ψ + 2(1+m) cos ψ           q_w   rate cos ψ - 2(1+m) sin ψ,   rate = γ/2 ∫ U_T x (x-ε) dx
    ṗ_w   sin ψ      q̇_w  cos ψ              normal acceleration  s

The integrals run from the hinge ε (or the root cut-out) to the tip (or the tip-loss radius).  Each is a polynomial in
u. With reversed flow U_T becomes |U_T| and U_T² becomes U_T |U_T|: three polynomials, for u above minus the root,
between, and below minus the tip, with kinks where u passes from one to the next.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FloquetWarning, ParameterError
from ..periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from ..rotor import Hub, Rotor
from .inputs import FORCING
from .physics import Physics, PhysicsKeywords, advance_ratios

__all__ = ["blade", "flapping"]

Array = NDArray[np.float64]
SINE, COSINE = PeriodicMatrix.scalar(sines=[1.0]), PeriodicMatrix.scalar(cosines=[1.0])


def flapping(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> PeriodicSystem:
    """Flapping of one blade in forward flight, eq. (1).

    Parameters
    ----------
    rotor : Rotor
        Its parameters broadcast against ``advance_ratio``.
    advance_ratio : float or array
        μ ≥ 0.
    **options
        Physics of the blade, see :mod:`floquet.models.physics`.

    Returns
    -------
    PeriodicSystem
        One coordinate β, period 2π, exponents per radian of azimuth (units of Ω); ten inputs, see
        :mod:`floquet.models.inputs`.
    """
    advance_ratios(advance_ratio, rotor)
    if rotor.hub == Hub.TEETERING:
        warnings.warn(
            "the rotor teeters, and flapping() is the equation of a blade that is held alone: use teetering()",
            FloquetWarning,
            stacklevel=2,
        )
    return blade(rotor, advance_ratio, **options)


def blade(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> PeriodicSystem:
    """:func:`flapping` of one blade, however the hub holds it: what the other models are made of."""
    physics = Physics.of(options)
    mu = advance_ratios(advance_ratio, rotor)
    if np.any(np.asarray(rotor.hinge_offset) > 0.3) and not physics.exact_offset:
        warnings.warn(
            "hinge_offset above 0.3: the report's integrals, truncated at ε², mean nothing there; "
            "use exact_offset (--exact-offset on the command line)",
            FloquetWarning,
            stacklevel=3,
        )
    air = _Integrals(rotor, mu, physics)
    gamma, m = np.asarray(rotor.lock_number), np.asarray(rotor.offset_mass_ratio)
    half = 0.5 * gamma

    structure = _constant(1.0 + np.asarray(rotor.hinge_stiffness) + m)
    pitch = half * air.integral(2, 0, 1)
    inflow = half * air.integral(1, 0, 1)
    damping = _constant(np.asarray(rotor.flap_damping)) + half * air.integral(1, 0, 2)
    stiffness = structure + np.asarray(rotor.pitch_flap_coupling) * pitch + mu * (COSINE @ inflow)

    def forcing() -> PeriodicMatrix:
        twist, rate = half * air.integral(2, 1, 1), half * air.integral(1, 1, 1)
        coriolis, acceleration = 2.0 * (1.0 + m), (1.0 + m if physics.kinematic_rates else np.ones_like(m))
        columns = [
            pitch,
            -1.0 * (COSINE @ pitch),
            -1.0 * (SINE @ pitch),
            twist,
            inflow,
            SINE @ rate + coriolis * COSINE,
            COSINE @ rate - coriolis * SINE,
            acceleration * SINE,
            acceleration * COSINE,
            _constant(np.asarray(rotor.static_moment_ratio)),
        ]
        return PeriodicMatrix.assemble([columns])

    return PeriodicSystem(
        period=TWO_PI,
        damping=damping,
        stiffness=stiffness,
        inputs=forcing,
        input_names=FORCING,
        coordinates=("beta",),
        name="flapping",
    )


def _constant(value: Array) -> PeriodicMatrix:
    return PeriodicMatrix.scalar(mean=value)


class _Integrals:
    """∫ (x+u)^p x^j (x-ε)^k dx over the lifting blade, as periodic functions through u = μ sin ψ."""

    def __init__(self, rotor: Rotor, mu: Array, physics: Physics) -> None:
        self.offset = np.asarray(rotor.hinge_offset)
        cutout = np.asarray(rotor.root_cutout)
        self.root, self.tip = np.maximum(self.offset, cutout), physics.tip_loss
        if np.any(self.tip <= self.root):
            raise ParameterError(
                "tip_loss",
                self.tip,
                f"tip_loss = {self.tip:g} leaves no blade that lifts outboard of the hinge or root cutout",
            )
        self.exact = physics.exact_offset | (cutout > self.offset)
        self.speed = mu * SINE
        self.edges = self._kinks(mu) if physics.reversed_flow else None

    def integral(self, p: int, j: int, k: int) -> PeriodicMatrix:
        """The integral with U_T^p, sign reversed in reversed flow where that is taken into account."""
        monomials = _powers(self.offset, j, k)
        forward = [math.comb(p, b) * self._moment(monomials, p - b) for b in range(p + 1)]
        if self.edges is None:
            return self._polynomial(forward)
        inboard = _inboard(monomials, p, self.root)
        mixed = [(forward[b] if b < len(forward) else 0.0) - 2.0 * inboard[b] for b in range(len(inboard))]
        ahead, between = self._polynomial(forward), self._polynomial(mixed)
        return PeriodicMatrix.pieces([ahead, between, -1.0 * ahead, between, ahead], self.edges)

    def _moment(self, monomials: Sequence[Array], power: int) -> Array:
        """∫ x^power Σ c_n x^n dx; what lies inboard of the hinge is O(ε^(degree+1)), and the report keeps it to ε²."""
        keep = np.asarray(self.exact) | (len(monomials) + power <= 2)
        outer = sum(c * self.tip ** (n + power + 1) / (n + power + 1) for n, c in enumerate(monomials))
        inner = sum(c * self.root ** (n + power + 1) / (n + power + 1) for n, c in enumerate(monomials))
        return np.asarray(outer - np.where(keep, inner, 0.0))

    def _polynomial(self, coefficients: Sequence[Array]) -> PeriodicMatrix:
        """Σ coefficients[b] u^b by Horner's rule."""
        total = _constant(np.asarray(coefficients[-1]))
        for c in coefficients[-2::-1]:
            total = total @ self.speed + _constant(np.asarray(c))
        return total

    def _kinks(self, mu: Array) -> Array:
        """Azimuths where the root and the tip enter and leave reversed flow, (..., 6) from 0 to 2π."""
        mu, root, tip = np.broadcast_arrays(mu, self.root, self.tip)
        root_angle, tip_angle = (np.arcsin(np.divide(r, mu, out=np.ones(mu.shape), where=mu > r)) for r in (root, tip))
        zero = np.zeros(mu.shape)
        return np.stack(
            [zero, math.pi + root_angle, math.pi + tip_angle, TWO_PI - tip_angle, TWO_PI - root_angle, zero + TWO_PI],
            axis=-1,
        )


def _powers(offset: Array, j: int, k: int) -> list[Array]:
    """x^j (x-ε)^k by powers of x."""
    return [np.zeros_like(offset)] * j + [math.comb(k, n) * (-offset) ** (k - n) for n in range(k + 1)]


def _inboard(monomials: Sequence[Array], p: int, root: Array) -> list[Array]:
    """∫ (x+u)^p Σ c_n x^n dx from the root to the reversal radius x = -u, by powers of u."""
    out = [np.zeros_like(root) for _ in range(p + len(monomials) + 1)]
    for n, c in enumerate(monomials):
        beta = math.factorial(p) * math.factorial(n) / math.factorial(p + n + 1)
        out[p + n + 1] = out[p + n + 1] + (-1) ** (n + 1) * beta * c
        for b in range(p + 1):
            e = n + 1 + p - b
            out[b] = out[b] - math.comb(p, b) * c * root**e / e
    return out
