"""A step of longitudinal cyclic pitch, by full, unreduced and reduced equations: what figures 13 and 14 share."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from floquet import Rotor, flapping, multiblade, stability, tip_path_plane
from floquet.comparison import eigenvalues
from floquet.exhibits import Exhibit
from floquet.plot.histories import History, step_histories
from floquet.response import flap_angle, periodic_response, reduced_order, steady_state, step_response

MU = 0.3
OMEGA = 31.41  # rad/s
STEP = {"B_1c": 1.0}
SECONDS = np.linspace(0.0, 1.2, 241)
IN_TABLE = slice(None, None, 4)
PLANE = ("a_0", "a_1", "b_1")
SHOWN = {
    "a_0": ("coning", "$a_0$ (rad per rad of $B_{1c}$)"),
    "a_1": ("longitudinal flapping", "$a_1$ (rad per rad of $B_{1c}$)"),
    "b_1": ("lateral flapping", "$b_1$ (rad per rad of $B_{1c}$)"),
    "beta": (r"flapping of one blade, first at $\psi$ = 0", r"$\beta$ (rad per rad of $B_{1c}$)"),
}
CLOSE = 0.05  # rad per rad
Histories = dict[str, dict[str, NDArray[np.float64]]]


def shown(rotor: Rotor, *, title: str, heading: str, caption: str) -> Exhibit:
    """The figure of a rotor; ``caption`` has the names of :func:`words` in braces."""
    found = histories(rotor)
    numbers = measured(rotor, found)
    columns = {"seconds": SECONDS, "revolutions": OMEGA * SECONDS / (2.0 * math.pi)}
    columns |= {f"{name}_{model}": x for name, models in found.items() for model, x in models.items()}
    rows = zip(*(x[IN_TABLE].tolist() for x in columns.values()), strict=True)
    return Exhibit(
        title=title,
        caption=caption.replace("\n", " ").format(**words(numbers, found)),
        equations=("1", "3", "5", "6", "11", "12"),
        table=[dict(zip(columns, row, strict=True)) for row in rows],
        numbers=numbers,
        figure=step_histories(
            SECONDS, [History(title=title, label=label, values=found[name]) for name, (title, label) in SHOWN.items()],
            rotor_speed=OMEGA, title=heading,
        ),
    )  # fmt: skip


def histories(rotor: Rotor) -> Histories:
    """Coordinate → model → values at SECONDS."""
    psi = OMEGA * SECONDS
    plane = tip_path_plane(rotor, MU)
    systems = {"full": multiblade(rotor, MU), "unreduced": plane, "reduced": reduced_order(plane)}
    planes = {model: step_response(system, STEP, psi) for model, system in systems.items()}
    values = {model: found.tip_path_plane for model, found in planes.items()}
    blade = {model: flap_angle(x, psi) for model, x in values.items()}
    blade["full"] = step_response(flapping(rotor, MU), STEP, psi).values[:, 0]
    return {name: {model: x[:, i] for model, x in values.items()} for i, name in enumerate(PLANE)} | {"beta": blade}


def measured(rotor: Rotor, found: Histories) -> dict[str, float]:
    """Steady values, how far the simple models are from the full equations, and how long it takes."""
    plane, blade = tip_path_plane(rotor, MU), flapping(rotor, MU)
    simple, full = steady_state(plane, STEP), periodic_response(blade, STEP).tip_path_plane
    out = {f"steady {name}, {model}": float(x[i]) for i, name in enumerate(PLANE)
           for model, x in (("simple models", simple), ("full equations", full))}  # fmt: skip
    away = {(n, model): np.abs(x[model] - x["full"]) for n, x in found.items() for model in ("unreduced", "reduced")}
    out |= {f"largest difference of {n}, {model} order": float(x.max()) for (n, model), x in away.items()}
    last = max(np.flatnonzero(away[name, "reduced"] > CLOSE)[-1] for name in PLANE)
    slowest = {"reduced order": eigenvalues(reduced_order(plane)), "full equations": stability(blade).exponents}
    out |= {f"longest time constant (s), {model}": float(-1.0 / (OMEGA * z.real.max())) for model, z in slowest.items()}
    return out | {"reduced order within 0.05 from (s)": float(SECONDS[last + 1])}


def words(numbers: dict[str, float], found: Histories) -> dict[str, float]:
    """What the caption says of the numbers and of the overshoot of a_0."""
    steady = {
        name: abs(numbers[f"steady {name}, simple models"] - numbers[f"steady {name}, full equations"])
        for name in PLANE
    }
    shares = {f"share_{n}": 100.0 * x / abs(numbers[f"steady {n}, full equations"]) for n, x in steady.items()}
    peak = {model: float(np.abs(x).max()) for model, x in found["a_0"].items()}
    return steady | shares | {
        "over": peak["reduced"] - abs(numbers["steady a_0, simple models"]),
        "over_full": peak["full"] - abs(numbers["steady a_0, full equations"]),
        "unreduced": max(numbers[f"largest difference of {name}, unreduced order"] for name in PLANE),
        "blade": numbers["largest difference of beta, unreduced order"],
        "reduced": numbers["largest difference of b_1, reduced order"],
        "close": numbers["reduced order within 0.05 from (s)"],
        "turns": OMEGA * numbers["reduced order within 0.05 from (s)"] / (2.0 * math.pi),
        "slow": numbers["longest time constant (s), reduced order"],
        "exact": numbers["longest time constant (s), full equations"],
    }  # fmt: skip
