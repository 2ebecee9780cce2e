"""Periodic matrices against the functions they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from floquet.errors import ParameterError
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
