"""Deadbeat control: nilpotent closed loops, and what pushes they bear."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import Deadbeat, deadbeat_answer, policy_of
from powered_walker_env.controllers.deadbeat import minimum_time
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.linear import LinearMap, linearise
from powered_walker_env.poincare import StrideMap, find_gait

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
PRESETS = ["hip-torque", "toe-off", "motor-with-stop"]


@pytest.mark.parametrize("walker", [*ENVIRONMENTS, *PRESETS])
def test_the_closed_loop_is_nilpotent(walker: str) -> None:
    task = task_of(walker) if walker in ENVIRONMENTS else task_of(ROUND_FOOT, preset=walker)
    linear, controller = linearise(task), Deadbeat(task)
    loop, n = linear.closed(controller.gain), controller.strides
    size = np.linalg.norm(linear.A, 2)
    assert np.linalg.norm(np.linalg.matrix_power(loop, n)) < 1e-8 * size**n
    assert np.linalg.norm(np.linalg.matrix_power(loop, n - 1)) > 1e-5
    assert n == 2 if walker in ENVIRONMENTS else n <= 4


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_the_true_walker_is_back_on_its_gait_but_for_a_square(env_id: str) -> None:
    task = task_of(env_id)
    controller = Deadbeat(task)
    policy = policy_of(task, controller)
    closed = find_gait(task.params, policy, task.gait[0])
    assert closed.spectral_radius < 1e-3  # of multiplicity two: the root of rounding
    away = np.random.default_rng(0).normal(size=(20, 4))
    left = []
    for size in (2e-6, 1e-6):
        starts = np.array(closed.state) + size * away * task.scale
        ends = StrideMap(task.params, policy)(starts, controller.strides)
        left.append(abs((ends - closed.state) / task.scale).max())
    assert left[1] < max(left[0] / 3, 1e-9)  # a fourth, but for rounding


def test_fewer_strides_are_not_possible_and_the_answer_says_so() -> None:
    answer = deadbeat_answer(task_of(ROUND_FOOT), pushes=50)
    assert (answer.rank, answer.controllable, answer.strides) == (3, 4, 2)
    assert answer.dimensions == (2, 4)
    linear = linearise(task_of(ROUND_FOOT))
    left = linear.A - linear.B @ np.linalg.pinv(linear.B) @ linear.A  # the best of one stride
    assert np.linalg.matrix_rank(left, 1e-7) == 4 - answer.dimensions[0]


def test_more_strides_need_smaller_actions_and_harder_pushes_larger() -> None:
    light, rough = (deadbeat_answer(task_of(ROUND_FOOT, disturbance=level), pushes=60)
                    for level in ("light", "rough"))  # fmt: skip
    assert (light.needed[3] <= light.needed[2] + 1e-9).all()
    assert (light.needed[4] <= light.needed[3] + 1e-9).all()
    np.testing.assert_allclose(rough.needed[2], 2.5 * light.needed[2], rtol=1e-6)
    assert light.share(2) >= rough.share(2)
    assert light.share(2) >= light.feedback_share  # some actions within bounds, or these


def test_an_uncontrollable_map_has_no_feedback() -> None:
    A = np.diag([0.5, 0.4, 0.0, 0.0])
    B = np.array([[1.0], [0.0], [0.0], [0.0]])
    dimensions, gain = minimum_time(LinearMap(A, B, np.eye(4)))
    assert (dimensions, gain) == ((3,), None)


def test_what_is_forgotten_anyway_needs_no_action() -> None:
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 2] = A[2, 3] = 1.0
    dimensions, gain = minimum_time(LinearMap(A, np.zeros((4, 1)), np.eye(4)))
    assert dimensions == (1, 2, 3, 4)
    assert gain is not None
    assert not gain.any()
