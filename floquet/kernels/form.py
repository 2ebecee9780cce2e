"""Terms of Hill forms from a program, with what follows from them at once: blocks of 256 points, compiled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..tape import Program
from . import ladder
from .compiler import inlined, kernel
from .hill_lanes import select
from .lanes import WIDTH, as_lanes, scratch
from .tape import run_prologue, run_steps

__all__ = ["TERMS", "hill_terms"]

Array = NDArray[np.float64]
LANES = 256
TERMS = 5  # of q, the most that compiled maps take


_wanted = inlined(ladder.wanted, fused=False, select=select, sqrt=math.sqrt)
_amplitude = inlined(ladder.amplitude, fused=False, sqrt=math.sqrt)


@kernel
def place_block(q: Any, omega: float, places: Any, out: Any) -> None:
    """Place on the ladder of a block of scratch: terms (5 rows) of q."""
    top = float(len(places) - 1)
    for i in range(LANES):
        first, second = _amplitude(q[LANES + i], q[2 * LANES + i]), _amplitude(q[3 * LANES + i], q[4 * LANES + i])
        panels = _wanted(q[i], (first, second), omega)
        out[i] = np.ceil(panels if panels < top else top)


@kernel
def _blocks(
    prologue: Any, steps: Any, outputs: Any, rows: int, s: Any, inputs: Any, omega: float, places: Any,
    terms: Any, others: Any, rung: Any,
) -> None:  # fmt: skip
    run_prologue(prologue, s)
    room = scratch(rows * (LANES // WIDTH)).reshape(rows, LANES)
    room[:] = 1.0
    r = as_lanes(room.reshape(rows, LANES // WIDTH, WIDTH))
    q, panels = np.zeros(TERMS * LANES), np.empty(LANES)
    harmonics, n = len(outputs) - 2, terms.shape[1]
    for start in range(0, n, LANES):
        count = min(LANES, n - start)
        for k in range(len(inputs)):
            room[k, :count] = inputs[k, start : start + count]
        run_steps(steps, s, r)
        for k in range(harmonics):
            q[k * LANES : (k + 1) * LANES] = room[outputs[k]]
        for k in range(TERMS):
            terms[k, start : start + count] = q[k * LANES : k * LANES + count]
        for k in range(2):
            others[k, start : start + count] = room[outputs[harmonics + k], :count]
        place_block(q, omega, places, panels)
        for i in range(count):
            rung[start + i] = places[int(panels[i])]


def hill_terms(
    program: Program, inputs: Array, uniform: list[float], omega: float
) -> tuple[Array, Array, NDArray[np.int16]]:
    """Terms of q (5, n), size and α (2, n), and the place on the ladder (n,).

    ``program`` gives up to five terms of q, in harmonics of frequency ω, then size and α, from the rows ``inputs``
    (k, n) and the scalars ``uniform``.
    """
    n = inputs.shape[1]
    scalars = np.zeros(max(program.scalars, 1))
    known = [c.double for c in program.constants] + uniform
    scalars[: len(known)] = known
    terms, others, rung = np.empty((TERMS, n)), np.empty((2, n)), np.empty(n, np.int16)
    _blocks(program.prologue, program.steps, program.outputs, program.rows, scalars, inputs, omega, ladder.PLACES,
            terms, others, rung)  # fmt: skip
    return terms, others, rung
