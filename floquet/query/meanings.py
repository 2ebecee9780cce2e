"""What a column of an answer is: its type, units and meaning, and the words of its flags.

A column of the table is what the file says; a part of a complex one, a reduction of a group and the rotors' names are
what they are of.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from floquet.query.language import ROTOR_NAME, Column

PARTS = {"re": "real part", "im": "imaginary part"}
REDUCED = {
    "min": "least: ",
    "max": "greatest: ",
    "mean": "mean: ",
    "median": "median: ",
    "first": "of the first row: ",
    "count": "number of rows with a value: ",
}
_REDUCTION = re.compile(r"(?:(\w+) at )?(\w+)\((\w+)\)")


class Meaning(NamedTuple):
    """As ``floquet.store.Column``, in this order; units are empty where there are none."""

    dtype: str
    units: str
    long_name: str
    flags: Mapping[int, str] | None = None


def meaning(name: str, dtype: np.dtype[Any], columns: Mapping[str, Column]) -> Meaning:
    """What the column ``name`` of an answer is, of a table with these columns."""
    kind = dtype.str.lstrip("<|=")
    whole, _, part = name.rpartition("_")
    if name in columns:
        return Meaning(kind, columns[name].units, columns[name].long_name, columns[name].flags)
    if whole in columns and part in PARTS:
        return Meaning(kind, columns[whole].units, f"{columns[whole].long_name}, {PARTS[part]}")
    if name == ROTOR_NAME:
        return Meaning("O", "", "name of the rotor")
    if match := _REDUCTION.fullmatch(name):
        value, by, column = match.groups()
        of = meaning(value or column, dtype, columns)
        if value:
            return of._replace(long_name=f"{of.long_name}, where {column} is {REDUCED[by].removesuffix(': ')}")
        units, flags = ("1", None) if by == "count" else (of.units, of.flags if by == "first" else None)
        return Meaning(kind, units, REDUCED[by] + of.long_name, flags)
    return Meaning(kind, "1", "number of rows" if name == "count" else name)
