"""A safe expression → rows: a small language over the columns of a database, streamed in bounded memory.

The language, loosest first::

    or    and    not    < <= > >= == !=, chained    in (…), not in (…)    + -    * /    unary + -    **

with numbers (``1e-3``, ``inf``), column names, words in quotes, parentheses, and the functions abs, min, max, sqrt,
isnan and isfinite. It is a subset of Python's grammar, with Python's precedence; ``&`` and ``|`` are refused, because
in Python they bind tighter than a comparison. Three kinds of value never mix: numbers, truth values and words (the flag
columns such as ``verdict``; ``rotor`` is a number that may also be compared with a rotor's name). A complex column is
reachable by its parts, NAME_re and NAME_im.

Arithmetic is float64 as in NumPy. So are comparisons with nan: ``<``, ``<=``, ``>``, ``>=``, ``==`` and ``in`` are
false, and ``!=`` is **true**, like ``not (… == …)``; ``isfinite(x)`` leaves a row without a value out, ``isnan(x)``
finds it.

An expression is parsed by an LALR grammar and checked (names, kinds, length, depth) before a row is read; nothing of it
reaches ``eval``. Each node of the tree has two readings, ``value`` over the columns of a chunk and ``bounds`` over
their stored ranges (interval arithmetic), and a chunk is skipped only when the bounds of the tree exclude "true"::

    holds(chunk) = value(columns)        skip(minima, maxima) = bounds([minimum, maximum] ∪ {nan}).high < 1

Rounding is monotone, so the ends of an interval bound every row's result of + - * / sqrt to the last bit; powers are
widened by 1e-12.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import Enum
from functools import cache, cached_property, partial, reduce
from itertools import islice
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquet.errors import DatabaseError, QueryError, did_you_mean

__all__ = ["Database", "open_database", "MAX_LENGTH", "MAX_DEPTH"]

MAX_LENGTH = 10_000
"""Characters in an expression."""
MAX_DEPTH = 64
"""Levels of parentheses, and of the parsed tree."""

Array: TypeAlias = NDArray[Any]
Rows: TypeAlias = dict[str, Array]


class Column(Protocol):
    """What a query needs to know of a column."""

    @property
    def dtype(self) -> Any: ...
    @property
    def units(self) -> str: ...
    @property
    def long_name(self) -> str: ...
    @property
    def flags(self) -> Mapping[int, str] | None: ...


class Reader(Protocol):
    """What a query needs of an open file; ``floquet.store.open_file`` gives it."""

    @property
    def names(self) -> Sequence[str]: ...
    @property
    def attributes(self) -> Mapping[str, Any]: ...
    @property
    def tables(self) -> Sequence[str]: ...
    def columns(self, table: str) -> Mapping[str, Any]: ...
    def rows(self, table: str) -> int: ...
    def chunks(
        self,
        table: str,
        columns: Sequence[str],
        start: int = 0,
        stop: int | None = None,
        skip: Callable[[Mapping[str, Any], Mapping[str, Any]], bool] | None = None,
    ) -> Iterator[tuple[int, Rows]]: ...


# --- intervals: what can a node be, when its columns lie between a chunk's minima and maxima? -------------------------


class Interval(NamedTuple):
    """Every value lies in [low, high], or is nan where ``nan`` says so; truth values lie in [0, 1]."""

    low: float
    high: float
    nan: bool = False


UNKNOWN = Interval(-np.inf, np.inf, True)
_HUGE = float(np.finfo(float).max)


def _hull(corners: Sequence[float], nan: bool) -> Interval:
    """The interval of its corners, nan inside where an end is infinite; a corner inf − inf or 0 · inf says nothing."""
    if np.isnan(corners).any():
        return UNKNOWN
    return Interval(min(corners), max(corners), nan or bool(np.isinf(corners).any()))


def _add(a: Interval, b: Interval) -> Interval:
    return _hull((a.low + b.low, a.high + b.high), a.nan or b.nan)


def _subtract(a: Interval, b: Interval) -> Interval:
    return _hull((a.low - b.high, a.high - b.low), a.nan or b.nan)


def _multiply(a: Interval, b: Interval) -> Interval:
    return _hull([x * y for x in a[:2] for y in b[:2]], a.nan or b.nan)


def _divide(a: Interval, b: Interval) -> Interval:
    if b.low <= 0 <= b.high:
        return UNKNOWN
    return _hull([np.divide(x, y) for x in a[:2] for y in b[:2]], a.nan or b.nan)


def _negate(a: Interval) -> Interval:
    return Interval(-a.high, -a.low, a.nan)


def _absolute(a: Interval) -> Interval:
    ends = abs(a.low), abs(a.high)
    return Interval(0.0 if a.low <= 0 <= a.high else min(ends), max(ends), a.nan)


def _root(a: Interval) -> Interval:
    return Interval(np.sqrt(a.low), np.sqrt(a.high), a.nan) if a.low >= 0 else UNKNOWN


def _power(a: Interval, exponent: float) -> Interval:
    """Monotone on positive numbers, and for odd natural exponents; even ones go by |x|; the rest is unknown."""
    natural = exponent > 0 and float(exponent).is_integer()
    if natural and exponent % 2 == 0:
        a = _absolute(a)
    if not (a.low > 0 or (a.low == 0 and exponent > 0) or natural):
        return UNKNOWN
    return _widened(_hull([np.power(end, exponent) for end in np.array(a[:2])], a.nan))


def _widened(a: Interval) -> Interval:
    """Room for the last bits of a power, which no two implementations share."""
    low, high = min(a.low, _HUGE), max(a.high, -_HUGE)
    return Interval(low - abs(low) * 1e-12 - 1e-300, high + abs(high) * 1e-12 + 1e-300, a.nan)


def _least(*args: Interval) -> Interval:
    return Interval(min(a.low for a in args), min(a.high for a in args), any(a.nan for a in args))


def _greatest(*args: Interval) -> Interval:
    return Interval(max(a.low for a in args), max(a.high for a in args), any(a.nan for a in args))


def _truth(certain: Any, possible: Any) -> Interval:
    return Interval(float(bool(certain)), float(bool(possible)))


def _not(a: Interval) -> Interval:
    return Interval(1.0 - a.high, 1.0 - a.low)


def _less(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.high < b.low, a.low < b.high)


def _less_equal(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.high <= b.low, a.low <= b.high)


def _equal(a: Interval, b: Interval) -> Interval:
    return _truth(not (a.nan or b.nan) and a.low == a.high == b.low == b.high, a.low <= b.high and b.low <= a.high)


def _among(values: Sequence[float], a: Interval) -> Interval:
    """x in (values): certain where x is one number, possible where one of them lies between the ends."""
    inside = any(a.low <= v <= a.high for v in values)
    return _truth(inside and a.low == a.high and not a.nan, inside)


def _is_nan(a: Interval) -> Interval:
    return _truth(False, a.nan)


def _is_finite(a: Interval) -> Interval:
    return _truth(not a.nan and np.isfinite(a.high - a.low), a.low < np.inf and a.high > -np.inf)


class Operation(NamedTuple):
    """One operation, over arrays and over intervals, and how many arguments it takes."""

    value: Callable[..., Any]
    bounds: Callable[..., Interval]
    least: int = 2
    most: int = 2


def _swapped(function: Callable[[Interval, Interval], Interval]) -> Callable[[Interval, Interval], Interval]:
    return lambda a, b: function(b, a)


ARITHMETIC = {
    "+": Operation(np.add, _add),
    "-": Operation(np.subtract, _subtract),
    "*": Operation(np.multiply, _multiply),
    "/": Operation(np.divide, _divide),
}
COMPARISONS = {
    "<": Operation(np.less, _less),
    "<=": Operation(np.less_equal, _less_equal),
    ">": Operation(np.greater, _swapped(_less)),
    ">=": Operation(np.greater_equal, _swapped(_less_equal)),
    "==": Operation(np.equal, _equal),
    "!=": Operation(np.not_equal, lambda a, b: _not(_equal(a, b))),
}
FUNCTIONS = {
    "abs": Operation(np.abs, _absolute, 1, 1),
    "min": Operation(lambda *args: reduce(np.minimum, args), _least, 2, MAX_LENGTH),
    "max": Operation(lambda *args: reduce(np.maximum, args), _greatest, 2, MAX_LENGTH),
    "sqrt": Operation(np.sqrt, _root, 1, 1),
    "isnan": Operation(np.isnan, _is_nan, 1, 1),
    "isfinite": Operation(np.isfinite, _is_finite, 1, 1),
}
NOT = Operation(np.logical_not, _not, 1, 1)
ALL = Operation(lambda *args: reduce(np.logical_and, args), _least)
ANY = Operation(lambda *args: reduce(np.logical_or, args), _greatest)


# --- the checked tree -------------------------------------------------------------------------------------------------


class Kind(Enum):
    """What a node yields, in the words of the error sentences."""

    NUMBER = "a number"
    TRUTH = "a truth value"
    FLAG = "a column of words"
    WORD = "a word in quotes"


@dataclass(frozen=True, kw_only=True)
class Node:
    """A checked part of an expression: what it is, where it stands (1-based), and its two readings."""

    kind: Kind
    at: int
    value: Callable[[Mapping[str, Any]], Any]
    bounds: Callable[[Mapping[str, Interval]], Interval]
    name: str = ""
    word: str = ""
    constant: bool = False


def _apply(operation: Operation, kind: Kind, at: int, args: Sequence[Node]) -> Node:
    return Node(
        kind=kind,
        at=at,
        value=lambda chunk: operation.value(*[a.value(chunk) for a in args]),
        bounds=lambda ranges: operation.bounds(*[a.bounds(ranges) for a in args]),
        constant=all(a.constant for a in args),
    )


@dataclass(frozen=True, kw_only=True)
class Scope:
    """The columns an expression may name: all of them, those that are complex, and the words that some compare with."""

    dtypes: Mapping[str, np.dtype[Any]]
    complex_names: frozenset[str]
    words: Mapping[str, Sequence[tuple[int, str]]]

    @classmethod
    def of(cls, columns: Mapping[str, Column], names: Sequence[str]) -> Scope:
        dtypes: dict[str, np.dtype[Any]] = {}
        for name, column in columns.items():
            dtype = np.dtype(column.dtype)
            parts = [name + "_re", name + "_im"] if dtype.kind == "c" else [name]
            dtypes |= dict.fromkeys(parts, np.dtype("f8") if dtype.kind == "c" else dtype)
        words = {name: tuple(column.flags.items()) for name, column in columns.items() if column.flags}
        if ROTOR in columns and names:
            words[ROTOR] = tuple(enumerate(names))
        return cls(dtypes=dtypes, complex_names=frozenset(columns) - frozenset(dtypes), words=words)

    def kind(self, name: str) -> Kind:
        return Kind.FLAG if name in self.words and name != ROTOR else Kind.NUMBER

    def number(self, name: str, minimum: Any, maximum: Any) -> Interval:
        """The range of a column from what is stored of a chunk; a bound that is missing or nan says nothing."""
        nan = self.dtypes[name].kind == "f"
        if minimum is None or maximum is None or not minimum <= maximum:
            return Interval(-np.inf, np.inf, nan)
        return Interval(np.float64(minimum), np.float64(maximum), nan)

    def check(self, name: str, expression: str = "", at: int = 0) -> str:
        """The name, if a number or flag column has it."""
        if name in self.dtypes:
            return name
        if name in self.complex_names:
            raise QueryError(f"{name} is complex; write {name}_re or {name}_im", expression, at)
        raise QueryError(f"{_short(name)!r} is no column of this table{self._hint(name)}", expression, at)

    def _hint(self, name: str) -> str:
        if name.lower() in KEYWORDS:
            return f"; write {name.lower()} in small letters"
        if name.lower() in _KNOWN:
            return f"; {_KNOWN[name.lower()]}"
        for column, words in self.words.items():
            if any(name.casefold() == word.casefold() for _, word in islice(words, 1000)):
                return f'; a word stands in quotes, as in {column} == "{name}"'
        return did_you_mean(name, [*self.dtypes, *self.complex_names])

    def codes(self, name: str, node: Node, expression: str) -> tuple[int, ...]:
        """The codes of a column's word; a name as written goes before one that only differs in capitals."""
        words = self.words[name]
        exact = tuple(code for code, word in words if word == node.word)
        found = exact or tuple(code for code, word in words if word.casefold() == node.word.casefold())
        if found:
            return found
        near = did_you_mean(node.word, [word for _, word in islice(words, 1000)])
        near = near or did_you_mean(node.word.lower(), [word.lower() for _, word in islice(words, 1000)])
        listed = ", ".join(_short(word) for _, word in words[:8]) + (", …" if len(words) > 8 else "")
        sentence = f"{_short(node.word)!r} is no word of {name}, which has {listed}"
        raise QueryError(sentence + near, expression, node.at)


ROTOR, ROTOR_NAME = "rotor", "rotor_name"
KEYWORDS = ("and", "or", "not", "in")
_KNOWN = {
    ROTOR_NAME: f"use {ROTOR}, which may be compared with a name in quotes",
    "mu": "the column is advance_ratio",
    "gamma": "the column is lock_number",
    "nan": "nan equals nothing, find it with isnan(x)",
    "infinity": "write inf",
    "true": "a comparison is already true or false",
    "false": "a comparison is already true or false",
}


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"


class Compiler:
    """Parsed tree → checked nodes: one method a rule of the grammar, the names that were met in ``names``."""

    def __init__(self, scope: Scope, expression: str) -> None:
        self.scope, self.expression = scope, expression
        self.names: dict[str, None] = {}

    def __call__(self, tree: Any) -> Node:
        """A token goes by its terminal, a tree by its rule."""
        rule = tree.data if hasattr(tree, "data") else tree.type.lower()
        node: Node = getattr(self, "_" + rule)(tree)
        return node

    def _fail(self, sentence: str, at: int) -> QueryError:
        return QueryError(sentence, self.expression, at)

    def root(self, tree: Any) -> Node:
        return self._need(Kind.TRUTH, self(tree))

    def _need(self, kind: Kind, node: Node) -> Node:
        if node.kind is kind:
            return node
        what = {Kind.TRUTH: "a comparison stands", Kind.WORD: "a word in quotes stands"}.get(node.kind, "")
        what = what or (f"{node.name} is {node.kind.value}" if node.name else f"this is {node.kind.value}")
        name = node.name or "it"
        way_out = {
            Kind.TRUTH: "join comparisons with and, or, not",
            Kind.NUMBER: f"compare {name}, as in {node.name or '…'} > 0.1",
            Kind.WORD: 'a word is compared with a column of words, as in verdict == "UNSTABLE"',
            Kind.FLAG: f"compare {name} with == or != or in, as in {self._example(node.name)}",
        }[node.kind]
        raise self._fail(f"{what} where {kind.value} is needed; {way_out}", node.at)

    def _example(self, name: str) -> str:
        words = self.scope.words.get(name, ())
        return f'{name} == "{_short(words[0][1])}"' if words else f"{name} == 0"

    # leaves

    def _number(self, token: Any) -> Node:
        number, at = np.float64(token), _at(token)
        if np.isinf(number):
            raise self._fail(f"{_short(token)} is beyond the largest number, 1.8e308; write inf for infinity", at)
        return self._constant(number, at)

    def _constant(self, number: Any, at: int) -> Node:
        point = Interval(number, number, bool(np.isnan(number)))
        return Node(kind=Kind.NUMBER, at=at, value=lambda _: number, bounds=lambda _: point, constant=True)

    def _string(self, token: Any) -> Node:
        """A word has no value of its own: it becomes the codes of the column it is compared with."""
        word = str(token)[1:-1]
        return Node(kind=Kind.WORD, at=_at(token), value=lambda _: np.nan, bounds=lambda _: UNKNOWN, word=word)

    def _name(self, token: Any) -> Node:
        name, at = str(token), _at(token)
        if name == "inf":
            return self._constant(np.float64(np.inf), at)
        if name in FUNCTIONS:
            raise self._fail(f"{name} is a function; write {name}(…) with its argument in parentheses", at)
        self.names[self.scope.check(name, self.expression, at)] = None
        return Node(
            kind=self.scope.kind(name),
            at=at,
            name=name,
            value=lambda chunk: np.asarray(chunk[name], dtype=float),
            bounds=lambda ranges: ranges[name],
        )

    # numbers

    def _chain_of_arithmetic(self, tree: Any) -> Node:
        total = self._need(Kind.NUMBER, self(tree.children[0]))
        rest = [self._need(Kind.NUMBER, self(child)) for child in tree.children[2::2]]
        steps = [(ARITHMETIC[str(sign)], node) for sign, node in zip(tree.children[1::2], rest, strict=True)]

        def value(chunk: Mapping[str, Any]) -> Any:
            result = total.value(chunk)
            for operation, node in steps:
                result = operation.value(result, node.value(chunk))
            return result

        def bounds(ranges: Mapping[str, Interval]) -> Interval:
            result = total.bounds(ranges)
            for operation, node in steps:
                result = operation.bounds(result, node.bounds(ranges))
            return result

        constant = all(node.constant for node in (total, *rest))
        return Node(kind=Kind.NUMBER, at=total.at, value=value, bounds=bounds, constant=constant)

    _sum = _term = _chain_of_arithmetic

    def _signed(self, tree: Any) -> Node:
        sign, operand = tree.children
        node = self._need(Kind.NUMBER, self(operand))
        return _apply(Operation(np.negative, _negate), Kind.NUMBER, _at(sign), [node]) if sign == "-" else node

    def _power(self, tree: Any) -> Node:
        base, exponent = (self._need(Kind.NUMBER, self(child)) for child in tree.children)
        if not exponent.constant:
            raise self._fail("the exponent after ** is a number, as in lock_number ** 2", exponent.at)
        with np.errstate(all="ignore"):
            number = exponent.value({})
        operation = Operation(lambda x: np.power(x, number), lambda a: _power(a, number))
        return _apply(operation, Kind.NUMBER, base.at, [base])

    def _call(self, tree: Any) -> Node:
        name, at = str(tree.children[0]), _at(tree.children[0])
        if name not in FUNCTIONS:
            raise self._fail(f"{_short(name)!r} is no function; there are {', '.join(FUNCTIONS)}", at)
        function, count = FUNCTIONS[name], len(tree.children) - 1
        if not function.least <= count <= function.most:
            rule = "one argument" if function.most == 1 else "two or more arguments"
            raise self._fail(f"{name} takes {rule}, {count or 'none'} given", at)
        args = [self._need(Kind.NUMBER, self(child)) for child in tree.children[1:]]
        return _apply(function, Kind.TRUTH if name.startswith("is") else Kind.NUMBER, at, args)

    # truth values

    def _either(self, tree: Any) -> Node:
        args = [self._need(Kind.TRUTH, self(child)) for child in tree.children]
        return _apply(ANY if tree.data == "either" else ALL, Kind.TRUTH, args[0].at, args)

    _both = _either

    def _denied(self, tree: Any) -> Node:
        word, operand = tree.children
        return _apply(NOT, Kind.TRUTH, _at(word), [self._need(Kind.TRUTH, self(operand))])

    def _chain(self, tree: Any) -> Node:
        """a < b <= c is a < b and b <= c."""
        operands, signs = [self(child) for child in tree.children[::2]], tree.children[1::2]
        pairs = [self._relation(a, s, b) for a, s, b in zip(operands, signs, operands[1:], strict=False)]
        return pairs[0] if len(pairs) == 1 else _apply(ALL, Kind.TRUTH, pairs[0].at, pairs)

    def _relation(self, a: Node, sign: Any, b: Node) -> Node:
        if {Kind.WORD, Kind.FLAG} & {a.kind, b.kind}:
            column, word = (b, a) if a.kind is Kind.WORD or b.kind is Kind.FLAG else (a, b)
            if sign not in ("==", "!="):
                raise self._fail(f"words have no order; compare with == or != instead of {sign}", _at(sign))
            found = self._words(column, [word])
            return found if sign == "==" else _apply(NOT, Kind.TRUTH, found.at, [found])
        args = [self._need(Kind.NUMBER, a), self._need(Kind.NUMBER, b)]
        return _apply(COMPARISONS[str(sign)], Kind.TRUTH, a.at, args)

    def _member(self, tree: Any) -> Node:
        operand, absent, *children = tree.children
        node, items = self(operand), [self(child) for child in children]
        if not items:
            raise self._fail("the set after in is empty; name its members, as in blades in (2, 4)", node.at)
        words = node.kind is Kind.FLAG or any(item.kind is Kind.WORD for item in items)
        found = self._words(node, items) if words else self._numbers(node, items)
        return _apply(NOT, Kind.TRUTH, found.at, [found]) if absent else found

    def _words(self, node: Node, items: Sequence[Node]) -> Node:
        """node is one of the words: a column of flags (or ``rotor``) against the codes of the words."""
        if node.name not in self.scope.words:
            raise self._fail(self._wordless(node), node.at)
        codes: list[float] = []
        for item in items:
            if item.kind is not Kind.WORD:
                example = self._example(node.name)
                raise self._fail(f"{node.name} holds words; compare it with a word in quotes, as in {example}", item.at)
            codes += self.scope.codes(node.name, item, self.expression)
        return self._isin(node, codes)

    def _wordless(self, node: Node) -> str:
        if node.name == ROTOR:
            return "this database has no rotor names; compare rotor with a number, as in rotor == 0"
        what = f"{node.name} holds numbers" if node.name else f"this is {node.kind.value}"
        some = f"; these columns hold words: {', '.join(list(self.scope.words)[:6])}" if self.scope.words else ""
        return f"{what}, which a word in quotes cannot be compared with{some}"

    def _numbers(self, node: Node, items: Sequence[Node]) -> Node:
        for item in items:
            if not self._need(Kind.NUMBER, item).constant:
                raise self._fail("the members of a set are numbers or words, as in blades in (2, 4)", item.at)
        with np.errstate(all="ignore"):
            return self._isin(self._need(Kind.NUMBER, node), [item.value({}) for item in items])

    def _isin(self, node: Node, values: Sequence[float]) -> Node:
        members = np.array([v for v in values if not np.isnan(v)], dtype=float)
        operation = Operation(lambda x: np.isin(x, members), partial(_among, members.tolist()))
        return _apply(operation, Kind.TRUTH, node.at, [node])


def _at(token: Any) -> int:
    return int(token.start_pos) + 1


@dataclass(frozen=True, kw_only=True)
class Predicate:
    """A compiled expression: the columns it reads, which rows of a chunk hold, which chunks cannot."""

    scope: Scope
    names: tuple[str, ...] = ()
    node: Node | None = field(default=None, repr=False)

    def holds(self, chunk: Mapping[str, Array], rows: int) -> Array:
        """(rows,) bool."""
        if self.node is None:
            return np.ones(rows, dtype=bool)
        with np.errstate(all="ignore"):
            return np.broadcast_to(self.node.value(chunk), rows)

    def skip(self, minima: Mapping[str, Any], maxima: Mapping[str, Any]) -> bool:
        """Can no row of a chunk with these minima and maxima hold?"""
        if self.node is None:
            return False
        ranges = {name: self.scope.number(name, minima.get(name), maxima.get(name)) for name in self.names}
        with np.errstate(all="ignore"):
            return self.node.bounds(ranges).high < 1


# --- text → tree ------------------------------------------------------------------------------------------------------

GRAMMAR = r"""
?start: either
?either: both ("or" both)*
?both: negation ("and" negation)*
?negation: NOT negation -> denied
         | comparison
?comparison: sum
           | sum (COMPARE sum)+ -> chain
           | sum [NOT] "in" "(" _arguments? ")" -> member
?sum: term (SIGN term)*
?term: factor (SCALE factor)*
?factor: SIGN factor -> signed
       | power
?power: atom
      | atom _POWER factor
?atom: NUMBER | STRING | NAME
     | NAME "(" _arguments? ")" -> call
     | "(" either ")"
_arguments: either ("," either)* ","?
NOT: "not"
COMPARE: "<=" | ">=" | "==" | "!=" | "<" | ">"
SIGN: "+" | "-"
SCALE: "*" | "/"
_POWER: "**"
NUMBER: /([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?/
STRING: /"[^"]*"|'[^']*'/
NAME: /[A-Za-z_][A-Za-z_0-9]*/
%ignore /\s+/
"""

_SHAPE = re.compile(r""""[^"]*"|'[^']*'|["'()]""")

_STRANGERS = {
    "&": "write and instead of &",
    "|": "write or instead of |",
    "=": "write == to compare",
    "!": "write not, or != to compare",
    "^": "write ** for a power",
    "[": "write a range as 0.2 <= x <= 0.4 and a set as x in (1, 2, 3)",
    "“": "words stand in straight quotes",
    "”": "words stand in straight quotes",
    "‘": "words stand in straight quotes",
    "’": "words stand in straight quotes",
}


@cache
def _parser() -> Any:
    """The LALR parser, made once; lark is loaded with the first expression."""
    import lark

    return lark.Lark(GRAMMAR, parser="lalr", lexer="basic", propagate_positions=True)


def compile_expression(expression: object, scope: Scope) -> Predicate:
    """Text → predicate; everything that can be wrong with an expression is found here."""
    if not isinstance(expression, str):
        raise QueryError(f"an expression is text, and {type(expression).__name__} was given; write it in quotes")
    _check_shape(expression)
    if not expression.strip():
        return Predicate(scope=scope)
    tree = _parse(expression)
    compiler = Compiler(scope, expression)
    node = compiler.root(tree)
    return Predicate(scope=scope, names=tuple(compiler.names), node=node)


def _check_shape(expression: str) -> None:
    """Length, quotes and parentheses, before anything is parsed."""
    if len(expression) > MAX_LENGTH:
        given = f"{len(expression)} characters are given and {MAX_LENGTH} allowed"
        raise QueryError(f"{given}; split the question, or filter the result", expression, MAX_LENGTH + 1)
    opened: list[int] = []
    for match in _SHAPE.finditer(expression):
        mark, at = match.group(), match.start() + 1
        if mark in ('"', "'"):
            raise QueryError(f"the quote {mark} opened here is never closed", expression, at)
        if mark == "(":
            opened.append(at)
        elif mark == ")" and not opened:
            raise QueryError("this ) closes no parenthesis", expression, at)
        elif mark == ")":
            opened.pop()
        if len(opened) > MAX_DEPTH:
            raise QueryError(_too_deep("parentheses"), expression, at)
    if opened:
        raise QueryError("the parenthesis opened here is never closed", expression, opened[-1])


def _too_deep(what: str) -> str:
    return f"{what} are nested more than {MAX_DEPTH} deep; write the expression flatter"


def _parse(expression: str) -> Any:
    from lark import exceptions

    try:
        tree = _parser().parse(expression)
    except exceptions.UnexpectedCharacters as e:
        at = int(e.pos_in_stream or 0)
        raise QueryError(_stranger(expression[at]), expression, at + 1) from None
    except exceptions.UnexpectedToken as e:
        ended = e.token.type == "$END"
        at = len(expression.rstrip()) + 1 if ended else _at(e.token)
        raise QueryError(_misplaced(e, expression[: at - 1], ended), expression, at) from None
    return _check_depth(tree, expression)


def _check_depth(tree: Any, expression: str) -> Any:
    """Signs, not and ** nest without parentheses; what follows walks the tree by recursion."""
    level = [tree]
    for _ in range(MAX_DEPTH):
        level = [child for node in level for child in getattr(node, "children", ())]
        if not level:
            return tree
    at = next((_position(node) for node in level if node is not None), 0)
    raise QueryError(_too_deep("signs, functions and parentheses"), expression, at)


def _position(node: Any) -> int:
    return int(node.meta.start_pos) + 1 if hasattr(node, "meta") else _at(node)


def _stranger(character: str) -> str:
    way_out = _STRANGERS.get(character, "it means nothing here: columns, numbers and words in quotes are compared")
    return f"{character!r} is not part of the language; {way_out}"


def _misplaced(error: Any, before: str, ended: bool) -> str:
    """A sentence for a token at the wrong place: a value was due, or an operator."""
    token, due = _short(str(error.token)), error.expected
    if "NUMBER" in due and ended:
        return "the expression ends where a column, a number or a word in quotes is due"
    if "NUMBER" in due and token == ")" and before.rstrip().endswith("("):
        return "there is nothing between these parentheses"
    if "NUMBER" in due:
        return f"{token!r} stands where a column, a number or a word in quotes is due"
    if due <= {"LPAR", "IN"}:
        return "a set in parentheses is due after in, as in blades in (2, 4)"
    if token.lower() in KEYWORDS and token not in KEYWORDS:
        return f"write {token.lower()} in small letters"
    if token == ",":
        return "a comma stands only between the arguments of a function or the members of a set"
    if error.token.type in ("COMPARE", "IN", "NOT", "SIGN", "SCALE", "_POWER"):
        return f"{token!r} cannot follow what stands before it; join comparisons with and, or"
    return f"{token!r} follows without an operator; join comparisons with and, or"


# --- rows -------------------------------------------------------------------------------------------------------------

DEFAULT_COLUMNS = {
    "points": (
        ROTOR, ROTOR_NAME, "advance_ratio", "lock_number", "hinge_offset", "pitch_flap_coupling", "verdict", "lock",
        "error_regressing", "error_coning", "error_advancing",
    ),
    "limits": (
        ROTOR, ROTOR_NAME, "lock_number", "hinge_offset", "pitch_flap_coupling", "mode", "metric", "tolerance", "limit",
        "cause", "lock",
    ),
}  # fmt: skip
"""What a query returns when no columns are named, followed by the columns its expression and its sort name."""


class Best:
    """The first ``limit`` rows in the order of a key, from pieces that arrive in file order: stable, nan last.

    At most 2 ``limit`` rows and one piece are kept; once ``limit`` rows are there, ``admits`` drops a row that comes no
    earlier than the last of them.
    """

    def __init__(self, key: str, descending: bool, limit: int | None) -> None:
        self.key, self.descending, self.limit = key, descending, limit
        self._pieces: list[Rows] = []
        self._rows = 0
        self._worst: Any = None

    def _keys(self, rows: Rows) -> Array:
        keys = np.asarray(rows[self.key], dtype=float)
        return -keys if self.descending else keys

    def admits(self, rows: Rows) -> Array:
        keys = self._keys(rows)
        if self._worst is None:
            return np.ones(keys.shape, dtype=bool)
        admitted: Array = ~(keys >= self._worst) & ~np.isnan(keys)
        return admitted

    def add(self, rows: Rows) -> None:
        self._pieces.append(rows)
        self._rows += len(rows[self.key])
        if self.limit is not None and self._rows >= 2 * self.limit:
            self.result()

    def result(self) -> Rows:
        rows = _joined(self._pieces)
        order = np.argsort(self._keys(rows), kind="stable")[: self.limit]
        rows = {name: values[order] for name, values in rows.items()}
        self._pieces, self._rows = [rows], len(order)
        if self.limit and len(order) == self.limit:
            self._worst = self._keys(rows)[-1]
        return rows


def _joined(pieces: Sequence[Rows]) -> Rows:
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def _first(pieces: Iterable[Rows], limit: int | None) -> Rows:
    """The first rows in file order; reading stops when they are there."""
    kept, rows = [], 0
    for piece in pieces:
        kept.append(piece)
        rows += len(next(iter(piece.values())))
        if limit is not None and rows >= limit:
            break
    return {name: values[:limit] for name, values in _joined(kept).items()}


class Database:
    """An open database: ``with open_database("validity.h5") as db: db.query("advance_ratio > 0.3")``."""

    def __init__(self, path: str | Path, reader: Reader, closing: ExitStack | None = None) -> None:
        self.path = str(path)
        self._open: Reader | None = reader
        self._closing = closing or ExitStack()

    def __enter__(self) -> Database:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Database({self.path!r})"

    def close(self) -> None:
        """Close the file; a second time does nothing."""
        self._open = None
        self._closing.close()

    @property
    def _reader(self) -> Reader:
        if self._open is None:
            raise DatabaseError(self.path, "the database is closed; open it again with open_database")
        return self._open

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the rotors, which the column ``rotor`` counts; empty if they have none."""
        return tuple(map(str, self._reader.names))

    @property
    def attributes(self) -> dict[str, Any]:
        """What the file says about itself: title, history, source, study."""
        return dict(self._reader.attributes)

    @property
    def tables(self) -> tuple[str, ...]:
        return tuple(self._reader.tables)

    def _table(self, table: str) -> str:
        if table not in self.tables:
            name, present = str(table), ", ".join(self.tables)
            raise QueryError(f"{_short(name)!r} is no table; this file has {present}{did_you_mean(name, self.tables)}")
        return table

    def columns(self, table: str = "points") -> dict[str, Any]:
        """Name → column (dtype, units, long_name, flags) in the order of the file; complex columns once."""
        return dict(self._reader.columns(self._table(table)))

    def rows(self, table: str = "points") -> int:
        return int(self._reader.rows(self._table(table)))

    def describe(self, table: str = "points") -> list[tuple[str, str, str]]:
        """(name, units, long name) of every column."""
        return [(name, column.units, column.long_name) for name, column in self.columns(table).items()]

    def limits(self, expression: str = "", **options: Any) -> Rows:
        """``query`` on the table of limits."""
        return self.query(expression, table="limits", **options)

    def query(
        self,
        expression: str = "",
        *,
        table: str = "points",
        columns: str | Sequence[str] | None = None,
        sort: str | None = None,
        descending: bool = False,
        limit: int | None = None,
    ) -> Rows:
        """The rows for which ``expression`` holds (all, if it is empty), as one array a column.

        ``columns`` names what is returned, complex columns by their name or by their parts; None is a short list for
        printing and the columns that ``expression`` and ``sort`` name, "*" is all of them. ``rotor_name`` stands
        beside the index ``rotor`` (an empty text where a rotor has no name). ``sort`` is stable, with nan last in both
        directions; ``limit`` is the number of rows, after sorting. Memory holds a chunk and the answer.
        """
        present = self.columns(table)
        scope = Scope.of(present, self.names)
        predicate = compile_expression(expression, scope)
        key = () if sort is None else (scope.check(str(sort)),)
        wanted = self._wanted(table, columns, present, scope, (*predicate.names, *key))
        limit = _checked_limit(limit)
        best = Best(key[0], bool(descending), limit) if key else None
        read = [ROTOR if name == ROTOR_NAME else name for name in wanted]
        pieces = self._pieces(table, predicate, list(dict.fromkeys([*read, *key])), best, limit)
        if best is None:
            found = _first(pieces, limit)
        else:
            for piece in pieces:
                best.add(piece)
            found = best.result()
        return {name: self._named(found[ROTOR]) if name == ROTOR_NAME else found[name] for name in wanted}

    def _wanted(
        self,
        table: str,
        columns: str | Sequence[str] | None,
        present: Mapping[str, Column],
        scope: Scope,
        used: Sequence[str],
    ) -> list[str]:
        named = (ROTOR_NAME,) if ROTOR in present else ()
        if columns is None:
            short = [*DEFAULT_COLUMNS.get(table, present), *used]
            known = {*present, *(named if self.names else ())}
            return list(dict.fromkeys(name for name in short if name in known or name in used))
        wanted: dict[str, None] = {}
        for name in [columns] if isinstance(columns, str) else columns:
            if name == "*":
                wanted |= dict.fromkeys([*present, *named])
            else:
                wanted[name if name in present or name in named else scope.check(str(name))] = None
        if not wanted:
            raise QueryError('no columns are asked for; name some, or "*" for all')
        return list(wanted)

    def _pieces(
        self, table: str, predicate: Predicate, read: Sequence[str], best: Best | None, limit: int | None
    ) -> Iterator[Rows]:
        """Chunk by chunk the rows that hold; the columns that are not tested are read only where a row does."""
        early = list(dict.fromkeys([*predicate.names, *([best.key] if best else [])])) or list(read)
        late = [name for name in read if name not in early]
        yield self._nothing(table, read)
        if limit == 0:
            return
        for start, chunk in self._reader.chunks(table, early, skip=predicate.skip):
            rows = len(chunk[early[0]])
            hits = np.flatnonzero(predicate.holds(chunk, rows))
            found = {name: chunk[name][hits] for name in early}
            if best is not None:
                admitted = best.admits(found)
                hits, found = hits[admitted], {name: values[admitted] for name, values in found.items()}
            if not hits.size:
                continue
            if late:
                beside = _joined([part for _, part in self._reader.chunks(table, late, start, start + rows)])
                found |= {name: values[hits] for name, values in beside.items()}
            yield {name: found[name] for name in read}

    def _nothing(self, table: str, read: Sequence[str]) -> Rows:
        """No row, in the right dtypes."""
        present = self.columns(table)
        return {name: np.empty(0, np.dtype(present[name].dtype) if name in present else float) for name in read}

    def _named(self, rotor: Array) -> Array:
        """The names of rotor indices; an index without a name gives an empty string."""
        names = np.array([*self.names, ""], dtype=object)
        return names[np.where((rotor >= 0) & (rotor < len(self.names)), rotor, len(self.names))]


def _checked_limit(limit: object) -> int | None:
    if limit is None:
        return None
    if isinstance(limit, bool) or not isinstance(limit, int | np.integer) or limit < 0:
        raise QueryError(f"limit is a number of rows, 0 or more, and {_short(repr(limit))} was given")
    return int(limit)


def open_database(path: str | Path) -> Database:
    """Open a database for reading; close it, or use it in a ``with`` statement."""
    from floquet import store

    closing = ExitStack()
    return Database(path, closing.enter_context(store.open_file(path)), closing)
