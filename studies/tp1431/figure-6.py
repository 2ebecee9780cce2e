"""Figure 6. Effect of advance ratio on the TPP modes, ε = κ = K₁ = 0."""

from __future__ import annotations

import numpy as np

from floquet import Rotor, lock_windows
from floquet.exhibits import Exhibit
from floquet.families import forward_records, forward_rows
from floquet.plot.loci import forward_loci
from floquet.validity import split_edges

VALUES: dict[str, float] = {}
TITLE = "Figure 6. Effect of advance ratio on the TPP modes, ε = κ = K₁ = 0"
CAPTION = """Exact Floquet exponents (solid) and eigenvalues of the tip-path plane (TPP, dashed), which alone the
original showed, as the advance ratio μ goes from 0 to 0.4, for the report's ε = κ = K₁ = 0; the Lock numbers γ = 2, 4
… 16 are chosen here. The exact damping is c₀/2 = γ/16 at every μ up to a lock, so exact curves are vertical, and what
a TPP curve moves aside is error of the TPP. For γ < 8 the modes are relatively insensitive to μ, the report says: by
its own size regressing moves by up to 8 %, at γ = 2. For γ = 12, 14 and 16 the exact regressing and coning exponents
lock at ½ per rev; the TPP pairs come near each other and part likewise."""


def exhibit() -> Exhibit:
    rows = forward_rows(np.linspace(0.0, 0.4, 41), **VALUES)
    table = forward_records(rows, (0.0, 0.1, 0.2, 0.3, 0.4))
    last = {r["lock_number"]: r for r in table if r["advance_ratio"] == 0.4 and r["mode"] == "regressing"}
    numbers = {f"TPP regressing moved up to μ = 0.4, γ = {g:g}": last[g]["moved"] for g in (2.0, 8.0)}
    numbers["error of TPP regressing, γ = 8, μ = 0.4"] = last[8.0]["error"]
    for g in (2.0,):
        numbers[f"μ at which TPP regressing splits, γ = {g:g}"] = split_edges(Rotor(lock_number=g, **VALUES), 0.4)[0]
    for g in (2.0, 12.0, 16.0):
        enter, _, per_rev = lock_windows(Rotor(lock_number=g, **VALUES), 0.4)[0]
        numbers[f"μ at which Floquet locks at {per_rev:g} per rev, γ = {g:g}"] = enter
    return Exhibit(
        title=TITLE, caption=CAPTION.replace("\n", " "), equations=("1", "6"), table=table, numbers=numbers,
        figure=forward_loci(rows, r"$\varepsilon$ = $\kappa$ = $K_1$ = 0", enlarged=4),
    )  # fmt: skip
