"""The points of a tensor grid: between nodes in tiles, directly elsewhere.

Points next to branch points, whose bounds would be above :data:`~floquet.period_map.precise.TOLERANCE`, points whose
branch is in doubt and points that no box carries are solved as if there were no grid.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..kernels import available
from ..kernels.grid import FIELDS, LEFT_OUT, Tile, cardinals
from ..periodic import PeriodicSystem
from .chebyshev import Box
from .hill import hill_map
from .precise import TOLERANCE
from .result import PeriodMap

__all__ = ["UNTOUCHED", "direct_map", "remaining", "tiles"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

UNTOUCHED = LEFT_OUT - 1  # in place of a method: no box carries the point
DIRECTLY = 16384  # points solved directly at once
ROWS_A_TILE, POINTS_A_TILE = 64, 65536  # the polynomials of columns are made once for all rows of a tile


def tiles(box: Box) -> Iterator[Tile]:
    """The points of a box, some at a time.

    Rows and columns of a tile are the last two axes, for every place on the others.  Where there is one axis the rows
    are places, each a node of its own.
    """
    firsts, added = box.region.places()
    values = np.moveaxis(box.values, 0, -2)  # (b, …, 7, columns' nodes)
    if len(added) == 1:
        for i in range(0, len(firsts), ROWS_A_TILE):
            some = slice(i, i + ROWS_A_TILE)
            rows = np.arange(len(firsts[some]), dtype=float)
            yield from _tiles(box, some, values[some], (rows, np.ones_like(rows)), rows, firsts[some])
        return
    x = box.region.values
    for i, first in enumerate(firsts):
        one, across = slice(i, i + 1), (box.nodes[-2], box.weights[-2])
        if len(added) == 2:
            yield from _tiles(box, one, values[i], across, x[0], first + added[0])
            continue
        for place, e in zip(added[0], cardinals(x[0], box.nodes[0], box.weights[0]), strict=True):
            weight = np.repeat(e[:, None], len(FIELDS), axis=1)
            weight[:, -1] = np.abs(e)
            plane = np.einsum("af,abfc->bfc", weight, values[i])
            yield from _tiles(box, one, plane, across, x[1], first + place + added[1])


def _tiles(
    box: Box, some: slice, values: Array, across: tuple[Array, Array], x: Array, row_places: Places
) -> Iterator[Tile]:
    """Rows at ``x`` of places ``some``, from nodes and weights ``across``."""
    z, column_places = box.region.values[-1], box.region.places()[1][-1]
    units, alpha_errors = (
        np.ascontiguousarray(np.broadcast_to(v[some], x.shape)) for v in (box.units, box.alpha_errors)
    )
    panels = np.ascontiguousarray(np.broadcast_to(box.panels[some], x.shape))
    rows = min(len(x), ROWS_A_TILE)
    columns = POINTS_A_TILE // rows
    for i, j in itertools.product(range(0, len(x), rows), range(0, len(z), columns)):
        yield Tile(
            values=np.ascontiguousarray(values),
            x=x[i : i + rows],
            x_nodes=across[0],
            x_weights=across[1],
            z=z[j : j + columns],
            z_nodes=box.nodes[-1],
            z_weights=box.weights[-1],
            row_places=row_places[i : i + rows],
            column_places=column_places[j : j + columns],
            units=units[i : i + rows],
            alpha_errors=alpha_errors[i : i + rows],
            panels=panels[i : i + rows],
            period=box.region.grid.system.period,
            most=TOLERANCE,
        )


def remaining(methods: NDArray[np.int8]) -> list[Places]:
    """What is to be solved directly, by what stands in place of a method, some points at a time."""
    index = np.flatnonzero(methods < 0)
    return [index[i : i + DIRECTLY] for i in range(0, len(index), DIRECTLY)]


def direct_map(system: PeriodicSystem, index: Places) -> PeriodMap:
    """The map of some cases, an index along all of them, with the last digits that many have."""
    return hill_map(system.part(index), compiled=available())
