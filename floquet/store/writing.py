"""Writing databases: tables filled chunk after chunk, with the digests of what was written."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ..chunks import LEVEL, Packed, digest, in_order, pack
from ..errors import StorageError
from . import schema
from .digests import attributes_digest, integrity_digest
from .files import Sink, atomic
from .schema import ROW, SCHEMA, TABLES, Column, stored_variables
from .seal import add_seal, chunk_extents

if TYPE_CHECKING:
    from .reading import File

__all__ = ["TableWriter", "copy_rows", "create", "write"]

Array = NDArray[Any]
Rows = Mapping[str, Array]
Jobs = Iterator[tuple[tuple[str, int], Callable[[], Packed]]]  # ((variable, first row), its chunk)


def write(path: str | Path, tables: Mapping[str, Rows], attributes: Mapping[str, Any]) -> None:
    """Write whole tables (dicts of columns) to a new file, of points those columns that are there."""
    lengths = {name: len(next(iter(rows.values()))) for name, rows in tables.items()}
    with create(path, lengths, attributes, columns={name: tuple(rows) for name, rows in tables.items()}) as writers:
        for name, rows in tables.items():
            writers[name].add(rows)


@contextlib.contextmanager
def create(
    path: str | Path,
    lengths: Mapping[str, int],
    attributes: Mapping[str, Any],
    *,
    columns: Mapping[str, Collection[str]] | None = None,
    root: str = "",
    replace: bool = True,
) -> Iterator[dict[str, TableWriter]]:
    """A new file of tables with so many rows each, to be filled through writers in row order.

    ``columns`` says which columns a table has (left out: all), by their names or, for a table that is not of the
    schema, as a mapping of columns.  The variables of the table ``root`` stand at the root of the file, not in a group:
    so other programs expect them.  Without ``replace`` a file that is there when this one is whole is refused.
    """
    with atomic(path, replace=replace) as temporary, Sink(temporary) as sink:
        with h5py.File(sink, "w", libver=("v108", "v108"), track_order=True) as file:
            for name, value in attributes.items():
                file.attrs[name] = value
            file.attrs["Conventions"] = "CF-1.10"
            file.attrs["schema_version"] = "{}.{}".format(*SCHEMA)
            names = str(attributes.get("rotor_names", "[]"))
            writers = {}
            for table, rows in lengths.items():
                group = file if table == root else file.create_group(table, track_order=True)
                kept = (columns or {}).get(table) or TABLES[table]
                whole = kept if isinstance(kept, Mapping) else {n: c for n, c in TABLES[table].items() if n in kept}
                writers[table] = TableWriter(group, table, rows, whole, names, sink.check)
            yield writers
            for writer in writers.values():
                writer.finish()
            file.attrs["attributes_digest"] = attributes_digest(file)
            file.flush()
            chunks = [place for writer in writers.values() for place in chunk_extents(writer.datasets.values())]
        sink.check()
        add_seal(sink, chunks)


class TableWriter:
    """Fills one table, chunk after chunk, and keeps the digests."""

    def __init__(
        self,
        group: h5py.Group,
        table: str,
        rows: int,
        columns: Mapping[str, Column],
        rotor_names: str = "[]",
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.group, self.table, self.rows, self.check = group, table, rows, check
        self.columns = dict(columns)
        self.variables = stored_variables(self.columns)
        self.numbers = {name: i for i, name in enumerate(self.variables)}
        self.at = self.kept = 0  # rows that are written, rows that wait
        self.waiting: dict[str, list[Array]] = {name: [] for name in self.variables}
        count = max(1, math.ceil(rows / schema.CHUNK_ROWS))
        self.digests = np.zeros((2, len(self.variables), count, 16), np.uint8)  # of the numbers, of what is stored
        self.ranges = np.full((2, len(self.variables), count), np.nan)
        # a table without rows still has a chunk: h5py wants one of at least a row to compress
        self.chunk_rows = min(max(rows, 1), schema.CHUNK_ROWS)
        self.datasets = {"row": self._variable("row", ROW)}
        self.datasets["row"].make_scale("row")
        for name, column in self.variables.items():
            dataset = self.datasets[name] = self._variable(name, column)
            dataset.dims[0].attach_scale(self.datasets["row"])
            flags = dict(enumerate(json.loads(rotor_names))) if name == "rotor" else column.flags
            if flags:
                dataset.attrs["flag_values"] = np.array(list(flags), dataset.dtype)
                dataset.attrs["flag_meanings"] = " ".join(_word(w, i) for i, w in flags.items())

    def _variable(self, name: str, column: Column) -> h5py.Dataset:
        dataset = self.group.create_dataset(
            name, (self.rows,), f"<{column.dtype}", chunks=(self.chunk_rows,), maxshape=None if self.rows else (None,),
            compression="gzip", compression_opts=LEVEL, shuffle=True, fletcher32=True,
        )  # fmt: skip
        dataset.attrs["units"], dataset.attrs["long_name"] = column.units, column.long_name
        return dataset

    def add(self, rows: Rows) -> None:
        """Append rows; what fills chunks is written before this returns, a copy of the rest waits for more."""
        for name, column in self.columns.items():
            value = np.asarray(rows[name])
            parts = {f"{name}_re": value.real, f"{name}_im": value.imag} if column.dtype == "c16" else {name: value}
            for variable, part in parts.items():
                self.waiting[variable].append(part)
        self.kept = sum(map(len, next(iter(self.waiting.values()))))
        last = self.at + self.kept == self.rows
        self._flush(self.kept if last else self.kept // schema.CHUNK_ROWS * schema.CHUNK_ROWS)

    def _flush(self, count: int) -> None:
        """Write the first rows that wait."""
        self._write(self._chunks(count))
        rest = {name: _cut(pieces, count, self.kept) for name, pieces in self.waiting.items()}
        self.waiting = {name: [np.concatenate(pieces)] if pieces else [] for name, pieces in rest.items()}
        self.at, self.kept = self.at + count, self.kept - count

    def _chunks(self, count: int) -> Jobs:
        for start in range(0, count, schema.CHUNK_ROWS):
            stop = min(start + schema.CHUNK_ROWS, count)
            yield self._numbered(self.at + start, self.at + stop)
            for name, pieces in self.waiting.items():
                yield (name, self.at + start), self._packed(name, _cut(pieces, start, stop))

    def _numbered(self, first: int, last: int) -> tuple[tuple[str, int], Callable[[], Packed]]:
        """A chunk of the scale: the numbers of the rows."""
        return ("row", first), self._packed("row", [np.arange(first, last)])

    def _packed(self, name: str, pieces: Sequence[Array]) -> Callable[[], Packed]:
        return partial(pack, pieces, self.datasets[name].dtype.str, self.chunk_rows)

    def takes(self, source: File) -> bool:
        """Whether the chunks of a file can stand in this table as they are."""
        rows = source.rows(self.table)
        whole = not rows % schema.CHUNK_ROWS or self.at + rows == self.rows
        alike = (
            self.chunk_rows == min(rows, schema.CHUNK_ROWS) and self.columns.keys() <= source.columns(self.table).keys()
        )
        ours = source.sealed and source.stored(self.table) is not None
        return whole and alike and not self.kept and ours

    def take(self, source: File, rotor_offset: int = 0) -> None:
        """Append a file's rows chunk by chunk, each checked, but not packed again."""
        self._write(self._taken(source, rotor_offset))
        self.at += source.rows(self.table)

    def _taken(self, source: File, rotor_offset: int) -> Jobs:
        last = self.at + source.rows(self.table)
        for (name, start), job in source.packed(self.table, self.variables):
            first = self.at + start
            if name == "rotor":  # the first variable of every chunk
                yield self._numbered(first, min(first + schema.CHUNK_ROWS, last))
                if rotor_offset:
                    numbers = source.variable(self.table, name, start // schema.CHUNK_ROWS) + np.int32(rotor_offset)
                    job = self._packed(name, [numbers])
            yield (name, first), job

    def _write(self, jobs: Jobs) -> None:
        for (name, first), packed in in_order(jobs):
            self.datasets[name].id.write_direct_chunk((first,), packed.data)
            if name in self.numbers:
                i, chunk = self.numbers[name], first // schema.CHUNK_ROWS
                self.digests[:, i, chunk] = np.frombuffer(packed.digest + packed.stored, np.uint8).reshape(2, 16)
                self.ranges[:, i, chunk] = packed.low, packed.high
            self.check()

    def finish(self) -> None:
        """Write the digests."""
        if self.at + self.kept != self.rows:
            raise StorageError(
                self.group.file.filename, f"{self.at + self.kept} rows came for the table {self.table} of {self.rows}"
            )
        group = self.group.file.create_group(f"integrity/{self.table}", track_order=True)
        group.attrs["variables"] = "\n".join(self.variables)
        group.attrs["chunk_rows"] = schema.CHUNK_ROWS
        (digests, stored), (minima, maxima) = self.digests, self.ranges
        group.attrs["digest"] = integrity_digest(self.variables, digests, minima, maxima)
        group.attrs["stored_digest"] = digest(stored).hex()
        for name, data in (("digests", digests), ("stored", stored), ("minima", minima), ("maxima", maxima)):
            group.create_dataset(name, data=data, chunks=True, fletcher32=True)


def _cut(pieces: Sequence[Array], start: int, stop: int) -> list[Array]:
    """Views of the numbers start … stop of some arrays that follow one another."""
    out, first = [], 0
    for piece in pieces:
        part = piece[max(start - first, 0) : max(stop - first, 0)]
        out += [part] if len(part) else []
        first += len(piece)
    return out


def _word(text: str, value: int) -> str:
    """A CF flag meaning: one word."""
    return "_".join(text.split()) or f"rotor_{value}"


def copy_rows(source: File, writer: TableWriter, *, rotor_offset: int = 0) -> None:
    """Append a file's rows to a table, checking every chunk; rotors are numbered on from ``rotor_offset``.

    Chunks that stand in the same places in both are taken as they are, others are packed again.
    """
    if writer.takes(source):
        writer.take(source, rotor_offset)
        return
    for _, rows in source.chunks(writer.table, list(writer.columns)):
        rows["rotor"] = rows["rotor"] + np.int32(rotor_offset)
        writer.add(rows)
