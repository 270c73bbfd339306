"""Ground: clearance, landing, the switch and falls, against the walker's geometry."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.mechanics import ground
from powered_walker_env.model.phases import Guard, Outcome
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation import events
from powered_walker_env.simulation.lockstep import FALL
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.samples import (
    constants,
    derivative,
    landing_state,
    random_motion,
    random_walkers,
    relative,
)

FREE, LOCKED = False, True  # the ankle
THESIS = WalkerParams()
WATCHED = (Guard.SWITCH_ANGLE, Guard.LANDING)


def guard_at(guard: int, *arguments: Any) -> tuple[float, float]:
    """Value and rate of a guard as the kernel looks it up, of one walker, in plain Python."""
    locked, y, *rest = arguments
    plain = getattr(events.guard_at, "py_func", events.guard_at)  # compiled, or not at all
    value, rate = plain(int(guard), locked, y, None, *rest)  # no torque acts
    return value, rate


def locked_motion(rng: np.random.Generator, params: WalkerParams) -> Array:
    y = random_motion(rng)
    y[0], y[3] = y[1] - params.locked_ankle_angle, y[4]
    return y


def test_swing_foot_is_where_the_walkers_geometry_puts_it() -> None:
    rng = np.random.default_rng(1)
    for params in random_walkers(1, 100):
        y = random_motion(rng)
        position = d.kinematics(*relative(y), params).position
        up, forward = position[d.SWING_CENTRE] - position[d.CENTRE]
        foot = ground.swing_foot(*y[:3], constants(params))
        assert foot == pytest.approx(complex(up, forward), abs=1e-14 * params.leg_length)


def test_clearance_is_the_swing_foots_height_and_its_rate_the_foots_velocity() -> None:
    rng = np.random.default_rng(2)
    for params in random_walkers(2, 100):
        y = random_motion(rng)
        position, velocity = d.kinematics(*relative(y), params)
        height, rate = ground.clearance(y, constants(params))
        lowest = position[d.SWING_CENTRE, 0] - params.foot_radius
        assert height == pytest.approx(lowest, abs=1e-14 * params.leg_length)
        assert rate == pytest.approx(velocity[d.SWING_CENTRE, 0], abs=5e-14 * params.leg_length)


def test_clearance_of_locked_feet_is_the_landing_factor_times_the_passing_factor() -> None:
    """−2|K| sin((α − s)/2) sin((α + s)/2 + arg K), K = L + D e^{−i·lock}; so is its rate."""
    rng = np.random.default_rng(3)
    for params in random_walkers(3, 100):
        y = locked_motion(rng, params)
        foot = params.foot_length * cmath.exp(-1j * params.locked_ankle_angle)
        leg = 2 * abs(params.leg_length + foot)
        apart = 0.5 * (y[1] - y[2] + math.pi)
        passing, passing_rate = math.sin(apart), math.cos(apart) * 0.5 * (y[4] - y[5])
        factor, factor_rate = ground.locked_landing(y, constants(params))
        height, rate = ground.clearance(y, constants(params))
        assert leg * passing * factor == pytest.approx(height, abs=2e-15 * leg)
        product = leg * (passing_rate * factor + passing * factor_rate)
        assert product == pytest.approx(rate, abs=1e-14 * leg)


def test_landing_is_positive_before_the_strike_ahead_and_falls_through_zero_there() -> None:
    rng = np.random.default_rng(4)
    for params in random_walkers(4, 100, locked_ankle_angle=0.5 * math.pi):
        c = constants(params)
        y = landing_state(rng, params, locked=True)
        y[3:] = 1.0, 1.0, 0.5  # both legs fall forward: the foot comes down
        value, rate = ground.landing(LOCKED, y, 0.0, c)
        assert value == pytest.approx(0, abs=1e-14)
        assert rate < 0
        earlier, _ = ground.landing(LOCKED, y - 1e-3 * np.array([*y[3:], 0, 0, 0]), 0.0, c)
        assert earlier > 0
        assert ground.legs_have_passed(y)


def test_locked_landing_does_not_vanish_where_the_feet_pass_each_other() -> None:
    rng = np.random.default_rng(5)
    for params in random_walkers(5, 50, locked_ankle_angle=0.5 * math.pi):
        alpha = rng.uniform(-0.3, 0.1)
        foot = alpha - params.locked_ankle_angle
        together = np.array([foot, alpha, alpha + math.pi, 0.5, 0.5, -0.5])
        c = constants(params)
        expected = cmath.phase(params.leg_length - 1j * params.foot_length)
        value, _ = ground.landing(LOCKED, together, 0.0, c)
        assert ground.clearance(together, c)[0] == pytest.approx(0, abs=1e-15)
        assert value == pytest.approx(-math.sin(alpha + expected), abs=1e-15)


def test_landing_of_a_free_ankle_or_on_a_step_is_the_height_above_that_ground() -> None:
    rng = np.random.default_rng(6)
    for params in random_walkers(6, 50):
        c, L = constants(params), params.leg_length
        y, step = random_motion(rng), rng.uniform(0.01, 0.1)
        height, speed = ground.clearance(y, c)
        flat = (height / L, speed / L)
        assert ground.landing(FREE, y, 0.0, c) == pytest.approx(flat, rel=1e-15)
        for locked in (FREE, LOCKED):
            value, rate = ground.landing(locked, y, step, c)
            assert (value, rate) == pytest.approx(((height - step) / L, speed / L), rel=1e-14)


def test_switch_is_the_fall_of_the_hip_angle_to_the_switch_angle() -> None:
    y = np.array([-2.0, 0.1, 3.2, 0.3, 0.3, -0.4])
    guard = guard_at(Guard.SWITCH_ANGLE, LOCKED, y, 2.9, 0.0, constants(THESIS))
    assert guard == pytest.approx((3.1 - 2.9, -0.7), rel=1e-12)


def test_guards_of_a_landing_and_of_a_fall_are_the_landing_and_the_fall() -> None:
    rng = np.random.default_rng(7)
    c = constants(THESIS)
    for locked in (FREE, LOCKED):
        y = random_motion(rng)
        landing = guard_at(Guard.LANDING, locked, y, 2.9, 0.02, c)
        assert landing == ground.landing(locked, y, 0.02, c)
        assert guard_at(FALL, locked, y, 2.9, 0.02, c) == ground.upright(locked, y, c)


@pytest.mark.parametrize("locked", [LOCKED, FREE])
def test_rates_of_all_guards_are_the_derivatives_of_their_values(locked: bool) -> None:
    rng = np.random.default_rng(8)
    for params in random_walkers(8, 50):
        c = constants(params)
        y = random_motion(rng)
        motion = np.concatenate([y[3:], np.zeros(3)])
        for guard in WATCHED:
            arguments = (2.9, 0.05, c)

            def value(state: Array, guard: Guard = guard, arguments: Any = arguments) -> float:
                return guard_at(guard, locked, state, *arguments)[0]

            rate = guard_at(guard, locked, y, *arguments)[1]
            assert rate == pytest.approx(derivative(value, y, motion), abs=1e-11)


def test_rate_of_uprightness_is_its_derivative_away_from_its_corners() -> None:
    rng = np.random.default_rng(9)
    checked = 0
    for params in random_walkers(9, 200):
        c = constants(params)
        y = random_motion(rng)
        motion = np.concatenate([y[3:], np.zeros(3)])
        for locked in (FREE, LOCKED):
            rates = [ground.upright(locked, y + h * motion, c)[1] for h in (-2e-3, 0, 2e-3)]
            if max(np.abs(np.diff(rates))) > 0.1:  # the least of its terms changes here
                continue
            slope = derivative(lambda s, k=locked, c=c: ground.upright(k, s, c)[0], y, motion)
            assert rates[1] == pytest.approx(slope, abs=1e-11)
            checked += 1
    assert checked > 300


def test_legs_have_passed_once_the_swing_ankle_is_ahead() -> None:
    assert not ground.legs_have_passed(np.array([0, -0.2, 0.2 + math.pi, 0, 0, 0]))
    assert ground.legs_have_passed(np.array([0, 0.2, math.pi - 0.2, 0, 0, 0]))


def standing(**changes: float) -> Array:
    """Near the thesis's gait, the foot at its stop."""
    angles = {"phi": -2.2, "alpha": 0.1, "beta": math.pi - 0.1} | changes
    return np.array([angles["phi"], angles["alpha"], angles["beta"], 0.5, 0.5, 0.5])


def test_walker_in_mid_stride_is_upright_in_both_modes() -> None:
    for locked in (FREE, LOCKED):
        assert ground.upright(locked, standing(), constants(THESIS))[0] > 0.1


HALF = 0.5 * math.pi
FALLS = [
    (LOCKED, {"alpha": HALF, "phi": 0.0}, Outcome.FELL_FORWARD),
    (FREE, {"alpha": HALF, "phi": 0.0}, Outcome.FELL_FORWARD),
    (LOCKED, {"alpha": -HALF, "phi": 0.0}, Outcome.FELL_BACKWARD),
    (LOCKED, {"beta": HALF}, Outcome.SWING_LEG_HORIZONTAL),
    (LOCKED, {"beta": 3 * HALF}, Outcome.SWING_LEG_HORIZONTAL),
    (FREE, {"phi": HALF}, Outcome.FOOT_ROLLED_OVER),
    (FREE, {"phi": -math.pi}, Outcome.FOOT_FELL_BACK),
    (LOCKED, {"phi": -math.pi, "alpha": math.acos(0.05)}, Outcome.HIP_BELOW_FLOOR),
]


@pytest.mark.parametrize(("locked", "angles", "outcome"), FALLS)
def test_each_fall_is_where_uprightness_vanishes_and_has_its_name(
    locked: bool, angles: dict[str, float], outcome: Outcome
) -> None:
    c = constants(THESIS)
    y = standing(**angles)
    assert ground.upright(locked, y, c)[0] == pytest.approx(0, abs=1e-15)
    assert ground.name_fall(locked, y, c) == outcome


def test_foot_over_its_ankle_is_no_fall_while_it_is_locked() -> None:
    for phi in (HALF, 2.0, -math.pi):
        assert ground.upright(LOCKED, standing(phi=phi), constants(THESIS))[0] > 0.1


def test_foot_may_point_anywhere_but_into_the_quarter_under_and_ahead_of_its_centre() -> None:
    for phi in np.linspace(-math.pi, math.pi, 100)[1:-1]:
        upright = ground.upright(FREE, standing(phi=phi), constants(THESIS))[0] > 0
        assert upright == (phi < HALF)


def test_hip_is_below_the_floor_of_a_round_foot_later_than_of_a_point_foot() -> None:
    low = standing(phi=-math.pi, alpha=math.acos(0.05))
    for radius in (0.1, 0.3):
        round_foot = constants(THESIS.replace(foot_radius=radius))
        height = ground.upright(LOCKED, low, round_foot)[0]
        assert height == pytest.approx(min(radius, 0.05), abs=1e-15)  # or the leg's cosine
