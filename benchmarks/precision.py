"""Work and precision: how many strides a second, and how far off they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.contenders import Contender, contenders
from benchmarks.problem import MANY, STARTS, Array, Problem
from benchmarks.timing import Case, Timing, measure
from powered_walker_env.simulation.strides import LOOSEST, TIGHTEST, stride_batch

RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
LOST = 1e-2  # an error from which it is another stride: steps so long that they miss an event
BASELINE = 0  # the contender that ratios are taken to: scipy's plain one


@dataclass(frozen=True)
class Rung:
    """A contender at one tolerance."""

    method: str
    cores: str  # "1" or "all"
    rtol: float
    error: float  # largest component of the post-strike state over the starts, rad and rad/s
    strides_per_second: float  # of CPU time on one core, of wall time on all
    ratio: float  # to scipy's plain DOP853 at equal error; NaN if there is none
    given: float  # cores that the machine gave: fewer where others use it, too


@dataclass(frozen=True)
class Precision:
    """All rungs, and what they are measured against."""

    walker: str
    rungs: tuple[Rung, ...]
    missing: dict[str, str]  # contenders that are not installed, and the remedy
    # By method: how far it is, at its tightest, from the reference (ours at rtol 1e-13).
    agreement: dict[str, float]
    worst_of_many: dict[float, float]  # ours: rtol to the largest error of MANY strides


def precision(problem: Problem, rtols: Sequence[float] = RTOLS, seconds: float = 1.0) -> Precision:
    """Measure all contenders at all tolerances, in the same rounds.

    Args:
        seconds: for each contender, shared out over the tolerances.

    Raises:
        ValueError: a tolerance out of bounds, or seconds that are not positive.
    """
    tolerances = check_rtols(rtols)
    present = [c for c in contenders() if not c.missing]
    errors, cases = [], []
    for contender in present:
        for rtol in tolerances:
            error, case = _prepare(contender, problem, rtol)
            errors.append(error)
            cases.append(case)
    timings = measure(cases, seconds / len(tolerances))
    shape = len(present), len(tolerances)
    return Precision(
        problem.name,
        tuple(_rungs(present, tolerances, np.reshape(errors, shape), timings)),
        {c.name: c.missing for c in contenders() if c.missing},
        {c.name: _distance(c, problem) for c in present if not c.name.startswith("ours")},
        {rtol: _worst(problem, rtol) for rtol in tolerances},
    )


def check_rtols(rtols: Sequence[float]) -> tuple[float, ...]:
    """The tolerances from loose to tight, each once.

    Raises:
        ValueError: none, or one out of bounds.
    """
    if not rtols:
        raise ValueError("rtols must be at least one tolerance, got none")
    for rtol in rtols:
        if not TIGHTEST <= rtol <= LOOSEST:
            raise ValueError(f"rtol must lie in [{TIGHTEST}, {LOOSEST}], got {rtol!r}")
    return tuple(sorted({float(rtol) for rtol in rtols}, reverse=True))


def speed_at(error: float, errors: Array, speeds: Array) -> float:
    """Speed of a method at an error, between its rungs log against log; at an end's beyond it.

    NaN if no rung, or the error asked for, is that of the same stride (`LOST`).
    """
    good = (errors > 0) & (errors < LOST)
    if not good.any() or not error < LOST:
        return float("nan")
    order = np.argsort(errors[good])
    x, y = np.log(errors[good][order]), np.log(speeds[good][order])
    return float(np.exp(np.interp(np.log(max(error, 1e-300)), x, y)))


def _prepare(contender: Contender, problem: Problem, rtol: float) -> tuple[float, Case]:
    """The error, and what to time: the contender compiled and seen to run."""
    advance = contender.make(problem, rtol)
    error = problem.error(advance(problem.starts[:STARTS]))
    batch = np.resize(problem.starts, (contender.batch, 4))
    return error, Case(lambda: advance(batch), contender.batch)


def _rungs(
    present: list[Contender], rtols: tuple[float, ...], errors: Array, timings: list[Timing]
) -> list[Rung]:
    """Medians, and ratios taken round by round."""
    count = len(rtols)
    base = timings[BASELINE * count : (BASELINE + 1) * count]
    rungs = []
    for i, contender in enumerate(present):
        for j, rtol in enumerate(rtols):
            timing, error = timings[i * count + j], float(errors[i, j])
            clock = "wall" if contender.every_core else "cpu"
            per_stride = getattr(timing, clock)
            base_speeds = np.array([1.0 / getattr(rung, clock) for rung in base])  # (rtols, rounds)
            ratios = [
                1.0 / (own * speed_at(error, errors[BASELINE], speeds))
                for own, speeds in zip(per_stride, base_speeds.T, strict=True)
            ]
            rungs.append(
                Rung(
                    contender.name,
                    "all" if contender.every_core else "1",
                    rtol,
                    error,
                    timing.rate if contender.every_core else timing.rate_per_core,
                    float(np.median(ratios)),
                    timing.cores,
                )
            )
    return rungs


def _distance(contender: Contender, problem: Problem) -> float:
    """Of a contender at its tightest from the reference, over the starts."""
    return problem.error(contender.make(problem, TIGHTEST)(problem.starts[:STARTS]))


def _worst(problem: Problem, rtol: float) -> float:
    """The largest error of all the starts, by this package."""
    batch = stride_batch(problem.starts[:MANY], problem.controls, problem.params, rtol=rtol)
    return problem.error(batch.state)
