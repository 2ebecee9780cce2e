"""``python -m benchmarks [NAME ...]``: all tables, or those named."""

from __future__ import annotations

import importlib
import sys

from benchmarks import machine

TABLES = ("speed", "maps", "states", "roofline", "scaling", "startup", "study", "query")
PROGRAMS = (*TABLES, "truth")


def main(names: list[str]) -> int:
    """Pin, describe the machine, run."""
    unknown = [name for name in names if name not in PROGRAMS]
    if unknown:
        print(f"{unknown[0]!r} is no benchmark: there are {', '.join(PROGRAMS)}", file=sys.stderr)
        return 2
    machine.pin()
    if names != ["truth"]:
        print(f"{machine.describe()}\n", flush=True)
    for name in names or TABLES:
        importlib.import_module(f"benchmarks.{name}").main()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
