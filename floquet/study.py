"""Running studies: shards, resume, pack, merge.

A running study is a folder beside its database, ``OUT.h5.parts``::

    study.toml          the input, byte for byte
    study.json          study id, columns, sizes of table and shard
    points-<from>-<to>.h5, limits-<from>-<to>.h5

A shard is a pure function of the plan, the columns and its range, written whole or not at all: the listing is the
journal, and running a shard again changes nothing.  The study id hashes every parameter of the plan and the engine's
version.  Shards of many points end where chunks of the database end: rows are computed chunk by chunk, and packing
copies chunks as they are.  When all shards are there they are packed, checked, into the database, and only then
removed.  A pool of processes whose worker dies is made anew; a shard that ends three workers is given up and reported.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import json
import math
import multiprocessing
import os
import platform
import shutil
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from itertools import pairwise, permutations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import __version__, store
from .comparison import exact_model, warn_of_few_blades
from .errors import DamageError, DatabaseError, FailedError, FloquetError, FloquetWarning, InputError, StorageError
from .rotor import PARAMETERS, Hub
from .studyfile import Study, load_study
from .sweep import ENGINE, Plan, limit_rows, point_rows

__all__ = ["Estimate", "RunReport", "Study", "dry_run", "load_study", "merge", "pack", "processes", "run"]

Progress = Callable[[int, int], None]
Rows = dict[str, NDArray[Any]]
LIVES = 3  # worker processes that a shard may end before it is given up
GO_ON = "finished shards are kept: go on with --resume and fewer --workers"
ALL_DIE = f"every worker process dies at once, perhaps for want of memory; {GO_ON}"
SHARED = "write to a folder that all workers share; finished shards are kept"
PATIENCE = 20.0  # seconds that a shared folder has to show a file
SHARDS = 32  # a study is cut into about so many, within these sizes:
POINT_SHARD, LIMIT_SHARD = (4096, 2**20), (1, 1024)  # rows of points, designs; a file takes the time of 4000 rows
BYTES_A_VALUE = 4.0  # of 8, after compression: measured on the validity study
TABLE_ROWS: dict[str, Callable[..., Rows]] = {"points": point_rows, "limits": limit_rows}


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
    sizes = {"points": int(np.clip(math.ceil(plan.points / SHARDS), *POINT_SHARD))}
    if sizes["points"] > store.schema.CHUNK_ROWS:
        sizes["points"] = math.ceil(sizes["points"] / store.schema.CHUNK_ROWS) * store.schema.CHUNK_ROWS
    if plan.tolerances:
        sizes["limits"] = int(np.clip(math.ceil(plan.designs / SHARDS), *LIMIT_SHARD))
    return sizes


def _shards(plan: Plan, sizes: Mapping[str, int]) -> list[Shard]:
    """All shards of these sizes; limits first, for they take longest."""
    counts = {"points": plan.points, "limits": plan.designs}
    return [
        Shard(t, i, min(i + sizes[t], counts[t]))
        for t in ("limits", "points")
        if t in sizes
        for i in range(0, counts[t], sizes[t])
    ]


@dataclass(frozen=True)
class Parts:
    """The folder of shards of a study, and the columns of points that they have."""

    folder: Path
    study_id: str
    columns: tuple[str, ...]


def _make(plan: Plan, shard: Shard, parts: Parts) -> str:
    """Compute a shard and write it: what a worker does."""
    out, columns = parts.folder / shard.file, {"points": parts.columns}
    about = {"study_id": parts.study_id, "engine_version": ENGINE, "shard": shard.name}
    wanted, blocks = (parts.columns,) if shard.table == "points" else (), _blocks(shard, plan)
    made = (TABLE_ROWS[shard.table](plan, *block, *wanted) for block in blocks)
    first = next(made)
    count = shard.stop - shard.start if shard.table == "points" else len(first["rotor"])
    with store.create(out, {shard.table: count}, about, columns=columns) as writers:
        writers[shard.table].add(first)
        for rows in made:
            writers[shard.table].add(rows)
    return shard.file


def _blocks(shard: Shard, plan: Plan) -> list[tuple[int, int]]:
    """Ranges that are computed at a time: of points the database's chunks, or whole designs that are mapped."""
    if shard.table == "limits":
        return [(shard.start, shard.stop)]
    whole = plan.advance_ratio.size if plan.map else store.schema.CHUNK_ROWS
    step = whole * max(1, store.schema.CHUNK_ROWS // whole)
    inner = range((shard.start // step + 1) * step, shard.stop, step)
    return list(pairwise([shard.start, *inner, shard.stop]))


def _ours(shard: Shard, parts: Parts) -> bool:
    """Whether a shard is there, of this study, of its range, with its columns."""
    try:
        with store.open_file(parts.folder / shard.file) as file:
            ours = (file.attributes.get("study_id"), file.attributes.get("shard")) == (parts.study_id, shard.name)
            complete = file.tables == (shard.table,) and shard.holds(file.rows(shard.table))
            return ours and complete and (shard.table != "points" or tuple(file.columns("points")) == parts.columns)
    except FloquetError:
        return False


def _sound(shard: Shard, parts: Parts) -> bool:
    """Whether a shard is the right one and whole."""
    if not _ours(shard, parts):
        return False
    with store.open_file(parts.folder / shard.file) as file:
        return file.intact()


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
    stored = {"points": {name: store.POINTS[name] for name in study.columns}, "limits": store.LIMITS}
    sizes = {t: len(store.stored_variables(c)) * BYTES_A_VALUE for t, c in stored.items()}
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
            reused=len(_shards(study.plan, _sizes(study.plan))),
        )
    with _locked(folder, study, resume) as sizes:
        store.remove_leftovers(folder)
        store.remove_leftovers(out.parent, out.name)
        shards = _shards(study.plan, sizes)
        parts = Parts(folder, study.id, study.columns)
        kept = {s for s in shards if (folder / s.file).exists() and _sound(s, parts)}
        todo = [s for s in shards if s not in kept]
        failed = _compute(study.plan, parts, todo, workers, executor, _counting(shards, kept, progress))
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
        _same_columns(out, study, file.columns("points"))
        return {t: file.rows(t) for t in file.tables}


def _same_columns(place: Path, study: Study, there: Iterable[str]) -> None:
    """Refuse to go on with a run of this study that stores other columns."""
    there = set(there)
    differences = [
        f"{what} {', '.join(sorted(names))}"
        for what, names in (("without", set(study.columns) - there), ("with", there - set(study.columns)))
        if names
    ]
    if differences:
        raise InputError(
            f"{place} holds this study {' and '.join(differences)}: name the same columns, or choose another output"
        )


@contextlib.contextmanager
def _locked(folder: Path, study: Study, resume: bool) -> Iterator[dict[str, int]]:
    """The study's folder, made or taken up, for one run at a time; gives the shard sizes that it began with."""
    from filelock import FileLock, Timeout

    sizes = _sizes(study.plan)
    described = json.dumps(
        {
            "study_id": study.id,
            "sizes": sizes,
            "columns": list(study.columns),
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
            _same_columns(folder, study, _columns_of(folder, about))
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
    plan: Plan,
    parts: Parts,
    todo: Sequence[Shard],
    workers: int,
    executor: Executor | None,
    count: Callable[[Shard], None],
) -> list[tuple[str, str]]:
    """Make the shards; the names of those that failed, with reasons."""
    failed: list[tuple[str, str]] = []
    with contextlib.closing(_results(plan, parts, todo, workers, executor)) as results:
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


def _results(plan: Plan, parts: Parts, todo: Sequence[Shard], workers: int, executor: Executor | None) -> Results:
    """Each shard as it is done (or, in this process, to be done), with what gives its result or raises."""
    if executor is not None:
        yield from _handed_out(plan, parts, todo, executor)
    elif workers == 1 or len(todo) < 2:
        for shard in todo:
            yield shard, functools.partial(_make, plan, shard, parts)
    else:
        yield from _pooled(plan, parts, todo, workers)


def _handed_out(plan: Plan, parts: Parts, todo: Sequence[Shard], executor: Executor) -> Results:
    """Shards from an executor.

    One that ended its worker, or was handed to one that died, is made once more when all others are done, alone.
    """
    _warn(plan)
    parts = dataclasses.replace(parts, folder=parts.folder.absolute())
    lost: list[Shard] = []
    futures = {executor.submit(_make_there, plan, shard, parts, ENGINE): shard for shard in todo}
    try:
        for future in as_completed(futures):
            if isinstance(future.exception(), BrokenExecutor):
                lost.append(futures[future])
                if len(lost) > LIVES and len(lost) == sum(f.done() for f in futures):
                    raise FailedError(ALL_DIE)
            else:
                yield futures[future], functools.partial(_arrived, future, parts)
    finally:
        for future in futures:
            future.cancel()
    dead = 0
    for shard in lost:
        future = executor.submit(_make_there, plan, shard, parts, ENGINE)
        died = isinstance(future.exception(), BrokenExecutor)
        dead += died
        if dead > 1 and dead == len(todo) - len(lost) + dead:  # and nothing else came of the others
            raise FailedError(ALL_DIE)
        yield shard, _given_up if died else functools.partial(_arrived, future, parts)


def _make_there(plan: Plan, shard: Shard, parts: Parts, engine: int) -> str:
    """Compute a shard and write it: what a worker does that may be on another machine."""
    if engine != ENGINE:
        raise FailedError(
            f"{platform.node()} has another version of floquet (engine {ENGINE}, here {engine}): install the same; "
            "finished shards are kept"
        )
    if not _appears(parts.folder / "study.json"):
        raise FailedError(f"{platform.node()} does not see {parts.folder}: {SHARED}")
    return _make(plan, shard, parts)


def _arrived(future: Future[str], parts: Parts) -> str:
    """The file that a worker has written; it must be seen here, too."""
    name = future.result()
    if not _appears(parts.folder / name):
        raise FailedError(f"a worker has written {name}, and it is not in {parts.folder} here: {SHARED}")
    return name


def _appears(path: Path) -> bool:
    """Whether a file is there; a shared folder may show it late, and sooner if it is listed."""
    end = time.monotonic() + PATIENCE
    while not path.exists():
        if time.monotonic() > end:
            return False
        with contextlib.suppress(OSError):
            os.listdir(path.parent)
        time.sleep(0.1)
    return True


def _warn(plan: Plan) -> None:
    """What workers do not say."""
    for rotor in plan.rotors:
        warn_of_few_blades(rotor, exact_model(rotor, plan.model), stacklevel=3)


def _pooled(plan: Plan, parts: Parts, todo: Sequence[Shard], workers: int) -> Results:
    """Shards from a pool of processes that is made anew when a worker dies.

    Nobody says which shard the dead worker had, but shards are handed out in order: it was one of the first that are
    not done.  These are made alone, so that a shard that ends its worker again has only itself to blame.
    """
    _warn(plan)
    left, lost = list(todo), 0
    while left:
        with contextlib.suppress(BrokenExecutor), processes(workers) as pool:
            futures = {pool.submit(_make, plan, shard, parts): shard for shard in left}
            for future in as_completed(futures):
                if isinstance(error := future.exception(), BrokenExecutor):
                    raise error
                left.remove(futures[future])
                yield futures[future], future.result
        for shard in left[: 2 * workers + 1]:
            result = _alone(plan, parts, shard)
            lost += result is None
            if lost > 1 and lost == len(todo) - len(left) + 1:  # and nothing else came of the others
                raise FailedError(ALL_DIE)
            left.remove(shard)
            yield shard, result or _given_up


def _alone(plan: Plan, parts: Parts, shard: Shard) -> Callable[[], str] | None:
    """A shard from a process of its own; None if it ends every one that it is given."""
    for _ in range(LIVES):
        with contextlib.suppress(BrokenExecutor), processes(1) as pool:
            future = pool.submit(_make, plan, shard, parts)
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
    with ProcessPoolExecutor(workers, mp_context=spawned, initializer=_begin_worker) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                if child not in others:
                    child.terminate()
            raise


def _begin_worker() -> None:
    """One thread a worker, none that outlives its parent and waits for work forever; warnings are its parent's."""
    warnings.simplefilter("ignore", FloquetWarning)
    os.environ["FLOQUET_THREADS"] = "1"  # whatever it was: there are workers for the cores

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
        counts = {"points": about["points"], "limits": about["designs"]}
        shards = {t: _listed(t, counts[t], about["sizes"][t]) for t in store.TABLES if t in about["sizes"]}
        parts = Parts(folder, about["study_id"], _columns_of(folder, about))
        text = _text(folder / "study.toml")
        attributes = _attributes(about["title"], about["study_id"], about["names"], about["options"], text)
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
    _refuse([s for s in everything if not _ours(s, parts)], everything, folder)
    try:
        return _joined(shards, parts, out, attributes)
    except DamageError:
        _refuse([s for s in everything if not _sound(s, parts)], everything, folder)
        raise


def _refuse(wrong: Sequence[Shard], everything: Sequence[Shard], folder: Path) -> None:
    if wrong:
        raise DatabaseError(
            folder,
            f"{len(wrong)} of {len(everything)} shards are damaged or of another study or range, the first "
            f"{wrong[0].file}: make them again with --resume",
        )


def _joined(
    shards: Mapping[str, Sequence[Shard]], parts: Parts, out: str | Path, attributes: Mapping[str, Any]
) -> dict[str, int]:
    """The database of these shards, each of which is checked chunk by chunk."""
    rows = {t: sum(_rows_of(parts.folder / s.file, t) for s in group) for t, group in shards.items()}
    with store.create(out, rows, attributes, columns={"points": parts.columns}) as writers:
        for table, writer in writers.items():
            for shard in shards[table]:
                with store.open_file(parts.folder / shard.file) as file:
                    store.copy_rows(file, writer)
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


def _columns_of(folder: Path, about: Mapping[str, Any]) -> tuple[str, ...]:
    """The columns of points that a journal tells; all where it was written before there was a choice."""
    try:
        return store.chosen(about.get("columns", [store.EVERY]))
    except (InputError, TypeError, AttributeError) as error:
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error


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
    """One database of several with the same engine and options; rotors are numbered on.

    Of one, whatever release or program has written it, it is a copy as this release writes.
    """
    if not paths:
        raise InputError("merge takes one database or more, and none was given")
    if Path(out).exists():
        raise InputError(f"{out} is there already: choose another name or move it away")
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(store.open_file(p)) for p in paths]
        if len(files) == 1:
            return _renewed(files[0], out)
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
        _refuse_twice(files)
        counts = [_designs(f) for f in files]
        names = [n for f, c in zip(files, counts, strict=True) for n in (f.names or ("",) * c)]
        present = [t for t in store.TABLES if any(t in f.tables for f in files)]
        rows = {t: sum(f.rows(t) for f in files if t in f.tables) for t in present}
        columns = {t: _common(files, t) for t in present}
        combined = hashlib.blake2b("".join(seen).encode(), digest_size=16).hexdigest()
        text = "\n".join(f"# {f.path}\n{f.attributes.get('input', '')}" for f in files)
        attributes = _attributes(
            f"{len(files)} studies merged",
            combined,
            names if any(names) else [],
            json.loads(first.attributes["options"]),
            text,
        )
        writers = stack.enter_context(store.create(out, rows, attributes, columns=columns))
        for table, writer in writers.items():
            for offset, file in zip(np.cumsum([0, *counts]), files, strict=False):
                if table in file.tables:
                    store.copy_rows(file, writer, rotor_offset=int(offset))
    return rows


def _renewed(file: store.File, out: str | Path) -> dict[str, int]:
    """A copy in the present schema, with the same rows and attributes and a line of history."""
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    line = f"{now} floquet-rotor {__version__}, from schema {file.attributes['schema_version']}"
    attributes = {name: value for name, value in file.attributes.items() if name != "attributes_digest"}
    attributes["history"] = "\n".join(filter(None, [attributes.get("history"), line]))
    rows = {table: file.rows(table) for table in file.tables}
    columns = {table: _common([file], table) for table in file.tables}
    with store.create(out, rows, attributes, columns=columns) as writers:
        for writer in writers.values():
            store.copy_rows(file, writer)
    return rows


def _refuse_twice(files: Sequence[store.File]) -> None:
    """No database has every row of another, as that of one study with maps and without."""
    points = [_points(file) for file in files]
    for (a, mine), (b, theirs) in permutations(zip(files, points, strict=True), 2):
        if mine and all(ratios <= theirs.get(design, frozenset()) for design, ratios in mine.items()):
            raise InputError(
                f"{b.path} has every design and advance ratio of {a.path}, as it is when one study was run with "
                "map = true and without: its rows would stand twice, so give one of the two"
            )


def _points(file: store.File) -> dict[bytes, frozenset[float]]:
    """The designs, by name and parameters, and their advance ratios."""
    columns = ["rotor", "advance_ratio", *(p.name for p in PARAMETERS), "blades", "hub"]
    found: dict[bytes, frozenset[float]] = {}
    grids: dict[bytes, frozenset[float]] = {}  # each once: all designs of a study have the same
    for _, rows in file.chunks("points", columns) if "points" in file.tables else ():
        rotor, mu = rows["rotor"], rows["advance_ratio"]
        ends = [0, *(np.flatnonzero(np.diff(rotor)) + 1).tolist(), len(rotor)]
        for start, stop in pairwise(ends):
            name = file.names[rotor[start]] if rotor[start] < len(file.names) else ""
            values = np.array([float(rows[column][start]) for column in columns[2:]])
            design, piece = name.encode() + b"\0" + values.tobytes(), mu[start:stop].tobytes()
            if piece not in grids:
                grids[piece] = frozenset(mu[start:stop].tolist())
            found[design] = found[design] | grids[piece] if design in found else grids[piece]
    return found


def _designs(file: store.File) -> int:
    """How many rotors a database has."""
    return max((int(r["rotor"].max()) + 1 for _, r in file.chunks("points", ["rotor"])), default=0)


def _common(files: Sequence[store.File], table: str) -> list[str]:
    """The columns that a table has in every file; a warning names the others."""
    there = [file.columns(table) for file in files if table in file.tables]
    kept = [name for name in store.TABLES[table] if all(name in columns for columns in there)]
    lost = [name for name in store.TABLES[table] if name not in kept and any(name in columns for columns in there)]
    lost += sorted(set().union(*(file.unknown(table) for file in files if table in file.tables)))
    if lost:
        warnings.warn(
            "columns that not every database has, or that this release does not know, are left out of the table "
            f"{table}: {', '.join(lost)}",
            FloquetWarning,
            stacklevel=3,
        )
    return kept
