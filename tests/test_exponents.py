"""Exponents against 30-digit oracles, closed forms and truth built backwards; bounds that hold and are not idle."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from floquet.comparison import compare
from floquet.errors import FailedError, ParameterError
from floquet.exponents import Reason, Verdict, exponents, stability
from floquet.kernels.hill import finished, weighed
from floquet.models import flapping, multiblade, teetering, tip_path_plane
from floquet.models.textbook import (
    bittanti_colaneri,
    colaneri,
    hill_sawtooth,
    mathieu,
    meissner,
    rotating_frame,
    zhou_hagiwara,
)
from floquet.period_map import Method, PeriodMap, period_map
from floquet.periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor
from floquet.validity import instability_onset, lock_windows
from tests.support import REFERENCE, distances, oracle, oracle_exponents, oracle_system
from tests.truth import extended

GOAL = 1e-12


# ---------------------------------------------------------------------- oracles
@pytest.mark.parametrize("case", oracle(), ids=lambda c: f"{c['kind']}-{c['id']}")
def test_oracle(case: dict[str, Any]) -> None:
    expected, strip = oracle_exponents(case)
    found = stability(oracle_system(case))
    error = distances(found.exponents, expected, strip)
    assert np.all(error <= found.exponent_errors)
    assert np.all(error <= GOAL)
    if (rho := case.get("rotation_number")) is not None:
        assert found.rotation_number == pytest.approx(float(rho), abs=GOAL)
        locked = case["type"].startswith("real") and "double root" not in str(case["locked"])
        assert (not math.isnan(found.lock)) == locked


@pytest.mark.parametrize(
    ("system", "expected", "strip", "goal"),
    [
        (mathieu(1.0, 0.1), [0.0499415701984130306 + 1j, -0.0499415701984130306 + 1j], 2.0, 1e-14),
        (mathieu(2.0, 1.0), [0.783423743452122748j, -0.783423743452122748j], 2.0, 1e-14),
        (mathieu(1.0, 0.1, 0.4), [-0.153489672625928869 + 1j, -0.246510327374071131 + 1j], 2.0, 1e-14),
        (
            meissner(1.0, -0.2, period=math.pi, fraction=1 / 3),
            [0.04137974466122074514 + 1j, -0.04137974466122074514 + 1j],
            2.0,
            1e-14,
        ),
        (
            meissner(1.0, -0.2, 0.4, period=math.pi, fraction=1 / 3),
            [-0.1479830793372450666 + 1j, -0.2520169206627549334 + 1j],
            2.0,
            1e-14,
        ),
        (hill_sawtooth(1.0, -0.2), [0.03181501124429217672 + 1j, -0.03181501124429217672 + 1j], 2.0, 1e-14),
        (hill_sawtooth(1.0, -0.2, 0.4), [-0.1747074564257013832 + 1j, -0.2252925435742986168 + 1j], 2.0, 1e-14),
        (colaneri(), [0.0, -24.0], 1.0, 1e-14),
        (zhou_hagiwara(), [-1.0, -2.0], 2.0, 1e-14),
        (zhou_hagiwara(math.pi / 2), [-1.0 + 2j, -2.0 + 2j], 4.0, 1e-14),
        (bittanti_colaneri(), [-1.0, -3.0], 1.0, 1e-14),
        (
            flapping(Rotor(lock_number=12.0), 1.0),
            [-0.75 + 0.242768241924562140j, -0.75 - 0.242768241924562140j],
            1.0,
            1e-14,
        ),
        (flapping(Rotor(lock_number=12.0), 2.0), [0.565398702951843120, -2.065398702951843119], 1.0, 1e-14),
        (
            flapping(Rotor(lock_number=8.0), 0.5),
            [-0.5 + 0.163937751138592147j, -0.5 - 0.163937751138592147j],
            1.0,
            1e-14,
        ),
    ],
    ids=lambda x: x.name if isinstance(x, PeriodicSystem) else "",
)
def test_problems_with_known_answers(
    system: PeriodicSystem, expected: list[complex], strip: float, goal: float
) -> None:
    found = stability(system)
    error = distances(found.exponents, expected, strip)
    assert error.max() <= goal
    assert np.all(error <= found.exponent_errors + 1e-18)


@pytest.mark.parametrize("n", [2, 4, 6, 8])
@pytest.mark.parametrize("size", [0.3, 2.0])
def test_truth_built_backwards(n: int, size: float) -> None:
    """Φ(2π) = exp(2πF): the exponents are F's eigenvalues, here with multipliers up to 25 decades apart."""
    for seed in range(4):
        F = np.random.default_rng([seed, n]).normal(size=(n, n)) * size / math.sqrt(n)
        with mpmath.workdps(40):
            expected = [complex(z) for z in mpmath.eig(mpmath.matrix(F.tolist()), left=False, right=False)]
        found = stability(rotating_frame(F))
        error = distances(found.exponents, expected, 1.0)
        assert np.all(error <= found.exponent_errors)
        assert error.max() < 1e-12


@pytest.mark.parametrize("N", [3, 4, 5])
@pytest.mark.parametrize("mu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("gamma", [4.0, 12.0])
def test_identical_blades_have_the_blades_exponents_shifted_by_integers(N: int, mu: float, gamma: float) -> None:
    rotor = Rotor(lock_number=gamma, hinge_offset=0.05, pitch_flap_coupling=0.1, blades=N)
    blade = np.asarray(stability(flapping(rotor, mu)).exponents)
    expected = (blade[:, None] + 1j * np.arange(N)).ravel()
    system = multiblade(rotor, mu)
    found, direct = stability(system), stability(system, symmetry=False)
    assert found.method == Method.HILL and direct.method == Method.FACTORS
    for one in (found, direct):
        assert distances(one.exponents, expected, N).max() < GOAL
        assert one.determinant_defect < 1e-13
    assert np.all(distances(found.exponents, direct.exponents, N) <= found.exponent_errors + direct.exponent_errors)
    assert np.all(np.abs(np.imag(found.exponents)) <= 0.5 * N) and found.verdict == direct.verdict
    assert np.sum(found.exponents).imag == 0.0  # conjugates, to the last bit


# ---------------------------------------------------------------------- bounds
def perturbed(phi: PeriodMap, direction: np.ndarray, size: float) -> PeriodMap:
    """The map moved by ``size`` along ``direction`` among maps of determinant 1, as every exact map is."""
    cofactors = np.linalg.inv(phi.hill[0]).T
    tangent = direction - np.sum(cofactors * direction) / np.sum(cofactors**2) * cofactors
    M = phi.hill + size * tangent / np.abs(tangent).max()
    M = M / np.sqrt(np.linalg.det(M))[:, None, None]
    D = (0.5 * (M[:, 0, 0] - M[:, 1, 1])) ** 2 + M[:, 0, 1] * M[:, 1, 0]
    assert phi.rows is not None
    return replace(phi, rows=np.concatenate([M.reshape(-1, 4).T, phi.rows[4:8], D[None]]))


@pytest.mark.parametrize("parameters", [{"mu": 0.3}, {"mu": 0.82684}, {"mu": 0.9}, {"mu": 0.826844869530709}])
def test_bound_covers_the_worst_perturbation_and_is_not_five_times_it(parameters: dict[str, float]) -> None:
    """Push Φ by its stated error in many directions: the set must stay within the bound, and come near it.

    γ = 8 on both sides of its lock at μ = 0.8268 and on the branch point itself.
    """
    phi = period_map(flapping(Rotor(lock_number=8.0), np.array([parameters["mu"]])))
    assert phi.rows is not None
    one = (np.ones(1), np.zeros(1), np.zeros(1), np.ones(1))
    rows = phi.rows.copy()
    rows[4:6] = finished(tuple(rows[:4]), 1.0, weighed(one, one, tuple(rows[:4]), phi.half_trace, 1e-9, 1.0))[4:6]
    phi = replace(phi, rows=rows)
    found = exponents(phi)
    moved = 0.0
    for direction in np.random.default_rng(6).normal(size=(4000, 2, 2)):
        tau, D = (m := perturbed(phi, direction, 1e-9)).half_trace[0], m.discriminant[0]
        nu = np.log(tau + np.sqrt(complex(D))) / TWO_PI
        moved = max(moved, distances([phi.mean[0] + nu, phi.mean[0] - nu], found.exponents[0], 1.0).max())
    assert moved <= found.exponent_errors[0].max() <= 5.0 * moved


@pytest.mark.parametrize("panels", [1, 2, 3])
def test_bound_follows_a_coarse_integration(panels: int) -> None:
    """Few panels for a large μ: truncation is the error, the bound must see it and not by chance."""
    system = flapping(Rotor(lock_number=20.0), np.linspace(0.5, 3.0, 11))
    fine, coarse = stability(system), stability(system, panels=panels)
    for a, b, e in zip(fine.exponents, coarse.exponents, coarse.exponent_errors, strict=True):
        assert distances(a, b, 1.0).max() <= e.max()
    assert np.all(coarse.panels == panels)


def test_an_undeclared_kink_shows_in_the_bound() -> None:
    """A square wave with its jump left undeclared is resolved badly: the bound says so, and holds."""

    def matrix(t: float) -> list[list[float]]:
        return [[0.0, 1.0], [-(1.0 - 0.2 * (1.0 if t % math.pi < 1.0 else -1.0)), 0.0]]

    blind = stability(PeriodicSystem.from_function(matrix, math.pi))
    told = stability(PeriodicSystem.from_function(matrix, math.pi, kinks=[1.0]))
    exact = stability(meissner(1.0, -0.2, period=math.pi, fraction=1.0 / math.pi)).exponents
    assert distances(told.exponents, exact, 2.0).max() < 1e-14 < 1e-9 < blind.exponent_errors.max()
    assert distances(blind.exponents, exact, 2.0).max() <= blind.exponent_errors.max()


def test_bounds_are_useful_away_from_branch_points() -> None:
    """At most 1e-11 where the discriminant exceeds 1e-3."""
    rng = np.random.default_rng(7)
    n = 400
    rotor = Rotor(
        lock_number=rng.uniform(2, 16, n),
        hinge_offset=rng.uniform(0, 0.2, n),
        hinge_stiffness=rng.uniform(0, 0.5, n),
        pitch_flap_coupling=rng.uniform(-0.5, 0.5, n),
    )
    phi = period_map(flapping(rotor, rng.uniform(0, 1, n)))
    away = np.abs(phi.discriminant) > 1e-3
    assert away.sum() > 0.9 * n
    assert exponents(phi).exponent_errors[away].max() <= 1e-11


def test_determinant_defect_can_fail() -> None:
    """Liouville: the check sees a map that is not of determinant 1, and a wrong mean trace."""
    phi = period_map(flapping(Rotor(lock_number=8.0), np.array([0.3])))
    assert phi.rows is not None
    assert exponents(phi).determinant_defect[0] < 1e-14
    wrong = phi.rows.copy()
    wrong[:4] *= 1 + 1e-9
    assert exponents(replace(phi, rows=wrong)).determinant_defect[0] > 1e-9
    many = period_map(multiblade(Rotor(lock_number=8.0, blades=3), np.array([0.3])))
    assert exponents(many).determinant_defect[0] < 1e-13
    assert exponents(replace(many, mean=many.mean + 1e-9)).determinant_defect[0] > 0.9e-9


# ---------------------------------------------------------------------- branch
def test_rotation_number_counts_turns() -> None:
    """Constant coefficients: ρ = √(k - d²/4), whatever its size; many turns a period included."""
    stiffness = np.array([0.1, 1.0, 4.3, 30.0, 400.0])
    system = PeriodicSystem(
        period=TWO_PI, damping=PeriodicMatrix.constant([[0.2]]), stiffness=PeriodicMatrix.scalar(mean=stiffness)
    )
    found = stability(system)
    np.testing.assert_allclose(found.rotation_number, np.sqrt(stiffness - 0.01), atol=1e-12)
    np.testing.assert_allclose(found.exponents[:, 0], -0.1 + 1j * np.sqrt(stiffness - 0.01), atol=1e-12)


def test_rotation_number_is_continuous_and_flat_in_locks() -> None:
    """Across the ½-per-rev lock of γ = 12 and the 1-per-rev lock of γ = 8."""
    for gamma, rho in ((12.0, 0.5), (8.0, 1.0)):
        s = stability(flapping(Rotor(lock_number=gamma), np.linspace(0.0, 1.0, 801)))
        assert np.abs(np.diff(s.rotation_number)).max() < 0.05  # a square root at the edge, no integer
        locked = ~np.isnan(s.lock)
        assert locked.any() and np.all(s.lock[locked] == rho) and np.all(s.rotation_number[locked] == rho)
        assert np.all(s.exponents[locked, 0].real >= s.exponents[locked, 1].real)


def test_rotation_number_rises_with_stiffness() -> None:
    rho = stability(flapping(Rotor(lock_number=8.0, hinge_stiffness=np.linspace(0.0, 3.0, 301)), 0.6)).rotation_number
    assert np.all(np.diff(rho) >= -1e-14)


@pytest.mark.parametrize("rho", [0.5, 1.0, 1.5])
def test_coexistence_is_no_lock(rho: float) -> None:
    """Φ = ±I without growth: y'' + ρ² y = 0 over 2π, both solutions periodic or antiperiodic."""
    s = stability(PeriodicSystem(period=TWO_PI, stiffness=PeriodicMatrix.constant([[rho * rho]])))
    assert math.isnan(s.lock) and s.rotation_number == pytest.approx(rho, abs=1e-14)
    # no branch point: D moves by the square of what Φ moves by, and doubles do
    assert s.method == Method.HILL and s.exponent_errors.max() < 1e-13


# ---------------------------------------------------------------------- verdicts, shapes
def test_verdicts_have_three_values() -> None:
    assert stability(flapping(Rotor(lock_number=8.0), 0.3)).verdict == Verdict.STABLE
    assert stability(flapping(Rotor(lock_number=8.0), 1.5)).verdict == Verdict.UNSTABLE
    neutral = stability(mathieu(2.5, 1.0))
    assert neutral.verdict == Verdict.UNDECIDED and neutral.reason == Reason.NEUTRAL
    edge = stability(flapping(Rotor(lock_number=8.0), instability_onset(Rotor(lock_number=8.0))))
    assert edge.verdict == Verdict.UNDECIDED and edge.reason == Reason.BOUND


def test_scalars_give_scalars_and_arrays_their_shape() -> None:
    one = stability(flapping(Rotor(lock_number=8.0), 0.3))
    assert isinstance(one.rotation_number, float) and isinstance(one.verdict, Verdict) and one.exponents.shape == (2,)
    grid = stability(flapping(Rotor(lock_number=np.array([[4.0], [8.0]])), np.array([0.0, 0.2, 0.4])))
    assert grid.exponents.shape == (2, 3, 2) and grid.lock.shape == (2, 3) and grid.verdict.dtype == np.int8
    np.testing.assert_array_equal(grid.exponents[1, 1], stability(flapping(Rotor(lock_number=8.0), 0.2)).exponents)


def test_constant_systems_have_eigenvalues_and_no_period() -> None:
    s = stability(tip_path_plane(Rotor(lock_number=8.0), 0.3))
    expected = [-0.5131 + 0.1403j, -0.4982 + 0.8428j, -0.4887 + 1.8548j]
    assert distances(s.exponents, [*expected, *np.conj(expected)]).max() < 1e-4  # table 4, four decimals
    assert (
        math.isnan(s.period) and math.isnan(s.lock) and np.isnan(s.multipliers).all() and s.method == Method.EIGENVALUES
    )
    assert np.all(s.exponent_errors < 1e-12)


def test_multipliers_are_the_eigenvalues_of_the_period() -> None:
    s = stability(teetering(Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING), 1.0))
    np.testing.assert_allclose(s.multipliers, np.exp(s.exponents * math.pi), rtol=1e-13)


def test_start_azimuth_does_not_matter() -> None:
    system = flapping(Rotor(lock_number=9.0, hinge_offset=0.1), 0.7)
    assert system.damping is not None and system.stiffness is not None
    for angle in (0.7, 2.0, 4.4):
        moved = PeriodicSystem(
            period=TWO_PI, damping=system.damping.shifted(angle), stiffness=system.stiffness.shifted(angle)
        )
        np.testing.assert_allclose(stability(moved).exponents, stability(system).exponents, atol=1e-13)


def test_a_case_alone_gives_the_same_bits() -> None:
    rng = np.random.default_rng(8)
    gamma, mu = rng.uniform(2, 16, 50), rng.uniform(0, 2, 50)
    for options in ({}, {"reversed_flow": True, "exact_offset": True}):
        many = stability(flapping(Rotor(lock_number=gamma, hinge_offset=0.1), mu, **options))  # type: ignore[arg-type]
        for i in range(0, 50, 7):
            one = stability(flapping(Rotor(lock_number=gamma[i : i + 1], hinge_offset=0.1), mu[i : i + 1], **options))  # type: ignore[arg-type]
            assert one.exponents.tobytes() == many.exponents[i : i + 1].tobytes()
            assert one.exponent_errors.tobytes() == many.exponent_errors[i : i + 1].tobytes()


# ---------------------------------------------------------------------- 30 digits, many blades in 80 bits
def generated() -> list[dict[str, Any]]:
    cases: list[dict[str, Any]] = json.loads((REFERENCE / "exponents.json").read_text())["cases"]
    return cases


@pytest.mark.parametrize("name", ["random", "near_branch", "reversed_flow", "dissimilar"])
def test_generated_reference(name: str) -> None:
    """204 cases of 30 digits: γ 2–24, μ to 2.5, next to branch points, reversed flow, dissimilar blades."""
    cases = [c for c in generated() if c["set"] == name]
    assert len(cases) >= 4
    for case in cases:
        if name == "dissimilar":
            mu = case["blades"][0]["advance_ratio"]
            blades = [Rotor(**{k: v for k, v in b.items() if k != "advance_ratio"}) for b in case["blades"]]
            found, strip = stability(multiblade(blades, mu)), 1.0
        else:
            p = dict(case["parameters"])
            found, strip = (
                stability(
                    flapping(
                        Rotor(**{k: v for k, v in p.items() if k != "advance_ratio"}),
                        p["advance_ratio"],
                        **case["options"],
                    )
                ),
                math.inf,
            )
            assert found.rotation_number == pytest.approx(
                float(case["rotation_number"]), abs=float(np.max(found.exponent_errors)) + 1e-14
            )
            assert (case["lock"] is None) == math.isnan(found.lock)
        error = distances(found.exponents, [complex(float(a), float(b)) for a, b in case["exponents"]], strip)
        assert np.all(error <= found.exponent_errors), case["id"]
        if name != "near_branch":
            assert error.max() <= GOAL, case["id"]


@pytest.mark.skipif(not extended.available(), reason="long double is no longer than double on this machine")
def test_bounds_hold_and_are_not_idle_on_many_blades() -> None:
    """1000 random blades against 80-bit integration: no error above its bound, bounds 100 times the median at most."""
    rng = np.random.default_rng(9)
    n = 1000
    gamma, eps, kappa, K1, mu = (rng.uniform(a, b, n) for a, b in ((2, 24), (0, 0.2), (0, 0.5), (-0.5, 0.5), (0, 1.5)))
    rotor = Rotor(lock_number=gamma, hinge_offset=eps, hinge_stiffness=kappa, pitch_flap_coupling=K1)
    expected, D = extended.exponents(gamma, eps, kappa, K1, mu, rotor.offset_mass_ratio)
    found = stability(flapping(rotor, mu))
    error = np.array([distances(a, b, 1.0).max() for a, b in zip(found.exponents, expected, strict=True)])
    bound = found.exponent_errors.max(axis=-1)
    assert np.all(error <= bound)
    assert np.median(bound) < max(1e-13, 100 * np.median(error))
    assert bound[np.abs(D) > 1e-3].max() <= 1e-11


@pytest.mark.parametrize(
    "M",
    [[[0.5, 2.0], [0.1, 0.6]], [[0.5, 2.0], [-0.1, 0.6]], [[0.9, 5.0], [0.0, 1e-4]]],
    ids=["real", "complex", "clusters"],
)
def test_bound_of_factors_covers_perturbations_and_is_not_ten_times_them(M: list[list[float]]) -> None:
    """Move a one-factor map by its stated error in many directions: inside one cluster and across two."""
    size, F = 1e-9, np.array([M])
    phi = PeriodMap(
        method=Method.FACTORS,
        period=1.0,
        shape=(1,),
        mean=np.zeros(1),
        panels=np.ones(1, np.int32),
        factors=(F,),
        errors=(np.array([size]),),
    )
    found, rng, moved = exponents(phi).exponents[0], np.random.default_rng(11), np.zeros(2)
    for delta in rng.normal(size=(1500, 2, 2)):
        values = np.log(np.linalg.eigvals(F[0] + size * delta / np.linalg.norm(delta)).astype(complex))
        d = np.abs(values[:, None] - found[None, :])
        moved = np.maximum(moved, np.diag(d) if np.trace(d) < np.trace(d[::-1]) else np.diag(d[::-1]))
    bounds = exponents(phi).exponent_errors[0]
    assert np.all(moved <= bounds) and np.all(bounds <= 9.0 * moved), bounds / moved


# ---------------------------------------------------------------------- far out, and what is refused
@pytest.mark.parametrize(
    ("gamma", "kappa", "K1", "mu", "sigma"),
    [(30.0, 10.0, -2.0, 3.0, 6.4031), (30.0, 0.0, 0.0, 3.0, 2.69648907), (100.0, 0.0, 0.0, 0.0, -0.08051866)],
)
def test_strong_locks_keep_their_digits(gamma: float, kappa: float, K1: float, mu: float, sigma: float) -> None:
    """Φ of 1e20 and more: the bound must not grow with Φ, or growth is taken for rounding."""
    found = stability(flapping(Rotor(lock_number=gamma, hinge_stiffness=kappa, pitch_flap_coupling=K1), mu))
    assert found.exponents[0].real == pytest.approx(sigma, abs=1e-4)
    assert found.exponent_errors.max() < 1e-12 and not math.isnan(found.lock)
    assert found.verdict == (Verdict.UNSTABLE if sigma > 0 else Verdict.STABLE)


def test_hover_of_an_overdamped_blade_is_its_roots() -> None:
    s = stability(flapping(Rotor(lock_number=100.0), 0.0))
    np.testing.assert_allclose(s.exponents, -6.25 + np.sqrt(6.25**2 - 1.0) * np.array([1, -1]), rtol=1e-13)


def test_functions_with_cases_of_unlike_stiffness() -> None:
    """Each case has panels of its own."""

    def matrix(t: float) -> np.ndarray:
        return np.array([[[0.0, 1.0], [-(a + 0.5 * math.cos(t)), -0.1]] for a in (1.0, 30.0)])

    many = stability(PeriodicSystem.from_function(matrix, TWO_PI))
    for i, a in enumerate((1.0, 30.0)):
        stiffness = PeriodicMatrix.scalar(mean=a, cosines=[0.5])
        one = stability(PeriodicSystem(period=TWO_PI, damping=PeriodicMatrix.constant([[0.1]]), stiffness=stiffness))
        assert distances(many.exponents[i], one.exponents, 1.0).max() < 1e-13
    assert many.panels[0] < many.panels[1]


def test_kinks_of_damping_and_stiffness_need_not_agree() -> None:
    def steps(values: list[float], at: float) -> PeriodicMatrix:
        return PeriodicMatrix.pieces([PeriodicMatrix.scalar(mean=v) for v in values], [0.0, at, TWO_PI])

    system = PeriodicSystem(period=TWO_PI, damping=steps([0.1, 0.5], 1.0), stiffness=steps([1.0, 2.0], 3.0))
    plain = PeriodicSystem.from_function(system.sample, TWO_PI, [1.0, 3.0], vectorised=True)
    assert distances(stability(system).exponents, stability(plain).exponents, 1.0).max() < 1e-13


def test_pieces_beyond_the_period_do_not_count() -> None:
    """The same steps of damping, told over one period or over two of which one is mapped."""
    values = [PeriodicMatrix.scalar(mean=v) for v in (0.1, 0.5)]
    stiffness = PeriodicMatrix.scalar(mean=1.3)
    once = PeriodicMatrix.pieces([replace(v, period=math.pi) for v in values], [0.0, 1.0, math.pi])
    twice = PeriodicMatrix.pieces(values * 2, [0.0, 1.0, math.pi, math.pi + 1.0, TWO_PI])
    one = PeriodicSystem(period=math.pi, damping=once, stiffness=replace(stiffness, period=math.pi))
    two = PeriodicSystem(period=math.pi, damping=twice, stiffness=stiffness)
    np.testing.assert_allclose(stability(two).exponents, stability(one).exponents, atol=1e-14)


def test_conjugates_stand_together() -> None:
    r = Rotor(lock_number=9.0)
    system = multiblade([r.replace() for _ in range(4)], 0.3)
    assert system.period == pytest.approx(math.pi / 2)  # equal blades are identical blades
    eta = np.asarray(stability(system).exponents)
    np.testing.assert_allclose(eta[::2], np.conj(eta[1::2]), atol=1e-12)


@pytest.mark.parametrize("change", [{"period": 2 * TWO_PI}, {"period": 1.0}])
def test_a_period_that_contradicts_the_coefficients_is_refused(change: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match="no period of coefficients"):
        replace(meissner(1.3, 0.2, 0.1), **change)
    with pytest.raises(ParameterError, match="odd harmonics"):
        replace(flapping(Rotor(lock_number=8.0), 0.3), period=math.pi)


def test_what_is_no_system_or_matrix_is_refused() -> None:
    with pytest.raises(ParameterError, match="is no system"):
        stability(Rotor(lock_number=8.0))  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="of real equations"):
        stability(PeriodicSystem.from_function(lambda t: np.array([[1j]]), 1.0))
    with pytest.raises(ParameterError, match="no number of panels"):
        stability(mathieu(1.0, 0.1), panels=0)
    assert stability(flapping(Rotor(lock_number=8.0), np.zeros(0), reversed_flow=True)).exponents.shape == (0, 2)
    assert f"{Verdict.UNSTABLE} {Verdict.UNSTABLE:d}" == "UNSTABLE 1"


@pytest.mark.parametrize("option", ["symmetry", "check", "certify"])
def test_switches_are_true_or_false(option: str) -> None:
    with pytest.raises(ParameterError, match=f"{option}: 'x' is neither True nor False"):
        stability(flapping(Rotor(lock_number=8.0), 0.3), **{option: "x"})  # type: ignore[arg-type]


@pytest.mark.parametrize("option", ["check", "certify"])
def test_no_case_has_no_evidence(option: str) -> None:
    with pytest.raises(ParameterError, match=f"{option}: there is no case"):
        stability(flapping(Rotor(lock_number=np.zeros(0)), 0.3), **{option: True})  # type: ignore[arg-type]


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("gamma", [1e150, 1e308, np.full(9000, 1e150)])
def test_a_parameter_beyond_doubles_has_no_bound_and_no_noise(gamma: Any) -> None:
    rotor = Rotor(lock_number=gamma)
    for found in (stability(flapping(rotor, 0.3)), compare(rotor, 0.3).stability):
        assert np.all(np.isinf(found.exponent_errors)) and np.all(found.verdict == Verdict.UNDECIDED)
    with pytest.raises(ParameterError, match="beyond what doubles hold"):
        lock_windows(rotor[:3] if rotor.shape else rotor)


# ---------------------------------------------------------------------- evidence
def test_an_answer_can_be_checked_and_proved() -> None:
    """A second mechanism beside the first; proven exponents in place of computed ones, with radii of rounding."""
    pytest.importorskip("flint")
    rotor = Rotor(lock_number=np.array([4.0, 8.0, 12.0]), hinge_offset=0.05, blades=4)
    for system in (flapping(rotor, 0.3), multiblade(rotor, 0.3)):
        found, plain = stability(system, check=True, certify=True), stability(system)
        assert found.check is not None and found.certificates is not None and len(found.certificates) == 3
        assert np.all(found.method == Method.CERTIFIED) and np.all(found.verdict == Verdict.STABLE)
        assert found.exponent_errors.max() < 1e-15 < plain.exponent_errors.max()
        assert np.all(np.abs(found.exponents - plain.exponents) <= found.exponent_errors + plain.exponent_errors)
        assert plain.check is None and plain.certificates is None
    one = stability(flapping(Rotor(lock_number=8.0), 1.5), certify=True)
    assert one.verdict is Verdict.UNSTABLE and "unstable" in one.certificates[0].theorem
    constant = stability(tip_path_plane(Rotor(lock_number=8.0), 0.3), certify=True)
    assert constant.verdict is Verdict.STABLE


@pytest.mark.parametrize("gamma", [[1e150], [8.0, 1e150], [*np.linspace(1.0, 20.0, 3000), 1e100, 1e300]])
@pytest.mark.parametrize("options", [{}, {"map": True}, {"symmetry": False}])
def test_what_leaves_doubles_has_no_bound(gamma: list[float], options: dict[str, Any]) -> None:
    """In silence: RuntimeWarnings of NumPy say nothing that the bound does not."""
    rotor = Rotor(lock_number=np.array(gamma), blades=3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for system in (flapping(rotor, 0.3), multiblade(rotor, 0.3)):
            found = stability(system, **options)
            lost = np.isinf(found.exponent_errors)
            assert lost[-1].all() and np.all(np.isfinite(found.exponents[~lost]))
            assert not np.isnan(found.exponent_errors).any() and found.verdict[-1] == Verdict.UNDECIDED


def test_a_map_that_overflowed_is_proved_all_the_same() -> None:
    """Growth of e^1000 a period is no number of the program and no fault of it."""
    pytest.importorskip("flint")
    system = mathieu(-30000.0, 0.1)
    assert np.all(np.isinf(stability(system).exponent_errors))
    assert stability(system, certify=True).verdict is Verdict.UNSTABLE


def test_what_disagrees_with_its_proof_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """An engine that is wrong by a thousand bounds is found out by the certificate and by the second mechanism."""
    pytest.importorskip("flint")
    system = flapping(Rotor(lock_number=8.0), 0.3)
    right = exponents(period_map(system))
    wrong = replace(right, exponents=right.exponents + 1e-11)
    monkeypatch.setattr("floquet.exponents.exponents", lambda phi: wrong)
    for evidence in ("check", "certify"):
        with pytest.raises(FailedError, match="please report it"):
            stability(system, **{evidence: True})


def test_functions_have_no_certificate() -> None:
    pytest.importorskip("flint")
    with pytest.raises(ParameterError, match="nothing can be proven"):
        stability(hill_sawtooth(1.0, -0.2), certify=True)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"map": "lock_numbr"}, "did you mean 'lock_number'"),
        ({"map": 3}, "no parameter"),
        ({"panels": "a"}, "no number of panels"),
        ({"panels": 2.5}, "no number of panels"),
    ],
)
def test_settings_that_are_none_are_one_sentence(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        stability(flapping(Rotor(lock_number=8.0), 0.3), **options)
    assert stability(colaneri(), map=True).exponents.shape == (2,)
