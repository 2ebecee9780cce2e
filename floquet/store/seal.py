"""The seal: what tells that a file's metadata are those that were written, before HDF5 looks at them.

HDF5's library may crash or hang on metadata that are not sound, and it has no checksum of all of them.  A database is
written in one go, so what is not chunk data can be digested once it is complete.  The seal stands behind the end of the
HDF5 file, where readers do not look (the superblock says where it ends)::

    0 … end             HDF5
    end …               extents, pairs of u64 (first byte, bytes): all of 0 … end but the chunks of the tables
    the last 48 bytes   count of extents, u64; end, u64; blake2b of extents, end and the bytes at the extents; MAGIC

All numbers have their lowest byte first.  Chunks have digests of their own.  A program that writes to the file, or
makes another of it, leaves no seal: its files are examined in a child process (:mod:`floquet.store.examine`).  It
leaves nothing else behind the end either, so that bytes there that are no seal are what is left of one: damage.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Iterable
from typing import BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from .files import Sink

__all__ = ["SIGNATURE", "Seal", "add_seal", "chunk_extents"]

MAGIC = b"\x89floquet\r\n\x1a\n\0\0\0\1"  # 16 bytes; a file that was sent as text loses it
FOOTER = struct.Struct("<QQ16s16s")
PIECE = 1 << 20  # bytes that are read at a time
SIGNATURE = b"\x89HDF\r\n\x1a\n"
ENDS = {0: 40, 1: 44, 2: 28, 3: 28}  # where a superblock of each version says at which byte HDF5 ends
Extents = NDArray[np.uint64]


class Seal:
    """What the end of a file says of it."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.size = file, os.fstat(file.fileno()).st_size
        file.seek(max(0, self.size - FOOTER.size))
        last = file.read(FOOTER.size)
        count, self.end, self.digest, magic = FOOTER.unpack(last) if len(last) == FOOTER.size else (0, 0, b"", b"")
        self.present = magic == MAGIC
        self.remains = not self.present and 0 < self._hdf5_ends() < self.size
        self.fits = self.present and self.end + 16 * count + FOOTER.size == self.size
        self.count = count

    def _hdf5_ends(self) -> int:
        """Where the superblock says that HDF5 ends, 0 where it says nothing."""
        self.file.seek(0)
        head = self.file.read(64)
        if len(head) < 64 or not head.startswith(SIGNATURE) or (place := ENDS.get(head[8])) is None:
            return 0
        return int.from_bytes(head[place : place + 8], "little")

    def holds(self) -> bool:
        """Whether everything outside the chunks is as it was when the file was sealed."""
        if not self.fits:
            return False
        self.file.seek(self.end)
        extents = np.frombuffer(self.file.read(16 * self.count), "<u8").reshape(-1, 2)
        if not _in_order(extents, self.end):
            return False
        return _digest(self.file, extents, self.end) == self.digest


def _in_order(extents: Extents, end: int) -> bool:
    """Whether extents follow one another up to the end."""
    first, length = extents[:, 0], extents[:, 1]
    if np.any(first > end) or np.any(length > end):  # before sums could overflow
        return False
    return bool(np.all(first[1:] >= (first + length)[:-1]) and np.all(first + length <= end))


def _digest(file: BinaryIO | Sink, extents: Extents, end: int) -> bytes:
    """Over the extents, the end, and the bytes at the extents."""
    total = hashlib.blake2b(extents.astype("<u8").tobytes() + struct.pack("<Q", end), digest_size=16)
    for first, length in extents.tolist():
        file.seek(first)
        for start in range(0, length, PIECE):
            total.update(file.read(min(PIECE, length - start)))
    return total.digest()


def chunk_extents(datasets: Iterable[h5py.Dataset]) -> list[tuple[int, int]]:
    """(first byte, bytes) of every chunk of some variables."""
    found: list[tuple[int, int]] = []
    for dataset in datasets:
        dataset.id.chunk_iter(lambda chunk: found.append((chunk.byte_offset, chunk.size)))
    return found


def add_seal(sink: Sink, chunks: list[tuple[int, int]]) -> None:
    """Seal a file that HDF5 has finished, with chunks at these places."""
    end = sink.seek(0, os.SEEK_END)
    taken = np.array(sorted(chunks), np.int64).reshape(-1, 2)
    starts, stops = np.append(0, taken.sum(axis=1)), np.append(taken[:, 0], end)
    some = stops > starts
    extents = np.column_stack([starts, stops - starts])[some].astype(np.uint64)
    digest = _digest(sink, extents, end)
    sink.seek(end)
    sink.write(extents.astype("<u8").tobytes() + FOOTER.pack(len(extents), end, digest, MAGIC))
