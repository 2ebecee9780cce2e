"""The machine: one core, one thread, and a line that says which; to be called before anything loads NumPy."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["all_cores", "describe", "pin"]

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "FLOQUET_THREADS")
SETTINGS = {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1"}
DISTRIBUTIONS = ("numpy", "scipy", "numba", "heyoka", "numbalsoda", "diffrax", "jax", "tables")


def pin(core: int | None = None) -> None:
    """Keep this process and its children on one core (the last one unless told) with one thread a library."""
    if "numpy" in sys.modules:
        raise RuntimeError("NumPy is loaded already and may have started threads: pin first, import afterwards")
    os.environ.update(dict.fromkeys(ONE_THREAD, "1") | SETTINGS)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0)) if core is None else core})
    else:
        print("this system cannot pin a process to a core: times will scatter", file=sys.stderr)


@contextmanager
def all_cores() -> Iterator[int]:
    """Threads begun within may run on any core; gives the number of cores."""
    if not hasattr(os, "sched_setaffinity"):
        yield os.cpu_count() or 1
        return
    pinned = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield len(os.sched_getaffinity(0))
    finally:
        os.sched_setaffinity(0, pinned)


def describe() -> str:
    """Processor, versions and the linear algebra that NumPy calls, as one paragraph."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    versions = ", ".join(f"{name} {found}" for name in DISTRIBUTIONS if (found := _version(name)))
    text = f"{_processor()}, {cores} core in use; Python {platform.python_version()}, {versions}{_blas()}."
    if "OPENBLAS_CORETYPE" in os.environ:
        text += f" OPENBLAS_CORETYPE={os.environ['OPENBLAS_CORETYPE']} is set: LAPACK may be slower than it could be."
    return text


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    """``AMD EPYC, family 26, model 2`` (a virtual machine may hide the rest), else what Python knows."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").split("\n\n")[0].splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    found = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    parts = [found.get("model name", platform.machine())]
    parts += [f"{word} {found[key]}" for word, key in (("family", "cpu family"), ("model", "model")) if key in found]
    return ", ".join(parts)


def _blas() -> str:
    """OpenBLAS chooses its code by the processor; which one it chose, where threadpoolctl can tell."""
    if importlib.util.find_spec("threadpoolctl") is None:
        return ""
    import numpy  # noqa: F401  (loads the library that is looked for)
    from threadpoolctl import threadpool_info

    chosen = sorted({str(info["architecture"]) for info in threadpool_info() if "architecture" in info})
    return f", OpenBLAS for {' and '.join(chosen)}" if chosen else ""
