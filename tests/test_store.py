"""Files whole or not at all, digests that notice, readers that are not ours."""

from __future__ import annotations

import contextlib
import copy
import errno
import json
import os
import pickle
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from floquet import store
from floquet.comparison import Metric
from floquet.errors import (
    ConfigError,
    DamageError,
    DatabaseError,
    FailedError,
    FloquetError,
    InputError,
    ParameterError,
    Problem,
    QueryError,
    StorageError,
)
from floquet.rotor import Hub, Rotor
from floquet.store import digests, writing
from floquet.sweep import Plan, limit_rows, point_rows

ATTRIBUTES = {"study_id": "abc", "title": "a test", "rotor_names": json.dumps(["Bo 105", "two blades"])}


@pytest.fixture(scope="module")
def rows() -> dict[str, dict[str, np.ndarray[Any, Any]]]:
    rotors = (
        Rotor(lock_number=5.087, hinge_stiffness=0.248, name="Bo 105"),
        Rotor(lock_number=6.0, blades=2, hub=Hub.TEETERING, name="two blades"),
    )
    plan = Plan(rotors=rotors, advance_ratio=np.linspace(0, 1, 21), tolerances=((Metric.RELATIVE, 0.05),))
    return {"points": point_rows(plan, 0, plan.points), "limits": limit_rows(plan, 0, 2)}


@pytest.fixture
def path(tmp_path: Path, rows: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A database of three chunks a table of points."""
    monkeypatch.setattr(store.schema, "CHUNK_ROWS", 16)
    target = tmp_path / "a base.h5"
    store.write(target, rows, ATTRIBUTES)
    return target


def test_every_column_of_the_schema_is_written_and_nothing_else(rows: dict[str, Any]) -> None:
    for table, columns in store.TABLES.items():
        assert list(rows[table]) == list(columns) or set(rows[table]) == set(columns)
        for name, column in columns.items():
            assert rows[table][name].dtype == np.dtype(column.dtype), name


def test_what_is_read_is_what_was_written(path: Path, rows: dict[str, Any]) -> None:
    with store.open_file(path) as file:
        assert (
            file.tables == ("points", "limits") and file.names == ("Bo 105", "two blades") and file.rows("points") == 42
        )
        for table, columns in rows.items():
            read = [part for _, part in file.chunks(table, list(columns))]
            for name, value in columns.items():
                assert np.concatenate([p[name] for p in read]).tobytes() == value.tobytes(), name
        [(start, part)] = list(file.chunks("points", ["rotor", "exponent_1_im"], 18, 20))
        assert start == 18
        np.testing.assert_array_equal(part["exponent_1_im"], rows["points"]["exponent_1"].imag[18:20])


def test_ranges_let_chunks_be_skipped(path: Path) -> None:
    with store.open_file(path) as file:
        seen = [
            start for start, _ in file.chunks("points", ["rotor"], skip=lambda low, high: high["advance_ratio"] < 0.9)
        ]
        assert seen == [16, 32]  # μ restarts with the second rotor in row 21


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_xarray_reads_it(path: Path, rows: dict[str, Any], engine: str) -> None:
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4" if engine == "netcdf4" else engine)
    with xarray.open_dataset(path, group="points", engine=engine) as data:
        assert dict(data.sizes) == {"row": 42}
        np.testing.assert_array_equal(data["error_regressing"], rows["points"]["error_regressing"])
        np.testing.assert_array_equal(data["tpp_coning_1_im"], rows["points"]["tpp_coning_1"].imag)
        assert data["error_regressing"].attrs["units"] == "1" and "per rev" in data["exponent_1_re"].attrs["long_name"]
        assert data["verdict"].attrs["flag_meanings"] == "STABLE UNSTABLE UNDECIDED"
        assert data["rotor"].attrs["flag_meanings"] == "Bo_105 two_blades"


def test_plain_h5py_reads_it(path: Path, rows: dict[str, Any]) -> None:
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["limits/limit"][()], rows["limits"]["limit"])
        assert (
            file["points/row"].is_scale and file["points/lock"].fletcher32 and file["points/lock"].compression == "gzip"
        )
        assert file.attrs["title"] == "a test" and file.attrs["schema_version"] == "1.1"


def test_equal_data_have_equal_digests(
    tmp_path: Path, path: Path, rows: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = tmp_path / "later.h5"
    store.write(other, rows, ATTRIBUTES | {"created": "later"})
    assert store.data_digest(other) == store.data_digest(path)
    changed = {t: {n: v.copy() for n, v in c.items()} for t, c in rows.items()}
    changed["points"]["lock"][3] = 0.5
    store.write(other, changed, ATTRIBUTES)
    assert store.data_digest(other) != store.data_digest(path)


# ---------------------------------------------------------------------- columns
FEW = ("error_regressing", "exponent_1")


def _few(rows: dict[str, Any]) -> dict[str, Any]:
    return {"points": {name: rows["points"][name] for name in store.chosen(FEW)}, "limits": rows["limits"]}


def test_a_file_may_have_fewer_columns(tmp_path: Path, rows: dict[str, Any]) -> None:
    store.write(tmp_path / "few.h5", _few(rows), ATTRIBUTES)
    with store.open_file(tmp_path / "few.h5") as file:
        assert set(file.columns("points")) == {*store.ALWAYS, *FEW}
        assert list(file.columns("limits")) == list(store.LIMITS)
        assert {"lock", "exponent_2", "exponent_2_im"} < file.left_out("points") and not file.left_out("limits")
        assert not file.left_out("points") & ({*store.ALWAYS, "exponent_1", "exponent_1_re"})
        [(_, part)] = file.chunks("points", list(FEW))
        np.testing.assert_array_equal(part["exponent_1"], rows["points"]["exponent_1"])
        with pytest.raises(DatabaseError, match="no column 'lock': it was written without it"):
            list(file.chunks("points", ["lock"]))
    assert store.verify(tmp_path / "few.h5") == ()


def test_columns_are_chosen_by_name_with_those_that_always_are() -> None:
    assert store.chosen(["lock", "exponent_1"]) == (*store.ALWAYS, "exponent_1", "lock")
    assert store.chosen(["lock", "*"]) == tuple(store.POINTS) and store.chosen([]) == store.ALWAYS
    assert {"rotor", "advance_ratio", "lock_number", "root_cutout", "blades", "hub", "flap_frequency"} < {*store.ALWAYS}
    for name, sentence in (
        ("error_regresing", "did you mean 'error_regressing'"),
        ("exponent_1_re", "is a part of exponent_1, which is stored as one: name exponent_1"),
        ("zzz", "'zzz' is no column of the table of points"),
    ):
        with pytest.raises(InputError, match=sentence):
            store.chosen([name])


# ---------------------------------------------------------------------- chunks
@pytest.mark.parametrize("threads", ["1", "2", "5"])
@pytest.mark.parametrize("piece", [1, 7, 16, 41, 42])
def test_the_bytes_of_a_file_depend_on_its_rows_alone(
    path: Path, tmp_path: Path, rows: dict[str, Any], monkeypatch: pytest.MonkeyPatch, threads: str, piece: int
) -> None:
    """Not on the number of threads, nor on how the rows come; and they may be changed as soon as they were given."""
    monkeypatch.setenv("FLOQUET_THREADS", threads)
    with store.create(tmp_path / "b.h5", {t: len(r["rotor"]) for t, r in rows.items()}, ATTRIBUTES) as writers:
        for table, columns in rows.items():
            for start in range(0, len(columns["rotor"]), piece):
                part = {name: value[start : start + piece].copy() for name, value in columns.items()}
                writers[table].add(part)
                for value in part.values():
                    value[:] = 0
    assert (tmp_path / "b.h5").read_bytes() == path.read_bytes()


def _parts(rows: dict[str, Any], ends: list[int], folder: Path) -> list[Path]:
    """Files of the points between some ends."""
    files = [folder / f"{start}.h5" for start in ends[:-1]]
    for file, start, stop in zip(files, ends, ends[1:], strict=False):
        store.write(file, {"points": {n: v[start:stop] for n, v in rows["points"].items()}}, ATTRIBUTES)
    return files


def _copied(files: list[Path], out: Path, rotor_offset: int = 0) -> None:
    with store.create(out, {"points": 42}, ATTRIBUTES) as writers:
        for file in files:
            with store.open_file(file) as source:
                store.copy_rows(source, writers["points"], rotor_offset=rotor_offset)


@pytest.mark.usefixtures("path")
@pytest.mark.parametrize(("ends", "packed"), [
    ([0, 42], 3), ([0, 32, 42], 3 + 80), ([0, 16, 32, 42], 3 + 80),  # the scale of three chunks; the last ten rows
    ([0, 20, 42], 3 * 81), ([0, 32, 40, 42], 3 + 80),
])  # fmt: skip
def test_chunks_that_stand_in_the_same_places_are_copied_as_they_are(
    tmp_path: Path, rows: dict[str, Any], monkeypatch: pytest.MonkeyPatch, ends: list[int], packed: int
) -> None:
    """The file has the bytes of one written at once; a last part of less than a chunk is packed again."""
    store.write(tmp_path / "whole.h5", {"points": rows["points"]}, ATTRIBUTES)
    files, made, real = _parts(rows, ends, tmp_path), [], writing.pack
    monkeypatch.setattr(writing, "pack", lambda *given: (made.append(given), real(*given))[1])
    _copied(files, tmp_path / "copy.h5")
    assert len(made) == packed
    assert (tmp_path / "copy.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


@pytest.mark.usefixtures("path")
def test_copied_rotors_are_numbered_on(tmp_path: Path, rows: dict[str, Any]) -> None:
    renumbered = rows["points"] | {"rotor": rows["points"]["rotor"] + np.int32(7)}
    store.write(tmp_path / "whole.h5", {"points": renumbered}, ATTRIBUTES)
    _copied(_parts(rows, [0, 32, 42], tmp_path), tmp_path / "copy.h5", rotor_offset=7)
    assert (tmp_path / "copy.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


@pytest.mark.usefixtures("path")
def test_a_file_without_digests_of_what_is_stored_is_packed_again(tmp_path: Path, rows: dict[str, Any]) -> None:
    store.write(tmp_path / "whole.h5", {"points": rows["points"]}, ATTRIBUTES)
    files = _parts(rows, [0, 32, 42], tmp_path)
    with h5py.File(files[0], "r+") as file:
        del file["integrity/points/stored"]
        file.attrs["attributes_digest"] = digests.attributes_digest(file)
    with store.open_file(files[0]) as file:
        assert not file.intact()
    _copied(files, tmp_path / "copy.h5")
    assert (tmp_path / "copy.h5").read_bytes() == (tmp_path / "whole.h5").read_bytes()


@pytest.mark.usefixtures("path")
@pytest.mark.parametrize("change", ["a number", "a byte", "another chunk", "a filter left out"])
def test_a_changed_chunk_is_not_copied(tmp_path: Path, rows: dict[str, Any], change: str) -> None:
    [file] = _parts(rows, [0, 42], tmp_path)
    with h5py.File(file, "r+") as changed:
        data = changed["points/lock_number"]
        mask, raw = data.id.read_direct_chunk((16,))
        if change == "a number":
            data[20] += 1e-12
        elif change == "a byte":
            data.id.write_direct_chunk((16,), bytes([*raw[:-1], raw[-1] ^ 1]))
        elif change == "another chunk":
            data.id.write_direct_chunk((16,), data.id.read_direct_chunk((0,))[1])
        else:
            data.id.write_direct_chunk((16,), raw + b"\0")  # HDF5 looks at the mask where the size changes
            data.id.write_direct_chunk((16,), raw, filter_mask=mask | 2)
    with store.open_file(file) as source:
        assert not source.intact()
    with pytest.raises(DamageError, match=r"points/lock_number rows 16…31"):
        _copied([file], tmp_path / "copy.h5")
    assert not (tmp_path / "copy.h5").exists()


def test_filters_of_others_are_not_taken_for_ours(path: Path) -> None:
    """A file that another program has filtered anew: its numbers are sound, its chunks are not copied."""
    with h5py.File(path, "r+") as file:
        group, numbers = file["points"], file["points/lock"][()]
        del group["lock"]
        group.create_dataset("lock", data=numbers, chunks=(16,), compression="gzip")
        file.attrs["attributes_digest"] = digests.attributes_digest(file)
    with store.open_file(path) as file:
        assert file.stored("points") is None and file.stored("limits") is not None
        list(file.chunks("points", ["lock"]))


# ---------------------------------------------------------------------- damage
def test_one_changed_number_is_noticed_and_named(path: Path) -> None:
    """Changed through HDF5 itself, so that its own checksum is content."""
    with h5py.File(path, "r+") as file:
        file["points/error_coning"][20] += 1e-12
    assert store.verify(path) == ("points/error_coning rows 16…31",)
    with store.open_file(path) as file:
        assert next(file.chunks("points", ["error_coning"]))[0] == 0
        with pytest.raises(DamageError, match=r"points/error_coning rows 16…31"):
            list(file.chunks("points", ["error_coning"]))
        list(file.chunks("points", ["error_regressing"]))


def test_a_flipped_byte_of_the_file_never_gives_a_wrong_number(path: Path, rows: dict[str, Any]) -> None:
    """Every 97th byte: the answer is an error, or exactly the data."""
    image, seen = path.read_bytes(), 0
    for position in range(8, len(image), max(1, len(image) // 97)):
        broken = bytearray(image)
        broken[position] ^= 0x41
        path.write_bytes(broken)
        try:
            with store.open_file(path) as file:
                for _, part in file.chunks("points", ["lock_number", "exponent_1"], 0, 16):
                    np.testing.assert_array_equal(part["exponent_1"], rows["points"]["exponent_1"][:16])
                    np.testing.assert_array_equal(part["lock_number"], rows["points"]["lock_number"][:16])
            if not store.verify(path):
                continue
        except DatabaseError:
            pass
        seen += 1
    assert seen > 20


@pytest.mark.parametrize("part", ["minima", "maxima", "digests"])
def test_changed_ranges_and_digests_are_noticed_when_the_file_is_opened(path: Path, part: str) -> None:
    """A smaller maximum would leave rows out of queries without a word."""
    with h5py.File(path, "r+") as file:
        assert file["integrity/points"][part].fletcher32
        file["integrity/points"][part][3, 1] = 7
    with pytest.raises(DamageError, match="integrity/points"):
        store.open_file(path)
    assert store.verify(path) == ("integrity/points",)


def test_changed_attributes_are_noticed(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["points/lock"].attrs["units"] = "knots"
    assert store.verify(path) == ("attributes and schema",)
    with store.File(path, examined=True) as file:
        assert list(file.damaged()) == ["attributes and schema"]


def test_a_value_that_is_no_flag_is_noticed(tmp_path: Path, rows: dict[str, Any]) -> None:
    wrong = {t: dict(c) for t, c in rows.items()}
    wrong["points"]["verdict"] = np.full_like(wrong["points"]["verdict"], 7)
    store.write(tmp_path / "x.h5", wrong, ATTRIBUTES)
    assert store.verify(tmp_path / "x.h5") == ("points/verdict (a value that is no flag)",)


def _foreign(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["x"] = [1.0, 2.0]


def _newer(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["schema_version"] = "2.0"


@pytest.mark.parametrize(("change", "sentence"), [
    (lambda p: p.unlink(), "there is no such file"),
    (lambda p: (p.unlink(), p.mkdir()), "this is a folder"),
    (lambda p: (p.unlink(), os.mkfifo(p)), "this is a pipe or a device"),
    (lambda p: p.write_bytes(b""), "not an HDF5 file"),
    (lambda p: p.write_bytes(b"mu,error\n0.1,0.2\n"), "not an HDF5 file"),
    (lambda p: p.write_bytes(p.read_bytes()[: p.stat().st_size // 2]), "damaged or was cut short"),
    (lambda p: p.write_bytes(p.read_bytes()[:600]), "damaged or was cut short"),
    (_foreign, "not made by floquet"),
    (_newer, "install a newer floquet-rotor"),
])  # fmt: skip
def test_what_is_no_database_is_refused_in_a_sentence(path: Path, change: Callable[[Path], Any], sentence: str) -> None:
    change(path)
    with pytest.raises(DatabaseError, match=sentence):
        store.open_file(path)


# ---------------------------------------------------------------------- writing
def test_a_file_is_synced_before_it_takes_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda fd: (calls.append("fsync"), fsync(fd))[1])
    monkeypatch.setattr(os, "replace", lambda a, b: (calls.append("replace"), replace(a, b))[1])
    with store.atomic(tmp_path / "x") as temporary:
        temporary.write_text("new")
    assert calls == ["fsync", "replace", "fsync"] and (tmp_path / "x").read_text() == "new"


@pytest.mark.parametrize("step", ["fsync", "replace", "body"])
def test_a_failure_at_any_step_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    target = tmp_path / "x"
    target.write_text("old")

    def fail(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    if step != "body":
        monkeypatch.setattr(os, step, fail)
    with pytest.raises(StorageError, match="the disk is full"), store.atomic(target) as temporary:
        temporary.write_text("new")
        if step == "body":
            fail()
    assert target.read_text() == "old" and list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize(("number", "fails"), [(errno.EIO, True), (errno.ENOSPC, True), (errno.EINVAL, False)])
def test_a_folder_that_cannot_be_synced_is_passed_over_and_a_failing_disk_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, fails: bool
) -> None:
    fsync = os.fsync

    def fail(descriptor: int) -> None:
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            raise OSError(number, "it fails")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(StorageError) if fails else contextlib.nullcontext(), store.atomic(tmp_path / "x") as temporary:
        temporary.write_text("new")
    assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_leftovers_of_killed_writers_go_and_nothing_else(tmp_path: Path) -> None:
    for name in (".a[1].h5.77.tmp", ".b.h5.78.tmp", ".a1.h5.79.tmp", "a[1].h5", "mine.tmp"):
        (tmp_path / name).touch()
    store.remove_leftovers(tmp_path, "a[1].h5")
    assert {p.name for p in tmp_path.iterdir()} == {".b.h5.78.tmp", ".a1.h5.79.tmp", "a[1].h5", "mine.tmp"}
    store.remove_leftovers(tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {"a[1].h5", "mine.tmp"}


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are POSIX")
@pytest.mark.parametrize("kilobytes", [1, 20, 60, 150, 250])
@pytest.mark.parametrize("threads", [1, 3])
def test_a_full_disk_is_one_sentence(tmp_path: Path, kilobytes: int, threads: int) -> None:
    """A child that may write so many kilobytes: HDF5 fails in the middle, while others are packed, or at its close."""
    program = f"""
import os, resource, sys
import numpy as np
from floquet import store
from floquet.errors import StorageError
from floquet.rotor import Rotor
from floquet.sweep import sweep
os.environ["FLOQUET_THREADS"], store.schema.CHUNK_ROWS = "{threads}", 100
rows = sweep(Rotor(lock_number=np.linspace(4, 9, 40)), np.linspace(0, 1, 30))
resource.setrlimit(resource.RLIMIT_FSIZE, ({kilobytes * 1024}, {kilobytes * 1024}))
try:
    store.write({str(tmp_path / "x.h5")!r}, {{"points": rows}}, {{"study_id": "a"}})
except StorageError as error:
    print(error)
    sys.exit(7)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 7, done.stderr
    assert "limit on file sizes" in done.stdout and done.stdout.count("\n") == 1
    assert "Traceback" not in done.stderr and list(tmp_path.iterdir()) == []


def test_rows_that_do_not_come_are_noticed(tmp_path: Path, rows: dict[str, Any]) -> None:
    with (
        pytest.raises(StorageError, match="42 rows came for the table points of 43"),
        store.create(tmp_path / "x.h5", {"points": 43}, ATTRIBUTES) as writers,
    ):
        writers["points"].add(rows["points"])
    assert list(tmp_path.iterdir()) == []


ERRORS = [
    FloquetError("plain"),
    InputError("plain"),
    ParameterError("lock_number", -1.0, "-1.0 is not possible"),
    ConfigError("a.toml", [Problem(3, "axes", "missing"), Problem(0, "", "empty")]),
    QueryError("no such column", "lok > 1", 1),
    DatabaseError("a.h5", "there is no such file"),
    DamageError("a.h5", ["points/lock rows 0…15", "b", "c", "d"]),
    FailedError("plain"),
    StorageError("a.h5", "the disk is full"),
]


def test_every_error_is_tried() -> None:
    def tree(kind: type[FloquetError]) -> set[type[FloquetError]]:
        return {kind}.union(*map(tree, kind.__subclasses__()))

    assert {type(e) for e in ERRORS} == {k for k in tree(FloquetError) if k.__module__ == "floquet.errors"}


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: type(e).__name__)
def test_errors_come_back_whole_from_worker_processes(error: FloquetError) -> None:
    for again in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)
