"""Table 4. Characteristic roots of the unreduced and the reduced order at μ = 0.3 (reconstructed)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquet import Rotor, compare, tip_path_plane
from floquet.comparison import Rule, eigenvalues
from floquet.exhibits import Exhibit
from floquet.plot.entries import Root, characteristic_roots
from floquet.response import reduced_order

MU = 0.3
OMEGA = 31.41  # rad/s
GAMMAS = range(2, 17, 2)
FAMILIES = {
    r"$\varepsilon$ = 0.15": {"hinge_offset": 0.15},
    r"$\kappa$ = 0.225": {"hinge_stiffness": 0.225},
    r"$K_1$ = 0.225": {"pitch_flap_coupling": 0.225},
}
MODES = ("regressing", "coning", "advancing")
NONE = complex(math.nan, math.nan)
TITLE = r"""$\mu$ = 0.3. Above: $\varepsilon$ = $\kappa$ = $K_1$ = 0.
Below: $\gamma$ = 8; lines: exact to simple."""
CAPTION = """Reconstructed: the roots are lost, so rotors are chosen here, after figures 6 to 12. Eigenvalues of the
tip-path plane (unreduced order, six) and of its reduced order (three), per rev and in rad/s at Ω = 31.41 rad/s,
beside the exact Floquet exponents; a root stands for its conjugate too, two reals are two rows, and in a lock the
mean of the locked two may stand for a mode (exact_is_mean). The reduced order keeps a slow pair for the regressing
mode and one real root, unlike it, in the place of the coning pair. Its slow pair is {reduced} away from the exact
regressing exponents at γ = 8, the unreduced order's {unreduced}. It serves at low Lock numbers ({reduced_2} at γ = 2)
and misleads at high ones ({reduced_16} at γ = 16), where it is damped a third as much as the rotor."""


def reduced_roots(rotor: Rotor) -> dict[str, Any]:
    """The three roots of eq. (11) by mode: the slow pair, and the real root that is left of coning."""
    z = eigenvalues(reduced_order(tip_path_plane(rotor, MU)))
    z = z[np.lexsort((np.abs(z), z.imag == 0.0))]  # a complex pair, then the real one; or three reals, the fastest last
    return {"regressing": z[:2], "coning": np.array([z[2], NONE]), "advancing": np.array([NONE, NONE])}


def records(rotor: Rotor) -> list[dict[str, Any]]:
    """The roots of a rotor by mode."""
    found, reduced = compare(rotor, MU), reduced_roots(rotor)
    parameters = {
        n: getattr(rotor, n) for n in ("lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling")
    }
    out = []
    for mode in MODES:
        one = found[mode]
        models = {"unreduced": one.simple, "reduced": reduced[mode], "exact": one.exact}
        models = {name: z[np.lexsort((-z.real, -z.imag))] for name, z in models.items()}
        two_rows = any(np.all(z.imag == 0.0) for z in models.values())
        for member in range(1 + two_rows):
            roots = {name: complex(z[member]) for name, z in models.items()}
            in_seconds = {f"{name}_rad_s": OMEGA * z for name, z in roots.items()}
            out.append(
                {**parameters, "mode": mode, **roots, "exact_is_mean": bool(one.rule == Rule.MEAN), **in_seconds}
            )
    return out


def away(row: dict[str, Any], model: str) -> float:
    """Distance of a root from the exact one, relative."""
    return abs(row[model] - row["exact"]) / abs(row["exact"])


def roots(label: str, rows: list[dict[str, Any]]) -> list[Root]:
    names = ("mode", "unreduced", "reduced", "exact", "exact_is_mean")
    return [Root(label=label, **{name: row[name] for name in names}) for row in rows]


def exhibit() -> Exhibit:
    series = {f"{gamma}": records(Rotor(lock_number=gamma)) for gamma in GAMMAS}
    families = {label: records(Rotor(lock_number=8.0, **changed)) for label, changed in FAMILIES.items()}
    slow = {label: rows[0] for label, rows in series.items()}
    numbers = {f"{model} order, regressing, from the exact one, γ = {gamma}": away(slow[gamma], f"{model}")
               for gamma in ("2", "8", "16") for model in ("unreduced", "reduced")}  # fmt: skip
    words = {"reduced": f"{100.0 * away(slow['8'], 'reduced'):.0f} %",
             "unreduced": f"{100.0 * away(slow['8'], 'unreduced'):.1f} %",
             "reduced_2": f"{100.0 * away(slow['2'], 'reduced'):.1f} %",
             "reduced_16": f"{100.0 * away(slow['16'], 'reduced'):.0f} %"}  # fmt: skip
    numbers |= {"damping of the slow pair, reduced order, γ = 8": slow["8"]["reduced"].real,
                "frequency of the slow pair, reduced order, γ = 8": slow["8"]["reduced"].imag}  # fmt: skip
    return Exhibit(
        title="Table 4. Characteristic roots at μ = 0.3 (reconstructed)",
        caption=CAPTION.replace("\n", " ").format(**words),
        equations=("6", "11"),
        table=[row for rows in (series | families).values() for row in rows],
        numbers=numbers,
        figure=characteristic_roots(
            [root for label, rows in series.items() for root in roots(label, rows)],
            [
                root
                for label, rows in ({r"$\varepsilon$ = $\kappa$ = $K_1$ = 0": series["8"]} | families).items()
                for root in roots(label, rows)
            ],
            title=TITLE,
        ),
    )
