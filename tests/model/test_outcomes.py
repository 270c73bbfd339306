"""How strides end: every way has its name, and every stride ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, WalkerParams, stride, stride_batch
from tests.helpers.samples import random_walkers

THESIS, ROUND = PRESETS["camp1997"], PRESETS["round-foot"]
assert THESIS.control is not None
assert ROUND.control is not None


def outcome(state: tuple[float, ...], control: Control | None, params: WalkerParams) -> Outcome:
    return stride(state, control, params).outcome


def test_a_walker_leaning_far_back_falls_backward() -> None:
    assert outcome((-1.0, 0.2, 0.0, 0.0), ROUND.control, ROUND.params) == Outcome.FELL_BACKWARD


def test_a_walker_rushing_forward_falls_forward_or_on_its_hip() -> None:
    late = Control(0.5, 0.0)
    fell = outcome((0.9, 0.5, 6.0, 9.0), late, ROUND.params)
    assert fell in (Outcome.FELL_FORWARD, Outcome.HIP_BELOW_FLOOR)


def test_a_leg_swung_wildly_reaches_the_horizontal() -> None:
    wild = outcome((-0.3, 0.4, 1.0, -30.0), Control(0.2, 100.0), ROUND.params)
    assert wild == Outcome.SWING_LEG_HORIZONTAL


def test_far_too_much_torque_rolls_the_foot_over() -> None:
    strong = Control(THESIS.control.switch_angle, 20_000.0)  # type: ignore[union-attr]
    assert outcome(THESIS.state, strong, THESIS.params) == Outcome.FOOT_ROLLED_OVER


def test_a_motor_too_weak_for_the_weight_lets_the_foot_fall_back() -> None:
    weak = Control(THESIS.control.switch_angle, 0.0)  # type: ignore[union-attr]
    assert outcome(THESIS.state, weak, THESIS.params) == Outcome.FOOT_FELL_BACK


def test_landing_before_the_switch_is_no_switch() -> None:
    late = Control(1.0, ROUND.control.stall_torque)  # type: ignore[union-attr]
    assert outcome(ROUND.state, late, ROUND.params) == Outcome.NO_SWITCH


def test_a_walker_balanced_on_the_way_does_not_land_in_time() -> None:
    # A passive walker on level ground with its legs together at rest: an equilibrium.
    params = WalkerParams(foot_length=0.0, foot_radius=0.3, com_along=0.2, leg_inertia=100.0)
    ended = stride((0.0, 0.0, 0.0, 0.0), None, params)
    assert ended.outcome == Outcome.NO_LANDING
    limit = 20 * math.sqrt(params.leg_length / params.gravity)
    assert ended.duration == pytest.approx(limit)


def test_a_start_that_is_already_down_is_a_fall_at_once() -> None:
    ended = stride((1.6, 0.2, 1.0, 0.0), ROUND.control, ROUND.params)
    assert ended.outcome == Outcome.FELL_FORWARD
    assert ended.duration == 0


def test_numbers_too_large_to_integrate_are_not_finite_and_not_endless() -> None:
    ended = stride((-0.3, 0.4, 1e200, 1e200), ROUND.control, ROUND.params)
    assert ended.outcome in (Outcome.NOT_FINITE, Outcome.STEP_LIMIT)


def test_a_hip_already_past_the_switch_and_closing_starts_the_motor_at_once() -> None:
    early = Control(6.0, ROUND.control.stall_torque)  # type: ignore[union-attr]
    from powered_walker_env import walk

    events = walk(ROUND.state, early, ROUND.params, 1).events
    assert events[0].phase == "swing"
    assert events[0].t == 0


def test_after_a_fall_there_is_no_post_strike_state_but_a_final_one() -> None:
    ended = stride((-1.0, 0.2, 0.0, 0.0), ROUND.control, ROUND.params)
    assert np.isnan(ended.state).all()
    assert np.isfinite([*ended.final.q, *ended.final.u]).all()
    assert ended.step_length == 0


def test_a_fall_ends_where_the_leg_is_horizontal() -> None:
    ended = stride((-1.0, 0.2, 0.0, 0.0), ROUND.control, ROUND.params)
    assert ended.final.q[0] + ended.final.q[1] == pytest.approx(-math.pi / 2, abs=1e-9)


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_says_what_happened(outcome: Outcome) -> None:
    assert outcome.description.endswith(".")
    assert "_" not in outcome.label


@pytest.mark.parametrize("powered", [True, False])
def test_wild_walkers_in_wild_states_all_end_with_a_name(powered: bool) -> None:
    rng = np.random.default_rng(7)
    walkers = list(random_walkers(8, 400))
    states = rng.normal(size=(400, 4)) * [1.0, 1.0, 5.0, 10.0]
    controls = np.column_stack([rng.uniform(0.01, 6.2, 400), 10 ** rng.uniform(-2, 6, 400)])
    batch = stride_batch(states, controls if powered else None, walkers)
    assert set(batch.outcome.tolist()) <= set(map(int, Outcome))
    assert len(set(batch.outcome.tolist())) >= 5
    np.testing.assert_array_equal(np.isfinite(batch.state).all(axis=1), batch.walked)


def test_bad_input_is_refused_with_its_name_and_value() -> None:
    good, control, params = ROUND.state, ROUND.control, ROUND.params
    with pytest.raises(ValueError, match=r"state\.swing_rate must be finite, got nan"):
        stride((*good[:3], math.nan), control, params)
    with pytest.raises(ValueError, match="state must be four numbers"):
        stride((1.0, 2.0), control, params)
    with pytest.raises(ValueError, match="rtol must lie in"):
        stride(good, control, params, rtol=0.0)
    with pytest.raises(ValueError, match="step_height must be finite"):
        stride(good, control, params, step_height=math.nan)
    with pytest.raises(TypeError, match="control must be one of Control"):
        stride(good, (2.9, 700.0), params)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="params must be a WalkerParams"):
        stride(good, control, {"leg_length": 1.0})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="foot_length must be positive for a powered walker"):
        stride(good, control, WalkerParams(foot_length=0.0))


def test_bad_batches_are_refused_with_their_row() -> None:
    good, params = np.tile(ROUND.state, (3, 1)), ROUND.params
    with pytest.raises(ValueError, match=r"states must have shape \(N, 4\), got \(3, 3\)"):
        stride_batch(good[:, :3], [2.7, 100.0], params)
    broken = good.copy()
    broken[2, 1] = np.inf
    with pytest.raises(ValueError, match=r"states must be finite, .* in row 2"):
        stride_batch(broken, [2.7, 100.0], params)
    with pytest.raises(
        ValueError, match=r"switch_angle must lie in \(0, 2\*pi\), got \[7.0, 1.0\] in row 1"
    ):
        stride_batch(good, [[1.0, 1.0], [7.0, 1.0], [1.0, 1.0]], params)
    with pytest.raises(ValueError, match=r"not be negative, got \[1.0, -1.0\] in row 0"):
        stride_batch(good, [1.0, -1.0], params)
    with pytest.raises(ValueError, match="one row for each of 3 states, got 2"):
        stride_batch(good, [[1.0, 1.0], [1.0, 1.0]], params)
    with pytest.raises(ValueError, match="one walker or 3, got 2"):
        stride_batch(good, [1.0, 1.0], [params, params])
    with pytest.raises(ValueError, match="one height or 3, got shape"):
        stride_batch(good, [1.0, 1.0], params, step_height=[0.0, 0.0])
