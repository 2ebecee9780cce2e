"""Tensor grids: loops over lanes, which numba turns into wide registers.

A tile is worked in blocks of :data:`~floquet.kernels.hill_lanes.LANES` columns.  The polynomials of a block are made
once for all its rows.  Everything from the nodes to the exponents happens in the scratch of a block.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import grid, lanes
from .compiler import inlined, kernel
from .grid import FIELDS, LEFT_OUT, NONE, TINY
from .hill_lanes import LANES, close_block, select
from .lanes import WIDTH

__all__ = ["close_tile"]

GROUPS = LANES // WIDTH  # of lanes in a block
SIGNED, ALL = len(FIELDS) - 1, len(FIELDS)
as_lanes: Any = lanes.as_lanes
scratch: Any = lanes.scratch
spread: Any = lanes.spread
where: Any = lanes.where


_judged = inlined(grid.judged)
_zeros_of, _within = inlined(grid.zeros_of, select=select), inlined(grid.within, select=select)


@kernel
def cardinals(x: Any, nodes: Any, weights: Any, out: Any) -> None:
    """ℓ_j of a block: x (groups,), out (groups, nodes) of Lanes."""
    for g in range(GROUPS):
        total = spread(0.0)
        for j in range(len(nodes)):
            distance = x[g] - nodes[j]
            term = weights[j] / where(distance == 0.0, spread(TINY), distance)
            out[g, j] = term
            total = total + term
        total = 1.0 / total
        for j in range(len(nodes)):
            e = out[g, j] * total
            out[g, j] = where(abs(e) < NONE, spread(0.0), e)


@kernel
def combined(r: Any, polynomials: Any, out: Any) -> None:
    """The fields of a block (7, groups) from those of a row at the columns' nodes (7, nodes), Σ_j r_fj ℓ_j."""
    nodes = r.shape[1]
    for g in range(GROUPS):
        a, b, c, d = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
        quarters, alpha, bound = spread(0.0), spread(0.0), spread(0.0)
        for j in range(nodes):
            e = polynomials[g, j]
            a, b, c, d = a + r[0, j] * e, b + r[1, j] * e, c + r[2, j] * e, d + r[3, j] * e
            quarters, alpha, bound = quarters + r[4, j] * e, alpha + r[5, j] * e, bound + r[6, j] * abs(e)
        out[0, g], out[1, g], out[2, g], out[3, g] = a, b, c, d
        out[4, g], out[5, g], out[6, g] = quarters, alpha, bound


@kernel
def mixed(values: Any, x: float, nodes: Any, weights: Any, out: Any) -> None:
    """The fields of a row at the columns' nodes (7, nodes), from those at all nodes (rows' nodes, 7, nodes)."""
    total = 0.0
    for a in range(len(nodes)):
        distance = x - nodes[a]
        total += weights[a] / (TINY if distance == 0.0 else distance)
    out[:] = 0.0
    for a in range(len(nodes)):
        distance = x - nodes[a]
        e = weights[a] / (TINY if distance == 0.0 else distance) / total
        if abs(e) < NONE:
            continue
        for f in range(ALL):
            factor = e if f < SIGNED else abs(e)
            for j in range(values.shape[2]):
                out[f, j] += factor * values[a, f, j]


@kernel
def judge_block(fields: Any, block: Any, kept: Any, unit: float, T: float, most: float) -> None:
    """Fields of a block → rows and α (10 rows), and 1 for points that are not left out."""
    for i in range(LANES):
        m = (fields[i], fields[LANES + i], fields[2 * LANES + i], fields[3 * LANES + i])
        tau_error = fields[6 * LANES + i]
        D, b = _judged(m, tau_error)
        zeros, certain = _zeros_of(m, fields[4 * LANES + i], unit)
        block[i], block[LANES + i], block[2 * LANES + i], block[3 * LANES + i] = m
        block[4 * LANES + i], block[5 * LANES + i], block[6 * LANES + i] = tau_error, b, zeros
        block[8 * LANES + i], block[9 * LANES + i] = D, fields[5 * LANES + i]
        kept[i] = 1.0 if certain and _within(D, b, tau_error, most, T) else 0.0


@kernel
def side_by_side(block: Any, found: Any, kept: Any, first: int, last: int, panels: int, code: int, out: Any) -> None:
    """Write a block whose points follow each other; loops short enough for wide registers."""
    exponents, errors = out.exponents[4 * first : 4 * last], out.exponent_errors[2 * first : 2 * last]
    rho, lock, defect = out.rotation_number[first:last], out.lock[first:last], out.determinant_defect[first:last]
    verdict, reason = out.verdict[first:last], out.reason[first:last]
    method, used = out.method[first:last], out.panels[first:last]
    count = last - first
    for i in range(count):
        alpha, growth, turning, locked = block[9 * LANES + i], found[i], found[LANES + i], found[2 * LANES + i] > 0.0
        exponents[4 * i], exponents[4 * i + 1] = alpha + growth, turning
        exponents[4 * i + 2], exponents[4 * i + 3] = alpha - growth, turning if locked else -turning
    for i in range(count):
        errors[2 * i], errors[2 * i + 1] = found[3 * LANES + i], found[3 * LANES + i]
    for i in range(count):
        turning, locked = found[LANES + i], found[2 * LANES + i] > 0.0
        rho[i], lock[i], defect[i] = turning, turning if locked else np.nan, found[6 * LANES + i]
    for i in range(count):
        verdict[i], reason[i] = np.int8(found[4 * LANES + i]), np.int8(found[5 * LANES + i])
    for i in range(count):
        method[i], used[i] = np.int8(code) if kept[i] > 0.0 else np.int8(LEFT_OUT), np.int32(panels)


@kernel
def apart(block: Any, found: Any, kept: Any, first: int, places: Any, panels: int, code: int, out: Any) -> None:
    """Write a block whose points are at ``first`` + ``places``."""
    for i in range(len(places)):
        k = first + places[i]
        alpha, growth, turning, locked = block[9 * LANES + i], found[i], found[LANES + i], found[2 * LANES + i] > 0.0
        out.exponents[4 * k], out.exponents[4 * k + 1] = alpha + growth, turning
        out.exponents[4 * k + 2], out.exponents[4 * k + 3] = alpha - growth, turning if locked else -turning
        out.exponent_errors[2 * k], out.exponent_errors[2 * k + 1] = found[3 * LANES + i], found[3 * LANES + i]
        out.rotation_number[k], out.lock[k] = turning, turning if locked else np.nan
        out.determinant_defect[k] = found[6 * LANES + i]
        out.verdict[k], out.reason[k] = np.int8(found[4 * LANES + i]), np.int8(found[5 * LANES + i])
        out.method[k], out.panels[k] = np.int8(code) if kept[i] > 0.0 else np.int8(LEFT_OUT), np.int32(panels)


@kernel
def close_tile(tile: Any, method: int, out: Any) -> None:
    """:func:`floquet.kernels.grid.close_tile`."""
    nodes = len(tile.z_nodes)
    rows = np.empty((len(tile.x), ALL, nodes))
    for r in range(len(tile.x)):
        mixed(tile.values, tile.x[r], tile.x_nodes, tile.x_weights, rows[r])
    columns, polynomials = scratch(GROUPS), as_lanes(scratch(GROUPS * nodes).reshape(GROUPS, nodes, WIDTH))
    z, fields = columns.reshape(-1), scratch(ALL * GROUPS)
    block, found = scratch(10 * GROUPS).reshape(-1), scratch(7 * GROUPS).reshape(-1)
    kept = scratch(GROUPS).reshape(-1)
    for start in range(0, len(tile.z), LANES):
        count = min(LANES, len(tile.z) - start)
        z[:] = tile.z[start + count - 1]  # spare lanes repeat the last column
        z[:count] = tile.z[start : start + count]
        cardinals(as_lanes(columns), tile.z_nodes, tile.z_weights, polynomials)
        places = tile.column_places[start : start + count]
        together = places[count - 1] - places[0] == count - 1 and np.all(places[1:] > places[:-1])
        for r in range(len(tile.x)):
            combined(rows[r], polynomials, as_lanes(fields.reshape(ALL, GROUPS, WIDTH)))
            judge_block(fields.reshape(-1), block, kept, tile.units[r], tile.period, tile.most)
            close_block(block, tile.alpha_errors[r], found, tile.period)
            first = tile.row_places[r]
            if together:
                first += places[0]
                side_by_side(block, found, kept, first, first + count, tile.panels[r], method, out)
            else:
                apart(block, found, kept, first, places, tile.panels[r], method, out)
