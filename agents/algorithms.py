"""The learning algorithms: where they are, and how a saved model of each is recognised."""

from __future__ import annotations

import importlib
import io
import json
import pickle
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.command import UserError

# Networks this small gain nothing from a second thread, and on shared cores the two wait for
# each other: 32,768 strides of PPO took 8 s with one and 8 to 55 s with two.
TORCH_THREADS = 1


class Algorithm(NamedTuple):
    """A row of the table."""

    module: str
    class_name: str
    policy: str  # the default one
    policy_module: str  # where the policy of a saved model comes from
    key: str  # what else a saved model has, where several share their policies

    def load_class(self) -> type[BaseAlgorithm]:
        """The algorithm's class (imports its library)."""
        found: type[BaseAlgorithm] = getattr(importlib.import_module(self.module), self.class_name)
        return found


_SB3, _CONTRIB = "stable_baselines3", "sb3_contrib"
_SHARED = "stable_baselines3.common.policies"
#: By the names of rl-baselines3-zoo. Of those that share policies, the pickiest key first.
ALGORITHMS: dict[str, Algorithm] = {
    "ppo": Algorithm(_SB3, "PPO", "MlpPolicy", _SHARED, "clip_range"),
    "trpo": Algorithm(_CONTRIB, "TRPO", "MlpPolicy", _SHARED, "cg_damping"),
    "a2c": Algorithm(_SB3, "A2C", "MlpPolicy", _SHARED, "vf_coef"),
    "sac": Algorithm(_SB3, "SAC", "MlpPolicy", "stable_baselines3.sac.policies", "ent_coef"),
    "td3": Algorithm(_SB3, "TD3", "MlpPolicy", "stable_baselines3.td3.policies", "policy_delay"),
    "tqc": Algorithm(_CONTRIB, "TQC", "MlpPolicy", "sb3_contrib.tqc.policies", "ent_coef"),
    "ppo_lstm": Algorithm(
        _CONTRIB, "RecurrentPPO", "MlpLstmPolicy", "sb3_contrib.common.recurrent.policies",
        "clip_range",
    ),
}  # fmt: skip


def algorithm(name: str) -> Algorithm:
    """The row of that name.

    Raises:
        UserError: no such algorithm; the message lists them.
    """
    if name not in ALGORITHMS:
        raise UserError(f"algo must be one of {', '.join(ALGORITHMS)}, got {name!r}")
    return ALGORITHMS[name]


def algorithm_of(path: Path) -> str:
    """The name of the algorithm that a saved model belongs to.

    Raises:
        UserError: no such file, or not a model of a known algorithm.
    """
    if path.is_dir():
        raise UserError(f"a model is a .zip file, got the folder {str(path)!r}")
    if not path.is_file():
        raise UserError(f"there is no model file {str(path)!r}; train one with agents.train")
    try:
        with zipfile.ZipFile(path) as archive:
            data = json.loads(archive.read("data"))
        policy_module = data["policy_class"]["__module__"]
    except (zipfile.BadZipFile, KeyError, TypeError, ValueError, OSError) as error:
        raise UserError(
            f"{str(path)!r} is not a saved model of Stable-Baselines3, or is damaged: {error}"
        ) from error
    for name, row in ALGORITHMS.items():
        if policy_module == row.policy_module and row.key in data:
            return name
    raise UserError(
        f"{str(path)!r} has a policy of {policy_module}, which belongs to none of the "
        f"algorithms known here: {', '.join(ALGORITHMS)}"
    )


def load_model(path: Path, **kwargs: Any) -> BaseAlgorithm:
    """Load a saved model. Loading can run code that the file brings: trust its source.

    Args:
        path: a .zip of Stable-Baselines3.
        **kwargs: of the algorithm's `load`.

    Raises:
        UserError: a file that is missing, damaged or not a model.
    """
    model_class = algorithm(algorithm_of(path)).load_class()
    content = io.BytesIO(path.read_bytes())
    try:
        return model_class.load(content, **{"device": "cpu", **kwargs})
    except (
        zipfile.BadZipFile, pickle.UnpicklingError, AssertionError, AttributeError, EOFError,
        ImportError, KeyError, RuntimeError, TypeError, ValueError,
    ) as error:  # fmt: skip
        raise UserError(f"the model {str(path)!r} cannot be loaded: {error}") from error


def limit_threads() -> None:
    """Leave the cores to the walkers."""
    torch.set_num_threads(TORCH_THREADS)
