"""One scalar equation: exponents of the map of its Hill form."""

from __future__ import annotations

import math

import numpy as np

from ..period_map import PeriodMap
from .result import EPS, Array, Stability, shaped, verdict_of


def of_hill(phi: PeriodMap) -> Stability:
    T, alpha, tau, D, b = phi.period, phi.mean, phi.half_trace, phi.discriminant, phi.discriminant_error
    assert phi.hill is not None and b is not None
    locked = D > b
    root = np.sqrt(np.where(locked, D, np.maximum(-D, 0.0)))
    growth = np.where(locked, np.arcsinh(root), 0.0) / T
    rho = rotation_number(phi)
    eta = np.stack([alpha + growth + 1j * rho, alpha - growth + 1j * np.where(locked, rho, -rho)], axis=-1)
    bound = _hill_bound(phi, root) / T + 4.0 * EPS * (np.abs(alpha) + np.abs(growth) + np.abs(rho))
    bound = np.where(np.isfinite(bound), bound, np.inf)  # a map that overflowed
    errors = np.stack([bound, bound], axis=-1)
    Lambda = np.exp(alpha * T)[:, None] * np.stack(
        [
            tau + np.where(locked, np.sign(tau) * root, 1j * root),
            tau - np.where(locked, np.sign(tau) * root, 1j * root),
        ],
        -1,
    )
    det = phi.hill[:, 0, 0] * phi.hill[:, 1, 1] - phi.hill[:, 0, 1] * phi.hill[:, 1, 0]
    # σ = α to rounding outside a lock; the bound of the set must not blur that
    sigma_error = np.where(D < -b, 8.0 * EPS * np.abs(alpha), bound)
    verdict, reason = verdict_of(
        eta.real, np.stack([sigma_error, sigma_error], axis=-1), neutral=(alpha == 0.0) & (D < -b)
    )
    return shaped(phi, eta, Lambda, errors, np.abs(det - 1.0), rho, np.where(locked, rho, np.nan), verdict, reason)


def rotation_number(phi: PeriodMap) -> Array:
    """ρ per radian: the fraction of a turn from Φ, its whole turns from the path."""
    assert phi.hill is not None and phi.turns is not None and phi.discriminant_error is not None
    tau, D = phi.half_trace, phi.discriminant
    unlocked = -np.sign(phi.hill[:, 1, 0]) * np.sqrt(np.maximum(-D, 0.0))
    fraction = np.mod(np.arctan2(np.where(D > phi.discriminant_error, 0.0, unlocked), tau) / (2.0 * math.pi), 1.0)
    return np.asarray(2.0 * math.pi / phi.period * (fraction + np.round(phi.turns - fraction)))


def _hill_bound(phi: PeriodMap, root: Array) -> Array:
    """Bound of the distance between the exact and the computed {±νT}.

    Away from a branch point √D moves by at most b/(√D + √(D-b)) and νT by that over |τ| (asinh) or, between complex
    pairs, by the angle that τ and √-D span together.  Next to it both may lie on either side: √D + √(D+b), through
    asinh and asin.
    """
    D, b = phi.discriminant, phi.discriminant_error
    assert b is not None and phi.half_trace_error is not None
    size = np.abs(D)
    away = size > b
    moved = b / (root + np.sqrt(np.maximum(size - b, 0.0)) + np.where(away, 0.0, 1.0))
    locked = moved / np.sqrt(1.0 + np.maximum(size - b, 0.0))
    angle = np.hypot(moved, phi.half_trace_error)
    near = np.sqrt(size) + np.sqrt(size + b)
    return np.where(away, np.where(D > 0, locked, angle), 0.5 * math.pi * near)
