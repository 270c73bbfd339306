"""The viability kernels in a plane through the gait, and the basins inside them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from powered_walker_env.envs.registration import family
from powered_walker_env.pictures.charts import Drawing
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    INK,
    PALE,
    WIDTH,
    label_of,
    styled,
)

KERNEL, OPEN = "#bcdcc2", "#f3e3b8"
CONTROLLERS = {"open-loop": "open loop", "lqr": "LQR", "ppo": "PPO",
               "optimal": "optimum, or best known"}  # fmt: skip
FATES = {"falls under all controls tried": PALE, "left open by the search": OPEN,
         "some control saves it": KERNEL, "the controller keeps it": BLUE}  # fmt: skip


@styled
def kernel_figure(answers: dict[str, dict[str, Any]]) -> Drawing:
    """A row for each walker, a panel for each controller: what can be saved, and what it keeps.

    Args:
        answers: of `agents.study.viability`, by the id.
    """
    figure = Figure(figsize=(WIDTH + 2.2, 2.0 * len(answers) + 0.9), layout="constrained")
    first = next(iter(answers))
    panels = figure.subplots(len(answers), len(CONTROLLERS), squeeze=False, sharey="row")
    for line, (env_id, answer) in zip(panels, answers.items(), strict=True):
        for axes, (name, label) in zip(line, CONTROLLERS.items(), strict=True):
            axes.tick_params(labelsize=7.5)
            axes.grid(visible=False)
            if name in answer["kept"]:
                _panel(axes, answer, name)
            axes.set_title(label if env_id == first else "")
        line[0].set_ylabel(family(env_id).replace("Walker", "Walker\n"), fontsize=8.5)
    for axes in panels[-1]:
        axes.set_xlabel(label_of("stance_angle"), fontsize=9)
    figure.supylabel(label_of("stance_rate"), fontsize=9)
    handles: list[Patch | Line2D] = [
        *(Patch(color=colour, label=label) for label, colour in FATES.items()),
        Line2D([], [], marker="o", color="white", markeredgecolor=INK, ls="", label="the gait"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    columns = {"walker": list(answers), "kernel": [each["kernel"][0] for each in answers.values()]}
    return Drawing(figure, columns)


def _panel(axes: Axes, answer: dict[str, Any], name: str) -> None:
    plane = answer["plane"]
    every = [marks_of(plane, each) for each in answer["kept"]]
    saved = np.any([marks_of(plane, "saved"), *every], axis=0)
    fate = np.where(saved, 2, np.where(marks_of(plane, "lost"), 0, 1))
    fate[marks_of(plane, name)] = 3
    axes.imshow(
        fate, origin="lower", aspect="auto", interpolation="nearest", vmin=0, vmax=3,
        extent=(*plane["stance_angle"], *plane["stance_rate"]),
        cmap=ListedColormap(list(FATES.values())),
    )  # fmt: skip
    axes.plot(*plane["gait"], "o", color="white", markeredgecolor=INK, markersize=4)


def marks_of(plane: dict[str, Any], name: str) -> NDArray[np.bool_]:
    """(rates, angles) of a set that was kept as a text of 0 and 1."""
    marks: NDArray[np.bool_] = np.frombuffer(plane[name].encode(), np.uint8) == ord("1")
    return marks.reshape(plane["points"], plane["points"])
