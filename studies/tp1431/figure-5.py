"""Figure 5. Effect of pitch-flap coupling and Lock number on the TPP modes at hover."""

from __future__ import annotations

import numpy as np

from floquet.exhibits import Exhibit
from floquet.families import Family, carpets, hover_records, hover_roots
from floquet.plot.loci import hover_loci

FAMILY = Family(parameter="pitch_flap_coupling", values=(-0.2, 0.0, 0.225, 0.5))
TITLE = "Figure 5. Effect of pitch-flap coupling and Lock number on TPP modes at hover"
CAPTION = """Roots of the tip-path plane (TPP) at hover, where it is exact, as curves of constant pitch-flap coupling
K₁ with the Lock number γ marked on them. Chosen here: K₁ = −0.2, 0, 0.225, 0.5, with ε = κ = 0, and γ = 2, 4 … 16; a
positive K₁ lowers the pitch for flap up. The coupling is a spring γ K₁/8 and does not change the damping γ/16. A
negative one softens the blade, which is overdamped above a lower Lock number, given for −0.2: then the cyclic
exponents have Im η = 1 and neither pair regresses. For γ ≤ 6 the regressing frequency varies by less than 9 % with
K₁, and at γ = 2 a K₁ of either sign raises it."""


def exhibit() -> Exhibit:
    table, modes = hover_records(FAMILY), carpets(FAMILY, hover_roots)
    of = {(r["pitch_flap_coupling"], r["lock_number"], r["mode"]): r for r in table}
    numbers = {f"regressing frequency, γ = {g:g}, K₁ = {k:g}": of[k, g, "regressing"]["frequency"]
               for g in (2.0, 12.0) for k in FAMILY.values}  # fmt: skip
    over = np.isfinite(modes["coning, faster"].along[0].real)
    numbers["critical Lock number, K₁ = -0.2"] = float(modes["regressing"].lock_numbers[over].min())
    for name, mode in (("faster", "regressing"), ("slower", "advancing")):
        numbers[f"damping of the {name} cyclic pair, γ = 16, K₁ = -0.2"] = -of[-0.2, 16.0, mode]["exponent_1"].real
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("9", "10a", "10b"), table=table, numbers=numbers,
        figure=hover_loci(FAMILY, modes),
    )  # fmt: skip
