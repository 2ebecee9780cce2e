"""From a record to a program: what is needed, in order, in few registers.

Values are of two kinds.  *Scalars* are the same for all points: constants, inputs that do not vary, and what follows
from these.  *Rows* hold a value a point in a block of points.  An instruction is four numbers, code, result and two
operands; the codes say of which kind the operands are.  Rows are used again once nothing needs their values; the
result of an instruction never stands where one of its operands is read.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .record import OPERATORS, Constant, Record

__all__ = ["Code", "Program", "program"]


class Code(IntEnum):
    """What an instruction does: of two rows, or of a row and a scalar (``_S``), or of a scalar and a row (``S_``)."""

    ADD = 0
    SUB = 1
    MUL = 2
    DIV = 3
    NEG = 4
    ABS = 5
    ADD_S = 6
    SUB_S = 7
    S_SUB = 8
    MUL_S = 9
    DIV_S = 10
    S_DIV = 11
    SPREAD = 12  # a scalar to all points


KINDS = {"+": Code.ADD, "-": Code.SUB, "*": Code.MUL, "/": Code.DIV, "neg": Code.NEG, "abs": Code.ABS}
WITH_SCALAR = {"+": Code.ADD_S, "-": Code.SUB_S, "*": Code.MUL_S, "/": Code.DIV_S}
OF_SCALAR = {"+": Code.ADD_S, "-": Code.S_SUB, "*": Code.MUL_S, "/": Code.S_DIV}


@dataclass(frozen=True, eq=False, kw_only=True)
class Program:
    """Instructions that give ``outputs`` from inputs.

    Attributes
    ----------
    constants : tuple of Constant
        The first scalars.
    uniform, varying : tuple of str
        Names of the inputs: scalars after the constants, and the first rows.
    prologue : int32 (steps, 4)
        Instructions among scalars, each with a new result.
    steps : int32 (steps, 4)
        Instructions among rows.
    outputs : int32 (outputs,)
        The rows in which they stand at the end.
    scalars, rows : int
        How many there are.
    """

    constants: tuple[Constant, ...]
    uniform: tuple[str, ...]
    varying: tuple[str, ...]
    prologue: NDArray[np.int32]
    steps: NDArray[np.int32]
    outputs: NDArray[np.int32]
    scalars: int
    rows: int

    def run(self, inputs: Mapping[str, Any], *, exact: bool = False) -> list[Any]:
        """The outputs for inputs of any kind that has + - * / and abs, constants as doubles or exact: no kernel."""
        scalars = [c.exact if exact else c.double for c in self.constants] + [inputs[name] for name in self.uniform]
        scalars += [None] * (self.scalars - len(scalars))
        for code, to, a, b in self.prologue.tolist():
            scalars[to] = _done(code, scalars[a], scalars[b])
        rows = [inputs[name] for name in self.varying] + [None] * (self.rows - len(self.varying))
        for code, to, a, b in self.steps.tolist():
            x, y = (scalars if first else rows for first in _scalar_operands(code))
            rows[to] = _done(code, x[a], y[b])
        return [rows[i] for i in self.outputs]


def _scalar_operands(code: int) -> tuple[bool, bool]:
    """Which operands of an instruction of rows are scalars."""
    return code in (Code.S_SUB, Code.S_DIV, Code.SPREAD), code in (Code.ADD_S, Code.SUB_S, Code.MUL_S, Code.DIV_S)


def _done(code: int, x: Any, y: Any) -> Any:
    """One instruction on numbers."""
    if code == Code.SPREAD:
        return x
    name = next(k for table in (KINDS, WITH_SCALAR, OF_SCALAR) for k, c in table.items() if c == code)
    return OPERATORS[name](x) if name in ("neg", "abs") else OPERATORS[name](x, y)


def program(record: Record, outputs: Sequence[int], varying: Collection[str]) -> Program:
    """The program that gives the entries ``outputs`` where the inputs ``varying`` vary from point to point."""
    needed = _needed(record, outputs)
    place = _Places(record, needed, varying)
    prologue, steps = [], []
    last = {p: n for n, e in enumerate(needed) for p in _operands(record, e)} | {p: len(needed) for p in outputs}
    for n, e in enumerate(needed):
        kind, operands = record.entries[e][0], _operands(record, e)
        if not operands:
            continue
        where = [place.of[p] for p in operands]
        if e in place.alike:
            prologue.append((KINDS[kind], place.new_scalar(e), where[0], where[-1]))
            continue
        to = place.new_row(e)
        steps.append((_code(kind, [p in place.alike for p in operands]), to, *_ordered(kind, operands, place)))
        place.free([p for p in set(operands) if last[p] == n and p not in place.alike])
    found = []
    for p in outputs:
        if p in place.alike:
            steps.append((Code.SPREAD, to := place.new_row(None), place.of[p], 0))
        found.append(to if p in place.alike else place.of[p])
    return Program(
        constants=tuple(place.constants),
        uniform=tuple(place.uniform),
        varying=tuple(place.varying),
        prologue=np.array(prologue, np.int32).reshape(-1, 4),
        steps=np.array(steps, np.int32).reshape(-1, 4),
        outputs=np.array(found, np.int32),
        scalars=place.scalars,
        rows=place.rows,
    )


class _Places:
    """Scalars and rows that hold entries."""

    def __init__(self, record: Record, needed: Iterable[int], varying: Collection[str]) -> None:
        of_kind: dict[str, list[int]] = {"constant": [], "uniform": [], "varying": []}
        self.alike: set[int] = set()
        for e in needed:
            kind, *rest = record.entries[e]
            if kind == "input":
                kind = "varying" if rest[0] in varying else "uniform"
            if kind in of_kind:
                of_kind[kind].append(e)
            if kind in ("constant", "uniform") or (
                kind != "varying" and all(p in self.alike for p in _operands(record, e))
            ):
                self.alike.add(e)
        self.constants, self.uniform, self.varying = (
            [record.entries[e][1] for e in of_kind[kind]] for kind in ("constant", "uniform", "varying")
        )
        self.of = {e: n for n, e in enumerate(of_kind["constant"] + of_kind["uniform"])}
        self.scalars, self.rows = len(self.of), len(self.varying)
        self.of |= {e: n for n, e in enumerate(of_kind["varying"])}
        self._free: list[int] = []

    def new_scalar(self, entry: int) -> int:
        self.of[entry] = self.scalars
        self.scalars += 1
        return self.of[entry]

    def new_row(self, entry: int | None) -> int:
        """A row that is free, the one used last first: it is in the nearest cache."""
        if not self._free:
            self._free.append(self.rows)
            self.rows += 1
        row = self._free.pop()
        if entry is not None:
            self.of[entry] = row
        return row

    def free(self, entries: Iterable[int]) -> None:
        self._free += [self.of[e] for e in entries]


def _needed(record: Record, outputs: Iterable[int]) -> list[int]:
    """The entries that outputs depend on, operands first."""
    found, open_ = set(), list(outputs)
    while open_:
        if (e := open_.pop()) not in found:
            found.add(e)
            open_ += _operands(record, e)
    return sorted(found)  # an entry stands after its operands


def _operands(record: Record, entry: int) -> tuple[int, ...]:
    kind, *rest = record.entries[entry]
    return () if kind in ("input", "constant") else tuple(rest)


def _code(kind: str, scalar: Sequence[bool]) -> Code:
    if not any(scalar):
        return KINDS[kind]
    return (OF_SCALAR if scalar[0] else WITH_SCALAR)[kind]


def _ordered(kind: str, operands: tuple[int, ...], place: _Places) -> tuple[int, int]:
    """Operands as the code wants them: sums and products have the scalar second."""
    first, second = operands[0], operands[-1]
    if first in place.alike and kind in "+*":
        first, second = second, first
    return place.of[first], place.of[second]
