"""An evolution strategy on the numbers of a network: what it draws, walks, learns and keeps."""

from __future__ import annotations

import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from agents.command import exit_status
from agents.evolution import main
from agents.evolution_learner import ALGO, Crowd, EvolutionLearner, Settings
from agents.own_training import read_settings, train
from powered_walker_env import ENVIRONMENTS
from powered_walker_env.controllers import OpenLoop, evaluate, load_controller
from powered_walker_env.controllers.evaluation import task_of

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
SMALL = Settings(ROUND_FOOT, n_timesteps=4000, population=4, walks=8, hidden=3, episodes=3)


def test_a_candidate_among_many_walks_as_it_does_alone() -> None:
    rng = np.random.default_rng(0)
    learner = EvolutionLearner(SMALL)
    layers = learner._layers(rng.normal(size=(4, 3 * 5 + 2 * 4)))
    crowd = Crowd(layers, learner._metric)
    seen = rng.normal(size=(4 * 8, 4)).astype(np.float32)
    together = crowd.predict(seen)[0].reshape(4, 8, 2)
    for i, each in enumerate(seen.reshape(4, 8, 4)):
        hidden = np.tanh(each @ learner._metric.T @ layers[0][0][i].T + layers[0][1][i])
        alone = np.clip(hidden @ layers[1][0][i].T + layers[1][1][i], -1, 1)
        np.testing.assert_allclose(together[i], alone, atol=1e-12)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_it_begins_as_the_open_loop_and_counts_its_strides(env_id: str) -> None:
    learner = EvolutionLearner(replace(SMALL, env_id=env_id))
    observations = np.random.default_rng(0).normal(size=(5, 4))
    assert not learner.network().predict(observations)[0].any()
    mean = learner.update()
    assert 0 < mean <= 100 and 0 < learner.falls <= 4 * 8
    assert learner.strides >= 4 * 8
    assert learner.network().predict(observations)[0].any()


def test_candidates_of_a_generation_meet_the_same_pushes(monkeypatch: pytest.MonkeyPatch) -> None:
    learner = EvolutionLearner(SMALL)
    asked = learner._strategy.ask()
    monkeypatch.setattr(learner._strategy, "ask", lambda: [asked[0]] * 4)
    told: list[list[float]] = []
    monkeypatch.setattr(learner._strategy, "tell", lambda _, costs: told.append(costs))
    learner.update()
    learner.update()
    assert all(len(set(costs)) == 1 for costs in told)  # alike, so their walks are
    assert told[0] != told[1]  # and the next generation meets others


def test_it_learns_on_the_ground_where_the_open_loop_falls(tmp_path: Path) -> None:
    learner = EvolutionLearner(
        Settings(ROUND_FOOT, n_timesteps=400_000, population=12, walks=32, episodes=20)
    )
    history = train(learner, tmp_path / "run", quiet=True)
    assert history[0]["steps"] == 0 and history[-1]["steps"] == learner.strides
    name, controller = load_controller(tmp_path / "run", task_of(ROUND_FOOT), ROUND_FOOT)
    assert name == "CMA-ES run"
    learnt = evaluate(controller, ROUND_FOOT, 100)
    baseline = evaluate(OpenLoop(), ROUND_FOOT, 100)
    assert learnt.mean_return.mean > 3 * baseline.mean_return.mean


def test_any_scheme_disturbance_and_reward_will_do() -> None:
    kwargs = {"preset": "hip-torque", "disturbance": "light-ground", "reward": "contraction"}
    learner = EvolutionLearner(replace(SMALL, env_kwargs=kwargs))
    learner.update()
    assert evaluate(learner.network(), ROUND_FOOT, 5, **kwargs).strides.max() > 0


def test_a_stopped_training_goes_on_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--runs", str(tmp_path), "--steps", "25000", "--hyperparams", "walks:8", "episodes:5"]
    main([*words, "--name", "whole"])
    update = EvolutionLearner.update

    def interrupted(self: EvolutionLearner) -> float:
        if len(self.kept()) == 2:
            signal.raise_signal(signal.SIGINT)
        return update(self)

    monkeypatch.setattr(EvolutionLearner, "update", interrupted)
    assert exit_status(lambda: main([*words, "--name", "cut"])) == 130
    assert "with --resume goes on" in capsys.readouterr().err
    monkeypatch.undo()
    walked: list[int] = []
    monkeypatch.setattr(
        EvolutionLearner, "_walked",
        lambda self, *args, walk=EvolutionLearner._walked: walked.append(1) or walk(self, *args),
    )  # fmt: skip
    main([*words, "--name", "cut", "--resume"])
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for name in ("policy.npz", "evaluations.csv", "updates.npy"):
        assert (whole / name).read_bytes() == (cut / name).read_bytes()
    assert len(walked) == len(np.load(whole / "updates.npy")) - 3  # three were kept
    with pytest.raises(ValueError, match="is a run of other settings"):
        main([*words, "--name", "cut", "--resume", "--seed", "1"])
    with pytest.raises(ValueError, match="is no run to go on with"):
        main([*words, "--name", "nowhere", "--resume"])
    np.save(cut / "updates.npy", np.zeros((2, 5)))
    with pytest.raises(ValueError, match="of another training"):
        main([*words, "--name", "cut", "--resume"])
    (cut / "updates.npy").write_bytes(b"x")
    with pytest.raises(ValueError, match="is no run to go on with"):
        main([*words, "--name", "cut", "--resume"])


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_every_environment_has_its_settings(env_id: str) -> None:
    settings = read_settings(Settings, ALGO, env_id)
    assert settings.n_timesteps >= 1_000_000 and settings.metric
