"""Long studies in pieces: on all cores or a cluster, resumed after an interruption.

`pieces` runs them on the `executors`, and keeps what is done in a `checkpoint`.
"""

from powered_walker_env.poincare.work.executors import BACKENDS
from powered_walker_env.poincare.work.pieces import (
    LostWorkersError,
    RunOptions,
    check_workers,
    run_chains,
    run_pieces,
)

__all__ = [
    "BACKENDS",
    "LostWorkersError",
    "RunOptions",
    "check_workers",
    "run_chains",
    "run_pieces",
]
