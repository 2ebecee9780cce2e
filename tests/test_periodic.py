"""Periodic matrices against the functions they stand for."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.periodic import TWO_PI, PeriodicMatrix, PeriodicSystem

PSI = np.linspace(0.0, TWO_PI, 23)[:-1] + 0.05
ROUNDING = 1e-14  # sums of a few terms of order one


def random_matrix(rng: np.random.Generator, n: int, m: int, order: int) -> PeriodicMatrix:
    total = PeriodicMatrix.constant(rng.normal(size=(n, m)))
    for h in range(1, order + 1):
        total = total + PeriodicMatrix.harmonic(h, rng.normal(size=(n, m)), rng.normal(size=(n, m)))
    return total


def random_pieces(rng: np.random.Generator, n: int, m: int, edges: list[float]) -> PeriodicMatrix:
    return PeriodicMatrix.pieces([random_matrix(rng, n, m, 2) for _ in edges[:-1]], edges)


@pytest.fixture(params=["smooth", "pieces", "both"])
def pair(request: pytest.FixtureRequest) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    rng = np.random.default_rng(1)
    a = random_matrix(rng, 2, 3, 2) if request.param == "smooth" else random_pieces(rng, 2, 3, [0.0, 1.0, 4.0, TWO_PI])
    b = random_pieces(rng, 3, 2, [0.0, 2.5, TWO_PI]) if request.param == "both" else random_matrix(rng, 3, 2, 3)
    return a, b


def test_product_sum_and_transpose_are_those_of_the_samples(pair: tuple[PeriodicMatrix, PeriodicMatrix]) -> None:
    a, b = pair
    np.testing.assert_allclose((a @ b).sample(PSI), a.sample(PSI) @ b.sample(PSI), atol=20 * ROUNDING)
    np.testing.assert_allclose(
        (a + b.transpose()).sample(PSI), a.sample(PSI) + np.swapaxes(b.sample(PSI), -1, -2), atol=ROUNDING
    )
    np.testing.assert_allclose((a - 2.0 * a).sample(PSI), -a.sample(PSI), atol=ROUNDING)
    np.testing.assert_array_equal((a * 2.0).sample(PSI), (2.0 * a).sample(PSI))


def test_shift_and_derivative(pair: tuple[PeriodicMatrix, PeriodicMatrix]) -> None:
    a, _ = pair
    np.testing.assert_allclose(a.shifted(1.3).sample(PSI), a.sample(np.mod(PSI + 1.3, TWO_PI)), atol=ROUNDING)
    h = 1e-5
    inside = PSI[np.min(np.abs(PSI[:, None] - np.array([0.0, 1.0, 4.0, TWO_PI])), axis=1) > 2 * h]
    slope = (a.sample(inside + h) - a.sample(inside - h)) / (2 * h)
    np.testing.assert_allclose(
        a.derivative().sample(inside), slope, atol=1e-8
    )  # central difference, h²·a'''/6 and eps/h


def test_mean_is_the_integral_over_the_period(pair: tuple[PeriodicMatrix, PeriodicMatrix]) -> None:
    a, _ = pair
    points = None if a.edges is None else list(a.edges[1:-1])
    value = quad(lambda t: a.sample(np.array([t]))[0, 1, 2], 0.0, TWO_PI, points=points, epsabs=1e-13)[0]
    assert a.mean()[1, 2] == pytest.approx(value / TWO_PI, abs=1e-13)


def test_bound_is_above_every_sample(pair: tuple[PeriodicMatrix, PeriodicMatrix]) -> None:
    a, _ = pair
    assert np.all(np.abs(a.sample(PSI)).max(axis=0) <= a.bound())


def test_jumps_are_the_differences_at_the_edges() -> None:
    a = random_pieces(np.random.default_rng(2), 1, 1, [0.0, 1.0, 4.0, TWO_PI])
    t = 1e-9
    expected = [
        a.sample(np.array([e + t]))[0] - a.sample(np.array([np.mod(e - t, TWO_PI)]))[0] for e in (0.0, 1.0, 4.0)
    ]
    np.testing.assert_allclose(a.jumps(), expected, atol=1e-7)  # slope times 2t


def test_cases_broadcast() -> None:
    a = PeriodicMatrix.scalar(mean=np.array([1.0, 2.0]), sines=[np.array([[3.0], [4.0]])])
    assert a.cases == (2, 2)
    np.testing.assert_allclose(a.sample(np.array([0.5]))[1, 0, 0, 0, 0], 1.0 + 4.0 * math.sin(0.5), rtol=1e-15)
    assert a.case((1, 0)).sample(np.array([0.5])).shape == (1, 1, 1)


def test_assemble_places_the_blocks() -> None:
    rng = np.random.default_rng(3)
    a, b = random_matrix(rng, 1, 2, 1), random_matrix(rng, 2, 1, 2)
    whole = PeriodicMatrix.assemble([[a, None], [None, b]]).sample(PSI)
    np.testing.assert_array_equal(whole[:, 0, :2], a.sample(PSI)[:, 0])
    np.testing.assert_array_equal(whole[:, 1:, 2:], b.sample(PSI))
    assert not whole[:, 0, 2].any() and not whole[:, 1:, :2].any()


def test_different_periods_are_refused() -> None:
    with pytest.raises(ParameterError, match="cannot be combined"):
        PeriodicMatrix.constant([[1.0]]) + PeriodicMatrix.constant([[1.0]], period=math.pi)


@pytest.mark.parametrize("period", [0.0, -1.0, math.nan, math.inf])
def test_a_function_needs_a_period(period: float) -> None:
    with pytest.raises(ParameterError, match="no period"):
        PeriodicSystem.from_function(lambda t: [[0.0]], period)


def test_a_function_must_be_square_and_finite() -> None:
    system = PeriodicSystem.from_function(lambda t: [[0.0, 1.0]], 1.0)
    with pytest.raises(ParameterError, match="must be square"):
        system.sample(np.zeros(2))
    with pytest.raises(ParameterError, match="not finite"):
        PeriodicSystem.from_function(lambda t: [[1.0 / t if t else math.nan]], 1.0).sample(np.zeros(1))


def test_a_system_is_given_once() -> None:
    K = PeriodicMatrix.constant([[1.0]])
    with pytest.raises(ParameterError, match="exactly one"):
        PeriodicSystem(period=1.0, stiffness=K, matrix=K)


# ---------------------------------------------------------------------- what is refused, in a sentence
ONE, TWO = PeriodicMatrix.constant([[1.0]]), PeriodicMatrix.constant(np.eye(2))
WIDE = PeriodicMatrix.constant(np.ones((2, 3)))


def unit(t: float) -> list[list[float]]:
    return [[1.0]]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: PeriodicMatrix.constant([1.0, 2.0]), r"shape \(2,\) is no matrix: give"),
        (lambda: PeriodicMatrix.constant(1.0), "no matrix"),
        (lambda: PeriodicMatrix.constant("x"), "a str, 'x', was given; it must be real numbers"),
        (lambda: PeriodicMatrix.constant(None), "must be real numbers"),
        (lambda: PeriodicMatrix.constant(ONE), "must be real numbers"),
        (lambda: PeriodicMatrix.constant(np.array([["a"]], object)), "must be real numbers"),
        (lambda: PeriodicMatrix.constant([[1.0], [1.0, 2.0]]), "rows of unequal length"),
        (lambda: PeriodicSystem(period=1.0, matrix=1j * ONE), "of real equations: write x = u"),
        (lambda: PeriodicSystem(period=1.0, stiffness=np.array(1j, object) * ONE), "of real equations"),
        (lambda: PeriodicMatrix.constant([[1.0]], -1.0), "-1.0 is no period: give"),
        (lambda: PeriodicMatrix.constant([[1.0]], "x"), "'x' is no period"),
        (lambda: PeriodicMatrix([1.0]), "must be an array"),
        (lambda: PeriodicMatrix(np.ones(3)), r"an array of shape \(3,\) was given"),
        (lambda: PeriodicMatrix(np.ones((1, 2, 1, 1))), "2H"),
        (lambda: PeriodicMatrix(np.ones((1, 1, 1, 1)), 1.0, [0.0, 1.0]), "use PeriodicMatrix.pieces"),
        (lambda: PeriodicMatrix.harmonic(-1, [[1.0]], [[1.0]]), "-1 is no harmonic: give a whole number from 1"),
        (lambda: PeriodicMatrix.harmonic(0, [[1.0]], [[1.0]]), "0 is no harmonic"),
        (lambda: PeriodicMatrix.harmonic(1.5, [[1.0]], [[1.0]]), "1.5 is no harmonic"),
        (lambda: PeriodicMatrix.harmonic(1, [1.0], [1.0]), "no matrix"),
        (lambda: PeriodicMatrix.harmonic(1, 1.0, 1.0), "no matrix"),
        (lambda: PeriodicMatrix.harmonic(1, np.eye(2), np.eye(3)), "a sine of 3×3 was given beside a cosine of 2×2"),
        (lambda: PeriodicMatrix.harmonic(1, np.ones((2, 1, 1)), np.ones((3, 1, 1))), "do not broadcast"),
        (lambda: PeriodicMatrix.scalar(cosines=1.0), "write cosines="),
        (lambda: PeriodicMatrix.scalar(sines="ab"), "write sines="),
        (lambda: PeriodicMatrix.scalar(mean="a"), "mean: a str"),
        (lambda: PeriodicMatrix.scalar(mean=np.ones(2), cosines=[np.ones(3)]), "do not broadcast"),
        (lambda: PeriodicMatrix.assemble([]), "there is no block"),
        (lambda: PeriodicMatrix.assemble([[]]), "there is no block"),
        (lambda: PeriodicMatrix.assemble([[None, None], [ONE, ONE]]), "None only"),
        (lambda: PeriodicMatrix.assemble([[ONE, ONE], [ONE]]), "write None for a block of zeros"),
        (lambda: PeriodicMatrix.assemble([[ONE, TWO], [ONE, ONE]]), "a matrix of 2×2 stands where one of 1×2 fits"),
        (lambda: PeriodicMatrix.assemble([[np.eye(2)]]), "must be a PeriodicMatrix"),
        (lambda: ONE + np.eye(1), r"an array of shape \(1, 1\) was given; it must be a PeriodicMatrix"),
        (lambda: ONE @ np.eye(1), "must be a PeriodicMatrix"),
        (lambda: ONE + TWO, "a matrix of 2×2 stands where one of 1×1 fits"),
        (lambda: WIDE @ TWO, "stands where one of 3×2 fits"),
        (lambda: "a" * ONE, "must be real numbers"),
        (lambda: ONE * ONE, "must be real numbers"),
    ],
)  # fmt: skip
def test_a_matrix_that_is_none_is_refused(make: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        make()


def test_a_harmonic_may_have_no_sine() -> None:
    np.testing.assert_allclose(
        PeriodicMatrix.harmonic(2, np.eye(2), 0.0).sample(PSI),
        np.cos(2 * PSI)[:, None, None] * np.eye(2),
        atol=ROUNDING,
    )


@pytest.mark.parametrize(
    ("parts", "edges", "sentence"),
    [
        ([], [], "there is no piece"),
        ([ONE, ONE], [0.0, TWO_PI], "2 edges were given for 2 pieces: give 3, from 0 to 6.28319"),
        ([ONE, ONE], [0.0, 1.0, 2.0, TWO_PI], "4 edges were given for 2 pieces"),
        ([ONE, ONE], 1.0, "1 edges were given"),
        ([ONE, ONE], [0.0, 7.0, TWO_PI], "edges go up from 0"),
        ([ONE] * 3, [0.0, 3.0, 2.0, TWO_PI], "edges go up from 0"),
        ([ONE, ONE], [1.0, 2.0, TWO_PI], "edges go up from 0"),
        ([ONE, ONE], [0.0, 2.0, 3.0], "edges go up from 0"),
        ([ONE, ONE], [0.0, math.nan, TWO_PI], "edges go up from 0"),
        ([ONE, ONE], "abc", "must be real numbers"),
        ([np.eye(2)], [0.0, TWO_PI], "must be a PeriodicMatrix"),
        ([ONE, TWO], [0.0, 1.0, TWO_PI], "stands where one of 1×1 fits"),
        ([ONE, PeriodicMatrix.constant([[1.0]], 1.0)], [0.0, 1.0, TWO_PI], "have one period"),
        ([PeriodicMatrix.pieces([ONE, ONE], [0.0, 1.0, TWO_PI]), ONE], [0.0, 1.0, TWO_PI], "single ones"),
    ],
)
def test_pieces_that_do_not_make_a_period_are_refused(parts: Any, edges: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        PeriodicMatrix.pieces(parts, edges)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"period": "a", "stiffness": ONE}, "'a' is no period: give a positive angle"),
        ({"period": None, "stiffness": ONE}, "no period"),
        ({"period": 1j, "stiffness": ONE}, "no period"),
        ({"matrix": np.eye(2)}, r"matrix: an array of shape \(2, 2\) was given; it must be a PeriodicMatrix"),
        ({"stiffness": np.eye(2), "period": math.nan}, "must be a PeriodicMatrix"),
        ({"stiffness": ONE, "damping": [[1.0]]}, "damping: a list, .* must be a PeriodicMatrix"),
        ({"matrix": WIDE}, "2×3 was given; it must be square"),
        ({"matrix": PeriodicMatrix.constant(np.zeros((0, 0)))}, "0×0 was given"),
        ({"stiffness": ONE, "damping": TWO}, "damping: a matrix of 2×2 stands where one of 1×1 fits"),
        ({"matrix": TWO, "damping": TWO}, "damping goes with stiffness"),
        ({"matrix": TWO, "kinks": [1.0]}, "kinks go with a function"),
        (
            {"stiffness": PeriodicMatrix.scalar(mean=np.ones(2)), "damping": PeriodicMatrix.scalar(mean=np.ones(3))},
            "do not broadcast",
        ),
        ({"matrix": PeriodicMatrix(np.ones((2, 1, 1, 1)), TWO_PI, np.array([0.0, 7.0, TWO_PI]))}, "edges go up"),
        ({"matrix": PeriodicMatrix(np.ones((3, 1, 1, 1)), TWO_PI, np.array([0.0, 1.0, TWO_PI]))}, "3 edges were given"),
        ({"stiffness": ONE, "inputs": ONE}, "write inputs=lambda: F"),
        ({"function": 3.0}, "must be a function of t"),
        ({"function": unit, "period": math.nan}, "no period"),
        ({"function": unit, "kinks": [math.nan]}, "kinks are finite times"),
        ({"stiffness": TWO, "twist": [1.0, -1.0]}, "a twist is 4 numbers 1 or -1, one a state"),
        ({"matrix": TWO, "twist": [1.0, 2.0]}, "a twist is 2 numbers 1 or -1"),
        ({"matrix": TWO, "twist": np.eye(2)}, "a twist is 2 numbers"),
        ({"matrix": TWO, "twist": "a"}, "twist: a str"),
        ({"stiffness": TWO, "twist": [1, -1, -1, 1]}, "again for q'"),
        ({"matrix": PeriodicMatrix.constant(np.ones((2, 2))), "twist": [1, -1]}, "do not repeat .* with this twist"),
        ({"matrix": PeriodicMatrix.harmonic(1, np.eye(2), 0), "twist": [1, -1], "period": math.pi}, "with this twist"),
    ],
)  # fmt: skip
def test_a_malformed_system_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        PeriodicSystem(**{"period": TWO_PI, **given})


@pytest.mark.parametrize("order, period", [(0, TWO_PI), (1, math.pi), (2, TWO_PI)])
def test_a_twist_in_which_the_coefficients_repeat_is_kept(order: int, period: float) -> None:
    off = np.array([[0.0, 1.0], [1.0, 0.0]]) if order == 1 else np.eye(2)
    A = PeriodicMatrix.harmonic(order, off, 0.0) if order else PeriodicMatrix.constant(off)
    system = PeriodicSystem(period=period, matrix=A, twist=[1, -1])  # type: ignore[arg-type]
    np.testing.assert_array_equal(system.twist, [1.0, -1.0])


@pytest.mark.parametrize(
    ("A", "given", "sentence"),
    [
        (3.0, {}, "a float, 3.0, was given; it must be a function of t"),
        (ONE, {}, "give matrices by PeriodicSystem"),
        (unit, {"period": "a"}, "'a' is no period"),
        (unit, {"kinks": [math.nan]}, "kinks are finite times"),
        (unit, {"kinks": "a"}, "kinks: a str"),
        (lambda t: 1.0, {}, r"shape \(\): it must be square"),
        (lambda t: None, {}, "gave None, not a matrix: see whether"),
        (lambda t: None, {"vectorised": True}, "gave None"),
        (lambda t: 1.0, {"vectorised": True}, r"it must be square, \(…, times, n, n\)"),
        (lambda t: [1.0, 2.0], {}, "must be square"),
        (lambda t: np.zeros((0, 0)), {}, "must be square"),
        (lambda t: np.zeros((len(t), 0, 0)), {"vectorised": True}, "must be square"),
        (lambda t: [[1.0], [1.0, 2.0]], {}, "rows of unequal length"),
        (lambda t: "x", {}, "must be real numbers"),
        (lambda t: [[1j]], {}, "of real equations"),
        (lambda t: np.eye(2 if t < 0.5 else 3), {}, r"shapes \(2, 2\) and \(3, 3\): it must have one shape"),
    ],
)
def test_a_function_that_gives_no_matrix_is_refused(A: Any, given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        stability(PeriodicSystem.from_function(A, **{"period": 1.0, **given}))


@pytest.mark.parametrize("kinks", [0.5, [0.5], [1.5, -0.5], None, []])
def test_kinks_are_kept_within_the_period(kinks: Any) -> None:
    found = PeriodicSystem.from_function(unit, 1.0, kinks).kinks
    assert found is not None and found.tolist() == ([0.5] if kinks else [])
