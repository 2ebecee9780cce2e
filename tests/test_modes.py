"""Modes of coupled blades: names, branches and vectors from the exponents of one blade."""

from __future__ import annotations

import math

import numpy as np
import pytest

from floquet.errors import ParameterError
from floquet.exponents import stability
from floquet.models import flapping, multiblade, tip_path_plane
from floquet.models.textbook import bittanti_colaneri, mathieu
from floquet.modes import modes
from floquet.rotor import Rotor


@pytest.mark.parametrize("N", [3, 4, 5, 6])
@pytest.mark.parametrize(
    "rotor",
    [Rotor(lock_number=8.0), Rotor(lock_number=8.0, hinge_offset=0.15), Rotor(lock_number=4.0, hinge_stiffness=0.3)],
)
def test_names_and_branches_come_from_the_blade(N: int, rotor: Rotor) -> None:
    """ρ below and above 1: regressing |ρ-n|, coning ρ, advancing ρ+n; differential β_d turns with the blade."""
    blade = stability(flapping(rotor, 0.3))
    assert math.isnan(blade.lock)
    rho = blade.rotation_number
    expected = {"coning": rho} | {
        f"{name}{'' if n == 1 else f'-{n}'}": abs(rho + s * n)
        for n in range(1, (N - 1) // 2 + 1)
        for name, s in (("regressing", -1), ("advancing", 1))
    }
    if N % 2 == 0:
        expected["differential"] = rho
    found = modes(multiblade(rotor.replace(blades=N), 0.3))
    assert sorted(found.names) == sorted([*expected, *expected])
    for name, eta in zip(found.names, found.exponents, strict=True):
        assert abs(eta.imag) == pytest.approx(expected[name], abs=1e-11)
        assert eta.real == pytest.approx(blade.exponents[0].real, abs=1e-11)
    assert found.closure.max() < 1e-11


NAMES = {
    3: ("regressing", "coning", "advancing"),
    4: ("regressing", "coning", "advancing", "differential"),
    6: ("regressing", "coning", "advancing", "regressing-2", "advancing-2", "differential"),
    7: ("regressing", "coning", "advancing", "regressing-2", "advancing-2", "regressing-3", "advancing-3"),
}


@pytest.mark.parametrize("N", NAMES)
@pytest.mark.parametrize("stiffness", [0.0, 0.2, 1.6])
def test_names_have_one_order_and_positive_frequencies_come_first(N: int, stiffness: float) -> None:
    """Whatever μ is and in whatever order the exponents are."""
    rotor = Rotor(lock_number=8.0, hinge_stiffness=stiffness, blades=N)
    for mu in (0.02, 0.1, 0.2, 0.3):
        if not math.isnan(stability(flapping(rotor, mu)).lock):
            continue
        system = multiblade(rotor, mu)
        found = modes(system)
        assert found.names == tuple(name for name in NAMES[N] for _ in range(2))
        assert np.all(found.exponents.imag[::2] > 0.0)
        np.testing.assert_allclose(found.exponents[1::2], found.exponents[::2].conj(), atol=1e-12)
        eta = np.asarray(stability(system).exponents)[found.order]
        turns = (found.exponents - eta) / (0.5j * 2.0 * math.pi / system.period)
        np.testing.assert_allclose(turns, np.round(turns.real), atol=1e-12)
        assert sorted(found.order) == list(range(2 * N))


@pytest.mark.parametrize(
    ("rotor", "low", "high", "names"),
    [
        (Rotor(lock_number=7.12, hinge_stiffness=0.193, blades=4), 0.25, 0.9, ["regressing"] * 2 + ["coning"] * 4
         + ["advancing"] * 2),
        (Rotor(lock_number=14.0, blades=3), 0.1, 0.9, ["regressing"] * 4 + ["advancing"] * 2),
        (Rotor(lock_number=8.0, hinge_stiffness=1.6, blades=3), 0.63, 0.8, ["regressing"] * 4 + ["coning"] * 2),
    ],
    ids=["at 1", "at 1/2", "at 3/2"],
)  # fmt: skip
def test_signs_and_names_stay_in_a_lock(rotor: Rotor, low: float, high: float, names: list[str]) -> None:
    """What turns both ways alike has the positive frequency, whatever rounding says; the less damped member first."""
    for mu in np.linspace(low, high, 15):
        blade = stability(flapping(rotor, mu))
        assert not math.isnan(blade.lock)
        found = modes(multiblade(rotor, mu))
        assert list(found.names) == names
        for name in set(names):
            own = found.exponents[[one == name for one in names]]
            assert np.all(np.diff(own.real) < 1e-9)
            if len(own) == 2:
                np.testing.assert_allclose(own.real, blade.exponents.real, atol=1e-9)
                assert own.imag[0] == pytest.approx(own.imag[1], abs=1e-9) and own.imag[0] >= -1e-12
            else:
                assert np.all(own.imag[::2] > 0.0) and np.all(own.imag[1::2] < 0.0)


def test_vectors_solve_the_equation() -> None:
    """p' = A p - η p at the azimuths, by the derivative of its Fourier series."""
    system = multiblade(Rotor(lock_number=8.0, blades=3), 0.3)
    found = modes(system)
    eta = np.asarray(stability(system).exponents)[found.order]
    steps = len(found.azimuths)
    slope = np.fft.ifft(np.fft.fft(found.vectors, axis=1) * (1j * found.frequencies)[None, :, None], axis=1)
    residual = (
        slope
        + eta[:, None, None] * found.vectors
        - np.einsum("kij,mkj->mki", system.sample(found.azimuths), found.vectors)
    )
    assert steps == 64 and np.abs(residual).max() < 1e-9
    np.testing.assert_allclose(found.participation.sum(axis=(1, 2)), 1.0, rtol=1e-12)


def test_a_single_equation_has_its_rotation_number() -> None:
    """The branch of the dominant harmonic is the one of the turns, outside locks."""
    found = modes(mathieu(2.5, 0.5))
    rho = stability(mathieu(2.5, 0.5)).rotation_number
    np.testing.assert_allclose(np.sort(np.abs(found.exponents.imag)) % 2.0, np.sort([rho % 2.0, rho % 2.0]), atol=1e-12)


def test_other_systems_are_numbered() -> None:
    assert modes(bittanti_colaneri()).names == ("mode 1", "mode 1") or set(modes(bittanti_colaneri()).names) <= {
        "mode 1",
        "mode 2",
    }


def test_cases_and_constant_systems_are_refused() -> None:
    for system in (flapping(Rotor(lock_number=8.0), np.array([0.1, 0.2])), tip_path_plane(Rotor(lock_number=8.0), 0.1)):
        with pytest.raises(ParameterError, match="one periodic system"):
            modes(system)
