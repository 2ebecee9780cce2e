"""The equations of a model as functions of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arithmetic import (
    fractions,
)
from .matrix import PeriodicMatrix

Array = NDArray[np.float64]
Index = slice | NDArray[np.intp]
IMAGINARY = 2.0**-300  # a step whose square is far below the last bit of anything


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
