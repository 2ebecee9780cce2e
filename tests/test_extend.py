"""A study that has grown: what its database has is copied, the rest computed, and nobody can tell."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from floquet import store, study
from floquet.errors import DatabaseError, InputError
from floquet.query import open_database
from floquet.study import alike, extending, running, shards

SMALL = """
[study]
name = "small"
schema = 1
[rotors]
{rotors}
[axes]
advance_ratio = {ratios}
[compare]
tolerances = {tolerances}
map = {map}
mu_max = {mu_max}
model = "{model}"
[output]
columns = {columns}
"""
ROTORS = 'grid = { lock_number = [6.0, 8.0], blades = [2, 3] }\nlist = [{ name = "soft", lock_number = 5.0 }]'
MORE = (
    "grid = { lock_number = [5.0, 6.0, 8.0], blades = [3, 2] }\nlist = [{ lock_number = 5.0 }]\n"
    'random = { count = 3, seed = 1, lock_number = [4.0, 12.0], hub = "teetering", blades = 2 }'
)
BEFORE = {
    "rotors": ROTORS, "ratios": "{ start = 0.0, stop = 0.5, count = 6 }", "tolerances": "[0.05]", "map": "false",
    "mu_max": 0.3, "model": "auto", "columns": '["error_regressing", "exponent_1"]',
}  # fmt: skip
FINER = "{ start = 0.0, stop = 0.5, count = 11 }"
Written = Callable[..., study.Study]


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 16 rows, and several shards of each table."""
    monkeypatch.setattr(store.schema, "CHUNK_ROWS", 16)
    monkeypatch.setattr(shards, "POINT_SHARD", (32, 32))
    monkeypatch.setattr(shards, "LIMIT_SHARD", (3, 3))


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def make(**changes: Any) -> study.Study:
        (tmp_path / "small.toml").write_text(SMALL.format(**{**BEFORE, **changes}))
        return study.load_study(tmp_path / "small.toml")

    return make


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """Points and designs that are computed."""
    asked = {"points": 0, "limits": 0}

    def counting(table: str, made: Any) -> Any:
        def rows(plan: Any, index: Any, *columns: Any) -> Any:
            asked[table] += len(index)
            return made(plan, index, *columns)

        return rows

    monkeypatch.setattr(extending, "points_at", counting("points", extending.points_at))
    monkeypatch.setattr(extending, "limits_at", counting("limits", extending.limits_at))
    return asked


LONG = {"ratios": "{ start = 0.0, stop = 1.0, count = 240 }", "map": "true", "tolerances": "[]"}


@pytest.mark.parametrize(("before", "changes", "points", "limits"), [
    ({}, {"rotors": MORE}, 5 * 6, 5),  # one design stands twice
    ({}, {"ratios": FINER}, 5 * 5, 0),
    ({}, {"rotors": MORE, "ratios": FINER}, 5 * 11 + 5 * 5, 5),
    ({}, {"tolerances": "[0.05, 0.1]"}, 0, 5),
    ({"tolerances": "[0.05, 0.1]"}, {"tolerances": "[0.1, 0.05]"}, 0, 5),
    ({}, {"mu_max": 0.4}, 0, 5),
    ({"tolerances": "[]"}, {"tolerances": "[0.05]"}, 0, 5),
    (LONG, {"rotors": MORE}, 5 * 240, 0),
    (LONG, {"ratios": "{ start = 0.0, stop = 1.0, count = 479 }"}, 5 * 479, 0),
    ({}, {"ratios": "{ start = 0.0, stop = 0.5, count = 501 }"}, 5 * 501, 0),  # few points have other last digits
])  # fmt: skip
def test_data_are_those_of_a_run_from_nothing(
    written: Written, tmp_path: Path, counted: dict[str, int], before: dict[str, Any], changes: dict[str, Any],
    points: int, limits: int, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    out, grown = tmp_path / "out.h5", written(**{**before, **changes})
    if grown.plan.points >= 1024:
        monkeypatch.setattr(store.schema, "CHUNK_ROWS", 512)
        monkeypatch.setattr(shards, "POINT_SHARD", (1024, 1024))
    study.run(written(**before), out)
    grown = written(**{**before, **changes})
    report = study.run(grown, out, extend=True)
    study.run(grown, tmp_path / "whole.h5")
    assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5") and store.verify(out) == ()
    assert counted == {"points": points, "limits": limits} and report.copied == grown.plan.points - points
    with store.open_file(out) as file, store.open_file(tmp_path / "whole.h5") as whole:
        assert file.attributes["study_id"] == grown.id and file.names == whole.names
    assert not study.parts_of(out).exists()


def test_workers_copy_too(written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()  # they see no chunks of 16 rows
    out = tmp_path / "out.h5"
    study.run(written(ratios="{ start = 0.0, stop = 0.5, count = 251 }"), out)
    grown = written(rotors=MORE, ratios="{ start = 0.0, stop = 0.5, count = 501 }")
    report = study.run(grown, out, extend=True, workers=2)
    study.run(grown, tmp_path / "whole.h5")
    assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5") and report.copied == 5 * 251


def test_rows_that_are_there_are_taken_and_not_computed(written: Written, tmp_path: Path) -> None:
    """A value that no computation gives is there afterwards."""
    out = tmp_path / "out.h5"
    first = written()
    study.run(first, out)
    with store.open_file(out) as file:
        [(_, rows), *_] = file.chunks("points", list(file.columns("points")), 0, 6)
        attributes = file.attributes
    rows["error_regressing"][2] = 77.0
    store.write(out, {"points": rows}, {**attributes, "rotor_names": "[]"})
    study.run(written(rotors=MORE), out, extend=True)
    with open_database(out) as db:
        found = db.query("error_regressing == 77")
    assert found["advance_ratio"].tolist() == [0.2] and found["lock_number"].tolist() == [5.0]


def test_what_is_there_survives_until_the_new_one_is_whole(
    written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out.h5"
    study.run(written(), out)
    before, grown = out.read_bytes(), written(ratios=FINER)
    real, made = shards.make, []

    def interrupted(*given: Any) -> str:
        if len(made) == 3:
            raise KeyboardInterrupt
        made.append(given)
        return real(*given)

    with monkeypatch.context() as patch:
        patch.setattr("floquet.study.workers.make", interrupted)
        with pytest.raises(KeyboardInterrupt):
            study.run(grown, out, extend=True)
    assert out.read_bytes() == before
    with pytest.raises(InputError, match=r"unfinished run.*--resume"):
        study.run(grown, out, extend=True)
    with monkeypatch.context() as patch:
        patch.setattr("floquet.study.packing._joined", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            study.run(grown, out, extend=True, resume=True)
    assert out.read_bytes() == before
    assert study.run(grown, out, extend=True, resume=True).computed == 0
    study.run(grown, tmp_path / "whole.h5")
    assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5")
    assert study.run(grown, out, extend=True).computed == 0  # it is this study already


def test_two_that_extend_at_once_take_no_row_from_a_wrong_place(
    written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between looking at the database and having the folder another one has replaced it; and while rows are taken."""
    out = tmp_path / "out.h5"
    study.run(written(), out)
    grown, more = written(ratios=FINER), written(rotors=MORE, ratios=FINER)
    real = running.known

    meanwhile: list[study.Study] = []

    def overtaken(path: Path, asked: study.Study) -> Any:
        found = real(path, asked)
        monkeypatch.setattr(running, "known", real)
        study.run(meanwhile[0], path, extend=True)
        return found

    for first, asked in ((grown, more), (more, more)):
        meanwhile[:] = [first]
        out.unlink()
        study.run(written(), out)
        monkeypatch.setattr(running, "known", overtaken)
        study.run(asked, out, extend=True)
        study.run(asked, tmp_path / "whole.h5")
        assert store.data_digest(out) == store.data_digest(tmp_path / "whole.h5")
        assert not study.parts_of(out).exists()
        (tmp_path / "whole.h5").unlink()
    study.run(grown, tmp_path / "other.h5")
    there = extending.known(out, more)
    (tmp_path / "other.h5").replace(out)
    with pytest.raises(DatabaseError, match="replaced while it was extended"):
        there.rows("points", more.plan, 0, 4, more.columns)


def test_the_way_on_is_to_extend(written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    study.run(written(), out)
    grown = written(ratios=FINER)
    with pytest.raises(InputError, match=r"another study .*--extend if it has grown"):
        study.run(grown, out, resume=True)
    with monkeypatch.context() as patch:
        patch.setattr("floquet.study.packing._joined", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            study.run(grown, out, extend=True)
    with pytest.raises(InputError, match=r"unfinished extension .*--extend --resume"):
        study.run(grown, out, resume=True)
    assert study.run(grown, out, resume=True, extend=True).computed == 0


def test_damage_is_not_copied(written: Written, tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    study.run(written(), out)
    with h5py.File(out, "r+") as changed:
        changed["points/error_regressing"][20] = 0.5
    report = study.run(written(ratios=FINER), out, extend=True)
    assert report.failed and all("do not match their digests" in reason for _, reason in report.failed)


@pytest.mark.parametrize(("changes", "sentence"), [
    ({"model": "flapping"}, "other options of .compare."),
    ({"columns": '["lock", "exponent_1"]'}, "has no lock, which the study stores"),
    ({"map": "true"}, "without map = true"),
    ({"columns": '["exponent_1"]'}, r"columns that the study does not store, and they would be lost \(\w+"),
    ({"tolerances": "[0.1]"}, r"limits of the tolerance 0\.05, which the study has not"),
    ({"tolerances": "[]"}, r"limits of the tolerance 0\.05, which the study has not"),
    ({"mu_max": 0.2}, r"sought up to μ = 0\.3, and the study seeks them up to 0\.2"),
])  # fmt: skip
def test_a_study_that_has_no_row_there_is_refused(
    written: Written, tmp_path: Path, changes: dict[str, Any], sentence: str
) -> None:
    out = tmp_path / "out.h5"
    study.run(written(), out)
    with pytest.raises(InputError, match=sentence):
        study.run(written(**changes), out, extend=True)
    assert store.verify(out) == () and not study.parts_of(out).exists()


def test_there_must_be_one_study(written: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.h5"
    with pytest.raises(InputError, match="not there to be extended"):
        study.run(written(), out, extend=True)
    study.run(written(), out)
    study.run(written(rotors="list = [{ lock_number = 9.0 }]"), tmp_path / "b.h5")
    study.merge([out, tmp_path / "b.h5"], tmp_path / "m.h5")
    with pytest.raises(InputError, match="not of one study"):
        study.run(written(ratios=FINER), tmp_path / "m.h5", extend=True)
    monkeypatch.setattr(extending, "ENGINE", extending.ENGINE + 1)
    with pytest.raises(InputError, match="computed by engine"):
        study.run(written(ratios=FINER), out, extend=True)


def test_a_study_that_has_not_every_row_is_refused(tmp_path: Path) -> None:
    """Nothing of a database is lost: neither designs nor advance ratios, and the file is as it was."""
    out = tmp_path / "out.h5"
    file = tmp_path / "study.toml"
    text = """
[study]
name = "shrinking"
[rotors]
grid = {{ lock_number = {gamma} }}
[axes]
advance_ratio = {mu}
[compare]
tolerances = []
[output]
columns = ["verdict"]
"""
    file.write_text(text.format(gamma=[4.0, 8.0], mu=[0.1, 0.2, 0.3]))
    study.run(study.load_study(file), out)
    before = out.read_bytes()
    for gamma, mu, lost in (([4.0], [0.1, 0.2, 0.3, 0.4], 3), ([4.0, 8.0, 9.0], [0.1, 0.3], 2), ([5.0], [0.5], 6)):
        file.write_text(text.format(gamma=gamma, mu=mu))
        with pytest.raises(InputError, match=f"has {lost} rows of designs or advance ratios that the study has not"):
            study.run(study.load_study(file), out, extend=True)
        assert out.read_bytes() == before and not study.parts_of(out).exists()


# ---------------------------------------------------------------------- alike
@pytest.mark.parametrize("seed", range(5))
def test_designs_are_found_as_a_dictionary_finds_them(seed: int) -> None:
    """Values of few bits, so that many designs are equal and many differ in one bit of one parameter."""
    g = np.random.default_rng(seed)

    def some(count: int) -> dict[str, Any]:
        rows = {name: g.choice([0.0, -0.0, 8.0, np.nextafter(8.0, 9.0)], count) for name in alike.DESIGN}
        return rows | {name: np.zeros(count) for name in alike.DESIGN[3:]}

    wanted, there = some(200), some(40)
    bits = [list(zip(*(rows[name].view("u8").tolist() for name in alike.DESIGN), strict=True))
            for rows in (wanted, there)]  # fmt: skip
    numbers = {design: i for i, design in reversed(list(enumerate(bits[1])))}
    found = alike.first_of(alike.marks(wanted), alike.marks(there))
    assert found.tolist() == [numbers.get(design, -1) for design in bits[0]]
    assert -1 in found and len(set(found.tolist())) > 20
    assert alike.first_of(alike.marks(wanted), alike.marks(some(0))).tolist() == [-1] * 200
