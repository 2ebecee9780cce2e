"""What arithmetic is written with beside + - * / and comparisons: of arrays here, of lanes in :mod:`blocks`."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["select", "somewhere", "sqrt"]


def select(condition: Any, yes: Any, no: Any) -> Any:
    """``yes`` where the condition holds."""
    return np.where(condition, yes, no)


def sqrt(x: Any) -> Any:
    """√x."""
    return np.sqrt(x)


def somewhere(condition: Any) -> bool:
    """Whether the condition holds anywhere."""
    return bool(np.any(condition))
