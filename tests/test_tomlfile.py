"""TOML files: the line of every key, and one sentence for each thing that can be wrong with a file."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import pydantic
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from floquet.errors import ConfigError, Problem
from floquet.tomlfile import Table, parse_document, parse_toml, read_document, read_toml


class Axis(Table):
    start: float = pydantic.Field(ge=0)
    stop: float = 1.0
    count: int = pydantic.Field(5, gt=1, lt=100)


class Study(Table):
    name: str = pydantic.Field(min_length=1)
    quick: bool = False
    metric: Literal["relative", "absolute"] = "relative"
    axis: Axis | list[float] = pydantic.Field(default_factory=list)
    tolerances: list[float] = pydantic.Field([0.05], min_length=1, max_length=3)
    axes: list[Axis] = pydantic.Field(default_factory=list)
    notes: dict[str, str] = pydantic.Field(default_factory=dict)

    @pydantic.model_validator(mode="after")
    def _together(self) -> Study:
        if self.quick and self.axes:
            raise ValueError("a quick study has no axes; leave out quick or axes")
        return self


class File(Table):
    study: Study


def problems(text: str) -> tuple[Problem, ...]:
    with pytest.raises(ConfigError) as caught:
        parse_toml(text, "study.toml", File)
    return caught.value.problems


TRICKY = r"""
# [not.a.table]
title = "a # b ] } \" = 'x'"   # a comment with [brackets] = 1
dotted.key."with = sign".'and . point' = [1, 2.5, [3, "]"],  # ]
  4]
date = 1979-05-27T07:32:00-08:00
"quoted" = 1
text = QQQ
[fake]
fake = 1 ""quoted"" \QQQ
QQQQQ
literal = '''
also_fake = 2'''
ends_in_quotes = [ QQQaQQQQ, "b" ]
inline = { a = 1, b = { c = [ { d = 1 }, { e = -inf } ] } }
[ table . inner ]
x = 0x1F
[[items]]
name = "one"
[items.sub]
y = 1
[[items.sub.deep]]
z = 1
[[items]]
name = "two"
[[items.parts]]
k = 1
[[items.parts]]
k = 2
[table]
last = true""".replace("Q", '"')


def keys(data: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    inside = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in inside:
        yield (*path, key)
        yield from keys(value, (*path, key))


def test_every_key_of_a_tricky_file_has_its_line_and_nothing_else_has_one() -> None:
    document = parse_document(TRICKY, "tricky.toml")
    assert set(document.lines) == set(keys(tomllib.loads(TRICKY)))
    lines = TRICKY.split("\n")
    for path, line in document.lines.items():
        if isinstance(path[-1], str):
            assert path[-1] in lines[line - 1], path
    assert document.line("items", 1, "parts", 1, "k") == document.line("items", 1, "parts", 0, "k") + 2
    assert document.line("items", 1, "nothing") == document.line("items", 1)
    assert document.line("nothing") == 0


NAME = st.text("ab.#=[]'\" ", min_size=1, max_size=4)
VALUE = st.recursive(
    st.integers() | st.booleans() | st.text("a#=[]{},\n\"'\\", max_size=6),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAME, inner, max_size=3),
    max_leaves=6,
)


def quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def written(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{quoted(k)} = {written(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", # ]\n".join(map(written, value)) + "]"
    return quoted(value) if isinstance(value, str) else str(value).lower()


@settings(max_examples=60, deadline=None)
@given(st.dictionaries(NAME, st.dictionaries(NAME, VALUE.map(lambda v: [v]), max_size=3), max_size=3))
def test_random_files_have_a_line_for_each_key(data: dict[str, Any]) -> None:
    text, expected = "", {}
    for table, pairs in data.items():
        text += f"[{quoted(table)}]\n"
        expected[table,] = text.count("\n")
        for key, value in pairs.items():
            expected[table, key] = text.count("\n") + 1
            text += f"{quoted(key)} = {written(value)}\n"
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:  # an inline table over several lines
        return
    lines = parse_document(text, "x").lines
    assert {path: lines[path] for path in expected} == expected
    assert set(lines) == set(keys(data))


def test_a_good_file_is_a_model(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_bytes('\ufeff[study]\r\nname = "é"\r\naxis = { start = 0 }\r\n'.encode())
    study = read_toml(path, File).study
    assert study.name == "é" and study.axis == Axis(start=0.0)
    assert not read_document(str(path)).problems(File)


CASES = [
    ("", 0, "study", "the table is missing; add [study] to the file"),
    ("study = 3", 1, "study", "3 was given; it must be a table"),
    ("[[study]]\nname='a'", 1, "study", "a list was given; it must be a table: write its header in single brackets"),
    ("[study]\n", 1, "study.name", "the key is missing and has no default; add it to [study]"),
    ("[study]\nname='a'\nquik=true", 3, "study.quik", "unknown key, did you mean 'quick'?"),
    ("[study]\nname='a'\n[[study.axes]]\nstart=0\nstp=1", 5, "study.axes[0].stp", "unknown key, did you mean 'stop'?"),
    ("[study]\nname='a'\naxis={start=0, zz=1}", 3, "study.axis.zz",
     "unknown key; [study.axis] takes start, stop, count"),
    ("zz=1\n[study]\nname='a'", 1, "zz", "unknown key; the file takes study"),
    ("[study]\nname=3", 2, "study.name", "3 was given; it must be a text in quotes"),
    ("[study]\nname=''", 2, "study.name", "'' was given; it must be a text of at least 1 character(s)"),
    ("[study]\nname='a'\nquick=1", 3, "study.quick", "1 was given; it must be true or false"),
    ("[study]\nname='a'\nmetric='relativ'", 3, "study.metric",
     "'relativ' was given; it must be 'relative' or 'absolute', did you mean 'relative'?"),
    ("[study]\nname='a'\nnotes=[1]", 3, "study.notes",
     "a list was given; it must be a table: write its header in single brackets"),
    ("[study]\nname='a'\ntolerances=[]", 3, "study.tolerances",
     "an empty list was given; it must be a list of at least 1"),
    ("[study]\nname='a'\ntolerances=[1,2,\n3,4]", 3, "study.tolerances",
     "a list was given; it must be a list of at most 3"),
    ("[study]\nname='a'\ntolerances=[1,\n'2']", 4, "study.tolerances[1]",
     "'2' was given; it must be a number: leave out the quotes"),
    ("[study]\nname='a'\ntolerances=[[1]]", 3, "study.tolerances[0]",
     "a list was given; it must be a number: write one value without brackets"),
    ("[study]\nname='a'\ntolerances=[true]", 3, "study.tolerances[0]", "true was given; it must be a number"),
    ("[study]\nname='a'\ntolerances=[2020-01-02]", 3, "study.tolerances[0]",
     "2020-01-02 was given; it must be a number"),
    ("[study]\nname='a'\ntolerances=[nan]", 3, "study.tolerances[0]",
     "nan was given; it must be a finite number: look for a missing value or a division by zero where it was computed"),
    (f"[study]\nname='a'\ntolerances=[1{'0' * 400}]", 3, "study.tolerances[0]",
     "100000000000000000...0000000000000000000 was given; it must be a number: "
     "it is too large for a floating-point number"),
    ("[study]\nname='a'\naxis='x'", 3, "study.axis", "'x' was given; it must be a table or a list in [ ]"),
    ("[study]\nname='a'\naxis={start=-1}", 3, "study.axis.start", "-1 was given; it must be >= 0"),
    ("[study]\nname='a'\n[[study.axes]]\nstart=0\ncount=1", 5, "study.axes[0].count", "1 was given; it must be > 1"),
    ("[study]\nname='a'\n[[study.axes]]\nstart=0\ncount=500", 5, "study.axes[0].count",
     "500 was given; it must be < 100"),
    ("[study]\nname='a'\n[[study.axes]]\nstart=0\ncount=8.0", 5, "study.axes[0].count",
     "8.0 was given; it must be a whole number: write 8"),
    ("[study]\nname='a'\nquick=true\naxes=[{start=0}]", 1, "study",
     "a quick study has no axes; leave out quick or axes"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "key", "sentence"), CASES, ids=lambda v: str(v)[:24])
def test_one_sentence_for_each_problem(text: str, line: int, key: str, sentence: str) -> None:
    found = [problem for problem in problems(text) if problem.key == key]
    assert found == [Problem(line, key, sentence)]


def test_all_problems_come_at_once_in_the_order_of_the_file() -> None:
    found = problems("[study]\nquick = 'yes'\nnam = 1\n[study.axis]\nstart = 'x'\n[extra]\n")
    where = [(p.line, p.key) for p in found]
    assert where == sorted(where, key=lambda place: place[0])
    assert {key for _, key in where} >= {"study.name", "study.quick", "study.nam", "study.axis.start", "extra"}


SYNTAX = [
    ("[study\n", 1, "expected ']'", "check the brackets and quotes there"),
    ("[study]\nname = \n", 2, "invalid value", "texts need quotes"),
    ("[study]\nx = .5\n", 2, "invalid value", "a digit on both sides of the point"),
    ("[study]\nname = 'a'\n\nname = 'b'\n", 4, "cannot overwrite", "a key stands once"),
    ("[study]\n[study]\n", 2, "twice", "a table stands once"),
    ("[study]\nname = '''a\n\n", 2, "", "check the brackets and quotes there"),
    (f"x = {'1' * 5000}", 0, "digits", "a point or an exponent"),
    (f"x = {'[' * 5000}", 0, "nested too deeply", ""),
]


@pytest.mark.parametrize(("text", "line", "what", "hint"), SYNTAX, ids=lambda v: str(v)[:12])
def test_a_text_that_is_not_toml_says_where(text: str, line: int, what: str, hint: str) -> None:
    (problem,) = problems(text)
    assert problem.line == line and problem.key == ""
    assert what in problem.sentence and hint in problem.sentence


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "rotor.toml").write_text("")
    (tmp_path / "latin.toml").write_bytes(b"# one\n# two\nname = '\xe9'\n")
    (tmp_path / "wide.toml").write_bytes("x = 1".encode("utf-16"))
    expected = {
        "rotr.toml": (0, "there is no such file, did you mean 'rotor.toml'?"),
        "other/deep/x.toml": (0, "there is no such file; check the path, which is relative to where the command runs"),
        ".": (0, "this is a directory; name a TOML file in it"),
        "latin.toml": (3, "byte 0xe9 is not UTF-8, which TOML must be; save the file again as UTF-8"),
        "wide.toml": (1, "byte 0xff is not UTF-8, which TOML must be; save the file again as UTF-8"),
        "nul\0": (0, "the file cannot be read (embedded null byte); check its name and permissions"),
        "rotor.toml/x": (0, "the file cannot be read (Not a directory); check its name and permissions"),
    }
    for name, (line, sentence) in expected.items():
        with pytest.raises(ConfigError) as caught:
            read_toml(tmp_path / name, File)
        assert caught.value.problems == (Problem(line, "", sentence),)
        assert str(tmp_path) in str(caught.value)


def test_the_message_has_path_line_and_key() -> None:
    with pytest.raises(ConfigError, match=r"^study\.toml:3: study\.quik: unknown key, did you mean 'quick'\?$"):
        parse_toml("[study]\nname = 'a'\nquik = true\n", "study.toml", File)


@pytest.mark.parametrize(
    "text", ["a." * 5000 + "a = 1", "[" + "a . " * 5000 + "a]", "x = { " + "'a'." * 90 + "b = 1 }"]
)
def test_keys_without_end_are_refused_with_their_line(text: str) -> None:
    with pytest.raises(ConfigError, match=r"x\.toml:2: this key has more than 60 dots"):
        parse_document("y = 1.5\n" + text, "x.toml")
    many = "[" + "1.5, " * 500 + "]"
    assert parse_document(f"y = {many}\nz = 'a{'.a' * 99}'", "x.toml").data["y"][3] == 1.5
