"""The stride against other people's gaits, a second integrator, and its own laws."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    Outcome,
    PostStrikeState,
    WalkerParams,
    stride,
    stride_batch,
)
from powered_walker_env.simulation import record
from powered_walker_env.simulation.walked import StrideBatch
from tests.helpers.derivation import Array
from tests.helpers.landings import clear_of_together
from tests.helpers.published import LIMIT_CYCLES, PASSIVE_GAITS, LimitCycle, PassiveGait
from tests.helpers.samples import MOTORS, random_walkers
from tests.helpers.second_integrator import stride_otherwise

SPREAD = np.array([0.02, 0.02, 0.06, 0.1])  # rad, rad, rad/s, rad/s: far beyond any basin


def around(name: str, count: int, seed: int) -> Array:
    """States scattered around a preset's gait."""
    rng = np.random.default_rng(seed)
    return np.array(PRESETS[name].state) + rng.normal(size=(count, 4)) * SPREAD


def many(name: str, states: Array, rtol: float) -> StrideBatch:
    control = PRESETS[name].control
    assert control is not None
    nominal = [control.switch_angle, control.stall_torque]
    return stride_batch(states, nominal, PRESETS[name].params, rtol=rtol)


def comparable(name: str, exact: StrideBatch, rtol: float) -> Array:
    """Which strides end alike at a looser tolerance: all but the few that land side by side."""
    final = exact.results[:, record.FINAL]
    same = ~exact.walked | clear_of_together(final, PRESETS[name].params, rtol)
    assert (~same).mean() < 0.005
    return same


@pytest.mark.parametrize("cycle", LIMIT_CYCLES, ids=str)
def test_reference_limit_cycles_return_to_themselves(cycle: LimitCycle) -> None:
    walked = stride(cycle.post_strike_state, cycle.control, cycle.params, rtol=1e-12)
    assert walked.outcome == Outcome.WALKED
    assert walked.state == pytest.approx(cycle.post_strike_state, abs=1e-10)
    assert walked.duration == pytest.approx(cycle.period, abs=1e-10)
    assert walked.step_length == pytest.approx(cycle.step_length, abs=1e-10)
    assert (*walked.final.q, *walked.final.u) == pytest.approx(cycle.pre_heelstrike, abs=1e-9)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_other_peoples_passive_walkers_return_to_their_printed_gaits(gait: PassiveGait) -> None:
    walked = stride(gait.state, None, gait.params)
    assert walked.outcome == Outcome.WALKED
    assert walked.state == pytest.approx(gait.state, abs=1e-9)
    assert walked.duration == pytest.approx(gait.step_duration, abs=1e-9)
    assert walked.step_length == pytest.approx(gait.step_length, abs=1e-9)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_the_listings_heel_strike_misses_the_printed_passive_gaits(gait: PassiveGait) -> None:
    listing = gait.params.replace(physics="as_published")
    walked = stride(gait.state, None, listing)
    assert np.abs(np.subtract(walked.state, gait.state)).max() > 0.01


def agrees_with_second_integrator(
    state: PostStrikeState, control: Control, params: WalkerParams
) -> None:
    ours = stride(state, control, params, rtol=1e-13)
    theirs, landing = stride_otherwise(state, control, params)
    assert ours.outcome == Outcome.WALKED
    assert ours.state == pytest.approx(theirs, abs=1e-9)
    assert ours.duration == pytest.approx(landing.t, abs=1e-10)
    assert ours.final.q == pytest.approx(landing.q, abs=1e-9)


@pytest.mark.parametrize("name", ["camp1997", "round-foot"])
def test_a_second_integrator_on_kanes_equations_walks_the_same_stride(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    assert control is not None
    near = state + 0.05 * (around(name, 3, 3) - state)
    for start in (state, *(PostStrikeState(*row) for row in near)):
        agrees_with_second_integrator(start, control, params)


def test_a_second_integrator_walks_the_same_strides_of_walkers_of_every_kind() -> None:
    rng = np.random.default_rng(11)
    kinds = {"slope": 0.03, "locked_ankle_angle": 1.2, "no_load_speed": 20.0}
    walkers = list(random_walkers(12, 3000, **kinds))  # R, Y, I and the slope are not zero
    count = len(walkers)
    stance = rng.uniform(-0.4, -0.1, count)
    rates = rng.uniform([0.2, -0.3], [1.0, 1.0], (count, 2))
    unit = np.sqrt([w.gravity / w.leg_length for w in walkers])[:, np.newaxis]
    states = np.column_stack([stance, -stance, rates * unit])
    weights = np.array([w.leg_mass * w.gravity * w.leg_length for w in walkers])
    controls = np.column_stack(
        [rng.uniform(2.7, 3.1, count), rng.uniform(0.1, 0.6, count) * weights]
    )
    chosen = np.flatnonzero(stride_batch(states, controls, walkers).walked)[:5]
    assert len(chosen) == 5
    for i in chosen:
        control = Control(*controls[i].tolist())
        agrees_with_second_integrator(PostStrikeState(*states[i].tolist()), control, walkers[i])


@pytest.mark.parametrize("name", MOTORS)
def test_default_tolerance_agrees_with_the_tightest_to_1e_8(name: str) -> None:
    states = around(name, 1000, 1)
    exact, plain = many(name, states, 1e-13), many(name, states, 1e-9)
    same = comparable(name, exact, 1e-9)
    np.testing.assert_array_equal(plain.outcome[same], exact.outcome[same])
    np.testing.assert_allclose(plain.state[same], exact.state[same], rtol=0, atol=1e-8)
    assert exact.walked.sum() > 200


@pytest.mark.parametrize("name", MOTORS)
def test_a_coarse_tolerance_jumps_over_no_heel_strike(name: str) -> None:
    states = around(name, 1000, 2)
    exact, coarse = many(name, states, 1e-13), many(name, states, 1e-3)
    same = comparable(name, exact, 1e-3)
    np.testing.assert_array_equal(coarse.outcome[same], exact.outcome[same])


def test_a_stride_of_a_batch_is_the_single_stride_bit_for_bit() -> None:
    states = around("round-foot", 150, 4)
    preset = PRESETS["round-foot"]
    whole = many("round-foot", states, 1e-9)
    for size in (1, 3, 64):
        part = many("round-foot", states[-size:], 1e-9)
        np.testing.assert_array_equal(part.results, whole.results[-size:])
    for i in (0, 77, 149):
        single = stride(states[i], preset.control, preset.params)
        np.testing.assert_array_equal(single.state, whole.state[i])
        np.testing.assert_array_equal(single.final.q, whole.final_q[i])
        assert single.outcome == whole.outcome[i]
        assert single.duration == whole.duration[i]


def test_a_batch_takes_a_walker_a_control_and_a_height_for_each_row() -> None:
    round_foot, thesis = PRESETS["round-foot"], PRESETS["camp1997"]
    assert round_foot.control is not None
    assert thesis.control is not None
    presets = [round_foot, thesis, round_foot]
    heights = [0.0, 0.0, 0.003]
    batch = stride_batch(
        [p.state for p in presets],
        [[p.control.switch_angle, p.control.stall_torque] for p in presets if p.control],
        [p.params for p in presets],
        step_height=heights,
    )
    for i, (preset, height) in enumerate(zip(presets, heights, strict=True)):
        single = stride(preset.state, preset.control, preset.params, step_height=height)
        np.testing.assert_array_equal(single.state, batch.state[i])


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_the_number_of_threads_changes_no_bit(
    threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    states = around("round-foot", 200, 5)
    whole = many("round-foot", states, 1e-9)
    monkeypatch.setattr("powered_walker_env.simulation.threads.cores", lambda: threads)
    np.testing.assert_array_equal(many("round-foot", states, 1e-9).results, whole.results)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_a_passive_gait_loses_at_heel_strike_what_the_slope_gives(gait: PassiveGait) -> None:
    walked = stride(gait.state, None, gait.params, rtol=1e-12)
    drop = walked.step_length * math.sin(gait.params.slope)
    given = 2 * gait.params.leg_mass * gait.params.gravity * drop
    assert walked.energy_in == 0
    assert walked.energy_lost == pytest.approx(given, rel=1e-8)


@pytest.mark.parametrize("name", ["camp1997", "round-foot"])
def test_a_level_gait_loses_at_heel_strike_what_the_motor_gives(name: str) -> None:
    preset = PRESETS[name]
    walked = stride(preset.state, preset.control, preset.params, rtol=1e-12)
    assert walked.energy_lost == pytest.approx(walked.energy_in, rel=1e-7)
    assert walked.positive_work >= walked.energy_in > 0


def test_time_scales_with_the_root_of_length_over_gravity() -> None:
    preset = PRESETS["round-foot"]
    assert preset.control is not None
    p, scale = preset.params, 4.0
    rate = 1 / math.sqrt(scale)  # L grows fourfold at the same g: rates halve
    big = p.replace(
        **{name: getattr(p, name) * scale for name in ("leg_length", "foot_length", "foot_radius")},
        com_along=p.com_along * scale,
        leg_inertia=p.leg_inertia * scale**2,
        no_load_speed=p.no_load_speed * rate,
    )
    s = preset.state
    start = PostStrikeState(s[0], s[1], s[2] * rate, s[3] * rate)
    control = Control(preset.control.switch_angle, preset.control.stall_torque * scale)
    small, large = stride(s, preset.control, p), stride(start, control, big)
    assert large.state[:2] == pytest.approx(small.state[:2], abs=1e-9)
    assert large.state[2] == pytest.approx(small.state[2] * rate, abs=1e-9)
    assert large.duration == pytest.approx(small.duration / rate, rel=1e-9)
    assert large.step_length == pytest.approx(small.step_length * scale, rel=1e-9)
    assert large.energy_in == pytest.approx(small.energy_in * scale, rel=1e-7)


def test_mass_and_torque_scale_together() -> None:
    preset = PRESETS["camp1997"]
    assert preset.control is not None
    p = preset.params
    light = p.replace(leg_mass=p.leg_mass / 8, leg_inertia=p.leg_inertia / 8)
    control = Control(preset.control.switch_angle, preset.control.stall_torque / 8)
    assert stride(preset.state, control, light).state == pytest.approx(
        stride(preset.state, preset.control, p).state, abs=1e-10
    )


@pytest.mark.parametrize("height", [-0.01, 1e-9, 0.01])
def test_the_foot_lands_on_the_ground_it_meets(height: float) -> None:
    preset = PRESETS["round-foot"]
    p = preset.params
    walked = stride(preset.state, preset.control, p, step_height=height)
    assert walked.outcome == Outcome.WALKED
    foot, stance, swing = np.cumsum(walked.final.q)
    centre = p.foot_length * (math.cos(foot) + math.cos(swing - p.locked_ankle_angle))
    legs = p.leg_length * (math.cos(stance) + math.cos(swing))
    assert centre + legs == pytest.approx(height, abs=1e-12)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
@pytest.mark.parametrize("height", [1e-13, 1e-11, -1e-11, 1e-7, -1e-7])
def test_a_passive_step_depends_smoothly_on_a_step_of_the_ground(
    gait: PassiveGait, height: float
) -> None:
    flat = stride(gait.state, None, gait.params)
    uneven = stride(gait.state, None, gait.params, step_height=height)
    assert uneven.outcome == Outcome.WALKED
    assert uneven.state == pytest.approx(flat.state, abs=100 * abs(height) + 1e-9)


@pytest.mark.parametrize("height", [1e-9, -1e-9, 1e-5, -1e-5, 3e-4, -3e-4])
def test_a_foot_that_scuffs_as_the_legs_pass_does_not_land_on_a_small_step_down(
    height: float,
) -> None:
    preset = PRESETS["round-foot"]  # its swing foot is under the floor as it passes
    flat = stride(preset.state, preset.control, preset.params)
    uneven = stride(preset.state, preset.control, preset.params, step_height=height)
    assert uneven.outcome == Outcome.WALKED
    assert uneven.state == pytest.approx(flat.state, abs=10 * abs(height) + 1e-8)
