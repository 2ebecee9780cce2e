"""Reading databases: every chunk is held against its digest when it is read, /integrity when the file is opened."""

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

from ..chunks import Packed, digest, in_order
from ..errors import DamageError, DatabaseError, file_name
from . import schema
from .digests import attributes_digest, integrity_digest, plain
from .schema import SCHEMA, TABLES, Column, stored_variables

__all__ = ["File", "data_digest", "open_file", "verify"]

Array = NDArray[Any]
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
    """

    def __init__(self, path: str | Path) -> None:
        self._file = _opened(path)
        self.path = str(path)
        try:
            with _reading(self.path):
                self.attributes: dict[str, Any] = {k: plain(v) for k, v in self._file.attrs.items()}
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
            variables = {name: i for i, name in enumerate(str(plain(group.attrs["variables"])).split("\n"))}
            digests, minima, maxima = (group[name][()] for name in ("digests", "minima", "maxima"))
            sound = plain(group.attrs["digest"]) == integrity_digest(variables, digests, minima, maxima)
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise DamageError(self.path, [place]) from error
        if not sound:
            raise DamageError(self.path, [place])
        count = max(1, math.ceil(self._rows[table] / schema.CHUNK_ROWS))
        sizes_agree = digests.shape == (len(variables), count, 16) and minima.shape == maxima.shape == digests.shape[:2]
        if not sizes_agree or int(group.attrs["chunk_rows"]) != schema.CHUNK_ROWS:
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
        for first in range(start // schema.CHUNK_ROWS * schema.CHUNK_ROWS, stop, schema.CHUNK_ROWS):
            chunk = first // schema.CHUNK_ROWS
            if skip is not None and minima is not None and maxima is not None:
                low, high = ({n: float(r[i, chunk]) for n, i in variables.items()} for r in (minima, maxima))
                if skip(low, high):
                    continue
            cut = slice(max(start, first) - first, min(stop, first + schema.CHUNK_ROWS) - first)
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
        first = chunk * schema.CHUNK_ROWS
        try:
            part: Array = self._file[table][name][first : first + schema.CHUNK_ROWS]
        except (OSError, RuntimeError, ValueError, KeyError) as error:
            raise DamageError(self.path, [self._place(table, name, chunk)]) from error
        if digest(part) != digests[index[name], chunk].tobytes():
            raise DamageError(self.path, [self._place(table, name, chunk)])
        return part

    def _place(self, table: str, name: str, chunk: int) -> str:
        first = chunk * schema.CHUNK_ROWS
        return f"{table}/{name} rows {first}…{min(first + schema.CHUNK_ROWS, self.rows(table)) - 1}"

    # -------------------------------------------------- chunks as they are stored
    def stored(self, table: str) -> NDArray[np.uint8] | None:
        """Digests of the chunks as they are stored; None if there are none, or other filters than ours made them."""
        known = self._known(table)
        try:
            group = self._file[f"integrity/{table}"]
            digests = group["stored"][()]
            sound = plain(group.attrs["stored_digest"]) == digest(digests).hex() and len(digests) == len(known)
            chunk = (min(self.rows(table), schema.CHUNK_ROWS),)
            ours = all(_filters(d) == FILTERS and d.chunks == chunk for d in map(self._file[table].get, known))
        except (OSError, RuntimeError, ValueError, KeyError, TypeError, AttributeError):
            return None
        return digests if sound and ours else None

    def packed(self, table: str, variables: Iterable[str]) -> Iterator[tuple[tuple[str, int], Callable[[], Packed]]]:
        """((variable, first row), job) of every chunk of some variables; the job checks the chunk as it is stored."""
        stored = self.stored(table)
        if stored is None:
            raise DamageError(self.path, [f"integrity/{table}"])
        for chunk in range(math.ceil(self.rows(table) / schema.CHUNK_ROWS)):
            for name in variables:
                raw = self._raw(table, name, chunk)
                yield (name, chunk * schema.CHUNK_ROWS), partial(self._checked, table, name, chunk, raw, stored)

    def _raw(self, table: str, name: str, chunk: int) -> bytes:
        try:
            left_out, data = self._file[table][name].id.read_direct_chunk((chunk * schema.CHUNK_ROWS,))
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
            sound = self.attributes.get("attributes_digest") == attributes_digest(self._file)
        except (OSError, RuntimeError, ValueError, KeyError, TypeError):
            sound = False
        if not sound:
            yield "attributes and schema"
        for table in self.tables:
            columns = stored_variables(TABLES[table])
            for name in self._known(table):
                for chunk in range(math.ceil(self.rows(table) / schema.CHUNK_ROWS)):
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
