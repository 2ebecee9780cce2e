"""Control laws against the report's equations as printed (where right), and loops closed on table 3 and on the blade.

Body axes are checked without the rotation matrix: a harmonic of ψ′ = ψ − β_w is projected on harmonics of ψ.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from floquet.decoupling import (
    Sensitivities,
    appendix_c_mixing,
    control_advance_angle,
    control_mixing,
    decoupled_rate_response,
    decoupling_coupling,
    decoupling_offset,
    decoupling_spring,
    hover_gearing,
    hover_rate_feedback,
    hover_rate_response,
    mixed_controls,
    rate_feedback,
    rate_response,
    rates_fed_back,
    report_mass_ratio,
    required_spring,
    teetering_gearing,
    uniform_mass_ratio,
)
from floquet.errors import ParameterError
from floquet.models import FORCING
from floquet.rotor import Hub, Rotor
from tests.test_response import harmonic_balance
from tests.truth import closed_forms

Array = NDArray[np.float64]
ROTOR = Rotor(lock_number=7.0, hinge_offset=0.08, hinge_stiffness=0.1, pitch_flap_coupling=0.25)
TEETERING = Rotor(lock_number=7.0, hinge_stiffness=0.1, pitch_flap_coupling=0.25, blades=2, hub=Hub.TEETERING)
K = Sensitivities(coning=1.3, longitudinal=0.7, lateral=0.9)
PROMISE = np.array([[1.3, 0, 0], [0, 0, 0.7], [0, 0.9, 0]])  # (C2): rows a₀, a₁, b₁; columns δ_C, δ_A, δ_L
SWAP = np.array([[0.0, 1.0], [1.0, 0.0]])
CLOSED = 1e-12  # what the laws promise; they do it to rounding
ANGLES = [0.0, math.radians(30.0)]


def blade(rotor: Rotor, mu: float) -> tuple[closed_forms.Coefficients, closed_forms.Forcing]:
    g, e = float(rotor.lock_number), float(rotor.hinge_offset)
    c = closed_forms.truncated(g, e, rotor.hinge_stiffness, rotor.pitch_flap_coupling, mu, rotor.offset_mass_ratio)
    return c, closed_forms.forcing(g, e, mu, rotor.offset_mass_ratio, rotor.static_moment_ratio)


def table_3_gains(rotor: Rotor, mu: float) -> Array:
    c, _ = blade(rotor, mu)
    F = closed_forms.table_3_forcing(float(rotor.lock_number), float(rotor.hinge_offset), mu, rotor.offset_mass_ratio)
    return np.asarray(np.linalg.solve(closed_forms.table_3(c)[1], F))


def periodic_gains(rotor: Rotor, mu: float) -> Array:
    c = harmonic_balance(*blade(rotor, mu))
    return np.stack([c[0].real, -c[1].real, c[1].imag])


def wind(sideslip: float, cosine: float, sine: float) -> tuple[float, float]:
    """Coefficients of cos ψ and sin ψ of ``cosine cos ψ′ + sine sin ψ′``, ψ′ = ψ − β_w, by projection."""
    psi = np.arange(8) * math.pi / 4
    f = cosine * np.cos(psi - sideslip) + sine * np.sin(psi - sideslip)
    return float(np.mean(2 * f * np.cos(psi))), float(np.mean(2 * f * np.sin(psi)))


def body_response(gains: Array, sideslip: float, inflow_gradient: float, **inputs: float) -> Array:
    """(a₀, a₁, b₁) in body axes for body-axis inputs theta_0, A, B, p, q, from wind-axis gains (3, 10)."""
    u = dict.fromkeys(FORCING, 0.0)
    u["theta_0"] = inputs.get("theta_0", 0.0)
    u["lambda"] = inflow_gradient * u["theta_0"]
    u["A_1c"], u["B_1c"] = wind(sideslip, inputs.get("A", 0.0), inputs.get("B", 0.0))  # θ = … − A cos ψ′ − B sin ψ′
    u["q_w"], u["p_w"] = wind(sideslip, inputs.get("q", 0.0), inputs.get("p", 0.0))  # U_P = … + x(p sin ψ′ + q cos ψ′)
    a0, a1, b1 = gains @ [u[name] for name in FORCING]
    return np.array([a0, *wind(-sideslip, a1, b1)])  # β = a₀ − a₁ cos ψ − b₁ sin ψ seen from ψ′


@pytest.mark.parametrize("sideslip", ANGLES)
@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("inflow_gradient", [0.0, 0.4])
def test_mixing_decouples_the_controls(mu: float, sideslip: float, inflow_gradient: float) -> None:
    """Closed on table 3 the promise is kept to 1e-12; closed on the blade's harmonics the residual is what is said."""
    mixing = control_mixing(ROTOR, mu, K, sideslip=sideslip, inflow_gradient=inflow_gradient)
    loop = mixed_controls(ROTOR, mu, mixing, K, sideslip=sideslip, inflow_gradient=inflow_gradient)
    for gains, found in ((table_3_gains(ROTOR, mu), loop.tip_path_plane), (periodic_gains(ROTOR, mu), loop.periodic)):
        columns = [
            body_response(gains, sideslip, inflow_gradient, theta_0=t, A=a, B=b) for t, a, b in np.asarray(mixing).T
        ]
        np.testing.assert_allclose(found, np.stack(columns, axis=-1), atol=CLOSED)
    np.testing.assert_allclose(loop.tip_path_plane, PROMISE, atol=CLOSED)
    assert loop.residual(loop.tip_path_plane).max() < CLOSED
    expected = np.abs(loop.periodic - PROMISE).max(axis=0) / [1.3, 0.9, 0.7]
    np.testing.assert_allclose(loop.residual(), expected, atol=1e-15)
    crossing = np.abs(np.where(PROMISE == 0.0, loop.periodic, 0.0)).max(axis=0) / [1.3, 0.9, 0.7]
    np.testing.assert_allclose(loop.coupling(), crossing, atol=1e-15)
    assert np.all(loop.coupling() <= loop.residual()) and loop.coupling(loop.tip_path_plane).max() < CLOSED
    assert (loop.residual().max() < CLOSED) if mu == 0.0 else (1e-3 < loop.residual().max() < 0.05)


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("inflow_gradient", [0.0, 0.4])
def test_appendix_c_written_out_is_the_solution(mu: float, inflow_gradient: float) -> None:
    found = appendix_c_mixing(ROTOR, mu, K, inflow_gradient=inflow_gradient)
    np.testing.assert_allclose(found, control_mixing(ROTOR, mu, K, inflow_gradient=inflow_gradient), atol=1e-14)
    g, e, Q = 7.0, 0.08, (1 - 0.08) ** 2 / 2  # (C4) with the αs of appendix C and K̃ of table 3, by hand
    a1 = g / 2 * ((1 / 4 - e / 3) + mu**2 / 2 * Q) + g / 2 * (1 / 3 - e / 2) * inflow_gradient
    a2 = -g / 2 * mu * (1 / 3 - e / 2)
    a4 = -g / 2 * mu * (2 / 3 - e) - g * mu / 2 * Q * inflow_gradient
    a5 = g / 2 * ((1 / 4 - e / 3) + 3 * mu**2 / 4 * Q)
    _, T = closed_forms.table_3(blade(ROTOR, mu)[0])
    d = a1 * a5 - a2 * a4
    assert found[0, 0] == pytest.approx(1.3 * (a5 * T[0, 0] - a2 * T[2, 0]) / d, rel=1e-13)
    assert found[2, 2] == pytest.approx(0.7 * (a1 * T[2, 1] - a4 * T[0, 1]) / d, rel=1e-13)  # ∂B₁s/∂δ_L
    assert found[1, 1] == pytest.approx(0.9 * T[1, 2] / (g / 2 * ((1 / 4 - e / 3) + mu**2 / 4 * Q)), rel=1e-13)


def gearing_14(g: float, e: float, P2: float, k: Sensitivities) -> Array:
    """Eq. (14) as printed (δ_B is δ_A)."""
    direct = (1 - 8 / 3 * e + 2 * e**2) / (1 - 4 / 3 * e)
    cross = 8 * (P2 - 1) / (g * (1 - 4 / 3 * e))
    return np.array([[direct * k.lateral, cross * k.longitudinal], [cross * k.lateral, -direct * k.longitudinal]])


def test_hover_gearing_is_equation_14_for_any_sideslip() -> None:
    P2 = float(ROTOR.frequency_ratio_squared)
    found = hover_gearing(ROTOR, K)
    np.testing.assert_allclose(found, gearing_14(7.0, 0.08, P2, K), rtol=1e-14)
    np.testing.assert_allclose(found, control_mixing(ROTOR, 0.0, K)[1:, 1:], atol=1e-14)
    for sideslip in ANGLES:
        loop = mixed_controls(ROTOR, 0.0, found, K, sideslip=sideslip)
        np.testing.assert_allclose(loop.tip_path_plane, PROMISE[1:, 1:], atol=CLOSED)
        np.testing.assert_allclose(loop.periodic, PROMISE[1:, 1:], atol=CLOSED)


def test_control_advance_angle_is_equation_15_and_the_blade_s_phase() -> None:
    """(15) as printed, and 90° less the lag of β'' + c₀ β' + P² β = cos ψ."""
    c, e = blade(ROTOR, 0.0)[0], 0.08
    expected = math.atan((c["P2"] - 1) / (7.0 * (1 / 8 - e / 3 + e**2 / 4)))
    lag = -np.angle(1.0 / (c["P2"] - 1.0 + 1j * c["c0"]))
    assert control_advance_angle(ROTOR) == pytest.approx(expected, rel=1e-14)
    assert control_advance_angle(ROTOR) == pytest.approx(math.pi / 2 - lag, rel=1e-14)
    # the swash plate turned by φ and no other mixing: a cyclic stick moves the plane one way only
    gearing = hover_gearing(ROTOR)
    assert math.atan2(gearing[1, 0], gearing[0, 0]) == pytest.approx(expected, rel=1e-14)
    assert control_advance_angle(Rotor(lock_number=8.0)) == 0.0


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_teetering_gearing_is_equation_16(mu: float) -> None:
    g, K1, P2 = 7.0, 0.25, float(TEETERING.frequency_ratio_squared)
    printed = np.array(
        [
            [K.lateral, 8 / g * (P2 - 1 + g * K1 * mu**2 / 16) / (1 + mu**2 / 2) * K.longitudinal],
            [
                8 / g * (P2 - 1 + 3 / 16 * g * K1 * mu**2) / (1 + 3 / 2 * mu**2) * K.lateral,
                -(1 - mu**2 / 2) / (1 + 3 / 2 * mu**2) * K.longitudinal,
            ],
        ]
    )
    found = teetering_gearing(TEETERING, mu, K)
    np.testing.assert_allclose(found, printed, rtol=1e-14)
    np.testing.assert_allclose(found, control_mixing(TEETERING, mu, K), atol=1e-14)
    loop = mixed_controls(TEETERING, mu, found, K)
    _, T, F = closed_forms.teetering_tip_path_plane(g, 0.1, K1, mu)
    np.testing.assert_allclose(loop.tip_path_plane, np.linalg.solve(T, F[:, 1:3] @ found), atol=CLOSED)
    np.testing.assert_allclose(loop.tip_path_plane, PROMISE[1:, 1:], atol=CLOSED)
    c = harmonic_balance(closed_forms.teetering(g, 0.1, K1, mu), closed_forms.teetering_forcing(g, mu))
    exact = np.stack([-c[1].real, c[1].imag])[:, 1:3] @ found
    np.testing.assert_allclose(loop.periodic, exact, atol=CLOSED)
    turned = control_mixing(TEETERING, mu, K, sideslip=0.5)
    np.testing.assert_allclose(
        mixed_controls(TEETERING, mu, turned, K, sideslip=0.5).tip_path_plane, PROMISE[1:, 1:], atol=CLOSED
    )


def rate_response_17(g: float, e: float, m: float, P2: float) -> Array:
    """Eq. (17) as printed, Ω = 1."""
    c0, c = 1 / 4 - 2 / 3 * e + e**2 / 2, 1 / 4 - e / 3
    cross = g**2 / 4 * c0 * c - 2 * (P2 - 1) * (1 + m)
    direct = -g * (1 + m) * c0 - g / 2 * (P2 - 1) * c
    return np.array([[cross, direct], [direct, -cross]]) / ((P2 - 1) ** 2 + g**2 / 4 * c0**2)


def test_rate_response_is_equations_17_and_18() -> None:
    P2 = float(ROTOR.frequency_ratio_squared)
    expected = rate_response_17(7.0, 0.08, 0.12, P2)
    np.testing.assert_allclose(hover_rate_response(ROTOR), expected, rtol=1e-13)
    for sideslip in ANGLES:
        np.testing.assert_allclose(
            rate_response(ROTOR, 0.0, sideslip=sideslip), _turned(expected, sideslip), atol=1e-14
        )
    g = 8.0
    np.testing.assert_allclose(hover_rate_response(Rotor(lock_number=g)), [[1, -16 / g], [-16 / g, -1]], rtol=1e-15)


def _turned(wind_axes: Array, sideslip: float) -> Array:
    """A rate response (2, 2) seen in body axes, by projection."""
    columns = []
    for p, q in ((1.0, 0.0), (0.0, 1.0)):
        q_w, p_w = wind(sideslip, q, p)
        columns.append(wind(-sideslip, *(wind_axes @ [p_w, q_w])))
    return np.array(columns).T


def test_required_spring_is_equations_19_and_22() -> None:
    g, e, m = 7.0, 0.08, 0.12
    printed = g**2 / 4 * (1 / 4 - e / 3) * (1 / 4 - 2 / 3 * e + e**2 / 2) / (2 * (1 + m))
    assert required_spring(ROTOR) == pytest.approx(printed, rel=1e-14)
    assert required_spring(Rotor(lock_number=g)) == pytest.approx(g**2 / 128, rel=1e-15)


@pytest.mark.parametrize("kind", ["coupling", "spring"])
def test_rates_decouple_where_19_holds(kind: str) -> None:
    """(20) corrected and (23): what is left of (17), for any rotor on the condition; in any axes."""
    change: dict[str, Any] = (
        {"pitch_flap_coupling": decoupling_coupling(ROTOR)}
        if kind == "coupling"
        else {"hinge_stiffness": decoupling_spring(ROTOR.replace(pitch_flap_coupling=0.05))}
    )
    rotor = ROTOR.replace(**({} if kind == "coupling" else {"pitch_flap_coupling": 0.05}), **change)
    direct = -16 * 1.12 / (7.0 * (1 - 8 * 0.08 / 3 + 2 * 0.08**2))
    np.testing.assert_allclose(hover_rate_response(rotor), direct * SWAP, atol=1e-14)
    assert decoupled_rate_response(rotor) == pytest.approx(direct, rel=1e-14)
    assert decoupled_rate_response(Rotor(lock_number=8.0)) == pytest.approx(-2.0, rel=1e-15)
    for sideslip in ANGLES:
        loop = rates_fed_back(rotor, 0.0, direct * SWAP, sideslip=sideslip)
        assert loop.residual(loop.tip_path_plane).max() < CLOSED and loop.residual().max() < CLOSED


def test_required_coupling_is_equations_22b_and_25() -> None:
    for g in (2.0, 8.0, 14.0):
        for kappa in (0.0, 0.225):
            found = decoupling_coupling(Rotor(lock_number=g, hinge_stiffness=kappa))
            assert found == pytest.approx(g / 16 - 8 * kappa / g, rel=1e-13)
        for e in (0.05, 0.15):
            printed = g / 16 * (1 - 8 / 3 * e + 2 * e**2) / (1 + 1.5 * e) - 12 / g * e / (1 - 4 / 3 * e)
            assert decoupling_coupling(Rotor(lock_number=g, hinge_offset=e)) == pytest.approx(printed, rel=1e-13)


@pytest.mark.parametrize(
    ("g", "mass_ratio", "expected"),
    [(2.0, report_mass_ratio, 0.01878), (8.0, report_mass_ratio, 0.14486), (2.0, uniform_mass_ratio, 0.01846),
     (8.0, uniform_mass_ratio, 0.13228)],
)  # fmt: skip
def test_required_offset_is_figure_17(g: float, mass_ratio: Any, expected: float) -> None:
    """The report reads .019 and .145 off its figure; five decimals by the roots of the polynomial below."""
    found = decoupling_offset(g, mass_ratio=mass_ratio)
    assert found == pytest.approx(expected, abs=5.1e-6)
    one = np.polynomial.Polynomial([1.0])
    e = np.polynomial.Polynomial([0.0, 1.0])
    right = g**2 / 4 * (1 / 4 - e / 3) * (1 / 4 - 2 / 3 * e + e**2 / 2)
    if mass_ratio is report_mass_ratio:
        condition = 2 * (one + 1.5 * e) * 1.5 * e - right
    else:  # times (1 − ε)²
        condition = 2 * (one + 0.5 * e) * 1.5 * e - right * (1 - e) ** 2
    roots = condition.roots()
    assert np.abs(roots - found).min() < 1e-12


def test_required_offset_where_there_is_none() -> None:
    assert math.isnan(decoupling_offset(4.0, pitch_flap_coupling=0.5))  # K₁ > γ/16: too stiff already at ε = 0
    assert decoupling_offset(8.0, pitch_flap_coupling=0.5) == 0.0  # K₁ = γ/16 exactly
    assert decoupling_offset(3.6, pitch_flap_coupling=0.225) == 0.0  # and to rounding
    e = decoupling_offset(8.0, pitch_flap_coupling=0.2, hinge_stiffness=0.05)
    rotor = Rotor(lock_number=8.0, pitch_flap_coupling=0.2, hinge_stiffness=0.05, hinge_offset=e)
    assert abs(hover_rate_response(rotor)[0, 0]) < 1e-12


def feedback_28(g: float, e: float, m: float, P2: float, k_3: float) -> Array:
    """Eq. (28) as printed, Ω = 1."""
    power = g * (1 / 8 - e / 6)
    c0 = g * (1 / 8 - e / 3 + e**2 / 4)
    first, second = -2 * (1 + m) + k_3 * c0, -power + k_3 * (P2 - 1)
    return -np.array([[first, second], [second, -first]]) / power


@pytest.mark.parametrize("sideslip", ANGLES)
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_feedback_decouples_the_rates(mu: float, sideslip: float) -> None:
    """(27) on table 3 to 1e-12, by the rotor's own response to rates and to the fed back pitch."""
    feedback = rate_feedback(ROTOR, mu, 1.5, sideslip=sideslip)
    loop = rates_fed_back(ROTOR, mu, -1.5 * SWAP, feedback, sideslip=sideslip)
    for gains, found in ((table_3_gains(ROTOR, mu), loop.tip_path_plane), (periodic_gains(ROTOR, mu), loop.periodic)):
        for j, (p, q) in enumerate(((1.0, 0.0), (0.0, 1.0))):
            A, B = feedback @ [p, q]
            np.testing.assert_allclose(
                found[:, j], body_response(gains, sideslip, 0.0, A=A, B=B, p=p, q=q)[1:], atol=CLOSED
            )
    np.testing.assert_allclose(loop.tip_path_plane, -1.5 * SWAP, atol=CLOSED)
    assert (loop.residual().max() < CLOSED) if mu == 0.0 else (1e-3 < loop.residual().max() < 0.1)
    if mu == 0.0 and sideslip == 0.0:
        printed = feedback_28(7.0, 0.08, 0.12, float(ROTOR.frequency_ratio_squared), 1.5)
        np.testing.assert_allclose(hover_rate_feedback(ROTOR, 1.5), printed, rtol=1e-13)
        np.testing.assert_allclose(feedback, printed, atol=1e-13)


def test_laws_take_arrays() -> None:
    rotors, mu = Rotor(lock_number=np.array([[6.0], [9.0]]), hinge_offset=0.05), np.array([0.0, 0.2, 0.3])
    mixing = control_mixing(rotors, mu)
    loop = mixed_controls(rotors, mu, mixing)
    assert mixing.shape == (2, 3, 3, 3) and loop.residual().shape == (2, 3, 3)
    np.testing.assert_allclose(mixing[1, 2], control_mixing(rotors[1, 0], 0.3), atol=1e-14)
    np.testing.assert_allclose(appendix_c_mixing(rotors, mu), mixing, atol=1e-14)
    assert rate_feedback(rotors, mu, 1.0).shape == (2, 3, 2, 2) and hover_gearing(rotors).shape == (2, 1, 2, 2)
    assert np.shape(control_advance_angle(rotors)) == np.shape(required_spring(rotors)) == (2, 1)
    exact = control_mixing(ROTOR, 0.3, exact_offset=True)  # options reach every model
    assert np.abs(exact - control_mixing(ROTOR, 0.3)).max() > 1e-5
    loop = mixed_controls(ROTOR, 0.3, exact, exact_offset=True)
    assert loop.residual(loop.tip_path_plane).max() < CLOSED


def test_laws_for_the_other_hub_are_refused() -> None:
    with pytest.raises(ParameterError, match="teetering hub"):
        teetering_gearing(ROTOR, 0.3)
    with pytest.raises(ParameterError, match="has coning"):
        appendix_c_mixing(TEETERING, 0.3)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: control_mixing(ROTOR, 0.3, sideslip=10.0), "no sideslip angle in radians"),
        (lambda: control_mixing(ROTOR, 0.3, sideslip="0.1"), "no sideslip angle in radians"),  # type: ignore[arg-type]
        (lambda: rate_feedback(ROTOR, 0.3, 1.0, sideslip=math.nan), "no sideslip angle in radians"),
        (lambda: control_mixing(ROTOR, 0.3, 2.0), "are no sensitivities"),  # type: ignore[arg-type]
        (lambda: hover_gearing(ROTOR, ("a", 2.0, 3.0)), "are no sensitivities"),  # type: ignore[arg-type]
        (lambda: control_mixing("uh60a.toml", 0.3), "is no Rotor"),  # type: ignore[arg-type]
        (lambda: control_mixing(ROTOR, "0.3"), "is not a number"),
        (lambda: control_mixing(ROTOR, 0.3, inflow_gradient="x"), "inflow_gradient"),  # type: ignore[arg-type]
        (lambda: rate_feedback(ROTOR, 0.3, "2"), "k_3"),  # type: ignore[arg-type]
        (lambda: mixed_controls(ROTOR, 0.3, np.eye(4)), "neither a mixing"),
        (lambda: rates_fed_back(ROTOR, 0.3, SWAP, np.eye(3)), "is no feedback"),
        (lambda: rates_fed_back(ROTOR, 0.3, np.eye(3)), "is no promise"),
        (lambda: mixed_controls(TEETERING, 0.3, np.eye(3)), "no coning to mix"),
        (lambda: teetering_gearing(TEETERING.replace(flap_damping=0.2), 0.3), "use control_mixing"),
        (lambda: decoupling_offset([2.0, 8.0]), "one rotor at a time"),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(call: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        call()


def test_three_numbers_are_sensitivities() -> None:
    np.testing.assert_array_equal(control_mixing(ROTOR, 0.3, (1.3, 0.7, 0.9)), control_mixing(ROTOR, 0.3, K))
