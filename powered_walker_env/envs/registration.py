"""The environments' ids. Any change that affects learning is a new version."""

from __future__ import annotations

import gymnasium as gym

MAX_EPISODE_STEPS = 100  # strides
#: Environment id to (preset, mean return of 100 episodes that counts as solved): what every
#: seed of PPO with `configs/ppo.yml` reached (91.6 to 93.2, 28.7 to 31.5, 8.4 to 10.6).
ENVIRONMENTS: dict[str, tuple[str, float]] = {
    "PoweredWalker-v0": ("camp1997", 28.0),
    "PoweredWalkerRoundFoot-v0": ("round-foot", 90.0),
    "PoweredWalkerAsPublished-v0": ("camp1997-as-published", 8.0),
}


def register_environments() -> None:
    """Register the environments with Gymnasium; again does nothing."""
    for name, (preset, threshold) in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(
                id=name,
                entry_point="powered_walker_env.envs.walker:PoweredWalkerEnv",
                vector_entry_point="powered_walker_env.envs.vector:PoweredWalkerVectorEnv",
                max_episode_steps=MAX_EPISODE_STEPS,
                reward_threshold=threshold,
                kwargs={"preset": preset},
            )
