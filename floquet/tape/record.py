"""Symbols that write down what is done to them.

A :class:`Symbol` stands for a number in object arrays, as a fraction does.  Its operations become entries of a
:class:`Record`, equal ones a single entry::

    kind      operands
    input     name
    constant  Constant
    + - * /   two entries
    neg abs   one entry

Rewritten is only what leaves every bit of a double as it is, but for the sign of zero: 0 + x, 1 x, 0 x, x - x,
x + (-y), x/2, 2 (x/2).  A constant is known exactly and as the double that the operations on doubles make of it, so
that a parameter may be taken as 0 or 1 beforehand, or not, without a change of the result.  Comparisons cannot be
written down, for their outcome is not known: :class:`UntraceableError`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NoReturn

import numpy as np

__all__ = ["Constant", "Record", "Symbol", "UntraceableError"]

OPERATORS: Mapping[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "neg": operator.neg, "abs": abs,
}  # fmt: skip


class UntraceableError(Exception):
    """Arithmetic whose course depends on its numbers."""


@dataclass(frozen=True)
class Constant:
    """A number: exactly, and as the double that arithmetic with doubles gives."""

    exact: Fraction
    double: float

    @staticmethod
    def of(number: Any) -> Constant:
        """Of a number of Python or NumPy."""
        exact = Fraction(number.item() if isinstance(number, np.generic) else number)
        return Constant(exact, float(exact))

    def equals(self, number: int) -> bool:
        """Whether it is this number either way."""
        return self.exact == number == self.double


ZERO = Constant(Fraction(0), 0.0)


@dataclass(frozen=True, eq=False, slots=True)
class Symbol:
    """An entry of a record."""

    record: Record
    place: int

    def _with(self, kind: str, other: Any, swapped: bool = False) -> Any:
        if isinstance(other, np.ndarray):
            return NotImplemented  # entry by entry
        place = other.place if isinstance(other, Symbol) else self.record.constant(Constant.of(other))
        a, b = (place, self.place) if swapped else (self.place, place)
        return Symbol(self.record, self.record.entry(kind, a, b))

    def __add__(self, other: Any) -> Any:
        return self._with("+", other)

    def __radd__(self, other: Any) -> Any:
        return self._with("+", other, True)

    def __sub__(self, other: Any) -> Any:
        return self._with("-", other)

    def __rsub__(self, other: Any) -> Any:
        return self._with("-", other, True)

    def __mul__(self, other: Any) -> Any:
        return self._with("*", other)

    def __rmul__(self, other: Any) -> Any:
        return self._with("*", other, True)

    def __truediv__(self, other: Any) -> Any:
        return self._with("/", other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with("/", other, True)

    def __neg__(self) -> Symbol:
        return Symbol(self.record, self.record.entry("neg", self.place))

    def __abs__(self) -> Symbol:
        return Symbol(self.record, self.record.entry("abs", self.place))

    def __bool__(self) -> bool:
        """Whether it may be other than zero: terms without one are left out."""
        known = self.record.known(self.place)
        return known is None or not known.equals(0)

    def _unknown(self, *_: Any) -> NoReturn:
        raise UntraceableError("a symbol has no value to compare or convert")

    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = __float__ = __int__ = __pow__ = _unknown
    __hash__ = None  # type: ignore[assignment]


class Record:
    """Entries in the order in which they were made, each once."""

    def __init__(self) -> None:
        self.entries: list[tuple[Any, ...]] = []
        self._places: dict[tuple[Any, ...], int] = {}

    def input(self, name: str) -> Symbol:
        """A symbol for a number that is not known yet."""
        return Symbol(self, self._placed(("input", name)))

    def number(self, value: Any) -> Symbol:
        """A symbol for a known number, on which arithmetic goes on in doubles, too."""
        return Symbol(self, self.constant(Constant.of(value)))

    def constant(self, value: Constant) -> int:
        """The place of a constant."""
        return self._placed(("constant", value))

    def place(self, value: Any) -> int:
        """The place of what a computation gave: a symbol, or a number if no symbol was left in it."""
        return value.place if isinstance(value, Symbol) else self.constant(Constant.of(value))

    def known(self, place: int) -> Constant | None:
        """The constant at a place."""
        kind, *rest = self.entries[place]
        return rest[0] if kind == "constant" else None

    def entry(self, kind: str, *places: int) -> int:
        """The place of an operation's result."""
        constants = [self.known(p) for p in places]
        if all(c is not None for c in constants):
            return self.constant(_folded(kind, *constants))  # type: ignore[arg-type]
        if kind in ("neg", "abs"):
            return self._of_one(kind, places[0])
        return (self._of_sum if kind in "+-" else self._of_product)(kind, *places)

    def _placed(self, entry: tuple[Any, ...]) -> int:
        if entry not in self._places:
            self._places[entry] = len(self.entries)
            self.entries.append(entry)
        return self._places[entry]

    def _negated(self, place: int) -> int | None:
        """What this is the negative of."""
        kind, *rest = self.entries[place]
        return rest[0] if kind == "neg" else None

    def _of_one(self, kind: str, x: int) -> int:
        inner, entry = self._negated(x), self.entries[x]
        if kind == "abs":
            return x if entry[0] == "abs" else self._placed(("abs", x if inner is None else inner))
        if entry[0] == "-":
            return self.entry("-", entry[2], entry[1])
        return self._placed(("neg", x)) if inner is None else inner

    def _of_sum(self, kind: str, x: int, y: int) -> int:
        if self._is(y, 0):
            return x
        if self._is(x, 0):
            return y if kind == "+" else self.entry("neg", y)
        if (inner := self._negated(y)) is not None:
            return self.entry("-" if kind == "+" else "+", x, inner)
        if kind == "+" and (inner := self._negated(x)) is not None:
            return self.entry("-", y, inner)
        if x == y:
            return self.constant(ZERO) if kind == "-" else self.entry("*", x, self.constant(Constant.of(2)))
        return self._placed((kind, *(sorted((x, y)) if kind == "+" else (x, y))))

    def _of_product(self, kind: str, x: int, y: int) -> int:
        if kind == "*" and self.known(x) is not None:
            x, y = y, x
        if self._is(x, 0) or (kind == "*" and self._is(y, 0)):
            return self.constant(ZERO)
        if self._is(y, 1):
            return x
        if self._is(y, -1):
            return self.entry("neg", x)
        for one, other in ((x, y), (y, x)):
            if (inner := self._negated(one)) is not None:
                return self.entry("neg", self.entry(kind, *((inner, other) if one == x else (other, inner))))
        if (power := self._power_of_two(y)) is not None:
            if kind == "/":
                return self.entry("*", x, self.constant(Constant.of(1 / power)))
            first, *operands = self.entries[x]
            if first == "*" and (before := self._power_of_two(operands[1])) is not None:
                return self.entry("*", operands[0], self.constant(Constant.of(power * before)))
        if kind == "*" and self.known(y) is None:
            x, y = sorted((x, y))
        return self._placed((kind, x, y))

    def _power_of_two(self, place: int) -> Fraction | None:
        """A constant that is one, or the negative of one: products with it are not rounded."""
        known = self.known(place)
        exact = known is not None and known.exact == known.double and abs(math.frexp(known.double)[0]) == 0.5
        return known.exact if exact and known is not None else None

    def _is(self, place: int, number: int) -> bool:
        known = self.known(place)
        return known is not None and known.equals(number)


def _folded(kind: str, *constants: Constant) -> Constant:
    operate = OPERATORS[kind]
    return Constant(operate(*(c.exact for c in constants)), operate(*(c.double for c in constants)))
