"""Actuation: the motor's torque–speed line, its power, and what drives each phase's flow."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env.model.mechanics import actuation
from powered_walker_env.model.mechanics.actuation import Drive, accelerations_at
from powered_walker_env.model.mechanics.chain import accelerations
from powered_walker_env.model.mechanics.packing import chains_of
from powered_walker_env.model.phases import Joints, Torque
from powered_walker_env.model.walker import WalkerParams
from tests.helpers import derivation
from tests.helpers.derivation import Array
from tests.helpers.samples import (
    as_published,
    constants,
    free_chain,
    locked_chain,
    locked_motion,
    pose,
    random_motion,
    random_walkers,
    relative,
    sprung,
)

STALL = 700.0
MOTOR = WalkerParams(no_load_speed=8.0)
EXTENDING = np.linspace(-12.0, -0.1, 30)  # u2, rad/s: extension makes q2 fall


def drive(torque: Torque, strength: float = STALL) -> Drive:
    return actuation.drive(torque, strength)


def torque_at(ankle_rate: float, params: WalkerParams = MOTOR) -> float:
    return float(actuation.ankle_torque(ankle_rate, drive(Torque.MOTOR), constants(params)))


def power_at(ankle_rate: float, torque: Torque = Torque.MOTOR) -> float:
    return float(actuation.power(pose(moving(ankle_rate)), drive(torque), constants(MOTOR)))


def moving(ankle_rate: float) -> Array:
    """A state whose ankle turns at `ankle_rate` = α' − φ'."""
    return np.array([-2.0, 0.1, 3.0, 0.3 - ankle_rate, 0.3, 0.4])


def flow(joints: Joints, torque: Torque, y: Array, strength: float, params: WalkerParams) -> Array:
    """y' of (φ, α, β, φ', α', β'); with the ankle locked the leg is no link of its own."""
    acting, c = drive(torque, strength), constants(params)
    if joints is Joints.ANKLE_FREE:
        return np.array(actuation.flow(y, acting, free_chain(params), c))
    of_chain = (y[0], 0.0, y[2], y[3], 0.0, y[5])
    d1, none, d3, dd1, still, dd3 = actuation.flow(of_chain, acting, locked_chain(params), c)
    assert none == still == 0.0
    return np.array([d1, d1, d3, dd1, dd1, dd3])


def test_motor_at_rest_gives_its_stall_torque() -> None:
    assert torque_at(0.0) == STALL
    assert torque_at(0.0, as_published(MOTOR)) == STALL


def test_motor_gives_no_torque_when_it_extends_at_its_no_load_speed() -> None:
    assert torque_at(-8.0) == 0.0


def test_torque_falls_on_a_straight_line_with_the_speed_of_extension() -> None:
    for speed in EXTENDING:
        assert torque_at(speed) == pytest.approx(STALL * (8.0 + speed) / 8.0, rel=1e-14, abs=1e-12)


def test_motor_driven_backwards_pushes_harder_than_at_rest() -> None:
    assert torque_at(4.0) == pytest.approx(1.5 * STALL, rel=1e-15)


def test_departure_3_the_listed_motor_pushes_harder_the_faster_it_extends() -> None:
    """`pow_qddt.m` takes u2 for the speed, which extension makes negative."""
    listed = [torque_at(speed, as_published(MOTOR)) for speed in EXTENDING]
    assert listed == pytest.approx([STALL * (1 - u2 / 8.0) for u2 in EXTENDING], rel=1e-14)
    assert min(listed) > STALL
    for torque, u2 in zip(listed, EXTENDING, strict=True):
        assert torque == pytest.approx(torque_at(-u2), rel=1e-14)  # the line of flexion
        assert torque + torque_at(u2) == pytest.approx(2 * STALL, rel=1e-14)


def test_power_is_the_torques_work_rate_on_foot_and_leg() -> None:
    for u2 in EXTENDING:
        y = moving(u2)
        assert power_at(u2) == pytest.approx(torque_at(u2) * (y[3] - y[4]), rel=1e-12)


def test_power_is_greatest_at_half_the_no_load_speed_and_a_quarter_of_stall_times_it() -> None:
    powers = [power_at(-speed) for speed in np.linspace(0.0, 8.0, 33)]
    assert int(np.argmax(powers)) == 16
    assert powers[16] == pytest.approx(STALL * 8.0 / 4, rel=1e-14)


def test_motor_brakes_beyond_its_no_load_speed() -> None:
    assert power_at(-10.0) < 0


def test_no_torque_and_no_power_where_the_phase_has_none() -> None:
    still = actuation.ankle_torque(-3.0, drive(Torque.NONE), constants(MOTOR))
    assert still == 0.0
    assert power_at(-3.0, Torque.NONE) == 0.0
    assert drive(Torque.NONE).pull == 0.0


def test_hip_torque_turns_the_swing_leg_forward_and_works_on_the_angle_between_the_legs() -> None:
    acting, y = drive(Torque.HIP, 30.0), moving(-3.0)
    assert acting.pull == -30.0  # β falls as the swing leg goes forward
    assert actuation.ankle_torque(-3.0, acting, constants(MOTOR)) == 0.0
    power = actuation.power(pose(y), acting, constants(MOTOR))
    assert power == pytest.approx(-30.0 * (y[5] - y[4]), rel=1e-15)


def test_hip_torque_and_spring_drive_kanes_equations_in_both_modes() -> None:
    rng = np.random.default_rng(4)
    for plain in random_walkers(4, 50):
        params, y = sprung(plain, rng), random_motion(rng)
        strength = plain.leg_mass * plain.gravity * plain.leg_length * rng.uniform(-1, 1)
        q, u = relative(y)
        matrix, forcing = derivation.powered_system(q, u, 0.0, params, -strength)
        expected = derivation.TO_ABSOLUTE @ np.linalg.solve(matrix, forcing)
        rounding = 1e-15 * np.linalg.cond(matrix) * np.abs(expected).max()
        free = flow(Joints.ANKLE_FREE, Torque.HIP, y, strength, params)
        assert free[3:] == pytest.approx(expected, abs=rounding)
        y[0], y[3] = y[1] - params.locked_ankle_angle, y[4]
        q, u = relative(y)
        du1, du3 = np.linalg.solve(*derivation.locked_system(q, u, params, -strength))
        locked = flow(Joints.ANKLE_LOCKED, Torque.HIP, y, strength, params)
        largest = np.hypot(du1, du1 + du3)
        assert locked[3:] == pytest.approx([du1, du1, du1 + du3], abs=5e-14 * largest)


def test_powered_flow_is_kanes_with_the_motors_torque() -> None:
    rng = np.random.default_rng(1)
    for plain in random_walkers(1, 50):
        stall = plain.leg_mass * plain.gravity * plain.leg_length * rng.uniform(0.1, 1)
        for params in (plain, as_published(plain)):
            y = random_motion(rng)
            q, u = relative(y)
            speed = u[1] if params is not plain else -u[1]
            torque = stall * (1 - speed / params.no_load_speed)
            matrix, forcing = derivation.powered_system(q, u, torque, params)
            expected = derivation.TO_ABSOLUTE @ np.linalg.solve(matrix, forcing)
            rate = flow(Joints.ANKLE_FREE, Torque.MOTOR, y, stall, params)
            rounding = 1e-15 * np.linalg.cond(matrix) * np.abs(expected).max()
            assert rate[:3] == pytest.approx(y[3:], abs=0)
            assert rate[3:] == pytest.approx(expected, abs=rounding)


def test_free_flow_without_torque_is_that_of_a_limp_ankle() -> None:
    rng = np.random.default_rng(2)
    for params in random_walkers(2, 20):
        y = random_motion(rng)
        rate = flow(Joints.ANKLE_FREE, Torque.NONE, y, STALL, params)
        limp = accelerations(y, 0.0, 0.0, free_chain(params), constants(params))
        assert rate == pytest.approx([*y[3:], *limp], abs=0)


def test_locked_flow_is_that_without_a_motor_bit_for_bit() -> None:
    """The ankle's torque is internal, and the locked chain has no ankle."""
    rng = np.random.default_rng(3)
    for params in random_walkers(3, 20):
        y = locked_motion(rng, params)
        still = flow(Joints.ANKLE_LOCKED, Torque.NONE, y, STALL, params)
        du1, du3 = np.linalg.solve(*derivation.locked_system(*relative(y), params))
        largest = np.hypot(du1, du1 + du3)
        assert still[3:] == pytest.approx([du1, du1, du1 + du3], abs=5e-14 * largest)
        pushed = flow(Joints.ANKLE_LOCKED, Torque.MOTOR, y, STALL, params)
        np.testing.assert_array_equal(pushed, still)


def test_accelerations_at_a_pose_are_those_of_the_flow() -> None:
    rng = np.random.default_rng(5)
    for params in random_walkers(5, 20):
        y, chains, c = locked_motion(rng, params), chains_of(params), constants(params)
        for torque in Torque:
            acting = drive(torque)
            for joints in (Joints.ANKLE_FREE, Joints.ANKLE_LOCKED):
                found = accelerations_at(pose(y), joints, acting, chains, c)
                expected = flow(joints, torque, y, STALL, params)[3:]
                assert (found.phi, found.alpha, found.beta) == tuple(expected)
                assert found.theta == found.beta
