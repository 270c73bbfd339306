"""skrl: its wrapper over one environment and over the native batch, and an agent that learns."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import pytest

import powered_walker_env  # noqa: F401  (registers the ids)
from tests.helpers.episodes import IDS

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("default")]
pytest.importorskip("skrl")
torch = pytest.importorskip("torch")


def wrapped(env_id: str, count: int | None) -> Any:
    """As skrl takes them: one, or a native batch."""
    from skrl.envs.wrappers.torch import wrap_env

    if count is None:
        return wrap_env(gym.make(env_id), wrapper="gymnasium")
    batch = gym.make_vec(env_id, count, vectorization_mode="vector_entry_point")
    return wrap_env(batch, wrapper="gymnasium")


@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("count", [None, 16])
def test_random_actions_walk_and_fall(env_id: str, count: int | None) -> None:
    env, fell = wrapped(env_id, count), 0
    rows = 1 if count is None else count
    observation, _ = env.reset()
    for _ in range(50):
        assert observation.shape == (rows, 4) and torch.isfinite(observation).all()
        actions = 2 * torch.rand(rows, 2) - 1
        observation, reward, terminated, truncated, _ = env.step(actions)
        assert reward.shape == terminated.shape == truncated.shape == (rows, 1)
        fell += int(terminated.sum())
        if count is None and (terminated | truncated).any():
            observation, _ = env.reset()
    assert fell > 0
    env.close()


def test_its_ppo_trains_on_the_native_batch() -> None:
    from skrl.agents.torch.ppo import PPO
    from skrl.memories.torch import RandomMemory
    from skrl.models.torch import DeterministicMixin, GaussianMixin, Model
    from skrl.trainers.torch import SequentialTrainer

    env = wrapped(IDS[1], 16)
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space}

    class Actor(GaussianMixin, Model):  # type: ignore[misc]
        def __init__(self) -> None:
            Model.__init__(self, **spaces, device=env.device)
            GaussianMixin.__init__(self)
            self.mean = torch.nn.Linear(4, 2)
            self.log_std = torch.nn.Parameter(torch.full((2,), -1.5))

        def compute(self, inputs: Any, role: str = "") -> Any:
            return self.mean(states_of(inputs)), {"log_std": self.log_std}

    class Critic(DeterministicMixin, Model):  # type: ignore[misc]
        def __init__(self) -> None:
            Model.__init__(self, **spaces, device=env.device)
            DeterministicMixin.__init__(self)
            self.value = torch.nn.Linear(4, 1)

        def compute(self, inputs: Any, role: str = "") -> Any:
            return self.value(states_of(inputs)), {}

    models = {"policy": Actor(), "value": Critic()}
    agent = PPO(
        models=models, memory=RandomMemory(memory_size=16, num_envs=16, device=env.device),
        cfg={"rollouts": 16, "experiment": {"write_interval": 0, "checkpoint_interval": 0}},
        **spaces, device=env.device,
    )  # fmt: skip
    before = models["policy"].mean.weight.detach().clone()
    cfg = {"timesteps": 64, "headless": True, "disable_progressbar": True}
    SequentialTrainer(cfg=cfg, env=env, agents=agent).train()
    assert not torch.equal(before, models["policy"].mean.weight)


def states_of(inputs: dict[str, Any]) -> Any:
    """What the policy sees: skrl 2 says observations, skrl 1 states."""
    return inputs["observations"] if inputs.get("observations") is not None else inputs["states"]
