"""Train a policy by gradients through the walker itself: an analytic policy gradient.

Some walkers walk a few strides under the policy and the environment's pushes, with the exact
derivatives of every stride. The policy then takes many steps down the gradient of what
these walks, and those before, cost to first order (`agents/segments.py`), and the walkers go
on. No value function, no reward, no exploration. Everything goes to `runs/NAME/`.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from agents.algorithms import limit_threads
from agents.command import (
    add_env_arguments,
    exit_status,
    make_walkers,
    natural_int,
    pairs,
    positive_int,
)
from agents.evaluate import evaluate
from agents.learner import Learner, Settings, read_settings
from agents.networks import save_network
from agents.progress import EVALUATION_SEED, History, polite_stop
from agents.runs import (
    EVALUATIONS,
    POLICY,
    RUNS,
    config_text,
    create_folder,
    run_folder,
    write_evaluations,
)
from agents.statistics import mean_estimate

STOPPED = 130  # exit status of a program that Ctrl-C ended
LEARNING_CURVE = 10  # evaluations of a training


def train(
    settings: Settings, folder: Path, *, overwrite: bool = False, quiet: bool = False
) -> tuple[Learner, History]:
    """Train; everything lands in `folder`. Ctrl-C ends it early and keeps what there is.

    Returns:
        The learner, with its policy and strides, and the evaluations on the way.

    Raises:
        UserError: settings that will not do, or a run that exists.
    """
    limit_threads()
    learner = Learner(settings, make_walkers(settings.env_id, 1, **settings.env_kwargs).task)
    create_folder(folder, config_text(settings), settings.seed, overwrite=overwrite)
    history: History = []
    asked: list[bool] = []
    bar = tqdm(
        total=settings.n_timesteps,
        unit=" strides",
        disable=quiet or not sys.stderr.isatty(),
        leave=False,
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
    settings, network = learner.settings, learner.network()
    save_network(network, folder / POLICY)
    if history and history[-1]["steps"] == learner.strides:
        return
    result = evaluate(
        network,
        settings.env_id,
        settings.episodes,
        EVALUATION_SEED + settings.seed,
        **settings.env_kwargs,
    )
    row: dict[str, Any] = {"steps": learner.strides}
    for name, values in (("strides", result.strides), ("return", result.returns)):
        estimate = mean_estimate(values)
        row |= {name: estimate.mean, f"{name}_low": estimate.low, f"{name}_high": estimate.high}
    history.append(row)
    write_evaluations(folder / EVALUATIONS, history)
    if not quiet:
        tqdm.write(
            f"{learner.strides:>9,} strides: {row['strides']:.1f} of {result.limit} survived"
        )


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
    print(f"evaluate it: python -m agents.evaluate open-loop lqr {folder} --env {settings.env_id}")
    if learner.strides + learner.strides_per_update <= settings.n_timesteps:
        print(f"stopped early, of {settings.n_timesteps:,} strides; the policy is what it was then")
        raise SystemExit(STOPPED)


if __name__ == "__main__":
    sys.exit(exit_status(main))
