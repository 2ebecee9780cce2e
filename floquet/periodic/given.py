"""What users give to the classes of this room: numbers, shapes, edges, periods; what is none of them is a sentence."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError

Array = NDArray[np.float64]


def described(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return f"{'an' if type(value).__name__[0] in 'aeiou' else 'a'} {type(value).__name__}, {reprlib.repr(value)},"


def size_of(matrix: Any) -> str:
    """``2×3``"""
    return "×".join(map(str, matrix.shape[-2:]))


def numbers(value: ArrayLike, name: str = "value") -> NDArray[Any]:
    """Doubles, or exact or complex numbers as they are."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise ParameterError(
            name, value, "rows of unequal length were given: every row of a matrix has as many entries"
        ) from None
    if array.dtype != object and array.dtype.kind in "fiubc":
        return array if array.dtype.kind == "c" else array.astype(float, copy=False)
    if array.dtype != object or not all(hasattr(x, "__truediv__") and not hasattr(x, "__matmul__") for x in array.flat):
        raise ParameterError(name, value, f"{described(value)} was given; it must be real numbers")
    return array


def real_numbers(array: NDArray[Any], name: str) -> NDArray[Any]:
    """What is not complex: numbers with an imaginary part are for rates only."""
    if array.dtype.kind == "c" or (array.dtype == object and any(isinstance(x, complex) for x in array.flat)):
        raise ParameterError(
            name,
            array.shape,
            "complex numbers were given, and the theory here is of real equations: "
            "write x = u + iv as the real equations of u and v",
        )
    return array


def as_matrix(array: NDArray[Any], name: str = "value") -> NDArray[Any]:
    """A matrix (..., n, m)."""
    if array.ndim < 2:
        raise ParameterError(
            name,
            array.shape,
            f"an array of shape {array.shape} is no matrix: give (…, n, m), and [[a]] for a single entry",
        )
    return array


def together(name: str, *shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape that shapes broadcast to."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        given = ", ".join(map(str, dict.fromkeys(shapes)))
        raise ParameterError(
            name, shapes, f"the shapes {given} do not broadcast: cases are leading axes of one length, or of length 1"
        ) from None


def checked_edges(given: ArrayLike, pieces: int, period: float) -> Array:
    """Edges (..., pieces+1) that go up from 0 to the period; a piece may have no length."""
    edges = np.asarray(real_numbers(numbers(given, "edges"), "edges"), float)
    if edges.ndim == 0 or edges.shape[-1] != pieces + 1:
        count = edges.shape[-1] if edges.ndim else 1
        raise ParameterError(
            "edges", given, f"{count} edges were given for {pieces} pieces: give {pieces + 1}, from 0 to {period:g}"
        )
    slack = 1e-12 * period  # rounding
    fits = np.all(edges[..., 0] == 0) and np.all(np.abs(edges[..., -1] - period) <= slack)
    if not (fits and np.all(np.diff(edges) >= -slack)):
        raise ParameterError(
            "edges",
            given,
            f"{reprlib.repr(np.asarray(given).tolist())} was given; edges go up from 0 to the period of the pieces, "
            f"{period:.17g}: sort them, and turn the start so that an edge is at 0",
        )
    return edges


def check_callable(A: Any) -> None:
    """A function of time."""
    if not callable(A):
        raise ParameterError(
            "A",
            A,
            f"{described(A)} was given; it must be a function of t: give matrices by PeriodicSystem(matrix=…)",
        )


def is_length(value: Any, *, or_nan: bool = False) -> bool:
    """Whether a value is a positive finite number, or nan."""
    return isinstance(value, Real) and (0 < float(value) < math.inf or (or_nan and math.isnan(value)))


def no_period(value: Any, way_out: str) -> ParameterError:
    return ParameterError("period", value, f"{reprlib.repr(value)} is no period: {way_out}")


def kinks_within(given: ArrayLike | None, period: float) -> Array:
    """Kinks within the period, in order."""
    kinks = real_numbers(numbers(() if given is None else given, "kinks"), "kinks")
    if not np.all(np.isfinite(kinks)):
        raise ParameterError(
            "kinks", given, f"{reprlib.repr(given)} was given; kinks are finite times at which A(t) is not smooth"
        )
    inner = np.unique(np.mod(kinks, period))
    return inner[inner > 0]


def sampled_singly(A: Callable[[float], ArrayLike], times: Array) -> Array:
    """A at one time after another, (..., times, n, n)."""
    values = [_square(real_matrix(A(float(t)))) for t in times]
    shapes = {value.shape for value in values}
    if len(shapes) > 1:
        raise ParameterError(
            "A",
            shapes,
            f"A(t) gave arrays of shapes {' and '.join(map(str, sorted(shapes)))}: it must have one shape at every t",
        )
    return np.stack(values, axis=-3)


def real_matrix(value: ArrayLike) -> Array:
    """What A(t) gave, as real numbers."""
    if value is None:
        raise ParameterError("A", None, "A(t) gave None, not a matrix: see whether the function returns its result")
    return np.asarray(real_numbers(numbers(value, "A"), "A"), float)


def is_square(matrix: Array) -> bool:
    return matrix.shape[-1] == matrix.shape[-2] > 0


def _square(matrix: Array) -> Array:
    """A matrix (..., n, n) that A(t) gave."""
    if matrix.ndim < 2 or not is_square(matrix):
        raise ParameterError(
            "A", matrix.shape, f"A(t) gave an array of shape {matrix.shape}: it must be square, (…, n, n)"
        )
    return matrix
