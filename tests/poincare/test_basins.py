"""Basins: the fate of starts, certain where it is called so, and the volume's interval."""

from __future__ import annotations

import time

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, find_gait, stride_batch
from powered_walker_env.poincare import Gait, StrideMap
from powered_walker_env.poincare.maps import natural_units
from powered_walker_env.poincare.regions import basins
from powered_walker_env.poincare.regions.basins import (
    FELL,
    WALKING,
    Slice,
    basin,
    basin_volume,
    clopper_pearson,
)
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stability.trapping import trap_around
from tests.helpers.samples import MOTORS

PARAMS, CONTROL, STATE, _ = PRESETS["camp1997-as-published"]
assert CONTROL is not None
GAIT = find_gait(PARAMS, CONTROL, STATE)
UNITS = natural_units(PARAMS)
RATES = Slice(
    STATE, ("stance_rate", "swing_rate"), ((STATE[2] - 0.3, STATE[2] + 0.3), (0.4, 1.6)), (12, 9)
)


def test_a_slice_is_a_rectangle_in_two_coordinates() -> None:
    across, up = RATES.ticks
    states = RATES.states
    assert states.shape == (108, 4) and len(across) == 12 and len(up) == 9
    np.testing.assert_array_equal(states[:, :2], np.tile(STATE[:2], (108, 1)))
    np.testing.assert_array_equal(states[:, 2].reshape(9, 12)[4], across)
    np.testing.assert_array_equal(states[:, 3].reshape(9, 12)[:, 5], up)
    with pytest.raises(ValueError, match="axes must be two of stance_angle"):
        Slice(STATE, ("stance_rate", "speed"), ((0, 1), (0, 1)))


def test_strides_survived_are_those_of_plain_walks() -> None:
    found = basin(PARAMS, CONTROL, RATES, strides=40, gaits=[GAIT], backend="threading")
    states, walked = RATES.states, np.full(len(RATES.states), 40)
    rows = np.arange(len(states))
    for k in range(40):
        control = [CONTROL.switch_angle, CONTROL.stall_torque]
        batch = stride_batch(states, control, PARAMS, rtol=1e-8)
        fell = ~batch.walked
        walked[rows[fell]] = k
        np.testing.assert_array_equal(found.outcome[rows[fell]], batch.outcome[fell])
        rows, states = rows[batch.walked], batch.state[batch.walked]
    np.testing.assert_array_equal(found.strides, walked)
    np.testing.assert_array_equal(found.attractor == FELL, walked < 40)
    assert found.picture("strides").shape == (9, 12)
    assert 0.05 < found.attracted_share < 0.95


def test_walkers_called_attracted_do_reach_the_gait() -> None:
    found = basin(PARAMS, CONTROL, RATES, strides=40, gaits=[GAIT], backend="threading")
    caught = found.attractor == 0
    ends = StrideMap(PARAMS, CONTROL, 1e-9)(RATES.states[caught], 100)
    np.testing.assert_allclose(ends, np.tile(GAIT.state, (caught.sum(), 1)), atol=1e-7)
    assert (found.settled[caught] >= 0).all() and (found.settled[~caught] == -1).all()


def test_no_stride_leaves_the_trapping_region() -> None:
    trap = trap_around(GAIT)
    rng = np.random.default_rng(5)  # other samples than the check's
    offsets = rng.normal(size=(500, 4))
    offsets /= np.linalg.norm(offsets, axis=1, keepdims=True)
    radii = trap.radii[0] * rng.uniform(0, 1, (500, 1)) ** 0.25
    states = trap.states[0] + np.linalg.solve(trap.factors[0], (radii * offsets).T).T
    assert trap.holds(states).all()
    assert trap.holds(StrideMap(PARAMS, CONTROL, 1e-9)(states)).all()
    assert trap.contraction < 1.0
    assert not trap.holds(np.add(states, [0.5, 0.0, 0.0, 0.0])).any()


def doubled() -> Gait:
    near = [-0.46, 0.57, 1.66, 0.99]
    start = StrideMap(PARAMS, Control(2.8625, 738.0), 1e-9)(np.array([near]), 200)[0]
    return find_gait(PARAMS, Control(2.8625, 738.0), start.tolist(), period=2)


def test_gaits_of_two_strides_attract_from_both_of_their_points() -> None:
    gait = doubled()
    assert gait.stable
    starts = np.concatenate([gait.states, gait.states + 1e-3, [[-1.0, 0.2, 0.0, 0.0]]])
    found = basin(PARAMS, gait.control, starts, gaits=[gait], backend="threading")
    assert found.attractor.tolist() == [0, 0, 0, 0, FELL]
    assert found.settled[:2].tolist() == [0, 0]
    assert found.outcome[4] == Outcome.HIP_BELOW_FLOOR and found.strides[4] == 0
    unlisted = basin(PARAMS, gait.control, starts[:2], gaits=[], backend="threading")
    assert unlisted.attractor.tolist() == [WALKING, WALKING]
    assert unlisted.period.tolist() == [2, 2]


def test_a_regulator_is_a_policy_with_a_basin() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    assert control is not None
    policy = regulate(find_gait(params, control, state), (0.2, 0.3 * control.stall_torque))
    closed = find_gait(params, policy, state)
    starts = np.random.default_rng(2).normal(state, 0.03, (60, 4))
    ours = basin(params, policy, starts, gaits=[closed], backend="threading")
    open_loop = basin(params, control, starts, backend="threading")
    assert closed.spectral_radius < find_gait(params, control, state).spectral_radius
    assert ours.attracted_share > open_loop.attracted_share > 0


def test_a_basin_does_not_depend_on_where_it_is_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(basins, "ROWS", 20)  # three pieces
    starts = np.random.default_rng(3).normal(STATE, 0.05, (50, 4))
    one = basin(PARAMS, CONTROL, starts, strides=5, gaits=[GAIT], backend="threading", jobs=1)
    two = basin(PARAMS, CONTROL, starts, strides=5, gaits=[GAIT], backend="loky", jobs=2)
    for name in ("strides", "attractor", "settled", "period", "outcome"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_the_volume_is_a_share_with_an_exact_interval() -> None:
    size = 0.05 * UNITS
    ends = np.subtract(STATE, size), np.add(STATE, size)
    found = basin_volume(
        PARAMS, CONTROL, *ends, samples=300, gaits=[GAIT], backend="threading", seed=4
    )
    assert found.share_low < found.share < found.share_high
    assert found.share == found.basin.attracted_share
    assert found.box_volume == pytest.approx(np.prod(2 * size))
    assert found.volume[0] == pytest.approx(found.share * found.box_volume)
    assert found.share_low < 0.378 < found.share_high  # 0.3776 of 10,000
    tiny = trap_around(GAIT).radii[0] * 1e-3
    inside = basin_volume(
        PARAMS, CONTROL, np.subtract(STATE, tiny), np.add(STATE, tiny), samples=50, gaits=[GAIT],
        backend="threading",
    )  # fmt: skip
    assert (inside.share, inside.share_high) == (1.0, 1.0)
    assert inside.share_low == pytest.approx(0.025 ** (1 / 50))


def test_clopper_pearson_bounds_are_the_tails_of_the_binomial() -> None:
    assert clopper_pearson(0, 10, 0.95) == (0.0, pytest.approx(1 - 0.025**0.1))
    low, high = clopper_pearson(7, 20, 0.95)
    assert (low, high) == (pytest.approx(0.15391, abs=1e-5), pytest.approx(0.59219, abs=1e-5))


def test_bad_basins_are_refused() -> None:
    with pytest.raises(ValueError, match="grid must be a Slice or states"):
        basin(PARAMS, CONTROL, [1.0, 2.0], gaits=[])
    with pytest.raises(ValueError, match="strides must be at least 1, got 0"):
        basin(PARAMS, CONTROL, [STATE], strides=0, gaits=[])
    unstable = find_gait(PARAMS, Control(2.8625, 738.0), STATE)
    with pytest.raises(ValueError, match="gait must be stable"):
        basin(PARAMS, CONTROL, [STATE], gaits=[unstable])
    with pytest.raises(ValueError, match="low must be below high"):
        basin_volume(PARAMS, CONTROL, STATE, STATE, gaits=[])
    with pytest.raises(ValueError, match="picture needs a basin over a Slice"):
        basin(PARAMS, CONTROL, [STATE], strides=1, gaits=[], backend="threading").picture("strides")


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTORS)
def test_a_slice_of_forty_thousand_walkers_takes_less_than_three_minutes(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    rates = ((state[2] - 0.3, state[2] + 0.3), (state[3] - 0.6, state[3] + 0.6))
    began = time.perf_counter()
    found = basin(params, control, Slice(state, ("stance_rate", "swing_rate"), rates))
    assert time.perf_counter() - began < 180.0
    assert 0.01 < found.attracted_share < 0.5
