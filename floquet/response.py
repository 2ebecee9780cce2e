"""Response of a rotor to controls, inflow and body motion: steady, periodic, in time, and of reduced order.

========================  =============================================================================================
:func:`steady_state`      a = K̃⁻¹ F̃ u of a constant model, eq. (12) of NASA TP-1431 (eqs. 13a–c at hover are
                          :func:`floquet.models.hover_response`)
:func:`periodic_response` the response of the periodic equations that repeats with them, and its harmonics: what (12)
                          approximates
:func:`reduced_order`     ȧ = −D̃⁻¹K̃ a + D̃⁻¹F̃ u, eq. (11)
:func:`step_response`     motion from rest after a step of the inputs, of any model
========================  =============================================================================================

Inputs are given by name (:mod:`floquet.models.inputs`), in radians and per rev; responses are in radians.  All models
are linear, so a response per degree of pitch is the same number in degrees.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FloquetWarning, ParameterError
from .models import input_vector
from .passage import passage
from .period_map import EPS, ROUNDING
from .periodic import PeriodicMatrix, PeriodicSystem

__all__ = [
    "PeriodicResponse", "StepResponse", "flap_angle", "periodic_response", "reduced_order", "steady_gains",
    "steady_state", "step_response", "tip_path_plane_gains",
]  # fmt: skip

Array = NDArray[np.float64]
Inputs = Mapping[str, ArrayLike]
RESONANT = 1e-13  # least singular value of I − Φ, relative to Φ, below which no digit of a response is left
SAMPLES = 64  # azimuths of a revolution: harmonics up to 31; those of a blade are at rounding from the twentieth on


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodicResponse:
    """The response that repeats every revolution.

    Attributes
    ----------
    coordinates : tuple of str
    azimuths : float (64,)
    values, rates : float (..., 64, n)
        Of the coordinates [rad] and their derivatives [rad per rad of azimuth].
    harmonics : complex (..., 32, n)
        c_h with q(ψ) = Σ_h Re c_h e^{ihψ}: the cosine's coefficient is Re c_h, the sine's −Im c_h.
    error : float (...)
        Bound of the error of the values.
    harmonic_error : float (...)
        Bound of the error of the harmonics: that of the values, and what lies beyond the last harmonic (with reversed
        flow harmonics fall off slowly).
    """

    coordinates: tuple[str, ...]
    azimuths: Array
    values: Array
    rates: Array
    harmonics: NDArray[np.complex128]
    error: Any
    harmonic_error: Any

    @property
    def tip_path_plane(self) -> Array:
        """Its (a₀, a₁, b₁), (..., 3): the first harmonics of a blade, the means of multiblade coordinates."""
        plane = _plane(np.moveaxis(self.harmonics, -1, -2)[..., None], self.coordinates)
        return plane[..., 0]


@dataclass(frozen=True, eq=False, kw_only=True)
class StepResponse:
    """Motion after a step: ``values`` (..., k, n) [rad] of ``coordinates`` at ``azimuths`` (k,), bound ``error``."""

    coordinates: tuple[str, ...]
    azimuths: Array
    values: Array
    error: Any

    @property
    def tip_path_plane(self) -> Array:
        """(a₀, a₁, b₁) (..., k, 3) of the tip-path plane or of multiblade coordinates; one blade has none."""
        return _plane(np.swapaxes(self.values, -1, -2)[..., None, :], self.coordinates).swapaxes(-1, -2)


# ---------------------------------------------------------------------- constant models
def steady_gains(system: PeriodicSystem) -> Array:
    """K⁻¹F (..., n, inputs) of a constant model: its steady state per unit of each input, eq. (12)."""
    _, K, F = _constant(system)
    if np.any(np.linalg.cond(K) > 1.0 / EPS):
        raise ParameterError(
            "stiffness", system.name, "the model diverges: its stiffness is singular, nothing is steady"
        )
    return np.asarray(np.linalg.solve(K, F))


def steady_state(system: PeriodicSystem, inputs: Inputs) -> Array:
    """The steady state (..., n) of a constant model, eq. (12), such as ``tip_path_plane(rotor, advance_ratio)``.

    Of a periodic one, whose steady state is no constant, take :func:`periodic_response`.
    """
    return np.asarray((steady_gains(system) @ _vector(system, inputs)[..., None])[..., 0])


def reduced_order(system: PeriodicSystem) -> PeriodicSystem:
    """The first-order model of a constant second-order one, eq. (11): what is left when q'' is set to zero."""
    D, K, F = _constant(system)
    if np.any(np.linalg.cond(D) > 1.0 / EPS):
        raise ParameterError("damping", system.name, "eq. (11) divides by the damping matrix, and this one is singular")
    A, B = -np.linalg.solve(D, K), np.linalg.solve(D, F)
    return PeriodicSystem(
        period=math.nan,
        matrix=PeriodicMatrix.constant(A),
        inputs=lambda: PeriodicMatrix.constant(B),
        input_names=system.input_names,
        coordinates=system.coordinates,
        name=f"{system.name}, reduced order",
    )


def _constant(system: PeriodicSystem) -> tuple[Array, Array, Array]:
    """D, K and F of a constant second-order model."""
    if not system.constant or system.damping is None or system.stiffness is None or system.forcing is None:
        raise ParameterError(
            "system",
            system.name,
            f"{system.name or 'this system'} is no constant second-order model with inputs: give tip_path_plane(…) or "
            "averaged(…), or use periodic_response for the periodic equations",
        )
    return system.damping.mean(), system.stiffness.mean(), system.forcing.mean()


# ---------------------------------------------------------------------- periodic steady state
def periodic_response(system: PeriodicSystem, inputs: Inputs) -> PeriodicResponse:
    """The response of a periodic system that repeats every revolution.

    Parameters
    ----------
    system : PeriodicSystem
        Of :func:`floquet.flapping`, ``teetering`` or ``multiblade``, in the last of which it is the response of every
        blade of the rotor.
    inputs : name → value
        Constant; arrays broadcast with the system's cases.

    Where the rotor is unstable the response exists, but the motion grows away from it: a warning says so.  Where an
    exponent is zero no response repeats: it is nan, its error inf.
    """
    X, error = _periodic_states(system)
    u = _vector(system, inputs)
    x = (X @ u[..., None, :, None])[..., 0]
    n = system.degrees
    harmonics = _harmonics(x[..., :n])
    bound = np.sum(error * np.abs(u), axis=-1)
    beyond = SAMPLES / 2 * np.abs(harmonics[..., -4:, :]).max(axis=(-2, -1))
    return PeriodicResponse(
        coordinates=system.coordinates,
        azimuths=_revolution(system)[:-1],
        values=x[..., :n],
        rates=x[..., n:] if system.second_order else np.full_like(x, np.nan),
        harmonics=harmonics,
        error=_plain(np.where(np.isnan(bound), np.inf, bound)),
        harmonic_error=_plain(np.where(np.isnan(bound), np.inf, bound + beyond)),
    )


def tip_path_plane_gains(system: PeriodicSystem) -> Array:
    """(a₀, a₁, b₁) per unit of each input, (..., 3, inputs), of the steady response of any rotor model.

    Of a periodic model these are the harmonics of its exact response; of the tip-path plane they are K̃⁻¹F̃, with a₀ = 0
    for a teetering rotor.
    """
    if system.constant:
        return _plane(steady_gains(system)[..., None, :] + 0j, system.coordinates)
    X, _ = _periodic_states(system)
    states = np.moveaxis(X[..., : system.degrees, :], -1, 0)
    return _plane(np.moveaxis(np.moveaxis(_harmonics(states), 0, -1), -3, -2), system.coordinates)


def _plane(harmonics: NDArray[Any], coordinates: tuple[str, ...]) -> Array:
    """(a₀, a₁, b₁) (..., 3, m) from the harmonics (..., n, h, m) of the coordinates."""
    if coordinates == ("beta",) and harmonics.shape[-2] > 1:
        mean, first = harmonics[..., 0, 0, :], harmonics[..., 0, 1, :]
        return np.stack([mean.real, -first.real, first.imag], axis=-2)
    signs = {"beta_0": 1.0, "beta_1c": -1.0, "beta_1s": -1.0, "a_0": 1.0, "a_1": 1.0, "b_1": 1.0}
    rows = {name: signs[name] * harmonics[..., i, 0, :].real for i, name in enumerate(coordinates) if name in signs}
    names = ("beta_0", "beta_1c", "beta_1s") if "beta_0" in rows else ("a_0", "a_1", "b_1")
    if names[1] not in rows:
        raise ParameterError("system", coordinates, f"coordinates {', '.join(coordinates)} have no tip-path plane")
    return np.asarray(np.stack([rows.get(name, np.zeros_like(rows[names[1]])) for name in names], axis=-2))


def _revolution(system: PeriodicSystem) -> Array:
    """Azimuths over the longest period of the parts, both ends."""
    parts = (system.damping, system.stiffness, system.matrix, system.forcing)
    periods = [part.period for part in parts if part is not None] + [system.period] * (system.function is not None)
    longest = max(periods)
    if any(abs(longest / period - round(longest / period)) > 1e-9 for period in periods):
        raise ParameterError(
            "period", periods, f"parts with the periods {', '.join(f'{p:g}' for p in periods)} do not repeat together"
        )
    return np.linspace(0.0, longest, SAMPLES + 1)


def _harmonics(values: Array) -> NDArray[np.complex128]:
    """c_h (..., SAMPLES/2, n) of values (..., SAMPLES, n), one-sided."""
    c = np.fft.rfft(values, axis=-2)[..., : SAMPLES // 2, :] / SAMPLES
    c[..., 1:, :] *= 2.0
    return np.asarray(c)


def _periodic_states(system: PeriodicSystem) -> tuple[Array, Array]:
    """X (..., SAMPLES, states, inputs) per unit of each input, and the bound of its error (..., inputs).

    x₀ = (I − Φ)⁻¹ Γ over a revolution.  The bound is the difference from a coarser rule and a rounding error a panel,
    passed on by (I − Φ)⁻¹.
    """
    if system.constant or system.forcing is None:
        raise ParameterError(
            "system",
            system.name,
            f"{system.name or 'this system'} has no periodic response: it "
            + ("is constant, so use steady_state" if system.constant else "has no inputs"),
        )
    psi = _revolution(system)
    X, amplification, panels = _repeating(system, psi)
    coarse = _repeating(system, psi, coarse=True)[0]
    scale = np.abs(X).max(axis=(-3, -2))
    return X, np.abs(X - coarse).max(axis=(-3, -2)) + ROUNDING * EPS * panels * amplification[..., None] * scale


def _repeating(system: PeriodicSystem, psi: Array, *, coarse: bool = False) -> tuple[Array, Array, int]:
    """States at all azimuths but the last that repeat after them, how much (I − Φ)⁻¹ and Φ amplify, and the panels."""
    found = passage(system, psi, forced=True, coarse=coarse)
    n, m = found.inputs.shape[-2:]
    Phi, Gamma = found.fundamental()[..., -1, :, :], found.states(np.zeros((n, m)))[..., -1, :, :]
    if not coarse and np.any(np.abs(np.linalg.eigvals(Phi)) > 1.0 + 1e-9):
        warnings.warn(
            f"{system.name or 'the system'} is unstable: the periodic response exists, but motion grows away from it",
            FloquetWarning,
            stacklevel=4,
        )
    I_Phi, size = np.eye(n) - Phi, 1.0 + np.linalg.norm(Phi, axis=(-2, -1))
    resonant = (np.linalg.svd(I_Phi, compute_uv=False)[..., -1] < RESONANT * size)[..., None, None]
    inverse = np.where(resonant, np.nan, np.linalg.inv(np.where(resonant, np.eye(n), I_Phi)))
    amplification = np.linalg.norm(inverse, axis=(-2, -1)) * size
    return found.states(inverse @ Gamma)[..., :-1, :, :], amplification, found.panels


# ---------------------------------------------------------------------- time
def step_response(
    system: PeriodicSystem, inputs: Inputs, azimuths: ArrayLike, *, initial: ArrayLike | None = None
) -> StepResponse:
    """Motion of any model when the inputs step to constant values at the first azimuth.

    Parameters
    ----------
    system : PeriodicSystem
        Constant or periodic, of first or second order.
    inputs : name → value
        Arrays broadcast with the system's cases.
    azimuths : (k,)
        Ascending [rad]; seconds are ψ/Ω.  The first is where the step happens, which matters to a periodic system.
    initial : (..., states), optional
        The state at the first azimuth; rest if left out.
    """
    psi = np.asarray(azimuths, float)
    if psi.ndim != 1 or len(psi) < 2 or not np.all(np.diff(psi) > 0) or not np.all(np.isfinite(psi)):
        raise ParameterError(
            "azimuths",
            azimuths,
            "a response is asked for at two or more finite azimuths, each larger than the one before",
        )
    if system.forcing is None:
        raise ParameterError("system", system.name, f"{system.name or 'this system'} has no inputs to step")
    u, n = _vector(system, inputs), system.states
    start = np.zeros(n) if initial is None else np.asarray(initial, float)
    if start.shape[-1:] != (n,):
        raise ParameterError(
            "initial", start.shape, f"shape {start.shape} is no state of {n} entries: give positions, then rates"
        )
    x, panels = _moved(system, psi, u, start)
    coarse, _ = _moved(system, psi, u, start, coarse=True)
    scale = np.abs(x).max(axis=(-2, -1))
    return StepResponse(
        coordinates=system.coordinates,
        azimuths=psi,
        values=x[..., : system.degrees],
        error=_plain(np.abs(x - coarse).max(axis=(-2, -1)) + ROUNDING * EPS * panels * scale),
    )


def _moved(system: PeriodicSystem, psi: Array, u: Array, start: Array, *, coarse: bool = False) -> tuple[Array, int]:
    """States (..., k, states) under constant inputs u (..., m)."""
    found = passage(system, psi, forced=True, coarse=coarse)
    return found.states(start[..., None], u[..., None])[..., 0], found.panels


def flap_angle(plane: ArrayLike, azimuths: ArrayLike, precone: float = 0.0) -> Array:
    """β = a₀ − a₁ cos ψ − b₁ sin ψ: eq. (5) of planes (..., k, 3), eq. (8) of (a₁, b₁) (..., k, 2) with ``precone``."""
    a, psi = np.asarray(plane, float), np.asarray(azimuths, float)
    a0 = a[..., 0] if a.shape[-1] == 3 else precone
    return np.asarray(a0 - a[..., -2] * np.cos(psi) - a[..., -1] * np.sin(psi))


def _plain(value: Array) -> Any:
    """A Python number of a single case."""
    return value if np.ndim(value) else float(value)


def _vector(system: PeriodicSystem, inputs: Inputs) -> Array:
    return input_vector(inputs, system.input_names)
