"""Ways out of a database: CSV, Parquet, netCDF, streamed chunk by chunk.

CSV and Parquet have a column ``rotor_name`` beside ``rotor``, empty where rotors have no names.  A netCDF file is an
HDF5 file of the database's own kind with the variables of one table at its root; names are flag meanings of ``rotor``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from . import store
from .errors import InputError, did_you_mean

__all__ = ["export"]


def export(path: str | Path, out: str | Path, table: str = "points") -> Path:
    """Write a table as .csv, .parquet or .nc (by the ending of ``out``), flags as their words in CSV."""
    out = Path(out)
    kinds = {".csv": _to_csv, ".parquet": _to_parquet, ".nc": _to_netcdf}
    if out.suffix not in kinds:
        raise InputError(
            f"{out}: {out.suffix or 'no ending'} is no format of export{did_you_mean(out.suffix, kinds)}; "
            "end the name in .csv, .parquet or .nc"
        )
    with store.open_file(path) as file:
        file.rows(table)  # an unknown table is refused before anything is written
        kinds[out.suffix](file, table, out)
    return out


def _named(file: store.File, table: str) -> Iterator[dict[str, NDArray[Any] | list[str]]]:
    """The stored variables chunk by chunk, with the rotors' names after their numbers."""
    columns = list(store.stored_variables(file.columns(table)))
    for _, rows in file.chunks(table, columns):
        names = [file.names[i] if 0 <= i < len(file.names) else "" for i in rows["rotor"].tolist()]
        yield {"rotor": rows.pop("rotor"), "rotor_name": names, **rows}


def _to_csv(file: store.File, table: str, out: Path) -> None:
    import csv

    columns = store.stored_variables(file.columns(table))
    with store.atomic(out) as temporary, temporary.open("w", newline="", encoding="utf-8") as target:
        writer = csv.writer(target)
        writer.writerow(["rotor", "rotor_name", *(n for n in columns if n != "rotor")])
        for rows in _named(file, table):
            writer.writerows(zip(*(_words(v, columns.get(n)) for n, v in rows.items()), strict=True))


def _words(values: NDArray[Any] | list[str], column: store.Column | None) -> list[Any]:
    """Values as they stand in a text: flags as words."""
    plain: list[Any] = values if isinstance(values, list) else values.tolist()
    return [column.flags.get(v, v) for v in plain] if column and column.flags else plain


def _to_parquet(file: store.File, table: str, out: Path) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError("export to Parquet needs pyarrow: install floquet-rotor[export]") from None
    fields = [(n, pa.from_numpy_dtype(c.dtype)) for n, c in store.stored_variables(file.columns(table)).items()]
    schema = pa.schema([fields[0], ("rotor_name", pa.string()), *fields[1:]])
    with store.atomic(out) as temporary, pq.ParquetWriter(temporary, schema) as writer:
        for rows in _named(file, table):
            writer.write_table(pa.table(rows, schema=schema))


def _to_netcdf(file: store.File, table: str, out: Path) -> None:
    attributes = {k: v for k, v in file.attributes.items() if k != "attributes_digest"}
    columns = {table: file.columns(table)}
    with store.create(out, {table: file.rows(table)}, attributes, columns=columns, root=table) as writers:
        store.copy_rows(file, writers[table])
