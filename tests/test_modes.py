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


def test_vectors_solve_the_equation() -> None:
    """p' = A p - η p at the azimuths, by the derivative of its Fourier series."""
    system = multiblade(Rotor(lock_number=8.0, blades=3), 0.3)
    found, eta = modes(system), np.asarray(stability(system).exponents)
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
