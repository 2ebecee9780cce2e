"""A real matrix of trigonometric polynomials, possibly a different one on each piece between kinks."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from .arithmetic import (
    TWO_PI,
    added,
    alike,
    fractions,
    frequency,
    multiples,
    product,
    sine_power,
    turned,
    union,
    zeros,
)
from .given import (
    as_matrix,
    checked_edges,
    described,
    is_length,
    no_period,
    numbers,
    size_of,
    together,
)

Array = NDArray[np.float64]


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
                f"{described(c)} was given; it must be an array (…, pieces, 2H+1, n, m): "
                "make it with PeriodicMatrix.constant, harmonic, scalar or pieces",
            )
        if not is_length(self.period):
            raise no_period(self.period, "give the positive angle of harmonic 1")
        if not (self.edges is None or isinstance(self.edges, np.ndarray)):
            raise ParameterError(
                "edges",
                self.edges,
                f"{described(self.edges)} was given; it must be an array: use PeriodicMatrix.pieces",
            )

    # ------------------------------------------------------------------ making
    @staticmethod
    def constant(value: ArrayLike, period: float = TWO_PI) -> PeriodicMatrix:
        """A matrix (..., n, m) that does not change."""
        return PeriodicMatrix(as_matrix(numbers(value))[..., None, None, :, :], period)

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
        c, s = alike(numbers(cosine, "cosine"), numbers(sine, "sine"))
        if c.ndim and s.ndim and as_matrix(c, "cosine").shape[-2:] != as_matrix(s, "sine").shape[-2:]:
            raise ParameterError(
                "sine",
                s.shape,
                f"a sine of {size_of(s)} was given beside a cosine of {size_of(c)}: give both one size, or 0 for none",
            )
        together("sine", c.shape, s.shape)
        c, s = np.broadcast_arrays(c, s)
        as_matrix(c, "cosine")
        out = zeros(c.shape[:-2], (1, 2 * order + 1, *c.shape[-2:]), np.result_type(c, s))
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
                    f"{described(given)} was given; it must be a list with one entry a harmonic: write {name}=[…]",
                )
        order = max(len(cosines), len(sines))
        rows = [numbers(mean, "mean"), *([np.zeros(())] * (2 * order))]
        rows[1 : 2 * len(cosines) : 2] = [numbers(c, "cosines") for c in cosines]
        rows[2 : 2 * len(sines) + 1 : 2] = [numbers(s, "sines") for s in sines]
        rows = alike(*rows)
        out = zeros(together("mean", *(r.shape for r in rows)), (1, 2 * order + 1, 1, 1), np.result_type(*rows))
        for n, row in enumerate(rows):
            out[..., 0, n, 0, 0] = row
        return PeriodicMatrix(out, period)

    @staticmethod
    def sine_polynomial(coefficients: Sequence[ArrayLike], amplitude: ArrayLike) -> PeriodicMatrix:
        """The 1×1 matrix ``Σ coefficients[b] (amplitude sin ψ)^b`` of period 2π; entries broadcast over cases."""
        amplitude = numbers(amplitude)
        exact = amplitude.dtype == object
        shape = np.broadcast_shapes(amplitude.shape, *(np.shape(c) for c in coefficients))
        out = zeros(shape, (1, 2 * len(coefficients) - 1, 1, 1), amplitude.dtype)
        power: Any = 1
        for b, c in enumerate(coefficients):
            weight = c * power
            for row, value in sine_power(b, exact):
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
                    check_size("blocks", block, (heights[i], widths[j]))
                    total = total + block.embedded(sum(heights[:i]), sum(widths[:j]), sum(heights), sum(widths))
        return total

    @staticmethod
    def pieces(parts: Sequence[PeriodicMatrix], edges: ArrayLike) -> PeriodicMatrix:
        """One single-piece matrix after another, with ``edges`` (..., len(parts)+1) from 0 to the period."""
        if not len(parts):
            raise ParameterError("parts", parts, "there is no piece: give one matrix or more, and the edges of each")
        for part in parts:
            check_matrix("parts", part)
            check_size("parts", part, parts[0].shape)
            if part.edges is not None or part.period != parts[0].period:
                raise ParameterError(
                    "parts",
                    part,
                    "the pieces must be single ones, without edges of their own, and have one period: give each "
                    "piece as it would go on over the whole period, with that period",
                )
        ends = checked_edges(edges, len(parts), parts[0].period)
        order = max(p.order for p in parts)
        wide = [p.widened(order).coefficients for p in parts]
        shape = together("parts", *(w.shape for w in wide))
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
        out = zeros(tuple(cases), (pieces, terms + 2 * extra, n, m), self.coefficients.dtype)
        out[..., :terms, :, :] = self.coefficients
        return replace(self, coefficients=out)

    def embedded(self, top: int, left: int, rows: int, columns: int) -> PeriodicMatrix:
        """This matrix as a block of a zero matrix of ``rows`` by ``columns``."""
        *cases, pieces, terms, n, m = self.coefficients.shape
        out = zeros(tuple(cases), (pieces, terms, rows, columns), self.coefficients.dtype)
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
            c = zeros((count,), (pieces, terms, n, m), c.dtype)
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
        check_size("matrix", b, a.shape)
        long, short = alike(*sorted((a.coefficients, b.coefficients), key=lambda c: -c.shape[-3]))
        if long.shape[-3] == short.shape[-3]:
            return replace(a, coefficients=long + short)
        shape = np.broadcast_shapes(long.shape[:-3], short.shape[:-3])
        out = zeros(shape[:-1], (shape[-1], *long.shape[-3:]), np.result_type(long, short))
        out[...] = long
        out[..., : short.shape[-3], :, :] += short
        return replace(a, coefficients=out)

    def __sub__(self, other: PeriodicMatrix) -> PeriodicMatrix:
        return self + (-1) * other

    def __rmul__(self, factor: ArrayLike) -> PeriodicMatrix:
        """Scale by one number a case."""
        scale, c = alike(numbers(factor, "factor"), self.coefficients)
        return replace(self, coefficients=scale[..., None, None, None, None] * c)

    def __mul__(self, factor: ArrayLike) -> PeriodicMatrix:
        return self.__rmul__(factor)

    def __truediv__(self, divisor: int) -> PeriodicMatrix:
        """Divide by a whole number, which keeps exact coefficients exact."""
        return replace(self, coefficients=self.coefficients / divisor)

    def __matmul__(self, other: PeriodicMatrix) -> PeriodicMatrix:
        a, b = on_common_pieces(self, other)
        check_size("matrix", b, (a.shape[1], b.shape[1]))
        return replace(a, coefficients=product(*alike(a.coefficients, b.coefficients)))

    def transpose(self) -> PeriodicMatrix:
        """Aᵀ."""
        return replace(self, coefficients=np.swapaxes(self.coefficients, -1, -2))

    def derivative(self) -> PeriodicMatrix:
        """dA/dψ inside the pieces; a jump between pieces is not differentiated."""
        c = self.coefficients
        out = zeros(c.shape[:-4], c.shape[-4:], c.dtype)
        omega = frequency(self.period, exact=c.dtype == object)
        for h in range(1, self.order + 1):
            out[..., 2 * h - 1, :, :] = (h * omega) * c[..., 2 * h, :, :]
            out[..., 2 * h, :, :] = (-h * omega) * c[..., 2 * h - 1, :, :]
        return replace(self, coefficients=out)

    def shifted(self, angle: float) -> PeriodicMatrix:
        """A(ψ + angle)."""
        c = self.coefficients
        out = zeros(c.shape[:-4], c.shape[-4:], c.dtype)
        out[..., 0, :, :] = c[..., 0, :, :]
        for h in range(1, self.order + 1):
            cosine, sine = turned(h * TWO_PI / self.period * angle)
            out[..., 2 * h - 1, :, :] = cosine * c[..., 2 * h - 1, :, :] + sine * c[..., 2 * h, :, :]
            out[..., 2 * h, :, :] = cosine * c[..., 2 * h, :, :] - sine * c[..., 2 * h - 1, :, :]
        moved = replace(self, coefficients=out)
        if self.edges is None:
            return moved
        inner = np.sort(np.mod(self.edges[..., :-1] - angle, self.period), axis=-1)
        ends = np.broadcast_to(0.0, (*inner.shape[:-1], 1))
        edges = np.concatenate([ends, inner, ends + self.period], axis=-1)
        middle = np.mod(0.5 * (edges[..., 1:] + edges[..., :-1]) + angle, self.period)
        return replace(moved.gathered(self.piece_of(middle)), edges=edges)

    def mean(self) -> NDArray[Any]:
        """Average over one period, (..., n, m)."""
        if self.edges is None:
            return self.coefficients[..., 0, 0, :, :]
        ends = np.moveaxis(self.edges, -1, 0)
        parts = [self.piece(j).integral(*ends[j : j + 2]) for j in range(len(ends) - 1)]
        return added(np.stack(np.broadcast_arrays(*parts)), 0) / self.period

    def integral(self, a: Array, b: Array) -> NDArray[Any]:
        """Of a single piece from a to b (...,), each a case: (..., n, m)."""
        c, omega = self.coefficients[..., 0, :, :, :], TWO_PI / self.period
        length = b - a
        total = length[..., None, None] * c[..., 0, :, :]
        halves, middles = multiples(omega * 0.5 * length, self.order), multiples(omega * 0.5 * (a + b), self.order)
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
        for h, (cosine, sine) in enumerate(multiples((TWO_PI / self.period) * psi, self.order), start=1):
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


def averaged(matrix: PeriodicMatrix) -> PeriodicMatrix:
    return PeriodicMatrix.constant(matrix.mean(), matrix.period)


def _first(blocks: Sequence[Sequence[PeriodicMatrix | None]]) -> PeriodicMatrix:
    return next(b for row in blocks for b in row if b is not None)


def on_common_pieces(a: PeriodicMatrix, b: PeriodicMatrix) -> tuple[PeriodicMatrix, PeriodicMatrix]:
    """Both matrices on the union of their edges."""
    for matrix in (a, b):
        check_matrix("matrix", matrix)
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
    edges = union(a.edges, b.edges, a.period)
    middle = 0.5 * (edges[..., 1:] + edges[..., :-1])
    return replace(a.gathered(a.piece_of(middle)), edges=edges), replace(b.gathered(b.piece_of(middle)), edges=edges)


def check_matrix(name: str, value: Any) -> None:
    """A PeriodicMatrix."""
    if not isinstance(value, PeriodicMatrix):
        raise ParameterError(
            name,
            value,
            f"{described(value)} was given; it must be a PeriodicMatrix: "
            "PeriodicMatrix.constant(array) is one that does not change",
        )


def check_size(name: str, matrix: PeriodicMatrix, shape: tuple[int, int]) -> None:
    """Rows and columns that fit."""
    if matrix.shape != shape:
        raise ParameterError(
            name, matrix.shape, f"a matrix of {size_of(matrix)} stands where one of {shape[0]}×{shape[1]} fits"
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
                check_matrix("blocks", block)
