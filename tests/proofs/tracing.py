"""A child under strace: which system calls it makes, and what becomes of it when one of them kills it or fails.

strace counts the calls of each name by themselves, so a point of a program is a name and a number.  A kill takes effect
at the entry of the call, which is not made: the point before a call is that after the call before it, and all states
that a file can be left in are tried, but for a write that is torn within.  Children are forked from a warm process,
and wait until strace has them: a point costs what the work costs.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["CHANGES", "OPENS", "Call", "calls", "untraceable", "traced"]

#: Calls that change files or make changes last; those that a processor does not have are left out.
CHANGES = (
    "write", "pwrite64", "writev", "pwritev", "pwritev2", "rename", "renameat", "renameat2", "fsync", "fdatasync",
    "truncate", "ftruncate", "fallocate", "unlink", "unlinkat", "rmdir", "mkdir", "mkdirat", "link", "linkat",
)  # fmt: skip
OPENS = ("open", "openat", "creat")
LINE = re.compile(r"(?P<name>[a-z0-9_]+)\((?P<rest>.*)$")
WRITING = re.compile(r"O_WRONLY|O_RDWR|O_CREAT")


@dataclass(frozen=True)
class Call:
    """The n-th call of a name, as strace shows it."""

    name: str
    number: int
    line: str

    @property
    def done(self) -> bool:
        """Whether the call was made and did not fail."""
        return re.search(r" = \d+", self.line) is not None

    @property
    def writes(self) -> bool:
        """Of a call that opens: whether it opens for writing."""
        return WRITING.search(self.line) is not None


def untraceable() -> str:
    """Why strace can inject nothing here; empty if it can."""
    if sys.platform != "linux" or shutil.which("strace") is None:
        return "there is no strace here"
    try:
        status = traced(lambda: os.write(-1, b"") and 0, os.devnull, ["-e", "inject=write:retval=0:when=1"])
    except OSError as error:
        return str(error)
    return "" if status == 0 else "strace cannot inject here"


def traced(work: Callable[[], int], log: str | Path, options: Sequence[str] = ()) -> int:
    """The wait status of a child that does ``work`` under strace, whose log is written; OSError without permission."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        status = 70
        try:
            os.close(writer)
            if os.read(reader, 1):  # nothing comes where strace could not attach
                status = work()
        finally:
            os._exit(status)
    os.close(reader)
    names = ",".join(f"?{name}" for name in (*CHANGES, *OPENS))
    command = ["strace", "-y", "-s", "0", "-o", str(log), "-e", f"trace={names}", *options, "-p", str(child)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as strace:
        assert strace.stderr is not None
        said = strace.stderr.readline()
        try:
            if "attached" not in said:
                raise OSError(f"strace cannot trace here ({said.strip()})")
            os.write(writer, b"\n")
        finally:
            os.close(writer)
            _, status = os.waitpid(child, 0)
            strace.stderr.read()
    return status


def calls(log: Path, folder: Path) -> list[Call]:
    """The calls of a log that concern a folder, numbered by name among all."""
    count: Counter[str] = Counter()
    found = []
    for line in log.read_text(encoding="utf-8", errors="replace").splitlines():
        if match := LINE.match(line):
            count[match["name"]] += 1
            if str(folder) in match["rest"]:
                found.append(Call(match["name"], count[match["name"]], line))
    return found
