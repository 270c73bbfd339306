"""A walk as a trajectory: the same stride, sampled; energy along it; one world frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from powered_walker_env import (
    PRESETS,
    Control,
    Outcome,
    PostStrikeState,
    Trajectory,
    WalkerParams,
    stride,
    walk,
)
from powered_walker_env.model.powering import scheme_of
from tests.helpers.derivation import HIP, SWING_CENTRE, Array, energies, kinematics
from tests.helpers.published import PASSIVE_GAITS
from tests.helpers.samples import MOTORS

THESIS, ROUND = PRESETS["camp1997"], PRESETS["round-foot"]


def mechanical_energy(walked: Trajectory, samples: Array | None = None) -> Array:
    """Kinetic and potential energy at samples (all), from the centres of mass."""
    chosen = slice(None) if samples is None else samples
    rows = zip(walked.q[chosen], walked.u[chosen], strict=True)
    both = [energies(q, u, walked.params) for q, u in rows]
    return np.array([e.kinetic + e.potential for e in both])


def point(walked: Trajectory, name: int) -> Array:
    """A point of the walker in the world frame, (n, 2) forward and up."""
    at = kinematics(walked.q.T, walked.u.T, walked.params).position
    return walked.foot + (at[name] - at[0])[::-1].T


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_energy_is_kept_through_a_passive_swing(gait) -> None:  # type: ignore[no-untyped-def]
    walked = walk(gait.state, None, gait.params, 1, sample_interval=0.01, rtol=1e-12)
    energy = mechanical_energy(walked)
    assert len(energy) > 20
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)


@pytest.mark.parametrize("preset", [THESIS, ROUND], ids=["camp1997", "round-foot"])
def test_energy_is_kept_in_the_swing_phase_of_a_powered_stride(preset) -> None:  # type: ignore[no-untyped-def]
    walked = walk(preset.state, preset.control, preset.params, 1, sample_interval=0.01, rtol=1e-12)
    energy = mechanical_energy(walked)[walked.phase == 0]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)


@pytest.mark.parametrize("name", MOTORS)
def test_the_motors_work_is_the_integral_of_torque_times_speed(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    assert control is not None
    walked = walk(state, control, params, 1, sample_interval=1e-4, rtol=1e-12)
    powered = walked.phase == 1
    speed = -walked.u[powered, 1]
    against = speed if params.physics == "conserving" else -speed
    torque = control.stall_torque * (1 - against / params.no_load_speed)
    once = np.append(np.diff(walked.t[powered]) > 0, True)  # events are sampled from both sides
    t, power = walked.t[powered][once], (torque * speed)[once]
    work = simpson(power, x=t)
    gain = mechanical_energy(walked, np.flatnonzero(powered)[[0, -1]])
    assert gain[1] - gain[0] == pytest.approx(work, rel=1e-8)
    summary = stride(state, control, params, rtol=1e-12)
    assert summary.energy_in == pytest.approx(work, rel=1e-8)
    positive = simpson(np.maximum(power, 0.0), x=t)
    assert summary.positive_work == pytest.approx(positive, rel=1e-5)


def test_the_walk_ends_where_single_strides_end_bit_for_bit() -> None:
    walked = walk(ROUND.state, ROUND.control, ROUND.params, 5)
    state = ROUND.state
    for k in range(5):
        assert tuple(walked.states[k]) == tuple(state)
        state = stride(state, ROUND.control, ROUND.params).state
    assert tuple(walked.states[5]) == tuple(state)


def test_no_point_of_the_walker_jumps_at_a_heel_strike() -> None:
    walked = walk(
        ROUND.state, ROUND.control, ROUND.params, 4, step_heights=[0.0, 0.004, -0.003, 0.0]
    )
    assert walked.outcome == Outcome.WALKED
    strikes = np.flatnonzero(np.diff(walked.stride)) + 1
    hips, swing_feet = point(walked, HIP), point(walked, SWING_CENTRE)
    np.testing.assert_allclose(walked.t[strikes], walked.t[strikes - 1], atol=0)
    np.testing.assert_allclose(hips[strikes], hips[strikes - 1], atol=1e-11)
    np.testing.assert_allclose(walked.foot[strikes], swing_feet[strikes - 1], atol=1e-11)


def test_the_contact_point_travels_the_step_length_and_climbs_the_steps() -> None:
    heights = [0.0, 0.004, -0.003]
    walked = walk(ROUND.state, ROUND.control, ROUND.params, 3, step_heights=heights)
    np.testing.assert_allclose(walked.ground, [0, *np.cumsum(heights)], atol=1e-15)
    first = stride(ROUND.state, ROUND.control, ROUND.params)
    assert walked.landings[1] == first.step_length


def test_samples_come_at_multiples_of_the_interval_and_at_both_sides_of_events() -> None:
    walked = walk(THESIS.state, THESIS.control, THESIS.params, 2, sample_interval=0.1)
    assert (np.diff(walked.t) >= 0).all()
    first = walked.t[walked.stride == 0]
    regular = np.arange(1, int(first[-1] / 0.1) + 1) * 0.1
    for t in regular:
        assert np.isclose(first, t, rtol=0, atol=1e-15).any()
    assert [event.phase for event in walked.events] == ["swing", "powered"] * 2
    for event in walked.events:
        assert (walked.t == event.t).sum() >= 2 or event.t == walked.t[-1]


def test_the_switch_happens_at_the_switch_angle_to_rounding() -> None:
    assert THESIS.control is not None
    for event in walk(THESIS.state, THESIS.control, THESIS.params, 3).events:
        if event.phase == "swing":
            assert event.q[2] == pytest.approx(THESIS.control.switch_angle, abs=1e-15)
            assert event.q[1] == pytest.approx(THESIS.params.locked_ankle_angle, abs=1e-15)
            assert event.u[2] < 0


def test_the_swing_foot_is_on_the_ground_at_heel_strike_to_rounding() -> None:
    walked = walk(ROUND.state, ROUND.control, ROUND.params, 3)
    foot = point(walked, SWING_CENTRE)[:, 1] - ROUND.params.foot_radius
    last = np.append(np.flatnonzero(np.diff(walked.stride)), len(walked.t) - 1)
    np.testing.assert_allclose(foot[last], 0.0, atol=1e-15)


def test_samples_between_steps_of_the_integrator_are_as_good_as_its_steps() -> None:
    rough = walk(THESIS.state, THESIS.control, THESIS.params, 1, sample_interval=0.01)
    exact = walk(THESIS.state, THESIS.control, THESIS.params, 1, sample_interval=0.01, rtol=1e-13)
    np.testing.assert_allclose(rough.q, exact.q, atol=1e-7)
    np.testing.assert_allclose(rough.u, exact.u, atol=1e-6)


@pytest.mark.parametrize("name", PRESETS)
def test_the_least_clearance_after_mid_swing_is_that_of_the_samples(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    walked = walk(state, control, params, 1, sample_interval=1e-4)
    stance, swing = walked.q[:, :2].sum(axis=1), walked.q.sum(axis=1) - math.pi
    height = point(walked, SWING_CENTRE)[:, 1] - params.foot_radius
    lowest = height[stance > swing].min()
    assert stride(state, control, params).min_clearance == pytest.approx(lowest, abs=1e-7)


@pytest.mark.parametrize("name", PRESETS)
def test_clearance_is_where_the_swing_foot_turns_or_the_stride_ends_not_where_the_legs_pass(
    name: str,
) -> None:
    """A foot that is under the floor as it passes and rises has not come down to there."""
    params, control, state, _ = PRESETS[name]
    rng, rising, scheme = np.random.default_rng(3), 0, scheme_of(control)
    for switch in (None,) if control is None else (None, 3.2, 3.3, 3.4):
        chosen = control
        if switch is not None:
            chosen = scheme.control_of((switch, 0.9 * scheme.row(control)[1]))
        for off in [np.zeros(4), *rng.normal(size=(3, 4)) * [0.01, 0.01, 0.03, 0.05]]:
            start = PostStrikeState(*(state + off).tolist())
            walked = walk(start, chosen, params, 1, sample_interval=2e-3)
            if walked.outcome != Outcome.WALKED:
                continue
            stance, swing = walked.q[:, :2].sum(axis=1), walked.q.sum(axis=1) - math.pi
            once = np.append(np.diff(walked.t) > 1e-9, True)  # events are there from both sides
            height = point(walked, SWING_CENTRE)[:, 1] - params.foot_radius
            after = height[once & (stance > swing)]
            turns = (after[1:-1] < after[:-2]) & (after[1:-1] <= after[2:])
            lowest = min([after[-1], *after[1:-1][turns]])
            found = stride(start, chosen, params).min_clearance
            assert found == pytest.approx(lowest, abs=1e-5 * params.leg_length)
            rising += bool(after[0] < lowest - 1e-3)
    assert rising > 0 or name != "camp1997"


def test_a_policy_sees_every_state_and_sets_every_control() -> None:
    seen: list[PostStrikeState] = []
    assert ROUND.control is not None
    nominal = ROUND.control

    def policy(state: PostStrikeState) -> Control:
        seen.append(state)
        return Control(nominal.switch_angle, nominal.stall_torque * (1 + 0.01 * len(seen)))

    walked = walk(ROUND.state, policy, ROUND.params, 3)
    np.testing.assert_array_equal(np.array(seen), walked.states[:-1])
    constant = walk(ROUND.state, ROUND.control, ROUND.params, 3)
    assert abs(walked.states[-1] - constant.states[-1]).max() > 1e-3


def test_a_fall_ends_the_walk() -> None:
    walked = walk((-1.0, 0.2, 0.0, 0.0), ROUND.control, ROUND.params, 10)
    assert walked.outcome == Outcome.FELL_BACKWARD
    assert np.isnan(walked.states[-1]).all()
    assert walked.stride.max() == 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"strides": 0}, "strides must be at least 1, got 0"),
        ({"sample_interval": -1.0}, "sample_interval must not be negative"),
        ({"sample_interval": math.nan}, "sample_interval must not be negative"),
        ({"step_heights": [0.0]}, "step_heights must be 2 finite heights"),
        ({"rtol": 1.0}, "rtol must lie in"),
        ({"state": (0.0, 0.0, math.inf, 0.0)}, r"state\.stance_rate must be finite"),
    ],
)
def test_bad_arguments_are_named(change: dict[str, object], message: str) -> None:
    arguments: dict[str, object] = {
        "state": ROUND.state,
        "control": ROUND.control,
        "params": ROUND.params,
        "strides": 2,
    }
    with pytest.raises(ValueError, match=message):
        walk(**(arguments | change))  # type: ignore[arg-type]


def test_a_policy_that_returns_no_control_is_refused() -> None:
    with pytest.raises(ValueError, match=r"must return controls of shape \(1, 2\), got \(2,\)"):
        walk(ROUND.state, lambda _: (2.7, 1.0), WalkerParams(), 1)  # type: ignore[arg-type, return-value]
