"""Sections: a state and where its orbit meets the section are the same start of a stride."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, find_gait
from powered_walker_env.model.mechanics.packing import pack
from powered_walker_env.model.powering import MOTOR, FunctionPolicy, scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import slice_through
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.sections import LEGS_PASS, Section, angle_sum, section_of
from powered_walker_env.simulation.strides import Array, StrideBatch, run_batch
from tests.helpers.samples import MOTORS

TORQUE_AT_ONCE = "hip-torque"  # acts from heel strike on: no hip angle is a section
SWINGING = [n for n, p in PRESETS.items() if n != TORQUE_AT_ONCE and p.params.knee is None]


def scattered(name: str, count: int, size: float = 0.01) -> Array:
    params, _, state, _ = PRESETS[name]
    offsets = np.random.default_rng(1).normal(0.0, size, (count, 4))
    return state + offsets * natural_units(params)


def walked(name: str, states: Array, heights: Array) -> StrideBatch:
    params, control, _, _ = PRESETS[name]
    scheme = scheme_of(control)
    rows, packed = np.tile(scheme.row(control), (len(states), 1)), pack(params)[np.newaxis]
    return run_batch(scheme.cycle, states, rows, packed, heights, 1e-11)


@pytest.mark.parametrize("name", SWINGING)
def test_a_stride_from_a_hip_angle_ends_as_the_whole_stride_on_any_ground(name: str) -> None:
    params, control, _, _ = PRESETS[name]
    section, starts = section_of(params, control, level=False), scattered(name, 300)
    heights = np.random.default_rng(2).normal(0.0, 0.004 * params.leg_length, len(starts))
    whole, there = walked(name, starts, heights), section.points(starts, 1e-11)
    rest = walked(name, section.states(there), heights)
    np.testing.assert_array_equal(rest.walked, whole.walked)
    assert whole.walked.sum() > 100
    np.testing.assert_allclose(
        rest.state[rest.walked] / natural_units(params),
        whole.state[rest.walked] / natural_units(params), atol=2e-8,
    )  # fmt: skip
    lost = np.isnan(there).any(axis=1)
    assert not whole.walked[lost].any()
    assert (section.points(section.states(there[~lost])) == there[~lost]).all()


@pytest.mark.parametrize("name", PRESETS)
def test_the_feet_are_the_section_exactly_where_the_foot_stays_locked(name: str) -> None:
    params, control, *_ = PRESETS[name]
    if name == "kneed":
        with pytest.raises(ValueError, match="must have no knee for a section at a hip angle"):
            section_of(params, control)
        return
    section = section_of(params, control)
    moves = name in (*MOTORS, "motor-with-stop")
    assert (section.hip_angle is not None) == moves
    if moves:
        assert section.hip_angle == control.switch_angle  # type: ignore[union-attr]
        return
    starts = scattered(name, 100, 0.04)
    ends = StrideMap(params, control, 1e-10)(starts)
    ends = ends[np.isfinite(ends).all(axis=1)]
    assert len(ends) > 10 and not np.allclose(starts, section.laid(starts), atol=1e-3)
    np.testing.assert_allclose(section.laid(ends), ends, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(section.states(section.points(ends)), ends, rtol=0.0, atol=1e-12)
    assert len(section.coordinates) == (2 if name == "simplest" else 3)


@pytest.mark.parametrize("name", [name for name in MOTORS if name != "kneed"])
def test_the_switch_is_the_section_of_the_thesis(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    gait = find_gait(params, control, state)
    assert gait.section_state is not None
    q1, u1, u3 = gait.section_state
    point = section_of(params, control).points([gait.state], 1e-12)[0]
    foot = point[0] - params.locked_ankle_angle
    np.testing.assert_allclose([foot, point[1], point[2] - point[1]], [q1, u1, u3], atol=1e-9)


def test_a_foot_at_an_angle_shifts_the_section() -> None:
    params = PRESETS["compass"].params.replace(foot_length=0.1, locked_ankle_angle=2.9)
    ends = StrideMap(params, None, 1e-10)(scattered("compass", 100, 0.04))
    ends = ends[np.isfinite(ends).all(axis=1)]
    assert len(ends) > 10 and abs(angle_sum(params)) > 0.05
    np.testing.assert_allclose(ends[:, 0] + ends[:, 1], angle_sum(params), rtol=0.0, atol=1e-12)


def test_where_the_switch_is_decided_the_section_is_ahead_of_all_of_them() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    gait = find_gait(params, control, state)
    assert section_of(params, control, (2.9, 4000.0)) == Section(params, 2.9)
    regulator = regulate(gait, (0.2, 1000.0))
    assert section_of(params, regulator) == Section(params, regulator.high[0])
    unknown = FunctionPolicy(lambda states: np.tile([2.7, 3371.8], (len(states), 1)), MOTOR.name)
    assert section_of(params, unknown) == Section(params, LEGS_PASS)
    ahead = section_of(params, control, (2.9, 4000.0))
    starts = ahead.states(ahead.points(scattered("round-foot", 50)))
    for switch in (2.6, 2.9):
        rows = np.tile([switch, 3371.8], (50, 1))
        packed = pack(params)[np.newaxis]
        batch = run_batch(MOTOR.cycle, starts, rows, packed, np.zeros(1), 1e-9)
        assert batch.walked.any()


def test_states_beyond_the_hip_angle_and_fallen_ones_are_not_on_it() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    section = section_of(params, control)
    beyond, fallen, falls = (0.3, -0.3, 0.9, -1.2), (np.nan,) * 4, (-1.0, 0.2, 0.0, 0.0)
    found = section.points([beyond, fallen, falls, state])
    assert np.isnan(found[:3]).all() and np.isfinite(found[3]).all()


def test_swing_and_stance_angle_follow_from_each_other() -> None:
    for section in (Section(PRESETS["compass"].params), Section(PRESETS["camp1997"].params, 2.9)):
        stance = np.linspace(-0.4, 0.3, 5)
        back = section.stance_angles(section.swing_angles(stance))
        np.testing.assert_allclose(back, stance, atol=1e-12)


@pytest.mark.parametrize("name", PRESETS)
def test_the_plane_through_a_gait_lies_on_its_section(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    gait = find_gait(params, control, state)
    plane = slice_through(gait, shape=(5, 4))
    if name == "kneed":
        assert plane.on is None
        return
    assert plane.on == section_of(params, control)
    np.testing.assert_allclose(plane.on.laid(plane.states), plane.states)
    next_states = StrideMap(params, control, 1e-9)(np.array([plane.base]))
    np.testing.assert_allclose(next_states[0], gait.state, atol=1e-6)


def test_sections_that_make_no_sense_are_refused() -> None:
    params = PRESETS["camp1997"].params
    with pytest.raises(ValueError, match=r"hip_angle must lie in \(0, 2\*pi\), got 7.1"):
        Section(params, 7.1)
    with pytest.raises(ValueError, match="hip_angle must be finite"):
        Section(params, math.nan)
    with pytest.raises(ValueError, match=r"points must have shape \(N, 3\): stance_angle"):
        Section(params, 2.9).states([[1.0, 2.0]])
    torque = PRESETS[TORQUE_AT_ONCE]
    with pytest.raises(ValueError, match="must leave the swing alone after heel strike"):
        section_of(torque.params, torque.control, level=False)
