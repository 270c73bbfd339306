"""Knees: the phases they add, the bent chain against Kane's method, knee strike against momenta."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator

import numpy as np
import pytest

from powered_walker_env.model.knees import bent, encoded
from powered_walker_env.model.mechanics import chain, ground, guards, locking
from powered_walker_env.model.mechanics.actuation import accelerations_at, drive
from powered_walker_env.model.mechanics.chain import Pose
from powered_walker_env.model.mechanics.packing import chains_of
from powered_walker_env.model.phases import (
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
)
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.model.walker import WalkerParams
from tests.helpers import kneed
from tests.helpers.derivation import Array
from tests.helpers.samples import constants, kneed_walkers, sprung

KNEE_FREE = Joints.KNEE_FREE
#: (φ, θ, β) and rates from the relative (q1, q3, q4): φ, φ + lock + q3, φ + lock + q3 + q4.
TO_ABSOLUTE = np.tril(np.ones((3, 3)))


def draws(seed: int, number: int = 60) -> Iterator[tuple[WalkerParams, Array, Array]]:
    """Walkers with knees, and (q1, q3, q4) with their rates, anywhere."""
    rng = np.random.default_rng(seed)
    for params in kneed_walkers(seed, number):
        q = rng.uniform(-math.pi, math.pi, 3)
        yield sprung(params, rng), q, rng.uniform(-3.0, 3.0, 3)


def pose_of(q: Array, u: Array, params: WalkerParams) -> Pose:
    """The pose, its stance ankle locked."""
    lock = params.locked_ankle_angle
    phi, theta, beta = TO_ABSOLUTE @ q + [0.0, lock, lock]
    dphi, dtheta, dbeta = TO_ABSOLUTE @ u
    straight = chain.pose_of(phi, phi + lock, beta, dphi, dphi, dbeta)
    return chain.bent(straight, theta, dtheta, cmath.exp(1j * theta))


def close(ours: object, theirs: object, tolerance: float) -> None:
    """Within `tolerance` of the second one's length."""
    assert np.linalg.norm(np.subtract(ours, theirs)) <= tolerance * np.linalg.norm(theirs)  # type: ignore[arg-type]


def test_accelerations_with_a_free_knee_are_those_of_kanes_method() -> None:
    rng = np.random.default_rng(1)
    for params, q, u in draws(1):
        weight = params.leg_mass * params.gravity * params.leg_length
        pull = rng.uniform(-1, 1) * weight
        matrix, forcing = kneed.bent_system(q, u, params, -pull)
        found = accelerations_at(
            pose_of(q, u, params), KNEE_FREE, drive(Torque.HIP, pull), chains_of(params),
            constants(params),
        )  # fmt: skip
        rounding = 1e-14 * np.linalg.cond(matrix)
        expected = TO_ABSOLUTE @ np.linalg.solve(matrix, forcing)
        close([found.phi, found.theta, found.beta], expected, rounding)
        assert found.alpha == found.phi


def test_energy_with_a_free_knee_is_that_of_the_bodies() -> None:
    for params, q, u in draws(2):
        at, c = pose_of(q, u, params), constants(params)
        ours = chain.energy(at, chains_of(params).bent, c)
        theirs = kneed.energy(q, u, params)
        scale = params.leg_mass * params.gravity * params.leg_length
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12 * scale)


def test_a_locked_knee_leaves_the_straight_walker_to_rounding() -> None:
    """Rows and columns of thigh and shank added up are those of the leg, for any split."""
    for params, q, u in draws(3):
        straight_q, straight_u = q * [1, 1, 0], u * [1, 1, 0]
        at, c, chains = (
            pose_of(straight_q, straight_u, params),
            constants(params),
            chains_of(params),
        )
        m = chain.mass_matrix_at(at, chains.bent, c)
        leg = chain.mass_matrix(
            chain.couplings(at.foot, at.stance, at.swing, chains.locked, c), chains.locked, c
        )
        size = abs(leg.m11) + abs(leg.m33)
        assert m.m11 == pytest.approx(leg.m11, abs=1e-14 * size)
        assert m.m12 + m.m13 == pytest.approx(leg.m13, abs=1e-14 * size)
        assert m.m22 + 2 * m.m23 + m.m33 == pytest.approx(leg.m33, abs=1e-14 * size)
        bare = params.replace(knee=None)
        assert chain.energy(at, chains.bent, c) == pytest.approx(
            chain.energy(at, chains_of(bare).free, constants(bare)), rel=1e-12, abs=1e-12 * size
        )
        assert ground.swing_foot(at, c) == pytest.approx(
            ground.swing_foot(at, constants(bare)), abs=1e-14 * params.leg_length
        )


def test_knee_strike_keeps_the_walker_s_momentum_and_the_swing_leg_s() -> None:
    for params, q, u in draws(4):
        straight_q, c, chains = q * [1, 1, 0], constants(params), chains_of(params)
        struck = locking.knee_caught(pose_of(straight_q, u, params), chains.locked, chains.bent, c)
        after = np.array([struck.dphi, struck.dtheta - struck.dphi, struck.dbeta - struck.dtheta])
        close(after, kneed.knee_strike(straight_q, u, params), 1e-10)
        close(
            kneed.kept_at_knee_strike(straight_q, after, params),
            kneed.kept_at_knee_strike(straight_q, u, params),
            1e-12,
        )
        lost = kneed.energy(straight_q, u, params) - kneed.energy(straight_q, after, params)
        kinetic = chain.kinetic_energy(pose_of(straight_q, u, params), chains.bent, c)
        assert lost >= -1e-12 * kinetic
        assert struck.dalpha == struck.dphi


def test_knee_strike_of_links_that_turn_together_changes_nothing() -> None:
    for params, q, u in draws(5, 20):
        together = pose_of(q * [1, 1, 0], u * [1, 1, 0], params)
        chains, c = chains_of(params), constants(params)
        struck = locking.knee_caught(together, chains.locked, chains.bent, c)
        close([struck.dphi, struck.dbeta], [together.dphi, together.dbeta], 1e-11)


def test_the_swing_foot_is_where_thigh_and_shank_put_it() -> None:
    for params, q, u in draws(6):
        at, c, knee = pose_of(q, u, params), constants(params), params.knee
        assert knee is not None
        thigh = params.leg_length - knee.shank_length
        foot = params.foot_length * cmath.exp(1j * (at.beta - params.locked_ankle_angle))
        expected = (
            params.foot_length * at.foot + params.leg_length * at.stance
            + thigh * at.thigh + knee.shank_length * at.swing + foot
        )  # fmt: skip
        assert ground.swing_foot(at, c) == pytest.approx(expected, abs=1e-14 * params.leg_length)
        height, rate = ground.clearance(at, c)
        assert height == pytest.approx(expected.real, abs=1e-14 * params.leg_length)
        ahead, behind = (
            ground.clearance(pose_of(q + h * u, u, params), c)[0] for h in (1e-6, -1e-6)
        )
        assert rate == pytest.approx((ahead - behind) / 2e-6, abs=1e-7 * params.leg_length)


def test_the_knee_s_guard_is_up_while_the_shank_hangs_back() -> None:
    params, q, u = next(draws(7))
    for flexion, up in ((0.1, True), (1.5, True), (3.0, True), (-0.1, False), (3.3, False)):
        at = pose_of(np.array([q[0], q[1], flexion]), u, params)
        assert (guards.knee(at) > 0.0) == up
        assert guards.knee(at) == pytest.approx(math.sin(flexion), abs=1e-14)


def test_a_bent_leg_switches_and_falls_by_its_thigh() -> None:
    params, q, u = next(draws(8))
    at = pose_of(q, u, params)
    assert guards.switch(at, 2.9) == pytest.approx(q[1] - 2.9, abs=1e-14)
    assert guards.swing_leg_up(at) == pytest.approx(-math.cos(at.theta), abs=1e-14)


# The phases.


def free(name: str) -> Phase:
    """A phase of some scheme's cycle that has a free knee."""
    return next(p for s in SCHEMES.values() for p in encoded(s.cycle).phases if p.name == name)


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_begins_with_a_free_knee_and_goes_on_as_it_is(name: str) -> None:
    cycle = SCHEMES[name].cycle
    phases, code = encoded(cycle)
    assert phases[: len(cycle)] == cycle
    first = phases[len(cycle)]
    assert first.name == bent(cycle[0].name)
    assert code[0, 2] == len(cycle)
    for twin in phases[len(cycle) :]:
        assert twin.joints == KNEE_FREE
        assert twin.torque != Torque.MOTOR
        strike = twin.exits[0]
        assert (strike.guard, strike.reset) == (Guard.KNEE_STRIKE, Reset.KNEE_STRIKE)
        assert bent(str(strike.to)) == twin.name
        landed = [way for way in twin.exits if way.guard == Guard.LANDING]
        assert [way.to for way in landed] == [Outcome.LANDED_ON_BENT_KNEE]


def test_the_motor_may_not_start_before_knee_strike_and_a_hip_torque_may_end() -> None:
    early = {way.guard: way.to for way in free("swing, knee free").exits}
    assert early[Guard.SWITCH_ANGLE] == Outcome.MOTOR_BEFORE_KNEE_STRIKE
    pulled = {way.guard: way.to for way in free("pulled, knee free").exits}
    assert pulled[Guard.SWITCH_ANGLE] == "coasting, knee free"
    assert free("coasting, knee free").exits[0].to == "coasting"


def test_a_cycle_that_begins_with_the_ankle_free_has_no_twin() -> None:
    landing = (Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),)
    cycle = (Phase("loose", Joints.ANKLE_FREE, Torque.NONE, landing),)
    assert encoded(cycle).phases == cycle
