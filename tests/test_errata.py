"""The page docs/errata-tp1431.md is true: a test for each erratum, by physics that shares nothing with the package.

Each test shows that the printed form is wrong, that the package has the right one, and that every number in bold on
the page is what comes out.  Sizes are (printed − right)/right unless the page says otherwise.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from floquet.comparison import compare
from floquet.decoupling import (
    Sensitivities,
    appendix_c_mixing,
    control_mixing,
    decoupled_rate_response,
    decoupling_coupling,
    decoupling_offset,
    hover_gearing,
    hover_rate_feedback,
    hover_rate_response,
    mixed_controls,
    rate_feedback,
    teetering_gearing,
    uniform_mass_ratio,
)
from floquet.models import averaged, flapping, hover_modes, hover_response, multiblade, teetering, tip_path_plane
from floquet.periodic import PeriodicSystem
from floquet.response import periodic_response, reduced_order, steady_state
from floquet.rotor import Rotor, load_rotor
from floquet.validity import lock_windows, split_edges
from tests.test_decoupling import body_response, periodic_gains, table_3_gains
from tests.test_response import harmonic_balance
from tests.truth import blade_element, closed_forms

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "errata-tp1431.md").read_text(encoding="utf-8")
SECTION = re.compile(r"^## (\d+)\. ([^\n]+)\n(.*?)(?=^## |\Z)", re.MULTILINE | re.DOTALL)
ROW = re.compile(r"^\| (\w+) \| (.*) \|$", re.MULTILINE)
SUMMARY = re.compile(r"^\| \[(\d+)\]\(#(.*?)\) \| .* \| (.*) \|$", re.MULTILINE)
BOLD = re.compile(r"\*\*([−+]?)(\d+(?:\.(\d+))?)( %)?\*\*")

UH60A, BO105, FIGURE_6, FIGURE_7, TEETERING = (
    load_rotor(ROOT / "data" / "rotors" / f"{name}.toml")
    for name in ("uh60a", "bo105", "tp1431-fig6", "tp1431-fig7", "teetering-nominal")
)
EXACT = 1e-12  # what is the same but for rounding
TRUNCATED = 3e-4  # what the report's ε² leaves out of c₀ at ε = 0.15: ε⁴ of 3 − 8ε + 6ε²
P_W, Q_W, PRECONE = 5, 6, 0


# ---------------------------------------------------------------------- the page
def sections() -> dict[int, dict[str, str]]:
    """The rows of each section, with its title."""
    return {int(number): {"title": title, **dict(ROW.findall(body))} for number, title, body in SECTION.findall(PAGE)}


def assert_page(number: int, *computed: float) -> None:
    """The numbers in bold of a section are these, to the digits given; those in % as fractions."""
    found = BOLD.findall(sections()[number]["size"])
    assert len(found) == len(computed), f"erratum {number}: {len(found)} on the page, {len(computed)} computed"
    for (sign, digits, decimals, percent), value in zip(found, computed, strict=True):
        stated = float(digits) * (-1.0 if sign == "−" else 1.0)
        got = value * (100.0 if percent else 1.0)
        assert abs(got - stated) <= 0.5000001 * 10.0 ** -len(decimals), f"erratum {number}: page {stated}, is {got:.6g}"


def test_page_and_tests_have_the_same_errata() -> None:
    tests = {int(name[13:15]): name for name in globals() if name.startswith("test_erratum_")}
    assert list(sections()) == sorted(tests) == list(range(1, len(tests) + 1))
    for number, rows in sections().items():
        assert list(rows) == ["title", "where", "printed", "right", "size", "test"]
        assert rows["test"] == f"`{tests[number]}`"


def test_summary_of_the_page_is_that_of_its_sections() -> None:
    summary = SUMMARY.findall(PAGE)
    assert [int(number) for number, _, _ in summary] == list(sections())
    for number, anchor, size in summary:
        rows = sections()[int(number)]
        slug = re.sub(r"[^\w -]", "", f"{number} {rows['title']}".lower()).replace(" ", "-")
        bold = BOLD.findall(size)
        assert anchor == slug
        assert bold == BOLD.findall(rows["size"])[: len(bold)] and (bold or number == "14")


# ---------------------------------------------------------------------- independent physics
def numbers(rotor: Rotor) -> tuple[float, float, float, float, float]:
    """γ, ε, κ, K₁, m."""
    return (
        float(rotor.lock_number),
        float(rotor.hinge_offset),
        float(rotor.hinge_stiffness),
        float(rotor.pitch_flap_coupling),
        float(rotor.offset_mass_ratio),
    )


def blade(rotor: Rotor, mu: float = 0.0) -> tuple[closed_forms.Coefficients, closed_forms.Forcing]:
    g, e, kappa, K1, m = numbers(rotor)
    return (
        closed_forms.truncated(g, e, kappa, K1, mu, m),
        closed_forms.forcing(g, e, mu, m, float(rotor.static_moment_ratio)),
    )


def companion(D: Array, K: Array) -> Complex:
    """Eigenvalues of q'' + D q' + K q = 0."""
    n = len(D)
    return np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-K, -D]])).astype(complex)


def plane_modes(rotor: Rotor, mu: float = 0.0) -> tuple[Complex, Complex]:
    """The regressing and the advancing pair of table 3: the lowest and the highest frequency."""
    values = companion(*closed_forms.table_3(blade(rotor, mu)[0]))
    values = values[np.lexsort((values.real, np.abs(values.imag)))]
    return values[:2], values[-2:]


def exact_exponents(c: closed_forms.Coefficients) -> Complex:
    """The two exponents of a blade with |Im| ≤ ½, by SciPy: those of the regressing mode for ρ from ½ to 3/2."""

    def motion(psi: float, x: Array) -> list[float]:
        d, k = closed_forms.blade_damping(c, psi), closed_forms.blade_stiffness(c, psi)
        return [x[1], -d * x[1] - k * x[0], x[3], -d * x[3] - k * x[2]]

    y = solve_ivp(motion, (0.0, 2 * math.pi), [1.0, 0.0, 0.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return np.log(np.linalg.eigvals(y.reshape(2, 2).T).astype(complex)) / (2 * math.pi)


def relative_error(values: Complex, exact: Complex) -> float:
    """The larger distance of two exact exponents from the nearest of the values, over their rms."""
    return float(np.abs(values[:, None] - exact).min(axis=0).max() / np.sqrt(np.mean(np.abs(exact) ** 2)))


def multiblade_mean(rotor: Rotor, mu: float, blades: int) -> tuple[Array, Array]:
    """Means of D and K of (B5) over a revolution, by numbers, for an odd number of blades."""
    c, psi = blade(rotor, mu)[0], np.arange(64) * 2 * math.pi / 64  # 64 azimuths: harmonics up to 63 average exactly
    azimuth = psi[:, None] + 2 * math.pi * np.arange(blades) / blades
    n = np.arange(1, (blades - 1) // 2 + 1)
    cosine, sine = np.cos(n * azimuth[..., None]), np.sin(n * azimuth[..., None])
    columns = [
        np.stack(pair, axis=-1).reshape(64, blades, -1)
        for pair in ((cosine, sine), (-n * sine, n * cosine), (-n * n * cosine, -n * n * sine))
    ]
    T, T1, T2 = (
        np.concatenate([np.full((64, blades, 1), one), x], axis=-1)
        for one, x in zip((1.0, 0.0, 0.0), columns, strict=True)
    )
    A = np.vectorize(lambda p: closed_forms.blade_damping(c, p))(azimuth)[..., None]
    B = np.vectorize(lambda p: closed_forms.blade_stiffness(c, p))(azimuth)[..., None]
    Ti = np.linalg.inv(T)
    return (Ti @ (2 * T1 + A * T)).mean(axis=0), (Ti @ (T2 + A * T1 + B * T)).mean(axis=0)


def matrices(system: PeriodicSystem) -> tuple[Array, Array]:
    """D and K of a constant model of the package."""
    assert system.damping is not None and system.stiffness is not None
    return system.damping.mean(), system.stiffness.mean()


def hover_rates(rotor: Rotor) -> Array:
    """(a₁, b₁) per (p_w, q_w)/Ω at hover, from the harmonics of the blade's own motion."""
    first = harmonic_balance(*blade(rotor))[1]
    return np.stack([-first.real, first.imag])[:, [P_W, Q_W]]


def off(printed: float, right: float) -> float:
    return printed / right - 1.0


# ---------------------------------------------------------------------- equations and signs
def test_erratum_01_damping_ratio_of_a_blade_has_a_sixth_of_epsilon() -> None:
    """Damping and stiffness by quadrature along the blade."""
    sizes, ratios = [], []
    for rotor in (FIGURE_7, UH60A):
        g, e, _, _, m = numbers(rotor)
        element = blade_element.Blade(gamma=g, eps=e, m=m)
        P = math.sqrt(blade_element.stiffness(element, 0.0))
        right = blade_element.damping(element, 0.0) / (2 * P)
        printed = g / P * (1 / 16 - e / 3 + e**2 / 8)
        assert hover_modes(rotor, exact_offset=True).coning.damping_ratio == pytest.approx(right, rel=EXACT)
        assert hover_modes(rotor).coning.damping_ratio == pytest.approx(right, rel=TRUNCATED)
        assert g / P * (1 / 16 - e / 6 + e**2 / 8) == pytest.approx(right, rel=TRUNCATED)
        sizes.append(off(printed, right))
        ratios += [printed, right]
    assert_page(1, sizes[0], *ratios[:2], sizes[1], *ratios[2:])


def test_erratum_02_damping_ratios_of_10_lack_the_factor_P() -> None:
    """Eigenvalues of table 3."""
    sizes = []
    for rotor in (FIGURE_7, BO105):
        c = blade(rotor)[0]
        P = math.sqrt(c["P2"])
        zeta = c["c0"] / (2 * P)
        found = hover_modes(rotor)
        for pair, mode in zip(plane_modes(rotor), (found.regressing, found.advancing), strict=True):
            right = -pair[0].real / abs(pair[0])
            printed = zeta / abs(pair[0])
            assert mode.damping_ratio == pytest.approx(right, rel=EXACT)
            assert printed == pytest.approx(right / P, rel=EXACT)
            sizes.append(off(printed, right))
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-10) and sizes[2] == pytest.approx(sizes[3], rel=1e-10)
    heavy = Rotor(lock_number=20.0)  # ζ = 1.25: (10) has the root of a negative number, table 3 has −½ ± i and −2 ± i
    assert hover_modes(heavy).overdamped and float(heavy.lock_number) / 16 == 1.25
    pairs = [-0.5 + 1j, -0.5 - 1j, -2.0 + 1j, -2.0 - 1j]
    table = companion(*closed_forms.table_3(blade(heavy)[0]))
    assert np.abs(table[:, None] - pairs).min(axis=0).max() < EXACT
    assert_page(2, sizes[0], sizes[2])


def test_erratum_03_equation_20_has_the_numerator_of_a_centred_rotor() -> None:
    """On condition (19), met by the K₁ of (24), the blade's harmonics give a₁ due to q_w."""
    values = []
    for rotor in (FIGURE_7, UH60A):
        g, e, _, _, m = numbers(rotor)
        c0, C = g / 2 * (1 / 4 - 2 / 3 * e + e**2 / 2), g / 2 * (1 / 4 - e / 3)
        spring = c0 * C / (2 * (1 + m))
        met = rotor.replace(pitch_flap_coupling=(spring - m) / C)
        rates = hover_rates(met)
        assert np.abs(np.diag(rates)).max() < EXACT and rates[0, 1] == pytest.approx(rates[1, 0], rel=EXACT)
        printed = -(g / 4 + g / 8 * spring) / (spring**2 + c0**2)
        assert decoupled_rate_response(met) == pytest.approx(rates[0, 1], rel=EXACT)
        values += [off(printed, rates[0, 1]), printed, rates[0, 1]]
    centred = Rotor(lock_number=8.0, pitch_flap_coupling=0.5)  # ε = 0: printed and right are the same
    assert hover_rates(centred)[0, 1] == pytest.approx(-(2 + 0.5) / (0.25 + 1), rel=EXACT)
    assert_page(3, values[0], *values[1:3], values[3], *values[4:])


def test_erratum_04_lateral_response_to_pitch_rate_is_the_negative() -> None:
    """The blade's harmonics at hover."""
    for rotor in (UH60A, BO105, FIGURE_7):
        rates = hover_rates(rotor)
        assert rates[1, 1] == pytest.approx(-rates[0, 0], rel=EXACT) and abs(rates[0, 0]) > 0.05
        np.testing.assert_allclose(hover_rate_response(rotor), rates, atol=EXACT)
    right = hover_rates(UH60A)[1, 1]
    assert_page(4, right, -right)


def test_erratum_05_aerodynamic_rate_groups_lack_the_square_of_the_rotor_speed() -> None:
    """Lift due to roll rate in newtons, integrated along the blade in metres."""
    assert UH60A.rotor_speed is not None and UH60A.radius is not None
    g, e, _, _, m = numbers(UH60A)
    speed, R, inertia = UH60A.rotor_speed, UH60A.radius, 2050.8
    hinge, lift = e * R, g * inertia / R**4  # ρ a c
    p, psi, mu = 0.1, 0.9, 0.2

    def moment(radius: float) -> float:
        tangential = speed * radius + mu * speed * R * math.sin(psi)
        return 0.5 * lift * tangential * radius * p * math.sin(psi) * (radius - hinge)

    right = quad(moment, hinge, R, epsrel=1e-12)[0] / inertia  # rad/s²
    printed = g / 2 * (1 / 4 - e / 3) * p / speed * math.sin(psi)
    printed += g / 8 * mu * (2 / 3 - e) * p / speed * (1 - math.cos(2 * psi))
    F = flapping(UH60A, mu, exact_offset=True).forcing
    assert F is not None
    column = F.sample(np.array([psi]))[0, 0, P_W] - 2 * (1 + m) * math.cos(psi)  # less Coriolis
    assert speed**2 * column * p / speed == pytest.approx(right, rel=EXACT)
    ratio = right / printed
    assert ratio == pytest.approx(speed**2, rel=1e-4)  # truncation at ε²
    c, f = blade(UH60A)
    for name, sign in (("fs1", P_W), ("fc1", Q_W)):
        f[name][sign] /= speed**2
    as_printed = -harmonic_balance(c, f)[1, P_W].real
    assert_page(5, ratio, as_printed, hover_rates(UH60A)[0, 0])


def test_erratum_06_moment_of_body_acceleration_lacks_the_hinge() -> None:
    """Inertia of a uniform blade by quadrature: an element at e + r is lifted by (e + r) ṗ and has the arm r."""
    e = float(FIGURE_7.hinge_offset)
    inertia, static, moment = (quad(f, 0, 1 - e)[0] for f in (lambda r: r * r, lambda r: r, lambda r: r * (e + r)))
    rotor = FIGURE_7.replace(offset_mass_ratio=e * static / inertia)
    for psi, column in ((math.pi / 2, 7), (0.0, 8)):
        right, printed = (flapping(rotor, 0.2, kinematic_rates=kinematic).forcing for kinematic in (True, False))
        assert right is not None and printed is not None
        assert right.sample(np.array([psi]))[0, 0, column] == pytest.approx(moment / inertia, rel=EXACT)
        assert printed.sample(np.array([psi]))[0, 0, column] == pytest.approx(
            1.0, rel=EXACT
        )  # the report's, by default
    right_plane, printed_plane = (
        hover_response(FIGURE_7, {"qdot_w": 1.0}, kinematic_rates=kinematic)[1] for kinematic in (True, False)
    )
    assert_page(6, off(printed_plane, right_plane), off(1.0, 1.0 + 0.381 * 385.7 / 2050.8))


def test_erratum_07_mass_ratio_of_a_uniform_blade_is_not_linear_in_the_offset() -> None:
    """Static moment and inertia by quadrature; figure 17 by the closed condition (19)."""
    e = float(FIGURE_7.hinge_offset)
    right = e * quad(lambda r: r, 0, 1 - e)[0] / quad(lambda r: r * r, 0, 1 - e)[0]
    assert uniform_mass_ratio(np.array(e)) == pytest.approx(right, rel=EXACT)
    truncated = closed_forms.truncated(8.0, e)["c0"] / closed_forms.exact(8.0, e)["c0"] - 1

    def condition(x: float, m: float) -> float:
        return 2 * (1 + m) * m - 16.0 * (1 / 4 - x / 3) * (1 / 4 - 2 / 3 * x + x * x / 2)

    offsets = [
        brentq(lambda x: condition(x, 1.5 * x), 0.05, 0.3, xtol=1e-14),
        brentq(lambda x: condition(x, 1.5 * x / (1 - x)), 0.05, 0.3, xtol=1e-14),
    ]
    assert decoupling_offset(8.0) == pytest.approx(offsets[0], abs=EXACT)
    assert decoupling_offset(8.0, mass_ratio=uniform_mass_ratio) == pytest.approx(offsets[1], abs=EXACT)
    measured = 0.381 * 385.7 / 2050.8
    assert UH60A.offset_mass_ratio == pytest.approx(measured, rel=EXACT)
    assert_page(
        7, off(1.5 * e, right), 1.5 * e, right, truncated, *offsets, off(1.5 * float(UH60A.hinge_offset), measured)
    )


def test_erratum_08_cycle_time_is_an_eighth_of_that_printed() -> None:
    """Two samples a period of a mode at 2 per rev; of the eigenvalue of table 3 for γ = 8."""
    speed = 300 * 2 * math.pi / 60
    printed, right = 4 * math.pi / speed, math.pi / (2 * speed)
    assert printed == pytest.approx(8 * right, rel=EXACT)
    advancing = abs(plane_modes(FIGURE_6)[1][0])
    assert advancing == pytest.approx(hover_modes(FIGURE_6).advancing.frequency, rel=EXACT)
    assert_page(8, printed, right, math.pi / (advancing * speed))


def test_erratum_09_sensitivities_of_appendix_C_are_those_of_equation_C2() -> None:
    """A longitudinal stick moves a₁ and a lateral one b₁, on table 3 and on the blade's harmonics at hover."""
    k = Sensitivities(coning=1.3, longitudinal=0.7, lateral=0.9)
    c2 = np.array([[1.3, 0, 0], [0, 0, 0.7], [0, 0.9, 0]])  # rows a₀, a₁, b₁; columns δ_C, δ_A, δ_L
    as_defined = np.array([[1.3, 0, 0], [0, 0.7, 0], [0, 0, 0.9]])  # k₁ = ∂a₁/∂δ_A, k₂ = ∂b₁/∂δ_L
    for mu in (0.0, 0.3):
        E_K = table_3_gains(UH60A, mu)[:, :3]
        for mixing in (control_mixing(UH60A, mu, k), appendix_c_mixing(UH60A, mu, k)):
            np.testing.assert_allclose(E_K @ mixing, c2, atol=EXACT)
            assert np.abs(E_K @ mixing - as_defined).max() > 0.6
    hover = periodic_gains(UH60A, 0.0)[1:, 1:3]  # ∂(a₁, b₁)/∂(A₁, B₁)
    np.testing.assert_allclose(hover @ hover_gearing(UH60A, k), c2[1:, 1:], atol=EXACT)
    A1, B1 = np.linalg.solve(hover, [1.0, 0.0])  # for ∂a₁/∂δ_L = 1: the third column of K_D
    np.testing.assert_allclose(hover_gearing(UH60A)[:, 1], [A1, B1], atol=EXACT)
    assert_page(9, B1, A1)


SWAP = np.array([[0.0, 1.0], [1.0, 0.0]])
PROMISE = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])  # rows a₀, a₁, b₁; columns δ_C, δ_A, δ_L


def mixed(mixing: Array, sideslip: float) -> Array:
    """(a₀, a₁, b₁) per pilot input of the UH-60A at μ = 0.3, in body axes, on table 3."""
    gains = table_3_gains(UH60A, 0.3)
    return np.stack([body_response(gains, sideslip, 0.0, theta_0=t, A=a, B=b) for t, a, b in mixing.T], axis=-1)


def fed_back(feedback: Array, sideslip: float) -> Array:
    """(a₁, b₁) per body rate of the Bo 105 at μ = 0.3, likewise."""
    gains, columns = table_3_gains(BO105, 0.3), []
    for p, q in ((1.0, 0.0), (0.0, 1.0)):
        A, B = feedback @ [p, q]
        columns.append(body_response(gains, sideslip, 0.0, A=A, B=B, p=p, q=q)[1:])
    return np.stack(columns, axis=-1)


def two_bladed(gearing: Array, sideslip: float) -> Array:
    """(a₁, b₁) per cyclic stick of the teetering rotor at μ = 0.3, likewise, on eq. (7)."""
    _, T, F = closed_forms.teetering_tip_path_plane(float(TEETERING.lock_number), 0.0, 0.0, 0.3)
    gains = np.concatenate([np.zeros((1, 10)), np.linalg.solve(T, F)])
    return np.stack([body_response(gains, sideslip, 0.0, A=a, B=b)[1:] for a, b in gearing.T], axis=-1)


def test_erratum_10_laws_hold_in_wind_axes() -> None:
    """The plane seen from the body's axes, by projection of its harmonics."""
    mu, small, large = 0.3, math.radians(10.0), math.radians(30.0)
    for angle in (small, large):
        np.testing.assert_allclose(mixed(control_mixing(UH60A, mu, sideslip=angle), angle), PROMISE, atol=EXACT)
        fed = fed_back(rate_feedback(BO105, mu, 1.5, sideslip=angle), angle)
        np.testing.assert_allclose(fed, -1.5 * SWAP, atol=EXACT)
        two = two_bladed(control_mixing(TEETERING, mu, sideslip=angle), angle)
        np.testing.assert_allclose(two, SWAP, atol=EXACT)
    np.testing.assert_allclose(  # (28), at hover, is the same in any axes
        rate_feedback(BO105, 0.0, 1.5, sideslip=large), hover_rate_feedback(BO105, 1.5), atol=EXACT
    )
    c4, eq16, kf = appendix_c_mixing(UH60A, mu), teetering_gearing(TEETERING, mu), rate_feedback(BO105, mu, 1.5)
    for law, closed, promise in ((c4, mixed, PROMISE), (eq16, two_bladed, SWAP), (kf, fed_back, -1.5 * SWAP)):
        np.testing.assert_allclose(closed(law, 0.0), promise, atol=EXACT)
    printed = mixed(c4, large)
    assert_page(
        10,
        mixed(c4, small)[2, 0],
        printed[2, 0],
        printed[1, 1],
        two_bladed(eq16, large)[0, 0],
        np.abs(fed_back(kf, large) + 1.5 * SWAP).max() / 1.5,
    )


def test_erratum_11_averaged_multiblade_equations_of_five_blades_are_not_the_plane() -> None:
    """(B5) averaged by numbers; the blade's exponents by SciPy."""
    rotor, mu = FIGURE_6, 0.3
    exact = exact_exponents(blade(rotor, mu)[0])
    errors = []
    for blades in (3, 5, 7):
        mean = multiblade_mean(rotor, mu, blades)
        found = matrices(averaged(rotor, mu, (blades - 1) // 2))
        for a, b in zip(mean, found, strict=True):
            np.testing.assert_allclose(b, a, atol=EXACT)
        errors.append(relative_error(companion(*mean), exact))
    D, K = closed_forms.table_3(blade(rotor, mu)[0])
    sign = np.diag([1.0, -1.0, -1.0])
    three = multiblade_mean(rotor, mu, 3)
    np.testing.assert_allclose([sign @ D @ sign, sign @ K @ sign], three, atol=EXACT)
    assert_page(11, *errors)


def test_erratum_12_precone_moves_a_teetering_rotor() -> None:
    """Moments of the two blades, each with a₀ more flap angle, by quadrature; motion by harmonic balance of (2)."""
    g, mu = float(TEETERING.lock_number), 0.3
    for K1 in (0.0, 0.25):
        one = blade_element.Blade(gamma=g, mu=mu, K1=K1)
        F = teetering(TEETERING.replace(pitch_flap_coupling=K1), mu).forcing
        assert F is not None
        for psi in (0.4, 1.7, 3.0):
            first, second = (blade_element.hinge_moment(one, p, beta=1.0) for p in (psi, psi + math.pi))
            right = 0.5 * (first - second)
            assert F.sample(np.array([psi]))[0, 0, -1] == pytest.approx(right, abs=EXACT)
            assert right == pytest.approx(-g * mu * (math.cos(psi) / 6 + K1 * math.sin(psi) / 3), abs=EXACT)
        lateral = steady_state(tip_path_plane(TEETERING.replace(pitch_flap_coupling=K1), mu), {"precone": 1.0})
        _, T, _ = closed_forms.teetering_tip_path_plane(g, 0.0, K1, mu)
        np.testing.assert_allclose(lateral, np.linalg.solve(T, [g * mu / 6, g * K1 * mu / 3]), atol=EXACT)
    f = {name: np.zeros(10) for name in closed_forms.HARMONICS}
    f["fc1"][PRECONE] = -g * mu / 6
    b1 = harmonic_balance(closed_forms.teetering(g, mu=mu), f)[1, PRECONE].imag
    _, T, _ = closed_forms.teetering_tip_path_plane(g, 0.0, 0.0, mu)
    plane = np.linalg.solve(T, [g * mu / 6, 0.0])
    np.testing.assert_allclose(plane, [0.0, 4 / 3 * mu / (1 + mu**2 / 2)], atol=EXACT)  # for any γ
    found = periodic_response(teetering(TEETERING, mu), {"precone": 1.0}).tip_path_plane
    assert found[2] == pytest.approx(b1, abs=EXACT)
    np.testing.assert_allclose(steady_state(tip_path_plane(TEETERING, mu), {"precone": 1.0}), plane, atol=EXACT)
    assert_page(12, plane[1], b1, 3.0 * plane[1])


def test_erratum_13_weight_pulls_the_blade_down() -> None:
    """The moment is minus the slope of the blade's potential energy."""
    assert UH60A.rotor_speed is not None and UH60A.radius is not None
    g, speed, h = 9.80665, UH60A.rotor_speed, 1e-4
    energy = [g * 385.7 * math.sin(beta) for beta in (-h, h)]  # mass outboard of the hinge, lifted by r sin β
    moment = -(energy[1] - energy[0]) / (2 * h)
    right = moment / (2050.8 * speed**2) / blade(UH60A)[0]["P2"]
    found, _, _ = hover_response(UH60A, {"normal_acceleration": -g / (speed**2 * UH60A.radius)})
    assert found == pytest.approx(right, rel=1e-8) and right < 0  # rel: the difference quotient
    assert_page(13, math.degrees(right), -math.degrees(right))


def test_erratum_14_cross_references_and_indices() -> None:
    """What each is said to follow from: (24) from (19), (B4) from (B1), β of even N, and the gearing of δ_A."""
    # (24) is (19) with κ = 0; (23) is a response of −16/γ and holds no K₁ and no offset
    g, e, _, _, m = numbers(UH60A)
    right = g**2 / 4 * (1 / 4 - e / 3) * (1 / 4 - 2 / 3 * e + e**2 / 2) / (2 * (1 + m))
    K1 = (right - m) / (g / 8 * (1 - 4 / 3 * e))
    assert np.abs(np.diag(hover_rates(UH60A.replace(pitch_flap_coupling=K1)))).max() < EXACT
    assert decoupling_coupling(UH60A) == pytest.approx(K1, rel=EXACT)
    # (B4) is (B1) for every blade, in units of the rotor speed; (A1) is a sum of moments
    mu, psi = 0.3, 0.7
    c, system = blade(UH60A, mu)[0], multiblade(UH60A, mu)
    azimuths = psi + np.arange(4) * math.pi / 2
    T = np.stack([np.ones(4), np.cos(azimuths), np.sin(azimuths), [-1, 1, -1, 1]], axis=-1)
    T1 = np.stack([np.zeros(4), -np.sin(azimuths), np.cos(azimuths), np.zeros(4)], axis=-1)
    A = np.diag([closed_forms.blade_damping(c, p) for p in azimuths])
    assert system.damping is not None
    found = T @ system.damping.sample(np.array([psi]))[0] @ np.linalg.inv(T)
    np.testing.assert_allclose(found, A + 2 * T1 @ np.linalg.inv(T), atol=EXACT)
    # N coordinates: 1 + 2(N − 2)/2 + 1 for even N, for which (N − 1)/2 is no whole number
    for blades in (4, 6, 8):
        names = multiblade(UH60A.replace(blades=blades), 0.1).coordinates
        assert len(names) == blades and names[-2:] == (f"beta_{(blades - 2) // 2}s", "beta_d")
        assert (blades - 1) % 2 == 1
    # (14): ∂B/∂δ_A, printed with δ_B, is what keeps a₁ still under δ_A
    A1, B1 = hover_gearing(UH60A)[:, 0]
    a1, b1 = periodic_gains(UH60A, 0.0)[1:, 1:3] @ [A1, B1]
    assert (a1, b1) == pytest.approx((0.0, 1.0), abs=EXACT)
    assert_page(14)


# ---------------------------------------------------------------------- claims
def shift(rotor: Rotor, mu: float) -> float:
    """How far the regressing pair of table 3 lies from where it was at hover, relative to that."""
    now, hover = plane_modes(rotor, mu)[0], plane_modes(rotor)[0]
    return float(min(np.abs(now - hover).max(), np.abs(now[::-1] - hover).max()) / abs(hover[0]))


def merging(rotor: Rotor, low: float, high: float) -> float:
    """Where the regressing pair of table 3 becomes two reals."""

    def squared(mu: float) -> float:
        pair = plane_modes(rotor, mu)[0]
        return float(((pair[0] - pair[1]) ** 2).real)

    return float(brentq(squared, low, high, xtol=1e-13))


def test_erratum_15_modes_are_not_invariant_with_advance_ratio() -> None:
    """Eigenvalues of table 3 (the report's own model)."""
    merged = []
    for gamma in (12.0, 10.0):
        rotor = FIGURE_7.replace(lock_number=gamma)
        merged.append(merging(rotor, 0.05, 0.4))
        assert split_edges(rotor, 0.4) == pytest.approx([merged[-1]], abs=1e-9)  # the root of a square root
        for mu in (merged[-1] - 0.01, merged[-1] + 0.01):
            split = np.abs(plane_modes(rotor, mu)[0].imag).max() == 0.0
            assert split == (mu > merged[-1])
    light = FIGURE_6.replace(lock_number=2.0)
    found = compare(light, np.array([0.0, 0.4]))["regressing"].simple
    pair = plane_modes(light, 0.4)[0]
    assert np.abs(found[1][:, None] - pair[None, :]).min(axis=1).max() < 1e-10
    assert shift(FIGURE_7.replace(lock_number=6.0), 0.4) < 0.03
    moved = [shift(FIGURE_7.replace(lock_number=gamma), 0.4) for gamma in (12.0, 10.0)]
    assert_page(15, merged[0], merged[1], *moved, shift(light, 0.4), merging(light, 0.2, 0.4))


def test_erratum_16_large_offset_does_not_always_lower_the_regressing_frequency() -> None:
    """Size of the eigenvalues of table 3 at hover."""
    frequencies = []
    for offset in (0.0, 0.05, 0.10, 0.15):
        rotor = Rotor(lock_number=2.0, hinge_offset=offset)
        frequencies.append(float(abs(plane_modes(rotor)[0][0])))
        assert hover_modes(rotor).regressing.frequency == pytest.approx(frequencies[-1], rel=EXACT)
    for gamma in (4.0, 8.0, 12.0):
        values = [abs(plane_modes(Rotor(lock_number=gamma, hinge_offset=e))[0][0]) for e in (0.0, 0.05, 0.10, 0.15)]
        assert np.all(np.diff(values) < 0)
    assert_page(16, frequencies[3] / frequencies[0] - 1, frequencies[3] / frequencies[1] - 1, *frequencies)


def test_erratum_17_teetering_plane_fails_at_the_lock_and_not_at_a_fixed_advance_ratio() -> None:
    """Lock edges of (2), a damped Mathieu equation, by SciPy; exponents of (2) by SciPy, eigenvalues of (7)."""
    edges = []
    for gamma in (8.0, 2.0):
        a = 1 - (gamma / 16) ** 2
        edges.append(float(brentq(lambda mu, g=gamma, a=a: mathieu_b(1, g * mu**2 / 16) - a, 0.1, 0.9, xtol=1e-13)))
        inside, outside = (gamma * (edges[-1] + d) ** 2 / 16 for d in (0.05, -0.05))
        assert mathieu_b(1, inside) < a < mathieu_a(1, inside) and not mathieu_b(1, outside) < a
        windows = lock_windows(TEETERING.replace(lock_number=gamma))
        assert windows == [(pytest.approx(edges[-1], abs=1e-10), math.inf, 1.0)]

    advance_ratios, errors = (0.4, 0.65, math.sqrt(8.0) / 4), []
    for mu in advance_ratios:
        values = companion(*closed_forms.teetering_tip_path_plane(8.0, 0.0, 0.0, mu)[:2])
        errors.append(relative_error(values, exact_exponents(closed_forms.teetering(8.0, mu=mu))))
        found = compare(TEETERING.replace(lock_number=8.0), mu)["regressing"].error
        assert found == pytest.approx(errors[-1], abs=1e-7)  # the square root of rounding where the plane splits
    for gamma in (2.0, 8.0):
        D, K = closed_forms.teetering_tip_path_plane(gamma, 0.0, 0.0, math.sqrt(gamma) / 4)[:2]
        assert np.sort(np.abs(companion(D, K).imag))[1] < 1e-7  # two reals begin: a double root
        splits = split_edges(TEETERING.replace(lock_number=gamma))
        assert splits == [pytest.approx(math.sqrt(gamma) / 4, abs=1e-9)]
    beyond = compare(TEETERING.replace(lock_number=8.0), np.linspace(0.4, 1.0, 601))["regressing"].error
    assert beyond.max() < errors[-1] + 1e-7
    assert_page(17, *edges, *errors)


def test_erratum_18_reduced_order_model_has_other_roots_and_responses() -> None:
    """Eigenvalues and frequency response of table 3 with and without its second derivatives."""
    sizes = []
    for gamma, offset in ((8.0, 0.0), (8.0, 0.15), (12.0, 0.0)):
        rotor = Rotor(lock_number=gamma, hinge_offset=offset)
        D, K = closed_forms.table_3(blade(rotor)[0])
        reduced = np.linalg.eigvals(-np.linalg.solve(D, K)).astype(complex)
        A = reduced_order(tip_path_plane(rotor, 0.0)).sample(np.zeros(1))[0]
        np.testing.assert_allclose(A, -np.linalg.solve(D, K), atol=EXACT)
        full = plane_modes(rotor)[0]
        full = full[np.argmax(full.imag)]
        sizes.append(float(np.abs(reduced - full).min() / abs(full)))
    D, K = closed_forms.table_3(blade(FIGURE_6)[0])
    F = closed_forms.table_3_forcing(8.0)[:, 1:3]
    responses = []
    for omega in (0.1, 0.4):
        slow = K + 1j * omega * D
        right, printed = (np.linalg.solve(M, F) for M in (slow - omega**2 * np.eye(3), slow))
        responses.append(float(np.linalg.norm(printed - right, 2) / np.linalg.norm(right, 2)))
    assert_page(18, *sizes, *responses)


def test_erratum_19_hinge_restraint_turns_the_sign_of_the_required_coupling() -> None:
    """K₁ at which the blade's harmonics show no cross response at hover, found by root-finding."""

    def coupling(gamma: float, kappa: float) -> float:
        rotor = Rotor(lock_number=gamma, hinge_stiffness=kappa)
        found = brentq(lambda K1: hover_rates(rotor.replace(pitch_flap_coupling=K1))[0, 0], -0.4, 1.0, xtol=1e-13)
        assert decoupling_coupling(rotor) == pytest.approx(found, abs=1e-10)
        return float(found)

    heavy, light = ([coupling(gamma, kappa) for kappa in (0.0, 0.225)] for gamma in (8.0, 4.0))
    assert_page(19, heavy[1] / heavy[0] - 1, *heavy, *light)


def test_erratum_20_responses_on_the_decoupling_condition_are_not_those_of_unit_frequency() -> None:
    """The blade's harmonics at hover, γ = 8, ε = 0: P = 1 against K₁ = γ/16."""
    unit, met = (hover_rates(FIGURE_6.replace(pitch_flap_coupling=K1)) for K1 in (0.0, 0.5))
    np.testing.assert_allclose(hover_rate_response(FIGURE_6.replace(pitch_flap_coupling=0.5)), met, atol=EXACT)
    assert met[0, 1] == pytest.approx(unit[0, 1], rel=EXACT) == pytest.approx(-2.0, rel=EXACT)
    assert abs(met[0, 0]) < EXACT
    assert_page(20, unit[0, 0])


def test_erratum_21_twist_is_counted_from_the_axis() -> None:
    """Moment of a blade whose pitch rises by 1 rad from the hinge to the tip, by quadrature."""
    sizes = []
    for rotor in (FIGURE_7, UH60A):
        g, e = float(rotor.lock_number), float(rotor.hinge_offset)
        right = g / 2 * quad(lambda x, e=e: x * x * (x - e) / (1 - e) * (x - e), e, 1)[0]
        F = flapping(rotor, 0.0, exact_offset=True).forcing
        assert F is not None
        f = F.mean()[0]
        assert -e / (1 - e) * f[0] + f[3] / (1 - e) == pytest.approx(right, rel=EXACT)
        as_listed = f[3] - e * f[0]  # θ_t = 1 and the same pitch at the root
        sizes.append(as_listed / right - 1)
    assert_page(21, *sizes)


def test_erratum_22_decoupling_in_forward_flight_is_perfect_on_table_3_only() -> None:
    """Table 3 solved for the controls, and the blade's harmonics under them."""
    left = []
    for rotor in (UH60A, BO105):
        mixing = np.linalg.solve(table_3_gains(rotor, 0.3)[:, :3], PROMISE)
        np.testing.assert_allclose(control_mixing(rotor, 0.3), mixing, atol=EXACT)
        off_promise = periodic_gains(rotor, 0.3)[:, :3] @ mixing - PROMISE
        found = mixed_controls(rotor, 0.3, mixing)
        np.testing.assert_allclose(found.periodic - PROMISE, off_promise, atol=EXACT)
        left.append(float(np.abs(off_promise).max()))
    assert_page(22, *left)


# ---------------------------------------------------------------------- what the scan does not show
def test_undecidable_places_of_the_scan_are_as_the_page_says() -> None:
    g, e, _, _, m = numbers(FIGURE_7)
    mu, psi = 0.3, 0.6
    spring = blade_element.stiffness(blade_element.Blade(gamma=g, eps=e, m=m, mu=mu), psi) - 1 - m
    bracket = (1 / 3 - e / 2 + (1 / 2 - e + e**2 / 2) * mu * math.sin(psi)) * mu * math.cos(psi)
    assert spring == pytest.approx(g / 2 * bracket, rel=0.01)  # (A5): truncation
    assert abs(spring / bracket - 1) > 2
    _, K = multiblade_mean(UH60A, 0.0, 3)  # (B5) with A at hover, where Ȧ = 0
    assert K[1, 2] == pytest.approx(blade(UH60A)[0]["c0"], rel=EXACT)
    feedback = rate_feedback(UH60A, 0.0, 1.5)  # (27) with k₃ in both places
    gains = periodic_gains(UH60A, 0.0)[1:]
    closed = gains[:, [P_W, Q_W]] + gains[:, 1:3] @ feedback
    np.testing.assert_allclose(closed, [[0.0, -1.5], [-1.5, 0.0]], atol=EXACT)
    twist = g / 2 * quad(lambda x: x * x * x * (x - e), e, 1)[0]  # x θ_t
    constant = g / 2 * quad(lambda x: x * x * (x - e), e, 1)[0]
    assert twist == pytest.approx(g / 2 * (1 / 5 - e / 4), rel=TRUNCATED) and constant / twist > 1.2
    D, _ = multiblade_mean(FIGURE_7, mu, 3)  # table 3 has D₂₃ and, with the signs of a₁ and b₁, D₃₁
    assert D[1, 2] == pytest.approx(2.0, rel=EXACT)
    assert D[2, 0] == pytest.approx(g * mu / 2 * (1 / 3 - e + e**2), rel=EXACT)
