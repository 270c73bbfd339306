"""The compass gait of Goswami, Thuilot and Espiau (1996): legs of point masses on point feet."""

from __future__ import annotations

import functools
import math

from powered_walker_env.literature.values.cascades import cascade, last_ratio, limit
from powered_walker_env.literature.values.published import Kind, Origin, load
from powered_walker_env.literature.values.rows import Family, Measures, Row, digits_rows
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.poincare import Gait, find_gait

BOUNDS = (0.03, 0.095)  # slopes, rad: from below 3 degrees to beyond the cascade


@functools.cache
def _gait() -> Gait:
    params, control, state, _ = PRESETS["compass"]
    return find_gait(params, control, state)


def _half_angle(gait: Gait) -> float:
    """Half the angle between the legs at heel strike, degrees."""
    return math.degrees(gait.state.swing_angle - gait.state.stance_angle) / 2.0


def _doubling(number: int) -> float:
    """The slope of a doubling, degrees, counted from 1."""
    return math.degrees(cascade(_gait(), "slope", BOUNDS, max(2, number)).values[number - 1])


def _known() -> list[Row]:
    first = load("published.json")["compass_cascade_degrees"]["first"]["deg"]
    accuracy = math.degrees(load("published.json")["accuracy"]["states"])
    origin = Origin(Kind.OWN, "compass", "compass gait, in its slope", Kind.OWN)
    return digits_rows(origin, [("first doubling, degrees", first, _doubling(1))], accuracy)


MEASURES: Measures = {
    "duration": lambda: _gait().duration,
    "half_angle": lambda: _half_angle(_gait()),
    # The sources' cycle is two steps: the multipliers of one step squared.
    "two_step_pair": lambda: abs(_gait().multipliers[0]) ** 2,
    "two_step_real": lambda: abs(_gait().multipliers[2]) ** 2,
    "doubling_1": lambda: _doubling(1),
    "doubling_2": lambda: _doubling(2),
    "doubling_3": lambda: _doubling(3),
    "chaos": lambda: math.degrees(limit(_gait(), "slope", BOUNDS)),
    "feigenbaum": lambda: last_ratio(_gait(), "slope", BOUNDS),
}

FAMILY = Family("compass", MEASURES, _known)
