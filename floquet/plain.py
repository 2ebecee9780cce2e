"""Values as texts have them: flags as words, numbers as strict JSON, which every parser reads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

__all__ = ["strict", "words"]


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
