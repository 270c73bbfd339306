"""An environment near its gait: the linear map, linear feedback, and how well it holds.

In observations x (deviations over their scale) and actions a (1 is the full range),

    x⁺ = A x + B a + e,    a = −K x,

e the push on both leg rates after the heel strike, which the controller sees. Two numbers judge a
closed loop. Its spectral radius says how fast deviations die out in the end. Its gait sensitivity
norm under the pushes (`poincare.gait_sensitivity`: Hobbelen and Wisse 2007) says how large they are
on the way, and that is what a walker falls over: the map of the thesis's gait multiplies a push by
up to 44 in its first stride though its spectral radius is 0.51.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg

from powered_walker_env.envs.levels import disturbance_of
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare.gaits import Gait, find_gait
from powered_walker_env.simulation.strides import Array


class LinearFeedback:
    """Actions −K x, clipped to ±1.

    Args:
        gain: K, (k, 4).

    Raises:
        ValueError: another shape, or a number that is not finite.
    """

    def __init__(self, gain: Any) -> None:
        given = np.array(gain, np.float64)
        if given.ndim != 2 or given.shape[1] != 4 or not np.isfinite(given).all():
            raise ValueError(f"gain must be (k, 4) finite numbers, got {gain!r}")
        self.gain: Array = given  # (k, 4): action = −gain · observation

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """Actions −K x, clipped to their range."""
        seen = np.asarray(observation, np.float64)[..., np.newaxis]
        # Row by row, or the last digits would depend on how many rows there are.
        return np.clip(-np.matmul(self.gain, seen)[..., 0], -1.0, 1.0), None

    def derivative(self, observations: Array) -> Array:
        """(N, k, 4) of the actions before clipping."""
        return np.broadcast_to(-self.gain, (len(observations), *self.gain.shape))


@dataclass(frozen=True, eq=False)
class LinearMap:
    """The steps of an environment near its gait, in observations and actions."""

    A: Array = field(repr=False)  # (4, 4)
    B: Array = field(repr=False)  # (4, k)
    pushes: Array = field(repr=False)  # (4, 4) covariance of e

    def closed(self, gain: Array) -> Array:
        """(4, 4) A − B K."""
        loop: Array = self.A - self.B @ gain
        return loop

    def spectral_radius(self, gain: Array) -> float:
        """The largest multiplier's modulus under −K x."""
        return float(abs(np.linalg.eigvals(self.closed(gain))).max())

    def sensitivity(self, gain: Array) -> float:
        """Gait sensitivity norm of the observations by the pushes; inf of an unstable loop.

        Also the standard deviation of the distance from the gait, in units of the scale, that a
        stride under such pushes ends with.
        """
        if not self.spectral_radius(gain) < 1.0:
            return math.inf
        loop = self.closed(gain)
        after = scipy.linalg.solve_discrete_lyapunov(loop.T, np.eye(4)) - np.eye(4)
        return math.sqrt(max(float(np.sum(after * self.pushes)), 0.0))


def linearise(task: Task) -> LinearMap:
    """An environment's steps near its gait; its pushes, or those of "light" where it has none.

    Raises:
        ValueError: a gait of more than one stride.
    """
    gait, scale = nominal_gait(task, "a linear map"), task.scale
    rates = np.array([0.0, 0.0, 1.0, 1.0]) * push_of(task) / scale
    return LinearMap(
        A=gait.jacobian * scale / scale[:, np.newaxis],
        B=gait.control_jacobian * task.half_range / scale[:, np.newaxis],
        pushes=np.diag(rates**2),
    )


def nominal_gait(task: Task, whose: str) -> Gait:
    """The gait of a task, of one stride.

    Raises:
        ValueError: a gait of more.
    """
    if len(task.gait) != 1:
        raise ValueError(f"{whose} needs a gait of one stride, got one of {len(task.gait)} strides")
    return find_gait(task.params, task.control, task.gait[0].tolist())


def push_of(task: Task) -> float:
    """rad/s: the standard deviation of the task's pushes; where it has none, that of "light"."""
    return task.disturbance.push or disturbance_of("light", None, task.params).push
