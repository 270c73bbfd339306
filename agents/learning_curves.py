"""Draw how several trainings of one environment learnt, beside open loop and LQR.

After trainings of some seeds, `python -m agents.train --env PoweredWalkerKneed-v0 --seed 3 --name
kneed-3` and so on:

    python -m agents.learning_curves runs/kneed-* --out docs/learning-kneed.png
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.command import exit_status, positive_int, read_yaml
from agents.runs import CONFIG, EVALUATIONS
from powered_walker_env.controllers import evaluate, load_controller
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.loading import LQR_NAME, OPEN_LOOP
from powered_walker_env.files import check_writable

EPISODES = 2000
_SAME = ("algo", "env_id", "env_kwargs")  # of runs in one picture


def read_curve(folder: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Strides trained and strides survived (n,) at the evaluations of a run.

    Raises:
        ValueError: no such file, or not one of a training's.
    """
    path = folder / EVALUATIONS
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = [(float(row["steps"]), float(row["strides"])) for row in csv.DictReader(file)]
        steps, strides = np.array(rows, np.float64).T
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{str(path)!r} holds no evaluations of a training: {error}") from error
    return steps, strides


def draw(folders: Sequence[Path], out: Path, episodes: int = EPISODES) -> dict[str, float]:
    """Draw the learning curves of some runs.

    Args:
        folders: of trainings by one algorithm in one environment, evaluated at equal times.
        episodes: on which the baselines are measured.

    Returns:
        Strides survived by each baseline.

    Raises:
        ValueError: a folder that is no run, or runs of different things.
    """
    from powered_walker_env.pictures.charts import learning_curves, save_figure

    settings: list[dict[str, Any]] = []
    for folder in folders:
        found = read_yaml(folder / CONFIG)
        if not isinstance(found, dict) or not {"env_id", "env_kwargs"} <= found.keys():
            raise ValueError(f"{str(folder)!r} must be the folder of a training")
        settings.append({name: found.get(name) for name in _SAME})
    curves = [read_curve(folder) for folder in folders]
    first, steps = settings[0], curves[0][0]
    for folder, setting, curve in zip(folders, settings, curves, strict=True):
        if setting != first or not np.array_equal(curve[0], steps):
            raise ValueError(
                f"the runs must be of one algorithm and environment, evaluated at equal times; "
                f"{str(folder)!r} differs from {str(folders[0])!r}"
            )
    env_id, kwargs = first["env_id"], first["env_kwargs"]
    walks = {}
    for word in (OPEN_LOOP, LQR_NAME):
        name, controller = load_controller(word, task_of(env_id, **kwargs))
        walks[name] = evaluate(controller, env_id, episodes, **kwargs)
    baselines = {name: found.mean_strides.mean for name, found in walks.items()}
    drawing = learning_curves(
        steps,
        {folder.name: curve[1] for folder, curve in zip(folders, curves, strict=True)},
        baselines=baselines,
        limit=next(iter(walks.values())).limit,
        title=f"{str(first['algo'] or 'a policy').upper()} learns to walk: {env_id}",
    )
    save_figure(drawing, out)
    return baselines


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(
        prog="python -m agents.learning_curves", description=(__doc__ or "").split("\n\n")[0]
    )
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="folder of a training")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="the picture")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE if it exists")
    parser.add_argument(
        "--episodes",
        type=positive_int,
        default=EPISODES,
        help="of each baseline (default: %(default)s)",
    )
    options = parser.parse_args(arguments)
    check_writable([options.out], options.overwrite)
    baselines = draw(options.runs, options.out, options.episodes)
    for name, strides in baselines.items():
        print(f"{name}: {strides:.1f} strides in {options.episodes} episodes")
    print(options.out)


if __name__ == "__main__":
    sys.exit(exit_status(main))
