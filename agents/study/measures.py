"""All measures of a cell, each bounded, each with its own words where it is refused."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from agents.study.cells import LIGHT, OPEN_LOOP, OPTIMAL
from agents.study.decisions import decided, decision
from agents.study.loops import basin_share, gait, sensitivity
from agents.study.subject import Subject
from agents.study.walks import episodes, passage, sweep, table_passage

Measure = Callable[[Subject], dict[str, Any]]
MEASURES: dict[str, Measure] = {
    "episodes": episodes,
    "passage": passage,
    "gait": gait,
    "sensitivity": sensitivity,
    "basin": basin_share,
    "decision": decision,
}
#: At the level of the ids only: they are the same, or the same question, at another.
AT_LIGHT: dict[str, Measure] = {"sweep": sweep, "decided": decided}
#: Of controllers that decide by the section's three numbers, or by none.
ON_SECTION: dict[str, Measure] = {"table_passage": table_passage}


def measured(subject: Subject) -> dict[str, dict[str, Any]]:
    """Every measure by its name; `refused` holds the words of one that does not apply."""
    asked = MEASURES | (AT_LIGHT if subject.cell.level == LIGHT else {})
    asked |= ON_SECTION if subject.cell.controller in (OPEN_LOOP, OPTIMAL) else {}
    found = {}
    for name, measure in asked.items():
        began = time.process_time()
        try:
            values = measure(subject)
        except (TypeError, ValueError) as error:  # GaitNotFoundError is one
            values = {"refused": " ".join(str(error).split())}
        found[name] = values | {"seconds": round(time.process_time() - began, 3)}
    return found
