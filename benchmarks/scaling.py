"""How the time a point changes: with their number, the Lock number, the number of blades, and threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.machine import all_cores
from benchmarks.peers import Call
from benchmarks.peers.ours import BATCH, WAYS, blade_call, rotor_call, rotor_of
from benchmarks.points import draw
from benchmarks.timing import Lap, interleave, microseconds, ratio, table
from floquet import flapping, stability

__all__ = ["main"]

SIZES = tuple(10**k for k in range(8))
AT_ONCE = 10**6  # points in one call: more are a loop over such calls, so that memory stays below half a GB
PATIENCE = 12.0  # seconds that one call may take; larger sizes are left out
LOCK_NUMBERS = (2, 4, 8, 16, 32, 64)
BLADES = (2, 3, 4, 5, 6, 7, 8, 10, 12)
ROUNDS = 3
SEED = 11
THREADS = "FLOQUET_THREADS"


def main() -> None:
    for title, text in (
        ("Number of points", points_table()),
        ("Lock number", lock_numbers()),
        ("Number of blades", blades()),
        ("Threads", threads()),
    ):
        print(f"### {title}\n\n{text}\n", flush=True)


def points_table() -> str:
    """Powers of ten, the large ones in blocks."""
    laps: dict[int, Lap] = {}
    for size in SIZES:
        block = draw(min(size, AT_ONCE), SEED)
        laps[size] = Lap(repeated(blade_call(block), size // len(block)), size)
        if 10 * laps[size].once() > PATIENCE:
            break
    interleave(list(laps.values()), ROUNDS)
    rows = [[f"{size:,}".replace(",", " "), microseconds(lap)] for size, lap in laps.items()]
    left = [size for size in SIZES if size not in laps]
    note = f"\n\nLeft out, because a call would take longer than {PATIENCE:g} s: {left}." if left else ""
    return table(["points", "µs a point"], rows) + note


def repeated(call: Call, times: int) -> Callable[[], None]:
    """A loop over a call, whose answers are dropped."""

    def loop() -> None:
        for _ in range(times):
            call()

    return loop


def lock_numbers() -> str:
    """A large batch at each; panels are what the equation asks for."""
    rows, laps = [], []
    for gamma in LOCK_NUMBERS:
        points = draw(BATCH, SEED)
        points[:, 0] = gamma
        laps.append(Lap(blade_call(points), BATCH))
        panels = stability(flapping(rotor_of(points), points[:, 4])).panels
        rows.append([f"{gamma}", f"{np.mean(panels):.1f}"])
    interleave(laps, ROUNDS)
    return table(
        ["γ", "panels a revolution, mean", "µs a point"],
        [[*row, microseconds(lap)] for row, lap in zip(rows, laps, strict=True)],
    )


def blades() -> str:
    """The 2N states of N blades, one column a way to treat them."""
    points = draw(200, SEED)
    laps = {(w, N): Lap(rotor_call(points, blades=N, ways=WAYS[w]), len(points)) for w in WAYS for N in BLADES}
    interleave(list(laps.values()), ROUNDS)
    heads = ["N blades", "states", *(f"{way}, µs a point" for way in WAYS)]
    rows = [[f"{N}", f"{2 * N}", *(microseconds(laps[w, N]) for w in WAYS)] for N in BLADES]
    return table(heads, rows)


def threads() -> str:
    """One large call by one thread, then by one on every core."""
    call = blade_call(draw(16 * BATCH, SEED))

    def on(count: int) -> None:
        os.environ[THREADS] = str(count)
        call()

    with all_cores() as cores:
        counts = [2**k for k in range(cores.bit_length()) if 2**k <= cores]
        laps = [Lap(partial(on, count), 16 * BATCH) for count in counts]
        interleave(laps, ROUNDS)
    os.environ[THREADS] = "1"
    rows = [[f"{n}", microseconds(lap), ratio(laps[0].best / lap.best)] for n, lap in zip(counts, laps, strict=True)]
    return table(["threads", "µs a point", "times as fast"], rows)
