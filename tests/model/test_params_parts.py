"""A leg assembled from its parts, and the two other arguments of a stride: control, state."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.powering import check_walkable
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState, check_state
from powered_walker_env.model.walker import WalkerParams

STATE = PostStrikeState(-0.1, 0.2, 0.5, 0.4)


def test_composite_leg_has_the_mass_centre_and_inertia_of_its_point_masses() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        length = rng.uniform(0.5, 2)
        hip, foot = rng.uniform(0, 5, 2)
        masses = rng.uniform(0.1, 1, 7)  # of the frame
        points = rng.uniform(-1, 1, (7, 2)) * [length, 0.3]  # along and across the leg
        centre = masses @ points / masses.sum()
        walker = WalkerParams.from_composite_leg(
            hip_mass=hip,
            frame_mass=masses.sum(),
            foot_mass=foot,
            leg_length=length,
            frame_com_along=centre[0],
            frame_com_across=centre[1],
            frame_inertia=masses @ np.sum((points - centre) ** 2, axis=1),
        )
        masses = np.array([*masses, hip, foot])
        points = np.array([*points, [length, 0], [0, 0]])
        com = np.array([walker.com_along, walker.com_across])
        assert walker.leg_mass == pytest.approx(masses.sum(), rel=1e-14)
        assert com == pytest.approx(masses @ points / masses.sum(), abs=1e-14)
        inertia = masses @ np.sum((points - com) ** 2, axis=1)
        assert walker.leg_inertia == pytest.approx(inertia, rel=1e-13)


def test_frame_without_further_word_is_a_uniform_rod() -> None:
    """Two halves of its mass at ±L/√12 from the middle have the same inertia everywhere."""
    rod = WalkerParams.from_composite_leg(hip_mass=3, frame_mass=2, foot_mass=1, leg_length=1.5)
    along = np.array([1.5, 0.75 + 1.5 / math.sqrt(12), 0.75 - 1.5 / math.sqrt(12), 0])
    masses = np.array([3.0, 1, 1, 1])
    centre = masses @ along / 6
    assert (rod.leg_length, rod.com_across) == (1.5, 0.0)
    assert rod.com_along == pytest.approx(centre, rel=1e-15)
    assert rod.leg_inertia == pytest.approx(masses @ (along - centre) ** 2, rel=1e-14)


def test_composite_leg_takes_every_other_field_of_the_walker() -> None:
    fields: dict[str, Any] = {"slope": 0.1, "foot_radius": 0.2, "physics": "as_published"}
    walker = WalkerParams.from_composite_leg(hip_mass=5, foot_mass=1, **fields)
    assert {name: getattr(walker, name) for name in fields} == fields
    with pytest.raises(TypeError, match="color"):
        WalkerParams.from_composite_leg(hip_mass=5, foot_mass=1, color="red")


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"hip_mass": -1.0}, "hip_mass must not be negative, got -1.0"),
        ({"hip_mass": 1.0, "frame_mass": -2.0}, "frame_mass must not be negative, got -2.0"),
        ({"hip_mass": 1.0, "foot_mass": -2.0}, "foot_mass must not be negative, got -2.0"),
        ({"hip_mass": 0.0}, "hip_mass + frame_mass + foot_mass must be positive, got 0.0"),
        ({"hip_mass": math.nan}, "hip_mass must be finite, got nan"),
        ({"hip_mass": 1.0, "foot_mass": 1.0, "leg_length": -1.0}, "leg_length must be positive"),
        (
            {"hip_mass": 1.0, "frame_mass": 1.0, "frame_inertia": -0.01},
            "frame_inertia must not be negative, got -0.01",
        ),
    ],
)
def test_impossible_part_of_a_leg_is_named(parts: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        WalkerParams.from_composite_leg(**parts)


@pytest.mark.parametrize("hip_mass", [0.1, 0.5, 5.0, 1000.0])
@pytest.mark.parametrize("leg_length", [0.3, 1.0, 1.7])
def test_hip_alone_is_the_leg_of_the_massless_limit_to_the_last_bit(
    hip_mass: float, leg_length: float
) -> None:
    """No inertia, and its centre of mass exactly at the hip: rounding does not spoil the limit."""
    leg = WalkerParams.from_composite_leg(hip_mass=hip_mass, leg_length=leg_length)
    assert (leg.leg_mass, leg.leg_inertia) == (hip_mass, 0.0)
    assert (leg.com_along, leg.com_across) == (leg_length, 0.0)
    check_walkable(leg, None)


@pytest.mark.parametrize("angle", [0.0, -0.1, 2 * math.pi, 7.1])
def test_switch_angle_outside_one_turn_is_rejected_with_its_unit(angle: float) -> None:
    message = f"switch_angle must lie in (0, 2*pi), got {angle!r}; angles are radians"
    with pytest.raises(ValueError, match=re.escape(message)):
        Control(angle, 700.0)


def test_bad_control_is_named_with_its_need_and_value() -> None:
    with pytest.raises(ValueError, match=r"stall_torque must not be negative, got -1\.0"):
        Control(2.9, -1.0)
    with pytest.raises(ValueError, match="switch_angle must be finite, got nan"):
        Control(math.nan, 700.0)
    with pytest.raises(ValueError, match="stall_torque must be finite, got inf"):
        Control(2.9, math.inf)
    with pytest.raises(TypeError, match="stall_torque must be a real number, got '700'"):
        Control(2.9, "700")  # type: ignore[arg-type]


def test_control_holds_floats_and_allows_a_motor_without_torque() -> None:
    control = Control(3, np.float32(0))
    assert (type(control.switch_angle), type(control.stall_torque)) == (float, float)
    assert control == Control(3.0, 0.0)


@pytest.mark.parametrize("form", [tuple, list, np.array, lambda s: np.array(s, dtype=np.float32)])
def test_state_of_any_sequence_is_four_floats(form: Any) -> None:
    state = check_state(form(STATE))
    assert isinstance(state, PostStrikeState)
    assert all(type(value) is float for value in state)
    assert state == pytest.approx(STATE, rel=1e-7)


@pytest.mark.parametrize("field", PostStrikeState._fields)
@pytest.mark.parametrize("value", [math.nan, math.inf, np.float64("nan")])
def test_state_that_is_not_finite_is_rejected_by_field(field: str, value: float) -> None:
    message = rf"state\.{field} must be finite, got (nan|inf)"
    with pytest.raises(ValueError, match=message):
        check_state(STATE._replace(**{field: value}))


@pytest.mark.parametrize("state", [(), STATE[:3], (*STATE, 0.0), np.zeros(6), 1.0, None])
def test_state_of_another_length_is_told_the_four_names(state: Any) -> None:
    names = "state must be four numbers (stance_angle, swing_angle, stance_rate, swing_rate), got"
    with pytest.raises(ValueError, match=re.escape(names)):
        check_state(state)


@pytest.mark.parametrize("state", [("a", 0, 0, 0), "abcd", np.zeros((4, 2)), (None, 0, 0, 0)])
def test_state_of_something_else_is_a_type_error(state: Any) -> None:
    with pytest.raises(TypeError, match=r"state\.stance_angle must be a real number, got"):
        check_state(state)


def test_motor_needs_a_foot_with_a_lever_on_the_floor() -> None:
    point = WalkerParams(foot_length=0.0)
    check_walkable(point, None)
    check_walkable(point.replace(foot_radius=0.1), Control(2.9, 700))
    check_walkable(WalkerParams(), Control(2.9, 700))
    with pytest.raises(ValueError, match=r"foot_length must be positive.*got 0\.0; pass control"):
        check_walkable(point, Control(2.9, 700))


def test_arguments_of_another_type_are_named() -> None:
    with pytest.raises(TypeError, match=r"params must be a WalkerParams, got \{\}"):
        check_walkable({}, None)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"control must be one of Control, .* got \(2\.9, 700\)"):
        check_walkable(WalkerParams(), (2.9, 700))  # type: ignore[arg-type]
