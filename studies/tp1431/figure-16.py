"""Figure 16. Pitch-flap coupling required for decoupling flapping due to aircraft angular rate at hover."""

import numpy as np

from floquet import Rotor
from floquet.decoupling import decoupling_coupling, uniform_mass_ratio
from floquet.exhibits import Exhibit
from floquet.plot.lines import Line, Panel, lines

GAMMA = np.linspace(2.0, 16.0, 57)
EPSILON = (0.0, 0.05, 0.10, 0.15)


def exhibit() -> Exhibit:
    curves, rows = [], []
    for i, offset in enumerate(EPSILON):
        for style, m in (("solid", 1.5 * offset), ("dashed", float(uniform_mass_ratio(np.array(offset))))):
            rotor = Rotor(lock_number=GAMMA, hinge_offset=offset, offset_mass_ratio=m)
            label = f"ε = {offset:g}" if style == "solid" else ""
            curves.append(Line(x=GAMMA, y=decoupling_coupling(rotor), label=label, colour=i, style=style))
            for gamma in range(2, 17, 2):
                one = Rotor(lock_number=float(gamma), hinge_offset=offset, offset_mass_ratio=m)
                values = {"lock_number": gamma, "hinge_offset": offset, "offset_mass_ratio": m}
                rows.append(values | {"pitch_flap_coupling": decoupling_coupling(one)})
    at = {(r["lock_number"], r["hinge_offset"], r["offset_mass_ratio"]): r["pitch_flap_coupling"] for r in rows}
    return Exhibit(
        title="Figure 16. Pitch-flap coupling required for decoupling flapping due to aircraft angular rate at hover",
        caption="Without hinge restraint, for hinge offsets chosen here. Solid, eq. (25): K₁ = (γ/16)(1 − 8ε/3 + 2ε²)/"
        "(1 + 3ε/2) − (12/γ) ε/(1 − 4ε/3), for the report's e M_β/I_β = 1.5 ε; dashed, eq. (24) for a uniform blade "
        "outboard of the hinge, 1.5 ε/(1 − ε). The curve of ε = 0 is that of figure 15. An offset of 0.15 and a spring "
        "of 0.225 raise the flapping frequency alike, but do not ask for the same coupling.",
        equations=("24", "25"),
        table=rows,
        numbers={
            "K₁ at γ = 8, ε = 0.05": at[8, 0.05, 1.5 * 0.05],
            "K₁ at γ = 8, ε = 0.15": at[8, 0.15, 1.5 * 0.15],
            "K₁ at γ = 8, ε = 0, κ = 0.225 (figure 15)": decoupling_coupling(
                Rotor(lock_number=8.0, hinge_stiffness=0.225)
            ),
        },
        figure=lines(
            [Panel(x="Lock number $\\gamma$", y="required pitch-flap coupling $K_1$ = tan $\\delta_3$", curves=curves,
                   xlim=(2.0, 17.4), every=2.0)],
            styles={"solid": "$eM_\\beta/I_\\beta = 1.5\\,\\varepsilon$ (the report)",
                    "dashed": "$1.5\\,\\varepsilon/(1-\\varepsilon)$ (uniform blade)"},
            footer="No hinge restraint, hover. Steady flapping; no dynamic inflow.",
        ),
    )  # fmt: skip
