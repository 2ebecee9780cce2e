"""floquet.query: the language against Python's own reading of it row by row, its errors, chunk skipping, streaming."""

from __future__ import annotations

import gc
import json
import random
import re
import shlex
import sys
import tracemalloc
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from floquet import query, store
from floquet.chunks import AHEAD
from floquet.cli import main
from floquet.comparison import compare
from floquet.errors import DatabaseError, FloquetWarning, InputError, ParameterError, QueryError
from floquet.query import (
    Database,
    Interval,
    Predicate,
    Scope,
    compile_expression,
    intervals,
    language,
    open_database,
    several,
)
from floquet.rotor import Rotor
from floquet.study import load_study, run

ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Column:
    """What the language needs of a column."""

    dtype: str = "f8"
    units: str = "1"
    long_name: str = ""
    flags: dict[int, str] | None = None


VERDICT = Column("i1", flags={0: "STABLE", 1: "UNSTABLE", 2: "UNDECIDED"})
CAUSE = Column("i1", flags={-1: "ABSENT", 0: "NONE", 1: "DRIFT", 2: "LOCK"})
POINTS = {
    "rotor": Column("i4", long_name="index of the rotor"),
    "advance_ratio": Column(long_name="advance ratio"),
    "lock_number": Column(),
    "hinge_offset": Column(units="R"),
    "pitch_flap_coupling": Column(),
    "blades": Column("i2"),
    "exponent_1": Column("c16"),
    "lock": Column(),
    "verdict": VERDICT,
    "error_regressing": Column(),
    "error_coning": Column(),
    "cause_regressing": CAUSE,
}
LIMITS = {
    "rotor": Column("i4"),
    "lock_number": Column(),
    "hinge_offset": Column(),
    "mode": Column("i1", flags={0: "regressing", 1: "coning"}),
    "tolerance": Column(),
    "limit": Column(),
    "cause": CAUSE,
    "intervals": Column("i4"),
    "interval_1_start": Column(),
    "interval_1_end": Column(),
}
NAMES = ("Bo 105", "Lynx", "UH-60")


class FakeFile:
    """The methods of an open store file over arrays in memory; counts what is read."""

    def __init__(self, tables: dict[str, dict[str, Any]], names: tuple[str, ...] = NAMES, chunk: int = 64) -> None:
        self._tables, self.names, self.chunk = tables, names, chunk
        self.attributes = {"title": "a database"}
        self._columns = {"points": POINTS, "limits": LIMITS}
        self.read: list[tuple[int, tuple[str, ...]]] = []

    @property
    def tables(self) -> tuple[str, ...]:
        return tuple(self._tables)

    def columns(self, table: str) -> dict[str, Column]:
        return {name: column for name, column in self._columns[table].items() if name in self._tables[table]}

    def left_out(self, table: str) -> tuple[str, ...]:
        return ()

    def rows(self, table: str) -> int:
        return len(next(iter(self._tables[table].values())))

    def _values(self, table: str, name: str) -> Any:
        data = self._tables[table]
        if name in data:
            return data[name]
        return data[name[:-3]].real if name.endswith("_re") else data[name[:-3]].imag

    def chunks(
        self, table: str, columns: Any, start: int = 0, stop: int | None = None, skip: Any = None
    ) -> Iterator[tuple[int, dict[str, Any]]]:
        stop = self.rows(table) if stop is None else stop
        for a in range(start, stop, self.chunk):
            part = {name: self._values(table, name)[a : min(a + self.chunk, stop)].copy() for name in columns}
            if skip is not None and skip(*_ranges(part)):
                continue
            self.read.append((a, tuple(columns)))
            yield a, part

    def spans(self, table: str, start: int = 0, stop: int | None = None, skip: Any = None) -> Iterator[tuple[int, int]]:
        stop = self.rows(table) if stop is None else stop
        for a in range(start, stop, self.chunk):
            b = min(a + self.chunk, stop)
            part = {name: self._values(table, name)[a:b] for name in self.columns(table)} if skip is not None else {}
            if skip is None or not skip(*_ranges(part)):
                yield a, b


def _ranges(part: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Minima and maxima that pass over nan; nan where there is nothing else."""
    minima, maxima = {}, {}
    for name, values in part.items():
        known = values[~np.isnan(values)]
        minima[name] = known.min() if known.size and known.dtype.kind != "c" else np.nan
        maxima[name] = known.max() if known.size and known.dtype.kind != "c" else np.nan
    return minima, maxima


def points(rows: int = 400, seed: int = 1) -> dict[str, Any]:
    """Quarters from −2 to 2 (so that ties and exact powers happen), with nan, ±inf and −0.0 among them."""
    g = np.random.default_rng(seed)

    def number() -> Any:
        values = g.integers(-8, 9, rows) / 4
        for special in (np.nan, np.inf, -np.inf, -0.0):
            values[g.random(rows) < 0.04] = special
        return values

    floats = {name: number() for name, column in POINTS.items() if column.dtype == "f8"}
    table = {
        "rotor": g.integers(0, len(NAMES), rows).astype("i4"),
        "blades": g.integers(2, 6, rows).astype("i2"),
        "exponent_1": np.where(np.isfinite(floats["lock"]), floats["lock"], 0) + 1j * g.integers(0, 4, rows),
        "verdict": g.integers(0, 3, rows).astype("i1"),
        "cause_regressing": g.integers(-1, 3, rows).astype("i1"),
        **floats,
    }
    return {name: table[name] for name in POINTS}


def limits(rows: int = 30, seed: int = 2) -> dict[str, Any]:
    g = np.random.default_rng(seed)
    table: dict[str, Any] = {name: g.random(rows) for name in LIMITS}
    table |= {"rotor": g.integers(0, 3, rows).astype("i4"), "mode": g.integers(0, 2, rows).astype("i1")}
    intervals = (np.arange(rows) % 3).astype("i4")
    return table | {"cause": g.integers(0, 3, rows).astype("i1"), "intervals": intervals}


@pytest.fixture
def db() -> Database:
    return Database("fake.h5", FakeFile({"points": points(), "limits": limits()}))


SCOPE = Scope.of(POINTS, NAMES, left_out=["rotation_number"])


def holds(expression: str, table: dict[str, Any]) -> Any:
    return compile_expression(expression, SCOPE).holds(with_parts(table), len(table["rotor"]))


def with_parts(table: dict[str, Any]) -> dict[str, Any]:
    """The table and the parts of its complex columns."""
    parts = {name: values for name, values in table.items() if values.dtype.kind == "c"}
    real = {name + "_re": values.real for name, values in parts.items()}
    return table | real | {name + "_im": values.imag for name, values in parts.items()}


# --- the language is a subset of Python: Python reads the same text row by row ----------------------------------------


PYTHON = {
    "F": np.float64,
    "inf": np.float64(np.inf),
    "abs": abs,
    "sqrt": np.sqrt,
    "isnan": np.isnan,
    "isfinite": np.isfinite,
    "min": lambda *a: np.float64(np.nan) if any(np.isnan(x) for x in a) else min(a),
    "max": lambda *a: np.float64(np.nan) if any(np.isnan(x) for x in a) else max(a),
    "__builtins__": {},
}


def python_rows(text: str, table: dict[str, Any]) -> Any:
    """Python's answer, one row after another, numbers as float64 so that 1/0 is inf; words as their text."""
    code = compile(re.sub(r"(?<![\w.])(\d+\.?\d*|\.\d+)", r"F(\1)", text), "<query>", "eval")
    answer = []
    for row in range(len(table["rotor"])):
        values = {name: np.float64(v[row]) for name, v in with_parts(table).items() if v.dtype.kind != "c"}
        for name, column in POINTS.items():
            if column.flags:
                values[name] = column.flags[int(table[name][row])]
        answer.append(bool(eval(code, PYTHON, values)))
    return np.array(answer)


class Writer:
    """Random expressions, with few parentheses, so that precedence decides."""

    def __init__(self, seed: int) -> None:
        self.r = random.Random(seed)

    def number(self, depth: int) -> str:
        r = self.r
        if depth <= 0 or r.random() < 0.3:
            constant = r.choice(["0", "1", "0.25", "2.", ".5", "1.5", "inf"])
            columns = ["advance_ratio", "lock_number", "lock", "blades", "rotor", "exponent_1_re", "exponent_1_im"]
            return constant if r.random() < 0.3 else r.choice(columns)
        a, b = self.number(depth - 1), self.number(depth - 1)
        form = r.choice(["{} + {}", "{} - {}", "{} * {}", "{} / {}", "-{}", "+{}", "({})", "({} - {})", "min({}, {})"])
        power = ["{} ** 2", "({}) ** 2", "-{} ** 2", "({}) ** -1", "{} ** 0", "({}) ** 3", "abs({})", "max({}, {}, 0)"]
        return (form if r.random() < 0.7 else r.choice(power)).format(a, b)

    def truth(self, depth: int) -> str:
        r = self.r
        if depth <= 0 or r.random() < 0.2:
            return self.leaf()
        a, b, c = (self.truth(depth - 1) for _ in range(3))
        return r.choice(["{} and {}", "{} or {}", "not {}", "({})", "({} or {})", "{} or {} and not {}"]).format(
            a, b, c
        )

    def leaf(self) -> str:
        r = self.r
        a, b, c = (self.number(2) for _ in range(3))
        sign, other = r.choice(["<", "<=", ">", ">=", "==", "!="]), r.choice(["<", "<=", "==", "!="])
        forms = [
            f"{a} {sign} {b}",
            f"{a} {sign} {b} {other} {c}",
            f"{a} in (0, .25, 2, -1.5)",
            f"{a} not in (1, inf,)",
            f"isnan({a})",
            f"isfinite({a})",
            f'verdict {r.choice(["==", "!="])} "{r.choice(["STABLE", "UNSTABLE"])}"',
            "cause_regressing in ('LOCK', \"DRIFT\")",
        ]
        return r.choice([*forms[:2], *forms])


def expressions(count: int, seed: int) -> Iterator[str]:
    writer = Writer(seed)
    for _ in range(count):
        yield writer.truth(3)


def test_random_expressions_mean_what_python_means() -> None:
    table = {name: values[:40] for name, values in points(seed=7).items()}
    share = []
    with np.errstate(all="ignore"):
        for text in expressions(350, seed=3):
            expected = python_rows(text, table)
            np.testing.assert_array_equal(holds(text, table), expected, err_msg=text)
            share.append(expected.mean())
    assert 0.3 < np.mean(share) < 0.7 and np.mean((np.array(share) > 0) & (np.array(share) < 1)) > 0.4


@pytest.mark.parametrize(
    "text",
    [
        "not advance_ratio < 0.5 and lock_number > 0",
        "not advance_ratio < 0.5 or lock_number > 0 and blades == 4",
        "-advance_ratio ** 2 > -1",
        "2 ** -1 < advance_ratio",
        "2 ** 3 ** 0 * blades == 4",
        "1 - lock_number - 1 < 0",
        "1 / lock_number / 2 > 0.25",
        "1 - 2 * blades + 3 <= -4",
        "0 < advance_ratio <= 1 != lock_number",
        "not not isnan(lock)",
        "not blades in (2, 4) and blades > 2",
        "lock != lock",
        "1 < 2",
        "1 / 0 == inf",
        "isnan(0 / 0) and blades == 3",
    ],
)
def test_precedence_is_pythons(text: str) -> None:
    table = points()
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(holds(text, table), python_rows(text, table))


def test_nan_is_false_in_every_comparison_but_unequal() -> None:
    table = {"lock": np.array([np.nan, 0.5]), "rotor": np.zeros(2, "i4")}
    for text in ("lock < 1", "lock <= 1", "lock > 0", "lock >= 0", "lock == 0.5", "lock in (0.5, 1)", "0 < lock < 1"):
        assert holds(text, table).tolist() == [False, True], text
    for text in ("lock != 0.5", "not lock == 0.5", "not lock > 0", "isnan(lock)", "lock not in (0.5, 1)"):
        assert holds(text, table).tolist() == [True, False], text
    assert holds("isfinite(lock) and lock != 1", table).tolist() == [False, True]


def test_words_match_in_any_capitals_and_a_name_as_written_goes_first() -> None:
    table = points()
    unstable = table["verdict"] == 1
    for text in ('verdict == "UNSTABLE"', "verdict == 'unstable'", '"Unstable" == verdict', 'verdict in ("unstable")'):
        np.testing.assert_array_equal(holds(text, table), unstable)
    np.testing.assert_array_equal(holds('verdict not in ("stable", "undecided")', table), unstable)
    np.testing.assert_array_equal(holds('verdict != "UNSTABLE"', table), ~unstable)
    np.testing.assert_array_equal(holds('rotor == "bo 105"', table), table["rotor"] == 0)
    np.testing.assert_array_equal(holds("rotor in (0, 2)", table), table["rotor"] != 1)
    np.testing.assert_array_equal(holds("rotor + 1 > 2", table), table["rotor"] > 1)
    twins = Scope.of(POINTS, ("lynx", "Lynx", "Lynx"))
    assert compile_expression('rotor == "Lynx"', twins).holds({"rotor": np.arange(3)}, 3).tolist() == [
        False,
        True,
        True,
    ]
    assert compile_expression('rotor == "LYNX"', twins).holds({"rotor": np.arange(3)}, 3).all()


# --- everything that is refused, in one sentence with its column ------------------------------------------------------

REFUSED = [
    ("advance_ratio > 0.3 & lock_number < 6", 21, "write and instead of &"),
    ("advance_ratio > 0.3 | lock_number < 6", 21, "write or instead of |"),
    ("advance_ratio > 0.3 && lock_number < 6", 21, "write and instead of &"),
    ('__import__("os")', 1, "'__import__' is no function; there are abs, min"),
    ('__import__("os").system("true")', 17, "'.' is not part of the language"),
    ("advance_ratio.__class__ > 1", 14, "'.' is not part of the language"),
    ("lambda: 0", 7, "':' is not part of the language"),
    ("@lock > 1", 1, "'@' is not part of the language"),
    ("µ > 0.3", 1, "'µ' is not part of the language"),
    ("advance_ratio = 0.3", 15, "write == to compare"),
    ("!(lock > 1)", 1, "write not"),
    ("lock ^ 2 > 1", 6, "write ** for a power"),
    ("blades in [2, 4]", 11, "x in (1, 2, 3)"),
    ("verdict == “STABLE”", 12, "straight quotes"),
    ("advance_ratoi > 0.3", 1, "'advance_ratoi' is no column of this table, did you mean 'advance_ratio'?"),
    ("blades > 1 and verdct == 'STABLE'", 16, "did you mean 'verdict'?"),
    ("mu > 0.3", 1, "the column is advance_ratio"),
    ("gamma > 6", 1, "the column is lock_number"),
    ("lock == nan", 9, "isnan(x)"),
    ("verdict == UNSTABLE", 12, 'a word stands in quotes, as in verdict == "UNSTABLE"'),
    ("rotor_name == 'Lynx'", 1, "use rotor"),
    ("exponent_1 > 0", 1, "exponent_1 is complex; write exponent_1_re or exponent_1_im"),
    ("exponent_1_ree > 0", 1, "did you mean 'exponent_1_re'?"),
    ("advance_ratio", 1, "advance_ratio is a number where a truth value is needed; compare advance_ratio"),
    ("not lock_number", 5, "lock_number is a number where a truth value is needed"),
    ("lock > 1 and blades + 1", 14, "this is a number where a truth value is needed"),
    ("lock > 1 or abs(blades)", 13, "this is a number where a truth value is needed"),
    ("(lock > 1) + 2 > 0", 2, "a comparison stands where a number is needed; join comparisons with and, or, not"),
    ("abs(lock > 1) > 0", 5, "a comparison stands where a number is needed"),
    ("isnan(lock) == 1", 1, "a comparison stands where a number is needed"),
    ("-(lock > 1) > 0", 3, "a comparison stands where a number is needed"),
    ("verdict", 1, "verdict is a column of words where a truth value is needed; compare verdict with == or !="),
    ("verdict + 1 > 2", 1, "verdict is a column of words where a number is needed"),
    ("isnan(verdict)", 7, "verdict is a column of words where a number is needed"),
    ("verdict == 1", 12, 'verdict holds words; compare it with a word in quotes, as in verdict == "STABLE"'),
    ("1 == verdict", 1, "verdict holds words"),
    ("verdict == cause_regressing", 1, "cause_regressing holds words"),
    ("verdict in ('STABLE', 1)", 23, "verdict holds words"),
    ("rotor in (1, 'Lynx')", 11, "rotor holds words"),
    ("verdict > 'STABLE'", 9, "words have no order"),
    ("verdict < 1", 9, "words have no order"),
    (
        "verdict == 'UNSTABEL'",
        12,
        "'UNSTABEL' is no word of verdict, which has STABLE, UNSTABLE, UNDECIDED, did you mean",
    ),
    ("verdict == 'unstabel'", 12, "did you mean 'unstable'?"),
    ("verdict == ''", 12, "'' is no word of verdict"),
    ("rotor == 'Bo 106'", 10, "did you mean 'Bo 105'?"),
    (
        "lock == 'LOCK'",
        1,
        "lock holds numbers, which a word in quotes cannot be compared with; these columns hold words:",
    ),
    ("lock + 1 == 'LOCK'", 1, "this is a number, which a word in quotes cannot be compared with"),
    ("'a' == 'b'", 8, "this is a word in quotes, which"),
    ("lock in ('LOCK')", 1, "lock holds numbers"),
    ("'LOCK'", 1, "a word in quotes stands where a truth value is needed"),
    ("'LOCK' + 1 > 0", 1, "a word in quotes stands where a number is needed"),
    ("blades in (2, lock)", 15, "the members of a set are numbers or words"),
    ("blades in ()", 1, "the set after in is empty"),
    ("blades in 4", 11, "a set in parentheses is due after in"),
    ("blades not 4", 12, "a set in parentheses is due after in"),
    ("0 < blades in (2, 4)", 12, "'in' cannot follow what stands before it"),
    ("blades in (2, 4) == 2", 18, "'==' cannot follow what stands before it"),
    ("lock_number ** advance_ratio > 1", 16, "the exponent after ** is a number"),
    ("lock ** abs(blades) > 1", 9, "the exponent after ** is a number"),
    ("lock ** (2 + blades) > 1", 10, "the exponent after ** is a number"),
    ("lock ** -blades > 1", 9, "the exponent after ** is a number"),
    ("abs() > 1", 1, "abs takes one argument, none given"),
    ("sqrt(1, 2) > 1", 1, "sqrt takes one argument, 2 given"),
    ("min(blades) > 1", 1, "min takes two or more arguments, 1 given"),
    ("abs > 1", 1, "abs is a function; write abs(…)"),
    ("lock(1) > 1", 1, "'lock' is no function"),
    ("()", 2, "there is nothing between these parentheses"),
    ("lock > 1 and ( )", 16, "there is nothing between these parentheses"),
    ("(lock > 1", 1, "the parenthesis opened here is never closed"),
    ("((lock > 1) and (blades > 2)", 1, "the parenthesis opened here is never closed"),
    ("lock > 1)", 9, "this ) closes no parenthesis"),
    (")(", 1, "this ) closes no parenthesis"),
    ("verdict == 'STABLE", 12, "the quote ' opened here is never closed"),
    ("verdict == \"STABLE'", 12, 'the quote " opened here is never closed'),
    ("lock > ", 7, "the expression ends where a column, a number or a word in quotes is due"),
    ("lock > 1 and", 13, "the expression ends where"),
    ("not", 4, "the expression ends where"),
    ("> 1", 1, "'>' stands where a column, a number or a word in quotes is due"),
    ("lock > > 1", 8, "'>' stands where"),
    ("lock <> 1", 7, "'>' stands where"),
    ("and", 1, "'and' stands where"),
    ("lock 1", 6, "'1' follows without an operator; join comparisons with and, or"),
    ("lock > 1 blades > 2", 10, "'blades' follows without an operator"),
    ("lock > 1 AND blades > 2", 10, "write and in small letters"),
    ("NOT lock > 1", 5, "'lock' follows without an operator"),
    ("lock > 1, blades > 2", 9, "a comma stands only between"),
    ("1.2.3 > lock", 4, "'.3' follows without an operator"),
    ("0x10 > lock", 2, "'x10' follows without an operator"),
    ("lock > 1; blades > 2", 9, "';' is not part of the language"),
    ("nearest > 1", 1, "nearest is a function; write nearest(…)"),
    ("nearest()", 1, "nearest takes columns with their numbers, as in nearest(advance_ratio=0.35)"),
    ("nearest(lock, 0.3)", 1, "nearest takes columns with their numbers"),
    ("nearest(lock == 0.3)", 1, "nearest takes columns with their numbers"),
    ("abs(lock=0.3) > 1", 1, "only nearest takes columns with their numbers"),
    ("nearest(lock=0.3, 2)", 19, "'2' follows without an operator"),
    ("nearest(lokc=0.3)", 9, "did you mean 'lock'?"),
    ("nearest(exponent_1=0.3)", 9, "exponent_1 is complex"),
    ("nearest(verdict='STABLE')", 9, "verdict holds words, and nearest is of numbers; compare words, as in verdict =="),
    ("nearest(rotor='Lynx')", 15, "a word in quotes stands where a number is needed"),
    ("nearest(inf=3)", 9, "inf is no column"),
    ("nearest(lock=blades)", 14, "lock is held against a number"),
    ("nearest(lock=-inf)", 14, "nothing is near -inf; give a finite number"),
    ("nearest(lock=0/0)", 14, "nothing is near nan"),
    ("nearest(lock=0.3, blades=2, lock=0.4)", 29, "nearest is given lock twice"),
    ("nearest(lock=0.3) > 1", 9, "a comparison stands where a number is needed"),
    ("nearest(lock=)", 14, "')' stands where"),
    ("nearest(1=lock)", 10, "'=' is not part of the language"),
    ("1e999 > lock", 1, "1e999 is beyond the largest number"),
    ("9" * 5000 + " > lock", 1, "is beyond the largest number"),
    ("(" * 10_000, 65, "parentheses are nested more than 64 deep"),
    ("(" * 65 + "lock > 1" + ")" * 65, 65, "parentheses are nested more than 64 deep"),
    ("abs(" * 1000 + "lock" + ")" * 1000 + "> 1", 260, "parentheses are nested more than 64 deep"),
    ("-" * 9000 + "lock > 1", 63, "are nested more than 64 deep; write the expression flatter"),
    ("not " * 2400 + "lock > 1", 253, "are nested more than 64 deep"),
    ("lock" + "**2" * 3000 + " > 1", 190, "are nested more than 64 deep"),
    ("x" * 20_000, 10_001, "20000 characters are given and 10000 allowed"),
    ("(" * 10_001, 10_001, "10001 characters are given"),
    ("x" * 10_000, 1, "is no column of this table"),
    ("verdict == '" + "U" * 9000 + "'", 12, "is no word of verdict"),
    ("\ud800 > 1", 1, "'\\ud800' is not part of the language"),
    ("\0", 1, "'\\x00' is not part of the language"),
    ("lock > ٣", 8, "'٣' is not part of the language"),
]


@pytest.mark.parametrize(("text", "at", "sentence"), REFUSED, ids=[text[:30] for text, *_ in REFUSED])
def test_refused_with_a_sentence_and_a_column(text: str, at: int, sentence: str) -> None:
    with pytest.raises(QueryError) as e:
        compile_expression(text, SCOPE)
    message = str(e.value)
    assert sentence in message and e.value.column == at and e.value.expression == text
    assert message.startswith(f"query, column {at}: ") and "\n" not in message and len(message) < 250


def test_without_rotor_names_a_word_is_refused() -> None:
    with pytest.raises(QueryError, match="no rotor names; compare rotor with a number, as in rotor == 0"):
        compile_expression("rotor == 'Lynx'", Scope.of(POINTS, ()))


def test_an_expression_is_text() -> None:
    for wrong in (None, 3, b"lock > 1", ["lock > 1"]):
        with pytest.raises(QueryError, match="an expression is text"):
            compile_expression(wrong, SCOPE)


def test_the_limits_themselves_are_allowed() -> None:
    assert holds("(" * 64 + "blades > 1" + ")" * 64, points()).all()
    long = "lock > 1" + " or blades > 1" * 700
    assert 9500 < len(long) <= query.MAX_LENGTH and holds(long, points()).all()
    assert holds("blades > 0" + " + 0" * 2400, points()).all()
    assert holds("blades in (" + "2, " * 3000 + "3, 4, 5)", points()).all()
    assert holds("0" + " < blades" * 1 + " <= blades" * 900, points()).all()


def test_depth_needs_little_of_the_stack() -> None:
    """64 levels of the tree, the way down the most expensive rule, within 450 frames from here."""
    deep = "-abs(" * 31 + "lock" + ")" * 31 + " <= 0"
    frames, frame = 0, sys._getframe()
    while frame is not None:
        frames, frame = frames + 1, frame.f_back  # type: ignore[assignment]
    before = sys.getrecursionlimit()
    compile_expression("lock > 1", SCOPE)
    try:
        sys.setrecursionlimit(frames + 450)
        predicate = compile_expression(deep, SCOPE)
        predicate.holds(points(), 400)
        predicate.skip({"lock": 0.0}, {"lock": 1.0})
    finally:
        sys.setrecursionlimit(before)


def test_random_text_gives_an_answer_or_a_query_error() -> None:
    r = random.Random(11)
    table = {name: values[:8] for name, values in points().items()}
    tokens = (
        "( ) ( ) and or not in < <= == != > >= + - * / ** , . & | = ! ' \" ; [ ] { } : @ \\ % # $ 1 0.5 1e9 1e-400 "
        "1e400 lock blades verdict rotor exponent_1 exponent_1_re 'LOCK' 'STABLE' \"Lynx\" abs min isnan sqrt inf nan "
        "__import__ eval exec lambda None True \n \t \0 é ∞ 🚁 \u202e"
        " nearest = lock= nearest(lock="
    ).split(" ")
    letters = "()'\"<>=!&|+-*/., abcelkox0129_\n\té\0"
    good = list(expressions(100, seed=5))
    accepted = 0
    for case in range(4000):
        if case % 4 == 0:
            text = "".join(r.choice(letters) for _ in range(r.randrange(20)))
        elif case % 4 == 3:
            text = list(r.choice(good))
            for _ in range(r.randrange(1, 4)):
                text[r.randrange(len(text))] = r.choice([*tokens, *[" "] * 40])
            text = "".join(text)
        else:
            text = r.choice(["", " "]).join(r.choice(tokens) for _ in range(r.randrange(1, 12)))
        try:
            answer = holds(text, table)
        except QueryError as e:
            assert 0 < e.column <= len(text) + 1 and "\n" not in str(e)
        else:
            accepted += 1
            assert answer.shape == (8,) and answer.dtype == bool
    assert 50 < accepted < 3900


# --- skipping chunks --------------------------------------------------------------------------------------------------


def _narrow(seed: int) -> dict[str, Any]:
    """Chunks of 8 rows whose ranges are narrow, so that skipping has something to skip."""
    g = np.random.default_rng(seed)
    table = points(8, seed)
    for name, values in table.items():
        if values.dtype.kind == "f":
            values[:] = g.integers(-8, 9) / 4 + g.choice([0, 0.25, 0.5], 8) * g.integers(0, 2)
            values[g.random(8) < g.choice([0, 0, 0.3, 1], p=[0.6, 0.1, 0.2, 0.1])] = np.nan
            values[g.random(8) < g.choice([0, 0.2], p=[0.8, 0.2])] = g.choice([np.inf, -np.inf, 0.0, -0.0])
        elif name != "exponent_1":
            values[:] = values[0] + (g.random(8) < 0.2) * (values[0] < 2)
    return table


@pytest.mark.parametrize("style", ["past nan", "nan wins", "nothing stored"])
def test_a_skipped_chunk_holds_no_row(style: str) -> None:
    skipped = empty = 0
    chunks = [_narrow(seed) for seed in range(12)]
    for text in expressions(350, seed=13):
        predicate = compile_expression(text, SCOPE)
        for table in chunks:
            real = {
                n + p: v for n, c in table.items() if c.dtype.kind == "c" for p, v in (("_re", c.real), ("_im", c.imag))
            }
            full = {**table, **real}
            minima, maxima = _ranges(full)
            if style == "nan wins":
                minima, maxima = ({n: f(v) for n, v in full.items() if v.dtype.kind != "c"} for f in (np.min, np.max))
            elif style == "nothing stored":
                minima, maxima = {}, {}
            some = predicate.holds(full, 8).any()
            skip = predicate.skip(minima, maxima)
            assert not (skip and some), (text, minima, maxima)
            skipped, empty = skipped + skip, empty + (not some)
    share = {"past nan": 0.6, "nan wins": 0.5, "nothing stored": 0.02}[style]
    assert skipped > share * empty, (skipped, empty)


def test_intervals_bound_every_operation() -> None:
    """Random intervals, infinite and zero ends too: every value of an operation lies inside, nan only if announced."""
    g = np.random.default_rng(17)
    ends = np.array([-np.inf, -1e308, -3.5, -1.0, -1e-310, 0.0, 5e-324, 0.1, 1.0, 2.0, 7.0, 1e200, np.inf])
    exponents = (0.0, 1.0, 2.0, 3.0, -1.0, -2.0, 0.5, -0.5, 1e3, np.inf, -np.inf, 2.5)
    powers = [
        intervals.Operation(lambda x, e=e: np.power(x, e), lambda a, e=e: intervals.power(a, e), 1) for e in exponents
    ]
    operations = [
        *intervals.ARITHMETIC.values(),
        *intervals.COMPARISONS.values(),
        *intervals.FUNCTIONS.values(),
        *powers,
    ]

    def draw() -> tuple[Interval, Any]:
        low, high = np.sort(g.choice(ends, 2) if g.random() < 0.7 else g.choice(ends, 1).repeat(2))
        inside = np.clip(np.concatenate([[low, high], g.normal(0, 3, 8), ends]), low, high)
        inside = np.where((inside == 0) & (g.random(inside.size) < 0.5), -inside, inside)
        nan = bool(g.random() < 0.3)
        return Interval(low, high, nan), np.append(inside, np.nan) if nan else inside

    with np.errstate(all="ignore"):
        for _ in range(400):
            a, x = draw()
            b, y = draw() if g.random() < 0.7 else (a, x)
            x, y = (v.ravel() for v in np.meshgrid(x, y))
            for operation in operations:
                two = operation.least == 2
                found = operation.bounds(*(a, b)[: 1 + two])
                value = np.asarray(operation.value(*(x, y)[: 1 + two]), dtype=float)
                known = value[~np.isnan(value)]
                assert ((found.low <= known) & (known <= found.high)).all(), (operation, a, b, found)
                assert found.nan or known.size == value.size, (operation, a, b, found)


def test_bounds_are_tight_at_their_ends() -> None:
    """One chunk, rotor and lock from 2 to 3 (rotor an integer, so never nan): what is skipped, what is not."""
    for text, skipped in {
        "rotor < 2": True,
        "rotor <= 2": False,
        "rotor > 3": True,
        "rotor >= 3": False,
        "rotor == 1": True,
        "not rotor <= 3": True,
        "not lock <= 3": False,
        "not rotor < 3": False,
        "rotor in (0, 1, 4)": True,
        "rotor not in (2, 3)": False,
        "rotor == 2 and rotor == 4": True,
        "rotor == 2 or rotor == 4": False,
        "rotor - 3 > 0 or 2 * rotor < 4 or -rotor > -2 or rotor / 2 > 1.5": True,
        "isnan(rotor) or not isfinite(rotor) or isnan(sqrt(rotor))": True,
        "isnan(lock)": False,
        "rotor ** 2 < 3.999 or rotor ** -1 > 0.501 or abs(rotor - 3) > 1": True,
        "min(rotor, 5) > 3 or max(rotor, 1) < 2": True,
    }.items():
        predicate = compile_expression(text, SCOPE)
        assert predicate.skip({"rotor": 2, "lock": 2.0}, {"rotor": 3, "lock": 3.0}) is skipped, text
    cube = intervals.power(Interval(2.0, 3.0), 3.0)
    assert 8 - 1e-10 < cube.low < 8 - 1e-12 and 27 + 1e-12 < cube.high < 27 + 1e-10


def test_skipping_reads_only_the_chunks_that_matter() -> None:
    table = points(640)
    table["advance_ratio"] = np.linspace(0, 1, 640)
    file = FakeFile({"points": table})
    found = Database("x", file).query("0.35 < advance_ratio < 0.45", columns=("advance_ratio", "lock"))
    assert sorted({start for start, _ in file.read}) == [192, 256]
    inside = (table["advance_ratio"] > 0.35) & (table["advance_ratio"] < 0.45)
    np.testing.assert_array_equal(found["lock"], table["lock"][inside])


# --- rows -------------------------------------------------------------------------------------------------------------


def test_an_empty_expression_is_every_row(db: Database) -> None:
    for text in ("", "  \n"):
        found = db.query(text)
        assert list(found) == [
            "rotor", "rotor_name", "advance_ratio", "lock_number", "hinge_offset", "pitch_flap_coupling", "verdict",
            "lock", "error_regressing", "error_coning",
        ]  # fmt: skip
        np.testing.assert_array_equal(found["advance_ratio"], points()["advance_ratio"])
        assert found["rotor_name"].tolist() == [NAMES[i] for i in points()["rotor"]]


def test_columns_are_those_asked_for_and_default_ones_grow_by_those_used(db: Database) -> None:
    assert list(db.query("blades > 2 and exponent_1_re < 0", sort="error_coning"))[-2:] == ["blades", "exponent_1_re"]
    everything = db.query("blades == 4", columns="*")
    assert list(everything) == [*POINTS, "rotor_name"] == list(db.query("blades == 4", columns=("*", "rotor")))
    chosen = points()["blades"] == 4
    for name, values in points().items():
        np.testing.assert_array_equal(everything[name], values[chosen])
        assert everything[name].dtype == np.dtype(POINTS[name].dtype)
    one = db.query("blades == 4", columns=["exponent_1_im", "exponent_1", "exponent_1_im"])
    assert list(one) == ["exponent_1_im", "exponent_1"] and one["exponent_1"].dtype == complex
    np.testing.assert_array_equal(one["exponent_1_im"], one["exponent_1"].imag)
    assert list(db.query(columns="rotor_name")) == ["rotor_name"]


def test_an_empty_answer_keeps_its_dtypes(db: Database) -> None:
    for options in ({}, {"sort": "lock"}, {"sort": "lock", "limit": 3}, {"limit": 0}):
        text = "" if options == {"limit": 0} else "blades > 100"
        found = db.query(text, columns=("exponent_1", "verdict", "exponent_1_re", "rotor_name"), **options)  # type: ignore[arg-type]
        assert [v.shape for v in found.values()] == [(0,)] * 4
        assert [v.dtype for v in found.values()] == [complex, np.int8, float, object]
    assert db.query("blades > 1", sort="lock", limit=0)["lock"].size == 0


@pytest.mark.parametrize("descending", [False, True])
@pytest.mark.parametrize("limit", [None, 1, 7, 63, 64, 200, 399, 1000])
@pytest.mark.parametrize("sort", ["lock_number", "blades", "exponent_1_im", None, "lock, blades",
                                  ("verdict", "lock", "advance_ratio")])  # fmt: skip
def test_sorted_and_limited_rows_are_those_of_a_stable_sort(
    db: Database, sort: str | tuple[str, ...] | None, limit: int | None, descending: bool
) -> None:
    """Against Python's sort of all row numbers: ties in file order, nan last in both directions."""
    table = points() | {"exponent_1_im": points()["exponent_1"].imag}
    rows = [i for i in range(400) if table["blades"][i] != 3]
    keys = [] if sort is None else sort.split(", ") if isinstance(sort, str) else sort
    sign = -1 if descending else 1

    def place(i: int) -> list[tuple[bool, float]]:
        values = [float(table[name][i]) for name in keys]
        return [(v != v, 0.0 if v != v else sign * v) for v in values]

    rows.sort(key=place)
    found = db.query("blades != 3", columns=("rotor", "lock"), sort=sort, limit=limit, descending=descending and keys)
    for name in ("rotor", "lock"):
        np.testing.assert_array_equal(found[name], table[name][rows[:limit]])


def test_an_order_that_is_none_is_refused(db: Database) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"descending": True}, "descending: it turns an order round, and none is given: add sort"),
        ({"sort": " , "}, "sort: no column is named"),
        ({"sort": 3}, "sort: 3 was given; it is a column, or several"),
        ({"sort": "blades,-lock"}, "sort: '-lock' is no column: descending turns the whole order round"),
        ({"sort": ["lock", 3]}, "sort: ['lock', 3] was given"),
    ]
    for ask in (db.query, db.groups):
        for options, sentence in cases:
            with pytest.raises(ParameterError, match=re.escape(sentence)):
                ask(**options)
    with pytest.raises(QueryError, match="'lokc' is no column"):
        db.query(sort="blades, lokc")


@pytest.mark.parametrize("threads", [1, 3])
def test_a_limit_without_sort_stops_reading(threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", str(threads))
    under_way = 0 if threads == 1 else 64 * AHEAD * threads
    file = FakeFile({"points": points(6400)})
    assert Database("x", file).query("blades >= 2", limit=70)["rotor"].size == 70
    assert max(start for start, _ in file.read) <= 64 + under_way
    file.read.clear()
    assert Database("x", file).query(limit=64)["rotor"].size == 64
    assert max(start for start, _ in file.read) <= under_way
    file.read.clear()
    assert Database("x", file).query("blades >= 2", sort="lock", limit=0)["rotor"].size == 0 and not file.read


def test_rows_that_cannot_enter_the_best_are_not_read() -> None:
    """Ties and nan come after the ten that are there: columns beside the key are read in the first chunk alone."""
    for rest in (1.0, 2.0, np.nan):
        table = points(640) | {"lock": np.r_[np.ones(64), np.full(576, rest)]}
        file = FakeFile({"points": table})
        found = Database("x", file).query("", columns=("rotor", "lock"), sort="lock", limit=10)
        np.testing.assert_array_equal(found["rotor"], table["rotor"][:10])
        assert [start for start, columns in file.read if "rotor" in columns] == [0]


def test_the_second_key_decides_between_rows_without_the_first() -> None:
    table = points(640) | {"lock": np.full(640, np.nan), "lock_number": np.arange(640.0, 0.0, -1.0)}
    found = Database("x", FakeFile({"points": table})).query("", sort=("lock", "lock_number"), limit=10)
    assert found["lock_number"].tolist() == list(range(1, 11))


def test_untested_columns_are_read_only_where_rows_hold() -> None:
    table = points(640)
    table["lock_number"] = np.where(np.arange(640) == 300, 5.0, 1.0)
    file = FakeFile({"points": table})
    found = Database("x", file).query("lock_number * (1 + 0 * error_coning) == 5 or lock_number > 4", columns="*")
    assert found["rotor"].tolist() == [table["rotor"][300]]
    assert [start for start, columns in file.read if "rotor" in columns] == [256]


def test_memory_is_that_of_a_chunk_and_the_answer() -> None:
    """2 million rows in virtual chunks of 50 000 (0.4 MB a column): the ten smallest within 8 MB."""

    class Endless(FakeFile):
        def rows(self, table: str) -> int:
            return 2_000_000

        def chunks(self, table: str, columns: Any, start: int = 0, stop: int | None = None, skip: Any = None) -> Any:
            for a in range(start, stop or self.rows(table), 50_000):
                yield a, {name: np.sin(np.arange(a, a + 50_000)) for name in columns}

        def spans(self, table: str, start: int = 0, stop: int | None = None, skip: Any = None) -> Any:
            return ((a, a + 50_000) for a in range(start, stop or self.rows(table), 50_000))

    db = Database("x", Endless({"points": points(4)}))
    db.query("lock > 1", limit=0)
    gc.collect()
    tracemalloc.start()
    try:
        found = db.query("abs(lock) > 0.5", sort="lock", limit=10, columns=("lock", "advance_ratio"))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 8e6
    np.testing.assert_array_equal(found["lock"], np.sort(np.sin(np.arange(2_000_000)))[:10])


# --- nearest ----------------------------------------------------------------------------------------------------------


def nearest(values: Any, number: float) -> Any:
    """Row by row, in Python: the finite value at the least distance, and of two of them the smaller."""
    best = min((v for v in values.tolist() if np.isfinite(v)), key=lambda v: (abs(v - number), v))
    return values == best


@pytest.mark.parametrize("number", [-9.0, -0.375, -0.3, 0.0, 0.1, 0.125, 0.3, 1.9, 1e300])
def test_nearest_is_of_all_rows_column_by_column(db: Database, number: float) -> None:
    table = points()
    near, blades = nearest(table["lock"], number), nearest(table["blades"].astype(float), 3.4)
    for text, expected in {
        f"nearest(lock={number!r})": near,
        f"nearest(lock = {number!r}, blades=17/5,)": near & blades,
        f"not nearest(lock={number!r}) and blades > 2": ~near & (table["blades"] > 2),
        f"lock_number < 0 or nearest(lock={number!r}) or nearest(lock=2)": near
        | (table["lock"] == 2)
        | (table["lock_number"] < 0),
    }.items():
        assert expected.any() and not expected.all()
        np.testing.assert_array_equal(db.query(text, columns="error_coning")["error_coning"],
                                      table["error_coning"][expected], err_msg=text)  # fmt: skip


def test_nearest_does_not_depend_on_the_other_conditions_nor_on_what_is_sorted(db: Database) -> None:
    assert db.query("nearest(advance_ratio=0.26) and advance_ratio > 0.26")["rotor"].size == 0
    found = db.query("nearest(advance_ratio=0.26)", sort="lock", limit=3, columns=("lock", "advance_ratio"))
    lock = points()["lock"][points()["advance_ratio"] == 0.25]
    np.testing.assert_array_equal(found["lock"], np.sort(lock)[:3])
    assert list(db.query("nearest(exponent_1_re=-1)"))[-1] == "exponent_1_re"


def test_nearest_to_a_node_reads_the_chunks_about_it_and_two_passes_only_the_columns_they_need() -> None:
    table = points(6400) | {"advance_ratio": np.linspace(0, 1, 101).repeat(64)[:6400]}
    file = FakeFile({"points": table})
    found = Database("x", file).query("nearest(advance_ratio=0.4949)", columns=("lock",))
    np.testing.assert_array_equal(found["lock"], table["lock"][49 * 64 : 50 * 64])
    first, second = file.read[:-2], file.read[-2:]
    assert [start // 64 for start, _ in first] == list(range(50)) and {names for _, names in first} == {
        ("advance_ratio",)
    }
    assert second == [(49 * 64, ("advance_ratio",)), (49 * 64, ("lock",))]


def test_the_first_pass_skips_a_chunk_only_if_it_is_far_from_every_number() -> None:
    table = points(640) | {"advance_ratio": np.linspace(0, 1, 640), "lock": np.linspace(1, 0, 640)}
    found = Database("x", FakeFile({"points": table})).query(
        "nearest(advance_ratio=0.1, lock=0.1) or nearest(lock=0.2)"
    )
    np.testing.assert_array_equal(found["lock"], table["lock"][nearest(table["lock"], 0.2)])
    found = Database("x", FakeFile({"points": table})).query("nearest(advance_ratio=0.1, lock=0.9001)")
    np.testing.assert_array_equal(found["advance_ratio"], table["advance_ratio"][nearest(table["lock"], 0.9001)])


@pytest.mark.parametrize(("number", "expected"), [(0.55, 0.5), (0.65, 0.6), (0.15, 0.1), (0.35, 0.3), (0.95, 0.9)])
def test_of_two_as_near_the_smaller_whatever_their_last_digits(number: float, expected: float) -> None:
    table = points(200) | {
        "advance_ratio": np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]).repeat(20)[::-1]
    }
    found = Database("x", FakeFile({"points": table})).query(
        f"nearest(advance_ratio={number})", columns="advance_ratio"
    )
    assert found["advance_ratio"].tolist() == [expected] * 20


def test_numbers_beyond_all_values_are_told(recwarn: pytest.WarningsRecorder) -> None:
    table = points(640) | {"advance_ratio": np.linspace(0, 1, 640), "lock": np.full(640, np.nan)}
    db = Database("x", FakeFile({"points": table}))
    for near in ("advance_ratio=0", "advance_ratio=1", "advance_ratio=0.3333", "lock=2"):
        db.query(f"nearest({near})")
    assert not recwarn.list
    for number, its in ((5, 1), (-0.25, 0)):
        with pytest.warns(FloquetWarning, match=rf"which are 0 to 1: its rows are those of {its}$"):
            assert db.query(f"nearest(advance_ratio={number})", columns="advance_ratio")["advance_ratio"] == [its]


def test_nothing_is_nearest_where_nothing_is_finite() -> None:
    table = points(200) | {"lock": np.r_[np.full(100, np.nan), np.full(100, np.inf)]}
    db = Database("x", FakeFile({"points": table}))
    assert db.query("nearest(lock=1)")["rotor"].size == 0
    assert db.query("not nearest(lock=1)")["rotor"].size == 200
    assert Database("x", FakeFile({"points": points(0)})).query("nearest(lock=1)")["rotor"].size == 0


def test_nearest_in_a_file(stored: tuple[Path, dict[str, Any], dict[str, Any]]) -> None:
    path, table, some = stored
    with open_database(path) as db:
        found = db.query("nearest(advance_ratio=0.70001, rotor=2.2)", columns=("advance_ratio", "rotor"))
        np.testing.assert_array_equal(
            found["advance_ratio"], table["advance_ratio"][nearest(table["advance_ratio"], 0.70001)]
        )
        chosen = nearest(some["limit"], 3.3) & (some["mode"] == 0)
        np.testing.assert_array_equal(
            db.limits("nearest(limit=3.3) and mode == 'regressing'")["rotor"], some["rotor"][chosen]
        )


# --- groups -----------------------------------------------------------------------------------------------------------


def grouped(rows: list[int], table: dict[str, Any], by: tuple[str, ...]) -> dict[tuple[float, ...], list[int]]:
    """Row numbers by the values of their keys, in Python: −0 is 0, nan (as a text) is one value and comes last."""
    met: dict[tuple[Any, ...], list[int]] = {}
    for i in rows:
        values = [float(table[name][i]) for name in by]
        met.setdefault(tuple((v != v, 0.0 if v != v else v + 0.0) for v in values), []).append(i)
    return dict(sorted(met.items()))


REDUCE = {
    "min(error_coning)": lambda t, r: min((v for v in t["error_coning"][r] if v == v), default=np.nan),
    "max(blades)": lambda t, r: max(t["blades"][r]),
    "mean(hinge_offset)": lambda t, r: _mean([v for v in t["hinge_offset"][r] if v == v]),
    "mean(blades)": lambda t, r: _mean(t["blades"][r].tolist()),
    "count": lambda t, r: len(r),
    "count(lock)": lambda t, r: sum(v == v for v in t["lock"][r]),
    "first(lock)": lambda t, r: t["lock"][r[0]],
    "first(exponent_1)": lambda t, r: t["exponent_1"][r[0]],
    "first(verdict)": lambda t, r: t["verdict"][r[0]],
    "max(exponent_1_im)": lambda t, r: max(t["exponent_1"][r].imag),
    "advance_ratio at min(error_coning)": lambda t, r: t["advance_ratio"][_least(t["error_coning"], r)],
    "exponent_1 at max(lock)": lambda t, r: t["exponent_1"][_least(-t["lock"], r)],
    "verdict at max(exponent_1_im)": lambda t, r: t["verdict"][_least(-t["exponent_1"].imag, r)],
    "rotor_name at min(blades)": lambda t, r: NAMES[t["rotor"][_least(t["blades"], r)]],
}


def _least(values: Any, rows: list[int]) -> int:
    """The first row with the least value, nan after all else."""
    return min(rows, key=lambda i: (values[i] != values[i], 0.0 if values[i] != values[i] else values[i]))


def _mean(values: list[float]) -> float:
    return float(np.float64(sum(values)) / len(values)) if values else np.nan


@pytest.mark.parametrize(
    "by", [("lock_number",), ("verdict", "lock"), ("blades", "advance_ratio", "exponent_1_im"), ("rotor",)]
)
@pytest.mark.parametrize("text", ["", "blades != 3 and nearest(rotor=0.6)", "lock > 0.5"])
def test_groups_are_those_of_a_dictionary_of_rows(db: Database, by: tuple[str, ...], text: str) -> None:
    """Chunks of 64 rows, so that nearly every group has rows of several; eighths and quarters sum without rounding."""
    table = with_parts(points())
    chosen = {"": np.ones(400, bool), "lock > 0.5": table["lock"] > 0.5}.get(
        text, (table["blades"] != 3) & (table["rotor"] == 1)
    )
    with np.errstate(all="ignore"):
        expected = grouped(np.flatnonzero(chosen).tolist(), table, by)
        found = db.groups(text, by=by, reduce=", ".join(REDUCE))
        assert list(found) == [*by, *(("rotor_name",) if by == ("rotor",) else ()), *REDUCE]
        assert len(expected) >= (1 if by == ("rotor",) else 3)
        for i, name in enumerate(by):
            np.testing.assert_array_equal(found[name], [np.nan if key[i][0] else key[i][1] for key in expected])
            assert found[name].dtype == (float if name == "exponent_1_im" else np.dtype(POINTS[name].dtype))
        for name, reduction in REDUCE.items():
            np.testing.assert_array_equal(found[name], [reduction(table, r) for r in expected.values()], err_msg=name)
    kinds = {name: found[name].dtype.kind for name in ("max(blades)", "mean(blades)", "count", "first(verdict)")}
    assert list(kinds.values()) == ["i", "f", "i", "i"]


def test_no_key_is_one_group_and_no_row_is_none(db: Database) -> None:
    found = db.groups(reduce="count, min(blades)")
    assert {name: values.tolist() for name, values in found.items()} == {"count": [400], "min(blades)": [2]}
    assert (
        db.groups()["count"].tolist() == [400] and db.groups("blades == 3")["count"] == (points()["blades"] == 3).sum()
    )
    for by in (None, "verdict", ("rotor", "lock")):
        found = db.groups("blades > 100", by=by, reduce="first(exponent_1), min(blades), mean(lock), count")
        assert db.groups("blades > 100", by=by, reduce="lock at min(blades)")["lock at min(blades)"].size == 0
        assert [v.size for v in found.values()] == [0] * len(found)
        assert [v.dtype for v in found.values()][-4:] == [complex, np.int16, float, np.int64]


def test_of_no_rows_the_count_is_zero_and_the_rest_is_nan(db: Database) -> None:
    found = db.groups("blades > 100", reduce="count, count(lock), min(blades), mean(lock), median(lock)")
    assert {name: values.tolist() for name, values in found.items() if "count" in name} == {
        "count": [0], "count(lock)": [0]
    }  # fmt: skip
    assert all(np.isnan(values).all() and values.size == 1 for name, values in found.items() if "count" not in name)


def test_names_are_not_taken_where_there_are_none() -> None:
    nameless = Database("x", FakeFile({"points": points()}, names=()))
    with pytest.raises(ParameterError, match=r"no names; take rotor at min\(lock\)"):
        nameless.groups(by="blades", reduce="rotor_name at min(lock)")


def test_nan_is_one_group_whatever_its_bits_and_so_is_zero() -> None:
    table = points(128) | {"lock": np.r_[np.full(64, np.nan), -np.full(64, np.nan)]}
    table["lock_number"] = np.r_[np.full(64, 0.0), np.full(64, -0.0)]
    assert len({bytes(v.tobytes()) for v in table["lock"]}) == 2
    for by in ("lock", "lock_number"):
        assert Database("x", FakeFile({"points": table})).groups(by=by)["count"].tolist() == [128]


def test_groups_are_sorted_stably_and_limited(db: Database) -> None:
    for descending in (False, True):
        found = db.groups(by="advance_ratio", reduce="min(lock),count", sort="count", descending=descending, limit=7)
        all_of = db.groups(by=["advance_ratio"], reduce=["count", "min( lock )"])
        order = np.argsort(all_of["count"] * (-1 if descending else 1), kind="stable")[:7]
        assert list(found) == ["advance_ratio", "min(lock)", "count"]
        for name, values in found.items():
            np.testing.assert_array_equal(values, all_of[name][order])
    last = db.groups(by="lock", sort="lock", descending=True)["lock"]
    assert np.isnan(last[-1]) and np.isnan(last).sum() == 1 and (np.diff(last[:-1]) < 0).all()
    assert db.groups(by="rotor", limit=2)["rotor_name"].tolist() == list(NAMES[:2])
    assert list(db.groups(by="rotor_name")) == ["rotor", "rotor_name", "count"]


def test_groups_need_the_memory_of_a_chunk_and_of_themselves() -> None:
    class Endless(FakeFile):
        def rows(self, table: str) -> int:
            return 2_000_000

        def chunks(self, table: str, columns: Any, start: int = 0, stop: int | None = None, skip: Any = None) -> Any:
            for a in range(start, stop or self.rows(table), 50_000):
                yield a, {name: np.arange(a, min(a + 50_000, stop or 2_000_000)) % 1000 / 4 for name in columns}

    db = Database("x", Endless({"points": points(4)}))
    db.groups("lock > 1", by="lock", limit=0)
    gc.collect()
    tracemalloc.start()
    try:
        found = db.groups("lock >= 1", by="lock", reduce="mean(advance_ratio), count")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 12e6 and found["count"].tolist() == [2000] * 996
    np.testing.assert_array_equal(found["mean(advance_ratio)"], np.arange(4, 1000) / 4)


def test_the_wrong_group_is_named(db: Database) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"by": "lock_numbr"}, "by: 'lock_numbr' is no column of this table, did you mean 'lock_number'?"),
        ({"by": "exponent_1"}, "by: exponent_1 is complex; write exponent_1_re"),
        ({"by": " , "}, "by: no column is named; name some, or leave it out"),
        ({"by": 3}, "by: 3 was given; it is a text, or several"),
        ({"reduce": ""}, "reduce: nothing is asked for; name reductions, as in min(limit), count"),
        ({"reduce": [3]}, "reduce: [3] was given"),
        ({"reduce": "sum(lock)"}, "reduce: 'sum' is none of min, max, mean, median, count, first, as in min(limit)"),
        ({"reduce": "men(lock)"}, "did you mean 'mean'?"),
        (
            {"reduce": "argmin(lock)"},
            "'argmin' is none of min, max, mean, median, count, first; write rotor at min(lock)",
        ),
        ({"reduce": "idxmax"}, "; write rotor at max(limit)"),
        ({"reduce": "min"}, "reduce: min is of a column, as in min(limit)"),
        ({"reduce": "min(lock"}, "reduce: 'min(lock' is no reduction, as in min(limit), count"),
        ({"reduce": "min(lock + 1)"}, "'min(lock + 1)' is no reduction"),
        ({"reduce": "count, max(lokc)"}, "reduce: 'lokc' is no column of this table, did you mean 'lock'?"),
        ({"reduce": "max(exponent_1)"}, "reduce: exponent_1 is complex"),
        ({"reduce": "mean(verdict)"}, "verdict holds words, which have no order; take first(verdict) or count"),
        ({"reduce": "min(rotor)"}, "rotor numbers rotors, which have no order; take first(rotor)"),
        ({"reduce": "rotor at mean(lock)"}, "a value is at a least or greatest one, as in rotor at min(limit)"),
        ({"reduce": "rotr at min(lock)"}, "reduce: 'rotr' is no column of this table, did you mean 'rotor'?"),
        ({"reduce": "rotor at min(verdict)"}, "verdict holds words, which have no order"),
        ({"reduce": "rotor at lock"}, "'lock' is none of min, max"),
        ({"by": "lock", "sort": "blades"}, "sort: 'blades' is none of lock, count"),
        ({"by": "lock", "sort": "count, blades"}, "sort: 'blades' is none of lock, count"),
        ({"by": "lock", "sort": "cout"}, "did you mean 'count'?"),
        ({"reduce": "first(exponent_1)", "sort": "first(exponent_1)"}, "first(exponent_1) is complex"),
    ]
    for options, sentence in cases:
        with pytest.raises(ParameterError, match=re.escape(sentence)):
            db.groups(**options)
    with pytest.raises(QueryError, match="no column"):
        db.groups("lokc > 1")
    with pytest.raises(QueryError, match="limit is a number of rows"):
        db.groups(limit=-1)


# --- pandas and xarray ------------------------------------------------------------------------------------------------


def gridded(axes: dict[str, list[float]], **derived: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Points of a study on a grid, shuffled, with a number of the row's own; the columns are those of the schema."""
    values = [v.ravel() for v in np.meshgrid(*axes.values(), indexing="ij")]
    table = {name: np.zeros(values[0].size, store.POINTS[name].dtype) for name in store.ALWAYS}
    table |= dict(zip(axes, values, strict=True))
    table |= {"error_regressing": np.arange(values[0].size) / 8, "verdict": np.arange(values[0].size) % 3}
    design = np.stack([values[i] for i, name in enumerate(axes) if name != "advance_ratio"] or [0 * values[0]])
    table["rotor"] = np.unique(design, axis=1, return_inverse=True)[1].reshape(-1)
    table |= {name: formula(table) for name, formula in derived.items()}
    order = np.random.default_rng(5).permutation(values[0].size)
    return {name: v[order].astype(store.POINTS[name].dtype) for name, v in table.items()}, table


def opened(table: dict[str, Any], name: str = "points") -> Database:
    file = FakeFile({name: table})
    file._columns = dict(store.TABLES)  # type: ignore[assignment]
    return Database("grid.h5", file)


GRID = {"lock_number": [4.0, 6.0, 9.0], "hinge_offset": [0.0, 0.1], "advance_ratio": [0.0, 0.25, 0.5, 1.0]}


def test_pandas_has_rows_units_meanings_and_words(db: Database) -> None:
    frame = db.to_pandas("blades != 3", sort="lock_number", columns="*", limit=50)
    found = db.query("blades != 3", sort="lock_number", columns="*", limit=50)
    assert list(frame.columns) == list(found) and len(frame) == 50
    for name, values in found.items():
        flags = POINTS[name].flags if name in POINTS else None
        expected = [flags[v] for v in values.tolist()] if flags else values
        np.testing.assert_array_equal(frame[name].to_numpy(), np.array(expected), err_msg=name)
    assert list(frame["verdict"].cat.categories) == ["STABLE", "UNSTABLE", "UNDECIDED"]
    assert frame.attrs["units"]["hinge_offset"] == "R" and frame.attrs["title"] == "a database"
    assert frame.attrs["long_name"]["advance_ratio"] == "advance ratio"
    part = db.to_pandas(columns="exponent_1_im", table="points").attrs
    assert part["long_name"] == {"exponent_1_im": ", imaginary part"} and part["units"] == {"exponent_1_im": "1"}
    assert len(db.to_pandas("blades > 100")) == 0 and len(db.to_pandas(table="limits")) == 30


def test_a_grid_comes_with_its_axes_whatever_the_order_of_its_rows() -> None:
    rows, table = gridded(GRID, offset_mass_ratio=lambda t: 1.5 * t["hinge_offset"])
    for columns in (("error_regressing", "verdict"), ("verdict", "lock_number", "advance_ratio", "error_regressing")):
        data = opened(rows).to_xarray(columns=columns)
        assert dict(data.sizes) == {name: len(values) for name, values in GRID.items()} and set(data.data_vars) == {
            "error_regressing", "verdict",
        }  # fmt: skip
        for name, values in GRID.items():
            np.testing.assert_array_equal(data[name], values)
            assert data[name].attrs == {"units": "1", "long_name": store.POINTS[name].long_name}
        for name in ("error_regressing", "verdict"):
            assert data[name].dims == tuple(GRID)
            np.testing.assert_array_equal(data[name].values.ravel(), table[name])
        assert float(data["error_regressing"].sel(lock_number=6.0, hinge_offset=0.1, advance_ratio=0.5)) == 14 / 8
    attrs = data["verdict"].attrs
    assert attrs["flag_values"].tolist() == [0, 1, 2] and attrs["flag_meanings"] == "STABLE UNSTABLE UNDECIDED"
    assert attrs["long_name"] == store.POINTS["verdict"].long_name and data.attrs["title"] == "a database"


def test_the_axes_are_those_that_vary_among_the_rows_found() -> None:
    rows, _ = gridded(GRID, offset_mass_ratio=lambda t: 1.5 * t["hinge_offset"])
    cases: dict[str, tuple[str, ...]] = {
        "hinge_offset == 0": ("lock_number", "advance_ratio"),
        "nearest(advance_ratio=0.3)": ("lock_number", "hinge_offset"),
        "hinge_offset == 0 and lock_number == 9": ("advance_ratio",),
        "lock_number != 6": tuple(GRID),
        "lock_number < 9 or advance_ratio > 0.1": ("row",),
        "error_regressing >= 0.125": ("row",),
        "lock_number > 99": ("row",),
    }
    for text, dims in cases.items():
        data = opened(rows).to_xarray(text, columns=("error_regressing",), sort="error_regressing")
        assert data["error_regressing"].dims == dims, text
    found = opened(rows).query("error_regressing >= 0.125", sort="error_regressing")
    data = opened(rows).to_xarray("error_regressing >= 0.125", sort="error_regressing")
    for name, values in found.items():
        np.testing.assert_array_equal(data[name], values)


def test_a_mass_ratio_is_an_axis_only_where_it_is_one() -> None:
    free, _ = gridded({"hinge_offset": [0.0, 0.1], "offset_mass_ratio": [0.0, 0.1, 0.2], "advance_ratio": [0.0, 0.5]})
    assert dict(opened(free).to_xarray().sizes) == {"hinge_offset": 2, "offset_mass_ratio": 3, "advance_ratio": 2}
    bound, _ = gridded(
        {"hinge_offset": [0.05, 0.1], "static_moment_ratio": [1.0, 1.5, 2.0], "advance_ratio": [0.0, 0.5]},
        offset_mass_ratio=lambda t: t["hinge_offset"] * t["static_moment_ratio"],
    )
    assert dict(opened(bound).to_xarray().sizes) == {"hinge_offset": 2, "static_moment_ratio": 3, "advance_ratio": 2}


def test_rotors_that_are_no_grid_have_an_axis_of_their_own() -> None:
    rows, table = gridded({"lock_number": [4.0, 6.0, 9.0], "advance_ratio": [0.0, 0.5]},
                          hinge_offset=lambda t: np.where(t["lock_number"] == 6, 0.1, 0.0))  # fmt: skip
    data = opened(rows).to_xarray()
    assert dict(data.sizes) == {"rotor": 3, "advance_ratio": 2} and data["rotor"].values.tolist() == [0, 1, 2]
    np.testing.assert_array_equal(data["error_regressing"].values.ravel(), table["error_regressing"])
    assert data["rotor_name"].values[:, 0].tolist() == list(NAMES)
    twins = {name: np.r_[values, values] for name, values in rows.items()} | {
        "rotor": np.r_[rows["rotor"], rows["rotor"] + 3]
    }
    assert dict(opened(twins).to_xarray(columns="verdict").sizes) == {"rotor": 6, "advance_ratio": 2}


def test_axes_of_words_have_words() -> None:
    modes, tolerances = np.meshgrid([0, 1, 3], [0.05, 0.1], indexing="ij")
    table = {name: np.zeros(6, column.dtype) for name, column in store.LIMITS.items()}
    table |= {"mode": modes.ravel().astype("i1"), "tolerance": tolerances.ravel(), "limit": np.arange(6) / 4}
    data = opened(table, "limits").to_xarray(table="limits", columns="limit")
    words = [store.LIMITS["mode"].flags[i] for i in (0, 1, 3)]  # type: ignore[index]
    assert data["limit"].dims == ("mode", "tolerance") and data["mode"].values.tolist() == words
    assert float(data["limit"].sel({"mode": words[2], "tolerance": 0.1})) == 1.25


@pytest.mark.parametrize("name", ["pandas", "xarray"])
def test_a_library_that_is_missing_is_named(db: Database, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match=re.escape(f"to_{name} needs {name}: install floquet-rotor[export]")):
        getattr(db, f"to_{name}")()


# --- between the rows -------------------------------------------------------------------------------------------------


def curves(**changed: Any) -> dict[str, Any]:
    """Rows of two rotors, shuffled: a rotor in no lock whose columns are cubics of μ, and another one."""
    mu = np.r_[np.linspace(0, 1, 21), np.linspace(0, 1, 11)]
    table = {name: np.zeros(32, column.dtype) for name, column in store.POINTS.items()}
    table |= {"advance_ratio": mu, "rotor": np.r_[np.zeros(21, "i4"), np.ones(11, "i4")], "lock": np.full(32, np.nan)}
    table |= {"exponent_1": 1 - mu**3 + 2j * mu**2, "exponent_2": np.exp(mu) + 0j, "rotation_number": 0.55 + mu / 3}
    table |= {"error_regressing": mu**3, "error_coning": 5 * mu**2, "lock_number": np.full(32, 8.1)} | changed
    order = np.random.default_rng(9).permutation(32)
    return {name: values[order] for name, values in table.items()}


FIRST = slice(0, 21)  # the rows of the first rotor before they are shuffled


def test_between_the_rows_is_the_polynomial_of_the_nearest() -> None:
    """A cubic through four rows and more is exact; through three it is off by what is estimated, within a factor."""
    names = ("exponent_1", "error_regressing", "error_coning", "exponent_1_im", "lock_number")
    for count in (4, 5, 6, 12):
        found = opened(curves()).at("rotor == 0", advance_ratio=0.333, columns=names, rows=count)
        mu = 0.333
        expected = (1 - mu**3 + 2j * mu**2, mu**3, 5 * mu**2, 2 * mu**2, 8.1)
        assert list(found.values) == list(names) == list(found.errors) and len(found.rows) == count
        for name, value in zip(names, expected, strict=True):
            assert abs(found.values[name] - value) < 1e-13, name  # rounding of twelve terms with weights below 3
    three = opened(curves()).at('rotor == "bo 105"', advance_ratio=0.333, columns=names, rows=3)
    assert np.allclose(three.rows, (0.3, 0.35, 0.4), rtol=1e-15, atol=0) and (three.rotor, three.rotor_name) == (
        0,
        "Bo 105",
    )
    off = abs(three.values["error_regressing"] - mu**3)
    assert 1e-5 < off < three.errors["error_regressing"] < 1e-1 and three.errors["lock_number"] == 0.0
    assert three.values["lock_number"] == 8.1 and isinstance(three.values["exponent_1"], complex)


def test_the_error_is_the_larger_of_the_last_two_changes() -> None:
    found = opened(curves()).at("rotor == 0", advance_ratio=0.333, columns="exponent_2", rows=4)
    near, mu = np.array([0.35, 0.3, 0.4, 0.25]), 0.333
    by_fit = [float(np.polyval(np.polyfit(near[:k] - mu, np.exp(near[:k]), k - 1), 0)) for k in (4, 3, 2)]
    np.testing.assert_allclose(found.rows, (0.25, 0.3, 0.35, 0.4), rtol=1e-15)
    assert found.values["exponent_2"].real == pytest.approx(by_fit[0], rel=1e-13)
    assert found.errors["exponent_2"] == pytest.approx(np.abs(np.diff(by_fit)).max(), rel=1e-9)
    assert abs(found.values["exponent_2"] - np.exp(mu)) < found.errors["exponent_2"] / 10
    one_less = opened(curves()).at("rotor == 0", advance_ratio=0.333, columns="exponent_2", rows=6)
    assert abs(one_less.values["exponent_2"] - np.exp(mu)) < 1e-9 < found.errors["exponent_2"]


def test_a_row_is_itself_and_all_columns_with_numbers_come_where_none_are_named() -> None:
    found = opened(curves()).at("rotor == 0", advance_ratio=0.25)
    assert (
        found.rows == (0.25,)
        and found.values["exponent_2"] == complex(np.exp(0.25))
        and set(found.errors.values()) == {0.0}
    )
    numbers = {name for name, column in store.POINTS.items() if column.dtype in ("f8", "c16")}
    assert set(found.values) == numbers - {"advance_ratio", "lock", "exponent_error", "determinant_defect"}
    thrice = opened(curves()).at("rotor == 1", advance_ratio=0.3)
    assert thrice.rows == (3 * 0.1,) != (0.3,) and thrice.errors["exponent_2"] == 0.0
    off = opened(curves(error_coning=np.where(np.arange(32) == 6, np.nan, 0.0))).at("rotor == 0", advance_ratio=0.333)
    assert np.isnan(off.values["error_coning"]) and off.errors["error_coning"] == np.inf
    assert np.isfinite(off.values["error_regressing"]) and set(off.values) == set(found.values)


def test_rows_of_another_kind_are_never_taken_and_an_edge_is_refused() -> None:
    lock = np.full(32, np.nan)
    lock[8:12] = 1.0  # μ from 0.40 to 0.55
    step = np.where(np.arange(32) >= 8, 1000.0, 0.0)
    db = opened(curves(lock=lock, error_regressing=step))
    names = ("error_regressing",)
    assert db.at("rotor == 0", advance_ratio=0.34, columns=names).values["error_regressing"] == 0.0
    inside = db.at("rotor == 0", advance_ratio=0.48, columns=names)
    np.testing.assert_allclose(inside.rows, (0.4, 0.45, 0.5, 0.55))
    assert inside.values["error_regressing"] == 1000.0
    for mu, words in ((0.36, "0.35 and 0.4 (no lock, the lock at 1)"), (0.57, "0.55 and 0.6 (the lock at 1, no lock)")):
        with pytest.raises(
            ParameterError, match=re.escape(f"advance_ratio: there is an edge of a lock between the rows {words}")
        ):
            db.at("rotor == 0", advance_ratio=mu, columns=names)
    assert db.at("rotor == 0", advance_ratio=0.4, columns=names).values["error_regressing"] == 1000.0


@pytest.mark.parametrize("at", [1.0, 0.5, 1.5])
def test_a_lock_that_no_row_is_in_is_refused(at: float) -> None:
    """The rotation number passes a multiple of ½ between rows 0.45 and 0.5, and no row is locked."""
    db = opened(curves(rotation_number=np.r_[at - 0.1 + np.linspace(0, 1, 21) / 4.8, np.full(11, 0.7)]))
    with pytest.raises(
        ParameterError, match=re.escape("a lock lies between the rows 0.45 and 0.5 (the rotation number")
    ):
        db.at("rotor == 0", advance_ratio=0.47, columns="exponent_1")
    assert max(db.at("rotor == 0", advance_ratio=0.44, columns="exponent_1").rows) == pytest.approx(0.45)


@pytest.mark.parametrize("kind", ["rule", "cause"])
def test_a_kind_that_changes_is_refused_for_the_columns_of_its_mode(kind: str) -> None:
    changed = np.where(np.arange(32) < 7, 0, 1).astype("i1")  # between 0.3 and 0.35
    db = opened(curves(**{f"{kind}_regressing": changed}))
    flags = store.POINTS[f"{kind}_regressing"].flags or {}
    words = (
        f"between the rows 0.3 and 0.35 ({kind}_regressing is {flags[0]}, then {flags[1]}); name columns of other modes"
    )
    for names in ("error_regressing", "tpp_regressing_1", "frequency_error_regressing", None):
        if names is None or names in store.POINTS:
            with pytest.raises(ParameterError, match=re.escape(words)):
                db.at("rotor == 0", advance_ratio=0.333, columns=names)
    near = db.at("rotor == 0", advance_ratio=0.333, columns=("error_coning", "exponent_1"))
    assert min(near.rows) < 0.3 < 0.35 < max(near.rows)
    assert min(db.at("rotor == 0", advance_ratio=0.36, columns="error_regressing").rows) == pytest.approx(0.35)


def test_what_cannot_be_said_between_rows_is_refused() -> None:
    few = {name: values for name, values in curves().items() if name not in ("lock", "cause_coning")}
    half = {name: values for name, values in curves().items() if name != "cause_coning"}
    edges = curves(lock=np.where(np.arange(32) % 3 == 0, 1.0, np.nan))
    cases: list[tuple[dict[str, Any], dict[str, Any], str]] = [
        (curves(), {"advance_ratio": 1.01}, "advance_ratio: 1.01 lies outside of the rows, which go from 0.0 to 1.0"),
        (curves(), {"advance_ratio": -0.1}, "-0.1 lies outside"),
        (curves(), {"advance_ratio": np.nan}, "advance_ratio: nan was given; it must be a finite number"),
        (curves(), {"advance_ratio": "0.3"}, "advance_ratio: '0.3' was given"),
        (curves(), {"rows": 2}, "rows: 2 was given; it is a number from 3 to 12"),
        (curves(), {"rows": 13}, "rows: 13 was given"),
        (curves(), {"columns": "verdict"}, "columns: verdict holds words, and has no value between rows"),
        (curves(), {"columns": "panels"}, "columns: panels counts, and has no value between rows"),
        (curves(), {"columns": "exponent_error"}, "exponent_error is each row's own, and has no value between rows"),
        (
            curves(),
            {"columns": ["exponent_1", "lokc"]},
            "columns: 'lokc' is no column of this table, did you mean 'lock'?",
        ),
        (curves(), {"columns": []}, "columns: no column that is stored here has values between rows"),
        (half, {"columns": "error_coning"}, "error_coning needs the column cause_coning, which is not stored"),
        (few, {"columns": "exponent_1"}, "exponent_1 needs the column lock, which is not stored"),
        (few, {}, "columns: no column that is stored here has values between rows"),
        (curves(), {"expression": ""}, "expression: 2 rotors have rows for which it holds (0, 1); name one"),
        (curves(), {"expression": "rotor > 7"}, "expression: it holds for no row; name one"),
        (edges, {"advance_ratio": 0.22}, "only 2 rows about 0.22 are of its kind (0.2 to 0.25)"),
    ]
    for table, options, sentence in cases:
        with pytest.raises(ParameterError, match=re.escape(sentence)):
            opened(table).at(**{"expression": "rotor == 0", "advance_ratio": 0.333} | options)


def test_between_the_rows_of_a_study_is_what_is_computed_there(tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(
        "[study]\nname = 'one'\n[rotors]\nlist = [{ lock_number = 8.0 }]\n"
        "[axes]\nadvance_ratio = { start = 0.0, stop = 0.5, count = 51 }\n"
    )
    run(load_study(tmp_path / "one.toml"), tmp_path / "one.h5", workers=1)
    with open_database(tmp_path / "one.h5") as db:
        found = db.at(advance_ratio=0.333)
    there = compare(Rotor(lock_number=8.0), 0.333)
    for name, exact in {
        "exponent_1": there.stability.exponents[0],
        "rotation_number": there.stability.rotation_number,
        "error_regressing": there["regressing"].error,
    }.items():
        assert abs(found.values[name] - exact) < found.errors[name] < 1e-6, name


# --- several files ----------------------------------------------------------------------------------------------------


def three_files(chunk: int = 64) -> tuple[Database, dict[str, Any], list[FakeFile]]:
    """Three files of 150, 0 and 100 rows with three, two and one rotor; the arrays that they are together."""
    parts = [points(150), points(0), points(100, seed=4)]
    parts[2]["rotor"] = np.zeros(100, "i4")
    names = (NAMES, ("A", "B"), ())
    files = [FakeFile({"points": part}, name, chunk) for part, name in zip(parts, names, strict=True)]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in POINTS}
    whole["file"] = np.repeat([0, 1, 2], [150, 0, 100])
    whole["rotor"] = whole["rotor"] + np.where(whole["file"] == 2, 5, 0)
    paths = ["a.h5", "b.h5", "c.h5"]
    return Database(", ".join(paths), several.Several(paths, files)), whole, files


def test_several_files_are_their_rows_after_one_another() -> None:
    db, whole, _ = three_files()
    assert db.rows() == 250 and db.names == (*NAMES, "A", "B", "") and list(db.columns())[:2] == ["file", "rotor"]
    assert db.path == "a.h5, b.h5, c.h5" and db.attributes == {"title": "a database"}
    assert db.describe()[0] == ("file", "1", "file that the row is from")
    lock = whole["lock"]
    for text, rows in {
        "": np.ones(250, bool),
        "lock > 0.5": lock > 0.5,
        'file == "c.h5"': whole["file"] == 2,
        'file != "C.H5" and lock > 0.5 or rotor == 5 and blades == 3': (whole["file"] == 0) & (lock > 0.5)
        | (whole["rotor"] == 5) & (whole["blades"] == 3),
        'rotor == "Lynx"': whole["rotor"] == 1,
        'file == "b.h5" or rotor == "A"': np.zeros(250, bool),
        "nearest(lock=0.3)": nearest(lock, 0.3),
    }.items():
        found = db.query(text, columns="*")
        assert list(found) == ["file", *POINTS, "rotor_name"]
        for name in ("file", *POINTS):
            np.testing.assert_array_equal(found[name], whole[name][rows], err_msg=text)
        assert found["rotor"].dtype == np.int32
        assert found["rotor_name"].tolist() == [db.names[i] for i in whole["rotor"][rows]]
    order = np.argsort(lock, kind="stable")[:120]
    np.testing.assert_array_equal(db.query(sort="lock", limit=120, columns="rotor")["rotor"], whole["rotor"][order])
    assert list(db.query("lock > 1"))[:3] == ["file", "rotor", "rotor_name"]
    assert db.query(columns="file")["file"].tolist() == whole["file"].tolist()


def test_several_files_reduce_and_go_to_pandas_and_xarray() -> None:
    db, whole, _ = three_files()
    found = db.groups("blades > 2", by="file", reduce="count, max(blades), first(file)")
    chosen = whole["blades"] > 2
    assert found["count"].tolist() == [(chosen & (whole["file"] == i)).sum() for i in (0, 2)]
    assert found["file"].tolist() == found["first(file)"].tolist() == [0, 2]
    assert set(db.to_pandas()["file"]) == {"a.h5", "c.h5"}
    rows, table = gridded(GRID)
    files = [FakeFile({"points": rows | {"error_regressing": rows["error_regressing"] + add}}) for add in (0, 100)]
    for file in files:
        file._columns = dict(store.TABLES)  # type: ignore[assignment]
    data = Database("x", several.Several(["one.h5", "two.h5"], files)).to_xarray(columns="error_regressing")
    assert data["error_regressing"].dims == ("file", *GRID) and data["file"].values.tolist() == ["one.h5", "two.h5"]
    for name, add in (("one.h5", 0), ("two.h5", 100)):
        np.testing.assert_array_equal(
            data["error_regressing"].sel(file=name).values.ravel(), table["error_regressing"] + add
        )


def test_chunks_of_several_files_are_skipped_in_the_numbers_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", "1")  # no chunk is under way before its turn
    db, whole, files = three_files(chunk=50)
    for text, read in {'file == "c.h5"': (0, 2), "rotor > 4": (0, 2), "rotor < 5 and blades > 0": (3, 0)}.items():
        for file in files:
            file.read.clear()
        found = db.query(text, columns="rotor")
        np.testing.assert_array_equal(found["rotor"], whole["rotor"][whole["file"] == (0 if read[0] else 2)])
        assert (len({a for a, _ in files[0].read}), len({a for a, _ in files[2].read})) == read, text
    for file in files:
        file.read.clear()
    assert db.query(limit=10)["rotor"].size == 10 and not files[2].read
    parts = list(db._reader.chunks("points", ["file", "rotor"], 140, 170))
    assert [(first, len(part["file"])) for first, part in parts] == [(140, 10), (150, 20)]
    for file in files:
        file.read.clear()
    assert db.query(limit=10)["rotor"].size == 10 and not files[2].read
    count = several._rotors(files[0])
    assert count == 3 and [len(file.read) for file in files] == [1, 0, 0]  # ranges say it, and no chunk is read


def test_files_that_differ_are_refused() -> None:
    one, other = FakeFile({"points": points(9)}), FakeFile({"points": points(9), "limits": limits()})
    with pytest.raises(DatabaseError, match=re.escape("b.h5: its tables are points and limits, those of a.h5 points")):
        several.Several(["a.h5", "b.h5"], [one, other])
    fewer = FakeFile({"points": {name: v for name, v in points(9).items() if name not in ("lock", "blades")}})
    for pair in ([one, fewer], [fewer, one]):
        with pytest.raises(
            DatabaseError, match=r"b.h5: its table points and that of a.h5 have different columns .*lock"
        ):
            several.Several(["a.h5", "b.h5"], pair)
    changed = FakeFile({"points": points(9)})
    changed._columns = {"points": POINTS | {"lock": Column(units="Hz"), "verdict": Column("i1", flags={0: "A"})}}
    with pytest.raises(DatabaseError, match=re.escape("have different columns (lock, verdict)")):
        several.Several(["a.h5", "b.h5"], [one, changed])


def test_several_files_are_opened_and_closed(
    stored: tuple[Path, dict[str, Any], dict[str, Any]], tmp_path: Path
) -> None:
    path, table, some = stored
    second = tmp_path / "second.h5"
    store.write(
        second, {"points": {n: v[:20_000] for n, v in table.items()}, "limits": some}, {"title": "b", "study_id": "1"}
    )
    with open_database([path, str(second)]) as db:
        assert db.rows() == 60_000 and db.names == (*NAMES, "", "", "") and db.attributes["title"] == "a test; b"
        assert "study_id" not in db.attributes and "schema_version" in db.attributes
        found = db.query("0.3 < advance_ratio < 0.45", columns=("advance_ratio", "file", "rotor"))
        for number, of in ((0, 40_000), (1, 20_000)):
            rows = (table["advance_ratio"][:of] > 0.3) & (table["advance_ratio"][:of] < 0.45)
            here = found["file"] == number
            np.testing.assert_array_equal(found["advance_ratio"][here], table["advance_ratio"][:of][rows])
            np.testing.assert_array_equal(found["rotor"][here], table["rotor"][:of][rows] + 3 * number)
        assert db.groups(by="file", table="limits")["count"].tolist() == [50, 50]
        assert db.query("lock == 7", columns="file", table="points")["file"].size == 0
    with pytest.raises(DatabaseError, match="closed"):
        db.rows()
    with open_database([path]) as db:
        assert set(db.query(limit=3)["file"]) == {0}
    for wrong, sentence in (
        ([path, path], "is given twice"),
        ([path, 3], "3 was given; it must be the name of a file"),
    ):
        with pytest.raises(ParameterError, match=re.escape(sentence)):
            open_database(wrong)  # type: ignore[arg-type]
    with pytest.raises(DatabaseError, match=r"none\.h5"):
        open_database([path, tmp_path / "none.h5"])


def test_the_wrong_option_is_named(db: Database) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"table": "point"}, "'point' is no table; this file has points, limits, did you mean 'points'?"),
        ({"columns": ["lokc"]}, "'lokc' is no column of this table, did you mean 'lock'?"),
        ({"columns": "x; y"}, "'x; y' is no column"),
        ({"columns": []}, "no columns are asked for"),
        ({"columns": 3}, "columns is a text or a list of names, and 3 was given"),
        ({"sort": "lock_numer"}, "did you mean 'lock_number'?"),
        ({"sort": "exponent_1"}, "exponent_1 is complex; write exponent_1_re"),
        ({"limit": -1}, "limit is a number of rows, 0 or more, and -1 was given"),
        ({"limit": 1.5}, "1.5 was given"),
        ({"limit": True}, "True was given"),
    ]
    for options, sentence in cases:
        with pytest.raises(QueryError, match=re.escape(sentence)):
            db.query("", **options)


def test_the_table_of_limits(db: Database) -> None:
    found = db.query("mode == 'regressing' and cause == \"LOCK\"", table="limits")
    chosen = (limits()["mode"] == 0) & (limits()["cause"] == 2)
    assert chosen.any() and list(found)[:3] == ["rotor", "rotor_name", "lock_number"] and "limit" in found
    np.testing.assert_array_equal(found["limit"], limits()["limit"][chosen])
    np.testing.assert_array_equal(db.limits("mode == 'regressing'", sort="limit", limit=1)["mode"], [0])


def test_a_database_describes_itself_and_closes() -> None:
    with Database("fake.h5", FakeFile({"points": points(9)})) as db:
        assert db.rows() == 9 and db.names == NAMES and db.tables == ("points",) and db.path == "fake.h5"
        assert db.attributes == {"title": "a database"} and list(db.columns()) == list(POINTS)
        assert db.describe()[:2] == [("rotor", "1", "index of the rotor"), ("advance_ratio", "1", "advance ratio")]
        assert repr(db) == "Database('fake.h5')"
    db.close()
    with pytest.raises(DatabaseError, match="the database is closed; open it again"):
        db.query("lock > 1")


def test_rotors_without_names() -> None:
    db = Database("x", FakeFile({"points": points(20)}, names=()))
    assert "rotor_name" not in db.query()
    for columns in ("*", ("rotor_name",)):
        assert db.query(columns=columns)["rotor_name"].tolist() == [""] * 20
    table = points(20)
    table["rotor"][:2] = -2, -1
    short = Database("x", FakeFile({"points": table}, names=("A",))).query(columns=("rotor", "rotor_name"))
    assert all((name == "A") == (i == 0) and name in ("A", "") for i, name in zip(*short.values(), strict=True))


def test_a_predicate_without_a_tree_skips_nothing() -> None:
    assert not Predicate(scope=SCOPE).skip({}, {})


# --- a file -----------------------------------------------------------------------------------------------------------


def _rows(columns: dict[str, Any], rows: int, seed: int) -> dict[str, Any]:
    """Every column of a table of the schema: nothing but zeros, and numbers in those that are asked about."""
    g = np.random.default_rng(seed)
    table = {name: np.zeros(rows, column.dtype) for name, column in columns.items()}
    for name in ("lock_number", "hinge_offset", "error_regressing", "limit"):
        if name in table:
            table[name] = g.integers(0, 64, rows) / 8
    for name, column in columns.items():
        if column.flags and name in ("verdict", "mode", "cause", "cause_regressing"):
            table[name] = g.choice(list(column.flags), rows).astype(column.dtype)
    table["rotor"] = (np.arange(rows) * 3 // rows).astype("i4")
    return table


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], dict[str, Any]]:
    """A file of three chunks: μ rises along it, the second chunk is locked throughout, the third not at all."""
    table, some = _rows(store.POINTS, 40_000, 1), _rows(store.LIMITS, 50, 2)
    table["advance_ratio"] = np.linspace(0, 1, 40_000)
    table["lock"] = np.where(np.arange(40_000) % 7 == 0, 0.5, np.nan)
    table["lock"][16384:32768], table["lock"][32768:] = 1.0, np.nan
    table["exponent_1"] = -np.linspace(0, 1, 40_000) + 1j * (np.arange(40_000) % 5)
    path = tmp_path_factory.mktemp("query") / "validity.h5"
    attributes = {"title": "a test", "study_id": "0", "rotor_names": json.dumps(NAMES)}
    store.write(path, {"points": table, "limits": some}, attributes)
    return path, table, some


def test_a_file_answers_as_its_arrays_do(stored: tuple[Path, dict[str, Any], dict[str, Any]]) -> None:
    path, table, some = stored
    with open_database(path) as db:
        assert db.names == NAMES and db.rows() == 40_000 and db.tables == ("points", "limits")
        assert db.attributes["title"] == "a test" and db.path == str(path)
        assert ("exponent_1", "1", store.POINTS["exponent_1"].long_name) in db.describe()
        for text, expected in {
            "": np.ones(40_000, bool),
            "0.2 < advance_ratio <= 0.4 and lock_number < 6": (table["advance_ratio"] > 0.2)
            & (table["advance_ratio"] <= 0.4)
            & (table["lock_number"] < 6),
            'verdict == "UNSTABLE" or cause_regressing == "LOCK"': (table["verdict"] == 1)
            | (table["cause_regressing"] == 2),
            'rotor == "lynx"': table["rotor"] == 1,
            "exponent_1_re < -0.5 and exponent_1_im in (1, 4)": (table["exponent_1"].real < -0.5)
            & np.isin(table["exponent_1"].imag, (1, 4)),
            "lock == 0.5": table["lock"] == 0.5,
            "isnan(lock)": np.isnan(table["lock"]),
            "lock != 1": table["lock"] != 1,
            "not isfinite(lock) and advance_ratio < 0.1": np.isnan(table["lock"]) & (table["advance_ratio"] < 0.1),
        }.items():
            found = db.query(text, columns=("advance_ratio", "exponent_1", "verdict", "rotor", "rotor_name"))
            assert expected.any()
            for name in ("advance_ratio", "exponent_1", "verdict", "rotor"):
                np.testing.assert_array_equal(found[name], table[name][expected], err_msg=text)
                assert found[name].dtype == table[name].dtype
            assert found["rotor_name"].tolist() == [NAMES[i] for i in table["rotor"][expected]]
        best = db.query(sort="error_regressing", descending=True, limit=20, columns=("advance_ratio",))
        order = np.argsort(-table["error_regressing"], kind="stable")[:20]
        np.testing.assert_array_equal(best["advance_ratio"], table["advance_ratio"][order])
        regressing = db.limits("mode == 'regressing' and limit < 4")
        chosen = (some["mode"] == 0) & (some["limit"] < 4)
        np.testing.assert_array_equal(regressing["limit"], some["limit"][chosen])
        assert list(db.query("lock == 7", columns="*")) == [*store.POINTS, "rotor_name"]


def test_the_default_columns_are_columns_of_the_schema() -> None:
    for table, names in query.DEFAULT_COLUMNS.items():
        assert set(names) - {language.ROTOR_NAME} <= set(store.TABLES[table])


def test_chunks_of_a_file_are_skipped_by_their_stored_ranges(
    stored: tuple[Path, dict[str, Any], dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[int] = []
    numbers = store.File._numbers
    monkeypatch.setattr(
        store.File,
        "_numbers",
        lambda self, table, name, chunk: [read.append(chunk), numbers(self, table, name, chunk)][1],
    )
    with open_database(stored[0]) as db:
        for text, chunks in {
            "advance_ratio > 0.9": {2},
            "0.45 < advance_ratio < 0.7": {1},
            "exponent_1_re > -0.1": {0},
            "lock < 0.75": {0, 2},  # where everything is nan, nothing is stored and nothing can be said
            "lock != 1": {0, 1, 2},  # a chunk of ones may have nan among them
            "verdict == 'UNSTABLE' and rotor == 'Bo 105'": {0},
            "advance_ratio > 2": set(),
        }.items():
            read.clear()
            db.query(text, columns=("hinge_offset",))
            assert set(read) == chunks, text


def test_what_is_no_database_is_said_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "text.h5").write_text("advance_ratio > 0.3")
    for name in ("text.h5", "missing.h5", "."):
        with pytest.raises(DatabaseError):
            open_database(tmp_path / name)


# --- docs/query.md: every example runs --------------------------------------------------------------------------------

PAGE = (ROOT / "docs" / "query.md").read_text(encoding="utf-8")


def fenced(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGE, flags=re.M | re.S)


def test_the_expressions_of_the_page_run_and_find_rows() -> None:
    db = Database("fake.h5", FakeFile({"points": points(4000), "limits": limits()}))
    lines = [line for block in fenced("text") for line in block.splitlines()]
    assert len(lines) >= 10
    for line in lines:
        table = "limits" if line.startswith("mode") else "points"
        found = db.query(line.split("  #")[0], table=table)
        assert len(found["rotor"]) > 0, line


def as_asked(path: Any, file: FakeFile) -> Any:
    return file if isinstance(path, str) else several.Several(path, [file] * len(path))


def test_the_python_of_the_page_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    file = FakeFile({"points": curves(), "limits": limits()})
    file._columns = {"points": store.POINTS, "limits": LIMITS}  # type: ignore[dict-item]
    monkeypatch.setattr("floquet.open_database", lambda path: Database(str(path), as_asked(path, file)))
    scope: dict[str, Any] = {}
    for block in fenced("py"):
        exec(block, scope)
    assert scope["both"]["file"].size > 0 and set(scope["both"]["file"]) == {1}
    assert scope["least"]["count"].sum() == (limits()["mode"] == 0).sum()


def test_the_commands_of_the_page_run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    file = FakeFile({"points": points(), "limits": limits()})
    monkeypatch.setattr("floquet.query.open_database", lambda path: Database(str(path), as_asked(path, file)))
    commands = [shlex.split(line) for block in fenced("sh") for line in block.splitlines()]
    assert len(commands) >= 5
    for program, *arguments in commands:
        assert program == "floquet"
        with pytest.raises(SystemExit) as end:
            main(arguments)
        shown = capsys.readouterr().out.splitlines()
        assert end.value.code == 0 and len(shown) > 2, arguments


def test_the_refusals_of_the_page_are_what_is_said() -> None:
    (block,) = fenced("refused")
    lines = block.splitlines()
    assert len(lines) >= 6 and len(lines) % 2 == 0
    for text, said in zip(lines[::2], lines[1::2], strict=True):
        with pytest.raises(QueryError) as e:
            compile_expression(text, SCOPE)
        caret, sentence = said.index("^"), said[said.index("^") + 1 :].strip()
        assert e.value.column == caret + 1 and str(e.value).endswith(": " + sentence), text


def test_the_page_names_every_function_and_operator() -> None:
    for word in [
        *intervals.FUNCTIONS,
        *intervals.COMPARISONS,
        *language.KEYWORDS,
        language.NEAREST,
        "**",
        "inf",
        f"{query.MAX_LENGTH:_}".replace("_", " "),
    ]:
        assert word in PAGE


@pytest.mark.parametrize("path", [None, 3, [], ""])
def test_a_database_has_a_name(path: Any) -> None:
    with pytest.raises(ParameterError, match="was given; it must be the name of a file"):
        open_database(path)
