"""Of which order in the advance ratio is the error of the tip-path plane?"""

from __future__ import annotations

from typing import Any

import numpy as np

from floquet import Hub, Rotor, compare
from floquet.exhibits import Exhibit
from floquet.plot.parts import COLOURS
from floquet.plot.validity_curves import Curve, Errors, validity_figure

GAMMAS = range(2, 17, 2)
ORDERS = {
    "articulated": {"regressing": 2, "coning": 4, "advancing": 2},
    "teetering": {"regressing": 4, "advancing": 4},
}
SMALL = np.array([0.005, 0.01])  # errors of 5e-12 or more; rounding is 1e-15
CAPTION = """Relative errors of the tip-path-plane (TPP) eigenvalues at small advance ratios μ, in two logarithms. The
TPP keeps the harmonics −1, 0, 1 of the non-rotating frame. Regressing and advancing stand at the ends and lack the
next neighbour: second order. Coning, in the middle, lacks only neighbours two away: fourth order. A teetering rotor
has no coefficients of one per rev: fourth order. At Lock number 16, critically damped at hover, two exponents meet
and orders are lower: 1 instead of 2 (coning 3 instead of 4), teetering 2 instead of 4. Lock number 14 enters a lock
at μ = 0.0133, too near for a power to show. The table has slopes between μ = 0.005 and 0.01, and coefficients at
0.005."""


def rotor(hub: str, gamma: float) -> Rotor:
    if hub == "teetering":
        return Rotor(lock_number=gamma, blades=2, hub=Hub.TEETERING)
    return Rotor(lock_number=gamma, blades=3)


def rows() -> list[dict[str, Any]]:
    """Slope and coefficient of every mode."""
    out = []
    for hub, modes in ORDERS.items():
        for gamma in GAMMAS:
            errors = {mode: compare(rotor(hub, gamma), SMALL)[mode].error for mode in modes}
            for mode, order in modes.items():
                slope = float(np.log(errors[mode][1] / errors[mode][0]) / np.log(SMALL[1] / SMALL[0]))
                coefficient = float(errors[mode][0] / SMALL[0] ** order)
                row = {"hub": hub, "lock_number": float(gamma), "mode": mode, "order": order}
                out.append({**row, "slope": slope, "coefficient": coefficient})
    return out


def exhibit() -> Exhibit:
    table = rows()
    mu = np.geomspace(0.002, 0.5, 121)
    panels = []
    for hub, modes in ORDERS.items():
        shown = [(8, mode, order) for mode, order in modes.items()]
        shown += [(16, "regressing", modes["regressing"] // 2)]
        curves = [
            Curve(label=rf"{m}, $\gamma$ = {g}, $\propto \mu^{n}$".replace("^1$", "$"), mu=mu, colour=COLOURS[m],
                  error=compare(rotor(hub, g), mu)[m].error, order=n, dashed=g == 16)
            for g, m, n in shown
        ]  # fmt: skip
        panels.append(
            Errors(
                title=f"{hub} rotor",
                curves=curves,
                lowest=1e-13,
                logarithms=True,
                dashed=r"$\gamma$ = 16, critically damped at hover",
            )
        )
    return Exhibit(
        title="Of which order in the advance ratio is the error of the tip-path plane?",
        caption=CAPTION.replace("\n", " "),
        equations=("1", "2", "6", "7"),
        table=table,
        numbers={f"slope, {r['hub']} {r['mode']}, γ = {r['lock_number']:g}": r["slope"]
                 for r in table if r["lock_number"] in (8.0, 16.0)},
        figure=validity_figure([panels], height=3.9),
    )  # fmt: skip
