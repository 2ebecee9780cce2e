"""What does a real rotor's Campbell diagram look like in forward flight: the Lynx at 120 knots."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import bisect

from floquet import Rotor, compare, flapping, load_rotor, transitions
from floquet.exhibits import Exhibit
from floquet.plot.campbell import Campbell, campbell
from floquet.plot.curves import Band

Array = NDArray[np.float64]
FILE = Path(__file__).parents[2] / "data" / "rotors" / "lynx.toml"
KNOTS = 120.0
KNOT = 1852.0 / 3600.0  # m/s
RPM = 30.0 / math.pi  # of a rad/s
ORDERS = {"regressing": -1, "coning": 0, "advancing": 1}
LOWEST, HIGHEST = 0.5, 1.1  # of the nominal speed
SHARES = np.linspace(LOWEST, HIGHEST, 13)  # for the table
CAPTION = """The flap modes of the Lynx at {knots:.0f} knots from 50 to 110 % of its rotor speed. Its hub spring
(K_β = {spring:.0f} N m/rad, I_β = {inertia:.0f} kg m²) is stiffer and its advance ratio higher the slower it turns:
κ = K_β/(I_β Ω²), μ = V/(ΩR). From {low:.0f} to {high:.0f} rpm, the nominal {nominal:.0f} rpm within, the exact coning
mode stays on the line of 1 per rev; the regressing mode has no frequency there and two dampings, at nominal speed
{first:.1f} and {second:.1f} 1/s. The regressing mode of the tip-path plane splits as well, but from {split:.0f} to
{merge:.0f} rpm, and its coning mode crosses the line of 1 per rev at one speed."""


def exhibit() -> Exhibit:
    rotor = load_rotor(FILE)
    physical = tomllib.loads(FILE.read_text(encoding="utf-8"))["rotor"]["physical"]
    nominal = float(physical["rotor_speed"])
    ends = LOWEST * nominal, HIGHEST * nominal
    edges, rho = transitions(lambda speed: flapping(*_slowed(rotor, speed)), *ends)
    splits = _splits(rotor, *ends)
    low, high, split, merge = (float(x) * RPM for x in (*edges, *splits))
    at = _modes(rotor, np.array([nominal]))
    first, second = (float(x) for x in at["damping"][0])
    numbers = {"locked from, rpm": low, "locked to, rpm": high, "nominal, rpm": nominal * RPM}
    numbers |= {"TPP regressing mode split from, rpm": split, "TPP regressing mode split to, rpm": merge}
    numbers |= {"μ at nominal speed": float(_slowed(rotor, np.array([nominal]))[1][0])}
    numbers |= {"κ at nominal speed": float(rotor.hinge_stiffness)}
    for mode in ORDERS:
        numbers |= {f"{mode} at nominal speed, Hz": float(at[f"{mode}_hz"][0])}
        numbers |= {f"{mode} at nominal speed, TPP, Hz": float(at[f"{mode}_tpp_hz"][0, 0])}
    numbers |= {"lower damping at nominal speed, 1/s": first, "higher damping at nominal speed, 1/s": second}
    caption = CAPTION.format(
        spring=physical["hinge_spring"], inertia=physical["flap_inertia"], knots=KNOTS, low=low, high=high, split=split,
        merge=merge, nominal=nominal * RPM, first=first, second=second,
    )  # fmt: skip
    return Exhibit(
        title="What does a real rotor's Campbell diagram look like in forward flight?",
        caption=caption.replace("\n", " "),
        equations=("1", "6"),
        table=rows(rotor),
        numbers=numbers,
        figure=campbell(_diagram(rotor, ends, [(low, high, float(rho[0]))], [*edges, *splits])),
    )


def _slowed(rotor: Rotor, speed: Any) -> tuple[Rotor, Any]:
    """The rotor at rotor speeds in rad/s, and its advance ratios."""
    assert rotor.rotor_speed is not None and rotor.radius is not None
    stiffness = rotor.hinge_stiffness * (rotor.rotor_speed / speed) ** 2
    return rotor.replace(hinge_stiffness=stiffness), KNOTS * KNOT / (speed * rotor.radius)


def _modes(rotor: Rotor, speed: Array) -> dict[str, Array]:
    """Columns at rotor speeds (k,): frequencies in Hz, damping in 1/s; those of the tip-path plane (k, 2)."""
    slowed, mu = _slowed(rotor, speed)
    found = compare(slowed, mu)
    exact = found.stability
    out = {"damping": -exact.exponents.real * speed[:, None], "lock": np.asarray(exact.lock)}
    for mode, order in ORDERS.items():
        simple = found[mode].simple * speed[:, None]
        out[f"{mode}_hz"] = np.abs(exact.rotation_number + order) * speed / (2.0 * math.pi)
        out[f"{mode}_tpp_hz"], out[f"{mode}_tpp_damping"] = np.abs(simple.imag) / (2.0 * math.pi), -simple.real
    return out


def _splits(rotor: Rotor, low: float, high: float) -> list[float]:
    """Rotor speeds in rad/s between which the tip-path plane's regressing eigenvalues are real."""

    def real(speed: float) -> float:
        return 1.0 if _modes(rotor, np.array([speed]))["regressing_tpp_hz"].max() == 0.0 else -1.0

    speeds = np.linspace(low, high, 241)
    flags = _modes(rotor, speeds)["regressing_tpp_hz"].max(axis=1) == 0.0
    return [float(bisect(real, speeds[i], speeds[i + 1], xtol=1e-9)) for i in np.flatnonzero(flags[1:] != flags[:-1])]


def _diagram(rotor: Rotor, ends: tuple[float, float], bands: list[Band], near: list[float]) -> Campbell:
    assert rotor.rotor_speed is not None
    beside = np.geomspace(1e-7, 0.3, 40)  # of a rad/s: curves stand upright at the edges of a lock
    dense = [edge + sign * beside for edge in near for sign in (1.0, -1.0)]
    speed = np.unique(np.clip(np.concatenate([np.linspace(*ends, 401), *dense]), *ends))
    found = _modes(rotor, speed)
    return Campbell(
        title=f"{rotor.name}, $N$ = {rotor.blades}, at {KNOTS:.0f} knots", rpm=speed * RPM,
        advance_ratio=_slowed(rotor, speed)[1], frequency={mode: found[f"{mode}_hz"] for mode in ORDERS},
        damping=found["damping"], plane_frequency={mode: found[f"{mode}_tpp_hz"] for mode in ORDERS},
        plane_damping={mode: found[f"{mode}_tpp_damping"] for mode in ORDERS},
        bands=bands, orders=(1, 2, rotor.blades),
        nominal=rotor.rotor_speed * RPM,
    )  # fmt: skip


def rows(rotor: Rotor) -> list[dict[str, Any]]:
    """A record for every 5 % of the rotor speed."""
    assert rotor.rotor_speed is not None
    speed = SHARES * rotor.rotor_speed
    slowed, mu = _slowed(rotor, speed)
    found = _modes(rotor, speed)
    columns = {"share": np.round(SHARES, 2), "rpm": speed * RPM, "advance_ratio": mu}
    columns |= {"hinge_stiffness": slowed.hinge_stiffness, "lock": found["lock"]}
    for mode in ORDERS:
        columns |= {f"{mode}_hz": found[f"{mode}_hz"], f"{mode}_tpp_hz": found[f"{mode}_tpp_hz"][:, 0]}
    columns |= {f"damping_{i + 1}": found["damping"][:, i] for i in (0, 1)}
    columns |= {f"{mode}_tpp_damping_{i + 1}": found[f"{mode}_tpp_damping"][:, i] for mode in ORDERS for i in (0, 1)}
    return [{name: float(values[k]) for name, values in columns.items()} for k in range(len(SHARES))]
