"""Systems of states, ``x' = A(t) x``: the exponents modulo 2πi/T, enclosed.

The map of one period is the product of its panels' maps, X(1) X(-1)⁻¹ with the series of :mod:`.series` about each
centre; its eigenvalues Λ are enclosed by :mod:`.discs`, and η = log(Λ)/T.  Multipliers that are many decades apart
need as many digits more, which the precision supplies.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import mul
from typing import Any, TypeAlias

from flint import acb, arb, arb_mat, ctx

from .discs import enclosed_eigenvalues
from .exact import Clock, Edge, Exact, Matrix, Unproved, ball, matrix, pieces, signs
from .result import SPARE, Certificate, Found, by_frequency, proven
from .series import LONGEST, Weights, last, panels, plus_minus, tail, weights

__all__ = ["certified_constant", "certified_system", "companion"]

Blocks: TypeAlias = list[arb_mat]
STATE = 6  # more bits a state, for the characteristic polynomial


def certified_system(
    A: Sequence[Any],
    period: float | Fraction,
    *,
    base: float | Fraction | None = None,
    edges: Sequence[Edge] = (),
    twist: Sequence[int] | None = None,
    digits: int = 20,
    limit: int = 512,
) -> Certificate:
    """The exponents of ``x' = A(t) x`` modulo 2πi/T, proven; clusters that cannot be told apart share a ball.

    Parameters
    ----------
    A : sequence of (n, n) matrices of exact numbers
        [mean, cos, sin, cos 2, sin 2, …] of the angle ωt, ω = 2π/base; with ``edges``, one such sequence a piece.
        For ``q'' + D q' + K q = 0`` see :func:`companion`.
    twist : (n,) of ±1, optional
        S with A(t + T) = S A(t) S: the exponents are those of S·Φ(T).
    period, base, edges, digits, limit
        As in :func:`~floquet.certify.certified_hill`.
    """
    clock = Clock.of(period, base)
    parts = [matrix(part) for (part,) in pieces((A,), edges, ("A",))]
    n = len(parts[0][0])
    diagonal = signs(twist, n)
    if len(parts) == 1:
        places = [(i, j, diagonal[i] * diagonal[j]) for i in range(n) for j in range(n)]
        clock.check([((m + 1) // 2, sign) for m, part in enumerate(parts[0]) for i, j, sign in places if part[i][j]])
    return proven(lambda: _enclosed(parts, edges, clock, diagonal), digits, limit, SPARE + STATE * n)


def certified_constant(A: Sequence[Sequence[Exact]], *, digits: int = 20, limit: int = 512) -> Certificate:
    """The exponents of ``x' = A x`` with a constant A (n, n) of exact numbers: its eigenvalues, proven."""
    (part,) = matrix([A])
    return proven(
        lambda: _found(enclosed_eigenvalues(_balls(part)), "exponents"), digits, limit, SPARE + STATE * len(part)
    )


def companion(D: Sequence[Any], K: Sequence[Any]) -> list[Matrix]:
    """``q'' + D q' + K q = 0`` as ``x' = A x``, x = (q, q'): D, K and A as [mean, cos, sin, …] of matrices."""
    n, out = len(K[0]), list[Matrix]()
    nothing: Matrix = [[0] * n] * n
    for i in range(max(len(D), len(K))):
        one: Matrix = [[int(i == 0 and row == column) for column in range(n)] for row in range(n)]
        A = [zeros + row for zeros, row in zip(nothing, one, strict=True)]
        blocks = (part[i] if i < len(part) else nothing for part in (K, D))
        A += [[-x for row in rows for x in row] for rows in zip(*blocks, strict=True)]
        out.append(A)
    return out


def _enclosed(parts: Sequence[list[Matrix]], edges: Sequence[Edge], clock: Clock, diagonal: Sequence[int]) -> Found:
    """Enclosures from the coefficient matrices of each piece."""
    factors: Blocks = []
    for ends, part in zip(pairwise(clock.angles(edges)), parts, strict=True):
        factors += _factors([_balls(m) for m in part], *ends, clock.omega)
    n = len(diagonal)
    twist = arb_mat([[sign * int(i == j) for j in range(n)] for i, sign in enumerate(diagonal)])
    phi = reduce(lambda product, factor: factor * product, [*factors, twist])
    return _found([(_log(z) / clock.T, m) for z, m in enclosed_eigenvalues(phi)], "multipliers")


def _found(values: list[tuple[acb, int]], of: str) -> Found:
    """Each value as often as it counts."""
    exponents = [z for z, m in by_frequency(values) for _ in range(m)]
    counts = [m for _, m in by_frequency(values) for _ in range(m)]
    said = f"{len(exponents)} {of} are in {len(values)} disjoint discs"
    return Found(exponents, counts, [z.real for z in exponents], arb.nan(), None, False, said)


def _log(z: acb) -> acb:
    """Principal logarithm, from across the negative axis on the side of +π."""
    if abs(z).contains(0):
        raise Unproved
    return (-z).log() + acb(0, arb.pi()) if z.real < 0 and z.imag.contains(0) else z.log()


# ---------------------------------------------------------------------- panels
def _factors(A: Blocks, start: arb, stop: arb, omega: arb) -> Iterator[arb_mat]:
    """The maps of a piece's panels."""
    sizes = [_norm(C) + _norm(S) for C, S in zip(A[1::2], A[2::2], strict=True)]
    mean, span, n = _norm(A[0]), stop - start, A[0].nrows()
    rate = sum(sizes, mean) / omega
    count = panels(span, rate, len(sizes))
    half = span / (2 * count)
    table = weights(mean, sizes, half, half / omega)
    one = arb_mat([[int(i == j) for j in range(n)] for i in range(n)])
    for i in range(count):
        X = _series(_taylor(A, table, start + (2 * i + 1) * half), one)
        spread = plus_minus(tail(map(_norm, X), table.tails, 1) * (rate * half).exp())
        even = reduce(operator.add, X[::2], arb_mat(n, n, [spread] * n**2))
        odd = reduce(operator.add, X[1::2])
        try:
            yield (even + odd) * (even - odd).inv()
        except ZeroDivisionError:
            raise Unproved from None


def _taylor(A: Blocks, table: Weights, centre: arb) -> Blocks:
    """f_j = h/ω A_j of A(centre + h x), j < J."""
    f = [A[0] * table.factor] + [0 * A[0]] * (len(table.tails) - 2)
    for m, (C, S, row) in enumerate(zip(A[1::2], A[2::2], table.rows, strict=True), 1):
        sine, cosine = (m * centre).sin_cos()
        even, odd = C * cosine + S * sine, S * cosine - C * sine
        cycle = [even, odd, -even, -odd] * (len(row) // 4 + 1)
        f = [total + part * weight for total, part, weight in zip(f, cycle, row, strict=False)]
    return f


def _series(f: Blocks, one: arb_mat) -> Blocks:
    """X_n of X' = f X, X(0) = 1."""
    smallest, X = last(), [one]
    for n in range(LONGEST * ctx.prec):
        X.append(reduce(operator.add, map(mul, f, X[n::-1])) / (n + 1))
        if n > 0 and _norm(X[-1].mid()) <= smallest and _norm(X[-2].mid()) <= smallest:
            return X
    raise Unproved


def _norm(M: arb_mat) -> arb:
    """Largest sum of a row's sizes."""
    n = M.ncols()
    sizes = [abs(x) for x in M.entries()]
    return reduce(arb.max, (sum(sizes[i : i + n], arb(0)) for i in range(0, len(sizes), n)))


def _balls(values: Matrix) -> arb_mat:
    return arb_mat([[ball(x) for x in row] for row in values])
