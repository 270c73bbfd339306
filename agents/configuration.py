"""What a training needs: one dataclass, read from rl-baselines3-zoo's YAML, keyed by id.

Keys of a section are the arguments of the algorithm's constructor, and those of `ZOO_KEYS`.
"""

from __future__ import annotations

import contextlib
import copy
import importlib
import inspect
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.noise import NormalActionNoise

from agents.command import CONFIGS, ROUND_FOOT, read_yaml
from agents.zoo import linear_schedule, python_literal

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: By the names of rl-baselines3-zoo.
ALGORITHMS = {
    "ppo": "stable_baselines3.PPO",
    "a2c": "stable_baselines3.A2C",
    "sac": "stable_baselines3.SAC",
    "td3": "stable_baselines3.TD3",
    "trpo": "sb3_contrib.TRPO",
    "tqc": "sb3_contrib.TQC",
    "crossq": "sb3_contrib.CrossQ",
    "ppo_lstm": "sb3_contrib.RecurrentPPO",
}
EVALUATIONS = 10  # of a training
ZOO_KEYS = (
    "n_timesteps", "n_envs", "policy", "policy_kwargs", "env_kwargs", "normalize", "noise_type",
    "noise_std",
)  # fmt: skip
# Arguments that are not for the file to set.
_RESERVED = {
    "self", "env", "device", "seed", "verbose", "tensorboard_log", "action_noise",
    "_init_setup_model",
}  # fmt: skip
_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")
_LITERALS = ("policy_kwargs", "replay_buffer_kwargs", "rollout_buffer_kwargs")
_FRACTIONS = ("gamma", "gae_lambda", "tau")
# Of the integers; 1 of the others.
_LEAST = {"gradient_steps": -1, "learning_starts": 0, "top_quantiles_to_drop_per_net": 0}


@dataclass(frozen=True)
class Settings:
    """What a training needs; `config.yml` of a run holds exactly these.

    Raises:
        ValueError: an unknown algorithm or key, or a value that will not do.
    """

    algo: str = "ppo"
    env_id: str = ROUND_FOOT
    seed: int = 0
    n_envs: int = 1
    n_timesteps: int = 100_000
    every: int = 0  # strides between evaluations; 0: a tenth of the training
    episodes: int = 50  # of an evaluation
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    hyperparameters: dict[str, Any] = field(default_factory=dict)  # as the file has them

    def __post_init__(self) -> None:
        load_class(self.algo)
        check_numbers(self, seed=0, every=0)
        if self.every == 0:
            object.__setattr__(self, "every", max(1, self.n_timesteps // EVALUATIONS))
        for name in ("env_kwargs", "hyperparameters"):
            value = getattr(self, name)
            if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
                raise ValueError(f"{name} must be a mapping of names to values, got {value!r}")
        _check_hyperparameters(self.algo, self.hyperparameters)
        self.model_kwargs(1)  # says now what would not do later

    @property
    def seeds(self) -> tuple[int, int]:
        """Of the training and of its evaluations."""
        return study_seeds(self.seed)

    def model_kwargs(self, actions: int) -> dict[str, Any]:
        """The constructor's arguments, for so many numbers to decide."""
        kwargs = copy.deepcopy(self.hyperparameters)  # SB3 adds to what it is given
        noise_type, noise_std = kwargs.pop("noise_type", None), kwargs.pop("noise_std", 0.0)
        for key, value in kwargs.items():
            if key in _LITERALS and isinstance(value, str):
                kwargs[key] = python_literal(key, value)
            elif key in _SCHEDULES and isinstance(value, str):
                kwargs[key] = linear_schedule(key, value)
        if isinstance(kwargs.get("train_freq"), list):
            kwargs["train_freq"] = tuple(kwargs["train_freq"])
        if noise_type is not None:
            if noise_type != "normal" or not _is_number(noise_std) or noise_std < 0:
                raise ValueError(
                    "noise_type must be 'normal' with a noise_std >= 0, got "
                    f"{noise_type!r} and {noise_std!r}"
                )
            kwargs["action_noise"] = NormalActionNoise(
                np.zeros(actions), np.full(actions, float(noise_std))
            )
        kwargs.setdefault("policy", "MlpLstmPolicy" if self.algo == "ppo_lstm" else "MlpPolicy")
        return kwargs


def study_seeds(seed: int) -> tuple[int, int]:
    """Seeds of a training and of its evaluations, independent of those of another seed.

    Walkers of a batch are seeded s, s + 1, ... With the seeds 0, 1, 2 of a study taken as
    they are, its trainings would share nearly all of their walkers.
    """
    training, evaluation = np.random.SeedSequence(seed).generate_state(2).tolist()
    return training, evaluation


def load_class(algo: str) -> type[BaseAlgorithm]:
    """The class of an algorithm (imports its library).

    Raises:
        ValueError: no such algorithm; the message lists them.
    """
    if algo not in ALGORITHMS:
        raise ValueError(f"algo must be one of {', '.join(ALGORITHMS)}, got {algo!r}")
    module, _, name = ALGORITHMS[algo].rpartition(".")
    found: type[BaseAlgorithm] = getattr(importlib.import_module(module), name)
    return found


def read_settings(
    algo: str,
    env_id: str,
    config: Path | None = None,
    *,
    env_kwargs: Mapping[str, Any] | None = None,
    hyperparameters: Mapping[str, Any] | None = None,
    **given: Any,
) -> Settings:
    """The settings for an algorithm and an environment.

    Args:
        config: the file; left out, `configs/ALGO.yml` or, without one or without a section
            for an environment of one's own, SB3's defaults.
        env_kwargs, hyperparameters: take the place of those of the file.
        **given: other fields of `Settings`; None is as left out.

    Raises:
        ValueError: an unknown algorithm or key, a bad value, or a file that is missing, not
            YAML or without the environment.
    """
    load_class(algo)
    path = CONFIGS / f"{algo}.yml" if config is None else config
    section = _section(path, env_id, config is not None) if config or path.is_file() else {}
    values = {**section, **(hyperparameters or {})}
    try:
        if values.pop("normalize", False):
            raise ValueError(
                "normalize must be false: observations are deviations over their scale and "
                "rewards at most 1 already"
            )
        in_file = values.pop("env_kwargs", None) or {}
        if isinstance(in_file, str):
            in_file = python_literal("env_kwargs", in_file)
        if not isinstance(in_file, dict):
            raise ValueError(f"env_kwargs must be a mapping of names to values, got {in_file!r}")
        own: dict[str, Any] = {
            key: values.pop(key) for key in ("n_envs", "n_timesteps") if key in values
        }
        own |= {key: value for key, value in given.items() if value is not None}
        arguments = {**in_file, **(env_kwargs or {})}
        return Settings(algo, env_id, env_kwargs=arguments, hyperparameters=values, **own)
    except ValueError as error:
        raise ValueError(f"{error} (in {path}, {env_id}, or given in its place)") from error


def _section(path: Path, env_id: str, wanted: bool) -> dict[str, Any]:
    """What a file has for an environment; nothing, if it need not have it."""
    content, name = read_yaml(path), env_id.rpartition(":")[2]  # without the module to import
    if isinstance(content, dict) and isinstance(content.get(name), dict):
        return dict(content[name])
    if not wanted:
        return {}
    known = ", ".join(map(str, content)) if isinstance(content, dict) else "none"
    raise ValueError(
        f"{str(path)!r} has no section for {name!r}, only for: {known}; add one, or give another "
        "file with --config"
    )


def _check_hyperparameters(algo: str, values: Mapping[str, Any]) -> None:
    """Refuse keys that neither the algorithm nor the zoo knows, and numbers that cannot be."""
    arguments = inspect.signature(load_class(algo).__init__).parameters
    known = (set(arguments) - _RESERVED) | (set(ZOO_KEYS) - {"n_envs", "n_timesteps"})
    unknown = [key for key in values if key not in known]
    if unknown:
        raise ValueError(
            f"unknown key {', '.join(map(repr, unknown))}; known for {algo}: "
            f"{', '.join(sorted(known))}"
        )
    for key, value in values.items():
        default = arguments[key].default if key in arguments else None
        if _is_number(value) or (_is_number(default) and key not in (*_SCHEDULES, "train_freq")):
            _check_number(key, value, default)


def _check_number(key: str, value: Any, default: Any) -> None:
    if isinstance(default, int) and not isinstance(default, bool) and default > 0:
        whole_number(key, value, _LEAST.get(key, 1))
    elif not _is_number(value) or not math.isfinite(value):
        raise ValueError(f"{key} must be a finite number, got {value!r}")
    elif key in _FRACTIONS and not 0 <= value <= 1:
        raise ValueError(f"{key} must lie in [0, 1], got {value!r}")
    elif _is_number(default) and default > 0 > value:
        raise ValueError(f"{key} must not be negative, got {value!r}")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def check_numbers(settings: DataclassInstance, **least: int) -> None:
    """Make the numbers of a frozen dataclass integers and floats that are positive.

    Args:
        **least: of integers that may be less than 1.

    Raises:
        ValueError: another value; the message names it.
    """
    for item in fields(settings):
        value = getattr(settings, item.name)
        if item.type == "int":
            value = whole_number(item.name, value, least.get(item.name, 1))
        elif item.type == "float":
            with contextlib.suppress(ValueError):  # YAML takes 3e-3 for a text
                value = float(value) if isinstance(value, str) else value
            if not _is_number(value) or not 0 < value < math.inf:
                raise ValueError(f"{item.name} must be a positive number, got {value!r}")
        object.__setattr__(settings, item.name, value)


def whole_number(name: str, value: Any, least: int = 1) -> int:
    """An integer, also one that a file writes as 2e4.

    Raises:
        ValueError: another value.
    """
    if not _is_number(value) or not math.isfinite(value) or value != int(value) or value < least:
        need = {0: "an integer of at least 0", 1: "a positive integer"}.get(
            least, f"an integer of at least {least}"
        )
        raise ValueError(f"{name} must be {need}, got {value!r}")
    return int(value)
