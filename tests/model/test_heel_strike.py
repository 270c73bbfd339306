"""Heel strike: the conserving one against a momentum balance of points in the plane.

The balance is that of `tests/helpers/impacts.py`: no mass matrix, no leg swap.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.mechanics import heel_strike as mechanics
from powered_walker_env.model.walker import WalkerParams
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.impacts import (
    Moving,
    after,
    before,
    kinetic,
    momentum_about,
    momentum_of_trailing_leg,
)
from tests.helpers.published import LIMIT_CYCLES, LimitCycle
from tests.helpers.samples import (
    constants,
    free_chain,
    landing_state,
    pose,
    random_motion,
    random_walkers,
    relative,
    state_of,
)


def heel_strike(y: Any, params: WalkerParams) -> Array:
    """(φ, α, β, φ', α', β') after the package's heel strike."""
    return state_of(mechanics.heel_strike(pose(y), free_chain(params), constants(params)))


def strikes(seed: int, number: int = 200) -> Iterator[tuple[WalkerParams, Array, Array]]:
    """Random walkers landing on flat ground: params, state before and state after."""
    rng = np.random.default_rng(seed)
    for params in random_walkers(seed, number):
        y = landing_state(rng, params)
        yield params, y, heel_strike(y, params)


def test_random_landings_touch_the_floor_ahead_of_the_stance_foot() -> None:
    for params, y, _ in strikes(1):
        position = d.kinematics(*relative(y), params).position
        height = position[d.SWING_CENTRE, 0] - params.foot_radius
        assert height == pytest.approx(0, abs=1e-14 * params.leg_length)
        assert position[d.SWING_ANKLE, 1] > position[d.ANKLE, 1]


def test_legs_swap_places_and_no_point_moves() -> None:
    for params, y, new in strikes(2):
        walker, contact = before(y, params)
        position = d.kinematics(*relative(new), params).position
        rolled = np.array([0, params.foot_radius * new[0]])  # its origin is where φ would be 0
        swapped = position - rolled + contact
        assert swapped[d.HIP] == pytest.approx(walker.hip, abs=1e-14)
        assert swapped[d.STANCE_LEG] == pytest.approx(walker.lead, abs=1e-14)
        assert swapped[d.SWING_LEG] == pytest.approx(walker.trail, abs=1e-14)


def test_new_stance_foot_is_locked_and_turns_about_its_contact_point() -> None:
    for params, y, new in strikes(3):
        assert new[1] - new[0] == pytest.approx(params.locked_ankle_angle, abs=1e-14)
        assert new[3] == new[4]
        walker = after(*before(y, params), new[4], new[5])
        velocity = d.kinematics(*relative(new), params).velocity
        scale = 1e-14 * (1 + np.abs(new[3:]).max())
        assert velocity[d.HIP] == pytest.approx(walker.hip_velocity, abs=scale)
        assert velocity[d.SWING_LEG] == pytest.approx(walker.trail_velocity, abs=scale)


def test_angular_momentum_of_the_walker_about_the_new_contact_point_is_kept() -> None:
    for params, y, new in strikes(4):
        walker, contact = before(y, params)
        scale = math.sqrt(kinetic(walker, params) * params.leg_mass) * params.leg_length
        kept = momentum_about(contact, after(walker, contact, new[4], new[5]), params)
        expected = momentum_about(contact, walker, params)
        assert kept == pytest.approx(expected, abs=1e-14 * scale)


def test_angular_momentum_of_the_trailing_leg_about_the_hip_is_kept() -> None:
    for params, y, new in strikes(5):
        walker, contact = before(y, params)
        scale = math.sqrt(kinetic(walker, params) * params.leg_mass) * params.leg_length
        kept = momentum_of_trailing_leg(after(walker, contact, new[4], new[5]), params)
        expected = momentum_of_trailing_leg(walker, params)
        assert kept == pytest.approx(expected, abs=1e-14 * scale)


def test_kinetic_energy_never_rises_and_what_is_lost_is_that_of_the_velocity_jump() -> None:
    """Carnot's theorem: true of a plastic impact, and of no other, at any height of ground."""
    rng = np.random.default_rng(6)
    on_steps = ((p, random_motion(rng)) for p in random_walkers(6, 200))
    states = [(p, y) for p, y, _ in strikes(6)] + list(on_steps)
    for params, y in states:
        new = heel_strike(y, params)
        walker, contact = before(y, params)
        struck = after(walker, contact, new[4], new[5])
        jump = Moving(*walker[:3], *(b - a for a, b in zip(walker[3:], struck[3:], strict=True)))
        energy = kinetic(walker, params)
        lost = energy - kinetic(struck, params)
        assert lost >= 0
        assert lost == pytest.approx(kinetic(jump, params), abs=2e-14 * energy)


def test_strike_of_legs_that_swing_together_as_one_body_changes_nothing() -> None:
    rng = np.random.default_rng(7)
    for params in random_walkers(7, 50):
        angle, rate = rng.uniform(-1, 1, 2)
        foot = angle - params.locked_ankle_angle
        y = np.array([foot, angle, angle + math.pi, rate, rate, rate])
        assert heel_strike(y, params) == pytest.approx(y, rel=1e-13)


def test_strike_without_feet_is_that_of_goswamis_compass_gait() -> None:
    """Goswami, Thuilot and Espiau 1998: Q⁻ θ'⁻ = Q⁺ θ'⁺, with (swing, stance) rates."""
    rng = np.random.default_rng(8)
    for _ in range(50):
        a, b, m, hip = rng.uniform(0.2, 2.0, 4)  # m: each leg's, a above the foot; hip: both's
        length = a + b
        params = WalkerParams.from_composite_leg(
            hip_mass=hip / 2,
            frame_mass=m,
            frame_com_along=a,
            frame_inertia=0.0,
            leg_length=length,
            foot_length=0.0,
            locked_ankle_angle=math.pi,
        )
        half, stance_rate, swing_rate = rng.uniform(0.1, 0.6), *rng.uniform(-1, 1, 2)
        cosine = math.cos(2 * half)
        rows = [[-m * a * b, (hip * length**2 + 2 * m * a * length) * cosine - m * a * b]]
        minus = np.array([*rows, [0, -m * a * b]])
        swing_column = [m * b * (b - length * cosine), m * b**2]
        stance = m * length * (length - b * cosine) + m * a**2 + hip * length**2
        plus = np.array([swing_column, [stance, -m * b * length * cosine]]).T
        expected = np.linalg.solve(plus, minus @ [swing_rate, stance_rate])

        y = (half - math.pi, half, math.pi - half, stance_rate, stance_rate, swing_rate)
        new = heel_strike(y, params)
        assert [new[5], new[4]] == pytest.approx(expected, abs=1e-13)


def test_hip_much_heavier_than_the_feet_gives_garcias_heel_strike() -> None:
    """Garcia et al. 1998: the hip keeps cos 2θ of its speed."""
    ratio = 1e-6  # foot to hip; what it leaves out is of this order
    params = WalkerParams.from_composite_leg(
        hip_mass=0.5, foot_mass=ratio, foot_length=0.0, locked_ankle_angle=math.pi
    )
    for theta in (0.05, 0.2, 0.35):
        y = (theta - math.pi, theta, math.pi - theta, 0.4, 0.4, 0.3)
        new = heel_strike(y, params)
        kept = math.cos(2 * theta)
        assert new[4] == pytest.approx(0.4 * kept, abs=ratio)
        assert new[5] - new[4] == pytest.approx(-0.4 * kept * (1 - kept), abs=ratio)


def momentum_rounding(cycle: LimitCycle) -> float:
    """How well the reference knows the swing rate after the strike, rad/s.

    The trailing leg's mass lies 1 mm under the hip. That arm was taken as the difference of two
    vectors of 1 m, each rounded; times the momentum of 1001 kg it gives 1e-13 of the leg's
    1 kg m² rad/s. In exact arithmetic the worst of these gaits ends 1.28e-13 off the rate in
    its file.
    """
    p = cycle.params
    speed = p.leg_length * abs(sum(cycle.pre_heelstrike[3:5]))  # of the hip about the ankle
    inertia = p.leg_inertia + p.leg_mass * (p.leg_length - p.com_along) ** 2
    return 2.0 * math.ulp(0.5 * p.leg_length) * p.leg_mass * speed / inertia


@pytest.mark.parametrize("cycle", LIMIT_CYCLES, ids=str)
def test_reference_gaits_strike_the_floor_as_they_should(cycle: LimitCycle) -> None:
    """Both physics: the state before each strike goes over into the state after it."""
    q, u = np.array(cycle.pre_heelstrike[:3]), np.array(cycle.pre_heelstrike[3:])
    y = np.concatenate([d.TO_ABSOLUTE @ q, d.TO_ABSOLUTE @ u])
    angles, rates = relative(heel_strike(y, cycle.params))
    turns = (angles[2] - cycle.post_heelstrike[2]) / (2 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-14)
    assert angles[:2] == pytest.approx(cycle.post_heelstrike[:2], abs=1e-14)
    assert rates[:2] == pytest.approx(cycle.post_heelstrike[3:5], abs=1e-14)
    assert rates[2] == pytest.approx(cycle.post_heelstrike[5], abs=momentum_rounding(cycle))
