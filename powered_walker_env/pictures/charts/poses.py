"""The walker drawn: its angles, and a stride as a row of poses."""

from __future__ import annotations

import cmath
import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc

from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    RED,
    VIOLET,
    Drawing,
    styled,
)
from powered_walker_env.pictures.renderer import SOLE
from powered_walker_env.pictures.scene import Pose
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory

POSES = 9  # of a stride, if nothing else is asked for
PHASES = (BLUE, ORANGE, VIOLET, GREEN)  # colours, in the order of the phases of a stride
SMALL = 0.02  # of the leg: a foot drawn as a point
STANCE, SWING = 2.6, 1.5  # line widths


@styled
def angles_figure(trajectory: Trajectory, *, title: str = "") -> Drawing:
    """One pose with its angles: the legs' (of the state), and the joints' (of the thesis).

    Args:
        trajectory: of which the first pose is taken, just after a heel strike; the floor is
            drawn level, whatever its slope.
    """
    params, q = trajectory.params.replace(slope=0.0), trajectory.q[0]
    pose = Pose.of(complex(params.foot_radius, 0.0), [*q, trajectory.knee[0, 0]], params)
    figure = Figure(figsize=(7.6, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        draw_pose(axes, pose, params, (INK, GREY))
        _draw_floor(axes, pose, params)
    reach, legs = 0.28 * params.leg_length, (q[0] + q[1], q[0] + q[1] + q[2] - math.pi)
    for foot, angle, name in ((pose.ankle, legs[0], "α"), (pose.swing_ankle, legs[1], "s")):
        _draw_angle(left, foot, 0.0, angle, reach, name, BLUE)
    left.set_title("legs, ankle to hip from the floor's normal")
    relative = [(pose.foot, 0.0, q[0], "q₁", RED), (pose.ankle, q[0], q[0] + q[1], "q₂", GREEN),
                (pose.hip, legs[0], legs[0] + q[2], "q₃", VIOLET)]  # fmt: skip
    for number, (joint, begin, end, name, colour) in enumerate(relative):
        if number == 2 or params.foot_length > 0:
            _draw_angle(right, joint, begin, end, (0.6 + 0.2 * number) * reach, name, colour)
    right.set_title("joints: foot, ankle, hip (Camp 1997)")
    figure.suptitle(title)
    names = ("q1_rad", "q2_rad", "q3_rad", "stance_angle_rad", "swing_angle_rad")
    return Drawing(figure, dict(zip(names, [[x] for x in (*q.tolist(), *legs)], strict=True)))


@styled
def stride_figure(trajectory: Trajectory, *, poses: int = POSES, title: str = "") -> Drawing:
    """The first stride as a row of poses at equal times, coloured by phase, over the hip angle.

    Args:
        trajectory: of a stride or more, sampled.
        poses: how many, at least 2.

    Raises:
        ValueError: fewer poses.
    """
    if poses < 2:
        raise ValueError(f"poses must be at least 2, got {poses!r}")
    one = trajectory.stride == 0
    t, q, knee, foot, phase = (a[one] for a in (trajectory.t, trajectory.q, trajectory.knee[:, 0],
                                                trajectory.foot, trajectory.phase))  # fmt: skip
    params = trajectory.params
    figure = Figure(figsize=(7.6, 5.2), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=(1.7, 1.0))
    times = np.linspace(t[0], t[-1], poses)
    rows = np.minimum(np.searchsorted(t, times), len(t) - 1)
    spread = 0.35 * params.leg_length * np.arange(poses)  # so that poses do not hide each other
    for row, shift in zip(rows.tolist(), spread.tolist(), strict=True):
        at = complex(foot[row, 1], foot[row, 0] + shift)
        pose = Pose.of(at, [*q[row], knee[row]], params)
        colour = PHASES[int(phase[row]) % len(PHASES)]
        draw_pose(above, pose, params, (colour, colour))
    ends = (
        complex(0.0, foot[0, 0] - 0.9 * params.leg_length),
        complex(0.0, foot[-1, 0] + spread[-1] + 0.9 * params.leg_length),
    )
    _line(above, ends, params, INK, 1.0)
    above.set_aspect("equal")
    above.set_axis_off()
    above.set_title(title or "one stride, from heel strike to heel strike, drawn apart")
    _draw_phases(below, trajectory, t, q, phase)
    columns = {"t_s": t, "q1_rad": q[:, 0], "q2_rad": q[:, 1], "q3_rad": q[:, 2],
               "knee_rad": knee, "phase": phase}  # fmt: skip
    return Drawing(figure, columns)


def _draw_phases(axes: Axes, trajectory: Trajectory, t: Array, q: Array, phase: Array) -> None:
    """Both legs' angles against time, and which phase it is."""
    alpha = q[:, 0] + q[:, 1]
    axes.plot(t, alpha, color=INK, label="stance angle α")
    swing = alpha + q[:, 2] - math.pi
    axes.plot(t, swing, color=INK, ls="--", label="swing angle s")
    if trajectory.params.knee is not None:
        bend = trajectory.knee[trajectory.stride == 0, 0]
        axes.plot(t, swing + bend, color=INK, ls=":", label="its shank")
    begin = float(t[0])
    for event in (event for event in trajectory.events if event.stride == 0):
        middle = int(phase[np.searchsorted(t, 0.5 * (begin + event.t))])
        colour = PHASES[middle % len(PHASES)]
        axes.axvspan(begin, event.t, color=colour, alpha=0.18, lw=0, label=f"phase: {event.phase}")
        begin = event.t
    axes.set(xlabel="time (s)", ylabel="angle (rad)", xlim=(t[0], t[-1]))
    axes.grid(color=PALE, linewidth=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _tilted(points: list[complex], params: WalkerParams) -> tuple[list[float], list[float]]:
    """Across and up, down being the direction of gravity."""
    turned = [point * cmath.rect(1.0, params.slope) for point in points]
    return [z.imag for z in turned], [z.real for z in turned]


def _line(
    axes: Axes, points: tuple[complex, ...], params: WalkerParams, colour: str, width: float,
    strength: float = 1.0,
) -> None:  # fmt: skip
    axes.plot(
        *_tilted([*points], params), color=colour, lw=width, solid_capstyle="round", alpha=strength
    )


def draw_pose(
    axes: Axes, pose: Pose, params: WalkerParams, colours: tuple[str, str], strength: float = 1.0
) -> None:
    """Both legs with their feet, the stance leg thicker; faint with less strength."""
    R, lock = params.foot_radius, params.locked_ankle_angle
    for centre, ankle, knee, angle, colour, width in (
        (
            pose.swing_foot,
            pose.swing_ankle,
            pose.swing_knee,
            pose.swing_foot_angle,
            colours[1],
            SWING,
        ),
        (pose.foot, pose.ankle, pose.knee, pose.foot_angle, colours[0], STANCE),
    ):
        if SMALL * params.leg_length < R:
            low, high = angle + math.pi + lock - SOLE, angle + math.pi + lock + SOLE
            sole = [centre + cmath.rect(R, a) for a in np.linspace(low, high, 24).tolist()]
            _line(axes, (ankle, *sole, ankle), params, colour, 0.8, strength)
        _line(axes, (centre, ankle), params, colour, width, strength)
        _line(axes, (ankle, knee, pose.hip), params, colour, width, strength)
    axes.plot(*_tilted([pose.hip], params), "o", color=INK, markersize=7, alpha=strength)


def _draw_floor(axes: Axes, pose: Pose, params: WalkerParams) -> None:
    """The floor, and the normals that angles are measured from."""
    left, right = sorted((pose.foot.imag, pose.swing_foot.imag))
    margin = 0.45 * params.leg_length
    _line(axes, (complex(0.0, left - margin), complex(0.0, right + margin)), params, INK, 1.0)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_angle(
    axes: Axes, joint: complex, begin: float, end: float, reach: float, name: str, colour: str
) -> None:
    """An angle at a joint, from one direction (drawn dotted) to another; forward positive."""
    far = joint + cmath.rect(1.5 * reach, begin)
    axes.plot([joint.imag, far.imag], [joint.real, far.real], ":", color=colour, lw=1.2)
    low, high = sorted((90.0 - math.degrees(begin), 90.0 - math.degrees(end)))
    axes.add_patch(Arc((joint.imag, joint.real), 2 * reach, 2 * reach, theta1=low, theta2=high,
                       color=colour, lw=1.6))  # fmt: skip
    at = joint + cmath.rect(1.35 * reach, 0.5 * (begin + end))
    axes.annotate(name, (at.imag, at.real), color=colour, ha="center", va="center", fontsize=12)
