"""Searches for gaits: all of them, and those with a step length or speed asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, GaitNotFoundError, find_gait, stride
from powered_walker_env.poincare.branches.continuation import continue_gait
from powered_walker_env.poincare.search import find_gaits
from powered_walker_env.poincare.wanted import find_gait_with
from tests.helpers.derivation import Array
from tests.helpers.published import PASSIVE_GAITS, load

ROUND = PRESETS["round-foot"]
assert ROUND.control is not None
NOMINAL = np.array([ROUND.control.switch_angle, ROUND.control.stall_torque])
COMPASS = next(gait for gait in PASSIVE_GAITS if gait.walker.startswith("compass"))
NEARLY_SIMPLEST = next(gait for gait in PASSIVE_GAITS if gait.walker.startswith("nearly"))


def policy(states: Array) -> Array:
    gain = np.array([[0.02, -0.03, 0.01, 0.02], [30.0, -20.0, 40.0, 10.0]])
    return NOMINAL + (states - np.array(ROUND.state)) @ gain.T


def test_all_gaits_of_a_branch_are_found_and_more() -> None:
    published = PRESETS["camp1997-as-published"]
    assert published.control is not None
    start = find_gait(published.params, published.control, published.state)
    passed = continue_gait(start, "stall_torque", (640.0, 760.0)).at(692.0)
    assert len(passed) == 3  # the branch is folded like an S
    found = find_gaits(published.params, published.control, starts=1024)
    assert len(found) >= 4
    radii = [gait.spectral_radius for gait in found]
    assert radii == sorted(radii)
    assert radii[0] == pytest.approx(0.6546, abs=5e-5)
    for gait in passed:
        assert min(math.dist(gait.state, other.state) for other in found) < 1e-8
    for gait in found:
        returned = stride(gait.state, gait.control, gait.params, rtol=1e-13).state
        assert returned == pytest.approx(gait.state, abs=1e-9)


# Several seeds and four times the starts: the six gaits are all that a search finds.
@pytest.mark.slow
def test_more_starts_and_other_seeds_find_the_same_gaits() -> None:
    published = PRESETS["camp1997-as-published"]
    sets = [
        find_gaits(published.params, published.control, starts=starts, seed=seed)
        for starts, seed in ((4096, 0), (4096, 1), (16384, 2))
    ]
    for found in sets:
        radii = [gait.spectral_radius for gait in found]
        assert radii == pytest.approx([0.654577, 1.437135, 2.423883, 4.521896, 8.789258, 53.753462])


def test_the_simplest_walker_s_two_gaits_are_found_standing_left_out() -> None:
    found = find_gaits(NEARLY_SIMPLEST.params, None, starts=1024)
    assert len(found) == 2
    cases = load("published.json")["simplest_walker"]["cases"]
    for gait, name in zip(found, ("0.009_long", "0.009_short"), strict=True):
        assert gait.section == "post-strike"
        assert -gait.state.stance_angle == pytest.approx(cases[name]["theta"], abs=1e-3)
        assert gait.spectral_radius == pytest.approx(cases[name]["maxabs"], rel=0.02)


def test_searches_are_repeatable() -> None:
    first, again = (find_gaits(COMPASS.params, None, starts=256, seed=3) for _ in range(2))
    assert [gait.state for gait in first] == [gait.state for gait in again]
    assert first[0].state == pytest.approx(COMPASS.state, abs=1e-10)


def test_cycles_of_two_strides_are_found_once_and_without_those_of_one() -> None:
    steep = COMPASS.params.replace(slope=math.radians(4.6))  # past the doubling at 4.39
    (double,) = find_gaits(steep, None, period=2, starts=512)
    assert double.stable
    assert double.states[0, 0] < double.states[1, 0] - 1e-3
    single = find_gaits(steep, None, starts=512)[0]
    assert not single.stable


# Li and Yang 2012 (Commun. Nonlinear Sci. 17): windows of the simplest walker's slope in which
# stable gaits of three and four strides, born at folds, coexist with its gait of one.
@pytest.mark.parametrize(
    ("period", "low", "high"), [(3, 0.0122808, 0.0126350), (4, 0.0100898, 0.0101318)]
)
def test_the_simplest_walkers_stable_gaits_of_three_and_four_strides_are_found(
    period: int, low: float, high: float
) -> None:
    for share in (0.1, 0.5, 0.9):
        params = PRESETS["simplest"].params.replace(slope=low + share * (high - low))
        found = find_gaits(params, None, period=period)
        stable = [gait for gait in found if gait.stable]
        assert len(stable) == 1, (share, found)
        (gait,) = stable
        for i in range(period):
            for j in range(i):
                assert math.dist(gait.states[i], gait.states[j]) > 1e-3
        assert len([gait for gait in find_gaits(params, None) if gait.stable]) == 1
    for outside in (low - 2e-6, high + 2e-6):
        params = PRESETS["simplest"].params.replace(slope=outside)
        assert not any(gait.stable for gait in find_gaits(params, None, period=period))


def test_closed_loops_have_gaits_too() -> None:
    found = find_gaits(ROUND.params, policy, starts=512)
    assert min(math.dist(gait.state, ROUND.state) for gait in found) < 1e-9


def test_no_gait_is_an_empty_list() -> None:
    assert find_gaits(ROUND.params, Control(2.7, 1.0), starts=64) == []


@pytest.mark.parametrize("by", ["stall_torque", "switch_angle", "leg_inertia"])
def test_a_gait_with_a_given_speed_is_found(by: str) -> None:
    gait = find_gait_with(ROUND.params, ROUND.control, speed=1.38, by=by, guess=ROUND.state)
    assert gait.speed == pytest.approx(1.38, abs=1e-11)
    again = find_gait(gait.params, gait.control, gait.state)
    assert again.state == pytest.approx(gait.state, abs=1e-9)
    changed = gait.control != ROUND.control if by != "leg_inertia" else gait.params != ROUND.params
    assert changed


@pytest.mark.parametrize("by", [("switch_angle", "stall_torque"), ("stall_torque", "slope")])
def test_a_gait_with_a_given_speed_and_step_length_is_found(by: tuple[str, str]) -> None:
    gait = find_gait_with(
        ROUND.params, ROUND.control, speed=1.385, step_length=1.411, by=by, guess=ROUND.state
    )
    assert gait.speed == pytest.approx(1.385, abs=1e-11)
    assert gait.step_length == pytest.approx(1.411, abs=1e-11)
    again = find_gait(gait.params, gait.control, gait.state)
    assert again.state == pytest.approx(gait.state, abs=1e-9)


def test_a_step_length_far_away_is_approached_in_steps() -> None:
    start = find_gait(COMPASS.params, None, COMPASS.state)
    gait = find_gait_with(COMPASS.params, None, step_length=0.1, by="slope", guess=start)
    assert gait.step_length == pytest.approx(0.1, abs=1e-11)
    assert 0 < gait.params.slope < 5e-4
    assert gait.stable  # still the long-step gait
    assert gait.control is None
    assert find_gait_with(COMPASS.params, None, speed=0.5, by="slope").stable


def test_a_closed_loop_is_given_a_speed_by_what_its_policy_does_not_set() -> None:
    gait = find_gait_with(ROUND.params, policy, speed=1.4, by="slope", guess=ROUND.state)
    assert gait.speed == pytest.approx(1.4, abs=1e-11)
    with pytest.raises(ValueError, match="must not be 'stall_torque' for a walker under a policy"):
        find_gait_with(ROUND.params, policy, speed=1.4, guess=ROUND.state)


def test_a_step_length_out_of_reach_is_refused_with_how_near_it_came() -> None:
    with pytest.raises(GaitNotFoundError, match=r"step_length = 3\.0 .* has step_length = 1\.412"):
        find_gait_with(ROUND.params, ROUND.control, step_length=3.0, guess=ROUND.state)


def test_bad_arguments_are_named() -> None:
    with pytest.raises(ValueError, match="period must be at least 1, got 0"):
        find_gaits(ROUND.params, ROUND.control, period=0)
    with pytest.raises(ValueError, match="starts must be at least 1, got 0"):
        find_gaits(ROUND.params, ROUND.control, starts=0)
    with pytest.raises(ValueError, match="give step_length, speed or both"):
        find_gait_with(ROUND.params, ROUND.control)
    with pytest.raises(ValueError, match="by must be 2 different names, one for each"):
        find_gait_with(ROUND.params, ROUND.control, step_length=1.0, speed=1.0)
    with pytest.raises(ValueError, match="by must be 2 different names, one for each"):
        find_gait_with(ROUND.params, ROUND.control, step_length=1.0, speed=1.0, by=["slope"] * 2)
    with pytest.raises(ValueError, match="by must be 1 different name, one for each"):
        find_gait_with(ROUND.params, ROUND.control, speed=1.0, by=("slope", "stall_torque"))
    with pytest.raises(ValueError, match=r"speed must be positive and finite, got -1\.0"):
        find_gait_with(ROUND.params, ROUND.control, speed=-1.0)
    with pytest.raises(ValueError, match="parameter must be one of"):
        find_gait_with(ROUND.params, ROUND.control, speed=1.0, by="colour")


def test_a_search_shared_out_to_processes_finds_the_same_gaits() -> None:
    here = find_gaits(ROUND.params, ROUND.control, starts=128)
    there = find_gaits(ROUND.params, ROUND.control, starts=128, backend="loky", jobs=2)
    assert here
    np.testing.assert_array_equal([g.state for g in here], [g.state for g in there])
