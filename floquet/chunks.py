"""Numbers → the bytes of an HDF5 chunk, on every core.  Knows no files.

HDF5 filters the n numbers of k bytes of a chunk one after another, in one thread and under a lock.  Here threads do the
same, and the library is handed what comes out; any HDF5 reads it::

    shuffle      (n, k) bytes → k planes of n: the first bytes of all numbers, then the second ones …
    deflate      a zlib stream, in which every plane is deflated by itself, or stored as it is where that gains nothing
    fletcher32   four bytes at the end, B 2¹⁶ + A with the lowest byte first: of the 16-bit words w₁ … w_m, each with
                 its high byte first and the last filled up with a zero,
                 A = Σ wᵢ,  B = Σ (m + 1 - i) wᵢ,  modulo 65535, as one of 1 … 65535 unless all words are 0

The planes of a result are noise in the low bytes and few values in the high ones: one by one they take half the time
of all at once, for deflate does not look for the one in the other, and stored ones are read back at once.

Digests (blake2b) and the least and largest number, nan apart, are taken on the way.  Other versions of zlib may give
other bytes; digests are of the numbers, and so are equal for equal rows.
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .kernels import cores, keep_memory

__all__ = ["LEVEL", "Packed", "digest", "fletcher32", "in_order", "pack", "unpack"]

Array = NDArray[Any]
Key = TypeVar("Key")
Result = TypeVar("Result")

LEVEL = 1  # of deflate: level 6 takes half as long again and saves 2 %
MEMORY = 9  # of deflate, the most: a tenth faster than the usual 8
WORTH = 0.97  # of its size: a plane that shrinks less is stored as it is
AHEAD = 2  # chunks under way a thread: one is worked on, one waits, so that none idles while others are written
MOST = 8  # threads: one thread writes what comes, and it is busy with the output of so many


# ---------------------------------------------------------------------- filters
def _shuffled(numbers: Array) -> Array:
    return np.ascontiguousarray(numbers.view(np.uint8).reshape(numbers.size, numbers.itemsize).T)


def _deflated(planes: Array) -> bytes:
    stream = zlib.compressobj(LEVEL, zlib.DEFLATED, zlib.MAX_WBITS, MEMORY)
    parts = [stream.flush(zlib.Z_FULL_FLUSH)]  # the header
    for plane in planes:
        # after a full flush nothing refers to what was before, so that it may be replaced
        part = stream.compress(plane) + stream.flush(zlib.Z_FULL_FLUSH)
        parts.append(part if len(part) < WORTH * plane.size else _as_it_is(plane.tobytes()))
    return b"".join([*parts, stream.flush()])  # with the checksum of all that was compressed


def _as_it_is(data: bytes) -> bytes:
    """Stored blocks (RFC 1951, 3.2.4): a zero, the length, its complement, and up to 65535 bytes."""
    pieces = [data[i : i + 65535] for i in range(0, len(data), 65535)]
    return b"".join(struct.pack("<BHH", 0, len(p), 65535 - len(p)) + p for p in pieces)


def fletcher32(data: bytes) -> int:
    """HDF5's checksum.

    Sums over the rows and columns of a table of words, 256 a row, give both sums.  Words are read with their low byte
    first: exchanging the bytes of a word is multiplying it by 256, for 2¹⁶ = 1 modulo 65535.
    """
    count = -(-len(data) // 2)
    words = np.zeros((-(-count // 256), 256), "<u2")
    words.view(np.uint8).reshape(-1)[: len(data)] = np.frombuffer(data, np.uint8)
    # 32 bits hold 65537 words of a column: chunks of 33 MB, 128 times the largest here
    rows, columns = words.sum(axis=1, dtype=np.uint32).astype(int), words.sum(axis=0, dtype=np.uint32).astype(int)
    plain = int(rows.sum())
    weighted = int(rows @ (count - 256 * np.arange(rows.size))) - int(columns @ np.arange(256))
    return _folded(256 * weighted) << 16 | _folded(256 * plain)


def _folded(total: int) -> int:
    """Modulo 65535 as HDF5 leaves it: 65535 for multiples, 0 for nothing."""
    return total and (total - 1) % 65535 + 1


def digest(data: bytes | Array) -> bytes:
    """Of bytes, or of those of an array."""
    plain = data if isinstance(data, bytes) else np.ascontiguousarray(data).data
    return hashlib.blake2b(plain, digest_size=16).digest()


# ---------------------------------------------------------------------- chunks
@dataclass(frozen=True, kw_only=True)
class Packed:
    """A chunk as it is stored; digests of this and of its numbers; their least and largest, nan where all are nan."""

    data: bytes
    stored: bytes
    digest: bytes
    low: float
    high: float


def pack(pieces: Sequence[Array], dtype: str, rows: int) -> Packed:
    """The numbers of some arrays, one after another, as a chunk of so many rows, the rest of which are zeros."""
    numbers = np.concatenate(pieces).astype(dtype, copy=False)
    whole = numbers if numbers.size == rows else np.concatenate([numbers, np.zeros(rows - numbers.size, dtype)])
    data = _deflated(_shuffled(whole))
    data += fletcher32(data).to_bytes(4, "little")
    low, high = float(np.fmin.reduce(numbers)), float(np.fmax.reduce(numbers))
    return Packed(data=data, stored=digest(data), digest=digest(numbers), low=low, high=high)


def unpack(data: bytes, dtype: str, rows: int) -> Array:
    """The numbers of a chunk of so many rows whose bytes are known to be right; what they cannot be is a ValueError."""
    width = np.dtype(dtype).itemsize
    try:
        planes = np.frombuffer(zlib.decompress(memoryview(data)[:-4], bufsize=rows * width), np.uint8)
        planes = planes.reshape(width, rows)
    except zlib.error as error:
        raise ValueError(str(error)) from error
    numbers = np.empty(rows, dtype)
    for target, plane in zip(numbers.view(np.uint8).reshape(rows, width).T, planes, strict=True):
        target[:] = plane
    return numbers


def in_order(jobs: Iterable[tuple[Key, Callable[[], Result]]], *, large: bool = True) -> Iterator[tuple[Key, Result]]:
    """(key, result) of (key, job) in the order of the jobs, which run on every core.

    A few jobs are under way at a time, so that memory is bounded however many there are.  Without ``large`` they take
    no more than some chunks each, and the 30 MB of :func:`floquet.kernels.keep_memory` are spared.
    """
    if large:
        keep_memory()
    threads = min(cores(), MOST)
    if threads == 1:
        for key, job in jobs:
            yield key, job()
        return
    with ThreadPoolExecutor(threads) as pool:
        under_way: deque[tuple[Key, Future[Result]]] = deque()
        for key, job in jobs:
            under_way.append((key, pool.submit(job)))
            if len(under_way) >= AHEAD * threads:
                yield _result(under_way.popleft())
        while under_way:
            yield _result(under_way.popleft())


def _result(made: tuple[Key, Future[Result]]) -> tuple[Key, Result]:
    return made[0], made[1].result()
