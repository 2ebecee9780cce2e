"""Table 3. Tip-path plane equation (restored: the scan has kept little of it)."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquet import PeriodicSystem, Rotor, tip_path_plane
from floquet.exhibits import Exhibit
from floquet.plot.entries import entries_against_mu

from ._entries import BLADE, by_input, in_letters, spelled_out, typeset

ROTOR = Rotor(lock_number=8.0, hinge_offset=0.05, hinge_stiffness=0.1, pitch_flap_coupling=0.2)
MU = 0.3
#: In the letters of one blade's equation; f0, fc1 and fs1 are those of each input.
FORMULAS = {
    ("D", "a_0", "a_0"): "c0",
    ("D", "a_0", "b_1"): "-cs1/2",
    ("D", "a_1", "a_1"): "c0",
    ("D", "a_1", "b_1"): "2",
    ("D", "b_1", "a_0"): "-cs1",
    ("D", "b_1", "a_1"): "-2",
    ("D", "b_1", "b_1"): "c0",
    ("K", "a_0", "a_0"): "k0",
    ("K", "a_0", "a_1"): "(cs1 - kc1)/2",
    ("K", "a_0", "b_1"): "-ks1/2",
    ("K", "a_1", "a_0"): "-kc1",
    ("K", "a_1", "a_1"): "k0 - 1 + kc2/2",
    ("K", "a_1", "b_1"): "c0 + ks2/2",
    ("K", "b_1", "a_0"): "-ks1",
    ("K", "b_1", "a_1"): "-c0 + ks2/2",
    ("K", "b_1", "b_1"): "k0 - 1 - kc2/2",
}
FORCING_ROWS = {"a_0": "f0", "a_1": "-fc1", "b_1": "-fs1"}
#: The entries in the rotor's parameters.
PARAMETERS = {
    ("D", "a_0", "a_0"): "gamma/2*(1/4 - 2*eps/3 + eps**2/2)",
    ("D", "a_0", "b_1"): "-gamma*mu/4*(1/3 - eps + eps**2)",
    ("D", "a_1", "a_1"): "gamma/2*(1/4 - 2*eps/3 + eps**2/2)",
    ("D", "a_1", "b_1"): "2",
    ("D", "b_1", "a_0"): "-gamma*mu/2*(1/3 - eps + eps**2)",
    ("D", "b_1", "a_1"): "-2",
    ("D", "b_1", "b_1"): "gamma/2*(1/4 - 2*eps/3 + eps**2/2)",
    ("K", "a_0", "a_0"): "P2 + gamma*K1*mu**2/8*(1 - eps)**2",
    ("K", "a_0", "a_1"): "-gamma*mu/8*eps*(1 - 2*eps)",
    ("K", "a_0", "b_1"): "-gamma*K1*mu/4*(2/3 - eps)",
    ("K", "a_1", "a_0"): "-gamma*mu/2*(1/3 - eps/2)",
    ("K", "a_1", "a_1"): "P2 - 1 + gamma*K1*mu**2/16*(1 - eps)**2",
    ("K", "a_1", "b_1"): "gamma/2*(1/4 - 2*eps/3 + eps**2/2) + gamma*mu**2/16*(1 - eps)**2",
    ("K", "b_1", "a_0"): "-gamma*K1*mu/2*(2/3 - eps)",
    ("K", "b_1", "a_1"): "-gamma/2*(1/4 - 2*eps/3 + eps**2/2) + gamma*mu**2/16*(1 - eps)**2",
    ("K", "b_1", "b_1"): "P2 - 1 + 3*gamma*K1*mu**2/16*(1 - eps)**2",
    ("f", "a_0", "theta_0"): "gamma/2*(1/4 - eps/3) + gamma*mu**2/8*(1 - eps)**2",
    ("f", "b_1", "theta_0"): "-gamma*mu/2*(2/3 - eps)",
    ("f", "a_1", "A_1c"): "gamma/2*(1/4 - eps/3) + gamma*mu**2/16*(1 - eps)**2",
    ("f", "a_0", "B_1c"): "-gamma*mu/2*(1/3 - eps/2)",
    ("f", "b_1", "B_1c"): "gamma/2*(1/4 - eps/3) + 3*gamma*mu**2/16*(1 - eps)**2",
    ("f", "a_0", "theta_t"): "gamma/2*(1/5 - eps/4) + gamma*mu**2/4*(1/3 - eps/2)",
    ("f", "b_1", "theta_t"): "-gamma*mu/2*(1/2 - 2*eps/3)",
    ("f", "a_0", "lambda"): "gamma/2*(1/3 - eps/2)",
    ("f", "b_1", "lambda"): "-gamma*mu/4*(1 - eps)**2",
    ("f", "a_0", "p_w"): "gamma*mu/8*(2/3 - eps)",
    ("f", "a_1", "p_w"): "-2*(1 + m)",
    ("f", "b_1", "p_w"): "-gamma/2*(1/4 - eps/3)",
    ("f", "a_1", "q_w"): "-gamma/2*(1/4 - eps/3)",
    ("f", "b_1", "q_w"): "2*(1 + m)",
    ("f", "b_1", "pdot_w"): "-1",
    ("f", "a_1", "qdot_w"): "-1",
    ("f", "a_0", "normal_acceleration"): "s",
}
CAPTION = """The equation a'' + D̃ a' + K̃ a = f̃ u of the tip-path plane, a = (a₀, a₁, b₁), primes d/dψ, derived again, as
the copy at hand has kept little of it: in the letters of one blade's equation and in the rotor's parameters, with P²
= 1 + κ + m + (γK₁/8) (1 − 4ε/3). The table's values, and those here, are for the rotor of table 1 (γ = 8, ε = 0.05, κ
= 0.1, K₁ = 0.2, μ = 0.3); the figure has three others, named above it, and shows what forward flight adds to each
entry. Most of it is what the cone does to the plane, of first order in μ: in K̃, −kc1 = {minus_kc1} of a₀ in the
equation of a₁; in that of b₁, −cs1 = {minus_cs1} of a₀' in D̃ and, with pitch-flap coupling, −ks1 = {minus_ks1} of a₀
in K̃. Back from the plane, a₁ enters the equation of a₀ with −γμε(1 − 2ε)/8 = {lift} alone: without hinge offset not
at all, whatever K₁ is. Between a₁ and b₁ all is of second order."""


def records(system: PeriodicSystem) -> list[dict[str, Any]]:
    q, inputs = system.coordinates, system.input_names
    means = {"D": system.damping.mean(), "K": system.stiffness.mean(), "f": system.forcing.mean()}
    out = []
    for (matrix, row, column), written in PARAMETERS.items():
        value = means[matrix][q.index(row), (inputs if matrix == "f" else q).index(column)]
        letters = FORCING_ROWS[row] if matrix == "f" else FORMULAS[matrix, row, column]
        out.append({"matrix": matrix, "row": row, "column": column, "mean": letters, "in_parameters": written,
                    "mean_value": round(float(value), 14)})  # fmt: skip
    return out


def exhibit() -> Exhibit:
    system = tip_path_plane(ROTOR, MU)
    table = records(system)
    value = {(r["matrix"], r["row"], r["column"]): r["mean_value"] for r in table}
    mu = np.linspace(0.0, 0.4, 41)
    shown = {
        r"$\varepsilon$ = $K_1$ = 0": Rotor(lock_number=8.0),
        r"$\varepsilon$ = 0.15": Rotor(lock_number=8.0, hinge_offset=0.15),
        r"$K_1$ = 0.225": Rotor(lock_number=8.0, pitch_flap_coupling=0.225),
    }
    models = {label: tip_path_plane(rotor, mu) for label, rotor in shown.items()}
    planes = {label: (model.damping.mean(), model.stiffness.mean()) for label, model in models.items()}
    letters = {"kc1": -value["K", "a_1", "a_0"], "cs1": -value["D", "b_1", "a_0"], "ks1": -value["K", "b_1", "a_0"]}
    lift = value["K", "a_0", "a_1"]
    said = {f"minus_{name}": typeset(f"{-x:.2f}") for name, x in letters.items()} | {"lift": typeset(f"{lift:.4f}")}
    means = {place: (0, formula, "0", "0") for place, formula in FORMULAS.items()}
    forcing = {place[1:]: formula for place, formula in PARAMETERS.items() if place[0] == "f"}
    return Exhibit(
        title="Table 3. Tip-path plane equation",
        caption=CAPTION.replace("\n", " ").format(**said),
        equations=("5", "6"),
        table=table,
        numbers={**letters, "a1 in the equation of a0": lift, "det K": float(np.linalg.det(system.stiffness.mean()))},
        text="\n\n".join([in_letters(system.coordinates, means, ("D̃", "K̃")), by_input(system.coordinates, forcing),
                         spelled_out({"": BLADE[""]})]),
        figure=entries_against_mu(
            mu, planes, system.coordinates, FORMULAS,
            title=r"Tip-path plane at $\gamma$ = 8, others 0 unless named; nothing of $\kappa$ depends on $\mu$",
        ),
    )  # fmt: skip
