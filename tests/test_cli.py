"""The command line: every answer in three dresses, every bad input one sentence and its exit status, no traceback."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import pytest

from floquet import Rotor, compare, load_rotor, lock_windows, validity_limit
from floquet.cli import command, main
from floquet.cli.options import ROTOR_FLAGS
from floquet.cli.talk import duration, progress
from floquet.plain import csv_lines
from floquet.report import NO_INFLOW
from floquet.store import ALWAYS, data_digest, open_file
from floquet.study import RunReport, load_study
from floquet.study import run as run_study
from floquet.validity import limits

ROOT = Path(__file__).resolve().parent.parent
ROTORS = ROOT / "data" / "rotors"
BLADE = ("--lock-number", "8", "--hinge-offset", "0.05")


@dataclass
class Done:
    """What a command left behind."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out, parse_constant=lambda word: pytest.fail(f"{word} is not strict JSON"))


Floquet = Callable[..., Done]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Floquet:
    """``run("analyse", …)`` in this process."""

    def call(*arguments: str | Path) -> Done:
        capsys.readouterr()
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return Done(int(end.value.code or 0), out, err)

    return call


def process(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """``floquet …`` in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)} | options.pop("env", {})
    words = [sys.executable, "-m", "floquet", *arguments]
    return subprocess.run(words, env=environment, text=True, stderr=subprocess.PIPE, **options)


def refused(done: Done, *words: str, status: int = 2) -> None:
    """Nothing on stdout, one sentence on stderr that contains the words, the status."""
    assert done.status == status, done.err
    assert done.out == ""
    assert done.err.startswith("floquet: ")
    assert all(word in done.err for word in words), done.err


# Answers.


def test_flags_are_the_fields_of_a_rotor() -> None:
    from dataclasses import fields

    assert {name for name, *_ in ROTOR_FLAGS} | {"hub"} == {f.name for f in fields(Rotor)} - {"sources"}


def test_analyse_gives_the_exponents_of_the_library(run: Floquet) -> None:
    answer = run("analyse", *BLADE, "--advance-ratio", "0.3", "--json").json
    expected = compare(Rotor(lock_number=8.0, hinge_offset=0.05), 0.3)
    assert [complex(*eta) for eta in answer["exponents"]] == expected.stability.exponents.tolist()
    assert answer["lock"] is None and answer["verdict"] == "STABLE"
    assert answer["modes"][0]["error"] == expected["regressing"].error
    assert answer["modes"][0]["rule"] == "PAIRED"


def test_analyse_checks_and_proves(run: Floquet) -> None:
    pytest.importorskip("flint")
    flags = ("analyse", *BLADE, "--advance-ratio", "0.3", "--check", "--certify")
    answer, text = run(*flags, "--json").json, run(*flags).out
    assert answer["method"] == "CERTIFIED" and max(answer["exponent_errors"]) < 1e-16
    assert answer["certificate"]["verdict"] == "STABLE" and answer["check"]["converged"]
    assert answer["rotation_number"] == answer["exponents"][0][1] == answer["certificate"]["exponents"][0][1]
    assert "proved: over one period" in text and "checked by Koopman–Hill" in text
    assert "check" not in run(*flags[:-2], "--json").json


def test_analyse_in_hertz_and_seconds(run: Floquet) -> None:
    """A motion e^{σΩt} has halved after ln 2/(-σΩ): σ = -γ/16 and Ω = 40 rad/s give 0.03466 s for γ = 8."""
    mode = run("analyse", "--lock-number", "8", "--rotor-speed", "40", "--advance-ratio", "0", "--json").json["modes"][
        1
    ]
    assert mode["name"] == "coning"
    assert mode["time_to_half"][0] == pytest.approx(math.log(2) / 20, rel=1e-12)  # closed form, rounding only
    assert mode["frequency_hz"][0] == pytest.approx(math.sqrt(0.75) * 40 / math.tau, rel=1e-12)


def test_text_says_what_matters(run: Floquet) -> None:
    text = run("analyse", *BLADE, "--advance-ratio", "0.3").out
    assert all(word in text for word in ("STABLE", "regressing", "-0.435833 + 0.932863i", "no lock", NO_INFLOW))


def test_rotor_resolves_what_was_left_out(run: Floquet) -> None:
    answer = run("rotor", *BLADE, "--json").json
    assert answer["offset_mass_ratio"] == pytest.approx(0.075, rel=1e-15) and answer["blades"] == 4
    assert "ν_β" in run("rotor", *BLADE).out


def test_limits_are_those_of_the_library(run: Floquet) -> None:
    rows = run("validity", *BLADE, "--mode", "regressing", "--mode", "coning", "--json").json
    assert [row["mode"] for row in rows] == ["regressing", "coning"]
    assert rows[0]["limit"] == validity_limit(Rotor(lock_number=8.0, hinge_offset=0.05))
    assert rows[0]["intervals"] == [[rows[0]["limit"], "inf"]]
    text = run("validity", *BLADE).out
    assert "regressing" in text and "DRIFT" in text and NO_INFLOW in text


def test_verdict_in_words(run: Floquet) -> None:
    text = run("validity", *BLADE, "--advance-ratio", "0.45").out
    assert "NOT valid" in text and "coning: valid" in text and "lock edge" in text
    assert "use the Floquet exponents" in text and NO_INFLOW in text


def test_a_verdict_says_how_the_limit_moves_with_the_rotor(run: Floquet) -> None:
    """10 % of every parameter that is not zero, by the library's own limits of those rotors; m goes with ε."""
    options = ("--lock-number", "8", "--hinge-offset", "0.05", "--hinge-stiffness", "0.1", "--advance-ratio", "0.2",
               "--pitch-flap-coupling", "-0.2")  # fmt: skip
    rows = run("validity", *options, "--json").json
    rotor = Rotor(lock_number=8.0, hinge_offset=0.05, hinge_stiffness=0.1, pitch_flap_coupling=-0.2)
    five = {"lock_number", "hinge_offset", "offset_mass_ratio", "hinge_stiffness", "pitch_flap_coupling"}
    for row in rows:
        assert set(row["nearby_limits"]) == set(row["nearby_causes"]) == set(row["nearby_locks"]) == five
        for name, ends in row["nearby_limits"].items():
            for side, share in enumerate((0.9, 1.1)):
                other = rotor.replace(**{name: getattr(rotor, name) * share})
                assert name != "hinge_offset" or other.offset_mass_ratio == 1.5 * other.hinge_offset
                (one,) = limits(other, modes=(row["mode"],))
                assert float(ends[side]) == pytest.approx(one.limit, abs=1e-12)
                assert row["nearby_causes"][name][side] == one.cause.name
                lock = row["nearby_locks"][name][side]
                assert (lock is None and math.isnan(one.lock)) or lock == one.lock
    low, high = (f"{end:.4g}" for end in rows[0]["nearby_limits"]["lock_number"])
    text = run("validity", *options).out
    assert f"less or more of the Lock number γ the limit is at {low} or {high}" in text
    assert "the hinge offset ε (m with it)" in text and "the offset mass ratio m = e·M_β/I_β" in text
    assert "the pitch-flap coupling K₁" in text
    held = run("validity", *options, "--offset-mass-ratio", "0.08").out
    assert "the hinge offset ε" in held and "m with it" not in held
    assert "With 10 % less or more of the Lock number γ the limit stays beyond 1." in run(
        "validity", "--lock-number", "4", "--blades", "2", "--hub", "teetering", "--advance-ratio", "0.2"
    ).out  # fmt: skip


def test_a_verdict_tells_the_cause_where_it_changes(run: Floquet) -> None:
    """TP-1431's figure 8: first by a split, with 10 % less γ by drift in the lock, with more by drift."""
    shown = run("validity", str(ROTORS / "tp1431-fig8.toml"), "--advance-ratio", "0.35", "--mode", "regressing").out
    first, limit, moved = shown.splitlines()[1:4]
    assert first.startswith("  regressing: NOT valid, error 6.02 %, because both pairs are split")
    assert limit == (
        "      It fails at μ = 0.247-0.268, from 0.3032, first by a split of the simple pair; the nearest lock edge "
        "is at μ = 0.2632; the nearest split of a simple pair is at μ = 0.2002."
    )
    assert moved == (
        "      With 10 % less or more of the Lock number γ the limit is at 0.4357 (by drift within a lock at 1 "
        "per rev) or 0.3022 (by drift), of the hinge spring κ at 0.2742 (by drift) or 0.3615 "
        "(by drift within a lock at 1 per rev)."
    )


def test_a_verdict_does_not_tell_of_small_moves(run: Floquet) -> None:
    shown = run("validity", str(ROTORS / "puma.toml"), "--advance-ratio", "0.35", "--mode", "regressing").out
    assert "at 0.3432 or 0.287, of the hinge spring κ it moves by less than 0.005." in shown


def test_a_verdict_of_a_large_offset(run: Floquet) -> None:
    """10 % more of an offset of 0.95 is beyond the tip: it is left out.  0.29 does not warn of 0.319."""
    options = ("--lock-number", "8", "--exact-offset", "--advance-ratio", "0.2", "--json")
    row = run("validity", *options, "--hinge-offset", "0.95").json[0]
    assert set(row["nearby_limits"]) == {"lock_number", "offset_mass_ratio"}
    assert run("validity", "--lock-number", "8", "--hinge-offset", "0.29", "--advance-ratio", "0.2").err == ""


def test_a_verdict_of_an_offset_near_the_lost_tip(run: Floquet) -> None:
    """An offset greater by 10 % would leave no blade that lifts: then it is not moved."""
    done = run("validity", "--lock-number", "8", "--hinge-offset", "0.47", "--exact-offset", "--tip-loss", "0.5",
               "--advance-ratio", "0.3")  # fmt: skip
    assert done.status == 0 and "Lock number" in done.out


def test_what_no_double_holds_is_named(run: Floquet) -> None:
    refused(run("validity", "--lock-number", "8", "--hinge-stiffness", "1e300"), "1e+300 is beyond what doubles hold")


def test_verdict_holds_its_advice(run: Floquet) -> None:
    """The averaged model that is recommended does keep the tolerance, by the library's own comparison."""
    row = run("validity", *BLADE, "--advance-ratio", "0.45", "--mode", "regressing", "--json").json[0]
    better = compare(Rotor(lock_number=8.0, hinge_offset=0.05), 0.45, harmonics=row["harmonics"])
    assert not row["valid"] and better["regressing"].error == row["harmonics_error"] <= 0.05


def test_advice_is_the_first_averaged_model_that_holds(run: Floquet) -> None:
    """γ = 12 in its lock at ½ per rev: 2 harmonics do not hold for coning, 3 do."""
    row = run("validity", "--lock-number", "12", "--advance-ratio", "0.9", "--mode", "coning", "--json").json[0]
    errors = {m: compare(Rotor(lock_number=12.0), 0.9, harmonics=m)["coning"].error for m in (2, 3)}
    assert errors[2] > 0.05 >= errors[3] == row["harmonics_error"] and row["harmonics"] == 3


def test_no_motion_decays_with_the_mean_of_a_lock(run: Floquet) -> None:
    """Lynx at μ = 0.35, locked at 1 per rev: the regressing mode has two reals, coning is against the mean."""
    file = ROOT / "data" / "rotors" / "lynx.toml"
    regressing, coning = run("analyse", file, "--advance-ratio", "0.35", "--json").json["modes"][:2]
    assert regressing["rule"] == "REALS" and regressing["time_to_half"][0] > regressing["time_to_half"][1] > 0
    assert coning["rule"] == "MEAN" and coning["time_to_half"] == [None, None] and coning["frequency_hz"][0] > 5
    assert "no exponent of the rotor" in run("analyse", file, "--advance-ratio", "0.35").out


def test_a_verdict_against_a_mean_says_so(run: Floquet) -> None:
    """Bo 105 at μ = 1, locked: coning's 2.55 % is against the mean of two dampings that no simple mode has."""
    file = ROOT / "data" / "rotors" / "bo105.toml"
    text = run("validity", file, "--advance-ratio", "1").out
    two = "the rotor has two dampings, 0.147 and 0.489 per rev, the simple model one, 0.296"
    assert f"coning: valid against the mean of a locked pair only: {two}; error 2.55 %" in text
    assert (
        "locked at 1 per rev (from μ = " in text.splitlines()[0]
        and "and holds for coning and advancing only against the mean of a locked pair" in text
    )
    row = run("validity", file, "--advance-ratio", "1", "--mode", "coning", "--json").json[0]
    exact = compare(load_rotor(file), 1.0).stability.exponents
    assert row["rule_here"] == "MEAN" and row["dampings"] == sorted(-exact.real)
    assert 2 * row["simple_dampings"][0] == pytest.approx(0.592, abs=1e-3)
    assert "held against the pair's mean" in run("validity", file, "--mode", "coning").out


def test_a_verdict_names_the_lock_it_is_in(run: Floquet) -> None:
    lynx = ROOT / "data" / "rotors" / "lynx.toml"
    enter = lock_windows(load_rotor(lynx))[0][0]
    inside = run("validity", lynx, "--advance-ratio", "0.35").out.splitlines()
    assert f"the blade is locked at 1 per rev (from μ = {enter:.4g})" in inside[0]
    assert "for coning, advancing and differential only against the mean of a locked pair" in inside[0]
    outside = run("validity", lynx, "--advance-ratio", "0.1").out
    assert "blade is locked" not in outside and "mean of a locked pair" not in outside


@pytest.mark.parametrize(
    "name, unit", [("relative", "%"), ("frequency", "%"), ("damping", "%"), ("absolute", "per rev")]
)
def test_a_ratio_is_in_percent(run: Floquet, name: str, unit: str) -> None:
    text = run("validity", *BLADE, "--advance-ratio", "0.3", "--metric", name, "--tolerance", "0.07").out
    assert f"(tolerance {'7 %' if unit == '%' else '0.07 per rev'}" in text
    assert re.search(rf"error [0-9.e-]+ {unit}[;.]", text)


@pytest.mark.parametrize("name", ["validity", "analyse"])
def test_a_speed_in_knots(run: Floquet, name: str) -> None:
    """μ = V/(ΩR): 123 knots · 1852/3600 over 44.4 rad/s · 4.91 m."""
    file = ROOT / "data" / "rotors" / "bo105.toml"
    done = run(name, file, "--knots", "123", "--json").json
    assert (done if name == "analyse" else done[0])["advance_ratio"] == pytest.approx(0.290255, abs=5e-7)
    refused(run(name, file, "--knots", "123", "--advance-ratio", "0.3"), "--knots and --advance-ratio")
    refused(run(name, "--lock-number", "8", "--radius", "5", "--knots", "123"), "without --rotor-speed:")
    refused(run(name, file, "--knots", "nan"), "knots", "finite")
    refused(run(name, file, "--knots", "-5"), "-5 was given", "check the sign")


def test_csv_is_a_table_with_numbers(run: Floquet) -> None:
    rows = list(csv.DictReader(io.StringIO(run("analyse", *BLADE, "--advance-ratio", "0.3", "--csv").out)))
    assert [row["name"] for row in rows] == ["regressing", "coning", "advancing", "differential"]
    assert (
        float(rows[0]["error_relative"]) == compare(Rotor(lock_number=8.0, hinge_offset=0.05), 0.3)["regressing"].error
    )


def test_negative_numbers_are_values(run: Floquet) -> None:
    answer = run("rotor", "--lock-number", "8", "--pitch-flap-coupling", "-0.3", "--json")
    assert answer.json["pitch_flap_coupling"] == -0.3


def test_teetering_takes_two_blades_by_itself(run: Floquet) -> None:
    modes = run("analyse", "--lock-number", "8", "--hub", "teetering", "--advance-ratio", "0.3", "--json").json["modes"]
    assert [mode["name"] for mode in modes] == ["regressing", "advancing"]


def test_unstable_rotor_is_an_answer(run: Floquet) -> None:
    done = run("analyse", "--lock-number", "8", "--advance-ratio", "2", "--json")
    assert done.status == 0 and done.json["verdict"] == "UNSTABLE"


def test_one_warning_a_command_on_stderr(run: Floquet) -> None:
    done = run("validity", "--lock-number", "8", "--blades", "2", "--json")
    assert done.status == 0 and len(done.json) == 3
    assert done.err.count("floquet: warning: 2 blades") == 1


# Bad input.


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("analyse", "--lock-number", "0", "--advance-ratio", "0.3"), ("lock_number", "> 0")),
        (("analyse", "--lock-number", "nan", "--advance-ratio", "0.3"), ("lock_number", "finite")),
        (("analyse", "--lock-number", "8", "--hinge-offset", "1", "--advance-ratio", "0.3"), ("hinge_offset", "< 1")),
        (("analyse", "--lock-number", "8", "--advance-ratio", "-0.1"), ("advance_ratio", "between 0")),
        (("analyse", "--lock-number", "8", "--advance-ratio", "inf"), ("advance_ratio", "between 0")),
        (("analyse", "--lock-number", "8", "--advance-ratio", "0.3", "--tip-loss", "2"), ("tip_loss",)),
        (("analyse", "--lock-number", "8", "--advance-ratio", "0.3", "--harmonics", "0"), ("harmonics",)),
        (("analyse", "--advance-ratio", "0.3"), ("no rotor was given", "--lock-number 8")),
        (("analyse", "--lock-number", "8"), ("--advance-ratio",)),
        (("rotor", "--lock-number", "8", "--hub", "teetring"), ("did you mean 'teetering'",)),
        (("analyse", "--lock-nubmer", "8", "--advance-ratio", "0.3"), ("--lock-number",)),
        (("analyze",), ("analyse",)),
        (("validity", "--lock-number", "8", "--mode", "regresing"), ("did you mean 'regressing'",)),
        (("validity", "--lock-number", "8", "--tolerance", "0"), ("tolerance", "positive")),
        (("validity", "--lock-number", "8", "--mu-max", "-1"), ("mu_max",)),
        (("validity", "--lock-number", "8", "--hub", "teetering", "--mode", "coning"), ("coning", "regressing")),
        (("rotor", "missing.toml"), ("missing.toml",)),
        (("rotor", "--lock-number", "8", "--csv", "--json"), ("--json and --csv", "one of them")),
        (("rotor", "."), (".",)),
        (("validity", "missing.h5"), ("missing.h5",)),
    ],
)  # fmt: skip
def test_bad_input_is_one_sentence(run: Floquet, arguments: tuple[str, ...], words: tuple[str, ...]) -> None:
    refused(run(*arguments), *words)


# Endings.


def test_help_and_version(run: Floquet) -> None:
    assert run("--help").status == 0
    assert run("--version").out.startswith("floquet 0.")
    for name in command.commands:
        assert run(name, "--help").status == 0


def test_closed_pipe_is_silent() -> None:
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed:
        done = process("rotor", "--lock-number", "8", stdout=closed)
    assert (done.returncode, done.stderr) == (0, "")


def test_full_disk_is_one_sentence() -> None:
    full = Path("/dev/full")
    if not full.exists():  # only Linux has it
        return
    with full.open("w") as out:
        done = process("rotor", "--lock-number", "8", stdout=out)
    assert done.returncode == 1
    assert done.stderr.startswith("floquet: no space left on device") and "Traceback" not in done.stderr


def test_ascii_terminal_still_gets_an_answer() -> None:
    environment = {"PYTHONIOENCODING": "ascii", "LC_ALL": "C", "PYTHONUTF8": "0"}
    done = process("rotor", "--lock-number", "8", stdout=subprocess.PIPE, env=environment)
    assert done.returncode == 0 and "lock_number" in done.stdout


# Studies and databases.

STUDY = """
[study]
name = "small"
schema = 1
title = "Two rotors"
[rotors]
list = [
    { name = "soft", lock_number = 8.0, hinge_offset = 0.05 },
    { name = "stiff", lock_number = 5.0, hinge_stiffness = 0.2, blades = 3 },
]
[axes]
advance_ratio = { start = 0.0, stop = 0.6, count = 7 }
[compare]
tolerances = [0.05, 0.1]
mu_max = 0.6
"""


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database of 14 points and 14 limits."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "small.toml").write_text(STUDY, encoding="utf-8")
    run_study(load_study(folder / "small.toml"), folder / "small.h5")
    return folder / "small.h5"


@pytest.fixture
def database(finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A copy of it in an empty working folder, with its study beside it."""
    shutil.copy(finished, tmp_path / "small.h5")
    shutil.copy(finished.with_suffix(".toml"), tmp_path / "small.toml")
    monkeypatch.chdir(tmp_path)
    return "small.h5"


def test_run_resume_and_dry_run(run: Floquet, database: str) -> None:
    dry = run("run", "small.toml", "-o", "new.h5", "--dry-run", "--json").json
    assert (dry["designs"], dry["points"], dry["limits"]) == (2, 14, 14) and 0.0 < dry["seconds"] < 100.0
    assert not Path("new.h5").exists() and "by a sample" in run("run", "small.toml", "-o", "new.h5", "--dry-run").out
    done = run("run", "small.toml", "-o", "new.h5", "--workers", "1")
    assert done.status == 0 and done.out.startswith("new.h5: 14 points, 14 limits")
    assert run("run", "small.toml", "-o", "json.h5", "--workers", "1", "--json").json["path"] == "json.h5"
    refused(run("run", "small.toml", "-o", "new.h5"), "new.h5", "--resume")
    refused(run("run", "small.toml", "-o", "new.csv"), "new.csv ends in .csv", "name it new.h5", "floquet export")
    assert "already, finished" in run("run", "small.toml", "-o", "new.h5", "--resume").out


def test_a_dry_run_counts_what_is_there(run: Floquet, database: str) -> None:
    """Bytes are those of the file to a fifth, also of few columns; what is copied or kept is not computed again."""
    text = Path("small.toml").read_text(encoding="utf-8")
    Path("more.toml").write_text(text.replace("count = 7", "count = 2000"), encoding="utf-8")
    for options in ((), ("--columns", "exponent_1")):
        dry = run("run", "more.toml", "-o", "more.h5", "--dry-run", "--json", *options).json
        assert (dry["copied"], dry["kept"]) == (0, 0)
        assert run("run", "more.toml", "-o", "more.h5", "--workers", "1", *options).status == 0
        with open_file("more.h5") as file:
            stored = sum(file.size(table) for table in file.tables)
        assert abs(dry["bytes"] / stored - 1) < 0.2
        Path("more.h5").unlink()
    Path("grown.toml").write_text(text.replace("list = [", "list = [\n{ lock_number = 9.0 },"), encoding="utf-8")
    grown = run("run", "grown.toml", "-o", database, "--extend", "--dry-run", "--json").json
    assert (grown["points"], grown["copied"]) == (21, 14)


def test_run_stores_the_columns_that_are_named(run: Floquet, database: str) -> None:
    options = ("--workers", "1", "--columns", "error_regressing, exponent_1", "--columns", "verdict")
    assert run("run", "small.toml", "-o", "few.h5", *options).status == 0
    with open_file("few.h5") as file:
        assert file.columns("points").keys() == {*ALWAYS, "error_regressing", "exponent_1", "verdict"}
    found = run("query", "few.h5", "error_regressing > 0.05", "--json").json
    assert found and {"verdict", "lock"} & found[0].keys() == {"verdict"}
    refused(run("query", "few.h5", "isnan(lock)"), "lock is not stored", "[output] columns", "run the study again")
    refused(run("query", "few.h5", "--columns", "exponent_2"), "exponent_2 is not stored")
    refused(run("plot", "few.h5", "root-locus", "-o", "a.png"), "few.h5 was written without", "tpp_MODE_1")
    refused(run("run", "small.toml", "-o", "few.h5", "--resume"), "few.h5 holds this study without", "rule_coning")
    refused(run("run", "small.toml", "-o", "x.h5", "--columns", "eror_coning"), "did you mean 'error_coning'")
    refused(run("run", "small.toml", "-o", "x.h5", "--columns", "lock_im"), "'lock_im' is no column")
    fewer, every = (run("run", "small.toml", "-o", "x.h5", "--dry-run", "--json", *o).json for o in (options, ()))
    assert 0 < fewer["bytes"] < every["bytes"]


def test_failed_parts_are_status_3(run: Floquet, database: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def half(loaded: Any, out: str, **_: Any) -> RunReport:
        return RunReport(
            path=Path(out), points=0, limits=0, seconds=1.0, computed=1, reused=0, failed=(("part", "why"),)
        )

    monkeypatch.setattr("floquet.study.run", half)
    done = run("run", "small.toml", "-o", "new.h5")
    assert done.status == 3 and "not finished" in done.out and "floquet: part: why" in done.err


def test_interrupt_is_130_and_says_how_to_go_on(run: Floquet, database: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> RunReport:
        raise KeyboardInterrupt

    monkeypatch.setattr("floquet.study.run", interrupted)
    monkeypatch.setattr("floquet.cli.talk.abandon_output", lambda: None)  # it would close pytest's own stdout
    done = run("run", "small.toml", "-o", "new.h5")
    assert done.status == 130 and "new.h5.parts: go on with --resume" in done.err and "interrupted" in done.err


def test_progress_is_a_line_every_ten_seconds(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter([0.0, 3.0, 11.0, 12.0, 25.0])
    monkeypatch.setattr("floquet.cli.talk.time.monotonic", lambda: next(clock))
    with progress("parts", 800) as done:
        for i in range(1, 5):
            done(i, 4)
    assert capsys.readouterr().err.splitlines() == ["parts: 2 of 4, 25 points/s, 16 s left", "parts: 4 of 4"]


@pytest.mark.parametrize(
    ("seconds", "words"), [(44.6, "45 s"), (60.0, "1 min 0 s"), (200, "3 min 20 s"), (7500.0, "2 h 5 min")]
)
def test_durations(seconds: float, words: str) -> None:
    assert duration(seconds) == words


def test_progress_on_a_terminal_leaves_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with progress("parts") as done:
        done(4, 4)
    assert "parts" in terminal.getvalue()


def test_limits_are_read_from_a_database(run: Floquet, database: str) -> None:
    rows = run("validity", database, "--json").json
    assert [row["rotor"] for row in rows] == ["soft"] * 4 + ["stiff"] * 3
    expected = validity_limit(Rotor(lock_number=8.0, hinge_offset=0.05), mu_max=0.6)
    assert rows[0]["limit"] == pytest.approx(expected, rel=1e-12)
    text = run("validity", database, "--mode", "regressing").out
    assert text.splitlines()[2].split()[:2] == ["soft", "4"] and "DRIFT" in text and NO_INFLOW in text


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (("--tolerance", "0.03"), ("0.03", "0.05")),
        (("--advance-ratio", "0.3"), ("--advance-ratio", "rotor file")),
        (("--knots", "90"), ("--knots", "rotor file")),
        (("--mu-max", "3"), ("--mu-max", "rotor file")),
        (("--lock-number", "8"), ("--lock-number",)),
        (("small.h5",), ("alone",)),
    ],
)
def test_a_database_takes_no_flags_of_a_rotor(
    run: Floquet, database: str, flags: tuple[str, ...], words: tuple[str, ...]
) -> None:
    refused(run("validity", database, *flags), *words)


def test_query(run: Floquet, database: str) -> None:
    where = 'rotor == "soft" and advance_ratio > 0.25 and advance_ratio < 0.35'
    row = run(
        "query", database, where, "--columns", "advance_ratio, exponent_1", "--columns", "verdict", "--json"
    ).json[0]
    expected = compare(Rotor(lock_number=8.0, hinge_offset=0.05), row["advance_ratio"])
    assert complex(*row["exponent_1"]) == pytest.approx(
        complex(expected.stability.exponents[0]), rel=1e-15
    )  # same maps
    assert row["verdict"] == "STABLE"
    text = run("query", database, "--sort", "error_regressing", "--descending", "--limit", "3").out
    assert len(text.splitlines()) == 5
    table = list(
        csv.DictReader(io.StringIO(run("query", database, "--table", "limits", "--columns", "*", "--csv").out))
    )
    assert len(table) == 14 and table[0]["cause"] == "DRIFT" and table[0]["rotor_name"] == "soft"


def test_query_by_groups(run: Floquet, database: str) -> None:
    limits = run("query", database, "--table", "limits", "--columns", "rotor_name,mode,limit", "--json").json
    arguments = ("query", database, "--table", "limits", "--by", "rotor,mode", "--reduce", "min(limit), count")
    found = run(*arguments, "--json").json
    for row in found:
        of = [one["limit"] for one in limits if (one["rotor_name"], one["mode"]) == (row["rotor_name"], row["mode"])]
        finite = [limit for limit in of if isinstance(limit, float)]
        assert row["count"] == len(of) and row["min(limit)"] == (min(finite) if finite else of[0])
    assert len(found) == len({(one["rotor_name"], one["mode"]) for one in limits}) > 3
    table = list(csv.DictReader(io.StringIO(run(*arguments, "--csv").out)))
    assert [row["mode"] for row in table] == [row["mode"] for row in found]
    text = run("query", database, "--by", "rotor", "--reduce", "count", "--reduce", "first(verdict)").out
    assert [line.split() for line in text.splitlines()[::2]] == [
        ["rotor", "rotor_name", "count", "first(verdict)"],
        ["0", "soft", "7", "STABLE"],
    ]
    refused(run("query", database, "--by", "lock_numbr"), "by: 'lock_numbr'", "did you mean 'lock_number'?")
    refused(run("query", database, "--by", "rotor", "--columns", "lock"), "columns:", "--by and --reduce")


def test_query_of_several_files(run: Floquet, database: str) -> None:
    shutil.copy(database, "second.h5")
    shutil.copy(database, "third")
    arguments = ("query", database, "second.h5", "third")
    found = run(*arguments, "advance_ratio > 0.25", "--by", "file,rotor", "--json").json
    alone = run("query", database, "advance_ratio > 0.25", "--by", "rotor", "--json").json
    assert [row["file"] for row in found] == [name for name in (database, "second.h5", "third") for _ in alone]
    assert [(row["rotor_name"], row["count"]) for row in found] == [(r["rotor_name"], r["count"]) for r in alone] * 3
    table = list(csv.DictReader(io.StringIO(run(*arguments, "--csv").out)))
    assert len(table) == 3 * 14 and table[14]["file"] == "second.h5" and table[14]["rotor"] == "2"
    assert run("query", database, "second.h5", 'file == "second.h5" and rotor == 3').out.count("second.h5") == 7
    refused(run("query", database, "second.h5", "fil == 'second.h5'"), "did you mean 'file'?")
    refused(run("query", database, database), "is given twice")
    refused(run("query", database, "none.h5"), "none.h5")
    refused(run("query", database, "x > 1", "y > 1"), "x > 1")
    assert run("run", "small.toml", "-o", "few.h5", "--workers", "1", "--columns", "lock").status == 0
    refused(run("query", database, "few.h5"), "few.h5: its table points and that of small.h5 have different columns")


def test_the_screen_has_so_many_rows_unless_more_are_asked_for(
    run: Floquet, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("floquet.cli.queries.SCREEN", 5)
    done = run("query", database)
    assert len(done.out.splitlines()) == 2 + 5 and "the first 5 of 14 rows" in done.err and "-o" in done.err
    for options, rows in ((("--limit", "9"), 9), (("--limit", "99"), 14), (("--by", "rotor"), 2)):
        done = run("query", database, *options)
        assert (len(done.out.splitlines()), done.err) == (2 + rows, "")
    assert len(run("query", database, "--json").json) == 14


def test_files_are_one_by_whatever_name_and_options_between_rows_are_not_passed_over(
    run: Floquet, database: str
) -> None:
    Path("link.h5").symlink_to(database)
    refused(run("query", database, "link.h5"), "link.h5 is given twice")
    refused(run("query", database, f"./{database}"), "is given twice")
    at = ("--at", "advance_ratio=.1", "--at")
    refused(run("query", database, "rotor == 0", *at, "advance-ratio=.3"), "advance_ratio is given twice")
    refused(run("query", database, "rotor == 0", *at[:2], "--limit", "0"), "leave --limit out")


def test_parts_that_stand_in_the_whole_are_written_once(run: Floquet, database: str) -> None:
    for kind in ("nc", "parquet", "csv"):
        assert run("query", database, "--columns", "exponent_1_re,exponent_1", "-o", f"x.{kind}").status == 0
    assert Path("x.csv").read_text(encoding="utf-8").splitlines()[0] == "exponent_1_re,exponent_1_im"


def test_nothing_near_to_several_numbers_is_told(run: Floquet, database: str) -> None:
    done = run("query", database, "nearest(lock_number=7.9, hinge_stiffness=0.2)")
    assert done.status == 0 and "no row has all of these values" in done.err
    assert run("query", database, "nearest(lock_number=7.9, hinge_stiffness=0.01)").err == ""


def test_what_is_no_study_is_said(run: Floquet, database: str) -> None:
    refused(run("run", database, "-o", "z.h5"), "this is an HDF5 file", "TOML")
    Path("folder").mkdir()
    refused(run("run", "small.toml", "-o", "folder"), "folder is a folder", "folder/out.h5")
    percent = Path("small.toml").read_text(encoding="utf-8").replace("[0.05, 0.1]", "[5, 10]")
    Path("percent.toml").write_text(percent, encoding="utf-8")
    assert "which is 500 %: 5 % is 0.05" in run("run", "percent.toml", "-o", "p.h5", "--dry-run").err


def test_a_column_of_another_table_says_of_which(run: Floquet, database: str) -> None:
    refused(run("query", database, "limit > 0.3"), "'limit' is no column of this table", "--table limits")


def test_lines_of_csv_are_those_that_were_written() -> None:
    rows = [["name", "number"], ["cr\rx", "1"], ["lf\ny", "2"], ['a "b", c', "3"], ["crlf\r\n", ""], ["Ω", "nan"]]
    text = csv_lines(rows)
    assert list(csv.reader(io.StringIO(text, newline=""))) == rows
    assert text.startswith("name,number\n") and text.endswith("\nΩ,nan\n")


DOUBTS = [
    (("validity", "--lock-number", "8", "--tolerance", "5"), "--tolerance 5 is 500 %: 5 % is 0.05"),
    (("validity", "--lock-number", "8", "--pitch-flap-coupling", "-20"), "reaches 20: it is K₁ = tan δ₃"),
    (("validity", "--lock-number", "8", "--rotor-speed", "300", "--radius", "5", "--knots", "150"),
     "the tip speed ΩR is 1500 m/s, faster than sound: Ω is in rad/s"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "sentence"), DOUBTS)
def test_units_that_are_seldom_meant_are_told(run: Floquet, arguments: tuple[str, ...], sentence: str) -> None:
    done = run(*arguments)
    assert done.status == 0 and done.out and done.err.count(sentence) == 1 and done.err.startswith("floquet: warning: ")
    quiet = run("validity", "--lock-number", "8", "--rotor-speed", "44", "--radius", "5", "--knots", "150")
    assert quiet.status == 0 and not quiet.err


def test_a_study_tells_of_degrees(run: Floquet) -> None:
    text = '[study]\nname = "s"\nschema = 1\n[rotors.grid]\nlock_number = 8.0\npitch_flap_coupling = [-20.0, 0.0]\n'
    Path("steep.toml").write_text(f"{text}[axes]\nadvance_ratio = [0.1, 0.2]\n", encoding="utf-8")
    assert "|pitch_flap_coupling| reaches 20: " in run("run", "steep.toml", "-o", "s.h5", "--dry-run").err


NEARLY = [
    (("--sort", "advance_ratio desc"), "an order goes up, and with descending down"),
    (("error_regressing",), "in a shell the whole expression stands in quotes"),
    (("error_regressing > 5%",), "5 % is 0.05"),
    (("--by", "lock", "--reduce", "lock_number, advance_ratio at min(lock)"), "as in lock_number at min(limit)"),
    (("--at", "mu=0.3"), "the column is advance_ratio"),
    (("--at", "gamma=7", "--at", "advance_ratio=0.3"), "the column is lock_number"),
]


@pytest.mark.parametrize(("arguments", "sentence"), NEARLY)
def test_what_is_nearly_right_is_told_how(
    run: Floquet, database: str, arguments: tuple[str, ...], sentence: str
) -> None:
    refused(run("query", database, *arguments), sentence)


def test_no_row_is_told(run: Floquet, database: str) -> None:
    done = run("query", database, "advance_ratio > 5")
    assert done.status == 0 and done.err.startswith("floquet: no row; ")


def test_empty_answer_is_an_answer(run: Floquet, database: str) -> None:
    done = run("query", database, "advance_ratio > 5", "--json")
    assert (done.status, done.json) == (0, [])
    assert run("query", database, "advance_ratio > 5").status == 0
    assert run("query", database, "advance_ratio > 5", "--csv").out.startswith("rotor,")


def test_verify_export_plot_merge_pack(run: Floquet, database: str) -> None:
    said = run("verify", database, "--sample", "3").out
    again = [f"3 rows of {table} computed again: 3 equal" for table in ("points", "limits")]
    assert said.startswith(f"{database}: ") and "values in" in said and said.endswith("; ".join(again) + "\n")
    assert "wrote limits.csv" in run("export", database, "-o", "limits.csv", "--table", "limits").err
    assert len(Path("limits.csv").read_text(encoding="utf-8").splitlines()) == 15
    assert "wrote locus.svg" in run("plot", database, "root-locus", "-o", "locus.svg", "--rotor", "stiff").err
    Path("other.toml").write_text(STUDY.replace("5.0", "6.0").replace("8.0", "8.5"), encoding="utf-8")
    assert run("run", "other.toml", "-o", "other.h5", "--workers", "1").status == 0
    assert run("merge", database, "other.h5", "-o", "both.h5").out == "both.h5: 28 rows of points, 28 rows of limits\n"
    assert run("verify", "both.h5").status == 0


def test_no_columns_and_no_name_are_refused(run: Floquet, database: str) -> None:
    for arguments in (("run", "small.toml", "-o", "x.h5"), ("query", database)):
        refused(run(*arguments, "--columns", ""), "--columns is empty", "'*' for all")
    for arguments in (("analyse", "", "--advance-ratio", "0.3"), ("run", "", "-o", "x.h5"), ("query", "")):
        refused(run(*arguments), "an empty name was given")
    assert not Path("x.h5").exists()


def test_a_setting_that_means_nothing_is_refused(run: Floquet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", "abc")
    refused(run("rotor", "--lock-number", "8"), "FLOQUET_THREADS: 'abc' in the environment is no number of threads")


def test_pack_makes_what_run_makes(run: Floquet, database: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("floquet.study.running.remove_parts", lambda *_: None)
    assert run("run", "small.toml", "-o", "new.h5", "--workers", "1").status == 0
    refused(run("pack", "new.h5.parts"), "new.h5 is there already")
    Path("new.h5").unlink()
    assert run("pack", "new.h5.parts").out == "new.h5: 14 rows of points, 14 rows of limits\n"
    assert data_digest("new.h5") == data_digest(database)
    refused(run("pack", database, "-o", "other.h5"), "not the folder of a study")


def test_verify_finds_damage(run: Floquet, database: str) -> None:
    """A value changed behind the library's back: status 1, and the place on stdout."""
    with h5py.File(database, "r+") as file:
        file["points/error_coning"][3] += 1e-9
    done = run("verify", database)
    assert done.status == 1 and "points/error_coning" in done.out and "do not match their digests" in done.err


def test_studies_come_with_the_package(run: Floquet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert run("study").out.startswith("validity: ")
    refused(run("study", "validty"), "did you mean 'validity'")
    (tmp_path / "small.toml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr("floquet.cli.studies.studies_folder", lambda: tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run("study", "small", "--workers", "1").out.startswith("small.h5: 14 points")
    assert run("study", "--all", "--resume").status == 0


NUMBERED = '''"""Figure 2. One."""
from floquet.exhibits import Exhibit

def exhibit():
    return Exhibit(title="Figure 2. One", caption="What it shows.", table=[{"a": 1.5}], numbers={"one": 1.25})
'''


def test_numbered_studies_are_written_with_their_page(
    run: Floquet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Listed without being run; one alone says its numbers; --all puts everything into one folder; 3 if one fails."""
    known = run("study").out.splitlines()
    assert [line.split(":")[0] for line in known[:3]] == ["validity", "table-1", "table-2"]
    assert any(line.startswith("figure-17: Figure 17. Hinge offset") for line in known)
    refused(run("study", "figure-18"), "did you mean 'figure-")
    folder = tmp_path / "studies"
    (folder / "tp1431").mkdir(parents=True)
    (folder / "small.toml").write_text(STUDY, encoding="utf-8")
    (folder / "tp1431" / "figure-2.py").write_text(NUMBERED, encoding="utf-8")
    monkeypatch.setattr("floquet.cli.studies.studies_folder", lambda: folder)
    monkeypatch.chdir(tmp_path)
    done = run("study", "figure-2")
    assert done.status == 0 and "What it shows." in done.out and re.search(r"one +1\.25", done.out)
    assert sorted(os.listdir("results/tp1431")) == ["figure-2.csv", "figure-2.json", "figure-2.md", "index.html"]
    refused(run("study", "figure-2", "--all"), "one study and for every study")
    refused(run("study", "figure-1"), "figures 1 and 2 of the report are sketches")
    for target in ("out.png", "index.h5"):
        refused(run("study", "figure-2", "-o", target), "is no folder")
    Path("a-file").write_text("", encoding="utf-8")
    refused(run("study", "figure-2", "-o", "a-file"), "is no folder")
    refused(run("study", "figure-2", "--workers", "-3"), "workers")
    Path("results/tp1431/figure-2.json").write_text("{", encoding="utf-8")  # a damaged neighbour costs only itself
    (folder / "tp1431" / "figure-3.py").write_text(NUMBERED.replace("Figure 2", "Figure 3"), encoding="utf-8")
    assert run("study", "figure-3").status == 0
    page = Path("results/tp1431/index.html").read_text(encoding="utf-8")
    assert "make it again with floquet study figure-2" in page and "Figure 3. One" in page
    (folder / "tp1431" / "figure-3.py").unlink()
    done = run("study", "--all", "-o", "results/all", "--workers", "1")
    assert done.status == 0 and "1 of 1 numbered studies" in done.out and "small.h5: 14 points" in done.out
    assert {"index.html", "figure-2.csv", "small.h5"} <= set(os.listdir("results/all"))
    refused(run("study", "--all", "-o", "results/all"), "small.h5 is there already")
    (folder / "tp1431" / "table-1.py").write_text("1 / 0", encoding="utf-8")
    done = run("study", "--all", "-o", "results/all", "--resume", "--workers", "1")
    assert done.status == 3 and done.err == "floquet: table-1: ZeroDivisionError: division by zero\n"
    (folder / "tp1431" / "table-1.py").write_text("def", encoding="utf-8")
    assert "table-1: it cannot be read: invalid syntax" in run("study").out
    assert run("study", "small", "-o", "results").out.startswith("results/small.h5: 14 points")


@pytest.mark.parametrize("name", ["query", "verify", "plot", "export", "validity"])
@pytest.mark.parametrize("kind", ["missing", "folder", "text", "truncated", "foreign"])
def test_no_database_is_one_sentence(run: Floquet, database: str, name: str, kind: str) -> None:
    path = Path(f"{kind}.h5")
    if kind == "folder":
        path.mkdir()
    elif kind == "foreign":
        h5py.File(path, "w").close()
    elif kind != "missing":
        path.write_bytes(b"hello" if kind == "text" else Path(database).read_bytes()[:20_000])
    rest = {"plot": ("root-locus", "-o", "a.png"), "export": ("-o", "a.csv")}.get(name, ())
    found = run(name, path, *rest)
    if (name, kind) == ("verify", "truncated"):  # damage is what it looks for
        assert (found.status, found.out) == (1, "the whole file\n") and "damaged or was cut short" in found.err
    else:
        refused(found, f"{kind}.h5")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("query", "small.h5", "advance_rtio > 0.3"), ("did you mean 'advance_ratio'",)),
        (("query", "small.h5", "__import__('os').system('id')"), ("column",)),
        (("query", "small.h5", "(" * 10_000 + "1" + ")" * 10_000), ("10000",)),
        (("query", "small.h5", "--table", "pionts"), ("did you mean 'points'",)),
        (("query", "small.h5", "--limit", "-1"), ("limit",)),
        (("plot", "small.h5", "root-locs", "-o", "a.png"), ("did you mean 'root-locus'",)),
        (("plot", "small.h5", "root-locus", "-o", "a.xyz"), (".png",)),
        (("plot", "small.h5", "root-locus", "-o", "a.png", "--dpi", "nan"), ("20 to 2400 dots per inch",)),
        (("export", "small.h5", "-o", "a.xls"), (".csv",)),
        (("run", "small.toml", "-o", "new.h5", "--workers", "0"), ("workers",)),
        (("run", "missing.toml", "-o", "new.h5"), ("missing.toml",)),
        (("run", "small.h5", "-o", "new.h5"), ("small.h5",)),
        (("pack", "nowhere"), ("nowhere",)),
        (("merge", "-o", "both.h5"), ("FILES",)),
        (("verify", "small.h5", "--sample", "-1"), ("0 or more",)),
        (("study", "-o", "a.h5"), ("NAME",)),
    ],
)
def test_bad_questions_are_one_sentence(
    run: Floquet, database: str, arguments: tuple[str, ...], words: tuple[str, ...]
) -> None:
    refused(run(*arguments), *words)


def test_no_room_for_a_file_is_status_1(run: Floquet, database: str) -> None:
    refused(run("run", "small.toml", "-o", "nowhere/new.h5"), "nowhere/new.h5", status=1)
    refused(run("plot", database, "root-locus", "-o", "nowhere/a.png"), "nowhere/a.png", status=1)


def test_all_problems_of_a_file_have_their_lines(run: Floquet, tmp_path: Path) -> None:
    path = tmp_path / "rotor.toml"
    path.write_text('[rotor]\nlock_number = 8.0\nhinge_ofset = 0.05\nblades = "4"\n', encoding="utf-8")
    done = run("rotor", path)
    refused(done, f"{path}:3: rotor.hinge_ofset", "did you mean 'hinge_offset'", f"{path}:4: rotor.blades")
    assert all(line.startswith("floquet: ") for line in done.err.splitlines())


def test_flags_override_the_file(run: Floquet) -> None:
    file = ROOT / "data" / "rotors" / "bo105.toml"
    answer = run("rotor", file, "--lock-number", "6", "--json").json
    assert answer["name"] == "Bo 105" and answer["lock_number"] == 6.0 and "lock_number" not in answer["sources"]
    assert "Padfield" in run("rotor", file).out


def test_real_rotor_in_knots(run: Floquet) -> None:
    """Bo 105: 0.35 · 44.4 rad/s · 4.91 m = 76.3 m/s = 148 knots."""
    text = run("validity", ROOT / "data" / "rotors" / "bo105.toml", "--advance-ratio", "0.35").out
    assert "148 knots" in text
