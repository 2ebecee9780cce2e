"""Which parameter moves the damping of the regressing mode most?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floquet import Rotor, compare, sensitivities
from floquet.exhibits import Exhibit
from floquet.plot.ranking import Ranking, ranking_figure
from floquet.sensitivity import plane_sensitivities

from ._rotors import REAL, rotor

MU = 0.35
SYMBOLS = {
    "lock_number": "γ", "hinge_offset": "ε", "hinge_stiffness": "κ", "pitch_flap_coupling": "K₁",
    "offset_mass_ratio": "m", "static_moment_ratio": "s", "flap_damping": "C_β", "root_cutout": "cut-out",
    "tip_loss": "tip loss", "advance_ratio": "μ",
}  # fmt: skip
PART = 0.1  # of a parameter that is not 0
STEPS = {"tip_loss": -0.03, "pitch_flap_coupling": 0.05}
STEP = 0.01  # of another parameter that is 0
NOTE = f"At μ = {MU:g}. Rate times step; m moves alone, ε takes m = ε s along, cut-out starts at the hinge."
CAPTION = """Change of the regressing mode's damping, in per cent of it, to first order, at advance ratio 0.35: when
a parameter grows by 10 %, by 0.01 where it is 0 (K₁ by 0.05), and at a tip loss of 3 %. Rates are exact, from left
and right Floquet modes, beside those of the tip-path plane's eigenvalues. Outside locks the exact damping is c₀/2:
of the ten parameters only {movers} move it; spring, coupling and advance ratio do not at all, though the plane of
the Puma has {puma:+.1f} % for 10 % of advance ratio. The Lynx is locked, and of its two dampings the smaller is
shown: there {spring:+.1f} % come of 10 % of hinge spring (plane {spring_plane:+.1f} %). No step is longer than
{reach:.0f} % of the way to the next branch point."""


def step(one: Rotor, name: str) -> float:
    """The change of a parameter that is shown."""
    value = MU if name == "advance_ratio" else 1.0 if name == "tip_loss" else float(getattr(one, name))
    return STEPS.get(name, STEP) if name == "tip_loss" or value == 0.0 else PART * value


def rows(name: str) -> list[dict[str, Any]]:
    """A record a parameter, the one that moves the exact damping most first."""
    one = rotor(name)
    exact, plane = sensitivities(one, MU), plane_sensitivities(one, MU)
    mode = compare(one, MU)["regressing"]
    # the pair's first: of two reals the less damped
    i = int(np.argmax(exact.stability.exponents.real))
    j = int(np.argmin(np.abs(plane.stability.exponents - mode.simple[int(np.argmax(mode.simple.real))])))
    damping = -float(exact.stability.exponents[i].real)
    assert exact.reach is not None
    out = []
    for k, parameter in enumerate(exact.parameters):
        h = step(one, parameter)
        rates = [0.0 - float(exact.rates[k, i].real), 0.0 - float(plane.rates[k, j].real)]
        out.append({
            "rotor": one.name, "parameter": parameter, "step": h, "exact_rate": rates[0], "plane_rate": rates[1],
            "exact_percent": 100.0 * rates[0] * h / damping, "plane_percent": 100.0 * rates[1] * h / damping,
            "trusted": bool(exact.trusted[k, i] and plane.trusted[k, j]), "part_of_reach": abs(h) / exact.reach[k],
        })  # fmt: skip
    return sorted(out, key=lambda r: (-round(abs(r["exact_percent"]), 9), -abs(r["plane_percent"])))


def exhibit() -> Exhibit:
    tables = {name: rows(name) for name in REAL}
    panels = [_panel(some) for some in tables.values()]
    table = [row for some in tables.values() for row in some]
    return Exhibit(
        title="Which parameter moves the damping of the regressing mode most?",
        caption=CAPTION.format(**_facts(table)).replace("\n", " ").replace(" -", " −"),
        equations=("1", "6"),
        table=table,
        numbers={f"{r['rotor']}, {_label(r)}, {model}, %": r[f"{model}_percent"]
                 for r in table for model in ("exact", "plane")},
        figure=ranking_figure([panels[:2], panels[2:]], xlabel="change of the damping (%)", note=NOTE),
    )  # fmt: skip


def _panel(some: Sequence[Mapping[str, Any]]) -> Ranking:
    values = {_label(r): (r["exact_percent"], r["plane_percent"], r["trusted"]) for r in some}
    locked = " (locked)" if some[0]["rotor"] == "Lynx" else ""
    return Ranking(title=some[0]["rotor"] + locked, values=values)


def _label(row: Mapping[str, Any]) -> str:
    """``γ +10 %``, ``K₁ +0.05``."""
    name, h = row["parameter"], row["step"]
    if name == "tip_loss":
        return f"tip loss {-100.0 * h:g} %"
    plain = name == "tip_loss" or h == STEPS.get(name, STEP)
    return f"{SYMBOLS[name]} {f'{h:+g}' if plain else f'+{100.0 * PART:g} %'}"


def _facts(table: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """What the caption says."""
    at = {(r["rotor"], r["parameter"]): r for r in table}
    free = [r for r in table if r["rotor"] != "Lynx"]
    moving = {r["parameter"] for r in free if abs(r["exact_percent"]) > 1e-9}
    return {
        "movers": ", ".join(symbol for name, symbol in SYMBOLS.items() if name in moving),
        "puma": at["Puma SA 330", "advance_ratio"]["plane_percent"],
        "spring": at["Lynx", "hinge_stiffness"]["exact_percent"],
        "spring_plane": at["Lynx", "hinge_stiffness"]["plane_percent"],
        "reach": 100.0 * max(r["part_of_reach"] for r in table),
    }
