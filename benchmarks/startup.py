"""From nothing to a first answer: whole processes, imports and compilers included, in interleaved rounds."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from benchmarks.peers import skip
from benchmarks.peers.ours import BATCH, WITHOUT_NUMBA
from benchmarks.timing import Lap, interleave, table

__all__ = ["main"]

ROOT = Path(__file__).resolve().parents[1]
ROUNDS = 3
BLADES = "from benchmarks.peers import ours; from benchmarks.points import draw; ours.blade_call(draw({}, 1))()"
PEER = (
    "import benchmarks.peers.{} as peer; from benchmarks.points import draw; "
    "next(c for c in peer.contenders(1) if c.shown).prepare(draw(200, 1))()"
)
PEERS = {
    "SciPy": "scipy_ivp", "heyoka": "heyoka_taylor", "numbalsoda": "numbalsoda_c", "diffrax": "diffrax_vmap",
}  # fmt: skip


def main() -> None:
    """The table: minimum and median seconds."""
    with tempfile.TemporaryDirectory() as kept:
        laps = {title: Lap(call, 1) for title, call in commands(kept)}
        interleave(list(laps.values()), ROUNDS)
    rows = [[title, f"{lap.best:.2f} / {lap.median:.2f}"] for title, lap in laps.items()]
    print(f"### Start-up: a process of its own, on one core\n\n{table(['until', 'seconds'], rows)}\n", flush=True)


def commands(kept: str) -> Iterator[tuple[str, Callable[[], None]]]:
    """Title and call of every process; the folder holds compiled kernels from one round to the next."""
    cached = {"NUMBA_CACHE_DIR": kept}
    yield "Python ends again", process("pass")
    yield "`import floquet`", process("import floquet")
    yield "`floquet --help`", process("from floquet.cli import main; main(['--help'])")
    yield "exponents of one blade", process(BLADES.format(1), cached)
    yield f"exponents of {BATCH}, kernels compiled before", process(BLADES.format(BATCH), cached)
    yield f"exponents of {BATCH}, NumPy alone", process(BLADES.format(BATCH), {WITHOUT_NUMBA: "1"})
    yield f"exponents of {BATCH}, nothing compiled yet", uncached(BLADES.format(BATCH))
    for name, module in PEERS.items():
        if importlib.util.find_spec(name.lower()) is None:
            skip(name.lower())
            continue
        yield f"exponents of 200 by {name}", process(PEER.format(module))


def process(code: str, more: Mapping[str, str] | None = None) -> Callable[[], None]:
    """Python with some lines, in this folder and on this core."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | dict(more or {})

    def call() -> None:
        subprocess.run([sys.executable, "-c", code], env=environment, check=True, stdout=subprocess.DEVNULL)

    return call


def uncached(code: str) -> Callable[[], None]:
    """The same with an empty folder for compiled kernels each time."""

    def call() -> None:
        with tempfile.TemporaryDirectory() as empty:
            process(code, {"NUMBA_CACHE_DIR": empty})()

    return call
