"""How far the reduced order is from the tip-path plane at hover: what the captions of figures 10 to 12 say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def order_words(table: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Smallest and largest error of the slow root at γ = 2 and 8 in percent, and how much too fast coning is at 2."""
    of = {gamma: [row for row in table if row["lock_number"] == gamma] for gamma in (2.0, 8.0)}
    slow, fast = ([100.0 * row["cyclic_error"] for row in of[gamma]] for gamma in (2.0, 8.0))
    times = [row["coning_reduced"] / row["coning"].real for row in of[2.0]]
    return {"low": span(slow, ".1f"), "high": span(fast, ".1f"), "fast": span(times, ".0f")}


def span(values: Sequence[float], digits: str) -> str:
    """``5.6 to 6.6``."""
    return f"{min(values):{digits}} to {max(values):{digits}}"
