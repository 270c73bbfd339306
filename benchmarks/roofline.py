"""The roofline: how many strides a second the machine's arithmetic allows.

Williams, Waterman and Patterson, Roofline: an insightful visual performance model for
multicore architectures, CACM 52 (2009). A stride lives in registers and the nearest cache,
so memory sets no bound: the roof is the processor's rate of additions and multiplications.
Flops per stride are those of DOP853 as scipy steps it: evaluations and steps from a solve, times
the counts below. Additions, multiplications, divisions and roundings count as one each; a
division takes as long as several of the others, so a count is a lower bound of the work.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from benchmarks.equations import equations
from benchmarks.precision import OWN, speed_at
from benchmarks.strides import STARTS, Problem, methods, scipy_stride
from benchmarks.timing import Array, Case, Section, measure
from powered_walker_env.tabular import aligned

# Counts, each derived once more by a test. A sine and a cosine to rounding: 8 to reduce the angle
# by three parts of π/2, 1 square, two polynomials of six coefficients, 8 to assemble both.
SINE_AND_COSINE = 8 + 1 + 2 * 10 + 8
# `locked_accelerations` with the foot's angle from the leg's, `free_accelerations`: the sines of
# three angles, and the additions and multiplications of `equations`.
EVALUATION = np.array([3 * SINE_AND_COSINE + 101, 3 * SINE_AND_COSINE + 118])
# One step beside its evaluations, for each number of the state (4 and 6): a multiplication and an
# addition for each non-zero coefficient of the tableau, h and y once a stage; the error's scale.
STEP = 169 * np.array([4, 6])

TARGET = 1e-8  # error of the post-strike state at which all is told
RTOLS = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)  # about it
STAGES = 12  # evaluations of one DOP853 step
BEGIN, LAND = 2, 3  # scipy's further evaluations in a phase: first slope and step; interpolant
MATRIX = 1024  # rows of the product: large enough for the library's best
LANES = 64  # numbers in the loop: eight registers of eight
PASSES = 200_000  # over them: some milliseconds
REPEATS = 10


def roofline(problem: Problem, seconds: float = 1.0) -> Section:
    """Count, measure the peak, and compare.

    Args:
        seconds: for the measurement of this package's strides.
    """
    own = next(method for method in methods() if method.name == OWN)
    advances = [own.make(problem, rtol) for rtol in RTOLS]
    errors = np.array([problem.error(advance(problem.starts[:STARTS])) for advance in advances])
    batch = problem.starts[: own.batch]
    cases = [Case(lambda f=f: f(batch), own.batch) for f in advances]  # type: ignore[misc]
    rates = np.array([timing.rate_per_core for timing in measure(cases, seconds / len(RTOLS))])
    speed = speed_at(TARGET, errors, rates)
    evaluations = _evaluations(problem)
    steps = (evaluations - BEGIN - LAND) / STAGES
    flops = float(evaluations @ EVALUATION + steps @ STEP)
    peak = peak_rate()
    bound = peak / flops
    data = {
        "error": TARGET, "evaluation_flops": EVALUATION.tolist(), "step_flops": STEP.tolist(),
        "steps": float(steps.sum()), "evaluations": float(evaluations.sum()), "flops": flops,
        "peak_gflops": peak / 1e9, "bound": bound,
        "strides_per_second": speed, "share": speed / bound,
    }  # fmt: skip
    lines = [
        ("one evaluation", f"{EVALUATION[0]} flops with the foot locked, {EVALUATION[1]} with the "
         "motor on (sines included)"),
        ("one step beside them", f"{STEP[0]} and {STEP[1]} flops"),
        ("one stride", f"{steps.sum():.1f} steps, {evaluations.sum():.0f} evaluations, "
         f"{flops / 1e3:.1f} kflop"),
        ("peak of one core", f"{peak / 1e9:.1f} GFLOP/s"),
        ("bound", f"{bound:,.0f} strides/s"),
        ("ours, a batch", f"{speed:,.0f} strides/s: {100 * speed / bound:.1f} % of the bound"),
    ]  # fmt: skip
    head = f"Roofline: one core, DOP853 to an error of {TARGET:.0e}"
    return Section("\n".join([head, "", *aligned(lines, left=2)]), data)


def _evaluations(problem: Problem) -> Array:
    """Evaluations of a mean stride by scipy, by phase (2,), at the target error."""
    functions = equations(problem.constants, jitted=True)
    errors, counts = [], []
    for rtol in RTOLS:
        solved = [scipy_stride(functions, problem, row, rtol) for row in problem.starts[:STARTS]]
        errors.append(problem.error(np.array([state for state, _ in solved])))
        counts.append(np.mean([evaluations for _, evaluations in solved], axis=0))
    at_rungs = np.array(errors)
    return np.array([speed_at(TARGET, at_rungs, column) for column in np.transpose(counts)])


def peak_rate() -> float:
    """Flops per second of CPU time of one core: the larger of a matrix product by the linear
    algebra library and of multiply-adds in registers, compiled as the kernels are."""
    a = np.random.default_rng(0).random((MATRIX, MATRIX))
    out, values = np.empty_like(a), np.ones(LANES)
    compiled = numba.njit(error_model="numpy", fastmath={"contract"})(_multiply_and_add)
    product = 2.0 * MATRIX**3 / _shortest(lambda: np.matmul(a, a, out=out))
    return max(product, 2.0 * LANES * PASSES / _shortest(lambda: compiled(values, PASSES)))


def _multiply_and_add(values: Any, passes: int) -> None:
    for _ in range(passes):
        for i in range(LANES):
            values[i] = values[i] * 0.999 + 0.001


def _shortest(work: Callable[[], Any]) -> float:
    """CPU time of the best of some calls, after one unseen: a peak is what the machine can do."""
    taken = []
    for _ in range(REPEATS + 1):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return max(min(taken[1:]), 1e-9)
