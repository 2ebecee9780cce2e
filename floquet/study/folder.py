"""The folder of a running study, ``OUT.h5.parts``::

    study.toml          the input, byte for byte
    study.json          study id, columns, sizes of table and shard, and a digest of all this
    points-<from>-<to>.h5, limits-<from>-<to>.h5

The listing of shards is the journal.  The study id hashes every parameter of the plan and the engine's version.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from .. import store
from ..errors import DatabaseError, InputError, StorageError, file_name
from ..studyfile import Study
from .shards import sizes_of

OTHER_FORMATS = (".csv", ".json", ".parquet", ".toml", ".txt", ".xlsx", ".mat", ".png", ".pdf", ".svg")
DAMAGED_JOURNAL = "its study.json is damaged: remove the folder and run the study again"


def checked_output(out: str | Path) -> Path:
    """Where a database is to be written; a name that promises another format is refused."""
    path = file_name(out)
    if path.is_dir():
        raise InputError(f"{path} is a folder: name the file that is to be written, such as {path / 'out.h5'}")
    if path.suffix.lower() in OTHER_FORMATS:
        raise InputError(
            f"{path} ends in {path.suffix}, and a database is HDF5: name it {path.with_suffix('.h5').name}, and take "
            f"{path.suffix} from it with floquet export"
        )
    return path


def parts_of(out: str | Path) -> Path:
    """The folder of a running study."""
    return Path(f"{out}.parts")


def remove_parts(folder: Path) -> None:
    """Remove a study's folder; what others have put into it stays there, and the folder with it."""
    ours = ("study.json", "study.toml", "points-*.h5", "limits-*.h5", ".*.tmp", ".lock")
    with contextlib.suppress(OSError):
        for path in [path for pattern in ours for path in folder.glob(pattern)]:
            path.unlink(missing_ok=True)
        folder.rmdir()


@contextlib.contextmanager
def locked(folder: Path, study: Study, resume: bool) -> Iterator[dict[str, int]]:
    """The study's folder, made or taken up, for one run at a time; gives the shard sizes that it began with."""
    sizes = sizes_of(study.plan)
    described: dict[str, Any] = {
        "study_id": study.id,
        "sizes": sizes,
        "columns": list(study.columns),
        "points": study.plan.points,
        "designs": study.plan.designs,
        "names": list(study.plan.names),
        "title": study.title,
        "options": study.plan.options,
    }
    described["digest"] = _digest(described)
    with contextlib.suppress(FileExistsError), _storage(folder):
        folder.mkdir()
    with alone(folder):
        journal = folder / "study.json"
        if journal.exists():
            if not resume:
                raise InputError(
                    f"{folder} holds an unfinished run: go on with it by --resume, or remove the folder to start again"
                )
            about = journal_of(folder)
            if about.get("study_id") != study.id:
                raise InputError(
                    f"{folder} holds an unfinished run of another study: choose another output, or remove the folder"
                )
            same_columns(folder, study, columns_of(folder, about))
            began = about.get("sizes")
            if not (isinstance(began, dict) and began.keys() == sizes.keys() and all(map(_is_size, began.values()))):
                raise DatabaseError(folder, DAMAGED_JOURNAL)
            sizes = began
        else:
            with store.atomic(folder / "study.toml") as temporary:
                temporary.write_text(study.text, encoding="utf-8")
            with store.atomic(journal) as temporary:
                temporary.write_text(json.dumps(described, indent=1), encoding="utf-8")
        yield sizes


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """A study's folder for one process at a time; the others are refused."""
    from filelock import FileLock, Timeout

    lock = FileLock(folder / ".lock", timeout=0)
    try:
        lock.acquire()
    except OSError as error:
        if not isinstance(error, Timeout):
            raise StorageError(folder, store.write_failure(error)) from error
        raise InputError(f"{folder} is in use by another run: wait for it, or write to another file") from None
    try:
        yield
    finally:
        lock.release()


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and value > 0


@contextlib.contextmanager
def _storage(path: Path) -> Iterator[None]:
    """OSErrors of folders and locks as sentences."""
    try:
        yield
    except FileExistsError:
        raise
    except OSError as error:
        raise StorageError(path, store.write_failure(error)) from error


def same_columns(place: Path, study: Study, there: Iterable[str]) -> None:
    """Refuse to go on with a run of this study that stores other columns."""
    there = set(there)
    differences = [
        f"{what} {', '.join(sorted(names))}"
        for what, names in (("without", set(study.columns) - there), ("with", there - set(study.columns)))
        if names
    ]
    if differences:
        raise InputError(
            f"{place} holds this study {' and '.join(differences)}: name the same columns, or choose another output"
        )


def journal_of(folder: Path) -> dict[str, Any]:
    """What study.json says."""
    try:
        about = json.loads(text_of(folder / "study.json"))
    except ValueError as error:
        if isinstance(error, DatabaseError):
            raise
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error
    if not isinstance(about, dict) or about.get("digest") != _digest(about):
        raise DatabaseError(folder, DAMAGED_JOURNAL)
    return about


def _digest(about: Mapping[str, Any]) -> str:
    """Of everything else that study.json says."""
    told = {name: value for name, value in about.items() if name != "digest"}
    return hashlib.blake2b(json.dumps(told, sort_keys=True).encode(), digest_size=16).hexdigest()


def columns_of(folder: Path, about: Mapping[str, Any]) -> tuple[str, ...]:
    """The columns of points that a journal tells; all where it was written before there was a choice."""
    try:
        return store.chosen(about.get("columns", [store.EVERY]))
    except (InputError, TypeError, AttributeError) as error:
        raise DatabaseError(folder, DAMAGED_JOURNAL) from error


def text_of(path: Path) -> str:
    """A file of a study's folder."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DatabaseError(
            path, "this file of the study's folder is missing or cannot be read: put it back, or run the study again"
        ) from error
