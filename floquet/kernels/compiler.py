"""numba, with a cache on disk that follows the kernels' sources.  The only import of numba.

numba looks at the file of a cached function alone: a kernel that calls a changed function of another file would be
loaded from the cache as it was.  Here the folder of the cache is named by a digest of all kernel sources and of the
versions of Python, NumPy and numba, below the folder of ``NUMBA_CACHE_DIR`` where that is set, else below the user's
cache folder; functions outside this package keep numba's own setting.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numba
import numpy as np

__all__ = ["cache_folder", "inlined", "kernel", "unfused_kernel"]

F = TypeVar("F", bound=Callable[..., Any])
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
FUSED: dict[str, Any] = {"fastmath": {"contract"}}


def digest(folder: Path = Path(__file__).parent) -> str:
    """Of the kernel sources and of all that compiles them."""
    parts = [f"{sys.version} {np.__version__} {numba.__version__} {platform.machine()}".encode()]
    parts += [path.name.encode() + path.read_bytes() for path in sorted(folder.glob("*.py"))]
    return hashlib.blake2b(b"\0".join(parts), digest_size=8).hexdigest()


@cache
def cache_folder() -> str:
    """Where compiled kernels are kept; a temporary folder if no other can be written to."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    chosen = os.environ.get("NUMBA_CACHE_DIR") or Path(home) / "floquet"
    for folder in (
        Path(chosen),
        Path(tempfile.gettempdir()) / f"floquet-{os.getuid() if hasattr(os, 'getuid') else 0}",
    ):
        try:
            (place := folder / f"kernels-{digest()}").mkdir(parents=True, exist_ok=True)
            return str(place)
        except OSError:
            continue
    return ""


def kernel(function: F) -> F:
    """A function over arrays of points: compiled at its first call, kept on disk, free of the interpreter's lock.

    A product and a sum may be fused.
    """
    return _kept(function, FUSED)


def unfused_kernel(function: F) -> F:
    """The same for arithmetic in which every rounding counts."""
    return _kept(function, {})


def _kept(function: F, more: dict[str, Any]) -> F:
    config: Any = numba.config
    before = config.CACHE_DIR
    config.CACHE_DIR = cache_folder() or before
    try:
        return numba.njit(cache=bool(cache_folder()), **OPTIONS, **more)(function)
    finally:
        config.CACHE_DIR = before


def inlined(function: F, *, fused: bool = True, **primitives: Any) -> F:
    """A function of numbers, compiled into the loops that call it; ``primitives`` replace globals of these names.

    Not ``fused``, it rounds as NumPy does.
    """
    if primitives:
        names = {**function.__globals__, **primitives}  # what NumPy does with arrays, numbers do in another way
        function = FunctionType(function.__code__, names, function.__name__)  # type: ignore[assignment]
    return numba.njit(forceinline=True, **OPTIONS, **(FUSED if fused else {}))(function)
