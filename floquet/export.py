"""Ways out of a database: CSV, Parquet, netCDF, streamed chunk by chunk (netCDF by xarray)."""

from __future__ import annotations

from pathlib import Path

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
    with store.open_file(path) as file, store.atomic(out) as temporary:
        kinds[out.suffix](file, table, temporary)
    return out


def _to_csv(file: store.File, table: str, out: Path) -> None:
    import csv

    columns = store.stored_variables(file.columns(table))
    with out.open("w", newline="", encoding="utf-8") as target:
        writer = csv.writer(target)
        writer.writerow(columns)
        for _, rows in file.chunks(table, list(columns)):
            words = {
                n: [f.get(v, v) for v in rows[n].tolist()] if (f := c.flags) else rows[n].tolist()
                for n, c in columns.items()
            }
            writer.writerows(zip(*words.values(), strict=True))


def _to_parquet(file: store.File, table: str, out: Path) -> None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise InputError("export to Parquet needs pyarrow: install floquet-rotor[export]") from None
    columns = list(store.stored_variables(file.columns(table)))
    writer = None
    for _, rows in file.chunks(table, columns):
        batch = pa.table(rows)
        writer = writer or pq.ParquetWriter(out, batch.schema)
        writer.write_table(batch)
    if writer is not None:
        writer.close()


def _to_netcdf(file: store.File, table: str, out: Path) -> None:
    try:
        import xarray
    except ImportError:
        raise InputError("export to netCDF needs xarray and h5netcdf: install floquet-rotor[export]") from None
    with xarray.open_dataset(file.path, group=table, engine="h5netcdf") as data:
        data.assign_attrs({k: v for k, v in file.attributes.items() if isinstance(v, str | int | float)}).to_netcdf(
            out, engine="h5netcdf"
        )
