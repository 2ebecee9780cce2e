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
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FloquetWarning, ParameterError
from ..periodic import TWO_PI, Equation, Parts, PeriodicMatrix, PeriodicSystem
from ..rotor import PARAMETERS, Hub, Rotor
from .inputs import FORCING
from .physics import Physics, PhysicsKeywords, advance_ratios

__all__ = ["blade", "flapping"]

Array = NDArray[np.float64]
PLACES = (0, 1, 2, 1, 0)  # between the kinks: air from ahead, mixed, from behind, mixed, from ahead
INTEGRALS = ((1, 0, 2), (2, 0, 1), (1, 0, 1))  # p, j, k of ∫ U_T^p x^j (x-ε)^k dx: of damping, pitch and inflow
SINE, COSINE = PeriodicMatrix.scalar(sines=[1]), PeriodicMatrix.scalar(cosines=[1])


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
    values = {p.name: np.asarray(getattr(rotor, p.name), float) for p in PARAMETERS}
    values |= {"advance_ratio": mu, "tip_loss": np.asarray(physics.tip_loss, float)}
    if np.any(values["tip_loss"] <= np.maximum(values["hinge_offset"], values["root_cutout"])):
        raise ParameterError(
            "tip_loss",
            physics.tip_loss,
            f"tip_loss = {physics.tip_loss:g} leaves no blade that lifts outboard of the hinge or root cutout",
        )
    return PeriodicSystem(
        period=TWO_PI,
        equation=Equation(
            build=lambda some: _Blade(some, physics).equation(),
            parameters=values,
            parts=(lambda some: _Blade(some, physics).parts()) if physics.reversed_flow else None,
            key=("flapping", physics.exact_offset, physics.reversed_flow),
        ),
        inputs=lambda: _Blade(values, physics).forcing(),
        input_names=FORCING,
        coordinates=("beta",),
        name="flapping",
    )


class _Blade:
    """Eq. (1) for parameters in doubles, or in object arrays: exact ones, or symbols while no blade has a cutout."""

    def __init__(self, values: Mapping[str, NDArray[Any]], physics: Physics) -> None:
        self.values, self.physics = values, physics
        self.mu, self.offset = values["advance_ratio"], values["hinge_offset"]
        self.half = values["lock_number"] / 2
        cutout = values["root_cutout"]
        self.tip, self.root, self.exact = values["tip_loss"], self.offset, np.asarray(physics.exact_offset)
        if np.any(cutout):
            outboard = np.real(cutout) > np.real(self.offset)  # parameters with rates have them as imaginary parts
            self.root, self.exact = np.where(outboard, cutout, self.offset)[()], self.exact | outboard

    def equation(self) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        """d and k."""
        pairs = self.pairs()
        if not self.physics.reversed_flow:
            return pairs[0]
        d, k = (PeriodicMatrix.pieces([pairs[place][i] for place in PLACES], self.edges) for i in (0, 1))
        return d, k

    def parts(self) -> Parts:
        """d and k in reversed flow, between the kinks."""
        return Parts(pairs=self.pairs(), places=PLACES, edges=self.edges)

    def pairs(self) -> list[tuple[PeriodicMatrix, PeriodicMatrix]]:
        """d and k without reversed flow, or with U_T ahead, mixed and reversed."""
        v = self.values
        structure = _constant(1 + v["hinge_stiffness"] + v["offset_mass_ratio"])
        damper = _constant(v["flap_damping"])
        pairs = []
        for rate, pitch, inflow in zip(*(self.polynomials(*powers) for powers in INTEGRALS), strict=True):
            pitch, inflow = self.half * pitch, self.half * inflow
            stiffness = structure + v["pitch_flap_coupling"] * pitch + self.mu * (COSINE @ inflow)
            pairs.append((damper + self.half * rate, stiffness))
        return pairs

    def forcing(self) -> PeriodicMatrix:
        """f, a column an input."""
        m, half = self.values["offset_mass_ratio"], self.half
        pitch, inflow = half * self.integral(2, 0, 1), half * self.integral(1, 0, 1)
        twist, rate = half * self.integral(2, 1, 1), half * self.integral(1, 1, 1)
        coriolis, acceleration = 2.0 * (1.0 + m), (1.0 + m if self.physics.kinematic_rates else np.ones_like(m))
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
            _constant(self.values["static_moment_ratio"]),
        ]
        return PeriodicMatrix.assemble([columns])

    # ∫ (x+u)^p x^j (x-ε)^k dx over the lifting blade, as periodic functions through u = μ sin ψ
    def integral(self, p: int, j: int, k: int) -> PeriodicMatrix:
        """The integral with U_T^p, sign reversed in reversed flow where that is taken into account."""
        found = self.polynomials(p, j, k)
        if not self.physics.reversed_flow:
            return found[0]
        return PeriodicMatrix.pieces([found[place] for place in PLACES], self.edges)

    def polynomials(self, p: int, j: int, k: int) -> list[PeriodicMatrix]:
        """The integral where the air comes from ahead; with reversed flow also where it is mixed, and from behind."""
        monomials = _powers(self.offset, j, k)
        forward = [math.comb(p, b) * self._moment(monomials, p - b) for b in range(p + 1)]
        ahead = PeriodicMatrix.sine_polynomial(forward, self.mu)
        if not self.physics.reversed_flow:
            return [ahead]
        inboard = _inboard(monomials, p, self.root)
        mixed = [(forward[b] if b < len(forward) else 0) - 2 * inboard[b] for b in range(len(inboard))]
        return [ahead, PeriodicMatrix.sine_polynomial(mixed, self.mu), (-1) * ahead]

    def _moment(self, monomials: Sequence[NDArray[Any]], power: int) -> NDArray[Any]:
        """∫ x^power Σ c_n x^n dx; what lies inboard of the hinge is O(ε^(degree+1)), and the report keeps it to ε²."""
        outer = sum(c * _power(self.tip, n + power + 1) / (n + power + 1) for n, c in enumerate(monomials))
        keep = self.exact | (len(monomials) + power <= 2)
        if not keep.any():
            return np.asarray(outer)
        inner = sum(c * _power(self.root, n + power + 1) / (n + power + 1) for n, c in enumerate(monomials))
        return np.asarray(outer - np.where(keep, inner, 0))

    @cached_property
    def edges(self) -> Array:
        """Azimuths where the root and the tip enter and leave reversed flow, (..., 6) from 0 to 2π.

        Doubles even for exact parameters: where the pieces meet their values and slopes agree, so that a shift of eps
        changes the motion by eps² at most.
        """
        mu, root, tip = np.broadcast_arrays(*(np.asarray(np.real(x), float) for x in (self.mu, self.root, self.tip)))
        root_angle, tip_angle = (np.arcsin(np.divide(r, mu, out=np.ones(mu.shape), where=mu > r)) for r in (root, tip))
        zero = np.zeros(mu.shape)
        pi, turn = zero + math.pi, zero + TWO_PI
        kinks = [zero, pi + root_angle, pi + tip_angle, turn - tip_angle, turn - root_angle, turn]
        return np.moveaxis(np.stack(kinks), 0, -1)


def _power(x: NDArray[Any], n: int) -> NDArray[Any]:
    """xⁿ by products: np.power takes ten times as long."""
    return x if n == 1 else x * _power(x, n - 1)


def _powers(offset: NDArray[Any], j: int, k: int) -> list[NDArray[Any]]:
    """x^j (x-ε)^k by powers of x."""
    unit = 0 * offset
    return [unit] * j + [unit + 1 if n == k else math.comb(k, n) * _power(-offset, k - n) for n in range(k + 1)]


def _inboard(monomials: Sequence[NDArray[Any]], p: int, root: NDArray[Any]) -> list[NDArray[Any]]:
    """∫ (x+u)^p Σ c_n x^n dx from the root to the reversal radius x = -u, by powers of u."""
    out = [0 * root for _ in range(p + len(monomials) + 1)]
    for n, c in enumerate(monomials):
        reciprocal = math.factorial(p + n + 1) // (math.factorial(p) * math.factorial(n))
        out[p + n + 1] = out[p + n + 1] + (-1) ** (n + 1) * c / reciprocal
        for b in range(p + 1):
            e = n + 1 + p - b
            out[b] = out[b] - math.comb(p, b) * c * _power(root, e) / e
    return out


def _constant(value: NDArray[Any]) -> PeriodicMatrix:
    return PeriodicMatrix.scalar(mean=value)
