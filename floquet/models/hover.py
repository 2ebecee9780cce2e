"""Closed forms at hover: modes, eqs. (9) and (10), and steady response, eqs. (13a–c), of NASA TP-1431.

At hover one blade is ``β'' + c₀ β' + P² β = f``, and the tip-path plane is that blade in the non-rotating frame::

    coning       ω_n = P,                              ζ   = c₀/(2P)                          (9)
    advancing    ω_n = √(1 + P² + 2P √(1 − ζ²)),       ζ_A = ζ P/ω_nA                         (10a)
    regressing   ω_n = √(1 + P² − 2P √(1 − ζ²)),       ζ_R = ζ P/ω_nR                         (10b)

The report leaves out the factor P of ζ_A and ζ_R; with it, both pairs have the blade's damping −ζP = −c₀/2.  Above
critical damping (ζ > 1) the blade has two real exponents and the plane −ζP ± P√(ζ² − 1) ± i: neither pair regresses or
advances, and the faster decay is called regressing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ParameterError
from ..rotor import Hub, Rotor, plain
from .flapping import blade
from .inputs import FORCING, input_vector
from .physics import Physics, PhysicsKeywords, advance_ratios

__all__ = ["HoverMode", "HoverModes", "hover_coefficients", "hover_modes", "hover_response"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class HoverMode:
    """``frequency`` ω_n [per rev] and ``damping_ratio`` ζ (...); ``exponents`` [per rev] (..., 2)."""

    frequency: Any
    damping_ratio: Any
    exponents: NDArray[np.complex128]


@dataclass(frozen=True, eq=False, kw_only=True)
class HoverModes:
    """The three modes; ``overdamped`` (...) where ζ > 1."""

    coning: HoverMode
    advancing: HoverMode
    regressing: HoverMode
    overdamped: Any


def hover_coefficients(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> tuple[Array, Array]:
    """c₀ and P² of the blade at hover, (...) each; P² keeps the truncated part of K₁ unless ``exact_offset``."""
    one = blade(rotor, 0.0, **options)
    assert one.damping is not None and one.stiffness is not None
    return one.damping.mean()[..., 0, 0], one.stiffness.mean()[..., 0, 0]


def hover_modes(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> HoverModes:
    """Modes of the tip-path plane at hover, eqs. (9) and (10), overdamped ones included.

    Parameters
    ----------
    rotor : Rotor
        With P² > 0 (frequencies are nan where a negative K₁ outweighs the other springs); arrays give arrays.
    **options
        As in :func:`floquet.flapping`.
    """
    _with_coning(rotor)
    c0, P2 = hover_coefficients(rotor, **options)
    P = np.sqrt(np.where(P2 > 0, P2, np.nan))
    zeta = 0.5 * c0 / P
    over = zeta > 1.0
    swing = P * np.sqrt(np.where(over, 0.0, 1.0 - zeta**2))
    spread = P * np.sqrt(np.where(over, zeta**2 - 1.0, 0.0))
    advancing = np.where(over, np.hypot(zeta * P - spread, 1.0), np.sqrt(1.0 + P2 + 2.0 * swing))
    regressing = np.where(over, np.hypot(zeta * P + spread, 1.0), np.sqrt(1.0 + P2 - 2.0 * swing))
    return HoverModes(
        coning=HoverMode(frequency=plain(P), damping_ratio=plain(zeta), exponents=_pair(-zeta * P, spread, swing)),
        advancing=_mode(advancing, zeta * P - spread, swing + 1.0),
        regressing=_mode(regressing, zeta * P + spread, np.abs(swing - 1.0)),
        overdamped=plain(over),
    )


def _mode(frequency: Array, decay: Array, turning: Array) -> HoverMode:
    return HoverMode(
        frequency=plain(frequency), damping_ratio=plain(decay / frequency), exponents=_pair(-decay, 0.0, turning)
    )


def _pair(sigma: Array, spread: Array | float, omega: Array) -> NDArray[np.complex128]:
    """σ ± spread ± iω, of which one is zero."""
    half = spread + 1j * omega
    return np.stack(np.broadcast_arrays(sigma + half, sigma - half), axis=-1)


def hover_response(
    rotor: Rotor, inputs: Mapping[str, ArrayLike], **options: Unpack[PhysicsKeywords]
) -> tuple[Any, Any, Any]:
    """Steady (a₀, a₁, b₁) at hover, eqs. (13a–c), for inputs by name (:data:`~floquet.models.FORCING`).

    With M_a, M_b the cyclic moments, Δ = (P² − 1)² + c₀²::

        a₀ = f₀/P²,    a₁ = ((P² − 1) M_a − c₀ M_b)/Δ,    b₁ = (c₀ M_a + (P² − 1) M_b)/Δ
    """
    _with_coning(rotor)
    forcing = blade(rotor, 0.0, **options).forcing
    assert forcing is not None
    c0, P2 = hover_coefficients(rotor, **options)
    steady = forcing.mean()[..., 0, :]
    u = input_vector(inputs, FORCING)
    theta_0, A, B, theta_t, inflow, p, q, pdot, qdot, normal = np.moveaxis(u, -1, 0)
    control, twist, through, static = (
        steady[..., FORCING.index(n)] for n in ("theta_0", "theta_t", "lambda", FORCING[-1])
    )
    m = np.asarray(rotor.offset_mass_ratio)
    acceleration = 1.0 + m if Physics.of(options).kinematic_rates else 1.0
    M_a = control * (A - q) - 2.0 * (1.0 + m) * p - acceleration * qdot
    M_b = control * (B - p) + 2.0 * (1.0 + m) * q - acceleration * pdot
    delta = (P2 - 1.0) ** 2 + c0**2
    a0 = (control * theta_0 + twist * theta_t + through * inflow + static * normal) / P2
    a1 = ((P2 - 1.0) * M_a - c0 * M_b) / delta
    b1 = (c0 * M_a + (P2 - 1.0) * M_b) / delta
    return plain(a0), plain(a1), plain(b1)


def _with_coning(rotor: Rotor) -> None:
    advance_ratios(0.0, rotor)
    if rotor.hub == Hub.TEETERING:
        raise ParameterError(
            "hub",
            rotor.hub,
            "a teetering rotor has no coning, which eqs. (9) and (13a) are of: use tip_path_plane(rotor, 0.0) with "
            "stability() or steady_state()",
        )
