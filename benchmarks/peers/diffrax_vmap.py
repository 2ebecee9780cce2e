"""diffrax: ``diffeqsolve`` of one point, mapped over all by ``jax.vmap`` and compiled, in double precision."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from benchmarks.equations import TWO_PI, blade, exponents_from_full
from benchmarks.peers import Call, Contender, written

Array = NDArray[np.float64]
TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
FIRST_STEP, MOST_STEPS = 0.05, 100_000


def contenders(blades: int) -> Iterator[Contender]:
    if blades > 1:
        return
    for tolerance in TOLERANCES:
        yield Contender(
            name="diffrax Dopri8",
            setting=written(tolerance),
            prepare=partial(blade_call, tolerance=tolerance),
            batch=4096,
            shown=tolerance == 1e-10,
        )


def motion(psi: Any, y: Any, row: Any) -> Any:
    """Both columns of the fundamental matrix, as (state, column)."""
    sine, cosine = jnp.sin(psi), jnp.cos(psi)
    d = row[0] + row[1] * sine
    k = row[2] + row[3] * cosine + row[4] * sine + row[5] * (1 - 2 * sine * sine) + row[6] * (2 * sine * cosine)
    return jnp.stack([y[1], -d * y[1] - k * y[0]])


def blade_call(points: Array, *, tolerance: float) -> Call:
    control = diffrax.PIDController(rtol=tolerance, atol=1e-2 * tolerance)

    def monodromy(row: Any) -> Any:
        return diffrax.diffeqsolve(
            diffrax.ODETerm(motion), diffrax.Dopri8(), 0.0, TWO_PI, FIRST_STEP, jnp.eye(2), args=row,
            stepsize_controller=control, saveat=diffrax.SaveAt(t1=True), max_steps=MOST_STEPS,
        ).ys[0]  # fmt: skip

    compiled, rows = jax.jit(jax.vmap(monodromy)), jnp.asarray(blade(points))
    if rows.dtype != jnp.float64:
        raise RuntimeError("jax computes in single precision: set JAX_ENABLE_X64=1 before it is imported")
    return lambda: exponents_from_full(np.asarray(compiled(rows)))
