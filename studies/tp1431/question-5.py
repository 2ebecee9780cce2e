"""How far is the steady response of the tip-path plane, eq. (12), from that of the periodic equations?"""

import numpy as np

from floquet import Rotor, averaged, flapping, tip_path_plane
from floquet.exhibits import Exhibit
from floquet.models import FORCING
from floquet.plot.lines import Line, Panel, lines
from floquet.response import periodic_response, tip_path_plane_gains

ROTOR = Rotor(lock_number=8.0, hinge_offset=0.05)
MU = np.linspace(0.0, 0.5, 51)
INPUTS = {"theta_0": "$\\theta_0$", "A_1c": "$A_{1c}$", "B_1c": "$B_{1c}$", "lambda": "$\\lambda$", "p_w": "$p$",
          "q_w": "$q$"}  # fmt: skip
COLUMNS = [FORCING.index(name) for name in INPUTS]


def exhibit() -> Exhibit:
    exact = tip_path_plane_gains(flapping(ROTOR, MU))[..., COLUMNS]
    plane = error(tip_path_plane_gains(tip_path_plane(ROTOR, MU))[..., COLUMNS], exact)
    finer = error(tip_path_plane_gains(averaged(ROTOR, MU, 2))[..., COLUMNS], exact)
    second = np.stack([second_harmonic(name) for name in INPUTS], axis=-1)
    rows = [
        {"advance_ratio": float(MU[i]), "input": name, "error_tip_path_plane": plane[i, j],
         "error_averaged_2": finer[i, j], "second_harmonic": second[i, j]}
        for i in range(0, 51, 10)
        for j, name in enumerate(INPUTS)
    ]  # fmt: skip
    curves = [Line(x=MU[1:], y=plane[1:, j], label=letter, colour=j) for j, letter in enumerate(INPUTS.values())]
    curves += [Line(x=MU[1:], y=finer[1:, j], colour=j, style="dashed") for j in range(len(INPUTS))]
    beyond = [Line(x=MU, y=second[:, j], label=letter, colour=j) for j, letter in enumerate(INPUTS.values())]
    return Exhibit(
        title="How far is the steady response of the tip-path plane, eq. (12), from that of the periodic "
        "equations?",
        caption="Steady (a₀, a₁, b₁) per unit of each input, for γ = 8, ε = 0.05, chosen here: the distance of the "
        "tip-path plane's, and of the averaged model's with two harmonics, from the harmonics of the exact periodic "
        "response, over the size of the latter. Eqs. (13a–c) are exact at hover; the error grows with μ² for cyclic "
        "pitch and body rates, with μ³ for collective pitch and inflow. Right: the second harmonic "
        "of flapping, which the tip-path plane leaves out, over the size of (a₀, a₁, b₁).",
        equations=("12", "13a", "13b", "13c"),
        table=rows,
        numbers={
            "largest error at μ = 0.3": float(plane[30].max()),
            "largest error at μ = 0.4": float(plane[40].max()),
            "largest error at μ = 0.3, two harmonics": float(finer[30].max()),
            "error of B₁c at μ = 0.3": float(plane[30, 2]),
            "second harmonic due to B₁c at μ = 0.3": float(second[30, 2]),
        },
        figure=lines(
            [
                Panel(x="advance ratio $\\mu$", y="error of steady ($a_0$, $a_1$, $b_1$), relative", curves=curves,
                      log=True, xlim=(0.0, 0.56), ylim=(1e-7, 1.0)),
                Panel(x="advance ratio $\\mu$", y="second harmonic over ($a_0$, $a_1$, $b_1$)", curves=beyond,
                      xlim=(0.0, 0.56)),
            ],
            styles={"solid": "tip-path plane", "dashed": "averaged, two harmonics"},
            footer="γ = 8, ε = 0.05. No dynamic inflow; reversed flow left out.",
        ),
    )  # fmt: skip


def error(gains: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """|a − a exact| / |a exact| by input, (μ, inputs)."""
    return np.linalg.norm(gains - exact, axis=-2) / np.linalg.norm(exact, axis=-2)


def second_harmonic(name: str) -> np.ndarray:
    """|c₂| over the length of (a₀, a₁, b₁), (μ,)."""
    found = periodic_response(flapping(ROTOR, MU), {name: 1.0})
    return np.abs(found.harmonics[:, 2, 0]) / np.linalg.norm(found.tip_path_plane, axis=-1)
