"""Interleaved rounds: everybody is timed once a round, in turn, so that what disturbs the machine disturbs all alike.

Given are the quickest call, which is the code's own time, and the median of the rounds' means, which is what one meets.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["Lap", "interleave", "microseconds", "ratio", "table"]

ROUNDS = 7
SLOT = 0.02  # seconds of a lap in one round, at least: a short call is repeated


@dataclass(eq=False)
class Lap:
    """A call, and what it took a point: the quickest call of all, and the mean call of every round."""

    call: Callable[[], Any]
    points: int
    best: float = math.inf
    rounds: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        return float(np.median(self.rounds))

    def once(self) -> float:
        """Seconds of one call."""
        start = time.perf_counter()
        self.call()
        return time.perf_counter() - start

    def run(self, calls: int) -> None:
        """One round."""
        times = [self.once() / self.points for _ in range(calls)]
        self.best = min(self.best, *times)
        self.rounds.append(sum(times) / calls)


def interleave(laps: Sequence[Lap], rounds: int = ROUNDS, slot: float = SLOT) -> None:
    """Warm every lap up, then time all of them, round by round, forwards and backwards in turn."""
    repeats = [max(1, math.ceil(slot / warm(lap))) for lap in laps]
    gc.collect()
    gc.disable()
    try:
        for n in range(rounds):
            for lap, count in list(zip(laps, repeats, strict=True))[:: 1 if n % 2 else -1]:
                lap.run(count)
    finally:
        gc.enable()


def warm(lap: Lap) -> float:
    """Seconds a call takes once caches are filled and code is compiled; long calls are not made twice."""
    first = lap.once()
    return first if first > 1.0 else lap.once()


def microseconds(lap: Lap) -> str:
    """``2.07 / 2.11``: minimum and median, a point."""
    return " / ".join(plain(1e6 * seconds) for seconds in (lap.best, lap.median))


def ratio(value: float) -> str:
    """Two digits are all that a busy machine gives."""
    return plain(float(f"{value:.2g}"))


def plain(value: float) -> str:
    """Three digits, without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown, columns aligned: the first left, others right."""
    widths = [max(len(head), 3, *(len(row[i]) for row in rows)) for i, head in enumerate(heads)]

    def line(cells: Sequence[str]) -> str:
        padded = [c.ljust(w) if i == 0 else c.rjust(w) for i, (c, w) in enumerate(zip(cells, widths, strict=True))]
        return f"| {' | '.join(padded)} |"

    rule = [("-" * w) if i == 0 else "-" * (w - 1) + ":" for i, w in enumerate(widths)]
    return "\n".join([line(heads), line(rule), *(line(row) for row in rows)])
