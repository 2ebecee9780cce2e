"""Hill forms of smooth equations, recorded from a model's own arithmetic and run compiled.

A model's :class:`~floquet.periodic.Equation` with a key is recorded once for each set of parameters that vary from case
to case, and of those that are 0 or 1 in all cases, which it then holds as numbers.  Recorded or not, every bit is the
same.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.ladder import first_rung
from ..periodic import TWO_PI, Equation, PeriodicMatrix, PeriodicSystem
from ..tape import Program, Record, UntraceableError, program
from .form import mean_growth, polynomial, term_size

__all__ = ["Smooth", "recorded", "smooth_form"]

Array = NDArray[np.float64]
FOLDED = (0.0, 1.0)  # products with them and sums with zero are left out, which changes no bit


class Smooth(NamedTuple):
    """A Hill form without kinks, for many points.

    ``terms`` (2H+1, n) of q, in harmonics of ``period``; ``size`` (n,) of the terms that q is made of, to which its
    rounding is relative; α (n,); the place on the ladder of panels (n,).
    """

    terms: Array
    period: float
    size: Array
    alpha: Array
    rung: NDArray[np.int16]

    @staticmethod
    def of(terms: Array, period: float, size: Array, alpha: Array) -> Smooth:
        """From the terms of q."""
        return Smooth(terms, period, size, alpha, first_rung(terms, TWO_PI / period))


def smooth_form(system: PeriodicSystem) -> Smooth | None:
    """The form of an equation by a compiled program; None for what cannot be recorded or has too many harmonics."""
    equation = system.equation
    if equation is None or equation.key is None or (tape := recorded(equation)) is None:
        return None
    from ..kernels.form import TERMS, hill_terms

    code, values = tape.program, equation.parameters
    if len(code.outputs) - 2 > TERMS:
        return None
    inputs = np.empty((len(code.varying), *equation.cases))
    for row, name in zip(inputs, code.varying, strict=True):
        row[:] = values[name]
    terms, (size, alpha), rung = hill_terms(
        code, inputs, [float(values[name]) for name in code.uniform], TWO_PI / tape.period
    )
    return Smooth(terms, tape.period, size, alpha, rung)


class Tape(NamedTuple):
    """A program whose outputs are the terms of q, in harmonics of ``period``, size and α."""

    program: Program
    period: float


@dataclass(frozen=True)
class _Variant:
    """What a tape follows from: the equation, parameters as numbers, names of those that vary."""

    key: Hashable
    folded: tuple[tuple[str, float], ...]
    varying: tuple[str, ...]
    names: tuple[str, ...] = field(compare=False)
    build: Callable[[Mapping[str, NDArray[Any]]], tuple[PeriodicMatrix, PeriodicMatrix]] = field(compare=False)


def recorded(equation: Equation) -> Tape | None:
    """The tape of an equation's Hill form; None where arithmetic depends on values (kinks, root cutouts)."""
    values = equation.parameters
    folded = tuple((name, v.flat[0].item()) for name, v in values.items() if _same(v) and v.flat[0] in FOLDED)
    constant = dict(folded)
    varying = tuple(name for name, v in values.items() if v.ndim and name not in constant)
    return _recorded(_Variant(equation.key, folded, varying, tuple(values), equation.build))


@lru_cache(256)
def _recorded(variant: _Variant) -> Tape | None:
    record, known = Record(), dict(variant.folded)
    symbols = {name: record.number(known[name]) if name in known else record.input(name) for name in variant.names}
    try:
        d, k = variant.build({name: _array(symbol) for name, symbol in symbols.items()})
        if k.edges is not None:
            return None
        q, alpha, size = polynomial(d, k), mean_growth(d), term_size(d, k)
    except UntraceableError:
        return None
    values = [*q.coefficients[0, 0, :, 0, 0], size.ravel()[0], np.ravel(alpha)[0]]
    return Tape(program(record, [record.place(v) for v in values], variant.varying), q.period)


def _same(values: Array) -> bool:
    """Whether there is one value."""
    if values.ndim == 0 or values.size < 2:
        return values.size > 0
    return bool(values.flat[0] == values.flat[-1] and np.all(values == values.flat[0]))


def _array(symbol: Any) -> NDArray[Any]:
    """One case."""
    out = np.empty(1, object)
    out[0] = symbol
    return out
