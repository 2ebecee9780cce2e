"""Figure 12. Characteristic roots of the reduced order and of the TPP at hover, by pitch-flap coupling."""

from __future__ import annotations

from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, reduced_records, reduced_roots
from floquet.plot.loci import order_loci

from ._orders import order_words

FAMILY = Family(parameter="pitch_flap_coupling", values=(-0.2, 0.0, 0.225, 0.5))
TITLE = """Figure 12. Comparison of characteristic roots of reduced order and unreduced TPP modes at hover (effect of
pitch-flap coupling)"""
CAPTION = """Roots of eq. (11) (dashed), which sets ä to 0, against those of the tip-path plane (TPP, solid) at hover,
by pitch-flap coupling; grey lines join what belongs together. Chosen here: K₁ = −0.2, 0, 0.225, 0.5, with ε = κ = 0,
and γ = 2, 4 … 16. The error of the low-frequency root is exactly ω_n/√(4 + c₀²), near half its undamped frequency:
{low} % at γ = 2 and {high} % at γ = 8. Above critical damping (K₁ = −0.2, γ = 14 and 16) neither pair of the TPP
regresses, and the reduced root is held against the slower. The reduced order has no advancing mode, and its coning is
one real root −P²/c₀ in place of a pair with the damping c₀/2: {fast} times too fast at γ = 2."""


def exhibit() -> Exhibit:
    table = reduced_records(FAMILY)
    of = {(r["pitch_flap_coupling"], r["lock_number"]): r for r in table}
    pairs = [(x, g) for g in (2.0, 8.0, 16.0) for x in (FAMILY.values[0], FAMILY.values[-1])]
    numbers = {f"error of the low-frequency root, γ = {g:g}, K₁ = {x:g}": of[x, g]["cyclic_error"] for x, g in pairs}
    numbers |= {f"reduced coning root, γ = {g:g}, K₁ = {x:g}": of[x, g]["coning_reduced"] for x, g in pairs}
    return Exhibit(
        title=TITLE.replace("\n", " "), caption=CAPTION.replace("\n", " ").format(**order_words(table)),
        equations=("9", "10a", "10b", "11"), table=table, numbers=numbers,
        figure=order_loci(FAMILY, carpets(FAMILY, reduced_roots)),
    )  # fmt: skip
