"""The motor's torque limit, and what it draws from its supply."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from powered_walker_env import PRESETS, Control, WalkerParams, stride
from powered_walker_env.model.mechanics import actuation
from powered_walker_env.model.phases import Outcome, Torque
from powered_walker_env.model.powering import ToeOff
from powered_walker_env.simulation import record
from powered_walker_env.simulation.trajectory import log_stride
from tests.helpers.samples import POWERED, constants, pose, random_walkers, sprung
from tests.helpers.second_integrator import motor, stride_otherwise

ROUND = PRESETS["round-foot"]
STALL = 3371.8
POWERED_PHASE = 1
# N m: above the line throughout, crossed on the way, below it throughout.
LIMITS = {"never": 4000.0, "at first": 2600.0, "always": 1200.0}


def limited(limit: float) -> WalkerParams:
    return ROUND.params.replace(torque_limit=limit)


@pytest.mark.parametrize("limit", [0.0, 500.0, 1e9])
def test_torque_is_the_line_cut_off_at_the_limit_both_ways(limit: float) -> None:
    control = Control(2.7, STALL)
    for plain in random_walkers(1, 20):
        params = plain.replace(torque_limit=limit)
        c = constants(params)
        acting = actuation.drive(Torque.MOTOR, STALL)
        for u2 in np.linspace(-4.0, 2.0, 13) * params.no_load_speed:
            torque = actuation.ankle_torque(u2, acting, c)
            expected = motor(float(u2), control, params)
            assert torque == pytest.approx(expected, abs=1e-12 * STALL)
            assert abs(torque) <= (limit or math.inf)


@pytest.mark.parametrize("name", POWERED)
def test_a_limit_that_is_never_met_changes_nothing(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    free = stride(state, control, params, rtol=1e-13)
    assert stride(state, control, params.replace(torque_limit=1e9), rtol=1e-13) == free


@pytest.mark.parametrize("which", LIMITS)
def test_a_stride_under_a_limit_is_kanes_with_the_torque_cut_off(which: str) -> None:
    params, control = limited(LIMITS[which]), ROUND.control
    assert isinstance(control, Control)
    expected, landing = stride_otherwise(ROUND.state, control, params)
    ours = stride(ROUND.state, control, params, rtol=1e-13)
    assert ours.outcome is Outcome.WALKED
    assert ours.state == pytest.approx(expected, abs=2e-11)
    assert ours.duration == pytest.approx(landing.t, abs=2e-11)


def test_a_stride_with_a_hip_spring_is_kanes_with_one() -> None:
    params, control = ROUND.params.replace(hip_stiffness=3.0), ROUND.control
    assert isinstance(control, Control)
    expected, landing = stride_otherwise(ROUND.state, control, params)
    ours = stride(ROUND.state, control, params, rtol=1e-13)
    free = stride(ROUND.state, control, ROUND.params, rtol=1e-13)
    assert ours.state == pytest.approx(expected, abs=2e-11)
    assert ours.duration == pytest.approx(landing.t, abs=2e-11)
    assert abs(ours.duration - free.duration) > 1e-3


@pytest.mark.parametrize("which", LIMITS)
def test_electrical_energy_is_the_no_load_speed_times_the_torques_impulse(which: str) -> None:
    """The motor at constant voltage: V I = ω_noload τ. ∫τ dt by splines through samples, each
    side of the kink by itself."""
    params, control = limited(LIMITS[which]), ROUND.control
    assert isinstance(control, Control)
    log = log_stride(ROUND.state, control, params, 0.0, 1e-13, 5e-4).log
    part = log[log[:, record.LOG_PHASE] == POWERED_PHASE]
    times = part[:, 0]
    line = control.stall_torque * (1.0 + (part[:, 5] - part[:, 4]) / params.no_load_speed)
    good = np.concatenate([[True], np.diff(times) > 1e-9])  # both sides of an event are there
    spline = make_interp_spline(times[good], line[good] - params.torque_limit, k=5)
    ends, over = (times[0], times[-1]), line > params.torque_limit
    pieces = [*ends]
    for i in np.flatnonzero(over[1:] != over[:-1]):
        low, high = times[i], times[i + 1]
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if (spline(middle) > 0) == over[i] else (low, middle)
        pieces.insert(-1, low)
    assert len(pieces) == (3 if which == "at first" else 2)
    impulse = params.torque_limit * (ends[1] - ends[0])
    for low, high in itertools.pairwise(pieces):
        if spline(0.5 * (low + high)) < 0:
            impulse += float(spline.integrate(low, high))
    drawn = stride(ROUND.state, control, params, rtol=1e-13).electrical_energy
    # In the one step with the kink the kernel takes the mean of the torques at its ends.
    within = 1e-8 if which == "at first" else 1e-10
    assert drawn == pytest.approx(params.no_load_speed * impulse, rel=within)


def test_motor_draws_at_least_what_it_does_and_the_rest_is_its_resistance() -> None:
    params, control, state, _ = ROUND
    assert isinstance(control, Control)
    ours = stride(state, control, params, rtol=1e-13)
    log = log_stride(state, control, params, 0.0, 1e-13, 5e-4).log
    part = log[log[:, record.LOG_PHASE] == POWERED_PHASE]
    part = part[np.concatenate([[True], np.diff(part[:, 0]) > 1e-9])]
    speed = part[:, 4] - part[:, 5]
    torque = control.stall_torque * (1.0 - speed / params.no_load_speed)
    copper = torque**2 * params.no_load_speed / control.stall_torque  # τ² R/k²
    lost = float(make_interp_spline(part[:, 0], copper, k=5).integrate(part[0, 0], part[-1, 0]))
    assert ours.electrical_energy - ours.energy_in == pytest.approx(lost, rel=1e-10)


def test_only_the_ankles_motor_draws() -> None:
    params, control, state, _ = ROUND
    assert isinstance(control, Control)
    idle = stride(state, Control(control.switch_angle, 0.0), params)
    assert idle.electrical_energy == 0.0
    passive = PRESETS["compass"]
    assert stride(passive.state, None, passive.params).electrical_energy == 0.0
    assert stride(passive.state, ToeOff(0.1), passive.params).electrical_energy == 0.0


def test_a_motor_turned_faster_than_its_no_load_speed_gives_back() -> None:
    """With a no-load speed of next to nothing every extension is faster: it brakes."""
    params, control, state, _ = ROUND
    slow = params.replace(no_load_speed=0.05)
    braked = stride(state, Control(control.switch_angle, 100.0), slow)  # type: ignore[union-attr]
    assert braked.energy_in * braked.electrical_energy != 0.0
    for params in random_walkers(3, 5):
        walker = sprung(params, np.random.default_rng(3))
        c = constants(walker)
        acting = actuation.drive(Torque.MOTOR, 10.0)
        y = np.array([0.1, 0.2, 3.0, 0.3 + 2.0 * walker.no_load_speed, 0.3, 0.4])
        assert actuation.ankle_torque(y[4] - y[3], acting, c) == pytest.approx(-10.0, rel=1e-12)
        assert actuation.power(pose(y), acting, c) < 0
