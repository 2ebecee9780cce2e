"""The classical Runge–Kutta method with NumPy, all points at once and a fixed number of steps: the quick solution."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.equations import TWO_PI, blade, exponents_from_full
from benchmarks.peers import Call, Contender

Array = NDArray[np.float64]
STEPS = (100, 400, 1600)


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        return
    for steps in STEPS:
        yield Contender(
            name="NumPy RK4",
            setting=f"{steps} steps",
            prepare=partial(blade_call, steps=steps),
            batch=1024,
            shown=steps == max(STEPS),
        )


def blade_call(points: Array, *, steps: int) -> Call:
    h = TWO_PI / steps
    d0, d1, k0, c1, s1, c2, s2 = np.ascontiguousarray(blade(points).T)

    def rate(psi: float, y: Array) -> Array:
        sine, cosine = math.sin(psi), math.cos(psi)
        d = d0 + d1 * sine
        k = k0 + c1 * cosine + s1 * sine + c2 * (1 - 2 * sine * sine) + s2 * (2 * sine * cosine)
        return np.stack([y[1], -d * y[1] - k * y[0]])

    def call() -> NDArray[np.complex128]:
        y = np.repeat(np.eye(2)[:, :, None], len(d0), axis=2)  # (state, column, point)
        for psi in (i * h for i in range(steps)):
            a = rate(psi, y)
            b = rate(psi + h / 2, y + h / 2 * a)
            c = rate(psi + h / 2, y + h / 2 * b)
            y = y + h / 6 * (a + 2 * (b + c) + rate(psi + h, y + h * c))
        return exponents_from_full(y.transpose(2, 0, 1))

    return call
