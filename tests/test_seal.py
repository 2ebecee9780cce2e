"""Damaged metadata are noticed before HDF5 sees them; files without a seal are looked at by a child process."""

from __future__ import annotations

import json
import lzma
import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from floquet import checking, store, study
from floquet.cli import main
from floquet.errors import DamageError, DatabaseError, InputError
from floquet.period_map import Method
from floquet.query import open_database
from floquet.store import digests, guard, reading, seal
from floquet.studyfile import load_study

EXAMPLES = sorted((Path(__file__).parent.parent / "data/reference").glob("schema-*.h5.xz"))
STUDY = """
[study]
name = "seal"
schema = 1
[rotors]
list = [{ name = "Bo 105", lock_number = 5.087, hinge_stiffness = 0.248 }, { lock_number = 8.0 }]
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 12 }
[compare]
tolerances = []
[output]
columns = ["exponent_1", "exponent_2", "exponent_error", "verdict", "method"]
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("seal")
    (folder / "seal.toml").write_text(STUDY, encoding="utf-8")
    study.run(load_study(folder / "seal.toml"), folder / "seal.h5")
    return folder / "seal.h5"


@pytest.fixture
def path(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(made, tmp_path / "a.h5"))


def metadata(path: Path) -> list[tuple[int, int]]:
    """What the seal covers."""
    with path.open("rb") as file:
        found = seal.Seal(file)
        file.seek(found.end)
        return [tuple(pair) for pair in np.frombuffer(file.read(16 * found.count), "<u8").reshape(-1, 2).tolist()]


def looked_at(path: Path, sample: int) -> dict[str, Any]:
    """What the child of ``check`` does, here."""
    return checking._look(str(path), sample, 0, lambda: None)


def no_child(*_: object, **__: object) -> None:
    raise AssertionError("a child was asked")


def test_the_seal_covers_all_but_the_chunks(path: Path) -> None:
    with h5py.File(path) as file:
        chunks = seal.chunk_extents(file["points"].values())
    covered = np.zeros(path.stat().st_size, int)
    for first, length in (*metadata(path), *chunks):
        covered[first : first + length] += 1
    with path.open("rb") as file:
        end = seal.Seal(file).end
    assert (
        np.all(covered[:end] == 1) and not covered[end:].any() and end + 16 * len(metadata(path)) + 48 == covered.size
    )


def test_any_changed_byte_of_the_metadata_is_damage_before_hdf5_looks(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "ask", no_child)
    image, luck = path.read_bytes(), np.random.default_rng(1)
    monkeypatch.setattr(reading.h5py, "File", no_child)
    for first, length in metadata(path):
        at = int(first + luck.integers(length))
        path.write_bytes(image[:at] + bytes([image[at] ^ 1 << luck.integers(8)]) + image[at + 1 :])
        with pytest.raises(DatabaseError, match=r"metadata|not an HDF5 file"):
            store.open_file(path)
    for at in range(len(image) - 48 - 16 * len(metadata(path)), len(image) - 16, 5):
        path.write_bytes(image[:at] + bytes([image[at] ^ 0x80]) + image[at + 1 :])
        with pytest.raises(DamageError, match="metadata"):
            store.open_file(path)


def test_extents_that_point_anywhere_are_damage(path: Path) -> None:
    """Also where sums of them overflow."""
    image = path.read_bytes()
    with path.open("rb") as file:
        end = seal.Seal(file).end
    for pair in ((2**64 - 1, 1), (0, 2**64 - 1), (end, 1), (5, 0)):
        path.write_bytes(image[: end + 16] + struct.pack("<QQ", *pair) + image[end + 32 :])
        with pytest.raises(DamageError, match="metadata"):
            store.open_file(path)


def test_a_sealed_file_needs_no_child(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "ask", no_child)
    with store.open_file(path) as file:
        assert file.sealed


@pytest.mark.parametrize("cut", [1, 16, 47, 48, 49, -1, -4096], ids="{:d} short".format)
def test_what_is_left_of_a_seal_is_damage(path: Path, cut: int) -> None:
    image = path.read_bytes()
    path.write_bytes(image[:-cut] if cut > 0 else image + bytes(-cut))
    with pytest.raises(DamageError, match="metadata"):
        store.open_file(path)
    with pytest.raises(DamageError, match="metadata"):
        looked_at(path, 0)


def test_files_without_a_seal_are_examined_and_read(path: Path) -> None:
    with open_database(path) as database:
        expected = database.query(columns="*")
    with h5py.File(path, "r+"):
        pass  # it cuts off what is behind its end
    with store.open_file(path) as file:
        assert not file.sealed
    with open_database(path) as database:
        for name, values in database.query(columns="*").items():
            assert values.tolist() == expected[name].tolist() or np.array_equal(values, expected[name], equal_nan=True)
    assert not looked_at(path, 0)["sealed"]


def test_the_same_numbers_packed_in_another_way_are_read(path: Path, tmp_path: Path) -> None:
    with store.open_file(path) as file:
        expected = {name: values.copy() for _, rows in file.chunks("points", list(file.columns("points")))
                    for name, values in rows.items()}  # fmt: skip
    with h5py.File(path, "r+") as file:
        for level in (file["points/exponent_error"], file["points/exponent_1_re"]):
            level[:] = level[:]
    with store.open_file(path) as file:
        for name, values in expected.items():
            np.testing.assert_array_equal(next(file.chunks("points", [name]))[1][name], values)
    assert looked_at(path, 3)["recomputed"][0]["equal"] == 3
    study.merge([path], tmp_path / "again.h5")
    assert store.data_digest(tmp_path / "again.h5") == store.data_digest(path)


def test_a_seed_is_no_negative_number(path: Path) -> None:
    with pytest.raises(InputError, match="seed = -1 is no number"):
        checking.check(path, seed=-1)


def test_a_file_without_a_seal_whose_words_were_changed_is_refused(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["rotor_names"] = '["Puma", ""]'
    with pytest.raises(DamageError, match="attributes and schema"):
        open_database(path)


def test_variables_that_are_stored_elsewhere_are_refused(path: Path, tmp_path: Path) -> None:
    other = Path(shutil.copy(path, tmp_path / "other.h5"))
    with h5py.File(path, "r+") as file:
        del file["points/lock_number"]
        file["points/lock_number"] = h5py.ExternalLink(str(other), "points/lock_number")
        file.attrs["attributes_digest"] = digests.attributes_digest(file)
    with pytest.raises(DamageError):
        open_database(path)


def test_rows_that_are_numbered_wrongly_are_noticed(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["points/row"][3] = 4
    assert store.verify(path) == ("points/row",)


# ---------------------------------------------------------------------- the child
CHILDREN = {
    "dies": ("import os; os.abort()", r"crashed \(SIGABRT\)"),
    "hangs": ("import time; time.sleep(20)", "hung"),
    "fails": ("raise SystemExit(3)", r"failed \(exit status 3\)"),
    "eats": ("from floquet.store import guard; guard.answer(lambda beat: [bytes(1 << 30) for _ in range(9)], 'x')",
             "out of memory"),
}  # fmt: skip


@pytest.mark.skipif(sys.platform != "linux", reason="signals and limits are named as Linux has them")
@pytest.mark.parametrize("what", CHILDREN)
def test_whatever_befalls_the_child_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    program, sentence = CHILDREN[what]
    (tmp_path / "child_that_ends.py").write_text(program, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(DamageError, match=f"x.h5: .*{sentence}"):
        guard.ask("child_that_ends", "x.h5", patience=2.0 if what == "hangs" else 30.0)


def test_a_child_that_gets_on_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = (
        "import time\nfor i in range(8):\n    print('null', flush=True)\n    time.sleep(0.4)\nprint('{\"answer\": 7}')"
    )
    (tmp_path / "child_that_works.py").write_text(program, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert guard.ask("child_that_works", "x.h5", patience=2.5) == 7


def test_the_child_takes_no_module_from_the_working_folder(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (path.parent / "h5py.py").write_text("raise SystemExit(9)", encoding="utf-8")
    monkeypatch.chdir(path.parent)
    assert checking.check("a.h5", sample=0).chunks > 0


# ---------------------------------------------------------------------- check
def test_rows_are_computed_again(path: Path) -> None:
    found = checking.check(path, sample=7)
    assert [(one.table, one.rows, one.equal) for one in found.recomputed] == [("points", 7, 7)]
    assert str(found).endswith("7 rows of points computed again: 7 equal") and "its seal holds" in str(found)
    assert checking.check(path, sample=0).recomputed == ()
    with pytest.raises(InputError, match="0 or more"):
        checking.check(path, sample=-1)


Rows = dict[str, Any]


@pytest.mark.parametrize("bytes_left", [600, 20_000])
def test_a_file_that_was_cut_short_is_damage(path: Path, bytes_left: int, capsys: pytest.CaptureFixture[str]) -> None:
    os.truncate(path, bytes_left)
    with pytest.raises(SystemExit) as end:
        main(["verify", str(path)])
    assert end.value.code == 1
    assert capsys.readouterr().err.count("a.h5: this HDF5 file is damaged or was cut short: restore a copy") == 1


def changed(path: Path, out: Path, change: Callable[[Rows], None], table: str = "points", **attributes: Any) -> Path:
    """A database of other numbers with right digests."""
    with store.open_file(path) as file:
        tables = {t: rows for t in file.tables for _, rows in file.chunks(t, list(file.columns(t)))}
        about = {**file.attributes, **attributes}
    change(tables[table])
    store.write(out, tables, {k: v for k, v in about.items() if k != "attributes_digest"})
    return out


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With limits, and all columns of points, some of maps."""
    folder = tmp_path_factory.mktemp("full")
    text = STUDY.split("[output]")[0].replace("tolerances = []", "tolerances = [0.02, 0.05, 0.1]")
    (folder / "full.toml").write_text(text, encoding="utf-8")
    study.run(load_study(folder / "full.toml"), folder / "full.h5")
    return folder / "full.h5"


def told(path: Path, table: str = "points") -> tuple[int, int]:
    """How many rows of a table are equal when they are computed again, and how many within their bounds."""
    [one] = [one for one in looked_at(path, 1000)["recomputed"] if one["table"] == table]
    return one["equal"], one["within"]


ADDED = [
    ("points", "exponent_1", 1e-15, True), ("points", "exponent_1", 1e-9, False),
    ("points", "exact_regressing_2", 1e-9, False), ("points", "error_coning", 1e-12, True),
    ("points", "error_coning", 1e-4, False), ("points", "tpp_advancing_1", 1e-4, False),
    ("points", "rule_regressing", 1, False), ("points", "panels", 1, True),
    ("limits", "limit", 1e-12, True), ("limits", "limit", 1e-4, False), ("limits", "cause", 1, False),
    ("limits", "interval_1_start", np.nan, False), ("limits", "tolerance", 1e-2, False),
]  # fmt: skip


@pytest.mark.parametrize(("table", "column", "added", "sound"), ADDED)
def test_digits_that_rounding_moves_are_within_bounds_and_others_are_noticed(
    full: Path, tmp_path: Path, table: str, column: str, added: float, sound: bool
) -> None:
    def wrong(rows: Rows) -> None:
        rows[column][np.flatnonzero(np.isfinite(rows[column]))[-1]] += added

    out = changed(full, tmp_path / "b.h5", wrong, table)
    if sound:
        assert told(out, table) == (23, 1)
    else:
        assert store.verify(out) == ()
        with pytest.raises(DamageError, match=rf"1 of the rows that were computed again are others .*\({table} row "):
            looked_at(out, 1000)


def test_every_row_of_points_and_limits_is_computed_again_with_the_same_bits(full: Path) -> None:
    assert told(full) == (24, 0) and told(full, "limits") == (24, 0)


def test_rows_of_maps_without_exponents_are_held_against_what_follows_from_them(tmp_path: Path) -> None:
    columns = '["error_regressing", "error_coning", "method", "lock", "verdict"]'
    text = STUDY.replace("tolerances = []", "map = true\ntolerances = []").split("columns =")[0]
    text = text.replace("count = 12", "count = 100")
    (tmp_path / "map.toml").write_text(f"{text}columns = {columns}\n", encoding="utf-8")
    study.run(load_study(tmp_path / "map.toml"), tmp_path / "map.h5")
    equal, within = told(tmp_path / "map.h5")
    assert equal + within == 200 and within > 100

    def wrong(rows: Rows) -> None:
        rows["error_coning"][150] += 1e-4

    with pytest.raises(DamageError, match=r"\(points row 150\)"):
        looked_at(changed(tmp_path / "map.h5", tmp_path / "b.h5", wrong), 1000)

    def unstable(rows: Rows) -> None:
        rows["verdict"][rows["method"] == Method.MAP] = 1

    with pytest.raises(DamageError, match=r"[1-9]\d* of the rows that were computed again"):
        looked_at(changed(tmp_path / "map.h5", tmp_path / "c.h5", unstable), 1000)


def _every_bound(rows: Rows) -> None:
    rows["exponent_error"][:] = 1e9
    rows["exponent_1"] += 0.5


def _no_bound(rows: Rows) -> None:
    rows["exponent_error"][:] = 0.0


def _as_of_maps(rows: Rows) -> None:
    rows["method"][:], rows["determinant_defect"][:] = Method.MAP, 1e5


def _one_rotor(rows: Rows) -> None:
    rows["rotor"][:] = 0


def _no_rotor_of_these(rows: Rows) -> None:
    rows["rotor"] += 1


def _backwards(rows: Rows) -> None:
    for name, values in rows.items():
        rows[name] = values[::-1].copy()


WRONG = [(_every_bound, "computed again"), (_no_bound, "computed again"), (_as_of_maps, "computed again"),
         (_one_rotor, r"\(points/rotor\)"), (_no_rotor_of_these, r"\(points/rotor\)"),
         (_backwards, r"\(points/rotor\)")]  # fmt: skip


@pytest.mark.parametrize(("wrong", "sentence"), WRONG)
def test_a_file_does_not_say_how_it_is_judged(
    full: Path, tmp_path: Path, wrong: Callable[[Rows], None], sentence: str
) -> None:
    out = changed(full, tmp_path / "b.h5", wrong)
    assert store.verify(out) == ()
    with pytest.raises(DamageError, match=sentence):
        looked_at(out, 100)


def test_what_cannot_be_compared_is_not_called_compared(path: Path, full: Path, tmp_path: Path) -> None:
    def few(rows: Rows) -> None:
        for name in [n for n in rows if n.startswith("exponent_")]:
            del rows[name]

    of_two = changed(path, tmp_path / "b.h5", few, engine_version=2)
    assert "no row of points was computed again (engine 2 has made them" in str(checking.check(of_two))
    _, limits = looked_at(changed(full, tmp_path / "c.h5", lambda rows: None, engine_version=2), 5)["recomputed"]
    assert limits["rows"] == 0 and limits["reason"].startswith("engine 2")
    with pytest.raises(DamageError, match="engine_version is 'abc', which is no number"):
        looked_at(changed(full, tmp_path / "d.h5", lambda rows: None, engine_version="abc"), 5)


@pytest.mark.parametrize("text", ["{", "{}", '{"model": "warp"}', "null", "[" * 5000])
def test_equations_that_are_none_are_damage(full: Path, tmp_path: Path, text: str) -> None:
    about = {"options": text}
    with pytest.raises(DamageError, match="computed again"):
        looked_at(changed(full, tmp_path / "b.h5", lambda rows: None, **about), 3)


@pytest.mark.parametrize(("size", "sound"), [(1e-15, True), (1e-6, False)])
def test_another_engine_is_held_against_the_bounds(full: Path, tmp_path: Path, size: float, sound: bool) -> None:
    def other(rows: Rows) -> None:
        rows["exponent_1"] += size
        rows["rule_coning"][:] = 1  # what is made of exponents may have been defined otherwise

    out = changed(full, tmp_path / "b.h5", other, engine_version=1)
    if sound:
        points, limits = looked_at(out, 100)["recomputed"]
        assert (points["rows"], points["equal"], points["within"], points["engine"]) == (24, 0, 24, 1)
        assert limits["rows"] == 0
    else:
        with pytest.raises(DamageError, match="computed again"):
            looked_at(out, 100)


@pytest.mark.parametrize(("column", "value"), [
    ("lock_number", 0.0), ("advance_ratio", -0.1), ("advance_ratio", np.nan), ("hinge_offset", 1.0), ("blades", 0),
    ("pitch_flap_coupling", np.inf), ("flap_frequency", 0.9),
])  # fmt: skip
def test_values_that_are_not_possible_are_noticed(path: Path, tmp_path: Path, column: str, value: float) -> None:
    def wrong(rows: Rows) -> None:
        rows[column][2] = value

    assert store.verify(changed(path, tmp_path / "b.h5", wrong)) == (f"points/{column} (a value that is not possible)",)


# ---------------------------------------------------------------------- every schema that was released
def unpacked(example: Path, folder: Path) -> tuple[Path, dict[str, Any]]:
    """An example of a schema, and its numbers without HDF5."""
    out = folder / example.stem
    out.write_bytes(lzma.decompress(example.read_bytes()))
    numbers = example.with_name(example.name.replace(".h5.", ".json."))
    return out, json.loads(lzma.decompress(numbers.read_bytes()))


def bits(values: Any) -> list[Any]:
    if values.dtype.kind == "c":
        return [bits(values.real), bits(values.imag)]
    return [v.hex() if isinstance(v, float) else v for v in values.tolist()]


def same(path: Path, document: dict[str, Any]) -> None:
    with store.open_file(path) as file:
        assert list(file.tables) == list(document["tables"]) and list(file.names) == document["names"]
        assert file.attributes["study_id"] == document["study_id"]
        for table, columns in document["tables"].items():
            assert set(columns) <= set(file.columns(table))
            [(_, rows)] = file.chunks(table, list(columns))
            for name, values in columns.items():
                assert bits(rows[name]) == values, name


def test_there_is_an_example_of_the_present_schema_and_of_the_first() -> None:
    names = {path.name.removeprefix("schema-").removesuffix(".h5.xz") for path in EXAMPLES}
    assert {"1.0", "{}.{}".format(*store.SCHEMA)} <= names


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_every_schema_is_read_value_by_value_and_renewed(example: Path, tmp_path: Path) -> None:
    out, document = unpacked(example, tmp_path)
    same(out, document)
    assert store.verify(out) == ()
    with open_database(out) as database:
        assert len(database.query("rotor == 'Bo 105' and advance_ratio > 0.3")["rotor"]) == 4
    assert study.merge([out], tmp_path / "new.h5") == {
        "points": 12,
        "limits": len(document["tables"]["limits"]["rotor"]),
    }
    same(tmp_path / "new.h5", document)
    with store.open_file(tmp_path / "new.h5") as file:
        assert file.sealed and file.attributes["schema_version"] == "{}.{}".format(*store.SCHEMA)
        assert "from schema" in file.attributes["history"].split("\n")[-1]
        assert file.attributes["input"] and file.data_digest() == store.data_digest(out)


def test_columns_of_a_newer_minor_schema_are_passed_over(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = dict(store.POINTS)
    with store.open_file(path) as file:
        [(_, rows)] = file.chunks("points", list(file.columns("points")))
        attributes = {k: v for k, v in file.attributes.items() if k != "attributes_digest"}
    monkeypatch.setitem(store.TABLES, "points", {**known, "torsion": store.Column("f8", "1", "of a later release")})
    monkeypatch.setattr(store.writing, "SCHEMA", (store.SCHEMA[0], 99))
    store.write(tmp_path / "b.h5", {"points": {**rows, "torsion": np.ones(24)}}, attributes)
    monkeypatch.setitem(store.TABLES, "points", known)
    assert store.verify(tmp_path / "b.h5") == ()
    with store.open_file(tmp_path / "b.h5") as file:
        assert file.attributes["schema_version"].endswith(".99") and "torsion" not in file.columns("points")
        [(_, read)] = file.chunks("points", ["exponent_1"])
        assert np.array_equal(read["exponent_1"], rows["exponent_1"])
    with pytest.warns(UserWarning, match="torsion"):
        study.merge([tmp_path / "b.h5"], tmp_path / "c.h5")


@pytest.mark.parametrize("command", ["verify", "query", "export"])
def test_every_command_ends_with_a_sentence_on_damaged_metadata(path: Path, command: str) -> None:
    image = bytearray(path.read_bytes())
    image[3000:3300] = os.urandom(300)
    path.write_bytes(image[:-60])  # no seal, and no sound metadata
    more = {"query": ("lock > 1",), "export": ("-o", "x.csv"), "verify": ()}[command]
    environment = {**os.environ, "PYTHONPATH": str(Path(store.__file__).parents[2])}
    asked = [sys.executable, "-m", "floquet", command, "a.h5", *more]
    done = subprocess.run(asked, cwd=path.parent, text=True, capture_output=True, env=environment)
    assert done.returncode in (1, 2) and "a.h5: " in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize(("designs", "ratios", "sentence"), [
    (4000 * 4000, 1, "has 16000000 designs, and the most is 10000000"),
    (10**6, 10**6, "has 1000000 designs at 1000000 advance ratios, 1000000000000 points, and the most is 100000000000"),
])  # fmt: skip
def test_studies_that_no_machine_would_finish_are_refused(
    tmp_path: Path, designs: int, ratios: int, sentence: str
) -> None:
    axis = f"{{ start = 0.1, stop = 0.9, count = {round(designs**0.5)} }}"
    along = f"{{ start = 0.1, stop = 0.9, count = {ratios} }}"
    grid = f"lock_number = {axis}, hinge_offset = {axis}"
    text = f"[study]\nname = 'x'\n[rotors]\ngrid = {{ {grid} }}\n[axes]\nadvance_ratio = {along}\n"
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=f"{sentence}: take fewer .* cut it into several studies"):
        load_study(tmp_path / "s.toml")
