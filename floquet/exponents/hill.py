"""One scalar equation: exponents of the map of its Hill form, see :mod:`floquet.kernels.closing`."""

from __future__ import annotations

import numpy as np

from ..kernels.closing import exponents_of
from ..period_map import PeriodMap
from .result import Stability, plain

__all__ = ["of_hill"]


def of_hill(phi: PeriodMap, *, compiled: bool | None = None) -> Stability:
    """[α+iρ, α-iρ], in a lock [σ₁+iρ, σ₂+iρ]; ``compiled``: by compiled kernels, however few the points."""
    assert phi.rows is not None and phi.methods is not None
    found, shape = exponents_of(phi.rows, phi.mean, phi.period, compiled=compiled), phi.shape
    bound = found["bound"].reshape(shape)
    full = {
        "determinant_defect": found["defect"],
        "rotation_number": found["rho"],
        "lock": found["lock"],
        "verdict": found["verdict"],
        "reason": found["reason"],
        "method": phi.methods,
        "panels": phi.panels,
    }
    return Stability(
        exponents=found["exponents"].reshape(*shape, 2),
        exponent_errors=np.stack([bound, bound], axis=-1),
        period=phi.period,
        **plain({name: value.reshape(shape) for name, value in full.items()}, shape),
    )
