"""Identical blades: the exponents of N blades are those of one, η + ik for k = 0 … N-1, modulo N·i."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .result import EPS, Stability

__all__ = ["of_identical"]

SAME = 1e9  # parts of one per rev: frequencies and growths closer than 1e-9 are ordered as equal


def of_identical(blade: Stability, blades: int, period: float) -> Stability:
    """Stability in multiblade coordinates, conjugate pairs together by Im then Re, from that of one blade."""
    eta = np.asarray(blade.exponents)
    locked = ~np.isnan(np.asarray(blade.lock))[..., None]
    k = np.arange(blades)
    turning = _within(eta.imag[..., :1] + k, blades)  # of (α + iρ) and, in a lock, of both real parts
    first, second = eta.real[..., :1] + 1j * turning, eta.real[..., 1:] + 1j * np.where(locked, turning, -turning)
    values = np.concatenate([first, second], axis=-1)
    order = np.lexsort((values.imag < 0, -np.round(SAME * values.real), np.round(SAME * np.abs(values.imag))), axis=-1)
    values = np.take_along_axis(values, order, axis=-1)
    errors = np.asarray(blade.exponent_errors).max(axis=-1, keepdims=True) + EPS * np.abs(values)
    errors = np.where(np.isnan(values), np.inf, errors)  # a map that overflowed
    nan = np.full(eta.shape[:-1], np.nan)
    return replace(
        blade,
        exponents=values,
        exponent_errors=errors,
        rotation_number=nan if nan.ndim else float(nan),
        lock=nan if nan.ndim else float(nan),
        period=period,
    )


def _within(frequency: np.ndarray, blades: int) -> np.ndarray:
    """Frequencies modulo ``blades`` in (-N/2, N/2]."""
    return frequency - blades * np.ceil(frequency / blades - 0.5)
