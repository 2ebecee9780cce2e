"""Periodic systems with known answers, from the literature.

=======================  ==========================================================================================
mathieu                  y'' + c y' + (a - 2q cos 2t) y = 0, period π (NIST DLMF 28.2)
meissner                 y'' + c y' + (a + b s(t)) y = 0, s = +1 on a fraction of the period, then -1
hill_sawtooth            y'' + c y' + (a + b (1 - 2t/T)) y = 0 on [0, T), repeated
colaneri                 x' = [0 1; -10 cos t, -24 - 10 sin t] x, exponents 0 and -24 exactly
zhou_hagiwara            exponents -1, -2 over the period π; -1+2i, -2+2i over π/2: the branch depends on the period
bittanti_colaneri        x' = [-1+sin t, 0; 1-cos t, -3] x, exponents -1 and -3 exactly
rotating_frame           x' = (J + e^{Jt} F e^{-Jt}) x with e^{2πJ} = I: Φ(2π) = e^{2πF} for any F
=======================  ==========================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from ..periodic import TWO_PI, Equation, PeriodicMatrix, PeriodicSystem

__all__ = ["bittanti_colaneri", "colaneri", "hill_sawtooth", "mathieu", "meissner", "rotating_frame", "zhou_hagiwara"]


def mathieu(a: ArrayLike, q: ArrayLike, damping: ArrayLike = 0.0) -> PeriodicSystem:
    """Mathieu's equation with damping c; parameters broadcast; exponents per unit of t, modulo 2i."""

    def build(values: Mapping[str, NDArray[Any]]) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        stiffness = PeriodicMatrix.scalar(mean=values["a"], cosines=[-2 * values["q"]], period=math.pi)
        return PeriodicMatrix.scalar(mean=values["damping"], period=math.pi), stiffness

    given = {"a": a, "q": q, "damping": damping}
    parameters = {name: np.asarray(value, float) for name, value in given.items()}
    equation = Equation(build=build, parameters=parameters, key="mathieu")
    return PeriodicSystem(period=math.pi, equation=equation, coordinates=("y",), name="mathieu")


def meissner(
    a: ArrayLike, b: ArrayLike, damping: ArrayLike = 0.0, *, period: float = TWO_PI, fraction: float = 0.5
) -> PeriodicSystem:
    """Meissner's equation: stiffness a + b for ``fraction`` of the period, then a - b."""
    if not 0.0 < fraction < 1.0:
        raise ParameterError(
            "fraction", fraction, f"{fraction!r} is outside 0 … 1: it is the part of the period with stiffness a + b"
        )
    a, b = np.asarray(a, float), np.asarray(b, float)
    high, low = (PeriodicMatrix.scalar(mean=a + sign * b, period=period) for sign in (1.0, -1.0))
    return _scalar(PeriodicMatrix.pieces([high, low], [0.0, fraction * period, period]), damping, "meissner")


def hill_sawtooth(a: float, b: float, damping: float = 0.0, *, period: float = math.pi) -> PeriodicSystem:
    """Hill's equation with a sawtooth, state (y, y')."""

    def matrix(t: NDArray[np.float64]) -> NDArray[np.float64]:
        out = np.zeros((len(t), 2, 2))
        out[:, 0, 1], out[:, 1, 1] = 1.0, -damping
        out[:, 1, 0] = -(a + b * (1.0 - 2.0 * t / period))
        return out

    return PeriodicSystem.from_function(matrix, period, vectorised=True, coordinates=("y", "y'"), name="hill sawtooth")


def colaneri() -> PeriodicSystem:
    """Exponents 0 and -24 (P. Colaneri): multipliers 65 decades apart."""
    A = PeriodicMatrix.constant([[0.0, 1.0], [0.0, -24.0]]) + PeriodicMatrix.harmonic(
        1, [[0.0, 0.0], [-10.0, 0.0]], [[0.0, 0.0], [0.0, -10.0]]
    )
    return PeriodicSystem(period=TWO_PI, matrix=A, coordinates=("x_1", "x_2"), name="colaneri")


def zhou_hagiwara(period: float = math.pi) -> PeriodicSystem:
    """Zhou and Hagiwara's system, declared with period π or π/2."""

    def matrix(t: NDArray[np.float64]) -> NDArray[np.float64]:
        s2, c2, s4 = np.sin(2 * t) ** 2, np.cos(2 * t) ** 2, 0.5 * np.sin(4 * t)
        return np.stack([np.stack([-1 - s2, 2 - s4], -1), np.stack([-2 - s4, -1 - c2], -1)], -2)

    return PeriodicSystem.from_function(
        matrix, period, vectorised=True, coordinates=("x_1", "x_2"), name="zhou hagiwara"
    )


def bittanti_colaneri() -> PeriodicSystem:
    """A triangular system with exponents -1 and -3 (S. Bittanti and P. Colaneri)."""
    A = PeriodicMatrix.constant([[-1.0, 0.0], [1.0, -3.0]]) + PeriodicMatrix.harmonic(
        1, [[0.0, 0.0], [-1.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]
    )
    return PeriodicSystem(period=TWO_PI, matrix=A, coordinates=("x_1", "x_2"), name="bittanti colaneri")


def rotating_frame(F: ArrayLike) -> PeriodicSystem:
    """Truth built backwards: Φ(2π) = exp(2πF) exactly, for any real F (n, n) with n even.

    J turns the pairs (1, 2), (3, 4), … once, twice, … a period.
    """
    F = np.asarray(F, float)
    n = F.shape[-1]
    if n % 2:
        raise ParameterError("F", F.shape, f"F has {n} states: pairs are turned, so their number must be even")

    def turn(t: Any) -> NDArray[np.float64]:
        R = np.zeros((len(t), n, n))
        for k in range(n // 2):
            c, s = np.cos((k + 1) * t), np.sin((k + 1) * t)
            R[:, 2 * k, 2 * k], R[:, 2 * k, 2 * k + 1], R[:, 2 * k + 1, 2 * k], R[:, 2 * k + 1, 2 * k + 1] = c, -s, s, c
        return R

    J = np.zeros((n, n))
    for k in range(n // 2):
        J[2 * k, 2 * k + 1], J[2 * k + 1, 2 * k] = -(k + 1.0), k + 1.0

    def matrix(t: NDArray[np.float64]) -> NDArray[np.float64]:
        R = turn(t)
        return J + R @ F @ np.swapaxes(R, -1, -2)

    return PeriodicSystem.from_function(matrix, TWO_PI, vectorised=True, name="rotating frame")


def _scalar(stiffness: PeriodicMatrix, damping: ArrayLike, name: str) -> PeriodicSystem:
    D = PeriodicMatrix.scalar(mean=damping, period=stiffness.period)
    return PeriodicSystem(period=stiffness.period, damping=D, stiffness=stiffness, coordinates=("y",), name=name)
