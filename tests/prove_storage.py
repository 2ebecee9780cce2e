"""What is stored survives kills, full disks and failing ones: ``make prove-storage``.

One counted line a part; exit status 1 if anything was lost, or differs, or was not said.  Where strace is missing, or
may not trace, the parts that need it are left out, and said to be.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from tests.proofs import random_kills, tracing
from tests.proofs.disturbed import FAILURES, KILL, Outcome, disturb
from tests.proofs.operations import OPERATIONS

SHOWN = 5  # of what went wrong a part


def killed(operation: str, jobs: int, at_most: int) -> bool:
    """A kill at every call."""
    outcomes = disturb(operation, KILL, jobs, at_most)
    return _told(f"{operation}: {len(outcomes)} kill points", ("lost", "different"), outcomes)


def failing(operation: str, jobs: int, at_most: int) -> bool:
    """ENOSPC and EIO at every call."""
    outcomes = [outcome for failure in FAILURES for outcome in disturb(operation, failure, jobs, at_most)]
    what = f"{operation}: {len(outcomes)} failures ({', '.join(f.name for f in FAILURES)})"
    return _told(what, ("unclear", "lost", "different"), outcomes)


def _told(what: str, kinds: Sequence[str], outcomes: Sequence[Outcome]) -> bool:
    counts = {kind: sum(bool(getattr(o, kind)) for o in outcomes) for kind in kinds}
    print(f"{what}, {', '.join(f'{count} {kind}' for kind, count in counts.items())}", flush=True)
    wrong = [o for o in outcomes if o.lost or o.different or o.unclear]
    for o in wrong[:SHOWN]:
        print(f"  {o.point}\n    {'; '.join(filter(None, (o.unclear, o.lost, o.different)))}", file=sys.stderr)
    return bool(outcomes) and not wrong


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.prove_storage", description=__doc__)
    parser.add_argument("--kills", type=int, default=random_kills.KILLS, help="random kills of local runs")
    parser.add_argument("--dask-kills", type=int, default=random_kills.DASK_KILLS, help="random kills of Dask workers")
    parser.add_argument("--points", type=int, default=0, help="at most so many calls an operation (0: every one)")
    parser.add_argument("--operations", nargs="*", default=list(OPERATIONS), choices=list(OPERATIONS))
    parser.add_argument("--jobs", type=int, default=2, help="processes that inject")
    given = parser.parse_args(arguments)
    same = []
    if given.operations and (why := tracing.untraceable()):
        print(f"NOT PROVED: kills and failures at every system call, for {why}", file=sys.stderr)
        print("run, resume, pack, merge: 0 kill points, 0 failures: SKIPPED (no injection here)", flush=True)
    else:
        same += [part(name, given.jobs, given.points) for part in (killed, failing) for name in given.operations]
    same += random_kills.main(given.kills, given.dask_kills)
    return 0 if all(same) else 1


if __name__ == "__main__":
    sys.exit(main())
