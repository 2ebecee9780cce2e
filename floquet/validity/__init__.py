"""Where the simple model stops: locks, splits, onset of growth and limits in μ, by root-finding.

=============  ======================================================================
``curves``     smooth functions of many cases, and every place where they pass a level
``levels``     the functions whose levels are boundaries
``boundaries`` the same along any parameter, and as curves in the plane of two
``designs``    rotors along μ: their locks, onsets and splits
``limits``     where errors of the modes pass tolerances
=============  ======================================================================
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np

from ..comparison import Metric, Model, mode_names
from ..errors import ParameterError, did_you_mean
from ..models import PhysicsKeywords
from ..rotor import Rotor, require_rotor
from .boundaries import BoundaryCurve, boundaries, transitions
from .curves import Crossings, crossings
from .designs import Designs, Windows
from .limits import Limit, Limits, Wanted
from .limits import found as _found

__all__ = [
    "BoundaryCurve",
    "Crossings",
    "Limit",
    "Limits",
    "Windows",
    "all_limits",
    "boundaries",
    "crossings",
    "instability_onset",
    "limits",
    "lock_windows",
    "locks",
    "split_edges",
    "tpp_instability_onset",
    "transitions",
    "validity_intervals",
    "validity_limit",
]


def validity_limit(
    rotor: Rotor,
    tolerance: float = 0.05,
    mode: str = "regressing",
    mu_max: float = 1.0,
    *,
    metric: Metric = Metric.RELATIVE,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Any:
    """The first μ at which the TPP error of ``mode`` passes ``tolerance``; inf = not up to ``mu_max``.

    Arrays of rotor parameters give an array of limits.
    """
    found = all_limits(
        rotor, tolerances=((metric, tolerance),), modes=(mode,), mu_max=mu_max, model=model, **options
    ).limit
    return found.reshape(rotor.shape) if rotor.shape else float(found[0, 0])


def validity_intervals(
    rotor: Rotor,
    tolerance: float = 0.05,
    mode: str = "regressing",
    mu_max: float = 1.0,
    *,
    metric: Metric = Metric.RELATIVE,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Any:
    """Every (μ_in, μ_out) where the TPP error of ``mode`` passes ``tolerance``; μ_out = inf: failing at ``mu_max``.

    Arrays of rotor parameters give a list, one list of intervals a rotor.
    """
    found = all_limits(rotor, tolerances=((metric, tolerance),), modes=(mode,), mu_max=mu_max, model=model, **options)
    ends = np.cumsum(found.counts[:, 0])
    pairs = list(zip(found.starts.tolist(), found.ends.tolist(), strict=True))
    lists = [pairs[end - count : end] for end, count in zip(ends, found.counts[:, 0], strict=True)]
    return lists if rotor.shape else lists[0]


def lock_windows(
    rotor: Rotor, mu_max: float = 1.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """Windows [(enter, leave, per_rev)] in μ where the exact pair is locked at ρ = per_rev, in order.

    enter = 0.0: locked in hover; leave = inf: still locked at ``mu_max``.  Arrays of parameters give a list of such
    lists; :func:`locks` gives all of them in arrays.
    """
    found = locks(rotor, mu_max, model=model, **options)
    lists: list[list[tuple[float, float, float]]] = [[] for _ in range(math.prod(rotor.shape))]
    for case, *window in zip(*(x.tolist() for x in (found.case, found.enter, found.leave, found.per_rev)), strict=True):
        lists[case].append(tuple(window))
    return lists if rotor.shape else lists[0]


def locks(
    rotor: Rotor, mu_max: float = 1.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Windows:
    """Every lock of every case of a rotor, in arrays: 10 000 designs take a second."""
    return Designs(rotor, mu_max, model, options).windows()


def instability_onset(
    rotor: Rotor, mu_max: float = 3.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """The first μ with growth; 0.0 if already in hover, inf if none up to ``mu_max``."""
    found = Designs(rotor, mu_max, model, options).onsets()
    return found.reshape(rotor.shape) if rotor.shape else float(found[0])


def tpp_instability_onset(
    rotor: Rotor, mu_max: float = 3.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """The first μ with growth of the tip-path plane; 0.0 if already in hover, inf if none up to ``mu_max``."""
    found = Designs(rotor, mu_max, model, options).simple_onsets()
    return found.reshape(rotor.shape) if rotor.shape else float(found[0])


def split_edges(
    rotor: Rotor, mu_max: float = 1.0, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Any:
    """Every μ where a pair of TPP eigenvalues splits on the real axis or merges again."""
    designs = Designs(rotor, mu_max, model, options)
    found = designs.splits()
    lists = [found.of(case).tolist() for case in range(designs.count)]
    return lists if rotor.shape else lists[0]


def limits(
    rotor: Rotor,
    *,
    tolerances: Sequence[tuple[Metric, float]] = ((Metric.RELATIVE, 0.05),),
    modes: Sequence[str] | None = None,
    mu_max: float = 1.0,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> tuple[Limit, ...]:
    """Limits of one rotor (no arrays) for every mode and (metric, tolerance), with intervals and causes."""
    if require_rotor(rotor).shape:
        raise ParameterError(
            "rotor",
            rotor.shape,
            f"limits() takes one rotor, not an array of shape {rotor.shape}: use all_limits, or index the rotor",
        )
    return all_limits(rotor, tolerances=tolerances, modes=modes, mu_max=mu_max, model=model, **options).of(0)


def all_limits(
    rotor: Rotor,
    *,
    tolerances: Sequence[tuple[Metric, float]] = ((Metric.RELATIVE, 0.05),),
    modes: Sequence[str] | None = None,
    mu_max: float = 1.0,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Limits:
    """Limits of every case of a rotor in arrays, for every mode and (metric, tolerance)."""
    designs = Designs(rotor, mu_max, model, options)
    if not designs.count:
        raise ParameterError("rotor", rotor, "there is no rotor whose limits could be sought: its parameters are empty")
    return _found(designs, _wanted(rotor, tolerances, modes, model))


def _wanted(
    rotor: Rotor, tolerances: Sequence[tuple[Metric, float]], modes: Sequence[str] | None, model: Model | None
) -> Wanted:
    """Modes × tolerances, checked."""
    for metric, tolerance in tolerances:
        if not (isinstance(tolerance, (int, float, np.number)) and 0 < tolerance < math.inf):
            raise ParameterError(
                "tolerance",
                tolerance,
                f"{tolerance!r} is no tolerance: give a positive number (0.05 is 5 % for a relative metric)",
            )
        if metric not in tuple(Metric):
            known_metrics = ", ".join(f"Metric.{m.name}" for m in Metric)
            raise ParameterError("metric", metric, f"{metric!r} is no metric: give one of {known_metrics}")
    known = mode_names(rotor, model)
    for mode in modes or ():
        if mode not in known:
            raise ParameterError(
                "mode",
                mode,
                f"{mode!r} is not a mode of this rotor{did_you_mean(str(mode), known)}; it has {', '.join(known)}",
            )
    return [(mode, Metric(m), float(t)) for mode in (modes or known) for m, t in tolerances]
