"""The shards of a study, checked, as one database."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .. import __version__, store
from ..errors import DamageError, DatabaseError, InputError
from ..sweep import ENGINE
from .folder import DAMAGED_JOURNAL, alone, checked_output, columns_of, journal_of, text_of
from .shards import Parts, Shard, listed, ours, sound


def pack(folder: str | Path, out: str | Path) -> dict[str, int]:
    """Check all shards of a study's folder and write them as one database; the rows of each table.

    No run may be at the folder, which is said where it may be written to.
    """
    folder, out = Path(folder), checked_output(out)
    _refuse_database(out)
    if not (folder / "study.json").is_file():
        raise DatabaseError(
            folder, "this is not the folder of a study: pack takes OUT.h5.parts, which floquet run leaves when it stops"
        )
    with alone(folder) if os.access(folder, os.W_OK) else contextlib.nullcontext():
        return packed(folder, out)


def packed(folder: Path, out: Path, *, replace: bool = False) -> dict[str, int]:
    """As :func:`pack`, by who has the folder.

    ``replace`` puts the database in the place of what is there, when it is whole.
    """
    if not replace:
        _refuse_database(out)
    about = journal_of(folder)
    try:
        counts = {"points": about["points"], "limits": about["designs"]}
        shards = {t: listed(t, counts[t], about["sizes"][t]) for t in store.TABLES if t in about["sizes"]}
        parts = Parts(folder, about["study_id"], columns_of(folder, about))
        text = text_of(folder / "study.toml")
        told = about["title"], about["study_id"], about["names"], about["options"], text
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        if isinstance(error, DatabaseError):
            raise
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error
    store.remove_leftovers(out.parent, out.name)
    everything = [s for group in shards.values() for s in group]
    missing = [s for s in everything if not (folder / s.file).exists()]
    if missing:
        raise DatabaseError(
            folder, f"{len(missing)} of {len(everything)} shards are missing: finish the study with --resume"
        )
    _refuse([s for s in everything if not ours(s, parts)], everything, folder)
    attributes = root_attributes(*told, _engine(parts, everything))
    try:
        return _joined(shards, parts, out, attributes, replace)
    except DamageError:
        _refuse([s for s in everything if not sound(s, parts)], everything, folder)
        raise


def _refuse_database(out: Path) -> None:
    if out.exists():
        raise InputError(f"{out} is there already: choose another name or move it away")


def _refuse(wrong: Sequence[Shard], everything: Sequence[Shard], folder: Path) -> None:
    if wrong:
        raise DatabaseError(
            folder,
            f"{len(wrong)} of {len(everything)} shards are damaged or of another study or range, the first "
            f"{wrong[0].file}: make them again with --resume",
        )


def _engine(parts: Parts, shards: Sequence[Shard]) -> int:
    """The engine that computed all shards."""
    engines = set()
    for shard in shards:
        with store.open_file(parts.folder / shard.file) as file:
            engines.add(int(file.attributes.get("engine_version", ENGINE)))
    if len(engines) > 1:
        raise DatabaseError(
            parts.folder, f"its parts are of engines {', '.join(map(str, sorted(engines)))}, whose rows may differ: "
            "remove the folder and run the study again"
        )  # fmt: skip
    return engines.pop() if engines else ENGINE


def _joined(
    shards: Mapping[str, Sequence[Shard]], parts: Parts, out: str | Path, attributes: Mapping[str, Any], replace: bool
) -> dict[str, int]:
    """The database of these shards, each of which is checked chunk by chunk."""
    rows = {t: sum(_rows_of(parts.folder / s.file, t) for s in group) for t, group in shards.items()}
    with store.create(out, rows, attributes, columns={"points": parts.columns}, replace=replace) as writers:
        for table, writer in writers.items():
            for shard in shards[table]:
                with store.open_file(parts.folder / shard.file) as file:
                    store.copy_rows(file, writer)
    return rows


def _rows_of(path: Path, table: str) -> int:
    with store.open_file(path) as file:
        return file.rows(table)


def root_attributes(
    title: str, study_id: str, names: Sequence[str], options: Mapping[str, Any], text: str, engine: int = ENGINE
) -> dict[str, Any]:
    """Root attributes of a database; ``engine`` is that which computed its rows."""
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return {
        "title": title,
        "history": f"{now} floquet-rotor {__version__}",
        "source": f"floquet-rotor {__version__}: Floquet exponents against the tip-path plane; no dynamic inflow",
        "created": now,
        "study_id": study_id,
        "engine_version": engine,
        "options": json.dumps(options),
        "rotor_names": json.dumps(list(names), ensure_ascii=False),
        "input": text,
    }
