"""Evaluate controllers and saved models on equal disturbances.

Episode i of every controller has the same seed, so all meet the same pushes; they differ
by what they make of them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.command import (
    EPISODE_SEED,
    UserError,
    add_env_arguments,
    exit_status,
    make_walkers,
    natural_int,
    pairs,
    positive_int,
)
from agents.controllers import LQR_NAME, OPEN_LOOP, Controller, make_controller
from powered_walker_env import Outcome

WALKED = int(Outcome.WALKED)


@dataclass(frozen=True, eq=False)
class Evaluation:
    """What became of a controller's episodes, seeded `seed`, `seed + 1`, ..."""

    env_id: str
    env_kwargs: Mapping[str, Any]
    seed: int
    limit: int  # strides after which an episode is over
    strides: NDArray[np.int64]  # (episodes,) strides completed
    returns: NDArray[np.float64]  # (episodes,)
    outcomes: NDArray[np.int64]  # (episodes,) `Outcome` of the last stride

    @property
    def survived(self) -> int:
        """Episodes that lasted to the limit."""
        return int((self.outcomes == WALKED).sum())

    def ends(self) -> dict[str, int]:
        """How the episodes ended, by the outcome's label, the most frequent first."""
        kinds, counts = np.unique(self.outcomes, return_counts=True)
        order = np.argsort(-counts, kind="stable")
        return {Outcome(int(kinds[i])).label: int(counts[i]) for i in order}


def evaluate(
    controller: Controller,
    env_id: str,
    episodes: int = 100,
    seed: int = EPISODE_SEED,
    **env_kwargs: Any,
) -> Evaluation:
    """Let a controller walk episodes, all at once; episode i has the seed `seed + i`.

    Args:
        controller: its `predict` is asked for deterministic actions.
        env_id: a registered environment of this package's class.
        **env_kwargs: arguments of the environment.

    Raises:
        UserError: an environment or arguments that do not exist.
        ValueError: a controller whose actions have a wrong shape or are not finite.
    """
    envs = make_walkers(env_id, episodes, **env_kwargs)
    limit = envs.max_episode_steps
    if limit is None:
        raise UserError(f"environment {env_id!r} has no max_episode_steps: episodes never end")
    observation, _ = envs.reset(seed=seed)
    memory, fresh = None, np.ones(episodes, np.bool_)
    strides, returns = np.zeros(episodes, np.int64), np.zeros(episodes)
    outcomes = np.full(episodes, WALKED)
    going = np.ones(episodes, np.bool_)
    for _ in range(limit):
        actions, memory = controller.predict(observation, memory, fresh, deterministic=True)
        # Those that fell are left out: they neither draw nor move.
        wanted = _checked(actions, envs.action_space.shape)
        result = envs.walkers.step(wanted, None if going.all() else going)
        observation = result.observation
        strides += going & ~result.terminated
        returns[going] += result.reward[going]
        outcomes[going] = result.info["outcome"][going]
        going &= ~result.terminated
        fresh = np.zeros(episodes, np.bool_)
        if not going.any():
            break
    return Evaluation(env_id, dict(env_kwargs), seed, limit, strides, returns, outcomes)


def _checked(actions: Any, shape: tuple[int, ...] | None) -> NDArray[np.float64]:
    checked = np.asarray(actions, np.float64)
    if checked.shape != shape or not np.isfinite(checked).all():
        raise ValueError(
            f"a controller must give {shape} finite actions, got shape {checked.shape}"
        )
    return checked


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.evaluate", description=__doc__)
    result.add_argument(
        "controllers",
        nargs="+",
        metavar="CONTROLLER",
        help=f"{OPEN_LOOP}, {LQR_NAME}, a saved model (.zip) or a run folder; "
        "the others are compared with the first",
    )
    add_env_arguments(result)
    result.add_argument(
        "--disturbance",
        nargs="+",
        metavar="LEVEL",
        help="levels: none, light, rough, light-ground, ... (default: light)",
    )
    result.add_argument(
        "--episodes", type=positive_int, default=200, help="of each (default: %(default)s)"
    )
    result.add_argument(
        "--seed",
        type=natural_int,
        default=EPISODE_SEED,
        help="of the first episode (default: %(default)s, none of a training's)",
    )
    result.add_argument("--out", type=Path, metavar="FILE", help="write the results there as JSON")
    result.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    from agents.runs import write_json  # after --help: torch takes its time
    from agents.tables import comparison, print_comparison

    options = parser().parse_args(arguments)
    if options.out is not None:
        check_target(options.out, options.overwrite)
    env_kwargs = pairs(options.env_kwargs)
    if options.disturbance and "disturbance" in env_kwargs:
        raise UserError("give the disturbance by --disturbance or --env-kwargs, not by both")
    levels = options.disturbance or [env_kwargs.pop("disturbance", "light")]
    results = []
    for level in levels:
        kwargs = env_kwargs | {"disturbance": level}
        task = make_walkers(options.env, 1, **kwargs).task
        evaluations = {}
        for text in options.controllers:
            name, controller = make_controller(text, task, options.env)
            if name in evaluations:
                name = f"{name} ({text})"
            evaluations[name] = evaluate(
                controller, options.env, options.episodes, options.seed, **kwargs
            )
        print_comparison(evaluations, title=f"{options.env}, disturbance {level}")
        results.append(comparison(evaluations))
    if options.out is not None:
        write_json(options.out, results)
        print(f"results: {options.out}")


def check_target(path: Path, overwrite: bool) -> None:
    """Say now what would prevent writing a file later.

    Raises:
        UserError: it exists, or its folder does not.
    """
    if path.exists() and not overwrite:
        raise UserError(f"{str(path)!r} exists; choose another file, or replace it by --overwrite")
    if not path.parent.is_dir():
        raise UserError(f"the folder {str(path.parent)!r} does not exist; make it first")


if __name__ == "__main__":
    sys.exit(exit_status(main))
