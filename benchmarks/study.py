"""Ten million points from a study file to a packed database, beside the exponents alone on the same cores."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.machine import all_cores
from benchmarks.timing import plain, table
from floquet import Rotor, flapping, stability

__all__ = ["main"]

ADVANCE_RATIOS = 1000
DESIGNS_AT_ONCE = 1000
STUDY = """\
[study]
name = "ten-million"
title = "Speed of a whole study"

[rotors.grid]
lock_number = {{ start = 2.0, stop = 16.0, count = {designs} }}
hinge_offset = {{ start = 0.0, stop = 0.15, count = 10 }}
pitch_flap_coupling = {{ start = -0.3, stop = 0.3, count = 10 }}

[axes]
advance_ratio = {{ start = 0.0, stop = 1.0, count = {ratios} }}

[compare]
tolerances = []

[output]
columns = ["exponent_1", "exponent_2", "exponent_error", "tpp_regressing_1", "tpp_coning_1", "tpp_advancing_1",
           "error_regressing", "error_coning", "error_advancing"]
"""


def main() -> None:
    """The table, for as many points as ``POINTS`` in the environment says."""
    points = int(float(os.environ.get("POINTS", "1e7")))
    count = max(points // (100 * ADVANCE_RATIOS), 1)
    with all_cores() as cores, tempfile.TemporaryDirectory(prefix="floquet-study-") as folder:
        os.environ["FLOQUET_THREADS"] = str(cores)
        alone = exponents_alone(count)
        whole, size, memory = whole_study(Path(folder), count, cores)
    total = count * 100 * ADVANCE_RATIOS
    rows = [
        ["exponents, bounds, branch, verdict", plain(alone), plain(1e6 * alone / total), "1", ""],
        [
            "the study: those, TPP eigenvalues, errors, packed HDF5 with digests",
            plain(whole),
            plain(1e6 * whole / total),
            plain(whole / alone),
            f"{memory / 1e6:.0f} MB a process, {size / 1e6:.0f} MB on disk",
        ],
    ]
    heads = [f"{total:.0e} points, {cores} cores", "s", "µs a point", "times the exponents", ""]
    print(f"### A whole study\n\n{table(heads, rows)}\n", flush=True)


def exponents_alone(count: int) -> float:
    """Seconds, in blocks of a million."""
    gamma = np.repeat(np.linspace(2.0, 16.0, count), 100)
    offset = np.tile(np.repeat(np.linspace(0.0, 0.15, 10), 10), count)
    K1 = np.tile(np.linspace(-0.3, 0.3, 10), 10 * count)
    mu = np.linspace(0.0, 1.0, ADVANCE_RATIOS)

    def block(start: int) -> None:
        some = slice(start, start + DESIGNS_AT_ONCE)
        design = {"lock_number": gamma[some], "hinge_offset": offset[some], "pitch_flap_coupling": K1[some]}
        stability(flapping(Rotor(**{name: value[:, None] for name, value in design.items()}), mu))

    block(0)
    began = time.perf_counter()
    for start in range(0, len(gamma), DESIGNS_AT_ONCE):
        block(start)
    return time.perf_counter() - began


def whole_study(folder: Path, count: int, cores: int) -> tuple[float, int, float]:
    """Seconds of ``floquet run``, bytes of the database, largest memory of a process in bytes."""
    study, out = folder / "study.toml", folder / "out.h5"
    study.write_text(STUDY.format(designs=count, ratios=ADVANCE_RATIOS))
    command = [sys.executable, "-m", "floquet", "run", str(study), "-o", str(out), "--workers", str(cores)]
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seconds = time.perf_counter() - began
    return seconds, out.stat().st_size, 1024.0 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
