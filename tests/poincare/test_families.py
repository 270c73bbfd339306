"""Families of gaits: what they refuse."""

from __future__ import annotations

import math
from typing import Any

import pytest

from powered_walker_env import PRESETS, continue_gait, find_gait

ROUND = PRESETS["round-foot"]


@pytest.mark.parametrize(
    ("bounds", "error", "message"),
    [
        (3000.0, TypeError, r"bounds must be a pair \(low, high\), got 3000\.0"),
        ((3000.0,), TypeError, r"must be a pair \(low, high\), got \(3000\.0,\)"),
        ((3000.0, 3400.0, 3500.0), TypeError, "must be a pair"),
        ("ab", TypeError, "must be a pair"),
        (("a", 3500.0), TypeError, "bounds must be a real number, got 'a'"),
        ((3000.0, None), TypeError, "bounds must be a real number, got None"),
        ((3000.0, math.inf), ValueError, "bounds must be finite, got inf"),
        ((math.nan, 3500.0), ValueError, "bounds must be finite, got nan"),
        ((3500.0, 3000.0), ValueError, "bounds must be finite and rising"),
        ((3500.0, 3600.0), ValueError, "bounds must hold the gait's stall_torque"),
        ((-5.0, 3600.0), ValueError, r"stall_torque must not be negative, got -5\.0"),
    ],
)
def test_bounds_that_are_none_are_named(bounds: Any, error: type[Exception], message: str) -> None:
    gait = find_gait(ROUND.params, ROUND.control, ROUND.state)
    with pytest.raises(error, match=message):
        continue_gait(gait, "stall_torque", bounds)


@pytest.mark.parametrize("name", ["impulse", "hip_torque", "colour", 7])
def test_a_walker_is_continued_in_its_own_numbers(name: Any) -> None:
    gait = find_gait(ROUND.params, ROUND.control, ROUND.state)
    with pytest.raises(ValueError, match=rf"parameter must .*{name}"):
        continue_gait(gait, name, (0.0, 1.0))


def test_something_else_than_a_gait_is_named() -> None:
    with pytest.raises(TypeError, match="gait must be a Gait, got None; find_gait finds one"):
        continue_gait(None, "slope", (0.0, 1.0))  # type: ignore[arg-type]
