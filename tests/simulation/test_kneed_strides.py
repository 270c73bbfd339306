"""Strides of walkers with knees: a published gait, a second integrator, derivatives, outcomes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, Outcome, PostStrikeState, find_gait, stride
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.knees import encoded
from powered_walker_env.model.phases import Joints
from powered_walker_env.model.powering import (
    AnyControl,
    HipTorque,
    LateToeOff,
    StoppedControl,
    ToeOff,
    ToeOffAtStrike,
    scheme_of,
)
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.simulation.strides import stride_batch
from powered_walker_env.simulation.trajectory import walk
from tests.helpers import kneed
from tests.helpers.derivation import Array
from tests.simulation.test_sensitivity import agree

CHEN, KNEED = PRESETS["chen2007"], PRESETS["kneed"]
KNEES = [name for name, preset in PRESETS.items() if preset.params.knee is not None]
CHEN_STATE = (-0.2385854602633963, 0.2385854602633963, 1.1095873312381046, 0.05714810637862491)
#: The reference's own accuracy; the two integrators here agree a thousand times better.
REFERENCE = 2e-10

#: A state at which the shank is about to leave its stop, and where to it does.
STIFF = np.array([-0.09034437372160552, -0.09532463086967354, 1.641073281163795, -1.46493507])
AWAY = np.array([0.020172516893832, 0.4109581537045, -0.1637283091455, 0.7597830425646])

# Schemes: each powers the legs of `kneed` from near its gait.
WEIGHT = KNEED.params.leg_mass * KNEED.params.gravity
SCHEMES: dict[str, AnyControl | None] = {
    "motor": KNEED.control,
    "motor-with-stop": StoppedControl(*(getattr(KNEED.control, n) for n in (
        "switch_angle", "stall_torque"))),
    "toe-off": ToeOff(0.02 * WEIGHT),
    "toe-off-at-strike": ToeOffAtStrike(0.02 * WEIGHT),
    "late-toe-off": LateToeOff(0.02 * WEIGHT),
    "hip-torque": HipTorque(3.3, 0.01 * WEIGHT),
    "hip-torque, late": HipTorque(2.6, 0.01 * WEIGHT),
    "passive": None,
}  # fmt: skip


def near(preset: Any, seed: int, count: int, size: float = 0.02) -> Array:
    """States around a gait."""
    rng = np.random.default_rng(seed)
    return np.array(preset.state) + size * rng.normal(size=(count, 4)) * [0.5, 0.5, 1.0, 1.0]


def test_the_gait_of_chen_returns_to_itself() -> None:
    walked = stride(CHEN_STATE, None, CHEN.params, rtol=1e-12)
    assert walked.state == pytest.approx(CHEN_STATE, abs=REFERENCE)
    assert walked.duration == pytest.approx(0.5643281659071575, abs=REFERENCE)
    struck, landed = walk(CHEN_STATE, None, CHEN.params, 1, rtol=1e-12).events
    assert (struck.phase, landed.phase) == ("swing, knee free", "swing")
    assert struck.t == pytest.approx(0.34861200046466345, abs=REFERENCE)
    gait = find_gait(CHEN.params, None, CHEN_STATE)
    assert gait.state == pytest.approx(CHEN_STATE, abs=REFERENCE)
    expected = [0.3525737382630107 + 0.5522114563289233j, 0.14382267409821842]
    assert gait.multipliers[[0, 2]] == pytest.approx(expected, abs=1e-7)


def test_one_stride_from_chen_s_printed_state() -> None:
    printed = (-0.1877 - 0.0504, 0.2884 - 0.0504, 1.1014, 0.0399)
    expected = (-0.23670282, 0.23670282, 1.10412671, 0.05764204)
    assert stride(printed, None, CHEN.params).state == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("name", KNEES)
def test_strides_are_those_of_the_second_integrator(name: str) -> None:
    """At walkers and states around a gait, of any shape: nothing is zero."""
    params, control, _, _ = PRESETS[name]
    assert control is None or type(control) is Control
    rng, compared = np.random.default_rng(5), 0
    size = params.leg_length
    for state in near(PRESETS[name], 5, 8, 0.01):
        knee = params.knee
        assert knee is not None
        general = params.replace(
            slope=params.slope + 0.002 * rng.normal(),
            com_across=params.com_across + 0.003 * size * rng.normal(),
            shank_com_across=knee.shank_com_across + 0.003 * size * rng.normal(),
            shank_inertia=knee.shank_inertia * 1.02 + 1e-4 * params.leg_mass * size**2,
            leg_inertia=params.leg_inertia * 1.05,
            shank_mass=knee.shank_mass * 0.98,
            hip_stiffness=0.003 * params.leg_mass * params.gravity * size,
        )
        ours = stride(state, control, general, rtol=1e-13)
        if ours.outcome != Outcome.WALKED:
            continue
        theirs = kneed.stride_with_knees(PostStrikeState(*state), control, general)
        assert ours.state == pytest.approx(theirs.state, abs=1e-11)
        assert ours.duration == pytest.approx(theirs.landing.t, abs=1e-11)
        struck = walk(state, control, general, 1, rtol=1e-13).events[0].t
        assert struck == pytest.approx(theirs.struck, abs=1e-11)
        compared += 1
    assert compared >= 5


@pytest.mark.parametrize("name", SCHEMES)
def test_derivatives_with_knees_are_exact_in_every_direction(name: str) -> None:
    params, control = KNEED.params, SCHEMES[name]
    general = params.replace(
        slope=0.02 if control is None or "hip" in name or "toe" in name else 1e-3,
        com_across=params.com_across + 0.002, hip_stiffness=1.0,
    )  # fmt: skip
    agree(general, np.add(KNEED.state, [0.002, -0.002, 0.003, 0.003]), control)


def test_derivatives_of_chen_s_gait_are_exact_in_every_direction() -> None:
    general = CHEN.params.replace(leg_inertia=1.1 * CHEN.params.leg_inertia, shank_inertia=1e-3)
    agree(general, np.array(CHEN_STATE), None)


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_s_phases_come_in_their_order(name: str) -> None:
    control = SCHEMES[name]
    params = KNEED.params.replace(slope=0.0 if "motor" in name else 0.02)
    walked = walk(KNEED.state, control, params, 1)
    assert walked.outcome == Outcome.WALKED
    names = [event.phase for event in walked.events]
    free = [
        p.name for p in encoded(scheme_of(control).cycle).phases if p.joints == Joints.KNEE_FREE
    ]
    assert names[0] == free[0]
    expected = ["pulled, knee free", "coasting, knee free", "coasting"]
    if name == "hip-torque":
        assert names == expected
    flexion = walked.knee[:, 0]
    bent = np.isin(walked.phase, [
        i for i, p in enumerate(encoded(scheme_of(control).cycle).phases)
        if p.joints == Joints.KNEE_FREE
    ])  # fmt: skip
    assert (flexion[bent] >= -1e-9).all()
    assert flexion.max() > 0.1
    np.testing.assert_array_equal(walked.knee[~bent], 0.0)


@pytest.mark.parametrize("name", KNEES)
def test_energy_is_kept_in_each_phase_without_torque(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    walked = walk(state, control, params, 1, rtol=1e-13, sample_interval=0.01)
    lock = params.locked_ankle_angle
    energies = [
        kneed.energy(np.array([q[0], q[2], k[0]]), np.array([u[0], u[2], k[1]]), params)
        for q, u, k in zip(walked.q, walked.u, walked.knee, strict=True)
    ]
    scale = params.leg_mass * params.gravity * params.leg_length
    for phase in np.unique(walked.phase):
        rows = (walked.phase == phase) & ~walked.motor_on
        assert np.allclose(walked.q[rows, 1], lock, atol=1e-12)
        if rows.any():
            assert np.ptp(np.array(energies)[rows]) < 1e-11 * scale
    lost = stride(state, control, params).energy_lost
    assert lost > 0.0


def test_walkers_with_and_without_knees_share_a_batch_bit_for_bit() -> None:
    bare = CHEN.params.replace(knee=None)
    walkers = [CHEN.params, bare] * 10
    states = near(CHEN, 6, 20)
    together = stride_batch(states, None, walkers)
    for i, (state, params) in enumerate(zip(states, walkers, strict=True)):
        alone = stride(state, None, params)
        np.testing.assert_array_equal(together.state[i], alone.state)
        assert together.outcome[i] == alone.outcome
    assert set(together.outcome[::2]) == {int(Outcome.WALKED)}


# What can go wrong.


def outcome(state: Any, control: AnyControl | None, params: WalkerParams) -> Outcome:
    return stride(state, control, params).outcome


def test_a_shank_that_presses_on_its_stop_is_named() -> None:
    """A swing leg that is thrown back: its shank wants to go on forward."""
    assert outcome(STIFF - 0.01 * AWAY, None, CHEN.params) == Outcome.KNEE_STAYED_STRAIGHT


def test_a_motor_that_would_start_before_knee_strike_is_named() -> None:
    early = Control(3.4, KNEED.control.stall_torque)  # type: ignore[union-attr]
    assert outcome(KNEED.state, early, KNEED.params) == Outcome.MOTOR_BEFORE_KNEE_STRIKE
    late = Control(2.0, KNEED.control.stall_torque)  # type: ignore[union-attr]
    assert outcome(KNEED.state, late, KNEED.params) == Outcome.NO_SWITCH


def test_a_landing_on_a_bent_knee_is_named() -> None:
    """A heavy, long pendulum for a shank: it comes too late."""
    slow = CHEN.params.replace(shank_inertia=0.012, leg_inertia=CHEN.params.leg_inertia + 0.02)
    assert outcome(CHEN_STATE, None, slow) == Outcome.LANDED_ON_BENT_KNEE


def test_a_knee_that_never_strikes_is_named() -> None:
    found = {outcome(state, None, CHEN.params) for state in near(CHEN, 8, 3000, 2.0)}
    assert {Outcome.KNEE_FOLDED, Outcome.KNEE_STAYED_STRAIGHT, Outcome.LANDED_ON_BENT_KNEE} <= found
    assert Outcome.STEP_LIMIT not in found
    assert Outcome.NOT_FINITE not in found


def test_a_shank_that_never_catches_up_runs_out_of_time() -> None:
    """Feet rounder than the legs are long keep the walker up, and a stiff spring keeps its legs
    swinging, so that the shank is always late."""
    rocking = CHEN.params.replace(slope=0.0, foot_radius=2.0, hip_stiffness=50.0)
    start = (-0.18851287375291037, -0.017126462616802198, 0.1983898983211469, 0.18267238673306907)
    found = stride(start, None, rocking)
    assert found.outcome == Outcome.NO_KNEE_STRIKE
    assert found.duration == pytest.approx(20.0 / math.sqrt(9.81), rel=1e-9)
    assert found.final.knee[0] > 0.0


def test_a_free_knee_of_no_time_is_a_straight_leg() -> None:
    """Near states where the shank only just leaves its stop it comes back at once: the strides
    become the straight walker's with the fourth power of the time that the knee is free, since
    thigh and shank part by its third, and the impact's loss goes with the square of the rate."""
    bare = CHEN.params.replace(knee=None)
    times, gaps = [], []
    for size in (0.1, 0.03, 0.01):
        state = STIFF + size * AWAY
        straight = stride(state, None, bare, rtol=1e-13).state
        gaps.append(
            np.abs(np.subtract(stride(state, None, CHEN.params, rtol=1e-13).state, straight))
        )
        times.append(walk(state, None, CHEN.params, 1).events[0].t)
    orders = np.diff(np.log(np.max(gaps, axis=1))) / np.diff(np.log(times))
    assert times[-1] < 0.004
    assert np.max(gaps[-1]) < 2e-9
    assert orders == pytest.approx([4.0, 4.0], abs=0.3)


def test_knee_of_a_heavy_shank_is_refused_before_anything_is_walked() -> None:
    with pytest.raises(ValueError, match="shank_mass must be less than leg_mass"):
        CHEN.params.replace(knee=Knee(shank_length=0.5, shank_mass=5.0, shank_com_along=0.3))


def test_scuffing_at_knee_strike_is_reported_and_no_fall() -> None:
    """The foot may be under the floor when the knee strikes: the clearance says so."""
    found = stride_batch(near(CHEN, 9, 2000, 0.3), None, CHEN.params)
    assert (found.walked & (found.min_clearance < -1e-3)).any()
    assert math.isfinite(float(found.min_clearance[found.walked].min()))
