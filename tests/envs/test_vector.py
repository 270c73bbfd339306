"""The native vector environment against Gymnasium's own over single environments."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from powered_walker_env import PoweredWalkerVectorEnv
from powered_walker_env.envs.rewards import REWARDS
from powered_walker_env.simulation import threads
from tests.helpers.episodes import EVERYTHING, FORWARD_FALL, IDS, ROUND_FOOT, assert_same, make

MODES = tuple(AutoresetMode)
COUNT, STEPS = 6, 300
LIMIT = 4  # strides: falls and truncations both happen, also to the same walker at once


def pair(
    mode: AutoresetMode, count: int = COUNT, env_id: str = ROUND_FOOT, **arguments: Any
) -> tuple[PoweredWalkerVectorEnv, SyncVectorEnv]:
    """The native environment and Gymnasium's, of the same walkers."""
    arguments = {"max_episode_steps": LIMIT, **arguments}
    native = gym.make_vec(
        env_id, count, vectorization_mode="vector_entry_point", autoreset_mode=mode, **arguments
    )
    sync = gym.make_vec(
        env_id,
        count,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        **arguments,
    )
    assert isinstance(native, PoweredWalkerVectorEnv) and isinstance(sync, SyncVectorEnv)
    return native, sync


def walk_both(native: Any, sync: Any, steps: int, seed: int = 0) -> dict[str, int]:
    """Walk with random actions; everything given must be the same. Counts what happened."""
    rng = np.random.default_rng(seed)
    assert_same(native.reset(seed=seed), sync.reset(seed=seed), "reset")
    seen = {"fell": 0, "cut": 0, "both": 0, "all over": 0}
    for step in range(steps):
        actions = rng.uniform(-0.15, 0.15, (native.num_envs, 2)).astype(np.float32)
        given = native.step(actions)
        assert_same(given, sync.step(actions), f"step {step}")
        _, _, fell, cut, _ = given
        over = fell | cut
        seen["fell"] += int(fell.sum())
        seen["cut"] += int(cut.sum())
        seen["both"] += int((fell & cut).sum())
        seen["all over"] += int(over.all())
        if native.autoreset_mode == AutoresetMode.DISABLED and over.any():
            again = [env.reset(options={"reset_mask": over.copy()}) for env in (native, sync)]
            assert_same(*again, f"reset after step {step}")
    return seen


@pytest.mark.parametrize("disturbance", ["light", EVERYTHING], ids=["pushes", "all"])
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.value)
def test_it_gives_what_gymnasiums_own_gives(mode: AutoresetMode, disturbance: Any) -> None:
    native, sync = pair(mode, disturbance=disturbance)
    seen = walk_both(native, sync, STEPS)
    for kind in ("fell", "cut", "both"):
        assert seen[kind] > 20, seen


@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("env_id", IDS)
def test_it_gives_the_same_for_every_walker_and_reward(env_id: str, reward: str) -> None:
    native, sync = pair(AutoresetMode.SAME_STEP, 3, env_id=env_id, reward=reward, effort_weight=0.1)
    walk_both(native, sync, 60)


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.value)
def test_walkers_that_all_end_together_are_no_exception(mode: AutoresetMode, count: int) -> None:
    assert walk_both(*pair(mode, count, max_episode_steps=1), 20)["all over"] >= 10


def test_a_large_batch_is_the_same_too() -> None:
    """So large that threads share it."""
    walk_both(*pair(AutoresetMode.NEXT_STEP, 96, disturbance=EVERYTHING), 10)


@pytest.mark.parametrize("count", [1, 5, 31, 64, 150])
def test_walker_i_is_a_single_environment_with_seed_plus_i(count: int) -> None:
    envs = gym.make_vec(ROUND_FOOT, count, disturbance=EVERYTHING)
    observations, _ = envs.reset(seed=40)
    results = envs.step(np.full((count, 2), 0.05, np.float32))
    for i in {0, count // 2, count - 1}:
        env = make(disturbance=EVERYTHING)
        np.testing.assert_array_equal(env.reset(seed=40 + i)[0], observations[i])
        observation, reward, terminated, _, info = env.step(np.full(2, 0.05, np.float32))
        np.testing.assert_array_equal(observation, results[0][i])
        assert (reward, terminated) == (results[1][i], results[2][i])
        np.testing.assert_array_equal(info["state"], results[4]["state"][i])


def walk(count: int, steps: int, **arguments: Any) -> list[Any]:
    envs = gym.make_vec(ROUND_FOOT, count, **arguments)
    rng = np.random.default_rng(3)
    given: list[Any] = [envs.reset(seed=0)]
    return given + [envs.step(rng.uniform(-0.1, 0.1, (count, 2))) for _ in range(steps)]


def test_the_result_does_not_depend_on_the_number_of_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    results = []
    for cores in (1, 2, 3, 8):
        monkeypatch.setattr(threads, "cores", lambda cores=cores: cores)
        monkeypatch.setattr(threads, "_pool", None)
        results.append(walk(130, 4, disturbance=EVERYTHING))
    for other in results[1:]:
        assert_same(results[0], other)


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.value)
def test_a_partial_reset_leaves_the_others_where_they_are(mode: AutoresetMode) -> None:
    native, sync = pair(mode, disturbance=EVERYTHING)
    walk_both(native, sync, 2)
    mask = np.array([True, False, False, True, False, True])
    for options in ({}, {"state": FORWARD_FALL}):
        for seed in (None, [9, None, None, 8, None, None]):
            given = [
                env.reset(seed=seed, options={**options, "reset_mask": mask.copy()})
                for env in (native, sync)
            ]
            assert_same(*given)
    over = native._over
    if mode == AutoresetMode.DISABLED and over.any():
        assert_same(*[env.reset(options={"reset_mask": over.copy()}) for env in (native, sync)])
    actions = np.zeros((COUNT, 2), np.float32)
    assert_same(native.step(actions), sync.step(actions))


def test_one_seed_for_each_and_no_seed() -> None:
    native, sync = pair(AutoresetMode.NEXT_STEP)
    seeds = [5, 3, 11, 0, 2, 7]
    assert_same(native.reset(seed=seeds), sync.reset(seed=seeds))
    assert_same(native.reset(), sync.reset())
    fresh = [gym.make_vec(ROUND_FOOT, 2).reset()[0] for _ in range(2)]
    assert len(np.unique(np.concatenate(fresh), axis=0)) == 4
