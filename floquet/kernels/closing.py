"""From the map of a Hill form to exponents, for many points: τ and D in, σ, ρ, bound and verdict out.

With ``cosh νT = τ`` and ``sinh² νT = D``::

    D ≤ 0   α ± iρ
    D > 0   a lock: σ₁,₂ + iρ with σ = α ± asinh(√D)/T and ρ a multiple of π/T

The branch of ρ: a solution turns clockwise through y = 0, and no solution turns by as much as π more or less than
ρT.  Outside a lock no direction stays where it was, so ρT lies between the same multiples kπ and (k+1)π as the angle of
every solution; k is even if the first solution (1, 0) ends with Φ₂₁ < 0.  In a lock ρT = kπ, k even if τ > 0.  The
angle of the first solution, which passes y = 0 Z times, is Zπ ± π/2: parity picks k among Z and Z - 1, in a lock among
Z - 1, Z, Z + 1, the last where the solution has gone beyond Zπ.

An error b in D moves √D by at most b/(√D + √(D-b)) away from a branch point, and νT by that over |τ| (asinh) or,
between complex pairs, by the angle that τ and √-D span together.  Next to it both may lie on either side:
√D + √(D+b), through asinh and asin.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import available, worth_compiling
from .primitives import select

__all__ = ["closed", "exponents_of"]

Array = NDArray[np.float64]
EPS = float(np.finfo(float).eps)
STABLE, UNSTABLE, UNDECIDED = 0, 1, 2
DECIDED, NEUTRAL, BOUND = 0, 1, 2


arcsinh, arctan2 = np.arcsinh, np.arctan2  # compiled code has its own


def closed(m: Any, tau_error: Any, D: Any, b: Any, zeros: Any, alpha: Any, alpha_error: Any, T: Any) -> Any:
    """Growth beyond α, ρ, lock or not, bound, verdict, reason and | det Φ - 1 | of numbers or arrays.

    ``alpha_error`` is beyond α's own rounding.
    """
    tau, size = 0.5 * (m[0] + m[3]), abs(D)
    locked = D > b
    root = np.sqrt(select(D * select(locked, 1.0, -1.0) > 0.0, size, 0.0))
    growth = select(size < math.inf, select(locked, arcsinh(root), 0.0) / T, math.nan)  # nan: the map overflowed

    even = select(locked, tau > 0.0, m[2] < 0.0)
    matches = even != (zeros - 2.0 * np.floor(0.5 * zeros) > 0.5)
    k = select(matches, zeros, select(locked & (m[2] * m[0] < 0.0), zeros + 1.0, zeros - 1.0))
    angle = select(locked, 0.0, arctan2(root, select(even, tau, -tau)))
    rho = select(size < math.inf, k * (math.pi / T) + angle / T, math.nan)  # whole multiples of π/T without rounding

    away = size > b
    rest = select(away, size - b, 0.0)
    moved = b / (root + np.sqrt(rest) + select(away, 0.0, 1.0))
    beside = select(D > 0.0, moved / np.sqrt(1.0 + rest), np.sqrt(moved * moved + tau_error * tau_error))
    bound = select(away, beside, 0.5 * math.pi * (np.sqrt(size) + np.sqrt(size + b))) / T
    bound = bound + alpha_error + 8.0 * EPS * (abs(alpha) + growth + abs(rho))
    bound = select(bound < math.inf, bound, math.inf)  # nan too

    between = D < -b  # there σ = α to rounding; the bound of the set must not blur that
    blur = select(between, alpha_error + 8.0 * EPS * abs(alpha), bound)
    verdict = select(alpha + growth + blur < 0.0, STABLE, select(alpha + growth - blur > 0.0, UNSTABLE, UNDECIDED))
    reason = select(verdict != UNDECIDED, DECIDED, select((alpha == 0.0) & between, NEUTRAL, BOUND))
    return growth, rho, locked, bound, verdict, reason, abs(m[0] * m[3] - m[1] * m[2] - 1.0)


def exponents_of(
    rows: Array, alpha: Array, T: float, *, alpha_error: Array | float = 0.0, compiled: bool | None = None
) -> dict[str, NDArray[Any]]:
    """Exponents (n, 2) complex and what goes with them, of maps ``rows`` (:data:`floquet.kernels.hill.ROWS`, n).

    ``compiled`` says whether they stand for many more; by their number if left out.
    """
    n = rows.shape[1]
    out: dict[str, NDArray[Any]] = {"exponents": np.empty((n, 2), complex)}
    out |= {name: np.empty(n) for name in ("bound", "rho", "lock", "defect")}
    out |= {name: np.empty(n, np.int8) for name in ("verdict", "reason")}
    if np.ndim(alpha_error) == 0 and (worth_compiling(n) if compiled is None else compiled and available()):
        from . import hill_lanes as lanes

        parts = out["exponents"].view(float)
        lanes.close_rows(
            rows,
            alpha,
            float(alpha_error),
            T,
            parts,
            *(out[k] for k in ("bound", "rho", "lock", "defect", "verdict", "reason")),
        )
        return out
    with np.errstate(invalid="ignore", over="ignore"):
        growth, rho, locked, *rest = closed(tuple(rows[:4]), rows[4], rows[8], rows[5], rows[6], alpha, alpha_error, T)
    out["exponents"].real = np.stack([alpha + growth, alpha - growth], axis=-1)
    out["exponents"].imag = np.stack([rho, np.where(locked, rho, -rho)], axis=-1)
    out["rho"], out["lock"] = rho, np.where(locked, rho, np.nan)
    out["bound"], out["verdict"], out["reason"], out["defect"] = (
        rest[0], rest[1].astype(np.int8), rest[2].astype(np.int8), rest[3]
    )  # fmt: skip
    return out
