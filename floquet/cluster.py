"""Shards on a Dask cluster: an executor whose workers may be on other machines.

:func:`dask` connects to a scheduler, or starts a cluster of processes here, and closes all at every way out.  What
Dask says of a task is put into the words of :mod:`concurrent.futures` and of this package: a task that ended its
workers is a :class:`~concurrent.futures.BrokenExecutor`, which says nothing of the others; a scheduler that is lost, or
workers without this package, are a :class:`~floquet.errors.FailedError`.

Dask makes a task again where its worker died.  It blames every task that was handed to the worker, also one that only
waited, so the caller tries a blamed task once more, alone.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import logging
import multiprocessing
import os
import pkgutil
import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from . import __version__
from .errors import FailedError, FloquetWarning, InputError, ParameterError

__all__ = ["LOCAL", "available", "dask"]

Value = TypeVar("Value")
LOCAL = "local"
CONNECT = 10.0  # seconds that a scheduler has to answer
CLOSE = 30.0  # seconds to close; Dask itself kills workers that go on for four
EVERY, STARTS, GIVES_UP = 1.0, 10, 120  # seconds; looks that a worker has to start, and a cluster to have one at all
INSTALL = f"give scheduler and workers this environment, with floquet-rotor {__version__}"
GO_ON = "finished shards are kept: go on with --resume"


def available() -> bool:
    """Whether Dask is installed."""
    return importlib.util.find_spec("distributed") is not None


@contextlib.contextmanager
def dask(where: str, workers: int = 1) -> Iterator[Executor]:
    """An executor on the scheduler at ``where`` (``tcp://host:port``), or on ``workers`` processes here (``local``)."""
    library = _library()
    with contextlib.ExitStack() as stack:
        stack.enter_context(_quiet())
        if where == LOCAL:
            stack.enter_context(_no_child_left())
            cluster = _local(library, workers)
            stack.callback(_closed, cluster)
            client = library.Client(cluster, timeout=CONNECT, set_as_default=False)
        else:
            client = _connected(library, where)
        stack.callback(_closed, client)
        _ready(client, where)
        if where == LOCAL:
            stack.enter_context(_staffed(cluster, client, workers))
        yield Tasks(client)


def _library() -> Any:
    """Dask, which is loaded only where it is asked for."""
    try:
        import distributed
        from distributed import core, scheduler  # noqa: F401
    except ImportError:
        raise InputError("--dask needs Dask: install floquet-rotor[distributed]") from None
    return distributed


def _local(library: Any, workers: int) -> Any:
    """Processes of one thread each; no dashboard, and no limit of memory but the system's.

    Ctrl-C is for this process: threads and processes that are begun with it blocked keep it so.
    """
    resource_tracker.ensure_running()  # where it begins, it unblocks
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return library.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # its server is there all the same: at any free port
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        )
    except (OSError, RuntimeError) as error:
        raise FailedError(f"a local Dask cluster of {workers} processes did not start ({error}): try fewer") from error
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _connected(library: Any, where: str) -> Any:
    """A client of a scheduler that answers within seconds."""

    async def knock() -> None:
        arguments = library.Security().get_connection_args("client")
        async with asyncio.timeout(CONNECT):  # what listens, but is no scheduler, says nothing
            await (await library.core.connect(where, timeout=CONNECT, **arguments)).close()

    try:
        asyncio.run(knock())  # a client that does not come about complains when it is collected
        client = library.Client(where, timeout=CONNECT, set_as_default=False)
    except ValueError as error:
        raise ParameterError(
            "dask", where, f"{where!r} is no address ({error}): give tcp://host:port of a scheduler, or {LOCAL}"
        ) from None
    except OSError as error:
        raise FailedError(
            f"no Dask scheduler answers at {where} within {CONNECT:g} s: check host and port, and that it runs"
        ) from error
    return client


def _ready(client: Any, where: str) -> None:
    """Wait for workers, and see that they have this package: without it the first task ends them."""
    if not client.scheduler_info()["workers"]:
        warnings.warn(f"the scheduler at {where} has no workers yet: waiting for some", FloquetWarning, stacklevel=4)
        client.wait_for_workers(1)
    for worker, found in client.run(pkgutil.resolve_name, f"{__name__}:LOCAL", on_error="return").items():
        if isinstance(found, Exception):
            raise FailedError(f"the Dask worker {worker} cannot take the work ({found}): {INSTALL}")


def _closed(opened: Any) -> None:
    """Close a client or a cluster, whatever has become of the other side."""
    with contextlib.suppress(Exception):
        opened.close(timeout=CLOSE)


@contextlib.contextmanager
def _staffed(cluster: Any, client: Any, workers: int) -> Iterator[None]:
    """Another thread that replaces workers which died while they started: Dask begins no other in their place.

    Where none can be started the client is closed, which ends what waits for its tasks.
    """
    done = threading.Event()

    def look() -> None:
        short = 0
        while not done.wait(EVERY):
            with contextlib.suppress(Exception):  # whatever becomes of the other side is told by the tasks
                there = len(client.nthreads())
                short = short + 1 if there < workers else 0
                if not there and short > GIVES_UP:
                    return _closed(client)
                if short and short % STARTS == 0:
                    cluster.scale(len(cluster.worker_spec) + workers - there)

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


@contextlib.contextmanager
def _no_child_left() -> Iterator[None]:
    """End processes that a cluster has begun and, in the time that it was given, not ended."""
    others = multiprocessing.active_children()
    try:
        yield
    finally:
        for child in multiprocessing.active_children():
            if child not in others:
                child.kill()
                child.join()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """What Dask logs is said by this package where it matters."""
    names = [n for n in logging.root.manager.loggerDict if n.split(".")[0] in ("distributed", "tornado", "asyncio")]
    before = {name: logging.getLogger(name).level for name in names}
    try:
        for name in names:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


class Tasks(Executor):
    """The executor of a client.  What tasks have as their first argument is sent once, and kept by the workers."""

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor(pure=False)
        self._first: tuple[Any, Any] = (None, None)

    def submit(self, function: Callable[..., Value], /, *given: Any, **named: Any) -> Future[Value]:
        if given and self._first[0] is not given[0]:
            self._first = given[0], self._client.submit(_itself, given[0], pure=False)
        sent = (self._first[1], *given[1:]) if given else ()
        outcome: Future[Value] = Future()
        outcome.set_running_or_notify_cancel()
        task = self._executor.submit(_single, function, *sent, **named)
        task.add_done_callback(lambda done: _hand_on(done, outcome))
        return outcome


def _itself(value: Value) -> Value:
    return value


def _single(function: Callable[..., Value], *given: Any, **named: Any) -> Value:
    """What a worker does: one thread a task, for it has as many tasks as it has threads; warnings are the client's."""
    warnings.simplefilter("ignore", FloquetWarning)
    os.environ["FLOQUET_THREADS"] = "1"
    return function(*given, **named)


def _hand_on(done: Future[Value], outcome: Future[Value]) -> None:
    """The end of a task, in the words of this package."""
    if done.cancelled():
        outcome.set_exception(FailedError(f"the Dask scheduler was lost, or took the work back; {GO_ON}"))
    elif (error := done.exception()) is None:
        outcome.set_result(done.result())
    elif isinstance(error, _library().scheduler.KilledWorker):
        outcome.set_exception(BrokenExecutor(str(error)))
    elif isinstance(error, ImportError) or "deserializ" in str(error):
        why = str(error).splitlines()[0].split(". ")[0]
        outcome.set_exception(FailedError(f"the Dask cluster cannot take the work ({why}): {INSTALL}; {GO_ON}"))
    else:
        outcome.set_exception(error)
