"""Rows of a database → Axes; the only room that imports matplotlib (object interface, no pyplot, no display needed).

=====================  ==============================================================================================
kind                   what it shows
=====================  ==============================================================================================
root-locus             the eigenvalues' paths in the complex plane with μ along them; Re across, stable on the left
eigenvalues-vs-mu      frequency above, damping below, lock bands shaded, the limit of the simple model marked
error-vs-mu            relative errors of the TPP modes, the tolerances and where they are crossed
validity-summary       for many rotors at once, the ranges of μ in which each TPP mode holds or fails
validity-atlas         of thousands of designs, how many each TPP mode holds for, by Lock number and μ
=====================  ==============================================================================================

Floquet is solid, TPP (the tip-path plane) dashed, a mode has one colour.  Each kind is a function of rows (columns of
one rotor by name, as ``query`` gives them) that draws into given Axes, or into a figure of its own at the width of a
journal's page or column, and returns the Axes; ``plot_database`` writes a file.  What is drawn between rows, and why
it is exact at lock edges and splits, stands in :mod:`floquet.plot.curves`.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np

from floquet.errors import ParameterError, did_you_mean
from floquet.plot.against_mu import eigenvalues_vs_mu, error_vs_mu
from floquet.plot.atlas import ATLAS_COLUMNS, validity_atlas
from floquet.plot.curves import lock_bands
from floquet.plot.locus import root_locus
from floquet.plot.parts import STYLE, root_figure, write_footer
from floquet.plot.summary import RotorRows, validity_summary
from floquet.rotor import PARAMETERS
from floquet.sweep import MODES, repeated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from floquet.query import Database

__all__ = [
    "ATLAS", "KINDS", "RotorRows", "eigenvalues_vs_mu", "error_vs_mu", "lock_bands", "plot_database", "root_locus",
    "validity_atlas", "validity_summary", "write_figure",
]  # fmt: skip

KINDS: dict[str, Callable[..., Any]] = {
    "root-locus": root_locus,
    "eigenvalues-vs-mu": eigenvalues_vs_mu,
    "error-vs-mu": error_vs_mu,
    "validity-summary": validity_summary,
    "validity-atlas": validity_atlas,
}
"""What ``plot_database`` and the command line can draw."""
BLADE = ("exponent_1", "exponent_2", "rotation_number", "lock")
EIGENVALUES, ERRORS = ("rule_{}", "tpp_{}_1", "tpp_{}_2"), ("rule_{}", "error_{}")
NEEDS = {
    "root-locus": EIGENVALUES,
    "eigenvalues-vs-mu": EIGENVALUES,
    "error-vs-mu": ERRORS,
    "validity-summary": ERRORS,
}
"""Columns of a mode that a kind draws, beside ``BLADE`` and those that every database has."""
ATLAS = "validity-atlas"
"""The kind that shows all designs of a file by their limits."""
SUMMARIES = ("validity-summary",)
"""Kinds that show several rotors; the others show one."""
MOST = 40
"""Rotors in one summary."""
SHARPNESS = (20, 2400)
"""The least and the most dots per inch."""
FORMATS: dict[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
"""What a figure may be written as, and what is left out because it would make two files of one figure differ."""


def plot_database(database: Database | str | Path, kind: str, out: str | Path,
                  rotor: str | int | Sequence[str | int] | None = None, *, dpi: float = 200.0) -> Path:  # fmt: skip
    """Draw a database and write the figure, whole or not at all.

    Parameters
    ----------
    database
        Open, or the path of a file.
    kind
        One of ``KINDS``.
    out
        The figure's path, which ends in .png, .pdf or .svg.
    rotor
        A rotor's name or its number in the file, for a summary also several, listed or with commas between.  None is
        the first rotor, for a summary every rotor; others are chosen with ``--rotor NAME`` on the command line.
    dpi
        Dots per inch of a .png, 20 to 2400.
    """
    from floquet.query import Database, open_database

    if kind not in KINDS:
        known = ", ".join(KINDS)
        raise ParameterError(
            "kind", kind, f"{kind!r} is no kind of figure{did_you_mean(str(kind), KINDS)}; there are {known}"
        )
    if not SHARPNESS[0] <= dpi <= SHARPNESS[1]:
        raise ParameterError("dpi", dpi, "a figure has {} to {} dots per inch; print needs 300".format(*SHARPNESS))
    path = _target(out)
    with contextlib.ExitStack() as closing:
        db = database if isinstance(database, Database) else closing.enter_context(open_database(database))
        options = db.attributes.get("options")
        physics = _physics(options)
        if kind == ATLAS:
            return _written(KINDS[kind](_limits(db, rotor)), physics, path, dpi)
        rotors = [_drawable(db, kind, _rows(db, index)) for index in _chosen(db, rotor, every=kind in SUMMARIES)]
    if kind in SUMMARIES:
        drawn = KINDS[kind](rotors)
    else:
        given = {"options": _options(options)} if kind == "error-vs-mu" else {}
        drawn = KINDS[kind](rotors[0].points, rotors[0].limits, name=rotors[0].name, **given)
    return _written(root_figure(drawn[0] if isinstance(drawn, tuple) else drawn), physics, path, dpi)


def _written(figure: Figure, physics: str, path: Path, dpi: float) -> Path:
    write_footer(figure, physics)
    write_figure(figure, path, dpi)
    return path


def _limits(db: Database, rotor: object) -> dict[str, Any]:
    """The columns of an atlas from the limits at one tolerance: 5 % of the exact eigenvalue, if there is that."""
    if rotor is not None:
        raise ParameterError("rotor", rotor, f"{ATLAS} shows all rotors of a file: leave out --rotor")
    about = [*(parameter.name for parameter in PARAMETERS), "hub", "blades"]
    columns = list(dict.fromkeys([*ATLAS_COLUMNS, *about]))
    found = db.query(table="limits", columns=columns) if "limits" in db.tables else {}
    if not len(found.get("limit", ())):
        raise ParameterError(
            "kind", ATLAS, f"{db.path} has no limits: give its study tolerances in [compare] and run it again"
        )
    relative = found["metric"] == found["metric"].min()
    tolerances = np.unique(found["tolerance"][relative])
    chosen = relative & (found["tolerance"] == tolerances[np.argmin(np.abs(tolerances - 0.05))])
    return _once({name: values[chosen] for name, values in found.items()})


def _once(limits: dict[str, Any]) -> dict[str, Any]:
    """The limits without those of designs that an earlier one equals: files may give a node of the grid."""
    _, first = np.unique(limits["rotor"], return_index=True)
    values = {parameter.name: limits[parameter.name][first] for parameter in PARAMETERS}
    again = [design for design, _ in repeated(values, limits["hub"][first], limits["blades"][first])]
    kept = ~np.isin(limits["rotor"], limits["rotor"][first][again])
    return {name: values[kept] for name, values in limits.items()}


def _physics(options: Any) -> str:
    """The study's choices of physics that are not the usual ones, in words."""
    given = _stored(options)
    usual = {"model": "by hub", "tip_loss": 1.0}
    chosen = {name: value for name, value in given.items() if value != usual.get(name, False)}
    words = [name if value is True else f"{name} {value}" for name, value in chosen.items()]
    return f"With {', '.join(words)}.".replace("_", " ") if words else ""


def _options(options: Any) -> dict[str, Any]:
    """The study's choices of physics as keywords of ``compare``."""
    given = _stored(options)
    return {name: value for name, value in given.items() if (name, value) != ("model", "by hub")}


def _stored(options: Any) -> dict[str, Any]:
    try:
        return dict(json.loads(options))
    except (TypeError, ValueError):
        return {}


def _target(out: str | Path) -> Path:
    path = Path(out)
    ending = path.suffix.lower().lstrip(".")
    if ending not in FORMATS:
        given = f"{str(out)!r} ends in {path.suffix}" if path.suffix else f"{str(out)!r} has no ending"
        sentence = f"{given}, and a figure's name ends in .png, .pdf or .svg{did_you_mean(ending, FORMATS)}"
        raise ParameterError("out", str(out), sentence)
    return path


def _chosen(db: Database, rotor: str | int | Sequence[str | int] | None, *, every: bool) -> list[int]:
    """Numbers of the rotors to draw."""
    last = db.query(columns=["rotor"], sort="rotor", descending=True, limit=1)["rotor"]
    count = max(len(db.names), int(last[0]) + 1 if len(last) else 0)
    if count == 0:
        raise ParameterError("rotor", rotor, f"{db.path} has no rows, so there is nothing to draw: run its study first")
    if rotor is None:
        found = list(range(count)) if every else [0]
    elif isinstance(rotor, str | int):
        whole = _number(db, rotor, count)
        found = [whole] if whole is not None else [_named(db, word, count) for word in str(rotor).split(",")]
    else:
        found = [_named(db, word, count) for word in rotor]
    most = MOST if every else 1
    if len(found) > most:
        sentence = (
            f"{len(found)} rotors are asked for and this kind of figure shows {most} at most: name fewer with --rotor"
        )
        raise ParameterError("rotor", rotor, sentence)
    return found


def _number(db: Database, rotor: str | int, count: int) -> int | None:
    """The number of a rotor given by its name (first as written, then whatever its capitals) or by its number."""
    given, names = str(rotor).strip(), list(db.names)
    for known, word in ((names, given), ([name.casefold() for name in names], given.casefold())):
        if word in known:
            return known.index(word)
    return int(given) if given.isdecimal() and int(given) < count else None


def _named(db: Database, rotor: str | int, count: int) -> int:
    number = _number(db, rotor, count)
    if number is not None:
        return number
    given, names = str(rotor).strip(), db.names
    known = [name for name in names if name]
    more = f" and {len(known) - 8} more" if len(known) > 8 else ""
    numbers = f"numbers from 0 to {count - 1}"
    has = f"{', '.join(known[:8])}{more}, and {numbers}" if known else f"no names, so give one of the {numbers}"
    raise ParameterError(
        "rotor", rotor, f"{given!r} is no rotor of {db.path}{did_you_mean(given, names)}; it has {has}"
    )


def _rows(db: Database, rotor: int) -> RotorRows:
    name = db.names[rotor] if rotor < len(db.names) and db.names[rotor] else f"rotor {rotor}"
    points = db.query(f"rotor == {rotor}", columns="*")
    if not len(points["advance_ratio"]):
        sentence = f"{db.path} has no rows of {name}: its study is not finished, so run it with --resume"
        raise ParameterError("rotor", name, sentence)
    limits = db.query(f"rotor == {rotor}", table="limits", columns="*") if "limits" in db.tables else {}
    return RotorRows(name, points, limits)


def _drawable(db: Database, kind: str, rows: RotorRows) -> RotorRows:
    """The rows with the modes that are stored with all that a kind draws of them."""
    missing = [name for name in BLADE if name not in rows.points]
    whole = [mode for mode in MODES if all(name.format(mode) in rows.points for name in NEEDS[kind])]
    if missing or not whole:
        of_mode = [] if whole else [name.format("MODE") for name in NEEDS[kind]]
        sentence = (
            f"{kind} draws {', '.join([*missing, *of_mode])}, and {db.path} was written without: "
            "[output] columns of its study leaves them out, so add them there and run the study again"
        )
        raise ParameterError("kind", kind, sentence)
    left_out = {f"rule_{mode}" for mode in MODES if mode not in whole}
    points = {name: values for name, values in rows.points.items() if name not in left_out}
    return RotorRows(rows.name, points, rows.limits)


def write_figure(figure: Figure, path: Path, dpi: float) -> None:
    """Write a figure whole or not at all: .png, .pdf or .svg; the same figure makes the same bytes."""
    from floquet.store import atomic

    ending = path.suffix.lower().lstrip(".")
    with atomic(path) as temporary, matplotlib.rc_context(STYLE):
        figure.savefig(temporary, format=ending, dpi=dpi, metadata=FORMATS[ending])
