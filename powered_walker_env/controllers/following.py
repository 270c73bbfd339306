"""Gaits followed through a box: of controls, of walkers, as an optimisation moves them."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable

import numpy as np
import scipy.optimize

from powered_walker_env.controllers.linear import LinearMap
from powered_walker_env.envs.task import Task
from powered_walker_env.model.powering import AnyControl
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.simulation.strides import Array

POINTS = 15  # of the grid along each axis
CLOSE = 1e-7  # of place and norm, that a search ends with
#: The gait at a point of the box, near one that is known; None where there is none.
Follow = Callable[[Array, Gait], Gait | None]


class Search:
    """A search by simplex in the box [-1, 1] that follows the gait of the best point so far."""

    def __init__(
        self, follow: Follow, judge: Callable[[Gait], float], start: tuple[Array, Gait]
    ) -> None:
        self._follow, self._judge = follow, judge
        self.x, self.gait = start
        self.least = judge(self.gait)

    def run(self, size: Array, evaluations: int) -> Array:
        """The best point, from a simplex of this size at the start."""
        corners = [self.x]
        for i in range(len(self.x)):
            corner = self.x.copy()
            corner[i] += size[i] if corner[i] + size[i] <= 1.0 else -size[i]
            corners.append(corner)
        scipy.optimize.minimize(
            self._try, self.x, method="Nelder-Mead", bounds=[(-1.0, 1.0)] * len(self.x),
            options={"initial_simplex": np.array(corners), "xatol": CLOSE, "fatol": CLOSE,
                     "maxfev": evaluations},
        )  # fmt: skip
        return self.x

    def _try(self, x: Array) -> float:
        gait = self._follow(x, self.gait)
        found = math.inf if gait is None else self._judge(gait)
        if gait is not None and found < self.least:
            self.x, self.gait, self.least = x.copy(), gait, found
        return found if math.isfinite(found) else 1e300


def gaits_within(k: int, start: Gait, follow: Follow) -> list[tuple[Array, Gait]]:
    """Gaits at the nodes of a grid over [-1, 1]^k, each followed from a neighbour's.

    Args:
        start: the gait in the middle.
    """
    axis = np.linspace(-1.0, 1.0, POINTS)
    middle = (POINTS // 2,) * k
    found, tried, queue = {middle: start}, {middle}, deque([middle])
    while queue:
        here = queue.popleft()
        for i, step in itertools.product(range(k), (-1, 1)):
            there = (*here[:i], here[i] + step, *here[i + 1 :])
            if there in tried or not 0 <= there[i] < POINTS:
                continue
            tried.add(there)
            gait = follow(axis[list(there)], found[here])
            if gait is not None:
                found[there] = gait
                queue.append(there)
    return [(axis[list(node)], gait) for node, gait in found.items()]


def gait_near(params: WalkerParams, control: AnyControl, near: Gait) -> Gait | None:
    """The gait that Newton's method finds from another's state, None if there is none."""
    try:
        return find_gait(params, control, near.state)
    except GaitNotFoundError:
        return None


def norm_of(task: Task, linear: LinearMap, gait: Gait) -> float:
    """The gait sensitivity norm of another gait, in the environment's units."""
    A = gait.jacobian * task.scale / task.scale[:, np.newaxis]
    return LinearMap(A, linear.B, linear.pushes).sensitivity(np.zeros_like(linear.B.T))
