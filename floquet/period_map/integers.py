"""Hill forms in integers with :data:`BITS` binary digits after the point, from exact coefficients.

The motion by the same two-sided Taylor series as elsewhere (see :mod:`floquet.kernels.hill`), continued until a term is
below the last digit: about three milliseconds a point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from operator import mul

import numpy as np
from numpy.typing import NDArray

from ..periodic import PI, TWO_PI, PeriodicMatrix, PeriodicSystem
from .form import polynomial

__all__ = ["ONE", "cosine_and_sine", "exact_ratio", "fixed", "in_integers", "powers"]

Array = NDArray[np.float64]
BITS = 160
ONE = 1 << BITS
TRUSTED = 2.0**-100  # of Σ|Φ|²: the last 60 digits are left to rounding, a few units a panel, and its growth


def in_integers(part: PeriodicSystem, panels: NDArray[np.int32]) -> Array:
    """Rows (:data:`~floquet.kernels.hill.ROWS`) of exact cases along one axis, with so many panels."""
    k, d = part.stiffness, part.damping
    assert k is not None
    q = polynomial(d, k).flat((len(panels),))
    cases = (q.case(slice(place, place + 1)) for place in range(len(panels)))
    return np.transpose([_mapped(case, part.period, int(count)) for case, count in zip(cases, panels, strict=True)])


def _mapped(q: PeriodicMatrix, period: float, panels: int) -> list[float]:
    """The rows of one point."""
    ratio = exact_ratio(period / q.period)  # turns of harmonic 1 a period
    turn = 2 * PI / exact_ratio(TWO_PI / q.period)
    inner = [] if q.edges is None else [Fraction(e) / turn for e in q.edges[0, 1:-1]]
    edges = [Fraction(0), *(min(e, ratio) for e in inner), ratio]  # in turns of harmonic 1
    m, zeros = [ONE, 0, 0, ONE], 0
    for terms, begin, end in zip(q.coefficients[0, :, :, 0, 0], edges[:-1], edges[1:], strict=True):
        count = math.ceil(panels * (end - begin) / ratio)  # none on a piece without length
        square = fixed(((end - begin) * turn / (2 * count)) ** 2) if count else 0
        scaled = [fixed(t) * square >> BITS for t in terms]  # h² q
        lengths = fixed((end - begin) / count * panels / ratio) if count else ONE  # y' is counted a length
        for s in range(count):
            half = (end - begin) / (2 * count)
            f = _panel(scaled, begin + (2 * s + 1) * half, half)
            f = [f[0], f[1] * lengths >> BITS, (f[2] << BITS) // lengths, f[3]]
            before = m[0]
            m = [(a * x + b * y) >> BITS for a, b in (f[:2], f[2:]) for x, y in ((m[0], m[2]), (m[1], m[3]))]
            zeros += (before < 0) != (m[0] < 0)
    D = Fraction((m[0] - m[3]) ** 2 + 4 * m[1] * m[2], 4 << (2 * BITS))
    phi = [x / ONE for x in m]
    trusted = TRUSTED * sum(abs(x) for x in phi) ** 2
    error = trusted + float(np.finfo(float).eps) * abs(float(D))
    length = 0.5 * period / panels
    rounding = 0.5 * float(np.finfo(float).eps) * (abs(phi[0]) + abs(phi[3]))  # of Φ in doubles, of which τ is made
    return [phi[0], phi[1] * length, phi[2] / length, phi[3], trusted + rounding, error, float(zeros), 0.0, float(D)]


def exact_ratio(ratio: float) -> Fraction:
    """A simple fraction, or the double as it is."""
    simple = Fraction(ratio).limit_denominator(1000)
    return simple if math.isclose(simple, ratio, rel_tol=1e-15) else Fraction(ratio)


def _panel(q: Sequence[int], centre: Fraction, half: Fraction) -> list[int]:
    """F of a panel of h² q, in (y, h y'); places in turns of harmonic 1."""
    u, v = _solutions(_series(q, centre, half))
    up, um, udp, udm = _ends(u)
    vp, vm, vdp, vdm = _ends(v)
    f = [up * vdm - vp * udm, vp * um - up * vm, udp * vdm - vdp * udm, vdp * um - udp * vm]
    return [x >> BITS for x in f]


def _series(q: Sequence[int], centre: Fraction, half: Fraction) -> list[int]:
    """p_k of -h² q(centre + h x), until they are below the last digit."""
    p = [-q[0]]
    for n in range(1, len(q) // 2 + 1):
        c, s = q[2 * n - 1], q[2 * n]
        if c == 0 == s:
            continue
        cosine, sine = cosine_and_sine(n * centre)
        parts = (c * cosine + s * sine) >> BITS, (s * cosine - c * sine) >> BITS
        for k, weight in enumerate(powers(n * half)):
            if k == len(p):
                p.append(0)
            value = parts[k % 2] * weight >> BITS
            p[k] += -value if k % 4 < 2 else value
    return p


@lru_cache(4096)
def powers(turns: Fraction) -> list[int]:
    """x^k/k! of an angle, to the last digit."""
    step, weights = fixed(2 * PI * turns), [ONE]
    while weights[-1]:
        weights.append((weights[-1] * step >> BITS) // len(weights))
    return weights


def _solutions(p: list[int]) -> tuple[list[int], list[int]]:
    """Taylor coefficients of the solutions (1, 0) and (0, 1) of y'' = p y."""
    u, v = [ONE, 0], [0, ONE]
    k, small = 0, 0
    while small < 4:
        for y in (u, v):
            total = sum(map(mul, p, y[k::-1]))  # the shorter of the two ends the sum
            y.append((total >> BITS) // ((k + 1) * (k + 2)))
        small = small + 1 if abs(u[-1]) + abs(v[-1]) <= 4 else 0
        k += 1
    return u, v


def _ends(y: list[int]) -> tuple[int, int, int, int]:
    """y(1), y(-1), y'(1), y'(-1)."""
    rates = list(map(mul, range(len(y)), y))
    even, odd = sum(y[::2]), sum(y[1::2])
    rate_even, rate_odd = sum(rates[1::2]), sum(rates[::2])  # y' is even where y is odd
    return even + odd, even - odd, rate_even + rate_odd, rate_even - rate_odd


def fixed(x: Fraction) -> int:
    """x · 2^BITS, rounded down."""
    return (x.numerator << BITS) // x.denominator


@lru_cache(4096)
def cosine_and_sine(turns: Fraction) -> tuple[int, int]:
    """cos and sin of an angle, by Taylor's series of a 16th of it."""
    x = fixed(2 * PI * (turns - round(turns)) / 16)
    square = x * x >> BITS
    cosine, sine, term_c, term_s, k = ONE, x, ONE, x, 0
    while abs(term_c) > 1 or abs(term_s) > 1:  # -1 >> n stays -1
        k += 2
        term_c = -(term_c * square >> BITS) // (k * (k - 1))
        term_s = -(term_s * square >> BITS) // (k * (k + 1))
        cosine, sine = cosine + term_c, sine + term_s
    for _ in range(4):
        cosine, sine = (cosine * cosine - sine * sine) >> BITS, 2 * cosine * sine >> BITS
    return cosine, sine
