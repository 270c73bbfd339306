"""Look-ahead on the exact map: the actions of the next n strides that cost least, then the first.

Receding-horizon control: least of Σ x'Qx + a'Ra over n strides of the true walker, undisturbed, and
x'Px after them, P of the regulator with these Q and R. With a linear map that is the regulator
itself for every n (Bellman), so what differs from it is owed to the map's curvature and to the
action bounds. Q is 1 and R small where nothing is said: x'x is d² of the reward exp(−d²/2), and
weights that are tuned for the regulator's walks make up for what it does not know of the map.

Gauss and Newton's method with the exact derivatives of the strides, projected on the bounds, from
the best of some plans: the first action the regulator's or one of a grid over the range, the others
the regulator's. The method is local, and its cost has narrow valleys: a coarser grid finds worse
ones. A walk that falls costs more than any other, the more the sooner; where all fall alike, the
regulator's action is taken.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.envs.task import Task
from powered_walker_env.model.checks import whole_number
from powered_walker_env.poincare.regulator import Weights
from powered_walker_env.simulation.derivatives import differentiate_batch
from powered_walker_env.simulation.strides import Array, stride_batch

MOST_STRIDES = 8
ACTION_COST = 0.01  # of the squared action, 1 at its bound, beside d²
FALL = 1e12  # what each stride not walked costs: above any sum of squares
LEVELS = 7  # of each number of the first action, that plans begin with
ITERATIONS = 6
HALVINGS = 4  # of a step that does not bring the cost down
PASSES = 3  # in which variables of a step are laid on their bounds
CONVERGED = 1e-7  # a change of the actions that makes no difference


class LookAhead:
    """The first of the next n actions that cost least on the exact map.

    Args:
        task: of the environment.
        strides: n, 1 to 8.
        state_cost, action_cost: Q and R, as `LQR` has them.

    Raises:
        ValueError: another number of strides, or as `LQR`.
    """

    def __init__(
        self, task: Task, strides: int = 1, state_cost: Weights = 1.0,
        action_cost: Weights = ACTION_COST,
    ) -> None:  # fmt: skip
        self.strides = whole_number("strides", strides, 1, MOST_STRIDES)
        #: The regulator of the same costs.
        self.lqr: LQR = LQR(task, state_cost, action_cost)
        self._task, self._k = task, len(task.nominal)
        levels = itertools.product(np.linspace(-1.0, 1.0, LEVELS), repeat=self._k)
        self._grid: Array = np.array(list(levels))

    def predict(self, observation: Any, *_: Any, deterministic: bool = True) -> tuple[Array, None]:
        """The first actions of those planned."""
        seen = np.atleast_2d(np.asarray(observation, np.float64))
        first: Array = self.plan(seen)[0][:, 0]
        return first.reshape(*np.shape(observation)[:-1], self._k), None

    def plan(self, observations: Array) -> tuple[Array, Array]:
        """(N, n, k) actions planned from observations (N, 4), and (N,) what they cost."""
        actions, costs = self._start(observations)
        going = np.flatnonzero(costs < FALL)
        for _ in range(ITERATIONS):
            if not len(going):
                break
            moved = self._improve(observations, actions, costs, going)
            going = going[moved > CONVERGED]
        return actions, costs

    def cost(self, observations: Array, actions: Array) -> Array:
        """(N,) of the strides from observations (N, 4) under actions (N, n, k)."""
        x, total = observations, np.zeros(len(observations))
        on = np.ones(len(x), np.bool_)
        for i in range(self.strides):
            a: Array = actions[:, i]
            x, on = self._stride(x, a, on)
            weights = self.lqr.P if i == self.strides - 1 else self.lqr.Q
            total += _squares(a, self.lqr.R) + np.where(on, _squares(x, weights), FALL)
        return total

    def _stride(
        self, x: Array, a: Array, on: NDArray[np.bool_]
    ) -> tuple[Array, NDArray[np.bool_]]:  # fmt: skip
        """Observations after a stride, 0 of those that fell, and who still walks."""
        task = self._task
        batch = stride_batch(
            task.gait[0] + x * task.scale, task.nominal + a * task.half_range, task.params,
            scheme=task.scheme.name,
        )  # fmt: skip
        on = on & batch.walked
        return np.where(on[:, np.newaxis], (batch.state - task.gait[0]) / task.scale, 0.0), on

    def _start(self, observations: Array) -> tuple[Array, Array]:
        """The best of the plans to begin with; the regulator's own if all are alike."""
        count, several = len(observations), 1 + len(self._grid)
        first = np.repeat(self._grid[:, np.newaxis], count, axis=1)
        first = np.concatenate([self.lqr.predict(observations)[0][np.newaxis], first])
        x, on = np.tile(observations, (several, 1)), np.ones(several * count, np.bool_)
        plans = np.zeros((several * count, self.strides, self._k))
        plans[:, 0] = first.reshape(-1, self._k)
        for i in range(1, self.strides):
            x, on = self._stride(x, plans[:, i - 1], on)
            plans[:, i] = self.lqr.predict(x)[0]
        costs = self.cost(np.tile(observations, (several, 1)), plans).reshape(several, count)
        # Walks that fall are told apart by the strides they walked alone.
        best = np.argmin(np.where(costs < FALL, costs, FALL * np.floor(costs / FALL)), axis=0)
        rows = np.arange(count)
        return plans.reshape(several, count, *plans.shape[1:])[best, rows], costs[best, rows]

    def _improve(
        self, observations: Array, actions: Array, costs: Array, going: NDArray[np.int64]
    ) -> Array:  # fmt: skip
        """One step for the walkers going; writes actions and costs. (m,) how far they moved."""
        x, a = observations[going], actions[going].reshape(len(going), -1)
        H, g = self._model(x, actions[going])
        step = _bounded_step(H, g, a)
        moved, waiting, share = np.zeros(len(going)), np.arange(len(going)), 1.0
        for _ in range(HALVINGS):
            trial = np.clip(a[waiting] + share * step[waiting], -1.0, 1.0)
            plans = trial.reshape(len(waiting), self.strides, self._k)
            found = self.cost(x[waiting], plans)
            better = found < costs[going[waiting]]
            rows = waiting[better]
            actions[going[rows]], costs[going[rows]] = plans[better], found[better]
            moved[rows] = np.abs(trial[better] - a[rows]).max(axis=1)
            waiting, share = waiting[~better], 0.5 * share
            if not len(waiting):
                break
        return moved

    def _model(self, x: Array, actions: Array) -> tuple[Array, Array]:
        """Gauss and Newton's matrix (N, nk, nk) of half the cost, and its gradient (N, nk)."""
        task, k, count = self._task, self._k, len(x)
        size = self.strides * k
        H = np.broadcast_to(np.kron(np.eye(self.strides), self.lqr.R), (count, size, size)).copy()
        g = (self.lqr.R @ actions[..., np.newaxis]).reshape(count, size)
        by = np.zeros((count, 4, size))
        for i in range(self.strides):
            found = differentiate_batch(
                task.gait[0] + x * task.scale, task.nominal + actions[:, i] * task.half_range,
                task.params, scheme=task.scheme.name,
            )  # fmt: skip
            across = task.scale[:, np.newaxis]
            by = (found.by_state * task.scale / across) @ by
            by[:, :, i * k : (i + 1) * k] += found.by_control * task.half_range / across
            x = (found.strides.state - task.gait[0]) / task.scale
            weights = self.lqr.P if i == self.strides - 1 else self.lqr.Q
            leaned = by.swapaxes(1, 2) @ weights
            H += leaned @ by
            g += (leaned @ x[:, :, np.newaxis])[:, :, 0]
        return H, g


def _bounded_step(H: Array, g: Array, a: Array) -> Array:
    """(N, m) steps to the least of ½ s'Hs + g's with a + s in ±1, or near it.

    Variables on a bound that the slope holds there stay; those that a step would carry over a
    bound are laid on it, and the rest solved for again.
    """
    fixed = ((a <= -1.0) & (g > 0.0)) | ((a >= 1.0) & (g < 0.0))
    step, eye = np.zeros_like(a), np.eye(a.shape[1])
    for _ in range(PASSES):
        free = ~fixed
        both = free[:, :, np.newaxis] & free[:, np.newaxis]
        laid = np.where(fixed, step, 0.0)
        slope = np.where(free, g + (H @ laid[:, :, np.newaxis])[:, :, 0], -laid)
        step = np.linalg.solve(np.where(both, H, eye), -slope[:, :, np.newaxis])[:, :, 0]
        over = free & (np.abs(a + step) > 1.0)
        if not over.any():
            break
        step = np.where(over, np.clip(a + step, -1.0, 1.0) - a, step)
        fixed = fixed | over
    return np.clip(a + step, -1.0, 1.0) - a


def _squares(x: Array, weights: Array) -> Array:
    """(N,) x'Wx."""
    # Row by row, or the last digits would depend on how many rows there are.
    found: Array = x[:, np.newaxis] @ (weights @ x[:, :, np.newaxis])
    return found[:, 0, 0]
