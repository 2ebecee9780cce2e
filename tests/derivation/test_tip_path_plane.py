"""The tip-path plane, eqs. (5)–(8) and table 3 of NASA TP-1431, and what follows from it in hover, eqs. (9)–(21)."""

from __future__ import annotations

import pytest
import sympy as sp
from sympy import Rational as frac

from tests.derivation import printed, rotor
from tests.derivation.blade import (
    INPUTS,
    K1,
    A_1c,
    B_1c,
    eps,
    gamma,
    is_same,
    kappa,
    m,
    mu,
    p_w,
    psi,
    q_w,
    s,
)
from tests.derivation.rotor import COEFFICIENTS, FORCING, multiblade, tip_path_plane
from tests.derivation.test_appendix_b import assert_same
from tests.truth import closed_forms

c0, cs1, k0, kc1, ks1, kc2, ks2 = COEFFICIENTS
P = sp.Symbol("P", positive=True)
STRUCTURE = {kappa: P**2 - 1 - m - gamma * K1 / 8 * (1 - frac(4, 3) * eps)}
ZETA = gamma / (16 * P) * (1 - frac(8, 3) * eps + 2 * eps**2)


def table(*, exact: bool = False, kinematic: bool = False) -> rotor.System:
    """The derived table 3 in the parameters of the blade, F with its ten columns."""
    D, K, F = tip_path_plane()
    coefficients = rotor.blade_coefficients(exact=exact)
    forcing = rotor.blade_forcing(exact=exact, kinematic=kinematic)
    columns = [F.subs({f: row[j] for f, row in forcing.items()}) for j in range(len(INPUTS))]
    return rotor.System(D.subs(coefficients), K.subs(coefficients), sp.Matrix.hstack(*columns))


def hover() -> rotor.System:
    """Table 3 at μ = 0."""
    return rotor.System(*(matrix.subs(mu, 0).expand() for matrix in table()))


# ---------------------------------------------------------------------------------------------- table 3, eq. (7)
def test_harmonic_balance_is_table_3() -> None:
    """D, K and all ten columns of the forcing, cut after ε²."""
    for name, derived, expected in zip("DKF", table(), printed.table_3(), strict=True):
        assert_same(derived, expected, name)


def test_harmonic_balance_is_table_3_for_any_coefficients() -> None:
    D, K, F = tip_path_plane()
    expected = closed_forms.table_3({c.name: c for c in COEFFICIENTS})
    assert_same(D, expected[0], "D")
    assert_same(K, expected[1], "K")
    f0, fc1, fs1, *_ = FORCING
    assert F == sp.Matrix([f0, -fc1, -fs1])


def test_closed_forms_of_table_3_are_the_derived_ones() -> None:
    numbers = {gamma: 9.3, eps: 0.13, mu: 0.41, m: 0.27, s: 1.63}
    for kinematic in (False, True):
        closed = closed_forms.table_3_forcing(*numbers.values(), kinematic_rates=kinematic)
        derived = table(kinematic=kinematic).F.subs(numbers)
        assert max(abs(float(x)) for x in derived - sp.Matrix(closed)) < 1e-14  # a dozen terms below 3


@pytest.mark.parametrize(("blades", "same"), [(3, True), (4, True), (6, False)])
def test_averaged_multiblade_equations_are_the_tip_path_plane_for_three_and_four_blades_only(
    blades: int, same: bool
) -> None:
    """a₁ = −β₁c and b₁ = −β₁s; with six blades the second harmonics, coupled to the first, stay."""
    average = [matrix.applyfunc(lambda entry: rotor.fourier(entry)["0"]) for matrix in multiblade(blades)]
    sign = sp.diag(1, -1, -1)
    D, K, F = tip_path_plane()
    assert_same(sign * average[0][:3, :3] * sign, D, "D")
    assert_same(sign * average[1][:3, :3] * sign, K, "K")
    assert_same(sign * average[2][:3, :], F, "F")
    rest = [average[0][:3, 3:], average[0][3:, :3], average[1][:3, 3:], average[1][3:, :3], average[2][3:, :]]
    assert all(part.is_zero_matrix for part in rest) is same


def test_harmonic_balance_of_the_teetering_rotor_is_equation_7() -> None:
    """Every column, and the lower block of table 3 without hinge offset."""
    D, K, F = printed.equation_7()
    derived = rotor.teetering_plane()
    assert_same(derived.D, D, "D")
    assert_same(derived.K, K, "K")
    assert_same(derived.F[:, :10], F, "F")
    centred = {eps: 0, m: 0}
    block = table()
    assert_same(derived.D, block.D[1:, 1:].subs(centred), "D of table 3")
    assert_same(derived.K, block.K[1:, 1:].subs(centred), "K of table 3")
    assert_same(derived.F[:, :10], block.F[1:, :].subs(centred), "F of table 3")


def test_precone_forces_the_teetering_rotor() -> None:
    """+γμ/6 a₀ on a₁ and, as K₁ acts on all of the flap, +γK₁μ/3 a₀ on b₁: eqs. (2) and (7) have neither."""
    derived = rotor.teetering()
    assert is_same(derived.precone, -gamma * mu / 6 * sp.cos(psi) - gamma * K1 * mu / 3 * sp.sin(psi))
    assert_same(rotor.teetering_plane().F.col(10), closed_forms.precone_forcing(gamma, K1, mu))


# ---------------------------------------------------------------------------------------------- hover, (9) and (10)
def test_coning_mode_in_hover_is_equation_9() -> None:
    """Of η² + 2ζPη + P², and uncoupled from a₁ and b₁."""
    D, K, _ = hover()
    assert sp.expand(K[0, 0].subs(STRUCTURE)) == P**2
    assert sp.expand(D[0, 0] - 2 * ZETA * P) == 0
    for matrix in (D, K):
        assert matrix[0, 1:].is_zero_matrix and matrix[1:, 0].is_zero_matrix


def cyclic_polynomial(zeta: sp.Symbol, root: sp.Symbol) -> sp.Expr:
    """det(η² + η D̃ + K̃) of a₁ and b₁ in hover, by P and ζ."""
    D, K, _ = hover()
    by_zeta = {gamma: 16 * P * zeta / (1 - frac(8, 3) * eps + 2 * eps**2)}
    matrix = (root**2 * sp.eye(2) + root * D[1:, 1:] + K[1:, 1:]).subs(STRUCTURE)
    return sp.expand(matrix.subs(by_zeta).applyfunc(sp.cancel).det())


def test_cyclic_modes_in_hover_are_equation_10_with_a_factor_P() -> None:
    """ω_n² = 1 + P² ± 2P√(1−ζ²) as printed, but ζ_A ω_nA = ζ_R ω_nR = ζP: without P it is right for P = 1 only."""
    zeta, root = sp.symbols("zeta root", positive=True)
    found = cyclic_polynomial(zeta, root)
    split = 2 * P * sp.sqrt(1 - zeta**2)

    def modes(damping: sp.Expr) -> sp.Expr:
        advancing, regressing = (root**2 + 2 * damping * root + 1 + P**2 + sign * split for sign in (1, -1))
        return sp.expand(advancing * regressing)

    assert sp.expand(found - modes(zeta * P)) == 0
    as_printed = sp.expand(found - modes(zeta))
    assert as_printed != 0
    assert as_printed.subs(P, 1) == 0


def test_overdamped_cyclic_exponents_in_hover() -> None:
    """−ζP ± P√(ζ²−1) ± i for ζ > 1, where eq. (10) has no roots to take."""
    zeta, root = sp.symbols("zeta root")
    found = cyclic_polynomial(zeta, root)
    for sign in (1, -1):
        for turn in (sp.I, -sp.I):
            assert sp.expand(found.subs(root, -zeta * P + sign * P * sp.sqrt(zeta**2 - 1) + turn)) == 0


def test_damping_ratio_after_15_has_a_sixth_of_epsilon() -> None:
    """(γ/P)(1/16 − ε/6 + ε²/8); printed with ε/3."""
    ratio = sp.expand(hover().D[1, 1] / (2 * P))
    assert sp.expand(ratio - gamma / P * (frac(1, 16) - eps / 6 + eps**2 / 8)) == 0
    assert sp.expand(ratio - gamma / P * (frac(1, 16) - eps / 3 + eps**2 / 8)) != 0


# ---------------------------------------------------------------------------------------------- hover, (13)–(21)
def test_steady_response_in_hover_is_equation_13() -> None:
    """K̃ a = f̃ for the controls, inflow, rates and weight; body accelerations are not steady."""
    _, K, F = hover()
    delta, a = printed.hover_response()
    steady = sp.Matrix(INPUTS)
    steady[7], steady[8] = 0, 0
    coning = sp.Matrix([K[0, 0] * a["a_0"]])
    assert_same(coning.applyfunc(sp.cancel), F[:1, :] * steady, "a_0")
    cyclic = (K[1:, 1:] * sp.Matrix([a["a_1"], a["b_1"]])).expand()
    assert_same(cyclic, (delta * F[1:, :] * steady).expand(), "(a_1, b_1)")
    assert sp.expand(K[1:, 1:].det() - delta) == 0


def test_response_to_body_rates_in_hover_is_equation_17() -> None:
    """And its b₁ due to q_w is the negative of a₁ due to p_w, which the report calls identical after (21)."""
    _, K, F = hover()
    delta, a = printed.hover_response()
    matrix = printed.rate_response()
    assert_same(K[1:, 1:] * matrix, delta * F[1:, 5:7])
    rates = sp.Matrix([a["a_1"], a["b_1"]]).subs({A_1c: 0, B_1c: 0})
    assert_same(rates.jacobian([p_w, q_w]), matrix)
    adjugate = (K[1:, 1:].adjugate() * F[1:, 5:7]).expand()
    assert sp.expand(adjugate[1, 1] + adjugate[0, 0]) == 0
    assert adjugate[0, 0] != 0


def test_centred_rotor_of_unit_frequency_is_equation_18() -> None:
    """a₁ = p_w − (16/γ) q_w, b₁ = −(16/γ) p_w − q_w for ε = 0, P = 1."""
    _, K, F = (matrix.subs({eps: 0, m: 0, kappa: 0, K1: 0}) for matrix in hover())
    expected = sp.Matrix([[1, -16 / gamma], [-16 / gamma, -1]])
    assert_same((K[1:, 1:] * expected).expand(), F[1:, 5:7])


def test_decoupled_response_to_body_rates_is_equation_20_corrected() -> None:
    """Its numerator is printed for ε = 0; on the condition (19) the response is −16(1+m)/(γ(1 − 8ε/3 + 2ε²))."""
    _, K, F = hover()
    spring = sp.Symbol("spring")  # P² − 1
    cut, J2 = frac(1, 4) - frac(2, 3) * eps + eps**2 / 2, frac(1, 4) - eps / 3
    structure = {kappa: spring - m - gamma * K1 / 8 * (1 - frac(4, 3) * eps)}
    K, rates = K[1:, 1:].subs(structure).expand(), F[1:, 5:7]
    response = K.adjugate() * rates / K.det()
    numerator = -(gamma * (1 + m) * cut + gamma / 2 * spring * J2)
    delta = spring**2 + gamma**2 / 4 * cut**2
    as_printed = -(gamma / 4 + gamma / 8 * spring)
    for i, j in ((0, 1), (1, 0)):
        assert sp.cancel(response[i, j] - numerator / delta) == 0
    assert sp.expand((numerator - as_printed).subs({eps: 0, m: 0})) == 0
    assert sp.expand(numerator - as_printed) != 0
    condition = {spring: gamma**2 / 4 * J2 * cut / (2 * (1 + m))}  # (19)
    decoupled = response.subs(condition).applyfunc(sp.cancel)
    assert (decoupled[0, 0], decoupled[1, 1]) == (0, 0)
    for i, j in ((0, 1), (1, 0)):
        assert sp.cancel(decoupled[i, j] + 16 * (1 + m) / (gamma * (1 - frac(8, 3) * eps + 2 * eps**2))) == 0
