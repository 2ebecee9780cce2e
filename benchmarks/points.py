"""The blades that are measured, their exponents to thirty digits, and the distance of computed exponents from those.

A point is (γ, ε, κ, K₁, μ), uniform in RANGES.  Accuracy is measured on the 200 blades of data/reference/benchmark.json
(written by :mod:`benchmarks.truth`); large batches are more blades from the same ranges.
"""

from __future__ import annotations

import functools
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["COUNT", "NAMES", "RANGES", "SEED", "STORED", "draw", "errors", "stored", "truth_of_rotor"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
NAMES = ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling", "advance_ratio")
RANGES = ((2.0, 16.0), (0.0, 0.2), (0.0, 0.5), (-0.5, 0.5), (0.0, 1.0))
STORED = Path(__file__).resolve().parents[1] / "data" / "reference" / "benchmark.json"
SEED, COUNT = 200, 200


def draw(count: int, seed: int) -> Array:
    """(count, 5) random blades, to six decimals so that a file can hold them."""
    low, high = np.array(RANGES).T
    return np.round(np.random.default_rng(seed).uniform(low, high, (count, len(RANGES))), 6)


@functools.cache
def stored() -> tuple[Array, NDArray[np.clongdouble]]:
    """The 200 blades (200, 5) and their exponents (200, 2), in long double where the machine has one."""
    rows = json.loads(STORED.read_text(encoding="utf-8"))["blades"]
    parts = np.array([[np.longdouble(text) for text in row[len(NAMES) :]] for row in rows])
    exponents = parts[:, ::2].astype(np.clongdouble) + 1j * parts[:, 1::2]
    return np.array([row[: len(NAMES)] for row in rows]), exponents


def truth_of_rotor(blades: int) -> NDArray[np.clongdouble]:
    """(200, 2N) exponents of N such blades in the non-rotating frame: the blade's + ik, modulo iN."""
    exponents = stored()[1]
    return (exponents[:, None, :] + 1j * np.arange(blades)[:, None]).reshape(len(exponents), -1)


def errors(found: Complex, truth: NDArray[np.clongdouble], strip: float) -> Array:
    """(points,) the largest distance within a point's set of exponents, at the best pairing; Im is known modulo strip.

    A point without an answer is infinitely far.
    """
    apart = found[:, :, None] - truth[:, None, :]
    distance = np.hypot(apart.real, apart.imag - strip * np.round(apart.imag / strip)).astype(float)
    distance = np.where(np.isfinite(distance), distance, np.inf)
    if found.shape[1] == 2:
        straight = np.maximum(distance[:, 0, 0], distance[:, 1, 1])
        return np.minimum(straight, np.maximum(distance[:, 0, 1], distance[:, 1, 0]))
    from scipy.optimize import linear_sum_assignment  # late, so that it is in nobody's start-up time

    finite = np.minimum(distance, 1e6)  # the assignment takes no infinities
    return np.array([d[linear_sum_assignment(f)].max() for d, f in zip(distance, finite, strict=True)])
