"""N blades in the non-rotating frame, 2N states over one passage 2π/N: the same equations for everybody.

The truth is the single blade's exponents + ik, modulo iN.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.linalg import expm

from benchmarks.equations import multiblade
from benchmarks.peers import contenders
from benchmarks.peers.ours import MANY
from benchmarks.points import Array, draw, errors, stored, truth_of_rotor
from benchmarks.timing import Lap, interleave, plain, table

__all__ = ["main"]

BLADES = (2, 3, 4, 5, 6, 7)
MODULES = ("ours", "heyoka_taylor", "numbalsoda_c", "scipy_ivp")
ROUNDS = 5
OTHER_ROTORS = 13
"""Seed of the large batches; what a call costs whatever the points is spread over them."""
Key = tuple[str, int]


def main() -> None:
    laps, worst = measure()
    labels = list(dict.fromkeys(label for label, _ in laps))
    heads = ["microseconds a point (max error)", *(f"n = {2 * N}" for N in BLADES)]
    rows = [[label, *(cell(laps[label, N], worst.get((label, N))) for N in BLADES)] for label in labels]
    print(f"### N blades in the non-rotating frame (n = 2N states)\n\n{table(heads, rows)}\n", flush=True)


def measure() -> tuple[dict[Key, Lap], dict[Key, float]]:
    """Laps and largest errors by contender and number of blades; how long LAPACK takes for eigenvalues goes along."""
    points = stored()[0]
    laps, worst = {}, {}
    for N in BLADES:
        truth = truth_of_rotor(N)
        for contender in contenders(N, MODULES):
            few = points[: contender.few]
            call = contender.prepare(few)
            key = f"{contender.name}, {contender.setting}", N
            worst[key] = float(errors(call(), truth[: len(few)], float(N)).max())
            laps[key] = Lap(call, len(few))
            if contender.batch == MANY:
                laps[f"{key[0]}, {MANY} at once", N] = Lap(contender.prepare(draw(MANY, OTHER_ROTORS)), MANY)
        laps["LAPACK's eigenvalues alone", N] = Lap(partial(np.linalg.eigvals, averaged_maps(points, N)), len(points))
    interleave(list(laps.values()), ROUNDS)
    return laps, worst


def averaged_maps(points: Array, blades: int) -> Array:
    """Matrices like those whose eigenvalues the peers need: the maps of the averaged equations."""
    equations = multiblade(points, blades)
    return np.asarray(expm(equations.passage * equations.first_order()[:, 0]))


def cell(lap: Lap, error: float | None) -> str:
    """``6.15 (8e-15)``."""
    return plain(1e6 * lap.best) + ("" if error is None else f" ({error:.0e})")
