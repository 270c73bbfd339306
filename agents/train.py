"""Train a policy with Stable-Baselines3, from a configuration file in rl-baselines3-zoo's format.

Everything goes to `runs/NAME/`: the settings, versions, evaluations, the best policy and a
checkpoint, from which a stopped training goes on bit for bit (`--resume`).
"""

from __future__ import annotations

import argparse
import importlib.util
import shlex
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, CallbackList, ProgressBarCallback
from stable_baselines3.common.logger import configure

from agents.command import (
    ROUND_FOOT,
    add_env_arguments,
    exit_status,
    natural_int,
    pairs,
    polite_stop,
    positive_int,
)
from agents.configuration import ALGORITHMS, Settings, load_class, read_settings
from agents.resume import load_checkpoint, read_run
from agents.runs import (
    CHECKPOINT,
    RUNS,
    History,
    create_run,
    evaluate_command,
    run_folder,
)
from agents.supervisor import Supervisor
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.metric import stride_metric
from powered_walker_env.controllers.stable_baselines import StrideMetric
from powered_walker_env.sb3 import PoweredWalkerVecEnv

# Networks this small gain nothing from a GPU or a second thread, and on shared cores two wait for
# each other: 32,768 strides of PPO took 8 s with one and 8 to 55 s with two.
TORCH_THREADS = 1


def train(
    settings: Settings,
    folder: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    stop_at: int | None = None,
    quiet: bool = False,
) -> Supervisor:
    """Train, or go on training; everything lands in `folder`.

    Args:
        resume: go on from the checkpoint in `folder`.
        overwrite: replace a run that is there.
        stop_at: stop with a checkpoint after so many strides, before the end.
        quiet: print nothing.

    Returns:
        The callback, with `history`, whether it `stopped` early and where it `saved_steps`.

    Raises:
        ValueError: settings that will not do, a run that exists, or none to resume.
        KeyboardInterrupt: asked to stop a second time.
    """
    torch.set_num_threads(TORCH_THREADS)
    task_of(settings.env_id, **settings.env_kwargs)  # says what is wrong with them
    env = PoweredWalkerVecEnv(settings.env_id, settings.n_envs, **settings.env_kwargs)
    history: History = []
    draws: dict[str, Any] | None = None
    if resume:
        for part in folder.glob(".*.part*"):  # what a killed process left half written
            part.unlink(missing_ok=True)
        model, history, draws = load_checkpoint(folder / CHECKPOINT, env, settings)
    else:
        model = new_model(settings, env, settings.seeds[0])
        create_run(folder, settings, overwrite=overwrite)
    outputs = ["tensorboard"] if importlib.util.find_spec("tensorboard") is not None else []
    model.set_logger(configure(str(folder), outputs))
    supervisor = Supervisor(settings, folder, history, draws, stop_at, quiet)
    supervisor.num_timesteps = supervisor.saved_steps = model.num_timesteps
    callbacks: list[BaseCallback] = [supervisor]
    if sys.stderr.isatty() and not quiet:
        callbacks.append(ProgressBarCallback())

    def request_stop() -> None:
        supervisor.stop_requested = True

    remaining = settings.n_timesteps - model.num_timesteps
    try:
        with polite_stop(request_stop):
            if remaining > 0:
                model.learn(remaining, CallbackList(callbacks), reset_num_timesteps=not resume)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted; go on from stride {supervisor.saved_steps:,}: {go_on(folder)}"
            if (folder / CHECKPOINT).is_file()
            else "interrupted before the first checkpoint"
        ) from None
    finally:
        model.logger.close()
        env.close()
    return supervisor


def new_model(settings: Settings, env: PoweredWalkerVecEnv, seed: int) -> BaseAlgorithm:
    """An untrained model.

    Raises:
        ValueError: settings that the algorithm does not take.
    """
    kwargs = settings.model_kwargs((env.action_space.shape or (0,))[0])
    policy = kwargs.get("policy_kwargs") or {}
    if policy.get("features_extractor_class") is StrideMetric:  # of these walkers
        matrix = stride_metric(env.envs.task).tolist()
        policy["features_extractor_kwargs"] = {"matrix": matrix}
    try:
        return load_class(settings.algo)(env=env, seed=seed, device="cpu", **kwargs)
    except (AssertionError, TypeError, ValueError, KeyError, RuntimeError) as error:
        raise ValueError(f"{settings.algo} does not take these settings: {error}") from error


def go_on(folder: Path) -> str:
    """The command that goes on with a run, ready to be pasted."""
    words = ["python", "-m", "agents.train", "--resume", "--name", folder.name]
    if folder.parent != RUNS:
        words += ["--runs", str(folder.parent)]
    return shlex.join(words)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.train", description=__doc__)
    result.add_argument("--algo", choices=ALGORITHMS, help=f"(default: {Settings.algo})")
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
        "--steps",
        type=positive_int,
        help="strides in all (default: n_timesteps of the file); with --resume, where to stop "
        "before the end",
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
        "--episodes", type=positive_int, help=f"of an evaluation (default: {Settings.episodes})"
    )
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    settings, folder = _resumed(options) if options.resume else _fresh(options)
    print(f"{settings.algo} on {settings.env_id}, seed {settings.seed}, in {folder}", flush=True)
    began = time.monotonic()
    done = train(
        settings,
        folder,
        resume=options.resume,
        overwrite=options.overwrite,
        stop_at=options.steps if options.resume else None,
    )
    if done.stopped:
        raise KeyboardInterrupt(
            f"stopped at {done.saved_steps:,} of {settings.n_timesteps:,} strides; "
            f"go on: {go_on(folder)}"
        )
    print(f"{done.num_timesteps:,} strides, {time.monotonic() - began:.0f} s")
    print(f"evaluate it: {evaluate_command(folder, settings.env_id, settings.env_kwargs)}")


def _fresh(options: argparse.Namespace) -> tuple[Settings, Path]:
    """Settings and folder of a new run."""
    settings = read_settings(
        options.algo or Settings.algo,
        options.env or ROUND_FOOT,
        options.config,
        env_kwargs=pairs(options.env_kwargs),
        hyperparameters=pairs(options.hyperparams),
        seed=options.seed,
        n_timesteps=options.steps,
        every=options.every,
        episodes=options.episodes,
    )
    env_name = settings.env_id.rpartition(":")[2]
    name = options.name or f"{settings.algo}-{env_name}-{settings.seed}"
    return settings, run_folder(name, options.runs)


def _resumed(options: argparse.Namespace) -> tuple[Settings, Path]:
    """Settings and folder of a run to go on with."""
    if options.name is None:
        raise ValueError("--resume needs the --name of the run")
    fixed = ("algo", "env", "env_kwargs", "config", "hyperparams", "seed", "every", "episodes")
    given = [f"--{name.replace('_', '-')}" for name in fixed if getattr(options, name) is not None]
    if given:
        raise ValueError(f"leave {', '.join(given)} away: a resumed run keeps its settings")
    folder = run_folder(options.name, options.runs)
    settings = read_run(folder)
    if options.steps is not None and options.steps > settings.n_timesteps:
        raise ValueError(
            f"--steps must be at most {settings.n_timesteps} with --resume, got {options.steps}: "
            "the run's schedules end there; train a new run for longer"
        )
    return settings, folder


if __name__ == "__main__":
    sys.exit(exit_status(main))
