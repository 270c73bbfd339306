"""Look-ahead on the exact map against the regulator, a search of all actions, and single walks."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS, stride_batch
from powered_walker_env.controllers import LookAhead, evaluate, paired_difference, policy_of
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.look_ahead import FALL
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import find_gait
from tests.helpers.derivation import Array

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
EACH = pytest.mark.parametrize("env_id", ENVIRONMENTS)


def pushed(task: Task, count: int = 60) -> Array:
    """Observations of walkers pushed off the gait, three times as hard as the level says."""
    size = 3 * task.disturbance.push / task.scale[2:]
    return np.hstack(
        [np.zeros((count, 2)), np.random.default_rng(3).normal(size=(count, 2)) * size]
    )


def exact_cost(look: LookAhead, task: Task, x: Array, plans: Array) -> Array:
    """(N,) Σ x'Qx + a'Ra and x'Px at the end of plans (N, n, k), stride by stride; inf of falls."""
    total = np.zeros(len(x))
    for i in range(plans.shape[1]):
        a = plans[:, i]
        controls = task.nominal + a * task.half_range
        batch = stride_batch(
            task.gait[0] + x * task.scale, controls, task.params, scheme=task.scheme.name
        )
        x = np.where(batch.walked[:, None], (batch.state - task.gait[0]) / task.scale, np.inf)
        W = look.lqr.P if i == plans.shape[1] - 1 else look.lqr.Q
        with np.errstate(invalid="ignore"):
            total += ((a @ look.lqr.R) * a).sum(axis=1) + ((x @ W) * x).sum(axis=1)
        x = np.where(np.isfinite(x), x, 0.0)
    return np.where(np.isfinite(total), total, np.inf)


@EACH
def test_it_costs_no_more_than_the_regulator_and_less_in_all(env_id: str) -> None:
    task = task_of(env_id)
    look, x = LookAhead(task, 1), pushed(task)
    ours = exact_cost(look, task, x, look.predict(x)[0][:, np.newaxis])
    theirs = exact_cost(look, task, x, look.lqr.predict(x)[0][:, np.newaxis])
    walked = np.isfinite(theirs)
    assert (ours[walked] <= theirs[walked] * (1 + 1e-12)).all()
    assert ours[walked].sum() < theirs[walked].sum()


@EACH
def test_one_stride_ahead_is_the_least_of_all_actions(env_id: str) -> None:
    task = task_of(env_id)
    look, x = LookAhead(task, 1), pushed(task, 20)
    plans, costs = look.plan(x)
    axis = np.linspace(-1, 1, 41)
    grid = np.array(list(itertools.product(axis, axis)))[:, np.newaxis]
    least = np.array([
        exact_cost(look, task, np.tile(one, (len(grid), 1)), grid).min() for one in x
    ])  # fmt: skip
    good = np.isfinite(least)
    np.testing.assert_allclose(costs[good], exact_cost(look, task, x, plans)[good], rtol=1e-9)
    assert (costs[good] < FALL).all()
    # The search is local, and its steps bounded: a narrow valley is not followed to its end.
    wide = env_id == "PoweredWalkerAsPublished-v1"  # a range of actions three times as wide
    assert (costs[good] <= 1.02 * least[good]).mean() >= (0.6 if wide else 0.9)
    assert (costs[good] <= 1.1 * least[good]).all()


@EACH
@pytest.mark.parametrize("strides", [1, 2, 3])
def test_near_the_gait_it_is_the_regulator(env_id: str, strides: int) -> None:
    task = task_of(env_id)
    look = LookAhead(task, strides)
    x = 1e-5 * np.random.default_rng(1).normal(size=(10, 4))
    linear = look.lqr.predict(x)[0]
    np.testing.assert_allclose(look.predict(x)[0], linear, atol=5e-3 * abs(linear).max())


def test_the_multipliers_are_the_regulators() -> None:
    task = task_of(ROUND_FOOT)
    look = LookAhead(task, 2)
    gaits = [find_gait(task.params, policy_of(task, c), task.gait[0]) for c in (look, look.lqr)]
    np.testing.assert_allclose(gaits[0].multipliers, gaits[1].multipliers, atol=1e-4)


def test_longer_plans_cost_less_and_stay_within_bounds() -> None:
    task = task_of(ROUND_FOOT, disturbance="rough")
    x = pushed(task)
    for strides in (2, 3):
        look = LookAhead(task, strides)
        plans, costs = look.plan(x)
        assert (abs(plans) <= 1).all()
        shorter, _ = LookAhead(task, strides - 1).plan(x)
        rest = np.concatenate([shorter, np.zeros((len(x), 1, 2))], axis=1)
        good = costs < FALL
        np.testing.assert_allclose(costs[good], exact_cost(look, task, x, plans)[good], rtol=1e-9)
        assert costs[good].sum() < exact_cost(look, task, x, rest)[good].sum()


def test_a_walker_decides_the_same_alone_and_among_many() -> None:
    task = task_of(ROUND_FOOT, disturbance="rough")
    look, x = LookAhead(task, 2), pushed(task, 30)
    together = look.predict(x)[0]
    alone = np.array([look.predict(one)[0] for one in x])
    np.testing.assert_array_equal(together, alone)


def test_where_every_plan_falls_the_regulator_decides() -> None:
    task = task_of(ROUND_FOOT)
    look = LookAhead(task, 1)
    lost = np.array([[0.0, 0.0, -20.0, 20.0]])
    plans, costs = look.plan(lost)
    assert costs[0] >= FALL
    np.testing.assert_array_equal(plans[:, 0], look.lqr.predict(lost)[0])


@pytest.mark.parametrize("preset", ["hip-torque", "toe-off", "motor-with-stop"])
def test_other_schemes_look_ahead_too(preset: str) -> None:
    task = task_of(ROUND_FOOT, preset=preset)
    look = LookAhead(task, 2)
    a = evaluate(look, ROUND_FOOT, 20, preset=preset)
    b = evaluate(look.lqr, ROUND_FOOT, 20, preset=preset)
    assert a.strides.sum() >= 0.8 * b.strides.sum()


def test_two_strides_ahead_beat_one_and_the_regulator_on_round_feet() -> None:
    task = task_of(ROUND_FOOT)
    walks = [
        evaluate(c, ROUND_FOOT, 80)
        for c in (LookAhead(task, 2), LookAhead(task), LookAhead(task).lqr)
    ]
    assert paired_difference(walks[0].strides, walks[1].strides).low > 0
    assert paired_difference(walks[1].strides, walks[2].strides).low > 0


def test_horizons_that_make_no_sense_are_refused() -> None:
    with pytest.raises(ValueError, match="strides must be at least 1"):
        LookAhead(task_of(ROUND_FOOT), 0)
    with pytest.raises(ValueError, match="needs a gait of one stride"):
        point = task_of(ROUND_FOOT).gait[0].tolist()
        LookAhead(task_of(ROUND_FOOT, gait=[point, point]))
