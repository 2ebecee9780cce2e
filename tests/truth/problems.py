"""Equations with known or computed exponents, as the pieces and matrices that ``taylor`` integrates.

Parameters are floats, fractions or decimal strings, all taken as exact. The flapping equation's coefficients come from
``closed_forms``, which ``test_truth`` holds against quadrature.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from mpmath import mp

from tests.truth import closed_forms
from tests.truth.taylor import Coefficient, Matrix, MatrixCoefficient, Mpf, Piece, Series, number

Parameter = Any
"""float, int, str or Fraction."""


def trigonometric(c: closed_forms.Coefficients, flap_damping: Mpf, period: Mpf) -> list[Piece]:
    """c0 + cs1 sin ψ and k0 + kc1 cos ψ + ks1 sin ψ + kc2 cos 2ψ + ks2 sin 2ψ on one piece."""

    def damping(t: Series, cosine: Series, sine: Series) -> Series:
        return c["cs1"] * sine + (c["c0"] + flap_damping)

    def stiffness(t: Series, cosine: Series, sine: Series) -> Series:
        first = c["kc1"] * cosine + c["ks1"] * sine
        return first + c["kc2"] * (cosine * cosine - sine * sine) + 2 * c["ks2"] * (sine * cosine) + c["k0"]

    return [Piece(mp.mpf(0), period, damping, stiffness)]


def flapping(
    gamma: Parameter,
    mu: Parameter = 0,
    *,
    eps: Parameter = 0,
    kappa: Parameter = 0,
    K1: Parameter = 0,
    m: Parameter | None = None,
    flap_damping: Parameter = 0,
    exact_offset: bool = False,
    reversed_flow: bool = False,
) -> list[Piece]:
    """One flapping blade; m is 1.5 ε unless given. Reversed flow is exact in ε whatever exact_offset says."""
    gamma, mu, eps, kappa, K1, flap_damping = (number(x) for x in (gamma, mu, eps, kappa, K1, flap_damping))
    m = 3 * eps / 2 if m is None else number(m)
    if reversed_flow:
        return _reversed_pieces(gamma, mu, eps, K1, 1 + kappa + m, flap_damping)
    make = closed_forms.exact if exact_offset else closed_forms.truncated
    return trigonometric(make(gamma, eps, kappa, K1, mu, m), flap_damping, 2 * mp.pi)


def teetering(gamma: Parameter, mu: Parameter = 0, *, kappa: Parameter = 0, K1: Parameter = 0) -> list[Piece]:
    """Eq. (2), period π."""
    gamma, mu, kappa, K1 = (number(x) for x in (gamma, mu, kappa, K1))
    return trigonometric(closed_forms.teetering(gamma, kappa, K1, mu), mp.mpf(0), mp.pi)


def mathieu(a: Parameter, q: Parameter, damping: Parameter = 0) -> list[Piece]:
    """y'' + damping y' + (a − 2q cos 2t) y = 0, period π."""
    a, q, damping = number(a), number(q), number(damping)
    return [Piece(mp.mpf(0), mp.pi, lambda t, c, s: damping, lambda t, c, s: a - 2 * q * (c * c - s * s))]


def meissner(mean: Parameter, depth: Parameter, damping: Parameter, switch: Mpf, period: Mpf) -> list[Piece]:
    """y'' + damping y' + (mean − depth ψ) y = 0, ψ = +1 for t < switch, −1 up to the period."""
    mean, depth, damping = number(mean), number(depth), number(damping)

    def constant(value: Mpf) -> Coefficient:
        return lambda t, c, s: value

    first = Piece(mp.mpf(0), switch, constant(damping), constant(mean - depth))
    return [first, Piece(switch, period, constant(damping), constant(mean + depth))]


def hill_sawtooth(mean: Parameter, depth: Parameter, damping: Parameter) -> list[Piece]:
    """y'' + damping y' + (mean − depth ψ) y = 0, ψ = 1 − 2t/π, period π."""
    mean, depth, damping = number(mean), number(depth), number(damping)
    return [Piece(mp.mpf(0), mp.pi, lambda t, c, s: damping, lambda t, c, s: mean - depth * (1 - 2 * t / mp.pi))]


def colaneri(t: Series, c: Series, s: Series) -> Sequence[Sequence[Any]]:
    """[0 1; −10 cos t, −24 − 10 sin t]: exponents 0 and −24 over 2π."""
    return [[0, 1], [-10 * c, -24 - 10 * s]]


def zhou_hagiwara(t: Series, c: Series, s: Series) -> Sequence[Sequence[Any]]:
    """[−1 − sin²2t, 2 − ½ sin 4t; −2 − ½ sin 4t, −1 − cos²2t].

    Exponents −1 and −2 over the period π, −1 + 2i and −2 + 2i over π/2.
    """
    sin2, cos2 = 2 * s * c, c * c - s * s
    half_sin4 = sin2 * cos2
    return [[-1 - sin2 * sin2, 2 - half_sin4], [-2 - half_sin4, -1 - cos2 * cos2]]


def bittanti_colaneri(t: Series, c: Series, s: Series) -> Sequence[Sequence[Any]]:
    """[−1 + sin t, 0; 1 − cos t, −3]: exponents −1 and −3 over 2π."""
    return [[-1 + s, 0], [1 - c, -3]]


def rotating_frame(F: Sequence[Sequence[Parameter]], turns: Sequence[int]) -> MatrixCoefficient:
    """A(t) = J + e^{Jt} F e^{−Jt}: Φ(2π) = expm(2πF) exactly. J has a block [0, w; −w, 0] for every w of ``turns``."""
    size = 2 * len(turns)
    if any(abs(w) > 2 for w in turns):
        raise ValueError("turns are -2 ... 2: only cos t, sin t, cos 2t and sin 2t are formed")

    def A(t: Series, c: Series, s: Series) -> Sequence[Sequence[Any]]:
        waves = {0: (1, 0 * s), 1: (c, s), 2: (c * c - s * s, 2 * s * c)}
        G: Any = [[Series([mp.mpf(0)] * len(t.c)) for _ in range(size)] for _ in range(size)]
        rotation: Any = [[0] * size for _ in range(size)]
        for i, w in enumerate(turns):
            cosine, sine = waves[abs(w)][0], waves[abs(w)][1] * (1 if w >= 0 else -1)
            rotation[2 * i][2 * i : 2 * i + 2] = [cosine, sine]
            rotation[2 * i + 1][2 * i : 2 * i + 2] = [-sine, cosine]
            G[2 * i][2 * i + 1] = G[2 * i][2 * i + 1] + w
            G[2 * i + 1][2 * i] = G[2 * i + 1][2 * i] - w
        near = [(i, k) for i in range(size) for k in (i - i % 2, i - i % 2 + 1)]
        for i, k in near:
            for j, n in near:
                G[i][j] = G[i][j] + rotation[i][k] * rotation[j][n] * number(F[k][n])
        return G

    return A


def eigenvalues(F: Sequence[Sequence[Parameter]]) -> list[Any]:
    """Of a constant matrix, by decreasing real part then decreasing imaginary part."""
    matrix: Matrix = mp.matrix([[number(x) for x in row] for row in F])
    return sorted((mp.mpc(z) for z in mp.eig(matrix, left=False, right=False)), key=lambda z: (-z.real, -z.imag))


def _reversed_pieces(gamma: Mpf, mu: Mpf, eps: Mpf, K1: Mpf, structure: Mpf, flap_damping: Mpf) -> list[Piece]:
    """Kinks where μ sin ψ = −ε and −1; between them trigonometric polynomials of degree 4."""
    ratios = [r for r in ((eps / mu, 1 / mu) if mu > 0 else ()) if r < 1]
    cuts = sorted({x for r in ratios for x in (mp.pi + mp.asin(r), 2 * mp.pi - mp.asin(r))} - {2 * mp.pi})
    ends = [mp.mpf(0), *cuts, 2 * mp.pi]
    return [_reversed_piece(a, b, gamma, mu, eps, K1, structure, flap_damping) for a, b in pairwise(ends)]


def _reversed_piece(
    start: Mpf, stop: Mpf, gamma: Mpf, mu: Mpf, eps: Mpf, K1: Mpf, structure: Mpf, flap_damping: Mpf
) -> Piece:
    u = mu * mp.sin((start + stop) / 2)
    region = 0 if u >= -eps else 1 if u > -1 else 2

    def damping(t: Series, c: Series, s: Series) -> Series:
        return closed_forms.reversed_flow(gamma, eps, K1, mu, s, region)[0] + flap_damping

    def stiffness(t: Series, c: Series, s: Series) -> Series:
        _, spring, coupling = closed_forms.reversed_flow(gamma, eps, K1, mu, s, region)
        return spring * c + coupling + structure

    return Piece(start, stop, damping, stiffness)
