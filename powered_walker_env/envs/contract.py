"""What single and vector environments have in common: spaces, and checks of what is given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from powered_walker_env.envs.task import OBSERVATION_LIMIT
from powered_walker_env.model.powering import Scheme
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.simulation.strides import Array

STRIDE_RTOL = 1e-8
RESET_OPTIONS = ("state",)


def observation_space() -> gym.Space[NDArray[np.float32]]:
    """Deviations from the gait, finite bounds."""
    space: Any = gym.spaces.Box(-OBSERVATION_LIMIT, OBSERVATION_LIMIT, (4,), np.float32)
    return space


def action_space(powered: Scheme) -> gym.Space[NDArray[np.float32]]:
    """One for each number of the control, as switch angle and stall torque; 0: the open loop."""
    space: Any = gym.spaces.Box(-1.0, 1.0, (len(powered.numbers),), np.float32)
    return space


def check_render_mode(mode: str | None, known: list[str]) -> str | None:
    """The render mode.

    Raises:
        ValueError: one that does not exist.
    """
    if mode is not None and mode not in known:
        raise ValueError(f"render_mode must be one of {known}, or None, got {mode!r}")
    return mode


def check_count(name: str, value: int) -> None:
    """Reject a number of walkers or strides below 1.

    Raises:
        ValueError: naming it.
    """
    if value < 1:
        raise ValueError(f"{name} must be at least 1, got {value!r}")


def check_options(options: dict[str, Any] | None) -> PostStrikeState | None:
    """The start that reset options ask for.

    Raises:
        ValueError: an option that does not exist, or a state that is not four numbers.
    """
    unknown = [name for name in options or {} if name not in RESET_OPTIONS]
    if unknown:
        raise ValueError(f"reset options are {', '.join(RESET_OPTIONS)}, got {unknown[0]!r}")
    state = (options or {}).get("state")
    return None if state is None else check_state(state)


def check_action(action: Any, shape: tuple[int, ...] | None, powered: Scheme) -> Array:
    """The action as float64.

    Raises:
        ValueError: another shape, or a number that is not finite.
    """
    try:
        wanted = np.asarray(action, np.float64, "C")
    except (TypeError, ValueError):
        raise ValueError(f"action must be numbers of shape {shape}, got {action!r}") from None
    if wanted.shape != shape:
        numbers = ", ".join(name.replace("_", " ") for name in powered.numbers)
        raise ValueError(
            f"action must have shape {shape}, ({numbers}) for each walker, got {wanted.shape}"
        )
    few = wanted.ndim == 1  # of which Python's own function is quicker
    if not (all(map(math.isfinite, wanted.tolist())) if few else np.isfinite(wanted).all()):
        raise ValueError(f"action must be finite, got {wanted[~np.isfinite(wanted)][0]}")
    return wanted


def check_seeds(seed: int | Sequence[int | None] | None, count: int) -> list[int | None]:
    """The seeds of `count` walkers.

    Raises:
        ValueError: another number of seeds.
    """
    if seed is None:
        return [None] * count
    if isinstance(seed, (int, np.integer)):
        return [int(seed) + i for i in range(count)]
    if len(seed) != count:
        raise ValueError(f"seed must be one or {count} seeds, got {len(seed)}")
    return list(seed)


def check_mask(mask: Any, count: int) -> NDArray[np.bool_]:
    """Which of `count` walkers are to be reset; all, if nothing is said.

    Raises:
        ValueError: no array of so many bool, or one without a True.
    """
    if mask is None:
        return np.ones(count, np.bool_)
    good = isinstance(mask, np.ndarray) and mask.dtype == np.bool_
    if not (good and mask.shape == (count,) and mask.any()):
        raise ValueError(f"options['reset_mask'] must be ({count},) bool with a True, got {mask!r}")
    chosen: NDArray[np.bool_] = mask
    return chosen


def masked(info: dict[str, NDArray[Any]], mask: NDArray[np.bool_] | None = None) -> dict[str, Any]:
    """Gymnasium's form: every key with a `_key` that says whose values count, others zero.

    Args:
        mask: (N,); every walker if left out.
    """
    result: dict[str, Any] = {}
    count = len(next(iter(info.values())))
    masks = np.ones((len(info), count), np.bool_)  # each key's own
    if mask is not None:
        masks &= mask
    for own, (name, values) in zip(masks, info.items(), strict=True):
        result[name], result[f"_{name}"] = values, own
        if mask is not None:
            result[name] = np.zeros_like(values)
            result[name][mask] = values[mask]
    return result


def endings(
    observation: NDArray[np.float32], info: dict[str, NDArray[Any]], over: NDArray[np.bool_]
) -> dict[str, Any]:
    """The last observation and info of the walkers that are over, as SAME_STEP has them."""
    final = np.full(len(over), None, dtype=object)
    for i in np.flatnonzero(over):
        final[i] = observation[i]
    last = masked(info, over)
    return {
        "final_obs": final,
        "_final_obs": over.copy(),
        "final_info": last,
        "_final_info": over.copy(),
    }
