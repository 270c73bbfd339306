"""Pictures: what the physics says is where the pixels are; files, window, continuity."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("pygame", reason='needs pip install "powered-walker-env[render]"')


from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.pictures.canvas import Colour, Frame
from powered_walker_env.pictures.painter import (
    ALERT,
    LEGS,
    LINE,
    MOTOR,
    SKY,
    SWING_TINT,
    mark_spacing,
    mixed,
)
from powered_walker_env.pictures.renderer import Renderer
from powered_walker_env.pictures.scene import Floor, Pose
from powered_walker_env.simulation.trajectory import Trajectory, walk

NAMES = ["camp1997", "camp1997-as-published", "round-foot"]
PIXEL = 1.5  # px: half a pixel of rounding at each end and the averaging of a fine line
HALF_LINE = 0.9  # px, of the floor's line
STEP = 0.02  # m, small enough for the round-foot walker to stay up


def gait(name: str, strides: int = 2, **arguments: object) -> Trajectory:
    preset = PRESETS[name]
    return walk(preset.state, preset.control, preset.params, strides, **arguments)


def fall() -> Trajectory:
    """A motor far too strong: the walker turns its foot over."""
    state, control = PRESETS["round-foot"].state, PRESETS["round-foot"].control
    strong = Control(control.switch_angle, 2.0 * control.stall_torque)
    trajectory = walk(state, strong, PRESETS["round-foot"].params, 5)
    assert trajectory.outcome != Outcome.WALKED
    return trajectory


def following(trajectory: Trajectory) -> Renderer:
    renderer = Renderer(trajectory.params)
    renderer.follow(trajectory)
    return renderer


def near(frame: Frame, colour: Colour, within: int = 12) -> np.ndarray:
    """Where a picture has a colour, as a mask."""
    return (np.abs(frame.astype(int) - colour) <= within).all(axis=2)


def surface_row(frame: Frame, column: int) -> float:
    """Row of the floor's surface at the picture's edge, where only sky is above it."""
    assert not 12 <= column <= 627, "labels and the walker are in between"
    first = np.flatnonzero(~near(frame, SKY)[:, column])[0]
    return float(first) + 0.5 + HALF_LINE


def phase_time(trajectory: Trajectory, phase: int) -> float:
    """The middle of the first piece of a phase, s."""
    rows = np.flatnonzero((trajectory.phase == phase) & (trajectory.stride == 0))
    return 0.5 * float(trajectory.t[rows[0]] + trajectory.t[rows[-1]])


def test_a_frame_is_an_rgb_array() -> None:
    frame = following(gait("camp1997")).frame()
    assert frame.shape == (360, 640, 3)
    assert frame.dtype == np.uint8
    assert frame.flags.writeable


@pytest.mark.parametrize("size", [(320, 180), (401, 303)])
def test_other_sizes(size: tuple[int, int]) -> None:
    trajectory = gait("round-foot")
    renderer = Renderer(trajectory.params, width=size[0], height=size[1])
    renderer.follow(trajectory)
    assert renderer.frame().shape == (size[1], size[0], 3)


@pytest.mark.parametrize("size", [{"width": 0}, {"height": -3}, {"width": 2.5}, {"height": True}])
def test_impossible_sizes_are_refused(size: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(size))} must be a positive integer"):
        Renderer(PRESETS["camp1997"].params, **size)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("phase", [0, 1])
def test_the_stance_foot_touches_the_drawn_floor_at_the_contact_point(
    name: str, phase: int
) -> None:
    """The contact point from rolling without slip, not from the feet of the trajectory."""
    trajectory = gait(name)
    renderer, time = following(trajectory), phase_time(trajectory, phase)
    scene, frame = renderer.scene(time), renderer.frame(time)
    rolled = trajectory.params.foot_radius * (scene.pose.foot_angle - trajectory.q[0, 0])
    column, row = renderer.to_pixels(scene, rolled, 0.0)
    assert near(frame, LINE, 60)[round(row), round(column)]  # the dot at the contact point
    for far in (5, 634):
        assert surface_row(frame, far) == pytest.approx(row, abs=PIXEL)


@pytest.mark.parametrize("name", NAMES)
def test_the_swing_foot_meets_the_floor_at_heel_strike(name: str) -> None:
    trajectory = gait(name, strides=1)
    renderer = following(trajectory)
    scene, frame = renderer.scene(), renderer.frame()
    R = trajectory.params.foot_radius
    column, row = renderer.to_pixels(scene, scene.pose.swing_foot.imag, scene.pose.swing_foot.real)
    scale = renderer.to_pixels(scene, scene.pose.swing_foot.imag + 1.0, 0.0)[0] - column
    assert row + R * scale == pytest.approx(surface_row(frame, 5), abs=PIXEL)
    assert scene.pose.swing_foot.imag == pytest.approx(trajectory.landings[1], abs=1e-9)


def test_a_round_sole_is_drawn_down_to_the_floor_and_no_further() -> None:
    trajectory = gait("round-foot")
    renderer, time = following(trajectory), phase_time(trajectory, 0)
    frame = renderer.frame(time)
    lowest = np.flatnonzero(near(frame, LEGS[0]).any(axis=1)).max()
    assert lowest == pytest.approx(surface_row(frame, 5), abs=2 * PIXEL)  # half the line's width


def test_the_sole_covers_every_contact_of_the_gait() -> None:
    trajectory = gait("round-foot", strides=3)
    low, high = following(trajectory).scene().sector
    assert low < trajectory.q[:, 0].min()
    assert high > trajectory.q[:, 0].max()


@pytest.mark.parametrize("name", NAMES)
def test_poses_follow_the_geometry_of_the_thesis(name: str) -> None:
    """Limbs keep their lengths, and the walker stands over its foot's centre as it started."""
    params, state = PRESETS[name].params, PRESETS[name].state
    renderer = Renderer(params)
    renderer.reset(state)
    pose = renderer.scene().pose
    assert abs(pose.ankle - pose.foot) == pytest.approx(params.foot_length)
    assert abs(pose.hip - pose.ankle) == pytest.approx(params.leg_length)
    assert abs(pose.swing_ankle - pose.hip) == pytest.approx(params.leg_length)
    assert abs(pose.swing_foot - pose.swing_ankle) == pytest.approx(params.foot_length)
    leaning = pose.hip - pose.ankle
    assert math.atan2(leaning.imag, leaning.real) == pytest.approx(state.stance_angle)
    leaning = pose.hip - pose.swing_ankle
    assert math.atan2(leaning.imag, leaning.real) == pytest.approx(state.swing_angle)


def test_the_thesis_ankle_is_below_the_floor() -> None:
    pose = following(gait("camp1997")).scene(0.0).pose
    assert pose.ankle.real == pytest.approx(-0.039, abs=0.001)


@pytest.mark.parametrize("name", NAMES)
def test_the_motor_lights_the_stance_ankle_and_its_label(name: str) -> None:
    trajectory = gait(name)
    renderer = following(trajectory)
    for phase in (0, 1):
        time = phase_time(trajectory, phase)
        scene, lit = renderer.scene(time), near(renderer.frame(time), MOTOR)
        column, row = renderer.to_pixels(scene, scene.pose.ankle.imag, scene.pose.ankle.real)
        assert bool(lit[round(row), round(column)]) is (phase == 1)
        assert bool(lit[:35, 530:].any()) is (phase == 1)


def test_stance_and_swing_leg_differ_and_swap_at_heel_strike() -> None:
    trajectory = gait("camp1997-as-published")
    renderer = following(trajectory)
    for stride in (0, 1):
        time = float(trajectory.t[trajectory.stride == stride][0]) + 0.1
        scene, frame = renderer.scene(time), renderer.frame(time)
        pose = scene.pose
        legs = (
            (pose.ankle, LEGS[stride]),
            (pose.swing_ankle, mixed(LEGS[1 - stride], SKY, SWING_TINT)),
        )
        for ankle, colour in legs:
            middle = 0.5 * (ankle + pose.hip)
            column, row = renderer.to_pixels(scene, middle.imag, middle.real)
            assert near(frame, colour)[round(row), round(column)]


def test_steps_of_the_ground_are_visible_at_their_height() -> None:
    trajectory = gait("round-foot", strides=1, step_heights=[STEP])
    assert trajectory.outcome == Outcome.WALKED
    renderer = following(trajectory)
    scene, frame = renderer.scene(), renderer.frame()
    assert trajectory.foot[-1, 0] < scene.floor.edges[0] < trajectory.landings[1]
    _, low = renderer.to_pixels(scene, 0.0, 0.0)
    _, high = renderer.to_pixels(scene, 0.0, STEP)
    assert low - high > 2
    assert surface_row(frame, 5) - surface_row(frame, 634) == pytest.approx(low - high, abs=PIXEL)


@pytest.mark.parametrize("slope", [0.08, -0.05])
def test_a_slope_tilts_the_picture_downhill_positive(slope: float) -> None:
    params = PRESETS["round-foot"].params.replace(slope=slope)
    renderer = Renderer(params)
    renderer.reset(PRESETS["round-foot"].state)
    frame = renderer.frame()
    fallen = surface_row(frame, 630) - surface_row(frame, 10)  # rows count downwards
    assert fallen / 620 == pytest.approx(math.tan(slope), abs=2 * PIXEL / 620)


def test_one_frame_for_each_tick_of_real_time() -> None:
    trajectory = gait("camp1997")
    end = float(trajectory.t[-1])
    for fps, speed in ((25.0, 1.0), (30.0, 1.0), (25.0, 0.5)):
        frames = list(Renderer(trajectory.params).frames(trajectory, fps, speed=speed))
        assert len(frames) == 1 + math.floor(end * fps / speed)


def test_a_walk_given_stride_by_stride_plays_like_one_given_whole() -> None:
    """Each stride in a frame of its own, as an environment makes them."""
    preset = PRESETS["round-foot"]
    whole = gait("round-foot", strides=3, step_heights=[0.0, STEP, 0.0])
    at_once = Renderer(whole.params)
    number = len(list(at_once.frames(whole, 10.0)))
    piecewise, pieces = Renderer(whole.params), 0
    for stride, height in enumerate((0.0, STEP, 0.0)):
        one = walk(whole.states[stride], preset.control, whole.params, 1, step_heights=[height])
        pieces += len(list(piecewise.frames(one, 10.0)))
        for time in np.linspace(*piecewise.span, 7)[1:-1].tolist():
            a, b = at_once.scene(time), piecewise.scene(time)
            np.testing.assert_allclose(a.pose, b.pose, atol=1e-6)
            np.testing.assert_allclose(a.focus, b.focus, atol=1e-6)
            assert (a.stride, a.motor_on) == (b.stride, b.motor_on)
    assert pieces == number
    np.testing.assert_allclose(at_once.scene().floor.edges, piecewise.scene().floor.edges)
    np.testing.assert_allclose(at_once.scene().floor.heights, piecewise.scene().floor.heights)


def test_the_camera_moves_evenly_and_keeps_the_hip_in_the_middle() -> None:
    trajectory = gait("camp1997-as-published", strides=12)
    renderer = following(trajectory)
    times = np.arange(0.0, renderer.span[1], 0.04)
    scenes = [renderer.scene(time) for time in times.tolist()]
    steps = np.diff([scene.focus.imag for scene in scenes])
    assert steps.min() > 0.75 * steps.mean()
    assert np.abs(np.diff(steps)).max() < 0.1 * steps.mean()
    columns = [
        renderer.to_pixels(scene, scene.pose.hip.imag, scene.pose.hip.real)[0] for scene in scenes
    ]
    assert np.abs(np.array(columns) - 320).max() < 0.1 * 640


def test_reset_forgets_the_walk() -> None:
    renderer = following(gait("round-foot", strides=2, step_heights=[STEP, 0.0]))
    first = gait("round-foot", strides=1)
    renderer.reset()
    with pytest.raises(ValueError, match="call follow"):
        renderer.frame()
    renderer.follow(first)
    assert renderer.span == (0.0, first.t[-1])
    np.testing.assert_array_equal(renderer.frame(), following(first).frame())


def test_a_state_stands_before_the_first_stride() -> None:
    """The frame of an environment's reset is the walk's first; the stride goes on from it."""
    trajectory = gait("camp1997", strides=1)
    renderer = Renderer(trajectory.params)
    renderer.reset(PRESETS["camp1997"].state)
    standing = renderer.frame()
    rest = list(renderer.frames(trajectory, 20.0))
    whole = list(Renderer(trajectory.params).frames(trajectory, 20.0))
    assert 1 + len(rest) == len(whole)
    for ours, theirs in zip([standing, *rest], whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_reset_takes_other_parameters() -> None:
    renderer = Renderer(PRESETS["camp1997"].params)
    renderer.reset(PRESETS["round-foot"].state, params=PRESETS["round-foot"].params)
    assert renderer.scene().params == PRESETS["round-foot"].params


def test_a_fall_is_named_and_ends_the_walk() -> None:
    trajectory = fall()
    renderer = Renderer(trajectory.params)
    frames = list(renderer.frames(trajectory, 10.0))
    assert near(frames[-1], ALERT, 40).any()
    assert not near(frames[-2], ALERT, 40).any()
    assert renderer.scene().verdict == trajectory.outcome.label
    with pytest.raises(ValueError, match=r"call reset\(\) first"):
        renderer.follow(trajectory)


def test_a_passive_walker_without_feet_is_drawn() -> None:
    params = PRESETS["camp1997"].params.replace(
        foot_length=0.0, com_along=0.6, leg_mass=5.0, slope=0.02
    )
    trajectory = walk((-0.3, 0.3, 1.2, 0.5), None, params, 1)
    assert following(trajectory).frame(0.5 * float(trajectory.t[-1])).shape == (360, 640, 3)


def test_rates_must_be_positive() -> None:
    trajectory = gait("camp1997", strides=1)
    renderer = Renderer(trajectory.params)
    with pytest.raises(ValueError, match="fps must be positive"):
        renderer.frames(trajectory, 0.0)
    with pytest.raises(ValueError, match="speed must be positive"):
        renderer.frames(trajectory, 25.0, speed=math.nan)


def test_floor_keeps_its_steps() -> None:
    floor = Floor()
    floor.extend(1.0, 0.1)
    floor.extend(2.0, 0.1)  # level: no edge
    floor.extend(3.0, -0.2)
    assert floor.edges == [1.0, 3.0]
    assert [floor.height(x) for x in (0.9, 1.1, 2.9, 3.1)] == [0.0, 0.1, 0.1, -0.2]
    assert floor.outline(0.5, 2.0) == [0.5j, 1j, 0.1 + 1j, 0.1 + 2j]
    assert floor.outline(1.5, 2.0) == [0.1 + 1.5j, 0.1 + 2j]
    assert floor.outline(0.0, 4.0)[-2:] == [-0.2 + 3j, -0.2 + 4j]


def test_marks_are_round_numbers() -> None:
    assert [mark_spacing(width) for width in (2.7, 3.1, 7.0, 60.0)] == [0.5, 1.0, 2.0, 10.0]


def test_a_pose_adds_the_limbs_up() -> None:
    params = PRESETS["camp1997"].params
    down = (math.pi, -math.pi, math.pi, 0.0)  # the foot down, legs together, no knee
    pose = Pose.of(0j, down, params)
    assert pose.hip.real == pytest.approx(params.leg_length - params.foot_length)
    assert pose.swing_ankle == pytest.approx(pose.ankle)
