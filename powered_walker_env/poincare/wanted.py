"""A gait with a step length, a speed or both asked for, by as many controls or parameters.

Solved for the state and those numbers at once, with exact derivatives of the step length and
the duration; where Newton alone does not reach, the wanted values are approached in steps.
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
    """Quantities of the gait that are to have values."""

    names: tuple[str, ...]  # of "step_length" and "speed"
    values: Array  # (k,)
    units: Array  # (k,) the quantities of one leg length, of one leg length per √(L/g)

    def __str__(self) -> str:
        return self.text(self.values)

    def text(self, values: Array, digits: str = "") -> str:
        """The quantities with these values, as messages print them."""
        pairs = zip(self.names, values.tolist(), strict=True)
        return " and ".join(f"{name} = {format(value, digits)}" for name, value in pairs)

    def of(self, equations: Equations, family: Family) -> tuple[Array, Array]:
        """(k,) the quantities here, and (k, n) their derivatives by the unknowns; both scaled."""
        point = equations.point
        free = range(STATE_SIZE + point.controls, len(point.step_length_by))
        columns = [*range(STATE_SIZE), *free]
        length, by = point.step_length, point.step_length_by[columns]
        speed = length / point.duration
        found = {
            "step_length": (length, by),
            "speed": (speed, (by - speed * point.duration_by[columns]) / point.duration),
        }
        values = np.array([found[name][0] for name in self.names])
        rows = np.array([found[name][1] for name in self.names])
        return values / self.units, rows * family.units / self.units[:, np.newaxis]


def find_gait_with(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    *,
    step_length: float | None = None,
    speed: float | None = None,
    by: str | Sequence[str] = "stall_torque",
    guess: Gait | PostStrikeState | Sequence[float] | None = None,
) -> Gait:
    """A gait with a given step length, speed, or both, found by changing one or two numbers.

    Args:
        params: the walker.
        control: where the search begins: a control, None for a passive walker, a policy.
        step_length: wanted, m per stride.
        speed: wanted, m/s. Give one of the two, or both.
        by: what may change, any names of `PARAMETERS`, as many as are wanted; "slope" suits
            passive walkers, and under a policy no control can be named.
        guess: a gait, or a post-strike state near one, of this walker; left out, the most
            stable gait of a short search.

    Returns:
        The gait; its `params` and `control` hold the values found. Where several have what is
        wanted, the first along the branch of the guess; `continue_gait` shows them all.

    Raises:
        GaitNotFoundError: with how near it came.
        ValueError: a bad argument.
    """
    wanted = _wanted(params, step_length, speed)
    names = _free(by, control, len(wanted.names))
    if guess is None:
        gaits = find_gaits(params, control, starts=FEW_STARTS)
        first = gaits[0] if gaits else find_gait(params, control)
    else:
        state = guess.state if isinstance(guess, Gait) else check_state(guess)
        first = find_gait(params, control, state)
    here = Family(params, control, names, np.ones(len(names))).current()
    family = Family(params, control, names, np.where(here == 0.0, 1.0, abs(here)))
    u = _approach(family, family.unknowns(first.state, here), wanted)
    stride_map, found = family.stride_map(family.values(u)), family.state(u)
    if reason := refusal(stride_map, found, 1):
        raise GaitNotFoundError(f"no gait with {wanted}: {reason}")
    return describe(stride_map, found, first.section, 1)


def _wanted(params: WalkerParams, step_length: float | None, speed: float | None) -> _Wanted:
    length = params.leg_length
    units = {"step_length": length, "speed": math.sqrt(params.gravity * length)}
    given = {"step_length": step_length, "speed": speed}
    asked = {name: value for name, value in given.items() if value is not None}
    if not asked:
        raise ValueError("give step_length, speed or both, got none")
    for name, value in asked.items():
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name} must be positive and finite, got {value!r}")
    scales = np.array([units[name] for name in asked])
    return _Wanted(tuple(asked), np.array(list(asked.values()), np.float64), scales)


def _free(
    by: str | Sequence[str], control: AnyControl | Policy | None, count: int
) -> tuple[str, ...]:
    """The names of what may change, checked."""
    names = (by,) if isinstance(by, str) else tuple(by)
    for name in names:
        check_parameter(name, control)
    if len(set(names)) != len(names) or len(names) != count:
        raise ValueError(
            f"by must be {count} different name{'s' * (count > 1)}, one for each of step_length "
            f"and speed that is wanted, got {by!r}"
        )
    return names


def _approach(family: Family, u: Array, wanted: _Wanted) -> Array:
    """The gait with the wanted values, in as few steps towards them as Newton can take."""
    start, _ = wanted.of(family.evaluate(u), family)
    way, done, share = wanted.values / wanted.units - start, 0.0, 1.0
    while done < 1.0 and way.any():
        target = min(done + share, 1.0)
        try:
            u = _solve(family, u, wanted, start + target * way)
        except OffCurveError as problem:
            share *= 0.5
            if share < SMALLEST_SHARE:
                found = ", ".join(
                    f"{name} = {value:.6g}"
                    for name, value in zip(family.names, family.values(u).tolist(), strict=True)
                )
                nearest = wanted.text((start + done * way) * wanted.units, ".6g")
                raise GaitNotFoundError(
                    f"no gait with {wanted} found by {', '.join(family.names)}: the nearest has "
                    f"{nearest} at {found}, beyond which {problem}; ask for less, or change "
                    "another parameter"
                ) from problem
        else:
            done = target
    return u


def _solve(family: Family, u: Array, wanted: _Wanted, target: Array) -> Array:
    """Newton on the state and the numbers that may change, on the branch that u is on.

    Raises:
        OffCurveError: it does not converge, strays from the branch, or the walker falls.
    """
    last, straying, allowed = math.inf, 0.0, math.inf
    what = " and ".join(wanted.names)
    for taken in range(NEWTON_STEPS):
        equations = family.evaluate(u)
        values, gradients = wanted.of(equations, family)
        matrix = np.vstack([equations.jacobian, gradients])
        try:
            change = np.linalg.solve(matrix, np.append(equations.residual, values - target))
        except np.linalg.LinAlgError as error:
            raise OffCurveError(f"the {what} does not depend on it") from error
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
    raise OffCurveError(f"Newton does not converge: the {what} may be at its limit")
