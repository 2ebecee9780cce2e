"""Several databases of the same equations as one."""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
import warnings
from collections.abc import Sequence
from itertools import combinations, pairwise, permutations
from pathlib import Path

import numpy as np

from .. import __version__, store
from ..errors import FloquetWarning, InputError
from .extending import DESIGN, mapped
from .folder import checked_output
from .packing import root_attributes


def merge(paths: Sequence[str | Path], out: str | Path) -> dict[str, int]:
    """One database of several with the same engine and options; rotors are numbered on.

    Of one, whatever release or program has written it, it is a copy as this release writes.
    """
    if not paths:
        raise InputError("merge takes one database or more, and none was given")
    if checked_output(out).exists():
        raise InputError(f"{out} is there already: choose another name or move it away")
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(store.open_file(p)) for p in paths]
        if len(files) == 1:
            return _renewed(files[0], out)
        first = files[0]
        seen: dict[str, str] = {}
        for file in files:
            for name in ("engine_version", "options"):
                if file.attributes.get(name) != first.attributes.get(name):
                    raise InputError(
                        f"{file.path} and {first.path} differ in {name}: "
                        "rows of one database must come from the same equations"
                    )
            if (other := seen.get(file.attributes["study_id"])) is not None:
                raise InputError(f"{file.path} and {other} hold the same study: its rows would stand twice")
            seen[file.attributes["study_id"]] = file.path
        _refuse_twice(files)
        counts = [_designs(f) for f in files]
        names = [n for f, c in zip(files, counts, strict=True) for n in (f.names or ("",) * c)]
        present = [t for t in store.TABLES if any(t in f.tables for f in files)]
        rows = {t: sum(f.rows(t) for f in files if t in f.tables) for t in present}
        columns = {t: _common(files, t) for t in present}
        combined = hashlib.blake2b("".join(seen).encode(), digest_size=16).hexdigest()
        text = "\n".join(f"# {f.path}\n{f.attributes.get('input', '')}" for f in files)
        attributes = root_attributes(
            f"{len(files)} studies merged",
            combined,
            names if any(names) else [],
            json.loads(first.attributes["options"]),
            text,
            int(first.attributes["engine_version"]),
        )
        store.remove_leftovers(Path(out).parent, Path(out).name)
        writers = stack.enter_context(store.create(out, rows, attributes, columns=columns, replace=False))
        for table, writer in writers.items():
            for offset, file in zip(np.cumsum([0, *counts]), files, strict=False):
                if table in file.tables:
                    store.copy_rows(file, writer, rotor_offset=int(offset))
    return rows


def _renewed(file: store.File, out: str | Path) -> dict[str, int]:
    """A copy in the present schema, with the same rows and attributes and a line of history."""
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    line = f"{now} floquet-rotor {__version__}, from schema {file.attributes['schema_version']}"
    attributes = {name: value for name, value in file.attributes.items() if name != "attributes_digest"}
    attributes["history"] = "\n".join(filter(None, [attributes.get("history"), line]))
    rows = {table: file.rows(table) for table in file.tables}
    columns = {table: _common([file], table) for table in file.tables}
    with store.create(out, rows, attributes, columns=columns, replace=False) as writers:
        for writer in writers.values():
            store.copy_rows(file, writer)
    return rows


def _refuse_twice(files: Sequence[store.File]) -> None:
    """No database has a row of another: least of all every row, as that of one study with maps and without."""
    points = [_points(file) for file in files]
    for (a, mine), (b, theirs) in permutations(zip(files, points, strict=True), 2):
        if mine and all(ratios <= theirs.get(design, frozenset()) for design, ratios in mine.items()):
            maps = ", as it is when one study was run with map = true and without" if _maps(a) != _maps(b) else ""
            raise InputError(
                f"{b.path} has every design and advance ratio of {a.path}{maps}: its rows would stand twice, so give "
                "one of the two"
            )
    for (a, mine), (b, theirs) in combinations(zip(files, points, strict=True), 2):
        for design, ratios in mine.items():
            if shared := ratios & theirs.get(design, frozenset()):
                raise InputError(
                    f"{a.path} and {b.path} both have {_described(design, a)} at μ = {min(shared):g}, and its row "
                    "would stand twice: run one study of both, or let one that has grown take its rows by --extend"
                )


def _maps(file: store.File) -> bool:
    """Whether the study that a file keeps was of maps, as far as it says so."""
    with contextlib.suppress(InputError):
        return mapped(file)
    return False


def _described(design: bytes, file: store.File) -> str:
    """What is not 0 of a design, and the name that a file has for it."""
    values = np.frombuffer(design)
    given = ", ".join(f"{key} {value:g}" for key, value in zip(DESIGN, values, strict=True) if value)
    columns = ["rotor", *DESIGN]
    for _, rows in file.chunks("points", columns):
        same = np.all([rows[name] == value for name, value in zip(DESIGN, values, strict=True)], axis=0)
        if same.any():
            number = int(rows["rotor"][same][0])
            name = file.names[number] if number < len(file.names) else ""
            return f"the rotor {name!r} ({given})" if name else f"a rotor of {given}"
    return f"a rotor of {given}"


def _points(file: store.File) -> dict[bytes, frozenset[float]]:
    """The designs, by their parameters, and their advance ratios."""
    columns = ["rotor", "advance_ratio", *DESIGN]
    found: dict[bytes, frozenset[float]] = {}
    grids: dict[bytes, frozenset[float]] = {}  # each once: all designs of a study have the same
    for _, rows in file.chunks("points", columns) if "points" in file.tables else ():
        rotor, mu = rows["rotor"], rows["advance_ratio"]
        ends = [0, *(np.flatnonzero(np.diff(rotor)) + 1).tolist(), len(rotor)]
        for start, stop in pairwise(ends):
            values = np.array([float(rows[column][start]) for column in columns[2:]])
            design, piece = values.tobytes(), mu[start:stop].tobytes()
            if piece not in grids:
                grids[piece] = frozenset(mu[start:stop].tolist())
            found[design] = found[design] | grids[piece] if design in found else grids[piece]
    return found


def _designs(file: store.File) -> int:
    """How many rotors a database has."""
    return max((int(r["rotor"].max()) + 1 for _, r in file.chunks("points", ["rotor"])), default=0)


def _common(files: Sequence[store.File], table: str) -> list[str]:
    """The columns that a table has in every file; a warning names the others."""
    there = [file.columns(table) for file in files if table in file.tables]
    kept = [name for name in store.TABLES[table] if all(name in columns for columns in there)]
    lost = [name for name in store.TABLES[table] if name not in kept and any(name in columns for columns in there)]
    lost += sorted(set().union(*(file.unknown(table) for file in files if table in file.tables)))
    if lost:
        warnings.warn(
            "columns that not every database has, or that this release does not know, are left out of the table "
            f"{table}: {', '.join(lost)}",
            FloquetWarning,
            stacklevel=3,
        )
    return kept
