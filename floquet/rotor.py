"""The rotor: its parameters, their symbols, units, ranges and sources.

=====================  =====  =======  ==========================================================  =================
name in code           sym.   units    meaning                                                     range
=====================  =====  =======  ==========================================================  =================
lock_number            γ      1        ρ a c R⁴ / I_β                                              > 0
hinge_offset           ε      1        e / R                                                       0 ≤ ε < 1
hinge_stiffness        κ      1        K_β / (I_β Ω²), spring about the flap hinge                 ≥ 0
pitch_flap_coupling    K₁     1        tan δ₃, positive lowers the pitch for flap up               any
offset_mass_ratio      m      1        e M_β / I_β; None = ε s, which is 1.5 ε by default          ≥ 0
static_moment_ratio    s      1        R M_β / I_β; 1.5 is a uniform blade with ε → 0              > 0
flap_damping           c      1        C_β / (I_β Ω), mechanical, adds to the aerodynamic damping  ≥ 0
root_cutout            x_c    1        r_c / R, no lift inboard of it                              0 ≤ x_c < 1
rotor_speed            Ω      rad/s    only for output in Hz and seconds                           > 0
radius                 R      m        only for output in m/s and knots                            > 0
=====================  =====  =======  ==========================================================  =================

with M_β the static moment and I_β the inertia of one blade about its flap hinge. Two derived values are kept apart::

    ν_β² = 1 + κ + m                          (structure only: Rotor.flap_frequency is ν_β)
    P²   = 1 + κ + m + (γ K₁ / 8)(1 − 4ε/3)   (with the aerodynamic spring: Rotor.frequency_ratio_squared)

Source: the list of symbols and Appendix A of NASA TP-1431 (R. T. N. Chen, 1979). There m is always 1.5 ε; here it is
an input of its own, because the exact value of a uniform blade outboard of the hinge is 1.5 ε / (1 − ε).
"""

from __future__ import annotations

import functools
import math
import os
import reprlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from floquet.errors import ConfigError, ParameterError, Problem, did_you_mean

if TYPE_CHECKING:
    from floquet.tomlfile import Document

__all__ = [
    "PARAMETERS",
    "Hub",
    "Parameter",
    "Rotor",
    "Word",
    "doubtful",
    "dump_rotor",
    "load_rotor",
    "plain",
    "require_rotor",
]

Values: TypeAlias = "float | NDArray[np.float64]"
_T = TypeVar("_T")


class Word(IntEnum):
    """A whole number, for arrays, that prints as its name."""

    def __str__(self) -> str:
        return self.name

    def __format__(self, spec: str) -> str:
        return format(self.name if not spec or spec[-1] == "s" else int(self), spec)


class Hub(Word):
    """How the blades are held; ARTICULATED covers hingeless blades by an equivalent hinge and spring."""

    ARTICULATED = 0
    TEETERING = 1


@dataclass(frozen=True)
class Parameter:
    """Name, letter, units and meaning of a number, the range it is good for, and what a value outside usually is."""

    name: str
    symbol: str
    units: str
    description: str
    minimum: float = -math.inf
    exclusive: bool = False
    below: float = math.inf
    hint: str = ""

    @property
    def rule(self) -> str:
        """The range in words: ``"> 0"``, ``">= 0 and < 1"``, ``"any finite number"``."""
        low = f"{'>' if self.exclusive else '>='} {self.minimum:g}" if self.minimum > -math.inf else ""
        high = f"< {self.below:g}" if self.below < math.inf else ""
        return " and ".join(part for part in (low, high) if part) or "any finite number"

    def allows(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of some finite values are in the range."""
        low = values > self.minimum if self.exclusive else values >= self.minimum
        return low & (values < self.below)


PARAMETERS: tuple[Parameter, ...] = (
    Parameter("lock_number", "γ", "1", "Lock number, rho a c R^4 / I_beta", 0.0, True,
              hint="a blade without lift does not flap, so check the sign and the values it was computed from"),
    Parameter("hinge_offset", "ε", "1", "flap hinge offset, e / R", 0.0, below=1.0,
              hint="it is a fraction of the radius, so divide an offset in metres by the radius"),
    Parameter("hinge_stiffness", "κ", "1", "flap hinge spring, K_beta / (I_beta Omega^2)", 0.0,
              hint="a negative spring is not modelled, so check the sign"),
    Parameter("pitch_flap_coupling", "K₁", "1", "pitch-flap coupling, tan delta_3, positive lowers pitch for flap up",
              hint="delta_3 = 90 degrees has no finite tangent"),
    Parameter("offset_mass_ratio", "m", "1", "offset times static moment, e M_beta / I_beta", 0.0,
              hint="leave it out to get hinge_offset * static_moment_ratio"),
    Parameter("static_moment_ratio", "s", "1", "static moment, R M_beta / I_beta", 0.0, True,
              hint="a uniform blade has 1.5, so leave it out unless the static moment is known"),
    Parameter("flap_damping", "c", "1", "mechanical flap damping, C_beta / (I_beta Omega)", 0.0,
              hint="a damper that adds energy is not modelled, so check the sign"),
    Parameter("root_cutout", "x_c", "1", "root cutout, r_c / R", 0.0, below=1.0,
              hint="it is a fraction of the radius, so divide a cutout in metres by the radius"),
)  # fmt: skip
"""The float parameters that may be arrays, in the order of the database's columns."""

_OUTPUT = (
    Parameter("rotor_speed", "Ω", "rad/s", "rotor speed, for output in Hz", 0.0, True,
              hint="give the size of the rotor speed in rad/s, or leave it out"),
    Parameter("radius", "R", "m", "rotor radius, for output in m/s and knots", 0.0, True,
              hint="give the radius in metres, or leave it out"),
)  # fmt: skip
_NAMES = tuple(p.name for p in PARAMETERS)

_PHYSICAL = {
    "flap_inertia": ("hinge_stiffness", "static_moment_ratio", "lock_number"),
    "hinge_spring": ("hinge_stiffness",),
    "static_moment": ("static_moment_ratio",),
    "air_density": ("lock_number",),
    "lift_slope": ("lock_number",),
    "chord": ("lock_number",),
}
"""Physical values of a rotor file that may have a source without being fields of Rotor, and what they determine."""


def _suggesting(cls: type[_T]) -> type[_T]:
    """Turn the TypeError of a misspelt, missing or positional argument into a ParameterError; the signature stays."""
    plain: Callable[..., None] = cls.__init__
    known = [f.name for f in fields(cls)]  # type: ignore[arg-type]

    @functools.wraps(plain)
    def init(self: _T, *args: Any, **values: Any) -> None:
        for name in values:
            if name not in known:
                near = did_you_mean(name, known) or f"; the parameters are {', '.join(known)}"
                raise ParameterError(name, values[name], f"{cls.__name__} has no such parameter{near}")
        if args:
            sentence = f"{cls.__name__} takes every parameter by name, so write {known[0]}={args[0]!r}"
            raise ParameterError(known[0], args[0], sentence)
        if known[0] not in values:
            sentence = f"it is missing and has no default, so give {cls.__name__}({known[0]}=8.0), for example"
            raise ParameterError(known[0], None, sentence)
        plain(self, **values)

    cls.__init__ = init  # type: ignore[assignment]
    return cls


@_suggesting
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Rotor:
    """One rotor, or a batch of rotors whose float parameters are arrays that broadcast together (no outer product).

    The module's table gives symbols, units and ranges. Scalars are kept as Python floats, arrays as read-only float64
    arrays of their own shape (see ``broadcast``). ``offset_mass_ratio=None`` is resolved here to hinge_offset *
    static_moment_ratio, 1.5 ε with the default 1.5; ``replace`` resolves it again. ``blades``, ``hub``, ``rotor_speed``
    and ``radius`` are one value for the batch. A teetering hub needs two blades and ε = m = 0. ``sources`` maps names
    of parameters, or of the physical values they were computed from, to the sentence that says where the value is from.

    >>> Rotor(lock_number=8.0, hinge_offset=0.05).flap_frequency
    1.036822067666386
    """

    lock_number: Values
    hinge_offset: Values = 0.0
    hinge_stiffness: Values = 0.0
    pitch_flap_coupling: Values = 0.0
    blades: int = 4
    hub: Hub = Hub.ARTICULATED
    offset_mass_ratio: Values = None  # type: ignore[assignment]  # None goes in, a number is always there afterwards
    static_moment_ratio: Values = 1.5
    flap_damping: Values = 0.0
    root_cutout: Values = 0.0
    rotor_speed: float | None = None
    radius: float | None = None
    name: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        derived = self.offset_mass_ratio is None
        values, faults = check(vars(self))
        if faults:
            raise faults[0]
        for name, value in values.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_derived", derived)

    @property
    def offset_mass_derived(self) -> bool:
        """Whether ``offset_mass_ratio`` was left out and follows hinge_offset and static_moment_ratio."""
        return bool(vars(self)["_derived"])

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch; () for one rotor."""
        return np.broadcast_shapes(*(np.shape(getattr(self, name)) for name in _NAMES))

    @property
    def flap_frequency(self) -> Values:
        """ν_β = sqrt(1 + κ + m), per rev: the structure alone."""
        return plain(np.sqrt(1.0 + self.hinge_stiffness + self.offset_mass_ratio))

    @property
    def frequency_ratio_squared(self) -> Values:
        """P² = 1 + κ + m + (γ K₁ / 8)(1 − 4ε/3), per rev²: with the aerodynamic spring, truncated."""
        aerodynamic = self.lock_number * self.pitch_flap_coupling / 8.0 * (1.0 - 4.0 * self.hinge_offset / 3.0)
        return plain(1.0 + self.hinge_stiffness + self.offset_mass_ratio + aerodynamic)

    def replace(self, **changes: Any) -> Rotor:
        """A rotor with some fields changed; a derived offset_mass_ratio follows, sources of changed values go."""
        gone = {*changes, *(name for name, made in _PHYSICAL.items() if set(made) <= set(changes))}
        sources = {name: sentence for name, sentence in self.sources.items() if name not in gone}
        return Rotor(**{**self._given(), "sources": sources, **changes})

    def broadcast(self) -> Rotor:
        """The same batch with every float parameter in the batch's full shape (one rotor stays as it is)."""
        return self.mapped(lambda value: np.broadcast_to(value, self.shape)) if self.shape else self

    def __getitem__(self, index: Any) -> Rotor:
        """One case, or some, of the batch, by any NumPy index of its shape; ``rotor[()]`` is the rotor itself."""
        if not self.shape and not (index is ... or (isinstance(index, tuple) and not index)):
            raise ParameterError("index", index, "this is one rotor, and only a rotor with array parameters has cases")
        return self.mapped(lambda value: np.broadcast_to(value, self.shape)[index])

    def mapped(self, change: Callable[[Values], Values]) -> Rotor:
        """This rotor with every float parameter changed alike, to another shape or to some cases; sources stay."""
        values = {n: change(v) for n, v in self._given().items() if n in _NAMES and v is not None}
        return self.replace(sources=self.sources, **values)

    def _given(self) -> dict[str, Any]:
        """The arguments that make this rotor again, a derived offset_mass_ratio as None."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return {**values, "offset_mass_ratio": None} if self.offset_mass_derived else values

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle and copy through the constructor, so that arrays stay read-only in a worker process."""
        return _rebuild, ({**self._given(), "sources": dict(self.sources)},)

    def __repr__(self) -> str:
        values = {"name": self.name, **self._given()}
        shown = {n: v for n, v in values.items() if n != "sources" and _differs(v, _DEFAULTS.get(n))}
        return f"Rotor({', '.join(f'{n}={_short(v)}' for n, v in shown.items())})"


_DEFAULTS: dict[str, Any] = {f.name: f.default for f in fields(Rotor) if f.name not in ("lock_number", "sources")}


def _rebuild(values: dict[str, Any]) -> Rotor:
    return Rotor(**values)


def _differs(value: Any, default: Any) -> bool:
    return isinstance(value, np.ndarray) or value != default


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        ends = f"{value.min():g} to {value.max():g}" if value.size else "empty"
        return f"<{'x'.join(map(str, value.shape))} values, {ends}>"
    return str(value) if isinstance(value, Hub) else f"{value:.6g}" if isinstance(value, float) else repr(value)


def require_rotor(value: Any) -> Rotor:
    """What was given, which must be a Rotor."""
    if isinstance(value, Rotor):
        return value
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        sentence = (
            f"a {type(value).__name__} is no Rotor, and this takes one: dissimilar blades, one Rotor a blade, are for "
            "multiblade and averaged; here ask for each of them alone"
        )
    else:
        sentence = f"{reprlib.repr(value)} is no Rotor: make one with Rotor(lock_number=…) or load_rotor(file)"
    raise ParameterError("rotor", value, sentence)


def doubtful(rotor: Rotor) -> str:
    """What is possible, but seldom meant, in a sentence; or empty."""
    steepest = float(np.abs(rotor.pitch_flap_coupling).max())
    if steepest > STEEP:
        return f"|pitch_flap_coupling| reaches {steepest:g}: it is K₁ = tan δ₃, no angle in degrees (20° are 0.364)"
    tip = (rotor.rotor_speed or 0.0) * (rotor.radius or 0.0)
    if tip > SOUND:
        return f"the tip speed ΩR is {tip:g} m/s, faster than sound: Ω is in rad/s, and 300 rev/min are 31.4"
    return ""


def plain(value: Any) -> Any:
    """Zero-dimensional values as Python numbers, others as they are."""
    return np.asarray(value).item() if np.ndim(value) == 0 else value


# Validation: every value has one function that returns it in its final form or raises ParameterError.


def check(values: Mapping[str, Any]) -> tuple[dict[str, Any], list[ParameterError]]:
    """The fields of a Rotor in their final form, and all that is wrong with them (then the fields are incomplete)."""
    done: dict[str, Any] = {}
    faults: list[ParameterError] = []

    def take(name: str, make: Callable[[], Any]) -> None:
        try:
            done[name] = make()
        except ParameterError as fault:
            faults.append(fault)

    for parameter in PARAMETERS:
        if parameter.name != "offset_mass_ratio" or values[parameter.name] is not None:
            take(parameter.name, functools.partial(_number, parameter, values[parameter.name]))
    for parameter in _OUTPUT:
        take(parameter.name, functools.partial(_scalar, parameter, values[parameter.name]))
    take("blades", lambda: _blades(values["blades"]))
    take("hub", lambda: _hub(values["hub"]))
    take("name", lambda: _text("name", values["name"]))
    take("sources", lambda: _sources(values["sources"]))
    if not faults:
        faults += _together(done)
    return done, faults


def _together(done: dict[str, Any]) -> list[ParameterError]:
    """Rules between fields; resolves ``offset_mass_ratio`` in place."""
    shapes = {n: np.shape(done[n]) for n in _NAMES if n in done and np.ndim(done[n])}
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        given = ", ".join(f"{n} {s}" for n, s in shapes.items())
        name = list(shapes)[-1]
        sentence = (
            f"the shapes of the array parameters do not broadcast together ({given}); arrays are taken case by "
            "case, so give them one shape, or add axes of length 1 for all combinations"
        )
        return [ParameterError(name, shapes[name], sentence)]
    if "offset_mass_ratio" not in done:
        done["offset_mass_ratio"] = _frozen(done["hinge_offset"] * done["static_moment_ratio"])
    return _teetering(done) if done["hub"] is Hub.TEETERING else []


def _teetering(done: Mapping[str, Any]) -> list[ParameterError]:
    faults = []
    if done["blades"] != 2:
        sentence = f"{done['blades']} was given, but a teetering rotor has two, so give blades=2 or hub=Hub.ARTICULATED"
        faults.append(ParameterError("blades", done["blades"], sentence))
    for name in ("hinge_offset", "offset_mass_ratio"):
        if np.any(done[name] != 0.0):
            sentence = (
                f"{_short(done[name])} was given, but the blades of a teetering rotor share one hinge on the shaft "
                "axis, so it must be 0; leave it out or use hub=Hub.ARTICULATED"
            )
            faults.append(ParameterError(name, done[name], sentence))
    return faults


def _number(parameter: Parameter, value: Any) -> Values:
    """A float or a read-only float64 array, finite and in range."""
    try:
        array = np.asarray(value)
    except ValueError:
        sentence = "rows of unequal length were given; an array needs one shape"
        raise ParameterError(parameter.name, value, sentence) from None
    if array.dtype.kind not in "iuf" or np.ma.is_masked(value):
        shown = reprlib.repr(value) if array.ndim == 0 else f"an array of {array.dtype}"
        shown = "an array with masked places" if np.ma.is_masked(value) else shown
        sentence = f"{shown} was given; it must be a real number or an array of them, {parameter.rule}"
        raise ParameterError(parameter.name, value, sentence)
    array = array.astype(np.float64)
    _each(
        parameter, value, array, np.isfinite(array), "a finite number", "look for a missing value or a division by zero"
    )
    _each(parameter, value, array, parameter.allows(array), parameter.rule, parameter.hint)
    return _frozen(array)


def _each(
    parameter: Parameter, value: Any, array: NDArray[np.float64], good: NDArray[np.bool_], rule: str, hint: str
) -> None:
    if not np.all(good):
        sentence = f"{_first(array, ~np.asarray(good))} was given; it must be {rule}: {hint}"
        raise ParameterError(parameter.name, value, sentence)


def _frozen(array: Any) -> Values:
    if np.ndim(array) == 0:
        return float(array)
    array.setflags(write=False)
    return array


def _first(array: NDArray[np.float64], bad: NDArray[np.bool_]) -> str:
    if array.ndim == 0:
        return f"{float(array):g}"
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    return f"{float(array[index]):g} at index {index[0] if len(index) == 1 else index}"


def _scalar(parameter: Parameter, value: Any) -> float | None:
    if value is None:
        return None
    number = _number(parameter, value)
    if np.ndim(number):
        sentence = "an array was given; it is one number for the whole batch, so make one Rotor for each value"
        raise ParameterError(parameter.name, value, sentence)
    return float(number)


STEEP = 2.0  # |tan δ₃| of 63°, which no rotor has
SOUND = 400.0  # m/s, some way above the speed of sound
_MOST_BLADES = 1000  # far beyond any rotor, and it fits the 16 bits that a database gives to it


def _blades(value: Any) -> int:
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        sentence = f"{reprlib.repr(value)} was given; the number of blades is one whole number >= 1, such as 4"
        raise ParameterError("blades", value, sentence)
    if value < 1:
        sentence = f"{value} was given; it must be >= 1, and 1 stands for a single blade's equation"
        raise ParameterError("blades", value, sentence)
    if value > _MOST_BLADES:
        sentence = f"{reprlib.repr(int(value))} was given; it must be <= {_MOST_BLADES}, so look for a slip of the pen"
        raise ParameterError("blades", value, sentence)
    return int(value)


def _hub(value: Any) -> Hub:
    words = {hub.name.lower(): hub for hub in Hub}
    if isinstance(value, str) and value.lower() in words:
        return words[value.lower()]
    if isinstance(value, int | np.integer) and not isinstance(value, bool) and value in tuple(Hub):
        return Hub(int(value))
    near = did_you_mean(value.lower(), words) if isinstance(value, str) else ""
    raise ParameterError("hub", value, f"{value!r} is no hub; it is articulated or teetering{near}")


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise ParameterError(name, value, f"{value!r} was given; it must be a text")
    if "\0" in value or any("\ud800" <= letter <= "\udfff" for letter in value):
        sentence = f"{value!r} was given; it has letters that no database or UTF-8 file can keep, so leave them out"
        raise ParameterError(name, value, sentence)
    return value


def _sources(value: Any) -> Mapping[str, str]:
    if not isinstance(value, Mapping):
        raise ParameterError("sources", value, f"{value!r} was given; it must map names of parameters to sentences")
    known = [f.name for f in fields(Rotor) if f.name != "sources"] + list(_PHYSICAL)
    for name, sentence in value.items():
        if name not in known:
            sentence = f"{name!r} is no parameter of a rotor{did_you_mean(str(name), known)}"
            raise ParameterError("sources", value, sentence)
        _text(f"sources.{name}", sentence)
    return MappingProxyType(dict(value))


# Files: the format is in floquet.rotorfile, which needs pydantic and is loaded when a file is read.


def load_rotor(path: str | os.PathLike[str]) -> Rotor:
    """The rotor in a TOML file; a ConfigError with all problems and their lines if it does not follow the format."""
    from floquet.tomlfile import read_document

    return _from_document(read_document(path))


def dump_rotor(rotor: Rotor) -> str:
    """The text of a file that ``load_rotor`` reads back to the same rotor, nondimensional and with its sources."""
    from floquet.rotorfile import write

    if rotor.shape:
        sentence = f"a batch of shape {rotor.shape} was given, but a file holds one rotor, so choose one: rotor[0]"
        raise ParameterError("rotor", rotor, sentence)
    given = rotor._given()
    first = {"name": rotor.name, "hub": rotor.hub.name.lower(), "blades": rotor.blades}
    return write(first | {n: given[n] for n in (*_NAMES, *(p.name for p in _OUTPUT))}, rotor.sources)


def _from_document(document: Document) -> Rotor:
    from floquet.rotorfile import RotorFile, nondimensional

    if problems := document.problems(RotorFile):
        table = document.data.get("rotor")
        wrong = {problem.key for problem in problems}
        plain = table if isinstance(table, dict) else {}
        given = {n: plain[n] for n in plain if n in _DEFAULTS | {"lock_number": None} and f"rotor.{n}" not in wrong}
        problems += _range_problems(document, {"lock_number": 1.0, **given}, {})
        raise ConfigError(document.path, sorted(problems, key=lambda problem: problem.line))
    values = nondimensional(document.validate(RotorFile).rotor)
    problems = [document.problem(sentence, "rotor", *key) for key, sentence in values.faults]
    problems += _range_problems(document, {"lock_number": 1.0, **values.arguments}, values.origins)
    if problems:
        raise ConfigError(document.path, sorted(problems, key=lambda problem: problem.line))
    return Rotor(**values.arguments)


def _range_problems(
    document: Document, given: Mapping[str, Any], origins: Mapping[str, tuple[str, ...]]
) -> list[Problem]:
    """What ``check`` finds wrong with the values of a file, at the keys they came from."""
    _, faults = check({**_DEFAULTS, "sources": {}, **given})
    known = [fault for fault in faults if fault.name in given]
    return [
        document.problem(_in_a_file(fault, key), "rotor", *key)
        for fault in known
        for key in [origins.get(fault.name, (fault.name,))]
    ]


def _in_a_file(fault: ParameterError, key: tuple[str, ...]) -> str:
    """A fault's sentence as a file would have it; one of a physical value names what it makes."""
    if key[0] == "physical":
        rule = next(p.rule for p in (*PARAMETERS, *_OUTPUT) if p.name == fault.name)
        rule = rule if math.isfinite(fault.value) else "a finite number"
        made = f"it makes {fault.name} {_short(fault.value)}, which must be {rule}"
        return f"{made}: check the values it is computed from and their units"
    return fault.sentence.replace("hub=Hub.ARTICULATED", 'hub = "articulated"').replace("blades=2", "blades = 2")
