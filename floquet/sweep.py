"""A plan of points → chunks of rows.  Knows no files.

Point i of a plan is design i // m at advance ratio i % m, for m advance ratios.  A row depends on its own parameters
alone: the same point gives the same bits in any chunk.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .comparison import Comparison, Metric, Model, Rule, compare, exact_model
from .errors import ParameterError
from .models import Physics, PhysicsKeywords
from .models.physics import advance_ratios
from .rotor import PARAMETERS, Hub, Rotor
from .validity import Limit, limits

__all__ = ["ENGINE", "INTERVALS", "MODES", "Plan", "limit_rows", "point_rows", "sweep"]

Rows = dict[str, NDArray[Any]]

#: Modes that have columns of their own, in the order of the database's flags.
MODES = ("regressing", "coning", "advancing", "differential")
#: Intervals of failure kept in a row of limits; their true number is a column.
INTERVALS = 6
#: Raised when any number in a row changes.
ENGINE = 2
METRIC_COLUMNS = {
    Metric.RELATIVE: "error_{}",
    Metric.ABSOLUTE: "error_absolute_{}",
    Metric.FREQUENCY: "error_frequency_{}",
    Metric.DAMPING: "error_damping_{}",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """What to compute: designs × advance ratios, and limits of every design.

    Parameters
    ----------
    rotors : sequence of Rotor
        The designs; a Rotor with arrays stands for all its cases.
    advance_ratio : (m,) array
    model : "flapping", "teetering" or None
        None: after each design's hub.
    physics : Physics
    tolerances : tuple of (Metric, float)
        Of the limits; empty for none.
    mu_max : float
        How far limits are sought.
    """

    rotors: tuple[Rotor, ...]
    advance_ratio: NDArray[np.float64]
    model: Model | None = None
    physics: Physics = field(default_factory=Physics)
    tolerances: tuple[tuple[Metric, float], ...] = ((Metric.RELATIVE, 0.05),)
    mu_max: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotors", tuple(self.rotors))
        object.__setattr__(self, "advance_ratio", np.atleast_1d(advance_ratios(self.advance_ratio)))
        sizes = np.array([math.prod(r.shape) for r in self.rotors], int)
        if not sizes.sum() or not self.advance_ratio.size:
            raise ParameterError("plan", None, "there is nothing to compute: the plan has no rotor or no advance ratio")
        object.__setattr__(self, "_first", np.concatenate([[0], np.cumsum(sizes)]))

    @property
    def designs(self) -> int:
        """Number of designs."""
        return int(self._first[-1])  # type: ignore[attr-defined]

    @property
    def points(self) -> int:
        """Number of points."""
        return self.designs * self.advance_ratio.size

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the designs, empty if none has one."""
        names = (
            [r.name for r in self.rotors for _ in range(math.prod(r.shape))] if any(r.name for r in self.rotors) else []
        )
        return tuple(names)

    def design(self, index: int) -> Rotor:
        """One design, without arrays."""
        first: NDArray[np.intp] = self._first  # type: ignore[attr-defined]
        i = int(np.searchsorted(first, index, side="right")) - 1
        rotor = self.rotors[i]
        return rotor if not rotor.shape else rotor[np.unravel_index(index - int(first[i]), rotor.shape)]


def sweep(
    rotor: Rotor, advance_ratio: ArrayLike, *, model: Model | None = None, **options: Unpack[PhysicsKeywords]
) -> Rows:
    """Compare every case of ``rotor`` at every advance ratio; columns of the points table, one row a case and μ."""
    plan = Plan(
        rotors=(rotor,),
        advance_ratio=np.asarray(advance_ratio, float).ravel(),
        model=model,
        physics=Physics.of(options),
        tolerances=(),
    )
    return point_rows(plan, 0, plan.points)


def point_rows(plan: Plan, start: int, stop: int) -> Rows:
    """Rows start … stop of the points table."""
    m = plan.advance_ratio.size
    index = np.arange(start, stop)
    designs, which = np.unique(index // m, return_inverse=True)
    rotors = [plan.design(int(d)) for d in designs]
    mu = plan.advance_ratio[index % m]
    out: Rows = {"rotor": (index // m).astype(np.int32), "advance_ratio": mu, **_parameters([rotors[w] for w in which])}
    out.update(_empty(len(index)))
    kinds = [(r.hub, r.blades, exact_model(r, plan.model)) for r in rotors]
    for kind in sorted(set(kinds)):
        chosen = np.flatnonzero(np.array([kinds[w] == kind for w in which]))
        group = _stacked([rotors[which[i]] for i in chosen], kind[0], kind[1])
        found = compare(group, mu[chosen], model=kind[2], **plan.physics.as_dict())
        _fill(out, chosen, found)
    return out


def limit_rows(plan: Plan, start: int, stop: int) -> Rows:
    """Rows of the limits table of designs start … stop: mode × (metric, tolerance) each."""
    rows: list[tuple[int, Rotor, Limit]] = []
    for d in range(start, stop):
        rotor = plan.design(d)
        if plan.tolerances:
            found = limits(
                rotor, tolerances=plan.tolerances, mu_max=plan.mu_max, model=plan.model, **plan.physics.as_dict()
            )
            rows += [(d, rotor, limit) for limit in found]
    out: Rows = {"rotor": np.array([d for d, _, _ in rows], np.int32), **_parameters([r for _, r, _ in rows])}
    found_limits = [limit for _, _, limit in rows]
    out["mode"] = np.array([MODES.index(x.mode) for x in found_limits], np.int8)
    out["metric"] = np.array([x.metric for x in found_limits], np.int8)
    for name in ("tolerance", "limit", "mu_max", "lock", "lock_edge", "split_edge"):
        out[name] = np.array([getattr(x, name) for x in found_limits], float)
    out["cause"] = np.array([x.cause for x in found_limits], np.int8)
    out["rule"] = np.array([x.rule for x in found_limits], np.int8)
    out["intervals"] = np.array([len(x.intervals) for x in found_limits], np.int32)
    for k in range(INTERVALS):
        ends = [x.intervals[k] if k < len(x.intervals) else (math.nan, math.nan) for x in found_limits]
        out[f"interval_{k + 1}_start"], out[f"interval_{k + 1}_end"] = (
            np.array([e[i] for e in ends], float) for i in (0, 1)
        )
    return out


# ---------------------------------------------------------------------- rows
def _parameters(rotors: Sequence[Rotor]) -> Rows:
    """The parameter columns of some designs."""
    out: Rows = {p.name: np.array([getattr(r, p.name) for r in rotors], float) for p in PARAMETERS}
    out["blades"] = np.array([r.blades for r in rotors], np.int16)
    out["hub"] = np.array([r.hub for r in rotors], np.int8)
    out["flap_frequency"] = np.array([r.flap_frequency for r in rotors], float)
    return out


def _stacked(rotors: Sequence[Rotor], hub: Hub, blades: int) -> Rotor:
    """One Rotor with an array a parameter."""
    values: dict[str, Any] = {p.name: np.array([getattr(r, p.name) for r in rotors], float) for p in PARAMETERS}
    return Rotor(hub=hub, blades=blades, **values)


def _empty(n: int) -> Rows:
    """Result columns with everything absent."""
    out: Rows = {f"exponent_{i}": np.full(n, np.nan + 0j) for i in (1, 2)}
    out |= {name: np.full(n, np.nan) for name in ("exponent_error", "rotation_number", "lock", "determinant_defect")}
    out |= {name: np.zeros(n, np.int8) for name in ("verdict", "method")} | {"panels": np.zeros(n, np.int32)}
    for mode in MODES:
        out |= {f"{part}_{mode}_{i}": np.full(n, complex(np.nan, np.nan)) for part in ("exact", "tpp") for i in (1, 2)}
        out |= {column.format(mode): np.full(n, np.nan) for column in METRIC_COLUMNS.values()}
        out |= {f"rule_{mode}": np.full(n, Rule.ABSENT, np.int8), f"cause_{mode}": np.zeros(n, np.int8)}
    return out


def _fill(out: Rows, rows: NDArray[np.intp], found: Comparison) -> None:
    """Put a comparison into its rows."""
    s = found.stability
    for i in (0, 1):
        out[f"exponent_{i + 1}"][rows] = s.exponents[..., i]
    out["exponent_error"][rows] = s.exponent_errors.max(axis=-1)
    for name in ("rotation_number", "lock", "determinant_defect", "verdict", "method", "panels"):
        out[name][rows] = getattr(s, name)
    for mode in found.modes:
        for i in (0, 1):
            out[f"exact_{mode.name}_{i + 1}"][rows] = mode.exact[..., i]
            out[f"tpp_{mode.name}_{i + 1}"][rows] = mode.simple[..., i]
        for metric, column in METRIC_COLUMNS.items():
            out[column.format(mode.name)][rows] = mode.by(metric)
        out[f"rule_{mode.name}"][rows], out[f"cause_{mode.name}"][rows] = mode.rule, mode.cause
