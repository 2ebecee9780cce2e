"""Which designs are the same, bit for bit: of a plan, and of the rows of databases, in forty bytes a design.

A design is known by a mark of 128 bits, two sums over the bits x_j of its parameters, modulo 2^64, mixed as in the
generator SplitMix64, m of Steele, Lea and Flood (2014)::

    mark_k = m(… m(m(k) + x_1) + x_2 …)        k = 1, 2

so that of 10⁷ designs two others have one mark with a probability of 10⁻²⁵.  Rows of a design follow one another; what
stands in them beside the design, such as its advance ratios, is kept once for all designs that have the same.
"""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import store
from ..rotor import PARAMETERS
from ..sweep import Plan

__all__ = ["DESIGN", "Runs", "first_of", "marks", "of_plan", "runs"]

Array = NDArray[Any]
Marks = NDArray[np.uint64]
DESIGN = (*(p.name for p in PARAMETERS), "blades", "hub")
TOGETHER = 2**16  # designs of a plan that are marked at a time


@dataclass(frozen=True, eq=False, kw_only=True)
class Runs:
    """The designs of a table as they follow one another, n of them.

    Attributes
    ----------
    marks : (n, 2) array
    start, stop : (n,) arrays
        First row, and the one after the last.
    which : (n,) array
        Which of ``beside`` a design has.
    beside : tuple of (rows, columns) arrays
        What stands beside a design, each once.
    """

    marks: Marks
    start: NDArray[np.int64]
    stop: NDArray[np.int64]
    which: NDArray[np.intp]
    beside: tuple[NDArray[np.float64], ...]


def marks(rows: Mapping[str, Array]) -> Marks:
    """(n, 2) what designs are known by."""
    columns = [np.asarray(rows[name], "<f8").view("<u8") for name in DESIGN]
    out = np.empty((len(columns[0]), 2), np.uint64)
    for k in (0, 1):
        state = np.full(len(columns[0]), k + 1, np.uint64)
        for bits in columns:
            state = _mixed(_mixed(state) + bits)
        out[:, k] = state
    return out


def _mixed(state: Marks) -> Marks:
    state = state + np.uint64(0x9E3779B97F4A7C15)
    state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed: Marks = state ^ (state >> np.uint64(31))
    return mixed


def of_plan(plan: Plan) -> Marks:
    """(designs, 2) those of a plan."""
    out = np.empty((plan.designs, 2), np.uint64)
    for start in range(0, plan.designs, TOGETHER):
        some = np.arange(start, min(start + TOGETHER, plan.designs))
        values, hubs, blades = plan.parameters(some)
        out[some] = marks({**values, "blades": blades, "hub": hubs})
    return out


def first_of(wanted: Marks, there: Marks) -> NDArray[np.intp]:
    """(n,) the first place among ``there`` of each that is wanted, −1 for none.

    They are looked up by their second half: of two that share it and are not the same one may not be found.
    """
    if not len(there):
        return np.full(len(wanted), -1, np.intp)
    order = np.lexsort(there.T)
    sorted_ = there[order]
    new = np.r_[True, (np.diff(sorted_, axis=0) != 0).any(axis=1)]
    order, sorted_ = order[new], sorted_[new]
    place = np.searchsorted(sorted_[:, 1], wanted[:, 1])
    place[place == len(sorted_)] = 0
    return np.where((sorted_[place] == wanted).all(axis=1), order[place], -1)


def runs(file: store.File, table: str, beside: Sequence[str]) -> Runs:
    """The designs of a table, and what of these columns stands beside them."""
    numbers: dict[bytes, int] = {}
    which, starts, marked = array("q"), [np.zeros(0, np.int64)], [np.empty((0, 2), np.uint64)]
    last, beside_last = -1, b""
    for first, rows in file.chunks(table, ["rotor", *DESIGN, *beside]):
        begins = np.flatnonzero(np.diff(rows["rotor"], prepend=last))
        last = int(rows["rotor"][-1])
        joined = np.ascontiguousarray(np.stack([np.asarray(rows[name], "<f8") for name in beside], axis=1))
        ends = [*begins.tolist(), len(joined)]
        beside_last += joined[: ends[0]].tobytes()
        for a, b in pairwise(ends):
            if first + a:
                which.append(numbers.setdefault(beside_last, len(numbers)))
            beside_last = joined[a:b].tobytes()
        starts.append(first + begins)
        marked.append(marks({name: rows[name][begins] for name in DESIGN}))
    if last >= 0:
        which.append(numbers.setdefault(beside_last, len(numbers)))
    start = np.concatenate(starts)
    return Runs(
        marks=np.concatenate(marked),
        start=start,
        stop=np.append(start[1:], file.rows(table))[: len(start)],
        which=np.array(which, np.intp),
        beside=tuple(np.frombuffer(bits, "<f8").reshape(-1, len(beside)) for bits in numbers),
    )
