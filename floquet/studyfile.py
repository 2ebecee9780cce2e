"""Study files: TOML → a plan.

::

    [study]    name, schema = 1, title
    [rotors]   files = ["rotor.toml", …] | list = [{lock_number = 8.0, …}, …] | grid = {lock_number = [4, 8], …}
               | sobol = {count = 64, seed = 1, lock_number = [4, 12], …}: any of them, one after another
    [axes]     advance_ratio = {start = 0.0, stop = 1.0, count = 401} or a list of numbers
    [compare]  model = "auto" | "flapping" | "teetering", the options of :mod:`floquet.models.physics`,
               tolerances, absolute_tolerances, mu_max
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field

from .comparison import Metric, Model
from .errors import ConfigError, InputError, Problem, did_you_mean
from .models import Physics
from .rotor import PARAMETERS, Hub, Rotor, load_rotor
from .sweep import ENGINE, Plan
from .tomlfile import Table, read_toml

__all__ = ["Study", "StudyFile", "load_study"]


class _Table(Table):
    model_config = ConfigDict(populate_by_name=True)


class Range(_Table):
    """``{start = 0.0, stop = 1.0, count = 401}``, both ends included."""

    start: float
    stop: float
    count: Annotated[int, Field(ge=1, le=10**7)]

    def values(self) -> list[float]:
        """The numbers."""
        return [float(x) for x in np.linspace(self.start, self.stop, self.count)]


Axis = Range | list[float]


class StudyTable(_Table):
    """``[study]``"""

    name: str
    schema_version: Literal[1] = Field(1, alias="schema")
    title: str = ""


class RotorsTable(_Table):
    """``[rotors]``: any of files, list, grid and sobol; their rotors follow one another."""

    files: list[str] = Field(default_factory=list)
    rotors: list[dict[str, Any]] = Field(default_factory=list, alias="list")
    grid: dict[str, Any] = Field(default_factory=dict)
    sobol: dict[str, Any] = Field(default_factory=dict)


class AxesTable(_Table):
    """``[axes]``"""

    advance_ratio: Axis


class CompareTable(_Table):
    """``[compare]``: model, physics, and what the limits are sought for."""

    model: Literal["auto", "flapping", "teetering"] = "auto"
    exact_offset: bool = False
    reversed_flow: bool = False
    tip_loss: float = 1.0
    kinematic_rates: bool = False
    tolerances: list[Annotated[float, Field(gt=0)]] = Field(default_factory=lambda: [0.05])
    absolute_tolerances: list[Annotated[float, Field(gt=0)]] = Field(default_factory=list)
    mu_max: Annotated[float, Field(gt=0)] = 1.0


class StudyFile(_Table):
    """A study file."""

    study: StudyTable
    rotors: RotorsTable
    axes: AxesTable
    compare: CompareTable = CompareTable()


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study: its name, its input and its plan."""

    name: str
    title: str
    text: str
    plan: Plan

    @property
    def id(self) -> str:
        """Hash of everything that decides a number."""
        plan, h = self.plan, hashlib.blake2b(digest_size=16)
        options = {"engine": ENGINE, "model": plan.model, "mu_max": plan.mu_max, **plan.physics.as_dict()}
        h.update(json.dumps([options, [[int(m), t] for m, t in plan.tolerances]], sort_keys=True).encode())
        h.update(plan.advance_ratio.astype("<f8").tobytes())
        for rotor in plan.rotors:
            h.update(json.dumps([rotor.name, int(rotor.hub), rotor.blades, list(rotor.shape)]).encode())
            for p in PARAMETERS:
                h.update(np.asarray(getattr(rotor, p.name), "<f8").tobytes())
        return h.hexdigest()


def load_study(path: str | Path) -> Study:
    """Read a study file; every problem at once, with its line."""
    path = Path(path)
    data = read_toml(path, StudyFile)
    try:
        compare = data.compare
        model: Model | None = None if compare.model == "auto" else compare.model
        physics = Physics(
            exact_offset=compare.exact_offset,
            reversed_flow=compare.reversed_flow,
            tip_loss=compare.tip_loss,
            kinematic_rates=compare.kinematic_rates,
        )
        tolerances = [(Metric.RELATIVE, t) for t in compare.tolerances] + [
            (Metric.ABSOLUTE, t) for t in compare.absolute_tolerances
        ]
        mu = data.axes.advance_ratio
        plan = Plan(
            rotors=tuple(_rotors(data.rotors, path.parent)),
            advance_ratio=np.array(_values(mu)),
            model=model,
            physics=physics,
            tolerances=tuple(tolerances),
            mu_max=compare.mu_max,
        )
    except ConfigError:
        raise
    except InputError as error:
        raise ConfigError(path, [Problem(0, "", str(error))]) from error
    return Study(
        name=data.study.name,
        title=data.study.title or data.study.name,
        text=path.read_text(encoding="utf-8"),
        plan=plan,
    )


def _values(axis: Axis) -> list[float]:
    return axis.values() if isinstance(axis, Range) else axis


def _rotors(table: RotorsTable, folder: Path) -> Iterator[Rotor]:
    """The rotors of a study in the order files, list, grid, sobol."""
    if not (table.files or table.rotors or table.grid or table.sobol):
        raise InputError("[rotors] is empty: give files = [...], list = [...], grid = {...} or sobol = {...}")
    for file in table.files:
        yield load_rotor(folder / file)
    for values in table.rotors:
        yield _rotor(values)
    if table.grid:
        yield from _grid(table.grid)
    if table.sobol:
        yield _sobol(dict(table.sobol))


def _rotor(values: Mapping[str, Any]) -> Rotor:
    """A rotor from keys as they are written, hub as a word."""
    fields = dict(values)
    if isinstance(hub := fields.get("hub"), str):
        known = [h.name.lower() for h in Hub]
        if hub.lower() not in known:
            raise InputError(f"hub {hub!r} is neither articulated nor teetering{did_you_mean(hub.lower(), known)}")
        fields["hub"] = Hub[hub.upper()]
    return Rotor(**fields)


def _grid(grid: Mapping[str, Any]) -> Iterator[Rotor]:
    """The outer product of the axes, the last one fastest; one Rotor a number of blades and hub."""
    axes = {name: _axis(name, value) for name, value in grid.items()}
    outer = {n: axes.pop(n) for n in ("hub", "blades") if n in axes}
    mesh = np.meshgrid(*[np.array(v, float) for v in axes.values()], indexing="ij") if axes else []
    values = {name: m.ravel() for name, m in zip(axes, mesh, strict=True)}
    for chosen in product(*outer.values()):
        yield _rotor(dict(zip(outer, chosen, strict=True)) | values)


def _axis(name: str, value: Any) -> list[Any]:
    if isinstance(value, dict):
        return (
            Range.model_validate(value).values() if set(value) == {"start", "stop", "count"} else _no_axis(name, value)
        )
    return list(value) if isinstance(value, list) and value else [value]


def _no_axis(name: str, value: Any) -> list[Any]:
    raise InputError(
        f"rotors.grid.{name}: {value!r} is no axis: give {{start = …, stop = …, count = …}} or a list of values"
    )


def _sobol(spec: dict[str, Any]) -> Rotor:
    """Sobol points in a box, scrambled with a seed."""
    from scipy.stats import qmc

    count, seed = spec.pop("count", 0), spec.pop("seed", 0)
    fixed = {k: spec.pop(k) for k in ("hub", "blades") if k in spec}
    if not (isinstance(count, int) and count > 0 and count & (count - 1) == 0 and isinstance(seed, int)):
        raise InputError(
            f"rotors.sobol: count = {count!r} is no power of two above 0 (with a whole seed): "
            "Sobol points keep their balance only so"
        )
    bounds = {}
    for name, value in spec.items():
        if not (isinstance(value, list) and len(value) == 2 and value[0] < value[1]):
            raise InputError(f"rotors.sobol.{name}: {value!r} is no interval: give [low, high]")
        bounds[name] = value
    unit = qmc.Sobol(len(bounds), scramble=True, rng=np.random.default_rng(seed)).random(count)
    return _rotor(
        fixed | {name: low + (high - low) * unit[:, i] for i, (name, (low, high)) in enumerate(bounds.items())}
    )
