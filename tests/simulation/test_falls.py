"""Falls: each by its own guard, where that guard is zero and not before or after, at every
tolerance; near the corners, too, where two of them vanish almost at once or one is only grazed."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from powered_walker_env import Control, Outcome, WalkerParams, stride, stride_batch
from powered_walker_env.model.mechanics.guards import FIRST_FALL
from powered_walker_env.model.phases import Guard
from powered_walker_env.simulation import record
from powered_walker_env.simulation.trajectory import log_stride
from powered_walker_env.simulation.walked import StrideBatch
from tests.helpers.derivation import Array
from tests.helpers.samples import random_walkers

COUNT = 6000
TOLERANCES = [1e-3, 1e-5, 1e-7, 1e-9]
STANCE, SWING, HIP, FOOT = (g for g in Guard if g >= FIRST_FALL)
GUARD_OF = {
    Outcome.FELL_FORWARD: STANCE, Outcome.FELL_BACKWARD: STANCE,
    Outcome.SWING_LEG_HORIZONTAL: SWING, Outcome.HIP_BELOW_FLOOR: HIP,
    Outcome.FOOT_ROLLED_OVER: FOOT, Outcome.FOOT_FELL_BACK: FOOT,
}  # fmt: skip
CLOSE = 0.05  # of two guards that vanish almost at once


def guards(angles: Array, params: WalkerParams) -> Array:
    """(n, 4) of poses (n, 3): stance leg, swing leg, hip, and a foot that is free."""
    phi, alpha, beta = angles.T
    height = (params.foot_radius + params.foot_length * np.cos(phi)) / params.leg_length
    turned = np.cos(phi + math.pi / 4) + math.sqrt(0.5)
    return np.column_stack([np.cos(alpha), -np.cos(beta), height + np.cos(alpha), turned])


@functools.cache
def starts() -> tuple[list[WalkerParams], Array, Array]:
    """Walkers that mostly fall, of every kind of fall."""
    rng = np.random.default_rng(1)
    kinds = list(random_walkers(2, 100))
    walkers = [kinds[i % 100] for i in range(COUNT)]
    states = rng.normal(size=(COUNT, 4)) * [0.7, 0.7, 2.0, 3.0]
    weights = np.array([p.leg_mass * p.gravity * p.leg_length for p in walkers])
    torques = weights * 10.0 ** rng.uniform(-2, 0.5, COUNT)
    return walkers, states, np.column_stack([rng.uniform(2.0, 6.0, COUNT), torques])


@functools.cache
def fallen(rtol: float) -> StrideBatch:
    walkers, states, controls = starts()
    return stride_batch(states, controls, walkers, rtol=rtol)


def final_guards(batch: StrideBatch) -> Array:
    """(N, 4) of all guards where the strides have ended."""
    walkers = starts()[0]
    final = batch.results[:, record.FINAL][:, :3]
    return np.concatenate([guards(final[i : i + 1], walkers[i]) for i in range(COUNT)])


def index(outcome: int) -> int:
    """Column of the guard that the outcome is named for."""
    return int(GUARD_OF[Outcome(outcome)]) - FIRST_FALL


def is_fall(batch: StrideBatch) -> Array:
    """(N,) those that fell, and not at once: as the stride begins, or the foot lets go (a locked
    foot may point anywhere)."""
    named = np.isin(batch.outcome, [int(outcome) for outcome in GUARD_OF])
    turned = np.isin(batch.outcome, [Outcome.FOOT_ROLLED_OVER, Outcome.FOOT_FELL_BACK])
    return np.asarray(named & (batch.duration > 0.0) & ~(turned & locked(batch)))


def locked(batch: StrideBatch) -> Array:
    """(N,) whose ankles stand at the end: locked, or just let go."""
    return np.asarray(batch.final_u[:, 1] == 0.0)


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_a_fall_ends_where_its_own_guard_is_zero_and_no_other_s_has_been_before(
    rtol: float,
) -> None:
    batch, fell = fallen(rtol), is_fall(fallen(rtol))
    values = final_guards(batch)
    for i in np.flatnonzero(fell):
        own = index(batch.outcome[i])
        assert abs(values[i, own]) < 10.0 * rtol, Outcome(batch.outcome[i])
        others = np.delete(values[i, :3], own) if own < 3 else values[i, :3]
        assert others.min() > -10.0 * rtol
    assert set(batch.outcome[fell].tolist()) == {int(outcome) for outcome in GUARD_OF}


def near_corners() -> Array:
    """Strides in which another guard is nearly zero, too, as they end."""
    batch = fallen(1e-9)
    values = final_guards(batch)
    values[locked(batch), 3] = 1.0  # a locked foot may point anywhere
    second = np.sort(values, axis=1)[:, 1]
    chosen = is_fall(batch) & (second < CLOSE)
    assert chosen.sum() > 100
    return np.flatnonzero(chosen)


def test_near_corners_outcome_and_time_do_not_depend_on_the_tolerance() -> None:
    """Where the other guard is further off than the tolerance can tell."""
    chosen, exact = near_corners(), fallen(1e-9)
    values = np.sort(final_guards(exact), axis=1)
    unit = np.array([math.sqrt(p.leg_length / p.gravity) for p in starts()[0]])
    for rtol in (1e-5, 1e-7):
        loose = fallen(rtol)
        clear = chosen[values[chosen, 1] > 300.0 * rtol]
        same = loose.outcome[clear] == exact.outcome[clear]
        assert same.mean() > 0.99  # others graze a guard on their way
        gap = np.abs(loose.duration - exact.duration)[clear][same] / unit[clear][same]
        assert np.quantile(gap, 0.99) < 100.0 * rtol
    assert len(clear) > 50


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_no_guard_has_been_down_along_a_stride_before_its_end(rtol: float) -> None:
    """By samples of the stride's own walk, dense enough to see a graze of a thousandth."""
    walkers, states, controls = starts()
    batch, seen = fallen(rtol), 0
    for i in near_corners()[:40]:
        params, control = walkers[i], Control(*controls[i].tolist())
        interval = 1e-3 * math.sqrt(params.leg_length / params.gravity)
        logged = log_stride(states[i], control, params, 0.0, rtol, interval)  # type: ignore[arg-type]
        assert logged.outcome == batch.outcome[i]
        log = logged.log[:-1]
        values = guards(log[:, 1:4], params)
        values[log[:, record.LOG_PHASE] == 0, 3] = 1.0  # a locked foot may point anywhere
        assert values.min() > -10.0 * rtol
        seen += len(log)
    assert seen > 5000


#: A walker whose stance leg may fall as its swing leg comes to the horizontal.
CORNER = WalkerParams(
    foot_length=0.0, foot_radius=0.1, com_along=0.5, leg_inertia=8.0, leg_mass=100.0
)


def at_the_corner(rate: float, rtol: float) -> Outcome:
    """How the stride ends that begins with this rate of the swing leg backwards."""
    return stride((-0.1, 0.1, 0.6, rate), None, CORNER, rtol=rtol).outcome


def corner_rate() -> float:
    """The rate at which both legs come to the horizontal at once."""
    low, high = 1.0, 20.0
    assert at_the_corner(low, 1e-12) == Outcome.FELL_BACKWARD
    for _ in range(60):
        middle = 0.5 * (low + high)
        first = at_the_corner(middle, 1e-12) == Outcome.SWING_LEG_HORIZONTAL
        low, high = (low, middle) if first else (middle, high)
    return high


def test_of_two_falls_the_first_is_named_up_to_the_corner_where_both_are_at_once() -> None:
    rate = corner_rate()
    for rtol in TOLERANCES:
        for off in (3.0 * rtol, 30.0 * rtol, 0.03):
            assert at_the_corner(rate * (1.0 + off), rtol) == Outcome.SWING_LEG_HORIZONTAL
            assert at_the_corner(rate * (1.0 - off), rtol) == Outcome.FELL_BACKWARD


#: Its stance leg balances upright, its swing leg is a pendulum: massless feet, g = L = 1.
PENDULUM = WalkerParams(
    foot_length=0.0, locked_ankle_angle=math.pi, leg_mass=0.5, leg_inertia=0.0, com_along=1.0,
    gravity=1.0,
)  # fmt: skip


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_a_graze_is_a_fall_on_one_side_of_it_and_none_on_the_other(rtol: float) -> None:
    """A pendulum comes to the horizontal with the rate √2 at its lowest point, and turns there:
    the guard falls and rises again inside a step, by what the tolerance can just tell."""
    graze = math.sqrt(2.0)
    for off in (30.0 * rtol, 0.03):
        rate = graze * (1.0 + off)
        fell = stride((0.0, 0.0, 0.0, rate), None, PENDULUM, rtol=rtol)
        assert fell.outcome == Outcome.SWING_LEG_HORIZONTAL, off
        assert -math.cos(sum(fell.final.q)) == pytest.approx(0.0, abs=10.0 * rtol)
        # t = ∫ ds/s', s'² = rate² − 2(1 − cos s), from s = π/2 − x² where it varies least.
        time, _ = quad(
            lambda x, r=rate: 2.0 * x / math.sqrt(r * r - 2.0 + 2.0 * math.sin(x * x)),
            0.0, math.sqrt(math.pi / 2), epsabs=1e-13,
        )  # fmt: skip
        assert fell.duration == pytest.approx(time, abs=100.0 * rtol / math.sqrt(off))
        passed = stride((0.0, 0.0, 0.0, graze * (1.0 - off)), None, PENDULUM, rtol=rtol)
        assert passed.outcome == Outcome.NO_LANDING, off
