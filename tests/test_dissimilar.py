"""Rotors of dissimilar blades in multiblade coordinates: the blades' own exponents, motion, modes and averages."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from floquet.comparison import compare
from floquet.errors import FloquetWarning, ParameterError
from floquet.exponents import Verdict, stability
from floquet.models import FORCING, averaged, flapping, multiblade, teetering, tip_path_plane
from floquet.modes import modes
from floquet.periodic import PeriodicSystem
from floquet.response import step_response
from floquet.rotor import Rotor
from floquet.sensitivity import of_system, plane_sensitivities, sensitivities
from floquet.tracking import track
from floquet.validity import lock_windows
from tests.support import distances
from tests.truth import blade_element, closed_forms

Array = NDArray[np.float64]
PSI = np.array([0.0, 0.4, 1.3, 2.9, 3.5, 4.7, 5.6])
ROTOR = Rotor(lock_number=8.0, hinge_offset=0.04, hinge_stiffness=0.1, pitch_flap_coupling=-0.1)


def mixed(N: int) -> list[Rotor]:
    """N blades of which no two are alike, in any parameter that has a rate of its own."""
    return [
        ROTOR.replace(
            lock_number=6.0 + 1.7 * i,
            hinge_offset=0.01 * (i + 1),
            hinge_stiffness=0.3 / (i + 1),
            pitch_flap_coupling=0.1 * (i - 1),
            flap_damping=0.02 * i,
        )
        for i in range(N)
    ]


def from_blades(N: int, psi: float, motion: Sequence[Array]) -> list[Array]:
    """q, q' and q'' from β, β' and β'' (N each) at ψ, by the sums of the definition, written without matrices.

    q_nc = (2/N) Σ β_i cos nψ_i and so on, and the derivatives of these products.
    """
    beta, rate, second = motion
    x = psi + 2.0 * math.pi * np.arange(N) / N

    def of(n: int, phase: float, weight: float) -> list[float]:
        wave = [n**k * np.cos(n * x - phase + 0.5 * k * math.pi) for k in range(3)]
        return [
            weight * float(wave[0] @ beta),
            weight * float(wave[1] @ beta + wave[0] @ rate),
            weight * float(wave[2] @ beta + 2.0 * wave[1] @ rate + wave[0] @ second),
        ]

    rows = [of(0, 0.0, 1.0 / N)]
    for n in range(1, (N - 1) // 2 + 1):
        rows += [of(n, 0.0, 2.0 / N), of(n, 0.5 * math.pi, 2.0 / N)]
    if N % 2 == 0:
        sign = (-1.0) ** np.arange(1, N + 1) / N
        rows.append([float(sign @ y) for y in (beta, rate, second)])
    return list(np.array(rows).T)


def matrices(system: PeriodicSystem) -> tuple[Array, Array, Array]:
    """D, K and F at PSI."""
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    return system.damping.sample(PSI), system.stiffness.sample(PSI), system.forcing.sample(PSI)


# ---------------------------------------------------------------------- exponents
@pytest.mark.parametrize("reversed_flow", [False, True])
@pytest.mark.parametrize("mu", [0.0, 0.35, 0.9])
@pytest.mark.parametrize("N", [2, 3, 4, 5])
def test_exponents_are_those_of_every_blade(N: int, mu: float, reversed_flow: bool) -> None:
    """Nothing couples the blades, so that the coordinates cannot matter: found 6e-15 at most, modulo i."""
    system = multiblade(mixed(N), mu, reversed_flow=reversed_flow)
    assert system.period == pytest.approx(2.0 * math.pi) and system.twist is None and system.blade is None
    found = stability(system)
    own = [stability(flapping(b, mu, reversed_flow=reversed_flow)).exponents for b in mixed(N)]
    off = distances(found.exponents, np.concatenate(own), 1.0)
    assert off.max() < 1e-13 and np.all(off <= np.max(found.exponent_errors) + 1e-14)


def test_symmetry_is_not_taken_of_blades_that_have_none() -> None:
    """With and without ``symmetry`` the same bits; blade 0, shifted by whole numbers, is a tenth per rev off."""
    system = multiblade(mixed(3), 0.3)
    a, b = stability(system), stability(system, symmetry=False)
    np.testing.assert_array_equal(a.exponents, b.exponents)
    first = np.tile(np.asarray(stability(flapping(mixed(3)[0], 0.3)).exponents), 3)
    assert distances(a.exponents, first, 1.0).max() > 0.1


@pytest.mark.parametrize("place", [0, 1, 3])
def test_one_blade_of_another_kind_is_found_wherever_it_stands(place: int) -> None:
    blades = [ROTOR] * 4
    blades[place] = ROTOR.replace(hinge_stiffness=0.09)
    found = stability(multiblade(blades, 0.3)).exponents
    own = [stability(flapping(b, 0.3)).exponents for b in blades]
    assert distances(found, np.concatenate(own), 1.0).max() < 1e-13


def test_growth_of_one_blade_is_growth_of_the_rotor() -> None:
    """K₁ = -0.3 with γ = 12 grows from μ = 0.97 on, without K₁ from 1.41 on."""
    calm, wild = Rotor(lock_number=12.0), Rotor(lock_number=12.0, pitch_flap_coupling=-0.3)
    for mu, verdict in ((0.9, Verdict.STABLE), (1.05, Verdict.UNSTABLE)):
        assert stability(multiblade([calm, calm, wild], mu)).verdict == verdict
        assert stability(multiblade([calm, calm, calm], mu)).verdict == Verdict.STABLE


@pytest.mark.parametrize("reversed_flow", [False, True])
@pytest.mark.parametrize("N", [2, 3, 4, 5])
def test_equal_blades_one_by_one_are_the_rotor(N: int, reversed_flow: bool) -> None:
    """Bit for bit; and to rounding where nobody could know that they are equal (numbers beside arrays of one case)."""
    rotor = multiblade(ROTOR.replace(blades=N), 0.35, reversed_flow=reversed_flow)
    listed = multiblade([ROTOR.replace() for _ in range(N)], 0.35, reversed_flow=reversed_flow)
    hidden = [ROTOR.replace(lock_number=np.array([8.0]))] + [ROTOR] * (N - 1)
    unseen = multiblade(hidden, 0.35, reversed_flow=reversed_flow)
    assert rotor.blade is not None and listed.blade is not None and unseen.blade is None
    for a, b, c in zip(matrices(rotor), matrices(listed), matrices(unseen), strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_allclose(c[0] if c.ndim == 4 else c, a, rtol=0, atol=4e-14 if reversed_flow else 1e-14)
    np.testing.assert_array_equal(stability(rotor).exponents, stability(listed).exponents)
    assert distances(stability(unseen).exponents[0], stability(rotor).exponents, 1.0).max() < 1e-13


def test_cases_of_blades_are_each_a_rotor() -> None:
    """Arrays in some blades, numbers in others, many advance ratios: every case is what it is alone."""
    kappa, mu = np.array([0.05, 0.1, 0.2]), np.array([[0.1], [0.4]])
    blades = [ROTOR, ROTOR.replace(hinge_stiffness=kappa), ROTOR.replace(lock_number=6.0)]
    found = stability(multiblade(blades, mu))
    assert found.exponents.shape == (2, 3, 6)
    for i in range(2):
        for j in range(3):
            one = stability(multiblade([blades[0], blades[1][j], blades[2]], float(mu[i, 0])))
            np.testing.assert_allclose(found.exponents[i, j], one.exponents, atol=1e-13)


# ---------------------------------------------------------------------- coefficients, motion
@pytest.mark.parametrize("reversed_flow", [False, True])
@pytest.mark.parametrize("N", [2, 3, 4, 5])
def test_equations_are_the_blade_elements_of_each_blade(N: int, reversed_flow: bool) -> None:
    """Any β and β' of the blades at ψ, with β'' of quadratures over each: their q solves q'' + D q' + K q = F u."""
    rng, mu = np.random.default_rng(N), 0.8
    blades = mixed(N)
    system = multiblade(blades, mu, exact_offset=True, reversed_flow=reversed_flow, kinematic_rates=True)
    D, K, F = matrices(system)
    for k, psi in enumerate(PSI):
        beta, rate, second, u = rng.normal(size=N), rng.normal(size=N), np.empty(N), rng.normal(size=len(FORCING))
        for i, b in enumerate(blades):
            truth = blade_element.Blade(
                gamma=float(b.lock_number), eps=float(b.hinge_offset), kappa=float(b.hinge_stiffness), mu=mu,
                K1=float(b.pitch_flap_coupling), m=float(b.offset_mass_ratio), s=float(b.static_moment_ratio),
                flap_damping=float(b.flap_damping), reversed_flow=reversed_flow, kinematic_rates=True,
            )  # fmt: skip
            x = psi + 2.0 * math.pi * i / N
            d, s = blade_element.damping(truth, x), blade_element.stiffness(truth, x)
            second[i] = blade_element.forcing(truth, x) @ u - d * rate[i] - s * beta[i]
        q, q1, q2 = from_blades(N, float(psi), (beta, rate, second))
        scale = 1.0 + np.abs(second).max()
        np.testing.assert_allclose(q2 + D[k] @ q1 + K[k] @ q, F[k] @ u, rtol=0, atol=1e-11 * scale)  # quadrature


@pytest.mark.parametrize("N", [2, 3, 4, 5])
def test_histories_of_the_blades_are_the_motion_of_the_coordinates(N: int) -> None:
    """Each blade under DOP853 with the transcribed coefficients of eq. (1) against one step response of the rotor."""
    mu, azimuths, u = 0.35, np.linspace(0.0, 9.0, 13), {"theta_0": 0.1, "B_1c": 0.04, "q_w": 0.02}
    vector = np.array([u.get(name, 0.0) for name in FORCING])
    start = 0.1 * np.random.default_rng(N).normal(size=(2, N))
    beta, rate = np.empty((N, 13)), np.empty((N, 13))
    for i, b in enumerate(mixed(N)):
        g, e, K1, m = b.lock_number, b.hinge_offset, b.pitch_flap_coupling, b.offset_mass_ratio
        c = closed_forms.truncated(g, e, b.hinge_stiffness, K1, mu, m)
        c["c0"] = c["c0"] + b.flap_damping
        f = closed_forms.forcing(g, e, mu, m, b.static_moment_ratio)

        def slope(psi: float, y: Array, i: int = i, c: Any = c, f: Any = f) -> list[float]:
            x = psi + 2.0 * math.pi * i / N
            push = closed_forms.blade_forcing(f, x) @ vector
            return [y[1], push - closed_forms.blade_damping(c, x) * y[1] - closed_forms.blade_stiffness(c, x) * y[0]]

        done = solve_ivp(slope, (0.0, 9.0), start[:, i], "DOP853", azimuths, rtol=1e-12, atol=1e-14)
        beta[i], rate[i] = done.y
    expected = [from_blades(N, psi, (beta[:, k], rate[:, k], np.zeros(N)))[:2] for k, psi in enumerate(azimuths)]
    found = step_response(multiblade(mixed(N), mu), u, azimuths, initial=np.concatenate(expected[0]))
    np.testing.assert_allclose(found.values, [q for q, _ in expected], atol=1e-10)  # of DOP853


def test_one_soft_blade_in_hover_makes_harmonics_of_one_and_two_per_rev() -> None:
    """K gains Δκ (w_n/N) c_n(ψ_j) c_m(ψ_j) of blade j, D nothing; equal blades in hover have constant coefficients."""
    N, j, less = 4, 2, -0.01
    blades = [ROTOR] * N
    blades[j] = ROTOR.replace(hinge_stiffness=0.1 + less)
    (D, K, F), (D0, K0, F0) = matrices(multiblade(blades, 0.0)), matrices(multiblade(ROTOR.replace(blades=N), 0.0))
    np.testing.assert_allclose(D, D0, atol=1e-14)
    np.testing.assert_allclose(F, F0, atol=1e-14)
    for psi, change in zip(PSI, K - K0, strict=True):
        x = psi + 2.0 * math.pi * j / N
        wave = np.array([1.0, np.cos(x), np.sin(x), (-1.0) ** (j + 1)])
        weight = np.array([1.0, 2.0, 2.0, 1.0]) / N
        np.testing.assert_allclose(change, less * weight[:, None] * wave[:, None] * wave, atol=1e-15)


# ---------------------------------------------------------------------- modes
@pytest.mark.parametrize("N", [2, 3, 4, 5])
def test_modes_stay_on_their_blade(N: int) -> None:
    """Each has all of its displacement on one blade and that blade's exponent, on the branch of its turns."""
    found = modes(multiblade(mixed(N), 0.3))
    assert found.blades is not None and found.blades.shape == (2 * N, N)
    np.testing.assert_allclose(found.blades.max(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(found.blades.sum(axis=1), 1.0, atol=1e-15)
    owners = np.argmax(found.blades, axis=1)
    assert found.names == tuple(f"blade {i}" for i in owners)
    for i, b in enumerate(mixed(N)):
        own = stability(flapping(b, 0.3))
        strip = math.inf if math.isnan(own.lock) else 1.0  # in a lock both signs of ρ are as good
        assert distances(found.exponents[owners == i], own.exponents, strip).max() < 1e-12


def test_mode_of_a_detuned_blade_is_in_all_coordinates_alike() -> None:
    """κ of blade 2 of four is a tenth less: its mode is (w_n/N) c_n(ψ_2) times that blade's, the others lack it.

    β₀ has 1/16 of |β|², β_1c and β_1s together 4/16, β_d 1/16: participation is 1/6, 2/3 and 1/6.
    """
    blades = [ROTOR] * 4
    blades[2] = ROTOR.replace(hinge_stiffness=0.09)
    found = modes(multiblade(blades, 0.3))
    assert found.blades is not None
    mine = [i for i, name in enumerate(found.names) if name == "blade 2"]
    assert len(mine) == 2 and sorted(found.names) == sorted(2 * tuple(f"blade {i}" for i in range(4)))
    np.testing.assert_allclose(found.blades.max(axis=1), 1.0, atol=1e-14)  # alike blades, too
    np.testing.assert_allclose(found.blades[mine], [[0.0, 0.0, 1.0, 0.0]] * 2, atol=1e-20)
    np.testing.assert_allclose(found.blades[[i for i in range(8) if i not in mine], 2], 0.0, atol=1e-20)
    share = found.participation[mine].sum(axis=2)
    np.testing.assert_allclose([s[[0, 3]] for s in share], 1.0 / 6.0, atol=1e-12)
    np.testing.assert_allclose(share[:, 1] + share[:, 2], 2.0 / 3.0, atol=1e-12)


def test_modes_of_equal_blades_are_on_all_of_them() -> None:
    found = modes(multiblade(ROTOR.replace(blades=3), 0.3))
    np.testing.assert_allclose(found.blades, 1.0 / 3.0, rtol=1e-15)
    assert set(found.names) == {"regressing", "coning", "advancing"}
    assert modes(flapping(ROTOR, 0.3)).blades is None
    assert modes(replace(multiblade(mixed(3), 0.3), coordinates=tuple("abc"))).blades is None


def test_modes_of_other_systems_in_these_coordinates_are_shared_by_their_blades() -> None:
    """Given as matrices, nobody knows that the blades are alone: the shares say it, names are those of whirl."""
    made = multiblade(mixed(3), 0.3)
    given = PeriodicSystem(
        period=made.period, damping=made.damping, stiffness=made.stiffness, coordinates=made.coordinates
    )
    found = modes(given)
    assert found.blades is not None and not any(name.startswith("blade") for name in found.names)
    np.testing.assert_allclose(found.blades.max(axis=1), 1.0, atol=1e-12)


def test_tracks_go_blade_by_blade() -> None:
    """Three alike and one whose κ passes theirs: where all are equal, too, each has its blade's exponents and locks."""
    kappa = np.linspace(0.08, 0.12, 5)
    found = track(lambda k: multiblade([ROTOR] * 3 + [ROTOR.replace(hinge_stiffness=k)], 0.7), kappa)
    assert found.names == tuple(f"blade {i}" for i in (0, 0, 1, 1, 2, 2, 3, 3)) and found.certain.all()
    for i in range(4):
        exact = stability(flapping(ROTOR.replace(hinge_stiffness=kappa if i == 3 else 0.1 + 0.0 * kappa), 0.7))
        for a, e in zip(found[f"blade {i}"], exact.exponents, strict=True):
            assert distances(a, e, 1.0).max() < 1e-13
    alone = track(lambda k: flapping(ROTOR.replace(hinge_stiffness=k), 0.7), kappa)
    np.testing.assert_array_equal(alone.exponents, found["blade 3"])
    assert [(e.kind, e.modes) for e in found.events] == [(e.kind, (6, 7)) for e in alone.events] != []


def test_tracks_of_a_changing_number_of_blades_are_refused() -> None:
    with pytest.raises(ParameterError, match="3 blades at one value and 2 at"):
        track(lambda m: multiblade(mixed(3 if m == 0.4 else 2), m), [0.0, 0.4])


def test_rates_are_those_of_each_blade_where_some_are_alike() -> None:
    """Rotors of two cases with two blades alike: their exponents coincide, their rates are still known."""
    blades = [ROTOR, ROTOR, ROTOR.replace(lock_number=np.array([6.0, 9.0]))]
    mu = np.array([[0.2], [0.3], [0.4]])
    found = sensitivities(blades, mu)
    eta = found.stability.exponents
    assert eta.shape == (3, 2, 6) and found.rates.shape == (3 * 9 + 1, 3, 2, 6) and found.trusted.all()
    for i, b in enumerate(blades):
        one = sensitivities(b, mu)
        rates = found[f"hinge_stiffness {i}"]
        for case in np.ndindex(3, 2):
            mine = np.flatnonzero(rates[case])
            assert len(mine) == 2
            at = (case[0], case[1] if i == 2 else 0)
            own = np.asarray(one.stability.exponents)[at]
            assert distances(eta[case][mine], own, 1.0).max() < 1e-12
            for name in ("hinge_stiffness", "lock_number", "hinge_offset"):
                assert distances(found[f"{name} {i}"][case][mine], one[name][at]).max() < 1e-13
            assert distances(found["advance_ratio"][case][mine], one["advance_ratio"][at]).max() < 1e-13


def test_rates_of_all_coordinates_are_those_blade_by_blade() -> None:
    found, whole = sensitivities(mixed(3), 0.2), of_system(multiblade(mixed(3), 0.2))
    for i in range(3):
        row = whole.parameters.index(f"lock_number {i}")
        assert np.all(np.abs(whole.rates[row] - found[f"lock_number {i}"]) <= whole.errors[row] + 1e-14)


# ---------------------------------------------------------------------- averages
def mean_of(system: PeriodicSystem) -> tuple[Array, Array]:
    assert system.damping is not None and system.stiffness is not None
    return system.damping.mean(), system.stiffness.mean()


@pytest.mark.parametrize("N", [3, 5])
def test_average_over_a_revolution_knows_the_mean_of_an_odd_number_of_blades_only(N: int) -> None:
    """Coefficients are linear in γ, κ and K₁γ: it is the averaged model of N blades like the mean, and says so."""
    kappa, gamma = 0.05 * np.arange(N), 6.0 + np.arange(N)
    blades = [Rotor(lock_number=g, hinge_stiffness=k) for g, k in zip(gamma, kappa, strict=True)]
    with pytest.warns(FloquetWarning, match="keeps the mean of the blades; their other differences are harmonics of 1"):
        found = averaged(blades, 0.3)
    same = averaged(Rotor(lock_number=gamma.mean(), hinge_stiffness=kappa.mean()), 0.3, (N - 1) // 2)
    for a, b in zip(mean_of(found), mean_of(same), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-14)
    assert found.coordinates == same.coordinates and found.constant and found.forcing is not None


def test_average_of_an_even_number_keeps_every_other_blade() -> None:
    """In hover (β₀, β_d) of blades A, B, A, B are exactly A and B, (β_1c, β_1s) the mean blade."""
    a, b = Rotor(lock_number=8.0, hinge_stiffness=0.2), Rotor(lock_number=6.0, hinge_stiffness=0.1)
    with pytest.warns(FloquetWarning, match="every other blade"):
        model = averaged([a, b, a, b], 0.0)
    found = np.asarray(stability(model).exponents)
    own = np.concatenate([stability(flapping(r, 0.0)).exponents for r in (a, b)])
    mean = np.asarray(stability(flapping(Rotor(lock_number=7.0, hinge_stiffness=0.15), 0.0)).exponents)
    expected = np.concatenate([own, mean - 1j * np.sign(mean.imag), mean + 1j * np.sign(mean.imag)])
    assert distances(found, expected).max() < 1e-13


def test_average_of_two_blades_loses_nothing_in_hover_and_does_not_warn() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = averaged(mixed(2), 0.0)
        averaged([ROTOR] * 3, 0.3)  # nothing differs
    own = np.concatenate([stability(flapping(b, 0.0)).exponents for b in mixed(2)])
    assert distances(stability(model).exponents, own).max() < 1e-13


def test_average_is_wrong_by_the_order_of_the_difference_and_that_of_each_blade_alone_is_not() -> None:
    """δ of κ halved halves the error in hover, where averages of equal blades are exact; alone it is rounding."""

    def off(less: float) -> float:
        blades = [ROTOR, ROTOR, ROTOR.replace(hinge_stiffness=0.1 - less)]
        with pytest.warns(FloquetWarning):
            model = averaged(blades, 0.0)
        own = np.concatenate([stability(flapping(b, 0.0)).exponents for b in blades])
        alone = [np.asarray(stability(averaged(b, 0.0)).exponents) for b in blades]
        for b, found in zip(blades, alone, strict=True):
            assert distances(found, np.tile(np.asarray(stability(flapping(b, 0.0)).exponents), 3), 1.0).max() < 1e-13
        return float(distances(stability(model).exponents, own, 1.0).max())

    assert off(0.01) / off(0.005) == pytest.approx(2.0, rel=0.02)
    slope = 0.5 * 2.0 / 3.0 / float(np.abs(np.asarray(stability(flapping(ROTOR, 0.0)).exponents)[0].imag))
    assert off(0.001) == pytest.approx(0.001 * slope, rel=0.01)  # the soft blade moves by δ/(2ω), the mean by a third


# ---------------------------------------------------------------------- what cannot be
@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: multiblade([ROTOR.replace(blades=5)] * 3, 0.3), "3 blades were given.*of a rotor of 5.*blades=3"),
        (lambda: multiblade([ROTOR.replace(lock_number=[6.0, 8.0]), ROTOR.replace(lock_number=[6.0, 7.0, 8.0])], 0.3),
         r"shapes \(2,\), \(3,\), which do not broadcast"),
        (lambda: multiblade([ROTOR, "b"], 0.3), "'b' is no Rotor"),
        (lambda: multiblade("ab", 0.3), "'ab' is no Rotor"),
        (lambda: multiblade(3, 0.3), "3 is no Rotor"),
        (lambda: multiblade([], 0.3), "at least 2 blades"),
        (lambda: averaged(mixed(5), 0.3, 1), "5 blades that are given one by one have 2 harmonics, not 1"),
        (lambda: averaged("ab", 0.3), "'ab' is no Rotor"),
        (lambda: flapping(mixed(2), 0.3), "a list is no Rotor.*multiblade and averaged"),
        (lambda: teetering(mixed(2), 0.3), "a list is no Rotor"),
        (lambda: tip_path_plane(tuple(mixed(3)), 0.3), "a tuple is no Rotor"),
        (lambda: compare(mixed(3), 0.3), "a list is no Rotor"),
        (lambda: lock_windows(mixed(3)), "a list is no Rotor"),
        (lambda: plane_sensitivities(mixed(3), 0.3), "a list is no Rotor"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_sentence(call: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        call()
