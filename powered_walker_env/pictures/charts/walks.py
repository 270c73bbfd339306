"""Figures of walks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    PALE,
    PALETTE,
    RED,
    Drawing,
    label_of,
    sheet,
    styled,
)
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory

COMPONENTS = PostStrikeState._fields
GAIT = "gait"  # the name of the undisturbed gait among walks: drawn on top, in ink


@styled
def disturbed_walks(
    walks: Mapping[str, Trajectory], gait: Trajectory, *, title: str = ""
) -> Drawing:
    """Walks in the state space: deviations at every heel strike, and both legs' portraits.

    Args:
        walks: name to walk; each a trajectory from the same start.
        gait: one stride of the undisturbed gait.
    """
    figure = Figure(figsize=(11, 7), layout="constrained")
    figure.suptitle(title, fontsize=12)
    left, right = np.asarray(figure.subfigures(1, 2, width_ratios=(1.15, 1)))
    _draw_deviations(left, walks, gait)
    shown = {**walks, GAIT: gait}
    _draw_portraits(right, shown)
    return Drawing(figure, _table(shown))


@styled
def portrait_figure(walks: Mapping[str, Trajectory], *, title: str = "") -> Drawing:
    """Phase portrait: rate against angle of both legs, from strike to strike.

    Args:
        walks: name to walk; one named "gait" is drawn on top, in ink.
    """
    figure, (axes,) = sheet(1, 4.8)
    shown, lone = [], len(walks) == 1
    for (name, walk), colour in zip(walks.items(), _colours(walks), strict=True):
        motion = leg_motion(walk)
        hues, lines = ((BLUE, RED), ("-", "-")) if lone else ((colour, colour), ("-", "--"))
        for i, leg in enumerate(("stance leg", "swing leg")):
            label = leg if lone else f"{name}, {leg}"
            width = 1.8 if lone or name == GAIT else 0.7
            _draw_portrait(axes, walk, motion[i], motion[i + 2], hues[i], label, lines[i], width)
            shown.append(np.stack([motion[i], motion[i + 2]])[:, _walked(walk)])
        axes.plot(*_jumps(walk, motion), ":", color=GREY, lw=0.8, zorder=1)
    axes.plot([], [], ":", color=GREY, lw=0.8, label="heel strike")
    _set_limits(axes, *np.concatenate(shown, axis=1))
    axes.set(xlabel="angle of the leg from vertical (rad)", ylabel="rate (rad/s)", title=title)
    figure.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, _table(walks))


def _colours(walks: Mapping[str, Trajectory]) -> list[str]:
    """One for each walk; ink for the gait, unless it is alone."""
    hues = iter(PALETTE * (len(walks) // len(PALETTE) + 1))
    return [INK if name == GAIT and len(walks) > 1 else next(hues) for name in walks]


def _table(walks: Mapping[str, Trajectory]) -> dict[str, ArrayLike]:
    """The samples of walks, one below the other."""
    columns: dict[str, Any] = {
        "walk": [np.full(len(walk.t), name) for name, walk in walks.items()],
        "stride": [walk.stride for walk in walks.values()],
        "t_s": [walk.t for walk in walks.values()],
    }
    motions = [leg_motion(walk) for walk in walks.values()]
    for i, component in enumerate(COMPONENTS):
        unit = "rad_s" if component.endswith("rate") else "rad"
        columns[f"{component}_{unit}"] = [motion[i] for motion in motions]
    return {name: np.concatenate(parts) for name, parts in columns.items()}


def _jumps(walk: Trajectory, motion: tuple[Array, ...]) -> tuple[Array, Array]:
    """(3n,) angles and rates: where each leg was before a heel strike, and where it is after."""
    after = np.flatnonzero(np.diff(walk.stride)) + 1
    gap = np.full(len(after), np.nan)
    stance, swing, stance_rate, swing_rate = motion
    lines = [
        np.stack([old[after - 1], new[after], gap], axis=1).ravel()
        for old, new in ((stance, swing), (swing, stance),
                         (stance_rate, swing_rate), (swing_rate, stance_rate))
    ]  # fmt: skip
    return np.concatenate(lines[:2]), np.concatenate(lines[2:])


def post_strike_states(walk: Trajectory) -> Array:
    """(strides, 4) the state at the start of every stride, pushes included."""
    rows = np.searchsorted(walk.stride, np.arange(walk.stride[-1] + 1))
    stance, swing, stance_rate, swing_rate = leg_motion(walk)
    return np.column_stack([stance, swing, stance_rate, swing_rate])[rows]


def leg_motion(walk: Trajectory) -> tuple[Array, Array, Array, Array]:
    """Angles and rates of both legs, (n,) each: stance and swing angle, then their rates.

    Both angles are of the line from ankle to hip, of a bent leg its thigh, from the floor's normal,
    forward positive.
    """
    stance, stance_rate = walk.q[:, 0] + walk.q[:, 1], walk.u[:, 0] + walk.u[:, 1]
    return stance, stance + walk.q[:, 2] - np.pi, stance_rate, stance_rate + walk.u[:, 2]


def _draw_deviations(figure: SubFigure, walks: Mapping[str, Trajectory], gait: Trajectory) -> None:
    """One strip for each component of the state, against the number of the stride."""
    strips: Sequence[Axes] = figure.subplots(4, 1, sharex=True)
    origin = post_strike_states(gait)[0]
    for (name, walk), colour in zip(walks.items(), PALETTE, strict=False):
        deviations = post_strike_states(walk) - origin
        fell = walk.outcome != Outcome.WALKED
        end = "falls in stride {}" if fell else "still walking after {} strides"
        label = f"{name}: {end.format(len(deviations))}"
        for axes, values in zip(strips, deviations.T, strict=True):
            number = np.arange(1, len(values) + 1)
            axes.plot(number, values, color=colour, marker=".", markersize=4, lw=1, label=label)
            if fell:
                axes.plot(number[-1], values[-1], "X", color=colour, markersize=9)
    for axes, component in zip(strips, COMPONENTS, strict=True):
        axes.axhline(0, color=INK, linewidth=0.8)
        axes.set_ylabel(label_of(component).replace(" (", "\n("))
        axes.grid(color=PALE, linewidth=0.6)
    strips[0].set_title("deviation from the gait after each heel strike")
    strips[0].legend(loc="upper right")
    strips[-1].set_xlabel("stride")
    strips[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.align_ylabels(strips)


def _draw_portraits(figure: SubFigure, walks: Mapping[str, Trajectory]) -> None:
    """Rate against angle of the stance leg (above) and of the swing leg."""
    panels: Sequence[Axes] = figure.subplots(2, 1)
    for i, (axes, leg) in enumerate(zip(panels, ("stance", "swing"), strict=True)):
        shown = []
        for (name, walk), colour in zip(walks.items(), _colours(walks), strict=True):
            motion = leg_motion(walk)
            _draw_portrait(axes, walk, motion[i], motion[i + 2], colour, name)
            shown.append(np.stack([motion[i], motion[i + 2]])[:, _walked(walk)])
        _set_limits(axes, *np.concatenate(shown, axis=1))
        axes.set(xlabel=f"{leg} leg, angle from vertical (rad)", ylabel=f"{leg} leg, rate (rad/s)")
        axes.grid(color=PALE, linewidth=0.6)
    panels[0].set_title("phase portrait of each leg, heel strike to heel strike")
    panels[0].legend(loc="best")
    figure.align_ylabels(panels)


def _walked(walk: Trajectory) -> NDArray[np.bool_]:
    """(n,) the samples of strides that ended in a heel strike."""
    return (walk.stride < walk.stride[-1]) | (walk.outcome == Outcome.WALKED)


def _set_limits(axes: Axes, angles: Array, rates: Array) -> None:
    """Frame what was walked; the path of a fall leaves the picture, unless it is all there is."""
    if not len(angles):
        return
    for values, set_limits in ((angles, axes.set_xlim), (rates, axes.set_ylim)):
        low, high = float(values.min()), float(values.max())
        margin = 0.12 * (high - low)
        set_limits(low - margin, high + margin)


def _draw_portrait(
    axes: Axes, walk: Trajectory, angle: Array, rate: Array, colour: str, name: str,
    line: str = "-", width: float | None = None,
) -> None:  # fmt: skip
    """One leg's path, a line for each stride, with a dot where it begins."""
    ends = np.flatnonzero(np.diff(walk.stride)) + 1
    x, y = (np.insert(values, ends, np.nan) for values in (angle, rate))
    width = width or (1.8 if walk.stride[-1] == 0 else 0.7)
    bold = width > 1
    axes.plot(x, y, color=colour, lw=width, ls=line, alpha=1.0 if bold else 0.7, label=name)
    starts = np.concatenate([[0], ends])
    axes.plot(angle[starts], rate[starts], ".", color=colour, markersize=9 if bold else 4)
    if walk.outcome != Outcome.WALKED:
        axes.plot(angle[-1], rate[-1], "X", color=colour, markersize=9)
