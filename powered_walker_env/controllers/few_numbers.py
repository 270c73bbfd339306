"""Fewer and fewer measured numbers: the best linear feedback of a subset of the state.

All k actions from n of the four numbers, the others unseen: the static output feedback of least

    J(K) = E[x'Qx + a'Ra] = tr(P W),    P = (A − BK)'P(A − BK) + Q + K'RK,

in the long run under the pushes' covariance W (Levine and Athans 1970, IEEE T-AC 15, 44-48); Q
and R are the regulator's own, tuned for the walker, so that four numbers give the LQR's J. With
Σ = (A − BK)Σ(A − BK)' + W its gradient is 2((R + B'PB)K − B'PA)Σ. It is not convex: several starts.

What is best for the linear map need not walk: where fewer numbers ask for larger actions than there
are, a dearer action does better. So each subset is tried with R and its multiples, in trial walks.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray

from powered_walker_env.controllers.linear import LinearFeedback, LinearMap, linearise
from powered_walker_env.controllers.lqr import LQR
from powered_walker_env.controllers.trials import FEW, trial_strides
from powered_walker_env.envs.task import Task
from powered_walker_env.model.checks import whole_number
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.simulation.strides import Array

NAMES = PostStrikeState._fields
WAYS = (1.0, 0.5, 0.25, 0.0)  # from the LQR's gain to none: starts, those that are stable
SMALLEST = 1e-12  # of a curvature, over the largest
DEARER = (1.0, 10.0, 100.0, 1000.0)  # factors of R that are tried
AGAIN, GAINED = 20, 1e-10  # starts anew, its variables scaled there, while that gains so much


@dataclass(frozen=True, eq=False)
class QuadraticCost:
    """J and its gradient."""

    linear: LinearMap
    Q: Array = field(repr=False)  # (4, 4)
    R: Array = field(repr=False)  # (k, k)

    def __call__(self, gain: Array) -> float:
        """J(K); inf of an unstable loop."""
        return self.with_gradient(gain)[0]

    def with_gradient(self, gain: Array) -> tuple[float, Array]:
        """J(K) and its (k, 4) derivatives; inf and 0 of an unstable loop."""
        if not self.linear.spectral_radius(gain) < 1.0:
            return math.inf, np.zeros_like(gain)
        P, S, H = self._solved(gain)
        gradient = 2.0 * (H @ gain - self.linear.B.T @ P @ self.linear.A) @ S
        return float(np.sum(P * self.linear.pushes)), gradient

    def curvature(self, gain: Array, mask: NDArray[np.bool_]) -> Array:
        """(m, m) second derivatives by the gains in a mask, as if P and Σ did not change."""
        _, S, H = self._solved(gain)
        chosen = mask.ravel()
        return np.asarray(2.0 * np.kron(H, S)[np.ix_(chosen, chosen)], np.float64)

    def _solved(self, gain: Array) -> tuple[Array, Array, Array]:
        loop = self.linear.closed(gain)
        P = scipy.linalg.solve_discrete_lyapunov(loop.T, self.Q + gain.T @ self.R @ gain)
        S = scipy.linalg.solve_discrete_lyapunov(loop, self.linear.pushes)
        return P, S, self.R + self.linear.B.T @ P @ self.linear.B


class FewNumbersLoop(NamedTuple):
    """The best feedback of some of the numbers."""

    numbers: tuple[str, ...]  # measured, by the names of the state
    gain: Array  # (k, 4), zero where a number is not measured
    cost: float  # J, with the regulator's R; inf where none was found that is stable
    spectral_radius: float
    sensitivity: float  # gait sensitivity norm by the task's pushes, observation units
    strides: float  # mean of trial walks of 100 strides


class FewNumbers(LinearFeedback):
    """The linear feedback of so many measured numbers that walks longest in trials.

    Args:
        task: of the environment.
        count: how many of the four numbers are measured, 0 to 4.

    Raises:
        ValueError: another count, a gait of several strides, no subset that is stable.
    """

    def __init__(self, task: Task, count: int) -> None:
        stable = [row for row in few_numbers_table(task, count) if math.isfinite(row.cost)]
        if not stable:
            raise ValueError(f"no feedback of {count} measured numbers makes this gait stable")
        #: The subset chosen.
        self.loop: FewNumbersLoop = max(stable, key=lambda row: row.strides)
        super().__init__(self.loop.gain)


def few_numbers_table(task: Task, count: int | None = None) -> list[FewNumbersLoop]:
    """Every subset of the four numbers (of `count` numbers, if given), each at its best gain.

    Raises:
        ValueError: a count outside 0 to 4, a gait of several strides.
    """
    counts = range(4, -1, -1) if count is None else [whole_number("count", count, 0, 4)]
    lqr, linear = LQR(task), linearise(task)
    judge = QuadraticCost(linear, lqr.Q, lqr.R)
    rows = []
    for size in counts:
        for chosen in itertools.combinations(range(4), size):
            gain = _walking_longest(task, judge, lqr.gain, chosen)
            rows.append(FewNumbersLoop(
                tuple(NAMES[i] for i in chosen), gain, judge(gain), linear.spectral_radius(gain),
                linear.sensitivity(gain), trial_strides(task, LinearFeedback(gain)),
            ))  # fmt: skip
    return rows


def _walking_longest(
    task: Task, judge: QuadraticCost, full: Array, chosen: tuple[int, ...]
) -> Array:  # fmt: skip
    """The gain of these numbers, for the dearness of actions with which it walks longest."""
    gains = [
        least_cost(dataclasses.replace(judge, R=factor * judge.R), full, chosen)
        for factor in DEARER
    ]
    return max(gains, key=lambda gain: trial_strides(task, LinearFeedback(gain), FEW))


def least_cost(judge: QuadraticCost, full: Array, chosen: tuple[int, ...]) -> Array:
    """(k, 4) the gain of least cost that has only these columns; zero if none is stable.

    Args:
        full: (k, 4) the gain with all of them.
    """
    best, least = np.zeros_like(full), judge(np.zeros_like(full))
    mask: NDArray[np.bool_] = np.zeros(full.shape, np.bool_)
    mask[:, list(chosen)] = True
    for share in WAYS if chosen else ():
        gain = np.where(mask, share * full, 0.0)
        if math.isfinite(judge(gain)):
            gain = _settled(judge, gain, mask)
            if (cost := judge(gain)) < least:
                best, least = gain, cost
    return best


def _settled(judge: QuadraticCost, gain: Array, mask: NDArray[np.bool_]) -> Array:
    """Where searches that start where the last one ended gain no more."""
    cost = judge(gain)
    for _ in range(AGAIN):
        gain, before = _descended(judge, gain, mask), cost
        cost = judge(gain)
        if cost > before * (1.0 - GAINED):
            break
    return gain


def _descended(judge: QuadraticCost, gain: Array, mask: NDArray[np.bool_]) -> Array:
    """Where a quasi-Newton search ends, in variables whose curvature is 1 at the start."""
    values, vectors = np.linalg.eigh(judge.curvature(gain, mask))
    unit = vectors / np.sqrt(np.maximum(values, SMALLEST * max(float(values[-1]), 1e-300)))
    start = gain[mask]

    def unpacked(z: Array) -> Array:
        trial = np.zeros_like(gain)
        trial[mask] = start + unit @ z
        return trial

    def function(z: Array) -> tuple[float, Array]:
        cost, gradient = judge.with_gradient(unpacked(z))
        return (cost if math.isfinite(cost) else 1e300), unit.T @ gradient[mask]

    found = scipy.optimize.minimize(
        function, np.zeros(len(start)), jac=True, method="BFGS", options={"gtol": 1e-12}
    )
    reached = unpacked(found.x)
    return reached if judge(reached) < judge(gain) else gain
