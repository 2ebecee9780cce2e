"""The tip-path plane's modes against advance ratio beside the exact ones: what figures 6 to 9 share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from floquet import Rotor, lock_windows
from floquet.exhibits import Exhibit
from floquet.families import forward_records, forward_rows
from floquet.plot.loci import forward_loci
from floquet.validity import split_edges

FASTEST = 0.4
MU = np.linspace(0.0, FASTEST, 41)


def forward(
    values: Mapping[str, float], *, moved: Sequence[float], split: Sequence[float], locked: Sequence[float], title: str,
    caption: str, heading: str, enlarged: int = 0,
) -> Exhibit:  # fmt: skip
    """The figure of a parameter set ``values``, with the first ``enlarged`` Lock numbers once more.

    Its numbers are how far the TPP's regressing pair has moved, where it splits, and where the exact pair locks first,
    each for some Lock numbers.
    """
    rows = forward_rows(MU, **values)
    table = forward_records(rows, (0.0, 0.1, 0.2, 0.3, FASTEST))
    last = {r["lock_number"]: r for r in table if r["advance_ratio"] == FASTEST and r["mode"] == "regressing"}
    numbers = {f"TPP regressing moved up to μ = 0.4, γ = {g:g}": last[g]["moved"] for g in moved}
    numbers["error of TPP regressing, γ = 8, μ = 0.4"] = last[8.0]["error"]
    for g in split:
        edges = split_edges(Rotor(lock_number=g, **values), FASTEST)
        numbers[f"μ at which TPP regressing splits, γ = {g:g}"] = edges[0]
    for g in locked:
        enter, _, per_rev = lock_windows(Rotor(lock_number=g, **values), FASTEST)[0]
        numbers[f"μ at which Floquet locks at {per_rev:g} per rev, γ = {g:g}"] = enter
    return Exhibit(
        title=title, caption=caption.replace("\n", " "), equations=("1", "6"), table=table, numbers=numbers,
        figure=forward_loci(rows, heading, enlarged=enlarged),
    )  # fmt: skip
