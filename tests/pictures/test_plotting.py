"""Figures: what they show is what was walked, and every axis says what it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Trajectory, walk
from powered_walker_env.pictures.charts import (
    disturbed_walks,
    learning_curve,
    learning_curves,
    save_figure,
)
from powered_walker_env.pictures.charts.walks import COMPONENTS, leg_motion, post_strike_states

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]


def a_walk(strides: int, stance_rate: float = 0.0, torque: float = 1.0) -> Trajectory:
    """A walk that starts off the gait."""
    assert CONTROL is not None
    control = Control(CONTROL.switch_angle, torque * CONTROL.stall_torque)
    start = STATE._replace(stance_rate=STATE.stance_rate + stance_rate)
    return walk(start, control, PARAMS, strides)


@pytest.fixture(scope="module")
def walks() -> dict[str, Trajectory]:
    return {"falls": a_walk(20, -0.15, 0.9), "walks": a_walk(12, 0.01)}


def test_post_strike_states_are_those_of_the_walk(walks: dict[str, Trajectory]) -> None:
    for trajectory in walks.values():
        starts = post_strike_states(trajectory)
        assert len(starts) == trajectory.stride[-1] + 1
        np.testing.assert_allclose(starts, trajectory.states[: len(starts)], atol=1e-12)


def test_leg_motion_is_the_derivative_of_the_leg_angles(walks: dict[str, Trajectory]) -> None:
    trajectory = walk(STATE, CONTROL, PARAMS, 1, sample_interval=0.001)
    stance, swing, stance_rate, swing_rate = leg_motion(trajectory)
    inside = trajectory.phase == 0
    t = trajectory.t[inside]
    for angle, rate in ((stance, stance_rate), (swing, swing_rate)):
        np.testing.assert_allclose(
            np.gradient(angle[inside], t)[2:-2], rate[inside][2:-2], atol=1e-4
        )


def test_disturbed_walks_show_every_stride_and_every_unit(walks: dict[str, Trajectory]) -> None:
    figure = disturbed_walks(walks, a_walk(1), title="two walks").figure
    axes = figure.axes
    assert len(axes) == 6
    units = ("rad", "rad", "rad/s", "rad/s")
    for strip, name, unit in zip(axes[:4], COMPONENTS, units, strict=True):
        assert strip.get_ylabel() == f"{name.replace('_', ' ')}\n({unit})"
    assert axes[3].get_xlabel() == "stride"
    for panel, leg in zip(axes[4:], ("stance", "swing"), strict=True):
        assert f"{leg} leg" in panel.get_xlabel() and "(rad)" in panel.get_xlabel()
        assert "(rad/s)" in panel.get_ylabel()
    legend = axes[0].get_legend()
    assert legend is not None
    count = walks["falls"].stride[-1] + 1
    assert [text.get_text() for text in legend.get_texts()] == [
        f"falls: falls in stride {count}",
        "walks: still walking after 12 strides",
    ]
    line = axes[2].get_lines()[0]
    expected = walks["falls"].states[:count, 2] - STATE.stance_rate
    np.testing.assert_allclose(line.get_ydata(), expected, atol=1e-9)
    np.testing.assert_array_equal(line.get_xdata(), np.arange(1, count + 1))


def test_a_portrait_frames_the_strides_that_were_walked(walks: dict[str, Trajectory]) -> None:
    panel = disturbed_walks(walks, a_walk(1)).figure.axes[4]
    stance = leg_motion(walks["walks"])[0]
    low, high = panel.get_xlim()
    assert low < stance.min() and stance.max() < high
    assert high - low < 2 * (stance.max() - stance.min())


def test_the_learning_curve_shows_interval_and_baselines() -> None:
    figure = learning_curve(
        [0, 1000, 2000], [10, 50, 90], [8, 45, 85], [12, 55, 95],
        baselines={"open loop": 9.7, "LQR": 26.0}, title="learning",
    ).figure  # fmt: skip
    (axes,) = figure.axes
    assert axes.get_xlabel() == "strides walked in training (thousands)"
    assert axes.get_ylabel() == "strides survived, of 100"
    assert axes.get_title(loc="left") == "learning"
    np.testing.assert_array_equal(axes.get_lines()[0].get_xdata(), [0, 1, 2])
    assert {text.get_text() for text in axes.texts} == {"open loop: 10", "LQR: 26"}
    band = axes.collections[0].get_paths()[0].vertices
    assert band[:, 1].min() == 8 and band[:, 1].max() == 95


def test_several_trainings_are_drawn_with_their_mean() -> None:
    drawing = learning_curves(
        [0, 1000], {"a": [10, 50], "b": [20, 90]}, baselines={"LQR": 26.0}, limit=200
    )
    (axes,) = drawing.figure.axes
    lines = [line.get_ydata() for line in axes.get_lines()[:3]]
    np.testing.assert_array_equal(lines, [[10, 50], [20, 90], [15, 70]])
    assert axes.get_ylim()[1] == pytest.approx(210)
    assert list(drawing.columns) == ["strides_trained", "a", "b"]


def test_a_curve_of_one_evaluation_can_be_drawn(tmp_path: Path) -> None:
    save_figure(learning_curve([0], [10], [8], [12]), tmp_path / "curve.png")


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_figures_are_written_complete(
    suffix: str, tmp_path: Path, walks: dict[str, Trajectory]
) -> None:
    path = save_figure(disturbed_walks(walks, a_walk(1)), tmp_path / f"walk.{suffix}")
    assert path.stat().st_size > 10_000
    assert [file.name for file in tmp_path.iterdir()] == [f"walk.{suffix}"]


def test_a_figure_that_cannot_be_written_leaves_the_old_one(tmp_path: Path) -> None:
    figure = learning_curve([0, 1], [1, 2], [1, 2], [1, 2])
    with pytest.raises(FileNotFoundError, match="make it first"):
        save_figure(figure, tmp_path / "nowhere" / "curve.png")
    with pytest.raises(ValueError, match="nosuch"):
        save_figure(figure, tmp_path / "curve.nosuch")
    assert not list(tmp_path.iterdir())


def test_pyplot_is_left_alone() -> None:
    code = (
        "import sys, powered_walker_env.pictures.charts as p;"
        "p.learning_curve([0, 1], [1, 2], [1, 2], [1, 2]);"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
