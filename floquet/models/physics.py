"""What the models take into account: options that validate themselves once.

=================  =======  =====================================================================================
option             default  meaning
=================  =======  =====================================================================================
exact_offset       False    blade-element integrals exact in ε; otherwise the report's truncation at ε²
reversed_flow      False    U_T |U_T| in place of U_T² (where the blade is flown over from behind the lift reverses)
tip_loss           1.0      no lift outboard of this radius, as a fraction of R
kinematic_rates    False    (1 + m) in the columns of body angular acceleration, as kinematics gives; the report has 1
=================  =======  =====================================================================================
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError, did_you_mean
from ..rotor import Rotor, require_rotor

__all__ = ["Physics", "PhysicsKeywords", "advance_ratios"]


#: Above this advance ratio multipliers overflow and no rotor has flown.
HIGHEST = 10.0


class PhysicsKeywords(TypedDict, total=False):
    """The options as keywords of every model."""

    exact_offset: bool
    reversed_flow: bool
    tip_loss: float
    kinematic_rates: bool


@dataclass(frozen=True, kw_only=True)
class Physics:
    """Options of the blade model, see the table of this module."""

    exact_offset: bool = False
    reversed_flow: bool = False
    tip_loss: float = 1.0
    kinematic_rates: bool = False

    def __post_init__(self) -> None:
        for name in ("exact_offset", "reversed_flow", "kinematic_rates"):
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise ParameterError(name, getattr(self, name), f"{getattr(self, name)!r} is neither True nor False")
        if not isinstance(self.tip_loss, (int, float, np.number)) or not 0.5 <= self.tip_loss <= 1.0:
            raise ParameterError(
                "tip_loss",
                self.tip_loss,
                f"{self.tip_loss!r} is outside 0.5 … 1: it is the fraction of the radius that lifts (1 = no tip loss)",
            )

    @staticmethod
    def of(options: PhysicsKeywords | dict[str, Any]) -> Physics:
        """Options from keywords; an unknown name is an error with a suggestion."""
        known = [f.name for f in fields(Physics)]
        for name, value in options.items():
            if name not in known:
                raise ParameterError(
                    name, value, f"unknown option{did_you_mean(name, known)}; the options are {', '.join(known)}"
                )
        return Physics(**options)

    def as_dict(self) -> dict[str, Any]:
        """The options by name."""
        return asdict(self)


def advance_ratios(advance_ratio: ArrayLike, rotor: Rotor | None = None) -> NDArray[np.float64]:
    """μ as an array of finite numbers from 0 to :data:`HIGHEST`, which must broadcast with the rotor's parameters."""
    if advance_ratio is None:
        raise ParameterError("advance_ratio", None, "no advance ratio was given: give μ = V cos α/(ΩR), such as 0.3")
    try:
        if np.asarray(advance_ratio).dtype.kind in "US":
            raise TypeError
        mu = np.asarray(advance_ratio, float)
    except (TypeError, ValueError):
        raise ParameterError("advance_ratio", advance_ratio, f"{advance_ratio!r} is not a number") from None
    bad = mu[~((mu >= 0) & (mu <= HIGHEST))]
    if np.isnan(bad).any():
        raise ParameterError(
            "advance_ratio", advance_ratio, "nan is no advance ratio: look for a missing value or a division by zero"
        )
    if bad.size:
        raise ParameterError(
            "advance_ratio",
            advance_ratio,
            f"{bad.flat[0]:g} is not possible: μ = V cos α/(ΩR) lies between 0 and {HIGHEST:g} "
            "(backward flight mirrors forward flight)",
        )
    if rotor is None:
        return mu
    rotor = require_rotor(rotor)
    try:
        np.broadcast_shapes(mu.shape, rotor.shape)
    except ValueError:
        raise ParameterError(
            "advance_ratio",
            advance_ratio,
            f"shapes {mu.shape} of advance_ratio and {rotor.shape} of the rotor do not broadcast: "
            "for every rotor at every μ give the rotor a last axis of length 1",
        ) from None
    return mu
