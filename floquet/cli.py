"""The command line: parse → one library call → print.

Results go to stdout, talk to stderr.  Exit status: 0 done (also for an unstable rotor or an empty answer), 1 failed
(disk full, damage found), 2 bad input (also a damaged or foreign file), 3 finished with failed points, 130 interrupted;
a closed pipe is silent.  Everything heavy is imported inside the commands, so that ``floquet --help`` loads none of it.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click

from floquet import __version__
from floquet.environment import check_environment
from floquet.errors import (
    DamageError,
    FailedError,
    FloquetError,
    FloquetWarning,
    InputError,
    ParameterError,
    did_you_mean,
)

if TYPE_CHECKING:
    from floquet.rotor import Rotor
    from floquet.study import Study

__all__ = ["main"]

Command = TypeVar("Command", bound=Callable[..., Any])

ROTOR_FLAGS: tuple[tuple[str, Any, str], ...] = (
    ("lock_number", float, "Lock number γ."),
    ("hinge_offset", float, "Flap hinge offset ε = e/R."),
    ("hinge_stiffness", float, "Hinge spring κ = K_β/(I_β Ω²)."),
    ("pitch_flap_coupling", float, "Pitch-flap coupling K₁ = tan δ₃."),
    ("offset_mass_ratio", float, "e M_β/I_β (left out: ε times the static moment ratio)."),
    ("static_moment_ratio", float, "R M_β/I_β (left out: 1.5)."),
    ("flap_damping", float, "Mechanical flap damping C_β/(I_β Ω)."),
    ("root_cutout", float, "No lift inboard of this fraction of the radius."),
    ("blades", int, "Number of blades."),
    ("rotor_speed", float, "Ω in rad/s, for output in Hz and seconds, and for knots."),
    ("radius", float, "R in m, for knots."),
    ("name", str, "What to call the rotor."),
)
"""The fields of Rotor as flags (and ``--hub``); a test holds them against ``Rotor``."""


class Word(click.Choice[str]):
    """A choice that suggests the nearest word."""

    def __init__(self, *words: str) -> None:
        super().__init__(words, case_sensitive=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            if near := did_you_mean(str(value).lower(), [str(word) for word in self.choices]):
                self.fail(error.message.rstrip(".") + near, param, ctx)
            raise


MODES = Word("regressing", "coning", "advancing", "differential")
METRICS = Word("relative", "absolute", "frequency", "damping")


def options(*made: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several options as one decorator, shown in the order given."""
    return lambda command: functools.reduce(lambda inner, option: option(inner), reversed(made), command)


def flag(name: str) -> str:
    return "--" + name.replace("_", "-")


rotor_flags = options(
    *(click.option(flag(name), type=kind, default=None, help=text) for name, kind, text in ROTOR_FLAGS),
    click.option("--hub", type=Word("articulated", "teetering"), help="How the blades are held."),
)
physics_flags = options(
    click.option("--model", type=Word("flapping", "teetering"), help="Equations of motion (left out: by the hub)."),
    click.option("--exact-offset", is_flag=True, help="Integrals exact in ε in place of the truncation at ε²."),
    click.option("--reversed-flow", is_flag=True, help="Lift reverses where the blade is flown over from behind."),
    click.option("--tip-loss", type=float, default=None, help="No lift outboard of this fraction of the radius."),
    click.option("--kinematic-rates", is_flag=True, help="(1 + m) in the columns of body angular acceleration."),
)
tolerance_flags = options(
    click.option(
        "--tolerance",
        type=float,
        default=0.05,
        show_default=True,
        help="Error at which a mode fails: 0.05 is 5 %, for the metric absolute 0.05 per rev.",
    ),
    click.option("--metric", type=METRICS, default="relative", show_default=True, help="How the error is measured."),
    click.option("--mode", "modes", type=MODES, multiple=True, help="Only this mode (may be repeated)."),
    click.option("--mu-max", type=float, help="Last advance ratio looked at (left out: 1)."),
)


def _style(context: click.Context, option: click.Parameter, chosen: bool) -> None:
    """Keep the one style that was asked for."""
    before = context.params.setdefault("style", None)
    if chosen and before is not None:
        raise click.UsageError("--json and --csv are two answers: give one of them", context)
    if chosen:
        context.params["style"] = str(option.name).removeprefix("as_")


output_flags = options(
    click.option("--json", "as_json", is_flag=True, expose_value=False, callback=_style,
                 help="Strict JSON: nan is null, inf is \"inf\"."),
    click.option("--csv", "as_csv", is_flag=True, expose_value=False, callback=_style, help="Comma-separated values."),
)  # fmt: skip
knots_flag = click.option("--knots", type=float, help="Speed V in place of --advance-ratio: μ = V/(ΩR), disc level.")
workers_flag = click.option(
    "--workers", type=click.IntRange(min=1), help="Processes (left out: one for each processor)."
)
table_flag = click.option("--table", default="points", show_default=True, help="points or limits.")
output_file = click.option("-o", "--output", required=True, help="File to write.")

SCREEN = 1000
"""Rows of a table on the screen, unless --limit is given."""
REPORT = "tp1431"
"""The numbered studies' folder among the studies, and in results where they are written."""
FILES = (".png", ".pdf", ".svg", ".csv", ".md", ".html", ".json", ".h5")
"""Endings that no folder of numbered studies has."""
PHYSICS = ("model", "exact_offset", "reversed_flow", "tip_loss", "kinematic_rates")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(__version__, prog_name="floquet", message="%(prog)s %(version)s")
def command() -> None:
    """How stable a rotor is in forward flight, exactly, and where the tip-path-plane model stops being valid.

    A rotor comes from a TOML file, from flags such as --lock-number 8, or from both: flags override the file.
    """
    check_environment()


def given(values: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """The options that were used, out of those named; a flag that is off was not used."""
    return {name: values[name] for name in names if values[name] is not None and values[name] is not False}


def rotor_of(file: str | None, values: Mapping[str, Any]) -> Rotor:
    """A rotor from its file and the flags that override it."""
    from floquet import rotor as rotors

    changes = given(values, [name for name, *_ in ROTOR_FLAGS] + ["hub"])
    if file is not None:
        return rotors.load_rotor(file).replace(**changes)
    if "lock_number" not in changes:
        raise ParameterError("lock_number", None, "no rotor was given: name a rotor file, or give --lock-number 8")
    if changes.get("hub") == "teetering":
        changes.setdefault("blades", 2)
    return rotors.Rotor(**changes)


def asked(one: Rotor, advance_ratio: float | None, knots: float | None) -> float | None:
    """The advance ratio that is asked for, itself or by the speed in knots with the disc level."""
    from floquet.judgement import KNOT

    if knots is None:
        return advance_ratio
    if advance_ratio is not None:
        raise InputError("--knots and --advance-ratio ask for the same: give one of them")
    if not (0.0 <= knots < math.inf):
        raise ParameterError(
            "knots", knots, f"{knots:g} was given; a speed is a finite number of knots, 0 or more: check the sign"
        )
    missing = [name for name in ("rotor_speed", "radius") if not getattr(one, name)]
    if missing:
        flags = " and ".join(flag(name) for name in missing)
        raise InputError(f"--knots {knots:g} is no advance ratio without {flags}: give that, or --advance-ratio")
    assert one.rotor_speed and one.radius
    return knots * KNOT / (one.rotor_speed * one.radius)


def show(style: str | None, records: Any, text: Callable[[], str], rows: Callable[[], Any] | None = None,
         names: Sequence[str] = ()) -> None:  # fmt: skip
    """Print an answer: as text, as JSON, or as CSV (of ``rows`` where the records are nested)."""
    from floquet import report

    if style == "json":
        answer(report.as_json(records))
    elif style == "csv":
        answer(report.as_csv(records if rows is None else rows(), names))
    else:
        answer(text())


def answer(text: str, newline: bool = True) -> None:
    """Results go to stdout; a reader that has left wants no more of them, and click would call that a failure."""
    try:
        click.echo(text, nl=newline)
    except BrokenPipeError:
        _abandon_output()
        raise click.exceptions.Exit(0) from None


def say(sentence: str) -> None:
    """Talk goes to stderr."""
    with contextlib.suppress(OSError):
        click.echo(sentence, err=True)


@contextlib.contextmanager
def progress(what: str, points: int = 0) -> Iterator[Callable[[int, int], None]]:
    """``done(count, total)``: a bar on a terminal, a line every 10 s elsewhere; ``points`` are those of all."""
    pace = Pace(points)
    if sys.stderr is not None and sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[pace]}"),
        )
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(what, total=None, pace="")

            def moved(done: int, total: int) -> None:
                bar.update(task, completed=done, total=total, pace=pace.told(time.monotonic(), done, total))

            yield moved
        return
    last = time.monotonic()

    def line(done: int, total: int) -> None:
        nonlocal last
        told = pace.told(now := time.monotonic(), done, total)
        if now - last >= 10.0:
            last = now
            say(f"{what}: {done} of {total}" + (f", {told}" if told else ""))

    yield line


class Pace:
    """How fast parts come and how long the rest will take, from what came since it was first told."""

    def __init__(self, points: int) -> None:
        self.points, self.began, self.first = points, 0.0, -1

    def told(self, now: float, done: int, total: int) -> str:
        """``120000 points/s, 1 min 20 s left``; nothing before a part has come, nor of the pace without points."""
        if self.first < 0:
            self.began, self.first = now, done
        came, took = done - self.first, now - self.began
        if not came or not took or done >= total:
            return ""
        rate = [f"{float(f'{self.points * came / total / took:.3g}'):.0f} points/s"] if self.points else []
        return ", ".join([*rate, f"{duration(took / came * (total - done))} left"])


def duration(seconds: float) -> str:
    """``45 s``, ``3 min 20 s``, ``2 h 5 min``."""
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if minutes else f"{rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


@command.command()
@click.argument("file", required=False)
@rotor_flags
@output_flags
def rotor(file: str | None, style: str | None, **values: Any) -> None:
    """Parameters of a rotor, their ranges and sources.

    FILE is TOML; docs/files.md has every key with its units and an example.
    """
    from floquet import report

    one = rotor_of(file, values)
    show(style, report.rotor_object(one), lambda: report.rotor_text(one), lambda: report.rotor_records(one))


@command.command()
@click.argument("file", required=False)
@click.option("--advance-ratio", type=float, help="μ = V cos α/(ΩR).")
@knots_flag
@click.option("--harmonics", type=int, help="Harmonics of the simple model (left out: 1, the tip-path plane).")
@click.option("--check", is_flag=True, default=None, help="Compute the exponents again by Koopman–Hill projection.")
@click.option("--certify", is_flag=True, default=None, help="Prove exponents and verdict by ball arithmetic.")
@rotor_flags
@physics_flags
@output_flags
def analyse(
    file: str | None, advance_ratio: float | None, knots: float | None, style: str | None, **values: Any
) -> None:
    """Exponents, lock and verdict at one advance ratio.

    Every exponent has its bound, and the simple model stands beside the exact one, mode by mode.
    """
    from floquet import report
    from floquet.comparison import compare

    one = rotor_of(file, values)
    mu = asked(one, advance_ratio, knots)
    if mu is None:
        raise InputError("no speed was given: add --advance-ratio 0.3, or --knots 120 where Ω and R are known")
    compared = compare(one, mu, **given(values, (*PHYSICS, "harmonics", "check", "certify")))
    record = report.analysis(one, mu, compared)
    show(style, record, lambda: report.analysis_text(one, mu, compared), lambda: report.analysis_rows(record))


@command.command()
@click.argument("files", nargs=-1)
@click.option("--advance-ratio", type=float, default=None, help="Answer for this μ, in words.")
@knots_flag
@rotor_flags
@physics_flags
@tolerance_flags
@output_flags
def validity(
    files: tuple[str, ...], advance_ratio: float | None, knots: float | None, style: str | None, tolerance: float,
    metric: str, modes: tuple[str, ...], mu_max: float | None, **values: Any,
) -> None:  # fmt: skip
    """Where the simple model stops being valid, and why.

    FILES are rotors (TOML), whose limits are computed, or the database of a study, whose limits are read.
    """
    settings: dict[str, Any] = {"tolerance": tolerance, "metric": metric, "modes": modes}
    stored = [file for file in files if not file.endswith(".toml") and Path(file).is_file()]
    if stored:
        speed = {"advance_ratio": advance_ratio, "knots": knots, "mu_max": mu_max}
        flags = given({**values, **speed}, [*values, *speed])
        _stored_limits(files, stored[0], list(flags), style, **settings)
        return
    rotors = [rotor_of(file, values) for file in files or [None]]
    settings |= {"mu_max": 1.0 if mu_max is None else mu_max} | given(values, PHYSICS)
    speeds = [mu for one in rotors if (mu := asked(one, advance_ratio, knots)) is not None]
    if speeds:
        _verdicts(rotors, speeds, style, **settings)
    else:
        _limits(rotors, style, **settings)


def _stored_limits(files: Sequence[str], stored: str, flags: Sequence[str], style: str | None, **settings: Any) -> None:
    from floquet import report
    from floquet.query import open_database

    if len(files) != 1:
        raise InputError(f"{stored} does not end in .toml and is taken for a database, which is given alone")
    if flags:
        raise InputError(f"{flag(flags[0])} goes with a rotor file; what {stored} holds was computed by its study")
    with open_database(stored) as database:
        records = report.stored_limits(database, **settings)
    show(style, records, lambda: report.limit_table(records))


def _limits(rotors: Sequence[Rotor], style: str | None, *, tolerance: float, metric: str, modes: Sequence[str],
            **settings: Any) -> None:  # fmt: skip
    from floquet import report
    from floquet.comparison import Metric
    from floquet.validity import limits

    records = []
    with progress("limits of rotors") as done:
        for i, one in enumerate(rotors):
            done(i, len(rotors))
            found = limits(one, tolerances=((Metric[metric.upper()], tolerance),), modes=modes or None, **settings)
            records += report.limit_records(one, found)
    show(style, records, lambda: report.limit_table(records))


def _verdicts(rotors: Sequence[Rotor], speeds: Sequence[float], style: str | None, *, metric: str, modes: Sequence[str],
              **settings: Any) -> None:  # fmt: skip
    from floquet import judgement
    from floquet.comparison import Metric

    answers = [
        judgement.verdict(one, mu, metric=Metric[metric.upper()], modes=modes or None, **settings)
        for one, mu in zip(rotors, speeds, strict=True)
    ]
    records = [record for answer in answers for record in judgement.verdict_records(answer)]
    show(style, records, lambda: "\n\n".join(judgement.verdict_text(answer) for answer in answers))


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
    return _run(loaded, output, resume, workers, style, dask, extend)


def _run(
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
        return _fail(str(error), 1)
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


@command.command()
@click.argument("words", nargs=-1, required=True, metavar="DATABASE... [EXPRESSION]")
@table_flag
@click.option("--columns", multiple=True, help="Columns, separated by commas; '*' is all (left out: a short list).")
@click.option("--by", multiple=True, help="One row for each value of these columns, separated by commas.")
@click.option(
    "--reduce",
    "reduced",
    multiple=True,
    help="What a group is reduced to, separated by commas: min(limit), max(…), mean(…), median(…), first(…), or count "
    "(left out).",
)
@click.option("--sort", help="Column to sort by.")
@click.option("--descending", is_flag=True, help="Largest first.")
@click.option("--limit", type=int, help="Number of rows.")
@click.option(
    "--at",
    "places",
    multiple=True,
    metavar="NAME=NUMBER",
    help="Values between the rows, at this advance_ratio and, of a grid of rotors, at these parameters.",
)
@click.option("-o", "--output", help="File to write: .csv, .json, .parquet or .nc (left out: the screen).")
@output_flags
def query(
    words: tuple[str, ...], style: str | None, columns: tuple[str, ...], by: tuple[str, ...], reduced: tuple[str, ...],
    places: tuple[str, ...], output: str | None, **choice: Any,
) -> None:  # fmt: skip
    """Rows of a database for which an expression holds.

    The EXPRESSION is a comparison of columns, such as 'advance_ratio > 0.3 and lock_number < 6'.  With --by and
    --reduce the rows are counted, or reduced to their least, largest, mean, median or first values, group by group.
    Several databases with the same columns are asked as one, which has a column file.  With --at advance_ratio=0.333
    the columns of one rotor are interpolated, with an estimate of the error; with --at lock_number=7.3 beside it those
    of a design between rotors that are a grid.  docs/query.md has examples.
    """
    from floquet import export, report
    from floquet.query import open_database

    if columns and (by or reduced):
        raise ParameterError("columns", columns, "it names columns of rows, and --by and --reduce those of groups")
    if output is not None:
        export.checked_format(output)
        if style is not None:
            raise InputError(
                f"--{style} is for the screen, and the ending of {output} says the format: give one of them"
            )
    wanted = separated(columns)
    files, expression = files_and_expression(words)
    with open_database(files[0] if len(files) == 1 else files) as opened:
        if places:
            _check_alone(places, {**choice, "by": by, "reduce": reduced, "output": output})
            at: Any = numbers(places)
            found = opened.at(expression, columns=wanted or None, **at)
            records = report.interpolated_records(found)
            show(style, records, lambda: report.table(list(records[0]), [list(r.values()) for r in records]))
            return
        asked = opened.answer(
            expression, columns=wanted or None, by=by or None, reduce=reduced or ("count" if by else None), **choice
        )
        if output is not None:
            say(f"wrote {export.write(asked, output)}")
        elif style is None:
            text, rows = report.answer_table(asked, SCREEN if choice["limit"] is None else None)
            answer(text)
            if choice["limit"] is None and rows > SCREEN:
                say(
                    f"floquet: these are the first {SCREEN} of {rows} rows: give --limit, --csv, --json or a file by -o"
                )
        else:
            for block in export.text(asked, style):
                answer(block, newline=False)


def numbers(given: Sequence[str]) -> dict[str, float]:
    """Settings such as advance_ratio=0.3: an advance ratio, and parameters of a design."""
    from floquet.query.grid import checked_design

    out: dict[str, float] = {}
    for text in given:
        name, _, value = (part.strip() for part in text.partition("="))
        try:
            number = float(value)
        except ValueError:
            raise ParameterError(
                "at", text, f"{text!r} was given; it is a name and a number, as in --at advance_ratio=0.3"
            ) from None
        if name in out:
            raise ParameterError("at", text, f"{name} is given twice")
        out[name.replace("-", "_")] = number
    if "advance_ratio" not in out:
        raise ParameterError("at", given, "no advance ratio was given: add --at advance_ratio=0.3")
    return {"advance_ratio": out.pop("advance_ratio"), **checked_design(out)}


def _check_alone(places: Sequence[str], others: Mapping[str, Any]) -> None:
    """Values between rows are of one design: nothing is sorted, grouped or written."""
    used = [name for name, value in others.items() if value and (name, value) != ("table", "points")]
    if used:
        raise InputError(
            f"--at {places[0]} gives the values of one design between the rows of points: leave {flag(used[0])} out"
        )


def files_and_expression(words: Sequence[str]) -> tuple[list[str], str]:
    """Databases, and after them an expression, unless the last word is a file or called like one."""
    *files, last = words
    return (files, last) if files and not (last.endswith(".h5") or os.path.isfile(last)) else ([*files, last], "")


@command.command()
@click.argument("database")
@click.argument("kind")
@output_file
@click.option("--rotor", help="Name or number (left out: the first); a summary takes several, by commas.")
@click.option("--dpi", type=float, default=200.0, show_default=True, help="Dots per inch of a .png, 20 to 2400.")
def plot(database: str, kind: str, output: str, rotor: str | None, dpi: float) -> None:
    """A figure of a database.

    KIND is root-locus, eigenvalues-vs-mu, error-vs-mu, validity-summary or validity-atlas.
    """
    from floquet.plot import plot_database

    say(f"wrote {plot_database(database, kind, output, rotor, dpi=dpi)}")


@command.command()
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run every study.")
@click.option("-o", "--output", help="File or folder to write, see above.")
@click.option("--resume", is_flag=True, help="Go on with a database that was stopped; keep a finished one.")
@workers_flag
def study(name: str | None, everything: bool, output: str | None, resume: bool, workers: int | None) -> int:
    """List the studies of the package, or run them.

    Without a NAME they are listed.  A numbered study (table-1, figure-3, question-2 ...) writes its figure, its table
    and a page, index.html, into the folder of --output (left out: results/tp1431); any other study writes a database
    (left out: NAME.h5).  --all runs every study, into one folder (left out: results/tp1431).
    """
    from floquet import exhibits
    from floquet import study as studies

    databases = {path.stem: path for path in sorted(studies_folder().glob("*.toml"))}
    numbered = exhibits.find(studies_folder() / REPORT)
    known = databases | numbered
    if name is not None and everything:
        raise InputError(f"{name} and --all ask for one study and for every study: give one of them")
    if name is not None and name not in known:
        sketch = ": figures 1 and 2 of the report are sketches" if name in ("figure-1", "figure-2") else ""
        near = sketch or did_you_mean(name, known) or ": there are " + ", ".join(known)
        raise InputError(f"{name!r} is no study{near}")
    if output is not None and name is None and not everything:
        raise InputError("--output goes with the NAME of one study, or with --all")
    if name is None and not everything:
        titles = {key: studies.load_study(path).title for key, path in databases.items()}
        titles |= {key: exhibits.title(path) for key, path in numbered.items()}
        answer("\n".join(f"{key}: {title}" for key, title in titles.items()))
        return 0
    count = processors() if workers is None else workers
    folder = Path(output or Path("results") / REPORT)
    if name in databases:
        target = folder / f"{name}.h5" if output and folder.is_dir() else Path(output or f"{name}.h5")
        return _run(studies.load_study(databases[name]), str(target), resume, count, None)
    if folder.suffix.lower() in FILES or folder.is_file():
        raise InputError(f"{folder} is no folder, and numbered studies are written into one: name a folder with -o")
    statuses = [0]
    if everything:
        folder.mkdir(parents=True, exist_ok=True)
        statuses += [_run(studies.load_study(path), str(folder / f"{key}.h5"), resume, count, None)
                     for key, path in databases.items()]  # fmt: skip
    chosen = list(numbered.values()) if name is None else [numbered[name]]
    return max(*statuses, _exhibits(chosen, folder, count))


def _exhibits(paths: Sequence[Path], folder: Path, workers: int) -> int:
    import textwrap

    from floquet import exhibits, report

    try:
        with progress("numbered studies") as done:
            failed = exhibits.make_all(paths, folder, workers=workers, progress=done)
    except KeyboardInterrupt:
        say(f"floquet: what is finished is in {folder}, and its page lists it")
        raise
    for name, reason in failed:
        say(f"floquet: {name}: {reason}")
    if len(paths) == 1 and not failed:
        shown = exhibits.read(folder, paths[0].stem)
        answer("\n".join([shown["title"], "", *textwrap.wrap(shown["caption"], 100), ""]))
        answer(report.table(("number", "value"), list(shown["numbers"].items())))
    if paths:
        answer(f"wrote {folder / 'index.html'}: {len(paths) - len(failed)} of {len(paths)} numbered studies")
    return 3 if failed else 0


def studies_folder() -> Path:
    """The studies, in a checkout beside the package and in an installation inside it."""
    package = Path(__file__).parent
    inside = package / "_share" / "studies"
    return inside if inside.is_dir() else package.parent / "studies"


# Ending: every way out has its status.


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit with its status."""
    warnings.showwarning = _shown_once(set())
    warnings.simplefilter("always", FloquetWarning)  # "once" forgets what was said when a library imports
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    sys.exit(_status(arguments))


def _status(arguments: Sequence[str] | None) -> int:
    try:
        status = command.main(arguments, prog_name="floquet", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        return int(status or 0)
    except (click.Abort, KeyboardInterrupt):
        _abandon_output()
        say("floquet: interrupted")
        return 130
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        where = f" (see {context.command_path} --help)" if context else ""
        return _fail(f"{error.format_message()}{where}", error.exit_code)
    except FloquetError as error:
        return _fail(str(error), 1 if isinstance(error, FailedError) else 2)
    except MemoryError:
        return _fail("there is not enough memory for this; ask for fewer rows or columns, or for a smaller study", 1)
    except OSError as error:
        return _operating_system(error)


def _fail(sentence: str, status: int) -> int:
    say("\n".join(f"floquet: {line}" for line in sentence.splitlines()))
    return status


def _operating_system(error: OSError) -> int:
    """Trouble of the system is one sentence."""
    _abandon_output()
    where = f"{error.filename}: " if error.filename else ""
    way_out = "; make room and run the command again" if error.errno == errno.ENOSPC else ""
    return _fail(f"{where}{(error.strerror or str(error)).lower()}{way_out}", 1)


def _abandon_output() -> None:
    """Let the interpreter flush what is left of stdout to nowhere, so that it does not complain on the way out."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _shown_once(said: set[str]) -> Callable[..., None]:
    """Shows each warning when it is new."""

    def show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
        if (text := str(message)) not in said:
            said.add(text)
            say(f"floquet: warning: {text}")

    return show_warning
