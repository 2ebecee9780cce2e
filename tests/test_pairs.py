"""Pairs of doubles against fractions, and maps in them against maps in 160-bit integers and certified exponents."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from floquet import Hub, Rotor, flapping, stability, teetering
from floquet.kernels import available
from floquet.models.textbook import mathieu
from floquet.period_map import Method
from floquet.period_map.hill import hill_map
from floquet.period_map.integers import in_integers
from floquet.period_map.pairs import STEPS, in_pairs
from floquet.periodic import PeriodicSystem
from floquet.tape import Record, program
from floquet.validity import lock_windows

if not available():
    pytest.skip("numba is not to be used", allow_module_level=True)

UNIT = 2.0**-104


def drawn(n: int, seed: int, low: float, high: float) -> PeriodicSystem:
    """Random blades with γ between two numbers."""
    rng = np.random.default_rng([41, seed])
    parameters = {name: rng.uniform(*ends, n) for name, ends in (
        ("hinge_offset", (0.0, 0.2)), ("hinge_stiffness", (0.0, 1.0)), ("pitch_flap_coupling", (-0.8, 0.8)),
        ("flap_damping", (0.0, 0.3)))}  # fmt: skip
    return flapping(Rotor(lock_number=rng.uniform(low, high, n), **parameters), rng.uniform(0.0, 2.0, n))


def panels_of(system: PeriodicSystem) -> Any:
    return hill_map(system, precise=False).panels


# ---------------------------------------------------------------------- arithmetic
def test_arithmetic_of_pairs_has_thirty_one_digits() -> None:
    """Random expressions on pairs against fractions, cancellation included; relative to the sizes that are added."""
    from floquet.kernels.pairs import run_pairs

    rng = np.random.default_rng(8)
    record = Record()
    a, b, c = (record.input(name) for name in "abc")
    third = Fraction(1, 3)
    outputs = [
        a + b,
        a - b,
        a * b,
        a / b,
        (a + b) - a,
        (a * b - b * a * (1 + third)) / c,
        abs(a - b) * third,
        2 / a - c,
    ]
    code = program(record, [record.place(x) for x in outputs], "ab")
    n = 200
    values = {"a": rng.normal(size=n) * 10.0 ** rng.integers(-3, 4, n), "b": rng.normal(size=n), "c": 0.7}
    scalars, rows = np.zeros((code.scalars, 2)), np.zeros((code.rows, 2, n))
    for k, constant in enumerate(code.constants):
        scalars[k] = float(constant.exact), float(constant.exact - Fraction(float(constant.exact)))
    scalars[len(code.constants), 0] = values["c"]
    for k, name in enumerate(code.varying):
        rows[k, 0] = values[name]
    run_pairs(code.prologue, code.steps, scalars, rows)
    for i in range(n):
        point = {name: Fraction(float(np.broadcast_to(v, n)[i])) for name, v in values.items()}
        size = max(map(abs, point.values())) ** 2 + 1 / min(map(abs, point.values()))
        for row, exact in zip(code.outputs, code.run(point, exact=True), strict=True):
            found = Fraction(rows[row, 0, i]) + Fraction(rows[row, 1, i])
            assert abs(found - exact) <= 16 * UNIT * max(abs(exact), size)
            assert abs(rows[row, 1, i]) <= np.spacing(abs(rows[row, 0, i]))  # normal


# ---------------------------------------------------------------------- maps
@pytest.mark.parametrize(
    "system",
    [
        drawn(150, 0, 2.0, 24.0),
        drawn(60, 1, 24.0, 64.0),
        teetering(
            Rotor(lock_number=np.linspace(2.0, 30.0, 60), hub=Hub.TEETERING, blades=2), np.linspace(0.0, 1.5, 60)
        ),
        mathieu(np.linspace(-2.0, 30.0, 60), np.linspace(0.0, 12.0, 60), 0.1),
    ],
    ids=["blades", "strong growth", "teetering", "mathieu"],
)
def test_maps_in_pairs_are_those_in_integers(system: PeriodicSystem) -> None:
    """Φ to the last bits of a double, D within a bound that is its own rounding, zeros the same."""
    panels = panels_of(system)
    index = np.arange(len(panels))
    found = in_pairs(system.part(index), panels)
    exact = in_integers(system.part(index, exact=True), panels)
    assert found is not None and not np.any(found[7])
    np.testing.assert_allclose(found[:4], exact[:4], rtol=1e-15)
    np.testing.assert_array_equal(found[6], exact[6])
    assert np.all(np.abs(found[8] - exact[8]) <= found[5] + exact[5])
    assert np.all(np.abs(0.5 * (found[0] + found[3]) - 0.5 * (exact[0] + exact[3])) <= found[4] + exact[4])
    away = np.abs(exact[8]) > 1e-12
    assert np.all(found[5][away] <= 1e-15 * np.abs(exact[8])[away])


def test_bounds_of_pairs_hold_at_branch_points() -> None:
    """Advance ratios a bit apart at the ends of locks: D of 1e-16, told to the last digits of pairs."""
    edges = []
    for gamma in (6.0, 8.0, 12.0, 16.5, 23.0, 40.0):
        for enter, leave, _ in lock_windows(Rotor(lock_number=gamma, hinge_offset=0.03), mu_max=1.5):
            edges += [(gamma, x + k * np.spacing(x)) for x in (enter, leave) if 0.0 < x < np.inf for k in range(-3, 4)]
    gamma, mu = np.array(edges).T
    system = flapping(Rotor(lock_number=gamma, hinge_offset=0.03), mu)
    panels, index = panels_of(system), np.arange(len(mu))
    found, exact = in_pairs(system.part(index), panels), in_integers(system.part(index, exact=True), panels)
    assert found is not None and len(mu) > 40 and np.median(np.abs(exact[8])) < 1e-13
    error = np.abs(found[8] - exact[8])
    assert np.all(error <= found[5] + exact[5])
    assert np.all(found[5] <= 1e-25 * np.abs(exact[:4]).max(axis=0) ** 2 + 1e-15 * np.abs(exact[8]))


def test_exponents_next_to_branch_points_are_the_certified_ones() -> None:
    """In a batch that is solved compiled, so by pairs."""
    edge = lock_windows(Rotor(lock_number=8.0))[0][0]
    near = edge + np.array([-1e-6, -1e-9, -1e-12, -1e-15, 1e-15, 1e-12, 1e-9, 1e-6])
    mu = np.concatenate([np.linspace(0.0, 0.7, 2000), near])
    found = stability(flapping(Rotor(lock_number=8.0), mu))
    assert np.sum(found.method == Method.PRECISE) >= 4
    proven = [stability(flapping(Rotor(lock_number=8.0), x), certify=True) for x in near]
    for k, proof in enumerate(proven, start=2000):
        error = np.abs(found.exponents[k] - proof.exponents).max()
        assert error <= found.exponent_errors[k].max() + proof.exponent_errors.max() <= 1.1e-11


def test_bits_next_to_branch_points_do_not_depend_on_other_cases() -> None:
    """One more blade, with a parameter that is zero for the others; with a root cutout it is not recorded itself."""
    edge = lock_windows(Rotor(lock_number=8.0))[0][0]
    mu = edge + np.arange(-40, 40) * 1e-13
    alone = flapping(Rotor(lock_number=8.0), mu)
    expected = in_pairs(alone.part(slice(None)), panels_of(alone))
    assert expected is not None and not np.any(expected[7])
    other = np.append(np.zeros(len(mu)), 0.1)
    for name in ("hinge_offset", "hinge_stiffness", "pitch_flap_coupling", "flap_damping", "root_cutout"):
        system = flapping(Rotor(lock_number=8.0, **{name: other}), np.append(mu, 0.3))
        found = in_pairs(system.part(slice(None)), panels_of(system))
        assert found is not None
        np.testing.assert_array_equal(found[:, :-1], expected)
        assert found[7, -1] == (name == "root_cutout")


def test_numbers_of_panels_are_those_wanted_or_a_few_more() -> None:
    for panels in range(2, 513):
        step = STEPS[np.searchsorted(STEPS, panels)]
        assert panels <= step <= 1.5 * panels
