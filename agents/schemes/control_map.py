"""What a motor's two numbers do: gaits over switch angle and stall torque, followed from one."""

from __future__ import annotations

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from powered_walker_env import PRESETS, Control, Gait, find_gait
from powered_walker_env.controllers.following import gait_near
from powered_walker_env.poincare import costs

NODES = 31  # along each axis


class Window(NamedTuple):
    """Where the two numbers are varied; the preset's own lie inside."""

    switch: tuple[float, float]  # rad
    torque: tuple[float, float]  # N m


#: Around the stable gaits of each walker.
WINDOWS = {
    "camp1997": Window((2.75, 3.10), (726.0, 735.0)),
    "round-foot": Window((2.62, 2.78), (3050.0, 3700.0)),
    "kneed": Window((2.40, 2.55), (170.0, 300.0)),
}


def control_map(legs: str, nodes: int = NODES) -> dict[str, Any]:
    """Spectral radius, costs, speed and step length at every node that a gait was followed to.

    Returns:
        The axes, and (nodes, nodes) tables, switch angle by stall torque; None: no gait.
    """
    params, control, state, _ = PRESETS[legs]
    window = WINDOWS[legs]
    switch, torque = (np.linspace(*bounds, nodes) for bounds in window)
    assert isinstance(control, Control)

    def follow(node: tuple[int, int], near: Gait) -> Gait | None:
        return gait_near(params, Control(float(switch[node[0]]), float(torque[node[1]])), near)

    own = find_gait(params, control, state)
    first = (_nearest(switch, control.switch_angle), _nearest(torque, control.stall_torque))
    gaits = _spread(first, follow(first, own), follow, nodes)
    names = ("spectral_radius", "mechanical", "electrical", "speed", "step_length")
    tables: dict[str, Any] = {name: [[None] * nodes for _ in range(nodes)] for name in names}
    for (i, j), gait in gaits.items():
        spent = costs(gait)
        for name in names:
            tables[name][i][j] = float(getattr(spent, name))
    return {
        "legs": legs,
        "switch_angle": switch.tolist(),
        "stall_torque": torque.tolist(),
        "own": [control.switch_angle, control.stall_torque],
        **tables,
    }


def _nearest(axis: np.ndarray[Any, Any], value: float) -> int:
    return int(np.argmin(abs(axis - value)))


def _spread(
    first: tuple[int, int], gait: Gait | None, follow: Any, nodes: int
) -> dict[tuple[int, int], Gait]:
    """Gaits at the nodes, each followed from a neighbour's, from the first on."""
    if gait is None:
        raise ValueError("the window must hold the preset's own control, where a gait is known")
    found, queue = {first: gait}, deque([first])
    while queue:
        here = queue.popleft()
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            there = (here[0] + step[0], here[1] + step[1])
            if there in found or not all(0 <= each < nodes for each in there):
                continue
            near = follow(there, found[here])
            if near is not None:
                found[there] = near
                queue.append(there)
    return found


def best(table: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Of the stable nodes: where a small deviation dies fastest, and where walking is cheapest."""
    radius = np.array(table["spectral_radius"], np.float64)
    stable = np.where(radius < 1.0, 0.0, np.nan)
    found = {}
    for name in ("spectral_radius", "mechanical", "electrical"):
        values = np.array(table[name], np.float64) + stable
        i, j = np.unravel_index(int(np.nanargmin(values)), values.shape)
        found[name] = {
            "switch_angle": table["switch_angle"][i],
            "stall_torque": table["stall_torque"][j],
            **{each: table[each][i][j] for each in
               ("spectral_radius", "mechanical", "electrical", "speed", "step_length")},
        }  # fmt: skip
    return found
