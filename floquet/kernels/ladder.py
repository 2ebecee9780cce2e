"""How many panels a point needs, from its q alone.

They follow from the frequency √|q| and, for every harmonic n of amplitude a_n, from the terms (nh)^k of its Taylor
series.  The rule was fitted to what 18 000 random blades and Mathieu equations needed; points that need more go up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .primitives import select, sqrt

__all__ = ["LADDER", "PLACES", "amplitude", "first_rung", "wanted"]

Array = NDArray[np.float64]

#: Numbers of panels a turn of harmonic 1, by about an eighth.
LADDER = np.array([*range(2, 17), *(round(16 * 1.125**k) for k in range(1, 50))], np.int64)
PLACES = np.searchsorted(LADDER, np.arange(LADDER[-1] + 1)).astype(np.int16)  # of a number of panels on the ladder
COUNTABLE = 2.1  # panels a turn over √|q|: less than half a turn (π) of y each, so that its zeros are counted
FREQUENCY, HARMONIC, AMPLITUDE = 0.9, 1.1, 2.2


def amplitude(cosine: Any, sine: Any) -> Any:
    """Of a harmonic."""
    return sqrt(cosine * cosine + sine * sine)


def wanted(mean: Any, amplitudes: tuple[Any, ...], omega: float) -> Any:
    """Panels a turn, any number, for q of harmonics of frequency ω; numbers or arrays."""
    total, series = abs(mean), 0.0 * mean
    for k in range(len(amplitudes)):
        total = total + amplitudes[k]
        turns = (k + 1.0) * omega
        fitted = (k + 1.0) * (HARMONIC + AMPLITUDE * sqrt(sqrt((4.0 / (turns * turns)) * amplitudes[k])))
        series = select((amplitudes[k] > 0.0) & (fitted > series), fitted, series)
    frequency = sqrt(total) / omega
    one, other = COUNTABLE * frequency, FREQUENCY * frequency + series
    return select(one > other, one, other)


def first_rung(terms: Array, omega: float) -> NDArray[np.int16]:
    """Place on the ladder for q as terms (2H+1, n) in harmonics of frequency ω."""
    panels = wanted(terms[0], tuple(amplitude(terms[1::2], terms[2::2])), omega)
    top = float(len(PLACES) - 1)
    return PLACES[np.ceil(np.where(panels < top, panels, top)).astype(np.int64)]
