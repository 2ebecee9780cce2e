"""Certificates of a :class:`~floquet.periodic.PeriodicSystem`, from its exact coefficients."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import ParameterError
from ..periodic import PeriodicMatrix, PeriodicSystem
from .exact import FUNCTION, Matrix
from .result import Certificate, identical
from .scalar import certified_hill
from .systems import certified_constant, certified_system, companion

__all__ = ["certify"]

SIMPLE = 64  # largest denominator of a multiple of π that a double is taken to mean
Pieces = list[list[Matrix]]


def certify(system: PeriodicSystem, *, digits: int = 20, limit: int = 512) -> list[Certificate]:
    """A certificate for each case of ``system``, in order.

    Coefficients are exact (:meth:`~floquet.periodic.PeriodicSystem.part`): those of a model's parameters, otherwise
    the stored doubles.  A period or an edge that is the double of a simple multiple of π is taken as that multiple.
    Identical blades have the exponents of one, shifted by whole numbers.
    """
    if system.function is not None:
        raise ParameterError("function", system.name, FUNCTION)
    if system.blade is not None:
        return [identical(c, system.degrees) for c in certify(system.blade, digits=digits, limit=limit)]
    cases = range(math.prod(system.cases))
    return [_one(system.part(np.array([i]), exact=True), digits, limit) for i in cases]


def _one(system: PeriodicSystem, digits: int, limit: int) -> Certificate:
    """The certificate of a single exact case."""
    matrices = _on_common_pieces(system)
    parts, edges = zip(*(_pieces(m, system.period) for m in matrices), strict=True)
    if system.constant:
        A = companion(*(p[0] for p in parts)) if system.second_order else parts[0][0]
        return certified_constant(A[0], digits=digits, limit=limit)
    T, base = _simple(system.period), _simple(matrices[0].period)
    if isinstance(T, float) or isinstance(base, float):
        T, base = system.period, matrices[0].period
    options: dict[str, Any] = {"base": base, "edges": edges[0], "digits": digits, "limit": limit}
    if system.second_order and system.degrees == 1:
        d, k = ([[m[0][0] for m in piece] for piece in part] for part in parts)
        return certified_hill(d if edges[0] else d[0], k if edges[0] else k[0], T, **options)
    states = [companion(*pair) for pair in zip(*parts, strict=True)] if system.second_order else parts[0]
    twist = None if system.twist is None else [int(s) for s in system.twist]
    return certified_system(states if edges[0] else states[0], T, twist=twist, **options)


def _on_common_pieces(system: PeriodicSystem) -> list[PeriodicMatrix]:
    """D and K, or A, of the only case."""
    parts = [system.matrix]
    if system.second_order:
        K = system.stiffness
        assert K is not None
        D = 0 * K if system.damping is None else system.damping + 0 * K
        parts = [D, K + 0 * D]
    return [m.flat(m.cases).case(0) for m in parts if m is not None]


def _pieces(m: PeriodicMatrix, period: float) -> tuple[Pieces, list[float | Fraction]]:
    """[mean, cos, sin, …] of the pieces that have a length, and the edges between them."""
    if m.edges is None:
        return [m.coefficients[0].tolist()], []
    ends = [min(float(x), period) for x in m.edges]
    kept = [i for i, (a, b) in enumerate(pairwise(ends)) if b > a]
    return [m.coefficients[i].tolist() for i in kept], [_simple(ends[i]) for i in kept[1:]]


def _simple(x: float) -> float | Fraction:
    """The simple multiple of π that x is the double of, or x."""
    ratio = Fraction(x / math.pi).limit_denominator(SIMPLE) if math.isfinite(x) else Fraction(0)
    return ratio if ratio and math.isclose(float(ratio) * math.pi, x, rel_tol=2.0**-52) else x
