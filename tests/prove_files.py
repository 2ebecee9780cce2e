"""No damaged file gives a wrong number, hangs or crashes: ``make prove-files``.

A database, a shard, a file without a seal and one of schema 1.0 are damaged 25 000 times: bits flipped, bytes
overwritten, ranges zeroed, copied and exchanged, files cut, grown, and with bytes put in or taken out, in chunks, in
metadata, in the integrity tables and in the seal.  Each goes through ``verify`` and a query of everything.  A query
that answers must give the bits of the intact file, and so must one of a file that ``verify`` passes.

The files go through one process, as they would through the one that asks.  What a child does for files without a seal
is done there too, under ``examine``: a death or a hang in it is what the child is for, and is counted apart; one in any
other phase is a failure.  Some files go through the whole commands.  Exit status 1 if anything fails.
"""

from __future__ import annotations

import contextlib
import hashlib
import lzma
import multiprocessing
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

import h5py

from floquet import query, store, study
from floquet.errors import DatabaseError
from floquet.store import guard, reading, seal
from floquet.study import shards

COUNT, COMMANDS, SEED, PATIENCE = 25_000, 60, 1431, 10.0
SHARES = (
    20,
    10,
    10,
    1,
)  # of the four files; the example of schema 1.0 has all columns and both tables, and takes longest
EXAMPLE = Path(__file__).parent.parent / "data/reference/schema-1.0.h5.xz"
STUDY = """
[study]
name = "proof"
schema = 1
[rotors]
list = [
    { name = "Bo 105", lock_number = 5.087, hinge_stiffness = 0.248 },
    { name = "two blades", lock_number = 6.0, hub = "teetering", blades = 2 },
]
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 30 }
[compare]
tolerances = []
[output]
columns = ["exponent_1", "verdict"]
"""


# ---------------------------------------------------------------------- files
def originals(folder: Path) -> dict[str, bytes]:
    """Sound files by what they are."""
    toml, out, shard = folder / "s.toml", folder / "s.h5", folder / "shard.h5"
    toml.write_text(STUDY, encoding="utf-8")
    one = study.load_study(toml)
    study.run(one, out)
    parts = shards.Parts(folder, one.id, one.columns)
    made = shards.make(one.plan, shards.Shard("points", 0, one.plan.points), parts)
    shutil.move(folder / made, shard)
    bare = folder / "bare.h5"
    shutil.copy(out, bare)
    with h5py.File(bare, "r+"):
        pass  # HDF5 cuts off what is behind its end
    named = {"database": out, "shard": shard, "without a seal": bare}
    found = {name: path.read_bytes() for name, path in named.items()}
    return found | {"schema 1.0": lzma.decompress(EXAMPLE.read_bytes())}


def places(image: bytes, path: Path) -> dict[str, list[tuple[int, int]]]:
    """Ranges of bytes: chunks, integrity tables, everything else, and the end."""
    path.write_bytes(image)
    with h5py.File(path, "r") as file:
        tables = [file[t] for t in store.TABLES if t in file]
        chunks = seal.chunk_extents([d for table in tables for d in table.values()])
        integrity = seal.chunk_extents([d for table in file["integrity"].values() for d in table.values()])
    taken, at, rest = sorted(chunks + integrity), 0, []
    for first, length in taken:
        rest += [(at, first - at)] if first > at else []
        at = first + length
    rest += [(at, len(image) - at)] if at < len(image) else []
    return {"chunks": chunks, "integrity": integrity, "metadata": rest, "end": [(len(image) - 200, 200)]}


def damaged(image: bytes, where: list[tuple[int, int]], luck: random.Random) -> tuple[str, bytes]:
    """One damage, and what it is."""
    out = bytearray(image)
    first, length = luck.choices(where, [length for _, length in where])[0]
    at, size = first + luck.randrange(length), luck.choice([1, 2, 4, 8, 64, 512, 4096])
    other = luck.randrange(len(image))
    kind = luck.choice(
        ["bit", "bytes", "extreme", "zeros", "copied", "exchanged", "cut", "grown", "put in", "taken out"]
    )
    if kind == "bit":
        out[at] ^= 1 << luck.randrange(8)
    elif kind == "bytes":
        out[at : at + size] = luck.randbytes(min(size, len(out) - at))
    elif kind == "extreme":
        size = min(size, 8, len(out) - at)
        out[at : at + size] = luck.choice([b"\xff", b"\x7f", b"\x80", b"\1"]) * size
    elif kind == "zeros":
        out[at : at + size] = bytes(min(size, len(out) - at))
    elif kind == "copied":
        size = min(size, len(out) - max(at, other))
        out[at : at + size] = image[other : other + size]
    elif kind == "exchanged":
        size = min(size, len(out) - max(at, other), abs(at - other))
        out[at : at + size], out[other : other + size] = image[other : other + size], image[at : at + size]
    elif kind == "cut":
        del out[at:]
    elif kind == "grown":
        out += luck.choice([bytes(size), luck.randbytes(size), image[-size:]])
    elif kind == "put in":
        out[at:at] = luck.randbytes(size)
    else:
        del out[at : at + size]
    return kind, bytes(out)


# ---------------------------------------------------------------------- what is asked of them
def answers(path: Path) -> str:
    """A digest of everything that queries say of a file: values, names, words, units."""
    total = hashlib.blake2b(digest_size=16)
    with query.open_database(path) as database:
        for table in database.tables:
            found = database.query("rotor >= 0", table=table, columns="*")
            for name, values in found.items():
                total.update(name.encode())
                total.update(values.tobytes() if values.dtype.kind in "fciu" else repr(values.tolist()).encode())
            total.update(repr(database.describe(table)).encode())
            total.update(str(len(database.query("advance_ratio > 0.5" if table == "points" else "limit < 1"
                                                , table=table)["rotor"])).encode())  # fmt: skip
    return total.hexdigest()


def worker(link: Connection) -> None:
    """Examine, verify and query the files that come, telling each step before it is taken."""

    def here(_: str, path: Path, *__: str, **___: float) -> None:
        link.send("examine")
        with reading.File(path, examined=True) as file:
            file.examine(lambda: None)
        link.send("open")

    reading.ask = here  # type: ignore[assignment]
    guard.limit_memory()
    while (path := link.recv()) is not None:
        link.send("verify")
        try:
            sound = not store.verify(path)
        except DatabaseError:
            sound = False
        link.send("query")
        try:
            answer = answers(path)
        except DatabaseError:
            answer = ""
        link.send((sound, answer))


class Asked:
    """A worker that is started anew when it has died or hung."""

    def __init__(self) -> None:
        self.context = multiprocessing.get_context("spawn")
        self.start()

    def start(self) -> None:
        """A new process."""
        self.link, theirs = self.context.Pipe()
        self.process = self.context.Process(target=worker, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()

    def ask(self, path: Path) -> tuple[str, bool, str]:
        """(how it ended, whether verify found it sound, the digest of the answers)."""
        self.link.send(path)
        phase = "start"
        try:
            while True:
                if not self.link.poll(PATIENCE if phase != "start" else 60.0):
                    return self.again(f"hung in {phase}"), False, ""
                said = self.link.recv()
                if isinstance(said, tuple):
                    return "answered" if said[1] else "refused", *said
                phase = said
        except (EOFError, ConnectionError):
            return self.again(f"died in {phase}"), False, ""

    def again(self, how: str) -> str:
        """End what is left of the process, and start another."""
        self.process.kill()
        self.process.join()
        self.start()
        return how


def commands(path: Path) -> tuple[int, int]:
    """Exit status of the whole commands; -1000 for a hang."""

    def status(*words: str) -> int:
        with contextlib.suppress(subprocess.TimeoutExpired):
            done = subprocess.run(
                [sys.executable, "-m", "floquet", *words], capture_output=True, text=True, timeout=120
            )
            return done.returncode if "Traceback" not in done.stderr else -2000
        return -1000

    return status("verify", str(path), "--sample", "0"), status("query", str(path), "rotor >= 0", "--csv")


def prove(count: int, through_commands: int) -> bool:
    """Damage files so many times and count what comes of it."""
    luck, ends, kinds, wrong, began = random.Random(SEED), Counter[str](), Counter[str](), 0, time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        path, asked = Path(folder) / "damaged.h5", Asked()
        files = originals(Path(folder))
        where = {name: places(image, path) for name, image in files.items()}
        truth: dict[str, str] = {}
        for name, image in files.items():
            path.write_bytes(image)
            end, sound, truth[name] = asked.ask(path)
            assert end == "answered" and sound, (name, end)
        for i in range(count):
            [name] = luck.choices(list(files), SHARES)
            place = luck.choice(list(where[name]))
            kind, image = damaged(files[name], where[name][place], luck)
            path.write_bytes(image)
            end, sound, answer = asked.ask(path)
            ends[end] += 1
            kinds[f"{place} of {name}"] += 1
            if (answer and answer != truth[name]) or (sound and answer != truth[name]):
                wrong += 1
                print(f"WRONG: file {i}, {kind} in {place} of {name}: verify {sound}", flush=True)
            if end.startswith(("hung", "died")) and not end.endswith("examine"):
                print(f"FAILED: file {i}, {kind} in {place} of {name}: {end}", flush=True)
            if (i + 1) % 5000 == 0:
                line = ", ".join(f"{n} {e}" for e, n in sorted(ends.items()))
                print(
                    f"{i + 1} files: {line}; {wrong} wrong; {(i + 1) / (time.monotonic() - began):.0f} a second",
                    flush=True,
                )
        asked.link.send(None)
        bad, statuses = 0, Counter[tuple[int, int]]()
        for _ in range(through_commands):
            name = luck.choice(list(files))
            _, image = damaged(files[name], where[name][luck.choice(list(where[name]))], luck)
            path.write_bytes(image)
            status = commands(path)
            statuses[status] += 1
            bad += not (set(status) <= {0, 1, 2})
    print(*(f"{n} in {k}" for k, n in sorted(kinds.items())), sep=", ")
    print(f"{through_commands} through the commands verify and query: exit statuses {dict(statuses)}; {bad} bad")
    unexpected = sum(n for e, n in ends.items() if e.startswith(("hung", "died")) and not e.endswith("examine"))
    print(f"{count} damaged files: {wrong} wrong values, {unexpected} crashes or hangs of the process that asks, "
          f"{sum(n for e, n in ends.items() if e.endswith('examine'))} of a child that examines")  # fmt: skip
    return not (wrong or bad or unexpected)


if __name__ == "__main__":
    sys.exit(not prove(*([int(word) for word in sys.argv[1:]] or (COUNT, COMMANDS))))
