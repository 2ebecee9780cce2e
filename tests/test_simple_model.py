"""Eigenvalues of the simple model, its pairs and its errors: by other arithmetic, by brute force, and compiled."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from floquet import comparison
from floquet.comparison import Cause, Metric, Rule, compare, differential, eigenvalues, mode_orders, simple_model
from floquet.kernels import available, pairing, quadratics
from floquet.kernels.pairing import _in_lanes, _on_arrays, paired
from floquet.kernels.quadratics import LOST, by_lapack, in_order, roots
from floquet.models import averaged, flapping, tip_path_plane
from floquet.periodic import PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor

EPS = float(np.finfo(float).eps)
DIGITS = 60
needs_numba = pytest.mark.skipif(not available(), reason="numba is not there, or not to be used")
kinds = pytest.mark.parametrize("teeters", [False, True], ids=["articulated", "teetering"])


def rotors(n: int, gamma: tuple[float, float] = (2.0, 24.0), *, teeters: bool = False, seed: int = 0) -> Rotor:
    """Random designs."""
    rng = np.random.default_rng(seed)
    values: dict[str, Any] = {
        "lock_number": rng.uniform(*gamma, n),
        "hinge_stiffness": rng.uniform(0.0, 0.5, n),
        "pitch_flap_coupling": rng.uniform(-0.5, 0.5, n),
    }
    if teeters:
        return Rotor(blades=2, hub=Hub.TEETERING, **values)
    return Rotor(hinge_offset=rng.uniform(0.0, 0.2, n), **values)


def matrices(rotor: Rotor, mu: Any) -> tuple[Any, Any]:
    """D and K of the tip-path plane, (n², points)."""
    plane = tip_path_plane(rotor, mu)
    assert plane.damping is not None and plane.stiffness is not None
    points = math.prod(plane.cases)
    D, K = (np.broadcast_to(m.mean(), (*plane.cases, *m.shape)) for m in (plane.damping, plane.stiffness))
    return tuple(np.moveaxis(m, (-2, -1), (0, 1)).reshape(-1, points).copy() for m in (D, K))  # type: ignore[return-value]


def exact_roots(D: Any, K: Any) -> list[Any]:
    """Roots of det(s² + D s + K) in 60 digits, for one point: the sum over all permutations, then Durand–Kerner."""
    n = math.isqrt(len(D))
    with mpmath.workdps(DIGITS):
        total = [mpmath.mpf(0)] * (2 * n + 1)
        for order in permutations(range(n)):
            sign = np.linalg.det(np.eye(n)[list(order)])
            product = [mpmath.mpf(round(sign))]
            for i, j in enumerate(order):
                entry = [mpmath.mpf(float(K[n * i + j])), mpmath.mpf(float(D[n * i + j])), mpmath.mpf(i == j)]
                longer = [mpmath.mpf(0)] * (len(product) + 2)
                for a, x in enumerate(product):
                    for b, y in enumerate(entry):
                        longer[a + b] += x * y
                product = longer
            total = [a + b for a, b in zip(total, product, strict=True)]
        return list(mpmath.polyroots(total[::-1], maxsteps=500, extraprec=4 * DIGITS))


def errors_of(found: Any, exact: list[Any]) -> Any:
    """Distances to the exact roots assigned to them, with all their digits, and the sizes of these."""
    with mpmath.workdps(DIGITS):
        distance = np.array([[float(abs(mpmath.mpc(complex(z)) - w)) for w in exact] for z in found])
    _, to = linear_sum_assignment(distance)
    return distance[np.arange(len(found)), to], np.array([float(abs(exact[i])) for i in to])


def solved(D: Any, K: Any) -> tuple[Any, Any, Any]:
    """Eigenvalues, bounds and doubts as NumPy runs the arithmetic, for any number of points."""
    n, points = math.isqrt(len(D)), D.shape[1]
    q, z = np.empty((n, 3, points)), np.empty((2 * n, 2, 1, points))
    errors, doubt = np.empty((2 * n, 1, points)), np.empty((1, points))
    with np.errstate(all="ignore"):
        quadratics.solved(D[:, None], K[:, None], 0, q, quadratics.COSINES[n], z, errors, doubt)
    return z[:, 0, 0] + 1j * z[:, 1, 0], errors[:, 0], doubt[0]


def excess(found: Any, expected: Any, bounds: Any) -> float:
    """The largest distance of values (2n, points) over its bound; pairs of one frequency may come in either order."""
    worst = 0.0
    for z, w, b in zip(found.T, expected.T, bounds.T, strict=True):
        distance = np.abs(z[:, None] - w[None, :])
        worst = max(worst, *(distance[linear_sum_assignment(distance)] / b))
    return worst


# ---------------------------------------------------------------------- eigenvalues
@kinds
@pytest.mark.parametrize(
    ("gamma", "mu"), [((2.0, 16.0), 1.0), ((16.0, 24.0), 1.5), ((40.0, 80.0), 1.0), ((2.0, 20.0), 0.0)]
)
def test_eigenvalues_have_all_their_digits(teeters: bool, gamma: tuple[float, float], mu: float) -> None:
    """Random rotors against 60 digits: every root within its bound, and the bound no idle one."""
    n = 40
    D, K = matrices(rotors(n, gamma, teeters=teeters, seed=1), np.linspace(0.0, mu, n))
    values, bounds, doubt = solved(D, K)
    there = doubt <= LOST
    assert there.mean() > 0.8  # the others are LAPACK's
    for i in np.flatnonzero(there):
        error, size = errors_of(values[:, i], exact_roots(D[:, i], K[:, i]))
        assert np.all(error <= bounds[:, i])
        assert np.all(error <= 1e-13 * size + 1e-9 * bounds[:, i])
    assert np.median(bounds[:, there]) < 1e-12


@kinds
def test_eigenvalues_are_those_of_lapack(teeters: bool) -> None:
    """Thousands of points: within both bounds of another algorithm, conjugates and reals exact, all in order."""
    n = 3000
    D, K = matrices(rotors(n, teeters=teeters), np.random.default_rng(1).uniform(0.0, 1.5, n))
    values, bounds, doubt = solved(D, K)
    there = doubt <= LOST
    assert there.mean() > 0.99
    values, bounds = values[:, there], bounds[:, there]
    others, others_bounds = by_lapack(D[:, there], K[:, there])
    assert excess(values, others, bounds + others_bounds) <= 1.0
    np.testing.assert_array_equal(values, in_order(values.T).T)
    real = values.imag == 0.0
    for j in range(0, len(values), 2):
        np.testing.assert_array_equal(real[j], real[j + 1])
        conjugate = np.where(real[j], values[j], values[j + 1].conj())
        np.testing.assert_array_equal(values[j], conjugate)
    assert {0, 2, 4} <= set(np.sum(real, axis=0))


def split(rotor: Rotor, low: float, high: float) -> float:
    """The μ where a pair of the tip-path plane becomes real, to the last bit."""

    def reals(mu: float) -> int:
        return int(np.sum(solved(*matrices(rotor, np.array([mu])))[0].imag == 0.0))

    before = reals(low)
    assert reals(high) != before
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if reals(middle) == before else (low, middle)
    return low


@pytest.mark.parametrize(
    ("rotor", "low", "high"),
    [
        (Rotor(lock_number=12.0, hinge_offset=0.15), 0.1, 0.14),
        (Rotor(lock_number=10.0, hinge_offset=0.15), 0.28, 0.31),
        (Rotor(lock_number=9.374), 0.6, 0.63),
    ],
)
def test_a_pair_that_splits_is_known_to_its_bound(rotor: Rotor, low: float, high: float) -> None:
    """Around the split the bound goes through √eps, not beyond, and the roots stay within it."""
    edge = split(rotor, low, high)
    mu = edge + np.concatenate([[0.0], *(s * 10.0 ** np.arange(-16.0, -3.0) for s in (-1.0, 1.0))])
    D, K = matrices(rotor, mu)
    values, bounds, doubt = solved(D, K)
    assert np.all(doubt <= LOST)  # the factor is as good as any
    assert 1e-9 < bounds.max() < 3e-7  # √(eps · permanent)
    for i in range(len(mu)):
        error, _ = errors_of(values[:, i], exact_roots(D[:, i], K[:, i]))
        assert np.all(error <= bounds[:, i])


def test_pairs_that_meet_are_left_to_lapack() -> None:
    """Hover at ρ = ½ (γ = 8√3): regressing and coning are one; at γ = 16 all pairs are double.

    The polynomial knows double roots to √eps only; LAPACK sees that coning is a block of its own.
    """
    gamma = np.array([8.0 * math.sqrt(3.0), 16.0, 8.0])
    D, K = matrices(Rotor(lock_number=gamma), np.zeros(3))
    *_, doubt = solved(D, K)
    assert list(doubt <= LOST) == [False, False, True]
    found, found_bounds = by_lapack(D, K)
    rate = np.sqrt((gamma / 16.0) ** 2 - 1.0 + 0j)
    expected = np.stack([-gamma / 16.0 + s * rate + 1j * k for s in (1, -1) for k in (-1, 0, 1)])
    assert excess(found, expected, found_bounds) <= 1.0
    assert excess(found[:, :1], expected[:, :1], np.full((6, 1), 1e-14)) < 1.0
    assert found_bounds[:, 1].max() > 1e-8  # Jordan blocks


@pytest.mark.parametrize(
    ("D", "K", "expected"),
    [
        (np.zeros((3, 3)), np.diag([1.0, 4.0, 9.0]), [1j, 2j, 3j]),
        (np.diag([3.0, 5.0]), np.diag([2.0, 4.0]), [-1.0, -2.0, -1.0, -4.0]),  # -1 twice
        (np.diag([3.0, 0.0, 1.0]), np.zeros((3, 3)), [0.0, -3.0, 0.0, 0.0, 0.0, -1.0]),  # no stiffness: 0 four times
        (np.diag([0.0, 0.0, 2e4]), np.diag([1.0, 1e-8, 1.0]), [1j, 1e-4j, -5.0000000125e-5, -19999.99995]),
        (np.array([[0.0, 2.0], [-2.0, 0.0]]), np.diag([-1.0, -1.0]), [1j, 1j]),  # a gyroscope, double
    ],
)
def test_degenerate_systems(D: Any, K: Any, expected: list[complex]) -> None:
    """Undamped, without stiffness, stiff, double: whoever solves it, the eigenvalues are within their bounds."""
    wanted = np.array([w for z in expected for w in ((z, np.conj(z)) if np.imag(z) else (z,))])
    d, k = D.reshape(-1, 1), K.reshape(-1, 1)
    values, bounds, doubt = solved(d, k)
    if not doubt[0] <= LOST:
        values, bounds = by_lapack(d, k)
    assert excess(values, wanted[:, None], bounds + 1e-12 * np.abs(wanted).max()) <= 1.0  # 1e-12: the digits above


def test_overflow_is_an_error_of_lapack_and_no_number() -> None:
    D, K = np.full((4, 1), np.nan), np.ones((4, 1))
    assert np.isnan(solved(D, K)[2][0])
    with pytest.raises(np.linalg.LinAlgError):
        by_lapack(D, K)


# ---------------------------------------------------------------------- compiled
@needs_numba
@kinds
def test_compiled_eigenvalues_are_numpys(teeters: bool) -> None:
    """The same arithmetic but for fused multiply-adds: within both bounds, and next to nothing of them mostly."""
    from floquet.kernels import blocks

    n = 2001  # no whole number of blocks
    D, K = matrices(rotors(n, teeters=teeters), np.random.default_rng(2).uniform(0.0, 1.2, n))
    values, bounds, doubt = solved(D, K)
    z, errors, doubts = blocks.solve(D, K, quadratics.COSINES[2 if teeters else 3])
    there = (doubt <= LOST) & (doubts <= LOST)
    assert there.mean() > 0.99
    compiled = z[:, 0] + 1j * z[:, 1]
    assert excess(values[:, there], compiled[:, there], (bounds + errors)[:, there]) <= 1.0
    assert np.median(np.abs(values - compiled)[:, there] / bounds[:, there]) < 0.03
    a, b = (np.sort(x[:, there], axis=0) for x in (errors, bounds))
    np.testing.assert_allclose(a, b, rtol=0.5)  # g is rounding, which is not the same


@needs_numba
def test_many_points_are_the_few_to_rounding() -> None:
    """compare() of thousands and of tens: the compiled path and LAPACK's; rules and causes are the same."""
    rotor, mu = rotors(2048, (2.0, 16.0), seed=3), np.random.default_rng(3).uniform(0.0, 1.2, 2048)
    many = compare(rotor, mu)
    for i in (0, 700, 2000):
        few = compare(rotor[i : i + 40], mu[i : i + 40])
        for mode, other in zip(many.modes, few.modes, strict=True):
            part = slice(i, i + 40)
            np.testing.assert_allclose(mode.exact[part], other.exact, atol=1e-12)
            np.testing.assert_allclose(mode.simple[part], other.simple, atol=1e-10)  # √ of rounding next to splits
            np.testing.assert_allclose(mode.errors[part], other.errors, atol=1e-8, rtol=1e-8)
            np.testing.assert_array_equal(mode.rule[part], other.rule)
            np.testing.assert_array_equal(mode.cause[part], other.cause)


def test_without_numba_lapack_does_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (comparison, pairing):
        monkeypatch.setattr(module, "worth_compiling", lambda points: False)
    monkeypatch.setattr(comparison, "roots", None)
    found = compare(rotors(1500, seed=5), np.linspace(0.0, 1.0, 1500))
    assert found["coning"].errors.shape == (1500, 4)


@needs_numba
def test_bits_do_not_depend_on_neighbours() -> None:
    """Points in another order, among others, and in another number: the same bits."""
    rng = np.random.default_rng(4)
    D, K = matrices(rotors(5000, (2.0, 40.0), seed=4), rng.uniform(0.0, 1.5, 5000))
    values, bounds = roots(D, K)
    some = rng.permutation(5000)[:2500]
    again, again_bounds = roots(D[:, some], K[:, some])
    assert again.tobytes() == values[:, some].tobytes() and again_bounds.tobytes() == bounds[:, some].tobytes()
    state, z = states(5000)
    whole, part = paired(state, z, (-1, 0, 1)), paired(state[:, some], z[:, some], (-1, 0, 1))
    for one, other in zip(whole, part, strict=True):
        assert one[..., some].tobytes() == other.tobytes()


# ---------------------------------------------------------------------- pairs
def states(n: int, modes: int = 3, seed: int = 0) -> tuple[Any, Any]:
    """Random exact exponents in and out of every lock, and simple eigenvalues in order, some of them real."""
    rng = np.random.default_rng(seed)
    lock = rng.choice([np.nan, np.nan, 0.0, 0.5, 1.0, 1.5, 2.0], n)
    rho = np.where(np.isnan(lock), rng.uniform(0.0, 2.2, n), lock)
    first = rng.uniform(-1.0, 0.3, n)
    state = np.stack([first, np.where(np.isnan(lock), first, first - rng.uniform(0.0, 1.0, n)), rho, lock])
    pairs = []
    for _ in range(modes):
        re, im, real = rng.uniform(-2.0, 0.3, (2, n)), rng.uniform(0.05, 3.0, n), rng.random(n) < 0.4
        pairs += [np.where(real, re[0], re[0] - 1j * im), np.where(real, re[1], re[0] + 1j * im)]
    return state, in_order(np.stack(pairs, axis=-1)).T


def twos(values: list[complex]) -> Iterator[list[tuple[complex, complex]]]:
    """Every way to put values in whole pairs: conjugates stay together, reals join any other."""
    if not values:
        yield []
        return
    first, rest = values[0], values[1:]
    for i, second in enumerate(rest):
        if (first.imag == 0.0 == second.imag) or second == first.conjugate():
            for others in twos(rest[:i] + rest[i + 1 :]):
                yield [(first, second), *others]


def targets(state: Any, k: int, modes: tuple[int, ...]) -> tuple[complex, complex, Rule]:
    """The rules as the docstring of floquet.comparison states them."""
    s1, s2, rho, lock = state
    if math.isnan(lock):
        return complex(s1, rho + k), complex(s2, -rho - k), Rule.PAIRED
    mirror = -2.0 * lock - k
    if mirror == k:
        return complex(s1), complex(s2), Rule.REALS
    if mirror in modes:
        sigma = s1 if k > mirror else s2
        return complex(sigma, rho + k), complex(sigma, -rho - k), Rule.JOINT
    return complex(0.5 * (s1 + s2), rho + k), complex(0.5 * (s1 + s2), -rho - k), Rule.MEAN


def cheapest(aims: list[tuple[complex, complex]], values: list[complex]) -> list[tuple[complex, complex]]:
    """By trying everything."""
    best, found = math.inf, []
    for pairs in twos(values):
        for order in permutations(pairs):
            turned = [min((p, p[::-1]), key=lambda p, a=a: cost(a, p)) for a, p in zip(aims, order, strict=True)]
            if (total := sum(cost(a, p) for a, p in zip(aims, turned, strict=True))) < best - 1e-12:
                best, found = total, turned
    return found


def cost(aim: tuple[complex, complex], pair: tuple[complex, complex]) -> float:
    return abs(aim[0] - pair[0]) + abs(aim[1] - pair[1])


@pytest.mark.parametrize("modes", [(0,), (-1, 1), (-1, 0, 1)])
def test_pairing_against_everything_tried(modes: tuple[int, ...]) -> None:
    """Rules, targets and the least total distance, at 300 random points in and out of every lock."""
    state, values = states(300, len(modes), seed=len(modes))
    found = paired(state, values, modes)
    seen = set()
    for i in range(state.shape[1]):
        aims = [targets(state[:, i], k, modes) for k in modes]
        assert [Rule(r) for r in found.rule[:, i]] == [rule for *_, rule in aims]
        best = cheapest([(a, b) for a, b, _ in aims], [complex(z) for z in values[:, i]])
        total = sum(cost((a, b), p) for (a, b, _), p in zip(aims, best, strict=True))
        joint = any(rule == Rule.JOINT for *_, rule in aims)
        exact, simple = found.exact[:, :, i], found.simple[:, :, i]
        assert np.abs(exact - simple).sum() == pytest.approx(total, rel=1e-8)  # ties count for 1e-9
        if not joint:
            np.testing.assert_array_equal(exact, [(a, b) for a, b, _ in aims])
        pairs = sorted(map(tuple, np.sort_complex(simple)), key=str)
        assert sorted(z for p in pairs for z in p) == sorted(map(complex, values[:, i]), key=lambda z: (z.real, z.imag))
        seen |= {int(np.sum(values[:, i].imag == 0.0))}
    assert max(seen) == 2 * len(modes)  # with all of them real


def test_errors_and_causes_by_their_definition() -> None:
    state, values = states(200, seed=7)
    found = paired(state, values, (-1, 0, 1))
    for i in range(200):
        for m in range(3):
            exact, simple = found.exact[m, :, i], found.simple[m, :, i]
            d, rms = simple - exact, lambda x: math.sqrt(np.mean(np.abs(x) ** 2))
            expected = {
                Metric.RELATIVE: np.abs(d).max() / rms(exact),
                Metric.ABSOLUTE: np.abs(d).max(),
                Metric.FREQUENCY: np.abs(d.imag).max() / rms(exact.imag) if rms(exact.imag) else math.inf,
                Metric.DAMPING: np.abs(d.real).max() / rms(exact.real),
            }
            if not np.any(d.imag) and not rms(exact.imag):
                expected[Metric.FREQUENCY] = 0.0
            np.testing.assert_allclose(found.errors[m, :, i], list(expected.values()), rtol=1e-13)
            locked, reals = not math.isnan(state[3, i]), not np.any(simple.imag)
            kind = (Cause.DRIFT_IN_LOCK if reals else Cause.LOCK) if locked else (
                Cause.TPP_SPLIT if reals else Cause.DRIFT
            )  # fmt: skip
            differs = (exact.real.max() > 0) != (simple.real.max() > 0)
            assert found.cause[m, i] == (Cause.STABILITY if differs else kind)


@needs_numba
@pytest.mark.parametrize("modes", [(0,), (-1, 1), (-1, 0, 1)])
def test_compiled_pairs_are_numpys(modes: tuple[int, ...]) -> None:
    """Targets, pairs, rules and causes to the last bit, errors to rounding."""
    state, values = states(3001, len(modes), seed=9)
    rows = np.stack([values.real, values.imag], axis=1)
    arrays, lanes = (f(state, rows, np.array(modes, float)) for f in (_on_arrays, _in_lanes))
    for k in (0, 1, 3):
        np.testing.assert_array_equal(arrays[k], lanes[k])
    np.testing.assert_allclose(arrays[2], lanes[2], rtol=1e-12, atol=1e-15)  # |z|² by fused multiply-adds


def test_what_overflowed_is_nan_and_nothing_else() -> None:
    state, values = states(64, seed=11)
    state[:, 5], state[:, 6] = np.nan, (np.nan, -0.5, 1.0, 1.0)  # all of it, and one of two reals
    found = paired(state, values, (-1, 0, 1))
    assert np.all(np.isnan(found.errors[:, :, 5])) and np.all(np.isnan(found.errors[0, :2, 6]))
    assert not np.any(np.isnan(np.delete(found.errors, [5, 6], axis=-1)))


# ---------------------------------------------------------------------- ties
def test_equal_totals_are_decided_by_the_larger_distance_not_by_rounding() -> None:
    """Both simple reals below both exact ones: straight and crossed cost the same, and the error is the smaller."""
    state = np.array([[-0.3], [-0.42], [1.0], [1.0]])
    others = [-0.36 - 1.1j, -0.36 + 1.1j, -0.36 - 2.1j, -0.36 + 2.1j]
    for noise in (0.0, 1e-15, -1e-15):
        values = np.array([-1.31 + noise, -0.45 - noise, *others])[:, None]
        found = paired(state, values, (-1, 0, 1))
        np.testing.assert_allclose(found.simple[0, :, 0].real, [-0.45, -1.31], atol=1e-14)
        assert found.errors[0, Metric.ABSOLUTE, 0] == pytest.approx(0.89, abs=1e-13)


def test_two_pairs_of_one_frequency_do_not_change_places_by_rounding() -> None:
    """The teetering plane where its modes have met: the less damped pair is the advancing one."""
    state = np.array([[-0.94], [-0.94], [0.163], [np.nan]])
    for noise in (0.0, 1e-15, -1e-15):
        slow, fast = -0.5 + 1j * (0.908 + noise), -1.38 + 0.908j
        values = in_order(np.array([slow, slow.conjugate(), fast, fast.conjugate()]))[:, None]
        found = paired(state, values, (-1, 1))
        assert found.simple[0].real.max() < -1.0 < found.simple[1].real.min()


# ---------------------------------------------------------------------- many modes, other systems
def test_averaged_models_of_many_modes_keep_the_least_total() -> None:
    """Nine harmonics: by SciPy's assignment of single eigenvalues, which can cost no more."""
    rotor = Rotor(lock_number=8.0)
    c = compare(rotor, np.array([0.2, 0.5]), harmonics=9)
    modes = [m for m in c.modes if m.name != "differential"]
    assert len(modes) == len(mode_orders(9, "flapping")) == 19
    for i in range(2):
        exact, simple = (np.concatenate([getattr(m, part)[i] for m in modes]) for part in ("exact", "simple"))
        rows, columns = linear_sum_assignment(np.abs(exact[:, None] - simple[None, :]))
        least = np.abs(exact[rows] - simple[columns]).sum()
        assert np.abs(exact - simple).sum() == pytest.approx(least, rel=1e-9)


def test_other_constant_systems_are_lapacks() -> None:
    """A first-order system, and one of a single coordinate."""
    first = PeriodicSystem(period=math.nan, matrix=PeriodicMatrix.constant(np.array([[-1.0, 2.0], [-2.0, -1.0]])))
    np.testing.assert_allclose(eigenvalues(first), [-1.0 - 2.0j, -1.0 + 2.0j], atol=1e-15)
    single = PeriodicSystem(
        period=math.nan,
        damping=PeriodicMatrix.constant(np.full((2000, 1, 1), 3.0)),
        stiffness=PeriodicMatrix.constant(np.full((2000, 1, 1), 2.0)),
    )
    np.testing.assert_allclose(eigenvalues(single), np.tile([-2.0, -1.0], (2000, 1)), atol=1e-14)


@kinds
def test_cases_keep_their_axes(teeters: bool) -> None:
    """A grid of rotors and advance ratios through the path of many points."""
    rotor = Rotor(lock_number=np.linspace(4.0, 12.0, 40)[:, None], blades=2 if teeters else 4,
                  hub=Hub.TEETERING if teeters else Hub.ARTICULATED)  # fmt: skip
    mu = np.linspace(0.05, 0.9, 50)
    found = compare(rotor, mu)
    assert found["regressing"].simple.shape == (40, 50, 2) and found["regressing"].cause.shape == (40, 50)
    one = compare(Rotor(lock_number=float(rotor.lock_number[7, 0]), blades=rotor.blades, hub=rotor.hub), float(mu[31]))
    for mode in one.modes:
        np.testing.assert_allclose(found[mode.name].simple[7, 31], mode.simple, atol=1e-13)


# ---------------------------------------------------------------------- projection
@pytest.mark.parametrize(
    "options", [{}, {"reversed_flow": True}, {"reversed_flow": True, "exact_offset": True, "tip_loss": 0.97}]
)
@pytest.mark.parametrize("harmonics", [1, 3])
def test_projection_is_the_mean_of_the_product(options: dict[str, Any], harmonics: int) -> None:
    """t⁺(2t' + d t) and t⁺(t'' + d t' + k t), multiplied out, then averaged."""
    rotor = Rotor(lock_number=np.array([5.0, 11.0]), hinge_offset=0.07, pitch_flap_coupling=0.3, root_cutout=0.15)
    mu = np.array([0.4, 1.2])
    system, one = averaged(rotor, mu, harmonics, **options), flapping(rotor, mu, **options)
    rows = [PeriodicMatrix.constant([[1.0]])]
    rows += [PeriodicMatrix.harmonic(n, [[1.0, 0.0]], [[0.0, 1.0]]) for n in range(1, harmonics + 1)]
    t = PeriodicMatrix.assemble([rows])
    plus = PeriodicMatrix.constant(np.diag([1.0] + [2.0] * (2 * harmonics))) @ t.transpose()
    d, k = one.damping, one.stiffness
    assert d is not None and k is not None and system.damping is not None and system.stiffness is not None
    D = plus @ (2.0 * t.derivative() + d @ t)
    K = plus @ (t.derivative().derivative() + d @ t.derivative() + k @ t)
    for found, expected in ((system.damping, D), (system.stiffness, K)):
        np.testing.assert_allclose(found.mean(), expected.mean(), atol=2e-14)  # eps of harmonics up to 9


def test_differential_coning_is_the_constant_equation() -> None:
    rotor = Rotor(lock_number=8.0, blades=4)
    plane = simple_model(rotor, np.asarray(0.3))
    found = differential(plane, rotor, "flapping")
    assert found is not None and plane.damping is not None and plane.stiffness is not None
    c, k = plane.damping.mean()[0, 0], plane.stiffness.mean()[0, 0]
    np.testing.assert_allclose(found * found + c * found + k, 0.0, atol=4 * EPS)


@pytest.mark.parametrize("shift", [0.0, 0.1])
def test_discs_that_touch_reach_all_over_one_another(shift: float) -> None:
    """Three pairs; two of them within their bounds of one another, or all three in a row, or none."""
    centre = np.array([-1.0 + 1.0j, -1.0 + 1.2j + shift, -1.0 + 3.0j])
    values = np.ravel(np.stack([centre, centre.conj()], axis=1))
    for bounds, touching in ((0.09, []), (0.105, [0, 1]), (1.0, [0, 1, 2])):
        z = np.stack([values.real, values.imag], axis=1)[:, :, None].copy()
        errors, q = np.full((6, 1), bounds), np.empty((3, 3))
        quadratics.joined(z, errors, 0, q)
        if shift and bounds < 0.11:
            touching = []
        expected = np.full(6, bounds)
        for i in touching:
            expected[2 * i : 2 * i + 2] = (4 * len(touching) - 1) * bounds
        np.testing.assert_allclose(errors[:, 0], expected, rtol=1e-14)
