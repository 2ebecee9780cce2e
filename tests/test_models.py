"""The models against independent physics: blade-element quadrature, transcribed tables, hover formulas."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from floquet.errors import FloquetWarning, ParameterError
from floquet.exponents import stability
from floquet.models import averaged, flapping, hover_modes, hover_response, multiblade, teetering, tip_path_plane
from floquet.periodic import PeriodicSystem
from floquet.rotor import Hub, Rotor
from tests.truth import blade_element, closed_forms

TEETERING = Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING)
PSI = np.array([0.0, 0.4, 1.3, 2.9, 3.5, 4.7, 5.6])
RELATIVE = 1e-14  # tables are sums of at most ten products
ROTORS = [
    {"lock_number": 8.0},
    {"lock_number": 5.0, "hinge_offset": 0.15, "hinge_stiffness": 0.2, "pitch_flap_coupling": 0.3},
    {
        "lock_number": 12.0,
        "hinge_offset": 0.05,
        "pitch_flap_coupling": -0.2,
        "offset_mass_ratio": 0.1,
        "static_moment_ratio": 1.7,
        "flap_damping": 0.07,
    },
]


def coefficients(rotor: Rotor, mu: float, *, exact: bool = False) -> closed_forms.Coefficients:
    form = closed_forms.exact if exact else closed_forms.truncated
    c = form(
        rotor.lock_number,
        rotor.hinge_offset,
        rotor.hinge_stiffness,
        rotor.pitch_flap_coupling,
        mu,
        rotor.offset_mass_ratio,
    )
    return c | {"c0": c["c0"] + rotor.flap_damping}


def forcing(rotor: Rotor, mu: float, **options: bool) -> closed_forms.Forcing:
    return closed_forms.forcing(
        rotor.lock_number, rotor.hinge_offset, mu, rotor.offset_mass_ratio, rotor.static_moment_ratio, **options
    )


@pytest.mark.parametrize("rotor", [Rotor(**r) for r in ROTORS])
@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("mu", [0.0, 0.35])
def test_flapping_is_equation_1(rotor: Rotor, exact: bool, mu: float) -> None:
    system = flapping(rotor, mu, exact_offset=exact)
    c = coefficients(rotor, mu, exact=exact)
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    np.testing.assert_allclose(
        system.damping.sample(PSI)[:, 0, 0],
        [closed_forms.blade_damping(c, p) for p in PSI],
        rtol=RELATIVE,
        atol=RELATIVE,
    )
    np.testing.assert_allclose(
        system.stiffness.sample(PSI)[:, 0, 0],
        [closed_forms.blade_stiffness(c, p) for p in PSI],
        rtol=RELATIVE,
        atol=RELATIVE,
    )
    f = forcing(rotor, mu, exact_offset=exact)
    np.testing.assert_allclose(
        system.forcing.sample(PSI)[:, 0], [closed_forms.blade_forcing(f, p) for p in PSI], rtol=RELATIVE, atol=RELATIVE
    )


BLADES = [
    {"eps": 0.0, "mu": 0.3},
    {"eps": 0.15, "K1": 0.3, "mu": 0.4},
    {"eps": 0.1, "mu": 1.2, "K1": -0.2, "tip_loss": 0.96},
    {"eps": 0.05, "mu": 2.5, "root_cutout": 0.2, "flap_damping": 0.03},
    {"eps": 0.0, "mu": 2.5, "tip_loss": 0.9},
    {"eps": 0.15, "mu": 0.1},
    {"eps": 0.15, "mu": 2.5, "K1": 0.2},
]


@pytest.mark.parametrize("reversed_flow", [False, True])
@pytest.mark.parametrize("case", BLADES)
def test_coefficients_and_forcing_are_the_blade_elements(case: dict[str, float], reversed_flow: bool) -> None:
    """Exact integrals against adaptive quadrature: neither side uses the other's algebra."""
    truth = blade_element.Blade(
        gamma=9.0, kappa=0.1, m=0.2, s=1.6, reversed_flow=reversed_flow, kinematic_rates=True, **case
    )
    rotor = Rotor(
        lock_number=9.0,
        hinge_stiffness=0.1,
        offset_mass_ratio=0.2,
        static_moment_ratio=1.6,
        hinge_offset=truth.eps,
        pitch_flap_coupling=truth.K1,
        root_cutout=truth.root_cutout,
        flap_damping=truth.flap_damping,
    )
    system = flapping(
        rotor, truth.mu, exact_offset=True, reversed_flow=reversed_flow, tip_loss=truth.tip_loss, kinematic_rates=True
    )
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    d, k, f = (
        system.damping.sample(PSI)[:, 0, 0],
        system.stiffness.sample(PSI)[:, 0, 0],
        system.forcing.sample(PSI)[:, 0],
    )
    scale = 1e-12 * (1.0 + truth.gamma * (1.0 + truth.mu) ** 3)  # the quadrature's tolerance 1e-13 times the terms
    for i, psi in enumerate(PSI):
        assert d[i] == pytest.approx(blade_element.damping(truth, psi), abs=scale)
        assert k[i] == pytest.approx(blade_element.stiffness(truth, psi), abs=scale)
        np.testing.assert_allclose(f[i], blade_element.forcing(truth, psi), atol=scale)


def test_mechanical_damping_and_body_rates_of_the_report() -> None:
    """Without ``kinematic_rates`` the columns of body acceleration are 1, as in the report."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.1)
    for kinematic, expected in ((False, 1.0), (True, 1.0 + rotor.offset_mass_ratio)):
        F = flapping(rotor, 0.2, kinematic_rates=kinematic).forcing
        assert F is not None
        np.testing.assert_allclose(
            F.sample(PSI)[:, 0, 7:9], expected * np.stack([np.sin(PSI), np.cos(PSI)], -1), atol=1e-15
        )


@pytest.mark.parametrize("rotor", [Rotor(**r) for r in ROTORS])
@pytest.mark.parametrize(("N", "table"), [(3, closed_forms.table_1), (4, closed_forms.table_2)])
def test_multiblade_is_tables_1_and_2(rotor: Rotor, N: int, table) -> None:  # type: ignore[no-untyped-def]
    system = multiblade(rotor.replace(blades=N), 0.35)
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    D, K, F = (m.sample(PSI) for m in (system.damping, system.stiffness, system.forcing))
    c, f = coefficients(rotor, 0.35), forcing(rotor, 0.35)
    for i, psi in enumerate(PSI):
        for got, expected in zip((D[i], K[i], F[i]), table(c, f, psi), strict=True):
            np.testing.assert_allclose(got, expected, rtol=0, atol=RELATIVE * np.abs(expected).max())


@pytest.mark.parametrize("rotor", [Rotor(**r) for r in ROTORS])
def test_tip_path_plane_is_table_3(rotor: Rotor) -> None:
    system = tip_path_plane(rotor, 0.35)
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    D, K = closed_forms.table_3(coefficients(rotor, 0.35))
    F = closed_forms.table_3_forcing(
        rotor.lock_number, rotor.hinge_offset, 0.35, rotor.offset_mass_ratio, rotor.static_moment_ratio
    )
    for got, expected in zip(
        (system.damping.mean(), system.stiffness.mean(), system.forcing.mean()), (D, K, F), strict=True
    ):
        np.testing.assert_allclose(got, expected, rtol=0, atol=RELATIVE * np.abs(expected).max())


def test_teetering_is_equations_2_and_7() -> None:
    rotor, mu = Rotor(lock_number=7.0, hinge_stiffness=0.1, pitch_flap_coupling=0.25, blades=2, hub=Hub.TEETERING), 0.45
    system, plane = teetering(rotor, mu), tip_path_plane(rotor, mu)
    c, f = closed_forms.teetering(7.0, 0.1, 0.25, mu), closed_forms.teetering_forcing(7.0, mu)
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    np.testing.assert_allclose(system.damping.sample(PSI)[:, 0, 0], 7.0 / 8.0, rtol=RELATIVE)
    np.testing.assert_allclose(
        system.stiffness.sample(PSI)[:, 0, 0], [closed_forms.blade_stiffness(c, p) for p in PSI], rtol=RELATIVE
    )
    np.testing.assert_allclose(
        system.forcing.sample(PSI)[:, 0, :10], [closed_forms.blade_forcing(f, p) for p in PSI], atol=RELATIVE
    )
    assert plane.damping is not None and plane.stiffness is not None and plane.forcing is not None
    expected = closed_forms.teetering_tip_path_plane(7.0, 0.1, 0.25, mu)
    F = plane.forcing.mean()
    for got, table in zip((plane.damping.mean(), plane.stiffness.mean(), F[:, :10]), expected, strict=True):
        np.testing.assert_allclose(got, table, atol=10 * RELATIVE)
    assert plane.input_names[10] == "precone"
    np.testing.assert_allclose(F[:, 10], closed_forms.precone_forcing(7.0, 0.25, mu), atol=10 * RELATIVE)


@pytest.mark.parametrize("N", [3, 4, 5, 6, 7])
def test_averaged_model_is_the_mean_of_the_multiblade_equations(N: int) -> None:
    """Of 2M+1 blades; for N = 3 and 4 the tip-path plane with a₁ = -β₁c, b₁ = -β₁s."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05, pitch_flap_coupling=0.2, blades=N)
    mean, model = multiblade(rotor, 0.3).mean(), averaged(rotor, 0.3, (N - 1) // 2)
    M = 2 * ((N - 1) // 2) + 1
    for name in ("damping", "stiffness", "forcing"):
        np.testing.assert_allclose(
            getattr(mean, name).mean()[:M, : None if name == "forcing" else M],
            getattr(model, name).mean(),
            atol=10 * RELATIVE,
        )
    if M == 3:
        sign = np.diag([1.0, -1.0, -1.0])
        plane = tip_path_plane(rotor, 0.3)
        assert plane.stiffness is not None and model.stiffness is not None
        np.testing.assert_allclose(sign @ plane.stiffness.mean() @ sign, model.stiffness.mean(), atol=RELATIVE)


@pytest.mark.parametrize("N", [2, 3, 4, 5, 6, 7])
def test_one_passage_of_identical_blades_is_a_twisted_period(N: int) -> None:
    system = multiblade(Rotor(lock_number=9.0, hinge_offset=0.1, pitch_flap_coupling=0.2, blades=N), 0.4)
    S = np.ones(2 * N) if system.twist is None else system.twist
    A, after = system.sample(PSI), system.sample(PSI + 2 * math.pi / N)
    np.testing.assert_allclose(after, S[:, None] * A * S, atol=20 * RELATIVE)


@pytest.mark.parametrize(
    "rotor", [Rotor(**r) for r in ROTORS] + [Rotor(lock_number=20.0), Rotor(lock_number=8.0, hinge_stiffness=0.225)]
)
def test_hover_is_equations_9_and_10_corrected(rotor: Rotor) -> None:
    rotor = rotor.replace(flap_damping=0.0)
    hover = closed_forms.hover(
        rotor.lock_number, rotor.hinge_offset, rotor.hinge_stiffness, rotor.pitch_flap_coupling, rotor.offset_mass_ratio
    )
    found = np.asarray(stability(tip_path_plane(rotor, 0.0)).exponents)
    expected = np.concatenate([np.asarray(hover["coning"]), np.asarray(hover["cyclic"])])
    assert np.abs(found[:, None] - expected[None, :]).min(axis=0).max() < 1e-13
    assert np.abs(found[:, None] - expected[None, :]).min(axis=1).max() < 1e-13


def test_dissimilar_blades_keep_the_period_of_a_revolution() -> None:
    """Uncoupled blades: the exponents of the rotor are those of its blades, whatever the coordinates."""
    blades = [Rotor(lock_number=8.0), Rotor(lock_number=8.0), Rotor(lock_number=6.0, hinge_stiffness=0.1)]
    system = multiblade(blades, 0.3)
    assert system.period == pytest.approx(2 * math.pi) and system.twist is None
    found, expected = stability(system), [stability(flapping(b, 0.3)).exponents for b in blades]
    d = np.asarray(found.exponents)[:, None] - np.concatenate(expected)[None, :]
    distance = np.hypot(d.real, d.imag - np.round(d.imag))
    bound = float(np.max(found.exponent_errors))
    assert distance.min(axis=0).max() < max(1e-12, bound) and distance.min(axis=1).max() < max(1e-12, bound)


def test_reversed_flow_without_reversal_changes_nothing() -> None:
    """Hover, and a root cut-out outside the reversed circle."""
    for mu, cutout in ((0.0, 0.0), (0.3, 0.35)):
        rotor = Rotor(lock_number=8.0, root_cutout=cutout)
        a, b = (stability(flapping(rotor, mu, reversed_flow=r)).exponents for r in (False, True))
        np.testing.assert_allclose(a, b, atol=1e-14)


@pytest.mark.parametrize("mu", [0.2, 0.7, 1.0])
def test_reversed_flow_damps_by_the_fourth_power(mu: float) -> None:
    """Σσ = -c0 (1 + μ⁴/8) for ε = 0 and μ ≤ 1 (mean of the middle polynomial)."""
    total = np.asarray(stability(flapping(Rotor(lock_number=8.0), mu, reversed_flow=True)).exponents).real.sum()
    assert total == pytest.approx(-(1.0 + mu**4 / 8.0), abs=1e-13)


def test_truncated_damping_that_jumps_in_reversed_flow_is_mapped_with_its_kick() -> None:
    """Above μ = 1 the truncated integrals jump where the tip enters reversed flow; first order needs no Hill kick."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.2)
    system = flapping(rotor, 1.4, reversed_flow=True)
    assert system.damping is not None and system.damping.edges is not None
    assert np.abs(system.damping.jumps()).max() > 1e-3
    plain = PeriodicSystem.from_function(
        system.sample, system.period, list(np.unique(system.damping.edges)[1:-1]), vectorised=True
    )
    a, b = stability(system), stability(plain)
    d = np.asarray(a.exponents)[:, None] - np.asarray(b.exponents)[None, :]
    d = np.hypot(d.real, d.imag - np.round(d.imag))
    assert min(d[0, 0] + d[1, 1], d[0, 1] + d[1, 0]) < 1e-12


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: flapping(Rotor(lock_number=8.0), -0.1), "advance_ratio: -0.1 is not possible"),
        (lambda: flapping(Rotor(lock_number=8.0), math.nan), "advance_ratio: nan is no advance ratio"),
        (lambda: flapping(Rotor(lock_number=8.0), "fast"), "is not a number"),
        (lambda: flapping(Rotor(lock_number=8.0), 0.1, reverse_flow=True), "did you mean 'reversed_flow'"),
        (lambda: flapping(Rotor(lock_number=8.0), 0.1, reversed_flow=1), "neither True nor False"),
        (lambda: flapping(Rotor(lock_number=8.0), 0.1, tip_loss=1.1), "outside 0.5"),
        (lambda: multiblade(Rotor(lock_number=8.0, blades=1), 0.1), "at least 2 blades"),
        (lambda: multiblade([Rotor(lock_number=8.0)], 0.1), "at least 2 blades"),
        (lambda: teetering(Rotor(lock_number=8.0, hinge_offset=0.05), 0.1), "hinges on its axis"),
        (lambda: averaged(Rotor(lock_number=8.0), 0.1, 0), "whole number"),
        (lambda: flapping(Rotor(lock_number=8.0, root_cutout=0.99), 0.3, tip_loss=0.9), "no blade that lifts"),
        (lambda: flapping(Rotor(lock_number=np.array([6.0, 8.0])), np.zeros(3)), "do not broadcast"),
        (lambda: flapping("bo105.toml", 0.3), "is no Rotor"),
        (lambda: tip_path_plane("bo105.toml", 0.3), "is no Rotor"),
        (lambda: teetering("bo105.toml", 0.3), "is no Rotor"),
        (lambda: averaged(Rotor(lock_number=8.0), 0.1, "x"), "whole number"),
        (lambda: flapping(Rotor(lock_number=8.0), "0.3"), "is not a number"),
        (lambda: multiblade(TEETERING, 0.3), "one beam"),
        (lambda: hover_modes(TEETERING), "has no coning"),
        (lambda: hover_response(TEETERING, {"theta_0": 0.1}), "has no coning"),
        (lambda: flapping(Rotor(lock_number=8.0), 11.0), "between 0 and 10"),
    ],
)
def test_bad_input_is_one_sentence(call, sentence: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ParameterError, match=sentence):
        call()


def test_flapping_of_a_teetering_rotor_is_probably_not_meant() -> None:
    """Said once by flapping(); the models that are made of one blade do not say it."""
    with pytest.warns(FloquetWarning, match=r"use teetering\(\)"):
        flapping(TEETERING, 0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        teetering(TEETERING, 0.3)
        tip_path_plane(TEETERING, 0.3)


def test_truncated_integrals_warn_far_out() -> None:
    with pytest.warns(FloquetWarning, match=r"hinge_offset above 0\.3"):
        flapping(Rotor(lock_number=8.0, hinge_offset=0.4), 0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        flapping(Rotor(lock_number=8.0, hinge_offset=0.4), 0.1, exact_offset=True)
