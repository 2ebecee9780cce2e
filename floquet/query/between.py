"""Columns of a design between its rows: the polynomial in the advance ratio through the nearest rows.

With the k rows x_i nearest to μ, nearest first, and Lagrange's weights::

    w_i = Π_{j ≠ i} (μ − x_j)/(x_i − x_j)        p_k = Σ w_i y_i
    error = max(|p_k − p_{k−1}|, |p_{k−1} − p_{k−2}|)

The error is an estimate, no bound. Exponents have a square root at the edge of a lock, and those of a mode where its
simple pair splits: the rows about μ, and all that are taken, must be of one kind, which is their lock (outside of locks
the interval between multiples of ½ that the rotation number lies in), and of a mode its ``rule`` and ``cause``. Next to
such an edge polynomials converge slowly. Of exponents at 900 random μ between rows 0.01 apart (γ of 5 and 8, three
offsets) the error was larger than estimated in 2 %, all within five rows of an edge, and there up to seven times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from floquet.errors import ParameterError, QueryError
from floquet.query.language import ROTOR, Array, Column, Rows, Scope
from floquet.sweep import MODES

MU, LOCK, ROTATION = "advance_ratio", "lock", "rotation_number"
EACH_ITS_OWN = ("exponent_error", "determinant_defect", LOCK)
"""Numbers of one computation, which say nothing of what lies between two."""
LEAST, MOST = 3, 12
SAME = 1e-15  # 0.3 is the row at 3 × 0.1


@dataclass(frozen=True, kw_only=True)
class Interpolated:
    """Columns of one design at an advance ratio: ``values``, and by the same names ``errors``, which are estimates.

    ``rows`` are the advance ratios of the rows that were taken. Of a design between rotors ``design`` has the numbers
    that were asked for and ``nodes`` the rotors' values that were taken; it has no rotor, which is −1. Where a row has
    no number the value is nan and the error inf; at the advance ratio of a row the values are those of the row and the
    errors 0.
    """

    advance_ratio: float
    rotor: int
    rotor_name: str
    rows: tuple[float, ...]
    values: Mapping[str, Any]
    errors: Mapping[str, float]
    design: Mapping[str, float] = field(default_factory=dict)
    nodes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)


def wanted(columns: Sequence[str] | None, present: Mapping[str, Column], scope: Scope) -> list[str]:
    """The columns to be interpolated, all that can be where none are named, each a number that varies smoothly."""
    if columns is None:
        smooth = [name for name, column in present.items() if np.dtype(column.dtype).kind in "fc"]
        return [name for name in smooth if name not in (*EACH_ITS_OWN, MU) and _known(name, present)]
    return list(dict.fromkeys(_checked(name, present, scope) for name in columns))


def _checked(name: str, present: Mapping[str, Column], scope: Scope) -> str:
    if name not in present:
        try:
            scope.check(str(name))
        except QueryError as error:
            raise ParameterError("columns", name, str(error).removeprefix("query: ")) from None
    elif present[name].flags or np.dtype(present[name].dtype).kind not in "fc":
        what = "holds words" if present[name].flags else "counts"
        raise ParameterError("columns", name, f"{name} {what}, and has no value between rows; ask a row with db.query")
    if name in EACH_ITS_OWN:
        raise ParameterError("columns", name, f"{name} is each row's own, and has no value between rows")
    if not _known(name, present):
        kind = next(kind for kind in _kinds(name) if kind not in present)
        raise ParameterError("columns", name, f"{name} needs the column {kind}, which is not stored in this database")
    return name


def _mode(name: str) -> str:
    return next((mode for mode in MODES if mode in name.split("_")), "")


def _kinds(name: str) -> list[str]:
    """The columns that must not change where a column is interpolated."""
    mode = _mode(name)
    return [LOCK, *((f"rule_{mode}", f"cause_{mode}") if mode else ())]


def _known(name: str, present: Mapping[str, Column]) -> bool:
    return all(kind in present for kind in _kinds(name))


def kinds(names: Sequence[str], present: Mapping[str, Column]) -> list[str]:
    """The columns that say of what kind a row is."""
    found = [kind for name in names for kind in _kinds(name)]
    return list(dict.fromkeys([*found, *((ROTATION,) if ROTATION in present else ())]))


def interpolated(rows: Rows, names: Sequence[str], kinds: Sequence[str], present: Mapping[str, Column],
                 mu: float, count: int, rotor_name: str) -> Interpolated:  # fmt: skip
    """The columns ``names`` at μ from the rows of one design, ``count`` of them or as many as are of the kind."""
    x, first = np.unique(rows[MU], return_index=True)
    nearest = int(np.argmin(np.abs(x - mu)))
    if np.isclose(x[nearest], mu, rtol=SAME, atol=0):
        mu = float(x[nearest])
    if not x[0] <= mu <= x[-1]:
        raise ParameterError(MU, mu, f"{mu} lies outside of the rows, which go from {float(x[0])} to {float(x[-1])}")
    if mu == x[nearest]:
        taken = np.array([nearest])
    else:
        low, high = _run(x, {name: rows[name][first] for name in kinds}, present, mu)
        inside = np.arange(low, high + 1)
        taken = inside[np.argsort(np.abs(x[inside] - mu), kind="stable")[:count]]
        if taken.size < LEAST:
            raise ParameterError(
                MU, mu, f"only {taken.size} rows about {mu:g} are of its kind ({x[low]:g} to {x[high]:g}), and a value "
                f"with its error takes {LEAST}; run the study with more advance ratios there"
            )  # fmt: skip
    values, errors = {}, {}
    with np.errstate(all="ignore"):
        for name in names:
            values[name], errors[name] = _polynomial(x[taken], rows[name][first][taken], mu)
    return Interpolated(
        advance_ratio=mu, rotor=int(rows[ROTOR][0]), rotor_name=rotor_name,
        rows=tuple(np.sort(x[taken]).tolist()), values=values, errors=errors,
    )  # fmt: skip


def _run(x: Array, kinds: Rows, present: Mapping[str, Column], mu: float) -> tuple[int, int]:
    """The first and last of the rows about μ that are all of one kind."""
    above = int(np.searchsorted(x, mu))
    changes = {name: np.flatnonzero(_changes(name, kinds)) for name in kinds}  # between row i and row i + 1
    for name, places in changes.items():
        if above - 1 in places:
            where = f"between the rows {x[above - 1]:g} and {x[above]:g}"
            raise ParameterError(MU, mu, refusal(name, kinds[name][above - 1 : above + 1].tolist(), present, where))
    places = np.unique(np.concatenate(list(changes.values())))
    low, high = places[places < above - 1], places[places > above - 1]
    return (int(low[-1]) + 1 if low.size else 0), (int(high[0]) if high.size else x.size - 1)


def _changes(name: str, kinds: Rows) -> Array:
    values = kinds[name]
    if name == ROTATION:  # locks differ or are passed unseen between two rows outside of all
        values = np.where(np.isnan(kinds[LOCK]), np.floor(2 * values), np.nan)
        free = ~np.isnan(values)
        return (values[1:] != values[:-1]) & free[1:] & free[:-1]
    return (values[1:] != values[:-1]) & ~(np.isnan(values[1:]) & np.isnan(values[:-1]))


def refusal(
    name: str, values: Sequence[Any], present: Mapping[str, Column], where: str, more: str = "advance ratios"
) -> str:
    """Why there is no polynomial where a kind changes from the one of the values to the other."""
    way_out = f"compute there, or run the study with more {more}"
    if name == LOCK:
        a, b = (f"the lock at {v:g}" if v == v else "no lock" for v in values)
        return f"there is an edge of a lock {where} ({a}, {b}), where exponents have a square root; {way_out}"
    if name == ROTATION:
        return f"a lock lies {where} (the rotation number goes from {values[0]:g} to {values[1]:g}); {way_out}"
    flags = present[name].flags or {}
    a, b = (flags.get(int(v), str(v)) for v in values)
    others = f"name columns of other modes than {_mode(name)}, or {way_out}"
    return f"the kind of pair changes {where} ({name} is {a}, then {b}); {others}"


def _polynomial(x: Array, y: Array, mu: float) -> tuple[Any, float]:
    """Value and error at μ from rows in the order of their distance."""
    if (y == y[0]).all():
        return y[0].item(), 0.0
    best, less, least = ((weights(x[:k], mu) @ y[:k]).item() for k in (x.size, x.size - 1, x.size - 2))
    error = max(abs(best - less), abs(less - least))
    return best, float(error) if np.isfinite(best) and np.isfinite(error) else float("inf")


def weights(x: Array, mu: float) -> Array:
    others = ~np.eye(x.size, dtype=bool)
    factors = np.divide(mu - x[None, :], x[:, None] - x[None, :], where=others, out=np.ones((x.size, x.size)))
    return factors.prod(axis=1)
