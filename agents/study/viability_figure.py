"""The viability kernels in a plane through the gait, and the basins inside them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from powered_walker_env.pictures.charts import Drawing
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    INK,
    ORANGE,
    PALE,
    RED,
    VIOLET,
    WIDTH,
    label_of,
    styled,
)

KERNEL, OPEN = "#cfe3d2", "#f3ead2"
#: From the outermost to the innermost, as a rule.
BASINS = {"optimal": ("the optimum, or the best known", BLUE), "ppo": ("PPO", VIOLET),
          "lqr": ("LQR", ORANGE), "open-loop": ("open loop", RED)}  # fmt: skip


@styled
def kernel_figure(answers: dict[str, dict[str, Any]]) -> Drawing:
    """A panel for each walker: what is saved, and what each controller keeps of it.

    Args:
        answers: of `agents.study.viability`, by the id.
    """
    rows = math.ceil(len(answers) / 2)
    figure = Figure(figsize=(WIDTH + 1.0, 3.0 * rows + 0.7), layout="constrained")
    panels = figure.subplots(rows, 2, squeeze=False).ravel()
    for axes, (env_id, answer) in zip(panels, answers.items(), strict=False):
        _panel(axes, answer)
        axes.set_title(env_id.removesuffix("-v0"))
    for axes in panels[len(answers) :]:
        axes.set_axis_off()
    shown = {name for answer in answers.values() for name in answer["kept"]}
    handles: list[Patch | Line2D] = [
        Patch(color=KERNEL, label="some control saves it"),
        Patch(color=OPEN, label="left open by the search"),
        Patch(color=PALE, label="falls, whatever is done"),
        *(Line2D([], [], color=colour, label=f"kept by {label}")
          for name, (label, colour) in BASINS.items() if name in shown),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    columns = {"walker": list(answers), "kernel": [each["kernel"][0] for each in answers.values()]}
    return Drawing(figure, columns)


def _panel(axes: Axes, answer: dict[str, Any]) -> None:
    plane = answer["plane"]
    count, x, y = plane["points"], plane["stance_angle"], plane["stance_rate"]
    kept = [marks_of(plane, name) for name in answer["kept"]]
    saved = np.any([marks_of(plane, "saved"), *kept], axis=0)
    picture = np.where(saved, 2, np.where(marks_of(plane, "lost"), 0, 1))
    for level, colour in ((0, PALE), (1, OPEN), (2, KERNEL)):
        _fill(axes, picture == level, colour, (*x, *y))
    across, up = np.linspace(*x, count), np.linspace(*y, count)
    for name, (_, colour) in BASINS.items():
        if name in answer["kept"]:
            marks = marks_of(plane, name).astype(float)
            axes.contour(across, up, marks, levels=[0.5], colors=[colour], linewidths=1.3)
    axes.plot(*plane["gait"], "o", color="white", markeredgecolor=INK, markersize=5)
    axes.grid(visible=False)
    axes.set(xlabel=label_of("stance_angle"), ylabel=label_of("stance_rate"))


def _fill(axes: Axes, marks: NDArray[np.bool_], colour: str, extent: tuple[float, ...]) -> None:
    picture = np.ma.masked_where(~marks, np.ones(marks.shape))
    axes.imshow(
        picture, origin="lower", aspect="auto", extent=extent, interpolation="nearest",
        cmap=ListedColormap([colour]),
    )  # fmt: skip


def marks_of(plane: dict[str, Any], name: str) -> NDArray[np.bool_]:
    """(rates, angles) of a set that was kept as a text of 0 and 1."""
    marks: NDArray[np.bool_] = np.frombuffer(plane[name].encode(), np.uint8) == ord("1")
    return marks.reshape(plane["points"], plane["points"])
