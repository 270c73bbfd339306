"""A walk as a row of stick figures, and how high its swing foot is."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from powered_walker_env.pictures.charts.poses import draw_pose
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    RED,
    Drawing,
    sheet,
    styled,
)
from powered_walker_env.pictures.scene import Pose
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory

STICKS = 9  # of a stride
FAINT = 0.35  # of sticks; those at a stride's first instant are drawn in full


@styled
def stick_figure(walk: Trajectory, *, title: str = "") -> Drawing:
    """Legs at equal times, thigh and shank each a stick, and below the height of the swing foot.

    The foot's height is over flat ground at the level of the stance foot's: it touches the floor
    at 0, and scuffs below. Dotted lines are the events.

    Args:
        walk: sampled in time.
    """
    poses = [
        Pose.of(complex(up, forward), [*q, knee], walk.params)
        for (forward, up), q, knee in zip(walk.foot, walk.q, walk.knee[:, 0], strict=True)
    ]
    height = np.array([pose.swing_foot.real - pose.foot.real for pose in poses])
    figure, (sticks, foot) = sheet(2, 6.0, height_ratios=[2, 1])
    _draw_sticks(sticks, walk, poses)
    sticks.set(xlabel="forward (m)", ylabel="up (m)", title=title, aspect="equal")
    foot.axhline(0, color=INK, linewidth=0.8)
    jumps = np.flatnonzero(np.diff(walk.stride)) + 1
    foot.plot(np.insert(walk.t, jumps, np.nan), np.insert(height, jumps, np.nan), color=RED)
    for event in walk.events:
        foot.axvline(event.t, color=GREY, ls=":", linewidth=0.9)
    foot.set(xlabel="t (s)", ylabel="swing foot's height (m)", xlim=(walk.t[0], walk.t[-1]))
    points = {name: np.array([getattr(pose, name) for pose in poses]) for name in (
        "foot", "ankle", "knee", "hip", "swing_knee", "swing_ankle", "swing_foot")}  # fmt: skip
    columns: dict[str, Array] = {"t_s": walk.t, "swing_foot_height_m": height}
    for name, where in points.items():
        columns |= {f"{name}_forward_m": where.imag, f"{name}_up_m": where.real}
    return Drawing(figure, columns)


def _draw_sticks(axes: Axes, walk: Trajectory, poses: list[Pose]) -> None:
    """A leg keeps its colour for the whole walk, as in the films."""
    strides = int(walk.stride[-1]) + 1
    times = np.linspace(walk.t[0], walk.t[-1], STICKS * strides + 1)
    chosen = np.unique(np.searchsorted(walk.t, times).clip(max=len(walk.t) - 1))
    first = {int(np.searchsorted(walk.stride, k)) for k in range(strides)}
    level = walk.params.replace(slope=0.0)  # along the floor
    for row in chosen:
        even = walk.stride[row] % 2 == 0
        full = row in first or row == len(poses) - 1
        draw_pose(
            axes, poses[row], level, (BLUE, RED) if even else (RED, BLUE), 1.0 if full else FAINT
        )
    axes.axhline(0, color=INK, linewidth=0.8)
