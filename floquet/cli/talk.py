"""What the commands print: answers on stdout, sentences and progress on stderr."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import click


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
        abandon_output()
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


def fail(sentence: str, status: int) -> int:
    say("\n".join(f"floquet: {line}" for line in sentence.splitlines()))
    return status


def abandon_output() -> None:
    """Let the interpreter flush what is left of stdout to nowhere, so that it does not complain on the way out."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
