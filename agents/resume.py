"""Checkpoints: a training that stopped between two rollouts goes on bit for bit.

A checkpoint is SB3's own zip with two members more: everything else that the rest of the
training depends on, and the replay buffer. It is taken at the start of a rollout, after
SB3 has drawn its exploration noise there, and put back at the same point.
"""

from __future__ import annotations

import io
import pickle
import random
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml
from stable_baselines3.common.base_class import BaseAlgorithm

from agents.command import read_yaml
from agents.configuration import Settings, load_class
from agents.runs import CONFIG, History, config_text
from powered_walker_env.controllers.stable_baselines import warn_of_pickle
from powered_walker_env.files import written_aside
from powered_walker_env.sb3 import PoweredWalkerVecEnv

_STATE, _REPLAY = "run_state.pkl", "replay_buffer.pkl"  # members of a checkpoint
_MEMORY = ("_last_lstm_states",)  # of a model, that its `load` makes anew
_EXPLORATION = ("exploration_mat", "exploration_matrices")  # of `use_sde`, likewise


def save_model(model: BaseAlgorithm, target: Path) -> None:
    """Save a model as Stable-Baselines3 does, complete or not at all."""
    with written_aside(target) as aside:
        aside.write_bytes(_content(model).getbuffer())


def save_checkpoint(
    model: BaseAlgorithm, target: Path, history: Sequence[Mapping[str, Any]], settings: Settings
) -> None:
    """Save a model with all that the rest of its training depends on, in one file.

    Args:
        model: at the start of a rollout, training in a `PoweredWalkerVecEnv`.
        history: the evaluations so far.
        settings: of the run.
    """
    env = model.get_env()
    assert isinstance(env, PoweredWalkerVecEnv)
    state = {
        "config": config_text(settings),
        "history": [dict(row) for row in history],
        "walkers": env.get_state(),
        "memory": {name: vars(model)[name] for name in _MEMORY if name in vars(model)},
        "draws": {
            "random": random.getstate(),
            "numpy": np.random.get_state(),  # noqa: NPY002 (SB3 draws from it)
            "torch": torch.get_rng_state(),
            "exploration": _exploration(model),
        },
    }
    content = _content(model)
    with zipfile.ZipFile(content, "a") as archive:
        archive.writestr(_STATE, pickle.dumps(state))
        replay = getattr(model, "replay_buffer", None)
        if replay is not None:
            with archive.open(_REPLAY, "w", force_zip64=True) as member:
                pickle.dump(replay, member)
    with written_aside(target) as aside:
        aside.write_bytes(content.getbuffer())


def load_checkpoint(
    path: Path, env: PoweredWalkerVecEnv, settings: Settings
) -> tuple[BaseAlgorithm, History, dict[str, Any]]:
    """The model of a checkpoint, to go on in `env`; the evaluations; and what it has to draw.

    The last is for `restore_draws`, at the start of the first rollout. The file is a pickle:
    a warning says so.

    Raises:
        ValueError: a file that is missing, damaged or no checkpoint; other settings.
    """
    if not path.is_file():
        raise ValueError(f"there is no checkpoint {str(path)!r} to go on from; train it anew")
    warn_of_pickle(path)
    try:
        with zipfile.ZipFile(path) as archive:
            if _STATE not in archive.namelist():
                raise ValueError("it is a model but no checkpoint")
            state = pickle.loads(archive.read(_STATE))
            replay = None
            if _REPLAY in archive.namelist():
                with archive.open(_REPLAY) as member:
                    replay = pickle.load(member)
        changed = _changed(state["config"], config_text(settings))
        if not changed:
            kind, content = load_class(settings.algo), io.BytesIO(path.read_bytes())
            model = kind.load(content, env=env, device="cpu", force_reset=False)
            if replay is not None:
                vars(model)["replay_buffer"] = replay
            env.set_state(state["walkers"])
            vars(model).update(state["memory"])
            return model, state["history"], state["draws"]
    except (ArithmeticError, AssertionError, AttributeError, EOFError, ImportError, LookupError,
            OSError, pickle.UnpicklingError, RuntimeError, TypeError, ValueError,
            zipfile.BadZipFile) as error:  # fmt: skip
        raise ValueError(
            f"{str(path)!r} is damaged, or no checkpoint ({type(error).__name__}: {error}); it "
            "cannot go on"
        ) from error
    raise ValueError(
        f"{CONFIG} was changed since the run began: {changed}; put it back, or train under "
        "another name"
    )


def restore_draws(model: BaseAlgorithm, draws: Mapping[str, Any]) -> None:
    """Put back the random numbers, where `save_checkpoint` took them."""
    for name, value in draws["exploration"].items():
        setattr(_noise(model), name, value.to(model.device))
    random.setstate(draws["random"])
    np.random.set_state(draws["numpy"])  # noqa: NPY002
    torch.set_rng_state(draws["torch"])


def read_run(folder: Path) -> Settings:
    """The settings of a run of `agents.train`.

    Raises:
        ValueError: no such run, or a damaged configuration.
    """
    path = folder / CONFIG
    if not path.is_file():
        raise ValueError(f"there is no run {str(folder)!r}; train it without --resume")
    content = read_yaml(path)
    try:
        return Settings(**content)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{str(path)!r} is damaged: {error}") from error


def _changed(before: str, now: str) -> str:
    """What differs between two configurations."""
    old, new = yaml.safe_load(before), yaml.safe_load(now)
    return ", ".join(
        f"{name} is {new[name]!r} and was {value!r}"
        for name, value in old.items()
        if new[name] != value
    )


def _content(model: BaseAlgorithm) -> io.BytesIO:
    content = io.BytesIO()
    model.save(content)
    return content


def _noise(model: BaseAlgorithm) -> Any:
    """The distribution of actions; with `use_sde` it holds a state of its own."""
    return getattr(getattr(model.policy, "actor", None) or model.policy, "action_dist", None)


def _exploration(model: BaseAlgorithm) -> dict[str, torch.Tensor]:
    held = vars(_noise(model)) if _noise(model) is not None else {}
    return {name: held[name].detach().cpu() for name in _EXPLORATION if name in held}
