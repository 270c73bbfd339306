"""What all have to solve, one stride each from scattered starts near a gait, and who solves it:
this package, scipy's DOP853 and heyoka's Taylor series.

scipy integrates phase by phase with `solve_ivp` and a terminal event; its right-hand side is
plain Python, or the same function compiled by numba. heyoka's are in `taylor`.
"""

from __future__ import annotations

import functools
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.equations import (
    Array,
    Constants,
    Equations,
    constants,
    equations,
)
from powered_walker_env.model.powering import Control
from powered_walker_env.model.presets import preset
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.arguments import TIGHTEST
from powered_walker_env.simulation.strides import stride, stride_batch
from powered_walker_env.simulation.threads import at_most, cores

SPREAD = (0.003, 0.003, 0.01, 0.01)  # rad, rad/s: within the basins of the presets
STARTS = 16  # at which errors are measured
MANY = 1024  # strides in a batch: enough for every lane of every core, little memory
SEED = 1997
SHORTEST_STEP = 0.01  # leg lengths: where the feet all but meet, tolerance decides what landed
LONGEST = 10.0  # s: no stride of the presets lasts longer

Advance = Callable[[Array], Array]  # (n, 4) post-strike states to the next ones, NaN for a fall


@dataclass(frozen=True, eq=False)
class Problem:
    """A walker, its starts, and where they lead."""

    name: str
    params: WalkerParams
    control: Control
    starts: Array  # (MANY, 4) post-strike states
    ends: Array  # (MANY, 4) the next ones, to rounding: by the package at its tightest

    @property
    def constants(self) -> Constants:
        """For the equations of the others."""
        return constants(self.params, self.control)

    @property
    def controls(self) -> Array:
        """(2,) switch angle and stall torque."""
        return np.array([self.control.switch_angle, self.control.stall_torque])

    def walked(self, states: Array, rtol: float) -> Array:
        """Where this package's batch leads."""
        return stride_batch(states, self.controls, self.params, rtol=rtol).state

    def error(self, ends: Array) -> float:
        """Largest component by which ends of the first starts are off; NaN counts as infinite."""
        off = np.abs(np.asarray(ends) - self.ends[: len(ends)])
        return float(np.where(np.isnan(off), np.inf, off).max())


def make_problem(name: str) -> Problem:
    """The problem at a preset.

    Raises:
        ValueError: no such preset, none with the motor, or the physics of the listing.
    """
    params, control, state, _ = preset(name)
    if type(control) is not Control:
        raise ValueError(f"preset must be a walker with the motor, got {name!r}")
    constants(params, control)
    rng = np.random.default_rng(SEED)
    starts = np.array(state) + np.array(SPREAD) * rng.uniform(-1, 1, (2 * MANY, 4))
    walked = stride_batch(starts, control, params, rtol=TIGHTEST)
    rows = np.flatnonzero(walked.step_length > SHORTEST_STEP * params.leg_length)[:MANY]
    if len(rows) < MANY:
        raise ValueError(
            f"preset must walk from the states around its gait, got {name!r}, "
            f"where {len(rows)} of {len(starts)} do"
        )
    return Problem(name, params, control, starts[rows], walked.state[rows])


class Method(NamedTuple):
    """A way to walk a stride."""

    name: str
    make: Callable[[Problem, float], Advance]  # from the problem and rtol
    batch: int  # strides walked by one timed call
    every_core: bool = False
    missing: str = ""  # what to install, if it cannot run


def methods() -> list[Method]:
    """All of them, also those that are not installed; scipy's plain one first."""
    lacks = "" if importlib.util.find_spec("heyoka") else "not installed: pip install heyoka"
    return [
        Method("scipy DOP853, Python", lambda p, rtol: scipy_strides(p, rtol, False), 2),
        Method("scipy DOP853, numba", lambda p, rtol: scipy_strides(p, rtol, True), 4),
        Method("heyoka, scalar", functools.partial(_taylor, "scalar"), 64, missing=lacks),
        Method("heyoka, a batch", functools.partial(_taylor, "batch"), MANY, missing=lacks),
        Method("ours, stride by stride", _one_by_one, 64),
        Method("ours, a batch", _on_one_core, MANY),
        Method("ours, a batch, all cores", _on_all_cores, MANY * cores(), every_core=True),
    ]


def _taylor(mode: str, problem: Problem, rtol: float) -> Advance:
    from benchmarks import taylor  # which needs heyoka

    made: Advance = getattr(taylor, f"{mode}_strides")(problem.constants, rtol)
    return made


def _one_by_one(problem: Problem, rtol: float) -> Advance:
    control, params = problem.control, problem.params
    return lambda states: np.array(
        [stride(row, control, params, rtol=rtol).state for row in states.tolist()]
    )


def _on_one_core(problem: Problem, rtol: float) -> Advance:
    def advance(states: Array) -> Array:
        with at_most(1):
            return problem.walked(states, rtol)

    return advance


def _on_all_cores(problem: Problem, rtol: float) -> Advance:
    return lambda states: problem.walked(states, rtol)


def scipy_strides(problem: Problem, rtol: float, jitted: bool) -> Advance:
    """Strides by scipy."""
    functions = equations(problem.constants, jitted=jitted)
    return lambda states: np.array(
        [scipy_stride(functions, problem, row, rtol)[0] for row in states]
    )


def scipy_stride(
    functions: Equations, problem: Problem, state: Array, rtol: float
) -> tuple[Array, NDArray[np.int64]]:
    """One stride by scipy: the next state, and evaluations by phase."""
    alpha, s, d_alpha, d_beta = state
    y, t = np.array([alpha, s + np.pi, d_alpha, d_beta]), 0.0
    evaluations, failed = np.zeros(2, np.int64), np.full(4, np.nan)
    phases = ((functions.swing, functions.switched), (functions.extension, functions.landed))
    for phase, (flow, guard) in enumerate(phases):
        solution = solve_ivp(
            flow, (t, LONGEST), y, "DOP853", rtol=rtol, atol=rtol, events=_Ending(guard)
        )
        evaluations[phase] = solution.nfev
        if solution.status != 1:
            return failed, evaluations
        t, y = float(solution.t[-1]), solution.y[:, -1]
        if phase == 0:
            y = np.array([y[0] - problem.constants.lock, y[0], y[1], y[2], y[2], y[3]])
    ahead = y[1] > y[2] - np.pi  # else the foot scuffed as the legs passed
    return (functions.strike(y) if ahead else failed), evaluations


class _Ending:
    """A guard as scipy's terminal event, looked for as it falls."""

    terminal, direction = True, -1.0

    def __init__(self, guard: Callable[[float, Array], float]) -> None:
        self.guard = guard

    def __call__(self, t: float, y: Array) -> float:
        return self.guard(t, y)
