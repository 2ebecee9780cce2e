"""Figure 7. Effect of advance ratio on the TPP dynamics, ε = 0.15, κ = K₁ = 0."""

from __future__ import annotations

import numpy as np

from floquet import Rotor, lock_windows
from floquet.exhibits import Exhibit
from floquet.families import forward_records, forward_rows
from floquet.plot.loci import forward_loci
from floquet.validity import split_edges

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
    rows = forward_rows(np.linspace(0.0, 0.4, 41), **VALUES)
    table = forward_records(rows, (0.0, 0.1, 0.2, 0.3, 0.4))
    last = {r["lock_number"]: r for r in table if r["advance_ratio"] == 0.4 and r["mode"] == "regressing"}
    numbers = {f"TPP regressing moved up to μ = 0.4, γ = {g:g}": last[g]["moved"] for g in (8.0, 10.0, 12.0, 14.0)}
    numbers["error of TPP regressing, γ = 8, μ = 0.4"] = last[8.0]["error"]
    for g in (10.0, 12.0, 14.0):
        numbers[f"μ at which TPP regressing splits, γ = {g:g}"] = split_edges(Rotor(lock_number=g, **VALUES), 0.4)[0]
    for g in (10.0, 12.0):
        enter, _, per_rev = lock_windows(Rotor(lock_number=g, **VALUES), 0.4)[0]
        numbers[f"μ at which Floquet locks at {per_rev:g} per rev, γ = {g:g}"] = enter
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("1", "6"), table=table, numbers=numbers,
        figure=forward_loci(rows, r"$\varepsilon$ = 0.15, $\kappa$ = $K_1$ = 0"),
    )  # fmt: skip
