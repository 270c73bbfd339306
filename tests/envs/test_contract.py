"""Random numbers, infos and controls as Gymnasium and its clients have them, single and native."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import Outcome, PoweredWalkerEnv, PoweredWalkerVectorEnv
from tests.helpers.episodes import EVERYTHING, FORWARD_FALL, IDS, ROUND_FOOT, assert_same, make
from tests.helpers.samples import DECIDING, scheme_arguments

COUNT = 3
NOISY = {"push": 0.002, "sensor": 0.1}  # nobody falls in a stride
MAKERS = [PoweredWalkerEnv, lambda **given: PoweredWalkerVectorEnv(COUNT, **given)]
both = pytest.mark.parametrize("maker", MAKERS, ids=["single", "native"])


def zeros(env: Any) -> np.ndarray:
    return np.zeros(env.action_space.shape, np.float32)


@both
def test_a_seeded_reset_seeds_np_random(maker: Any) -> None:
    env = maker()
    env.reset(seed=17)
    assert env.np_random_seed == 17
    expected = gym.utils.seeding.np_random(17)[0]
    if isinstance(env, PoweredWalkerEnv):
        expected.integers(2**64, dtype=np.uint64)  # what the walker's numbers begin with
    assert env.np_random.random() == expected.random()


@both
def test_the_seed_of_an_unseeded_reset_makes_it_again(maker: Any) -> None:
    env, again = maker(disturbance=EVERYTHING), maker(disturbance=EVERYTHING)
    given = env.reset()
    assert_same(again.reset(seed=env.np_random_seed), given)
    assert_same(again.step(zeros(env)), env.step(zeros(env)))


@both
def test_a_generator_that_is_set_is_where_the_random_numbers_come_from(maker: Any) -> None:
    env, other, seeded = (maker(disturbance=NOISY) for _ in range(3))
    for each in (env, other, seeded):
        each.reset(seed=1)
    env.np_random = np.random.default_rng(8)
    other.np_random = np.random.default_rng(8)
    assert env.np_random_seed == -1
    given = [env.step(zeros(env)), env.reset(), env.step(zeros(env))]
    assert_same(given, [other.step(zeros(env)), other.reset(), other.step(zeros(env))])
    assert (given[0][0] != seeded.step(zeros(env))[0]).any()  # at once, not at the next reset
    fresh = maker(disturbance=NOISY)
    fresh.np_random = np.random.default_rng(8)  # before the first reset
    again = maker(disturbance=NOISY)
    again.reset(seed=5)
    again.np_random = np.random.default_rng(8)
    assert_same(fresh.reset()[0], again.reset()[0])
    assert_same(env.reset(seed=1), seeded.reset(seed=1))  # a seed counts again


def test_walkers_of_a_batch_draw_their_own_numbers_from_a_generator_that_is_set() -> None:
    envs, env = PoweredWalkerVectorEnv(COUNT), PoweredWalkerEnv()
    for each in (envs, env):
        each.np_random = np.random.default_rng(3)
    starts = envs.reset()[0]
    np.testing.assert_array_equal(starts[0], env.reset()[0])
    assert len({tuple(row) for row in starts.tolist()}) == COUNT


@pytest.mark.parametrize("name", DECIDING)
def test_a_batch_says_the_controls_that_actions_mean(name: str) -> None:
    arguments = scheme_arguments(name)
    envs, env = PoweredWalkerVectorEnv(COUNT, **arguments), PoweredWalkerEnv(**arguments)
    actions = np.random.default_rng(0).uniform(-1.5, 1.5, envs.action_space.shape)
    assert envs.control(actions) == tuple(env.control(action) for action in actions)
    with pytest.raises(ValueError, match="action must have shape"):
        envs.control(actions[0])


@pytest.mark.parametrize("env_id", IDS)
def test_infos_are_numpys_numbers_so_that_others_can_make_tensors_of_them(env_id: str) -> None:
    """torchrl's `auto_register_info_dict` asks every value for its dtype and shape."""
    env = make(env_id, disturbance=EVERYTHING)
    for info in (env.reset(seed=0)[1], env.step(zeros(env))[4], env.step(zeros(env))[4]):
        for name, value in info.items():
            assert value.dtype.kind in "fi" and value.shape in ((), (2,), (4,)), name


def test_the_outcome_can_be_read() -> None:
    env = make()
    env.reset(options={"state": FORWARD_FALL})
    assert env.outcome is Outcome.WALKED
    info = env.step(zeros(env))[4]
    assert env.outcome is Outcome(info["outcome"]) is Outcome.FELL_FORWARD
    assert env.outcome.label == "fell forward"


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_every_key_of_an_info_has_a_mask_of_its_own(mode: str) -> None:
    envs = gym.make_vec(ROUND_FOOT, COUNT, autoreset_mode=mode, max_episode_steps=1)
    mask = np.array([True, False, True])
    infos = [envs.reset(seed=0)[1], envs.step(np.zeros((COUNT, 2)))[4]]
    infos += [envs.reset(options={"reset_mask": mask})[1]]
    infos += [infos[1]["final_info"]] if mode == "SameStep" else []
    for info in infos:
        masks = {name: value for name, value in info.items() if name.startswith("_")}
        assert len(masks) >= 13
        for name, own in masks.items():
            before = {other: value.copy() for other, value in masks.items() if other != name}
            own[:] = ~own
            for other, value in before.items():
                np.testing.assert_array_equal(masks[other], value)
