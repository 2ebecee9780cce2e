"""Several files as one: their rows after one another, with a column ``file`` and rotors numbered on.

File k begins at row Σ_{j<k} rows_j, and its rotor r is rotor r + Σ_{j<k} rotors_j; tables and columns are the same.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Protocol

import numpy as np

from floquet.errors import DatabaseError, ParameterError
from floquet.query.language import FILE, ROTOR, Column, Rows

Skip = Callable[[Mapping[str, Any], Mapping[str, Any]], bool]


class Reader(Protocol):
    """What a query needs of an open file; ``floquet.store.open_file`` gives it."""

    @property
    def names(self) -> Sequence[str]: ...
    @property
    def attributes(self) -> Mapping[str, Any]: ...
    @property
    def tables(self) -> Sequence[str]: ...
    def columns(self, table: str) -> Mapping[str, Any]: ...
    def left_out(self, table: str) -> Iterable[str]: ...
    def rows(self, table: str) -> int: ...
    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, Rows]]: ...
    def spans(
        self, table: str, start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, int]]: ...


@dataclass(frozen=True)
class FileColumn:
    """The column ``file``: a number with the file's name as its word."""

    flags: Mapping[int, str]
    dtype: str = "i4"
    units: str = "1"
    long_name: str = "file that the row is from"


class Several:
    """Open files as one reader."""

    def __init__(self, paths: Sequence[str], readers: Sequence[Reader]) -> None:
        for path, reader in zip(paths, readers, strict=True):
            _check_same(paths[0], readers[0], path, reader)
        self._readers = tuple(readers)
        self._file = FileColumn(dict(enumerate(paths)))
        counts = [_rotors(reader) for reader in readers]
        self._offsets = list(accumulate(counts, initial=0))
        padded = [(*r.names, *[""] * (n - len(r.names))) for r, n in zip(readers, counts, strict=True)]
        self.names = tuple(name for names in padded for name in names) if any(r.names for r in readers) else ()
        self.tables = tuple(readers[0].tables)

    @property
    def attributes(self) -> dict[str, Any]:
        """Those that all files share, and all titles."""
        first, *others = (reader.attributes for reader in self._readers)
        shared = {name: v for name, v in first.items() if all(_equal(v, other.get(name)) for other in others)}
        titles = dict.fromkeys(str(r.attributes["title"]) for r in self._readers if "title" in r.attributes)
        return shared | ({"title": "; ".join(titles)} if titles else {})

    def columns(self, table: str) -> dict[str, Column]:
        return {FILE: self._file, **self._readers[0].columns(table)}

    def left_out(self, table: str) -> Iterable[str]:
        return self._readers[0].left_out(table)

    def rows(self, table: str) -> int:
        return sum(reader.rows(table) for reader in self._readers)

    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, Rows]]:
        read = [name for name in columns if name != FILE] or list(self._readers[0].columns(table))[:1]
        for number, before, low, high in self._parts(table, start, stop):
            for first, chunk in self._readers[number].chunks(table, read, low, high, self._skip(number, skip)):
                yield before + first, self._numbered(number, chunk, columns)

    def spans(
        self, table: str, start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, int]]:
        for number, before, low, high in self._parts(table, start, stop):
            for first, last in self._readers[number].spans(table, low, high, self._skip(number, skip)):
                yield before + first, before + last

    def _parts(self, table: str, start: int, stop: int | None) -> Iterator[tuple[int, int, int, int]]:
        """Of every file that has some of the rows: its number, the rows before it, and its own from … to."""
        stop, before = self.rows(table) if stop is None else stop, 0
        for number, reader in enumerate(self._readers):
            rows = reader.rows(table)
            low, high = max(start - before, 0), min(stop - before, rows)
            if low < high:
                yield number, before, low, high
            before += rows

    def _skip(self, number: int, skip: Skip | None) -> Skip | None:
        """The question of a chunk of one file, in the numbers of all."""
        if skip is None:
            return None

        def moved(ends: Mapping[str, Any]) -> dict[str, Any]:
            rotor = {ROTOR: ends[ROTOR] + self._offsets[number]} if ROTOR in ends else {}
            return {**ends, **rotor, FILE: number}

        return lambda minima, maxima: skip(moved(minima), moved(maxima))

    def _numbered(self, number: int, chunk: Rows, columns: Sequence[str]) -> Rows:
        count = len(next(iter(chunk.values())))
        added = {FILE: np.full(count, number, dtype=self._file.dtype)}
        if ROTOR in chunk:
            added[ROTOR] = chunk[ROTOR] + chunk[ROTOR].dtype.type(self._offsets[number])
        return {name: added[name] if name in added else chunk[name] for name in columns}


def _equal(a: Any, b: Any) -> bool:
    return bool(np.array_equal(a, b))


def _rotors(reader: Reader) -> int:
    """How many rotors a file numbers: as many as have names or rows, by the stored ranges of its chunks."""
    count = len(reader.names)

    def look(_: Mapping[str, Any], maxima: Mapping[str, Any]) -> bool:
        nonlocal count
        largest = maxima.get(ROTOR, np.nan)
        count = max(count, int(largest) + 1) if largest == largest else count
        return True

    for table in reader.tables:
        if ROTOR in reader.columns(table):
            for _ in reader.chunks(table, [ROTOR], skip=look):
                pass
    return count


def _check_same(first_path: str, first: Reader, path: str, reader: Reader) -> None:
    if tuple(reader.tables) != tuple(first.tables):
        has, had = (" and ".join(one.tables) or "none" for one in (reader, first))
        raise DatabaseError(path, f"its tables are {has}, those of {first_path} {had}: ask them one by one")
    for table in first.tables:
        ours, theirs = (_schema(one.columns(table)) for one in (reader, first))
        if different := [name for name in {**theirs, **ours} if theirs.get(name) != ours.get(name)]:
            listed = ", ".join(different[:4]) + (f" and {len(different) - 4} more" if len(different) > 4 else "")
            raise DatabaseError(
                path, f"its table {table} and that of {first_path} have different columns ({listed}): files that are "
                "asked together store the same; ask them one by one, or floquet merge what they share"
            )  # fmt: skip


def _schema(columns: Mapping[str, Column]) -> dict[str, Any]:
    return {name: (np.dtype(c.dtype), c.units, dict(c.flags or {})) for name, c in columns.items()}


def check_once(paths: Sequence[str]) -> None:
    """No file may be given twice: its rows would stand twice."""
    places = [os.path.realpath(path) for path in paths]
    twice = next((path for i, path in enumerate(paths) if places[i] in places[:i]), None)
    if twice is not None:
        raise ParameterError("file", twice, f"{twice} is given twice, and its rows would stand twice; name it once")
