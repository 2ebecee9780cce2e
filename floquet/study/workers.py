"""Shards computed here, by a pool of processes, or by an executor whose workers may be on other machines.

A pool of processes whose worker dies is made anew; a shard that ends three workers is given up and reported.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import multiprocessing
import os
import platform
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, as_completed
from pathlib import Path

from ..comparison import exact_model, warn_of_few_blades
from ..errors import FailedError, FloquetWarning, InputError
from ..sweep import ENGINE, Plan
from .shards import Parts, Shard, make

LIVES = 3  # worker processes that a shard may end before it is given up
GO_ON = "finished shards are kept: go on with --resume and fewer --workers"
ALL_DIE = f"every worker process dies at once, perhaps for want of memory; {GO_ON}"
SHARED = "write to a folder that all workers share; finished shards are kept"
PATIENCE = 20.0  # seconds that a shared folder has to show a file


def compute(
    plan: Plan,
    parts: Parts,
    todo: Sequence[Shard],
    workers: int,
    executor: Executor | None,
    count: Callable[[Shard], None],
) -> list[tuple[str, str]]:
    """Make the shards; the names of those that failed, with reasons."""
    failed: list[tuple[str, str]] = []
    with contextlib.closing(_results(plan, parts, todo, workers, executor)) as results:
        for shard, result in results:
            try:
                result()
            except InputError as error:
                failed.append((shard.file, str(error)))
            except (ValueError, ArithmeticError) as error:  # NumPy's and SciPy's, LinAlgError is a ValueError
                failed.append((shard.file, f"the computation failed ({type(error).__name__}: {error})"))
            except BrokenExecutor as error:
                raise FailedError(f"a worker process died, perhaps for want of memory; {GO_ON}") from error
            count(shard)
    return failed


Results = Generator[tuple[Shard, Callable[[], str]], None, None]


def _results(plan: Plan, parts: Parts, todo: Sequence[Shard], workers: int, executor: Executor | None) -> Results:
    """Each shard as it is done (or, in this process, to be done), with what gives its result or raises."""
    if executor is not None:
        yield from _handed_out(plan, parts, todo, executor)
    elif workers == 1 or len(todo) < 2:
        for shard in todo:
            yield shard, functools.partial(make, plan, shard, parts)
    else:
        yield from _pooled(plan, parts, todo, workers)


def _handed_out(plan: Plan, parts: Parts, todo: Sequence[Shard], executor: Executor) -> Results:
    """Shards from an executor.

    One that ended its worker, or was handed to one that died, is made once more when all others are done, alone.
    """
    _warn(plan)
    parts = dataclasses.replace(parts, folder=parts.folder.absolute())
    lost: list[Shard] = []
    futures = {executor.submit(make_there, plan, shard, parts, ENGINE): shard for shard in todo}
    try:
        for future in as_completed(futures):
            if isinstance(future.exception(), BrokenExecutor):
                lost.append(futures[future])
                if len(lost) > LIVES and len(lost) == sum(f.done() for f in futures):
                    raise FailedError(ALL_DIE)
            else:
                yield futures[future], functools.partial(_arrived, future, parts)
    finally:
        for future in futures:
            future.cancel()
    dead = 0
    for shard in lost:
        future = executor.submit(make_there, plan, shard, parts, ENGINE)
        died = isinstance(future.exception(), BrokenExecutor)
        dead += died
        if dead > 1 and dead == len(todo) - len(lost) + dead:  # and nothing else came of the others
            raise FailedError(ALL_DIE)
        yield shard, _ended_there if died else functools.partial(_arrived, future, parts)


def make_there(plan: Plan, shard: Shard, parts: Parts, engine: int) -> str:
    """Compute a shard and write it: what a worker does that may be on another machine."""
    if engine != ENGINE:
        raise FailedError(
            f"{platform.node()} has another version of floquet (engine {ENGINE}, here {engine}): install the same; "
            "finished shards are kept"
        )
    if not appears(parts.folder / "study.json"):
        raise FailedError(f"{platform.node()} does not see {parts.folder}: {SHARED}")
    return make(plan, shard, parts)


def _arrived(future: Future[str], parts: Parts) -> str:
    """The file that a worker has written; it must be seen here, too."""
    name = future.result()
    if not appears(parts.folder / name):
        raise FailedError(f"a worker has written {name}, and it is not in {parts.folder} here: {SHARED}")
    return name


def appears(path: Path) -> bool:
    """Whether a file is there; a shared folder may show it late, and sooner if it is listed."""
    end = time.monotonic() + PATIENCE
    while not path.exists():
        if time.monotonic() > end:
            return False
        with contextlib.suppress(OSError):
            os.listdir(path.parent)
        time.sleep(0.1)
    return True


def _warn(plan: Plan) -> None:
    """What workers do not say."""
    for rotor in plan.rotors:
        warn_of_few_blades(rotor, exact_model(rotor, plan.model), stacklevel=3)


def _pooled(plan: Plan, parts: Parts, todo: Sequence[Shard], workers: int) -> Results:
    """Shards from a pool of processes that is made anew when a worker dies.

    Nobody says which shard the dead worker had, but shards are handed out in order: it was one of the first that are
    not done.  These are made alone, so that a shard that ends its worker again has only itself to blame.
    """
    _warn(plan)
    left, lost = list(todo), 0
    while left:
        with contextlib.suppress(BrokenExecutor), processes(workers) as pool:
            futures = {pool.submit(make, plan, shard, parts): shard for shard in left}
            for future in as_completed(futures):
                if isinstance(error := future.exception(), BrokenExecutor):
                    raise error
                left.remove(futures[future])
                yield futures[future], future.result
        for shard in left[: 2 * workers + 1]:
            result = _alone(plan, parts, shard)
            lost += result is None
            if lost > 1 and lost == len(todo) - len(left) + 1:  # and nothing else came of the others
                raise FailedError(ALL_DIE)
            left.remove(shard)
            yield shard, result or _given_up


def _alone(plan: Plan, parts: Parts, shard: Shard) -> Callable[[], str] | None:
    """A shard from a process of its own; None if it ends every one that it is given."""
    for _ in range(LIVES):
        with contextlib.suppress(BrokenExecutor), processes(1) as pool:
            future = pool.submit(make, plan, shard, parts)
            if isinstance(error := future.exception(), BrokenExecutor):
                raise error
            return future.result
    return None


def _ended_there() -> str:
    raise InputError(
        "it ended every worker of the executor that it was given, perhaps for want of memory: give workers more, or "
        "try it with --workers 1"
    )


def _given_up() -> str:
    raise InputError(f"it ended {LIVES} worker processes, perhaps for want of memory: try it with --workers 1")


@contextlib.contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Fresh processes, ended at once by any exception: what they write is there whole or not at all."""
    others = multiprocessing.active_children()
    spawned = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawned, initializer=_begin_worker) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():
                if child not in others:
                    child.terminate()
            raise


def _begin_worker() -> None:
    """One thread a worker, none that outlives its parent and waits for work forever; warnings are its parent's."""
    warnings.simplefilter("ignore", FloquetWarning)
    os.environ["FLOQUET_THREADS"] = "1"  # whatever it was: there are workers for the cores

    def watch() -> None:
        if (parent := multiprocessing.parent_process()) is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
