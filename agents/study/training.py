"""The training of a cell, by the machinery of `agents.train` and `agents.own_training`.

Its run is a folder like any other's. A training that was interrupted goes on from its checkpoint,
bit for bit; by gradients, which keep none, and one whose settings have changed, it begins again.
"""

from __future__ import annotations

import contextlib
import csv
import json
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents import own_training
from agents import train as train_module
from agents.command import CONFIGS
from agents.configuration import Settings, read_settings
from agents.own_learners import OWN_LEARNERS
from agents.runs import CHECKPOINT, EVALUATIONS, run_folder, write_json
from agents.study.budgets import Budget
from agents.study.cells import Cell

TRAINED = "trained.json"  # in the folder of a run that has come to its end


@dataclass(frozen=True)
class Training:
    """A training that has come to its end."""

    folder: Path
    strides: int
    seconds: float  # processor time; of the last part alone, if it was interrupted
    resumed: bool
    curve: dict[str, list[float]]  # of its own evaluations: columns of `evaluations.csv`

    def plain(self) -> dict[str, Any]:
        """As JSON has it."""
        return {"strides": self.strides, "seconds": self.seconds, "resumed": self.resumed,
                "curve": self.curve}  # fmt: skip


@contextlib.contextmanager
def own_pickles() -> Iterator[None]:
    """Say nothing of pickles: those of a study are its own."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".* is a pickle of Stable-Baselines3")
        yield


def trained(cell: Cell, budget: Budget, runs: Path) -> Training:
    """Train a cell, or go on training it, or find it trained.

    Args:
        runs: where its run is, or will be.

    Raises:
        ValueError: a learner that does not take the task, or is not there.
    """
    folder = run_folder(cell.name, runs)
    done = folder / TRAINED
    settings = settings_of(cell, budget)
    if not done.is_file():
        began = time.process_time()
        with own_pickles():
            strides, resumed = (
                _by_sb3(settings, folder)
                if isinstance(settings, Settings)
                else _by_own(cell.controller, settings, folder)
            )
        seconds = time.process_time() - began
        write_json(done, {"strides": strides, "seconds": seconds, "resumed": resumed})
    return Training(folder, curve=_curve(folder), **json.loads(done.read_text(encoding="utf-8")))


def settings_of(cell: Cell, budget: Budget) -> Any:
    """What a cell's training needs: its configuration file's, but for the budget's strides.

    Returns:
        The `Settings` of `agents.configuration`, or those of one of our own learners.

    Raises:
        ValueError: a cell that does not learn, an unknown algorithm.
    """
    if not cell.learns:
        raise ValueError(f"cell must be a learner's to be trained, got {cell.name!r}")
    kwargs, strides = dict(cell.env_kwargs), budget.strides.get(cell.controller)
    if cell.controller in OWN_LEARNERS:
        changes: dict[str, Any] = {"episodes": budget.training_episodes}
        changes |= {} if strides is None else {"n_timesteps": strides}
        return own_training.read_settings(
            OWN_LEARNERS[cell.controller].settings, cell.controller, cell.env_id, changes,
            seed=cell.seed, env_kwargs=kwargs,
        )  # fmt: skip
    config = CONFIGS / cell.config if cell.config else None
    return read_settings(
        cell.algo, cell.env_id, config,
        env_kwargs=kwargs, seed=cell.seed, n_timesteps=strides, episodes=budget.training_episodes,
    )  # fmt: skip


def _by_sb3(settings: Settings, folder: Path) -> tuple[int, bool]:
    """Strides, and whether it went on from a checkpoint."""
    resume = (folder / CHECKPOINT).is_file()
    try:
        done = train_module.train(settings, folder, resume=resume, overwrite=not resume, quiet=True)
    except ValueError:
        if not resume:
            raise
        resume = False  # a damaged checkpoint, or one of other settings
        done = train_module.train(settings, folder, overwrite=True, quiet=True)
    if done.stopped:
        raise KeyboardInterrupt(f"the training {folder.name} was asked to stop")
    return int(done.num_timesteps), resume


def _by_own(name: str, settings: Any, folder: Path) -> tuple[int, bool]:
    def done(resume: bool) -> own_training.OwnLearner:
        learner = OWN_LEARNERS[name].learner(settings)
        own_training.train(learner, folder, overwrite=not resume, resume=resume, quiet=True)
        return learner

    resume = (folder / own_training.KEPT).is_file()
    try:
        learner = done(resume)
    except ValueError:
        if not resume:
            raise
        resume = False  # a damaged file, or one of other settings
        learner = done(resume)
    if not learner.finished:
        raise KeyboardInterrupt(f"the training {folder.name} was asked to stop")
    return learner.strides, resume


def _curve(folder: Path) -> dict[str, list[float]]:
    with (folder / EVALUATIONS).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [float(row[name]) for row in rows] for name in rows[0]}
