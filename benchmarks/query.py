"""A question to ten million rows × 8 columns: ``floquet query`` beside PyTables' query in its kernel.

The rows are those of a study, made by ``floquet run``; PyTables has the 8 columns as one table, written with the same
filters (deflate 1, shuffle, Fletcher checksums), and again without any.  Every contender answers in a process of its
own, on all cores, the file first dropped from the system's cache and then in it.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.machine import all_cores
from benchmarks.study import ADVANCE_RATIOS, whole_study
from benchmarks.timing import plain, ratio, table

__all__ = ["main"]

COLUMNS = ("advance_ratio", "lock_number", "hinge_offset", "pitch_flap_coupling", "exponent_error", "error_regressing",
           "error_coning", "error_advancing")  # fmt: skip
QUESTION = "(error_regressing > 0.2) {} (error_coning < 0.05)"
ROUNDS = 5  # of answers from the cache, in each process
PROCESSES = 3  # a contender, in turn
LABELS = {
    "floquet": "floquet: deflate 1, shuffle, blake2b checked",
    "same": "PyTables, in-kernel: deflate 1, shuffle, Fletcher checked",
    "plain": "PyTables, in-kernel: not compressed, nothing checked",
}


def main() -> None:
    """The table, for as many rows as ``POINTS`` in the environment says."""
    if importlib.util.find_spec("tables") is None:
        print("PyTables is not installed (pip install '.[bench]'): the queries are skipped", file=sys.stderr)
        return
    designs = max(int(float(os.environ.get("POINTS", "1e7"))) // (100 * ADVANCE_RATIOS), 1)
    with all_cores() as cores, tempfile.TemporaryDirectory(prefix="floquet-query-") as folder:
        os.environ |= dict.fromkeys(("FLOQUET_THREADS", "NUMEXPR_NUM_THREADS", "NUMEXPR_MAX_THREADS"), str(cores))
        whole_study(Path(folder), designs, cores)
        files = {name: Path(folder) / f"{name}.h5" for name in LABELS}
        (Path(folder) / "out.h5").rename(files["floquet"])
        for name in ("same", "plain"):
            _child("write", files["floquet"], files[name])
        answers = _asked(files)
    [hits] = {answer["hits"] for some in answers.values() for answer in some}
    best = {n: {k: min(a[k] for a in some) for k in ("cold", "warm", "memory")} for n, some in answers.items()}
    rows = [
        [LABELS[n], *(plain(b[k]) for k in ("cold", "warm")), ratio(b["warm"] / best["floquet"]["warm"]),
         plain(b["memory"] / 1e6)]
        for n, b in best.items()
    ]  # fmt: skip
    total = designs * 100 * ADVANCE_RATIOS
    heads = [f"{total:.0e} rows × 8 columns, {hits} hits ({100 * hits / total:.1f} %), {cores} cores", "s, on disk",
             "s, in memory", "times floquet", "MB"]  # fmt: skip
    print(f"### A query\n\n{table(heads, rows)}\n", flush=True)


def _asked(files: dict[str, Path]) -> dict[str, list[dict[str, Any]]]:
    """What each process of each contender says, in turns."""
    answers: dict[str, list[dict[str, Any]]] = {name: [] for name in files}
    for _ in range(PROCESSES):
        for name, file in files.items():
            with file.open("rb") as opened:
                os.posix_fadvise(opened.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
            answers[name].append(json.loads(_child("floquet" if name == "floquet" else "tables", file)))
    return answers


def _child(*arguments: Any) -> str:
    command = [sys.executable, "-m", "benchmarks.query", *map(str, arguments)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


# ---------------------------------------------------------------------- in a process of their own
def write(source: str, target: str) -> None:
    """The columns of a floquet database as a table of PyTables, filtered where it is called ``same``."""
    import tables

    from floquet import store

    kind = np.dtype([(name, "<f8") for name in COLUMNS])
    same = Path(target).stem == "same"
    filters = tables.Filters(1, "zlib", shuffle=True, fletcher32=True) if same else None
    with store.open_file(source) as file, tables.open_file(target, "w") as out:
        made = out.create_table("/", "points", kind, filters=filters, expectedrows=file.rows("points"))
        for _, rows in file.chunks("points", COLUMNS):
            made.append(np.rec.fromarrays([rows[name] for name in COLUMNS], dtype=kind))
    with Path(target).open("rb+") as written:
        os.fsync(written.fileno())  # what is not on disk cannot be dropped from the cache


@contextlib.contextmanager
def _floquet(path: str) -> Iterator[Any]:
    from floquet import open_database

    with open_database(path) as opened:
        yield lambda: opened.query(QUESTION.format("and"), columns=COLUMNS)["lock_number"]


@contextlib.contextmanager
def _tables(path: str) -> Iterator[Any]:
    import tables

    with tables.open_file(path) as opened:
        yield lambda: opened.root.points.read_where(QUESTION.format("&"))["lock_number"]


def ask(contender: str, path: str) -> None:
    """Seconds of the first answer and of the best later one, hits, bytes of memory, as JSON."""
    seconds = []
    with {"floquet": _floquet, "tables": _tables}[contender](path) as question:
        for _ in range(1 + ROUNDS):
            began = time.perf_counter()
            hits = len(question())
            seconds.append(time.perf_counter() - began)
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps({"cold": seconds[0], "warm": min(seconds[1:]), "hits": hits, "memory": memory}))


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(*sys.argv[2:])
    else:
        ask(*sys.argv[1:])
