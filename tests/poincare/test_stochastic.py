"""The law of the next step: known chains exactly, walkers against plain simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg

from powered_walker_env import PRESETS, find_gait
from powered_walker_env.model.rimless_wheel import RimlessWheel
from powered_walker_env.poincare import (
    Grid,
    Law,
    StepNoise,
    disturbed_walks,
    first_passage,
    step_law,
)
from powered_walker_env.poincare.sections import Section, section_of
from powered_walker_env.poincare.stochastic.law import normal_points
from powered_walker_env.poincare.stochastic.noise import branches_of
from powered_walker_env.poincare.stochastic.steps import Stepper
from powered_walker_env.poincare.stochastic.walks import visits
from powered_walker_env.simulation.strides import Array


def law_of(grid: Grid, means: Array, spread: Array, reward: Array, points: int = 5) -> Law:
    """A law of choices (N, A): points (N, A, k), noise (k, 2) the same for all, rewards (N, A)."""
    nodes, choices, size = means.shape
    places = grid.places(means.reshape(-1, size))
    gain = np.stack([grid.steps(column[np.newaxis])[0] for column in spread.T], axis=1)
    number = nodes * choices
    return Law(
        grid,
        np.arange(nodes + 1) * choices,
        np.tile(np.arange(choices, dtype=np.int32), nodes),
        np.ones(number),
        places.astype(np.float32),
        np.tile(gain.astype(np.float32), (number, 1, 1)),
        reward.ravel().astype(np.float32),
        *normal_points(points),
    )


A = np.array([[0.9, 0.3], [-0.2, 1.05]])
B = np.array([[0.1], [0.6]])
Q, R = np.diag([1.0, 0.5]), np.array([[0.4]])
NOISE = np.diag([0.02, 0.03])


@pytest.mark.parametrize("count", [11, 21])
def test_a_linear_gaussian_map_has_the_values_of_the_riccati_equation(count: int) -> None:
    grid = Grid.box((-1.0, -1.0), (1.0, 1.0), (count, count))
    controls = np.linspace(-2.0, 2.0, 81)[:, np.newaxis]
    x = grid.points
    means = (x @ A.T)[:, np.newaxis] + controls @ B.T
    cost = np.einsum("ni,ij,nj->n", x, Q, x)[:, np.newaxis] + R[0, 0] * controls[:, 0] ** 2
    law, strides = law_of(grid, means, NOISE, -cost), 4
    values, exact, constant = np.zeros(grid.size), np.zeros((2, 2)), 0.0
    for _ in range(strides):
        values, chosen = law.best(values, outside=-50.0)
        constant += float(np.trace(NOISE.T @ exact @ NOISE))
        K = np.linalg.solve(R + B.T @ exact @ B, B.T @ exact @ A)
        exact = Q + A.T @ exact @ (A - B @ K)
    inner = np.abs(x).max(axis=1) <= 0.5  # whose steps stay on the grid
    known = np.einsum("ni,ij,nj->n", x, exact, x) + constant
    np.testing.assert_allclose(-values[inner], known[inner], atol=2e-3)
    best = controls[chosen[inner], 0]
    np.testing.assert_allclose(best, -(x[inner] @ K.T)[:, 0], atol=0.03)  # half a step, and more
    np.testing.assert_allclose(K, _gain(exact_after(strides - 1)))


def exact_after(strides: int) -> Array:
    P = np.zeros((2, 2))
    for _ in range(strides):
        P = Q + A.T @ P @ A - A.T @ P @ B @ np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    return P


def _gain(P: Array) -> Array:
    gain: Array = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    return gain


def test_the_riccati_recursion_goes_to_the_algebraic_equation() -> None:
    np.testing.assert_allclose(exact_after(400), scipy.linalg.solve_discrete_are(A, B, Q, R))


WHEEL = RimlessWheel.with_spokes(8, 0.08)


def wheel_step(rate: Array, slope: Array) -> Array:
    """The rimless wheel's rate after a step on a slope of its own; NaN where it falls back."""
    gained = 4.0 * math.sin(WHEEL.half_angle) * np.sin(slope)
    least = 2.0 * (1.0 - np.cos(WHEEL.half_angle - slope))
    with np.errstate(invalid="ignore"):
        after = WHEEL.retained * np.sqrt(rate**2 + gained)
    return np.where(rate**2 > least, after, np.nan)


@pytest.fixture(scope="module")
def simulated_wheel() -> tuple[float, float]:
    """Share of rough steps that a rimless wheel rolls on over, by brute force, and its error."""
    rng, rates, rolled, fell = np.random.default_rng(0), np.full(40_000, WHEEL.steady_rate), 0, 0
    for k in range(400):
        after = wheel_step(rates, WHEEL.slope + 0.035 * rng.normal(size=len(rates)))
        down = np.isnan(after)
        if k >= 20:
            rolled, fell = rolled + int((~down).sum()), fell + int(down.sum())
        rates = np.where(down, rates[rng.integers(len(rates), size=len(rates))], after)
        rates[np.isnan(rates)] = WHEEL.steady_rate
    total = rolled + fell
    return rolled / total, math.sqrt(rolled * fell / total**3)


def test_the_rimless_wheel_on_rough_ground_falls_as_often_as_simulated(
    simulated_wheel: tuple[float, float],
) -> None:
    known, error = simulated_wheel
    found = []
    for count in (20, 40, 60):
        grid = Grid.box([0.05], [1.4], [count])
        drawn = branches_of(StepNoise(step_height=0.035), 200)
        after = wheel_step(grid.points, WHEEL.slope + drawn.height[np.newaxis])
        node, branch = np.nonzero(np.isfinite(after))
        law = Law(
            grid,
            np.concatenate([[0], np.cumsum(np.bincount(node, minlength=count))]),
            np.zeros(len(node), np.int32),
            drawn.share[branch],
            grid.places(after[node, branch][:, np.newaxis]).astype(np.float32),
            np.zeros((len(node), 3, 2), np.float32),
            np.ones(len(node), np.float32),
            np.zeros((1, 2)),
            np.ones(1),
        )
        alive = np.ones(count)
        for _ in range(300):
            after_one, _ = law.best(alive, gain=0.0)
            share, alive = float(after_one @ alive / (alive @ alive)), after_one
        found.append(share)
        linear = np.ones(count)
        for _ in range(300):
            linear, last = law.best(linear, gain=0.0, curved=False)[0], linear
        (largest,) = scipy.sparse.linalg.eigs(law.matrix(), k=1, return_eigenvectors=False)
        assert linear[count // 2] / last[count // 2] == pytest.approx(largest.real, abs=1e-9)
    assert abs(found[2] - found[1]) < 0.5 * abs(found[1] - found[0]) + 1e-6
    assert abs(found[2] - known) < 4.0 * error + 2e-4
    assert known < 0.999


def test_a_matrix_is_of_probabilities_and_only_of_one_choice() -> None:
    grid = Grid.box((-1.0, -1.0), (1.0, 1.0), (7, 6))
    means = np.repeat((grid.points @ (0.5 * A).T)[:, np.newaxis], 2, axis=1)
    law = law_of(grid, means, NOISE, np.ones((grid.size, 2)))
    with pytest.raises(ValueError, match="law must have one choice at every node"):
        law.matrix()
    chosen = np.ones(grid.size, np.int32)
    chosen[0] = -1
    matrix = law.under(chosen).matrix()
    sums = np.asarray(matrix.sum(axis=1)).ravel()
    assert (matrix.data > 0).all() and sums[0] == 0
    np.testing.assert_allclose(sums[1:], 1.0)
    first = law.among(np.array([False, True]))
    np.testing.assert_array_equal(first.choice, 0)
    assert first.rows == law.rows // 2


def test_a_law_reproduces_a_quadratic_and_stays_within_its_table() -> None:
    grid = Grid(np.array([0.3, -0.2, 1.0]), np.array([[1.0, 0.2, 0], [0, 2.0, 0.1], [0, 0, 0.5]]),
                (9, 8, 7))  # fmt: skip
    inside = np.random.default_rng(0).uniform(-0.7, 0.7, (grid.size, 3))
    means = (grid.centre + inside @ grid.frame.T)[:, np.newaxis]
    law = law_of(grid, means, np.zeros((3, 2)), np.zeros((grid.size, 1)), points=1)

    def function(p: Array) -> Array:
        return 10.0 + p @ [3.0, 1.0, -2.0] + 0.3 * (p[:, 0] ** 2 - p[:, 1] * 0.2)  # type: ignore[no-any-return]

    curved, _ = law.best(function(grid.points))
    linear, _ = law.best(function(grid.points), curved=False)
    exact = function(means[:, 0])
    assert np.abs(curved - exact).max() < 0.3 * np.abs(linear - exact).max()
    np.testing.assert_allclose(grid.at(function(grid.points)[:, np.newaxis], means[:, 0])[:, 0],
                               linear, atol=1e-5)  # fmt: skip
    steep = np.where(grid.points[:, 0] > 0.3, 1.0, 0.0)
    found, _ = law.best(steep)
    assert found.min() >= 0.0 and found.max() <= 1.0


@pytest.mark.parametrize(
    ("name", "noise"),
    [
        ("compass", StepNoise(step_height=0.004)),
        ("round-foot", StepNoise(push=0.02)),
        ("toe-off", StepNoise(push=0.004, strength=0.1)),
    ],
)
def test_first_passage_is_that_of_plain_walks(name: str, noise: StepNoise) -> None:
    params, control, state, _ = PRESETS[name]
    shape, branches = (14, 17) if noise.strength else (20, 49)  # one more number is drawn
    found = first_passage(params, control, noise, state, shape=shape, walks=6000, branches=branches)
    mean, error = found.walks.mean
    assert abs(found.mean_strides - mean) < 4.0 * error + found.strides_error + 0.02 * mean
    rate, deviation = found.walks.fall_rate()
    off = abs(1.0 - found.second_eigenvalue - rate)
    assert off < 4.0 * deviation + found.eigenvalue_error + 2e-3
    assert (np.diff(found.survival) <= 1e-9).all() and found.survival[0] <= 1.0
    assert "second eigenvalue" in repr(found)


def test_the_compass_gait_on_rough_ground_has_the_known_eigenvalue() -> None:
    params, control, state, _ = PRESETS["compass"]
    assert params.slope == pytest.approx(math.radians(3.0))
    noise = StepNoise(step_height=0.004)
    found = first_passage(params, control, noise, state, shape=24, walks=3000)
    assert found.second_eigenvalue == pytest.approx(0.900, abs=1e-3)
    assert 9.9 < found.mean_first_passage < 10.1
    assert abs(found.second_eigenvalue - found.coarser_eigenvalue) < 2e-3
    assert found.eigenvalue_error >= abs(1.0 - found.second_eigenvalue - found.walks.fall_rate()[0])


@pytest.mark.parametrize("name", ["round-foot", "camp1997"])
def test_a_push_is_carried_to_the_section_by_a_quadratic(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    push = {"round-foot": 0.02, "camp1997": 0.005}[name]
    section = section_of(params, control, (3.05, 4000.0))
    centre = section.points([state])[0]
    grid = Grid.box(centre - 0.5, centre + 0.5, (11, 11, 11), section)
    stepper = Stepper(params, control, grid, StepNoise(push=push), 1e-9)
    places, gain, bend = stepper.landed(np.array([state]))
    # Falls are of pushes that are rare: three standard deviations and more.
    around = np.linspace(0.0, 2.0 * np.pi, 60)
    draws = 3.5 * np.column_stack([np.cos(around), np.sin(around)])
    pushed = np.tile(state, (60, 1))
    pushed[:, 2:] += push * draws
    exact = grid.places(section.points(pushed))
    linear = places[0] + draws @ gain[0].T
    x, y = draws.T
    curved = linear + np.column_stack([x * x, x * y, y * y]) @ bend[0].T
    scatter = np.abs(exact - places[0]).mean()
    assert np.abs(exact - linear).mean() < 0.05 * scatter
    assert np.abs(exact - curved).mean() < 0.2 * np.abs(exact - linear).mean()


def test_where_far_pushes_do_not_come_to_the_section_near_ones_say_how_it_bends() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    section = section_of(params, control, (3.05, 4000.0))
    grid = Grid.box((-0.4, -0.4, -1.2), (0.6, 0.6, -0.2), (11, 11, 11), section)
    stepper = Stepper(params, control, grid, StepNoise(push=0.02), 1e-9)
    slow = np.tile(state, (40, 1))
    slow[:, 2:] *= np.linspace(1.0, 0.5, 40)[:, np.newaxis]
    far = np.isnan(stepper._pushed(slow, stepper._swung(slow), 2.5)[0]).any(axis=(1, 2))
    near = np.isnan(stepper._pushed(slow, stepper._swung(slow), 0.1)[0]).any(axis=(1, 2))
    _, gain, bend = stepper.landed(slow)
    assert (far & ~near).any() and near.any()
    np.testing.assert_array_equal(np.isnan(gain).any(axis=(1, 2)), near)
    np.testing.assert_array_equal(np.isnan(bend).any(axis=(1, 2)), near)


def test_walks_are_seeded_and_their_visits_are_on_the_section() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    noise, section = StepNoise(push=0.02, strength=0.02), section_of(params, control)
    one = disturbed_walks(params, control, noise, state, walks=50, seed=3)
    two, met = visits(params, control, noise, state, section, walks=50, seed=3)
    np.testing.assert_array_equal(one.strides, two.strides)
    assert len(met.point) <= (one.strides + 1).sum()
    assert one.mean_reward[0] == pytest.approx(one.strides.mean())
    still = disturbed_walks(params, control, StepNoise(), state, walks=2, strides=20)
    assert not still.fell.any() and still.strides.tolist() == [20, 20]
    gait = find_gait(params, control, state)
    np.testing.assert_allclose(section.points([gait.state]), section.points([state]), atol=1e-6)


def test_what_makes_no_sense_is_refused() -> None:
    params, control, state, _ = PRESETS["compass"]
    feet = Grid.box((-0.4, 0.5, 0.0), (-0.1, 1.5, 1.0), (6, 6, 6), Section(params))
    with pytest.raises(ValueError, match="push must not be negative, got -1"):
        StepNoise(push=-1.0)
    with pytest.raises(ValueError, match="hip angle for ground that is not level"):
        step_law(params, control, feet, StepNoise(step_height=0.001))
    with pytest.raises(ValueError, match="grid must lie on the section of a walker"):
        step_law(params, control, Grid.box((0,), (1,), (4,)), StepNoise(push=0.1))
    simplest = PRESETS["simplest"].params
    flat = Grid.box((-0.4, 0.1), (-0.1, 0.4), (6, 6), Section(simplest))
    with pytest.raises(ValueError, match="for pushes on a massless point foot"):
        step_law(simplest, None, flat, StepNoise(push=0.001))
    with pytest.raises(ValueError, match="noise must disturb the walker"):
        first_passage(params, control, StepNoise(), state)
    with pytest.raises(ValueError, match="noise must leave walks of 8 strides"):
        first_passage(params, control, StepNoise(step_height=0.5), state, walks=200)
    with pytest.raises(ValueError, match="low must be below high"):
        Grid.box((0.0,), (0.0,), (4,))
    with pytest.raises(ValueError, match="frame must have axes that span"):
        Grid(np.zeros(2), np.ones((2, 2)), (4, 4))
    with pytest.raises(ValueError, match="shape must be 1 counts"):
        Grid.box((0.0,), (1.0,), (4, 4))
    with pytest.raises(ValueError, match="to have states, got none"):
        assert Grid.box((0.0,), (1.0,), (4,)).states
