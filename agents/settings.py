"""Settings of a training: rl-baselines3-zoo's YAML, keyed by environment id, checked.

Keys are the arguments of the algorithm's constructor, and those of `ZOO_KEYS`.
"""

from __future__ import annotations

import ast
import copy
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml
from stable_baselines3.common.noise import ActionNoise, NormalActionNoise

from agents.algorithms import algorithm
from agents.command import CONFIGS, UserError

EVALUATIONS = 10  # of a training
ZOO_KEYS = (
    "n_timesteps", "n_envs", "policy", "policy_kwargs", "env_kwargs", "normalize", "noise_type",
    "noise_std",
)  # fmt: skip
_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")
_LITERALS = ("policy_kwargs", "replay_buffer_kwargs", "rollout_buffer_kwargs")
# Arguments that are not for the file to set.
_RESERVED = {
    "self", "env", "device", "seed", "verbose", "tensorboard_log", "action_noise",
    "_init_setup_model",
}  # fmt: skip
_ACTIVATIONS = ("ReLU", "Tanh", "ELU", "LeakyReLU", "SiLU", "GELU")


@dataclass(frozen=True)
class Settings:
    """What a training needs; `hyperparameters` are as the file has them."""

    algo: str
    env_id: str
    seed: int = 0
    n_envs: int = 1
    n_timesteps: int = 100_000
    every: int = 10_000  # strides between evaluations
    episodes: int = 50  # of an evaluation
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    hyperparameters: dict[str, Any] = field(default_factory=dict)

    def model_kwargs(self, actions: int = 2) -> dict[str, Any]:
        """The constructor's arguments from the hyperparameters, for so many numbers to decide."""
        kwargs = copy.deepcopy(self.hyperparameters)  # SB3 adds to what it is given
        noise_type, noise_std = kwargs.pop("noise_type", None), kwargs.pop("noise_std", 0.0)
        for key in _SCHEDULES:
            if isinstance(kwargs.get(key), str):
                kwargs[key] = linear_schedule(key, kwargs[key])
        for key in _LITERALS:
            if isinstance(kwargs.get(key), str):
                kwargs[key] = python_literal(key, kwargs[key])
        if isinstance(kwargs.get("train_freq"), list):
            kwargs["train_freq"] = tuple(kwargs["train_freq"])
        if noise_type is not None:
            kwargs["action_noise"] = _noise(noise_type, noise_std, actions)
        kwargs.setdefault("policy", algorithm(self.algo).policy)
        return kwargs


def read_settings(
    algo: str,
    env_id: str,
    config: Path | None = None,
    *,
    seed: int = 0,
    steps: int | None = None,
    env_kwargs: Mapping[str, Any] | None = None,
    hyperparameters: Mapping[str, Any] | None = None,
    every: int | None = None,
    episodes: int = Settings.episodes,
) -> Settings:
    """The settings for an algorithm and an environment.

    Args:
        config: the file; left out, `configs/ALGO.yml` or, without one, SB3's defaults.
        steps, env_kwargs, hyperparameters: take the place of those of the file.
        every: strides between evaluations; a tenth of the training if left out.
        episodes: of an evaluation.

    Raises:
        UserError: an unknown algorithm or key, or a file that is missing, not YAML or
            without the environment.
    """
    algorithm(algo)
    path = CONFIGS / f"{algo}.yml" if config is None else config
    section = _section(path, env_id) if config is not None or path.is_file() else {}
    section |= dict(hyperparameters or {})
    if steps is not None:
        section["n_timesteps"] = steps
    settings = settings_of(algo, env_id, section, seed, env_kwargs or {}, str(path))
    tenth = max(1, settings.n_timesteps // EVALUATIONS)
    return replace(settings, every=tenth if every is None else every, episodes=episodes)


def settings_of(
    algo: str,
    env_id: str,
    section: Mapping[str, Any],
    seed: int,
    env_kwargs: Mapping[str, Any],
    source: str,
) -> Settings:
    """The settings that a section of a file means.

    Raises:
        UserError: an unknown key or a bad value; `source` says where.
    """
    values = dict(section)
    _check_keys(algo, values, f"{source}, {env_id}")
    if values.pop("normalize", False):
        raise UserError(
            f"normalize must be false, got it in {source}: observations are deviations over their "
            "scale and rewards at most 1 already"
        )
    in_file = values.pop("env_kwargs", None) or {}
    if isinstance(in_file, str):
        in_file = python_literal("env_kwargs", in_file)
    settings = Settings(
        algo=algo,
        env_id=env_id,
        seed=seed,
        n_envs=_count("n_envs", values.pop("n_envs", 1)),
        n_timesteps=_count("n_timesteps", values.pop("n_timesteps", Settings.n_timesteps)),
        env_kwargs={**in_file, **env_kwargs},
        hyperparameters=values,
    )
    settings.model_kwargs()  # says now what would not do later
    return settings


def _section(path: Path, env_id: str) -> dict[str, Any]:
    try:
        content = yaml.safe_load(path.read_text())
    except OSError as error:
        raise UserError(f"the configuration {str(path)!r} cannot be read: {error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"the configuration {str(path)!r} is not YAML: {error}") from error
    name = env_id.rpartition(":")[2]  # without the module to import
    if not isinstance(content, dict) or not isinstance(content.get(name), dict):
        known = ", ".join(map(str, content)) if isinstance(content, dict) else "none"
        raise UserError(
            f"{str(path)!r} has no section for {name!r}, only for: {known}; add one, or give "
            "another file with --config"
        )
    return dict(content[name])


def _check_keys(algo: str, values: Mapping[str, Any], where: str) -> None:
    """Refuse keys that neither the algorithm nor the zoo's format knows."""
    arguments = set(inspect.signature(algorithm(algo).load_class().__init__).parameters)
    known = (arguments - _RESERVED) | set(ZOO_KEYS)
    unknown = [key for key in values if key not in known]
    if unknown:
        raise UserError(
            f"unknown key {', '.join(map(repr, unknown))} in {where}; known for {algo}: "
            f"{', '.join(sorted(known))}"
        )


def _count(name: str, value: Any) -> int:
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not good or value < 1 or value != int(value):
        raise UserError(f"{name} must be a positive integer, got {value!r}")
    return int(value)


def linear_schedule(key: str, text: str) -> Callable[[float], float]:
    """The zoo's `lin_1e-3`: from 1e-3 down to 0 over the training.

    Raises:
        UserError: a text of another form.
    """
    kind, _, number = text.partition("_")
    try:
        initial = float(number) if kind == "lin" else float(text)
    except ValueError:
        raise UserError(f"{key} must be a number or like 'lin_1e-3', got {text!r}") from None
    if kind != "lin":  # YAML takes 1e-3 for a text
        return lambda _: initial
    return lambda remaining: remaining * initial


def python_literal(key: str, text: str) -> dict[str, Any]:
    """The zoo's `"dict(net_arch=[64, 64], activation_fn=nn.ReLU)"`, read without running it.

    Raises:
        UserError: anything but a dictionary of literals and activation functions.
    """
    try:
        value = _evaluate(ast.parse(text.strip(), mode="eval").body)
    except (SyntaxError, ValueError) as error:
        raise UserError(
            f"{key} must be a dictionary of plain values, got {text!r}: {error}"
        ) from error
    if not isinstance(value, dict):
        raise UserError(f"{key} must be a dictionary, got {text!r}")
    return value


def _evaluate(node: ast.expr) -> Any:
    """The value of a literal, `dict(...)` or `nn.NAME` inside one included."""
    match node:
        case ast.Call(func=ast.Name(id="dict"), args=[], keywords=keywords) if all(
            word.arg for word in keywords
        ):
            return {str(word.arg): _evaluate(word.value) for word in keywords}
        case ast.Dict(keys=keys, values=values) if None not in keys:
            found = [_evaluate(key) for key in keys if key is not None]
            return dict(zip(found, map(_evaluate, values), strict=True))
        case ast.List(elts=elements):
            return [_evaluate(element) for element in elements]
        case ast.Attribute(value=ast.Name(id="nn"), attr=name) if name in _ACTIVATIONS:
            return getattr(torch.nn, name)
    return ast.literal_eval(node)


def _noise(kind: Any, std: Any, actions: int) -> ActionNoise:
    if kind != "normal" or not isinstance(std, (int, float)) or std < 0:
        raise UserError(
            f"noise_type must be 'normal' with a noise_std >= 0, got {kind!r} and {std!r}"
        )
    return NormalActionNoise(np.zeros(actions), np.full(actions, float(std)))
