"""The walker as reinforcement-learning environments."""

from powered_walker_env.envs.walker import PoweredWalkerEnv

__all__ = ["PoweredWalkerEnv"]
