"""What the pages of the thesis's questions say in numbers, from the files that hold them.

`benchmark/study.json` has the study, `questions/*.json` what `agents.study.ladder`, `viability`
and `geometry` found. A number stands on a page because it stands there.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import answer_tables as tables
import answer_words as words
from answer_figures import cost_figure, ladder_figure
from generate import write
from study_rows import Study

from powered_walker_env.pictures.charts import save_figure

MISSING = "No results are published with this version: make them with the commands of this page.\n"


def answers(generated: Path, docs: Path) -> None:
    """Write every fragment and figure; of what was not published, that it was not."""
    source, questions = docs / "benchmark" / "study.json", docs / "questions"
    found = {name: load(questions / f"{name}.json") for name in ("ladder", "viability", "geometry")}
    study = Study(source) if source.is_file() else None
    texts = {
        "simplest-answer": study and found["ladder"] and words.simplest(study, found["ladder"]),
        "stable-answer": study and found["viability"] and words.stable(study, found["viability"]),
        "computation-answer": study
        and found["geometry"]
        and words.computation(study, found["geometry"]),
        "ladder": study and tables.ladder(study),
        "pairs": found["ladder"] and tables.pairs(found["ladder"]),
        "deadbeat": found["ladder"] and tables.deadbeat(found["ladder"]),
        "optima": tables.optima(),
        "scores": study and tables.scores(study),
        "kernels": found["viability"] and tables.kernels(found["viability"]),
        "lasting": study and tables.lasting(study),
        "fronts": study and tables.fronts(study),
        "bodies": found["geometry"] and tables.bodies(found["geometry"]),
    }
    for name, text in texts.items():
        write(generated / f"{name}.md", text or MISSING)
    if study:
        save_figure(ladder_figure(study), generated / "ladder.png")
        save_figure(cost_figure(study), generated / "cost.png")


def load(path: Path) -> Any:
    """Of JSON; None if there is none."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
