"""Rows → one row a group: min, max, mean, median, count, first and x at min(y), from chunks one by one.

Memory goes by the number of groups, and for a median by the number of rows: it keeps its column.

A group is the rows with equal values in some columns: −0 is 0, and nan is one value. Each reduction folds a chunk's
values v into one number s a group, with nan for "no value here"::

    min      s ← fmin(s, v)             max      s ← fmax(s, v)          (nan passed over; nan where all are)
    mean     (s, n) ← (s + Σv, n + 1)   s / n    over the rows where v is not nan
    median   s ← s, v                   of s sorted the middle one, or the mean of the two; nan passed over
    count    s ← s + 1                  over all rows; of a column, over the rows where it is not nan
    first    s ← v of the first row of the group in file order, whatever it is
    x at min(y)    s ← v of the first row with the least y (nan after all else); x at max(y) of that with the greatest
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquet.errors import ParameterError, QueryError, did_you_mean
from floquet.query.language import ROTOR, ROTOR_NAME, Array, Column, Rows, Scope, short

REDUCTIONS = ("min", "max", "mean", "median", "count", "first")
_WRITTEN = re.compile(r"\s*(?:(\w+)\s+at\s+)?(\w+)\s*(?:\(\s*(\w*)\s*\)\s*)?")
_PLACES = ("argmin", "argmax", "idxmin", "idxmax")  # as others call it
_ORDERED = ("min", "max", "mean", "median")


@dataclass(frozen=True, kw_only=True)
class Reduction:
    """One number a group: ``kind`` of REDUCTIONS, of a column (count needs none), or another column's value there."""

    kind: str
    column: str = ""
    value: str = ""

    @property
    def name(self) -> str:
        """How the column of the answer is called."""
        own = f"{self.kind}({self.column})" if self.column else self.kind
        return f"{self.value} at {own}" if self.value else own

    @property
    def result(self) -> str:
        """The column whose values the answer has."""
        return ROTOR if self.value == ROTOR_NAME else self.value or self.column

    @property
    def reads(self) -> list[str]:
        """The columns it goes by, that of the answer first."""
        return [*([self.result] if self.value else []), *([self.column] if self.column else [])]

    @classmethod
    def of(cls, text: str, columns: Mapping[str, Column], scope: Scope) -> Reduction:
        """``min(limit)`` → a checked reduction."""
        match = _WRITTEN.fullmatch(text)
        if match is None:
            raise ParameterError("reduce", text, f"{short(text)!r} is no reduction, {_AS_IN}")
        value, kind, column = match[1] or "", match[2], match[3] or ""
        if kind not in REDUCTIONS:
            where = f"; write rotor at {kind[3:]}({column or 'limit'})" if kind in _PLACES else ""
            if kind in columns and not value and not column:
                where = f", and a column is taken of a row, as in {kind} at min(limit)"
            near = where or did_you_mean(kind, REDUCTIONS) or f", {_AS_IN}"
            raise ParameterError("reduce", text, f"{short(kind)!r} is none of {', '.join(REDUCTIONS)}{near}")
        if not column and kind != "count":
            raise ParameterError("reduce", text, f"{kind} is of a column, as in {kind}(limit)")
        if value and kind not in ("min", "max"):
            raise ParameterError("reduce", text, f"a value is at a least or greatest one, as in {value} at min(limit)")
        for name in (value,) if value else ():
            if name not in columns and not (name == ROTOR_NAME and ROTOR in columns):
                _checked("reduce", name, scope)
        if column and not (kind == "first" and column in columns):
            _checked("reduce", column, scope)
        if kind in _ORDERED and column in columns and (columns[column].flags or column == ROTOR):
            what = "numbers rotors" if column == ROTOR else "holds words"
            raise ParameterError("reduce", text, f"{column} {what}, which have no order; take first({column}) or count")
        return cls(kind=kind, column=column, value=value)


_AS_IN = "as in min(limit), count"


def _checked(option: str, name: str, scope: Scope) -> str:
    try:
        return scope.check(name)
    except QueryError as error:
        raise ParameterError(option, name, str(error).removeprefix("query: ")) from None


def reductions(given: object, columns: Mapping[str, Column], scope: Scope) -> tuple[Reduction, ...]:
    """The reductions that were asked for, as one text with commas or as several; once each."""
    found = [Reduction.of(text, columns, scope) for text in _texts("reduce", given)]
    if not found:
        raise ParameterError("reduce", given, f"nothing is asked for; name reductions, {_AS_IN}")
    return tuple(dict.fromkeys(found))


def keys(given: object, scope: Scope) -> tuple[str, ...]:
    """The columns whose values make the groups; none makes one group of all rows."""
    if given is None:
        return ()
    named = [ROTOR if name == ROTOR_NAME and ROTOR in scope.dtypes else name for name in _texts("by", given)]
    if not named:
        raise ParameterError("by", given, "no column is named; name some, or leave it out for one group of all rows")
    return tuple(dict.fromkeys(_checked("by", name, scope) for name in named))


def _texts(option: str, given: object) -> list[str]:
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, Sequence) or not all(isinstance(text, str) for text in texts):
        raise ParameterError(option, given, f"{short(repr(given))} was given; it is a text, or several")
    return [name.strip() for text in texts for name in text.split(",") if name.strip()]


class Groups:
    """The groups met so far: the values of their keys and what their rows reduce to."""

    def __init__(self, by: Sequence[str], reduced: Sequence[Reduction], dtypes: Mapping[str, np.dtype[Any]]) -> None:
        self._by, self._dtypes = tuple(by), dtypes
        self._number: dict[bytes, int] = {}
        self._folds = {one.name: _fold(one, dtypes.get(one.result)) for one in reduced}
        self._columns = {one.name: one.reads for one in reduced}

    @property
    def read(self) -> list[str]:
        """The columns that a chunk must have."""
        return list(dict.fromkeys([*self._by, *(name for names in self._columns.values() for name in names)]))

    def add(self, rows: Rows, count: int) -> None:
        """Fold ``count`` rows, in file order, into their groups."""
        if not count:
            return
        group = self._group(rows, count)
        for name, fold in self._folds.items():
            fold.grow(len(self._number))
            with np.errstate(all="ignore"):
                fold.add(group, *([rows[column] for column in self._columns[name]] or [np.zeros(count)]))

    def _group(self, rows: Rows, count: int) -> Array:
        """(count,) the number of each row's group; new ones are numbered on."""
        key, code = np.zeros((count, max(1, len(self._by)))), np.zeros(count, dtype=np.int64)
        for i, name in enumerate(self._by):
            values = np.asarray(rows[name], dtype=float) + 0.0  # −0 is 0
            key[:, i] = np.where(np.isnan(values), np.nan, values)  # one nan of the many
            met, place = np.unique(key[:, i], return_inverse=True)
            code = np.unique(code * len(met) + place, return_inverse=True)[1]
        firsts = np.unique(code, return_index=True)[1]
        numbers = [self._number.setdefault(key[i].tobytes(), len(self._number)) for i in firsts]
        return np.array(numbers)[code]

    def result(self) -> Rows:
        """Groups in the order of their keys, nan last: first the keys, then the reductions.

        Without keys there is one, be it of no rows: counts are 0 then, and the others nan; but no row is the first.
        """
        of_a_row = any(isinstance(fold, _First | _At) for fold in self._folds.values())
        if not self._by and not self._number and not of_a_row:
            none = {_Count: np.zeros(1, dtype=np.int64)}
            return {name: none.get(type(fold), np.full(1, np.nan)) for name, fold in self._folds.items()}
        met = np.frombuffer(b"".join(self._number), dtype=float).reshape(len(self._number), max(1, len(self._by)))
        order = np.lexsort(met.T[::-1]) if self._by else np.arange(len(met))
        found = {name: met[order, i].astype(self._dtypes[name]) for i, name in enumerate(self._by)}
        return found | {name: fold.result()[order] for name, fold in self._folds.items()}


class _Extreme:
    """min or max; whole numbers stay whole."""

    def __init__(self, ufunc: np.ufunc, dtype: np.dtype[Any] | None) -> None:
        self._ufunc, self._dtype, self._state = ufunc, dtype, np.empty(0)

    def grow(self, groups: int) -> None:
        self._state = _longer(self._state, groups, np.nan)

    def add(self, group: Array, values: Array) -> None:
        self._ufunc.at(self._state, group, np.asarray(values, dtype=float))

    def result(self) -> Array:
        return self._state.astype(self._dtype or float)


class _Mean:
    def __init__(self, dtype: np.dtype[Any] | None) -> None:
        self._sum, self._count = np.empty(0), np.empty(0, dtype=np.int64)

    def grow(self, groups: int) -> None:
        self._sum, self._count = _longer(self._sum, groups, 0.0), _longer(self._count, groups, 0)

    def add(self, group: Array, values: Array) -> None:
        known = ~np.isnan(values)
        self._sum += np.bincount(group[known], np.asarray(values[known], dtype=float), minlength=self._sum.size)
        self._count += np.bincount(group[known], minlength=self._count.size)

    def result(self) -> Array:
        with np.errstate(all="ignore"):
            return self._sum / self._count


class _Median:
    """Keeps the values: a median needs them all."""

    def __init__(self, dtype: np.dtype[Any] | None) -> None:
        self._groups: list[Array] = []
        self._values: list[Array] = []
        self._count = 0

    def grow(self, groups: int) -> None:
        self._count = groups

    def add(self, group: Array, values: Array) -> None:
        known = ~np.isnan(values)
        kept = np.int32 if self._count < 2**31 else np.int64
        self._groups.append(group[known].astype(kept))
        self._values.append(np.array(values[known]))

    def result(self) -> Array:
        if not self._values:
            return np.empty(0)
        group, values = np.concatenate(self._groups), np.concatenate(self._values).astype(float)
        values = values[np.lexsort((values, group))]
        size = np.bincount(group, minlength=self._count)
        first = np.cumsum(size) - size
        out = np.full(self._count, np.nan)
        some = size > 0
        low, high = (values[(first + (size - odd) // 2)[some]] for odd in (1, 0))
        with np.errstate(all="ignore"):
            out[some] = np.where(low == high, low, (low + high) / 2)
        return out


class _Count:
    def __init__(self, dtype: np.dtype[Any] | None) -> None:
        self._count = np.empty(0, dtype=np.int64)

    def grow(self, groups: int) -> None:
        self._count = _longer(self._count, groups, 0)

    def add(self, group: Array, values: Array) -> None:
        self._count += np.bincount(group[~np.isnan(values)], minlength=self._count.size)

    def result(self) -> Array:
        return self._count


class _First:
    def __init__(self, dtype: np.dtype[Any] | None) -> None:
        self._state, self._known = np.empty(0, dtype or float), 0

    def grow(self, groups: int) -> None:
        self._state = _longer(self._state, groups, 0)
        self._new = self._known
        self._known = groups

    def add(self, group: Array, values: Array) -> None:
        fresh = np.flatnonzero(group >= self._new)[::-1]  # of rows with one group the last written stays: the first
        self._state[group[fresh]] = values[fresh]

    def result(self) -> Array:
        return self._state


class _At:
    """A value of the row with the least or greatest key."""

    def __init__(self, sign: float, dtype: np.dtype[Any] | None) -> None:
        self._sign, self._state, self._key, self._known = sign, np.empty(0, dtype or float), np.empty(0), 0

    def grow(self, groups: int) -> None:
        self._state, self._key = _longer(self._state, groups, 0), _longer(self._key, groups, np.nan)
        self._new, self._known = self._known, groups

    def add(self, group: Array, values: Array, key: Array) -> None:
        keys = self._sign * np.asarray(key, dtype=float)
        order = np.lexsort((keys, group))  # stable, and nan last
        first = order[np.flatnonzero(np.diff(group[order], prepend=-1))]
        at, least = group[first], keys[first]
        better = (at >= self._new) | (least < self._key[at]) | (np.isnan(self._key[at]) & ~np.isnan(least))
        self._state[at[better]], self._key[at[better]] = values[first[better]], least[better]

    def result(self) -> Array:
        return self._state


def _longer(state: Array, length: int, fill: float) -> Array:
    return np.concatenate([state, np.full(length - state.size, fill, state.dtype)]) if length > state.size else state


def _fold(one: Reduction, dtype: np.dtype[Any] | None) -> Any:
    """What gathers a reduction whose values have this type."""
    return _At(1.0 if one.kind == "min" else -1.0, dtype) if one.value else _FOLDS[one.kind](dtype)


_FOLDS: dict[str, Callable[[np.dtype[Any] | None], Any]] = {
    "min": lambda dtype: _Extreme(np.fmin, dtype),
    "max": lambda dtype: _Extreme(np.fmax, dtype),
    "mean": _Mean,
    "median": _Median,
    "count": _Count,
    "first": _First,
}
