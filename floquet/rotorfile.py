"""The format of a rotor file, and physical values made nondimensional.

::

    [rotor]
    name = "Bo 105"             # name, hub, blades, and the numbers of Rotor by their names
    hub = "articulated"         # or "teetering"
    blades = 4
    notes = "free text"         # not kept on the rotor
    pitch_flap_coupling = 0.0

    [rotor.physical]            # instead of the number it determines, each may be given in SI units
    radius = 4.91               # R          [m]
    rotor_speed = 44.4          # Ω          [rad/s]
    flap_inertia = 231.7        # I_β        [kg m²]
    hinge_spring = 113330       # K_β        [N m/rad]    κ = K_β / (I_β Ω²)
    hinge_offset = 0.0          # e          [m]          ε = e / R
    static_moment = 70.8        # M_β        [kg m]       s = R M_β / I_β, then m = ε s = e M_β / I_β
    lock_number = 5.087         # γ          [1]          or air_density ρ [kg/m³], lift_slope a [1/rad] and
                                #                         chord c [m]: γ = ρ a c R⁴ / I_β

    [rotor.sources]             # a sentence for any key given, under the key's name
    radius = "Padfield, Helicopter Flight Dynamics, appendix 4B"

A quantity is given once: a nondimensional value beside the physical one that determines it is an error.  A source for
a key that is not given is an error, except that a file without ``[rotor.physical]`` may keep the sources of the
physical values that its numbers were computed from, which is what ``floquet.rotor.dump_rotor`` writes.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeAlias

import pydantic

from floquet.errors import did_you_mean
from floquet.tomlfile import Table

__all__ = ["PhysicalTable", "RotorFile", "RotorTable", "Values", "nondimensional", "write"]

_Positive: TypeAlias = Annotated[float, pydantic.Field(gt=0)]
_NotNegative: TypeAlias = Annotated[float, pydantic.Field(ge=0)]


class PhysicalTable(Table):
    """``[rotor.physical]``, SI units."""

    radius: _Positive | None = None
    rotor_speed: _Positive | None = None
    flap_inertia: _Positive | None = None
    hinge_spring: _NotNegative | None = None
    hinge_offset: _NotNegative | None = None
    static_moment: _Positive | None = None
    lock_number: _Positive | None = None
    air_density: _Positive | None = None
    lift_slope: _Positive | None = None
    chord: _Positive | None = None


class RotorTable(Table):
    """``[rotor]``; the ranges of its numbers are those of Rotor, which checks them."""

    name: str = ""
    hub: str = "articulated"
    blades: int = 4
    notes: str = ""
    lock_number: float | None = None
    hinge_offset: float | None = None
    hinge_stiffness: float | None = None
    pitch_flap_coupling: float | None = None
    offset_mass_ratio: float | None = None
    static_moment_ratio: float | None = None
    flap_damping: float | None = None
    root_cutout: float | None = None
    rotor_speed: float | None = None
    radius: float | None = None
    physical: PhysicalTable = PhysicalTable()
    sources: dict[str, str] = pydantic.Field(default_factory=dict)


class RotorFile(Table):
    """A rotor file."""

    rotor: RotorTable


@dataclass(frozen=True)
class Values:
    """Arguments of Rotor, the key each came from, and the faults as (key below ``rotor``, sentence)."""

    arguments: dict[str, Any] = field(default_factory=dict)
    origins: dict[str, tuple[str, ...]] = field(default_factory=dict)
    faults: list[tuple[tuple[str, ...], str]] = field(default_factory=list)


_GROUPS: tuple[tuple[str, tuple[str, ...], tuple[str, ...], Callable[..., float]], ...] = (
    ("radius", ("radius",), (), lambda R: R),
    ("rotor_speed", ("rotor_speed",), (), lambda Omega: Omega),
    ("hinge_offset", ("hinge_offset",), ("radius",), lambda e, R: e / R),
    ("hinge_stiffness", ("hinge_spring",), ("flap_inertia", "rotor_speed"), lambda K, I_b, Omega: K / (I_b * Omega**2)),
    ("static_moment_ratio", ("static_moment",), ("radius", "flap_inertia"), lambda M, R, I_b: R * M / I_b),
    ("lock_number", ("lock_number",), (), lambda gamma: gamma),
    (
        "lock_number",
        ("air_density", "lift_slope", "chord"),
        ("radius", "flap_inertia"),
        lambda rho, a, c, R, I_b: rho * a * c * R**4 / I_b,
    ),
)
"""(name in Rotor, physical keys that determine it, others the formula needs, formula of them all in that order)."""


def nondimensional(table: RotorTable) -> Values:
    """Arguments of Rotor from a table, physical values converted; all faults of what is given together."""
    texts = ("notes", "physical", "sources")
    own = {n: getattr(table, n) for n in table.model_fields_set if n not in texts}
    physical = {n: getattr(table.physical, n) for n in table.physical.model_fields_set}
    values = Values(dict(own), {n: (n,) for n in own})
    at_hand = {n: own[n] for n in ("radius", "rotor_speed") if n in own} | physical
    for name, keys, others, formula in _GROUPS:
        given = [key for key in keys if key in physical]
        if given and not _fault(values, name, given, [k for k in (*keys, *others) if k not in at_hand]):
            values.arguments[name] = _compute(formula, [at_hand[k] for k in (*keys, *others)])
            values.origins[name] = ("physical", given[0])
    if "offset_mass_ratio" in own and "static_moment" in physical:
        values.faults.append((("offset_mass_ratio",), _twice("offset_mass_ratio", "static_moment")))
    if "lock_number" not in values.arguments and not any(key[-1] in _LIFT for key, _ in values.faults):
        sentence = (
            "it is missing and has no default; give it in [rotor], or air_density, lift_slope and chord "
            "in [rotor.physical]"
        )
        values.faults.append((("lock_number",), sentence))
    if table.hub.lower() == "teetering" and "blades" not in own:
        values.faults.append((("blades",), "it is missing, and a teetering rotor has two; add blades = 2"))
    _take_sources(values, table, {*own, *physical})
    return values


_LIFT = ("lock_number", "air_density", "lift_slope", "chord")
_ONLY_PHYSICAL = ("flap_inertia", "hinge_spring", "static_moment", "air_density", "lift_slope", "chord")


def _fault(values: Values, name: str, given: list[str], missing: list[str]) -> bool:
    """Note a quantity that is given twice, or a formula that lacks a value."""
    if name in values.arguments:
        values.faults.append((values.origins[name], _twice(values.origins[name][-1], given[0])))
    elif missing:
        lacking = " and ".join(missing)
        sentence = f"{name} cannot be computed from it without {lacking}; add {lacking} to [rotor.physical]"
        values.faults.append((("physical", given[0]), sentence))
    return name in values.arguments or bool(missing)


def _twice(key: str, other: str) -> str:
    return f"it and {other} of [rotor.physical] determine the same quantity ({key}); keep one of the two"


def _compute(formula: Callable[..., float], numbers: list[float]) -> float:
    """nan where the numbers overflow or vanish: Rotor refuses it."""
    try:
        return formula(*numbers)
    except ArithmeticError:
        return math.nan


def _take_sources(values: Values, table: RotorTable, given: set[str]) -> None:
    """Every source belongs to a key of the file."""
    allowed = given if table.physical.model_fields_set else given | set(_ONLY_PHYSICAL)
    values.arguments["sources"] = {name: text for name, text in table.sources.items() if name in allowed}
    for name in table.sources:
        if name not in allowed:
            near = did_you_mean(name, sorted(given)) or ", so give the key or leave the source out"
            values.faults.append((("sources", name), f"a source is given for a key that is not in the file{near}"))


def write(values: Mapping[str, Any], sources: Mapping[str, str]) -> str:
    """The text of a rotor file from Python values; keys with None are left out."""
    lines = ["[rotor]", *(f"{name} = {_toml(value)}" for name, value in values.items() if value is not None)]
    if sources:
        lines += ["", "[rotor.sources]", *(f"{name} = {_toml(text)}" for name, text in sources.items())]
    return "\n".join(lines) + "\n"


def _toml(value: str | int | float) -> str:
    """A text as JSON writes it, but with DEL escaped too; a number as Python writes it, which reads back exactly."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f") if isinstance(value, str) else repr(value)
