"""Numbered studies: a question answered by one table, one figure and a few numbers, and the page that shows them all.

A study is a short Python file, ``table-1.py``, ``figure-3.py``, ``question-2.py`` …, whose docstring begins with its
title and whose ``exhibit()`` returns an :class:`Exhibit`; what several share stands beside them (``from ._steps import
…``).  Made in a folder, it becomes::

    NAME.png                the figure
    NAME.csv, NAME.md       the table, with all digits and as people read it
    NAME.json               title, caption, equations and numbers
    index.html              all exhibits of the folder in order

Tables and figures carry the numbers of NASA TP-1431; questions are asked here.  On one
machine the same study makes the same bytes.
"""

from __future__ import annotations

import ast
import hashlib
import html
import importlib.util
import json
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from floquet import __version__, report
from floquet.errors import FloquetError, InputError, StorageError
from floquet.store import atomic, write_failure
from floquet.study import processes

__all__ = ["Exhibit", "find", "load", "make", "make_all", "module", "read", "title", "write_index"]

NAME = re.compile(r"(table|figure|question)-(\d+)")
KINDS = ("table", "figure", "question")
KEYS = {"title", "caption", "equations", "numbers", "text", "figure", "rows"}
DPI = 200.0
LONG = 14  # rows of a table from which the page shows it on request


@dataclass(frozen=True, eq=False, kw_only=True)
class Exhibit:
    """What a numbered study shows.

    Attributes
    ----------
    title : str
        The report's caption, or the question.
    caption : str
        What is shown, what was chosen here because the report does not say, and what comes out.
    equations : tuple of str
        Numbers of the report's equations that are used.
    table : records
        Names → values, a record a row; complex numbers take two columns of the CSV file.
    numbers : name → number
        What a reader takes home; a test holds each against another source.
    text : str
        Lines of fixed width, such as matrices in letters.
    figure : matplotlib.figure.Figure
        None where a table says it all.
    """

    title: str
    caption: str
    equations: tuple[str, ...] = ()
    table: Sequence[Mapping[str, Any]] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    text: str = ""
    figure: Any = None


# ---------------------------------------------------------------------- studies
def find(folder: Path) -> dict[str, Path]:
    """The numbered studies in a folder by name: tables, figures, questions, each in the order of their numbers."""
    found = {path.stem: path for path in folder.glob("*.py") if NAME.fullmatch(path.stem)}
    return {name: found[name] for name in sorted(found, key=_place)}


def _place(name: str) -> tuple[int, int]:
    match = NAME.fullmatch(name)
    assert match is not None
    return KINDS.index(match[1]), int(match[2])


def title(path: Path) -> str:
    """The first line of a study's docstring, without running it."""
    try:
        text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or path.stem
    except (SyntaxError, ValueError) as error:
        return f"it cannot be read: {error}"
    return text.splitlines()[0].rstrip(".")


def module(path: Path) -> ModuleType:
    """The study as a module of a package made of its folder, so that studies share code: ``from ._steps import …``."""
    folder = path.resolve().parent
    package = f"floquet_studies_{hashlib.blake2b(str(folder).encode(), digest_size=8).hexdigest()}"
    if package not in sys.modules:
        sys.modules[package] = ModuleType(package)
        sys.modules[package].__path__ = [str(folder)]
    spec = importlib.util.spec_from_file_location(f"{package}.{path.stem.replace('-', '_')}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise InputError(f"{path} is no study: it is not a Python file")
    made, before = importlib.util.module_from_spec(spec), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # an installed folder is not ours to write in
    try:
        spec.loader.exec_module(made)
    finally:
        sys.dont_write_bytecode = before
    return made


def load(path: Path) -> Exhibit:
    """Run a study."""
    study = module(path)
    found = study.exhibit() if hasattr(study, "exhibit") else None
    if not isinstance(found, Exhibit):
        raise InputError(f"{path} is no study: it needs a function exhibit() that returns an Exhibit")
    return found


# ---------------------------------------------------------------------- making
def make(path: Path, folder: Path) -> Exhibit:
    """Run a study and write its files into a folder."""
    shown = load(path)
    _make_folder(folder)
    name = path.stem
    if shown.figure is not None:
        from floquet.plot import write_figure

        write_figure(shown.figure, folder / f"{name}.png", DPI)
    if shown.table:
        _write(folder / f"{name}.csv", report.as_csv(shown.table))
        parts = [f"# {_numbered(name, shown.title)}", *([f"```\n{shown.text}\n```"] if shown.text else [])]
        _write(folder / f"{name}.md", "\n\n".join([*parts, report.markdown(shown.table)]))
    about = {
        "title": _numbered(name, shown.title),
        "caption": shown.caption,
        "equations": shown.equations,
        "numbers": shown.numbers,
        "text": shown.text,
        "figure": shown.figure is not None,
        "rows": len(shown.table),
    }
    _write(folder / f"{name}.json", report.as_json(about))
    return shown


def _numbered(name: str, heading: str) -> str:
    """A title with its number, which captions of the report begin with and questions do not."""
    kind, number = name.split("-")
    begin = f"{kind.capitalize()} {number}. "
    return heading if heading.startswith(begin) else begin + heading


def make_all(
    paths: Iterable[Path], folder: Path, *, workers: int = 1, progress: Callable[[int, int], None] | None = None
) -> list[tuple[str, str]]:
    """Make many studies, in several processes, and the page; gives the name and the reason of every one that failed."""
    paths = list(paths)
    _make_folder(folder)
    failed: list[tuple[str, str]] = []

    def settle(done: int, path: Path, error: BaseException | None) -> None:
        if isinstance(error, StorageError):
            raise error
        if error is not None:
            failed.append((path.stem, str(error) if isinstance(error, FloquetError) else repr(error)))
        if progress is not None:
            progress(done, len(paths))

    try:
        if workers <= 1 or len(paths) < 2:
            for done, path in enumerate(paths, 1):
                settle(done, path, _tried(path, folder))
        else:
            with processes(min(workers, len(paths))) as workforce:
                asked = {workforce.submit(_tried, path, folder): path for path in reversed(paths)}  # the longest first
                for done, future in enumerate(as_completed(asked), 1):
                    settle(done, asked[future], future.exception() or future.result())
    finally:  # also of a run that is interrupted
        write_index(folder)
    return sorted(failed, key=lambda one: _place(one[0]))


def _tried(path: Path, folder: Path) -> Exception | None:
    """What went wrong in making a study; a full disk ends the run."""
    try:
        make(path, folder)
    except Exception as error:  # one study's fault must not cost the others
        return error if isinstance(error, FloquetError) else InputError(f"{type(error).__name__}: {error}")
    return None


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(folder, write_failure(error)) from error


def _write(path: Path, text: str) -> None:
    with atomic(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8", newline="\n")


# ---------------------------------------------------------------------- the page
STYLE = """\
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
pre { font-size: .74rem; line-height: 1.35; } h1 { line-height: 1.2; }
h2 { margin-top: 4rem; border-top: 1px solid #ccc; padding-top: 1rem; font-size: 1.2rem; }
nav { columns: 2; font-size: .9rem; } nav a { display: block; break-inside: avoid; color: inherit; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: .85rem; } td, th { padding: .15rem .6rem; border-bottom: 1px solid #ddd; }
td { white-space: nowrap; } td.number { text-align: right; font-variant-numeric: tabular-nums; }
th { text-align: left; vertical-align: bottom; } .wide { overflow-x: auto; }
.small { font-size: .85rem; color: #555; }"""
INTRODUCTION = """\
Tables and figures of R. T. N. Chen, <em>Effects of Primary Rotor Parameters on Flapping Dynamics</em>, NASA TP-1431
(1979), computed anew, with the exact Floquet exponents beside the tip-path plane where the original could not show
them, and questions the report left open. The copy at hand was a text without the plots: families of parameters are
chosen here, as each caption says, and no curve has been compared with a printed one. Figures 1 and 2 are sketches.
Rates are per rev, in units of the rotor speed Ω. Errata of the report, its equations by number and the answer to its
question are in docs/errata-tp1431.md, docs/equation-map.md and docs/validity.md of the source."""


def write_index(folder: Path) -> Path:
    """Write the page of all exhibits that a folder holds."""
    found: dict[str, dict[str, Any]] = {}
    lost: list[str] = []
    for name in sorted((path.stem for path in folder.glob("*.json") if NAME.fullmatch(path.stem)), key=_place):
        try:
            found[name] = read(folder, name)
        except InputError as error:
            lost.append(f'<p class="small">{_escaped(str(error))}</p>')
    links = "\n".join(f'<a href="#{name}">{_escaped(about["title"])}</a>' for name, about in found.items())
    parts = "\n".join([*lost, *(_section(folder, name, about) for name, about in found.items())])
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>NASA TP-1431, computed anew</title>\n<style>\n{STYLE}\n</style>\n</head>\n<body>\n"
        f"<h1>NASA TP-1431, computed anew</h1>\n<p>{INTRODUCTION} {_escaped(report.NO_INFLOW)}</p>\n"
        f"<nav>\n{links}\n</nav>\n{parts}\n"
        f'<p class="small">floquet {__version__}</p>\n</body>\n</html>'
    )
    _write(folder / "index.html", page)
    return folder / "index.html"


def read(folder: Path, name: str) -> dict[str, Any]:
    """What stands in a folder about an exhibit: title, caption, equations, numbers."""
    path = folder / f"{name}.json"
    try:
        about: dict[str, Any] = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        about = {}
    if not KEYS <= set(about) or (about["rows"] and not (folder / f"{name}.md").is_file()):
        raise InputError(f"{path} is damaged or stands alone: make it again with floquet study {name}")
    return about


def _section(folder: Path, name: str, about: Mapping[str, Any]) -> str:
    """One exhibit."""
    lines = [f'<h2 id="{name}">{_escaped(about["title"])}</h2>']
    if about["figure"]:
        lines.append(f'<figure><img src="{name}.png" alt="{_escaped(about["title"])}" loading="lazy"></figure>')
    lines.append(f"<p>{_escaped(about['caption'])}</p>")
    if about["text"]:
        lines.append(f'<pre class="wide">{_escaped(about["text"])}</pre>')
    if about["equations"]:
        numbers = ", ".join(f"({_escaped(one)})" for one in about["equations"])
        lines.append(f'<p class="small">Equations {numbers} of the report.</p>')
    if about["numbers"]:
        rows = [(key, "-" if value is None else _number(value)) for key, value in about["numbers"].items()]
        lines.append(_table(("number", "value"), rows))
    if about["rows"]:
        lines.append(_linked_table(folder, name, about["rows"]))
    return "\n".join(lines)


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else report.number(float(value), 6)


def _linked_table(folder: Path, name: str, rows: int) -> str:
    """The table as its Markdown file has it, folded if it is long, with links to the files."""
    lines = [line for line in (folder / f"{name}.md").read_text("utf-8").splitlines() if line.startswith("|")]
    cells = [
        [cell.strip().replace("\\|", "|").replace("\\*", "*") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in lines
    ]
    files = f'<a href="{name}.csv">CSV</a>, <a href="{name}.md">Markdown</a>'
    whole = _table(cells[0], cells[2:])
    if rows < LONG:
        return f'{whole}\n<p class="small">{files}</p>'
    return f"<details><summary>Table of {rows} rows ({files})</summary>\n{whole}\n</details>"


def _table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{_escaped(cell)}</th>" for cell in headers)
    body = "\n".join("<tr>" + "".join(_cell(cell) for cell in row) + "</tr>" for row in rows)
    return f'<div class="wide"><table>\n<tr>{head}</tr>\n{body}\n</table></div>'


def _cell(text: str) -> str:
    kind = ' class="number"' if re.match(r"[-+−.]?\d", text) else ""
    return f"<td{kind}>{_escaped(text)}</td>"


def _escaped(text: str) -> str:
    return html.escape(text, quote=True)
