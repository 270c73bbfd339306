"""Train a policy by gradients through the walker itself: an analytic policy gradient.

Some walkers walk a few strides under the policy and the environment's pushes, with the exact
derivatives of every stride. The policy then takes many steps down the gradient of what
these walks, and those before, cost to first order (`segments`), and the walkers go
on. No value function, no reward, no exploration. Everything goes to `runs/NAME/`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import torch
from tqdm import tqdm

from agents.command import (
    add_env_arguments,
    exit_status,
    natural_int,
    pairs,
    polite_stop,
    positive_int,
)
from agents.configuration import EVALUATIONS as LEARNING_CURVE
from agents.configuration import study_seeds
from agents.learner import Learner, Settings, read_settings
from agents.runs import (
    EVALUATIONS,
    RUNS,
    History,
    create_run,
    evaluate_command,
    evaluation_row,
    run_folder,
    write_evaluations,
)
from agents.train import TORCH_THREADS
from powered_walker_env.controllers import evaluate, save_network
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import POLICY


def train(
    settings: Settings, folder: Path, *, overwrite: bool = False, quiet: bool = False
) -> tuple[Learner, History]:
    """Train; everything lands in `folder`. Ctrl-C ends it early and keeps what there is.

    Returns:
        The learner, with its policy and strides, and the evaluations on the way.

    Raises:
        ValueError: settings that will not do, or a run that exists.
    """
    torch.set_num_threads(TORCH_THREADS)
    learner = Learner(settings, task_of(settings.env_id, **settings.env_kwargs))
    create_run(folder, settings, overwrite=overwrite)
    history: History = []
    asked: list[bool] = []
    bar = tqdm(
        total=settings.n_timesteps, unit=" strides", disable=True if quiet else None, leave=False
    )
    every = settings.n_timesteps / LEARNING_CURVE
    with bar, polite_stop(lambda: asked.append(True)):
        _note(learner, history, folder, quiet)
        while learner.strides + learner.strides_per_update <= settings.n_timesteps and not asked:
            learner.update()
            bar.update(learner.strides - bar.n)
            if learner.strides >= every * len(history) and len(history) < LEARNING_CURVE:
                _note(learner, history, folder, quiet)
        _note(learner, history, folder, quiet)
    return learner, history


def _note(learner: Learner, history: History, folder: Path, quiet: bool) -> None:
    """Evaluate, save the policy, and say so. Evaluations teach nothing and choose nothing."""
    run, network = learner.settings, learner.network()
    save_network(network, folder / POLICY)
    if history and history[-1]["steps"] == learner.strides:
        return
    seed = study_seeds(run.seed)[1]
    result = evaluate(network, run.env_id, run.episodes, seed, **run.env_kwargs)
    history.append(evaluation_row(learner.strides, result))
    write_evaluations(folder / EVALUATIONS, history)
    if not quiet:
        strides = result.mean_strides.mean
        tqdm.write(f"{learner.strides:>9,} strides: {strides:.1f} of {result.limit} survived")


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.analytic_gradient", description=__doc__)
    add_env_arguments(result)
    result.add_argument("--name", help="of the run (default: apg-ENV-SEED)")
    result.add_argument("--seed", type=natural_int, default=0, help="(default: %(default)s)")
    result.add_argument(
        "--steps",
        type=positive_int,
        help="strides in all (default: n_timesteps of configs/apg.yml)",
    )
    result.add_argument(
        "--hyperparams", nargs="+", metavar="KEY:VALUE", help="in place of those of configs/apg.yml"
    )
    result.add_argument("--runs", type=Path, default=RUNS, help="where runs go (default: runs)")
    result.add_argument("--overwrite", action="store_true", help="replace the run NAME")
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    changes = pairs(options.hyperparams)
    if options.steps is not None:
        changes["n_timesteps"] = options.steps
    settings = read_settings(
        options.env, changes, seed=options.seed, env_kwargs=pairs(options.env_kwargs)
    )
    name = options.name or f"apg-{settings.env_id.rpartition(':')[2]}-{settings.seed}"
    folder = run_folder(name, options.runs)
    print(f"analytic gradient on {settings.env_id}, seed {settings.seed}, in {folder}")
    began = time.monotonic()
    learner, _ = train(settings, folder, overwrite=options.overwrite)
    print(
        f"{learner.strides:,} strides, all of them differentiated, {learner.falls} falls, "
        f"{time.monotonic() - began:.0f} s"
    )
    print(f"evaluate it: {evaluate_command(folder, settings.env_id, settings.env_kwargs)}")
    if learner.strides + learner.strides_per_update <= settings.n_timesteps:
        raise KeyboardInterrupt(
            f"stopped early, of {settings.n_timesteps:,} strides; the policy is what it was then"
        )


if __name__ == "__main__":
    sys.exit(exit_status(main))
