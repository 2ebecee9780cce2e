"""Chunks: HDF5 reads what threads have packed, its checksum is ours, and the order of jobs is kept."""

from __future__ import annotations

import threading
import time
import zlib
from collections.abc import Iterator
from functools import partial
from typing import Any

import h5py
import numpy as np
import pytest

from floquet import chunks

RANDOM = np.random.default_rng(1431)
FILTERS: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}


@pytest.fixture
def file() -> Iterator[h5py.File]:
    """A file in memory."""
    with h5py.File("x.h5", "w", driver="core", backing_store=False, libver=("v108", "v108")) as opened:
        yield opened


def pipeline(dataset: h5py.Dataset) -> list[Any]:
    made = dataset.id.get_create_plist()
    return [made.get_filter(i) for i in range(made.get_nfilters())]


def numbers(kind: str, count: int) -> np.ndarray[Any, Any]:
    noise = RANDOM.standard_normal(count)
    return {
        "noise": noise,
        "locks": np.where(np.arange(count) % 400 < 150, np.nan, np.repeat(noise, 20)[:count]),
        "constant": np.full(count, 1.5),
        "nothing": np.full(count, np.nan),
        "ends": np.resize([0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, -1.7e308], count),
        "axis": np.resize(np.linspace(0.0, 1.0, 101), count),
        "counter": np.arange(count, dtype="i8"),
        "small": RANDOM.integers(-128, 128, count).astype("i1"),
        "short": RANDOM.integers(-3, 5, count).astype("i2"),
        "design": np.repeat(np.arange(count), 101)[:count].astype("i4"),
    }[kind]


@pytest.mark.parametrize("count", [1, 2, 1000, 70_000])  # the last: a plane that needs two stored blocks
@pytest.mark.parametrize(
    "kind", ["noise", "locks", "constant", "nothing", "ends", "axis", "counter", "small", "short", "design"]
)
def test_hdf5_reads_a_chunk_as_if_it_had_written_it(file: h5py.File, kind: str, count: int) -> None:
    given = numbers(kind, count)
    ours = file.create_dataset("ours", (count,), given.dtype, chunks=(count,), **FILTERS)
    theirs = file.create_dataset("theirs", data=given, chunks=(count,), **FILTERS)
    packed = chunks.pack([given[: count // 3], given[count // 3 :]], given.dtype.str, count)
    ours.id.write_direct_chunk((0,), packed.data)
    assert ours[()].tobytes() == given.tobytes() == theirs[()].tobytes()
    assert [f[0] for f in pipeline(ours)] == [2, 1, 3] and pipeline(ours) == pipeline(theirs)
    left_out, raw = theirs.id.read_direct_chunk((0,))
    if not left_out:  # HDF5 leaves deflate out where it gains nothing
        assert zlib.decompress(raw[:-4]) == zlib.decompress(packed.data[:-4])
    assert len(packed.data) <= len(given.tobytes()) + 8 * (5 + 5 + 5) + 20  # stored planes: a few bytes a plane
    assert packed.digest == chunks.digest(given) and packed.stored == chunks.digest(packed.data)


def test_planes_of_noise_are_stored_and_others_deflated() -> None:
    """Of the eight planes of noise in [1, 2) six are noise; those of sign and exponent are constant."""
    noise = 1.0 + RANDOM.random(16384)
    size = len(chunks.pack([noise], "<f8", noise.size).data)
    assert 6 * 16384 < size < 6.6 * 16384  # the seventh has 4 bits of noise, of which deflate leaves 9 in 16
    assert len(chunks.pack([np.repeat(noise, 400)[:16384]], "<f8", 16384).data) < 1500
    assert size < 1.001 * len(zlib.compress(chunks._shuffled(noise).tobytes(), 1))


def test_the_end_of_the_last_chunk_is_zeros(file: h5py.File) -> None:
    data = file.create_dataset("x", (5,), "<f8", chunks=(8,), maxshape=(None,), **FILTERS)
    data.id.write_direct_chunk((0,), chunks.pack([np.arange(5.0)], "<f8", 8).data)
    data.resize((8,))
    assert data[()].tolist() == [0, 1, 2, 3, 4, 0, 0, 0]


@pytest.mark.parametrize("value", [[3.0, -1.0, np.nan], [np.nan, np.nan], [np.inf, 2.0], [7]])
def test_ranges_leave_nan_apart(value: list[float]) -> None:
    packed, given = chunks.pack([np.array(value)], "<f8", 4), np.array(value)
    some = given[~np.isnan(given)]
    expected = [some.min(), some.max()] if some.size else [np.nan, np.nan]
    np.testing.assert_array_equal([packed.low, packed.high], expected)


@pytest.mark.parametrize("length", [1, 2, 3, 255, 719, 720, 721, 1024, 65537, 131072])
def test_the_checksum_is_that_of_hdf5(file: h5py.File, length: int) -> None:
    """Also of zeros and of words that are all 65535, where sums modulo 65535 could be 0 or 65535."""
    for i, data in enumerate((RANDOM.bytes(length), bytes(length), b"\xff" * length, b"\x00\x01" * (length // 2))):
        if data:
            stored = file.create_dataset(f"{i}", data=np.frombuffer(data, "u1"), chunks=(len(data),), fletcher32=True)
            _, raw = stored.id.read_direct_chunk((0,))
            assert raw == data + chunks.fletcher32(data).to_bytes(4, "little")


def test_hdf5_notices_every_changed_byte(file: h5py.File) -> None:
    given = numbers("locks", 1000)
    data = file.create_dataset("x", (1000,), "<f8", chunks=(1000,), **FILTERS)
    image = chunks.pack([given], "<f8", 1000).data
    for position in [*range(0, len(image), 97), *range(len(image) - 4, len(image))]:
        broken = bytearray(image)
        broken[position] ^= 0x10
        data.id.write_direct_chunk((0,), bytes(broken))
        with pytest.raises(OSError, match="filter returned failure"):
            _ = data[()]


# ---------------------------------------------------------------------- threads
@pytest.mark.parametrize("threads", ["1", "2", "7"])
def test_results_come_in_the_order_of_the_jobs(monkeypatch: pytest.MonkeyPatch, threads: str) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", threads)

    def job(i: int) -> int:
        time.sleep(0.002 * (i % 3 == 0))
        return i * i

    found = list(chunks.in_order((i, partial(job, i)) for i in range(40)))
    assert found == [(i, i * i) for i in range(40)]


def test_few_jobs_are_under_way_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """However slowly results are taken: memory holds a few chunks."""
    monkeypatch.setenv("FLOQUET_THREADS", "3")
    begun: list[int] = []
    most = 0
    for taken, _ in enumerate(chunks.in_order((i, partial(begun.append, i)) for i in range(50))):
        time.sleep(0.001)
        most = max(most, len(begun) - taken)
    assert len(begun) == 50 and most <= 3 * chunks.AHEAD


def test_a_job_that_fails_ends_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLOQUET_THREADS", "2")
    done: list[int] = []

    def job(i: int) -> None:
        if i == 5:
            raise ZeroDivisionError
        done.append(i)

    with pytest.raises(ZeroDivisionError):
        list(chunks.in_order((i, partial(job, i)) for i in range(1000)))
    assert len(done) < 20 and not [t for t in threading.enumerate() if t.name.startswith("ThreadPoolExecutor")]
