"""A model's arithmetic as a tape: recorded once with symbols for numbers, run on many points.

Tapes leave no interpreter between two operations: a kernel runs them on blocks of points that stay in a cache, and the
same tape serves doubles, pairs of doubles and fractions.
"""

from __future__ import annotations

from .program import Code, Program, program
from .record import Constant, Record, Symbol, UntraceableError

__all__ = ["Code", "Constant", "Program", "Record", "Symbol", "UntraceableError", "program"]
