"""Theorem 1: what a Taylor polynomial leaves out.

The coefficients are q = mean + Σ_m Re(z_m e^{imθ}).  Over a panel θ = centre + h x, |x| ≤ 1, h² q = Σ_j f_j x^j with::

    Σ_{i≥j} |f_i| ≤ T_j := h² Σ_m |z_m| (mh)^j/j! e^{mh},    T_0 more by h² |mean|                                   (1)

because |Re(z_m i^j)| ≤ |z_m| and i! ≥ j! (i-j)!.

**Theorem 1.**  Let p = Σ_{n<N} u_n x^n with u_{n+2} = -Σ_{j<J} f_j u_{n-j}/((n+1)(n+2)), and w ≥ h √|q|.  The solution
of y'' + h² q y = 0 that starts at x = 0 with p's value and slope has, for |x| ≤ 1, |y - p| and |y' - p'| ≤ r cosh w::

    r = Σ_n |u_n| T_min(J, max(0, N-2-n))

*Proof.*  The defect g = p'' + h² q p has only products f_j u_n with j ≥ J or n + j ≥ N - 2, so that |g| ≤ r by (1).
e = y - p solves e'' = -h² q e - g from e = e' = 0; by Picard's iteration |e| ≤ m and |e'| ≤ m' with m'' = w² m + r from
m = m' = 0, so m = r (cosh wx - 1)/w² ≤ r cosh w and m' = r sinh(wx)/w ≤ r cosh w.  ∎

For states, x' = A x, the same with the norms of h A/ω = Σ f_j x^j, X_{n+1} = Σ_j f_j X_{n-j}/(n+1), N-1 for N-2 and
e^w, w ≥ h ‖A‖/ω, for cosh w.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from operator import mul
from typing import NamedTuple

from flint import acb, acb_poly, arb, ctx

from ..errors import ParameterError
from .exact import Exact, ball

__all__ = ["HALF_SWEEP", "LONGEST", "Trig", "Weights", "last", "panels", "plus_minus", "tail", "weights"]

GUARD = 8  # bits between the precision and the last term kept: more terms would drown in the balls' radii
SWEEP = 4.0  # length of a panel times (largest rate + highest harmonic): the least work from 60 to 250 bits
HALF_SWEEP = 3.0  # what SWEEP leaves of a half panel is at most 2; below π, see theorem 2
PANELS = 20_000  # a period: beyond, coefficients are not those of a vibration
LONGEST = 40  # terms a bit: far beyond what a half sweep of 3 needs


class Trig(NamedTuple):
    """mean + Σ_m Re(z_m e^{imθ}), m = 1, 2, …"""

    mean: arb
    waves: list[acb]

    @staticmethod
    def of(values: Sequence[Exact]) -> Trig:
        """From [mean, cos, sin, cos 2, sin 2, …]."""
        balls = [ball(x) for x in values]
        return Trig(balls[0], [acb(c, -s) for c, s in zip(balls[1::2], balls[2::2], strict=True)])

    def turned(self, theta: arb) -> list[acb]:
        """z_m e^{imθ}."""
        sine, cosine = theta.sin_cos()
        step, power, out = acb(cosine, sine), acb(1), []
        for z in self.waves:
            power *= step
            out.append(z * power)
        return out

    def value(self, theta: arb) -> arb:
        """The polynomial at θ."""
        return sum((z.real for z in self.turned(theta)), self.mean)

    def integral(self, start: arb, stop: arb) -> arb:
        """∫ dθ."""
        ends = zip(self.turned(start), self.turned(stop), strict=True)
        return sum(((b - a).imag / m for m, (a, b) in enumerate(ends, 1)), self.mean * (stop - start))

    def squared(self) -> Trig:
        """The polynomial's square."""
        H = len(self.waves)
        halves = [z / 2 for z in self.waves]
        two_sided = acb_poly([*(z.conjugate() for z in halves[::-1]), acb(self.mean), *halves])
        square = two_sided * two_sided
        return Trig(square[2 * H].real, [2 * square[2 * H + m] for m in range(1, 2 * H + 1)])

    def sizes(self) -> list[arb]:
        """|z_m|."""
        return [abs(z) for z in self.waves]


class Weights(NamedTuple):
    """Of panels of half length h: rows[m-1][j] = factor (mh)^j/j!, tails T_0 … T_J, and the factor of the mean.

    The factor is h² for one equation and h/ω for states.
    """

    half: arb
    factor: arb
    rows: list[list[arb]]
    tails: list[arb]


def weights(mean: arb, sizes: Sequence[arb], half: arb, factor: arb) -> Weights:
    """Taylor weights up to the J from which coefficients with these bounds drown in the precision."""
    grown = [a * (m * half).exp() for m, a in enumerate(sizes, 1)]
    now = [factor for _ in sizes]
    rows: list[list[arb]] = [[] for _ in sizes]
    tails = [factor * (mean + sum(grown, arb(0)))]
    smallest = last()
    while tails[-1].mid() > smallest or len(tails) < 2:
        for row, weight in zip(rows, now, strict=True):
            row.append(weight)
        now = [weight * (m * half) / len(tails) for m, weight in enumerate(now, 1)]
        tails.append(sum(map(mul, grown, now), arb(0)))
    return Weights(half, factor, rows, tails)


def last() -> arb:
    """Size of a term that is not worth keeping."""
    return arb(2) ** (GUARD - ctx.prec)


def tail(sizes: Iterable[arb], tails: Sequence[arb], order: int) -> arb:
    """r of theorem 1 for an equation of this order, with ``sizes`` |u_n|."""
    values, J = list(sizes), len(tails) - 1
    first = len(values) - order
    return sum((size * tails[min(J, max(0, first - n))] for n, size in enumerate(values)), arb(0))


def panels(span: arb, rate: arb, harmonics: int) -> int:
    """Number of panels of a piece of θ; whether they are short enough is checked where it matters."""
    count = math.ceil(float(span.upper()) * (float(rate.upper()) + harmonics) / SWEEP)
    if count > PANELS:
        raise ParameterError(
            "coefficients",
            count,
            f"{count} panels a period would be needed, {PANELS} are the most: the coefficients are too large for the "
            "period, so check the units of both",
        )
    return max(count, 1)


def plus_minus(bound: arb) -> arb:
    """The ball from -bound to bound."""
    return bound.union(-bound)
