"""The Hill form next to its branch points, in fixed point from exact coefficients.

Where D is nearly zero an error δ of Φ is an error √δ of the exponents.  Such points are mapped again: q in fractions
from the parameters as they are, the motion in integers with :data:`BITS` binary digits after the point, by the same
two-sided Taylor series as elsewhere (see :mod:`floquet.kernels.hill`), continued until a term is below the last digit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from operator import mul

import numpy as np
from numpy.typing import NDArray

from ..periodic import PI, TWO_PI, PeriodicMatrix, PeriodicSystem
from .result import Method, PeriodMap

__all__ = ["make_precise"]

BITS = 160
ONE = 1 << BITS
TRUSTED = 2.0**-100  # of Σ|Φ|²: the last 60 digits are left to rounding, a few units a panel, and its growth
TOLERANCE = 1e-11  # bound of an exponent from which a point is mapped again
MOST_PANELS = 512  # in doubles; beyond, a point would take seconds


def make_precise(phi: PeriodMap, system: PeriodicSystem, left_out: NDArray[np.bool_] | None = None) -> PeriodMap:
    """``phi`` with the points near branch points mapped again, those that are ``left_out`` excepted."""
    assert phi.rows is not None
    index = _doubtful(phi)
    if left_out is not None:
        index = index[~left_out[index]]
    if not index.size:
        return phi
    part = system.part(index, exact=True)
    k, d = part.stiffness, part.damping
    assert k is not None
    q = k if d is None else k - d.derivative() / 2 - (d @ d) / 4
    assert phi.methods is not None
    rows, methods = phi.rows.copy(), phi.methods.copy()
    q = q.flat((len(index),))
    for place, case in enumerate(index):
        rows[:, case] = _mapped(q.case(slice(place, place + 1)), phi.period, int(phi.panels[case]))
        methods[case] = Method.PRECISE
    return replace(phi, rows=rows, methods=methods)


def _doubtful(phi: PeriodMap) -> NDArray[np.intp]:
    """The points whose exponents have bounds above :data:`TOLERANCE`."""
    assert phi.rows is not None
    D, b = phi.rows[8], phi.rows[5]
    index = np.flatnonzero(b * b > (TOLERANCE * phi.period) ** 2 * np.abs(D))  # all of them, and some more
    D, b = D[index], b[index]
    bound = b / (phi.period * (np.sqrt(np.abs(D)) + np.sqrt(b)) * np.sqrt(1.0 + np.maximum(D, 0.0)))
    return index[(bound > TOLERANCE) & (phi.panels[index] <= MOST_PANELS) & np.isfinite(D)]


def _mapped(q: PeriodicMatrix, period: float, panels: int) -> list[float]:
    """The rows of one point."""
    ratio = _exact_ratio(period / q.period)  # turns of harmonic 1 a period
    turn = 2 * PI / _exact_ratio(TWO_PI / q.period)
    inner = [] if q.edges is None else [Fraction(e) / turn for e in q.edges[0, 1:-1]]
    edges = [Fraction(0), *(min(e, ratio) for e in inner), ratio]  # in turns of harmonic 1
    m, zeros = [ONE, 0, 0, ONE], 0
    for terms, begin, end in zip(q.coefficients[0, :, :, 0, 0], edges[:-1], edges[1:], strict=True):
        count = math.ceil(panels * (end - begin) / ratio)  # none on a piece without length
        square = _fixed(((end - begin) * turn / (2 * count)) ** 2) if count else 0
        scaled = [_fixed(t) * square >> BITS for t in terms]  # h² q
        lengths = _fixed((end - begin) / count * panels / ratio) if count else ONE  # y' is counted a length
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


def _exact_ratio(ratio: float) -> Fraction:
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
        cosine, sine = _cosine_and_sine(n * centre)
        parts = (c * cosine + s * sine) >> BITS, (s * cosine - c * sine) >> BITS
        for k, weight in enumerate(_weights(n * half)):
            if k == len(p):
                p.append(0)
            value = parts[k % 2] * weight >> BITS
            p[k] += -value if k % 4 < 2 else value
    return p


@lru_cache(4096)
def _weights(turns: Fraction) -> list[int]:
    """x^k/k! of an angle, to the last digit."""
    step, weights = _fixed(2 * PI * turns), [ONE]
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


def _fixed(x: Fraction) -> int:
    """x · 2^BITS, rounded down."""
    return (x.numerator << BITS) // x.denominator


@lru_cache(4096)
def _cosine_and_sine(turns: Fraction) -> tuple[int, int]:
    """cos and sin of an angle, by Taylor's series of a 16th of it."""
    x = _fixed(2 * PI * (turns - round(turns)) / 16)
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
