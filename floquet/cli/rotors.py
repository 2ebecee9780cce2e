"""Commands on rotors: what they are, how stable, and how far the simple model holds."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from floquet.cli.options import (
    ROTOR_FLAGS,
    command,
    flag,
    knots_flag,
    output_flags,
    physics_flags,
    rotor_flags,
    tolerance_flags,
)
from floquet.cli.talk import progress, show
from floquet.errors import FloquetWarning, InputError, ParameterError

if TYPE_CHECKING:
    from floquet.rotor import Rotor

PHYSICS = ("model", "exact_offset", "reversed_flow", "tip_loss", "kinematic_rates")


def given(values: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """The options that were used, out of those named; a flag that is off was not used."""
    return {name: values[name] for name in names if values[name] is not None and values[name] is not False}


def rotor_of(file: str | None, values: Mapping[str, Any]) -> Rotor:
    """A rotor from its file and the flags that override it."""
    from floquet import rotor as rotors

    changes = given(values, [name for name, *_ in ROTOR_FLAGS] + ["hub"])
    if file is None and "lock_number" not in changes:
        raise ParameterError("lock_number", None, "no rotor was given: name a rotor file, or give --lock-number 8")
    if file is None and changes.get("hub") == "teetering":
        changes.setdefault("blades", 2)
    one = rotors.Rotor(**changes) if file is None else rotors.load_rotor(file).replace(**changes)
    if sentence := rotors.doubtful(one):
        warnings.warn(sentence, FloquetWarning, stacklevel=2)
    return one


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
    if tolerance > 1.0 and metric.upper() != "ABSOLUTE":
        warnings.warn(f"--tolerance {tolerance:g} is {100 * tolerance:g} %: 5 % is 0.05", FloquetWarning, stacklevel=2)
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
