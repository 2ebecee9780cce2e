"""Boundaries along any parameter and in planes: Mathieu's values, published transitions, known curves."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from floquet import Hub, Rotor, boundaries, flapping, lock_windows, multiblade, teetering, tip_path_plane, transitions
from floquet.errors import ParameterError
from floquet.models.textbook import mathieu
from floquet.periodic import PeriodicMatrix, PeriodicSystem
from floquet.validity import BoundaryCurve, crossings
from floquet.validity.curves import Curve
from tests.support import REFERENCE

Array = np.ndarray[Any, Any]


def spring(k: Array) -> PeriodicSystem:
    """q'' + k q = 0: locked where k < 0, and nowhere else for k < (π/T)²."""
    return PeriodicSystem(stiffness=PeriodicMatrix.constant(k[:, None, None], 0.5), period=0.5)


def characteristic(order: int, odd: bool, q: Array) -> Array:
    return np.array([(mathieu_b if odd else mathieu_a)(order, value) for value in q])


def closed(curve: BoundaryCurve) -> bool:
    return bool(curve.x[0] == curve.x[-1] and curve.y[0] == curve.y[-1])


# ---------------------------------------------------------------------- along one parameter
def test_mathieus_characteristic_values_are_all_found() -> None:
    """Fourteen to a = 50, windows down to 1e-7."""
    q = 0.8
    values, rho = transitions(lambda a: mathieu(a, q), -1.0, 50.0)
    known = [(float(mathieu_a(0, q)), 0), *((float(f(n, q)), n) for n in range(1, 8) for f in (mathieu_b, mathieu_a))]
    expected = np.array(sorted(pair for pair in known if pair[0] < 50.0))
    while len(expected) > len(values) and np.diff(expected[-2:, 0]) < 51e-9:  # narrower than a billionth of the range
        expected = expected[:-2]
    np.testing.assert_allclose(values, expected[:, 0], atol=3e-9)
    np.testing.assert_array_equal(rho, expected[:, 1])


def test_edges_of_rotors_are_those_along_the_advance_ratio() -> None:
    """One blade, several and teetering, whatever is the parameter."""
    rotor = Rotor(lock_number=12.0)
    windows = lock_windows(rotor, 1.5)
    for model in (flapping, lambda r, mu: multiblade(r.replace(blades=4), mu)):
        mu, rho = transitions(lambda mu, model=model: model(rotor, mu), 0.0, 1.5)  # type: ignore[misc]
        ends = [end for window in windows for end in window[:2] if 0.0 < end < math.inf]
        np.testing.assert_allclose(mu, ends, atol=1e-12)
        assert set(rho) <= {window[2] for window in windows}
    seesaw = Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING)
    enter = lock_windows(seesaw)[0][0]
    gamma, _ = transitions(lambda g: teetering(seesaw.replace(lock_number=g), enter), 6.0, 10.0)
    assert np.abs(gamma - 8.0).min() < 1e-10


def test_growth_begins_where_it_is_published() -> None:
    known = json.loads((REFERENCE / "transitions.json").read_text())
    for gamma in (4, 12, 16):
        onset = known[f"single:fig6:{gamma}"]["instability_mu"]
        mu, _ = transitions(lambda mu, g=gamma: flapping(Rotor(lock_number=g), mu), 0.0, onset + 0.1, kind="growth")  # type: ignore[misc]
        assert mu[0] == pytest.approx(onset, abs=1e-11)


# ---------------------------------------------------------------------- planes
def test_strutt_diagram() -> None:
    """Every point of every tongue is a characteristic value; all tongues down to their tips at q = 0."""
    curves = boundaries(mathieu, (-2.0, 17.0), (0.0, 10.0))
    covered = {}
    for curve in curves:
        (order,) = set(curve.rotation_number.tolist())
        n = int(order)
        branches = [characteristic(n, odd, curve.y) for odd in (True, False) if n or not odd]
        error = np.min([np.abs(branch - curve.x) for branch in branches], axis=0)
        assert error.max() < 5e-10
        covered[n] = covered.get(n, 0) + len(curve.x)
        if n:
            assert curve.y.min() < 0.5  # the tip
            sides = [np.abs(branch - curve.x) < 1e-8 for branch in branches]
            assert all(side.any() for side in sides)
    assert sorted(covered) == [0, 1, 2, 3, 4] and min(covered.values()) > 15


def test_curves_close_and_do_not_cross() -> None:
    """A circle comes back to where it began; branches of a hyperbola 0.02 apart within one mesh stay apart."""
    (circle,) = boundaries(lambda x, y: spring(x**2 + y**2 - 1.0), (-2.0, 2.0), (-2.0, 2.0), meshes=9)
    assert closed(circle) and len(circle.x) > 20
    np.testing.assert_allclose(np.hypot(circle.x, circle.y), 1.0, atol=1e-12)
    turn = np.unwrap(np.arctan2(circle.y, circle.x))
    assert abs(abs(turn[-1] - turn[0]) - 2.0 * math.pi) < 1e-9 and len(set(np.sign(np.diff(turn)))) == 1
    for sign in (1.0, -1.0):
        branches = boundaries(lambda x, y, s=sign: spring(s * x * y - 1e-4), (-1.0, 1.2), (-1.1, 1.0), meshes=4)  # type: ignore[misc]
        assert len(branches) == 2
        for branch in branches:
            np.testing.assert_allclose(branch.x * branch.y, sign * 1e-4, atol=1e-12)
            assert len(set(np.sign(branch.x))) == 1 and not closed(branch)


def test_a_narrow_tongue_keeps_its_two_sides() -> None:
    """A strip of width 1e-7 across the net, straight through and in at one end."""
    strip = boundaries(lambda x, y: spring((x - 0.3 * y) ** 2 - 1e-14 + 0.0 * y), (-1.0, 1.0), (0.0, 1.0), meshes=6)
    assert len(strip) == 2
    for curve in strip:
        side = curve.x - 0.3 * curve.y
        np.testing.assert_allclose(np.abs(side), 1e-7, rtol=1e-4)
        assert len(set(np.sign(side))) == 1 and {curve.y.min(), curve.y.max()} == {0.0, 1.0}
    (tongue,) = boundaries(lambda x, y: spring(x**2 - 1e-3 * (y - 0.5)), (-1.0, 1.0), (0.0, 1.0), meshes=6)
    np.testing.assert_allclose(tongue.x**2, 1e-3 * (tongue.y - 0.5), atol=1e-12)
    assert tongue.y[0] == tongue.y[-1] == 1.0 and tongue.y.min() < 0.6


@pytest.mark.parametrize("width", [0.05, 0.01, 0.001])
def test_a_tongue_that_comes_in_across_a_corner_has_its_tip(width: float) -> None:
    """Its axis is a diagonal of the net, so that one side of it passes a side of the last mesh, and one another."""
    place = 0.613

    def family(x: Array, y: Array) -> PeriodicSystem:
        along, beside = (x + y) / math.sqrt(2.0), (x - y) / math.sqrt(2.0)
        return spring(beside**2 - width**2 * (along - place))

    (curve,) = boundaries(family, (0.0, 1.0), (0.0, 1.0), meshes=8)
    tip = place / math.sqrt(2.0)
    assert np.hypot(curve.x - tip, curve.y - tip).min() < 0.02 / 8


@pytest.mark.parametrize(("middle", "half"), [(y, 0.03) for y in (0.32, 0.36, 0.41, 0.47, 0.5, 0.68)] + [(0.41, 0.001)])
def test_a_tongue_that_is_pinched_off_within_a_mesh_has_two_tips(middle: float, half: float) -> None:
    """Half a mesh, or a hundredth, is missing of a tongue of a hundredth of a mesh, however the net cuts it."""
    tongues = boundaries(
        lambda x, y: spring((x - 0.5 - 0.3 * (y - 0.5)) ** 2 - 1e-4 * ((y - middle) ** 2 - half**2)),
        (0.0, 1.0),
        (0.0, 1.0),
        meshes=8,
    )
    below, above = sorted(tongues, key=lambda curve: float(curve.y.min()))
    assert below.y[0] == below.y[-1] == 0.0 and above.y[0] == above.y[-1] == 1.0
    assert below.y.max() == pytest.approx(middle - half, abs=0.002) and below.y.max() < middle - half
    assert above.y.min() == pytest.approx(middle + half, abs=0.002) and above.y.min() > middle + half


def test_a_boundary_along_the_border_is_one_curve() -> None:
    for ends in ((0.0, 1.0), (1.0, 2.0)):
        (border,) = boundaries(lambda x, y: spring(x - 1.0 + 0.0 * y), ends, (0.0, 1.0), meshes=8)
        assert np.all(border.x == 1.0) and sorted(border.y) == pytest.approx(border.y) and len(border.x) == 9
        assert (border.y[0], border.y[-1]) == (0.0, 1.0)
    half = boundaries(lambda x, y: spring(x * x + y * y - 1.0), (-1.0, 1.0), (0.0, 1.0), meshes=8)
    assert sorted(x for curve in half for x, y in zip(curve.x, curve.y, strict=True) if y == 0.0) == [-1.0, 1.0]


def test_an_end_on_a_boundary_is_a_transition() -> None:
    """Mathieu's equation with a = 4 is locked for every q > 0, and at the edge of the lock for q = 0."""
    values, rho = transitions(lambda q: mathieu(4.0 + 0.0 * q, q), 0.0, 1.0)
    np.testing.assert_array_equal(values, [0.0])
    np.testing.assert_array_equal(rho, [2.0])


def test_what_passes_a_level_by_less_than_rounding_is_decided_by_more_digits() -> None:
    """A dome of 1e-5 over a range, 1.3e-15 of it above 1: the polynomial lies below or above, as it is rounded."""
    for centre in np.random.default_rng(1).uniform(0.2, 0.8, 40):

        def beyond(level: float, centre: float = float(centre)) -> Curve:
            return lambda case, t: (1.0 - level) + (1.3e-15 - 1.1e-5 * (t - centre) ** 2)

        found = crossings(beyond(0.0), np.zeros(1), np.ones(1), (1.0,), exact=beyond, least=1e-9)
        np.testing.assert_allclose(found.x, centre + np.array([-1.0, 1.0]) * math.sqrt(1.3e-15 / 1.1e-5), atol=1e-9)


@pytest.mark.parametrize("end", [0.25, 0.5, 0.625])
def test_passages_about_the_end_of_a_piece_are_found_once(end: float) -> None:
    """Such a dome where two pieces meet: each finds those that are its own."""
    for centre in end + np.linspace(-2e-5, 2e-5, 41):

        def beyond(level: float, centre: float = float(centre)) -> Curve:
            return lambda case, t: (1.0 - level) + (1.3e-15 - 1.1e-5 * (t - centre) ** 2)

        found = crossings(beyond(0.0), np.zeros(1), np.ones(1), (1.0,), exact=beyond, least=1e-9)
        np.testing.assert_allclose(found.x, centre + np.array([-1.0, 1.0]) * math.sqrt(1.3e-15 / 1.1e-5), atol=1e-9)


def test_locks_of_the_plane_of_lock_number_and_advance_ratio() -> None:
    """The curves pass γ = 8 and 14 where the windows of these rotors end."""
    curves = boundaries(lambda g, mu: flapping(Rotor(lock_number=g), mu), (2.0, 16.0), (0.0, 1.5), meshes=30)
    assert {rho for curve in curves for rho in curve.rotation_number.tolist()} == {0.5, 1.0}
    for gamma in (8.0, 12.0, 14.0):
        ends = [end for window in lock_windows(Rotor(lock_number=gamma), 1.5) for end in window[:2] if 0 < end < 9]
        found = []
        for curve in curves:
            for i in np.flatnonzero(np.diff(curve.x > gamma)):
                share = (gamma - curve.x[i]) / (curve.x[i + 1] - curve.x[i])
                found.append(curve.y[i] + share * (curve.y[i + 1] - curve.y[i]))
        np.testing.assert_allclose(sorted(found), sorted(ends), atol=2e-3)  # chords of the net


# ---------------------------------------------------------------------- bad input
def test_what_has_no_boundaries_is_refused() -> None:
    one = Rotor(lock_number=8.0)
    for family, ends, message in (
        (lambda a: mathieu(a, 0.3), (2.0, 1.0), "no range"),
        (lambda a: mathieu(a, 0.3), (0.0, math.inf), "no range"),
        (3.0, (0.0, 1.0), "no family: give a function"),
        (lambda a: 3.0, (0.0, 1.0), "gives float"),
        (lambda mu: tip_path_plane(one, mu), (0.0, 1.0), "one scalar equation"),
        (lambda a: mathieu(1.0, 0.3), (0.0, 1.0), "one case a value"),
    ):
        with pytest.raises(ParameterError, match=message):
            transitions(family, *ends)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="did you mean 'growth'"):
        transitions(lambda a: mathieu(a, 0.3), 0.0, 1.0, kind="grow")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="no net"):
        boundaries(mathieu, (0.0, 1.0), (0.0, 1.0), meshes=1)
    with pytest.raises(ParameterError, match="mean damping is negative"):
        transitions(lambda a: mathieu(a, 1.0, -0.2), 0.0, 3.0, kind="growth")
    (diagonal,) = boundaries(lambda x, y: spring(x - y), (0.0, 1.0), (0.0, 1.0), meshes=8)
    assert len(diagonal.x) > 10  # through no corner of the net but the two at its ends
    assert boundaries(mathieu, (1.5, 3.5), (0.0, 0.1), meshes=4) == ()
