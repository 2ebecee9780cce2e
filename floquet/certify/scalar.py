"""One equation, ``y'' + d y' + k y = 0``: enclosures of both exponents on the branch of the rotation number.

d and k are trigonometric polynomials of θ = ωt on each piece.  In Hill form, with β = exp(-½∫d dt) y and primes d/dθ::

    y'' + q y = 0,    q = (k - ½ ω d' - ¼ d²)/ω²,    exponents α ± ν,  α = -mean(d)/2,    det Φ = 1

and where d jumps by Δ, y' jumps by Δ y/(2ω).  Panels are series about their centres (:mod:`.series`).

**Theorem 2.**  Let s² ≥ |q|.  In the plane (y, y'/s) the angle φ of a solution turns clockwise with
φ' = s cos²φ + (q/s) sin²φ, so |φ'| ≤ s, hence by less than π over a half panel with s h ≤ 3.  At a kick y stays, so
that it turns by less than π there too: each is the principal angle between two vectors.  Their sum over a period, t
revolutions, and the rotation number ρ have |t - ρT/2π| < ½.

*Proof.*  On lines through the origin the angle after a period, F(φ), is a lift of an orientation-preserving circle map
of period π, so that F(φ) - φ varies by less than π; its mean rate lies between its extremes.  (y, y') is β's vector up
to a positive factor and a shear that is the same after a period, which do not change mean rates.  ∎

With τ half the trace of Φ and D = ((Φ₁₁-Φ₂₂)/2)² + Φ₁₂ Φ₂₁ = τ² - 1::

    D < 0   ρT/2π = atan2(-sign(Φ₂₁) √-D, τ)/2π modulo 1
    D > 0   a lock: νT = asinh √D, ρT/2π = 0 or ½ modulo 1 by the sign of τ

so that t leaves one integer.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import mul
from typing import Any, NamedTuple, TypeAlias

from flint import acb, arb, ctx

from .exact import Clock, Edge, Exact, Unproved, ball, orders, pieces, polynomial
from .result import Certificate, Found, proven
from .series import HALF_SWEEP, LONGEST, Trig, Weights, last, panels, plus_minus, tail, weights

__all__ = ["certified_hill"]

Map: TypeAlias = tuple[arb, arb, arb, arb]
"""[Φ₁₁, Φ₁₂, Φ₂₁, Φ₂₂] of (y, y')."""
ONE: Map = (arb(1), arb(0), arb(0), arb(1))


def certified_hill(
    d: Sequence[Any],
    k: Sequence[Any],
    period: float | Fraction,
    *,
    base: float | Fraction | None = None,
    edges: Sequence[Edge] = (),
    digits: int = 20,
    limit: int = 512,
) -> Certificate:
    """Both exponents of ``y'' + d(t) y' + k(t) y = 0``, proven.

    Parameters
    ----------
    d, k : sequence of exact numbers
        [mean, cos, sin, cos 2, sin 2, …] of the angle ωt, ω = 2π/base; with ``edges``, one such sequence a piece.
    period : float or Fraction
        T after which d and k repeat; a Fraction is a multiple of π.
    base : float or Fraction, optional
        Period of harmonic 1; T unless given.
    edges : sequence of float, Fraction or callable
        Where pieces meet, inside (0, T).
    digits : int
        Wanted decimals of the exponents.
    limit : int
        Bits up to which precision is raised for them, for the verdict and for the sign of D.
    """
    clock = Clock.of(period, base)
    parts = [(polynomial(a, "d"), polynomial(b, "k")) for a, b in pieces((d, k), edges, ("d", "k"))]
    if len(parts) == 1:
        clock.check([(m, 1) for p in parts[0] for m in orders(p)])
        if all(len(p) == 1 for p in parts[0]):
            return proven(lambda: _constant(parts[0], clock), digits, limit)
    return proven(lambda: _enclosed(parts, edges, clock), digits, limit)


# ---------------------------------------------------------------------- Hill form
class _Piece(NamedTuple):
    """y'' + q y = 0 for start ≤ θ ≤ stop, after y' has jumped by kick·y."""

    start: arb
    stop: arb
    q: Trig
    kick: arb | None


def _enclosed(parts: Sequence[tuple[list[Exact], list[Exact]]], edges: Sequence[Edge], clock: Clock) -> Found:
    """Enclosures from the coefficients (d, k) of each piece."""
    angles, omega = clock.angles(edges), clock.omega
    damping = [Trig.of(d) for d, _ in parts]
    forms = [_hill_form(d, Trig.of(k), omega) for d, (_, k) in zip(damping, parts, strict=True)]
    kicks, mean = _kicks(damping, angles, omega), damping[0].mean
    if len(parts) > 1:
        mean = sum((d.integral(*ends) for d, ends in zip(damping, pairwise(angles), strict=True)), arb(0)) / angles[-1]
    phi, turns = _map([_Piece(*ends, q, kick) for ends, q, kick in zip(pairwise(angles), forms, kicks, strict=True)])
    undamped = all(x == 0 for d, _ in parts for x in d) or (len(parts) == 1 and parts[0][0][0] == 0)
    return _closed(phi, turns, -mean / 2, clock, undamped)


def _hill_form(d: Trig, k: Trig, omega: arb) -> Trig:
    """q = (k - ½ω d' - ¼d²)/ω², d' = dd/dθ."""
    square, scale = d.squared(), 1 / (omega * omega)
    waves = [acb(0)] * max(len(k.waves), len(square.waves))
    for m, z in enumerate(k.waves):
        waves[m] += z
    for m, z in enumerate(d.waves):
        waves[m] -= acb(0, omega * (m + 1) / 2) * z
    for m, z in enumerate(square.waves):
        waves[m] -= z / 4
    return Trig((k.mean - square.mean / 4) * scale, [z * scale for z in waves])


def _kicks(damping: Sequence[Trig], angles: Sequence[arb], omega: arb) -> list[arb | None]:
    """What y' jumps by at the start of each piece, over y; a single piece has no jumps."""
    if len(damping) == 1:
        return [None]
    ends = [angles[-1], *angles[1:-1]]
    return [(damping[i].value(angles[i]) - damping[i - 1].value(ends[i])) / (2 * omega) for i in range(len(damping))]


# ---------------------------------------------------------------------- the map of one period
def _map(parts: Sequence[_Piece]) -> tuple[Map, list[arb]]:
    """Φ, and the revolutions of (1, 0) and (0, 1)."""
    s = reduce(arb.max, (sum(p.q.sizes(), abs(p.q.mean)) for p in parts)).sqrt()
    s = s if s > 0 else arb(1)
    phi, turns = ONE, [arb(0), arb(0)]
    for step in _steps(parts, s):
        before, phi = phi, _times(step, phi)
        turns = [t + _turned(before[column::2], phi[column::2], s) for column, t in enumerate(turns)]
    return phi, [t / (2 * arb.pi()) for t in turns]


def _steps(parts: Sequence[_Piece], s: arb) -> Iterator[Map]:
    """Kicks and half panels in order, each turning by less than π."""
    for piece in parts:
        if piece.kick is not None:
            yield (arb(1), arb(0), piece.kick, arb(1))
        span = piece.stop - piece.start
        count = panels(span, s, len(piece.q.waves))
        half = span / (2 * count)
        table = weights(abs(piece.q.mean), piece.q.sizes(), half, half * half)
        for i in range(count):
            yield from _panel(piece.q, table, piece.start + (2 * i + 1) * half, s)


def _panel(q: Trig, table: Weights, centre: arb, s: arb) -> tuple[Map, Map]:
    """Maps of (y, y') from the start of a panel to its centre, and from there to its end."""
    h, w = table.half, s * table.half
    if not w <= HALF_SWEEP:
        raise Unproved
    u = _series(_taylor(q, table, centre))
    spread = plus_minus(tail(map(abs, u), table.tails, 2) * w.cosh())
    left_out = acb(spread, spread)
    rates = [n * z for n, z in enumerate(u)]
    even, odd = sum(u[::2], left_out), sum(u[1::2], acb(0))
    even_rate, odd_rate = sum(rates[::2], left_out), sum(rates[1::2], acb(0))
    y, rate = even - odd, odd_rate - even_rate  # at x = -1, where the map back has determinant 1 too
    to_centre = (rate.imag, -y.imag * h, -rate.real / h, y.real)
    y, rate = even + odd, odd_rate + even_rate
    return to_centre, (y.real, y.imag * h, rate.real / h, rate.imag)


def _taylor(q: Trig, table: Weights, centre: arb) -> list[arb]:
    """-f_j = -h² q_j of q(centre + h x), j < J."""
    length = len(table.tails) - 1
    f = [arb(0)] * length
    for z, row in zip(q.turned(centre), table.rows, strict=True):
        a, b = -z.real, -z.imag
        f = list(map(operator.add, f, map(mul, [a, -b, -a, b] * (length // 4 + 1), row)))
    f[0] -= table.factor * q.mean
    return f


def _series(f: Sequence[arb]) -> list[acb]:
    """u_n of y'' = f y with (y, y') = (1, 0) and, as imaginary part, (0, 1)."""
    smallest, zero = last(), acb(0)
    u = [acb(1), acb(0, 1)]
    for n in range(LONGEST * ctx.prec):
        u.append(sum(map(mul, u[n::-1], f), zero) / ((n + 1) * (n + 2)))
        if abs(u[-1].mid()) <= smallest and abs(u[-2].mid()) <= smallest:
            return u
    raise Unproved


def _times(a: Map, b: Map) -> Map:
    """Product of 2×2 matrices."""
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


def _turned(a: Sequence[arb], b: Sequence[arb], s: arb) -> arb:
    """Clockwise angle from a to b in the plane (y, y'/s)."""
    return arb.atan2((a[1] * b[0] - a[0] * b[1]) / s, a[0] * b[0] + a[1] * b[1] / (s * s))


# ---------------------------------------------------------------------- from the map to exponents
def _closed(phi: Map, turns: Sequence[arb], alpha: arb, clock: Clock, undamped: bool) -> Found:
    """Exponents from the map of the Hill form and its turns (theorem 2)."""
    T, tau, difference = clock.T, (phi[0] + phi[3]) / 2, (phi[0] - phi[3]) / 2
    D = difference * difference + phi[1] * phi[2]
    locked: bool | None
    if D < 0:
        sign = phi[2].sgn()
        rho = _lifted(arb.atan2(-sign * (-D).sqrt(), tau) / (2 * arb.pi()), turns, clock)
        found, real, locked = [acb(alpha, rho), acb(alpha, -rho)], [alpha], False
    elif D > 0:
        growth, rho = D.sqrt().asinh() / T, _lifted(_half(tau), turns, clock)
        real, locked = [alpha + growth, alpha - growth], True
        found = [acb(x, rho) for x in real]
    else:  # all that is known is |sinh² νT| ≤ size
        size = D.abs_upper()
        growth, angle = size.sqrt().asinh() / T, size.sqrt().asin() / (2 * arb.pi())
        rho = _lifted(_half(tau) + plus_minus(angle), turns, clock)
        real, locked = [alpha + growth.union(arb(0)), alpha - growth.union(arb(0))], None
        found = [acb(alpha + plus_minus(growth), rho)] * 2
    said = f"over one period the discriminant is in {D.str(6)}"
    return Found(found, _shared(locked), real, D, locked, undamped and locked is False, said)


def _half(tau: arb) -> arb:
    """0 or ½ by the sign of τ."""
    if tau.contains(0):
        raise Unproved
    return arb(0) if tau > 0 else arb(1) / 2


def _lifted(fraction: arb, turns: Sequence[arb], clock: Clock) -> arb:
    """ρ: the fraction of a turn, and the one whole number of turns less than half a turn from a path's."""
    for t in turns:
        distance = t - fraction
        if not distance.is_finite():
            continue
        whole = math.floor(float(distance.mid()) + 0.5)
        if abs(distance - whole) < arb(1) / 2:
            exact = isinstance(clock.period, Fraction)  # then π cancels
            return (fraction + whole) * (ball(2 / clock.period) if exact else 2 * arb.pi() / clock.T)
    raise Unproved


def _constant(part: tuple[list[Exact], list[Exact]], clock: Clock) -> Found:
    """Constant d and k: the roots of η² + d η + k, whose discriminant has an exact sign."""
    d, k = (Fraction(p[0]) for p in part)
    q, alpha, T = k - d * d / 4, ball(-d / 2), clock.T
    root = ball(abs(q)).sqrt()
    if q > 0:
        found, real, D = [acb(alpha, root), acb(alpha, -root)], [alpha], -((root * T).sin() ** 2)
    else:
        real, D = [alpha + root, alpha - root], (root * T).sinh() ** 2
        found = [acb(x) for x in real]
    locked = None if q == 0 else q < 0
    return Found(found, _shared(locked), real, D, locked, d == 0 and q > 0, "the coefficients are constant")


def _shared(locked: bool | None) -> list[int]:
    """How many exponents share each ball: both, on the edge of a lock."""
    return [2, 2] if locked is None else [1, 1]
