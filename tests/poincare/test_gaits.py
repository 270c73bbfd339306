"""Gaits: the paper reproduced, other people's multipliers, and what is said when none is found."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    GaitNotFoundError,
    PostStrikeState,
    PoweredWalkerEnv,
    ToeOff,
    WalkerParams,
    continue_gait,
    find_gait,
    find_gait_with,
    find_gaits,
    stride,
)
from powered_walker_env.poincare.energy.energetics import costs
from tests.helpers.published import (
    LIMIT_CYCLES,
    PASSIVE_GAITS,
    ROUND_FOOT,
    LimitCycle,
    PassiveGait,
    limit_cycle,
)


def sorted_like(found: np.ndarray, wanted: tuple[complex, ...]) -> float:
    """Largest distance between two sets of multipliers, each printed one matched in turn."""
    return max(float(np.abs(found - value).min()) for value in wanted)


@pytest.mark.parametrize("cycle", LIMIT_CYCLES, ids=str)
def test_reference_gaits_are_found_with_their_section_states_and_multipliers(
    cycle: LimitCycle,
) -> None:
    gait = find_gait(cycle.params, cycle.control, cycle.post_strike_state)
    assert gait.section_state == pytest.approx(cycle.section_state, abs=1e-9)
    assert gait.duration == pytest.approx(cycle.period, abs=1e-9)
    assert gait.step_length == pytest.approx(cycle.step_length, abs=1e-9)
    assert sorted_like(gait.multipliers, cycle.multipliers) < 1e-6  # theirs are differences
    assert gait.spectral_radius == pytest.approx(cycle.spectral_radius, abs=1e-6)
    assert gait.stable


def test_the_published_spectral_radius_is_that_of_the_listing() -> None:
    cycle = limit_cycle("as_published", 692)
    gait = find_gait(cycle.params, cycle.control, cycle.post_strike_state)
    assert round(gait.spectral_radius, 2) == 0.65  # Camp 1997, figure 4
    assert gait.spectral_radius == pytest.approx(0.6546, abs=5e-5)


def test_the_text_s_physics_walks_elsewhere_and_more_stably() -> None:
    cycle = limit_cycle("conserving", 729.8)
    gait = find_gait(cycle.params, cycle.control, cycle.post_strike_state)
    assert gait.spectral_radius == pytest.approx(0.5111, abs=5e-5)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_passive_gaits_come_back_with_their_printed_multipliers(gait: PassiveGait) -> None:
    found = find_gait(gait.params, None, gait.state)
    assert found.state == pytest.approx(gait.state, abs=1e-12)
    assert len(found.multipliers) == 4
    assert abs(found.multipliers[3]) < 1e-12  # the section has one dimension to spare
    assert sorted_like(found.multipliers, gait.multipliers) < 1e-11
    assert found.section_state is None
    assert found.cost_of_transport == pytest.approx(math.sin(gait.params.slope), abs=1e-15)


def test_the_round_foot_gait_is_that_of_the_laboratory() -> None:
    gait = find_gait(ROUND_FOOT.params, ROUND_FOOT.control, ROUND_FOOT.state)
    assert gait.spectral_radius == pytest.approx(ROUND_FOOT.spectral_radius, abs=5e-5)
    assert gait.duration == pytest.approx(ROUND_FOOT.period, abs=5e-5)
    assert gait.step_length == pytest.approx(ROUND_FOOT.step_length, abs=5e-4)
    assert gait.speed == pytest.approx(gait.step_length / gait.duration)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_stable_fixed_points(name: str) -> None:
    params, control, state, source = PRESETS[name]
    returned = stride(state, control, params, rtol=1e-13).state
    assert returned == pytest.approx(state, abs=1e-10)
    assert find_gait(params, control, state).stable
    assert source


def test_both_sections_have_the_same_multipliers_but_for_a_zero() -> None:
    preset = PRESETS["round-foot"]
    switch = find_gait(preset.params, preset.control, preset.state, section="switch")
    strike = find_gait(preset.params, preset.control, preset.state, section="post-strike")
    np.testing.assert_array_equal(switch.multipliers, strike.multipliers[:3])
    assert abs(strike.multipliers[3]) < 1e-12
    assert np.all(np.diff(abs(strike.multipliers)) <= 1e-9)


def test_deviations_shrink_along_the_walk_as_the_multipliers_say() -> None:
    preset = PRESETS["round-foot"]
    gait = find_gait(preset.params, preset.control, preset.state)
    state = PostStrikeState(*(np.array(gait.state) + 1e-4))
    sizes = []
    for _ in range(24):
        state = stride(state, preset.control, preset.params, rtol=1e-12).state
        sizes.append(np.linalg.norm(np.subtract(state, gait.state)))
    rate = (sizes[23] / sizes[8]) ** (1 / 15)
    assert rate == pytest.approx(gait.spectral_radius, rel=0.1)


def test_jacobians_predict_how_the_next_state_moves() -> None:
    preset = PRESETS["round-foot"]
    assert preset.control is not None
    gait = find_gait(preset.params, preset.control, preset.state)
    change, steer = np.array([3e-5, -2e-5, 1e-4, -5e-5]), np.array([1e-4, 0.1])
    nominal = np.array([preset.control.switch_angle, preset.control.stall_torque])

    def landed(sign: float) -> np.ndarray:
        state = PostStrikeState(*(np.array(gait.state) + sign * change))
        control = Control(*(nominal + sign * steer).tolist())
        return np.array(stride(state, control, preset.params, rtol=1e-12).state)

    moved = (landed(1.0) - landed(-1.0)) / 2  # the curvature of the map cancels
    expected = gait.jacobian @ change + gait.control_jacobian @ steer
    np.testing.assert_allclose(moved, expected, atol=1e-8)


def test_a_gait_is_found_without_a_guess() -> None:
    preset = PRESETS["round-foot"]
    gait = find_gait(preset.params, preset.control)
    assert gait.state == pytest.approx(preset.state, abs=1e-10)
    heavier = preset.params.replace(leg_inertia=preset.params.leg_inertia * 1.05)
    assert find_gait(heavier, preset.control).period == 1


def test_a_period_two_gait_is_found_beyond_the_period_doubling() -> None:
    preset = PRESETS["camp1997"]
    control = Control(2.9068, 733.6)  # past the doubling at 733.35
    state = preset.state
    for torque in np.linspace(729.8, 733.6, 20):
        state = find_gait(preset.params, Control(2.9068, torque), state).state
    single = find_gait(preset.params, control, state)
    assert not single.stable
    settled = single.state._replace(swing_rate=single.state.swing_rate + 1e-4)
    for _ in range(2000):
        settled = stride(settled, control, preset.params).state
    double = find_gait(preset.params, control, settled, period=2)
    assert double.stable
    assert double.states.shape == (2, 4)
    assert np.abs(double.states[0] - double.states[1]).max() > 1e-3
    assert double.duration == pytest.approx(2 * single.duration, rel=0.01)
    walked = [stride(row, control, preset.params, rtol=1e-13) for row in double.states]
    for energy in ("positive_work", "electrical_energy"):
        first, second = (getattr(each, energy) for each in walked)
        assert abs(first - second) > 1e-3 * second  # so that no stride counts twice
        assert getattr(double, energy) == pytest.approx(first + second, rel=1e-11)


SIMPLEST = PRESETS["simplest"]


def test_a_period_is_the_least_one_or_the_reason_is_given() -> None:
    doubled = SIMPLEST.params.replace(slope=0.017)  # past the doubling at 0.0151
    gait = find_gait(doubled, None, period=2)
    assert gait.stable and math.dist(gait.states[0], gait.states[1]) > 1e-3
    # A guess from which Newton leads to the gait of one stride: walking on finds the other.
    single = find_gait(SIMPLEST.params, None, SIMPLEST.state)
    for slope in np.linspace(SIMPLEST.params.slope, 0.0155, 12)[1:]:
        single = find_gait(SIMPLEST.params.replace(slope=slope), None, single.state)
    assert not single.stable
    again = find_gait(single.params, None, single.state, period=2)
    assert again.stable and math.dist(again.states[0], again.states[1]) > 1e-3
    # A stable gait of one stride has no gait of two beside it.
    with pytest.raises(GaitNotFoundError, match=r"has period 1; walking on .* not settle on .* 2"):
        find_gait(SIMPLEST.params, None, SIMPLEST.state, period=2)
    with pytest.raises(GaitNotFoundError, match="has period 2; walking on"):
        find_gait(doubled, None, gait.state, period=4)


def test_standing_on_the_spot_is_no_gait() -> None:
    flat = PRESETS["compass"].params.replace(slope=0.0)
    push = ToeOff(10.0)
    with pytest.raises(GaitNotFoundError, match="stands on the spot: it comes back after"):
        find_gait(flat, push, PRESETS["compass"].state)
    with pytest.raises(GaitNotFoundError, match="stands on the spot"):
        find_gait_with(
            PRESETS["compass"].params, None, step_length=1e-5, by="slope",
            guess=PRESETS["compass"].state,
        )  # fmt: skip
    for gait in (find_gait(flat, push), *find_gaits(flat, push, starts=256)):
        assert gait.step_length > 0.1
    env = PoweredWalkerEnv(params=flat.to_dict(), scheme="toe-off", control=[10.0])
    assert env.task.gait[0, 1] - env.task.gait[0, 0] > 0.1
    branch = continue_gait(find_gait(flat, push), "impulse", (5.0, 12.0), step=0.2)
    assert all(branch.gait(i).step_length > 1e-3 for i in range(len(branch)))


@pytest.mark.parametrize("name", PRESETS)
def test_one_definition_of_the_cost_of_transport(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    gait = find_gait(params, control, state)
    assert gait.cost_of_transport == pytest.approx(costs(gait).mechanical, rel=1e-12)
    if control is None:
        assert gait.cost_of_transport == pytest.approx(math.sin(params.slope), rel=1e-12)
    else:
        weight = 2 * params.leg_mass * params.gravity
        assert gait.cost_of_transport * weight * gait.step_length == pytest.approx(
            gait.positive_work + weight * gait.step_length * max(math.sin(params.slope), 0.0)
        )


def test_uphill_gravity_puts_nothing_in() -> None:
    preset = PRESETS["round-foot"]
    uphill = find_gait(preset.params.replace(slope=-1e-4), preset.control, preset.state)
    weight = 2 * preset.params.leg_mass * preset.params.gravity
    assert uphill.cost_of_transport == uphill.positive_work / (weight * uphill.step_length)


def test_a_gait_that_does_not_exist_is_refused_with_the_reason() -> None:
    params = PRESETS["round-foot"].params
    with pytest.raises(GaitNotFoundError, match="no gait of period 1 found"):
        find_gait(params, Control(2.7, 1.0))
    with pytest.raises(GaitNotFoundError, match="fell backward"):
        find_gait(params, Control(2.7, 3000.0), (-1.0, 0.2, 0.0, 0.0))


def test_bad_arguments_are_named() -> None:
    preset = PRESETS["round-foot"]
    with pytest.raises(ValueError, match="section must be one of"):
        find_gait(preset.params, preset.control, preset.state, section="apex")
    with pytest.raises(ValueError, match="'post-strike' for a passive walker"):
        find_gait(WalkerParams(), None, section="switch")
    for period, need in ((0, "at least 1, got 0"), (10**6, "at most 1024, got 1000000")):
        with pytest.raises(ValueError, match=f"period must be {need}"):
            find_gait(preset.params, preset.control, period=period)
    with pytest.raises(TypeError, match=r"period must be a whole number, got 1\.5"):
        find_gait(preset.params, preset.control, period=1.5)  # type: ignore[arg-type]
