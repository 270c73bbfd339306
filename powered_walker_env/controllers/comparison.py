"""Evaluations side by side, as text and for JSON; differences are paired, against the first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from powered_walker_env.controllers.estimates import (
    METHOD,
    SHARE_METHOD,
    Estimate,
    paired_difference,
    share_estimate,
)
from powered_walker_env.controllers.evaluation import WALKED, Evaluation
from powered_walker_env.controllers.optimal import OPTIMUM_NAME
from powered_walker_env.controllers.scores import OPEN_LOOP_NAME, normalised_score
from powered_walker_env.model.phases import Outcome
from powered_walker_env.tabular import aligned


def comparison_text(evaluations: Mapping[str, Evaluation], title: str) -> str:
    """The table, and below it the sample and how the walkers fell."""
    first_name, first = next(iter(evaluations.items()))
    count = len(first.strides)
    rows: list[tuple[str, ...]] = [
        (
            name,
            item.mean_strides.text(),
            ""
            if item is first
            else paired_difference(item.strides, first.strides).text(signed=True),
            f"{100 * item.survived / count:.0f} %",
            f"{item.returns.mean():.1f}",
        )
        for name, item in evaluations.items()
    ]
    head: tuple[str, ...] = (
        "controller",
        f"strides of {first.limit}",
        "difference",
        "to the end",
        "return",
    )
    scores = _scores(evaluations)
    if scores:
        head = (*head, "score")
        rows = [(*row, scores[row[0]].text(3)) for row in rows]
    lines = aligned([head, *rows])
    falls = [f"  {name}: {_falls(item)}" for name, item in evaluations.items()]
    notes = [
        f"mean [95 % confidence] of {count} episodes, seeds {first.seed} to "
        f"{first.seed + count - 1}, the same for all;",
        f"differences are against {first_name}, episode by episode. Falls:",
    ]
    if scores:
        notes.insert(1, "score: of the return, 0 is the open loop and 1 the optimum;")
    return "\n".join([title, "", *lines, "", *notes, *falls]) + "\n"


def _scores(evaluations: Mapping[str, Evaluation]) -> dict[str, Estimate]:
    """The normalised scores, where the open loop and the optimum were evaluated, too."""
    if not {OPEN_LOOP_NAME, OPTIMUM_NAME} <= set(evaluations):
        return {}
    ends = evaluations[OPEN_LOOP_NAME], evaluations[OPTIMUM_NAME]
    return {name: normalised_score(item, *ends) for name, item in evaluations.items()}


def comparison(evaluations: Mapping[str, Evaluation]) -> dict[str, Any]:
    """The comparison for JSON, with the numbers of every episode."""
    first_name, first = next(iter(evaluations.items()))
    scores = _scores(evaluations)
    return {
        "env": first.env_id,
        "env_kwargs": dict(first.env_kwargs),
        "disturbance": dict(first.disturbance),
        "episodes": len(first.strides),
        "seed": first.seed,
        "stride_limit": first.limit,
        "intervals": {"means": METHOD, "shares": SHARE_METHOD},
        "controllers": {
            name: _entry(item, first_name, first)
            | ({"score": scores[name]._asdict()} if scores else {})
            for name, item in evaluations.items()
        },
    }


def _entry(item: Evaluation, first_name: str, first: Evaluation) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "strides": item.mean_strides._asdict(),
        "return": item.mean_return._asdict(),
        "survived": share_estimate(item.survived, len(item.strides))._asdict(),
        "ends": item.ends(),
    }
    if item is not first:
        entry["difference"] = {
            "against": first_name,
            "strides": paired_difference(item.strides, first.strides)._asdict(),
            "return": paired_difference(item.returns, first.returns)._asdict(),
        }
    entry["by_episode"] = {
        "strides": item.strides.tolist(),
        "return": item.returns.tolist(),
        "end": [Outcome(int(outcome)).label for outcome in item.outcomes],
    }
    return entry


def _falls(item: Evaluation) -> str:
    falls = {label: n for label, n in item.ends().items() if label != Outcome(WALKED).label}
    return ", ".join(f"{n} {label}" for label, n in falls.items()) or "none"
