"""Figure 3. Effect of hinge offset and Lock number on the TPP modes at hover."""

from __future__ import annotations

from floquet import Rotor
from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, hover_records, hover_roots
from floquet.models.hover import hover_coefficients
from floquet.plot.loci import hover_loci

FAMILY = Family(parameter="hinge_offset", values=(0.0, 0.05, 0.10, 0.15))
TITLE = "Figure 3. Effect of hinge offset and Lock number on TPP modes at hover"
CAPTION = """Roots of the tip-path plane (TPP) at hover, where it is exact, as curves of constant hinge offset ε with
the Lock number γ marked on them. Chosen here: ε = 0, 0.05, 0.10, 0.15, with κ = K₁ = 0, and γ = 2, 4 … 16. Coning
moves on a circle of radius P about 0, advancing and regressing on the same circle about i; ε widens it and lowers the
damping. For γ ≥ 4 a larger offset lowers the regressing frequency; at γ = 2, 0.15 gives more than 0: there Im η
outweighs the damping that is lost. A disc with offset precesses against the rotation up to a Lock number, given for
0.15, and with it above."""


def exhibit() -> Exhibit:
    table = hover_records(FAMILY)
    slow = {(r["hinge_offset"], r["lock_number"]): r["frequency"] for r in table if r["mode"] == "regressing"}
    numbers = {f"regressing frequency, γ = {g:g}, ε = {e:g}": slow[e, g] for g in (2.0, 12.0) for e in FAMILY.values}
    c0, P2 = hover_coefficients(Rotor(lock_number=1.0, hinge_offset=0.15))
    numbers["Lock number at which the disc does not precess, ε = 0.15"] = 2.0 * float((P2 - 1.0) ** 0.5 / c0)
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("9", "10a", "10b"), table=table, numbers=numbers,
        figure=hover_loci(FAMILY, carpets(FAMILY, hover_roots)),
    )  # fmt: skip
