"""Running studies: shards, resume, pack, merge.

A running study is a folder beside its database, ``OUT.h5.parts``::

    study.toml          the input, byte for byte
    study.json          study id, sizes of table and shard
    points-<from>-<to>.h5, limits-<from>-<to>.h5

A shard is a pure function of the plan and its range, written whole or not at all: the listing is the journal, and
running a shard again changes nothing.  The study id hashes every parameter of the plan and the engine's version.
When all shards are there they are packed, checked, into the database, and only then removed.  A pool of processes whose
worker dies is made anew; a shard that ends three workers is given up and reported.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import math
import multiprocessing
import os
import shutil
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import __version__, store
from .errors import DatabaseError, FailedError, FloquetError, InputError, StorageError
from .rotor import Hub
from .studyfile import Study, load_study
from .sweep import ENGINE, Plan, limit_rows, point_rows

__all__ = ["Estimate", "RunReport", "Study", "dry_run", "load_study", "merge", "pack", "processes", "run"]

Progress = Callable[[int, int], None]
Rows = dict[str, NDArray[Any]]
LIVES = 3  # worker processes that a shard may end before it is given up
GO_ON = "finished shards are kept: go on with --resume and fewer --workers"
SHARDS = 32  # a study is cut into about so many, within these sizes:
POINT_SHARD, LIMIT_SHARD = (250, 65536), (1, 1024)  # rows of points, designs
BYTES_A_VALUE = 4.0  # of 8, after compression: measured on the validity study
TABLE_ROWS: dict[str, Callable[[Plan, int, int], Rows]] = {"points": point_rows, "limits": limit_rows}


# ---------------------------------------------------------------------- shards
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


def _sizes(plan: Plan) -> dict[str, int]:
    """Shard sizes, fixed for a study."""
    counts = {"points": plan.points, "limits": plan.designs if plan.tolerances else 0}
    bounds = {"points": POINT_SHARD, "limits": LIMIT_SHARD}
    return {t: int(np.clip(math.ceil(n / SHARDS), *bounds[t])) for t, n in counts.items() if n}


def _shards(plan: Plan, sizes: Mapping[str, int]) -> list[Shard]:
    """All shards of these sizes; limits first, for they take longest."""
    counts = {"points": plan.points, "limits": plan.designs}
    return [
        Shard(t, i, min(i + sizes[t], counts[t]))
        for t in ("limits", "points")
        if t in sizes
        for i in range(0, counts[t], sizes[t])
    ]


def _make(plan: Plan, shard: Shard, folder: Path, study_id: str) -> str:
    """Compute a shard and write it: what a worker does."""
    rows = TABLE_ROWS[shard.table](plan, shard.start, shard.stop)
    about = {"study_id": study_id, "engine_version": ENGINE, "shard": shard.name}
    store.write(folder / shard.file, {shard.table: rows}, about)
    return shard.file


def _sound(shard: Shard, folder: Path, study_id: str) -> bool:
    """Whether a shard is there, whole, of this study and of its range."""
    try:
        with store.open_file(folder / shard.file) as file:
            ours = (file.attributes.get("study_id"), file.attributes.get("shard")) == (study_id, shard.name)
            complete = file.tables == (shard.table,) and shard.holds(file.rows(shard.table))
            return ours and complete and not any(True for _ in file.damaged())
    except FloquetError:
        return False


# ---------------------------------------------------------------------- running
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
    sizes = {t: len(store.stored_variables(c)) * BYTES_A_VALUE for t, c in store.TABLES.items()}
    total = plan.points * sizes["points"] + limits * sizes["limits"]
    return Estimate(
        designs=plan.designs,
        points=plan.points,
        limits=limits,
        shards=len(_shards(plan, _sizes(plan))),
        bytes=int(total),
    )


def parts_of(out: str | Path) -> Path:
    """The folder of a running study."""
    return Path(f"{out}.parts")


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
        Where shards are computed instead.
    progress : callable
        ``progress(done, total)`` in shards.
    """
    began, out, study_id = time.monotonic(), Path(out), study.id
    if workers < 1:
        raise InputError(f"workers = {workers} is no number of processes: give 1 or more")
    folder = parts_of(out)
    if out.exists():
        rows = _finished(out, study_id, resume)
        return RunReport(
            path=out,
            points=rows.get("points", 0),
            limits=rows.get("limits", 0),
            seconds=0.0,
            computed=0,
            reused=len(_shards(study.plan, _sizes(study.plan))),
        )
    with _locked(folder, study, resume) as sizes:
        store.remove_leftovers(folder)
        store.remove_leftovers(out.parent, out.name)
        shards = _shards(study.plan, sizes)
        kept = {s for s in shards if (folder / s.file).exists() and _sound(s, folder, study_id)}
        todo = [s for s in shards if s not in kept]
        failed = _compute(study, todo, folder, workers, executor, _counting(shards, kept, progress))
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


def _finished(out: Path, study_id: str, resume: bool) -> dict[str, int]:
    """The rows of each table of ``out`` if it is this study, finished; anything else there is refused."""
    if not resume:
        raise InputError(
            f"{out} is there already: choose another name, move it away, "
            "or give --resume to keep it if it is the same study"
        )
    with store.open_file(out) as file:
        if file.attributes.get("study_id") != study_id:
            raise InputError(
                f"{out} holds another study (or one of another version of the engine): "
                "choose another name or move it away"
            )
        return {t: file.rows(t) for t in file.tables}


@contextlib.contextmanager
def _locked(folder: Path, study: Study, resume: bool) -> Iterator[dict[str, int]]:
    """The study's folder, made or taken up, for one run at a time; gives the shard sizes that it began with."""
    from filelock import FileLock, Timeout

    sizes = _sizes(study.plan)
    described = json.dumps(
        {
            "study_id": study.id,
            "sizes": sizes,
            "points": study.plan.points,
            "designs": study.plan.designs,
            "names": list(study.plan.names),
            "title": study.title,
            "options": _options(study.plan),
        },
        indent=1,
    )
    with contextlib.suppress(FileExistsError), _storage(folder):
        folder.mkdir()
    lock = FileLock(folder / ".lock", timeout=0)
    try:
        lock.acquire()
    except OSError as error:
        if not isinstance(error, Timeout):
            raise StorageError(folder, store.write_failure(error)) from error
        raise InputError(f"{folder} is in use by another run: wait for it, or write to another file") from None
    try:
        journal = folder / "study.json"
        if journal.exists():
            if not resume:
                raise InputError(
                    f"{folder} holds an unfinished run: go on with it by --resume, or remove the folder to start again"
                )
            about = _journal(folder)
            if about.get("study_id") != study.id:
                raise InputError(
                    f"{folder} holds an unfinished run of another study: choose another output, or remove the folder"
                )
            began = about.get("sizes")
            if not (isinstance(began, dict) and began.keys() == sizes.keys() and all(map(_is_size, began.values()))):
                raise DatabaseError(folder, DAMAGED_JOURNAL)
            sizes = began
        else:
            with store.atomic(folder / "study.toml") as temporary:
                temporary.write_text(study.text, encoding="utf-8")
            with store.atomic(journal) as temporary:
                temporary.write_text(described, encoding="utf-8")
        yield sizes
    finally:
        lock.release()


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and value > 0


@contextlib.contextmanager
def _storage(path: Path) -> Iterator[None]:
    """OSErrors of folders and locks as sentences."""
    try:
        yield
    except FileExistsError:
        raise
    except OSError as error:
        raise StorageError(path, store.write_failure(error)) from error


def _options(plan: Plan) -> dict[str, Any]:
    """What rows of one database have in common beside their columns."""
    return {"model": plan.model or "by hub", **plan.physics.as_dict()}


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


def _compute(
    study: Study,
    todo: Sequence[Shard],
    folder: Path,
    workers: int,
    executor: Executor | None,
    count: Callable[[Shard], None],
) -> list[tuple[str, str]]:
    """Make the shards; the names of those that failed, with reasons."""
    failed: list[tuple[str, str]] = []
    with contextlib.closing(_results(study, todo, folder, workers, executor)) as results:
        for shard, result in results:
            try:
                result()
            except InputError as error:
                failed.append((shard.file, str(error)))
            except (ValueError, ArithmeticError) as error:  # NumPy's and SciPy's, LinAlgError is a ValueError
                failed.append((shard.file, f"the computation failed ({type(error).__name__}: {error})"))
            except BrokenExecutor as error:
                raise FailedError(f"a worker process died, perhaps for want of memory; {GO_ON}") from error
            count(shard)
    return failed


Results = Generator[tuple[Shard, Callable[[], str]], None, None]


def _results(study: Study, todo: Sequence[Shard], folder: Path, workers: int, executor: Executor | None) -> Results:
    """Each shard as it is done (or, in this process, to be done), with what gives its result or raises."""
    if executor is not None:
        futures = {executor.submit(_make, study.plan, shard, folder, study.id): shard for shard in todo}
        for future in as_completed(futures):
            yield futures[future], future.result
    elif workers == 1 or len(todo) < 2:
        for shard in todo:
            yield shard, functools.partial(_make, study.plan, shard, folder, study.id)
    else:
        yield from _pooled(study, todo, folder, workers)


def _pooled(study: Study, todo: Sequence[Shard], folder: Path, workers: int) -> Results:
    """Shards from a pool of processes that is made anew when a worker dies.

    Nobody says which shard the dead worker had, but shards are handed out in order: it was one of the first that are
    not done.  These are made alone, so that a shard that ends its worker again has only itself to blame.
    """
    left, lost = list(todo), 0
    while left:
        with contextlib.suppress(BrokenExecutor), processes(workers) as pool:
            futures = {pool.submit(_make, study.plan, shard, folder, study.id): shard for shard in left}
            for future in as_completed(futures):
                if isinstance(error := future.exception(), BrokenExecutor):
                    raise error
                left.remove(futures[future])
                yield futures[future], future.result
        for shard in left[: 2 * workers + 1]:
            result = _alone(study, shard, folder)
            lost += result is None
            if lost > 1 and lost == len(todo) - len(left) + 1:  # and nothing else came of the others
                raise FailedError(f"every worker process dies at once, perhaps for want of memory; {GO_ON}")
            left.remove(shard)
            yield shard, result or _given_up


def _alone(study: Study, shard: Shard, folder: Path) -> Callable[[], str] | None:
    """A shard from a process of its own; None if it ends every one that it is given."""
    for _ in range(LIVES):
        with contextlib.suppress(BrokenExecutor), processes(1) as pool:
            future = pool.submit(_make, study.plan, shard, folder, study.id)
            if isinstance(error := future.exception(), BrokenExecutor):
                raise error
            return future.result
    return None


def _given_up() -> str:
    raise InputError(f"it ended {LIVES} worker processes, perhaps for want of memory: try it with --workers 1")


@contextlib.contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Fresh processes, ended at once by any exception: what they write is there whole or not at all."""
    others = multiprocessing.active_children()
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawned, initializer=_end_with_parent) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                if child not in others:
                    child.terminate()
            raise


def _end_with_parent() -> None:
    """Let this worker leave when its parent is killed, or it would wait for work forever."""

    def watch() -> None:
        if (parent := multiprocessing.parent_process()) is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


# ---------------------------------------------------------------------- packing and merging
def pack(folder: str | Path, out: str | Path) -> dict[str, int]:
    """Check all shards of a study's folder and write them as one database; the rows of each table."""
    folder = Path(folder)
    journal = folder / "study.json"
    if Path(out).exists():
        raise InputError(f"{out} is there already: choose another name or move it away")
    if not journal.is_file():
        raise DatabaseError(
            folder, "this is not the folder of a study: pack takes OUT.h5.parts, which floquet run leaves when it stops"
        )
    about = _journal(folder)
    try:
        shards = {
            t: _listed(t, about["designs" if t == "limits" else "points"], size) for t, size in about["sizes"].items()
        }
        attributes = _attributes(
            about["title"], about["study_id"], about["names"], about["options"], _text(folder / "study.toml")
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, DatabaseError):
            raise
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error
    everything = [s for group in shards.values() for s in group]
    missing = [s for s in everything if not (folder / s.file).exists()]
    if missing:
        raise DatabaseError(
            folder, f"{len(missing)} of {len(everything)} shards are missing: finish the study with --resume"
        )
    wrong = [s.file for s in everything if not _sound(s, folder, about["study_id"])]
    if wrong:
        raise DatabaseError(
            folder,
            f"{len(wrong)} of {len(everything)} shards are damaged or of another study or range, the first {wrong[0]}: "
            "make them again with --resume",
        )
    with contextlib.ExitStack() as stack:
        rows = {
            t: sum(_rows_of(folder / s.file, t) for s in group) for t, group in sorted(shards.items(), reverse=True)
        }
        writers = stack.enter_context(store.create(out, rows, attributes))
        for table, writer in writers.items():
            for shard in shards[table]:
                with store.open_file(folder / shard.file) as file:
                    store.copy_rows(file, table, writer)
    return rows


DAMAGED_JOURNAL = "its study.json is damaged: remove the folder and run the study again"


def _journal(folder: Path) -> dict[str, Any]:
    """What study.json says."""
    try:
        about = json.loads(_text(folder / "study.json"))
    except ValueError as error:
        if isinstance(error, DatabaseError):
            raise
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error
    if not isinstance(about, dict):
        raise DatabaseError(folder, DAMAGED_JOURNAL)
    return about


def _text(path: Path) -> str:
    """A file of a study's folder."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DatabaseError(
            path, "this file of the study's folder is missing or cannot be read: put it back, or run the study again"
        ) from error


def _listed(table: str, count: int, size: int) -> list[Shard]:
    return [Shard(table, i, min(i + size, count)) for i in range(0, count, size)]


def _rows_of(path: Path, table: str) -> int:
    with store.open_file(path) as file:
        return file.rows(table)


def _attributes(
    title: str, study_id: str, names: Sequence[str], options: Mapping[str, Any], text: str
) -> dict[str, Any]:
    """Root attributes of a database."""
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return {
        "title": title,
        "history": f"{now} floquet-rotor {__version__}",
        "source": f"floquet-rotor {__version__}: Floquet exponents against the tip-path plane; no dynamic inflow",
        "created": now,
        "study_id": study_id,
        "engine_version": ENGINE,
        "options": json.dumps(options),
        "rotor_names": json.dumps(list(names), ensure_ascii=False),
        "input": text,
    }


def merge(paths: Sequence[str | Path], out: str | Path) -> dict[str, int]:
    """One database of several with the same engine and options; rotors are numbered on."""
    if len(paths) < 2:
        raise InputError("merge takes two databases or more")
    if Path(out).exists():
        raise InputError(f"{out} is there already: choose another name or move it away")
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(store.open_file(p)) for p in paths]
        first = files[0]
        seen: dict[str, str] = {}
        for file in files:
            for name in ("engine_version", "options"):
                if file.attributes.get(name) != first.attributes.get(name):
                    raise InputError(
                        f"{file.path} and {first.path} differ in {name}: "
                        "rows of one database must come from the same equations"
                    )
            if (other := seen.get(file.attributes["study_id"])) is not None:
                raise InputError(f"{file.path} and {other} hold the same study: its rows would stand twice")
            seen[file.attributes["study_id"]] = file.path
        counts = [_designs(f) for f in files]
        names = [n for f, c in zip(files, counts, strict=True) for n in (f.names or ("",) * c)]
        present = [t for t in store.TABLES if any(t in f.tables for f in files)]
        rows = {t: sum(f.rows(t) for f in files if t in f.tables) for t in present}
        combined = hashlib.blake2b("".join(seen).encode(), digest_size=16).hexdigest()
        text = "\n".join(f"# {f.path}\n{f.attributes.get('input', '')}" for f in files)
        attributes = _attributes(
            f"{len(files)} studies merged",
            combined,
            names if any(names) else [],
            json.loads(first.attributes["options"]),
            text,
        )
        writers = stack.enter_context(store.create(out, rows, attributes))
        for table, writer in writers.items():
            for offset, file in zip(np.cumsum([0, *counts]), files, strict=False):
                if table in file.tables:
                    store.copy_rows(file, table, writer, rotor_offset=int(offset))
    return rows


def _designs(file: store.File) -> int:
    """How many rotors a database has."""
    return max((int(r["rotor"].max()) + 1 for _, r in file.chunks("points", ["rotor"])), default=0)
