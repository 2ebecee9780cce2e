"""Grids of parameters: polynomials between nodes beside every point by itself, in interleaved rounds."""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks.timing import Lap, interleave, microseconds, ratio, table
from floquet import Rotor, flapping, stability
from floquet.period_map import Method
from floquet.periodic import PeriodicSystem

__all__ = ["main"]

ROUNDS = 5
SIDES = (512, 1000, 2000)
DESIGNS = (100, 1000)
RATIOS = 1000
SEED = 3


def main() -> None:
    """The table."""
    rows, laps = [], []
    for title, system, ways in grids():
        points = int(np.prod(system.cases))
        mapped, direct = stability(system, map=ways), stability(system)
        apart = np.abs(mapped.exponents - direct.exponents) / (mapped.exponent_errors + direct.exponent_errors)
        laps.append([Lap(partial(stability, system, map=way), points) for way in (ways, False)])
        rows.append([
            title, f"{100.0 * np.mean(mapped.method == Method.MAP):.2f} %",
            *(f"{np.median(found.exponent_errors):.0e}" for found in (mapped, direct)), f"{apart.max():.2f}",
        ])  # fmt: skip
    interleave([lap for pair in laps for lap in pair], ROUNDS)
    heads = ["grid", "from nodes", "median bound", "direct", "largest distance / bound",
             "map, µs a point", "direct, µs a point", "times as fast"]  # fmt: skip
    timed = [
        [*row, microseconds(quick), microseconds(slow), ratio(slow.best / quick.best)]
        for row, (quick, slow) in zip(rows, laps, strict=True)
    ]
    print(f"### Grids of parameters\n\n{table(heads, timed)}\n", flush=True)


def grids() -> list[tuple[str, PeriodicSystem, bool | str]]:
    """γ × μ, and designs without order × μ."""
    out: list[tuple[str, PeriodicSystem, bool | str]] = []
    for side in SIDES:
        rotor = Rotor(lock_number=np.linspace(2.0, 16.0, side)[:, None])
        out.append((f"{side} γ × {side} μ", flapping(rotor, np.linspace(0.0, 1.0, side)), True))
    for designs in DESIGNS:
        low, high = (2.0, 0.0, 0.0, -0.3), (16.0, 0.15, 0.3, 0.3)
        values = np.random.default_rng(SEED).uniform(low, high, (designs, 4)).T[:, :, None]
        names = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling")
        rotor = Rotor(**dict(zip(names, values, strict=True)))
        system = flapping(rotor, np.linspace(0.0, 1.0, RATIOS))
        out.append((f"{designs} random designs × {RATIOS} μ", system, "advance_ratio"))
    return out
