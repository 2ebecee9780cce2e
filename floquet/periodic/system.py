"""A linear periodic system, of second or first order."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from .equation import Equation, Index, Parts
from .given import (
    check_callable,
    checked_edges,
    described,
    is_length,
    is_square,
    kinks_within,
    no_period,
    numbers,
    real_matrix,
    real_numbers,
    sampled_singly,
    size_of,
    together,
)
from .matrix import PeriodicMatrix, averaged, check_matrix, check_size

Array = NDArray[np.float64]


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
        if not is_length(self.period, or_nan=True):
            raise no_period(self.period, "give a positive angle, or nan for a constant system")
        if self.function is not None:
            self._check_function()
        self._check_matrices()
        if self.inputs is not None and not callable(self.inputs):
            raise ParameterError(
                "inputs",
                self.inputs,
                f"{described(self.inputs)} was given; it must be a function that gives F: write inputs=lambda: F",
            )
        if self.twist is not None:
            object.__setattr__(self, "twist", self._twist())
        for part in (self.damping, self.stiffness, self.matrix):
            if part is not None and not self.constant:
                self._check_period(part)

    def _check_function(self) -> None:
        """A(t), its kinks and its period."""
        check_callable(self.function)
        if self.constant:
            raise no_period(self.period, "give the positive time after which A(t) repeats")
        object.__setattr__(self, "kinks", kinks_within(self.kinks, self.period))

    def _check_matrices(self) -> None:
        """Square ones of one size, with cases that broadcast."""
        parts = {n: p for n in ("damping", "stiffness", "matrix") if (p := getattr(self, n)) is not None}
        if self.damping is not None and self.stiffness is None:
            raise ParameterError("damping", self.damping, "damping goes with stiffness: put it into the matrix A")
        if self.kinks is not None and parts:
            raise ParameterError("kinks", self.kinks, "kinks go with a function: PeriodicMatrix.pieces has edges")
        for name, part in parts.items():
            check_matrix(name, part)
            real_numbers(part.coefficients, name)
            if part.shape[0] != part.shape[1] or not part.shape[0]:
                raise ParameterError(
                    name, part.shape, f"a matrix of {size_of(part)} was given; it must be square, n×n for n coordinates"
                )
            if part.edges is not None:
                checked_edges(part.edges, max(part.coefficients.shape[-4], part.edges.shape[-1] - 1), part.period)
        if self.damping is not None and self.stiffness is not None:
            check_size("damping", self.damping, self.stiffness.shape)
            together("damping", self.damping.cases, self.stiffness.cases)

    def _twist(self) -> Array:
        """S as it is kept: a sign for every state, of q and q' alike."""
        n = self.states
        given: Any = self.twist
        twist: Array = np.asarray(real_numbers(numbers(given, "twist"), "twist"), np.float64)
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
            values = real_matrix(A(times)) if vectorised else sampled_singly(A, times)
            if values.ndim < 3 or values.shape[-3] != len(times) or not is_square(values):
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

        check_callable(A)
        if not is_length(period):
            raise no_period(period, "give the positive time after which A(t) repeats")
        return PeriodicSystem(
            period=float(period),
            function=sampled,
            kinks=kinks_within(kinks, float(period)),
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
        means: dict[str, Any] = {
            n: None if (m := getattr(self, n)) is None else averaged(m) for n in ("damping", "stiffness", "matrix")
        }
        inputs = self.inputs
        return replace(
            self,
            period=math.nan,
            twist=None,
            blade=None,
            blades=(),
            inputs=inputs and (lambda: averaged(inputs())),
            **means,
        )


for _name in ("damping", "stiffness"):
    delattr(PeriodicSystem, _name)  # a default on the class would hide that an equation has not made them yet
