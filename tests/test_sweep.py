"""Rows: right values in right columns, and the same bits however they are cut."""

from __future__ import annotations

import warnings
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from floquet.comparison import Metric, Rule, compare
from floquet.errors import FloquetWarning, ParameterError
from floquet.models import Physics
from floquet.period_map import Method
from floquet.rotor import Hub, Rotor
from floquet.sweep import Plan, limit_rows, point_rows, sweep
from floquet.validity import limits


@pytest.fixture(params=[{}, {"reversed_flow": True, "exact_offset": True}], ids=["report", "reversed"])
def plan(request: pytest.FixtureRequest) -> Plan:
    grid = Rotor(lock_number=np.array([[4.0], [12.0]]), hinge_offset=np.array([0.0, 0.15]))
    teetering, three = (
        Rotor(lock_number=6.0, blades=2, hub=Hub.TEETERING, name="nominal"),
        Rotor(lock_number=8.0, blades=3),
    )
    return Plan(
        rotors=(grid, teetering, three),
        advance_ratio=np.array([0.0, 0.3, 0.9, 1.4]),
        physics=Physics(**request.param),
        tolerances=((Metric.RELATIVE, 0.05), (Metric.ABSOLUTE, 0.02)),
    )


def test_rows_are_the_comparisons(plan: Plan) -> None:
    rows = point_rows(plan, 0, plan.points)
    assert plan.designs == 6 and plan.points == 24
    for i in (1, 6, 13, 18, 23):
        rotor, mu = plan.design(i // 4), plan.advance_ratio[i % 4]
        assert (
            rows["rotor"][i] == i // 4
            and rows["advance_ratio"][i] == mu
            and rows["lock_number"][i] == rotor.lock_number
        )
        c = compare(rotor, mu, **plan.physics.as_dict())
        assert rows["exponent_1"][i] == c.stability.exponents[0] and rows["panels"][i] == c.stability.panels
        present = {m.name for m in c.modes}
        for mode in ("regressing", "coning", "advancing", "differential"):
            if mode in present:
                assert rows[f"tpp_{mode}_2"][i] == c[mode].simple[1] and rows[f"error_frequency_{mode}"][i] == c[
                    mode
                ].by(Metric.FREQUENCY)
            else:
                assert rows[f"rule_{mode}"][i] == Rule.ABSENT and np.isnan(rows[f"error_{mode}"][i])


@pytest.mark.parametrize("size", [1, 5, 7])
def test_bits_do_not_depend_on_chunks(plan: Plan, size: int) -> None:
    whole = point_rows(plan, 0, plan.points)
    parts = [point_rows(plan, i, min(i + size, plan.points)) for i in range(0, plan.points, size)]
    for name, column in whole.items():
        assert column.tobytes() == np.concatenate([p[name] for p in parts]).tobytes(), name


def test_limit_rows_are_the_limits(plan: Plan) -> None:
    rows = limit_rows(plan, 3, 5)
    found = [x for d in (3, 4) for x in limits(plan.design(d), tolerances=plan.tolerances, **plan.physics.as_dict())]
    assert len(rows["limit"]) == len(found) == 2 * (4 + 2)
    np.testing.assert_allclose(rows["limit"], [x.limit for x in found], rtol=1e-11)  # solved with others, or alone
    np.testing.assert_array_equal(rows["intervals"], [len(x.intervals) for x in found])
    np.testing.assert_array_equal(rows["cause"], [x.cause for x in found])
    assert rows["interval_1_start"][0] == pytest.approx(found[0].intervals[0][0], rel=1e-11)


def test_sweep_is_the_short_way() -> None:
    rows = sweep(Rotor(lock_number=8.0), [0.0, 0.3])
    assert rows["error_regressing"][1] == compare(Rotor(lock_number=8.0), 0.3).modes[0].error
    with pytest.raises(ParameterError, match="nothing to compute"):
        sweep(Rotor(lock_number=8.0), [])


def test_designs_of_two_blades_warn_once_a_group() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sweep(Rotor(lock_number=np.linspace(4, 8, 5), blades=2), [0.1, 0.2])
    assert [w.category for w in caught] == [FloquetWarning]


def mapped(ratios: int, *, map: bool) -> Plan:
    """Random designs of three kinds."""
    gamma, offset = np.random.default_rng(5).uniform((2.0, 0.0), (16.0, 0.15), (30, 2)).T
    articulated = [Rotor(lock_number=gamma, hinge_offset=offset, blades=n) for n in (3, 4)]
    teetering = Rotor(lock_number=gamma[:5], blades=2, hub=Hub.TEETERING)
    return Plan(rotors=(*articulated, teetering), advance_ratio=np.linspace(0.0, 1.0, ratios), map=map)


def test_rows_from_maps_are_those_of_points_within_their_bounds_and_say_so() -> None:
    plan = mapped(120, map=True)
    rows, direct = point_rows(plan, 0, plan.points), point_rows(mapped(120, map=False), 0, plan.points)
    from_nodes = rows["method"] == Method.MAP
    assert np.mean(from_nodes) > 0.99 and np.all(direct["method"] != Method.MAP)
    bound = rows["exponent_error"] + direct["exponent_error"]
    assert np.all(np.abs(rows["exponent_1"] - direct["exponent_1"]) <= bound)
    assert np.all(np.abs(rows["rotation_number"] - direct["rotation_number"]) <= bound)
    for name in ("rotor", "advance_ratio", "lock_number", "blades", "hub"):
        np.testing.assert_array_equal(rows[name], direct[name])
    for name in ("tpp_advancing_1", "error_regressing", "error_differential"):
        np.testing.assert_allclose(rows[name], direct[name], rtol=1e-6, atol=1e-9)
    few = mapped(60, map=True)  # too few advance ratios for nodes
    assert np.all(point_rows(few, 0, few.points)["method"] != Method.MAP)


def test_rows_from_maps_do_not_depend_on_how_they_are_cut() -> None:
    """In the middle of a design, and of a kind."""
    plan = mapped(130, map=True)
    whole, cuts = point_rows(plan, 0, plan.points), [0, 1700, 3900, 5333, 7000, plan.points]
    parts = [point_rows(plan, a, b) for a, b in pairwise(cuts)]
    for name, column in whole.items():
        assert column.tobytes() == np.concatenate([p[name] for p in parts]).tobytes(), name


def test_a_sweep_takes_maps() -> None:
    rotor, mu = Rotor(lock_number=np.array([6.0, 8.0])), np.linspace(0.0, 0.6, 300)
    mapped, direct = sweep(rotor, mu, map=True), sweep(rotor, mu)
    assert set(mapped["method"]) == {Method.MAP} and Method.MAP not in direct["method"]
    gaps = abs(mapped["exponent_1"] - direct["exponent_1"])
    assert np.all(gaps <= mapped["exponent_error"] + direct["exponent_error"])


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"rotor": "x"}, "'x' is no Rotor: make one"),
        ({"advance_ratio": "x"}, "'x' is not a number"),
        ({"map": "x"}, "map: 'x' is neither True nor False"),
    ],
)
def test_what_cannot_be_swept_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        sweep(**{"rotor": Rotor(lock_number=8.0), "advance_ratio": 0.3, **given})
