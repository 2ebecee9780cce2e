"""Modes along a parameter: against the rotation number, the blade + ik, closed forms; in any order, on any grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.models import averaged, flapping, hover_modes, multiblade, teetering, tip_path_plane
from floquet.models.textbook import mathieu
from floquet.periodic import PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor
from floquet.tracking import TOUCH, Meeting, Track, track
from floquet.validity import lock_windows
from tests.support import distances

Complex = NDArray[np.complex128]
Family = Callable[[float], PeriodicSystem]
GAMMAS = np.linspace(4.0, 15.5, 24)


def blades(count: int, mu: float) -> Family:
    return lambda gamma: multiblade(Rotor(lock_number=gamma, hinge_offset=0.05, hinge_stiffness=0.1, blades=count), mu)


def oscillators(coupling: float, damping: float = 0.05) -> Family:
    """Frequencies² 1 + p and 2 - p, coupled: they would meet at p = ½."""
    D = PeriodicMatrix.constant(damping * np.eye(2))

    def family(p: float) -> PeriodicSystem:
        K = PeriodicMatrix.constant([[1.0 + p, coupling], [coupling, 2.0 - p]])
        return PeriodicSystem(period=math.nan, damping=D, stiffness=K)

    return family


def oscillator_exponents(p: NDArray[np.float64], coupling: float, damping: float = 0.05) -> Complex:
    """With Im > 0, the slower first, (k, 2)."""
    split = np.hypot(p - 0.5, coupling)
    omega = np.sqrt(np.stack([1.5 - split, 1.5 + split], axis=-1) - damping**2 / 4.0)
    return -0.5 * damping + 1j * omega


def kinds(found: Track) -> list[Meeting]:
    return [event.kind for event in found.events]


# ---------------------------------------------------------------------- one blade
@pytest.mark.parametrize("reversed_flow", [False, True])
def test_one_blade_keeps_its_rotation_number(reversed_flow: bool) -> None:
    """Through γ = 12's locks: C and the turns counted on the way agree, and events are its lock windows."""
    rotor, mu = Rotor(lock_number=12.0), np.linspace(0.0, 1.5, 31)
    found = track(lambda m: flapping(rotor, m, reversed_flow=reversed_flow), mu)
    exact = stability(flapping(rotor, mu, reversed_flow=reversed_flow))
    free = np.isnan(exact.lock)
    np.testing.assert_allclose(found.exponents[free], exact.exponents[free], atol=1e-12)
    for a, b in zip(found.exponents[~free], exact.exponents[~free], strict=True):
        assert distances(a, b, 1.0).max() < 1e-12 and a[0].real > a[1].real
    assert found.certain.all()
    edges = [e for w in lock_windows(rotor, mu_max=1.5, reversed_flow=reversed_flow) for e in w[:2] if math.isfinite(e)]
    assert len(edges) == len(found.events)
    assert all(event.low <= edge <= event.high for edge, event in zip(edges, found.events, strict=True))
    assert kinds(found) == [Meeting.LOCK, Meeting.UNLOCK, Meeting.LOCK][: len(edges)]


def test_one_blade_through_several_locks_at_once() -> None:
    """From ρ = 1 to beyond 3/2, and Mathieu's equation from 0 to 3 per π: the branch behind each lock is the next."""
    kappa = np.linspace(0.0, 3.0, 13)
    found = track(lambda k: flapping(Rotor(lock_number=8.0, hinge_stiffness=k), 0.8), kappa)
    exact = stability(flapping(Rotor(lock_number=8.0, hinge_stiffness=kappa), 0.8))
    free = np.isnan(exact.lock)
    np.testing.assert_allclose(found.exponents[free], exact.exponents[free], atol=1e-12)
    assert kinds(found) == [Meeting.LOCK, Meeting.UNLOCK] * 2
    a = np.linspace(0.5, 10.0, 20)
    found, exact = track(lambda x: mathieu(x, 0.4), a), stability(mathieu(a, 0.4))
    free = np.isnan(exact.lock)
    own = found.exponents[free]
    np.testing.assert_allclose(own - own[0], (exact.exponents - exact.exponents[free][0])[free], atol=1e-12)


def test_teetering_rotor() -> None:
    rotor, kappa = Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING), np.linspace(0.0, 1.5, 13)
    found = track(lambda k: teetering(rotor.replace(hinge_stiffness=k), 0.8), kappa)
    exact = stability(teetering(rotor.replace(hinge_stiffness=kappa), 0.8))
    free = np.isnan(exact.lock)
    assert kinds(found) == [Meeting.UNLOCK] and 0 < free.sum() < len(free)
    np.testing.assert_allclose(found.exponents[free], exact.exponents[free], atol=1e-12)


# ---------------------------------------------------------------------- coupled coordinates of identical blades
@pytest.mark.parametrize("count", [3, 4, 5])
@pytest.mark.parametrize("mu", [0.0, 0.3, 0.6])
def test_identical_blades_are_the_blade_and_whole_turns(count: int, mu: float) -> None:
    """Coning meets regressing at ρ = ½, regressing its conjugate and coning advancing at ρ = 1: named for ever."""
    found = track(blades(count, mu), GAMMAS)
    exact = stability(flapping(Rotor(lock_number=GAMMAS, hinge_offset=0.05, hinge_stiffness=0.1), mu))
    free = np.isnan(exact.lock)
    assert found.certain.all() and free.sum() == {0.0: 24, 0.3: 18, 0.6: 8}[mu]
    names = {"regressing": -1, "coning": 0, "advancing": 1} | ({"differential": 0} if count == 4 else {})
    for name, k in names.items():
        for eta, own in zip(exact.exponents[free, 0] + 1j * k, found[name][free], strict=True):
            assert min(np.abs(own - [eta, np.conj(eta)]).max(), np.abs(own - [np.conj(eta), eta]).max()) < 1e-12
        pair = found[name][free]
        assert np.abs(np.diff(pair.imag, axis=0)).max() < 1.0  # each member goes on, also through zero
    whole = stability(multiblade(Rotor(lock_number=GAMMAS, hinge_offset=0.05, hinge_stiffness=0.1, blades=count), mu))
    for a, b in zip(found.exponents, whole.exponents, strict=True):
        assert distances(a, b, count if count % 2 else count / 2).max() < 1e-12  # β_d changes its sign a passage


def test_random_rotors_are_their_blade_and_whole_turns() -> None:
    """Any start and end, most of the ways through locks: 12 ways of 3 to 6 blades in six values."""
    rng, p = np.random.default_rng(7), np.linspace(0.0, 1.0, 6)
    low, high = np.array([3.0, 0.0, 0.0, -0.2, 0.0]), np.array([14.0, 0.15, 0.5, 0.4, 0.8])
    parameters = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling")
    for count in (3, 4, 5, 6) * 3:
        ends = rng.uniform(low, high, (2, 5))

        def at(x: Any, ends: NDArray[np.float64] = ends) -> tuple[dict[str, Any], Any]:
            *values, mu = np.multiply.outer(1.0 - x, ends[0]).T + np.multiply.outer(x, ends[1]).T
            return dict(zip(parameters, values, strict=True)), mu

        def family(x: float, count: int = count, at: Callable[..., Any] = at) -> PeriodicSystem:
            values, mu = at(np.float64(x))
            return multiblade(Rotor(blades=count, **values), mu)

        found, (values, mu) = track(family, p), at(p)
        exact = stability(flapping(Rotor(**values), mu))
        free = np.isnan(exact.lock)
        assert found.certain.all()
        for name, k in (("regressing", -1), ("coning", 0), ("advancing", 1)) if free.any() else ():
            for eta, own in zip(exact.exponents[free, 0] + 1j * k, found[name][free], strict=True):
                assert distances(own, [eta, np.conj(eta)]).max() < 1e-11


def test_characters_name_as_the_rotation_number_does() -> None:
    """Without knowing that its blades are identical."""
    for count in (3, 4, 5):
        known = track(blades(count, 0.3), GAMMAS)
        unknown = track(lambda g, n=count: replace(blades(n, 0.3)(g), blade=None), GAMMAS)
        assert known.names == unknown.names
        np.testing.assert_allclose(known.exponents, unknown.exponents, atol=1e-11)


def test_modes_cross_in_hover_and_lock_beyond() -> None:
    """Without periodic coefficients ρ = 1 is a crossing of three pairs; at μ = 0.3 it is a lock of three pairs."""
    crossed, locked = track(blades(3, 0.0), GAMMAS), track(blades(3, 0.3), GAMMAS)
    assert kinds(crossed) == [Meeting.CROSSING] * 3
    assert kinds(locked) == [Meeting.LOCK] * 3 + [Meeting.UNLOCK] * 3 + [Meeting.LOCK] * 3
    member = crossed["regressing"][:, 0].imag
    assert member[0] * member[-1] < 0 and len(set(np.sign(np.diff(member)))) == 1  # through zero, not back
    meets = [{crossed.names[i] for i in event.modes} for event in crossed.events]
    assert sorted(map(len, meets)) == [1, 2, 2]


def test_first_of_two_locked_modes_grows_more() -> None:
    found = track(blades(3, 0.6), GAMMAS)
    inside = found["regressing"][4:9]
    assert np.all(inside[:, 0].real > inside[:, 1].real) and np.abs(inside.imag).max() < 1e-12


def test_dissimilar_blades_keep_to_themselves() -> None:
    """They do not couple: each pair is one blade, through the locks of the others, whose exponents it passes."""
    rotors, mu = [Rotor(lock_number=8.0 + 0.5 * i, hinge_stiffness=0.2) for i in range(3)], np.linspace(0.0, 0.5, 11)
    found = track(lambda m: multiblade(rotors, m), mu)
    assert found.certain.all() and set(kinds(found)) == {Meeting.LOCK}
    starts = [stability(flapping(r, 0.0)).exponents for r in rotors]
    for rotor, start in zip(rotors, starts, strict=True):
        mine = np.flatnonzero(np.abs(found.exponents[0].real - start[0].real) < 1e-9)
        assert len(mine) == 2
        exact = stability(flapping(rotor, mu)).exponents
        for a, b in zip(found.exponents[:, mine], exact, strict=True):
            assert distances(a, b, 1.0).max() < 1e-12


# ---------------------------------------------------------------------- constant systems
def test_tip_path_plane_is_named_as_in_hover() -> None:
    for gamma in (4.0, 8.0, 12.0):
        rotor = Rotor(lock_number=gamma, hinge_offset=0.05)
        found, hover = track(lambda m, r=rotor: tip_path_plane(r, m), [0.0, 0.4, 1.0]), hover_modes(rotor)
        for name in ("regressing", "coning", "advancing"):
            assert distances(found[name][0], getattr(hover, name).exponents).max() < 1e-12
        for k, m in enumerate((0.0, 0.4, 1.0)):
            exact = stability(tip_path_plane(rotor, m)).exponents
            assert distances(found.exponents[k], exact).max() < 1e-12


def test_tip_path_plane_splits() -> None:
    """The regressing pair turns real at 0.461 (γ = 8, ε = 0.05): its name goes with both reals."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05)
    found = track(lambda m: tip_path_plane(rotor, m), np.linspace(0.0, 1.2, 13))
    (event,) = found.events
    assert event.kind == Meeting.LOCK and found.names[event.modes[0]] == found.names[event.modes[1]] == "regressing"
    assert event.low < 0.4609 < event.high + 1e-4
    assert np.all(found["regressing"][5:].imag == 0) and np.all(found["regressing"][:4].imag != 0)


@pytest.mark.parametrize("coupling", [0.3, 1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("count", [2, 7])
def test_veering_modes_stay_on_their_side(coupling: float, count: int) -> None:
    """Gaps down to 8e-7 per rev between values ½ apart: the slower stays the slower."""
    p = np.linspace(0.0, 1.0, count)
    found, expected = track(oscillators(coupling), p), oscillator_exponents(p, coupling)
    np.testing.assert_allclose(found.exponents[:, [0, 2]], expected, atol=1e-12)
    assert found.certain.all()
    if coupling < 0.1:
        assert kinds(found) == [Meeting.VEERING] * 2 and {e.modes for e in found.events} == {(0, 2), (1, 3)}
        assert all(event.low < 0.5 < event.high for event in found.events)


@pytest.mark.parametrize("coupling", [0.0, 0.1 * TOUCH])
@pytest.mark.parametrize("count", [2, 5, 7])
def test_crossing_modes_pass(coupling: float, count: int) -> None:
    """Also when the place where they meet is asked for, and when the gap is not seen."""
    p = np.linspace(0.0, 1.0, count)
    found = track(oscillators(coupling), p)
    expected = -0.025 + 1j * np.sqrt(np.stack([1.0 + p, 2.0 - p], axis=-1) - 0.025**2)
    np.testing.assert_allclose(found.exponents[:, [0, 2]], expected, atol=1e-7)
    assert found.certain.all() and kinds(found) == [Meeting.CROSSING] * 2


def test_critical_damping_is_a_value_like_others() -> None:
    def family(p: float) -> PeriodicSystem:
        one = PeriodicMatrix.constant([[1.0]])
        return PeriodicSystem(period=math.nan, damping=2.0 * p * one, stiffness=one)

    found = track(family, [0.0, 0.5, 1.0, 1.5, 2.0])
    roots = np.sqrt(np.array([0.25, 4.0]) - np.array([1.0, 1.0]) + 0j)
    np.testing.assert_allclose(found.exponents[1], [-0.5 + roots[0], -0.5 - roots[0]], atol=1e-12)
    np.testing.assert_allclose(found.exponents[2], [-1.0, -1.0], atol=1e-7)
    np.testing.assert_allclose(found.exponents[4].real, [math.sqrt(3.0) - 2.0, -math.sqrt(3.0) - 2.0], atol=1e-12)
    assert found.certain.all() and kinds(found) == [Meeting.LOCK]


# ---------------------------------------------------------------------- order and grid
FAMILIES: dict[str, tuple[Family, float, float]] = {
    "blade": (lambda m: flapping(Rotor(lock_number=12.0), m), 0.0, 1.5),
    "blades": (blades(4, 0.3), 4.0, 15.5),
    "hover": (blades(5, 0.0), 4.0, 15.5),
    "plane": (lambda m: tip_path_plane(Rotor(lock_number=12.0), m), 0.0, 1.2),
    "averaged": (lambda m: averaged(Rotor(lock_number=6.0, hinge_offset=0.05), m, 2), 0.0, 1.2),
    "veering": (oscillators(1e-3), 0.0, 1.0),
    "crossing": (oscillators(0.0), 0.0, 1.0),
}  # fmt: skip


@pytest.mark.parametrize("name", FAMILIES)
def test_neither_direction_nor_grid_matter(name: str) -> None:
    family, low, high = FAMILIES[name]
    values = np.linspace(low, high, 12)
    there = track(family, values)
    back, fine = track(family, values[::-1]), track(family, np.linspace(low, high, 56))
    ends = track(family, [low, high])
    assert there.names == back.names == fine.names == ends.names
    np.testing.assert_array_equal(back.exponents[::-1], there.exponents)
    np.testing.assert_allclose(fine.exponents[::5], there.exponents, atol=1e-10)
    np.testing.assert_allclose(ends.exponents, there.exponents[[0, -1]], atol=1e-10)
    assert there.certain.all() and kinds(there) == kinds(back) == kinds(fine) == kinds(ends)


# ---------------------------------------------------------------------- what is not certain, and errors
def test_a_jump_is_not_certain() -> None:
    """A family that is not continuous: beyond the jump, from where they are named, nobody knows which mode is which."""
    found = track(lambda p: oscillators(0.1)(p if p < 0.5 else p + 1.3), np.linspace(0.0, 1.0, 5))
    first, last = found.certain[:2], found.certain[2:]
    assert (first.all() and not last.any()) or (last.all() and not first.any())


def test_modes_that_never_part_are_not_certain() -> None:
    found = track(
        lambda p: PeriodicSystem(period=math.nan, stiffness=PeriodicMatrix.constant((1.0 + p) * np.eye(2))), [0, 1]
    )
    assert not found.certain[-1].any()
    assert distances(found.exponents[-1], 1j * math.sqrt(2.0) * np.array([1, 1, -1, -1])).max() < 1e-12


def test_modes_locked_together_from_the_start_are_numbered() -> None:
    """Coning and regressing at ½ per rev from end to end: their characters are one."""
    found = track(lambda m: multiblade(Rotor(lock_number=12.0, blades=4), m), [0.3, 0.5])
    assert set(found.names) == {"mode 1", "mode 2", "mode 3", "mode 4"} and found.certain.all()
    three = track(lambda m: multiblade(Rotor(lock_number=12.0, blades=3), m), [0.3, 0.5])
    assert sorted(three.names) == ["advancing"] * 2 + ["mode 1"] * 2 + ["mode 2"] * 2


def test_one_value() -> None:
    found = track(blades(3, 0.3), [5.0])
    assert found.names == ("regressing", "regressing", "coning", "coning", "advancing", "advancing")
    assert found.exponents.shape == (1, 6) and found.certain.all() and found.events == ()
    assert np.all(found.exponents[0, ::2].imag > 0)


def test_what_cannot_be_followed_is_refused() -> None:
    family = blades(3, 0.3)
    with pytest.raises(ParameterError, match="one or more finite values"):
        track(family, [math.nan])
    with pytest.raises(ParameterError, match="one or more finite values"):
        track(family, [[1.0]])
    with pytest.raises(ParameterError, match="one system for a value"):
        track(lambda m: flapping(Rotor(lock_number=8.0), np.array([m, m])), [0.1, 0.2])
    with pytest.raises(ParameterError, match="not among the modes"):
        track(family, [5.0])["flutter"]
