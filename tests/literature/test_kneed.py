"""Kneed walkers of others: the steps behind printed digits, a free knee at heel strike, limits."""

from __future__ import annotations

import cmath
import math
from functools import cache

import numpy as np
import pytest

from powered_walker_env import PRESETS, Gait, PostStrikeState, WalkerParams, find_gait
from powered_walker_env.literature.values.euler import (
    STEP,
    chens_walker,
    stepped_gait,
    stepped_stride,
)
from powered_walker_env.literature.values.kneed import mcgeer_machine
from powered_walker_env.literature.values.published import PRINTED
from powered_walker_env.model.knee import Knee
from tests.helpers import kneed
from tests.helpers.derivation import Array, kinematics
from tests.helpers.published import PASSIVE_GAITS


def printed(name: str) -> str:
    return next(e.printed for e in PRINTED if (e.origin.family, e.name) == ("kneed", name))


@cache
def exact() -> Gait:
    """The gait of the program's walker, integrated well."""
    return find_gait(chens_walker(), None, PRESETS["chen2007"].state)


def test_euler_steps_of_a_millisecond_give_chen_s_printed_digits() -> None:
    state, slope = stepped_gait().state, chens_walker().slope
    found = {
        "q1": -state[0] - slope, "q2": -state[1] - slope, "q1_rate": -state[2],
        "q2_rate": -state[3], "interleg": state[1] - state[0],
    }  # fmt: skip
    assert {name: f"{value:.4f}" for name, value in found.items()} == {
        name: printed(name) for name in found
    }
    assert f"{slope:.4f}" == "0.0504"


def test_as_the_step_goes_to_zero_the_gait_is_ours_with_first_order() -> None:
    ours = np.array(exact().state)
    steps = (4 * STEP, 2 * STEP, STEP, 0.5 * STEP)
    errors = np.array([stepped_gait(step).state - ours for step in steps])[:, 1:]
    assert np.all((errors[:-1] / errors[1:] > 1.8) & (errors[:-1] / errors[1:] < 2.1))
    assert np.abs(2.0 * errors[3] - errors[2]).max() < 3e-4  # where the last two lead
    assert np.abs(errors[:, 1]).round(4).tolist() == [0.0279, 0.0146, 0.0075, 0.0038]
    multipliers = [stepped_gait(step).multipliers for step in steps[2:]]
    led_to = 2.0 * multipliers[1] - multipliers[0]
    assert np.abs(led_to - exact().multipliers[:3]).max() < 2e-3


def test_chen_s_pair_of_multipliers_is_near_that_of_two_stepped_strides() -> None:
    one = stepped_gait().multipliers
    assert one[[0, 2]].round(3).tolist() == [0.309 + 0.552j, 0.149]
    assert (one[[0, 2]] ** 2).round(3).tolist() == [-0.209 + 0.341j, 0.022]
    pair, real = complex(printed("pair")), complex(printed("real"))
    assert abs(one[0] ** 2 - pair) < 0.0065 < abs(one[0] - pair)
    assert min(abs(one[2] - real), abs(one[2] ** 2 - real)) > 0.2  # not explained


def test_a_stepped_stride_that_falls_says_so() -> None:
    with pytest.raises(ValueError, match="must lead to a knee strike and a landing within"):
        stepped_stride((-0.2, 0.2, 0.1, 0.0), chens_walker(), 4 * STEP)


def test_a_shank_that_weighs_nothing_leaves_the_compass_gait() -> None:
    """Massless, the shank swings and strikes without being felt: the leg is its thigh."""
    compass = next(gait for gait in PASSIVE_GAITS if gait.walker.startswith("compass"))
    missed = []
    for mass in (1e-3, 1e-5):
        knee = Knee(shank_length=0.5, shank_mass=mass, shank_com_along=0.375)
        gait = find_gait(compass.params.replace(knee=knee), None, compass.state)
        missed.append(np.abs(np.array(gait.state) - compass.state).max())
        assert gait.duration == pytest.approx(compass.step_duration, abs=10 * mass)
        assert gait.multipliers[0] == pytest.approx(compass.multipliers[0], abs=100 * mass)
    assert missed[1] == pytest.approx(missed[0] / 100, rel=0.01)


# McGeer's machine with its trailing knee free at heel strike. States are (α, α', θ', shank's
# rate); the swing leg is level with the stance leg's foot.


def machine() -> tuple[WalkerParams, float]:
    """The machine, and how far its line from foot to hip leans from the leg's."""
    params = mcgeer_machine()
    foot = params.foot_length * cmath.exp(-1j * params.locked_ankle_angle)
    return params, cmath.phase(params.leg_length + foot)


def struck(q: Array, u: Array, params: WalkerParams) -> Array:
    """The state after a heel strike that leaves three momenta: the walker's about the new
    contact point, the trailing leg's about the hip, the trailing shank's about the knee."""
    alpha = q[0] + q[1] + q[2] - math.pi
    after = np.array([alpha - params.locked_ankle_angle, q[0] + q[1] + math.pi - alpha, 0.0])
    rest = kneed.masses(after, np.zeros(3), params)
    thigh = q[0] + q[1] + math.pi
    split = kneed.segments(params)
    knee = rest.hip + split.d * np.array([math.cos(thigh), math.sin(thigh)])

    def kept(bodies: kneed.Masses) -> list[float]:
        about = ((rest.contact, [0, 1, 2]), (rest.hip, [1, 2]), (knee, [2]))
        return [kneed.momentum(point, bodies, which) for point, which in about]

    rates = np.array([u[0] + u[2], u[0], u[0]])  # leading leg; thigh and shank of the trailing one
    arms = rest.place - rest.hip
    turning = rates[:, np.newaxis] * np.column_stack([-arms[:, 1], arms[:, 0]])
    hip = kinematics(q, u, params).velocity[2]
    before = kept(rest._replace(velocity=hip + turning, rate=rates))
    columns = [kept(kneed.masses(after, one, params)) for one in np.eye(3)]
    u1, u3, u4 = np.linalg.solve(np.column_stack(columns), before)
    return np.array([alpha, u1, u1 + u3, u1 + u3 + u4])


def free_stride(x: Array) -> tuple[Array, float, float]:
    """State after a stride, and when the knee and the heel struck."""
    params, lean = machine()
    start = PostStrikeState(x[0], -x[0] - 2.0 * lean, x[1], x[2])
    t, q, u = kneed.bent_swing(start, params, flexing=x[3] - x[2])
    u1, u3, _ = kneed.knee_strike(q, u, params)
    landing = kneed.passive_landing(t, np.array([q[0], q[1], u1, u3]), params)
    return struck(landing.q, landing.u, params), t, landing.t


def test_with_the_trailing_knee_free_mcgeer_s_machine_comes_to_his_multipliers() -> None:
    said = np.array([-0.26516, 0.36667, -0.06457, 0.70192])
    nudges = 1e-4 * np.eye(4)
    ends = [(free_stride(said + d)[0], free_stride(said - d)[0]) for d in nudges]
    jacobian = np.column_stack([(up - down) / 2e-4 for up, down in ends])
    missed = free_stride(said)[0] - said
    x = said - np.linalg.solve(jacobian - np.eye(4), missed)  # a step of Newton's
    after, knee, heel = free_stride(x)
    assert after == pytest.approx(x, abs=1e-8)
    assert x == pytest.approx(said, abs=1e-5)
    assert -x[0] - machine()[1] == pytest.approx(0.350, abs=5e-4)
    assert (knee, heel) == pytest.approx((1.659, 2.655), abs=5e-4)
    found = sorted(np.linalg.eigvals(jacobian), key=lambda m: (-abs(m), m.imag))
    assert [abs(m) for m in found] == pytest.approx([0.4606, 0.4606, 0.0670, 0.0], abs=1e-4)
    assert cmath.phase(found[1]) == pytest.approx(0.9443, abs=2e-4)
    size, angle = float(printed("machine_size")), float(printed("machine_angle"))
    assert abs(abs(found[0]) - size) < 0.031 * size
    assert abs(cmath.phase(found[1]) - angle) < 0.003 * angle
