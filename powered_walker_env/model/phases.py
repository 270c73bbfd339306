"""A walker's stride as a list of phases: read this first, then `powering/motor.py`.

A stride runs from just after one heel strike to just after the next (Camp 1997,
section 3). It is a list of phases; each says which joints are free, which torque
acts, and how it can end: a guard (an event), the reset applied there, and what
follows (another phase by name, or the outcome of the stride). A different walker is
another list (`powering/` has one in each module), not another simulator: the compiled
kernel (`simulation/kernel.py`) takes the encoded list as an argument. A walker with knees
begins in the same phases with its swing knee free (`knees.py`).

"Stride" means one step of one leg, as in McGeer and Camp; in biomechanics a stride
is two steps.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Joints(IntEnum):
    """Which joints move freely; the hip always does."""

    ANKLE_LOCKED = 0
    ANKLE_FREE = 1
    KNEE_FREE = 2  # of the swing leg; the ankle is locked


class Torque(IntEnum):
    """Which torque acts."""

    NONE = 0
    MOTOR = 1  # at the stance ankle, on its torque–speed line
    HIP = 2  # between the legs, constant


class Guard(IntEnum):
    """The event that ends a phase (`mechanics/guards.py`); falls are watched in every phase."""

    NEVER = 0
    SWITCH_ANGLE = 1  # the hip angle falls to the control's
    LANDING = 2  # the swing foot meets the ground ahead
    STOP = 3  # the ankle flexes back to its stop
    RELEASE = 4  # the stop has nothing to hold any more
    KNEE_STRIKE = 5  # the shank catches up with the thigh
    STANCE_LEG_DOWN = 6  # a fall, as those that follow
    SWING_LEG_DOWN = 7
    HIP_DOWN = 8
    FOOT_TURNED = 9


class Reset(IntEnum):
    """What happens to the state at the event."""

    CONTINUE = 0
    HEEL_STRIKE = 1
    PUSH_BEFORE = 2  # an impulse along the trailing leg, then the heel strike
    PUSH_WITH = 3  # both at once
    PUSH_AFTER = 4  # the heel strike, then the impulse
    STOP = 5  # the ankle is caught by its stop
    KNEE_STRIKE = 6  # the knee is caught straight


class Outcome(IntEnum):
    """How a stride ended. Only `WALKED` leaves a post-strike state."""

    WALKED = 0
    FELL_FORWARD = 1
    FELL_BACKWARD = 2
    SWING_LEG_HORIZONTAL = 3
    HIP_BELOW_FLOOR = 4
    FOOT_ROLLED_OVER = 5
    FOOT_FELL_BACK = 6
    NO_SWITCH = 7
    NO_LANDING = 8
    NOT_FINITE = 9
    STEP_LIMIT = 10
    ALREADY_LANDED = 11
    KNEE_STAYED_STRAIGHT = 12
    NO_KNEE_STRIKE = 13
    KNEE_FOLDED = 14
    LANDED_ON_BENT_KNEE = 15
    MOTOR_BEFORE_KNEE_STRIKE = 16

    @property
    def description(self) -> str:
        """One sentence: what happened, and what usually helps."""
        return _DESCRIPTIONS[self]

    @property
    def label(self) -> str:
        """The name in plain words, as tables print it."""
        return self.name.lower().replace("_", " ")


_DESCRIPTIONS = {
    Outcome.WALKED: "The swing foot landed ahead of the stance foot: a heel strike.",
    Outcome.FELL_FORWARD: "The stance leg reached the horizontal forwards; less torque or a "
    "later switch slows the walker.",
    Outcome.FELL_BACKWARD: "The stance leg fell back to the horizontal; it needs more speed, "
    "torque or slope to pass over its foot.",
    Outcome.SWING_LEG_HORIZONTAL: "The swing leg reached the horizontal before it landed.",
    Outcome.HIP_BELOW_FLOOR: "The hip came down to the floor.",
    Outcome.FOOT_ROLLED_OVER: "The stance ankle passed over the foot and down in front of it; "
    "the stall torque is too large or the switch too early.",
    Outcome.FOOT_FELL_BACK: "The stance foot fell back past its stop and under itself; the "
    "stall torque is too small to hold it.",
    Outcome.NO_SWITCH: "The foot landed before the hip reached the switch angle; raise "
    "switch_angle so that the motor starts earlier.",
    Outcome.NO_LANDING: "The swing foot did not land within 20 sqrt(L/g).",
    Outcome.NOT_FINITE: "The state stopped being finite; look at the start and the parameters.",
    Outcome.STEP_LIMIT: "The integrator used up its steps: the motion is too fast for its "
    "tolerance; loosen rtol or look at the parameters.",
    Outcome.ALREADY_LANDED: "The stride began with the swing foot on the ground ahead; start with "
    "the swing foot behind, or above the ground.",
    Outcome.KNEE_STAYED_STRAIGHT: "The shank pressed on its stop as the swing began, so that the "
    "knee had no way to bend; a lighter shank or a slower swing leg bends it.",
    Outcome.NO_KNEE_STRIKE: "The shank did not catch up with the thigh within 20 sqrt(L/g).",
    Outcome.KNEE_FOLDED: "The shank folded up against the thigh before it could catch up with it.",
    Outcome.LANDED_ON_BENT_KNEE: "The swing foot landed before the shank had caught up with the "
    "thigh; a lighter or shorter shank swings faster.",
    Outcome.MOTOR_BEFORE_KNEE_STRIKE: "The hip reached the switch angle before the shank had "
    "caught up with the thigh: this motor works on a straight-legged walker; lower "
    "switch_angle so that it starts later.",
}


class Exit(NamedTuple):
    """One way out of a phase; `to` names the next phase or is the stride's outcome."""

    guard: Guard
    reset: Reset
    to: str | Outcome


class Phase(NamedTuple):
    """One smooth piece of a stride."""

    name: str
    joints: Joints
    torque: Torque
    exits: tuple[Exit, ...]


Cycle = tuple[Phase, ...]

MAX_EXITS = 3  # exits of one phase; the encoding pads shorter lists with Guard.NEVER
#: Columns of an encoded phase: joints, torque, where a walker with knees begins instead, and
#: from here on guard, reset and target of each exit.
JOINTS, TORQUE, BENT, EXITS = range(4)


def code_of(cycle: Cycle, bent: dict[str, str]) -> NDArray[np.float64]:
    """The list as numbers for the kernel, one row a phase; not to be written to.

    A row is (joints, torque, bent, guard, reset, to, guard, reset, to, ...), where `to` is the
    index of the next phase, or −1 − outcome.

    Args:
        bent: name of the phase that a walker with knees is in instead, for those that have one.

    Raises:
        ValueError: a phase has too many exits or names a phase that is not in the list.
    """
    names = [phase.name for phase in cycle]
    if len(set(names)) != len(names):
        raise ValueError(f"the phases of a cycle need different names, got {names}")
    rows = [_encode_phase(phase, bent.get(phase.name, phase.name), names) for phase in cycle]
    code = np.array(rows, dtype=np.float64)
    code.setflags(write=False)
    return code


def _encode_phase(phase: Phase, bent: str, names: list[str]) -> tuple[int, ...]:
    if not 1 <= len(phase.exits) <= MAX_EXITS:
        raise ValueError(
            f"phase {phase.name!r} must have 1 to {MAX_EXITS} exits, got {len(phase.exits)}; "
            "raise MAX_EXITS for more"
        )
    codes = [int(phase.joints), int(phase.torque), names.index(bent)]
    for guard, reset, to in phase.exits:
        codes += [int(guard), int(reset), _encode_target(to, names)]
    padding = [int(Guard.NEVER), int(Reset.CONTINUE), -1 - int(Outcome.STEP_LIMIT)]
    return tuple(codes + padding * (MAX_EXITS - len(phase.exits)))


def _encode_target(to: str | Outcome, names: list[str]) -> int:
    if isinstance(to, Outcome):
        return -1 - int(to)
    if to not in names:
        raise ValueError(f"an exit must lead to a phase of the list {names}, got {to!r}")
    return names.index(to)
