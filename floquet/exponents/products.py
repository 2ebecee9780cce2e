"""Eigenvalues of products of matrices that are known to an error each, with bounds.

Let B = E·F_K…F_1 and X⁻¹ B X = Λ, x_j the columns of X and y_i the rows of X⁻¹.  Errors of the factors, not more than
e_k in the 2-norm, change the entries of X⁻¹ B X by no more than::

    G_ij = Σ_k |y_i E F_K…F_{k+1}| e_k |F_{k-1}…F_1 x_j|

to which the rounding of the product and |y_i| |B x_j - λ_j x_j| are added.  By Gershgorin's theorem the eigenvalues lie
in discs about λ_i of radius ϱ_i = Σ_j G_ij, as many in a connected set of discs as it has discs (J. H. Wilkinson, The
Algebraic Eigenvalue Problem, ch. 2).  With the i-th vector longer by t, disc i has the radius G_ii + (ϱ_i - G_ii)/t and
others have ϱ_j + t G_ji at most: where it then meets none of them, that is the bound.  Elsner's theorem caps what
defective eigenvalues can do.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels import worth_compiling
from .clusters import cluster_bounds
from .result import EPS, Array

__all__ = ["eigenvalues", "multipliers", "multipliers_of_lanes", "poor", "size_of"]

Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]
BACKWARD = 16.0  # eps of |B|: what LAPACK's QR steps do; seen are 10, in 10 000 matrices
SHARE = 0.1  # of G_ii: what the other entries of its row add to the bound
AT_ONCE = 512  # factors between a half and one that are multiplied: their product is a normal number
POOR = 1e-8  # of an eigenvalue: bounds above are those of eigenvalues too close for discs


def eigenvalues(matrices: Array, error: Array) -> tuple[Complex, Array]:
    """Eigenvalues (cases, n) of matrices (cases, n, n), each known to an error in the 2-norm, with bounds.

    Conjugate pairs stand side by side, the one with Im > 0 first.  Both are nan and inf for what is not finite.
    """
    count, n, _ = matrices.shape
    if n == 1 or not worth_compiling(count * n // 2):
        return _with_scale(*multipliers(np.eye(n)[None], matrices[:, None], error[:, None]))
    from ..kernels.lanes import WIDTH, aligned  # loads numba

    places = np.minimum(np.arange(-(-count // WIDTH) * WIDTH), count - 1)
    maps = aligned((len(places) // WIDTH, 1, n, n, WIDTH))
    maps[:, 0] = np.moveaxis(matrices[places].reshape(-1, WIDTH, n, n), 1, -1)
    found, clear = multipliers_of_lanes(np.ones(n), maps, error[places].reshape(-1, 1, WIDTH), count)
    values, radius = _with_scale(*found)
    rest = np.flatnonzero(~clear)
    alone = multipliers(np.eye(n)[None], matrices[rest, None], error[rest, None])
    values[rest], radius[rest] = _with_scale(*alone)
    return values, radius


def multipliers_of_lanes(
    twist: Array, maps: Array, errors: Array, count: int
) -> tuple[tuple[Complex, Array, Array], Flags]:
    """As :func:`multipliers` for the first ``count`` cases of blocks, and which of them have all eigenvalues clear."""
    from ..kernels.products import multipliers as kernel  # loads numba

    blocks, _, n, _, lanes = maps.shape
    out, radius, exponents = np.empty((blocks, lanes, n, 2)), np.empty((blocks, lanes, n)), np.empty((blocks, lanes))
    kernel(maps, errors, twist, noise(n), SHARE, out, radius, exponents)
    values: Complex = out.reshape(-1, n, 2)[:count].view(complex)[..., 0]
    radius = radius.reshape(-1, n)[:count]
    clear = np.asarray(np.isfinite(radius).all(axis=-1))
    return (values, radius, exponents.reshape(-1)[:count] * math.log(2.0)), clear


def multipliers(
    left: Array, maps: Array, errors: Array, *, closely: bool = True, within: float = math.inf
) -> tuple[Complex, Array, Array]:
    """Eigenvalues·exp(-scale) (cases, n) of left·F_K…F_1, their bounds, and scale (cases,).

    ``left``, E, is (cases or 1, n, n), maps are (cases, K, n, n), errors (cases, K).  ``closely``: where discs join and
    say little look at clusters of eigenvalues, case by case.  ``within``: where logarithms of all cases' eigenvalues
    differ by more there are no bounds.
    """
    if maps.shape[-1] == 1:
        return _numbers(left, maps, errors)
    maps, errors, exponent = _scaled(maps, errors)
    cases, panels, n, _ = maps.shape
    before = [np.broadcast_to(np.eye(n), (cases, n, n))]
    for k in range(panels):
        before.append(maps[:, k] @ before[k])
    B = left @ before[-1]
    values, X, Y = _vectors(B)
    with np.errstate(divide="ignore", invalid="ignore"):
        if np.all(np.ptp(np.log(np.abs(values)), axis=-1) > within):
            return values, np.full(values.shape, np.inf), exponent * math.log(2.0)
    after = [np.broadcast_to(left, (cases, n, n))]
    for k in range(panels - 1, 0, -1):
        after.append(after[-1] @ maps[:, k])
    after.reverse()
    rounding = noise(n) * size_of(maps)
    with np.errstate(over="ignore", invalid="ignore"):
        residual = _length(B @ X - X * values[:, None, :], -2) + noise(n) * size_of(B)[:, None]
        G, total, ahead = _length(Y, -1)[:, :, None] * residual[:, None, :], np.zeros(cases), X
        for k in range(panels):
            size = size_of(before[k])
            own = errors[:, k, None] * _length(ahead, -2) + (k > 0) * (rounding[:, k] * size)[:, None]
            G += _length(Y @ after[k], -1)[:, :, None] * own[:, None, :]
            total += size_of(after[k]) * (errors[:, k] + rounding[:, k]) * size
            ahead = maps[:, k] @ ahead
        radius = _bounds(values, G, total, size_of(B))
        for case in np.flatnonzero(closely & poor(values, radius)).tolist():
            e = total[case] + BACKWARD * EPS * float(np.linalg.norm(B[case]))
            radius[case] = np.fmin(radius[case], cluster_bounds(B[case], values[case], e))
    return values, radius, exponent * math.log(2.0)


def _numbers(left: Array, maps: Array, errors: Array) -> tuple[Complex, Array, Array]:
    """Of products of numbers, 1×1 matrices."""
    r = maps[..., 0, 0]
    product, exponent = np.broadcast_to(left[..., 0, 0], r.shape[:1]), np.zeros(len(r))
    for first in range(0, r.shape[1], AT_ONCE):
        mantissas, powers = np.frexp(r[:, first : first + AT_ONCE])
        product, power = np.frexp(product * np.prod(mantissas, axis=1))
        exponent += powers.sum(axis=1) + power
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.abs(product) * ((errors / np.abs(r)).sum(axis=1) + EPS * r.shape[1])
    radius = np.where(np.isfinite(radius), radius, np.inf)
    return product[:, None].astype(complex), radius[:, None], exponent * math.log(2.0)


def poor(values: Complex, radius: Array) -> Flags:
    """Cases in which a bound says little of an eigenvalue."""
    return np.asarray(np.isfinite(values).all(axis=-1) & ~np.all(radius < POOR * np.abs(values), axis=-1))


def noise(n: int) -> float:
    """Of |X| |Y|, which the rounding of X Y stays below: the norms overestimate less the smaller n is."""
    return (1.0 + 6.0 / n) * EPS


def size_of(m: Array) -> Array:
    """√(largest sum of a row · largest sum of a column), which no 2-norm exceeds."""
    m = np.abs(m)
    return np.sqrt(m.sum(axis=-1).max(axis=-1) * m.sum(axis=-2).max(axis=-1))


def _with_scale(values: Complex, radius: Array, scale: Array) -> tuple[Complex, Array]:
    """The eigenvalues and bounds themselves."""
    power = np.rint(scale / math.log(2.0)).astype(int)[:, None]  # exact: exp(scale) has lost digits where it is large
    with np.errstate(over="ignore"):
        return np.ldexp(values.real, power) + 1j * np.ldexp(values.imag, power), np.ldexp(radius, power)


def _scaled(maps: Array, errors: Array) -> tuple[Array, Array, Array]:
    """Factors and errors by powers of two such that products F_k…F_1 are near 1; the sum of the exponents (cases,)."""
    maps, errors = maps.copy(), errors.copy()
    product, total = np.eye(maps.shape[-1])[None], np.zeros(len(maps))
    for k in range(maps.shape[1]):
        exponent = np.frexp(np.abs(maps[:, k] @ product).max(axis=(-2, -1)))[1]
        maps[:, k] = np.ldexp(maps[:, k], -exponent[:, None, None])
        errors[:, k] = np.ldexp(errors[:, k], -exponent)
        product = maps[:, k] @ product
        total += exponent
    return maps, errors, total


def _vectors(matrices: Array) -> tuple[Complex, Complex, Complex]:
    """Λ (cases, n), X with columns of length 1, and X⁻¹; nan where a matrix is not finite or X is singular."""
    values = np.full(matrices.shape[:-1], np.nan + 0j)
    X, Y = np.full(matrices.shape, np.nan + 0j), np.full(matrices.shape, np.nan + 0j)
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    if finite.any():
        values[finite], X[finite] = np.linalg.eig(matrices[finite])
        Y[finite] = _inverse(X[finite])
    return values, X, Y


def _inverse(X: Complex) -> Complex:
    """Inverses; nan for singular matrices: their vectors coincide."""
    try:
        return np.linalg.inv(X).astype(complex)
    except np.linalg.LinAlgError:
        if len(X) == 1:
            return np.full_like(X, np.nan)
        half = len(X) // 2
        return np.concatenate([_inverse(X[:half]), _inverse(X[half:])])


def _bounds(values: Complex, G: Array, error: Array, size: Array) -> Array:
    """Bounds (cases, n) from G (cases, n, n), and from the error and the size of the matrix (cases,)."""
    m = values.shape[-1]
    own, rows = np.diagonal(G, axis1=-2, axis2=-1), _added(G)
    stretch = np.maximum((rows - own) / (SHARE * own), 1.0)
    reach = ((1.0 + SHARE) * own)[:, :, None] + rows[:, None, :] + stretch[:, :, None] * np.swapaxes(G, -1, -2)
    distance = np.abs(values[:, :, None] - values[:, None, :])
    clear = ((distance > reach) | np.eye(m, dtype=bool)).all(axis=-1) & np.isfinite(own)
    radius = np.where(clear, (1.0 + SHARE) * own, np.inf)
    rest = np.flatnonzero(~clear.all(axis=-1) & np.isfinite(values).all(axis=-1))
    if rest.size:
        e = error[rest] + math.sqrt(m) * BACKWARD * EPS * size[rest]
        cap = (2 * m - 1) * (2.0 * size[rest] + e) ** (1.0 - 1.0 / m) * e ** (1.0 / m)
        radius[rest] = np.fmin(np.fmin(radius[rest], _joined(distance[rest], rows[rest])), cap[:, None])
    return np.asarray(radius)


def _joined(distance: Array, radius: Array) -> Array:
    """Distance from each eigenvalue to anywhere in the discs connected with its own; inf where one is not known."""
    radius = np.where(np.isfinite(radius), radius, np.inf)
    meet = ~(distance > radius[:, :, None] + radius[:, None, :])
    for _ in range(max(1, math.ceil(math.log2(radius.shape[-1])))):
        meet = meet @ meet
    reach = np.where(meet, radius[:, None, :], 0.0)
    return np.where(meet.sum(axis=-1) == 1, radius, 2.0 * _added(reach))


def _added(terms: Array) -> Array:
    """Sum over the last axis, in order: NumPy's own order depends on the number of cases, and so would the last bit."""
    total = terms[..., 0].copy()
    for k in range(1, terms.shape[-1]):
        total += terms[..., k]
    return total


def _length(m: NDArray[Any], axis: int) -> Array:
    """2-norms of vectors along an axis."""
    return np.asarray(np.sqrt((m.real**2 + m.imag**2).sum(axis=axis)))
