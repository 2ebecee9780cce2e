"""The hinge moment of one blade by adaptive quadrature: no expansion in the hinge offset, no polynomial in μ.

Appendix A of NASA TP-1431 for small β, nondimensional (speeds by ΩR, lengths by R, moments by I_β Ω², rates by Ω)::

    U_T   = x + μ sin ψ
    U_P   = λ − μ β cos ψ − (x − ε) β' + x (p_w sin ψ + q_w cos ψ)
    theta = θ₀ − A₁c cos ψ − B₁c sin ψ + x θ_t − K₁ β

    M_aero = (γ/2) ∫ (U_T |U_T| theta + |U_T| U_P) (x − ε) dx      with reversed flow
    M_aero = (γ/2) ∫ (U_T² theta + U_T U_P) (x − ε) dx             without

over x from max(ε, root cutout) to the tip loss factor B. All other moments about the hinge::

    M_rest = −(1 + κ + m) β − c β' + 2 (1 + m) (p_w cos ψ − q_w sin ψ) + a (ṗ_w sin ψ + q̇_w cos ψ) + s n

with a = 1 as in the report, 1 + m by kinematics, and n the normal acceleration ((ẇ − uq + pv) − g)/(Ω²R). The equation
of motion is β'' = M_aero + M_rest = −d(ψ) β' − k(ψ) β + f_u(ψ) u; d, k and the ten columns f_u follow by linearity:
unit inputs, less the moment of zero input.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

INPUTS = ("theta_0", "A_1c", "B_1c", "theta_t", "lambda", "p_w", "q_w", "pdot_w", "qdot_w", "normal_acceleration")
"""The columns of the forcing, in order."""

TOLERANCE = 1e-13
"""Absolute and relative, of one quadrature; the integrands are cubics at most between their kinks."""


@dataclass(frozen=True, kw_only=True)
class Blade:
    """One blade and its flight condition; eps, m and s are independent inputs."""

    gamma: float
    eps: float = 0.0
    kappa: float = 0.0
    K1: float = 0.0
    mu: float = 0.0
    m: float = 0.0
    s: float = 1.5
    tip_loss: float = 1.0
    root_cutout: float = 0.0
    flap_damping: float = 0.0
    reversed_flow: bool = False
    kinematic_rates: bool = False


def hinge_moment(
    blade: Blade, psi: float, *, beta: float = 0.0, rate: float = 0.0, inputs: NDArray[np.float64] | None = None
) -> float:
    """β'' at azimuth psi for flap angle beta, flap rate β' and the ten inputs u."""
    theta_0, A1, B1, theta_t, inflow, p, q, pdot, qdot, normal = np.zeros(10) if inputs is None else inputs
    sine, cosine = math.sin(psi), math.cos(psi)

    def lift_moment(x: float) -> float:
        U_T = x + blade.mu * sine
        U_P = inflow - blade.mu * beta * cosine - (x - blade.eps) * rate + x * (p * sine + q * cosine)
        theta = theta_0 - A1 * cosine - B1 * sine + x * theta_t - blade.K1 * beta
        speed = abs(U_T) if blade.reversed_flow else U_T
        return speed * (U_T * theta + U_P) * (x - blade.eps)

    aerodynamic = blade.gamma / 2 * _integral(lift_moment, blade, -blade.mu * sine)
    restoring = -(1 + blade.kappa + blade.m) * beta - blade.flap_damping * rate
    coriolis = 2 * (1 + blade.m) * (p * cosine - q * sine)
    acceleration = (1 + blade.m if blade.kinematic_rates else 1) * (pdot * sine + qdot * cosine)
    return aerodynamic + restoring + coriolis + acceleration + blade.s * normal


def damping(blade: Blade, psi: float) -> float:
    """d(ψ) = −∂β''/∂β'."""
    return hinge_moment(blade, psi) - hinge_moment(blade, psi, rate=1.0)


def stiffness(blade: Blade, psi: float) -> float:
    """k(ψ) = −∂β''/∂β."""
    return hinge_moment(blade, psi) - hinge_moment(blade, psi, beta=1.0)


def forcing(blade: Blade, psi: float) -> NDArray[np.float64]:
    """The row f_u(ψ) = ∂β''/∂u of shape (10,), in the order of INPUTS."""
    rest = hinge_moment(blade, psi)
    return np.array([hinge_moment(blade, psi, inputs=unit) - rest for unit in np.eye(10)])


def _integral(integrand: Callable[[float], float], blade: Blade, reversal: float) -> float:
    """From the root to the tip, split where U_T changes sign."""
    root, tip = max(blade.eps, blade.root_cutout), blade.tip_loss
    cuts = [root, *([reversal] if root < reversal < tip else []), tip]
    parts = [quad(integrand, a, b, epsabs=TOLERANCE, epsrel=TOLERANCE)[0] for a, b in pairwise(cuts)]
    return math.fsum(parts)
