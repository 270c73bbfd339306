"""A gait over time, as in the thesis's figures 4 and 5 (Camp 1997, section 8 and `step.m`)."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    RED,
    VIOLET,
    Drawing,
    sheet,
    styled,
)
from powered_walker_env.poincare import Gait
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory, walk

SAMPLES = 240  # per stride


@styled
def gait_figure(
    gait: Gait, *, periods: int = 2, title: str = "", foot_panel: bool = False
) -> Drawing:
    """Stance leg, swing leg and stance foot against t·√(g/L), from the start of the motor.

    The legs are measured from the vertical, ankle to hip (α and β − π), the foot from its
    stop (q2 − q2_lock); at heel strike legs and feet change their parts.

    Args:
        gait: one of an ankle motor, under a constant control.
        periods: how many to show.
        foot_panel: show the foot once more by itself, enlarged.

    Raises:
        ValueError: a gait without an ankle motor, or one that falls.
    """
    powered = scheme_of(gait.control)
    if not powered.moves_ankle:
        raise ValueError(
            f"gait must be one of an ankle motor, got a {powered.name} gait; plot its walk instead"
        )
    walked = _walk(gait, periods)
    time = math.sqrt(gait.params.gravity / gait.params.leg_length)
    t, angles, on = _from_motor_start(walked, periods * gait.period)
    rows, height = (2, 5.4) if foot_panel else (1, 4.0)
    figure, panels = sheet(rows, height, sharex=True, height_ratios=[2, 1][:rows])
    axes = panels[0]
    styles = (
        (BLUE, r"stance leg, $\alpha$"),
        (RED, r"swing leg, $\beta-\pi$"),
        (VIOLET, r"foot from its stop, $q_2-q_{2,\mathrm{lock}}$"),
    )
    for values, (colour, label) in zip(angles, styles, strict=True):
        x, y = _broken(t * time, values)
        axes.plot(x, y, color=colour, label=label)
    axes.set(ylabel="angle (rad)", title=title, xlim=(0, t[-1] * time))
    if foot_panel:
        panels[1].plot(*_broken(t * time, angles[2]), color=VIOLET)
        panels[1].set_ylabel("foot (rad)")
    for number, panel in enumerate(panels):
        panel.axhline(0, color=INK, linewidth=0.6, zorder=1)
        _shade_motor(panel, t * time, on, "motor on" if number == 0 else None)
    panels[-1].set_xlabel(r"time $t\sqrt{g/L}$")
    figure.align_ylabels()
    figure.legend(loc="outside lower center", ncols=4, columnspacing=1.4)
    columns = {
        "t_sqrt_g_over_L": t * time,
        "t_s": t,
        "stance_angle_rad": angles[0],
        "swing_angle_rad": angles[1],
        "foot_from_stop_rad": angles[2],
        "motor_on": on.astype(int),
    }
    return Drawing(figure, columns)


def _walk(gait: Gait, periods: int) -> Trajectory:
    control = gait.control
    strides = periods * gait.period + 1
    if not callable(control):
        chosen = control
    else:
        raise ValueError("gait must have a constant control, got a policy")
    interval = gait.duration / gait.period / SAMPLES
    walked = walk(gait.state, chosen, gait.params, strides, sample_interval=interval, rtol=1e-12)
    if walked.outcome != Outcome.WALKED:
        raise ValueError(f"gait must walk {strides} strides to be drawn: {walked.outcome.label}")
    return walked


def _from_motor_start(walked: Trajectory, strides: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Time, the three angles (3, n), whether the motor is on: between two starts of it."""
    starts = np.flatnonzero(np.diff(walked.motor_on.astype(int), prepend=0) == 1)
    rows = slice(int(starts[0]), int(starts[strides]))
    q = walked.q[rows]
    stance = q[:, 0] + q[:, 1]
    swing = stance + q[:, 2] - math.pi
    foot = q[:, 1] - walked.params.locked_ankle_angle
    return (
        walked.t[rows] - walked.t[rows][0],
        np.array([stance, swing, foot]),
        walked.motor_on[rows],
    )


def _broken(x: Array, y: Array) -> tuple[Array, Array]:
    """The curve with gaps at heel strikes, where the legs change their names."""
    jumps = np.flatnonzero((np.diff(x) == 0) & (np.abs(np.diff(y)) > 1e-6)) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)


def _shade_motor(axes: Axes, x: Array, motor: NDArray[np.bool_], label: str | None) -> None:
    on = np.concatenate([[0], motor.astype(int), [0]])
    begins, ends = np.flatnonzero(np.diff(on) == 1), np.flatnonzero(np.diff(on) == -1) - 1
    for begin, end in zip(begins, ends, strict=True):
        axes.axvspan(x[begin], x[end], color=GREY, alpha=0.18, linewidth=0, label=label)
        label = None
