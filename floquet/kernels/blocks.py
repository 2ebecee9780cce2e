"""The arithmetic of :mod:`quadratics` and :mod:`pairing`, compiled as it stands for blocks of sixteen points."""

from __future__ import annotations

import math
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import lanes, pairing, quadratics
from .compiler import inlined, kernel
from .lanes import WIDTH

__all__ = ["compare", "solve"]

Array = NDArray[np.float64]
PRIMITIVES: dict[str, Any] = {"select": lanes.where, "somewhere": lanes.any_lane, "sqrt": math.sqrt}
as_lanes: Any = lanes.as_lanes
scratch: Any = lanes.scratch


def compiled(module: ModuleType) -> dict[str, Any]:
    """The functions of a module that take numbers, calling one another and the primitives of lanes."""
    world = {**vars(module), **PRIMITIVES}
    for name in vars(module)["ARITHMETIC"]:
        world[name] = inlined(FunctionType(vars(module)[name].__code__, world, name))
    return world


def blocks_of(rows: Array) -> Array:
    """Rows (..., points) as (..., blocks, 16); spare lanes repeat the last point."""
    points = rows.shape[-1]
    spare = -points % WIDTH
    if spare:
        rows = np.concatenate([rows, np.broadcast_to(rows[..., -1:], (*rows.shape[:-1], spare))], axis=-1)
    return np.ascontiguousarray(rows).reshape(*rows.shape[:-1], -1, WIDTH)


def points_of(blocks: Array, points: int) -> Array:
    """The rows again."""
    return blocks.reshape(*blocks.shape[:-2], -1)[..., :points]


# ---------------------------------------------------------------------- eigenvalues
_solved = compiled(quadratics)["solved"]


@kernel
def _solve(damping: Any, stiffness: Any, cosines: Any, roots: Any, errors: Any, doubts: Any) -> None:
    D, K, z, bound, doubt = as_lanes(damping), as_lanes(stiffness), as_lanes(roots), as_lanes(errors), as_lanes(doubts)
    q = as_lanes(scratch(9).reshape(3, 3, WIDTH))
    for b in range(D.shape[1]):
        _solved(D, K, b, q, cosines, z, bound, doubt)


def solve(D: Array, K: Array, cosines: tuple[float, ...]) -> tuple[Array, Array, Array]:
    """Roots (2n, 2, points), bounds (2n, points) and doubts (points,) for D and K (n², points)."""
    d, k, n, points = blocks_of(D), blocks_of(K), len(cosines), D.shape[1]
    roots, errors, doubts = (np.empty((*rows, *d.shape[1:])) for rows in ((2 * n, 2), (2 * n,), ()))
    _solve(d, k, cosines, roots, errors, doubts)
    return points_of(roots, points), points_of(errors, points), points_of(doubts, points)


# ---------------------------------------------------------------------- pairs
_world = compiled(pairing)
_world["cheapest"] = _world["tried"]
_compared = _world["compared"]


@kernel
def _compare(
    state: Any, values: Any, modes: Any, orders: Any, twos: Any, needed: Any,
    exact: Any, pairs: Any, errors: Any, kinds: Any,
) -> None:  # fmt: skip
    m = len(modes)
    s, v, x, p = as_lanes(state), as_lanes(values), as_lanes(exact), as_lanes(pairs)
    e, k, room = as_lanes(errors), as_lanes(kinds), as_lanes(scratch((2 * m + 1) * m).reshape(2 * m + 1, m, WIDTH))
    for b in range(s.shape[1]):
        _compared(s, v, modes, orders, twos, needed, room, b, x, p, e, k)


def compare(state: Array, values: Array, modes: Array) -> tuple[Array, ...]:
    """Targets, pairs, errors (m, 4, points) and kinds (m, 2, points) of points, see :mod:`pairing`."""
    s, v = blocks_of(state), blocks_of(values)
    out = tuple(np.empty((len(modes), rows, *s.shape[1:])) for rows in (4, 4, 4, 2))
    _compare(s, v, modes, *pairing.tables(len(modes)), *out)
    return tuple(points_of(x, state.shape[1]) for x in out)
