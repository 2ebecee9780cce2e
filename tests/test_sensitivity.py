"""Rates of exponents: against differences in forty digits, closed forms, and what must be equal."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from numpy.typing import NDArray

from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.models import flapping, multiblade, tip_path_plane
from floquet.models.textbook import mathieu, rotating_frame
from floquet.periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor
from floquet.sensitivity import Sensitivities, of_system, plane_sensitivities, sensitivities
from floquet.validity import lock_windows
from tests.truth import problems, taylor

STEP = "1e-16"  # of the differences: its square is far below the digits compared
NAMES = {"lock_number": "gamma", "advance_ratio": "mu", "hinge_offset": "eps", "hinge_stiffness": "kappa",
         "pitch_flap_coupling": "K1", "offset_mass_ratio": "m", "flap_damping": "flap_damping"}  # fmt: skip


def differences(problem: Callable[..., Any], values: dict[str, float], move: str) -> tuple[NDArray[Any], float, float]:
    """dη, dτ and dD with ``move``, from exponents in forty digits at two places."""
    with mp.workdps(40):
        ends = []
        for sign in (1, -1):
            v = {name: mp.mpf(x) for name, x in values.items()}
            v[move] += sign * mp.mpf(STEP)
            ends.append(taylor.scalar_exponents(problem(**v)))
        a, b, width = *ends, 2 * mp.mpf(STEP)
        eta = [complex((x - y) / width) for x, y in zip(a.exponents, b.exponents, strict=True)]
        return (
            np.array(eta),
            float((a.half_trace - b.half_trace) / width),
            float((a.discriminant - b.discriminant) / width),
        )


BLADES: dict[str, dict[str, float]] = {
    "plain": {"gamma": 8.0, "mu": 0.3, "eps": 0.05, "kappa": 0.1, "K1": 0.2, "m": 0.09, "flap_damping": 0.1},
    "half-per-rev lock": {"gamma": 12.0, "mu": 0.5, "eps": 0.0, "kappa": 0.0, "K1": 0.0, "m": 0.0, "flap_damping": 0.0},
    "strong growth": {"gamma": 18.0, "mu": 1.4, "eps": 0.1, "kappa": 0.0, "K1": -0.3, "m": 0.1, "flap_damping": 0.0},
}


def of_blade(v: dict[str, float], **options: Any) -> Sensitivities:
    letters = {letter: name for name, letter in NAMES.items() if letter != "mu"}
    return sensitivities(Rotor(**{letters[a]: x for a, x in v.items() if a != "mu"}), v["mu"], **options)


@pytest.mark.parametrize("name", BLADES)
@pytest.mark.parametrize("option", [None, "exact_offset"])
def test_rates_are_differences_in_forty_digits(name: str, option: str | None) -> None:
    options = {option: True} if option else {}
    v = BLADES[name]
    found = of_blade(v, **options)
    for parameter, letter in NAMES.items():
        eta, tau, D = differences(lambda **x: problems.flapping(**x, **options), v, letter)
        i = found.parameters.index(parameter)
        assert np.all(np.abs(found[parameter] - eta) <= found.errors[i])
        assert np.all(found.errors[i] <= 1e-11 * np.abs(eta).max()) and found.trusted[i].all()
        assert found.half_trace_rates is not None and found.discriminant_rates is not None
        assert found.half_trace_rates[i] == pytest.approx(tau, rel=1e-12)
        assert found.discriminant_rates[i] == pytest.approx(D, rel=1e-12)


def test_reversed_flow_moves_its_edges() -> None:
    """The pieces' edges move with μ; as values and slopes agree there, that adds nothing."""
    v = {"gamma": 8.0, "mu": 0.8, "eps": 0.05, "K1": 0.2, "kappa": 0.1, "flap_damping": 0.0}
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05, pitch_flap_coupling=0.2, hinge_stiffness=0.1)
    found = sensitivities(rotor, 0.8, reversed_flow=True, exact_offset=True)
    for parameter in ("lock_number", "hinge_offset", "pitch_flap_coupling", "advance_ratio"):
        eta, *_ = differences(lambda **x: problems.flapping(**x, reversed_flow=True), v, NAMES[parameter])
        np.testing.assert_allclose(found[parameter], eta, rtol=1e-11)


def test_teetering_rotor() -> None:
    rotor = Rotor(lock_number=9.0, hinge_stiffness=0.1, pitch_flap_coupling=0.3, blades=2, hub=Hub.TEETERING)
    found = sensitivities(rotor, 0.6)
    assert "hinge_offset" not in found.parameters and found.stability.period == math.pi
    values = {"gamma": 9.0, "mu": 0.6, "kappa": 0.1, "K1": 0.3}
    for parameter in ("lock_number", "advance_ratio", "hinge_stiffness", "pitch_flap_coupling"):
        eta, *_ = differences(problems.teetering, values, NAMES[parameter])
        np.testing.assert_allclose(found[parameter], eta, rtol=1e-13)


def test_root_cutout_and_tip_loss_are_differences() -> None:
    """No independent equation has them: differences of the exponents, right to eight digits."""
    rotor, h = Rotor(lock_number=8.0, hinge_offset=0.05, root_cutout=0.2), 1e-4

    def eta(cutout: float, tip: float) -> NDArray[Any]:
        return np.asarray(stability(flapping(rotor.replace(root_cutout=cutout), 0.4, tip_loss=tip)).exponents)

    found = sensitivities(rotor, 0.4, tip_loss=0.97)
    for name, at in (("root_cutout", lambda x: eta(0.2 + x, 0.97)), ("tip_loss", lambda x: eta(0.2, 0.97 + x))):
        fourth = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
        np.testing.assert_allclose(found[name], fourth, rtol=1e-8)


# ---------------------------------------------------------------------- closed forms and structure
def test_hover_is_the_closed_form() -> None:
    """η = -c₀/2 ± i √(P² - c₀²/4)."""
    gamma, eps, kappa, K1 = np.array([4.0, 8.0, 11.0]), 0.06, 0.15, 0.2
    rotor = Rotor(lock_number=gamma, hinge_offset=eps, hinge_stiffness=kappa, pitch_flap_coupling=K1)
    found = sensitivities(rotor, 0.0)
    c0, P2 = gamma / 8 * (1 - 8 * eps / 3 + 2 * eps**2), 1 + kappa + 1.5 * eps + gamma * K1 / 8 * (1 - 4 * eps / 3)
    omega = np.sqrt(P2 - c0**2 / 4)
    moved = {  # (dc₀, dP²)
        "lock_number": (c0 / gamma, K1 / 8 * (1 - 4 * eps / 3)),
        "hinge_offset": (gamma / 8 * (4 * eps - 8 / 3), 1.5 - gamma * K1 / 6),
        "hinge_stiffness": (0.0, 1.0),
        "pitch_flap_coupling": (0.0, gamma / 8 * (1 - 4 * eps / 3)),
        "flap_damping": (1.0, 0.0),
        "advance_ratio": (0.0, 0.0),
    }
    for name, (dc, dP) in moved.items():
        expected = -0.5 * dc + 1j * (dP - 0.5 * c0 * dc) / (2.0 * omega)
        np.testing.assert_allclose(
            found[name], np.stack([expected, np.conj(expected)], axis=-1), rtol=1e-12, atol=1e-14
        )


def test_teetering_in_hover_is_the_blade_and_K1_its_spring() -> None:
    rotor = Rotor(lock_number=9.0, pitch_flap_coupling=0.3, blades=2, hub=Hub.TEETERING)
    teeters, alone = sensitivities(rotor, 0.0), sensitivities(rotor, 0.0, model="flapping")
    for name in ("lock_number", "hinge_stiffness", "pitch_flap_coupling", "flap_damping"):
        np.testing.assert_allclose(teeters[name], alone[name], rtol=1e-13)
    np.testing.assert_allclose(teeters["pitch_flap_coupling"], 9.0 / 8.0 * teeters["hinge_stiffness"], rtol=1e-13)


def test_offset_mass_follows_or_is_held() -> None:
    following = sensitivities(Rotor(lock_number=8.0, hinge_offset=0.1, static_moment_ratio=1.4), 0.35)
    held = sensitivities(
        Rotor(lock_number=8.0, hinge_offset=0.1, offset_mass_ratio=0.14, static_moment_ratio=1.4), 0.35
    )
    mass = held["offset_mass_ratio"]
    np.testing.assert_array_equal(mass, held["hinge_stiffness"])  # both enter 1 + κ + m
    np.testing.assert_allclose(following["hinge_offset"], held["hinge_offset"] + 1.4 * mass, rtol=1e-13)
    np.testing.assert_allclose(following["static_moment_ratio"], 0.1 * mass, rtol=1e-13)
    np.testing.assert_array_equal(held["static_moment_ratio"], 0.0)
    np.testing.assert_allclose(mass, following["offset_mass_ratio"], rtol=1e-13)


@pytest.mark.parametrize("given", [{}, {"offset_mass_ratio": 0.14}], ids=["total", "partial"])
def test_rates_with_the_offset_are_those_of_rotors_made_with_it(given: dict[str, float]) -> None:
    """Differences of rotors as their constructor resolves m: total where it follows, partial where it is held."""
    rates = sensitivities(Rotor(lock_number=8.0, hinge_offset=0.1, static_moment_ratio=1.4, **given), 0.35)
    for name, value, h in (("hinge_offset", 0.1, 1e-5), ("static_moment_ratio", 1.4, 1e-4)):
        own = {"lock_number": 8.0, "hinge_offset": 0.1, "static_moment_ratio": 1.4, **given}
        ends = [stability(flapping(Rotor(**own | {name: value + s * h}), 0.35)).exponents for s in (1, -1)]
        np.testing.assert_allclose((ends[0] - ends[1]) / (2.0 * h), rates[name], rtol=1e-7, atol=1e-9)


def test_an_unknown_parameter_is_one_short_sentence() -> None:
    """One blade's are listed; the 37 of four blades are counted, and what was meant is named."""
    rotor = Rotor(lock_number=8.0, blades=4)
    one = sensitivities(rotor, 0.3)
    with pytest.raises(ParameterError, match=r"did you mean 'lock_number'.*the parameters are lock_number, "):
        one["lock_numbr"]
    four = sensitivities([rotor, rotor, rotor, rotor.replace(lock_number=7.0)], 0.3)
    for name, meant in (("lock_number", "'lock_number 0' to 'lock_number 3'"), ("hinge_ofset 2", "'hinge_offset 2'")):
        with pytest.raises(ParameterError, match=f"{meant}.*37 parameters.*field parameters lists") as caught:
            four[name]
        assert len(str(caught.value)) < 240


def test_a_direction_of_several_parameters_is_their_sum() -> None:
    system = flapping(Rotor(lock_number=8.0, hinge_offset=0.05), 0.4)
    single = of_system(system)
    both = of_system(system, {"both": {"lock_number": 2.0, "advance_ratio": -0.5}})
    np.testing.assert_allclose(both["both"], 2.0 * single["lock_number"] - 0.5 * single["advance_ratio"], rtol=1e-13)


def test_cutout_inside_the_hinge_does_nothing() -> None:
    for offset in (0.0, 0.05):
        found = sensitivities(Rotor(lock_number=8.0, hinge_offset=offset, root_cutout=offset), 0.3, exact_offset=True)
        np.testing.assert_array_equal(found["root_cutout"], 0.0)


# ---------------------------------------------------------------------- several states
@pytest.mark.parametrize("blades", [3, 4])
def test_identical_blades_have_the_rates_of_one(blades: int) -> None:
    """All coordinates, by left and right modes, give what the half trace of one blade gives."""
    rotor = Rotor(lock_number=6.0, hinge_offset=0.06, hinge_stiffness=0.1, pitch_flap_coupling=0.2, blades=blades)
    one, whole = of_system(flapping(rotor, 0.3)), of_system(multiblade(rotor, 0.3), symmetry=False)
    assert whole.trusted.all() and whole.rates.shape == (10, 2 * blades)
    for name in one.parameters:
        up = np.where(np.isclose(whole[f"{name} 0"].imag, one[name][0].imag, atol=1e-11), one[name][0], one[name][1])
        row = whole.parameters.index(f"{name} 0")
        assert np.all(np.abs(whole[f"{name} 0"] - up) <= whole.errors[row] + one.errors[row].max())
        assert whole.errors[row].max() < 1e-11
    np.testing.assert_array_equal(sensitivities(rotor, 0.3)["lock_number"], one["lock_number"])


def test_blades_one_by_one_move_alone() -> None:
    """Dissimilar blades do not couple: the rate of an exponent with another blade's parameter is zero."""
    rotors = [Rotor(lock_number=g, hinge_offset=0.05, hinge_stiffness=0.2) for g in (5.0, 6.0, 7.5)]
    found = sensitivities(rotors, 0.3)
    eta = np.asarray(found.stability.exponents)
    for i, rotor in enumerate(rotors):
        one = sensitivities(rotor, 0.3)
        targets = np.asarray(one.stability.exponents)
        mine = np.abs(eta.real - targets[0].real) < 1e-9
        assert mine.sum() == 2
        np.testing.assert_allclose(found[f"lock_number {i}"][~mine], 0.0, atol=1e-13)
        for name, own in ((f"hinge_offset {i}", "hinge_offset"), ("advance_ratio", "advance_ratio")):
            expected = one[own]
            got = found[name][mine]
            assert min(np.abs(got - expected).max(), np.abs(got - expected[::-1]).max()) < 1e-12


def test_rates_given_as_systems() -> None:
    """Truth built backwards: Φ = e^{2πF} exactly, so dη = w* F_p v of the constant F."""
    rng = np.random.default_rng(5)
    F, F_p = 0.3 * rng.standard_normal((4, 4)), rng.standard_normal((4, 4))
    base = rotating_frame(F)
    turned, still = rotating_frame(F_p).function, rotating_frame(np.zeros((4, 4))).function
    assert turned is not None and still is not None
    rate = PeriodicSystem(period=TWO_PI, function=lambda t: turned(t) - still(t))
    found = of_system(base, rates={"p": rate})
    values, V = np.linalg.eig(F.astype(complex))
    expected = np.diagonal(np.linalg.inv(V) @ F_p @ V)
    eta = np.asarray(found.stability.exponents)
    order = [int(np.argmin(np.abs(np.exp(TWO_PI * values) - np.exp(TWO_PI * e)))) for e in eta]
    assert np.abs(found["p"] - expected[order]).max() < 1e-12
    assert np.all(np.abs(found["p"] - expected[order]) <= found.errors[0])


def test_matrices_and_equation_agree() -> None:
    model = mathieu(2.5, 0.6, 0.1)
    damping, stiffness = model.damping, model.stiffness
    plain = PeriodicSystem(period=math.pi, damping=damping, stiffness=stiffness)
    one, zero = PeriodicMatrix.scalar(mean=1.0, period=math.pi), PeriodicMatrix.scalar(period=math.pi)
    rates = {
        "a": PeriodicSystem(period=math.pi, stiffness=one),
        "damping": PeriodicSystem(period=math.pi, damping=one, stiffness=zero),
    }
    given, model_rates = of_system(plain, rates=rates), of_system(model)
    for name in rates:
        np.testing.assert_allclose(given[name], model_rates[name], rtol=1e-14)


def test_constant_systems() -> None:
    """Eigenvalues of the tip-path plane along K_p: the derivative of its characteristic roots."""
    plane = tip_path_plane(Rotor(lock_number=8.0, hinge_offset=0.05), 0.3)
    assert plane.damping is not None and plane.stiffness is not None
    K_p = PeriodicMatrix.constant(np.diag([1.0, 0.5, -0.3]))
    found = of_system(plane, rates={"p": PeriodicSystem(period=math.nan, stiffness=K_p)})
    h = 1e-4
    ends = [stability(replace(plane, stiffness=plane.stiffness + s * K_p)).exponents for s in (h, -h, 2 * h, -2 * h)]
    fourth = (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12.0 * h)
    np.testing.assert_allclose(found["p"], fourth, atol=1e-10)
    assert found.trusted.all()


@pytest.mark.parametrize("options", [{}, {"reversed_flow": True, "tip_loss": 0.97}])
def test_rates_of_the_tip_path_plane(options: Any) -> None:
    """Against differences of its eigenvalues, for two μ at once; a teetering rotor too."""
    bell = Rotor(lock_number=6.0, pitch_flap_coupling=0.1, hinge_stiffness=0.1, blades=2, hub=Hub.TEETERING)
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05, pitch_flap_coupling=0.1, hinge_stiffness=0.3)
    mu, h = np.array([0.2, 0.6]), 1e-4  # far from splits, where differences lose their digits
    for one in (rotor, bell):
        found = plane_sensitivities(one, mu, **options)
        moved = {
            "advance_ratio": lambda x, r=one: tip_path_plane(r, mu + x, **options),
            "lock_number": lambda x, r=one: tip_path_plane(r.replace(lock_number=r.lock_number + x), mu, **options),
        }
        if one is rotor:  # m follows
            moved["hinge_offset"] = lambda x: tip_path_plane(rotor.replace(hinge_offset=0.05 + x), mu, **options)
        for name, at in moved.items():
            a, b, c, d = (np.asarray(stability(at(s * h)).exponents) for s in (1, -1, 2, -2))
            fourth = (8.0 * (a - b) - (c - d)) / (12.0 * h)
            np.testing.assert_allclose(found[name], fourth, atol=2e-9)
        assert found.trusted.all()


# ---------------------------------------------------------------------- branch points
def test_next_to_a_branch_point_rates_grow_and_tau_does_not() -> None:
    """dη/dμ √|D| → |dD/dμ|/(2T) from both sides of γ = 12's lock; reach is the distance to its edge."""
    enter = lock_windows(Rotor(lock_number=12.0), mu_max=0.5)[0][0]
    away = np.array([-1e-3, -1e-5, 1e-5, 1e-3])
    found = sensitivities(Rotor(lock_number=12.0), enter + away)
    i = found.parameters.index("advance_ratio")
    assert found.reach is not None and found.discriminant_rates is not None
    np.testing.assert_allclose(found.reach[i], np.abs(away), rtol=5e-3)
    slope = found.discriminant_rates[i]
    np.testing.assert_allclose(slope, slope[1], rtol=1e-2)
    growth = np.abs(found["advance_ratio"][:, 0]) * np.sqrt(np.abs(found.discriminant))
    np.testing.assert_allclose(growth, np.abs(slope[1]) / (4.0 * math.pi), rtol=1e-2)
    assert np.all((found["advance_ratio"][:, 0].real < 1e-12) == (away < 0))  # a pair only turns


def test_rates_keep_their_digits_up_to_the_edge() -> None:
    """Next to it D comes from forty digits: what grows like 1/√D stays right to 1e-9 of itself, and to its error."""
    enter = lock_windows(Rotor(lock_number=12.0), mu_max=0.5)[0][0]
    mu = enter + np.array([1e-4, 1e-6, 1e-8, 1e-10])
    found = sensitivities(Rotor(lock_number=12.0), mu)
    i = found.parameters.index("lock_number")
    assert found.trusted[i].all() and np.all(found.errors[i] < 1e-8 * np.abs(found["lock_number"]))
    values = {"gamma": 12.0, "eps": 0.0, "kappa": 0.0, "K1": 0.0, "m": 0.0, "flap_damping": 0.0}
    for k, m in enumerate(mu):
        eta, *_ = differences(problems.flapping, values | {"mu": float(m)}, "gamma")
        off = np.abs(found["lock_number"][k] - eta)
        assert np.all(off <= found.errors[i, k])
        assert np.all(off < 1e-9 * np.abs(eta))


def test_on_a_branch_point_there_is_no_rate() -> None:
    """y'' + y = 0 over π: D is zero, τ is not moved, and both exponents are -i or i."""
    found = of_system(mathieu(1.0, 0.0))
    i = found.parameters.index("a")
    assert found.discriminant == 0.0 and not found.trusted[i].any() and not np.isfinite(found["a"]).any()
    assert found.half_trace_rates is not None and abs(found.half_trace_rates[i]) < 1e-15


def test_edges_of_locks_move_by_the_rates_of_D() -> None:
    """dμ_edge/dγ = -(dD/dγ)/(dD/dμ)."""
    edges = [lock_windows(Rotor(lock_number=g), mu_max=0.5)[0][0] for g in (11.999, 12.0, 12.001)]
    found = sensitivities(Rotor(lock_number=12.0), edges[1])
    rates = found.discriminant_rates
    assert rates is not None
    moved = -rates[found.parameters.index("lock_number")] / rates[found.parameters.index("advance_ratio")]
    assert moved == pytest.approx((edges[2] - edges[0]) / 0.002, rel=1e-6)


def test_coupled_modes_that_meet_are_not_trusted() -> None:
    enter = lock_windows(Rotor(lock_number=12.0), mu_max=0.5)[0][0]
    system = multiblade(Rotor(lock_number=12.0, blades=3), np.array([0.15, enter * (1.0 + 1e-13)]))
    found = of_system(system, symmetry=False)
    i = found.parameters.index("hinge_stiffness 0")
    assert found.trusted[i, 0].all() and not found.trusted[i, 1].any()


# ---------------------------------------------------------------------- shapes and errors
def test_cases_are_each_alone() -> None:
    rotor = Rotor(lock_number=np.linspace(4.0, 12.0, 300)[:, None], hinge_offset=0.05)
    mu = np.array([0.1, 0.45])
    found = sensitivities(rotor, mu)
    assert found.rates.shape == (10, 300, 2, 2) and found.discriminant.shape == (300, 2)
    assert found.reach is not None and found.reach.shape == (10, 300, 2)
    for i, j in ((0, 0), (170, 1), (299, 0)):
        one = sensitivities(rotor[i, 0], float(mu[j]))
        np.testing.assert_allclose(one.rates, found.rates[:, i, j], rtol=1e-10, atol=1e-14)


def test_what_has_no_rates_is_refused() -> None:
    system = flapping(Rotor(lock_number=8.0), 0.3)
    with pytest.raises(ParameterError, match="did you mean 'lock_number'"):
        of_system(system)["lock_numbr"]
    with pytest.raises(ParameterError, match="did you mean 'advance_ratio'"):
        of_system(system, {"mu": {"advance_ratios": 1.0}})
    with pytest.raises(ParameterError, match="give rates="):
        of_system(PeriodicSystem(period=TWO_PI, stiffness=system.stiffness))


def test_rates_of_what_moves_a_jump_are_not_given() -> None:
    """Truncated integrals jump where reversed flow reaches the tip, which μ and B move; others' rates stay right."""
    rotor, options = Rotor(lock_number=16.0, hinge_offset=0.15), {"reversed_flow": True}
    for of in (sensitivities, plane_sensitivities):
        found = of(rotor, np.array([0.9, 1.2]), **options)  # type: ignore[arg-type]
        for name in ("advance_ratio", "tip_loss"):
            row = found.parameters.index(name)
            assert np.all(np.isfinite(found.rates[row, 0])) and np.all(found.trusted[row, 0])
            assert np.all(np.isnan(found.rates[row, 1].real)) and not np.any(found.trusted[row, 1])
            assert np.all(found.errors[row, 1] == math.inf)
        assert np.all(np.isfinite(found["lock_number"])) and np.all(np.isfinite(found["hinge_offset"]))
    step = 1e-5
    for physics in ({"exact_offset": True}, {}):
        mu = 1.2 if physics else 0.9
        ends = [flapping(rotor, mu + s, reversed_flow=True, **physics) for s in (-step, step)]  # type: ignore[arg-type]
        low, high = (stability(end).exponents for end in ends)
        rate = sensitivities(rotor, mu, reversed_flow=True, **physics)["advance_ratio"]  # type: ignore[arg-type]
        np.testing.assert_allclose(rate, (high - low) / (2.0 * step), rtol=1e-6)
    blades = sensitivities([rotor, rotor.replace(lock_number=8.0), rotor], 1.2, reversed_flow=True)
    assert np.all(np.isnan(blades["advance_ratio"].real)) and np.any(np.isfinite(blades["lock_number 0"]))
