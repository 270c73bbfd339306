"""The stride map: open and closed loops, and derivatives by anything a walker is made of."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Outcome,
    basin,
    differentiate_batch,
    lyapunov_exponent,
    stride,
    stride_batch,
    walk,
)
from powered_walker_env.model.powering import as_policy
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import PARAMETERS, StrideMap, find_gait
from powered_walker_env.simulation.derivatives import policy_derivative
from tests.helpers.derivation import Array

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
assert CONTROL is not None
NOMINAL = np.array([CONTROL.switch_angle, CONTROL.stall_torque])
GAIN = np.array([[0.02, -0.03, 0.01, 0.02], [30.0, -20.0, 40.0, 10.0]])


def feedback(states: Array) -> Array:
    return NOMINAL + (states - np.array(STATE)) @ GAIN.T


def test_a_policy_that_ignores_the_state_is_the_constant_control() -> None:
    def constant(states: Array) -> Array:
        return np.tile(NOMINAL, (len(states), 1))

    states = np.array([STATE, np.add(STATE, 0.01)])
    np.testing.assert_array_equal(
        StrideMap(PARAMS, constant)(states, 3), StrideMap(PARAMS, CONTROL)(states, 3)
    )


def test_the_closed_loop_has_the_jacobian_a_plus_b_k() -> None:
    gait = find_gait(PARAMS, CONTROL, STATE)
    closed = find_gait(PARAMS, feedback, STATE)
    expected = gait.jacobian + gait.control_jacobian @ GAIN
    np.testing.assert_allclose(closed.state, gait.state, atol=1e-11)
    np.testing.assert_allclose(closed.jacobian, expected, atol=1e-8)
    np.testing.assert_allclose(closed.control_jacobian, gait.control_jacobian, rtol=1e-8)


def test_the_derivative_of_a_nonlinear_policy_is_exact_to_its_differences() -> None:
    def bent(states: Array) -> Array:
        return NOMINAL + np.tanh(states @ GAIN.T)

    steepness = 1 - np.tanh(GAIN @ np.array(STATE)) ** 2
    found = policy_derivative(as_policy(bent), np.array([STATE]), natural_units(PARAMS))
    np.testing.assert_allclose(found[0], steepness[:, np.newaxis] * GAIN, atol=1e-6)


def test_two_closed_strides_have_the_derivative_of_their_differences() -> None:
    stride_map, start, h = StrideMap(PARAMS, feedback), np.add(STATE, 0.003), 1e-5
    by = stride_map.differentiate(start, period=2).by_state
    for j in range(4):
        step = h * np.eye(4)[j]
        there, back = stride_map(np.array([start + step, start - step]), 2)
        np.testing.assert_allclose(by[:, j], (there - back) / (2 * h), atol=1e-6)


@pytest.mark.parametrize("name", ["stall_torque", "foot_radius", "slope", "leg_inertia"])
def test_derivatives_by_a_parameter_are_those_of_strides_of_changed_walkers(name: str) -> None:
    point = StrideMap(PARAMS, CONTROL).differentiate(STATE, by=[name])
    assert point.by_parameters.shape == (4, 1)
    if name == "stall_torque":
        np.testing.assert_array_equal(point.by_parameters[:, 0], point.by_control[:, 1])
        return
    h, value = 1e-6, getattr(PARAMS, name)
    ends = [
        stride(STATE, CONTROL, PARAMS.replace(**{name: value + sign * h}), rtol=1e-13)
        for sign in (1, -1)
    ]
    change = np.subtract(ends[0].state, ends[1].state) / (2 * h)
    np.testing.assert_allclose(point.by_parameters[:, 0], change, rtol=1e-5, atol=1e-7)
    duration = (ends[0].duration - ends[1].duration) / (2 * h)
    assert point.duration_by[-1] == pytest.approx(duration, abs=1e-5)
    length = (ends[0].step_length - ends[1].step_length) / (2 * h)
    assert point.step_length_by[-1] == pytest.approx(length, abs=1e-5)


def test_durations_and_lengths_add_up_over_strides() -> None:
    start = np.add(STATE, 0.002)
    twice = StrideMap(PARAMS, CONTROL).differentiate(start, period=2)
    first = stride(start, CONTROL, PARAMS, rtol=1e-13)
    second = stride(first.state, CONTROL, PARAMS, rtol=1e-13)
    assert twice.duration == pytest.approx(first.duration + second.duration, abs=1e-14)
    assert twice.step_length == pytest.approx(first.step_length + second.step_length, abs=1e-14)


def test_unknown_parameters_and_misshapen_policies_are_refused() -> None:
    with pytest.raises(ValueError, match=r"parameter must be one of switch_angle, .* got 'colour'"):
        StrideMap(PARAMS, CONTROL).differentiate(STATE, by=["colour"])
    with pytest.raises(ValueError, match=r"controls of shape \(1, 2\), got \(2,\)"):
        StrideMap(PARAMS, lambda states: NOMINAL)(np.array([STATE]))
    assert "physics" not in PARAMETERS


@pytest.mark.parametrize(
    ("rtol", "error"),
    [
        (None, TypeError),
        (1.0, ValueError),
        (-1e-9, ValueError),
        (np.nan, ValueError),
        (0, ValueError),
    ],
)
def test_tolerances_out_of_bounds_are_refused_wherever_strides_are_walked(
    rtol: Any, error: type[Exception]
) -> None:
    ways: list[Callable[[], Any]] = [
        lambda: stride(STATE, CONTROL, PARAMS, rtol=rtol),
        lambda: walk(STATE, CONTROL, PARAMS, 1, rtol=rtol),
        lambda: stride_batch([STATE], CONTROL, PARAMS, rtol=rtol),
        lambda: differentiate_batch([STATE], CONTROL, PARAMS, rtol=rtol),
        lambda: StrideMap(PARAMS, CONTROL, rtol),
        lambda: lyapunov_exponent(PARAMS, CONTROL, STATE, rtol=rtol),
        lambda: basin(PARAMS, CONTROL, [STATE], gaits=[], rtol=rtol),
    ]
    for way in ways:
        with pytest.raises(error, match="rtol must"):
            way()


def test_a_map_after_a_fall_is_not_a_number_and_says_how_it_fell() -> None:
    point = StrideMap(PARAMS, CONTROL).differentiate((-1.0, 0.2, 0.0, 0.0), period=3)
    assert point.outcome == Outcome.FELL_BACKWARD
    assert np.isnan(point.state).all()
    assert np.isnan(point.by).all()
