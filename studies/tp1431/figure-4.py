"""Figure 4. Effect of hinge restraint and Lock number on the TPP modes at hover."""

from __future__ import annotations

from floquet import Rotor
from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, hover_records, hover_roots
from floquet.models.hover import hover_coefficients
from floquet.plot.loci import hover_loci

FAMILY = Family(parameter="hinge_stiffness", values=(0.0, 0.1, 0.225))
TITLE = "Figure 4. Effect of hinge restraint and Lock number on TPP modes at hover"
CAPTION = """Roots of the tip-path plane (TPP) at hover, where it is exact, as curves of constant hinge restraint κ =
K_β/(I_β Ω²) with the Lock number γ marked on them. Chosen here: κ = 0, 0.1, 0.225, with ε = K₁ = 0, and γ = 2, 4 …
16; 0.225 gives the flapping frequency of ε = 0.15. The restraint does not change the damping, γ/16 for all modes, so
roots of one Lock number stand above each other. The regressing frequency rises with κ at γ = 2 and falls from γ = 8
on: the restraint moves the root down, to the real axis and away from it below. It crosses at γ = 16 √κ, given for
0.225: there the disc does not precess."""


def exhibit() -> Exhibit:
    table = hover_records(FAMILY)
    slow = {(r["hinge_stiffness"], r["lock_number"]): r["frequency"] for r in table if r["mode"] == "regressing"}
    numbers = {f"regressing frequency, γ = {g:g}, κ = {k:g}": slow[k, g] for g in (2.0, 12.0) for k in FAMILY.values}
    c0, P2 = hover_coefficients(Rotor(lock_number=1.0, hinge_stiffness=0.225))
    numbers["Lock number at which the disc does not precess, κ = 0.225"] = 2.0 * float((P2 - 1.0) ** 0.5 / c0)
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("9", "10a", "10b"), table=table, numbers=numbers,
        figure=hover_loci(FAMILY, carpets(FAMILY, hover_roots)),
    )  # fmt: skip
