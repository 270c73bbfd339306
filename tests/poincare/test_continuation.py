"""Branches: the thesis's figure 6 as a curve, other authors' doublings, and how curves end."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Gait, WalkerParams, find_gait
from powered_walker_env.poincare import GaitNotFoundError
from powered_walker_env.poincare.branches.arclength import EndReason
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.special_points import SpecialKind, SpecialPoint
from tests.helpers.derivation import Array
from tests.helpers.published import LIMIT_CYCLES, PASSIVE_GAITS, LimitCycle, PassiveGait, load

FOLD, DOUBLING, CIRCLE = SpecialKind
# By this package, to the digits that do not depend on the step; the laboratory's 732.2,
# 733.35 and 727.84 N m are the first, second and third.
PUBLISHED_DOUBLING = 732.19846603
CONSERVING_DOUBLING = 733.34635728
CONSERVING_CIRCLE = 727.84264836
CONSERVING_FOLD = 721.09686221
LOWER_CIRCLE = 721.12490538
LOWER_DOUBLING = 721.37433066
PUBLISHED_FOLDS = (715.59831411, 688.79911578)


def preset_gait(name: str) -> Gait:
    return find_gait(PRESETS[name].params, PRESETS[name].control, PRESETS[name].state)


def passive(walker: str) -> PassiveGait:
    return next(gait for gait in PASSIVE_GAITS if gait.walker.startswith(walker))


def the(branch: Branch, kind: SpecialKind, near: float) -> SpecialPoint:
    return min(branch.of_kind(kind), key=lambda point: abs(point.value - near))


@pytest.fixture(scope="module")
def figure_6() -> Branch:
    return continue_gait(preset_gait("camp1997-as-published"), "stall_torque", (640.0, 760.0))


@pytest.fixture(scope="module")
def conserving() -> Branch:
    return continue_gait(preset_gait("camp1997"), "stall_torque", (715.0, 745.0))


def test_figure_6_is_24_gaits_of_one_branch(figure_6: Branch) -> None:
    params, guess = figure_6.params, PRESETS["camp1997-as-published"].state
    for torque in np.linspace(692.0, 760.0, 24).tolist():
        ramped = find_gait(params, Control(2.8625, torque), guess)
        passed = figure_6.at(torque)
        nearest = min(passed, key=lambda gait: math.dist(gait.state, ramped.state))
        assert nearest.control == Control(2.8625, torque)
        assert nearest.state == pytest.approx(ramped.state, abs=1e-9)
        assert nearest.spectral_radius == pytest.approx(ramped.spectral_radius, abs=1e-6)
        guess = ramped.state


@pytest.mark.parametrize("cycle", [c for c in LIMIT_CYCLES if "pub" in str(c)], ids=str)
def test_the_reference_gaits_of_figure_6_lie_on_the_branch(
    cycle: LimitCycle, figure_6: Branch
) -> None:
    radii = [gait.spectral_radius for gait in figure_6.at(cycle.control.stall_torque)]
    assert min(abs(np.array(radii) - cycle.spectral_radius)) < 1e-6


def test_the_published_walker_doubles_its_period_and_folds_twice(figure_6: Branch) -> None:
    (doubling,) = figure_6.of_kind(DOUBLING)
    assert doubling.value == pytest.approx(PUBLISHED_DOUBLING, abs=1e-6)
    folds = [point.value for point in figure_6.of_kind(FOLD)]
    assert folds == pytest.approx(PUBLISHED_FOLDS, abs=1e-6)
    assert figure_6.stable_ranges() == [
        (pytest.approx(PUBLISHED_FOLDS[1], abs=1e-6), pytest.approx(PUBLISHED_DOUBLING, abs=1e-6))
    ]
    assert figure_6.ends[0].reason is EndReason.BOUND
    assert figure_6.ends[1].reason is EndReason.BOUND
    assert figure_6.values[[0, -1]] == pytest.approx([640.0, 760.0], abs=1e-10)


def test_the_conserving_walker_is_stable_between_a_circle_and_a_doubling(
    conserving: Branch,
) -> None:
    low, high = conserving.stable_ranges()
    assert low == pytest.approx((CONSERVING_FOLD, LOWER_CIRCLE), abs=1e-6)
    assert high == pytest.approx((CONSERVING_CIRCLE, CONSERVING_DOUBLING), abs=1e-6)
    assert the(conserving, CIRCLE, CONSERVING_CIRCLE).limits_stability
    inner = the(conserving, DOUBLING, LOWER_DOUBLING)
    assert inner.value == pytest.approx(LOWER_DOUBLING, abs=1e-6)
    assert not inner.limits_stability  # one multiplier is outside already
    assert conserving.ends[0].reason is EndReason.FALL
    assert "no switch" in conserving.ends[0].detail


@pytest.mark.parametrize("step", [None, 0.05, 0.01])
def test_stable_ranges_do_not_depend_on_where_the_gaits_of_the_branch_lie(
    step: float | None,
) -> None:
    branch = continue_gait(preset_gait("camp1997"), "stall_torque", (300.0, 1500.0), step=step)
    ranges = branch.stable_ranges()
    for wanted in ((CONSERVING_FOLD, LOWER_CIRCLE), (CONSERVING_CIRCLE, CONSERVING_DOUBLING)):
        assert any(found == pytest.approx(wanted, abs=1e-6) for found in ranges)
    if step is None:  # both ends between two gaits: none of them is stable there
        inside = (branch.values > CONSERVING_FOLD) & (branch.values < LOWER_CIRCLE)
        assert not (inside & branch.stable).any()


@pytest.mark.parametrize("name", PRESETS)
def test_stable_ranges_hold_the_stable_gaits_and_no_others(name: str) -> None:
    gait = preset_gait(name)
    reach = 0.02 + 0.1 * abs(gait.params.slope)
    branch = continue_gait(gait, "slope", (gait.params.slope - reach, gait.params.slope + reach))
    ranges = branch.stable_ranges()
    for value, stable in zip(branch.values.tolist(), branch.stable.tolist(), strict=True):
        held = any(low <= value <= high for low, high in ranges)
        assert held or not stable
    assert any(low <= gait.params.slope <= high for low, high in ranges)
    if np.all(np.diff(branch.values) > 0):
        middle = [0.5 * (low + high) for low, high in ranges]
        assert all(found.stable for value in middle for found in branch.at(value))


@pytest.mark.parametrize(
    ("kind", "value"),
    [(CIRCLE, CONSERVING_CIRCLE), (CIRCLE, LOWER_CIRCLE), (DOUBLING, CONSERVING_DOUBLING)],
)
def test_multipliers_cross_the_circle_within_1e_7_of_the_point(
    conserving: Branch, kind: SpecialKind, value: float
) -> None:
    point = the(conserving, kind, value)
    radii = [
        find_gait(conserving.params, Control(2.9068, point.value + h), point.state).spectral_radius
        for h in (-1e-7, -1e-8, 1e-8, 1e-7)
    ]
    assert (radii[0] - 1) * (radii[3] - 1) < 0
    assert (radii[1] - 1) * (radii[2] - 1) < 0  # the 1e-8 asked of the parameter
    assert abs(abs(point.critical_multiplier) - 1.0) < 1e-10
    if kind is CIRCLE:
        assert point.critical_multiplier.imag > 0.5


def test_special_points_do_not_depend_on_the_step(figure_6: Branch) -> None:
    coarse = continue_gait(
        preset_gait("camp1997-as-published"), "stall_torque", (640.0, 760.0), step=0.1
    )
    assert len(coarse) < len(figure_6)
    values = [point.value for point in coarse.special_points]
    assert values == pytest.approx([p.value for p in figure_6.special_points], abs=1e-8)


def test_at_a_fold_two_gaits_meet_like_a_square_root(figure_6: Branch) -> None:
    fold = the(figure_6, FOLD, PUBLISHED_FOLDS[1])
    closer = continue_gait(fold.gait, "stall_torque", (688.0, 689.0), max_points=20)

    def apart(torque: float) -> float:
        pair = closer.at(torque)
        assert len(pair) == 2
        return math.dist(pair[0].state, pair[1].state)

    assert apart(fold.value + 4e-3) / apart(fold.value + 1e-3) == pytest.approx(2.0, rel=0.02)
    assert abs(fold.critical_multiplier - 1.0) < 1e-8
    with pytest.raises(GaitNotFoundError):  # nothing to find below it
        find_gait(figure_6.params, Control(2.8625, fold.value - 1e-6), fold.state)


@pytest.mark.parametrize(
    ("name", "value", "next_doubling"),
    [
        ("camp1997-as-published", PUBLISHED_DOUBLING, 747.3030801),
        ("camp1997", CONSERVING_DOUBLING, 735.5043633),
    ],
)
def test_the_doubled_branch_leaves_its_doubling_stable_and_doubles_again(
    name: str, value: float, next_doubling: float, figure_6: Branch, conserving: Branch
) -> None:
    parent = conserving if name == "camp1997" else figure_6
    point = the(parent, DOUBLING, value)
    doubled = switch_branch(point, parent.bounds)
    assert doubled.period == 2
    assert doubled.ends[0].reason is EndReason.DOUBLING
    assert doubled.stable[:5].all()
    (again,) = [p.value for p in doubled.of_kind(DOUBLING)]
    assert again == pytest.approx(next_doubling, abs=1e-6)
    first = doubled.gait(0)
    assert first.states.shape == (2, 4)
    halves = np.linalg.norm(first.states[1] - first.states[0])
    assert halves > 1e-3
    found = find_gait(doubled.params, first.control, first.state, period=2)
    assert found.spectral_radius == pytest.approx(doubled.spectral_radius[0], abs=1e-6)
    # The amplitude grows like the square root of the distance from the doubling.
    gaits = [doubled.gait(i) for i in range(4)]
    squares = [np.sum((gait.states[1] - gait.states[0]) ** 2) for gait in gaits]
    torques = doubled.values[:4]
    slope = (torques[3] - torques[0]) / (squares[3] - squares[0])
    assert torques[0] - slope * squares[0] == pytest.approx(point.value, abs=2e-4)


def test_the_compass_gait_doubles_where_an_independent_code_has_it() -> None:
    gait = passive("compass")
    branch = continue_gait(find_gait(gait.params, None, gait.state), "slope", (0.03, 0.08))
    (point,) = branch.special_points
    published = math.radians(load("published.json")["compass_cascade_degrees"]["first"]["deg"])
    assert point.kind is DOUBLING
    assert point.value == pytest.approx(published, abs=1e-12)  # 4.390898249602 degrees


def test_with_lighter_feet_the_first_doubling_goes_to_that_of_the_simplest_walker() -> None:
    state = passive("nearly").state
    published = load("published.json")["simplest_walker"]["first_period_doubling"]["gamma"]
    found = []
    for foot_mass in (1e-3, 1e-4, 1e-5):
        params = WalkerParams.from_composite_leg(
            hip_mass=0.5,
            foot_mass=foot_mass,
            gravity=1.0,
            slope=0.009,
            foot_length=0.0,
            locked_ankle_angle=math.pi,
        )
        gait = find_gait(params, None, state)
        branch = continue_gait(gait, "slope", (0.005, 0.018), step=0.1)
        found.append(the(branch, DOUBLING, published).value)
    assert found[0] == pytest.approx(0.0149350875479, abs=1e-12)
    assert (10 * found[2] - found[1]) / 9 == pytest.approx(published, abs=1e-10)  # Garcia 1998


def test_a_passive_walker_on_the_level_stands_still() -> None:
    gait = passive("round feet")
    branch = continue_gait(find_gait(gait.params, None, gait.state), "slope", (0.0, 0.1))
    assert branch.ends[0].reason is EndReason.STANDING
    assert branch.values[0] < 1e-6
    assert branch.section == "post-strike"
    assert np.all(branch.cost_of_transport == 0.0)
    assert branch.of_kind(DOUBLING)[0].value == pytest.approx(0.0924097973, abs=1e-9)


def test_the_gaits_of_a_branch_are_those_of_its_arrays(conserving: Branch) -> None:
    for index in (5, len(conserving) // 2, -1):
        gait = conserving.gait(index)
        assert gait.control == Control(2.9068, conserving.values[index])
        assert gait.section == "switch"
        np.testing.assert_allclose(gait.multipliers, conserving.multipliers[index, :3], atol=1e-9)
        assert gait.speed == pytest.approx(conserving.speed[index], rel=1e-12)
        assert gait.cost_of_transport == pytest.approx(
            conserving.cost_of_transport[index], rel=1e-12
        )
        assert gait.stable == conserving.stable[index]


def test_a_closed_loop_is_continued_in_what_its_policy_does_not_set() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    assert control is not None
    nominal = np.array([control.switch_angle, control.stall_torque])

    def policy(states: Array) -> Array:
        gain = np.array([[0.02, -0.03, 0.01, 0.02], [30.0, -20.0, 40.0, 10.0]])
        return nominal + (states - np.array(state)) @ gain.T

    gait = find_gait(params, policy, state)
    branch = continue_gait(gait, "slope", (-0.02, 0.02))
    assert branch.stable_ranges()[0][0] == pytest.approx(-0.01883957068, abs=1e-8)
    with pytest.raises(ValueError, match="must not be 'stall_torque' for a walker under a policy"):
        continue_gait(gait, "stall_torque", (3000.0, 4000.0))


def test_branches_end_for_named_reasons() -> None:
    gait = preset_gait("round-foot")
    few = continue_gait(gait, "stall_torque", (3000.0, 4000.0), max_points=3)
    assert {end.reason for end in few.ends} == {EndReason.MAX_POINTS}
    assert len(few) == 7
    scuffing = continue_gait(gait, "stall_torque", (3300.0, 4000.0), least_clearance=-7e-4)
    assert scuffing.ends[1].reason is EndReason.SCUFF
    assert scuffing.min_clearance[-1] == pytest.approx(-7e-4, abs=1e-8)
    ends = [end.reason for end in continue_gait(gait, "stall_torque", (3300.0, 3400.0)).ends]
    assert ends == [EndReason.BOUND, EndReason.BOUND]


def test_a_gait_on_a_bound_is_followed_inwards() -> None:
    gait = preset_gait("round-foot")
    branch = continue_gait(gait, "stall_torque", (3371.8, 3400.0))
    assert branch.values[0] == pytest.approx(3371.8, abs=1e-9)
    assert np.all(np.diff(branch.values) > 0)
    assert branch.values[-1] == pytest.approx(3400.0, abs=1e-9)


def test_bad_arguments_are_named(figure_6: Branch) -> None:
    gait = preset_gait("round-foot")
    with pytest.raises(ValueError, match=r"parameter must be one of .* got 'colour'"):
        continue_gait(gait, "colour", (0.0, 1.0))
    with pytest.raises(ValueError, match=r"bounds must hold the gait's stall_torque = 3371\.8"):
        continue_gait(gait, "stall_torque", (1.0, 2.0))
    wrong: list[Any] = [
        (4000.0, 3000.0), (3000.0,), (3000.0, 3500.0, 4000.0), (3000.0, math.nan), 5.0, None,
        (3000.0, math.inf), ("low", "high"),
    ]  # fmt: skip
    for bounds in wrong:
        with pytest.raises((TypeError, ValueError), match="bounds must be"):
            continue_gait(gait, "stall_torque", bounds)
    for other in (gait.state, None, PRESETS["round-foot"]):
        with pytest.raises(TypeError, match="gait must be a Gait, got"):
            continue_gait(other, "stall_torque", (3000.0, 4000.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="foot_radius must not be negative"):
        continue_gait(gait, "foot_radius", (-1.0, 1.0))
    with pytest.raises(ValueError, match="step must lie in"):
        continue_gait(gait, "slope", (-0.1, 0.1), step=0.0)
    with pytest.raises(ValueError, match="max_points must be at least 1"):
        continue_gait(gait, "slope", (-0.1, 0.1), max_points=0)
    standing = passive("compass")
    with pytest.raises(ValueError, match="must not be 'switch_angle' for this walker"):
        continue_gait(find_gait(standing.params, None, standing.state), "switch_angle", (2.0, 3.0))
    fold = figure_6.of_kind(FOLD)[0]
    with pytest.raises(ValueError, match=r"point must be a period doubling .* got a fold"):
        switch_branch(fold, figure_6.bounds)
    broken = replace(figure_6, states=figure_6.states + 0.3)
    with pytest.raises(GaitNotFoundError):
        broken.at(735.0)
