"""Studies on Dask: the same data whatever dies, every way out closed, every trouble one sentence."""

from __future__ import annotations

import ast
import contextlib
import multiprocessing
import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from floquet import cluster, store, study
from floquet.cli import main
from floquet.errors import FailedError, InputError, ParameterError
from floquet.rotor import Hub, Rotor
from floquet.study import shards, workers

ROOT = Path(__file__).resolve().parent.parent
dask = pytest.mark.skipif(
    not cluster.available(), reason="Dask is not installed: pip install 'floquet-rotor[distributed]'"
)

STUDY = """
[study]
name = "spread"
schema = 1
[rotors]
list = [
    { lock_number = 8.0, name = "eight" },
    { lock_number = 6.0, blades = 2, hub = "teetering", name = "two blades" },
]
[axes]
advance_ratio = { start = 0.0, stop = 1.0, count = 200 }
"""


@pytest.fixture
def spread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> study.Study:
    """400 points and two designs in 42 shards."""
    monkeypatch.setattr(shards, "POINT_SHARD", (10, 10))
    monkeypatch.setattr(shards, "LIMIT_SHARD", (1, 1))
    (tmp_path / "spread.toml").write_text(STUDY)
    return study.load_study(tmp_path / "spread.toml")


@pytest.fixture
def expected(spread: study.Study, tmp_path: Path) -> str:
    """The digest of the data of a serial run."""
    study.run(spread, tmp_path / "serial.h5")
    return store.data_digest(tmp_path / "serial.h5")


def _workers() -> list[Any]:
    return [child for child in multiprocessing.active_children() if "Dask" in child.name]


# ---------------------------------------------------------------------- Dask
@dask
def test_five_killed_workers_leave_the_data_as_they_are(spread: study.Study, expected: str, tmp_path: Path) -> None:
    """Each by SIGKILL, after a seeded number of shards and a seeded time."""
    luck, killed = random.Random(1431), set()
    moments = luck.sample(range(1, 36), 5)

    def kill(done: int, total: int) -> None:
        if done in moments:
            time.sleep(luck.uniform(0.0, 0.1))
            while not (alive := [child for child in _workers() if child.pid not in killed]):
                time.sleep(0.01)
            victim = luck.choice(sorted(alive, key=lambda child: child.pid))
            os.kill(victim.pid, signal.SIGKILL)
            killed.add(victim.pid)

    with cluster.dask("local", 2) as executor:
        report = study.run(spread, tmp_path / "out.h5", executor=executor, progress=kill)
    assert len(killed) == 5 and report.failed == () and report.computed == 42
    assert store.data_digest(tmp_path / "out.h5") == expected and store.verify(tmp_path / "out.h5") == ()
    assert not _workers()


def _deadly(plan: Any, shard: shards.Shard, parts: shards.Parts, engine: int) -> str:
    """What a worker does, but one shard ends it, and one cannot be."""
    if shard.name.startswith("points-000000000200"):
        os.kill(os.getpid(), signal.SIGKILL)
    if shard.name.startswith("points-000000000100"):
        raise InputError("this point cannot be")
    return workers.make_there(plan, shard, parts, engine)


@dask
def test_a_deadly_shard_is_given_up_and_the_others_are_made(
    spread: study.Study, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the failed ones are made by the next run, with the shards that there are."""
    out = tmp_path / "out.h5"
    with cluster.dask("local", 2) as executor:
        with monkeypatch.context() as patch:
            patch.setattr(workers, "make_there", _deadly)
            report = study.run(spread, out, executor=executor)
        reasons = {name[:19]: reason for name, reason in report.failed}
        assert reasons["points-000000000100"] == "this point cannot be" and len(reasons) == 2
        assert (
            "ended every worker of the executor" in reasons["points-000000000200"]
            and report.computed == 40
            and not out.exists()
        )
        again = study.run(spread, out, executor=executor, resume=True)
    assert (again.computed, again.reused) == (2, 40) and store.data_digest(out) == expected


@dask
@pytest.mark.parametrize("startable", [True, False])
def test_workers_that_die_while_they_start_are_replaced(monkeypatch: pytest.MonkeyPatch, startable: bool) -> None:
    """Dask restarts what was killed once, and no more if that is killed before it has begun."""
    never = 10**9
    for name, value in (("EVERY", 0.2), ("STARTS", never), ("GIVES_UP", never)):
        monkeypatch.setattr(cluster, name, value)
    with cluster.dask(cluster.LOCAL, 2) as executor:
        quiet = time.monotonic()
        while time.monotonic() < quiet + 3.0:
            for child in _workers():
                quiet = time.monotonic()
                with contextlib.suppress(ProcessLookupError, TypeError):
                    os.kill(child.pid, signal.SIGKILL)
            time.sleep(0.01)
        task = executor.submit(os.getpid)
        with pytest.raises(TimeoutError):
            task.result(timeout=1.0)
        if startable:
            monkeypatch.setattr(cluster, "STARTS", 5)
            assert task.result(timeout=60.0) != os.getpid()
        else:
            monkeypatch.setattr(cluster, "GIVES_UP", 1)
            with pytest.raises(FailedError, match="scheduler was lost"):
                task.result(timeout=60.0)


@dask
def test_workers_have_one_thread_a_task_and_share_the_first_argument() -> None:
    with cluster.dask("local", 1) as executor:
        rotor = Rotor(lock_number=6.0, blades=2, hub=Hub.TEETERING)
        assert executor.submit(_threads_and, rotor).result() == ("1", 6.0)
        assert executor.submit(_threads_and, rotor).result() == ("1", 6.0)
        with pytest.raises(ZeroDivisionError):
            executor.submit(divmod, 1, 0).result()
        [worker] = _workers()
    assert not worker.is_alive()


@dask
def test_a_busy_worker_is_ended_with_the_cluster() -> None:
    began = time.monotonic()
    with cluster.dask("local", 1) as executor:
        executor.submit(time.sleep, 60.0)
        time.sleep(1.0)
    assert not _workers() and time.monotonic() - began < 25.0


def _threads_and(rotor: Rotor) -> tuple[str, float]:
    return os.environ["FLOQUET_THREADS"], float(rotor.lock_number)


@dask
@pytest.mark.parametrize(("where", "error", "sentence"), [
    ("nonsense", ParameterError, "'nonsense' is no address .*tcp://host:port"),
    ("foo://here:1", ParameterError, "'foo://here:1' is no address .*tcp://host:port"),
    ("tcp://127.0.0.1:PORT", FailedError, "no Dask scheduler answers at tcp://127.0.0.1:.* within 1 s"),
])  # fmt: skip
def test_a_scheduler_that_is_not_there_is_one_sentence_in_seconds(
    where: str, error: type[Exception], sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    began = time.monotonic()
    with socket.socket() as silent:  # listens, and says nothing
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = where.replace("PORT", str(silent.getsockname()[1]))
        with pytest.raises(error, match=sentence) as caught, cluster.dask(address):
            pass
    assert "\n" not in str(caught.value) and time.monotonic() - began < 10.0


class Scheduler:
    """``dask scheduler`` in a process of its own, with workers in processes of theirs."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.begun: list[subprocess.Popen[bytes]] = []
        self.process = self.begin("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")

    def begin(self, what: str, *options: str, **environment: str) -> subprocess.Popen[bytes]:
        words = [sys.executable, *environment.pop("FLAGS", "").split(), "-m", f"distributed.cli.dask_{what}", *options]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path[1:]]), **environment}
        self.begun.append(subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL))
        return self.begun[-1]

    def worker(self, **environment: str) -> None:
        self.begin("worker", self.address, "--nthreads", "2", "--no-dashboard", "--no-nanny", **environment)


@pytest.fixture
def scheduler() -> Iterator[Scheduler]:
    one = Scheduler()
    yield one
    for process in reversed(one.begun):
        process.kill()
        process.wait()


def floquet(*arguments: str, cwd: Path, **options: Any) -> subprocess.Popen[str]:
    """``floquet …`` in a process group of its own, with SIGINT as a terminal gives it: jobs behind it have none."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path[1:]])}
    return subprocess.Popen(
        [sys.executable, "-m", "floquet", *arguments], cwd=cwd, env=environment, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL), **options,
    )  # fmt: skip


def _shards(folder: Path) -> int:
    return len([*folder.glob("points-*.h5"), *folder.glob("limits-*.h5")])


def _wait_for(shards: int, folder: Path) -> None:
    end = time.monotonic() + 60.0
    while _shards(folder) < shards:
        assert time.monotonic() < end, "no shard has come"
        time.sleep(0.01)


@dask
def test_a_scheduler_with_workers_from_elsewhere(
    spread: study.Study, expected: str, tmp_path: Path, scheduler: Scheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The output is named from here, the workers are elsewhere; when the scheduler is lost the shards are kept."""
    monkeypatch.chdir(tmp_path)
    waiting: list[str] = []
    monkeypatch.setattr(cluster.warnings, "warn", lambda text, *_, **__: (waiting.append(text), scheduler.worker()))

    def lose(done: int, total: int) -> None:
        if done == 10:
            scheduler.process.kill()

    with (
        pytest.raises(FailedError, match=r"scheduler was lost.*--resume"),
        cluster.dask(scheduler.address) as executor,
    ):
        study.run(spread, "out.h5", executor=executor, progress=lose)
    assert _shards(Path("out.h5.parts")) >= 10 and "has no workers yet: waiting" in waiting[0]
    assert study.run(spread, "out.h5", resume=True).reused >= 10 and store.data_digest("out.h5") == expected


@dask
@pytest.mark.filterwarnings("ignore:.* has no workers yet")
def test_workers_without_this_package_are_one_sentence(scheduler: Scheduler, tmp_path: Path) -> None:
    blind = tmp_path / "sitecustomize.py"
    blind.write_text("import sys\nsys.modules['floquet'] = None\n")
    scheduler.worker(PYTHONPATH=os.pathsep.join([str(tmp_path), *sys.path[1:]]))
    with (
        pytest.raises(FailedError, match=r"worker tcp://.* cannot take the work .*floquet-rotor \d"),
        cluster.dask(scheduler.address),
    ):
        pass


LARGE = STUDY.replace("[axes]", "grid = { lock_number = { start = 4, stop = 12, count = 3000 } }\n[axes]")


@dask
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_an_interrupted_run_leaves_its_shards_and_no_process(tmp_path: Path, how: signal.Signals) -> None:
    """Ctrl-C goes to all processes of the terminal, and is one sentence."""
    (tmp_path / "large.toml").write_text(LARGE)
    command = ("run", "large.toml", "-o", "out.h5", "--dask", "local", "--workers", "2")
    run = floquet(*command, cwd=tmp_path)
    _wait_for(3, tmp_path / "out.h5.parts")
    if how == signal.SIGINT:
        os.killpg(run.pid, how)
    else:
        run.kill()
    out, said = run.communicate(timeout=30)  # the pipes end when no process holds them any more
    assert out == "" and _shards(tmp_path / "out.h5.parts") >= 3
    if how == signal.SIGINT:
        assert run.returncode == 130 and "Traceback" not in said and "go on with --resume" in said


@dask
def test_the_command_line_runs_on_dask_and_says_what_it_cannot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 2.0)
    (tmp_path / "spread.toml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    another = contextlib.ExitStack()
    with contextlib.suppress(OSError):  # has the port already
        another.enter_context(socket.create_server(("", 8787)))
    for command, status, words in (
        ("-o a.h5 --dask local --workers 2", 0, ""),
        ("-o a.h5 --dask local --workers 1", 2, "a.h5 is there already"),
        ("-o b.h5 --dask nonsense", 2, "'nonsense' is no address"),
        ("-o b.h5 --dask tcp://127.0.0.1:9", 1, "no Dask scheduler answers"),
        ("-o b.h5 --dask tcp://127.0.0.1:9 --workers 2", 2, "--workers goes with --dask local"),
    ):
        with pytest.raises(SystemExit) as end:
            main(["run", "spread.toml", *command.split()])
        out, said = capsys.readouterr()
        said = "\n".join(line for line in said.splitlines() if not line.startswith("spread, parts:"))
        assert end.value.code == status and words in said and bool(out) == (status == 0), said
        assert len(said.splitlines()) == (status > 0) and not _workers()
    another.close()
    study.run(study.load_study("spread.toml"), "serial.h5")
    assert store.data_digest("a.h5") == store.data_digest("serial.h5") and not Path("b.h5.parts").exists()


def test_without_dask_it_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"install floquet-rotor\[distributed\]"), cluster.dask("local"):
        pass


# ---------------------------------------------------------------------- any executor
class Elsewhere(ThreadPoolExecutor):
    """Workers whose folder is another one."""

    def __init__(self, folder: Path) -> None:
        super().__init__(1)
        self.folder = folder

    def submit(self, function: Any, plan: Any, shard: Any, parts: Any, *others: Any) -> Future[Any]:  # type: ignore[override]
        assert parts.folder.is_absolute()
        return super().submit(function, plan, shard, shards.Parts(self.folder, *_but_folder(parts)), *others)


def _but_folder(parts: shards.Parts) -> tuple[str, tuple[str, ...]]:
    return parts.study_id, parts.columns


@pytest.mark.parametrize(("there", "sentence"), [
    (False, "does not see .*elsewhere: write to a folder that all workers share; finished"),
    (True, r"has written limits-.*\.h5, and it is not in .*out\.h5\.parts here: write to a folder that all workers"),
])  # fmt: skip
def test_workers_that_do_not_see_the_folder_end_the_run(
    spread: study.Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, there: bool, sentence: str
) -> None:
    monkeypatch.setattr(workers, "PATIENCE", 0.2)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    if there:
        (elsewhere / "study.json").write_text("")
    with Elsewhere(elsewhere) as executor, pytest.raises(FailedError, match=sentence):
        study.run(spread, tmp_path / "out.h5", executor=executor)


def test_a_shared_folder_may_show_a_shard_late(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Path] = []
    monkeypatch.setattr(Path, "exists", lambda path: (asked.append(path), len(asked) > 3)[1])
    assert workers.appears(tmp_path / "late.h5") and len(asked) == 4


def test_workers_of_another_engine_are_refused(spread: study.Study, tmp_path: Path) -> None:
    parts, shard = shards.Parts(tmp_path, spread.id, spread.columns), shards.Shard("points", 0, 10)
    with pytest.raises(FailedError, match="another version of floquet"):
        workers.make_there(spread.plan, shard, parts, workers.ENGINE + 1)


class Dying(Executor):
    """Every task ends its worker."""

    def submit(self, function: Any, /, *given: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_exception(BrokenExecutor("killed"))
        return future


def test_an_executor_whose_workers_all_die_ends_the_run(spread: study.Study, tmp_path: Path) -> None:
    with pytest.raises(FailedError, match=r"dies at once.*--resume"):
        study.run(spread, tmp_path / "out.h5", executor=Dying())


# ---------------------------------------------------------------------- the page
def test_the_scripts_of_the_page_are_scripts(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "running.md").read_text(encoding="utf-8")
    scripts = [block.split("```")[0] for block in page.split("```py\n")[1:]]
    assert scripts
    for script in scripts:
        called = {node.attr for node in ast.walk(ast.parse(script)) if isinstance(node, ast.Attribute)}
        assert {"load_study", "run", "dask"} <= called | {
            alias.name
            for node in ast.walk(ast.parse(script))
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
    for i, block in enumerate(page.split("```bash\n")[1:]):
        (tmp_path / f"{i}.sh").write_text(block.split("```")[0])
        subprocess.run(["bash", "-n", str(tmp_path / f"{i}.sh")], check=True)
