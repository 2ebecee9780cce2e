"""Certificates, and the precision that is raised until there is one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

from flint import acb, arb, ctx

from ..errors import ParameterError
from ..verdict import Reason, Verdict
from .exact import Unproved

__all__ = ["Certificate", "Found", "by_frequency", "identical", "proven"]

SPARE = 30  # bits beyond the wanted digits: what panels and their product lose in nearly all random blades


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """What has been proven of the exact exponents.

    Attributes
    ----------
    exponents : tuple of complex
        Midpoints η.  One equation: [α+iρ, α-iρ], in a lock [σ₁+iρ, σ₂+iρ] with σ₁ ≥ σ₂, on the branch of the rotation
        number (where ``locked`` is None the second is given as in a lock, modulo 2πi/T).  Systems: principal branch
        modulo 2πi/T, by |Im| then falling Re.
    radii : tuple of float
        The exact exponents can be numbered such that |exact - η| ≤ radius, rounded outward.
    balls : tuple of (str, str)
        Real and imaginary part of each with all their digits, ``[midpoint +/- radius]``, which flint.arb reads.
    multiplicities : tuple of int
        How many exponents share the ball; each of them has an entry.
    discriminant, discriminant_radius : float
        D of the Hill form (identical blades: of one); nan for systems.
    locked : bool or None
        Sign of D; None where its ball holds 0 (on the edge of a lock, to ``bits`` bits) and for systems.
    verdict, reason : Verdict, Reason
        STABLE, UNSTABLE: proven.  UNDECIDED with NEUTRAL: proven that σ = 0 and that all solutions are bounded.
    bits : int
        Precision of the arithmetic.
    theorem : str
        What is proven, in a sentence.
    """

    exponents: tuple[complex, ...]
    radii: tuple[float, ...]
    balls: tuple[tuple[str, str], ...]
    multiplicities: tuple[int, ...]
    discriminant: float
    discriminant_radius: float
    locked: bool | None
    verdict: Verdict
    reason: Reason
    bits: int
    theorem: str


class Found(NamedTuple):
    """Enclosures at one precision: exponents, how many share each, their real parts at their sharpest, D."""

    exponents: list[acb]
    multiplicities: list[int]
    real: list[arb]
    D: arb
    locked: bool | None
    neutral: bool
    said: str

    @property
    def decided(self) -> bool:
        """Whether verdict and sign of D are."""
        return self.verdict[1] != Reason.BOUND and (self.locked is not None or self.D.is_nan())

    @property
    def verdict(self) -> tuple[Verdict, Reason]:
        """What the real parts prove."""
        if all(x < 0 for x in self.real):
            return Verdict.STABLE, Reason.NONE
        if any(x > 0 for x in self.real):
            return Verdict.UNSTABLE, Reason.NONE
        return Verdict.UNDECIDED, Reason.NEUTRAL if self.neutral else Reason.BOUND


def proven(attempt: Callable[[], Found], digits: int, limit: int, spare: int = SPARE) -> Certificate:
    """The certificate of the first precision that decides everything to ``digits``, at most ``limit`` bits."""
    if not 1 <= digits <= 10_000 or not 64 <= limit <= 100_000:
        raise ParameterError(
            "limit", limit, f"digits = {digits}, limit = {limit}: give 1 … 10000 digits and 64 … 100000 bits"
        )
    bits, best = max(64, math.ceil(digits / math.log10(2.0)) + spare), None
    while True:
        bits = min(bits, limit)
        with ctx.workprec(bits):
            try:
                found = attempt()
                best = _certificate(found, bits)
                if found.decided and all(_within(z, digits) for z in found.exponents):
                    return best
            except Unproved:
                pass
        if bits == limit:
            break
        bits *= 2
    if best is None:
        raise ParameterError(
            "limit", limit, f"{limit} bits do not resolve this system, which grows or decays by more: raise limit"
        )
    return best


def identical(blade: Certificate, blades: int) -> Certificate:
    """The certificate of identical blades in multiblade coordinates: those of one + ik, k = 0 … N-1, modulo Ni."""
    with ctx.workprec(blade.bits):
        one = [acb(arb(re), arb(im)) for re, im in blade.balls]
        values = [
            (_modulo(z + acb(0, k), blades), m)
            for z, m in zip(one, blade.multiplicities, strict=True)
            for k in range(blades)
        ]
        exponents, multiplicities = zip(*by_frequency(values), strict=True)
        rounded = [_rounded(z) for z in exponents]
        return replace(
            blade,
            exponents=tuple(z for z, _ in rounded),
            radii=tuple(radius for _, radius in rounded),
            balls=_printed(exponents, blade.bits),
            multiplicities=multiplicities,
            theorem=f"{blades} blades like one, for which {blade.theorem}",
        )


def by_frequency(values: Sequence[tuple[acb, int]]) -> list[tuple[acb, int]]:
    """By |Im| then falling Re, Im > 0 before its conjugate."""
    middles = [(float(z.real.mid()), float(z.imag.mid())) for z, _ in values]
    key = [(round(abs(im), 9), -round(re, 9), -im) for re, im in middles]
    return [values[i] for i in sorted(range(len(values)), key=lambda i: key[i])]


def _modulo(z: acb, turn: int) -> acb:
    """Im in (-turn/2, turn/2], of the midpoint."""
    return z - acb(0, turn * math.ceil(float(z.imag.mid()) / turn - 0.5))


def _printed(exponents: Sequence[acb], bits: int) -> tuple[tuple[str, str], ...]:
    """Balls with all their digits."""
    digits = math.ceil(bits * math.log10(2.0)) + 3
    return tuple((z.real.str(digits), z.imag.str(digits)) for z in exponents)


def _within(z: acb, digits: int) -> bool:
    smallest = arb(10) ** -digits
    return bool(z.real.rad() < smallest and z.imag.rad() < smallest)


def _certificate(found: Found, bits: int) -> Certificate:
    verdict, reason = found.verdict
    middles, radii = zip(*(_rounded(z) for z in found.exponents), strict=True)
    D, D_radius = _rounded_real(found.D)
    return Certificate(
        exponents=middles,
        radii=radii,
        balls=_printed(found.exponents, bits),
        multiplicities=tuple(found.multiplicities),
        discriminant=D,
        discriminant_radius=D_radius,
        locked=found.locked,
        verdict=verdict,
        reason=reason,
        bits=bits,
        theorem=f"{found.said}; {_sentence(found, verdict, reason)}",
    )


def _sentence(found: Found, verdict: Verdict, reason: Reason) -> str:
    largest = reduce(arb.max, found.real).str(6)
    if reason == Reason.NEUTRAL:
        return "both real parts are 0 and every solution is bounded: neither stable nor unstable"
    if verdict == Verdict.UNDECIDED:
        return f"the largest real part is in {largest}, which holds 0: undecided"
    return f"the largest real part is in {largest}: {verdict.name.lower()}"


def _rounded(z: acb) -> tuple[complex, float]:
    """Midpoint and radius of a disc of floats around a complex ball."""
    (a, _), (b, _) = _rounded_real(z.real), _rounded_real(z.imag)
    return complex(a, b), _up(abs(z - acb(a, b)).upper()) if z.is_finite() else math.inf


def _rounded_real(x: arb) -> tuple[float, float]:
    """Midpoint and radius as floats, outward."""
    if x.is_nan():
        return math.nan, math.nan
    middle = float(x.mid())
    if not (x.is_finite() and math.isfinite(middle)):
        return 0.0, math.inf
    return middle, _up((x - arb(middle)).abs_upper())


def _up(x: arb) -> float:
    """The least float that is not below an upper bound."""
    value = float(x)
    return value if arb(value) >= x else math.nextafter(value, math.inf)
