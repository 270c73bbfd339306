"""Guards: the table of what ends a phase, in plain Python; the falls by their names."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env.model.mechanics import ground, guards
from powered_walker_env.model.mechanics.actuation import Drive
from powered_walker_env.model.mechanics.chain import Pose
from powered_walker_env.model.mechanics.ground import Held
from powered_walker_env.model.mechanics.guards import FIRST_FALL, Aims
from powered_walker_env.model.mechanics.packing import chains_of
from powered_walker_env.model.phases import Guard, Outcome
from powered_walker_env.model.walker import WalkerParams
from tests.helpers.samples import constants, pose, random_motion, random_walkers

FREE, LOCKED = Held(ankle=False, knee=True), Held(ankle=True, knee=True)
THESIS = WalkerParams()
HALF = 0.5 * math.pi
FALLS = [guard for guard in Guard if guard >= FIRST_FALL]
NOTHING = Drive(0.0, 0.0)


def value(guard: Guard, held: Held, at: Pose, params: WalkerParams, step: float = 0.0) -> float:
    """Of a guard whose switch angle is 2.9 rad, where no torque acts."""
    aims, chains = Aims(2.9, step), chains_of(params)
    return float(guards.value_of(int(guard), held, at, NOTHING, aims, chains, constants(params)))


def upright(held: Held, at: Pose, params: WalkerParams) -> float:
    """The least of the guards against falls."""
    return min(value(guard, held, at, params) for guard in FALLS)


def test_every_guard_but_never_is_in_the_table_and_falls_come_last() -> None:
    assert [*FALLS] == [
        Guard.STANCE_LEG_DOWN, Guard.SWING_LEG_DOWN, Guard.HIP_DOWN, Guard.FOOT_TURNED
    ]  # fmt: skip
    assert list(Guard) == sorted(Guard)
    assert min(FALLS) == max(guard for guard in Guard if guard not in FALLS) + 1


def test_switch_is_the_fall_of_the_hip_angle_to_the_switch_angle() -> None:
    at = pose([-2.0, 0.1, 3.2, 0.3, 0.3, -0.4])
    assert value(Guard.SWITCH_ANGLE, LOCKED, at, THESIS) == pytest.approx(3.1 - 2.9, rel=1e-12)


def test_guard_of_a_landing_is_the_height_over_the_ground_ahead() -> None:
    rng = np.random.default_rng(7)
    for params in random_walkers(7, 20):
        for held in (FREE, LOCKED):
            at, step = pose(random_motion(rng)), rng.choice([0.0, 0.02])
            expected = ground.height_over_ground(held, at, step, constants(params))
            assert value(Guard.LANDING, held, at, params, step) == expected


def standing(**changes: float) -> Pose:
    """Near the thesis's gait, the foot at its stop."""
    angles = {"phi": -2.2, "alpha": 0.1, "beta": math.pi - 0.1} | changes
    return pose([angles["phi"], angles["alpha"], angles["beta"], 0.5, 0.5, 0.5])


def test_walker_in_mid_stride_is_upright_in_both_modes() -> None:
    for held in (FREE, LOCKED):
        assert upright(held, standing(), THESIS) > 0.1


NAMED = [
    (LOCKED, {"alpha": HALF, "phi": 0.0}, Guard.STANCE_LEG_DOWN, Outcome.FELL_FORWARD),
    (FREE, {"alpha": HALF, "phi": 0.0}, Guard.STANCE_LEG_DOWN, Outcome.FELL_FORWARD),
    (LOCKED, {"alpha": -HALF, "phi": 0.0}, Guard.STANCE_LEG_DOWN, Outcome.FELL_BACKWARD),
    (LOCKED, {"beta": HALF}, Guard.SWING_LEG_DOWN, Outcome.SWING_LEG_HORIZONTAL),
    (LOCKED, {"beta": 3 * HALF}, Guard.SWING_LEG_DOWN, Outcome.SWING_LEG_HORIZONTAL),
    (FREE, {"phi": HALF}, Guard.FOOT_TURNED, Outcome.FOOT_ROLLED_OVER),
    (FREE, {"phi": -math.pi}, Guard.FOOT_TURNED, Outcome.FOOT_FELL_BACK),
    (LOCKED, {"phi": -math.pi, "alpha": math.acos(0.05)}, Guard.HIP_DOWN, Outcome.HIP_BELOW_FLOOR),
]


@pytest.mark.parametrize(("held", "angles", "guard", "outcome"), NAMED)
def test_each_fall_is_where_its_guard_vanishes_and_has_its_name(
    held: Held, angles: dict[str, float], guard: Guard, outcome: Outcome
) -> None:
    at = standing(**angles)
    assert value(guard, held, at, THESIS) == pytest.approx(0, abs=1e-15)
    others = [value(other, held, at, THESIS) for other in FALLS if other != guard]
    assert min(others) > 0.04  # and no other's does
    assert guards.fall_outcome(int(guard), at.stance.imag, at.foot.imag) == outcome


def test_foot_over_its_ankle_is_no_fall_while_it_is_locked() -> None:
    for phi in (HALF, 2.0, -math.pi):
        assert upright(LOCKED, standing(phi=phi), THESIS) > 0.1


def test_foot_may_point_anywhere_but_into_the_quarter_under_and_ahead_of_its_centre() -> None:
    for phi in np.linspace(-math.pi, math.pi, 100)[1:-1]:
        up = value(Guard.FOOT_TURNED, FREE, standing(phi=phi), THESIS) > 0
        assert up == (upright(FREE, standing(phi=phi), THESIS) > 0) == (phi < HALF)


def test_hip_is_below_the_floor_of_a_round_foot_later_than_of_a_point_foot() -> None:
    low = standing(phi=-math.pi, alpha=math.acos(0.05))
    for radius in (0.1, 0.3):
        round_foot = THESIS.replace(foot_radius=radius)
        assert value(Guard.HIP_DOWN, LOCKED, low, round_foot) == pytest.approx(radius, abs=1e-15)
        least = upright(LOCKED, low, round_foot)
        assert least == pytest.approx(min(radius, 0.05), abs=1e-15)  # or the leg's cosine


def test_hip_of_a_walker_without_feet_is_down_with_its_stance_leg_alone() -> None:
    footless = THESIS.replace(foot_length=0.0)
    for alpha in (0.1, 1.5, 3.0):
        assert value(Guard.HIP_DOWN, LOCKED, standing(alpha=alpha), footless) == 1.0
