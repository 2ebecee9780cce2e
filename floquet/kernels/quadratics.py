"""Eigenvalues of ``q'' + D q' + K q = 0`` with constant D and K of two or three coordinates, for many points at once.

det(s² + D s + K) is a product of as many real quadratics as there are coordinates, a pair of eigenvalues each.  With
t = s - x, remainders modulo a quadratic t² - f t - e are numbers a + b t with t² = e + f t::

    (a + b t)(c + d t) = (ac + e bd) + (ad + bc + f bd) t

(e = -1, f = 0: complex numbers).  Calculated with such numbers the determinant of the matrix s² + D s + K is the
remainder r of the characteristic polynomial, of which no coefficient is ever formed, and where r = 0 the quadratic is a
factor.  Newton's method for all factors q_i at once is::

    q_i ← q_i + g_i,      g_i = r_i / Π_{j≠i} q_j  mod q_i

(A. A. Grau, The simultaneous Newton improvement of a complete set of approximate factors of a polynomial, SIAM J.
Numer. Anal. 8, 1971).  Pairs are conjugate or real by construction, and a pair that meets on the real axis and splits
is as smooth as any other: only pairs that meet one another are hard.  The factors start on a circle about the mean of
all eigenvalues, so that the result follows from D and K alone.

The last step sees each pair from where it is: x is the middle of a complex pair, or of two reals the one nearer to 0,
which keeps its own relative accuracy next to a large one.

Errors.  Let δ_i be g_i with what the rounding of r_i can do to it (eps times the permanent of the absolute values).
The characteristic polynomial is Π q_i (1 + Σ g_i/q_i), by Lagrange's interpolation at the roots of the factors, so each
of its roots has |q_i| ≤ n |δ_i| for one i.  As many roots are in discs that touch one another as there are discs, and
any of them may be anywhere in these: the bounds of such discs reach all over them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .primitives import select, somewhere, sqrt

__all__ = ["ANGLES", "ARITHMETIC", "by_lapack", "in_order", "roots"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
EPS = float(np.finfo(float).eps)
#: Angles on the circle where the pairs of two or three coordinates start, without a symmetry that Newton's method would
#: keep: of random rotors up to γ = 24 and μ = 1.5, 99 % arrive within 12 steps and 99.8 % within STEPS.
ANGLES = {2: (0.7, 2.0), 3: (0.5, 1.4, 2.4)}
COSINES = {n: tuple(math.cos(a) for a in angles) for n, angles in ANGLES.items()}
CIRCLE = 0.8  # radius over ½ max |D| + √ max |K|, as seen from the mean
STEPS = 18  # at most: what is not there by then started where Newton's method wanders
ARRIVED = 1e-8  # change over the scale: the next one, its square over the distance of two pairs, is rounding
ROUNDING = 1.0  # eps of the permanent: true errors of thousands of rotors reach a third of the bound
LOST = 1e-12  # n |δ| over the scale's square: has not arrived, or pairs meet, of which a matrix may know more
POINTS_AT_ONCE = 2032  # stay in L2; rows a power of two apart would share the sets of a cache

#: What is compiled for lanes as it stands.
ARITHMETIC = ("times", "over", "minor", "expanded", "diagonal", "beside", "remainder", "apart", "others",
              "correction", "seen", "started", "refined", "radius", "stated", "touching", "joined", "ordered",
              "solved")  # fmt: skip


# ---------------------------------------------------------------------- arithmetic modulo t² - f t - e
def times(a: Any, b: Any, c: Any, d: Any, e: Any, f: Any) -> Any:
    """(a + b t)(c + d t)."""
    bd = b * d
    return a * c + e * bd, a * d + b * c + f * bd


def over(a: Any, b: Any, c: Any, d: Any, e: Any, f: Any) -> Any:
    """(a + b t) / (c + d t), by the conjugate c + d f - d t."""
    conjugate = c + d * f
    norm = c * conjugate - d * d * e
    return (a * conjugate - b * d * e) / norm, (b * c - a * d) / norm


def minor(p: Any, q: Any, r: Any, s: Any, e: Any, f: Any, sign: float) -> Any:
    """p s + sign q r."""
    a, b = times(p[0], p[1], s[0], s[1], e, f)
    c, d = times(q[0], q[1], r[0], r[1], e, f)
    return a + sign * c, b + sign * d


def expanded(row: Any, m3: Any, m4: Any, m5: Any, m6: Any, m7: Any, m8: Any, e: Any, f: Any, sign: float) -> Any:
    """The determinant (sign -1) or the permanent (sign 1) of three rows, by the first."""
    a, b = minor(m4, m5, m7, m8, e, f, sign)
    u = times(row[0][0], row[0][1], a, b, e, f)
    a, b = minor(m3, m5, m6, m8, e, f, sign)
    v = times(row[1][0], row[1][1], a, b, e, f)
    a, b = minor(m3, m4, m6, m7, e, f, sign)
    w = times(row[2][0], row[2][1], a, b, e, f)
    return u[0] + sign * v[0] + w[0], u[1] + sign * v[1] + w[1]


# ---------------------------------------------------------------------- the matrix s² + D s + K at s = x + t
# D and K are (n², blocks): k an entry, b a block of points.  A sign of 1 asks for absolute values.
def diagonal(D: Any, K: Any, k: int, b: int, x: Any, e: Any, f: Any, sign: float) -> Any:
    """An entry with s²."""
    if sign > 0.0:
        return abs(K[k, b]) + abs(x) * (abs(D[k, b]) + abs(x)) + abs(e), abs(D[k, b]) + 2.0 * abs(x) + abs(f)
    return K[k, b] + x * (D[k, b] + x) + e, D[k, b] + 2.0 * x + f


def beside(D: Any, K: Any, k: int, b: int, x: Any, sign: float) -> Any:
    """An entry beside the diagonal."""
    if sign > 0.0:
        return abs(K[k, b]) + abs(x) * abs(D[k, b]), abs(D[k, b])
    return K[k, b] + x * D[k, b], D[k, b]


def remainder(D: Any, K: Any, b: int, n: int, x: Any, e: Any, f: Any, sign: float) -> Any:
    """r, the determinant (sign -1), or the permanent of absolute values (sign 1), for e and f as they are given."""
    if n == 2:
        p, s = diagonal(D, K, 0, b, x, e, f, sign), diagonal(D, K, 3, b, x, e, f, sign)
        return minor(p, beside(D, K, 1, b, x, sign), beside(D, K, 2, b, x, sign), s, e, f, sign)
    row = (diagonal(D, K, 0, b, x, e, f, sign), beside(D, K, 1, b, x, sign), beside(D, K, 2, b, x, sign))
    m3, m4, m5 = beside(D, K, 3, b, x, sign), diagonal(D, K, 4, b, x, e, f, sign), beside(D, K, 5, b, x, sign)
    m6, m7, m8 = beside(D, K, 6, b, x, sign), beside(D, K, 7, b, x, sign), diagonal(D, K, 8, b, x, e, f, sign)
    return expanded(row, m3, m4, m5, m6, m7, m8, e, f, sign)


# ---------------------------------------------------------------------- factors: q[i] = x, e, f of t² - f t - e
def apart(q: Any, j: int, x: Any, e: Any, f: Any) -> Any:
    """Factor j modulo t² - f t - e at x."""
    h = x - q[j, 0]
    return h * (h - q[j, 2]) + e - q[j, 1], 2.0 * h + f - q[j, 2]


def others(q: Any, i: int, n: int) -> Any:
    """The product of all other factors modulo factor i."""
    x, e, f = q[i, 0], q[i, 1], q[i, 2]
    c, d = apart(q, 1 if i == 0 else 0, x, e, f)
    if n == 3:
        third = apart(q, 1 if i == 2 else 2, x, e, f)
        c, d = times(c, d, third[0], third[1], e, f)
    return c, d


def correction(D: Any, K: Any, b: int, q: Any, i: int, n: int) -> Any:
    """g_i."""
    x, e, f = q[i, 0], q[i, 1], q[i, 2]
    r0, r1 = remainder(D, K, b, n, x, e, f, -1.0)
    c, d = others(q, i, n)
    return over(r0, r1, c, d, e, f)


def seen(q: Any, i: int) -> None:
    """Factor i from the middle of its complex pair, or from the one of its reals that is nearer to 0."""
    x, e, f = q[i, 0], q[i, 1], q[i, 2]
    half = 0.5 * f
    square = half * half + e
    real = square > 0.0
    spread = sqrt(abs(square))
    large = select(f < 0.0, half - spread, half + spread)
    small = (0.0 - e) / select(large == 0.0, 1.0, large)
    swap = abs(x + large) < abs(x + small)
    near, far = select(swap, large, small), select(swap, small, large)
    q[i, 0] = x + select(real, near, half)
    q[i, 1] = select(real, 0.0, square)
    q[i, 2] = select(real, far - near, 0.0)


# ---------------------------------------------------------------------- the solver
def started(D: Any, K: Any, b: int, q: Any, cosines: Any) -> Any:
    """Put the factors on a circle about the mean of all eigenvalues; its radius is the scale of the problem."""
    n = len(cosines)
    trace = D[0, b]
    for i in range(1, n):
        trace = trace + D[i * (n + 1), b]
    x = trace * (-0.5 / n)
    rates, springs = 0.0 * x, 0.0 * x
    for k in range(n * n):
        c, d = diagonal(D, K, k, b, x, 0.0 * x, 0.0 * x, -1.0) if k % (n + 1) == 0 else beside(D, K, k, b, x, -1.0)
        rates, springs = select(abs(d) > rates, abs(d), rates), select(abs(c) > springs, abs(c), springs)
    scale = 0.5 * rates + sqrt(springs)
    r = CIRCLE * scale
    for i in range(n):
        q[i, 0], q[i, 1], q[i, 2] = x, -1.0 * r * r, 2.0 * r * cosines[i]
    return scale


def refined(D: Any, K: Any, b: int, q: Any, scale: Any, n: int) -> None:
    """Newton's method until each point has arrived, and once more as seen from each pair."""
    active = scale == scale
    for _ in range(STEPS):
        change = 0.0 * scale
        for i in range(n):
            g0, g1 = correction(D, K, b, q, i, n)
            q[i, 1], q[i, 2] = select(active, q[i, 1] - g0, q[i, 1]), select(active, q[i, 2] - g1, q[i, 2])
            moved = abs(g0) + scale * abs(g1)
            change = select(moved > change, moved, change)
        active = active & (change > ARRIVED * scale * scale)
        if not somewhere(active):
            break
    for i in range(n):
        seen(q, i)
    for i in range(n):
        g0, g1 = correction(D, K, b, q, i, n)
        q[i, 1], q[i, 2] = q[i, 1] - g0, q[i, 2] - g1
        seen(q, i)


def radius(moved: Any, gap: Any) -> Any:
    """How far a root can be from where |q| is ``moved`` at most, its partner being ``gap`` away."""
    square = gap * gap - 4.0 * moved
    alone = square > 0.0
    root = sqrt(select(alone, square, gap * gap + 4.0 * moved))
    return select(alone, 2.0 * moved / select(alone, gap + root, 1.0), 0.5 * (gap + root))


def stated(D: Any, K: Any, b: int, q: Any, n: int, roots: Any, errors: Any) -> Any:
    """Roots of the factors (2n, real and imaginary part) and bounds of their errors (2n); gives the largest n |δ_i|."""
    largest = 0.0 * q[0, 0]
    for i in range(n):
        x, e, f = q[i, 0], q[i, 1], q[i, 2]
        real = e == 0.0
        height = sqrt(abs(e))
        gap = select(real, abs(f), 2.0 * height)
        g0, g1 = correction(D, K, b, q, i, n)
        p0, p1 = remainder(D, K, b, n, x, abs(e), abs(f), 1.0)
        c, d = others(q, i, n)
        complex_rest, complex_size = sqrt(abs(c * c - d * d * e)), sqrt(abs(g0 * g0 - g1 * g1 * e))
        rounding = ROUNDING * EPS * (p0 + p1 * select(real, abs(f), height))
        far = n * select(real, abs(g0 + g1 * f) + rounding / abs(c + d * f), complex_size + rounding / complex_rest)
        near = select(real, n * (abs(g0) + ROUNDING * EPS * p0 / abs(c)), far)
        roots[2 * i, 0, b], roots[2 * i, 1, b] = x, select(real, 0.0, 0.0 - height)
        roots[2 * i + 1, 0, b], roots[2 * i + 1, 1, b] = x + f, select(real, 0.0, height)
        errors[2 * i, b], errors[2 * i + 1, b] = radius(near, gap), radius(far, gap)
        largest = select(largest >= near, largest, near)
        largest = select(largest >= far, largest, far)
    return largest


def touching(roots: Any, errors: Any, b: int, i: int, j: int) -> Any:
    """1 where discs i and j touch, else 0."""
    x, y, reach = roots[i, 0, b] - roots[j, 0, b], roots[i, 1, b] - roots[j, 1, b], errors[i, b] + errors[j, b]
    return select(x * x + y * y <= reach * reach, 1.0, 0.0 * reach)


def joined(roots: Any, errors: Any, b: int, q: Any) -> None:
    """Bounds of discs that touch others reach all over those of their kind; ``q`` is used up."""
    count = errors.shape[0]
    for i in range(count):
        q[i // 2, i % 2] = 0.0 * errors[0, b]
    for i in range(count - 2):
        for j in range(i + 2 - i % 2, count):  # discs of one pair that touch are each all over both
            both = touching(roots, errors, b, i, j)
            q[i // 2, i % 2], q[j // 2, j % 2] = q[i // 2, i % 2] + both, q[j // 2, j % 2] + both
    total = 0.0 * errors[0, b]
    for i in range(count // 2):
        both, near = touching(roots, errors, b, 2 * i, 2 * i + 1), q[i, 0]
        q[i, 0], q[i, 1] = near + both * q[i, 1], q[i, 1] + both * near
    for i in range(count):
        total = total + select(q[i // 2, i % 2] > 0.0, errors[i, b], 0.0)
    if somewhere(total > 0.0):
        for i in range(count):
            errors[i, b] = select(q[i // 2, i % 2] > 0.0, 2.0 * total - errors[i, b], errors[i, b])


def ordered(roots: Any, errors: Any, b: int) -> None:
    """By |Im|, then Re, then Im: reals first, then pairs."""
    for i in range(errors.shape[0] - 1):
        for j in range(i + 1, errors.shape[0]):
            u, v, x, y = roots[i, 0, b], roots[i, 1, b], roots[j, 0, b], roots[j, 1, b]
            later = (abs(v) > abs(y)) | ((abs(v) == abs(y)) & ((u > x) | ((u == x) & (v > y))))
            for c in range(2):
                first, second = roots[i, c, b], roots[j, c, b]
                roots[i, c, b], roots[j, c, b] = select(later, second, first), select(later, first, second)
            p, q = errors[i, b], errors[j, b]
            errors[i, b], errors[j, b] = select(later, q, p), select(later, p, q)


def solved(D: Any, K: Any, b: int, q: Any, cosines: Any, roots: Any, errors: Any, doubt: Any) -> None:
    """A block of points: eigenvalues and bounds, in order, and the largest n |δ| over the scale's square."""
    scale = started(D, K, b, q, cosines)
    refined(D, K, b, q, scale, len(cosines))
    doubt[b] = stated(D, K, b, q, len(cosines), roots, errors) / (scale * scale)
    joined(roots, errors, b, q)
    ordered(roots, errors, b)


# ---------------------------------------------------------------------- many points
def roots(D: Array, K: Array) -> tuple[Complex, Array]:
    """Eigenvalues (2n, points), in order, and bounds of their errors, for D and K (n², points).

    The exact eigenvalues, each with one value for its own, are within the bounds.
    """
    from . import blocks

    points, n = D.shape[1], math.isqrt(len(D))
    values, errors, doubt = np.empty((2 * n, points), complex), np.empty((2 * n, points)), np.empty(points)
    for first in range(0, points, POINTS_AT_ONCE):
        some = slice(first, first + POINTS_AT_ONCE)
        z, errors[:, some], doubt[some] = blocks.solve(D[:, some], K[:, some], COSINES[n])
        values.real[:, some], values.imag[:, some] = z[:, 0], z[:, 1]
    lost = np.flatnonzero(~(doubt <= LOST))
    if lost.size:
        values[:, lost], errors[:, lost] = by_lapack(D[:, lost], K[:, lost])
    return values, errors


def by_lapack(D: Array, K: Array) -> tuple[Complex, Array]:
    """The same by LAPACK, from the matrix of the first-order system."""
    points, n = D.shape[1], math.isqrt(len(D))
    A = np.zeros((points, 2 * n, 2 * n))
    A[:, :n, n:] = np.eye(n)
    A[:, n:, :n], A[:, n:, n:] = (-m.T.reshape(points, n, n) for m in (K, D))
    values = in_order(np.linalg.eigvals(A).astype(complex)).T
    return values, bounds(D, K, values)


def bounds(D: Array, K: Array, values: Complex) -> Array:
    """Bounds of the errors of values (2n, points) that come in twos, conjugate or real."""
    n, points = len(values) // 2, D.shape[1]
    q, z, errors = np.empty((n, 3, points)), np.empty((2 * n, 2, 1, points)), np.empty((2 * n, 1, points))
    for i, (a, b) in enumerate(zip(values[0::2], values[1::2], strict=True)):
        real, swap = a.imag == 0.0, np.abs(b) < np.abs(a)
        near, far = np.where(swap, b.real, a.real), np.where(swap, a.real, b.real)
        q[i] = np.where(real, near, a.real), np.where(real, 0.0, -a.imag * a.imag), np.where(real, far - near, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # pairs that are the same to the last bit
        stated(D[:, None], K[:, None], 0, q, n, z, errors)
        joined(z, errors, 0, q)
    ordered(z, errors, 0)
    return np.where(np.isnan(errors[:, 0]), np.inf, errors[:, 0])


def in_order(values: Complex) -> Complex:
    """Values (..., k) by |Im|, then Re, then Im: reals first, then pairs."""
    order = np.lexsort((values.imag, values.real, np.abs(values.imag)), axis=-1)
    return np.take_along_axis(values, order, axis=-1)
