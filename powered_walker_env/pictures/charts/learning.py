"""Figures of learning: strides survived against strides trained."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    PALETTE,
    Drawing,
    sheet,
    styled,
)


@styled
def learning_curve(
    steps: ArrayLike,
    mean: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    *,
    baselines: Mapping[str, float] | None = None,
    limit: int = 100,
    title: str = "",
) -> Drawing:
    """Strides survived against strides trained, with a band of confidence and baselines.

    Args:
        steps: (n,) strides walked in training at each evaluation.
        mean, low, high: (n,) strides survived, and their interval.
        baselines: name to strides survived, of controllers that do not learn.
        limit: strides of a whole episode.
    """
    figure, (axes,) = sheet()
    x = np.asarray(steps, np.float64) / 1000
    band = "95 % confidence, over the\nepisodes of this one seed"
    axes.fill_between(x, low, high, color=BLUE, alpha=0.2, linewidth=0, label=band)
    axes.plot(x, mean, color=BLUE, marker="o", markersize=4, label="policy, as it learns")
    _frame(axes, x[-1], baselines or {}, limit, title)
    columns = {"strides_trained": steps, "strides": mean, "strides_low": low, "strides_high": high}
    return Drawing(figure, columns)


@styled
def learning_curves(
    steps: ArrayLike,
    strides: Mapping[str, ArrayLike],
    *,
    baselines: Mapping[str, float] | None = None,
    limit: int = 100,
    title: str = "",
) -> Drawing:
    """The same of several trainings: a thin line for each, a thick one for their mean.

    Args:
        steps: (n,) strides walked in training at each evaluation.
        strides: name of a training to its strides survived (n,).
        baselines, limit, title: as for `learning_curve`.
    """
    figure, (axes,) = sheet()
    x = np.asarray(steps, np.float64) / 1000
    survived = np.array(list(strides.values()), np.float64)
    lines = axes.plot(x, survived.T, color=BLUE, alpha=0.4, linewidth=0.9)
    lines[0].set_label(f"each of {len(survived)} seeds")
    axes.plot(x, survived.mean(axis=0), color=BLUE, marker="o", markersize=4, label="their mean")
    _frame(axes, x[-1], baselines or {}, limit, title)
    return Drawing(figure, {"strides_trained": steps, **strides})


def _frame(axes: Axes, last: float, baselines: Mapping[str, float], limit: int, title: str) -> None:
    """Baselines, the most that there is to reach, and what the axes are."""
    colours = [colour for colour in PALETTE if colour != BLUE]
    for (name, value), colour in zip(baselines.items(), colours, strict=False):
        axes.axhline(value, color=colour, linestyle="--", linewidth=1.3)
        axes.annotate(
            f"{name}: {value:.0f}", (1, value), xycoords=axes.get_yaxis_transform(),
            xytext=(-4, 3), textcoords="offset points", ha="right", color=colour,
        )  # fmt: skip
    axes.axhline(limit, color=GREY, linewidth=0.8)
    axes.set(
        xlabel="strides walked in training (thousands)",
        ylabel=f"strides survived, of {limit}",
        xlim=(0, 1.02 * (last or 1)),
        ylim=(0, 1.05 * limit),
        title=title,
    )
    axes.legend(loc="center right")
