"""Certificates: every ball holds the truth, every verdict is a theorem, and what is cut off is bounded.

The truth is 30 digits computed without the package (data/reference), closed forms, and systems built backwards.
"""

from __future__ import annotations

import importlib.util
import json
import math
import sys
import tomllib
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.special import mathieu_a, mathieu_b

pytest.importorskip("flint")

from flint import acb, acb_poly, arb, arb_mat, ctx

from floquet.certify import (
    Certificate,
    certified_constant,
    certified_hill,
    certified_system,
    certify,
    companion,
    discs,
    exact,
    result,
    scalar,
    series,
    systems,
)
from floquet.errors import InputError, ParameterError
from floquet.exponents import Reason, Verdict, stability
from floquet.models import flapping, multiblade, teetering, textbook, tip_path_plane
from floquet.rotor import Hub, Rotor
from tests.truth import problems, taylor

REFERENCE = Path(__file__).parent.parent / "data" / "reference"
EXPONENTS = json.loads((REFERENCE / "exponents.json").read_text())["cases"]
ORACLE = json.loads((REFERENCE / "floquet_oracle.json").read_text())["cases"]
TRANSITIONS = json.loads((REFERENCE / "transitions.json").read_text())
TEXTBOOK = tomllib.loads((REFERENCE / "textbook.toml").read_text())
STORED = 1e-27  # the references' own accuracy: agreement of two resolutions
F = Fraction


def program() -> ModuleType:
    """data/reference/certified.py, the coefficients stated again in fractions."""
    spec = importlib.util.spec_from_file_location("certified", REFERENCE / "certified.py")
    assert spec is not None and spec.loader is not None
    module = sys.modules.setdefault("certified", importlib.util.module_from_spec(spec))
    if not hasattr(module, "Case"):
        spec.loader.exec_module(module)
    return module


certified = program()


def outside(found: Certificate, wanted: Iterable[Sequence[Any]], *, strip: float = 0.0) -> float:
    """How far the exponents ``wanted`` [re, im] (30 digits) lie outside their balls, and outside the floats' discs."""
    worst = -math.inf
    with mp.workdps(60):
        left = [mp.mpc(mp.mpf(str(re)), mp.mpf(str(im))) for re, im in wanted]
        for (re, im), z, radius in zip(found.balls, found.exponents, found.radii, strict=True):
            middle, spread = _read(re), _read(im)
            distances = [_apart(w, mp.mpc(middle[0], spread[0]), strip) for w in left]
            i = min(range(len(left)), key=lambda i: float(distances[i].real ** 2 + distances[i].imag ** 2))
            d = distances[i]
            near = abs(_apart(left.pop(i), mp.mpc(z), strip)) - mp.mpf(radius)
            worst = max(worst, float(abs(d.real) - middle[1]), float(abs(d.imag) - spread[1]), float(near))
    assert not left
    return worst


def _apart(a: Any, b: Any, strip: float) -> Any:
    d = a - b
    return mp.mpc(d.real, d.imag - strip * mp.nint(d.imag / strip)) if strip else d


def _read(ball: str) -> tuple[Any, Any]:
    """Midpoint and radius of a printed ball."""
    parts = ball.strip("[]").split(" +/- ")
    if ball.startswith("[+/- "):
        return mp.mpf(0), mp.mpf(ball[5:-1])
    return mp.mpf(parts[0]), mp.mpf(parts[1]) if len(parts) > 1 else mp.mpf(0)


# ---------------------------------------------------------------------- one equation against 30 digits
@pytest.mark.parametrize("kind", ["random", "near_branch", "reversed_flow"])
def test_balls_hold_the_stored_exponents(kind: str) -> None:
    for case in (c for c in EXPONENTS if c["set"] == kind):
        p, options = case["parameters"], case["options"]
        values = tuple(p.get(name, 1.0) for name in certified.NAMES)
        exactly = options["exact_offset"] or options["reversed_flow"]  # reversed flow is exact in ε there
        given = certified.Case(values, exact_offset=exactly, reversed_flow=options["reversed_flow"])
        found = certified.certificate(given, 20, p["offset_mass_ratio"])
        assert outside(found, case["exponents"]) < STORED, case["id"]
        assert max(found.radii) < 1e-14  # one rounding of numbers up to 20
        assert found.locked == (case["lock"] is not None)
        growth = max(float(re) for re, _ in case["exponents"])
        assert found.verdict == (Verdict.UNSTABLE if growth > 0 else Verdict.STABLE)
        assert abs(found.discriminant - float(case["discriminant"])) <= found.discriminant_radius * (1 + 1e-12)


@pytest.mark.parametrize("case", ORACLE, ids=lambda case: f"{case['kind']}-{case['id']}")
def test_balls_hold_the_oracle(case: dict[str, Any]) -> None:
    strip = {"i": 1.0, "2i": 2.0, "3i": 3.0, "4i": 4.0, "5i": 5.0}[case["exponent_mod"]]
    found = oracle_certificate(case)
    assert outside(found, case["exponents"], strip=strip) < STORED
    if case["kind"] != "multiblade" and case.get("rotation_number"):
        assert abs(found.exponents[0].imag - float(case["rotation_number"])) <= found.radii[0] + 1e-16


def oracle_certificate(case: dict[str, Any]) -> Certificate:
    p = case["params"]
    if case["kind"] == "mathieu":
        return certified_hill([F(p["damping"])], [F(p["a"]), -2 * F(p["q"]), 0], F(1))
    if case["kind"] == "meissner":
        k = [[F(p["delta"]) + F(p["e"])], [F(p["delta"]) - F(p["e"])]]
        return certified_hill([[F(p["damping"])]] * 2, k, F(2), edges=[F(1)])
    eps = F(p.get("eps", 0))
    values = (p["gamma"], eps, p.get("kbeta", 0), p.get("K1", 0), 0, 1, p["mu"])
    given = certified.Case(tuple(map(F, values)), teetering=case["kind"] == "teetering")
    m = 3 * eps / 2 / (1 - eps if p.get("eMI") == "uniform_exact" else 1)
    if case["kind"] == "multiblade":
        return certified.multiblade(given, case["N"], 20, m)
    return certified.certificate(given, 20, m)


@pytest.mark.parametrize("case", TEXTBOOK["cases"], ids=lambda case: f"{case['problem']}-{case['exponents'][0][0][:7]}")
def test_balls_hold_the_textbook(case: dict[str, Any]) -> None:
    p, T = case.get("parameters", {}), {"2pi": F(2), "pi": F(1), "pi/2": F(1, 2)}[case["period"]]
    if case["problem"] == "hill_sawtooth":
        pytest.skip("a sawtooth is no trigonometric polynomial")
    if case["problem"] == "mathieu":
        found = certified_hill([F(p["damping"])], [F(p["a"]), -2 * F(p["q"]), 0], T)
    elif case["problem"] == "meissner":
        k = [[F(p["mean"]) - F(p["depth"])], [F(p["mean"]) + F(p["depth"])]]
        found = certified_hill([[F(p["damping"])]] * 2, k, T, edges=[F(1, 3)])
    elif case["problem"] == "flapping":
        given = certified.Case((float(p["gamma"]), 0.0, 0.0, 0.0, 0.0, 1.0, float(p["mu"])))
        found = certified.certificate(given)
    else:
        base = {"zhou_hagiwara": F(1, 2)}.get(case["problem"], T)
        found = certified_system(first_order(case["problem"], p), T, base=base)
    stored = 1e-24 if case["problem"] == "rotating_frame" else STORED  # 25 digits are given of that one
    assert outside(found, case["exponents"], strip=2.0 / float(T)) < stored
    worst = max(float(re) for re, _ in case["exponents"])
    neutral = Reason.NEUTRAL if case["problem"] == "mathieu" else Reason.BOUND
    verdict = {-1: Verdict.STABLE, 0: Verdict.UNDECIDED, 1: Verdict.UNSTABLE}[int(np.sign(worst))]
    assert (found.verdict, found.reason) == (verdict, neutral if worst == 0 else Reason.NONE)


def first_order(problem: str, parameters: dict[str, Any]) -> list[Any]:
    if problem == "colaneri":
        return [[[0, 1], [0, -24]], [[0, 0], [-10, 0]], [[0, 0], [0, -10]]]
    if problem == "bittanti_colaneri":
        return [[[-1, 0], [1, -3]], [[0, 0], [-1, 0]], [[1, 0], [0, 0]]]
    if problem == "zhou_hagiwara":
        return [[[-1.5, 2], [-2, -1.5]], [[0.5, 0], [0, -0.5]], [[0, -0.5], [-0.5, 0]]]
    return rotating([[F(x) for x in row] for row in parameters["F"]], parameters["turns"])


def rotating(matrix: list[list[Fraction]], turns: Sequence[int]) -> list[Any]:
    """A(t) = J + e^{Jt} F e^{-Jt} by harmonics: Φ(2π) = e^{2πF} exactly."""
    n = len(matrix)
    one, zero = [F(1)], [F(0)]

    def turned(i: int, j: int) -> Any:
        if i // 2 != j // 2:
            return zero
        w = turns[i // 2]
        order, sign = abs(w), (1 if w >= 0 else -1) * (1 if i < j else -1)
        if order == 0:
            return one if i == j else zero
        return certified.wave(order, 1, 0) if i == j else certified.wave(order, 0, sign)

    entries = [[[F(0)] for _ in range(n)] for _ in range(n)]
    for i in range(n):
        for j in range(n):
            near = ((k, m) for k in (i - i % 2, i - i % 2 + 1) for m in (j - j % 2, j - j % 2 + 1))
            terms = [certified.scaled(matrix[k][m], certified.times(turned(i, k), turned(j, m))) for k, m in near]
            own = F(turns[i // 2]) * (1 if i < j else -1) if i // 2 == j // 2 and i != j else F(0)
            entries[i][j] = certified.added([own], *terms)
    order = max(len(w) for row in entries for w in row)
    return [[[w[h] if h < len(w) else F(0) for w in row] for row in entries] for h in range(order)]


def test_balls_hold_what_another_integrator_finds_to_45_digits() -> None:
    """Radii are a few units of the 45th digit, the integrator's error 1e-50: no slack hides a wrong bound."""
    rng = np.random.default_rng(5)
    for exact_offset, reversed_flow in ((False, False), (True, True)):
        gamma, eps, kappa, K1, mu = rng.uniform([2, 0.01, 0, -0.5, 1.1], [24, 0.2, 0.5, 0.5, 1.5]).tolist()
        given = certified.Case((gamma, eps, kappa, K1, 0.0, 1.0, mu), False, exact_offset, reversed_flow)
        found = certified.certificate(given, 45)
        with mp.workdps(70):
            pieces = problems.flapping(
                gamma, mu, eps=eps, kappa=kappa, K1=K1, m=1.5 * eps, exact_offset=exact_offset,
                reversed_flow=reversed_flow,
            )  # fmt: skip
            truth = taylor.scalar_exponents(pieces, order=80, steps=40)
            wanted = [(mp.nstr(z.real, 60), mp.nstr(z.imag, 60)) for z in truth.exponents]
        assert outside(found, wanted) < 1e-49
        assert max(float(_read(b)[1]) for pair in found.balls for b in pair) < 1e-45


# ---------------------------------------------------------------------- the branch
@pytest.mark.parametrize("k", [F(1, 100), F(9, 10), 30, 400, -2])
@pytest.mark.parametrize("period", [F(1, 2), F(2), F(14, 3), 3.0])
def test_whole_turns_are_counted(k: Fraction, period: Any) -> None:
    """A wave of 1e-6 moves exponents by less than its size; without it the rotation number is √k."""
    small = certified_hill([0], [k, F(1, 10**6), 0], period, base=period)
    constant = certified_hill([0], [k], period)
    assert abs(small.exponents[0] - constant.exponents[0]) < 2e-6
    assert constant.exponents[0].imag == pytest.approx(math.sqrt(max(k, 0)), abs=1e-15)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 12])
def test_every_lock_has_its_rotation_number(order: int) -> None:
    """In the middle of Mathieu's tongues, from SciPy's boundaries, at a q where each is wide."""
    q = 0.5 * order**2
    middle = 0.5 * float(mathieu_a(order, q) + mathieu_b(order, q))
    found = certified_hill([F(1, 100)], [middle, -2 * q, 0], F(1))
    assert found.locked and [z.imag for z in found.exponents] == [order, order]


def test_damping_that_jumps_kicks_the_hill_form() -> None:
    """d = 1 then 0 over π each, k constant: the product of two matrix exponentials."""
    found = certified_hill([[1], [0]], [[2], [2]], F(2), edges=[F(1)])
    with mp.workdps(50):
        first, second = (mp.expm(mp.pi * mp.matrix([[0, 1], [-2, -d]])) for d in (1, 0))
        phi = second * first
        values = mp.eig(phi, left=False, right=False)
        wanted = [(mp.log(z).real / (2 * mp.pi), mp.log(z).imag / (2 * mp.pi)) for z in values]
        assert outside(found, [(mp.nstr(a, 45), mp.nstr(b, 45)) for a, b in wanted], strip=1.0) < 1e-40
    assert found.exponents[0].imag == pytest.approx((math.sqrt(1.75) + math.sqrt(2.0)) / 2, abs=0.02)  # the mean rate


def test_pieces_of_one_polynomial_are_that_polynomial() -> None:
    d, k = [F(1, 3), F(1, 5), 1], [2, F(1, 2), 0, F(1, 7), -1]
    whole = certified_hill(d, k, F(2), digits=30)
    cut = certified_hill([d] * 3, [k] * 3, F(2), edges=[0.7, lambda: arb.pi() / 3 + 1], digits=30)
    assert outside(cut, [[_centre(re), _centre(im)] for re, im in whole.balls]) < 1e-30
    assert whole.locked == cut.locked


def _centre(ball: str) -> str:
    with mp.workdps(60):
        return mp.nstr(_read(ball)[0], 50)


def test_pieces_need_not_repeat_after_the_base() -> None:
    """Each piece has its own polynomial, of a base that is no part of the period; the states have no kicks."""
    d, k = [[1, F(1, 2), F(1, 3)], [F(1, 5), F(-1, 2), 1]], [[2, 1, 0], [1, F(1, 3), F(-1, 2)]]
    options: dict[str, Any] = {"base": F(5, 3), "edges": [1.25], "digits": 25}
    one = certified_hill(d, k, F(1), **options)
    states = [companion([[[x]] for x in a], [[[x]] for x in b]) for a, b in zip(d, k, strict=True)]
    other = certified_system(states, F(1), **options)
    assert outside(other, [[_centre(a), _centre(b)] for a, b in one.balls], strip=2.0) < 1e-25


def test_harmonics_of_a_longer_base_are_the_same_equation() -> None:
    one = certified_hill([F(1, 2)], [1, F(1, 3), F(1, 4)], F(1), digits=30)
    other = certified_hill([F(1, 2)], [1, 0, 0, F(1, 3), F(1, 4)], F(1), base=F(2), digits=30)
    assert one.balls == other.balls
    double = certified_hill([0.5], [1, F(1, 3), F(1, 4)], math.pi)  # the double, not π
    assert abs(double.exponents[0] - one.exponents[0]) < 1e-15


# ---------------------------------------------------------------------- verdicts as theorems
@pytest.mark.parametrize("entry", TEXTBOOK["mathieu_boundaries"]["values"], ids=lambda e: f"{e['name']}({e['q']})")
def test_mathieu_boundaries_are_proven_to_20_digits(entry: dict[str, str]) -> None:
    """D changes sign within 1e-20 of the boundary: undamped, one side is neutral and the other grows."""
    sides = [
        certified_hill([0], [F(entry["value"]) + x, -2 * F(entry["q"]), 0], F(1)) for x in (-F(1, 10**20), F(1, 10**20))
    ]
    assert {side.locked for side in sides} == {True, False}
    for side in sides:
        assert side.verdict == (Verdict.UNSTABLE if side.locked else Verdict.UNDECIDED)
        assert side.reason == (Reason.NONE if side.locked else Reason.NEUTRAL)
        assert side.exponents[0].imag == pytest.approx(int(entry["name"][1:]), abs=1e-6)


@pytest.mark.parametrize("key", [k for k in TRANSITIONS if ":" in k and "instability_mu" in TRANSITIONS[k]][:12])
def test_growth_begins_where_the_transitions_say(key: str) -> None:
    model, family, gamma = key.split(":")
    options = {"fig6": (0, 0, 0), "fig7": ("0.15", 0, 0), "fig8": (0, "0.225", 0), "fig9": (0, 0, "0.225")}
    eps, kappa, K1 = options.get(family, (0, 0, family.removeprefix("K1=")))
    for step, verdict in ((-1e-9, Verdict.STABLE), (1e-9, Verdict.UNSTABLE)):
        values = (gamma, eps, kappa, K1, 0, 1, TRANSITIONS[key]["instability_mu"] + step)
        given = certified.Case(tuple(map(F, values)), teetering=model == "teeter")
        assert certified.certificate(given).verdict == verdict


def test_coexistence_is_on_the_edge_and_damped_it_is_stable() -> None:
    """k = 1 then 4 over π each: Φ = -I exactly, D = 0 at any precision."""
    undamped = certified_hill([[0], [0]], [[1], [4]], F(2), edges=[F(1)])
    assert undamped.locked is None and (undamped.verdict, undamped.reason) == (Verdict.UNDECIDED, Reason.BOUND)
    assert outside(undamped, [["0", "1.5"], ["0", "1.5"]]) <= 0
    assert max(undamped.radii) < 1e-120  # D is as small as the square of an error where Φ = ±I
    c = F(1, 5)
    damped = certified_hill([[c], [c]], [[1 + c * c / 4], [4 + c * c / 4]], F(2), edges=[F(1)])
    assert damped.locked is None and damped.verdict == Verdict.STABLE
    assert outside(damped, [["-0.1", "1.5"], ["-0.1", "1.5"]]) <= 0


def test_edge_at_low_precision_is_honest() -> None:
    """1e-20 from a boundary 64 bits cannot tell: both exponents are still in the balls."""
    value, q = F(TEXTBOOK["mathieu_boundaries"]["values"][2]["value"]), F(1)
    for shift in (-F(1, 10**22), F(1, 10**22)):
        blind = certified_hill([0], [value + shift, -2 * q, 0], F(1), limit=64)
        sharp = certified_hill([0], [value + shift, -2 * q, 0], F(1), digits=40)
        assert blind.locked is None and sharp.locked is not None and blind.verdict == Verdict.UNDECIDED
        assert outside(blind, [[_centre(a), _centre(b)] for a, b in sharp.balls], strip=2.0) <= 0
        assert blind.radii[0] < 1e-6  # the root of 64 bits less what panels lose


def test_edge_that_may_grow_is_undecided() -> None:
    """Damping of 1e-12 beside a boundary: 64 bits cannot tell an exponent of -1e-12 from one of 1e-8."""
    boundary, d = F(TEXTBOOK["mathieu_boundaries"]["values"][2]["value"]), F(2, 10**12)
    for shift in (-F(1, 10**17), F(1, 10**17)):
        k = [boundary + shift + d * d / 4, -2, 0]
        blind, sharp = certified_hill([d], k, F(1), limit=64), certified_hill([d], k, F(1))
        assert blind.locked is None and (blind.verdict, blind.reason) == (Verdict.UNDECIDED, Reason.BOUND)
        assert sharp.verdict == (Verdict.UNSTABLE if sharp.locked else Verdict.STABLE)


def test_damping_that_may_be_zero_is_not_neutral() -> None:
    """d = 1 then -1, and an edge known to 1e-30: what is not proven is not said."""
    edges = [lambda: arb.pi() + arb(0, arb(10) ** -30)]
    found = certified_hill([[1], [-1]], [[2], [2]], F(2), edges=edges, limit=200)
    assert found.locked is False and (found.verdict, found.reason) == (Verdict.UNDECIDED, Reason.BOUND)
    assert max(found.radii) < 1e-16


@pytest.mark.parametrize(("a", "q"), [(-300, 50), (10, 1000), (0, 500)])
def test_strong_locks_keep_both_exponents(a: int, q: int) -> None:
    found = certified_hill([2], [a + 1, -2 * q, 0], F(1), digits=30)
    assert found.discriminant > 1e24 and found.locked and found.verdict == Verdict.UNSTABLE
    assert found.exponents[0].real + found.exponents[1].real == pytest.approx(-2.0, abs=1e-14)  # Liouville
    with mp.workdps(110):  # det Φ loses 50
        truth = taylor.scalar_exponents(problems.mathieu(a + 1, q, 2), order=90, steps=120)
        wanted = [(mp.nstr(z.real, 45), mp.nstr(z.imag, 45)) for z in truth.exponents]
    assert outside(found, wanted) < 1e-38


def test_constant_coefficients_are_decided_exactly() -> None:
    oscillating = certified_hill([0], [1], F(2))  # Φ = I over this period
    assert oscillating.exponents == (1j, -1j) and oscillating.radii == (0.0, 0.0)
    assert (oscillating.verdict, oscillating.reason, oscillating.locked) == (Verdict.UNDECIDED, Reason.NEUTRAL, False)
    double = certified_hill([1], [F(1, 4)], F(2))
    assert double.exponents == (-0.5, -0.5) and double.locked is None and double.verdict == Verdict.STABLE
    assert double.multiplicities == (2, 2) and oscillating.multiplicities == (1, 1)
    saddle = certified_hill([0], [-1], F(2))
    assert saddle.exponents == (1, -1) and saddle.locked and saddle.verdict == Verdict.UNSTABLE
    drift = certified_hill([0], [0], F(2))
    assert (drift.verdict, drift.reason) == (Verdict.UNDECIDED, Reason.BOUND)
    assert "stable" in saddle.theorem and "bounded" in oscillating.theorem and "undecided" in drift.theorem


def test_damping_of_zero_mean_is_neutral() -> None:
    found = certified_hill([0, 0, F(1, 2)], [2, F(1, 3), 0], F(2))
    assert (found.verdict, found.reason) == (Verdict.UNDECIDED, Reason.NEUTRAL)
    assert [z.real for z in found.exponents] == [0.0, 0.0]


# ---------------------------------------------------------------------- systems
@pytest.mark.parametrize("size", [2, 4])
def test_jordan_blocks_share_a_ball(size: int) -> None:
    matrix = [[F(-1, 4) if i == j else F(int(j == i + 1)) for j in range(size)] for i in range(size)]
    found = certified_system(rotating(matrix, [1, 2][: size // 2]), F(2), digits=12)
    assert found.multiplicities == (size,) * size and found.verdict == Verdict.STABLE
    assert outside(found, [["-0.25", "0"]] * size) <= 0 and max(found.radii) < 1e-12


def test_neutral_jordan_block_is_undecided() -> None:
    found = certified_system(rotating([[F(0), F(1)], [F(0), F(0)]], [1]), F(2), limit=256)
    assert (found.verdict, found.reason) == (Verdict.UNDECIDED, Reason.BOUND)
    assert outside(found, [["0", "0"]] * 2) <= 0


def test_double_exponents_beside_simple_ones() -> None:
    values = [F(-1, 4), F(-1, 4), F(1, 8), F(-8)]
    matrix = [[values[i] if i == j else F(0) for j in range(4)] for i in range(4)]
    found = certified_system(rotating(matrix, [1, -2]), F(2))
    assert sorted(found.multiplicities) == [1, 1, 2, 2] and found.verdict == Verdict.UNSTABLE
    assert outside(found, [[str(float(x)), "0"] for x in values]) <= 0


def test_multipliers_65_decades_apart() -> None:
    found = certified_system(first_order("colaneri", {}), F(2), limit=300)
    assert outside(found, [["0", "0"], ["-24", "0"]]) <= 0 and max(found.radii) < 1e-20
    assert (found.verdict, found.reason) == (Verdict.UNDECIDED, Reason.BOUND)  # the multiplier 1 is exact


def test_a_scalar_equation_as_a_system() -> None:
    d, k = [F(1, 3), F(1, 5), 1], [2, F(1, 2), 0, F(1, 7), -1]
    scalar_one = certified_hill(d, k, F(2), digits=25)
    states = companion([[[x]] for x in d], [[[x]] for x in k])
    for options in ({}, {"edges": [2.5]}):
        A = [states, states] if options else states
        found = certified_system(A, F(2), digits=25, **options)
        assert outside(found, [[_centre(a), _centre(b)] for a, b in scalar_one.balls], strip=1.0) < 1e-25


def test_negative_multipliers_are_real() -> None:
    """A lock of ½ per period: the logarithm has π exactly, on the branch of +π."""
    one = certified_hill([F(2, 5)], [1, F(-1, 5), 0], F(1))
    found = certified_system(companion([[[F(2, 5)]]], [[[1]], [[F(-1, 5)]], [[0]]]), F(1))
    assert [z.imag for z in found.exponents] == [1.0, 1.0]
    assert [z.real for z in found.exponents] == pytest.approx([z.real for z in one.exponents], abs=1e-16)


def test_double_negative_multiplier() -> None:
    """A cluster across the cut of the logarithm: Λ = -exp(-π/2) twice."""
    found = certified_system([[[F(-1, 4), F(1, 2)], [F(-1, 2), F(-1, 4)]]], F(2))
    assert found.multiplicities == (2, 2) and found.verdict == Verdict.STABLE and max(found.radii) < 1e-19
    assert outside(found, [["-0.25", "0.5"]] * 2, strip=1.0) <= 0


def test_precision_is_raised_for_the_verdict() -> None:
    """-1e-40 beside -1: ten digits are reached at once, the sign is not."""
    found = certified_system(rotating([[F(-1, 10**40), F(0)], [F(0), F(-1)]], [1]), F(2), digits=10)
    assert found.verdict == Verdict.STABLE and found.bits > 128


def test_guesses_are_proven_or_put_together() -> None:
    with ctx.workprec(100):
        p = acb_poly([as_ball(F(11, 10)), as_ball(F(-21, 10)), acb(1)])  # (z - 1)(z - 1.1)
        assert discs._pellet(p, [acb(1.04)]) is None and discs._pellet(p, [acb(1.0)]) is not None
        both = discs._pellet(p, [acb(1.04), acb(1.05)])
        assert both is not None and both.zeros == 2 and both.radius < 0.5
        near, far = discs._Disc(acb(0, 0.1), arb(0.15), 1), discs._Disc(acb(0, -0.2), arb(0.01), 1)
        assert not near.meets(far) and near.meets(far._replace(radius=arb(0.16))) and near.meets(near)
        assert not discs._ball(near, [near, far]).imag.is_zero()  # its conjugate may be the other
        assert discs._ball(near, [near]).imag.is_zero()
        assert not discs._ball(near._replace(zeros=2), [near]).imag.is_zero()
        assert [z.imag.is_zero() for z, _ in discs.enclosed_eigenvalues(arb_mat([[1, 2], [3, 4]]))] == [True, True]


def as_ball(x: Fraction) -> acb:
    return acb(exact.ball(x))


@pytest.mark.parametrize("matrix", [[[1, 1], [0, 1]], [[2, 0], [0, 2]], [[0, 1], [-1, 0]], [[1, 5], [0, 3]]])
def test_discs_hold_the_eigenvalues(matrix: list[list[int]]) -> None:
    wanted = np.linalg.eigvals(np.array(matrix, float))
    with ctx.workprec(128):
        found = discs.enclosed_eigenvalues(arb_mat(matrix))
        assert sum(m for _, m in found) == 2
        for z in wanted:
            assert any(abs(ball - acb(complex(z).real, complex(z).imag)) < arb(10) ** -15 for ball, _ in found)


def test_companion_cubed_root() -> None:
    """(η + 1)³: a Jordan block of three; eigenvalues of a constant system."""
    found = certified_constant([[0, 1, 0], [0, 0, 1], [-1, -3, -3]])
    assert outside(found, [["-1", "0"]] * 3) <= 0 and found.multiplicities == (3, 3, 3) and max(found.radii) < 1e-20


# ---------------------------------------------------------------------- what is cut off
@pytest.mark.parametrize("lost", [30, 50, 75])
def test_short_series_widen_the_balls_enough(monkeypatch: pytest.MonkeyPatch, lost: int) -> None:
    """Series cut ``lost`` bits too early: the tail is then all of the radius, and must still hold the truth."""
    d, k = [F(1, 3), F(1, 5), 1], [2, F(1, 2), 0, F(1, 7), -1]
    states = companion([[[x]] for x in d], [[[x]] for x in k])
    truth = [[_centre(a), _centre(b)] for a, b in certified_hill(d, k, F(2), digits=40).balls]
    monkeypatch.setattr(series, "GUARD", lost)
    for found, strip in (
        (certified_hill(d, k, F(2), limit=97), 0.0),
        (certified_system(states, F(2), limit=97), 1.0),
    ):
        assert outside(found, truth, strip=strip) <= 0
        size = max(float(_read(b)[1]) for pair in found.balls for b in pair)
        assert 2.0 ** (lost - 110) < size < 2.0 ** (lost - 77)  # of the size of what is cut off, within a few decades


@pytest.mark.parametrize("w", [0.5, 2.0, 2.9])
@pytest.mark.parametrize("terms", [2, 4, 7])
def test_defect_bound_of_a_saddle(monkeypatch: pytest.MonkeyPatch, w: float, terms: int) -> None:
    """y'' = w² y over a panel of half length 1: hyperbolic functions, cut after so many terms."""
    with ctx.workprec(100):
        q = series.Trig(-arb(w) * arb(w), [])
        table = series.weights(abs(q.mean), [], arb(1), arb(1))
        full = scalar._series(scalar._taylor(q, table, arb(0)))
        monkeypatch.setattr(scalar, "_series", lambda f: full[:terms])
        to_centre, to_end = scalar._panel(q, table, arb(0), arb(w))
        grow, slope = arb(w).cosh(), arb(w).sinh()
        for found in (to_centre, to_end):
            for entry, true in zip(found, (grow, slope / w, slope * w, grow), strict=True):
                assert entry.contains(true.mid())
        r = series.tail(map(abs, full[:terms]), table.tails, 2)
        left = sum((abs(u) for u in full[terms - 2 : terms]), arb(0)) * w * w  # the defect's two terms
        assert r.contains(left.mid()) or r > left
        assert float(r) == pytest.approx(float(left), rel=1e-12)
        assert to_end[2].rad() > left * arb(w).cosh() * 0.99  # the bound is not made sharper than it is proven


def test_sum_of_the_defect_term_by_term() -> None:
    """N = 4 terms, T_0 … T_2: the weights of |u_n| are T_2, T_1, T_0, T_0 for order 2 and T_2, T_2, T_1, T_0 for 1."""
    with ctx.workprec(64):
        sizes, tails = [arb(1), arb(10), arb(100), arb(1000)], [arb(7), arb(5), arb(3)]
        assert series.tail(iter(sizes), tails, 2) == 3 + 50 + 700 + 7000
        assert series.tail(iter(sizes), tails, 1) == 3 + 30 + 500 + 7000


def test_growth_of_the_defect_in_a_system(monkeypatch: pytest.MonkeyPatch) -> None:
    """x' = w x cut after two terms: 1 + w at the end of a half panel and 1 - w at its start, for e^w and e^-w."""
    full = systems._series
    monkeypatch.setattr(systems, "_series", lambda f, one: full(f, one)[:2])
    monkeypatch.setattr(systems, "panels", lambda *_: 1)
    with ctx.workprec(100):
        for w in (0.1, 0.3):
            (found,) = systems._factors([arb_mat([[w]])], arb(0), arb(2), arb(1))
            assert found[0, 0].contains(arb(2 * w).exp().mid())
            left = arb(w) * w * arb(w).exp()  # w (w) e^w: the defect's only term, grown
            spread = series.plus_minus(left)
            assert found[0, 0].contains(((1 + arb(w) + spread) / (1 - arb(w) + spread)).mid())
            assert found[0, 0].rad() > 1.99 * left / (1 - w) ** 2  # of the numerator and of the denominator


def test_tails_bound_what_they_stand_for() -> None:
    """T_j against the sum of |f_i|, i ≥ j, for a polynomial with every phase."""
    with ctx.workprec(100):
        half = arb(0.7)
        q = series.Trig.of([F(1, 2), 1, F(-1, 3), 0, 2, F(1, 4), F(1, 4)])
        table = series.weights(abs(q.mean), q.sizes(), half, half * half)
        for centre in (0.0, 0.4, 2.0):
            f = scalar._taylor(q, table, arb(centre))
            for j in range(len(f)):
                assert sum(map(abs, f[j:]), arb(0)) <= table.tails[j]
        assert table.tails[0] < 20 * sum(map(abs, f), arb(0))


def test_floats_are_rounded_outward() -> None:
    with ctx.workprec(120):
        for x in (arb(2).sqrt(), arb(1) / 3, arb(10) ** -400, arb(3, arb(10) ** -30), -arb.pi()):
            middle, radius = result._rounded_real(x)
            assert abs(x - middle) <= radius or arb(radius) >= (x - middle).abs_upper()
        exact_third = result._rounded_real(arb(1) / 3)[1]
        assert exact_third == pytest.approx(1.8504e-17, rel=1e-3)  # the distance from 1/3 to its double
    assert result._rounded_real(arb.nan())[1] != result._rounded_real(arb.nan())[1]


def test_half_panels_that_are_too_long_are_refused() -> None:
    with ctx.workprec(64):
        table = series.weights(arb(9.5), [], arb(1), arb(1))
        with pytest.raises(exact.Unproved):
            scalar._panel(series.Trig(arb(9.5), []), table, arb(0), arb(9.5).sqrt())


def test_whole_turns_are_proven_or_refused() -> None:
    """½ lies between two integers; another path decides, or none."""
    clock = exact.Clock.of(F(2), None)
    with ctx.workprec(64):
        blurred = arb(2.75, 0.01)
        assert float(scalar._lifted(arb(0.25), [blurred, arb(3.0)], clock)) == 3.25
        assert float(scalar._lifted(arb(0.25), [arb.nan(), arb(1.9)], clock)) == 2.25
        with pytest.raises(exact.Unproved):
            scalar._lifted(arb(0.25), [blurred, blurred], clock)


def test_precision_in_force_is_left_alone() -> None:
    before = ctx.prec
    certified_hill([0], [1, F(1, 5), 0], F(1))
    with pytest.raises(ParameterError):
        certified_hill([0], [10.0**12, 1, 0], F(1))
    assert ctx.prec == before


# ---------------------------------------------------------------------- the package's own systems
def rotors(count: int, **options: Any) -> Rotor:
    rng = np.random.default_rng(3)
    low, high = [2, 0, 0, -0.5], [24, 0.2, 0.5, 0.5]
    gamma, eps, kappa, K1 = rng.uniform(low, high, (count, 4)).T
    return Rotor(lock_number=gamma, hinge_offset=eps, hinge_stiffness=kappa, pitch_flap_coupling=K1, **options)


@pytest.mark.parametrize("options", [{}, {"reversed_flow": True, "exact_offset": True}, {"tip_loss": 0.97}])
def test_engine_is_within_its_bound_of_the_balls(options: Any) -> None:
    system = flapping(rotors(8), np.linspace(0.0, 1.5, 8), **options)
    found, proven = stability(system), certify(system)
    for case, c in enumerate(proven):
        distance = np.abs(np.array(c.exponents) - found.exponents[case])
        assert np.all(distance <= found.exponent_errors[case] + np.array(c.radii))
        assert c.verdict == found.verdict[case]
        assert c.locked is (not np.isnan(found.lock[case])) or c.locked is None  # μ = 0 at a double root


@pytest.mark.parametrize(
    "system",
    [
        teetering(Rotor(lock_number=8.0, blades=2, hub=Hub.TEETERING), 0.8),
        textbook.mathieu(1.0, 0.1, 0.4),
        textbook.meissner(1.0, -0.2, 0.4, period=math.pi, fraction=1.0 / 3.0),
        textbook.colaneri(),
        textbook.bittanti_colaneri(),
        tip_path_plane(Rotor(lock_number=8.0, hinge_offset=0.05), 0.3),
    ],
    ids=lambda system: system.name,
)
def test_every_kind_of_system_has_a_certificate(system: Any) -> None:
    found, (proven,) = stability(system), certify(system, limit=256)
    strip = 1e9 if system.constant else 2.0 * math.pi / system.period
    assert_close(proven, found.exponents, float(np.max(found.exponent_errors)), strip)
    assert proven.verdict in (found.verdict, Verdict.UNDECIDED)


def test_functions_have_no_certificate() -> None:
    with pytest.raises(ParameterError, match="nothing can be proven of it: give the coefficients"):
        certify(textbook.hill_sawtooth(1.0, 0.2))


@pytest.mark.parametrize("blades", [3, 4])
@pytest.mark.parametrize("mu", [0.3, 0.8])
def test_identical_blades_have_one_certificate(blades: int, mu: float) -> None:
    """μ = 0.8 is in a lock: real exponents of the blade at ρ = 1."""
    system = multiblade(Rotor(lock_number=8.0, hinge_offset=0.05, blades=blades), [mu, 0.1])
    found, proven = stability(system), certify(system)
    (one,) = certify(flapping(Rotor(lock_number=8.0, hinge_offset=0.05), mu))
    assert (proven[0].verdict, proven[0].locked, proven[0].bits) == (one.verdict, one.locked, one.bits)
    assert len(proven[0].exponents) == 2 * blades and proven[0].theorem.startswith(f"{blades} blades")
    for case, c in enumerate(proven):
        assert_close(c, found.exponents[case], np.max(found.exponent_errors[case]), 1.0 * blades)
    given = certified.Case((8.0, 0.05, 0.0, 0.0, 0.0, 1.0, mu))
    m = float(Rotor(lock_number=8.0, hinge_offset=0.05).offset_mass_ratio)
    direct = certified.multiblade(given, blades, 25, m)
    assert outside(proven[0], [[_centre(a), _centre(b)] for a, b in direct.balls], strip=1.0 * blades) < 1e-25
    assert all(abs(z.imag) <= blades / 2 for z in proven[0].exponents)


def test_dissimilar_blades_are_a_system() -> None:
    ones = [Rotor(lock_number=8.0, hinge_offset=0.05)] * 2 + [Rotor(lock_number=9.0, hinge_offset=0.05)]
    (proven,) = certify(multiblade(ones, 0.3))
    (one,), (other,) = certify(flapping(ones[0], 0.3)), certify(flapping(ones[2], 0.3))
    wanted = np.array([*one.exponents, *one.exponents, *other.exponents])
    assert_close(proven, wanted, 1e-14, 1.0)  # coefficients of T are doubles
    assert proven.verdict == Verdict.STABLE


def assert_close(proven: Certificate, values: Any, error: float, strip: float) -> None:
    """Every ball has its value, modulo i·strip."""
    left = list(np.asarray(values))
    for z, radius in zip(proven.exponents, proven.radii, strict=True):
        distance = [complex((w - z).real, math.remainder((w - z).imag, strip)) for w in left]
        i = min(range(len(left)), key=lambda i: abs(distance[i]))
        assert abs(distance[i]) <= radius + error
        left.pop(i)


# ---------------------------------------------------------------------- the reference file
@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    with np.load(REFERENCE / "certified.npz") as file:
        return dict(file)


def test_stored_certificates_are_these(stored: dict[str, Any]) -> None:
    """A few of every kind, computed again; the parameters are the seed's."""
    cases = certified.cases()
    assert len(cases) == len(stored["parameters"]) == 10_000 and tuple(stored["names"]) == certified.NAMES
    assert np.array_equal(stored["parameters"], [c.values for c in cases])
    for i in [*range(0, 40), 9_999]:
        c = certified.certificate(cases[i])
        given = complex(stored["real"][i, 0].sum(), stored["rho"][i].sum())
        assert abs(c.exponents[0] - given) < 1e-15
        assert (c.locked, c.verdict) == (stored["locked"][i] == 1, stored["verdict"][i])
        wanted = [[_sum(stored["real"][i, j]), _sum(stored["rho"][i], -1 if j and not c.locked else 1)] for j in (0, 1)]
        assert outside(c, wanted) <= float(stored["radius"])
    assert stored["radius"] < 1e-25 and stored["multiblade_radius"] < 1e-25
    shares = [np.sum(stored[name]) for name in ("teetering", "exact_offset", "reversed_flow")]
    assert shares == [2500, 1500, 1000]


def _sum(parts: Any, sign: int = 1) -> str:
    with mp.workdps(60):
        return mp.nstr(sign * (mp.mpf(float(parts[0])) + mp.mpf(float(parts[1]))), 50)


def test_stored_pairs_have_the_sum_liouville_asks_for(stored: dict[str, Any]) -> None:
    """Σσ = -mean(d), exactly, wherever no flow is reversed."""
    columns = dict(zip(stored["names"].tolist(), stored["parameters"].T, strict=True))
    chosen = np.flatnonzero(~stored["reversed_flow"])[::7]
    for i in chosen:
        g, e, c, B = (F(float(columns[n][i])) for n in ("lock_number", "hinge_offset", "flap_damping", "tip_loss"))
        if stored["teetering"][i]:
            mean = g / 8
        elif stored["exact_offset"][i]:
            rate = (B**4 - e**4) / 4 - 2 * e * (B**3 - e**3) / 3 + e**2 * (B**2 - e**2) / 2
            mean = c + g / 2 * rate
        else:
            mean = g / 2 * (F(1, 4) - 2 * e / 3 + e**2 / 2)
        total = sum(F(float(x)) for x in stored["real"][i].ravel())
        assert abs(float(total + mean)) < 2 * float(stored["radius"])


def test_stored_rotors_in_multiblade_coordinates(stored: dict[str, Any]) -> None:
    rotors_ = certified.multiblade_cases()
    assert np.array_equal(stored["multiblade_parameters"], [case.values for case, _ in rotors_])
    assert np.array_equal(stored["multiblade_blades"], [blades for _, blades in rotors_])
    assert stored["multiblade_direct"].sum() == certified.DIRECT
    for case, blades in rotors_[4:8]:
        one = certified.certificate(case)
        assert certified.encloses_the_blade(certified.multiblade(case, blades), one, blades)
        other = certified.certificate(case._replace(values=(case.values[0] + 1e-6, *case.values[1:])))
        assert not certified.encloses_the_blade(certified.multiblade(case, blades), other, blades)


# ---------------------------------------------------------------------- refusals
@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: certified_hill([0], lambda t: t, F(1)), "can be sampled but not enclosed"),
        (lambda: certified_system(lambda t: t, F(1)), "can be sampled but not enclosed"),  # type: ignore[arg-type]
        (lambda: certified_hill([0, 1], [1], F(1)), "odd length"),
        (lambda: certified_hill([0], ["1"], F(1)), "not an exact number"),
        (lambda: certified_hill([0], [math.nan], F(1)), "not an exact number"),
        (lambda: certified_hill([0], [1], 2), "is no period"),  # type: ignore[arg-type]
        (lambda: certified_hill([0], [1], -1.0), "is no period"),
        (lambda: certified_hill([0], [1], F(1), base=2.0), "cannot be compared"),
        (lambda: certified_hill([0], [1, 1, 0], F(1), base=F(2)), "harmonic 1 does not repeat after 1/2"),
        (lambda: certified_hill([[0], [0]], [[1]], F(1), edges=[0.5]), "one more piece than edges"),
        (lambda: certified_hill([[0]] * 2, [[1], [2]], F(1), edges=[4.0]), "edges of pieces must rise"),
        (lambda: certified_hill([0], [10.0**12, 1, 0], F(1)), "check the units"),
        (lambda: certified_hill([0], [1], F(1), digits=0), "digits"),
        (lambda: certified_system([[[1, 2]]], F(1)), "not all of its shape"),
        (lambda: certified_system([[[1]]], F(1), twist=[2]), "numbers 1 or -1"),
        (lambda: certified_system([[[0, 1], [1, 0]]], F(1), twist=[1, -1]), "does not repeat"),
        (
            lambda: certified_system([[[-1000, 0], [0, 1]], [[0, 1], [1, 0]], [[0, 0], [0, 0]]], F(2), limit=64),
            "raise limit",
        ),
    ],
)
def test_refusals_are_sentences(call: Any, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        call()


def test_without_flint_there_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("floquet.certify")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "flint", None)
    with pytest.raises(InputError, match=r"install floquet-rotor\[certify\]"):
        importlib.import_module("floquet.certify")


def test_clock_is_exact() -> None:
    clock = exact.Clock.of(F(2, 3), F(2))
    assert clock.turns == F(1, 3) and clock.omega.is_exact() and float(clock.omega) == 1.0
    assert systems.companion([[[1]]], [[[2]]]) == [[[0, 1], [-2, -1]]]
