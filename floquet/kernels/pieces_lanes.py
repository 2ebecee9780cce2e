"""Hill's equation in pieces: sixteen points as one number, one panel of theirs after the other.

A block takes as many panels on a piece as the point with the most; a point with fewer waits, its numbers unchanged.
For panel s, ``steps[s + 1]`` = F (4), the errors of its entries (3), its flag (1 not resolved, 0 resolved, -1 no panel
of this point), and the product of all panels so far (4).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import elementary, hill, lanes
from .compiler import inlined, kernel
from .lanes import WIDTH
from .taylor import ORDER, panel

__all__ = ["map_blocks"]

as_lanes: Any = lanes.as_lanes
scratch: Any = lanes.scratch
spread: Any = lanes.spread
where: Any = lanes.where

_size_of = inlined(hill.size_of)
_cosine_and_sine = inlined(elementary.cosine_and_sine, select=where)
_placed = inlined(hill.placed, select=where, size_of=_size_of)
_panel, _chained = inlined(panel), inlined(hill.chained)
_entrywise, _finished = inlined(hill.entrywise), inlined(hill.finished)


@kernel
def series(q: Any, first: int, order: int, phase: Any, step: Any, square: Any, table: Any, parts: Any, p: Any) -> None:
    """p_k of -h² q about a centre: ``phase`` = ωc, ``step`` = ωh, ``square`` = h²; ``parts`` is room for harmonics.

    Angles are added a harmonic at a time, so cos and sin of harmonic n are off by 3n eps at most: one of n by the
    first angle, two by the products.
    """
    c, s = _cosine_and_sine(phase)
    cosine, sine = c, s
    for n in range(order):
        a, b = q[first + 2 * n + 1], q[first + 2 * n + 2]
        parts[0, n], parts[1, n] = a * cosine + b * sine, b * cosine - a * sine
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    power = square
    for k in range(ORDER - 1):
        total = spread(0.0) if k else 0.0 - q[first]
        for n in range(order):
            total = total + table[k, n] * parts[k % 2, n]
        p[k] = power * total
        power = power * step


@kernel
def forward(p: Any, half: Any, unit: Any, size: Any, kick: Any, live: Any, steps: Any, s: int) -> None:
    """Panel s from its p: F, the errors of its entries, the flag, and the product with what is before."""
    f0, f1, f2, f3, e = _panel(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11],
                               p[12], p[13], p[14], p[15], p[16], p[17], p[18], p[19], p[20], p[21], p[22])  # fmt: skip
    f, errors, rough = _placed((f0, f1, f2, f3), e, half, unit, size, kick)
    n, m = s + 1, (steps[s, 8], steps[s, 9], steps[s, 10], steps[s, 11])
    steps[n, 0], steps[n, 1], steps[n, 2], steps[n, 3] = f
    steps[n, 4], steps[n, 5], steps[n, 6] = errors
    steps[n, 7] = where(live, where(rough, 1.0, spread(0.0)), -1.0)
    product = _chained(f, m)
    steps[n, 8], steps[n, 9] = where(live, product[0], m[0]), where(live, product[1], m[1])
    steps[n, 10], steps[n, 11] = where(live, product[2], m[2]), where(live, product[3], m[3])


@kernel
def backward(steps: Any, s: int, state: Any, tau: Any) -> None:
    """Weigh the errors of panel s and put it to the product after it: four rows of ``state``, then the sums."""
    n = s + 1
    flag, f = steps[n, 7], (steps[n, 0], steps[n, 1], steps[n, 2], steps[n, 3])
    p, a = (steps[s, 8], steps[s, 9], steps[s, 10], steps[s, 11]), (state[0], state[1], state[2], state[3])
    w, after = _entrywise(p, a, f, tau, steps[n, 4], steps[n, 5], steps[n, 6]), _chained(a, f)
    live = flag >= 0.0
    state[0], state[1] = where(live, after[0], a[0]), where(live, after[1], a[1])
    state[2], state[3] = where(live, after[2], a[2]), where(live, after[3], a[3])
    state[4] = where(live, state[4] + w[0], state[4])
    state[5] = where(live, state[5] + w[1], state[5])
    state[6] = where(live, state[6] + w[2], state[6])
    state[7] = state[7] + abs(where(steps[n, 8] < 0.0, 1.0, spread(0.0)) - where(p[0] < 0.0, 1.0, spread(0.0)))
    state[8] = state[8] + where(flag > 0.0, 1.0, spread(0.0))


@kernel
def gather(
    terms: Any, edges: Any, kicks: Any, size: Any, counts: Any, index: Any, at: Any, q: Any, places: Any, point: Any,
    most: Any,
) -> int:  # fmt: skip
    """Rows of the sixteen points ``at``, and the most panels of them on each piece, whose sum is given back.

    ``q`` are the terms, ``places`` start, half length, kick and panels of each piece, ``point`` the unit of length and
    the size of the terms of q.
    """
    pieces, total = len(counts), 0
    for i in range(WIDTH):
        k, panels = index[at[i]], 0
        for j in range(pieces):
            panels += counts[j, at[i]]
        point[0, i], point[1, i] = 0.5 * edges[pieces, k] / panels, size[k]
    for r in range(len(terms)):
        for i in range(WIDTH):
            q[r, i] = terms[r, index[at[i]]]
    for j in range(pieces):
        most[j] = 0
        for i in range(WIDTH):
            k, count = index[at[i]], counts[j, at[i]]
            places[j, 0, i], places[j, 1, i] = edges[j, k], (edges[j + 1, k] - edges[j, k]) / (2 * max(count, 1))
            places[j, 2, i], places[j, 3, i] = kicks[j, k] if kicks.shape[1] else 0.0, count
            most[j] = max(most[j], count)
        total += most[j]
    return total


@kernel
def map_blocks(
    terms: Any, edges: Any, kicks: Any, size: Any, first: Any, orders: Any, table: Any, frequency: float,
    index: Any, counts: Any, panels: int, out: Any,
) -> None:  # fmt: skip
    """:func:`floquet.kernels.pieces.map_pieces` of points in an order that has like ones side by side.

    ``panels``: as many as a block of sixteen can have.  Spare lanes repeat the last point.
    """
    pieces, points = counts.shape
    at, most = np.empty(WIDTH, np.intp), np.empty(pieces, np.int64)
    q_rows, place_rows, point_rows = scratch(len(terms)), scratch(4 * pieces).reshape(pieces, 4, WIDTH), scratch(2)
    step_rows, state_rows = scratch(12 * (panels + 1)).reshape(panels + 1, 12, WIDTH), scratch(9)
    q, places, point, steps = as_lanes(q_rows), as_lanes(place_rows), as_lanes(point_rows), as_lanes(step_rows)
    p, parts = as_lanes(scratch(ORDER - 1)), as_lanes(scratch(2 * table.shape[1]).reshape(2, table.shape[1], WIDTH))
    state = as_lanes(state_rows)
    steps[0, 8], steps[0, 9], steps[0, 10], steps[0, 11] = spread(1.0), spread(0.0), spread(0.0), spread(1.0)
    for start in range(0, points, WIDTH):
        for i in range(WIDTH):
            at[i] = min(start + i, points - 1)
        total = gather(terms, edges, kicks, size, counts, index, at, q_rows, place_rows, point_rows, most)
        done = 0
        for j in range(pieces):
            half = places[j, 1]
            for s in range(most[j]):
                centre = places[j, 0] + (2 * s + 1) * half
                series(q, first[j], orders[j], frequency * centre, frequency * half, half * half, table, parts, p)
                kick = places[j, 2] if s == 0 else spread(0.0)
                forward(p, half, point[0], point[1], kick, places[j, 3] > s, steps, done)
                done += 1
        tau = 0.5 * (steps[total, 8] + steps[total, 11])
        for r in range(9):
            state[r] = spread(1.0 if r in (0, 3) else 0.0)
        for s in range(total - 1, -1, -1):
            backward(steps, s, state, tau)
        for i in range(min(WIDTH, points - start)):
            m = (step_rows[total, 8, i], step_rows[total, 9, i], step_rows[total, 10, i], step_rows[total, 11, i])
            sums, k = (state_rows[4, i], state_rows[5, i], state_rows[6, i]), index[start + i]
            out[0, k], out[1, k], out[2, k], out[3, k], out[4, k], out[5, k], out[8, k] = _finished(
                m, point_rows[0, i], sums
            )
            out[6, k], out[7, k] = state_rows[7, i], state_rows[8, i]
