"""The independent truths agree among themselves, before the package is held against them.

Quadrature against polynomials, polynomials against tables by brute force, tables against polynomial roots, and the
Taylor integrator against closed forms and the stored references.
"""

from __future__ import annotations

import ast
import json
import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from tests.truth import blade_element, closed_forms, problems, taylor
from tests.truth.blade_element import Blade

ROOT = Path(__file__).resolve().parents[1]
REFERENCE = ROOT / "data" / "reference"
ORACLE = {case["id"]: case for case in json.loads((REFERENCE / "floquet_oracle.json").read_text())["cases"]}
TRANSITIONS = json.loads((REFERENCE / "transitions.json").read_text())
EXPONENTS = json.loads((REFERENCE / "exponents.json").read_text())["cases"]
TEXTBOOK = tomllib.loads((REFERENCE / "textbook.toml").read_text())
QUADRATURE = 1e-12  # tolerance of the quadrature 1e-13, times γ/2 up to 12
ROUNDING = 1e-13  # a few dozen operations on numbers up to a hundred
PERIODS = {"2pi": 2, "pi": 1, "pi/2": 0.5}


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    """Fifty digits for every test here, and whatever it was afterwards."""
    with mp.workdps(taylor.DIGITS):
        yield


def random_blades(count: int, *, mu_max: float = 1.2, eps_max: float = 0.25) -> list[dict[str, float]]:
    """Parameters of ``count`` blades, always the same, m independent of ε."""
    rng = np.random.default_rng(7)
    names = ("gamma", "eps", "kappa", "K1", "mu", "m")
    low, high = [2, 0, 0, -0.5, 0, 0], [24, eps_max, 0.5, 0.5, mu_max, 0.4]
    return [dict(zip(names, map(float, rng.uniform(low, high)), strict=True)) for _ in range(count)]


def azimuths(count: int) -> NDArray[np.float64]:
    return np.random.default_rng(11).uniform(0, 2 * np.pi, count)


# ------------------------------------------------------------------------------------------------ independence
def test_truth_shares_no_code_with_the_package() -> None:
    for path in (ROOT / "tests" / "truth").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "floquet" for name in names), path.name


# ------------------------------------------------------------------------------------------------ one blade
@pytest.mark.parametrize("kinematic", [False, True])
def test_exact_coefficients_are_the_quadrature(kinematic: bool) -> None:
    for values, psi in zip(random_blades(8), azimuths(8), strict=True):
        blade = Blade(**values, s=1.7, kinematic_rates=kinematic)
        c = closed_forms.exact(**values)
        f = closed_forms.forcing(
            values["gamma"], values["eps"], values["mu"], values["m"], 1.7, exact_offset=True, kinematic_rates=kinematic
        )
        assert_allclose(blade_element.damping(blade, psi), closed_forms.blade_damping(c, psi), atol=QUADRATURE)
        assert_allclose(blade_element.stiffness(blade, psi), closed_forms.blade_stiffness(c, psi), atol=QUADRATURE)
        assert_allclose(blade_element.forcing(blade, psi), closed_forms.blade_forcing(f, psi), atol=QUADRATURE)


def test_truncated_coefficients_leave_an_error_of_third_order_in_the_offset() -> None:
    parameters = {"gamma": 9.0, "kappa": 0.1, "K1": 0.4, "mu": 0.7, "m": 0.1}
    eps = np.array([0.02, 0.01])
    short, full = (make(eps=eps, **parameters) for make in (closed_forms.truncated, closed_forms.exact))
    for name in short:
        error = np.abs(short[name] - full[name]) * np.ones(2)
        assert error[1] < 30 * eps[1] ** 3, name  # γ/2 times the largest coefficient of ε³, 5/3, times μ or so
        assert error[0] == pytest.approx(error[1], abs=1e-15) or np.log2(error[0] / error[1]) > 2.9, name
    assert {name for name in short if np.ptp(np.abs(short[name] - full[name])) > 1e-9} == {
        "P2", "c0", "cs1", "k0", "kc1", "ks1",
    }  # fmt: skip
    rows = [
        [closed_forms.forcing(9.0, e, 0.7, 0.1, exact_offset=exact) for exact in (False, True)] for e in (0.02, 0.01)
    ]
    for name in closed_forms.HARMONICS:
        errors = [np.abs(row[0][name] - row[1][name]).max() for row in rows]
        assert errors[1] < 30 * 0.01**3, name
        assert errors[0] < 1e-15 or np.log2(errors[0] / errors[1]) > 2.9, name


def test_offset_mass_ratio_is_the_reports_unless_given() -> None:
    for make in (closed_forms.truncated, closed_forms.exact):
        assert make(8.0, 0.1, K1=0.3) == make(8.0, 0.1, K1=0.3, m=3 * 0.1 / 2)
    for make_loads in (closed_forms.table_3_forcing, lambda *a: closed_forms.forcing(*a)["fc1"]):
        assert_allclose(make_loads(8.0, 0.1, 0.3), make_loads(8.0, 0.1, 0.3, 0.15), atol=ROUNDING)
    given, default = (problems.flapping("8", "0.3", eps="0.1", m=m) for m in ("0.15", None))
    assert taylor.scalar_exponents(given) == taylor.scalar_exponents(default)


def test_reversed_flow_polynomials_are_the_quadrature() -> None:
    regions = set()
    for i, (values, psi) in enumerate(zip(random_blades(24, mu_max=2.5), azimuths(24), strict=True)):
        values["eps"] *= i % 3 > 0
        gamma, eps, K1, mu = (values[name] for name in ("gamma", "eps", "K1", "mu"))
        region = closed_forms.reversed_flow_region(eps, mu, psi)
        damping, spring, coupling = closed_forms.reversed_flow(gamma, eps, K1, mu, np.sin(psi), region)
        structure = 1 + values["kappa"] + values["m"]
        blade = Blade(**values, reversed_flow=True)
        assert_allclose(blade_element.damping(blade, psi), damping, atol=QUADRATURE)
        assert_allclose(
            blade_element.stiffness(blade, psi), structure + spring * np.cos(psi) + coupling, atol=QUADRATURE
        )
        regions.add((region, eps > 0))
    assert regions == {(region, offset) for region in (0, 1, 2) for offset in (False, True)}


@pytest.mark.parametrize("reversed_flow", [False, True])
def test_tip_loss_root_cutout_and_flap_damping_are_limits_and_a_constant(reversed_flow: bool) -> None:
    """∫ |x + u| (x − ε)² dx from the cutout to B, by the antiderivative on either side of x = −u."""
    eps, cutout, tip, mu, psi = 0.08, 0.2, 0.97, 0.9, 4.0
    u = mu * np.sin(psi)
    assert cutout < -u < tip
    common = {"gamma": 7.0, "eps": eps, "mu": mu, "K1": 0.3, "tip_loss": tip, "root_cutout": cutout}
    blade = Blade(**common, flap_damping=0.25, reversed_flow=reversed_flow)
    x = Polynomial([0, 1])
    sign = -1 if reversed_flow else 1

    def along(integrand: Polynomial) -> float:
        primitive = integrand.integ()
        return float(primitive(tip) - primitive(-u) + sign * (primitive(-u) - primitive(cutout)))

    damping = 3.5 * along((x + u) * (x - eps) ** 2) + 0.25
    spring = 3.5 * (mu * np.cos(psi) * along((x + u) * (x - eps)) + 0.3 * along((x + u) ** 2 * (x - eps)))
    inflow = 3.5 * along((x + u) * (x - eps))
    assert_allclose(blade_element.damping(blade, psi), damping, atol=QUADRATURE)
    assert_allclose(blade_element.stiffness(blade, psi), 1 + spring, atol=QUADRATURE)
    assert_allclose(blade_element.forcing(blade, psi)[4], inflow, atol=QUADRATURE)
    hinged = Blade(**common | {"root_cutout": 0.01})  # inside the hinge: the integral starts at ε
    assert blade_element.damping(hinged, 1.0) == blade_element.damping(Blade(**common | {"root_cutout": 0.0}), 1.0)


# ------------------------------------------------------------------------------------------------ multiblade tables
def multiblade(
    blades: int, psi: float, d: Callable[[float], float], k: Callable[[float], float], f: Callable[[float], Any]
) -> tuple[NDArray[np.float64], ...]:
    """D, K, F from the blades' own equations: move one coordinate at a time, read B'' from the definitions' sums."""
    psis = psi + 2 * np.pi * np.arange(blades) / blades
    harmonics = range(1, (blades + 1) // 2)

    def basis(order: int) -> NDArray[np.float64]:
        """β_i due to each coordinate, or its derivative of that order."""
        shift = order * np.pi / 2
        waves = [n**order * wave(n * psis + shift) for n in harmonics for wave in (np.cos, np.sin)]
        last = [(-1.0) ** np.arange(1, blades + 1) * (order == 0)] if blades % 2 == 0 else []
        return np.array([np.ones(blades) * (order == 0), *waves, *last]).T

    def coordinates(beta: NDArray[np.float64]) -> NDArray[np.float64]:
        """Eq. (3): means, and twice the means with cos nψ and sin nψ."""
        weights = [2 * wave(n * psis) for n in harmonics for wave in (np.cos, np.sin)]
        last = [(-1.0) ** np.arange(1, blades + 1)] if blades % 2 == 0 else []
        result: NDArray[np.float64] = np.array([np.ones(blades), *weights, *last]) @ beta / blades
        return result

    dd, kk = (np.array([g(p) for p in psis])[:, None] for g in (d, k))
    T, T1, T2 = basis(0), basis(1), basis(2)
    return coordinates(2 * T1 + dd * T), coordinates(T2 + dd * T1 + kk * T), coordinates(np.array([f(p) for p in psis]))


@pytest.mark.parametrize(("blades", "table"), [(3, closed_forms.table_1), (4, closed_forms.table_2)])
def test_tables_1_and_2_are_the_blades_in_multiblade_coordinates(blades: int, table: Callable[..., Any]) -> None:
    for values, psi in zip(random_blades(5), azimuths(5), strict=True):
        c = closed_forms.truncated(**values)
        f = closed_forms.forcing(values["gamma"], values["eps"], values["mu"], values["m"])
        expected = multiblade(
            blades, psi,
            lambda p, c=c: closed_forms.blade_damping(c, p),
            lambda p, c=c: closed_forms.blade_stiffness(c, p),
            lambda p, f=f: closed_forms.blade_forcing(f, p),
        )  # fmt: skip
        for given, wanted in zip(table(c, f, psi), expected, strict=True):
            assert_allclose(given, wanted, atol=ROUNDING * values["gamma"])


def test_table_2_is_four_blades_by_quadrature() -> None:
    values, psi = random_blades(1)[0], 0.6
    blade = Blade(**values)
    given = closed_forms.table_2(
        closed_forms.exact(**values),
        closed_forms.forcing(values["gamma"], values["eps"], values["mu"], values["m"], exact_offset=True),
        psi,
    )
    functions = (blade_element.damping, blade_element.stiffness, blade_element.forcing)
    expected = multiblade(4, psi, *((lambda p, g=g: g(blade, p)) for g in functions))
    for table, wanted in zip(given, expected, strict=True):
        assert_allclose(table, wanted, atol=10 * QUADRATURE)  # sums of four quadratures


# ------------------------------------------------------------------------------------------------ tip-path plane
def harmonic_balance(
    c: closed_forms.Coefficients, f: closed_forms.Forcing, coning: bool
) -> tuple[NDArray[np.float64], ...]:
    """D, K, F of (a₀, a₁, b₁) or (a₁, b₁): put (5) into the blade's equation, keep its mean and first harmonics."""
    psis = 2 * np.pi * np.arange(16) / 16
    one, zero = np.ones(16), np.zeros(16)
    shapes = [-np.cos(psis), -np.sin(psis)]
    rates, accelerations = [np.sin(psis), -np.cos(psis)], [np.cos(psis), np.sin(psis)]
    projections = [-2 * np.cos(psis), -2 * np.sin(psis)]
    if coning:
        shapes, rates, accelerations = [one, *shapes], [zero, *rates], [zero, *accelerations]
        projections = [one, *projections]
    d, k = (
        np.array([g(c, p) for p in psis])[:, None] for g in (closed_forms.blade_damping, closed_forms.blade_stiffness)
    )
    S, S1, S2 = (np.array(x).T for x in (shapes, rates, accelerations))
    project = np.array(projections) / 16
    forces = np.array([closed_forms.blade_forcing(f, p) for p in psis])
    return project @ (2 * S1 + d * S), project @ (S2 + d * S1 + k * S), project @ forces


@pytest.mark.parametrize("kinematic", [False, True])
def test_table_3_is_the_harmonic_balance_and_the_mean_of_tables_1_and_2(kinematic: bool) -> None:
    signs = np.array([1.0, -1.0, -1.0])
    psis = 2 * np.pi * np.arange(16) / 16
    for values in random_blades(4):
        loads = values["gamma"], values["eps"], values["mu"], values["m"], 1.6
        c, f = closed_forms.truncated(**values), closed_forms.forcing(*loads, kinematic_rates=kinematic)
        given = (*closed_forms.table_3(c), closed_forms.table_3_forcing(*loads, kinematic_rates=kinematic))
        for table, wanted in zip(given, harmonic_balance(c, f, coning=True), strict=True):
            assert_allclose(table, wanted, atol=ROUNDING * values["gamma"])
        for multiblade_table in (closed_forms.table_1, closed_forms.table_2):
            means = [np.mean(x, axis=0) for x in zip(*(multiblade_table(c, f, p) for p in psis), strict=True)]
            for i, (table, mean) in enumerate(zip(given, means, strict=True)):
                flipped = signs[:, None] * mean[:3, :3] * signs if i < 2 else signs[:, None] * mean[:3]
                assert_allclose(table, flipped, atol=ROUNDING * values["gamma"])


def test_equation_7_is_the_harmonic_balance_of_equation_2_and_the_lower_block_of_table_3() -> None:
    for values in random_blades(4):
        gamma, kappa, K1, mu = (values[name] for name in ("gamma", "kappa", "K1", "mu"))
        given = closed_forms.teetering_tip_path_plane(gamma, kappa, K1, mu)
        c, f = closed_forms.teetering(gamma, kappa, K1, mu), closed_forms.teetering_forcing(gamma, mu)
        D, K = closed_forms.table_3(closed_forms.truncated(gamma, 0.0, kappa, K1, mu))
        lower = D[1:, 1:], K[1:, 1:], closed_forms.table_3_forcing(gamma, 0.0, mu)[1:]
        for table, wanted, block in zip(given, harmonic_balance(c, f, coning=False), lower, strict=True):
            assert_allclose(table, wanted, atol=ROUNDING * gamma)
            assert_allclose(table, block, atol=ROUNDING * gamma)
        # built-in coning bends eq. (1) with a constant angle: minus the a₀ column of table 3's stiffness
        assert_allclose(closed_forms.precone_forcing(gamma, K1, mu), -K[1:, 0], atol=ROUNDING * gamma)


def test_equation_2_is_half_the_difference_of_two_opposite_blades() -> None:
    for values, psi in zip(random_blades(4), azimuths(4), strict=True):
        gamma, kappa, K1, mu = (values[name] for name in ("gamma", "kappa", "K1", "mu"))
        blade = Blade(gamma=gamma, kappa=kappa, K1=K1, mu=mu)
        c, f = closed_forms.teetering(gamma, kappa, K1, mu), closed_forms.teetering_forcing(gamma, mu)
        for quadrature, polynomial, sign in (
            (blade_element.damping, closed_forms.blade_damping(c, psi), 1),
            (blade_element.stiffness, closed_forms.blade_stiffness(c, psi), 1),
            (blade_element.forcing, closed_forms.blade_forcing(f, psi), -1),
        ):
            half = (quadrature(blade, psi) + sign * quadrature(blade, psi + np.pi)) / 2
            assert_allclose(polynomial, half, atol=QUADRATURE)


@pytest.mark.parametrize("gamma", [2.0, 6.0, 12.0, 17.0, 22.0])
@pytest.mark.parametrize(("eps", "kappa", "K1"), [(0.0, 0.0, 0.0), (0.15, 0.0, 0.0), (0.05, 0.2, 0.3)])
def test_hover_formulas_are_the_roots_of_table_3(gamma: float, eps: float, kappa: float, K1: float) -> None:
    D, K = closed_forms.table_3(closed_forms.truncated(gamma, eps, kappa, K1, 0.0))
    given = closed_forms.hover(gamma, eps, kappa, K1)
    coning = np.roots([1, D[0, 0], K[0, 0]])
    d, k = ([Polynomial([K[i, j], D[i, j], float(i == j)]) for j in (1, 2)] for i in (1, 2))
    cyclic = (d[0] * k[1] - d[1] * k[0]).roots()
    assert_sets(given["coning"], coning)
    assert_sets(given["cyclic"], cyclic)
    if not given["zeta"] > 1:
        advancing, regressing = np.abs(given["cyclic"][[0, 2]])  # type: ignore[index]
        assert_allclose([given["omega_A"], given["omega_R"]], [advancing, regressing], atol=1e-12)


def test_both_branches_of_the_hover_formulas_are_tested() -> None:
    assert closed_forms.hover(12.0)["zeta"] < 1 < closed_forms.hover(17.0)["zeta"]


def assert_sets(given: Any, wanted: NDArray[np.complex128]) -> None:
    """Equal as sets, to rounding of well-separated roots."""
    left = list(np.asarray(wanted, dtype=complex))
    for z in np.asarray(given, dtype=complex):
        left.remove(nearest := min(left, key=lambda w, z=z: abs(w - z)))
        assert abs(nearest - z) < 1e-11
    assert not left


# ------------------------------------------------------------------------------------------------ exponents
def oracle_pieces(case: dict[str, Any]) -> list[taylor.Piece]:
    p = case["params"]
    if case["kind"] == "mathieu":
        return problems.mathieu(p["a"], p["q"], p["damping"])
    if case["kind"] == "meissner":  # delta + e on half of the period 2π, delta − e on the other
        return problems.meissner(p["delta"], "-" + p["e"], p["damping"], mp.pi, 2 * mp.pi)
    spring = {"kappa": p.get("kbeta", "0"), "K1": p.get("K1", "0")}
    if case["kind"] == "teetering":
        return problems.teetering(p["gamma"], p["mu"], **spring)
    eps = mp.mpf(p.get("eps", "0"))
    m = 3 * eps / 2 / (1 - eps) if p.get("eMI") == "uniform_exact" else None
    return problems.flapping(p["gamma"], p["mu"], eps=eps, m=m, **spring)


def set_distance(given: Iterable[Any], wanted: Iterable[Any], period: Any) -> Any:
    """Largest distance of a minimum pairing by greed, imaginary parts modulo 2π/period."""
    turn, left, worst = 2 * mp.pi / period, list(wanted), mp.mpf(0)
    for z in given:
        distances = [abs(mp.mpc((d := z - w).real, d.imag - turn * mp.nint(d.imag / turn))) for w in left]
        worst = max(worst, min(distances))
        left.pop(distances.index(min(distances)))
    assert not left
    return worst


@pytest.mark.parametrize("number", [6, 14, 22, 28, 44, 54, 56, 74, 80])
def test_oracle_is_the_taylor_integrator(number: int) -> None:
    case = ORACLE[number]
    result = taylor.scalar_exponents(oracle_pieces(case))
    assert set_distance(result.exponents, [mp.mpc(*z) for z in case["exponents"]], result.period) < mp.mpf("1e-28")
    if case.get("rotation_number"):
        assert abs(result.rotation_number - mp.mpf(case["rotation_number"])) < mp.mpf("1e-22")
        assert result.locked == (case["locked"] is not None)


@pytest.mark.parametrize("number", [62, 66, 68])
def test_multiblade_oracle_is_the_blade_shifted_by_integers(number: int) -> None:
    case = ORACLE[number]
    result = taylor.scalar_exponents(oracle_pieces(case))
    shifted = [z + mp.mpc(0, k) for z in result.exponents for k in range(case["N"])]
    wanted = [mp.mpc(*z) for z in case["exponents"]]
    assert set_distance(shifted, wanted, 2 * mp.pi / case["N"]) < mp.mpf("1e-28")


def textbook_exponents(case: dict[str, Any]) -> tuple[list[Any], Any, taylor.Exponents | None]:
    """Exponents, period, and the whole result of a scalar problem."""
    p, period = case.get("parameters", {}), PERIODS[case["period"]] * mp.pi
    scalar: dict[str, Callable[[], list[taylor.Piece]]] = {
        "mathieu": lambda: problems.mathieu(**p),
        "meissner": lambda: problems.meissner(**p, switch=mp.pi / 3, period=mp.pi),
        "hill_sawtooth": lambda: problems.hill_sawtooth(**p),
        "flapping": lambda: problems.flapping(**p),
    }
    if case["problem"] in scalar:
        result = taylor.scalar_exponents(scalar[case["problem"]]())
        assert result.period == period
        return list(result.exponents), period, result
    if case["problem"] == "rotating_frame":
        A, order, steps = problems.rotating_frame(**p), 30, 20  # four states: 1e-22 is enough and fast
    else:
        A, order, steps = getattr(problems, case["problem"]), 60, 36
    return taylor.matrix_exponents(A, period, order=order, steps=steps), period, None


@pytest.mark.parametrize("case", TEXTBOOK["cases"], ids=lambda case: f"{case['problem']}-{case['exponents'][0][0][:7]}")
def test_textbook_values(case: dict[str, Any]) -> None:
    digits = {"colaneri": 100, "rotating_frame": 30}.get(case["problem"], taylor.DIGITS)  # multipliers 1 and 1e-66
    with mp.workdps(digits):
        given, period, result = textbook_exponents(case)
        tolerance = mp.mpf("1e-20") if case["status"] == "exact" else mp.mpf("1e-28")
        assert set_distance(given, [mp.mpc(*z) for z in case["exponents"]], period) < tolerance
        assert (result is not None) == ("rotation_number" in case)
        if result is not None:
            assert abs(result.rotation_number - mp.mpf(case["rotation_number"])) < tolerance


@pytest.mark.parametrize("entry", TEXTBOOK["mathieu_boundaries"]["values"], ids=lambda e: f"{e['name']}({e['q']})")
def test_mathieu_boundaries_are_roots_of_the_discriminant(entry: dict[str, str]) -> None:
    """a_n: Φ₂₁ = 0, the even solution is periodic; b_n: Φ₁₂ = 0. A Newton step must not move 28 digits of it."""
    order, place = int(entry["name"][1:]), {"a": 2, "b": 1}[entry["name"][0]]
    value, step = mp.mpf(entry["value"]), mp.mpf("1e-20")
    here, there = (taylor.scalar_exponents(problems.mathieu(a, entry["q"])) for a in (value, value + step))
    slope = (there.monodromy[place] - here.monodromy[place]) / step
    assert abs(here.monodromy[place] / slope) < abs(value) * mp.mpf("1e-28")
    assert abs(here.half_trace - (-1) ** order) < 1e-20  # slopes up to 4e6 times 1e-28
    assert abs(here.rotation_number - order) < 1e-10  # goes as the square root


@pytest.mark.parametrize("key", ["single:fig6:12", "single:fig7:8", "single:fig9:16", "teeter:fig6:6"])
def test_transitions_change_the_sign_of_the_discriminant(key: str) -> None:
    model, family, gamma = key.split(":")
    options = {"fig6": {}, "fig7": {"eps": "0.15"}, "fig8": {"kappa": "0.225"}, "fig9": {"K1": "0.225"}}[family]
    make = problems.flapping if model == "single" else problems.teetering

    def solve(mu: float) -> taylor.Exponents:
        with mp.workdps(25):
            return taylor.scalar_exponents(make(gamma, mu, **options), order=26)

    for edge in TRANSITIONS[key]["edges"]:
        below, above = (solve(edge["mu"] + step) for step in (-1e-9, 1e-9))
        inside, outside = (above, below) if edge["type"] == "enter" else (below, above)
        assert inside.locked and not outside.locked
        assert abs(inside.rotation_number - edge["rho"]) < 1e-12
    stable, growing = (solve(TRANSITIONS[key]["instability_mu"] + step) for step in (-1e-9, 1e-9))
    assert stable.exponents[0].real < 0 < growing.exponents[0].real


# ------------------------------------------------------------------------------------------------ exponents.json
def reference_arguments(parameters: dict[str, float]) -> dict[str, float]:
    letters = {
        "lock_number": "gamma", "hinge_offset": "eps", "hinge_stiffness": "kappa", "pitch_flap_coupling": "K1",
        "offset_mass_ratio": "m", "flap_damping": "flap_damping", "advance_ratio": "mu",
    }  # fmt: skip
    return {letters[name]: value for name, value in parameters.items()}


@pytest.mark.parametrize("name", [f"{s}-{i}" for s in ("random", "near_branch", "reversed_flow") for i in (9, 14)])
def test_stored_exponents_can_be_recomputed(name: str) -> None:
    case = next(case for case in EXPONENTS if case["id"] == name)
    pieces = problems.flapping(**reference_arguments(case["parameters"]), **case["options"])
    result = taylor.scalar_exponents(pieces, order=52)
    for given, wanted in zip(result.exponents, case["exponents"], strict=True):
        assert abs(given - mp.mpc(*wanted)) < mp.mpf("1e-25")
    assert abs(result.rotation_number - mp.mpf(case["rotation_number"])) < mp.mpf("1e-25")
    assert result.locked == (case["lock"] is not None)


def test_every_stored_pair_has_the_sum_liouville_asks_for() -> None:
    """Σσ = −c0 − flap damping; with reversed flow, ε = 0 and μ ≤ 1, −c0 (1 + μ⁴/8) − flap damping."""
    tested = {False: 0, True: 0}
    for case in EXPONENTS:
        if case["set"] == "dissimilar":
            continue
        values = {k: mp.mpf(v) for k, v in reference_arguments(case["parameters"]).items()}
        damping, mu = values.pop("flap_damping"), values["mu"]
        c = (closed_forms.exact if case["options"]["exact_offset"] else closed_forms.truncated)(**values)
        mean = c["c0"]
        if case["options"]["reversed_flow"]:
            if values["eps"] > 0 or mu > 1:
                continue
            mean *= 1 + mu**4 / 8
        total = sum(mp.mpf(re) for re, _ in case["exponents"])
        assert abs(total + mean + damping) < mp.mpf("1e-27"), case["id"]
        tested[case["options"]["reversed_flow"]] += 1
    assert tested[False] == 180 and tested[True] > 0


def test_stored_cases_cover_what_they_claim() -> None:
    sets = {name: [case for case in EXPONENTS if case["set"] == name] for name in {c["set"] for c in EXPONENTS}}
    assert {name: len(cases) for name, cases in sets.items()} == {
        "random": 150, "near_branch": 30, "reversed_flow": 20, "dissimilar": 4,
    }  # fmt: skip
    locks = {case["lock"] for case in sets["random"]}
    assert locks >= {None, 0.0, 0.5, 1.0}
    for case in sets["near_branch"]:  # the discriminant has a simple root there
        assert abs(mp.mpf(case["discriminant"])) < 1000 * abs(case["distance"])
    assert 5 < sum(case["lock"] is None for case in sets["near_branch"]) < 25
    for case in sets["dissimilar"]:
        assert len(case["exponents"]) == 2 * len(case["blades"]) == 6
        assert len({tuple(blade.items()) for blade in case["blades"]}) > 1
