"""What a study will make, and about how long it takes."""

from __future__ import annotations

import math
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from .. import store
from ..kernels import cores
from ..rotor import Hub
from ..studyfile import Study
from .shards import Parts, Shard, all_shards, make, sizes_of

BYTES_A_VALUE = 4.0  # of 8, after compression: measured on the validity study
SAMPLE = {"points": 4096, "limits": 8}  # rows, designs of the first shard that is timed
LONG = 0.5  # seconds: a shard that takes them tells the pace
START = 2.0  # seconds that a process takes until it computes


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a study will make; ``seconds`` is an estimate from a sample, nan where none was computed."""

    designs: int
    points: int
    limits: int
    shards: int
    bytes: int
    seconds: float = math.nan


def dry_run(study: Study, *, workers: int = 0) -> Estimate:
    """Sizes of a study without running it; with a number of workers also about how long they will take.

    That is found by making a few shards in a folder that is removed, each twice as large as the one before it, for
    about a second a table.
    """
    plan = study.plan
    modes = {h: n for h, n in ((Hub.ARTICULATED, 3), (Hub.TEETERING, 2))}
    rows = sum(
        math.prod(r.shape) * (modes[r.hub] + (r.hub == Hub.ARTICULATED and r.blades % 2 == 0 and r.blades >= 4))
        for r in plan.rotors
    )
    limits = rows * len(plan.tolerances)
    stored = {"points": {name: store.POINTS[name] for name in study.columns}, "limits": store.LIMITS}
    sizes = {t: len(store.stored_variables(c)) * BYTES_A_VALUE for t, c in stored.items()}
    total = plan.points * sizes["points"] + limits * sizes["limits"]
    return Estimate(
        designs=plan.designs,
        points=plan.points,
        limits=limits,
        shards=len(all_shards(plan, sizes_of(plan))),
        bytes=int(total),
        seconds=_seconds(study, workers) if workers else math.nan,
    )


def _seconds(study: Study, workers: int) -> float:
    """About how long a run takes: the pace of each table over the workers that find a processor and a shard."""
    sizes = sizes_of(study.plan)
    counts = {"points": study.plan.points, "limits": study.plan.designs}
    at_once = min(workers, cores(), len(all_shards(study.plan, sizes)))
    threads = os.environ.get("FLOQUET_THREADS")
    with tempfile.TemporaryDirectory(prefix="floquet-") as folder:
        parts = Parts(Path(folder), study.id, study.columns)
        try:
            if workers > 1:
                os.environ["FLOQUET_THREADS"] = "1"  # as every worker has it
            alone = sum(counts[t] * _pace(study, parts, t, min(sizes[t], counts[t])) for t in sizes)
        finally:
            os.environ.pop("FLOQUET_THREADS", None)
            if threads is not None:
                os.environ["FLOQUET_THREADS"] = threads
    return alone / at_once + (START if workers > 1 else 0.0)


def _pace(study: Study, parts: Parts, table: str, most: int) -> float:
    """Seconds a row of points, or a design of limits, of a shard in the middle of the table."""
    plan, size = study.plan, min(SAMPLE[table], most)
    count = plan.points if table == "points" else plan.designs

    def seconds() -> float:
        start = (count - size) // 2
        shard = Shard(table, start, start + size)
        began = time.perf_counter()
        make(plan, shard, parts)
        (parts.folder / shard.file).unlink()
        return time.perf_counter() - began

    seconds()  # what is compiled once is not timed
    while (took := seconds()) < LONG and size < most:
        size = min(2 * size, most)
    return took / size
