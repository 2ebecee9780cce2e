"""Is the tip-path plane valid up to an advance ratio of 0.3 to 0.4?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from floquet import Rotor, compare, lock_windows
from floquet.comparison import Metric
from floquet.exhibits import Exhibit
from floquet.plot.validity_curves import Limits, Locks, Series, validity_figure
from floquet.report import intervals_text
from floquet.validity import limits

GAMMAS = range(2, 17, 2)
FAMILIES = {
    "hinge_offset": (0.0, 0.05, 0.10, 0.15),
    "hinge_stiffness": (0.0, 0.1, 0.225),
    "pitch_flap_coupling": (0.0, -0.2, 0.225, 0.5),
}
SYMBOLS = {"hinge_offset": r"$\varepsilon$", "hinge_stiffness": r"$\kappa$", "pitch_flap_coupling": "$K_1$"}
MODES = ("regressing", "coning", "advancing")
TOLERANCES = {"limit_at_1_percent": 0.01, "limit": 0.05, "limit_at_10_percent": 0.10}
COLUMNS = ("cause", "rule", "lock", "lock_edge", "split_edge", "intervals")
CAPTION = """The advance ratio at which the error of a tip-path-plane (TPP) mode first passes 5 %, up to 1, with hinge
offset ε, hinge spring κ or coupling K₁ changed, the others 0; values chosen here. Within 5 % up to 0.3, and up to
0.4, are of {rotors} rotors: {counts}. The error is the distance of the eigenvalues over the size of the exact ones,
in the non-rotating frame; in a lock, a mode without an exponent of its own is held against the mean of the locked
pair. Outside locks the exact real part is −c₀/2 at every advance ratio, spring and coupling, so a TPP real part that
drifts there is error. Columns of the table belong to 5 % unless they say otherwise."""


def rows(gammas: Iterable[float] = GAMMAS, families: Mapping[str, Sequence[float]] = FAMILIES) -> list[dict[str, Any]]:
    """A record for every rotor and mode; the rotors without offset, spring and coupling come once."""
    parameters = {(name if x else "", x): {name: x} for name, values in families.items() for x in values}
    rotors = [Rotor(lock_number=gamma, blades=3, **changed) for changed in parameters.values() for gamma in gammas]
    return [row for rotor in rotors for row in _rows(rotor)]


def _rows(rotor: Rotor) -> list[dict[str, Any]]:
    found = limits(rotor, tolerances=[(Metric.RELATIVE, x) for x in TOLERANCES.values()])
    by = {(one.mode, one.tolerance): one for one in found}
    same = {name: getattr(rotor, name) for name in ("lock_number", *FAMILIES)}
    windows = lock_windows(rotor)
    return [
        {**same, "mode": mode, **{name: by[mode, x].limit for name, x in TOLERANCES.items()},
         **{name: getattr(by[mode, 0.05], name) for name in COLUMNS}, "lock_windows": windows}
        for mode in MODES
    ]  # fmt: skip


def chosen(table: Sequence[Mapping[str, Any]], mode: str, **changed: float) -> list[Mapping[str, Any]]:
    """Rows of a mode with one parameter changed, by Lock number."""
    values = {**dict.fromkeys(FAMILIES, 0.0), **changed, "mode": mode}
    return [row for row in table if all(row[name] == x for name, x in values.items())]


def exhibit(gammas: Iterable[float] = GAMMAS) -> Exhibit:
    table = rows(gammas)
    lines = {
        (m, n): [Series.of(f"{x:g}", chosen(table, m, **{n: x})) for x in FAMILIES[n]] for m in MODES for n in SYMBOLS
    }
    panels = [[Limits(title=f"{m}, by {s}", series=lines[m, n]) for n, s in SYMBOLS.items()] for m in MODES]
    locks = [Locks(title=f"locks, by {s}", series=lines["coning", n]) for n, s in SYMBOLS.items()]
    reach = {(m, x): sum(r["limit"] >= x for r in table if r["mode"] == m) for m in MODES for x in (0.3, 0.4)}
    one = compare(Rotor(lock_number=8.0, blades=3), 0.3)["regressing"]
    numbers = {f"rotors whose {mode} limit is at least {x}": float(n) for (mode, x), n in reach.items()}
    numbers |= {f"{m} limit, γ = {r['lock_number']:g}, others 0": r["limit"] for m in MODES for r in chosen(table, m)}
    numbers["TPP regressing damping less the exact one, γ = 8, μ = 0.3"] = float((one.exact - one.simple)[0].real)
    counts = ", ".join(f"{m} {reach[m, 0.3]} and {reach[m, 0.4]}" for m in MODES)
    return Exhibit(
        title="Is the tip-path plane valid up to an advance ratio of 0.3 to 0.4?",
        caption=CAPTION.format(rotors=len(table) // len(MODES), counts=counts).replace("\n", " "),
        equations=("1", "6"),
        table=[{**r, "intervals": intervals_text(r["intervals"]), "lock_windows": locked(r)} for r in table],
        numbers=numbers,
        figure=validity_figure([*panels, locks], note="Simple model: the tip-path plane. Parameters not named are 0."),
    )


def locked(row: Mapping[str, Any]) -> str:
    """``0.2144-0.9599 at 0.5``: where, and per rev."""
    return ", ".join(f"{intervals_text([w[:2]])} at {w[2]:g}" for w in row["lock_windows"]) or "nowhere"
