"""SIGKILLs at random moments, seeded: of runs in one process, of runs and of their worker processes, of Dask workers.

A killed run is resumed, and killed again, until there is a database; its data must be those of a serial run.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import random
import signal
import tempfile
import time
from collections.abc import Callable
from multiprocessing.context import ForkProcess as Process
from pathlib import Path

from floquet import cluster, store, study
from floquet.study import shards as cut

__all__ = ["DASK_KILLS", "KILLS", "main"]

KILLS, DASK_KILLS, SEED = 480, 20, 1431
STUDY = """
[study]
name = "proof"
schema = 1
[rotors]
grid = { lock_number = { start = 4.0, stop = 12.0, count = 10 } }
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 50 }
[output]
columns = ["verdict"]
"""


class Kills:
    """One study, killed in several ways, and what it must give."""

    def __init__(self, folder: Path) -> None:
        cut.POINT_SHARD, cut.LIMIT_SHARD = (10, 10), (1, 1)  # sixty shards of a small study
        self.folder, self.luck = folder, random.Random(SEED)
        (folder / "proof.toml").write_text(STUDY)
        self.study = study.load_study(folder / "proof.toml")
        study.run(self.study, folder / "serial.h5")
        self.expected = store.data_digest(folder / "serial.h5")

    def same(self, out: Path) -> bool:
        """Whether a database has the data of the serial run, and nothing is left beside it."""
        left = study.parts_of(out).exists() or [*out.parent.glob(f".{out.name}.*")]
        return not left and store.verify(out) == () and store.data_digest(out) == self.expected

    def resumed(self, name: str, workers: int, kills: int, kill: Callable[[Process], bool]) -> bool:
        """Runs, each forked, as long as ``kill`` has not killed so often; it says whether it did."""
        context, done, wrong, finished = multiprocessing.get_context("fork"), 0, 0, 0
        while done < kills:
            out = self.folder / f"{name}-{finished}.h5"
            run = context.Process(target=study.run, args=(self.study, out), kwargs={"resume": True, "workers": workers})
            run.start()
            while done < kills and run.is_alive():
                self.wait(out, run.join)
                done += run.is_alive() and kill(run)
            run.join()
            if run.exitcode == 0 or done == kills:
                study.run(self.study, out, resume=True)
                wrong, finished = wrong + (not self.same(out)), finished + 1
        print(f"{name}: {done} kills, {finished} databases, {wrong} different", flush=True)
        return not wrong

    def wait(self, out: Path, join: Callable[[float], None]) -> None:
        """For a random time, every other time from when there is another shard."""
        before, end = shards(out), time.monotonic() + 10.0
        if self.luck.random() < 0.5:
            while shards(out) == before and time.monotonic() < end:
                join(0.001)
        join(self.luck.uniform(0.0, 0.5))

    def whole(self, run: Process) -> bool:
        """Kill a run, if it does not end before."""
        run.kill()
        run.join()
        return run.exitcode == -signal.SIGKILL

    def any_of(self, run: Process) -> bool:
        """Kill a run or one of its workers."""
        found = workers_of(run.pid or 0)
        if not found or self.luck.random() < 0.3:
            return self.whole(run)
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.luck.choice(found), signal.SIGKILL)
            return True
        return False

    def on_dask(self, kills: int) -> bool:
        """One run whose workers are killed."""
        out, killed = self.folder / "dask.h5", set[int]()
        moments = set(self.luck.sample(range(1, study.dry_run(self.study).shards - 10), kills))

        def kill(done: int, total: int) -> None:
            if done in moments:
                time.sleep(self.luck.uniform(0.0, 0.1))
                while not (
                    alive := [c.pid for c in multiprocessing.active_children() if c.pid and c.pid not in killed]
                ):
                    time.sleep(0.01)
                victim = self.luck.choice(sorted(alive))
                os.kill(victim, signal.SIGKILL)
                killed.add(victim)

        with cluster.dask(cluster.LOCAL, 2) as executor:
            report = study.run(self.study, out, executor=executor, progress=kill)
        same = not report.failed and self.same(out)
        print(f"Dask workers: {len(killed)} kills, 1 database, {int(not same)} different", flush=True)
        return same


def shards(out: Path) -> int:
    """How many there are."""
    with contextlib.suppress(OSError):
        return sum(name.endswith(".h5") for name in os.listdir(study.parts_of(out)))
    return 0


def workers_of(pid: int) -> list[int]:
    """The workers of a run: processes that it has spawned, but not the keeper of semaphores."""
    found = []
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            with contextlib.suppress(OSError):
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(int(child))
    return found


def main(kills: int = KILLS, dask_kills: int = DASK_KILLS) -> list[bool]:
    """Half the kills are of runs in one process."""
    os.environ["FLOQUET_THREADS"] = "1"  # what is forked has no other threads
    os.environ["PYTHONWARNINGS"] = "ignore::UserWarning:multiprocessing.resource_tracker"  # of runs that are killed
    with tempfile.TemporaryDirectory(prefix="proof-") as name:
        one = Kills(Path(name))
        same = [one.resumed("one process", 1, kills // 2, one.whole)] if kills else []
        same += [one.resumed("two workers", 2, kills - kills // 2, one.any_of)] if kills else []
        if dask_kills and cluster.available():
            same.append(one.on_dask(dask_kills))
        elif dask_kills:
            print("Dask workers: 0 kills: SKIPPED (Dask is not installed)", flush=True)
        return same
