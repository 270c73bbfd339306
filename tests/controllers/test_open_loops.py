"""Constant controls and walkers of least gait sensitivity."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import TunedOpenLoop, policy_of, tune_control, tune_walker
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.trials import trial_strides
from powered_walker_env.controllers.tuned_open_loop import TunedControl
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Gait, find_gait, gait_sensitivity
from powered_walker_env.poincare.stability.robustness import STATE_NAMES
from tests.helpers.derivation import Array

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


@cache
def tuned_to(env_id: str) -> TunedControl:
    """The constant control of least norm in that environment."""
    return tune_control(task_of(env_id))


@cache
def by_norm() -> TunedOpenLoop:
    return TunedOpenLoop(task_of(ROUND_FOOT))


def laboratory_norm(task: Task, gait: Gait) -> float:
    """The gait sensitivity norm as the laboratory has it: observations by the task's pushes."""
    pushes = dict.fromkeys(("stance_rate", "swing_rate"), task.disturbance.push)
    units = dict(zip(STATE_NAMES, task.scale.tolist(), strict=True))
    return gait_sensitivity(gait, pushes, units).norm


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_the_tuned_control_is_at_a_least_norm_within_the_bounds(env_id: str) -> None:
    task, tuned = task_of(env_id), tuned_to(env_id)

    def norm(action: Array) -> float:
        return laboratory_norm(
            task, find_gait(task.params, task.control_of(action), tuned.gait.state)
        )

    nominal = find_gait(task.params, task.control, task.gait[0])
    np.testing.assert_allclose(tuned.nominal_sensitivity, laboratory_norm(task, nominal), rtol=1e-6)
    np.testing.assert_allclose(tuned.sensitivity, norm(tuned.action), rtol=1e-6)
    assert tuned.sensitivity < tuned.nominal_sensitivity
    assert (abs(tuned.action) <= 1).all()
    for step in 1e-3 * np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)]):
        near = tuned.action + step
        if (abs(near) <= 1).all():
            assert norm(near) > tuned.sensitivity * (1 - 1e-6)


def test_the_tuned_open_loop_gives_one_action_and_its_loop_is_the_gaits_own() -> None:
    task, controller = task_of(ROUND_FOOT), by_norm()
    actions, memory = controller.predict(np.ones((3, 4), np.float32))
    assert memory is None
    np.testing.assert_array_equal(actions, np.tile(controller.tuned.action, (3, 1)))
    assert controller.predict(np.ones(4))[0].shape == (2,)
    closed = find_gait(task.params, policy_of(task, controller), controller.tuned.gait.state)
    np.testing.assert_allclose(closed.multipliers, controller.tuned.gait.multipliers, atol=1e-7)


def test_by_trials_it_walks_longer_than_by_the_norm() -> None:
    task = task_of(ROUND_FOOT)
    by_trials = TunedOpenLoop(task, "strides")
    assert trial_strides(task, by_trials) > trial_strides(task, by_norm()) + 5
    assert by_norm().tuned.sensitivity < by_trials.tuned.sensitivity


@pytest.mark.parametrize("preset", ["hip-torque", "toe-off"])
def test_other_schemes_are_tuned_too(preset: str) -> None:
    task = task_of(ROUND_FOOT, preset=preset)
    tuned = tune_control(task)
    assert tuned.action.shape == task.nominal.shape
    assert tuned.sensitivity <= tuned.nominal_sensitivity


def test_with_geometry_the_norm_is_less_still_and_the_walker_within_its_bounds() -> None:
    task, tuned = task_of("PoweredWalker-v0"), tuned_to("PoweredWalker-v0")
    found = tune_walker(task, ["leg_inertia"], reach=0.02)
    own = task.params.leg_inertia
    assert found.sensitivity < 0.5 * tuned.sensitivity
    assert abs(found.params.leg_inertia - own) <= 0.02 * task.params.leg_mass * (1 + 1e-12)
    assert found.params.replace(leg_inertia=own) == task.params
    np.testing.assert_allclose(laboratory_norm(task, found.gait), found.sensitivity, rtol=1e-6)
    assert found.gait.params == found.params
    assert found.gait.control == found.control


def test_what_cannot_be_tuned_is_refused() -> None:
    task = task_of(ROUND_FOOT)
    with pytest.raises(ValueError, match=r"fields must be out of leg_length, .*, got 'gravity'"):
        tune_walker(task, ["gravity"])
    with pytest.raises(ValueError, match="reach must be positive"):
        tune_walker(task, reach=0.0)
    with pytest.raises(ValueError, match="criterion must be one of sensitivity, strides"):
        TunedOpenLoop(task, "luck")
    point = task.gait[0].tolist()
    with pytest.raises(ValueError, match="the tuned open loop needs a gait of one stride"):
        TunedOpenLoop(task_of(ROUND_FOOT, gait=[point, point]))
