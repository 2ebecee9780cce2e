"""Exact input, checked: numbers, trigonometric polynomials, matrices of them, periods and edges."""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

from flint import arb, fmpq

from ..errors import ParameterError

__all__ = ["Clock", "Edge", "Exact", "Matrix", "Unproved", "ball", "matrix", "orders", "pieces", "polynomial", "signs"]

Exact: TypeAlias = int | float | Fraction
"""A number taken as it is; as a period or an edge a Fraction is a multiple of π."""
Edge: TypeAlias = float | Fraction | Callable[[], arb]
"""A place in t, or a function that encloses it at the precision in force (``flint.ctx.prec``)."""
Matrix: TypeAlias = list[list[Exact]]
FUNCTION = (
    "a function of t can be sampled but not enclosed, so nothing can be proven of it: give the coefficients of its "
    "trigonometric polynomial, [mean, cos, sin, cos 2, sin 2, …]"
)


class Unproved(Exception):
    """More bits are needed; never leaves this room."""


class Clock(NamedTuple):
    """T and the period of harmonic 1, exact; ``turns`` = T/base.  Angles are θ = ωt, ω = 2π/base."""

    period: float | Fraction
    base: float | Fraction
    turns: Fraction

    @staticmethod
    def of(period: float | Fraction, base: float | Fraction | None) -> Clock:
        """From a period and a base, both float or both Fraction; no base is the period."""
        base = period if base is None else base
        for name, value in (("period", period), ("base", base)):
            if not isinstance(value, float | Fraction) or not 0 < value < math.inf:
                raise ParameterError(
                    name, value, f"{value!r} is no period: give a positive float, or a Fraction for a multiple of π"
                )
        if isinstance(period, float) != isinstance(base, float):
            raise ParameterError(
                "base", base, f"period {period!r} and base {base!r} cannot be compared: give both as float or Fraction"
            )
        return Clock(period, base, Fraction(period) / Fraction(base))

    def check(self, harmonics: Sequence[tuple[int, int]]) -> None:
        """Every harmonic (order, sign) must repeat after T, with the sign that the twist gives it."""
        stray = next((m for m, sign in harmonics if (m * self.turns + Fraction(sign - 1, 4)).denominator != 1), None)
        if stray is not None:
            raise ParameterError(
                "period",
                self.period,
                f"harmonic {stray} does not repeat after {self.turns} of the base period: give a period of the "
                "coefficients, or the twist in which they repeat",
            )

    @property
    def T(self) -> arb:
        """The period."""
        return length(self.period)

    @property
    def omega(self) -> arb:
        """dθ/dt."""
        return ball(2 / self.base) if isinstance(self.base, Fraction) else 2 * arb.pi() / arb(self.base)

    def angles(self, edges: Sequence[Edge]) -> list[arb]:
        """θ at 0, the edges and T; they must rise."""
        inner = [self.omega * (edge() if callable(edge) else length(edge)) for edge in edges]
        angles = [arb(0), *inner, 2 * arb.pi() * ball(self.turns)]
        if any(b <= a for a, b in pairwise(angles)):
            raise ParameterError("edges", edges, "the edges of pieces must rise from above 0 to below the period")
        if not all(b > a for a, b in pairwise(angles)):
            raise Unproved
        return angles


def ball(value: Exact) -> arb:
    """The ball of an exact number at the precision in force."""
    return arb(value) if isinstance(value, float | int) else arb(fmpq(value.numerator, value.denominator))


def length(value: float | Fraction) -> arb:
    """The ball of a period or edge."""
    return arb(value) if isinstance(value, float) else ball(value) * arb.pi()


def number(value: Any, name: str) -> Exact:
    """An exact number: a Fraction, an integer or a finite float."""
    if isinstance(value, Fraction):
        return value
    try:
        exact: Exact = float(value) if isinstance(value, float) else operator.index(value)
        if math.isfinite(exact):
            return exact
    except TypeError:
        pass
    raise ParameterError(
        name, value, f"{value!r} is not an exact number: coefficients are integers, Fractions or finite floats"
    )


def polynomial(values: Any, name: str) -> list[Exact]:
    """[mean, cos, sin, …] without trailing zeros."""
    _of_odd_length(values, name)
    out = [number(x, name) for x in values]
    while len(out) > 1 and out[-1] == out[-2] == 0:
        del out[-2:]
    return out


def matrix(values: Any) -> list[Matrix]:
    """[mean, cos, sin, …] of square matrices."""
    _of_odd_length(values, "A")
    n = len(values[0])
    if any(len(m) != n or any(len(row) != n for row in m) for m in values):
        raise ParameterError("A", values, f"the coefficients of A are not all of its shape, {n} by {n}")
    return [[[number(x, "A") for x in row] for row in m] for m in values]


def orders(values: Sequence[Exact]) -> list[int]:
    """The harmonics of a polynomial that are not zero, and 0."""
    return [0, *((i + 1) // 2 for i, x in enumerate(values) if i and x)]


def pieces(parts: Sequence[Any], edges: Sequence[Edge], names: Sequence[str]) -> list[tuple[Any, ...]]:
    """The coefficients of one piece after another."""
    for part, name in zip(parts, names, strict=True):
        if callable(part):
            raise ParameterError(name, part, FUNCTION)
        if len(edges) and len(part) != len(edges) + 1:
            raise ParameterError(
                name, part, f"{len(part)} pieces for {len(edges)} edges: give one more piece than edges"
            )
    return list(zip(*parts, strict=True)) if len(edges) else [tuple(parts)]


def signs(twist: Sequence[int] | None, n: int) -> list[int]:
    """The diagonal of a twist; ones for None."""
    out = [1] * n if twist is None else [int(s) for s in twist]
    if len(out) != n or any(s not in (1, -1) for s in out):
        raise ParameterError("twist", twist, f"{twist!r} is not {n} numbers 1 or -1, one a state")
    return out


def _of_odd_length(values: Any, name: str) -> None:
    if callable(values):
        raise ParameterError(name, values, FUNCTION)
    if not hasattr(values, "__len__") or len(values) % 2 == 0:
        raise ParameterError(
            name, values, f"{reprlib.repr(values)} is not [mean, cos, sin, cos 2, sin 2, …], which has an odd length"
        )
