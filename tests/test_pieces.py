"""Hill's equation in pieces and of many harmonics: compiled, on arrays, and against what shares no code with either."""

from __future__ import annotations

import math
import subprocess
import sys
import textwrap
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from floquet import stability
from floquet.kernels import available
from floquet.kernels.hill import placed
from floquet.models import flapping
from floquet.models.textbook import meissner
from floquet.period_map import Method, PeriodMap, hill_form, period_map
from floquet.period_map.hill import hill_map
from floquet.period_map.precise import make_precise
from floquet.periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from floquet.rotor import Rotor

compiled = pytest.mark.skipif(not available(), reason="numba is not to be used")
MANY = 1200  # points that run compiled
BOTH = [pytest.param(True, marks=compiled, id="compiled"), pytest.param(False, id="arrays")]


def blades(n: int, seed: int = 0, *, mu: float = 2.5) -> tuple[Rotor, np.ndarray]:
    """Random articulated blades, a tenth of them just after the root has met reversed flow."""
    rng = np.random.default_rng(seed)
    offset, speed = rng.uniform(0, 0.2, n), rng.uniform(0, mu, n)
    grazing = rng.random(n) < 0.1
    speed = np.where(grazing, offset * (1.0 + 10.0 ** rng.uniform(-14, -2, n)), speed)
    rotor = Rotor(
        lock_number=rng.uniform(2, 16, n),
        hinge_offset=offset,
        hinge_stiffness=rng.uniform(0, 0.5, n),
        pitch_flap_coupling=rng.uniform(-0.5, 0.5, n),
        flap_damping=rng.uniform(0, 0.2, n),
    )
    return rotor, speed


def reversed_flow(n: int, seed: int = 0, **options: Any) -> PeriodicSystem:
    """Such blades in reversed flow."""
    rotor, mu = blades(n, seed)
    return flapping(rotor, mu, reversed_flow=True, **options)


def harmonics(n: int, order: int, seed: int = 0, *, damped: bool = True) -> PeriodicSystem:
    """Damped Hill equations with ``order`` harmonics."""
    rng = np.random.default_rng(seed)
    amplitudes = rng.normal(size=(2, order, n)) * rng.uniform(0.1, 3.0, n)
    k = PeriodicMatrix.scalar(mean=rng.uniform(-1, 9, n), cosines=[*amplitudes[0]], sines=[*amplitudes[1]])
    d = PeriodicMatrix.scalar(mean=rng.uniform(0, 0.3, n), sines=[rng.uniform(-0.3, 0.3, n)]) if damped else None
    return PeriodicSystem(period=TWO_PI, damping=d, stiffness=k, coordinates=("y",))


def steps(n: int, seed: int = 0) -> tuple[PeriodicSystem, np.ndarray, np.ndarray, np.ndarray]:
    """Constant d and k on five pieces, of which some have no length: d jumps.  The system, d, k and edges."""
    rng = np.random.default_rng(seed)
    d, k = rng.uniform(-0.3, 0.6, (n, 5)), rng.uniform(-1.0, 6.0, (n, 5))
    inner = np.sort(rng.uniform(0.0, TWO_PI, (n, 4)))
    inner[::3, 1] = inner[::3, 2]
    inner[1::7, 3] = TWO_PI
    inner[::5, 0] = 0.0
    edges = np.concatenate([np.zeros((n, 1)), inner, np.full((n, 1), TWO_PI)], axis=1)
    D, K = (
        PeriodicMatrix.pieces([PeriodicMatrix.constant(x[:, j, None, None]) for j in range(5)], edges) for x in (d, k)
    )
    return PeriodicSystem(period=TWO_PI, damping=D, stiffness=K, coordinates=("y",)), d, k, edges


def within(one: PeriodMap, exact: PeriodMap, slack: float = 0.0) -> None:
    """τ and D of one map are within the bounds of the exact ones, and the branch is the same."""
    assert one.rows is not None and exact.rows is not None
    assert np.all(np.abs(one.half_trace - exact.half_trace) <= one.rows[4] + slack)
    assert np.all(np.abs(one.discriminant - exact.discriminant) <= one.rows[5] + slack)
    np.testing.assert_array_equal(one.rows[6], exact.rows[6])


def in_forty_digits(phi: PeriodMap, system: PeriodicSystem, monkeypatch: pytest.MonkeyPatch) -> PeriodMap:
    """The map of all points from exact coefficients."""
    monkeypatch.setattr("floquet.period_map.precise.TOLERANCE", 0.0)
    out = make_precise(phi, system)
    assert out.methods is not None and np.all(out.methods == Method.PRECISE)
    return out


# ---------------------------------------------------------------------- compiled against arrays
@compiled
@pytest.mark.parametrize("exact_offset", [False, True])
@pytest.mark.parametrize("panels", [None, 23])
def test_compiled_pieces_are_those_of_arrays(exact_offset: bool, panels: int | None) -> None:
    """To rounding: maps, bounds, zeros, panels, what is not resolved; kicks and pieces without length among them."""
    system = reversed_flow(3000, 1, exact_offset=exact_offset)
    fast, slow = (hill_map(system, panels, precise=False, compiled=c) for c in (True, False))
    assert fast.rows is not None and slow.rows is not None
    bounds = fast.rows[4:6] + slow.rows[4:6]
    assert np.all(np.abs(fast.half_trace - slow.half_trace) <= bounds[0])
    assert np.all(np.abs(fast.discriminant - slow.discriminant) <= bounds[1])
    ratio = fast.rows[4] / slow.rows[4]
    assert abs(np.median(ratio) - 1.0) < 1e-3 and ratio.min() > 0.9 and ratio.max() < 1.1
    for row in (6, 7):
        np.testing.assert_array_equal(fast.rows[row], slow.rows[row])
    np.testing.assert_array_equal(fast.panels, slow.panels)


@compiled
@pytest.mark.parametrize("order", [0, 3, 5, 8, 20])
def test_compiled_harmonics_are_those_of_arrays(order: int) -> None:
    system = harmonics(MANY, order, order)
    fast, slow = (hill_map(system, precise=False, compiled=c) for c in (True, False))
    assert fast.rows is not None and slow.rows is not None
    within(fast, slow, slack=0.0)
    np.testing.assert_array_equal(fast.panels, slow.panels)
    assert not np.any(fast.rows[7])


@compiled
def test_unresolved_panels_are_counted_compiled() -> None:
    system = harmonics(200, 5, 2)
    fast, slow = (hill_map(system, 5, precise=False, compiled=c) for c in (True, False))
    assert fast.rows is not None and slow.rows is not None
    np.testing.assert_array_equal(fast.rows[7], slow.rows[7])
    assert np.median(fast.rows[7]) > 1 and np.all(fast.panels == 5)


@compiled
def test_bits_of_a_point_do_not_depend_on_its_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blades shuffled, every third of them, alone, and on one thread or three."""
    n = 20_000
    rotor, mu = blades(n, 3)
    monkeypatch.setenv("FLOQUET_THREADS", "3")
    whole = stability(flapping(rotor, mu, reversed_flow=True))
    monkeypatch.setenv("FLOQUET_THREADS", "1")
    order = np.random.default_rng(0).permutation(n)
    for some in (order, np.arange(0, n, 3)):
        part = stability(flapping(rotor[some], mu[some], reversed_flow=True))
        assert np.array_equal(whole.exponents[some], part.exponents)
        assert np.array_equal(whole.exponent_errors[some], part.exponent_errors)
        assert np.array_equal(np.asarray(whole.method)[some], part.method)
    system = flapping(rotor, mu, reversed_flow=True)
    phi = hill_map(system.part(slice(0, 40)), precise=False, compiled=True)
    for i in range(40):
        one = hill_map(system.part(slice(i, i + 1)), precise=False, compiled=True)
        assert one.rows is not None and phi.rows is not None and np.array_equal(one.rows[:, 0], phi.rows[:, i])


# ---------------------------------------------------------------------- against other mechanisms
@pytest.mark.parametrize("fast", BOTH)
def test_reversed_flow_is_within_its_bounds_of_forty_digits(fast: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """μ to 2.5 and just above the root, where pieces are as short as 1e-7 and the bounds must not be idle."""
    system = reversed_flow(150, 4, exact_offset=True)
    phi = hill_map(system, precise=False, compiled=fast)
    exact = in_forty_digits(phi, system, monkeypatch)
    within(phi, exact)
    assert phi.rows is not None
    error = np.abs(phi.discriminant - exact.discriminant)
    assert np.median(phi.rows[5] / np.maximum(error, 1e-16)) < 300.0
    lengths = hill_form(system.part(slice(None))).q.lengths[1]
    short = (lengths > 0.0) & (lengths < 0.1)
    assert np.sum(short) > 5 and np.all(phi.rows[5][short] < 1e-13 * (1.0 + np.abs(phi.discriminant[short])))


def test_reversed_flow_with_kicks_is_certified() -> None:
    """The report's truncated integrals, whose damping jumps above μ = 1: proven exponents by ball arithmetic."""
    n = MANY
    system = reversed_flow(n, 5)
    found = stability(system)
    some = np.arange(0, n, 40)
    proven = stability(system.part(some), certify=True)
    error = np.abs(np.asarray(found.exponents)[some] - proven.exponents)
    assert np.all(error <= np.asarray(found.exponent_errors)[some] + proven.exponent_errors)
    np.testing.assert_array_equal(np.asarray(found.verdict)[some], proven.verdict)


@pytest.mark.parametrize("fast", BOTH)
@pytest.mark.parametrize("order", [3, 8, 20])
def test_harmonics_are_within_their_bounds_of_forty_digits(
    order: int, fast: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = harmonics(60, order, 10 + order)
    phi = hill_map(system, precise=False, compiled=fast)
    within(phi, in_forty_digits(phi, system, monkeypatch))


@pytest.mark.parametrize("order", [3, 5, 8])
def test_harmonics_are_those_of_an_integrator(order: int) -> None:
    """SciPy's DOP853 at 1e-13: multipliers to its 1e-10 of the largest."""
    system = harmonics(MANY, order, 20 + order)
    found = stability(system)
    for case in range(0, MANY, 200):
        one = system.part(slice(case, case + 1))

        def right(t: float, y: np.ndarray, one: PeriodicSystem = one) -> np.ndarray:
            A = one.sample(np.array([t]))[0, 0]
            return np.asarray((A @ y.reshape(2, 2)).ravel())

        end = solve_ivp(right, (0.0, TWO_PI), np.eye(2).ravel(), method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        expected = np.linalg.eigvals(end.reshape(2, 2))
        values = np.exp(TWO_PI * np.asarray(found.exponents)[case])
        size = np.abs(expected).max()
        assert max(np.abs(expected - v).min() for v in values) < 1e-10 * size


@pytest.mark.parametrize("fast", BOTH)
def test_meissner_has_its_closed_form(fast: bool) -> None:
    """Two constants: 2τ = 2 cos a cos b - (ω₁/ω₂ + ω₂/ω₁) sin a sin b."""
    rng = np.random.default_rng(7)
    delta, e = rng.uniform(1.0, 9.0, MANY), rng.uniform(0.0, 0.9, MANY)
    phi = hill_map(meissner(delta, e), precise=False, compiled=fast)
    assert phi.rows is not None
    one, two = np.sqrt(delta + e), np.sqrt(delta - e)
    a, b = one * phi.period / 2, two * phi.period / 2
    trace = 2 * np.cos(a) * np.cos(b) - (one / two + two / one) * np.sin(a) * np.sin(b)
    assert np.all(np.abs(phi.half_trace - 0.5 * trace) <= phi.rows[4] + 1e-14)


@pytest.mark.parametrize("fast", BOTH)
def test_jumps_of_the_damping_are_kicks(fast: bool) -> None:
    """d and k constant on five pieces: products of matrix exponentials, some pieces without length."""
    system, d, k, edges = steps(MANY, 8)
    form = hill_form(system)
    assert form.q.kicks is not None and np.abs(form.q.kicks).max() > 0.1
    phi = hill_map(system, precise=False, compiled=fast)
    assert phi.rows is not None
    for case in range(0, MANY, 37):
        with mp.workdps(30):
            product, growth = mp.eye(2), mp.mpf(0)
            for j, (begin, end) in enumerate(pairwise(map(mp.mpf, edges[case]))):
                damping, stiffness = mp.mpf(d[case, j]), mp.mpf(k[case, j])
                product = mp.expm(mp.matrix([[0, 1], [-stiffness, -damping]]) * (end - begin)) * product
                growth -= damping * (end - begin) / 2
            half_trace = float((product[0, 0] + product[1, 1]) / 2 * mp.exp(-growth))  # of determinant 1
        assert phi.mean[case] == pytest.approx(float(growth) / TWO_PI, abs=1e-15)
        assert abs(phi.half_trace[case] - half_trace) <= phi.rows[4, case]


@pytest.mark.parametrize("fast", BOTH)
def test_a_piece_without_length_changes_nothing(fast: bool) -> None:
    """A wild polynomial on no length, between two halves of one polynomial; its jumps there and back are no kick."""
    tame = PeriodicMatrix.scalar(mean=1.3, cosines=[0.4, 0.1], sines=[0.2])
    wild = PeriodicMatrix.scalar(mean=-50.0, cosines=[9.0, 8.0, 7.0, 6.0])
    psi = np.linspace(0.0, TWO_PI, 40)
    edges = np.stack([0 * psi, psi, psi, 0 * psi + TWO_PI], axis=-1)
    k, d = (PeriodicMatrix.pieces([x * tame, x * wild, x * tame], edges) for x in (1.0, 0.3))
    system = PeriodicSystem(period=TWO_PI, damping=d, stiffness=k, coordinates=("y",))
    kicks = hill_form(system).q.kicks
    assert kicks is None
    whole = hill_map(PeriodicSystem(period=TWO_PI, damping=0.3 * tame, stiffness=tame), precise=False, compiled=fast)
    phi = hill_map(system, precise=False, compiled=fast)
    assert phi.rows is not None and whole.rows is not None
    assert np.all(np.abs(phi.half_trace - whole.half_trace) <= phi.rows[4] + whole.rows[4])
    assert np.all(np.abs(phi.discriminant - whole.discriminant) <= phi.rows[5] + whole.rows[5])


def test_forty_digits_do_not_depend_on_kicks_of_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two cases side by side; a jump of the damping is known in doubles only."""
    monkeypatch.setattr("floquet.period_map.precise.TOLERANCE", 0.0)
    jump, edges = np.array([0.0, 0.5]), np.array([0.0, 1.0, TWO_PI])
    d = PeriodicMatrix.pieces([PeriodicMatrix.scalar(mean=0 * jump), PeriodicMatrix.scalar(mean=jump)], edges)
    k = PeriodicMatrix.pieces([PeriodicMatrix.scalar(mean=[0.5, 1.0])] * 2, edges)
    phi = period_map(PeriodicSystem(period=TWO_PI, damping=d, stiffness=k))
    assert phi.methods is not None and list(phi.methods) == [Method.PRECISE, Method.HILL]


@pytest.mark.parametrize("kick", [0.0, 7.0, -7.0])
def test_errors_of_a_panel_after_its_kick(kick: float) -> None:
    """Entries of F moved by ±e: after the kick none moves by more than its bound, and each by all of it."""
    f, e, options = np.array([1.1, 0.8, -0.4, 0.9]), 1e-6, (0.1, 0.3, 0.0, kick)
    F, (delta, d1, d2), _ = placed(f, e, *options)
    moved = [np.subtract(placed(f + e * np.array(signs), e, *options)[0], F) for signs in product((-1, 1), repeat=4)]
    np.testing.assert_allclose(np.abs(moved).max(axis=0), [delta, d1, d2, e], rtol=1e-6)


def test_pieces_of_a_part_of_the_coefficients_period() -> None:
    """Coefficients that repeat after π, declared over 2π in four pieces: the map over π is that of two."""
    one, two = PeriodicMatrix.scalar(mean=2.0, cosines=[0, 0.3]), PeriodicMatrix.scalar(mean=0.7, sines=[0, 0.2])
    k = PeriodicMatrix.pieces([one, two, one, two], np.array([0.0, 1.0, math.pi, math.pi + 1.0, TWO_PI]))
    half, whole = (stability(PeriodicSystem(period=T, stiffness=k)).exponents for T in (math.pi, TWO_PI))
    turns = np.exp(TWO_PI * half)
    assert max(np.abs(turns - v).min() for v in np.exp(TWO_PI * whole)) < 1e-13


# ---------------------------------------------------------------------- cos and sin
@compiled
def test_cosine_and_sine_are_accurate(tmp_path: Path) -> None:
    """Against 40 digits for |x| < 40π, also next to multiples of ½π: 1.5 units in the last place."""
    code = """
        import numpy as np
        from floquet.kernels import elementary, lanes
        from numba import njit
        from floquet.kernels.compiler import inlined
        function, as_lanes = inlined(elementary.cosine_and_sine, select=lanes.where), lanes.as_lanes

        @njit
        def tabulate(x, c, s):
            a, b, d = as_lanes(x), as_lanes(c), as_lanes(s)
            for i in range(len(a)):
                b[i], d[i] = function(a[i])

        rng = np.random.default_rng(0)
        x = rng.uniform(-40 * np.pi, 40 * np.pi, 32_000)
        x[:16_000:2] = np.round(x[:16_000:2] / (np.pi / 2)) * (np.pi / 2) + rng.normal(size=8000) * 1e-6
        x[:8] = 0.0, -0.0, np.pi / 4, -np.pi / 4, np.pi, 1e-300, -1e-8, 0.5
        c, s = np.empty((2, 2000, 16))
        tabulate(x.reshape(-1, 16), c, s)
        np.save("{}", np.stack([x, c.ravel(), s.ravel()]))
    """
    file = tmp_path / "values.npy"
    subprocess.run([sys.executable, "-c", textwrap.dedent(code).replace("{}", str(file))], check=True)
    x, c, s = np.load(file)
    with mp.workdps(40):
        for i in range(0, len(x), 5):
            for found, exact in ((c[i], mp.cos(mp.mpf(x[i]))), (s[i], mp.sin(mp.mpf(x[i])))):
                assert abs(exact - mp.mpf(found)) <= 1.5 * max(np.spacing(abs(found)), 2.0**-80), (x[i], found)
