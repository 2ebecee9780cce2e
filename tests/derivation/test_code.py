"""The package's numbers against the symbolic derivation: flapping, teetering, multiblade and the tip-path plane."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from floquet.models import FORCING, flapping, multiblade, teetering, tip_path_plane
from floquet.periodic import PeriodicSystem
from floquet.rotor import Hub, Rotor
from tests.derivation import blade, rotor
from tests.derivation.blade import PARAMETERS, psi

ROUNDING = 1e-14  # of the largest entry: sums of at most some forty products
PSI = np.random.default_rng(1431).uniform(0.0, 2.0 * np.pi, 7)
OPTIONS = [{"exact_offset": e, "kinematic_rates": k} for e in (False, True) for k in (False, True)]
Numbers = dict[str, float]


def random_rotors(count: int) -> list[Numbers]:
    """γ, ε, κ, K₁, μ, m and s, each by itself: m is not ε s."""
    low, high = (4.0, 0.02, 0.0, -0.4, 0.1, 0.05, 1.2), (14.0, 0.25, 0.3, 0.4, 1.2, 0.4, 2.0)
    names = [parameter.name for parameter in PARAMETERS]
    values = np.random.default_rng(79).uniform(low, high, (count, len(names)))
    return [dict(zip(names, map(float, row), strict=True)) for row in values]


ROTORS = random_rotors(3)


def described(numbers: Numbers, **changes: Any) -> Rotor:
    return Rotor(
        lock_number=numbers["gamma"],
        hinge_offset=numbers["epsilon"],
        hinge_stiffness=numbers["kappa"],
        pitch_flap_coupling=numbers["K_1"],
        offset_mass_ratio=numbers["m"],
        static_moment_ratio=numbers["s"],
        **changes,
    )


def evaluated(matrix: sp.Matrix, numbers: Numbers) -> Callable[[float], NDArray[np.float64]]:
    """A matrix of ψ and the parameters as a function of ψ."""
    real = matrix.applyfunc(lambda entry: sp.expand(entry.rewrite(sp.cos)))
    function = sp.lambdify([psi, *PARAMETERS], real, modules="numpy")
    return lambda azimuth: np.asarray(function(azimuth, *numbers.values()), float)


def in_parameters(system: rotor.System, *, exact: bool, kinematic: bool) -> rotor.System:
    """A system by harmonics in the parameters of the blade, a column of F for each input."""
    coefficients = rotor.blade_coefficients(exact=exact)
    forcing = rotor.blade_forcing(exact=exact, kinematic=kinematic)
    columns = [system.F.subs({f: row[j] for f, row in forcing.items()}) for j in range(len(blade.INPUTS))]
    return rotor.System(system.D.subs(coefficients), system.K.subs(coefficients), sp.Matrix.hstack(*columns))


def assert_agrees(system: PeriodicSystem, derived: rotor.System, numbers: Numbers) -> None:
    """D, K and each column of F at every azimuth."""
    assert system.damping is not None and system.stiffness is not None and system.forcing is not None
    for part, matrix in zip((system.damping, system.stiffness, system.forcing), derived, strict=True):
        found, function = part.sample(PSI), evaluated(matrix, numbers)
        expected = np.stack([function(azimuth) for azimuth in PSI])
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING * np.abs(expected).max())


def test_columns_of_the_forcing_have_one_order() -> None:
    """By name; the normal acceleration is n in the derivation."""
    assert [v.name for v in blade.INPUTS[:-1]] == list(FORCING[:-1])
    assert (blade.INPUTS[-1].name, FORCING[-1]) == ("n", "normal_acceleration")


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("numbers", ROTORS, ids=range(len(ROTORS)))
def test_flapping_agrees(numbers: Numbers, options: dict[str, bool]) -> None:
    exact, kinematic = options.values()
    derived = rotor.System(
        sp.Matrix([blade.damping(exact=exact)]),
        sp.Matrix([blade.stiffness(exact=exact)]),
        blade.forcing(exact=exact, kinematic=kinematic),
    )
    assert_agrees(flapping(described(numbers), numbers["mu"], **options), derived, numbers)


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("blades", [3, 4])
@pytest.mark.parametrize("numbers", ROTORS, ids=range(len(ROTORS)))
def test_multiblade_agrees(numbers: Numbers, blades: int, options: dict[str, bool]) -> None:
    exact, kinematic = options.values()
    derived = in_parameters(rotor.multiblade(blades), exact=exact, kinematic=kinematic)
    assert_agrees(multiblade(described(numbers, blades=blades), numbers["mu"], **options), derived, numbers)


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("numbers", ROTORS, ids=range(len(ROTORS)))
def test_tip_path_plane_agrees(numbers: Numbers, options: dict[str, bool]) -> None:
    exact, kinematic = options.values()
    derived = in_parameters(rotor.tip_path_plane(), exact=exact, kinematic=kinematic)
    assert_agrees(tip_path_plane(described(numbers), numbers["mu"], **options), derived, numbers)


@pytest.mark.parametrize("options", OPTIONS, ids=str)
@pytest.mark.parametrize("numbers", ROTORS, ids=range(len(ROTORS)))
def test_teetering_rotor_and_its_plane_agree(numbers: Numbers, options: dict[str, bool]) -> None:
    """With the column of the precone; without hinge offset no option makes a difference."""
    numbers = numbers | {"epsilon": 0.0, "m": 0.0}
    hub = described(numbers, blades=2, hub=Hub.TEETERING)
    d, k, f, precone = rotor.teetering()
    derived = rotor.System(sp.Matrix([d]), sp.Matrix([k]), f.row_join(sp.Matrix([precone])))
    assert_agrees(teetering(hub, numbers["mu"], **options), derived, numbers)
    assert_agrees(tip_path_plane(hub, numbers["mu"], **options), rotor.teetering_plane(), numbers)
