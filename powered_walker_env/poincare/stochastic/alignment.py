"""A grid aligned with what decides where a step leads.

The singular values of a stride map are far apart (the thesis's gait: 80, 0.024, 0.0098): where a
walker lands depends on nearly one number of its state. A grid of equal nodes spends nearly all of
them on the others. So the first axis crosses the surfaces of equal landings, whatever the angle,
and the others lie in them; as the surfaces are bent, so is the coordinate (`Grid.curve`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from powered_walker_env.poincare.stochastic.grid import STRAIGHT, AnySection, Grid
from powered_walker_env.poincare.stochastic.walks import grid_around
from powered_walker_env.simulation.strides import Array

Step = Callable[[Array], Array]  # points (N, k) to landings (N, m), NaN where they fall
STENCIL = 1e-3  # spreads of the cloud, of the differences of a step
LINE = 4001  # points along the first axis, by which a landing is traced back
EVEN = 0.2  # of the second singular value to the first: from here a grid needs no alignment
PASSES = 4  # of the fit
CORE = 0.01  # share of the points on either side of each axis that a fit leaves out
FEWEST, MOST = 100, 5000  # points of a fit
SMALLEST = 1e-9  # spread along an axis


def aligned_grid(
    points: Array, step: Step, shape: Sequence[int], section: AnySection | None = None,
    tail: float = 5e-4, margin: float = 1.25,
) -> Grid:  # fmt: skip
    """The grid that holds a cloud but for its tails, its first axis across equal landings.

    Args:
        points: (M, k) where walkers are.
        step: where one leads from there, all under one control; in units of equal weight.
        shape: (k,) nodes along the axes: across equal landings, then the longer and the shorter
            one along them.
        section: of the points.
        tail: share of the points left out on either side of each axis.
        margin: of the box over what it holds.

    Raises:
        ValueError: no step walks at the cloud's middle.
    """
    centre, scale = np.median(points, axis=0), points.std(axis=0) + SMALLEST
    rng, (normal, landing, share) = np.random.default_rng(0), _steepest(step, centre, scale)
    if share > EVEN:
        return grid_around(points, section, shape, tail, margin)
    some = rng.permutation(len(points))[:MOST]
    frame = scale[:, np.newaxis] * _axes((points - centre) / scale, normal)
    curve = np.zeros(len(STRAIGHT))
    y = np.linalg.solve(frame, (points - centre).T).T
    traced = _traced(centre, frame[:, 0], y[:, 0], step(points[some]) @ landing, step, landing)
    for _ in range(PASSES):
        grid = Grid(centre, frame, tuple(shape), section, tuple(curve))
        z = 2.0 * grid.places(points)[:, : len(shape)] / (np.array(shape) - 1.0) - 1.0
        low, high = np.quantile(z, [tail, 1.0 - tail], axis=0)
        middle, half = 0.5 * (low + high), np.maximum(0.5 * margin * (high - low), SMALLEST)
        centre, frame = centre + frame @ middle, frame * half
        traced = (traced - middle[0]) / half[0]
        y = np.linalg.solve(frame, (points[some] - centre).T).T
        inner = (y >= np.quantile(y, CORE, axis=0)) & (y <= np.quantile(y, 1.0 - CORE, axis=0))
        known = np.isfinite(traced) & inner.all(axis=1)
        if len(shape) == 1 or known.sum() < FEWEST:
            curve[:] = 0.0
            continue
        constant, lines, curve = _fit(y[known], traced[known])
        centre = centre - frame[:, 0] * constant / lines[0]
        frame[:, 0] /= lines[0]
        frame[:, 1:] -= frame[:, :1] * lines[1:]
    return Grid(centre, frame, tuple(shape), section, tuple(curve))


def _steepest(step: Step, centre: Array, scale: Array) -> tuple[Array, Array, float]:
    """(k,) the gradient of the landing, of its direction (m,) that changes most, by the scale.

    Third: the second singular value over the first.
    """
    moved = STENCIL * np.concatenate([np.diag(scale), -np.diag(scale)])
    ahead, behind = np.split(step(centre + moved), 2)
    jacobian = (ahead - behind).T / (2.0 * STENCIL)
    if not np.isfinite(jacobian).all():
        raise ValueError(f"points must walk in their middle to align a grid, got {centre!r}")
    left, sizes, right = np.linalg.svd(jacobian, full_matrices=False)
    return sizes[0] * right[0], left[:, 0], float(sizes[1] / sizes[0]) if len(sizes) > 1 else 0.0


def _axes(x: Array, normal: Array) -> Array:
    """(k, k) columns: one with the cloud across the level planes, those of the cloud in them."""
    level = normal / np.linalg.norm(normal)
    t = x @ level
    first = (x * t[:, np.newaxis]).mean(axis=0) / max(float((t * t).mean()), SMALLEST)
    first = first / (first @ level)
    if len(level) == 1:
        return first[:, np.newaxis]
    rest = x - t[:, np.newaxis] * first
    # An orthonormal basis of the plane, then the cloud's own axes in it, the longer one first.
    plane = np.linalg.svd(level[np.newaxis])[2][1:].T
    _, turn = np.linalg.eigh(np.cov((rest @ plane).T).reshape(plane.shape[1], -1))
    return np.column_stack([first, plane @ turn[:, ::-1]])


def _traced(
    centre: Array, along: Array, first: Array, led: Array, step: Step, landing: Array
) -> Array:
    """(M,) where on a line through the centre a step leads as far as those; NaN where nowhere.

    Args:
        along: (k,) the line's direction.
        first: (M,) coordinates on it, which say how long it is.
        led: (M,) landings.
    """
    reach = 1.5 * np.abs(np.quantile(first, [0.001, 0.999])).max()
    line = np.linspace(-reach, reach, LINE)
    found = step(centre + line[:, np.newaxis] * along) @ landing
    sign = 1.0 if _rises(found) else -1.0
    part = _rising(sign * found)
    values = sign * found[part]
    return np.interp(sign * led, values, line[part], left=np.nan, right=np.nan)


def _fit(y: Array, traced: Array) -> tuple[float, Array, Array]:
    """Constant, (k,) lines and (5,) curve by which z₁ is nearest to what was traced."""
    n, k = y.shape
    second, third = y[:, 1], y[:, 2] if k == 3 else np.zeros(n)
    level = np.column_stack([np.ones(n), y[:, 1:], second**2, second * third, third**2])

    def off(given: Array) -> Array:
        rise = given[0] * y[:, 0] * np.exp(given[1] * second + given[2] * third)
        away: Array = rise + level @ given[3:] - traced
        return away

    begin = np.zeros(3 + level.shape[1])
    begin[0] = 1.0
    size = float(traced.std())
    found = scipy.optimize.least_squares(off, begin, loss="soft_l1", f_scale=0.1 * size).x
    lines = np.concatenate([found[:1], found[4 : 3 + k]])
    return float(found[3]), lines, np.concatenate([found[1:3], found[3 + k :]])


def _rises(along: Array) -> bool:
    """Whether a row of landings rises at its middle."""
    middle = len(along) // 2
    return bool(along[middle + 1] >= along[middle])


def _rising(along: Array) -> slice:
    """The part about the middle in which a row rises, NaN ending it."""
    with np.errstate(invalid="ignore"):
        steps: NDArray[np.bool_] = np.diff(along) > 0.0
    middle = len(along) // 2
    below = np.flatnonzero(~steps[:middle])
    above = np.flatnonzero(~steps[middle:])
    first = int(below[-1]) + 1 if len(below) else 0
    last = middle + int(above[0]) if len(above) else len(along) - 1
    return slice(first, last + 1)
