"""The main job: train PPO on the round-foot walker and show what it has learnt.

Open loop, LQR and PPO then meet the same pushes; a table, two plots and an animation of
them are saved next to the training. It takes about half a minute on two cores.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import shlex
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.command import (
    ROUND_FOOT,
    add_env_arguments,
    exit_status,
    natural_int,
    pairs,
    positive_int,
)
from powered_walker_env import Disturbance
from powered_walker_env.controllers import (
    EPISODE_SEED,
    Controller,
    Evaluation,
    comparison,
    comparison_text,
    evaluate,
    load_controller,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import LQR_NAME, OPEN_LOOP, POLICY
from powered_walker_env.envs.task import Task
from powered_walker_env.files import write_text
from powered_walker_env.model.quantities import quantities

DEFAULT_OUT = Path("runs") / "quickstart"
EPISODES = 200
SHOWN_STRIDES = 30  # of the plot of a walk
FILM_STRIDES, AFTERWARDS = 12, 3  # most of the animation; after the fall of the open loop
RESULTS, TABLE = "results.json", "results.txt"
CURVE, WALK, FILM = "learning_curve.png", "walk.png", "walk.gif"


def run(
    folder: Path,
    *,
    env_id: str = ROUND_FOOT,
    env_kwargs: Mapping[str, Any] | None = None,
    seed: int = 0,
    steps: int | None = None,
    episodes: int = EPISODES,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Train, evaluate, draw; everything lands in `folder`.

    Returns:
        The comparison, as in `results.json`.

    Raises:
        ValueError: the folder exists, or the environment does not.
        KeyboardInterrupt: stopped while training; a checkpoint is saved.
    """
    # What needs torch is imported here: --help answers at once.
    from agents.configuration import read_settings
    from agents.runs import write_json
    from agents.train import go_on, train

    _check_packages()
    kwargs = dict(env_kwargs or {})
    settings = read_settings("ppo", env_id, seed=seed, n_timesteps=steps, env_kwargs=kwargs)
    print(f"1. training PPO on {env_id}: {settings.n_timesteps:,} strides", flush=True)
    done = train(settings, folder, overwrite=overwrite)
    if done.stopped:
        raise KeyboardInterrupt(
            f"stopped; what there is so far is in {shlex.quote(str(folder))}. To go on with the "
            f"training: {go_on(folder)}"
        )
    print(f"2. evaluation: {episodes} episodes each", flush=True)
    task = task_of(env_id, **kwargs)
    controllers = {
        name: load_controller(source, task)[1]
        for name, source in (
            ("open loop", OPEN_LOOP), ("LQR", LQR_NAME), ("PPO", folder / POLICY),
        )
    }  # fmt: skip
    evaluations = {
        name: evaluate(controller, env_id, episodes, EPISODE_SEED, **kwargs)
        for name, controller in controllers.items()
    }
    result = comparison(evaluations)
    text = comparison_text(evaluations, f"{env_id}, {met(evaluations['PPO'])}")
    write_json(folder / RESULTS, result)
    write_text(folder / TABLE, text)
    print(f"\n{text}")
    print("3. pictures", flush=True)
    _draw_curve(folder, done.history, result, seed)
    _draw_walks(folder, controllers, evaluations, task)
    return result


def _check_packages() -> None:
    """Say now what the pictures at the end would lack."""
    missing = [name for name in ("PIL", "pygame") if importlib.util.find_spec(name) is None]
    if missing:
        raise ImportError(
            f"the animation needs {' and '.join(missing)}, not installed; "
            'in the repository: pip install -e ".[train,render]"'
        )


def met(walks: Evaluation) -> str:
    """What the walkers meet, for titles: `push 0.02 rad/s`."""
    known = quantities(Disturbance)
    units = {kind: known[kind].unit if kind in known else "" for kind in walks.disturbance}
    sizes = [f"{kind} {size:g} {units[kind]}".strip() for kind, size in walks.disturbance.items()]
    return ", ".join(sizes) or "undisturbed"


def _draw_curve(
    folder: Path, history: Sequence[Mapping[str, float]], result: Mapping[str, Any], seed: int
) -> None:
    from powered_walker_env.pictures.charts import learning_curve, save_figure

    columns = ("steps", "strides", "strides_low", "strides_high")
    baselines = {
        name: entry["strides"]["mean"]
        for name, entry in result["controllers"].items()
        if name != "PPO"
    }
    figure = learning_curve(
        *([row[column] for row in history] for column in columns),
        baselines=baselines,
        limit=result["stride_limit"],
        title=f"PPO learns to walk: {result['env']}, seed {seed}",
    )
    save_figure(figure, folder / CURVE)


def _draw_walks(
    folder: Path,
    controllers: Mapping[str, Controller],
    evaluations: Mapping[str, Evaluation],
    task: Task,
) -> None:
    """One episode of open loop and PPO, in the state space and as an animation."""
    from agents.recording import nominal_stride, record
    from powered_walker_env.pictures.charts import disturbed_walks, save_figure
    from powered_walker_env.pictures.film import save_side_by_side

    baseline = evaluations["open loop"]
    strides = baseline.strides
    episode = typical_episode(strides, evaluations["PPO"].strides)
    seed, falls = EPISODE_SEED + episode, int(strides[episode]) + 1

    def walks(count: int) -> dict[str, Any]:
        return {
            name: record(controllers[name], baseline.env_id, seed, count, **baseline.env_kwargs)
            for name in ("open loop", "PPO")
        }

    title = f"Two controllers, the same disturbances ({met(baseline)}, episode {seed})"
    shown = walks(max(SHOWN_STRIDES, falls))
    figure = disturbed_walks(shown, nominal_stride(task), title=title)
    save_figure(figure, folder / WALK)
    save_side_by_side(walks(min(falls + AFTERWARDS, FILM_STRIDES)), folder / FILM)


def typical_episode(strides: NDArray[np.int64], others: NDArray[np.int64]) -> int:
    """The episode to show: of median length, where the other controller walks longest."""
    from_median = np.abs(strides - np.median(strides))
    return int(np.lexsort((from_median, -others))[0])


def free_folder(wanted: Path) -> Path:
    """`wanted`, or `wanted-2`, `wanted-3`, ...: the first that does not exist."""
    if not wanted.exists():
        return wanted
    names = (wanted.with_name(f"{wanted.name}-{i}") for i in itertools.count(2))
    return next(folder for folder in names if not folder.exists())


def parser() -> argparse.ArgumentParser:
    """The command line."""
    result = argparse.ArgumentParser(prog="python -m agents.quickstart", description=__doc__)
    result.add_argument(
        "--out",
        type=Path,
        help=f"folder to make (default: {DEFAULT_OUT}, or {DEFAULT_OUT}-2, ... if it exists)",
    )
    result.add_argument("--overwrite", action="store_true", help="replace the folder if it exists")
    add_env_arguments(result)
    result.add_argument(
        "--seed", type=natural_int, default=0, help="of the training (default: %(default)s)"
    )
    result.add_argument(
        "--steps", type=positive_int, help="strides of training (default: configs/ppo.yml)"
    )
    result.add_argument(
        "--episodes", type=positive_int, default=EPISODES, help="of each (default: %(default)s)"
    )
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    options = parser().parse_args(arguments)
    folder = options.out or (DEFAULT_OUT if options.overwrite else free_folder(DEFAULT_OUT))
    began = time.monotonic()
    run(
        folder,
        env_id=options.env,
        env_kwargs=pairs(options.env_kwargs),
        seed=options.seed,
        steps=options.steps,
        episodes=options.episodes,
        overwrite=options.overwrite,
    )
    print(f"done in {time.monotonic() - began:.0f} s; in {folder}:")
    for name, meaning in (
        (TABLE, "the table above"),
        (RESULTS, "its numbers, and those of every episode"),
        (CURVE, "how PPO learnt"),
        (WALK, "one walk of open loop and PPO in the state space"),
        (FILM, "the same walk, moving"),
        (POLICY, "the policy: plain numbers, for agents.evaluate and the gait laboratory"),
        ("best_model.zip", "the same as a model of Stable-Baselines3"),
    ):
        print(f"  {folder / name}  ({meaning})")


if __name__ == "__main__":
    sys.exit(exit_status(main))
