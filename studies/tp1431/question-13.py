"""Which term is to blame for the error of the tip-path plane?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquet import Rotor, compare
from floquet.comparison import Rule
from floquet.exhibits import Exhibit
from floquet.plot.waterfall import Waterfall, waterfall_figure

from ._rotors import REAL, rotor

MU = 0.35
MODES = ("regressing", "coning")
STEPS = {
    "reversed flow": "reversed flow dropped",
    "integrals": "integrals to ε² only",
    "moment": "m = 1.5 ε",
    "harmonics 2": "harmonics above 2 dropped",
    "harmonics 1": "harmonic 2 dropped",
}
Pair = NDArray[np.complex128]
NOTE = "In % of the exact exponents, step by step downwards: orange adds, blue takes."
CAPTION = """From the exact exponents with all the model has (reversed flow, integrals exact in ε, m of the measured
or a uniform blade) to the report's tip-path plane at advance ratio 0.35, a step a term. A step is the part of its
move along the whole difference of the pair, over the size of the exact exponents, so that steps add up. Of the
aircraft's regressing difference, dropping the second harmonic makes {low:.0f} to {high:.0f} %, reversed flow
{flow_low:+.1f} to {flow_high:+.1f} %; at ε = 0.15 (no aircraft) m = 1.5 ε makes {moment:.0f} %. The order of the
steps matters, as terms interact: over all 60 orders that drop higher harmonics first, the aircraft's shares move by
up to {spread:.1f} points, at ε = 0.15 by {spread_offset:.1f}; the table has the least and the largest. Coning has no
exponent of its own in the Lynx's lock."""


def exact_moment(one: Rotor) -> Rotor:
    """With the static moment that was measured, else that of a uniform blade outboard of the hinge."""
    if one.static_moment_ratio != 1.5:
        return one
    return one.replace(offset_mass_ratio=1.5 * one.hinge_offset / (1.0 - one.hinge_offset))


def values(one: Rotor, done: frozenset[str], mode: str) -> tuple[Pair, Rule]:
    """The pair of a mode after some steps, and what it was held against."""
    other = one.replace(offset_mass_ratio=1.5 * one.hinge_offset) if "moment" in done else exact_moment(one)
    options: dict[str, Any] = {"reversed_flow": "reversed flow" not in done, "exact_offset": "integrals" not in done}
    harmonics = 1 if "harmonics 1" in done else 2 if "harmonics 2" in done else 0
    found = compare(other, MU, harmonics=max(harmonics, 1), **options)[mode]
    return (found.simple if harmonics else found.exact), found.rule


def orders() -> Iterator[tuple[str, ...]]:
    """Orders of the steps in which the higher harmonics go first."""
    return (some for some in permutations(STEPS) if some.index("harmonics 2") < some.index("harmonics 1"))


def shares(known: Mapping[frozenset[str], Pair], order: Sequence[str]) -> dict[str, float]:
    """Parts of the whole difference, which add up to 1."""
    whole = known[frozenset(STEPS)] - known[frozenset()]
    out = {}
    for i, step in enumerate(order):
        move = known[frozenset(order[: i + 1])] - known[frozenset(order[:i])]
        out[step] = float(np.vdot(whole, move).real / np.vdot(whole, whole).real)
    return out


def rows(name: str, mode: str) -> list[dict[str, Any]]:
    """A record a step; none where the mode has no exponent of its own."""
    one = rotor(name)
    reached = {frozenset(order[:i]) for order in orders() for i in range(len(STEPS) + 1)}
    found = {done: values(one, done, mode) for done in reached}
    if any(rule == Rule.MEAN for _, rule in found.values()):
        return []
    known = {done: pair for done, (pair, _) in found.items()}
    size = float(np.sqrt(np.mean(np.abs(known[frozenset()]) ** 2)))
    whole = float(np.sqrt(np.mean(np.abs(known[frozenset(STEPS)] - known[frozenset()]) ** 2))) / size
    every, order = [shares(known, some) for some in orders()], list(STEPS)
    chosen, out = shares(known, order), []
    for i, step in enumerate(order):
        before, after = known[frozenset(order[:i])], known[frozenset(order[: i + 1])]
        out.append({
            "rotor": one.name, "mode": mode, "step": STEPS[step],
            "exponent_before": complex(before[0]), "exponent_after": complex(after[0]),
            "percent": 100.0 * whole * chosen[step], "share": chosen[step],
            "least_share": min(s[step] for s in every), "largest_share": max(s[step] for s in every),
        })  # fmt: skip
    return out


def exhibit() -> Exhibit:
    names = (*REAL, "tp1431-fig7")
    found = {(name, mode): rows(name, mode) for mode in MODES for name in names}
    panels = [[_panel(rotor(name).name, mode, found[name, mode]) for name in names] for mode in MODES]
    table = [row for some in found.values() for row in some]
    return Exhibit(
        title="Which term is to blame for the error of the tip-path plane?",
        caption=CAPTION.format(**_facts(found)).replace("\n", " ").replace(" -", " −"),
        equations=("1", "6"),
        table=table,
        numbers={f"share of the {r['mode']} difference, {r['rotor']}, {r['step']}": r["share"] for r in table},
        figure=waterfall_figure(panels, [*STEPS.values(), "tip-path plane"], xlabel="error (%)", note=NOTE),
    )


def _panel(name: str, mode: str, some: Sequence[Mapping[str, Any]]) -> Waterfall:
    empty = "" if some else "locked:\nno exponent\nof its own"
    return Waterfall(title=f"{name}\n{mode}", steps=[r["percent"] for r in some], empty=empty)


def _facts(found: Mapping[tuple[str, str], Sequence[Mapping[str, Any]]]) -> dict[str, float]:
    """What the caption says, in per cent."""
    by = {(n, m): {r["step"]: r for r in some} for (n, m), some in found.items()}

    def of(step: str) -> list[float]:
        return [100.0 * by[n, "regressing"][STEPS[step]]["share"] for n in REAL]

    def spread(names: Sequence[str]) -> float:
        return max(100.0 * (r["largest_share"] - r["least_share"]) for n in names for r in found[n, "regressing"])

    last, flow = of("harmonics 1"), of("reversed flow")
    return {
        "low": min(last), "high": max(last), "flow_low": min(flow), "flow_high": max(flow),
        "moment": 100.0 * by["tp1431-fig7", "regressing"][STEPS["moment"]]["share"],
        "spread": spread(REAL), "spread_offset": spread(["tp1431-fig7"]),
    }  # fmt: skip
