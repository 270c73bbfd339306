"""First passages by the table: the right ones, or none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS, PRESETS
from powered_walker_env.controllers import LQR, OpenLoop, Optimal, TunedOpenLoop, policy_of
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.optimal import noise_of
from powered_walker_env.envs.levels import SIZES as NOISE
from powered_walker_env.model.powering import decides_on_section
from powered_walker_env.poincare import (
    Grid,
    StepNoise,
    disturbed_walks,
    first_passage,
    step_law,
)
from powered_walker_env.poincare.sections import section_of

SIZES: dict[str, Any] = {"walks": 3000, "branches": 5, "push_points": 11}


@pytest.mark.parametrize("name", ["camp1997", "round-foot", "compass", "camp1997-as-published"])
def test_the_mean_of_a_constant_control_is_within_its_error_of_other_walks(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    rough = StepNoise(step_height=0.004)
    noise = rough if name == "compass" else StepNoise(push=NOISE[name]["push"][0])
    found = first_passage(params, control, noise, state, shape=20, **{**SIZES, "branches": 33})
    mean, error = found.walks.mean
    assert abs(found.mean_strides - mean) <= 1.001 * found.strides_error + 1e-9
    others = disturbed_walks(params, control, noise, state, strides=1000, walks=3000, seed=9)
    assert others.fell.all()
    away = abs(found.mean_strides - others.mean[0])
    assert away < found.strides_error + 3.0 * np.hypot(error, others.mean[1])
    rate, _ = found.walks.fall_rate()
    assert found.eigenvalue_error >= abs(1.0 - found.second_eigenvalue - rate)


def test_the_error_knows_of_walks_that_are_cut_off() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    noise = StepNoise(push=0.02)
    whole, cut = (
        first_passage(params, control, noise, state, shape=16, limit=limit, **SIZES)
        for limit in (1000, 12)
    )
    assert cut.walks.mean[0] < 0.8 * whole.walks.mean[0]
    assert abs(cut.mean_strides - whole.mean_strides) < cut.strides_error + whole.strides_error
    assert cut.strides_error < 0.3 * cut.mean_strides


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_a_policy_of_four_numbers_is_refused_on_a_hip_angle(env_id: str) -> None:
    task = task_of(env_id)
    policy, start = policy_of(task, LQR(task)), task.gait[0].tolist()
    noise = noise_of(task)
    match = (
        "no knee" if task.params.knee is not None else r"TaskPolicy\(motor, LQR\), which decides"
    )
    with pytest.raises(ValueError, match=match):
        first_passage(task.params, policy, noise, start)
    assert not decides_on_section(policy)


def test_a_law_on_a_hip_angle_refuses_it_too() -> None:
    task = task_of("PoweredWalkerRoundFoot-v0")
    policy = policy_of(task, LQR(task))
    section = section_of(task.params, policy)
    assert section.hip_angle is not None
    at = section.points(task.gait[:1])[0]
    grid = Grid.box(at - 0.05, at + 0.05, (4, 4, 4), section)
    with pytest.raises(ValueError, match="on_section = True"):
        step_law(task.params, policy, grid, noise_of(task))


def test_with_both_feet_on_the_floor_four_numbers_are_the_section() -> None:
    params, control, state, _ = PRESETS["toe-off"]
    strength = control.impulse  # type: ignore[union-attr]

    class Timid:
        """Less toe-off the faster it is: of the state at heel strike."""

        scheme = "toe-off"

        def __call__(self, states: Any) -> Any:
            return strength * (1.0 - 0.1 * (states[:, 2:3] - state[2]))

    found = first_passage(params, Timid(), StepNoise(push=0.004), state, shape=14, walks=1000)
    assert found.strides_error < 0.2 * found.mean_strides


def test_who_sees_the_section_alone_says_so() -> None:
    task = task_of("PoweredWalkerRoundFoot-v0")
    for controller in (OpenLoop(), TunedOpenLoop(task)):
        assert decides_on_section(policy_of(task, controller))
    assert decides_on_section(None) and decides_on_section(task.control)
    best = Optimal(task)
    assert decides_on_section(best.policy)
    section = section_of(task.params, best.policy)
    states = task.gait + 0.02 * np.random.default_rng(0).normal(size=(20, 4))
    carried = section.states(section.points(states))
    np.testing.assert_allclose(best.policy(states), best.policy(carried), atol=1e-5)


def test_the_optimums_table_is_right_about_its_walks() -> None:
    task = task_of("PoweredWalkerRoundFoot-v0")
    policy, start = Optimal(task).policy, task.gait[0].tolist()
    noise = StepNoise(push=2.0 * noise_of(task).push)
    found = first_passage(task.params, policy, noise, start, shape=20, **SIZES)
    others = disturbed_walks(task.params, policy, noise, start, strides=1000, walks=1000, seed=9)
    gap = abs(found.mean_strides - others.mean[0])
    assert gap < found.strides_error + 3.0 * np.hypot(found.walks.mean[1], others.mean[1])
