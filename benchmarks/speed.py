"""One blade, parameters to both exponents: everybody on the same 200 blades, and on batches as large as suits each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.figure import write_work_precision
from benchmarks.peers import Contender, contenders
from benchmarks.points import draw, errors, stored
from benchmarks.timing import Lap, interleave, microseconds, ratio, table

__all__ = ["Result", "main", "measure", "report"]

Array = NDArray[np.float64]
OTHER_BLADES = 9
"""Seed of the large batches."""
OURS = "floquet"


@dataclass(eq=False)
class Result:
    """A contender with the errors of its exponents and its laps: the 200 blades, then the large batch if it has one."""

    contender: Contender
    errors: Array
    laps: list[Lap] = field(default_factory=list)

    @property
    def best(self) -> float:
        """Seconds a point, at the size that suits it."""
        return min(lap.best for lap in self.laps)

    @property
    def label(self) -> str:
        return ", ".join(filter(None, (self.contender.name, self.contender.setting)))


def main() -> None:
    results = measure()
    print(f"### One blade (2 states): parameters to exponents\n\n{report(results)}\n", flush=True)
    print(f"Work and precision of all settings: {write_work_precision(results)}\n", flush=True)


def measure() -> list[Result]:
    """Errors first, then all laps interleaved."""
    blades, truth = stored()
    results = []
    for contender in contenders():
        call = contender.prepare(blades)
        apart = errors(call(), truth, 1.0) if contender.answers else np.full(len(blades), np.nan)
        result = Result(contender, apart, [Lap(call, len(blades))])
        if contender.batch:
            result.laps.append(Lap(contender.prepare(draw(contender.batch, OTHER_BLADES)), contender.batch))
        results.append(result)
    interleave([lap for result in results for lap in result.laps])
    return results


def report(results: Sequence[Result]) -> str:
    """The table: of the times the minimum, and the median behind a stroke."""
    ours = min((r for r in results if r.contender.name == OURS), key=lambda r: r.best)
    heads = ["contender", "max error", "median error", "200 blades, µs each", "batch", "batch, µs each", "× floquet"]
    rows = [
        [
            result.label,
            *(f"{f(result.errors):.0e}" if result.contender.answers else "" for f in (np.max, np.median)),
            microseconds(result.laps[0]),
            str(result.contender.batch or ""),
            microseconds(result.laps[1]) if result.contender.batch else "",
            ratio(result.best / ours.best),
        ]
        for result in results
        if result.contender.shown
    ]
    return table(heads, rows)
