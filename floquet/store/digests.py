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
    described: list[Any] = sorted((k, plain(v)) for k, v in file.attrs.items() if k != "attributes_digest")

    def visit(name: str, item: Any) -> None:
        shape = [list(item.shape), item.dtype.str] if isinstance(item, h5py.Dataset) else []
        kept = sorted((k, plain(v)) for k, v in item.attrs.items() if k not in HDF5_ATTRIBUTES)
        described.append([name, shape, kept])

    file.visititems(visit)
    return hashlib.blake2b(json.dumps(described, default=str).encode(), digest_size=16).hexdigest()


HDF5_ATTRIBUTES = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")  # written by HDF5's dimension scales


def plain(value: Any) -> Any:
    """An attribute as Python has it."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
