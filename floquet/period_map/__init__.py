"""The map of the motion over one period, as factors with an error each.

One blade (a second-order scalar equation) is mapped in Hill form: with β = exp(-½∫d) y::

    y'' + q y = 0,     q = k - d'/2 - d²/4,     det Φ = 1,    exponents = α ± ν,  α = -mean(d)/2

so that both exponents keep all their digits; where d jumps by Δ, y' jumps by ½Δ y.  Anything else is mapped as it is,
and the factors are kept apart because their product would lose the small multipliers.

Panels follow from the case alone (its stiffness and damping, then the error measured on it), never from its neighbours.
The error of a panel is the difference between p = 16 and p = 12 nodes, which is the error of the worse of the two,
plus an allowance for rounding.
"""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..periodic import PeriodicSystem
from .factors import factor_map
from .form import hill_form
from .hill import hill_map
from .panels import EPS, LADDER, ROUNDING
from .result import Method, PeriodMap

__all__ = ["EPS", "ROUNDING", "Method", "PeriodMap", "hill_form", "hill_map", "period_map"]


def period_map(system: PeriodicSystem, *, panels: int | None = None) -> PeriodMap:
    """Map ``system`` over its period.

    Parameters
    ----------
    system : PeriodicSystem
        Not constant.
    panels : int, optional
        Fix the number of panels a period (for convergence studies); the error says what came of it.
    """
    if panels is not None and not (isinstance(panels, (int, np.integer)) and 1 <= panels <= LADDER[-1]):
        raise ParameterError(
            "panels", panels, f"{panels!r} is no number of panels: give 1 to {LADDER[-1]}, or leave it out"
        )
    if system.constant:
        raise ParameterError(
            "system",
            system.name,
            "a constant system has no period to be mapped over: use stability(), which takes its eigenvalues",
        )
    if system.second_order and system.degrees == 1:
        return hill_map(system, panels)
    return factor_map(system, panels)
