"""heyoka: Taylor's method compiled for the very equations, eight points in the lanes of one register.

Blade and Hill form are both given, because the Hill form is as open to a user of heyoka as it is to us.  What the
Python loop over batches costs by itself has a row of its own.  Batches of 16 to 64 lanes were 3 to 45 % slower, and the
compact mode by 35 to 90 %; the ensemble functions copy the integrator for every batch, which takes forty times as long
as the integration.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from benchmarks.equations import (
    TWO_PI,
    blade,
    exponents_from_full,
    exponents_from_hill,
    hill,
    multiblade,
)  # fmt: skip
from benchmarks.peers import Call, Contender, written

Array = NDArray[np.float64]
LANES = 8
TOLERANCES = (1e-6, 1e-8, 1e-10, 0.0)
SHOWN = (1e-10, 0.0)
BATCH = 4096


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        for tolerance in SHOWN:
            prepare = partial(rotor_call, blades=blades, tolerance=tolerance)
            yield Contender(name="heyoka", setting=written(tolerance), prepare=prepare)
        return
    for form, make in (("as written", blade_call), ("Hill form", hill_call)):
        for tolerance in TOLERANCES:
            yield Contender(
                name=f"heyoka, {form}",
                setting=written(tolerance),
                prepare=partial(make, tolerance=tolerance),
                batch=BATCH,
                shown=tolerance in SHOWN,
            )
    yield Contender(
        name="heyoka",
        setting="Python loop alone",
        prepare=idle_call,
        batch=BATCH,
        answers=False,
    )


def blade_call(points: Array, *, tolerance: float) -> Call:
    """β'' + d β' + k β = 0."""
    p, sine, cosine = hy.par, hy.sin(hy.time), hy.cos(hy.time)
    d = p[0] + p[1] * sine
    k = p[2] + p[3] * cosine + p[4] * sine + p[5] * (1.0 - 2.0 * sine * sine) + p[6] * (2.0 * sine * cosine)
    y, v = columns(1)
    equations = [*zip(y, v, strict=True), *((v[c], -d * v[c] - k * y[c]) for c in range(2))]
    solve = Batches(equations, blade(points), TWO_PI, tolerance)
    return lambda: exponents_from_full(solve())


def hill_call(points: Array, *, tolerance: float) -> Call:
    """y'' + q y = 0, β = exp(-½∫d) y."""
    solve, damping = hill_batches(points, tolerance), blade(points)[:, 0]
    return lambda: exponents_from_hill(solve(), damping)


def idle_call(points: Array) -> Call:
    """The loop over batches without its integration."""
    solve, damping = hill_batches(points, 0.0), blade(points)[:, 0]
    return lambda: exponents_from_hill(solve(0.0), damping)


def hill_batches(points: Array, tolerance: float) -> Batches:
    p, sine, cosine = hy.par, hy.sin(hy.time), hy.cos(hy.time)
    q = p[0] + p[1] * cosine + p[2] * sine + p[3] * (1.0 - 2.0 * sine * sine) + p[4] * (2.0 * sine * cosine)
    y, v = columns(1)
    equations = [*zip(y, v, strict=True), *((v[c], -q * y[c]) for c in range(2))]
    return Batches(equations, hill(blade(points)), TWO_PI, tolerance)


def rotor_call(points: Array, *, blades: int, tolerance: float) -> Call:
    """x'' + D x' + K x = 0 for 2N columns; a parameter for every coefficient that is not zero at all points."""
    equations, N, n = multiblade(points, blades), blades, 2 * blades
    waves = [f(float(h) * hy.time) for h in equations.orders for f in (hy.cos, hy.sin)]
    parameters: list[Array] = []

    def entry(terms: Array) -> Any:
        """A trigonometric polynomial from its harmonics (points, 1 + 2 orders)."""
        total = []
        for wave, column in zip([None, *waves], terms.T, strict=True):
            if np.any(column):
                parameters.append(column)
                factor = hy.par[len(parameters) - 1]
                total.append(factor if wave is None else factor * wave)
        return hy.sum(total) if total else None

    D, K = ([[entry(M[:, :, i, j]) for j in range(N)] for i in range(N)] for M in (equations.D, equations.K))
    x, v = columns(N)
    system = list(zip(x, v, strict=True))
    for i in range(N):
        for c in range(n):
            forces = [a * y[j * n + c] for M, y in ((D, v), (K, x)) for j, a in enumerate(M[i]) if a is not None]
            system.append((v[i * n + c], -hy.sum(forces)))
    solve = Batches(system, np.stack(parameters, axis=-1), equations.passage, tolerance)
    return lambda: equations.exponents(solve())


def columns(blades: int) -> tuple[list[Any], list[Any]]:
    """Coordinates and rates of 2N columns, row by row."""
    names = [f"{i}_{c}" for i in range(blades) for c in range(2 * blades)]
    return [hy.expression(f"x{name}") for name in names], [hy.expression(f"v{name}") for name in names]


class Batches:
    """The fundamental matrices of all points, eight at a time."""

    def __init__(self, system: list[Any], parameters: Array, stop: float, tolerance: float) -> None:
        points, count = parameters.shape
        self.points, self.stop, self.n = points, stop, round(len(system) ** 0.5)
        padded = np.concatenate([parameters, np.repeat(parameters[-1:], -points % LANES, axis=0)])
        self.batches = np.ascontiguousarray(padded.reshape(-1, LANES, count).swapaxes(1, 2))
        self.start = np.repeat(np.eye(self.n).reshape(-1, 1), LANES, axis=1)
        self.integrator = hy.taylor_adaptive_batch(
            system, self.start.copy(), pars=self.batches[0].copy(), tol=tolerance, compact_mode=False
        )
        self.ends = np.empty((len(self.batches), self.n**2, LANES))

    def __call__(self, stop: float | None = None) -> Array:
        integrator, state, parameters = self.integrator, self.integrator.state, self.integrator.pars
        stop = self.stop if stop is None else stop
        for values, end in zip(self.batches, self.ends, strict=True):
            integrator.set_time(0.0)
            state[:] = self.start
            parameters[:] = values
            integrator.propagate_until(stop)
            end[:] = state
        return self.ends.swapaxes(1, 2).reshape(-1, self.n, self.n)[: self.points]
