"""A child process that looks at a file in place of this one: its death, its hanging, its hunger are sentences here.

The child is ``python -m MODULE FILE …``, so that it starts alike on every system and needs nothing of the program that
asks.  It prints lines of JSON: ``null`` while it gets on, and at last an object with ``answer``, or with ``damage``
(places) or ``refused`` (a sentence), which are raised here.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import DamageError, DatabaseError, FailedError

__all__ = ["Beat", "answer", "ask", "limit_memory", "unlimited_memory"]

Beat = Callable[[], None]

PATIENCE = 60.0  # s without a line: a chunk takes milliseconds, Python's start a second or, on slow disks, ten
MEMORY = 2 << 30  # bytes that a child may take beyond what it has when it begins
EVERY = 0.5  # s between two signs of life


def ask(module: str, path: str | Path, *arguments: str, patience: float | None = None) -> Any:
    """What a module's child process finds in a file.

    Raises
    ------
    DamageError
        The child found damage, died, or said nothing for ``patience`` seconds.
    DatabaseError
        The child refused the file.
    """
    folder = str(Path(__file__).resolve().parents[2])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))}
    command = [sys.executable, "-P", "-m", module, str(path), *arguments]
    try:
        child = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
    except OSError as error:
        raise FailedError(f"{path}: no process could be started to examine it ({error.strerror or error})") from error
    with child:
        try:
            found = _last(child, PATIENCE if patience is None else patience)
        except TimeoutError:
            raise DamageError(path, ["metadata, over which the process that examined it hung"]) from None
        finally:
            child.kill()
    if found is None:
        raise DamageError(path, [f"metadata, over which the process that examined it {_end(child.returncode)}"])
    if "damage" in found:
        raise DamageError(path, found["damage"], found.get("sentence", ""))
    if "refused" in found:
        raise DatabaseError(path, found["refused"])
    return found["answer"]


def _last(child: subprocess.Popen[bytes], patience: float) -> dict[str, Any] | None:
    """The object that a child prints; None if it ends without."""
    lines: queue.Queue[bytes | None] = queue.Queue()

    def read() -> None:
        assert child.stdout is not None
        for line in child.stdout:
            lines.put(line)
        lines.put(None)

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            line = lines.get(timeout=patience)
        except queue.Empty:
            raise TimeoutError from None
        if line is None:
            child.wait()
            return None
        with contextlib.suppress(ValueError):
            if isinstance(found := json.loads(line), dict):
                return found


def _end(status: int) -> str:
    """How a process ended."""
    if status >= 0:
        return f"failed (exit status {status})"
    with contextlib.suppress(ValueError):
        return f"crashed ({signal.Signals(-status).name})"
    return f"crashed (signal {-status})"


# ---------------------------------------------------------------------- in the child
def answer(work: Callable[[Beat], Any], path: str) -> None:
    """Print what ``work`` returns or raises; it calls its argument whenever it got on."""
    last = 0.0

    def beat() -> None:
        nonlocal last
        if time.monotonic() - last > EVERY:
            last = time.monotonic()
            print("null", flush=True)

    limit_memory()
    try:
        found: dict[str, Any] = {"answer": work(beat)}
    except DamageError as error:
        found = {"damage": error.places, "sentence": error.sentence}
    except DatabaseError as error:
        found = {"refused": str(error).removeprefix(f"{path}: ")}
    except (MemoryError, RecursionError):
        found = {"damage": ["metadata, over which the process that examined it ran out of memory"]}
    print(json.dumps(found), flush=True)


def limit_memory() -> None:
    """Let this process take so much more memory, where the system can limit it."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        _set_limit(taken + MEMORY)


def unlimited_memory() -> None:
    """Lift the limit."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        _set_limit(resource.getrlimit(resource.RLIMIT_AS)[1])


def _set_limit(limit: int) -> None:
    import resource

    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (limit if hard < 0 else min(limit, hard), hard))
