"""Where the results of a study go: its own folder, and the places of the repository."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from agents.command import CONFIGS
from agents.runs import write_json
from agents.study.budgets import Budget
from agents.study.commands import page
from agents.study.figures import figures
from agents.study.policies import export
from agents.study.records import Record
from agents.study.tables import markdown, study_json
from powered_walker_env.controllers.shipped import FOLDER
from powered_walker_env.files import write_text

ROOT = CONFIGS.parent
BENCHMARK = ROOT / "docs" / "benchmark"  # the pages are made of what is here
STUDY, TABLES = "study.json", "tables.md"


def report(records: Sequence[Record], budget: Budget, out: Path) -> Path:
    """Tables as JSON and Markdown, and the figures, into the folder of the study.

    Returns:
        The Markdown.
    """
    pictures = out / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    study = study_json(records, budget.resamples)
    write_json(out / STUDY, study)
    write_text(out / TABLES, markdown(study))
    figures(records, pictures)
    return out / TABLES


def publish(records: Sequence[Record], budget: Budget, out: Path) -> list[Path]:
    """The same into docs/benchmark, the policies into the package, the commands into agents/.

    Returns:
        What was written.
    """
    BENCHMARK.mkdir(exist_ok=True)
    study = BENCHMARK / STUDY
    write_json(study, study_json(records, budget.resamples))
    readme = ROOT / "agents" / "README.md"
    write_text(readme, page())
    pictures = figures(records, BENCHMARK)
    return [study, *pictures, *export(records, out, FOLDER, budget.episodes), readme]
