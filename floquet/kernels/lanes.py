# mypy: disable-error-code="import-untyped, no-untyped-call, attr-defined"
"""Sixteen numbers as one: what the kernels of matrices are written in.

:func:`as_lanes` shows an array (..., 16) of doubles as an array (...) of ``Lanes``.  Inside kernels these are indexed,
added, multiplied and compared like numbers, sixteen cases at once, so that a kernel reads as the algorithm for one
matrix; the compiler makes of them the vector registers that the processor has.  A comparison gives a ``Mask``, and
:func:`where` chooses by it: every lane takes every step.

Loops over lanes say the same, but a compiler keeps their numbers in registers only where it can prove that no two
arrays overlap.  It cannot where a pattern of zeros says which rows are added, and products of small matrices then run
at a third of the speed.
"""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.typing import signature
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np import arrayobj
from numpy.typing import NDArray

from .compiler import inlined

__all__ = ["WIDTH", "aligned", "any_lane", "as_lanes", "scratch", "spread", "where"]

WIDTH = 16  # twice the widest registers: with one register a number, too few sums are under way at a time
FLAGS = ("contract",)  # as compiler.OPTIONS: a product and a sum may be fused


class Vector(types.Type):
    """``Lanes`` or ``Mask``, to numba."""


LANES, MASK = Vector("Lanes"), Vector("Mask")
DOUBLES, BITS = ir.VectorType(ir.DoubleType(), WIDTH), ir.VectorType(ir.IntType(1), WIDTH)


def _model(manager: Any, kind: Any) -> Any:
    return models.PrimitiveModel(manager, kind, DOUBLES if kind == LANES else BITS)


register_model(Vector)(_model)


# ---------------------------------------------------------------------- arrays
def _as_lanes(_: Any, array: Any) -> Any:
    """An array (..., 16), contiguous, as an array (...) of Lanes."""
    if array.layout != "C":
        raise TypingError("as_lanes takes contiguous arrays: use numpy.ascontiguousarray")
    seen = types.Array(LANES, array.ndim - 1, "C", aligned=False)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source = context.make_array(sig.args[0])(context, builder, args[0])
        out = context.make_array(seen)(context, builder)
        arrayobj.populate_array(
            out,
            data=builder.bitcast(source.data, context.get_data_type(LANES).as_pointer()),
            shape=[builder.extract_value(source.shape, i) for i in range(seen.ndim)],
            strides=[builder.extract_value(source.strides, i) for i in range(seen.ndim)],
            itemsize=context.get_constant(types.intp, 8 * WIDTH),
            meminfo=source.meminfo,
            parent=None,
        )
        return arrayobj.impl_ret_borrowed(context, builder, seen, out._getvalue())

    return signature(seen, array), code


as_lanes: Any = intrinsic(_as_lanes)


def aligned(shape: tuple[int, ...]) -> NDArray[np.float64]:
    """An empty array that starts where a line of the processor's cache does: loads of Lanes then touch one or two."""
    size = math.prod(shape)
    room = np.empty(size + 8)
    start = (-room.ctypes.data // 8) % 8
    return room[start : start + size].reshape(shape)


def _scratch(count: int) -> Any:
    """Room for ``count`` Lanes inside a kernel, aligned doubles (count, 16)."""
    room = np.empty(count * WIDTH + 8)
    start = (-room.ctypes.data // 8) % 8
    return room[start : start + count * WIDTH].reshape(count, WIDTH)


scratch: Any = inlined(_scratch)


# ---------------------------------------------------------------------- arithmetic
def _spread(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """A number in every lane; Lanes as they are."""
    if kind == LANES:
        return value
    first = ir.Constant(ir.IntType(32), 0)
    number = context.cast(builder, value, kind, types.float64)
    vector = builder.insert_element(ir.Constant(DOUBLES, ir.Undefined), number, first)
    return builder.shuffle_vector(vector, vector, ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH))


def _typed(function: Any, result: Any, *kinds: Any) -> None:
    """Tell numba that ``function`` of one or two Lanes (or of one and a number) is a ``result``."""

    def generic(_: Any, args: Any, kws: Any) -> Any:
        if not kws and kinds[0] in args and all(a in kinds or isinstance(a, types.Number) for a in args):
            return signature(result, *args)
        return None

    infer_global(function)(type("Rule", (AbstractTemplate,), {"generic": generic}))


def _two(function: Any, result: Any, make: Any) -> None:
    """An operator of two Lanes, or of Lanes and a number."""
    _typed(function, result, LANES)

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return make(builder, *(_spread(context, builder, k, v) for k, v in zip(sig.args, args, strict=True)))

    for kinds in ((LANES, LANES), (LANES, types.Number), (types.Number, LANES)):
        lower_builtin(function, *kinds)(code)


def _one(function: Any, name: str) -> None:
    """A function of one Lanes that LLVM has."""
    _typed(function, LANES, LANES)

    def code(_: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(DOUBLES, [DOUBLES])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{WIDTH}f64"), args)

    lower_builtin(function, LANES)(code)


def _arithmetic(name: str) -> Any:
    return lambda builder, x, y: getattr(builder, name)(x, y, flags=FLAGS)


def _comparison(sign: str) -> Any:
    ordered = sign != "!="
    return lambda builder, x, y: (builder.fcmp_ordered if ordered else builder.fcmp_unordered)(sign, x, y)


for _name, _operators in {
    "fadd": (operator.add, operator.iadd),
    "fsub": (operator.sub, operator.isub),
    "fmul": (operator.mul, operator.imul),
    "fdiv": (operator.truediv, operator.itruediv),
}.items():
    for _operator in _operators:
        _two(_operator, LANES, _arithmetic(_name))
for _sign, _operator in {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}.items():
    _two(_operator, MASK, _comparison(_sign))
for _sign, _operator in {"==": operator.eq, "!=": operator.ne}.items():
    _two(_operator, MASK, _comparison(_sign))
_one(abs, "llvm.fabs")
_one(math.sqrt, "llvm.sqrt")


# ---------------------------------------------------------------------- masks
for _name, _operator in {"and_": operator.and_, "or_": operator.or_}.items():
    _typed(_operator, MASK, MASK)
    lower_builtin(_operator, MASK, MASK)(lambda _c, builder, _s, args, name=_name: getattr(builder, name)(*args))
_typed(operator.invert, MASK, MASK)
lower_builtin(operator.invert, MASK)(lambda _c, builder, _s, args: builder.not_(args[0]))


def _where(_: Any, mask: Any, x: Any, y: Any) -> Any:
    """x in the lanes of the mask, y in the others."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        values = [_spread(context, builder, k, v) for k, v in zip(sig.args[1:], args[1:], strict=True)]
        return builder.select(args[0], *values)

    return signature(LANES, mask, x, y), code


def _spread_number(_: Any, number: Any) -> Any:
    """The number in every lane."""

    def code(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _spread(context, builder, sig.args[0], args[0])

    return signature(LANES, number), code


def _any_lane(_: Any, mask: Any) -> Any:
    """Whether the mask holds in any lane."""

    def code(_c: Any, builder: Any, _s: Any, args: Any) -> Any:
        word = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", word, ir.Constant(ir.IntType(WIDTH), 0))

    return signature(types.boolean, mask), code


where: Any = intrinsic(_where)
spread: Any = intrinsic(_spread_number)
any_lane: Any = intrinsic(_any_lane)
