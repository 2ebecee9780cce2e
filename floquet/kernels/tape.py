"""Programs (:mod:`floquet.tape`) run on blocks of points: an instruction at a time, for all points of a block.

A block's rows stay in the nearest cache, and an instruction is read once for all its points.
"""

from __future__ import annotations

from typing import Any

from ..tape import Code
from .compiler import kernel
from .lanes import spread

__all__ = ["run_prologue", "run_steps"]

ADD, SUB, MUL, DIV, NEG, ABS, ADD_S, SUB_S, S_SUB, MUL_S, DIV_S, S_DIV, SPREAD = (int(code) for code in Code)


@kernel
def run_prologue(prologue: Any, s: Any) -> None:
    """Instructions among scalars s."""
    for code, to, a, b in prologue:
        if code == ADD:
            s[to] = s[a] + s[b]
        elif code == SUB:
            s[to] = s[a] - s[b]
        elif code == MUL:
            s[to] = s[a] * s[b]
        elif code == DIV:
            s[to] = s[a] / s[b]
        elif code == NEG:
            s[to] = -s[a]
        else:
            s[to] = abs(s[a])


@kernel
def run_steps(steps: Any, s: Any, r: Any) -> None:
    """Instructions among rows r (rows, Lanes) and scalars s."""
    width = r.shape[1]
    for n in range(len(steps)):
        code, to, a, b = steps[n, 0], steps[n, 1], steps[n, 2], steps[n, 3]
        if code == ADD:
            for k in range(width):
                r[to, k] = r[a, k] + r[b, k]
        elif code == SUB:
            for k in range(width):
                r[to, k] = r[a, k] - r[b, k]
        elif code == MUL:
            for k in range(width):
                r[to, k] = r[a, k] * r[b, k]
        elif code == DIV:
            for k in range(width):
                r[to, k] = r[a, k] / r[b, k]
        elif code == NEG:
            for k in range(width):
                r[to, k] = -1.0 * r[a, k]
        elif code == ABS:
            for k in range(width):
                r[to, k] = abs(r[a, k])
        elif code == ADD_S:
            for k in range(width):
                r[to, k] = r[a, k] + s[b]
        elif code == SUB_S:
            for k in range(width):
                r[to, k] = r[a, k] - s[b]
        elif code == S_SUB:
            for k in range(width):
                r[to, k] = s[a] - r[b, k]
        elif code == MUL_S:
            for k in range(width):
                r[to, k] = r[a, k] * s[b]
        elif code == DIV_S:
            for k in range(width):
                r[to, k] = r[a, k] / s[b]
        elif code == S_DIV:
            for k in range(width):
                r[to, k] = s[a] / r[b, k]
        else:
            for k in range(width):
                r[to, k] = spread(s[a])
