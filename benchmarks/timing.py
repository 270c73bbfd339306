"""Timing on a machine that others use, too: rounds in turn, medians, ratios within a round.

Everything that is to be compared takes its turn in every round, so that a slow spell of
the machine falls on all. Two clocks are read: wall time, and the process's CPU time, which
does not run while others have the core; for work on one core the latter is the one to
trust.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from powered_walker_env.pictures.charts import Drawing

Array = NDArray[np.float64]

ROUNDS = 5  # enough for a median that one slow round does not move


class Section(NamedTuple):
    """What a benchmark found: for people, for programs, and drawn if asked."""

    text: str
    data: dict[str, Any]
    draw: Callable[[], Mapping[str, Drawing]] = dict


class Case(NamedTuple):
    """Something to time."""

    work: Callable[[], Any]
    units: int = 1  # done by one call: strides, steps


@dataclass(frozen=True, eq=False)
class Timing:
    """Seconds for one unit, (rounds,) each."""

    wall: Array
    cpu: Array

    @property
    def rate(self) -> float:
        """Units per second of wall time, the median."""
        return float(np.median(1.0 / self.wall))

    @property
    def cores(self) -> float:
        """Cores that the machine gave, the median: CPU time over wall time."""
        return float(np.median(self.cpu / self.wall))

    @property
    def rate_per_core(self) -> float:
        """Units per second of CPU time, the median."""
        return float(np.median(1.0 / self.cpu))


def measure(cases: Sequence[Case], seconds: float, rounds: int = ROUNDS) -> list[Timing]:
    """Time cases in turn, after one call of each unseen.

    Args:
        seconds: for each case in all, on average; every round makes at least one call of
            each, and where that takes longer there are fewer rounds, down to one.
    """
    calls, shortest = [], 0.0
    for case in cases:
        once = _seconds(case.work, 1)[0]
        if once < seconds / rounds:  # the first call may have compiled something
            once = _seconds(case.work, 1)[0]
        calls.append(max(1, round(seconds / rounds / max(once, 1e-9))))
        shortest += calls[-1] * once
    rounds = max(1, min(rounds, round(seconds * len(cases) / max(shortest, 1e-9))))
    taken = np.empty((len(cases), rounds, 2))
    for turn in range(rounds):
        for i, case in enumerate(cases):
            taken[i, turn] = np.array(_seconds(case.work, calls[i])) / (calls[i] * case.units)
    return [Timing(rows[:, 0], rows[:, 1]) for rows in np.maximum(taken, 1e-12)]


def _seconds(work: Callable[[], Any], calls: int) -> tuple[float, float]:
    """Wall and CPU time of so many calls."""
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(calls):
        work()
    return time.perf_counter() - wall, time.process_time() - cpu
