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

from .arithmetic import PI, TWO_PI, fractions
from .equation import Equation, Parts
from .matrix import PeriodicMatrix, on_common_pieces
from .system import PeriodicSystem

__all__ = ["PI", "TWO_PI", "Equation", "Parts", "PeriodicMatrix", "PeriodicSystem", "fractions", "on_common_pieces"]
