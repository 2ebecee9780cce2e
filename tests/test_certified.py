"""Ten thousand random rotors of every model against proven exponents (data/reference/certified.npz): bounds hold, and
are useful.

The exact values are sums of two doubles (26 decimals), so differences are taken in extended precision.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from floquet import Hub, Rotor, flapping, multiblade, stability, teetering
from floquet.exponents import Stability, Verdict
from floquet.period_map import Method, hill
from tests.support import REFERENCE

LONG = np.longdouble
DATA: dict[str, Any] = dict(np.load(REFERENCE / "certified.npz"))
NAMES = [str(name) for name in DATA["names"]]
KINDS = ("teetering", "exact_offset", "reversed_flow")


def groups(prefix: str = "") -> Iterator[tuple[np.ndarray, dict[str, Any], dict[str, np.ndarray]]]:
    """Cases that one call can take: their numbers, the model's options and the parameters."""
    values = DATA[f"{prefix}parameters"]
    tip = values[:, NAMES.index("tip_loss")]
    keys = np.column_stack([*(DATA[f"{prefix}{kind}"] for kind in KINDS), tip])
    for key in np.unique(keys, axis=0):
        chosen = np.flatnonzero((keys == key).all(axis=1))
        options = {"teetering": bool(key[0]), "exact_offset": bool(key[1]), "reversed_flow": bool(key[2])}
        yield (
            chosen,
            options | {"tip_loss": float(key[3])},
            {name: values[chosen, i] for i, name in enumerate(NAMES) if name != "tip_loss"},
        )


def computed(options: dict[str, Any], parameters: dict[str, np.ndarray]) -> Stability:
    """Stability of blades."""
    given, physics = dict(parameters), dict(options)
    mu, teeters = given.pop("advance_ratio"), physics.pop("teetering")
    rotor = Rotor(**given, **({"hub": Hub.TEETERING, "blades": 2} if teeters else {}))
    return stability((teetering if teeters else flapping)(rotor, mu, **physics))


def solved(prefix: str = "") -> dict[str, np.ndarray]:
    """Exponents, bounds and more of all cases."""
    count = len(DATA[f"{prefix}rho"])
    out = {"exponents": np.empty((count, 2), complex), "bound": np.empty(count), "rho": np.empty(count)}
    out |= {"lock": np.empty(count), "verdict": np.empty(count, int), "method": np.empty(count, int)}
    for chosen, options, parameters in groups(prefix):
        s = computed(options, parameters)
        out["exponents"][chosen], out["bound"][chosen] = s.exponents, s.exponent_errors.max(axis=-1)
        out["rho"][chosen], out["lock"][chosen], out["verdict"][chosen] = s.rotation_number, s.lock, s.verdict
        out["method"][chosen] = s.method
    return out


@pytest.fixture(scope="module")
def found() -> dict[str, np.ndarray]:
    return solved()


def errors(found: dict[str, np.ndarray], prefix: str = "") -> np.ndarray:
    """The larger of the two distances, on the branch."""
    real, rho = DATA[f"{prefix}real"], DATA[f"{prefix}rho"]
    turning = found["rho"].astype(LONG) - rho[:, 0] - rho[:, 1]
    growth = [found["exponents"][:, i].real.astype(LONG) - real[:, i, 0] - real[:, i, 1] for i in (0, 1)]
    return np.max([np.hypot(g, turning).astype(float) for g in growth], axis=0)


def test_every_error_is_within_its_bound(found: dict[str, np.ndarray]) -> None:
    error = errors(found)
    assert np.all(error + float(DATA["radius"]) <= found["bound"])
    assert error.max() < 1e-12


@pytest.mark.parametrize("precise", [True, False])
def test_bounds_hold_where_they_are_tried_hardest(precise: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Next to ends of locks, with growth by many decades, and where products of maps are rounded more than usual.

    Without forty digits, too: the bound of D in doubles must hold by itself.
    """
    if not precise:
        monkeypatch.setattr(hill, "make_precise", lambda phi, *_, **__: phi)
    found = solved("hard_")
    assert np.all(errors(found, "hard_") + float(DATA["hard_radius"]) <= found["bound"])
    proven = DATA["hard_locked"] >= 0
    surely = proven & (found["bound"] < 1e-11)
    np.testing.assert_array_equal(~np.isnan(found["lock"])[surely], DATA["hard_locked"][surely] == 1)
    decided = found["verdict"] != Verdict.UNDECIDED
    np.testing.assert_array_equal(found["verdict"][decided], DATA["hard_verdict"][decided])
    assert np.mean(decided) > 0.99
    assert (np.mean(found["method"] == Method.PRECISE) > 0.1) == precise


def test_bounds_are_useful(found: dict[str, np.ndarray]) -> None:
    """The median is 1e-14; where the discriminant is no tiny number, none exceeds 1e-11."""
    assert np.median(found["bound"]) < 1e-13
    assert found["bound"][np.abs(DATA["discriminant"]) > 1e-3].max() < 1e-11


def test_locks_and_verdicts_are_the_proven_ones(found: dict[str, np.ndarray]) -> None:
    proven = DATA["locked"] >= 0
    np.testing.assert_array_equal(~np.isnan(found["lock"])[proven], DATA["locked"][proven] == 1)
    np.testing.assert_array_equal(found["verdict"], DATA["verdict"])


def test_blades_in_the_non_rotating_frame() -> None:
    """300 rotors of 3 to 6 blades, from one blade and from all coordinates."""
    for chosen, options, parameters in groups("multiblade_"):
        physics = {k: v for k, v in options.items() if k != "teetering"}
        for place, case in list(enumerate(chosen))[:12]:
            given = {k: float(v[place]) for k, v in parameters.items()}
            mu, N = given.pop("advance_ratio"), int(DATA["multiblade_blades"][case])
            system = multiblade(Rotor(**given, blades=N), mu, **physics)
            (s1, s2), rho = DATA["multiblade_real"][case].sum(axis=-1), DATA["multiblade_rho"][case].sum()
            locked = DATA["multiblade_locked"][case] == 1
            pair = np.array([s1 + 1j * rho, s2 + (1j if locked else -1j) * rho])
            expected = (pair[:, None] + 1j * np.arange(N)).ravel()
            for symmetry in (True, False):
                s = stability(system, symmetry=symmetry)
                gaps = s.exponents[:, None] - expected
                gaps -= 1j * N * np.round(gaps.imag / N)
                nearest = np.abs(gaps).min(axis=1)
                assert np.all(nearest <= s.exponent_errors + 4e-16)  # the sums above are rounded
