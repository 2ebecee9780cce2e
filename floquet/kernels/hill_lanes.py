"""Hill's equation for many points at once: loops over lanes, which numba turns into wide registers.

A block holds :data:`LANES` points, one a lane.  Scratch is one-dimensional, row r of lane i at r·LANES + i: with
constant distances between rows the compiler can tell that what it writes is not what it reads next, and makes wide
registers of the loops.  For panel s, ``steps[s + 1]`` = F (4 rows), the product of all panels so far (4), the bound of
the truncation of F (1).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import closing, hill
from .compiler import inlined, kernel
from .elementary import arcsinh, arctan2
from .hill import COEFFICIENTS, EPS, ROUNDING, TRUNCATION
from .lanes import WIDTH
from .taylor import panel, two_harmonics, weights

__all__ = ["LANES", "blocks", "close_rows", "hill_blocks", "select", "unit", "weigh"]

LANES = 256  # enough for a panel's weights to be fetched once for many points; the scratch of a block stays in L2

_panel, _two_harmonics, _weights = inlined(panel), inlined(two_harmonics), inlined(weights)
_chained, _size_of, _finished = inlined(hill.chained), inlined(hill.size_of), inlined(hill.finished)
_weighed = inlined(hill.weighed, entrywise=inlined(hill.entrywise))


@inlined
def select(condition: Any, yes: Any, no: Any) -> Any:
    """:func:`floquet.kernels.primitives.select` of numbers."""
    return yes if condition else no


_closed = inlined(closing.closed, select=select, arcsinh=arcsinh, arctan2=arctan2)


def blocks(index: NDArray[np.intp]) -> NDArray[np.intp]:
    """The points in blocks of lanes, (blocks, LANES); spare lanes repeat the last point."""
    count = -(-len(index) // LANES)
    out = np.empty(count * LANES, np.intp)
    out[: len(index)], out[len(index) :] = index, index[-1]
    return out.reshape(count, LANES)


@kernel
def forward(q: Any, before: Any, step: Any, cosine: Any, table: Any, lanes: int) -> None:
    """One panel: F, the bound of its truncation, and its product with what is before."""
    c1, s1, c2, s2 = cosine[0], cosine[1], cosine[2], cosine[3]
    w = _weights(table)
    for i in range(lanes):
        q1, q2, q3, q4 = q[LANES + i], q[2 * LANES + i], q[3 * LANES + i], q[4 * LANES + i]
        even_1, odd_1 = q1 * c1 + q2 * s1, q2 * c1 - q1 * s1
        even_2, odd_2 = q3 * c2 + q4 * s2, q4 * c2 - q3 * s2
        f0, f1, f2, f3, e = _panel(*_two_harmonics(q[i], even_1, odd_1, even_2, odd_2, w))
        p = (before[4 * LANES + i], before[5 * LANES + i], before[6 * LANES + i], before[7 * LANES + i])
        m = _chained((f0, f1, f2, f3), p)
        step[i], step[LANES + i], step[2 * LANES + i], step[3 * LANES + i] = f0, f1, f2, f3
        step[4 * LANES + i], step[5 * LANES + i], step[6 * LANES + i], step[7 * LANES + i] = m
        step[8 * LANES + i] = e


@kernel
def backward(step: Any, before: Any, state: Any, point: Any, lanes: int) -> None:
    """Weigh the errors of a panel and put it to the product after it."""
    for i in range(lanes):
        f = (step[i], step[LANES + i], step[2 * LANES + i], step[3 * LANES + i])
        p = (before[4 * LANES + i], before[5 * LANES + i], before[6 * LANES + i], before[7 * LANES + i])
        a = (state[i], state[LANES + i], state[2 * LANES + i], state[3 * LANES + i])
        scale, e = _size_of(f), step[8 * LANES + i]
        w = _weighed(p, a, f, point[i], e + EPS * ROUNDING * scale + point[LANES + i], 1.0)
        state[i], state[LANES + i], state[2 * LANES + i], state[3 * LANES + i] = _chained(a, f)
        state[4 * LANES + i] += w[0]
        state[5 * LANES + i] += w[1]
        state[6 * LANES + i] += w[2]
        state[7 * LANES + i] += 1.0 if (step[4 * LANES + i] < 0.0) != (p[0] < 0.0) else 0.0
        state[8 * LANES + i] += 1.0 if e > TRUNCATION * scale else 0.0


@kernel
def unit(m: Any) -> None:
    """Set four rows to the unit matrix."""
    for i in range(LANES):
        m[i], m[LANES + i], m[2 * LANES + i], m[3 * LANES + i] = 1.0, 0.0, 0.0, 1.0


@kernel
def weigh(steps: Any, panels: int, state: Any, point: Any, lanes: int) -> None:
    """The sweep backwards over all panels: the product of all and the sums of their errors in ``state``."""
    last = steps[panels, 4 * LANES :]
    for i in range(lanes):
        point[i] = 0.5 * (last[i] + last[3 * LANES + i])
    state[:] = 0.0
    unit(state)
    for s in range(panels, 0, -1):
        backward(steps[s], steps[s - 1], state, point, lanes)


@kernel
def hill_blocks(q: Any, size: Any, index: Any, count: int, cosines: Any, table: Any, half: float, out: Any) -> None:
    """:func:`floquet.kernels.hill.map_equal_panels` for ``count`` points in :func:`blocks`."""
    panels = len(cosines)
    steps = np.empty((panels + 1, 9 * LANES))
    rows, state, point = np.empty(5 * LANES), np.empty(9 * LANES), np.empty(2 * LANES)
    for b in range(len(index)):
        block = index[b]
        lanes = min(LANES, -(-(count - b * LANES) // WIDTH) * WIDTH)  # of the last block no more than are wanted
        for i in range(lanes):
            for r in range(5):
                rows[r * LANES + i] = q[r, block[i]]
            point[LANES + i] = EPS * COEFFICIENTS * half * half * size[block[i]]
        unit(steps[0, 4 * LANES :])
        for s in range(panels):
            forward(rows, steps[s], steps[s + 1], cosines[s], table, lanes)
        weigh(steps, panels, state, point, lanes)
        last = steps[panels, 4 * LANES :]
        for i in range(lanes):
            m = (last[i], last[LANES + i], last[2 * LANES + i], last[3 * LANES + i])
            sums = (state[4 * LANES + i], state[5 * LANES + i], state[6 * LANES + i])
            k = block[i]
            out[0, k], out[1, k], out[2, k], out[3, k], out[4, k], out[5, k], out[8, k] = _finished(m, half, sums)
            out[6, k], out[7, k] = state[7 * LANES + i], state[8 * LANES + i]


@kernel
def close_block(rows: Any, alpha_error: float, out: Any, T: float) -> None:
    """A block of scratch: rows and α (10 rows) → growth, ρ, lock or not, bound, verdict, reason, defect."""
    for i in range(LANES):
        m = (rows[i], rows[LANES + i], rows[2 * LANES + i], rows[3 * LANES + i])
        growth, rho, locked, bound, verdict, reason, defect = _closed(
            m,
            rows[4 * LANES + i],
            rows[8 * LANES + i],
            rows[5 * LANES + i],
            rows[6 * LANES + i],
            rows[9 * LANES + i],
            alpha_error,
            T,
        )
        out[i], out[LANES + i], out[2 * LANES + i], out[3 * LANES + i] = growth, rho, 1.0 if locked else 0.0, bound
        out[4 * LANES + i], out[5 * LANES + i], out[6 * LANES + i] = verdict, reason, defect


@kernel
def close_rows(
    rows: Any,
    alpha: Any,
    alpha_error: float,
    T: float,
    parts: Any,
    bound: Any,
    rho: Any,
    lock: Any,
    defect: Any,
    verdict: Any,
    reason: Any,
) -> None:
    """:func:`floquet.kernels.closing.exponents_of` in blocks; ``parts`` are σ₁, ρ₁, σ₂, ρ₂ (n, 4)."""
    n = len(alpha)
    block, out = np.ones(10 * LANES), np.empty(7 * LANES)
    for start in range(0, n, LANES):
        count = min(LANES, n - start)
        for r in range(9):
            block[r * LANES : r * LANES + count] = rows[r, start : start + count]
        block[9 * LANES : 9 * LANES + count] = alpha[start : start + count]
        close_block(block, alpha_error, out, T)
        for i in range(count):
            k, growth, turning, locked = start + i, out[i], out[LANES + i], out[2 * LANES + i] > 0.0
            parts[k, 0], parts[k, 1] = alpha[k] + growth, turning
            parts[k, 2], parts[k, 3] = alpha[k] - growth, turning if locked else -turning
            rho[k], lock[k], bound[k] = turning, turning if locked else np.nan, out[3 * LANES + i]
            verdict[k], reason[k], defect[k] = out[4 * LANES + i], out[5 * LANES + i], out[6 * LANES + i]
