"""Periodic matrices and the linear systems made of them.

A :class:`PeriodicMatrix` is a real matrix of trigonometric polynomials, possibly a different one on each piece between
kinks::

    A(ψ) = A₀ + Σ_h C_h cos hωψ + S_h sin hωψ,   1 ≤ h ≤ H,   ω = 2π / period

It knows ``+``, ``-``, ``@``, a derivative, a mean, a shift and samples, so that the multiblade transformation reads
as the report prints it (eq. B5): ``D = Ti @ (2 * T.derivative() + A @ T)``.  Leading axes are cases (rotors, advance
ratios …) and broadcast.  In memory the cases lie side by side (structure of arrays), whatever the order of the axes,
so that a term of a million cases is one contiguous row.

Coefficients are doubles, or exact: an object array of ``fractions.Fraction``, which sums, products and derivatives
keep exact (samples and means over pieces do not).

A :class:`PeriodicSystem` is ``q'' + D q' + K q = F u`` or ``x' = A x + F u``; primes are d/dψ.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ParameterError

__all__ = ["TWO_PI", "Equation", "Parts", "PeriodicMatrix", "PeriodicSystem", "fractions", "on_common_pieces"]

Array = NDArray[np.float64]
TWO_PI = 2.0 * math.pi
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494")
ENTRYWISE = 64  # cases from which products entry by entry are faster than small matrix products
IMAGINARY = 2.0**-300  # a step whose square is far below the last bit of anything


@dataclass(frozen=True, eq=False)
class PeriodicMatrix:
    """A real periodic matrix, trigonometric on each piece.

    Parameters
    ----------
    coefficients : (..., pieces, 2H+1, n, m)
        A₀, C₁, S₁, C₂, S₂ … on each piece.
    period : float
        Period of harmonic 1.
    edges : float (..., pieces+1), optional
        Where the pieces meet, from 0 to ``period``; None for a single piece.  Pieces may have no length.
    """

    coefficients: NDArray[Any]
    period: float = TWO_PI
    edges: Array | None = None

    __array_ufunc__ = None  # let ``array * matrix`` reach __rmul__

    def __post_init__(self) -> None:
        c = self.coefficients
        if not (isinstance(c, np.ndarray) and c.ndim >= 4 and c.shape[-3] % 2):
            raise ParameterError(
                "coefficients",
                c,
                f"{_described(c)} was given; it must be an array (…, pieces, 2H+1, n, m): "
                "make it with PeriodicMatrix.constant, harmonic, scalar or pieces",
            )
        if not _is_length(self.period):
            raise _no_period(self.period, "give the positive angle of harmonic 1")
        if not (self.edges is None or isinstance(self.edges, np.ndarray)):
            raise ParameterError(
                "edges",
                self.edges,
                f"{_described(self.edges)} was given; it must be an array: use PeriodicMatrix.pieces",
            )

    # ------------------------------------------------------------------ making
    @staticmethod
    def constant(value: ArrayLike, period: float = TWO_PI) -> PeriodicMatrix:
        """A matrix (..., n, m) that does not change."""
        return PeriodicMatrix(_matrix(_numbers(value))[..., None, None, :, :], period)

    @staticmethod
    def harmonic(order: int, cosine: ArrayLike, sine: ArrayLike, period: float = TWO_PI) -> PeriodicMatrix:
        """``cosine cos(order ω ψ) + sine sin(order ω ψ)`` for matrices (..., n, m), or 0 for none, and order ≥ 1."""
        if isinstance(order, bool) or not isinstance(order, (int, np.integer)) or order < 1:
            raise ParameterError(
                "order",
                order,
                f"{reprlib.repr(order)} is no harmonic: give a whole number from 1, and add PeriodicMatrix.constant "
                "for the mean",
            )
        c, s = _alike(_numbers(cosine, "cosine"), _numbers(sine, "sine"))
        if c.ndim and s.ndim and _matrix(c, "cosine").shape[-2:] != _matrix(s, "sine").shape[-2:]:
            raise ParameterError(
                "sine",
                s.shape,
                f"a sine of {_size(s)} was given beside a cosine of {_size(c)}: give both one size, or 0 for none",
            )
        _together("sine", c.shape, s.shape)
        c, s = np.broadcast_arrays(c, s)
        _matrix(c, "cosine")
        out = _zeros(c.shape[:-2], (1, 2 * order + 1, *c.shape[-2:]), np.result_type(c, s))
        out[..., 0, 2 * order - 1, :, :], out[..., 0, 2 * order, :, :] = c, s
        return PeriodicMatrix(out, period)

    @staticmethod
    def scalar(
        *,
        mean: ArrayLike = 0.0,
        cosines: Sequence[ArrayLike] = (),
        sines: Sequence[ArrayLike] = (),
        period: float = TWO_PI,
    ) -> PeriodicMatrix:
        """The 1×1 matrix ``mean + Σ cosines[n-1] cos nωψ + sines[n-1] sin nωψ``; entries broadcast over cases."""
        for name, given in (("cosines", cosines), ("sines", sines)):
            if isinstance(given, str) or not hasattr(given, "__len__"):
                raise ParameterError(
                    name,
                    given,
                    f"{_described(given)} was given; it must be a list with one entry a harmonic: write {name}=[…]",
                )
        order = max(len(cosines), len(sines))
        rows = [_numbers(mean, "mean"), *([np.zeros(())] * (2 * order))]
        rows[1 : 2 * len(cosines) : 2] = [_numbers(c, "cosines") for c in cosines]
        rows[2 : 2 * len(sines) + 1 : 2] = [_numbers(s, "sines") for s in sines]
        rows = _alike(*rows)
        out = _zeros(_together("mean", *(r.shape for r in rows)), (1, 2 * order + 1, 1, 1), np.result_type(*rows))
        for n, row in enumerate(rows):
            out[..., 0, n, 0, 0] = row
        return PeriodicMatrix(out, period)

    @staticmethod
    def sine_polynomial(coefficients: Sequence[ArrayLike], amplitude: ArrayLike) -> PeriodicMatrix:
        """The 1×1 matrix ``Σ coefficients[b] (amplitude sin ψ)^b`` of period 2π; entries broadcast over cases."""
        amplitude = _numbers(amplitude)
        exact = amplitude.dtype == object
        shape = np.broadcast_shapes(amplitude.shape, *(np.shape(c) for c in coefficients))
        out = _zeros(shape, (1, 2 * len(coefficients) - 1, 1, 1), amplitude.dtype)
        power: Any = 1
        for b, c in enumerate(coefficients):
            weight = c * power
            for row, value in _sine_power(b, exact):
                out[..., 0, row, 0, 0] += value * weight
            power = power * amplitude
        return PeriodicMatrix(out)

    @staticmethod
    def assemble(blocks: Sequence[Sequence[PeriodicMatrix | None]]) -> PeriodicMatrix:
        """The block matrix of ``blocks`` (None is zero); every row and column needs at least one block."""
        _check_blocks(blocks)
        heights = [next(b.shape[0] for b in row if b is not None) for row in blocks]
        widths = [next(b.shape[1] for b in column if b is not None) for column in zip(*blocks, strict=True)]
        total = PeriodicMatrix.constant(np.zeros((sum(heights), sum(widths))), _first(blocks).period)
        for i, row in enumerate(blocks):
            for j, block in enumerate(row):
                if block is not None:
                    _check_size("blocks", block, (heights[i], widths[j]))
                    total = total + block.embedded(sum(heights[:i]), sum(widths[:j]), sum(heights), sum(widths))
        return total

    @staticmethod
    def pieces(parts: Sequence[PeriodicMatrix], edges: ArrayLike) -> PeriodicMatrix:
        """One single-piece matrix after another, with ``edges`` (..., len(parts)+1) from 0 to the period."""
        if not len(parts):
            raise ParameterError("parts", parts, "there is no piece: give one matrix or more, and the edges of each")
        for part in parts:
            _check_matrix("parts", part)
            _check_size("parts", part, parts[0].shape)
            if part.edges is not None or part.period != parts[0].period:
                raise ParameterError(
                    "parts",
                    part,
                    "the pieces must be single ones, without edges of their own, and have one period: give each "
                    "piece as it would go on over the whole period, with that period",
                )
        ends = _edges(edges, len(parts), parts[0].period)
        order = max(p.order for p in parts)
        wide = [p.widened(order).coefficients for p in parts]
        shape = _together("parts", *(w.shape for w in wide))
        whole = np.concatenate([np.broadcast_to(w, shape) for w in wide], axis=-4)
        return PeriodicMatrix(whole, parts[0].period, ends)

    # ------------------------------------------------------------------ shape
    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        n, m = self.coefficients.shape[-2:]
        return n, m

    @property
    def cases(self) -> tuple[int, ...]:
        """Shape of the leading axes."""
        own = self.coefficients.shape[:-4]
        return own if self.edges is None else np.broadcast_shapes(own, self.edges.shape[:-1])

    @property
    def order(self) -> int:
        """Highest harmonic kept."""
        return self.coefficients.shape[-3] // 2

    def widened(self, order: int) -> PeriodicMatrix:
        """The same matrix with room for harmonics up to ``order``."""
        extra = order - self.order
        if extra <= 0:
            return self
        *cases, pieces, terms, n, m = self.coefficients.shape
        out = _zeros(tuple(cases), (pieces, terms + 2 * extra, n, m), self.coefficients.dtype)
        out[..., :terms, :, :] = self.coefficients
        return replace(self, coefficients=out)

    def embedded(self, top: int, left: int, rows: int, columns: int) -> PeriodicMatrix:
        """This matrix as a block of a zero matrix of ``rows`` by ``columns``."""
        *cases, pieces, terms, n, m = self.coefficients.shape
        out = _zeros(tuple(cases), (pieces, terms, rows, columns), self.coefficients.dtype)
        out[..., top : top + n, left : left + m] = self.coefficients
        return replace(self, coefficients=out)

    def entry(self, i: int, j: int) -> PeriodicMatrix:
        """The 1×1 matrix of one entry."""
        return replace(self, coefficients=self.coefficients[..., i : i + 1, j : j + 1])

    def case(self, index: Any) -> PeriodicMatrix:
        """The cases selected by ``index`` of the leading axes."""
        full = np.broadcast_to(self.coefficients, self.cases + self.coefficients.shape[-4:])
        edges = None if self.edges is None else np.broadcast_to(self.edges, self.cases + self.edges.shape[-1:])[index]
        return replace(self, coefficients=full[index], edges=edges)

    def flat(self, cases: tuple[int, ...]) -> PeriodicMatrix:
        """The same matrix for all of ``cases``, along one axis."""
        *own, pieces, terms, n, m = self.coefficients.shape
        count = math.prod(cases)
        c = self.coefficients
        if tuple(own) != (count,):
            c = _zeros((count,), (pieces, terms, n, m), c.dtype)
            full = np.broadcast_to(self.coefficients, (*cases, pieces, terms, n, m))
            c[...] = full.reshape(count, pieces, terms, n, m)
        edges = self.edges
        if edges is not None:
            edges = np.broadcast_to(edges, (*cases, edges.shape[-1])).reshape(count, edges.shape[-1])
        return replace(self, coefficients=c, edges=edges)

    def spread(self, cases: tuple[int, ...]) -> PeriodicMatrix:
        """The same matrix for all of ``cases``, a view."""
        return replace(self, coefficients=np.broadcast_to(self.coefficients, cases + self.coefficients.shape[-4:]))

    def exact(self) -> PeriodicMatrix:
        """The same matrix with its coefficients as fractions."""
        return replace(self, coefficients=fractions(self.coefficients))

    # ------------------------------------------------------------------ algebra
    def __add__(self, other: PeriodicMatrix) -> PeriodicMatrix:
        a, b = on_common_pieces(self, other)
        _check_size("matrix", b, a.shape)
        long, short = _alike(*sorted((a.coefficients, b.coefficients), key=lambda c: -c.shape[-3]))
        if long.shape[-3] == short.shape[-3]:
            return replace(a, coefficients=long + short)
        shape = np.broadcast_shapes(long.shape[:-3], short.shape[:-3])
        out = _zeros(shape[:-1], (shape[-1], *long.shape[-3:]), np.result_type(long, short))
        out[...] = long
        out[..., : short.shape[-3], :, :] += short
        return replace(a, coefficients=out)

    def __sub__(self, other: PeriodicMatrix) -> PeriodicMatrix:
        return self + (-1) * other

    def __rmul__(self, factor: ArrayLike) -> PeriodicMatrix:
        """Scale by one number a case."""
        scale, c = _alike(_numbers(factor, "factor"), self.coefficients)
        return replace(self, coefficients=scale[..., None, None, None, None] * c)

    def __mul__(self, factor: ArrayLike) -> PeriodicMatrix:
        return self.__rmul__(factor)

    def __truediv__(self, divisor: int) -> PeriodicMatrix:
        """Divide by a whole number, which keeps exact coefficients exact."""
        return replace(self, coefficients=self.coefficients / divisor)

    def __matmul__(self, other: PeriodicMatrix) -> PeriodicMatrix:
        a, b = on_common_pieces(self, other)
        _check_size("matrix", b, (a.shape[1], b.shape[1]))
        return replace(a, coefficients=_product(*_alike(a.coefficients, b.coefficients)))

    def transpose(self) -> PeriodicMatrix:
        """Aᵀ."""
        return replace(self, coefficients=np.swapaxes(self.coefficients, -1, -2))

    def derivative(self) -> PeriodicMatrix:
        """dA/dψ inside the pieces; a jump between pieces is not differentiated."""
        c = self.coefficients
        out = _zeros(c.shape[:-4], c.shape[-4:], c.dtype)
        omega = _frequency(self.period, exact=c.dtype == object)
        for h in range(1, self.order + 1):
            out[..., 2 * h - 1, :, :] = (h * omega) * c[..., 2 * h, :, :]
            out[..., 2 * h, :, :] = (-h * omega) * c[..., 2 * h - 1, :, :]
        return replace(self, coefficients=out)

    def shifted(self, angle: float) -> PeriodicMatrix:
        """A(ψ + angle)."""
        c = self.coefficients
        out = _zeros(c.shape[:-4], c.shape[-4:], c.dtype)
        out[..., 0, :, :] = c[..., 0, :, :]
        for h in range(1, self.order + 1):
            cosine, sine = _turned(h * TWO_PI / self.period * angle)
            out[..., 2 * h - 1, :, :] = cosine * c[..., 2 * h - 1, :, :] + sine * c[..., 2 * h, :, :]
            out[..., 2 * h, :, :] = cosine * c[..., 2 * h, :, :] - sine * c[..., 2 * h - 1, :, :]
        turned = replace(self, coefficients=out)
        if self.edges is None:
            return turned
        inner = np.sort(np.mod(self.edges[..., :-1] - angle, self.period), axis=-1)
        ends = np.broadcast_to(0.0, (*inner.shape[:-1], 1))
        edges = np.concatenate([ends, inner, ends + self.period], axis=-1)
        middle = np.mod(0.5 * (edges[..., 1:] + edges[..., :-1]) + angle, self.period)
        return replace(turned.gathered(self.piece_of(middle)), edges=edges)

    def mean(self) -> NDArray[Any]:
        """Average over one period, (..., n, m)."""
        if self.edges is None:
            return self.coefficients[..., 0, 0, :, :]
        ends = np.moveaxis(self.edges, -1, 0)
        parts = [self.piece(j).integral(*ends[j : j + 2]) for j in range(len(ends) - 1)]
        return _added(np.stack(np.broadcast_arrays(*parts)), 0) / self.period

    def integral(self, a: Array, b: Array) -> NDArray[Any]:
        """Of a single piece from a to b (...,), each a case: (..., n, m)."""
        c, omega = self.coefficients[..., 0, :, :, :], TWO_PI / self.period
        length = b - a
        total = length[..., None, None] * c[..., 0, :, :]
        halves, middles = _multiples(omega * 0.5 * length, self.order), _multiples(omega * 0.5 * (a + b), self.order)
        for h, ((_, half), (cosine, sine)) in enumerate(zip(halves, middles, strict=True), start=1):
            weight = (2.0 / (h * omega)) * half[..., None, None]
            cosine, sine = cosine[..., None, None], sine[..., None, None]
            total = total + weight * (cosine * c[..., 2 * h - 1, :, :] + sine * c[..., 2 * h, :, :])
        return np.asarray(total)

    # ------------------------------------------------------------------ values
    def piece(self, j: int) -> PeriodicMatrix:
        """Piece j alone, as it would go on over the whole period."""
        one = j if self.coefficients.shape[-4] > 1 else 0  # one piece broadcasts over many
        return replace(self, coefficients=self.coefficients[..., one : one + 1, :, :, :], edges=None)

    def at(self, psi: Array) -> NDArray[Any]:
        """Values of a single piece at an azimuth a case: psi (...,) → (..., n, m)."""
        c = self.coefficients[..., 0, :, :, :]
        total = c[..., 0, :, :]
        for h, (cosine, sine) in enumerate(_multiples((TWO_PI / self.period) * psi, self.order), start=1):
            total = (
                total + cosine[..., None, None] * c[..., 2 * h - 1, :, :] + sine[..., None, None] * c[..., 2 * h, :, :]
            )
        return np.asarray(total)

    def piece_of(self, psi: Array) -> NDArray[np.intp]:
        """Index of the piece that holds each ψ in [0, period]; psi is (..., k)."""
        if self.edges is None:
            return np.zeros(psi.shape, np.intp)
        return np.sum(psi[..., None] >= self.edges[..., None, 1:-1], axis=-1)

    def gathered(self, index: NDArray[np.intp]) -> PeriodicMatrix:
        """The pieces ``index`` (..., k), in that order."""
        cases = np.broadcast_shapes(self.cases, index.shape[:-1])
        full = np.broadcast_to(self.coefficients, cases + self.coefficients.shape[-4:])
        index = np.broadcast_to(index, (*cases, index.shape[-1]))
        return replace(self, coefficients=np.take_along_axis(full, index[..., None, None, None], axis=-4))

    def sample(self, psi: ArrayLike) -> Array:
        """Values at azimuths: psi (..., k) → (..., k, n, m)."""
        psi = np.asarray(psi, float)
        c = self.coefficients
        if self.edges is not None:
            c = self.gathered(self.piece_of(np.mod(psi, self.period))).coefficients
        phase = (TWO_PI / self.period) * psi
        out = np.array(
            np.broadcast_to(c[..., 0, :, :], (*np.broadcast_shapes(c.shape[:-3], psi.shape), *self.shape)), float
        )
        for h in range(1, self.order + 1):  # elementwise, so that a case's bits do not depend on its neighbours
            cosine, sine = np.cos(h * phase)[..., None, None], np.sin(h * phase)[..., None, None]
            out += cosine * c[..., 2 * h - 1, :, :] + sine * c[..., 2 * h, :, :]
        return out

    def bound(self) -> Array:
        """An upper bound of |entries| over ψ, (..., n, m)."""
        c = self.coefficients
        total = np.abs(c[..., 0, :, :])
        for h in range(1, self.order + 1):
            total = total + np.hypot(c[..., 2 * h - 1, :, :], c[..., 2 * h, :, :])
        return np.max(total, axis=-3)

    def magnitude(self) -> Array:
        """The sum of all |terms|, of the piece where it is largest, (..., n, m)."""
        c = self.coefficients
        total = np.abs(c[..., 0, :, :])
        for row in range(1, c.shape[-3]):
            total = total + np.abs(c[..., row, :, :])
        return total[..., 0, :, :] if total.shape[-3] == 1 else np.max(total, axis=-3)

    def jumps(self) -> Array:
        """A(edge+) − A(edge−) at every edge but the last, (..., pieces, n, m); zero for a single piece."""
        if self.edges is None:
            return np.zeros((*self.coefficients.shape[:-4], 1, *self.shape))
        begins = np.moveaxis(self.edges, -1, 0)[:-1]
        steps = [(self.piece(j) - self.piece(j - 1 if j else len(begins) - 1)).at(e) for j, e in enumerate(begins)]
        return np.stack(np.broadcast_arrays(*steps), axis=-3)


# ---------------------------------------------------------------------- what was given
def _described(value: Any) -> str:
    """A value in a few words."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return f"{'an' if type(value).__name__[0] in 'aeiou' else 'a'} {type(value).__name__}, {reprlib.repr(value)},"


def _size(matrix: Any) -> str:
    """``2×3``"""
    return "×".join(map(str, matrix.shape[-2:]))


def _numbers(value: ArrayLike, name: str = "value") -> NDArray[Any]:
    """Doubles, or exact or complex numbers as they are."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise ParameterError(
            name, value, "rows of unequal length were given: every row of a matrix has as many entries"
        ) from None
    if array.dtype != object and array.dtype.kind in "fiubc":
        return array if array.dtype.kind == "c" else array.astype(float, copy=False)
    exact = array.dtype == object and all(hasattr(x, "__truediv__") for x in array.flat)
    if not exact or any(isinstance(x, PeriodicMatrix) for x in array.flat):
        raise ParameterError(name, value, f"{_described(value)} was given; it must be real numbers")
    return array


def _real_numbers(array: NDArray[Any], name: str) -> NDArray[Any]:
    """What is not complex: numbers with an imaginary part are for rates only."""
    if array.dtype.kind == "c" or (array.dtype == object and any(isinstance(x, complex) for x in array.flat)):
        raise ParameterError(
            name,
            array.shape,
            "complex numbers were given, and the theory here is of real equations: "
            "write x = u + iv as the real equations of u and v",
        )
    return array


def _matrix(array: NDArray[Any], name: str = "value") -> NDArray[Any]:
    """A matrix (..., n, m)."""
    if array.ndim < 2:
        raise ParameterError(
            name,
            array.shape,
            f"an array of shape {array.shape} is no matrix: give (…, n, m), and [[a]] for a single entry",
        )
    return array


def _together(name: str, *shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape that shapes broadcast to."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        given = ", ".join(map(str, dict.fromkeys(shapes)))
        raise ParameterError(
            name, shapes, f"the shapes {given} do not broadcast: cases are leading axes of one length, or of length 1"
        ) from None


def _check_matrix(name: str, value: Any) -> None:
    """A PeriodicMatrix."""
    if not isinstance(value, PeriodicMatrix):
        raise ParameterError(
            name,
            value,
            f"{_described(value)} was given; it must be a PeriodicMatrix: "
            "PeriodicMatrix.constant(array) is one that does not change",
        )


def _check_size(name: str, matrix: PeriodicMatrix, shape: tuple[int, int]) -> None:
    """Rows and columns that fit."""
    if matrix.shape != shape:
        raise ParameterError(
            name, matrix.shape, f"a matrix of {_size(matrix)} stands where one of {shape[0]}×{shape[1]} fits"
        )


def _check_blocks(blocks: Sequence[Sequence[PeriodicMatrix | None]]) -> None:
    """Rows of one length, with a block in every row and column."""
    if len(blocks) == 0 or not all(isinstance(row, Sequence) and row for row in blocks):
        raise ParameterError("blocks", blocks, "there is no block: give rows of blocks, [[A, B], [C, None]]")
    if len({len(row) for row in blocks}) > 1:
        raise ParameterError("blocks", blocks, "rows of unequal length were given: write None for a block of zeros")
    for line in (*blocks, *zip(*blocks, strict=True)):
        if all(block is None for block in line):
            raise ParameterError(
                "blocks",
                blocks,
                "a row or column has None only, which has no size: give a PeriodicMatrix.constant of zeros in it",
            )
        for block in line:
            if block is not None:
                _check_matrix("blocks", block)


def _edges(given: ArrayLike, pieces: int, period: float) -> Array:
    """Edges (..., pieces+1) that go up from 0 to the period; a piece may have no length."""
    edges = np.asarray(_real_numbers(_numbers(given, "edges"), "edges"), float)
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


def _check_callable(A: Any) -> None:
    """A function of time."""
    if not callable(A):
        raise ParameterError(
            "A",
            A,
            f"{_described(A)} was given; it must be a function of t: give matrices by PeriodicSystem(matrix=…)",
        )


def _is_length(value: Any, *, or_nan: bool = False) -> bool:
    """Whether a value is a positive finite number, or nan."""
    return isinstance(value, Real) and (0 < float(value) < math.inf or (or_nan and math.isnan(value)))


def _no_period(value: Any, way_out: str) -> ParameterError:
    return ParameterError("period", value, f"{reprlib.repr(value)} is no period: {way_out}")


def _kinks(given: ArrayLike | None, period: float) -> Array:
    """Kinks within the period, in order."""
    kinks = _real_numbers(_numbers(() if given is None else given, "kinks"), "kinks")
    if not np.all(np.isfinite(kinks)):
        raise ParameterError(
            "kinks", given, f"{reprlib.repr(given)} was given; kinks are finite times at which A(t) is not smooth"
        )
    inner = np.unique(np.mod(kinks, period))
    return inner[inner > 0]


def _samples(A: Callable[[float], ArrayLike], times: Array) -> Array:
    """A at one time after another, (..., times, n, n)."""
    values = [_square(_real(A(float(t)))) for t in times]
    shapes = {value.shape for value in values}
    if len(shapes) > 1:
        raise ParameterError(
            "A",
            shapes,
            f"A(t) gave arrays of shapes {' and '.join(map(str, sorted(shapes)))}: it must have one shape at every t",
        )
    return np.stack(values, axis=-3)


def _real(value: ArrayLike) -> Array:
    """What A(t) gave, as real numbers."""
    if value is None:
        raise ParameterError("A", None, "A(t) gave None, not a matrix: see whether the function returns its result")
    return np.asarray(_real_numbers(_numbers(value, "A"), "A"), float)


def _is_square(matrix: Array) -> bool:
    return matrix.shape[-1] == matrix.shape[-2] > 0


def _square(matrix: Array) -> Array:
    """A matrix (..., n, n) that A(t) gave."""
    if matrix.ndim < 2 or not _is_square(matrix):
        raise ParameterError(
            "A", matrix.shape, f"A(t) gave an array of shape {matrix.shape}: it must be square, (…, n, n)"
        )
    return matrix


# ---------------------------------------------------------------------- arithmetic


def fractions(values: NDArray[Any]) -> NDArray[Any]:
    """An object array of the same numbers as fractions."""
    out = np.empty(values.size, object)
    out[:] = [Fraction(x) for x in values.ravel().tolist()]  # Python's numbers: NumPy's whole ones overflow
    return out.reshape(values.shape)


def _alike(*arrays: NDArray[Any]) -> list[NDArray[Any]]:
    """The arrays, all of them exact if one is: a double among fractions would make doubles of them."""
    if all(a.dtype != object for a in arrays) or all(a.dtype == object for a in arrays):
        return list(arrays)
    return [a if a.dtype == object else fractions(a) for a in arrays]


def _zeros(cases: tuple[int, ...], inner: tuple[int, ...], dtype: Any) -> NDArray[Any]:
    """Zeros (*cases, *inner) with the cases side by side in memory."""
    k = len(cases)
    exact = np.dtype(dtype) == object
    zeros = np.full((*inner, *cases), Fraction(0)) if exact else np.zeros((*inner, *cases), dtype)
    return zeros.transpose(*range(len(inner), len(inner) + k), *range(len(inner)))


def _product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Coefficients of the product of two trigonometric polynomials of matrices, (..., 2H+1, n, m) each.

    cos i cos j = ½[cos(i-j) + cos(i+j)] and so on; terms that are zero in every case are left out.
    """
    H, J = a.shape[-3] // 2, b.shape[-3] // 2
    shape = np.broadcast_shapes(a.shape[:-3], b.shape[:-3])
    inner = (shape[-1], 2 * (H + J) + 1, a.shape[-2], b.shape[-1])
    out = _zeros(shape[:-1], inner, np.result_type(a, b))

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
    out = _zeros(cases, (n, p), np.result_type(x, y))
    left = [(i, k) for i in range(n) for k in range(m) if np.any(x[..., i, k])]
    right = {(k, j): y[..., k, j] for k in range(m) for j in range(p) if np.any(y[..., k, j])}
    for i, k in left:
        for j in range(p):
            if (k, j) in right:
                out[..., i, j] += x[..., i, k] * right[k, j]
    return out


@cache
def _sine_power(b: int, exact: bool) -> list[tuple[int, Any]]:
    """Terms of sin^b ψ that are not zero, (row, value)."""
    rows = np.zeros((1, 1, 1, 1), object) + Fraction(1)
    sine = np.array([0, 0, Fraction(1)], object).reshape(1, 3, 1, 1)
    for _ in range(b):
        rows = _product(rows, sine)
    return [(r, value if exact else float(value)) for r, value in enumerate(rows.ravel()) if value != 0]


def _frequency(period: float, *, exact: bool) -> Any:
    """ω = 2π/period; exact as a fraction, where the period is a simple part or multiple of 2π, or to 60 digits."""
    if not exact:
        return TWO_PI / period
    simple = Fraction(TWO_PI / period).limit_denominator(1000)
    return simple if math.isclose(simple, TWO_PI / period, rel_tol=1e-15) else 2 * PI / Fraction(period)


def _multiples(angle: Array, order: int) -> Iterator[tuple[Array, Array]]:
    """cos and sin of angle, 2 angle … order·angle, by adding angles: errors of n eps in harmonic n."""
    if order:
        cosine, sine = c, s = np.cos(angle), np.sin(angle)
        yield c, s
        for _ in range(order - 1):
            cosine, sine = cosine * c - sine * s, sine * c + cosine * s
            yield cosine, sine


def _turned(angle: float) -> tuple[float, float]:
    """cos and sin of an angle, without rounding at quarter turns."""
    quarters = angle / (0.5 * math.pi)
    if abs(quarters - round(quarters)) < 1e-13 * max(1.0, abs(quarters)):
        return ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4]
    return math.cos(angle), math.sin(angle)


def _added(terms: NDArray[Any], axis: int) -> NDArray[Any]:
    """Sum along an axis in order: NumPy's own order depends on the number of cases, and so would the last bit."""
    parts = np.moveaxis(terms, axis, 0)
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def _averaged(matrix: PeriodicMatrix) -> PeriodicMatrix:
    return PeriodicMatrix.constant(matrix.mean(), matrix.period)


def _first(blocks: Sequence[Sequence[PeriodicMatrix | None]]) -> PeriodicMatrix:
    return next(b for row in blocks for b in row if b is not None)


def on_common_pieces(a: PeriodicMatrix, b: PeriodicMatrix) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """Both matrices on the union of their edges."""
    for matrix in (a, b):
        _check_matrix("matrix", matrix)
    if a.period != b.period:
        raise ParameterError(
            "period", (a.period, b.period), f"matrices of periods {a.period:g} and {b.period:g} cannot be combined"
        )
    if a.edges is None and b.edges is None:
        return a, b
    if a.edges is None or b.edges is None:
        edges = a.edges if b.edges is None else b.edges
        return replace(a, edges=edges), replace(b, edges=edges)  # one piece broadcasts over many
    if a.edges is b.edges or (a.edges.shape == b.edges.shape and np.array_equal(a.edges, b.edges)):
        return a, b
    edges = _union(a.edges, b.edges, a.period)
    middle = 0.5 * (edges[..., 1:] + edges[..., :-1])
    return replace(a.gathered(a.piece_of(middle)), edges=edges), replace(b.gathered(b.piece_of(middle)), edges=edges)


def _union(a: Array, b: Array, period: float) -> Array:
    """The edges of both, each once where one set holds the other."""
    for one, other in ((a, b), (b, a)):
        if np.all(np.any(other[..., 1:-1, None] == one[..., None, 1:-1], axis=-1)):
            return one
    cases = np.broadcast_shapes(a.shape[:-1], b.shape[:-1])
    inner = [np.broadcast_to(e[..., 1:-1], (*cases, e.shape[-1] - 2)) for e in (a, b)]
    ends = np.zeros((*cases, 1))
    return np.concatenate([ends, np.sort(np.concatenate(inner, axis=-1), axis=-1), ends + period], axis=-1)


Index = slice | NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Parts:
    """D and K in pieces, each polynomial once.

    Parameters
    ----------
    pairs : sequence of (D, K)
        Single pieces; D may be None.
    places : tuple of int
        Which pair stands on each piece.
    edges : float (..., pieces+1)
    """

    pairs: Sequence[tuple[PeriodicMatrix | None, PeriodicMatrix]]
    places: tuple[int, ...]
    edges: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Equation:
    """D and K of ``q'' + D q' + K q = F u`` as a function of parameters, for all cases, some, exactly, or in symbols.

    Parameters
    ----------
    build : callable
        Gives D and K (n, n each) for a dict of arrays, of doubles or of objects that have arithmetic.
    parameters : dict of arrays
        They broadcast to the cases.
    degrees : int
        n.
    parts : callable, optional
        Gives the same in pieces, each polynomial once: less to compute than ``build`` would repeat.
    key : hashable, optional
        What ``build`` follows from: equations of one key have one tape.  None for those that are not to be recorded.
    """

    build: Callable[[Mapping[str, NDArray[Any]]], tuple[PeriodicMatrix, PeriodicMatrix]]
    parameters: Mapping[str, NDArray[Any]]
    degrees: int = 1
    parts: Callable[[Mapping[str, NDArray[Any]]], Parts] | None = None
    key: Hashable = None

    @property
    def cases(self) -> tuple[int, ...]:
        """Shape of the cases."""
        return np.broadcast_shapes(*(v.shape for v in self.parameters.values()))

    def whole(self) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        """D and K of all cases."""
        return self.build(self.parameters)

    def part(self, index: Index) -> Equation:
        """The equation of some cases, an index along all of them."""
        shape = self.cases
        return replace(self, parameters={name: _some(v, shape, index) for name, v in self.parameters.items()})

    def exact(self) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        """D and K of all cases with their coefficients as fractions, for the parameters as they are."""
        return self.build({name: fractions(v) for name, v in self.parameters.items()})

    def rates(self, directions: Sequence[Mapping[str, ArrayLike]]) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        """Rates of D and K as the parameters move, (directions, ..., pieces, 2H+1, n, m).

        Each direction gives the rate of every parameter that moves, a number or one a case.  The models are analytic
        in their parameters, so that an imaginary step h leaves h times the rate as the imaginary part: no difference is
        taken, and h² is below the last bit.
        """
        cases, count = self.cases, len(directions)
        values: dict[str, NDArray[Any]] = {}
        for name, value in self.parameters.items():
            moving = np.stack([np.broadcast_to(np.asarray(d.get(name, 0.0), float), cases) for d in directions])
            own = np.broadcast_to(value, cases) if np.any(moving) else value
            values[name] = own + (IMAGINARY * 1j) * moving if np.any(moving) else np.asarray(own, complex)
        found = self.build(values)
        D, K = (replace(m, coefficients=np.asarray(m.coefficients, complex).imag / IMAGINARY) for m in found)
        return D.spread((count, *cases)), K.spread((count, *cases))


def _some(value: NDArray[Any], shape: tuple[int, ...], index: Index) -> NDArray[Any]:
    """Entries of ``value`` broadcast to ``shape``, by their flat index."""
    if value.ndim == 0:
        return value
    return value.reshape(-1)[index] if value.shape == shape else np.broadcast_to(value, shape).flat[index]


@dataclass(frozen=True, kw_only=True, eq=False)
class PeriodicSystem:
    """``q'' + D q' + K q = F u`` (state q, q') or ``x' = A x + F u``.

    Give either ``stiffness`` (with ``damping`` and ``inputs``, each optional), or an ``equation`` that makes the two
    when they are asked for, or ``matrix``, or ``function``.

    Parameters
    ----------
    damping, stiffness : PeriodicMatrix
        D and K (..., n, n).
    inputs : callable
        Gives F (..., n, inputs) when it is asked for; stability does not need it.
    matrix : PeriodicMatrix
        A (..., n, n) of a first-order system.
    function : callable
        A(t) of a first-order system for an array of times (k,) → (..., k, n, n).
    period : float
        Angle after which the motion is mapped; nan for a constant system, whose eigenvalues are its exponents.
    twist : (states,) array of ±1, optional
        S with A(ψ + period) = S A(ψ) S⁻¹, as a diagonal; None is the identity.
    kinks : float (..., k)
        Places in (0, period) where ``function`` is not smooth.
    input_names : tuple of str
        Names of the columns of F.
    coordinates : tuple of str
        Names of q (or x).
    blade : PeriodicSystem, optional
        One coordinate whose exponents, shifted by the whole numbers 0 … n-1, are the exponents of this system.
    blades : tuple of PeriodicSystem, optional
        Where there is no such coordinate: the equations of n blades, each in its own azimuth, of which this system in
        multiblade coordinates is made, and whose exponents it has.
    equation : Equation, optional
        Of a model: millions of cases are then made and solved in pieces that fit a cache.
    """

    period: float
    damping: PeriodicMatrix | None = None
    stiffness: PeriodicMatrix | None = None
    inputs: Callable[[], PeriodicMatrix] | None = None
    matrix: PeriodicMatrix | None = None
    function: Callable[[Array], Array] | None = None
    twist: Array | None = None
    kinks: Array | None = None
    input_names: tuple[str, ...] = ()
    coordinates: tuple[str, ...] = ()
    name: str = ""
    blade: PeriodicSystem | None = None
    blades: tuple[PeriodicSystem, ...] = ()
    equation: Equation | None = None

    def __post_init__(self) -> None:
        if self.equation is not None and self.stiffness is None:
            for name in ("damping", "stiffness"):
                object.__delattr__(self, name)  # __getattr__ makes them
            return
        object.__setattr__(self, "equation", None)  # matrices that were given count
        if sum(part is not None for part in (self.stiffness, self.matrix, self.function)) != 1:
            raise ParameterError(
                "PeriodicSystem", None, "give exactly one of stiffness (second order), matrix or function (first order)"
            )
        if not _is_length(self.period, or_nan=True):
            raise _no_period(self.period, "give a positive angle, or nan for a constant system")
        if self.function is not None:
            self._check_function()
        self._check_matrices()
        if self.inputs is not None and not callable(self.inputs):
            raise ParameterError(
                "inputs",
                self.inputs,
                f"{_described(self.inputs)} was given; it must be a function that gives F: write inputs=lambda: F",
            )
        if self.twist is not None:
            object.__setattr__(self, "twist", self._twist())
        for part in (self.damping, self.stiffness, self.matrix):
            if part is not None and not self.constant:
                self._check_period(part)

    def _check_function(self) -> None:
        """A(t), its kinks and its period."""
        _check_callable(self.function)
        if self.constant:
            raise _no_period(self.period, "give the positive time after which A(t) repeats")
        object.__setattr__(self, "kinks", _kinks(self.kinks, self.period))

    def _check_matrices(self) -> None:
        """Square ones of one size, with cases that broadcast."""
        parts = {n: p for n in ("damping", "stiffness", "matrix") if (p := getattr(self, n)) is not None}
        if self.damping is not None and self.stiffness is None:
            raise ParameterError("damping", self.damping, "damping goes with stiffness: put it into the matrix A")
        if self.kinks is not None and parts:
            raise ParameterError("kinks", self.kinks, "kinks go with a function: PeriodicMatrix.pieces has edges")
        for name, part in parts.items():
            _check_matrix(name, part)
            _real_numbers(part.coefficients, name)
            if part.shape[0] != part.shape[1] or not part.shape[0]:
                raise ParameterError(
                    name, part.shape, f"a matrix of {_size(part)} was given; it must be square, n×n for n coordinates"
                )
            if part.edges is not None:
                _edges(part.edges, max(part.coefficients.shape[-4], part.edges.shape[-1] - 1), part.period)
        if self.damping is not None and self.stiffness is not None:
            _check_size("damping", self.damping, self.stiffness.shape)
            _together("damping", self.damping.cases, self.stiffness.cases)

    def _twist(self) -> Array:
        """S as it is kept: a sign for every state, of q and q' alike."""
        n = self.states
        given: Any = self.twist
        twist: Array = np.asarray(_real_numbers(_numbers(given, "twist"), "twist"), np.float64)
        if twist.shape != (n,) or not np.all(np.abs(twist) == 1):
            raise ParameterError(
                "twist",
                self.twist,
                f"{reprlib.repr(twist.tolist())} was given; a twist is {n} numbers 1 or -1, one a state",
            )
        if self.second_order and not np.array_equal(twist[: n // 2], twist[n // 2 :]):
            raise ParameterError(
                "twist",
                self.twist,
                f"{reprlib.repr(twist.tolist())} turns a coordinate and not its rate: give the signs of q and again "
                "for q'",
            )
        return twist

    def __getattr__(self, name: str) -> Any:
        """``damping`` and ``stiffness`` of an equation, at their first use."""
        equation = self.__dict__.get("equation")
        if name not in ("damping", "stiffness") or equation is None:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        for key, value in zip(("damping", "stiffness"), equation.whole(), strict=True):
            object.__setattr__(self, key, value)
        return self.__dict__[name]

    def _check_period(self, part: PeriodicMatrix) -> None:
        """The period must be one of the coefficients: a multiple of theirs, or a part in which they (or S) repeat."""
        ratio = self.period / part.period
        whole = round(ratio) if ratio >= 1 else round(1 / ratio)
        fits = math.isclose(ratio if ratio >= 1 else 1 / ratio, whole, rel_tol=1e-12)
        if not fits or (ratio > 1.5 and part.edges is not None):
            raise ParameterError(
                "period",
                self.period,
                f"{self.period:g} is no period of coefficients that repeat after {part.period:g}: "
                "give theirs, or a fraction of it in which they repeat",
            )
        if part.edges is None and (ratio < 0.75 or self.twist is not None):
            self._check_turned(part, 1 if ratio > 0.75 else whole)

    def _check_turned(self, part: PeriodicMatrix, whole: int) -> None:
        """A(ψ + period) = S A(ψ) S⁻¹, for a period that is 1/whole of the coefficients'."""
        signs = np.ones(self.states) if self.twist is None else self.twist
        same = np.equal.outer(signs, signs)[: self.degrees, : self.degrees]
        order = (np.arange(2 * part.order + 1) + 1) // 2
        stays, turns = order % whole == 0, 2 * order % (2 * whole) == whole  # after the period: times 1, times -1
        allowed = (stays[:, None, None] & same) | (turns[:, None, None] & ~same)
        stray = np.abs(np.where(allowed, 0, part.coefficients))
        if stray.size and stray.max() > 1e-12 * np.abs(part.coefficients).max():
            raise ParameterError(
                "period" if self.twist is None else "twist",
                self.period if self.twist is None else self.twist,
                f"the coefficients do not repeat after {self.period:g}"
                + (
                    ": they have odd harmonics"
                    if self.twist is None
                    else " with this twist: A(ψ + period) must be S A S⁻¹"
                ),
            )

    @staticmethod
    def from_function(
        A: Callable[[Any], ArrayLike],
        period: float,
        kinks: Sequence[float] = (),
        *,
        vectorised: bool = False,
        coordinates: tuple[str, ...] = (),
        name: str = "",
    ) -> PeriodicSystem:
        """The first-order system ``x' = A(t) x``.

        ``A(t)`` takes a scalar t and gives (..., n, n) with cases leading; with ``vectorised`` it takes times (k,)
        and gives (..., k, n, n).  Declare every place where A or a derivative jumps in ``kinks``; exponents are per
        unit of t.
        """

        def sampled(times: Array) -> Array:
            values = _real(A(times)) if vectorised else _samples(A, times)
            if values.ndim < 3 or values.shape[-3] != len(times) or not _is_square(values):
                raise ParameterError(
                    "A",
                    values.shape,
                    f"A(t) gave an array of shape {values.shape}: it must be square, (…, times, n, n)",
                )
            if not np.all(np.isfinite(values)):
                raise ParameterError(
                    "A",
                    None,
                    f"A(t) is not finite near t = {times[0]:.6g}: every entry must be a number over the whole period",
                )
            return values

        _check_callable(A)
        if not _is_length(period):
            raise _no_period(period, "give the positive time after which A(t) repeats")
        return PeriodicSystem(
            period=float(period),
            function=sampled,
            kinks=_kinks(kinks, float(period)),
            coordinates=coordinates,
            name=name,
        )

    @property
    def parts(self) -> Parts | None:
        """D and K of a model in pieces, each polynomial once; None without pieces, or where matrices were given."""
        equation = self.equation
        return None if equation is None or equation.parts is None else equation.parts(equation.parameters)

    @property
    def forcing(self) -> PeriodicMatrix | None:
        """F (..., n, inputs), or None."""
        return None if self.inputs is None else self.inputs()

    def part(self, index: Index, *, exact: bool = False) -> PeriodicSystem:
        """Some cases (an index along all of them), along one axis, their coefficients in doubles or as fractions.

        Fractions are the coefficients of a model for its parameters as they are, without rounding, or of the matrices
        that were given.
        """
        if self.equation is not None:
            equation = self.equation.part(index)  # kept, so that a part of it is exact from the parameters too
            if not exact:
                return replace(self, damping=None, stiffness=None, equation=equation, blade=None, blades=())
            D, K = equation.exact()
            return replace(self, damping=D, stiffness=K, equation=None, blade=None, blades=())
        if self.function is not None:
            if exact:
                raise ParameterError(
                    "function", None, "the values of a function are not exact: give the system as a PeriodicMatrix"
                )
            return self
        cases, parts = self.cases, {}
        for name in ("damping", "stiffness", "matrix"):
            if (matrix := getattr(self, name)) is not None:
                chosen = matrix.flat(cases).case(index)
                parts[name] = chosen.exact() if exact else chosen
        return replace(self, **parts)

    @property
    def second_order(self) -> bool:
        """Whether the state is (q, q')."""
        return self.equation is not None or self.stiffness is not None

    @property
    def constant(self) -> bool:
        """Whether the coefficients do not change."""
        return math.isnan(self.period)

    @property
    def cases(self) -> tuple[int, ...]:
        """Shape of the leading axes."""
        if self.equation is not None:
            return self.equation.cases
        if self.function is not None:
            return self.function(np.zeros(1)).shape[:-3]
        parts = (self.damping, self.stiffness, self.matrix)
        return np.broadcast_shapes(*(p.cases for p in parts if p is not None))

    @property
    def degrees(self) -> int:
        """Number of coordinates q (or x)."""
        if self.equation is not None:
            return self.equation.degrees
        if self.function is not None:
            return self.function(np.zeros(1)).shape[-1]
        part = self.stiffness if self.stiffness is not None else self.matrix
        assert part is not None
        return part.shape[0]

    @property
    def states(self) -> int:
        """Number of states."""
        return self.degrees * (2 if self.second_order else 1)

    def sample(self, psi: ArrayLike) -> Array:
        """The first-order matrix A(ψ): psi (k,) → (..., k, states, states)."""
        psi = np.asarray(psi, float)
        if self.function is not None:
            return self.function(psi)
        if self.matrix is not None:
            return self.matrix.sample(psi)
        assert self.stiffness is not None
        n = self.degrees
        K = self.stiffness.sample(psi)
        D = self.damping.sample(psi) if self.damping is not None else np.zeros_like(K)
        K, D = np.broadcast_arrays(K, D)
        out = np.zeros((*K.shape[:-2], 2 * n, 2 * n))
        out[..., :n, n:] = np.eye(n)
        out[..., n:, :n] = -K
        out[..., n:, n:] = -D
        return out

    def mean(self) -> PeriodicSystem:
        """The constant system of the averaged coefficients."""
        if self.function is not None:
            raise ParameterError(
                "function",
                None,
                "a system given as a function is not averaged here: average its matrix and give that as a constant",
            )
        averaged: dict[str, Any] = {
            n: None if (m := getattr(self, n)) is None else _averaged(m) for n in ("damping", "stiffness", "matrix")
        }
        inputs = self.inputs
        return replace(
            self,
            period=math.nan,
            twist=None,
            blade=None,
            blades=(),
            inputs=inputs and (lambda: _averaged(inputs())),
            **averaged,
        )


for _name in ("damping", "stiffness"):
    delattr(PeriodicSystem, _name)  # a default on the class would hide that an equation has not made them yet
