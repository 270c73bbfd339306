"""The mechanics on eight walkers with derivatives: what Python's floats give, and differences.

The formulas are written once. In Python they take floats, here compiled lanes that carry tangents
along one direction of everything at once: pose, walker, control.
"""

from __future__ import annotations

import functools
from typing import Annotated, Any, NamedTuple

import numba
import numpy as np
import pytest

from powered_walker_env.compiled.lanes import (
    LANES,
    Table,
    dual,
    dual_state,
    eights,
    load,
    load_state,
    store,
    unit,
)
from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.mechanics import guards
from powered_walker_env.model.mechanics.actuation import Drive, ankle_torque, flow
from powered_walker_env.model.mechanics.chain import couplings, hip_bend, mass_matrix, pose_of
from powered_walker_env.model.mechanics.ground import Held
from powered_walker_env.model.mechanics.guards import Aims, value_of
from powered_walker_env.model.mechanics.heel_strike import heel_strike
from powered_walker_env.model.mechanics.locking import ankle_caught
from powered_walker_env.model.mechanics.packing import (
    BENT_CHAIN,
    CHAIN,
    CONSTANTS,
    FREE_CHAIN,
    LOCKED_CHAIN,
    OWN,
    own_numbers,
    row_tangents,
    rows_from_own,
)
from powered_walker_env.model.mechanics.push_off import push_off
from powered_walker_env.model.mechanics.tangents import acceleration_tangents, couplings_tangent
from powered_walker_env.model.phases import Guard
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING
from tests.helpers.derivation import Array
from tests.helpers.differences import central
from tests.helpers.lanes import block_of
from tests.helpers.samples import pose, random_motion, random_walker, sprung, state_of

GUARDS = len(Guard)
Numbers = Annotated[Table, 6]


class Block(NamedTuple):
    """Eight walkers, a direction for each, and what is found of them: values, then tangents."""

    y: Numbers
    dy: Numbers
    control: Annotated[Table, 4]  # switch angle, step height, strength, impulse
    dcontrol: Annotated[Table, 4]
    constants: Annotated[Table, CONSTANTS.size]
    locked: Annotated[Table, CHAIN.size]
    free: Annotated[Table, CHAIN.size]
    dconstants: Annotated[Table, CONSTANTS.size]
    dlocked: Annotated[Table, CHAIN.size]
    dfree: Annotated[Table, CHAIN.size]
    ankle_locked: Table
    guards: Annotated[Table, 2 * GUARDS]
    strike: Annotated[Table, 12]
    push: Annotated[Table, 12]
    caught: Annotated[Table, 12]
    flow: Numbers  # values alone


BLOCK = Layout(Block)
view, constants_lanes, chain_lanes = BLOCK.view, CONSTANTS.lanes, CHAIN.lanes
constants_duals, chain_duals = CONSTANTS.duals, CHAIN.duals


@numba.njit
def keep(rows, pose):
    """Write a pose's values and tangents."""
    for i, number in enumerate(
        (pose.phi, pose.alpha, pose.beta, pose.dphi, pose.dalpha, pose.dbeta)
    ):
        store(rows, i, number.value)
        store(rows, 6 + i, number.tangent)


@numba.njit(error_model="numpy")
def evaluate(block):
    """All guards and impacts of eight walkers, with tangents; their flow."""
    b = view(eights(block))
    c = constants_duals(constants_lanes(b.constants), b.dconstants)
    free = chain_duals(chain_lanes(b.free), b.dfree)
    locked = chain_duals(chain_lanes(b.locked), b.dlocked)
    y = dual_state(load_state(b.y, 0), load_state(b.dy, 0))
    at = pose_of(y[0], y[1], y[2], y[3], y[4], y[5])
    switch_angle = dual(load(b.control, 0), load(b.dcontrol, 0))
    strength = dual(load(b.control, 2), load(b.dcontrol, 2))
    impulse = dual(load(b.control, 3), load(b.dcontrol, 3))
    aims, acting = Aims(switch_angle, load(b.control, 1)), Drive(strength, 0.1 * strength)
    for guard in range(1, GUARDS):
        mask = load(b.ankle_locked, 0) > 0.0
        found = value_of(
            guard, Held(mask, load(b.ankle_locked, 0) >= 0.0), at, acting, aims, (locked, free), c
        )
        store(b.guards, guard, found.value)
        store(b.guards, GUARDS + guard, found.tangent)
    keep(b.strike, heel_strike(at, free, c))
    keep(b.push, push_off(at, impulse, free, c))
    keep(b.caught, ankle_caught(at, free, c))
    stall = load(b.control, 2)
    moved = flow(
        load_state(b.y, 0), Drive(stall, 0.1 * stall), chain_lanes(b.free),
        constants_lanes(b.constants),
    )  # fmt: skip
    for i in range(6):
        store(b.flow, i, moved[i])


class Case(NamedTuple):
    """One walker in a state, and a direction in which all of it changes."""

    y: Array
    dy: Array
    control: Array
    dcontrol: Array
    own: Array
    down: Array
    ankle_locked: bool

    def at(self, h: float) -> Case:
        """The case that lies h along the direction."""
        return self._replace(
            y=self.y + h * self.dy,
            control=self.control + h * self.dcontrol,
            own=self.own + h * self.down,
        )

    def row(self) -> Array:
        """The walker's constants and chains."""
        return rows_from_own(self.own[np.newaxis])[0]

    def parts(self) -> tuple[Any, Any, Any]:
        """Constants, locked and free chain, as formulas take them."""
        row = self.row()
        return (
            CONSTANTS.of(row[OWN:LOCKED_CHAIN]), CHAIN.of(row[LOCKED_CHAIN:FREE_CHAIN]),
            CHAIN.of(row[FREE_CHAIN:BENT_CHAIN]),
        )  # fmt: skip


def draw(rng: np.random.Generator, physics: str) -> Case:
    """Nothing is zero but the step of the ground, in half of the cases."""
    params = sprung(random_walker(rng, torque_limit=1e9, physics=physics), rng)
    weight = params.leg_mass * params.gravity * params.leg_length
    step = rng.choice([0.0, 0.05])
    momentum = params.leg_mass * np.sqrt(params.gravity * params.leg_length)
    control = np.array([2.9, step, 0.3 * weight, 0.2 * momentum])
    own = np.array(own_numbers(params))
    down = np.append(own[:-1] * rng.normal(size=OWN - 1), 0.0)
    changes = rng.normal(size=4) * control * [1.0, 0.0, 1.0, 1.0]  # a ground stays where it is
    motion = random_motion(rng)
    return Case(motion, rng.normal(size=6), control, changes, own, down, bool(rng.integers(2)))


def by_python(case: Case) -> dict[str, Array]:
    """What `evaluate` finds, of one walker, by the plain formulas."""
    c, locked, free = case.parts()
    at, (switch_angle, step, strength, impulse) = pose(case.y), case.control.tolist()
    aims, acting = Aims(switch_angle, step), Drive(strength, 0.1 * strength)
    values = [0.0]
    for guard in range(1, GUARDS):
        if guard == Guard.RELEASE:
            values.append(guards.holding_torque.py_func(at, acting, locked, free, c))
        else:
            values.append(
                value_of(guard, Held(case.ankle_locked, True), at, acting, aims, (locked, free), c)
            )
    return {
        "guards": np.array(values),
        "strike": state_of(heel_strike(at, free, c)),
        "push": state_of(push_off(at, impulse, free, c)),
        "caught": state_of(ankle_caught(at, free, c)),
        "flow": np.array(flow(case.y, acting, free, c)),
    }


def by_lanes(cases: list[Case]) -> dict[str, Array]:
    """The same of eight walkers, (8, n) values and behind them tangents."""
    block, rows = block_of(BLOCK.size)
    row = np.array([case.row() for case in cases])
    by = np.array([row_tangents(case.own[np.newaxis], case.down)[0] for case in cases])
    for name, numbers in (
        ("y", [case.y for case in cases]), ("dy", [case.dy for case in cases]),
        ("control", [case.control for case in cases]),
        ("dcontrol", [case.dcontrol for case in cases]),
        ("ankle_locked", [[float(case.ankle_locked)] for case in cases]),
        ("constants", row[:, OWN:LOCKED_CHAIN]), ("dconstants", by[:, OWN:LOCKED_CHAIN]),
        ("locked", row[:, LOCKED_CHAIN:FREE_CHAIN]), ("dlocked", by[:, LOCKED_CHAIN:FREE_CHAIN]),
        ("free", row[:, FREE_CHAIN:BENT_CHAIN]), ("dfree", by[:, FREE_CHAIN:BENT_CHAIN]),
    ):  # fmt: skip
        rows[BLOCK.slice(name)] = np.transpose(numbers)
    evaluate(block)
    return {
        name: rows[BLOCK.slice(name)].T.copy()
        for name in ("guards", "strike", "push", "caught", "flow")
    }


@functools.cache
def drawn(physics: str) -> tuple[list[Case], dict[str, Array]]:
    """Walkers, and what lanes find of them."""
    rng = np.random.default_rng(1)
    cases = [draw(rng, physics) for _ in range(5 * LANES)]
    found = [by_lanes(cases[i : i + LANES]) for i in range(0, len(cases), LANES)]
    return cases, {name: np.concatenate([part[name] for part in found]) for name in found[0]}


BOTH = [CONSERVING, AS_PUBLISHED]


@pytest.mark.parametrize("physics", BOTH)
@pytest.mark.parametrize("name", ["guards", "strike", "push", "caught", "flow"])
def test_lanes_give_the_values_of_floats(name: str, physics: str) -> None:
    cases, found = drawn(physics)
    for case, ours in zip(cases, found[name], strict=True):
        expected = by_python(case)[name]
        values = ours[: len(expected)]
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("physics", BOTH)
@pytest.mark.parametrize("name", ["guards", "strike", "push", "caught"])
def test_tangents_are_those_of_differences(name: str, physics: str) -> None:
    """Rates of guards and derivatives of resets are nothing but these."""
    cases, found = drawn(physics)
    for case, ours in zip(cases, found[name], strict=True):
        tangents = ours[len(ours) // 2 :]
        tries = [central(lambda h, c=case: by_python(c.at(h))[name], h) for h in (1e-3, 3e-4, 1e-4)]
        gap = np.min([np.abs(tangents - one).max() for one in tries])
        assert gap < 1e-7 * np.abs(tangents).max()
    assert np.count_nonzero(found[name]) > 0.5 * found[name].size


@pytest.mark.parametrize("physics", BOTH)
def test_the_chain_s_own_tangents_are_those_of_differences(physics: str) -> None:
    """The one formula whose derivatives are written by hand, in both modes."""
    for case in drawn(physics)[0]:
        row = case.row()
        by = row_tangents(case.own[np.newaxis], case.down)[0]
        c, dc = CONSTANTS.of(row[OWN:LOCKED_CHAIN]), CONSTANTS.of(by[OWN:LOCKED_CHAIN])
        for cut in (slice(LOCKED_CHAIN, FREE_CHAIN), slice(FREE_CHAIN, BENT_CHAIN)):
            chain, dchain = CHAIN.of(row[cut]), CHAIN.of(by[cut])
            alone = chain.ankle == 0.0  # the leg is no link of its own
            y = np.where([False, alone, False, False, alone, False], 0.0, case.y)
            t = np.where([False, alone, False, False, alone, False], 0.0, case.dy)
            strength, dstrength = case.control[2], case.dcontrol[2]

            def moved(
                h: float, case: Case = case, y: Array = y, t: Array = t, cut: slice = cut
            ) -> Array:
                there, row = case.at(h), case.at(h).row()
                acting = Drive(there.control[2], 0.1 * there.control[2])
                c = CONSTANTS.of(row[OWN:LOCKED_CHAIN])
                return np.array(flow(y + h * t, acting, CHAIN.of(row[cut]), c)[3:])

            def torques(h: float, case: Case = case, y: Array = y, t: Array = t,
                        cut: slice = cut) -> Array:  # fmt: skip
                there, row = case.at(h), case.at(h).row()
                c, chain, state = CONSTANTS.of(row[OWN:LOCKED_CHAIN]), CHAIN.of(row[cut]), y + h * t
                acting = Drive(there.control[2], 0.1 * there.control[2])
                ankle = ankle_torque(chain.ankle * (state[4] - state[3]), acting, c)
                bend = c.hip_stiffness * hip_bend(*state[:3], chain)
                return np.array([ankle, acting.pull - bend])

            zs = [unit(angle) for angle in y[:3]]
            at = couplings(*zs, chain, c)
            dat = couplings_tangent(*zs, at, t, chain, c, dchain, dc)
            tau, hip = central(torques, 1e-3)
            flows = flow(y, Drive(strength, 0.1 * strength), chain, c)
            found = acceleration_tangents(
                at, dat, mass_matrix(at, chain, c), y, flows, t, tau, hip, chain, c, dchain, dc
            )
            tries = [central(moved, h) for h in (1e-3, 3e-4, 1e-4)]
            gap = np.min([np.abs(np.subtract(found, one)).max() for one in tries])
            assert gap < 1e-6 * np.abs(found).max()
            assert dstrength != 0.0
