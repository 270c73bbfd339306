"""Ground: the swing foot's place, clearance, and what is a landing, against geometry."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from powered_walker_env.model.mechanics import ground
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.samples import (
    constants,
    derivative,
    landing_state,
    locked_motion,
    pose,
    random_motion,
    random_walker,
    random_walkers,
    relative,
)

FREE, LOCKED = ground.Held(False, True), ground.Held(True, True)  # the ankle, the knee
TOGETHER = 1e-4


def last_factor(y: Array, params: object) -> float:
    return float(ground.last_factor(pose(y), constants(params)))  # type: ignore[arg-type]


def motion(y: Array) -> Array:
    """The rates of the angles, and none of the rates."""
    return np.array([*y[3:], 0.0, 0.0, 0.0])


def test_swing_foot_is_where_the_walkers_geometry_puts_it() -> None:
    rng = np.random.default_rng(1)
    for params in random_walkers(1, 100):
        y = random_motion(rng)
        position = d.kinematics(*relative(y), params).position
        up, forward = position[d.SWING_CENTRE] - position[d.CENTRE]
        foot = ground.swing_foot(pose(y), constants(params))
        assert foot == pytest.approx(complex(up, forward), abs=1e-14 * params.leg_length)


def test_clearance_is_the_swing_foots_height_and_its_rate_the_foots_velocity() -> None:
    rng = np.random.default_rng(2)
    for params in random_walkers(2, 100):
        y = random_motion(rng)
        position, velocity = d.kinematics(*relative(y), params)
        height, rate = ground.clearance(pose(y), constants(params))
        lowest = position[d.SWING_CENTRE, 0] - params.foot_radius
        assert height == pytest.approx(lowest, abs=1e-14 * params.leg_length)
        assert rate == pytest.approx(velocity[d.SWING_CENTRE, 0], abs=5e-14 * params.leg_length)


def test_the_contact_point_travels_from_foot_to_foot_and_by_rolling() -> None:
    rng = np.random.default_rng(10)
    for params in random_walkers(10, 50):
        y, first = random_motion(rng), rng.uniform(-1, 1)
        position = d.kinematics(*relative(y), params).position  # from where φ would be 0
        way = position[d.SWING_CENTRE, 1] - params.foot_radius * first
        found = ground.travel(pose(y), first, constants(params))
        assert found == pytest.approx(way, abs=1e-14 * params.leg_length)


@pytest.mark.parametrize("wheel", [False, True], ids=["feet locked", "no foot's length"])
def test_clearance_is_the_last_factor_times_the_passing_factor(wheel: bool) -> None:
    """−2|K| sin((α − s)/2) sin((α + s)/2 + arg K), K = L + D e^{−i·lock}; so is its rate. With
    both feet locked, and for a foot without length whatever its ankle does."""
    rng = np.random.default_rng(3)
    for params in random_walkers(3, 100, **({"foot_length": 0.0} if wheel else {})):
        y = random_motion(rng) if wheel else locked_motion(rng, params)
        foot = params.foot_length * cmath.exp(-1j * params.locked_ankle_angle)
        leg = 2 * abs(params.leg_length + foot)
        apart = 0.5 * (y[1] - y[2] + math.pi)
        assert ground.apart(pose(y)) == pytest.approx(2 * apart, abs=1e-15)
        passing, passing_rate = math.sin(apart), math.cos(apart) * 0.5 * (y[4] - y[5])
        factor = last_factor(y, params)
        factor_rate = derivative(lambda s, p=params: last_factor(s, p), y, motion(y))
        height, rate = ground.clearance(pose(y), constants(params))
        assert leg * passing * factor == pytest.approx(height, abs=2e-15 * leg)
        product = leg * (passing_rate * factor + passing * factor_rate)
        assert product == pytest.approx(rate, abs=1e-11 * leg)
        assert ground.factorises(FREE if wheel else LOCKED, constants(params))


def test_a_free_ankle_under_a_foot_of_some_length_has_no_such_factor() -> None:
    c = constants(random_walker(np.random.default_rng(11)))
    assert not ground.factorises(FREE, c)
    assert ground.factorises(LOCKED, c)


def test_height_is_positive_before_the_strike_ahead_and_falls_through_zero_there() -> None:
    rng = np.random.default_rng(4)
    for params in random_walkers(4, 100, locked_ankle_angle=0.5 * math.pi):
        c = constants(params)
        y = landing_state(rng, params, locked=True)
        y[3:] = 1.0, 1.0, 0.5  # both legs fall forward: the foot comes down

        def height(state: Array, c: object = c) -> float:
            return float(ground.height_over_ground(LOCKED, pose(state), 0.0, c))

        assert height(y) == pytest.approx(0, abs=1e-14)
        rate = derivative(height, y, motion(y))
        assert rate < 0
        assert height(y - 1e-3 * motion(y)) > 0
        assert ground.lands(LOCKED, pose(y), rate, 0.0, c)


def test_height_of_locked_feet_does_not_vanish_where_they_pass_each_other() -> None:
    rng = np.random.default_rng(5)
    for params in random_walkers(5, 50, locked_ankle_angle=0.5 * math.pi):
        alpha = rng.uniform(-0.3, 0.1)
        foot = alpha - params.locked_ankle_angle
        together = pose([foot, alpha, alpha + math.pi, 0.5, 0.5, -0.5])
        c = constants(params)
        expected = cmath.phase(params.leg_length - 1j * params.foot_length)
        value = ground.height_over_ground(LOCKED, together, 0.0, c)
        assert ground.clearance(together, c)[0] == pytest.approx(0, abs=1e-15)
        assert value == pytest.approx(-math.sin(alpha + expected), abs=1e-15)


def test_height_with_a_free_ankle_or_over_a_step_is_that_above_that_ground() -> None:
    rng = np.random.default_rng(6)
    for params in random_walkers(6, 50):
        c, L = constants(params), params.leg_length
        at, step = pose(random_motion(rng)), rng.uniform(0.01, 0.1)
        height, _ = ground.clearance(at, c)
        level = ground.height_over_ground(FREE, at, 0.0, c)
        assert level == pytest.approx(height / L, rel=1e-15)
        for held in (FREE, LOCKED):
            value = ground.height_over_ground(held, at, step, c)
            assert value == pytest.approx((height - step) / L, rel=1e-14)


def test_legs_have_passed_once_the_stance_leg_is_ahead_in_angle() -> None:
    assert ground.apart(pose([0, -0.2, 0.2 + math.pi, 0, 0, 0])) < 0
    assert ground.apart(pose([0, 0.2, math.pi - 0.2, 0, 0, 0])) > 0


def test_a_foot_lands_ahead_of_the_other_and_not_beside_it() -> None:
    rng, landed = np.random.default_rng(7), 0
    for params in random_walkers(7, 300):
        y, c, L = landing_state(rng, params), constants(params), params.leg_length
        y[2] += rng.choice([0.0, 1.0]) * rng.uniform(-2e-3, 2e-3)
        at = pose(y)
        ahead, angle = ground.swing_foot(at, c).imag / L, y[1] - y[2] + math.pi
        expected = ahead > TOGETHER and angle > 0.0
        assert ground.lands(FREE, at, -1.0, TOGETHER, c) == expected
        # With a free ankle the last factor is no factor, and its rate is not asked.
        assert ground.lands(FREE, at, 1.0, TOGETHER, c) == expected
        assert ground.lands(LOCKED, at, -1.0, TOGETHER, c) == expected
        assert not ground.lands(LOCKED, at, 1.0, TOGETHER, c)  # the foot comes up
        landed += expected
    assert 50 < landed < 300


def test_legs_side_by_side_are_no_landing_at_any_tolerance() -> None:
    for params in random_walkers(8, 20):
        alpha = 0.2
        y = [alpha - params.locked_ankle_angle, alpha, alpha + math.pi, 1.0, 1.0, 0.5]
        for together in (0.0, 1e-7, TOGETHER):
            assert not ground.lands(LOCKED, pose(y), -1.0, together, constants(params))
