"""Other authors' passive walkers: round feet, compass, Ranger, nearly the simplest walker.

Their gaits (`general` in `published.json`) were verified by an independent integrator;
each is found again from its rounded state, and everything known of it is compared.
"""

from __future__ import annotations

import functools
from collections.abc import Callable

from powered_walker_env.literature.values.checks import Measures, Row, digits_row, printed_rows
from powered_walker_env.literature.values.published import PASSIVE_GAITS, PassiveGait, load
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import Gait, find_gait

ROUNDED = 3  # decimals of the state that the search for a published gait starts from
FAMILY = "passive"


def rows(long: bool) -> list[Row]:
    """The lines of this family."""
    found = [row for published in PASSIVE_GAITS for row in _rows_of(published)]
    return found + printed_rows(FAMILY, MEASURES, long)


def _rows_of(published: PassiveGait) -> list[Row]:
    accuracy = load("published.json")["accuracy"]
    gait = find_gait(published.params, None, [round(x, ROUNDED) for x in published.state])
    names = ("stance angle, rad", "swing angle, rad", "stance rate, rad/s", "swing rate, rad/s")
    pairs = [
        *zip(names, published.state, gait.state, strict=True),
        ("step duration", published.step_duration, gait.duration),
        ("step length", published.step_length, gait.step_length),
    ]
    source = (FAMILY, published.walker, published.source)
    lines = [digits_row(*source, *pair, accuracy["states"]) for pair in pairs]
    for number, value in enumerate(published.multipliers):
        if value.imag < 0.0 or abs(value) < accuracy["multipliers"]:
            continue  # the conjugate of the one before, or zero to rounding
        ours = min(gait.multipliers.tolist(), key=lambda found: abs(found - value))
        quantity = f"multiplier {number + 1}"
        lines.append(digits_row(*source, quantity, value, ours, accuracy["multipliers"]))
    return lines


@functools.cache
def _gait(walker: str) -> Gait:
    """Bhounsule's walkers: of the presets, and his legs on point feet (the long, stable gait)."""
    names = {"nearly": "nearly-simplest", "round": "bhounsule-round-feet"}
    if walker in names:
        params, control, state, _ = PRESETS[names[walker]]
        return find_gait(params, control, state)
    legs: WalkerParams = PRESETS["bhounsule-round-feet"].params.replace(foot_radius=0.0)
    return find_gait(legs, None, PostStrikeState(-0.16, 0.16, 0.23, 0.19))


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


MEASURES: Measures = {**_measures("nearly"), **_measures("round"), **_measures("point")}
