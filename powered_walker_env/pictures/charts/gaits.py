"""A gait over time, as in the thesis's figures 4 and 5 (Camp 1997, section 8 and `step.m`)."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from powered_walker_env.model.phases import Outcome, Torque
from powered_walker_env.model.powering import Scheme, ToeOff, scheme_of
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    RED,
    VIOLET,
    Drawing,
    sheet,
    styled,
)
from powered_walker_env.pictures.charts.walks import leg_motion
from powered_walker_env.poincare import Gait
from powered_walker_env.simulation.strides import Array
from powered_walker_env.simulation.trajectory import Trajectory, walk

SAMPLES = 240  # per stride


@styled
def gait_figure(
    gait: Gait, *, periods: int = 2, title: str = "", foot_panel: bool = False
) -> Drawing:
    """Stance leg, swing leg and stance foot against t·√(g/L).

    From the start of the motor, as the thesis has it; where the ankle is locked, from heel
    strike. The legs are measured from the vertical, ankle to hip (α and β − π), the foot from
    its stop (q2 − q2_lock); at heel strike legs and feet change their parts. A swing leg with a
    knee is two curves until knee strike.

    Args:
        gait: under a constant control or none.
        periods: how many to show.
        foot_panel: show the foot once more by itself, enlarged.

    Raises:
        ValueError: a gait under a policy, or one that falls.
    """
    walked = cycle(gait, periods * gait.period + 1)
    powered = scheme_of(gait.control)
    rows = _shown(walked, powered, periods * gait.period)
    unit = math.sqrt(gait.params.gravity / gait.params.leg_length)
    t = walked.t[rows] - walked.t[rows][0]
    stance, swing, _, _ = (values[rows] for values in leg_motion(walked))
    foot = walked.q[rows, 1] - gait.params.locked_ankle_angle
    on = _acting(walked, powered)[rows]
    panelled = foot_panel and powered.moves_ankle
    figure, panels = sheet(1 + panelled, 5.4 if panelled else 4.0, sharex=True,
                           height_ratios=[2, 1][: 1 + panelled])  # fmt: skip
    curves = [(stance, BLUE, r"stance leg, $\alpha$"), (swing, RED, r"swing leg, $\beta-\pi$")]
    if gait.params.knee is not None:
        curves[1] = (swing, RED, "swing leg, its thigh")
        curves.append((swing + walked.knee[rows, 0], ORANGE, "and its shank"))
    if powered.moves_ankle:
        curves.append((foot, VIOLET, r"foot from its stop, $q_2-q_{2,\mathrm{lock}}$"))
    for values, colour, label in curves:
        panels[0].plot(*_broken(t * unit, values), color=colour, label=label)
    panels[0].set(ylabel="angle (rad)", title=title, xlim=(0, t[-1] * unit))
    if panelled:
        panels[1].plot(*_broken(t * unit, foot), color=VIOLET)
        panels[1].set_ylabel("foot (rad)")
    for number, panel in enumerate(panels):
        panel.axhline(0, color=INK, linewidth=0.6, zorder=1)
        _mark_power(panel, t * unit, on, powered, walked.stride[rows], named=number == 0)
    panels[-1].set_xlabel(r"time $t\sqrt{g/L}$")
    figure.align_ylabels()
    figure.legend(loc="outside lower center", ncols=4, columnspacing=1.4)
    columns = {
        "t_sqrt_g_over_L": t * unit,
        "t_s": t,
        "stance_angle_rad": stance,
        "swing_angle_rad": swing,
        "knee_flexion_rad": walked.knee[rows, 0],
        "foot_from_stop_rad": foot,
        "motor_on": on.astype(int),
    }
    return Drawing(figure, columns)


def cycle(gait: Gait, strides: int | None = None) -> Trajectory:
    """A gait as a walk of so many strides, one period if left out, finely sampled.

    Raises:
        ValueError: a gait under a policy, or one that falls.
    """
    if callable(gait.control):
        raise ValueError("gait must have a constant control, got a policy")
    strides, interval = strides or gait.period, gait.duration / gait.period / SAMPLES
    walked = walk(
        gait.state, gait.control, gait.params, strides, sample_interval=interval, rtol=1e-12
    )
    if walked.outcome != Outcome.WALKED:
        raise ValueError(f"gait must walk {strides} strides to be drawn: {walked.outcome.label}")
    return walked


def _acting(walked: Trajectory, powered: Scheme) -> NDArray[np.bool_]:
    """(n,) whether a torque acts at each sample."""
    by_phase = np.array([phase.torque != Torque.NONE for phase in powered.phases])
    acting: NDArray[np.bool_] = by_phase[walked.phase]
    return acting


def _shown(walked: Trajectory, powered: Scheme, strides: int) -> slice:
    """The samples between two starts of the motor, or else two heel strikes."""
    if powered.moves_ankle:
        starts = np.flatnonzero(np.diff(walked.motor_on.astype(int), prepend=0) == 1)
        return slice(int(starts[0]), int(starts[strides]))
    return slice(0, int(np.searchsorted(walked.stride, strides)))


def _broken(x: Array, y: Array) -> tuple[Array, Array]:
    """The curve with gaps at heel strikes, where the legs change their names."""
    jumps = np.flatnonzero((np.diff(x) == 0) & (np.abs(np.diff(y)) > 1e-6)) + 1
    return np.insert(x, jumps, np.nan), np.insert(y, jumps, np.nan)


def _mark_power(
    axes: Axes, x: Array, on: NDArray[np.bool_], powered: Scheme, stride: NDArray[np.int64],
    *, named: bool,
) -> None:  # fmt: skip
    """Shade where a torque acts; without one mark the heel strikes, and what pushes there."""
    edges = np.diff(np.concatenate([[0], on.astype(int), [0]]))
    label: str | None = "motor on" if powered.moves_ankle else "hip torque on"
    for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1, strict=True):
        axes.axvspan(x[begin], x[end], color=GREY, alpha=0.18, linewidth=0,
                     label=label if named else None)  # fmt: skip
        label = None
    if not on.any():
        pushed = powered.control is not None and issubclass(powered.control, ToeOff)
        label = f"heel strike{' and push-off' if pushed else ''}"
        for strike in np.flatnonzero(np.diff(stride)) + 1:
            axes.axvline(x[strike], color=GREY, ls=":", label=label if named else None)
            label = None
