"""The database: an HDF5 schema as one table, atomic files, digests.  The only home of h5py.

A database has two tables, each a group that xarray opens as a dataset::

    /points   one row a rotor and advance ratio        :data:`POINTS`
    /limits   one row a rotor, mode, metric, tolerance :data:`LIMITS`
    /integrity/<table>   digests (variables, chunks, 16), minima and maxima (variables, chunks), all under the
                         attribute digest

A complex column NAME is stored as the variables NAME_re and NAME_im.  Every variable is cut into chunks of
:data:`CHUNK_ROWS` rows, compressed, with HDF5's checksum; the blake2b digest of every chunk is checked whenever it is
read, that of /integrity when the file is opened, and one more covers the schema and the attributes.  Files appear whole
or not at all: they are written beside their place, synced, and renamed.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import hashlib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .comparison import Cause, Metric, Rule
from .errors import DamageError, DatabaseError, StorageError
from .exponents import Verdict
from .period_map import Method
from .rotor import PARAMETERS, Hub
from .sweep import INTERVALS, METRIC_COLUMNS, MODES

__all__ = ["CHUNK_ROWS", "LIMITS", "POINTS", "SCHEMA", "TABLES", "Column", "File", "TableWriter", "atomic", "create",
           "copy_rows", "data_digest", "open_file", "remove_leftovers", "stored_variables", "verify", "write",
           "write_failure"]  # fmt: skip

Rows = Mapping[str, NDArray[Any]]
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
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
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
    """Write whole tables (dicts of columns) to a new file."""
    lengths = {name: len(next(iter(rows.values()))) for name, rows in tables.items()}
    with create(path, lengths, attributes) as writers:
        for name, rows in tables.items():
            writers[name].add(rows)


@contextlib.contextmanager
def create(
    path: str | Path, lengths: Mapping[str, int], attributes: Mapping[str, Any], *, root: str = ""
) -> Iterator[dict[str, TableWriter]]:
    """A new file of tables with so many rows each, to be filled through writers in row order.

    The variables of the table ``root`` stand at the root of the file, not in a group: so other programs expect them.
    """
    with atomic(path) as temporary, _Sink(temporary) as sink:
        with h5py.File(sink, "w", libver=("v108", "v108"), track_order=True) as file:
            for name, value in attributes.items():
                file.attrs[name] = value
            file.attrs["Conventions"] = "CF-1.10"
            file.attrs["schema_version"] = "{}.{}".format(*SCHEMA)
            names = str(attributes.get("rotor_names", "[]"))
            writers = {
                table: TableWriter(file, table, rows, names, sink.check, at_root=table == root)
                for table, rows in lengths.items()
            }
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
        file: h5py.File,
        table: str,
        rows: int,
        rotor_names: str,
        check: Callable[[], None] = lambda: None,
        *,
        at_root: bool = False,
    ) -> None:
        self.check = check
        self.columns, self.rows, self.table, self.file = TABLES[table], rows, table, file
        self.variables = stored_variables(self.columns)
        self.at = 0
        self.waiting: dict[str, list[NDArray[Any]]] = {name: [] for name in self.variables}
        chunks = max(1, math.ceil(rows / CHUNK_ROWS))
        self.digests = np.zeros((len(self.variables), chunks, 16), np.uint8)
        self.ranges = np.full((2, len(self.variables), chunks), np.nan)
        self.group = file if at_root else file.create_group(table, track_order=True)
        scale = self._variable("row", "i8", "row number")
        scale.make_scale("row")
        for start in range(0, rows, CHUNK_ROWS):
            scale[start : start + CHUNK_ROWS] = np.arange(start, min(rows, start + CHUNK_ROWS))
        for name, column in self.variables.items():
            dataset = self._variable(name, column.dtype, column.long_name, column.units)
            dataset.dims[0].attach_scale(scale)
            flags = dict(enumerate(json.loads(rotor_names))) if name == "rotor" else column.flags
            if flags:
                dataset.attrs["flag_values"] = np.array(list(flags), dataset.dtype)
                dataset.attrs["flag_meanings"] = " ".join(_word(w, i) for i, w in flags.items())

    def _variable(self, name: str, dtype: str, long_name: str, units: str = "1") -> h5py.Dataset:
        # a table without rows still has a chunk: h5py wants one of at least a row to compress
        chunk = (min(max(self.rows, 1), CHUNK_ROWS),)
        dataset = self.group.create_dataset(
            name, (self.rows,), f"<{dtype}", chunks=chunk, maxshape=(None,) if not self.rows else None,
            compression="gzip", compression_opts=1, shuffle=True, fletcher32=True,
        )  # fmt: skip
        dataset.attrs["units"], dataset.attrs["long_name"] = units, long_name
        return dataset

    def add(self, rows: Rows) -> None:
        """Append rows; whole chunks are written, the rest waits for more."""
        for name, column in self.columns.items():
            value = np.asarray(rows[name])
            parts = {f"{name}_re": value.real, f"{name}_im": value.imag} if column.dtype == "c16" else {name: value}
            for variable, part in parts.items():
                self.waiting[variable].append(np.ascontiguousarray(part, f"<{self.variables[variable].dtype}"))
        while sum(map(len, self.waiting["rotor"])) >= CHUNK_ROWS:
            self._flush(CHUNK_ROWS)

    def _flush(self, count: int) -> None:
        chunk = self.at // CHUNK_ROWS
        for i, (name, waiting) in enumerate(self.waiting.items()):
            whole = np.concatenate(waiting)
            part, rest = whole[:count], whole[count:]
            self.group[name][self.at : self.at + count] = part
            self.digests[i, chunk] = np.frombuffer(_digest(part), np.uint8)
            if np.any(part == part):
                self.ranges[:, i, chunk] = np.nanmin(part), np.nanmax(part)
            self.waiting[name] = [rest]
        self.at += count
        self.check()

    def finish(self) -> None:
        """Write what waits, and the digests."""
        left = sum(map(len, self.waiting["rotor"]))
        if self.at + left != self.rows:
            raise StorageError(
                self.file.filename, f"{self.at + left} rows came for the table {self.table} of {self.rows}"
            )
        if left:
            self._flush(left)
        group = self.file.create_group(f"integrity/{self.table}", track_order=True)
        group.attrs["variables"] = "\n".join(self.variables)
        group.attrs["chunk_rows"] = CHUNK_ROWS
        group.attrs["digest"] = _integrity_digest(self.variables, self.digests, *self.ranges)
        for name, data in (("digests", self.digests), ("minima", self.ranges[0]), ("maxima", self.ranges[1])):
            group.create_dataset(name, data=data, chunks=True, fletcher32=True)


def _word(text: str, value: int) -> str:
    """A CF flag meaning: one word."""
    return "_".join(text.split()) or f"rotor_{value}"


def _digest(part: NDArray[Any]) -> bytes:
    return hashlib.blake2b(np.ascontiguousarray(part).tobytes(), digest_size=16).digest()


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
        self.path = str(path)
        self._file = _opened(path)
        try:
            with _reading(self.path):
                self.attributes: dict[str, Any] = {k: _plain(v) for k, v in self._file.attrs.items()}
                _check_schema(self.path, self.attributes)
                self.tables = tuple(t for t in TABLES if t in self._file)
                self.names: tuple[str, ...] = tuple(json.loads(self.attributes.get("rotor_names", "[]")))
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

    def rows(self, table: str) -> int:
        """Number of rows of a table."""
        self._known(table)
        with _reading(self.path):
            return int(self._file[table]["row"].shape[0])

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
        chunks = max(1, math.ceil(self._file[table]["row"].shape[0] / CHUNK_ROWS))
        sizes_agree = (
            digests.shape == (len(variables), chunks, 16) and minima.shape == maxima.shape == digests.shape[:2]
        )
        if not sizes_agree or int(group.attrs["chunk_rows"]) != CHUNK_ROWS:
            raise DatabaseError(
                self.path, f"the table {table} and its digests do not belong together: the file is damaged"
            )
        return variables, digests, minima, maxima

    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, dict[str, NDArray[Any]]]]:
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

    def _column(self, table: str, name: str, chunk: int) -> NDArray[Any]:
        known = self._known(table)
        if name in known:
            return self.variable(table, name, chunk)
        if f"{name}_re" in known:
            real, imaginary = (self.variable(table, f"{name}_{part}", chunk) for part in ("re", "im"))
            out = np.empty(real.shape, complex)
            out.real, out.imag = real, imaginary
            return out
        raise DatabaseError(self.path, f"the table {table} has no column {name!r}: it was written without it")

    def variable(self, table: str, name: str, chunk: int) -> NDArray[Any]:
        """One chunk of one variable, checked."""
        index, digests, _, _ = self._integrity[table]
        first = chunk * CHUNK_ROWS
        place = f"{table}/{name} rows {first}…{min(first + CHUNK_ROWS, self.rows(table)) - 1}"
        try:
            part: NDArray[Any] = self._file[table][name][first : first + CHUNK_ROWS]
        except (OSError, RuntimeError, ValueError, KeyError) as error:
            raise DamageError(self.path, [place]) from error
        if _digest(part) != digests[index[name], chunk].tobytes():
            raise DamageError(self.path, [place])
        return part

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
    path = Path(path)
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


def copy_rows(source: File, table: str, writer: TableWriter, *, rotor_offset: int = 0) -> None:
    """Append a file's rows to a table, checking every chunk; rotors are numbered on from ``rotor_offset``."""
    for _, rows in source.chunks(table, list(TABLES[table])):
        rows["rotor"] = rows["rotor"] + np.int32(rotor_offset)
        writer.add(rows)
