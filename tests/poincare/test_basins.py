"""Basins: the fate of starts, certain where it is called so, and the volume's interval."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, find_gait, stride_batch
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare import Gait, GaitNotFoundError, StrideMap
from powered_walker_env.poincare.regions import basins
from powered_walker_env.poincare.regions.basins import FELL, WALKING, basin
from powered_walker_env.poincare.regions.slices import (
    SLICES,
    Slice,
    slice_through,
)
from powered_walker_env.poincare.regions.volumes import basin_volume
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.sections import section_of
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


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ranges": ((0.0, np.nan), (0.0, 1.0))}, "ranges must be two pairs of finite numbers"),
        ({"ranges": ((0.0, np.inf), (0.0, 1.0))}, "ranges must be two pairs of finite numbers"),
        ({"ranges": ((1.0, 0.0), (0.0, 1.0))}, r"ranges must be two pairs \(low, high\) that rise"),
        ({"ranges": (0.0, 1.0)}, "ranges must be two pairs"),
        ({"shape": (2.5, 5)}, "shape must be two positive numbers"),
        ({"shape": (5,)}, "shape must be two positive numbers"),
        ({"shape": (10**8, 10**8)}, "10,000,000,000,000,000 points; take fewer"),
        ({"base": (np.nan, 0.0, 0.0, 0.0)}, "must be finite"),
        ({"axes": ("stance_angle", "swing_angle"), "section": PARAMS}, "one angle only"),
        ({"axes": ("stance_angle", "swing_rate"), "section": PRESETS["simplest"].params},
         "axes must be two of stance_angle, swing_angle, stance_rate and"),
    ],
)  # fmt: skip
def test_slices_that_make_no_sense_are_refused(changes: dict[str, Any], message: str) -> None:
    good = {"base": STATE, "axes": ("stance_angle", "stance_rate"), "ranges": ((0, 1), (0, 1))}
    assert Slice(**good).shape == (200, 200)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message):
        Slice(**(good | changes))  # type: ignore[arg-type]


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


def test_the_volume_of_the_section_is_the_default_measure() -> None:
    gait = preset_gait("compass")
    low, high = (-0.5, 0.0, -0.5), (0.0, 2.0, 1.5)
    found = basin_volume(
        gait.params, None, low, high, samples=400, gaits=[gait], backend="threading"
    )
    assert found.coordinates == ("stance_angle", "stance_rate", "swing_rate")
    assert found.box_volume == pytest.approx(0.5 * 2.0 * 2.0)
    states = found.basin.states
    np.testing.assert_array_equal(states[:, 1], -states[:, 0])
    assert (states[:, [0, 2, 3]] >= low).all() and (states[:, [0, 2, 3]] <= high).all()
    assert found.share_low < 0.0283 < found.share_high  # 0.0283 of 10,000
    around = basin_volume(gait.params, None, samples=50, backend="threading")
    np.testing.assert_allclose(0.5 * (around.low + around.high), np.array(gait.state)[[0, 2, 3]])
    walker = preset_gait("simplest")
    flat = basin_volume(walker.params, None, samples=10, backend="threading")
    assert flat.coordinates == ("stance_angle", "stance_rate")
    motor = basin_volume(PARAMS, CONTROL, samples=10, gaits=[GAIT], backend="threading")
    assert motor.coordinates == found.coordinates
    assert motor.section == section_of(PARAMS, CONTROL)
    np.testing.assert_allclose(0.5 * (motor.low + motor.high), motor.section.points([STATE])[0])
    raw = basin_volume(PARAMS, CONTROL, STATE - UNITS, STATE + UNITS, samples=10, gaits=[GAIT],
                       backend="threading")  # fmt: skip
    assert len(raw.coordinates) == 4 and raw.section is None


def preset_gait(name: str) -> Gait:
    params, control, state, _ = PRESETS[name]
    return find_gait(params, control, state)


def test_half_of_what_a_plain_slice_shows_attracted_is_not_on_the_section() -> None:
    gait = preset_gait("compass")
    middle = (gait.state.stance_angle, gait.state.stance_rate)
    ranges = tuple((m - r, m + r) for m, r in zip(middle, (0.2, 0.5), strict=True))
    plane = slice_through(gait, ranges=ranges, shape=(50, 50))  # type: ignore[arg-type]
    assert plane.section is gait.params
    np.testing.assert_array_equal(plane.states[:, 1], -plane.states[:, 0])
    np.testing.assert_array_equal(plane.states[:, 3], gait.state.swing_rate)
    plain = Slice(gait.state, plane.axes, plane.ranges, plane.shape)
    on, off = (
        basin(gait.params, None, grid, gaits=[gait], backend="threading").attracted_share
        for grid in (plane, plain)
    )
    assert on == pytest.approx(0.0614, abs=0.002)  # by an independent count
    assert off == pytest.approx(0.13, abs=0.005)
    mirrored = Slice(gait.state, ("swing_angle", "stance_rate"), plain.ranges, (3, 4), gait.params)
    np.testing.assert_allclose(mirrored.states[:, 0], -mirrored.states[:, 1])


def test_the_default_plane_is_the_section_through_the_stable_gait() -> None:
    params, _, state, _ = PRESETS["simplest"]
    found = basin(params, None, strides=30, jobs=2, backend="threading")
    assert found.grid is not None and found.grid.section == params
    assert found.gaits[0].stable and found.gaits[0].state == pytest.approx(state, abs=1e-8)
    assert found.attracted_share > 0
    np.testing.assert_allclose(
        found.states[:, 3], found.states[:, 2] * np.cos(2 * found.states[:, 0])
    )


def test_without_a_gait_there_is_no_default_plane(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> Gait:
        raise GaitNotFoundError("none")

    monkeypatch.setattr(basins, "stable_gait", none)
    with pytest.raises(GaitNotFoundError, match="grid must be given"):
        basin(PARAMS, CONTROL)
    with pytest.raises(GaitNotFoundError, match="low and high must be given"):
        basin_volume(PARAMS, CONTROL)


def test_the_slice_of_schwab_and_wisse_is_known_by_name() -> None:
    plane = SLICES["schwab-wisse"]((80, 80))
    assert plane.section is not None and plane.section.slope == 0.004
    found = basin(plane.section, None, plane, backend="threading")
    (gait,) = found.gaits
    assert gait.state[:3:2] == pytest.approx((-0.1534, 0.1561), abs=5e-5)
    attracted = found.states[found.attractor == 0]
    assert 0 < found.attracted_share < 0.03  # "a small, thin area"
    assert abs(attracted[:, 0] + attracted[:, 2]).max() < 0.05  # along α' = −α


def test_bad_basins_are_refused() -> None:
    with pytest.raises(ValueError, match="grid must be a Slice or states"):
        basin(PARAMS, CONTROL, [1.0, 2.0], gaits=[])
    with pytest.raises(ValueError, match="strides must be at least 1, got 0"):
        basin(PARAMS, CONTROL, [STATE], strides=0, gaits=[])
    with pytest.raises(TypeError, match="strides must be a whole number"):
        basin(PARAMS, CONTROL, [STATE], strides=1.5, gaits=[])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="samples must be at least 1, got 0"):
        basin_volume(PARAMS, CONTROL, samples=0, gaits=[])
    with pytest.raises(ValueError, match=r"confidence must lie in \(0, 1\), got 1"):
        basin_volume(PARAMS, CONTROL, confidence=1.0, gaits=[])
    unstable = find_gait(PARAMS, Control(2.8625, 738.0), STATE)
    with pytest.raises(ValueError, match="gait must be stable"):
        basin(PARAMS, CONTROL, [STATE], gaits=[unstable])
    for rtol in (1.0, -1e-9, float("nan"), 0.0):
        with pytest.raises(ValueError, match="rtol must"):
            basin(PARAMS, CONTROL, [STATE], gaits=[], rtol=rtol)
    with pytest.raises(TypeError, match="rtol must be a real number, got None"):
        basin(PARAMS, CONTROL, [STATE], gaits=[], rtol=None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="low must be below high"):
        basin_volume(PARAMS, CONTROL, STATE, STATE, gaits=[])
    with pytest.raises(ValueError, match=r"4 numbers, or 3 \("):
        basin_volume(PARAMS, CONTROL, (0, 0), (1, 1), gaits=[])
    with pytest.raises(ValueError, match="4 numbers, or 3"):
        basin_volume(PRESETS["compass"].params, None, (0, 0), (1, 1), gaits=[])
    with pytest.raises(ValueError, match="low must be finite"):
        basin_volume(PARAMS, CONTROL, (0, 0, 0, np.nan), (1, 1, 1, 1), gaits=[])
    with pytest.raises(ValueError, match="both or not at all"):
        basin_volume(PARAMS, CONTROL, STATE, gaits=[])
    with pytest.raises(ValueError, match="picture needs a basin over a Slice"):
        basin(PARAMS, CONTROL, [STATE], strides=1, gaits=[], backend="threading").picture("strides")


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTORS)
def test_a_slice_of_forty_thousand_walkers_shows_the_basin(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    rates = ((state[2] - 0.3, state[2] + 0.3), (state[3] - 0.6, state[3] + 0.6))
    found = basin(params, control, Slice(state, ("stance_rate", "swing_rate"), rates))
    assert 0.01 < found.attracted_share < 0.5
