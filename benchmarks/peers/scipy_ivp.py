"""SciPy's ``solve_ivp``, one point after another: what most people write."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.equations import TWO_PI, blade, exponents_from_full, multiblade
from benchmarks.peers import Call, Contender, written

Array = NDArray[np.float64]
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
SHOWN = (("DOP853", 1e-10), ("DOP853", 1e-12), ("LSODA", 1e-10))
ABSOLUTE = 1e-2  # of the relative tolerance


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        yield Contender(
            name="SciPy DOP853",
            setting=written(1e-10),
            prepare=partial(rotor_call, blades=blades, tolerance=1e-10),
            few=20,
        )
        return
    for method in ("DOP853", "LSODA"):
        for tolerance in TOLERANCES:
            yield Contender(
                name=f"SciPy {method}",
                setting=written(tolerance),
                prepare=partial(blade_call, method=method, tolerance=tolerance),
                shown=(method, tolerance) in SHOWN,
            )


def motion(
    psi: float, y: Array, d0: float, d1: float, k0: float, c1: float, s1: float, c2: float, s2: float
) -> list[float]:
    """Both columns of the fundamental matrix at once, in plain numbers: faster than small arrays."""
    sine, cosine = math.sin(psi), math.cos(psi)
    d = d0 + d1 * sine
    k = k0 + c1 * cosine + s1 * sine + c2 * (1 - 2 * sine * sine) + s2 * (2 * sine * cosine)
    return [y[1], -d * y[1] - k * y[0], y[3], -d * y[3] - k * y[2]]


def blade_call(points: Array, *, method: str, tolerance: float) -> Call:
    options: dict[str, Any] = {"method": method, "rtol": tolerance, "atol": ABSOLUTE * tolerance}
    rows = [tuple(row) for row in blade(points).tolist()]

    def end(row: tuple[float, ...]) -> Array:
        return np.asarray(solve_ivp(motion, (0.0, TWO_PI), [1.0, 0.0, 0.0, 1.0], args=row, **options).y[:, -1])

    return lambda: exponents_from_full(np.array([end(row) for row in rows]).reshape(-1, 2, 2).swapaxes(1, 2))


def rotor_call(points: Array, *, blades: int, tolerance: float) -> Call:
    equations, n = multiblade(points, blades), 2 * blades
    options: dict[str, Any] = {"method": "DOP853", "rtol": tolerance, "atol": ABSOLUTE * tolerance}
    A = equations.first_order().reshape(len(points), -1, n * n)

    def end(terms: Array) -> Array:
        def rate(psi: float, y: Array) -> Any:
            return ((equations.waves(psi) @ terms).reshape(n, n) @ y.reshape(n, n)).ravel()

        found = solve_ivp(rate, (0.0, equations.passage), np.eye(n).ravel(), **options)
        return np.asarray(found.y[:, -1]).reshape(n, n)

    return lambda: equations.exponents(np.array([end(terms) for terms in A]))
