"""Does the tip-path plane of a teetering rotor fail beyond 0.4, above all without spring and coupling?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from floquet import Hub, Rotor, compare, instability_onset, lock_windows
from floquet.exhibits import Exhibit
from floquet.plot.validity_curves import Curve, Errors, Limits, Series, validity_figure
from floquet.report import intervals_text
from floquet.validity import limits, split_edges

GAMMAS = range(2, 17, 2)
FAMILIES = {"hinge_stiffness": (0.0, 0.1, 0.225), "pitch_flap_coupling": (0.0, -0.2, 0.225, 0.5)}
SYMBOLS = {"hinge_stiffness": r"$\kappa$", "pitch_flap_coupling": "$K_1$"}
LETTERS = {"hinge_stiffness": "κ", "pitch_flap_coupling": "K₁"}
MODES = ("regressing", "advancing")
MU = np.linspace(0.0, 1.0, 401)
NOTE = "Teetering rotor; simple model: the tip-path plane. Parameters not named are 0."
NAMES = {
    "at_04": "largest regressing error up to 0.4",
    "at_06": "largest regressing error up to 0.6",
    "first": "lowest regressing limit",
    "advancing": "lowest advancing limit",
    "worst": "of 8 Lock numbers, largest regressing error up to 0.6 without spring and coupling",
    "lowest": "of 8 Lock numbers, lowest regressing limit without spring and coupling",
}
CAPTION = """Not at 5 % before 0.6 in the regressing mode, and not above all there. After eq. (7) the report expects
the tip-path plane (TPP) of a teetering rotor to deteriorate rapidly beyond 0.4, especially when K₁ = K_β = 0. Above,
errors in that case; below, the advance ratio at which the error first passes 5 %, with springs κ and couplings K₁
chosen here. Of {rotors} rotors the regressing error is {percent_04:.1f} % at most up to 0.4 and {percent_06:.1f} % up
to 0.6; its first limit is at {first:.3f}, that of advancing at {advancing:.3f}. Errors peak where the exact pair
locks at 1 per rev and the TPP splits close by. Of the six springs and couplings, none at all has the largest
regressing error up to 0.6 at {worst:g} of 8 Lock numbers, and the lowest limit at {lowest:g}."""


def rotor(gamma: float, **changed: float) -> Rotor:
    return Rotor(lock_number=gamma, blades=2, hub=Hub.TEETERING, **changed)


def rows(gammas: Iterable[float] = GAMMAS) -> list[dict[str, Any]]:
    """A record for every rotor and mode; the rotors without spring and coupling come once."""
    parameters = {(name if x else "", x): {name: x} for name, values in FAMILIES.items() for x in values}
    return [row for changed in parameters.values() for gamma in gammas for row in _rows(rotor(gamma, **changed))]


def _rows(one: Rotor) -> list[dict[str, Any]]:
    windows, out = lock_windows(one), []
    mu = np.unique([*MU, *split_edges(one), *(x for w in windows for x in w[:2] if x <= 1.0)])  # where errors peak
    errors = compare(one, mu)
    for found in limits(one):
        row = {name: getattr(one, name) for name in ("lock_number", *FAMILIES)} | {"mode": found.mode}
        row |= {f"largest_error_to_{x}": errors[found.mode].error[mu <= x].max().item() for x in (0.4, 0.6, 1.0)}
        row |= {name: getattr(found, name) for name in ("limit", "cause", "rule", "split_edge", "intervals")}
        out.append(row | {"lock_windows": windows})
    return out


def chosen(table: Sequence[Mapping[str, Any]], mode: str, **changed: float) -> list[Mapping[str, Any]]:
    """Rows of a mode with one parameter changed, by Lock number."""
    values = {**dict.fromkeys(FAMILIES, 0.0), **changed, "mode": mode}
    return [row for row in table if all(row[name] == x for name, x in values.items())]


def exhibit() -> Exhibit:
    table = rows()
    facts = _facts(table)
    percent = {"percent_04": 100.0 * facts["at_04"], "percent_06": 100.0 * facts["at_06"]}
    return Exhibit(
        title="Does the tip-path plane of a teetering rotor fail beyond 0.4, above all without spring and coupling?",
        caption=CAPTION.format(rotors=len(table) // len(MODES), **facts, **percent).replace("\n", " "),
        equations=("2", "7"),
        table=[{**row, "intervals": intervals_text(row["intervals"]), "lock_windows": locked(row)} for row in table],
        numbers={NAMES[key]: value for key, value in facts.items()} | _numbers(table),
        figure=validity_figure([_errors(), *([_limits(table, m, n) for n in SYMBOLS] for m in MODES)], note=NOTE),
    )


def _facts(table: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """What the caption says, by the keys of NAMES."""
    regressing, advancing = ([r for r in table if r["mode"] == mode] for mode in MODES)
    same = [[r for r in regressing if r["lock_number"] == gamma] for gamma in GAMMAS]  # the first has neither
    found = {key: max(r[f"largest_error_to_{x}"] for r in regressing) for key, x in (("at_04", 0.4), ("at_06", 0.6))}
    found |= {key: min(r["limit"] for r in some) for key, some in (("first", regressing), ("advancing", advancing))}
    worst = sum(all(r["largest_error_to_0.6"] < rs[0]["largest_error_to_0.6"] for r in rs[1:]) for rs in same)
    return found | {"worst": worst, "lowest": sum(all(r["limit"] > rs[0]["limit"] for r in rs[1:]) for rs in same)}


def _numbers(table: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Errors, locks and growth without spring and coupling; how many limits these move up and down."""
    plain = chosen(table, "regressing")
    points = [(gamma, mu) for gamma in (6, 8) for mu in (0.4, 0.6)]
    out = {f"regressing error, γ = {g}, μ = {x}": compare(rotor(g), x)["regressing"].error for g, x in points}
    out |= {f"locked at 1 per rev from, γ = {r['lock_number']:g}": r["lock_windows"][0][0] for r in plain}
    out |= {f"growth from, γ = {g}": instability_onset(rotor(g)) for g in (2, 6, 16)}
    for name, x in ((name, x) for name, values in FAMILIES.items() for x in values[1:]):
        pairs = [(a["limit"], b["limit"]) for a, b in zip(plain, chosen(table, "regressing", **{name: x}), strict=True)]
        out[f"of 8 regressing limits, raised by {LETTERS[name]} = {x:g}"] = float(sum(b > a for a, b in pairs))
        out[f"of 8 regressing limits, lowered by {LETTERS[name]} = {x:g}"] = float(sum(b < a for a, b in pairs))
    return out


def _errors() -> list[Errors]:
    mu = {g: np.unique([*MU, *split_edges(rotor(g)), lock_windows(rotor(g))[0][0]]) for g in (2, 6, 8, 12, 16)}
    found = {g: compare(rotor(g), x) for g, x in mu.items()}
    curves = {m: [Curve(label=rf"$\gamma$ = {g}", mu=mu[g], error=c[m].error) for g, c in found.items()] for m in MODES}
    return [Errors(title=rf"{mode}, $\kappa$ = $K_1$ = 0", curves=some) for mode, some in curves.items()]


def _limits(table: Sequence[Mapping[str, Any]], mode: str, name: str) -> Limits:
    series = [Series.of(f"{x:g}", chosen(table, mode, **{name: x})) for x in FAMILIES[name]]
    return Limits(title=f"{mode}, by {SYMBOLS[name]}", series=series)


def locked(row: Mapping[str, Any]) -> str:
    """``from 0.6072 at 1``: where, and per rev."""
    return ", ".join(f"{intervals_text([w[:2]])} at {w[2]:g}" for w in row["lock_windows"]) or "nowhere"
