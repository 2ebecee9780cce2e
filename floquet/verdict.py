"""What is said of a system's stability, and why it may not be."""

from __future__ import annotations

from .rotor import Word

__all__ = ["Reason", "Verdict"]


class Verdict(Word):
    """STABLE: all σ + bound < 0.  UNSTABLE: some σ - bound > 0."""

    STABLE = 0
    UNSTABLE = 1
    UNDECIDED = 2


class Reason(Word):
    """Why a verdict is UNDECIDED."""

    NONE = 0
    NEUTRAL = 1  # one undamped scalar equation outside its locks: σ = 0 by the equation, not by its numbers
    BOUND = 2  # the bound of some exponent reaches across zero
