"""A stride by other means: Kane's equations, scipy's DOP853 with events, relative angles.

Shares with the package only the names of the parameters and the statement of the model;
equations from `derivation.py`, momenta from point velocities.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from powered_walker_env.params import Control, PostStrikeState, WalkerParams
from tests.derivation import Array, locked_system, powered_system
from tests.test_heel_strike import (
    Moving,
    after,
    before,
    momentum_about,
    momentum_of_trailing_leg,
)

TOLERANCES = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13, "max_step": 0.05}


class Landing(NamedTuple):
    """Where and when the swing foot lands."""

    t: float
    q: Array
    u: Array


def swing(state: PostStrikeState, control: Control, params: WalkerParams) -> tuple[float, Array]:
    """The locked mode until the hip falls to the switch angle: time and (q1, q3, u1, u3)."""
    lock = params.locked_ankle_angle
    start = [
        state.stance_angle - lock,
        state.swing_angle + math.pi - state.stance_angle,
        state.stance_rate,
        state.swing_rate - state.stance_rate,
    ]

    def flow(_: float, y: Array) -> Array:
        mass, force = locked_system([y[0], lock, y[1]], [y[2], 0.0, y[3]], params)
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    def switch(_: float, y: Array) -> float:
        return float(y[1] - control.switch_angle)

    switch.terminal, switch.direction = True, -1  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (0.0, 10.0), start, events=switch, **TOLERANCES)
    assert solution.status == 1, "the hip did not reach the switch angle"
    return float(solution.t[-1]), solution.y[:, -1]


def extension(t: float, y: Array, control: Control, params: WalkerParams) -> Landing:
    """The powered mode until the swing foot falls through the floor ahead."""
    lock, length, foot = params.locked_ankle_angle, params.leg_length, params.foot_length
    start = np.array([y[0], lock, y[1], y[2], 0.0, y[3]])

    def flow(_: float, y: Array) -> Array:
        torque = control.stall_torque * (1.0 + y[4] / params.no_load_speed)
        mass, force = powered_system(y[:3], y[3:], torque, params)
        return np.concatenate([y[3:], np.linalg.solve(mass, force)])

    def height(_: float, y: Array) -> float:
        foot_angle, stance, swinging = np.cumsum(y[:3])
        return float(
            foot * (math.cos(foot_angle) + math.cos(swinging - lock))
            + length * (math.cos(stance) + math.cos(swinging))
        )

    height.direction = -1  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (t, t + 3.0), start, events=height, **TOLERANCES)
    for time, state in zip(solution.t_events[0], solution.y_events[0], strict=True):
        if state[2] < math.pi:  # the swing foot is ahead
            return Landing(float(time), state[:3], state[3:])
    raise AssertionError("the swing foot did not land")


def strike(landing: Landing, params: WalkerParams) -> PostStrikeState:
    """The rates after the strike that give the two momenta before it."""
    foot, stance, swinging = np.cumsum(landing.q)
    y = np.array([foot, stance, swinging, *np.cumsum(landing.u)])
    walker, contact = before(y, params)

    def momenta(moving: Moving) -> Array:
        whole = momentum_about(contact, moving, params)
        return np.array([whole, momentum_of_trailing_leg(moving, params)])

    columns = [momenta(after(walker, contact, *rates)) for rates in ((1.0, 0.0), (0.0, 1.0))]
    stance_rate, swing_rate = np.linalg.solve(np.column_stack(columns), momenta(walker))
    return PostStrikeState(swinging - math.pi, stance, stance_rate, swing_rate)


def stride_otherwise(
    state: PostStrikeState, control: Control, params: WalkerParams
) -> tuple[PostStrikeState, Landing]:
    """A whole stride of a conserving walker on flat ground, and its landing."""
    t, y = swing(state, control, params)
    landing = extension(t, y, control, params)
    return strike(landing, params), landing
