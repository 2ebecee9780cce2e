"""Constant-coefficient models: the tip-path plane (table 3, eqs. 6 and 7) and averages with more harmonics.

Put β = t(ψ) a into the blade's equation, with t a row of harmonics, and keep the same harmonics of the result, t⁺::

    D̃ = mean of t⁺ (2 t' + d t),    K̃ = mean of t⁺ (t'' + d t' + k t),    F̃ = mean of t⁺ f

With t = (1, -cos ψ, -sin ψ), a = (a₀, a₁, b₁) this is the tip-path plane; with M harmonics it is the averaged
multiblade model of 2M+1 blades, which is the tip-path plane only for M = 1 (N = 3 and 4).
"""

from __future__ import annotations

import math
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ParameterError
from ..periodic import PeriodicMatrix, PeriodicSystem
from ..rotor import Hub, Rotor
from .flapping import blade
from .multiblade import coordinates
from .physics import PhysicsKeywords, advance_ratios
from .teetering import teetering

__all__ = ["averaged", "tip_path_plane"]


def tip_path_plane(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> PeriodicSystem:
    """The tip-path plane a = (a₀, a₁, b₁), table 3; (a₁, b₁), eq. (7), for a teetering hub.

    Arguments as in :func:`floquet.flapping`; a constant system, whose exponents are eigenvalues.
    """
    advance_ratios(advance_ratio, rotor)
    t = PeriodicMatrix.harmonic(1, [[-1.0, 0.0]], [[0.0, -1.0]])
    if rotor.hub == Hub.TEETERING:
        return _projected(teetering(rotor, advance_ratio, **options), t, ("a_1", "b_1"), "tip path plane")
    t = PeriodicMatrix.assemble([[PeriodicMatrix.constant([[1.0]]), t]])
    return _projected(blade(rotor, advance_ratio, **options), t, ("a_0", "a_1", "b_1"), "tip path plane")


def averaged(
    rotor: Rotor, advance_ratio: ArrayLike, harmonics: int = 1, **options: Unpack[PhysicsKeywords]
) -> PeriodicSystem:
    """The averaged multiblade model of 2·harmonics+1 identical blades, in β₀, β₁c, β₁s, …

    Its modes are approximations of the rotor's for any number of blades, better with every harmonic.
    """
    if isinstance(harmonics, bool) or harmonics != int(harmonics) or not 1 <= harmonics <= 16:
        raise ParameterError(
            "harmonics",
            harmonics,
            f"{harmonics!r} is not a whole number from 1 to 16: 1 is the tip-path plane, "
            "each further one adds two modes",
        )
    rows = [
        PeriodicMatrix.constant([[1.0]]),
        *(PeriodicMatrix.harmonic(n, [[1.0, 0.0]], [[0.0, 1.0]]) for n in range(1, int(harmonics) + 1)),
    ]
    t = PeriodicMatrix.assemble([rows])
    return _projected(
        blade(rotor, advance_ratio, **options),
        t,
        coordinates(2 * int(harmonics) + 1),
        f"averaged over {harmonics} harmonics",
    )


def _projected(one: PeriodicSystem, t: PeriodicMatrix, names: tuple[str, ...], name: str) -> PeriodicSystem:
    """Keep the harmonics of ``t`` in the blade's equation."""
    assert one.damping is not None and one.stiffness is not None
    d, k, inputs = one.damping, one.stiffness, one.inputs
    assert inputs is not None
    t_plus = PeriodicMatrix.constant(np.diag(1.0 / (t.transpose() @ t).mean().diagonal())) @ t.transpose()
    D = t_plus @ (2.0 * t.derivative() + d @ t)
    K = t_plus @ (t.derivative().derivative() + d @ t.derivative() + k @ t)
    return PeriodicSystem(
        period=math.nan,
        damping=_mean(D),
        stiffness=_mean(K),
        inputs=lambda: _mean(t_plus @ inputs()),
        input_names=one.input_names,
        coordinates=names,
        name=name,
    )


def _mean(matrix: PeriodicMatrix) -> PeriodicMatrix:
    return PeriodicMatrix.constant(matrix.mean(), matrix.period)
