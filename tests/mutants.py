"""Break the code on purpose: every mutant must fail the tests named beside it (``make mutants``).

A mutant is one replacement in one file.  It is made in a temporary copy of the tree, never in place; its old text must
stand there exactly once, so that a mutant cannot go stale unnoticed.  Exit status 1 if a mutant survives, does not
apply, or if its tests fail without it.  ``python tests/mutants.py WORD…`` runs the mutants that contain a word.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.faults import FAULTS, Mutant  # noqa: E402
from tests.faults_files import FILES  # noqa: E402
from tests.faults_modes import MODES  # noqa: E402
from tests.faults_query import QUERIES  # noqa: E402

LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "results", "__pycache__", ".*_cache", ".hypothesis", "dist", "build")


REPORT, JUDGED, JSON = "floquet/report.py", "floquet/judgement.py", "floquet/plain.py"
LAYERS, ASKED = "tests/test_layers.py", "tests/test_cli.py"
AT_EDGES, DRAWN = "floquet/plot/at_edges.py", "tests/test_plot.py -k errors"
OTHERS: tuple[Mutant, ...] = (
    Mutant("module for function", "floquet/__init__.py", "value = value.sweep", "pass", LAYERS),
    Mutant("no line in an error", "floquet/errors.py", '}:{p.line}" if p.line', '}" if p.line', ASKED),
    Mutant("NumPy for --help", "floquet/cli/options.py", "\nimport click\n", "\nimport click, numpy\n", LAYERS),
    Mutant(
        "failed parts are done", "floquet/cli/databases.py", "return 3 if finished.failed else 0", "return 0", ASKED
    ),
    Mutant("damage is done", "floquet/cli/databases.py", "return fail(str(error), 1)\n    return 0", "return 0", ASKED),
    Mutant("no room is bad input", "floquet/cli/ending.py", "1 if isinstance(error, FailedError) else 2", "2", ASKED),
    Mutant("limits of other rotors", JUDGED, "(1.0 - CHANGE, 1.0 + CHANGE)", "(1.0 + CHANGE, 1.0 - CHANGE)", ASKED),
    Mutant("a warning for every call", "floquet/cli/ending.py", "said.add(text)", "pass", ASKED),
    Mutant("teetering with four blades", "floquet/cli/rotors.py", 'changes.setdefault("blades", 2)', "pass", ASKED),
    Mutant(
        "flags forgotten", "floquet/cli/rotors.py", "load_rotor(file).replace(**changes)", "load_rotor(file)", ASKED
    ),
    Mutant("a flag that is off counts", "floquet/cli/rotors.py", " and values[name] is not False}", "}", ASKED),
    Mutant(
        "closed pipe fails",
        "floquet/cli/talk.py",
        "raise click.exceptions.Exit(0)",
        "raise click.exceptions.Exit(1)",
        ASKED,
    ),
    Mutant("talk every 100 s", "floquet/cli/talk.py", "- last >= 10.0", "- last >= 100.0", ASKED),
    Mutant(
        "nan in JSON", JSON, "return None if math.isnan(value) else", "return value if math.isnan(value) else", ASKED
    ),
    Mutant("inf is null", JSON, '"inf" if value > 0', "None if value > 0", ASKED),
    Mutant("doubling for halving", REPORT, "-math.log(2.0) / (sigma", "math.log(2.0) / (sigma", ASKED),
    Mutant("the mean decays", REPORT, "math.nan if mode.rule == Rule.MEAN else", "", ASKED),
    Mutant("Hz without 2π", REPORT, "rotor_speed / math.tau for s", "rotor_speed for s", ASKED),
    Mutant("miles for knots", JUDGED, "KNOT = 1852.0", "KNOT = 1609.0", ASKED),
    Mutant(
        "valid above tolerance", JUDGED, "valid = error <= limit.tolerance", "valid = error > limit.tolerance", ASKED
    ),
    Mutant("advice that fails", JUDGED, "if e <= limit.tolerance), 0)", "), 0)", ASKED),
    Mutant(
        "m held while ε is moved", JUDGED, "and rotor.offset_mass_derived else [name]", "and False else [name]", ASKED
    ),
    Mutant("no changed cause", JUDGED, "_briefly(there) != _briefly(limit)", "False", ASKED),
    Mutant("a small move is told", JUDGED, "STILL = 0.005", "STILL = 0.0", ASKED),
    Mutant("a limit's cause at another place", JUDGED, "{_briefly(limit)}", "by drift", ASKED),
    Mutant("spikes cut off", AT_EDGES, "if more.size:", "if False:", DRAWN),
    Mutant("one side of an edge", AT_EDGES, "for way in ways]", "for way in ways[:1]]", DRAWN),
    Mutant(
        "rows of other physics believed",
        AT_EDGES,
        "if rotor is None or not _reproduced(rotor, mu, error, options):",
        "if rotor is None:",
        DRAWN,
    ),
    Mutant(
        "splits where there are none", AT_EDGES, "(np.abs(roots.imag) < REAL)", "(np.abs(roots.imag) > REAL)", DRAWN
    ),
    Mutant(
        "the study's physics not drawn",
        "floquet/plot/__init__.py",
        '{"options": _options(options)}',
        '{"options": {}}',
        DRAWN,
    ),
    Mutant(
        "a share's line beside its dots",
        "floquet/plot/atlas.py",
        "(1.0 - share) * len",
        "share * len",
        "tests/test_plot.py -k atlas",
    ),
    Mutant(
        "equal designs counted twice",
        "floquet/plot/__init__.py",
        'limits["rotor"], limits["rotor"][first][again]',
        'limits["rotor"], []',
        "tests/test_plot.py -k atlas",
    ),
    Mutant(
        "designs of other numbers of blades are equal",
        "floquet/sweep.py",
        "np.column_stack([hubs, blades, *",
        "np.column_stack([*",
        "tests/test_study.py -k twice",
    ),
    Mutant("another tolerance's limits", REPORT, 'if r["tolerance"] == tolerance and', "if", ASKED),
    Mutant("inflow not mentioned", REPORT, "{LEGEND}\\n{NO_INFLOW}", "{LEGEND}", ASKED),
)
MUTANTS = (*FAULTS, *MODES, *FILES, *QUERIES, *OTHERS)


def run(tree: Path, tests: str) -> subprocess.CompletedProcess[str]:
    """pytest in a tree, on the tree's own package, up to the first failure."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests.split()]
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True)


def try_mutant(tree: Path, mutant: Mutant) -> str:
    """``killed``, or why it was not."""
    path = tree / mutant.file
    original = path.read_text(encoding="utf-8") if path.exists() else ""
    if (count := original.count(mutant.old)) != 1:
        return f"STALE: the old text stands {count} times in the file"
    path.write_text(original.replace(mutant.old, mutant.new), encoding="utf-8")
    try:
        status = run(tree, mutant.tests).returncode
    finally:
        path.write_text(original, encoding="utf-8")
    return {0: "SURVIVED", 1: "killed", 2: "killed"}.get(status, f"STALE: pytest ended with {status}")


def main(words: Sequence[str]) -> int:
    """Run the mutants that contain one of the words (all without words) and print a table."""
    chosen = [m for m in MUTANTS if not words or any(word in " ".join(m) for word in words)]
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=LEFT_OUT)
        for tests in sorted({m.tests for m in chosen}):
            if (sound := run(tree, tests)).returncode:
                print(sound.stdout, f"the tests fail without any mutant: {tests}", sep="\n")
                return 1
        alive = 0
        for mutant in chosen:
            verdict = try_mutant(tree, mutant)
            alive += verdict != "killed"
            print(f"{verdict:<9} {mutant.file:<32} {mutant.what:<46} {mutant.tests}", flush=True)
    print(f"{len(chosen) - alive} of {len(chosen)} mutants killed")
    return int(alive > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
