"""Values between the rotors of a grid: products of polynomials, their error, refusals, and what is computed there."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from floquet import store
from floquet.cli import main
from floquet.comparison import compare
from floquet.errors import ParameterError
from floquet.query import Database, grid, open_database
from floquet.rotor import Rotor
from floquet.study import load_study
from floquet.sweep import point_rows
from tests.test_query import FakeFile

GAMMA, OFFSET, MU = np.linspace(4, 12, 9), np.array([0.0, 0.01, 0.03, 0.06, 0.1]), np.linspace(0, 0.5, 11)
AT: dict[str, float] = {"lock_number": 7.3, "hinge_offset": 0.02, "advance_ratio": 0.33}


def made(**columns: Any) -> dict[str, Any]:
    """Rows of 9 × 5 rotors at 11 advance ratios, shuffled; columns are functions of (γ, ε, μ)."""
    gamma, offset, mu = (x.reshape(-1) for x in np.meshgrid(GAMMA, OFFSET, MU, indexing="ij"))
    table = {name: np.zeros(gamma.size, column.dtype) for name, column in store.POINTS.items()}
    table |= {"lock_number": gamma, "hinge_offset": offset, "advance_ratio": mu, "offset_mass_ratio": 1.5 * offset}
    table |= {"rotor": np.repeat(np.arange(45, dtype="i4"), 11), "lock": np.full(gamma.size, np.nan)}
    table |= {"blades": np.full(gamma.size, 4, "i2"), "rotation_number": np.full(gamma.size, 0.7)}
    table |= {name: np.asarray(f(gamma, offset, mu), table[name].dtype) for name, f in columns.items()}
    order = np.random.default_rng(3).permutation(gamma.size)
    return {name: values[order] for name, values in table.items()}


def opened(table: dict[str, Any], names: tuple[str, ...] = ()) -> Database:
    file = FakeFile({"points": table}, names=names)
    file._columns = {"points": store.POINTS}  # type: ignore[dict-item]
    return Database("grid.h5", file)


def cubic(gamma: Any, offset: Any, mu: Any) -> Any:
    return (1 + gamma - 0.03 * gamma**3) * (1 + 40 * offset**2) * (mu + 3 * mu**3) + gamma * offset


def exponential(gamma: Any, offset: Any, mu: Any) -> Any:
    return np.exp(0.3 * gamma + 5 * offset + 2 * mu)


def test_a_polynomial_of_the_degree_is_exact_and_the_design_is_what_was_asked() -> None:
    db = opened(made(error_regressing=cubic, exponent_1=lambda g, e, m: cubic(g, e, m) * (1 - 2j)))
    found = db.at(**AT, columns=("error_regressing", "exponent_1", "lock_number", "offset_mass_ratio"))
    exact = cubic(7.3, 0.02, 0.33)
    assert found.values["error_regressing"] == pytest.approx(exact, rel=1e-13)
    assert found.values["exponent_1"] == pytest.approx(exact * (1 - 2j), rel=1e-13)
    assert (found.values["lock_number"], found.errors["lock_number"]) == (7.3, 0.0)
    assert found.values["offset_mass_ratio"] == pytest.approx(0.03, rel=1e-13)
    assert found.design == {"lock_number": 7.3, "hinge_offset": 0.02} and found.advance_ratio == 0.33
    assert found.nodes["lock_number"] == (5, 6, 7, 8, 9, 10) and found.nodes["hinge_offset"] == tuple(OFFSET)
    np.testing.assert_allclose(found.rows, (0.2, 0.25, 0.3, 0.35, 0.4, 0.45), rtol=1e-15)
    assert (found.rotor, found.rotor_name) == (-1, "")
    for rows, nodes in ((3, 3), (5, 5), (9, 9)):
        one = db.at(**AT, columns="error_regressing", rows=rows)
        assert len(one.nodes["lock_number"]) == nodes and len(one.nodes["hinge_offset"]) == min(nodes, 5)
        assert abs(one.values["error_regressing"] - exact) < one.errors["error_regressing"]


def test_the_error_is_the_sum_of_the_changes_on_each_axis() -> None:
    """Computed anew with polynomials fitted along one axis after the other."""
    found = opened(made(error_coning=exponential)).at(**AT, columns="error_coning", rows=4)
    axes = [(np.array([7.0, 8.0, 6.0, 9.0]), 7.3), (np.array([0.01, 0.03, 0.0, 0.06]), 0.02),
            (np.array([0.35, 0.3, 0.4, 0.25]), 0.33)]  # fmt: skip
    assert found.nodes["hinge_offset"] == (0.0, 0.01, 0.03, 0.06)

    def through(*drop: int) -> float:
        near = [x[: 4 - d] for (x, _), d in zip(axes, drop, strict=True)]
        y = exponential(*np.meshgrid(*near, indexing="ij"))
        for x, (_, at) in zip(near, axes, strict=True):
            fitted = np.linalg.solve(np.vander(x - at, increasing=True), y.reshape(x.size, -1))
            y = fitted[0].reshape(y.shape[1:])
        return float(y)

    best = through(0, 0, 0)
    changes = [
        max(abs(best - through(*one)), abs(through(*one) - through(*(2 * d for d in one))))
        for one in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    ]
    assert found.values["error_coning"] == pytest.approx(best, rel=1e-12)
    assert found.errors["error_coning"] == pytest.approx(sum(changes), rel=1e-6)
    assert abs(best - exponential(7.3, 0.02, 0.33)) < found.errors["error_coning"] < 0.1 * best


def test_on_a_node_the_axis_has_no_error_and_a_rotor_of_the_grid_is_itself() -> None:
    db = opened(made(error_coning=exponential, error_regressing=cubic), tuple(f"r{i}" for i in range(45)))
    on = db.at(advance_ratio=0.35, lock_number=7.0, hinge_offset=0.02, columns="error_coning")
    assert on.nodes["lock_number"] == (7.0,) and len(on.rows) == 1 and len(on.nodes["hinge_offset"]) == 5
    alone = [exponential(7.0, e, on.rows[0]) for e in OFFSET]
    by_fit = np.polyval(np.polyfit(OFFSET - 0.02, alone, 4), 0.0)
    assert on.values["error_coning"] == pytest.approx(by_fit, rel=1e-12)
    rotor = int(np.flatnonzero(GAMMA == 7.0)[0]) * 5 + 2
    same = db.at(advance_ratio=0.33, lock_number=7.0, hinge_offset=0.03, columns="error_coning")
    assert same == db.at(f"rotor == {rotor}", advance_ratio=0.33, columns="error_coning")
    assert (same.rotor, same.rotor_name) == (rotor, f"r{rotor}")
    one = db.at("hinge_offset == 0.03", advance_ratio=0.33, lock_number=7.3, columns="error_coning")
    assert set(one.nodes) == {"lock_number"}
    again = db.at(
        "hinge_offset == 0.03", advance_ratio=0.33, lock_number=7.3, hinge_offset=0.03, columns="error_coning"
    )
    assert (again.values, again.errors) == (one.values, one.errors)
    known = db.at(**AT)
    assert "exponent_1" in known.values and "advance_ratio" not in known.values and "lock" not in known.values


def test_nothing_is_taken_from_beyond_an_edge_and_an_edge_about_the_point_is_told() -> None:
    """A lock for γ + 40 ε > 9 of rows 1000 off; the box stays below it."""

    def lock(g: Any, e: Any, m: Any) -> Any:
        return np.where(g + 40 * e > 9.0, 1.0, np.nan)

    def step(g: Any, e: Any, m: Any) -> Any:
        return np.where(g + 40 * e > 9.0, 1000.0, g * e)

    db = opened(made(lock=lock, error_regressing=step))
    found = db.at(advance_ratio=0.33, lock_number=5.5, hinge_offset=0.02, columns="error_regressing")
    assert found.values["error_regressing"] == pytest.approx(0.11, rel=1e-12)
    assert max(found.nodes["lock_number"]) + 40 * max(found.nodes["hinge_offset"]) <= 9.0
    assert len(found.nodes["lock_number"]) >= 3 <= len(found.nodes["hinge_offset"])
    sloping = opened(made(lock=lock, error_regressing=exponential))
    cut = sloping.at(advance_ratio=0.33, lock_number=5.5, hinge_offset=0.02, columns="error_regressing")
    ends = " and ".join(f"{name} <= {max(nodes)}" for name, nodes in cut.nodes.items())
    free = sloping.at(ends, advance_ratio=0.33, lock_number=5.5, hinge_offset=0.02, columns="error_regressing")
    assert free.nodes == cut.nodes and free.values == cut.values
    assert cut.errors["error_regressing"] == 4 * free.errors["error_regressing"] > 0
    cases = [
        ((8.5, 0.005), "lock_number: there is an edge of a lock between lock_number 8 and 9 (at hinge_offset 0.01, "
                       "advance_ratio 0.3) (no lock, the lock at 1), where exponents have a square root; compute"),
        ((8.0, 0.02), "hinge_offset: there is an edge of a lock between hinge_offset 0.01 and 0.03 (at lock_number 8"),
        ((8.0, 0.005), "hinge_offset: only 2 values of hinge_offset about 0.005 have rows of one kind (0 to 0.01)"),
    ]  # fmt: skip
    for (gamma, offset), sentence in cases:
        with pytest.raises(ParameterError, match=re.escape(sentence)):
            db.at(advance_ratio=0.33, lock_number=gamma, hinge_offset=offset, columns="error_regressing")


def test_the_box_grows_on_all_axes_alike() -> None:
    """Below γ + 40 ε = 10.5 from γ of 6 and 7: up to 9 there would be no room for an offset of 0.06."""
    db = opened(made(lock=lambda g, e, m: np.where(g + 40 * e > 10.5, 1.0, np.nan)))
    found = db.at(advance_ratio=0.33, lock_number=6.5, hinge_offset=0.02, columns="error_regressing")
    assert found.nodes == {"lock_number": (4.0, 5.0, 6.0, 7.0, 8.0), "hinge_offset": (0.0, 0.01, 0.03, 0.06)}


@pytest.mark.parametrize("name, words", [
    ("rotation_number", "a lock lies between lock_number 7 and 8 (at hinge_offset 0.01, advance_ratio 0.3) (the "
                        "rotation number goes from 0.4 to 0.6)"),
    ("rule_regressing", "the kind of pair changes between lock_number 7 and 8 (at hinge_offset 0.01, advance_ratio "
                        "0.3) (rule_regressing is PAIRED, then REALS); name columns of other modes than regressing"),
])  # fmt: skip
def test_a_kind_that_changes_is_refused(name: str, words: str) -> None:
    low, high = {"rotation_number": (0.4, 0.6), "rule_regressing": (0, 1)}[name]
    db = opened(made(**{name: lambda g, e, m: np.where(g > 7.5, high, low)}))
    with pytest.raises(ParameterError, match=re.escape(words)):
        db.at(**AT, columns="error_regressing")
    assert max(db.at(**{**AT, "lock_number": 6.3}, columns="error_regressing").nodes["lock_number"]) == 7.0
    if name == "rule_regressing":
        assert max(db.at(**AT, columns="error_coning").nodes["lock_number"]) > 8.0


def test_what_lies_in_no_grid_is_refused() -> None:
    plain = made()
    three = {name: np.concatenate([values, values[:1]]) for name, values in plain.items()}
    three["rotor"][-1], three["lock_number"][-1] = 45, 5.5
    four = made(blades=lambda g, e, m: np.where(g > 8, 2, 4))
    speeds = made(advance_ratio=lambda g, e, m: np.where(g > 8, m * 1.01, m))
    cases: list[tuple[dict[str, Any], str, dict[str, float], str]] = [
        (plain, "", {"lock_number": 12.5}, "lock_number: 12.5 lies outside of the rotors' values, which go from 4.0"),
        (plain, "", {"hinge_offset": -0.01}, "hinge_offset: -0.01 lies outside"),
        (plain, "", {"advance_ratio": 0.51}, "advance_ratio: 0.51 lies outside of the rows, which go from 0.0 to 0.5"),
        (plain, "", {"lock_number": float("nan")}, "lock_number: nan was given; it must be a finite number"),
        (plain, "", {"root_cutout": 0.1}, "root_cutout: 0.1 lies outside of the rotors' values, which go from 0.0"),
        (plain, "", {"lock_nmber": 7.0}, "at: 'lock_nmber' is no parameter that lies between rotors, did you mean"),
        (plain, "", {"blades": 4}, "at: 'blades' is no parameter that lies between rotors; put it into the expression"),
        (plain, "rotor > 99", {}, "expression: it holds for no row; name rows of some rotors"),
        (plain, "hinge_offset in (0, 0.1)", {}, "hinge_offset: only 2 values of hinge_offset about 0.02 have rows of"),
        (three, "", {}, "at: 46 rotors are no grid of 10 × 5 values in lock_number and hinge_offset; give an"),
        (four, "", {}, "blades: the rotors differ in it, too (2 values, 2 to 4); put it into the expression, as in"),
        (speeds, "", {}, "advance_ratio: the rotors about it do not have the same advance ratios there"),
    ]  # fmt: skip
    for table, expression, changed, sentence in cases:
        with pytest.raises(ParameterError, match=re.escape(sentence)):
            opened(table).at(expression, **{**AT, **changed}, columns="error_regressing")
    with pytest.raises(
        ParameterError, match=r"hinge_offset: the rotors differ in it, too \(5 values, 0 to 0\.1\); give"
    ):
        opened(plain).at(lock_number=7.3, advance_ratio=0.3)
    unknown = made(error_coning=lambda g, e, m: np.where((g == 7) & (m > 0.32), np.nan, 1.0))
    found = opened(unknown).at(**AT, columns=("error_coning", "error_regressing"))
    assert np.isnan(found.values["error_coning"]) and found.errors["error_coning"] == np.inf
    assert found.errors["error_regressing"] == 0.0


# --- against what is computed there -----------------------------------------------------------------------------------
STUDY = """
study = { name = "grid" }
axes = { advance_ratio = { start = 0.0, stop = 0.5, count = 26 } }
[rotors.grid]
lock_number = { start = 4.0, stop = 10.0, count = 13 }
hinge_offset = { start = 0.0, stop = 0.1, count = 6 }
"""
COLUMNS = ("exponent_1", "rotation_number", "tpp_regressing_1", "error_regressing", "error_coning", "flap_frequency")


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grid")
    (folder / "grid.toml").write_text(STUDY, encoding="utf-8")
    plan = load_study(folder / "grid.toml").plan
    store.write(
        folder / "grid.h5", {"points": point_rows(plan, 0, plan.points)}, {"study_id": "0", "rotor_names": "[]"}
    )
    return folder / "grid.h5"


def exact(gamma: float, offset: float, mu: float) -> dict[str, Any]:
    rotor = Rotor(lock_number=gamma, hinge_offset=offset)
    there = compare(rotor, mu)
    return {
        "exponent_1": there.stability.exponents[0],
        "rotation_number": there.stability.rotation_number,
        "tpp_regressing_1": there["regressing"].simple[0],
        "error_regressing": there["regressing"].error,
        "error_coning": there["coning"].error,
        "flap_frequency": rotor.flap_frequency,
    }


def test_the_estimate_covers_the_error_at_designs_between(computed: Path) -> None:
    """Of 100 seeded points, half of which are refused: 99 % of the values are within their error, all within twice."""
    g = np.random.default_rng(1431)
    ratios: list[float] = []
    refused = 0
    with open_database(computed) as db:
        for _ in range(100):
            gamma, offset, mu = g.uniform(4, 10), g.uniform(0, 0.1), g.uniform(0, 0.5)
            try:
                found = db.at(lock_number=gamma, hinge_offset=offset, advance_ratio=mu, columns=COLUMNS)
            except ParameterError:
                refused += 1
                continue
            there = exact(gamma, offset, mu)
            ratios += [abs(found.values[name] - there[name]) / found.errors[name] for name in COLUMNS]
    assert refused < 60 and len(ratios) > 240
    assert np.mean(np.array(ratios) <= 1.0) >= 0.99 and max(ratios) < 2.0


def status(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_the_command_line_gives_values_and_errors(
    computed: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(computed.parent)
    places = ("--at", "advance_ratio=.123", "--at", "lock_number=7.3", "--at", "hinge-offset = 0.031")
    assert status("query", "grid.h5", *places, "--columns", "exponent_1,error_regressing", "--json") == 0
    first, second = json.loads(capsys.readouterr().out)
    with open_database(computed) as db:
        found = db.at(
            advance_ratio=0.123, lock_number=7.3, hinge_offset=0.031, columns=("exponent_1", "error_regressing")
        )
    value = found.values["exponent_1"]
    assert first == {"column": "exponent_1", "value": [value.real, value.imag], "error": found.errors["exponent_1"]}
    assert second["value"] == found.values["error_regressing"]
    assert status("query", "grid.h5", *places) == 0
    assert len(capsys.readouterr().out.splitlines()) > 30
    assert status("query", "grid.h5", "lock_number == 8 and hinge_offset == 0.1", "--at", "advance_ratio=0.05") == 0
    capsys.readouterr()
    for wrong, sentence in (
        (("--at", "lock_number=7"), "at: no advance ratio was given: add --at advance_ratio=0.3"),
        (("--at", "advance_ratio"), "at: 'advance_ratio' was given; it is a name and a number"),
        ((*places, "--at", "lock_number=8"), "at: lock_number is given twice"),
        ((*places, "--at", "rows=4"), "at: 'rows' is no parameter that lies between rotors"),
        ((*places, "--by", "rotor"), "leave --by out"),
        ((*places, "--table", "limits"), "leave --table out"),
        ((*places, "-o", "a.csv"), "leave --output out"),
        ((*places, "--sort", "lock"), "leave --sort out"),
    ):
        assert status("query", "grid.h5", *wrong) == 2
        error = capsys.readouterr().err
        assert sentence in error and "Traceback" not in error, error


def test_the_examples_of_the_page_run(
    computed: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow")
    monkeypatch.chdir(computed.parent)
    page = (Path(__file__).parents[1] / "docs" / "query.md").read_text(encoding="utf-8")
    fenced = {kind: re.findall(rf"^```{kind}\n(.*?)^```$", page, flags=re.M | re.S) for kind in ("shell", "python3")}
    lines = [line for block in fenced["shell"] for line in block.splitlines()]
    assert len(lines) == 5 and len(fenced["python3"]) == 2
    for line in lines:
        program, *arguments = shlex.split(line)
        assert program == "floquet" and status(*arguments) == 0, line
        shown = capsys.readouterr()
        assert "wrote" in shown.err if "-o" in arguments else "exponent_1" in shown.out
    names: dict[str, Any] = {"open_database": open_database}
    for block in fenced["python3"]:
        exec(block, names)
    assert set(names["found"].values) == {"exponent_1", "error_coning"}
    written = {path.name for path in computed.parent.iterdir()}
    assert {"failing.parquet", "failing.nc", "medians.csv", "medians.json", "points.nc"} <= written


def test_an_axis_reaches_as_far_as_its_rows() -> None:
    axis = grid.Axis(name="x", nodes=np.arange(20.0), at=7.5)
    assert axis.cell == (7, 8) and axis.reach(6).nodes.tolist() == list(range(3, 13))
    assert axis.next(7, 8) == [6, 9] and axis.next(0, 8) == [9] and axis.next(0, 19) == []
    assert grid.Axis(name="x", nodes=np.arange(20.0), at=3.0).reach(6).nodes.tolist() == [3.0]
