"""The study runs, goes on where it was stopped, and does nothing twice."""

from __future__ import annotations

import dataclasses
import json
import time
from pathlib import Path
from typing import Any

import filelock
import numpy as np
import pytest

from agents.own_training import KEPT
from agents.study import running
from agents.study.budgets import SMALL, Budget
from agents.study.cells import Cell, cells
from agents.study.command import main
from agents.study.records import (
    DONE,
    FAILED,
    REFUSED,
    is_done,
    load_record,
    load_records,
    open_study,
    path_of,
)
from agents.study.running import LATER, LOCK, Plan, run_cell, run_study
from agents.study.training import settings_of, trained
from agents.train import train
from powered_walker_env.controllers import load_network, optimal

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
TINY = dataclasses.replace(
    SMALL, episodes=6, sweep_episodes=3, walks=10, limit=10, starts=10, nodes=6, decisions=3
)


def a_cell(controller: str, seed: int = 0) -> Cell:
    return Cell(ROUND_FOOT, "light", controller, seed)


def plan_in(folder: Path, budget: Budget = TINY, **named: Any) -> Plan:
    open_study(folder, budget)
    return Plan(budget, folder, **named)


def test_the_command_does_a_small_study_and_nothing_twice(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--small", "--out", str(tmp_path), "--only", "RoundFoot-v0-light"]
    main(words)
    every = [
        cell for cell in cells(SMALL) if cell.name.startswith("PoweredWalkerRoundFoot-v0-light")
    ]
    records = load_records(tmp_path, every)
    assert [record.cell for record in records] == every
    assert {record.status for record in records} == {DONE}
    trained_by = {record.cell.controller: record.training.get("strides") for record in records}
    assert trained_by["ppo"] == 2048 and trained_by["apg"] == 160 and trained_by["lqr"] is None
    table = (tmp_path / "tables.md").read_text(encoding="utf-8")
    assert "How long it walks: PoweredWalkerRoundFoot-v0, light" in table
    assert len(list((tmp_path / "figures").glob("*.png"))) == 6
    study = json.loads((tmp_path / "study.json").read_text(encoding="utf-8"))
    scores = {row["controller"]: row["score"] for row in study["rows"]}
    assert scores["open-loop"][0] == 0.0 and scores["optimal"][0] == 1.0
    assert 0.5 < scores["lqr"][0] < 1.0 and scores["ppo"][1] <= scores["ppo"][0]
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "cells").iterdir()}
    capsys.readouterr()
    assert run_study(every, Plan(SMALL, tmp_path)) == []
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "cells").iterdir()}
    main([*words, "--list"])
    assert "left" not in capsys.readouterr().out


def test_the_same_cell_has_the_same_results(tmp_path: Path) -> None:
    found = []
    for name in ("first", "second"):
        plan = plan_in(tmp_path / name)
        assert run_cell(a_cell("ppo", 1), plan).status == DONE
        record = load_record(path_of(plan.out, a_cell("ppo", 1)))
        assert record is not None
        found.append(record)
    for measure in ("episodes", "passage", "gait", "basin", "decided"):
        first, second = (dict(record.measures[measure], seconds=0) for record in found)
        assert first == second
    assert found[0].training["curve"] == found[1].training["curve"]


def test_an_interrupted_training_goes_on_bit_for_bit(tmp_path: Path) -> None:
    cell = a_cell("ppo")
    settings = settings_of(cell, TINY)
    whole = trained(cell, TINY, tmp_path / "whole")
    cut = train(settings, tmp_path / "cut" / cell.name, stop_at=1024, quiet=True)
    assert cut.stopped
    again = trained(cell, TINY, tmp_path / "cut")
    assert again.resumed and not whole.resumed
    assert again.strides == whole.strides == 2048 and again.curve == whole.curve
    first, second = (load_network(each.folder / "policy.npz") for each in (whole, again))
    for one, other in zip(first.layers, second.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
    # Once it has come to its end it is not trained again.
    assert trained(cell, TINY, tmp_path / "cut") == again


def test_an_evolution_goes_on_from_what_it_kept_unless_that_is_damaged(tmp_path: Path) -> None:
    cell = a_cell("cmaes")
    whole = trained(cell, TINY, tmp_path)
    assert whole.strides >= 20_000 and not whole.resumed
    (whole.folder / "trained.json").unlink()
    again = trained(cell, TINY, tmp_path)
    assert again.resumed and (again.strides, again.curve) == (whole.strides, whole.curve)
    (whole.folder / "trained.json").unlink()
    (whole.folder / KEPT).write_bytes(b"x")
    anew = trained(cell, TINY, tmp_path)
    assert not anew.resumed and anew.curve == whole.curve


def test_a_training_of_other_settings_begins_again(tmp_path: Path) -> None:
    cell = a_cell("ppo")
    other = dataclasses.replace(settings_of(cell, TINY), n_timesteps=3072)
    train(other, tmp_path / cell.name, stop_at=1024, quiet=True)
    assert not trained(cell, TINY, tmp_path).resumed


def test_a_controller_that_refuses_a_task_is_recorded_and_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(optimal, "SHIPPED", ())
    cell = Cell("PoweredWalker-v0", "rough", "optimal")
    end = run_cell(cell, plan_in(tmp_path))
    record = load_record(path_of(tmp_path, cell))
    assert record is not None
    assert (end.status, record.status) == (REFUSED, REFUSED)
    assert record.reason == end.reason and "optimum" in record.reason
    assert not is_done(tmp_path, cell)


def test_a_fault_is_kept_and_stops_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: object) -> None:
        raise ZeroDivisionError("of this test")

    monkeypatch.setattr(running, "measured", broken)
    end = run_cell(a_cell("open-loop"), plan_in(tmp_path))
    assert end.status == FAILED and "ZeroDivisionError: of this test" in end.reason
    assert not is_done(tmp_path, a_cell("open-loop"))


def test_after_the_deadline_no_cell_is_begun(tmp_path: Path) -> None:
    plan = plan_in(tmp_path, deadline=time.time() - 1.0)
    assert run_cell(a_cell("open-loop"), plan).status == LATER
    assert not path_of(tmp_path, a_cell("open-loop")).exists()


def test_a_damaged_cell_counts_as_not_there(tmp_path: Path) -> None:
    open_study(tmp_path, TINY)
    path_of(tmp_path, a_cell("lqr")).write_text('{"cell": {"env_id"')
    assert load_records(tmp_path, [a_cell("lqr")]) == [] and not is_done(tmp_path, a_cell("lqr"))


def test_studies_are_not_mixed(tmp_path: Path) -> None:
    open_study(tmp_path, TINY)
    with pytest.raises(
        ValueError, match=r"a study of other sizes \(.*episodes.*\); choose another"
    ):
        run_study([a_cell("lqr")], Plan(SMALL, tmp_path))
    with (
        filelock.FileLock(tmp_path / LOCK),
        pytest.raises(ValueError, match=r"a study is running in .* already"),
    ):
        run_study([a_cell("lqr")], Plan(TINY, tmp_path))
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match=r"file' cannot be made .*; choose another --out"):
        open_study(tmp_path / "file", TINY)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--small", "--only", "nothing"], "--only must be part of a cell's name"),
        (["--small", "--publish"], "--publish must be left out with --small"),
    ],
)
def test_silly_arguments_are_refused(words: list[str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        main(words)


@pytest.mark.parametrize("words", [["--jobs", "0"], ["--minutes", "-1"], ["--jobs", "two"]])
def test_silly_numbers_are_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(words)
    assert "must be a positive integer" in capsys.readouterr().err


def test_what_does_not_learn_is_not_trained() -> None:
    with pytest.raises(ValueError, match="cell must be a learner's to be trained"):
        settings_of(a_cell("lqr"), TINY)
