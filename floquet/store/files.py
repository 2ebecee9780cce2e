"""Files that appear whole or not at all: written beside their place, synced, and renamed."""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import secrets
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import InputError, StorageError

__all__ = ["Sink", "atomic", "remove_leftovers", "write_failure"]


@contextlib.contextmanager
def atomic(path: str | Path, *, replace: bool = True) -> Iterator[Path]:
    """A temporary file beside ``path`` that takes its place when the block ends well, and vanishes when it does not.

    Where ``path`` is a link, it stays one, and the place is that of what it points to.  Permissions stay.  Without
    ``replace`` a file that has come there since is refused.
    """
    path = _behind(Path(path))
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(8)}.tmp")  # others may be on other machines
    try:
        with _in_use(temporary):
            yield temporary
            _settle(path, temporary, replace)
            os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        raise StorageError(path, write_failure(error)) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def _settle(path: Path, temporary: Path, replace: bool) -> None:
    """Sync a file that is complete, and give it the permissions of the one that it replaces."""
    _sync(temporary)
    if path.exists():
        if not replace:
            raise InputError(f"{path} has been written by another program meanwhile: choose another name")
        shutil.copymode(path, temporary)


@contextlib.contextmanager
def _in_use(temporary: Path) -> Iterator[None]:
    """A new file that is locked as long as its writer lives."""
    if sys.platform == "win32":  # where files that are in use cannot be removed, nor renamed
        yield
        return
    descriptor = os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with contextlib.suppress(OSError):  # of a file system without locks
            _lock(descriptor)
        yield
    finally:
        os.close(descriptor)


def _lock(descriptor: int) -> None:
    """Lock a file, or raise BlockingIOError."""
    if sys.platform != "win32":
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def remove_leftovers(folder: Path, name: str = "") -> None:
    """Remove temporary files that killed writers of ``name``, or of any file, have left in a folder."""
    if name:
        folder, name = (place := _behind(folder / name)).parent, place.name
    for left in folder.glob(f".{glob.escape(name) or '*'}.*.tmp"):
        with contextlib.suppress(OSError):  # such as that its writer lives
            descriptor = os.open(left, os.O_RDWR)
            try:
                _lock(descriptor)
                left.unlink()
            finally:
                os.close(descriptor)


def _behind(path: Path) -> Path:
    """Where a link points to; any other path as it is."""
    return path.resolve() if path.is_symlink() else path


def _sync(path: Path) -> None:
    with path.open("rb+") as file:  # Windows syncs only what may be written
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    """Make a rename durable, where folders can be synced; a disk that fails at it is an error."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno in (errno.EIO, errno.ENOSPC, errno.EDQUOT):
            raise
    finally:
        os.close(descriptor)


def write_failure(error: OSError) -> str:
    """Why a file could not be written, in a sentence."""
    reasons = {
        errno.ENOSPC: "the disk is full: free some space",
        errno.EIO: "the disk failed (an input/output error): check its health, or write elsewhere",
        errno.EFBIG: "the file would pass the limit on file sizes: raise the limit or write elsewhere",
        errno.EDQUOT: "the disk quota is used up: free some space",
        errno.EACCES: "the folder may not be written to: choose another, or change its permissions",
        errno.EROFS: "the file system is read-only: write elsewhere",
        errno.ENOENT: "the folder does not exist: create it first",
        errno.ENOTDIR: "a part of the path is a file, not a folder: check the path",
        errno.EISDIR: "this is a folder: name a file",
    }
    why = reasons.get(error.errno or 0, f"{(error.strerror or str(error)).lower()}: check the disk")
    return f"could not be written, because {why}; what was saved before is untouched"


class Sink:
    """A file for HDF5 to write to that never fails under its hands.

    HDF5 does not survive a full disk: a file that cannot be flushed at its close may crash the process.  Here the first
    error is kept, what follows is swallowed, and the error is raised when HDF5 is done.
    """

    def __init__(self, path: Path) -> None:
        self.file, self.position = path.open("w+b", buffering=0), 0
        self.error: OSError | None = None

    def __enter__(self) -> Sink:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()
        self.check()

    def check(self) -> None:
        """Raise what went wrong."""
        if self.error is not None:
            raise self.error

    def write(self, data: Any) -> int:
        """Write all of ``data`` at the position."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            self.file.seek(self.position)
            while len(left):
                left = left[self.file.write(left) or 0 :]
        except OSError as error:
            self.error = self.error or error
        self.position += size
        return size

    def readinto(self, buffer: Any) -> int:
        """Fill ``buffer``, with zeros beyond what was written."""
        view = memoryview(buffer).cast("B")
        self.file.seek(self.position)
        count = self.file.readinto(view) or 0
        view[count:] = bytes(len(view) - count)
        self.position += len(view)
        return len(view)

    def read(self, size: int) -> bytes:
        """As :meth:`readinto`; h5py knows a file by this method."""
        buffer = bytearray(size)
        self.readinto(buffer)
        return bytes(buffer)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move; the end is the end of what was written."""
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self.position, os.SEEK_END: os.fstat(self.file.fileno()).st_size}[whence]
        self.position = base + offset
        return self.position

    def tell(self) -> int:
        """The position."""
        return self.position

    def truncate(self, size: int | None = None) -> int:
        """Set the size."""
        size = self.position if size is None else size
        try:
            self.file.truncate(size)
        except OSError as error:
            self.error = self.error or error
        return size

    def flush(self) -> None:
        """Nothing waits here."""
