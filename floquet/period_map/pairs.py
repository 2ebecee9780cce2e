"""Hill forms in pairs of doubles: 31 digits, compiled, for smooth equations that are recorded."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..kernels.hill import ROWS
from ..periodic import PI, TWO_PI, Equation, PeriodicSystem
from .integers import ONE, cosine_and_sine, exact_ratio, fixed, powers
from .recorded import FOLDED, Tape, recorded

__all__ = ["in_pairs"]

Array = NDArray[np.float64]
TERMS = 5  # of q, the most
#: Numbers of panels: few, so that points share blocks of lanes, which take as long for one as for sixteen.
STEPS = np.array([panels for k in range(1, 10) for panels in (2**k, 3 * 2 ** (k - 1))])


def in_pairs(part: PeriodicSystem, panels: NDArray[np.int32]) -> Array | None:
    """Rows (:data:`~floquet.kernels.hill.ROWS`) of cases along one axis, with so many panels; None without an equation.

    Cases that are not recorded count as not resolved.
    """
    equation = part.equation
    if equation is None or equation.key is None:
        return None
    from ..kernels.doubled import map_pairs

    out, counts = np.zeros((len(ROWS), len(panels))), STEPS[np.searchsorted(STEPS, panels)]
    out[ROWS.index("unresolved")] = 1.0
    for kind in _kinds(equation, len(panels)):
        alike = part.part(kind)
        assert alike.equation is not None
        tape = recorded(alike.equation)
        if tape is None or len(tape.program.outputs) - 2 > TERMS:
            continue
        q, size = _terms(alike, tape, len(kind))
        for count in np.unique(counts[kind]).tolist():
            some = np.flatnonzero(counts[kind] == count)
            rows, half = np.empty((len(ROWS), len(some))), 0.5 * part.period / count
            tables = _tables(count, part.period, tape.period)
            map_pairs(np.ascontiguousarray(q[..., some]), size[some], *tables, half, rows)
            out[:, kind[some]] = rows
    return out


def _kinds(equation: Equation, n: int) -> list[NDArray[np.intp]]:
    """The cases whose parameters are 0 and 1 in the same places, and so have one tape, whatever stands beside them.

    A blade with a root cutout has none; and the last digits may depend on what a tape holds as numbers.
    """
    values = [np.broadcast_to(v, n) for v in equation.parameters.values()]
    kinds = np.stack([np.select([v == x for x in FOLDED], FOLDED, 2.0) for v in values])
    _, which = np.unique(kinds, axis=1, return_inverse=True)
    return [np.flatnonzero(which.ravel() == k) for k in range(int(which.max()) + 1)]


def _terms(part: PeriodicSystem, tape: Tape, n: int) -> tuple[Array, Array]:
    """The terms of q (5, 2, n), and their size (n,)."""
    from ..kernels.pairs import run_pairs

    assert part.equation is not None
    code, values = tape.program, part.equation.parameters
    scalars, rows = np.zeros((max(code.scalars, 1), 2)), np.zeros((code.rows, 2, n))
    for k, constant in enumerate(code.constants):
        scalars[k] = _pair(constant.exact)
    for k, name in enumerate(code.uniform, start=len(code.constants)):
        scalars[k, 0] = values[name]
    for k, name in enumerate(code.varying):
        rows[k, 0] = values[name]
    run_pairs(code.prologue, code.steps, scalars, rows)
    q = np.zeros((TERMS, 2, n))
    for k, row in enumerate(code.outputs[:-2]):
        q[k] = rows[row]
    return q, rows[code.outputs[-2], 0]


@lru_cache(512)
def _tables(panels: int, period: float, turn: float) -> tuple[Array, Array, Array]:
    """Pairs of cos and sin at the centres (panels, 4, 2), ∓h² (nωh)^k/k! (2 K, 2), and 1/((k+1)(k+2)) (K, 2)."""
    from ..kernels.doubled import ORDER

    ratio, angle = exact_ratio(period / turn), 2 * PI / exact_ratio(TWO_PI / turn)
    half = ratio / (2 * panels)  # in turns of harmonic 1
    square = Fraction(fixed((half * angle) ** 2), ONE)
    cosines = [[_pair(Fraction(x, ONE)) for n in (1, 2) for x in cosine_and_sine(n * (2 * s + 1) * half)]
               for s in range(panels)]  # fmt: skip
    terms = [powers(n * half) for n in (1, 2)]
    weights = []
    for k in range(ORDER - 1):
        for series in terms:
            value = square * Fraction(series[k] if k < len(series) else 0, ONE)
            weights.append(_pair(-value if k % 4 < 2 else value))
    inverse = [_pair(Fraction(1, (k + 1) * (k + 2))) for k in range(ORDER - 1)]
    return np.array(cosines), np.array(weights), np.array(inverse)


def _pair(x: Fraction) -> tuple[float, float]:
    """Head and tail of a number."""
    head = float(x)
    return head, float(x - Fraction(head))
