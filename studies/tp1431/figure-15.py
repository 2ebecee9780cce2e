"""Figure 15. Pitch-flap coupling required for decoupling flapping due to aircraft angular rate, center-hinged rotor.

The report's caption ends "for center-hinged rotor at hover".
"""

import numpy as np

from floquet import Rotor
from floquet.decoupling import decoupled_rate_response, decoupling_coupling, rates_fed_back
from floquet.exhibits import Exhibit
from floquet.plot.lines import Line, Panel, lines

GAMMA = np.linspace(2.0, 16.0, 57)
KAPPA = (0.0, 0.1, 0.225)
SWAP = np.array([[0.0, 1.0], [1.0, 0.0]])


def exhibit() -> Exhibit:
    required = {k: decoupling_coupling(Rotor(lock_number=GAMMA, hinge_stiffness=k)) for k in KAPPA}
    curves = [Line(x=GAMMA, y=K1, label=f"κ = {k:g}", colour=i) for i, (k, K1) in enumerate(required.items())]
    rows = [row(float(gamma), k) for k in KAPPA for gamma in range(2, 17, 2)]
    return Exhibit(
        title="Figure 15. Pitch-flap coupling required for decoupling flapping due to aircraft angular rate for "
        "center-hinged rotor at hover",
        caption="Eq. (22b): K₁ = γ/16 − 8κ/γ, with hinge restraints κ = K_β/(I_βΩ²) chosen here. With this coupling a "
        "roll rate tilts the tip-path plane sideways only, and a pitch rate fore and aft only, at hover: the cross "
        "response vanishes there, on the periodic equations too, and b₁ per p/Ω and a₁ per q/Ω are both −16/γ, eq. "
        "(23). It comes back in forward flight: the table gives it at advance ratio 0.3, as a share of the direct "
        "response at hover, on the tip-path plane and on the periodic equations.",
        equations=("17", "19", "20", "22a", "22b", "23"),
        table=rows,
        numbers={
            "K₁ at γ = 8, κ = 0": rows[3]["pitch_flap_coupling"],
            "K₁ at γ = 8, κ = 0.225": rows[19]["pitch_flap_coupling"],
            "cross over direct response at μ = 0.3, γ = 8, κ = 0, tip-path plane": rows[3]["cross_tip_path_plane"],
            "cross over direct response at μ = 0.3, γ = 8, κ = 0, periodic": rows[3]["cross_periodic"],
        },
        figure=lines(
            [Panel(x="Lock number $\\gamma$", y="required pitch-flap coupling $K_1$ = tan $\\delta_3$", curves=curves,
                   xlim=(2.0, 17.8), every=2.0)],
            height=4.6,
            footer=r"$\kappa = K_\beta/(I_\beta\Omega^2)$. Hinge offset 0, hover. Steady flapping; no dynamic inflow.",
        ),
    )  # fmt: skip


def row(gamma: float, kappa: float) -> dict[str, float]:
    """The coupling of one rotor, and what is left of the cross response at hover and at μ = 0.3."""
    rotor = Rotor(lock_number=gamma, hinge_stiffness=kappa)
    rotor = rotor.replace(pitch_flap_coupling=decoupling_coupling(rotor))
    hover, forward = (rates_fed_back(rotor, mu, decoupled_rate_response(rotor) * SWAP) for mu in (0.0, 0.3))
    return {
        "lock_number": gamma,
        "hinge_stiffness": kappa,
        "pitch_flap_coupling": rotor.pitch_flap_coupling,
        "cross_hover": float(hover.coupling().max()),
        "cross_tip_path_plane": float(forward.coupling(forward.tip_path_plane).max()),
        "cross_periodic": float(forward.coupling().max()),
    }
