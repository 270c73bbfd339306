"""What the published control study says: all of it, and the baselines of an environment."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tabulated import table

from agents.study.budgets import FULL
from agents.study.cells import LEARNERS, LEVELS, OPTIMAL, Cell
from agents.study.commands import command_of
from powered_walker_env.controllers import Estimate, Optimal, shipped_learners
from powered_walker_env.controllers.evaluation import task_of

STUDY = "study.json"
HEADER = ("controller", "strides of 100", "return", "score")
MISSING = (
    "The control study is not published with this version: `python -m agents.study --publish` "
    "makes this table ({doc}`../benchmark`).\n"
)


def study(folder: Path) -> str:
    """Tables and figures of the control study; of one that was not published, how to make it."""
    content = _published(folder)
    if not content:
        return "No results are published with this version: make them with the command above.\n"
    text = ["## Tables\n", f"Intervals: {content['method']}.\n"]
    text += [f"### {each['title']}\n\n{table(each['header'], each['rows'])}"
             for each in content["tables"]]  # fmt: skip
    pictures = sorted(folder.glob("*.png"))
    text += ["## Figures\n"] if pictures else []
    text += [f"![{path.stem.replace('-', ', ')}](benchmark/{path.name})\n" for path in pictures]
    return "\n".join(text)


def _published(folder: Path) -> dict[str, Any]:
    """The study's tables and rows; none if it is not there."""
    source = folder / STUDY
    content: dict[str, Any] = (
        json.loads(source.read_text(encoding="utf-8")) if source.is_file() else {}
    )
    return content


def baselines(env_id: str, folder: Path) -> str:
    """Tables of all controllers at both levels, the optimum, and how to run each row.

    Args:
        folder: where the study is published; without it, a placeholder and the optimum.
    """
    rows = [row for row in _published(folder).get("rows", []) if row["env_id"] == env_id]
    text = ["What each of them is, and how it is measured: {doc}`../benchmark`.\n"]
    text = text if rows else [MISSING]
    for level in LEVELS:
        some = [row for row in rows if row["level"] == level]
        kwargs = Cell(env_id, level, OPTIMAL).env_kwargs
        push = task_of(env_id, **kwargs).disturbance.push
        text.append(f"### {level.capitalize()} pushes, {push:g} rad/s\n")
        if some:
            header = HEADER if any(row["score"] for row in some) else HEADER[:-1]
            text.append(table(header, [_line(row, len(header)) for row in some if row["runs"]]))
            text += [_refused(some)]
        text.append(_optimum(env_id, kwargs))
    if rows:
        text += _how(env_id, rows)
    return "\n".join(text)


def _line(row: dict[str, Any], columns: int) -> list[str]:
    name = f"{row['controller']} ({row['runs']} seeds)" if _learns(row) else row["controller"]
    found = [(row["strides"], 1), (row["returns"], 1), (row["score"], 3)]
    shown = [Estimate(*values).text(digits) if values else "–" for values, digits in found]
    return [name, *shown][:columns]


def _refused(rows: Sequence[dict[str, Any]]) -> str:
    names = [row["controller"] for row in rows if not row["runs"]]
    return f"Not there, and why: {{doc}}`../benchmark` ({', '.join(names)}).\n" if names else ""


def _optimum(env_id: str, kwargs: dict[str, str]) -> str:
    """What is known of the greatest return of any controller."""
    try:
        found = Optimal(task_of(env_id, **kwargs)).found
    except ValueError:
        return "The optimum is not known here, and no table comes with the package.\n"
    mean, error = found.walked
    walked = f"{mean:.1f} ± {1.96 * error:.2g}"
    how = "which looks a stride ahead" if found.looks_ahead else "the table as it is"
    if found.resolved:
        return (
            f"The optimum is resolved: **{found.value:.1f} ± {found.error:.1f}** is the greatest "
            f"return of any controller; the shipped policy (`optimal`), {how}, walks {walked}.\n"
        )
    return (
        f"The optimum is not resolved. Best known: **{walked}**, a lower bound, walked by the "
        f"shipped policy (`optimal`), {how}; its table promises {found.value:.1f} on its grid, "
        "which is no bound.\n"
    )


def _how(env_id: str, rows: Sequence[dict[str, Any]]) -> list[str]:
    """The command of every row."""
    learners = [name for name in LEARNERS if any(row["controller"] == name for row in rows)]
    named = " ".join(["open-loop", "lqr", *shipped_learners(env_id), "optimal"])
    text = [
        "### How to run each row\n",
        "1,000 episodes each, the same pushes for all; 95 % intervals, over seeds as well where "
        "there are several (interquartile mean). Rows by their names; a learner's name is the "
        "trained policy that comes with the package, that of its median seed under light "
        "pushes:\n",
        f"```sh\npython -m agents.evaluate {named} --env {env_id} \\\n"
        f"  --episodes {FULL.episodes}\n```\n",
        "and `--disturbance rough` for the other level. A learner's row itself is trained with "
        "the seeds 0 to 4, by\n",
    ]
    there = {(row["level"], row["controller"]) for row in rows}
    cells = [Cell(env_id, *each) for each in itertools.product(LEVELS, learners) if each in there]
    if cells:
        text.append("```sh\n" + "\n".join(map(command_of, cells)) + "\n```\n")
    return text


def _learns(row: dict[str, Any]) -> bool:
    return row["controller"] in LEARNERS


def questions(folder: Path) -> dict[str, str]:
    """Tables of the pages of questions by page, from the JSON files beside them."""
    found: dict[str, list[dict[str, Any]]] = {}
    for source in sorted(folder.glob("*.json")):
        content = json.loads(source.read_text(encoding="utf-8"))
        for page, tables in content.get("tables", {}).items():
            found.setdefault(page, []).extend(tables)
    return {
        page: "\n".join(f"### {each['title']}\n\n{table(each['header'], each['rows'])}"
                        for each in tables)
        for page, tables in found.items()
    }  # fmt: skip
