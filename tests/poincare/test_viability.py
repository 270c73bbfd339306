"""Viability: rescues that are real, losses that are complete, and the regulator behind both."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, find_gait
from powered_walker_env.poincare import StrideMap
from powered_walker_env.poincare.regions.basins import basin
from powered_walker_env.poincare.regions.viability import Viability, viable_states
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.simulation.strides import Array, stride_batch

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
assert CONTROL is not None
GAIT = find_gait(PARAMS, CONTROL, STATE)
REACH = (0.2, 0.3 * CONTROL.stall_torque)
HOPELESS = (-1.0, 0.2, 0.0, 0.0)
STARTS = np.vstack([[STATE, HOPELESS], np.random.default_rng(0).normal(STATE, 0.04, (22, 4))])


@pytest.fixture(scope="module")
def found() -> Viability:
    return viable_states(GAIT, REACH, STARTS, grid=(4, 4), depth=6, width=4, backend="threading")


def test_the_gait_is_safe_and_a_fallen_walker_is_lost(found: Viability) -> None:
    assert found.saved[0] == 0
    assert (found.saved[1], found.lost[1], found.walked[1]) == (-1, 0, 0)
    sure, possible = found.bounds
    assert 0 < sure < possible < 1


def test_what_is_lost_is_not_saved_and_every_number_fits_the_others(found: Viability) -> None:
    assert not ((found.saved >= 0) & (found.lost >= 0)).any()
    gone = found.lost >= 0
    np.testing.assert_array_equal(found.walked[gone], found.lost[gone])
    assert (found.walked[found.saved >= 0] == found.saved[found.saved >= 0]).all()
    assert (found.first_control >= found.low).all() and (found.first_control <= found.high).all()


def test_the_first_control_of_a_rescue_leads_to_a_shorter_rescue(found: Viability) -> None:
    rows = np.flatnonzero(found.saved > 0)
    batch = stride_batch(found.states[rows], found.first_control[rows], PARAMS, rtol=1e-8)
    assert batch.walked.all()
    after = viable_states(
        GAIT, REACH, batch.state, grid=(4, 4), depth=5, width=4, backend="threading"
    )
    assert (after.saved >= 0).all()
    assert (after.saved <= found.saved[rows] - 1).all()


def test_the_best_control_saves_all_that_the_regulator_saves_and_more(found: Viability) -> None:
    policy = regulate(GAIT, REACH)
    closed = find_gait(PARAMS, policy, STATE)
    ours = basin(PARAMS, policy, STARTS, strides=6, gaits=[closed], backend="threading")
    regulated = ours.attractor == 0
    assert (found.saved[regulated] >= 0).all()
    assert (found.saved >= 0).sum() > regulated.sum()


def test_lost_after_one_stride_means_that_no_control_of_the_grid_walks() -> None:
    lost = STARTS[2:][:, np.newaxis] * [[[1.0, 1.0, 0.7, 1.0]]]
    found = viable_states(
        GAIT, REACH, lost[:, 0], grid=(3, 3), depth=1, width=9, backend="threading"
    )
    angles = np.linspace(found.low[0], found.high[0], 3)
    torques = np.linspace(found.low[1], found.high[1], 3)
    walks = np.zeros(len(lost), np.bool_)
    for angle in angles:
        for torque in torques:
            batch = stride_batch(lost[:, 0], [angle, torque], PARAMS, rtol=1e-8)
            walks |= batch.walked
    gone = found.lost == 0
    assert gone.any() and not walks[gone].any()
    assert (found.walked[walks] == 1).all()


def longest_walk(state: Array, strides: int, counts: tuple[int, int]) -> int:
    """Strides, up to so many, that some sequence of a grid of controls walks: all are tried."""
    low, high = np.subtract([CONTROL.switch_angle, CONTROL.stall_torque], REACH), np.add(
        [CONTROL.switch_angle, CONTROL.stall_torque], REACH
    )  # fmt: skip
    axes = [np.linspace(*ends) for ends in zip(low, high, counts, strict=True)]
    controls = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    states = state[np.newaxis]
    for k in range(strides):
        starts = np.repeat(states, len(controls), axis=0)
        batch = stride_batch(starts, np.tile(controls, (len(states), 1)), PARAMS, rtol=1e-8)
        if not batch.walked.any():
            return k
        states = batch.state[batch.walked]
    return strides


def test_labels_converge_with_the_grid_and_agree_with_an_exhaustive_search() -> None:
    scattered = np.random.default_rng(0).normal(STATE, 0.06, (200, 4))
    regulated = StrideMap(PARAMS, regulate(GAIT, REACH), 1e-8)(scattered, 3)
    starts = scattered[np.isnan(regulated).any(axis=1)]  # the doubtful ones
    coarse, fine = (
        viable_states(GAIT, REACH, starts, grid=grid, depth=3, backend="threading")
        for grid in (5, 9)  # the finer one has more controls than walkers are kept
    )
    for found in (coarse, fine):
        assert (found.lost == 0).sum() >= 50 and (found.lost == 1).sum() >= 10
    assert not ((coarse.lost >= 0) & (fine.saved >= 0)).any()
    assert not ((fine.lost >= 0) & (coarse.saved >= 0)).any()
    assert np.mean(coarse.lost != fine.lost) < 0.05
    for row in np.flatnonzero(fine.lost == 0)[:20].tolist():
        assert longest_walk(starts[row], 1, (61, 61)) == 0
    for row in np.flatnonzero(fine.lost == 1).tolist():
        assert longest_walk(starts[row], 2, (17, 17)) == 1


def test_the_regulator_is_linear_within_bounds_and_knows_its_derivative() -> None:
    policy = regulate(GAIT, REACH)
    np.testing.assert_allclose(policy(np.array([STATE]))[0], [2.704, 3371.8])
    far = policy(np.array([STATE]) + 10.0)
    assert (far >= policy.low).all() and (far <= policy.high).all()
    np.testing.assert_array_equal(policy.derivative(np.array([STATE]))[0], policy.gain)
    assert not policy.derivative(np.array([STATE]) + 10.0).any()
    assert policy.costs(np.array([STATE]) + 0.01)[0] > 0
    wide = regulate(GAIT, (3.0, 1e5))
    assert wide.low[1] == 0.0 and 0 < wide.low[0] < wide.high[0] < 2 * np.pi


def test_bad_searches_are_refused() -> None:
    with pytest.raises(ValueError, match="half_range must be 2 positive numbers"):
        viable_states(GAIT, (0.1, 0.0), STARTS)
    with pytest.raises(ValueError, match="grid must be at least 2, got 1"):
        viable_states(GAIT, REACH, STARTS, grid=(1, 5))
    with pytest.raises(ValueError, match=r"grid must be one count or 2, got \(5,\)"):
        viable_states(GAIT, REACH, STARTS, grid=(5,))
    for name in ("grid", "depth", "width"):
        with pytest.raises(ValueError, match=f"{name} must be at least"):
            viable_states(GAIT, REACH, STARTS, **{name: 0})  # type: ignore[arg-type]
        with pytest.raises(TypeError, match=f"{name} must be a whole number, got 4.5"):
            viable_states(GAIT, REACH, STARTS, **{name: 4.5})  # type: ignore[arg-type]
    params, _, state, _ = PRESETS["camp1997-as-published"]
    start = StrideMap(params, Control(2.8625, 738.0), 1e-9)(np.array([state]) + 1e-3, 200)[0]
    double = find_gait(params, Control(2.8625, 738.0), start.tolist(), period=2)
    with pytest.raises(ValueError, match="one stride and a constant control, got period 2"):
        regulate(double, REACH)
