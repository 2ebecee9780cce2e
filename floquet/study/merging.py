"""Several databases of the same equations as one."""

from __future__ import annotations

import contextlib
import hashlib
import json
import time
import warnings
from collections.abc import Iterator, Sequence
from itertools import permutations
from pathlib import Path

import numpy as np

from .. import __version__, store
from ..errors import FloquetWarning, InputError
from .alike import DESIGN, Runs, first_of, runs
from .extending import mapped
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
    with_points = [file for file in files if "points" in file.tables and file.rows("points")]
    pairs = list(permutations([(file, runs(file, "points", ("advance_ratio",))) for file in with_points], 2))
    for (a, mine), (b, theirs) in pairs:
        if all(ratios <= others for ratios, others, _ in _side_by_side(mine, theirs)):
            maps = ", as it is when one study was run with map = true and without" if _maps(a) != _maps(b) else ""
            raise InputError(
                f"{b.path} has every design and advance ratio of {a.path}{maps}: its rows would stand twice, so give "
                "one of the two"
            )
    for (a, mine), (b, theirs) in pairs:
        for ratios, others, row in _side_by_side(mine, theirs):
            if shared := ratios & others:
                raise InputError(
                    f"{a.path} and {b.path} both have {_described(row, a)} at μ = {min(shared):g}, and its row "
                    "would stand twice: run one study of both, or let one that has grown take its rows by --extend"
                )


def _side_by_side(mine: Runs, theirs: Runs) -> Iterator[tuple[frozenset[float], frozenset[float], int]]:
    """The advance ratios of designs in one database and in another, and a row of such a design; each case once."""
    case, left = [mine.which], np.arange(len(theirs.marks))
    while left.size:  # a database may have a design several times, with other advance ratios
        new = first_of(theirs.marks[left], theirs.marks[left]) == np.arange(left.size)
        place = first_of(mine.marks, theirs.marks[left[new]])
        case.append(np.where(place >= 0, theirs.which[left[new]][place], -1))
        left = left[~new]
    cases, index = np.unique(np.stack(case, axis=1), axis=0, return_index=True)
    sets, others = ([frozenset(ratios.ravel().tolist()) for ratios in one.beside] for one in (mine, theirs))
    for (own, *some), row in zip(cases.tolist(), mine.start[index].tolist(), strict=True):
        yield sets[own], frozenset().union(*(others[i] for i in some if i >= 0)), row


def _maps(file: store.File) -> bool:
    """Whether the study that a file keeps was of maps, as far as it says so."""
    with contextlib.suppress(InputError):
        return mapped(file)
    return False


def _described(row: int, file: store.File) -> str:
    """What is not 0 of the design of a row, and the name that a file has for it."""
    [(_, rows)] = file.chunks("points", ["rotor", *DESIGN], row, row + 1)
    given = ", ".join(f"{key} {rows[key][0]:g}" for key in DESIGN if rows[key][0])
    number = int(rows["rotor"][0])
    name = file.names[number] if number < len(file.names) else ""
    return f"the rotor {name!r} ({given})" if name else f"a rotor of {given}"


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
