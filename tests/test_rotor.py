"""The rotor: its derived values, its rules, and the files it is read from and written to."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquet
from floquet.errors import ConfigError, ParameterError
from floquet.rotor import PARAMETERS, Hub, Rotor, dump_rotor, load_rotor
from floquet.rotorfile import PhysicalTable, RotorTable

DATA = Path(__file__).parent.parent / "data" / "rotors"
FILES = sorted(DATA.glob("*.toml"))


def load(tmp_path: Path, text: str) -> Rotor:
    path = tmp_path / "rotor.toml"
    path.write_text(text, encoding="utf-8")
    return load_rotor(path)


def problems(tmp_path: Path, text: str) -> list[tuple[int, str, str]]:
    with pytest.raises(ConfigError) as caught:
        load(tmp_path, text)
    assert caught.value.path == str(tmp_path / "rotor.toml")
    return [tuple(problem) for problem in caught.value.problems]


def parts(rotor: Rotor) -> dict[str, Any]:
    values = {f.name: getattr(rotor, f.name) for f in fields(rotor)}
    return values | {"sources": dict(rotor.sources), "derived": rotor.offset_mass_derived}


# Rotors of the data folder


@pytest.mark.parametrize(("name", "square"), [("bo105", 1.248), ("lynx", 1.193), ("puma", 1.052)])
def test_flap_frequency_of_hingeless_rotors(name: str, square: float) -> None:
    """1 + K_β / (I_β Ω²) by hand, to three decimals."""
    rotor = load_rotor(DATA / f"{name}.toml")
    assert round(rotor.flap_frequency**2, 3) == square
    assert rotor.frequency_ratio_squared == pytest.approx(rotor.flap_frequency**2, rel=1e-15)  # K₁ = 0


def test_uh60a_has_a_hinge_offset_and_its_own_static_moment() -> None:
    rotor = floquet.load_rotor(DATA / "uh60a.toml")
    assert round(rotor.flap_frequency, 3) == 1.035
    assert rotor.hinge_offset == 0.381 / 8.178
    assert rotor.static_moment_ratio == pytest.approx(8.178 * 385.7 / 2050.8, rel=1e-15)
    assert rotor.offset_mass_ratio == pytest.approx(0.381 * 385.7 / 2050.8, rel=1e-15)
    assert (rotor.rotor_speed, rotor.radius, rotor.name, rotor.blades) == (27.0, 8.178, "UH-60A", 4)


def test_the_reports_cases() -> None:
    found = {}
    for n in (6, 7, 8, 9):
        rotor = load_rotor(DATA / f"tp1431-fig{n}.toml")
        assert (rotor.name, rotor.lock_number) == (f"TP-1431 figure {n}", 8.0)
        found[n] = (rotor.hinge_offset, rotor.hinge_stiffness, rotor.pitch_flap_coupling)
    assert found == {6: (0, 0, 0), 7: (0.15, 0, 0), 8: (0, 0.225, 0), 9: (0, 0, 0.225)}
    assert load_rotor(DATA / "teetering-nominal.toml").hub is Hub.TEETERING


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_number_of_a_data_file_has_a_source(path: Path) -> None:
    table = tomllib.loads(path.read_text(encoding="utf-8"))["rotor"]
    numbers = {
        key for part in (table, table.get("physical", {})) for key, v in part.items() if isinstance(v, int | float)
    }
    rotor = load_rotor(path)
    assert numbers and numbers == set(table["sources"]) == set(rotor.sources)
    assert all(len(sentence) > 10 for sentence in rotor.sources.values())


def test_there_are_nine_files() -> None:
    assert len(FILES) == 9 and len({load_rotor(path).name for path in FILES}) == 9


# Writing and reading back


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_data_files_round_trip(path: Path, tmp_path: Path) -> None:
    rotor = load_rotor(path)
    assert parts(load(tmp_path, dump_rotor(rotor))) == parts(rotor)


NUMBER = st.floats(1e-300, 1e300)
TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=12)


@settings(max_examples=80, deadline=None)
@given(
    st.fixed_dictionaries(
        {"lock_number": NUMBER},
        optional={
            "hinge_offset": st.floats(0, 1, exclude_max=True), "hinge_stiffness": NUMBER,
            "root_cutout": st.just(5e-324),
            "pitch_flap_coupling": st.floats(-1e300, 1e300), "offset_mass_ratio": NUMBER, "flap_damping": NUMBER,
            "static_moment_ratio": NUMBER, "rotor_speed": NUMBER, "radius": NUMBER, "blades": st.integers(1, 9),
            "name": TEXT, "sources": st.dictionaries(st.sampled_from(["lock_number", "blades", "chord"]), TEXT),
        },
    )
)  # fmt: skip
def test_any_rotor_round_trips(values: dict[str, Any]) -> None:
    from floquet.rotor import _from_document
    from floquet.tomlfile import parse_document

    rotor = Rotor(**values)
    assert parts(_from_document(parse_document(dump_rotor(rotor), "x"))) == parts(rotor)


def test_names_with_control_characters_round_trip(tmp_path: Path) -> None:
    name = "".join(map(chr, (*range(1, 32), 34, 39, 92, 127, 0x1F681)))
    assert load(tmp_path, dump_rotor(Rotor(lock_number=8.0, name=name))).name == name


def test_a_batch_is_not_dumped() -> None:
    with pytest.raises(ParameterError, match=r"batch of shape \(2,\).*rotor\[0\]"):
        dump_rotor(Rotor(lock_number=[4.0, 8.0]))


# Reading


def test_the_smallest_file_has_the_defaults_of_rotor(tmp_path: Path) -> None:
    assert parts(load(tmp_path, "[rotor]\nlock_number = 8\n")) == parts(Rotor(lock_number=8.0))


def test_the_file_takes_every_field_of_a_rotor() -> None:
    assert set(RotorTable.model_fields) == {f.name for f in fields(Rotor)} | {"notes", "physical"}
    assert set(PhysicalTable.model_fields) - {f.name for f in fields(Rotor)} == set(floquet.rotor._PHYSICAL)


def test_physical_values_are_made_nondimensional(tmp_path: Path) -> None:
    text = """[rotor]
    radius = 2.0
    pitch_flap_coupling = 0.1
    notes = "radius and rotor speed may stand in either table"
    [rotor.physical]
    rotor_speed = 3.0
    flap_inertia = 5.0
    hinge_spring = 7.0
    hinge_offset = 0.5
    static_moment = 11.0
    air_density = 1.2
    lift_slope = 5.5
    chord = 0.25
    [rotor.sources]
    chord = "measured"
    """
    rotor = load(tmp_path, text)
    assert rotor.hinge_stiffness == pytest.approx(7 / 45, rel=1e-15)
    assert rotor.hinge_offset == 0.25
    assert rotor.static_moment_ratio == pytest.approx(2 * 11 / 5, rel=1e-15)
    assert rotor.offset_mass_ratio == pytest.approx(0.5 * 11 / 5, rel=1e-15)
    assert rotor.lock_number == pytest.approx(1.2 * 5.5 * 0.25 * 16 / 5, rel=1e-15)
    assert (rotor.rotor_speed, rotor.radius, rotor.pitch_flap_coupling) == (3.0, 2.0, 0.1)
    assert dict(rotor.sources) == {"chord": "measured"}
    without = load(tmp_path, text.replace("static_moment = 11.0", ""))
    assert (without.static_moment_ratio, without.offset_mass_ratio) == (1.5, 0.375)


def test_a_rotor_in_code_needs_no_pydantic() -> None:
    code = "import sys, floquet.rotor as r; r.Rotor(lock_number=8.0); assert 'pydantic' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


# What is wrong with a file

HEAD = "[rotor]\nname = 'x'\n"
GOOD = HEAD + "lock_number = 8.0\n"
SIZE = "[rotor.physical]\nradius = 4.0\nrotor_speed = 40.0\nflap_inertia = 200.0\n"
TWICE = "it and {} of [rotor.physical] determine the same quantity ({}); keep one of the two"
TEETER = (
    "0.05 was given, but the blades of a teetering rotor share one hinge on the shaft axis, so it must be 0; "
    'leave it out or use hub = "articulated"'
)
LACKS = "{} cannot be computed from it without {}; add {} to [rotor.physical]"
MADE = "it makes {}, which must be {}: check the values it is computed from and their units"
FRACTION = "it is a fraction of the radius, so divide {} in metres by the radius"

CASES = [
    (HEAD, 1, "lock_number", "it is missing and has no default; "
     "give it in [rotor], or air_density, lift_slope and chord in [rotor.physical]"),
    (GOOD + "hinge_ofset = 0.1", 4, "hinge_ofset", "unknown key, did you mean 'hinge_offset'?"),
    (GOOD + "physical.radus = 1", 4, "physical.radus", "unknown key, did you mean 'radius'?"),
    (HEAD + "lock_number = 0", 3, "lock_number", "0 was given; it must be > 0: "
     "a blade without lift does not flap, so check the sign and the values it was computed from"),
    (GOOD + "hinge_offset = 1.0", 4, "hinge_offset",
     "1 was given; it must be >= 0 and < 1: " + FRACTION.format("an offset")),
    (GOOD + "root_cutout = 1", 4, "root_cutout",
     "1 was given; it must be >= 0 and < 1: " + FRACTION.format("a cutout")),
    (GOOD + "hinge_stiffness = -1", 4, "hinge_stiffness",
     "-1 was given; it must be >= 0: a negative spring is not modelled, so check the sign"),
    (GOOD + "flap_damping = nan", 4, "flap_damping", "nan was given; it must be a finite number: "
     "look for a missing value or a division by zero where it was computed"),
    (GOOD + "radius = 0", 4, "radius", "0 was given; it must be > 0: give the radius in metres, or leave it out"),
    (GOOD + "blades = 4.0", 4, "blades", "4.0 was given; it must be a whole number: write 4"),
    (GOOD + "blades = 0", 4, "blades", "0 was given; it must be >= 1, and 1 stands for a single blade's equation"),
    (GOOD + "hub = 'teeter'", 4, "hub",
     "'teeter' is no hub; it is articulated or teetering, did you mean 'teetering'?"),
    (GOOD + "hub = 1", 4, "hub", "1 was given; it must be a text in quotes"),
    (GOOD + "hub = 'teetering'", 1, "blades", "it is missing, and a teetering rotor has two; add blades = 2"),
    (GOOD + "blades = 3\nhub = 'teetering'", 4, "blades",
     '3 was given, but a teetering rotor has two, so give blades = 2 or hub = "articulated"'),
    (GOOD + "hub = 'teetering'\nblades = 2\nhinge_offset = 0.05", 6, "hinge_offset", TEETER),
    (GOOD + "hub = 'teetering'\nblades = 2\noffset_mass_ratio = 0.05", 6, "offset_mass_ratio", TEETER),
    (GOOD + SIZE + "lock_number = 5", 3, "lock_number", TWICE.format("lock_number", "lock_number")),
    (GOOD + SIZE + "chord = 0.3", 3, "lock_number", TWICE.format("chord", "lock_number")),
    (HEAD + SIZE + "lock_number = 5\nchord = 0.3", 7, "physical.lock_number", TWICE.format("chord", "lock_number")),
    (GOOD + "radius = 4.0\n" + SIZE, 4, "radius", TWICE.format("radius", "radius")),
    (GOOD + "rotor_speed = 4.0\n" + SIZE, 4, "rotor_speed", TWICE.format("rotor_speed", "rotor_speed")),
    (GOOD + "hinge_offset = 0.0\n" + SIZE + "hinge_offset = 0.0", 4, "hinge_offset",
     TWICE.format("hinge_offset", "hinge_offset")),
    (GOOD + "hinge_stiffness = 0.1\n" + SIZE + "hinge_spring = 1", 4, "hinge_stiffness",
     TWICE.format("hinge_spring", "hinge_stiffness")),
    (GOOD + "static_moment_ratio = 1\n" + SIZE + "static_moment = 1", 4, "static_moment_ratio",
     TWICE.format("static_moment", "static_moment_ratio")),
    (GOOD + "offset_mass_ratio = 1\n" + SIZE + "static_moment = 1", 4, "offset_mass_ratio",
     TWICE.format("static_moment", "offset_mass_ratio")),
    (HEAD + SIZE + "air_density = 1.2\nchord = 0.3", 7, "physical.air_density",
     LACKS.format("lock_number", *["lift_slope"] * 2)),
    (GOOD + "physical.hinge_spring = 3", 4, "physical.hinge_spring",
     LACKS.format("hinge_stiffness", *["flap_inertia and rotor_speed"] * 2)),
    (GOOD + "physical.hinge_offset = 3", 4, "physical.hinge_offset", LACKS.format("hinge_offset", *["radius"] * 2)),
    (GOOD + "physical.static_moment = 3", 4, "physical.static_moment",
     LACKS.format("static_moment_ratio", *["radius and flap_inertia"] * 2)),
    (GOOD + "physical.chord = -3", 4, "physical.chord", "-3 was given; it must be > 0"),
    (GOOD + "physical.hinge_spring = -3", 4, "physical.hinge_spring", "-3 was given; it must be >= 0"),
    (GOOD + SIZE + "hinge_offset = 8", 8, "physical.hinge_offset", MADE.format("hinge_offset 2", ">= 0 and < 1")),
    (GOOD + SIZE.replace("200.0", "1e-320").replace("40.0", "1e-9") + "hinge_spring = 8", 8, "physical.hinge_spring",
     MADE.format("hinge_stiffness nan", "a finite number")),
    (GOOD + "sources.hinge_offset = 'a book'", 4, "sources.hinge_offset",
     "a source is given for a key that is not in the file, so give the key or leave the source out"),
    (GOOD + "sources.lock_numbr = 'a book'", 4, "sources.lock_numbr",
     "a source is given for a key that is not in the file, did you mean 'lock_number'?"),
    (GOOD + SIZE + "[rotor.sources]\nchord = 'a book'", 9, "sources.chord",
     "a source is given for a key that is not in the file, so give the key or leave the source out"),
    (GOOD + "sources.name = 3", 4, "sources.name", "3 was given; it must be a text in quotes"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "key", "sentence"), CASES, ids=lambda v: str(v)[-24:])
def test_one_sentence_for_each_problem(tmp_path: Path, text: str, line: int, key: str, sentence: str) -> None:
    assert problems(tmp_path, text) == [(line, f"rotor.{key}", sentence)]


def test_all_problems_of_a_file_come_at_once(tmp_path: Path) -> None:
    text = HEAD + "lock_number = 0\nflp_damping = 0\nblades = '4'\nhub = 'artic'\nphysical.chrod = 1\nhinge_offset = 2"
    found = problems(tmp_path, text)
    assert [line for line, *_ in found] == [3, 4, 5, 6, 7, 8]
    found = problems(tmp_path, HEAD + "hinge_offset = 2\nblades = 0\nsources.chrod = 'a'\nphysical.hinge_offset = 1\n")
    assert [(line, key.removeprefix("rotor.")) for line, key, _ in found] == [
        (1, "lock_number"), (3, "hinge_offset"), (3, "hinge_offset"), (4, "blades"), (5, "sources.chrod"),
    ]  # fmt: skip


def test_missing_file_directory_and_syntax(tmp_path: Path) -> None:
    for path, what in ((DATA / "bo15.toml", "no such file, did you mean 'bo105.toml'"), (DATA, "this is a directory")):
        with pytest.raises(ConfigError, match=what):
            load_rotor(path)
    assert problems(tmp_path, "[rotor]\nlock_number = \n")[0][0] == 2


# Rotors in code


def test_derived_frequencies() -> None:
    rotor = Rotor(lock_number=8.0, hinge_offset=0.06, hinge_stiffness=0.11, pitch_flap_coupling=0.5)
    assert rotor.offset_mass_ratio == pytest.approx(0.09, rel=1e-15)
    assert rotor.flap_frequency == pytest.approx(math.sqrt(1.2), rel=1e-15)
    assert rotor.frequency_ratio_squared == pytest.approx(1.2 + 0.5 * (1 - 0.08), rel=1e-15)


BAD: list[tuple[dict[str, Any], str, str]] = [
    ({"lock_number": 0.0}, "lock_number", "must be > 0"),
    ({"lock_number": -8.0}, "lock_number", "-8 was given"),
    ({"lock_number": math.nan}, "lock_number", "nan was given; it must be a finite number"),
    ({"lock_number": "8"}, "lock_number", "must be a real number"),
    ({"lock_number": True}, "lock_number", "must be a real number"),
    ({"lock_number": [4.0, -1.0]}, "lock_number", "-1 at index 1 was given"),
    ({"lock_number": [[1.0, 2.0], [3.0]]}, "lock_number", "unequal length"),
    ({"lock_number": np.ma.masked_equal([1.0, 2.0], 2.0)}, "lock_number", "masked"),
    ({}, "lock_number", "missing and has no default"),
    ({"lock_numbr": 8.0}, "lock_numbr", "did you mean 'lock_number'"),
    ({"hinge_offset": 1.0}, "hinge_offset", ">= 0 and < 1.*divide an offset in metres"),
    ({"hinge_offset": -0.1}, "hinge_offset", ">= 0 and < 1"),
    ({"hinge_stiffness": -1e-9}, "hinge_stiffness", ">= 0"),
    ({"static_moment_ratio": 0.0}, "static_moment_ratio", "> 0"),
    ({"flap_damping": math.inf}, "flap_damping", "finite"),
    ({"pitch_flap_coupling": math.inf}, "pitch_flap_coupling", "finite"),
    ({"blades": 0}, "blades", ">= 1"),
    ({"blades": 4.0}, "blades", "whole number"),
    ({"blades": True}, "blades", "whole number"),
    ({"blades": 1001}, "blades", "must be <= 1000"),
    ({"blades": 10**30}, "blades", "must be <= 1000"),
    ({"hub": "teter"}, "hub", "articulated or teetering"),
    ({"hub": 2}, "hub", "is no hub"),
    ({"hub": Hub.TEETERING}, "blades", "a teetering rotor has two"),
    ({"hub": Hub.TEETERING, "blades": 2, "hinge_offset": 0.05}, "hinge_offset", "share one hinge"),
    ({"hub": Hub.TEETERING, "blades": 2, "offset_mass_ratio": 0.05}, "offset_mass_ratio", "share one hinge"),
    ({"radius": [1.0, 2.0]}, "radius", "one number for the whole batch"),
    ({"rotor_speed": 0.0}, "rotor_speed", "> 0"),
    ({"name": 3}, "name", "must be a text"),
    ({"name": "a\0b"}, "name", "no database or UTF-8 file can keep"),
    ({"name": "a\udcffb"}, "name", "no database or UTF-8 file can keep"),
    ({"sources": {"radius": "\0"}}, "sources.radius", "no database or UTF-8 file can keep"),
    ({"sources": {"lock_numbr": "a"}}, "sources", "did you mean 'lock_number'"),
    ({"sources": 3}, "sources", "must map"),
    ({"hinge_offset": np.zeros(3), "hinge_stiffness": np.zeros(2)}, "hinge_stiffness", "do not broadcast"),
]


@pytest.mark.parametrize(("values", "name", "what"), BAD, ids=lambda v: str(v)[:40])
def test_a_bad_value_is_one_sentence_with_its_name(values: dict[str, Any], name: str, what: str) -> None:
    full = values if any(key.startswith("lock") for key in values) or not values else {"lock_number": 8.0, **values}
    with pytest.raises(ParameterError, match=what) as caught:
        Rotor(**full)
    assert caught.value.name == name and isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)


def test_parameters_go_by_name() -> None:
    with pytest.raises(ParameterError, match=r"write lock_number=8\.0"):
        Rotor(8.0)  # type: ignore[misc]


def test_arrays_broadcast_without_an_outer_product() -> None:
    rotor = Rotor(lock_number=np.array([[4.0], [8.0]]), hinge_offset=[0.0, 0.1, 0.2], blades=3)
    assert rotor.shape == (2, 3)
    assert np.shape(rotor.lock_number) == (2, 1) and np.shape(rotor.flap_frequency) == (3,)
    np.testing.assert_array_equal(rotor.offset_mass_ratio, 1.5 * np.array([0.0, 0.1, 0.2]))
    full = rotor.broadcast()
    assert all(np.shape(getattr(full, p.name)) == (2, 3) for p in PARAMETERS)
    one = rotor[1, 2]
    assert (one.lock_number, one.hinge_offset, one.blades, one.shape) == (8.0, 0.2, 3, ())
    assert one.flap_frequency == rotor.broadcast().flap_frequency[1, 2]
    with pytest.raises(ParameterError, match="only a rotor with array parameters"):
        one[0]


def test_a_rotor_cannot_be_changed_from_outside() -> None:
    values = np.array([4.0, 8.0])
    rotor = Rotor(lock_number=values)
    values[0] = -1.0
    np.testing.assert_array_equal(rotor.lock_number, [4.0, 8.0])
    for copy in (rotor, pickle.loads(pickle.dumps(rotor))):
        with pytest.raises(ValueError, match="read-only"):
            copy.lock_number[0] = 1.0


def test_replace_does_not_go_stale() -> None:
    """A derived offset_mass_ratio follows; a source goes with its value, a physical one with the last value it made."""
    rotor = Rotor(lock_number=8.0, hinge_offset=0.1)
    assert rotor.replace(hinge_offset=0.2).offset_mass_ratio == pytest.approx(0.3, rel=1e-15)
    assert rotor.replace(static_moment_ratio=2.0).offset_mass_ratio == pytest.approx(0.2, rel=1e-15)
    own = rotor.replace(offset_mass_ratio=0.4)
    assert own.replace(hinge_offset=0.2).offset_mass_ratio == 0.4
    assert own.replace(offset_mass_ratio=None).offset_mass_ratio == rotor.offset_mass_ratio
    bo105 = load_rotor(DATA / "bo105.toml")
    changed = bo105.replace(hinge_stiffness=0.1, lock_number=6.0)
    assert set(bo105.sources) - set(changed.sources) == {"lock_number", "hinge_spring"}
    assert set(bo105.broadcast().sources) == set(bo105[()].sources) == set(bo105.sources)


def test_parameters_are_the_float_fields_in_the_database_order() -> None:
    names = [p.name for p in PARAMETERS]
    assert names == [
        "lock_number", "hinge_offset", "hinge_stiffness", "pitch_flap_coupling", "offset_mass_ratio",
        "static_moment_ratio", "flap_damping", "root_cutout",
    ]  # fmt: skip
    assert [p.rule for p in PARAMETERS][:4] == ["> 0", ">= 0 and < 1", ">= 0", "any finite number"]


def test_repr_shows_what_was_given() -> None:
    assert repr(Rotor(lock_number=8.0, hinge_offset=0.05)) == "Rotor(lock_number=8, hinge_offset=0.05)"
    assert repr(Rotor(lock_number=[4.0, 8.0])) == "Rotor(lock_number=<2 values, 4 to 8>)"
