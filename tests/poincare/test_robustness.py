"""The gait sensitivity norm against simulated responses; transition times."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, find_gait
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import Gait, StrideMap
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stability.robustness import gait_sensitivity
from powered_walker_env.poincare.stability.transitions import transition_times
from powered_walker_env.simulation.strides import stride_batch
from tests.helpers.derivation import Array

ROUND = PRESETS["round-foot"]
PUBLISHED = PRESETS["camp1997-as-published"]
INDICATORS = {"duration": 1.0, "step_length": 0.5, "speed": 0.25, "swing_angle": 2.0}


def gait_of(kind: str) -> Gait:
    if kind == "two strides":
        control = Control(2.8625, 738.0)
        start = StrideMap(PUBLISHED.params, control, 1e-9)(np.array([PUBLISHED.state]) + 1e-3, 200)
        return find_gait(PUBLISHED.params, control, start[0].tolist(), period=2)
    params, control, state, _ = ROUND if kind != "published" else PUBLISHED
    gait = find_gait(params, control, state)
    if kind == "closed loop":
        assert control is not None
        return find_gait(params, regulate(gait, (0.2, 0.3 * control.stall_torque)), state)
    return gait


def walked(gait: Gait, phase: int, push: Array, torque: float, height: float) -> Array:
    """(strides, 4) duration, length, speed and swing angle of a walk disturbed at first."""
    x, rows = (gait.states[phase] + push)[np.newaxis], []
    policy = StrideMap(gait.params, gait.control)
    for k in range(60):
        controls = policy.controls(x)
        controls[:, 1] += torque if k == 0 else 0.0
        batch = stride_batch(
            x, controls, gait.params, step_height=height if k == 0 else 0.0, rtol=1e-13
        )
        x, time, length = batch.state, batch.duration[0], batch.step_length[0]
        rows.append([time, length, length / time, x[0, 1]])
    return np.array(rows)


@pytest.mark.parametrize("kind", ["open loop", "closed loop", "published", "two strides"])
def test_the_norm_is_that_of_simulated_responses(kind: str) -> None:
    gait = gait_of(kind)
    sizes = {"stance_rate": 0.02, "swing_rate": 0.05, "stall_torque": 3.0}
    if kind == "published":
        sizes["step_height"] = 0.3
    found = gait_sensitivity(gait, sizes, INDICATORS)
    squares, scales = np.zeros((4, len(sizes))), np.array(list(INDICATORS.values()))
    for phase in range(gait.period):
        for column, (name, size) in enumerate(sizes.items()):
            h = 1e-6 / (1e-3 if name == "stall_torque" else 1.0)
            ends = []
            for sign in (h, -h):
                push = np.array([0, 0, name == "stance_rate", name == "swing_rate"]) * sign
                torque, height = (name == "stall_torque") * sign, (name == "step_height") * sign
                ends.append(walked(gait, phase, push, torque, height))
            response = (ends[0] - ends[1]) / (2 * h) * size / scales
            expected = found.impulse_response(60, phase)[:, :, column]
            np.testing.assert_allclose(response, expected, atol=1e-4 * np.abs(expected).max())
            squares[:, column] += np.sum(response**2, axis=0) / gait.period
    np.testing.assert_allclose(found.parts, np.sqrt(squares), rtol=1e-4)
    assert found.norm == pytest.approx(math.sqrt(squares.sum()), rel=1e-4)


def test_where_a_step_down_is_another_stride_the_derivative_is_that_of_steps_up() -> None:
    gait = gait_of("open loop")
    found = gait_sensitivity(gait, {"step_height": 1.0}, {"duration": 1.0})
    heights = np.array([0.0, 1e-5])
    controls = np.tile(np.array(scheme_of(ROUND.control).row(ROUND.control)), (2, 1))
    batch = stride_batch(np.tile(gait.state, (2, 1)), controls, ROUND.params, step_height=heights,
                         rtol=1e-13)  # fmt: skip
    slope = np.diff(batch.duration)[0] / 1e-5
    assert found.D[0, 0, 0] == pytest.approx(slope, rel=1e-3)


def test_by_default_it_is_a_step_up_and_the_duration_without_dimension() -> None:
    gait = gait_of("published")
    found = gait_sensitivity(gait)
    assert found.disturbances == {"step_height": 1.0}
    assert found.indicators == {"duration": pytest.approx(math.sqrt(0.1))}
    assert found.norm == pytest.approx(97.2929, rel=1e-4)


def test_feedback_makes_pushes_felt_less() -> None:
    pushes, states = {"stance_rate": 1.0, "swing_rate": 1.0}, {"stance_angle": 1.0}
    open_loop = gait_sensitivity(gait_of("open loop"), pushes, states)
    closed = gait_sensitivity(gait_of("closed loop"), pushes, states)
    assert closed.norm < open_loop.norm


def test_transition_times_of_the_map_and_of_walks_agree() -> None:
    gait = gait_of("open loop")
    times = transition_times(gait, (0.5, 0.05), size=1e-6, limit=60)
    np.testing.assert_allclose(
        times.by_multiplier, np.log([0.5, 0.05]) / math.log(gait.spectral_radius)
    )
    units = natural_units(gait.params)
    scaled = gait.jacobian * units / units[:, np.newaxis]
    sizes = [np.linalg.norm(np.linalg.matrix_power(scaled, k), 2) for k in range(60)]
    for level, worst in zip((0.5, 0.05), times.worst, strict=True):
        assert sizes[worst] <= level < sizes[worst - 1]
        assert max(sizes[worst:]) <= level
    assert times.growth == pytest.approx(max(sizes), rel=1e-9)
    assert (times.simulated >= 0).all()
    assert (times.simulated.max(axis=1) <= times.worst).all()
    assert times.seconds(times.worst)[0] == pytest.approx(times.worst[0] * gait.duration)


def test_walkers_that_fall_never_settle() -> None:
    times = transition_times(gait_of("open loop"), (0.5,), size=0.3, deviations=8, limit=12)
    assert (times.simulated == -1).any()


def test_unstable_gaits_and_unknown_names_are_refused() -> None:
    unstable = find_gait(PUBLISHED.params, Control(2.8625, 738.0), PUBLISHED.state)
    with pytest.raises(ValueError, match="gait must be stable"):
        gait_sensitivity(unstable)
    with pytest.raises(ValueError, match="gait must be stable"):
        transition_times(unstable)
    gait = gait_of("published")
    with pytest.raises(ValueError, match=r"disturbances must be out of .* got 'wind'"):
        gait_sensitivity(gait, {"wind": 1.0})
    with pytest.raises(ValueError, match="indicators need positive sizes, got 0 for 'speed'"):
        gait_sensitivity(gait, None, {"speed": 0})
    with pytest.raises(ValueError, match="levels must lie in"):
        transition_times(gait, (1.5,))
