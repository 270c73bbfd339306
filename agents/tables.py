"""Comparisons of controllers as tables (rich) and as JSON."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from agents.evaluate import Evaluation
from agents.statistics import (
    METHOD,
    SHARE_METHOD,
    mean_estimate,
    paired_difference,
    share_estimate,
)
from powered_walker_env import Outcome

WIDTH = 100  # of tables: terminals that are narrower wrap


def comparison_table(evaluations: Mapping[str, Evaluation], title: str) -> Table:
    """Controllers side by side; differences are paired, against the first."""
    first = next(iter(evaluations.values()))
    table = Table(title=escape(title), box=box.SIMPLE, title_justify="left")
    table.add_column("controller", no_wrap=True)
    for header in (f"strides of {first.limit}", "difference", "return", "to the end"):
        table.add_column(header, justify="right", no_wrap=True)
    for name, evaluation in evaluations.items():
        paired = paired_difference(evaluation.strides, first.strides)
        table.add_row(
            escape(name),
            escape(mean_estimate(evaluation.strides).text()),
            "" if evaluation is first else escape(paired.text(signed=True)),
            f"{evaluation.returns.mean():.1f}",
            f"{100 * evaluation.survived / len(evaluation.strides):.0f} %",
        )
    return table


def notes(evaluations: Mapping[str, Evaluation]) -> list[str]:
    """What stands below the table: the sample, and how the walkers fell."""
    first_name, first = next(iter(evaluations.items()))
    count = len(first.strides)
    falls = [f"  {name}: {_falls(evaluation)}" for name, evaluation in evaluations.items()]
    return [
        f"mean [95 % confidence] of {count} episodes, seeds {first.seed} to "
        f"{first.seed + count - 1}, the same for all;",
        f"differences are against {first_name}, episode by episode. Falls:",
        *falls,
    ]


def print_comparison(
    evaluations: Mapping[str, Evaluation], title: str, console: Console | None = None
) -> None:
    """Print the table and its notes."""
    console = console or Console(width=WIDTH)
    console.print(comparison_table(evaluations, title))
    console.print("\n".join(notes(evaluations)), markup=False, highlight=False)


def comparison_text(evaluations: Mapping[str, Evaluation], title: str) -> str:
    """The table and its notes as plain text."""
    text = io.StringIO()
    print_comparison(evaluations, title, Console(file=text, width=WIDTH, color_system=None))
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()) + "\n"


def comparison(evaluations: Mapping[str, Evaluation]) -> dict[str, Any]:
    """The comparison for JSON, with the numbers of every episode."""
    first_name, first = next(iter(evaluations.items()))
    return {
        "env": first.env_id,
        "env_kwargs": dict(first.env_kwargs),
        "episodes": len(first.strides),
        "seed": first.seed,
        "stride_limit": first.limit,
        "intervals": {"means": METHOD, "shares": SHARE_METHOD},
        "controllers": {
            name: _entry(evaluation, first_name, first) for name, evaluation in evaluations.items()
        },
    }


def _entry(evaluation: Evaluation, first_name: str, first: Evaluation) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "strides": mean_estimate(evaluation.strides).to_dict(),
        "return": mean_estimate(evaluation.returns).to_dict(),
        "survived": share_estimate(evaluation.survived, len(evaluation.strides)).to_dict(),
        "ends": evaluation.ends(),
    }
    if evaluation is not first:
        entry["difference"] = {
            "against": first_name,
            "strides": paired_difference(evaluation.strides, first.strides).to_dict(),
            "return": paired_difference(evaluation.returns, first.returns).to_dict(),
        }
    entry["by_episode"] = {
        "strides": evaluation.strides.tolist(),
        "return": evaluation.returns.tolist(),
        "end": [Outcome(int(outcome)).label for outcome in evaluation.outcomes],
    }
    return entry


def _falls(evaluation: Evaluation) -> str:
    falls = {k: n for k, n in evaluation.ends().items() if k != Outcome.WALKED.label}
    return ", ".join(f"{count} {kind}" for kind, count in falls.items()) or "none"
