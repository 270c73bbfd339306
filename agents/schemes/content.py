"""All that is said of the schemes, as one JSON: what figures and tables are made from."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from agents.schemes.cases import CASES, Case, gaits, wanted
from agents.schemes.control_map import NODES, WINDOWS, best, control_map
from agents.schemes.loops import POWERED, feedback
from agents.schemes.measures import SAMPLES, measured
from powered_walker_env.results import versions


def content(
    cases: Sequence[Case] = CASES,
    loops: Sequence[str] = POWERED,
    maps: Sequence[str] = tuple(WINDOWS),
    *,
    nodes: int = NODES,
    samples: int = SAMPLES,
    told: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Measure it all.

    Args:
        cases: legs and speeds. loops: presets whose feedback is looked at. maps: presets whose
            controls are varied. nodes: of a map, along each axis. samples: starts of a basin.
        told: is told what comes next.
    """
    began, found = time.process_time(), []
    for case in cases:
        told(case.name)
        speed, step_length = wanted(case)
        rows = [measured(case.legs, each, samples) for each in gaits(case)]
        found.append({"case": case.name, "legs": case.legs, "speed": speed,
                      "step_length": step_length, "schemes": rows})  # fmt: skip
    closed, tables = [], []
    for legs in loops:
        told(f"feedback, {legs}")
        closed.append(feedback(legs))
    for legs in maps:
        told(f"switch angle and stall torque, {legs}")
        table = control_map(legs, nodes)
        tables.append({**table, "best": best(table)})
    return {
        "versions": versions(),
        "seconds": round(time.process_time() - began, 1),
        "samples": samples,
        "cases": found,
        "feedback": closed,
        "maps": tables,
    }
