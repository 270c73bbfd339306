"""Where pieces run: processes, threads, Dask or Ray, each as an executor with `submit`.

Processes are loky's: they are started afresh (a fork of a process with threads may hang),
take local functions, need no guarded main module, and say so when one of them dies. They
end with the process that began them, whatever ended that.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future, ThreadPoolExecutor
from typing import Any, Protocol

import loky

from powered_walker_env.simulation.threads import cores

BACKENDS = ("loky", "threading", "dask", "ray")
IDLE = 60.0  # s, that idle processes wait for the next study: to start them takes seconds
WATCH = 0.5  # s between two looks at whether the parent is still there
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


class Executor(Protocol):
    """What runs pieces: as `concurrent.futures.Executor`, as far as it is used here."""

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Run the function somewhere, some time."""


def executor(
    backend: str, address: str | None, jobs: int | None
) -> contextlib.AbstractContextManager[Executor]:
    """The executor of a backend; as a context it gives up unfinished work when it is left.

    Raises:
        ImportError: Dask or Ray is not installed.
    """
    if backend == "dask":
        return _dask(address, jobs or cores())
    if backend == "ray":
        return _ray(address, jobs or cores())
    return (_processes if backend == "loky" else _threads)(jobs or cores())


def lost_worker() -> tuple[type[Exception], ...]:
    """What a future raises when its worker died, by the libraries in use."""
    losses: list[type[Exception]] = [BrokenExecutor, CancelledError, ConnectionError]
    if ray := sys.modules.get("ray"):
        losses.append(ray.exceptions.RayError)
    if distributed := sys.modules.get("distributed"):
        losses.append(distributed.KilledWorker)  # more often than Dask allows
    return tuple(losses)


@contextlib.contextmanager
def _processes(jobs: int) -> Iterator[Executor]:
    workers = loky.get_reusable_executor(
        jobs, timeout=IDLE, initializer=_depend_on, initargs=(os.getpid(),), env=ONE_THREAD
    )
    try:
        yield workers
    except BaseException:
        workers.shutdown(wait=True, kill_workers=True)
        raise


def _depend_on(parent: int) -> None:
    """Leave Ctrl-C to the parent process, and end when it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextlib.contextmanager
def _threads(jobs: int) -> Iterator[Executor]:
    workers = ThreadPoolExecutor(jobs, thread_name_prefix="pieces")
    try:
        yield workers
    finally:
        workers.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _dask(address: str | None, jobs: int) -> Iterator[Executor]:
    try:
        import distributed
    except ImportError as error:
        raise ImportError(
            "backend 'dask' needs dask and distributed: pip install 'powered-walker-env[cluster]'"
        ) from error
    with contextlib.ExitStack() as stack:
        if address is None:
            cluster = distributed.LocalCluster(
                n_workers=jobs, threads_per_worker=1, dashboard_address=None
            )
            address = stack.enter_context(cluster).scheduler_address
        client = stack.enter_context(distributed.Client(address, set_as_default=False))
        workers = client.get_executor(pure=False)
        stack.callback(workers.shutdown, wait=False)
        yield workers


class _RayTasks:
    """Ray's tasks as an executor."""

    def __init__(self, ray: Any) -> None:
        self.ray = ray
        self.begun: list[Any] = []

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        task = self.ray.remote(function).options(max_retries=0)  # lost pieces are ours to try again
        self.begun.append(task.remote(*arguments))
        future: Future[Any] = self.begun[-1].future()
        return future

    def shutdown(self) -> None:
        for task in self.begun:
            self.ray.cancel(task, force=True)


@contextlib.contextmanager
def _ray(address: str | None, jobs: int) -> Iterator[Executor]:
    try:
        import ray
    except ImportError as error:
        raise ImportError(
            "backend 'ray' needs Ray: pip install 'powered-walker-env[ray]'"
        ) from error
    own = not ray.is_initialized()
    if own:
        here = {} if address else {"num_cpus": jobs, "include_dashboard": False}
        ray.init(address=address, log_to_driver=False, **here)
    workers = _RayTasks(ray)
    try:
        yield workers
    finally:
        workers.shutdown()
        if own:
            ray.shutdown()
