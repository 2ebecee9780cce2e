"""The report's equations as printed, transcribed term by term: NASA TP-1431.

Where a printed equation has a known error it stands here as the derivation has it, and the printed form is an argument
or a function of its own, for the test that tells them apart. Appendix A and eq. (1) keep their units and the axes of
their body rates; later equations are by azimuth, Ω = 1. ``printed = left − right`` for equations of motion.
"""

from __future__ import annotations

import sympy as sp
from sympy import Rational as frac
from sympy import cos, sin

from tests.derivation.blade import (
    K1,
    A_1c,
    B_1c,
    I_beta,
    K_beta,
    M_beta,
    Omega,
    beta,
    beta_ddot,
    beta_dot,
    e,
    eps,
    g,
    gamma,
    inflow,
    kappa,
    m,
    mu,
    normal,
    p_dot,
    p_w,
    psi,
    q_dot,
    q_w,
    s,
    theta_0,
    theta_t,
    u_w,
    v_w,
    w_dot,
)

# Hub-body axes: x' is at β_w from the relative wind, ψ' = ψ − β_w.
p, q, pdot, qdot, u, v, beta_w = sp.symbols("p q pdot qdot u v beta_w", real=True)
BODY = {
    p_w: p * cos(beta_w) + q * sin(beta_w),
    q_w: -p * sin(beta_w) + q * cos(beta_w),
    p_dot: pdot * cos(beta_w) + qdot * sin(beta_w),
    q_dot: -pdot * sin(beta_w) + qdot * cos(beta_w),
    u_w: u * cos(beta_w) + v * sin(beta_w),
    v_w: -u * sin(beta_w) + v * cos(beta_w),
}
psi_body = psi - beta_w
roll, pitch = p / Omega * cos(beta_w) + q / Omega * sin(beta_w), p / Omega * sin(beta_w) - q / Omega * cos(beta_w)
control = theta_0 - A_1c * cos(psi) - B_1c * sin(psi)
S = sin(psi)
QUARTER, THIRD, HALF = frac(1, 4), frac(1, 3), frac(1, 2)
P2 = 1 + kappa + m + gamma * K1 / 8 * (1 - frac(4, 3) * eps)


# ---------------------------------------------------------------------------------------------- appendix A
def A2() -> sp.Expr:
    """M_A / ((ρ/2) a c (ΩR)² R²), eq. (A2)."""
    return (
        (
            QUARTER * (1 - eps**4)
            + THIRD * (1 - eps**3) * (2 * mu * S - eps)
            + HALF * (1 - eps**2) * (mu**2 * S**2 - 2 * mu * eps * S)
            - (1 - eps) * mu**2 * eps * S**2
        )
        * control
        + (
            frac(1, 5) * (1 - eps**5)
            + QUARTER * (1 - eps**4) * (2 * mu * S - eps)
            + THIRD * (1 - eps**3) * (mu**2 * S**2 - 2 * mu * eps * S)
            - HALF * (1 - eps**2) * mu**2 * eps * S**2
        )
        * theta_t
        + (THIRD * (1 - eps**3) + HALF * (1 - eps**2) * (mu * S - eps) - (1 - eps) * eps * mu * S) * inflow
        - (
            (
                QUARTER * (1 - eps**4)
                + THIRD * (1 - eps**3) * (2 * mu * S - eps)
                + HALF * (1 - eps**2) * (mu**2 * S**2 - 2 * mu * eps * S)
                - (1 - eps) * mu**2 * eps * S**2
            )
            * K1
            + (THIRD * (1 - eps**3) + HALF * (1 - eps**2) * (mu * S - eps) - (1 - eps) * mu * eps * S) * mu * cos(psi)
        )
        * beta
        - (
            QUARTER * (1 - eps**4)
            + THIRD * (1 - eps**3) * (mu * S - 2 * eps)
            - HALF * (1 - eps**2) * (2 * mu * eps * S - eps**2)
            + (1 - eps) * mu * eps**2 * S
        )
        * (beta_dot / Omega)
        + (QUARTER * (1 - eps**4) + THIRD * (1 - eps**3) * (mu * S - eps) - mu * eps / 2 * (1 - eps**2) * S)
        * (roll * S - pitch * cos(psi))
    )


def A3() -> sp.Expr:
    """(A2) without ε³, ε⁴, …, eq. (A3)."""
    return (
        (QUARTER - eps / 3 + mu * S * (2 * THIRD - eps + HALF * mu * S - eps * mu * S + HALF * mu * eps**2 * S))
        * control
        + (frac(1, 5) - eps / 4 + mu * S * (HALF - 2 * THIRD * eps + THIRD * mu * S - HALF * mu * eps * S)) * theta_t
        + (THIRD - HALF * eps + mu * S * (HALF - eps + eps**2 / 2)) * inflow
        - (
            (QUARTER - eps / 3 + mu * S * (2 * THIRD - eps + mu / 2 * S - eps * mu * S + eps**2 / 2 * mu * S)) * K1
            + (THIRD - eps / 2 + mu * S * (HALF - eps + eps**2 / 2)) * mu * cos(psi)
        )
        * beta
        - (QUARTER - 2 * THIRD * eps + eps**2 / 2 + mu * S * (THIRD - eps + eps**2)) * (beta_dot / Omega)
        + ((QUARTER - eps / 3) + mu * S * (THIRD - eps / 2)) * (roll * S - pitch * cos(psi))
    )


def A4() -> sp.Expr:
    """Left less right side of eq. (A4), [rad/s²], M_W = M_β g."""
    left = (
        beta_ddot
        + Omega * gamma / 2 * (QUARTER - 2 * THIRD * eps + eps**2 / 2 + mu * (THIRD - eps + eps**2) * S) * beta_dot
        + (
            (K_beta / I_beta + (1 + e * M_beta / I_beta) * Omega**2)
            + Omega**2
            * gamma
            / 2
            * (
                (QUARTER - eps / 3 + mu * (2 * THIRD - eps + mu / 2 * S - eps * mu * S + eps**2 / 2 * mu * S) * S) * K1
                + (THIRD - eps / 2 + mu * (HALF - eps + eps**2 / 2) * S) * mu * cos(psi)
            )
        )
        * beta
    )
    right = (
        2 * (1 + e * M_beta / I_beta) * (p * Omega * cos(psi_body) - q * Omega * sin(psi_body))
        + (pdot * sin(psi_body) + qdot * cos(psi_body))
        + M_beta / I_beta * (w_dot - u * q + p * v)
        - M_beta * g / I_beta
        + Omega**2
        * gamma
        / 2
        * (
            (QUARTER - eps / 3 + mu * S * (2 * THIRD - eps + HALF * mu * S - eps * mu * S + HALF * mu * eps**2 * S))
            * control
            + (frac(1, 5) - eps / 4 + mu * (HALF - 2 * THIRD * eps + THIRD * mu * S - HALF * mu * eps * S) * S)
            * theta_t
            + (THIRD - HALF * eps + mu * (HALF - eps + HALF * eps**2) * S) * inflow
        )
        + gamma
        / 2
        * (QUARTER - eps / 3)
        * (
            (p * Omega * cos(beta_w) + q * Omega * sin(beta_w)) * S
            - (p * Omega * sin(beta_w) - q * Omega * cos(beta_w)) * cos(psi)
        )
        + gamma
        / 8
        * mu
        * (2 * THIRD - eps)
        * (
            (p * Omega * cos(beta_w) + q * Omega * sin(beta_w)) * (1 - cos(2 * psi))
            - (p * Omega * sin(beta_w) - q * Omega * cos(beta_w)) * sin(2 * psi)
        )
    )
    return left - right


def A5(spring: sp.Expr = gamma / 2) -> sp.Expr:
    """Left less right side of eq. (A5), rates by azimuth; ``spring`` is the factor of […] μ cos ψ, lost in print."""
    left = (
        beta_ddot
        + gamma / 2 * (QUARTER - 2 * THIRD * eps + eps**2 / 2 + (THIRD - eps + eps**2) * mu * S) * beta_dot
        + (
            (1 + e * M_beta / I_beta + K_beta / (I_beta * Omega**2))
            + gamma
            / 2
            * (QUARTER - eps / 3 + (2 * THIRD - eps + mu / 2 * S - eps * mu * S + eps**2 / 2 * mu * S) * mu * S)
            * K1
            + spring * (THIRD - eps / 2 + (HALF - eps + eps**2 / 2) * mu * S) * mu * cos(psi)
        )
        * beta
    )
    right = (
        2 * (1 + e * M_beta / I_beta) * (p / Omega * cos(psi_body) - q / Omega * sin(psi_body))
        + (pdot / Omega**2 * sin(psi_body) + qdot / Omega**2 * cos(psi_body))
        + M_beta / (Omega**2 * I_beta) * (w_dot - u * q + p * v)
        - M_beta * g / (I_beta * Omega**2)
        + gamma
        / 2
        * (
            (QUARTER - eps / 3 + (2 * THIRD - eps + HALF * mu * S - eps * mu * S + HALF * mu * eps**2 * S) * mu * S)
            * control
            + (frac(1, 5) - eps / 4 + (HALF - 2 * THIRD * eps + THIRD * mu * S - HALF * mu * eps * S) * mu * S)
            * theta_t
            + (THIRD - HALF * eps + (HALF - eps + HALF * eps**2) * mu * S) * inflow
        )
        + gamma / 2 * (QUARTER - eps / 3) * (roll * S - pitch * cos(psi))
        + gamma / 8 * mu * (2 * THIRD - eps) * (roll * (1 - cos(2 * psi)) - pitch * sin(2 * psi))
    )
    return left - right


def equation_1(groups: sp.Expr = Omega**2) -> sp.Expr:
    """Left less right side of eq. (1); ``groups`` multiplies the two aerodynamic rate groups, printed outside Ω²{…}."""
    Q = HALF - eps + eps**2 / 2
    P2 = 1 + e * M_beta / I_beta + K_beta / (I_beta * Omega**2) + gamma * K1 / 8 * (1 - frac(4, 3) * eps)
    left = (
        beta_ddot
        + gamma
        * Omega
        / 2
        * ((QUARTER - 2 * THIRD * eps + eps**2 / 2) + mu * (THIRD - eps + eps**2) * sin(psi))
        * beta_dot
        + Omega**2
        * (
            P2
            + gamma / 2 * (mu * (THIRD - eps / 2) * cos(psi) + mu**2 / 2 * Q * sin(2 * psi))
            + gamma * K1 / 2 * (mu * (2 * THIRD - eps) * sin(psi) + mu**2 / 2 * Q * (1 - cos(2 * psi)))
        )
        * beta
    )
    right = Omega**2 * (
        2 * (1 + e * M_beta / I_beta) * (-q_w / Omega * sin(psi) + p_w / Omega * cos(psi))
        + p_dot / Omega**2 * sin(psi)
        + q_dot / Omega**2 * cos(psi)
        + M_beta / (I_beta * Omega**2) * ((w_dot - u * q + p * v) - g)
        + gamma
        / 2
        * ((QUARTER - eps / 3) + (2 * THIRD - eps) * mu * sin(psi) + mu**2 / 2 * Q * (1 - cos(2 * psi)))
        * theta_0
        - gamma
        / 2
        * (
            (QUARTER - eps / 3) * cos(psi)
            + mu * (THIRD - eps / 2) * sin(2 * psi)
            + mu**2 / 4 * Q * (cos(psi) - cos(3 * psi))
        )
        * A_1c
        - gamma
        / 2
        * (
            (QUARTER - eps / 3) * sin(psi)
            + mu * (THIRD - eps / 2) * (1 - cos(2 * psi))
            + mu**2 / 4 * Q * (3 * sin(psi) - sin(3 * psi))
        )
        * B_1c
        + gamma
        / 2
        * (
            (frac(1, 5) - eps / 4)
            + mu * (HALF - 2 * THIRD * eps) * sin(psi)
            + mu**2 / 2 * (THIRD - eps / 2) * (1 - cos(2 * psi))
        )
        * theta_t
        + gamma / 2 * ((THIRD - eps / 2) + mu * Q * sin(psi)) * inflow
    )
    rates = gamma / 2 * (QUARTER - eps / 3) * (p_w / Omega * sin(psi) + q_w / Omega * cos(psi)) + gamma / 8 * mu * (
        2 * THIRD - eps
    ) * (p_w / Omega * (1 - cos(2 * psi)) + q_w / Omega * sin(2 * psi))
    return (left - right - groups * rates).subs(BODY)


def forcing_harmonics(*, exact: bool, kinematic: bool) -> dict[str, dict[int, sp.Expr]]:
    """The right side of eq. (1) by harmonics, {harmonic: {column: value}}: J1, J2, J3 cut after ε² or not."""
    Q = (1 - eps) ** 2 / 2
    J1, J2, J3 = THIRD - eps / 2, QUARTER - eps / 3, frac(1, 5) - eps / 4
    if exact:
        J1, J2 = (1 - eps) ** 2 * (2 + eps) / 6, (1 - eps) ** 2 * (3 + 2 * eps + eps**2) / 12
        J3 = frac(1, 5) - eps / 4 + eps**5 / 20
    h = gamma / 2
    a = 1 + m if kinematic else sp.S.One
    return {
        "f0": {
            0: h * (J2 + mu**2 * Q / 2),
            2: -h * mu * J1,
            3: h * (J3 + mu**2 * J1 / 2),
            4: h * J1,
            5: gamma * mu * J1 / 4,
            9: s,
        },
        "fc1": {1: -h * (J2 + mu**2 * Q / 4), 5: 2 * (1 + m), 6: h * J2, 8: a},
        "fs1": {
            0: gamma * mu * J1,
            2: -h * (J2 + 3 * mu**2 * Q / 4),
            3: gamma * mu * J2,
            4: h * mu * Q,
            5: h * J2,
            6: -2 * (1 + m),
            7: a,
        },
        "fc2": {
            0: -gamma * mu**2 * Q / 4,
            2: h * mu * J1,
            3: -gamma * mu**2 * J1 / 4,
            5: -gamma * mu * J1 / 4,
        },
        "fs2": {1: -h * mu * J1, 6: gamma * mu * J1 / 4},
        "fc3": {1: gamma * mu**2 * Q / 8},
        "fs3": {2: gamma * mu**2 * Q / 8},
    }


# ---------------------------------------------------------------------------------------------- teetering rotor
def equation_2() -> tuple[sp.Expr, sp.Expr, dict[int, sp.Expr]]:
    """d, k and the columns of f of eq. (2)."""
    k = 1 + kappa + K1 * gamma / 8 + gamma * mu**2 / 8 * sin(2 * psi) + gamma * K1 * mu**2 / 8 * (1 - cos(2 * psi))
    f = {
        0: gamma * mu / 3 * sin(psi),
        1: -gamma / 8 * ((1 + mu**2 / 2) * cos(psi) - mu**2 / 2 * cos(3 * psi)),
        2: -gamma / 8 * ((1 + frac(3, 2) * mu**2) * sin(psi) - mu**2 / 2 * sin(3 * psi)),
        3: gamma * mu / 4 * sin(psi),
        4: gamma * mu / 4 * sin(psi),
        5: gamma / 8 * sin(psi) + 2 * cos(psi),
        6: -2 * sin(psi) + gamma / 8 * cos(psi),
        7: sin(psi),
        8: cos(psi),
    }
    return gamma / 8, k, f


def equation_7() -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """D, K and F of eq. (7), (a₁, b₁), without the precone the report leaves out."""
    P2 = 1 + kappa + gamma * K1 / 8
    D = sp.Matrix([[gamma / 8, 2], [-2, gamma / 8]])
    K = sp.Matrix(
        [
            [P2 - 1 + gamma * K1 * mu**2 / 16, gamma / 8 * (1 + mu**2 / 2)],
            [-gamma / 8 * (1 - mu**2 / 2), P2 - 1 + frac(3, 16) * gamma * K1 * mu**2],
        ]
    )
    # Printed in the order θ₀, θ_t, A₁c, B₁c; λ; p_w, q_w, ṗ_w, q̇_w.
    controls = sp.Matrix(
        [
            [0, 0, gamma / 8 * (1 + mu**2 / 2), 0],
            [-gamma * mu / 3, -gamma * mu / 4, 0, gamma / 8 * (1 + frac(3, 2) * mu**2)],
        ]
    )
    through = sp.Matrix([0, -gamma * mu / 4])
    rates = sp.Matrix([[-2, -gamma / 8, 0, -1], [-gamma / 8, 2, -1, 0]])
    normal_acceleration = sp.zeros(2, 1)
    F = sp.Matrix.hstack(*(controls.col(i) for i in (0, 2, 3, 1)), through, rates, normal_acceleration)
    return D, K, F


# ---------------------------------------------------------------------------------------------- tip-path plane
def table_3() -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """D, K and F of table 3, (a₀, a₁, b₁); what the published scan has lost of it by the pattern of eq. (1)."""
    Q = HALF - eps + eps**2 / 2
    c = gamma / 2 * (QUARTER - 2 * THIRD * eps + eps**2 / 2)
    D = sp.Matrix(
        [
            [c, 0, -gamma * mu / 4 * (THIRD - eps + eps**2)],
            [0, c, 2],
            [-gamma * mu / 2 * (THIRD - eps + eps**2), -2, c],
        ]
    )
    K = sp.Matrix(
        [
            [
                P2 + gamma * K1 * mu**2 / 4 * Q,
                gamma * mu / 4 * (-eps / 2 + eps**2),
                -gamma * K1 * mu / 4 * (2 * THIRD - eps),
            ],
            [
                -gamma * mu / 2 * (THIRD - eps / 2),
                P2 - 1 + gamma * K1 * mu**2 / 8 * Q,
                c + gamma * mu**2 / 8 * Q,
            ],
            [
                -gamma * K1 * mu / 2 * (2 * THIRD - eps),
                -c + gamma * mu**2 / 8 * Q,
                P2 - 1 + frac(3, 8) * gamma * K1 * mu**2 * Q,
            ],
        ]
    )
    J2 = QUARTER - eps / 3
    h = gamma / 2
    columns = [
        [h * (J2 + mu**2 / 2 * Q), 0, -h * mu * (2 * THIRD - eps)],
        [0, h * (J2 + mu**2 / 4 * Q), 0],
        [-h * mu * (THIRD - eps / 2), 0, h * (J2 + frac(3, 4) * mu**2 * Q)],
        [h * (frac(1, 5) - eps / 4 + mu**2 / 2 * (THIRD - eps / 2)), 0, -h * mu * (HALF - 2 * THIRD * eps)],
        [h * (THIRD - eps / 2), 0, -h * mu * Q],
        [gamma * mu / 8 * (2 * THIRD - eps), -2 * (1 + m), -h * J2],
        [0, -h * J2, 2 * (1 + m)],
        [0, 0, -1],
        [0, -1, 0],
        [s, 0, 0],
    ]
    return D, K, sp.Matrix(columns).T


# ---------------------------------------------------------------------------------------------- hover
def hover_response() -> tuple[sp.Expr, dict[str, sp.Expr]]:
    """Δ, and the steady a₀, Δ a₁ and Δ b₁ of eqs. (13a)–(13c) by azimuth, the weight as n = −g/(Ω²R)."""
    cut = frac(1, 8) - eps / 3 + eps**2 / 4
    lift = gamma * (frac(1, 8) - eps / 6)
    delta = (P2 - 1) ** 2 + gamma**2 * cut**2
    a_0 = (
        s * normal
        + gamma / 2 * ((QUARTER - eps / 3) * theta_0 + (frac(1, 5) - eps / 4) * theta_t + (THIRD - eps / 2) * inflow)
    ) / P2
    a_1 = lift * ((P2 - 1) * (A_1c - q_w) - gamma * cut * (B_1c - p_w)) - 2 * (1 + m) * (
        (P2 - 1) * p_w + gamma * cut * q_w
    )
    b_1 = lift * (gamma * cut * (A_1c - q_w) + (P2 - 1) * (B_1c - p_w)) - 2 * (1 + m) * (
        gamma * cut * p_w - (P2 - 1) * q_w
    )
    return delta, {"a_0": a_0, "a_1": a_1, "b_1": b_1}


def rate_response() -> sp.Matrix:
    """Δ times the matrix of eq. (17) from (p_w, q_w) to (a₁, b₁)."""
    cut, J2 = QUARTER - 2 * THIRD * eps + eps**2 / 2, QUARTER - eps / 3
    return sp.Matrix(
        [
            [
                gamma**2 / 4 * cut * J2 - 2 * (P2 - 1) * (1 + m),
                -gamma * (1 + m) * cut - gamma / 2 * (P2 - 1) * J2,
            ],
            [
                -gamma * (1 + m) * cut - gamma / 2 * (P2 - 1) * J2,
                -(gamma**2) / 4 * cut * J2 + 2 * (P2 - 1) * (1 + m),
            ],
        ]
    )
