"""The points of a tensor grid: between nodes in tiles, directly elsewhere.

Points next to branch points, whose bounds would be above :data:`~floquet.period_map.precise.TOLERANCE`, and points
whose branch is in doubt are solved directly, in doubles: forty digits would cost more than all other points together.
Points that no box carries are solved as if there were no grid.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..kernels import available
from ..kernels.grid import FIELDS, LEFT_OUT, Tile, cardinals, judged, tile_rows
from ..kernels.hill import ROWS
from ..periodic import PeriodicSystem
from .chebyshev import Box, boxes
from .hill import hill_map
from .precise import TOLERANCE
from .result import Method, PeriodMap
from .tensor import TensorGrid

__all__ = ["UNTOUCHED", "direct_map", "grid_map", "remaining", "tiles"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

UNTOUCHED = LEFT_OUT - 1  # in place of a method: no box carries the point
DIRECTLY = 16384  # points solved directly at once
ROWS_A_TILE, POINTS_A_TILE = 64, 65536  # the polynomials of columns are made once for all rows of a tile


def tiles(box: Box) -> Iterator[Tile]:
    """The points of a box, some at a time: rows and columns, for every place on the first of three axes."""
    first, added = box.region.places()
    x, values = box.region.values, np.moveaxis(box.values, 0, -2)  # (…, 7, columns' nodes)
    if len(x) == 3:
        for place, e in zip(added[0], cardinals(x[0], box.nodes[0], box.weights[0]), strict=True):
            weight = np.repeat(e[:, None], len(FIELDS), axis=1)
            weight[:, -1] = np.abs(e)
            plane = np.ascontiguousarray(np.einsum("af,abfc->bfc", weight, values))
            yield from _tiles(box, plane, x[1:], added[1:], first + int(place))
    elif len(x) == 2:
        yield from _tiles(box, np.ascontiguousarray(values), x, added, first)
    else:
        one = np.zeros(1)  # row, at its one node
        yield from _tiles(box, np.ascontiguousarray(values[None]), (one, *x), (one.astype(np.intp), *added), first)


def _tiles(box: Box, values: Array, x: tuple[Array, ...], added: tuple[Places, ...], first: int) -> Iterator[Tile]:
    nodes, weights = box.nodes[-2:], box.weights[-2:]
    if len(nodes) == 1:
        nodes, weights = (np.zeros(1), *nodes), (np.ones(1), *weights)
    rows = min(len(x[0]), ROWS_A_TILE)
    columns = POINTS_A_TILE // rows
    for i, j in itertools.product(range(0, len(x[0]), rows), range(0, len(x[1]), columns)):
        yield Tile(
            values=values,
            x=x[0][i : i + rows],
            x_nodes=nodes[0],
            x_weights=weights[0],
            z=x[1][j : j + columns],
            z_nodes=nodes[1],
            z_weights=weights[1],
            row_places=first + added[0][i : i + rows],
            column_places=added[1][j : j + columns],
            unit=box.unit,
            period=box.region.grid.system.period,
            most=TOLERANCE,
            panels=box.panels,
        )


def remaining(methods: NDArray[np.int8]) -> list[tuple[Places, bool]]:
    """What is to be solved directly, by what stands in place of a method: some points and whether nodes carry them."""
    found = [(np.flatnonzero(methods == code), code == LEFT_OUT) for code in (LEFT_OUT, UNTOUCHED)]
    return [(index[i : i + DIRECTLY], carried) for index, carried in found for i in range(0, len(index), DIRECTLY)]


def direct_map(system: PeriodicSystem, index: Places, carried: bool) -> PeriodMap:
    """The map of some cases, an index along all of them.

    Products of large entries are rounded by more than the panels' allowances in one of a million points; det Φ tells.
    """
    if not carried:
        return hill_map(system.part(index))
    phi = hill_map(system.part(index), precise=False, compiled=available())
    assert phi.rows is not None
    m, large = tuple(phi.rows[:4]), np.abs(phi.rows[1] * phi.rows[2]) > 1.0  # else Φ may be near ±I, and D near h²
    phi.rows[5] = np.where(large, np.maximum(phi.rows[5], judged(m, phi.rows[4])[1]), phi.rows[5])
    return phi


def grid_map(system: PeriodicSystem) -> PeriodMap:
    """The map of all cases of one scalar equation."""
    grid, shape = TensorGrid.of(system), system.cases
    n = math.prod(shape)
    rows, alpha = np.empty((len(ROWS), n)), np.empty(n)
    panels, methods = np.zeros(n, np.int32), np.full(n, UNTOUCHED, np.int8)
    for box in (box for region in (grid.regions() if grid else ()) for box in boxes(region)):
        for tile in tiles(box):
            places = (tile.row_places[:, None] + tile.column_places).ravel()
            rows[:, places], alpha[places], kept = tile_rows(tile)
            panels[places], methods[places] = box.panels, np.where(kept, Method.MAP, LEFT_OUT)
    for index, carried in remaining(methods):
        phi = direct_map(system, index, carried)
        assert phi.rows is not None and phi.methods is not None
        rows[:, index], alpha[index], panels[index], methods[index] = phi.rows, phi.mean, phi.panels, phi.methods
    return PeriodMap(
        method=Method.MAP, period=system.period, shape=shape, mean=alpha, panels=panels, rows=rows, methods=methods
    )
