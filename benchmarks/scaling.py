"""Strides per second against the number of walkers in a batch, and of cores."""

from __future__ import annotations

import numpy as np

from benchmarks.strides import Problem
from benchmarks.timing import Case, Section, measure
from powered_walker_env.simulation.threads import at_most, cores
from powered_walker_env.tabular import aligned

RTOL = 1e-8
SIZES = (1, 4, 16, 64, 256, 1024, 2048, 4096)
LARGE = 2048  # walkers for each core, where cores are compared


def scaling(problem: Problem, seconds: float = 1.0) -> Section:
    """Measure both; one core by CPU time, more by wall time.

    Args:
        seconds: for each of the two, shared out over sizes and numbers of cores.
    """
    counts = core_counts(cores())
    cases = [_case(problem, size, threads) for size in SIZES for threads in (1, cores())]
    timings = measure(cases, seconds / len(SIZES))
    walkers = {
        "walkers": list(SIZES),
        "one_core": [timing.rate_per_core for timing in timings[::2]],
        "all_cores": [timing.rate for timing in timings[1::2]],
    }
    cases = [_case(problem, LARGE * cores(), threads) for threads in counts]
    shared = measure(cases, seconds / len(counts))
    by_cores = {
        "cores": list(counts),
        "strides_per_second": [timing.rate for timing in shared],
        "of_proportion": [  # to one core's rate, times cores; the median of rounds
            float(np.median(shared[0].wall / timing.wall)) / threads
            for threads, timing in zip(counts, shared, strict=True)
        ],
        "given": [timing.cores for timing in shared],  # fewer where others use the machine, too
        "by_cpu_time": [float(np.median(shared[0].cpu / timing.cpu)) for timing in shared],
    }
    sizes = [("walkers in a batch", "strides/s on one core", "on all cores")]
    sizes += [(f"{n:,}", f"{one:,.0f}", f"{every:,.0f}")
              for n, one, every in zip(*walkers.values(), strict=True)]  # fmt: skip
    table = [("cores", "strides/s", "of proportion", "cores the machine gave", "by CPU time")]
    table += [
        (str(n), f"{rate:,.0f}", f"{100 * share:.0f} %", f"{given:.2f}", f"{100 * cpu:.0f} %")
        for n, rate, share, given, cpu in zip(*by_cores.values(), strict=True)
    ]
    text = [
        f"Scaling: rtol {RTOL:.0e}; one core by CPU time, all cores by wall time",
        "",
        *aligned(sizes),
        "",
        *aligned(table),
        f"({LARGE:,} walkers for each core; of proportion: to one core's rate, times cores)",
    ]
    return Section("\n".join(text), {"rtol": RTOL, **walkers, "by_cores": by_cores})


def core_counts(most: int) -> tuple[int, ...]:
    """1, 2, 4, ... and all of them."""
    return tuple(sorted({2**k for k in range(most.bit_length())} | {most}))


def _case(problem: Problem, size: int, threads: int) -> Case:
    states = np.resize(problem.starts, (size, 4))

    def work() -> None:
        with at_most(threads):
            problem.walked(states, RTOL)

    return Case(work, size)
