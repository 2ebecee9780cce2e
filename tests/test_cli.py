"""The command line: every answer in three dresses, every bad input one sentence and its exit status, no traceback."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from floquet import Rotor, compare, validity_limit
from floquet.cli import ROTOR_FLAGS, command, main
from floquet.report import NO_INFLOW

ROOT = Path(__file__).resolve().parent.parent
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


def test_verdict_holds_its_advice(run: Floquet) -> None:
    """The averaged model that is recommended does keep the tolerance, by the library's own comparison."""
    row = run("validity", *BLADE, "--advance-ratio", "0.45", "--mode", "regressing", "--json").json[0]
    better = compare(Rotor(lock_number=8.0, hinge_offset=0.05), 0.45, harmonics=row["harmonics"])
    assert not row["valid"] and better["regressing"].error == row["harmonics_error"] <= 0.05


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
    assert done.err.count("floquet: warning: two blades") == 1


# Bad input.


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("analyse", "--lock-number", "0", "--advance-ratio", "0.3"), ("lock_number", "> 0")),
        (("analyse", "--lock-number", "nan", "--advance-ratio", "0.3"), ("lock_number", "finite")),
        (("analyse", "--lock-number", "8", "--hinge-offset", "1", "--advance-ratio", "0.3"), ("hinge_offset", "< 1")),
        (("analyse", "--lock-number", "8", "--advance-ratio", "-0.1"), ("advance_ratio", "≥ 0")),
        (("analyse", "--lock-number", "8", "--advance-ratio", "inf"), ("advance_ratio", "finite")),
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
