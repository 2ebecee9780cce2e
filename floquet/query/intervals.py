"""What can a node of an expression be, when its columns lie between a chunk's minima and maxima?

Every operation of the language stands here with its two readings: on values, as NumPy computes it, and on the intervals
that its arguments lie in.  Rounding is monotone, so the ends of an interval bound every row's result of + - * / sqrt to
the last bit; powers are widened by 1e-12.  A truth value is an interval in [0, 1].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

MAX_LENGTH = 10_000
"""Characters in an expression, and so the arguments a function may have."""


class Interval(NamedTuple):
    """Every value lies in [low, high], or is nan where ``nan`` says so; truth values lie in [0, 1]."""

    low: float
    high: float
    nan: bool = False


UNKNOWN = Interval(-np.inf, np.inf, True)
_HUGE = float(np.finfo(float).max)


def _hull(corners: Sequence[float], nan: bool) -> Interval:
    """The interval of its corners, nan inside where an end is infinite; a corner inf − inf or 0 · inf says nothing."""
    if np.isnan(corners).any():
        return UNKNOWN
    return Interval(min(corners), max(corners), nan or bool(np.isinf(corners).any()))


def _add(a: Interval, b: Interval) -> Interval:
    return _hull((a.low + b.low, a.high + b.high), a.nan or b.nan)


def _subtract(a: Interval, b: Interval) -> Interval:
    return _hull((a.low - b.high, a.high - b.low), a.nan or b.nan)


def _multiply(a: Interval, b: Interval) -> Interval:
    return _hull([x * y for x in a[:2] for y in b[:2]], a.nan or b.nan)


def _divide(a: Interval, b: Interval) -> Interval:
    if b.low <= 0 <= b.high:
        return UNKNOWN
    return _hull([np.divide(x, y) for x in a[:2] for y in b[:2]], a.nan or b.nan)


def negate(a: Interval) -> Interval:
    return Interval(-a.high, -a.low, a.nan)


def _absolute(a: Interval) -> Interval:
    ends = abs(a.low), abs(a.high)
    return Interval(0.0 if a.low <= 0 <= a.high else min(ends), max(ends), a.nan)


def _root(a: Interval) -> Interval:
    return Interval(np.sqrt(a.low), np.sqrt(a.high), a.nan) if a.low >= 0 else UNKNOWN


def power(a: Interval, exponent: float) -> Interval:
    """Monotone on positive numbers, and for odd natural exponents; even ones go by |x|; the rest is unknown."""
    natural = exponent > 0 and float(exponent).is_integer()
    if natural and exponent % 2 == 0:
        a = _absolute(a)
    if not (a.low > 0 or (a.low == 0 and exponent > 0) or natural):
        return UNKNOWN
    return _widened(_hull([np.power(end, exponent) for end in np.array(a[:2])], a.nan))


def _widened(a: Interval) -> Interval:
    """Room for the last bits of a power, which no two implementations share."""
    low, high = min(a.low, _HUGE), max(a.high, -_HUGE)
    return Interval(low - abs(low) * 1e-12 - 1e-300, high + abs(high) * 1e-12 + 1e-300, a.nan)


def _least(*args: Interval) -> Interval:
    return Interval(min(a.low for a in args), min(a.high for a in args), any(a.nan for a in args))


def _greatest(*args: Interval) -> Interval:
    return Interval(max(a.low for a in args), max(a.high for a in args), any(a.nan for a in args))


def _truth(certain: Any, possible: Any) -> Interval:
    return Interval(float(bool(certain)), float(bool(possible)))


def _not(a: Interval) -> Interval:
    return Interval(1.0 - a.high, 1.0 - a.low)


def _less(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.high < b.low, a.low < b.high)


def _less_equal(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.high <= b.low, a.low <= b.high)


def _equal(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.low == a.high == b.low == b.high, a.low <= b.high and b.low <= a.high)


def among(values: Sequence[float], a: Interval) -> Interval:
    """x in (values): certain where x is one number, possible where one of them lies between the ends."""
    inside = any(a.low <= v <= a.high for v in values)
    return _truth(inside and a.low == a.high and not a.nan, inside)


def _is_nan(a: Interval) -> Interval:
    return _truth(False, a.nan)


def _is_finite(a: Interval) -> Interval:
    return _truth(not a.nan and np.isfinite(a.high - a.low), a.low < np.inf and a.high > -np.inf)


class Operation(NamedTuple):
    """One operation, over arrays and over intervals, and how many arguments it takes."""

    value: Callable[..., Any]
    bounds: Callable[..., Interval]
    least: int = 2
    most: int = 2


def _swapped(function: Callable[[Interval, Interval], Interval]) -> Callable[[Interval, Interval], Interval]:
    return lambda a, b: function(b, a)


ARITHMETIC = {
    "+": Operation(np.add, _add),
    "-": Operation(np.subtract, _subtract),
    "*": Operation(np.multiply, _multiply),
    "/": Operation(np.divide, _divide),
}
COMPARISONS = {
    "<": Operation(np.less, _less),
    "<=": Operation(np.less_equal, _less_equal),
    ">": Operation(np.greater, _swapped(_less)),
    ">=": Operation(np.greater_equal, _swapped(_less_equal)),
    "==": Operation(np.equal, _equal),
    "!=": Operation(np.not_equal, lambda a, b: _not(_equal(a, b))),
}
FUNCTIONS = {
    "abs": Operation(np.abs, _absolute, 1, 1),
    "min": Operation(lambda *args: reduce(np.minimum, args), _least, 2, MAX_LENGTH),
    "max": Operation(lambda *args: reduce(np.maximum, args), _greatest, 2, MAX_LENGTH),
    "sqrt": Operation(np.sqrt, _root, 1, 1),
    "isnan": Operation(np.isnan, _is_nan, 1, 1),
    "isfinite": Operation(np.isfinite, _is_finite, 1, 1),
}
NOT = Operation(np.logical_not, _not, 1, 1)
ALL = Operation(lambda *args: reduce(np.logical_and, args), _least)
ANY = Operation(lambda *args: reduce(np.logical_or, args), _greatest)
