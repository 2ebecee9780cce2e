"""The harness of ``make prove-storage`` at a few points; the script takes every one of every operation."""

from __future__ import annotations

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
