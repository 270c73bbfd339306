"""Train a policy with Stable-Baselines3, from a configuration file in rl-baselines3-zoo's format.

Everything goes to `runs/NAME/`: the settings, versions, evaluations, the best model and a
checkpoint, from which a stopped training goes on bit for bit (`--resume`).
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import configure
from stable_baselines3.common.vec_env import VecMonitor

from agents.algorithms import ALGORITHMS, algorithm, limit_threads
from agents.command import (
    ROUND_FOOT,
    UserError,
    add_env_arguments,
    exit_status,
    make_walkers,
    natural_int,
    pairs,
    positive_int,
)
from agents.progress import History, Progress, polite_stop
from agents.runs import (
    CHECKPOINT,
    CONFIG,
    RUNS,
    clear_leftovers,
    config_text,
    create_run,
    load_checkpoint,
    read_run,
    run_folder,
)
from agents.settings import Settings, read_settings
from powered_walker_env.files import write_text
from powered_walker_env.sb3 import PoweredWalkerVecEnv

DEFAULT_ALGORITHM = "ppo"
_FIXED = ("algo", "env", "env_kwargs", "config", "hyperparams", "seed", "every", "episodes")
STOPPED = 130  # exit status of a program that Ctrl-C ended


def train(
    settings: Settings,
    folder: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    device: str = "cpu",
    tensorboard: bool = False,
    quiet: bool = False,
) -> Progress:
    """Train, or go on training; everything lands in `folder`.

    Args:
        resume: go on from the checkpoint in `folder`, up to `settings.n_timesteps`.
        overwrite: replace a run that is there.
        device: "cpu" or "cuda".
        tensorboard: write its logs, too.
        quiet: print nothing.

    Returns:
        The callback, with `history` and whether it `stopped` early.

    Raises:
        UserError: settings that will not do, a run that exists, or none to resume.
    """
    limit_threads()
    env = VecMonitor(_environment(settings))
    history: History = []
    if resume:
        clear_leftovers(folder)
        model, history = load_checkpoint(folder / CHECKPOINT, env, device)
    else:
        model = _new_model(settings, env, device)
        create_run(folder, settings, overwrite=overwrite)
    outputs = ["tensorboard"] if tensorboard else []
    model.set_logger(configure(str(folder), outputs))
    progress = Progress(settings, folder, history, quiet)
    remaining = settings.n_timesteps - model.num_timesteps

    def request_stop() -> None:
        progress.stop_requested = True

    try:
        with polite_stop(request_stop):
            if remaining > 0:
                model.learn(remaining, callback=progress, reset_num_timesteps=not resume)
    finally:
        progress.close()
        model.logger.close()
        env.close()
    return progress


def _environment(settings: Settings) -> PoweredWalkerVecEnv:
    make_walkers(settings.env_id, 1, **settings.env_kwargs)  # says what is wrong with them
    return PoweredWalkerVecEnv(
        settings.env_id, settings.n_envs, settings.seed, monitor=False, **settings.env_kwargs
    )


def _new_model(settings: Settings, env: VecMonitor, device: str) -> BaseAlgorithm:
    numbers = (env.action_space.shape or (0,))[0]
    try:
        return algorithm(settings.algo).load_class()(
            env=env, seed=settings.seed, device=device, **settings.model_kwargs(numbers)
        )
    except (AssertionError, TypeError, ValueError, KeyError) as error:
        raise UserError(f"{settings.algo} does not take these settings: {error}") from error


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.train", description=__doc__)
    result.add_argument(
        "--algo", choices=ALGORITHMS, help=f"algorithm (default: {DEFAULT_ALGORITHM})"
    )
    add_env_arguments(result, default=None)
    result.add_argument("--name", help="of the run (default: ALGO-ENV-SEED)")
    result.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="YAML keyed by environment, as in rl-baselines3-zoo (default: configs/ALGO.yml)",
    )
    result.add_argument(
        "--hyperparams", nargs="+", metavar="KEY:VALUE", help="in place of those of the file"
    )
    result.add_argument(
        "--steps", type=positive_int, help="strides in all (default: n_timesteps of the file)"
    )
    result.add_argument("--seed", type=natural_int, help="of everything random (default: 0)")
    result.add_argument("--runs", type=Path, default=RUNS, help="where runs go (default: runs)")
    choice = result.add_mutually_exclusive_group()
    choice.add_argument("--resume", action="store_true", help="go on with the run NAME")
    choice.add_argument("--overwrite", action="store_true", help="replace the run NAME")
    result.add_argument(
        "--every", type=positive_int, help="strides between evaluations (default: a tenth)"
    )
    result.add_argument(
        "--episodes",
        type=positive_int,
        help=f"of an evaluation (default: {Settings.episodes})",
    )
    result.add_argument(
        "--gpu",
        choices=("no", "yes"),
        default="no",
        help="use one; networks this small are faster without (default: %(default)s)",
    )
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    settings, folder = _resumed(options) if options.resume else _fresh(options)
    if options.gpu == "yes" and not torch.cuda.is_available():
        raise UserError("no GPU was found; leave --gpu away")
    print(f"{settings.algo} on {settings.env_id}, seed {settings.seed}, in {folder}")
    began = time.monotonic()
    resume_command = f"python -m agents.train --resume --name {folder.name}"
    if options.runs != RUNS:
        resume_command += f" --runs {options.runs}"
    try:
        progress = train(
            settings,
            folder,
            resume=options.resume,
            overwrite=options.overwrite,
            device="cuda" if options.gpu == "yes" else "cpu",
            tensorboard=importlib.util.find_spec("tensorboard") is not None,
        )
    except KeyboardInterrupt:
        print(f"interrupted; go on from the last checkpoint: {resume_command}", file=sys.stderr)
        raise
    if progress.stopped:
        print(
            f"stopped at {progress.num_timesteps:,} of {settings.n_timesteps:,} steps; "
            f"go on: {resume_command}"
        )
        raise SystemExit(STOPPED)
    print(f"{progress.num_timesteps:,} steps, {time.monotonic() - began:.0f} s")
    print(f"evaluate it: python -m agents.evaluate open-loop lqr {folder} --env {settings.env_id}")


def _fresh(options: argparse.Namespace) -> tuple[Settings, Path]:
    """Settings and folder of a new run."""
    settings = read_settings(
        options.algo or DEFAULT_ALGORITHM,
        options.env or ROUND_FOOT,
        options.config,
        seed=options.seed or 0,
        steps=options.steps,
        env_kwargs=pairs(options.env_kwargs),
        hyperparameters=pairs(options.hyperparams),
        every=options.every,
        episodes=options.episodes or Settings.episodes,
    )
    env_name = settings.env_id.rpartition(":")[2]
    name = options.name or f"{settings.algo}-{env_name}-{settings.seed}"
    return settings, run_folder(name, options.runs)


def _resumed(options: argparse.Namespace) -> tuple[Settings, Path]:
    """Settings and folder of a run to go on with."""
    if options.name is None:
        raise UserError("--resume needs the --name of the run")
    given = [f"--{name.replace('_', '-')}" for name in _FIXED if getattr(options, name) is not None]
    if given:
        raise UserError(f"leave {', '.join(given)} away: a resumed run keeps its settings")
    folder = run_folder(options.name, options.runs)
    settings = read_run(folder)
    if options.steps is not None:
        settings = replace(settings, n_timesteps=options.steps)
        write_text(folder / CONFIG, config_text(settings))
    return settings, folder


if __name__ == "__main__":
    sys.exit(exit_status(main))
