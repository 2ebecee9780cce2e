"""Reading databases: every chunk is held against its digest when it is read, everything else when the file is opened.

A file whose seal holds has the metadata that were written.  One without a seal, of an earlier release or another
program, is examined by a child process before it is opened here.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ..chunks import Packed, digest, in_order, unpack
from ..errors import DamageError, DatabaseError, file_name
from . import schema
from .digests import attributes_digest, integrity_digest, plain
from .guard import ask
from .schema import SCHEMA, TABLES, Column, stored_variables
from .seal import SIGNATURE, Seal, chunk_extents

__all__ = ["File", "data_digest", "open_file", "verify"]

Array = NDArray[Any]
NO_TABLES = (
    "it has no table of a database: it may be one that was exported, which xarray opens; name the database itself"
)
MOST_ROWS = 1 << 24  # of a chunk of any file
Skip = Callable[[Mapping[str, float], Mapping[str, float]], bool]

#: The filters of every variable but their parameters, as HDF5 numbers them: shuffle, deflate, fletcher32.
FILTERS = (h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_FLETCHER32)


def _filters(dataset: h5py.Dataset) -> tuple[int, ...]:
    """The filters that chunks go through one after another; none if numbers of another size are shuffled."""
    made = dataset.id.get_create_plist()
    found = [made.get_filter(i) for i in range(made.get_nfilters())]
    shuffled = [values for kind, _, values, _ in found if kind == h5py.h5z.FILTER_SHUFFLE]
    return tuple(kind for kind, *_ in found) if shuffled == [(dataset.dtype.itemsize,)] else ()


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
    sealed : bool
        Whether the file has a seal, which then holds.
    """

    def __init__(self, path: str | Path, *, examined: bool = False) -> None:
        self.path = str(path)
        self._file, self.sealed = _opened(path, examined)
        try:
            with _reading(self.path):
                self.attributes: dict[str, Any] = {k: plain(v) for k, v in self._file.attrs.items()}
                _check_schema(self.path, self.attributes)
                self.tables = tuple(t for t in TABLES if t in self._file)
                self.names: tuple[str, ...] = tuple(json.loads(self.attributes.get("rotor_names", "[]")))
                self._rows = {t: int(self._file[t]["row"].shape[0]) for t in self.tables}
                self._name = h5py.h5f.get_name(self._file.id)
                self._chunk_rows: dict[str, int] = {}
                self._datasets: dict[tuple[str, str], h5py.Dataset] = {}
                self._integrity = {t: self._read_integrity(t) for t in self.tables}
                self._stored = {t: self.stored(t) for t in self.tables}
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

    def unknown(self, table: str) -> frozenset[str]:
        """Variables of this table that a later release has added."""
        return frozenset(self._known(table)) - frozenset(stored_variables(TABLES[table]))

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
            variables = {name: i for i, name in enumerate(str(plain(group.attrs["variables"])).split("\n"))}
            digests, minima, maxima = (group[name][()] for name in ("digests", "minima", "maxima"))
            sound = plain(group.attrs["digest"]) == integrity_digest(variables, digests, minima, maxima)
            self._chunk_rows[table] = chunk_rows = int(plain(group.attrs["chunk_rows"]))
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise DamageError(self.path, [place]) from error
        if not sound:
            raise DamageError(self.path, [place])
        count = max(1, math.ceil(self._rows[table] / chunk_rows)) if 0 < chunk_rows <= MOST_ROWS else 0
        sizes_agree = digests.shape == (len(variables), count, 16) and minima.shape == maxima.shape == digests.shape[:2]
        if not sizes_agree:
            sentence = f"the table {table} and its digests do not belong together, so this HDF5 file is damaged"
            raise DamageError(self.path, [table], sentence)
        return variables, digests, minima, maxima

    def chunks(
        self, table: str, columns: Sequence[str], start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, dict[str, Array]]]:
        """(first row, columns) of a table chunk by chunk, each checked against its digest.

        ``columns`` may be columns (complex ones whole) or stored variables.  ``skip(minima, maxima)`` leaves out a
        chunk by the ranges of its variables, nan apart.
        """
        for first, last in self.spans(table, start, stop, skip):
            chunk, begin = divmod(first, self._chunk_rows[table])
            cut = slice(begin, begin + last - first)
            yield first, {name: self._column(table, name, chunk)[cut] for name in columns}

    def spans(
        self, table: str, start: int = 0, stop: int | None = None, skip: Skip | None = None
    ) -> Iterator[tuple[int, int]]:
        """(first row, the row after the last) of the chunks that :meth:`chunks` reads."""
        variables, _, minima, maxima = self._integrity[table] if self._known(table) else ({}, None, None, None)
        total = self.rows(table)
        stop, step = total if stop is None else min(stop, total), self._chunk_rows[table]
        for first in range(start // step * step, stop, step):
            chunk = first // step
            if skip is not None and minima is not None and maxima is not None:
                low, high = ({n: float(r[i, chunk]) for n, i in variables.items()} for r in (minima, maxima))
                if skip(low, high):
                    continue
            yield max(start, first), min(stop, first + step)

    def _column(self, table: str, name: str, chunk: int) -> Array:
        known = self._known(table)
        if name in known:
            return self._numbers(table, name, chunk)
        if f"{name}_re" in known:
            real, imaginary = (self._numbers(table, f"{name}_{part}", chunk) for part in ("re", "im"))
            out = np.empty(real.shape, complex)
            out.real, out.imag = real, imaginary
            return out
        raise DatabaseError(self.path, f"the table {table} has no column {name!r}: it was written without it")

    def _numbers(self, table: str, name: str, chunk: int) -> Array:
        """One chunk of one variable, checked as it is stored where that is known: a third of the time, and no lock."""
        if (stored := self._stored[table]) is None:
            return self.variable(table, name, chunk)
        try:
            packed = self._checked(table, name, chunk, self._raw(table, name, chunk), stored)
        except DamageError:
            if self.sealed:
                raise
            return self.variable(table, name, chunk)  # another program has packed the same numbers in its way
        dataset, there = self._datasets[table, name], self.rows(table) - chunk * self._chunk_rows[table]
        try:
            return unpack(packed.data, dataset.dtype.str, dataset.chunks[0])[:there]
        except ValueError as error:
            raise DamageError(self.path, [self._place(table, name, chunk)]) from error

    def variable(self, table: str, name: str, chunk: int) -> Array:
        """One chunk of one variable, read by HDF5 and held against the digest of its numbers."""
        index, digests, _, _ = self._integrity[table]
        step = self._chunk_rows[table]
        try:
            part: Array = self._dataset(table, name)[chunk * step : (chunk + 1) * step]
        except (OSError, RuntimeError, ValueError, KeyError) as error:
            raise DamageError(self.path, [self._place(table, name, chunk)]) from error
        if digest(part) != digests[index[name], chunk].tobytes():
            raise DamageError(self.path, [self._place(table, name, chunk)])
        return part

    def _place(self, table: str, name: str, chunk: int) -> str:
        first = chunk * self._chunk_rows[table]
        return f"{table}/{name} rows {first}…{min(first + self._chunk_rows[table], self.rows(table)) - 1}"

    def _dataset(self, table: str, name: str) -> h5py.Dataset:
        """A variable, which must be stored in this file and nowhere else."""
        if (table, name) not in self._datasets:
            dataset = self._file[table][name]
            made = dataset.id.get_create_plist()
            elsewhere = made.get_layout() == h5py.h5d.VIRTUAL or made.get_external_count()
            if elsewhere or h5py.h5f.get_name(dataset.id) != self._name or dataset.shape != (self._rows[table],):
                raise ValueError(f"{table}/{name} is not stored here")
            self._datasets[table, name] = dataset
        return self._datasets[table, name]

    def examine(self, beat: Callable[[], None]) -> None:
        """Look at all metadata that reading goes by; raises DamageError where they are not sound."""
        if not self._described():
            raise DamageError(self.path, ["attributes and schema"])
        size = Path(self.path).stat().st_size
        for table in self.tables:
            for name in ("row", *self._known(table)):
                beat()
                try:
                    dataset = self._dataset(table, name)
                    places = chunk_extents([dataset]) if dataset.chunks else []
                except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError) as error:
                    raise DamageError(self.path, [f"{table}/{name}"]) from error
                most = 2 * dataset.dtype.itemsize * (dataset.chunks or (0,))[0] + 4096
                if any(first + length > size or length > most for first, length in places):
                    raise DamageError(self.path, [f"{table}/{name}"])

    # -------------------------------------------------- chunks as they are stored
    def stored(self, table: str) -> NDArray[np.uint8] | None:
        """Digests of the chunks as they are stored; None if there are none, or other filters than ours made them."""
        known = self._known(table)
        try:
            group = self._file[f"integrity/{table}"]
            digests = group["stored"][()]
            sound = plain(group.attrs["stored_digest"]) == digest(digests).hex() and len(digests) == len(known)
            chunk = (min(self.rows(table), schema.CHUNK_ROWS),)
            ours = self._chunk_rows[table] == schema.CHUNK_ROWS
            ours &= all(_filters(d) == FILTERS and d.chunks == chunk for d in map(self._file[table].get, known))
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
            return None
        return digests if sound and ours else None

    def packed(self, table: str, variables: Iterable[str]) -> Iterator[tuple[tuple[str, int], Callable[[], Packed]]]:
        """((variable, first row), job) of every chunk of some variables; the job checks the chunk as it is stored."""
        stored = self.stored(table)
        if stored is None:
            raise DamageError(self.path, [f"integrity/{table}"])
        for chunk in range(self._count(table)):
            for name in variables:
                raw = self._raw(table, name, chunk)
                yield (name, chunk * self._chunk_rows[table]), partial(self._checked, table, name, chunk, raw, stored)

    def _raw(self, table: str, name: str, chunk: int) -> bytes:
        try:
            left_out, data = self._dataset(table, name).id.read_direct_chunk((chunk * self._chunk_rows[table],))
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

    def _count(self, table: str) -> int:
        """Number of chunks."""
        return math.ceil(self.rows(table) / self._chunk_rows[table])

    def _described(self) -> bool:
        """Whether schema and attributes are those that were written."""
        try:
            return bool(self.attributes.get("attributes_digest") == attributes_digest(self._file))
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
            return False

    def values(self) -> int:
        """Number of values in all tables."""
        return sum(self.rows(table) * len(self._known(table)) for table in self.tables)

    def size(self, table: str) -> int:
        """Bytes that a table's chunks take on disk."""
        return sum(int(self._dataset(table, name).id.get_storage_size()) for name in ("row", *self._known(table)))

    def count(self) -> int:
        """Number of chunks in all tables."""
        return sum(self._count(table) * len(self._known(table)) for table in self.tables)

    def damaged(self, beat: Callable[[], None] = lambda: None) -> Iterator[str]:
        """Every place that does not match its digest, its type, its flags or the range of what it is.

        ``beat`` is called chunk by chunk.
        """
        if not self._described():
            yield "attributes and schema"
        for table in self.tables:
            columns = stored_variables(TABLES[table])
            yield from self._misnumbered(table, beat)
            for name in self._known(table):
                wrong = dict.fromkeys(self._wrong(table, name, columns.get(name), beat))
                yield from wrong

    def _wrong(self, table: str, name: str, column: Column | None, beat: Callable[[], None]) -> Iterator[str]:
        """Places of one variable."""
        for chunk in range(self._count(table)):
            beat()
            try:
                part = self.variable(table, name, chunk)
            except DamageError as error:
                yield error.places[0]
                continue
            if column is not None and (why := column.refuses(part)):
                yield f"{table}/{name} ({why})"

    def _misnumbered(self, table: str, beat: Callable[[], None]) -> Iterator[str]:
        """The scale, if it does not number the rows."""
        step = self._chunk_rows[table]
        try:
            rows = self._dataset(table, "row")
            for first in range(0, self.rows(table), step):
                beat()
                part = rows[first : first + step]
                if not np.array_equal(part, np.arange(first, first + len(part))):
                    raise ValueError
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
            yield f"{table}/row"

    def data_digest(self) -> str:
        """Digest of the tables' contents; equal data have equal digests, whenever they were written."""
        total = hashlib.blake2b(digest_size=16)
        for table in self.tables:
            variables, digests, _, _ = self._integrity[table]
            total.update(json.dumps([table, self.rows(table), list(variables)]).encode())
            total.update(digests.tobytes())
        return total.hexdigest()


def _opened(path: str | Path, examined: bool) -> tuple[h5py.File, bool]:
    """A file that HDF5 may look at, and whether it is sealed."""
    path = file_name(path)
    if not path.exists():
        if Path(f"{path}.parts").is_dir():
            raise DatabaseError(path, "its run is not finished: wait for it, or go on with floquet run and --resume")
        raise DatabaseError(path, "there is no such file: check the path, or make it with floquet run")
    if path.is_dir():
        raise DatabaseError(path, "this is a folder, not a database: name the file, such as results/validity.h5")
    if not path.is_file():
        raise DatabaseError(path, "this is a pipe or a device, not a file: write the database to a disk first")
    try:
        with path.open("rb") as file:
            signature, seal = file.read(8), Seal(file)
            broken = seal.remains or (seal.present and not seal.holds())
    except OSError as error:
        raise DatabaseError(path, f"cannot be read ({(error.strerror or str(error)).lower()})") from error
    if signature != SIGNATURE:
        raise DatabaseError(path, "this is not an HDF5 file: a floquet database is made with floquet run")
    if broken:
        raise DamageError(path, ["metadata"])
    if not seal.present and not examined:
        ask("floquet.store.examine", path)
    try:
        return h5py.File(path, "r"), seal.present
    except (OSError, RuntimeError) as error:
        raise DamageError(path, sentence="this HDF5 file is damaged or was cut short") from error


@contextlib.contextmanager
def _reading(path: str) -> Iterator[None]:
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        if isinstance(error, DatabaseError):
            raise
        raise DamageError(path, sentence="this HDF5 file is damaged") from error


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
