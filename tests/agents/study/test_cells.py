"""What the study compares, and in which order."""

from __future__ import annotations

import pytest

from agents.study.budgets import FULL, SMALL
from agents.study.cells import (
    CONTROLLERS,
    LEARNERS,
    LEFT_OUT,
    LEVELS,
    Cell,
    cells,
    chosen,
    left_out,
)
from powered_walker_env import ENVIRONMENTS


def test_every_cell_is_there_once_or_declared_left_out() -> None:
    every = cells(FULL)
    names = [cell.name for cell in every]
    assert len(set(names)) == len(names)
    for env_id in ENVIRONMENTS:
        for level in LEVELS:
            for controller in CONTROLLERS:
                assert Cell(env_id, level, controller) in every
            for learner in LEARNERS:
                for seed in range(5):
                    cell = Cell(env_id, level, learner, seed)
                    assert (cell in every) is (left_out(cell) == "")
    assert all(group.reason for group in LEFT_OUT)


def test_the_cheap_ones_come_first() -> None:
    every = cells(FULL)
    learning = [cell.learns for cell in every]
    assert learning == sorted(learning)
    first = [cell for cell in every if cell.learns][:4]
    assert {cell.env_id for cell in first} == set(ENVIRONMENTS)
    assert {(cell.controller, cell.level) for cell in first} == {("ppo", "light")}


def test_some_are_chosen_by_parts_of_their_names() -> None:
    every = cells(SMALL)
    some = chosen(every, ["Kneed-v0-rough-ppo"])
    assert [cell.name for cell in some] == [
        "PoweredWalkerKneed-v0-rough-ppo-0",
        "PoweredWalkerKneed-v0-rough-ppo-1",
    ]
    assert chosen(every, None) == every
    with pytest.raises(ValueError, match=r"--only must be part of a cell's name, .* got 'ppq'"):
        chosen(every, ["ppo", "ppq"])


def test_slow_controllers_walk_less_but_meet_the_same_episodes() -> None:
    slow = FULL.of("look-ahead-3")
    assert slow.walks == FULL.walks // 25 and slow.starts == FULL.starts // 25
    assert slow.episodes == FULL.episodes and slow.limit == FULL.limit
    assert FULL.of("lqr") == FULL and set(FULL.slow) <= set(CONTROLLERS)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (("X-v0", "medium", "ppo", 0), "level must be one of light, rough, got 'medium'"),
        (("X-v0", "light", "dqn", 0), "controller must be one of open-loop, .* got 'dqn'"),
        (("X-v0", "light", "ppo", -1), "seed must be an integer of at least 0, got -1"),
    ],
)
def test_cells_that_cannot_be_are_refused(values: tuple[str, str, str, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Cell(*values)


def test_a_level_is_the_environments_own_or_an_argument() -> None:
    assert Cell("X-v0", "light", "ppo").env_kwargs == {}
    assert Cell("X-v0", "rough", "ppo").env_kwargs == {"disturbance": "rough"}
