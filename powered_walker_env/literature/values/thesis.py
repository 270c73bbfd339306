"""Camp's powered walker (1997), as published and with the physics of the text."""

from __future__ import annotations

import functools

from powered_walker_env.literature.values.published import (
    LIMIT_CYCLES,
    Kind,
    LimitCycle,
    Origin,
    limit_cycle,
    load,
)
from powered_walker_env.literature.values.rows import Family, Row, digits_rows, multipliers
from powered_walker_env.model.walker import AS_PUBLISHED
from powered_walker_env.poincare import Gait, find_gait

SOURCE = "this project's independent code (Camp 1997, figure 6's walker; limit_cycles.json)"
SECTION = ("q1, rad", "u1, rad/s", "u3, rad/s")


@functools.cache
def _gait(cycle: LimitCycle) -> Gait:
    return find_gait(cycle.params, cycle.control, cycle.post_strike_state)


def _rows_of(cycle: LimitCycle) -> list[Row]:
    gait, physics = _gait(cycle), cycle.params.physics.replace("_", " ")
    name = f"Camp's powered walker, {physics}, {cycle.control.stall_torque:g} N m"
    origin = Origin(Kind.OWN, FAMILY.name, name, SOURCE)
    assert gait.section_state is not None
    exact = [
        *zip(SECTION, cycle.section_state, gait.section_state, strict=True),
        ("stride duration, s", cycle.period, gait.duration),
        ("step length, m", cycle.step_length, gait.step_length),
    ]
    differenced = [
        ("spectral radius", cycle.spectral_radius, gait.spectral_radius),
        *multipliers(cycle.multipliers, gait),
    ]
    accuracy = load("published.json")["accuracy"]
    return digits_rows(origin, exact, accuracy["thesis_states"]) + digits_rows(
        origin, differenced, accuracy["thesis_multipliers"]
    )


def _known() -> list[Row]:
    return [row for cycle in LIMIT_CYCLES for row in _rows_of(cycle)]


FAMILY = Family(
    "thesis",
    {"radius_4": lambda: _gait(limit_cycle(AS_PUBLISHED, 692)).spectral_radius},
    _known,
)
