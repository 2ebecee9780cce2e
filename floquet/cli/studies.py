"""Figures of databases, and the studies that come with the package."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

import floquet
from floquet.cli.databases import processors, run_study
from floquet.cli.options import command, output_file, workers_flag
from floquet.cli.talk import answer, progress, say
from floquet.errors import InputError, did_you_mean

REPORT = "tp1431"
"""The numbered studies' folder among the studies, and in results where they are written."""
FILES = (".png", ".pdf", ".svg", ".csv", ".md", ".html", ".json", ".h5")
"""Endings that no folder of numbered studies has."""


@command.command()
@click.argument("database")
@click.argument("kind")
@output_file
@click.option("--rotor", help="Name or number (left out: the first); a summary takes several, by commas.")
@click.option("--dpi", type=float, default=200.0, show_default=True, help="Dots per inch of a .png, 20 to 2400.")
def plot(database: str, kind: str, output: str, rotor: str | None, dpi: float) -> None:
    """A figure of a database.

    KIND is root-locus, eigenvalues-vs-mu, error-vs-mu, validity-summary or validity-atlas.
    """
    from floquet.plot import plot_database

    say(f"wrote {plot_database(database, kind, output, rotor, dpi=dpi)}")


@command.command()
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run every study.")
@click.option("-o", "--output", help="File or folder to write, see above.")
@click.option("--resume", is_flag=True, help="Go on with a database that was stopped; keep a finished one.")
@workers_flag
def study(name: str | None, everything: bool, output: str | None, resume: bool, workers: int | None) -> int:
    """List the studies of the package, or run them.

    Without a NAME they are listed.  A numbered study (table-1, figure-3, question-2 ...) writes its figure, its table
    and a page, index.html, into the folder of --output (left out: results/tp1431); any other study writes a database
    (left out: NAME.h5).  --all runs every study, into one folder (left out: results/tp1431).
    """
    from floquet import exhibits
    from floquet import study as studies

    databases = {path.stem: path for path in sorted(studies_folder().glob("*.toml"))}
    numbered = exhibits.find(studies_folder() / REPORT)
    known = databases | numbered
    if name is not None and everything:
        raise InputError(f"{name} and --all ask for one study and for every study: give one of them")
    if name is not None and name not in known:
        sketch = ": figures 1 and 2 of the report are sketches" if name in ("figure-1", "figure-2") else ""
        near = sketch or did_you_mean(name, known) or ": there are " + ", ".join(known)
        raise InputError(f"{name!r} is no study{near}")
    if output is not None and name is None and not everything:
        raise InputError("--output goes with the NAME of one study, or with --all")
    if name is None and not everything:
        titles = {key: studies.load_study(path).title for key, path in databases.items()}
        titles |= {key: exhibits.title(path) for key, path in numbered.items()}
        answer("\n".join(f"{key}: {title}" for key, title in titles.items()))
        return 0
    count = processors() if workers is None else workers
    folder = Path(output or Path("results") / REPORT)
    if name in databases:
        target = folder / f"{name}.h5" if output and folder.is_dir() else Path(output or f"{name}.h5")
        return run_study(studies.load_study(databases[name]), str(target), resume, count, None)
    if folder.suffix.lower() in FILES or folder.is_file():
        raise InputError(f"{folder} is no folder, and numbered studies are written into one: name a folder with -o")
    statuses = [0]
    if everything:
        folder.mkdir(parents=True, exist_ok=True)
        statuses += [run_study(studies.load_study(path), str(folder / f"{key}.h5"), resume, count, None)
                     for key, path in databases.items()]  # fmt: skip
    chosen = list(numbered.values()) if name is None else [numbered[name]]
    return max(*statuses, _exhibits(chosen, folder, count))


def _exhibits(paths: Sequence[Path], folder: Path, workers: int) -> int:
    import textwrap

    from floquet import exhibits, report

    try:
        with progress("numbered studies") as done:
            failed = exhibits.make_all(paths, folder, workers=workers, progress=done)
    except KeyboardInterrupt:
        say(f"floquet: what is finished is in {folder}, and its page lists it")
        raise
    for name, reason in failed:
        say(f"floquet: {name}: {reason}")
    if len(paths) == 1 and not failed:
        shown = exhibits.read(folder, paths[0].stem)
        answer("\n".join([shown["title"], "", *textwrap.wrap(shown["caption"], 100), ""]))
        answer(report.table(("number", "value"), list(shown["numbers"].items())))
    if paths:
        answer(f"wrote {folder / 'index.html'}: {len(paths) - len(failed)} of {len(paths)} numbered studies")
    return 3 if failed else 0


def studies_folder() -> Path:
    """The studies, in a checkout beside the package and in an installation inside it."""
    package = Path(floquet.__file__).parent
    inside = package / "_share" / "studies"
    return inside if inside.is_dir() else package.parent / "studies"
