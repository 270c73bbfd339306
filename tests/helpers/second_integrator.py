"""A stride by other means: Kane's equations, scipy's DOP853 with events, relative angles.

Shares with the package only the names of the parameters and the statement of the model;
equations from `derivation.py`, momenta from point velocities.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from tests.helpers.derivation import Array, energies, locked_system, powered_system
from tests.helpers.impacts import (
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
    start = np.array([
        state.stance_angle - params.locked_ankle_angle,
        state.swing_angle + math.pi - state.stance_angle,
        state.stance_rate,
        state.swing_rate - state.stance_rate,
    ])  # fmt: skip
    return until_switch(0.0, start, control, params)


def until_switch(
    t: float, start: Array, control: Control, params: WalkerParams
) -> tuple[float, Array]:
    """The locked mode from (q1, q3, u1, u3) at a time until the hip falls to the switch angle."""
    lock = params.locked_ankle_angle

    def flow(_: float, y: Array) -> Array:
        mass, force = locked_system([y[0], lock, y[1]], [y[2], 0.0, y[3]], params)
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    def switch(_: float, y: Array) -> float:
        return float(y[1] - control.switch_angle)

    switch.terminal, switch.direction = True, -1  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (t, t + 10.0), start, events=switch, **TOLERANCES)
    assert solution.status == 1, "the hip did not reach the switch angle"
    return float(solution.t[-1]), solution.y[:, -1]


def motor(ankle_rate: float, control: Control, params: WalkerParams) -> float:
    """Torque of the motor on its line (u2 < 0 extends), within its limit, N m."""
    torque = control.stall_torque * (1.0 + ankle_rate / params.no_load_speed)
    limit = params.torque_limit or math.inf
    return min(max(torque, -limit), limit)


def height(q: Array, params: WalkerParams) -> float:
    """Of the swing foot over the floor, m."""
    foot_angle, stance, swinging = np.cumsum(q)
    lock, length, foot = params.locked_ankle_angle, params.leg_length, params.foot_length
    feet = foot * (math.cos(foot_angle) + math.cos(swinging - lock))
    return float(feet + length * (math.cos(stance) + math.cos(swinging)))


def extension(t: float, y: Array, control: Control, params: WalkerParams) -> Landing:
    """The powered mode until the swing foot falls through the floor ahead.

    Where the motor comes off its limit the flow has a kink: it is integrated up to there.
    """
    start = np.array([y[0], params.locked_ankle_angle, y[1], y[2], 0.0, y[3]])
    while True:
        time, state, landed = _extension(t, start, control, params)
        if landed:
            return Landing(time, state[:3], state[3:])
        # Past the kink by far more than rounding, so that it is not met again.
        t, start = time, state


def _extension(
    t: float, start: Array, control: Control, params: WalkerParams
) -> tuple[float, Array, bool]:
    """Powered up to the landing or the kink, whichever comes first; is it the landing?"""
    limit = params.torque_limit or math.inf

    def line(y: Array) -> float:
        return control.stall_torque * (1.0 + y[4] / params.no_load_speed)

    ramp = _slope_of_line(start, control, params)
    limited = line(start) > limit or (line(start) > limit * (1 - 1e-9) and ramp > 0.0)

    def flow(_: float, y: Array) -> Array:
        torque = limit if limited else line(y)
        mass, force = powered_system(y[:3], y[3:], torque, params)
        return np.concatenate([y[3:], np.linalg.solve(mass, force)])

    def landing(_: float, y: Array) -> float:
        return height(y[:3], params)

    def kink(_: float, y: Array) -> float:
        return 1.0 if math.isinf(limit) else (line(y) - limit) / limit

    landing.direction = -1  # type: ignore[attr-defined]
    kink.direction = -1 if limited else 1  # type: ignore[attr-defined]
    kink.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(flow, (t, t + 3.0), start, events=(landing, kink), **TOLERANCES)
    for time, state in zip(solution.t_events[0], solution.y_events[0], strict=True):
        if state[2] < math.pi:  # the swing foot is ahead
            return float(time), state, True
    assert solution.status == 1, "the swing foot did not land"
    return float(solution.t[-1]), solution.y[:, -1], False


def _slope_of_line(y: Array, control: Control, params: WalkerParams) -> float:
    """Sign of the change of the motor's line in time."""
    mass, force = powered_system(y[:3], y[3:], motor(y[4], control, params), params)
    return float(np.linalg.solve(mass, force)[1])


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


class StoppedStride(NamedTuple):
    """A stride of a motor with a stop: how it went from phase to phase."""

    state: PostStrikeState
    landing: Landing
    released: list[float]  # s
    stopped: list[float]  # s
    lost: float  # J, at the stops


def needed_torque(q: Array, u: Array, params: WalkerParams) -> float:
    """The ankle torque under which Kane's free walker does not turn its ankle, N m."""
    mass, slack = powered_system(q, u, 0.0, params)
    _, pushed = powered_system(q, u, 1.0, params)
    at_rest, response = np.linalg.solve(mass, np.column_stack([slack, pushed - slack]))[1]
    return float(-at_rest / response)


def stopped_at(q: Array, u: Array, params: WalkerParams) -> Array:
    """(u1, 0, u3) after the ankle's stop: the impulse is a torque at the ankle, so that it
    changes Kane's momentum of u2 alone."""
    mass, _ = powered_system(q, u, 0.0, params)
    hinges = [0, 2]
    u1, u3 = np.linalg.solve(mass[np.ix_(hinges, hinges)], mass[hinges] @ u)
    return np.array([u1, 0.0, u3])


def stride_with_stop(
    state: PostStrikeState, control: Control, params: WalkerParams
) -> StoppedStride:
    """A whole stride of a conserving walker on flat ground, whose motor has no limit."""
    lock, torque = params.locked_ankle_angle, control.stall_torque
    released: list[float] = []
    stopped: list[float] = []
    lost = 0.0
    t, (q1, q3, u1, u3) = swing(state, control, params)
    y = np.array([q1, lock, q3, u1, 0.0, u3])

    def landing(_: float, y: Array) -> float:
        return height(y[:3], params)

    def release(_: float, y: Array) -> float:
        return needed_torque(y[:3], y[3:], params) - torque

    def stop(_: float, y: Array) -> float:
        return float(lock - y[1])

    def held(_: float, y: Array) -> Array:
        mass, force = locked_system(y[:3], y[3:], params)
        du1, du3 = np.linalg.solve(mass, force)
        return np.array([y[3], 0.0, y[5], du1, 0.0, du3])

    def free(_: float, y: Array) -> Array:
        mass, force = powered_system(y[:3], y[3:], motor(y[4], control, params), params)
        return np.concatenate([y[3:], np.linalg.solve(mass, force)])

    for event in (landing, release, stop):
        event.direction = -1  # type: ignore[attr-defined]
    release.terminal = stop.terminal = True  # type: ignore[attr-defined]
    holding = release(t, y) > 0.0
    if not holding:
        released.append(t)
    while True:
        flow, guard = (held, release) if holding else (free, stop)
        solution = solve_ivp(flow, (t, t + 3.0), y, events=(landing, guard), **TOLERANCES)
        for time, at in zip(solution.t_events[0], solution.y_events[0], strict=True):
            if at[2] < math.pi - 1e-3:  # the swing foot is ahead, not passing by
                down = Landing(float(time), at[:3], at[3:])
                return StoppedStride(strike(down, params), down, released, stopped, lost)
        assert solution.status == 1, "the swing foot did not land"
        t, y = float(solution.t[-1]), solution.y[:, -1]
        if holding:
            released.append(t)
        else:
            stopped.append(t)
            before = energies(y[:3], y[3:], params).kinetic
            y = np.array([y[0], lock, y[2], *stopped_at(y[:3], y[3:], params)])
            lost += before - energies(y[:3], y[3:], params).kinetic
        holding = not holding
