"""The schema: which columns the tables have, with units and meanings, and which of them a study stores.

A complex column NAME is stored as the variables NAME_re and NAME_im.  Of the points a study may store fewer columns,
those of :data:`ALWAYS` in any case.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..comparison import Cause, Metric, Rule
from ..errors import InputError, did_you_mean
from ..exponents import Verdict
from ..period_map import Method
from ..rotor import PARAMETERS, Hub, Parameter
from ..sweep import INTERVALS, METRIC_COLUMNS, MODES

__all__ = ["ALWAYS", "CHUNK_ROWS", "EVERY", "LIMITS", "POINTS", "ROW", "SCHEMA", "TABLES", "Column", "chosen",
           "column_name", "stored_variables"]  # fmt: skip

SCHEMA = (1, 1)  # major: older readers cannot read it; minor: columns were added
CHUNK_ROWS = 16384  # 128 kB a chunk of doubles
PER_REV = "per radian of azimuth, in units of the rotor speed (per rev)"


@dataclass(frozen=True)
class Column:
    """A column: NumPy type (f8, i4, i2, i1, c16), CF units, meaning, the words of a flag, and what numbers it may have.

    Numbers are at least ``least`` (above it, if ``exclusive``) and below ``below``, and finite; without any of these
    they may be anything.
    """

    dtype: str
    units: str
    long_name: str
    flags: Mapping[int, str] | None = None
    least: float | None = None
    exclusive: bool = False
    below: float = math.inf

    def refuses(self, values: NDArray[Any]) -> str:
        """Why some of these values cannot be right, or nothing."""
        if self.flags is not None:
            return "" if np.isin(values, list(self.flags)).all() else "a value that is no flag"
        if self.least is None:
            return ""
        above = values > self.least if self.exclusive else values >= self.least
        return "" if (above & (values < self.below)).all() else "a value that is not possible"


def _flags(kind: type[IntEnum]) -> dict[int, str]:
    return {int(member): member.name for member in kind}


def _number(long_name: str, units: str = "1") -> Column:
    return Column("f8", units, long_name)


def _parameter(p: Parameter) -> Column:
    """Finite, and in its range."""
    least = max(p.minimum, -float(np.finfo(float).max))
    return Column("f8", "1", p.description, None, least, p.exclusive, p.below)


MODE_FLAGS = dict(enumerate(MODES))
_DESIGN = {"rotor": Column("i4", "1", "number of the rotor; names are in the attribute rotor_names", None, 0)}
_PARAMETERS = {p.name: _parameter(p) for p in PARAMETERS} | {
    "blades": Column("i2", "1", "number of blades", None, 1),
    "hub": Column("i1", "1", "how the blades are held", _flags(Hub)),
    "flap_frequency": Column(
        "f8", "1", "rotating flap frequency nu_beta = sqrt(1 + kappa + m), structure only, per rev", None, 1.0
    ),
}
_ERRORS = {
    Metric.RELATIVE: "distance of the two models' exponents over the exact ones' root mean square",
    Metric.ABSOLUTE: f"distance of the two models' exponents, {PER_REV}",
    Metric.FREQUENCY: "difference of frequency over the exact one",
    Metric.DAMPING: "difference of damping over the exact one",
}


def _mode_columns(mode: str) -> dict[str, Column]:
    pairs = {
        f"{part}_{mode}_{i}": Column("c16", "1", f"{mode} mode, {what} exponent {i}, {PER_REV}")
        for part, what in (("exact", "Floquet"), ("tpp", "tip-path-plane"))
        for i in (1, 2)
    }
    errors = {METRIC_COLUMNS[m].format(mode): _number(f"{mode} mode, {what}") for m, what in _ERRORS.items()}
    return {
        **pairs,
        **errors,
        f"rule_{mode}": Column("i1", "1", f"{mode} mode, what was compared", _flags(Rule)),
        f"cause_{mode}": Column("i1", "1", f"{mode} mode, how the two models differ in kind", _flags(Cause)),
    }


POINTS: dict[str, Column] = {
    **_DESIGN,
    "advance_ratio": Column("f8", "1", "advance ratio V cos(alpha) / (Omega R)", None, 0.0),
    **_PARAMETERS,
    "exponent_1": Column("c16", "1", f"first Floquet exponent of the blade, {PER_REV}"),
    "exponent_2": Column("c16", "1", f"second Floquet exponent of the blade, {PER_REV}"),
    "exponent_error": _number(f"bound of the error of both exponents, {PER_REV}"),
    "rotation_number": _number(f"rotation number, the frequency on its branch, {PER_REV}"),
    "lock": _number("rotation number inside a lock, nan outside, per rev"),
    "verdict": Column("i1", "1", "stability of the blade", _flags(Verdict)),
    "determinant_defect": _number("distance of the period map's determinant from 1"),
    "method": Column("i1", "1", "how the exponents were found", _flags(Method)),
    "panels": Column("i4", "1", "panels a period"),
    **{name: column for mode in MODES for name, column in _mode_columns(mode).items()},
}
LIMITS: dict[str, Column] = {
    **_DESIGN,
    **_PARAMETERS,
    "mode": Column("i1", "1", "mode", MODE_FLAGS),
    "metric": Column("i1", "1", "how the error is measured", _flags(Metric)),
    "tolerance": Column("f8", "1", "error at which the mode fails", None, 0.0, True),
    "limit": _number("first advance ratio at which the error passes the tolerance, inf: none up to mu_max"),
    "mu_max": Column("f8", "1", "last advance ratio looked at", None, 0.0, True),
    "intervals": Column("i4", "1", f"number of intervals of failure (the first {INTERVALS} are columns)"),
    **{
        f"interval_{k}_{end}": _number(f"{end} of interval {k} of failure (an end at inf: still failing at mu_max)")
        for k in range(1, INTERVALS + 1)
        for end in ("start", "end")
    },
    "cause": Column("i1", "1", "how the two models differ in kind at the limit", _flags(Cause)),
    "rule": Column("i1", "1", "what the mode is compared with at the limit (MEAN is no exponent)", _flags(Rule)),
    "lock": _number("lock at the limit, nan outside, per rev"),
    "lock_edge": _number("advance ratio of the nearest lock edge"),
    "split_edge": _number("advance ratio of the nearest split of a tip-path-plane pair"),
}
TABLES: dict[str, dict[str, Column]] = {"points": POINTS, "limits": LIMITS}
ALWAYS = (*_DESIGN, "advance_ratio", *_PARAMETERS)  # every row says what it is of: plots, merges and readers need it
ROW = Column("i8", "1", "row number")  # the scale that every variable has
EVERY = "*"  # all columns, where columns are named


def column_name(name: str) -> str:
    """A name that may stand among the columns that a study stores."""
    if name == EVERY or name in POINTS:
        return name
    whole = name.rpartition("_")[0]
    if name in stored_variables(POINTS):
        raise InputError(f"{name} is a part of {whole}, which is stored as one: name {whole}")
    near = did_you_mean(name, POINTS) or ", whose columns floquet run stores without this setting"
    raise InputError(f"{name!r} is no column of the table of points{near}")


def chosen(names: Collection[str]) -> tuple[str, ...]:
    """The columns of points that are stored where these are named: they and those of ALWAYS, in the schema's order."""
    wanted = {column_name(name) for name in names}
    return tuple(name for name in POINTS if name in wanted or name in ALWAYS or EVERY in wanted)


def stored_variables(columns: Mapping[str, Column]) -> dict[str, Column]:
    """The columns as they are stored: complex ones in two parts."""
    out: dict[str, Column] = {}
    for name, c in columns.items():
        if c.dtype == "c16":
            parts = (("re", "real part"), ("im", "imaginary part"))
            out |= {f"{name}_{p}": Column("f8", c.units, f"{c.long_name}, {what}") for p, what in parts}
        else:
            out[name] = c
    return out
