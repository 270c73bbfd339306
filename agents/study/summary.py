"""The records of a study as rows: one for each controller at an environment and level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from agents.study.cells import OPEN_LOOP, OPTIMAL, Cell
from agents.study.intervals import Stratum, interquartile_mean
from agents.study.records import DONE, REFUSED, Record
from powered_walker_env.controllers import Estimate, Optimal
from powered_walker_env.controllers.evaluation import task_of

#: Values of single runs that a row has the median of: (measure, name) by the row's name.
MEDIANS = {
    "survived": ("episodes", "survived"),
    "mean_first_passage": ("passage", "mean"),
    "at_least": ("passage", "low"),
    "first_passage_by_table": ("table_passage", "mean"),
    "cost_of_transport": ("gait", "cost_of_transport"),
    "electrical_cost": ("gait", "electrical_cost"),
    "spectral_radius": ("gait", "spectral_radius"),
    "push_sensitivity": ("sensitivity", "push"),
    "step_sensitivity": ("sensitivity", "step"),
    "basin": ("basin", "share"),
    "walking": ("basin", "walking"),
    "microseconds": ("decision", "microseconds"),
    "flops": ("decision", "flops"),
}
Key = tuple[str, str, str]  # environment, level, controller


@dataclass(frozen=True)
class Row:
    """What the tables say of a controller at an environment and level."""

    env_id: str
    level: str
    controller: str
    runs: int
    strides: Estimate | None  # interquartile means over seeds
    returns: Estimate | None
    score: Estimate | None  # None where the optimum is not known
    medians: dict[str, float | None]  # over the runs that have the value
    having: dict[str, int]  # how many have it
    trained_strides: float | None = None
    trained_seconds: float | None = None
    refused: dict[str, str] = field(default_factory=dict)  # words of a measure, or of the cell


def grouped(records: Sequence[Record]) -> dict[Key, list[Record]]:
    """The records of each row, in the order of their first."""
    found: dict[Key, list[Record]] = {}
    for record in records:
        cell = record.cell
        found.setdefault((cell.env_id, cell.level, cell.controller), []).append(record)
    return found


def summary(records: Sequence[Record], resamples: int) -> list[Row]:
    """A row of every group; those refused have their words and no numbers."""
    groups = grouped(records)
    return [_row(key, group, groups, resamples) for key, group in groups.items()]


def over_all(records: Sequence[Record], level: str, resamples: int) -> dict[str, dict[str, Any]]:
    """Controllers over all environments of a level: share of the strides, and the score.

    A score is over the environments whose optimum is known; only controllers that are at
    every one of them are compared.
    """
    groups = {key: group for key, group in grouped(records).items() if key[1] == level}
    env_ids = sorted({env_id for env_id, _, _ in groups})
    known = [env_id for env_id in env_ids if bounds(groups, env_id, level) is not None]
    found: dict[str, dict[str, Any]] = {}
    for controller in dict.fromkeys(name for _, _, name in groups):
        values = {}
        for what, among in (("strides", env_ids), ("score", known)):
            strata = []
            for env_id in among:
                done = _done(groups.get((env_id, level, controller), []))
                if not done:
                    break
                if what == "strides":
                    strata.append(Stratum(np.array(_episodes(done, "strides")) / _limit(done)))
                else:
                    low, high = bounds(groups, env_id, level) or (None, None)
                    strata.append(Stratum(_episodes(done, "returns"), low, high))
            if among and len(strata) == len(among):
                values[what] = interquartile_mean(strata, resamples)
        if values:
            found[controller] = {**values, "environments": {"strides": env_ids, "score": known}}
    return found


def bounds(
    groups: dict[Key, list[Record]], env_id: str, level: str
) -> tuple[list[float], list[float]] | None:
    """Returns of the open loop and of the optimum, episode by episode; None if one is missing.

    Or if the optimum is not resolved: what its table walks is but the best that is known.
    """
    columns = []
    if not resolved(env_id, level):
        return None
    for name in (OPEN_LOOP, OPTIMAL):
        done = _done(groups.get((env_id, level, name), []))
        if not done:
            return None
        columns.append(_episodes(done, "returns")[0])
    if len(columns[0]) != len(columns[1]) or not np.mean(columns[1]) > np.mean(columns[0]):
        return None
    return columns[0], columns[1]


@cache
def resolved(env_id: str, level: str) -> bool:
    """Whether the optimum that comes with the package is known to a tenth."""
    cell = Cell(env_id, level, OPTIMAL)
    try:
        return Optimal(task_of(env_id, **cell.env_kwargs)).found.resolved
    except ValueError:
        return False


def median_of(group: Sequence[Record], measure: str, name: str) -> tuple[float | None, int]:
    """The median over the runs that have a value, and how many have."""
    values = [record.get(measure, name) for record in group]
    known = [float(value) for value in values if value is not None]
    return (float(np.median(known)), len(known)) if known else (None, 0)


def _row(key: Key, group: list[Record], groups: dict[Key, list[Record]], resamples: int) -> Row:
    done = _done(group)
    refused = {
        name: values["refused"]
        for record in done
        for name, values in record.measures.items()
        if "refused" in values
    }
    if not done:
        why = next((each.reason for each in group if each.status == REFUSED), "it failed")
        return Row(*key, 0, None, None, None, {}, {}, refused={"": why})
    found = {name: median_of(done, *place) for name, place in MEDIANS.items()}
    ends = bounds(groups, key[0], key[1])
    score = None if ends is None else Stratum(_episodes(done, "returns"), *ends)
    trained = [record.training for record in done if record.training]
    whole = [each["seconds"] for each in trained if not each["resumed"]]
    return Row(
        *key,
        runs=len(done),
        strides=interquartile_mean([Stratum(_episodes(done, "strides"))], resamples),
        returns=interquartile_mean([Stratum(_episodes(done, "returns"))], resamples),
        score=None if score is None else interquartile_mean([score], resamples),
        medians={name: value for name, (value, _) in found.items()},
        having={name: count for name, (_, count) in found.items()},
        trained_strides=_median([each["strides"] for each in trained]),
        trained_seconds=_median(whole),
        refused=refused,
    )


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def _done(group: Sequence[Record]) -> list[Record]:
    return [each for each in group if each.status == DONE and each.get("episodes", "strides")]


def _episodes(done: Sequence[Record], name: str) -> list[list[float]]:
    return [record.get("episodes", name) for record in done]


def _limit(done: Sequence[Record]) -> float:
    return float(done[0].get("episodes", "limit") or math.nan)
