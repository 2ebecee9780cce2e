"""One scalar equation over a tensor grid of parameters: exponents of the polynomials between nodes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..kernels import cores, keep_memory
from ..kernels.grid import Exponents, Tile, close_tile
from ..period_map import Method
from ..period_map.chebyshev import boxes, regions
from ..period_map.grid import UNTOUCHED, direct_map, remaining, tiles
from ..period_map.tensor import TensorGrid
from .hill import of_hill
from .result import PER_CASE, PER_STATE, Stability

__all__ = ["of_grid"]

T = TypeVar("T")
LINE = 64  # bytes of a line of the processor's cache
TOGETHER = 16  # batches of nodes whose boxes are in memory at once


def of_grid(grid: TensorGrid) -> Stability:
    """Exponents of all cases, by all cores; the answers do not depend on how many."""
    n, shape = math.prod(grid.shape), grid.shape
    keep_memory()
    fields = _room(n)
    fields["method"][:] = UNTOUCHED
    as_they_lie = {name: values.view(float).reshape(-1) for name, values in fields.items() if name in PER_STATE}
    out = Exponents(**(fields | as_they_lie))

    def close(tile: Tile) -> None:
        close_tile(tile, int(Method.MAP), out)

    def solve(some: NDArray[np.intp]) -> None:
        found = of_hill(direct_map(grid.system, some), compiled=True)
        for name, values in fields.items():
            values[some] = getattr(found, name)

    with ThreadPoolExecutor(cores()) as pool:
        for some in _by(TOGETHER, regions(grid)):
            found = [box for each in pool.map(boxes, some) for box in each]
            list(pool.map(close, (tile for box in found for tile in tiles(box))))
        list(pool.map(solve, remaining(out.method)))
    shaped: dict[str, Any] = {
        name: v.reshape(*shape, 2) if name in PER_STATE else v.reshape(shape) for name, v in fields.items()
    }
    return Stability(period=grid.system.period, **shaped)


def _room(n: int) -> dict[str, NDArray[Any]]:
    """Arrays for n cases, side by side in one: the system hands out large pages, and no small ones at their ends."""
    shapes: dict[str, tuple[tuple[int, ...], Any]] = {k: ((n, 2), np.dtype(v)) for k, v in PER_STATE.items()}
    shapes |= {k: ((n,), np.dtype(v)) for k, v in PER_CASE.items()}
    sizes = [math.prod(shape) * kind.itemsize for shape, kind in shapes.values()]
    starts = np.cumsum([0, *(-(-size // LINE) * LINE for size in sizes)])
    room = np.empty(starts[-1], np.uint8)
    return {
        name: room[start : start + size].view(kind).reshape(shape)
        for (name, (shape, kind)), start, size in zip(shapes.items(), starts[:-1].tolist(), sizes, strict=True)
    }


def _by(count: int, values: Iterable[T]) -> Iterator[list[T]]:
    """Lists of so many, as they come."""
    source = iter(values)
    while part := list(islice(source, count)):
        yield part
