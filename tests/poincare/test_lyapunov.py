"""Lyapunov exponents: known on gaits, positive past the doubling cascade."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, find_gait
from powered_walker_env.poincare import StrideMap
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stability.lyapunov import lyapunov_exponent

PARAMS, CONTROL, STATE, _ = PRESETS["camp1997"]
#: A state on the chaotic attractor at switch angle 2.9068 and stall torque 737.0.
CHAOTIC = (-0.0889576406, 0.1724750642, 0.4316165461, 0.4178702501)


@pytest.mark.parametrize("name", ["camp1997-as-published", "round-foot"])
def test_on_a_stable_gait_it_is_the_logarithm_of_the_spectral_radius(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    gait = find_gait(params, control, state)
    found = lyapunov_exponent(params, control, gait.state, strides=600, transient=20)
    assert found.exponent == pytest.approx(math.log(gait.spectral_radius), abs=0.01)
    assert found.exponent == pytest.approx(float(np.mean(found.growth)))
    assert not found.chaotic and found.outcome == Outcome.WALKED


def test_on_a_gait_of_two_strides_it_is_half_of_that() -> None:
    params, _, state, _ = PRESETS["camp1997-as-published"]
    control = Control(2.8625, 738.0)
    start = StrideMap(params, control, 1e-9)(np.array([state]) + 1e-3, 200)[0]
    gait = find_gait(params, control, start.tolist(), period=2)
    found = lyapunov_exponent(params, control, gait.state, strides=400, transient=20)
    assert found.exponent == pytest.approx(math.log(gait.spectral_radius) / 2, abs=0.01)


def test_under_a_policy_it_is_that_of_the_closed_loop() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    policy = regulate(find_gait(params, control, state), (0.2, 1000.0))
    gait = find_gait(params, policy, state)
    found = lyapunov_exponent(params, policy, gait.state, strides=300, transient=20)
    assert found.exponent == pytest.approx(math.log(gait.spectral_radius), abs=0.01)


def test_past_the_doubling_cascade_walking_is_chaotic() -> None:
    found = lyapunov_exponent(PARAMS, Control(2.9068, 737.0), CHAOTIC, strides=600, transient=0)
    assert found.outcome == Outcome.WALKED
    assert found.chaotic
    assert found.exponent == pytest.approx(0.34, abs=5 * found.standard_error)
    assert 0.005 < found.standard_error < 0.05


def test_a_walker_that_falls_has_no_exponent() -> None:
    found = lyapunov_exponent(PARAMS, CONTROL, (-1.0, 0.2, 0.0, 0.0), strides=40)
    assert math.isnan(found.exponent) and not found.chaotic
    assert found.outcome != Outcome.WALKED


def test_too_few_strides_are_refused() -> None:
    with pytest.raises(ValueError, match="strides must be at least "):
        lyapunov_exponent(PARAMS, CONTROL, STATE, strides=10)
