"""The training of learners that are not of SB3: their loop, their settings, their command.

A learner walks and learns a little at a time until it has walked its strides. Its policy is
evaluated and saved on the way, and the evaluations choose nothing: what counts is the policy at
the end. Everything goes to `runs/NAME/`. Ctrl-C ends a training early and keeps what there is; a
learner that can, goes on from there bit for bit.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
import torch
from tqdm import tqdm

from agents.command import (
    CONFIGS,
    add_env_arguments,
    natural_int,
    pairs,
    polite_stop,
    positive_int,
    read_yaml,
)
from agents.configuration import EVALUATIONS as LEARNING_CURVE
from agents.configuration import study_seeds
from agents.runs import (
    CONFIG,
    EVALUATIONS,
    RUNS,
    History,
    config_text,
    create_run,
    evaluate_command,
    evaluation_row,
    run_folder,
    write_evaluations,
)
from agents.train import TORCH_THREADS
from powered_walker_env.controllers import Network, evaluate, save_network
from powered_walker_env.controllers.loading import POLICY
from powered_walker_env.files import written_aside
from powered_walker_env.simulation.strides import Array

KEPT = "updates.npy"  # of a run: what its learner has learned from
_GIVEN = ("env_id", "seed", "env_kwargs")  # settings that no file has
SettingsT = TypeVar("SettingsT")


class OwnLearner(Protocol):
    """What the loop asks of a learner."""

    settings: Any  # a dataclass: env_id, seed, env_kwargs, n_timesteps, episodes
    strides: int  # walked so far
    falls: int

    @property
    def finished(self) -> bool:
        """Whether no further update fits into `n_timesteps`."""

    def update(self) -> float:
        """Walk on, then learn; how well the walkers did."""

    def network(self) -> Network:
        """The policy as it is now."""


@runtime_checkable
class Recalls(Protocol):
    """A learner that goes through a stopped training again without walking it, and then on."""

    def kept(self) -> Array:
        """(updates, numbers) what it has learned from."""

    def recall(self, kept: Array) -> None:
        """Take these for the walks of the updates to come.

        Raises:
            ValueError: numbers of another training.
        """


def train(
    learner: OwnLearner, folder: Path, *, overwrite: bool = False, resume: bool = False,
    quiet: bool = False,
) -> History:  # fmt: skip
    """Train; everything lands in `folder`.

    Args:
        resume: go on with the run that is there, of the same settings.

    Returns:
        The evaluations on the way.

    Raises:
        ValueError: a run that exists; none to go on with, or one of other settings.
    """
    torch.set_num_threads(TORCH_THREADS)
    if resume:
        _recall(learner, folder)
    else:
        create_run(folder, learner.settings, overwrite=overwrite)
    history: History = []
    asked: list[bool] = []
    total = learner.settings.n_timesteps
    bar = tqdm(
        total=total, unit=" strides", unit_scale=True, disable=True if quiet else None, leave=False
    )
    with bar, polite_stop(lambda: asked.append(True)):
        _note(learner, history, folder, quiet)
        while not learner.finished and not asked:
            learner.update()
            bar.update(min(learner.strides, total) - bar.n)
            due = learner.strides >= total / LEARNING_CURVE * len(history)
            if due and len(history) < LEARNING_CURVE:
                _note(learner, history, folder, quiet)
        _note(learner, history, folder, quiet)
    return history


def _recall(learner: OwnLearner, folder: Path) -> None:
    if not isinstance(learner, Recalls):
        raise ValueError("this learner cannot go on with a run; begin again, with overwrite")
    try:
        config = (folder / CONFIG).read_text(encoding="utf-8")
        kept = np.load(folder / KEPT, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise ValueError(f"{str(folder)!r} is no run to go on with: {error}") from error
    if config != config_text(learner.settings):
        raise ValueError(
            f"{str(folder)!r} is a run of other settings; go on with its own, or replace it"
        )
    learner.recall(kept)


def _note(learner: OwnLearner, history: History, folder: Path, quiet: bool) -> None:
    """Evaluate, save the policy, and say so."""
    run, network = learner.settings, learner.network()
    save_network(network, folder / POLICY)
    if isinstance(learner, Recalls):
        with written_aside(folder / KEPT) as aside, aside.open("wb") as file:
            np.save(file, learner.kept(), allow_pickle=False)
    if history and history[-1]["steps"] == learner.strides:
        return
    seed = study_seeds(run.seed)[1]
    result = evaluate(network, run.env_id, run.episodes, seed, **run.env_kwargs)
    history.append(evaluation_row(learner.strides, result))
    write_evaluations(folder / EVALUATIONS, history)
    if not quiet:
        strides = result.mean_strides.mean
        tqdm.write(f"{learner.strides:>9,} strides: {strides:.1f} of {result.limit} survived")


def read_settings(
    kind: Callable[..., SettingsT], algo: str, env_id: str,
    changes: Mapping[str, Any] | None = None, *,
    seed: int = 0, env_kwargs: Mapping[str, Any] | None = None,
) -> SettingsT:  # fmt: skip
    """The settings that `configs/ALGO.yml` has for an environment, some of them changed.

    Args:
        kind: their dataclass.

    Raises:
        ValueError: an unknown key or a bad value.
    """
    file = read_yaml(CONFIGS / f"{algo}.yml")
    values = file.get(env_id.rpartition(":")[2], {}) | dict(changes or {})
    known = [item.name for item in fields(kind) if item.name not in _GIVEN]  # type: ignore[arg-type]
    unknown = [key for key in values if key not in known]
    if unknown:
        raise ValueError(f"unknown key {unknown[0]!r}; known are {', '.join(known)}")
    return kind(env_id, seed, env_kwargs=dict(env_kwargs or {}), **values)


def own_parser(
    module: str, algo: str, description: str | None, *, resumes: bool = False
) -> argparse.ArgumentParser:
    """The command line of such a learner.

    Args:
        resumes: whether it goes on with stopped runs.
    """
    result = argparse.ArgumentParser(prog=f"python -m agents.{module}", description=description)
    add_env_arguments(result)
    result.add_argument("--name", help=f"of the run (default: {algo}-ENV-SEED)")
    result.add_argument("--seed", type=natural_int, default=0, help="(default: %(default)s)")
    result.add_argument(
        "--steps",
        type=positive_int,
        help=f"strides in all (default: n_timesteps of configs/{algo}.yml)",
    )
    result.add_argument(
        "--hyperparams",
        nargs="+",
        metavar="KEY:VALUE",
        help=f"in place of those of configs/{algo}.yml",
    )
    result.add_argument("--runs", type=Path, default=RUNS, help="where runs go (default: runs)")
    choice = result.add_mutually_exclusive_group()
    choice.add_argument("--overwrite", action="store_true", help="replace the run NAME")
    if resumes:
        choice.add_argument(
            "--resume", action="store_true", help="go on with the run NAME, of the same settings"
        )
    return result


def run_command(
    parser: argparse.ArgumentParser, kind: Callable[..., Any], algo: str,
    learner_of: Callable[[Any], OwnLearner], arguments: Sequence[str] | None,
) -> None:  # fmt: skip
    """Read the arguments, train, and say what came of it.

    Raises:
        ValueError: bad arguments. KeyboardInterrupt: it was stopped early.
    """
    options = parser.parse_args(arguments)
    changes = pairs(options.hyperparams)
    if options.steps is not None:
        changes["n_timesteps"] = options.steps
    settings = read_settings(
        kind, algo, options.env, changes, seed=options.seed, env_kwargs=pairs(options.env_kwargs)
    )
    name = options.name or f"{algo}-{settings.env_id.rpartition(':')[2]}-{settings.seed}"
    folder, learner = run_folder(name, options.runs), learner_of(settings)
    print(f"{algo} on {settings.env_id}, seed {settings.seed}, in {folder}")
    began = time.monotonic()
    resumes = "resume" in options
    train(learner, folder, overwrite=options.overwrite, resume=resumes and options.resume)
    seconds = time.monotonic() - began
    print(f"{learner.strides:,} strides, {learner.falls:,} falls, {seconds:.0f} s")
    print(f"evaluate it: {evaluate_command(folder, settings.env_id, settings.env_kwargs)}")
    if not learner.finished:
        raise KeyboardInterrupt(
            f"stopped early, of {settings.n_timesteps:,} strides; the policy is what it was then"
            + ("; the same command with --resume goes on" if resumes else "")
        )
