"""Where is a blade locked and where does it grow: the Strutt diagram of the flapping equation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from floquet import Rotor, boundaries, flapping, instability_onset, lock_windows, stability, transitions
from floquet.exhibits import Exhibit
from floquet.models.textbook import mathieu
from floquet.plot.parts import MU_LABEL, per_rev
from floquet.plot.strutt import Plane, strutt
from floquet.verdict import Verdict

Q, A = np.linspace(0.0, 8.0, 321), np.linspace(-4.0, 18.0, 441)
MU, GAMMA = np.linspace(0.0, 2.5, 401), np.linspace(2.0, 16.0, 401)
LISTED = range(2, 17)
MARKED = 8.0
HOVER = 1e-3  # an advance ratio at which the tongue of ½ per rev is 0.02 wide in γ
CAPTION = """Left, Mathieu's equation x'' + (a − 2q cos 2t) x = 0 as in every textbook: locked solutions make n half
turns in a period, and every lock grows. Beside it one blade of an articulated rotor, hinge offset, spring and
coupling 0, in the plane of its Lock number and the advance ratio, without and with reversed flow. The tongues are the
same, but its damping keeps them stable far beyond their edges: at γ = 8 the blade is locked from μ = {lock:.3f} and
grows from {onset:.3f}, with reversed flow from {locked:.3f} and {later:.3f}. The tongue of ½ per rev stands at γ =
8√3 in hover and reaches down to γ = {tip:.2f}, with reversed flow to {lower:.2f}."""


def exhibit() -> Exhibit:
    onset, later = (instability_onset(Rotor(lock_number=MARKED), 3.0, reversed_flow=flow) for flow in (False, True))
    first, second = (lock_windows(Rotor(lock_number=MARKED), 2.5, reversed_flow=flow)[-1][0] for flow in (False, True))
    tip, lower = (_lowest_locked(flow) for flow in (False, True))
    numbers = {"onset of growth, γ = 8": onset, "onset of growth, γ = 8, reversed flow": later}
    numbers |= {"locked at 1 per rev from, γ = 8": first, "locked at 1 per rev from, γ = 8, reversed flow": second}
    numbers |= {"γ of the tip of the tongue of ½ per rev": _tip()}
    numbers |= {"lowest γ locked at ½ per rev": tip, "lowest γ locked at ½ per rev, reversed flow": lower}
    return Exhibit(
        title="Where is a blade locked and where does it grow: the Strutt diagram of the flapping equation?",
        caption=CAPTION.format(lock=first, onset=onset, locked=second, later=later, tip=tip, lower=lower).replace(
            "\n", " "
        ),
        equations=("1",),
        table=rows(),
        numbers=numbers,
        figure=strutt(
            [
                _mathieu(),
                _blade("blade, without reversed flow", onset, flow=False),
                _blade("blade, with reversed flow", later, flow=True),
            ],
            footer="n: half turns of a locked solution in a period; a blade's period is one revolution.",
        ),
    )


def _mathieu() -> Plane:
    found = stability(mathieu(A[:, None], Q))
    ends = (float(Q[0]), float(Q[-1])), (float(A[0]), float(A[-1]))
    return Plane(
        title="Mathieu's equation", across="strength $q$", up="stiffness $a$", x=Q, y=A,
        turns=np.asarray(found.lock), growth=np.asarray(found.verdict) == Verdict.UNSTABLE,
        locks=boundaries(lambda q, a: mathieu(a, q), *ends), onset=(), names={n: f"$n$ = {n}" for n in range(6)},
        ticks=[n**2 for n in range(5)],
    )  # fmt: skip


def _blade(title: str, onset: float, *, flow: bool) -> Plane:
    found = stability(_family(MU, GAMMA[:, None], flow=flow))
    ends = (float(MU[0]), float(MU[-1])), (float(GAMMA[0]), float(GAMMA[-1]))
    locks, growth = (
        boundaries(lambda mu, gamma: _family(mu, gamma, flow=flow), *ends, kind=kind)  # type: ignore[arg-type]
        for kind in ("lock", "growth")
    )
    return Plane(
        title=title, across=MU_LABEL, up=r"Lock number $\gamma$", x=MU, y=GAMMA, turns=2.0 * np.asarray(found.lock),
        growth=np.asarray(found.verdict) == Verdict.UNSTABLE, locks=locks, onset=growth,
        names={n: f"{per_rev(0.5 * n)}\n$n$ = {n}" for n in range(5)},
        marks=[(onset, MARKED, f"$\\mu$ = {onset:.3f}"), (0.0, 8.0 * math.sqrt(3.0), r"$\gamma = 8\sqrt{3}$")],
        folklore=True,
    )  # fmt: skip


def _family(mu: Any, gamma: Any, *, flow: bool) -> Any:
    return flapping(Rotor(lock_number=gamma), mu, reversed_flow=flow)


def _tip() -> float:
    """γ in the middle of the tongue of ½ per rev where it begins."""
    edges, _ = transitions(lambda gamma: _family(HOVER, gamma, flow=False), 10.0, 15.9)
    return float(edges.mean())


def _lowest_locked(flow: bool) -> float:
    """The lowest Lock number at which there is a lock at ½ per rev."""

    def edge(mu: float) -> float:
        gamma, rho = transitions(lambda g: _family(mu, g, flow=flow), 2.0, 16.0)
        return min(gamma[rho == 0.5], default=16.0)

    found = minimize_scalar(edge, bounds=(0.3, 1.5), method="bounded", options={"xatol": 1e-7})
    return float(found.fun)


def rows() -> list[dict[str, Any]]:
    """A record for every whole Lock number, without and with reversed flow: the locks up to 2.5, and growth."""
    out: list[dict[str, Any]] = []
    rotor = Rotor(lock_number=np.array(LISTED, float))
    for flow in (False, True):
        found, onsets = (find(rotor, 2.5, reversed_flow=flow) for find in (lock_windows, instability_onset))
        for gamma, windows, onset in zip(LISTED, found, onsets.tolist(), strict=True):
            ends = {rho: (enter, leave) for enter, leave, rho in windows}
            row: dict[str, Any] = {"lock_number": float(gamma), "reversed_flow": flow}
            for rho, name in ((0.5, "half_per_rev"), (1.0, "1_per_rev")):
                enter, leave = ends.get(rho, (math.inf, math.inf))
                row |= {f"{name}_from": enter, f"{name}_to": leave}
            out.append(row | {"growth_from": onset})
    return out
