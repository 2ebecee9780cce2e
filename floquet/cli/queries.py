"""The command that asks databases."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import click

from floquet.cli.databases import separated
from floquet.cli.options import command, flag, output_flags, table_flag
from floquet.cli.talk import answer, say, show
from floquet.errors import InputError, ParameterError

SCREEN = 1000
"""Rows of a table on the screen, unless --limit is given."""


@command.command()
@click.argument("words", nargs=-1, required=True, metavar="DATABASE... [EXPRESSION]")
@table_flag
@click.option("--columns", multiple=True, help="Columns, separated by commas; '*' is all (left out: a short list).")
@click.option("--by", multiple=True, help="One row for each value of these columns, separated by commas.")
@click.option(
    "--reduce",
    "reduced",
    multiple=True,
    help="What a group is reduced to, separated by commas: min(limit), max(…), mean(…), median(…), first(…), "
    "rotor_name at min(limit), or count (left out).",
)
@click.option("--sort", help="Columns to sort by, separated by commas.")
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
            if not rows and "nearest" in expression:
                say("floquet: nearest takes each column by itself, of all rows, and no row has all of these values")
            elif not rows and choice["limit"] != 0:
                say("floquet: no row; numbers must be equal to the last digit, but for nearest(advance_ratio=0.35)")
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
        if (name := name.replace("-", "_")) in out:
            raise ParameterError("at", text, f"{name} is given twice")
        out[name] = number
    speed, design = out.pop("advance_ratio", None), checked_design(out)
    if speed is None:
        raise ParameterError("at", given, "no advance ratio was given: add --at advance_ratio=0.3")
    return {"advance_ratio": speed, **design}


def _check_alone(places: Sequence[str], others: Mapping[str, Any]) -> None:
    """Values between rows are of one design: nothing is sorted, grouped or written."""
    used = [name for name, value in others.items() if value or (value == 0 and value is not False)]
    used = [name for name in used if (name, others[name]) != ("table", "points")]
    if used:
        raise InputError(
            f"--at {places[0]} gives the values of one design between the rows of points: leave {flag(used[0])} out"
        )


def files_and_expression(words: Sequence[str]) -> tuple[list[str], str]:
    """Databases, and after them an expression, unless the last word is a file or called like one."""
    *files, last = words
    return (files, last) if files and not (last.endswith(".h5") or os.path.isfile(last)) else ([*files, last], "")
