"""The documentation is true: examples run and give what they say, links lead somewhere, nothing public is left out.

A ``python`` block runs as doctests, or as a plain script if it has no prompts; the blocks of a page share their names.
In a ``console`` block every ``$ floquet …`` line runs, and what follows is what it prints (``...`` is anything).
"""

from __future__ import annotations

import doctest
import math
import os
import re
import shlex
import subprocess
import sys
from enum import IntEnum
from pathlib import Path

import pytest

import floquet
from floquet.cli import command
from floquet.comparison import Cause, Metric, Rule
from floquet.exponents import Verdict
from floquet.rotorfile import PhysicalTable, RotorTable
from floquet.store import ALWAYS, POINTS
from floquet.studyfile import AxesTable, CompareTable, OutputTable, RotorsTable, StudyTable, load_study
from floquet.tomlfile import Table

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TEXT = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
FENCE = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page: Path, language: str) -> list[str]:
    found = FENCE.findall(page.read_text(encoding="utf-8"))
    return [body for word, body in found if word == language]


def with_blocks(language: str) -> list[Path]:
    return [page for page in PAGES if blocks(page, language)]


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that looks like the checkout, where examples may write."""
    for name in ("data", "studies"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "results").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", with_blocks("python"), ids=named)
def test_python_examples(page: Path, checkout: Path) -> None:
    names: dict[str, object] = {"__name__": "__main__"}
    runner = doctest.DocTestRunner(optionflags=OPTIONS, verbose=False)
    for i, body in enumerate(blocks(page, "python")):
        if ">>>" not in body:
            exec(compile(body, f"{page.name} example {i}", "exec"), names)
            continue
        test = doctest.DocTestParser().get_doctest(body, names, f"{page.name}[{i}]", str(page), 0)
        output: list[str] = []
        failed, _ = runner.run(test, out=output.append, clear_globs=False)
        names = test.globs
        assert not failed, "".join(output)


@pytest.mark.parametrize("page", with_blocks("console"), ids=named)
def test_console_examples(page: Path, checkout: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    for body in blocks(page, "console"):
        for example in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
            line, _, expected = example.partition("\n")
            words = shlex.split(line)
            assert words[0] == "floquet", f"a console example runs floquet, not {words[0]}: use a sh block"
            done = subprocess.run(
                [sys.executable, "-m", *words], env=environment, capture_output=True, text=True, encoding="utf-8"
            )
            assert done.returncode == 0, f"{line}: {done.stderr}"
            same = doctest.OutputChecker().check_output(expected.rstrip() + "\n", done.stdout.rstrip() + "\n", OPTIONS)
            assert same or not expected.strip(), f"{line} printed\n{done.stdout}\nand not\n{expected}"


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_lead_somewhere(page: Path) -> None:
    missing = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert not missing


def test_files_are_as_the_page_shows_them(checkout: Path) -> None:
    page = ROOT / "docs" / "files.md"
    rotor_text, study_text = blocks(page, "toml")
    (checkout / "rotor.toml").write_text(rotor_text, encoding="utf-8")
    (checkout / "study.toml").write_text(study_text, encoding="utf-8")
    rotor, study = floquet.load_rotor("rotor.toml"), load_study("study.toml")
    real = floquet.load_rotor(ROOT / "data" / "rotors" / "bo105.toml")
    assert (rotor.name, rotor.flap_frequency, rotor.lock_number) == ("Bo 105", real.flap_frequency, real.lock_number)
    assert set(rotor.sources) == {"radius", "flap_inertia"}
    assert sum(math.prod(one.shape) for one in study.plan.rotors) == 36 and len(study.plan.advance_ratio) == 101
    assert study.plan.physics.tip_loss == 0.97 and len(study.plan.tolerances) == 3
    assert len(ALWAYS) < len(study.columns) < len(POINTS) and "lock" in study.columns


def test_columns_that_are_always_stored_stand_on_the_page() -> None:
    text = (ROOT / "docs" / "files.md").read_text(encoding="utf-8").split("**Always there**")[1].split("\n* ")[0]
    assert set(re.findall(r"`(\w+)`", text)) == set(ALWAYS)


@pytest.mark.parametrize("table", [RotorTable, PhysicalTable, StudyTable, RotorsTable, AxesTable, CompareTable,
                                   OutputTable])  # fmt: skip
def test_every_key_of_a_file_stands_in_a_table(table: type[Table]) -> None:
    rows = [line for line in (ROOT / "docs" / "files.md").read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    first = re.findall(r"`(?:\w+\.)?(\w+)`", "\n".join(row.split("|")[1] for row in rows))
    keys = {field.alias or name for name, field in table.model_fields.items()} - {"physical", "sources"}
    assert keys and keys <= set(first)


@pytest.mark.parametrize("column, kind", [("verdict", Verdict), ("cause", Cause), ("rule", Rule), ("metric", Metric)])
def test_numbers_for_words_are_those_of_the_code(column: str, kind: type[IntEnum]) -> None:
    text = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")
    found = re.findall(rf"^\| `{column}` \| (-?\d) \| (\w+) \| [^|]+ \|$", text, re.MULTILINE)
    assert {int(number): word for number, word in found} == {int(one): one.name for one in kind}


@pytest.mark.parametrize("name", ["run", "rotor"])
def test_help_leads_to_the_page_of_files(name: str) -> None:
    assert "docs/files.md" in str(command.commands[name].help)


@pytest.mark.parametrize("name", floquet.__all__)
def test_public_name_is_documented(name: str) -> None:
    assert re.search(rf"\b{name}\b", TEXT), f"{name} stands on no page"
    assert getattr(floquet, name).__doc__


@pytest.mark.parametrize("name", sorted(command.commands))
def test_command_is_documented(name: str) -> None:
    assert f"floquet {name}" in TEXT, f"floquet {name} stands on no page"
    assert command.commands[name].help


def test_changelog_and_citation_name_this_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(rf"^## {re.escape(floquet.__version__)}\b", changelog, re.MULTILINE)
    assert f"\nversion: {floquet.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
