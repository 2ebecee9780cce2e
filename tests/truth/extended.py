"""Exponents of eq. (1) in extended precision (80-bit long double), many blades at once.

β'' + d β' + k β = 0 with the coefficients of :mod:`tests.truth.closed_forms` is integrated as it is, not in Hill
form, by its Taylor series about the start of each of 120 steps: truncation below 1e-20, rounding about 1e-19 a step.
The multipliers of the 2×2 monodromy matrix follow from its trace and from Liouville's determinant, exp(-2π c0).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.truth import closed_forms

Long = NDArray[np.longdouble]
PI = np.longdouble("3.14159265358979323846264338327950288")
STEPS, ORDER = 120, 24


def available() -> bool:
    """Whether long double is longer than double on this machine."""
    return bool(np.finfo(np.longdouble).eps < 1e-18)


def exponents(gamma: Any, eps: Any, kappa: Any, K1: Any, mu: Any, m: Any) -> tuple[NDArray[np.complex128], Long]:
    """(cases, 2) principal exponents (Im in (-1/2, 1/2]) and the scaled discriminant (tr/2)²/det - 1."""
    values = [np.asarray(x, np.longdouble) for x in (gamma, eps, kappa, K1, mu, m)]
    c = closed_forms.truncated(values[0], values[1], values[2], values[3], values[4], values[5])
    h = 2 * PI / STEPS
    state = [[np.ones_like(values[0]), np.zeros_like(values[0])], [np.zeros_like(values[0]), np.ones_like(values[0])]]
    for step in range(STEPS):
        d, k = _series(c, step * h, h)
        state = [_advance(d, k, y, rate, h) for y, rate in state]
    scale = np.exp(PI * c["c0"])  # 1/√det
    tau = (state[0][0] + state[1][1]) / 2 * scale
    half = (state[0][0] - state[1][1]) / 2 * scale
    D = half * half + state[1][0] * state[0][1] * scale * scale
    root = np.sqrt(np.abs(D))
    growth = np.where(D > 0, np.arcsinh(root), 0) / (2 * PI)
    turn = np.where(D > 0, np.where(tau < 0, PI, 0), np.arctan2(root, tau)) / (2 * PI)
    alpha = -c["c0"] / 2
    first = (alpha + growth).astype(float) + 1j * turn.astype(float)
    second = (alpha - growth).astype(float) + 1j * np.where(D > 0, turn, -turn).astype(float)
    return np.stack([first, second], axis=-1), D


def _series(c: closed_forms.Coefficients, start: Any, h: Any) -> tuple[list[Long], list[Long]]:
    """Taylor coefficients of d and k about ``start`` in units of the step."""
    s1, c1, s2, c2 = np.sin(start), np.cos(start), np.sin(2 * start), np.cos(2 * start)
    d, k = [], []
    w1, w2 = np.longdouble(1), np.longdouble(1)
    for n in range(ORDER + 1):
        if n:
            w1, w2 = w1 * h / n, w2 * 2 * h / n
        sine1, cosine1 = (s1, c1, -s1, -c1)[n % 4] * w1, (c1, -s1, -c1, s1)[n % 4] * w1
        sine2, cosine2 = (s2, c2, -s2, -c2)[n % 4] * w2, (c2, -s2, -c2, s2)[n % 4] * w2
        d.append(c["cs1"] * sine1 + (c["c0"] if n == 0 else 0))
        k.append(
            c["kc1"] * cosine1 + c["ks1"] * sine1 + c["kc2"] * cosine2 + c["ks2"] * sine2 + (c["k0"] if n == 0 else 0)
        )
    return d, k


def _advance(d: list[Long], k: list[Long], y: Long, rate: Long, h: Any) -> list[Long]:
    """(y, y') one step later."""
    u = [y, rate * h]
    for n in range(ORDER - 1):
        total = sum(d[j] * h * ((n + 1 - j) * u[n + 1 - j]) + k[j] * h * h * u[n - j] for j in range(n + 1))
        u.append(-total / ((n + 1) * (n + 2)))
    return [sum(u[1:], u[0]), sum((n * u[n] for n in range(2, ORDER + 1)), u[1]) / h]
