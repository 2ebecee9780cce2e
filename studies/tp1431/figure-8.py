"""Figure 8. Effect of advance ratio on the TPP modes, κ = 0.225, ε = K₁ = 0."""

from floquet.exhibits import Exhibit

from ._forward import forward

VALUES = {"hinge_stiffness": 0.225}
TITLE = "Figure 8. Effect of advance ratio on the TPP modes, κ = 0.225, ε = K₁ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's κ = 0.225, ε = K₁ = 0; the Lock numbers γ
= 2, 4 … 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical,
and what a TPP curve moves aside is error of the TPP. The restraint gives the flapping frequency of ε = 0.15 but not
its damping, and the locks are others: for γ = 6 and 8 the exact regressing pair locks at 1 per rev, for γ = 14 and 16
regressing and coning lock at ½ per rev. The TPP pair splits at γ = 8 only, and sooner than the exact one."""


def exhibit() -> Exhibit:
    return forward(
        VALUES, moved=(6.0, 8.0, 10.0), split=(8.0,), locked=(6.0, 8.0, 14.0, 16.0),
        title=TITLE, caption=CAPTION, heading=r"$\kappa$ = 0.225, $\varepsilon$ = $K_1$ = 0", enlarged=4,
    )  # fmt: skip
