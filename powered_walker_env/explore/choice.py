"""What is walking: a walker, what powers it and who decides; and how far its sliders reach.

Who may decide is offered for every walker; a trained policy or the optimum that is not shipped for
the one at hand says so, and leaves the loop open (`views`).
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

from powered_walker_env.controllers.loading import LQR_NAME, OPEN_LOOP, OPTIMAL
from powered_walker_env.controllers.shipped import shipped_learners
from powered_walker_env.envs.levels import disturbance_of
from powered_walker_env.envs.registration import ENVIRONMENTS
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.powering import (
    ANGLE,
    AnyControl,
    Scheme,
    check_walkable,
    scheme_named,
    scheme_of,
)
from powered_walker_env.model.presets import PRESETS, Preset, preset
from powered_walker_env.model.quantities import ANY, Quantity, quantities
from powered_walker_env.model.walker import WalkerParams

CONTROL_REACH, WALKER_REACH = 0.1, 0.5  # of a number's own value: how far its slider goes
STEEPEST = 2.2  # times its slope, which a passive walker's slider begins at zero
FROM_ZERO = 0.1  # of the walker's scale: the reach of a number that is zero
LEVEL = 0.02  # rad, the reach of a slope that is zero
STEPS = 400  # of a slider: Camp's motor walks in a window of 1 %
FALLBACK = 0.1  # of the walker's scale: a strength that no preset has a value for
FALLBACK_ANGLE = 2.9  # rad, of a switch no preset has a value for


def controllers_offered() -> list[str]:
    """The names of the controllers that come with the package, for one walker or another."""
    return [OPEN_LOOP, LQR_NAME, *shipped_learners(), OPTIMAL]


class Reach(NamedTuple):
    """Where a slider begins and ends, and its step."""

    low: float
    high: float
    step: float


@dataclass(frozen=True)
class Choice:
    """A walker, its control (the slider's numbers) and its controller, by name or file."""

    preset: str
    params: WalkerParams
    control: AnyControl | None
    controller: str = OPEN_LOOP

    @classmethod
    def of_preset(cls, name: str, controller: str = OPEN_LOOP) -> Choice:
        """The preset as it is.

        Raises:
            ValueError: no such preset.
        """
        known = preset(name)
        return cls(name, known.params, known.control, controller)

    @property
    def known(self) -> Preset:
        """The preset that it began with."""
        return PRESETS[self.preset]

    @property
    def env_id(self) -> str | None:
        """The registered environment of the preset."""
        return next((each for each, (name, _) in ENVIRONMENTS.items() if name == self.preset), None)

    @property
    def scheme(self) -> Scheme:
        """What powers the walker."""
        return scheme_of(self.control)

    @property
    def numbers(self) -> dict[str, Quantity]:
        """The numbers there are sliders for: the control's, then those the walker has a use for."""
        useless = () if self.scheme.moves_ankle else ("no_load_speed", "torque_limit")
        own = {} if self.control is None else numbers_of_control(self.scheme)
        walker = quantities(WalkerParams) | (quantities(Knee) if self.params.knee else {})
        return own | {name: each for name, each in walker.items() if name not in useless}

    @property
    def usual_push(self) -> float:
        """rad/s: the environment's light push for this walker."""
        return disturbance_of("light", self.preset, self.params).push

    def value(self, name: str) -> float:
        """Of one of the numbers."""
        own = name in self.scheme.numbers
        return float(getattr(self.control, name)) if own else self.params.number(name)

    def replace(self, name: str, value: float) -> Choice:
        """The same with one number changed.

        Raises:
            ValueError: out of its domain, or a walker that its scheme cannot power.
        """
        if name in self.scheme.numbers:
            control = dataclasses.replace(self.control, **{name: value})  # type: ignore[type-var]
            return dataclasses.replace(self, control=control)
        params = self.params.replace(**{name: value})
        check_walkable(params, self.control)
        return dataclasses.replace(self, params=params)

    def powered_by(self, name: str) -> Choice:
        """The same legs under another scheme, with numbers of their scale.

        Raises:
            ValueError: no such scheme, or one that cannot power these legs.
        """
        scheme = scheme_named(name)
        control = scheme.of_numbers([_likely(number, self, scheme) for number in scheme.numbers])
        check_walkable(self.params, control)
        return dataclasses.replace(self, control=control)

    def decided_by(self, controller: str) -> Choice:
        """The same under another controller."""
        return dataclasses.replace(self, controller=controller)

    def reach(self, name: str) -> Reach:
        """How far the slider of a number goes: around the preset's value, in its domain."""
        number = self.numbers[name]
        of_control = name in self.scheme.numbers
        nominal = dataclasses.replace(self, params=self.known.params)
        centre = _likely(name, nominal, self.scheme) if of_control else nominal.value(name)
        share = CONTROL_REACH if of_control else WALKER_REACH
        zero = LEVEL if name == "slope" else FROM_ZERO * scale_of(number.unit, self.known.params)
        reach = share * abs(centre) if centre else zero
        low, high = centre - reach, centre + reach
        if name == "slope" and centre > 0:
            low, high = 0.0, STEEPEST * centre
        domain, step = number.domain, (high - low) / STEPS
        if not domain.holds(low):
            low = domain.low if domain.holds(domain.low) else domain.low + step
        if not domain.holds(high):
            high = domain.high if domain.holds(domain.high) else domain.high - step
        value = self.value(name)
        return Reach(min(low, value), max(high, value), step)


def numbers_of_control(scheme: Scheme) -> dict[str, Quantity]:
    """What the numbers of a scheme are; one from outside need not have said so."""
    known = quantities(scheme.control)
    return {n: known.get(n, Quantity(n, n, "", n.replace("_", " "), ANY)) for n in scheme.numbers}


def scale_of(unit: str, params: WalkerParams) -> float:
    """What one of a unit is to a walker: made of L, g and M; 1 for a unit made of others."""
    L, g, M = params.leg_length, params.gravity, params.leg_mass
    return {
        "m": L,
        "kg": M,
        "kg m²": M * L**2,
        "m/s²": g,
        "rad/s": math.sqrt(g / L),
        "N m": M * g * L,
        "N m/rad": M * g * L,
        "N s": M * math.sqrt(g * L),
    }.get(unit, 1.0)


def _likely(name: str, choice: Choice, scheme: Scheme) -> float:
    """A value for a number of a scheme: the preset's, else to scale that of one so powered."""
    number = numbers_of_control(scheme)[name]
    own = choice.known
    others = sorted(PRESETS.values(), key=lambda each: scheme_of(each.control) is not scheme)
    for each in (own, *others):
        value = getattr(each.control, name, None)
        if value is not None:
            scale = scale_of(number.unit, choice.params) / scale_of(number.unit, each.params)
            return float(value) * (1.0 if each is own else scale)
    if scheme.columns[scheme.numbers.index(name)] == ANGLE:
        return FALLBACK_ANGLE
    return FALLBACK * scale_of(number.unit, choice.params)
