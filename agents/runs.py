"""Run folders: what a training writes, where, and so that a kill harms nothing.

`runs/NAME/` holds `config.yml` (the settings, complete), `versions.json` (where the
results come from), `checkpoint.zip` (everything to go on from), `best_model.zip` and
`evaluations.csv`. Every file is written aside, then renamed: it is there complete or
not at all.
"""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import importlib.metadata
import io
import json
import pickle
import platform
import random
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
import yaml
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecMonitor

from agents.algorithms import load_model
from agents.command import UserError
from agents.settings import Settings, settings_of
from powered_walker_env.files import write_text, written_aside
from powered_walker_env.sb3 import PoweredWalkerVecEnv

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

RUNS = Path("runs")
CONFIG, VERSIONS = "config.yml", "versions.json"
CHECKPOINT, BEST_MODEL, EVALUATIONS = "checkpoint.zip", "best_model.zip", "evaluations.csv"
POLICY = "policy.npz"  # of the trainings that have no model of Stable-Baselines3
_STATE, _REPLAY = "run_state.pkl", "replay_buffer.pkl"  # members of a checkpoint
_MEMORY = ("_last_lstm_states",)  # of a model, that its `load` makes anew
_PACKAGES = (
    "powered-walker-env", "gymnasium", "numba", "numpy", "scipy", "stable-baselines3",
    "sb3-contrib", "torch",
)  # fmt: skip


def write_json(target: Path, content: Any) -> None:
    """Write a JSON file: complete or not at all."""
    write_text(target, json.dumps(content, indent=2, allow_nan=False) + "\n")


def run_folder(name: str, runs: Path = RUNS) -> Path:
    """The folder of a run.

    Raises:
        UserError: a name that would not be one folder inside `runs`.
    """
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", name):
        raise UserError(f"name must be letters, digits, '_', '-' and '.', got {name!r}")
    return runs / name


def create_run(folder: Path, settings: Settings, *, overwrite: bool = False) -> None:
    """Make the folder of a new run, with its configuration and versions.

    Raises:
        UserError: it exists, and `overwrite` is false or it is no run.
    """
    if folder.exists() and not overwrite:
        raise UserError(
            f"{str(folder)!r} exists; choose another name, replace it by --overwrite, or go on "
            "with it by agents.train --resume"
        )
    create_folder(folder, config_text(settings), settings.seed, overwrite=overwrite)


def create_folder(folder: Path, config: str, seed: int, *, overwrite: bool = False) -> None:
    """Make the folder of a new run of any kind, its configuration given as text.

    Raises:
        UserError: it exists, and `overwrite` is false or it is no run.
    """
    if folder.exists():
        if not overwrite:
            raise UserError(
                f"{str(folder)!r} exists; choose another name, or replace it by --overwrite"
            )
        remove_run(folder)
    folder.mkdir(parents=True)
    write_text(folder / CONFIG, config)
    write_json(folder / VERSIONS, provenance(seed))


def remove_run(folder: Path) -> None:
    """Delete a run, and nothing that is not one.

    Raises:
        UserError: the folder holds something, but no configuration of a run.
    """
    if not folder.is_dir() or (any(folder.iterdir()) and not (folder / CONFIG).is_file()):
        raise UserError(f"{str(folder)!r} is no run, so --overwrite leaves it alone; move it away")
    shutil.rmtree(folder)


def clear_leftovers(folder: Path) -> None:
    """Delete what a killed process left half written."""
    for part in folder.glob(".*.part*"):
        part.unlink(missing_ok=True)


def config_text(settings: DataclassInstance) -> str:
    """The settings as YAML."""
    return str(yaml.safe_dump(dataclasses.asdict(settings), sort_keys=False))


def read_run(folder: Path) -> Settings:
    """The settings of a run.

    Raises:
        UserError: no such run, or a damaged configuration.
    """
    path = folder / CONFIG
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        section = content["hyperparameters"] | {
            "n_envs": content["n_envs"],
            "n_timesteps": content["n_timesteps"],
        }
        head = content["algo"], content["env_id"]
        settings = settings_of(*head, section, content["seed"], content["env_kwargs"], str(path))
        return replace(settings, every=content["every"], episodes=content["episodes"])
    except OSError as error:
        raise UserError(f"there is no run {str(folder)!r}: {error}") from error
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise UserError(f"{str(path)!r} is damaged: {error!r}") from error


def provenance(seed: int) -> dict[str, Any]:
    """What a result depends on besides its settings."""
    packages = {}
    for name in _PACKAGES:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            packages[name] = importlib.metadata.version(name)
    return {
        "started": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        "command": [Path(sys.argv[0]).name, *sys.argv[1:]],
        "seed": seed,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "packages": packages,
        "git_commit": git_commit(),
    }


def git_commit() -> str | None:
    """The commit of the repository, `-dirty` if it has changed since; None outside of one."""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, timeout=10
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None


def save_model(model: BaseAlgorithm, target: Path) -> None:
    """Save a model as Stable-Baselines3 does, complete or not at all."""
    with written_aside(target) as aside:
        aside.write_bytes(_content(model).getbuffer())


def save_checkpoint(
    model: BaseAlgorithm, target: Path, history: Sequence[Mapping[str, Any]]
) -> None:
    """Save a model with all that the rest of its training depends on, in one file.

    Args:
        model: between two rollouts, training in `VecMonitor(PoweredWalkerVecEnv)`.
        history: the evaluations so far.
    """
    content = _content(model)
    with zipfile.ZipFile(content, "a") as archive:
        archive.writestr(_STATE, pickle.dumps(_state(model, history)))
        replay = getattr(model, "replay_buffer", None)
        if replay is not None:
            with archive.open(_REPLAY, "w", force_zip64=True) as member:
                pickle.dump(replay, member)
    with written_aside(target) as aside:
        aside.write_bytes(content.getbuffer())


def load_checkpoint(
    path: Path, env: VecMonitor, device: str = "cpu"
) -> tuple[BaseAlgorithm, list[dict[str, Any]]]:
    """The model of a checkpoint, ready to go on in `env` bit for bit, and the evaluations.

    Raises:
        UserError: a file that is missing, damaged or not a checkpoint.
    """
    model = load_model(path, env=env, device=device, force_reset=False)
    try:
        with zipfile.ZipFile(path) as archive:
            state = pickle.loads(archive.read(_STATE))
            if _REPLAY in archive.namelist():
                with archive.open(_REPLAY) as member:
                    model.__dict__["replay_buffer"] = pickle.load(member)
    except KeyError as error:
        raise UserError(f"{str(path)!r} is a model but no checkpoint; it cannot go on") from error
    _walkers(env).set_state(state["walkers"])
    env.episode_returns, env.episode_lengths = state["episode_returns"], state["episode_lengths"]
    vars(model).update(state["memory"])
    random.setstate(state["random"])
    np.random.set_state(state["numpy"])  # noqa: NPY002 (SB3 draws from it)
    torch.set_rng_state(state["torch"])
    return model, state["history"]


def write_evaluations(target: Path, history: Sequence[Mapping[str, Any]]) -> None:
    """The evaluations as CSV."""
    text = io.StringIO()
    if history:
        table = csv.DictWriter(text, list(history[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(history)
    write_text(target, text.getvalue())


def _content(model: BaseAlgorithm) -> io.BytesIO:
    content = io.BytesIO()
    model.save(content)
    return content


def _state(model: BaseAlgorithm, history: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    env = model.get_env()
    assert isinstance(env, VecMonitor)
    return {
        "walkers": _walkers(env).get_state(),
        "episode_returns": env.episode_returns,
        "episode_lengths": env.episode_lengths,
        "memory": {name: vars(model)[name] for name in _MEMORY if name in vars(model)},
        "random": random.getstate(),
        "numpy": np.random.get_state(),  # noqa: NPY002
        "torch": torch.get_rng_state(),
        "history": [dict(row) for row in history],
    }


def _walkers(env: VecMonitor) -> PoweredWalkerVecEnv:
    assert isinstance(env.venv, PoweredWalkerVecEnv)
    return env.venv
