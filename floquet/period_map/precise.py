"""Next to branch points: maps in more digits than doubles have.

Where D is nearly zero an error δ of Φ is an error √δ of the exponents.  Such points are mapped again, from the
parameters as they are: in pairs of doubles (``pairs.py``) where that can be done compiled, and what is not settled by
them in integers (``integers.py``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..periodic import PeriodicSystem
from .integers import in_integers
from .pairs import in_pairs
from .result import Method, PeriodMap

__all__ = ["TOLERANCE", "make_precise"]

Array = NDArray[np.float64]
TOLERANCE = 1e-11  # bound of an exponent from which a point is mapped again
MOST_PANELS = 512  # in doubles; beyond, a point would take seconds


def make_precise(
    phi: PeriodMap, system: PeriodicSystem, left_out: NDArray[np.bool_] | None = None, *, compiled: bool = False
) -> PeriodMap:
    """``phi`` with the points near branch points mapped again, those that are ``left_out`` excepted."""
    assert phi.rows is not None
    index = np.flatnonzero(_doubtful(phi.rows, phi.period) & (phi.panels <= MOST_PANELS))
    if left_out is not None:
        index = index[~left_out[index]]
    if not index.size:
        return phi
    assert phi.methods is not None
    rows, methods = phi.rows.copy(), phi.methods.copy()
    methods[index] = Method.PRECISE
    if compiled and (found := in_pairs(system.part(index), phi.panels[index])) is not None:
        rows[:, index] = found
        index = index[_doubtful(found, phi.period) | (found[7] > 0.0)]
    if index.size:
        rows[:, index] = in_integers(system.part(index, exact=True), phi.panels[index])
    return replace(phi, rows=rows, methods=methods)


def _doubtful(rows: Array, period: float) -> NDArray[np.bool_]:
    """Whether the exponents of points have bounds above :data:`TOLERANCE`."""
    D, b = rows[8], rows[5]
    out = b * b > (TOLERANCE * period) ** 2 * np.abs(D)  # all of them, and some more
    D, b = D[out], b[out]
    bound = b / (period * (np.sqrt(np.abs(D)) + np.sqrt(b)) * np.sqrt(1.0 + np.maximum(D, 0.0)))
    out[out] = (bound > TOLERANCE) & np.isfinite(D)
    return np.asarray(out)
