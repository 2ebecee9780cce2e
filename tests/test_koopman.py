"""Koopman–Hill projection against exponents that are known, and against the period map as a check that can fail."""

from __future__ import annotations

import json
import math
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from floquet import koopman
from floquet.errors import FailedError, FloquetWarning, ParameterError
from floquet.exponents import stability
from floquet.koopman import HillCheck, disagreement, koopman_hill, require_agreement
from floquet.models import flapping, multiblade, teetering, textbook, tip_path_plane
from floquet.periodic import PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor

EXPONENTS = json.loads((Path(__file__).parent.parent / "data" / "reference" / "exponents.json").read_text())["cases"]
ONE = Rotor(lock_number=8.0, hinge_offset=0.05)
F = np.array([[-0.3, 2.0, 0.5, 0.0], [-0.1, -0.4, 0.0, 3.0], [0.0, 0.25, -0.2, 1.0], [0.125, 0.0, -1.5, -0.6]])


def known(exponents: Any, errors: float = 0.0) -> Any:
    """Exponents as a result whose bound is given."""
    values = np.asarray(exponents, complex)
    return SimpleNamespace(exponents=values, exponent_errors=np.full(values.shape, errors))


@pytest.mark.parametrize(
    ("system", "exponents", "error"),
    [
        (textbook.mathieu(1.0, 0.1), [0.049941570198413031 + 1j, -0.049941570198413031 + 1j], 1e-13),
        (textbook.mathieu(2.0, 1.0), [1.2165762565478773j, -1.2165762565478773j], 1e-13),
        (textbook.zhou_hagiwara(math.pi), [-1, -2], 1e-13),
        (textbook.zhou_hagiwara(math.pi / 2), [-1 + 2j, -2 + 2j], 1e-13),
        (textbook.bittanti_colaneri(), [-1, -3], 1e-12),
        (textbook.rotating_frame(F), np.linalg.eigvals(F), 1e-11),
        (textbook.rotating_frame([[-0.25, 1.0], [0.0, -0.25]]), [-0.25, -0.25], 1e-5),  # the root of rounding
        (textbook.colaneri(), [0, -24], 1e-4),  # of the second; multipliers are 65 decades apart
    ],
    ids=["mathieu-lock", "mathieu", "zhou-pi", "zhou-pi/2", "bittanti", "rotating", "jordan", "colaneri"],
)
def test_exponents_are_the_known_ones(system: PeriodicSystem, exponents: Any, error: float) -> None:
    check = koopman_hill(system)
    assert check.converged and np.all(check.exponent_errors < error)
    assert disagreement(known(exponents), check) <= 1.0


def test_maps_are_the_known_ones() -> None:
    """Φ(2π) = exp(2πF) exactly, to rounding in its norm of about 10."""
    check = koopman_hill(textbook.rotating_frame(F))
    assert np.abs(check.monodromy - expm(2.0 * math.pi * F)).max() < 1e-12
    assert check.harmonics == 18 and check.monodromy.shape == (4, 4)


def test_blades_of_the_reference() -> None:
    """150 random ones, 30 digits: all within the estimate, which is near rounding for most."""
    cases = [c for c in EXPONENTS if c["set"] == "random" and not c["options"]["exact_offset"]]
    names = [n for n in cases[0]["parameters"] if n != "advance_ratio"]
    rotor = Rotor(**{n: np.array([c["parameters"][n] for c in cases]) for n in names})
    check = koopman_hill(flapping(rotor, [c["parameters"]["advance_ratio"] for c in cases]))
    stored = [[complex(float(re), float(im)) for re, im in c["exponents"]] for c in cases]
    assert check.converged.all() and np.all(disagreement(known(stored, 1e-15), check) <= 1.0)
    assert np.median(check.exponent_errors) < 1e-12
    lowest = np.array(stored).real.min(axis=-1) * 2.0 * math.pi
    assert check.exponent_errors[lowest > -8.0].max() < 1e-9


@pytest.mark.parametrize("blades", [3, 4])
def test_passage_with_its_twist(blades: int) -> None:
    """Identical blades: the blade's exponents + ik, modulo Ni, over 2π/N with β_d reversed for even N."""
    check = koopman_hill(multiblade(ONE.replace(blades=blades), 0.3))
    one = stability(flapping(ONE, 0.3)).exponents
    wanted = [z + 1j * k for z in one for k in range(blades)]
    assert check.converged and disagreement(known(wanted, 1e-14), check) <= 1.0
    assert check.exponent_errors.max() < 1e-11


@pytest.mark.parametrize(
    "system",
    [
        flapping(ONE.replace(lock_number=np.array([[2.0, 8.0, 16.0]])), np.array([[0.2], [1.2]])),
        teetering(Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING), [0.4, 0.8]),
        multiblade([ONE, ONE, ONE.replace(lock_number=9.0)], 0.3),
        PeriodicSystem.from_function(lambda t: [[0, 1], [-math.exp(math.cos(t)), -0.1]], 2.0 * math.pi),
        PeriodicSystem.from_function(lambda t: [[0, 1], [-1 / (1.3 + math.cos(t)), -0.1]], 2.0 * math.pi),
    ],
    ids=["flapping", "teetering", "dissimilar", "exp(cos t)", "1/(1.3 + cos t)"],
)
def test_agrees_with_the_period_map(system: PeriodicSystem) -> None:
    found, check = stability(system), koopman_hill(system)
    assert check.converged.shape == check.harmonics.shape == system.cases and check.converged.all()
    assert check.exponents.shape == (*system.cases, system.states)
    require_agreement(found, check)
    assert np.max(check.exponent_errors) < 1e-9  # so that agreement says something


@pytest.mark.parametrize(
    ("system", "error"),
    [
        (textbook.meissner(1.0, -0.2, 0.1, fraction=1.0 / 3.0), 1e-4),
        (textbook.hill_sawtooth(1.0, -0.2, 0.1), 1e-4),
        (flapping(ONE, 0.8, reversed_flow=True, exact_offset=True), 1e-7),
    ],
    ids=["jump", "jump at the end", "third derivative"],
)
def test_kinks_converge_slowly_and_say_so(
    monkeypatch: pytest.MonkeyPatch, system: PeriodicSystem, error: float
) -> None:
    monkeypatch.setattr(koopman, "LARGEST", 400)  # three seconds less
    check = koopman_hill(system)
    assert not check.converged and 1e-12 < check.exponent_errors.max() < error
    require_agreement(stability(system), check)


@pytest.mark.parametrize(
    ("a", "b", "damping", "fraction"),
    [(2.70524, -0.813122, 0.0594672, 0.609027), (1.90831, -0.874695, 0.0335243, 0.228966)],
)
def test_differences_that_are_small_by_chance(a: float, b: float, damping: float, fraction: float) -> None:
    """N = 60 and 90 agree there 10 and 3 times better than either with the truth."""
    system = textbook.meissner(a, b, damping, fraction=fraction)
    assert disagreement(stability(system), koopman_hill(system)) < 0.5


@pytest.mark.parametrize("shift", [1e-9, 1e-9j, 1e-3])
def test_a_wrong_exponent_is_noticed(shift: complex) -> None:
    system = flapping(ONE, [0.2, 0.3])
    found, check = stability(system), koopman_hill(system)
    wrong = SimpleNamespace(exponents=found.exponents.copy(), exponent_errors=found.exponent_errors)
    wrong.exponents[1, 0] += shift
    assert disagreement(wrong, check)[0] <= 1.0 < disagreement(wrong, check)[1]
    with pytest.raises(FailedError, match=r"differ by .* times the bounds of both"):
        require_agreement(wrong, check)


def test_exponents_are_compared_modulo_the_strip() -> None:
    check = koopman_hill(textbook.mathieu(2.0, 1.0))  # period π
    z = 1.2165762565478773j
    assert disagreement(known([z + 4j, -z - 2j]), check) <= 1.0 < disagreement(known([z + 1j, -z]), check)
    assert np.all(np.abs(check.exponents.imag) <= 1.0)


@pytest.mark.parametrize("G", [1, 2, 7])
def test_one_root_of_each_multiplier(G: int) -> None:
    """Roots on the edges of every obvious sector: negative, real and complex multipliers, one of them double."""
    multipliers = np.array([-0.5, -0.5, 2.0, 0.3 + 0.4j, 0.3 - 0.4j, -1e-9])
    roots = np.concatenate(
        [m ** (1 / G) * np.exp(2j * math.pi * np.arange(G) / G) for m in multipliers.astype(complex)]
    )
    chosen = roots[koopman._sector(roots, G, len(multipliers))] ** G
    assert np.allclose(np.sort_complex(chosen.round(6)), np.sort_complex(multipliers.round(6)), atol=1e-6)


def test_roots_beside_the_cut() -> None:
    """Square roots of 2, 3 and -1 with rounding on either side of the real axis: a cut there would count 2 twice."""
    angles = {2.0: (1e-9, math.pi - 3e-9), 3.0: (-1e-9, math.pi - 2e-9), -1.0: (0.5 * math.pi, 1.5 * math.pi)}
    roots = np.array([math.sqrt(abs(m)) * np.exp(1j * a) for m, both in angles.items() for a in both])
    assert sorted((roots[koopman._sector(roots, 2, 3)] ** 2).real.round(6)) == [-1.0, 2.0, 3.0]


def test_constant_systems_are_refused() -> None:
    with pytest.raises(ParameterError, match="eigenvalues of its matrix"):
        koopman_hill(tip_path_plane(ONE, 0.3))


def test_coefficients_are_those_of_the_series() -> None:
    t = 2.0 * math.pi * np.arange(64) / 64
    samples = (1.0 + 2.0 * np.cos(3 * t) + 4.0 * np.sin(5 * t))[:, None, None]
    A = koopman._transformed(samples, 12)[:, 0, 0]
    wanted = {0: 1.0, 3: 1.0, -3: 1.0, 5: -2.0j, -5: 2.0j}
    assert all(abs(A[k + 24] - wanted.get(k, 0.0)) < 1e-14 for k in range(-24, 25))


@pytest.mark.parametrize("fraction", [0.5, 1.0 / 3.0])
def test_coefficients_between_kinks_are_integrals(fraction: float) -> None:
    """A square wave, one on ``fraction`` of the period: (1 - e^{-2πik fraction})/(2πik)."""
    system = textbook.meissner([1.0, 2.0], -1.0, fraction=fraction)
    harmonics, scale, size = koopman._spectrum(system, system.period)
    k = np.arange(-180, 181)
    wave = np.where(k == 0, fraction, (1.0 - np.exp(-2j * math.pi * k * fraction)) / (2j * math.pi * np.where(k, k, 1)))
    for case, a in enumerate((1.0, 2.0)):
        found = -harmonics(90)[case, :, 1, 0] * scale[case, 1]  # a + 1 but for 2 on the wave
        assert np.abs(found - ((a + 1.0) * (k == 0) - 2.0 * wave)).max() < 1e-13
    np.testing.assert_array_equal(scale, [[1.0, 1.0], [1.0, 2.0]])  # √2 and √3, to powers of two
    assert np.allclose(size, [2.0, 2.0])  # a + 1 over the scale, or the scale


def test_kinks_of_the_passage_are_those_of_the_base() -> None:
    """With a twist the coefficients repeat after two passages, and every piece is met again."""
    edges = np.array([0.0, 1.0, 4.0, 2.0 * math.pi])
    A = PeriodicMatrix.pieces([PeriodicMatrix.constant([[x]]) for x in (-1.0, -2.0, -1.0)], edges)
    system = PeriodicSystem(period=2.0 * math.pi, matrix=A, twist=np.array([-1.0]))
    breaks = koopman._breaks(system, 4.0 * math.pi)
    assert breaks is not None and np.allclose(np.unique(breaks), [*edges, *(edges[1:] + 2.0 * math.pi)])
    check = koopman_hill(system)
    assert disagreement(known([-(2.0 * math.pi + 3.0) / (2.0 * math.pi) + 0.5j]), check) <= 1.0


def test_high_frequencies_need_few_factors() -> None:
    """√9000 = 95 a radian, in coordinates of one size: 100 factors a period, not 9000."""
    system = textbook.mathieu(9000.0, 0.3, 0.1)
    check = koopman_hill(system)
    assert check.exponent_errors.max() < 1e-11 and check.converged
    require_agreement(stability(system), check)
    multipliers = np.exp(stability(system).exponents * system.period)
    np.testing.assert_allclose(*map(np.sort_complex, (np.linalg.eigvals(check.monodromy), multipliers)), atol=1e-10)


def test_what_would_not_end_is_refused() -> None:
    for a in (1e9, 1e300):
        with pytest.raises(FailedError, match="leave out check"):
            koopman_hill(textbook.mathieu(a, 0.3))


def test_cases_do_not_depend_on_how_many_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    system = flapping(Rotor(lock_number=np.array([[4.0], [6.0], [8.0]])), np.array([0.1, 0.5]))
    whole = koopman_hill(system)
    monkeypatch.setattr(koopman, "ENTRIES", 8)
    parts = koopman_hill(system)
    for name in ("exponents", "exponent_errors", "monodromy", "harmonics"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(parts, name))


def test_a_check_that_says_little_says_so() -> None:
    """A square wave: declared, and declared or not at the edge of a panel; a smooth system is confirmed in silence."""
    with pytest.warns(FloquetWarning, match="was not declared is in neither bound"):
        assert stability(textbook.meissner(2.7, -0.8, 0.1, fraction=0.6), check=True).check is not None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        stability(flapping(ONE, 0.3), check=True)


def test_result_is_frozen() -> None:
    check = koopman_hill(textbook.bittanti_colaneri())
    assert isinstance(check, HillCheck) and check.period == 2.0 * math.pi
    with pytest.raises(AttributeError):
        check.period = 1.0  # type: ignore[misc]
