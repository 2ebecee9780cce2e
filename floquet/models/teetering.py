"""The two-bladed teetering rotor, eq. (2) of NASA TP-1431.

The blades are one beam, β₂(ψ) = -β₁(ψ), ψ₂ = ψ + π, hinged on the axis (ε = 0, m = 0).  Half the difference of the two
blades' eq. (1) is::

    β'' + (γ/8) β' + [P² + (γμ²/8) sin 2ψ + (γK₁μ²/8)(1 - cos 2ψ)] β = f(ψ) u,      period π

so the even harmonics of the coefficients remain, and the odd ones of the forcing.  Without reversed flow it is a damped
Mathieu equation.

Built-in coning a₀ (both blades up) adds what the odd harmonics of one blade's stiffness do to it; the report leaves
that out of (2) and (7)::

    f = −a₀ [(γμ/6) cos ψ + (γK₁μ/3) sin ψ]

where K₁ acts on the total flap angle, coning included; it is the eleventh input.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from ..periodic import Equation, PeriodicMatrix, PeriodicSystem
from ..rotor import Rotor, require_rotor
from .flapping import blade
from .inputs import PRECONE
from .physics import PhysicsKeywords

__all__ = ["teetering"]


def teetering(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> PeriodicSystem:
    """Teetering of a two-bladed rotor, eq. (2): one coordinate β, period π, exponents modulo 2i per rev.

    Its inputs are the blade's and ``precone``.  ``rotor`` must have no hinge offset (ε = m = 0); see
    :func:`floquet.flapping` for the other arguments.
    """
    if np.any(np.asarray(require_rotor(rotor).hinge_offset) != 0) or np.any(np.asarray(rotor.offset_mass_ratio) != 0):
        e, m = (float(np.max(np.asarray(x))) for x in (rotor.hinge_offset, rotor.offset_mass_ratio))
        raise ParameterError(
            "hinge_offset",
            e,
            f"a teetering rotor hinges on its axis, but hinge_offset = {e:g} and offset_mass_ratio = {m:g}: "
            "give both as 0, or use the flapping model",
        )
    one = blade(rotor, advance_ratio, **options)
    assert one.equation is not None and one.inputs is not None
    inputs, blade_equation = one.inputs, one.equation

    def build(values: Mapping[str, NDArray[Any]]) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        d, k = blade_equation.build(values)
        return _even(d), _even(k)

    def forcing() -> PeriodicMatrix:
        return PeriodicMatrix.assemble([[_odd(inputs()), -1.0 * _odd(blade_equation.whole()[1])]])

    return PeriodicSystem(
        period=math.pi,
        equation=Equation(build=build, parameters=blade_equation.parameters, key=("teetering", blade_equation.key)),
        inputs=forcing,
        input_names=(*one.input_names, PRECONE),
        coordinates=("beta",),
        name="teetering",
    )


def _odd(matrix: PeriodicMatrix) -> PeriodicMatrix:
    return (matrix - matrix.shifted(math.pi)) / 2


def _even(matrix: PeriodicMatrix) -> PeriodicMatrix:
    return (matrix + matrix.shifted(math.pi)) / 2
