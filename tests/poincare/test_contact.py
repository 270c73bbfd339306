"""Contact: forces against positions alone, impulses against momenta, and what must balance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from powered_walker_env import PRESETS, Control, Gait, Outcome, WalkerParams, find_gait, walk
from powered_walker_env.poincare.energy.contact import ContactReport, contact_of, contact_report
from powered_walker_env.poincare.energy.ground_force import GroundForce, ground_force
from powered_walker_env.simulation.trajectory import Trajectory
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.published import PASSIVE_GAITS, PassiveGait
from tests.helpers.samples import POWERED

THESIS, PUBLISHED, ROUND = (
    PRESETS[name] for name in ("camp1997", "camp1997-as-published", "round-foot")
)
STEP = 1e-3  # s, of the second differences
STENCIL = (-1, 16, -30, 16, -1)  # fourth order, over 12·STEP²


def centres(walked: Trajectory) -> tuple[Array, Array]:
    """Summed positions and velocities of both centres of mass, (n, 2) up and forward."""
    rows = [d.kinematics(q, u, walked.params) for q, u in zip(walked.q, walked.u, strict=True)]
    legs = [d.STANCE_LEG, d.SWING_LEG]
    return (
        np.array([row.position[legs].sum(axis=0) for row in rows]),
        np.array([row.velocity[legs].sum(axis=0) for row in rows]),
    )


def between_samples(force: GroundForce, values: Array, phase: int, t: Array) -> Array:
    """A component of the force inside one phase, by a cubic spline."""
    here = np.flatnonzero(force.phase == phase)
    here = here[np.append(np.diff(force.t[here]) > 0, True)]
    return np.asarray(CubicSpline(force.t[here], values[here])(t))


def impulse_over_stride(force: GroundForce) -> Array:
    """∫ F dt over a stride and the impulses of its impacts, (normal, forward), N s."""
    total = np.array(force.impulse) + force.push
    if np.isfinite(force.knee_impulse).all():
        total += force.knee_impulse
    for phase in np.unique(force.phase):
        here = force.phase == phase
        t, once = force.t[here], np.append(np.diff(force.t[here]) > 0, True)
        parts = (force.normal[here][once], force.tangential[here][once])
        total += [simpson(part, x=t[once]) for part in parts]
    return total


@pytest.mark.parametrize("preset", [THESIS, PUBLISHED, ROUND], ids=["thesis", "published", "round"])
def test_ground_force_is_that_of_the_second_difference_of_positions(preset) -> None:  # type: ignore[no-untyped-def]
    params = preset.params.replace(slope=0.02)
    walked = walk(preset.state, preset.control, params, 1, sample_interval=STEP, rtol=1e-13)
    position, _ = centres(walked)
    force = ground_force(params, preset.control, preset.state)
    gravity = params.leg_mass * params.gravity * np.array([math.cos(0.02), -math.sin(0.02)])
    for phase in (0, 1):
        rows = np.flatnonzero(walked.phase == phase)[4:-4]
        acceleration = sum(
            weight * position[rows + k] for k, weight in zip(range(-2, 3), STENCIL, strict=True)
        ) / (12 * STEP**2)
        expected = params.leg_mass * acceleration + 2 * gravity
        for column, component in enumerate((force.normal, force.tangential)):
            ours = between_samples(force, component, phase, walked.t[rows])
            bound = 1e-5 * 2 * gravity[0]
            np.testing.assert_allclose(ours, expected[:, column], atol=bound)


@pytest.mark.parametrize("preset", [THESIS, PUBLISHED, ROUND], ids=["thesis", "published", "round"])
def test_impulse_is_the_change_of_the_point_velocities(preset) -> None:  # type: ignore[no-untyped-def]
    walked = walk(preset.state, preset.control, preset.params, 2, sample_interval=0, rtol=1e-13)
    strike = int(np.flatnonzero(np.diff(walked.stride))[0])
    _, velocity = centres(walked)
    expected = preset.params.leg_mass * (velocity[strike + 1] - velocity[strike])
    force = ground_force(preset.params, preset.control, preset.state)
    assert force.impulse == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_a_passive_gaits_floor_carries_its_weight_down_the_slope(gait: PassiveGait) -> None:
    params = gait.params
    weight = 2 * params.leg_mass * params.gravity
    along = weight * np.array([math.cos(params.slope), -math.sin(params.slope)])
    force = ground_force(params, None, gait.state)
    bound = 1e-6 * weight * force.t[-1]
    np.testing.assert_allclose(impulse_over_stride(force), along * force.t[-1], atol=bound)


@pytest.mark.parametrize("name", POWERED)
def test_over_a_period_force_and_impulse_balance_the_weight(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    force = ground_force(params, control, state)
    weight = 2 * params.leg_mass * params.gravity
    bound = 1e-6 * weight * force.t[-1]
    balance = [weight * force.t[-1], 0.0]
    np.testing.assert_allclose(impulse_over_stride(force), balance, atol=bound)


@pytest.mark.parametrize("preset", [THESIS, ROUND], ids=["thesis", "round"])
def test_torque_at_the_ankle_of_a_massless_foot_is_the_motors(preset) -> None:  # type: ignore[no-untyped-def]
    force = ground_force(preset.params, preset.control, preset.state)
    walked = walk(preset.state, preset.control, preset.params, 1, sample_interval=0.005)
    powered = walked.phase == 1
    speed = -walked.u[powered, 1]
    motor = preset.control.stall_torque * (1 - speed / preset.params.no_load_speed)
    ours = between_samples(force, force.ankle_torque, 1, walked.t[powered])
    np.testing.assert_allclose(ours, motor, rtol=1e-5)


def test_a_walker_on_one_straight_leg_stands_with_its_weight_on_the_floor() -> None:
    """Nearly all of the mass in the hip, upright and nearly still: F = weight less m v²/L."""
    params = WalkerParams.from_composite_leg(
        hip_mass=500.0, foot_mass=1e-6, foot_length=0.0, locked_ankle_angle=math.pi
    )
    for rate in (1e-3, 0.5, 3.0):
        force = ground_force(params, None, (0.0, 0.1, rate, 0.0))
        centripetal = params.gravity - rate**2 * params.leg_length
        assert force.normal[0] == pytest.approx(1000.0 * centripetal, rel=1e-6)


def test_a_walker_faster_than_gravity_can_hold_lifts_off() -> None:
    """Froude number above 1: the walk turns into a run, which the report must tell."""
    params = WalkerParams.from_composite_leg(
        hip_mass=500.0, foot_mass=1.0, foot_length=0.0, locked_ankle_angle=math.pi
    )
    report = contact_report(params, None, (-0.3, 0.3, 4.0, 0.0))
    assert report.min_normal_force < 0
    assert not report.keeps_contact
    assert report.friction == math.inf
    assert any("lifts off" in text for text in report.violations())


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_published_passive_gaits_push_and_lift(gait: PassiveGait) -> None:
    report = contact_report(gait.params, None, gait.state)
    assert report.strike_pushes
    assert report.trailing_foot_lifts
    assert report.keeps_contact
    assert report.deepest < 0 <= report.max_clearance  # straight legs scuff until they pass
    assert not report.falls_back
    assert report.ankle_reversals == 0


def trailing_velocity(preset) -> float:  # type: ignore[no-untyped-def]
    """Upward velocity of the trailing ankle after the first heel strike, by Kane's points."""
    walked = walk(preset.state, preset.control, preset.params, 2, sample_interval=0, rtol=1e-13)
    after = int(np.flatnonzero(np.diff(walked.stride))[0]) + 1
    velocity = d.kinematics(walked.q[after], walked.u[after], walked.params).velocity
    return float(velocity[d.SWING_ANKLE, 0])


@pytest.mark.parametrize("preset", [THESIS, ROUND], ids=["thesis", "round"])
def test_trailing_ankle_moves_as_the_points_of_the_walker_do(preset) -> None:  # type: ignore[no-untyped-def]
    report = contact_report(preset.params, preset.control, preset.state)
    assert report.trailing_ankle_velocity == pytest.approx(trailing_velocity(preset), rel=1e-6)


def test_trailing_foot_of_a_locked_walker_moves_as_its_swing_foot() -> None:
    gait = PASSIVE_GAITS[0]
    walked = walk(gait.state, None, gait.params, 2, sample_interval=0, rtol=1e-13)
    after = int(np.flatnonzero(np.diff(walked.stride))[0]) + 1
    velocity = d.kinematics(walked.q[after], walked.u[after], gait.params).velocity
    report = contact_report(gait.params, None, gait.state)
    expected = velocity[d.SWING_CENTRE, 0]
    assert report.trailing_foot_velocity == pytest.approx(expected, rel=1e-6)


def test_the_thesis_geometrys_faults_are_told() -> None:
    """Its ankles are 39 mm under the floor and its foot passes the stop by 0.004 rad."""
    report = contact_report(THESIS.params, THESIS.control, THESIS.state)
    assert report.min_ankle_height == pytest.approx(-0.039, abs=5e-4)
    assert report.stop_overrun == pytest.approx(0.004, abs=5e-5)
    assert report.falls_back
    assert not report.extends_monotonely
    assert not report.ankles_stay_above
    assert len(report.violations()) == 2


def test_the_round_foots_scuffing_is_told() -> None:
    report = contact_report(ROUND.params, ROUND.control, ROUND.state)
    assert report.deepest == pytest.approx(-0.0025, abs=5e-5)
    assert report.scuffs
    assert report.extends_monotonely
    assert not report.stop_suffices
    assert len(report.violations(friction=0.3)) == len(report.violations()) + 1


def published_gait(stall_torque: float) -> Gait:
    return find_gait(PUBLISHED.params, Control(2.8625, stall_torque), PUBLISHED.state)


@pytest.mark.parametrize(("stall_torque", "reversals"), [(700.0, 1), (725.0, 0), (745.0, 2)])
def test_reversals_are_those_of_the_sampled_ankle(stall_torque: float, reversals: int) -> None:
    gait = published_gait(stall_torque)
    report = contact_of(gait)
    walked = walk(gait.state, gait.control, gait.params, 1, sample_interval=1e-3)  # type: ignore[arg-type]
    ankle = walked.q[walked.phase == 1, 1]
    turns = np.diff(np.sign(np.diff(ankle)[np.diff(walked.t[walked.phase == 1]) > 0]))
    assert report.ankle_reversals == np.count_nonzero(turns) == reversals
    overrun = max(0.0, ankle.max() - gait.params.locked_ankle_angle)
    assert report.stop_overrun == pytest.approx(overrun, abs=1e-6)
    assert report.extends_monotonely == (reversals == 0)


def test_several_strides_report_their_worst() -> None:
    state = ROUND.state._replace(stance_rate=ROUND.state.stance_rate + 0.01)
    both = contact_report(ROUND.params, ROUND.control, state, strides=2)
    singles = [contact_report(ROUND.params, ROUND.control, state)]
    after = walk(state, ROUND.control, ROUND.params, 1).states[1]
    singles.append(contact_report(ROUND.params, ROUND.control, after.tolist()))
    assert both.strides == 2
    for name in ("min_normal_force", "normal_impulse", "deepest"):
        assert getattr(both, name) == pytest.approx(min(getattr(r, name) for r in singles))
    for name in ("friction", "max_normal_force", "strike_friction"):
        assert getattr(both, name) == pytest.approx(max(getattr(r, name) for r in singles))


def test_a_fall_is_reported_without_a_strike() -> None:
    report: ContactReport = contact_report(
        ROUND.params, ROUND.control, (-1.0, 0.2, 0.0, 0.0), strides=5
    )
    assert report.outcome == Outcome.FELL_BACKWARD
    assert report.strides == 1
    assert math.isnan(report.normal_impulse)
    assert not report.strike_pushes
    assert math.isfinite(report.min_normal_force)


def test_a_policy_is_a_control_too() -> None:
    assert ROUND.control is not None
    row = np.array([ROUND.control.switch_angle, ROUND.control.stall_torque])
    constant = contact_report(ROUND.params, ROUND.control, ROUND.state)
    policy = contact_report(
        ROUND.params, lambda states: np.tile(row, (len(states), 1)), ROUND.state
    )
    assert policy == constant


def test_silly_counts_are_named() -> None:
    with pytest.raises(ValueError, match="strides must be at least 1, got 0"):
        contact_report(ROUND.params, ROUND.control, ROUND.state, strides=0)
