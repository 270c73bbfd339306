"""Many independent pieces of work: on all cores, on a cluster, with retries, to be resumed.

Every study of the laboratory that takes minutes is a list of pieces and a function of
one piece. Where a piece runs cannot change its result: kernels treat each row by itself.
On one machine joblib runs the pieces, in processes ("loky") or threads ("threading"); on
a cluster Dask or Ray do. Each piece keeps to one thread: the pieces fill the cores.
"""

from __future__ import annotations

import contextlib
import sys
import time
import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any, NamedTuple, TypedDict, TypeVar

import joblib

from powered_walker_env.poincare.work.checkpoint import Checkpoint
from powered_walker_env.simulation.threads import at_most, cores

BACKENDS = ("loky", "threading", "dask", "ray")

Piece = TypeVar("Piece")
Result = TypeVar("Result")
#: Called after every piece: pieces done, pieces in all, seconds left (NaN if unknown).
Progress = Callable[[int, int, float], None]


class RunOptions(TypedDict, total=False):
    """How `run_pieces` runs; studies made of pieces take these and hand them on."""

    backend: str
    address: str | None
    jobs: int | None
    retries: int
    progress: Progress | None
    checkpoint: str | Path | None


class LostWorkersError(RuntimeError):
    """Workers died again and again, taking pieces with them."""


class _Done(NamedTuple):
    number: int  # of the piece
    result: Any
    error: Exception | None


_Tasks = list[tuple[int, Any]]


def run_pieces(
    function: Callable[[Piece], Result],
    pieces: Sequence[Piece],
    *,
    backend: str = "loky",
    address: str | None = None,
    jobs: int | None = None,
    retries: int = 2,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
) -> list[Result]:
    """The function's results, in the order of the pieces, wherever they were computed.

    Args:
        function: of one piece; it and the pieces must pickle, but for threads.
        backend: "loky" (processes), "threading", "dask" or "ray".
        address: of a running cluster; without it, Dask and Ray start one on this machine.
        jobs: workers on this machine; all cores if left out. A cluster has its own number.
        retries: how often the pieces of workers that died are tried again.
        progress: called after every piece with pieces done, pieces in all, seconds left.
        checkpoint: a folder that keeps finished pieces, each written whole: after an
            interruption (Ctrl-C included) the same call computes the rest only. It holds
            pickles: open only folders of your own.

    Raises:
        ValueError: an unknown backend, or a checkpoint of other work.
        LostWorkersError: workers died more often than `retries` allows.
        ImportError: Dask or Ray is not installed.
        Exception: whatever the function raises, at once.
    """
    _check(backend, address, jobs, retries)
    store = None if checkpoint is None else Checkpoint(Path(checkpoint), function, pieces)
    results: dict[int, Result] = {} if store is None else store.load()
    began, restored = time.monotonic(), len(results)
    for attempt in range(retries + 1):
        rest = [(i, piece) for i, piece in enumerate(pieces) if i not in results]
        if not rest:
            break
        try:
            with contextlib.closing(_run(function, rest, backend, address, jobs)) as stream:
                for done in stream:
                    if done.error is not None:
                        done.error.add_note(f"in piece {done.number} of {len(pieces)}")
                        raise done.error
                    results[done.number] = done.result
                    if store is not None:
                        store.save(done.number, done.result)
                    if progress is not None:
                        pace = (time.monotonic() - began) / (len(results) - restored)
                        progress(len(results), len(pieces), pace * (len(pieces) - len(results)))
        except _lost_worker() as error:
            if attempt == retries:
                raise LostWorkersError(
                    f"workers died {retries + 1} times, {len(results)} of {len(pieces)} pieces "
                    "are done; give them more memory, make smaller pieces, or raise retries"
                ) from error
    return [results[i] for i in range(len(pieces))]


def _check(backend: str, address: str | None, jobs: int | None, retries: int) -> None:
    if backend not in BACKENDS:
        raise ValueError(f"backend must be one of {', '.join(BACKENDS)}, got {backend!r}")
    if address is not None and backend not in ("dask", "ray"):
        raise ValueError(
            f"address must be left out for {backend!r}, which runs on this machine, got "
            f"{address!r}; pass backend='dask' or 'ray' for a cluster"
        )
    if jobs is not None and jobs < 1:
        raise ValueError(f"jobs must be at least 1, got {jobs!r}")
    if retries < 0:
        raise ValueError(f"retries must not be negative, got {retries!r}")


def _work(function: Callable[[Any], Any], index: int, piece: Any) -> _Done:
    """One piece, where it runs. Its own errors travel as results: only losses are retried."""
    try:
        with at_most(1):
            return _Done(index, function(piece), None)
    except Exception as error:
        return _Done(index, None, error)


def _run(
    function: Callable[[Any], Any],
    tasks: _Tasks,
    backend: str,
    address: str | None,
    jobs: int | None,
) -> Generator[_Done]:
    """The pieces as they get done; raises one of `_lost_worker` if a worker died."""
    if backend == "dask":
        return _run_dask(function, tasks, address, jobs)
    if backend == "ray":
        return _run_ray(function, tasks, address, jobs)
    return _run_joblib(function, tasks, backend, jobs)


def _run_joblib(
    function: Callable[[Any], Any],
    tasks: _Tasks,
    backend: str,
    jobs: int | None,
) -> Generator[_Done]:
    settings = {"inner_max_num_threads": 1} if backend == "loky" else {}
    with joblib.parallel_config(backend, n_jobs=jobs or cores(), **settings):
        stream = joblib.Parallel(batch_size=1, return_as="generator_unordered")(
            joblib.delayed(_work)(function, index, piece) for index, piece in tasks
        )
        try:
            for done in stream:  # noqa: UP028 - "yield from" would close the stream, loudly
                yield done
        finally:
            with warnings.catch_warnings():  # pieces under way are given up: meant so
                warnings.simplefilter("ignore", UserWarning)
                stream.close()


def _run_dask(
    function: Callable[[Any], Any], tasks: _Tasks, address: str | None, jobs: int | None
) -> Generator[_Done]:
    """By Dask's own futures: joblib's Dask backend never hears of a piece lost for good."""
    try:
        import distributed
    except ImportError as error:
        raise ImportError(
            "backend 'dask' needs dask and distributed: pip install 'powered-walker-env[cluster]'"
        ) from error
    with contextlib.ExitStack() as stack:
        if address is None:
            address = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=jobs or cores(), threads_per_worker=1, dashboard_address=None
                )
            ).scheduler_address
        client = stack.enter_context(distributed.Client(address, set_as_default=False))
        futures = [
            client.submit(_work, function, index, piece, pure=False) for index, piece in tasks
        ]
        stack.callback(client.cancel, futures)
        for future in distributed.as_completed(futures, loop=client.loop):
            if future.status != "finished":  # its workers died, more often than Dask allows
                raise ConnectionError(f"a piece was lost: {future.status}")
            yield future.result()


def _run_ray(
    function: Callable[[Any], Any], tasks: _Tasks, address: str | None, jobs: int | None
) -> Generator[_Done]:
    """By Ray's own tasks: joblib's Ray backend hands results out all at once, at the end."""
    try:
        import ray
    except ImportError as error:
        raise ImportError(
            "backend 'ray' needs Ray: pip install 'powered-walker-env[ray]'"
        ) from error
    own = not ray.is_initialized()
    if own:
        here = {} if address else {"num_cpus": jobs or cores(), "include_dashboard": False}
        ray.init(address=address, log_to_driver=False, **here)
    try:
        work = ray.remote(_work).options(max_retries=0)  # lost pieces are ours to try again
        waiting = [work.remote(function, index, piece) for index, piece in tasks]
        while waiting:
            (done, *_), waiting = ray.wait(waiting)
            yield ray.get(done)
    finally:
        if own:
            ray.shutdown()


def _lost_worker() -> tuple[type[Exception], ...]:
    """What is raised when a worker died, by the libraries in use."""
    ray = sys.modules.get("ray")
    return (BrokenExecutor, ConnectionError, *((ray.exceptions.RayError,) if ray else ()))


def blocks(count: int, size: int) -> list[slice]:
    """Slices of at most `size` rows that cover `count` rows; the same for any backend."""
    return [slice(low, min(low + size, count)) for low in range(0, count, size)]


__all__ = ["BACKENDS", "LostWorkersError", "Progress", "RunOptions", "blocks", "run_pieces"]
