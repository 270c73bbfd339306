"""The rows of the published study, as the pages of the questions ask for them."""

from __future__ import annotations

import json
from pathlib import Path

from agents.study.decisions import flops as flops_of
from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import Optimal
from powered_walker_env.controllers.evaluation import task_of

WALKERS = {
    "PoweredWalker-v0": "the thesis's", "PoweredWalkerRoundFoot-v0": "round feet",
    "PoweredWalkerAsPublished-v1": "as published", "PoweredWalkerKneed-v0": "with knees",
}  # fmt: skip
THESIS, ROUND, PUBLISHED, KNEED = WALKERS
LEVELS = ("light", "rough")

assert set(WALKERS) == set(ENVIRONMENTS)


class Study:
    """The rows of `study.json`, by environment, level and controller."""

    def __init__(self, path: Path) -> None:
        content = json.loads(path.read_text(encoding="utf-8"))
        self.rows = {(row["env_id"], row["level"], row["controller"]): row
                     for row in content["rows"] if row["runs"]}  # fmt: skip

    def value(self, env_id: str, level: str, controller: str, name: str) -> float | None:
        """Strides, score or return (interquartile mean over seeds), or a median."""
        row = self.rows.get((env_id, level, controller))
        if row is None:
            return None
        found = row.get(name, row["medians"].get(name))
        return found[0] if isinstance(found, list) else found

    def text(self, env_id: str, level: str, controller: str, name: str, form: str = ".1f") -> str:
        """The same as a table has it; a dash where there is none."""
        found = self.value(env_id, level, controller, name)
        return "–" if found is None else format(found, form)

    def lasts(self, env_id: str, level: str, controller: str) -> tuple[float | None, bool]:
        """Mean first passage time, and whether it is known: without falls it is a lower bound."""
        found = self.value(env_id, level, controller, "mean_first_passage")
        if found is not None:
            return found, True
        return self.value(env_id, level, controller, "at_least"), False


def points(study: Study, env_id: str) -> list[tuple[float, float, str]]:
    """Operations a decision, mean first passage time and name of who has both; cheap ones first."""
    found = []
    for each, level, name in study.rows:
        if (each, level) == (env_id, "light"):
            flops = operations(study, env_id, name)
            time, _ = study.lasts(each, level, name)
            if flops is not None and time is not None:
                found.append((flops, time, name))
    return sorted(found, key=lambda point: (point[0], -point[1]))


def operations(study: Study, env_id: str, controller: str) -> float | None:
    """Of a decision; of the optimum, whose policy may look ahead, by its formula here and now."""
    if controller == "optimal":
        return flops_of(Optimal(task_of(env_id)))
    return study.value(env_id, "light", controller, "flops")


def duration(study: Study, env_id: str, level: str, controller: str) -> str:
    """A mean first passage time in words."""
    found, known = study.lasts(env_id, level, controller)
    return "–" if found is None else f"{'' if known else '> '}{rounded(found)}"


def rounded(value: float) -> str:
    """Three digits, thousands set off."""
    return f"{float(f'{value:.3g}'):,.0f}" if value >= 100.0 else f"{value:.3g}"
