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
rad (all models are linear, so degrees per degree are the same numbers). Chosen here: four blades, one of which is at
ψ = 0 when the step comes; 1.2 s, six revolutions; Ω = 31.41 rad/s, which the report uses for its roots. Full
equations: those of four blades, a0 = β₀, a1 = -β₁c, b1 = -β₁s, and in (d) of one blade. The unreduced order (tip-path
plane) follows their plane within {unreduced:.3f}, and the blade, which does more than one harmonic, within
{blade:.2f}. With less damping than without offset, coning and the sideways swing ring for three revolutions. Nothing
of that is in the reduced order, which passes through the middle: it is {reduced:.2f} off in b1, and from {close:.2f}
s on, a revolution, it stays within 0.05. Its slow roots are two reals, the slower with a time constant of {slow:.3f}
s, that of the full equations {exact:.3f} s: nearer than without offset. All settle at the same values: the simple
models are {a_1:.4f} off the mean of the full equations in a1 and {b_1:.4f} in b1."""


def exhibit() -> Exhibit:
    return shown(ROTOR, title=TITLE, heading=HEADING, caption=CAPTION)
