"""Figure 8. Effect of advance ratio on the TPP modes, κ = 0.225, ε = K₁ = 0."""

from __future__ import annotations

import numpy as np

from floquet import Rotor, lock_windows
from floquet.exhibits import Exhibit
from floquet.families import forward_records, forward_rows
from floquet.plot.loci import forward_loci
from floquet.validity import split_edges

VALUES = {"hinge_stiffness": 0.225}
TITLE = "Figure 8. Effect of advance ratio on the TPP modes, κ = 0.225, ε = K₁ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's κ = 0.225, ε = K₁ = 0; the Lock numbers γ
= 2, 4 … 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical,
and what a TPP curve moves aside is error of the TPP. The restraint gives the flapping frequency of ε = 0.15 but not
its damping, and the locks are others: for γ = 6 and 8 the exact regressing pair locks at 1 per rev, for γ = 14 and 16
regressing and coning lock at ½ per rev. The TPP pair splits at γ = 8 only, and sooner than the exact one."""


def exhibit() -> Exhibit:
    rows = forward_rows(np.linspace(0.0, 0.4, 41), **VALUES)
    table = forward_records(rows, (0.0, 0.1, 0.2, 0.3, 0.4))
    last = {r["lock_number"]: r for r in table if r["advance_ratio"] == 0.4 and r["mode"] == "regressing"}
    numbers = {f"TPP regressing moved up to μ = 0.4, γ = {g:g}": last[g]["moved"] for g in (6.0, 8.0, 10.0)}
    numbers["error of TPP regressing, γ = 8, μ = 0.4"] = last[8.0]["error"]
    for g in (8.0,):
        numbers[f"μ at which TPP regressing splits, γ = {g:g}"] = split_edges(Rotor(lock_number=g, **VALUES), 0.4)[0]
    for g in (6.0, 8.0, 14.0, 16.0):
        enter, _, per_rev = lock_windows(Rotor(lock_number=g, **VALUES), 0.4)[0]
        numbers[f"μ at which Floquet locks at {per_rev:g} per rev, γ = {g:g}"] = enter
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("1", "6"), table=table, numbers=numbers,
        figure=forward_loci(rows, r"$\kappa$ = 0.225, $\varepsilon$ = $K_1$ = 0", enlarged=4),
    )  # fmt: skip
