"""The stride kernel: eight walkers abreast walk as each would alone, and none holds the others."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Outcome, WalkerParams, stride_batch
from powered_walker_env.compiled.lanes import LANES
from powered_walker_env.model.knees import encode
from powered_walker_env.model.mechanics.packing import OWN, ROW, pack, row_tangents
from powered_walker_env.model.phases import Cycle, Exit, Guard, Joints, Phase, Reset, Torque
from powered_walker_env.model.powering import PASSIVE_WALKER, POWERED_WALKER, scheme_of
from powered_walker_env.simulation import kernel, record, threads
from powered_walker_env.simulation.directions import CHANGES, OUTPUTS
from powered_walker_env.simulation.strides import NO_ROWS
from powered_walker_env.simulation.waiting import RESTING
from tests.helpers.derivation import Array
from tests.helpers.landings import clear_of_together
from tests.helpers.samples import MOTORS, PASSIVE

ORDER = 120  # strides of a mixed batch
SPREAD = np.array([0.02, 0.02, 0.06, 0.1])  # rad, rad, rad/s, rad/s: far beyond any basin
FLAT = np.zeros(1)


class Rows:
    """Strides to walk: a row each of states, controls, packed walkers and heights."""

    def __init__(self, cycle: Cycle, states: Array, controls: Array, walkers: Array) -> None:
        self.cycle, self.states, self.controls, self.walkers = cycle, states, controls, walkers
        self.heights = np.zeros(len(states))

    def at(self, chosen: Any) -> Rows:
        """Some of them, in that order."""
        parts = (
            np.ascontiguousarray(a[chosen]) for a in (self.states, self.controls, self.walkers)
        )
        some = Rows(self.cycle, *parts)
        some.heights = np.ascontiguousarray(self.heights[chosen])
        return some

    def walked(
        self, rtol: float = 1e-9, changes: Array = NO_ROWS, workspace: Array | None = None
    ) -> tuple[Array, Array]:
        """Results and derivatives, by the kernel alone in one thread.

        Args:
            changes: (n, CHANGES + OWN) directions, of state, control and walker.
            workspace: one that was used before.
        """
        count, n = len(self.states), len(changes)
        results, derivatives = np.empty((count, record.RESULTS)), np.empty((count * n, OUTPUTS))
        walkers = NO_ROWS
        if n:
            of_each = [row_tangents(self.walkers[:, :OWN], row[CHANGES:]) for row in changes]
            walkers = np.stack(of_each, axis=1).reshape(-1, ROW)
        kernel.run_strides(
            kernel.workspace_for(n) if workspace is None else workspace, encode(self.cycle),
            self.states, self.controls, self.walkers, self.heights, rtol, results, 0.0, NO_ROWS,
            np.ascontiguousarray(changes[:, :CHANGES]), walkers, derivatives,
        )  # fmt: skip
        return results, derivatives.reshape(count, n, OUTPUTS)


def mixed(names: list[str], seed: int) -> Rows:
    """Every walker of these presets, both physics; falls, states that are no numbers, steps."""
    rng = np.random.default_rng(seed)
    states, controls, walkers = [], [], []
    for i in range(ORDER):
        params, control, state, _ = PRESETS[names[i % len(names)]]
        states.append(np.array(state) + rng.normal(size=4) * SPREAD)
        controls.append(scheme_of(control).row(control))
        walkers.append(pack(params))
    rows = Rows(
        PASSIVE_WALKER if names == PASSIVE else POWERED_WALKER,
        np.array(states), np.array(controls), np.array(walkers),
    )  # fmt: skip
    rows.states[7::31, rng.integers(4)] = math.nan
    rows.states[11::29, 2] = -2.0  # falls back
    rows.states[13::37, 2] = 1e200  # beyond any arithmetic
    rows.heights[::5] = rng.normal(size=len(rows.heights[::5])) * 1e-3
    return rows


MIXED = {
    "powered": (mixed(MOTORS, 1), {Outcome.WALKED, Outcome.NOT_FINITE, Outcome.FELL_BACKWARD}),
    "passive": (mixed(PASSIVE, 2), {Outcome.WALKED, Outcome.NOT_FINITE, Outcome.FELL_BACKWARD}),
}


@pytest.fixture(params=MIXED)
def batch(request: pytest.FixtureRequest) -> Rows:
    """A batch of walkers of every kind."""
    rows, expected = MIXED[request.param]
    found = set(rows.walked()[0][:, record.OUTCOME].astype(int).tolist())
    assert expected <= found, "the batch does not hold what it should"
    return rows


def alone(rows: Rows) -> Array:
    """The results of every row in a batch of its own."""
    return np.concatenate([rows.at([i]).walked()[0] for i in range(len(rows.states))])


@pytest.mark.parametrize("size", [*range(1, 18), 100])
def test_a_batch_of_any_size_walks_as_its_rows_do_alone(batch: Rows, size: int) -> None:
    singles = alone(batch.at(slice(0, size)))
    np.testing.assert_array_equal(batch.at(slice(0, size)).walked()[0], singles)


def test_a_stride_is_the_same_in_every_lane_among_any_neighbours(batch: Rows) -> None:
    singles, rng = alone(batch), np.random.default_rng(3)
    for row in range(0, ORDER, 7):
        for lane in range(LANES):
            crowd = rng.integers(ORDER, size=LANES)
            crowd[lane] = row
            np.testing.assert_array_equal(batch.at(crowd).walked()[0], singles[crowd])


def test_the_order_of_the_rows_does_not_matter(batch: Rows) -> None:
    whole, rng = batch.walked()[0], np.random.default_rng(4)
    for _ in range(5):
        order = rng.permutation(ORDER)
        np.testing.assert_array_equal(batch.at(order).walked()[0], whole[order])


@pytest.mark.parametrize("count", [1, 2])
def test_threads_change_no_bit(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, _ = MIXED["powered"]
    finite = np.isfinite(rows.states).all(axis=1)
    walkers = [preset_of(i) for i in np.flatnonzero(finite)]
    monkeypatch.setattr(threads, "cores", lambda: count)
    found = stride_batch(
        rows.states[finite], rows.controls[finite], walkers, step_height=rows.heights[finite]
    )
    np.testing.assert_array_equal(found.results, rows.walked()[0][finite])


def preset_of(row: int) -> WalkerParams:
    """The walker in a row of the powered batch."""
    return PRESETS[MOTORS[row % len(MOTORS)]].params


def test_one_walker_for_all_rows_is_the_same_as_one_in_each() -> None:
    rows = MIXED["powered"][0].at(slice(0, ORDER, len(MOTORS)))
    shared = rows.at(slice(None))
    shared.walkers, shared.heights = rows.walkers[:1], FLAT
    rows.heights = np.zeros(len(rows.states))
    np.testing.assert_array_equal(shared.walked()[0], rows.walked()[0])


def test_asking_for_derivatives_changes_no_bit_of_the_results(batch: Rows) -> None:
    plain, _ = batch.walked()
    for n in (1, CHANGES, CHANGES + OWN - 1):
        results, _ = batch.walked(changes=np.eye(n, CHANGES + OWN))
        np.testing.assert_array_equal(results, plain)


def test_derivatives_do_not_depend_on_the_neighbours(batch: Rows) -> None:
    changes = np.eye(CHANGES, CHANGES + OWN)
    whole, rng = batch.walked(changes=changes)[1], np.random.default_rng(5)
    for row in rng.integers(ORDER, size=20):
        np.testing.assert_array_equal(batch.at([row]).walked(changes=changes)[1][0], whole[row])
    order = rng.permutation(ORDER)
    np.testing.assert_array_equal(batch.at(order).walked(changes=changes)[1], whole[order])


def test_a_workspace_that_was_used_before_leaves_no_trace() -> None:
    """Of other walkers and cycles, of numbers that are none, of lanes that were not used again."""
    used = kernel.workspace_for()
    for name, (params, control, state, _) in PRESETS.items():
        powered = scheme_of(control)
        for count in (20, 1):
            states = np.tile(state, (count, 1))
            states[1:] += np.random.default_rng(count).normal(size=(count - 1, 4)) * SPREAD
            states[2:3] = math.nan
            controls = np.tile(powered.row(control), (count, 1))
            rows = Rows(powered.cycle, states, controls, np.array([pack(params)]))
            found, _ = rows.walked(workspace=used)
            np.testing.assert_array_equal(found, rows.walked()[0], err_msg=name)


def test_a_row_writes_only_its_own_results() -> None:
    rows = MIXED["powered"][0].at(slice(0, 5))
    frame = np.full((7, record.RESULTS), 0.5)
    kernel.run_strides(
        kernel.workspace_for(), encode(rows.cycle), rows.states, rows.controls, rows.walkers,
        rows.heights, 1e-9, frame[1:6], 0.0, NO_ROWS, NO_ROWS, NO_ROWS, NO_ROWS,
    )  # fmt: skip
    np.testing.assert_array_equal(frame[1:6], rows.walked()[0])
    assert (frame[[0, 6]] == 0.5).all()


def test_no_strides_are_no_work() -> None:
    results, _ = MIXED["powered"][0].at(slice(0, 0)).walked()
    assert results.shape == (0, record.RESULTS)


def test_a_guard_that_never_falls_ends_no_phase() -> None:
    """A way out of a phase that cannot be taken changes nothing, the last one least."""
    rows, _ = MIXED["passive"]
    (swing,) = PASSIVE_WALKER
    never = Exit(Guard.NEVER, Reset.CONTINUE, Outcome.NO_SWITCH)
    twice = rows.at(slice(None))
    twice.cycle = (swing._replace(exits=(*swing.exits, never)),)
    np.testing.assert_array_equal(twice.walked()[0], rows.walked()[0])
    twice.cycle = (swing._replace(exits=(never,)),)
    ends = set(twice.walked()[0][:, record.OUTCOME].astype(int).tolist())
    assert not ends & {Outcome.WALKED, Outcome.NO_SWITCH, Outcome.STEP_LIMIT}


def repeated(name: str, count: int, state: Any = None, control: Any = None) -> Rows:
    """The same stride of a powered preset so many times."""
    params, nominal, start, _ = PRESETS[name]
    assert nominal is not None
    chosen = control or (nominal.switch_angle, nominal.stall_torque)
    parts = (np.tile(a, (count, 1)) for a in (state or start, chosen, pack(params)))
    return Rows(POWERED_WALKER, *parts)


def joined(one: Rows, other: Rows, places: Array) -> Rows:
    """The rows of `one`, with those of `other` before the places."""
    parts = (
        np.insert(getattr(one, n), places, getattr(other, n), axis=0)
        for n in ("states", "controls", "walkers")
    )
    return Rows(one.cycle, *parts)


#: Balanced at rest on level ground, and pulled by a motor a million times too strong.
BALANCED = WalkerParams(foot_length=0.0, foot_radius=0.3, com_along=0.2, leg_inertia=100.0)
ENDLESS = {
    Outcome.NO_LANDING: Rows(
        PASSIVE_WALKER,
        np.zeros((1, 4)),
        np.array([scheme_of(None).row(None)]),
        pack(BALANCED)[np.newaxis],
    ),
    Outcome.STEP_LIMIT: repeated("round-foot", 1, control=(2.704, 1e9)),
}


@pytest.mark.parametrize("outcome", ENDLESS)
def test_a_stride_without_end_is_given_up_and_holds_no_other(outcome: Outcome) -> None:
    slow = ENDLESS[outcome]
    assert slow.walked()[0][0, record.OUTCOME] == outcome
    names = MOTORS if slow.cycle == POWERED_WALKER else PASSIVE
    healthy = mixed(names, 6)
    places = np.array([0, 50, ORDER])
    both = joined(healthy, slow.at([0, 0, 0]), places)
    both.heights = np.insert(healthy.heights, places, 0.0)
    results, _ = both.walked()
    walked = np.ones(len(results), bool)
    walked[places + np.arange(3)] = False
    np.testing.assert_array_equal(results[walked], healthy.walked()[0])
    np.testing.assert_array_equal(results[~walked], np.repeat(slow.walked()[0], 3, axis=0))


def test_a_cycle_of_phases_that_take_no_time_is_given_up() -> None:
    """Past its switch angle and closing, each phase leads on at once to the other."""
    on = Phase(
        "on", Joints.ANKLE_LOCKED, Torque.NONE, (Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "off"),)
    )
    off = on._replace(name="off", exits=(Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "on"),))
    rows = repeated("round-foot", 20, control=(6.0, 0.0))
    rows.cycle = (on, off)
    results, _ = rows.walked()
    assert (results[:, record.OUTCOME] == Outcome.STEP_LIMIT).all()
    assert (results[:, record.DURATION] == 0.0).all()


@pytest.mark.parametrize("name", MOTORS)
def test_the_error_is_within_ten_tolerances_and_no_event_is_jumped_over(name: str) -> None:
    """At a coarse tolerance a step could reach beyond a heel strike and its recovery.

    Feet that land side by side, to the tolerance, are no landing: those few strides go on.
    """
    rows, rng = repeated(name, 3000), np.random.default_rng(20)
    rows.states += rng.normal(size=rows.states.shape) * SPREAD
    exact, _ = rows.walked(1e-12)
    walked = exact[:, record.OUTCOME] == Outcome.WALKED
    assert 900 < walked.sum() < 2900
    compared = [*range(4), record.DURATION]
    for rtol in 10.0 ** -np.arange(3, 9):
        found, _ = rows.walked(rtol)
        clear = clear_of_together(exact[:, record.FINAL], PRESETS[name].params, rtol)
        same = ~walked | clear
        assert (~same).mean() < 0.005
        np.testing.assert_array_equal(found[same, record.OUTCOME], exact[same, record.OUTCOME])
        error = np.abs(found - exact)[walked & clear][:, compared]
        assert error.max() < 10.0 * rtol


@pytest.mark.parametrize("rtol", [1e-5, 1e-9])
@pytest.mark.parametrize("name", PRESETS)
def test_strides_that_rest_between_phases_are_the_same_strides(name: str, rtol: float) -> None:
    """Most of a batch rest, while others walk chains of as many links; alone nobody does, and
    eight never, whose chains differ while they walk."""
    params, control, state, _ = PRESETS[name]
    rng = np.random.default_rng(8)
    states = (
        np.array(state) + rng.normal(size=(160, 4)) * SPREAD * np.repeat([0.1, 1.0], 80)[:, None]
    )
    rows = Rows(
        scheme_of(control).cycle, states, np.array([scheme_of(control).row(control)] * 160),
        np.array([pack(params)]),
    )  # fmt: skip
    rows.heights[::3] = rng.normal(size=len(rows.heights[::3])) * 1e-3
    together, _ = rows.walked(rtol)
    np.testing.assert_array_equal(together, some_at_a_time(rows, 1, rtol))
    np.testing.assert_array_equal(together, some_at_a_time(rows, LANES, rtol))


def some_at_a_time(rows: Rows, size: int, rtol: float) -> Array:
    """The results of all, so many in a batch."""
    found = []
    for first in range(0, len(rows.states), size):
        part = slice(first, first + size)
        some = Rows(rows.cycle, rows.states[part], rows.controls[part], rows.walkers)
        some.heights = rows.heights[part]
        found.append(some.walked(rtol)[0])
    return np.concatenate(found)


def test_a_stride_at_rest_fits_into_its_row_of_the_results() -> None:
    assert RESTING.size <= record.RESULTS
