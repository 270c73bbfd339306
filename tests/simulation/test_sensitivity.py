"""The derivatives of a stride against differences of strides at the tightest tolerance."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, WalkerParams
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.packing import NUMBERS
from powered_walker_env.model.phases import Outcome
from powered_walker_env.model.powering import (
    ANGLE,
    MOTOR,
    STRENGTH,
    AnyControl,
    HipTorque,
    LateToeOff,
    StoppedControl,
    ToeOff,
    ToeOffAtStrike,
    scheme_of,
)
from powered_walker_env.model.quantities import quantities
from powered_walker_env.poincare.maps import StrideMap
from tests.helpers.derivation import Array
from tests.helpers.differences import INPUTS, difference, outputs, point_of, variational
from tests.helpers.published import PASSIVE_GAITS, TOE_OFF_GAITS
from tests.helpers.samples import POWERED
from tests.model.test_locking import WALKS, Walk
from tests.model.test_push_off import simplest

DIRECTIONS = INPUTS - 1  # the last of a walker's numbers is its physics
EVERY = np.eye(DIRECTIONS, INPUTS)
NAMES = [*(f"state {i}" for i in range(4)), "angle", "strength", *NUMBERS[:-1]]
LIMIT = NAMES.index("torque_limit")
OF_THE_KNEE = [NAMES.index(name) for name in quantities(Knee)]
AT_THE_HIP = [
    NAMES.index(name) for name in ("leg_length", "leg_inertia", "com_along", "com_across")
]


def agree(
    params: WalkerParams, state: Array, control: AnyControl | None, within: float = 1e-8
) -> Array:
    """Every column to 1e-8 of its largest entry (of all entries, for state and control)."""
    scheme = scheme_of(control)
    point = point_of(state, scheme.row(control), params)
    strides, exact = variational(scheme.cycle, point, EVERY)
    assert strides.outcome[0] == Outcome.WALKED
    # Controls that the scheme has not, and no limit at all, change nothing. A mass that leaves
    # the hip is another walker: the limit of massless feet has no derivative by its place.
    nothing = [4 + column for column in (ANGLE, STRENGTH) if column not in scheme.columns]
    nothing += [LIMIT] if params.torque_limit == 0 else []
    nothing += OF_THE_KNEE if params.knee is None else []
    assert not exact[:, nothing].any()
    skipped = nothing + (AT_THE_HIP if params.massless_foot else [])
    for column in (k for k in range(DIRECTIONS) if k not in skipped):
        size = abs(point[column]) or 1.0
        tries = [
            difference(scheme.cycle, point, EVERY[column], size * 10**-e)
            for e in np.arange(2, 7, 0.5)
        ]
        largest = max(np.abs(exact[:, column]).max(), 1e-3)
        gap = np.nanmin([np.abs(exact[:, column] - one).max() for one in tries])
        assert gap < within * largest, (NAMES[column], gap / largest)
    return exact


@pytest.mark.parametrize("name", POWERED)
def test_derivatives_of_a_powered_stride_are_exact_in_every_direction(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    agree(params, np.array(state), control)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_derivatives_of_a_passive_stride_are_exact_in_every_direction(gait) -> None:  # type: ignore[no-untyped-def]
    agree(gait.params, np.array(gait.state), None)


def test_derivatives_away_from_the_gait_and_with_nothing_zero_are_exact() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    general = params.replace(slope=1e-3, com_across=1e-5, leg_inertia=1.0)
    away = np.add(state, [0.005, -0.005, 0.02, 0.02])
    agree(general, away, control)


def test_where_the_motor_starts_with_the_stride_the_switch_angle_does_not_matter() -> None:
    params, _, state, _ = PRESETS["camp1997"]
    early = Control(3.45, 600.0)  # the hip is past it already, and closing
    agree(params, np.array(state), early)
    mapped = StrideMap(params, early).differentiate(state)
    np.testing.assert_array_equal(mapped.by_control[:, 0], 0.0)
    assert np.abs(mapped.by_control[:, 1]).max() > 0


def test_a_map_over_two_strides_has_the_product_of_derivatives() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    start = np.array(state) + 1e-3
    stride_map = StrideMap(params, control)
    twice = stride_map.differentiate(start, period=2)
    first = stride_map.differentiate(start)
    second = stride_map.differentiate(first.state)
    np.testing.assert_array_equal(twice.state, second.state)
    np.testing.assert_allclose(twice.by_state, second.by_state @ first.by_state, rtol=1e-14)
    chained = second.by_state @ first.by_control + second.by_control
    np.testing.assert_allclose(twice.by_control, chained, rtol=1e-14)


def test_the_stride_with_derivatives_is_the_stride_without_bit_for_bit() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    point = point_of(np.array(state), MOTOR.row(control), params)
    plain = outputs(MOTOR.cycle, point[np.newaxis])[0, :4]
    np.testing.assert_array_equal(StrideMap(params, control).differentiate(point[:4]).state, plain)


def test_after_a_fall_the_derivatives_are_not_numbers() -> None:
    params, control, _, _ = PRESETS["round-foot"]
    mapped = StrideMap(params, control).differentiate((-1.0, 0.2, 0.0, 0.0))
    assert mapped.outcome == Outcome.FELL_BACKWARD
    assert np.isnan(mapped.by_state).all()


# Schemes: toe-off, hip torque, a motor with a stop, a hip spring, a limit of the torque.

TOE_OFF = TOE_OFF_GAITS[0]


@pytest.mark.parametrize("timing", [ToeOff, ToeOffAtStrike, LateToeOff])
def test_derivatives_of_a_toe_off_are_exact_in_every_direction(timing: type[ToeOff]) -> None:
    general = TOE_OFF.params.replace(slope=1e-3, com_across=1e-3, hip_stiffness=0.05)
    exact = agree(general, np.array(TOE_OFF.state), timing(0.1))
    assert np.abs(exact[2:4, 4 + STRENGTH]).min() > 1e-2  # the impulse changes both rates
    assert not exact[[0, 1, 4, 5], 4 + STRENGTH].any()  # and comes too late for all else


def test_derivatives_of_a_toe_off_from_round_feet_are_exact() -> None:
    round_feet = TOE_OFF.params.replace(foot_radius=0.2, foot_length=0.05, locked_ankle_angle=2.5)
    agree(round_feet, np.array(TOE_OFF.state), ToeOff(0.1))


def test_derivatives_of_kuos_walker_with_massless_feet_are_exact() -> None:
    state = np.array([-0.355460, 0.355460, 0.505619, 0.383139])
    agree(simplest(hip_stiffness=2.5127), state, ToeOff(0.1877))


@pytest.mark.parametrize("switch", [3.4, 2.9])
def test_derivatives_of_a_hip_torque_are_exact_in_every_direction(switch: float) -> None:
    general = TOE_OFF.params.replace(slope=0.01, com_across=1e-3, hip_stiffness=0.05)
    exact = agree(general, np.array(TOE_OFF.state), HipTorque(switch, 0.02))
    assert np.abs(exact[:, 4 + STRENGTH]).max() > 1e-2


def test_a_stop_that_lets_go_at_once_has_the_derivatives_of_a_motor_without() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    assert isinstance(control, Control)
    stopped = StoppedControl(control.switch_angle, control.stall_torque)
    expected = StrideMap(params, control).differentiate(state).by
    by = StrideMap(params, stopped).differentiate(state).by
    np.testing.assert_allclose(by, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "walk",
    WALKS,
    ids=["lets-go", "comes-back", "too-weak"],
)
def test_derivatives_with_a_stop_are_exact_through_release_and_impact(walk: Walk) -> None:
    name, switch, stall = walk
    params, _, state, _ = PRESETS[name]
    agree(params.replace(hip_stiffness=1.0), np.array(state), StoppedControl(switch, stall))


def test_derivatives_of_a_motor_always_at_its_limit_are_exact() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    general = params.replace(torque_limit=1200.0, hip_stiffness=2.0)
    exact = agree(general, np.array(state), control)
    assert np.abs(exact[:, LIMIT]).max() > 1e-5
    assert not exact[:, 4 + STRENGTH].any()  # its line is never met


def test_derivatives_of_a_motor_that_comes_off_its_limit_are_good_to_the_step_with_the_kink() -> (
    None
):
    """∂f/∂y jumps inside one step; the step control makes it about √(1e-14) long."""
    params, control, state, _ = PRESETS["round-foot"]
    general = params.replace(torque_limit=2600.0, hip_stiffness=2.0)
    exact = agree(general, np.array(state), control, within=1e-5)
    assert (np.abs(exact[:, [LIMIT, 4 + STRENGTH]]).max(axis=0) > 1e-5).all()
