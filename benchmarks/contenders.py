"""Who walks the same stride: this package, scipy's DOP853 and heyoka's Taylor series.

Each contender makes, for a tolerance, a function from post-strike states to the next
ones. scipy integrates phase by phase with `solve_ivp` and a terminal event; its
right-hand side is plain Python, or the same function compiled by numba.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.equations import Array, Equations, equations
from benchmarks.problem import MANY, Problem
from powered_walker_env.simulation.strides import stride, stride_batch
from powered_walker_env.simulation.threads import at_most, cores

Advance = Callable[[Array], Array]  # (n, 4) post-strike states to the next ones

LONGEST = 10.0  # s: no stride of the presets lasts longer
FAILED = np.full(4, np.nan)


@dataclass(frozen=True)
class Contender:
    """A way to walk a stride."""

    name: str
    make: Callable[[Problem, float], Advance]  # from the problem and rtol
    batch: int  # strides walked by one timed call
    every_core: bool = False
    missing: str = ""  # what to install, if it cannot run


def contenders() -> list[Contender]:
    """All of them, also those that are not installed; scipy's plain one first."""
    lacks = "" if importlib.util.find_spec("heyoka") else "not installed: pip install heyoka"
    return [
        Contender("scipy DOP853, Python", lambda p, rtol: scipy_strides(p, rtol, False), 2),
        Contender("scipy DOP853, numba", lambda p, rtol: scipy_strides(p, rtol, True), 4),
        Contender("heyoka, scalar", _heyoka, 64, missing=lacks),
        Contender("ours, stride by stride", _one_by_one, 64),
        Contender("ours, a batch", _batch, MANY),
        Contender("ours, a batch, all cores", _parallel, MANY * cores(), every_core=True),
    ]


def scipy_strides(problem: Problem, rtol: float, jitted: bool) -> Advance:
    """Strides by scipy; a state that does not walk gives NaN."""
    functions = equations(problem.constants, jitted=jitted)

    def advance(states: Array) -> Array:
        return np.array([scipy_stride(functions, problem, state, rtol)[0] for state in states])

    return advance


def scipy_stride(
    functions: Equations, problem: Problem, state: Array, rtol: float
) -> tuple[Array, NDArray[np.int64]]:
    """One stride by scipy: the next state, and (2, 2) steps accepted and evaluations by phase."""
    lock = problem.params.locked_ankle_angle
    alpha, s, d_alpha, d_beta = state
    y = np.array([alpha, s + np.pi, d_alpha, d_beta])
    work = np.zeros((2, 2), np.int64)
    t = 0.0
    phases = ((functions.swing, functions.switched), (functions.extension, functions.landed))
    for phase, (flow, guard) in enumerate(phases):
        solution = solve_ivp(
            flow, (t, LONGEST), y, "DOP853", rtol=rtol, atol=rtol, events=_Ending(guard)
        )
        work[phase] = len(solution.t) - 1, solution.nfev
        if solution.status != 1:
            return FAILED, work
        t, y = float(solution.t[-1]), solution.y[:, -1]
        if phase == 0:
            y = np.array([y[0] - lock, y[0], y[1], y[2], y[2], y[3]])
    ahead = y[1] > y[2] - np.pi  # else the foot scuffed as the legs passed
    return (functions.strike(y) if ahead else FAILED), work


class _Ending:
    """A guard as scipy's terminal event, looked for as it falls."""

    terminal, direction = True, -1.0

    def __init__(self, guard: Callable[[float, Array], float]) -> None:
        self.guard = guard

    def __call__(self, t: float, y: Array) -> float:
        return self.guard(t, y)


def _one_by_one(problem: Problem, rtol: float) -> Advance:
    def advance(states: Array) -> Array:
        control, params = problem.control, problem.params
        rows = states.tolist()
        return np.array([stride(row, control, params, rtol=rtol).state for row in rows])

    return advance


def _batch(problem: Problem, rtol: float) -> Advance:
    def advance(states: Array) -> Array:
        with at_most(1):
            return stride_batch(states, problem.controls, problem.params, rtol=rtol).state

    return advance


def _parallel(problem: Problem, rtol: float) -> Advance:
    def advance(states: Array) -> Array:
        return stride_batch(states, problem.controls, problem.params, rtol=rtol).state

    return advance


def _heyoka(problem: Problem, rtol: float) -> Advance:
    from benchmarks.taylor import taylor_strides

    return taylor_strides(problem, rtol)
