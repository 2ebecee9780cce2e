"""How do the exact exponents pass through locks: a root locus at γ = 12."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from floquet import Rotor, flapping, lock_windows, multiblade, stability, tip_path_plane, track
from floquet.exhibits import Exhibit
from floquet.plot.through_locks import Locus, through_locks

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
ROTOR = Rotor(lock_number=12.0, blades=3)
END = 1.2
MARKS = np.linspace(0.1, END, 12)
LISTED = np.linspace(0.0, END, 25)
ORDERS = {"regressing": -1, "coning": 0}
CAPTION = """Exponents of an articulated rotor with γ = 12, hinge offset, spring and coupling 0, from hover to μ =
1.2. All exact modes have the damping γ/16 until regressing and coning meet at ½ per rev at μ = {enter:.3f}. In the
lock they keep that frequency and share two dampings, farthest apart at μ = {turn:.2f} with {least:.3f} and
{most:.3f} per rev; at {leave:.3f} they part again, at {second:.3f} the regressing mode becomes two reals and the
coning mode stays at 1 per rev. The tip-path plane has no lock at ½ per rev: its modes veer, and its regressing mode
splits at μ = {split:.3f}."""


def exhibit() -> Exhibit:
    (enter, leave, _), (second, last, _) = lock_windows(ROTOR, END)
    turn = _turn(enter, leave)
    least, most = (-stability(flapping(ROTOR, turn)).exponents.real).tolist()
    found = track(lambda mu: tip_path_plane(ROTOR, mu), LISTED)
    event = next(event for event in found.events if found.names[event.modes[0]] == "regressing")
    split = 0.5 * (event.low + event.high)
    parts = {
        "enter": enter,
        "leave": leave,
        "second": second,
        "turn": turn,
        "least": least,
        "most": most,
        "split": split,
    }
    numbers = {"enters the lock at ½ per rev, μ": enter, "leaves the lock at ½ per rev, μ": leave}
    numbers |= {"enters the lock at 1 per rev, μ": second, "farthest apart at ½ per rev, μ": turn}
    numbers |= {"least damping at ½ per rev": least, "largest damping at ½ per rev": most}
    numbers |= {"TPP regressing mode splits, μ": split}
    return Exhibit(
        title="How do the exact exponents pass through locks?",
        caption=CAPTION.format(**parts).replace("\n", " "),
        equations=("1", "6"),
        table=rows(),
        numbers=numbers,
        figure=through_locks(_locus([(enter, leave, 0.5), (second, last, 1.0)], [turn, split])),
    )


def _turn(enter: float, leave: float) -> float:
    """Where in a lock the two dampings are farthest apart."""

    def growth(mu: float) -> float:
        return -float(stability(flapping(ROTOR, mu)).exponents.real.max())

    found = minimize_scalar(growth, bounds=(enter, leave), method="bounded", options={"xatol": 1e-8})
    return float(found.x)


def _locus(bands: list[tuple[float, float, float]], more: list[float]) -> Locus:
    beside = np.geomspace(1e-9, 0.02, 30)  # the exponents part with a square root
    edges = [edge for band in bands for edge in band[:2] if math.isfinite(edge)]
    near = np.concatenate([edge + sign * beside for edge in [*edges, *more] for sign in (1.0, -1.0)])
    mu = np.unique(np.concatenate([np.linspace(0.0, END, 241), MARKS, edges, more, near]))
    simple = track(lambda x: tip_path_plane(ROTOR, x), mu)
    return Locus(
        title=r"$\gamma$ = 12, $N$ = 3, ticks and dots at $\mu$ = 0.1, 0.2 …",
        mu=mu,
        exact={mode: _seen(mu, order) for mode, order in ORDERS.items()},
        plane={mode: np.where(simple[mode].imag > -1e-9, simple[mode], complex(math.nan, math.nan)) for mode in ORDERS},
        bands=bands,
        marks=MARKS,
    )


def _seen(mu: Array, order: int) -> Complex:
    """The exponents of a mode in the upper half plane, (k, 2): one outside locks, two within."""
    found = stability(flapping(ROTOR, mu))
    return np.asarray(found.exponents.real + 1j * np.abs(found.rotation_number + order)[:, None])


def rows() -> list[dict[str, Any]]:
    """A record for every 0.05 of μ: exact exponents of three blades and those of the tip-path plane, as tracked."""
    models = {"exact": multiblade, "tpp": tip_path_plane}
    found = {name: track(lambda mu, model=model: model(ROTOR, mu), LISTED) for name, model in models.items()}  # type: ignore[misc]
    out: list[dict[str, Any]] = []
    for k, mu in enumerate(LISTED.tolist()):
        row: dict[str, Any] = {"advance_ratio": round(mu, 2)}
        for name, tracked in found.items():
            for mode in ORDERS:
                row |= {f"{name}_{mode}_{i + 1}": complex(tracked[mode][k, i]) for i in (0, 1)}
        out.append(row)
    return out
