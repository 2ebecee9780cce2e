"""Where in the plane of Lock number and advance ratio does the tip-path plane hold?"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquet import Hub, Rotor, compare
from floquet.comparison import Metric
from floquet.exhibits import Exhibit
from floquet.plot.maps import ErrorMap, validity_maps
from floquet.validity import all_limits, locks

GAMMA, MU = np.linspace(2.0, 16.0, 281), np.linspace(0.0, 1.0, 401)
LISTED = np.arange(2.0, 17.0)
TOLERANCES = (0.01, 0.05, 0.10)
MODES = ("regressing", "coning", "advancing")
CAPTION = """Errors of the tip-path-plane modes relative to the exact exponents, articulated (three or more blades) and
teetering, hinge offset, spring and coupling 0. Colours change at 1, 2, 5, 10 and 20 %, the line is 5 %; hatched, the
exact exponents are locked and split. The regressing mode of the articulated rotor is within 5 % up to 0.3 for Lock
numbers to {low:.1f} and up to 0.4 to {high:.1f}; the teetering rotor's is within 5 % up to {teetering:.2f} for every
Lock number from 2 to 16."""


def exhibit() -> Exhibit:
    articulated, teetering = (_rotor(GAMMA[:, None], hub) for hub in (Hub.ARTICULATED, Hub.TEETERING))
    maps = [_map(articulated, mode, f"articulated, {mode}") for mode in MODES]
    maps.append(_map(teetering, "regressing", "teetering, regressing"))
    fine = {hub: _limits(_rotor(GAMMA, hub)) for hub in Hub}
    first = fine[Hub.ARTICULATED].limit[:, 0]
    low, high = (float(GAMMA[first >= mu].max()) for mu in (0.3, 0.4))
    least = float(fine[Hub.TEETERING].limit[:, 0].min())
    numbers = {"largest Lock number within 5 % up to 0.3, articulated regressing": low}
    numbers |= {"largest Lock number within 5 % up to 0.4, articulated regressing": high}
    numbers |= {"least limit of the teetering regressing mode": least}
    return Exhibit(
        title="Where in the plane of Lock number and advance ratio does the tip-path plane hold?",
        caption=CAPTION.format(low=low, high=high, teetering=least).replace("\n", " "),
        equations=("1", "2", "6", "7"),
        table=rows(),
        numbers=numbers,
        figure=validity_maps(maps),
    )


def _rotor(gamma: Any, hub: Hub) -> Rotor:
    return Rotor(lock_number=gamma, hub=hub, blades=2 if hub is Hub.TEETERING else 3)


def _map(rotor: Rotor, mode: str, title: str) -> ErrorMap:
    found = compare(rotor, MU, map=True)
    return ErrorMap(
        title=title, lock_number=GAMMA, advance_ratio=MU, errors=found[mode].error, lock=found.stability.lock
    )


def _limits(rotor: Rotor) -> Any:
    return all_limits(rotor, tolerances=[(Metric.RELATIVE, 0.05)], modes=["regressing"])


def rows() -> list[dict[str, Any]]:
    """A record for every whole Lock number, hub and mode: limits at 1, 5 and 10 %, and the first lock."""
    out = []
    for hub in Hub:
        rotor = _rotor(LISTED, hub)
        found = all_limits(rotor, tolerances=[(Metric.RELATIVE, t) for t in TOLERANCES])
        windows = locks(rotor)
        modes = list(dict.fromkeys(mode for mode, _, _ in found.wanted))
        for case, gamma in enumerate(LISTED.tolist()):
            first = windows.of(case)[0] if windows.of(case) else (math.inf, math.inf, math.nan)
            for mode in modes:
                limits = {
                    f"limit_{t:g}": found.limit[case, i].item() for i, (m, _, t) in enumerate(found.wanted) if m == mode
                }
                row = {"lock_number": gamma, "hub": hub.name.lower(), "mode": mode, **limits}
                out.append(row | {"first_lock": first[0], "per_rev": first[2]})
    return out
