"""What several tests share: reference cases as systems, and the distance of sets of exponents."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from floquet.models import flapping, multiblade, teetering
from floquet.models.textbook import mathieu, meissner
from floquet.periodic import PeriodicSystem
from floquet.rotor import Hub, Rotor

REFERENCE = Path(__file__).parent.parent / "data" / "reference"


def oracle() -> list[dict[str, Any]]:
    """The 42 cases of 30 digits."""
    cases: list[dict[str, Any]] = json.loads((REFERENCE / "floquet_oracle.json").read_text())["cases"]
    return cases


def oracle_system(case: dict[str, Any]) -> PeriodicSystem:
    """The package's model of an oracle case."""
    p = {k: v for k, v in case["params"].items()}
    if case["kind"] == "mathieu":
        return mathieu(float(p["a"]), float(p["q"]), float(p["damping"]))
    if case["kind"] == "meissner":
        return meissner(float(p["delta"]), float(p["e"]), float(p["damping"]))
    eps = float(p.get("eps", 0))
    values = {
        "lock_number": float(p["gamma"]),
        "hinge_offset": eps,
        "hinge_stiffness": float(p.get("kbeta", 0)),
        "pitch_flap_coupling": float(p.get("K1", 0)),
    }
    if case["kind"] == "teetering":
        return teetering(Rotor(blades=2, hub=Hub.TEETERING, **values), float(p["mu"]))
    m = 1.5 * eps / (1.0 - eps) if p.get("eMI") == "uniform_exact" else None
    rotor = Rotor(offset_mass_ratio=m, blades=case.get("N", 4), **values)
    return multiblade(rotor, float(p["mu"])) if case["kind"] == "multiblade" else flapping(rotor, float(p["mu"]))


def oracle_exponents(case: dict[str, Any]) -> tuple[NDArray[np.complex128], float]:
    """Exponents and the strip they are known modulo."""
    return np.array([complex(float(a), float(b)) for a, b in case["exponents"]]), float(
        case["exponent_mod"].rstrip("i") or 1
    )


def distances(found: Any, expected: Any, strip: float = np.inf) -> NDArray[np.float64]:
    """Distance of each found exponent to the one assigned to it, modulo i·strip."""
    d = np.asarray(found, complex)[:, None] - np.asarray(expected, complex)[None, :]
    if np.isfinite(strip):
        d = d.real + 1j * (d.imag - strip * np.round(d.imag / strip))
    rows, columns = linear_sum_assignment(np.abs(d))
    return np.asarray(np.abs(d[rows, columns]))
