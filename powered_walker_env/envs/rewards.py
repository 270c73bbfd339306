"""Rewards: what a stride is worth. Formulas by name, or a function of one's own.

Distances are in units of `task.state_scale`; d is that of a post-strike state from the gait.
A new formula is a name in `REWARDS`, with its words, and a line of `stability_reward`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from powered_walker_env.compiled.decorators import internal, rare
from powered_walker_env.envs.paths import imported
from powered_walker_env.model.mechanics.packing import GRAVITY, LEG_LENGTH, LEG_MASS
from powered_walker_env.simulation.record import POSITIVE_WORK, STEP_LENGTH
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.walked import StrideBatch

#: Name to what it is, as the environment's documentation says it.
REWARDS = {
    "deviation": "exp(−d²/2) after the stride; 0 on a fall",
    "contraction": "log((d + ε)/(d' + ε)), d before and d' after the stride and ε = 0.01. The "
    "sum telescopes: the return is the measured stability. −10 on a fall",
    "periodicity": "exp(−d²/2) with d the distance between successive post-strike states: no "
    "target gait needed; 0 on a fall",
}
CONTRACTION, PERIODICITY = (list(REWARDS).index(name) for name in ("contraction", "periodicity"))
CONTRACTION_FLOOR = 0.01  # ε: a distance of less than a hundredth of the scale is "on the gait"
CONTRACTION_FALL = -10.0  # log(40/0.01) is 8.3: more than a walk loses inside the observed box
SHORTEST_STEP = 0.01  # leg lengths; a shorter step costs as much as this one, not infinity

#: One's own: (N, 4) states before and after N strides, and the strides, to (N,) rewards.
Reward = Callable[[Array, Array, StrideBatch], Array]


def reward_of(choice: Any) -> str | Reward:
    """The reward that a constructor argument means: a name, or a function.

    Args:
        choice: a name in `REWARDS`, a function, or the path of one, "module:function".

    Raises:
        ValueError: an unknown name, a path that leads nowhere, or something else.
    """
    if callable(choice):
        return choice
    if isinstance(choice, str) and choice in REWARDS:
        return choice
    if isinstance(choice, str) and ":" in choice:
        return _function_at(choice)
    raise ValueError(
        f"reward must be one of {', '.join(REWARDS)}, a function of (before, after, strides) or "
        f"its path 'module:function', got {choice!r}"
    )


def path_of(function: Reward) -> str:
    """The path "module:function" of a function, for arguments that must be JSON.

    Raises:
        ValueError: a function that cannot be imported by its name.
    """
    path = f"{function.__module__}:{getattr(function, '__qualname__', function)}"
    try:
        found: Any = _function_at(path)
    except ValueError:
        found = None
    if found is not function:
        raise ValueError(
            f"reward must be importable to be written down, got {function!r}; define it in a "
            "module, not inside a function or in __main__"
        )
    return path


def own_rewards(function: Reward, before: Array, after: Array, strides: StrideBatch) -> Array:
    """(N,) what a function of one's own makes of N strides.

    Raises:
        ValueError: it does not give one finite number for each stride.
    """
    given = np.asarray(function(before, after, strides), np.float64)
    if given.shape != (len(before),) or not np.isfinite(given).all():
        raise ValueError(
            f"reward must give ({len(before)},) finite numbers, one for each stride, got "
            f"{given!r} from {function!r}; after a fall the state is that before the stride"
        )
    return given


def _function_at(path: str) -> Reward:
    try:
        found = imported(path)
    except ImportError as error:
        raise ValueError(
            f"reward must lead to a function, got {path!r}: {error.__cause__}"
        ) from error
    if not callable(found):
        raise ValueError(f"reward must lead to a function, got {path!r}, which is {found!r}")
    function: Reward = found
    return function


@internal
def distance(states: Array, i: int, others: Array, k: int, scale: Array) -> float:
    """Distance of two post-strike states, rows i and k, in units of the scale."""
    total = 0.0
    for j in range(4):
        apart = (states[i, j] - others[k, j]) / scale[j]
        total += apart * apart
    return math.sqrt(total)


@rare
def distance_to_gait(states: Array, i: int, gait: Array, scale: Array) -> float:
    """Distance to the nearest point of the gait's cycle."""
    nearest = math.inf
    for k in range(gait.shape[0]):
        apart = distance(states, i, gait, k, scale)
        if apart < nearest:
            nearest = apart
    return nearest


@rare
def stability_reward(
    kind: int, states: Array, i: int, landed: Array, k: int, gait: Array, scale: Array
) -> float:
    """Reward of a stride that walked from row i of `states` to row k of `landed`.

    Args:
        kind: index in `REWARDS`.
    """
    if kind == PERIODICITY:
        moved = distance(states, i, landed, k, scale)
        return math.exp(-0.5 * (moved * moved))
    after = distance_to_gait(landed, k, gait, scale)
    if kind == CONTRACTION:
        before = distance_to_gait(states, i, gait, scale)
        return math.log((before + CONTRACTION_FLOOR) / (after + CONTRACTION_FLOOR))
    return math.exp(-0.5 * (after * after))


@rare
def cost_of_transport(results: Array, i: int, packed: Array, k: int) -> float:
    """Positive work of a stride over weight times step length; row k of the packed walkers."""
    length, mass, gravity = packed[k, LEG_LENGTH], packed[k, LEG_MASS], packed[k, GRAVITY]
    step, shortest = results[i, STEP_LENGTH], SHORTEST_STEP * length
    if step < shortest:
        step = shortest
    return results[i, POSITIVE_WORK] / (2.0 * mass * gravity * step)
