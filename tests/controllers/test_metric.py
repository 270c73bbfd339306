"""The metric in which one stride does not stretch deviations."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.controllers.metric import stride_metric
from powered_walker_env.simulation.strides import stride_batch


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_it_measures_a_deviation_now_and_a_stride_on(env_id: str) -> None:
    """The stride by finite differences of walked strides, without a derivative."""
    task = task_of(env_id)
    metric = stride_metric(task)
    np.testing.assert_allclose(metric, metric.T, atol=1e-12 * np.abs(metric).max())
    x = np.random.default_rng(0).normal(size=(5, 4))
    small = 1e-6
    starts = np.concatenate([task.gait[0] + sign * small * task.scale * x for sign in (1, -1)])
    controls = np.tile(task.nominal, (10, 1))
    ends = stride_batch(starts, controls, task.params, rtol=1e-11).state
    after = (ends[:5] - ends[5:]) / (2 * small * task.scale)
    wanted = (x**2).sum(1) + (after**2).sum(1)
    np.testing.assert_allclose(((x @ metric) ** 2).sum(1), wanted, rtol=1e-3)


def test_a_gait_of_two_strides_has_none() -> None:
    task = task_of("PoweredWalkerRoundFoot-v0")
    two = task_of("PoweredWalkerRoundFoot-v0", gait=[task.gait[0].tolist()] * 2)
    with pytest.raises(ValueError, match="needs a gait of one stride, got one of 2"):
        stride_metric(two)
