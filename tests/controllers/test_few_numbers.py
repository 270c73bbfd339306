"""Feedback of one number, and of fewer and fewer."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import (
    LQR,
    FewNumbers,
    LinearFeedback,
    OneNumber,
    few_numbers_table,
    one_number_table,
    policy_of,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.few_numbers import QuadraticCost, least_cost
from powered_walker_env.controllers.linear import linearise
from powered_walker_env.poincare import find_gait
from tests.controllers.test_open_loops import laboratory_norm
from tests.helpers.derivation import Array

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


def judge_of(env_id: str) -> tuple[LQR, QuadraticCost]:
    task = task_of(env_id)
    lqr = LQR(task)
    return lqr, QuadraticCost(linearise(task), lqr.Q, lqr.R)


def series(loops: Array, pushes: Array, weights: Array, strides: int = 3000) -> Array:
    """(...) Σ over strides after pushes of the responses' x'Wx, for loops (..., 4, 4).

    Norms without a Lyapunov equation.
    """
    x, total = np.broadcast_to(pushes, loops.shape), np.zeros(loops.shape[:-2])
    for _ in range(strides):
        total += (x * weights).sum(axis=(-2, -1))
        x = loops @ x @ loops.swapaxes(-2, -1)
    return total


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_the_best_pair_is_that_of_a_search_through_all_gains(env_id: str) -> None:
    task = task_of(env_id)
    linear, table = linearise(task), one_number_table(task)
    assert [(row.number, row.action) for row in table[:2]] == [
        ("stance_angle", "switch_angle"), ("swing_angle", "switch_angle"),
    ]  # fmt: skip
    assert len(table) == 8
    found = {}
    for (j, i), row in zip(itertools.product(range(2), range(4)), table, strict=True):
        sizes, gains = np.geomspace(0.01, 100, 300), np.zeros((600, 2, 4))
        gains[:, j, i] = np.concatenate([-sizes[::-1], sizes])
        loops = np.array([linear.closed(gain) for gain in gains])
        loops = loops[abs(np.linalg.eigvals(loops)).max(axis=1) < 0.995]
        norms = series(loops, linear.pushes, np.eye(4), 300)
        least = np.sqrt(norms.min() - np.trace(linear.pushes))
        found[(row.number, row.action)] = least
        assert row.sensitivity <= least * (1 + 1e-6)
        np.testing.assert_allclose(row.sensitivity, least, rtol=5e-3)
    best = min(table, key=lambda row: row.sensitivity)
    assert min(found, key=lambda pair: found[pair]) == (best.number, best.action)


def test_a_row_says_what_the_laboratory_says_of_its_loop() -> None:
    task = task_of(ROUND_FOOT)
    row = one_number_table(task)[2]
    gain = np.zeros((2, 4))
    gain[0, 2] = row.gain
    closed = find_gait(task.params, policy_of(task, LinearFeedback(gain)), task.gait[0])
    np.testing.assert_allclose(closed.spectral_radius, row.spectral_radius, rtol=1e-6)
    np.testing.assert_allclose(laboratory_norm(task, closed), row.sensitivity, rtol=1e-6)


def test_the_radius_is_least_where_asked_for_and_walks_less() -> None:
    task = task_of(ROUND_FOOT)
    by_radius, by_norm = one_number_table(task, "radius"), one_number_table(task)
    for one, other in zip(by_radius, by_norm, strict=True):
        assert one.spectral_radius <= other.spectral_radius * (1 + 1e-9)
        assert one.sensitivity >= other.sensitivity * (1 - 1e-9)
    assert min(by_radius).strides < max(row.strides for row in by_norm) - 10


def test_one_number_walks_longer_than_none_and_uses_one() -> None:
    task = task_of(ROUND_FOOT)
    controller = OneNumber(task)
    assert np.count_nonzero(controller.gain) == 1
    assert (controller.loop.number, controller.loop.action) == ("stance_rate", "switch_angle")
    assert controller.loop.strides > 2 * few_numbers_table(task, 0)[0].strides


def test_schemes_with_one_action_have_four_pairs() -> None:
    task = task_of(ROUND_FOOT, preset="toe-off")
    assert [row.action for row in one_number_table(task)] == ["impulse"] * 4


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_all_four_numbers_give_the_regulator_from_any_start(env_id: str) -> None:
    lqr, judge = judge_of(env_id)
    rng = np.random.default_rng(2)
    for _ in range(3):
        start = 0.3 * rng.normal(size=lqr.gain.shape) * abs(lqr.gain)
        found = least_cost(judge, start, (0, 1, 2, 3))
        np.testing.assert_allclose(judge(found), judge(lqr.gain), rtol=1e-6)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
@pytest.mark.parametrize("chosen", [(2,), (0, 2), (1, 3), (0, 2, 3)])
def test_a_subset_costs_least_where_its_gradient_vanishes(
    env_id: str, chosen: tuple[int, ...]
) -> None:
    lqr, judge = judge_of(env_id)
    gain = least_cost(judge, lqr.gain, chosen)
    unseen = [i for i in range(4) if i not in chosen]
    assert not gain[:, unseen].any()
    assert gain[:, list(chosen)].any()
    rng, least = np.random.default_rng(1), judge(gain)
    for _ in range(30):
        near = gain * (1 + 0.01 * rng.normal(size=gain.shape))
        assert judge(near) > least * (1 - 1e-9)
    assert judge(lqr.gain) <= least * (1 + 1e-9)
    assert least < judge(np.zeros_like(gain))


def test_cost_and_gradient_are_those_of_the_strides_to_come() -> None:
    lqr, judge = judge_of(ROUND_FOOT)
    gain = 0.7 * lqr.gain
    weights = judge.Q + gain.T @ judge.R @ gain
    summed = series(judge.linear.closed(gain), judge.linear.pushes, weights)
    np.testing.assert_allclose(judge(gain), summed, rtol=1e-9)
    _, gradient = judge.with_gradient(gain)
    for j, i in itertools.product(range(2), range(4)):
        step = np.zeros((2, 4))
        step[j, i] = 1e-5
        slope = (judge(gain + step) - judge(gain - step)) / 2e-5
        np.testing.assert_allclose(gradient[j, i], slope, rtol=1e-5, atol=1e-9)
    unstable = 50 * lqr.gain
    assert judge(unstable) == np.inf


@pytest.mark.slow
def test_the_ladder_of_fewer_numbers_goes_down() -> None:
    task = task_of(ROUND_FOOT)
    table = few_numbers_table(task)
    assert [len(row.numbers) for row in table] == [4] + [3] * 4 + [2] * 6 + [1] * 4 + [0]
    best = [max(r.strides for r in table if len(r.numbers) == k) for k in range(5)]
    assert best[0] < best[1] < best[2] < best[4]
    assert FewNumbers(task, 2).loop.strides == best[2]
    assert FewNumbers(task, 0).gain.any() == False  # noqa: E712


def test_what_makes_no_sense_is_refused() -> None:
    task = task_of(ROUND_FOOT)
    with pytest.raises(ValueError, match="criterion must be one of radius, sensitivity, strides"):
        OneNumber(task, "luck")
    with pytest.raises(ValueError, match=r"count must .* 4"):
        FewNumbers(task, 5)
    with pytest.raises(ValueError, match=r"gain must be \(k, 4\) finite numbers"):
        LinearFeedback(np.full((2, 4), np.nan))
