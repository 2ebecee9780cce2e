"""Figure 11. Characteristic roots of the reduced order and of the TPP at hover, by hinge restraint."""

from __future__ import annotations

from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, reduced_records, reduced_roots
from floquet.plot.loci import order_loci

from ._orders import order_words

FAMILY = Family(parameter="hinge_stiffness", values=(0.0, 0.1, 0.225))
TITLE = """Figure 11. Comparison of characteristic roots of reduced order and unreduced TPP modes at hover (effect of
hinge restraint)"""
CAPTION = """Roots of eq. (11) (dashed), which sets ä to 0, against those of the tip-path plane (TPP, solid) at hover,
by hinge restraint; grey lines join what belongs together. Chosen here: κ = 0, 0.1, 0.225, with ε = K₁ = 0, and γ = 2,
4 … 16. The error of the low-frequency root is exactly ω_n/√(4 + c₀²), near half its undamped frequency: {low} % at γ
= 2 and {high} % at γ = 8. The restraint raises it at γ = 2 and lowers it from γ = 8 on. The reduced order has no
advancing mode, and its coning is one real root −P²/c₀ in place of a pair with the damping c₀/2: {fast} times too fast
at γ = 2."""


def exhibit() -> Exhibit:
    table = reduced_records(FAMILY)
    of = {(r["hinge_stiffness"], r["lock_number"]): r for r in table}
    pairs = [(x, g) for g in (2.0, 8.0, 16.0) for x in (FAMILY.values[0], FAMILY.values[-1])]
    numbers = {f"error of the low-frequency root, γ = {g:g}, κ = {x:g}": of[x, g]["cyclic_error"] for x, g in pairs}
    numbers |= {f"reduced coning root, γ = {g:g}, κ = {x:g}": of[x, g]["coning_reduced"] for x, g in pairs}
    return Exhibit(
        title=TITLE.replace("\n", " "), caption=CAPTION.replace("\n", " ").format(**order_words(table)),
        equations=("9", "10a", "10b", "11"), table=table, numbers=numbers,
        figure=order_loci(FAMILY, carpets(FAMILY, reduced_roots)),
    )  # fmt: skip
