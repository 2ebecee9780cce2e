"""Text → a checked tree: grammar, names, kinds and limits, each refusal with its column.

An expression is parsed by an LALR grammar and checked (names, kinds, length, depth) before a row is read; nothing of it
reaches ``eval``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cache, partial
from itertools import islice
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquet.errors import QueryError, did_you_mean
from floquet.query.intervals import (
    ALL,
    ANY,
    ARITHMETIC,
    COMPARISONS,
    FUNCTIONS,
    MAX_LENGTH,
    NOT,
    UNKNOWN,
    Interval,
    Operation,
    among,
    negate,
    power,
)

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
    """The columns an expression may name: all of them, those that are complex, and the words that some compare with.

    Those in ``left_out`` the study did not store; those of ``elsewhere`` another table of the file has.
    """

    dtypes: Mapping[str, np.dtype[Any]]
    complex_names: frozenset[str]
    words: Mapping[str, Sequence[tuple[int, str]]]
    left_out: frozenset[str] = frozenset()
    elsewhere: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        columns: Mapping[str, Column],
        names: Sequence[str],
        left_out: Iterable[str] = (),
        elsewhere: Mapping[str, str] | None = None,
    ) -> Scope:
        dtypes: dict[str, np.dtype[Any]] = {}
        for name, column in columns.items():
            dtype = np.dtype(column.dtype)
            parts = [name + "_re", name + "_im"] if dtype.kind == "c" else [name]
            dtypes |= dict.fromkeys(parts, np.dtype("f8") if dtype.kind == "c" else dtype)
        words = {name: tuple(column.flags.items()) for name, column in columns.items() if column.flags}
        if ROTOR in columns and names:
            words[ROTOR] = tuple(enumerate(names))
        return cls(
            dtypes=dtypes,
            complex_names=frozenset(columns) - frozenset(dtypes),
            words=words,
            left_out=frozenset(left_out),
            elsewhere=elsewhere or {},
        )

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
        if name in self.left_out:
            raise QueryError(f"{name} is not stored in this database: {LEFT_OUT}", expression, at)
        raise QueryError(f"{short(name)!r} is no column of this table{self._hint(name)}", expression, at)

    def _hint(self, name: str) -> str:
        if name.lower() in KEYWORDS:
            return f"; write {name.lower()} in small letters"
        if name in self.elsewhere:
            return f"; it is one of the table {self.elsewhere[name]}, so ask for that (--table {self.elsewhere[name]})"
        if name.lower() in KNOWN:
            return f"; {KNOWN[name.lower()]}"
        for column, words in self.words.items():
            if any(name.casefold() == word.casefold() for _, word in islice(words, 1000)):
                return f'; a word stands in quotes, as in {column} == "{name}"'
        return did_you_mean(name, [*self.dtypes, *self.complex_names, *sorted(self.left_out)])

    def codes(self, name: str, node: Node, expression: str) -> tuple[int, ...]:
        """The codes of a column's word; a name as written goes before one that only differs in capitals."""
        words = self.words[name]
        exact = tuple(code for code, word in words if word == node.word)
        found = exact or tuple(code for code, word in words if word.casefold() == node.word.casefold())
        if found:
            return found
        near = did_you_mean(node.word, [word for _, word in islice(words, 1000)])
        near = near or did_you_mean(node.word.lower(), [word.lower() for _, word in islice(words, 1000)])
        named = list(islice(dict.fromkeys(word for _, word in words if word), 9))
        listed = ", ".join(short(word) for word in named[:8]) + (", …" if len(named) > 8 else "")
        sentence = f"{short(node.word)!r} is no word of {name}, which has {listed}"
        raise QueryError(sentence + near, expression, node.at)


LEFT_OUT = "[output] columns of its study leaves it out, so add it there and run the study again"
ROTOR, ROTOR_NAME, FILE = "rotor", "rotor_name", "file"
NEAREST = "nearest"
_AS_IN_NEAREST = "as in nearest(advance_ratio=0.35)"
KEYWORDS = ("and", "or", "not", "in")
KNOWN = {
    ROTOR_NAME: f"use {ROTOR}, which may be compared with a name in quotes",
    "mu": "the column is advance_ratio",
    "gamma": "the column is lock_number",
    "nan": "nan equals nothing, find it with isnan(x)",
    "infinity": "write inf",
    "true": "a comparison is already true or false",
    "false": "a comparison is already true or false",
}


def short(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"


class Compiler:
    """Parsed tree → checked nodes: one method a rule of the grammar.

    The names that were met are in ``names``, and in ``nearest`` what must be looked for in all rows before any holds.
    """

    def __init__(self, scope: Scope, expression: str) -> None:
        self.scope, self.expression = scope, expression
        self.names: dict[str, None] = {}
        self.nearest: dict[str, tuple[str, float]] = {}

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
        if node.name and node.name == self.expression.strip():
            way_out += "; in a shell the whole expression stands in quotes"
        raise self._fail(f"{what} where {kind.value} is needed; {way_out}", node.at)

    def _example(self, name: str) -> str:
        words = self.scope.words.get(name, ())
        return f'{name} == "{short(words[0][1])}"' if words else f"{name} == 0"

    # leaves

    def _number(self, token: Any) -> Node:
        number, at = np.float64(token), _at(token)
        if np.isinf(number):
            raise self._fail(f"{short(token)} is beyond the largest number, 1.8e308; write inf for infinity", at)
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
        if name in (*FUNCTIONS, NEAREST):
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
        return _apply(Operation(np.negative, negate), Kind.NUMBER, _at(sign), [node]) if sign == "-" else node

    def _power(self, tree: Any) -> Node:
        base, exponent = (self._need(Kind.NUMBER, self(child)) for child in tree.children)
        if not exponent.constant:
            raise self._fail("the exponent after ** is a number, as in lock_number ** 2", exponent.at)
        with np.errstate(all="ignore"):
            number = exponent.value({})
        operation = Operation(lambda x: np.power(x, number), lambda a: power(a, number))
        return _apply(operation, Kind.NUMBER, base.at, [base])

    def _call(self, tree: Any) -> Node:
        name, at = str(tree.children[0]), _at(tree.children[0])
        if name == NEAREST:
            raise self._fail(f"nearest takes columns with their numbers, {_AS_IN_NEAREST}", at)
        if name not in FUNCTIONS:
            raise self._fail(f"{short(name)!r} is no function; there are {', '.join((*FUNCTIONS, NEAREST))}", at)
        function, count = FUNCTIONS[name], len(tree.children) - 1
        if not function.least <= count <= function.most:
            rule = "one argument" if function.most == 1 else "two or more arguments"
            raise self._fail(f"{name} takes {rule}, {count or 'none'} given", at)
        args = [self._need(Kind.NUMBER, self(child)) for child in tree.children[1:]]
        return _apply(function, Kind.TRUTH if name.startswith("is") else Kind.NUMBER, at, args)

    # truth values

    def _named_call(self, tree: Any) -> Node:
        """nearest(a=1, b=2) is a == (what is nearest to 1) and b == (what is nearest to 2)."""
        name, at = str(tree.children[0]), _at(tree.children[0])
        if name != NEAREST:
            raise self._fail(f"only nearest takes columns with their numbers, {_AS_IN_NEAREST}", at)
        columns = [setting.children[0] for setting in tree.children[1:]]
        for i, column in enumerate(columns):
            if column in columns[:i]:
                raise self._fail(f"nearest is given {short(column)} twice", _at(column))
        nodes = [self._setting(setting) for setting in tree.children[1:]]
        return nodes[0] if len(nodes) == 1 else _apply(ALL, Kind.TRUTH, at, nodes)

    def _setting(self, tree: Any) -> Node:
        column, target = self._name(tree.children[0]), self(tree.children[2])
        if column.kind is not Kind.NUMBER or column.constant:
            what = f"{column.name} holds words" if column.name else "inf is no column"
            raise self._fail(f"{what}, and nearest is of numbers; compare words, as in {self._word()}", column.at)
        if not self._need(Kind.NUMBER, target).constant:
            raise self._fail(f"{column.name} is held against a number, {_AS_IN_NEAREST}", target.at)
        with np.errstate(all="ignore"):
            number = float(target.value({}))
        if not np.isfinite(number):
            raise self._fail(f"nothing is near {number}; give a finite number, {_AS_IN_NEAREST}", target.at)
        key = f"nearest({column.name}={number!r})"
        self.nearest[key] = column.name, number
        found = Node(kind=Kind.NUMBER, at=target.at, value=lambda chunk: chunk[key], bounds=lambda ranges: ranges[key])
        return _apply(COMPARISONS["=="], Kind.TRUTH, column.at, [column, found])

    def _word(self) -> str:
        return self._example(next((name for name in self.scope.words if name != ROTOR), "verdict"))

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
        operation = Operation(lambda x: np.isin(x, members), partial(among, members.tolist()))
        return _apply(operation, Kind.TRUTH, node.at, [node])


def _at(token: Any) -> int:
    return int(token.start_pos) + 1


@dataclass(frozen=True, kw_only=True)
class Predicate:
    """A compiled expression: the columns it reads, which rows of a chunk hold, which chunks cannot.

    ``nearest`` is name → (column, number) of what has to be ``settled`` first: the finite value nearest to a number.
    """

    scope: Scope
    names: tuple[str, ...] = ()
    node: Node | None = field(default=None, repr=False)
    nearest: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    found: Mapping[str, float] = field(default_factory=dict)

    def settled(self, found: Mapping[str, float]) -> Predicate:
        """With the values that are nearest; nan, where a column has no finite value, is met by no row."""
        return replace(self, found=dict(found))

    def holds(self, chunk: Mapping[str, Array], rows: int) -> Array:
        """(rows,) bool."""
        if self.node is None:
            return np.ones(rows, dtype=bool)
        with np.errstate(all="ignore"):
            return np.broadcast_to(self.node.value({**chunk, **self.found}), rows)

    def skip(self, minima: Mapping[str, Any], maxima: Mapping[str, Any]) -> bool:
        """Can no row of a chunk with these minima and maxima hold?"""
        if self.node is None:
            return False
        ranges = {name: self.scope.number(name, minima.get(name), maxima.get(name)) for name in self.names}
        points = {name: Interval(value, value) for name, value in self.found.items()}  # nan equals nothing here, too
        with np.errstate(all="ignore"):
            return self.node.bounds(ranges | points).high < 1


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
     | NAME "(" setting ("," setting)* ","? ")" -> named_call
     | "(" either ")"
_arguments: either ("," either)* ","?
setting: NAME SET sum
NOT: "not"
COMPARE: "<=" | ">=" | "==" | "!=" | "<" | ">"
SET: "="
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
    "%": "5 % is 0.05",
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
    return Predicate(scope=scope, names=tuple(compiler.names), node=node, nearest=compiler.nearest)


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
    token, due = short(str(error.token)), error.expected
    if token == "=":
        return _stranger(token)
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
