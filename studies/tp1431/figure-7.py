"""Figure 7. Effect of advance ratio on the TPP dynamics, ε = 0.15, κ = K₁ = 0."""

from floquet.exhibits import Exhibit

from ._forward import forward

VALUES = {"hinge_offset": 0.15}
TITLE = "Figure 7. Effect of advance ratio on the TPP dynamics, ε = 0.15, κ = K₁ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's ε = 0.15, κ = K₁ = 0; the Lock numbers γ
= 2, 4 … 16 are chosen here. The exact damping is c₀/2 at every μ up to a lock, so exact curves are vertical, and what
a TPP curve moves aside is error of the TPP. With a large offset the eigenvalues are almost invariant, the report
says: the advancing ones are, within 2 %, and the coning ones up to γ = 14 within 5 %. The regressing TPP pair becomes
two reals for γ = 10, 12 and 14 and moves by up to 17 %; the exact one does so for γ = 10 and 12 only, locked at 1 per
rev."""


def exhibit() -> Exhibit:
    return forward(
        VALUES, moved=(8.0, 10.0, 12.0, 14.0), split=(10.0, 12.0, 14.0), locked=(10.0, 12.0),
        title=TITLE, caption=CAPTION, heading=r"$\varepsilon$ = 0.15, $\kappa$ = $K_1$ = 0",
    )  # fmt: skip
