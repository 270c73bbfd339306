"""Knees: the phases of a walker that swings its leg with a free knee (Camp 1997, section 9).

The stance knee is locked all stride. The swing knee is free from heel strike until the shank
catches up with the thigh; there it is locked, and the stride goes on as a straight-legged
walker's. So whatever powers the walker, the list of its phases follows: each phase that can come
before knee strike has a twin with the knee free, which has one way out more.

The motor of the thesis may start only after knee strike, "the walker would effectively be
straight legged during powered mode": a stride in which it would have to start earlier ends with
`Outcome.MOTOR_BEFORE_KNEE_STRIKE`.
"""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.phases import (
    Cycle,
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
    code_of,
)


def bent(name: str) -> str:
    """The name of a phase's twin with the swing knee free."""
    return f"{name}, knee free"


class Encoded(NamedTuple):
    """All phases that walkers of a cycle can be in, and as the kernel takes them."""

    phases: Cycle  # those of the cycle, then their twins with the knee free
    code: NDArray[np.float64]  # (phases, codes)


@functools.cache
def encoded(cycle: Cycle) -> Encoded:
    """A cycle with the twins of its phases.

    Raises:
        ValueError: as `phases.code_of`.
    """
    code_of(cycle, {})  # so that what is wrong with it is said of its own phases
    twins = _twins(cycle)
    names = {twin.name for twin in twins}
    own = {phase.name: bent(phase.name) for phase in cycle if bent(phase.name) in names}
    return Encoded((*cycle, *twins), code_of((*cycle, *twins), own))


def encode(cycle: Cycle) -> NDArray[np.float64]:
    """The cycle as numbers for the kernel (`phases.code_of`), with the twins of its phases."""
    return encoded(cycle).code


def bends(phase: Phase) -> bool:
    """Whether the swing knee may be free in such a phase: ankle locked, motor off."""
    return phase.joints == Joints.ANKLE_LOCKED and phase.torque != Torque.MOTOR


def _twins(cycle: Cycle) -> Cycle:
    """The twins of the phases that can be reached before knee strike, the first one's first."""
    known = {phase.name: phase for phase in cycle}
    twins: list[Phase] = []
    waiting = [phase for phase in cycle[:1] if bends(phase)]
    while waiting:
        phase = waiting.pop(0)
        exits = [_with_bent_knee(exit, known) for exit in phase.exits]
        strike = Exit(Guard.KNEE_STRIKE, Reset.KNEE_STRIKE, phase.name)
        twins.append(Phase(bent(phase.name), Joints.KNEE_FREE, phase.torque, (strike, *exits)))
        reached = {exit.to for twin in twins for exit in twin.exits}
        done = {twin.name for twin in (*twins, *waiting)}
        waiting += [p for p in cycle if bent(p.name) in reached and bent(p.name) not in done]
    return tuple(twins)


def _with_bent_knee(exit: Exit, known: dict[str, Phase]) -> Exit:
    """Where a way out leads while the knee is bent."""
    if exit.guard == Guard.LANDING:
        return Exit(exit.guard, Reset.CONTINUE, Outcome.LANDED_ON_BENT_KNEE)
    if isinstance(exit.to, Outcome):
        return exit
    following = known.get(exit.to)
    if following is not None and not bends(following):
        return Exit(exit.guard, Reset.CONTINUE, Outcome.MOTOR_BEFORE_KNEE_STRIKE)
    return exit._replace(to=bent(exit.to))
