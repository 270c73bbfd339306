"""Deadbeat control: back on the gait in as few strides as the map allows.

Of the linear map x⁺ = A x + B a, V₀ = {0} and Vⱼ is where one stride can lead into Vⱼ₋₁: where
j strides are enough. All states are in Vₙ for some n if [B, AB, A²B, ...] reaches what A does not
forget by itself. A feedback that leads each Vⱼ into Vⱼ₋₁, with the least actions that do, makes
(A − BK)ⁿ = 0 (minimum-time deadbeat; Kučera 1972, Kybernetika 8, 431-447).

Singular values below `TOLERANCE` of the largest of A count as zero: derivatives of strides are
known to about 1e-10 of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray

from powered_walker_env.controllers.linear import LinearFeedback, LinearMap, linearise
from powered_walker_env.envs.task import Task
from powered_walker_env.model.checks import whole_number
from powered_walker_env.simulation.strides import Array

TOLERANCE = 1e-7
ORTHOGONAL = 1e-6  # of unit vectors: what is left of one inside a subspace is rounding
PUSHES, SEED = 400, 70_000  # pushes drawn
MORE = 2  # strides beyond the fewest that are looked at, too


class DeadbeatAnswer(NamedTuple):
    """In how many strides, and within which bounds."""

    rank: int  # of A: numbers that a stride depends on
    controllable: int  # rank of [B, AB, A²B, A³B]
    dimensions: tuple[int, ...]  # of V₁, V₂, ...: states that are back in 1, 2, ... strides
    strides: int | None  # the fewest that do for every state, None if it is not possible
    gain: Array | None  # (k, 4) action = −gain · observation that takes so many
    feedback_share: float  # of pushes (off the gait) whose actions, under it, stay in bounds
    needed: dict[int, Array]  # by strides: (pushes,) the least bound that some actions stay within

    def share(self, strides: int) -> float:
        """Of pushes that can be undone in so many strides within bounds, as if linear."""
        return float(np.mean(self.needed[strides] <= 1.0))


class Deadbeat(LinearFeedback):
    """Linear feedback under which every small deviation is gone after the fewest strides.

    Args:
        task: of the environment.

    Raises:
        ValueError: a gait that cannot be reached so, or one of several strides.
    """

    def __init__(self, task: Task) -> None:
        dimensions, gain = minimum_time(linearise(task))
        if gain is None:
            raise ValueError(
                "task must have a controllable step map for deadbeat control: only "
                f"{dimensions[-1]} of 4 dimensions are led back to the gait"
            )
        #: The strides it takes.
        self.strides = len(dimensions)
        super().__init__(gain)


def deadbeat_answer(task: Task, *, pushes: int = PUSHES, seed: int = SEED) -> DeadbeatAnswer:
    """In how many strides deadbeat control is possible at all, and whether actions suffice.

    Args:
        task: of the environment; pushes as in its disturbance ("light" where it has none).
        pushes: drawn, off the gait.
        seed: of the draws.

    Raises:
        ValueError: a gait of several strides, a count that makes no sense.
    """
    linear = linearise(task)
    A, B = linear.A, linear.B
    least = TOLERANCE * float(np.linalg.norm(A, 2))
    powers = [np.linalg.matrix_power(A, i) @ B for i in range(4)]
    dimensions, gain = minimum_time(linear)
    rng = np.random.default_rng(seed)
    drawn = rng.normal(size=(whole_number("pushes", pushes, 1), 4)) * np.sqrt(
        np.diag(linear.pushes)
    )
    fewest = None if gain is None else len(dimensions)
    horizons = range(0) if fewest is None else range(fewest, fewest + MORE + 1)
    return DeadbeatAnswer(
        rank=int(np.linalg.matrix_rank(A, least)),
        controllable=int(np.linalg.matrix_rank(np.hstack(powers), least)),
        dimensions=dimensions,
        strides=fewest,
        gain=gain,
        feedback_share=0.0 if gain is None else float(np.mean(_obeyed(linear, gain, drawn))),
        needed={n: _needed(linear, n, drawn) for n in horizons},
    )


def minimum_time(linear: LinearMap) -> tuple[tuple[int, ...], Array | None]:
    """Dimensions of V₁, V₂, ... until they grow no more, and the feedback if the last is all."""
    A, B = linear.A, linear.B
    least = TOLERANCE * float(np.linalg.norm(A, 2))
    gain, V = np.zeros((B.shape[1], 4)), np.zeros((4, 0))
    dimensions: list[int] = []
    while V.shape[1] < 4:
        away = np.eye(4) - V @ V.T
        undo = np.linalg.pinv(away @ B, rcond=_relative(away @ B, least)) @ away @ A
        larger = _kernel(away @ (A - B @ undo), least)
        if larger.shape[1] <= V.shape[1]:
            return tuple(dimensions), None
        fresh = scipy.linalg.orth(larger - V @ (V.T @ larger), rcond=ORTHOGONAL)
        gain += undo @ fresh @ fresh.T
        V = np.hstack([V, fresh])
        dimensions.append(V.shape[1])
    return tuple(dimensions), gain


def _relative(matrix: Array, least: float) -> float:
    """A singular value as a share of the largest."""
    return min(least / max(float(np.linalg.norm(matrix, 2)), least), 1.0)


def _kernel(matrix: Array, least: float) -> Array:
    """An orthonormal basis (4, m) of what a matrix (n, 4) takes to less than `least`."""
    _, values, rows = np.linalg.svd(matrix)
    basis: Array = rows[int(np.sum(values > least)) :].T
    return basis


def _obeyed(linear: LinearMap, gain: Array, drawn: Array) -> NDArray[np.bool_]:
    """Whether the actions that follow each push stay within ±1."""
    good, x = np.ones(len(drawn), np.bool_), drawn
    for _ in range(4):
        good &= (np.abs(x @ gain.T) <= 1.0).all(axis=1)
        x = x @ linear.closed(gain).T
    return good


def _needed(linear: LinearMap, strides: int, drawn: Array) -> Array:
    """The least b such that actions in ±b lead each push back in so many strides (an LP each)."""
    A, B = linear.A, linear.B
    reach = np.hstack([np.linalg.matrix_power(A, strides - 1 - i) @ B for i in range(strides)])
    left, values, _ = np.linalg.svd(reach, full_matrices=False)
    rows = left[:, values > TOLERANCE * float(np.linalg.norm(A, 2))].T
    count = reach.shape[1]
    weights = np.append(np.zeros(count), 1.0)
    within = np.block(
        [[np.eye(count), -np.ones((count, 1))], [-np.eye(count), -np.ones((count, 1))]]
    )
    equal = np.hstack([rows @ reach, np.zeros((len(rows), 1))])
    targets = -(rows @ np.linalg.matrix_power(A, strides) @ drawn.T).T
    free = [(None, None)] * count + [(0.0, None)]
    return np.array([
        scipy.optimize.linprog(
            weights, A_ub=within, b_ub=np.zeros(2 * count), A_eq=equal, b_eq=target, bounds=free,
        ).fun
        for target in targets
    ])  # fmt: skip
