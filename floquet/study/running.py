"""Running a study into its database: what is missing is computed, packed and checked, and only then the parts go."""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path

from .. import store
from ..errors import InputError
from ..rotor import Hub
from ..studyfile import Study
from .folder import locked, parts_of, same_columns
from .packing import pack
from .shards import Parts, Shard, all_shards, sizes_of, sound
from .workers import compute

Progress = Callable[[int, int], None]
BYTES_A_VALUE = 4.0  # of 8, after compression: measured on the validity study


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a study will make."""

    designs: int
    points: int
    limits: int
    shards: int
    bytes: int


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a run did; ``failed`` shards leave the study unfinished, its folder in place."""

    path: Path
    points: int
    limits: int
    seconds: float
    computed: int
    reused: int
    failed: tuple[tuple[str, str], ...] = field(default=())


def dry_run(study: Study) -> Estimate:
    """Sizes of a study without running it."""
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
    )


def run(
    study: Study,
    out: str | Path,
    *,
    resume: bool = False,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RunReport:
    """Compute a study into the database ``out``.

    Parameters
    ----------
    resume : bool
        Go on where an earlier run of the same study stopped; without it an existing output is refused.
    workers : int
        Processes; 1 computes here.  The result does not depend on it.
    executor : concurrent.futures.Executor, optional
        Where shards are computed instead, by workers that see the folder of ``out``: :func:`floquet.cluster.dask`.
    progress : callable
        ``progress(done, total)`` in shards.
    """
    began, out = time.monotonic(), Path(out)
    if workers < 1:
        raise InputError(f"workers = {workers} is no number of processes: give 1 or more")
    folder = parts_of(out)
    if out.exists():
        rows = _finished(out, study, resume)
        return RunReport(
            path=out,
            points=rows.get("points", 0),
            limits=rows.get("limits", 0),
            seconds=0.0,
            computed=0,
            reused=len(all_shards(study.plan, sizes_of(study.plan))),
        )
    with locked(folder, study, resume) as sizes:
        store.remove_leftovers(folder)
        store.remove_leftovers(out.parent, out.name)
        shards = all_shards(study.plan, sizes)
        parts = Parts(folder, study.id, study.columns)
        kept = {s for s in shards if (folder / s.file).exists() and sound(s, parts)}
        todo = [s for s in shards if s not in kept]
        failed = compute(study.plan, parts, todo, workers, executor, _counting(shards, kept, progress))
        if not failed:
            rows = pack(folder, out)
            shutil.rmtree(folder, ignore_errors=True)
    if failed:
        return RunReport(
            path=out,
            points=0,
            limits=0,
            seconds=time.monotonic() - began,
            computed=len(todo) - len(failed),
            reused=len(kept),
            failed=tuple(failed),
        )
    seconds = time.monotonic() - began
    return RunReport(
        path=out,
        points=rows["points"],
        limits=rows.get("limits", 0),
        seconds=seconds,
        computed=len(todo),
        reused=len(kept),
    )


def _finished(out: Path, study: Study, resume: bool) -> dict[str, int]:
    """The rows of each table of ``out`` if it is this study, finished; anything else there is refused."""
    if not resume:
        raise InputError(
            f"{out} is there already: choose another name, move it away, "
            "or give --resume to keep it if it is the same study"
        )
    with store.open_file(out) as file:
        if file.attributes.get("study_id") != study.id:
            raise InputError(
                f"{out} holds another study (or one of another version of the engine): "
                "choose another name or move it away"
            )
        same_columns(out, study, file.columns("points"))
        return {t: file.rows(t) for t in file.tables}


def _counting(shards: Sequence[Shard], kept: set[Shard], progress: Progress | None) -> Callable[[Shard], None]:
    """Progress in shards."""
    total, done = len(shards), len(kept)
    if progress:
        progress(done, total)

    def count(_: Shard) -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done, total)

    return count
