"""The inputs of a rotor by name: controls, inflow, body rates and accelerations.

===================  ===================  =====================================  =====
name                 symbol               meaning                                units
===================  ===================  =====================================  =====
theta_0              θ₀                   collective pitch                       rad
A_1c                 A₁c                  lateral cyclic pitch                   rad
B_1c                 B₁c                  longitudinal cyclic pitch              rad
theta_t              θ_t                  twist, tip against axis                rad
lambda               λ                    inflow ratio (V sin α − v_i)/(ΩR)      1
p_w, q_w             p_w/Ω, q_w/Ω         roll and pitch rate                    rad/rad
pdot_w, qdot_w       ṗ_w/Ω², q̇_w/Ω²       roll and pitch acceleration            rad/rad²
normal_acceleration  ((ẇ−uq+pv)−g)/(Ω²R)  of the hub, downward, less gravity     1
precone              a₀                   built-in coning of a teetering rotor   rad
===================  ===================  =====================================  =====

All in the wind-hub system: x upwind, y to the right, z down, so that p rolls to the right and q pitches the nose up.
λ is positive upward through the disc; a hovering rotor's is negative.  Rates are in units of Ω: per radian of azimuth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError, did_you_mean

__all__ = ["FORCING", "PRECONE", "input_vector"]

#: The columns of F.
FORCING = ("theta_0", "A_1c", "B_1c", "theta_t", "lambda", "p_w", "q_w", "pdot_w", "qdot_w", "normal_acceleration")
#: A further column of the teetering rotor.
PRECONE = "precone"


def input_vector(inputs: Mapping[str, ArrayLike], names: Sequence[str]) -> NDArray[np.float64]:
    """u (..., inputs) in the order of ``names``; what is not given is zero, arrays broadcast."""
    if not isinstance(inputs, Mapping):
        raise ParameterError("inputs", inputs, f"{inputs!r} names no inputs: write {{'B_1c': 1.0}}, for example")
    columns = {}
    for name, value in inputs.items():
        if name not in names:
            known = ", ".join(names) or "none"
            raise ParameterError(
                name, value, f"it is no input of this model{did_you_mean(str(name), names)}; it has {known}"
            )
        try:
            columns[name] = np.asarray(value, float)
        except (TypeError, ValueError):
            raise ParameterError(name, value, f"{value!r} is not a number") from None
        if not np.all(np.isfinite(columns[name])):
            raise ParameterError(name, value, f"{value!r} is not finite, and no response could be")
    try:
        shape = np.broadcast_shapes(*(column.shape for column in columns.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {column.shape}" for name, column in columns.items())
        raise ParameterError("inputs", shapes, f"the shapes do not broadcast: {shapes}") from None
    out = np.zeros((*shape, len(names)))
    for name, column in columns.items():
        out[..., list(names).index(name)] = column
    return out
