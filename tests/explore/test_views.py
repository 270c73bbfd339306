"""What the laboratory says of a choice, and the threads that ask it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, GaitNotFoundError
from powered_walker_env.controllers import TaskPolicy, shipped_learners
from powered_walker_env.envs.registration import ENVIRONMENTS
from powered_walker_env.explore import views
from powered_walker_env.explore.aside import Aside, Outdated
from powered_walker_env.explore.choice import Choice, controllers_offered
from powered_walker_env.explore.views import (
    basin_view,
    diagram_view,
    parameters_of,
    prospect,
)
from powered_walker_env.poincare import StrideMap

PATIENCE = 120  # s, for a loaded machine


def nothing() -> None:
    """Nobody asks for anything newer."""


def has_its_pictures(name: str) -> None:
    found = prospect(Choice.of_preset(name))
    assert found.problem == ""
    assert found.gait is not None
    assert found.gait.stable
    np.testing.assert_allclose(found.start, PRESETS[name].state, atol=1e-6)
    basin = basin_view(found, nothing)
    assert 0 < basin.attracted_share < 1
    parameter = (*found.choice.scheme.numbers, "slope")[-1]
    assert parameter in parameters_of(found)
    diagram = diagram_view(found, parameter, nothing)
    assert len(diagram.values) == views.VALUES
    assert diagram.up.walked.any()
    reach = found.choice.reach(parameter)
    assert diagram.values[[0, -1]].tolist() == [reach.low, reach.high]


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_has_its_gait_its_basin_and_its_diagram(name: str, coarse: None) -> None:
    has_its_pictures(name)


def test_one_has_them_in_full() -> None:
    has_its_pictures("round-foot")


def test_a_moved_slider_moves_the_gait_along_its_branch() -> None:
    choice, near = Choice.of_preset("camp1997"), None
    for torque in np.linspace(729.8, 740.0, 12):  # past the period doubling
        found = prospect(choice.replace("stall_torque", float(torque)), near)
        near = found.start
        assert found.gait is not None
        moved = StrideMap(found.choice.params, found.policy)(np.array([found.start]))[0]
        np.testing.assert_allclose(moved, found.start, atol=1e-8)
    assert not found.gait.stable
    assert basin_view(found, nothing).gaits == ()  # it attracts nothing


@pytest.mark.parametrize("name", [n for n, p in PRESETS.items() if p.control is not None])
def test_the_regulator_acts_around_the_present_gait(name: str) -> None:
    choice = Choice.of_preset(name)
    strength = choice.scheme.numbers[-1]
    choice = choice.replace(strength, 1.002 * choice.value(strength))
    free = prospect(choice)
    closed = prospect(choice.decided_by("lqr"))
    assert closed.problem == ""
    assert free.gait is not None and closed.gait is not None
    np.testing.assert_allclose(closed.start, free.start, atol=1e-9)
    assert closed.gait.stable
    assert abs(closed.gait.spectral_radius - free.gait.spectral_radius) > 1e-4
    assert strength in parameters_of(free)
    assert strength not in parameters_of(closed)  # the controller decides it
    assert "slope" in parameters_of(closed)


def test_no_gait_and_no_controller_are_said_and_the_loop_is_open() -> None:
    level = prospect(Choice.of_preset("simplest").replace("slope", 0.0))
    assert level.gait is None
    assert "no gait" in level.problem
    with pytest.raises(GaitNotFoundError):
        basin_view(level, nothing)
    for name, source, words in (
        ("simplest", "lqr", "nothing to decide"),
        ("round-foot", "no/such/file.npz", "file.npz"),
        ("round-foot", "tests.helpers:nobody", "nobody"),
    ):
        choice = Choice.of_preset(name, source)
        found = prospect(choice)
        assert words in found.problem
        assert found.policy == choice.control
        assert found.gait is not None


def linear(observations: Any) -> Any:
    """A controller from outside."""
    return -0.1 * observations[:, [0, 2]]


def test_a_controller_from_outside_is_taken_by_its_path() -> None:
    found = prospect(Choice.of_preset("round-foot", f"{__name__}:linear"))
    assert found.problem == ""
    assert callable(found.policy)


REGISTERED = [preset for preset, _ in ENVIRONMENTS.values()]


@pytest.mark.parametrize("preset", REGISTERED)
def test_what_comes_with_the_package_decides(preset: str) -> None:
    assert controllers_offered()[:3] == ["open-loop", "lqr", "ppo"]
    assert controllers_offered()[-1] == "optimal"
    env_id = next(each for each, (home, _) in ENVIRONMENTS.items() if home == preset)
    missing = set(shipped_learners()) - set(shipped_learners(env_id))
    for name in missing:
        assert f"{name} cannot act: no trained" in prospect(Choice.of_preset(preset, name)).problem
    for name in [each for each in controllers_offered()[2:] if each not in missing]:
        found = prospect(Choice.of_preset(preset, name))
        assert "open loop" not in found.problem
        assert isinstance(found.policy, TaskPolicy)
        if name != "optimal":
            assert found.problem == ""
        if found.gait is not None:
            moved = StrideMap(found.choice.params, found.policy)(np.array([found.start]))[0]
            np.testing.assert_allclose(moved, found.start, atol=1e-7)


def test_a_trained_policy_acts_around_the_gait_of_the_sliders_and_the_optimum_refuses() -> None:
    moved = Choice.of_preset("round-foot").replace("stall_torque", 3400.0)
    acting, refused = (prospect(moved.decided_by(name)) for name in ("ppo", "optimal"))
    assert acting.problem == "" and isinstance(acting.policy, TaskPolicy)
    assert acting.policy.task.control == moved.control
    assert "optimal cannot act: the optimum of this task does not come" in refused.problem
    assert refused.policy == moved.control
    toe_off = prospect(Choice.of_preset("toe-off", "ppo"))
    assert "ppo cannot act: no trained 'ppo' comes with the package" in toe_off.problem
    other = prospect(Choice.of_preset("round-foot").powered_by("hip-torque").decided_by("ppo"))
    assert "ppo cannot act" in other.problem or other.gait is None


def test_pictures_that_the_optimum_cannot_have_say_so() -> None:
    best = prospect(Choice.of_preset("round-foot", "optimal"))
    assert basin_view(best, nothing).attracted_share > 0.3
    with pytest.raises(ValueError, match="the optimum is of this walker alone"):
        diagram_view(best, "slope", nothing)
    ahead = prospect(Choice.of_preset("camp1997", "optimal"))
    with pytest.raises(ValueError, match="looks ahead"):
        basin_view(ahead, nothing)


class Answers:
    """Where answers are handed over, one after another."""

    def __init__(self) -> None:
        self.queue: queue.Queue[Callable[[], None]] = queue.Queue()
        self.taken: list[Any] = []

    def hand_over(self) -> None:
        self.queue.get(timeout=PATIENCE)()


def test_only_the_newest_wish_is_answered() -> None:
    answers, begun, go = Answers(), threading.Event(), threading.Event()
    aside = Aside(answers.queue.put)

    def slow(check: Callable[[], None]) -> str:
        begun.set()
        assert go.wait(PATIENCE)
        check()
        raise AssertionError("this is outdated")

    aside.ask(slow, answers.taken.append)
    assert begun.wait(PATIENCE)
    aside.ask(lambda check: "never begun", answers.taken.append)
    aside.ask(lambda check: "newest", answers.taken.append)
    go.set()
    answers.hand_over()
    assert answers.taken == ["newest"]
    assert answers.queue.empty()
    aside.close()


def test_an_answer_on_its_way_is_dropped_and_a_fault_is_an_answer() -> None:
    answers = Answers()
    aside = Aside(answers.queue.put)

    def fails(check: Callable[[], None]) -> None:
        raise ValueError("no such thing")

    aside.ask(fails, answers.taken.append)
    answers.hand_over()
    assert [str(answer) for answer in answers.taken] == ["no such thing"]
    aside.ask(lambda check: "late", answers.taken.append)
    arrived = answers.queue.get(timeout=PATIENCE)
    aside.forget()
    arrived()
    assert len(answers.taken) == 1
    aside.close()
    aside._thread.join(PATIENCE)
    assert not aside._thread.is_alive()


def test_a_study_that_nobody_wants_any_more_ends() -> None:
    found, looks = prospect(Choice.of_preset("round-foot")), []

    def outdated() -> None:
        looks.append(1)
        raise Outdated

    with pytest.raises(Outdated):
        diagram_view(found, "stall_torque", outdated)
    assert len(looks) == 1
