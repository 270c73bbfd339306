"""The adapter to Stable-Baselines3: the same as its own `DummyVecEnv` over single walkers."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecMonitor, VecNormalize

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.sb3 import PoweredWalkerVecEnv

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
COUNT = 5


def dummy(env_id: str = ROUND_FOOT, count: int = COUNT, **kwargs: Any) -> DummyVecEnv:
    """What SB3's `make_vec_env` makes."""
    return DummyVecEnv([lambda: Monitor(gym.make(env_id, **kwargs)) for _ in range(count)])


def assert_equal_infos(first: dict[str, Any], second: dict[str, Any]) -> None:
    """The same values; time passes, and the adapter's numbers are Python's own."""
    assert set(first) == set(second)
    for name, value in first.items():
        if name == "episode":
            assert_equal_infos({**value, "t": 0.0}, {**second[name], "t": 0.0})
            continue
        assert np.asarray(value).dtype == np.asarray(second[name]).dtype, name
        np.testing.assert_array_equal(value, second[name], err_msg=name)


def assert_equal_rollouts(
    first: VecEnv, second: VecEnv, actions: np.ndarray, *, seed: int = 3
) -> int:
    """Walk both with the same actions; return how many episodes ended."""
    first.seed(seed)
    second.seed(seed)
    np.testing.assert_array_equal(first.reset(), second.reset())
    ended = 0
    for action in actions:
        (o1, r1, d1, i1), (o2, r2, d2, i2) = first.step(action), second.step(action)
        np.testing.assert_array_equal(o1, o2)
        np.testing.assert_array_equal(np.float32(r1), r2)  # DummyVecEnv rounds rewards
        np.testing.assert_array_equal(d1, d2)
        for a, b in zip([*i1, *first.reset_infos], [*i2, *second.reset_infos], strict=True):
            assert_equal_infos(a, b)
        ended += int(d1.sum())
    return ended


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_equals_dummy_vec_env_through_falls(env_id: str) -> None:
    actions = np.random.default_rng(0).normal(0, 0.4, (40, COUNT, 2)).astype(np.float32)
    ended = assert_equal_rollouts(PoweredWalkerVecEnv(env_id, COUNT), dummy(env_id), actions)
    assert ended > COUNT


def test_equals_dummy_vec_env_through_truncation_and_every_disturbance() -> None:
    sizes = dict(push=0.01, ground=0.002, slope=0.001, torque=0.01, sensor=0.1, parameters=0.002)
    kwargs: dict[str, Any] = {"disturbance": sizes, "max_episode_steps": 7, "reward": "contraction"}
    actions = np.zeros((30, COUNT, 2), np.float32)
    ended = assert_equal_rollouts(
        PoweredWalkerVecEnv(ROUND_FOOT, COUNT, **kwargs), dummy(**kwargs), actions
    )
    assert ended > COUNT


def test_truncation_is_marked_and_a_fall_is_not() -> None:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 2, seed=0, max_episode_steps=3, disturbance="none")
    env.reset()
    falling = np.array([[0.0, 0.0], [1.0, 1.0]])
    marked: list[list[Any]] = [[], []]
    for _ in range(3):
        _, _, done, infos = env.step(falling)
        for i in np.flatnonzero(done):
            marked[i].append((infos[i]["TimeLimit.truncated"], infos[i]["outcome"] == 0))
            assert infos[i]["terminal_observation"].shape == (4,)
    assert marked[0] == [(True, True)]
    assert (False, False) in marked[1]


def test_registered_limit_holds() -> None:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 1, disturbance="none")
    env.reset()
    dones = [bool(env.step(np.zeros((1, 2)))[2][0]) for _ in range(101)]
    assert [i for i, done in enumerate(dones) if done] == [99]


def test_seed_of_the_constructor_counts_once() -> None:
    first, second = PoweredWalkerVecEnv(ROUND_FOOT, 3, seed=5), PoweredWalkerVecEnv(ROUND_FOOT, 3)
    second.seed(5)
    start = first.reset()
    np.testing.assert_array_equal(start, second.reset())
    assert (first.reset() != start).any()
    assert len({tuple(row) for row in start.tolist()}) == 3  # every walker has its own numbers


def test_options_reach_the_walkers_they_are_for() -> None:
    states = [[-0.36, 0.44, 1.18, 0.28], [-0.35, 0.43, 1.2, 0.3]]
    for options in ([{"state": states[0]}, {}, {"state": states[1]}], {"state": states[0]}):
        ours, theirs = PoweredWalkerVecEnv(ROUND_FOOT, 3), dummy(count=3)
        for env in (ours, theirs):
            env.seed(1)
            env.set_options(options)
        np.testing.assert_array_equal(ours.reset(), theirs.reset())
        for a, b in zip(ours.reset_infos, theirs.reset_infos, strict=True):
            assert_equal_infos(a, b)
        for env in (ours, theirs):  # they count once
            env.seed(1)
        np.testing.assert_array_equal(ours.reset(), theirs.reset())


def test_a_saved_state_goes_on_bit_for_bit() -> None:
    first = PoweredWalkerVecEnv(ROUND_FOOT, COUNT, seed=0)
    first.reset()
    actions = np.random.default_rng(0).normal(0, 0.3, (25, COUNT, 2))
    for action in actions[:5]:
        first.step(action)
    second = PoweredWalkerVecEnv(ROUND_FOOT, COUNT, seed=99)
    second.set_state(first.get_state())
    for action in actions[5:]:
        (o1, r1, d1, _), (o2, r2, d2, _) = first.step(action), second.step(action)
        np.testing.assert_array_equal(o1, o2)
        np.testing.assert_array_equal(r1, r2)
        np.testing.assert_array_equal(d1, d2)
    with pytest.raises(ValueError, match="5 walkers, got 2"):
        first.set_state(PoweredWalkerVecEnv(ROUND_FOOT, 2).get_state())


def test_stable_baselines3_accepts_the_single_environments() -> None:
    for env_id in ENVIRONMENTS:
        check_env(gym.make(env_id).unwrapped)


def walk_episodes(env: VecEnv, strides: int) -> tuple[list[Any], np.ndarray]:
    """The episodes in the infos of an open-loop walk, and what was earned."""
    env.reset()
    episodes, total = [], np.zeros(env.num_envs)
    for _ in range(strides):
        _, rewards, _, infos = env.step(np.zeros((env.num_envs, 2)))
        total += rewards
        episodes += [info["episode"] for info in infos if "episode" in info]
    return episodes, total


@pytest.mark.parametrize("wrapped", [False, True])
def test_episodes_are_monitored_inside_or_by_a_wrapper(wrapped: bool) -> None:
    env: VecEnv = PoweredWalkerVecEnv(
        ROUND_FOOT, 2, seed=0, max_episode_steps=4, monitor=not wrapped
    )
    episodes, total = walk_episodes(VecMonitor(env) if wrapped else env, 4)
    assert [episode["l"] for episode in episodes] == [4, 4]
    np.testing.assert_allclose([episode["r"] for episode in episodes], total, rtol=1e-6)
    plain = PoweredWalkerVecEnv(ROUND_FOOT, 2, seed=0, max_episode_steps=4, monitor=False)
    assert walk_episodes(plain, 4)[0] == []


def test_the_mean_reward_of_episodes_is_logged() -> None:
    model = PPO("MlpPolicy", PoweredWalkerVecEnv(ROUND_FOOT, 4, seed=0), n_steps=32, batch_size=64)
    model.learn(256)
    returns = [episode["r"] for episode in model.ep_info_buffer]
    assert len(returns) > 4 and max(returns) > 1.0


def test_an_evaluation_over_normalised_rewards_reports_raw_returns() -> None:
    def mean(env: VecEnv) -> float:
        env.seed(7)
        policy = PPO("MlpPolicy", env, n_steps=8, batch_size=8, seed=0)
        return float(evaluate_policy(policy, env, 6, warn=True)[0])

    normalised = VecNormalize(
        PoweredWalkerVecEnv(ROUND_FOOT, 3), norm_obs=False, norm_reward=True, training=False
    )
    normalised.ret_rms.var = np.array(400.0)  # so that a reward is a twentieth
    assert mean(normalised) == pytest.approx(mean(dummy(count=3)), rel=1e-6)


def test_a_saved_state_has_the_returns_of_the_episodes_under_way() -> None:
    first = PoweredWalkerVecEnv(ROUND_FOOT, 2, seed=0, max_episode_steps=4, disturbance="none")
    first.reset()
    for _ in range(3):
        first.step(np.zeros((2, 2)))
    second = PoweredWalkerVecEnv(ROUND_FOOT, 2, max_episode_steps=4, disturbance="none")
    second.set_state(first.get_state())
    infos = second.step(np.zeros((2, 2)))[3]
    assert [info["episode"]["r"] for info in infos] == pytest.approx([4.0, 4.0], abs=1e-4)
    with pytest.raises(ValueError, match="without walkers, elapsed, returns"):
        second.set_state({})


@pytest.mark.parametrize(
    "change", [{"returns": [1.0]}, {"elapsed": "many"}, {"walkers": [{}, {}]}], ids=str
)
def test_a_saved_state_that_is_none_is_refused_and_changes_nothing(change: dict[str, Any]) -> None:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 2, seed=0)
    env.reset()
    saved = env.get_state()
    saved["walkers"][0]["level"] = 0.5
    with pytest.raises(ValueError, match=r"saved (returns|elapsed|must)"):
        env.set_state(saved | change)
    assert env.get_state()["walkers"][0]["level"] == 0.0


def test_the_rest_of_the_interface() -> None:
    env = PoweredWalkerVecEnv(ROUND_FOOT, 3)
    assert env.get_attr("num_envs", indices=[0, 2]) == [3, 3]
    assert env.has_attr("task") and not env.has_attr("nothing")
    assert env.env_is_wrapped(gym.wrappers.TimeLimit, indices=0) == [False]
    assert env.env_is_wrapped(Monitor) == [True] * 3
    assert env.render_mode is None
    with pytest.raises(AttributeError, match="share one task"):
        env.set_attr("task", None)
    np.testing.assert_array_equal(env.env_method("reset", seed=1, indices=0)[0][0].shape, (3, 4))
    env.close()


def test_environments_of_others_are_refused() -> None:
    with pytest.raises(ValueError, match=r"this package .* got 'CartPole-v1'"):
        PoweredWalkerVecEnv("CartPole-v1", 2)
    with pytest.raises(ValueError, match=r"got 'PoweredWalker-v0': .* keyword argument 'speed'"):
        PoweredWalkerVecEnv("PoweredWalker-v0", 2, speed=3)
    with pytest.raises(ValueError, match="autoreset_mode is 'SameStep' here"):
        PoweredWalkerVecEnv("PoweredWalker-v0", 2, autoreset_mode="Disabled")
