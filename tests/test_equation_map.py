"""docs/equation-map.md: every number of the report is there once, and every function, test and study named exists."""

from __future__ import annotations

import ast
import importlib
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from floquet.exhibits import find

ROOT = Path(__file__).resolve().parent.parent
ROWS = [
    [cell.strip() for cell in line.split("|")[1:-1]]
    for line in (ROOT / "docs" / "equation-map.md").read_text(encoding="utf-8").splitlines()
    if re.match(r"\| (\(|Table \d|Figure \d)", line)
]
EQUATIONS = {
    *(f"({n})" for n in range(1, 29) if n not in (10, 13, 22)),
    "(10a)", "(10b)", "(13a)", "(13b)", "(13c)", "(22a)", "(22b)",
    *(f"(A{n})" for n in range(1, 6)), *(f"(B{n})" for n in range(1, 7)), *(f"(C{n})" for n in range(1, 5)),
}  # fmt: skip
EXPECTED = EQUATIONS | {f"Table {n}" for n in range(1, 5)} | {f"Figure {n}" for n in range(1, 18)}
SKETCHES = ("Figure 1", "Figure 2")
STUDIES = find(ROOT / "studies" / "tp1431")


@cache
def defined_in(file: str) -> set[str]:
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def named(path: str) -> Any:
    """What a dotted name is; a function of a package comes before a module of the same name."""
    parent, _, name = path.rpartition(".")
    module = importlib.import_module(parent)
    return getattr(module, name)


def test_every_number_of_the_report_is_there_once() -> None:
    numbers = [row[0] for row in ROWS]
    assert sorted(numbers) == sorted(EXPECTED)


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_function_test_and_study_exist(row: list[str]) -> None:
    number, what, function, test, study = row
    assert what
    assert callable(named(function.strip("`")))
    if number not in SKETCHES:
        file, _, name = test.strip("`").partition("::")
        assert name in defined_in(file), test
    for one in study.split(", "):
        assert one == "-" or one in STUDIES, one
    if number.startswith(("Table", "Figure")) and number not in SKETCHES:
        assert study == number.lower().replace(" ", "-")


def test_a_study_names_the_equations_the_map_gives_it() -> None:
    """Of tables and figures: what the map lists under a study stands in the study file."""
    listed: dict[str, set[str]] = {}
    for number, _, _, _, study in ROWS:
        for one in study.split(", "):
            if number.startswith("("):
                listed.setdefault(one, set()).add(number.strip("()"))
    for name, numbers in listed.items():
        if name != "-":
            text = STUDIES[name].read_text(encoding="utf-8")
            for shared in re.findall(r"from \.(_\w+) import", text):
                text += STUDIES[name].with_name(f"{shared}.py").read_text(encoding="utf-8")
            missing = {n for n in numbers if f'"{n}"' not in text}
            assert not missing, f"{name} does not name {missing}"
