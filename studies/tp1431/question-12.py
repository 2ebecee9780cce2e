"""How much of the error goes with more harmonics?"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from floquet import Rotor, compare, lock_windows
from floquet.exhibits import Exhibit
from floquet.plot.ranges import Ranges, ranges_figure

from ._rotors import REAL, rotor

ROTORS = (*REAL, "tp1431-fig6", "tp1431-fig7")
BLADES = range(3, 10)
HARMONICS = {1: "3, 4", 2: "5, 6", 3: "7, 8", 4: "9"}  # and the blades whose averaged model has them
TOLERANCES = {"limit_1_percent": 0.01, "limit_5_percent": 0.05, "limit_10_percent": 0.10}
OWN = ("regressing", "coning", "advancing", "differential")
MU = np.linspace(0.0, 1.0, 801)
AT = 0.3
NOTE = "Mark: limit at 5 %, bar: from 1 to 10 %, up to 1."
CAPTION = """Advance ratios at which modes of the averaged model with M harmonics pass 1, 5 and 10 %; N blades allow
M up to (N − 1)/2, and M = 1 is the tip-path plane. A second harmonic takes {two_low:.1f} to {two_high:.1f} % of the
regressing error of these rotors at advance ratio 0.3 away, a third leaves {three:.3f} % of it at most. What is left
is in modes that the plane has not; of these the outermost regressing one fails first, but for the UH-60A of 9
blades, and the model of 9 blades holds as a whole up to {puma:.2f} for the Puma and {eight:.2f} for γ = 8, ε = 0,
whose three modes of the plane hold up to {three_puma:.2f} and {three_eight:.2f} in it. The differential mode of an
even number of blades is the same for any M: no harmonic helps it."""


def rows(one: Rotor) -> list[dict[str, Any]]:
    """A record for every number of blades, harmonics it allows and mode."""
    windows = lock_windows(one)
    mu = np.unique([*MU, *(x for w in windows for x in w[:2] if x < 1.0)])  # errors peak at lock edges
    even = one.replace(blades=4)
    found = {M: _limits(even, M, mu) for M in HARMONICS}
    out = []
    for N in BLADES:
        for M in range(1, (N - 1) // 2 + 1):
            modes = {mode: row for mode, row in found[M].items() if mode != "differential" or N % 2 == 0}
            out += [
                {"rotor": one.name, "blades": N, "harmonics": M, "mode": mode, **row} for mode, row in modes.items()
            ]
    return out


def _limits(one: Rotor, M: int, mu: Any) -> dict[str, dict[str, float]]:
    """Mode → the first μ at every tolerance, and the error at AT."""
    found, at = compare(one, mu, harmonics=M), compare(one, AT, harmonics=M)
    return {
        mode.name: {name: _first(one, M, mode.name, mu, mode.error, x) for name, x in TOLERANCES.items()}
        | {"error_at_0.3": at[mode.name].error}
        for mode in found.modes
    }


def _first(one: Rotor, M: int, mode: str, mu: Any, error: Any, tolerance: float) -> float:
    """The first μ at which the error passes a tolerance, inf if it does not."""
    failing = np.flatnonzero(error > tolerance)
    if not failing.size:
        return math.inf
    low, high = mu[failing[0] - 1 : failing[0] + 1]
    return float(brentq(lambda x: compare(one, x, harmonics=M)[mode].error - tolerance, low, high, xtol=1e-10))


def exhibit() -> Exhibit:
    tables = {name: rows(rotor(name)) for name in ROTORS}
    panels = [_panel(some) for some in tables.values()]
    table = [row for some in tables.values() for row in some]
    return Exhibit(
        title="How much of the error goes with more harmonics?",
        caption=CAPTION.format(**_facts(table)).replace("\n", " "),
        equations=("4", "6", "B5"),
        table=table,
        numbers=_numbers(table),
        figure=ranges_figure([panels[:3], panels[3:]], xlabel="blades whose averaged model it is",
                             ylabel=r"limit in $\mu$", note=NOTE),
    )  # fmt: skip


def _models(some: Sequence[Mapping[str, Any]]) -> dict[int, list[Mapping[str, Any]]]:
    """Harmonics → modes, the differential one included."""
    full = {1: 4, 2: 6, 3: 8, 4: 9}
    return {M: [r for r in some if (r["blades"], r["harmonics"]) == (N, M)] for M, N in full.items()}


def _panel(some: Sequence[Mapping[str, Any]]) -> Ranges:
    values = {}
    for M, modes in _models(some).items():
        limits = {r["mode"]: tuple(r[name] for name in TOLERANCES) for r in modes if r["mode"] in OWN}
        further = [r for r in modes if r["mode"] not in OWN]
        if further:
            limits["further"] = tuple(min(r[name] for r in further) for name in TOLERANCES)
        values[HARMONICS[M]] = limits
    return Ranges(title=some[0]["rotor"], values=values)


def whole(table: Sequence[Mapping[str, Any]], name: str, M: int, N: int) -> float:
    """The first 5 % limit of any mode of a model."""
    return min(r["limit_5_percent"] for r in table if (r["rotor"], r["harmonics"], r["blades"]) == (name, M, N))


def _facts(table: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """What the caption says."""
    error = {(r["rotor"], r["harmonics"]): r["error_at_0.3"] for r in table if r["mode"] == "regressing"}
    names = list(dict.fromkeys(name for name, _ in error))
    left = {M: [100.0 * error[n, M] / error[n, 1] for n in names] for M in (2, 3)}
    nine = {n: [r for r in table if (r["rotor"], r["harmonics"]) == (n, 4)] for n in names}
    three = {n: min(r["limit_5_percent"] for r in some if r["mode"] in OWN) for n, some in nine.items()}
    puma, eight = "Puma SA 330", "γ = 8, ε = 0"
    return {
        "two_low": 100.0 - max(left[2]), "two_high": 100.0 - min(left[2]), "three": max(left[3]),
        "puma": whole(table, puma, 4, 9), "eight": whole(table, eight, 4, 9),
        "three_puma": three[puma], "three_eight": min(three[eight], 1.0),
    }  # fmt: skip


def _numbers(table: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    names = list(dict.fromkeys(r["rotor"] for r in table))
    out = {f"regressing limit at 5 %, {r['rotor']}, M = {r['harmonics']}": r["limit_5_percent"]
           for r in table if r["mode"] == "regressing"}  # fmt: skip
    out |= {f"least limit of any mode at 5 %, {n}, {N} blades, M = {(N - 1) // 2}": whole(table, n, (N - 1) // 2, N)
            for n in names for N in BLADES}  # fmt: skip
    return out
