"""Figure 14. Reduced and unreduced order after a step in longitudinal cyclic, ε = 0.15, beside the full equations."""

from floquet import Rotor
from floquet.exhibits import Exhibit

from ._steps import shown

ROTOR = Rotor(lock_number=8.0, hinge_offset=0.15, blades=4)
TITLE = (
    "Figure 14. Comparison of responses of the reduced and unreduced order TPP dynamics to unit step input"
    " in longitudinal cyclic (K₁ = K_β = 0, ε = 0.15, μ = 0.3, γ = 8)"
)
HEADING = (
    r"Unit step of $B_{1c}$: $\gamma$ = 8, $\varepsilon$ = 0.15, $\kappa$ = $K_1$ = 0, "
    r"$\mu$ = 0.3, four blades, $\Omega$ = 31.41 rad/s"
)
CAPTION = """Responses from rest to a unit step of longitudinal cyclic pitch with a hinge offset of 0.15, in rad per
rad. Chosen here: four blades, one at ψ = 0 when the step comes; Ω = 31.41 rad/s. The unreduced order (tip-path plane)
follows the plane of the full equations within {unreduced:.3f}, and in (d) the blade, with its higher harmonics,
within {blade:.2f}. With less damping than without offset, coning and the sideways swing ring for three revolutions.
The reduced order has no inertia and passes through the middle: it is {reduced:.2f} off in b₁, and from {close:.2f} s
on, {turns:.2f} revolutions, it stays within 0.05. Its longest time constant is {slow:.3f} s, that of the full
equations {exact:.3f} s. All settle near the same values: the simple models are {a_1:.4f} off the mean of the full
equations in a₁ ({share_a_1:.1f} %) and {b_1:.4f} in b₁ ({share_b_1:.1f} %)."""


def exhibit() -> Exhibit:
    return shown(ROTOR, title=TITLE, heading=HEADING, caption=CAPTION)
