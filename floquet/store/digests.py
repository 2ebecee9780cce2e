"""What a database's digests cover beside the chunks: the ranges and digests of a table, the schema and attributes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

__all__ = ["attributes_digest", "integrity_digest", "plain"]


def integrity_digest(
    variables: Iterable[str], digests: NDArray[np.uint8], minima: NDArray[np.float64], maxima: NDArray[np.float64]
) -> str:
    """Over what stands under /integrity for a table: the names of its variables, their digests and ranges."""
    total = hashlib.blake2b("\n".join(variables).encode(), digest_size=16)
    for part, dtype in ((digests, "u1"), (minima, "<f8"), (maxima, "<f8")):
        total.update(np.ascontiguousarray(part, dtype).tobytes())
    return total.hexdigest()


def attributes_digest(file: h5py.File) -> str:
    """Over the root's attributes and every variable's type, size and attributes."""

    def attributes(item: Any) -> list[tuple[str, Any]]:
        return sorted((k, plain(v)) for k, v in item.attrs.items() if k not in (*OF_LIBRARIES, "attributes_digest"))

    described: list[Any] = attributes(file)

    def visit(name: str, item: Any) -> None:
        if str(plain(item.attrs.get("NAME", ""))).startswith(NO_VARIABLE):
            return
        shape = [list(item.shape), item.dtype.str] if isinstance(item, h5py.Dataset) else []
        described.append([name, shape, attributes(item)])

    file.visititems(visit)
    return hashlib.blake2b(json.dumps(described, default=str).encode(), digest_size=16).hexdigest()


OF_LIBRARIES = (
    "DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME",  # HDF5's dimension scales
    "_NCProperties", "_Netcdf4Dimid", "_Netcdf4Coordinates",  # netCDF, where one of its programs has copied the file
)  # fmt: skip
"""Attributes that libraries write for themselves."""
NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"  # such as nccopy gives to what had no dimension


def plain(value: Any) -> Any:
    """An attribute as Python has it; netCDF's programs make an array of one of what was a single value."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.reshape(-1)[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
