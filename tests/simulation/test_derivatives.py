"""Batches of strides with derivatives: those of the stride map, row by row."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, Outcome, StrideMap, stride_batch
from powered_walker_env.simulation.derivatives import PARAMETERS, differentiate_batch
from powered_walker_env.simulation.threads import at_most
from tests.helpers.derivation import Array
from tests.helpers.published import PASSIVE_GAITS

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
assert CONTROL is not None
NOMINAL = np.array([CONTROL.switch_angle, CONTROL.stall_torque])
FALLEN = (-1.0, 0.2, 0.0, 0.0)
COUNT = 40  # more than one thread takes


def states(count: int = COUNT) -> Array:
    return STATE + 0.003 * np.random.default_rng(0).normal(size=(count, 4))


def test_every_row_has_the_derivatives_of_the_stride_map() -> None:
    names = ("foot_radius", "stall_torque")
    batch = differentiate_batch(states(), NOMINAL, PARAMS, by=names, rtol=1e-13)
    for i in (0, 17, COUNT - 1):
        point = StrideMap(PARAMS, CONTROL).differentiate(states()[i], by=names)
        np.testing.assert_array_equal(batch.strides.state[i], point.state)
        np.testing.assert_array_equal(batch.by_state[i], point.by_state)
        np.testing.assert_array_equal(batch.by_control[i], point.by_control)
        np.testing.assert_array_equal(batch.by_parameters[i], point.by_parameters)
        np.testing.assert_array_equal(batch.duration_by[i], point.duration_by)
        np.testing.assert_array_equal(batch.step_length_by[i], point.step_length_by)
    np.testing.assert_array_equal(batch.by_parameters[..., 1], batch.by_control[..., 1])


def test_the_strides_are_those_of_a_batch_without_derivatives_bit_for_bit() -> None:
    plain = stride_batch(states(), NOMINAL, PARAMS)
    with_derivatives = differentiate_batch(states(), NOMINAL, PARAMS).strides
    np.testing.assert_array_equal(with_derivatives.results, plain.results)


def test_a_row_does_not_depend_on_the_batch_nor_on_the_threads() -> None:
    walkers = [PARAMS.replace(slope=1e-4 * i) for i in range(COUNT)]
    with at_most(1):
        alone = differentiate_batch(states(), NOMINAL, walkers)
    together = differentiate_batch(states(), NOMINAL, walkers)
    np.testing.assert_array_equal(together.by, alone.by)
    one = differentiate_batch(states()[5:6], NOMINAL, walkers[5])
    np.testing.assert_array_equal(one.by[0], together.by[5])


def test_a_fall_has_no_derivatives_and_harms_no_other_row() -> None:
    start = states(3)
    start[1] = FALLEN
    batch = differentiate_batch(start, NOMINAL, PARAMS)
    assert batch.strides.outcome[1] == Outcome.FELL_BACKWARD
    assert np.isnan(batch.by[1]).all()
    assert np.isfinite(batch.by[[0, 2]]).all()


def test_a_passive_walker_has_no_derivatives_by_a_control() -> None:
    gait = PASSIVE_GAITS[0]
    batch = differentiate_batch([gait.state], None, gait.params)
    assert batch.strides.walked.all()
    assert batch.by_control.shape == (1, 4, 0)
    assert batch.by_state.any()


def test_no_rows_are_no_error() -> None:
    assert differentiate_batch(np.empty((0, 4)), NOMINAL, PARAMS).by.shape == (0, 6, 6)


@pytest.mark.parametrize(
    ("start", "by", "rtol", "message"),
    [
        ([[0.0, 1.0]], (), 1e-9, r"states must have shape \(N, 4\)"),
        ([(np.nan, 0.0, 0.0, 0.0)], (), 1e-9, "states must be finite, got .* in row 0"),
        ([STATE], ("physics",), 1e-9, "parameter must be one of .* got 'physics'"),
        ([STATE], (), 1.0, "rtol must lie in"),
    ],
)
def test_bad_input_is_named(
    start: list[tuple[float, ...]], by: tuple[str, ...], rtol: float, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        differentiate_batch(start, NOMINAL, PARAMS, by=by, rtol=rtol)
    assert "physics" not in PARAMETERS
