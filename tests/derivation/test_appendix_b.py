"""From one blade to several: eq. (2), eqs. (3), (4), (B2)–(B6) and tables 1 and 2 of NASA TP-1431."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from tests.derivation import printed, rotor
from tests.derivation.blade import gamma, is_same, mu, psi, trigonometric
from tests.derivation.rotor import COEFFICIENTS, FORCING, at_blades, inverse, multiblade, transformation
from tests.truth import closed_forms

c0, cs1, k0, kc1, ks1, kc2, ks2 = COEFFICIENTS
TABLES = {3: closed_forms.table_1, 4: closed_forms.table_2}


class Azimuth:
    """n ψ, of which NumPy makes symbolic sines and cosines, so that tables written for numbers give expressions."""

    def __init__(self, multiple: int = 1) -> None:
        self.multiple = multiple

    def __rmul__(self, multiple: int) -> Azimuth:
        return Azimuth(multiple * self.multiple)

    def sin(self) -> sp.Expr:
        return sp.sin(self.multiple * psi)

    def cos(self) -> sp.Expr:
        return sp.cos(self.multiple * psi)


def assert_same(derived: sp.Matrix, expected: np.ndarray | sp.Matrix, name: str = "") -> None:
    """Entry by entry, to name what differs."""
    expected = sp.Matrix(expected)
    assert derived.shape == expected.shape
    for i in range(derived.rows):
        for j in range(derived.cols):
            assert is_same(derived[i, j], expected[i, j]), f"{name}({i + 1}, {j + 1})"


# ---------------------------------------------------------------------------------------------- teetering, eq. (2)
def test_teetering_rotor_is_equation_2() -> None:
    """Half the difference of two blades with β₂ = −β₁ and ψ₂ = ψ₁ + π, every column of the forcing."""
    d, k, f = printed.equation_2()
    derived = rotor.teetering()
    assert is_same(derived.d, d)
    assert is_same(derived.k, k)
    for column, value in enumerate(derived.f):
        assert is_same(value, f.get(column, 0)), column


def test_closed_forms_of_the_teetering_rotor_are_the_derived_ones() -> None:
    derived, closed = rotor.teetering(), closed_forms.teetering(*sp.symbols("gamma kappa K_1 mu", real=True))
    d, k, _ = rotor.by_harmonics()
    values = {c: closed[c.name] for c in COEFFICIENTS}
    assert is_same(derived.d, d.subs(values))
    assert is_same(derived.k, k.subs(values))
    harmonics = [rotor.fourier(column) for column in derived.f]
    numbers = {gamma: 9.3, mu: 0.41}
    for name, row in closed_forms.teetering_forcing(9.3, 0.41).items():
        expected = [float(sp.sympify(column[name[1:]]).subs(numbers)) for column in harmonics]
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-15)  # single products below 3


# ---------------------------------------------------------------------------------------------- transformation
@pytest.mark.parametrize("blades", [3, 4, 6])
def test_sums_over_the_blades_invert_the_transformation(blades: int) -> None:
    product = inverse(blades) * transformation(blades)
    assert product.applyfunc(trigonometric) == sp.eye(blades)


@pytest.mark.parametrize("blades", [3, 4, 6])
def test_scaled_transformation_is_orthogonal(blades: int) -> None:
    """(B6): T_S = diag(1/√N, √(2/N), …, √(2/N)[, 1/√N]) makes T T_S orthogonal, and so T⁻¹ = T_S² Tᵀ."""
    cyclic = 2 * ((blades - 1) // 2)
    scale = [1, *[sp.sqrt(2)] * cyclic, *[1] * (blades - 1 - cyclic)]
    T_S = sp.diag(*scale) / sp.sqrt(blades)
    T_I = transformation(blades) * T_S
    assert (T_I.T * T_I).applyfunc(trigonometric) == sp.eye(blades)
    assert (T_S**2 * transformation(blades).T).applyfunc(trigonometric) == inverse(blades).applyfunc(trigonometric)


def moved(blades: int) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """T⁻¹ times every blade's β_i'' + d β_i' + k β_i with β_i of eq. (3): its parts with q, q', q''."""
    q, rate, acceleration = (sp.symbols(f"{name}:{blades}") for name in ("q", "qdot", "qddot"))
    motion = {psi: 1, **dict(zip(q, rate, strict=True)), **dict(zip(rate, acceleration, strict=True))}

    def derivative(y: sp.Expr) -> sp.Expr:
        return sum(y.diff(v) * v_dot for v, v_dot in motion.items())

    d, k, _ = rotor.by_harmonics()
    sums = []
    for i in range(blades):
        beta = (transformation(blades).row(i) * sp.Matrix(q))[0]
        damping, stiffness = at_blades(d, blades)[i], at_blades(k, blades)[i]
        sums.append(derivative(derivative(beta)) + damping * derivative(beta) + stiffness * beta)
    left = (inverse(blades) * sp.Matrix(sums)).expand()
    return left.jacobian(q), left.jacobian(rate), left.jacobian(acceleration)


@pytest.mark.parametrize("blades", [3, 4])
def test_B5_is_the_motion_of_the_blades_in_multiblade_coordinates(blades: int) -> None:
    """By the blades' equations one by one, without matrices."""
    K, D, unit = moved(blades)
    assert_same(unit, sp.eye(blades), "M")
    assert_same(D, multiblade(blades).D, "D")
    assert_same(K, multiblade(blades).K, "K")


@pytest.mark.parametrize("blades", [3, 4])
def test_derivative_of_A_printed_in_B5_would_be_wrong(blades: int) -> None:
    """With A' for A in K the cyclic coordinates lose c0, which couples them in hover already."""
    d, k, _ = rotor.by_harmonics()
    T, A, B = transformation(blades), sp.diag(*at_blades(d, blades)), sp.diag(*at_blades(k, blades))
    as_printed = inverse(blades) * (T.diff(psi, 2) + A.diff(psi) * T.diff(psi) + B * T)
    hover = dict.fromkeys((cs1, kc1, ks1, kc2, ks2), 0)
    right, wrong = (matrix.subs(hover).applyfunc(trigonometric) for matrix in (multiblade(blades).K, as_printed))
    assert (right[1, 2], right[2, 1]) == (c0, -c0)
    assert (wrong[1, 2], wrong[2, 1]) == (0, 0)


# ---------------------------------------------------------------------------------------------- tables 1 and 2
@pytest.mark.parametrize("blades", TABLES)
def test_multiblade_equations_are_tables_1_and_2(blades: int) -> None:
    """For any coefficients: D, K and a column of the forcing by its harmonics."""
    coefficients = {c.name: c for c in COEFFICIENTS}
    harmonics = {f.name: np.array([f]) for f in FORCING}
    tables = TABLES[blades](coefficients, harmonics, Azimuth())
    for name, derived, expected in zip("DKF", multiblade(blades), tables, strict=True):
        assert_same(derived, expected, name)


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("blades", TABLES)
def test_forcing_of_tables_1_and_2_has_every_column_of_equation_1(blades: int, exact: bool) -> None:
    columns = printed.forcing_harmonics(exact=exact, kinematic=True)
    rows = {name: np.array([row.get(j, sp.S.Zero) for j in range(10)]) for name, row in columns.items()}
    _, _, table = TABLES[blades]({c.name: c for c in COEFFICIENTS}, rows, Azimuth())
    derived = rotor.blade_forcing(exact=exact, kinematic=True)
    each = [multiblade(blades).F.subs({f: row[j] for f, row in derived.items()}) for j in range(10)]
    assert_same(sp.Matrix.hstack(*each), table, "F")


@pytest.mark.parametrize(("blades", "per_rev"), [(3, {0, 3}), (4, {0, 2, 4}), (6, {0, 3, 6})])
def test_periodic_terms_have_the_frequencies_of_observation_a(blades: int, per_rev: set[int]) -> None:
    """N per rev at most, multiples of N for odd N and of N/2 for even N."""
    entries = [entry for matrix in multiblade(blades) for entry in matrix]
    found = {abs(e.exp / (sp.I * psi)) for entry in entries for e in entry.atoms(sp.exp)}
    assert found | {0} == per_rev
