"""torchrl: its checks of an environment's specifications, rollouts, and batches in one call."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import powered_walker_env  # noqa: F401  (registers the ids)
from tests.helpers.episodes import IDS

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]
envs = pytest.importorskip("torchrl.envs")
torch = pytest.importorskip("torch")


def wrapped(env: Any) -> Any:
    """As torchrl takes an environment of Gymnasium, with what its infos hold."""
    walker = envs.GymWrapper(env)
    return walker.auto_register_info_dict()


@pytest.mark.parametrize("env_id", IDS)
def test_its_checks_pass(env_id: str) -> None:
    envs.check_env_specs(envs.GymEnv(env_id))


@pytest.mark.parametrize("env_id", IDS)
def test_infos_are_registered_by_themselves(env_id: str) -> None:
    rolled = wrapped(gym.make(env_id)).rollout(5, break_when_any_done=False)
    assert torch.isfinite(rolled["next", "state"]).any()


def test_a_rollout_is_the_walk_of_the_environment() -> None:
    env, walker = gym.make(IDS[0]), envs.GymEnv(IDS[0])
    walker.set_seed(5)
    rolled = walker.rollout(20, policy=lambda _: torch.zeros(2))
    env.reset(seed=5)  # as its set_seed does; the rollout resets once more
    observation, _ = env.reset()
    for row in rolled:
        np.testing.assert_array_equal(row["observation"].numpy(), observation)
        observation, reward, *_ = env.step(np.zeros(2, np.float32))
        assert row["next", "reward"].item() == np.float32(reward)


@pytest.mark.parametrize("mode", ["Disabled", "SameStep"])  # it refuses NextStep
def test_a_native_batch_walks(mode: str) -> None:
    batch = gym.make_vec(IDS[0], 16, vectorization_mode="vector_entry_point", autoreset_mode=mode)
    rolled = envs.GymWrapper(batch).rollout(30, break_when_any_done=False)
    assert rolled.batch_size == torch.Size([16, 30])
    assert rolled["next", "terminated"].any()
