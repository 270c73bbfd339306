"""The environment as Gymnasium and its users expect it."""

from __future__ import annotations

import copy
import json
import math
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from powered_walker_env import PRESETS, Outcome
from powered_walker_env.envs.rewards import REWARDS
from tests.helpers.episodes import (
    EVERYTHING,
    FORWARD_FALL,
    IDS,
    ROUND_FOOT,
    assert_same,
    go_on,
    make,
    record,
)

STRIDES = 40


# Warnings are errors in this suite, those of the checkers, too.
@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("disable_env_checker", [None, True])
def test_gymnasiums_checker_finds_nothing(
    env_id: str, reward: str, disable_env_checker: bool | None
) -> None:
    env = gym.make(env_id, reward=reward, disable_env_checker=disable_env_checker)
    check_env(env.unwrapped, skip_render_check=True)


def test_gymnasiums_checker_finds_nothing_about_rendering() -> None:
    check_env(gym.make(ROUND_FOOT, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("env_id", IDS)
def test_stable_baselines3s_checker_finds_nothing(env_id: str, reward: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gym.make(env_id, reward=reward)
    checker.check_env(env)
    checker.check_env(env.unwrapped)


@pytest.mark.parametrize("env_id", IDS)
def test_the_same_seed_gives_the_same_walk(env_id: str) -> None:
    one, two = make(env_id), make(env_id)
    assert_same(record(one, STRIDES, seed=3), record(two, STRIDES, seed=3))
    assert_same(record(one, STRIDES, seed=3), record(two, STRIDES, seed=3))


def test_other_seeds_and_no_seed_give_other_walks() -> None:
    env = make()
    starts = [env.reset(seed=seed)[1]["state"].tolist() for seed in (1, 2, None, None)]
    starts += [make().reset()[1]["state"].tolist() for _ in range(2)]
    assert len({tuple(start) for start in starts}) == len(starts)


def test_without_a_seed_the_random_numbers_go_on() -> None:
    env = make()
    env.reset(seed=5)
    env.step(np.zeros(2, np.float32))
    later = env.reset()[0]
    again = make()
    again.reset(seed=5)
    assert not np.array_equal(again.reset()[0], later)  # a stride less
    again.reset(seed=5)
    again.step(np.ones(2, np.float32))
    np.testing.assert_array_equal(again.reset()[0], later)  # whatever the action was


@pytest.mark.parametrize("copies", [lambda env: pickle.loads(pickle.dumps(env)), copy.deepcopy])
def test_a_copy_made_in_the_middle_of_a_walk_goes_on_alike(copies: Any) -> None:
    env = gym.make(ROUND_FOOT, disturbance=EVERYTHING)
    env.reset(seed=1)
    env.step(np.zeros(2, np.float32))
    twin = copies(env)
    assert_same(go_on(env, STRIDES), go_on(twin, STRIDES))


@pytest.mark.parametrize("disturbance", ["none", "light", EVERYTHING])
def test_a_saved_state_replays_the_future(disturbance: Any) -> None:
    env = make(disturbance=disturbance)
    env.reset(seed=2)
    env.step(np.zeros(2, np.float32))
    saved = json.loads(json.dumps(env.get_state()))
    first = go_on(env, STRIDES)
    env.set_state(saved)
    assert_same(go_on(env, STRIDES), first)
    elsewhere = make(disturbance=disturbance)
    elsewhere.set_state(saved)
    assert_same(go_on(elsewhere, STRIDES), first)


def test_a_state_saved_after_a_fall_is_one_after_a_fall() -> None:
    env = make()
    env.reset(seed=0, options={"state": FORWARD_FALL})
    assert env.step(np.zeros(2, np.float32))[2]
    other = make()
    other.reset(seed=0)
    other.set_state(env.get_state())
    assert other.outcome is Outcome.FELL_FORWARD
    with pytest.warns(UserWarning, match="after a fall"):
        assert other.step(np.zeros(2, np.float32))[2]


@pytest.mark.parametrize("disturbance", ["light", EVERYTHING])
@pytest.mark.parametrize("env_id", IDS)
def test_info_has_the_same_keys_and_types_at_reset_and_at_every_stride(
    env_id: str, disturbance: Any
) -> None:
    given = record(make(env_id, disturbance=disturbance), STRIDES, seed=0)
    infos = [step[-1] for step in given]
    assert any(step[2] for step in given if len(step) == 5)  # a fall is among them
    kinds = [{key: type(value) for key, value in info.items()} for info in infos]
    assert all(kind == kinds[0] for kind in kinds)
    assert set(kinds[0].values()) == {np.ndarray, np.float64, np.int64}
    for info in infos:
        assert info["state"].shape == (4,) and info["control"].shape == (2,)
        assert all(np.isfinite(value).all() for value in info.values())
        assert Outcome(info["outcome"]) in Outcome


@pytest.mark.parametrize("disturbance", ["light", "rough", EVERYTHING])
@pytest.mark.parametrize("env_id", IDS)
def test_observations_and_rewards_are_of_their_spaces_and_types(
    env_id: str, disturbance: Any
) -> None:
    env = make(env_id, disturbance=disturbance)
    assert env.observation_space == gym.spaces.Box(-20, 20, (4,), np.float32)
    assert env.action_space == gym.spaces.Box(-1, 1, (2,), np.float32)
    for observation, *rest in record(env, STRIDES, seed=0):
        assert observation.dtype == np.float32
        assert observation in env.observation_space
        if len(rest) == 4:
            reward, terminated, truncated, info = rest
            assert type(reward) is float and 0 <= reward <= 1
            assert type(terminated) is bool and truncated is False
            assert terminated == (info["outcome"] != Outcome.WALKED)


@pytest.mark.parametrize("reward", REWARDS)
def test_after_a_fall_state_and_observation_are_the_last_ones(reward: str) -> None:
    env = make(reward=reward, disturbance=EVERYTHING)
    start, info = env.reset(seed=0, options={"state": FORWARD_FALL})
    observation, value, terminated, truncated, end = env.step(np.zeros(2, np.float32))
    assert terminated and not truncated
    assert Outcome(end["outcome"]) == Outcome.FELL_FORWARD
    np.testing.assert_array_equal(observation, start)
    np.testing.assert_array_equal(end["state"], info["state"])
    assert value == (-10.0 if reward == "contraction" else 0.0)
    assert end["step_length"] == 0.0 and end["duration"] > 0.0


def test_a_far_state_is_observed_at_the_bounds() -> None:
    observation, _ = make().reset(options={"state": (1.5, -1.5, 9.0, -9.0)})
    np.testing.assert_array_equal(observation, [20, -20, 20, -20])


def test_reset_starts_exactly_at_a_given_state() -> None:
    env = make(disturbance=EVERYTHING)
    state = tuple(x + 0.01 for x in PRESETS["round-foot"].state)
    observation, info = env.reset(seed=0, options={"state": state})
    np.testing.assert_array_equal(info["state"], state)
    # The sensor is noisy, the push is not felt.
    assert observation == pytest.approx([0.2, 0.2, 0.01 / 0.15, 0.01 / 0.3], abs=0.6)


@pytest.mark.parametrize("env_id", IDS)
def test_the_open_loop_undisturbed_walks_the_gait_to_the_limit(env_id: str) -> None:
    env = gym.make(env_id, disturbance="none")
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(observation, np.zeros(4))
    for stride in range(1, 101):
        observation, reward, terminated, truncated, info = env.step(np.zeros(2, np.float32))
        assert float(reward) == pytest.approx(1.0, abs=1e-9)
        assert abs(observation).max() < 1e-4
        assert not terminated
        assert truncated == (stride == 100)
    assert math.isclose(info["distance"], 0.0, abs_tol=1e-4)


def test_a_stride_costs_no_second_reset_after_a_fall() -> None:
    env = make()
    env.reset(options={"state": FORWARD_FALL})
    env.step(np.zeros(2, np.float32))
    env.reset()
    assert not env.step(np.zeros(2, np.float32))[2]
