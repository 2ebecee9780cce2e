"""Several states: panels by series and by collocation, exponents of many cases, against wide precision and truth."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import acb_mat, arb_mat, ctx

from floquet import Rotor, flapping, multiblade, stability
from floquet.exponents import Verdict, exponents
from floquet.exponents.products import eigenvalues as eigenvalues_of
from floquet.kernels import available
from floquet.models.textbook import colaneri, rotating_frame
from floquet.period_map import period_map, series
from floquet.period_map.collocated import Collocation
from floquet.period_map.factors import FactorMap
from floquet.period_map.series import Series
from floquet.periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from tests.support import distances
from tests.truth import extended

EPS = float(np.finfo(float).eps)
compiled = pytest.mark.skipif(not available(), reason="numba is not to be used")
wide = pytest.mark.skipif(not extended.available(), reason="long double is no longer than double")
LANES = pytest.param("lanes", marks=compiled)


def use(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Take one of the two paths, whatever the number of cases."""
    for module in ("period_map.factors", "exponents.products"):
        monkeypatch.setattr(f"floquet.{module}.worth_compiling", lambda points: path == "lanes")


@pytest.fixture
def lanes(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    if not available():
        pytest.skip("numba is not to be used")
    use("lanes", monkeypatch)
    yield


# ---------------------------------------------------------------------- systems
def blades(n: int, N: int, seed: int = 0) -> tuple[Rotor, np.ndarray]:
    rng = np.random.default_rng([seed, N])
    rotor = Rotor(
        lock_number=rng.uniform(2, 16, n),
        hinge_offset=rng.uniform(0, 0.2, n),
        hinge_stiffness=rng.uniform(0, 0.5, n),
        pitch_flap_coupling=rng.uniform(-0.5, 0.5, n),
        blades=N,
    )
    return rotor, rng.uniform(0, 1, n)


def rotating(F: Any) -> PeriodicSystem:
    """Φ(2π) = exp(2πF) for F (..., n, n) of any n, as trigonometric coefficients: J + e^{Jt} F e^{-Jt}."""
    n = np.shape(F)[-1]
    J, turn = np.zeros((n, n)), PeriodicMatrix.constant(np.diag(np.arange(n) >= n - n % 2).astype(float))
    for k in range(n // 2):
        pair, swap = np.zeros((n, n)), np.zeros((n, n))
        a, b = 2 * k, 2 * k + 1
        pair[a, a] = pair[b, b] = swap[b, a] = 1.0
        swap[a, b] = -1.0
        turn = turn + PeriodicMatrix.harmonic(k + 1, pair, swap)
        J += (k + 1) * swap
    A = PeriodicMatrix.constant(J) + turn @ PeriodicMatrix.constant(F) @ turn.transpose()
    return PeriodicSystem(period=TWO_PI, matrix=A)


def dyadic(F: Any) -> np.ndarray:
    """Rounded to 2⁻²⁰, so that the coefficients of :func:`rotating` are exact."""
    return np.round(np.asarray(F) * 2.0**20) / 2.0**20


def eigenvalues(F: np.ndarray) -> np.ndarray:
    """To forty digits and more (Arb)."""
    ctx.prec, before = 400, ctx.prec
    try:
        found = acb_mat(arb_mat(F.tolist())).eig(algorithm="approx")
        return np.array([complex(float(z.real), float(z.imag)) for z in found])
    finally:
        ctx.prec = before


def second_order(cases: int, N: int, harmonics: int, seed: int, size: float = 1.0) -> PeriodicSystem:
    rng = np.random.default_rng(seed)
    K = PeriodicMatrix.constant(0.5 * rng.normal(size=(cases, N, N)) + np.diag(rng.uniform(0.5, 4.0, N)))
    D = PeriodicMatrix.constant(0.3 * rng.normal(size=(cases, N, N)))
    for h in range(1, harmonics + 1):
        K = K + PeriodicMatrix.harmonic(h, *(size * rng.normal(size=(2, cases, N, N)) / h))
        D = D + PeriodicMatrix.harmonic(h, *(0.3 * size * rng.normal(size=(2, cases, N, N)) / h))
    return PeriodicSystem(period=TWO_PI, damping=D, stiffness=K)


def decaying(cases: int, n: int, rate: float) -> PeriodicSystem:
    """x' = -rate (1 + 0.3 cos t) x and little else: Y(-h) is much larger than Y(h)."""
    rng = np.random.default_rng(n)
    A = PeriodicMatrix.constant(-rate * np.eye(n) + 0.2 * rng.normal(size=(cases, n, n)))
    wave = PeriodicMatrix.harmonic(1, 0.3 * rate * np.eye(n) + 0.2 * rng.normal(size=(cases, n, n)), np.zeros((n, n)))
    return PeriodicSystem(period=TWO_PI, matrix=A + wave)


def stepped(cases: int, seed: int = 3) -> PeriodicSystem:
    """Two coordinates whose stiffness jumps, and has another slope, at an azimuth that each case has for itself."""
    rng = np.random.default_rng(seed)
    parts = [
        PeriodicMatrix.constant(np.diag([1.0, 2.0]) + 0.2 * rng.normal(size=(cases, 2, 2)))
        + PeriodicMatrix.harmonic(1, *(0.5 * rng.normal(size=(2, cases, 2, 2))))
        for _ in range(2)
    ]
    at = rng.uniform(0.3, 5.0, cases)
    edges = np.stack([np.zeros(cases), at, np.full(cases, TWO_PI)], axis=-1)
    return PeriodicSystem(
        period=TWO_PI,
        damping=PeriodicMatrix.constant([[0.1, 0.3], [-0.3, 0.2]]),
        stiffness=PeriodicMatrix.pieces(parts, edges),
    )


SYSTEMS = {
    "three blades": lambda: multiblade(*blades(24, 3)),
    "four blades": lambda: multiblade(*blades(24, 4)),
    "seven blades": lambda: multiblade(*blades(24, 7)),
    "two coordinates": lambda: second_order(24, 2, 2, 1),
    "five coordinates": lambda: second_order(24, 5, 1, 2),
    "odd": lambda: rotating(0.2 * np.random.default_rng(5).normal(size=(24, 5, 5))),
    "decay": lambda: decaying(24, 2, 10.0),
    "growth": lambda: decaying(24, 3, -3.0),
    "steps": lambda: stepped(24),
}


# ---------------------------------------------------------------------- maps of panels
def coefficients(system: PeriodicSystem) -> tuple[Any, dict[float, tuple[Any, Any]]]:
    """A₀ (cases, n, n) and C, S of every frequency, in long double, on one piece."""
    n, count = system.degrees, math.prod(system.cases)
    parts = [(system.matrix, 0, 0, 1)]
    A0 = np.zeros((count, system.states, system.states), np.longdouble)
    if system.second_order:
        parts = [(system.stiffness, n, 0, -1), (system.damping, n, n, -1)]
        A0[:, :n, n:] = np.eye(n)
    waves: dict[float, tuple[Any, Any]] = {}
    for part, top, left, sign in parts:
        assert part is not None
        block = (slice(None), slice(top, top + n), slice(left, left + n))
        c = np.broadcast_to(part.coefficients, (count, *part.coefficients.shape[-4:]))[:, 0]
        A0[block] += sign * c[:, 0]
        for h in range(1, part.order + 1):
            pair = waves.setdefault(h * (TWO_PI / part.period), (np.zeros_like(A0), np.zeros_like(A0)))
            for wave, row in zip(pair, (2 * h - 1, 2 * h), strict=True):
                wave[block] += sign * c[:, row]
    return A0, waves


def product(a: Any, b: Any) -> Any:
    return sum(a[:, :, k, None] * b[:, None, k, :] for k in range(a.shape[2]))


def wide_maps(system: PeriodicSystem, panels: int) -> Any:
    """Maps of all panels, (cases, panels, n, n), in 64-bit mantissas: from the start of each quarter by 32 terms."""
    A0, waves = coefficients(system)
    h = np.longdouble(system.period) / (4 * panels)
    out = []
    for k in range(4 * panels):
        start = k * h
        turned = {}
        for omega, (C, S) in waves.items():
            cosine, sine = np.cos(np.longdouble(omega) * start), np.sin(np.longdouble(omega) * start)
            turned[np.longdouble(omega)] = (cosine * C + sine * S, cosine * S - sine * C)
        A = [A0 + sum(C for C, _ in turned.values())]
        for j in range(1, 33):
            cycle = ((0, 1), (1, 1), (0, -1), (1, -1))[j % 4]
            A.append(sum(w**j * cycle[1] * pair[cycle[0]] / math.factorial(j) for w, pair in turned.items()) + 0 * A0)
        Y = [np.broadcast_to(np.eye(A0.shape[1], dtype=np.longdouble), A0.shape)]
        for j in range(32):
            Y.append(sum(product(A[i], Y[j - i]) for i in range(j + 1)) / (j + 1))
        step = sum(y * h**j for j, y in reversed(list(enumerate(Y))))
        out.append(step if k % 4 == 0 else product(step, out.pop()))
    return np.stack(out, axis=1)


def of_series(system: PeriodicSystem, panels: int) -> tuple[Any, Any, Any]:
    """Maps in (q, q'), and bounds on the scale of the series, and the scale of every case."""
    solver = Series(system)
    count, n = solver.values.shape[-1], solver.states
    maps, errors, _ = solver.maps(np.arange(count), [panels])
    scale = np.ones((count, n))
    if system.second_order:
        scale[:, n // 2 :] = solver.values[0, solver.layout.identity].T
    F = np.moveaxis(maps, -1, 1).reshape(-1, *maps.shape[1:4])[:count]
    return F, np.moveaxis(errors, -1, 1).reshape(-1, panels)[:count], scale


@wide
@compiled
@pytest.mark.parametrize("name", ["three blades", "four blades", "two coordinates", "odd", "decay", "growth"])
def test_maps_are_within_their_bounds_of_wide_precision(name: str) -> None:
    """Every panel of 24 systems, resolved and not; where it is resolved the bound is not idle."""
    system = SYSTEMS[name]()
    for panels in (3, math.ceil(Series(system).wanted.max())):
        F, bound, scale = of_series(system, panels)
        exact = wide_maps(system, panels) * scale[:, None, None, :] / scale[:, None, :, None]
        error = np.linalg.norm((F - exact).astype(float), 2, axis=(-2, -1))
        assert np.all(error <= bound)
    assert np.median(bound / error) < 30  # of the last, resolved: norms of sums and of products
    assert np.all(bound < 60 * EPS * (1.0 + np.linalg.norm(F, 2, axis=(-2, -1))) ** 2)


@wide
@compiled
@pytest.mark.parametrize("order", [4, 8, 12])
def test_series_is_of_its_order(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Panels half as long: errors fall by 2^(order+1), their bounds, of an order two less, by 2^(order-1)."""
    monkeypatch.setattr(series, "ORDER", order)
    system = second_order(20, 2, 1, 4)
    errors, bounds = [], []
    for panels in (12, 24):
        F, bound, scale = of_series(system, panels)
        exact = wide_maps(system, panels) * scale[:, None, None, :] / scale[:, None, :, None]
        errors.append(np.linalg.norm((F - exact).astype(float), 2, axis=(-2, -1)).max(axis=1))
        bounds.append(bound.max(axis=1))
    assert np.all(errors[0] < bounds[0]) and np.all(errors[1] < bounds[1])
    assert np.median(np.log2(errors[0] / errors[1])) > order + 0.8
    assert np.median(np.log2(bounds[0] / bounds[1])) > order - 1.2


@compiled
@pytest.mark.parametrize("name", list(SYSTEMS))
def test_series_and_collocation_agree(name: str) -> None:
    """Each within the bounds of both, panel by panel; kinks of each case included."""
    system = SYSTEMS[name]()
    first, second = Series(system), Collocation(system)
    count = math.ceil(first.wanted.max())
    counts = [count] * first.lengths.shape[-1]
    places = np.arange(24)
    maps, errors, _ = first.maps(places, counts)
    others, bounds, _ = second.maps(places, counts)
    F, e = (
        np.moveaxis(maps, -1, 1).reshape(-1, *maps.shape[1:4])[:24],
        np.moveaxis(errors, -1, 1).reshape(-1, len(bounds[0]))[:24],
    )
    scale = np.ones((24, first.states))
    if system.second_order:
        scale[:, first.states // 2 :] = first.values[0, first.layout.identity].T
    ratio = scale / second.scale  # both scales are powers of two
    moved = others[..., 0] * ratio[:, None, None, :] / ratio[:, None, :, None]
    stretch = (ratio.max(axis=1) / ratio.min(axis=1))[:, None]
    assert np.all(np.linalg.norm(F - moved, 2, axis=(-2, -1)) <= e + stretch * bounds[..., 0])


# ---------------------------------------------------------------------- exponents
@pytest.mark.parametrize("path", [LANES, "numpy"])
@pytest.mark.parametrize("n", [2, 3, 4, 6, 9, 14, 20])
@pytest.mark.parametrize("size", [0.1, 0.5, 2.0])
def test_truth_built_backwards(n: int, size: float, path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Multipliers within a decade, and dozens of decades apart: no error beyond its bound, bounds that are not idle."""
    if path == "numpy" and n > 6:
        pytest.skip("the same code, slower")
    use(path, monkeypatch)
    cases = 32 if n < 14 else 16
    F = dyadic(np.random.default_rng([n, int(10 * size)]).normal(size=(cases, n, n)) * size / math.sqrt(n))
    found = stability(rotating(F))
    error = np.stack([distances(eta, eigenvalues(f), 1.0) for eta, f in zip(found.exponents, F, strict=True)])
    assert np.all(error <= found.exponent_errors)
    assert np.median(found.exponent_errors / np.maximum(error, EPS)) < (500 if size < 1 else 3000)  # n = 20; by sweeps
    assert np.median(found.exponent_errors) < (3e-13 if size < 1 else 2e-12)
    assert found.determinant_defect.max() < 1e-12


@pytest.mark.parametrize("path", [LANES, "numpy"])
def test_graded_spectra_keep_their_digits(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exponents 0, -4, … -24 in coordinates that whole numbers mix: multipliers 65 decades apart."""
    use(path, monkeypatch)
    F, rng = [], np.random.default_rng(0)
    for _ in range(20):
        G = np.diag(-4.0 * np.arange(7))
        for i, j in rng.permutation(7)[:6].reshape(3, 2):
            G[i] += G[j]
            G[:, j] -= G[:, i]
        F.append(G)
    found = stability(rotating(np.array(F)))
    np.testing.assert_allclose(np.sort(found.exponents.real), np.tile(-4.0 * np.arange(7)[::-1], (20, 1)), atol=1e-12)
    assert np.all(np.abs(np.sort(found.exponents.real) + 4.0 * np.arange(7)[::-1]) <= found.exponent_errors.max())
    assert found.exponent_errors.max() < 1e-10


@pytest.mark.parametrize("path", [LANES, "numpy"])
def test_colaneri_to_thirteen_digits(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """0 and -24 (P. Colaneri), in eighteen cases at once."""
    use(path, monkeypatch)
    one = colaneri().matrix
    assert one is not None
    many = PeriodicSystem(period=TWO_PI, matrix=np.ones(18) * one)
    found = stability(many)
    error = np.abs(np.sort(found.exponents.real) - [-24.0, 0.0])
    assert error.max() < 1e-13 * 24 and np.all(error <= found.exponent_errors.max())


@pytest.mark.parametrize("path", [LANES, "numpy"])
@pytest.mark.parametrize("gap", [0.0, 2.0**-40, 2.0**-26, 2.0**-14])
def test_defective_and_nearly_defective_exponents(gap: float, path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """[a 1; gap a] beside other exponents: a ± √gap, within bounds that follow the square root."""
    use(path, monkeypatch)
    a, F = np.arange(-8, 9) / 32.0, np.zeros((17, 4, 4))
    F[:, 0, 0], F[:, 1, 1], F[:, 2, 2], F[:, 3, 3] = a, a, -0.5, 0.5
    F[:, 0, 1], F[:, 1, 0], F[:, 0, 2], F[:, 3, 1] = (
        1.0,
        gap,
        0.25,
        -0.25,
    )  # what is beside the block is triangular to it
    found = stability(rotating(F))
    exact = np.stack([a + math.sqrt(gap), a - math.sqrt(gap), np.full(17, -0.5), np.full(17, 0.5)], axis=-1)
    error = np.stack([distances(x, y, 1.0) for x, y in zip(found.exponents, exact, strict=True)])
    assert np.all(error <= found.exponent_errors)
    assert found.exponent_errors.max() < (1e-4 if gap == 0.0 else 1e-12 / math.sqrt(gap))


@pytest.mark.parametrize("path", [LANES, "numpy"])
@pytest.mark.parametrize("N", [2, 3, 4, 5, 6, 7])
def test_identical_blades_by_all_coordinates(N: int, path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twisted passages: the exponents of one blade, shifted by whole numbers."""
    use(path, monkeypatch)
    cases = 40 if path == "lanes" else 6
    rotor, mu = blades(cases, N, 1)
    blade = stability(flapping(rotor, mu))
    expected = (blade.exponents[:, :, None] + 1j * np.arange(N)).reshape(cases, -1)
    found = stability(multiblade(rotor, mu), symmetry=False)
    for k in range(cases):
        error = distances(found.exponents[k], expected[k], N)
        assert np.all(error <= found.exponent_errors[k] + blade.exponent_errors[k].max())
    assert np.median(found.exponent_errors) < (2e-13 if path == "lanes" else 1e-12)
    assert found.determinant_defect.max() < 1e-12


@pytest.mark.parametrize("path", [LANES, "numpy"])
@pytest.mark.parametrize("decay", [0.6, 8.0])
def test_half_a_period_with_a_twist_is_half_the_period(
    decay: float, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A(t + π) = S A(t) S, S = diag(1, -1, 1, -1): the exponents of 2π, multipliers near and far from each other."""
    use(path, monkeypatch)
    rng = np.random.default_rng(9)
    odd = np.indices((4, 4)).sum(axis=0) % 2 == 1
    A = PeriodicMatrix.constant(np.where(odd, 0.0, 0.3 * rng.normal(size=(18, 4, 4))) - np.diag(decay * np.arange(4)))
    A = A + PeriodicMatrix.harmonic(1, *np.where(odd, 0.5 * rng.normal(size=(2, 18, 4, 4)), 0.0))
    whole = stability(PeriodicSystem(period=TWO_PI, matrix=A))
    half = stability(PeriodicSystem(period=math.pi, matrix=A, twist=np.array([1.0, -1.0, 1.0, -1.0])))
    for a, b, x, y in zip(half.exponents, whole.exponents, half.exponent_errors, whole.exponent_errors, strict=True):
        assert np.all(distances(a, b, 1.0) <= x.max() + y.max())
    assert np.median(half.exponent_errors) < 1e-12


@compiled
@pytest.mark.parametrize("name", list(SYSTEMS))
def test_compiled_and_numpy_paths_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within both bounds; verdicts alike."""
    system = SYSTEMS[name]()
    use("lanes", monkeypatch)
    fast = stability(system, symmetry=False)
    use("numpy", monkeypatch)
    slow = stability(system, symmetry=False)
    strip = TWO_PI / system.period
    for a, b, x, y in zip(fast.exponents, slow.exponents, fast.exponent_errors, slow.exponent_errors, strict=True):
        assert np.all(distances(a, b, strip) <= x.max() + y.max())
    np.testing.assert_array_equal(fast.verdict, slow.verdict)
    assert fast.determinant_defect.max() < 1e-12 and slow.determinant_defect.max() < 1e-12


@pytest.mark.parametrize("path", [LANES, "numpy"])
def test_panels_and_start_do_not_matter(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice the panels, few panels, and other azimuths to begin with: all within their bounds."""
    use(path, monkeypatch)
    system = second_order(20, 2, 2, 7)
    assert system.damping is not None and system.stiffness is not None
    exact = stability(system)
    few = 8 if path == "lanes" else 3
    others = [stability(system, panels=p) for p in (few, 40)]
    others += [
        stability(
            PeriodicSystem(period=TWO_PI, damping=system.damping.shifted(x), stiffness=system.stiffness.shifted(x))
        )
        for x in (1.0, 4.0)
    ]
    for other in others:
        for a, b, x, y in zip(
            exact.exponents, other.exponents, exact.exponent_errors, other.exponent_errors, strict=True
        ):
            assert np.all(distances(a, b, 1.0) <= x.max() + y.max())
    assert np.all(others[0].panels == few) and others[0].exponent_errors.max() > 1e-11  # coarse, and says so


@pytest.mark.parametrize("name", ["three blades", "four blades", "steps", "odd", "two coordinates"])
def test_a_case_alone_gives_the_same_bits(name: str, lanes: None) -> None:
    """Whatever its neighbours in the lanes are, what rung they end on, and which of their entries are zero."""
    system = SYSTEMS[name]()
    whole = stability(system, symmetry=False)
    for some in (np.arange(3, 4), np.arange(0, 24, 5), np.arange(20)):
        part = stability(system.part(some), symmetry=False)
        assert part.exponents.tobytes() == whole.exponents[some].tobytes()
        assert part.exponent_errors.tobytes() == whole.exponent_errors[some].tobytes()
        assert part.panels.tobytes() == whole.panels[some].tobytes()


def test_zeros_of_a_neighbour_do_not_matter(lanes: None) -> None:
    """Hover has no harmonics; alone it is mapped without them, beside forward flight with harmonics that are zero."""
    rotor = Rotor(lock_number=np.array([8.0, 9.0, 7.0]), blades=4)
    together = stability(multiblade(rotor, np.array([0.0, 0.3, 0.0])), symmetry=False)
    alone = stability(multiblade(rotor.replace(lock_number=np.array([8.0])), np.array([0.0])), symmetry=False)
    assert alone.exponents.tobytes() == together.exponents[:1].tobytes()
    assert alone.exponent_errors.tobytes() == together.exponent_errors[:1].tobytes()


def test_strong_growth_and_what_is_beyond_doubles(lanes: None) -> None:
    """exp(±200·2π) in 17 cases: exponents of all digits; beside them cases that overflow, which say so."""
    cases = 18
    K = np.zeros((cases, 2, 2))
    K[:, 0, 0], K[:, 1, 1] = -4e4, 1.0
    K[5] = 1e200 * np.eye(2)
    K[6, 0, 1] = np.inf
    with np.errstate(all="ignore"):
        found = stability(PeriodicSystem(period=TWO_PI, stiffness=PeriodicMatrix.constant(K)), panels=400)
    good = np.ones(cases, bool)
    good[[5, 6]] = False
    np.testing.assert_allclose(np.sort(found.exponents[good].real)[:, [0, -1]], [[-200.0, 200.0]] * 16, rtol=1e-12)
    assert np.all(np.isinf(found.exponent_errors[~good])) and np.all(found.verdict[~good] == Verdict.UNDECIDED)
    assert np.all(found.exponent_errors[good] < 1e-8)


def test_functions_are_mapped_panel_by_panel_at_once() -> None:
    """One call of the function a piece and rule, and the answers of the trigonometric system."""
    F = 0.3 * np.random.default_rng(1).normal(size=(4, 4))
    system, calls = rotating_frame(F), []
    assert system.function is not None
    inner = system.function

    def counted(t: np.ndarray) -> np.ndarray:
        calls.append(len(t))
        return inner(t)

    found = stability(PeriodicSystem(period=TWO_PI, function=counted))
    assert distances(found.exponents, stability(rotating(F)).exponents, 1.0).max() < 1e-13
    assert len(calls) < 30  # shapes, four samples of the size, and two rules a rung


def test_the_number_of_panels_follows_from_the_case(lanes: None) -> None:
    """Slow and fast cases in one call: each on its own rung, the slow ones not on more panels for the fast ones."""
    K = np.array([0.5, 2.0, 50.0, 1000.0])[:, None, None] * np.diag([1.0, 1.3])
    found = stability(PeriodicSystem(period=TWO_PI, stiffness=PeriodicMatrix.constant(K)))
    assert np.all(np.diff(found.panels) > 0)
    exact = np.sqrt(K[:, [0, 1], [0, 1]])
    for k in range(4):
        assert distances(found.exponents[k], np.concatenate([1j * exact[k], -1j * exact[k]]), 1.0).max() < 1e-12
    phi = period_map(PeriodicSystem(period=TWO_PI, stiffness=PeriodicMatrix.constant(K)))
    assert isinstance(phi, FactorMap) and len(phi.groups) >= 4
    assert exponents(phi).exponents.tobytes() == found.exponents.tobytes()


def test_panels_that_are_too_few_are_noticed(lanes: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """A probe that promises too much: cases go up the ladder until the series say that they are resolved."""
    system = second_order(40, 3, 1, 8)
    usual = stability(system)
    monkeypatch.setattr(series, "SMALL", 1e-6)
    phi = period_map(system)
    assert isinstance(phi, FactorMap) and sum(len(group.cases) for group in phi.groups) > 60  # many were mapped again
    again = exponents(phi)
    assert np.all(again.exponent_errors < 3.0 * usual.exponent_errors)
    assert np.all(again.panels <= 1.5 * usual.panels)


# ---------------------------------------------------------------------- compilation
#: Kernels that must be made of wide registers, and how many fused multiply-adds each has at least.
WIDE = {"factors.map_panels": 100, "products.multipliers": 300}


@compiled
def test_kernels_run_on_wide_registers(tmp_path: Path) -> None:
    flags = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    if " avx2" not in flags or " fma" not in flags:
        pytest.skip("this machine has no wide fused multiply-add")
    code = f"""
        import importlib, re
        import numpy as np
        from floquet import Rotor, multiblade, stability
        stability(multiblade(Rotor(lock_number=8.0, blades=3), np.linspace(0.0, 1.0, 500)), symmetry=False)
        for name in {list(WIDE)}:
            module, kernel = name.split(".")
            compiled = getattr(importlib.import_module(f"floquet.kernels.{{module}}"), kernel)
            text = "".join(compiled.inspect_asm().values())
            wide, single = (r"vfn?m(?:add|sub)\\w+pd\\s.*%[yz]mm", r"vfn?m\\w+sd\\s")
            print(len(re.findall(wide, text)), len(re.findall(single, text)))
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},  # compiled afresh: code from a cache has no listing
        capture_output=True,
        text=True,
        check=True,
    )
    counts = [tuple(map(int, line.split())) for line in run.stdout.splitlines()]
    for (wide_ones, single), (kernel, least) in zip(counts, WIDE.items(), strict=True):
        assert wide_ones > least and single < least / 10, kernel


@pytest.mark.parametrize("size", [1e6, 1e12, 1e300])
@pytest.mark.parametrize("n", [1, 2])
def test_what_no_number_of_panels_resolves_has_no_bound(n: int, size: float, lanes: None) -> None:
    """The difference of two rules is small beside what both leave out."""
    matrix = np.eye(n) * np.array([1.0, size])[:, None, None]
    found = stability(PeriodicSystem(matrix=PeriodicMatrix.constant(matrix, 1.0), period=1.0))
    assert np.all(np.isinf(found.exponent_errors[1])) and found.verdict[1] == Verdict.UNDECIDED
    assert (
        np.all(np.abs(found.exponents[0] - 1.0) <= found.exponent_errors[0]) and found.exponent_errors[0].max() < 1e-13
    )


def test_large_multipliers_keep_their_digits() -> None:
    """2^±1000 times matrices near 1: scales are powers of two, exactly."""
    near = np.random.default_rng(5).normal(size=(8, 3, 3))
    for power in (-900, 900):
        values, bounds = eigenvalues_of(np.ldexp(near, power), np.ldexp(np.full(8, 1e-15), power))
        plain, radius = eigenvalues_of(near, np.full(8, 1e-15))
        np.testing.assert_array_equal(values, np.ldexp(plain.real, power) + 1j * np.ldexp(plain.imag, power))
        np.testing.assert_array_equal(bounds, np.ldexp(radius, power))


def test_first_order_systems_on_several_cores_give_the_same_bits(lanes: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of cases, in chunks."""
    rng = np.random.default_rng(8)
    A, C = rng.normal(size=(2, 6000, 2, 2))
    matrix = PeriodicMatrix.constant(A - np.eye(2)) + PeriodicMatrix.harmonic(1, C, 0.0 * C)
    system = PeriodicSystem(matrix=matrix, period=2.0 * math.pi)
    found = []
    for threads in ("1", "2"):
        monkeypatch.setenv("FLOQUET_THREADS", threads)
        found.append(stability(system))
    whole = exponents(period_map(system))
    for one in found:
        assert one.exponents.tobytes() == whole.exponents.tobytes()
        assert one.exponent_errors.tobytes() == whole.exponent_errors.tobytes()
