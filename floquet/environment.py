"""What the environment says about the engine: ``FLOQUET_THREADS`` and ``FLOQUET_NO_NUMBA``.

The kernels read both, and know no sentences; here they are checked, at the doors of the package, before any work.
"""

from __future__ import annotations

import os

from .errors import ParameterError

__all__ = ["check_environment"]

WORDS = {"": "0", "0": "0", "no": "0", "false": "0", "off": "0", "1": "1", "yes": "1", "true": "1", "on": "1"}


def check_environment() -> None:
    """A :class:`~floquet.errors.ParameterError` for a setting that means nothing; words become 0 and 1."""
    threads = os.environ.get("FLOQUET_THREADS", "")
    if threads and not (threads.isascii() and threads.isdigit() and int(threads) > 0):
        raise ParameterError(
            "FLOQUET_THREADS",
            threads,
            f"{threads!r} in the environment is no number of threads: give a whole number from 1, or unset it for "
            "all cores",
        )
    plain = os.environ.get("FLOQUET_NO_NUMBA", "0")
    if (word := WORDS.get(plain.strip().lower())) is None:
        raise ParameterError(
            "FLOQUET_NO_NUMBA",
            plain,
            f"{plain!r} in the environment is neither yes nor no: give 1 to leave all to NumPy, 0 or nothing for "
            "compiled kernels",
        )
    if word != plain:
        os.environ["FLOQUET_NO_NUMBA"] = word  # as the kernels, and worker processes, read it
