"""What is disturbed: commands of a small study, each from the same folder again and again, and what must hold after.

Before the command the folder holds what its operation needs::

    run      nothing
    resume   its two shards, of which one was cut short, and what killed writers leave behind
    pack     all shards
    merge    two databases
    extend   the database of a smaller study
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import shutil
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from floquet import cli, store, study
from floquet.study import running

from .tracing import Call

__all__ = ["LEFT", "OPERATIONS", "Operation", "Place", "command"]

STUDY = """
[study]
name = "proof"
schema = 1
[rotors]
list = [{{ lock_number = {lock_number} }}]
[axes]
advance_ratio = {{ start = 0.0, stop = 1.0, count = {count} }}
[compare]
tolerances = [0.05]
[output]
columns = ["verdict"]
"""
OUT, PARTS = "out.h5", "out.h5.parts"
LEFT = "0123456789abcdef"  # where a temporary file has its random digits
LEFTOVERS = (f".out.h5.{LEFT}.tmp", f"{PARTS}/.limits-000000000000-000000000001.h5.{LEFT}.tmp")


@dataclass(frozen=True)
class Operation:
    """A command on a folder (``{}``), the command that takes it up again, and what is there at the end.

    ``prepare(folder)`` makes what is there before, and names the files that are damaged, or old, on purpose.
    """

    name: str
    command: tuple[str, ...]
    again: tuple[str, ...]
    end: frozenset[str]
    prepare: Callable[[Path], Sequence[str]]


def _nothing(folder: Path) -> Sequence[str]:
    return ()


def _all_shards(folder: Path) -> Sequence[str]:
    """The folder of a run that was stopped when it was about to pack."""
    packing, running.packed = running.packed, _stopped
    try:
        with contextlib.suppress(KeyboardInterrupt):
            study.run(study.load_study(_study(folder.parent / "study.toml")), folder / OUT)
    finally:
        running.packed = packing
    return ()


def _stopped(*_: object, **__: object) -> dict[str, int]:
    raise KeyboardInterrupt


def _some_shards(folder: Path) -> Sequence[str]:
    _all_shards(folder)
    _, cut = sorted(path.name for path in (folder / PARTS).glob("*-*.h5"))
    os.truncate(folder / PARTS / cut, 3000)
    for name in LEFTOVERS:
        (folder / name).write_bytes(b"half")
    return (f"{PARTS}/{cut}",)


def _databases(folder: Path) -> Sequence[str]:
    for name, lock_number in (("a", 4.0), ("b", 5.0)):
        file = _study(folder.parent / f"{name}.toml", lock_number)
        study.run(study.load_study(file), folder / f"{name}.h5")
    return ()


def _smaller(folder: Path) -> Sequence[str]:
    study.run(study.load_study(_study(folder.parent / "smaller.toml", count=5)), folder / OUT)
    return (OUT,)


def _study(file: Path, lock_number: float = 4.0, count: int = 9) -> Path:
    file.write_text(STUDY.format(lock_number=lock_number, count=count), encoding="utf-8")
    return file


RUN = ("run", "{}/../study.toml", "-o", f"{{}}/{OUT}", "--workers", "1")
PACK, MERGE = ("pack", f"{{}}/{PARTS}"), ("merge", "{}/a.h5", "{}/b.h5", "-o", f"{{}}/{OUT}")
EXTEND = (*RUN, "--extend")
OPERATIONS = {
    operation.name: operation
    for operation in (
        Operation("run", RUN, (*RUN, "--resume"), frozenset({OUT}), _nothing),
        Operation("resume", (*RUN, "--resume"), (*RUN, "--resume"), frozenset({OUT}), _some_shards),
        Operation("pack", PACK, PACK, frozenset({OUT, PARTS}), _all_shards),
        Operation("merge", MERGE, MERGE, frozenset({OUT, "a.h5", "b.h5"}), _databases),
        Operation("extend", EXTEND, (*EXTEND, "--resume"), frozenset({OUT}), _smaller),
    )
}


def command(arguments: Sequence[str]) -> tuple[int, str, str]:
    """The exit status of ``floquet`` in this process, and what it says on stderr and on stdout."""
    said, answered, status = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(answered):
        try:
            cli.main(arguments)
        except SystemExit as end:
            status = int(end.code or 0)
    return status, said.getvalue(), answered.getvalue()


class Place:
    """A folder in which an operation is done again and again: in ``work``, which is restored from ``before``."""

    def __init__(self, folder: Path, operation: Operation) -> None:
        self.operation, self.before, self.work = operation, folder / "before", folder / "work"
        self.before.mkdir(parents=True)
        self.study = _study(folder / "study.toml")
        self.spoilt = {name: (self.before / name).read_bytes() for name in operation.prepare(self.before)}
        self.restore()
        status, said, _ = command(self.filled(operation.command))  # all that are forked find it warm
        assert status == 0, said
        self.expected = store.data_digest(self.work / OUT)

    def restore(self) -> None:
        """The folder as it was before."""
        shutil.rmtree(self.work, ignore_errors=True)
        shutil.copytree(self.before, self.work)

    def filled(self, arguments: Sequence[str]) -> list[str]:
        """Arguments of this place."""
        return [argument.format(self.work) for argument in arguments]

    # ------------------------------------------------------------------ what must hold after a kill or a failure
    def lost(self, made: Iterable[Call]) -> str:
        """What is not whole of the files that were there, or have taken their place by the calls made; or empty."""
        renamed = (re.findall(r'"([^"]*)"', call.line)[-1] for call in made if call.name.startswith("rename"))
        saved = {*_files(self.before), *(os.path.relpath(path, self.work) for path in renamed)}
        there = _files(self.work)
        for name in sorted(n for n in there if not n.endswith((".tmp", ".lock"))):
            if not self._whole(name):
                return f"{name} is half a file"
        packed = self._finished() and PARTS not in self.operation.end  # then its shards go
        gone = {n for n in saved - there if not n.endswith((".tmp", ".lock")) and not (packed and n.startswith(PARTS))}
        return f"{min(gone)} is gone" if gone else ""

    def _finished(self) -> bool:
        out = self.work / OUT
        return out.exists() and out.read_bytes() != self.spoilt.get(OUT)

    def _whole(self, name: str) -> bool:
        file = self.work / name
        if file.suffix == ".toml":
            return file.read_bytes() == self.study.read_bytes()
        with contextlib.suppress(ValueError):  # a DatabaseError is one, and so is what is no JSON
            if file.suffix == ".json":
                return "study_id" in json.loads(file.read_bytes())
            if file.read_bytes() == self.spoilt.get(name):
                return True
            return store.verify(file) == () and (name != OUT or store.data_digest(file) == self.expected)
        return False

    def different(self) -> str:
        """Take the command up again: what is not as in a run in one go; or empty."""
        finished = self._finished()
        names = [n for n in _files(self.work) if "-" in n and n.endswith(".h5")]
        kept = sum(self._whole(name) and (self.work / name).read_bytes() != self.spoilt.get(name) for name in names)
        status, said, answered = command(self.filled(self.operation.again))
        refused = finished and "is there already" in said and "--resume" not in self.operation.again
        if status and not refused:
            return f"status {status} when taken up: {said.strip()}"
        if not (self._finished() and self._whole(OUT)):
            return "other data"
        reused = re.search(r"(\d+) kept", answered)
        if reused and not finished and int(reused[1]) != kept:
            return f"{reused[1]} shards kept of {kept}"
        top, left = {path.name for path in self.work.iterdir()}, {n for n in _files(self.work) if n.endswith(".tmp")}
        return "" if top == self.operation.end and not left else f"left behind: {', '.join(sorted(top | left))}"


def _files(folder: Path) -> set[str]:
    """Of a folder and those in it, by their paths in it."""
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
