"""Deviations in the metric in which one stride does not stretch them: what a learner can see."""

from __future__ import annotations

import numpy as np

from powered_walker_env.envs.task import Task
from powered_walker_env.poincare.gaits import find_gait
from powered_walker_env.simulation.strides import Array


def stride_metric(task: Task) -> Array:
    """(4, 4) M = (1 + A'A)^½, symmetric: |M x|² = |x|² + |A x|², the deviation now and a stride on.

    A is the stride map's derivative at the gait, in units of the observation. Where it has a
    large singular value (44 on the thesis's walker) a deviation too small to be seen in x fells
    the walker a stride later; in M x it is as large as it is dangerous, all else as it was.

    Raises:
        ValueError: a gait of more than one stride.
    """
    if len(task.gait) != 1:
        raise ValueError(
            f"the metric needs a gait of one stride, got one of {len(task.gait)} strides"
        )
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    step = gait.jacobian / task.scale[:, np.newaxis] * task.scale
    _, stretched, directions = np.linalg.svd(step)
    found: Array = (directions.T * np.sqrt(1.0 + stretched**2)) @ directions
    return found
