"""Locks, onsets and limits against published transitions, Mathieu's characteristic values and brute force."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from floquet.comparison import Cause, Metric, Rule, compare, eigenvalues
from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.models import flapping, tip_path_plane
from floquet.rotor import Hub, Rotor
from floquet.validity import (
    all_limits,
    crossings,
    instability_onset,
    limits,
    lock_windows,
    split_edges,
    tpp_instability_onset,
    validity_intervals,
    validity_limit,
)
from tests.support import REFERENCE

FAMILY = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling")
FAMILIES: dict[str, dict[str, float]] = {
    "fig6": {},
    "fig7": {"hinge_offset": 0.15},
    "fig8": {"hinge_stiffness": 0.225},
    "fig9": {"pitch_flap_coupling": 0.225},
    "K1=-0.2": {"pitch_flap_coupling": -0.2},
    "K1=0.5": {"pitch_flap_coupling": 0.5},
}


def transitions() -> list[tuple[str, dict[str, Any]]]:
    data: dict[str, Any] = json.loads((REFERENCE / "transitions.json").read_text())
    return [(key, value) for key, value in data.items() if key != "meta"]


def rotor_of(key: str) -> Rotor:
    model, family, gamma = key.split(":")
    hub = {"blades": 2, "hub": Hub.TEETERING} if model == "teeter" else {}
    return Rotor(lock_number=float(gamma), **FAMILIES[family], **hub)  # type: ignore[arg-type]


@pytest.mark.parametrize(("key", "expected"), transitions(), ids=[k for k, _ in transitions()])
def test_transitions(key: str, expected: dict[str, Any]) -> None:
    """Lock edges up to μ = 1 and onsets of growth, given to about 1e-12."""
    rotor = rotor_of(key)
    assert instability_onset(rotor) == pytest.approx(expected["instability_mu"], abs=1e-11)
    if "edges" in expected:
        windows = lock_windows(rotor)
        found = sorted(
            [(a, "enter", r) for a, _, r in windows if a > 0] + [(b, "leave", r) for _, b, r in windows if b < math.inf]
        )
        listed = sorted((e["mu"], e["type"], e["rho"]) for e in expected["edges"])
        assert [f[1:] for f in found] == [e[1:] for e in listed]
        np.testing.assert_allclose([f[0] for f in found], [e[0] for e in listed], atol=1e-11)


@pytest.mark.parametrize(
    ("gamma", "kappa", "K1"), [(6.0, 0.0, 0.0), (2.0, 0.0, 0.0), (10.0, 0.225, 0.1), (18.0, 0.0, 0.0)]
)
def test_teetering_lock_edges_are_mathieus(gamma: float, kappa: float, K1: float) -> None:
    """a(μ) = a_n(q) or b_n(q) with a, q of the damped Mathieu equation: no integration on that side."""

    def a_q(mu: float) -> tuple[float, float]:
        P2 = 1.0 + kappa + gamma * K1 / 8.0
        return P2 + gamma * K1 * mu**2 / 8.0 - (gamma / 16.0) ** 2, gamma * mu**2 / 16.0 * math.sqrt(1.0 + K1**2)

    edges, grid = [], np.linspace(1e-6, 1.5, 400)
    for curve, orders in ((mathieu_a, (0, 1, 2)), (mathieu_b, (1, 2))):
        for n in orders:
            f = [a_q(m)[0] - curve(n, a_q(m)[1]) for m in grid]
            for i in np.flatnonzero(np.sign(f[:-1]) != np.sign(f[1:])):
                edges.append(
                    brentq(
                        lambda m, curve=curve, n=n: a_q(m)[0] - curve(n, a_q(m)[1]), grid[i], grid[i + 1], xtol=1e-14
                    )
                )
    windows = lock_windows(
        Rotor(lock_number=gamma, hinge_stiffness=kappa, pitch_flap_coupling=K1, blades=2, hub=Hub.TEETERING), mu_max=1.5
    )
    found = [x for a, b, _ in windows for x in (a, b) if 0 < x < math.inf]
    np.testing.assert_allclose(sorted(found), sorted(edges), atol=1e-10)  # SciPy's characteristic values: 1e-12


@pytest.mark.parametrize(("gamma", "limit"), [(6.0, 0.41798), (8.0, 0.35734), (10.0, 0.29228)])
def test_regressing_limit_of_the_plain_rotor(gamma: float, limit: float) -> None:
    assert validity_limit(Rotor(lock_number=gamma)) == pytest.approx(limit, abs=1e-5)


def test_teetering_rotor_fails_in_no_wide_range_below_its_lock() -> None:
    """γ = 6: 7e-4 at μ = 0.4, 1.2 % at 0.6, lock from 0.60724; γ = 8: above 5 % on a hundredth of μ only."""
    six, eight = (Rotor(lock_number=gamma, blades=2, hub=Hub.TEETERING) for gamma in (6.0, 8.0))
    assert compare(six, 0.4)["regressing"].error == pytest.approx(7.2e-4, abs=5e-6)
    assert compare(six, 0.6)["regressing"].error == pytest.approx(1.2e-2, abs=5e-4)
    assert lock_windows(six)[0][0] == pytest.approx(0.60724, abs=5e-6)
    ((start, end),) = validity_intervals(eight)
    assert start == pytest.approx(0.69635, abs=5e-6) and end == pytest.approx(0.70783, abs=5e-6)


def test_a_limit_inside_a_lock_says_so() -> None:
    found = limits(Rotor(lock_number=12.0), modes=["regressing"])[0]
    enter, _, per_rev = lock_windows(Rotor(lock_number=12.0))[0]
    assert enter == pytest.approx(0.21438, abs=1e-5) and per_rev == 0.5
    assert found.limit < enter and found.cause == Cause.DRIFT and found.rule == Rule.PAIRED
    held = limits(
        Rotor(lock_number=5.087, hinge_stiffness=0.248), tolerances=[(Metric.RELATIVE, 0.2)], modes=["coning"]
    )[0]
    assert held.limit == math.inf and held.rule == Rule.MEAN  # up to μ = 1, where the pair is locked
    assert compare(Rotor(lock_number=12.0), 0.3)["regressing"].lock == 0.5


@pytest.mark.parametrize(("reversed_flow", "onset"), [(False, 1.39189), (True, 2.22823)])
def test_growth_without_and_with_reversed_flow(reversed_flow: bool, onset: float) -> None:
    assert instability_onset(Rotor(lock_number=8.0), reversed_flow=reversed_flow) == pytest.approx(onset, abs=5e-6)


def test_onset_is_where_growth_begins() -> None:
    for rotor, options in (
        (Rotor(lock_number=10.0, hinge_offset=0.1), {"exact_offset": True, "reversed_flow": True}),
        (Rotor(lock_number=5.0), {}),
    ):
        onset = instability_onset(rotor, **options)
        below, above = (np.max(stability(flapping(rotor, onset + d, **options)).exponents.real) for d in (-1e-6, 1e-6))  # type: ignore[arg-type]
        assert below < 0 < above


def test_divergence_in_hover_is_at_zero_and_calm_rotors_have_none() -> None:
    assert instability_onset(Rotor(lock_number=12.0, pitch_flap_coupling=-1.0)) == 0.0
    assert instability_onset(Rotor(lock_number=8.0), mu_max=1.0) == math.inf


def test_locks_open_in_hover_and_at_the_end() -> None:
    assert lock_windows(Rotor(lock_number=20.0))[0][0] == 0.0 and lock_windows(Rotor(lock_number=20.0))[0][2] == 0.0
    assert lock_windows(Rotor(lock_number=8.0))[-1] == (pytest.approx(0.8268448695), math.inf, 1.0)
    assert lock_windows(Rotor(lock_number=16.0))[0][0] > 0.0  # at γ = 16 hover is the branch point itself, not a lock


def test_locks_parted_by_a_narrow_gap_are_two() -> None:
    """A gap of 3e-5 in μ between 1 and 1½ per rev, of 6e-6 between 1½ and 2: each lock has its own name."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05)
    windows = lock_windows(rotor, mu_max=5.0)
    assert [w[2] for w in windows] == [1.0, 1.5, 2.0] and windows[-1][1] == math.inf
    for enter, leave, rho in windows:
        inside = np.linspace(enter + 1e-7, min(leave, 5.0) - 1e-7, 50)
        np.testing.assert_array_equal(stability(flapping(rotor, inside)).lock, rho)
    gap = 0.5 * (windows[0][1] + windows[1][0])
    assert math.isnan(stability(flapping(rotor, gap)).lock)


def test_a_rotor_beyond_doubles_is_refused() -> None:
    for call in (validity_limit, lock_windows, instability_onset):
        with pytest.raises(ParameterError, match="overflows"), np.errstate(all="ignore"):
            call(Rotor(lock_number=np.array([8.0, 1e5])))


@pytest.mark.parametrize("seed", range(6))
def test_windows_against_a_fine_scan(seed: int) -> None:
    """Every lock of a random design found on a grid of 1e-3 is a window, and nothing else is."""
    rng = np.random.default_rng([10, seed])
    rotor = Rotor(
        lock_number=rng.uniform(2, 20),
        hinge_offset=rng.uniform(0, 0.2),
        hinge_stiffness=rng.uniform(0, 0.8),
        pitch_flap_coupling=rng.uniform(-0.3, 0.5),
    )
    options: dict[str, Any] = {"reversed_flow": True, "exact_offset": True} if seed % 2 else {}
    mu = np.linspace(0.0005, 1.9995, 2000)
    lock = stability(flapping(rotor, mu, **options)).lock
    inside = np.full(mu.shape, np.nan)
    for a, b, rho in lock_windows(rotor, mu_max=2.0, **options):
        inside[(mu > a) & (mu < b)] = rho
    np.testing.assert_array_equal(np.isnan(lock), np.isnan(inside))
    np.testing.assert_allclose(lock[~np.isnan(lock)], inside[~np.isnan(lock)])


def test_intervals_against_a_fine_scan() -> None:
    """Bo 105's coning fails between its crossings only; every sign of the scan agrees with the intervals."""
    rotor = Rotor(lock_number=5.087, hinge_stiffness=0.24811494)
    (start, end), *rest = validity_intervals(rotor, mode="coning")
    assert not rest and start == pytest.approx(0.5518, abs=1e-4) and end == pytest.approx(0.5641, abs=1e-4)
    mu = np.linspace(0.0003, 0.9997, 2500)
    for mode in ("regressing", "coning", "advancing", "differential"):
        for metric, tolerance in ((Metric.RELATIVE, 0.01), (Metric.ABSOLUTE, 0.02)):
            error = compare(rotor, mu)[mode].by(metric)
            failing = np.zeros(mu.shape, bool)
            for a, b in validity_intervals(rotor, tolerance, mode, metric=metric):
                failing |= (mu > a) & (mu < b)
            np.testing.assert_array_equal(error > tolerance, failing)


def test_the_limit_is_the_first_interval_and_its_error_the_tolerance() -> None:
    rotor = Rotor(lock_number=9.374, hinge_stiffness=0.0516)
    for found in limits(rotor, tolerances=[(Metric.RELATIVE, t) for t in (0.01, 0.05, 0.1)]):
        assert found.limit == (found.intervals[0][0] if found.intervals else math.inf)
        if found.limit < math.inf:
            assert compare(rotor, found.limit)[found.mode].error == pytest.approx(found.tolerance, rel=1e-9)


def test_splits_are_where_the_tpp_pairs_turn_real() -> None:
    rotor = Rotor(lock_number=8.0, hinge_offset=0.15)
    edges = split_edges(rotor)
    assert edges
    for edge in edges:
        counts = [
            (np.abs(np.asarray(stability(tip_path_plane(rotor, edge + d)).exponents).imag) < 1e-9).sum()
            for d in (-1e-6, 1e-6)
        ]
        assert abs(counts[0] - counts[1]) == 2
    found = limits(rotor, modes=["regressing"])[0]
    assert found.split_edge == min(edges, key=lambda e: abs(e - found.limit))


def passages(f: Callable[[Any], Any], **given: Any) -> list[float]:
    """Every passage of one curve through zero on [0, 1]."""
    return crossings(lambda _, x: f(x), np.zeros(1), np.ones(1), **given).x.tolist()


def test_crossings_are_found_however_close() -> None:
    """Roots a millionth apart, a double root that does not cross, many roots, none at the ends."""
    np.testing.assert_allclose(passages(lambda x: (x - 0.5) * (x - 0.500001)), [0.5, 0.500001], atol=1e-12)
    assert passages(lambda x: (x - 0.5) ** 2 + 1e-9) == []
    assert passages(lambda x: (x - 0.5) ** 2, least=1e-9) == []
    np.testing.assert_allclose(
        passages(lambda x: np.sin(40 * x + 0.1)), (np.arange(1, 13) * math.pi - 0.1) / 40, atol=1e-15
    )


@pytest.mark.parametrize("width", [10.0**-k for k in range(2, 9)])
def test_windows_of_every_width_are_found(width: float) -> None:
    """Two passages so far apart, of a curve known to more digits than its values have."""

    def curve(case: Any, x: Any) -> Any:
        return np.cos(7.0 * x) * np.exp(x) * ((x - 0.3) ** 2 - (0.5 * width) ** 2)

    found = crossings(curve, np.zeros(1), np.ones(1), exact=lambda level: lambda case, x: curve(case, x) - level).x
    expected = [math.pi / 14, 0.3 - 0.5 * width, 0.3 + 0.5 * width, 3 * math.pi / 14]
    np.testing.assert_allclose(found, expected, atol=1e-14 + 1e-5 * width)
    if width < 5e-7:
        assert len(passages(lambda x: curve(0, x), least=2.0 * width)) == 2


def test_a_narrow_dip_is_resolved_before_roots_are_sought() -> None:
    """A hundredth wide on a rising line: polynomials that leave it out have no root there."""
    found = passages(lambda x: 0.1 + x - np.exp(-(((x - 0.5) / 0.01) ** 2)))
    assert len(found) == 2
    np.testing.assert_allclose([0.1 + x - math.exp(-(((x - 0.5) / 0.01) ** 2)) for x in found], 0.0, atol=1e-12)


def test_roots_are_the_curves_own_where_polynomials_are_coarse() -> None:
    """Of polynomials that are right to a thousandth: two steps with the curve itself."""
    found = passages(lambda x: np.exp(3.0 * np.sin(11.0 * x)) - 1.5, rounding=1e-3)
    exact = sorted(
        x for k in range(2) for x in (
            (math.asin(math.log(1.5) / 3.0) + 2 * math.pi * k) / 11.0,
            (math.pi - math.asin(math.log(1.5) / 3.0) + 2 * math.pi * k) / 11.0,
        ) if x < 1.0
    )  # fmt: skip
    np.testing.assert_allclose(found, exact, atol=1e-9)


def test_a_gap_between_two_samples_is_found() -> None:
    """A tolerance just above a least error: the mode holds on a range far narrower than a sample."""
    rotor = Rotor(lock_number=9.374, hinge_stiffness=0.0516)
    mu = np.linspace(0.70, 0.76, 60_001)
    error = compare(rotor, mu)["differential"].error
    least = int(np.argmin(error))
    assert 0 < least < len(mu) - 1
    tolerance = float(error[least]) + 1e-6
    failing = validity_intervals(rotor, tolerance, "differential")
    (gap,) = [(a, b) for (_, a), (b, _) in pairwise(failing) if a < mu[least] < b]
    assert 0.0 < gap[1] - gap[0] < 3e-3


def test_crossings_of_many_curves_at_once() -> None:
    """Polynomials of six random roots, down to 1e-11 of their largest values; two levels."""
    roots = np.sort(np.random.default_rng(0).uniform(0, 1, (500, 6)), axis=1)

    def curve(case: Any, x: Any) -> Any:
        return np.prod(x[:, None] - roots[case], axis=1)

    found = crossings(curve, np.zeros(500), np.ones(500))
    np.testing.assert_array_equal(found.case, np.repeat(np.arange(500), 6))
    np.testing.assert_allclose(found.x, roots.ravel(), atol=1e-13)
    waves = crossings(lambda case, x: np.sin((case + 1.0) * 2 * math.pi * x), np.zeros(5), np.ones(5), (0.5, -0.5))
    np.testing.assert_array_equal(np.bincount(waves.case), 4 * np.arange(1, 6))
    np.testing.assert_allclose(np.sin((waves.case + 1.0) * 2 * math.pi * waves.x), waves.level, atol=1e-14)


def test_many_rotors_have_the_limits_of_each() -> None:
    rng = np.random.default_rng(8)
    rotors = Rotor(lock_number=rng.uniform(2, 16, (3, 4)), hinge_offset=rng.uniform(0, 0.15, (3, 1)))
    found = all_limits(rotors, tolerances=[(Metric.RELATIVE, 0.05), (Metric.ABSOLUTE, 0.02)], mu_max=1.2)
    for case, index in enumerate(np.ndindex(3, 4)):
        one = limits(rotors[index], tolerances=[(Metric.RELATIVE, 0.05), (Metric.ABSOLUTE, 0.02)], mu_max=1.2)
        for a, b in zip(found.of(case), one, strict=True):
            assert (a.mode, a.metric, a.cause, a.rule) == (b.mode, b.metric, b.cause, b.rule)
            np.testing.assert_allclose(a.intervals, b.intervals, atol=1e-10)
            np.testing.assert_allclose([a.lock_edge, a.split_edge], [b.lock_edge, b.split_edge], atol=1e-10)


def test_arrays_of_rotors() -> None:
    rotors = Rotor(lock_number=np.array([[6.0, 8.0]]))
    np.testing.assert_allclose(validity_limit(rotors), [[0.41798, 0.35734]], atol=1e-5)
    assert [w[0][2] for w in lock_windows(rotors)] == [1.0, 1.0]


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: validity_limit(Rotor(lock_number=8.0), mode="regresive"), "did you mean 'regressing'"),
        (lambda: validity_limit(Rotor(lock_number=8.0), tolerance=0.0), "is no tolerance"),
        (lambda: validity_limit(Rotor(lock_number=8.0), mu_max=-1.0), "above 0"),
        (lambda: validity_limit(Rotor(lock_number=8.0), metric="absolute"), "give one of Metric.RELATIVE"),
        (lambda: limits(Rotor(lock_number=np.array([6.0, 8.0]))), "takes one rotor"),
        (lambda: lock_windows(Rotor(lock_number=8.0), revesed_flow=True), "did you mean 'reversed_flow'"),
    ],
)
def test_bad_input_is_one_sentence(call, sentence: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError, match=sentence):
        call()


@pytest.mark.parametrize("sought", [validity_limit, validity_intervals, lock_windows, instability_onset, limits])
@pytest.mark.parametrize("value", ["x", 3, None])
def test_boundaries_are_of_a_rotor(sought: Callable[..., Any], value: Any) -> None:
    with pytest.raises(ParameterError, match="is no Rotor: make one"):
        sought(value)


@pytest.mark.parametrize("sought", [validity_limit, validity_intervals])
def test_no_rotor_has_no_limit(sought: Callable[..., Any]) -> None:
    with pytest.raises(ParameterError, match="there is no rotor whose limits"):
        sought(Rotor(lock_number=np.zeros(0)))


def test_a_mode_is_a_word() -> None:
    with pytest.raises(ParameterError, match="3 is not a mode of this rotor"):
        validity_limit(Rotor(lock_number=8.0), mode=3)  # type: ignore[arg-type]


# ---------------------------------------------------------------------- growth of the simple model
def test_the_teetering_plane_grows_from_the_square_root_of_two() -> None:
    """For every Lock number, without spring and coupling: eq. (7) has the constant term P² - 1 - … = 0 there."""
    gamma = np.array([2.0, 5.0, 8.0, 16.0])
    found = tpp_instability_onset(Rotor(lock_number=gamma, blades=2, hub=Hub.TEETERING))
    np.testing.assert_allclose(found, math.sqrt(2.0), atol=1e-10)
    assert tpp_instability_onset(Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING), 1.4) == math.inf


def test_growth_of_the_plane_is_that_of_a_scan() -> None:
    """Random rotors: the largest real part is negative on a fine grid up to the onset, and positive behind it."""
    rng = np.random.default_rng(12)
    rotor = Rotor(
        lock_number=rng.uniform(2.0, 20.0, 40),
        hinge_offset=rng.uniform(0.0, 0.15, 40),
        hinge_stiffness=rng.uniform(0.0, 0.3, 40),
        pitch_flap_coupling=rng.uniform(-1.0, 0.6, 40),
        blades=3,
    )
    found = tpp_instability_onset(rotor, 2.0)
    assert 5 < np.isfinite(found).sum() < 40
    mu = np.linspace(0.0, 2.0, 4001)
    for k in range(40):
        one = Rotor(**{name: float(getattr(rotor, name)[k]) for name in FAMILY}, blades=3)
        growth = eigenvalues(tip_path_plane(one, mu)).real.max(axis=-1)
        first = mu[growth > 0.0][0] if np.any(growth > 0.0) else math.inf
        assert first - 5e-4 <= found[k] <= first if math.isfinite(first) else found[k] > 2.0 - 5e-4
        if 0.0 < found[k] < math.inf:
            beside = eigenvalues(tip_path_plane(one, found[k] + np.array([-1e-7, 1e-7]))).real.max(axis=-1)
            assert beside[0] < 0.0 < beside[1]
