"""Floquet exponents to any number of digits: Taylor series of the solution, step by step, in multiple precision.

Scalar problems are y'' + d(t) y' + k(t) y = 0, general ones x' = A(t) x. Coefficients are polynomials in t, cos t and
sin t on pieces between kinks, given as functions of the three truncated power series of t, cos t and sin t about a
point (``Series``, which knows + − ×). The recurrence

    (n + 1)(n + 2) y_{n+2} = −Σ_j [ d_j (n + 1 − j) y_{n+1−j} + k_j y_{n−j} ]

is stepped over each piece in equal steps. With Φ the monodromy matrix over the period T, det Φ = e^{2αT},

    τ = tr Φ e^{−αT} / 2,   Δ = [ ((Φ₁₁ − Φ₂₂)/2)² + Φ₁₂ Φ₂₁ ] e^{−2αT}   ( = τ² − 1 )

Δ < 0 gives α ± iρ, Δ ≥ 0 a lock: α ± ln(|τ| + √Δ)/T + iρ. ρ is the rotation number: its remainder modulo 2π/T is in Φ
(the sign of Φ₁₂ tells ρ from −ρ), its integer part in the zeros of the solution that starts with y = 0, which turns by
2πρT/2π to within half a turn. There is at most one zero a step, because zeros are at least π/√max(q) apart, q the
coefficient of the Hill form. Numbers (floats, fractions, decimal strings) are taken as exact.

Nothing is estimated here: accuracy is shown by running twice with different steps and orders (see make_reference) and
by problems solved in closed form (see test_truth).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from mpmath import mp

Mpf: TypeAlias = Any
Mpc: TypeAlias = Any
Matrix: TypeAlias = Any
DIGITS = 50
"""Working precision; multipliers down to 1e-20 leave thirty digits."""
ORDER = 48
STEPS = 24
"""Steps per 2π: (|frequency| 2π/24)^48/48! is 1e-46 at a frequency of 10 per radian."""


class Series:
    """A truncated power series in t − t₀: the list of its coefficients."""

    __slots__ = ("c",)

    def __init__(self, coefficients: Sequence[Mpf]) -> None:
        self.c = list(coefficients)

    def __add__(self, other: Series | Mpf) -> Series:
        if isinstance(other, Series):
            return Series([a + b for a, b in zip(self.c, other.c, strict=True)])
        return Series([self.c[0] + other, *self.c[1:]])

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series([-a for a in self.c])

    def __sub__(self, other: Series | Mpf) -> Series:
        return self + (-other)

    def __rsub__(self, other: Mpf) -> Series:
        return -self + other

    def __mul__(self, other: Series | Mpf) -> Series:
        if isinstance(other, Series):
            return Series([mp.fdot(self.c[: n + 1], other.c[n::-1]) for n in range(len(self.c))])
        return Series([a * other for a in self.c])

    __rmul__ = __mul__

    def __truediv__(self, other: Mpf) -> Series:
        return Series([a / other for a in self.c])


Coefficient: TypeAlias = Callable[[Series, Series, Series], "Series | Mpf"]
"""(t, cos t, sin t) → the coefficient."""
MatrixCoefficient: TypeAlias = Callable[[Series, Series, Series], Sequence[Sequence["Series | Mpf"]]]


@dataclass(frozen=True)
class Piece:
    """y'' + damping y' + stiffness y = 0 for start ≤ t ≤ stop."""

    start: Mpf
    stop: Mpf
    damping: Coefficient
    stiffness: Coefficient


@dataclass(frozen=True)
class Exponents:
    """Of a scalar problem: the pair, ordered [α + iρ, α − iρ] or, in a lock, [σ₁ + iρ, σ₂ + iρ] with σ₁ ≥ σ₂."""

    exponents: tuple[Mpc, Mpc]
    rotation_number: Mpf
    locked: bool
    half_trace: Mpf
    discriminant: Mpf
    monodromy: tuple[Mpf, Mpf, Mpf, Mpf]
    period: Mpf

    @property
    def multipliers(self) -> tuple[Mpc, Mpc]:
        """e^{ηT}."""
        return tuple(mp.exp(eta * self.period) for eta in self.exponents)  # type: ignore[return-value]


def number(value: float | int | str | Fraction | Mpf) -> Mpf:
    """The exact value of a float, fraction or decimal string, to the working precision."""
    return mp.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mp.mpf(value)


def scalar_exponents(pieces: Sequence[Piece], *, order: int = ORDER, steps: int = STEPS) -> Exponents:
    """Exponents over the period from the first piece's start to the last one's stop, at the precision mp is set to."""
    columns = [[mp.mpf(1), mp.mpf(0)], [mp.mpf(0), mp.mpf(1)]]
    zeros = 0
    for piece in pieces:
        for t, h in _steps(piece.start, piece.stop, steps):
            variables = _variables(t, order)
            d, k = (_series(f(*variables), order).c for f in (piece.damping, piece.stiffness))
            before = columns[1][0]
            columns = [_scalar_step(d, k, y, h, order) for y in columns]
            after = columns[1][0]
            zeros += (before > 0) != (after > 0) if before else after < 0
    (a, c), (b, d) = columns
    return _close((a, b, c, d), zeros, pieces[-1].stop - pieces[0].start)


def monodromy(A: MatrixCoefficient, period: Mpf, *, order: int = ORDER, steps: int = STEPS) -> Matrix:
    """Φ(T) of x' = A(t) x from t = 0, by the recurrence (m + 1) x_{m+1} = Σ_j A_j x_{m−j}."""
    n = len(A(*_variables(mp.mpf(0), order)))
    columns = [[mp.mpf(i == j) for i in range(n)] for j in range(n)]
    for t, h in _steps(mp.mpf(0), period, steps):
        rows = [[_series(a, order).c for a in row] for row in A(*_variables(t, order))]
        columns = [_matrix_step(rows, x, h, order) for x in columns]
    return mp.matrix(columns).T


def matrix_exponents(A: MatrixCoefficient, period: Mpf, *, order: int = ORDER, steps: int = STEPS) -> list[Mpc]:
    """Principal exponents, imaginary parts in (−π/T, π/T], by decreasing real part then decreasing imaginary part."""
    multipliers = mp.eig(monodromy(A, period, order=order, steps=steps), left=False, right=False)
    return sorted((mp.log(mp.mpc(z)) / period for z in multipliers), key=lambda z: (-z.real, -z.imag))


def _steps(start: Mpf, stop: Mpf, per_turn: int) -> list[tuple[Mpf, Mpf]]:
    """(t, h) of equal steps no longer than 2π / per_turn."""
    count = max(1, int(mp.ceil((stop - start) * per_turn / (2 * mp.pi) - mp.mpf(10) ** -9)))
    h = (stop - start) / count
    return [(start + i * h, h) for i in range(count)]


def _variables(t: Mpf, order: int) -> tuple[Series, Series, Series]:
    """The series of t, cos t and sin t about t."""
    cosine, sine = mp.cos(t), mp.sin(t)
    cycle, factorial = (cosine, -sine, -cosine, sine), mp.mpf(1)
    derivatives = []
    for n in range(order + 1):
        factorial = factorial * n if n else factorial
        derivatives.append((cycle[n % 4] / factorial, cycle[(n + 3) % 4] / factorial))
    line = Series([t, mp.mpf(1), *[mp.mpf(0)] * (order - 1)])
    return line, Series([c for c, _ in derivatives]), Series([s for _, s in derivatives])


def _series(value: Series | Mpf, order: int) -> Series:
    return value if isinstance(value, Series) else Series([number(value), *[mp.mpf(0)] * order])


def _scalar_step(d: list[Mpf], k: list[Mpf], state: list[Mpf], h: Mpf, order: int) -> list[Mpf]:
    """(y, y') after a step h."""
    y, rate = [state[0], state[1]], [state[1]]
    for n in range(order - 1):
        acceleration = -mp.fdot(d[: n + 1], rate[n::-1]) - mp.fdot(k[: n + 1], y[n::-1])
        rate.append(acceleration / (n + 1))
        y.append(rate[-1] / (n + 2))
    return [mp.polyval(y[::-1], h), mp.polyval(rate[::-1], h)]


def _matrix_step(rows: list[list[list[Mpf]]], state: list[Mpf], h: Mpf, order: int) -> list[Mpf]:
    """x after a step h."""
    x = [[value] for value in state]
    for m in range(order):
        rates = [mp.fsum(mp.fdot(a[: m + 1], xj[m::-1]) for a, xj in zip(row, x, strict=True)) for row in rows]
        for xi, rate in zip(x, rates, strict=True):
            xi.append(rate / (m + 1))
    return [mp.polyval(xi[::-1], h) for xi in x]


def _close(phi: tuple[Mpf, Mpf, Mpf, Mpf], zeros: int, period: Mpf) -> Exponents:
    """Multipliers, branch and lock from Φ = [a b; c d] and the zeros of its second column in (0, T]."""
    a, b, c, d = phi
    growth = mp.log(a * d - b * c) / (2 * period)
    scale = mp.exp(-growth * period)
    tau = (a + d) / 2 * scale
    discriminant = (((a - d) / 2) ** 2 + b * c) * scale**2
    turns = (zeros + _half_turn(b, d)) / 2
    locked = discriminant >= 0
    if locked:
        spread = mp.log(abs(tau) + mp.sqrt(discriminant)) / period
        remainder = mp.mpf(0 if tau > 0 else 1) / 2
    else:
        angle = mp.atan2(mp.sign(b) * mp.sqrt(-discriminant), tau)
        remainder = (angle / (2 * mp.pi)) % 1
    rho = 2 * mp.pi / period * (remainder + mp.nint(turns - remainder))
    pair = (
        (mp.mpc(growth + spread, rho), mp.mpc(growth - spread, rho))
        if locked
        else (mp.mpc(growth, rho), mp.mpc(growth, -rho))
    )
    return Exponents(pair, rho, bool(locked), tau, discriminant, phi, period)


def _half_turn(y: Mpf, rate: Mpf) -> Mpf:
    """Clockwise angle of (y, y') from the last crossing of y = 0, in half turns, 0 ≤ … < 1."""
    return (mp.atan2(y, rate) / mp.pi) % 1
