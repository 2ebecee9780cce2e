"""Figure 10. Characteristic roots of the reduced order and of the TPP at hover, by hinge offset."""

from __future__ import annotations

from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, reduced_records, reduced_roots
from floquet.plot.loci import order_loci

from ._orders import order_words

FAMILY = Family(parameter="hinge_offset", values=(0.0, 0.05, 0.10, 0.15))
TITLE = """Figure 10. Comparison of characteristic roots of reduced order and unreduced TPP modes at hover (effect of
hinge offset)"""
CAPTION = """Roots of eq. (11) (dashed), which sets ä to 0, against those of the tip-path plane (TPP, solid) at hover,
by hinge offset; grey lines join what belongs together. Chosen here: ε = 0, 0.05, 0.10, 0.15, with κ = K₁ = 0, and γ =
2, 4 … 16. The error of the low-frequency root is exactly ω_n/√(4 + c₀²), near half its undamped frequency: {low} % at
γ = 2 and {high} % at γ = 8. A larger offset lowers it, except at γ = 2. The reduced order has no advancing mode, and
its coning is one real root −P²/c₀ in place of a pair with the damping c₀/2: {fast} times too fast at γ = 2."""


def exhibit() -> Exhibit:
    table = reduced_records(FAMILY)
    of = {(r["hinge_offset"], r["lock_number"]): r for r in table}
    pairs = [(x, g) for g in (2.0, 8.0, 16.0) for x in (FAMILY.values[0], FAMILY.values[-1])]
    numbers = {f"error of the low-frequency root, γ = {g:g}, ε = {x:g}": of[x, g]["cyclic_error"] for x, g in pairs}
    numbers |= {f"reduced coning root, γ = {g:g}, ε = {x:g}": of[x, g]["coning_reduced"] for x, g in pairs}
    return Exhibit(
        title=TITLE.replace("\n", " "), caption=CAPTION.replace("\n", " ").format(**order_words(table)),
        equations=("9", "10a", "10b", "11"), table=table, numbers=numbers,
        figure=order_loci(FAMILY, carpets(FAMILY, reduced_roots)),
    )  # fmt: skip
