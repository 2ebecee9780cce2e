"""The derivation of one blade's equation against the printed eqs. (A1)–(A5) and (1) of NASA TP-1431.

The printed sides stand in ``printed`` with their units, and are compared in hub-body axes.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
import sympy as sp
from sympy import cos, sin

from tests.derivation import blade, printed, rotor
from tests.derivation.blade import (
    K1,
    A_1c,
    B_1c,
    I_beta,
    M_beta,
    Omega,
    aerodynamic_moment,
    beta,
    beta_ddot,
    beta_dot,
    damping,
    e,
    eps,
    flap_acceleration,
    forcing,
    g,
    gamma,
    inertial_moment,
    inflow,
    is_same,
    kappa,
    linear,
    m,
    mu,
    p_dot,
    p_w,
    psi,
    q_dot,
    q_w,
    s,
    speeds,
    stiffness,
    theta_0,
    theta_t,
    trigonometric,
    w_dot,
    x,
)
from tests.derivation.printed import BODY, p, pdot, pitch, psi_body, q, qdot, roll, u, v
from tests.truth import closed_forms

EVERY = (beta_ddot, beta_dot, beta, theta_0, A_1c, B_1c, theta_t, inflow, p, q, pdot, qdot, w_dot, g)


def assert_same(derived: sp.Expr, expected: sp.Expr, variables: Iterable[sp.Symbol]) -> None:
    """Term by term, to name what differs, and as a whole."""
    derived, expected = (trigonometric(side) for side in (derived, expected))
    for variable in variables:
        assert expected.coeff(variable) != 0, f"the printed equation has no term with {variable}"
        assert sp.expand(derived.coeff(variable) - expected.coeff(variable)) == 0, f"the terms with {variable} differ"
    assert sp.expand(derived - expected) == 0


# ---------------------------------------------------------------------------------------------- speeds
def test_speeds_of_an_element_are_the_printed_ones() -> None:
    """For any β without body rates; with them to first order, as the printed U_T and U_P drop their products with β."""
    U_T, U_P = speeds()
    rates = x * (roll * sin(psi) - pitch * cos(psi))
    printed_T = eps * (1 - cos(beta)) + mu * sin(psi) + x * cos(beta)
    printed_P = inflow * cos(beta) - mu * sin(beta) * cos(psi) - beta_dot / Omega * (x - eps)
    still = {p_w: 0, q_w: 0}
    assert is_same(U_T.subs(still), printed_T)
    assert is_same(U_P.subs(still), printed_P)
    assert is_same(linear(U_P).subs(BODY), linear(printed_P) + rates)
    assert linear(U_T) == 0
    assert is_same(U_T.subs(dict.fromkeys(blade.SMALL, 0)), x + mu * sin(psi))


# ---------------------------------------------------------------------------------------------- moments
def test_inertial_moments_are_those_of_A1_for_any_flap_angle() -> None:
    """M_CF, M_I and the weight, on a hub that does not turn: exact in β; the weight pulls the blade down."""
    M_CF = -(Omega**2) * (I_beta * cos(beta) + e * M_beta) * sin(beta)
    M_I = -I_beta * beta_ddot
    at_rest = dict.fromkeys((p_w, q_w, p_dot, q_dot, blade.u_dot, blade.v_dot, w_dot), 0)
    assert is_same(inertial_moment().subs(at_rest), M_CF + M_I - M_beta * g * cos(beta))


def test_body_motion_gives_the_moments_of_A1_but_for_two() -> None:
    """M_BA lacks e M_β(ṗ sin ψ' + q̇ cos ψ'), and the weight moment M_W = M_β g enters (A1) with a minus."""
    M_CF, M_I = -(Omega**2) * (I_beta + e * M_beta) * beta, -I_beta * beta_ddot
    M_Cor = 2 * (I_beta + e * M_beta) * (p * Omega * cos(psi_body) - q * Omega * sin(psi_body))
    M_BA = I_beta * (pdot * sin(psi_body) + qdot * cos(psi_body))
    M_BL = M_beta * (w_dot - u * q + p * v)
    M_W = M_beta * g
    missing = e * M_beta * (pdot * sin(psi_body) + qdot * cos(psi_body))
    derived = linear(inertial_moment()).subs(BODY)
    assert is_same(derived, M_CF + M_I + M_Cor + M_BA + missing + M_BL - M_W)
    assert trigonometric(derived).coeff(g) == -M_beta


def test_nothing_of_order_zero_is_dropped() -> None:
    """An unflapped blade on a hub at rest, without pitch, inflow and weight, has no moment to linearise about."""
    U_T, U_P = speeds()
    nothing = dict.fromkeys(blade.SMALL, 0)
    assert inertial_moment().subs(nothing) == 0
    assert (U_T * U_P).subs(nothing) == 0


AERODYNAMIC = (beta_dot, beta, theta_0, A_1c, B_1c, theta_t, inflow, p, q)


def test_aerodynamic_moment_is_A2() -> None:
    assert_same(aerodynamic_moment(exact=True).subs(BODY), printed.A2(), AERODYNAMIC)


def test_truncated_aerodynamic_moment_is_A3() -> None:
    assert_same(aerodynamic_moment(exact=False).subs(BODY), printed.A3(), AERODYNAMIC)


# ---------------------------------------------------------------------------------------------- equation of motion
def report() -> sp.Expr:
    """β̈ less its value, in the report's form: cut after ε², M_BA with I_β."""
    return beta_ddot - flap_acceleration(exact=False, kinematic=False).subs(BODY)


def test_equation_of_motion_is_A4() -> None:
    assert_same(report(), printed.A4(), EVERY)


def test_equation_of_motion_by_azimuth_is_A5() -> None:
    by_azimuth = {beta_ddot: Omega**2 * beta_ddot, beta_dot: Omega * beta_dot}
    derived = sp.expand(report().subs(by_azimuth, simultaneous=True) / Omega**2)
    assert_same(derived, printed.A5(), EVERY)
    assert not is_same(derived, printed.A5(spring=sp.S.One))


def test_equation_of_motion_is_1_with_the_rate_groups_inside_the_brace() -> None:
    assert_same(report(), printed.equation_1(), EVERY)


def test_rate_groups_as_printed_have_the_wrong_units() -> None:
    """Outside Ω²{…} they differ from the derivation by Ω² − 1 times themselves, and from nothing else."""
    difference = sp.expand(trigonometric(printed.equation_1(groups=sp.S.One) - report()))
    groups = sp.expand(trigonometric(printed.equation_1(groups=sp.S.Zero) - printed.equation_1(groups=sp.S.One)))
    assert groups != 0
    assert sp.expand(difference - (Omega**2 - 1) * groups) == 0


def test_weight_with_the_sign_of_A1_would_lift_the_blade() -> None:
    """Σ M = 0 with + M_W, as (A1) prints, contradicts (A4), whose M_W has the other sign."""
    assert trigonometric(report()).coeff(g) == M_beta / I_beta == trigonometric(printed.A4()).coeff(g)


@pytest.mark.parametrize("exact", [False, True])
def test_kinematics_give_one_plus_m_to_body_accelerations_as_to_body_rates(exact: bool) -> None:
    derived, reported = (forcing(exact=exact, kinematic=kinematic) for kinematic in (True, False))
    ahead = (1 + m) * sp.Matrix([[sin(psi), cos(psi)]])
    coriolis = 2 * (1 + m) * sp.Matrix([[cos(psi), -sin(psi)]])
    inertia = derived.subs(gamma, 0)
    for column, expected in zip((5, 6, 7, 8), (*coriolis, *ahead), strict=True):
        assert is_same(inertia[column], expected)
    for column in range(10):
        factor = 1 + m if column in (7, 8) else 1
        assert is_same(derived[column], factor * reported[column])
    assert derived[9] == s


# ---------------------------------------------------------------------------------------------- harmonics
@pytest.mark.parametrize("exact", [False, True])
def test_harmonics_of_the_coefficients_are_the_closed_forms(exact: bool) -> None:
    """And no further harmonics: the seven give back d(ψ) and k(ψ)."""
    form = closed_forms.exact if exact else closed_forms.truncated
    closed, derived = form(gamma, eps, kappa, K1, mu, m), rotor.blade_coefficients(exact=exact)
    for name in rotor.COEFFICIENTS:
        assert sp.expand(derived[name] - closed[name.name]) == 0, name
    d, k, _ = rotor.by_harmonics()
    assert is_same(d.subs(derived), damping(exact=exact))
    assert is_same(k.subs(derived), stiffness(exact=exact))


@pytest.mark.parametrize("kinematic", [False, True])
@pytest.mark.parametrize("exact", [False, True])
def test_harmonics_of_the_forcing_are_those_of_equation_1(exact: bool, kinematic: bool) -> None:
    """Every column of every harmonic, and no further harmonics."""
    derived = rotor.blade_forcing(exact=exact, kinematic=kinematic)
    for name, columns in printed.forcing_harmonics(exact=exact, kinematic=kinematic).items():
        row = derived[sp.Symbol(name, real=True)]
        for column, value in enumerate(row):
            assert sp.expand(value - columns.get(column, 0)) == 0, f"{name} of {blade.INPUTS[column]}"
    _, _, f = rotor.by_harmonics()
    for column, whole in enumerate(forcing(exact=exact, kinematic=kinematic)):
        assert is_same(f.subs({name: row[column] for name, row in derived.items()}), whole)


@pytest.mark.parametrize("kinematic", [False, True])
@pytest.mark.parametrize("exact", [False, True])
def test_closed_forms_of_the_forcing_are_the_derived_ones(exact: bool, kinematic: bool) -> None:
    numbers = {gamma: 9.3, eps: 0.13, mu: 0.41, m: 0.27, s: 1.63}
    closed = closed_forms.forcing(*numbers.values(), exact_offset=exact, kinematic_rates=kinematic)
    for name, row in rotor.blade_forcing(exact=exact, kinematic=kinematic).items():
        expected = [float(sp.sympify(value).subs(numbers)) for value in row]
        np.testing.assert_allclose(closed[name.name], expected, rtol=0, atol=1e-14)  # a dozen terms below 3


@pytest.mark.parametrize("exact", [False, True])
def test_equation_by_azimuth_has_no_units_and_no_other_terms(exact: bool) -> None:
    """Ω, R, e, I_β, M_β, g and the hub's speed are all in the parameters and the ten inputs."""
    equation = blade.by_azimuth(exact=exact, kinematic=True)
    assert equation.free_symbols == {psi, beta, beta_dot, *blade.PARAMETERS, *blade.INPUTS}
    terms = -damping(exact=exact) * beta_dot - stiffness(exact=exact) * beta
    terms += (forcing(exact=exact, kinematic=True) * sp.Matrix(blade.INPUTS))[0]
    assert sp.expand(equation - terms) == 0
