"""Figure 9. Effect of advance ratio on the TPP modes, K₁ = 0.225, ε = κ = 0."""

from __future__ import annotations

import numpy as np

from floquet import Rotor, lock_windows
from floquet.exhibits import Exhibit
from floquet.families import forward_records, forward_rows
from floquet.plot.loci import forward_loci
from floquet.validity import split_edges

VALUES = {"pitch_flap_coupling": 0.225}
TITLE = "Figure 9. Effect of advance ratio on the TPP modes, K₁ = 0.225, ε = κ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's K₁ = 0.225, ε = κ = 0; the Lock numbers γ
= 2, 4 … 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical,
and what a TPP curve moves aside is error of the TPP. The spring of the coupling grows with γ, so that regressing
roots up to γ = 10 start within 0.06 per rev of the real axis: the exact pair locks at 1 per rev for γ = 6 and 8, the
TPP pair splits for these and for 10. At γ = 16 regressing and coning lock at ½ per rev."""


def exhibit() -> Exhibit:
    rows = forward_rows(np.linspace(0.0, 0.4, 41), **VALUES)
    table = forward_records(rows, (0.0, 0.1, 0.2, 0.3, 0.4))
    last = {r["lock_number"]: r for r in table if r["advance_ratio"] == 0.4 and r["mode"] == "regressing"}
    numbers = {f"TPP regressing moved up to μ = 0.4, γ = {g:g}": last[g]["moved"] for g in (6.0, 8.0, 10.0)}
    numbers["error of TPP regressing, γ = 8, μ = 0.4"] = last[8.0]["error"]
    for g in (6.0, 8.0, 10.0):
        numbers[f"μ at which TPP regressing splits, γ = {g:g}"] = split_edges(Rotor(lock_number=g, **VALUES), 0.4)[0]
    for g in (6.0, 8.0, 16.0):
        enter, _, per_rev = lock_windows(Rotor(lock_number=g, **VALUES), 0.4)[0]
        numbers[f"μ at which Floquet locks at {per_rev:g} per rev, γ = {g:g}"] = enter
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("1", "6"), table=table, numbers=numbers,
        figure=forward_loci(rows, r"$K_1$ = 0.225, $\varepsilon$ = $\kappa$ = 0", enlarged=5),
    )  # fmt: skip
