"""Rotors along the advance ratio: maps, comparisons, and every boundary between 0 and an end, for many at once.

With the half trace τ of the blade's Hill form over the period T with mean damping -2α::

    lock              |τ| > 1
    growth            |τ| > cosh αT
    split of the TPP  the discriminant of its characteristic polynomial changes sign

are levels of smooth functions of μ (analytic, but where reversed flow reaches root or tip), see
:mod:`floquet.validity.curves` for how every passage is found.  Where a curve only touches its level the discriminant
D = τ² - 1 in forty digits decides, and windows down to :data:`WIDTH` are told from none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..comparison import Comparison, Model, compare, eigenvalues, exact_model, simple_model
from ..environment import check_environment
from ..errors import ParameterError
from ..exponents import BEYOND, exponents
from ..models import PhysicsKeywords, teetering
from ..models.flapping import blade
from ..models.physics import HIGHEST
from ..period_map import PeriodMap, hill_map
from ..rotor import PARAMETERS, Rotor
from .curves import Crossings, Curve, crossings
from .levels import BOUNDARIES, Boundary

__all__ = ["WIDTH", "Designs", "Windows"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Places = NDArray[np.intp]
WIDTH = 1e-9  # windows narrower than this are not reported
ROUNDING_OF_EIGENVALUES = 1e-11  # and of the products of their differences, relative to the largest


@dataclass(frozen=True, eq=False, kw_only=True)
class Windows:
    """Locks of many rotors: ``case`` (w,), ``enter`` and ``leave`` (w,) in μ, ``per_rev`` (w,), in order.

    enter = 0.0: locked in hover; leave = inf: still locked at the end.
    """

    case: Places
    enter: Array
    leave: Array
    per_rev: Array

    def of(self, case: int) -> list[tuple[float, float, float]]:
        """(enter, leave, per_rev) of one rotor."""
        i = self.case == case
        return list(zip(*(x[i].tolist() for x in (self.enter, self.leave, self.per_rev)), strict=True))


class Designs:
    """The cases of a rotor, along one axis, from μ = 0 to ``mu_max``."""

    def __init__(self, rotor: Rotor, mu_max: float, model: Model | None, options: PhysicsKeywords) -> None:
        if not (isinstance(mu_max, (int, float, np.number)) and 0 < mu_max <= HIGHEST):
            raise ParameterError(
                "mu_max",
                mu_max,
                f"{mu_max!r} is no end of the search: give an advance ratio above 0, {HIGHEST:g} at most",
            )
        check_environment()
        self.rotor, self.mu_max, self.options = rotor, float(mu_max), options
        self.model: Model = exact_model(rotor, model)
        self.count = math.prod(rotor.shape)

    def at(self, case: Places) -> Rotor:
        """The rotors of some cases; parameters that all have in common stay single numbers."""
        shape = self.rotor.shape
        return self.rotor.mapped(lambda v: v if np.ndim(v) == 0 else np.broadcast_to(v, shape).ravel()[case])

    def part(self, start: int, stop: int) -> Designs:
        """Some of them."""
        return Designs(self.at(np.arange(start, min(stop, self.count))), self.mu_max, self.model, self.options)

    # ------------------------------------------------------------------ functions of case and μ
    def map(self, case: Places, mu: Array, *, precise: bool = True) -> PeriodMap:
        """Of the exact rotors."""
        one = (teetering if self.model == "teetering" else blade)(self.at(case), mu, **self.options)
        return hill_map(one, precise=precise)

    def comparison(self, case: Places, mu: Array) -> Comparison:
        """Of exact and simple rotors."""
        return compare(self.at(case), mu, model=self.model, **self.options)

    def locks(self, case: Places, mu: Array) -> Array:
        """ρ of the lock, nan outside."""
        return np.atleast_1d(exponents(self.map(case, mu)).lock)

    def _value(self, kind: Boundary) -> Curve:
        """What is level at such boundaries, in doubles."""
        return lambda case, mu: BOUNDARIES[kind].value(self.map(case, mu, precise=False))

    def _beyond(self, kind: Boundary) -> Callable[[float], Curve]:
        """What lies beyond the level, with more digits."""
        return lambda level: lambda case, mu: BOUNDARIES[kind].beyond(self.map(case, mu), level)

    def _simple(self, case: Places, mu: Array) -> Complex:
        """Eigenvalues of the simple model."""
        return eigenvalues(simple_model(self.at(case), mu, model=self.model, **self.options))

    def _margin(self, case: Places, mu: Array) -> Array:
        """Π (s_i + s_j) with i ≤ j: smooth in μ, zero where an eigenvalue or a pair is on the imaginary axis."""
        roots = self._simple(case, mu)
        i, j = np.triu_indices(roots.shape[-1])
        return np.asarray(np.prod(roots[..., i] + roots[..., j], axis=-1)).real

    def _splitting(self, case: Places, mu: Array) -> Array:
        """Π (s_i - s_j)² of the simple model's eigenvalues: real, negative for an odd number of complex pairs."""
        roots = self._simple(case, mu)
        i, j = np.triu_indices(roots.shape[-1], 1)
        return np.asarray(np.prod(roots[..., i] - roots[..., j], axis=-1) ** 2).real

    # ------------------------------------------------------------------ boundaries
    def ranges(self) -> tuple[Places, Array, Array]:
        """Where the functions of μ are smooth: case, start and stop.  Reversed flow has kinks at root and tip."""
        everyone = np.arange(self.count)
        ends = [np.zeros(self.count), np.full(self.count, self.mu_max)]
        if self.options.get("reversed_flow", False):
            rotor = self.at(everyone)
            root = np.broadcast_to(np.maximum(rotor.hinge_offset, rotor.root_cutout), self.count)
            tip = np.full(self.count, float(self.options.get("tip_loss", 1.0)))
            ends[1:1] = [np.minimum(root, self.mu_max), np.minimum(tip, self.mu_max)]
        case = np.tile(everyone, len(ends) - 1)
        start, stop = np.concatenate(ends[:-1]), np.concatenate(ends[1:])
        there = stop > start
        return case[there], start[there], stop[there]

    def _passages(
        self, curve: Curve, levels: tuple[float, ...], exact: Callable[[float], Curve], **given: float
    ) -> Crossings:
        with np.errstate(**BEYOND):
            end = curve(np.arange(self.count), np.full(self.count, self.mu_max))
        if not np.all(np.isfinite(end)):
            raise self.overflow(int(np.flatnonzero(~np.isfinite(end))[0]))
        case, start, stop = self.ranges()
        return crossings(curve, start, stop, levels, case=case, exact=exact, least=WIDTH, **given)

    def overflow(self, case: int) -> ParameterError:
        """What is wrong with a rotor whose period map no double holds: its largest parameter."""
        rotor = self.at(np.array([case]))
        values = {p.name: float(np.asarray(getattr(rotor, p.name)).ravel()[0]) for p in PARAMETERS}
        name = max(values, key=lambda p: abs(values[p]))
        return ParameterError(
            name,
            values[name],
            f"{values[name]:g} is beyond what doubles hold up to μ = {self.mu_max:g}: the period map overflows",
        )

    def _between(self, found: Crossings) -> tuple[Places, Array, Array]:
        """Case, start and stop of the ranges from one passage to the next, wider than :data:`WIDTH`."""
        everyone = np.arange(self.count)
        case = np.concatenate([everyone, found.case, everyone])
        edge = np.concatenate([np.zeros(self.count), found.x, np.full(self.count, self.mu_max)])
        order = np.lexsort((edge, case))
        case, edge = case[order], edge[order]
        inner = (case[:-1] == case[1:]) & (edge[1:] - edge[:-1] > WIDTH)
        return case[:-1][inner], edge[:-1][inner], edge[1:][inner]

    def windows(self) -> Windows:
        """Every lock."""
        found = self._passages(self._value("lock"), (1.0, -1.0), self._beyond("lock"))
        case, enter, leave = self._between(found)
        rho = self.locks(case, 0.5 * (enter + leave))
        locked = ~np.isnan(rho)
        case, enter, leave, rho = case[locked], enter[locked], leave[locked], rho[locked]
        joined = (case[1:] == case[:-1]) & (enter[1:] == leave[:-1]) & (rho[1:] == rho[:-1])  # no edge after all
        first, last = np.append(True, ~joined)[: len(case)], np.append(~joined, True)[: len(case)]
        leave = leave[last]
        leave = np.where(leave == self.mu_max, math.inf, leave)
        return Windows(case=case[first], enter=enter[first], leave=leave, per_rev=rho[first])

    def onsets(self) -> Array:
        """The first μ with growth (n,): 0.0 if already in hover, inf if there is none."""
        everyone = np.arange(self.count)
        out = np.full(self.count, math.inf)
        found = self._passages(self._value("growth"), (1.0, -1.0), self._beyond("growth"))
        case, first = np.unique(found.case, return_index=True)
        out[case] = found.x[first]
        phi = self.map(everyone, np.zeros(self.count))
        out[phi.discriminant > np.sinh(phi.mean * phi.period) ** 2] = 0.0
        return out

    def simple_onsets(self) -> Array:
        """The first μ with growth of the simple model (n,): 0.0 if already in hover, inf if there is none."""
        found = self._passages(self._margin, (0.0,), lambda _: self._margin, rounding=ROUNDING_OF_EIGENVALUES)
        case, start, stop = self._between(found)
        grows = self._simple(case, 0.5 * (start + stop)).real.max(axis=-1) > 0.0
        out = np.full(self.count, math.inf)
        first, place = np.unique(case[grows], return_index=True)
        out[first] = start[grows][place]
        return out

    def splits(self) -> Crossings:
        """Every μ where a pair of the simple model's eigenvalues splits on the real axis or merges again."""
        return self._passages(self._splitting, (0.0,), lambda _: self._splitting, rounding=ROUNDING_OF_EIGENVALUES)
