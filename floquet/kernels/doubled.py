"""Hill's equation in pairs of doubles (:mod:`floquet.kernels.pairs`): what ``hill_lanes`` does, with twice the digits.

A panel's series goes to order :data:`ORDER`; loops over lanes stand within loops over orders, and numbers are rows of
heads and of tails, row r of lane i at r·WIDTH + i.  Errors are weighed in doubles by the sweep of ``hill_lanes``,
:data:`SCALE` times too large, so that its own allowances are those of pairs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .compiler import unfused_kernel
from .hill import COEFFICIENTS, EPS
from .hill_lanes import LANES, unit, weigh
from .pairs import accumulated, added, multiplied, negative, normal, pure, scaled

__all__ = ["ORDER", "map_pairs"]

ORDER = 44
WIDTH = 8
SCALE = 2.0**48  # pairs round to 2^-104 at worst: an allowance of 2 eps is then one of 32 of their units
K = ORDER + 1


@pure
def at(x: Any, row: int, i: int) -> Any:
    """A number: rows come in twos, head and tail."""
    return x[2 * row * WIDTH + i], x[(2 * row + 1) * WIDTH + i]


@pure
def put(x: Any, row: int, i: int, value: Any) -> None:
    x[2 * row * WIDTH + i], x[(2 * row + 1) * WIDTH + i] = value


@pure
def known(table: Any, k: int) -> Any:
    """A number of a table (n, 2)."""
    return table[k, 0], table[k, 1]


@unfused_kernel
def coefficients(q: Any, cosines: Any, weights: Any, p: Any) -> None:
    """p_k of -h² q about the centre: ``cosines`` (4, 2), ``weights`` (2 (ORDER-1), 2) of harmonics 1, 2 in turn."""
    c1, s1, c2, s2 = known(cosines, 0), known(cosines, 1), known(cosines, 2), known(cosines, 3)
    for k in range(ORDER - 1):
        w1, w2 = known(weights, 2 * k), known(weights, 2 * k + 1)
        for i in range(WIDTH):
            a1, b1, a2, b2 = at(q, 1, i), at(q, 2, i), at(q, 3, i), at(q, 4, i)
            if k % 2 == 0:
                one = added(multiplied(a1, c1), multiplied(b1, s1))
                two = added(multiplied(a2, c2), multiplied(b2, s2))
            else:
                one = added(multiplied(b1, c1), negative(multiplied(a1, s1)))
                two = added(multiplied(b2, c2), negative(multiplied(a2, s2)))
            value = added(multiplied(one, w1), multiplied(two, w2))
            put(p, k, i, added(value, multiplied(at(q, 0, i), w1)) if k == 0 else value)


@unfused_kernel
def series(p: Any, inverse: Any, u: Any, v: Any, total: Any) -> None:
    """Taylor coefficients of the two solutions whose first two stand in u and v."""
    for k in range(ORDER - 1):
        total[:] = 0.0
        for j in range(k, -1, -1):
            for i in range(WIDTH):
                put(total, 0, i, accumulated(at(total, 0, i), at(p, j, i), at(u, k - j, i)))
                put(total, 1, i, accumulated(at(total, 1, i), at(p, j, i), at(v, k - j, i)))
        for i in range(WIDTH):
            put(u, k + 2, i, multiplied(normal(*at(total, 0, i)), known(inverse, k)))
            put(v, k + 2, i, multiplied(normal(*at(total, 1, i)), known(inverse, k)))


@unfused_kernel
def ends(y: Any, found: Any) -> None:
    """y(1), y(-1), y'(1), y'(-1) of Taylor coefficients."""
    for i in range(WIDTH):
        even, odd, rate_even, rate_odd = (0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)
        for k in range(ORDER, -1, -1):
            value = at(y, k, i)
            rate = scaled(value, float(k))
            if k % 2 == 0:
                even, rate_even = added(even, value), added(rate_even, rate)
            else:
                odd, rate_odd = added(odd, value), added(rate_odd, rate)
        put(found, 0, i, added(even, odd))
        put(found, 1, i, added(even, negative(odd)))
        put(found, 2, i, added(rate_odd, rate_even))
        put(found, 3, i, added(rate_odd, negative(rate_even)))


@unfused_kernel
def panel(u: Any, v: Any, of_u: Any, of_v: Any, m: Any, step: Any, first: int) -> None:
    """F from the ends of both solutions, and its product with m; heads and the truncation go to ``step``."""
    for i in range(WIDTH):
        up, um, udp, udm = at(of_u, 0, i), at(of_u, 1, i), at(of_u, 2, i), at(of_u, 3, i)
        vp, vm, vdp, vdm = at(of_v, 0, i), at(of_v, 1, i), at(of_v, 2, i), at(of_v, 3, i)
        f0 = added(multiplied(up, vdm), negative(multiplied(vp, udm)))
        f1 = added(multiplied(vp, um), negative(multiplied(up, vm)))
        f2 = added(multiplied(udp, vdm), negative(multiplied(vdp, udm)))
        f3 = added(multiplied(vdp, um), negative(multiplied(udp, vm)))
        m0, m1, m2, m3 = at(m, 0, i), at(m, 1, i), at(m, 2, i), at(m, 3, i)
        put(m, 0, i, added(multiplied(f0, m0), multiplied(f1, m2)))
        put(m, 1, i, added(multiplied(f0, m1), multiplied(f1, m3)))
        put(m, 2, i, added(multiplied(f2, m0), multiplied(f3, m2)))
        put(m, 3, i, added(multiplied(f2, m1), multiplied(f3, m3)))
        last = 0.0
        for k in range(ORDER - 1, K):
            last += k * (abs(u[2 * k * WIDTH + i]) + abs(v[2 * k * WIDTH + i]))
        size = abs(up[0]) + abs(um[0]) + abs(udp[0]) + abs(udm[0]) + abs(vp[0]) + abs(vm[0]) + abs(vdp[0]) + abs(vdm[0])
        lane = first + i
        step[lane], step[LANES + lane], step[2 * LANES + lane], step[3 * LANES + lane] = f0[0], f1[0], f2[0], f3[0]
        for r in range(4):
            step[(4 + r) * LANES + lane] = m[2 * r * WIDTH + i]
        step[8 * LANES + lane] = SCALE * last * size


@unfused_kernel
def map_pairs(q: Any, size: Any, cosines: Any, weights: Any, inverse: Any, half: float, out: Any) -> None:
    """Rows (9, n) of points with equal panels: ``q`` (5, 2, n), ``cosines`` (panels, 4, 2) of the centres."""
    n, panels = q.shape[2], len(cosines)
    steps, rows = np.empty((panels + 1, 9 * LANES)), np.empty(10 * WIDTH)
    p, u, v = np.zeros(2 * K * WIDTH), np.zeros(2 * K * WIDTH), np.zeros(2 * K * WIDTH)
    of_u, of_v, total = np.empty(8 * WIDTH), np.empty(8 * WIDTH), np.empty(4 * WIDTH)
    m, maps = np.empty(8 * WIDTH), np.empty((LANES // WIDTH, 8 * WIDTH))
    state, point = np.empty(9 * LANES), np.empty(2 * LANES)
    u[:WIDTH], v[2 * WIDTH : 3 * WIDTH] = 1.0, 1.0
    for start in range(0, n, LANES):
        count = min(LANES, n - start)
        groups = -(-count // WIDTH)
        unit(steps[0, 4 * LANES :])
        for g in range(groups):
            for i in range(WIDTH):
                k = start + min(g * WIDTH + i, count - 1)
                for r in range(5):
                    rows[2 * r * WIDTH + i], rows[(2 * r + 1) * WIDTH + i] = q[r, 0, k], q[r, 1, k]
                point[LANES + g * WIDTH + i] = EPS * COEFFICIENTS * half * half * size[k]
            m[:] = 0.0
            m[:WIDTH], m[6 * WIDTH : 7 * WIDTH] = 1.0, 1.0
            for s in range(panels):
                coefficients(rows, cosines[s], weights, p)
                series(p, inverse, u, v, total)
                ends(u, of_u)
                ends(v, of_v)
                panel(u, v, of_u, of_v, m, steps[s + 1], g * WIDTH)
            maps[g] = m
        weigh(steps, panels, state, point, groups * WIDTH)
        for i in range(count):
            finish(maps[i // WIDTH], i % WIDTH, state, i, half, out, start + i)


@unfused_kernel
def finish(m: Any, i: int, state: Any, lane: int, half: float, out: Any, k: int) -> None:
    """The rows of a point; D from the pairs, each bound with what its double is rounded."""
    m0, m1, m2, m3 = at(m, 0, i), at(m, 1, i), at(m, 2, i), at(m, 3, i)
    mean = scaled(added(m0, negative(m3)), 0.5)
    D = added(multiplied(mean, mean), multiplied(m1, m2))[0]
    of_tau, of_D = state[4 * LANES + lane] / SCALE, state[5 * LANES + lane] / SCALE
    of_all = state[6 * LANES + lane] / SCALE
    out[0, k], out[1, k], out[2, k], out[3, k] = m0[0], m1[0] * half, m2[0] / half, m3[0]
    out[4, k] = 0.5 * of_tau + 0.5 * EPS * (abs(m0[0]) + abs(m3[0]))
    out[5, k] = of_D + of_all * of_all + EPS * abs(D)
    out[6, k], out[7, k], out[8, k] = state[7 * LANES + lane], state[8 * LANES + lane], D
