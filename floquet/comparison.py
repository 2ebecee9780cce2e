"""The exact rotor against the constant-coefficient model, mode by mode.

The blade's exponents are α ± iρ, or σ₁,₂ + iρ in a lock.  A simple model with M harmonics (M = 1: the tip-path plane)
has a mode for every k from -M to M, which approximates the exponent seen in the non-rotating frame::

    k = 0 coning    k = -1 regressing    k = +1 advancing    k = ∓n regressing-n, advancing-n
    no lock         σ ± i(ρ + k)                                                                       Rule.PAIRED

In a lock at ρ, the set of all exponents contains, with frequency ρ + k, those of mode k and of its mirror k' = -2ρ -
k::

    k' = k          the two split exponents σ₁, σ₂, on the real axis                                   Rule.REALS
    k' a mode too   σ₁ ± i(ρ+k) and σ₂ ± i(ρ+k) are shared by the two modes                            Rule.JOINT
    k' no mode      no two modes of the simple model meet: compared with the mean (σ₁+σ₂)/2 ± i(ρ+k),
                    which is no exponent of the rotor                                                  Rule.MEAN

Pairs of simple eigenvalues are assigned to the modes at the least total distance.  The error of a mode is the larger
distance of its two, divided by the root mean square of its two targets.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FloquetWarning, ParameterError, did_you_mean
from .exponents import Stability, stability
from .models import PhysicsKeywords, averaged, teetering, tip_path_plane
from .models.flapping import blade
from .models.physics import advance_ratios
from .periodic import PeriodicSystem
from .rotor import Hub, Rotor, Word

__all__ = [
    "Cause",
    "Comparison",
    "Metric",
    "ModeComparison",
    "Model",
    "Rule",
    "compare",
    "exact_model",
    "mode_names",
    "simple_model",
]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Model = Literal["flapping", "teetering"]
MODELS = ("flapping", "teetering")
REAL = 1e-9  # two eigenvalues without imaginary parts above this are a split pair: the noise of a double root is √eps


class Metric(Word):
    """How the error of a mode is measured; all but ABSOLUTE are relative to the exact targets' root mean square."""

    RELATIVE = 0  # max |s - η*| / rms |η*|
    ABSOLUTE = 1  # max |s - η*|, per rev
    FREQUENCY = 2  # max |Im (s - η*)| / rms |Im η*|
    DAMPING = 3  # max |Re (s - η*)| / rms |Re η*|


class Rule(Word):
    """What a mode was compared with; ABSENT: the rotor has no such mode."""

    PAIRED = 0
    REALS = 1
    JOINT = 2
    MEAN = 3
    ABSENT = -1


class Cause(Word):
    """How exact and simple model differ in kind at a point."""

    NONE = 0
    DRIFT = 1  # both oscillate; the simple one has drifted off
    LOCK = 2  # the exact exponents are locked, the simple ones are not split
    TPP_SPLIT = 3  # the simple mode has split into two real eigenvalues, the exact one has not
    DRIFT_IN_LOCK = 4  # both have split
    STABILITY = 5  # one is stable, the other is not


@dataclass(frozen=True, eq=False, kw_only=True)
class ModeComparison:
    """One mode: ``exact`` and ``simple`` (..., 2) paired, ``errors`` (..., 4) by :class:`Metric`."""

    name: str
    exact: Complex
    simple: Complex
    errors: Array
    lock: Any
    rule: Any
    cause: Any

    @property
    def error(self) -> Any:
        """The relative error."""
        return self.by(Metric.RELATIVE)

    def by(self, metric: Metric) -> Any:
        """The error in one metric."""
        value = self.errors[..., metric]
        return value if value.ndim else float(value)


@dataclass(frozen=True, eq=False, kw_only=True)
class Comparison:
    """``modes`` of the simple model against the exact ``stability`` of the blade; ``c["regressing"]``."""

    stability: Stability
    modes: tuple[ModeComparison, ...]

    def __getitem__(self, name: str) -> ModeComparison:
        for mode in self.modes:
            if mode.name == name:
                return mode
        known = [m.name for m in self.modes]
        raise ParameterError(
            "mode", name, f"{name!r} is not a mode of this rotor{did_you_mean(name, known)}; it has {', '.join(known)}"
        )


def compare(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    *,
    harmonics: int = 1,
    model: Model | None = None,
    **options: Unpack[PhysicsKeywords],
) -> Comparison:
    """Compare the exact exponents of a rotor with those of its constant-coefficient model.

    Parameters
    ----------
    rotor, advance_ratio
        Broadcast against each other; the shape (...) of the result's leading axes.
    harmonics : int
        Of the simple model: 1 is the tip-path plane, M the averaged model of 2M+1 blades.
    model : "flapping" or "teetering"
        Of the exact rotor; by default after its hub.
    **options
        Physics of both, see :mod:`floquet.models.physics`.
    """
    kind = exact_model(rotor, model)
    mu = advance_ratios(advance_ratio)
    if kind == "flapping" and rotor.blades <= 2:
        warnings.warn(
            f"{rotor.blades} blade{'s' * (rotor.blades == 2)}: multiblade coordinates remove no periodicity, so the "
            "tip-path plane is not an average of the rotor; the exact exponents are the blade's all the same",
            FloquetWarning,
            stacklevel=2,
        )
    exact = stability((teetering if kind == "teetering" else blade)(rotor, mu, **options))
    simple = simple_model(rotor, mu, harmonics=harmonics, model=kind, **options)
    orders = mode_orders(harmonics, kind)
    return matched(exact, eigenvalues(simple), orders, differential=differential(simple, rotor, kind))


def exact_model(rotor: Rotor, model: str | None = None) -> Model:
    """The exact model's name: as asked, or after the hub."""
    if model is not None and model not in MODELS:
        raise ParameterError(
            "model",
            model,
            f"{model!r} is not a model{did_you_mean(str(model), MODELS)}; give 'flapping' or 'teetering'",
        )
    if model is None:
        return "teetering" if rotor.hub == Hub.TEETERING else "flapping"
    return "teetering" if model == "teetering" else "flapping"


def simple_model(
    rotor: Rotor, mu: Array, *, harmonics: int = 1, model: Model = "flapping", **options: Unpack[PhysicsKeywords]
) -> PeriodicSystem:
    """The constant model: the tip-path plane, or with more harmonics the averaged one."""
    if model == "teetering":
        if harmonics != 1:
            raise ParameterError(
                "harmonics",
                harmonics,
                "the teetering rotor is compared with its tip-path plane, eq. (7), only: leave harmonics at 1",
            )
        return tip_path_plane(
            rotor if rotor.hub == Hub.TEETERING else rotor.replace(hub=Hub.TEETERING, blades=2), mu, **options
        )
    if rotor.hub == Hub.TEETERING:
        rotor = rotor.replace(hub=Hub.ARTICULATED)
    return tip_path_plane(rotor, mu, **options) if harmonics == 1 else averaged(rotor, mu, harmonics, **options)


def mode_orders(harmonics: int, model: Model) -> tuple[int, ...]:
    """The modes k in the order they are reported: regressing, coning, advancing, regressing-2, advancing-2, …"""
    further = tuple(k for n in range(2, harmonics + 1) for k in (-n, n))
    return (-1, 1) if model == "teetering" else (-1, 0, 1, *further)


def mode_name(order: int) -> str:
    """Name of mode k."""
    if order == 0:
        return "coning"
    return ("regressing" if order < 0 else "advancing") + ("" if abs(order) == 1 else f"-{abs(order)}")


def mode_names(rotor: Rotor, model: Model | None = None) -> tuple[str, ...]:
    """Names of the modes compare() reports for this rotor with the tip-path plane."""
    kind = exact_model(rotor, model)
    names = tuple(mode_name(k) for k in mode_orders(1, kind))
    return (*names, "differential") if kind == "flapping" and has_differential(rotor) else names


def has_differential(rotor: Rotor) -> bool:
    """Whether the rotor has a differential coning coordinate beside the cyclic ones."""
    return rotor.blades >= 4 and rotor.blades % 2 == 0


def eigenvalues(system: PeriodicSystem) -> Complex:
    """Eigenvalues of a constant system, (..., states)."""
    return np.linalg.eigvals(system.sample(np.zeros(1))[..., 0, :, :]).astype(complex)


def differential(simple: PeriodicSystem, rotor: Rotor, model: Model) -> Complex | None:
    """Roots of ``s² + c0 s + k0``, the averaged equation of differential coning (table 2), for even N."""
    if model != "flapping" or not has_differential(rotor):
        return None
    assert simple.damping is not None and simple.stiffness is not None
    c, k = simple.damping.mean()[..., 0, 0], simple.stiffness.mean()[..., 0, 0]
    root = np.sqrt((0.25 * c * c - k).astype(complex))
    return np.stack([-0.5 * c + root, -0.5 * c - root], axis=-1)


# ---------------------------------------------------------------------- targets and assignment
def matched(
    exact: Stability, simple: Complex, orders: tuple[int, ...], differential: Complex | None = None
) -> Comparison:
    """Assign simple eigenvalues (..., 2·modes) to the exact targets of the modes ``orders``."""
    rho, lock = np.asarray(exact.rotation_number, float), np.asarray(exact.lock, float)
    eta = np.asarray(exact.exponents)
    shape = eta.shape[:-1]
    targets, rules = zip(*(_targets(eta.real, rho, lock, k, orders) for k in orders), strict=True)
    m = len(orders)
    values = np.broadcast_to(simple, (*shape, 2 * m)).reshape(-1, 2 * m)
    assigned = _assigned(np.stack(targets, axis=-2).reshape(-1, m, 2), values).reshape(*shape, m, 2)
    sets = [assigned[..., i, :] for i in range(m)]
    found = dict(zip(orders, zip(targets, sets, rules, strict=True), strict=True))
    _name_joint_pairs(found, lock)
    modes = [_mode(mode_name(k), *found[k], lock) for k in orders]
    if differential is not None:
        target, rule = _targets(eta.real, rho, lock, 0, (0,))
        swap = np.abs(differential - target).sum(axis=-1) > np.abs(differential[..., ::-1] - target).sum(axis=-1)
        modes.append(
            _mode("differential", target, np.where(swap[..., None], differential[..., ::-1], differential), rule, lock)
        )
    return Comparison(stability=exact, modes=tuple(modes))


def _targets(
    sigma: Array, rho: Array, lock: Array, k: int, orders: tuple[int, ...]
) -> tuple[Complex, NDArray[np.int8]]:
    """The two exact targets of mode k and the rule that gave them."""
    mirror = -2.0 * lock - k
    reals = mirror == k
    joint = ~reals & np.isin(mirror, orders)
    rule = np.where(
        np.isnan(lock), Rule.PAIRED, np.where(reals, Rule.REALS, np.where(joint, Rule.JOINT, Rule.MEAN))
    ).astype(np.int8)
    mean = sigma.mean(axis=-1)
    # of a joint pair the mode with the higher k takes σ₁ until names are settled
    split = np.where(reals[..., None], sigma, np.where((k > mirror)[..., None], sigma[..., :1], sigma[..., 1:]))
    real = np.where((reals | joint)[..., None], split, mean[..., None])
    frequency = np.where(reals, 0.0, rho + k)
    return real + 1j * np.stack([frequency, -frequency], axis=-1), rule


def _assigned(targets: Complex, values: Complex) -> Complex:
    """The simple pair of every mode, at the least total distance: targets (cases, m, 2), values (cases, 2m).

    Pairs stay whole: conjugates together, reals in neighbouring twos, or in whatever twos come nearest.
    """
    order = np.lexsort((values.imag, values.real, np.abs(values.imag)), axis=-1)
    pairs = np.take_along_axis(values, order, axis=-1).reshape(targets.shape)
    out, cost = _matched_pairs(targets, pairs)
    reals = np.sum(values.imag == 0.0, axis=-1)
    for case in np.flatnonzero((reals >= 4) & (reals <= 6)):
        flat = pairs[case].ravel()  # the reals come first
        for grouping in _groupings(range(int(reals[case]))):
            tried = np.concatenate([flat[[i for two in grouping for i in two]], flat[reals[case] :]]).reshape(-1, 2)
            other, other_cost = _matched_pairs(targets[case : case + 1], tried[None])
            if other_cost[0] < cost[case]:
                out[case], cost[case] = other[0], other_cost[0]
    return out


def _groupings(items: Sequence[int]) -> Iterator[list[tuple[int, int]]]:
    """All ways to put an even number of items in twos."""
    if not items:
        yield []
        return
    first, rest = items[0], list(items[1:])
    for second in rest:
        for others in _groupings([i for i in rest if i != second]):
            yield [(first, second), *others]


def _matched_pairs(targets: Complex, pairs: Complex) -> tuple[Complex, Array]:
    """Pairs (cases, m, 2) in the order of the targets nearest to them in total, and the total."""
    m = targets.shape[1]
    straight, crossed = (
        np.abs(targets[:, :, None, 0] - p[:, None, :, 0]) + np.abs(targets[:, :, None, 1] - p[:, None, :, 1])
        for p in (pairs, pairs[..., ::-1])
    )
    cost = np.minimum(straight, crossed)
    if m <= 3:
        orders = np.array(list(permutations(range(m))))
        totals = cost[:, np.arange(m), orders].sum(axis=-1)
        chosen = orders[np.argmin(totals, axis=-1)]
    else:
        from scipy.optimize import linear_sum_assignment

        chosen = np.stack([linear_sum_assignment(c)[1] for c in cost])
    case, mode = np.arange(len(targets))[:, None], np.arange(m)
    flip = (crossed < straight)[case, mode, chosen]
    out = pairs[case, chosen]
    return np.where(flip[..., None], out[..., ::-1], out), cost[case, mode, chosen].sum(axis=-1)


def _name_joint_pairs(found: dict[int, tuple[Complex, Complex, NDArray[np.int8]]], lock: Array) -> None:
    """Of two modes that share four targets, the regressing one (lower k) takes the lower simple frequency."""
    for low in sorted(found):
        for high in (k for k in sorted(found) if k > low):
            (z1, s1, r1), (z2, s2, r2) = found[low], found[high]
            swap = ((-2.0 * lock - low == high) & (np.abs(s1.imag).sum(axis=-1) > np.abs(s2.imag).sum(axis=-1) + REAL))[
                ..., None
            ]
            found[low] = (np.where(swap, z2, z1), np.where(swap, s2, s1), r1)
            found[high] = (np.where(swap, z1, z2), np.where(swap, s1, s2), r2)


def _mode(name: str, exact: Complex, simple: Complex, rule: NDArray[np.int8], lock: Array) -> ModeComparison:
    d = simple - exact
    parts = ((d, exact), (d.imag, exact.imag), (d.real, exact.real))
    relative, frequency, damping = (
        _ratio(np.abs(a).max(axis=-1), np.sqrt(np.mean(np.abs(b) ** 2, axis=-1))) for a, b in parts
    )
    errors = np.stack([relative, np.abs(d).max(axis=-1), frequency, damping], axis=-1)
    plain = exact.ndim == 1
    cause = _cause(exact, simple, lock)
    return ModeComparison(
        name=name,
        exact=exact,
        simple=simple,
        errors=errors,
        lock=lock.item() if plain else lock,
        rule=Rule(int(rule)) if plain else rule,
        cause=Cause(int(cause)) if plain else cause,
    )


def _ratio(a: Array, b: Array) -> Array:
    """a / b; 0 where both vanish, inf where only b does, nan where either is nan."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(b == 0, np.where(a == 0, 0.0, np.inf), a / b)


def _cause(exact: Complex, simple: Complex, lock: Array) -> NDArray[np.int8]:
    """How the two differ in kind."""
    locked = ~np.isnan(lock)
    split = np.all(np.abs(simple.imag) < REAL, axis=-1)
    kind = np.where(
        locked, np.where(split, Cause.DRIFT_IN_LOCK, Cause.LOCK), np.where(split, Cause.TPP_SPLIT, Cause.DRIFT)
    )
    differs = np.any(exact.real > 0, axis=-1) != np.any(simple.real > 0, axis=-1)
    return np.where(differs, Cause.STABILITY, kind).astype(np.int8)
