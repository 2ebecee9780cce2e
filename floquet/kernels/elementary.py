"""Logarithm, arc and circular functions without branches and calls, so that loops over them become wide registers.

Each reduces its argument until a few terms of a series are left; errors stay below six units in the last place.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .compiler import inlined
from .primitives import select

__all__ = ["arcsinh", "arctan2", "cosine_and_sine"]

LN_2 = math.log(2.0)
HALF_ROOT = 0x3FE6A09E667F3BCD  # the bits of √½
WHOLE = 1.5 * 2.0**52  # added and taken away again: rounds to a whole number
#: ½π in three parts; whole multiples of the first two are exact up to 2^20.
QUARTER = (float.fromhex("0x1.921fb544p+0"), float.fromhex("0x1.0b4611a6p-34"), float.fromhex("0x1.3198a2e037073p-69"))
#: Taylor coefficients of sin and cos, in z = x², from the last to the first that is not written out.
SINE = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(8, 0, -1))
COSINE = tuple((-1) ** k / math.factorial(2 * k) for k in range(8, 1, -1))


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


def cosine_and_sine(x: Any) -> Any:
    """cos x and sin x for |x| < 10^6: series about the nearest multiple of ½π.  Numbers, lanes or arrays."""
    turns = (x * (2.0 / math.pi) + WHOLE) - WHOLE
    r = ((x - turns * QUARTER[0]) - turns * QUARTER[1]) - turns * QUARTER[2]
    z = r * r
    sine, cosine = z * SINE[0] + SINE[1], z * COSINE[0] + COSINE[1]
    for a in SINE[2:]:
        sine = sine * z + a
    for a in COSINE[2:]:
        cosine = cosine * z + a
    sine, cosine = r + r * (z * sine), 1.0 - (0.5 * z - z * z * cosine)
    quarter = turns - 4.0 * ((0.25 * turns + WHOLE) - WHOLE)  # -2 … 2
    crosswise = abs(quarter) == 1.0
    return (
        select(crosswise, sine, cosine) * select((quarter > 0.5) | (quarter < -1.5), -1.0, 1.0),
        select(crosswise, cosine, sine) * select((quarter < -0.5) | (quarter > 1.5), -1.0, 1.0),
    )
