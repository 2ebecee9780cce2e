"""Rows: right values in right columns, and the same bits however they are cut."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from floquet.comparison import Metric, Rule, compare
from floquet.errors import FloquetWarning, ParameterError
from floquet.models import Physics
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
    np.testing.assert_array_equal(rows["limit"], [x.limit for x in found])
    np.testing.assert_array_equal(rows["intervals"], [len(x.intervals) for x in found])
    assert rows["interval_1_start"][0] == found[0].intervals[0][0]


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
