"""The same legs powered in other ways, at one speed and, where a scheme has two numbers, one step.

A slope or an impulse is one number: it gives the speed, and the step length is what comes of it.
A motor or a hip torque has two, and gives both (`find_gait_with`). Toe-offs and hip torques have
gaits on the level near those of a slope: as the slope goes, bit by bit, the other power comes and
keeps the speed.

    gait_at("round-foot", "toe-off", speed=0.75)
    gait_at("camp1997", "motor", speed=0.21, step_length=0.285)
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from powered_walker_env.model.powering import AnyControl, Scheme, scheme_named, scheme_of
from powered_walker_env.model.presets import preset
from powered_walker_env.model.state import natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.energy.energetics import CLOSED_BY
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.search import FEW_STARTS, find_gaits
from powered_walker_env.poincare.tolerances import SAME_STATE
from powered_walker_env.poincare.wanted import find_gait_with

SLOPES = (0.002, 0.01, 0.03)  # rad, on which passive gaits are looked for
STEPS, FINEST = 8, 64  # of the way from a slope to the level: at first, and at most


def gait_at(preset_name: str, scheme: str, speed: float, step_length: float | None = None) -> Gait:
    """A gait of a preset's legs under a scheme, with this speed.

    On the level, but for passive legs, whose slope is what gives the speed. A motor's is followed
    from the preset's; of passive gaits it is the most stable found, and the others begin at the
    most stable from which the level is reached.

    Args:
        preset_name: whose legs. scheme: its name.
        speed: m/s. step_length: m, asked of schemes with two numbers; others have their own.

    Raises:
        GaitNotFoundError: none was found, with how near it came.
        ValueError: an unknown name, or a scheme that these legs cannot be powered by.
    """
    params, control, state, _ = preset(preset_name)
    powered, level = scheme_named(scheme), params.replace(slope=0.0)
    powered.check_walker(level)
    if powered.moves_ankle:
        if control is None or scheme_of(control).numbers != powered.numbers:
            raise GaitNotFoundError(
                f"no gait of {preset_name!r} under an ankle motor is known to begin with: its "
                "preset has no such motor"
            )
        assert powered.control is not None
        first = find_gait(params, powered.control(*dataclasses.astuple(control)), state)
        return _with(first, powered, speed, step_length)
    passive = passive_gaits(level, speed)
    if not passive:
        raise GaitNotFoundError(
            f"no passive gait of {preset_name!r} has {speed:.4g} m/s on any slope, where the "
            "search begins"
        )
    if powered.control is None:
        return passive[0]
    problem: GaitNotFoundError | None = None
    for gait in passive:
        try:
            return _with(_on_the_level(gait, powered, speed), powered, speed, step_length)
        except GaitNotFoundError as refused:
            problem = problem or refused
    assert problem is not None
    raise problem


@functools.lru_cache(maxsize=64)
def passive_gaits(params: WalkerParams, speed: float) -> list[Gait]:
    """Gaits of passive legs with this speed, each on the slope that gives it; most stable first."""
    found: list[Gait] = []
    for start in _passive_starts(params):
        try:
            gait = find_gait_with(start.params, None, speed=speed, by="slope", guess=start)
        except GaitNotFoundError:
            continue
        unit = natural_units(params)
        away = [np.linalg.norm((gait.states[0] - each.states[0]) / unit) for each in found]
        if gait.params.slope > 0 and all(distance > SAME_STATE for distance in away):
            found.append(gait)
    return sorted(found, key=lambda gait: gait.spectral_radius)


@functools.lru_cache(maxsize=16)
def _passive_starts(params: WalkerParams) -> list[Gait]:
    return [
        gait
        for slope in SLOPES
        for gait in find_gaits(params.replace(slope=slope), None, starts=FEW_STARTS)
    ]


def _on_the_level(passive: Gait, powered: Scheme, speed: float) -> Gait:
    """A passive gait carried over to the level at its speed.

    Raises:
        GaitNotFoundError: it is lost on the way, with where.
    """
    name, slope = powered.numbers[-1], passive.params.slope
    found = find_gait(passive.params, _control(powered, 0.0), passive.state)
    share, step = 0.0, 1.0 / STEPS
    while share < 1.0:
        there = min(share + step, 1.0)
        tilted = passive.params.replace(slope=(1.0 - there) * slope)
        try:
            found = find_gait_with(tilted, found.control, speed=speed, by=name, guess=found)
        except GaitNotFoundError as problem:
            step *= 0.5
            if step < 1.0 / FINEST:
                strength = getattr(found.control, name)
                raise GaitNotFoundError(
                    f"no gait at {speed:.4g} m/s by {name} on the level: on the way there "
                    f"the last is at slope {found.params.slope:.3g} with {name} = {strength:.4g} "
                    f"({problem})"
                ) from problem
        else:
            share = there
    return found


def _control(powered: Scheme, strength: float) -> AnyControl:
    control: AnyControl = powered.control_of((CLOSED_BY, strength))
    return control


def _with(gait: Gait, powered: Scheme, speed: float, step_length: float | None) -> Gait:
    """The gait brought to the speed, and to the step length if two numbers can."""
    numbers = powered.numbers
    if step_length is None or len(numbers) < 2:
        return find_gait_with(gait.params, gait.control, speed=speed, by=numbers[-1], guess=gait)
    return find_gait_with(
        gait.params, gait.control, speed=speed, step_length=step_length, by=numbers, guess=gait
    )
