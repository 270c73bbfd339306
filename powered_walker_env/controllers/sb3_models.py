"""Saved policies in models of Stable-Baselines3, to go on with there (import on demand: torch).

The inverse of `stable_baselines.double_precision`: the actor is the network's, in single
precision. What a file of a policy does not hold, critics, exploration and optimisers, is new.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from powered_walker_env.controllers.network import CLIP, TANH, Network

#: By the names of rl-baselines3-zoo: the class, and how its actor brings actions into range.
KINDS = {
    "ppo": ("stable_baselines3.PPO", CLIP),
    "a2c": ("stable_baselines3.A2C", CLIP),
    "sac": ("stable_baselines3.SAC", TANH),
    "tqc": ("sb3_contrib.TQC", TANH),
    "crossq": ("sb3_contrib.CrossQ", TANH),
}


def sb3_model(network: Network, env: Any, algo: str | None = None, **kwargs: Any) -> BaseAlgorithm:
    """A model whose deterministic actions are the network's.

    Args:
        network: as `load_network` gives it.
        env: that it will go on in: an environment of this package, or a `PoweredWalkerVecEnv`.
        algo: one of `KINDS`; left out, as the network's settings say.
        **kwargs: of the algorithm's constructor, `seed` say; of `policy_kwargs` those of the
            actor's layers are the network's.

    Raises:
        ValueError: an unknown algorithm, one that brings actions into range otherwise than
            the network does, or an environment of another task.
    """
    name = str(network.settings.get("algo", "")).lower() if algo is None else algo
    if name not in KINDS:
        raise ValueError(f"algo must be one of {', '.join(KINDS)}, got {name!r}")
    where, squash = KINDS[name]
    if squash != network.squash:
        raise ValueError(
            f"algo must squash its actions by {network.squash!r} as the network does, got "
            f"{name!r}, which does by {squash!r}"
        )
    shapes = env.observation_space.shape, env.action_space.shape
    if shapes != ((4,), (network.actions,)):
        raise ValueError(
            f"env must have observations and actions of shape (4,) and ({network.actions},), as "
            f"the network, got {shapes[0]} and {shapes[1]}"
        )
    module, _, kind = where.rpartition(".")
    widths = [len(biases) for _, biases in network.layers[:-1]]
    policy_kwargs = dict(kwargs.pop("policy_kwargs", {})) | {
        "net_arch": {"pi": widths, "vf" if squash == CLIP else "qf": widths},
        "activation_fn": getattr(torch.nn, network.activation),
    }
    made: BaseAlgorithm = getattr(importlib.import_module(module), kind)(
        "MlpPolicy", env, policy_kwargs=policy_kwargs, **{"device": "cpu", **kwargs}
    )
    _put(made.policy, network)
    return made


def _put(policy: Any, network: Network) -> None:
    """The network's numbers into an actor, in single precision."""
    actor = getattr(policy, "actor", None)
    parts = (
        [*policy.mlp_extractor.policy_net, policy.action_net]
        if actor is None
        else [*actor.latent_pi, actor.mu]
    )
    linear = [part for part in parts if isinstance(part, torch.nn.Linear)]
    with torch.no_grad():
        for part in parts:
            if hasattr(part, "ra_mean"):  # CrossQ's: its numbers are in the weights already
                part.ra_mean.zero_()
                part.ra_var.fill_(1.0 - part.eps)
        for layer, (weights, biases) in zip(linear, network.layers, strict=True):
            layer.weight.copy_(torch.from_numpy(weights.astype(np.float32)))
            layer.bias.copy_(torch.from_numpy(biases.astype(np.float32)))
    policy.set_training_mode(False)
