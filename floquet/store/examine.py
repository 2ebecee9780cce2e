"""Look at all metadata of a file without a seal, in a child process: ``python -m floquet.store.examine FILE``."""

from __future__ import annotations

import sys

from .guard import answer
from .reading import File

__all__: list[str] = []

if __name__ == "__main__":

    def examine(beat: object) -> None:
        """Raise what is wrong with the file."""
        with File(sys.argv[1], examined=True) as file:
            file.examine(beat)  # type: ignore[arg-type]

    answer(examine, sys.argv[1])
