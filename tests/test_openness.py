"""Every reader gives a database as it was written, docs/format.md is all it takes, and answers leave in four formats.

A reader that is missing is skipped and named, but for those of the test extra under CI, which fail.
"""

from __future__ import annotations

import csv
import importlib
import json
import os
import re
import shutil
import subprocess
import tracemalloc
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from floquet import export, query, store
from floquet.cli import main
from floquet.errors import DatabaseError, InputError, ParameterError, StorageError
from floquet.query import Database, open_database
from floquet.store.schema import CHUNK_ROWS, Column
from floquet.study import load_study, run
from floquet.sweep import INTERVALS, MODES
from tests.test_query import FakeFile
from tests.test_query import points as fake_points

PAGE = (Path(__file__).parents[1] / "docs" / "format.md").read_text(encoding="utf-8")
NAMES = ("Bo 105", "", "Лynx µ")
SPECIAL = np.array([np.nan, np.inf, -np.inf, -0.0, 5e-324, np.nextafter(1.0, 2.0), -1.7976931348623157e308, 1e-17])
Arrays = dict[str, Any]


def needed(module: str) -> Any:
    """A module of the test extra: skipped where it is missing, but not under CI, which installs it."""
    if os.environ.get("CI"):
        return importlib.import_module(module)
    return pytest.importorskip(module)


def program(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed: its reading of a database is NOT tested here")
    return found


def random_rows(columns: Mapping[str, Column], rows: int, seed: int) -> Arrays:
    """Numbers with all their bits, every special one, every flag; where a column has a range, in it."""
    g = np.random.default_rng(seed)

    def real() -> Any:
        return np.where(g.random(rows) < 0.3, g.choice(SPECIAL, rows), g.standard_normal(rows))

    def column(name: str, kind: Column) -> Any:
        if name == "rotor":
            return g.integers(0, len(NAMES), rows).astype("i4")
        if kind.flags:
            return g.choice(list(kind.flags), rows).astype(kind.dtype)
        if kind.dtype == "c16":
            out = np.empty(rows, complex)
            out.real, out.imag = real(), real()
            return out
        if kind.dtype == "f8":
            return real() if kind.least is None else g.uniform(max(kind.least, 0.1), min(kind.below, 2.0), rows)
        return g.integers(-9 if kind.least is None else int(kind.least), 99, rows).astype(kind.dtype)

    return {name: column(name, kind) for name, kind in columns.items()}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Arrays]]:
    """A file of two chunks of points and one of limits, and the variables that were written."""
    path = tmp_path_factory.mktemp("open") / "random.h5"
    tables = {"points": random_rows(store.POINTS, CHUNK_ROWS + 77, 1), "limits": random_rows(store.LIMITS, 61, 2)}
    about = {"title": "random", "study_id": "0" * 32, "rotor_names": json.dumps(NAMES, ensure_ascii=False)}
    store.write(path, tables, about)
    variables = {}
    for table, rows in tables.items():
        variables[table] = {"row": np.arange(len(rows["rotor"]))}
        for name, values in rows.items():
            parts = (
                {f"{name}_re": values.real, f"{name}_im": values.imag} if values.dtype.kind == "c" else {name: values}
            )
            variables[table] |= parts
    return path, variables


def same_bits(found: Any, written: Any) -> bool:
    found, written = np.ascontiguousarray(found), np.ascontiguousarray(written)
    kinds = found.dtype.newbyteorder("=") == written.dtype.newbyteorder("=")
    return bool(kinds and found.shape == written.shape and found.tobytes() == written.tobytes())


# --- readers ----------------------------------------------------------------------------------------------------------
Get = Callable[[str, str], tuple[Any, dict[str, Any]]]


def _xarray(engine: str) -> Callable[[Path], Iterator[Get]]:
    def reader(path: Path) -> Iterator[Get]:
        needed({"netcdf4": "netCDF4"}.get(engine, engine))
        xarray = needed("xarray")
        data = {table: xarray.open_dataset(path, group=table, engine=engine) for table in store.TABLES}
        yield lambda table, name: (data[table][name].values, data[table][name].attrs)
        for one in data.values():
            one.close()

    return reader


def _netcdf4(path: Path) -> Iterator[Get]:
    with needed("netCDF4").Dataset(path) as data:

        def get(table: str, name: str) -> tuple[Any, dict[str, Any]]:
            values = data[table][name][:]
            assert not np.ma.is_masked(values)
            return np.ma.getdata(values), data[table][name].__dict__

        yield get


def _pytables(path: Path) -> Iterator[Get]:
    """It cannot read the scale of a netCDF-4 file (KeyError: 'Reference'), nor arrays of attributes as others do."""
    with needed("tables").open_file(str(path)) as file:

        def get(table: str, name: str) -> tuple[Any, dict[str, Any]]:
            node = file.get_node(f"/{table}/{name}")
            attrs = node._v_attrs
            return node[:], {key: attrs[key] for key in ("units", "long_name", "flag_values") if key in attrs}

        yield get


def _pyfive(path: Path) -> Iterator[Get]:
    with needed("pyfive").File(str(path)) as file:
        yield lambda table, name: (file[table][name][:], dict(file[table][name].attrs))


READERS = {
    "xarray h5netcdf": _xarray("h5netcdf"),
    "xarray netcdf4": _xarray("netcdf4"),
    "netCDF4": _netcdf4,
    "PyTables": _pytables,
    "pyfive": _pyfive,
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", READERS)
def test_a_reader_gives_every_number_bit_by_bit(written: tuple[Path, dict[str, Arrays]], name: str) -> None:
    path, variables = written
    count = 0
    for get in READERS[name](path):
        for table, columns in variables.items():
            schema = store.stored_variables(store.TABLES[table])
            for variable, values in columns.items():
                if (name, variable) == ("PyTables", "row"):
                    continue
                found, attrs = get(table, variable)
                assert same_bits(found, values), (table, variable)
                count += 1
                if variable in schema:
                    said = {key: _text(attrs[key]) for key in ("units", "long_name")}
                    assert said == {"units": schema[variable].units, "long_name": schema[variable].long_name}
                    if schema[variable].flags:
                        assert np.asarray(attrs["flag_values"]).tolist() == list(schema[variable].flags or ())
    assert count >= 115


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def test_ncdump_prints_every_number(written: tuple[Path, dict[str, Arrays]]) -> None:
    path, variables = written
    names = {"points": ("lock", "exponent_1_im", "rule_coning", "rotor"), "limits": ("limit", "mode", "blades")}
    asked = ",".join(f"/{table}/{name}" for table, some in names.items() for name in some)
    done = subprocess.run([program("ncdump"), "-p", "9,17", "-v", asked, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for table, some in names.items():
        part = re.split(rf"^group: {table} \{{", done.stdout, flags=re.M)[1].split(f"}} // group {table}")[0]
        for name in some:
            [text] = re.findall(rf"^\s+{name} =\s(.*?);", part.split("data:")[1], re.M | re.S)
            kind = variables[table][name].dtype
            found = np.array([float(word) for word in text.split(",")]).astype(kind)
            assert same_bits(found, variables[table][name]), name


def _copied(source: Any, target: Any) -> None:
    """A group as nccopy copies it: texts as arrays of one, and dimensions for what had none."""
    for name in source.ncattrs():
        value = source.getncattr(name)
        (target.setncattr_string if isinstance(value, str) else target.setncattr)(name, value)
    for name, dimension in source.dimensions.items():
        target.createDimension(name, len(dimension))
    for name, variable in source.variables.items():
        made = target.createVariable(name, variable.dtype, variable.dimensions, zlib=True)
        for key in variable.ncattrs():
            value = variable.getncattr(key)
            (made.setncattr_string if isinstance(value, str) else made.setncattr)(key, value)
        made[:] = variable[:]
    for name, group in source.groups.items():
        _copied(group, target.createGroup(name))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("by", ["netCDF4", "nccopy"])
def test_a_copy_by_netcdf_is_a_database_with_the_same_data(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, by: str
) -> None:
    path, _ = written
    copy = tmp_path / "copy.nc"
    if by == "nccopy":
        subprocess.run([program("nccopy"), path, copy], check=True)
    else:
        netcdf = needed("netCDF4")
        with netcdf.Dataset(path) as source, netcdf.Dataset(copy, "w") as target:
            for one in (source, target):
                one.set_auto_maskandscale(False)
            _copied(source, target)
    assert store.verify(copy) == ()
    assert store.data_digest(copy) == store.data_digest(path)
    with open_database(copy) as found, open_database(path) as kept:
        assert found.names == kept.names and found.attributes["title"] == "random"
        assert same_bits(*(db.query("lock > 0", columns="exponent_1")["exponent_1"] for db in (found, kept)))


def test_a_changed_attribute_of_a_copy_by_netcdf_is_damage(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path
) -> None:
    copy = tmp_path / "copy.nc"
    subprocess.run([program("nccopy"), written[0], copy], check=True)
    with h5py.File(copy, "r+") as file:
        file["points/lock_number"].attrs["units"] = ["deg"]
    assert store.verify(copy) == ("attributes and schema",)


def test_h5dump_gives_every_bit(written: tuple[Path, dict[str, Arrays]], tmp_path: Path) -> None:
    path, variables = written
    some = {"points": ("advance_ratio", "exponent_2_re", "exponent_2_im", "cause_coning", "panels")}
    for table, names in (some | {"limits": tuple(variables["limits"])}).items():
        for name in names:
            raw = tmp_path / "raw"
            command = [program("h5dump"), "-d", f"/{table}/{name}", "-b", "LE", "-o", raw, path]
            done = subprocess.run(command, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            assert same_bits(np.fromfile(raw, variables[table][name].dtype), variables[table][name]), name


# --- the page ---------------------------------------------------------------------------------------------------------
def blocks(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGE, flags=re.M | re.S)


def table_after(heading: str, text: str = PAGE) -> list[list[str]]:
    """The rows of the first table after a heading or a sentence."""
    lines = text.split(heading, 1)[1].splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("|---"))
    rows = []
    for line in lines[first + 1 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip().replace("`", "") for cell in line.strip("|").split("|")])
    return rows


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example of the page, made as the page makes it."""
    folder = tmp_path_factory.mktemp("page")
    [text] = re.findall(r"write_text\('''(.*?)'''\)", PAGE, re.S)
    (folder / "example.toml").write_text(text, encoding="utf-8")
    run(load_study(folder / "example.toml"), folder / "example.h5", workers=1)
    return folder / "example.h5"


@pytest.fixture(scope="module")
def program_of_the_page() -> Callable[[Path], Iterator[str]]:
    names: dict[str, Any] = {}
    [text] = [block for block in blocks("python") if "def wrong(" in block]
    assert "import floquet" not in text and "from floquet" not in text
    exec(text, names)
    return lambda path: names["wrong"](path)


def words(column: Column) -> str:
    return ", ".join(f"{number} {word}" for number, word in sorted((column.flags or {}).items()))


@pytest.mark.parametrize("table", store.TABLES)
def test_the_columns_of_the_page_are_those_of_the_schema(table: str) -> None:
    told: list[list[str]] = []
    pending: list[list[str]] = []
    for row in table_after(f"### {table}"):
        if "MODE" in row[0]:
            pending.append(row)
        elif "_K_" in row[0]:
            pending.append(row)
        else:
            told += [*_spread(pending), row]
            pending = []
    told += _spread(pending)
    schema = store.TABLES[table]
    assert [row[0] for row in told] == list(schema)
    for name, kind, meaning, flags in told:
        assert (kind, meaning, flags) == (schema[name].dtype, schema[name].long_name, words(schema[name])), name
    assert {column.units for column in schema.values()} == {"1"}


def _spread(rows: list[list[str]]) -> list[list[str]]:
    """Rows for every mode, or for every interval, one mode after the other."""
    if not rows:
        return []
    places = (
        [("MODE", mode) for mode in MODES] if "MODE" in rows[0][0] else [("K", str(k)) for k in range(1, INTERVALS + 1)]
    )
    return [[re.sub(rf"(?<![A-Z]){a}(?![A-Z])", b, cell) for cell in row] for a, b in places for row in rows]


def test_the_page_names_what_is_in_a_file(example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kinds = {"text": str, "i8": np.int64}
    with h5py.File(example) as file:
        told = table_after("## Root attributes")
        assert {name for name, *_ in told} == set(file.attrs)
        for name, kind, _ in told:
            assert isinstance(file.attrs[name], kinds[kind]), name
        names = {part.strip() for row in table_after("## Integrity") for part in row[0].split(",")}
        for group in file["integrity"].values():
            assert names == {*group, *group.attrs}
        assert {name for name, *_ in table_after("## Variables")} == {*file["points/verdict"].attrs}
        scale = file["points/row"]
        for table in ("points", "limits"):
            for name, variable in file[table].items():
                assert variable.shape == file[table]["row"].shape and variable.fillvalue == 0, name
                made = variable.id.get_create_plist()
                assert [made.get_filter(i)[0] for i in range(made.get_nfilters())] == [2, 1, 3]
        assert file["points/lock"].dims[0][0] == scale and scale[:].tolist() == list(range(62))
        order = file["points/rotor"][:], file["points/advance_ratio"][:]
        assert np.lexsort(order[::-1]).tolist() == list(range(62))
        assert (np.diff(file["limits/rotor"][:]) >= 0).all()
    monkeypatch.setattr("floquet.study.running.remove_parts", lambda *_: None)
    out = tmp_path / "out.h5"
    run(load_study(example.with_suffix(".toml")), out, workers=1)
    folder = tmp_path / "out.h5.parts"
    about = json.loads((folder / "study.json").read_text(encoding="utf-8"))
    assert [name for name, *_ in table_after("makes a database of a folder")] == list(about)
    pattern = re.compile(r"(points|limits)-\d{12}-\d{12}\.h5|study\.toml|study\.json|\.lock")
    assert all(pattern.fullmatch(path.name) for path in folder.iterdir())
    with h5py.File(next(folder.glob("points-*.h5"))) as part:
        [sentence] = re.findall(r"Their root attributes are (.*?);", PAGE, re.S)
        assert set(re.findall(r"`(\w+)`", sentence.split("(the file")[0] + sentence.split("),")[1])) == set(part.attrs)


def _change(name: str, place: Any, value: Any) -> Callable[[h5py.File], None]:
    def act(file: h5py.File) -> None:
        file[name][place] = value

    return act


CHANGES: dict[str, tuple[Callable[[h5py.File], Any], str]] = {
    "a value": (_change("points/lock", CHUNK_ROWS + 3, 0.25), f"points/lock rows {CHUNK_ROWS} on"),
    "a flag": (_change("limits/hub", 0, 2), "limits/hub rows 0 on"),
    "a title": (lambda f: f.attrs.__setitem__("title", "another"), "attributes and schema"),
    "units": (lambda f: f["points/lock"].attrs.__setitem__("units", "deg"), "attributes and schema"),
    "a new variable": (lambda f: f["points"].create_dataset("new", data=[1.0]), "attributes and schema"),
    "a least number": (_change("integrity/points/minima", (0, 0), -7.5), "integrity/points"),
    "a digest": (
        lambda f: f["integrity/limits/digests"].write_direct(~f["integrity/limits/digests"][:]),
        "integrity/limits",
    ),
}


@pytest.fixture
def chunked(tmp_path: Path) -> Path:
    """A file of two chunks of points, with few columns."""
    some = {name: store.POINTS[name] for name in (*store.ALWAYS, "exponent_1", "lock", "verdict")}
    tables = {"points": random_rows(some, CHUNK_ROWS + 9, 8), "limits": random_rows(store.LIMITS, 20, 9)}
    store.write(tmp_path / "whole.h5", tables, {"title": "chunks", "study_id": "0", "rotor_names": "[]"})
    return tmp_path / "whole.h5"


@pytest.mark.parametrize("what", [*CHANGES, "nothing", "a byte", "metadata"])
def test_the_program_of_the_page_finds_what_verify_finds(
    chunked: Path, what: str, program_of_the_page: Callable[[Path], Iterator[str]]
) -> None:
    """On sound files nothing; on a change of every kind the place, as ``floquet verify``."""
    assert list(program_of_the_page(chunked)) == [] == list(store.verify(chunked))
    with h5py.File(chunked, "r+" if what in CHANGES else "r") as file:
        at = file["points/exponent_1_re"].id.get_chunk_info(1).byte_offset
        if what in CHANGES:
            CHANGES[what][0](file)
    data = bytearray(chunked.read_bytes())
    data[{"a byte": at + 100, "metadata": data.find(b"title")}.get(what, 0)] ^= what in ("a byte", "metadata")
    chunked.write_bytes(data)
    if what == "metadata":
        assert next(program_of_the_page(chunked)) == "seal" and store.verify(chunked)
        return
    places = {"a byte": [f"points/exponent_1_re rows {CHUNK_ROWS} on"], "nothing": []}.get(what)
    found = list(program_of_the_page(chunked))
    assert found == places if places is not None else CHANGES[what][1] in found
    assert bool(store.verify(chunked)) == bool(found)


def test_the_program_of_the_page_takes_what_a_run_writes(
    example: Path, program_of_the_page: Callable[[Path], Iterator[str]]
) -> None:
    assert list(program_of_the_page(example)) == []


@pytest.mark.parametrize("module", ["tables", "pyfive"])
def test_the_example_of_a_reader_runs(example: Path, monkeypatch: pytest.MonkeyPatch, module: str) -> None:
    needed(module)
    monkeypatch.chdir(example.parent)
    [text] = [block for block in blocks("py") if f"import {module}" in block]
    names: dict[str, Any] = {}
    exec(text, names)
    with h5py.File(example) as file:
        if module == "tables":
            assert len(names["frame"]) == 62
            assert same_bits(names["frame"]["error_regressing"], file["points/error_regressing"][:])
        else:
            assert same_bits(names["limit"], file["limits/limit"][:])


def test_names_in_other_languages_are_names_in_the_file(example: Path) -> None:
    text = "\n".join(block for kind in ("matlab", "octave", "shell") for block in blocks(kind))
    read = re.findall(r"(?:h5read|ncread)\('example.h5', '(/[\w/]+)'\)", text)
    attributes = re.findall(r"h5readatt\('example.h5', '(/[\w/]*)', '(\w+)'\)", text)
    named = [name for line in re.findall(r"-[vd] (\S+)", text) for name in line.split(",")]
    assert len(read) == 7 and len(attributes) == 2 and len(named) == 4
    with h5py.File(example) as file:
        assert all(isinstance(file[name], h5py.Dataset) for name in (*read, *named))
        assert all(name in file[place].attrs for place, name in attributes)
        assert file["points/verdict"].attrs["flag_meanings"].split(" ")[1] == "UNSTABLE"
        assert json.loads(file.attrs["rotor_names"]) == ["light", "three blades"]


@pytest.mark.parametrize("name", ["ncdump", "h5dump"])
def test_the_commands_of_the_page_run(example: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    program(name)
    monkeypatch.chdir(example.parent)
    lines = [line for block in blocks("shell") for line in block.splitlines() if line.startswith(name)]
    assert len(lines) == 2
    for line in lines:
        done = subprocess.run(line.split(), capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr and done.stdout, line


def test_octave_reads_the_same(example: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    octave = program("octave-cli")
    monkeypatch.chdir(example.parent)
    [text] = blocks("octave")
    script = text + 'printf("%.17g %.17g %.17g\\n", [mu, real(eta), imag(eta)].\');'
    done = subprocess.run([octave, "--norc", "--eval", script], capture_output=True, text=True)
    if "package netcdf" in done.stderr or "not found" in done.stderr:
        pytest.skip("octave's package netcdf is not installed: its reading of a database is NOT tested here")
    assert done.returncode == 0, done.stderr
    found = np.array([line.split() for line in done.stdout.strip().splitlines()], float).T
    with h5py.File(example) as file:
        for values, name in zip(found, ("advance_ratio", "exponent_1_re", "exponent_1_im"), strict=True):
            assert same_bits(values, file[f"points/{name}"][:]), name


# --- versions ---------------------------------------------------------------------------------------------------------
def test_a_newer_minor_version_is_read_and_a_newer_major_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A later release adds a column, a group and an attribute."""
    rows = random_rows(store.LIMITS, 20, 5)
    more = {**store.LIMITS, "new_one": Column("f8", "1", "from a later release")}
    for version in ((1, 7), (2, 0)):
        monkeypatch.setattr("floquet.store.writing.SCHEMA", version)
        path = tmp_path / f"{version[0]}.h5"
        about = {"title": "later", "study_id": "1" * 32, "later": "?"}
        with store.create(path, {"limits": 20}, about, columns={"limits": more}) as writers:
            writers["limits"].add({**rows, "new_one": np.arange(20.0)})
    with open_database(tmp_path / "1.h5") as db:
        assert list(db.columns("limits")) == list(store.LIMITS) and db.attributes["later"] == "?"
        assert same_bits(db.limits(columns="limit")["limit"], rows["limit"])
    assert store.verify(tmp_path / "1.h5") == ()
    with pytest.raises(DatabaseError, match=r"its schema is version 2\.0, and this release reads up to 1\.1"):
        open_database(tmp_path / "2.h5")


# --- answers leave ----------------------------------------------------------------------------------------------------
ENDINGS = ("csv", "json", "parquet", "nc")


@pytest.fixture(params=ENDINGS)
def ending(request: pytest.FixtureRequest) -> str:
    if request.param == "parquet":
        needed("pyarrow")
    return str(request.param)


def read_back(path: Path) -> dict[str, list[Any]]:
    """The columns of a file that was written, complex ones in parts, words as words."""
    if path.suffix == ".csv":
        with path.open(newline="", encoding="utf-8") as source:
            rows = list(csv.DictReader(source))
        return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
    if path.suffix == ".json":
        records = json.loads(path.read_text(encoding="utf-8"))
        return {name: [record[name] for record in records] for name in (records[0] if records else ())}
    if path.suffix == ".parquet":
        table = needed("pyarrow.parquet").read_table(path)
        return {name: table[name].to_pylist() for name in table.column_names}
    with needed("xarray").open_dataset(path, engine="h5netcdf") as data:
        return {str(name): data[name].values.tolist() for name in data.data_vars}


def numbers(values: list[Any]) -> Any:
    """Numbers as any of the formats has them."""
    return np.array([np.nan if value is None else float(value) for value in values])


@pytest.mark.parametrize("options", [
    {"expression": "lock_number > 0.5"},
    {"expression": "lock_number > 0.5", "limit": 7},
    {"expression": "isfinite(lock)", "sort": "lock", "descending": True, "limit": 9},
    {"sort": "advance_ratio", "limit": 30_000},
    {"expression": "blades > 500"},
    {"limit": 0},
], ids=["rows", "first", "best", "all", "none", "no row"])  # fmt: skip
def test_an_answer_is_written_as_it_is_asked(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, ending: str, options: dict[str, Any]
) -> None:
    names = ("rotor", "rotor_name", "exponent_1", "verdict", "lock", "advance_ratio")
    out = tmp_path / f"out.{ending}"
    with open_database(written[0]) as db:
        expected = db.query(columns=names, **options)
        assert db.save(out, columns=names, **options) == out
    found = read_back(out)
    if not len(expected["lock"]) and ending in ("csv", "json"):
        header = "rotor,rotor_name,exponent_1_re,exponent_1_im,verdict,lock,advance_ratio\n"
        assert out.read_text() == (header if ending == "csv" else "[]\n")
        return
    assert len(found["lock"]) == len(expected["lock"])
    for name in ("lock", "advance_ratio", "rotor"):
        np.testing.assert_array_equal(numbers(found[name]), expected[name].astype(float))
    verdicts = store.POINTS["verdict"].flags or {}
    as_stored = expected["verdict"].tolist()
    assert found["verdict"] == (as_stored if ending == "nc" else [verdicts[v] for v in as_stored])
    if ending == "json":
        parts = [numbers(list(part)) for part in zip(*found["exponent_1"], strict=True)]
    else:
        parts = [numbers(found[f"exponent_1_{part}"]) for part in ("re", "im")]
    np.testing.assert_array_equal(parts, [expected["exponent_1"].real, expected["exponent_1"].imag])
    if ending == "nc":
        with h5py.File(out) as file:
            assert file["rotor"].attrs["flag_meanings"] == "Bo_105 rotor_1 Лynx_µ" and "rotor_name" not in file
            assert file["exponent_1_im"].attrs["long_name"] == store.POINTS["exponent_1"].long_name + ", imaginary part"
            assert file.attrs["title"] == "random"
    else:
        assert found["rotor_name"] == expected["rotor_name"].tolist()


def test_groups_and_names_alone_are_written(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, ending: str
) -> None:
    out = tmp_path / f"out.{ending}"
    with open_database(written[0]) as db:
        expected = db.groups(by="hub,blades", reduce="median(lock), first(verdict), count", limit=11)
        db.save(out, by="hub,blades", reduce="median(lock), first(verdict), count", limit=11)
        found = read_back(out)
        for name in ("blades", "median(lock)", "count"):
            np.testing.assert_array_equal(numbers(found[name]), expected[name].astype(float), err_msg=name)
        flags = {name: store.POINTS[name].flags or {} for name in ("verdict", "hub")}
        for name, of in (("first(verdict)", "verdict"), ("hub", "hub")):
            plain = expected[name].tolist()
            assert found[name] == (plain if ending == "nc" else [flags[of][v] for v in plain])
        db.save(out, "lock == inf", columns="rotor_name", limit=40)
        rotors = db.query("lock == inf", columns="rotor_name", limit=40)["rotor_name"].tolist()
        assert _names(out, "rotor_name", ending) == [plain_name(name, ending) for name in rotors]
        worst = "rotor_name at min(lock)"
        db.save(out, by="hub,blades", reduce=worst, limit=11)
        expected = db.groups(by="hub,blades", reduce=worst, limit=11)
        assert _names(out, worst, ending) == [plain_name(name, ending) for name in expected[worst].tolist()]


def plain_name(name: str, ending: str) -> str:
    """As it stands in a file: netCDF's words are without spaces, and none is empty."""
    return ("_".join(name.split()) or "-") if ending == "nc" else name


def _names(out: Path, column: str, ending: str) -> list[str]:
    found = read_back(out)[column]
    if ending == "nc":
        with h5py.File(out) as file:
            told = file[column].attrs["flag_meanings"].split(" ")
        return [told[i] for i in found]
    return list(found)


def test_a_whole_table_leaves_by_the_same_writers(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, ending: str
) -> None:
    whole = export.export(written[0], tmp_path / f"whole.{ending}", "limits")
    with open_database(written[0]) as db:
        columns = ["rotor", "rotor_name", *list(store.LIMITS)[1:]]
        asked = db.save(tmp_path / f"asked.{ending}", table="limits", columns=columns)
    if ending == "nc":
        with h5py.File(whole) as a, h5py.File(asked) as b:
            names = [*store.stored_variables(store.LIMITS), "row"]
            assert {*a} == {*b} == {*names, "integrity"} and all(same_bits(a[n][:], b[n][:]) for n in names)
            for name in names:
                texts = [{k: v for k, v in f[name].attrs.items() if isinstance(v, str)} for f in (a, b)]
                assert texts[0] == texts[1], name
    else:
        assert whole.read_bytes() == asked.read_bytes()


def test_several_files_leave_with_their_names(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, ending: str
) -> None:
    shutil.copy(written[0], tmp_path / "b.h5")
    with open_database([written[0], tmp_path / "b.h5"]) as db:
        db.save(tmp_path / f"out.{ending}", "lock == 1e-17", columns="file,rotor".split(","), table="points")
        found = read_back(tmp_path / f"out.{ending}")["file"]
        names = [str(written[0]), str(tmp_path / "b.h5")]
        assert found == sorted(found, key=(names if ending != "nc" else [0, 1]).index) and len(set(found)) == 2
        with pytest.raises(InputError, match="is the database that is read, and would be lost"):
            shutil.copy(tmp_path / "b.h5", tmp_path / "c.nc")
            with open_database(tmp_path / "c.nc") as other:
                other.save(tmp_path / "c.nc", "lock > 3")
    assert store.verify(tmp_path / "c.nc") == ()


def test_the_rows_of_a_row_group_are_many(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 64 rows, of which a query leaves a few each, are joined before they are written."""
    parquet = needed("pyarrow.parquet")
    monkeypatch.setattr("floquet.export.TOGETHER", 300)
    table = fake_points(4000)
    db = Database("fake.h5", FakeFile({"points": table}))
    db.save(tmp_path / "a.parquet", "blades == 3", columns=("rotor", "blades"))
    count = int((table["blades"] == 3).sum())
    meta = parquet.ParquetFile(tmp_path / "a.parquet").metadata
    groups = [meta.row_group(i).num_rows for i in range(meta.num_row_groups)]
    assert sum(groups) == count and all(300 <= rows < 364 for rows in groups[:-1]) and len(groups) > 2
    field = parquet.read_schema(tmp_path / "a.parquet").field("blades")
    assert field.metadata[b"units"] == b"1"


def test_a_large_answer_needs_the_memory_of_a_chunk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    monkeypatch.setattr("floquet.export.TOGETHER", 2048)
    monkeypatch.setattr("floquet.store.schema.CHUNK_ROWS", 1024)
    db = Database("fake.h5", FakeFile({"points": fake_points(120_000)}, chunk=1024))
    db.save(tmp_path / f"small.{ending}", "blades > 2", limit=10)  # imports
    tracemalloc.start()
    db.save(tmp_path / f"a.{ending}", "blades > 2", columns=("lock", "lock_number", "advance_ratio", "exponent_1"))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.5e6  # the answer is 90 000 rows of 40 bytes, 3.6 MB, and a chunk as text 0.3 MB


def test_a_file_is_replaced_whole_or_not_at_all(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, ending: str
) -> None:
    with open_database(written[0]) as db:
        out = db.save(tmp_path / f"a.{ending}", limit=3)
        before = out.read_bytes()

        def broken() -> Iterator[Any]:
            answer = db.answer(limit=9)
            yield next(iter(answer.pieces))
            raise OSError(28, "no space")

        answer = db.answer(limit=9)
        object.__setattr__(answer, "pieces", broken())
        with pytest.raises(StorageError, match="the disk is full"):
            export.write(answer, out)
        assert out.read_bytes() == before
        db.save(out, limit=4)
        assert len(read_back(out)["rotor"]) == 4
    assert [path.name for path in tmp_path.iterdir()] == [f"a.{ending}"]


def status(*arguments: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_the_command_writes_what_it_shows(
    written: tuple[Path, dict[str, Arrays]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    ask = ("query", str(written[0]), "lock > 1", "--columns", "rotor,exponent_1,lock,verdict", "--limit", "500")
    for style in ("csv", "json"):
        assert status(*ask, f"--{style}") == 0
        shown = capsys.readouterr().out
        assert status(*ask, "-o", f"a.{style}") == 0
        assert capsys.readouterr() == ("", f"wrote a.{style}\n")
        assert Path(f"a.{style}").read_text(encoding="utf-8") == shown and len(shown) > 5000
    for wrong, sentence in (
        (("-o", "a.xls"), ".xls is no format of export"),
        (("-o", "a"), "no ending is no format of export"),
        (("-o", "a.csv", "--json"), "--json is for the screen, and the ending of a.csv says the format"),
        (("-o", "nowhere/a.nc"), "the folder does not exist"),
    ):
        assert status(*ask, *wrong) == (1 if "folder" in sentence else 2)
        assert sentence in capsys.readouterr().err
    assert not Path("a.xls").exists()


def test_names_that_are_all_empty_make_no_column(tmp_path: Path) -> None:
    rows = random_rows(store.LIMITS, 9, 3)
    store.write(tmp_path / "a.h5", {"limits": rows}, {"study_id": "0", "rotor_names": '["", "", ""]'})
    with open_database(tmp_path / "a.h5") as db:
        assert "rotor_name" not in db.limits() and "rotor_name" not in db.groups(by="rotor", table="limits")
        assert db.limits(columns="rotor_name")["rotor_name"].tolist() == [""] * 9
        assert "rotor_name" in db.limits(columns="*")


# --- medians ----------------------------------------------------------------------------------------------------------
def test_medians_are_those_of_sorted_values(written: tuple[Path, dict[str, Arrays]]) -> None:
    columns = written[1]["points"]
    with open_database(written[0]) as db:
        found = db.groups(by="hub,rotor", reduce="median(lock), median(blades), count(lock)")
        empty = db.groups("blades > 500", by="hub", reduce="median(lock)")
        alone = db.groups("lock != lock", reduce="median(lock)")
    assert empty["median(lock)"].shape == (0,) and np.isnan(alone["median(lock)"]).tolist() == [True]
    for hub, rotor, lock, blades in zip(
        *(found[n] for n in ("hub", "rotor", "median(lock)", "median(blades)")), strict=True
    ):
        rows = (columns["hub"] == hub) & (columns["rotor"] == rotor)
        for median, name in ((lock, "lock"), (blades, "blades")):
            with np.errstate(all="ignore"):
                assert median == np.nanmedian(columns[name][rows]), (hub, rotor, name)
    cases = {(1, 2): 1.5, (3, 1, 2): 2, (1, np.nan): 1, (np.inf, 1, np.inf): np.inf, (np.nan,): np.nan, (4, 2, 1, 8): 3}
    table = fake_points(sum(map(len, cases)))
    table["lock"] = np.array([value for values in cases for value in values], float)
    table["blades"] = np.repeat(np.arange(6, dtype="i2"), [len(values) for values in cases])
    few = Database("x", FakeFile({"points": table}, chunk=4)).groups(by="blades", reduce="median(lock)")
    np.testing.assert_array_equal(few["median(lock)"], list(cases.values()))
    with pytest.raises(ParameterError, match="verdict holds words, which have no order"):
        Database("x", FakeFile({"points": fake_points(9)})).groups(reduce="median(verdict)")


def test_the_package_says_what_it_said() -> None:
    assert {"Database", "open_database", "compile_expression", "Scope", "Predicate"} <= set(query.__all__)
