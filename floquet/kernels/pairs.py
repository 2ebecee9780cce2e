# mypy: disable-error-code="import-untyped, no-untyped-call, attr-defined"
"""Numbers as pairs of doubles, head and tail, with 31 digits; and programs (:mod:`floquet.tape`) run on them.

Sums and products of doubles are known without error (Knuth's; Dekker's by a fused multiply-add), so kernels of pairs
must not let the compiler fuse anything of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import types
from numba.core.typing import signature
from numba.extending import intrinsic

from ..tape import Code
from .compiler import inlined, unfused_kernel

__all__ = ["accumulated", "added", "divided", "multiplied", "negative", "normal", "pure", "run_pairs", "scaled"]

ADD, SUB, MUL, DIV, NEG, ABS, ADD_S, SUB_S, S_SUB, MUL_S, DIV_S, S_DIV, SPREAD = (int(code) for code in Code)
F = TypeVar("F", bound=Callable[..., Any])


def pure(function: F) -> F:
    """Inlined, and rounded as it is written."""
    return inlined(function, fused=False)


def _multiply_add(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once."""

    def generate(context: Any, builder: Any, given: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return signature(types.float64, types.float64, types.float64, types.float64), generate


multiply_add: Any = intrinsic(_multiply_add)


@pure
def exact_sum(a: float, b: float) -> Any:
    """a + b and its error."""
    s = a + b
    back = s - a
    return s, (a - (s - back)) + (b - back)


@pure
def normal(a: float, b: float) -> Any:
    """The pair of |a| ≥ |b|."""
    s = a + b
    return s, b - (s - a)


@pure
def added(a: Any, b: Any) -> Any:
    s, e = exact_sum(a[0], b[0])
    t, f = exact_sum(a[1], b[1])
    s, e = normal(s, e + t)
    return normal(s, e + f)


@pure
def negative(a: Any) -> Any:
    return -a[0], -a[1]


@pure
def multiplied(a: Any, b: Any) -> Any:
    p = a[0] * b[0]
    e = multiply_add(a[0], b[0], -p)
    return normal(p, e + (a[0] * b[1] + a[1] * b[0]))


@pure
def accumulated(total: Any, a: Any, b: Any) -> Any:
    """total + a b of a long sum: its tail gathers what heads lose, and is brought in by :func:`normal` at the end."""
    p = a[0] * b[0]
    s, e = exact_sum(total[0], p)
    return s, total[1] + (e + (multiply_add(a[0], b[0], -p) + (a[0] * b[1] + a[1] * b[0])))


@pure
def scaled(a: Any, factor: float) -> Any:
    """A pair times a double."""
    p = a[0] * factor
    return normal(p, multiply_add(a[0], factor, -p) + a[1] * factor)


@pure
def divided(a: Any, b: Any) -> Any:
    first = a[0] / b[0]
    rest = added(a, negative(scaled(b, first)))
    second = rest[0] / b[0]
    rest = added(rest, negative(scaled(b, second)))
    s, e = normal(first, second)
    return added((s, e), (rest[0] / b[0], 0.0))


@pure
def operated(code: int, a: Any, b: Any) -> Any:
    """One instruction, whichever kinds its operands are of."""
    if code in (ADD, ADD_S):
        return added(a, b)
    if code in (SUB, SUB_S, S_SUB):
        return added(a, negative(b))
    if code in (MUL, MUL_S):
        return multiplied(a, b)
    if code in (DIV, DIV_S, S_DIV):
        return divided(a, b)
    if code == NEG or (code == ABS and a[0] < 0.0):
        return negative(a)
    return a


@unfused_kernel
def run_pairs(prologue: Any, steps: Any, scalars: Any, rows: Any) -> None:
    """A program on scalars (scalars, 2) and rows (rows, 2, n)."""
    for code, to, a, b in prologue:
        scalars[to, 0], scalars[to, 1] = operated(code, (scalars[a, 0], scalars[a, 1]), (scalars[b, 0], scalars[b, 1]))
    for code, to, a, b in steps:
        for i in range(rows.shape[2]):
            if code in (S_SUB, S_DIV, SPREAD):
                x = (scalars[a, 0], scalars[a, 1])
            else:
                x = (rows[a, 0, i], rows[a, 1, i])
            if code in (ADD_S, SUB_S, MUL_S, DIV_S):
                y = (scalars[b, 0], scalars[b, 1])
            elif code == SPREAD:
                y = x
            else:
                y = (rows[b, 0, i], rows[b, 1, i])
            rows[to, 0, i], rows[to, 1, i] = operated(code, x, y)
