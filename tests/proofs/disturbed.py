"""Every system call of every operation that changes files, killed at and failing.

Killed at: what was saved is there and whole, nothing is half, and the command taken up again ends with the data of a
run in one go, nothing left behind.  Failing, for want of room or because of the disk: the same, and the command ends
with exit status 1 and one sentence.  Without room no later call of that name succeeds either, as on a full disk.
"""

from __future__ import annotations

import gc
import mmap
import multiprocessing
import os
import re
import signal
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .operations import LEFT, OPERATIONS, Place, command
from .tracing import CHANGES, OPENS, Call, calls, traced

__all__ = ["Disturbance", "Outcome", "KILL", "FAILURES", "disturb"]

FAILING = ("write", "pwrite64", "writev", "rename", "renameat", "renameat2", "fsync", "fdatasync", "truncate",
           "ftruncate", "mkdir", "mkdirat", *OPENS)  # fmt: skip
TRIALS = re.compile(rf"O_TMPFILE|{LEFT}")
"""Opens that need not succeed: of a file without a name, by which filelock sees whether there are locks, and of what a
killed writer has left, which stays where it cannot be opened."""
LASTING = ("write", "pwrite64", "writev", "ftruncate")  # what fails on and on while a disk is full
MEMORY = "/dev/shm"  # where there is one: the calls are the same, and syncing takes no time
ROOM = 2**16  # bytes for what a child says


@dataclass(frozen=True)
class Disturbance:
    """What strace does to a call, and the words that the sentence must then have."""

    name: str
    inject: str
    sentence: str = ""

    def hits(self, call: Call) -> bool:
        """Whether the call is one to disturb; what fails by itself, as where a folder is there already, need not."""
        if not self.sentence:
            return call.name in CHANGES
        if call.name in OPENS and (not call.writes or TRIALS.search(call.line)):
            return False
        return call.done and call.name in FAILING

    def options(self, call: Call) -> list[str]:
        """Of strace."""
        lasting = "+" if self.name == "ENOSPC" and call.name in LASTING else ""
        return ["-e", f"inject={call.name}:{self.inject}:when={call.number}{lasting}"]


KILL = Disturbance("kill", "signal=SIGKILL")
FAILURES = (
    Disturbance("ENOSPC", "error=ENOSPC", "the disk is full"),
    Disturbance("EIO", "error=EIO", "the disk failed"),
)


@dataclass(frozen=True)
class Outcome:
    """Of one disturbance: the point, and what was wrong, each empty if nothing was."""

    point: str
    lost: str
    different: str
    unclear: str = ""


def disturb(operation: str, disturbance: Disturbance, jobs: int = 2, at_most: int = 0) -> list[Outcome]:
    """Every point of an operation (or so many, evenly) in so many processes."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        parts = [pool.submit(_share, operation, disturbance, i, jobs, at_most) for i in range(jobs)]
        return [outcome for part in parts for outcome in part.result()]


def _share(operation: str, disturbance: Disturbance, first: int, jobs: int, at_most: int) -> list[Outcome]:
    """The outcomes of every jobs-th point."""
    os.environ["FLOQUET_THREADS"] = "1"  # all calls are the first thread's, so that they have numbers
    with tempfile.TemporaryDirectory(prefix="proof-", dir=MEMORY if os.access(MEMORY, os.W_OK) else None) as name:
        place, log = Place(Path(name) / "place", OPERATIONS[operation]), Path(name) / "log"
        points = list(_points(place, log, disturbance))
        gc.freeze()  # children then copy less
        step = max(1.0, len(points) / at_most) if at_most else 1.0
        chosen = [points[int(i * step)] for i in range(int(len(points) / step))]
        return [_outcome(place, log, disturbance, call) for call in chosen[first::jobs]]


def _points(place: Place, log: Path, disturbance: Disturbance) -> Iterator[Call]:
    """The calls of the command, undisturbed."""
    status, said = _command(place, log, [])
    if status:
        raise RuntimeError(f"{place.operation.name} under strace alone ends with {status}: {said}")
    return filter(disturbance.hits, calls(log, place.work))


def _command(place: Place, log: Path, options: Sequence[str]) -> tuple[int, str]:
    """The wait status of the command under strace, and all it says on stderr; sentences come by memory, uninjected."""
    place.restore()
    with mmap.mmap(-1, ROOM) as shared, tempfile.TemporaryFile() as noise:

        def work() -> int:
            os.dup2(noise.fileno(), 2)  # for libraries that write without Python
            status, said, _ = command(place.filled(place.operation.command))
            shared.write(said.encode()[:ROOM])
            return status

        status = traced(work, log, options)
        noise.seek(0)
        return status, (shared[:].rstrip(b"\0") + noise.read()).decode(errors="replace")


def _outcome(place: Place, log: Path, disturbance: Disturbance, call: Call) -> Outcome:
    status, said = _command(place, log, disturbance.options(call))
    lost = place.lost(made for made in calls(log, place.work) if made.done)
    unclear = ""
    if disturbance.sentence:
        said = "".join(line for line in said.splitlines(True) if not line.startswith("floquet: warning: "))
        clear = said.startswith("floquet: ") and said.count("\n") == 1 and disturbance.sentence in said
        ended = os.waitstatus_to_exitcode(status)
        unclear = "" if ended == 1 and clear else f"status {ended}: {said.strip() or 'not a word'}"
    elif not (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL):
        unclear = f"not killed: {status}"
    return Outcome(f"{call.name} {call.number}: {call.line[:160]}", lost, place.different(), unclear)
