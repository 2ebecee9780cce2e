"""Exponents that are proven: ball arithmetic with every truncation bounded.

A ball is a midpoint and a radius, and every operation on balls (python-flint, which is at home here) gives a ball that
holds every result of numbers in its operands.  What is left to prove by hand is what is cut off, in three theorems:

========  =======================  =================================================================================
theorem   file                     what it bounds
========  =======================  =================================================================================
1         :mod:`.series`           what a Taylor polynomial leaves out, by its defect
2         :mod:`.scalar`           whole turns: one equation's exponents on the branch of the rotation number
3         :mod:`.discs`            eigenvalues of a matrix of balls, clusters with their number
========  =======================  =================================================================================

Parameters are exact: a float is the number it stores, a Fraction itself; as a period or an edge, a Fraction is a
multiple of π.  A verdict STABLE or UNSTABLE is a theorem about the equation with those numbers.
"""

from __future__ import annotations

from ..errors import InputError

try:
    import flint  # noqa: F401  here only, so that what is missing is said in a sentence
except ImportError:
    raise InputError("certificates need python-flint: install floquet-rotor[certify]") from None

from .given import certify
from .result import Certificate
from .scalar import certified_hill
from .systems import certified_constant, certified_system, companion

__all__ = ["Certificate", "certified_constant", "certified_hill", "certified_system", "certify", "companion"]
