"""Maps of y'' + q(ψ) y = 0 over a period, for many q: the arithmetic, and the path that runs it on arrays.

Each panel of half length h is mapped by its Taylor series (``taylor.py``) in the coordinates (y, h y'), which makes its
entries of one size; products and errors are kept in (y, u y') with one unit u for the whole period.  The maps F_s
multiply to Φ = F_S … F_1, of determinant 1.  With P the product before a panel, A the product after it, W = P A, an
error δ of F moves τ = ½ tr Φ and D = τ² - 1 by::

    dτ = ½ tr(W δ),     dD = tr((τ W - adj F) δ) + second order

(D = ½ tr X² for the traceless part X of Φ; P Φ A = W F W = 2τ W - F⁻¹ by Cayley and Hamilton for W F), so the bounds
need one sweep backwards.  δ is the bound of the truncation plus an allowance for rounding.

Zeros of the first solution (y = 1, y' = 0) are counted on the way, one a panel at most.  They carry the branch: a
solution passes y = 0 clockwise only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import available, worth_compiling
from .primitives import select
from .taylor import ORDER, panel

__all__ = ["ROWS", "Panels", "equal_panels", "map_equal_panels", "map_panels"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
# True errors of 20 000 random blades reach 0.15 (τ) and 0.42 (D) of the bounds that these give.
ROUNDING = 2.0  # eps a panel, relative to its map
COEFFICIENTS = 2.0  # eps of the terms of q, relative to them
TRUNCATION = 4e-15  # relative to a panel's map: half of its rounding
CELLS = 8192  # panels at once in NumPy: the sixty arrays of their arithmetic stay in L2

#: Rows of a result: Φ by rows, the bounds of the errors of τ and D, zeros of y, panels that are not resolved, D.
ROWS = ("phi_11", "phi_12", "phi_21", "phi_22", "half_trace_error", "discriminant_error", "zeros", "unresolved",
        "discriminant")  # fmt: skip


# ---------------------------------------------------------------------- arithmetic of a panel, numbers or arrays
def chained(f: Any, m: Any) -> Any:
    """F M, by rows."""
    return (
        f[0] * m[0] + f[1] * m[2],
        f[0] * m[1] + f[1] * m[3],
        f[2] * m[0] + f[3] * m[2],
        f[2] * m[1] + f[3] * m[3],
    )


def size_of(f: Any) -> Any:
    """Σ |entries|."""
    return abs(f[0]) + abs(f[1]) + abs(f[2]) + abs(f[3])


def placed(f: Any, e: Any, half: Any, unit: Any, size: Any, kick: Any) -> Any:
    """A panel in (y, u y') after its kick, the errors for :func:`entrywise`, and whether its series is too short.

    ``kick`` is what y adds to y' where the panel begins.  F₂₁ comes from h² q, and in a panel much shorter than u so
    does its error: as large as the others it would, over h/u, outgrow them all.
    """
    g, kick, area, scale = half / unit, unit * kick, half * half * size, size_of(f)
    part = select((g < 0.5) & (area < 1.0), area, 1.0)
    delta = e + EPS * (ROUNDING * scale + COEFFICIENTS * area)
    corner = e + EPS * (ROUNDING * scale * part + COEFFICIENTS * area)
    f1, f2 = f[1] * g, f[2] / g
    F = f[0] + f1 * kick, f1, f2 + f[3] * kick, f[3]
    return F, (delta * (1.0 + g * abs(kick)), delta * g, corner / g + delta * abs(kick)), e > TRUNCATION * scale


def weighed(p: Any, a: Any, f: Any, tau: Any, delta: Any, g: Any) -> Any:
    """:func:`entrywise` for errors δ, δg, δ/g, δ of the entries of F."""
    return entrywise(p, a, f, tau, delta, delta * g, delta / g)


def entrywise(p: Any, a: Any, f: Any, tau: Any, delta: Any, d1: Any, d2: Any) -> Any:
    """What errors δ, d₁, d₂, δ of the entries of F do to τ (twice), to D, and to all entries of Φ together."""
    w0, w1 = p[0] * a[0] + p[1] * a[2], p[0] * a[1] + p[1] * a[3]
    w2, w3 = p[2] * a[0] + p[3] * a[2], p[2] * a[1] + p[3] * a[3]
    trace = (abs(w0) + abs(w3)) * delta + abs(w2) * d1 + abs(w1) * d2
    discriminant = (
        (abs(tau * w0 - f[3]) + abs(tau * w3 - f[0])) * delta + abs(tau * w2 + f[2]) * d1 + abs(tau * w1 + f[1]) * d2
    )
    row_1, row_2 = abs(p[0]) + abs(p[1]), abs(p[2]) + abs(p[3])
    entries = (abs(a[0]) + abs(a[2])) * (delta * row_1 + d1 * row_2) + (abs(a[1]) + abs(a[3])) * (
        d2 * row_1 + delta * row_2
    )
    return trace, discriminant, entries


def finished(m: Any, unit: Any, sums: Any) -> Any:
    """Φ in (y, y'), the bounds of τ and D from the sums of :func:`weighed`, and D.

    Second order is δΦ's own determinant; D itself is the difference of two numbers that are rounded.
    """
    half, product = 0.5 * (m[0] - m[3]), m[1] * m[2]
    rounding = 2.0 * EPS * (half * half + abs(product))
    # products of large maps are rounded too, which shows in the determinant (D = τ² - det Φ); next to ±I it must not
    defect = (abs(product) > 1.0) * abs(m[0] * m[3] - product - 1.0)
    D_error = sums[1] + sums[2] * sums[2] + rounding + defect
    return m[0], m[1] * unit, m[2] / unit, m[3], 0.5 * sums[0], D_error, half * half + product


# ---------------------------------------------------------------------- equal panels, one polynomial: compiled
class Tables(NamedTuple):
    """cos and sin of two harmonics at the centres (panels, 4), and weights of their Taylor coefficients (K, 2)."""

    trigonometric: Array
    weights: Array


@cache
def tables(panels: int, angle: float, period: float) -> Tables:
    """For ``panels`` over a period in which harmonic 1 turns by ``angle`` revolutions."""
    h, half, n = math.pi * angle / panels, 0.5 * period / panels, np.array([1, 2])
    phase = np.outer((2 * np.arange(panels) + 1) * h, n)
    k = np.arange(ORDER - 1)
    sign = np.where(k % 4 < 2, -1.0, 1.0)  # of cos, -sin, -cos, sin; p = -h² q
    scale = np.array([half * half / math.factorial(j) for j in k])
    return Tables(
        np.stack([np.cos(phase), np.sin(phase)], axis=-1).reshape(panels, 4),
        (sign * scale)[:, None] * (n * h) ** k[:, None],
    )


def map_equal_panels(
    q: Array,
    size: Array,
    index: NDArray[np.intp],
    counts: NDArray[np.int64],
    period: float,
    angle: float,
    out: Array,
    *,
    compiled: bool | None = None,
) -> None:
    """Map the points ``index``, each over its number of equal panels.

    Parameters
    ----------
    q : (2H+1, n)
        Mean, cos ωψ, sin ωψ, cos 2ωψ … of q; H ≤ 2 runs compiled.
    size : (n,)
        Of the terms that q is made of: their rounding is its error.
    index, counts : (m,)
        The points to map and their panels; a point's bits do not depend on the others.
    period, angle : float
        In ψ and in revolutions of harmonic 1.
    out : (9, n)
        :data:`ROWS` of the points are filled.
    compiled : bool, optional
        Whether the points stand for many more; by their number if left out.
    """
    if len(q) <= 5 and (worth_compiling(q.shape[1]) if compiled is None else compiled and available()):
        from . import hill_lanes

        terms = np.ascontiguousarray(q if len(q) == 5 else np.concatenate([q, np.zeros((5 - len(q), q.shape[1]))]))
        for count, points in _grouped(index, counts):
            half = 0.5 * period / count
            filled, tabled = (hill_lanes.blocks(points), len(points)), tables(count, angle, period)
            hill_lanes.hill_blocks(terms, size, *filled, *tabled, half, out)
        return
    map_panels(equal_panels(q[:, index], counts, period, angle), size[index], 0.5 * period / counts, index, out)


def _grouped(index: NDArray[np.intp], key: NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """The points of each key, in order."""
    order = np.argsort(key.astype(np.int16), kind="stable")
    counts = np.bincount(key)
    ends = np.cumsum(counts)
    for k in np.flatnonzero(counts).tolist():
        yield k, index[order[ends[k] - counts[k] : ends[k]]]


# ---------------------------------------------------------------------- any panels, on arrays
class Panels(NamedTuple):
    """Panels of many points, one point after the other.

    ``point`` is the point of each panel, ``terms`` (2H+1, panels) its q in harmonics of ``frequency``, ``kick`` what y
    adds to y' where it begins, ``counts`` the number of panels of each point.
    """

    terms: Array
    centre: Array
    half: Array
    kick: Array
    counts: NDArray[np.int64]
    frequency: float


def equal_panels(q: Array, counts: NDArray[np.int64], period: float, angle: float) -> Panels:
    """``counts`` equal panels a point of q (2H+1, points)."""
    point = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(point)) - np.repeat(np.cumsum(counts) - counts, counts)
    half = (0.5 * period / counts)[point]
    frequency = 2.0 * math.pi * angle / period
    return Panels(q[:, point], (2 * place + 1) * half, half, np.zeros(len(point)), counts, frequency)


def map_panels(panels: Panels, size: Array, unit: Array, index: NDArray[np.intp], out: Array) -> None:
    """Fill the :data:`ROWS` (9, n) of the points ``index`` from their panels.

    ``unit`` (points,) is the length that makes y' comparable with y.
    """
    ends = np.cumsum(panels.counts)
    first = 0
    while first < len(size):
        done = ends[first - 1] if first else 0
        last = max(int(np.searchsorted(ends, done + CELLS, side="right")), first + 1)
        some, flat = slice(first, last), slice(done, ends[last - 1])
        part = Panels(panels.terms[:, flat], panels.centre[flat], panels.half[flat], panels.kick[flat],
                      panels.counts[some], panels.frequency)  # fmt: skip
        with np.errstate(over="ignore", invalid="ignore"):  # motions that grow beyond the doubles have infinite bounds
            out[:, index[some]] = _mapped(part, size[some], unit[some])
        first = last


def _series(panels: Panels) -> list[Array]:
    """p_k of -h² q about the centres, (panels,) each."""
    q, half = panels.terms, panels.half
    p = [np.zeros(len(half)) for _ in range(ORDER - 1)]
    p[0] -= half * half * q[0]
    for n in range(1, len(q) // 2 + 1):
        phase, step = n * panels.frequency * panels.centre, n * panels.frequency * half
        cosine, sine = np.cos(phase), np.sin(phase)
        even, odd = q[2 * n - 1] * cosine + q[2 * n] * sine, q[2 * n] * cosine - q[2 * n - 1] * sine
        weight = half * half
        for k in range(ORDER - 1):
            p[k] += (-weight if k % 4 < 2 else weight) * (even, odd)[k % 2]
            weight = weight * step / (k + 1)
    return p


def _mapped(panels: Panels, size: Array, unit: Array) -> Array:
    """The rows of some points."""
    counts, half = panels.counts, panels.half
    point = np.repeat(np.arange(len(counts)), counts)
    *entries, e = panel(*_series(panels))
    F, errors, rough = placed(entries, e, half, unit[point], size[point], panels.kick)
    flat = (*F, *errors, rough)
    steps = list(
        zip(*(_by_place(x, fill, counts) for x, fill in zip(flat, (1, 0, 0, 1, 0, 0, 0, 0), strict=True)), strict=True)
    )

    one, zero = np.ones(len(counts)), np.zeros(len(counts))
    products: list[Any] = [(one, zero, zero, one)]
    for f in steps:
        products.append(chained(f[:4], products[-1]))
    last = products[-1]
    tau, sums, after, unresolved = 0.5 * (last[0] + last[3]), [zero] * 3, products[0], zero
    for f, p in zip(steps[::-1], products[-2::-1], strict=True):
        sums = [total + x for total, x in zip(sums, entrywise(p, after, f[:4], tau, *f[4:7]), strict=True)]
        unresolved = unresolved + f[7]
        after = chained(after, f[:4])
    zeros = sum(((a[0] < 0) != (b[0] < 0)) * 1.0 for a, b in pairwise(products))
    *first, discriminant = finished(last, unit, sums)
    return np.stack([*first, zeros, unresolved, discriminant])


def _by_place(values: Array, fill: float, counts: NDArray[np.int64]) -> Array:
    """Values a panel as (most panels, points): first panels in the first row; ``fill`` after a point's last."""
    out = np.full((len(counts), int(counts.max())), fill, float)
    out[np.arange(out.shape[1]) < counts[:, None]] = values
    return np.ascontiguousarray(out.T)
