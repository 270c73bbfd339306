"""Find good weights for the linear-quadratic regulator, by a random search on seeded episodes.

The regulator is the baseline that learning has to beat: it deserves the same care. The
search uses other episodes than evaluations do.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from agents.command import (
    add_env_arguments,
    exit_status,
    make_walkers,
    natural_int,
    pairs,
    positive_int,
)
from agents.controllers import LQR, lqr_for
from agents.evaluate import evaluate
from powered_walker_env.envs.task import Task

TUNING_SEED = 50_000  # of the episodes, apart from those of trainings and evaluations
LOWEST = -3.0  # decades below the largest state weight: less makes no difference
FIRST_STEP, SMALLEST_STEP = 0.5, 0.1  # decades, of a change of a weight


def search(
    env_id: str, trials: int, episodes: int, seed: int, **env_kwargs: Any
) -> tuple[list[float], float]:
    """The best weights found, four of the state and two of the action, and their mean strides.

    Starts from the weights of `configs/lqr.yml`, changes half of them at random each time
    and keeps what is better.
    """
    task = make_walkers(env_id, 1, **env_kwargs).task

    def score(weights: NDArray[np.float64]) -> float:
        return _strides(task, weights, env_id, episodes, env_kwargs)

    rng, step = np.random.default_rng(seed), FIRST_STEP
    start = lqr_for(env_id, task)
    weights = np.log10(np.maximum([*start.Q.diagonal(), *start.R.diagonal()], 10**LOWEST))
    best = score(weights)
    bar = tqdm(range(trials), unit=" trials", disable=not sys.stderr.isatty())
    for _ in bar:
        change = step * rng.normal(size=6) * (rng.random(6) < 0.5)
        trial = weights + change
        trial = np.maximum(trial - trial[:4].max(), LOWEST)
        strides = score(trial)
        better = strides > best
        if better:
            weights, best = trial, strides
        step = min(1.3 * step, 2 * FIRST_STEP) if better else max(0.97 * step, SMALLEST_STEP)
        bar.set_postfix(strides=f"{best:.1f}")
    return (10**weights).tolist(), best


def _strides(
    task: Task,
    weights: NDArray[np.float64],
    env_id: str,
    episodes: int,
    env_kwargs: dict[str, Any],
) -> float:
    """Mean strides survived with the logarithms of weights; 0 if there is no regulator."""
    costs = (10**weights).tolist()
    try:
        controller = LQR(task, costs[:4], costs[4:])
    except ValueError:
        return 0.0
    return float(evaluate(controller, env_id, episodes, TUNING_SEED, **env_kwargs).strides.mean())


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m agents.tune_lqr", description=__doc__)
    add_env_arguments(parser)
    parser.add_argument("--trials", type=positive_int, default=100, help="(default: %(default)s)")
    parser.add_argument(
        "--episodes", type=positive_int, default=200, help="of each trial (default: %(default)s)"
    )
    parser.add_argument("--seed", type=natural_int, default=0, help="(default: %(default)s)")
    options = parser.parse_args(arguments)
    kwargs = pairs(options.env_kwargs)
    weights, strides = search(options.env, options.trials, options.episodes, options.seed, **kwargs)
    rounded = [float(f"{weight:.2g}") for weight in weights]
    print(f"# {strides:.1f} strides in {options.episodes} episodes")
    print(f"{options.env}:\n  state_cost: {rounded[:4]}\n  action_cost: {rounded[4:]}")


if __name__ == "__main__":
    sys.exit(exit_status(main))
