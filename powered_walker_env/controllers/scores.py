"""Normalised scores: 0 is the open loop, 1 the best that any controller can do.

As those of Atari (Mnih et al. 2015, human-normalised) and D4RL (Fu et al. 2020), but between a
baseline and the optimum, which is known here: (R − R_open loop)/(R_optimum − R_open loop), R the
mean return of the same episodes. Above 1 by more than its interval means that the optimum is none.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from powered_walker_env.controllers.controller import OpenLoop
from powered_walker_env.controllers.estimates import RESAMPLES, Estimate
from powered_walker_env.controllers.evaluation import EPISODE_SEED, Evaluation, evaluate, walkers_of
from powered_walker_env.controllers.optimal import OPTIMUM_NAME, Optimal
from powered_walker_env.poincare import Optimum

OPEN_LOOP_NAME = "open loop"  # in tables
BLOCK = 1000  # resamples at once


def normalised_score(item: Evaluation, open_loop: Evaluation, optimum: Evaluation) -> Estimate:
    """The score of an evaluation, its interval by bootstrap over the episodes, all three together.

    Args:
        item, open_loop, optimum: evaluations of the same episodes.

    Raises:
        ValueError: of other episodes, or an optimum that is no better than the open loop.
    """
    for other in (open_loop, optimum):
        if (other.env_id, other.seed, len(other.returns)) != (
            item.env_id, item.seed, len(item.returns),
        ):  # fmt: skip
            raise ValueError(
                f"evaluations must be of the same episodes, got {item.env_id} from seed "
                f"{item.seed} and {other.env_id} from seed {other.seed}"
            )
    columns = np.array([item.returns, open_loop.returns, optimum.returns])
    value, low, best = columns.mean(axis=1)
    if not best > low:
        raise ValueError(
            f"optimum must be better than the open loop, got returns of {best:.4g} and {low:.4g}"
        )
    rng, count = np.random.default_rng(0), columns.shape[1]
    drawn = []
    for _ in range(0, RESAMPLES, BLOCK):
        rows = rng.integers(count, size=(BLOCK, count))
        own, base, top = columns[:, rows].mean(axis=2)
        drawn.append((own - base) / np.where(top > base, top - base, np.nan))
    bounds = np.nanpercentile(np.concatenate(drawn), [2.5, 97.5])
    return Estimate(float((value - low) / (best - low)), float(bounds[0]), float(bounds[1]))


def benchmark_score(
    controller: Any,
    env: str,
    episodes: int = 200,
    seed: int = EPISODE_SEED,
    *,
    optimum: Optimum | None = None,
    **env_kwargs: Any,
) -> Estimate:
    """The normalised score of a controller at an environment: 0 open loop, 1 optimum.

    Args:
        controller: as `evaluate` takes it.
        env: an id.
        episodes, seed: the same for all three.
        optimum: of the environment's task (`find_optimum`); left out, the one shipped for it.
        **env_kwargs: arguments of the environment.

    Raises:
        ValueError: an environment whose optimum is not known, or as `evaluate`.
    """
    task = walkers_of(env, 1, **env_kwargs)[0].task
    best = Optimal(task, optimum)
    if optimum is None and best.name != OPTIMUM_NAME:
        raise ValueError(
            f"env must have a known optimum for a score, got {env!r} with {best.found!r}: give "
            "that as optimum to have the share of the best known"
        )
    walks = [
        evaluate(each, env, episodes, seed, **env_kwargs)
        for each in (controller, OpenLoop(len(task.nominal)), best)
    ]
    return normalised_score(*walks)
