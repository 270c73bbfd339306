"""Camp's powered walker (1997), as published and with the physics of the text."""

from __future__ import annotations

import functools

from powered_walker_env.literature.values.checks import Measures, Row, digits_row, printed_rows
from powered_walker_env.literature.values.published import (
    LIMIT_CYCLES,
    LimitCycle,
    limit_cycle,
    load,
)
from powered_walker_env.model.walker import AS_PUBLISHED
from powered_walker_env.poincare import Gait, find_gait

FAMILY = "thesis"
SOURCE = "this project's independent code (Camp 1997, figure 6's walker; limit_cycles.json)"


@functools.cache
def _gait(cycle: LimitCycle) -> Gait:
    return find_gait(cycle.params, cycle.control, cycle.post_strike_state)


def _rows_of(cycle: LimitCycle) -> list[Row]:
    accuracy, gait = load("published.json")["accuracy"], _gait(cycle)
    physics = cycle.params.physics.replace("_", " ")
    name = f"Camp's powered walker, {physics}, {cycle.control.stall_torque:g} N m"
    assert gait.section_state is not None
    exact = [
        *zip(("q1, rad", "u1, rad/s", "u3, rad/s"), cycle.section_state, gait.section_state,
             strict=True),
        ("stride duration, s", cycle.period, gait.duration),
        ("step length, m", cycle.step_length, gait.step_length),
    ]  # fmt: skip
    lines = [digits_row(FAMILY, name, SOURCE, *e, accuracy["thesis_states"]) for e in exact]
    differenced: list[tuple[str, complex, complex]] = [
        ("spectral radius", cycle.spectral_radius, gait.spectral_radius)
    ]
    for number, value in enumerate(cycle.multipliers):
        if value.imag < 0.0:
            continue  # the conjugate of the one before
        ours = min(gait.multipliers.tolist(), key=lambda found: abs(found - value))
        differenced.append((f"multiplier {number + 1}", value, ours))
    within = accuracy["thesis_multipliers"]
    return lines + [digits_row(FAMILY, name, SOURCE, *d, within) for d in differenced]


def rows(long: bool) -> list[Row]:
    """The lines of this family."""
    known = [row for cycle in LIMIT_CYCLES for row in _rows_of(cycle)]
    return printed_rows(FAMILY, MEASURES, long) + known


MEASURES: Measures = {"radius_4": lambda: _gait(limit_cycle(AS_PUBLISHED, 692)).spectral_radius}
