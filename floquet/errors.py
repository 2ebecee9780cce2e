"""Exceptions and warnings, in one tree.

::

    FloquetError
    ├── InputError (also a ValueError)   the caller can mend it; the command line exits with 2
    │   ├── ParameterError               a model, rotor or option value          .name .value
    │   ├── ConfigError                  a rotor or study file                   .path .problems
    │   ├── QueryError                   a query expression                      .expression .column
    │   └── DatabaseError                missing, foreign, cut short or too new  .path
    │       └── DamageError              stored data do not match their digests  .path .places
    └── FailedError                      the world failed; the command line exits with 1
        └── StorageError                 disk full, no permission                .path
    FloquetWarning (a UserWarning)       legitimate, but probably not what was meant

Every message is one sentence or two: what was given, the rule, the likely cause, the way out.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

__all__ = [
    "FloquetError",
    "InputError",
    "ParameterError",
    "ConfigError",
    "Problem",
    "QueryError",
    "DatabaseError",
    "DamageError",
    "FailedError",
    "StorageError",
    "FloquetWarning",
    "did_you_mean",
    "file_name",
]


def _rebuilt(kind: type[FloquetError], args: tuple[Any, ...], state: dict[str, Any]) -> FloquetError:
    """An exception as it was, without calling its ``__init__``: what pickle and copy use."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class FloquetError(Exception):
    """Anything this package raises on purpose; pickled or copied it keeps type, message and attributes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.args, dict(self.__dict__))


class InputError(FloquetError, ValueError):
    """What was given cannot be used as it stands."""


class ParameterError(InputError):
    """A parameter or option has a value outside its rule."""

    def __init__(self, name: str, value: Any, sentence: str) -> None:
        super().__init__(f"{name}: {sentence}")
        self.name, self.value, self.sentence = name, value, sentence


class Problem(NamedTuple):
    """One thing wrong with a file: line (1-based, 0 = unknown), dotted key, sentence."""

    line: int
    key: str
    sentence: str


class ConfigError(InputError):
    """A rotor or study file that does not follow its format; all problems at once."""

    def __init__(self, path: str | Path, problems: Sequence[Problem]) -> None:
        self.path, self.problems = str(path), tuple(problems)
        super().__init__("\n".join(self._line(p) for p in self.problems))

    def _line(self, p: Problem) -> str:
        where = f"{self.path}:{p.line}" if p.line else self.path
        return f"{where}: {p.key}: {p.sentence}" if p.key else f"{where}: {p.sentence}"


class QueryError(InputError):
    """A query expression that is not in the language; ``column`` is 1-based, 0 = unknown."""

    def __init__(self, sentence: str, expression: str = "", column: int = 0) -> None:
        super().__init__(f"query, column {column}: {sentence}" if column else f"query: {sentence}")
        self.expression, self.column = expression, column


class DatabaseError(InputError):
    """A file that is not a readable floquet database."""

    def __init__(self, path: str | Path, sentence: str) -> None:
        super().__init__(f"{path}: {sentence}")
        self.path = str(path)


class DamageError(DatabaseError):
    """Stored data no longer match their digests, or cannot be read; ``places`` names the chunks."""

    def __init__(self, path: str | Path, places: Sequence[str] = ("the whole file",), sentence: str = "") -> None:
        shown = ", ".join(places[:3]) + (f" and {len(places) - 3} more" if len(places) > 3 else "")
        digests = f"the stored data do not match their digests ({shown}); the file was changed or the disk is failing"
        super().__init__(path, f"{sentence or digests}: restore a copy or run the study again")
        self.places, self.sentence = tuple(places), sentence


class FailedError(FloquetError):
    """The input was right and the work still failed."""


class StorageError(FailedError):
    """A file could not be written; nothing saved earlier is lost."""

    def __init__(self, path: str | Path, sentence: str) -> None:
        super().__init__(f"{path}: {sentence}")
        self.path, self.sentence = str(path), sentence


class FloquetWarning(UserWarning):
    """A result that is right for what was asked, where something else was probably meant."""


def file_name(path: Any) -> Path:
    """The path of a file that was named."""
    if not isinstance(path, str | os.PathLike) or not os.fspath(path):
        given = "an empty name" if path == "" else repr(path)
        raise ParameterError("file", path, f"{given} was given; it must be the name of a file, a text or a path")
    return Path(path)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """``", did you mean 'x'?"`` for the nearest known word, or the empty string."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.6)
    return f", did you mean {near[0]!r}?" if near else ""
