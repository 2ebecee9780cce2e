"""The Hill form over a tensor grid of parameters: between nodes by polynomials, for many points at once.

Over two axes x and z, with ℓ_a(x) the polynomial that is 1 at node a and 0 at the others::

    f(x, z) = Σ_a Σ_b ℓ_a(x) ℓ_b(z) f_ab,      f = Φ₁₁, Φ₁₂, Φ₂₁, Φ₂₂, ω, α
    |δτ|   ≤ Σ_a Σ_b |ℓ_a(x)| |ℓ_b(z)| w_ab,    w_ab a bound at the node that holds what the polynomials leave out

ℓ in barycentric form is right to a few eps of itself, however small it is: where motions grow by decades over the grid,
the errors of the large ones stay there.

No bound of Φ's entries is needed: det Φ = 1, so that D = τ² - 1, and what is computed from the entries is τ² - det Φ::

    D = ((Φ₁₁-Φ₂₂)/2)² + Φ₁₂ Φ₂₁,      |δD| ≤ 2|τ||δτ| + |δτ|² + |det Φ - 1|

The branch comes from the angle ω of the rotation in Φ = rotation · stretch (stretch symmetric and positive)::

    tan ω = (Φ₁₂/u - Φ₂₁u) / (Φ₁₁ + Φ₂₂),      clockwise in the plane of y and u y'

The sum of the squares of the two is 4 at least, so that ω is an analytic function of the parameters, smooth where the
angle of a solution leaps; and a stretch turns nothing by a quarter turn.  Signs tell the quadrant of ω, so that a rough
polynomial tells its whole turns, and signs again where the first solution is, hence its zeros.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import available
from .closing import exponents_of
from .hill import EPS, ROWS
from .primitives import select

__all__ = ["FIELDS", "Exponents", "Tile", "cardinals", "close_tile", "summed", "tile_rows"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

#: What is known at the nodes: Φ by rows, ω in quarter turns, α, the bound of τ.
FIELDS = ("phi_11", "phi_12", "phi_21", "phi_22", "quarters", "alpha", "half_trace_error")
LEFT_OUT = -1  # in place of a method
TINY = 1e-200  # in place of a distance of zero: its weight outgrows all others,
NONE = 1e-100  # and below this theirs are zero: a point at a node has nothing of the other nodes
DOUBTFUL = 1.25 / 4.0  # turns from the middle of ω's quadrant: 1/8 is right, 1/2 the turn is anyone's guess


class Tile(NamedTuple):
    """Some rows and columns of a grid.

    ``values`` (rows' nodes, 7, columns' nodes) are the :data:`FIELDS`; ``x`` (r,) and ``z`` (c,) the parameters of rows
    and columns, ``row_places`` and ``column_places`` add up to a point's place among all.  ``units`` (r,) make y'
    comparable with y, ``alpha_errors`` (r,) bound those of α, ``panels`` (r,) are those of each node.  A point whose
    bound is above ``most`` is left out.
    """

    values: Array
    x: Array
    x_nodes: Array
    x_weights: Array
    z: Array
    z_nodes: Array
    z_weights: Array
    row_places: Places
    column_places: Places
    units: Array
    alpha_errors: Array
    panels: NDArray[np.int64]
    period: float
    most: float


class Exponents(NamedTuple):
    """Where the exponents of n points go, as they lie in memory: σ₁, ρ₁, σ₂, ρ₂ (4n,), their errors (2n,), others (n,).

    ``method`` is :data:`LEFT_OUT` where a point is.
    """

    exponents: Array
    exponent_errors: Array
    determinant_defect: Array
    rotation_number: Array
    lock: Array
    verdict: NDArray[np.int8]
    reason: NDArray[np.int8]
    method: NDArray[np.int8]
    panels: NDArray[np.int32]


# ---------------------------------------------------------------------- arithmetic of a point, numbers or arrays
def judged(m: Any, tau_error: Any) -> Any:
    """D and the bound of its error."""
    tau, half, product, diagonal = 0.5 * (m[0] + m[3]), 0.5 * (m[0] - m[3]), m[1] * m[2], m[0] * m[3]
    rounding = 4.0 * EPS * (half * half + abs(product) + abs(diagonal))  # of D and of det Φ
    return half * half + product, (2.0 * abs(tau) + tau_error) * tau_error + abs(diagonal - product - 1.0) + rounding


def zeros_of(m: Any, quarters: Any, unit: Any) -> Any:
    """Zeros of the first solution, and whether its turns are certain, from Φ and ω in quarter turns."""
    sine, cosine = m[1] / unit - m[2] * unit, m[0] + m[3]
    quadrant = select(sine >= 0.0, select(cosine >= 0.0, 0.0, 1.0), select(cosine < 0.0, 2.0, 3.0))
    away = 0.25 * (quarters - quadrant - 0.5)
    turns = np.floor(away + 0.5)
    first = select(m[2] <= 0.0, select(m[0] >= 0.0, 0.0, 1.0), select(m[0] < 0.0, 2.0, 3.0))  # quadrant of (y, uy')
    step = first - quadrant + 1.0
    step = step - 4.0 * np.floor(0.25 * step)  # 0, 1 or 2: at most a quadrant from ω's
    zeros = np.floor(0.5 * (quadrant + 4.0 * turns + step))
    return zeros, (abs(away - turns) < DOUBTFUL) & (step < 2.5)


def within(D: Any, b: Any, tau_error: Any, most: Any, T: Any) -> Any:
    """Whether the bound of the exponents is below ``most``, without roots.

    It is b/(2T√(|D|(1+D))) in a lock, and √(b²/4|D| + δτ²)/T between.
    """
    room = (most * T) ** 2 - select(D > 0.0, 0.0, tau_error * tau_error)
    return b * b <= 4.0 * room * (abs(D) * (1.0 + select(D > 0.0, D, 0.0)))


# ---------------------------------------------------------------------- on arrays
def cardinals(x: Array, nodes: Array, weights: Array) -> Array:
    """ℓ_j(x), (points, nodes)."""
    distance = x[:, None] - nodes
    terms = weights / np.where(distance == 0.0, TINY, distance)
    found = terms / terms.sum(axis=1, keepdims=True)
    return np.where(np.abs(found) < NONE, 0.0, found)


def summed(matrix: Array, values: Array, axis: int) -> Array:
    """Σ_j matrix_ij values_…j… along an axis, which comes first: in order, so that a place's bits are its own."""
    parts = np.moveaxis(values, axis, 0)
    total = np.zeros((len(matrix), *parts.shape[1:]))
    for column, part in zip(matrix.T, parts, strict=True):
        total += column.reshape(-1, *[1] * part.ndim) * part
    return total


def tile_rows(tile: Tile) -> tuple[Array, Array, NDArray[np.bool_]]:
    """:data:`~floquet.kernels.hill.ROWS` (9, n), α, and which points are not left out."""
    fields = len(FIELDS)
    across, along = cardinals(tile.x, tile.x_nodes, tile.x_weights), cardinals(tile.z, tile.z_nodes, tile.z_weights)
    mixed = summed(across, tile.values, 0)  # (r, 7, columns' nodes)
    mixed[:, -1] = summed(np.abs(across), tile.values[:, -1], 0)
    found = np.empty((fields, len(tile.x), len(tile.z)))
    found[:-1] = np.moveaxis(summed(along, mixed[:, :-1], 2), 0, -1).swapaxes(0, 1)
    found[-1] = summed(np.abs(along), mixed[:, -1], 1).T
    *m, quarters, alpha, tau_error = found.reshape(fields, -1)
    rows = np.empty((len(ROWS), len(alpha)))
    with np.errstate(invalid="ignore", over="ignore"):
        rows[:4], rows[4] = m, tau_error
        rows[8], rows[5] = judged(m, tau_error)
        rows[6], certain = zeros_of(m, quarters, np.repeat(tile.units, len(tile.z)))
        rows[7] = 0.0
        return rows, alpha, certain & within(rows[8], rows[5], rows[4], tile.most, tile.period)


def close_tile(tile: Tile, method: int, out: Exponents) -> None:
    """Exponents of a tile's points."""
    if available():
        from . import grid_lanes

        grid_lanes.close_tile(tile, method, out)
        return
    rows, alpha, kept = tile_rows(tile)
    found = exponents_of(rows, alpha, tile.period, alpha_error=np.repeat(tile.alpha_errors, len(tile.z)))
    places = (tile.row_places[:, None] + tile.column_places).ravel()
    out.exponents.view(complex).reshape(-1, 2)[places] = found["exponents"]
    out.exponent_errors.reshape(-1, 2)[places] = found["bound"][:, None]
    out.determinant_defect[places], out.rotation_number[places] = found["defect"], found["rho"]
    out.lock[places], out.verdict[places], out.reason[places] = found["lock"], found["verdict"], found["reason"]
    out.method[places], out.panels[places] = np.where(kept, method, LEFT_OUT), np.repeat(tile.panels, len(tile.z))
