"""What a result says of itself: one line, with the numbers that one asks for first."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from powered_walker_env import find_gait, stride, stride_batch, walk
from powered_walker_env.poincare.energy.contact import contact_of
from powered_walker_env.poincare.energy.energetics import costs
from powered_walker_env.poincare.energy.ground_force import ground_force
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.stability.lyapunov import lyapunov_exponent
from powered_walker_env.poincare.stability.robustness import gait_sensitivity
from powered_walker_env.poincare.stability.transitions import transition_times
from powered_walker_env.poincare.stability.trapping import trap_around
from powered_walker_env.simulation.derivatives import differentiate_batch
from tests.poincare.test_schemes_laboratory import NAMES, gait_of, half_range


def lyapunov_of(gait: Gait) -> Any:
    return lyapunov_exponent(
        gait.params, gait.control, gait.state, strides=6, transient=0, blocks=2
    )


def regulator_of(gait: Gait) -> Any:
    if gait.control is None:
        return find_gait(gait.params, None, gait.state)
    return find_gait(gait.params, regulate(gait, half_range(gait)), gait.state)


RESULTS: list[tuple[Callable[[Gait], Any], str]] = [
    (lambda gait: gait, "Gait("),
    (regulator_of, "Gait("),
    (lambda g: stride(g.state, g.control, g.params), "Stride("),
    (lambda g: stride_batch([g.state], g.control, g.params), r"StrideBatch(1 strides, 1 walked)"),
    (lambda g: differentiate_batch([g.state], g.control, g.params), "by stance_angle, "),
    (lambda g: StrideMap(g.params, g.control).differentiate(g.state), "walked)"),
    (lambda g: walk(g.state, g.control, g.params, 2), "Trajectory(2 strides, "),
    (lyapunov_of, "per stride"),
    (lambda g: gait_sensitivity(g), "duration by step_height"),
    (lambda g: transition_times(g, limit=2, deviations=2), "to 0.368, 0.05 of its size"),
    (trap_around, "Trap(1 ellipsoids"),
    (lambda g: ground_force(g.params, g.control, g.state), "GroundForce("),
    (contact_of, "ContactReport(1 stride, walked: "),
    (costs, "Costs("),
]


@pytest.mark.parametrize(("ask", "words"), RESULTS)
@pytest.mark.parametrize("name", NAMES)
def test_a_result_is_one_line(name: str, ask: Callable[[Gait], Any], words: str) -> None:
    said = repr(ask(gait_of(name)))
    assert words in said
    assert "\n" not in said and len(said) < 800, said
