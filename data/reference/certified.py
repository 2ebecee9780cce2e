"""Ten thousand random rotors with proven exponents: the program that writes ``certified.npz``.

    python data/reference/certified.py            # two minutes, the same bytes every time

Enclosures are those of ``floquet.certify`` (ball arithmetic, every truncation bounded); the equations are stated here
again, in exact fractions, and share no code with ``floquet.models``.  Blade-element integrals, U_T = x + u and
u = μ sin ψ, from the root ε to the tip B::

    d = c + γ/2 ∫ U_T (x-ε)² dx,    k = 1 + κ + m + γ/2 [K₁ ∫ U_T² (x-ε) dx + μ cos ψ ∫ U_T (x-ε) dx]

With reversed flow |U_T| for U_T and U_T |U_T| for U_T²: with P the primitive in x the integral is P(B) - P(ε) for
u ≥ -ε, P(B) + P(ε) - 2 P(-u) for -B < u < -ε and P(ε) - P(B) for u ≤ -B.  Without ``exact_offset`` the coefficients are
those that NASA TP-1431 truncates at ε² (its eq. 1), and teetering rotors are its eq. 2.

Arrays of ``certified.npz``, one row a case:

====================  ==============  ================================================================================
``parameters``        (10000, 7)      columns in ``names``; every double is the exact parameter, and the offset mass
                                      ratio m is the double ``1.5 * hinge_offset``
``teetering`` …       (10000,)        which model, and its options ``exact_offset``, ``reversed_flow``
``real``, ``rho``     (10000, 2, 2),  σ₁ ≥ σ₂ and ρ, each as [head, tail] whose sum is the number to ``radius``; the
                      (10000, 2)      exponents are σ ± iρ outside a lock and σ₁ + iρ, σ₂ + iρ in one
``discriminant``      (10000,)        D of the Hill form; positive in a lock
``locked``            (10000,)        1, 0, or -1 where the sign of D is not proven
``verdict``           (10000,)        floquet.exponents.Verdict
``radius``            ()              no exponent is further from the stored sum
``multiblade_…``      (300, …)        the same for the blade of rotors of ``multiblade_blades`` identical blades, whose
                                      exponents are the blade's + ik, k = 0 … N-1, modulo Ni; where
                                      ``multiblade_direct`` the multiblade equations themselves are certified, and
                                      enclose the same exponents
``hard_…``            (1200, …)       the same for points that try a bound: next to the ends of locks, and where motions
                                      grow by decades a revolution, in locks and where the map has large entries and
                                      small exponents.  floquet's own maps choose the last 400 of half a million
====================  ==============  ================================================================================
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx, fmpq

from floquet import Rotor, flapping
from floquet.certify import Certificate, certified_hill, certified_system, companion
from floquet.period_map import period_map

SEED, COUNT, MULTIBLADE, DIRECT, HARD = 1431, 10_000, 300, 40, 400
DIGITS = 26  # decimals of every exponent
NAMES = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling", "flap_damping", "tip_loss",
         "advance_ratio")  # fmt: skip
LOW, HIGH = (2.0, 0.0, 0.0, -0.5, 0.0, 0.9, 0.0), (24.0, 0.2, 0.5, 0.5, 0.3, 1.0, 1.5)
Wave = list[Fraction]
"""[mean, cos, sin, cos 2, sin 2, …] of ψ."""


class Case(NamedTuple):
    """A rotor at an advance ratio: its parameters by NAMES, and its model."""

    values: tuple[float, ...]
    teetering: bool = False
    exact_offset: bool = False
    reversed_flow: bool = False

    @property
    def offset_mass_ratio(self) -> float:
        """m: 1.5 ε, rounded."""
        return 1.5 * self.values[NAMES.index("hinge_offset")]


# ---------------------------------------------------------------------- trigonometric polynomials
def wave(order: int, cosine: int, sine: int) -> Wave:
    """cosine cos(order ψ) + sine sin(order ψ)."""
    return [Fraction(cosine)] if order == 0 else [Fraction(0)] * (2 * order - 1) + [Fraction(cosine), Fraction(sine)]


def added(*waves: Wave) -> Wave:
    """Their sum."""
    return [sum((w[i] for w in waves if i < len(w)), Fraction(0)) for i in range(max(map(len, waves)))]


def scaled(factor: Fraction | int, w: Wave) -> Wave:
    """factor times w."""
    return [factor * x for x in w]


def times(a: Wave, b: Wave) -> Wave:
    """Product, from cos x cos y = ½ [cos(x-y) + cos(x+y)] and the like."""
    out = [Fraction(0)] * (2 * (len(a) // 2 + len(b) // 2) + 1)
    for m, n in product(range(len(a) // 2 + 1), range(len(b) // 2 + 1)):
        (c, s), (x, y) = _pair(a, m), _pair(b, n)
        for order, cosine, sine in ((m + n, c * x - s * y, c * y + s * x), (m - n, c * x + s * y, s * x - c * y)):
            i = abs(order)
            out[max(2 * i - 1, 0)] += cosine / 2
            if i:
                out[2 * i] += (sine if order > 0 else -sine) / 2
    return out


def _pair(w: Wave, m: int) -> tuple[Fraction, Fraction]:
    return (w[0], Fraction(0)) if m == 0 else (w[2 * m - 1], w[2 * m])


def derivative(w: Wave) -> Wave:
    """d/dψ."""
    out = [Fraction(0)] * len(w)
    for m in range(1, len(w) // 2 + 1):
        out[2 * m - 1], out[2 * m] = m * w[2 * m], -m * w[2 * m - 1]
    return out


def of_speed(coefficients: Sequence[Fraction], mu: Fraction) -> Wave:
    """Σ coefficients[b] (μ sin ψ)^b."""
    out, power = [Fraction(0)], [Fraction(1)]
    for c in coefficients:
        out, power = added(out, scaled(c, power)), times(power, [Fraction(0), Fraction(0), mu])
    return out


# ---------------------------------------------------------------------- one blade
def blade(case: Case, m: float | None = None) -> tuple[list[Wave], list[Wave], list[Any]]:
    """d and k on each piece, and the edges between them; another m may be given."""
    gamma, eps, kappa, K1, damping, tip, mu = (Fraction(x) for x in case.values)
    structure = 1 + kappa + Fraction(case.offset_mass_ratio if m is None else m)
    if case.teetering:
        d, k = teetering(gamma, kappa, K1, mu)
    elif not case.exact_offset:
        d, k = truncated(gamma, eps, K1, mu, structure)
    else:
        sets, edges = integrals(eps, tip, mu) if case.reversed_flow else ([forward(eps, tip)], [])
        ds = [added([damping], scaled(gamma / 2, of_speed(rate, mu))) for rate, _, _ in sets]
        ks = [
            added(
                [structure],
                scaled(gamma / 2 * K1, of_speed(pitch, mu)),
                scaled(gamma / 2 * mu, times(wave(1, 1, 0), of_speed(inflow, mu))),
            )
            for _, inflow, pitch in sets
        ]
        return ds, ks, edges
    return [added([damping], d)], [k], []


def truncated(gamma: Fraction, eps: Fraction, K1: Fraction, mu: Fraction, structure: Fraction) -> tuple[Wave, Wave]:
    """Eq. (1), Q = (1-ε)²/2."""
    g, Q = gamma / 2, (1 - eps) ** 2 / 2
    P2 = structure + gamma * K1 / 8 * (1 - 4 * eps / 3)
    d = [g * (Fraction(1, 4) - 2 * eps / 3 + eps**2 / 2), Fraction(0), g * mu * (Fraction(1, 3) - eps + eps**2)]
    first = [g * mu * (Fraction(1, 3) - eps / 2), gamma * K1 / 2 * mu * (Fraction(2, 3) - eps)]
    second = [-gamma * K1 * mu**2 * Q / 4, gamma * mu**2 * Q / 4]
    return d, [P2 + gamma * K1 * mu**2 * Q / 4, *first, *second]


def teetering(gamma: Fraction, kappa: Fraction, K1: Fraction, mu: Fraction) -> tuple[Wave, Wave]:
    """Eq. (2), in harmonics of ψ (the odd ones are zero)."""
    P2, depth, zero = 1 + kappa + gamma * K1 / 8, gamma * mu**2 / 8, Fraction(0)
    return [gamma / 8], [P2 + K1 * depth, zero, zero, -K1 * depth, depth]


def primitive(p: int, k: int, eps: Fraction) -> dict[tuple[int, int], Fraction]:
    """∫ (x+u)^p (x-ε)^k dx by powers of x and u."""
    out: dict[tuple[int, int], Fraction] = {}
    for a, b in product(range(p + 1), range(k + 1)):
        power = p - a + b + 1
        term = math.comb(p, a) * math.comb(k, b) * (-eps) ** (k - b) / power
        out[power, a] = out.get((power, a), Fraction(0)) + term
    return out


def at(terms: dict[tuple[int, int], Fraction], x: Fraction | None) -> list[Fraction]:
    """A primitive at x, or at x = -u for None, by powers of u."""
    out = [Fraction(0)] * 6
    for (i, j), c in terms.items():
        out[j if x is not None else i + j] += c * (x**i if x is not None else (-1) ** i)
    return out


ORDERS = ((1, 2), (1, 1), (2, 1))  # (p, k) of damping, inflow and pitch


def forward(eps: Fraction, tip: Fraction) -> list[list[Fraction]]:
    """The three integrals where no part of the blade meets the air backwards."""
    terms = [primitive(p, k, eps) for p, k in ORDERS]
    return [[b - a for a, b in zip(at(t, eps), at(t, tip), strict=True)] for t in terms]


def integrals(eps: Fraction, tip: Fraction, mu: Fraction) -> tuple[list[list[list[Fraction]]], list[Any]]:
    """The three integrals on each piece with reversed flow, and the edges."""
    ahead = forward(eps, tip)
    if mu <= eps:
        return [ahead], []
    terms = [primitive(p, k, eps) for p, k in ORDERS]
    mixed = [[a + b - 2 * c for a, b, c in zip(at(t, eps), at(t, tip), at(t, None), strict=True)] for t in terms]
    behind = [[-x for x in row] for row in ahead]

    def entered(radius: Fraction) -> tuple[Any, Any]:
        """Where u falls below -radius, and where it rises above it: callables that enclose them."""

        def angle() -> arb:
            return (arb(fmpq(radius.numerator, radius.denominator)) / arb(fmpq(mu.numerator, mu.denominator))).asin()

        return lambda: arb.pi() + angle(), lambda: 2 * arb.pi() - angle()

    root = entered(eps) if eps else (Fraction(1), None)
    inner = [mixed, behind, mixed] if mu > tip else [mixed]
    edges = [root[0], *(entered(tip) if mu > tip else ()), *([root[1]] if eps else [])]
    return [ahead, *inner, *([ahead] if eps else [])], edges


def certificate(case: Case, digits: int = DIGITS, m: float | None = None) -> Certificate:
    """Proven exponents of a case."""
    d, k, edges = blade(case, m)
    period = Fraction(1 if case.teetering else 2)
    if edges:
        return certified_hill(d, k, period, edges=edges, digits=digits)
    return certified_hill(d[0], k[0], period, base=Fraction(2), digits=digits)


# ---------------------------------------------------------------------- multiblade coordinates
def multiblade(case: Case, blades: int, digits: int = 20, m: float | None = None) -> Certificate:
    """Proven exponents of identical blades in multiblade coordinates, over the passage 2π/N.

    D = T⁻¹(2T' + AT), K = T⁻¹(T'' + AT' + BT) with β_i = β₀ + Σ (β_nc cos nψ_i + β_ns sin nψ_i) [+ (-1)^i β_d], so that
    every entry is a mean over the blades of a polynomial of ψ_i: what is left of e^{ikψ_i} is e^{ikψ} for k a multiple
    of N, and with the sign (-1)^i minus that for k an odd multiple of N/2.
    """
    N, (d, k) = blades, (part[0] for part in blade(case, m)[:2])
    columns = [(wave(0, 1, 0), 1)]
    columns += [(wave(n, c, 1 - c), 1) for n in range(1, (N - 1) // 2 + 1) for c in (1, 0)]
    columns += [(wave(0, 1, 0), -1)] if N % 2 == 0 else []

    def matrix(terms: list[Wave]) -> list[list[list[Fraction]]]:
        rows = []
        for i, (row, sign) in enumerate(columns):
            weight = 1 if i == 0 or sign < 0 else 2
            means = [_mean(times(row, t), N, sign * s) for t, (_, s) in zip(terms, columns, strict=True)]
            rows.append([scaled(weight, m) for m in means])
        order = max(len(m) for r in rows for m in r)
        return [[[m[h] if h < len(m) else Fraction(0) for m in r] for r in rows] for h in range(order)]

    D = matrix([added(scaled(2, derivative(c)), times(d, c)) for c, _ in columns])
    K = matrix([added(derivative(derivative(c)), times(d, derivative(c)), times(k, c)) for c, _ in columns])
    twist = [sign for _, sign in columns] * 2
    return certified_system(companion(D, K), Fraction(2, N), base=Fraction(2), twist=twist, digits=digits)


def _mean(w: Wave, N: int, sign: int) -> Wave:
    """Mean over the blades of w(ψ_i), times (-1)^i for sign < 0."""
    shift = 0 if sign > 0 else N // 2
    return [sign * x if ((i + 1) // 2 - shift) % N == 0 else Fraction(0) for i, x in enumerate(w)]


def encloses_the_blade(direct: Certificate, one: Certificate, blades: int) -> bool:
    """Whether the balls of the multiblade equations meet the blade's + ik, one to one, modulo Ni."""
    wanted = [(arb(re), arb(im) + k) for re, im in one.balls for k in range(blades)]
    left = [(arb(re), arb(im)) for re, im in direct.balls]
    for re, im in wanted:
        near = [z for z in left if z[0].overlaps(re) and ((z[1] - im) / blades).contains_integer()]
        if not near:
            return False
        left.remove(near[0])
    return not left


# ---------------------------------------------------------------------- the file
def cases() -> list[Case]:
    """The ten thousand, always the same: 60 % flapping, 25 % teetering, the rest with options."""
    rng = np.random.default_rng(SEED)
    out = []
    for i, row in enumerate(rng.uniform(LOW, HIGH, (COUNT, len(NAMES))).tolist()):
        gamma, eps, kappa, K1, damping, tip, mu = row
        share = i % 20
        if share < 12:
            out.append(Case((gamma, eps, kappa, K1, 0.0, 1.0, mu)))
        elif share < 17:
            out.append(Case((gamma, 0.0, kappa, K1, 0.0, 1.0, mu), teetering=True))
        else:  # options alone and together
            values = (
                gamma,
                eps if share < 19 or i % 3 else 0.0,
                kappa,
                K1,
                damping * (i % 2),
                tip if i % 40 < 20 else 1.0,
                mu,
            )
            out.append(Case(values, exact_offset=True, reversed_flow=share > 17))
    return out


def multiblade_cases() -> list[tuple[Case, int]]:
    """Three hundred blades with N = 3 … 6."""
    rng = np.random.default_rng(SEED + 1)
    rows = rng.uniform(LOW, HIGH, (MULTIBLADE, len(NAMES))).tolist()
    return [(Case((*row[:4], 0.0, 1.0, row[6])), 3 + i % 4) for i, row in enumerate(rows)]


def hard_cases() -> list[Case]:
    """Next to ends of locks, from 1e-3 down to the last bit; growth by many decades, in locks and where D is small."""
    rng = np.random.default_rng(SEED + 2)
    rows = rng.uniform((*LOW[:6], 0.0), (40.0, *HIGH[1:6], 2.0), (HARD // 8, len(NAMES))).tolist()
    out = []
    for i, row in enumerate(rows):
        edge = lock_end(model(i, row))
        out += [moved(edge, sign * 10.0 ** -rng.uniform(3.0, 16.5)) for sign in (-1, 1) for _ in range(4)]
    wide = rng.uniform((16.0, *LOW[1:]), (64.0, *HIGH[1:6], 2.5), (HARD, len(NAMES))).tolist()
    out += [model(i, row) for i, row in enumerate(wide)]
    return out + grown(rng)


def grown(rng: np.random.Generator) -> list[Case]:
    """Of half a million flapping blades those whose map has the largest entries for the D they make."""
    values = rng.uniform(LOW, HIGH, (500_000, len(NAMES)))
    values[:, 3] *= 2.0
    values[:, 4:6] = 0.0, 1.0
    gamma, eps, kappa, K1, _, _, mu = values.T
    rotor = Rotor(lock_number=gamma, hinge_offset=eps, hinge_stiffness=kappa, pitch_flap_coupling=K1)
    _, b, c, _, _, _, _, _, D = period_map(flapping(rotor, mu)).rows
    chosen = np.argsort(np.abs(b * c) / (1.0 + np.abs(D)))[-HARD:]
    return [Case(tuple(row)) for row in values[np.sort(chosen)].tolist()]


def model(i: int, row: Sequence[float]) -> Case:
    """Flapping as the report has it, teetering, and with options, in turn."""
    gamma, eps, kappa, K1, damping, tip, mu = row
    if i % 4 == 3:
        return Case((gamma, eps, kappa, K1, damping, tip, mu), exact_offset=True, reversed_flow=True)
    return Case((gamma, eps * (i % 4 != 2), kappa, K1, 0.0, 1.0, mu), teetering=i % 4 == 2)


def moved(case: Case, step: float) -> Case:
    """The case at another advance ratio."""
    return case._replace(values=(*case.values[:6], case.values[6] + step))


def lock_end(case: Case) -> Case:
    """At the first change of sign of D above the case's advance ratio, to the last bit; two on if none comes."""
    low = case.values[6]
    for _ in range(40):
        if _locked(case, low) != _locked(case, low + 0.05):
            break
        low += 0.05
    high = low + 0.05
    was = _locked(case, low)
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if _locked(case, middle) == was else (low, middle)
    return case._replace(values=(*case.values[:6], low))


def _locked(case: Case, mu: float) -> bool:
    return certificate(case._replace(values=(*case.values[:6], mu)), digits=8).discriminant > 0.0


def arrays(given: Sequence[Case]) -> dict[str, Any]:
    """The stored arrays of cases."""
    found = [certificate(case) for case in given]
    real, rho, radii = [], [], []
    for c in found:
        with ctx.workprec(c.bits + 64):
            balls = [arb(c.balls[0][0]), arb(c.balls[1][0]), arb(c.balls[0][1])]
            split = [_split(b) for b in balls]
            left = [(b - arb(h) - arb(t)).abs_upper() for b, (h, t) in zip(balls, split, strict=True)]
            radii += [float((max(left[0], left[1]) ** 2 + left[2] ** 2).sqrt().upper())]
        real.append(split[:2])
        rho.append(split[2])
    return {
        "parameters": np.array([case.values for case in given]),
        "teetering": np.array([case.teetering for case in given]),
        "exact_offset": np.array([case.exact_offset for case in given]),
        "reversed_flow": np.array([case.reversed_flow for case in given]),
        "real": np.array(real),
        "rho": np.array(rho),
        "discriminant": np.array([c.discriminant for c in found]),
        "locked": np.array([-1 if c.locked is None else int(c.locked) for c in found], np.int8),
        "verdict": np.array([int(c.verdict) for c in found], np.int8),
        "radius": np.array(math.nextafter(max(radii), 1.0)),
    }


def _split(x: arb) -> tuple[float, float]:
    """Midpoint as head + tail."""
    head = float(x.mid())
    return head, float((x.mid() - arb(head)).mid())


def main() -> None:
    """Write certified.npz beside this file."""
    out = {"names": np.array(NAMES), **arrays(cases())}
    rotors = multiblade_cases()
    for name, value in arrays([case for case, _ in rotors]).items():
        out[f"multiblade_{name}"] = value
    for case, blades in rotors[:DIRECT]:
        if not encloses_the_blade(multiblade(case, blades), certificate(case), blades):
            sys.exit(f"the multiblade equations of {case} do not enclose the blade's exponents")
    out |= {f"hard_{name}": value for name, value in arrays(hard_cases()).items()}
    out["multiblade_blades"] = np.array([blades for _, blades in rotors], np.int8)
    out["multiblade_direct"] = np.arange(MULTIBLADE) < DIRECT
    np.savez_compressed(Path(__file__).with_name("certified.npz"), **out)


if __name__ == "__main__":
    main()
