"""The database: an HDF5 schema as one table, atomic files, digests.  The only home of h5py.

A database has two tables, each a group that xarray opens as a dataset::

    /points   one row a rotor and advance ratio        :data:`POINTS`
    /limits   one row a rotor, mode, metric, tolerance :data:`LIMITS`
    /integrity/<table>   digests (variables, chunks, 16), minima and maxima (variables, chunks), all under the
                         attribute digest; stored (variables, chunks, 16), digests of the chunks as they are stored

A complex column NAME is stored as the variables NAME_re and NAME_im.  Of the points a study may store fewer columns,
those of :data:`ALWAYS` in any case.  Every variable is cut into chunks of :data:`CHUNK_ROWS` rows, compressed, with
HDF5's checksum (:mod:`floquet.chunks` makes them, on every core); the blake2b digest of every chunk is checked whenever
it is read, that of /integrity when the file is opened, and one more covers the schema and the attributes.  Files appear
whole or not at all: they are written beside their place, synced, and renamed.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import hashlib
import json
import math
import os
import secrets
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .chunks import LEVEL, Packed, digest, in_order, pack
from .comparison import Cause, Metric, Rule
from .errors import DamageError, DatabaseError, InputError, StorageError, did_you_mean, file_name
from .exponents import Verdict
from .period_map import Method
from .rotor import PARAMETERS, Hub
from .sweep import INTERVALS, METRIC_COLUMNS, MODES

__all__ = ["ALWAYS", "CHUNK_ROWS", "LIMITS", "POINTS", "SCHEMA", "TABLES", "Column", "File", "TableWriter", "atomic",
           "chosen", "column_name", "copy_rows", "create", "data_digest", "open_file", "remove_leftovers",
           "stored_variables", "verify", "write", "write_failure"]  # fmt: skip

Array = NDArray[Any]
Rows = Mapping[str, Array]
Jobs = Iterator[tuple[tuple[str, int], Callable[[], Packed]]]  # ((variable, first row), its chunk)
Skip = Callable[[Mapping[str, float], Mapping[str, float]], bool]

SCHEMA = (1, 0)  # major: older readers cannot read it; minor: columns were added
CHUNK_ROWS = 16384  # 128 kB a chunk of doubles
PER_REV = "per radian of azimuth, in units of the rotor speed (per rev)"


@dataclass(frozen=True)
class Column:
    """A column: NumPy type (f8, i4, i2, i1, c16), CF units, meaning, and the words of a flag."""

    dtype: str
    units: str
    long_name: str
    flags: Mapping[int, str] | None = None


def _flags(kind: type[IntEnum]) -> dict[int, str]:
    return {int(member): member.name for member in kind}


def _number(long_name: str, units: str = "1") -> Column:
    return Column("f8", units, long_name)


MODE_FLAGS = dict(enumerate(MODES))
_DESIGN = {"rotor": Column("i4", "1", "number of the rotor; names are in the attribute rotor_names")}
_PARAMETERS = {p.name: _number(p.description) for p in PARAMETERS} | {
    "blades": Column("i2", "1", "number of blades"),
    "hub": Column("i1", "1", "how the blades are held", _flags(Hub)),
    "flap_frequency": _number("rotating flap frequency nu_beta = sqrt(1 + kappa + m), structure only, per rev"),
}
_ERRORS = {
    Metric.RELATIVE: "distance of the two models' exponents over the exact ones' root mean square",
    Metric.ABSOLUTE: f"distance of the two models' exponents, {PER_REV}",
    Metric.FREQUENCY: "difference of frequency over the exact one",
    Metric.DAMPING: "difference of damping over the exact one",
}


def _mode_columns(mode: str) -> dict[str, Column]:
    pairs = {
        f"{part}_{mode}_{i}": Column("c16", "1", f"{mode} mode, {what} exponent {i}, {PER_REV}")
        for part, what in (("exact", "Floquet"), ("tpp", "tip-path-plane"))
        for i in (1, 2)
    }
    errors = {METRIC_COLUMNS[m].format(mode): _number(f"{mode} mode, {what}") for m, what in _ERRORS.items()}
    return {
        **pairs,
        **errors,
        f"rule_{mode}": Column("i1", "1", f"{mode} mode, what was compared", _flags(Rule)),
        f"cause_{mode}": Column("i1", "1", f"{mode} mode, how the two models differ in kind", _flags(Cause)),
    }


POINTS: dict[str, Column] = {
    **_DESIGN,
    "advance_ratio": _number("advance ratio V cos(alpha) / (Omega R)"),
    **_PARAMETERS,
    "exponent_1": Column("c16", "1", f"first Floquet exponent of the blade, {PER_REV}"),
    "exponent_2": Column("c16", "1", f"second Floquet exponent of the blade, {PER_REV}"),
    "exponent_error": _number(f"bound of the error of both exponents, {PER_REV}"),
    "rotation_number": _number(f"rotation number, the frequency on its branch, {PER_REV}"),
    "lock": _number("rotation number inside a lock, nan outside, per rev"),
    "verdict": Column("i1", "1", "stability of the blade", _flags(Verdict)),
    "determinant_defect": _number("distance of the period map's determinant from 1"),
    "method": Column("i1", "1", "how the exponents were found", _flags(Method)),
    "panels": Column("i4", "1", "panels a period"),
    **{name: column for mode in MODES for name, column in _mode_columns(mode).items()},
}
LIMITS: dict[str, Column] = {
    **_DESIGN,
    **_PARAMETERS,
    "mode": Column("i1", "1", "mode", MODE_FLAGS),
    "metric": Column("i1", "1", "how the error is measured", _flags(Metric)),
    "tolerance": _number("error at which the mode fails"),
    "limit": _number("first advance ratio at which the error passes the tolerance, inf: none up to mu_max"),
    "mu_max": _number("last advance ratio looked at"),
    "intervals": Column("i4", "1", f"number of intervals of failure (the first {INTERVALS} are columns)"),
    **{
        f"interval_{k}_{end}": _number(f"{end} of interval {k} of failure (an end at inf: still failing at mu_max)")
        for k in range(1, INTERVALS + 1)
        for end in ("start", "end")
    },
    "cause": Column("i1", "1", "how the two models differ in kind at the limit", _flags(Cause)),
    "rule": Column("i1", "1", "what the mode is compared with at the limit (MEAN is no exponent)", _flags(Rule)),
    "lock": _number("lock at the limit, nan outside, per rev"),
    "lock_edge": _number("advance ratio of the nearest lock edge"),
    "split_edge": _number("advance ratio of the nearest split of a tip-path-plane pair"),
}
TABLES: dict[str, dict[str, Column]] = {"points": POINTS, "limits": LIMITS}
ALWAYS = (*_DESIGN, "advance_ratio", *_PARAMETERS)  # every row says what it is of: plots, merges and readers need it
EVERY = "*"  # all columns, where columns are named


def column_name(name: str) -> str:
    """A name that may stand among the columns that a study stores."""
    if name == EVERY or name in POINTS:
        return name
    whole = name.rpartition("_")[0]
    if name in stored_variables(POINTS):
        raise InputError(f"{name} is a part of {whole}, which is stored as one: name {whole}")
    near = did_you_mean(name, POINTS) or ", whose columns floquet run stores without this setting"
    raise InputError(f"{name!r} is no column of the table of points{near}")


def chosen(names: Collection[str]) -> tuple[str, ...]:
    """The columns of points that are stored where these are named: they and those of ALWAYS, in the schema's order."""
    wanted = {column_name(name) for name in names}
    return tuple(name for name in POINTS if name in wanted or name in ALWAYS or EVERY in wanted)


def stored_variables(columns: Mapping[str, Column]) -> dict[str, Column]:
    """The columns as they are stored: complex ones in two parts."""
    out: dict[str, Column] = {}
    for name, c in columns.items():
        if c.dtype == "c16":
            parts = (("re", "real part"), ("im", "imaginary part"))
            out |= {f"{name}_{p}": Column("f8", c.units, f"{c.long_name}, {what}") for p, what in parts}
        else:
            out[name] = c
    return out


# ---------------------------------------------------------------------- files that appear whole or not at all
@contextlib.contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """A temporary file beside ``path`` that takes its place when the block ends well, and vanishes when it does not."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")  # others may be on other machines
    try:
        yield temporary
        _sync(temporary)
        os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        raise StorageError(path, write_failure(error)) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def remove_leftovers(folder: Path, name: str = "") -> None:
    """Remove temporary files that killed writers of ``name``, or of any file, have left in a folder."""
    for left in folder.glob(f".{glob.escape(name) or '*'}.*.tmp"):
        with contextlib.suppress(OSError):
            left.unlink()


def _sync(path: Path) -> None:
    with path.open("rb+") as file:  # Windows syncs only what may be written
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    """Make a rename durable, where folders can be synced."""
    with contextlib.suppress(OSError, AttributeError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def write_failure(error: OSError) -> str:
    """Why a file could not be written, in a sentence."""
    reasons = {
        errno.ENOSPC: "the disk is full: free some space",
        errno.EFBIG: "the file would pass the limit on file sizes: raise the limit or write elsewhere",
        errno.EDQUOT: "the disk quota is used up: free some space",
        errno.EACCES: "the folder may not be written to: choose another, or change its permissions",
        errno.EROFS: "the file system is read-only: write elsewhere",
        errno.ENOENT: "the folder does not exist: create it first",
        errno.ENOTDIR: "a part of the path is a file, not a folder: check the path",
        errno.EISDIR: "this is a folder: name a file",
    }
    why = reasons.get(error.errno or 0, f"{(error.strerror or str(error)).lower()}: check the disk")
    return f"could not be written, because {why}; what was saved before is untouched"


# ---------------------------------------------------------------------- writing
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
) -> Iterator[dict[str, TableWriter]]:
    """A new file of tables with so many rows each, to be filled through writers in row order.

    ``columns`` says which columns a table has (left out: all).  The variables of the table ``root`` stand at the root
    of the file, not in a group: so other programs expect them.
    """
    with atomic(path) as temporary, _Sink(temporary) as sink:
        with h5py.File(sink, "w", libver=("v108", "v108"), track_order=True) as file:
            for name, value in attributes.items():
                file.attrs[name] = value
            file.attrs["Conventions"] = "CF-1.10"
            file.attrs["schema_version"] = "{}.{}".format(*SCHEMA)
            names = str(attributes.get("rotor_names", "[]"))
            writers = {}
            for table, rows in lengths.items():
                group = file if table == root else file.create_group(table, track_order=True)
                kept = (columns or {}).get(table, TABLES[table])
                writers[table] = TableWriter(group, table, rows, kept, names, sink.check)
            yield writers
            for writer in writers.values():
                writer.finish()
            file.attrs["attributes_digest"] = _attributes_digest(file)


class _Sink:
    """A file for HDF5 to write to that never fails under its hands.

    HDF5 does not survive a full disk: a file that cannot be flushed at its close may crash the process.  Here the first
    error is kept, what follows is swallowed, and the error is raised when HDF5 is done.
    """

    def __init__(self, path: Path) -> None:
        self.file, self.position = path.open("w+b", buffering=0), 0
        self.error: OSError | None = None

    def __enter__(self) -> _Sink:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()
        self.check()

    def check(self) -> None:
        """Raise what went wrong."""
        if self.error is not None:
            raise self.error

    def write(self, data: Any) -> int:
        """Write all of ``data`` at the position."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            self.file.seek(self.position)
            while len(left):
                left = left[self.file.write(left) or 0 :]
        except OSError as error:
            self.error = self.error or error
        self.position += size
        return size

    def readinto(self, buffer: Any) -> int:
        """Fill ``buffer``, with zeros beyond what was written."""
        view = memoryview(buffer).cast("B")
        self.file.seek(self.position)
        count = self.file.readinto(view) or 0
        view[count:] = bytes(len(view) - count)
        self.position += len(view)
        return len(view)

    def read(self, size: int) -> bytes:
        """As :meth:`readinto`; h5py knows a file by this method."""
        buffer = bytearray(size)
        self.readinto(buffer)
        return bytes(buffer)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move; the end is the end of what was written."""
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self.position, os.SEEK_END: os.fstat(self.file.fileno()).st_size}[whence]
        self.position = base + offset
        return self.position

    def tell(self) -> int:
        """The position."""
        return self.position

    def truncate(self, size: int | None = None) -> int:
        """Set the size."""
        size = self.position if size is None else size
        try:
            self.file.truncate(size)
        except OSError as error:
            self.error = self.error or error
        return size

    def flush(self) -> None:
        """Nothing waits here."""


class TableWriter:
    """Fills one table, chunk after chunk, and keeps the digests."""

    def __init__(
        self,
        group: h5py.Group,
        table: str,
        rows: int,
        columns: Collection[str],
        rotor_names: str = "[]",
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.group, self.table, self.rows, self.check = group, table, rows, check
        self.columns = {name: column for name, column in TABLES[table].items() if name in columns}
        self.variables = stored_variables(self.columns)
        self.numbers = {name: i for i, name in enumerate(self.variables)}
        self.at = self.kept = 0  # rows that are written, rows that wait
        self.waiting: dict[str, list[Array]] = {name: [] for name in self.variables}
        count = max(1, math.ceil(rows / CHUNK_ROWS))
        self.digests = np.zeros((2, len(self.variables), count, 16), np.uint8)  # of the numbers, of what is stored
        self.ranges = np.full((2, len(self.variables), count), np.nan)
        # a table without rows still has a chunk: h5py wants one of at least a row to compress
        self.chunk_rows = min(max(rows, 1), CHUNK_ROWS)
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
        self.kept = sum(map(len, self.waiting["rotor"]))
        last = self.at + self.kept == self.rows
        self._flush(self.kept if last else self.kept // CHUNK_ROWS * CHUNK_ROWS)

    def _flush(self, count: int) -> None:
        """Write the first rows that wait."""
        self._write(self._chunks(count))
        rest = {name: _cut(pieces, count, self.kept) for name, pieces in self.waiting.items()}
        self.waiting = {name: [np.concatenate(pieces)] if pieces else [] for name, pieces in rest.items()}
        self.at, self.kept = self.at + count, self.kept - count

    def _chunks(self, count: int) -> Jobs:
        for start in range(0, count, CHUNK_ROWS):
            stop = min(start + CHUNK_ROWS, count)
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
        whole = not rows % CHUNK_ROWS or self.at + rows == self.rows
        alike = self.chunk_rows == min(rows, CHUNK_ROWS) and self.columns.keys() <= source.columns(self.table).keys()
        return whole and alike and not self.kept and source.stored(self.table) is not None

    def take(self, source: File, rotor_offset: int = 0) -> None:
        """Append a file's rows chunk by chunk, each checked, but not packed again."""
        self._write(self._taken(source, rotor_offset))
        self.at += source.rows(self.table)

    def _taken(self, source: File, rotor_offset: int) -> Jobs:
        last = self.at + source.rows(self.table)
        for (name, start), job in source.packed(self.table, self.variables):
            first = self.at + start
            if name == "rotor":  # the first variable of every chunk
                yield self._numbered(first, min(first + CHUNK_ROWS, last))
                if rotor_offset:
                    numbers = source.variable(self.table, name, start // CHUNK_ROWS) + np.int32(rotor_offset)
                    job = self._packed(name, [numbers])
            yield (name, first), job

    def _write(self, jobs: Jobs) -> None:
        for (name, first), packed in in_order(jobs):
            self.datasets[name].id.write_direct_chunk((first,), packed.data)
            if name in self.numbers:
                i, chunk = self.numbers[name], first // CHUNK_ROWS
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
        group.attrs["chunk_rows"] = CHUNK_ROWS
        (digests, stored), (minima, maxima) = self.digests, self.ranges
        group.attrs["digest"] = _integrity_digest(self.variables, digests, minima, maxima)
        group.attrs["stored_digest"] = digest(stored).hex()
        for name, data in (("digests", digests), ("stored", stored), ("minima", minima), ("maxima", maxima)):
            group.create_dataset(name, data=data, chunks=True, fletcher32=True)


ROW = Column("i8", "1", "row number")


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


def _integrity_digest(
    variables: Iterable[str], digests: NDArray[np.uint8], minima: NDArray[np.float64], maxima: NDArray[np.float64]
) -> str:
    """Over what stands under /integrity for a table: the names of its variables, their digests and ranges."""
    total = hashlib.blake2b("\n".join(variables).encode(), digest_size=16)
    for part, dtype in ((digests, "u1"), (minima, "<f8"), (maxima, "<f8")):
        total.update(np.ascontiguousarray(part, dtype).tobytes())
    return total.hexdigest()


def _attributes_digest(file: h5py.File) -> str:
    """Over the root's attributes and every variable's type, size and attributes."""
    described: list[Any] = sorted((k, _plain(v)) for k, v in file.attrs.items() if k != "attributes_digest")

    def visit(name: str, item: Any) -> None:
        shape = [list(item.shape), item.dtype.str] if isinstance(item, h5py.Dataset) else []
        kept = sorted((k, _plain(v)) for k, v in item.attrs.items() if k not in HDF5_ATTRIBUTES)
        described.append([name, shape, kept])

    file.visititems(visit)
    return hashlib.blake2b(json.dumps(described, default=str).encode(), digest_size=16).hexdigest()


#: The filters of every variable but their parameters, as HDF5 numbers them: shuffle, deflate, fletcher32.
FILTERS = (h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_FLETCHER32)


def _filters(dataset: h5py.Dataset) -> tuple[int, ...]:
    """The filters that chunks go through one after another; none if numbers of another size are shuffled."""
    made = dataset.id.get_create_plist()
    found = [made.get_filter(i) for i in range(made.get_nfilters())]
    shuffled = [values for kind, _, values, _ in found if kind == h5py.h5z.FILTER_SHUFFLE]
    return tuple(kind for kind, *_ in found) if shuffled == [(dataset.dtype.itemsize,)] else ()


HDF5_ATTRIBUTES = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")  # written by HDF5's dimension scales


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


# ---------------------------------------------------------------------- reading
def open_file(path: str | Path) -> File:
    """Open a database for reading; a context manager."""
    return File(path)


class File:
    """An open database.

    Attributes
    ----------
    path : str
    attributes : dict
        Of the root.
    tables : tuple of str
    names : tuple of str
        Of the rotors; empty if they have none.
    """

    def __init__(self, path: str | Path) -> None:
        self._file = _opened(path)
        self.path = str(path)
        try:
            with _reading(self.path):
                self.attributes: dict[str, Any] = {k: _plain(v) for k, v in self._file.attrs.items()}
                _check_schema(self.path, self.attributes)
                self.tables = tuple(t for t in TABLES if t in self._file)
                self.names: tuple[str, ...] = tuple(json.loads(self.attributes.get("rotor_names", "[]")))
                self._rows = {t: int(self._file[t]["row"].shape[0]) for t in self.tables}
                self._integrity = {t: self._read_integrity(t) for t in self.tables}
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> File:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        with contextlib.suppress(RuntimeError, OSError):
            self._file.close()

    def columns(self, table: str) -> dict[str, Column]:
        """The columns of a table that this file has."""
        known = self._known(table)
        return {n: c for n, c in TABLES[table].items() if n in known or f"{n}_re" in known}

    def left_out(self, table: str) -> frozenset[str]:
        """Columns, and parts of complex ones, that this table may have and does not."""
        columns = {n: c for n, c in TABLES[table].items() if n not in self.columns(table)}
        return frozenset(columns) | frozenset(stored_variables(columns))

    def rows(self, table: str) -> int:
        """Number of rows of a table."""
        self._known(table)
        return self._rows[table]

    def _known(self, table: str) -> dict[str, int]:
        if table not in self._integrity:
            raise DatabaseError(self.path, f"there is no table {table!r}: it has {', '.join(self.tables) or 'none'}")
        return self._integrity[table][0]

    def _read_integrity(
        self, table: str
    ) -> tuple[dict[str, int], NDArray[np.uint8], NDArray[np.float64], NDArray[np.float64]]:
        place = f"integrity/{table}"
        try:
            group = self._file[place]
            variables = {name: i for i, name in enumerate(str(_plain(group.attrs["variables"])).split("\n"))}
            digests, minima, maxima = (group[name][()] for name in ("digests", "minima", "maxima"))
            sound = _plain(group.attrs["digest"]) == _integrity_digest(variables, digests, minima, maxima)
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise DamageError(self.path, [place]) from error
        if not sound:
            raise DamageError(self.path, [place])
        count = max(1, math.ceil(self._rows[table] / CHUNK_ROWS))
        sizes_agree = digests.shape == (len(variables), count, 16) and minima.shape == maxima.shape == digests.shape[:2]
        if not sizes_agree or int(group.attrs["chunk_rows"]) != CHUNK_ROWS:
            raise DatabaseError(
                self.path, f"the table {table} and its digests do not belong together: the file is damaged"
            )
        return variables, digests, minima, maxima

    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, dict[str, Array]]]:
        """(first row, columns) of a table chunk by chunk, each checked against its digest.

        ``columns`` may be columns (complex ones whole) or stored variables.  ``skip(minima, maxima)`` leaves out a
        chunk by the ranges of its variables, nan apart.
        """
        variables, _, minima, maxima = self._integrity[table] if self._known(table) else ({}, None, None, None)
        total = self.rows(table)
        stop = total if stop is None else min(stop, total)
        for first in range(start // CHUNK_ROWS * CHUNK_ROWS, stop, CHUNK_ROWS):
            chunk = first // CHUNK_ROWS
            if skip is not None and minima is not None and maxima is not None:
                low, high = ({n: float(r[i, chunk]) for n, i in variables.items()} for r in (minima, maxima))
                if skip(low, high):
                    continue
            cut = slice(max(start, first) - first, min(stop, first + CHUNK_ROWS) - first)
            yield max(start, first), {name: self._column(table, name, chunk)[cut] for name in columns}

    def _column(self, table: str, name: str, chunk: int) -> Array:
        known = self._known(table)
        if name in known:
            return self.variable(table, name, chunk)
        if f"{name}_re" in known:
            real, imaginary = (self.variable(table, f"{name}_{part}", chunk) for part in ("re", "im"))
            out = np.empty(real.shape, complex)
            out.real, out.imag = real, imaginary
            return out
        raise DatabaseError(self.path, f"the table {table} has no column {name!r}: it was written without it")

    def variable(self, table: str, name: str, chunk: int) -> Array:
        """One chunk of one variable, checked."""
        index, digests, _, _ = self._integrity[table]
        first = chunk * CHUNK_ROWS
        try:
            part: Array = self._file[table][name][first : first + CHUNK_ROWS]
        except (OSError, RuntimeError, ValueError, KeyError) as error:
            raise DamageError(self.path, [self._place(table, name, chunk)]) from error
        if digest(part) != digests[index[name], chunk].tobytes():
            raise DamageError(self.path, [self._place(table, name, chunk)])
        return part

    def _place(self, table: str, name: str, chunk: int) -> str:
        first = chunk * CHUNK_ROWS
        return f"{table}/{name} rows {first}…{min(first + CHUNK_ROWS, self.rows(table)) - 1}"

    # -------------------------------------------------- chunks as they are stored
    def stored(self, table: str) -> NDArray[np.uint8] | None:
        """Digests of the chunks as they are stored; None if there are none, or other filters than ours made them."""
        known = self._known(table)
        try:
            group = self._file[f"integrity/{table}"]
            digests = group["stored"][()]
            sound = _plain(group.attrs["stored_digest"]) == digest(digests).hex() and len(digests) == len(known)
            chunk = (min(self.rows(table), CHUNK_ROWS),)
            ours = all(_filters(d) == FILTERS and d.chunks == chunk for d in map(self._file[table].get, known))
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
            return None
        return digests if sound and ours else None

    def packed(self, table: str, variables: Iterable[str]) -> Iterator[tuple[tuple[str, int], Callable[[], Packed]]]:
        """((variable, first row), job) of every chunk of some variables; the job checks the chunk as it is stored."""
        stored = self.stored(table)
        if stored is None:
            raise DamageError(self.path, [f"integrity/{table}"])
        for chunk in range(math.ceil(self.rows(table) / CHUNK_ROWS)):
            for name in variables:
                raw = self._raw(table, name, chunk)
                yield (name, chunk * CHUNK_ROWS), partial(self._checked, table, name, chunk, raw, stored)

    def _raw(self, table: str, name: str, chunk: int) -> bytes:
        try:
            left_out, data = self._file[table][name].id.read_direct_chunk((chunk * CHUNK_ROWS,))
        except (OSError, RuntimeError, ValueError, KeyError) as error:
            raise DamageError(self.path, [self._place(table, name, chunk)]) from error
        return b"" if left_out else bytes(data)  # some filter was not applied: no chunk of ours

    def _checked(self, table: str, name: str, chunk: int, raw: bytes, stored: NDArray[np.uint8]) -> Packed:
        index, digests, minima, maxima = self._integrity[table]
        at = index[name], chunk
        if (found := digest(raw)) != stored[at].tobytes():
            raise DamageError(self.path, [self._place(table, name, chunk)])
        return Packed(data=raw, stored=found, digest=digests[at].tobytes(), low=minima[at], high=maxima[at])

    def intact(self) -> bool:
        """Whether every chunk is stored as it was written, which takes a fifth of reading it."""
        try:
            return all(True for t in self.tables for _ in in_order(self.packed(t, self._known(t))))
        except DamageError:
            return False

    def damaged(self) -> Iterator[str]:
        """Every place that does not match its digest, its type or its flags."""
        try:
            sound = self.attributes.get("attributes_digest") == _attributes_digest(self._file)
        except (OSError, RuntimeError, ValueError, KeyError, TypeError):
            sound = False
        if not sound:
            yield "attributes and schema"
        for table in self.tables:
            columns = stored_variables(TABLES[table])
            for name in self._known(table):
                for chunk in range(math.ceil(self.rows(table) / CHUNK_ROWS)):
                    try:
                        part = self.variable(table, name, chunk)
                    except DamageError as error:
                        yield error.places[0]
                        continue
                    flags = columns[name].flags if name in columns else None
                    if flags and not np.all(np.isin(part, list(flags))):
                        yield f"{table}/{name} (a value that is no flag)"

    def data_digest(self) -> str:
        """Digest of the tables' contents; equal data have equal digests, whenever they were written."""
        total = hashlib.blake2b(digest_size=16)
        for table in self.tables:
            variables, digests, _, _ = self._integrity[table]
            total.update(json.dumps([table, self.rows(table), list(variables)]).encode())
            total.update(digests.tobytes())
        return total.hexdigest()


def _opened(path: str | Path) -> h5py.File:
    path = file_name(path)
    if not path.exists():
        raise DatabaseError(path, "there is no such file: check the path, or make it with floquet run")
    if path.is_dir():
        raise DatabaseError(path, "this is a folder, not a database: name the file, such as results/validity.h5")
    try:
        with path.open("rb") as file:
            signature = file.read(8)
    except OSError as error:
        raise DatabaseError(path, f"cannot be read ({(error.strerror or str(error)).lower()})") from error
    if signature != b"\x89HDF\r\n\x1a\n":
        raise DatabaseError(path, "this is not an HDF5 file: a floquet database is made with floquet run")
    try:
        return h5py.File(path, "r")
    except (OSError, RuntimeError) as error:
        raise DatabaseError(
            path, "this HDF5 file is damaged or was cut short: restore a copy or run the study again"
        ) from error


@contextlib.contextmanager
def _reading(path: str) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        if isinstance(error, DatabaseError):
            raise
        raise DatabaseError(path, "this HDF5 file is damaged: restore a copy or run the study again") from error


def _check_schema(path: str, attributes: Mapping[str, Any]) -> None:
    version = str(attributes.get("schema_version", ""))
    if "study_id" not in attributes or not version.replace(".", "", 1).isdigit():
        raise DatabaseError(path, "this HDF5 file was not made by floquet: a database is made with floquet run")
    if int(version.split(".")[0]) > SCHEMA[0]:
        ours = "{}.{}".format(*SCHEMA)
        raise DatabaseError(
            path, f"its schema is version {version}, and this release reads up to {ours}: install a newer floquet-rotor"
        )


def verify(path: str | Path) -> tuple[str, ...]:
    """Read everything; the places that are damaged."""
    try:
        with open_file(path) as file:
            return tuple(file.damaged())
    except DamageError as error:
        return error.places


def data_digest(path: str | Path) -> str:
    """Digest of a database's tables, see :meth:`File.data_digest`."""
    with open_file(path) as file:
        return file.data_digest()


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
