"""Responses against independent physics: harmonic balance, the blade element under SciPy, matrix exponentials."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from floquet.errors import FloquetWarning, ParameterError
from floquet.exponents import stability
from floquet.models import (
    FORCING,
    averaged,
    flapping,
    hover_modes,
    hover_response,
    multiblade,
    teetering,
    tip_path_plane,
)
from floquet.periodic import PeriodicMatrix, PeriodicSystem
from floquet.response import (
    flap_angle,
    periodic_response,
    reduced_order,
    steady_gains,
    steady_state,
    step_response,
    tip_path_plane_gains,
)
from floquet.rotor import Hub, Rotor
from tests.truth import blade_element, closed_forms

ROTOR = Rotor(lock_number=7.0, hinge_offset=0.08, hinge_stiffness=0.1, pitch_flap_coupling=0.25)
TEETERING = Rotor(lock_number=7.0, hinge_stiffness=0.1, pitch_flap_coupling=0.25, blades=2, hub=Hub.TEETERING)
INPUTS = {"theta_0": 0.14, "A_1c": 0.02, "B_1c": 0.05, "theta_t": -0.1, "lambda": -0.03, "p_w": 0.01, "q_w": -0.02,
          "pdot_w": 0.003, "qdot_w": 0.002, "normal_acceleration": -0.004}  # fmt: skip
U = np.array([INPUTS[name] for name in FORCING])


def harmonic_balance(c: closed_forms.Coefficients, f: closed_forms.Forcing, order: int = 40) -> NDArray[np.complex128]:
    """c_h (order+1, 10) of the blade's periodic response: Hill's equations for the harmonics −order … order."""
    n = 2 * order + 1
    h = np.arange(-order, order + 1)

    def multiplied(mean: float, cosines: list[float], sines: list[float]) -> NDArray[np.complex128]:
        M = mean * np.eye(n, dtype=complex)
        for k, (a, b) in enumerate(zip(cosines, sines, strict=True), 1):
            M += 0.5 * (a - 1j * b) * np.eye(n, k=-k) + 0.5 * (a + 1j * b) * np.eye(n, k=k)
        return M

    d = multiplied(c["c0"], [0.0], [c["cs1"]])
    k = multiplied(c["k0"], [c["kc1"], c["kc2"]], [c["ks1"], c["ks2"]])
    right = np.zeros((n, 10), complex)
    right[order] = f["f0"]
    for j in range(1, min(order, 3) + 1):
        right[order + j], right[order - j] = (0.5 * (f[f"fc{j}"] - s * 1j * f[f"fs{j}"]) for s in (1, -1))
    x = np.linalg.solve(np.diag(-(h**2)) + d @ np.diag(1j * h) + k, right)
    return np.concatenate([x[order : order + 1], 2.0 * x[order + 1 :]])


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("mu", [0.0, 0.3, 1.2])
def test_periodic_response_of_a_blade_is_harmonic_balance(mu: float, exact: bool) -> None:
    form = closed_forms.exact if exact else closed_forms.truncated
    c = form(7.0, 0.08, 0.1, 0.25, mu)
    f = closed_forms.forcing(7.0, 0.08, mu, exact_offset=exact)
    found = periodic_response(flapping(ROTOR, mu, exact_offset=exact), INPUTS)
    expected = harmonic_balance(c, f)[:32] @ U
    error = np.abs(found.harmonics[:, 0] - expected).max()
    assert error <= found.harmonic_error and found.error < 1e-11  # the bound, and it is useful
    assert error < 1e-14 * (1.0 + np.abs(expected).max())
    np.testing.assert_allclose(
        found.tip_path_plane, [expected[0].real, -expected[1].real, expected[1].imag], atol=1e-14
    )


def test_periodic_response_of_the_teetering_rotor_is_harmonic_balance() -> None:
    f = closed_forms.teetering_forcing(7.0, 0.45)
    expected = harmonic_balance(closed_forms.teetering(7.0, 0.1, 0.25, 0.45), f)[:32] @ U
    found = periodic_response(teetering(TEETERING, 0.45), INPUTS)
    np.testing.assert_allclose(found.harmonics[:, 0], expected, atol=1e-14)
    assert found.tip_path_plane[0] == pytest.approx(0.0, abs=1e-14)


def element(rotor: Rotor, mu: float, **options: Any) -> blade_element.Blade:
    return blade_element.Blade(
        gamma=rotor.lock_number, eps=rotor.hinge_offset, kappa=rotor.hinge_stiffness, K1=rotor.pitch_flap_coupling,
        mu=mu, m=rotor.offset_mass_ratio, s=rotor.static_moment_ratio, **options,
    )  # fmt: skip


def integrated(blade: blade_element.Blade, start: Any, psi: NDArray[np.float64]) -> NDArray[np.float64]:
    """β, β' of the blade element, by an integrator that shares nothing with the package."""
    done = solve_ivp(
        lambda t, x: [x[1], blade_element.hinge_moment(blade, t, beta=x[0], rate=x[1], inputs=U)],
        (psi[0], psi[-1]), start, method="DOP853", rtol=1e-10, atol=1e-12, t_eval=psi,
    )  # fmt: skip
    return np.asarray(done.y)


@pytest.mark.parametrize(("mu", "reversed_flow"), [(0.35, False), (0.9, True), (1.4, True)])
def test_periodic_response_is_the_blade_element_s(mu: float, reversed_flow: bool) -> None:
    """Integrated from its own start, the blade element comes back and passes through every value (1e-8: DOP853)."""
    found = periodic_response(flapping(ROTOR, mu, exact_offset=True, reversed_flow=reversed_flow), INPUTS)
    blade = element(ROTOR, mu, reversed_flow=reversed_flow)
    start = [found.values[0, 0], found.rates[0, 0]]
    y = integrated(blade, start, np.append(found.azimuths, 2 * math.pi))
    np.testing.assert_allclose(y[:, -1], start, atol=1e-8)
    np.testing.assert_allclose(y[0, :-1], found.values[:, 0], atol=1e-8)


def test_step_of_the_blade_is_the_blade_element_s() -> None:
    psi = np.linspace(0.7, 9.0, 24)
    found = step_response(flapping(ROTOR, 0.9, exact_offset=True, reversed_flow=True), INPUTS, psi)
    y = integrated(element(ROTOR, 0.9, reversed_flow=True), [0.0, 0.0], psi)
    np.testing.assert_allclose(found.values[:, 0], y[0], atol=1e-8)
    other = step_response(flapping(ROTOR, 0.9, exact_offset=True, reversed_flow=True), INPUTS, psi - 0.7)
    assert np.abs(other.values - found.values).max() > 1e-3  # where the step happens matters


@pytest.mark.parametrize("psi", [np.array([0.0, 6.0, 20.0]), np.linspace(1.0, 19.0, 8)])
def test_kinks_are_panel_ends_in_every_turn(psi: NDArray[np.float64]) -> None:
    """A rule across a kink is right to 1e-6 only, and its difference from the coarser rule says so."""
    rotor = Rotor(lock_number=np.array([7.0, 12.0]), hinge_offset=0.2)
    system = flapping(rotor, np.array([1.2, 0.7]), reversed_flow=True)
    assert np.max(step_response(system, INPUTS, psi).error) < 3e-11
    assert np.max(periodic_response(system, INPUTS).error) < 3e-11


@pytest.mark.parametrize("N", [2, 3, 4, 5])
@pytest.mark.parametrize("reversed_flow", [False, True])
def test_multiblade_response_is_the_blade_s(N: int, reversed_flow: bool) -> None:
    """Identical blades: the means of β₀, β₁c, β₁s are the blade's harmonics, and T puts its motion together."""
    blade = periodic_response(flapping(ROTOR, 0.9, reversed_flow=reversed_flow), INPUTS)
    rotor = periodic_response(multiblade(ROTOR.replace(blades=N), 0.9, reversed_flow=reversed_flow), INPUTS)
    assert len(rotor.coordinates) == N
    if N > 2:
        np.testing.assert_allclose(rotor.tip_path_plane, blade.tip_path_plane, atol=1e-9 if reversed_flow else 1e-13)
    at = dict(zip(rotor.coordinates, rotor.values.T, strict=True))
    psi = rotor.azimuths
    beta = at["beta_0"] - at.get("beta_d", 0.0)  # blade 1 has (−1)¹
    for n in range(1, (N - 1) // 2 + 1):
        beta = beta + at[f"beta_{n}c"] * np.cos(n * psi) + at[f"beta_{n}s"] * np.sin(n * psi)
    np.testing.assert_allclose(beta, blade.values[:, 0], atol=1e-13)


def test_steady_state_is_table_3_solved() -> None:
    c = closed_forms.truncated(7.0, 0.08, 0.1, 0.25, 0.3)
    _, K = closed_forms.table_3(c)
    F = closed_forms.table_3_forcing(7.0, 0.08, 0.3)
    found = steady_state(tip_path_plane(ROTOR, 0.3), INPUTS)
    np.testing.assert_allclose(found, np.linalg.solve(K, F @ U), atol=1e-15)
    np.testing.assert_allclose(tip_path_plane_gains(tip_path_plane(ROTOR, 0.3)), np.linalg.solve(K, F), atol=1e-14)
    average = tip_path_plane_gains(averaged(ROTOR, 0.3, 1))
    np.testing.assert_allclose(average, np.linalg.solve(K, F), atol=1e-14)


def hover_13(rotor: Rotor, u: dict[str, float]) -> NDArray[np.float64]:
    """Eqs. (13a), (13b), (13c) term by term, as printed."""
    g, e, m = float(rotor.lock_number), float(rotor.hinge_offset), float(rotor.offset_mass_ratio)
    P2 = 1 + rotor.hinge_stiffness + m + g * rotor.pitch_flap_coupling / 8 * (1 - 4 / 3 * e)
    delta = (P2 - 1) ** 2 + (g * (1 / 8 - e / 3 + e**2 / 4)) ** 2
    A, B = u["A_1c"] - u["q_w"], u["B_1c"] - u["p_w"]
    a0 = u["normal_acceleration"] * rotor.static_moment_ratio
    a0 += g / 2 * ((1 / 4 - e / 3) * u["theta_0"] + (1 / 5 - e / 4) * u["theta_t"] + (1 / 3 - e / 2) * u["lambda"])
    half = g * (1 / 8 - e / 3 + e**2 / 4)
    a1 = g * (1 / 8 - e / 6) * ((P2 - 1) * A - half * B) - 2 * (1 + m) * ((P2 - 1) * u["p_w"] + half * u["q_w"])
    b1 = g * (1 / 8 - e / 6) * (half * A + (P2 - 1) * B) + 2 * (1 + m) * ((P2 - 1) * u["q_w"] - half * u["p_w"])
    return np.array([a0 / P2, a1 / delta, b1 / delta])


def test_hover_response_is_equation_13() -> None:
    u = {name: value for name, value in INPUTS.items() if not name.endswith("dot_w")}
    expected = hover_13(ROTOR, {**u, "pdot_w": 0.0, "qdot_w": 0.0})
    np.testing.assert_allclose(hover_response(ROTOR, u), expected, atol=1e-15)
    np.testing.assert_allclose(steady_state(tip_path_plane(ROTOR, 0.0), u), expected, atol=1e-15)
    for kinematic in (False, True):  # accelerations too, which (13) leaves out
        plane = steady_state(tip_path_plane(ROTOR, 0.0, kinematic_rates=kinematic), INPUTS)
        np.testing.assert_allclose(hover_response(ROTOR, INPUTS, kinematic_rates=kinematic), plane, atol=1e-15)


@pytest.mark.parametrize(
    "rotor", [ROTOR, Rotor(lock_number=20.0), Rotor(lock_number=np.array([8.0, 16.0, 24.0]), hinge_offset=0.1)]
)
def test_hover_modes_are_equations_9_and_10_corrected(rotor: Rotor) -> None:
    for index in np.ndindex(rotor.shape):
        one, found = rotor[index], hover_modes(rotor)
        truth = closed_forms.hover(
            one.lock_number, one.hinge_offset, one.hinge_stiffness, one.pitch_flap_coupling, one.offset_mass_ratio
        )
        assert np.asarray(found.coning.frequency)[index] == pytest.approx(truth["P"], rel=1e-15)
        assert np.asarray(found.coning.damping_ratio)[index] == pytest.approx(truth["zeta"], rel=1e-14)
        if truth["zeta"] <= 1:
            for name, letter in (("advancing", "A"), ("regressing", "R")):
                mode = getattr(found, name)
                # next to critical damping the square root of 1 − ζ² halves the digits
                assert np.asarray(mode.frequency)[index] == pytest.approx(truth[f"omega_{letter}"], rel=1e-8)
                assert np.asarray(mode.damping_ratio)[index] == pytest.approx(truth[f"zeta_{letter}"], rel=1e-8)
        cyclic = np.concatenate([found.advancing.exponents[index], found.regressing.exponents[index]])
        exact = np.asarray(stability(tip_path_plane(one, 0.0)).exponents)
        for values in (cyclic, found.coning.exponents[index]):
            assert np.abs(values[:, None] - exact[None, :]).min(axis=1).max() < 1e-7
        expected = np.asarray(truth["cyclic"])
        assert np.abs(cyclic[:, None] - expected[None, :]).min(axis=0).max() < 1e-13
        assert bool(np.asarray(found.overdamped)[index]) == (truth["zeta"] > 1)


def test_overdamped_modes_have_the_frequency_and_damping_of_their_exponents() -> None:
    found = hover_modes(Rotor(lock_number=20.0))  # −½ ± i and −2 ± i, ζ = 1.25
    np.testing.assert_allclose(found.advancing.exponents, [-0.5 + 1j, -0.5 - 1j], atol=1e-15)
    np.testing.assert_allclose(found.regressing.exponents, [-2.0 + 1j, -2.0 - 1j], atol=1e-15)
    assert found.regressing.damping_ratio == pytest.approx(2.0 / math.sqrt(5.0))
    np.testing.assert_allclose(found.coning.exponents, [-0.5, -2.0], atol=1e-15)
    assert found.overdamped is True and isinstance(found.coning.frequency, float)


@pytest.mark.parametrize("reduced", [False, True])
def test_step_of_constant_models_is_a_matrix_exponential(reduced: bool) -> None:
    c = closed_forms.truncated(7.0, 0.08, 0.1, 0.25, 0.3)
    D, K = closed_forms.table_3(c)
    f = closed_forms.table_3_forcing(7.0, 0.08, 0.3) @ U
    if reduced:
        A, b = -np.linalg.solve(D, K), np.linalg.solve(D, f)
    else:
        A = np.block([[np.zeros((3, 3)), np.eye(3)], [-K, -D]])
        b = np.concatenate([np.zeros(3), f])
    psi = np.array([0.0, 0.3, 2.0, 11.0, 11.5, 40.0])
    wide = np.zeros((len(b) + 1, len(b) + 1))
    wide[:-1, :-1], wide[:-1, -1] = A, b
    expected = np.array([(expm(wide * t) @ np.append(np.zeros(len(b)), 1.0))[:3] for t in psi])
    plane = tip_path_plane(ROTOR, 0.3)
    found = step_response(reduced_order(plane) if reduced else plane, INPUTS, psi)
    np.testing.assert_allclose(found.values, expected, atol=1e-13)
    assert np.abs(found.values - expected).max() <= found.error < 1e-12
    np.testing.assert_allclose(found.values[-1], np.linalg.solve(K, f), atol=1e-5)  # at rest after 40 rad


def test_tip_path_plane_of_a_step_is_in_the_sense_of_a1_and_b1() -> None:
    psi = np.array([0.0, 2.0, 60.0])
    system = multiblade(ROTOR, 0.3)
    moved, plane = (step_response(s, INPUTS, psi) for s in (system, tip_path_plane(ROTOR, 0.3)))
    np.testing.assert_array_equal(moved.tip_path_plane, moved.values[:, :3] * [1.0, -1.0, -1.0])
    np.testing.assert_array_equal(plane.tip_path_plane, plane.values)
    assert np.abs(moved.tip_path_plane - plane.tip_path_plane).max() < 0.05 * np.abs(plane.values).max()
    with pytest.raises(ParameterError, match="have no tip-path plane"):
        _ = step_response(flapping(ROTOR, 0.3), INPUTS, psi).tip_path_plane


def test_step_ends_in_the_periodic_response() -> None:
    system = multiblade(ROTOR, 0.3)
    steady = periodic_response(system, INPUTS)
    psi = np.concatenate([[0.0], 2 * math.pi * 14 + steady.azimuths])
    moved = step_response(system, INPUTS, psi)
    np.testing.assert_allclose(moved.values[1:], steady.values, atol=1e-12)  # e^{−0.4·88} of the start is left


def test_initial_state_is_carried_on() -> None:
    psi = np.linspace(0.2, 5.0, 9)
    system, u = flapping(ROTOR, 0.3), {"B_1c": 0.1}
    whole = step_response(system, u, psi)
    half = step_response(system, u, psi[:5])
    blade = periodic_response(system, u)
    assert blade.values.shape == (128, 1)
    # a state in the middle: position from the values, rate by the fundamental solution of the second half
    start = np.array([half.values[-1, 0], _rate(system, u, psi[:5])])
    rest = step_response(system, u, psi[4:], initial=start)
    np.testing.assert_allclose(rest.values, whole.values[4:], atol=1e-13)


def _rate(system: PeriodicSystem, u: dict[str, float], psi: NDArray[np.float64]) -> float:
    """β' at the last azimuth, from SciPy."""
    assert system.forcing is not None
    forcing = system.forcing
    column = list(system.input_names).index("B_1c")

    def rates(t: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
        push = forcing.sample(np.array([t]))[0, 0, column] * u["B_1c"]
        return np.asarray(system.sample(np.array([t]))[0] @ x + [0.0, push])

    done = solve_ivp(rates, (psi[0], psi[-1]), [0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-15)
    return float(done.y[1, -1])


def test_reduced_order_is_equation_11() -> None:
    """TP-1431, figure 13: γ = 8, μ = 0.3, all else 0; the roots of the restored table 4 (equations of table 3)."""
    D, K = closed_forms.table_3(closed_forms.truncated(8.0, mu=0.3))
    found = np.asarray(stability(reduced_order(tip_path_plane(Rotor(lock_number=8.0), 0.3))).exponents)
    expected = np.linalg.eigvals(-np.linalg.solve(D, K))
    assert np.abs(found[:, None] - expected[None, :]).min(axis=0).max() < 1e-14
    for root in (-0.9982, -0.3993 + 0.2092j, -0.3993 - 0.2092j):
        assert np.abs(found - root).min() < 5.1e-5 * math.sqrt(2.0)  # four decimals of re and im
    assert steady_gains(tip_path_plane(ROTOR, 0.3)).shape == (3, 10)


def test_cases_broadcast_and_equal_the_single_ones() -> None:
    rotors = Rotor(lock_number=np.array([[6.0], [9.0]]), hinge_offset=0.05)
    mu, B = np.array([0.1, 0.3, 0.8]), np.array([1.0, 2.0, -1.0])
    for options in ({}, {"reversed_flow": True}):
        found = periodic_response(flapping(rotors, mu, **options), {"B_1c": B})
        psi = np.linspace(0.0, 4.0, 5)
        steps = step_response(flapping(rotors, mu, **options), {"B_1c": B}, psi)
        gains = tip_path_plane_gains(flapping(rotors, mu, **options))
        assert found.values.shape == (2, 3, 128, 1) and found.tip_path_plane.shape == (2, 3, 3)
        assert gains.shape == (2, 3, 3, 10) and np.shape(found.error) == (2, 3) == np.shape(steps.error)
        for i, j in np.ndindex(2, 3):
            one = flapping(rotors[i, 0], mu[j], **options)
            alone = periodic_response(one, {"B_1c": B[j]})
            np.testing.assert_allclose(found.harmonics[i, j], alone.harmonics, atol=1e-9 if options else 1e-13)
            np.testing.assert_allclose(gains[i, j, :, 2] * B[j], found.tip_path_plane[i, j], atol=1e-12)
            np.testing.assert_allclose(steps.values[i, j], step_response(one, {"B_1c": B[j]}, psi).values, atol=1e-13)
    assert steady_state(tip_path_plane(rotors, mu), {"B_1c": B}).shape == (2, 3, 3)
    one = periodic_response(flapping(Rotor(lock_number=6.0), 0.2), {"B_1c": np.ones(4)})
    assert one.tip_path_plane.shape == (4, 3) and isinstance(
        periodic_response(flapping(Rotor(lock_number=6.0), 0.2), {"B_1c": 1.0}).error, float
    )


def test_dissimilar_blades_respond_each_for_itself() -> None:
    blades = [Rotor(lock_number=8.0), Rotor(lock_number=8.0), Rotor(lock_number=6.0, hinge_stiffness=0.1)]
    found = periodic_response(multiblade(blades, 0.3), INPUTS)
    third = periodic_response(flapping(blades[2], 0.3), INPUTS)
    q = found.harmonics[:, :].T  # (coordinates, harmonics)
    psi = found.azimuths
    values = [np.real(sum(c * np.exp(1j * h * psi) for h, c in enumerate(row))) for row in q]
    beta_3 = values[0] + values[1] * np.cos(psi + 4 * math.pi / 3) + values[2] * np.sin(psi + 4 * math.pi / 3)
    here = np.real(sum(c * np.exp(1j * h * (psi + 4 * math.pi / 3)) for h, c in enumerate(third.harmonics[:, 0])))
    np.testing.assert_allclose(beta_3, here, atol=1e-13)


def test_precone_moves_the_teetering_rotor() -> None:
    """The two blades' own eq. (1) with a₀ added to the flap angle of both: half the difference of their moments."""
    a0, psi = 0.05, np.array([0.3, 1.1, 4.0])
    F = teetering(TEETERING, 0.45).forcing
    assert F is not None
    blade = element(TEETERING.replace(hub=Hub.ARTICULATED), 0.45)
    for i, p in enumerate(psi):
        one, two = (blade_element.hinge_moment(blade, q, beta=a0) for q in (p, p + math.pi))
        assert a0 * F.sample(psi)[i, 0, 10] == pytest.approx(0.5 * (one - two), abs=1e-14)
    moved = periodic_response(teetering(TEETERING, 0.45), {"precone": a0})
    assert np.abs(moved.tip_path_plane[1:]).max() > 1e-3


def test_flap_angle_is_equation_5() -> None:
    psi = np.array([0.0, math.pi / 2, math.pi])
    np.testing.assert_allclose(flap_angle(np.tile([0.1, 0.02, 0.03], (3, 1)), psi), [0.08, 0.07, 0.12], atol=1e-16)
    np.testing.assert_allclose(flap_angle(np.tile([0.02, 0.03], (3, 1)), psi, 0.1), [0.08, 0.07, 0.12], atol=1e-16)


def test_unstable_rotor_is_said_to_be_so() -> None:
    with pytest.warns(FloquetWarning, match="unstable"):
        periodic_response(flapping(Rotor(lock_number=8.0), 1.6), {"B_1c": 1.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        periodic_response(flapping(Rotor(lock_number=8.0), 1.3), {"B_1c": 1.0})


def _incommensurate() -> PeriodicSystem:
    return PeriodicSystem(
        period=2.0,
        stiffness=PeriodicMatrix.scalar(mean=1.0, cosines=[0.1], period=2.0),
        inputs=lambda: PeriodicMatrix.scalar(cosines=[1.0], period=3.0),
        input_names=("force",),
        coordinates=("beta",),
    )


def test_forcing_of_half_the_period_is_taken_over_the_whole() -> None:
    """x' = −x + u cos 2t with period 2π beside a forcing of period π: x = u (cos 2t + 2 sin 2t)/5."""
    system = PeriodicSystem(
        period=2 * math.pi,
        matrix=PeriodicMatrix.constant([[-1.0]]),
        inputs=lambda: PeriodicMatrix.scalar(cosines=[1.0], period=math.pi),
        input_names=("force",),
    )
    found = periodic_response(system, {"force": 5.0})
    expected = np.cos(2 * found.azimuths) + 2 * np.sin(2 * found.azimuths)
    np.testing.assert_allclose(found.values[:, 0], expected, atol=1e-14)
    assert np.all(np.isnan(found.rates))


def test_many_cases_are_mapped_some_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = periodic_response(multiblade(ROTOR, np.linspace(0.0, 0.5, 5)), INPUTS)
    monkeypatch.setattr("floquet.passage.DOUBLES", 3 * (16 * 8) ** 2)  # three panels of four blades
    parts = periodic_response(multiblade(ROTOR, np.linspace(0.0, 0.5, 5)), INPUTS)
    np.testing.assert_array_equal(whole.values, parts.values)


def test_unstable_plane_is_said_to_be_so_and_a_singular_one_has_no_steady_state() -> None:
    rotors = Rotor(lock_number=8.0, pitch_flap_coupling=np.array([-1.0, 0.1]))  # P² = 0 and 1.1
    with pytest.warns(FloquetWarning, match="unstable"):
        found = steady_state(tip_path_plane(rotors, 0.0), INPUTS)
    assert np.all(np.isnan(found[0])) and np.all(np.isfinite(found[1]))


@pytest.mark.parametrize("A", [1.0, 3.56, 8.46])
def test_error_bounds_motion_that_grows_on_the_way(A: float) -> None:
    """q'' = (A² cos²ψ − A sin ψ) q has q = e^{A sin ψ}: what rounding does where q is least grows by e^{2A}."""
    system = PeriodicSystem(
        period=2 * math.pi,
        stiffness=PeriodicMatrix.scalar(mean=-A * A / 2.0, cosines=[0.0, -A * A / 2.0], sines=[A]),
        inputs=lambda: PeriodicMatrix.scalar(mean=0.0),
        input_names=("force",),
        coordinates=("beta",),
    )
    psi = np.linspace(-math.pi / 2, 2.5 * math.pi, 7)
    found = step_response(system, {}, psi, initial=[math.exp(-A), 0.0])
    error = np.abs(found.values[:, 0] - np.exp(A * np.sin(psi))).max()
    doubles = 4.0 * math.exp(3.0 * A) * np.finfo(float).eps  # A, the coefficients and the start are no exact numbers
    assert error <= found.error + doubles


@pytest.mark.parametrize("A", [1.0, 5.0, 7.9])
def test_error_bounds_a_periodic_response_beside_growth(A: float) -> None:
    """x' = a(ψ)(x − 1) with a = −0.447 + A cos ψ has x ≡ 1: what is not 1 is rounding, and the bound holds it."""
    a = PeriodicMatrix.scalar(mean=-0.447, cosines=[A])
    system = PeriodicSystem(
        period=2 * math.pi, matrix=a, inputs=lambda: -1.0 * a, input_names=("pull",), coordinates=("x",)
    )
    found = periodic_response(system, {"pull": 1.0})
    assert np.abs(found.values - 1.0).max() <= found.error
    moved = step_response(system, {"pull": 1.0}, np.linspace(-math.pi / 2, math.pi / 2, 3), initial=[1.0])
    assert np.abs(moved.values - 1.0).max() <= moved.error


def test_harmonics_beyond_are_in_their_error() -> None:
    """A forcing of 63 per rev moves no low harmonic, and one beyond half the samples makes for more samples."""
    for order in (63, 65, 127):
        system = PeriodicSystem(
            period=2 * math.pi,
            damping=PeriodicMatrix.scalar(mean=1.0),
            stiffness=PeriodicMatrix.scalar(mean=2.0),
            inputs=lambda order=order: PeriodicMatrix.harmonic(order, [[1.0]], [[0.0]]),  # type: ignore[misc]
            input_names=("force",),
            coordinates=("beta",),
        )
        found = periodic_response(system, {"force": 1.0})
        assert np.abs(found.harmonics).max() <= found.harmonic_error and np.abs(found.harmonics).max() < 1e-14
    for N in (16, 19):
        rotor = periodic_response(multiblade(ROTOR.replace(blades=N), 0.5, reversed_flow=True), {"B_1c": 1.0})
        blade = periodic_response(flapping(ROTOR, 0.5, reversed_flow=True), {"B_1c": 1.0})
        difference = np.abs(rotor.tip_path_plane - blade.tip_path_plane).max()
        assert difference <= rotor.harmonic_error + blade.harmonic_error


def test_resonance_has_no_response_and_says_so() -> None:
    """β'' + k β = cos ψ: β = cos ψ/(k − 1), and none for k = 1; the case beside it is not touched."""
    system = PeriodicSystem(
        period=2 * math.pi,
        stiffness=PeriodicMatrix.scalar(mean=np.array([1.0, 3.0])),
        inputs=lambda: PeriodicMatrix.scalar(cosines=[1.0]),
        input_names=("force",),
        coordinates=("beta",),
    )
    found = periodic_response(system, {"force": 1.0})
    assert np.all(np.isnan(found.values[0])) and found.error[0] == math.inf == found.harmonic_error[0]
    np.testing.assert_allclose(found.tip_path_plane[1], [0.0, -0.5, 0.0], atol=1e-14)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: periodic_response(flapping(ROTOR, 0.3), {"B_1": 1.0}), "no input of this model, did you mean 'B_1c'"),
        (lambda: periodic_response(flapping(ROTOR, 0.3), {"precone": 1.0}), "no input of this model"),
        (lambda: periodic_response(flapping(ROTOR, 0.3), {"B_1c": math.nan}), "not finite"),
        (lambda: periodic_response(flapping(ROTOR, 0.3), {"B_1c": "much"}), "not a number"),
        (lambda: periodic_response(flapping(ROTOR, 0.3), 0.1), "names no inputs"),  # type: ignore[arg-type]
        (lambda: steady_state(tip_path_plane(ROTOR, 0.3), {"B_1c": np.ones(2), "A_1c": np.ones(3)}), "not broadcast"),
        (lambda: periodic_response(tip_path_plane(ROTOR, 0.3), INPUTS), "is constant, so use steady_state"),
        (lambda: steady_state(flapping(ROTOR, 0.3), INPUTS), "use periodic_response"),
        (lambda: steady_state(ROTOR, INPUTS), "Rotor is no system"),  # type: ignore[arg-type]
        (lambda: periodic_response(flapping(ROTOR, [0.1, 0.2]), {"B_1c": [1.0, 2.0, 3.0]}), "do not broadcast"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, ["a", "b"]), "azimuths"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, [0.0, 1e12]), "panels"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, [0.0, 1.0], initial=[math.nan, 0.0]), "finite numbers"),
        (lambda: flap_angle([0.1], 0.0), "along the last axis"),
        (lambda: periodic_response(_incommensurate(), {"force": 1.0}), "do not repeat together"),
        (lambda: reduced_order(flapping(ROTOR, 0.3)), "no constant second-order model"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, [0.0, 0.0]), "each larger than the one before"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, [0.0, math.inf]), "finite numbers"),
        (lambda: step_response(flapping(ROTOR, 0.3), INPUTS, [0.0, 1.0], initial=[1.0]), "is no state of 2"),
        (lambda: step_response(PeriodicSystem(period=1.0, matrix=PeriodicMatrix.constant(np.eye(1), 1.0)), {}, [0, 1]),
         "no inputs to step"),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(call, sentence: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError, match=sentence):
        call()
