"""Gymnasium's own checker, and what its test-suite asks of each of its environments."""

from __future__ import annotations

import pickle
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env, data_equivalence

from tests.helpers.episodes import IDS

pytestmark = pytest.mark.slow
MODES = (None, "rgb_array", "rgb_array_list")
STRIDES = 100


@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("mode", MODES)
def test_the_checker_has_no_complaint(env_id: str, mode: str | None) -> None:
    env = gym.make(env_id, render_mode=mode, disable_env_checker=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=mode is None)
    env.close()


@pytest.mark.parametrize("env_id", IDS)
def test_two_rollouts_of_one_seed_are_equal(env_id: str) -> None:
    one, two = gym.make(env_id), gym.make(env_id)
    assert data_equivalence(one.reset(seed=7), two.reset(seed=7))
    one.action_space.seed(7)
    for _ in range(STRIDES):
        action = one.action_space.sample()
        given, expected = one.step(action), two.step(action)
        assert data_equivalence(given, expected, exact=True)
        observation, reward, terminated, truncated, info = given
        assert observation in one.observation_space
        assert isinstance(info, dict) and np.isfinite(reward)
        if terminated or truncated:
            assert data_equivalence(one.reset(), two.reset(), exact=True)


@pytest.mark.parametrize("env_id", IDS)
def test_resets_of_one_seed_are_equal_and_of_none_go_on(env_id: str) -> None:
    env = gym.make(env_id)
    first, again = env.reset(seed=3), env.reset(seed=3)
    assert data_equivalence(first, again, exact=True)
    unseeded = gym.make(env_id)
    unseeded.reset(seed=3)
    walks = [walked(unseeded), walked(unseeded)]
    assert not data_equivalence(*walks)  # the numbers of the next episode are new ones


def walked(env: gym.Env[Any, Any]) -> list[Any]:
    """One episode of the open loop, begun by a reset without a seed."""
    given: list[Any] = [env.reset()]
    for _ in range(STRIDES):
        given.append(env.step(np.zeros(2, np.float32)))
        if given[-1][2] or given[-1][3]:
            break
    return given


@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("mode", MODES[1:])
def test_every_mode_of_the_metadata_draws(env_id: str, mode: str) -> None:
    env = gym.make(env_id, render_mode=mode)
    assert mode in env.metadata["render_modes"]
    env.reset(seed=0)
    env.step(np.zeros(2, np.float32))
    pictures = env.render()
    pictures = pictures if isinstance(pictures, list) else [pictures]
    assert len(pictures) >= 1
    for picture in pictures:
        assert picture.dtype == np.uint8 and picture.ndim == 3 and picture.shape[2] == 3
    env.close()


@pytest.mark.parametrize("env_id", IDS)
def test_a_specification_survives_json_and_an_environment_pickling(env_id: str) -> None:
    env = gym.make(env_id)
    assert env.spec is not None
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    pickled = pickle.loads(pickle.dumps(gym.make(env_id)))
    expected = env.reset(seed=1), env.step(np.zeros(2, np.float32))
    for other in (again, pickled):
        given = other.reset(seed=1), other.step(np.zeros(2, np.float32))
        assert data_equivalence(given, expected, exact=True)
