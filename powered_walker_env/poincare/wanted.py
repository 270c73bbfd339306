"""A gait with a step length or a speed asked for, by one control or parameter.

Solved for the state and that number at once, with exact derivatives of the step length and
the duration; where Newton alone does not reach, the wanted value is approached in steps.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.families import Equations, Family, OffCurveError, check_parameter
from powered_walker_env.poincare.fixed_points import refusal
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, describe, find_gait
from powered_walker_env.poincare.search import FEW_STARTS, find_gaits
from powered_walker_env.poincare.tolerances import NEWTON_STEPS, RESIDUAL
from powered_walker_env.simulation.derivatives import STATE_SIZE
from powered_walker_env.simulation.strides import Array

OFF_BRANCH = 0.3  # more correction than this share of the first step: perhaps another branch
SMALLEST_SHARE = 1e-5  # of the way to the wanted value, before giving up


class _Wanted(NamedTuple):
    """A quantity of the gait that is to have a value."""

    name: str  # "step_length" or "speed"
    value: float
    unit: float  # the quantity of one leg length, or one leg length per √(L/g)

    def of(self, equations: Equations, family: Family) -> tuple[float, Array]:
        """The quantity here, and its derivative by the family's unknowns; both scaled."""
        point = equations.point
        free = range(STATE_SIZE + point.controls, len(point.step_length_by))
        columns = [*range(STATE_SIZE), *free]
        value, by = point.step_length, point.step_length_by[columns]
        if self.name == "speed":
            value = point.step_length / point.duration
            by = (by - value * point.duration_by[columns]) / point.duration
        return value / self.unit, by * family.units / self.unit


def find_gait_with(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    *,
    step_length: float | None = None,
    speed: float | None = None,
    by: str = "stall_torque",
    guess: Gait | PostStrikeState | Sequence[float] | None = None,
) -> Gait:
    """A gait with a given step length or speed, found by changing one control or parameter.

    Args:
        params: the walker.
        control: where the search begins: a control, None for a passive walker, a policy.
        step_length: wanted, m per stride.
        speed: wanted, m/s. Give one of the two.
        by: what may change, any name of `PARAMETERS`; "slope" suits passive walkers, and
            under a policy no control can be named.
        guess: a gait, or a post-strike state near one, of this walker; left out, the most
            stable gait of a short search.

    Returns:
        The gait; its `params` and `control` hold the value found. Where several have what is
        wanted, the first along the branch of the guess; `continue_gait` shows them all.

    Raises:
        GaitNotFoundError: with how near it came.
        ValueError: a bad argument.
    """
    wanted = _wanted(params, step_length, speed)
    check_parameter(by, control)
    if guess is None:
        gaits = find_gaits(params, control, starts=FEW_STARTS)
        first = gaits[0] if gaits else find_gait(params, control)
    else:
        state = guess.state if isinstance(guess, Gait) else check_state(guess)
        first = find_gait(params, control, state)
    here = Family(params, control, (by,), np.ones(1)).current()
    family = Family(params, control, (by,), np.array([abs(here[0]) or 1.0]))
    u = _approach(family, family.unknowns(first.state, here), wanted)
    stride_map, found = family.stride_map(family.values(u)), family.state(u)
    if reason := refusal(stride_map, found, 1):
        raise GaitNotFoundError(f"no gait with {wanted.name} = {wanted.value!r}: {reason}")
    return describe(stride_map, found, first.section, 1)


def _wanted(params: WalkerParams, step_length: float | None, speed: float | None) -> _Wanted:
    if (step_length is None) == (speed is None):
        raise ValueError(
            f"give either step_length or speed, got step_length={step_length!r}, speed={speed!r}"
        )
    name, value = ("speed", speed) if step_length is None else ("step_length", step_length)
    if value is None or not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be positive and finite, got {value!r}")
    length = params.leg_length
    unit = length if name == "step_length" else math.sqrt(params.gravity * length)
    return _Wanted(name, value, unit)


def _approach(family: Family, u: Array, wanted: _Wanted) -> Array:
    """The gait with the wanted value, in as few steps of that value as Newton can take."""
    value, _ = wanted.of(family.evaluate(u), family)
    goal, share = wanted.value / wanted.unit, 1.0
    total = goal - value
    while value != goal:
        target = goal if abs(goal - value) <= abs(share * total) else value + share * total
        try:
            u = _solve(family, u, wanted, target)
        except OffCurveError as problem:
            share *= 0.5
            if share < SMALLEST_SHARE:
                name, found = family.names[0], family.values(u)[0]
                raise GaitNotFoundError(
                    f"no gait with {wanted.name} = {wanted.value!r} found by {name}: the "
                    f"nearest has {value * wanted.unit:.6g} at {name} = {found:.6g}, beyond "
                    f"which {problem}; ask for less, or change another parameter"
                ) from problem
        else:
            value = target
    return u


def _solve(family: Family, u: Array, wanted: _Wanted, target: float) -> Array:
    """Newton on the five unknowns, on the branch that u is on.

    Raises:
        OffCurveError: it does not converge, strays from the branch, or the walker falls.
    """
    last, straying, allowed = math.inf, 0.0, math.inf
    for taken in range(NEWTON_STEPS):
        equations = family.evaluate(u)
        value, gradient = wanted.of(equations, family)
        matrix = np.vstack([equations.jacobian, gradient])
        try:
            change = np.linalg.solve(matrix, np.append(equations.residual, value - target))
        except np.linalg.LinAlgError as error:
            raise OffCurveError(f"the {wanted.name} does not depend on it") from error
        size = float(np.linalg.norm(change))
        if size < RESIDUAL or (size < 1e-8 and size > 0.25 * last):
            return u
        if taken == 0:
            allowed = max(OFF_BRANCH * size, 1e-6)
        else:
            straying += size
        if straying > allowed:
            break
        u, last = u - change, size
    raise OffCurveError(f"Newton does not converge: the {wanted.name} may be at its limit")
