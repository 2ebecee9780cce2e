"""Table 1. Flapping equation in non-rotating coordinate system, N = 3 (restored: the scan has lost it)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquet import PeriodicSystem, Rotor, flapping, multiblade
from floquet.exhibits import Exhibit
from floquet.models import FORCING
from floquet.plot.entries import entries_over_azimuth

from ._entries import BLADE, entries, harmonics, in_letters, record, spelled_out

ROTOR = Rotor(lock_number=8.0, hinge_offset=0.05, hinge_stiffness=0.1, pitch_flap_coupling=0.2, blades=3)
MU = 0.3
N = 3
#: mean, and the coefficients of cos Nψ and sin Nψ; a row of f holds for every input.
FORMULAS = {
    ("D", "beta_0", "beta_0"): ("c0", "0", "0"),
    ("D", "beta_0", "beta_1s"): ("cs1/2", "0", "0"),
    ("D", "beta_1c", "beta_1c"): ("c0", "0", "cs1/2"),
    ("D", "beta_1c", "beta_1s"): ("2", "-cs1/2", "0"),
    ("D", "beta_1s", "beta_0"): ("cs1", "0", "0"),
    ("D", "beta_1s", "beta_1c"): ("-2", "-cs1/2", "0"),
    ("D", "beta_1s", "beta_1s"): ("c0", "0", "-cs1/2"),
    ("K", "beta_0", "beta_0"): ("k0", "0", "0"),
    ("K", "beta_0", "beta_1c"): ("(kc1 - cs1)/2", "kc2/2", "ks2/2"),
    ("K", "beta_0", "beta_1s"): ("ks1/2", "-ks2/2", "kc2/2"),
    ("K", "beta_1c", "beta_0"): ("kc1", "kc2", "ks2"),
    ("K", "beta_1c", "beta_1c"): ("k0 - 1 + kc2/2", "(cs1 + kc1)/2", "ks1/2"),
    ("K", "beta_1c", "beta_1s"): ("c0 + ks2/2", "-ks1/2", "(cs1 + kc1)/2"),
    ("K", "beta_1s", "beta_0"): ("ks1", "-ks2", "kc2"),
    ("K", "beta_1s", "beta_1c"): ("-c0 + ks2/2", "-ks1/2", "(cs1 + kc1)/2"),
    ("K", "beta_1s", "beta_1s"): ("k0 - 1 - kc2/2", "-(cs1 + kc1)/2", "-ks1/2"),
    ("f", "beta_0"): ("f0", "fc3", "fs3"),
    ("f", "beta_1c"): ("fc1", "fc2", "fs2"),
    ("f", "beta_1s"): ("fs1", "-fs2", "fc2"),
}
CAPTION = """The equation q'' + D q' + K q = f u of three blades, primes d/dψ, derived again, as the copy at hand has
lost it. Letters are those of one blade's equation, β'' + (c0 + cs1 sin ψ) β' + (k0 + kc1 cos ψ + ks1 sin ψ + kc2 cos
2ψ + ks2 sin 2ψ) β = f u, f = f0 + Σ (fcn cos nψ + fsn sin nψ); m is the mass ratio of the hinge offset, s the static
moment ratio. Values are those of a rotor chosen here: γ = 8, ε = 0.05, κ = 0.1, K₁ = 0.2, μ = 0.3. The tip-path plane
keeps the means. What it drops is of first order in μ, largest between the cyclic coordinates: {damping:.2f} in D,
where c0 is {c0:.2f}, and {stiffness:.2f} in K, where k0 is {k0:.2f}."""


def blade_letters(blade: PeriodicSystem) -> list[dict[str, Any]]:
    """What the letters mean: c is the damping's, k the stiffness's, f the forcing's; 0 the mean, c1 … harmonics."""
    matrices, out = {"c": blade.damping, "k": blade.stiffness, "f": blade.forcing}, []
    for column, letter, formula in ((x, letter, f) for x, letters in BLADE.items() for letter, f in letters.items()):
        part, n = "0cs".index(letter[1]), int(letter[-1])
        value = harmonics(matrices[letter[0]], n)[part, 0, FORCING.index(column) if column else 0]
        out.append(record(("blade", letter, column), 0, (formula, "0", "0"), np.array([value, 0.0, 0.0])))
    return out


def exhibit() -> Exhibit:
    system, blade = multiblade(ROTOR, MU), flapping(ROTOR, MU)
    letters = blade_letters(blade)
    table = entries(system, {place: (N, *told) for place, told in FORMULAS.items()}, N)
    size = {x: max(math.hypot(r["cosine_value"], r["sine_value"]) for r in table if r["matrix"] == x) for x in "DK"}
    values = {r["row"]: r["mean_value"] for r in letters}
    return Exhibit(
        title="Table 1. Flapping equation in non-rotating coordinate system, N = 3",
        caption=CAPTION.replace("\n", " ").format(damping=size["D"], stiffness=size["K"], **values),
        equations=("1", "3", "4", "B1", "B2", "B3", "B4", "B5"),
        table=table + letters,
        numbers={"largest periodic term of D": size["D"], "largest periodic term of K": size["K"],
                 "largest periodic term of D over c0": size["D"] / values["c0"],
                 "largest periodic term of K over k0": size["K"] / values["k0"]},
        text=in_letters(system.coordinates, {place: (N, *told) for place, told in FORMULAS.items()})
        + "\n\n" + spelled_out(BLADE),
        figure=entries_over_azimuth(
            system.damping, system.stiffness, system.coordinates, revolution=1 / N,
            title=r"$N$ = 3, $\gamma$ = 8, $\varepsilon$ = 0.05, $\kappa$ = 0.1, $K_1$ = 0.2, $\mu$ = 0.3",
        ),
    )  # fmt: skip
