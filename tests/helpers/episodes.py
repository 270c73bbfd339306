"""Walks through environments, recorded so that they can be compared bit for bit."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from powered_walker_env import ENVIRONMENTS, PoweredWalkerEnv

IDS = tuple(ENVIRONMENTS)
ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
#: All kinds at once, gentle enough for a few strides of the round-foot walker.
EVERYTHING = {
    "push": 0.02,
    "ground": 0.002,
    "slope": 0.005,
    "torque": 0.02,
    "sensor": 0.1,
    "parameters": 0.02,
}
FORWARD_FALL = (0.9, 0.5, 3.0, 0.0)  # a state from which the stance leg goes over forwards

Env = gym.Env[Any, Any]


def make(env_id: str = ROUND_FOOT, **kwargs: Any) -> PoweredWalkerEnv:
    """The environment itself, without the wrappers of `gym.make`."""
    env = gym.make(env_id, disable_env_checker=True, **kwargs).unwrapped
    assert isinstance(env, PoweredWalkerEnv)
    return env


def gentle_actions(count: int, seed: int = 0) -> np.ndarray:
    """(count, 2) random actions among which a walk lasts some strides and then falls."""
    return np.random.default_rng(seed).uniform(-0.1, 0.1, (count, 2)).astype(np.float32)


def record(env: Env, strides: int, seed: int | None = None) -> list[Any]:
    """Everything that an environment gives over some strides, begun with a reset."""
    return [env.reset(seed=seed), *go_on(env, strides)]


def go_on(env: Env, strides: int) -> list[Any]:
    """Everything that an environment gives over some more strides, reset at every end."""
    given: list[Any] = []
    for action in gentle_actions(strides):
        given.append(env.step(action))
        if given[-1][2] or given[-1][3]:
            given.append(env.reset())
    return given


def assert_same(one: Any, two: Any, where: str = "") -> None:
    """Equal to the last bit, in types, shapes and keys, too."""
    assert type(one) is type(two), f"{where}: {type(one)} and {type(two)}"
    if isinstance(one, dict):
        assert one.keys() == two.keys(), f"{where}: {one.keys() ^ two.keys()}"
        for key in one:
            assert_same(one[key], two[key], f"{where}[{key!r}]")
    elif isinstance(one, (list, tuple)):
        assert len(one) == len(two), where
        for i, pair in enumerate(zip(one, two, strict=True)):
            assert_same(*pair, f"{where}[{i}]")
    elif isinstance(one, np.ndarray) and one.dtype == object:
        assert one.shape == two.shape, where
        assert_same(list(one), list(two), where)
    elif isinstance(one, np.ndarray):
        assert one.dtype == two.dtype, f"{where}: {one.dtype} and {two.dtype}"
        np.testing.assert_array_equal(one, two, err_msg=where)
    else:
        assert one == two, f"{where}: {one!r} and {two!r}"
