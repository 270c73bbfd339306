"""The walkers as lists of phases: what is encoded is what is written, and it makes sense."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env.model import knees
from powered_walker_env.model.knees import encode
from powered_walker_env.model.phases import (
    EXITS,
    MAX_EXITS,
    Cycle,
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
)
from powered_walker_env.model.powering import PASSIVE_WALKER, POWERED_WALKER
from tests.helpers.derivation import Array

LANDED = Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED)
#: A walker that swings with a limp ankle between its stop and its motor, then goes back.
THREE_PHASES: Cycle = (
    Phase("a", Joints.ANKLE_LOCKED, Torque.NONE, (LANDED, Exit(Guard.NEVER, Reset.CONTINUE, "c"))),
    Phase("b", Joints.ANKLE_FREE, Torque.NONE, (Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "a"),)),
    Phase("c", Joints.ANKLE_FREE, Torque.MOTOR, (Exit(Guard.LANDING, Reset.CONTINUE, "b"),)),
)
CYCLES = {"powered": POWERED_WALKER, "passive": PASSIVE_WALKER, "three phases": THREE_PHASES}


def decode(encoded: Array, names: list[str]) -> Cycle:
    """The list back from the numbers, as their documentation describes them."""
    phases = []
    for name, (joints, torque, _, *codes) in zip(names, encoded.astype(int).tolist(), strict=True):
        triples = [codes[i : i + 3] for i in range(0, len(codes), 3)]
        exits = tuple(
            Exit(Guard(guard), Reset(reset), names[to] if to >= 0 else Outcome(-1 - to))
            for guard, reset, to in triples
        )
        used = tuple(way for way in exits if way != PADDING)
        phases.append(Phase(name, Joints(joints), Torque(torque), used))
    return tuple(phases)


PADDING = Exit(Guard.NEVER, Reset.CONTINUE, Outcome.STEP_LIMIT)


@pytest.mark.parametrize("cycle", CYCLES.values(), ids=CYCLES.keys())
def test_encoding_loses_nothing(cycle: Cycle) -> None:
    encoded = encode(cycle)
    phases = knees.encoded(cycle).phases
    assert phases[: len(cycle)] == cycle
    assert decode(encoded, [phase.name for phase in phases]) == phases
    assert encoded.shape == (len(phases), EXITS + 3 * MAX_EXITS)
    assert encoded.dtype == np.float64  # the kernel's tables hold nothing else
    np.testing.assert_array_equal(encoded, encoded.astype(int))


def test_an_encoded_cycle_is_shared_and_cannot_be_changed() -> None:
    code = encode(POWERED_WALKER)
    assert encode(POWERED_WALKER) is code
    with pytest.raises(ValueError, match="read-only"):
        code[0, 0] = 1.0


def test_powered_walker_swings_until_the_switch_angle_then_pushes_until_it_lands() -> None:
    swing, powered = POWERED_WALKER
    assert (swing.joints, swing.torque) == (Joints.ANKLE_LOCKED, Torque.NONE)
    assert swing.exits[0] == Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "powered")
    assert swing.exits[1].to == Outcome.NO_SWITCH
    assert (powered.joints, powered.torque) == (Joints.ANKLE_FREE, Torque.MOTOR)
    assert powered.exits == (LANDED,)


def test_passive_walker_swings_locked_and_unpowered_until_it_lands() -> None:
    (swing,) = PASSIVE_WALKER
    assert (swing.joints, swing.torque) == (Joints.ANKLE_LOCKED, Torque.NONE)
    assert swing.exits == (LANDED,)


@pytest.mark.parametrize("cycle", [POWERED_WALKER, PASSIVE_WALKER], ids=["powered", "passive"])
def test_every_phase_is_reached_and_only_a_heel_strike_ends_in_walked(cycle: Cycle) -> None:
    exits = [leaving for phase in cycle for leaving in phase.exits]
    targets = {leaving.to for leaving in exits}
    assert {phase.name for phase in cycle[1:]} <= targets
    for leaving in exits:
        assert (leaving.to == Outcome.WALKED) == (leaving.reset == Reset.HEEL_STRIKE)


def test_every_outcome_has_a_label_and_a_sentence() -> None:
    for outcome in Outcome:
        assert outcome.description.endswith(".")
        assert outcome.label == outcome.name.lower().replace("_", " ")
    assert len({outcome.description for outcome in Outcome}) == len(Outcome)


def phase(*exits: Exit, name: str = "only") -> Phase:
    return Phase(name, Joints.ANKLE_LOCKED, Torque.NONE, exits)


def test_unknown_target_is_named_with_the_phases_there_are() -> None:
    lost = Exit(Guard.LANDING, Reset.CONTINUE, "toe-off")
    with pytest.raises(ValueError, match=r"phase of the list \['only'\], got 'toe-off'"):
        encode((phase(lost),))


@pytest.mark.parametrize("number", [0, MAX_EXITS + 1])
def test_too_few_or_too_many_exits_are_counted(number: int) -> None:
    with pytest.raises(ValueError, match=f"'only' must have 1 to {MAX_EXITS} exits, got {number}"):
        encode((phase(*[LANDED] * number),))


def test_two_phases_of_one_name_are_rejected() -> None:
    with pytest.raises(ValueError, match=r"different names, got \['twin', 'twin'\]"):
        encode((phase(LANDED, name="twin"), phase(LANDED, name="twin")))
