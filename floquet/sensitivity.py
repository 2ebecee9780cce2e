"""Rates of Floquet exponents as parameters move, exactly, from left and right Floquet modes.

With right modes e^{ηψ} v(ψ) and left modes e^{-ηψ} w*(ψ) of x' = A(ψ) x, w*(ψ) v(ψ) = 1, and A_p = ∂A/∂p::

    dη/dp = (1/T) ∫ w* A_p v dψ,     A_p = [0, 0; -K_p, -D_p] for q'' + D q' + K q = 0

One scalar equation β'' + d β' + k β = 0 has η = α ± ν with α = -½ mean d, cosh νT = τ and D = τ² - 1.  With M(ψ) =
Φ(ψ + T, ψ), the map over a period from ψ on, which is periodic::

    dα/dp = -½ mean d_p                                               dD/dp = 2 τ dτ/dp
    dτ/dp = -½ e^{-αT} ∫ [k_p M₁₂ + ½ d_p (M₂₂ - M₁₁)] dψ             dη/dp = dα/dp ± dτ/dp / (T sinh νT)

(V. A. Yakubovich and V. M. Starzhinskii, *Linear Differential Equations with Periodic Coefficients*, 1975, ch. IV and
VIII).  τ and D are smooth in every parameter.  At a branch point, where D = 0 and the two exponents meet, dη/dp grows
like 1/√D; there dτ/dp and dD/dp say how the edge of a lock moves: by -(dD/dp)/(dD/dq) of q.  A rate describes changes
of p that are small beside :attr:`Sensitivities.reach`.

A_p comes from the model's own equation with an imaginary step (:meth:`floquet.periodic.Equation.rates`), without
differences.  Integrals are sums over 16 Gauss nodes a panel.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .comparison import Model, exact_model
from .errors import ParameterError, did_you_mean
from .exponents import Stability, exponents, stability
from .models import PhysicsKeywords, multiblade, teetering
from .models.flapping import blade
from .models.physics import advance_ratios
from .models.tip_path_plane import plane_of
from .modes import paired
from .passage import Nodes, sampled, through_nodes
from .period_map import EPS, period_map
from .periodic import TWO_PI, PeriodicMatrix, PeriodicSystem
from .rotor import PARAMETERS, Hub, Rotor, plain, require_rotor

__all__ = ["Sensitivities", "of_system", "plane_sensitivities", "sensitivities"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Directions = Mapping[str, Mapping[str, ArrayLike]]
TRUSTED = 1e-8  # of a rate: errors above are those next to a branch point
FEW = 12  # names that an error lists
ROUNDING = 1.0  # eps of what is summed: seen are 0.1, of 500 rates in forty digits
JUMP = 1e-9  # of the coefficients: less is rounding
MOVES_KINKS = ("advance_ratio", "tip_loss")
CHUNK = 256  # cases at once: the nodes of their panels stay near a cache


@dataclass(frozen=True, eq=False, kw_only=True)
class Sensitivities:
    """Rates of exponents, (parameters, ..., states) with the states of ``stability``; ``s["lock_number"]`` is a row.

    Attributes
    ----------
    parameters : tuple of str
    stability : Stability
        The exponents themselves.
    rates : complex (parameters, ..., states)
        dη/dp, per unit of p; nan at a branch point.
    errors : float (parameters, ..., states)
        Estimates of their errors, to first order.
    trusted : bool (parameters, ..., states)
        Whether the error is below 1e-8 of the rate (of its parts, where they cancel): False on a branch point, and near
        one where D or the modes are not known better.
    half_trace_rates, discriminant_rates : float (parameters, ...) or None
        dτ/dp and dD/dp of one scalar equation, smooth everywhere.
    discriminant : float (...) or None
        D, positive in a lock.
    """

    parameters: tuple[str, ...]
    stability: Stability
    rates: Complex
    errors: Array
    trusted: NDArray[np.bool_]
    half_trace_rates: Array | None = None
    discriminant_rates: Array | None = None
    discriminant: Any = None

    def __getitem__(self, parameter: str) -> Complex:
        if parameter not in self.parameters:
            raise ParameterError(
                "parameter",
                parameter,
                f"{parameter!r} does not move these exponents{self._near(parameter)}; {self._listed()}",
            )
        return self.rates[self.parameters.index(parameter)]

    def _near(self, parameter: str) -> str:
        """The parameter that was meant; of one without its blade, those of the blades."""
        own = [name for name in self.parameters if name.rpartition(" ")[0] == parameter]
        if own:
            return f", but those of the blades do: {own[0]!r} to {own[-1]!r}"
        return did_you_mean(parameter, self.parameters)

    def _listed(self) -> str:
        """The parameters, or where many are, how to list them."""
        if len(self.parameters) <= FEW:
            return f"the parameters are {', '.join(self.parameters)}"
        first, last = self.parameters[0], self.parameters[-1]
        return (
            f"there are {len(self.parameters)} parameters, from {first!r} to {last!r}: the field parameters lists them"
        )

    @property
    def reach(self) -> Array | None:
        """|D / (dD/dp)| (parameters, ...): the change of p, to first order, that leads to a branch point."""
        if self.discriminant_rates is None:
            return None
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.abs(self.discriminant / self.discriminant_rates)


def sensitivities(
    rotor: Rotor | Sequence[Rotor],
    advance_ratio: ArrayLike,
    *,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Sensitivities:
    """Rates of the exact exponents of a rotor with each of its parameters, ``tip_loss`` and ``advance_ratio``.

    Parameters
    ----------
    rotor : Rotor, or a sequence of one Rotor a blade
        Identical blades have the rates of one blade: their exponents are its, shifted by whole numbers.  Parameters of
        blades that are given one by one are called ``"lock_number 0"`` and so on, from the first blade on.
    advance_ratio
        μ; broadcasts against the rotor.
    model : "flapping" or "teetering"
        By default after the hub.
    **options
        See :mod:`floquet.models.physics`.

    Notes
    -----
    Where ``offset_mass_ratio`` was left out it follows, m = ε s: the rate of ``hinge_offset`` is then the total one,
    ∂η/∂ε + s ∂η/∂m, and that of ``static_moment_ratio`` is ε ∂η/∂m.  Where it was given both are partial, with m held,
    and the second is 0.  ``offset_mass_ratio`` is ∂η/∂m with ε and s held, either way.  A teetering rotor has no
    hinge offset.  ``root_cutout`` up to the hinge does nothing, and has the rate 0 at the hinge itself.

    In reversed flow beyond μ = B, with an offset and without ``exact_offset``, the truncated integrals jump where
    reversed flow reaches the tip.  There the rates of μ and ``tip_loss`` are nan, not trusted: give ``exact_offset``.

    >>> s = sensitivities(Rotor(lock_number=8.0), 0.3)
    >>> f"{s['lock_number'][0]:.6f}"
    '-0.062500-0.044515j'
    """
    if not isinstance(rotor, Rotor):
        return _of_blades(list(rotor), advance_ratio, **options)
    kind = exact_model(rotor, model)
    one = (teetering if kind == "teetering" else blade)(rotor, advance_ratios(advance_ratio), **options)
    return _without_jumps(of_system(one, _with_mu(_directions(rotor), kind == "teetering")), one)


def plane_sensitivities(rotor: Rotor, advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> Sensitivities:
    """Rates of the eigenvalues of the tip-path plane; names and arguments as of :func:`sensitivities`.

    The plane's matrices are straight functions of the blade's coefficients, see :mod:`floquet.models.tip_path_plane`.
    """
    teeters = require_rotor(rotor).hub == Hub.TEETERING
    directions = _with_mu(_directions(rotor), teeters)
    one = (teetering if teeters else blade)(rotor, advance_ratios(advance_ratio), **options)
    assert one.equation is not None
    zero = 0 * PeriodicMatrix.scalar(period=TWO_PI)

    def plane(d: PeriodicMatrix, k: PeriodicMatrix) -> tuple[Array, Array]:
        found = plane_of(replace(one, equation=None, damping=d, stiffness=k, period=TWO_PI), teeters=teeters)
        assert found.damping is not None and found.stiffness is not None
        return found.damping.mean(), found.stiffness.mean()

    still, moved = plane(zero, zero), plane(*one.equation.rates(list(directions.values())))
    rates = [
        tuple(PeriodicMatrix.constant(x[i] - y) for x, y in zip(moved, still, strict=True))
        for i in range(len(directions))
    ]
    given = {
        n: PeriodicSystem(period=math.nan, damping=D, stiffness=K) for n, (D, K) in zip(directions, rates, strict=True)
    }
    return _without_jumps(of_system(plane_of(one, teeters=teeters), rates=given), one)


def _without_jumps(found: Sensitivities, blade: PeriodicSystem) -> Sensitivities:
    """Without rates of what moves a kink at which the blade's coefficients jump: A_p has an impulse there.

    They jump where reversed flow reaches the tip, if integrals are truncated in ε: a kink that μ and B move.
    """
    if blade.parts is None:
        return found
    assert blade.damping is not None and blade.stiffness is not None
    there = np.any([_jumps(m) for m in (blade.damping, blade.stiffness)], axis=0)
    moved = np.array([name in MOVES_KINKS for name in found.parameters])
    lost = moved.reshape(-1, *([1] * (found.rates.ndim - 1))) & there[..., None]
    return replace(
        found,
        rates=np.where(lost, math.nan, found.rates),
        errors=np.where(lost, math.inf, found.errors),
        trusted=found.trusted & ~lost,
    )


def _jumps(matrix: PeriodicMatrix) -> NDArray[np.bool_]:
    """Whether a matrix jumps anywhere, (...); where pieces have no length, over all edges at one place together."""
    if matrix.edges is None:
        return np.zeros(matrix.cases, bool)
    begins, jumps = matrix.edges[..., :-1], matrix.jumps()
    apart = np.abs(begins[..., :, None] - begins[..., None, :])
    same = (np.minimum(apart, matrix.period - apart) < JUMP).astype(float)
    net = np.abs(np.einsum("...ij,...jnm->...inm", same, jumps)).max(axis=(-3, -2, -1))
    return np.asarray(net > JUMP * matrix.magnitude().max(axis=(-2, -1)))


def _with_mu(directions: dict[str, dict[str, ArrayLike]], teeters: bool) -> dict[str, dict[str, ArrayLike]]:
    """μ too; a teetering rotor has no hinge offset."""
    kept = {n: d for n, d in directions.items() if not (teeters and n in ("hinge_offset", "offset_mass_ratio"))}
    return kept | {"advance_ratio": {"advance_ratio": 1.0}}


def _directions(rotor: Rotor, suffix: str = "") -> dict[str, dict[str, ArrayLike]]:
    """What moves with each parameter of a blade."""
    moves: dict[str, dict[str, ArrayLike]] = {name: {name: 1.0} for name in (*(p.name for p in PARAMETERS), "tip_loss")}
    if rotor.offset_mass_derived:
        moves["hinge_offset"]["offset_mass_ratio"] = rotor.static_moment_ratio
        moves["static_moment_ratio"]["offset_mass_ratio"] = rotor.hinge_offset
    return {n + suffix: {name + suffix: rate for name, rate in d.items()} for n, d in moves.items()}


def _of_blades(rotors: list[Rotor], advance_ratio: ArrayLike, **options: Unpack[PhysicsKeywords]) -> Sensitivities:
    """Of blades one by one, and of μ, which all of them share; no parameter of one moves an exponent of another."""
    system = multiblade(rotors, advance_ratio, **options)
    if system.blade is not None:
        return sensitivities(rotors[0], advance_ratio, **options)
    each = [
        _without_jumps(of_system(b, _with_mu(_directions(r), False)), b)
        for b, r in zip(system.blades, rotors, strict=True)
    ]
    found, cases, count = stability(system), system.cases, len(each[0].parameters)
    own = np.concatenate([np.broadcast_to(one.stability.exponents, (*cases, 2)) for one in each], axis=-1)
    pairs = zip(np.reshape(found.exponents, (-1, 2 * len(each))), own.reshape(-1, 2 * len(each)), strict=True)
    order = np.reshape([paired(a, b, 1.0) for a, b in pairs], own.shape)

    def whole(parts: Sequence[NDArray[Any]], other: Any) -> NDArray[Any]:
        """Of every blade's parameters in turn, μ last; ``other`` is the rate with those of another blade."""
        full = [np.broadcast_to(_padded(part, len(cases)), (count, *cases, 2)) for part in parts]
        rows = [
            np.concatenate(
                [part[:-1] if i == k else np.full((count - 1, *cases, 2), other) for i in range(len(full))], -1
            )
            for k, part in enumerate(full)
        ]
        rows.append(np.concatenate([part[-1:] for part in full], -1))
        return np.take_along_axis(np.concatenate(rows), order[None], axis=-1)

    return Sensitivities(
        parameters=(*(f"{name} {i}" for i in range(len(each)) for name in each[0].parameters[:-1]), "advance_ratio"),
        stability=found,
        rates=whole([one.rates for one in each], 0.0),
        errors=whole([one.errors for one in each], 0.0),
        trusted=whole([one.trusted for one in each], True),
    )


def _padded(values: NDArray[Any], axes: int) -> NDArray[Any]:
    """(parameters, ..., states) with as many axes of cases, of length 1."""
    return values.reshape(values.shape[:1] + (1,) * (axes + 2 - values.ndim) + values.shape[1:])


def of_system(
    system: PeriodicSystem,
    directions: Directions | None = None,
    *,
    rates: Mapping[str, PeriodicSystem] | None = None,
    symmetry: bool = True,
) -> Sensitivities:
    """Rates of the exponents of any system.

    Parameters
    ----------
    system : PeriodicSystem
    directions : mapping of mappings, optional
        For each name in the result the rates of the parameters of the system's equation; by default each parameter is
        a direction of its own.
    rates : mapping of PeriodicSystem, optional
        For a system without an equation: for each name one whose coefficients are the rates of ``system``'s.
    symmetry : bool
        Identical blades: the exponents and rates of one blade; False takes those of all coordinates.
    """
    if symmetry and system.blade is not None:
        system = system.blade
    source = _Model.of(system, directions) if rates is None else _Given(system, rates)
    if system.second_order and system.degrees == 1 and not system.constant:
        return _of_scalar(system, source)
    return _of_states(system, source)


Sampler = Callable[[Array, tuple[int, ...]], tuple[Array | None, Array]]


@dataclass(frozen=True, eq=False)
class _Given:
    """Rates that were given as systems."""

    system: PeriodicSystem
    rates: Mapping[str, PeriodicSystem]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.rates)

    def parts(self) -> Iterator[tuple[slice, PeriodicSystem, Sampler]]:
        """Some of the flat cases, their system, and what gives D_p and K_p, or None and A_p, at nodes."""
        yield slice(None), self.system, self._sampler

    def _sampler(self, psi: Array, cases: tuple[int, ...]) -> tuple[Array | None, Array]:
        D, A = zip(*(_sampled(rate, psi, cases) for rate in self.rates.values()), strict=True)
        return None if D[0] is None else np.stack(D), np.stack(A)


@dataclass(frozen=True, eq=False)
class _Model:
    """Rates from the equation of a model, its cases along one axis."""

    system: PeriodicSystem
    directions: Mapping[str, Mapping[str, Array]]

    @staticmethod
    def of(system: PeriodicSystem, directions: Directions | None) -> _Model:
        if system.equation is None:
            raise ParameterError(
                "system",
                system.name,
                "its matrices do not say how they depend on parameters: give rates={name: PeriodicSystem of rates}",
            )
        known, shape = system.equation.parameters, system.cases
        directions = {name: {name: 1.0} for name in known} if directions is None else directions
        for name in (name for d in directions.values() for name in d if name not in known):
            raise ParameterError(
                "directions",
                name,
                f"{name!r} is no parameter of this system{did_you_mean(name, known)}; it has {', '.join(known)}",
            )
        flat = {
            name: {p: np.broadcast_to(np.asarray(rate, float), shape).ravel() for p, rate in d.items()}
            for name, d in directions.items()
        }
        return _Model(system, flat)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.directions)

    def parts(self) -> Iterator[tuple[slice, PeriodicSystem, Sampler]]:
        """As of :class:`_Given`."""
        for start in range(0, math.prod(self.system.cases), CHUNK):
            some = slice(start, start + CHUNK)
            part = self.system.part(some if self.system.cases else slice(None))
            moves = [{p: rate[some] for p, rate in d.items()} for d in self.directions.values()]
            yield some, part, self._sampler(part, moves)

    def _sampler(self, part: PeriodicSystem, moves: Sequence[Mapping[str, Array]]) -> Sampler:
        assert part.equation is not None
        D, K = part.equation.rates([{p: r.reshape(part.cases) for p, r in d.items()} for d in moves])
        return lambda psi, cases: (_at(D, psi, (len(moves), *cases)), _at(K, psi, (len(moves), *cases)))


def _sampled(rate: PeriodicSystem, psi: Array, cases: tuple[int, ...]) -> tuple[Array | None, Array]:
    """D_p and K_p, or None and A_p, of a system of rates."""
    D, K = rate.damping if rate.second_order else None, rate.stiffness if rate.second_order else rate.matrix
    A = _at(rate.function if K is None else K, psi, cases)
    return (np.zeros_like(A) if D is None else _at(D, psi, cases)) if rate.second_order else None, A


def _at(part: PeriodicMatrix | Callable[[Array], Array] | None, psi: Array, cases: tuple[int, ...]) -> Array:
    """Samples (cases, panels, p, n, m)."""
    samples = sampled(part, psi, cases)
    assert samples is not None
    return samples.reshape(*cases, *psi.shape[-2:], *samples.shape[-2:])


# ---------------------------------------------------------------------- one scalar equation
def _of_scalar(system: PeriodicSystem, source: _Given | _Model) -> Sensitivities:
    """Through τ, see the module's equations."""
    phi, T, shape = period_map(system), system.period, system.cases
    found = exponents(phi)
    assert phi.rows is not None
    rows = (np.asarray(x).reshape(shape) for x in (phi.half_trace, phi.discriminant, phi.rows[5], phi.rows[2]))
    tau, D, D_error, phi_21 = rows
    integrals = zip(*(_integrals(part, rates) for _, part, rates in source.parts()), strict=True)
    alpha_rate, tau_rate, tau_error = (np.concatenate(x, axis=1).reshape(-1, *shape) for x in integrals)
    locked, root = ~np.isnan(np.asarray(found.lock)), np.sqrt(np.abs(D))
    turning = np.where(phi_21 < 0.0, 1.0j, -1.0j)  # sin ρT has the sign of -Φ₂₁
    sinh = np.where(locked, np.where(tau > 0.0, 1.0, -1.0), turning) * root
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = 0.5 * D_error / np.abs(D)
        part = tau_rate / (T * sinh)
        errors = tau_error / (T * root) + np.abs(part) * relative + ROUNDING * EPS * np.abs(alpha_rate)
        trusted = (errors <= TRUSTED * (np.abs(alpha_rate) + np.abs(part))) & (relative < TRUSTED)
    return Sensitivities(
        parameters=source.names,
        stability=found,
        rates=np.stack([alpha_rate + part, alpha_rate - part], axis=-1),
        errors=np.stack([errors, errors], axis=-1),
        trusted=np.stack([trusted, trusted], axis=-1),
        half_trace_rates=tau_rate,
        discriminant_rates=2.0 * tau * tau_rate,
        discriminant=plain(D),
    )


def _integrals(system: PeriodicSystem, rates: Sampler) -> tuple[Array, Array, Array]:
    """dα/dp, dτ/dp and the rounding of dτ/dp, (parameters, cases) each."""
    nodes, T = through_nodes(system, system.period), system.period
    parts = rates(nodes.azimuths, system.cases)
    d, k = (np.zeros(()) if part is None else part[..., 0, 0] for part in parts)
    M, size = _around(nodes, lambda m: m), _around(nodes, np.abs)
    mean = 0.0 if system.damping is None else system.damping.mean()[..., 0, 0]
    scale = 0.5 * np.exp(0.5 * T * mean)

    def total(values: Array) -> Array:
        summed = np.sum(nodes.weights * values, axis=(-2, -1))
        return summed.reshape(len(summed), -1)

    tau = total(k * M[..., 0, 1] + 0.5 * d * (M[..., 1, 1] - M[..., 0, 0]))
    error = total(np.abs(k) * size[..., 0, 1] + 0.5 * np.abs(d) * (size[..., 1, 1] + size[..., 0, 0]))
    return total(-0.5 / T * d + 0.0 * k), -scale * tau, ROUNDING * EPS * scale * error


def _around(nodes: Nodes, part: Callable[[Array], Array]) -> Array:
    """M(ψ) = Φ(ψ, 0) Φ(T, ψ) at the nodes, (..., panels, p, 2, 2); with ``np.abs`` the sizes of what it sums."""
    F, N = part(nodes.transitions), nodes.within
    panels = F.shape[-3]
    before, after = [np.broadcast_to(np.eye(2), F[..., 0, :, :].shape)], [np.eye(2)]
    for k in range(panels - 1):
        before.append(F[..., k, :, :] @ before[-1])
    for k in range(panels - 1, -1, -1):
        after.append(after[-1] @ F[..., k, :, :])
    M = np.stack([b @ a for b, a in zip(before, after[:0:-1], strict=True)], axis=-3)
    return part(N) @ M[..., None, :, :] @ part(_inverse(N))


def _inverse(m: Array) -> Array:
    """Inverses of 2×2 matrices."""
    a, b, c, d = m[..., 0, 0], m[..., 0, 1], m[..., 1, 0], m[..., 1, 1]
    adjugate = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    return adjugate / (a * d - b * c)[..., None, None]


# ---------------------------------------------------------------------- several states
def _of_states(system: PeriodicSystem, source: _Given | _Model) -> Sensitivities:
    """From left and right modes."""
    found, n = stability(system, symmetry=False), system.states
    eta = np.asarray(found.exponents).reshape(-1, n)
    parts = zip(*(_of_modes(part, eta[some], rates) for some, part, rates in source.parts()), strict=True)
    rates, errors, trusted = (np.concatenate(x, axis=1).reshape(-1, *system.cases, n) for x in parts)
    return Sensitivities(parameters=source.names, stability=found, rates=rates, errors=errors, trusted=trusted)


def _of_modes(system: PeriodicSystem, eta: Complex, rates: Sampler) -> tuple[Complex, Array, NDArray[np.bool_]]:
    """dη/dp, its error and whether to trust it, (parameters, cases, states) each.

    The errors of a map, a few eps of its norm, turn modes into each other the more the closer multipliers are.
    """
    n = system.states
    if system.constant:
        still = np.broadcast_to(np.eye(n), (*system.cases, 1, 1, n, n))
        nodes, T, strip = Nodes(np.zeros((1, 1)), np.ones((1, 1)), still, still[..., 0, :, :]), 1.0, math.inf
        Phi = system.sample(np.zeros(1))[..., 0, :, :]
    else:
        nodes, T = through_nodes(system, system.period), system.period
        strip, Phi = 2.0 * math.pi / T, np.diag(np.ones(n) if system.twist is None else system.twist)
        for k in reversed(range(nodes.transitions.shape[-3])):
            Phi = Phi @ nodes.transitions[..., k, :, :]
    values, V = np.linalg.eig(Phi.astype(complex))
    flat = values.reshape(-1, n)
    with np.errstate(divide="ignore"):
        logs = flat if system.constant else np.log(flat) / T
    order = np.stack([paired(a, b, strip) for a, b in zip(eta, logs, strict=True)]).reshape(values.shape)
    values = np.take_along_axis(values, order, axis=-1)
    V = np.take_along_axis(V, order[..., None, :], axis=-1)
    mean, size, condition = _averaged(system.second_order, nodes, V, *rates(nodes.azimuths, system.cases), T)
    gap = np.abs(values[..., :, None] - values[..., None, :])
    norm = np.linalg.norm(Phi, axis=(-2, -1))[..., None, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        mixing = np.where(np.eye(n, dtype=bool), 0.0, norm / gap)
        turned = size * condition[..., None, :] + condition[..., :, None] * np.swapaxes(size, -1, -2)
        own = np.diagonal(size, axis1=-2, axis2=-1)
        errors = ROUNDING * EPS * (own + np.sum(mixing * turned, axis=-1))
        trusted = errors <= TRUSTED * own
    found: tuple[Any, ...] = tuple(x.reshape(len(x), -1, n) for x in (mean, errors, trusted))
    return found


def _averaged(
    second_order: bool, nodes: Nodes, V: Complex, D: Array | None, A: Array, T: float
) -> tuple[Complex, Array, Array]:
    """Means of w_i* A_p v_i (parameters, ..., n) and of |w_i| |A_p| |v_j| (parameters, ..., n, n); max |w_i| |v_i|."""
    mean, size, condition = np.zeros(()), np.zeros(()), np.zeros(())
    weights = nodes.weights / T
    for k in range(nodes.transitions.shape[-3]):
        right = nodes.within[..., k, :, :, :] @ V[..., None, :, :]
        right = right / np.linalg.norm(right, axis=-2, keepdims=True)
        left, w = np.linalg.inv(right), weights[..., k, :, None]
        pushed = _pushed(second_order, None if D is None else D[..., k, :, :, :], A[..., k, :, :, :], right)
        rows = left[..., left.shape[-1] - A.shape[-1] :]  # only they meet A_p
        mean = mean + np.sum(w * np.einsum("...ia,...ai->...i", rows, pushed), axis=-2)
        lengths = np.linalg.norm(rows, axis=-1)[..., :, None] * np.linalg.norm(pushed, axis=-2)[..., None, :]
        size = size + np.sum(w[..., None] * lengths, axis=-3)
        condition = np.maximum(condition, np.linalg.norm(left, axis=-1).max(axis=-2))
        V = nodes.transitions[..., k, :, :] @ V
        V = V / np.linalg.norm(V, axis=-2, keepdims=True)
    return np.asarray(mean, complex), size, condition


def _pushed(second_order: bool, D: Array | None, A: Array, right: Complex) -> Complex:
    """The rows of A_p v that are not zero: -(K_p q + D_p q'), or A_p x."""
    if not second_order:
        return A @ right
    assert D is not None
    n = A.shape[-1]
    return -(A @ right[..., :n, :] + D @ right[..., n:, :])
