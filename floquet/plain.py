"""Values as texts have them: flags as words, numbers as strict JSON, lines of CSV, which every parser reads."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from typing import Any

__all__ = ["csv_lines", "strict", "words"]


class _Lines(list[str]):
    """What a writer of CSV writes to, a line at a time."""

    def write(self, line: str) -> None:
        self.append(line[:-2] + "\n")


def csv_lines(rows: Iterable[Iterable[Any]]) -> str:
    """Rows as lines that end in a line feed; a text that has one, or a carriage return, is in quotes."""
    lines = _Lines()
    csv.writer(lines, lineterminator="\r\n").writerows(rows)  # it quotes what has a letter of its end of line
    return "".join(lines)


def words(values: Any, flags: Mapping[int, str] | None) -> list[Any]:
    """An array as a list, flags as their words; a number that is no flag stays a number."""
    plain: list[Any] = values.tolist()
    return [flags.get(value, value) for value in plain] if flags else plain


def strict(value: Any) -> Any:
    """A number: nan is None, inf "inf", a complex one [re, im]; anything else as it is."""
    if isinstance(value, complex):
        return [strict(value.real), strict(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf" if value > 0 else "-inf"
    return value
