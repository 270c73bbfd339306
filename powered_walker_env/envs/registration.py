"""The environments' ids. Any change that affects learning is a new version."""

from __future__ import annotations

import gymnasium as gym

MAX_EPISODE_STEPS = 100  # strides
#: Environment id to (preset, mean return of 100 episodes that counts as solved): a little
#: less than PPO reaches with `configs/ppo.yml` (94, 33 and 8; the open loop 7.7, 8 and 5).
ENVIRONMENTS: dict[str, tuple[str, float]] = {
    "PoweredWalker-v0": ("camp1997", 30.0),
    "PoweredWalkerRoundFoot-v0": ("round-foot", 90.0),
    "PoweredWalkerAsPublished-v0": ("camp1997-as-published", 7.0),
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
