"""Shards: ranges of a study's tables, computed and written whole or not at all.

A shard is a pure function of the plan, the columns and its range, so running it again changes nothing.  Shards of many
points end where chunks of the database end: rows are computed chunk by chunk, and packing copies chunks as they are.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import store
from ..errors import FloquetError
from ..sweep import ENGINE, Plan, limit_rows, point_rows
from .extending import Known

Rows = dict[str, NDArray[Any]]
SHARDS = 32  # a study is cut into about so many, within these sizes:
POINT_SHARD = (4096, 10**6 // store.schema.CHUNK_ROWS * store.schema.CHUNK_ROWS)  # rows; a file takes the time of 4000
LIMIT_SHARD = (1, 2**14)  # designs; the largest of both take about half a minute of one processor
TOGETHER = 1024  # designs whose limits are computed at a time
TABLE_ROWS: dict[str, Callable[..., Rows]] = {"points": point_rows, "limits": limit_rows}


@dataclass(frozen=True)
class Shard:
    """A range of a table: rows of points, designs of limits."""

    table: str
    start: int
    stop: int

    @property
    def name(self) -> str:
        """Table and range, which the shard keeps as an attribute."""
        return f"{self.table}-{self.start:012d}-{self.stop:012d}"

    @property
    def file(self) -> str:
        """Its name in the folder."""
        return f"{self.name}.h5"

    def holds(self, rows: int) -> bool:
        """Whether so many rows are right: of limits at least one a design."""
        count = self.stop - self.start
        return rows == count if self.table == "points" else rows >= count


def sizes_of(plan: Plan) -> dict[str, int]:
    """Shard sizes, fixed for a study."""
    sizes = {"points": int(np.clip(math.ceil(plan.points / SHARDS), *POINT_SHARD))}
    if sizes["points"] > store.schema.CHUNK_ROWS:
        sizes["points"] = math.ceil(sizes["points"] / store.schema.CHUNK_ROWS) * store.schema.CHUNK_ROWS
    if plan.tolerances:
        sizes["limits"] = int(np.clip(math.ceil(plan.designs / SHARDS), *LIMIT_SHARD))
    return sizes


def all_shards(plan: Plan, sizes: Mapping[str, int]) -> list[Shard]:
    """All shards of these sizes; limits first, for they take longest."""
    counts = {"points": plan.points, "limits": plan.designs}
    return [
        Shard(t, i, min(i + sizes[t], counts[t]))
        for t in ("limits", "points")
        if t in sizes
        for i in range(0, counts[t], sizes[t])
    ]


def listed(table: str, count: int, size: int) -> list[Shard]:
    return [Shard(table, i, min(i + size, count)) for i in range(0, count, size)]


@dataclass(frozen=True)
class Parts:
    """The folder of shards of a study, the columns of points that they have, and what there is of their rows."""

    folder: Path
    study_id: str
    columns: tuple[str, ...]
    known: Known | None = None


def make(plan: Plan, shard: Shard, parts: Parts) -> str:
    """Compute a shard and write it: what a worker does."""
    out, columns = parts.folder / shard.file, {"points": parts.columns}
    about = {"study_id": parts.study_id, "engine_version": ENGINE, "shard": shard.name}
    wanted, blocks = (parts.columns,) if shard.table == "points" else (), _blocks(shard, plan)
    rows_of = TABLE_ROWS[shard.table] if parts.known is None else functools.partial(parts.known.rows, shard.table)
    made: Iterable[Rows] = (rows_of(plan, *block, *wanted) for block in blocks)
    count = shard.stop - shard.start
    if shard.table == "limits":  # how many rows they have is known when they are there
        made = list(made)
        count = sum(len(rows["rotor"]) for rows in made)
    with store.create(out, {shard.table: count}, about, columns=columns) as writers:
        for rows in made:
            writers[shard.table].add(rows)
    return shard.file


def _blocks(shard: Shard, plan: Plan) -> list[tuple[int, int]]:
    """Ranges that are computed at a time: of points the database's chunks, or whole designs that are mapped."""
    if shard.table == "limits":
        return list(pairwise([*range(shard.start, shard.stop, TOGETHER), shard.stop]))
    whole = plan.advance_ratio.size if plan.map else store.schema.CHUNK_ROWS
    step = whole * max(1, store.schema.CHUNK_ROWS // whole)
    inner = range((shard.start // step + 1) * step, shard.stop, step)
    return list(pairwise([shard.start, *inner, shard.stop]))


def ours(shard: Shard, parts: Parts) -> bool:
    """Whether a shard is there, of this study, of its range, with its columns."""
    try:
        with store.open_file(parts.folder / shard.file) as file:
            ours = (file.attributes.get("study_id"), file.attributes.get("shard")) == (parts.study_id, shard.name)
            complete = file.tables == (shard.table,) and shard.holds(file.rows(shard.table))
            return ours and complete and (shard.table != "points" or tuple(file.columns("points")) == parts.columns)
    except FloquetError:
        return False


def sound(shard: Shard, parts: Parts) -> bool:
    """Whether a shard is the right one and whole."""
    if not ours(shard, parts):
        return False
    with store.open_file(parts.folder / shard.file) as file:
        return file.intact()
