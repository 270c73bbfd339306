"""The derivatives of a stride against differences of strides at the tightest tolerance."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, WalkerParams, kernel, record
from powered_walker_env.phases import Cycle, Outcome, encode
from powered_walker_env.physics.constants import PACKED, pack
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.schemes import PASSIVE_WALKER, POWERED_WALKER, scheme_of
from powered_walker_env.sensitivity import OUTPUTS
from powered_walker_env.stride import NO_LOG
from tests.derivation import Array
from tests.published import PASSIVE_GAITS
from tests.samples import MOTORS

WALKER = slice(6, 6 + PACKED)  # columns of a point: state 4, control 2, packed walker
DIRECTIONS = 6 + PACKED - 1  # all of them but the walker's physics, which is no number
FLAT = np.zeros(1)


def run(cycle: Cycle, points: Array, rtol: float, changes: Array | None = None) -> tuple[Any, Any]:
    """Results and derivatives (N, n, OUTPUTS); each row of points is its own walker."""
    count, n = len(points), 0 if changes is None else len(changes)
    results, derivatives = np.empty((count, record.RESULTS)), np.empty((count * n, OUTPUTS))
    parts = (np.ascontiguousarray(points[:, cut]) for cut in (slice(4), slice(4, 6), WALKER))
    kernel.run_strides(
        encode(cycle), *parts, FLAT, rtol, results, 0.0, NO_LOG, changes, derivatives
    )
    return results, derivatives.reshape(count, n, OUTPUTS)


TORQUE_LIMIT = 6 + PACKED - 2  # the last of a walker's numbers


def derivative(cycle: Cycle, point: Array, rtol: float = 1e-13) -> Array:
    """(OUTPUTS, DIRECTIONS) by the variational equations."""
    results, derivatives = run(cycle, point[np.newaxis], rtol, np.eye(DIRECTIONS, 6 + PACKED))
    assert results[0, record.OUTCOME] == Outcome.WALKED
    return np.asarray(derivatives[0].T)


def outputs(cycle: Cycle, points: Array) -> Array:
    """(N, OUTPUTS) of plain strides, NaN for falls; each row of points is its own walker."""
    results, _ = run(cycle, points, 1e-13)
    wanted = (record.DURATION, record.STEP_LENGTH)
    return np.column_stack([results[:, record.STATE], *(results[:, k] for k in wanted)])


def difference(cycle: Cycle, point: Array, column: int, h: float) -> Array:
    """Sixth-order central difference (Richardson's, twice) in one direction."""
    offsets = np.array([-3, -2, -1, 1, 2, 3])
    points = np.tile(point, (6, 1))
    points[:, column] += offsets * h
    return np.array([-1, 9, -45, 45, -9, 1]) @ outputs(cycle, points) / (60 * h)


def agree(cycle: Cycle, params: WalkerParams, state: Array, control: Control | None) -> None:
    """Every column to 1e-8 of its largest entry (of all entries, for state and control)."""
    point = np.concatenate([state, np.array(scheme_of(control).row(control)), pack(params)])
    exact = derivative(cycle, point)
    for column in range(DIRECTIONS):
        if cycle == PASSIVE_WALKER and column in (4, 5):
            assert not exact[:, column].any()  # a passive walker has no control
            continue
        if column == TORQUE_LIMIT and point[column] == 0.0:
            assert not exact[:, column].any()  # a motor without a limit
            continue
        size = abs(point[column]) or 1.0
        tries = [difference(cycle, point, column, size * 10**-e) for e in np.arange(2, 7, 0.5)]
        largest = max(np.abs(exact[:, column]).max(), 1e-3)
        gap = np.nanmin([np.abs(exact[:, column] - one).max() for one in tries])
        assert gap < 1e-8 * largest, (column, gap / largest)


@pytest.mark.parametrize("name", MOTORS)
def test_derivatives_of_a_powered_stride_are_exact_in_every_direction(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    agree(POWERED_WALKER, params, np.array(state), control)


@pytest.mark.parametrize("gait", PASSIVE_GAITS, ids=str)
def test_derivatives_of_a_passive_stride_are_exact_in_every_direction(gait) -> None:  # type: ignore[no-untyped-def]
    agree(PASSIVE_WALKER, gait.params, np.array(gait.state), None)


def test_derivatives_away_from_the_gait_and_with_nothing_zero_are_exact() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    general = params.replace(slope=1e-3, com_across=1e-5, leg_inertia=1.0, hip_stiffness=0.2)
    away = np.add(state, [0.005, -0.005, 0.02, 0.02])
    agree(POWERED_WALKER, general, away, control)


def test_where_the_motor_starts_with_the_stride_the_switch_angle_does_not_matter() -> None:
    params, _, state, _ = PRESETS["camp1997"]
    early = Control(3.45, 600.0)  # the hip is past it already, and closing
    agree(POWERED_WALKER, params, np.array(state), early)
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
    point = np.concatenate([state, np.array(scheme_of(control).row(control)), pack(params)])
    plain = outputs(POWERED_WALKER, point[np.newaxis])[0, :4]
    np.testing.assert_array_equal(StrideMap(params, control).differentiate(point[:4]).state, plain)


def test_after_a_fall_the_derivatives_are_not_numbers() -> None:
    params, control, _, _ = PRESETS["round-foot"]
    mapped = StrideMap(params, control).differentiate((-1.0, 0.2, 0.0, 0.0))
    assert mapped.outcome == Outcome.FELL_BACKWARD
    assert np.isnan(mapped.by_state).all()


@pytest.mark.slow  # a timing: quiet machines only
def test_a_stride_with_the_derivatives_of_a_jacobian_costs_at_most_8_plain_ones() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    point = np.concatenate([state, np.array(scheme_of(control).row(control)), pack(params)])
    count, rtol = 200, 1e-9
    points = np.tile(point, (count, 1))

    def seconds(work: Callable[[], object]) -> float:
        begin = time.process_time()
        work()
        return time.process_time() - begin

    def plain() -> None:
        run(POWERED_WALKER, points, rtol)

    def differentiated() -> None:
        run(POWERED_WALKER, points, rtol, np.eye(6, 6 + PACKED))

    plain(), differentiated()
    pairs = [(seconds(differentiated), seconds(plain)) for _ in range(15)]
    assert min(pair[0] for pair in pairs) < 8 * min(pair[1] for pair in pairs)
