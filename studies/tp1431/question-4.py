"""What do averaged models of five and more blades change?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from floquet import Rotor, compare, lock_windows, multiblade, stability
from floquet.comparison import Cause
from floquet.exhibits import Exhibit
from floquet.plot.validity_curves import Curve, Errors, Limits, Series, validity_figure
from floquet.report import intervals_text

GAMMAS = range(2, 17, 2)
MODES = ("regressing", "coning", "advancing")
HARMONICS = {1: "3, 4", 2: "5, 6", 3: "7, 8", 4: "9, 10"}  # and the blades whose averaged model it is
TOLERANCE = 0.05
NOTE = "M harmonics: averaged model of N = 2M + 1 or 2M + 2 blades; M = 1 is the tip-path plane."
MU = np.linspace(0.0, 1.0, 801)
CAPTION = """The averaged multiblade model of N = 2M + 1 or 2M + 2 blades keeps M harmonics; M = 1 is the tip-path
plane. The flapping exponents of identical blades are the same for any number, so each is a model of every rotor;
hinge offset, spring and coupling are 0. Every harmonic gains two orders in the advance ratio: errors are of order 2M
for regressing and advancing, 2M + 2 for coning. Above, errors at Lock number 8: at advance ratio 0.3 the regressing
error is {errors} for M = 1 to 4. Below, the advance ratio at which the error first passes 5 %. Of 8 rotors the
regressing mode is still within 5 % where the first lock begins for {passing} with M = 1 to 4."""


def rows(gammas: Sequence[float] = GAMMAS) -> list[dict[str, Any]]:
    """A record for every Lock number, number of harmonics and mode."""
    rotors = [Rotor(lock_number=gamma, blades=3) for gamma in gammas]
    return [row for r, w in [(r, lock_windows(r)) for r in rotors] for M in HARMONICS for row in _rows(r, w, M)]


def _rows(rotor: Rotor, windows: Sequence[tuple[float, float, float]], M: int) -> list[dict[str, Any]]:
    out = []
    mu = np.unique([*MU, *(x for w in windows for x in w[:2] if x < 1.0)])  # errors peak at lock edges
    found = compare(rotor, mu, harmonics=M)
    for mode in MODES:
        limit = _limit(rotor, M, mode, mu, found[mode].error)
        there = compare(rotor, min(limit + 1e-12, 1.0), harmonics=M)[mode]
        row = {"lock_number": rotor.lock_number, "harmonics": M, "blades": HARMONICS[M], "mode": mode, "limit": limit}
        cause = there.cause if limit <= 1.0 else Cause.NONE
        row |= {"cause": cause, "rule": there.rule, "largest_error": found[mode].error.max().item()}
        out.append(row | {"lock_windows": windows, "passes_lock": limit > windows[0][0]})
    return out


def _limit(rotor: Rotor, M: int, mode: str, mu: Any, error: Any) -> float:
    """The first μ at which the error passes the tolerance, inf if it does not."""
    failing = np.flatnonzero(error > TOLERANCE)
    if not failing.size:
        return float("inf")
    low, high = mu[failing[0] - 1 : failing[0] + 1]
    return float(brentq(lambda x: compare(rotor, x, harmonics=M)[mode].error - TOLERANCE, low, high, xtol=1e-12))


def chosen(table: Sequence[Mapping[str, Any]], mode: str, M: int) -> list[Mapping[str, Any]]:
    return [row for row in table if row["mode"] == mode and row["harmonics"] == M]


def exhibit() -> Exhibit:
    table = rows()
    eight = Rotor(lock_number=8.0, blades=3)
    errors = {M: compare(eight, 0.3, harmonics=M)["regressing"].error for M in HARMONICS}
    passing = {M: sum(row["passes_lock"] for row in chosen(table, "regressing", M)) for M in HARMONICS}
    numbers = {f"regressing error, {N} blades, γ = 8, μ = 0.3": errors[M] for M, N in HARMONICS.items()}
    numbers |= {
        f"{row['mode']} limit, {row['blades']} blades, γ = 8": row["limit"] for row in table if row["lock_number"] == 8
    }
    numbers |= {f"rotors of 8 within 5 % up to the first lock, {N} blades": passing[M] for M, N in HARMONICS.items()}
    numbers["distance of the modes of 5 blades from those of 6, γ = 8, μ = 0.3"] = six_from_five(8.0, 0.3)
    said = {
        "errors": ", ".join(f"{100.0 * x:.2g} %" for x in errors.values()),
        "passing": ", ".join(map(str, passing.values())),
    }
    return Exhibit(
        title="What do averaged models of five and more blades change?",
        caption=CAPTION.format(**said).replace("\n", " "),
        equations=("4", "6", "B5"),
        table=[{**row, "lock_windows": locked(row)} for row in table],
        numbers=numbers,
        figure=validity_figure([[_errors(eight, m) for m in MODES], [_limits(table, m) for m in MODES]], note=NOTE),
    )


def six_from_five(gamma: float, mu: float) -> float:
    """The largest distance of an eigenvalue of the averaged model of five blades from the nearest one of six."""
    six, five = (stability(multiblade(Rotor(lock_number=gamma, blades=N), mu).mean()).exponents for N in (6, 5))
    return float(np.abs(five[:, None] - six).min(axis=1).max())


def _errors(rotor: Rotor, mode: str) -> Errors:
    mu = np.unique([*MU, lock_windows(rotor)[0][0]])
    curves = [Curve(label=str(M), mu=mu, error=compare(rotor, mu, harmonics=M)[mode].error) for M in HARMONICS]
    return Errors(title=rf"{mode}, by M, $\gamma$ = 8", curves=curves, locks=lock_windows(rotor), lowest=1e-6)


def _limits(table: Sequence[Mapping[str, Any]], mode: str) -> Limits:
    return Limits(title=f"{mode}, by M", series=[Series.of(str(M), chosen(table, mode, M)) for M in HARMONICS])


def locked(row: Mapping[str, Any]) -> str:
    """``from 0.8268 at 1``: where, and per rev."""
    return ", ".join(f"{intervals_text([w[:2]])} at {w[2]:g}" for w in row["lock_windows"])
