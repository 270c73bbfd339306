"""Ramps of a parameter: the thesis's period doubling, falls, and starting again."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, find_gait
from powered_walker_env.poincare.branches.ramps import (
    NO_START,
    BifurcationDiagram,
    Ramp,
    bifurcation_diagram,
)
from powered_walker_env.poincare.branches.starts import changed, stable_gait, starts_along
from tests.helpers.derivation import Array

PUBLISHED = PRESETS["camp1997-as-published"]
CONSERVING = PRESETS["camp1997"]


@pytest.fixture(scope="module")
def doubling() -> BifurcationDiagram:
    params, control, state, _ = PUBLISHED
    values = [720.0, 738.0, 749.5]
    return bifurcation_diagram(
        params, control, "stall_torque", values, state=state, keep=16, backend="threading"
    )


def test_the_published_walker_doubles_its_period_twice_as_torque_rises(
    doubling: BifurcationDiagram,
) -> None:
    assert doubling.periods(doubling.up).tolist() == [1, 2, 4]
    assert doubling.periods(doubling.down).tolist() == [1, 2, 4]
    assert doubling.up.states.shape == (3, 16, 4)
    assert (doubling.gap < 1e-6).all()  # no hysteresis here
    assert not (doubling.up.restarted.any() or doubling.down.restarted.any())


def test_a_ramp_ends_on_the_gaits_that_newton_finds(doubling: BifurcationDiagram) -> None:
    for row, period in enumerate([1, 2, 4]):
        walker = changed(PUBLISHED.params, PUBLISHED.control, "stall_torque", doubling.values[row])
        last = doubling.up.states[row, -1]
        gait = find_gait(*walker, last.tolist(), period=period)
        assert gait.stable
        np.testing.assert_allclose(last, gait.state, atol=1e-6)


SIMPLEST = [
    0.009, 0.012, 0.014, 0.0146, 0.0155, 0.0165, 0.0172, 0.0179, 0.01822, 0.01827, 0.01828,
    0.0183, 0.0187, 0.0189, 0.0192,
]  # fmt: skip
# Garcia et al. 1998: doublings from 0.0151, chaos, and no walking beyond 0.019.
PERIODS = [1, 1, 1, 1, 2, 2, 2, 4, 8, 16, 16, 0, 0, 0]


@pytest.mark.parametrize("first", [0, 2, 8])  # with and without the preset's slope, in a cascade
def test_the_simplest_walker_doubles_to_chaos_up_and_down(first: int) -> None:
    params, control, state, _ = PRESETS["simplest"]
    found = bifurcation_diagram(
        params, control, "slope", SIMPLEST[first:], state=state, transient=600,
        backend="threading",
    )  # fmt: skip
    assert found.periods(found.up).tolist() == [*PERIODS[first:], -1]
    # Beyond the end of chaos a walk from its last points may last for a while, or not.
    assert found.periods(found.down).tolist()[:-1] == PERIODS[first:]
    assert found.periods(found.down)[-1] in (-1, -2) and found.up.outcome[-1] > 0
    assert np.isnan(found.gap[-1]) and found.gap[:-1].max() < 1e-2  # of chaos, by sampling
    assert not found.up.restarted[:-1].any()


def test_the_compass_gait_doubles_to_chaos_up_and_down() -> None:
    params, control, _, _ = PRESETS["compass"]
    slopes = np.radians([3.0, 3.5, 4.0, 4.3, 4.6, 4.8, 4.95, 5.0, 5.03, 5.05, 5.1, 5.2, 5.5])
    found = bifurcation_diagram(
        params, control, "slope", slopes, transient=600, backend="threading"
    )
    periods = [1, 1, 1, 1, 2, 2, 4, 4, 8, 0, 0, 0]  # Goswami et al.: from 4.39 degrees
    assert found.periods(found.up).tolist() == [*periods, -1]
    assert found.periods(found.down).tolist() == [*periods, -2]


def test_beyond_the_end_of_chaos_nothing_is_called_a_fall() -> None:
    params, control, state, _ = PRESETS["simplest"]
    found = bifurcation_diagram(
        params, control, "slope", [0.0195, 0.02], state=state, keep=4, backend="threading"
    )
    for ramp in (found.up, found.down):
        assert found.periods(ramp).tolist() == [-2, -2]
        assert not (ramp.walked.any() or ramp.restarted.any())


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_ramped_from_its_stable_gait(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    around = params.slope + np.array([-1e-4, 0.0, 1e-4])
    starts = starts_along(params, control, "slope", around, state)
    for value, start in zip(around.tolist(), starts, strict=True):
        gait = find_gait(params.replace(slope=value), control, start.tolist())
        assert gait.stable
        np.testing.assert_allclose(start, gait.state, atol=1e-9)


@pytest.mark.parametrize("name", ["simplest", "compass", "mcgeer1990", "round-foot"])
def test_a_stable_gait_is_found_without_a_guess(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    np.testing.assert_allclose(stable_gait(params, control).state, state, atol=1e-8)


def test_after_a_fall_a_ramp_starts_again_from_the_gait() -> None:
    params, control, state, _ = CONSERVING
    found = bifurcation_diagram(
        params, control, "stall_torque", [729.8, 760.0], state=state, transient=30, keep=8,
        backend="threading",
    )  # fmt: skip
    assert found.periods(found.up)[0] == 1
    assert found.up.outcome[1] != Outcome.WALKED and np.isnan(found.up.states[1]).all()
    assert found.down.restarted.tolist() == [True, False]
    assert found.down.walked.tolist() == [True, False]
    assert found.down.outcome[1] == NO_START
    assert np.isnan(found.gap[1])


def test_a_motion_that_alternates_as_it_settles_has_no_period_yet() -> None:
    k = np.arange(64)

    def ramp(along: Array) -> Ramp:
        states = np.outer(along, np.ones(4))[np.newaxis]
        return Ramp(states, np.zeros(1, np.int64), np.zeros(1, np.bool_))

    settling, settled = ramp(1e-5 * (-0.99) ** k), ramp(1e-5 * (-1.0) ** k)
    still, wandering = ramp(np.zeros(64)), ramp(np.sin(k))
    found = BifurcationDiagram(
        CONSERVING.params, CONSERVING.control, "stall_torque", np.zeros(1), 0, 64, 1e-9,
        settling, settled,
    )  # fmt: skip
    ramps = (settling, settled, still, wandering)
    assert [found.periods(one).tolist() for one in ramps] == [[0], [2], [1], [0]]


def test_any_number_of_the_walker_can_be_ramped() -> None:
    params, control, state, _ = CONSERVING
    found = bifurcation_diagram(
        params, control, "slope", [0.0, 1e-5], state=state, transient=60, keep=4,
        backend="threading",
    )  # fmt: skip
    assert found.up.walked.all() and found.down.walked.all()
    assert np.ptp(found.up.states[:, -1, 0]) > 0


def test_bad_ramps_are_refused() -> None:
    params, control, state, _ = CONSERVING
    with pytest.raises(ValueError, match="ascending numbers"):
        bifurcation_diagram(params, control, "stall_torque", [2.0, 1.0], state=state)
    for values in ([1.0, np.nan], [np.inf], []):
        with pytest.raises(ValueError, match="ascending numbers"):
            bifurcation_diagram(params, control, "stall_torque", values, state=state)
    for rtol in (1.0, -1e-9, np.nan, 0.0):
        with pytest.raises(ValueError, match="rtol must"):
            bifurcation_diagram(params, control, "slope", [0.0], state=state, rtol=rtol)
    with pytest.raises(ValueError, match=r"parameter must be one of .* got 'colour'"):
        bifurcation_diagram(params, control, "colour", [1.0], state=state)
    with pytest.raises(ValueError, match="'stall_torque' is no number of a constant control, got"):
        changed(params, None, "stall_torque", 1.0)
    for name, least in (("keep", 2), ("transient", 0)):
        for given, kind, need in ((least - 1, ValueError, f"be at least {least}, got {least - 1}"),
                                  (2.5, TypeError, "be a whole number, got 2.5")):  # fmt: skip
            with pytest.raises(kind, match=f"{name} must {need}"):
                bifurcation_diagram(params, control, "slope", [0.0], state=state, **{name: given})
    assert changed(params, Control(3.0, 1.0), "switch_angle", 2.5)[1] == Control(2.5, 1.0)
