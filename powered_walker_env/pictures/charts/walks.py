"""Figures of walks and of learning (import it on demand: needs matplotlib).

The functions return `matplotlib.figure.Figure` objects and leave pyplot's state alone;
`save_figure` writes one.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.files import written_aside
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory

COLOURS = ("#c8553d", "#1f6f8b", "#7a9e3c", "#8a5a99", "#5b5b5b")  # told apart by all eyes
GAIT_COLOUR = "#111111"
#: Components of a post-strike state: name, symbol and unit.
COMPONENTS = (
    ("stance angle", "rad"),
    ("swing angle", "rad"),
    ("stance rate", "rad/s"),
    ("swing rate", "rad/s"),
)


def save_figure(figure: Figure, path: str | os.PathLike[str], *, dpi: int = 120) -> Path:
    """Write a figure; the suffix of `path` says the format. It appears complete or not at all.

    Raises:
        ValueError: a suffix that matplotlib does not know.
        FileNotFoundError: the folder does not exist.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"the folder {str(target.parent)!r} does not exist; make it first")
    with written_aside(target) as aside:
        figure.savefig(aside, dpi=dpi)
    return target


def learning_curve(
    steps: ArrayLike,
    mean: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    *,
    baselines: Mapping[str, float] | None = None,
    limit: int = 100,
    title: str = "",
) -> Figure:
    """Strides survived against strides trained, with a band of confidence and baselines.

    Args:
        steps: (n,) strides walked in training at each evaluation.
        mean, low, high: (n,) strides survived, and their interval.
        baselines: name to strides survived, of controllers that do not learn.
        limit: strides of a whole episode.
    """
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    axes = figure.add_subplot()
    x = np.asarray(steps, np.float64) / 1000
    axes.fill_between(
        x, low, high, color=COLOURS[1], alpha=0.2, linewidth=0, label="95 % confidence"
    )
    axes.plot(x, mean, color=COLOURS[1], marker="o", markersize=4, label="policy, as it learns")
    for (name, value), colour in zip((baselines or {}).items(), COLOURS[::2], strict=False):
        axes.axhline(value, color=colour, linestyle="--", linewidth=1.3)
        axes.annotate(
            f"{name}: {value:.0f}", (1, value), xycoords=axes.get_yaxis_transform(),
            xytext=(-4, 3), textcoords="offset points", ha="right", color=colour,
        )  # fmt: skip
    axes.axhline(limit, color="#999999", linewidth=0.8)
    axes.set(
        xlabel="strides walked in training (thousands)",
        ylabel=f"strides survived, of {limit}",
        xlim=(0, 1.02 * (x[-1] or 1)),
        ylim=(0, 1.05 * limit),
        title=title,
    )
    _grid(axes)
    axes.legend(loc="center right", frameon=False)
    return figure


def disturbed_walks(
    walks: Mapping[str, Trajectory], gait: Trajectory, *, title: str = ""
) -> Figure:
    """Walks in the state space: deviations at every heel strike, and both legs' portraits.

    Args:
        walks: name to walk; each a trajectory from the same start.
        gait: one stride of the undisturbed gait.
    """
    figure = Figure(figsize=(11, 7), layout="constrained")
    figure.suptitle(title, fontsize=12)
    left, right = np.asarray(figure.subfigures(1, 2, width_ratios=(1.15, 1)))
    _draw_deviations(left, walks, gait)
    _draw_portraits(right, walks, gait)
    return figure


def post_strike_states(walk: Trajectory) -> Array:
    """(strides, 4) the state at the start of every stride, pushes included."""
    rows = np.searchsorted(walk.stride, np.arange(walk.stride[-1] + 1))
    stance, swing, stance_rate, swing_rate = leg_motion(walk)
    return np.column_stack([stance, swing, stance_rate, swing_rate])[rows]


def leg_motion(walk: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Angles and rates of both legs, (n,) each: stance and swing angle, then their rates.

    Both angles are of the line from ankle to hip, from the floor's normal, forward positive.
    """
    stance, stance_rate = walk.q[:, 0] + walk.q[:, 1], walk.u[:, 0] + walk.u[:, 1]
    return stance, stance + walk.q[:, 2] - np.pi, stance_rate, stance_rate + walk.u[:, 2]


def _grid(axes: Axes) -> None:
    axes.grid(color="#dddddd", linewidth=0.6)


def _draw_deviations(figure: SubFigure, walks: Mapping[str, Trajectory], gait: Trajectory) -> None:
    """One strip for each component of the state, against the number of the stride."""
    strips: Sequence[Axes] = figure.subplots(4, 1, sharex=True)
    origin = post_strike_states(gait)[0]
    for (name, walk), colour in zip(walks.items(), COLOURS, strict=False):
        deviations = post_strike_states(walk) - origin
        fell = walk.outcome != Outcome.WALKED
        end = "falls in stride {}" if fell else "still walking after {} strides"
        label = f"{name}: {end.format(len(deviations))}"
        for axes, values in zip(strips, deviations.T, strict=True):
            number = np.arange(1, len(values) + 1)
            axes.plot(number, values, color=colour, marker=".", markersize=4, lw=1, label=label)
            if fell:
                axes.plot(number[-1], values[-1], "X", color=colour, markersize=9)
    for axes, (component, unit) in zip(strips, COMPONENTS, strict=True):
        axes.axhline(0, color=GAIT_COLOUR, linewidth=0.8)
        axes.set_ylabel(f"{component}\n({unit})")
        _grid(axes)
    strips[0].set_title("deviation from the gait after each heel strike", fontsize=11)
    strips[0].legend(loc="upper right", frameon=False, fontsize=9)
    strips[-1].set_xlabel("stride")
    strips[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.align_ylabels(strips)


def _draw_portraits(figure: SubFigure, walks: Mapping[str, Trajectory], gait: Trajectory) -> None:
    """Rate against angle of the stance leg (above) and of the swing leg."""
    panels: Sequence[Axes] = figure.subplots(2, 1)
    styles = [*zip(walks.items(), COLOURS, strict=False), (("gait", gait), GAIT_COLOUR)]
    for i, (axes, leg) in enumerate(zip(panels, ("stance", "swing"), strict=True)):
        shown = []
        for (name, walk), colour in styles:
            motion = leg_motion(walk)
            _draw_portrait(axes, walk, motion[i], motion[i + 2], colour, name)
            shown.append(np.stack([motion[i], motion[i + 2]])[:, _walked(walk)])
        _set_limits(axes, *np.concatenate(shown, axis=1))
        axes.set(xlabel=f"{leg} leg, angle from vertical (rad)", ylabel=f"{leg} leg, rate (rad/s)")
        _grid(axes)
    panels[0].set_title("phase portrait of each leg, heel strike to heel strike", fontsize=11)
    panels[0].legend(loc="best", frameon=False, fontsize=9)
    figure.align_ylabels(panels)


def _walked(walk: Trajectory) -> NDArray[np.bool_]:
    """(n,) the samples of strides that ended in a heel strike."""
    return (walk.stride < walk.stride[-1]) | (walk.outcome == Outcome.WALKED)


def _set_limits(axes: Axes, angles: Array, rates: Array) -> None:
    """Frame what was walked; the path of a fall leaves the picture."""
    for values, set_limits in ((angles, axes.set_xlim), (rates, axes.set_ylim)):
        low, high = float(values.min()), float(values.max())
        margin = 0.12 * (high - low)
        set_limits(low - margin, high + margin)


def _draw_portrait(
    axes: Axes, walk: Trajectory, angle: Array, rate: Array, colour: str, name: str
) -> None:
    """One leg's path, a line for each stride, with a dot where it begins."""
    ends = np.flatnonzero(np.diff(walk.stride)) + 1
    x, y = (np.insert(values, ends, np.nan) for values in (angle, rate))
    single = walk.stride[-1] == 0
    axes.plot(x, y, color=colour, lw=1.8 if single else 0.7, alpha=1 if single else 0.7, label=name)
    starts = np.concatenate([[0], ends])
    axes.plot(angle[starts], rate[starts], ".", color=colour, markersize=9 if single else 4)
    if walk.outcome != Outcome.WALKED:
        axes.plot(angle[-1], rate[-1], "X", color=colour, markersize=9)
