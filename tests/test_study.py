"""Studies: the file, the run, its interruptions, packing and the ways out."""

from __future__ import annotations

import contextlib
import csv
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from filelock import FileLock

from floquet import checking, store, study
from floquet.comparison import Metric
from floquet.errors import (
    ConfigError,
    DatabaseError,
    FailedError,
    FloquetWarning,
    InputError,
    ParameterError,
    QueryError,
    StorageError,
)
from floquet.export import export
from floquet.kernels import cores
from floquet.plot import plot_database
from floquet.query import open_database
from floquet.rotor import Hub, Rotor
from floquet.store import digests, writing
from floquet.study import folder as study_folder
from floquet.study import packing, running, shards, workers
from floquet.sweep import Plan, limit_rows, point_rows

SMALL = """
[study]
name = "small"
schema = 1

[rotors]
list = [
    { lock_number = 8.0, name = "eight" },
    { lock_number = 6.0, blades = 2, hub = "teetering", name = "two blades" },
]
grid = { lock_number = [4.0, 12.0], hinge_offset = { start = 0.0, stop = 0.1, count = 2 }, blades = [3, 4] }

[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 60 }

[compare]
tolerances = [0.05]
absolute_tolerances = [0.02]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "small study.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def tiny(file: Path) -> Path:
    """Two rotors and 600 points: seven shards when they are cut small."""
    lines = SMALL.replace("count = 60", "count = 300").replace("absolute_tolerances = [0.02]", "").splitlines()
    file.write_text("\n".join(line for line in lines if not line.startswith("grid")))
    return file


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Several shards of each table from a small study."""
    monkeypatch.setattr(shards, "POINT_SHARD", (100, 100))
    monkeypatch.setattr(shards, "LIMIT_SHARD", (3, 3))


# ---------------------------------------------------------------------- the file
def test_a_study_file_is_a_plan(file: Path) -> None:
    plan = study.load_study(file).plan
    assert plan.designs == 10 and plan.points == 600 and plan.names[:2] == ("eight", "two blades")
    assert plan.tolerances == ((Metric.RELATIVE, 0.05), (Metric.ABSOLUTE, 0.02))
    assert plan.design(1).hub is Hub.TEETERING
    grid = [(r.blades, r.lock_number, r.hinge_offset) for r in map(plan.design, range(2, 10))]
    assert grid == [(n, g, e) for n in (3, 4) for g in (4.0, 12.0) for e in (0.0, 0.1)]


def test_sobol_designs_are_in_their_box_and_the_same_every_time(tmp_path: Path) -> None:
    text = SMALL.replace(
        "list =",
        "sobol = { count = 8, seed = 3, lock_number = [4.0, 12.0], hinge_offset = [0.0, 0.1], blades = 5 }\nlist =",
    )
    (tmp_path / "s.toml").write_text(text)
    first, second = (study.load_study(tmp_path / "s.toml") for _ in range(2))
    designs = [first.plan.design(i) for i in range(10, 18)]
    assert all(4 <= r.lock_number <= 12 and 0 <= r.hinge_offset <= 0.1 and r.blades == 5 for r in designs)
    assert len({r.lock_number for r in designs}) == 8 and first.id == second.id


@pytest.mark.parametrize(("kind", "count"), [("sobol", 8), ("random", 7)])
def test_designs_that_are_drawn_stay_as_they_are_when_there_are_more(tmp_path: Path, kind: str, count: int) -> None:
    def drawn(count: int, seed: int = 3) -> Rotor:
        box = f"count = {count}, seed = {seed}, lock_number = [4.0, 12.0], hinge_offset = [0.0, 0.1], blades = 5"
        (tmp_path / "s.toml").write_text(SMALL.replace("list =", f"{kind} = {{ {box} }}\nlist ="))
        return study.load_study(tmp_path / "s.toml").plan.rotors[-1]

    few, more = drawn(count), drawn(2 * count)
    assert few.shape == (count,) and few.blades == 5 and np.all((few.lock_number >= 4.0) & (few.lock_number <= 12.0))
    for name in ("lock_number", "hinge_offset"):
        np.testing.assert_array_equal(getattr(few, name), getattr(more, name)[:count])
        assert not np.any(getattr(few, name) == getattr(drawn(count, 4), name))
    assert len(set(more.lock_number.tolist())) == 2 * count


def test_the_id_changes_with_every_number_that_matters(tmp_path: Path, file: Path) -> None:
    ids = {study.load_study(file).id}
    changes = {
        "8.0": "8.000001",
        "count = 60": "count = 61",
        "0.05]": "0.06]",
        "0.02]": "0.03]",
        "[compare]": "[compare]\nreversed_flow = true",
        "tolerances = [0.05]\n": "tolerances = [0.05]\nmap = true\n",
        '"eight"': '"8"',
        "blades = 2": "blades = 2, hinge_stiffness = 0.1",
    }
    for old, new in changes.items():
        path = tmp_path / "other.toml"
        path.write_text(SMALL.replace(old, new))
        ids.add(study.load_study(path).id)
    assert len(ids) == 9
    commented = tmp_path / "comment.toml"
    commented.write_text("# why\n" + SMALL)
    assert study.load_study(commented).id in ids


@pytest.mark.parametrize(("old", "new", "sentence"), [
    ("[axes]", "[axis]", r"axis: .*did you mean 'axes'"),
    ("tolerances = [0.05]", "tolerance = [0.05]", r"small\.toml:17: compare\.tolerance: .*did you mean 'tolerances'"),
    ("tolerances = [0.05]", "tolerances = [-1]", "tolerances"),
    ("count = 60", "count = 0", "count"),
    ("schema = 1", "schema = 2", "schema"),
    ('hub = "teetering"', 'hub = "teetring"', "did you mean 'teetering'"),
    ("lock_number = 8.0", "lock_number = -8.0", "lock_number"),
    ("lock_number = 8.0", "lock_numbr = 8.0", "did you mean 'lock_number'"),
    ("stop = 0.1, count = 2 }", "stop = 0.1 }", r"small\.toml:11: rotors\.grid\.hinge_offset\.count: the key is miss"),
    ("[4.0, 12.0]", "-4.0", r"small\.toml:11: lock_number"),
    ("stop = 1.0", "stop = nan", "stop"),
    ("{ start = 0.0, stop = 1.0, count = 60 }", "[0.1, -0.2]", "-0.2 is not possible"),
    ("[compare]", "[compare]\ntip_loss = 1.2", "outside 0.5"),
])  # fmt: skip
def test_a_bad_study_is_refused_in_a_sentence(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = tmp_path / "small.toml"
    assert old in SMALL
    path.write_text(SMALL.replace(old, new, 1))
    with pytest.raises(ConfigError, match=sentence):
        study.load_study(path)


@pytest.mark.parametrize(("line", "key"), [
    ('grid = { lock_number = { start = "a", stop = 2, count = 3 } }', "grid.lock_number.start"),
    ("grid = { lock_number = { start = 1, stop = 2, count = 0 } }", "grid.lock_number.count"),
    ("grid = { lock_number = { start = 1, stop = 2, count = true } }", "grid.lock_number.count"),
    ('grid = { lock_number = ["a", 1.0] }', "grid.lock_number[0]"),
    ("grid = { lock_number = [] }", "grid.lock_number"),
    ("grid = { lock_number = true }", "grid.lock_number"),
    ('grid = { lock_number = "8" }', "grid.lock_number"),
    ("grid = { lock_number = 8, blades = 3.5 }", "grid.blades"),
    ("grid = { lock_number = 8, hub = [1] }", "grid.hub[0]"),
    ("grid = { lock_numbr = 8 }", "grid.lock_numbr"),
    ('sobol = { count = 8, lock_number = [5, "a"] }', "sobol.lock_number[1]"),
    ("sobol = { count = 8, lock_number = [5, 4] }", "sobol.lock_number"),
    ("sobol = { count = 8, lock_number = [5] }", "sobol.lock_number"),
    ("sobol = { count = 8, seed = -1, lock_number = [5, 6] }", "sobol.seed"),
    ("sobol = { count = true, lock_number = [5, 6] }", "sobol.count"),
    ("sobol = { count = 12, lock_number = [5, 6] }", "sobol.count"),
    ("sobol = { lock_number = [5, 6] }", "sobol.count"),
    ("sobol = { count = 8 }", "sobol"),
    ("random = { count = 0, lock_number = [5, 6] }", "random.count"),
    ("random = { count = 3, lock_number = [6, 5] }", "random.lock_number"),
    ("random = { count = 3 }", "random"),
])  # fmt: skip
def test_a_bad_grid_or_sobol_box_is_one_sentence_with_its_line(tmp_path: Path, line: str, key: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        f'[study]\nname = "s"\nschema = 1\n[rotors]\n{line}\n[axes]\nadvance_ratio = [0.1]\n', encoding="utf-8"
    )
    with pytest.raises(ConfigError) as caught:
        study.load_study(path)
    [problem] = caught.value.problems
    assert problem.line == 5 and f"rotors.{key}: " in str(caught.value) and "\n" not in str(caught.value)


def test_the_order_of_a_grid_is_that_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        SMALL.replace(
            "lock_number = [4.0, 12.0], hinge_offset = { start = 0.0, stop = 0.1, count = 2 }",
            "hinge_offset = { start = 0.0, stop = 0.1, count = 2 }, lock_number = [4.0, 12.0]",
        )
    )
    plan = study.load_study(path).plan
    assert [(plan.design(i).lock_number, plan.design(i).hinge_offset) for i in (2, 3, 4)] == [(4, 0), (12, 0), (4, 0.1)]


def test_a_design_that_is_given_twice_is_told(tmp_path: Path) -> None:
    """Of a list and a grid: another name or m given as it follows makes no other design, another hub or number does."""
    file = tmp_path / "twice.toml"
    text = (
        '[study]\nname = "s"\nschema = 1\n[rotors]\nlist = [{lock_number = 6.0, blades = 4, name = "mine"}, '
        "{lock_number = 8.0, hinge_offset = 0.1, offset_mass_ratio = 0.15, blades = 4}, "
        "{lock_number = 6.0, blades = 3}]\n"
        "[rotors.grid]\nblades = 4\nlock_number = [6.0, 8.0]\nhinge_offset = [0.0, 0.1]\n"
        "[axes]\nadvance_ratio = [0.1, 0.2]\n"
    )
    file.write_text(text, encoding="utf-8")
    with pytest.warns(FloquetWarning, match=r"rotor 3 is rotor 0 \(mine\) once more and 1 more: .* take it twice"):
        found = study.load_study(file)
    assert found.plan.repeated() == [(3, 0), (6, 1)]
    file.write_text(text.replace("[6.0, 8.0]", "[6.5, 8.5]"), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert study.load_study(file).plan.repeated() == []


@pytest.mark.parametrize(("given", "sentence"), [
    ("advance_ratio = [0.1, 0.2, 0.1]\n[compare]\ntolerances = [0.05]", "axes.advance_ratio has 0.1 twice"),
    ("advance_ratio = [0.1, 0.2]\n[compare]\ntolerances = [0.05, 0.1, 0.05]", "compare.tolerances has 0.05 twice"),
    ("advance_ratio = [0.1, 0.2]\n[compare]\ntolerances = [0.05]\nabsolute_tolerances = [0.05]", ""),
])  # fmt: skip
def test_an_advance_ratio_or_a_tolerance_that_is_given_twice_is_told(tmp_path: Path, given: str, sentence: str) -> None:
    file = tmp_path / "twice.toml"
    file.write_text(f'[study]\nname = "s"\nschema = 1\n[rotors]\nlist = [{{lock_number = 6.0}}]\n[axes]\n{given}\n')
    with pytest.warns(FloquetWarning, match=sentence) if sentence else warnings.catch_warnings():
        warnings.simplefilter("always" if sentence else "error")
        study.load_study(file)


def test_a_missing_rotor_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(SMALL.replace("list =", 'files = ["nowhere.toml"]\nlist ='))
    with pytest.raises(ConfigError, match=r"nowhere\.toml"):
        study.load_study(tmp_path / "s.toml")


# ---------------------------------------------------------------------- columns
OUTPUT = '\n[output]\ncolumns = ["error_regressing", "exponent_1", "verdict"]\n'


@pytest.fixture
def few(tiny: Path) -> Path:
    """The tiny study, three of its columns beside those that are always stored."""
    tiny.write_text(tiny.read_text() + OUTPUT)
    return tiny


def test_a_study_says_which_columns_it_stores(few: Path) -> None:
    named = study.load_study(few)
    assert named.columns == (*store.ALWAYS, "exponent_1", "verdict", "error_regressing")
    few.write_text(few.read_text().replace(OUTPUT, ""))
    every = study.load_study(few)
    assert every.columns == tuple(store.POINTS) == named.storing(["*"]).columns and every.id == named.id
    assert every.storing(["lock"]).columns == (*store.ALWAYS, "lock")
    assert study.dry_run(named).bytes < 0.4 * study.dry_run(every).bytes


@pytest.mark.parametrize(("columns", "sentence"), [
    ('["eror_regressing"]', r"s\.toml:8: output\.columns\[0\]: .*did you mean 'error_regressing'"),
    ('["lock", "exponent_1_im"]', r"output\.columns\[1\]: exponent_1_im is a part of exponent_1.*name exponent_1"),
    ("[]", r"s\.toml:8: output\.columns: .*a list of at least 1"),
    ('"lock"', r"output\.columns: .*a list in \[ \]"),
    ("[1]", r"output\.columns\[0\]: .*a text in quotes"),
    ('["limit"]', r"'limit' is no column of the table of points"),
])  # fmt: skip
def test_bad_columns_are_one_sentence_with_their_line(tmp_path: Path, columns: str, sentence: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        '[study]\nname = "s"\n[rotors]\nlist = [{ lock_number = 8.0 }]\n[axes]\nadvance_ratio = [0.1]\n'
        f"[output]\ncolumns = {columns}\n"
    )
    with pytest.raises(ConfigError, match=sentence) as caught:
        study.load_study(path)
    assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_with_few_columns_from_end_to_end(few: Path, tmp_path: Path, workers: int) -> None:
    one, out = study.load_study(few), tmp_path / "out.h5"
    assert study.run(one, out, workers=workers).points == 600
    rows = point_rows(one.plan, 0, 600)
    with store.open_file(out) as file:
        assert tuple(file.columns("points")) == one.columns and list(file.columns("limits")) == list(store.LIMITS)
        [(_, read)] = file.chunks("points", list(one.columns))
        for name in one.columns:
            assert read[name].tobytes() == rows[name].tobytes(), name
    assert store.verify(out) == ()
    for ending in ("csv", "nc"):
        export(out, tmp_path / f"out.{ending}")
    with (tmp_path / "out.csv").open(newline="") as source:
        header = next(csv.reader(source))
    stored = list(store.stored_variables({name: store.POINTS[name] for name in one.columns}))
    assert header == ["rotor", "rotor_name", *stored[1:]]
    with h5py.File(tmp_path / "out.nc") as exported:
        assert set(exported) == {"row", "integrity", *stored}
    with open_database(out) as database:
        found = database.query("error_regressing > 0.05 and verdict == 'STABLE'")
        assert {"rotor", "error_regressing", "verdict", "advance_ratio"} <= set(found) and "lock" not in found
        assert set(database.query(columns="*")) == {*one.columns, "rotor_name"}
        for asked in ("lock > 0", "exponent_2_re < 0"):
            with pytest.raises(QueryError, match=r"not stored in this database: \[output\] columns of its study"):
                database.query(asked)
        with pytest.raises(QueryError, match="did you mean 'error_coning'"):
            database.query("eror_coning > 0")
    with pytest.raises(
        ParameterError, match=r"error-vs-mu draws exponent_2, rotation_number, lock, rule_MODE, error_M"
    ):
        plot_database(out, "error-vs-mu", tmp_path / "a.svg")


@pytest.mark.parametrize(("kind", "of_mode"), [
    ("root-locus", ["tpp_regressing_1", "tpp_regressing_2"]), ("error-vs-mu", ["error_regressing"]),
])  # fmt: skip
def test_a_figure_needs_the_columns_of_one_mode(tiny: Path, tmp_path: Path, kind: str, of_mode: list[str]) -> None:
    """And shows the modes that are stored whole."""
    named = ["exponent_1", "exponent_2", "rotation_number", "lock", "rule_regressing", *of_mode, "rule_coning"]
    study.run(study.load_study(tiny).storing(named), tmp_path / "out.h5")
    assert plot_database(tmp_path / "out.h5", kind, tmp_path / "a.svg").exists()
    for i, left_out in enumerate(named[:-1]):
        study.run(study.load_study(tiny).storing([*named[:i], *named[i + 1 :]]), tmp_path / f"{i}.h5")
        with pytest.raises(ParameterError, match=left_out.replace("regressing", "MODE")):
            plot_database(tmp_path / f"{i}.h5", kind, tmp_path / "a.svg")


@pytest.mark.usefixtures("quick")
def test_a_run_is_gone_on_with_and_packed_with_its_own_columns(few: Path, tmp_path: Path) -> None:
    one, out = study.load_study(few), tmp_path / "out.h5"
    folder = _unpacked(few, out)
    other = one.storing(["error_regressing", "exponent_1", "lock"])
    for place in (folder, out):
        with pytest.raises(InputError, match=f"{place.name} holds this study without lock and with verdict: name the"):
            study.run(other, out, resume=True)
        assert study.run(one, out, resume=True).computed == 0
    out.unlink()
    folder = _unpacked(few, out)
    first = min(folder.glob("points-*.h5"))
    with store.open_file(first) as file:
        attributes = dict(file.attributes)
        [(_, rows)] = file.chunks("points", list(one.columns))
    del rows["verdict"]
    store.write(first, {"points": rows}, attributes)
    with pytest.raises(DatabaseError, match=f"1 of 7 shards are damaged or of another study.*{first.name}"):
        study.pack(folder, out)
    assert study.run(one, out, resume=True).computed == 1
    folder = _unpacked(few, tmp_path / "again.h5")
    about = json.loads((folder / "study.json").read_text())
    for wrong in (["eror"], 3, [3]):
        (folder / "study.json").write_text(json.dumps(about | {"columns": wrong}))
        with pytest.raises(DatabaseError, match=r"study\.json is damaged"):
            study.pack(folder, tmp_path / "again.h5")
        with pytest.raises(DatabaseError, match=r"study\.json is damaged"):
            study.run(one, tmp_path / "again.h5", resume=True)


def test_merge_keeps_the_columns_that_all_have_and_says_so(two: tuple[Path, Path], tmp_path: Path) -> None:
    second = study.load_study(tmp_path / "b.toml").storing(["error_regressing"])
    study.run(second, tmp_path / "few.h5")
    with pytest.warns(FloquetWarning, match=r"left out of the table points: exponent_1, exponent_2, "):
        study.merge([two[0], tmp_path / "few.h5"], tmp_path / "m.h5")
    with store.open_file(tmp_path / "m.h5") as merged:
        assert tuple(merged.columns("points")) == second.columns
        assert list(merged.columns("limits")) == list(store.LIMITS)
    assert store.verify(tmp_path / "m.h5") == ()


# ---------------------------------------------------------------------- shards and chunks
@pytest.mark.parametrize(("points", "size"), [
    (100, 4096), (3609, 4096), (200_000, 6250), (2**19, 16384), (10**6, 2 * 16384), (10**7, 20 * 16384),
    (10**9, 61 * 16384),
])  # fmt: skip
def test_shards_of_many_points_are_whole_chunks(points: int, size: int) -> None:
    plan = Plan(rotors=(Rotor(lock_number=8.0),), advance_ratio=np.zeros(2), tolerances=())
    object.__setattr__(plan, "_first", np.array([0, points // 2]))
    assert shards.sizes_of(plan) == {"points": points and size}


@pytest.mark.usefixtures("quick")
def test_rows_and_chunks_do_not_depend_on_shards(tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks that are computed at a time begin at chunks of the database; shards of whole chunks are copied."""
    monkeypatch.setattr(store.schema, "CHUNK_ROWS", 64)
    asked: list[tuple[int, int]] = []
    real, images = shards.TABLE_ROWS["points"], {}

    def seen(plan: Any, start: int, stop: int, *columns: Any) -> Any:
        asked.append((start, stop))
        return real(plan, start, stop, *columns)

    monkeypatch.setitem(shards.TABLE_ROWS, "points", seen)
    monkeypatch.setattr(packing.time, "strftime", lambda *_: "now")
    for size in (600, 128, 192, 100):  # in whole chunks: 640, 128, 192 (the last shard is less than a chunk), 128
        monkeypatch.setattr(shards, "POINT_SHARD", (size, size))
        study.run(study.load_study(tiny), tmp_path / f"{size}.h5")
        images[size] = (tmp_path / f"{size}.h5").read_bytes()
        assert asked == [(i, min(i + 64, 600)) for i in range(0, 600, 64)]
        asked.clear()
    assert len(set(images.values())) == 1


@pytest.mark.usefixtures("quick")
def test_packing_copies_chunks(tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store.schema, "CHUNK_ROWS", 50)
    folder = _unpacked(tiny, tmp_path / "out.h5")
    made, real = [], writing.pack
    monkeypatch.setattr(writing, "pack", lambda *given: (made.append(given), real(*given))[1])
    study.pack(folder, tmp_path / "out.h5")
    assert len(made) == 12 + 1  # the numbers of the rows; the limits' few rows are one chunk
    assert store.verify(tmp_path / "out.h5") == ()


def test_worker_processes_have_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", "8")
    with study.processes(1) as pool:
        assert pool.submit(cores).result() == 1
    assert cores() == 8


# ---------------------------------------------------------------------- running
@pytest.mark.usefixtures("quick")
def test_a_run_packs_what_the_sweep_gives(file: Path, tmp_path: Path) -> None:
    one, seen = study.load_study(file), []
    report = study.run(one, tmp_path / "out.h5", progress=lambda done, total: seen.append((done, total)))
    assert (report.points, report.limits, report.computed, report.failed) == (600, 68, 10, ())
    assert seen[0] == (0, 10) and seen[-1] == (10, 10) and not study.parts_of(report.path).exists()
    points, limits = point_rows(one.plan, 0, 600), limit_rows(one.plan, 0, 10)
    with store.open_file(report.path) as stored:
        assert (
            stored.names == one.plan.names
            and stored.attributes["input"] == SMALL
            and stored.attributes["study_id"] == one.id
        )
        for table, rows in (("points", points), ("limits", limits)):
            [(_, read)] = list(stored.chunks(table, list(rows)))
            for name, value in rows.items():
                assert read[name].tobytes() == value.tobytes(), name
    assert store.verify(report.path) == ()
    assert study.dry_run(one).limits == 68 and study.dry_run(one).shards == 10


@pytest.mark.usefixtures("quick")
def test_any_engine_gives_the_same_bits(file: Path, tmp_path: Path) -> None:
    one = study.load_study(file)
    study.run(one, tmp_path / "serial.h5")
    with ThreadPoolExecutor(2) as pool:
        study.run(one, tmp_path / "threads.h5", executor=pool)
    study.run(one, tmp_path / "processes.h5", workers=2)
    assert len({store.data_digest(tmp_path / f"{n}.h5") for n in ("serial", "threads", "processes")}) == 1


@pytest.mark.usefixtures("quick")
def test_resume_keeps_sound_shards_and_makes_damaged_ones_again(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, out, made = study.load_study(file), tmp_path / "out.h5", []
    real = shards.TABLE_ROWS["points"]

    def interrupted(plan: Any, start: int, stop: int, *columns: Any) -> Any:
        if start == 400:
            raise KeyboardInterrupt
        return real(plan, start, stop, *columns)

    monkeypatch.setitem(shards.TABLE_ROWS, "points", interrupted)
    with pytest.raises(KeyboardInterrupt):
        study.run(one, out)
    folder = study.parts_of(out)
    files = sorted(p.name for p in folder.glob("points-*.h5"))
    assert len(files) == 4 and not out.exists()
    with pytest.raises(InputError, match="--resume"):
        study.run(one, out)
    damaged = folder / files[1]
    damaged.write_bytes(damaged.read_bytes()[:-5000])
    (folder / files[2]).write_bytes(b"not HDF5 at all")
    with h5py.File(folder / files[3], "r+") as changed:  # HDF5 is content with it, the digest is not
        changed["points/lock_number"][0] += 1.0

    def counted(plan: Any, start: int, stop: int, *columns: Any) -> Any:
        made.append(start)
        return real(plan, start, stop, *columns)

    monkeypatch.setitem(shards.TABLE_ROWS, "points", counted)
    with pytest.warns(FloquetWarning, match=f"3 parts that were there are damaged, the first {files[1]}"):
        report = study.run(one, out, resume=True)
    assert sorted(made) == [100, 200, 300, 400, 500] and report.reused == 5
    study.run(one, tmp_path / "whole.h5")
    assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5")


@pytest.mark.usefixtures("quick")
def test_another_study_is_not_mixed_in(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    one = study.load_study(file)
    study.run(one, out)
    with pytest.raises(InputError, match="is there already"):
        study.run(one, out)
    again = study.run(one, out, resume=True)
    assert (again.computed, again.points, again.limits) == (0, 600, 68)
    file.write_text(SMALL.replace("8.0", "8.5"))
    with pytest.raises(InputError, match="another study"):
        study.run(study.load_study(file), out, resume=True)


@pytest.mark.usefixtures("quick")
def test_an_unfinished_run_of_another_study_is_not_gone_on_with(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setitem(shards.TABLE_ROWS, "points", interrupted)
    with pytest.raises(KeyboardInterrupt):
        study.run(study.load_study(file), tmp_path / "out.h5")
    file.write_text(SMALL.replace("8.0", "8.5"))
    with pytest.raises(InputError, match="unfinished run of another study"):
        study.run(study.load_study(file), tmp_path / "out.h5", resume=True)


def test_two_runs_of_one_study_do_not_meet(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    folder = study.parts_of(out)
    folder.mkdir()
    with FileLock(folder / ".lock"), pytest.raises(InputError, match="in use by another run"):
        study.run(study.load_study(file), out)


def test_a_range_has_the_numbers_that_one_would_write(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(SMALL.replace("count = 60", "count = 101"))
    values = study.load_study(tmp_path / "s.toml").plan.advance_ratio
    assert values.tolist() == [float(f"{i / 100:.2f}") for i in range(101)] and 0.35 in values.tolist()


def test_what_was_exported_is_no_database_and_no_database_is_exported_over(tiny: Path, tmp_path: Path) -> None:
    out, other, exported = tmp_path / "out.h5", tmp_path / "other.nc", tmp_path / "points.nc"
    study.run(study.load_study(tiny), out)
    other.write_bytes(out.read_bytes())
    for _ in range(2):  # an exported file is replaced
        export(out, exported)
    for look in (checking.check, open_database):
        with pytest.raises(DatabaseError, match="it has no table of a database: it may be one that was exported"):
            look(exported)
    with pytest.raises(InputError, match="is a database itself, and would be lost"):
        export(out, other)
    assert other.read_bytes() == out.read_bytes()


def test_of_two_processes_that_begin_a_study_at_once_one_goes_on(tiny: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "floquet", "run", str(tiny), "-o", "out.h5", "--workers", "1"]
    environment = os.environ | {"PYTHONPATH": str(Path(study.__file__).parents[2])}
    both = [
        subprocess.Popen(
            command, cwd=tmp_path, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        for _ in range(2)
    ]
    (_, one), (_, other) = said = sorted((run.wait(), run.communicate()[1]) for run in both)
    assert [status for status, _ in said] == [0, 2] and one == ""
    assert re.fullmatch(r"floquet: out\.h5(\.parts is in use by another run| is there already): .*\n", other), other
    assert store.verify(tmp_path / "out.h5") == () and not study.parts_of(tmp_path / "out.h5").exists()


@pytest.mark.parametrize("resume", [True, False])
def test_a_run_that_finds_the_database_made_meanwhile_ends(
    tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, resume: bool
) -> None:
    """Between its first look and its turn another run has ended."""
    one, out, real = study.load_study(tiny), tmp_path / "out.h5", running.locked

    def late(*given: Any) -> Any:
        monkeypatch.setattr(running, "locked", real)
        study.run(one, out)
        return real(*given)

    monkeypatch.setattr(running, "locked", late)
    with contextlib.nullcontext() if resume else pytest.raises(InputError, match=r"is there already: .*--resume"):
        assert study.run(one, out, resume=resume).computed == 0
    assert not study.parts_of(out).exists() and store.verify(out) == ()


def test_nobody_packs_what_a_run_is_at(tiny: Path, tmp_path: Path) -> None:
    folder = _unpacked(tiny, tmp_path / "out.h5")
    with FileLock(folder / ".lock"), pytest.raises(InputError, match="in use by another run"):
        study.pack(folder, tmp_path / "out.h5")
    assert study.pack(folder, tmp_path / "out.h5")["points"] == 600


def test_a_database_that_is_not_finished_is_told_from_one_that_is_not_there(tiny: Path, tmp_path: Path) -> None:
    _unpacked(tiny, tmp_path / "out.h5")
    with pytest.raises(DatabaseError, match=r"out\.h5: its run is not finished: .*--resume"):
        open_database(tmp_path / "out.h5")


def test_parts_that_a_killed_run_left_beside_its_database_go(tiny: Path, tmp_path: Path) -> None:
    """Those of the same study, told or already without their journal; another's stay."""
    one, out = study.load_study(tiny), tmp_path / "out.h5"
    study.run(one, out)
    folder = study.parts_of(out)
    for journal, stays in ((one.id, False), (None, False), ("of another", True)):
        folder.mkdir()
        (folder / "points-000000000000-000000000010.h5").write_bytes(b"a shard")
        if journal:
            about = {"study_id": journal}
            (folder / "study.json").write_text(json.dumps(about | {"digest": study_folder._digest(about)}))
        assert study.run(one, out, resume=True).computed == 0
        assert folder.exists() == stays and store.verify(out) == ()


@pytest.mark.usefixtures("quick")
def test_what_others_put_among_the_parts_stays(tiny: Path, tmp_path: Path) -> None:
    folder = _unpacked(tiny, tmp_path / "out.h5")
    (folder / "notes.txt").write_text("why this study")
    study.run(study.load_study(tiny), tmp_path / "out.h5", resume=True)
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("name", ["with two spaces/out 1.h5", "Läufe/μ=0.35 ∂.h5", "[a]*?.h5", "-o.h5", "'quoted\".h5"])
def test_any_name_of_a_file_will_do(tiny: Path, tmp_path: Path, name: str) -> None:
    """Run, resumed, merged and asked from another folder, nothing left behind."""
    out = tmp_path / "there" / name
    out.parent.mkdir(parents=True)
    one = study.load_study(tiny)
    study.run(one, out)
    (out.parent / f".{out.name}.0123456789abcdef.tmp").write_bytes(b"half a merge, killed")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(out.parent)
        assert study.run(one, Path(out.name), resume=True).computed == 0
        with open_database(Path(out.name)) as db:
            assert len(db.query("advance_ratio < 0.1")["lock_number"]) == 60
        study.merge([Path(out.name)], Path(f"2 {out.name}"))
    assert {p.name for p in out.parent.iterdir()} - {f".{out.name}.0123456789abcdef.tmp"} == {out.name, f"2 {out.name}"}


def test_an_output_behind_a_link_is_where_the_link_is(tiny: Path, tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "disk", target_is_directory=True)
    study.run(study.load_study(tiny), tmp_path / "link" / "out.h5")
    assert [p.name for p in (tmp_path / "disk").iterdir()] == ["out.h5"]


def test_an_output_that_is_a_link_is_written_where_it_points_to(tiny: Path, tmp_path: Path) -> None:
    """Whether there is something or not; what was left half there goes."""
    disk, out = tmp_path / "disk", tmp_path / "out.h5"
    disk.mkdir()
    out.symlink_to(disk / "real.h5")
    (disk / ".real.h5.0123456789abcdef.tmp").write_bytes(b"half")
    study.run(study.load_study(tiny), out)
    tiny.write_text(tiny.read_text().replace("count = 300", "count = 599"))
    assert study.run(study.load_study(tiny), out, extend=True).points == 1198
    assert out.is_symlink() and [p.name for p in disk.iterdir()] == ["real.h5"]
    assert store.verify(disk / "real.h5") == () and {p.name for p in tmp_path.iterdir()} == {
        "disk", "out.h5", tiny.name
    }  # fmt: skip


@pytest.mark.skipif(not os.path.isdir("/sys/kernel"), reason="no folder here that nobody may write to")
def test_a_folder_that_may_not_be_written_to_is_one_sentence(tiny: Path) -> None:
    with pytest.raises(StorageError, match=r"could not be written, because .*; what was saved before is untouched"):
        study.run(study.load_study(tiny), "/sys/kernel/out.h5")


def test_a_database_is_read_while_it_is_extended(tiny: Path, tmp_path: Path) -> None:
    """A reader keeps what it has opened; who opens it later finds the new one."""
    out = tmp_path / "out.h5"
    study.run(study.load_study(tiny), out)
    tiny.write_text(tiny.read_text().replace("count = 300", "count = 599"))
    with open_database(out) as db:
        study.run(study.load_study(tiny), out, extend=True)
        assert len(db.query("advance_ratio < 0.1")["lock_number"]) == 60
    with open_database(out) as db:
        assert len(db.query("advance_ratio < 0.1")["lock_number"]) == 120


@pytest.mark.usefixtures("quick")
def test_a_failed_shard_does_not_stop_the_others(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = shards.TABLE_ROWS["points"]

    def failing(plan: Any, start: int, stop: int, *columns: Any) -> Any:
        if start == 200:
            raise InputError("this point cannot be")
        return real(plan, start, stop, *columns)

    monkeypatch.setitem(shards.TABLE_ROWS, "points", failing)
    report = study.run(study.load_study(file), tmp_path / "out.h5")
    assert [reason for _, reason in report.failed] == ["this point cannot be"] and report.computed == 9
    assert not (tmp_path / "out.h5").exists() and study.parts_of(tmp_path / "out.h5").exists()
    with pytest.raises(DatabaseError, match="1 of 10 shards are missing"):
        study.pack(study.parts_of(tmp_path / "out.h5"), tmp_path / "out.h5")


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("error", [np.linalg.LinAlgError("singular"), ValueError("no root"), ZeroDivisionError("by 0")])
def test_a_numerical_failure_is_a_failed_shard(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    real = shards.TABLE_ROWS["points"]

    def failing(plan: Any, start: int, stop: int, *columns: Any) -> Any:
        if start == 200:
            raise error
        return real(plan, start, stop, *columns)

    monkeypatch.setitem(shards.TABLE_ROWS, "points", failing)
    report = study.run(study.load_study(file), tmp_path / "out.h5")
    assert report.computed == 9 and len(report.failed) == 1
    assert str(error) in report.failed[0][1] and type(error).__name__ in report.failed[0][1]


def _no_room(program: str, kilobytes: int) -> subprocess.CompletedProcess[str]:
    """A child that may write so many kilobytes a file and prints the error it meets."""
    limited = f"""
import resource
from floquet.errors import StorageError
from floquet import study
from floquet.export import export
resource.setrlimit(resource.RLIMIT_FSIZE, ({kilobytes * 1024}, {kilobytes * 1024}))
try:
    {program}
except StorageError as error:
    print(error)
"""
    return subprocess.run([sys.executable, "-c", limited], capture_output=True, text=True)


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are POSIX")
def test_a_full_disk_in_a_worker_process_is_one_sentence(file: Path, tmp_path: Path) -> None:
    done = _no_room(f"study.run(study.load_study({str(file)!r}), {str(tmp_path / 'out.h5')!r}, workers=2)", 20)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert "limit on file sizes" in done.stdout and done.stdout.count("\n") == 1
    assert done.stdout.endswith("what was saved before is untouched, and --resume goes on from it\n")


def _unpacked(file: Path, out: Path) -> Path:
    """The folder of a finished study whose packing did not come about."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "packed", lambda *_, **__: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            study.run(study.load_study(file), out)
    return study.parts_of(out)


def _another_study(a: Path, b: Path) -> None:
    with h5py.File(a, "r+") as changed:
        changed.attrs["study_id"] = "f" * 32
        changed.attrs["attributes_digest"] = digests.attributes_digest(changed)


def _fewer_rows(a: Path, b: Path) -> None:
    with store.open_file(a) as source:
        attributes = dict(source.attributes)
        [(_, rows)] = list(source.chunks("points", list(store.POINTS)))
    store.write(a, {"points": {n: v[:-1] for n, v in rows.items()}}, attributes)


def _damaged(a: Path, b: Path) -> None:
    with h5py.File(a, "r+") as changed:
        changed["points/lock_number"][0] += 1.0


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("change", [_another_study, _fewer_rows, _damaged, lambda a, b: a.write_bytes(b.read_bytes())])
def test_pack_takes_only_sound_shards_of_the_study(file: Path, tmp_path: Path, change: Any) -> None:
    folder = _unpacked(file, tmp_path / "out.h5")
    first, second = sorted(folder.glob("points-*.h5"))[:2]
    change(first, second)
    with pytest.raises(DatabaseError, match=rf"1 of 10 shards are damaged or of another study.*{first.name}"):
        study.pack(folder, tmp_path / "out.h5")
    assert study.run(study.load_study(file), tmp_path / "out.h5", resume=True).computed == 1


@pytest.mark.usefixtures("quick")
def test_pack_says_what_is_wrong_with_its_folder(file: Path, tmp_path: Path) -> None:
    folder = _unpacked(file, tmp_path / "out.h5")
    (folder / "study.toml").write_bytes(b"\xff")
    with pytest.raises(DatabaseError, match=r"study\.toml: this file .* cannot be read"):
        study.pack(folder, tmp_path / "out.h5")
    (folder / "study.toml").unlink()
    with pytest.raises(DatabaseError, match=r"study\.toml: this file .* is missing"):
        study.pack(folder, tmp_path / "out.h5")
    for text in ("", "[]", '{"sizes": {"points": 0}, "points": 3}'):
        (folder / "study.json").write_text(text)
        with pytest.raises(DatabaseError, match=r"study\.json is damaged"):
            (folder / "study.toml").write_text("")
            study.pack(folder, tmp_path / "out.h5")
    (folder / "study.json").write_text("{")
    with pytest.raises(DatabaseError, match=r"study\.json is damaged"):
        study.run(study.load_study(file), tmp_path / "out.h5", resume=True)


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="children are forked")
def test_ten_kills_at_random_moments_lose_nothing(file: Path, tmp_path: Path) -> None:
    """A child is killed by SIGKILL ten times and resumed; the packed data equal those of a run in one go."""
    program = textwrap.dedent(f"""
        import json, os, random, signal, sys, time
        from floquet import store, study
        from floquet.study import shards as cut
        cut.POINT_SHARD, cut.LIMIT_SHARD = (10, 10), (1, 1)
        one, out = study.load_study({str(file)!r}), {str(tmp_path / "killed.h5")!r}
        random.seed(1431)

        def shards():
            folder = out + ".parts"
            return sum(f.endswith(".h5") for f in os.listdir(folder)) if os.path.isdir(folder) else 0

        for kill in range(10):
            before, child = shards(), os.fork()
            if child == 0:
                study.run(one, out, resume=True)
                os._exit(0)
            while kill % 2 == 0 and shards() == before:  # every other kill comes after some progress
                time.sleep(0.001)
            time.sleep(random.uniform(0.0, 0.05))
            os.kill(child, signal.SIGKILL)
            assert os.WIFSIGNALED(os.waitpid(child, 0)[1]), "the study was too short for ten kills"
        kept = len([f for f in os.listdir(out + ".parts") if f.endswith(".h5")])
        report = study.run(one, out, resume=True)
        study.run(one, {str(tmp_path / "whole.h5")!r})
        digests = [store.data_digest(p) for p in (out, {str(tmp_path / "whole.h5")!r})]
        print(json.dumps([kept, report.reused, *digests]))
    """)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    kept, reused, killed, whole = json.loads(done.stdout)
    assert killed == whole and 0 < reused <= kept


def test_how_many_limits_are_computed_together_makes_no_difference(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests = set()
    for together in (1024, 2):
        monkeypatch.setattr(shards, "TOGETHER", together)
        monkeypatch.setattr(shards, "LIMIT_SHARD", (5, 5))
        out = tmp_path / f"{together}.h5"
        assert study.run(study.load_study(file), out).limits > 5
        digests.add(store.data_digest(out))
    assert len(digests) == 1


@pytest.mark.usefixtures("quick")
def test_resume_keeps_the_sizes_of_shards_it_began_with(
    tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = _unpacked(tiny, tmp_path / "out.h5")
    min(folder.glob("points-*.h5")).unlink()
    monkeypatch.setattr(shards, "POINT_SHARD", (70, 70))
    left = tmp_path / ".out.h5.99.tmp"
    left.write_bytes(b"half a database of a run that was killed while it packed")
    report = study.run(study.load_study(tiny), tmp_path / "out.h5", resume=True)
    assert (report.computed, report.reused) == (1, 6) and not left.exists()


@pytest.mark.parametrize("sizes", [{}, {"points": 0, "limits": 3}, {"points": "100", "limits": 3}, None, [100, 3]])
def test_sizes_of_shards_that_cannot_be_are_one_sentence(tiny: Path, tmp_path: Path, sizes: Any) -> None:
    folder = study.parts_of(tmp_path / "out.h5")
    folder.mkdir()
    (folder / "study.json").write_text(json.dumps({"study_id": study.load_study(tiny).id, "sizes": sizes}))
    with pytest.raises(DatabaseError, match=r"study\.json is damaged"):
        study.run(study.load_study(tiny), tmp_path / "out.h5", resume=True)


def _deadly(plan: Any, shard: shards.Shard, parts: shards.Parts) -> str:
    """What a worker does, but some shards end it."""
    if shard.name.startswith(os.environ["DEADLY"]):
        os._exit(9)
    return shards.make(plan, shard, parts)


@pytest.mark.usefixtures("quick")
def test_a_shard_that_ends_its_workers_is_given_up_and_the_others_are_made(
    tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, out = study.load_study(tiny), tmp_path / "out.h5"
    with monkeypatch.context() as patch:
        patch.setenv("DEADLY", "points-000000000200")
        patch.setattr(workers, "make", _deadly)
        report = study.run(one, out, workers=2)
    [(name, reason)] = report.failed
    assert name.startswith("points-000000000200") and "ended 3 worker processes" in reason
    assert report.computed == 6 and not out.exists()
    assert study.run(one, out, resume=True).reused == 6
    study.run(one, tmp_path / "whole.h5")
    assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5")


@pytest.mark.usefixtures("quick")
def test_workers_that_all_die_end_the_run(tiny: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DEADLY", "")
    monkeypatch.setattr(workers, "make", _deadly)
    with pytest.raises(FailedError, match=r"dies at once.*--resume"):
        study.run(study.load_study(tiny), tmp_path / "out.h5", workers=2)


@pytest.mark.usefixtures("quick")
def test_a_worker_killed_from_outside_costs_nothing(tiny: Path, tmp_path: Path) -> None:
    """As a system short of memory does it: the pool is made anew, and the data are the same."""
    one, killed = study.load_study(tiny), []

    def kill(done: int, total: int) -> None:
        if done == 1:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()

    report = study.run(one, tmp_path / "out.h5", workers=2, progress=kill)
    study.run(one, tmp_path / "whole.h5")
    assert killed and report.failed == () and report.computed == 7
    assert store.data_digest(tmp_path / "out.h5") == store.data_digest(tmp_path / "whole.h5")


@pytest.mark.parametrize("how", ["os.kill(os.getpid(), signal.SIGKILL)", "raise KeyboardInterrupt"])
@pytest.mark.skipif(sys.platform == "win32", reason="signals are POSIX")
def test_workers_leave_at_once_when_their_parent_is_killed_or_interrupted(tmp_path: Path, how: str) -> None:
    program = tmp_path / "parent.py"
    program.write_text(
        textwrap.dedent(f"""
            import os, signal, time
            from floquet import study
            if __name__ == "__main__":
                with study.processes(1) as pool:
                    print(pool.submit(os.getpid).result(), flush=True)
                    pool.submit(time.sleep, 60)
                    time.sleep(0.2)
                    {how}
        """)
    )
    environment = os.environ | {"PYTHONPATH": str(Path(study.__file__).parents[2])}
    parent = subprocess.Popen(
        [sys.executable, str(program)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
    )
    assert parent.stdout is not None
    worker = int(parent.stdout.readline())
    end = threading.Thread(target=parent.stdout.read, daemon=True)  # it comes when no process holds the pipe any more
    end.start()
    end.join(20.0)  # the worker has 60 s to sleep
    if end.is_alive():
        os.kill(worker, signal.SIGKILL)
        pytest.fail("the worker outlived its parent by 20 s")
    parent.stdout.close()
    assert parent.wait() != 0


# ---------------------------------------------------------------------- merging and exporting
@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    paths = []
    for name, gamma in (("a", "8.0"), ("b", "9.0")):
        text = (
            SMALL.replace("8.0", gamma)
            .replace("6.0", "6.5" if name == "b" else "6.0")
            .replace("count = 60", "count = 5")
            .replace("absolute_tolerances = [0.02]", "")
        )
        (tmp_path / f"{name}.toml").write_text(
            "\n".join(line for line in text.splitlines() if not line.startswith("grid"))
        )
        study.run(study.load_study(tmp_path / f"{name}.toml"), tmp_path / f"{name}.h5")
        paths.append(tmp_path / f"{name}.h5")
    return paths[0], paths[1]


def test_merge_numbers_the_rotors_on(two: tuple[Path, Path], tmp_path: Path) -> None:
    assert study.merge(two, tmp_path / "m.h5") == {"points": 20, "limits": 12}
    with store.open_file(tmp_path / "m.h5") as merged, store.open_file(two[1]) as second:
        [(_, rows)] = list(merged.chunks("points", ["rotor", "lock_number", "error_regressing"]))
        [(_, theirs)] = list(second.chunks("points", ["error_regressing"]))
        assert rows["rotor"].tolist() == [r for r in range(4) for _ in range(5)]
        assert merged.names == ("eight", "two blades", "eight", "two blades")
        np.testing.assert_array_equal(rows["error_regressing"][10:], theirs["error_regressing"])
    assert store.verify(tmp_path / "m.h5") == ()


def test_merge_keeps_a_table_that_the_first_file_has_not(two: tuple[Path, Path], tmp_path: Path) -> None:
    bare = tmp_path / "bare.toml"
    bare.write_text((tmp_path / "a.toml").read_text().replace("tolerances = [0.05]", "tolerances = []"))
    study.run(study.load_study(bare), tmp_path / "bare.h5")
    assert study.merge([tmp_path / "bare.h5", two[1]], tmp_path / "m.h5") == {"points": 20, "limits": 6}
    with store.open_file(tmp_path / "m.h5") as merged:
        assert set(next(merged.chunks("limits", ["rotor"]))[1]["rotor"].tolist()) == {2, 3}


def test_merge_refuses_what_does_not_belong_together(two: tuple[Path, Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="hold the same study"):
        study.merge([two[0], two[0]], tmp_path / "m.h5")
    other = tmp_path / "c.toml"
    other.write_text((tmp_path / "a.toml").read_text() + "reversed_flow = true\n")
    study.run(study.load_study(other), tmp_path / "c.h5")
    with pytest.raises(InputError, match="differ in options"):
        study.merge([two[0], tmp_path / "c.h5"], tmp_path / "m.h5")
    assert not (tmp_path / "m.h5").exists()


def test_a_rotor_of_another_name_is_no_other_rotor(two: tuple[Path, Path], tmp_path: Path) -> None:
    for name in ("A", "B"):
        text = f'[study]\nname = "x"\n[rotors]\nlist = [{{ name = "{name}", lock_number = 8.0 }}]\n'
        (tmp_path / "x.toml").write_text(text + "[axes]\nadvance_ratio = [0.1, 0.2]\n" + f"# {name}")
        study.run(study.load_study(tmp_path / "x.toml"), tmp_path / f"{name}.h5")
    with pytest.raises(InputError, match=r"hold the same study|has every design and advance ratio of"):
        study.merge([tmp_path / "A.h5", tmp_path / "B.h5"], tmp_path / "m.h5")


def test_a_design_that_a_database_has_twice_is_looked_at_each_time(tmp_path: Path) -> None:
    ratios = {"a": "[0.1, 0.2]", "b": "[0.3, 0.4]", "c": "[0.4, 0.5]", "d": "[0.5, 0.6]", "e": "[0.1, 0.3]"}
    for name, values in ratios.items():
        text = f'[study]\nname = "{name}"\n[rotors]\nlist = [{{ lock_number = 8.0 }}]\n[axes]\n'
        (tmp_path / f"{name}.toml").write_text(f"{text}advance_ratio = {values}\n")
        study.run(study.load_study(tmp_path / f"{name}.toml"), tmp_path / f"{name}.h5")
    a, b, c, d, e = (tmp_path / f"{name}.h5" for name in ratios)
    study.merge([a, b], tmp_path / "ab.h5")
    for pair in ([tmp_path / "ab.h5", c], [c, tmp_path / "ab.h5"]):
        with pytest.raises(InputError, match=r"both have a rotor of lock_number 8.* at μ = 0.4, and its row"):
            study.merge(pair, tmp_path / "m.h5")
    with pytest.raises(InputError, match=r"ab.h5 has every design and advance ratio of .*e.h5"):
        study.merge([tmp_path / "ab.h5", e], tmp_path / "m.h5")
    assert study.merge([tmp_path / "ab.h5", d], tmp_path / "m.h5")["points"] == 6


def test_rows_keep_the_number_of_the_engine_that_computed_them(
    tiny: Path, two: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for path in two:
        with h5py.File(path, "r+") as file:
            file.attrs["engine_version"] = 2
            file.attrs["attributes_digest"] = digests.attributes_digest(file)
    study.merge(two, tmp_path / "m.h5")
    with store.open_file(tmp_path / "m.h5") as merged:
        assert merged.attributes["engine_version"] == 2
    folder = _unpacked(tiny, tmp_path / "out.h5")
    monkeypatch.setattr(packing, "ENGINE", 99)
    study.pack(folder, tmp_path / "packed.h5")
    with store.open_file(tmp_path / "packed.h5") as packed:
        assert packed.attributes["engine_version"] != 99
    with h5py.File(min(folder.glob("points-*.h5")), "r+") as file:
        file.attrs["engine_version"] = 2
        file.attrs["attributes_digest"] = digests.attributes_digest(file)
    with pytest.raises(DatabaseError, match="its parts are of engines 2, "):
        study.pack(folder, tmp_path / "mixed.h5")


def test_leftovers_of_those_that_live_stay_and_a_file_that_came_meanwhile_is_kept(tmp_path: Path) -> None:
    with store.atomic(tmp_path / "a.h5") as temporary:
        store.remove_leftovers(tmp_path, "a.h5")
        assert temporary.exists()
        temporary.write_bytes(b"one")
    left = tmp_path / ".a.h5.0123456789abcdef.tmp"
    left.write_bytes(b"half")
    store.remove_leftovers(tmp_path, "a.h5")
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]
    with (
        pytest.raises(InputError, match="has been written by another program meanwhile"),
        store.atomic(tmp_path / "a.h5", replace=False) as temporary,
    ):
        temporary.write_bytes(b"two")
    (tmp_path / "a.h5").chmod(0o600)
    with store.atomic(tmp_path / "a.h5") as temporary:
        temporary.write_bytes(b"three")
    assert (tmp_path / "a.h5").stat().st_mode & 0o777 == 0o600 and (tmp_path / "a.h5").read_bytes() == b"three"
    assert [p.name for p in tmp_path.iterdir()] == ["a.h5"]


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("old", "new"), [('"points": ', '"points": 1'), ('"names": [', '"names": [1'), ("title", "titel")]
)
def test_a_journal_that_was_changed_is_damaged(tiny: Path, tmp_path: Path, old: str, new: str) -> None:
    folder = _unpacked(tiny, tmp_path / "out.h5")
    journal = folder / "study.json"
    journal.write_text(journal.read_text().replace(old, new))
    with pytest.raises(DatabaseError, match=r"its study\.json is damaged"):
        study.pack(folder, tmp_path / "packed.h5")


def test_merge_refuses_a_row_that_two_files_have_and_names_it(two: tuple[Path, Path], tmp_path: Path) -> None:
    with store.open_file(two[0]) as file:
        ratios = next(file.chunks("points", ["advance_ratio"]))[1]["advance_ratio"].tolist()
    for rotors, what in (
        (
            'list = [{ name = "eight", lock_number = 8.0 }, { lock_number = 9.5 }]',
            r"the rotor 'eight' \(lock_number 8.*\) at μ",
        ),
        ("list = [{ lock_number = 9.5 }, { lock_number = 9.25 }]", "a rotor of lock_number 9.5, .*blades 4.* at μ"),
    ):
        axis = f"[axes]\nadvance_ratio = [{ratios[1]}, 0.7771]\n"
        text = f'[study]\nname = "x"\n[rotors]\n{rotors}\n{axis}'
        (tmp_path / "x.toml").write_text(text)
        study.run(study.load_study(tmp_path / "x.toml"), tmp_path / "x.h5")
        (tmp_path / "y.toml").write_text(text.replace("0.7771", "0.7772"))
        study.run(study.load_study(tmp_path / "y.toml"), tmp_path / "y.h5")
        with pytest.raises(InputError, match=rf"x\.h5 and .*y\.h5 both have {what} = {ratios[1]:g}.*--extend"):
            study.merge([tmp_path / "x.h5", tmp_path / "y.h5"], tmp_path / "m.h5")
        (tmp_path / "x.h5").unlink()
        (tmp_path / "y.h5").unlink()


def test_merge_refuses_a_study_run_with_maps_and_without(two: tuple[Path, Path], tmp_path: Path) -> None:
    other = tmp_path / "c.toml"
    other.write_text((tmp_path / "a.toml").read_text() + "map = true\n")
    study.run(study.load_study(other), tmp_path / "c.h5")
    for files in ([two[0], tmp_path / "c.h5"], [tmp_path / "c.h5", two[1], two[0]]):
        with pytest.raises(InputError, match=r"every design and advance ratio of .*: its rows would stand twice"):
            study.merge(files, tmp_path / "m.h5")
    assert not (tmp_path / "m.h5").exists()


@pytest.mark.parametrize("ending", ["csv", "parquet", "nc"])
def test_exports_hold_the_rows(two: tuple[Path, Path], tmp_path: Path, ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    out = export(two[0], tmp_path / f"out.{ending}", "limits")
    with store.open_file(two[0]) as file:
        [(_, rows)] = list(file.chunks("limits", ["limit", "cause"]))
    if ending == "csv":
        with out.open(newline="") as source:
            read = list(csv.DictReader(source))
        assert [float(r["limit"]) for r in read] == rows["limit"].tolist() and read[0]["mode"] == "regressing"
        assert list(read[0])[:2] == ["rotor", "rotor_name"]
        assert {(r["rotor"], r["rotor_name"]) for r in read} == {("0", "eight"), ("1", "two blades")}
        return
    if ending == "parquet":
        columns = pytest.importorskip("pyarrow.parquet").read_table(out)
        found = columns["limit"].to_numpy()
        assert columns.column_names[:2] == ["rotor", "rotor_name"]
        assert set(columns["rotor_name"].to_pylist()) == {"eight", "two blades"}
    else:
        xarray = pytest.importorskip("xarray")
        pytest.importorskip("h5netcdf")
        with xarray.open_dataset(out) as data, xarray.open_dataset(two[0], group="limits") as source:
            found = data["limit"].values
            assert data.identical(source.assign_attrs(data.attrs)) and data.attrs["title"] == "small"
    np.testing.assert_array_equal(found, rows["limit"])


def test_an_unknown_format_is_refused(two: tuple[Path, Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"did you mean '\.csv'"):
        export(two[0], tmp_path / "x.cvs")


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are POSIX")
@pytest.mark.parametrize("ending", ["csv", "parquet", "nc"])
def test_an_export_to_a_full_disk_is_one_sentence(two: tuple[Path, Path], tmp_path: Path, ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    before = sorted(tmp_path.iterdir())
    done = _no_room(f"export({str(two[0])!r}, {str(tmp_path / f'x.{ending}')!r})", 2)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert "limit on file sizes" in done.stdout and done.stdout.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_an_export_of_nameless_rotors_has_empty_names(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        'study = { name = "s" }\nrotors = { grid = { lock_number = [4, 8] } }\naxes = { advance_ratio = [0.1] }'
    )
    study.run(study.load_study(path), tmp_path / "s.h5")
    with export(tmp_path / "s.h5", tmp_path / "s.csv").open(newline="") as source:
        assert [(r["rotor"], r["rotor_name"]) for r in csv.DictReader(source)] == [("0", ""), ("1", "")]
