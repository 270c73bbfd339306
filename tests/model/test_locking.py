"""A joint that locks, the ankle's stop: a plastic impact, and holding until nothing is to hold.

Against Kane's equations in relative angles (`derivation.py`), where a torque at the ankle
stands in one equation alone, and strides against scipy's integrator.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, WalkerParams, stride
from powered_walker_env.model.mechanics import actuation, guards
from powered_walker_env.model.mechanics.chain import mass_matrix_at, momenta
from powered_walker_env.model.mechanics.locking import ankle_caught
from powered_walker_env.model.phases import Outcome, Torque
from powered_walker_env.model.powering import StoppedControl
from powered_walker_env.simulation import record
from powered_walker_env.simulation.trajectory import log_stride
from tests.helpers import derivation as d
from tests.helpers.derivation import TO_ABSOLUTE, Array
from tests.helpers.samples import (
    constants,
    derivative,
    free_chain,
    locked_chain,
    pose,
    random_motion,
    random_walkers,
    relative,
    state_of,
)
from tests.helpers.second_integrator import needed_torque, stopped_at, stride_with_stop

HELD, POWERED = 1, 2  # phases of a motor with a stop
# Preset, switch angle, stall torque: a motor that is too weak at first and lets go later;
# one that lets go at once and is brought back to the stop; one too weak for all of the stride.
LETS_GO = ("camp1997", 2.9068, 725.0)
COMES_BACK = ("round-foot", 3.3, 1000.0)
TOO_WEAK = ("round-foot", 2.5, 500.0)
WALKS = (LETS_GO, COMES_BACK, TOO_WEAK)
Walk = tuple[str, float, float]


def caught(y: Array, params: WalkerParams) -> Array:
    """The state after the stop."""
    return state_of(ankle_caught(pose(y), free_chain(params), constants(params)))


def kept_momenta(y: Array, params: WalkerParams) -> tuple[float, float]:
    """Those of foot and stance leg together, and of the swing leg."""
    c = constants(params)
    m = mass_matrix_at(pose(y), free_chain(params), c)
    foot, stance, swing = momenta(m, *y[3:], c)
    return foot + stance, swing


def at_the_stop(seed: int, number: int = 150) -> Iterator[tuple[WalkerParams, Array]]:
    """Walkers whose ankle comes back to its stop, u2 > 0."""
    rng = np.random.default_rng(seed)
    for params in random_walkers(seed, number):
        y = random_motion(rng)
        y[0] = y[1] - params.locked_ankle_angle
        y[3] = y[4] - abs(y[3])
        yield params, y


def test_stop_is_the_distance_of_the_ankle_from_it_positive_when_extended() -> None:
    rng = np.random.default_rng(1)
    for params in random_walkers(1, 20):
        y = random_motion(rng)
        (_, q2, _), (_, u2, _) = relative(y)
        c = constants(params)
        expected = params.locked_ankle_angle - q2
        assert guards.stop(pose(y), c) == pytest.approx(expected, abs=1e-14)
        motion = np.array([*y[3:], 0.0, 0.0, 0.0])
        rate = derivative(lambda s, c=c: guards.stop(pose(s), c), y, motion)
        assert rate == pytest.approx(-u2, abs=1e-11)


def test_after_the_stop_the_ankle_is_locked_and_nothing_has_moved() -> None:
    for params, y in at_the_stop(2):
        new = caught(y, params)
        assert tuple(new[:3]) == tuple(y[:3])
        assert new[3] == new[4]


def test_rates_after_the_stop_are_those_of_an_impulsive_torque_in_kanes_equations() -> None:
    for params, y in at_the_stop(3):
        expected = TO_ABSOLUTE @ stopped_at(*relative(y), params)
        new = caught(y, params)
        assert new[3:] == pytest.approx(expected, abs=2e-13 * (1 + np.abs(expected).max()))


def test_momenta_of_foot_with_stance_leg_and_of_the_swing_leg_are_kept() -> None:
    for params, y in at_the_stop(4):
        before, after = kept_momenta(y, params), kept_momenta(caught(y, params), params)
        scale = np.sqrt(d.energies(*relative(y), params).kinetic * params.leg_mass)
        assert after == pytest.approx(before, abs=1e-14 * scale * 2 * params.leg_length)


def test_momenta_are_the_derivatives_of_the_kinetic_energy_by_the_rates() -> None:
    for params, y in at_the_stop(5):
        gradient = d.energies(*relative(y), params).gradient[3:]  # by u1, u2, u3
        absolute = d.TO_RELATIVE.T @ gradient  # by φ', α', β'
        expected = [absolute[0] + absolute[1], absolute[2]]
        scale = 1e-14 * np.abs(absolute).max()
        assert kept_momenta(y, params) == pytest.approx(expected, abs=scale)


def test_stop_never_gives_energy_and_takes_that_of_the_velocity_jump() -> None:
    """Carnot's theorem, true of a plastic impact and of no other."""
    for params, y in at_the_stop(6):
        new = caught(y, params)
        q, before = relative(y)
        _, after = relative(new)
        kinetic = d.energies(q, before, params).kinetic
        lost = kinetic - d.energies(q, after, params).kinetic
        jump = d.energies(q, after - before, params).kinetic
        assert lost >= 0
        assert lost == pytest.approx(jump, abs=2e-14 * kinetic)


def test_an_ankle_at_rest_is_caught_without_loss() -> None:
    for params, y in at_the_stop(7, 50):
        y[3] = y[4]
        assert caught(y, params) == pytest.approx(y, rel=1e-12)


def test_holding_torque_is_what_kanes_free_walker_needs_to_keep_its_ankle() -> None:
    rng = np.random.default_rng(8)
    for params, y in at_the_stop(8):
        y[3] = y[4]
        c, unit = constants(params), params.leg_mass * params.leg_length
        stall = unit * params.gravity * rng.uniform(0, 2)
        acting = actuation.drive(Torque.MOTOR, stall)
        chains = locked_chain(params), free_chain(params)
        over_unit = guards.holding_torque.py_func(pose(y), acting, *chains, c)
        held = over_unit * guards.holding_unit(c)
        needed = needed_torque(*relative(y), params)
        mass, _ = d.powered_system(*relative(y), 0.0, params)
        rounding = 1e-15 * np.linalg.cond(mass) * (abs(needed) + stall)
        assert held == pytest.approx(needed - stall, abs=rounding)


def test_a_strong_motor_that_never_meets_its_stop_walks_as_without() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    assert isinstance(control, Control)
    plain = stride(state, control, params, rtol=1e-13)
    stopped = stride(state, StoppedControl(control.switch_angle, control.stall_torque), params,
                     rtol=1e-13)  # fmt: skip
    assert stopped == plain


def test_the_thesiss_foot_gives_way_a_little_which_its_stop_would_not_let_it() -> None:
    params, control, state, _ = PRESETS["camp1997"]
    assert isinstance(control, Control)
    plain = log_stride(state, control, params, 0.0, 1e-9, 0.001).log
    beyond = plain[:, 2] - plain[:, 1] - params.locked_ankle_angle
    assert beyond.max() > 1e-3
    with_stop = StoppedControl(control.switch_angle, control.stall_torque)
    held = log_stride(state, with_stop, params, 0.0, 1e-9, 0.001).log
    assert (held[:, 2] - held[:, 1] - params.locked_ankle_angle).max() < 1e-12


def walk(of: Walk, interval: float = 0.0) -> tuple[WalkerParams, StoppedControl, Array]:
    name, switch, stall = of
    params, _, state, _ = PRESETS[name]
    control = StoppedControl(switch, stall)
    logged = log_stride(state, control, params, 0.0, 1e-13, interval)
    assert logged.outcome is Outcome.WALKED
    return params, control, logged.log


def test_the_stop_lets_go_where_it_has_nothing_to_hold() -> None:
    params, control, log = walk(LETS_GO, 0.01)
    held = log[log[:, record.LOG_PHASE] == HELD]
    spare = [needed_torque(*relative(row[1:7]), params) - control.stall_torque for row in held]
    unit = params.leg_mass * params.gravity * params.leg_length
    assert len(spare) > 20
    assert min(spare[:-1]) > 0
    assert spare[-1] == pytest.approx(0, abs=1e-10 * unit)


@pytest.mark.parametrize("of", WALKS, ids=["lets-go", "comes-back", "too-weak"])
def test_strides_with_a_stop_are_those_of_a_second_integrator(of: Walk) -> None:
    params, control, log = walk(of)
    state = PRESETS[of[0]].state
    other = stride_with_stop(state, control, params)
    ours = stride(state, control, params, rtol=1e-13)
    assert ours.state == pytest.approx(other.state, abs=2e-11)
    assert ours.duration == pytest.approx(other.landing.t, abs=2e-11)
    phases, times = log[:, record.LOG_PHASE], log[:, 0]
    entered = [i for i in range(1, len(log)) if phases[i] != phases[i - 1]]
    released = [times[i] for i in entered if phases[i] == POWERED]
    stopped = [times[i] for i in entered if phases[i] == HELD and phases[i - 1] == POWERED]
    assert released == pytest.approx(other.released, abs=2e-11)
    assert stopped == pytest.approx(other.stopped, abs=2e-11)
    assert (len(released), len(stopped)) == {LETS_GO: (1, 0), COMES_BACK: (1, 1)}.get(of, (0, 0))


@pytest.mark.parametrize("of", WALKS, ids=["lets-go", "comes-back", "too-weak"])
def test_energy_put_in_less_what_stop_and_strike_take_is_the_change_over_the_stride(
    of: Walk,
) -> None:
    params, control, _ = walk(of)
    start = PRESETS[of[0]].state
    ours = stride(start, control, params, rtol=1e-13)
    other = stride_with_stop(start, control, params)
    assert (other.lost > 1.0) == (of is COMES_BACK)

    def energy(state: tuple[float, ...]) -> float:
        alpha, s, dalpha, ds = state
        lock = params.locked_ankle_angle
        q = [alpha - lock, lock, s + np.pi - alpha]
        of_state = d.energies(q, [dalpha, 0.0, ds - dalpha], params)
        return of_state.kinetic + of_state.potential

    change = energy(ours.state) - energy(start)
    unit = params.leg_mass * params.gravity * params.leg_length
    assert ours.energy_in - ours.energy_lost == pytest.approx(change, abs=1e-11 * unit)
    before = d.energies(other.landing.q, other.landing.u, params).kinetic
    alpha, s, dalpha, ds = other.state
    after = d.energies(
        [alpha - params.locked_ankle_angle, params.locked_ankle_angle, s + np.pi - alpha],
        [dalpha, 0.0, ds - dalpha], params,
    ).kinetic  # fmt: skip
    assert ours.energy_lost == pytest.approx(other.lost + before - after, abs=1e-9 * unit)
