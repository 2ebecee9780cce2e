"""Figure 17. Hinge offset required to decouple flapping due to aircraft angular rate at hover."""

import numpy as np

from floquet.decoupling import decoupling_offset, report_mass_ratio, uniform_mass_ratio
from floquet.exhibits import Exhibit
from floquet.plot.lines import Line, Panel, lines

GAMMA = np.linspace(2.0, 16.0, 29)
COUPLING = (-0.2, 0.0, 0.225, 0.5)
LAST = 13.98  # where the curve of K₁ = −0.2 meets ε = 0.3
MASS = {"report": report_mass_ratio, "uniform blade": uniform_mass_ratio}
CAPTION = """The smallest hinge offset that solves eq. (19) without hinge restraint, for pitch-flap couplings chosen
here, with the report's e M_β/I_β = 1.5 ε (solid) and with 1.5 ε/(1 − ε) of a uniform blade (dashed), which needs
less. Curves start from ε = 0 at γ = 16 K₁; where K₁ > γ/16 the blade is too stiff already without offset. The search
ends at ε = 0.3, beyond which the truncated integrals mean nothing: the solid curve of K₁ = −0.2 gets there just below
γ = 14, and the table has no value for it at 14 and 16. For K₁ = 0 the report reads 0.019 at γ = 2 and 0.145 at γ = 8
off its figure, almost on a line; the offset bends towards the axis above γ = 8."""


def exhibit() -> Exhibit:
    curves, rows = [], []
    for i, K1 in enumerate(COUPLING):
        for (name, mass), style in zip(MASS.items(), ("solid", "dashed"), strict=True):
            gammas = np.unique([*GAMMA, max(16.0 * K1, 2.0), LAST])  # curves start from ε = 0 at γ = 16 K₁
            offsets = [decoupling_offset(g, K1, mass_ratio=mass) for g in gammas]
            label = f"$K_1$ = ${K1:g}$" if style == "solid" else ""
            curves.append(Line(x=gammas, y=offsets, label=label, colour=i, style=style))
            for g, offset in zip(gammas, offsets, strict=True):
                if g % 2 == 0:
                    values = {"lock_number": float(g), "pitch_flap_coupling": K1, "mass_ratio": name}
                    rows.append(values | {"hinge_offset": offset})
    at = {(r["lock_number"], r["pitch_flap_coupling"], r["mass_ratio"]): r["hinge_offset"] for r in rows}
    return Exhibit(
        title="Figure 17. Hinge offset required to decouple flapping due to aircraft angular rate at hover",
        caption=CAPTION.replace("\n", " "),
        equations=("19", "24"),
        table=rows,
        numbers={f"ε at γ = {g:g}, K₁ = 0, {name}": at[g, 0.0, name] for name in MASS for g in (2.0, 8.0)},
        figure=lines(
            [Panel(x="Lock number $\\gamma$", y="required hinge offset $\\varepsilon = e/R$", curves=curves,
                   xlim=(2.0, 17.8), ylim=(0.0, 0.31), every=2.0,
                   points=[(2.0, 0.019, "report: .019"), (8.0, 0.145, "report: .145")])],
            styles={"solid": "$eM_\\beta/I_\\beta = 1.5\\,\\varepsilon$ (the report)",
                    "dashed": "$1.5\\,\\varepsilon/(1-\\varepsilon)$ (uniform blade)"},
            footer="No hinge restraint, hover. Steady flapping; no dynamic inflow.",
        ),
    )  # fmt: skip
