"""Policies of Stable-Baselines3 (import it on demand: needs torch).

SB3's networks answer in single precision: their rounding, 1e-7, limits what a closed
loop's gaits and multipliers can be known to. `double_precision` takes the numbers of an
actor out of a model: a `Network`, which also can be saved without any code.
"""

from __future__ import annotations

import copy
import json
import pickle
import warnings
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, FlattenExtractor
from stable_baselines3.sac.policies import SACPolicy
from stable_baselines3.td3.policies import TD3Policy

from powered_walker_env.controllers.network import ACTIVATIONS, CLIP, TANH, Network

# Of sb3-contrib, by name: it need not be installed.
_LIKE_SAC, _NORM = ("TQCPolicy", "CrossQPolicy"), "BatchRenorm1d"


class StrideMetric(BaseFeaturesExtractor):
    """Observations times a matrix, before the networks: `features_extractor_class` of a policy.

    The walkers are as they were, and so is who acts in them; what a learner sees is stretched.

    Args:
        observation_space: of the environment.
        matrix: (4, 4), as `stride_metric` has it for a task.
    """

    def __init__(self, observation_space: Any, matrix: Sequence[Sequence[float]]) -> None:
        super().__init__(observation_space, len(matrix))
        self.matrix: torch.Tensor
        self.register_buffer("matrix", torch.tensor(matrix, dtype=torch.float32))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """The features."""
        return observations @ self.matrix.T


def double_precision(model: Any, settings: Mapping[str, Any] | None = None) -> Network:
    """The deterministic actor of a model of Stable-Baselines3, in double precision.

    Args:
        model: PPO, A2C, TRPO (any `ActorCriticPolicy` without squashed actions), SAC, TQC,
            TD3, DDPG or CrossQ, or the policy of one, on a `Box` of observations. What
            CrossQ's layers normalise by goes into the weights that follow.
        settings: what to keep with it about its training; JSON-able.

    Raises:
        TypeError: another kind of policy, or of network.
    """
    policy = model if isinstance(model, BasePolicy) else model.policy
    features, modules = _actor(policy)
    *modules, last = _without_norms(modules)
    squash = CLIP
    if isinstance(last, torch.nn.Tanh):
        squash, last = TANH, modules.pop()
    hidden, activations = modules[::2], {type(module).__name__ for module in modules[1::2]}
    plain = all(isinstance(module, torch.nn.Linear) for module in (*hidden, last))
    activation = activations.pop() if activations else "Tanh"
    if not plain or activations or activation not in ACTIVATIONS:
        raise TypeError(
            f"the network must be linear layers with one of {', '.join(ACTIVATIONS)} between "
            f"them, got {[*modules, last]}; pass the model to policy_of as it is, in single "
            "precision"
        )
    tensors = [(_numbers(part) for part in module.parameters()) for module in (*hidden, last)]
    layers = [(weights, biases) for weights, biases in tensors]
    if isinstance(features, StrideMetric):
        layers[0] = (layers[0][0] @ _numbers(features.matrix), layers[0][1])
    return Network(layers, activation, squash, dict(settings or {}))


def _without_norms(modules: list[torch.nn.Module]) -> list[torch.nn.Module]:
    """Each batch renormalisation, as it acts after training, taken into the layer behind it."""
    kept: list[torch.nn.Module] = []
    gain: torch.Tensor | None = None
    for module in modules:
        if type(module).__name__ == _NORM:
            parts: Any = module
            gain = parts.scale.double() / torch.sqrt(parts.ra_var.double() + parts.eps)
            shift = parts.bias.double() - gain * parts.ra_mean.double()
        elif gain is not None and isinstance(module, torch.nn.Linear):
            layer = copy.deepcopy(module).double()
            layer.bias.data += layer.weight.data @ shift
            layer.weight.data *= gain
            kept.append(layer)
            gain = None
        else:
            kept.append(module)
    return kept


def _numbers(tensor: torch.Tensor) -> np.ndarray:
    return tensor.detach().cpu().numpy().astype(np.float64)


def _actor(policy: Any) -> tuple[Any, list[torch.nn.Module]]:
    """What an actor makes of observations, and its modules up to the actions before clipping."""
    actor, kind = getattr(policy, "actor", None), type(policy).__name__
    if isinstance(policy, ActorCriticPolicy) and not policy.squash_output:
        features = getattr(policy, "pi_features_extractor", policy.features_extractor)
        parts: list[Any] = [getattr(policy.mlp_extractor, "policy_net", None), policy.action_net]
        memory = hasattr(policy, "lstm_actor")
    elif isinstance(policy, TD3Policy) and actor is not None:
        features, parts, memory = actor.features_extractor, [actor.mu], False  # squashes itself
    elif (isinstance(policy, SACPolicy) or kind in _LIKE_SAC) and actor is not None:
        features, memory = actor.features_extractor, False
        parts = [actor.latent_pi, actor.mu, torch.nn.Tanh()]
    else:
        features, parts, memory = None, [], False
    if memory or not isinstance(features, FlattenExtractor | StrideMetric):
        raise TypeError(
            "model must have an actor of PPO's, SAC's or TD3's kind on a Box of observations, "
            f"without memory and squashed Gaussians, got {kind}; pass it to policy_of as it is, "
            "in single precision"
        )
    return features, [module for part in parts for module in _flat(part)]


def _flat(module: torch.nn.Module) -> Iterator[torch.nn.Module]:
    inner = list(module.children())
    if not inner and not isinstance(module, torch.nn.Sequential):
        yield module
    for part in inner:
        yield from _flat(part)


def load_sb3_policy(path: Path) -> BasePolicy:
    """The policy in a saved model of any algorithm of Stable-Baselines3.

    The file is a pickle: loading runs what code it may hold, and a warning says so.

    Raises:
        FileNotFoundError: no such file.
        ValueError: a file that is damaged, or not a model.
    """
    if not path.is_file():
        raise FileNotFoundError(
            f"there is no model file {str(path)!r}; train one with agents.train"
        )
    warn_of_pickle(path)
    try:
        data, parameters, _ = load_from_zip_file(path, device="cpu")
        if data is None:
            raise ValueError("it holds no settings")
        kwargs, kind = dict(data["policy_kwargs"]), data["policy_class"]
        if issubclass(kind, ActorCriticPolicy):  # the others' kwargs have it
            kwargs["use_sde"] = data["use_sde"]
        policy: BasePolicy = kind(
            data["observation_space"], data["action_space"], lambda _: 0.0, **kwargs
        )
        policy.load_state_dict(dict(parameters)["policy"])  # type: ignore[arg-type]
    except (
        zipfile.BadZipFile, pickle.UnpicklingError, json.JSONDecodeError, AssertionError,
        AttributeError, EOFError, ImportError, IndexError, KeyError, OSError, RuntimeError,
        TypeError, ValueError,
    ) as error:  # fmt: skip
        raise ValueError(
            f"{str(path)!r} is not a saved model of Stable-Baselines3, or is damaged: {error}"
        ) from error
    policy.set_training_mode(False)
    return policy


def warn_of_pickle(path: Path) -> None:
    """Say that a file can run code."""
    warnings.warn(
        f"{str(path)!r} is a pickle of Stable-Baselines3: loading it runs the code it holds, so "
        "trust where it came from; policies saved as .npz hold none",
        stacklevel=3,
    )
