"""Rows in pieces → the first of them in an order, and values nearest to numbers; what is kept is bounded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from floquet.query.language import Array, Rows


class Best:
    """The first ``limit`` rows in the order of some keys, from pieces that arrive in file order: stable, nan last.

    At most 2 ``limit`` rows and one piece are kept; once ``limit`` rows are there, ``admits`` drops rows that come no
    earlier than the last of them.
    """

    def __init__(self, keys: Sequence[str], descending: bool, limit: int | None) -> None:
        self.keys, self.descending, self.limit = tuple(keys), descending, limit
        self._pieces: list[Rows] = []
        self._rows = 0
        self._worst: Any = None

    def _keys(self, rows: Rows) -> list[Array]:
        keys = (np.asarray(rows[name], dtype=float) for name in self.keys)
        return [-values if self.descending else values for values in keys]

    def admits(self, rows: Rows) -> Array:
        first, *others = self._keys(rows)
        if self._worst is None or (others and np.isnan(self._worst)):
            return np.ones(first.shape, dtype=bool)
        beyond = first > self._worst if others else first >= self._worst  # the others decide between equals
        admitted: Array = ~beyond & ~np.isnan(first)
        return admitted

    def add(self, rows: Rows) -> None:
        self._pieces.append(rows)
        self._rows += len(rows[self.keys[0]])
        if self.limit is not None and self._rows >= 2 * self.limit:
            self.result()

    def result(self) -> Rows:
        rows = joined(self._pieces)
        order = np.lexsort(self._keys(rows)[::-1])[: self.limit]
        rows = {name: values[order] for name, values in rows.items()}
        self._pieces, self._rows = [rows], len(order)
        if self.limit and len(order) == self.limit:
            self._worst = self._keys(rows)[0][-1]
        return rows


TIE = 4 * float(np.finfo(float).eps)
"""Distances that differ by so much of the number, or of themselves, are equal: 0.5 and 0.6 are as near to 0.55."""


class Nearest:
    """Name → the finite value of a column nearest to a number, from chunks one by one; of two as near, the smaller."""

    def __init__(self, wanted: Mapping[str, tuple[str, float]]) -> None:
        self._wanted = wanted
        self.columns = list(dict.fromkeys(column for column, _ in wanted.values()))
        self.found = dict.fromkeys(wanted, np.nan)
        self._ranges = {column: (np.inf, -np.inf) for column in self.columns}

    def beyond(self) -> Iterator[str]:
        """What is to be said of numbers that lie beyond all values of their columns."""
        for name, (column, number) in self._wanted.items():
            low, high = self._ranges[column]
            if np.isfinite([low, high]).all() and not low <= number <= high:
                yield (
                    f"nearest({column}={number:g}) lies beyond all values of {column}, which are {low:g} to {high:g}: "
                    f"its rows are those of {self.found[name]:g}"
                )

    def _distance(self, name: str) -> float:
        """What a value must not exceed to be looked at; inf as long as there is none."""
        number = self._wanted[name][1]
        distance = abs(self.found[name] - number)
        return distance + TIE * max(abs(number), distance) if distance >= 0 else np.inf

    def skip(self, minima: Mapping[str, Any], maxima: Mapping[str, Any]) -> bool:
        """Does every value of a chunk with these ranges lie farther away than what is there?"""
        for column, (low, high) in self._ranges.items():
            self._ranges[column] = min(low, minima.get(column, -np.inf)), max(high, maxima.get(column, np.inf))
        return all(
            max(minima.get(column, -np.inf) - number, number - maxima.get(column, np.inf)) > self._distance(name)
            for name, (column, number) in self._wanted.items()
        )

    def add(self, chunk: Rows) -> None:
        for name, (column, number) in self._wanted.items():
            values = np.append(np.asarray(chunk[column], dtype=float), self.found[name])
            values = values[np.isfinite(values)]
            if values.size:
                distances = np.abs(values - number)
                nearest = distances.min()
                self.found[name] = float(values[distances <= nearest + TIE * max(abs(number), nearest)].min())


def joined(pieces: Sequence[Rows]) -> Rows:
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def first(pieces: Iterable[Rows], limit: int | None) -> Iterator[Rows]:
    """The first rows in file order; reading stops when they are there."""
    left = limit
    for piece in pieces:
        rows = len(next(iter(piece.values())))
        yield piece if left is None or rows <= left else {name: values[:left] for name, values in piece.items()}
        left = None if left is None else max(left - rows, 0)
        if left == 0:
            return
