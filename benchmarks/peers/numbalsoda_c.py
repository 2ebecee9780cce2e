"""numbalsoda: DOP853 and LSODA in machine code, called point by point from a loop compiled by numba.

The right-hand sides are compiled too, for the processor at hand; the solvers are as the package's own build makes them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, cast

import numba
import numpy as np
from numba import carray  # type: ignore[attr-defined, unused-ignore]
from numbalsoda import dop853, lsoda, lsoda_sig
from numpy.typing import NDArray

from benchmarks.equations import TWO_PI, blade, exponents_from_full, multiblade
from benchmarks.peers import Call, Contender, written

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
SOLVERS = {"DOP853": dop853, "LSODA": lsoda}
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
SHOWN = (("DOP853", 1e-10), ("DOP853", 1e-12), ("LSODA", 1e-10))
Solve = Callable[[Array, Array, float, float], Array]


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        for tolerance in (1e-10, 1e-12):
            prepare = partial(RotorCall, blades=blades, tolerance=tolerance)
            yield Contender(name="numbalsoda DOP853", setting=written(tolerance), prepare=prepare)
        return
    for method, solver in SOLVERS.items():
        solve = compiled(solver, one_blade.address)
        for tolerance in TOLERANCES:
            yield Contender(
                name=f"numbalsoda {method}",
                setting=written(tolerance),
                prepare=partial(blade_call, solve=solve, tolerance=tolerance),
                batch=4096,
                shown=(method, tolerance) in SHOWN,
            )


@numba.cfunc(lsoda_sig)
def one_blade(psi: Any, y: Any, rate: Any, p: Any) -> None:
    """Both columns of the fundamental matrix."""
    sine, cosine = math.sin(psi), math.cos(psi)
    d = p[0] + p[1] * sine
    k = p[2] + p[3] * cosine + p[4] * sine + p[5] * (1 - 2 * sine * sine) + p[6] * (2 * sine * cosine)
    rate[0] = y[2]
    rate[1] = y[3]
    rate[2] = -d * y[2] - k * y[0]
    rate[3] = -d * y[3] - k * y[1]


def compiled(solver: Any, motion: Any) -> Solve:
    """All points, one after another: (points, parameters) and the start → the ends."""

    @numba.njit
    def solve(parameters: Array, start: Array, stop: float, tolerance: float) -> Array:
        ends = np.empty((len(parameters), len(start)))
        times = np.array([0.0, stop])
        for i in range(len(parameters)):
            found, success = solver(motion, start, times, parameters[i], tolerance, 1e-2 * tolerance)
            ends[i] = found[1]
            if not success:
                ends[i] = np.nan
        return ends

    return cast(Solve, solve)


def blade_call(points: Array, *, solve: Solve, tolerance: float) -> Call:
    coefficients, start = blade(points), np.eye(2).ravel()
    return lambda: exponents_from_full(solve(coefficients, start, TWO_PI, tolerance).reshape(-1, 2, 2))


class RotorCall:
    """N blades; keeps the right-hand side, of which the solver has the address only."""

    def __init__(self, points: Array, *, blades: int, tolerance: float) -> None:
        self.equations, self.tolerance = multiblade(points, blades), tolerance
        self.motion = rotor_motion(blades, self.equations.orders)
        self.solve = compiled(dop853, self.motion.address)
        terms = np.stack([self.equations.D, self.equations.K], axis=2).transpose(0, 3, 4, 2, 1)
        self.parameters, self.start = terms.reshape(len(points), -1), np.eye(2 * blades)

    def __call__(self) -> Complex:
        ends = self.solve(self.parameters, self.start.ravel(), self.equations.passage, self.tolerance)
        return self.equations.exponents(ends.reshape(-1, *self.start.shape))


def rotor_motion(blades: int, orders: tuple[int, ...]) -> Any:
    """x'' = -D x' - K x for 2N columns, D and K summed from their harmonics; sizes are constants to the compiler.

    There are one or two harmonics, and the second is twice the first.  Entries that are zero are passed over.
    """
    N, n, waves, first, two = blades, 2 * blades, 1 + 2 * len(orders), orders[0], len(orders) == 2

    @numba.cfunc(lsoda_sig, fastmath={"contract"})
    def motion(psi: Any, y: Any, rate: Any, p: Any) -> None:
        state, out, terms = carray(y, (n, n)), carray(rate, (n, n)), carray(p, (N, N, 2, waves))
        c1, s1 = math.cos(first * psi), math.sin(first * psi)
        c2, s2 = c1 * c1 - s1 * s1, 2.0 * s1 * c1
        for i in range(N):
            for c in range(n):
                out[i, c] = state[N + i, c]
                out[N + i, c] = 0.0
            for j in range(N):
                for m in range(2):
                    t = terms[i, j, m]
                    entry = t[0] + c1 * t[1] + s1 * t[2]
                    if two:
                        entry += c2 * t[3] + s2 * t[4]
                    if entry != 0.0:
                        for c in range(n):
                            out[N + i, c] -= entry * state[N * (1 - m) + j, c]

    return motion
