"""From one blade to the rotor, derived symbolically: eqs. (2)–(8) and tables 1–3 of NASA TP-1431.

A blade's equation by its harmonics, ``β'' + d β' + k β = f``, primes d/dψ::

    d = c0 + cs1 sin ψ        k = k0 + kc1 cos ψ + ks1 sin ψ + kc2 cos 2ψ + ks2 sin 2ψ
    f = f0 + Σ (fcn cos nψ + fsn sin nψ), n ≤ 3

Teetering rotor: half the difference of the moments of two blades with ψ₂ = ψ₁ + π and β₁,₂ = a₀ ± β.
Multiblade: β_i = T q, ``T q'' + (2T' + A T) q' + (T'' + A T' + B T) q = f_R`` with A = diag d(ψ_i), B = diag k(ψ_i).
Tip-path plane: β = a₀ − a₁ cos ψ − b₁ sin ψ with a(ψ) is put into the equation, and of what results the constant, the
cosine and the sine are kept (harmonic balance).
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import NamedTuple

import sympy as sp

from tests.derivation import blade
from tests.derivation.blade import psi, trigonometric

__all__ = [
    "COEFFICIENTS", "FORCING", "System", "Teetering", "at_blades", "balanced", "blade_coefficients", "blade_forcing",
    "by_harmonics", "fourier", "inverse", "multiblade", "teetering", "teetering_plane", "tip_path_plane",
    "transformation",
]  # fmt: skip

COEFFICIENTS = sp.symbols("c0 cs1 k0 kc1 ks1 kc2 ks2", real=True)
FORCING = sp.symbols("f0 fc1 fs1 fc2 fs2 fc3 fs3", real=True)
a_0 = sp.Symbol("a_0", real=True)


class System(NamedTuple):
    """``q'' + D q' + K q = F``, F with a column for each input."""

    D: sp.Matrix
    K: sp.Matrix
    F: sp.Matrix


class Teetering(NamedTuple):
    """``β'' + d β' + k β = f u + precone a₀``."""

    d: sp.Expr
    k: sp.Expr
    f: sp.Matrix
    precone: sp.Expr


# ---------------------------------------------------------------------------------------------- harmonics
def fourier(expression: sp.Expr, order: int = 3) -> dict[str, sp.Expr]:
    """Coefficients "0", "c1", "s1", … of the constant, cos ψ, sin ψ, …"""
    z = sp.Symbol("z")
    series = sp.expand(trigonometric(expression).subs(sp.exp(sp.I * psi), z))
    found = {"0": series.coeff(z, 0)}
    for n in range(1, order + 1):
        plus, minus = series.coeff(z, n), series.coeff(z, -n)
        found |= {f"c{n}": sp.expand(plus + minus), f"s{n}": sp.expand(sp.I * (plus - minus))}
    return found


def by_harmonics() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """d, k and f of a blade by :data:`COEFFICIENTS` and :data:`FORCING`."""
    c0, cs1, k0, kc1, ks1, kc2, ks2 = COEFFICIENTS
    f0, fc1, fs1, fc2, fs2, fc3, fs3 = FORCING
    d = c0 + cs1 * sp.sin(psi)
    k = k0 + kc1 * sp.cos(psi) + ks1 * sp.sin(psi) + kc2 * sp.cos(2 * psi) + ks2 * sp.sin(2 * psi)
    f = f0 + fc1 * sp.cos(psi) + fs1 * sp.sin(psi) + fc2 * sp.cos(2 * psi) + fs2 * sp.sin(2 * psi)
    return d, k, f + fc3 * sp.cos(3 * psi) + fs3 * sp.sin(3 * psi)


@functools.cache
def blade_coefficients(*, exact: bool) -> dict[sp.Symbol, sp.Expr]:
    """:data:`COEFFICIENTS` in the parameters of the blade."""
    d, k = fourier(blade.damping(exact=exact)), fourier(blade.stiffness(exact=exact))
    return dict(zip(COEFFICIENTS, (d["0"], d["s1"], k["0"], k["c1"], k["s1"], k["c2"], k["s2"]), strict=True))


@functools.cache
def blade_forcing(*, exact: bool, kinematic: bool) -> dict[sp.Symbol, list[sp.Expr]]:
    """:data:`FORCING`, each a row with a column for each input, in the parameters of the blade."""
    columns = [fourier(f) for f in blade.forcing(exact=exact, kinematic=kinematic)]
    return {name: [column[name.name[1:]] for column in columns] for name in FORCING}


# ---------------------------------------------------------------------------------------------- teetering, eq. (2)
@functools.cache
def teetering() -> Teetering:
    """Eq. (2): the two blades' moments on one beam, without hinge offset; nothing is cut in ε."""
    beta, rate = sp.symbols("beta rate")
    centred = {blade.eps: 0, blade.m: 0}
    d, k = (function(exact=True).subs(centred) for function in (blade.damping, blade.stiffness))
    f = blade.forcing(exact=True, kinematic=True).subs(centred)

    def opposite(coefficient: sp.Expr) -> sp.Expr:
        return sp.expand_trig(coefficient.subs(psi, psi + sp.pi))

    left = d * rate + k * (a_0 + beta) - (opposite(d) * -rate + opposite(k) * (a_0 - beta))
    left = sp.expand(left / 2)
    right = ((f - f.applyfunc(opposite)) / 2).expand()
    return Teetering(left.coeff(rate), left.coeff(beta), right, -left.coeff(a_0))


# ---------------------------------------------------------------------------------------------- multiblade, (B2)–(B5)
def at_blades(coefficient: sp.Expr, blades: int) -> list[sp.Expr]:
    """A coefficient at ψ_i = ψ + 2π(i − 1)/N of every blade."""
    return [sp.expand_trig(coefficient.subs(psi, psi + 2 * sp.pi * i / blades)) for i in range(blades)]


@functools.cache
def transformation(blades: int) -> sp.ImmutableMatrix:
    """T of β_i = β₀ + Σ_n (β_nc cos nψ_i + β_ns sin nψ_i) [+ β_d (−1)^i], eq. (B2)."""
    cyclic = [g(n * psi) for n in range(1, (blades - 1) // 2 + 1) for g in (sp.cos, sp.sin)]
    columns = [[sp.S.One] * blades, *(at_blades(g, blades) for g in cyclic)]
    if blades % 2 == 0:
        columns.append([sp.Integer(-1) ** i for i in range(1, blades + 1)])
    return sp.ImmutableMatrix(columns).T


@functools.cache
def inverse(blades: int) -> sp.ImmutableMatrix:
    """T⁻¹ of β₀ = Σ β_i/N, β_nc = 2 Σ β_i cos nψ_i/N, β_ns = 2 Σ β_i sin nψ_i/N, β_d = Σ β_i (−1)^i/N, eq. (B2)."""
    rows = transformation(blades).T
    cyclic = range(1, 2 * ((blades - 1) // 2) + 1)
    return sp.ImmutableMatrix([(2 if i in cyclic else 1) * rows.row(i) / blades for i in range(blades)])


@functools.cache
def multiblade(blades: int) -> System:
    """Eq. (B5) by the blade's harmonics: ``D = T⁻¹(2T' + A T)``, ``K = T⁻¹(T'' + A T' + B T)``, ``F = T⁻¹ f_R``."""
    d, k, f = by_harmonics()
    A, B = (sp.diag(*at_blades(c, blades)) for c in (d, k))
    T, T_inverse = transformation(blades), inverse(blades)
    D = T_inverse * (2 * T.diff(psi) + A * T)
    K = T_inverse * (T.diff(psi, 2) + A * T.diff(psi) + B * T)
    F = T_inverse * sp.Matrix(at_blades(f, blades))
    return System(*(matrix.applyfunc(trigonometric) for matrix in (D, K, F)))


# ---------------------------------------------------------------------------------------------- tip-path plane, (5)–(8)
def balanced(shape: dict[str, sp.Expr], d: sp.Expr, k: sp.Expr, f: Sequence[sp.Expr]) -> System:
    """β = Σ shape_j a_j(ψ) put into β'' + d β' + k β = f, and the harmonics named in ``shape`` kept."""
    n = len(shape)
    a, a_dot, a_ddot = (sp.symbols(f"{name}:{n}") for name in ("a", "adot", "addot"))
    motion = {psi: 1, **dict(zip(a, a_dot, strict=True)), **dict(zip(a_dot, a_ddot, strict=True))}

    def rate(y: sp.Expr) -> sp.Expr:
        return sum(y.diff(v) * v_dot for v, v_dot in motion.items())

    def kept(y: sp.Expr) -> list[sp.Expr]:
        """In the scale that leaves a_j'' with the factor 1."""
        have = fourier(y)
        return [sp.expand(have[name] / fourier(term)[name]) for name, term in shape.items()]

    beta = sum(term * a_j for term, a_j in zip(shape.values(), a, strict=True))
    left = sp.Matrix(kept(rate(rate(beta)) + d * rate(beta) + k * beta))
    assert left.jacobian(a_ddot) == sp.eye(n)
    return System(left.jacobian(a_dot), left.jacobian(a), sp.Matrix([kept(column) for column in f]).T)


@functools.cache
def tip_path_plane() -> System:
    """Table 3 by the blade's harmonics, (a₀, a₁, b₁)."""
    d, k, f = by_harmonics()
    return balanced({"0": sp.S.One, "c1": -sp.cos(psi), "s1": -sp.sin(psi)}, d, k, [f])


@functools.cache
def teetering_plane() -> System:
    """Eq. (7), (a₁, b₁); the last column of F is what a precone a₀ = 1 adds."""
    d, k, f, precone = teetering()
    return balanced({"c1": -sp.cos(psi), "s1": -sp.sin(psi)}, d, k, [*f, precone])
