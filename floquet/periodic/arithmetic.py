"""Coefficients of trigonometric polynomials: sums, products, turns; in doubles or exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TWO_PI = 2.0 * math.pi
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494")
ENTRYWISE = 64  # cases from which products entry by entry are faster than small matrix products


def fractions(values: NDArray[Any]) -> NDArray[Any]:
    """An object array of the same numbers as fractions."""
    out = np.empty(values.size, object)
    out[:] = [Fraction(x) for x in values.ravel().tolist()]  # Python's numbers: NumPy's whole ones overflow
    return out.reshape(values.shape)


def alike(*arrays: NDArray[Any]) -> list[NDArray[Any]]:
    """The arrays, all of them exact if one is: a double among fractions would make doubles of them."""
    if all(a.dtype != object for a in arrays) or all(a.dtype == object for a in arrays):
        return list(arrays)
    return [a if a.dtype == object else fractions(a) for a in arrays]


def zeros(cases: tuple[int, ...], inner: tuple[int, ...], dtype: Any) -> NDArray[Any]:
    """Zeros (*cases, *inner) with the cases side by side in memory."""
    k = len(cases)
    exact = np.dtype(dtype) == object
    zeros = np.full((*inner, *cases), Fraction(0)) if exact else np.zeros((*inner, *cases), dtype)
    return zeros.transpose(*range(len(inner), len(inner) + k), *range(len(inner)))


def product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Coefficients of the product of two trigonometric polynomials of matrices, (..., 2H+1, n, m) each.

    cos i cos j = ½[cos(i-j) + cos(i+j)] and so on; terms that are zero in every case are left out.
    """
    H, J = a.shape[-3] // 2, b.shape[-3] // 2
    shape = np.broadcast_shapes(a.shape[:-3], b.shape[:-3])
    inner = (shape[-1], 2 * (H + J) + 1, a.shape[-2], b.shape[-1])
    out = zeros(shape[:-1], inner, np.result_type(a, b))

    def rows(c: NDArray[Any], h: int) -> list[tuple[int, NDArray[Any]]]:
        """Terms of a harmonic that are not zero: 0 the cosine (or the mean), 1 the sine."""
        terms = [(0, c[..., 0, :, :])] if h == 0 else [(k, c[..., 2 * h - 1 + k, :, :]) for k in (0, 1)]
        return [(k, t) for k, t in terms if np.any(t)]

    def add(h: int, sine: bool, value: NDArray[Any]) -> None:
        row = 0 if h == 0 else 2 * abs(h) - 1 + sine
        if h != 0 or not sine:
            out[..., row, :, :] += -value if sine and h < 0 else value

    for i in range(H + 1):
        for j in range(J + 1):
            for k, x in rows(a, i):
                for m, y in rows(b, j):
                    z = x * y if x.shape[-2:] == (1, 1) == y.shape[-2:] else _matmul(x, y)
                    if i == 0 or j == 0:
                        add(i + j, bool(k + m), z)
                        continue
                    z = z / 2
                    add(i + j, k != m, -z if k + m == 2 else z)
                    add(i - j, k != m, -z if k < m else z)
    return out


def _matmul(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    """x @ y; for many cases entry by entry along the cases, which lie side by side, without entries that are zero."""
    cases = np.broadcast_shapes(x.shape[:-2], y.shape[:-2])
    if math.prod(cases) < ENTRYWISE:
        return x @ y
    (n, m), p = x.shape[-2:], y.shape[-1]
    out = zeros(cases, (n, p), np.result_type(x, y))
    left = [(i, k) for i in range(n) for k in range(m) if np.any(x[..., i, k])]
    right = {(k, j): y[..., k, j] for k in range(m) for j in range(p) if np.any(y[..., k, j])}
    for i, k in left:
        for j in range(p):
            if (k, j) in right:
                out[..., i, j] += x[..., i, k] * right[k, j]
    return out


@cache
def sine_power(b: int, exact: bool) -> list[tuple[int, Any]]:
    """Terms of sin^b ψ that are not zero, (row, value)."""
    rows = np.zeros((1, 1, 1, 1), object) + Fraction(1)
    sine = np.array([0, 0, Fraction(1)], object).reshape(1, 3, 1, 1)
    for _ in range(b):
        rows = product(rows, sine)
    return [(r, value if exact else float(value)) for r, value in enumerate(rows.ravel()) if value != 0]


def frequency(period: float, *, exact: bool) -> Any:
    """ω = 2π/period; exact as a fraction, where the period is a simple part or multiple of 2π, or to 60 digits."""
    if not exact:
        return TWO_PI / period
    simple = Fraction(TWO_PI / period).limit_denominator(1000)
    return simple if math.isclose(simple, TWO_PI / period, rel_tol=1e-15) else 2 * PI / Fraction(period)


def multiples(angle: Array, order: int) -> Iterator[tuple[Array, Array]]:
    """cos and sin of angle, 2 angle … order·angle, by adding angles: errors of n eps in harmonic n."""
    if order:
        cosine, sine = c, s = np.cos(angle), np.sin(angle)
        yield c, s
        for _ in range(order - 1):
            cosine, sine = cosine * c - sine * s, sine * c + cosine * s
            yield cosine, sine


def turned(angle: float) -> tuple[float, float]:
    """cos and sin of an angle, without rounding at quarter turns."""
    quarters = angle / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-13 * max(1.0, abs(quarters)):
        return ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4]
    return math.cos(angle), math.sin(angle)


def added(terms: NDArray[Any], axis: int) -> NDArray[Any]:
    """Sum along an axis in order: NumPy's own order depends on the number of cases, and so would the last bit."""
    parts = np.moveaxis(terms, axis, 0)
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def union(a: Array, b: Array, period: float) -> Array:
    """The edges of both, each once where one set holds the other."""
    for one, other in ((a, b), (b, a)):
        if np.all(np.any(other[..., 1:-1, None] == one[..., None, 1:-1], axis=-1)):
            return one
    cases = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    inner = [np.broadcast_to(e[..., 1:-1], (*cases, e.shape[-1] - 2)) for e in (a, b)]
    ends = np.zeros((*cases, 1))
    return np.concatenate([ends, np.sort(np.concatenate(inner, axis=-1), axis=-1), ends + period], axis=-1)
