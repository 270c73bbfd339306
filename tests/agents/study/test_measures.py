"""What is measured of a controller, against the same asked for otherwise."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from agents.study.budgets import SMALL
from agents.study.cells import Cell
from agents.study.decisions import decided, flops
from agents.study.loops import basin_share, gait, landing_plane, sensitivity
from agents.study.measures import measured
from agents.study.subject import Subject
from agents.study.walks import passage, sweep, table_passage
from powered_walker_env import ENVIRONMENTS, PRESETS, find_gait
from powered_walker_env.controllers import (
    LQR,
    FunctionController,
    Network,
    OpenLoop,
    evaluate,
    load_controller,
)
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.poincare import StrideMap

ROUND_FOOT, KNEED = "PoweredWalkerRoundFoot-v0", "PoweredWalkerKneed-v0"


def subject_of(env_id: str, level: str, word: str, controller: Any = None, **sizes: int) -> Subject:
    cell = Cell(env_id, level, word)
    task = task_of(env_id, **cell.env_kwargs)
    chosen = load_controller(word, task)[1] if controller is None else controller
    return Subject(cell, task, chosen, dataclasses.replace(SMALL, **sizes))  # type: ignore[arg-type]


def test_without_feedback_the_gait_is_the_presets() -> None:
    for env_id, (name, _) in ENVIRONMENTS.items():
        params, control, state, _ = PRESETS[name]
        known, found = (
            find_gait(params, control, state),
            gait(subject_of(env_id, "light", "open-loop")),
        )
        assert found["spectral_radius"] == pytest.approx(known.spectral_radius, rel=1e-6)
        assert found["cost_of_transport"] == pytest.approx(known.cost_of_transport, rel=1e-9)
        assert found["electrical_cost"] > found["cost_of_transport"]
        assert found["moved"] == pytest.approx(0.0, abs=1e-6)
        assert len(found["multipliers"]) == 3


@pytest.mark.parametrize("level", ["light", "rough"])
@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_every_measure_answers_or_says_why_not(env_id: str, level: str) -> None:
    for word in ("open-loop", "lqr"):
        found = measured(subject_of(env_id, level, word, episodes=8, starts=20, decisions=3))
        assert ("sweep" in found) is (level == "light")
        assert ("table_passage" in found) is (word == "open-loop")
        for name, values in found.items():
            assert values["seconds"] >= 0
            if "refused" in values:
                assert name in ("table_passage", "sensitivity") and len(values["refused"]) > 20


def test_episodes_are_those_of_an_evaluation() -> None:
    subject = subject_of(ROUND_FOOT, "rough", "lqr")
    found = measured(subject)["episodes"]
    known = evaluate(subject.controller, ROUND_FOOT, SMALL.episodes, disturbance="rough")
    assert found["strides"] == known.strides.tolist() and found["returns"] == known.returns.tolist()


def test_first_passage_by_walks_and_by_the_table_agree() -> None:
    subject = subject_of(ROUND_FOOT, "light", "open-loop", walks=2000, limit=300, nodes=24)
    walked, known = passage(subject), table_passage(subject)
    assert walked["falls"] == 2000
    assert walked["low"] < walked["mean"] < walked["high"]
    assert walked["low"] < known["mean"] < walked["high"]
    error = 4 * walked["second_eigenvalue_error"] + known["second_eigenvalue_error"]
    assert walked["second_eigenvalue"] == pytest.approx(known["second_eigenvalue"], abs=error)


def test_walks_that_the_limit_cuts_off_count_with_what_they_walked() -> None:
    long, short = (
        passage(subject_of(ROUND_FOOT, "light", "lqr", walks=1500, limit=limit))
        for limit in (1500, 100)
    )
    assert short["falls"] < long["falls"]
    assert short["low"] < long["high"] and long["low"] < short["high"]
    never = passage(subject_of(ROUND_FOOT, "light", "optimal", walks=20, limit=10))
    assert never["falls"] == 0 and never["mean"] is None and never["high"] is None
    assert never["low"] == pytest.approx(200 / -np.log(0.025), rel=1e-9)  # chi squared of 2


def test_a_controller_that_sees_four_numbers_has_no_table() -> None:
    with pytest.raises(ValueError, match=r"by the section's three numbers .* got LQR, which sees"):
        table_passage(subject_of(ROUND_FOOT, "light", "lqr"))


@pytest.mark.slow
def test_the_optimum_has_a_table_of_first_passages() -> None:
    found = table_passage(subject_of(ROUND_FOOT, "rough", "optimal", walks=400))
    assert 5.0 < found["mean"] < 200.0 and found["mean_error"] < found["mean"]


def test_feedback_makes_the_basin_larger_and_the_sensitivity_less() -> None:
    bare, closed = (subject_of(KNEED, "light", word, starts=600) for word in ("open-loop", "lqr"))
    first, second = basin_share(bare), basin_share(closed)
    assert first["low"] < first["share"] < first["high"] < second["low"]
    assert first["volume"] / first["share"] == pytest.approx(second["volume"] / second["share"])
    assert sensitivity(closed)["push"] < sensitivity(bare)["push"]


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_landings_lie_on_the_plane_of_the_starts(env_id: str) -> None:
    subject = subject_of(env_id, "light", "open-loop")
    state, slope = np.array(subject.nominal.state), landing_plane(subject.nominal)
    near = state + 1e-6 * np.random.default_rng(0).normal(size=(50, 4))
    away = StrideMap(subject.task.params, subject.task.control)(near) - state
    assert np.abs(away[:, 1]).max() > 1e-6
    off = away[:, 1] - away @ slope
    assert np.abs(off).max() < 1e-3 * np.abs(away).max()


def test_larger_pushes_fell_sooner() -> None:
    found = sweep(subject_of(KNEED, "light", "lqr", sweep_episodes=60))
    assert found["push"][1] == pytest.approx(0.025)
    assert found["strides"][0] > found["strides"][2] > found["strides"][-1] > 0


def test_a_loop_without_a_gait_is_refused_in_words() -> None:
    mad = FunctionController(lambda seen: np.tile([-1.0, -1.0], (len(seen), 1)))
    found = measured(subject_of(ROUND_FOOT, "light", "ppo", mad, episodes=4, starts=10, walks=10))
    assert found["gait"]["refused"].startswith("no gait of period 1 found for TaskPolicy(motor,")
    assert len(found["gait"]["refused"]) < 300
    assert found["basin"]["share"] is None and 0 <= found["basin"]["walking"] <= 1
    assert found["decision"]["flops"] is None and found["decision"]["microseconds"] > 0


def test_operations_are_counted_by_hand() -> None:
    task = task_of(ROUND_FOOT)
    layers = [(np.zeros((3, 4)), np.zeros(3)), (np.zeros((2, 3)), np.zeros(2))]
    assert flops(OpenLoop()) == 0
    assert flops(LQR(task)) == 2 * 2 * 4
    assert flops(Network(layers)) == (2 * 4 * 3 + 3) + (2 * 3 * 2 + 2)
    assert 73_000 < (flops(load_controller("optimal", task)[1]) or 0) < 80_000  # a table
    ahead = load_controller("optimal", task_of("PoweredWalker-v0"))[1]  # 25 and 25 controls
    assert (flops(ahead) or 0) == 73_000 * (1 + 8 * 50) + 39

    class Counted(FunctionController):
        flops = 7

    assert flops(Counted(lambda seen: seen)) == 7
    assert flops(FunctionController(lambda seen: seen)) is None


def test_decisions_over_a_slice_are_the_controllers() -> None:
    subject = subject_of(ROUND_FOOT, "light", "lqr", slice_points=5)
    found = decided(subject)
    assert found["numbers"] == ["switch angle", "stall torque"]
    scale = subject.task.scale
    angle, rate = found["axis"][1], found["axis"][2]
    apart = landing_plane(subject.nominal) @ [angle * scale[0], 0.0, rate * scale[2], 0.0]
    seen = np.array([[angle, apart / scale[1], rate, 0.0]])
    known = subject.controller.predict(seen)[0][0]
    assert [found["actions"][k][2][1] for k in range(2)] == pytest.approx(known.tolist(), abs=1e-4)
