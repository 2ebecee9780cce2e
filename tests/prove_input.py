"""No text gives anything but a right answer or our own sentence: ``make prove-input``.

100 000 query strings (grown from the grammar and asked in Python row by row as well; the same with damage; garbage,
Unicode, deep nesting, great length; foreign columns, sorts and limits) and 20 000 damaged or bold study and rotor files
are tried in one process with limits on the time of each and on memory.  Exit status 1 if anything but a FloquetError or
a right answer comes out.
"""

from __future__ import annotations

import math
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from floquet import store, study
from floquet.errors import FloquetError, FloquetWarning
from floquet.query import Database
from floquet.rotor import load_rotor
from floquet.studyfile import load_study

QUERIES, FILES, SEED, SECONDS, MEMORY = 100_000, 20_000, 1431, 30, 4 << 30
NUMBERS = ("advance_ratio", "lock_number", "error_regressing", "lock", "exponent_1_re", "panels", "rotor")
Row = dict[str, np.float64]
Made = tuple[str, Callable[[Row], Any]]  # a text, and what it says of a row


class Hung(BaseException):
    """An item took too long."""


def _hang(*_: object) -> None:
    raise Hung


# ---------------------------------------------------------------------- queries
class Memory:
    """A table of points that is not in a file."""

    names = ("Bo 105", "two blades")
    attributes: dict[str, Any] = {"title": "proof"}  # noqa: RUF012
    tables = ("points",)

    def __init__(self, rows: int) -> None:
        luck = np.random.default_rng(SEED)
        self.data: dict[str, Any] = {}
        for name, c in store.POINTS.items():
            if c.flags:
                self.data[name] = luck.choice(list(c.flags), rows).astype(c.dtype)
            elif c.dtype in ("f8", "c16"):
                values = luck.choice([0.0, -0.0, 1.0, 0.5, -3.0, np.nan, np.inf, -np.inf, 1e300, 1e-300], rows)
                self.data[name] = np.where(luck.random(rows) < 0.5, luck.normal(size=rows), values).astype(c.dtype)
            else:
                self.data[name] = luck.integers(0, 2, rows).astype(c.dtype)
        for name in [n for n, c in store.POINTS.items() if c.dtype == "c16"]:
            self.data |= {f"{name}_re": self.data[name].real, f"{name}_im": self.data[name].imag}

    def columns(self, _: str) -> dict[str, store.Column]:
        """All columns."""
        return dict(store.POINTS)

    def left_out(self, _: str) -> tuple[str, ...]:
        """None is."""
        return ()

    def rows(self, _: str) -> int:
        """How many."""
        return len(self.data["rotor"])

    def spans(self, _: str, start: int = 0, stop: int | None = None, skip: Any = None) -> Iterator[tuple[int, int]]:
        """Ten rows each, with the ranges that a file would have."""
        end = self.rows("") if stop is None else stop
        for first in range(start, end, 10):
            if skip is not None:
                real = {n: v[first : first + 10] for n, v in self.data.items() if v.dtype.kind != "c"}
                with np.errstate(all="ignore"):
                    low = {name: float(np.fmin.reduce(v)) for name, v in real.items()}
                    high = {name: float(np.fmax.reduce(v)) for name, v in real.items()}
                if skip(low, high):
                    continue
            yield first, min(first + 10, end)

    def chunks(
        self, _: str, columns: Any, start: int = 0, stop: int | None = None, skip: Any = None
    ) -> Iterator[tuple[int, Any]]:
        """The rows of these spans."""
        for first, last in self.spans(_, start, stop, skip):
            yield first, {name: self.data[name][first:last] for name in columns}


def number(luck: random.Random, depth: int) -> Made:
    """An expression that is a number."""
    if depth <= 0 or luck.random() < 0.3:
        if luck.random() < 0.5:
            name = luck.choice(NUMBERS)
            return name, lambda row: row[name]
        text = luck.choice(["0", "1", "2.5", "1e-3", "1e300", "inf", "0.3", "7"])
        value = np.float64(text)
        return text, lambda _: value
    (a, left), (b, right) = number(luck, depth - 1), number(luck, depth - 1)
    match luck.randrange(7):
        case 0:
            return f"({a} + {b})", lambda row: left(row) + right(row)
        case 1:
            return f"({a} - {b})", lambda row: left(row) - right(row)
        case 2:
            return f"({a} * {b})", lambda row: left(row) * right(row)
        case 3:
            return f"({a} / {b})", lambda row: left(row) / right(row)
        case 4:
            return f"abs({a})", lambda row: abs(left(row))
        case 5:
            return f"sqrt({a})", lambda row: np.sqrt(left(row))
        case _:
            return f"(-{a})", lambda row: -left(row)


def truth(luck: random.Random, depth: int) -> Made:
    """An expression that is true or false."""
    if depth > 0 and luck.random() < 0.5:
        (a, left), (b, right) = truth(luck, depth - 1), truth(luck, depth - 1)
        match luck.randrange(3):
            case 0:
                return f"({a} and {b})", lambda row: left(row) and right(row)
            case 1:
                return f"({a} or {b})", lambda row: left(row) or right(row)
            case _:
                return f"(not {a})", lambda row: not left(row)
    (x, one), (y, two), (z, three) = (number(luck, depth - 1) for _ in range(3))
    match luck.randrange(9):
        case 0:
            return f"{x} < {y}", lambda row: one(row) < two(row)
        case 1:
            return f"{x} >= {y}", lambda row: one(row) >= two(row)
        case 2:
            return f"{x} == {y}", lambda row: one(row) == two(row)
        case 3:
            return f"{x} != {y}", lambda row: one(row) != two(row)
        case 4:
            return f"{x} < {y} <= {z}", lambda row: one(row) < two(row) <= three(row)
        case 5:
            return f"isnan({x})", lambda row: math.isnan(one(row))
        case 6:
            return f"isfinite({x})", lambda row: math.isfinite(one(row))
        case 7:
            return f"verdict == 'UNSTABLE'", lambda row: row["verdict"] == 1  # noqa: F541
        case _:
            return f"{x} in (0, 1, 0.5)", lambda row: one(row) in (0.0, 1.0, 0.5)


SCRAPS = ("(", ")", ",", "<", ">", "==", "!=", "<=", "&", "|", "not", "and", "in", "nearest(", "**", "9" * 30, 
          "1e999",
          "'", '"', "\\", "\0", "\n", "é", "μ", "\u202e", "\ud800", "𝔸", "__class__", "lambda: 0", "import os", "{}",
          "nan", "None", "[0]", ".", "..", "0x10", "1_0", "rotor_name", "lok", "5j", "-", "%",
          "//", ";", "#")  # fmt: skip


def spoiled(text: str, luck: random.Random) -> str:
    """A text with some damage."""
    for _ in range(luck.choice([1, 1, 1, 2, 5])):
        at = luck.randrange(len(text) + 1)
        to = min(len(text), at + luck.choice([0, 1, 3, 10]))
        new = luck.choice([luck.choice(SCRAPS), "", text[at:to] * luck.choice([2, 3]), chr(luck.randrange(0x110000))])
        text = text[:at] + new + text[to:]
    return text


def garbage(luck: random.Random) -> str:
    """Anything but an expression."""
    size = luck.choice([0, 1, 5, 50, 500])
    match luck.randrange(7):
        case 0:
            return "".join(chr(luck.randrange(0x110000)) for _ in range(size))
        case 1:
            return "".join(luck.choice(SCRAPS) for _ in range(size))
        case 2:
            return "(" * luck.choice([10, 63, 64, 65, 5000]) + "1 < 2" + ")" * luck.choice([10, 63, 64, 65, 5000])
        case 3:
            return luck.choice(["not ", "-", "abs(", "nearest("]) * luck.choice([3, 60, 70, 4000]) + "lock"
        case 4:
            return luck.choice([" and ", " or ", " + ", " < ", " ** ", ", "]).join(
                ["lock"] * luck.choice([2, 60, 3000])
            )
        case 5:
            return "lock in (" + ", ".join(str(luck.random()) for _ in range(luck.choice([1, 100, 3000]))) + ")"
        case _:
            return "lock > " + "9" * luck.choice([5, 300, 5000, 100_000])


def options(luck: random.Random) -> dict[str, Any]:
    """Settings of a query, some of them bold."""
    if luck.random() < 0.8:
        return {"columns": "rotor"}
    bold: list[Any] = [
        "",
        "*",
        "lock",
        "lok",
        "rotor_name",
        "\0",
        "a,b",
        3,
        -1,
        2**70,
        math.nan,
        [],
        ["lock", "lock"],
        "exponent_1",
    ]
    return {name: luck.choice(bold) for name in luck.sample(["columns", "sort", "limit", "table"], 2)}


def query(reader: Memory, luck: random.Random) -> str:
    """One question; how it ended."""
    database, kind = Database("memory", reader), luck.choice(["grown", "spoiled", "garbage"])  # type: ignore[arg-type]
    if kind == "grown":
        text, says = truth(luck, luck.randrange(5))
        with np.errstate(all="ignore"):
            rows = [{n: np.float64(reader.data[n][i]) for n in (*NUMBERS, "verdict")} for i in range(reader.rows(""))]
            expected = [i for i, row in enumerate(rows) if says(row)]
        found = database.query(text, columns=["panels", "advance_ratio", "method"])
        right = [reader.data["advance_ratio"][i] for i in expected]
        if not np.array_equal(found["advance_ratio"], np.array(right), equal_nan=True):
            raise AssertionError(f"another answer than Python's: {text}")
        return "grown: right"
    text = spoiled(truth(luck, 3)[0], luck) if kind == "spoiled" else garbage(luck)
    try:
        database.query(text, **options(luck))
    except FloquetError as error:
        if "\n" in str(error).strip() or len(str(error)) > 2000:
            raise AssertionError(f"no sentence: {str(error)[:300]!r}") from error
        return f"{kind}: refused"
    return f"{kind}: answered"


# ---------------------------------------------------------------------- files
STUDY = """
[study]
name = "proof"
schema = 1
title = "a title"
[rotors]
files = ["rotor.toml"]
list = [{ name = "light", lock_number = 6.0 }, { lock_number = 6.0, hub = "teetering", blades = 2 }]
[rotors.grid]
blades = [3, 4]
lock_number = { start = 4.0, stop = 12.0, count = 5 }
[rotors.sobol]
count = 8
seed = 1
lock_number = [4.0, 12.0]
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 11 }
[compare]
model = "auto"
tip_loss = 0.97
tolerances = [0.05, 0.10]
mu_max = 1.0
map = false
[output]
columns = ["exponent_1", "lock"]
"""
ROTOR = """
[rotor]
name = "Bo 105"
hub = "articulated"
blades = 4
flap_damping = 0.0
[rotor.physical]
radius = 4.91
rotor_speed = 44.4
flap_inertia = 231.7
hinge_spring = 113330.0
lock_number = 5.087
[rotor.sources]
radius = "somewhere"
"""
BOLD = ("inf", "-inf", "nan", "1e400", "1e308", "-1", "0", "1e-320", "1000000000", "9" * 40, "10000000", "true", "'x'",
        "''", "[]", "{}", "[[]]", "2020-01-01", "[1, 'a']", "{ start = 0, stop = 1, count = 1000000 }", "0x7f", "1_000",
        "{ start = 1e308, stop = -1e308, count = 3 }", "'../../etc/passwd'", "'rotor.toml'", "[nan]", "1.5",
        '"\\u0000"',
        "{ start = 0.0, stop = 1.0, count = 0 }", "[0.1, 0.1]", "[1, 2, 3, 4, 5]", "'" + "a" * 5000 + "'")  # fmt: skip


def spoiled_file(text: str, luck: random.Random) -> bytes:
    """A file with some damage: bold values, keys, lines; or bytes."""
    lines = text.strip().split("\n")
    for _ in range(luck.choice([1, 1, 2, 4])):
        at = luck.randrange(len(lines))
        key, equals, _ = lines[at].partition(" = ")
        match luck.randrange(8):
            case 0 | 1 | 2 if equals:
                lines[at] = f"{key} = {luck.choice(BOLD)}"
            case 3 if equals:
                lines[at] = f"{spoiled(key, luck)} = {luck.choice(BOLD)}"
            case 4:
                lines.insert(at, lines[luck.randrange(len(lines))])
            case 5:
                del lines[at]
                lines = lines or [""]
            case 6:
                lines[at] = spoiled(lines[at], luck)
            case _:
                n = luck.choice([3, 100, 10_000])
                deep = (
                    f"{key} = {'[' * n}{']' * n}",
                    f"{key} = {'{a=' * n}1{'}' * n}",
                    f"[{'a.' * n}a]",
                    "a." * n + "a = 1",
                )
                lines[at] = luck.choice(deep)
    out = bytearray("\n".join(lines).encode("utf-8", "surrogatepass"))
    for _ in range(luck.choice([0, 0, 0, 0, 1, 3])):
        out[luck.randrange(len(out) or 1) : 0] = luck.randbytes(luck.choice([1, 2, 40]))
    return bytes(out)


def file(folder: Path, luck: random.Random) -> str:
    """One file; how it ended."""
    kind = luck.choice(["study", "rotor"])
    path = folder / f"bold-{kind}.toml"
    path.write_bytes(spoiled_file(STUDY if kind == "study" else ROTOR, luck))
    try:
        if kind == "study":
            loaded = load_study(path)
            assert study.dry_run(loaded).points == loaded.plan.points > 0
            assert loaded.plan.advance_ratio.min() >= 0 and np.isfinite(loaded.plan.advance_ratio).all()
        else:
            rotor = load_rotor(path)
            assert rotor.lock_number > 0 and math.isfinite(rotor.flap_frequency) and rotor.blades >= 1
    except FloquetError as error:
        if len(str(error)) > 20_000:
            raise AssertionError(f"no sentence: {str(error)[:300]!r}") from error
        return f"{kind}: refused"
    return f"{kind}: read"


def prove(what: str, count: int, one: Callable[[random.Random], str]) -> bool:
    """Try something so many times; each time from a seed of its own, which is told if it fails."""
    ends, began, failed = Counter[str](), time.monotonic(), 0
    signal.signal(signal.SIGALRM, _hang)
    for i in range(count):
        signal.alarm(SECONDS)
        try:
            ends[one(random.Random(f"{SEED} {what} {i}"))] += 1
        except (Exception, Hung) as error:
            failed += 1
            last = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(last.filename).name}:{last.lineno}"
            if failed <= 20:
                print(f"FAILED: {what} {i}: {type(error).__name__} in {place}: {str(error)[:200]!a}", flush=True)
        finally:
            signal.alarm(0)
    told = ", ".join(f"{n} {end}" for end, n in sorted(ends.items()))
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    print(f"{count} {what}: {told}; {failed} failed; {count / (time.monotonic() - began):.0f} a second, {most} MB")
    return not failed


def main(queries: int = QUERIES, files: int = FILES) -> int:
    """Both; exit status."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    warnings.simplefilter("ignore", FloquetWarning)
    reader = Memory(40)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "rotor.toml").write_text(ROTOR, encoding="utf-8")
        good = [prove("queries", queries, lambda luck: query(reader, luck)),
                prove("files", files, lambda luck: file(Path(folder), luck))]  # fmt: skip
    return int(not all(good))


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
