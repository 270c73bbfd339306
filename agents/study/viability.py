"""How stable can a controlled walker become? The states that any control saves, and each basin.

For each walker: starts in a box where its strides land, 0.1 (0.1 √(g/L) of a rate) to either side
of the gait, and what becomes of them without further pushes. A search through sequences of controls
within the action bounds (`viable_states`) says which can be saved at all; a start is kept by a
controller if it walks 100 strides. The share of a controller's starts among those saved is what it
reaches of the viability kernel. The same over a plane through the gait, to be drawn.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.command import exit_status
from agents.study.asking import answered, parser
from agents.study.loops import landing_plane
from agents.study.viability_figure import kernel_figure
from powered_walker_env import Gait, find_gait
from powered_walker_env.controllers import OpenLoop, load_controller, policy_of
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.shipped import FOLDER
from powered_walker_env.envs.registration import family
from powered_walker_env.envs.task import Task
from powered_walker_env.pictures.charts import save_figure
from powered_walker_env.poincare import StrideMap, viable_states
from powered_walker_env.poincare.regions.slices import box_around

FILE, PICTURE = "viability.json", "viability.png"
STARTS, SEED = 2000, 0
STRIDES = 100  # that a start must walk to count as kept
POINTS = 45  # of the plane along each axis
SEARCH: dict[str, Any] = {"grid": 9, "width": 16, "depth": 12}
#: Where controllers keep starts that all controls of the coarser grid lose.
FINER: dict[str, dict[str, Any]] = {"PoweredWalkerKneed-v0": {"grid": 11}}
Array = NDArray[np.float64]
Marks = NDArray[np.bool_]


def saved_and_kept(env_id: str, policies: Path, starts: int = STARTS, points: int = POINTS,
                   **search: Any) -> dict[str, Any]:  # fmt: skip
    """One walker's kernel, and what of it each controller keeps.

    Args:
        policies: a folder; the network of PPO there joins the comparison, if there is one.
        starts, points: how many, in the box and along each axis of the plane.
        search: of `viable_states`, in place of `SEARCH`.
    """
    began, task = time.process_time(), task_of(env_id)
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    low, high = box_around(gait, gait.states[0])
    inside = landed(gait, np.random.default_rng(SEED).uniform(low, high, (starts, 4)))
    axes = [np.linspace(low[i], high[i], points) for i in (0, 2)]
    plane = np.tile(gait.states[0], (points * points, 1))
    plane[:, 0], plane[:, 2] = (values.ravel() for values in np.meshgrid(*axes))
    names = {"open-loop": OpenLoop(), "lqr": "lqr", "optimal": "optimal"}
    network = policies / f"{family(env_id)}-ppo.npz"
    if network.is_file():
        names["ppo"] = str(network)
    controllers = {name: load_controller(source, task, env_id)[1]
                   for name, source in names.items()}  # fmt: skip
    fates, drawn = (
        _fates(task, gait, states, controllers, {**SEARCH, **FINER.get(env_id, {}), **search})
        for states in (inside, landed(gait, plane))
    )
    return {
        "starts": starts,
        "strides": STRIDES,
        **shares(fates),
        "plane": {
            "stance_angle": [low[0], high[0]], "stance_rate": [low[2], high[2]],
            "points": points, "gait": [gait.states[0][0], gait.states[0][2]],
            **{name: _packed(marks) for name, marks in drawn.items()},
        },
        "seconds": round(time.process_time() - began, 1),
    }  # fmt: skip


def landed(gait: Gait, states: Array) -> Array:
    """Starts (N, 4) moved to where strides land, to first order: s follows from the rest."""
    states = states.copy()
    states[:, 1] = gait.states[0][1] + (states - gait.states[0]) @ landing_plane(gait)
    return states


def shares(fates: dict[str, Marks]) -> dict[str, Any]:
    """Of the starts, and of those that can be saved: bounds, where the search leaves some open.

    Who is kept by any controller is saved, found by the search or not; `refuted` counts those
    that the search, whose controls are those of a grid, had called lost.
    """
    kept = {name: marks for name, marks in fates.items() if name not in ("saved", "lost")}
    saved = np.any([fates["saved"], *kept.values()], axis=0)
    possible = saved | ~fates["lost"]
    return {
        "kernel": [float(saved.mean()), float(possible.mean())],
        "refuted": int((saved & fates["lost"]).sum()),
        "kept": {name: float(marks.mean()) for name, marks in kept.items()},
        "of_kernel": {name: [float(marks.sum() / possible.sum()), float(marks.sum() / saved.sum())]
                      for name, marks in kept.items()},
    }  # fmt: skip


def _fates(
    task: Task, gait: Gait, states: Array, controllers: dict[str, Any], search: dict[str, Any]
) -> dict[str, Marks]:
    found = viable_states(
        gait, task.half_range.tolist(), states, backend="threading", jobs=1, **search
    )
    marks: dict[str, Marks] = {
        "saved": np.asarray(found.saved >= 0), "lost": np.asarray(found.lost >= 0)
    }  # fmt: skip
    for name, controller in controllers.items():
        ends = StrideMap(task.params, policy_of(task, controller))(states, STRIDES)
        marks[name] = np.asarray(np.isfinite(ends).all(axis=1))
    return marks


def _packed(marks: Marks) -> str:
    return "".join("1" if mark else "0" for mark in marks)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    command = parser("viability", __doc__)
    command.add_argument(
        "--policies", type=Path, default=FOLDER,
        help="a folder with trained policies, WALKER-ppo.npz (default: those of the package)",
    )  # fmt: skip
    options = command.parse_args(arguments)
    found = answered(
        options.out, FILE, options.env, lambda env_id: saved_and_kept(env_id, options.policies)
    )
    print(save_figure(kernel_figure(found), options.out / PICTURE))


if __name__ == "__main__":
    sys.exit(exit_status(main))
