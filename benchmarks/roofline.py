"""The roofline: how many strides a second the machine's arithmetic allows.

Williams, Waterman and Patterson, Roofline: an insightful visual performance model for
multicore architectures, CACM 52 (2009). A stride lives in registers and the nearest cache,
so memory sets no bound: the roof is the processor's rate of additions and multiplications.
Flops per stride are those of DOP853 as scipy steps it, counted: evaluations and steps from
a solve, the operations of each by numbers that count, and by the method's tableau.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from benchmarks.contenders import contenders, scipy_stride
from benchmarks.counting import (
    FREE_DIMENSION,
    LOCKED_DIMENSION,
    evaluation_flops,
    step_flops,
)
from benchmarks.equations import equations
from benchmarks.precision import speed_at
from benchmarks.problem import STARTS, Problem
from benchmarks.timing import Case, measure

TARGET = 1e-8  # error of the post-strike state at which all is told
RTOLS = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)  # about it
STAGES = 12  # evaluations of one DOP853 step
BEGIN, LAND = 2, 3  # scipy's further evaluations in a phase: first slope and step; interpolant
MATRIX = 1024  # rows of the product: large enough for the library's best
LANES = 64  # numbers in the loop: eight registers of eight
PASSES = 200_000  # over them: some milliseconds
REPEATS = 10


@dataclass(frozen=True)
class Roofline:
    """What one core does and could do, at an error of `TARGET`."""

    error: float
    locked_flops: int  # of one evaluation with the foot locked
    free_flops: int  # with the motor on
    step_flops: tuple[int, int]  # of one step beside its evaluations, by phase
    steps: float  # tried in a stride
    evaluations: float  # of a stride
    flops: float  # of a stride
    product_gflops: float  # of a matrix product by the linear algebra library, on one core
    loop_gflops: float  # of multiply-adds in registers by numba
    bound: float  # strides/s by the larger of the two
    strides_per_second: float  # ours, a batch, on one core
    share: float  # of the bound


def roofline(problem: Problem, seconds: float = 1.0) -> Roofline:
    """Count, measure the peak, and compare.

    Args:
        seconds: for the measurement of this package's strides.

    Raises:
        ValueError: seconds that are not positive.
    """
    own = next(c for c in contenders() if c.name == "ours, a batch")
    advances = [own.make(problem, rtol) for rtol in RTOLS]
    errors = np.array([problem.error(advance(problem.starts[:STARTS])) for advance in advances])
    batch = problem.starts[: own.batch]
    cases = [Case(lambda a=a: a(batch), own.batch) for a in advances]  # type: ignore[misc]
    timings = measure(cases, seconds / len(RTOLS))
    speed = speed_at(TARGET, errors, np.array([timing.rate_per_core for timing in timings]))

    locked, free = evaluation_flops(problem.constants)
    beside = step_flops(LOCKED_DIMENSION), step_flops(FREE_DIMENSION)
    steps, evaluations = _work_at(problem)
    flops = float(evaluations @ (locked, free) + steps @ beside)
    product, loop = matrix_product_rate(), loop_rate()
    bound = max(product, loop) / flops
    return Roofline(
        TARGET, locked, free, beside, float(steps.sum()), float(evaluations.sum()), flops,
        product / 1e9, loop / 1e9, bound, speed, speed / bound,
    )  # fmt: skip


def _work_at(problem: Problem) -> tuple[Any, Any]:
    """Steps tried and evaluations of a mean stride, by phase (2,), at the target error."""
    functions = equations(problem.constants, jitted=True)
    errors, steps, evaluations = [], [], []
    for rtol in RTOLS:
        solved = [scipy_stride(functions, problem, row, rtol) for row in problem.starts[:STARTS]]
        errors.append(problem.error(np.array([state for state, _ in solved])))
        called = np.array([work[:, 1] for _, work in solved])
        evaluations.append(called.mean(axis=0))
        steps.append(((called - BEGIN - LAND) / STAGES).mean(axis=0))

    def at(rows: list[Any]) -> Any:
        return np.array(
            [speed_at(TARGET, np.array(errors), column) for column in np.transpose(rows)]
        )

    return at(steps), at(evaluations)


def matrix_product_rate() -> float:
    """Flops per second of CPU time of a product of two matrices: so, of one core."""
    a = np.random.default_rng(0).random((MATRIX, MATRIX))
    out = np.empty_like(a)
    return 2.0 * MATRIX**3 / _shortest(lambda: np.matmul(a, a, out=out), time.process_time)


def loop_rate() -> float:
    """Flops per second of independent multiply-adds, compiled as the kernels are."""
    values = np.ones(LANES)
    compiled = numba.njit(error_model="numpy", fastmath={"contract"})(_multiply_and_add)
    seconds = _shortest(lambda: compiled(values, PASSES, 0.999, 0.001), time.perf_counter)
    return 2.0 * LANES * PASSES / seconds


def _multiply_and_add(values: Any, passes: int, factor: float, term: float) -> None:
    for _ in range(passes):
        for i in range(LANES):
            values[i] = values[i] * factor + term


def _shortest(work: Callable[[], Any], clock: Callable[[], float]) -> float:
    """The best of some calls, after one unseen: a peak is what the machine can do."""
    work()
    best = float("inf")
    for _ in range(REPEATS):
        begun = clock()
        work()
        best = min(best, clock() - begun)
    return max(best, 1e-9)
