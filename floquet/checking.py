"""Whether a database is what it says: digests, ranges, and some rows computed again.

:func:`check` has a child process look at the file, with limits on its time and memory, so that no file, whoever made
it, can crash, hang or fill the process that asks.  :func:`recompute` takes the parameters of a row as they are stored,
makes the rotor, and computes the row anew.  Where the engine is the one that made the file, both have the same bits;
another engine's exponents are held against the sum of the two error bounds.
"""

from __future__ import annotations

import contextlib
import json
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import store
from .errors import DamageError, DatabaseError, FloquetError, InputError
from .kernels import POINTS, part_of
from .models import Physics
from .period_map import Method
from .rotor import PARAMETERS, Hub, Rotor
from .store.guard import Beat, answer, ask, unlimited_memory
from .sweep import ENGINE, Plan, point_rows

__all__ = ["SAMPLE", "Checked", "Recomputed", "check", "recompute"]

Rows = dict[str, NDArray[Any]]
SAMPLE = 20  # rows that are computed again unless told otherwise
MOST_SECONDS = 600.0  # that computing them may take


@dataclass(frozen=True, kw_only=True)
class Recomputed:
    """How many rows were computed again, and found equal to the bit, or within their bounds; the numbers of others."""

    rows: int
    equal: int
    within: int
    others: tuple[int, ...]
    engine: int


@dataclass(frozen=True, kw_only=True)
class Checked:
    """What was looked at in a database, and was found sound; equal data have equal digests."""

    values: int
    chunks: int
    schema: str
    sealed: bool
    digest: str
    recomputed: Recomputed | None

    def __str__(self) -> str:
        seal = "its seal holds" if self.sealed else "it has no seal, and its metadata were read through"
        first = f"{self.values} values in {self.chunks} chunks, digest {self.digest}, are as they were written"
        again = "" if self.recomputed is None else f"; {_told(self.recomputed)}"
        return f"{first} (schema {self.schema}; {seal}){again}"


def _told(again: Recomputed) -> str:
    if not again.rows:
        return "no row was computed again: no point of this file says its parameters and equations"
    said = [f"{again.equal} equal"] if again.equal else []
    said += [f"{again.within} within the bounds of error"] if again.within else []
    engine = "" if again.engine == ENGINE else f", with engine {ENGINE} where the file has {again.engine}"
    return f"{again.rows} rows computed again{engine}: {' and '.join(said)}"


def check(path: str | Path, *, sample: int = SAMPLE, seed: int = 0, patience: float | None = None) -> Checked:
    """Everything in a database against its digests, ranges and flags, and ``sample`` random rows computed again.

    Raises
    ------
    DamageError
        Something is not as it was written, or the child process that looked died or hung.
    DatabaseError
        The file is missing, foreign, or of a newer schema.
    """
    if isinstance(sample, bool) or not isinstance(sample, int) or sample < 0:
        raise InputError(f"sample = {sample!r} is no number of rows: give 0 or more")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise InputError(f"seed = {seed!r} is no number that rows are chosen by: give 0 or more")
    found = ask("floquet.checking", path, str(sample), str(seed), patience=patience)
    again = found.pop("recomputed")
    return Checked(recomputed=again and Recomputed(**{**again, "others": tuple(again["others"])}), **found)


# ---------------------------------------------------------------------- in the child
def _look(path: str, sample: int, seed: int, beat: Beat) -> dict[str, Any]:
    """What a :class:`Checked` says, as a dict."""
    with store.File(path, examined=True) as file:
        if not file.tables:
            raise DatabaseError(path, store.NO_TABLES)
        file.examine(beat)
        if places := tuple(file.damaged(beat)):
            raise DamageError(path, places)
        found: dict[str, Any] = {"values": file.values(), "chunks": file.count(), "sealed": file.sealed}
        found["digest"] = file.data_digest()
        found["schema"] = str(file.attributes["schema_version"])
        unlimited_memory()
        with _getting_on(beat):  # where nothing is compiled yet, the first row may take a minute
            again = recompute(file, sample, seed) if sample else None
    if again and again.others:
        raise DamageError(path, [f"points row {row}, computed again" for row in again.others])
    return {**found, "recomputed": asdict(again) if again else None}


@contextlib.contextmanager
def _getting_on(beat: Beat) -> Iterator[None]:
    """Signs of life from another thread, for :data:`MOST_SECONDS` at most."""
    done = threading.Event()

    def signs() -> None:
        end = time.monotonic() + MOST_SECONDS
        while not done.wait(1.0) and time.monotonic() < end:
            beat()

    thread = threading.Thread(target=signs, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def recompute(file: store.File, sample: int, seed: int = 0) -> Recomputed:
    """Compute random rows of the points again and compare them."""
    engine = int(file.attributes.get("engine_version", 0))
    rows = file.rows("points") if "points" in file.tables else 0
    if not rows or "options" not in file.attributes:
        return Recomputed(rows=0, equal=0, within=0, others=(), engine=engine)
    chosen = np.sort(np.random.default_rng(seed).choice(rows, min(sample, rows), replace=False))
    options = json.loads(file.attributes["options"])
    model = options.pop("model")
    columns, results = list(file.columns("points")), []
    for row in chosen.tolist():
        [(_, stored)] = file.chunks("points", columns, row, row + 1)
        results.append(_compared(stored, None if model == "by hub" else model, options, engine))
    return Recomputed(
        rows=len(chosen),
        equal=results.count(True),
        within=results.count(False),
        others=tuple(row for row, result in zip(chosen.tolist(), results, strict=True) if result is None),
        engine=engine,
    )


def _compared(stored: Rows, model: Any, options: Mapping[str, Any], engine: int) -> bool | None:
    """Whether a row is equal to the bit (True), within its bounds (False), or neither (None)."""
    values: dict[str, Any] = {p.name: float(stored[p.name][0]) for p in PARAMETERS}
    try:
        rotor = Rotor(hub=Hub(int(stored["hub"][0])), blades=int(stored["blades"][0]), **values)
        plan = Plan(rotors=(rotor,), advance_ratio=stored["advance_ratio"], model=model, physics=Physics(**options))
    except (FloquetError, TypeError):
        return None
    mapped = "method" in stored and int(stored["method"][0]) == Method.MAP
    for many in (POINTS, 1):  # the last digits are those of a large study or of a small one
        with part_of(many):
            again = point_rows(plan, 0, 1)
        if all(again[name].tobytes() == value.tobytes() for name, value in stored.items() if name != "rotor"):
            return True
    return False if (mapped or engine != ENGINE) and _within(stored, again) else None


def _within(stored: Rows, again: Rows) -> bool:
    """Whether exponents are as close as both bounds allow; True where none are stored."""
    names = [name for name in ("exponent_1", "exponent_2") if name in stored]
    if not names:
        return True
    bound = again["exponent_error"] + stored.get("exponent_error", again["exponent_error"])
    return bool(all(np.all(np.abs(stored[name] - again[name]) <= bound) for name in names))


if __name__ == "__main__":
    file, count, start = sys.argv[1:]
    answer(lambda beat: _look(file, int(count), int(start), beat), file)
