"""What is stored survives kills: ``make prove-storage``.

Random SIGKILLs of a local run, of the whole process or of one of its workers, each resumed; and of the workers of a
Dask cluster during one run.  The data must be those of a serial run.  Kills are seeded; exit status 1 if a digest
differs.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from floquet import cluster, store, study
from floquet.study import shards

KILLS, DASK_KILLS, SEED = 100, 20, 1431
STUDY = """
[study]
name = "proof"
schema = 1
[rotors]
grid = { lock_number = { start = 4.0, stop = 12.0, count = 20 }, hinge_offset = [0.0, 0.05] }
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 50 }
"""


def small_shards() -> None:
    """Some hundred shards of a small study."""
    shards.POINT_SHARD, shards.LIMIT_SHARD = (10, 10), (1, 1)


def run_here(file: Path, out: Path) -> None:
    """What is killed: a run of two processes, in a group of its own."""
    os.setpgid(0, 0)
    small_shards()
    study.run(study.load_study(file), out, resume=True, workers=2)


def children(pid: int) -> list[int]:
    """The workers of a run: processes that it has spawned, but not the keeper of semaphores."""
    found = []
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            with contextlib.suppress(OSError):
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(int(child))
    return found


def local(file: Path, folder: Path, kills: int, expected: str) -> bool:
    """Runs that are killed and resumed, with new outputs as they finish, until there were so many kills."""
    luck, done, wholes, finished, same = random.Random(SEED), 0, 0, 0, True
    context = multiprocessing.get_context("spawn")
    while done < kills:
        out = folder / f"local-{finished}.h5"
        run = context.Process(target=run_here, args=(file, out))
        run.start()
        assert run.pid is not None
        while done < kills and run.is_alive():
            run.join(luck.uniform(0.2, 4.0))
            workers = children(run.pid)
            if run.is_alive() and (luck.random() < 0.5 or not workers):
                run.kill()
                run.join()
                done, wholes = done + 1, wholes + 1
            elif workers:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(luck.choice(workers), signal.SIGKILL)
                    done += 1
        run.join()
        if out.exists():
            same &= store.verify(out) == () and store.data_digest(out) == expected
            finished += 1
    if not out.exists():
        study.run(study.load_study(file), out, resume=True)
        same &= store.verify(out) == () and store.data_digest(out) == expected
        finished += 1
    verdict = "equal" if same else "DIFFERENT"
    print(f"local: {wholes} runs and {done - wholes} workers killed, {finished} databases: {verdict}")
    return same


def on_dask(file: Path, folder: Path, kills: int, expected: str) -> bool:
    """One run whose workers are killed."""
    luck, out, killed = random.Random(SEED), folder / "dask.h5", set[int]()
    one = study.load_study(file)
    moments = set(luck.sample(range(1, study.dry_run(one).shards - 20), kills))

    def kill(done: int, total: int) -> None:
        if done in moments:
            time.sleep(luck.uniform(0.0, 0.1))
            while not (alive := [c.pid for c in multiprocessing.active_children() if c.pid and c.pid not in killed]):
                time.sleep(0.01)
            victim = luck.choice(sorted(alive))
            os.kill(victim, signal.SIGKILL)
            killed.add(victim)

    with cluster.dask(cluster.LOCAL, 2) as executor:
        report = study.run(one, out, executor=executor, progress=kill)
    same = not report.failed and store.verify(out) == () and store.data_digest(out) == expected
    print(f"Dask: {len(killed)} workers killed, {report.computed} shards: {'equal' if same else 'DIFFERENT'}")
    return same


def main(kills: int = KILLS, dask_kills: int = DASK_KILLS) -> int:
    small_shards()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (file := folder / "proof.toml").write_text(STUDY)
        study.run(study.load_study(file), folder / "serial.h5")
        expected = store.data_digest(folder / "serial.h5")
        same = [on_dask(file, folder, dask_kills, expected), local(file, folder, kills, expected)]
    return 0 if all(same) else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
