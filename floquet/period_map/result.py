"""What a map over one period is: Φ of a Hill form, or factors, with an error each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..rotor import Word

__all__ = ["Method", "PeriodMap"]

Array = NDArray[np.float64]


class Method(Word):
    """How exponents were found."""

    HILL = 0  # Taylor series of the Hill form of one scalar equation
    FACTORS = 1  # maps of the states panel by panel, exponents from the factors
    EIGENVALUES = 2  # constant coefficients
    PRECISE = 3  # the Hill form from exact coefficients in forty digits, next to branch points
    CERTIFIED = 5  # ball arithmetic with every truncation bounded
    MAP = 4  # the Hill form between nodes of a tensor grid


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodMap:
    """Φ over one period with its error.

    Attributes
    ----------
    method : Method
    period : float
    twist : (n,) or None
        The motion after a period is twist·Φ.
    rows : (9, cases)
        Φ of the Hill form, determinant 1, and bounds: :data:`floquet.kernels.hill.ROWS` (methods HILL and MAP).
    methods : (cases,)
        How each case was found: HILL, PRECISE or MAP (HILL and MAP).
    factors : tuple of (panels, n, n)
        One a case, first panel first (method FACTORS only).
    errors : tuple of (panels,)
        Bound of the Frobenius norm of each factor's error (FACTORS).
    mean : (cases,)
        α = -mean(d)/2 (HILL and MAP), or the mean trace of A (FACTORS).
    states : int
    panels : (cases,)
    shape : tuple
        Shape of the cases.
    """

    method: Method
    period: float
    shape: tuple[int, ...]
    mean: Array
    panels: NDArray[np.int32]
    twist: Array | None = None
    rows: Array | None = None
    methods: NDArray[np.int8] | None = None
    factors: tuple[Array, ...] = ()
    errors: tuple[Array, ...] = ()
    states: int = 2

    @property
    def hill(self) -> Array:
        """Φ of the Hill form, (cases, 2, 2)."""
        assert self.rows is not None
        return np.moveaxis(self.rows[:4].reshape(2, 2, -1), -1, 0)

    @property
    def half_trace(self) -> Array:
        """τ = ½ tr Φ of the Hill form: |τ| ≤ 1 is a complex pair, |τ| > 1 a lock."""
        assert self.rows is not None
        return 0.5 * (self.rows[0] + self.rows[3])

    @property
    def discriminant(self) -> Array:
        """((Φ₁₁-Φ₂₂)/2)² + Φ₁₂ Φ₂₁ = τ² - 1 without the cancellation; positive in a lock."""
        assert self.rows is not None
        return self.rows[8]
