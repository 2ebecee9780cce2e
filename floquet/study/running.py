"""Running a study into its database: what is missing is computed, packed and checked, and only then the parts go."""

from __future__ import annotations

import contextlib
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path

from .. import store
from ..errors import DatabaseError, FloquetError, FloquetWarning, InputError, StorageError
from ..studyfile import Study
from .extending import Known, known
from .folder import checked_output, journal_of, locked, parts_of, remove_parts, same_columns
from .packing import packed
from .shards import Parts, Shard, all_shards, sizes_of, sound
from .workers import compute

Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a run did; ``failed`` shards leave the study unfinished, its folder in place.

    ``computed`` and ``reused`` are shards, ``copied`` points of a database that was extended.
    """

    path: Path
    points: int
    limits: int
    seconds: float
    computed: int
    reused: int
    failed: tuple[tuple[str, str], ...] = field(default=())
    copied: int = 0


def run(
    study: Study,
    out: str | Path,
    *,
    resume: bool = False,
    extend: bool = False,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RunReport:
    """Compute a study into the database ``out``.

    Parameters
    ----------
    resume : bool
        Go on where an earlier run of the same study stopped; without it an existing output is refused.
    extend : bool
        ``out`` is a database of the study as it was before it grew, by designs, advance ratios or tolerances: its rows
        are copied, the others computed, and it is replaced when the new one is whole.  Its data are those of a run
        from nothing.
    workers : int
        Processes; 1 computes here.  The result does not depend on it.
    executor : concurrent.futures.Executor, optional
        Where shards are computed instead, by workers that see the folder of ``out``: :func:`floquet.cluster.dask`.
    progress : callable
        ``progress(done, total)`` in shards.
    """
    began, out = time.monotonic(), checked_output(out)
    if workers < 1:
        raise InputError(f"workers = {workers} is no number of processes: give 1 or more")
    folder = parts_of(out)
    if extend and not out.exists():
        raise InputError(f"{out} is not there to be extended: check the path, or run the study without --extend")
    if out.exists() and not (extend and _grown(out, study)):
        return _kept(out, study, resume or extend)
    there = known(out, study) if extend else None  # or a refusal, before anything is written
    with locked(folder, study, resume) as sizes:
        if out.exists() and not extend:  # another run has ended since
            if not resume:
                _clear(folder, study)
            return _kept(out, study, resume)
        if there is not None and there.digest != store.data_digest(out):  # another has extended it since
            if not _grown(out, study):
                return _kept(out, study, True)
            there = _known_anew(out, study, None if resume else folder)
        store.remove_leftovers(folder)
        shards = all_shards(study.plan, sizes)
        parts = Parts(folder, study.id, study.columns, there)
        made = [s for s in shards if (folder / s.file).exists()]
        kept = {s for s in made if sound(s, parts)}
        _tell_of_damage([s for s in made if s not in kept])
        todo = [s for s in shards if s not in kept]
        with _resumable():
            failed = compute(study.plan, parts, todo, workers, executor, _counting(shards, kept, progress))
            rows = {} if failed else packed(folder, out, replace=extend)
        if not failed:
            remove_parts(folder)
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
        copied=parts.known.points if parts.known else 0,
    )


def _known_anew(out: Path, study: Study, folder: Path | None) -> Known:
    """As :func:`known`; a refusal leaves no folder that this run has made."""
    try:
        return known(out, study)
    except FloquetError:
        if folder is not None:
            remove_parts(folder)
        raise


@contextlib.contextmanager
def _resumable() -> Iterator[None]:
    """What could not be written is told with the way on."""
    try:
        yield
    except StorageError as error:
        raise StorageError(error.path, f"{error.sentence}, and --resume goes on from it") from error


def _grown(out: Path, study: Study) -> bool:
    """Whether a database is of another study than this, or of this with other columns."""
    with store.open_file(out) as file:
        same = file.attributes.get("study_id") == study.id
        return not (same and set(file.columns("points")) == set(study.columns))


def _kept(out: Path, study: Study, resume: bool) -> RunReport:
    """The report of a study that is there, finished; what is left of its parts goes."""
    rows = _finished(out, study, resume)
    _clear(parts_of(out), study)
    return RunReport(
        path=out,
        points=rows.get("points", 0),
        limits=rows.get("limits", 0),
        seconds=0.0,
        computed=0,
        reused=len(all_shards(study.plan, sizes_of(study.plan))),
    )


def _finished(out: Path, study: Study, resume: bool) -> dict[str, int]:
    """The rows of each table of ``out`` if it is this study, finished; anything else there is refused."""
    if not resume:
        raise InputError(
            f"{out} is there already: choose another name, move it away, "
            "or give --resume to keep it if it is the same study, --extend if that has grown"
        )
    with store.open_file(out) as file:
        if file.attributes.get("study_id") != study.id:
            if _begun(out, study):
                raise InputError(f"{parts_of(out)} holds an unfinished extension of {out}: give --extend --resume")
            raise InputError(
                f"{out} holds another study (or one of another version of the engine): choose another name or move it "
                "away, or give --extend if it has grown"
            )
        same_columns(out, study, file.columns("points"))
        return {t: file.rows(t) for t in file.tables}


def _begun(out: Path, study: Study) -> bool:
    """Whether there are parts of this study."""
    with contextlib.suppress(DatabaseError):
        return journal_of(parts_of(out)).get("study_id") == study.id
    return False


def _tell_of_damage(damaged: Sequence[Shard]) -> None:
    """Shards are written whole: one that is not is the sign of a failing disk, or somebody has changed it."""
    if damaged:
        warnings.warn(
            f"{len(damaged)} parts that were there are damaged, the first {damaged[0].file}, and are made again: "
            "see whether the disk is sound",
            FloquetWarning,
            stacklevel=3,
        )


def _clear(folder: Path, study: Study) -> None:
    """Remove the parts of a finished study, where a run was killed before it had."""
    journal = folder / "study.json"
    with contextlib.suppress(DatabaseError):
        if not journal.exists() or journal_of(folder).get("study_id") == study.id:
            remove_parts(folder)


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
