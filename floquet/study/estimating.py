"""What a run will make, of how much it is there already, and about how long the rest takes."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from .. import store
from ..kernels import cores
from ..rotor import Hub
from ..studyfile import Study
from ..sweep import Plan
from .extending import known
from .folder import parts_of
from .shards import Parts, Shard, all_shards, make, sizes_of

BYTES_A_VALUE = 4.0  # of 8, after compression, where no sample is made: measured on the validity study
SAMPLE = {"points": 4096, "limits": 8}  # rows, designs of the first shard that is timed
LONG = 0.5  # seconds: a shard that takes them tells the pace
START = 2.0  # seconds that a process takes until it computes


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a run will make.

    ``copied`` are the points that --extend takes from the database, ``kept`` the shards that --resume goes on from.
    ``seconds``, for what is left, and ``bytes``, of the whole database, are estimates from a sample; without one
    ``seconds`` is nan and ``bytes`` rough.
    """

    designs: int
    points: int
    limits: int
    shards: int
    copied: int = 0
    kept: int = 0
    bytes: int
    seconds: float = math.nan


def dry_run(
    study: Study, *, workers: int = 0, out: str | Path | None = None, resume: bool = False, extend: bool = False
) -> Estimate:
    """Sizes of a study without running it; with a number of workers also about how long a run to ``out`` will take.

    That is found by making a few shards in a folder that is removed, each twice as large as the one before it, for
    about a second a table.
    """
    plan, sizes = study.plan, sizes_of(study.plan)
    counts = {"points": plan.points, "limits": plan.designs if plan.tolerances else 0}
    left, copied, kept = dict(counts), 0, 0
    if extend and out is not None:
        there = known(Path(out), study)
        copied = there.points
        left = {"points": plan.points - copied, "limits": int((there.limits[:, 0] < 0).sum()) if plan.tolerances else 0}
    if resume and out is not None:
        made = [s for s in all_shards(plan, sizes) if (parts_of(out) / s.file).exists()]
        kept = len(made)
        for shard in made:
            left[shard.table] = max(0, left[shard.table] - (shard.stop - shard.start))
    rows = {"points": plan.points, "limits": _modes(plan) * len(plan.tolerances)}
    size = sum(rows[t] * len(store.stored_variables(c)) * BYTES_A_VALUE for t, c in _columns(study).items())
    seconds = math.nan
    if workers:
        found = _sampled(study, workers)
        size = sum(s.size * counts[t] for t, s in found.items())
        at_once = min(workers, cores(), len(all_shards(plan, sizes)))
        seconds = sum(s.seconds * left[t] for t, s in found.items()) / at_once + (START if workers > 1 else 0.0)
    return Estimate(
        designs=plan.designs,
        points=plan.points,
        limits=rows["limits"],
        shards=len(all_shards(plan, sizes)),
        copied=copied,
        kept=kept,
        bytes=int(size),
        seconds=seconds,
    )


def _columns(study: Study) -> dict[str, Mapping[str, store.Column]]:
    return {"points": {name: store.POINTS[name] for name in study.columns}, "limits": store.LIMITS}


def _modes(plan: Plan) -> int:
    """Modes of all designs, of each of which there is a limit a tolerance."""
    modes = {Hub.ARTICULATED: 3, Hub.TEETERING: 2}
    return sum(
        math.prod(r.shape) * (modes[r.hub] + (r.hub == Hub.ARTICULATED and r.blades % 2 == 0 and r.blades >= 4))
        for r in plan.rotors
    )


@dataclass(frozen=True)
class _Sample:
    """What a row of points, or a design of limits, takes: seconds of one process, bytes on disk."""

    seconds: float
    size: float


def _sampled(study: Study, workers: int) -> dict[str, _Sample]:
    """A sample of each table, on one thread where there are several workers: as every one of them has it."""
    sizes, counts = sizes_of(study.plan), {"points": study.plan.points, "limits": study.plan.designs}
    threads = os.environ.get("FLOQUET_THREADS")
    with tempfile.TemporaryDirectory(prefix="floquet-") as folder:
        parts = Parts(Path(folder), study.id, study.columns)
        try:
            if workers > 1:
                os.environ["FLOQUET_THREADS"] = "1"
            return {t: _sample(study.plan, parts, t, min(sizes[t], counts[t])) for t in sizes if counts[t]}
        finally:
            os.environ.pop("FLOQUET_THREADS", None)
            if threads is not None:
                os.environ["FLOQUET_THREADS"] = threads


def _sample(plan: Plan, parts: Parts, table: str, most: int) -> _Sample:
    """Of a shard in the middle of the table."""
    size, count = min(SAMPLE[table], most), plan.points if table == "points" else plan.designs

    def made() -> _Sample:
        start = (count - size) // 2
        shard = Shard(table, start, start + size)
        began = time.perf_counter()
        make(plan, shard, parts)
        took, place = time.perf_counter() - began, parts.folder / shard.file
        with store.open_file(place) as file:
            stored = file.size(table)
        place.unlink()
        return _Sample(took / size, stored / size)

    made()  # what is compiled once is not timed
    while (found := made()).seconds * size < LONG and size < most:
        size = min(2 * size, most)
    return found
