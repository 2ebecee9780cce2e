"""Logarithm and arc functions of numbers, without branches and calls, so that loops over them become wide registers.

Each reduces its argument until a few terms of a series are left; errors stay below six units in the last place.
"""

from __future__ import annotations

import math

import numpy as np

from .compiler import inlined

__all__ = ["arcsinh", "arctan2"]

LN_2 = math.log(2.0)
HALF_ROOT = 0x3FE6A09E667F3BCD  # the bits of √½


@inlined
def odd_series(x: float, sign: float, terms: int) -> float:
    """x + sign·x³/3 + x⁵/5 + …: artanh for sign 1, arctan for -1."""
    z, total = sign * x * x, 0.0
    for k in range(terms, 0, -1):
        total = z * (1.0 / (2 * k + 1) + total)
    return x + x * total


@inlined
def logarithm(x: float) -> float:
    """ln x for x > 0, not subnormal: 2 artanh((m-1)/(m+1)) of the mantissa between √½ and √2."""
    bits = np.float64(x).view(np.int64)
    exponent = (bits - np.int64(HALF_ROOT)) >> np.int64(52)
    m = np.int64(bits - (exponent << np.int64(52))).view(np.float64)
    return np.float64(exponent) * LN_2 + 2.0 * odd_series((m - 1.0) / (m + 1.0), 1.0, 11)


@inlined
def arcsinh(x: float) -> float:
    """arsinh x for x ≥ 0: 2 artanh(x/(1+r)) below ½, else ln(x + r), r = √(1+x²)."""
    r = math.sqrt(1.0 + x * x)
    small = 2.0 * odd_series(min(x, 0.5) / (1.0 + math.sqrt(1.0 + min(x, 0.5) * min(x, 0.5))), 1.0, 13)
    return small if x < 0.5 else logarithm(x + r)


@inlined
def arctan2(y: float, x: float) -> float:
    """The angle of (x, y), y ≥ 0: eight times that of a tangent halved three times."""
    t = y / (math.sqrt(x * x + y * y) + abs(x))
    t = t / (1.0 + math.sqrt(1.0 + t * t))
    t = t / (1.0 + math.sqrt(1.0 + t * t))
    angle = 8.0 * odd_series(t, -1.0, 11)
    return angle if x >= 0.0 else math.pi - angle
