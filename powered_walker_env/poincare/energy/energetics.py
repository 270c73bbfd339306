"""What walking costs: work, net energy and current of gaits, beside what it must cost.

A cost of transport is an energy over weight times distance, dimensionless, so that a slope's
is its sine (McGeer 1990; Collins et al. 2005). On a gait all that is put in is lost:
motor or push or hip, and gravity, make up for the collisions. `least_cost.py` has what a
transition must cost at least.

    costs(find_gait(params, ToeOff(0.1), state))
    families = comparison("compass")     # one scheme beside the other

To compare schemes on the same legs, a passive walker on its slope is carried over to the
level, bit by bit: as the slope goes, the other power comes.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from powered_walker_env.model.powering import (
    SCHEMES,
    AnyControl,
    HipTorque,
    LateToeOff,
    Scheme,
    ToeOff,
    ToeOffAtStrike,
    scheme_named,
    scheme_of,
)
from powered_walker_env.model.presets import preset
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait
from powered_walker_env.poincare.energy.least_cost import ideal_push, least_cost
from powered_walker_env.poincare.families import Bounds, value_of
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError, find_gait
from powered_walker_env.poincare.maps import StrideMap

HANDED_OVER = 8  # steps from the slope to the level
CLOSED_BY = math.pi  # q3 at which a hip torque ends: the legs side by side
WEAKEST, STRONGEST = 0.1, 4.0  # of the first gait's power: the range of a family
STEP = 0.04  # of arclength, between its gaits
MOTORS = (0.5, 2.0)  # the same range of a motor, whose gaits end inside it
TIMINGS: tuple[type[ToeOff], ...] = (ToeOff, ToeOffAtStrike, LateToeOff)


class Costs(NamedTuple):
    """One gait's costs of transport (dimensionless, all but the first six)."""

    scheme: str
    parameter: str  # what changes along the family
    value: float  # its value, SI
    speed: float  # m/s
    step_length: float  # m
    spectral_radius: float
    work: float  # positive work of motor, push or hip
    gravity: float  # the slope's sine: what gravity puts in
    net: float  # all that is put in, braking taken off: the losses of the gait
    lost: float  # the same, from the collisions
    electrical: float  # drawn by an ankle motor; NaN without one
    ideal: float  # an ideal push-off at this heel strike; NaN if none would do
    least: float  # of a mass on point feet at this speed and step length (`least_cost`)

    @property
    def mechanical(self) -> float:
        """Positive work, gravity's included: the cost that figures compare."""
        return self.work + max(self.gravity, 0.0)


def costs(gait: Gait, parameter: str = "") -> Costs:
    """The costs of one gait.

    Args:
        gait: any period. parameter: names what changes along its family, if it has one.
    """
    stride_map = StrideMap(gait.params, gait.control)
    batch, powered = stride_map.strides(gait.states), stride_map.scheme
    carried = 2.0 * gait.params.leg_mass * gait.params.gravity * gait.step_length
    pushed, put_in, lost = (
        math.fsum(energy.tolist()) / carried
        for energy in (batch.positive_work, batch.energy_in, batch.energy_lost)
    )
    gravity = math.sin(gait.params.slope)
    drawn = math.fsum(batch.electrical_energy.tolist()) / carried
    strikes = batch.final
    return Costs(
        scheme=powered.name,
        parameter=parameter,
        value=value_of(gait.params, gait.control, parameter) if parameter else math.nan,
        speed=gait.speed,
        step_length=gait.step_length / gait.period,
        spectral_radius=gait.spectral_radius,
        work=pushed,
        gravity=gravity,
        net=put_in + gravity,
        lost=lost,
        electrical=drawn if _draws(powered) else math.nan,
        ideal=math.fsum(_ideal(strike, gait.params) for strike in strikes) / carried,
        least=_least(gait),
    )


def _draws(powered: Scheme) -> bool:
    return "stall_torque" in powered.numbers


def _ideal(strike: Any, params: WalkerParams) -> float:
    try:
        return ideal_push(strike, params)[1]
    except ValueError:
        return math.nan


def _least(gait: Gait) -> float:
    try:
        return least_cost(gait.speed, gait.step_length / gait.period, gait.params)
    except ValueError:  # a step longer than legs on point feet can take
        return math.nan


def family_costs(branch: Branch) -> list[Costs]:
    """The costs of all gaits of a branch, in its order."""
    return [costs(branch.gait(i), branch.parameter) for i in range(len(branch))]


@functools.cache
def start_on_the_level(passive_preset: str, name: str) -> Gait:
    """A gait on the level with the legs of a passive preset, powered by a scheme.

    Args:
        name: a toe-off's or the hip torque's.

    Raises:
        GaitNotFoundError: the gait is lost on the way from the slope.
        ValueError: a preset that has a motor, or a scheme that these legs cannot be powered by.
    """
    params, control, state, _ = preset(passive_preset)
    powered = scheme_named(name)
    if control is not None or powered.control is None or _draws(powered):
        raise ValueError(
            "scheme must be a toe-off or hip-torque on the legs of a passive preset, got "
            f"{name!r} for {passive_preset!r}, which walks with "
            f"{', '.join(schemes_for(passive_preset))}"
        )
    if powered.control is HipTorque and params.massless_foot:
        raise ValueError(
            "scheme must not be hip-torque on legs with massless feet, which it cannot push with; "
            "choose a toe-off"
        )
    found, slope = find_gait(params, None, state), params.slope
    strength = _strength(found, powered)
    for share in np.linspace(0.0, 1.0, HANDED_OVER + 1)[1:].tolist():
        tilted = params.replace(slope=(1.0 - share) * slope)
        found = find_gait(tilted, _control(powered, share * strength), found.state)
    return found


def _strength(passive: Gait, powered: Scheme) -> float:
    """The impulse or torque that puts in about what gravity does over the passive gait's step."""
    params, (alpha, s, rate, _) = passive.params, passive.state
    if powered.control is HipTorque:
        work = 2.0 * params.leg_mass * params.gravity * passive.step_length * math.sin(params.slope)
        return work / (s - alpha)
    return 2.0 * params.leg_mass * rate * params.leg_length * math.tan(0.5 * (s - alpha))


def _control(powered: Scheme, strength: float) -> AnyControl:
    assert powered.control is not None
    row = (CLOSED_BY, strength)
    control: AnyControl = powered.control_of(row)
    return control


def first_gait(name: str, preset_name: str) -> tuple[Gait, str]:
    """Where a family begins, and the parameter that it is continued in.

    Raises:
        ValueError, GaitNotFoundError: as `start_on_the_level`.
    """
    params, control, state, _ = preset(preset_name)
    powered = scheme_named(name)
    if name not in schemes_for(preset_name):
        raise ValueError(
            f"scheme must be one of {', '.join(schemes_for(preset_name))} on the legs of "
            f"{preset_name!r}, got {name!r}"
        )
    if powered.control is None:
        return find_gait(params, None, state), "slope"
    if control is None:
        return start_on_the_level(preset_name, name), powered.numbers[-1]
    same: AnyControl = powered.control(*dataclasses.astuple(control))
    return find_gait(params, same, state), powered.numbers[-1]


def schemes_for(preset_name: str) -> tuple[str, ...]:
    """Names of the schemes that a preset's legs can be powered by.

    On a powered preset's gait, those whose controls have the same numbers: both motors, or
    the three timings of a push.
    """
    params, control, _, _ = preset(preset_name)
    if control is not None:
        same = scheme_of(control).numbers
        return tuple(name for name, each in SCHEMES.items() if each.numbers == same)
    timings = ("toe-off", "toe-off-at-strike", "late-toe-off")
    return ("passive", *timings, *(() if params.massless_foot else ("hip-torque",)))


def comparison(
    preset_name: str, schemes: Sequence[str] | None = None, *, step: float = STEP
) -> dict[str, list[Costs]]:
    """The costs of a preset's legs, a family of gaits for each scheme.

    Each family is continued in its slope, impulse or torque, from a tenth to four times the
    first gait's; a motor's from half to twice. It ends earlier where the walker falls.

    Args:
        preset_name: whose legs. schemes: names; all that can power them if left out, with an
            empty family where no gait is found (light feet have little for a hip to push with).
        step: arclength between gaits.

    Raises:
        ValueError: an unknown name, or a scheme that these legs cannot be powered by.
        GaitNotFoundError: no first gait for a scheme that was asked for.
    """
    names = schemes_for(preset_name) if schemes is None else tuple(schemes)
    found: dict[str, list[Costs]] = {}
    for name in names:
        try:
            gait, parameter = first_gait(name, preset_name)
        except GaitNotFoundError:
            if schemes is not None:
                raise
            found[name] = []
            continue
        value = value_of(gait.params, gait.control, parameter)
        low, high = MOTORS if parameter == "stall_torque" else (WEAKEST, STRONGEST)
        found[name] = _rows(gait, parameter, (low * value, high * value), step)
    return found


def _rows(gait: Gait, parameter: str, bounds: Bounds, step: float) -> list[Costs]:
    return family_costs(continue_gait(gait, parameter, bounds, step=step))


def at_equal_gait(gait: Gait) -> dict[str, Costs]:
    """A toe-off gait's costs if it pushed before, with or after the heel strike.

    The state after is the same, and so the gait, its speed and its step length; the work is
    not (`model/mechanics/push_off.py`).

    Raises:
        GaitNotFoundError, ValueError: not a toe-off gait.
    """
    if not isinstance(gait.control, ToeOff):
        raise ValueError(f"gait must be one with a toe-off, got {gait.control!r}")
    impulse, found = gait.control.impulse, {}
    for timing in TIMINGS:
        same = dataclasses.replace(gait, control=timing(impulse))
        found[scheme_of(same.control).name] = costs(same, "impulse")
    return found
