"""Trained policies: exported, loaded, and as good as they say."""

from __future__ import annotations

from pathlib import Path

import pytest

from agents.evaluate import main as evaluate_command
from agents.study import policies
from agents.study.policies import export, median_seed
from agents.study.records import Record, load_record, path_of
from agents.study.running import Plan, run_cell
from powered_walker_env.controllers import evaluate, load_network
from powered_walker_env.controllers.shipped import shipped_policies
from tests.agents.study.test_running import a_cell, plan_in

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"


def a_record(seed: int, worth: float) -> Record:
    return Record(a_cell("ppo", seed), "done", measures={"episodes": {"returns": [worth, worth]}})


def test_the_median_seed_is_taken() -> None:
    some = [a_record(seed, worth) for seed, worth in enumerate([5.0, 1.0, 9.0, 3.0, 4.0])]
    assert median_seed(some).cell.seed == 4
    assert median_seed(some[:4]).cell.seed == 3  # of 1, 3, 5, 9
    assert median_seed(some[:1]).cell.seed == 0


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    plan = plan_in(tmp_path_factory.mktemp("study"))
    for controller in ("ppo", "apg", "sac"):
        assert run_cell(a_cell(controller), plan).status == "done"
    return plan


def records_of(study: Plan) -> list[Record]:
    found = [load_record(path_of(study.out, a_cell(word))) for word in ("ppo", "apg", "sac")]
    return [record for record in found if record is not None]


def test_policies_are_exported_with_what_they_score(
    study: Plan, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written = export(records_of(study), study.out, tmp_path, episodes=12)
    assert [path.stem.rpartition("-")[2] for path in written] == ["ppo", "apg", "sac"]
    declared = shipped_policies(tmp_path)
    assert list(declared) == sorted(path.name for path in written)
    for path in written:
        numbers = sum(weights.size + biases.size for weights, biases in load_network(path).layers)
        assert path.stat().st_size < 4 * numbers + 5000  # single precision, and what it is
        found, about = evaluate(load_network(path), ROUND_FOOT, 12), declared[path.name]
        assert about["strides"] == list(found.mean_strides)
        assert about["return"] == list(found.mean_return)
        assert about["first"]["strides"] == found.strides.tolist()
        assert (about["env_id"], about["learner"]) == (ROUND_FOOT, path.stem.rpartition("-")[2])
    evaluate_command(["open-loop", *map(str, written), "--episodes", "3"])
    assert "PPO" in capsys.readouterr().out


def test_policies_too_large_in_all_are_refused(
    study: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(policies, "MOST", 30_000)
    with pytest.raises(ValueError, match="policies must be smaller than 30,000 bytes in all"):
        export(records_of(study), study.out, tmp_path, episodes=2)
