"""Many pieces of work: on all cores, on a cluster, with retries, to be resumed.

Every study of the laboratory that takes minutes is a list of pieces and a function of
one piece, or of chains of them, in which each needs what the one before found. Where a
piece runs cannot change its result: kernels treat each row by itself. Each piece keeps to
one thread: the pieces fill the cores.
"""

from __future__ import annotations

import dataclasses
import itertools
import queue
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Generic, TypedDict, TypeVar, Unpack

from powered_walker_env.model.checks import whole_number
from powered_walker_env.poincare.work.checkpoint import Checkpoint
from powered_walker_env.poincare.work.executors import BACKENDS, Executor, executor, lost_worker
from powered_walker_env.simulation.threads import at_most

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


@dataclasses.dataclass(frozen=True)
class _Alone(Generic[Piece, Result]):
    """A function of one piece as one that needs nothing of the pieces before."""

    function: Callable[[Piece], Result]

    def __call__(self, piece: Piece, _: Result | None) -> Result:
        return self.function(piece)


def run_pieces(
    function: Callable[[Piece], Result], pieces: Sequence[Piece], **run: Unpack[RunOptions]
) -> list[Result]:
    """The function's results, in the order of the pieces, wherever they were computed.

    Args:
        function: of one piece; it and the pieces must pickle, but for threads.
        run: as in `run_chains`.

    Raises:
        As `run_chains`.
    """
    chains = [[piece] for piece in pieces]
    kept = _run(_Alone(function), function, chains, **run)
    return [result for (result,) in kept]


def run_chains(
    function: Callable[[Piece, Result | None], Result],
    chains: Sequence[Sequence[Piece]],
    **run: Unpack[RunOptions],
) -> list[list[Result]]:
    """The results of chains of pieces, each computed from its piece and the result before.

    Args:
        function: of a piece and the result of the piece before it in its chain, None for
            the first; it, the pieces and the results must pickle, but for threads.
        chains: of pieces.
        backend: "loky" (processes), "threading", "dask" or "ray".
        address: of a running cluster; without it, Dask and Ray start one on this machine.
        jobs: workers on this machine; all cores if left out. A cluster has its own number.
        retries: how often the pieces of workers that died are tried again.
        progress: called after every piece with pieces done, pieces in all, seconds left.
        checkpoint: a folder that keeps finished pieces, each written whole: after an
            interruption (Ctrl-C included) the same call computes the rest only. The
            results must be such as `save_result` keeps.

    Raises:
        ValueError: an unknown backend, or a checkpoint of other work.
        LostWorkersError: workers died more often than `retries` allows.
        ImportError: Dask or Ray is not installed.
        Exception: whatever the function raises, at once.
    """
    return _run(function, function, chains, **run)


def _run(
    function: Callable[[Any, Any], Any],
    named: Callable[..., Any],
    chains: Sequence[Sequence[Any]],
    *,
    backend: str = "loky",
    address: str | None = None,
    jobs: int | None = None,
    retries: int = 2,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
) -> list[list[Any]]:
    check_workers(backend, address, jobs, retries)
    links = [piece for chain in chains for piece in chain]
    store = None if checkpoint is None else Checkpoint(Path(checkpoint), named, links)
    work = _Work(function, chains, store, progress)
    for attempt in range(retries + 1):
        if work.finished == work.total:
            break
        try:
            with executor(backend, address, jobs) as workers:
                work.run(workers)
        except lost_worker() as error:
            if attempt == retries:
                raise LostWorkersError(
                    f"workers died {retries + 1} times, {work.finished} of {work.total} pieces "
                    "are done; give them more memory, make smaller pieces, or raise retries"
                ) from error
    return work.results


def check_workers(
    backend: str, address: str | None = None, jobs: int | None = None, retries: int = 0
) -> None:
    """Refuse workers that there cannot be.

    Raises:
        ValueError: naming the argument.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend must be one of {', '.join(BACKENDS)}, got {backend!r}")
    if address is not None and backend not in ("dask", "ray"):
        raise ValueError(
            f"address must be left out for {backend!r}, which runs on this machine, got "
            f"{address!r}; pass backend='dask' or 'ray' for a cluster"
        )
    if jobs is not None:
        whole_number("jobs", jobs, 1)
    whole_number("retries", retries, 0)


class _Work:
    """Chains of pieces and the results so far."""

    def __init__(
        self,
        function: Callable[[Any, Any], Any],
        chains: Sequence[Sequence[Any]],
        store: Checkpoint | None,
        progress: Progress | None,
    ) -> None:
        self.function, self.chains = function, chains
        self.store, self.progress = store, progress
        bounds = [0, *itertools.accumulate(map(len, chains))]
        self.first, self.total = bounds[:-1], bounds[-1]  # each chain's first number; pieces
        numbers = [range(*pair) for pair in itertools.pairwise(bounds)]
        self.results = [[] if store is None else store.load(pieces) for pieces in numbers]
        self.finished = self.restored = sum(map(len, self.results))
        self.began = time.monotonic()

    def run(self, workers: Executor) -> None:
        """Compute what is left: the next piece of a chain as soon as the one before is done."""
        done: queue.SimpleQueue[tuple[int, Future[Any]]] = queue.SimpleQueue()

        def begin(chain: int) -> int:
            results, pieces = self.results[chain], self.chains[chain]
            if len(results) == len(pieces):
                return 0
            before = results[-1] if results else None
            future = workers.submit(_work, self.function, pieces[len(results)], before)
            future.add_done_callback(lambda future: done.put((chain, future)))
            return 1

        waiting = sum(begin(chain) for chain in range(len(self.chains)))
        while waiting:
            chain, future = done.get()
            result, error = future.result()  # raises what a lost worker raises
            if error is not None:
                number = self.first[chain] + len(self.results[chain])
                error.add_note(f"in piece {number} of {self.total}")
                raise error
            self._keep(chain, result)
            waiting += begin(chain) - 1

    def _keep(self, chain: int, result: Any) -> None:
        if self.store is not None:
            self.store.save(self.first[chain] + len(self.results[chain]), result)
        self.results[chain].append(result)
        self.finished += 1
        if self.progress is not None:
            pace = (time.monotonic() - self.began) / (self.finished - self.restored)
            self.progress(self.finished, self.total, pace * (self.total - self.finished))


def _work(
    function: Callable[[Any, Any], Any], piece: Any, before: Any
) -> tuple[Any, Exception | None]:
    """One piece, where it runs. Its own errors travel as results: only losses are retried."""
    try:
        with at_most(1):
            return function(piece, before), None
    except Exception as error:
        return None, error


def blocks(count: int, size: int) -> list[slice]:
    """Slices of at most `size` rows that cover `count` rows; the same for any backend."""
    return [slice(low, min(low + size, count)) for low in range(0, count, size)]


__all__ = [
    "BACKENDS",
    "LostWorkersError",
    "Progress",
    "RunOptions",
    "blocks",
    "run_chains",
    "run_pieces",
]
