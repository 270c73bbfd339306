"""The quickstart, in small: everything that it promises is there afterwards."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from agents import quickstart
from agents.command import ROUND_FOOT, exit_status
from agents.quickstart import free_folder, main, met, typical_episode
from agents.recording import record
from powered_walker_env import Disturbance, Outcome
from powered_walker_env.controllers import EPISODE_SEED, LQR, OpenLoop, evaluate
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.model.quantities import quantities


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quickstart of two thousand strides."""
    out = tmp_path_factory.mktemp("runs") / "quickstart"
    main(["--out", str(out), "--steps", "2048", "--episodes", "12"])
    return out


def test_everything_is_there(folder: Path) -> None:
    names = {path.name for path in folder.iterdir()}
    assert names >= {
        "results.json", "results.txt", "learning_curve.png", "walk.png", "walk.gif",
        "best_model.zip", "policy.npz", "checkpoint.zip", "config.yml", "versions.json",
        "evaluations.csv",
    }  # fmt: skip
    assert not [name for name in names if name.startswith(".")]


def test_the_results_are_those_of_an_evaluation(folder: Path) -> None:
    result = json.loads((folder / "results.json").read_text())
    assert list(result["controllers"]) == ["open loop", "LQR", "PPO"]
    again = evaluate(OpenLoop(), ROUND_FOOT, 12, EPISODE_SEED)
    assert result["controllers"]["open loop"]["by_episode"]["strides"] == again.strides.tolist()
    text = (folder / "results.txt").read_text()
    assert all(name in text for name in ("open loop", "LQR", "PPO", "push 0.02"))


def test_what_the_walkers_meet_is_told_with_its_unit() -> None:
    walks = evaluate(OpenLoop(), ROUND_FOOT, 1, disturbance={"push": 0.02, "slope": 0.01})
    known = quantities(Disturbance)
    for part, kind, size in zip(
        met(walks).split(", "), ("push", "slope"), (0.02, 0.01), strict=True
    ):
        unit = known[kind].unit if kind in known else ""
        assert part == f"{kind} {size} {unit}".strip()
    assert met(evaluate(OpenLoop(), ROUND_FOOT, 1, disturbance="none")) == "undisturbed"


def test_the_pictures_are_pictures(folder: Path) -> None:
    for name in ("learning_curve.png", "walk.png"):
        with PIL.Image.open(folder / name) as image:
            assert image.width > 600
            assert len(np.unique(np.asarray(image.convert("L")))) > 20
    with PIL.Image.open(folder / "walk.gif") as film:
        assert film.n_frames > 20  # type: ignore[attr-defined]
        assert film.info["loop"] == 0


def test_the_pasted_command_works_a_second_time(tmp_path: Path) -> None:
    wanted = tmp_path / "quickstart"
    assert free_folder(wanted) == wanted
    wanted.mkdir()
    assert free_folder(wanted) == tmp_path / "quickstart-2"
    (tmp_path / "quickstart-2").mkdir()
    assert free_folder(wanted) == tmp_path / "quickstart-3"


def test_a_folder_that_was_named_is_not_overwritten_unasked(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (folder / "results.json").read_bytes()
    assert exit_status(lambda: main(["--out", str(folder), "--steps", "64"])) == 2
    assert "exists; choose another name, replace it by --overwrite" in capsys.readouterr().err
    assert (folder / "results.json").read_bytes() == before


def test_ctrl_c_leaves_a_run_that_can_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import signal

    import agents.supervisor

    evaluate_once = agents.supervisor.evaluate

    def interrupted(*args: object, **kwargs: object) -> object:
        signal.raise_signal(signal.SIGINT)
        return evaluate_once(*args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(agents.supervisor, "evaluate", interrupted)
    out = tmp_path / "q"
    assert exit_status(lambda: main(["--out", str(out), "--steps", "4096"])) == 130
    assert f"python -m agents.train --resume --name q --runs {tmp_path}" in capsys.readouterr().err
    assert (out / "checkpoint.zip").exists()


def test_an_unknown_environment_is_named() -> None:
    with pytest.raises(ValueError, match="PoweredWalker-v7"):
        quickstart.run(Path("nowhere"), env_id="PoweredWalker-v7")
    assert not Path("nowhere").exists()


def test_the_episode_shown_is_typical() -> None:
    strides = np.array([1, 9, 10, 40, 9])
    assert typical_episode(strides, np.array([100, 50, 100, 100, 100])) == 4
    assert typical_episode(strides, np.array([5, 6, 7, 8, 4])) == 3


@pytest.mark.parametrize("seed", [EPISODE_SEED, EPISODE_SEED + 3])
def test_a_recorded_episode_is_the_one_that_was_evaluated(seed: int) -> None:
    kwargs = {"disturbance": {"push": 0.02, "ground": 0.003, "torque": 0.01, "parameters": 0.002}}
    controller = LQR(task_of(ROUND_FOOT, **kwargs))
    result = evaluate(controller, ROUND_FOOT, 1, seed, **kwargs)
    trajectory = record(controller, ROUND_FOOT, seed, 100, **kwargs)
    assert trajectory.outcome == Outcome(int(result.outcomes[0]))
    fell = trajectory.outcome != Outcome.WALKED
    assert trajectory.stride[-1] + 1 == result.strides[0] + fell
    assert (np.diff(trajectory.t) >= 0).all()
