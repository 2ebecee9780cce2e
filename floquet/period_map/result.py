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

    HILL = 0  # collocation of the Hill form of one scalar equation
    FACTORS = 1  # collocation of the states, exponents from the factors
    EIGENVALUES = 2  # constant coefficients


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodMap:
    """Φ over one period with its error.

    Attributes
    ----------
    method : Method
    period : float
    twist : (n,) or None
        The motion after a period is twist·Φ.
    hill : (cases, 2, 2)
        Φ of the Hill form (method HILL only), determinant 1.
    factors : tuple of (panels, n, n)
        One a case, first panel first (method FACTORS only).
    half_trace_error, discriminant_error : (cases,)
        Bounds of the errors of τ and D (HILL).
    errors : tuple of (panels,)
        Bound of the Frobenius norm of each factor's error (FACTORS).
    mean : (cases,)
        α = -mean(d)/2 (HILL), or the mean trace of A (FACTORS).
    states : int
    turns : (cases,)
        Revolutions of (y, y') clockwise, less than half a turn from the rotation number (HILL; else nan).
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
    hill: Array | None = None
    factors: tuple[Array, ...] = ()
    half_trace_error: Array | None = None
    discriminant_error: Array | None = None
    errors: tuple[Array, ...] = ()
    turns: Array | None = None
    states: int = 2

    @property
    def half_trace(self) -> Array:
        """τ = ½ tr Φ of the Hill form: |τ| ≤ 1 is a complex pair, |τ| > 1 a lock."""
        assert self.hill is not None
        return 0.5 * (self.hill[:, 0, 0] + self.hill[:, 1, 1])

    @property
    def discriminant(self) -> Array:
        """((Φ₁₁-Φ₂₂)/2)² + Φ₁₂ Φ₂₁ = τ² - 1 without the cancellation; positive in a lock."""
        assert self.hill is not None
        return (0.5 * (self.hill[:, 0, 0] - self.hill[:, 1, 1])) ** 2 + self.hill[:, 0, 1] * self.hill[:, 1, 0]
