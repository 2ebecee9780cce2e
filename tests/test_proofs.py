"""The proofs of the Makefile at a few points, so that they work when they are wanted; the scripts take every one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.proofs import tracing
from tests.proofs.disturbed import FAILURES, KILL, Disturbance, disturb

WHY = tracing.untraceable()


@pytest.mark.skipif(bool(WHY), reason=f"no system call can be disturbed: {WHY}")
@pytest.mark.parametrize(("operation", "disturbance"), [("resume", KILL), ("merge", KILL), ("pack", FAILURES[1])])
def test_what_is_saved_survives(operation: str, disturbance: Disturbance) -> None:
    outcomes = disturb(operation, disturbance, jobs=1, at_most=4)
    assert len(outcomes) == 4
    assert [(o.point, o.unclear, o.lost, o.different) for o in outcomes if o.unclear or o.lost or o.different] == []


@pytest.mark.parametrize(("module", "counts", "words"), [
    ("prove_input", ("400", "40"), ("grown: right", "0 failed")),
    ("prove_files", ("80", "1"), ("0 wrong values",)),
])  # fmt: skip
def test_other_proofs_work(module: str, counts: tuple[str, str], words: tuple[str, ...]) -> None:
    command = [sys.executable, "-m", f"tests.{module}", *counts]
    done = subprocess.run(command, cwd=Path(__file__).parent.parent, capture_output=True, text=True)
    assert done.returncode == 0 and all(word in done.stdout for word in words), done.stdout + done.stderr
