"""Control laws that decouple the flapping response, eqs. (14)–(28) and appendix C of NASA TP-1431.

Two couplings are undone in the steady state of the tip-path plane, ``K̃ a = F̃ u``:

* of **controls**: pilot inputs δ = (δ_C, δ_A, δ_L) shall give ``a = S δ``, with the sensitivities k₀ = ∂a₀/∂δ_C,
  k₁ = ∂a₁/∂δ_L, k₂ = ∂b₁/∂δ_A.  The mixing ``(θ₀, A₁, B₁) = K_D δ`` with ``K_D = E⁻¹ K̃ S`` does it; E are the control
  columns of F̃, with the inflow that collective pitch induces (Λ₁, Λ₂);
* of **body rates**: p and q tilt the plane both ways.  Condition (19) makes the cross responses vanish by design of the
  rotor; the feedback ``(A₁, B₁) = K_f (p, q)`` makes them vanish for any.

The report's laws hold in wind axes; with the rotor's sideslip β_w they are turned into hub-body axes.  With
R = [cos β_w, −sin β_w; sin β_w, cos β_w], flapping and cyclic pitch are x_wind = R x_body, but rates are
(p, q)_wind = Rᵀ (p, q)_body.

:class:`ClosedLoop` holds what a law promises, what the tip-path plane gives with it, and what the periodic equations
give, which the report did not check.  Rates are p/Ω, q/Ω, angles in radians; laws take arrays of rotors and μ.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import ParameterError
from .models import FORCING, PhysicsKeywords, teetering, tip_path_plane
from .models.flapping import blade
from .models.hover import hover_coefficients
from .models.physics import advance_ratios
from .response import tip_path_plane_gains
from .rotor import Hub, Rotor, plain
from .validity import crossings

__all__ = [
    "ClosedLoop", "Sensitivities", "appendix_c_mixing", "control_advance_angle", "control_mixing",
    "decoupled_rate_response", "decoupling_coupling", "decoupling_offset", "decoupling_spring", "hover_gearing",
    "hover_rate_feedback", "hover_rate_response", "mixed_controls", "rate_feedback", "rate_response", "rates_fed_back",
    "report_mass_ratio", "required_spring", "teetering_gearing", "uniform_mass_ratio",
]  # fmt: skip

Array = NDArray[np.float64]
CONTROLS = [FORCING.index(name) for name in ("theta_0", "A_1c", "B_1c")]
RATES = [FORCING.index(name) for name in ("p_w", "q_w")]
INFLOW = FORCING.index("lambda")
FARTHEST = 0.3  # hinge offsets looked at: the truncated integrals mean nothing beyond


class Sensitivities(NamedTuple):
    """k₀ = ∂a₀/∂δ_C, k₁ = ∂a₁/∂δ_L, k₂ = ∂b₁/∂δ_A [rad per unit of pilot input]; laws also take three numbers."""

    coning: float = 1.0
    longitudinal: float = 1.0
    lateral: float = 1.0

    @property
    def promise(self) -> Array:
        """S of (C2): rows (a₀, a₁, b₁), columns (δ_C, δ_A, δ_L)."""
        return np.array([[self.coning, 0, 0], [0, 0, self.longitudinal], [0, self.lateral, 0]], float)


UNIT = Sensitivities()


def _sensitivities(k: Sequence[float]) -> Sensitivities:
    """Three numbers as Sensitivities."""
    try:
        return Sensitivities(*(float(x) for x in k))
    except (TypeError, ValueError):
        raise ParameterError(
            "k", k, f"{k!r} are no sensitivities: give three numbers, of coning, longitudinal and lateral flapping"
        ) from None


@dataclass(frozen=True, eq=False, kw_only=True)
class ClosedLoop:
    """Steady responses (..., outputs, inputs): ``promised``, of the ``tip_path_plane``, and of the ``periodic`` rotor.

    Outputs are (a₀, a₁, b₁), or (a₁, b₁); inputs the pilot's or the body rates.
    """

    promised: Array
    tip_path_plane: Array
    periodic: Array

    def residual(self, model: Array | None = None) -> Array:
        """What is not as promised, over the largest response promised to the same input: (..., inputs).

        Of ``periodic``, or of another field.
        """
        got = self.periodic if model is None else model
        return np.asarray(np.abs(got - self.promised).max(axis=-2) / self._promised_size())

    def coupling(self, model: Array | None = None) -> Array:
        """The largest response that shall be zero, over the one promised to the same input: (..., inputs).

        What a pilot feels as coupling; :meth:`residual` also counts what is wrong with the promised response itself.
        """
        got = self.periodic if model is None else model
        crossing = np.where(self.promised == 0.0, np.abs(got), 0.0)
        return np.asarray(crossing.max(axis=-2) / self._promised_size())

    def _promised_size(self) -> Array:
        size = np.abs(self.promised).max(axis=-2)
        return np.where(size > 0, size, 1.0)


# ---------------------------------------------------------------------- axes
def axes(sideslip: ArrayLike) -> Array:
    """R (..., 2, 2): wind axes from hub-body axes, for flapping and cyclic pitch; β_w [rad], |β_w| ≤ π."""
    beta = np.asarray(sideslip)
    if beta.dtype.kind not in "fiu" or not np.all(np.abs(beta) <= np.pi):
        raise ParameterError(
            "sideslip", sideslip, f"{sideslip!r} is no sideslip angle in radians: for degrees use np.radians(…)"
        )
    c, s = np.cos(beta), np.sin(beta)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def _with_coning(R: Array) -> Array:
    """R₃ = diag(1, R)."""
    out = np.zeros((*R.shape[:-2], 3, 3))
    out[..., 0, 0], out[..., 1:, 1:] = 1.0, R
    return out


def _turned(matrix: Array) -> Array:
    return np.swapaxes(matrix, -1, -2)


# ---------------------------------------------------------------------- controls
def hover_gearing(rotor: Rotor, k: Sequence[float] = UNIT, **options: Unpack[PhysicsKeywords]) -> Array:
    """Cyclic gearing at hover, eq. (14): rows (A₁, B₁), columns (δ_A, δ_L), (..., 2, 2); for any sideslip.

    With c₀ the damping and C = (γ/8)(1 − 4ε/3) the cyclic pitch's power::

        ∂A/∂δ_A = (c₀/C) k₂           ∂A/∂δ_L = ((P² − 1)/C) k₁
        ∂B/∂δ_A = ((P² − 1)/C) k₂     ∂B/∂δ_L = −(c₀/C) k₁
    """
    c0, P2 = hover_coefficients(rotor, **options)
    k, power = _sensitivities(k), _power(rotor, **options)
    direct, cross = c0 / power, (P2 - 1.0) / power
    return _matrix([[direct * k.lateral, cross * k.longitudinal], [cross * k.lateral, -direct * k.longitudinal]])


def control_advance_angle(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Any:
    """φ = atan((P² − 1)/c₀) [rad], eq. (15): how far the swash plate is turned with the rotor to decouple at hover."""
    c0, P2 = hover_coefficients(rotor, **options)
    return plain(np.arctan2(P2 - 1.0, c0))


def teetering_gearing(rotor: Rotor, advance_ratio: ArrayLike, k: Sequence[float] = UNIT) -> Array:
    """Cyclic gearing of a teetering rotor in forward flight, eq. (16): (..., 2, 2) as in (14).

    ::

        ∂A/∂δ_A = k₂                                             ∂A/∂δ_L = (8/γ)(P²−1 + γK₁μ²/16)/(1 + μ²/2) k₁
        ∂B/∂δ_A = (8/γ)(P²−1 + 3γK₁μ²/16)/(1 + 3μ²/2) k₂         ∂B/∂δ_L = −(1 − μ²/2)/(1 + 3μ²/2) k₁
    """
    _teetering_only(rotor)
    k = _sensitivities(k)
    mu2 = advance_ratios(advance_ratio, rotor) ** 2
    gamma, coupling = np.asarray(rotor.lock_number), np.asarray(rotor.lock_number) * rotor.pitch_flap_coupling
    spring = np.asarray(rotor.frequency_ratio_squared) - 1.0
    forward, side = 1.0 + 1.5 * mu2, 1.0 + 0.5 * mu2
    return _matrix(
        [
            [k.lateral + 0.0 * mu2, 8.0 / gamma * (spring + coupling * mu2 / 16.0) / side * k.longitudinal],
            [
                8.0 / gamma * (spring + 3.0 * coupling * mu2 / 16.0) / forward * k.lateral,
                -(1.0 - 0.5 * mu2) / forward * k.longitudinal,
            ],
        ]
    )


def control_mixing(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    k: Sequence[float] = UNIT,
    *,
    sideslip: ArrayLike = 0.0,
    inflow_gradient: float = 0.0,
    **options: Unpack[PhysicsKeywords],
) -> Array:
    """Mixing of collective and cyclic pitch in forward flight, appendix C.

    Parameters
    ----------
    rotor, advance_ratio
        Broadcast against each other.
    k : Sensitivities
        In hub-body axes.
    sideslip : float or array
        β_w [rad].
    inflow_gradient : float
        ∂λ/∂θ₀, of Λ₁ and Λ₂.

    Returns
    -------
    (..., 3, 3)
        K_D = (R₃ᵀ E⁻¹ K̃ R₃) S: rows (θ₀, A₁, B₁), columns (δ_C, δ_A, δ_L); of a teetering rotor (..., 2, 2).
    """
    plane, k = tip_path_plane(rotor, advance_ratio, **options), _sensitivities(k)
    assert plane.stiffness is not None and plane.forcing is not None
    E, R = _effectiveness(plane.forcing.mean(), inflow_gradient), axes(sideslip)
    if rotor.hub == Hub.TEETERING:
        return np.asarray(_turned(R) @ np.linalg.solve(E[..., 1:], plane.stiffness.mean()) @ R @ k.promise[1:, 1:])
    R = _with_coning(R)
    return np.asarray(_turned(R) @ np.linalg.solve(E, plane.stiffness.mean()) @ R @ k.promise)


def _effectiveness(F: Array, inflow_gradient: float) -> Array:
    """E: the columns of (θ₀, A₁c, B₁c), with Λ = ∂λ/∂θ₀ times the column of λ in the first."""
    E: Array = F[..., CONTROLS].copy()
    E[..., 0] += _number("inflow_gradient", inflow_gradient) * F[..., INFLOW]
    return E


def appendix_c_mixing(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    k: Sequence[float] = UNIT,
    *,
    inflow_gradient: float = 0.0,
    **options: Unpack[PhysicsKeywords],
) -> Array:
    """K_D written out, eq. (C4) with (C3), β_w = 0; the scan has lost it::

    [ k₀(α₅K₁₁−α₂K₃₁)/d   k₂(α₅K₁₃−α₂K₃₃)/d   k₁(α₅K₁₂−α₂K₃₂)/d ]
    [ k₀K₂₁/α₃             k₂K₂₃/α₃             k₁K₂₂/α₃           ],   d = α₁α₅ − α₂α₄
    [ k₀(α₁K₃₁−α₄K₁₁)/d   k₂(α₁K₃₃−α₄K₁₃)/d   k₁(α₁K₃₂−α₄K₁₂)/d ]
    """
    advance_ratios(advance_ratio, rotor)
    if rotor.hub == Hub.TEETERING:
        raise ParameterError("hub", rotor.hub, "eq. (C4) has coning: use teetering_gearing for a teetering hub")
    plane = tip_path_plane(rotor, advance_ratio, **options)
    assert plane.stiffness is not None and plane.forcing is not None
    (K11, K12, K13), (K21, K22, K23), (K31, K32, K33) = _entries(plane.stiffness.mean())
    (a1, _, a2), (_, a3, _), (a4, _, a5) = _entries(_effectiveness(plane.forcing.mean(), inflow_gradient))
    d = a1 * a5 - a2 * a4
    k0, k1, k2 = _sensitivities(k)
    return _matrix(
        [
            [k0 * (a5 * K11 - a2 * K31) / d, k2 * (a5 * K13 - a2 * K33) / d, k1 * (a5 * K12 - a2 * K32) / d],
            [k0 * K21 / a3, k2 * K23 / a3, k1 * K22 / a3],
            [k0 * (a1 * K31 - a4 * K11) / d, k2 * (a1 * K33 - a4 * K13) / d, k1 * (a1 * K32 - a4 * K12) / d],
        ]
    )


def mixed_controls(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    mixing: Array,
    k: Sequence[float] = UNIT,
    *,
    sideslip: ArrayLike = 0.0,
    inflow_gradient: float = 0.0,
    **options: Unpack[PhysicsKeywords],
) -> ClosedLoop:
    """What pilot inputs do through ``mixing``, in hub-body axes.

    Parameters
    ----------
    rotor, advance_ratio, k, sideslip, inflow_gradient
        As in :func:`control_mixing`.
    mixing : (..., 3, 3) or (..., 2, 2)
        Of :func:`control_mixing`, or a cyclic gearing, whose outputs are (a₁, b₁) and inputs (δ_A, δ_L).
    """
    mixing, k = np.asarray(mixing, float), _sensitivities(k)
    if mixing.shape[-2:] not in ((2, 2), (3, 3)):
        raise ParameterError(
            "mixing", mixing.shape, f"shape {mixing.shape} is neither a mixing (…, 3, 3) nor a cyclic gearing (…, 2, 2)"
        )
    if rotor.hub == Hub.TEETERING and mixing.shape[-1] == 3:
        raise ParameterError("mixing", mixing.shape, "a teetering rotor has no coning to mix: give gearing (…, 2, 2)")
    R, first = axes(sideslip), 3 - mixing.shape[-1]
    R = R if first else _with_coning(R)

    def closed(gains: Array) -> Array:
        E = _effectiveness(gains, inflow_gradient)[..., first:, first:]
        return np.asarray(_turned(R) @ E @ R @ mixing)

    simple, exact = _gains(rotor, advance_ratio, **options)
    return ClosedLoop(promised=k.promise[first:, first:], tip_path_plane=closed(simple), periodic=closed(exact))


# ---------------------------------------------------------------------- body rates
def hover_rate_response(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Array:
    """(a₁, b₁) per (p/Ω, q/Ω) at hover, eq. (17), (..., 2, 2); for ε = 0 and P = 1 it is (18).

    With C = (γ/2)(1/4 − ε/3), Δ = (P² − 1)² + c₀²::

        (1/Δ) [ c₀C − 2(P²−1)(1+m)          −2(1+m)c₀ − (P²−1)C  ]
              [ −2(1+m)c₀ − (P²−1)C         −c₀C + 2(P²−1)(1+m)  ]
    """
    c0, P2 = hover_coefficients(rotor, **options)
    C, inertia = _power(rotor, **options), 2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio))
    delta = (P2 - 1.0) ** 2 + c0**2
    cross = (c0 * C - (P2 - 1.0) * inertia) / delta
    direct = -(inertia * c0 + (P2 - 1.0) * C) / delta
    return _matrix([[cross, direct], [direct, -cross]])


def rate_response(
    rotor: Rotor, advance_ratio: ArrayLike, *, sideslip: ArrayLike = 0.0, **options: Unpack[PhysicsKeywords]
) -> Array:
    """(a₁, b₁) per (p/Ω, q/Ω) of the tip-path plane in hub-body axes, (..., 2, 2): Rᵀ G Rᵀ."""
    plane = tip_path_plane_gains(tip_path_plane(rotor, advance_ratio, **options))
    R = _turned(axes(sideslip))
    return np.asarray(R @ plane[..., 1:, RATES] @ R)


def required_spring(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Any:
    """P² − 1 = c₀ C/(2(1 + m)), eq. (19): with it, p tilts the plane sideways only and q fore and aft only, at hover.

    For ε = 0 it is γ²/128, eq. (22a).  It is what all springs add up to [per rev²]; the hinge spring κ that makes it
    so is :func:`decoupling_spring`.
    """
    c0, _ = hover_coefficients(rotor, **options)
    return plain(c0 * _power(rotor, **options) / (2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio))))


def decoupled_rate_response(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Any:
    """∂a₁/∂(q/Ω) = ∂b₁/∂(p/Ω) where (19) holds: −2(1 + m)/c₀, which is −16(1 + m)/(γ(1 − 8ε/3 + 2ε²)), eq. (20).

    For ε = 0 it is −16/γ, eq. (23).  The report prints (20) with the numerator of ε = 0.
    """
    c0, _ = hover_coefficients(rotor, **options)
    return plain(-2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio)) / c0)


def decoupling_coupling(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Any:
    """The K₁ that meets (19) with the rotor's other parameters; its own K₁ does not matter.

    For ε = 0 it is γ/16 − 8κ/γ, eq. (22b); for κ = 0 and m = 1.5 ε eq. (25); (24) leaves m open.
    """
    missing = np.asarray(required_spring(rotor, **options)) - rotor.hinge_stiffness - rotor.offset_mass_ratio
    return plain(missing / _power(rotor, **options))


def decoupling_spring(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Any:
    """The κ that meets (19) with the rotor's other parameters; negative where no spring can."""
    _, P2 = hover_coefficients(rotor, **options)
    return plain(np.asarray(required_spring(rotor, **options)) - (P2 - 1.0 - rotor.hinge_stiffness))


def report_mass_ratio(offset: Array) -> Array:
    """m = 1.5 ε: the report's, right to first order in ε."""
    return 1.5 * offset


def uniform_mass_ratio(offset: Array) -> Array:
    """m = 1.5 ε/(1 − ε): a uniform blade outboard of the hinge."""
    return 1.5 * offset / (1.0 - offset)


def decoupling_offset(
    lock_number: float,
    pitch_flap_coupling: float = 0.0,
    hinge_stiffness: float = 0.0,
    *,
    mass_ratio: Callable[[Array], Array] = report_mass_ratio,
    **options: Unpack[PhysicsKeywords],
) -> float:
    """The smallest hinge offset that meets (19), figure 17; nan where none up to 0.3 does.

    ``mass_ratio`` gives m of an offset: :func:`report_mass_ratio` or :func:`uniform_mass_ratio`.  All parameters are
    single numbers.
    """
    given = {"lock_number": lock_number, "pitch_flap_coupling": pitch_flap_coupling, "hinge_stiffness": hinge_stiffness}
    for name, value in given.items():
        if np.ndim(value):
            raise ParameterError(
                name, value, f"shape {np.shape(value)}: one rotor at a time, so call it for each value"
            )

    def excess(offset: Array) -> Array:
        rotor = Rotor(
            lock_number=lock_number,
            pitch_flap_coupling=pitch_flap_coupling,
            hinge_stiffness=hinge_stiffness,
            hinge_offset=offset,
            offset_mass_ratio=mass_ratio(offset),
        )
        _, P2 = hover_coefficients(rotor, **options)
        return np.asarray(P2 - 1.0 - required_spring(rotor, **options))

    if abs(excess(np.zeros(1))[0]) <= 1e-14:  # met without offset, to rounding of numbers of 1
        return 0.0
    found = crossings(lambda _, offset: excess(offset), np.zeros(1), np.full(1, FARTHEST)).x
    return float(found[0]) if found.size else float("nan")


def hover_rate_feedback(rotor: Rotor, k_3: float, **options: Unpack[PhysicsKeywords]) -> Array:
    """K_f at hover, eq. (28), (..., 2, 2): rows (A₁, B₁), columns (p/Ω, q/Ω).

    It makes ``(a₁, b₁) = −k₃ (q, p)/Ω``, eq. (27)::

        K_f = −(1/C) [ k₃c₀ − 2(1+m)       k₃(P²−1) − C      ],    C = (γ/2)(1/4 − ε/3)
                     [ k₃(P²−1) − C        −k₃c₀ + 2(1+m)    ]
    """
    c0, P2 = hover_coefficients(rotor, **options)
    C, inertia = _power(rotor, **options), 2.0 * (1.0 + np.asarray(rotor.offset_mass_ratio))
    k_3 = _number("k_3", k_3)
    direct, cross = (k_3 * c0 - inertia) / C, k_3 * (P2 - 1.0) / C - 1.0
    return _matrix([[-direct, -cross], [-cross, direct]])


def rate_feedback(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    k_3: float,
    *,
    sideslip: ArrayLike = 0.0,
    **options: Unpack[PhysicsKeywords],
) -> Array:
    """K_f of eqs. (26), (27) at any advance ratio, in hub-body axes, (..., 2, 2): Rᵀ K_f Rᵀ; at hover it is (28)."""
    plane = tip_path_plane_gains(tip_path_plane(rotor, advance_ratio, **options))
    wanted = -_number("k_3", k_3) * np.array([[0.0, 1.0], [1.0, 0.0]])
    K = np.linalg.solve(plane[..., 1:, CONTROLS[1:]], wanted - plane[..., 1:, RATES])
    R = _turned(axes(sideslip))
    return np.asarray(R @ K @ R)


def rates_fed_back(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    promised: ArrayLike,
    feedback: ArrayLike = ((0.0, 0.0), (0.0, 0.0)),
    *,
    sideslip: ArrayLike = 0.0,
    **options: Unpack[PhysicsKeywords],
) -> ClosedLoop:
    """What body rates do to (a₁, b₁), in hub-body axes, against what a law promises.

    Parameters
    ----------
    rotor, advance_ratio, sideslip
        As in :func:`control_mixing`.
    promised : (..., 2, 2)
        Rows (a₁, b₁), columns (p/Ω, q/Ω): ``[[0, r], [r, 0]]`` with r of :func:`decoupled_rate_response` for a rotor
        that meets (19), with r = −k₃ for feedback.
    feedback : (..., 2, 2)
        Of :func:`rate_feedback`; left out, there is none.
    """
    R, feedback = axes(sideslip), np.asarray(feedback, float)
    if feedback.shape[-2:] != (2, 2):
        raise ParameterError("feedback", feedback.shape, f"shape {feedback.shape} is no feedback (…, 2, 2)")
    if np.shape(promised)[-2:] != (2, 2):
        raise ParameterError("promised", np.shape(promised), f"shape {np.shape(promised)} is no promise (…, 2, 2)")

    def closed(gains: Array) -> Array:
        direct = _turned(R) @ gains[..., 1:, RATES] @ _turned(R)
        return np.asarray(direct + _turned(R) @ gains[..., 1:, CONTROLS[1:]] @ R @ feedback)

    simple, exact = _gains(rotor, advance_ratio, **options)
    return ClosedLoop(promised=np.asarray(promised, float), tip_path_plane=closed(simple), periodic=closed(exact))


# ---------------------------------------------------------------------- shared
def _gains(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> tuple[Array, Array]:
    """Gains of (a₀, a₁, b₁) of the tip-path plane and of the periodic equations."""
    plane = tip_path_plane(rotor, advance_ratio, **options)
    exact = teetering if rotor.hub == Hub.TEETERING else blade
    return tip_path_plane_gains(plane), tip_path_plane_gains(exact(rotor, advance_ratio, **options))


def _power(rotor: Rotor, **options: Unpack[PhysicsKeywords]) -> Array:
    """C = (γ/2)(1/4 − ε/3): the moment of unit pitch at hover."""
    forcing = blade(rotor, 0.0, **options).forcing
    assert forcing is not None
    return np.asarray(forcing.mean()[..., 0, FORCING.index("theta_0")])


def _number(name: str, value: float) -> float:
    """One finite number."""
    array = np.asarray(value)
    if array.ndim or array.dtype.kind not in "fiu" or not np.isfinite(array):
        raise ParameterError(name, value, f"{value!r} is no finite number")
    return float(array)


def _teetering_only(rotor: Rotor) -> None:
    """Eq. (16) knows no damper and no root cutout."""
    for name in ("flap_damping", "root_cutout"):
        if np.any(np.asarray(getattr(rotor, name)) != 0.0):
            raise ParameterError(name, getattr(rotor, name), "eq. (16) is for a rotor without it: use control_mixing")
    if rotor.hub != Hub.TEETERING:
        raise ParameterError(
            "hub", rotor.hub, "eq. (16) is for a teetering hub: use control_mixing, or hover_gearing at hover"
        )


def _matrix(rows: list[list[Array]]) -> Array:
    """A matrix (..., r, c) of entries that broadcast."""
    entries = np.broadcast_arrays(*(entry for row in rows for entry in row))
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, len(rows), len(rows[0]))


def _entries(matrix: Array) -> list[list[Array]]:
    return [[matrix[..., i, j] for j in range(matrix.shape[-1])] for i in range(matrix.shape[-2])]
