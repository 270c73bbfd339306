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

from agents.command import add_env_arguments, exit_status, natural_int, pairs, positive_int
from powered_walker_env.controllers import LQR, evaluate
from powered_walker_env.controllers.evaluation import task_of

TUNING_SEED = 50_000  # of the episodes, apart from those of trainings and evaluations
LOWEST = -3.0  # decades below the largest state weight: less makes no difference
FIRST_STEP, SMALLEST_STEP = 0.5, 0.1  # decades, of a change of a weight


def search(
    env_id: str, trials: int, episodes: int, seed: int, **env_kwargs: Any
) -> tuple[list[float], float]:
    """The best weights found, four of the state and k of the action, and their mean strides.

    Starts from the weights that the regulator has, changes half of them at random each time
    and keeps what is better.
    """
    task = task_of(env_id, **env_kwargs)

    def score(weights: NDArray[np.float64]) -> float:
        """Mean strides survived with the logarithms of weights; 0 if there is no regulator."""
        costs = (10**weights).tolist()
        try:
            controller = LQR(task, costs[:4], costs[4:])
        except ValueError:
            return 0.0
        walks = evaluate(controller, env_id, episodes, TUNING_SEED, **env_kwargs)
        return float(walks.strides.mean())

    start, rng, step = LQR(task), np.random.default_rng(seed), FIRST_STEP
    known = [np.broadcast_to(start.state_cost, 4),
             np.broadcast_to(start.action_cost, len(task.nominal))]  # fmt: skip
    weights = np.log10(np.maximum(np.concatenate(known), 10**LOWEST))
    best = score(weights)
    bar = tqdm(range(trials), unit=" trials", disable=None)
    for _ in bar:
        change = step * rng.normal(size=len(weights)) * (rng.random(len(weights)) < 0.5)
        trial = weights + change
        trial = np.maximum(trial - trial[:4].max(), LOWEST)
        strides = score(trial)
        better = strides > best
        if better:
            weights, best = trial, strides
        step = min(1.3 * step, 2 * FIRST_STEP) if better else max(0.97 * step, SMALLEST_STEP)
        bar.set_postfix(strides=f"{best:.1f}")
    return (10**weights).tolist(), best


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
    print(f"# {options.env}: {strides:.1f} strides in {options.episodes} episodes")
    print(f"LQR(task, state_cost={rounded[:4]}, action_cost={rounded[4:]})")


if __name__ == "__main__":
    sys.exit(exit_status(main))
