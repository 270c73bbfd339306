"""A walk in real time, without a browser: all walkers and schemes, pushes, falls, changes."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, stride
from powered_walker_env.explore.choice import STEPS, Choice
from powered_walker_env.explore.session import LONGEST, REMEMBERED, REST, SLOW, Session
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.poincare import StrideMap

pytest.importorskip("pygame")
SMALL = (64, 36)
TICK = 0.04


def session(name: str = "round-foot") -> Session:
    return Session(Choice.of_preset(name), SMALL)


def let_pass(walking: Session, seconds: float) -> None:
    for _ in range(round(seconds / TICK)):
        walking.advance(TICK)


def until_heel_strike(walking: Session) -> None:
    strides = walking.strides
    for _ in range(2000):
        walking.advance(TICK)
        if walking.strides != strides or walking.verdict:
            return
    raise AssertionError("no heel strike")


@pytest.mark.parametrize("name", PRESETS)
def test_it_walks_the_strides_of_the_map_in_real_time(name: str) -> None:
    walking = session(name)
    params, control, start, _ = PRESETS[name]
    states, durations = [np.array(start)], []
    for _ in range(3):
        one = stride(states[-1], control, params)
        states.append(np.array(one.state))
        durations.append(one.duration)
    walking.advance(TICK)
    for k in range(1, 4):  # the k-th stride is under way once those before have passed
        let_pass(walking, sum(durations[:k]) - walking.time + 2 * TICK)
        assert walking.strides == k + 1
        np.testing.assert_allclose(walking.section()[k], states[k], rtol=1e-7, atol=1e-9)
    assert walking.status().falls == 0


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", PRESETS)
def test_every_walker_goes_on_under_every_scheme_or_is_refused(name: str, scheme: str) -> None:
    choice = Choice.of_preset(name)
    try:
        choice = choice.powered_by(scheme)
    except ValueError as error:
        assert "must be" in str(error)
        return
    walking = Session(choice, SMALL)
    let_pass(walking, 8.0)
    assert walking.time > 0
    assert len(walking.section()) > 0
    assert np.isfinite(walking.section()).all()
    assert walking.picture().shape == (36, 64, 3)


def test_a_push_is_felt_at_the_next_heel_strike_and_once() -> None:
    walking = session()
    until_heel_strike(walking)
    state = np.array(walking.state)
    walking.push(0.01, -0.02)
    walking.push(0.01, 0.0)
    assert walking.status().pushed
    until_heel_strike(walking)
    np.testing.assert_allclose(
        walking.section()[-1], state + np.array([0, 0, 0.02, -0.02]), atol=1e-12
    )
    assert not walking.status().pushed
    mapped = StrideMap(walking.choice.params, walking.policy)(walking.section()[-1:])[0]
    np.testing.assert_allclose(walking.state, mapped, atol=1e-6)


def test_a_fall_says_how_lies_there_and_the_walk_starts_again() -> None:
    walking = session()
    walking.push(1.0, 1.0)
    while not walking.status().lies:
        walking.advance(TICK)
    status = walking.status()
    assert status.falls == 1
    assert status.lies == walking.outcome.label
    assert walking.outcome.description in status.fell
    last = walking.picture()
    let_pass(walking, REST - 2 * TICK)
    np.testing.assert_array_equal(walking.picture(), last)  # it lies
    let_pass(walking, 3 * TICK)
    assert walking.status().lies == ""
    assert walking.status().fell == status.fell
    np.testing.assert_allclose(walking.section()[-1], PRESETS["round-foot"].state)


def test_it_starts_where_it_is_told_to_and_there_again() -> None:
    walking = session()
    start = np.array(PRESETS["round-foot"].state) + np.array([0.0, 0.0, 0.01, 0.0])
    walking.start(start.tolist())
    walking.advance(TICK)
    np.testing.assert_array_equal(walking.section()[-1], start)
    let_pass(walking, 3.0)
    walking.restart()
    assert walking.time == 0.0
    walking.advance(TICK)
    np.testing.assert_array_equal(walking.section()[-1], start)
    with pytest.raises(ValueError, match="four numbers"):
        walking.start([0.0, 1.0])


def test_a_change_forgets_old_strides_and_holds_from_the_next() -> None:
    walking = session()
    let_pass(walking, 3.0)
    changed = walking.choice.replace("stall_torque", 3400.0)
    walking.change(changed, changed.control)
    assert len(walking.section()) == 0
    state = np.array(walking.state)
    until_heel_strike(walking)
    np.testing.assert_array_equal(walking.section()[0], state)
    mapped = StrideMap(changed.params, changed.control)(state[np.newaxis])[0]
    np.testing.assert_allclose(walking.state, mapped, atol=1e-6)


def test_the_last_hundred_strides_are_remembered() -> None:
    walking = session()
    walking.speed = 50.0
    let_pass(walking, 60.0)
    assert walking.strides > REMEMBERED
    assert len(walking.section()) == REMEMBERED


def test_pause_slow_motion_and_a_clock_that_jumps() -> None:
    walking = session()
    walking.advance(TICK)
    walking.paused = True
    let_pass(walking, 1.0)
    assert walking.time == TICK
    walking.paused, walking.speed = False, SLOW
    let_pass(walking, 1.0)
    assert walking.time == pytest.approx(TICK + SLOW)
    walking.speed = 1.0
    walking.advance(1e6)
    assert walking.time == pytest.approx(TICK + SLOW + LONGEST)
    assert not walking.advance(-1.0)
    assert not walking.advance(float("nan"))


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_has_a_slider_in_its_domain_around_its_value(name: str) -> None:
    for scheme in SCHEMES:
        try:
            choice = Choice.of_preset(name).powered_by(scheme)
        except ValueError:
            continue
        for number, quantity in choice.numbers.items():
            reach = choice.reach(number)
            assert reach.low <= choice.value(number) <= reach.high
            assert reach.low < reach.high
            assert reach.step <= (reach.high - reach.low) * 2.5 / STEPS
            for end in (reach.low, reach.high):
                assert quantity.domain.holds(end), (number, end)
            try:
                moved = choice.replace(number, reach.low)
            except ValueError as error:  # what thigh and shank can be is more than a domain
                assert choice.params.knee is not None
                assert "must" in str(error)
                continue
            assert moved.value(number) == reach.low
            assert moved.scheme is choice.scheme


def test_a_number_out_of_its_domain_is_refused() -> None:
    with pytest.raises(ValueError, match="stall_torque"):
        Choice.of_preset("camp1997").replace("stall_torque", -1.0)
    with pytest.raises(ValueError, match="preset"):
        Choice.of_preset("nobody")
    with pytest.raises(ValueError, match="foot_length"):
        Choice.of_preset("ranger-locked").powered_by("motor").replace("foot_radius", 0.0).replace(
            "foot_length", 0.0
        )
