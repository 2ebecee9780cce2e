"""Figure 13. Reduced and unreduced order after a step in longitudinal cyclic, ε = 0, beside the full equations."""

from floquet import Rotor
from floquet.exhibits import Exhibit

from ._steps import shown

ROTOR = Rotor(lock_number=8.0, blades=4)
TITLE = (
    "Figure 13. Comparison of responses of the reduced and unreduced order to unit step input"
    " in longitudinal cyclic (K₁ = K_β = ε = 0, μ = 0.3, γ = 8)"
)
HEADING = (
    r"Unit step of $B_{1c}$: $\gamma$ = 8, $\varepsilon$ = $\kappa$ = $K_1$ = 0, "
    r"$\mu$ = 0.3, four blades, $\Omega$ = 31.41 rad/s"
)
CAPTION = """Responses from rest to a unit step of longitudinal cyclic pitch without hinge offset, in rad per rad (all
models are linear, so degrees per degree are the same numbers). Chosen here: four blades, one of which is at ψ = 0
when the step comes; 1.2 s, six revolutions; Ω = 31.41 rad/s, which the report uses for its roots. Full equations:
those of four blades, a0 = β₀, a1 = -β₁c, b1 = -β₁s, and in (d) of one blade. The unreduced order (tip-path plane)
follows their plane within {unreduced:.3f}, and the blade, which does more than one harmonic, within {blade:.2f}. The
reduced order, which has no inertia, starts with a jump of its rates and does not oscillate: it misses the overshoot
of a0 and most of the first sideways swing of b1, where it is {reduced:.2f} off. From {close:.2f} s on, a revolution,
it stays within 0.05: it is a model of what takes longer than that. Its longest time constant is {slow:.3f} s, that of
the full equations {exact:.3f} s. All settle at the same values: the simple models are {a_1:.4f} off the mean of the
full equations in a1 and {b_1:.4f} in b1."""


def exhibit() -> Exhibit:
    return shown(ROTOR, title=TITLE, heading=HEADING, caption=CAPTION)
