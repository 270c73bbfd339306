"""Stable-Baselines3 models in double precision, with exact derivatives (needs torch).

SB3's networks answer in single precision: their rounding, 1e-7, limits what a closed
loop's gaits and multipliers can be known to. Here a copy of the actor calculates in
double precision and is differentiated by torch.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.sac.policies import SACPolicy
from stable_baselines3.td3.policies import TD3Policy

from powered_walker_env.simulation.strides import Array


class DoublePrecision:
    """The deterministic actor of a model, in double precision.

    Args:
        model: PPO, A2C, TRPO (any `ActorCriticPolicy` without squashed actions), SAC,
            TQC, TD3 or DDPG, on a `Box` of observations.

    Raises:
        TypeError: another kind of policy.
    """

    def __init__(self, model: BaseAlgorithm) -> None:
        policy = copy.deepcopy(model.policy).to("cpu").double().eval()
        self._network = _network(policy)

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Array, None]:
        """The actions, clipped to their range as the model clips them."""
        with torch.no_grad():
            actions = self._network(torch.as_tensor(np.asarray(observation, np.float64)))
        return np.clip(actions.numpy(), -1.0, 1.0), None

    def derivative(self, observations: Array) -> Array:
        """(N, 2, 4) derivatives of the actions before clipping."""
        given = torch.as_tensor(observations).requires_grad_(True)
        actions = self._network(given)
        rows = [
            torch.autograd.grad(actions[:, k].sum(), given, retain_graph=True)[0].numpy()
            for k in range(actions.shape[1])
        ]
        return np.stack(rows, axis=1)


class _Network:
    """Observations to actions before clipping, by the policy's own layers.

    The policies' public way casts observations to single precision; this does not.
    """

    def __init__(self, features: Any, layers: list[Any], squashed: bool) -> None:
        self.features, self.layers, self.squashed = features, layers, squashed

    def __call__(self, observations: torch.Tensor) -> torch.Tensor:
        values = self.features(observations)
        for layer in self.layers:
            values = layer(values)
        return torch.tanh(values) if self.squashed else values


def _network(policy: Any) -> _Network:
    if isinstance(policy, ActorCriticPolicy) and not policy.squash_output:
        features = getattr(policy, "pi_features_extractor", policy.features_extractor)
        layers = [policy.mlp_extractor.policy_net, policy.action_net]
        return _Network(features, layers, squashed=False)
    actor = getattr(policy, "actor", None)
    if isinstance(policy, TD3Policy) and actor is not None:
        return _Network(actor.features_extractor, [actor.mu], squashed=False)  # squashes itself
    if (isinstance(policy, SACPolicy) or type(policy).__name__ == "TQCPolicy") and actor:
        return _Network(actor.features_extractor, [actor.latent_pi, actor.mu], squashed=True)
    raise TypeError(
        "model must have an actor of PPO's, SAC's or TD3's kind without squashed Gaussians, got "
        f"{type(policy).__name__}; pass it to policy_of as it is, in single precision"
    )


def double_precision(model: BaseAlgorithm) -> DoublePrecision:
    """The controller for `policy_of` that a Stable-Baselines3 model is, in double precision."""
    return DoublePrecision(model)
