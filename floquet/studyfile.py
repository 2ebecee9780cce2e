"""Study files: TOML → a plan.

::

    [study]    name, schema = 1, title
    [rotors]   files = ["rotor.toml", …] | list = [{lock_number = 8.0, …}, …] | grid = {lock_number = [4, 8], …}
               | sobol = {count = 64, seed = 1, lock_number = [4, 12], …}
               | random = {count = 100, seed = 1, lock_number = [4, 12], …}: any of them, one after another
    [axes]     advance_ratio = {start = 0.0, stop = 1.0, count = 401} or a list of numbers
    [compare]  model = "auto" | "flapping" | "teetering", the options of :mod:`floquet.models.physics`,
               tolerances, absolute_tolerances, mu_max, map
    [output]   columns = ["error_regressing", …], of the points
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, create_model

from . import store
from .comparison import Metric, Model
from .errors import ConfigError, FloquetWarning, InputError, Problem, did_you_mean, file_name
from .models import Physics
from .rotor import PARAMETERS, Hub, Rotor, doubtful, load_rotor
from .sweep import ENGINE, Plan
from .tomlfile import Document, Table, read_document

__all__ = ["Study", "StudyFile", "load_study"]


class _Table(Table):
    model_config = ConfigDict(populate_by_name=True)


class Range(_Table):
    """``{start = 0.0, stop = 1.0, count = 401}``, both ends included."""

    start: float
    stop: float
    count: Annotated[int, Field(ge=1, le=10**7)]

    def values(self) -> list[float]:
        """The numbers, as one would write them: 0.35, not 0.35000000000000003."""
        with np.errstate(all="ignore"):  # what becomes of bold ends is looked at where it is used
            return [float(f"{x:.15g}") for x in np.linspace(self.start, self.stop, self.count).tolist()]


def _form(value: Any) -> str:
    """Which form of an axis is written, so that only its own rule is told."""
    return "range" if isinstance(value, dict | Range) else "list" if isinstance(value, list) else "one"


def _interval(value: list[float]) -> list[float]:
    if len(value) != 2 or not value[0] < value[1]:
        raise ValueError(f"{value} is no interval: give [low, high] with low below high")
    return value


def _power_of_two(value: int) -> int:
    if not 0 < value <= MOST or value & (value - 1):
        raise ValueError(
            f"count = {value} is no power of two from 1 to {MOST}: Sobol points keep their balance only so"
        )
    return value


MOST = 2**23  # Sobol points
MOST_DESIGNS = 10**7  # of a study: their parameters are kept in memory, 0.1 kB each
MOST_POINTS = 10**11  # of a study: a day on one processor, and 30 TB if all columns are stored
_Ranged = Annotated[Range, Tag("range")]
Axis = Annotated[
    _Ranged | Annotated[list[float], Tag("list")], Discriminator(lambda v: _form(v).replace("one", "list"))
]
_Axis = Annotated[
    _Ranged | Annotated[list[float], Field(min_length=1), Tag("list")] | Annotated[float, Tag("one")],
    Discriminator(_form),
]
_Listed = Discriminator(lambda v: "list" if isinstance(v, list) else "one")
_Blades = Annotated[Annotated[list[int], Field(min_length=1), Tag("list")] | Annotated[int, Tag("one")], _Listed]
_Hubs = Annotated[Annotated[list[str], Field(min_length=1), Tag("list")] | Annotated[str, Tag("one")], _Listed]
_Interval = Annotated[list[float], AfterValidator(_interval)]
_NAMES = tuple(p.name for p in PARAMETERS)

GridTable: type[_Table] = create_model(
    "GridTable",
    __base__=_Table,
    **{name: (_Axis | None, None) for name in _NAMES},
    blades=(_Blades | None, None),
    hub=(_Hubs | None, None),
)  # type: ignore[call-overload]
GridTable.__doc__ = "``[rotors.grid]``: a number, a list or a range a parameter; the rotors are their outer product."

_BOX: dict[str, Any] = {
    "seed": (Annotated[int, Field(ge=0)], 0),
    **{name: (_Interval | None, None) for name in _NAMES},
    "blades": (int | None, None),
    "hub": (str | None, None),
}
SobolTable: type[_Table] = create_model(
    "SobolTable", __base__=_Table, count=(Annotated[int, AfterValidator(_power_of_two)], ...), **_BOX
)
SobolTable.__doc__ = "``[rotors.sobol]``: how many points, a seed, and [low, high] of every parameter that varies."

RandomTable: type[_Table] = create_model(
    "RandomTable", __base__=_Table, count=(Annotated[int, Field(ge=1, le=10**7)], ...), **_BOX
)
RandomTable.__doc__ = "``[rotors.random]``: the same, of independent and even chance, in any number."


class StudyTable(_Table):
    """``[study]``"""

    name: str
    schema_version: Literal[1] = Field(1, alias="schema")
    title: str = ""


class RotorsTable(_Table):
    """``[rotors]``: any of files, list, grid, sobol and random; their rotors follow one another."""

    files: list[str] = Field(default_factory=list)
    rotors: list[dict[str, Any]] = Field(default_factory=list, alias="list")
    grid: GridTable | None = None  # type: ignore[valid-type]
    sobol: SobolTable | None = None  # type: ignore[valid-type]
    random: RandomTable | None = None  # type: ignore[valid-type]


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
    map: bool = False


class OutputTable(_Table):
    """``[output]``: the columns of points that are stored beside those that always are; all if it is left out."""

    columns: Annotated[list[Annotated[str, AfterValidator(store.column_name)]], Field(min_length=1)] = Field(
        default_factory=lambda: [store.EVERY]
    )


class StudyFile(_Table):
    """A study file."""

    study: StudyTable
    rotors: RotorsTable
    axes: AxesTable
    compare: CompareTable = CompareTable()
    output: OutputTable = OutputTable()


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study: its name, its input, its plan, and the columns of points that are stored."""

    name: str
    title: str
    text: str
    plan: Plan
    columns: tuple[str, ...] = store.chosen([store.EVERY])

    def storing(self, columns: Sequence[str]) -> Study:
        """The same study with other columns stored: those named, "*" for all, and those that always are."""
        return replace(self, columns=store.chosen(columns))

    @property
    def id(self) -> str:
        """Hash of everything that decides a number; which of them are stored is another matter."""
        plan, h = self.plan, hashlib.blake2b(digest_size=16)
        options = {"engine": ENGINE, "model": plan.model, "mu_max": plan.mu_max, **plan.physics.as_dict()}
        if plan.map:
            options["map"] = True
        h.update(json.dumps([options, [[int(m), t] for m, t in plan.tolerances]], sort_keys=True).encode())
        h.update(plan.advance_ratio.astype("<f8").tobytes())
        for rotor in plan.rotors:
            h.update(json.dumps([rotor.name, int(rotor.hub), rotor.blades, list(rotor.shape)]).encode())
            for p in PARAMETERS:
                h.update(np.asarray(getattr(rotor, p.name), "<f8").tobytes())
        return h.hexdigest()


def load_study(path: str | Path) -> Study:
    """Read a study file; every problem at once, with its line."""
    path = file_name(path)
    document = read_document(path)
    data = document.validate(StudyFile)
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
        rotors = tuple(_rotors(data.rotors, document))
        mu = data.axes.advance_ratio
        ratios = mu.count if isinstance(mu, Range) else len(mu)
        _check_size(sum(math.prod(rotor.shape) for rotor in rotors), ratios)
        plan = Plan(
            rotors=rotors,
            advance_ratio=np.array(_values(mu)),
            model=model,
            physics=physics,
            tolerances=tuple(tolerances),
            mu_max=compare.mu_max,
            map=compare.map,
        )
    except ConfigError:
        raise
    except InputError as error:
        raise ConfigError(path, [Problem(0, "", str(error))]) from error
    _tell_repeated(plan)
    _tell_given_twice(plan)
    _tell_percent(plan)
    for sentence in dict.fromkeys(filter(None, map(doubtful, plan.rotors))):
        warnings.warn(sentence, FloquetWarning, stacklevel=2)
    return Study(
        name=data.study.name,
        title=data.study.title or data.study.name,
        text=path.read_text(encoding="utf-8"),
        plan=plan,
        columns=store.chosen(data.output.columns),
    )


def _check_size(designs: int, ratios: int = 1) -> None:
    """Refuse what no machine would finish, before memory is taken for it."""
    if designs > MOST_DESIGNS:
        raise InputError(
            f"the study has {designs} designs, and the most is {MOST_DESIGNS}: take fewer values on an axis, "
            "spread points by rotors.sobol instead of a grid, or cut it into several studies and merge them"
        )
    if designs * ratios > MOST_POINTS:
        raise InputError(
            f"the study has {designs} designs at {ratios} advance ratios, {designs * ratios} points, and the most is "
            f"{MOST_POINTS}: take fewer advance ratios or designs, or cut it into several studies"
        )


def _tell_percent(plan: Plan) -> None:
    """A relative error of more than 1 is seldom meant."""
    large = [t for metric, t in plan.tolerances if metric is Metric.RELATIVE and t > 1.0]
    if large:
        warnings.warn(
            f"compare.tolerances has {large[0]:g}, which is {100 * large[0]:g} %: 5 % is 0.05",
            FloquetWarning,
            stacklevel=3,
        )


def _tell_repeated(plan: Plan) -> None:
    """Designs that are equal are computed and stored each, but should be known."""
    found = plan.repeated()
    if not found:
        return
    again, earlier = found[0]
    more = f" and {len(found) - 1} more" if len(found) > 1 else ""
    warnings.warn(
        f"rotor {again} is rotor {earlier}{_called(plan, earlier)} once more{more}: [rotors] gives the same design "
        "twice, and counts and means of rows (--by, --reduce) take it twice; leave it out of one of them",
        FloquetWarning,
        stacklevel=3,
    )


def _tell_given_twice(plan: Plan) -> None:
    """Rows of an advance ratio, or of a tolerance, that is given twice are twice in every count and mean."""
    ratios, count = np.unique(plan.advance_ratio, return_counts=True)
    tolerances = [one for one, often in Counter(plan.tolerances).items() if often > 1]
    relative, absolute = (
        [t for kind, t in tolerances if kind is metric] for metric in (Metric.RELATIVE, Metric.ABSOLUTE)
    )
    for name, again in (
        ("axes.advance_ratio", ratios[count > 1].tolist()),
        ("compare.tolerances", relative),
        ("compare.absolute_tolerances", absolute),
    ):
        if again:
            sentence = f"{name} has {again[0]} twice, and so the rows of every rotor: leave one out"
            warnings.warn(sentence, FloquetWarning, stacklevel=3)


def _called(plan: Plan, design: int) -> str:
    name = plan.design(design).name
    return f" ({name})" if name else ""


def _values(axis: Any) -> list[Any]:
    """The values of an axis in any of its forms."""
    return axis.values() if isinstance(axis, Range) else axis if isinstance(axis, list) else [axis]


def _rotors(table: RotorsTable, document: Document) -> Iterator[Rotor]:
    """The rotors of a study in the order files, list, grid, sobol, random."""
    written = document.data["rotors"]
    if not any(written.get(key) for key in ("files", "list", "grid", *DRAWN)):
        raise InputError(
            "[rotors] is empty: give files = [...], list = [...], grid = {...}, sobol = {...} or random = {...}"
        )
    for file in table.files:
        yield load_rotor(Path(document.path).parent / file)
    for i, values in enumerate(table.rotors):
        with _located(document, "list", i):
            yield _rotor(values)
    # in the order of the file, which decides the order of the rotors
    if written.get("grid"):
        with _located(document, "grid"):
            axes = {name: getattr(table.grid, name) for name in written["grid"]}
            _check_size(math.prod(a.count if isinstance(a, Range) else len(_values(a)) for a in axes.values()))
            yield from _grid({name: _values(axis) for name, axis in axes.items()})
    for kind in DRAWN:
        if written.get(kind):
            with _located(document, kind):
                yield _drawn(kind, {name: getattr(getattr(table, kind), name) for name in written[kind]})


@contextlib.contextmanager
def _located(document: Document, *key: str | int) -> Iterator[None]:
    """What a Rotor finds wrong, with the line of the file."""
    try:
        yield
    except ConfigError:
        raise
    except InputError as error:
        line = document.line("rotors", *key, getattr(error, "name", ""))
        raise ConfigError(document.path, [Problem(line, "", str(error))]) from error


def _rotor(values: Mapping[str, Any]) -> Rotor:
    """A rotor from keys as they are written, hub as a word."""
    fields = dict(values)
    if isinstance(hub := fields.get("hub"), str):
        known = [h.name.lower() for h in Hub]
        if hub.lower() not in known:
            raise InputError(f"hub {hub!r} is neither articulated nor teetering{did_you_mean(hub.lower(), known)}")
        fields["hub"] = Hub[hub.upper()]
    return Rotor(**fields)


def _grid(axes: dict[str, list[Any]]) -> Iterator[Rotor]:
    """The outer product of the axes, the last one fastest; one Rotor a number of blades and hub."""
    outer = {n: axes.pop(n) for n in ("hub", "blades") if n in axes}
    mesh = np.meshgrid(*[np.array(v, float) for v in axes.values()], indexing="ij") if axes else []
    values = {name: m.ravel() for name, m in zip(axes, mesh, strict=True)}
    for chosen in product(*outer.values()):
        yield _rotor(dict(zip(outer, chosen, strict=True)) | values)


def _drawn(kind: str, spec: dict[str, Any]) -> Rotor:
    """Points in a box; the first n of more points are those of n."""
    count, seed = spec.pop("count"), spec.pop("seed", 0)
    fixed = {k: spec.pop(k) for k in ("hub", "blades") if k in spec}
    if not spec:
        raise InputError(f"rotors.{kind}: no parameter varies: give one [low, high], such as lock_number = [4.0, 12.0]")
    unit = DRAWN[kind](np.random.default_rng(seed), count, len(spec))
    return _rotor(fixed | {name: low + (high - low) * unit[:, i] for i, (name, (low, high)) in enumerate(spec.items())})


def _sobol(rng: np.random.Generator, count: int, dimensions: int) -> NDArray[np.float64]:
    """Sobol points of the unit cube, scrambled."""
    from scipy.stats import qmc

    return np.asarray(qmc.Sobol(dimensions, scramble=True, rng=rng).random(count))


def _random(rng: np.random.Generator, count: int, dimensions: int) -> NDArray[np.float64]:
    """Independent points of the unit cube, each drawn whole before the next."""
    return rng.random((count, dimensions))


DRAWN: dict[str, Callable[[np.random.Generator, int, int], NDArray[np.float64]]] = {"sobol": _sobol, "random": _random}
