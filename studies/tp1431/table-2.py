"""Table 2. Flapping equation in non-rotating coordinate system, N = 4 (restored: the scan has lost it)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquet import Rotor, multiblade
from floquet.exhibits import Exhibit
from floquet.plot.entries import entries_over_azimuth

from ._entries import BLADE, entries, harmonics, in_letters, spelled_out

ROTOR = Rotor(lock_number=8.0, hinge_offset=0.05, hinge_stiffness=0.1, pitch_flap_coupling=0.2, blades=4)
MU = 0.3
N = 4
#: The harmonic n, mean, and the coefficients of cos nψ and sin nψ; a row of f holds for every input.
FORMULAS = {
    ("D", "beta_0", "beta_0"): (0, "c0", "0", "0"),
    ("D", "beta_0", "beta_1s"): (0, "cs1/2", "0", "0"),
    ("D", "beta_1c", "beta_1c"): (0, "c0", "0", "0"),
    ("D", "beta_1c", "beta_1s"): (0, "2", "0", "0"),
    ("D", "beta_1c", "beta_d"): (2, "0", "0", "-cs1"),
    ("D", "beta_1s", "beta_0"): (0, "cs1", "0", "0"),
    ("D", "beta_1s", "beta_1c"): (0, "-2", "0", "0"),
    ("D", "beta_1s", "beta_1s"): (0, "c0", "0", "0"),
    ("D", "beta_1s", "beta_d"): (2, "0", "cs1", "0"),
    ("D", "beta_d", "beta_1c"): (2, "0", "0", "-cs1/2"),
    ("D", "beta_d", "beta_1s"): (2, "0", "cs1/2", "0"),
    ("D", "beta_d", "beta_d"): (0, "c0", "0", "0"),
    ("K", "beta_0", "beta_0"): (0, "k0", "0", "0"),
    ("K", "beta_0", "beta_1c"): (0, "(kc1 - cs1)/2", "0", "0"),
    ("K", "beta_0", "beta_1s"): (0, "ks1/2", "0", "0"),
    ("K", "beta_0", "beta_d"): (2, "0", "-kc2", "-ks2"),
    ("K", "beta_1c", "beta_0"): (0, "kc1", "0", "0"),
    ("K", "beta_1c", "beta_1c"): (4, "k0 - 1 + kc2/2", "kc2/2", "ks2/2"),
    ("K", "beta_1c", "beta_1s"): (4, "c0 + ks2/2", "-ks2/2", "kc2/2"),
    ("K", "beta_1c", "beta_d"): (2, "0", "-kc1", "-ks1"),
    ("K", "beta_1s", "beta_0"): (0, "ks1", "0", "0"),
    ("K", "beta_1s", "beta_1c"): (4, "-c0 + ks2/2", "-ks2/2", "kc2/2"),
    ("K", "beta_1s", "beta_1s"): (4, "k0 - 1 - kc2/2", "-kc2/2", "-ks2/2"),
    ("K", "beta_1s", "beta_d"): (2, "0", "ks1", "-kc1"),
    ("K", "beta_d", "beta_0"): (2, "0", "-kc2", "-ks2"),
    ("K", "beta_d", "beta_1c"): (2, "0", "-(cs1 + kc1)/2", "-ks1/2"),
    ("K", "beta_d", "beta_1s"): (2, "0", "ks1/2", "-(cs1 + kc1)/2"),
    ("K", "beta_d", "beta_d"): (0, "k0", "0", "0"),
    ("f", "beta_0"): (0, "f0", "0", "0"),
    ("f", "beta_1c"): (4, "fc1", "fc3", "fs3"),
    ("f", "beta_1s"): (4, "fs1", "-fs3", "fc3"),
    ("f", "beta_d"): (2, "0", "-fc2", "-fs2"),
}
CAPTION = """The equation q'' + D q' + K q = f u of four blades, primes d/dψ, derived again, as the copy at hand has
lost it; β_d is the differential coordinate, (-1)^i on blade i = 1 … 4. Letters are those of one blade's equation,
values those of the rotor of table 1 with a fourth blade. The means of the first three rows and columns are those of
table 1, so the tip-path plane is the same; β_d keeps only its own c0 and k0. Between the first three, periodic terms
are now of second order in μ: {plane:.2f} at most, where three blades have {three:.2f}. Those of first order have
moved to the coupling with β_d at 2 per rev, up to {coupling:.2f}, and as that acts there and back, the error of the
plane's eigenvalues is the same as of three blades."""


def largest(table: list[dict[str, Any]], *, coupling: bool) -> float:
    """The largest periodic term of D and K, of those that act on or through β_d or of the others."""
    some = [r for r in table if r["matrix"] in "DK" and ("beta_d" in (r["row"], r["column"])) is coupling]
    return max(math.hypot(r["cosine_value"], r["sine_value"]) for r in some)


def exhibit() -> Exhibit:
    system = multiblade(ROTOR, MU)
    table = entries(system, FORMULAS, N)
    three = multiblade(ROTOR.replace(blades=3), MU)
    numbers = {
        "largest periodic term within the plane": largest(table, coupling=False),
        "largest periodic term of the coupling with beta_d": largest(table, coupling=True),
        "largest periodic term of three blades": max(
            float(np.hypot(*harmonics(m, 3)[1:]).max()) for m in (three.damping, three.stiffness)
        ),
    }
    plane, coupling, three_blades = numbers.values()
    return Exhibit(
        title="Table 2. Flapping equation in non-rotating coordinate system, N = 4",
        caption=CAPTION.replace("\n", " ").format(plane=plane, coupling=coupling, three=three_blades),
        equations=("1", "3", "4", "B1", "B2", "B3", "B4", "B5"),
        table=table,
        numbers=numbers,
        text=in_letters(system.coordinates, FORMULAS) + "\n\n" + spelled_out(BLADE),
        figure=entries_over_azimuth(
            system.damping, system.stiffness, system.coordinates, revolution=2 / N,
            title=r"$N$ = 4, $\gamma$ = 8, $\varepsilon$ = 0.05, $\kappa$ = 0.1, $K_1$ = 0.2, $\mu$ = 0.3",
        ),
    )  # fmt: skip
