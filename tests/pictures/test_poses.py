"""The walker drawn: its angles, and a stride as a row of poses."""

from __future__ import annotations

import io

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason='needs pip install "powered-walker-env[render]"')

from PIL import Image

from powered_walker_env import PRESETS, walk
from powered_walker_env.pictures.charts import angles_figure, stride_figure


@pytest.mark.parametrize("name", PRESETS)
def test_every_walker_is_drawn_with_its_angles_and_phases(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    walked = walk(state, control, params, 2)
    angles = angles_figure(walked)
    assert angles.columns["stance_angle_rad"] == pytest.approx([state.stance_angle])
    assert angles.columns["swing_angle_rad"] == pytest.approx([state.swing_angle])
    left, right = angles.figure.axes
    assert {text.get_text() for text in left.texts} == {"α", "s"}
    joints = {"q₃"} | ({"q₁", "q₂"} if params.foot_length else set())
    assert {text.get_text() for text in right.texts} == joints
    poses = stride_figure(walked, poses=5)
    assert np.max(poses.columns["t_s"]) == pytest.approx(float(walked.t[walked.stride == 0][-1]))
    above, below = poses.figure.axes
    hips = [line for line in above.lines if line.get_marker() == "o"]
    assert len(hips) == 5
    phases = {event.phase for event in walked.events if event.stride == 0}
    named = {text.get_text() for text in below.get_legend().get_texts()}
    assert {f"phase: {phase}" for phase in phases} <= named


def test_the_poses_stand_on_the_floor() -> None:
    """The hip is one stance leg over its foot, downhill as the slope says."""
    params, control, state, _ = PRESETS["compass"]
    poses = stride_figure(walk(state, control, params, 1), poses=2)
    hips = [line for line in poses.figure.axes[0].lines if line.get_marker() == "o"]
    (x0,), (y0,) = hips[0].get_data()
    alpha = state.stance_angle
    along, normal = np.sin(alpha), np.cos(alpha)  # from the contact point, of a leg of 1 m
    slope = params.slope
    assert x0 == pytest.approx(along * np.cos(slope) + normal * np.sin(slope))
    assert y0 == pytest.approx(normal * np.cos(slope) - along * np.sin(slope))


def test_a_fall_is_drawn_and_one_pose_is_too_few() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    fallen = walk(np.array(state) + np.array([0, 0, 0.8, 0]), control, params, 1)
    assert stride_figure(fallen, poses=4).figure.axes
    with pytest.raises(ValueError, match="poses must be at least 2"):
        stride_figure(fallen, poses=1)


def test_a_drawing_shows_itself_in_a_notebook() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    png = angles_figure(walk(state, control, params, 1))._repr_png_()
    assert Image.open(io.BytesIO(png)).width > 500
