"""Studies: a TOML file → a plan; run, resume, pack, merge, export.

A running study is a folder beside its database, ``OUT.h5.parts``::

    study.toml          the input, byte for byte
    study.json          study id, sizes of table and shard
    points-<from>-<to>.h5, limits-<from>-<to>.h5

A shard is a pure function of the plan and its range, written whole or not at all: the listing is the journal, and
running a shard again changes nothing.  The study id hashes every parameter of the plan and the engine's version.
When all shards are there they are packed, checked, into the database, and only then removed.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import math
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, as_completed
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field

from . import __version__, store
from .comparison import Metric, Model
from .errors import (
    ConfigError,
    DatabaseError,
    FailedError,
    FloquetError,
    InputError,
    Problem,
    StorageError,
    did_you_mean,
)
from .models import Physics
from .rotor import PARAMETERS, Hub, Rotor, load_rotor
from .sweep import ENGINE, Plan, limit_rows, point_rows
from .tomlfile import Table, read_toml

__all__ = ["Estimate", "RunReport", "Study", "dry_run", "export", "load_study", "merge", "pack", "run"]

Progress = Callable[[int, int], None]
Rows = dict[str, NDArray[Any]]
SHARDS = 32  # a study is cut into about so many, within these sizes:
POINT_SHARD, LIMIT_SHARD = (250, 65536), (1, 1024)  # rows of points, designs
BYTES_A_VALUE = 4.0  # of 8, after compression: measured on the validity study
TABLE_ROWS: dict[str, Callable[[Plan, int, int], Rows]] = {"points": point_rows, "limits": limit_rows}


# ---------------------------------------------------------------------- the study file
class _Table(Table):
    model_config = ConfigDict(populate_by_name=True)


class Range(_Table):
    """``{start = 0.0, stop = 1.0, count = 401}``, both ends included."""

    start: float
    stop: float
    count: Annotated[int, Field(ge=1, le=10**7)]

    def values(self) -> list[float]:
        """The numbers."""
        return [float(x) for x in np.linspace(self.start, self.stop, self.count)]


Axis = Range | list[float]


class StudyTable(_Table):
    """``[study]``"""

    name: str
    schema_version: Literal[1] = Field(1, alias="schema")
    title: str = ""


class RotorsTable(_Table):
    """``[rotors]``: any of files, list, grid and sobol; their rotors follow one another."""

    files: list[str] = Field(default_factory=list)
    rotors: list[dict[str, Any]] = Field(default_factory=list, alias="list")
    grid: dict[str, Any] = Field(default_factory=dict)
    sobol: dict[str, Any] = Field(default_factory=dict)


class AxesTable(_Table):
    """``[axes]``"""

    advance_ratio: Axis


class CompareTable(_Table):
    """``[compare]``: model, physics, and what the limits are sought for."""

    model: Literal["auto", "flapping", "teetering"] = "auto"
    exact_offset: bool = False
    reversed_flow: bool = False
    tip_loss: float = 1.0
    kinematic_rates: bool = False
    tolerances: list[Annotated[float, Field(gt=0)]] = Field(default_factory=lambda: [0.05])
    absolute_tolerances: list[Annotated[float, Field(gt=0)]] = Field(default_factory=list)
    mu_max: Annotated[float, Field(gt=0)] = 1.0


class StudyFile(_Table):
    """A study file."""

    study: StudyTable
    rotors: RotorsTable
    axes: AxesTable
    compare: CompareTable = CompareTable()


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study: its name, its input and its plan."""

    name: str
    title: str
    text: str
    plan: Plan

    @property
    def id(self) -> str:
        """Hash of everything that decides a number."""
        plan, h = self.plan, hashlib.blake2b(digest_size=16)
        options = {"engine": ENGINE, "model": plan.model, "mu_max": plan.mu_max, **plan.physics.as_dict()}
        h.update(json.dumps([options, [[int(m), t] for m, t in plan.tolerances]], sort_keys=True).encode())
        h.update(plan.advance_ratio.astype("<f8").tobytes())
        for rotor in plan.rotors:
            h.update(json.dumps([rotor.name, int(rotor.hub), rotor.blades, list(rotor.shape)]).encode())
            for p in PARAMETERS:
                h.update(np.asarray(getattr(rotor, p.name), "<f8").tobytes())
        return h.hexdigest()


def load_study(path: str | Path) -> Study:
    """Read a study file; every problem at once, with its line."""
    path = Path(path)
    data = read_toml(path, StudyFile)
    try:
        compare = data.compare
        model: Model | None = None if compare.model == "auto" else compare.model
        physics = Physics(
            exact_offset=compare.exact_offset,
            reversed_flow=compare.reversed_flow,
            tip_loss=compare.tip_loss,
            kinematic_rates=compare.kinematic_rates,
        )
        tolerances = [(Metric.RELATIVE, t) for t in compare.tolerances] + [
            (Metric.ABSOLUTE, t) for t in compare.absolute_tolerances
        ]
        mu = data.axes.advance_ratio
        plan = Plan(
            rotors=tuple(_rotors(data.rotors, path.parent)),
            advance_ratio=np.array(_values(mu)),
            model=model,
            physics=physics,
            tolerances=tuple(tolerances),
            mu_max=compare.mu_max,
        )
    except ConfigError:
        raise
    except InputError as error:
        raise ConfigError(path, [Problem(0, "", str(error))]) from error
    return Study(
        name=data.study.name,
        title=data.study.title or data.study.name,
        text=path.read_text(encoding="utf-8"),
        plan=plan,
    )


def _values(axis: Axis) -> list[float]:
    return axis.values() if isinstance(axis, Range) else axis


def _rotors(table: RotorsTable, folder: Path) -> Iterator[Rotor]:
    """The rotors of a study in the order files, list, grid, sobol."""
    if not (table.files or table.rotors or table.grid or table.sobol):
        raise InputError("[rotors] is empty: give files = [...], list = [...], grid = {...} or sobol = {...}")
    for file in table.files:
        yield load_rotor(folder / file)
    for values in table.rotors:
        yield _rotor(values)
    if table.grid:
        yield from _grid(table.grid)
    if table.sobol:
        yield _sobol(dict(table.sobol))


def _rotor(values: Mapping[str, Any]) -> Rotor:
    """A rotor from keys as they are written, hub as a word."""
    fields = dict(values)
    if isinstance(hub := fields.get("hub"), str):
        known = [h.name.lower() for h in Hub]
        if hub.lower() not in known:
            raise InputError(f"hub {hub!r} is neither articulated nor teetering{did_you_mean(hub.lower(), known)}")
        fields["hub"] = Hub[hub.upper()]
    return Rotor(**fields)


def _grid(grid: Mapping[str, Any]) -> Iterator[Rotor]:
    """The outer product of the axes, the last one fastest; one Rotor a number of blades and hub."""
    axes = {name: _axis(name, value) for name, value in grid.items()}
    outer = {n: axes.pop(n) for n in ("hub", "blades") if n in axes}
    mesh = np.meshgrid(*[np.array(v, float) for v in axes.values()], indexing="ij") if axes else []
    values = {name: m.ravel() for name, m in zip(axes, mesh, strict=True)}
    for chosen in product(*outer.values()):
        yield _rotor(dict(zip(outer, chosen, strict=True)) | values)


def _axis(name: str, value: Any) -> list[Any]:
    if isinstance(value, dict):
        return (
            Range.model_validate(value).values() if set(value) == {"start", "stop", "count"} else _no_axis(name, value)
        )
    return list(value) if isinstance(value, list) and value else [value]


def _no_axis(name: str, value: Any) -> list[Any]:
    raise InputError(
        f"rotors.grid.{name}: {value!r} is no axis: give {{start = …, stop = …, count = …}} or a list of values"
    )


def _sobol(spec: dict[str, Any]) -> Rotor:
    """Sobol points in a box, scrambled with a seed."""
    from scipy.stats import qmc

    count, seed = spec.pop("count", 0), spec.pop("seed", 0)
    fixed = {k: spec.pop(k) for k in ("hub", "blades") if k in spec}
    if not (isinstance(count, int) and count > 0 and count & (count - 1) == 0 and isinstance(seed, int)):
        raise InputError(
            f"rotors.sobol: count = {count!r} is no power of two above 0 (with a whole seed): "
            "Sobol points keep their balance only so"
        )
    bounds = {}
    for name, value in spec.items():
        if not (isinstance(value, list) and len(value) == 2 and value[0] < value[1]):
            raise InputError(f"rotors.sobol.{name}: {value!r} is no interval: give [low, high]")
        bounds[name] = value
    unit = qmc.Sobol(len(bounds), scramble=True, rng=np.random.default_rng(seed)).random(count)
    return _rotor(
        fixed | {name: low + (high - low) * unit[:, i] for i, (name, (low, high)) in enumerate(bounds.items())}
    )


# ---------------------------------------------------------------------- shards
@dataclass(frozen=True)
class Shard:
    """A range of a table: rows of points, designs of limits."""

    table: str
    start: int
    stop: int

    @property
    def file(self) -> str:
        """Its name in the folder."""
        return f"{self.table}-{self.start:012d}-{self.stop:012d}.h5"


def _sizes(plan: Plan) -> dict[str, int]:
    """Shard sizes, fixed for a study."""
    counts = {"points": plan.points, "limits": plan.designs if plan.tolerances else 0}
    bounds = {"points": POINT_SHARD, "limits": LIMIT_SHARD}
    return {t: int(np.clip(math.ceil(n / SHARDS), *bounds[t])) for t, n in counts.items() if n}


def _shards(plan: Plan) -> list[Shard]:
    """All shards; limits first, for they take longest."""
    counts, sizes = {"points": plan.points, "limits": plan.designs}, _sizes(plan)
    return [
        Shard(t, i, min(i + sizes[t], counts[t]))
        for t in ("limits", "points")
        if t in sizes
        for i in range(0, counts[t], sizes[t])
    ]


def _make(plan: Plan, shard: Shard, folder: Path, study_id: str) -> str:
    """Compute a shard and write it: what a worker does."""
    rows = TABLE_ROWS[shard.table](plan, shard.start, shard.stop)
    store.write(folder / shard.file, {shard.table: rows}, {"study_id": study_id, "engine_version": ENGINE})
    return shard.file


def _sound(shard: Shard, folder: Path, study_id: str) -> bool:
    """Whether a shard is there, whole and of this study."""
    try:
        with store.open_file(folder / shard.file) as file:
            return file.attributes.get("study_id") == study_id and not any(True for _ in file.damaged())
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
        designs=plan.designs, points=plan.points, limits=limits, shards=len(_shards(plan)), bytes=int(total)
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
        ``progress(done, total)`` in rows.
    """
    began, out, study_id = time.monotonic(), Path(out), study.id
    if workers < 1:
        raise InputError(f"workers = {workers} is no number of processes: give 1 or more")
    shards, folder = _shards(study.plan), parts_of(out)
    if out.exists() and _finished(out, study_id, resume):
        return RunReport(path=out, points=study.plan.points, limits=0, seconds=0.0, computed=0, reused=len(shards))
    with _locked(folder, study, resume):
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


def _finished(out: Path, study_id: str, resume: bool) -> bool:
    """Whether ``out`` is this study, finished; anything else there is refused."""
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
    return True


@contextlib.contextmanager
def _locked(folder: Path, study: Study, resume: bool) -> Iterator[None]:
    """The study's folder, made or taken up, for one run at a time."""
    from filelock import FileLock, Timeout

    described = json.dumps(
        {
            "study_id": study.id,
            "sizes": _sizes(study.plan),
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
            if json.loads(journal.read_text(encoding="utf-8")).get("study_id") != study.id:
                raise InputError(
                    f"{folder} holds an unfinished run of another study: choose another output, or remove the folder"
                )
        else:
            with store.atomic(folder / "study.toml") as temporary:
                temporary.write_text(study.text, encoding="utf-8")
            with store.atomic(journal) as temporary:
                temporary.write_text(described, encoding="utf-8")
        yield
    finally:
        lock.release()


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
    """Progress in shares of points: a design's limits count as many rows as a shard of points has to a design."""
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
    with _engine(workers if len(todo) > 1 else 1, executor) as engine:
        for shard, result in _results(engine, study, todo, folder):
            try:
                result()
            except InputError as error:
                failed.append((shard.file, str(error)))
            except BrokenExecutor as error:
                raise FailedError(
                    "a worker process died, perhaps for want of memory; finished shards are kept: "
                    "go on with --resume and fewer --workers"
                ) from error
            count(shard)
    return failed


def _results(
    engine: Executor | None, study: Study, todo: Sequence[Shard], folder: Path
) -> Iterator[tuple[Shard, Callable[[], str]]]:
    """Each shard as it is done (or, in this process, to be done), with what gives its result or raises."""
    if engine is None:
        for shard in todo:
            yield shard, functools.partial(_make, study.plan, shard, folder, study.id)
        return
    futures = {engine.submit(_make, study.plan, shard, folder, study.id): shard for shard in todo}
    for future in as_completed(futures):
        yield futures[future], future.result


@contextlib.contextmanager
def _engine(workers: int, executor: Executor | None) -> Iterator[Executor | None]:
    """The executor given, a pool of fresh processes, or None for this process."""
    if executor is not None or workers == 1:
        yield executor
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


# ---------------------------------------------------------------------- packing and merging
def pack(folder: str | Path, out: str | Path) -> dict[str, int]:
    """Check all shards of a study's folder and write them as one database; the rows of each table."""
    folder = Path(folder)
    journal = folder / "study.json"
    if not journal.is_file():
        raise DatabaseError(
            folder, "this is not the folder of a study: pack takes OUT.h5.parts, which floquet run leaves when it stops"
        )
    try:
        about = json.loads(journal.read_text(encoding="utf-8"))
        shards = {
            t: _listed(t, about["designs" if t == "limits" else "points"], size) for t, size in about["sizes"].items()
        }
    except (ValueError, KeyError, TypeError) as error:
        raise DatabaseError(folder, "its study.json is damaged: run the study again") from error
    missing = [s.file for group in shards.values() for s in group if not (folder / s.file).exists()]
    if missing:
        raise DatabaseError(
            folder,
            f"{len(missing)} of {sum(map(len, shards.values()))} shards are missing: finish the study with --resume",
        )
    attributes = _attributes(
        about["title"],
        about["study_id"],
        about["names"],
        about["options"],
        (folder / "study.toml").read_text(encoding="utf-8"),
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
        rows = {t: sum(f.rows(t) for f in files if t in f.tables) for t in first.tables}
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


# ---------------------------------------------------------------------- ways out
def export(path: str | Path, out: str | Path, table: str = "points") -> Path:
    """Write a table as .csv, .parquet or .nc (by the ending of ``out``), flags as their words in CSV."""
    out = Path(out)
    kinds = {".csv": _to_csv, ".parquet": _to_parquet, ".nc": _to_netcdf}
    if out.suffix not in kinds:
        raise InputError(
            f"{out}: {out.suffix or 'no ending'} is no format of export{did_you_mean(out.suffix, kinds)}; "
            "end the name in .csv, .parquet or .nc"
        )
    with store.open_file(path) as file, store.atomic(out) as temporary:
        kinds[out.suffix](file, table, temporary)
    return out


def _to_csv(file: store.File, table: str, out: Path) -> None:
    import csv

    columns = store.stored_variables(file.columns(table))
    with out.open("w", newline="", encoding="utf-8") as target:
        writer = csv.writer(target)
        writer.writerow(columns)
        for _, rows in file.chunks(table, list(columns)):
            words = {
                n: [f.get(v, v) for v in rows[n].tolist()] if (f := c.flags) else rows[n].tolist()
                for n, c in columns.items()
            }
            writer.writerows(zip(*words.values(), strict=True))


def _to_parquet(file: store.File, table: str, out: Path) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError("export to Parquet needs pyarrow: install floquet-rotor[export]") from None
    columns = list(store.stored_variables(file.columns(table)))
    writer = None
    for _, rows in file.chunks(table, columns):
        batch = pa.table(rows)
        writer = writer or pq.ParquetWriter(out, batch.schema)
        writer.write_table(batch)
    if writer is not None:
        writer.close()


def _to_netcdf(file: store.File, table: str, out: Path) -> None:
    try:
        import xarray
    except ImportError:
        raise InputError("export to netCDF needs xarray and h5netcdf: install floquet-rotor[export]") from None
    with xarray.open_dataset(file.path, group=table, engine="h5netcdf") as data:
        data.assign_attrs({k: v for k, v in file.attributes.items() if isinstance(v, str | int | float)}).to_netcdf(
            out, engine="h5netcdf"
        )
