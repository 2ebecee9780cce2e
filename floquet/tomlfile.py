"""TOML files read into pydantic models: every problem at once, each with its line and the way out.

``read_toml(path, model)`` reads a file, ``parse_toml(text, path, model)`` a text that came from one; both return an
instance of the model or raise a ConfigError with all problems.  ``read_document`` and ``parse_document`` stop one step
earlier, for callers with rules of their own: a Document has the plain data, the line of every key and the problems
that a model finds.

A model derives from ``Table``, which forbids unknown keys, strings for numbers, and nan or infinity.  Lists are
``list[...]`` in a model: TOML has no tuples.

The lines come from a scanner of its own, because tomllib gives none.  It runs after tomllib has accepted the text, so
it may trust the grammar: a text is headers ``[a.b]`` and ``[[a.b]]``, and statements ``key = value``; a value is a
list, an inline table, or anything else up to the next comma, bracket or line.  TOML: https://toml.io/en/v1.0.0.
"""

from __future__ import annotations

import math
import os
import re
import reprlib
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date, time
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import pydantic
from pydantic_core import ErrorDetails

from floquet.errors import ConfigError, Problem, did_you_mean, file_name

__all__ = ["Document", "Table", "parse_document", "parse_toml", "read_document", "read_toml"]

Key: TypeAlias = "tuple[str | int, ...]"
_Model = TypeVar("_Model", bound=pydantic.BaseModel)


class Table(pydantic.BaseModel):
    """A table of a file: unknown keys, strings for numbers, nan and infinity are problems."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


@dataclass(frozen=True)
class Document:
    """A parsed file: its data as tomllib gives them and the 1-based line of every key, list items by number."""

    path: str
    data: dict[str, Any]
    lines: Mapping[Key, int]

    def line(self, *key: str | int) -> int:
        """The line of a key, of the nearest table above it if it is not there, 0 if there is none."""
        return next((self.lines[key[:n]] for n in range(len(key), 0, -1) if key[:n] in self.lines), 0)

    def problem(self, sentence: str, *key: str | int) -> Problem:
        """A problem with a key, at its line."""
        return Problem(self.line(*key), _dotted(key), sentence)

    def problems(self, model: type[pydantic.BaseModel]) -> list[Problem]:
        """All that a model finds wrong with the data; nothing if they fit."""
        try:
            model.model_validate(self.data)
        except pydantic.ValidationError as error:
            return _problems(self, model, error)
        return []

    def validate(self, model: type[_Model]) -> _Model:
        """The data as an instance of a model, or a ConfigError with all problems."""
        try:
            return model.model_validate(self.data)
        except pydantic.ValidationError as error:
            raise ConfigError(self.path, _problems(self, model, error)) from None


def read_toml(path: str | os.PathLike[str], model: type[_Model]) -> _Model:
    """A file as an instance of a model, or a ConfigError with all problems."""
    return read_document(path).validate(model)


def parse_toml(text: str, path: str | os.PathLike[str], model: type[_Model]) -> _Model:
    """A text as an instance of a model; ``path`` only names it in the problems."""
    return parse_document(text, path).validate(model)


def read_document(path: str | os.PathLike[str]) -> Document:
    """A file as a Document."""
    file_name(path)
    try:
        raw = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise ConfigError(os.fspath(path), [Problem(0, "", _unreadable(Path(path), error))]) from None
    try:
        return parse_document(raw.decode("utf-8-sig"), path)
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        if raw.startswith(b"\x89HDF"):
            problem = Problem(0, "", "this is an HDF5 file, such as a database is, and a rotor or a study is TOML")
            raise ConfigError(os.fspath(path), [problem]) from None
        sentence = f"byte {raw[error.start]:#04x} is not UTF-8, which TOML must be; save the file again as UTF-8"
        raise ConfigError(os.fspath(path), [Problem(line, "", sentence)]) from None


def parse_document(text: str, path: str | os.PathLike[str]) -> Document:
    """A text as a Document; ``path`` only names it in the problems."""
    if line := _long_key(text):
        sentence = f"this key has more than {MOST_DOTS} dots; no file of this package needs more than three"
        raise ConfigError(os.fspath(path), [Problem(line, "", sentence)])
    try:
        data = tomllib.loads(text)
        return Document(os.fspath(path), data, _Scanner(text).lines)
    except RecursionError:
        problem = Problem(0, "", "lists or tables are nested too deeply; no file of this package needs more than four")
    except ValueError as error:
        problem = _syntax(text, str(error))
    raise ConfigError(os.fspath(path), [problem])


MOST_DOTS = 60  # in a key: the time that the standard library takes for it grows with the square


def _long_key(text: str) -> int:
    """The line of the first key with too many dots, or 0; ``text`` may be anything."""
    dots = 0
    for token, line in _tokens(text):
        dots = dots + 1 if token == "." else 0 if token in "\n=[]{},#" else dots
        if dots > MOST_DOTS:
            return line
    return 0


def _unreadable(path: Path, error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        near = _neighbour(path)
        return f"there is no such file{near or '; check the path, which is relative to where the command runs'}"
    if isinstance(error, IsADirectoryError) or path.is_dir():
        return "this is a directory; name a TOML file in it"
    return f"the file cannot be read ({getattr(error, 'strerror', None) or error}); check its name and permissions"


def _neighbour(path: Path) -> str:
    try:
        return did_you_mean(path.name, sorted(p.name for p in path.parent.glob("*.toml")))
    except OSError:
        return ""


def _syntax(text: str, message: str) -> Problem:
    """tomllib says ``(at line 3, column 5)`` or ``(at end of document)`` last."""
    what, _, where = message.partition(" (at ")
    place = re.match(r"line (\d+), column (\d+)", where)
    line = int(place[1]) if place else text.rstrip().count("\n") + 1 if where else 0
    column = f", column {place[2]}" if place else ""
    what = what[:1].lower() + what[1:].partition(";")[0].rstrip(".")
    hint = next((h for word, h in _HINTS.items() if word in what), "check the brackets and quotes there")
    return Problem(line, "", f"this is not TOML{column}: {what}; {hint}")


_HINTS = {
    "invalid value": "texts need quotes, and numbers a digit on both sides of the point",
    "overwrite": "a key stands once in its table",
    "twice": "a table stands once in a file",
    "digits": "write a large number with a point or an exponent",
}


# Lines


_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}'  # texts of several lines, which may end in up to two quotes of their own
    r"|'''.*?'{3,5}"
    r"|\"{3}.*|'{3}.*"  # without an end: no TOML, and taken at once, lest each of many looks for its end in vain
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r'|"(?:\\.|[^"\\\n])*'  # the same
    r"|\#[^\n]*"
    r"|[\n\[\]{}=,.]"
    r"""|[^\s\[\]{}=,.\#"']+""",
    re.DOTALL,
)


class _Scanner:
    """Walks over a valid TOML text once and notes the line of every key."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Key, int] = {}
        self._counts: dict[Key, int] = {}  # items so far of each array of tables
        self._tokens = _tokens(text)
        self._next()
        base: Key = ()
        while self._token:
            if self._token == "\n":
                self._next()
            elif self._token == "[":
                base = self._header()
            else:
                self._pair(base)

    def _next(self) -> None:
        self._token, self._line = next(self._tokens, ("", 0))

    def _note(self, path: Key, line: int) -> None:
        self.lines[path] = line
        for n in range(1, len(path)):
            self.lines.setdefault(path[:n], line)

    def _header(self) -> Key:
        line = self._line
        self._next()
        many = self._token == "["
        if many:
            self._next()
        *above, name = self._key("]")
        path: Key = ()
        for part in above:
            path = self._inside((*path, part))
        path = (*path, name)
        if many:
            self.lines.setdefault(path, line)
            self._counts[path] = self._counts.get(path, 0) + 1
            path = self._inside(path)
            self._next()
        self._note(path, line)
        return path

    def _inside(self, path: Key) -> Key:
        """A table, or the last item of an array of tables."""
        return (*path, self._counts[path] - 1) if path in self._counts else path

    def _pair(self, base: Key) -> None:
        line = self._line
        path = (*base, *self._key("="))
        self._note(path, line)
        self._value(path)

    def _key(self, end: str) -> list[str]:
        """The parts of a dotted key up to a token, which is passed."""
        parts = []
        while self._token != end:
            if self._token != ".":
                quoted = self._token[0] in "\"'"
                parts.append(next(iter(tomllib.loads(f"{self._token} = 0"))) if quoted else self._token)
            self._next()
        self._next()
        return parts

    def _value(self, path: Key) -> None:
        if self._token not in ("[", "{"):
            while self._token not in (",", "]", "}", "\n", ""):
                self._next()
            return
        end, count = "]" if self._token == "[" else "}", 0
        self._next()
        while self._token != end:
            if self._token in (",", "\n"):
                self._next()
            elif end == "}":
                self._pair(path)
            else:
                self._note((*path, count), self._line)
                self._value((*path, count))
                count += 1
        self._next()


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    """(token, its line), without comments; a ``\\r`` is space to the pattern."""
    line, place = 1, 0
    for match in _TOKEN.finditer(text):
        line, place = line + text.count("\n", place, match.start()), match.start()
        if not match[0].startswith("#"):
            yield match[0], line


# Sentences

_KINDS = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "string_type": "a text in quotes",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "list_type": "a list in [ ]",
    "tuple_type": "a list in [ ]",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "finite_number": "a finite number",
}
_RULES = {
    "greater_than": "> {gt:g}",
    "greater_than_equal": ">= {ge:g}",
    "less_than": "< {lt:g}",
    "less_than_equal": "<= {le:g}",
    "literal_error": "{expected}",
    "enum": "{expected}",
    "too_short": "a list of at least {min_length}",
    "too_long": "a list of at most {max_length}",
    "string_too_short": "a text of at least {min_length} character(s)",
    "string_too_long": "a text of at most {max_length} characters",
}


def _problems(document: Document, model: type[pydantic.BaseModel], error: pydantic.ValidationError) -> list[Problem]:
    """pydantic's errors as Problems in the order of the file; the members of a union as one rule."""
    rules: dict[Key, list[str]] = {}
    given: dict[Key, Any] = {}
    found: list[Problem] = []
    for detail in error.errors(include_url=False):
        key = _real(document.data, detail)
        rule = _rule(detail)
        if rule:
            rules.setdefault(key, []).append(rule)
            given[key] = detail["input"]
        else:
            found.append(document.problem(_sentence(model, key, detail), *key))
    for key, alternatives in rules.items():
        rule = " or ".join(dict.fromkeys(alternatives))
        found.append(document.problem(_given(given[key], rule), *key))
    return sorted(dict.fromkeys(found), key=lambda problem: problem.line)


def _real(data: Any, detail: ErrorDetails) -> Key:
    """Where an error is, without the names of union members that pydantic puts between the keys."""
    key: list[str | int] = []
    *above, last = detail["loc"] or ("",)
    for part in above:
        if _has(data, part):
            key.append(part)
            data = data[part]
    if _has(data, last) or detail["type"] in ("missing", "extra_forbidden"):
        key.append(last)
    return tuple(key)


def _has(data: Any, part: str | int) -> bool:
    if isinstance(data, dict):
        return part in data
    return isinstance(data, list) and isinstance(part, int) and part < len(data)


def _rule(detail: ErrorDetails) -> str:
    """What a value must be, or the empty string if the error is not of that kind."""
    form = _RULES.get(detail["type"])
    return form.format(**detail.get("ctx", {})) if form else _KINDS.get(detail["type"], "")


def _sentence(model: type[pydantic.BaseModel], key: Key, detail: ErrorDetails) -> str:
    """Missing and unknown keys, rules a model wrote itself, and whatever pydantic says in its own words."""
    table = f"[{_dotted(key[:-1])}]" if key[:-1] else "the file"
    if detail["type"] == "missing":
        if _fields(model, key):
            return f"the table is missing; add [{_dotted(key)}] to the file"
        return f"the key is missing and has no default; add it to {table}"
    if detail["type"] == "extra_forbidden":
        known = _fields(model, key[:-1])
        near = did_you_mean(str(key[-1]), known)
        return f"unknown key{near or (f'; {table} takes ' + ', '.join(known) if known else '; leave it out')}"
    if detail["type"] in ("value_error", "assertion_error"):
        return str(detail.get("ctx", {}).get("error", detail["msg"]))
    return f"{_short(detail['input'])} was given; {detail['msg'][:1].lower()}{detail['msg'][1:]}"


def _given(value: Any, rule: str) -> str:
    """The sentence of a value that breaks a rule, with the likely cause where there is one."""
    hint = _hint(value, rule)
    return f"{_short(value)} was given; it must be {rule}{hint if hint[:1] in ('', ',') else f': {hint}'}"


def _hint(value: Any, rule: str) -> str:
    match value:
        case str() if "number" in rule and _is_number(value):
            return "leave out the quotes"
        case str() if "'" in rule:
            return did_you_mean(value, re.findall(r"'([^']*)'", rule))
        case list() if rule == "a table":
            return "write its header in single brackets"
        case list() if "list" not in rule:
            return "write one value without brackets"
        case float() if not math.isfinite(value):
            return "look for a missing value or a division by zero where it was computed"
        case float() if rule == "a whole number" and value.is_integer():
            return f"write {int(value)}"
        case int() if rule == "a number" and not isinstance(value, bool):
            return "it is too large for a floating-point number"
    return ""


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _fields(model: type[pydantic.BaseModel], key: Key) -> list[str]:
    """The keys that the table at a place takes, by the model's annotations; none for a free table."""
    models: list[type[pydantic.BaseModel]] = [model]
    for part in key:
        if isinstance(part, str):
            here = [m.model_fields[part].annotation for m in models if part in m.model_fields]
            models = [found for annotation in here for found in _models(annotation)]
    return [field.alias or name for m in models for name, field in m.model_fields.items()]


def _models(annotation: Any) -> Iterator[type[pydantic.BaseModel]]:
    """The models in an annotation such as ``Axes | None`` or ``list[Axis]``."""
    if isinstance(annotation, type) and issubclass(annotation, pydantic.BaseModel):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _models(inner)


def _short(value: Any) -> str:
    """A value as it stands in a file, shortened."""
    if isinstance(value, dict | list):
        return f"{'a' if value else 'an empty'} {'table' if isinstance(value, dict) else 'list'}"
    if isinstance(value, bool):
        return str(value).lower()
    return str(value) if isinstance(value, date | time) else reprlib.repr(value)


def _dotted(key: Key) -> str:
    """``rotors.list[0].name``"""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key).removeprefix(".")
