"""Measured by walking: paired episodes, pushes of other sizes, walks without a limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.stats

from agents.study.subject import Subject
from powered_walker_env.controllers import EPISODE_SEED, OpenLoop, Optimal, evaluate
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.optimal import noise_of
from powered_walker_env.poincare import disturbed_walks, first_passage

#: Pushes, by those of the level "light".
SWEEP = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
WALKS_SEED = 70_000  # of the walks without a limit; none of a training's or an evaluation's


def episodes(subject: Subject) -> dict[str, Any]:
    """Episodes seeded from `EPISODE_SEED` on: the same pushes for every cell of its level."""
    cell, count = subject.cell, subject.budget.episodes
    found = evaluate(subject.controller, cell.env_id, count, EPISODE_SEED, **subject.env_kwargs)
    return {
        "limit": found.limit,
        "survived": found.survived / count,
        "ends": found.ends(),
        "strides": found.strides.tolist(),
        "returns": found.returns.tolist(),
    }


def sweep(subject: Subject) -> dict[str, Any]:
    """Strides survived under pushes of other sizes than it was made for."""
    cell, light = subject.cell, task_of(subject.cell.env_id, disturbance="light").disturbance.push
    rows = []
    for factor in SWEEP:
        found = evaluate(
            subject.controller, cell.env_id, subject.budget.sweep_episodes, EPISODE_SEED,
            disturbance={"push": factor * light},
        )  # fmt: skip
        rows.append([factor * light, float(found.strides.mean()), float(found.returns.mean())])
    push, strides, returns = np.array(rows).T.tolist()
    return {"push": push, "strides": strides, "returns": returns}


def passage(subject: Subject) -> dict[str, Any]:
    """The mean first passage time to a fall: strides walked in all, by falls.

    Walks that have forgotten their start fall at a constant rate at every stride, so those that
    the limit cuts off count with what they walked; the interval is the exact one of a rate (chi
    squared). Without a fall there is a lower bound alone.
    """
    budget, task = subject.budget, subject.task
    found = disturbed_walks(
        task.params, subject.policy, noise_of(task), task.gait[0].tolist(),
        strides=budget.limit, walks=budget.walks, seed=WALKS_SEED,
    )  # fmt: skip
    total, falls = int(found.strides.sum()), int(found.fell.sum())
    rate, error = found.fall_rate()
    return {
        "limit": budget.limit,
        "walks": budget.walks,
        "strides": total,
        "falls": falls,
        "mean": total / falls if falls else None,
        "low": 2.0 * total / float(scipy.stats.chi2.ppf(0.975, 2 * falls + 2)),
        "high": 2.0 * total / float(scipy.stats.chi2.ppf(0.025, 2 * falls)) if falls else None,
        "second_eigenvalue": None if np.isnan(rate) else 1.0 - rate,
        "second_eigenvalue_error": None if np.isnan(error) else error,
    }


def table_passage(subject: Subject) -> dict[str, Any]:
    """The same by the law of a step on the section: for policies that live on it.

    Raises:
        ValueError: another controller: it decides by the state at heel strike, of which the
            section forgets one number.
    """
    task, controller = subject.task, subject.controller
    if isinstance(controller, OpenLoop):
        control: Any = task.control
    elif isinstance(controller, Optimal):
        control = controller.policy
    else:
        raise ValueError(
            "controller must decide by the section's three numbers for a table of first passages, "
            f"got {type(controller).__name__}, which sees four; its walks have the time"
        )
    found = first_passage(
        task.params, control, noise_of(task), task.gait[0].tolist(), shape=subject.budget.nodes,
        walks=max(subject.budget.walks, 400), limit=min(subject.budget.limit, 1000), branches=17,
        push_points=7,
    )  # fmt: skip
    return {
        "second_eigenvalue": found.second_eigenvalue,
        "second_eigenvalue_error": found.eigenvalue_error,
        "mean": found.mean_strides,
        "mean_error": found.strides_error,
    }
