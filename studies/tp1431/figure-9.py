"""Figure 9. Effect of advance ratio on the TPP modes, K₁ = 0.225, ε = κ = 0."""

from floquet.exhibits import Exhibit

from ._forward import forward

VALUES = {"pitch_flap_coupling": 0.225}
TITLE = "Figure 9. Effect of advance ratio on the TPP modes, K₁ = 0.225, ε = κ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's K₁ = 0.225, ε = κ = 0; the Lock numbers γ
= 2, 4 … 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical,
and what a TPP curve moves aside is error of the TPP. The spring of the coupling grows with γ, so that regressing
roots up to γ = 10 start within 0.06 per rev of the real axis: the exact pair locks at 1 per rev for γ = 6 and 8, the
TPP pair splits for these and for 10. At γ = 16 regressing and coning lock at ½ per rev."""


def exhibit() -> Exhibit:
    return forward(
        VALUES, moved=(6.0, 8.0, 10.0), split=(6.0, 8.0, 10.0), locked=(6.0, 8.0, 16.0),
        title=TITLE, caption=CAPTION, heading=r"$K_1$ = 0.225, $\varepsilon$ = $\kappa$ = 0", enlarged=5,
    )  # fmt: skip
