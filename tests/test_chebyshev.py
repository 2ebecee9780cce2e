"""Maps over tensor grids against points solved one by one: bounds, branch, what falls back, axes of every kind."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from floquet.errors import ParameterError
from floquet.exponents import Stability, Verdict, stability
from floquet.kernels import available
from floquet.kernels.grid import LEFT_OUT, Tile, cardinals, judged, tile_rows, within, zeros_of
from floquet.kernels.hill import ROWS
from floquet.models import flapping, multiblade, teetering
from floquet.models.textbook import mathieu, meissner
from floquet.period_map import Method, PeriodMap, period_map
from floquet.period_map.chebyshev import FIRST, MOST, Attempt, Box, boxes, regions
from floquet.period_map.grid import UNTOUCHED, direct_map, remaining, tiles
from floquet.period_map.hill import hill_map
from floquet.period_map.precise import TOLERANCE, make_precise
from floquet.period_map.tensor import LEAST, Axis, Region, TensorGrid
from floquet.periodic import Equation, PeriodicMatrix, PeriodicSystem
from floquet.rotor import Hub, Rotor
from tests.support import distances
from tests.truth import extended

EPS = float(np.finfo(float).eps)
Array = np.ndarray[Any, Any]


def span(a: float, b: float, n: int) -> Array:
    return np.linspace(a, b, n)


def blades(gamma: Any, mu: Any, **others: Any) -> PeriodicSystem:
    return flapping(Rotor(lock_number=gamma, **others), mu)


def seesaw(gamma: Any, mu: Any, **others: Any) -> PeriodicSystem:
    return teetering(Rotor(lock_number=gamma, blades=2, hub=Hub.TEETERING, **others), mu)


def column(x: Array) -> Array:
    return x[:, None]


def grid_map(system: PeriodicSystem) -> PeriodMap:
    """The map of all cases of one scalar equation."""
    grid, shape = TensorGrid.of(system), system.cases
    n = math.prod(shape)
    rows, alpha = np.empty((len(ROWS), n)), np.empty(n)
    panels, methods = np.zeros(n, np.int32), np.full(n, UNTOUCHED, np.int8)
    for box in (box for region in (regions(grid) if grid else ()) for box in boxes(region)):
        for tile in tiles(box):
            places = (tile.row_places[:, None] + tile.column_places).ravel()
            rows[:, places], alpha[places], kept = tile_rows(tile)
            panels[places] = np.repeat(tile.panels, len(tile.z))
            methods[places] = np.where(kept, Method.MAP, LEFT_OUT)
    for index in remaining(methods):
        phi = direct_map(system, index)
        assert phi.rows is not None and phi.methods is not None
        rows[:, index], alpha[index], panels[index], methods[index] = phi.rows, phi.mean, phi.panels, phi.methods
    return PeriodMap(
        method=Method.MAP, period=system.period, shape=shape, mean=alpha, panels=panels, rows=rows, methods=methods
    )


def compared(system: PeriodicSystem, *, least: float = 0.0) -> Stability:
    """The map of a system, after holding it against points solved directly; ``least`` of them from nodes."""
    found, direct = stability(system, map=True), stability(system)
    bound = found.exponent_errors[..., 0] + direct.exponent_errors[..., 0]
    assert np.mean(found.method == Method.MAP) >= least
    assert np.all(np.isfinite(found.exponents)) and np.all(np.isfinite(found.exponent_errors))
    assert np.all(np.abs(found.exponents - direct.exponents).max(axis=-1) <= bound)
    assert np.all(np.abs(found.rotation_number - direct.rotation_number) <= bound)  # the branch
    surely = bound < 1e-9  # elsewhere a lock of no width may be seen by one of the two
    np.testing.assert_array_equal(np.isnan(found.lock)[surely], np.isnan(direct.lock)[surely])
    np.testing.assert_array_equal(found.verdict[surely], direct.verdict[surely])
    assert found.exponent_errors[found.method != Method.HILL].max(initial=0.0) <= TOLERANCE + 5e-13  # and of α, ρ
    return found


# ---------------------------------------------------------------------- agreement with points solved one by one
@pytest.mark.parametrize(
    "system",
    [
        blades(8.0, span(0.0, 1.0, 9000)),
        blades(column(span(2.0, 16.0, 90)), span(0.0, 1.0, 100)),
        blades(column(span(4.0, 12.0, 90)), 0.4, pitch_flap_coupling=span(-0.5, 0.5, 100)),
        blades(8.0, span(0.0, 1.0, 90), hinge_offset=column(span(0.0, 0.2, 100))),
        blades(6.0, 0.5, hinge_stiffness=column(span(0.0, 1.0, 80)), flap_damping=span(0.0, 0.4, 70)),
        blades(span(4.0, 10.0, 34)[:, None, None], span(0.0, 0.6, 36), hinge_stiffness=column(span(0.0, 0.5, 35))),
        seesaw(column(span(2.0, 16.0, 80)), span(0.0, 1.2, 90)),
        seesaw(9.0, span(0.0, 1.2, 90), pitch_flap_coupling=column(span(-0.4, 0.4, 80))),
        mathieu(column(span(0.0, 10.0, 90)), span(0.0, 5.0, 80)),
        mathieu(column(span(0.2, 8.0, 90)), span(0.0, 3.0, 80), 0.3),
    ],
    ids=["μ", "γ-μ", "γ-K1", "ε-μ", "κ-c", "γ-κ-μ", "teetering", "teetering K1", "mathieu", "damped mathieu"],
)
def test_maps_agree_with_points_solved_one_by_one(system: PeriodicSystem) -> None:
    found = compared(system, least=0.99)
    assert np.quantile(found.exponent_errors, 0.9) <= 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_bounds_hold_on_grids_of_random_ranges(seed: int) -> None:
    """Two parameters of five over random ranges; growth by four decades included."""
    rng = np.random.default_rng([71, seed])
    ranges = {
        "lock_number": (2.0, 24.0),
        "hinge_stiffness": (0.0, 1.5),
        "pitch_flap_coupling": (-0.8, 0.8),
        "hinge_offset": (0.0, 0.2),
        "mu": (0.0, 1.4),
    }
    values: dict[str, Any] = {name: rng.uniform(*limits) for name, limits in ranges.items()}
    first, second = rng.choice(list(ranges), 2, replace=False)
    values[first] = column(np.sort(rng.uniform(*ranges[first], 80)))
    values[second] = np.sort(rng.uniform(*ranges[second], 90))[:: rng.choice([-1, 1])]
    mu = values.pop("mu")
    compared(flapping(Rotor(**values), mu), least=0.5)  # where Φ grows to 1e7, a third has bounds above 1e-11


@pytest.mark.skipif(not extended.available(), reason="long double is no longer than double on this machine")
@pytest.mark.parametrize(("gamma_max", "mu_max"), [(16.0, 1.0), (24.0, 1.5)])
def test_bounds_hold_against_80_bits(gamma_max: float, mu_max: float) -> None:
    """A thousand points of a map against an integration that shares nothing with it."""
    gamma, mu = span(2.0, gamma_max, 250), span(0.0, mu_max, 240)
    found = stability(blades(column(gamma), mu), map=True)
    i, j = np.random.default_rng(9).integers(0, 240, (2, 1000))
    zero = np.zeros(1000)
    expected, _ = extended.exponents(gamma[i], zero, zero, zero, mu[j], zero)
    error = np.array([distances(a, b, 1.0).max() for a, b in zip(found.exponents[i, j], expected, strict=True)])
    bound = found.exponent_errors[i, j].max(axis=-1)
    assert np.all(error <= bound) and np.mean(found.method[i, j] == Method.MAP) > 0.98
    assert np.median(bound) < max(5e-13, 300 * np.median(error))  # rounding at random falls short of rounding added up


def test_bounds_of_the_usual_grid_are_small() -> None:
    """γ 2–16, μ 0–1: 1e-12 nearly everywhere; γ 2–24, μ 0–1.5, where Φ grows to 1e5: in nine of ten points."""
    usual = compared(blades(column(span(2.0, 16.0, 160)), span(0.0, 1.0, 170)), least=0.999).exponent_errors
    assert np.mean(usual <= 1e-12) > 0.98 and np.median(usual) < 2e-13
    wide = compared(blades(column(span(2.0, 24.0, 260)), span(0.0, 1.5, 270)), least=0.97).exponent_errors
    assert np.mean(wide <= 1e-11) > 0.95 and np.median(wide) < 1e-12


def test_branch_is_right_where_the_angle_of_a_solution_leaps() -> None:
    """Strong locks with bands of no width between them, and ten turns a period."""
    compared(mathieu(column(span(-5.0, 30.0, 180)), span(0.0, 20.0, 170)), least=0.85)
    compared(mathieu(column(span(20.0, 100.0, 90)), span(0.0, 10.0, 80)), least=0.99)


def test_regions_are_cut_until_turns_are_known() -> None:
    """Φ to 1e11, where ω itself leaps by half turns in bands of no width."""
    region = whole(mathieu(column(span(-60.0, 60.0, 280)), span(0.0, 40.0, 270)))
    assert not Attempt(region, (40, 32)).turns_known.any()
    found = boxes(region)
    assert len(found) > 1 and all(Attempt(b.region, tuple(map(len, b.nodes))).turns_known.all() for b in found)


def test_rows_are_those_of_points_solved_one_by_one() -> None:
    """Φ, zeros and both bounds, of flapping and teetering."""
    for system in (
        blades(column(span(3.0, 15.0, 70)), span(0.0, 1.1, 80)),
        seesaw(column(span(3.0, 15.0, 70)), span(0.0, 1.1, 80)),
    ):
        found, direct = grid_map(system), period_map(system)
        assert found.rows is not None and direct.rows is not None and found.methods is not None
        assert found.method == Method.MAP and np.mean(found.methods == Method.MAP) > 0.99
        assert np.all(np.abs(found.half_trace - direct.half_trace) <= found.rows[4] + direct.rows[4])
        assert np.all(np.abs(found.discriminant - direct.discriminant) <= found.rows[5] + direct.rows[5])
        np.testing.assert_array_equal(found.rows[6], direct.rows[6])
        np.testing.assert_allclose(found.mean, direct.mean, rtol=8 * EPS)  # twenty weights that add up to 1
        scale = np.abs(direct.rows[:4]).max()
        assert np.abs(found.rows[:4] - direct.rows[:4]).max() < 1e-13 * scale


# ---------------------------------------------------------------------- convergence, and bounds before it
def whole(system: PeriodicSystem) -> Region:
    grid = TensorGrid.of(system)
    assert grid is not None
    return next(regions(grid))


def asked(attempt: Attempt) -> tuple[int, ...]:
    """Nodes wanted at the only place."""
    (wanted,) = attempt.wanted.tolist()
    return tuple(wanted)


def rows_of(box: Box) -> Array:
    """Rows of all points of a box in the order of the cases."""
    parts = [(tile_rows(t)[0], (t.row_places[:, None] + t.column_places).ravel()) for t in tiles(box)]
    out = np.empty((9, box.region.points))
    for rows, places in parts:
        out[:, places] = rows
    return out


def test_errors_fall_spectrally_and_never_beyond_the_bounds() -> None:
    """From 8 to 20 nodes an axis the error falls by nine decades, each four nodes by more than the four before."""
    region = whole(system := blades(column(span(2.0, 12.0, 64)), span(0.0, 0.8, 66)))
    direct, errors = period_map(system), []
    assert direct.rows is not None
    for m in (8, 12, 16, 20):
        rows = rows_of(Attempt(region, (m, m)).box)
        error = np.abs(0.5 * (rows[0] + rows[3]) - direct.half_trace)
        assert np.all(error <= rows[4] + direct.rows[4])
        assert np.all(np.abs(rows[8] - direct.discriminant) <= rows[5] + direct.rows[5])
        errors.append(float(error.max()))
    steps = [math.log10(a / b) for a, b in pairwise(errors)]
    assert errors[0] > 1e-5 and errors[-1] < 1e-13
    assert steps[0] > 2.0 and steps[1] > steps[0]  # an entire function; the last step ends at rounding


def test_wanted_nodes_are_enough() -> None:
    """What an attempt with too few nodes asks for resolves the region; a resolved one asks for no more."""
    for system in (blades(column(span(2.0, 16.0, 80)), span(0.0, 1.0, 80)), mathieu(span(0.0, 40.0, 9000), 3.0)):
        region = whole(system)
        few = asked(Attempt(region, (12,) * len(region.spans)))
        assert all(12 < m <= MOST for m in few)
        enough = Attempt(region, few)
        again = asked(enough) if asked(enough) == few else asked(Attempt(region, asked(enough)))
        assert all(m - w <= 4 for m, w in zip(again, few, strict=True))
        assert boxes(region)[0].nodes[0].size >= FIRST[len(region.spans)]


def test_polynomials_are_one_at_their_node_and_right_to_rounding_however_small() -> None:
    (box,) = boxes(whole(blades(8.0, span(0.0, 1.0, 5000))))
    (nodes,), (weights,) = box.nodes, box.weights
    np.testing.assert_allclose(cardinals(nodes, nodes, weights), np.eye(len(nodes)), rtol=2 * EPS, atol=1e-150)
    x = np.array([0.123, 0.5, 0.987])
    exact = [
        [math.prod((v - b) / (a - b) for b in nodes.astype(np.longdouble) if b != a) for a in nodes] for v in x
    ]  # differences of doubles are exact to half an eps, in 80 bits to 1/4000 of one
    np.testing.assert_allclose(cardinals(x, nodes, weights), np.array(exact, float), rtol=64 * EPS)


def test_discriminant_is_bounded_by_the_determinant() -> None:
    """Entries moved in any way: D, computed from them, stays within what τ and det Φ tell."""
    rng = np.random.default_rng(3)
    a, b, c = rng.normal(size=(3, 4000)) * 10.0 ** rng.uniform(-1, 2, (3, 4000))
    d = (1.0 + b * c) / a
    moved = [x + 1e-8 * rng.normal(size=4000) * (1.0 + abs(x)) for x in (a, b, c, d)]
    tau, error = 0.5 * (a + d), abs(0.5 * (moved[0] + moved[3]) - 0.5 * (a + d))
    D, bound = judged(moved, error)
    assert np.all(np.abs(D - (tau**2 - 1.0)) <= bound + 8 * EPS * tau**2)  # of τ² here
    assert np.median(bound / np.abs(D - (tau**2 - 1.0))) < 10.0


@pytest.mark.parametrize("off", [-1.4, -0.6, 0.0, 0.6, 1.4])
def test_zeros_follow_from_a_rough_angle(off: float) -> None:
    """Constant q, many turns: ω known to within one and a half quarter turns gives the zeros of cos."""
    w = span(0.02, 6.0, 3000)
    turn = w * math.pi
    m = (np.cos(turn), np.sin(turn) / w, -np.sin(turn) * w, np.cos(turn))
    for unit in (0.3, 1.0, 4.0):
        sine, cosine = m[1] / unit - m[2] * unit, m[0] + m[3]
        omega = np.arctan2(sine, cosine)
        omega += 2 * np.pi * np.round((turn - omega) / (2 * np.pi))
        zeros, certain = zeros_of(m, omega / (0.5 * math.pi) + off, unit)
        np.testing.assert_array_equal(zeros, np.floor(w + 0.5))
        assert np.all(certain) or abs(off) > 0.7


def test_bound_without_roots_is_that_of_the_exponents() -> None:
    """``within`` says what :func:`floquet.kernels.closing.closed` makes of the bounds, in locks and between."""
    D = np.array([-0.9, -0.3, 1e-6, 0.4, 40.0])
    for factor, inside in ((0.99, True), (1.01, False)):
        moved = factor * 1e-11 * 6.0 * np.array([0.6, 1.0, 1.0, 1.0, 1.0])  # a part of it is τ's, between
        tau_error = factor * 1e-11 * 6.0 * np.array([0.8, 0.0, 1.0, 1.0, 1.0])
        b = moved * 2.0 * np.sqrt(np.abs(D) * (1.0 + np.maximum(D, 0.0)))
        assert np.all(within(D, b, tau_error, 1e-11, 6.0) == inside)
    assert not within(np.float64(np.nan), 1.0, 1.0, 1e-11, 6.0)


# ---------------------------------------------------------------------- what falls back
@pytest.mark.parametrize("ways", [True, "advance_ratio"])
def test_equations_in_pieces_are_solved_directly(ways: bool | str) -> None:
    """Reversed flow begins where μ passes the hinge offset, just above the first μ or below it."""
    for offset, mu in ((0.001, span(0.0, 0.5, 300)), (0.0057, span(0.0075, 1.0, 300))):
        system = flapping(Rotor(lock_number=column(span(3.0, 12.0, 20)), hinge_offset=offset), mu, reversed_flow=True)
        found, direct = stability(system, map=ways), stability(system)
        np.testing.assert_array_equal(found.exponents, direct.exponents)
        np.testing.assert_array_equal(found.exponent_errors, direct.exponent_errors)


def test_neutral_systems_stay_neutral_beside_damped_ones() -> None:
    """α = 0 is no part of a neighbour's α, whichever way its sign is."""
    damping = column(np.array([0.0, 0.1, 0.0, -0.2]))
    found, direct = (stability(mathieu(span(1.5, 6.0, 400), 0.3, damping), map=m) for m in ("a", False))
    assert np.mean(found.method == Method.MAP) > 0.95
    np.testing.assert_array_equal(found.verdict[[0, 2]], direct.verdict[[0, 2]])
    np.testing.assert_array_equal(found.reason[[0, 2]], direct.reason[[0, 2]])
    crossing = mathieu(span(1.5, 6.0, 90), 0.3, column(span(-0.3, 0.3, 101)))
    found, direct = stability(crossing, map=True), stability(crossing)
    known = direct.verdict != Verdict.UNDECIDED
    assert np.all((found.verdict == direct.verdict)[known])
    assert np.all(found.verdict[50][~known[50]] == Verdict.UNDECIDED)


@pytest.mark.parametrize("places", [1, 2, 60])
def test_answers_along_one_axis_do_not_depend_on_other_places(places: int) -> None:
    """Bit for bit, bounds and methods included."""
    rng = np.random.default_rng(14)
    gamma, offset, coupling = (column(rng.uniform(*ends, 120)) for ends in ((2.0, 20.0), (0.0, 0.2), (-0.6, 0.6)))
    mu = span(0.0, 1.2, 130)
    whole = stability(blades(gamma, mu, hinge_offset=offset, pitch_flap_coupling=coupling), map="advance_ratio")
    for start in range(0, 120, 40):
        some = slice(start, start + places)
        part = blades(gamma[some], mu, hinge_offset=offset[some], pitch_flap_coupling=coupling[some])
        found = stability(part, map="advance_ratio")
        for name in ("exponents", "exponent_errors", "rotation_number", "lock", "verdict", "method", "panels"):
            np.testing.assert_array_equal(getattr(found, name), getattr(whole, name)[some], err_msg=name)


def test_bound_of_the_mean_damping_is_in_that_of_the_exponents() -> None:
    """α of many nodes between them, against the coefficients themselves."""
    region = whole(blades(8.0, span(0.0, 1.0, 5000), flap_damping=0.3 + 0.2 * span(0.0, 1.0, 5000)))
    coarse = Attempt(region, (8,))
    e = cardinals(region.values[0], coarse.nodes[0], coarse.box.weights[0])
    assert region.grid.axes[0].parameter == "flap_damping"
    exact = -0.5 * (region.values[0] + 1.0)
    assert np.all(np.abs(e @ coarse.values[5][0] - exact) <= coarse.box.alpha_errors[0])
    assert coarse.box.alpha_errors[0] < 2e-14


def test_a_jump_of_the_equation_within_or_at_an_end_is_seen() -> None:
    """The integrals are exact in ε beyond ε = root cutout, truncated before: a jump at 0.1, or at the first value."""
    for low, values in ((0.05, 90), (0.1, 90), (0.1, 91), (0.1, 92)):  # at random, some of them would be found
        cutout = span(low, 0.2, values)
        found = compared(blades(column(span(4.0, 12.0, 80)), 0.3, hinge_offset=0.1, root_cutout=cutout))
        assert np.all(found.method[:, cutout <= 0.1] != Method.MAP) or low < 0.1


def test_a_jump_of_the_mean_damping_alone_is_seen() -> None:
    """q of Hill's form is the same for all; the damping jumps at the last value, which is no node."""
    a = span(1.0, 2.0, 200)

    def build(values: Mapping[str, Array]) -> tuple[PeriodicMatrix, PeriodicMatrix]:
        d = np.where(values["a"] == a[-1], 0.2, 0.1)[..., None, None]
        K = PeriodicMatrix.constant(values["a"][..., None, None] + 0.25 * d * d)
        return PeriodicMatrix.constant(d), K + PeriodicMatrix.harmonic(1, 0.2 + 0.0 * d, 0.0 * d)

    system = PeriodicSystem(period=2.0 * math.pi, equation=Equation(build=build, parameters={"a": a}))
    found, direct = stability(system, map="a"), stability(system)
    np.testing.assert_allclose(found.exponents[-1].real, -0.1, atol=1e-12)
    np.testing.assert_allclose(found.exponents.real, direct.exponents.real, atol=1e-12)


def test_others_that_vary_along_the_axis_are_nothing_to_a_place() -> None:
    """A second parameter that is another straight function at each place: no nodes for places apart from others."""
    mu = span(0.0, 0.5, 90)
    both = {"mu": mu[None], "b": np.array([[1.0], [2.0]]) * mu}
    assert Axis.of(both, 1) is not None and Axis.of(both, 1, alone=True) is None
    assert Axis.of({"mu": mu[None], "b": 2.0 * mu[None]}, 1, alone=True) is not None


def test_points_next_to_branch_points_are_solved_directly() -> None:
    """The edges of the one-per-rev lock: no polynomial carries their points; bounds are below 1e-11 there too."""
    gamma, mu = span(7.0, 9.0, 80), span(0.75, 0.9, 4000)
    found = compared(blades(column(gamma), mu))
    assert 0 < np.mean(found.method != Method.MAP) < 0.01 and np.any(found.method == Method.PRECISE)
    assert np.isnan(found.lock).any() and not np.isnan(found.lock).all()


def test_points_no_box_carries_are_solved_as_if_there_were_no_grid() -> None:
    """With more digits next to a branch point."""
    system = blades(8.0, span(0.82684, 0.82685, 9))
    alone, found = hill_map(system, compiled=available()), direct_map(system, np.arange(9))
    assert alone.rows is not None and found.rows is not None
    assert alone.methods is not None and np.any(alone.methods == Method.PRECISE)
    np.testing.assert_array_equal(found.rows, alone.rows)


def test_products_of_large_entries_are_in_the_bound() -> None:
    """Φ of 6000, whose products leave a D of 1: rounded by three times the allowance of the panels, as det Φ tells."""
    system = blades(
        23.775651629450348, span(0.6230, 0.6232, 40), hinge_offset=0.0743899697310001,
        hinge_stiffness=0.1818410726298223, pitch_flap_coupling=-0.8410159098596708, root_cutout=0.19086825014003841,
        flap_damping=0.27309213976638447, static_moment_ratio=2.6717908359536002,
    )  # fmt: skip
    exact, found = period_map(system), hill_map(system, precise=False)
    assert found.rows is not None and exact.methods is not None and np.all(exact.methods == Method.PRECISE)
    assert np.all(np.abs(found.discriminant - exact.discriminant) <= found.rows[5])


def test_tiny_grids_and_other_systems_are_solved_as_without() -> None:
    rotor = Rotor(lock_number=8.0)
    for system in (
        blades(column(span(2.0, 16.0, 20)), span(0.0, 1.0, 30)),
        blades(8.0, 0.3),
        blades(8.0, np.zeros(0)),
        multiblade(Rotor(lock_number=column(span(4.0, 8.0, 3)), blades=4), span(0.0, 0.4, 4)),
        meissner(column(span(0.5, 2.0, 80)), span(0.0, 0.3, 80)),  # matrices, no parameters
    ):
        assert TensorGrid.of(system) is None
        found, direct = stability(system, map=True), stability(system)
        np.testing.assert_array_equal(found.exponents, direct.exponents)
        np.testing.assert_array_equal(found.exponent_errors, direct.exponent_errors)
    with pytest.raises(ParameterError, match="either map or panels"):
        stability(flapping(rotor, 0.3), map=True, panels=8)


def test_identical_blades_use_the_map_of_one() -> None:
    rotor = Rotor(lock_number=column(span(4.0, 12.0, 80)), blades=3)
    found, direct = (stability(multiblade(rotor, span(0.0, 0.5, 70)), map=m) for m in (True, False))
    assert np.mean(found.method == Method.MAP) > 0.99
    bound = (found.exponent_errors + direct.exponent_errors).max(axis=-1)
    assert np.all(np.abs(found.exponents - direct.exponents).max(axis=-1) <= bound)


# ---------------------------------------------------------------------- axes of every kind
GAMMA, MU = span(3.0, 12.0, 80), span(0.0, 0.8, 70)
RNG = np.random.default_rng(12)


@pytest.mark.parametrize(
    ("gamma", "mu"),
    [
        (column(GAMMA[::-1]), MU[::-1]),
        (column(RNG.permutation(GAMMA)), RNG.permutation(MU)),
        (column(np.repeat(GAMMA[::4], 4)), np.sort(np.repeat(MU[::7], 7))),
        (column(GAMMA) * np.ones(70), MU * np.ones((80, 1))),
        (GAMMA, column(MU)),
        (span(3.0, 12.0, 80)[:, None] * np.ones((1, 1)), MU**3),
    ],
    ids=["descending", "in no order", "repeated", "dense", "exchanged", "uneven"],
)
def test_axes_in_any_order(gamma: Array, mu: Array) -> None:
    compared(blades(gamma, mu), least=0.99)


def test_axes_without_nodes_are_gone_through_value_by_value() -> None:
    for place in range(3):
        shapes = [[-1 if i == k else 1 for i in range(3)] for k in range(3)]
        order = [s for k, s in enumerate(shapes) if k != place]
        gamma, mu = GAMMA.reshape(order[0]), MU.reshape(order[1])
        system = blades(gamma, mu, hinge_stiffness=np.array([0.0, 0.4, 0.1]).reshape(shapes[place]))
        grid = TensorGrid.of(system)
        assert grid is not None and [axis.place for axis in grid.axes] == [k for k in range(3) if k != place]
        assert sum(map(len, regions(grid))) == 3
        compared(system, least=0.99)


def test_several_parameters_on_an_axis() -> None:
    """Straight functions of one (ε and m = 1.5 ε, or a line through the plane) carry nodes; others do not."""
    straight = blades(column(GAMMA), 0.9 - 0.07 * GAMMA[:70], hinge_stiffness=0.3 * GAMMA[:70])
    compared(straight, least=0.99)
    grid = TensorGrid.of(straight)
    assert grid is not None and [axis.slack > 0 for axis in grid.axes] == [False, True]
    offset = blades(column(GAMMA), 0.4, hinge_offset=span(0.0, 0.15, 70), static_moment_ratio=1.4)
    compared(offset, least=0.99)
    product = blades(8.0, 0.4, hinge_offset=span(0.0, 0.15, 70), static_moment_ratio=column(span(1.2, 1.6, 80)))
    compared(product, least=0.99)  # m = ε s is straight along both axes
    curved = blades(column(GAMMA), MU, hinge_stiffness=MU**2)
    grid = TensorGrid.of(curved)
    assert grid is not None and [axis.parameter for axis in grid.axes] == ["lock_number"]
    compared(curved)
    assert TensorGrid.of(blades(8.0 + RNG.uniform(0, 1, (80, 70)), RNG.uniform(0, 1, (80, 70)))) is None


def test_slack_bounds_what_parameters_are_off_their_straight_line() -> None:
    """Values off by 2 eps of the largest, to either side: accepted and told as slack; more are not."""
    x = span(0.1, 0.3, 4500)
    off = 2 * EPS * 0.6 * (-1.0) ** np.arange(4500)
    parameters = {"a": x, "b": 2.0 * x + off}
    axis = Axis.of(parameters, 0)
    assert axis is not None and 4 * EPS * 0.3 <= axis.slack <= 8 * EPS * 0.3  # with 2 eps for making them
    assert Axis.of({"a": x, "b": 2.0 * x + 100 * off}, 0) is None
    assert Axis.of({"a": np.full(4500, 0.2) + 1e-12 * x, "c": np.zeros(1)}, 0) is None  # too narrow for nodes

    region = whole(blades(8.0, span(0.0, 1.0, 5000)))
    (axis,) = region.grid.axes
    loose = replace(region, grid=replace(region.grid, axes=(replace(axis, slack=1e-6),)))
    tight, wide = (Attempt(r, (24,)).box for r in (region, loose))
    tau = 0.5 * (tight.values[0] + tight.values[3])
    slope = np.abs(np.gradient(tau[0], tight.nodes[0]))[1:-1]
    assert np.all(wide.values[6, 0, 1:-1] - tight.values[6, 0, 1:-1] >= 0.9e-6 * slope)  # of differences: 10 % off


def test_bounds_of_three_axes_weigh_all_nodes() -> None:
    """Σ |ℓ_a ℓ_b ℓ_c| w_abc, at points in every corner of a tile."""
    region = whole(
        blades(span(4.0, 10.0, 34)[:, None, None], span(0.0, 0.6, 36), hinge_stiffness=column(span(0, 0.5, 35)))
    )
    (box,) = boxes(region)
    e = [np.abs(cardinals(x, n, w)) for x, n, w in zip(region.values, box.nodes, box.weights, strict=True)]
    expected = np.einsum("xa,yb,zc,abc->xyz", *e, box.values[6, 0]).ravel()
    np.testing.assert_allclose(rows_of(box)[4], expected, rtol=1e-12)


def test_cut_regions_hold_every_point_once() -> None:
    region = whole(blades(column(RNG.permutation(GAMMA)), np.sort(np.repeat(MU[::7], 7))))
    for k in range(2):
        a, b = region.cut(k)
        assert a.points + b.points == region.points and a.values[k][-1] < b.values[k][0]
    parts = [part for half in region.cut(0) for part in half.cut(1)]
    places = [first + (rows[:, None] + columns).ravel() for first, (rows, columns) in (p.places() for p in parts)]
    np.testing.assert_array_equal(np.sort(np.concatenate(places)), np.arange(region.points))


# ---------------------------------------------------------------------- the same answers, however computed
def same(a: Stability, b: Stability) -> None:
    for name in ("exponents", "exponent_errors", "rotation_number", "lock", "verdict", "reason", "method", "panels"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_answers_do_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    system = blades(column(span(2.0, 20.0, 260)), span(0.0, 1.3, 300))
    found = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("FLOQUET_THREADS", threads)
        found.append(stability(system, map=True))
    same(found[0], found[1])
    same(found[0], found[2])


SCRIPT = """
import sys
import numpy as np
from floquet import Rotor, flapping, stability
s = stability(flapping(Rotor(lock_number=np.linspace(2.0, 14.0, 80)[:, None]), np.linspace(0.0, 1.0, 90)), map=True)
np.savez(sys.argv[1], exponents=s.exponents, errors=s.exponent_errors, rho=s.rotation_number, method=s.method)
"""


@pytest.mark.skipif(not available(), reason="numba is not to be used")
def test_answers_are_the_same_without_numba(tmp_path: Any) -> None:
    for name, environment in (("compiled", {}), ("arrays", {"FLOQUET_NO_NUMBA": "1"})):
        command = [sys.executable, "-c", SCRIPT, str(tmp_path / f"{name}.npz")]
        subprocess.run(command, check=True, env={**os.environ, **environment})
    a, b = (np.load(tmp_path / f"{name}.npz") for name in ("compiled", "arrays"))
    assert np.mean(a["method"] == b["method"]) > 0.999  # single points at the limit of their bounds
    assert np.all(np.abs(a["exponents"] - b["exponents"]) <= a["errors"] + b["errors"])
    assert np.all(np.abs(a["rho"] - b["rho"]) <= a["errors"][..., 0] + b["errors"][..., 0])
    both = (a["method"] == Method.MAP) & (b["method"] == Method.MAP)
    np.testing.assert_allclose(a["errors"][both], b["errors"][both], rtol=0.25)  # the defect in them is rounding


def turned_within(places: Array) -> Array:
    """All but the first and the last in the opposite order."""
    return np.concatenate([places[:1], places[-2:0:-1], places[1:][-1:]])


@pytest.mark.skipif(not available(), reason="numba is not to be used")
@pytest.mark.parametrize("columns", [1, 255, 256, 700])
def test_compiled_tiles_are_the_arithmetic_of_arrays(columns: int) -> None:
    """Blocks that are full, and not; points side by side, apart, and in no order."""
    from floquet.kernels import grid
    from floquet.kernels.closing import exponents_of

    (box,) = boxes(whole(blades(column(span(3.0, 12.0, 80)), span(0.0, 0.8, 70))))
    tile = next(tiles(box))
    chosen, z, n = [5, 20, 60], np.linspace(0.01, 0.79, columns), 3 * columns
    orders: list[Callable[[Array], Array]] = [np.copy, lambda k: 3 * k, RNG.permutation, turned_within]
    for order in orders:
        places = order(np.arange(columns))
        step = 1 if places.max() > columns else columns
        part: Tile = tile._replace(
            x=tile.x[chosen],
            units=tile.units[chosen],
            alpha_errors=tile.alpha_errors[chosen],
            panels=tile.panels[chosen],
            z=z,
            row_places=np.arange(3) * step,
            column_places=places.astype(np.intp),
        )
        out = grid.Exponents(
            np.empty(4 * n), np.empty(2 * n), *(np.empty(n) for _ in range(3)),
            *(np.zeros(n, np.int8) for _ in range(3)), np.zeros(n, np.int32),
        )  # fmt: skip
        grid.close_tile(part, int(Method.MAP), out)
        rows, alpha, kept = tile_rows(part)
        expected = exponents_of(rows, alpha, part.period, alpha_error=np.repeat(part.alpha_errors, columns))
        where = (part.row_places[:, None] + part.column_places).ravel()
        found = out.exponents.view(complex).reshape(-1, 2)[where]
        assert np.all(np.abs(found - expected["exponents"]).max(axis=-1) <= expected["bound"])
        np.testing.assert_allclose(out.exponent_errors.reshape(-1, 2)[where, 1], expected["bound"], rtol=0.05)
        np.testing.assert_array_equal(out.method[where], np.where(kept, Method.MAP, -1))
        np.testing.assert_array_equal(out.verdict[where], expected["verdict"])
        np.testing.assert_allclose(out.rotation_number[where], expected["rho"], atol=1e-10)
        assert np.all(out.panels[where] == box.panels[0])


# ---------------------------------------------------------------------- parts of systems
def test_a_part_of_a_part_is_exact_from_the_parameters() -> None:
    """Next to a branch point, in forty digits: the same whether the point is one of many or alone."""
    mu = span(0.82684486, 0.82684488, 40)
    system = flapping(Rotor(lock_number=8.0, hinge_stiffness=0.0), mu)
    parts = system.part(np.arange(5, 30)).part(np.arange(3, 9))
    one, many = make_precise(period_map(parts), parts), make_precise(period_map(system), system)
    assert one.rows is not None and many.rows is not None and one.methods is not None
    assert np.all(one.methods == Method.PRECISE)
    np.testing.assert_array_equal(one.rows, many.rows[:, 8:14])


def test_least_grid_is_worth_its_nodes() -> None:
    """A grid at the limit: nodes of one attempt are fewer than its points by the gain asked for."""
    assert FIRST[2] ** 2 * 4 <= LEAST and FIRST[1] * 4 <= LEAST
