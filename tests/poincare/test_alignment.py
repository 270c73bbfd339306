"""Grids aligned with what decides where a step leads: curved maps, and far-from-normal ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.stats

from powered_walker_env import PRESETS, find_gait
from powered_walker_env.poincare import Grid, capture
from powered_walker_env.poincare.sections import section_of
from powered_walker_env.poincare.stochastic.alignment import aligned_grid
from powered_walker_env.poincare.stochastic.law import normal_points, push_counts, turned
from powered_walker_env.poincare.stochastic.plane import landing_plane
from powered_walker_env.poincare.stochastic.walks import grid_around
from powered_walker_env.simulation.strides import Array
from tests.poincare.test_stochastic import law_of

LEFT, _ = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [-0.6, 1.0, 0.1], [0.5, 0.3, -1.0]]))
RIGHT, _ = np.linalg.qr(np.array([[0.8, 0.5, -0.3], [0.7, -0.9, 0.4], [0.3, 0.6, 1.0]]))
A = LEFT @ np.diag([80.0, 0.02, 0.01]) @ RIGHT.T
B = RIGHT[:, :1] * 0.02 + RIGHT[:, 1:2] * 0.01  # moves what the next step depends on
NOISE = np.array([[0.0, 0.0], [0.006, 0.0], [0.0, 0.009]])
Q, R = np.eye(3), np.array([[0.05]])
P: Array = scipy.linalg.solve_discrete_are(A, B, Q, R)
K: Array = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
A_STRIDE = float(np.trace(NOISE.T @ P @ NOISE))  # cost of the noise
STRIDES = 4


def cloud() -> Array:
    """Where the regulated map walks, pushed at every step."""
    rng, x, points = np.random.default_rng(0), np.zeros((4000, 3)), []
    for _ in range(6):
        x = x @ (A - B @ K).T + rng.normal(size=(len(x), 2)) @ NOISE.T
        points.append(x)
    return np.concatenate(points[2:])


def missed(grid: Grid, points: Array) -> float:
    """Error of the values at points against Riccati's, over their spread (root mean squares).

    The costs to come beyond so many strides are Riccati's; so must be those of all.
    """
    x = grid.points
    controls = -(x @ K.T) + np.linspace(-1.0, 1.0, 5)  # the best among them
    means = (x @ A.T)[:, np.newaxis] + controls[:, :, np.newaxis] * B[:, 0]
    cost = np.einsum("ni,ij,nj->n", x, Q, x)[:, np.newaxis] + R[0, 0] * controls**2
    law, values = law_of(grid, means, NOISE, -cost), -np.einsum("ni,ij,nj->n", x, P, x)
    for _ in range(STRIDES):
        values, _ = law.best(values, outside=float(values.min()))
    known = np.einsum("ni,ij,nj->n", points, P, points)
    found = -grid.at(values[:, np.newaxis], points)[:, 0] - STRIDES * A_STRIDE
    return float(np.sqrt(np.mean((found - known) ** 2)) / known.std())


def test_where_singular_values_are_far_apart_nodes_pay_along_one_axis_only() -> None:
    points = cloud()
    off = np.abs((points - points.mean(axis=0)) / points.std(axis=0)).max(axis=1)
    inner, reach = points[off < 1.5][:300], 1.25 * np.abs(points).max(axis=0)
    cube = Grid.box(-reach, reach, (12, 12, 12))
    own = grid_around(points, None, (12, 12, 12))
    aligned = aligned_grid(points, lambda x: x @ A.T, (48, 6, 6))
    assert aligned.size == cube.size
    assert missed(cube, inner) > 1.0  # as much as there is to know, or more
    assert missed(aligned, inner) < 0.06
    assert missed(aligned, inner) < 0.6 * missed(own, inner)
    across = np.linalg.solve(aligned.frame, RIGHT[:, 0])
    along = RIGHT.T @ aligned.frame[:, 1:]
    assert abs(across[0]) > 0 and np.abs(along[0]).max() < 1e-6 * np.abs(along[1:]).max()


def bent(points: Array) -> Array:
    """A map that tells points apart by one number, and not a linear one."""
    x, y, z = points.T
    told = x * np.exp(0.8 * y) + 0.5 * y**2 - 0.2 * y * z + 0.1 * z**2
    return np.column_stack([50.0 * np.tanh(told), 0.1 * y, 0.05 * z])


def test_a_curved_coordinate_is_that_of_equal_landings() -> None:
    points = np.random.default_rng(1).normal(size=(4000, 3)) * [0.15, 0.2, 0.2]
    grid = aligned_grid(points, bent, (31, 6, 6))
    assert grid.aligned
    places, led = grid.places(points)[:, 0], bent(points)[:, 0]
    order = np.argsort(places)
    smooth = np.convolve(led[order], np.ones(9) / 9, "same")
    off = (led[order] - smooth)[50:-50]
    straight = np.argsort(points[:, 0])
    rough = (led[straight] - np.convolve(led[straight], np.ones(9) / 9, "same"))[50:-50]
    assert off.std() < 0.1 * rough.std()
    counted = np.array(list(np.ndindex(grid.shape)), float)
    np.testing.assert_allclose(grid.places(grid.points), counted, atol=1e-8)
    again = grid.resized((7, 5, 4))
    assert again.curve == grid.curve
    np.testing.assert_allclose(again.places(grid.centre[np.newaxis])[0], [3.0, 2.0, 1.5], atol=1e-9)


def test_a_law_on_a_curved_grid_reads_its_table_where_the_grid_does() -> None:
    grid = Grid(np.array([0.3, -0.2, 1.0]), np.array([[1.0, 0.2, 0], [0, 2.0, 0.1], [0, 0, 0.5]]),
                (9, 8, 7), curve=(0.4, -0.3, 0.2, -0.1, 0.15))  # fmt: skip
    inside = np.random.default_rng(0).uniform(-0.6, 0.6, (grid.size, 3))
    means = grid.centre + inside @ grid.frame.T
    law = law_of(grid, means[:, np.newaxis], np.zeros((3, 2)), np.zeros((grid.size, 1)), points=1)
    law = replace(law, mean=grid.straight_places(means).astype(np.float32))
    table = np.random.default_rng(2).normal(size=grid.size) + 5.0
    found, _ = law.best(table, curved=False)
    np.testing.assert_allclose(found, grid.at(table[:, np.newaxis], means)[:, 0], atol=1e-4)
    np.testing.assert_allclose(law.matrix() @ table, found, atol=1e-9)


def test_turned_noise_is_the_same_noise() -> None:
    rng = np.random.default_rng(3)
    gain, bend = rng.normal(size=(20, 3, 2)), rng.normal(size=(20, 3, 3))
    gain[0, 0] = 0.0
    other, bent_too = turned(gain, bend)
    np.testing.assert_allclose(other @ other.transpose(0, 2, 1), gain @ gain.transpose(0, 2, 1))
    np.testing.assert_allclose(other[:, 0, 1], 0.0, atol=1e-15)
    # The same push, in the numbers of both, leads to the same place.
    u, v = 0.7, -1.3
    for k in range(20):
        size = np.hypot(*gain[k, 0])
        c, s = gain[k, 0] / size if size else (1.0, 0.0)
        x, y = c * u - s * v, s * u + c * v
        led = gain[k] @ [x, y] + bend[k] @ [x * x, x * y, y * y]
        np.testing.assert_allclose(other[k] @ [u, v] + bent_too[k] @ [u * u, u * v, v * v], led)


def test_equal_spaces_are_exact_for_smooth_values_and_see_a_cliff() -> None:
    for counts in ((5, 3), (11, 3), (31, 3)):
        points, weights = normal_points(counts)
        for power, moment in ((0, 1.0), (1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)):
            assert weights @ points[:, 0] ** power == pytest.approx(moment, abs=2e-3)
    np.testing.assert_array_equal(normal_points((5, 5))[0], normal_points(5)[0])
    # Where no axis is the one of the cliffs both numbers see them alike.
    assert push_counts(Grid(np.zeros(3), np.eye(3), (4, 4, 4), curve=(0.1, 0, 0, 0, 0))) == (31, 3)
    points, weights = normal_points(push_counts(Grid.box((0.0,), (1.0,), (4,))))
    turned_over = np.lexsort(points.T)
    np.testing.assert_array_equal(points[turned_over][:, ::-1], points)
    np.testing.assert_allclose(weights[turned_over], weights)
    # A chance of falling, off a ramp as wide as the spaces (a cliff between two nodes of a table).
    width, middle = 0.3, np.linspace(-3.5, -1.5, 201)

    def seen(counts: int | tuple[int, int]) -> Array:
        points, weights = normal_points(counts)
        ramps = np.clip((middle[:, np.newaxis] - points[:, 0]) / width + 0.5, 0.0, 1.0)
        return ramps @ weights

    def below(x: Array) -> Array:
        area: Array = x * scipy.stats.norm.cdf(x) + scipy.stats.norm.pdf(x)
        return area

    share = (below(middle + 0.5 * width) - below(middle - 0.5 * width)) / width
    assert np.abs(seen((31, 1)) / share - 1.0).max() < 0.1
    assert np.abs(seen(11) / share - 1.0).max() > 0.8


def test_choices_left_early_would_not_have_been_the_best() -> None:
    rng, grid = np.random.default_rng(4), Grid.box((-1.0, -1.0), (1.0, 1.0), (9, 8))
    means = rng.uniform(-0.9, 0.9, (grid.size, 12, 2))
    for sign in (1.0, -1.0):
        law = law_of(grid, means, 0.3 * np.eye(2), 0.2 * sign * rng.random((grid.size, 12)))
        law = replace(law, bend=0.2 * rng.normal(size=law.bend.shape).astype(np.float32))
        values = sign * rng.random(grid.size)
        best, chosen = law.best(values, 0.9, outside=-0.3)
        alone = np.column_stack([
            law.under(np.full(grid.size, each, np.int32)).best(values, 0.9, outside=-0.3)[0]
            for each in range(12)
        ])  # fmt: skip
        np.testing.assert_array_equal(best, alone.max(axis=1))
        np.testing.assert_array_equal(chosen, alone.argmax(axis=1))


def test_knees_leave_three_numbers() -> None:
    params, control, state, _ = PRESETS["kneed"]
    gait = find_gait(params, control, state)
    plane = landing_plane(gait)
    states = np.array(gait.state) + 1e-4 * np.random.default_rng(0).normal(size=(30, 4))
    moved = plane.states(plane.points(states))
    # To first order nothing is lost: what a stride makes of both is the same.
    led = (states - moved) @ gait.jacobian.T
    assert np.abs(led).max() < 1e-3 * np.abs((states - gait.state) @ gait.jacobian.T).max()
    np.testing.assert_allclose(moved[:, :2].sum(axis=1), sum(gait.state[:2]))
    straight = find_gait(*PRESETS["round-foot"][:3])
    assert landing_plane(straight).coordinates == ("stance_angle", "stance_rate", "swing_rate")
    assert "landings" in str(plane) and plane.columns == [0, 2, 3]


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(ValueError, match="curve must be 5 finite numbers"):
        Grid(np.zeros(1), np.eye(1), (4,), curve=(1.0,))
    with pytest.raises(ValueError, match="curve must have"):
        Grid(np.zeros(1), np.eye(1), (4,), curve=(30.0, 0, 0, 0, 0))
    with pytest.raises(ValueError, match="points must walk in their middle"):
        aligned_grid(cloud(), lambda x: np.full_like(x, np.nan), (6, 6, 6))
    params, control, state, _ = PRESETS["round-foot"]
    gait = find_gait(params, control, state)
    on = section_of(params, control, (2.9, 4000.0))
    curved = Grid(on.points([gait.state])[0], 0.1 * np.eye(3), (4, 4, 4), on, (0.1, 0, 0, 0, 0))
    with pytest.raises(ValueError, match="grid must not be curved"):
        capture(gait, (0.1, 100.0), grid=curved)
