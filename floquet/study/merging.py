"""Several databases of the same equations as one."""

from __future__ import annotations

import contextlib
import hashlib
import json
import warnings
from collections.abc import Sequence
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np

from .. import store
from ..errors import FloquetWarning, InputError
from ..rotor import PARAMETERS
from .packing import root_attributes


def merge(paths: Sequence[str | Path], out: str | Path) -> dict[str, int]:
    """One database of several with the same engine and options; rotors are numbered on."""
    if len(paths) < 2:
        raise InputError("merge takes two databases or more")
    if Path(out).exists():
        raise InputError(f"{out} is there already: choose another name or move it away")
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(store.open_file(p)) for p in paths]
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
        )
        writers = stack.enter_context(store.create(out, rows, attributes, columns=columns))
        for table, writer in writers.items():
            for offset, file in zip(np.cumsum([0, *counts]), files, strict=False):
                if table in file.tables:
                    store.copy_rows(file, writer, rotor_offset=int(offset))
    return rows


def _refuse_twice(files: Sequence[store.File]) -> None:
    """No database has every row of another, as that of one study with maps and without."""
    points = [_points(file) for file in files]
    for (a, mine), (b, theirs) in permutations(zip(files, points, strict=True), 2):
        if mine and all(ratios <= theirs.get(design, frozenset()) for design, ratios in mine.items()):
            raise InputError(
                f"{b.path} has every design and advance ratio of {a.path}, as it is when one study was run with "
                "map = true and without: its rows would stand twice, so give one of the two"
            )


def _points(file: store.File) -> dict[bytes, frozenset[float]]:
    """The designs, by name and parameters, and their advance ratios."""
    columns = ["rotor", "advance_ratio", *(p.name for p in PARAMETERS), "blades", "hub"]
    found: dict[bytes, frozenset[float]] = {}
    grids: dict[bytes, frozenset[float]] = {}  # each once: all designs of a study have the same
    for _, rows in file.chunks("points", columns) if "points" in file.tables else ():
        rotor, mu = rows["rotor"], rows["advance_ratio"]
        ends = [0, *(np.flatnonzero(np.diff(rotor)) + 1).tolist(), len(rotor)]
        for start, stop in pairwise(ends):
            name = file.names[rotor[start]] if rotor[start] < len(file.names) else ""
            values = np.array([float(rows[column][start]) for column in columns[2:]])
            design, piece = name.encode() + b"\0" + values.tobytes(), mu[start:stop].tobytes()
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
    if lost:
        warnings.warn(
            f"columns that not every database has are left out of the table {table}: {', '.join(lost)}",
            FloquetWarning,
            stacklevel=3,
        )
    return kept
