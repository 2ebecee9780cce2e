"""The contenders, ours among them: one module each, which imports its library when it is asked for contenders.

A contender turns points into exponents in its natural way.  ``prepare(points)`` does what is not timed (coefficients,
compiling, memory) and gives the call that is; ours has nothing to prepare and is timed from the parameters on.
"""

from __future__ import annotations

import functools
import importlib
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = ["MODULES", "Call", "Contender", "contenders", "skip", "written"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Call: TypeAlias = Callable[[], Complex]
MODULES = ("ours", "heyoka_taylor", "numbalsoda_c", "diffrax_vmap", "scipy_ivp", "numpy_rk4")


@dataclass(frozen=True, kw_only=True)
class Contender:
    """A library and the setting it is run with.

    Attributes
    ----------
    name, setting : str
    prepare : callable
        points → the timed call, which gives their exponents (points, states).
    batch : int
        Points of a large call; 0 where a user calls point by point and more of them change nothing.
    few : int
        At most so many of the 200 blades are timed, because it is slow.
    shown : bool
        Whether it has a row in the table; else it is in the figure alone.
    answers : bool
        Whether the call gives exponents; else it shows what something costs.
    """

    name: str
    setting: str
    prepare: Callable[[Array], Call]
    batch: int = 0
    few: int = 200
    shown: bool = True
    answers: bool = True


def contenders(blades: int = 1, modules: Sequence[str] = MODULES) -> Iterator[Contender]:
    """Everybody that is installed and takes part, for one blade or for N in the non-rotating frame."""
    for name in modules:
        try:
            yield from importlib.import_module(f"benchmarks.peers.{name}").contenders(blades)
        except ImportError as error:
            skip(error.name or name)


@functools.cache
def skip(name: str) -> None:
    """Say once that a peer is missing."""
    print(f"SKIPPED {name}: it is not installed; benchmarks/README.md says what it needs", file=sys.stderr, flush=True)


def written(tolerance: float) -> str:
    """``1e-8``; the smallest that makes sense is ``eps``."""
    return f"{tolerance:.0e}".replace("e-0", "e-") if tolerance else "eps"
