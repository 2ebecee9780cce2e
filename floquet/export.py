"""Ways out of a database: CSV, JSON, Parquet and netCDF, streamed piece by piece.

An :class:`Answer` is what goes out, a whole table or what a query found: columns, and their rows in pieces of any
length.  There is a writer for each ending::

    .csv       a header, a line a row; complex columns as NAME_re and NAME_im, flags as words, nan and inf as such
    .json      a list of objects; complex numbers are [re, im], flags words, nan is null, inf "inf"
    .parquet   complex columns as two, flags as dictionaries of words, units and meanings as metadata of the fields
    .nc        variables as in a database, at the root of the file; a rotor's name is a flag meaning of its number

CSV and JSON are the same on a screen and in a file.  Files appear whole or not at all.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import store
from .errors import DatabaseError, InputError, did_you_mean, file_name
from .plain import csv_lines, strict, words

__all__ = ["Answer", "checked_format", "export", "text", "whole", "write"]

Array = NDArray[Any]
ROTOR, ROTOR_NAME = "rotor", "rotor_name"
NAMES = store.Column("O", "", "name of the rotor")
TOGETHER = 65536
"""Rows of a row group of Parquet: pieces of a query may have one row each."""
PARTS = ("re", "im")


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Columns on their way out: what each is, and their rows in pieces, which come once.

    ``count()`` is the number of rows, which only netCDF asks for, before the first piece. ``names`` are the rotors',
    ``sources`` the files that are read, over which nothing is written.
    """

    columns: Mapping[str, store.Column]
    pieces: Iterable[Mapping[str, Array]]
    count: Callable[[], int]
    names: Sequence[str] = ()
    attributes: Mapping[str, Any]
    sources: Sequence[str] = ()


def export(path: str | Path, out: str | Path, table: str = "points") -> Path:
    """Write a whole table as .csv, .json, .parquet or .nc, by the ending of ``out``."""
    checked_format(out)
    with store.open_file(path) as file:
        file.rows(table)  # an unknown table is refused before anything is written
        if Path(out).suffix == ".nc":
            return _copied(file, table, _checked_place(out, [str(path)]))
        return write(whole(file, table), out)


def whole(file: store.File, table: str) -> Answer:
    """All rows and columns of a table, the rotors' names after their numbers."""
    stored = file.columns(table)
    columns = {ROTOR: stored[ROTOR], ROTOR_NAME: NAMES, **stored}
    names = np.array([*file.names, ""], dtype=object)

    def pieces() -> Iterator[dict[str, Array]]:
        for _, rows in file.chunks(table, list(stored)):
            rotor = rows[ROTOR]
            named = np.where((rotor >= 0) & (rotor < len(file.names)), rotor, len(file.names))
            yield {ROTOR: rotor, ROTOR_NAME: names[named], **rows}

    return Answer(
        columns=columns, pieces=pieces(), count=lambda: file.rows(table), names=file.names, attributes=file.attributes,
        sources=(file.path,),
    )  # fmt: skip


def _copied(file: store.File, table: str, out: Path) -> Path:
    """A whole table as netCDF: its chunks as they are stored."""
    attributes = {k: v for k, v in file.attributes.items() if k != "attributes_digest"}
    columns = {table: file.columns(table)}
    with store.create(out, {table: file.rows(table)}, attributes, columns=columns, root=table) as writers:
        store.copy_rows(file, writers[table])
    return out


def write(answer: Answer, out: str | Path) -> Path:
    """Write an answer in the format of the name's ending; the file appears whole or not at all."""
    kind = checked_format(out)
    path = _checked_place(out, answer.sources)
    _WRITERS[kind](answer, path)
    return path


def checked_format(out: str | Path) -> str:
    """The ending of a name, which is one that can be written."""
    kind = file_name(out).suffix
    if kind not in _WRITERS:
        raise InputError(
            f"{out}: {kind or 'no ending'} is no format of export{did_you_mean(kind, _WRITERS)}; "
            "end the name in .csv, .json, .parquet or .nc"
        )
    return kind


def _checked_place(out: str | Path, sources: Sequence[str]) -> Path:
    path = Path(out)
    store.remove_leftovers(path.parent, path.name)
    if path.exists() and any(path.samefile(source) for source in sources):
        raise InputError(f"{out} is the database that is read, and would be lost: name another file with -o")
    if path.is_file() and _is_database(path):
        raise InputError(f"{out} is a database itself, and would be lost: name another file, or move it away")
    return path


def _is_database(path: Path) -> bool:
    """Whether a file has tables, and is not one that was exported."""
    try:
        with store.open_file(path) as file:
            return bool(file.tables)
    except DatabaseError:
        return False


# ---------------------------------------------------------------------- text
def text(answer: Answer, style: str) -> Iterator[str]:
    """An answer as text, "csv" or "json", in blocks; the last one ends its line."""
    return {"csv": _csv_blocks, "json": _json_blocks}[style](answer)


def _csv_blocks(answer: Answer) -> Iterator[str]:
    columns = _parted(answer.columns)
    yield csv_lines([columns])
    for piece in answer.pieces:
        rows = _split(piece, answer.columns)
        yield csv_lines(zip(*(words(rows[name], column.flags) for name, column in columns.items()), strict=True))


def _json_blocks(answer: Answer) -> Iterator[str]:
    """What ``json.dumps`` gives with an indent of two, several times as fast: every record has the same keys."""
    keys = [_ENCODED(name).replace("%", "%%") for name in answer.columns]
    record = "  {\n" + ",\n".join(f"    {key}: %s" for key in keys) + "\n  }"
    yield "["
    before = "\n"
    for piece in answer.pieces:
        lists = [_json_values(piece[name], column) for name, column in answer.columns.items()]
        if records := ",\n".join(record % row for row in zip(*lists, strict=True)):
            yield before + records
            before = ",\n"
    yield "]\n" if before == "\n" else "\n]\n"


def _json_values(values: Array, column: store.Column) -> list[str]:
    if column.dtype == "c16":
        parts = (_json_values(part, NAMES) for part in (values.real, values.imag))
        return [f"[\n      {real},\n      {imaginary}\n    ]" for real, imaginary in zip(*parts, strict=True)]
    return [
        repr(value)
        if type(value) is int or (type(value) is float and math.isfinite(value))
        else _ENCODED(strict(value))
        for value in words(values, column.flags)
    ]


_ENCODED = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def _to_text(answer: Answer, out: Path) -> None:
    with store.atomic(out) as temporary, temporary.open("w", newline="", encoding="utf-8") as target:
        target.writelines(text(answer, out.suffix[1:]))


# ---------------------------------------------------------------------- binary
def _parted(columns: Mapping[str, store.Column]) -> dict[str, store.Column]:
    """Columns as files have them: complex ones in two."""
    return store.stored_variables(columns)


def _split(piece: Mapping[str, Array], columns: Mapping[str, store.Column]) -> dict[str, Array]:
    out: dict[str, Array] = {}
    for name, column in columns.items():
        values = piece[name]
        out |= {f"{name}_re": values.real, f"{name}_im": values.imag} if column.dtype == "c16" else {name: values}
    return out


def _to_parquet(answer: Answer, out: Path) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError("Parquet needs pyarrow: install floquet-rotor[export]") from None
    columns = _parted(answer.columns)
    about = {k: str(v) for k, v in answer.attributes.items() if k in ("title", "history", "source", "study_id")}
    schema = pa.schema(
        [pa.field(name, _arrow_type(pa, one), metadata=_about(one)) for name, one in columns.items()], metadata=about
    )
    with store.atomic(out) as temporary, pq.ParquetWriter(temporary, schema) as writer:
        waiting = []
        for piece in answer.pieces:
            rows = _split(piece, answer.columns)
            waiting.append(pa.table([_arrow(pa, rows[n], c) for n, c in columns.items()], schema=schema))
            if sum(len(table) for table in waiting) >= TOGETHER:
                writer.write_table(pa.concat_tables(waiting))
                waiting = []
        if waiting:
            writer.write_table(pa.concat_tables(waiting))


def _about(column: store.Column) -> dict[str, str]:
    return {"units": column.units, "long_name": column.long_name}


def _arrow_type(pa: Any, column: store.Column) -> Any:
    if column.dtype == "O":
        return pa.string()
    return pa.dictionary(pa.int32(), pa.string()) if column.flags else pa.from_numpy_dtype(np.dtype(column.dtype))


def _arrow(pa: Any, values: Array, column: store.Column) -> Any:
    """Flags as places in the list of their words; a number that is no flag is null."""
    if not column.flags:
        return pa.array(values.tolist(), pa.string()) if column.dtype == "O" else pa.array(values)
    places = {number: place for place, number in enumerate(column.flags)}
    listed = pa.array(list(column.flags.values()), pa.string())
    return pa.DictionaryArray.from_arrays(pa.array([places.get(v) for v in values.tolist()], pa.int32()), listed)


def _to_netcdf(answer: Answer, out: Path) -> None:
    """Names that stand without their numbers are numbered, each once."""
    columns = {
        name: column for name, column in answer.columns.items() if name != ROTOR_NAME or ROTOR not in answer.columns
    }
    numbers = {name: i for i, name in enumerate(dict.fromkeys([*answer.names, ""]))}
    texts = [name for name, column in columns.items() if column.dtype == "O"]
    for name in texts:
        flags = {i: rotor or "-" for rotor, i in numbers.items()}
        columns[name] = replace(columns[name], dtype="i4", units="1", flags=flags)
    kept = {
        k: v for k, v in answer.attributes.items() if k not in ("attributes_digest", "schema_version", "Conventions")
    }
    kept["rotor_names"] = json.dumps(list(answer.names), ensure_ascii=False)
    count = answer.count()
    with store.create(out, {"answer": count}, kept, columns={"answer": columns}, root="answer") as writers:
        for piece in answer.pieces:
            rows = {name: piece[name] for name in columns}
            for name in texts:
                rows[name] = np.array([numbers[rotor] for rotor in rows[name].tolist()], "i4")
            writers["answer"].add(rows)


_WRITERS: dict[str, Callable[[Answer, Path], None]] = {
    ".csv": _to_text,
    ".json": _to_text,
    ".parquet": _to_parquet,
    ".nc": _to_netcdf,
}
