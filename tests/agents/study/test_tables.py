"""Rows, tables and figures of records made up for the purpose."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from agents.study.cells import Cell
from agents.study.figures import figures
from agents.study.records import Record
from agents.study.summary import over_all, summary
from agents.study.tables import markdown, study_json

FIRST, SECOND = "PoweredWalkerRoundFoot-v0", "PoweredWalkerKneed-v0"


def a_record(
    env_id: str, controller: str, seed: int, worth: float, **measures: dict[str, Any]
) -> Record:
    episodes = {
        "limit": 100, "survived": worth / 100, "strides": [int(worth)] * 4,
        "returns": [worth - 1.0, worth, worth, worth + 1.0],
    }  # fmt: skip
    training = {}
    if controller == "ppo":
        curve = {"steps": [0.0, 1000.0], "strides": [10.0, worth]}
        training = {"strides": 1000, "seconds": 10.0 + seed, "resumed": seed == 2, "curve": curve}
    passage = {"mean": 2 * worth, "low": worth, "falls": 3}
    return Record(
        Cell(env_id, "light", controller, seed), "done",
        measures={"episodes": episodes, "passage": passage, **measures}, training=training,
    )  # fmt: skip


def some_records() -> list[Record]:
    found = [
        a_record(env_id, controller, 0, worth)
        for env_id in (FIRST, SECOND)
        for controller, worth in (("open-loop", 10.0), ("lqr", 60.0), ("optimal", 90.0))
    ]
    found += [a_record(FIRST, "ppo", seed, 50.0 + 10.0 * seed) for seed in range(5)]
    refused = Record(Cell(SECOND, "light", "deadbeat"), "refused", "two strides are not enough")
    return [*found, refused]


def test_rows_have_what_the_records_have() -> None:
    rows = {(row.env_id, row.controller): row for row in summary(some_records(), 200)}
    ppo = rows[FIRST, "ppo"]
    assert ppo.runs == 5 and ppo.strides is not None and ppo.score is not None
    assert ppo.strides.mean == pytest.approx(70.0)  # of 60, 70, 80
    assert ppo.score.mean == pytest.approx(0.75)
    assert ppo.medians["mean_first_passage"] == 140.0
    assert ppo.trained_strides == 1000.0
    assert ppo.trained_seconds == 12.0  # of 10, 11, 13, 14: the resumed one does not count
    assert rows[SECOND, "deadbeat"].refused == {"": "two strides are not enough"}
    assert rows[FIRST, "open-loop"].medians["cost_of_transport"] is None


def test_only_what_is_at_every_environment_is_put_over_all() -> None:
    found = over_all(some_records(), "light", 200)
    assert set(found) == {"open-loop", "lqr", "optimal"}
    assert found["lqr"]["strides"].mean == pytest.approx(0.6)
    assert found["lqr"]["score"].mean == pytest.approx(0.625)
    assert over_all(some_records(), "rough", 200) == {}


def test_without_the_optimum_there_is_no_score() -> None:
    some = [record for record in some_records() if record.cell.controller != "optimal"]
    assert all(row.score is None for row in summary(some, 50))
    assert "score" not in over_all(some, "light", 50)["lqr"]


def test_tables_are_written_from_the_json_alone() -> None:
    study = study_json(some_records(), 100)
    again = json.loads(json.dumps(study, allow_nan=False))
    text = markdown(again)
    assert text == markdown(study)
    assert "| ppo | 5 | 70.0 [" in text and "| 0.750 [" in text
    assert "two strides are not enough" in text
    for line in text.splitlines():
        assert "None" not in line and "nan" not in line


def test_a_mean_without_all_its_falls_is_a_bound() -> None:
    never = a_record(FIRST, "optimal", 0, 90.0)
    never.measures["passage"].update(mean=None, falls=0)
    text = markdown(study_json([never], 50))
    assert "> 90" in text


def test_figures_are_drawn_of_what_there_is(tmp_path: Path) -> None:
    written = figures(some_records(), tmp_path)
    assert sorted({path.stem.partition("-")[0] for path in written}) == ["learning"]
    assert all(path.with_suffix(".csv").is_file() for path in written)
    assert figures([], tmp_path) == []
