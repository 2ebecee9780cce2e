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
from .passage import Passage, passage
from .period_map import EPS
from .periodic import PeriodicMatrix, PeriodicSystem
from .rotor import plain

__all__ = [
    "PeriodicResponse", "StepResponse", "flap_angle", "periodic_response", "reduced_order", "steady_gains",
    "steady_state", "step_response", "tip_path_plane_gains",
]  # fmt: skip

Array = NDArray[np.float64]
Inputs = Mapping[str, ArrayLike]
RESONANT = 1e-13  # least singular value of I − Φ, relative to Φ, below which no digit of a response is left
SAMPLES, HARMONICS = 128, 32  # of a revolution; harmonics of a blade are at rounding from the twentieth on


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodicResponse:
    """The response that repeats every revolution.

    Attributes
    ----------
    coordinates : tuple of str
    azimuths : float (k,)
        128, or more for rotors of many blades.
    values, rates : float (..., k, n)
        Of the coordinates [rad] and their derivatives [rad per rad of azimuth]; rates of a first-order system are nan.
    harmonics : complex (..., 32, n)
        c_h with q(ψ) = Σ_h Re c_h e^{ihψ}: the cosine's coefficient is Re c_h, the sine's −Im c_h.
    error : float (...)
        Bound of the error of the values.
    harmonic_error : float (...)
        Bound of the error of the harmonics: that of the values, and the size of the harmonics 32 to k/2 (with reversed
        flow they fall off slowly), beside which what lies beyond is small.
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
    singular = (np.linalg.cond(K) > 1.0 / EPS)[..., None, None]
    if np.any(singular) or np.any(np.linalg.eigvals(system.sample(np.zeros(1))).real > 1e-9):
        warnings.warn(
            f"{system.name or 'the model'} is unstable: motion grows away from its steady state, and there is none "
            "where the stiffness is singular",
            FloquetWarning,
            stacklevel=3,
        )
    return np.where(singular, np.nan, np.linalg.solve(np.where(singular, np.eye(K.shape[-1]), K), F))


def steady_state(system: PeriodicSystem, inputs: Inputs) -> Array:
    """The steady state (..., n) [rad] of a constant model, eq. (12), such as ``tip_path_plane(rotor, advance_ratio)``.

    Of a periodic one, whose steady state is no constant, take :func:`periodic_response`.  Where the model is unstable
    a warning says so; where its stiffness is singular the state is nan.
    """
    u = _vector(_checked(system), inputs)
    return np.asarray((steady_gains(system) @ u[..., None])[..., 0])


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
    if not _checked(system).constant or system.damping is None or system.stiffness is None or system.forcing is None:
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
    u = _vector(_checked(system), inputs)
    psi, X, error = _periodic_states(system)
    x = (X @ u[..., None, :, None])[..., 0]
    n = system.degrees
    harmonics, beyond = _harmonics(x[..., :n])
    bound = np.sum(error * np.abs(u), axis=-1)
    return PeriodicResponse(
        coordinates=system.coordinates,
        azimuths=psi,
        values=x[..., :n],
        rates=x[..., n:] if system.second_order else np.full_like(x, np.nan),
        harmonics=harmonics,
        error=plain(np.where(np.isnan(bound), np.inf, bound)),
        harmonic_error=plain(np.where(np.isnan(bound), np.inf, bound + beyond.max(axis=-1))),
    )


def tip_path_plane_gains(system: PeriodicSystem) -> Array:
    """(a₀, a₁, b₁) per unit of each input, (..., 3, inputs), of the steady response of any rotor model.

    Of a periodic model these are the harmonics of its exact response; of the tip-path plane they are K̃⁻¹F̃, with a₀ = 0
    for a teetering rotor.
    """
    if _checked(system).constant:
        return _plane(steady_gains(system)[..., None, :] + 0j, system.coordinates)
    _, X, _ = _periodic_states(system)
    states = np.moveaxis(X[..., : system.degrees, :], -1, 0)
    return _plane(np.moveaxis(np.moveaxis(_harmonics(states)[0], 0, -1), -3, -2), system.coordinates)


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


def _revolution(system: PeriodicSystem, forcing: PeriodicMatrix) -> Array:
    """Azimuths over the longest period of the parts, both ends: 128, or four to the highest harmonic of a part."""
    parts = [p for p in (system.damping, system.stiffness, system.matrix, forcing) if p is not None]
    periods = [part.period for part in parts] + [system.period] * (system.function is not None)
    longest = max(periods)
    if any(abs(longest / period - round(longest / period)) > 1e-9 for period in periods):
        raise ParameterError(
            "period", periods, f"parts with the periods {', '.join(f'{p:g}' for p in periods)} do not repeat together"
        )
    highest = max(part.order * longest / part.period for part in parts)
    samples = max(SAMPLES, 2 ** math.ceil(math.log2(4.0 * max(highest, 1.0))))
    return np.linspace(0.0, longest, samples + 1)


def _harmonics(values: Array) -> tuple[NDArray[np.complex128], Array]:
    """c_h (..., HARMONICS, n) of values (..., samples, n), one-sided, and the size (..., n) of those beyond.

    What lies beyond half of the samples is counted to a harmonic that lies before; it is less than what lies between.
    """
    c = np.fft.rfft(values, axis=-2) / values.shape[-2]
    c[..., 1:, :] *= 2.0
    return np.asarray(c[..., :HARMONICS, :]), np.abs(c[..., HARMONICS:, :]).sum(axis=-2)


def _periodic_states(system: PeriodicSystem) -> tuple[Array, Array, Array]:
    """Azimuths (k,), X (..., k, states, inputs) per unit of each input, and the bound of its error (..., inputs).

    The rounding of one revolution, E (:meth:`Passage.rounding`), and of solving for the start x₀ = (I − Φ)⁻¹ Γ makes
    (I − Φ)⁻¹ E (I − Φ)⁻ᵀ of the start, which is passed on like the start itself; truncation is the difference from a
    coarser rule.
    """
    forcing = system.forcing
    if system.constant or forcing is None:
        raise ParameterError(
            "system",
            system.name,
            f"{system.name or 'this system'} has no periodic response: it "
            + ("is constant, so use steady_state" if system.constant else "has no inputs"),
        )
    psi = _revolution(system, forcing)
    fine, less = (passage(system, psi, forcing=forcing, coarse=coarse) for coarse in (False, True))
    start, inverse, unstable = _start(fine)
    if unstable:
        warnings.warn(
            f"{system.name or 'the system'} is unstable: the periodic response exists, but motion grows away from it",
            FloquetWarning,
            stacklevel=3,
        )
    x = fine.states(start)
    E = fine.rounding(x)[1]
    whole = 1.0 + np.sum(fine.fundamental()[..., -1, :, :] ** 2, axis=(-2, -1))[..., None]
    solving = EPS**2 * whole * np.sum(start * start, axis=-2)
    back = inverse[..., None, :, :]
    E = back @ (E + solving[..., None, None] * np.eye(start.shape[-2])) @ np.swapaxes(back, -1, -2)
    rounding = fine.rounding(x, E)[0].max(axis=-2)
    X = fine.at_outputs(x)[..., :-1, :, :]
    other = less.at_outputs(less.states(_start(less)[0]))[..., :-1, :, :]
    return psi[:-1], X, np.abs(X - other).max(axis=(-3, -2)) + rounding


def _start(found: Passage) -> tuple[Array, Array, bool]:
    """x₀ = (I − Φ)⁻¹ Γ of a revolution, nan where that does not exist; (I − Φ)⁻¹; whether a multiplier is above 1."""
    n, m = found.inputs.shape[-2:]
    Phi, Gamma = found.fundamental()[..., -1, :, :], found.states(np.zeros((n, m)))[..., -1, :, :]
    I_Phi, size = np.eye(n) - Phi, 1.0 + np.linalg.norm(Phi, axis=(-2, -1))
    resonant = (np.linalg.svd(I_Phi, compute_uv=False)[..., -1] < RESONANT * size)[..., None, None]
    inverse = np.where(resonant, np.nan, np.linalg.inv(np.where(resonant, np.eye(n), I_Phi)))
    unstable = bool(np.any(np.abs(np.linalg.eigvals(Phi)) > 1.0 + 1e-9))
    return inverse @ Gamma, inverse, unstable


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
    psi = _numbers("azimuths", azimuths)
    if psi.ndim != 1 or len(psi) < 2 or not np.all(np.diff(psi) > 0):
        raise ParameterError(
            "azimuths",
            azimuths,
            "a response is asked for at two or more azimuths, each larger than the one before",
        )
    forcing = _checked(system).forcing
    if forcing is None:
        raise ParameterError("system", system.name, f"{system.name or 'this system'} has no inputs to step")
    n = system.states
    start = _numbers("initial", np.zeros(n) if initial is None else initial)
    if start.shape[-1:] != (n,):
        raise ParameterError(
            "initial", start.shape, f"shape {start.shape} is no state of {n} entries: give positions, then rates"
        )
    u = _vector(system, inputs, start.shape[:-1])
    fine, less = (passage(system, psi, forcing=forcing, coarse=coarse) for coarse in (False, True))
    ends = fine.states(start[..., None], u[..., None])
    x, other = fine.at_outputs(ends)[..., 0], less.at_outputs(less.states(start[..., None], u[..., None]))[..., 0]
    rounding = fine.rounding(ends)[0][..., 0].max(axis=-1)
    return StepResponse(
        coordinates=system.coordinates,
        azimuths=psi,
        values=x[..., : system.degrees],
        error=plain(np.abs(x - other).max(axis=(-2, -1)) + rounding),
    )


def flap_angle(plane: ArrayLike, azimuths: ArrayLike, precone: float = 0.0) -> Array:
    """β = a₀ − a₁ cos ψ − b₁ sin ψ: eq. (5) of planes (..., k, 3), eq. (8) of (a₁, b₁) (..., k, 2) with ``precone``."""
    a, psi = _numbers("plane", plane), _numbers("azimuths", azimuths)
    if a.shape[-1:] not in ((2,), (3,)):
        raise ParameterError("plane", a.shape, f"shape {a.shape} is no (a₀, a₁, b₁) or (a₁, b₁) along the last axis")
    a0 = a[..., 0] if a.shape[-1] == 3 else precone
    return np.asarray(a0 - a[..., -2] * np.cos(psi) - a[..., -1] * np.sin(psi))


def _checked(system: PeriodicSystem) -> PeriodicSystem:
    if not isinstance(system, PeriodicSystem):
        raise ParameterError(
            "system",
            system,
            f"{type(system).__name__} is no system: make one with tip_path_plane(rotor, advance_ratio)",
        )
    return system


def _numbers(name: str, value: ArrayLike) -> Array:
    """Finite numbers."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise ParameterError(name, value, "these are not numbers, or their lengths differ") from None
    if not np.all(np.isfinite(array)) or np.asarray(value).dtype.kind in "US":
        raise ParameterError(name, value, "a response needs finite numbers")
    return array


def _vector(system: PeriodicSystem, inputs: Inputs, other: tuple[int, ...] = ()) -> Array:
    """u (..., inputs), which must broadcast with the system's cases and with ``other``."""
    u = input_vector(inputs, system.input_names)
    try:
        np.broadcast_shapes(u.shape[:-1], system.cases, other)
    except ValueError:
        shapes = ", ".join(str(shape) for shape in (u.shape[:-1], system.cases, other) if shape)
        raise ParameterError(
            "inputs", shapes, f"shapes {shapes} of inputs, cases and initial states do not broadcast"
        ) from None
    return u
