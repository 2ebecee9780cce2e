"""The database: an HDF5 schema, atomic files, digests.  The only home of h5py.

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

from . import schema as schema
from .files import atomic, remove_leftovers, write_failure
from .reading import NO_TABLES, File, data_digest, open_file, verify
from .schema import ALWAYS, EVERY, LIMITS, POINTS, SCHEMA, TABLES, Column, chosen, column_name, stored_variables
from .writing import TableWriter, copy_rows, create, write

__all__ = ["ALWAYS", "EVERY", "LIMITS", "NO_TABLES", "POINTS", "SCHEMA", "TABLES", "Column", "File", "TableWriter",
           "atomic", "chosen", "column_name", "copy_rows", "create", "data_digest", "open_file", "remove_leftovers",
           "schema", "stored_variables", "verify", "write", "write_failure"]  # fmt: skip
