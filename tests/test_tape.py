"""Tapes: what is recorded gives, bit for bit, what the model's own arithmetic gives; in fractions, exactly that."""

from __future__ import annotations

import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from floquet import stability
from floquet.kernels import available
from floquet.models import flapping, teetering
from floquet.models.textbook import mathieu
from floquet.period_map.form import hill_form, mean_growth, polynomial, term_size
from floquet.period_map.recorded import Smooth, recorded, smooth_form
from floquet.periodic import PeriodicSystem
from floquet.rotor import Hub, Rotor
from floquet.tape import Record, UntraceableError, program

compiled = pytest.mark.skipif(not available(), reason="numba is not to be used")
N = 3000
RANGES = {
    "lock_number": (2.0, 24.0),
    "hinge_offset": (0.0, 0.25),
    "hinge_stiffness": (0.0, 0.8),
    "pitch_flap_coupling": (-0.6, 0.6),
    "flap_damping": (0.0, 1.0),
}


def drawn(names: tuple[str, ...], seed: int, n: int = N) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(*RANGES[name], n) for name in names}


def systems(n: int = N) -> dict[str, PeriodicSystem]:
    """Every model that is recorded, with parameters that vary, are alike, zero or one."""
    rng = np.random.default_rng(0)
    mu, all_names = rng.uniform(0.0, 1.5, n), tuple(RANGES)
    teeter: dict[str, Any] = {"hub": Hub.TEETERING, "blades": 2}
    two = drawn(("lock_number", "pitch_flap_coupling"), 1, n)
    return {
        "all vary": flapping(Rotor(**drawn(all_names, 2, n)), mu),
        "exact in the offset": flapping(Rotor(**drawn(all_names, 3, n)), mu, exact_offset=True),
        "tip loss": flapping(Rotor(**drawn(all_names, 4, n)), mu, tip_loss=0.97, exact_offset=True),
        "offset and coupling alike": flapping(
            Rotor(**drawn(("lock_number",), 5, n), hinge_offset=0.05, pitch_flap_coupling=0.3), mu
        ),
        "no offset": flapping(Rotor(**two), mu),
        "one rotor": flapping(Rotor(lock_number=8.0, hinge_stiffness=1.0, hinge_offset=0.1), mu),
        "hover": flapping(Rotor(**drawn(all_names, 6, n)), 0.0),
        "zeros in some places": flapping(Rotor(**drawn(("lock_number",), 7, n)), np.where(mu < 0.5, 0.0, mu)),
        "a grid": flapping(Rotor(lock_number=np.linspace(2.0, 9.0, n // 50)[:, None]), np.linspace(0.0, 1.0, 50)),
        "teetering": teetering(Rotor(**two, **teeter), mu),
        "teetering with tip loss": teetering(Rotor(**two, **teeter), mu, tip_loss=0.95),
        "mathieu": mathieu(rng.uniform(-3, 20, n), rng.uniform(0, 8, n), 0.1),
        "mathieu without modulation": mathieu(rng.uniform(-3, 20, n), 0.0, rng.uniform(0, 1, n)),
    }  # fmt: skip


SYSTEMS = systems()


def in_numpy(system: PeriodicSystem) -> Smooth:
    """The Hill form without a tape."""
    q, alpha, size = hill_form(system)
    return Smooth.of(q.polynomials[0], q.turn, size, alpha)


@compiled
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_bit_is_that_of_the_models_arithmetic(name: str) -> None:
    part = SYSTEMS[name].part(slice(None))
    fast, slow = smooth_form(part), in_numpy(part)
    assert fast is not None and fast.period == slow.period
    assert np.array_equal(fast.terms[: len(slow.terms)], slow.terms) and not np.any(fast.terms[len(slow.terms) :])
    for field in ("size", "alpha", "rung"):
        assert np.array_equal(getattr(fast, field), getattr(slow, field)), field


@pytest.mark.parametrize("name", SYSTEMS)
def test_in_fractions_a_tape_is_the_exact_form(name: str) -> None:
    part = SYSTEMS[name].part(np.arange(4, N, N // 5))
    assert part.equation is not None
    tape = recorded(part.equation)
    assert tape is not None
    exact = SYSTEMS[name].part(np.arange(4, N, N // 5), exact=True)
    d, k = exact.damping, exact.stiffness
    assert d is not None and k is not None
    q, alpha, size = polynomial(d, k), mean_growth(d), term_size(d, k)
    for i in range(2):
        inputs = {k: Fraction(np.broadcast_to(v, 5)[i].item()) for k, v in part.equation.parameters.items()}
        found = tape.program.run(inputs, exact=True)
        expected = [*np.broadcast_to(q.coefficients, (5, *q.coefficients.shape[1:]))[i, 0, :, 0, 0]]
        expected += [np.broadcast_to(size, 5)[i], np.broadcast_to(alpha, 5)[i]]
        assert found == expected


@compiled
def test_one_key_has_a_tape_for_each_set_of_zeros() -> None:
    """Systems in turn, of one model, with zeros in other places: none runs on another's tape."""
    lock, mu = np.linspace(3.0, 9.0, N), np.linspace(0.1, 1.0, N)
    values = [(0.0, 0.3), (0.2, 0.0), (0.0, 0.0), (0.2, 0.3), (mu, 0.3), (np.zeros(N), np.full(N, 0.3)), (1.0, 1.0)]
    for offset, coupling in values * 2:
        some = flapping(Rotor(lock_number=lock, hinge_stiffness=offset, pitch_flap_coupling=coupling), mu)
        fast = smooth_form(some.part(slice(None)))
        assert fast is not None and np.array_equal(fast.terms, in_numpy(some).terms)
    keys = [flapping(Rotor(lock_number=8.0), mu, exact_offset=exact).equation.key for exact in (True, False)]  # type: ignore[union-attr]
    assert keys[0] != keys[1]


@compiled
@pytest.mark.parametrize("options", [{"reversed_flow": True}, {}])
def test_what_depends_on_values_is_left_to_numpy(options: dict[str, Any]) -> None:
    """Kinks, and one blade with a root cutout among others, whose bits stay as they are."""
    rotor = drawn(("lock_number", "hinge_offset"), 8)
    cutout = np.zeros(N)
    cutout[7] = 0.0 if options else 0.3
    mu = np.linspace(0.0, 1.0, N)
    system = flapping(Rotor(**rotor, root_cutout=cutout), mu, **options)
    assert smooth_form(system.part(slice(None))) is None
    if not options:
        found, alone = stability(system), stability(flapping(Rotor(**rotor), mu))
        others = np.arange(N) != 7
        assert np.array_equal(found.exponents[others], alone.exponents[others])
        assert abs(found.exponents[7] - alone.exponents[7]).max() > 1e-6


def test_symbols_cannot_be_compared() -> None:
    x = Record().input("x")
    tests: tuple[Callable[[], Any], ...] = (
        lambda: x > 0, lambda: x == x, lambda: float(x), lambda: x**2, lambda: np.maximum(np.array([x]), 0),
    )  # fmt: skip
    for test in tests:
        with pytest.raises(UntraceableError):
            test()


# ---------------------------------------------------------------------- random arithmetic
OPERATIONS = (operator.add, operator.sub, operator.mul, operator.truediv, operator.neg, abs)
INPUTS = ("a", "b", "c", "d", "e", "f")


def random_arithmetic(
    rng: np.random.Generator, steps: int = 60
) -> Callable[[dict[str, Any], Callable[[Any], Any]], list[Any]]:
    """Seven results of some operations on inputs and constants; the same ones for whatever numbers."""
    constants = [Fraction(int(n), int(d)) for n, d in zip(rng.integers(-4, 5, 5), (1, 2, 3, 4, 7), strict=True)]
    plan = [(rng.integers(len(OPERATIONS)), rng.random(2)) for _ in range(steps)]

    def run(inputs: dict[str, Any], number: Callable[[Any], Any]) -> list[Any]:
        values: list[Any] = [*inputs.values(), *(number(c) for c in constants)]
        for which, places in plan:
            x, y = (values[int(p * len(values))] for p in places)
            operation = OPERATIONS[which]
            if operation is operator.truediv:
                y = abs(y) + number(Fraction(1))  # not zero
                values.append(x / y)
            else:
                values.append(operation(x) if which > 3 else operation(x, y))
            if len(values) % 9 == 0:
                values.append(values[-1] / (abs(values[-1]) + number(Fraction(1))))  # not large
        return values[-7:]

    return run


@pytest.mark.parametrize("seed", range(60))
def test_random_arithmetic_survives_recording(seed: int) -> None:
    """Shared, folded and renamed values in rows that are used again, uniform or not: the bits of plain doubles."""
    rng = np.random.default_rng(seed)
    run = random_arithmetic(rng)
    points = {name: rng.normal(size=300) for name in INPUTS}
    kinds = rng.integers(0, 4, len(INPUTS))  # varying, uniform, zero, one
    for name, kind in zip(INPUTS, kinds, strict=True):
        if kind:
            points[name][:] = (0.0, rng.normal(), 0.0, 1.0)[kind]
    record = Record()
    symbols = {
        name: record.input(name) if kind < 2 else record.number(kind - 2)
        for name, kind in zip(INPUTS, kinds, strict=True)
    }
    results = [record.place(value) for value in run(symbols, record.number)]
    tape = program(record, results, [n for n, k in zip(INPUTS, kinds, strict=True) if k == 0])
    with np.errstate(all="ignore"):
        expected = run(points, lambda c: np.full(300, float(c)))
        found = tape.run(points)
    for x, y in zip(found, expected, strict=True):
        assert np.array_equal(np.broadcast_to(x, 300), y, equal_nan=True)
    if available():
        from floquet.kernels.form import hill_terms

        rows = np.array([points[name] for name in tape.varying]).reshape(-1, 300)
        terms, others, _ = hill_terms(tape, rows, [points[name][0] for name in tape.uniform], 1.0)
        assert np.array_equal([*terms, *others], expected, equal_nan=True)


def test_equal_operations_are_one_and_nothing_idle_is_kept() -> None:
    record = Record()
    x, y = record.input("x"), record.input("y")
    _ = x / y
    tape = program(record, [record.place((x + y) * (y + x) - 0 * y + 1 * x)], ["x", "y"])
    assert len(tape.steps) == 3 and tape.rows <= 4 and len(tape.constants) == 0
