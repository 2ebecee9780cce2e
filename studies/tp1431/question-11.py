"""What do reversed flow, exact integrals, tip loss, cut-out, static moment and damping do to the limits?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from floquet import Rotor, instability_onset
from floquet.exhibits import Exhibit
from floquet.plot.effects import Effects, effects_figure, moved
from floquet.validity import all_limits, locks

from ._rotors import REAL, rotor

ROTORS = (*REAL, "teetering-nominal", "tp1431-fig6", "tp1431-fig7")
OPTIONS = {
    "reversed flow": {"reversed_flow": True},
    "exact integrals": {"exact_offset": True},
    "tip loss 0.97": {"tip_loss": 0.97},
    "root cut-out 0.2": {"root_cutout": 0.2},
    "m = 1.5 ε/(1 − ε)": {"offset_mass_ratio": None},  # after the rotor's ε
    "flap damping 0.1": {"flap_damping": 0.1},
    "kinematic rates": {"kinematic_rates": True},
}
OF_THE_ROTOR = ("root_cutout", "offset_mass_ratio", "flap_damping")
QUANTITIES = {"regressing": "regressing limit", "coning": "coning limit", "advancing": "advancing limit",
              "first_lock": "first lock", "growth": "onset of growth"}  # fmt: skip
NOTE = "Limits at 5 % and locks up to 1, growth up to 3; options in both models."
CAPTION = """Changes of the advance ratio at which a tip-path-plane mode first passes 5 %, at which the exact
exponents lock first and at which they begin to grow, when one option is taken against the default: the report's
equations for the rotor's own file. Articulated rotors without offset have nothing that exact integrals or the static
moment could change, and kinematic rates are in the forcing only. Reversed flow moves no regressing limit by more
than {flow:.3f}, and growth of articulated rotors from {low:.2f} … {high:.2f} to {low_flow:.2f} … {high_flow:.2f}, of
the teetering rotor beyond 3. Tip loss and damping move the regressing limit of the Lynx by {tip:+.3f} and
{damping:+.3f}, the static moment that of ε = 0.15 by {moment:+.3f}. Tip loss, cut-out and damping are chosen here."""


def changed(one: Rotor, given: Mapping[str, Any]) -> tuple[Rotor, dict[str, Any]]:
    """A rotor and the options of its models with one of OPTIONS."""
    values = dict(given)
    if "offset_mass_ratio" in values:
        values["offset_mass_ratio"] = 1.5 * one.hinge_offset / (1.0 - one.hinge_offset)
    own = {name: values.pop(name) for name in OF_THE_ROTOR if name in values}
    return one.replace(**own), values


def row(one: Rotor, option: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Limits, first lock and onset of growth."""
    other, options = changed(one, given)
    found = all_limits(other, **options)
    limits = {mode: limit for (mode, *_), limit in zip(found.wanted, found.limit[0].tolist(), strict=True)}
    windows = locks(other, **options).of(0)
    return {
        "rotor": one.name,
        "option": option,
        **{mode: limits.get(mode, math.nan) for mode in ("regressing", "coning", "advancing")},
        "first_lock": windows[0][0] if windows else math.inf,
        "per_rev": windows[0][2] if windows else math.nan,
        "growth": instability_onset(other, **options),
    }


def rows() -> list[dict[str, Any]]:
    """A record for every rotor and option, the default first."""
    every = {"default": {}, **OPTIONS}
    return [row(rotor(name), option, given) for name in ROTORS for option, given in every.items()]


def exhibit() -> Exhibit:
    table = rows()
    at = {(r["rotor"], r["option"]): r for r in table}
    names = list(dict.fromkeys(r["rotor"] for r in table))
    panels = [Effects(title=title, values=_pairs(at, names, key)) for key, title in QUANTITIES.items()]
    return Exhibit(
        title="What do reversed flow, exact integrals, tip loss, cut-out, static moment and damping do to the limits?",
        caption=CAPTION.format(**_facts(at, names)).replace("\n", " ").replace(" -", " −"),
        equations=("1", "2", "6", "7"),
        table=table,
        numbers=_numbers(at, names),
        figure=effects_figure(panels, note=NOTE),
    )


def _pairs(
    at: Mapping[tuple[str, str], Mapping[str, Any]], names: Sequence[str], key: str
) -> dict[str, dict[str, tuple[float, float]]]:
    """Option → rotor → (before, after), of the rotors that have the quantity."""
    having = [name for name in names if not math.isnan(at[name, "default"][key])]
    return {option: {n: (at[n, "default"][key], at[n, option][key]) for n in having} for option in OPTIONS}


def _facts(at: Mapping[tuple[str, str], Mapping[str, Any]], names: Sequence[str]) -> dict[str, float]:
    """What the caption says."""

    def of(name: str, option: str, key: str = "regressing") -> float:
        return moved(at[name, "default"][key], at[name, option][key])

    flow = [abs(of(n, "reversed flow")) for n in names]
    growth = [[at[n, option]["growth"] for n in names] for option in ("default", "reversed flow")]
    before, after = ([x for n, x in zip(names, some, strict=True) if "teetering" not in n] for some in growth)
    return {
        "flow": max(x for x in flow if math.isfinite(x)),
        "low": min(before), "high": max(before), "low_flow": min(after), "high_flow": max(after),
        "tip": of("Lynx", "tip loss 0.97"), "damping": of("Lynx", "flap damping 0.1"),
        "moment": of("γ = 8, ε = 0.15", "m = 1.5 ε/(1 − ε)"),
    }  # fmt: skip


def _numbers(at: Mapping[tuple[str, str], Mapping[str, Any]], names: Sequence[str]) -> dict[str, float]:
    out = {f"onset of growth, {n}, {o}": at[n, o]["growth"] for n in names for o in ("default", "reversed flow")}
    out |= {f"regressing limit, {n}, {o}": at[n, o]["regressing"] for n in names for o in ("default", *OPTIONS)
            if "teetering" not in n}  # fmt: skip
    keys = list(QUANTITIES)
    same = sum(at[n, "kinematic rates"][k] == at[n, "default"][k] or math.isnan(at[n, "default"][k])
               for n in names for k in keys)  # fmt: skip
    return out | {"quantities that kinematic rates move": float(len(names) * len(keys) - same)}
