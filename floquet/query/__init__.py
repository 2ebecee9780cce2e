"""A safe expression → rows: a small language over the columns of a database, streamed in bounded memory.

The language, loosest first::

    or    and    not    < <= > >= == !=, chained    in (…), not in (…)    + -    * /    unary + -    **

with numbers (``1e-3``, ``inf``), column names, words in quotes, parentheses, the functions abs, min, max, sqrt, isnan
and isfinite, and ``nearest(column=number, …)``. It is a subset of Python's grammar, with Python's precedence; ``&`` and
``|`` are refused, because in Python they bind tighter than a comparison. Three kinds of value never mix: numbers, truth
values and words (the flag columns such as ``verdict``; ``rotor`` is a number that may also be compared with a rotor's
name). A complex column is reachable by its parts, NAME_re and NAME_im.

Arithmetic is float64 as in NumPy. So are comparisons with nan: ``<``, ``<=``, ``>``, ``>=``, ``==`` and ``in`` are
false, and ``!=`` is **true**, like ``not (… == …)``; ``isfinite(x)`` leaves a row without a value out, ``isnan(x)``
finds it.

An expression is parsed by an LALR grammar and checked (names, kinds, length, depth) before a row is read; nothing of it
reaches ``eval``. Each node of the tree has two readings, ``value`` over the columns of a chunk and ``bounds`` over
their stored ranges (interval arithmetic), and a chunk is skipped only when the bounds of the tree exclude "true"::

    holds(chunk) = value(columns)        skip(minima, maxima) = bounds([minimum, maximum] ∪ {nan}).high < 1

``nearest(x=c)`` is x == x*, with x* the finite value nearest to c in the whole table, which a first pass finds.

Rounding is monotone, so the ends of an interval bound every row's result of + - * / sqrt to the last bit; powers are
widened by 1e-12.
"""

from floquet.query.database import DEFAULT_COLUMNS, Database, open_database
from floquet.query.intervals import MAX_LENGTH, Interval
from floquet.query.language import MAX_DEPTH, Predicate, Scope, compile_expression

__all__ = [
    "DEFAULT_COLUMNS",
    "Database",
    "open_database",
    "MAX_LENGTH",
    "MAX_DEPTH",
    "Interval",
    "Predicate",
    "Scope",
    "compile_expression",
]
