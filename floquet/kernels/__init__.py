"""Everything compiled: arrays in, arrays out; no rotor, no system, no file.

Arithmetic is written once, in functions of numbers that take arrays as well: NumPy runs them on arrays (a value a
point), and the lane loops that numba compiles run them on the numbers of one point (structure of arrays, the points
innermost, so that a compiler makes wide registers of them).  Both give the same answers up to the rounding of fused
multiply-adds.

numba is loaded by the first call that has points enough to be worth its second of start-up (:data:`POINTS`); not at all
when it is not installed or the environment variable ``FLOQUET_NO_NUMBA`` is set.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache

import numpy as np

__all__ = ["POINTS", "available", "cores", "keep_memory", "part_of", "worth_compiling"]

#: From this many points on compiled kernels are used: NumPy would take about as long as numba takes to load.
POINTS = 1024


@cache
def available() -> bool:
    """Whether compiled kernels can be used."""
    return os.environ.get("FLOQUET_NO_NUMBA", "") in ("", "0") and importlib.util.find_spec("numba") is not None


_MANY: ContextVar[bool] = ContextVar("many points", default=False)


def worth_compiling(points: int) -> bool:
    """Whether so many points go to the compiled kernels; by their number alone, so that answers do not vary."""
    return (points >= POINTS or _MANY.get()) and available()


@contextmanager
def part_of(points: int) -> Iterator[None]:
    """What is solved herein, in this thread, is a part of so many points, and has the last digits that they have."""
    before = _MANY.set(_MANY.get() or points >= POINTS)
    try:
        yield
    finally:
        _MANY.reset(before)


def cores() -> int:
    """Threads to use: ``FLOQUET_THREADS``, or as many as this process may run on."""
    asked = os.environ.get("FLOQUET_THREADS", "")
    if asked.isdigit() and int(asked) > 0:
        return int(asked)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def keep_memory() -> None:
    """Have the C library keep freed memory, where it is glibc.

    By default it returns the memory of every larger array to the system, and fresh pages cost more than the arithmetic
    in them: twice the time for a chunk of points.  Its threshold follows the largest block that was ever freed.
    """
    np.zeros(3_900_000)[::512] = 1.0  # just below 32 MB, the most the threshold follows
