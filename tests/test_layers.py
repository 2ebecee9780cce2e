"""The house's order: nothing imports a later room, each heavy library has one home, ``floquet --help`` loads none."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import floquet

PACKAGE = Path(floquet.__file__).parent
ORDER = (
    "errors", "environment", "plain", "tomlfile", "rotorfile", "rotor", "verdict", "tape", "periodic", "models",
    "kernels", "collocation", "period_map", "passage", "koopman", "certify", "exponents", "modes", "comparison",
    "sensitivity", "tracking", "validity", "response", "decoupling", "sweep", "families", "chunks", "store",
    "studyfile", "cluster", "study", "recomputing", "checking", "export", "query", "plot", "report", "judgement",
    "exhibits", "cli", "__main__",
)  # fmt: skip
HOMES = {
    "h5py": "store", "matplotlib": "plot", "click": "cli", "rich": "cli", "numba": "kernels", "lark": "query",
    "tomlkit": "tomlfile", "flint": "certify", "distributed": "cluster", "dask": "cluster",
}  # fmt: skip
HEAVY = ("numba", "flint", "scipy", "matplotlib", "h5py", "numpy", "pydantic", "lark", "rich", "distributed")
FILES = sorted(PACKAGE.rglob("*.py"))


def room(path: Path) -> str:
    """The room a file belongs to: a module's name, or the name of the package it is in."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(path: Path) -> Iterator[tuple[int, str]]:
    """(line, dotted module) of every import in a file, wherever it stands; relative ones made absolute."""
    here = ("floquet", *path.relative_to(PACKAGE).parent.parts)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(here[: len(here) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module or "") if part)
            yield node.lineno, module
            yield from ((node.lineno, f"{module}.{alias.name}") for alias in node.names if module == "floquet")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_nothing_imports_a_later_room(path: Path) -> None:
    here = room(path)
    if here == "__init__":
        return
    assert here in ORDER, f"{path.name} has no place in the order of the house"
    for line, module in imported(path):
        parts = module.split(".")
        if parts[0] == "floquet" and len(parts) > 1 and parts[1] in ORDER:
            assert ORDER.index(parts[1]) <= ORDER.index(here), f"{path.name}:{line} imports the later room {parts[1]}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_heavy_libraries_have_one_home(path: Path) -> None:
    for line, module in imported(path):
        home = HOMES.get(module.split(".")[0])
        assert home in (None, room(path)), f"{path.name}:{line} imports {module}, whose home is {home}"


def test_package_itself_imports_rooms_only_for_the_type_checker() -> None:
    """``import floquet`` loads no room, whichever names it promises."""
    tree = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    outside = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    assert not [node for node in outside if isinstance(node, ast.ImportFrom) and "floquet" in (node.module or "")]


@pytest.mark.parametrize("statement", ["import floquet", "from floquet.cli import main; main(['--help'])"])
def test_help_loads_nothing_heavy(statement: str) -> None:
    report = f"import sys; print('LOADED', *sorted(set(sys.modules) & set({HEAVY!r})))"
    code = f"try:\n    {statement}\nexcept SystemExit as end:\n    assert not end.code, end.code\n{report}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LOADED"


def test_queries_load_no_scipy() -> None:
    """Which is 40 MB, and half of the time to a first answer."""
    code = "import sys; import floquet.query, floquet.store; assert not set(sys.modules) & {'scipy', 'numba', 'pandas'}"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_public_names_resolve_and_the_sweep_function_is_not_hidden_by_its_room() -> None:
    code = (
        "import floquet.sweep, floquet\n"
        "assert all(callable(getattr(floquet, name)) for name in floquet.__all__)\n"
        "from floquet import sweep\n"
        "assert sweep.__module__ == 'floquet.sweep' and not hasattr(sweep, '__file__')\n"
        "assert set(floquet.__all__) <= set(dir(floquet))\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_unknown_public_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = floquet.no_such_name
