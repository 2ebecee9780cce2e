"""A plan of points → chunks of rows.  Knows no files.

Point i of a plan is design i // m at advance ratio i % m, for m advance ratios.  A row depends on its own parameters
alone: the same point gives the same bits in any chunk.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .comparison import Comparison, Metric, Model, Rule, compare, exact_model
from .environment import check_environment
from .errors import ParameterError
from .kernels import POINTS, part_of
from .models import Physics, PhysicsKeywords
from .models.physics import advance_ratios
from .rotor import PARAMETERS, Hub, Rotor, require_rotor
from .validity import Limits, all_limits

__all__ = ["ENGINE", "INTERVALS", "MODES", "Plan", "limit_rows", "limits_at", "point_rows", "points_at", "sweep"]

Rows = dict[str, NDArray[Any]]

#: Modes that have columns of their own, in the order of the database's flags.
MODES = ("regressing", "coning", "advancing", "differential")
#: Intervals of failure kept in a row of limits; their true number is a column.
INTERVALS = 6
DIGITS = 12  # of a parameter: 1.5 * 0.1 is the 0.15 that someone writes
#: Raised when any number in a row changes.
ENGINE = 3
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
    map : bool
        Take exact exponents from polynomials in the advance ratio, a design at a time; rows say so by their method.
    """

    rotors: tuple[Rotor, ...]
    advance_ratio: NDArray[np.float64]
    model: Model | None = None
    physics: Physics = field(default_factory=Physics)
    tolerances: tuple[tuple[Metric, float], ...] = ((Metric.RELATIVE, 0.05),)
    mu_max: float = 1.0
    map: bool = False

    def __post_init__(self) -> None:
        check_environment()
        object.__setattr__(self, "rotors", tuple(require_rotor(rotor) for rotor in self.rotors))
        if not isinstance(self.map, (bool, np.bool_)):
            raise ParameterError("map", self.map, f"{self.map!r} is neither True nor False")
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

    @property
    def options(self) -> dict[str, Any]:
        """What the rows of one database have in common beside their columns."""
        return {"model": self.model or "by hub", **self.physics.as_dict()}

    def parameters(self, designs: NDArray[np.intp]) -> tuple[Rows, NDArray[np.int8], NDArray[np.int16]]:
        """Parameters, hubs and numbers of blades of some designs."""
        first: NDArray[np.intp] = self._first  # type: ignore[attr-defined]
        which = np.searchsorted(first, designs, side="right") - 1
        values = {p.name: np.empty(len(designs)) for p in PARAMETERS}
        hubs, blades = np.empty(len(designs), np.int8), np.empty(len(designs), np.int16)
        for i in np.unique(which):
            rotor, some = self.rotors[i], which == i
            hubs[some], blades[some] = rotor.hub, rotor.blades
            local = designs[some] - first[i]
            for name, column in values.items():
                value = np.asarray(getattr(rotor, name), float)
                column[some] = value if value.ndim == 0 else np.broadcast_to(value, rotor.shape).flat[local]
        return values, hubs, blades

    def repeated(self) -> list[tuple[int, int]]:
        """(design, the first equal to it) of every design given by itself that others equal in all but the name.

        A grid or a sample has no equal designs of its own, so that with nothing else there is nothing to compare.
        """
        if self.designs < 2 or all(rotor.shape for rotor in self.rotors):
            return []
        return repeated(*self.parameters(np.arange(self.designs)))

    def design(self, index: int) -> Rotor:
        """One design, without arrays."""
        first: NDArray[np.intp] = self._first  # type: ignore[attr-defined]
        i = int(np.searchsorted(first, index, side="right")) - 1
        rotor = self.rotors[i]
        return rotor if not rotor.shape else rotor[np.unravel_index(index - int(first[i]), rotor.shape)]


def repeated(values: Rows, hubs: NDArray[np.int8], blades: NDArray[np.int16]) -> list[tuple[int, int]]:
    """(design, the first equal to it) of designs by their parameters, to :data:`DIGITS` places."""
    table = np.round(np.column_stack([hubs, blades, *values.values()]), DIGITS) + 0.0  # -0 is 0
    _, first, which = np.unique(table, axis=0, return_index=True, return_inverse=True)
    earlier = first[which.ravel()]
    again = np.flatnonzero(earlier != np.arange(len(table)))
    return list(zip(again.tolist(), earlier[again].tolist(), strict=True))


def sweep(
    rotor: Rotor,
    advance_ratio: ArrayLike,
    *,
    model: Model | None = None,
    map: bool = False,
    **options: Unpack[PhysicsKeywords],
) -> Rows:
    """Compare every case of ``rotor`` at every advance ratio; columns of the points table, one row a case and μ.

    ``map`` takes exact exponents from polynomials in the advance ratio, as ``compare.map = true`` does in a study.
    """
    plan = Plan(
        rotors=(rotor,),
        advance_ratio=advance_ratios(advance_ratio).ravel(),
        model=model,
        map=map,
        physics=Physics.of(options),
        tolerances=(),
    )
    return point_rows(plan, 0, plan.points)


def point_rows(plan: Plan, start: int, stop: int, columns: Collection[str] | None = None) -> Rows:
    """Rows start … stop of the points table; all its columns, or those that are named."""
    return points_at(plan, np.arange(start, stop), columns)


def points_at(plan: Plan, index: NDArray[np.intp], columns: Collection[str] | None = None) -> Rows:
    """Some rows of the points table, in ascending order; one row a point, in that order."""
    designs, mu = index // plan.advance_ratio.size, plan.advance_ratio[index % plan.advance_ratio.size]
    values, hubs, blades = plan.parameters(designs)
    out: Rows = {"rotor": designs.astype(np.int32), "advance_ratio": mu, **_parameters(values, hubs, blades)}
    with part_of(plan.points):
        parts = list(_mapped(plan, index) if plan.map else _one_by_one(plan, mu, values, hubs, blades))
    absent = _absent(len(index))
    out |= {name: _joined(name, parts, value) for name, value in absent.items() if columns is None or name in columns}
    return {name: value for name, value in out.items() if columns is None or name in columns}


def _one_by_one(
    plan: Plan, mu: NDArray[np.float64], values: Rows, hubs: NDArray[np.int8], blades: NDArray[np.int16]
) -> Iterator[tuple[Any, Rows]]:
    """Rows and their results, those of a kind together."""
    for hub, count, some in _kinds(hubs, blades):
        group = Rotor(hub=hub, blades=count, **{name: value[some] for name, value in values.items()})
        found = compare(group, mu[some], model=exact_model(group, plan.model), **plan.physics.as_dict())
        yield some, _results(found)


def _mapped(plan: Plan, index: NDArray[np.intp]) -> Iterator[tuple[Any, Rows]]:
    """The same from maps along the advance ratio, of whole designs whatever part of them is wanted."""
    m = plan.advance_ratio.size
    designs = np.unique(index // m)
    values, hubs, blades = plan.parameters(designs)
    for hub, count, some in _kinds(hubs, blades):
        columns: dict[str, Any] = {name: value[some][:, None] for name, value in values.items()}
        group = Rotor(hub=hub, blades=count, **columns)
        model, options = exact_model(group, plan.model), plan.physics.as_dict()
        found = compare(group, plan.advance_ratio, model=model, map="advance_ratio", **options)
        places = (designs[some] * m)[:, None] + np.arange(m)
        wanted = np.isin(places, index)
        yield np.searchsorted(index, places[wanted]), {name: value[wanted] for name, value in _results(found).items()}


def limit_rows(plan: Plan, start: int, stop: int) -> Rows:
    """Rows of the limits table of designs start … stop: mode × (metric, tolerance) each."""
    return limits_at(plan, np.arange(start, stop))


def limits_at(plan: Plan, designs: NDArray[np.intp]) -> Rows:
    """Rows of the limits table of some designs, in ascending order."""
    values, hubs, blades = plan.parameters(designs)
    parts = [_limit_columns(designs[:0], _none_wanted())]
    for hub, count, some in _kinds(hubs, blades) if plan.tolerances and len(designs) else ():
        group = Rotor(hub=hub, blades=count, **{name: value[some] for name, value in values.items()})
        options: dict[str, Any] = {"mu_max": plan.mu_max, "model": plan.model, **plan.physics.as_dict()}
        with part_of(POINTS):
            found = all_limits(group, tolerances=plan.tolerances, **options)
        parts.append(_limit_columns(designs[some], found))
    out = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(out["rotor"], kind="stable")
    out = {name: value[order] for name, value in out.items()}
    return out | _parameters(*plan.parameters(out["rotor"].astype(np.intp)))


def _limit_columns(designs: NDArray[np.intp], found: Limits) -> Rows:
    """The columns of limits, a row a design and wanted mode, metric and tolerance."""
    n, w = len(designs), len(found.wanted)
    out: Rows = {"rotor": np.repeat(designs, w).astype(np.int32)}
    out["mode"] = np.tile(np.array([MODES.index(mode) for mode, _, _ in found.wanted], np.int8), n)
    out["metric"] = np.tile(np.array([metric for _, metric, _ in found.wanted], np.int8), n)
    out["tolerance"] = np.tile(np.array([tolerance for _, _, tolerance in found.wanted], float), n)
    out["mu_max"] = np.full(n * w, found.mu_max)
    out |= {name: getattr(found, name).ravel() for name in ("limit", "lock", "lock_edge", "split_edge")}
    out |= {name: getattr(found, name).ravel() for name in ("cause", "rule")}
    out["intervals"] = found.counts.ravel().astype(np.int32)
    starts, ends = found.intervals(INTERVALS)
    for k in range(INTERVALS):
        out[f"interval_{k + 1}_start"], out[f"interval_{k + 1}_end"] = starts[..., k].ravel(), ends[..., k].ravel()
    return out


def _none_wanted() -> Limits:
    """Of no rotor and no tolerance."""
    empty, small, none = np.zeros((0, 0)), np.zeros((0, 0), np.int8), np.zeros(0)
    arrays: dict[str, Any] = {
        "limit": empty,
        "cause": small,
        "rule": small,
        "lock": empty,
        "lock_edge": empty,
        "split_edge": empty,
    }
    return Limits(wanted=(), counts=np.zeros((0, 0), np.int64), starts=none, ends=none, mu_max=math.nan, **arrays)


# ---------------------------------------------------------------------- rows
def _parameters(values: Rows, hubs: NDArray[Any], blades: NDArray[Any]) -> Rows:
    """The parameter columns of some designs."""
    frequency = np.sqrt(1.0 + values["hinge_stiffness"] + values["offset_mass_ratio"])
    return {**values, "blades": blades, "hub": hubs, "flap_frequency": frequency}


def _kinds(hubs: NDArray[np.int8], blades: NDArray[np.int16]) -> Iterator[tuple[Hub, int, Any]]:
    """Hub, number of blades, and the rows that have them: all of them where there is one kind."""
    if hubs.min() == hubs.max() and blades.min() == blades.max():
        yield Hub(int(hubs[0])), int(blades[0]), slice(None)
        return
    kinds = hubs.astype(np.int32) * 2**15 + blades
    for kind in np.unique(kinds):
        yield Hub(int(kind) >> 15), int(kind) % 2**15, np.flatnonzero(kinds == kind)


def _absent(n: int) -> Rows:
    """Result columns of rows that have no such result; columns of one type share their memory."""
    number, pair, small = np.full(n, np.nan), np.full(n, complex(np.nan, np.nan)), np.zeros(n, np.int8)
    out: Rows = {"exponent_1": pair, "exponent_2": pair}
    out |= dict.fromkeys(("exponent_error", "rotation_number", "lock", "determinant_defect"), number)
    out |= {"verdict": small, "method": small, "panels": np.zeros(n, np.int32)}
    rule = np.full(n, Rule.ABSENT, np.int8)
    for mode in MODES:
        out |= {f"{part}_{mode}_{i}": pair for part in ("exact", "tpp") for i in (1, 2)}
        out |= {column.format(mode): number for column in METRIC_COLUMNS.values()}
        out |= {f"rule_{mode}": rule, f"cause_{mode}": small}
    return out


def _results(found: Comparison) -> Rows:
    """The result columns of a comparison."""
    s = found.stability
    out: Rows = {f"exponent_{i + 1}": s.exponents[..., i] for i in (0, 1)}
    out["exponent_error"] = s.exponent_errors[..., 0]  # one bound for both
    names = ("rotation_number", "lock", "determinant_defect", "verdict", "method", "panels")
    out |= {name: getattr(s, name) for name in names}
    for mode in found.modes:
        for i in (0, 1):
            out[f"exact_{mode.name}_{i + 1}"] = mode.exact[..., i]
            out[f"tpp_{mode.name}_{i + 1}"] = mode.simple[..., i]
        out |= {column.format(mode.name): mode.by(metric) for metric, column in METRIC_COLUMNS.items()}
        out |= {f"rule_{mode.name}": mode.rule, f"cause_{mode.name}": mode.cause}
    return out


def _joined(name: str, parts: Sequence[tuple[Any, Rows]], absent: NDArray[Any]) -> NDArray[Any]:
    """A column of all rows from those of groups of them."""
    if len(parts) == 1:
        return parts[0][1].get(name, absent)
    out = absent.copy()
    for rows, results in parts:
        if name in results:
            out[rows] = results[name]
    return out
