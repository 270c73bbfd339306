"""The optimum as a controller: what is shipped, what it scores, and that nothing beats it."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.optimum import main as make_optimum
from powered_walker_env import find_gait, load_result, save_result
from powered_walker_env.controllers import (
    LQR,
    OpenLoop,
    Optimal,
    benchmark_score,
    comparison,
    comparison_text,
    evaluate,
    find_optimum,
    load_controller,
    normalised_score,
)
from powered_walker_env.controllers import optimal as room
from powered_walker_env.controllers.evaluation import Evaluation, task_of
from powered_walker_env.controllers.optimal import FOLDER, SHIPPED
from powered_walker_env.envs.task import Task
from powered_walker_env.poincare import Optimum, StepNoise, disturbed_walks, optimum
from powered_walker_env.poincare.stochastic.optimum import RESOLVED
from powered_walker_env.results import result_info

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
TASK: Task = task_of(ROUND_FOOT)
EPISODES = 300


@pytest.fixture(scope="module")
def walks() -> dict[str, Evaluation]:
    controllers = {"open loop": OpenLoop(), "LQR": LQR(TASK), "optimum": Optimal(TASK)}
    return {name: evaluate(each, ROUND_FOOT, EPISODES) for name, each in controllers.items()}


def test_the_shipped_table_walks_as_it_says_in_the_environment(
    walks: dict[str, Evaluation],
) -> None:
    found = Optimal(TASK).found
    low, high = found.value - found.error, found.value + found.error
    mean = walks["optimum"].mean_return
    assert mean.low < high and mean.high > low
    assert found.error < 0.01 * found.value and found.value < found.upper
    assert walks["optimum"].mean_strides.mean > 98.0
    rng_free = np.zeros((3, 4), np.float32)
    actions, memory = Optimal(TASK).predict(rng_free)
    assert memory is None and actions.shape == (3, 2) and (np.abs(actions) <= 1.0).all()
    assert Optimal(TASK).predict(rng_free[0])[0].shape == (2,)


@pytest.mark.parametrize("name", SHIPPED)
def test_each_shipped_table_walks_what_it_promises(name: str) -> None:
    path = FOLDER / name
    settings = result_info(path)["settings"]
    env_id, kwargs = settings["env_id"], settings["env_kwargs"]
    task = task_of(env_id, **kwargs)
    found = Optimal(task).found
    assert found.value == load_result(path).value  # it is found by its task
    many = 60 if found.looks_ahead else 300
    best = evaluate(Optimal(task), env_id, many, **kwargs).mean_return
    spread = 1.5 * (best.high - best.low)  # three standard errors
    assert abs(best.mean - found.value) < found.error + spread
    assert abs(best.mean - found.walked[0]) < 3.0 * found.walked[1] + spread
    for other in (OpenLoop(len(task.nominal)), LQR(task)):
        assert evaluate(other, env_id, 300, **kwargs).mean_return.low < found.value + found.error
    assert found.value < found.upper


def test_no_other_controller_beats_it(walks: dict[str, Evaluation]) -> None:
    found = Optimal(TASK).found
    for name in ("open loop", "LQR"):
        assert walks[name].mean_return.high < found.value - found.error
    score = normalised_score(walks["LQR"], walks["open loop"], walks["optimum"])
    assert 0.6 < score.low < score.mean < score.high < 1.0
    assert normalised_score(walks["optimum"], walks["open loop"], walks["optimum"]).mean == 1.0
    assert benchmark_score(OpenLoop(), ROUND_FOOT, 20).mean == 0.0


def test_tables_have_the_score_where_both_ends_are_known(walks: dict[str, Evaluation]) -> None:
    text = comparison_text(walks, "title")
    assert " score" in text and "1.000 [1.000, 1.000]" in text
    data = comparison(walks)["controllers"]
    assert data["optimum"]["score"]["mean"] == 1.0 and data["open loop"]["score"]["mean"] == 0.0
    without = {name: walks[name] for name in ("open loop", "LQR")}
    assert "score" not in comparison_text(without, "title")
    assert "score" not in comparison(without)["controllers"]["LQR"]


@pytest.fixture(scope="module")
def toe_off() -> tuple[Task, Optimum]:
    task = task_of(ROUND_FOOT, preset="toe-off")
    return task, find_optimum(task, objective="strides", shape=10)


def test_another_scheme_has_an_optimum_too(toe_off: tuple[Task, Optimum], tmp_path: Path) -> None:
    task, found = toe_off
    open_loop = evaluate(OpenLoop(1), ROUND_FOOT, 200, preset="toe-off")
    best = evaluate(Optimal(task, found), ROUND_FOOT, 200, preset="toe-off")
    assert best.mean_strides.low > open_loop.mean_strides.high
    path = save_result(found, tmp_path / "toe-off.npz")
    name, loaded = load_controller(path, task)
    seen = np.random.default_rng(0).normal(size=(50, 4)).astype(np.float32)
    np.testing.assert_array_equal(loaded.predict(seen)[0], Optimal(task, found).predict(seen)[0])
    assert name == "optimum"
    with pytest.raises(ValueError, match="optimum of this task, got one with another walker"):
        load_controller(path, TASK)
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    save_result(gait, tmp_path / "gait.npz")
    with pytest.raises(ValueError, match="must hold an optimum to be a controller, got a Gait"):
        load_controller(tmp_path / "gait.npz", task)


def test_the_value_is_that_of_plain_walks(toe_off: tuple[Task, Optimum]) -> None:
    task, found = toe_off
    walked = disturbed_walks(
        task.params, found.policy(), found.noise, task.gait[0], walks=3000, seed=9
    )
    mean, error = walked.mean
    assert abs(mean - found.walked[0]) < 5.0 * (error + found.walked[1])
    assert "strides, walked" in repr(found) and (np.abs(found.controls) <= 32767).all()


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"disturbance": "medium"}, "does not come with the package: make a table with"),
        ({"disturbance": "light-sensor"}, "got sensor: there a decision depends on more"),
        ({"disturbance": "none"}, "disturbance must not be none"),
        ({"action_range": (0.1, 0.1)}, "does not come with the package"),
    ],
)
def test_tasks_without_a_table_say_what_to_do(kwargs: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_controller("optimal", task_of(ROUND_FOOT, **kwargs))


def test_there_is_no_score_where_the_optimum_is_not_resolved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = Optimal(TASK).found
    blurred = replace(found, coarser=0.8 * found.value)
    monkeypatch.setattr(room, "_shipped", lambda _: blurred)
    name, controller = load_controller("optimal", TASK)
    assert isinstance(controller, Optimal)
    assert name == "best known" and controller.found is blurred
    with pytest.raises(ValueError, match="env must have a known optimum for a score"):
        benchmark_score(OpenLoop(), ROUND_FOOT, 3)
    assert benchmark_score(OpenLoop(), ROUND_FOOT, 20, optimum=blurred).mean == 0.0


def test_the_thesis_s_walker_has_a_known_optimum() -> None:
    found = Optimal(task_of("PoweredWalker-v0")).found
    mean, error = found.walked
    assert found.resolved and found.looks_ahead
    # More than what is walked, since it counts the strides that are left.
    assert mean - 3.0 * error < found.value < mean + RESOLVED * found.value
    score = benchmark_score(LQR(task_of("PoweredWalker-v0")), "PoweredWalker-v0", 60)
    assert 0.0 < score.low < score.high < 1.0


def test_what_makes_no_sense_is_refused(walks: dict[str, Evaluation]) -> None:
    with pytest.raises(ValueError, match="objective must be 'return' or 'strides'"):
        find_optimum(TASK, objective="speed")
    with pytest.raises(ValueError, match="must have the reward 'deviation'"):
        find_optimum(task_of(ROUND_FOOT, reward="contraction"))
    gait = find_gait(TASK.params, TASK.control, TASK.gait[0].tolist())
    with pytest.raises(ValueError, match="counts must be odd"):
        optimum(gait, TASK.half_range.tolist(), StepNoise(push=0.02), counts=4)
    with pytest.raises(ValueError, match="optimum must be better than the open loop"):
        normalised_score(walks["LQR"], walks["LQR"], walks["open loop"])
    with pytest.raises(ValueError, match="evaluations must be of the same episodes"):
        normalised_score(walks["LQR"], walks["LQR"], evaluate(OpenLoop(), ROUND_FOOT, 3))


def test_the_command_makes_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "table.npz"
    env = ("--env", ROUND_FOOT, "--env-kwargs", "preset:toe-off")
    small = ("--shape", "5", "--counts", "3", "--objective", "strides")
    make_optimum([*env, *small, "--out", str(path)])
    assert "as walked" in capsys.readouterr().out
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        name, _ = load_controller(path, task_of(ROUND_FOOT, preset="toe-off"))
    assert name == "best known"  # so small a table promises what it does not walk
    with pytest.raises(ValueError, match=r"--out must end in \.npz"):
        make_optimum(["--out", str(tmp_path / "table.zip")])
