"""Trained policies: exported, loaded, and as good as they say."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from agents.evaluate import main as evaluate_command
from agents.study import policies
from agents.study.policies import FOLDER, MOST, export, median_seed, shipped
from agents.study.records import Record, load_record, path_of
from agents.study.running import Plan, run_cell
from powered_walker_env.controllers import evaluate, load_network
from powered_walker_env.envs.registration import ENVIRONMENTS
from tests.agents.study.test_running import a_cell, plan_in


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
    for path in written:
        assert path.stat().st_size < 25_000
        assert path.name in shipped(tmp_path)
        network = load_network(path)
        found = evaluate(network, "PoweredWalkerRoundFoot-v0", 12)
        assert network.settings["strides"] == list(found.mean_strides)
        assert network.settings["return"] == list(found.mean_return)
        assert network.settings["env_id"] == "PoweredWalkerRoundFoot-v0"
    evaluate_command(["open-loop", *map(str, written), "--episodes", "3"])
    assert "PPO" in capsys.readouterr().out


def test_policies_too_large_in_all_are_refused(
    study: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(policies, "MOST", 30_000)
    with pytest.raises(ValueError, match="policies must be smaller than 30,000 bytes in all"):
        export(records_of(study), study.out, tmp_path, episodes=2)


def test_the_files_that_come_with_the_repository_are_those_declared() -> None:
    there = sorted(FOLDER.glob("*.npz"))
    assert [path.name for path in there] == shipped()
    assert sum(path.stat().st_size for path in there) < MOST


@pytest.mark.parametrize("name", shipped())
def test_a_policy_scores_what_its_file_says(name: str) -> None:
    """Another processor rounds otherwise, and some walks differ: half the interval is allowed."""
    network = load_network(FOLDER / name)
    about = network.settings
    assert about["env_id"] in ENVIRONMENTS
    found = evaluate(network, about["env_id"], about["episodes"], about["episode_seed"])
    for what, ours in (("strides", found.mean_strides), ("return", found.mean_return)):
        mean, low, high = about[what]
        assert math.isfinite(mean)
        assert ours.mean == pytest.approx(mean, abs=0.25 * (high - low) + 0.05)
