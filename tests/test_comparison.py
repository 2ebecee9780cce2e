"""What is compared with what: targets, locks, pairing, causes, metrics."""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any

import numpy as np
import pytest

from floquet.comparison import Cause, Metric, Rule, compare, matched, mode_orders
from floquet.errors import FloquetWarning, ParameterError
from floquet.exponents import Stability, stability
from floquet.kernels import pairing
from floquet.kernels.quadratics import in_order
from floquet.models import flapping
from floquet.rotor import Hub, Rotor

TEETERING = Rotor(lock_number=6.0, blades=2, hub=Hub.TEETERING)


def locked_state(rho: float, s1: float, s2: float) -> Stability:
    """A blade locked at rho, as stability() would report it."""
    return Stability(
        exponents=np.array([s1 + 1j * rho, s2 + 1j * rho]),
        exponent_errors=None,
        determinant_defect=0.0,
        rotation_number=rho,
        lock=rho,
        verdict=0,
        reason=0,
        method=0,
        panels=0,
        period=2 * math.pi,
    )


def assigned(targets: Any, values: Any) -> Any:
    """The pair of values (2m,) of every target (m, 2), for one point."""
    m = len(targets)
    exact, z = (np.stack([x.real, x.imag], axis=-1) for x in (np.asarray(targets), in_order(np.asarray(values))))
    pairs = np.empty((m, 4, 1, 1))
    pairing.assigned(
        exact.reshape(m, 4, 1, 1),
        np.arange(m, dtype=float),
        z.reshape(2 * m, 2, 1, 1),
        *pairing.tables(m),
        np.empty((2 * m + 1, m, 1)),
        pairs,
        0,
    )
    return pairs[:, 0::2, 0, 0] + 1j * pairs[:, 1::2, 0, 0]


# ---------------------------------------------------------------------- published and derived numbers
@pytest.mark.parametrize(("harmonics", "error", "digits"), [(1, 0.034, 1e-3), (2, 0.00083, 1e-5), (3, 8e-6, 5e-7)])
def test_averaged_models_of_3_5_and_7_blades(harmonics: int, error: float, digits: float) -> None:
    """γ = 8, μ = .3: 3.4 %, 0.083 % and 8e-6 for the regressing mode."""
    assert compare(Rotor(lock_number=8.0), 0.3, harmonics=harmonics)["regressing"].error == pytest.approx(
        error, abs=digits
    )


def test_frequency_alone_would_say_more() -> None:
    mode = compare(Rotor(lock_number=8.0), 0.3)["regressing"]
    assert mode.by(Metric.FREQUENCY) == pytest.approx(0.077, abs=5e-4)
    assert mode.by(Metric.ABSOLUTE) == pytest.approx(mode.error * abs(mode.exact[0]), rel=1e-12)
    d = mode.simple - mode.exact
    assert mode.by(Metric.DAMPING) == pytest.approx(np.abs(d.real).max() / np.abs(mode.exact.real).max(), rel=1e-12)


@pytest.mark.parametrize(("mu", "error"), [(0.4, 7.2e-4), (0.6, 1.24e-2)])
def test_teetering_regressing_error(mu: float, error: float) -> None:
    assert compare(TEETERING, mu)["regressing"].error == pytest.approx(error, rel=0.005)


@pytest.mark.parametrize(
    ("rotor", "mode", "order"),
    [
        (Rotor(lock_number=8.0), "regressing", 2),
        (Rotor(lock_number=8.0), "advancing", 2),
        (Rotor(lock_number=8.0), "coning", 4),
        (TEETERING, "regressing", 4),
        (TEETERING, "advancing", 4),
    ],
)
def test_order_of_the_error_in_mu(rotor: Rotor, mode: str, order: int) -> None:
    """O(μ²) for regressing and advancing, O(μ⁴) for coning and the teetering rotor."""
    small, large = (compare(rotor, mu)[mode].error for mu in (0.02, 0.04))
    assert math.log2(large / small) == pytest.approx(order, abs=0.05)


def test_hover_is_exact() -> None:
    for rotor in (
        Rotor(lock_number=8.0, hinge_offset=0.1, pitch_flap_coupling=0.2),
        Rotor(lock_number=20.0),
        TEETERING,
    ):
        for mode in compare(rotor, 0.0).modes:
            assert mode.error < 1e-7, mode.name  # √eps: at hover the overdamped and the cyclic pairs may be double


# ---------------------------------------------------------------------- targets
def test_targets_outside_a_lock() -> None:
    c = compare(Rotor(lock_number=8.0), 0.3)
    alpha, rho = -0.5, c.stability.rotation_number
    for mode, k in zip(c.modes, (-1, 0, 1), strict=False):
        assert mode.rule == Rule.PAIRED
        np.testing.assert_allclose(
            sorted(mode.exact, key=lambda z: z.imag), [alpha - 1j * abs(rho + k), alpha + 1j * abs(rho + k)], atol=1e-14
        )
    np.testing.assert_allclose(np.sort(c["differential"].exact.imag), [-rho, rho], atol=1e-14)


S1, S2 = -0.3, -0.7
MEAN = 0.5 * (S1 + S2)


@pytest.mark.parametrize(
    ("rho", "expected"),
    [
        (
            1.0,
            {
                -1: (Rule.REALS, {S1, S2}),
                0: (Rule.MEAN, {MEAN + 1j, MEAN - 1j}),
                1: (Rule.MEAN, {MEAN + 2j, MEAN - 2j}),
            },
        ),
        (0.5, {-1: (Rule.JOINT, None), 0: (Rule.JOINT, None), 1: (Rule.MEAN, {MEAN + 1.5j, MEAN - 1.5j})}),
        (0.0, {-1: (Rule.JOINT, None), 0: (Rule.REALS, {S1, S2}), 1: (Rule.JOINT, None)}),
        (
            1.5,
            {
                -1: (Rule.MEAN, {MEAN + 0.5j, MEAN - 0.5j}),
                0: (Rule.MEAN, {MEAN + 1.5j, MEAN - 1.5j}),
                1: (Rule.MEAN, {MEAN + 2.5j, MEAN - 2.5j}),
            },
        ),
    ],
)
def test_targets_inside_each_kind_of_lock(rho: float, expected: dict[int, tuple[Rule, set[complex] | None]]) -> None:
    """The rules of each lock; the joint modes share σ₁ and σ₂ at one frequency."""
    orders = (-1, 0, 1)
    simple = np.array([MEAN + 0.01 * k + 1j * sign * (0.1 + abs(rho + k)) for k in orders for sign in (1, -1)])
    c = matched(locked_state(rho, S1, S2), simple, orders)
    joint: list[complex] = []
    for k, mode in zip(orders, c.modes, strict=True):
        rule, targets = expected[k]
        assert mode.rule == rule, (rho, k)
        if targets is None:
            joint += list(mode.exact)
            np.testing.assert_allclose(mode.exact[0], np.conj(mode.exact[1]))
        else:
            assert {complex(np.round(z, 12)) for z in mode.exact} == targets
    if joint:
        w = next(abs(rho + k) for k in orders if expected[k][0] == Rule.JOINT)
        assert {complex(np.round(z, 12)) for z in joint} == {complex(s, sign * w) for s in (S1, S2) for sign in (1, -1)}


def test_the_error_of_two_reals_is_the_larger_distance() -> None:
    simple = np.array([S1 - 0.01, S2 - 0.2, MEAN + 1.1j, MEAN - 1.1j, MEAN + 2.1j, MEAN - 2.1j])
    mode = matched(locked_state(1.0, S1, S2), simple, (-1, 0, 1))["regressing"]
    assert mode.error == pytest.approx(0.2 / math.sqrt((S1**2 + S2**2) / 2), rel=1e-12)


def test_teetering_locks() -> None:
    orders = mode_orders(1, "teetering")
    for rho, rules in ((1.0, (Rule.REALS, Rule.MEAN)), (0.0, (Rule.JOINT, Rule.JOINT))):
        simple = np.array([MEAN + 1j * sign * (0.1 + abs(rho + k)) for k in orders for sign in (1, -1)])
        assert tuple(m.rule for m in matched(locked_state(rho, S1, S2), simple, orders).modes) == rules


def test_pairing_is_the_cheapest_of_all() -> None:
    """Against every permutation, at points inside and outside locks."""
    for gamma, mu in ((8.0, 0.3), (12.0, 0.4), (7.12, 0.3), (16.0, 0.5), (4.0, 0.9)):
        modes = [
            m for m in compare(Rotor(lock_number=gamma, hinge_stiffness=0.1), mu).modes if m.name != "differential"
        ]
        exact, simple = (np.concatenate([getattr(m, part) for m in modes]) for part in ("exact", "simple"))
        cost = np.abs(exact[:, None] - simple[None, :])
        best = min(sum(cost[i, p] for i, p in enumerate(order)) for order in permutations(range(6)))
        assert np.abs(exact - simple).sum() == pytest.approx(best, rel=1e-9)


def test_pairs_stay_whole() -> None:
    """A mode's two simple eigenvalues are conjugates or both real, however many reals there are."""
    reals = 0
    for gamma in (9.374, 16.0, 20.0, 24.0):
        for mode in compare(Rotor(lock_number=gamma), np.linspace(0.0, 1.5, 301)).modes:
            whole = np.isclose(mode.simple[:, 0], np.conj(mode.simple[:, 1])) | np.all(mode.simple.imag == 0, axis=-1)
            assert np.all(whole), (gamma, mode.name)
            reals += np.sum(np.all(mode.simple.imag == 0, axis=-1))
    assert reals > 100


def test_reals_are_put_in_the_nearest_twos() -> None:
    """Two overdamped modes inside one another: neighbours would be the wrong pairs."""
    simple = np.array([-0.3, -2.6, -1.0, -1.4, MEAN + 2j, MEAN - 2j])
    targets = np.array([[-0.32, -2.5], [-1.1, -1.3], [MEAN + 2.1j, MEAN - 2.1j]])
    np.testing.assert_array_equal(assigned(targets, simple), [[-0.3, -2.6], [-1.0, -1.4], [MEAN + 2j, MEAN - 2j]])


def test_errors_are_continuous_into_a_lock() -> None:
    """Sets are compared, so that nothing jumps where a lock begins (a square root, no step)."""
    for gamma, edge in ((12.0, 0.21438233322949), (8.0, 0.826844869530709)):
        outside, inside = compare(Rotor(lock_number=gamma), np.array([edge - 1e-9, edge + 1e-9])).modes[0].error
        assert outside == pytest.approx(inside, abs=1e-3)


def test_a_joint_pair_is_named_by_the_simple_frequencies() -> None:
    c = compare(Rotor(lock_number=12.0), 0.3)
    assert c.stability.lock == 0.5
    assert np.abs(c["regressing"].simple.imag).max() < np.abs(c["coning"].simple.imag).min()


# ---------------------------------------------------------------------- causes
@pytest.mark.parametrize(
    ("rotor", "mu", "cause"),
    [
        (Rotor(lock_number=8.0), 0.3, Cause.DRIFT),
        (Rotor(lock_number=12.0), 0.3, Cause.LOCK),
        (Rotor(lock_number=9.374, hinge_stiffness=0.0516), 0.7, Cause.TPP_SPLIT),
        (Rotor(lock_number=7.12, hinge_stiffness=0.1932311), 0.39, Cause.DRIFT_IN_LOCK),
        (Rotor(lock_number=8.0), 1.4, Cause.STABILITY),
    ],
)
def test_causes(rotor: Rotor, mu: float, cause: Cause) -> None:
    assert compare(rotor, mu)["regressing"].cause == cause


# ---------------------------------------------------------------------- shapes and bad input
def test_arrays_and_scalars_agree() -> None:
    mu = np.array([0.1, 0.3, 0.9])
    many = compare(Rotor(lock_number=np.array([[6.0], [12.0]])), mu)
    assert (
        many["coning"].exact.shape == (2, 3, 2)
        and many["coning"].errors.shape == (2, 3, 4)
        and many["coning"].rule.shape == (2, 3)
    )
    for i, gamma in enumerate((6.0, 12.0)):
        for j, m in enumerate(mu):
            one = compare(Rotor(lock_number=gamma), float(m))
            assert isinstance(one["coning"].error, float) and isinstance(one["coning"].rule, Rule)
            for mode in one.modes:
                np.testing.assert_array_equal(many[mode.name].exact[i, j], mode.exact)
                np.testing.assert_array_equal(many[mode.name].errors[i, j], mode.errors)


def test_exact_side_is_the_blade() -> None:
    rotor = Rotor(lock_number=9.0, hinge_offset=0.1)
    assert (
        compare(rotor, 0.4, exact_offset=True).stability.rotation_number
        == stability(flapping(rotor, 0.4, exact_offset=True)).rotation_number
    )


def test_bad_input_is_one_sentence() -> None:
    rotor = Rotor(lock_number=8.0)
    with pytest.raises(ParameterError, match="did you mean 'regressing'"):
        compare(rotor, 0.3)["regresing"]
    with pytest.raises(ParameterError, match="did you mean 'teetering'"):
        compare(rotor, 0.3, model="tetering")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="did you mean 'tip_loss'"):
        compare(rotor, 0.3, tip_los=0.97)  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match=r"eq\. \(7\), only"):
        compare(TEETERING, 0.3, harmonics=2)
    with pytest.warns(FloquetWarning, match="2 blades"):
        compare(Rotor(lock_number=8.0, blades=2), 0.3)


def test_no_rotor_has_no_modes_to_compare() -> None:
    found = compare(Rotor(lock_number=np.zeros(0)), 0.3)
    assert found["regressing"].error.shape == (0,) and found["coning"].exact.shape == (0, 2)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"rotor": "x"}, "'x' is no Rotor: make one"),
        ({"harmonics": "x"}, "'x' is not a whole number"),
        ({"check": "x"}, "neither True nor False"),
        ({"advance_ratio": None}, "no advance ratio was given: give"),
        ({"advance_ratio": [0.3, None]}, "nan is no advance ratio: look for a missing value"),
    ],
)
def test_what_cannot_be_compared_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        compare(**{"rotor": Rotor(lock_number=8.0), "advance_ratio": 0.3, **given})
