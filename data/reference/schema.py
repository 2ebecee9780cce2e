"""The example of a database that every later release must read: ``python data/reference/schema.py``.

Writes ``schema-MAJOR.MINOR.h5.xz``, in the schema of the code that runs it, and the same numbers without HDF5 as
``schema-MAJOR.MINOR.json.xz`` (floats in hexadecimal).  Two rotors with names, all columns, a chunk of each table.  A
release that changes the schema runs it once more and commits both files; those that are there are never made again.
"""

from __future__ import annotations

import json
import lzma
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from floquet import store, study
from floquet.studyfile import load_study

HERE = Path(__file__).parent
STUDY = """
[study]
name = "schema"
schema = 1
title = "An example of the schema"
[rotors]
list = [
    { name = "Bo 105", lock_number = 5.087, hinge_stiffness = 0.248 },
    { name = "two blades", lock_number = 6.0, hub = "teetering", blades = 2 },
]
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 6 }
[compare]
tolerances = [0.05]
"""


def plain(values: np.ndarray[Any, Any]) -> list[Any]:
    """Numbers as JSON keeps them to the bit."""
    if values.dtype.kind == "c":
        return [plain(values.real), plain(values.imag)]
    return [v.hex() if isinstance(v, float) else v for v in values.tolist()]


def main() -> int:
    """Make both files, unless they are there."""
    name = "schema-{}.{}".format(*store.SCHEMA)
    if (HERE / f"{name}.h5.xz").exists():
        print(f"{name} is there already")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        file, out = Path(folder) / "schema.toml", Path(folder) / f"{name}.h5"
        file.write_text(STUDY, encoding="utf-8")
        study.run(load_study(file), out)
        with store.open_file(out) as made:
            tables = {}
            for table in made.tables:
                [(_, rows)] = made.chunks(table, list(made.columns(table)))
                tables[table] = {column: plain(values) for column, values in rows.items()}
            document = {"tables": tables, "names": made.names, "study_id": made.attributes["study_id"]}
        for path, content in ((f"{name}.h5.xz", out.read_bytes()), (f"{name}.json.xz", json.dumps(document).encode())):
            (HERE / path).write_bytes(lzma.compress(content, preset=9))
            print(path, (HERE / path).stat().st_size, "bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
