"""Distribution of tasks to workers by dask, on a local or an existing cluster.

A chunk is a list of numbered tasks. A worker solves it by the method `solver.solve` of a plugin, which returns a row for each task.
"""

import shlex
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import cloudpickle
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, WorkerPlugin, as_completed, get_worker

import pushbelt.fmu
from pushbelt import arguments, errors
from pushbelt.console import starting_processes
from pushbelt.errors import PushbeltError
from pushbelt.fmu.unit import Archive

Chunk = Sequence[tuple[int, Any]]  # Numbered tasks that a worker solves together
Rows = list[tuple[int, dict[str, Any]]]  # Their numbers and results

CONNECT_TIMEOUT = 10.0  # Timeout for the connection to a scheduler, s
WORKERS_TIMEOUT = 60.0  # Timeout for the first worker of a cluster, s
QUEUE_TIMEOUT = 7 * 86400.0  # Timeout for the first worker of a given cluster, whose jobs may wait in a queue, s
WORKER_LOST = "the worker process crashed repeatedly"
CLOSING = 120  # Time before the end of a job at which its worker closes and passes its points on, s
REPEATED = {"directive": "job_extra_directives", "prologue": "job_script_prologue"}


class ClusterError(PushbeltError, RuntimeError):
    """The cluster cannot be reached, or the connection is lost."""


@contextmanager
def connect(scheduler: Any = None, workers: int | None = None) -> Iterator[Client]:
    """A client of the scheduler at an address such as `tcp://host:port`, of a cluster of dask, or of a new local
    cluster of processes. Raises ClusterError if there is no worker within the timeout."""
    with ExitStack() as stack:
        try:
            timeout = WORKERS_TIMEOUT if scheduler is None or isinstance(scheduler, str) else QUEUE_TIMEOUT
            if scheduler is None:
                # A worker in the midst of a heartbeat logs the end of its scheduler as an error, and what it can't solve comes back as a reason.
                common = {"threads_per_worker": 1, "memory_limit": 0, "dashboard_address": ":0", "silence_logs": "CRITICAL"}
                with starting_processes():
                    scheduler = stack.enter_context(LocalCluster(n_workers=workers, **common))
            client = stack.enter_context(Client(scheduler, timeout=CONNECT_TIMEOUT))
            client.wait_for_workers(1, timeout=timeout)
        except (OSError, TimeoutError) as error:
            raise ClusterError(f"{scheduler}: {error or 'no worker'}") from error
        yield client


class UnitPlugin(WorkerPlugin):
    """Installs an FMU and its solver on every worker, including workers that join later."""

    def __init__(self, name: str, fmu: bytes, load: Callable[[Archive], Any]) -> None:
        self.name = name
        self._fmu, self._load = fmu, load

    def setup(self, worker: Any) -> None:
        self._cleanup = ExitStack()
        folder = Path(worker.local_directory) / self.name
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "unit.fmu"
        file.write_bytes(self._fmu)
        archive = self._cleanup.enter_context(Archive.unpack(file, folder / "unpacked"))
        self.solver = self._cleanup.enter_context(closing(self._load(archive)))

    def teardown(self, worker: Any) -> None:
        self._cleanup.close()


@contextmanager
def shipped(client: Client, fmu: bytes, load: Callable[[Archive], Any], *modules: ModuleType) -> Iterator[Callable[[Chunk], Rows]]:
    """Sends an FMU and the code of its solver to the workers; returns the function that solves chunks there. `load`
    makes the solver, with the methods `solve` and `close`, from the unpacked FMU. It is in one of the modules, which
    are sent with those of `pushbelt.fmu`. Raises ClusterError if a worker cannot load them."""
    name = f"pushbelt-{client.id}"
    try:
        with ExitStack() as stack:
            for module in (pushbelt.fmu, arguments, errors, sys.modules[__name__], *modules):
                # Its objects and those of its submodules are pickled by value.
                cloudpickle.register_pickle_by_value(module)
                stack.callback(cloudpickle.unregister_pickle_by_value, module)
            client.register_plugin(UnitPlugin(name, fmu, load))
    except Exception as error:  # Any exception type is possible, since it comes from a worker.
        raise ClusterError(f"a worker cannot load the FMU: {error}") from error

    def solve(chunk: Chunk) -> Rows:
        # A local function is pickled by value: scheduler and workers do not have this project's modules.
        return get_worker().plugins[name].solver.solve(chunk)  # type: ignore[attr-defined]

    try:
        yield solve
    finally:
        if client.status == "running":
            client.unregister_worker_plugin(name)


def rows(client: Client, solve: Callable[[Chunk], Rows], chunks: Iterable[Chunk]) -> Iterator[Rows]:
    """Rows of the chunks in the order of completion. Chunks of a lost worker are sent to another one. The points of a chunk that repeatedly
    loses its worker are solved at the end, one at a time. The reason of the one that crashes the worker is `WORKER_LOST`."""
    given = {client.submit(solve, chunk, pure=False): chunk for chunk in chunks}
    suspects: list[tuple[int, Any]] = []
    # With results: one that is lost with its worker before it is here is computed again.
    for future, _ in as_completed(given, with_results=True, raise_errors=False):
        chunk, found = given.pop(future), _result(future)
        if found is None:
            suspects.extend(chunk)
        else:
            yield found
    for suspect in suspects:
        yield _result(client.submit(solve, [suspect], pure=False)) or [(suspect[0], {"reason": WORKER_LOST, "time": None})]


def _result(future: Future) -> Rows | None:
    """Rows of a chunk; None if it lost too many workers."""
    try:
        return future.result()
    except KilledWorker:
        return None
    except CancelledError as error:
        raise ClusterError("the connection to the scheduler is lost") from error
    finally:
        future.release()


def slurm(text: str) -> tuple[Any, int]:
    """A cluster of jobs of Slurm by dask-jobqueue, without jobs so far, and their number; each has `cores` processes, as
    `queue=normal walltime=02:00:00 jobs=4 cores=16 "directive=--nice=100"` says."""
    from dask_jobqueue import SLURMCluster

    given: dict[str, Any] = {}
    try:
        for key, value in (word.split("=", 1) for word in shlex.split(text)):
            if key in REPEATED:
                given.setdefault(REPEATED[key], []).append(value)
            else:
                given[key] = value
        jobs, cores, port = (int(given.pop(name, default)) for name, default in (("jobs", 1), ("cores", 1), ("port", 0)))
        days, _, clock = given.get("walltime", "00:30:00").rpartition("-")
        hours, minutes, seconds = map(int, clock.split(":"))
        lifetime = max(86400 * int(days or 0) + 3600 * hours + 60 * minutes + seconds - CLOSING, 30)
        # A worker that closes by itself passes its points on. One that Slurm ends would lose them and count as crashed.
        given = {"memory": f"{cores}GB", "worker_extra_args": ["--lifetime", f"{lifetime}s", "--lifetime-stagger", "30s"]} | given
        options = {"port": port, "dashboard_address": ":0"}
        found = SLURMCluster(cores=cores, processes=cores, scheduler_options=options, **given)
    except (TypeError, ValueError) as error:
        raise ClusterError(f"--slurm {text}: {error}; words are key=value, with walltime=02:00:00 or 1-02:00:00") from error
    return found, jobs
