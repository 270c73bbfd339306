"""Push-off: an impulse along the trailing leg before, with and after the heel strike.

Its momenta and works are written again with a walker that is free in the air, as four
numbers: velocity of the hip in the plane, rates of both legs; Newton and Euler for its
two rigid legs, impulses at both feet, constraints solved as a linear system.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import ArrayLike

from powered_walker_env import WalkerParams, find_gait, stride
from powered_walker_env.model.mechanics import push_off as mechanics
from powered_walker_env.model.mechanics.chain import Pose
from powered_walker_env.model.mechanics.chain import kinetic_energy as kinetic_energy_of
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.powering import LateToeOff, ToeOff, ToeOffAtStrike
from powered_walker_env.poincare.energy.contact import contact_report
from tests.helpers import derivation as d
from tests.helpers.derivation import Array
from tests.helpers.impacts import spun
from tests.helpers.published import TOE_OFF_GAITS
from tests.helpers.samples import (
    constants,
    free_chain,
    landing_state,
    pose,
    random_walkers,
    relative,
)

TIMINGS = (ToeOff, ToeOffAtStrike, LateToeOff)
GAIT = TOE_OFF_GAITS[0]


def struck_pose(y: ArrayLike, params: WalkerParams) -> Pose:
    """The pose after a heel strike without a push."""
    struck: Pose = heel_strike(pose(y), free_chain(params), constants(params))
    return struck


def push_off(y: ArrayLike, impulse: float, params: WalkerParams) -> Pose:
    """The pose after strike and push."""
    pushed: Pose = mechanics.push_off(pose(y), impulse, free_chain(params), constants(params))
    return pushed


def work_before(y: ArrayLike, impulse: float, params: WalkerParams) -> float:
    return float(mechanics.work_before(pose(y), impulse, constants(params)))


def work_with(y: ArrayLike, impulse: float, params: WalkerParams) -> float:
    new = push_off(y, impulse, params)
    return float(mechanics.work_with(pose(y), impulse, new, constants(params)))


def work_after(y: ArrayLike, impulse: float, params: WalkerParams) -> float:
    unpushed, new = struck_pose(y, params), push_off(y, impulse, params)
    return float(mechanics.work_after(pose(y), impulse, unpushed, new, constants(params)))


def kinetic_energy(at: Pose, params: WalkerParams) -> float:
    return float(kinetic_energy_of(at, free_chain(params), constants(params)))


class InTheAir(NamedTuple):
    """A walker about to strike, as two free legs hinged at the hip; v = (v1, v2, α', β')."""

    mass: Array  # (4, 4)
    rates: Array  # (4,) v just before
    old: Array  # (2, 4) velocity of the old contact point per unit of v
    new: Array  # (2, 4) the same of the new one
    push: Array  # (2,) unit vector along the trailing leg


def in_the_air(y: Array, params: WalkerParams) -> InTheAir:
    """Jacobians of points from their places: leg points turn about the moving hip.

    The feet are locked to their legs by then: the old one is retracted at once, so
    that its contact point goes with the trailing leg.
    """
    position, velocity = d.kinematics(*relative(y), params)
    hip, down = position[d.HIP], np.array([params.foot_radius, 0.0])
    old, new = position[d.CENTRE] - down, position[d.SWING_CENTRE] - down

    def of_leg(point: Array, leg: int) -> Array:
        jacobian = np.zeros((2, 4))
        jacobian[:, :2] = np.eye(2)
        jacobian[:, 2 + leg] = spun(1.0, point - hip)
        return jacobian

    mass = np.diag([0.0, 0.0, params.leg_inertia, params.leg_inertia])
    for point, leg in ((position[d.STANCE_LEG], 0), (position[d.SWING_LEG], 1)):
        jacobian = of_leg(point, leg)
        mass += params.leg_mass * jacobian.T @ jacobian
    push = np.array([math.cos(y[1]), math.sin(y[1])])
    rates = np.array([*velocity[d.HIP], y[4], y[5]])
    return InTheAir(mass, rates, of_leg(old, 0), of_leg(new, 1), push)


def struck(air: InTheAir, rates: Array, impulse: float) -> tuple[Array, float]:
    """v after an impulse at the old contact and a plastic impact at the new one, at once;
    and the work of the impulse, ½⟨J, v⁻ + v⁺⟩ at its point."""
    generalised = air.old.T @ (impulse * air.push)
    system = np.block([[air.mass, air.new.T], [air.new, np.zeros((2, 2))]])
    after = np.linalg.solve(system, [*(air.mass @ rates + generalised), 0.0, 0.0])[:4]
    return after, 0.5 * float(generalised @ (rates + after))


def kinetic(air: InTheAir, rates: Array) -> float:
    return 0.5 * float(rates @ air.mass @ rates)


def pushes(seed: int, number: int = 150) -> Iterator[tuple[WalkerParams, Array, float, InTheAir]]:
    """Landings with locked ankles, and impulses like the momentum of the walker."""
    rng = np.random.default_rng(seed)
    for params in random_walkers(seed, number):
        y = landing_state(rng, params, locked=True)
        speed = math.sqrt(params.gravity * params.leg_length)
        impulse = 2.0 * params.leg_mass * speed * rng.uniform(0.05, 1.0)
        yield params, y, impulse, in_the_air(y, params)


def size(air: InTheAir, impulse: float) -> float:
    """Kinetic energies of motion and push, for tolerances."""
    free = np.linalg.solve(air.mass, air.old.T @ (impulse * air.push))
    return kinetic(air, air.rates) + kinetic(air, free)


def test_the_walker_in_the_air_has_the_kinetic_energy_of_the_one_on_the_ground() -> None:
    for params, y, _, air in pushes(1):
        expected = kinetic_energy(pose(y), params)
        assert kinetic(air, air.rates) == pytest.approx(expected, rel=1e-13)


def test_state_after_is_that_of_impulse_and_impact_at_once() -> None:
    for params, y, impulse, air in pushes(2):
        expected, _ = struck(air, air.rates, impulse)
        new = push_off(y, impulse, params)
        rounding = 1e-15 * np.linalg.cond(air.mass) * np.abs(expected[2:]).max()
        assert [new.dbeta, new.dalpha] == pytest.approx(expected[2:], abs=max(rounding, 1e-12))


def test_the_state_after_is_the_same_for_the_three_timings() -> None:
    """Impacts and impulses are linear: the one after the other is both at once."""
    for params, _, impulse, air in pushes(3):
        scale = math.sqrt(2.0 * size(air, impulse) / params.leg_mass) / params.leg_length
        at_once, _ = struck(air, air.rates, impulse)
        for timing in TIMINGS:
            one_by_one = timed(air, impulse, timing)
            assert one_by_one == pytest.approx(at_once, abs=1e-11 * scale)


def timed(air: InTheAir, impulse: float, timing: type[ToeOff]) -> Array:
    """v after a push and an impact one after the other, or at once, as the timing says."""
    if timing is ToeOffAtStrike:
        return struck(air, air.rates, impulse)[0]
    if timing is LateToeOff:
        return struck(air, struck(air, air.rates, 0.0)[0], impulse)[0]
    pushed = air.rates + np.linalg.solve(air.mass, air.old.T @ (impulse * air.push))
    return struck(air, pushed, 0.0)[0]


@pytest.mark.parametrize("timing", TIMINGS)
@pytest.mark.parametrize("impulse", [0.0, 0.1, 0.3])
def test_a_stride_s_rates_after_the_push_are_those_of_free_legs_one_after_the_other(
    timing: type[ToeOff], impulse: float
) -> None:
    """Each timing by its own order of impulse and impact, from where the stride has ended."""
    walked = stride(GAIT.state, timing(impulse), GAIT.params, rtol=1e-13)
    y = np.concatenate([np.cumsum(walked.final.q), np.cumsum(walked.final.u)])
    after = timed(in_the_air(y, GAIT.params), impulse, timing)
    assert walked.state.stance_rate == pytest.approx(after[3], abs=1e-13)
    assert walked.state.swing_rate == pytest.approx(after[2], abs=1e-12)
    assert walked.state[:2] == pytest.approx((y[2] - math.pi, y[1]), abs=1e-15)


def test_work_before_is_the_change_of_kinetic_energy_in_the_air() -> None:
    """The old contact stands before: v⁻ = 0 there."""
    for params, y, impulse, air in pushes(4):
        pushed = air.rates + np.linalg.solve(air.mass, air.old.T @ (impulse * air.push))
        gained = kinetic(air, pushed) - kinetic(air, air.rates)
        work = work_before(y, impulse, params)
        assert work > 0
        assert work == pytest.approx(gained, abs=1e-12 * size(air, impulse))


def test_work_with_and_after_is_that_of_the_impulse_over_the_motion_of_its_point() -> None:
    for params, y, impulse, air in pushes(5):
        scale = size(air, impulse)
        _, work = struck(air, air.rates, impulse)
        assert work_with(y, impulse, params) == pytest.approx(work, abs=1e-12 * scale)
        between, _ = struck(air, air.rates, 0.0)
        again, late = struck(air, between, impulse)
        assert late == pytest.approx(kinetic(air, again) - kinetic(air, between), abs=1e-11 * scale)
        assert work_after(y, impulse, params) == pytest.approx(late, abs=1e-12 * scale)


def test_a_gait_needs_least_work_if_it_pushes_early_and_most_if_late() -> None:
    """The state after is the same, so what one push puts in beyond another is lost."""
    strides = [stride(GAIT.state, timing(0.1), GAIT.params, rtol=1e-13) for timing in TIMINGS]
    for one in strides:
        assert one.energy_in == pytest.approx(one.energy_lost, abs=1e-12)
        assert one.positive_work == one.energy_in > 0
        assert one.energy_lost > 0
    assert 1.5 * strides[0].energy_in < strides[1].energy_in
    assert 1.5 * strides[1].energy_in < strides[2].energy_in


def test_published_toe_off_gait_returns_to_its_state() -> None:
    found = stride(GAIT.state, ToeOffAtStrike(GAIT.toe_off_impulse), GAIT.params, rtol=1e-13)
    assert found.state == pytest.approx(GAIT.state, abs=1e-13)
    assert found.duration == pytest.approx(GAIT.step_duration, abs=1e-12)
    assert found.step_length == pytest.approx(GAIT.step_length, abs=1e-13)


@pytest.mark.parametrize("timing", TIMINGS)
def test_published_toe_off_gait_has_its_multipliers_whenever_it_pushes(
    timing: type[ToeOff],
) -> None:
    gait = find_gait(GAIT.params, timing(GAIT.toe_off_impulse), GAIT.state)
    for expected in GAIT.multipliers:
        nearest = min(gait.multipliers.tolist(), key=lambda z: abs(z - expected))
        assert nearest == pytest.approx(expected, abs=1e-11)


def simplest(**fields: float) -> WalkerParams:
    """Kuo's simplest walker: all mass, 1, at the hip, point feet, g = L = 1."""
    return WalkerParams(
        foot_length=0.0, locked_ankle_angle=math.pi, leg_mass=0.5, leg_inertia=0.0,
        com_along=1.0, gravity=1.0, **fields,
    )  # fmt: skip


@pytest.mark.parametrize("half_angle", [0.05, 0.2, 0.35])
@pytest.mark.parametrize("impulse", [0.0, 0.03, 0.2])
def test_simplest_walker_is_kuos(half_angle: float, impulse: float) -> None:
    """Kuo 2002: θ'⁺ = cos 2α θ'⁻ + sin 2α P; a push before does ½P².

    Before: the hip, moving across the trailing leg, gains P along it. After: it can move
    across the leading leg only, at v cos 2α, later P sin 2α more; along the trailing leg that is
    sin 2α of it, so P does P sin 2α (v cos 2α + ½P sin 2α). With: from rest, half of all that.
    """
    v, params = 0.4, simplest()
    y = (half_angle - math.pi, half_angle, math.pi - half_angle, v, v, 0.3)
    new = push_off(y, impulse, params)
    cosine, sine = math.cos(2 * half_angle), math.sin(2 * half_angle)
    assert new.dalpha == pytest.approx(cosine * v + sine * impulse, abs=1e-15)
    before = work_before(y, impulse, params)
    assert before == pytest.approx(0.5 * impulse**2, abs=1e-16)
    late = work_after(y, impulse, params)
    expected = impulse * sine * (v * cosine + 0.5 * impulse * sine)
    assert late == pytest.approx(expected, abs=1e-15)
    along = work_with(y, impulse, params)
    assert along == pytest.approx(0.5 * impulse * sine * (v * cosine + impulse * sine), abs=1e-15)


@pytest.mark.parametrize("half_angle", [0.05, 0.2, 0.35])
def test_push_before_costs_a_quarter_of_a_push_from_elsewhere_as_steps_get_short(
    half_angle: float,
) -> None:
    """Kuo 2002: to keep v = θ'⁻ over the strike takes P = v tan α before it, ½v² tan²α; power
    from elsewhere (gravity, hip) makes up for the whole loss ½v² sin²2α. Their ratio is
    sec⁴α / 4: a quarter for short steps."""
    v, params = 0.4, simplest()
    y = (half_angle - math.pi, half_angle, math.pi - half_angle, v, v, 0.3)
    impulse = v * math.tan(half_angle)
    assert push_off(y, impulse, params).dalpha == pytest.approx(v, abs=1e-15)
    unpushed = struck_pose(y, params)
    lost = kinetic_energy(pose(y), params) - kinetic_energy(unpushed, params)
    assert lost == pytest.approx(0.5 * (v * math.sin(2 * half_angle)) ** 2, abs=1e-15)
    ratio = work_before(y, impulse, params) / lost
    assert ratio == pytest.approx(0.25 / math.cos(half_angle) ** 4, rel=1e-12)


def test_pushing_with_the_strike_costs_twice_and_after_it_four_times_as_steps_get_short() -> None:
    """P = v tan α in the works above: ½v²α², v²α² and 2v²α², to the square of α."""
    v, params, half_angle = 0.4, simplest(), 1e-3
    y = (half_angle - math.pi, half_angle, math.pi - half_angle, v, v, 0.3)
    impulse = v * math.tan(half_angle)
    before = work_before(y, impulse, params)
    within = 10 * half_angle**2
    assert work_with(y, impulse, params) / before == pytest.approx(2.0, rel=within)
    assert work_after(y, impulse, params) / before == pytest.approx(4.0, rel=within)


def test_what_is_lost_is_what_the_floor_takes_at_the_new_foot() -> None:
    """Each impulse does its work over the mean velocity of its point; the new contact's is half
    of that before. Only a push at once can make the floor give instead of take, and then the
    floor would have to pull the new foot, or to drag it along where it slides."""
    gave = 0
    for params, y, impulse, air in pushes(6, 300):
        scale = size(air, impulse)
        before, after = (
            kinetic(air, air.rates),
            kinetic_energy(push_off(y, impulse, params), params),
        )
        pushed = air.rates + np.linalg.solve(air.mass, air.old.T @ (impulse * air.push))
        effective = np.linalg.inv(air.new @ np.linalg.solve(air.mass, air.new.T))
        floor = -effective @ air.new @ pushed  # impulse that stops the new foot
        landing = air.new @ air.rates
        lost = before + work_with(y, impulse, params) - after
        assert lost == pytest.approx(-0.5 * floor @ landing, abs=1e-11 * scale)
        if lost < -1e-11 * scale:
            gave += 1
            assert floor[0] < 0 or floor[1] * landing[1] > 0
        first = before + work_before(y, impulse, params) - after
        sliding = air.new @ pushed
        assert first == pytest.approx(0.5 * sliding @ effective @ sliding, abs=1e-11 * scale)
        last = before + work_after(y, impulse, params) - after
        assert last == pytest.approx(0.5 * landing @ effective @ landing, abs=1e-11 * scale)
    assert gave > 20


def test_a_strike_that_gives_energy_is_one_that_the_floor_would_have_to_pull_at() -> None:
    params, state = GAIT.params, GAIT.state
    unit = params.leg_mass * math.sqrt(params.gravity * params.leg_length)
    seen = set()
    for impulse in np.linspace(0.0, unit, 40).tolist():
        lost = {timing: stride(state, timing(impulse), params).energy_lost for timing in TIMINGS}
        assert lost[ToeOff] >= 0 and lost[LateToeOff] >= 0
        gives = lost[ToeOffAtStrike] < 0
        seen.add(gives)
        report = contact_report(params, ToeOffAtStrike(impulse), state)
        assert not gives or not report.strike_pushes
    assert seen == {True, False}
