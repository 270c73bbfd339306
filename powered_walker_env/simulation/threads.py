"""Run a compiled kernel over slices of a batch on all cores.

The kernels release the GIL and treat every row by itself, so plain threads do: nothing
to compile twice, no runtime of its own to clash with torch or with `fork`, and the
result of a row cannot depend on how many threads there are.

`POWERED_WALKER_THREADS` in the environment sets how many threads a process uses; the
pieces of a larger job limit themselves to their share (`at_most`).
"""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar

SMALLEST_SHARE = 64  # rows worth handing to a thread: about 0.15 ms of strides
PIECE = 256  # rows of a piece, where there are enough: falls are short, so they are spread
THREADS_VARIABLE = "POWERED_WALKER_THREADS"
WHOLE = slice(None)  # the slice of a batch that one thread walks

_pool: ThreadPoolExecutor | None = None
_limit: ContextVar[int | None] = ContextVar("limit", default=None)


def cores() -> int:
    """Cores this process may use: those it has, or as many as the environment says.

    Raises:
        ValueError: a number of threads in the environment that is not a positive integer.
    """
    asked = os.environ.get(THREADS_VARIABLE, "")
    if asked:
        if not asked.isdecimal() or int(asked) < 1:
            raise ValueError(f"{THREADS_VARIABLE} must be a positive integer, got {asked!r}")
        return int(asked)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def at_most(threads: int) -> Iterator[None]:
    """Use no more than so many threads for the batches inside, in this thread of the program."""
    token = _limit.set(threads)
    try:
        yield
    finally:
        _limit.reset(token)


def _forget_pool() -> None:
    global _pool  # threads do not survive a fork; the child makes its own
    _pool = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pool)


def run_in_slices(work: Callable[[slice], None], rows: int) -> None:
    """Call `work` on slices that together cover `rows`, on as many cores as pay.

    It is called on `WHOLE` where one thread does it.
    """
    global _pool
    most = rows // SMALLEST_SHARE
    shares = most if most < 2 else min(_limit.get() or cores(), most)
    if shares < 2:
        work(WHOLE)
        return
    if _pool is None:
        _pool = ThreadPoolExecutor(cores(), thread_name_prefix="strides")
    pieces = max(shares, min(4 * shares, rows // PIECE))
    bounds = [rows * i // pieces for i in range(pieces + 1)]
    slices = [slice(low, high) for low, high in itertools.pairwise(bounds)]
    list(_pool.map(work, slices))
