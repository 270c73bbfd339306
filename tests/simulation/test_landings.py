"""What is a landing: ahead of the stance foot, never beside it, on any ground, at any tolerance;
and what a stride is at all: it takes time, and its numbers are finite."""

from __future__ import annotations

import math

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, WalkerParams, stride, stride_batch, walk
from powered_walker_env.model.powering import SCHEMES, HipTorque, StoppedControl, ToeOff, scheme_of
from powered_walker_env.simulation import record
from powered_walker_env.simulation.walked import StrideBatch
from tests.helpers.derivation import Array
from tests.helpers.landings import room_ahead, together
from tests.helpers.samples import random_walkers

#: A wheel for a foot: no length, some radius. The legs pass with the clearance zero.
WHEEL = WalkerParams(
    foot_length=0.0, foot_radius=0.3, com_along=0.6, leg_inertia=20.0, leg_mass=100.0
)
SMALL_STEPS = [sign * 10.0**-e for e in (8, 9, 10, 11, 12, 13) for sign in (1, -1)]


def natural_starts(count: int, seed: int) -> Array:
    """The stance leg leans back, both feet about on the floor."""
    rng = np.random.default_rng(seed)
    stance = rng.uniform(-0.5, -0.05, count)
    swing = -stance * rng.uniform(0.8, 1.2, count)
    return np.column_stack([stance, swing, rng.uniform(0.2, 2, count), rng.uniform(-1, 1, count)])


@pytest.mark.parametrize(("switch", "torque"), [(3.3, 0.0), (3.6, 0.0), (3.6, 30.0), (3.3, 100.0)])
def test_a_wheel_s_feet_never_land_together_past_the_switch(switch: float, torque: float) -> None:
    """Motor, level floor, and a switch angle past π: the legs pass with the motor on."""
    states, control = natural_starts(2000, 1), [switch, torque]
    exact = stride_batch(states, control, WHEEL)
    room = room_ahead(exact.results[exact.walked][:, record.FINAL], WHEEL)
    assert (room > together(1e-9)).all()
    for last_digits in (1.0 + 2**-52, 1.0 - 2**-52, 1.1):
        near = stride_batch(states, control, WHEEL, rtol=1e-9 * last_digits)
        np.testing.assert_array_equal(near.outcome, exact.outcome)
    for height in SMALL_STEPS:
        near = stride_batch(states, control, WHEEL, step_height=height)
        np.testing.assert_array_equal(near.outcome, exact.outcome)


def test_a_wheel_walks_with_a_switch_past_pi_at_all() -> None:
    found = stride_batch(natural_starts(2000, 1), [3.3, 0.0], WHEEL)
    assert found.walked.sum() > 100
    assert set(found.outcome.tolist()) >= {
        Outcome.FELL_FORWARD, Outcome.FELL_BACKWARD, Outcome.FOOT_ROLLED_OVER
    }  # fmt: skip


@pytest.mark.parametrize("name", PRESETS)
def test_a_step_of_the_ground_that_is_next_to_nothing_changes_next_to_nothing(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    scheme, rng = scheme_of(control), np.random.default_rng(2)
    states = np.array(state) + rng.normal(size=(300, 4)) * [0.02, 0.02, 0.06, 0.1]
    numbers = None if control is None else [scheme.row(control)[k] for k in scheme.columns]

    def walked(height: float) -> StrideBatch:
        return stride_batch(
            states, numbers, params, step_height=height * params.leg_length, scheme=scheme.name
        )

    flat = walked(0.0)
    landed = flat.walked
    room = room_ahead(flat.results[:, record.FINAL], params)
    assert (room[landed] > together(1e-9)).all()
    clear = ~landed | (room > 1e-3)  # whoever lands this near may pass over a step, too
    assert landed.sum() > 20
    for height in SMALL_STEPS:
        near = walked(height)
        np.testing.assert_array_equal(near.outcome[clear], flat.outcome[clear])
        gap = np.abs(near.state - flat.state)[landed & clear]
        steepness = 1.0 + np.abs(flat.state[landed & clear]).max()
        assert gap.max() < (1e3 * abs(height) + 1e-8) * steepness


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9, 1e-12])
def test_no_landing_is_beside_the_stance_foot_at_any_tolerance(rtol: float) -> None:
    params, control, state, _ = PRESETS["camp1997"]
    assert isinstance(control, Control)
    rng = np.random.default_rng(3)
    states = np.array(state) + rng.normal(size=(3000, 4)) * [0.02, 0.02, 0.06, 0.1]
    found = stride_batch(states, [control.switch_angle, control.stall_torque], params, rtol=rtol)
    room = room_ahead(found.results[found.walked][:, record.FINAL], params)
    assert room.min() > together(rtol) * (1 - 1e-9)


CONTROLS = [
    None, Control(2.9, 20.0), StoppedControl(2.9, 20.0), ToeOff(0.1), HipTorque(2.9, 0.1)
]  # fmt: skip


@pytest.mark.parametrize("control", CONTROLS, ids=lambda c: scheme_of(c).name)
def test_a_start_on_the_floor_ahead_is_named_and_takes_no_time(control: object) -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        alpha, rates = rng.uniform(0.05, 0.5), rng.uniform(-2, 2, 2)
        found = stride((alpha, -alpha, *rates), control, WHEEL)  # type: ignore[arg-type]
        assert found.outcome == Outcome.ALREADY_LANDED
        assert found.duration == 0.0
        assert np.isnan(found.state).all()
        above = stride((alpha, -alpha - 0.05, *rates), control, WHEEL)  # type: ignore[arg-type]
        assert above.outcome != Outcome.ALREADY_LANDED
        assert above.duration > 0.0


def test_the_gaits_themselves_begin_on_the_floor_behind_and_are_strides() -> None:
    for name, (params, control, state, _) in PRESETS.items():
        assert stride(state, control, params).outcome == Outcome.WALKED, name


def hostile(count: int, seed: int) -> tuple[list[WalkerParams], Array, Array]:
    """Walkers, wheels for feet and the listing's physics among them; starts, a third of them
    with both feet on the floor, some nearly so; steps of the ground of all sizes, or none."""
    rng = np.random.default_rng(seed)
    kinds = []
    for i, params in enumerate(random_walkers(seed, 200)):
        wheel = {"foot_length": 0.0} if i % 4 == 0 else {}
        kinds.append(
            params.replace(physics="as_published" if i % 5 == 0 else "conserving", **wheel)
        )
    states = rng.normal(size=(count, 4)) * [0.6, 0.6, 3.0, 5.0]
    number = np.arange(count)
    states[number % 3 == 0, 1] = -states[number % 3 == 0, 0]
    off = 10.0 ** rng.uniform(-16, -3, count) * rng.choice([-1, 1], count)
    near = number % 7 == 0
    states[near, 1] = -states[near, 0] * (1.0 + off[near])
    steps = rng.choice([-1, 1], count) * 10.0 ** rng.uniform(-14, -1, count)
    return [kinds[i % 200] for i in number], states, np.where(number % 2 == 0, 0.0, steps)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_of_100_000_hostile_strides_each_takes_time_and_is_finite(scheme: str) -> None:
    count, rng = 100_000 // len(SCHEMES) + 1, np.random.default_rng(5)
    walkers, states, heights = hostile(count, 6)
    columns = {
        0: rng.uniform(0.05, 6.2, count),
        1: np.array([p.leg_mass * p.gravity * p.leg_length for p in walkers])
        * 10.0 ** rng.uniform(-3, 1, count),
    }
    numbers = [columns[k] for k in SCHEMES[scheme].columns]
    controls = np.column_stack(numbers) if numbers else None
    found = stride_batch(states, controls, walkers, step_height=heights, scheme=scheme)
    assert (found.duration >= 0.0).all()
    assert (found.duration[found.walked] > 0.0).all()
    assert found.walked.sum() > 0.01 * count
    assert (found.outcome == Outcome.ALREADY_LANDED).sum() > 100
    assert np.isfinite(found.results[found.walked]).all()
    assert np.isnan(found.state[~found.walked]).all()
    room = [
        room_ahead(row[np.newaxis, record.FINAL], walkers[i])[0]
        for i, row in zip(np.flatnonzero(found.walked), found.results[found.walked], strict=True)
    ]
    assert min(room) > together(1e-9) * (1 - 1e-6)


@pytest.mark.parametrize("exponent", [100, 150, 154, 200, 300])
def test_whoever_walks_has_finite_energies_however_huge_masses_and_impulses_are(
    exponent: int,
) -> None:
    huge, seen = 10.0**exponent, []
    for name in ("compass", "round-foot", "toe-off", "hip-torque"):
        params, control, state, _ = PRESETS[name]
        scheme = scheme_of(control)
        heavy = params.replace(
            leg_mass=params.leg_mass * huge, leg_inertia=params.leg_inertia * huge
        )
        strong = scheme.control_of((2.9, min(huge, 1e300)))
        for walker in (params, heavy):
            for chosen in (control, strong):
                for rtol in (1e-6, 1e-9):
                    seen.append(stride(state, chosen, walker, rtol=rtol))
    walked = [one for one in seen if one.outcome == Outcome.WALKED]
    for one in walked:
        numbers = (
            *one.state, one.duration, one.step_length, one.energy_in, one.positive_work,
            one.energy_lost, one.electrical_energy, one.min_clearance,
        )  # fmt: skip
        assert np.isfinite(numbers).all()
    assert walked
    assert (exponent < 150) or any(one.outcome == Outcome.NOT_FINITE for one in seen)


@pytest.mark.parametrize("name", ["camp1997", "round-foot", "motor-with-stop", "hip-torque"])
@pytest.mark.parametrize("below", [0.02, 0.05, 0.1])
def test_the_motor_does_not_start_while_the_hip_still_opens_past_the_switch(
    name: str, below: float
) -> None:
    """A hip that begins past the switch angle and opens must rise over it and fall to it first."""
    params, control, state, _ = PRESETS[name]
    assert control is not None
    opening = state._replace(swing_rate=state.stance_rate + 3.0 * math.sqrt(below) + 1.0)
    hip = opening.swing_angle + math.pi - opening.stance_angle
    scheme = scheme_of(control)
    late = scheme.control_of((hip + below, scheme.row(control)[1]))
    events = walk(opening, late, params, 1, sample_interval=0.001)
    first = events.events[0]
    assert first.phase == scheme.cycle[0].name
    assert first.t > 0.02
    assert first.q[2] == pytest.approx(hip + below, abs=1e-12)
    assert first.u[2] < 0.0
    before = events.q[events.t < first.t][:, 2]
    assert before.max() > hip + below  # it has risen over it
    assert (events.phase[events.t < first.t] == 0).all()
