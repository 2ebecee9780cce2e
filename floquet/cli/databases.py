"""Commands that make databases and look after them."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from floquet.cli.options import command, output_file, output_flags, table_flag, workers_flag
from floquet.cli.talk import answer, fail, progress, say, show
from floquet.errors import DamageError, InputError

if TYPE_CHECKING:
    from floquet.study import Study


@command.command()
@click.argument("file", metavar="STUDY.toml")
@output_file
@click.option("--resume", is_flag=True, help="Go on with a run that was stopped; keep a finished output.")
@click.option("--extend", is_flag=True, help="The study has grown: compute what the output lacks, and replace it.")
@click.option("--dry-run", is_flag=True, help="Say what would be computed, and how long it may take, and stop.")
@click.option(
    "--columns",
    multiple=True,
    help="Columns of points to store, separated by commas; '*' is all (left out: [output] columns of the study).",
)
@workers_flag
@click.option(
    "--dask", metavar="WHERE", help="Compute on the Dask scheduler at tcp://host:port, or on a local cluster."
)
@output_flags
def run(
    file: str, output: str, resume: bool, extend: bool, dry_run: bool, columns: tuple[str, ...], workers: int | None,
    dask: str | None, style: str | None,
) -> int:  # fmt: skip
    """Run a study into a database.

    A run that is stopped keeps its finished parts and goes on with --resume.  STUDY.toml is described, with an example,
    in docs/files.md, and runs on several machines (--dask) in docs/running.md.
    """
    from floquet import report, study
    from floquet.cluster import LOCAL

    if dask not in (None, LOCAL) and workers is not None:
        raise InputError(f"--workers goes with --dask {LOCAL}: the scheduler at {dask} has its own")
    loaded = study.load_study(file)
    if columns:
        loaded = loaded.storing(separated(columns))
    if dry_run:
        say("floquet: a sample is made to see how long it takes")
        count = processors() if workers is None else workers
        estimate = study.dry_run(loaded, workers=count, out=output, resume=resume, extend=extend)
        show(style, estimate, lambda: report.estimate_text(estimate), lambda: [report.fields(estimate)])
        return 0
    return run_study(loaded, output, resume, workers, style, dask, extend)


def run_study(
    loaded: Study, output: str, resume: bool, workers: int | None, style: str | None, dask: str | None = None,
    extend: bool = False,
) -> int:  # fmt: skip
    from floquet import cluster, report, study

    count = processors() if workers is None else workers
    try:
        with (
            progress(f"{loaded.name}, parts", loaded.plan.points) as done,
            contextlib.nullcontext() if dask is None else cluster.dask(dask, count) as executor,
        ):
            finished = study.run(
                loaded, output, resume=resume, extend=extend, workers=count, executor=executor, progress=done
            )
    except KeyboardInterrupt:
        say(f"floquet: the finished parts are kept in {study.parts_of(output)}: go on with --resume")
        raise
    show(style, finished, lambda: report.run_text(finished), lambda: [report.fields(finished)])
    for part, reason in finished.failed:
        say(f"floquet: {part}: {reason}")
    return 3 if finished.failed else 0


def separated(given: Sequence[str]) -> list[str]:
    """Columns that were given with commas between, or by several options."""
    names = [name.strip() for part in given for name in part.split(",") if name.strip()]
    if given and not names:
        raise InputError("--columns is empty: name columns with commas between, '*' for all, or leave it out")
    return names


def processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@command.command()
@click.argument("folder")
@click.option("-o", "--output", help="Database to write (left out: the folder's name without .parts).")
def pack(folder: str, output: str | None) -> None:
    """Make one database of the parts of a study.

    Every part is checked; this is what a run does at its end.
    """
    from floquet import study

    target = output or folder.rstrip("/").removesuffix(".parts")
    if Path(target).exists():
        raise InputError(f"{target} is there already: name another file with -o, or move it away")
    rows = study.pack(folder, target)
    answer(f"{target}: " + ", ".join(f"{count} rows of {table}" for table, count in rows.items()))


@command.command()
@click.argument("files", nargs=-1, required=True)
@output_file
def merge(files: tuple[str, ...], output: str) -> None:
    """Several databases as one.

    They must come from the same equations: the same engine and options.
    """
    from floquet import study

    rows = study.merge(files, output)
    answer(f"{output}: " + ", ".join(f"{count} rows of {table}" for table, count in rows.items()))


@command.command()
@click.argument("file")
@click.option("--sample", default=20, show_default=True, metavar="N", help="Rows that are computed again; 0 is none.")
@click.option("--seed", default=0, show_default=True, metavar="N", help="Which rows.")
def verify(file: str, sample: int, seed: int) -> int:
    """Whether everything in a database is as it was written.

    Digests, schema, ranges and flags, and some rows that are computed again.  Another process looks at the file, so
    that a damaged or hostile one can do no harm.
    """
    from floquet import checking

    try:
        answer(f"{file}: {checking.check(file, sample=sample, seed=seed)}")
    except DamageError as error:
        answer("\n".join(error.places))
        return fail(str(error), 1)
    return 0


@command.command()
@click.argument("database")
@output_file
@table_flag
def export(database: str, output: str, table: str) -> None:
    """A table of a database as .csv, .json, .parquet or .nc.

    The ending of the output decides; a file of that name is replaced.  floquet query writes some rows and columns.
    """
    from floquet.export import export as exported

    say(f"wrote {exported(database, output, table)}")
