"""What is level at a boundary: smooth functions of a period map, and what lies beyond the level in more digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..period_map import PeriodMap

__all__ = ["BOUNDARIES", "Boundary", "Level"]

Array = NDArray[np.float64]
Boundary = Literal["lock", "growth"]


class Level(NamedTuple):
    """A boundary lies where ``value`` is 1 or -1; ``beyond`` is value less that, from the discriminant D."""

    value: Callable[[PeriodMap], Array]
    beyond: Callable[[PeriodMap, float], Array]


def _half_trace(phi: PeriodMap) -> Array:
    return phi.half_trace


def _beyond_one(phi: PeriodMap, level: float) -> Array:
    return np.asarray(phi.discriminant / (phi.half_trace + level))


def _growth(phi: PeriodMap) -> Array:
    """τ over its value at the onset of growth."""
    return np.asarray(phi.half_trace / np.cosh(phi.mean * phi.period))


def _beyond_onset(phi: PeriodMap, level: float) -> Array:
    neutral = np.cosh(phi.mean * phi.period)
    excess = phi.discriminant - np.sinh(phi.mean * phi.period) ** 2
    return np.asarray(excess / (phi.half_trace + level * neutral) / neutral)


#: |τ| = 1 and |τ| = cosh αT, with the half trace τ of the Hill form over the period T and the mean damping -2α.
BOUNDARIES: dict[Boundary, Level] = {"lock": Level(_half_trace, _beyond_one), "growth": Level(_growth, _beyond_onset)}
