"""Other authors' passive walkers: round feet, compass, Ranger, nearly the simplest walker.

Their gaits (`general` in `published.json`) were verified by an independent integrator;
each is found again from its rounded state, and everything known of it is compared.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

from powered_walker_env.literature.values.published import (
    PASSIVE_GAITS,
    Origin,
    PassiveGait,
    load,
)
from powered_walker_env.literature.values.rows import Family, Row, digits_rows, multipliers
from powered_walker_env.model.powering import ToeOffAtStrike
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import Gait, find_gait

ROUNDED = 3  # decimals of the state that the search for a published gait starts from
STATE = ("stance angle, rad", "swing angle, rad", "stance rate, rad/s", "swing rate, rad/s")


def gait_rows(
    family: str, published: PassiveGait, accuracy: dict[str, float] | None = None
) -> list[Row]:
    """State, duration, length and multipliers of a gait known in full precision.

    Args:
        family: whose lines they are.
        published: the gait.
        accuracy: how good its `states` and `multipliers` are; as all of them, if left out.
    """
    push = published.toe_off_impulse
    control = ToeOffAtStrike(push) if push else None
    gait = find_gait(published.params, control, [round(x, ROUNDED) for x in published.state])
    pairs = [
        *zip(STATE, published.state, gait.state, strict=True),
        ("step duration", published.step_duration, gait.duration),
        ("step length", published.step_length, gait.step_length),
    ]
    origin = Origin(published.kind, family, published.walker, published.source)
    accuracy = accuracy or load("published.json")["accuracy"]
    exact = accuracy["multipliers"]
    return digits_rows(origin, pairs, accuracy["states"]) + digits_rows(
        origin, multipliers(published.multipliers, gait, exact), exact
    )


def _known() -> list[Row]:
    return [row for gait in PASSIVE_GAITS for row in gait_rows(FAMILY.name, gait)]


@functools.cache
def _gait(walker: str) -> Gait:
    """Bhounsule's walkers: of the presets, and his legs on point feet (the long, stable gait)."""
    names = {"nearly": "nearly-simplest", "round": "bhounsule-round-feet"}
    if walker in names:
        params, control, state, _ = PRESETS[names[walker]]
        return find_gait(params, control, state)
    legs = PRESETS["bhounsule-round-feet"].params.replace(foot_radius=0.0)
    return find_gait(legs, None, (-0.16, 0.16, 0.23, 0.19))


def _measures(walker: str) -> dict[str, Callable[[], complex]]:
    """θ, θ' and φ' as the source counts them: θ positive leaning back."""

    def hip_rate() -> float:
        return _gait(walker).state.swing_rate - _gait(walker).state.stance_rate

    return {
        f"{walker}_angle": lambda: -_gait(walker).state.stance_angle,
        f"{walker}_rate": lambda: -_gait(walker).state.stance_rate,
        f"{walker}_hip_rate": hip_rate,
        f"{walker}_hip_rate_reversed": lambda: -hip_rate(),
    }


FAMILY = Family(
    "passive", {**_measures("nearly"), **_measures("round"), **_measures("point")}, _known
)
