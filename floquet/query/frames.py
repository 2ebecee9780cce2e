"""Rows → pandas and xarray, with units and meanings; rows that form a grid get its axes.

The columns that may be axes are the design's parameters, the advance ratio, and in the table of limits mode, metric and
tolerance. Those that vary among the rows are the axes, if the rows are every combination of their values, once each::

    rows = Π sizes        index = ravel(place of each row's value on each axis), all different

``offset_mass_ratio`` is one only where the others do not determine it (left out, it is ε s). Rows of designs that are
no grid have the axes ``rotor`` and the others, if each rotor has the same; failing that, the one dimension ``row``. Of
several files that have the same grid, ``file`` is the first axis.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floquet.errors import InputError
from floquet.query.language import FILE, ROTOR, Array, Column, Rows
from floquet.query.meanings import meaning
from floquet.rotor import PARAMETERS

ROW = "row"
DERIVED = "offset_mass_ratio"
DESIGN = (*(p.name for p in PARAMETERS if p.name != DERIVED), "blades", "hub")
OTHERS = ("mode", "metric", "tolerance", "advance_ratio")


def library(name: str, method: str) -> Any:
    """pandas or xarray, loaded when it is first asked for."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(f"{method} needs {name}: install floquet-rotor[export]") from None


def axes_columns(present: Mapping[str, Column]) -> list[str]:
    """The columns that decide about axes."""
    return [name for name in (ROTOR, FILE, *DESIGN, DERIVED, *OTHERS) if name in present]


def axes(rows: Rows) -> tuple[str, ...]:
    """The axes of the grid that the rows form, () if they form none."""
    if not next(iter(rows.values()), np.empty(0)).size:
        return ()
    varying = [name for name, values in rows.items() if name != ROTOR and np.unique(values).size > 1]
    others = [name for name in varying if name in OTHERS]
    design = [name for name in varying if name in DESIGN]
    derived = [DERIVED] if DERIVED in varying else []
    files = [FILE] if FILE in varying else []
    for names in ([*files, *design], [*files, *design, *derived], design, [*design, *derived], [ROTOR]):
        chosen = tuple(name for name in (*names, *others) if name in rows)
        if chosen and is_grid(rows, chosen):
            return chosen
    return ()


def _places(rows: Rows, names: Sequence[str]) -> tuple[tuple[int, ...], Array]:
    """The sizes of the axes and where on the grid each row is, counted through."""
    places = [np.unique(rows[name], return_inverse=True)[1].reshape(-1) for name in names]
    shape = tuple(int(place.max()) + 1 for place in places)
    return shape, np.ravel_multi_index(places, shape) if math.prod(shape) == places[0].size else np.zeros(0, int)


def is_grid(rows: Rows, names: Sequence[str]) -> bool:
    """Whether rows are every combination of the values of some columns, once each."""
    shape, index = _places(rows, names)
    return index.size > 0 and np.unique(index).size == math.prod(shape)


def to_pandas(found: Rows, columns: Mapping[str, Column], attributes: Mapping[str, Any]) -> Any:
    """A DataFrame: flags as categories in words; ``attrs`` has the file's title and each column's units and meaning."""
    pandas = library("pandas", "to_pandas")
    frame = pandas.DataFrame({name: _worded(pandas, values, columns.get(name)) for name, values in found.items()})
    about = {name: _attrs(name, values, columns) for name, values in found.items()}
    frame.attrs = _about(attributes) | {
        key: {name: attrs[key] for name, attrs in about.items() if key in attrs} for key in ("units", "long_name")
    }
    return frame


def _worded(pandas: Any, values: Array, column: Column | None) -> Any:
    flags = column.flags if column else None
    return pandas.Categorical([flags.get(v) for v in values.tolist()], list(flags.values())) if flags else values


def to_xarray(found: Rows, wanted: Sequence[str], columns: Mapping[str, Column], attributes: Mapping[str, Any]) -> Any:
    """A Dataset over the grid that the rows form, or over ``row``; ``found`` has the columns of ``axes_columns``, too.

    Axes of words have the words as labels; other flags are numbers with CF's flag_values and flag_meanings.
    """
    xarray = library("xarray", "to_xarray")
    names = axes({name: found[name] for name in axes_columns(columns)})
    shape, index = _places(found, names) if names else (found[wanted[0]].shape, np.arange(found[wanted[0]].size))
    order = np.argsort(index)
    dims = names or (ROW,)
    coordinates = {}
    for name in names:
        labels, flags = np.unique(found[name]), columns[name].flags
        words = np.array([flags.get(v, str(v)) for v in labels.tolist()]) if flags else labels
        about = _attrs(name, labels, columns)
        coordinates[name] = (name, words, {key: about[key] for key in ("units", "long_name")})
    variables = {
        name: (dims, found[name][order].reshape(shape), _attrs(name, found[name], columns))
        for name in wanted
        if name not in names
    }
    return xarray.Dataset(variables, coordinates, _about(attributes))


def _about(attributes: Mapping[str, Any]) -> dict[str, Any]:
    return {name: attributes[name] for name in ("title", "history", "source", "study_id") if name in attributes}


def _attrs(name: str, values: Array, columns: Mapping[str, Column]) -> dict[str, Any]:
    """Units and long name, and of flags what CF says of them."""
    of = meaning(name, values.dtype, columns)
    attrs: dict[str, Any] = ({"units": of.units} if of.units else {}) | {"long_name": of.long_name}
    if not of.flags:
        return attrs
    words = " ".join("_".join(word.split()) for word in of.flags.values())
    return attrs | {"flag_values": np.array(list(of.flags), values.dtype), "flag_meanings": words}
