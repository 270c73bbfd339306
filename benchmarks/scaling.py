"""Strides per second against the number of walkers in a batch, and of cores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.problem import Array, Problem
from benchmarks.timing import Case, measure
from powered_walker_env.simulation.strides import stride_batch
from powered_walker_env.simulation.threads import at_most, cores

RTOL = 1e-8
SIZES = (1, 4, 16, 64, 256, 1024, 2048, 4096)
LARGE = 2048  # walkers for each core, where cores are compared
PAST_START = 256  # walkers from which the time should be proportional to their number


@dataclass(frozen=True)
class Scaling:
    """Rates (one core: of CPU time; more: of wall time), and how close they come to proportion."""

    rtol: float
    sizes: tuple[int, ...]
    one_core: tuple[float, ...]  # strides/s by size
    all_cores: tuple[float, ...]
    start_up: float  # s: of time = start-up + size/rate, on one core
    departure: float  # largest relative distance from that line past the start-up
    cores: tuple[int, ...]
    by_cores: tuple[float, ...]  # strides/s
    given: tuple[float, ...]  # cores that the machine gave: fewer where others use it, too
    efficiency: tuple[float, ...]  # over as many times the rate of one core, median of rounds
    undisturbed: tuple[float, ...]  # the same by CPU time: without what others took


def scaling(problem: Problem, seconds: float = 1.0, sizes: tuple[int, ...] = SIZES) -> Scaling:
    """Measure both.

    Args:
        seconds: for each of the two, shared out over sizes and numbers of cores.

    Raises:
        ValueError: seconds that are not positive.
    """
    counts = core_counts(cores())
    cases = [_case(problem, size, threads) for size in sizes for threads in (1, cores())]
    timings = measure(cases, seconds / len(sizes))
    one, every = timings[::2], timings[1::2]
    line = _line(np.array(sizes), np.array([np.median(timing.cpu) for timing in one]))
    shared = measure(
        [_case(problem, LARGE * cores(), threads) for threads in counts], seconds / len(counts)
    )
    return Scaling(
        RTOL,
        tuple(sizes),
        tuple(timing.rate_per_core for timing in one),
        tuple(timing.rate for timing in every),
        *line,
        counts,
        tuple(timing.rate for timing in shared),
        tuple(timing.cores for timing in shared),
        tuple(
            float(np.median(shared[0].wall / timing.wall)) / threads
            for threads, timing in zip(counts, shared, strict=True)
        ),
        tuple(float(np.median(shared[0].cpu / timing.cpu)) for timing in shared),
    )


def core_counts(most: int) -> tuple[int, ...]:
    """1, 2, 4, ... and all of them."""
    return tuple(sorted({2**k for k in range(most.bit_length())} | {most}))


def _case(problem: Problem, size: int, threads: int) -> Case:
    states = np.resize(problem.starts, (size, 4))

    def work() -> None:
        with at_most(threads):
            stride_batch(states, problem.controls, problem.params, rtol=RTOL)

    return Case(work, size)


def _line(sizes: Array, per_stride: Array) -> tuple[float, float]:
    """Start-up of the line through the times past the start-up, and the departure from it."""
    past = sizes >= PAST_START
    if past.sum() < 3:
        return float("nan"), float("nan")
    n, times = sizes[past].astype(float), (sizes * per_stride)[past]
    weights = 1.0 / times  # relative errors count
    slope, start = np.polyfit(n, times, 1, w=weights)
    fitted = start + slope * n
    return float(start), float(np.max(np.abs(times / fitted - 1.0)))
