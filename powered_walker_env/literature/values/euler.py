"""Chen's walker with knees in steps of explicit Euler, as the program steps that found her gait.

`kneedCompassGait.m` by R. Tedrake, her thesis's supervisor, "simulates the model described in"
the thesis: explicit Euler with a fixed step of 1 ms; a step that passes knee strike or heel
strike is halved again and again, and each half that stays before the event is taken. Its gravity
is 9.8 and its slope asin(7.25/144), printed as 0.0504. Here the same steps are taken over the
formulas of `model/mechanics`, as plain Python; the error of a gait so found is of first order.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.mechanics import chain
from powered_walker_env.model.mechanics.ground import apart, last_factor
from powered_walker_env.model.mechanics.guards import knee
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.links import Chain
from powered_walker_env.model.mechanics.locking import knee_caught
from powered_walker_env.model.mechanics.packing import chains_of, constants_of
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.walker import WalkerParams

Array = NDArray[np.float64]

STEP = 1e-3  # s, the program's
HALVINGS = 56  # of a step: what is left is below rounding
LONGEST = 3.0  # s, of a stride
STRIDES = 200  # until a gait is found; its errors shrink by a third at each
SAME = 1e-13  # rad, rad/s: so near, a state is the one it was
NUDGE = 1e-7  # rad, rad/s, of the differences behind the multipliers


class SteppedStride(NamedTuple):
    """One stride in steps."""

    state: Array  # (4,) post-strike state, rad and rad/s
    knee_strike: float  # s
    duration: float  # s


class SteppedGait(NamedTuple):
    """The gait of the stepped stride, and its multipliers."""

    state: Array  # (4,)
    multipliers: NDArray[np.complex128]  # (3,), largest first


def chens_walker() -> WalkerParams:
    """The walker with the gravity and the slope of the program."""
    return PRESETS["chen2007"].params.replace(gravity=9.8, slope=math.asin(7.25 / 144))


def stepped_stride(
    state: Sequence[float] | Array, params: WalkerParams, step: float = STEP
) -> SteppedStride:
    """A stride of a passive walker with knees on point feet, by Euler steps of `step` seconds.

    Raises:
        ValueError: the knee does not strike, or the foot does not land, within three seconds.
    """
    c, chains, lock = constants_of(params), chains_of(params), params.locked_ankle_angle
    alpha, s, rate, swing = (float(x) for x in state)
    beta = s + math.pi

    def bent(y: Array) -> Any:
        straight = chain.pose_of(y[0], y[0] + lock, y[2], y[3], y[3], y[5])
        return chain.bent(straight, y[1], y[4], complex(math.cos(y[1]), math.sin(y[1])))

    def locked(y: Array) -> Any:
        return chain.pose_of(y[0], y[0] + lock, y[2], y[3], y[3], y[5])

    def hanging(y: Array) -> bool:
        return bool(knee(bent(y)) >= 0.0)

    def swinging(y: Array) -> bool:
        pose = locked(y)
        return not (apart(pose) > 0.0 and last_factor(pose, c) <= 0.0)

    y = np.array([alpha - lock, beta, beta, rate, swing, swing])
    struck, y = _until(hanging, _flow(chains.bent, c), y, step)
    pose = knee_caught(bent(y), chains.locked, chains.bent, c)
    y = np.array([pose.phi, 0.0, pose.beta, pose.dphi, 0.0, pose.dbeta])
    swung, y = _until(swinging, _flow(chains.locked, c), y, step)
    after = heel_strike(locked(y), chains.free, c)
    landed = np.array([after.alpha, after.beta - math.pi, after.dalpha, after.dbeta])
    return SteppedStride(landed, struck, struck + swung)


def _flow(links: Chain, c: Any) -> Callable[[Array], Array]:
    def flow(y: Array) -> Array:
        return np.array([*y[3:], *chain.accelerations(y.tolist(), 0.0, 0.0, links, c)])

    return flow


def _until(
    goes_on: Callable[[Array], bool], flow: Callable[[Array], Array], y: Array, step: float
) -> tuple[float, Array]:
    """Time and state up to where `goes_on` ends, the last step halved until nothing is left."""
    for number in range(math.ceil(LONGEST / step)):
        following = y + step * flow(y)
        if goes_on(following):
            y = following
            continue
        time = number * step
        for _ in range(HALVINGS):
            step *= 0.5
            following = y + step * flow(y)
            if goes_on(following):
                time, y = time + step, following
        return time, y
    raise ValueError(f"state must lead to a knee strike and a landing within {LONGEST} s")


@functools.cache
def stepped_gait(step: float = STEP) -> SteppedGait:
    """Chen's gait in steps of so many seconds, by walking until nothing changes any more."""
    params, state = chens_walker(), np.array(PRESETS["chen2007"].state)

    def after(reduced: Array) -> Array:
        """Stride map of swing angle and rates; the feet of a post-strike state are level."""
        landed = stepped_stride([-reduced[0], *reduced], params, step).state
        return landed[1:]

    reduced = state[1:]
    for _ in range(STRIDES):
        before, reduced = reduced, after(reduced)
        if np.abs(reduced - before).max() < SAME:
            break
    nudges = NUDGE * np.eye(3)
    columns = [(after(reduced + d) - after(reduced - d)) / (2.0 * NUDGE) for d in nudges]
    found = np.linalg.eigvals(np.column_stack(columns)).astype(complex)
    largest_first = np.lexsort([-found.imag, -np.abs(found).round(9)])
    return SteppedGait(np.array([-reduced[0], *reduced]), found[largest_first])
