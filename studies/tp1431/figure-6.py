"""Figure 6. Effect of advance ratio on the TPP modes, ε = κ = K₁ = 0."""

from floquet.exhibits import Exhibit

from ._forward import forward

VALUES: dict[str, float] = {}
TITLE = "Figure 6. Effect of advance ratio on the TPP modes, ε = κ = K₁ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's ε = κ = K₁ = 0; the Lock numbers γ = 2, 4
… 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical, and what
a TPP curve moves aside is error of the TPP. For γ < 8 the modes are relatively insensitive to μ, the report says: by
its own size regressing moves by up to 8 %, at γ = 2. For γ = 12, 14 and 16 the exact regressing and coning exponents
lock at ½ per rev; the TPP pairs come near each other and part likewise."""


def exhibit() -> Exhibit:
    return forward(
        VALUES, moved=(2.0, 8.0), split=(2.0,), locked=(2.0, 12.0, 16.0),
        title=TITLE, caption=CAPTION, heading=r"$\varepsilon$ = $\kappa$ = $K_1$ = 0", enlarged=4,
    )  # fmt: skip
