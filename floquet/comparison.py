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

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FloquetWarning, ParameterError, did_you_mean
from .exponents import BEYOND, Stability, stability
from .kernels import pairing, worth_compiling
from .kernels.quadratics import ANGLES, in_order, roots
from .models import PhysicsKeywords, teetering
from .models.flapping import blade
from .models.physics import advance_ratios
from .models.tip_path_plane import averaged_of, plane_of
from .periodic import PeriodicMatrix, PeriodicSystem
from .rotor import Hub, Rotor, Word, require_rotor

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
    "warn_of_few_blades",
]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Model = Literal["flapping", "teetering"]
MODELS = ("flapping", "teetering")


class Metric(Word):
    """How the error of a mode is measured; all but ABSOLUTE are relative to the exact targets' root mean square."""

    RELATIVE = 0  # max |s - η*| / rms |η*|
    ABSOLUTE = 1  # max |s - η*|, per rev
    FREQUENCY = 2  # max |Im (s - η*)| / rms |Im η*|
    DAMPING = 3  # max |Re (s - η*)| / rms |Re η*|


class Rule(Word):
    """What a mode was compared with; ABSENT: the rotor has no such mode."""

    PAIRED = pairing.PAIRED
    REALS = pairing.REALS
    JOINT = pairing.JOINT
    MEAN = pairing.MEAN
    ABSENT = -1


class Cause(Word):
    """How exact and simple model differ in kind at a point."""

    NONE = pairing.NONE
    DRIFT = pairing.DRIFT  # both oscillate; the simple one has drifted off
    LOCK = pairing.LOCK  # the exact exponents are locked, the simple ones are not split
    TPP_SPLIT = pairing.SPLIT  # the simple mode has split into two real eigenvalues, the exact one has not
    DRIFT_IN_LOCK = pairing.DRIFT_IN_LOCK  # both have split
    STABILITY = pairing.STABILITY  # one is stable, the other is not


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
    map: bool | str = False,
    check: bool = False,
    certify: bool = False,
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
    map : bool or str
        Take the exact exponents from polynomials over the grid of parameters; see :func:`floquet.stability`.
    check, certify : bool
        Have the exact exponents checked by a second mechanism, or proved; see :func:`floquet.stability`.
    **options
        Physics of both, see :mod:`floquet.models.physics`.
    """
    kind = exact_model(rotor, model)
    mu = advance_ratios(advance_ratio)
    warn_of_few_blades(rotor, kind, stacklevel=3)
    one = (teetering if kind == "teetering" else blade)(rotor, mu, **options)
    with np.errstate(**BEYOND):
        simple = _simplified(one, harmonics, kind)
    modes = mode_orders(harmonics, kind)
    exact = stability(one, map=map, check=check, certify=certify)
    with np.errstate(**BEYOND):
        return _matched(exact, eigenvalues(simple), modes, differential(simple, rotor, kind))


def warn_of_few_blades(rotor: Rotor, model: Model, *, stacklevel: int) -> None:
    """That one or two flapping blades have no tip-path plane."""
    if model == "flapping" and rotor.blades <= 2:
        warnings.warn(
            f"{rotor.blades} blade{'s' * (rotor.blades == 2)}: multiblade coordinates remove no periodicity, so the "
            "tip-path plane is not an average of the rotor; the exact exponents are the blade's all the same",
            FloquetWarning,
            stacklevel=stacklevel,
        )


def exact_model(rotor: Rotor, model: str | None = None) -> Model:
    """The exact model's name: as asked, or after the hub."""
    require_rotor(rotor)
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
    return _simplified((teetering if model == "teetering" else blade)(rotor, mu, **options), harmonics, model)


def _simplified(one: PeriodicSystem, harmonics: int, model: Model) -> PeriodicSystem:
    """The constant model of the equation of a blade or a teetering rotor."""
    if model == "teetering" and harmonics != 1:
        raise ParameterError(
            "harmonics",
            harmonics,
            "the teetering rotor is compared with its tip-path plane, eq. (7), only: leave harmonics at 1",
        )
    return plane_of(one, teeters=model == "teetering") if harmonics == 1 else averaged_of(one, harmonics)


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
    """Eigenvalues of a constant system, (..., states), by |Im|, then Re, then Im."""
    points = math.prod(system.cases)
    if not (system.second_order and system.degrees in ANGLES and worth_compiling(points)):
        return in_order(np.linalg.eigvals(system.sample(np.zeros(1))[..., 0, :, :]).astype(complex))
    assert system.damping is not None and system.stiffness is not None
    D, K = (_entries(m, system.cases) for m in (system.damping, system.stiffness))
    values, _ = roots(D, K)
    return values.T.reshape(*system.cases, len(values))


def _entries(matrix: PeriodicMatrix, cases: tuple[int, ...]) -> Array:
    """The entries of a constant matrix by rows, (n², points)."""
    n, m = matrix.shape
    rows = np.moveaxis(np.broadcast_to(matrix.mean(), (*cases, n, m)), (-2, -1), (0, 1))
    return rows.reshape(n * m, math.prod(cases))


def differential(simple: PeriodicSystem, rotor: Rotor, model: Model) -> Complex | None:
    """Roots of ``s² + c0 s + k0``, the averaged equation of differential coning (table 2), for even N."""
    if model != "flapping" or not has_differential(rotor):
        return None
    assert simple.damping is not None and simple.stiffness is not None
    c, k = simple.damping.mean()[..., 0, 0], simple.stiffness.mean()[..., 0, 0]
    root = np.sqrt((0.25 * c * c - k).astype(complex))
    return np.stack([-0.5 * c + root, -0.5 * c - root], axis=-1)


# ---------------------------------------------------------------------- pairs
def matched(
    exact: Stability, simple: Complex, orders: tuple[int, ...], differential: Complex | None = None
) -> Comparison:
    """Assign simple eigenvalues (..., 2·modes) to the exact targets of the modes ``orders``."""
    return _matched(exact, in_order(np.asarray(simple)), orders, differential)


def _matched(exact: Stability, simple: Complex, orders: tuple[int, ...], differential: Complex | None) -> Comparison:
    """The same for eigenvalues in order."""
    modes = _paired(exact, simple, orders, tuple(mode_name(k) for k in orders))
    if differential is not None:
        modes += _paired(exact, differential, (0,), ("differential",))
    return Comparison(stability=exact, modes=modes)


def _paired(
    exact: Stability, simple: Complex, orders: tuple[int, ...], names: tuple[str, ...]
) -> tuple[ModeComparison, ...]:
    """The modes ``orders`` and the pairs assigned to them."""
    eta = np.asarray(exact.exponents)
    shape = eta.shape[:-1]
    points = math.prod(shape)
    state = np.empty((4, *shape))
    state[:2], state[2], state[3] = np.moveaxis(eta.real, -1, 0), exact.rotation_number, exact.lock
    values = np.moveaxis(np.broadcast_to(simple, (*shape, 2 * len(orders))), -1, 0).reshape(2 * len(orders), points)
    found = pairing.paired(state.reshape(4, points), values, orders)
    return tuple(_mode(name, found, i, shape, exact.lock) for i, name in enumerate(names))


def _mode(name: str, found: pairing.Pairing, i: int, shape: tuple[int, ...], lock: Any) -> ModeComparison:
    """One of the modes; plain numbers for a single case."""
    rule, cause = found.rule[i].reshape(shape), found.cause[i].reshape(shape)
    return ModeComparison(
        name=name,
        exact=found.exact[i].T.reshape(*shape, 2),
        simple=found.simple[i].T.reshape(*shape, 2),
        errors=found.errors[i].T.reshape(*shape, 4),
        lock=np.asarray(lock, float) if shape else float(lock),
        rule=rule if shape else Rule(int(rule)),
        cause=cause if shape else Cause(int(cause)),
    )
