"""Whether a database is what it says: digests, ranges, and some rows computed again.

:func:`check` has a child process look at the file, with limits on its time and memory, so that no file, whoever made
it, can crash, hang or fill the process that asks.
"""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from . import store
from .errors import DamageError, DatabaseError, InputError
from .recomputing import Recomputed, misplaced, recompute
from .store.guard import Beat, answer, ask, unlimited_memory

__all__ = ["SAMPLE", "Checked", "check"]

SAMPLE = 20  # rows of a table that are computed again unless told otherwise
MOST_SECONDS = 600.0  # that computing them may take


@dataclass(frozen=True, kw_only=True)
class Checked:
    """What was looked at in a database, and was found sound, by table where rows were computed again.

    Equal data have equal digests.
    """

    values: int
    chunks: int
    schema: str
    sealed: bool
    digest: str
    recomputed: tuple[Recomputed, ...]

    def __str__(self) -> str:
        seal = "its seal holds" if self.sealed else "it has no seal, and its metadata were read through"
        first = f"{self.values} values in {self.chunks} chunks, digest {self.digest}, are as they were written"
        return "; ".join([f"{first} (schema {self.schema}; {seal})", *map(str, self.recomputed)])


def check(path: str | Path, *, sample: int = SAMPLE, seed: int = 0, patience: float | None = None) -> Checked:
    """Everything in a database against its digests, ranges and flags; ``sample`` rows of each table computed again.

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
    again = tuple(Recomputed(**{**one, "others": tuple(one["others"])}) for one in found.pop("recomputed"))
    return Checked(recomputed=again, **found)


# ---------------------------------------------------------------------- in the child
def _look(path: str, sample: int, seed: int, beat: Beat) -> dict[str, Any]:
    """What a :class:`Checked` says, as a dict."""
    with store.File(path, examined=True) as file:
        if not file.tables:
            raise DatabaseError(path, store.NO_TABLES)
        file.examine(beat)
        if places := (*file.damaged(beat), *misplaced(file, beat)):
            raise DamageError(path, places)
        found: dict[str, Any] = {"values": file.values(), "chunks": file.count(), "sealed": file.sealed}
        found["digest"] = file.data_digest()
        found["schema"] = str(file.attributes["schema_version"])
        unlimited_memory()
        with _getting_on(beat):  # where nothing is compiled yet, the first row may take a minute
            again = [recompute(file, table, sample, seed) for table in file.tables] if sample else []
    if places := tuple(f"{one.table} row {row}, computed again" for one in again for row in one.others):
        sentence = f"{len(places)} of the rows that were computed again are others than are stored"
        raise DamageError(path, places, f"{sentence} ({places[0].partition(',')[0]})")
    return {**found, "recomputed": [asdict(one) for one in again]}


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


if __name__ == "__main__":
    file, count, start = sys.argv[1:]
    answer(lambda beat: _look(file, int(count), int(start), beat), file)
