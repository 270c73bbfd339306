"""The page of commands is made, and its commands parse."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from agents import analytic_gradient, evaluate, evolution, train
from agents.study import command
from agents.study.budgets import FULL
from agents.study.cells import cells
from agents.study.commands import command_of, page

README = Path(__file__).parents[3] / "agents" / "README.md"
PARSERS = {
    "agents.analytic_gradient": analytic_gradient.parser,
    "agents.evolution": evolution.parser,
    "agents.evaluate": evaluate.parser,
    "agents.train": train.parser,
    "agents.study": command.parser,
}
COMMANDS = re.findall(r"`(python -m agents\.[^`]*)`", page())


def test_the_page_is_what_is_made() -> None:
    assert README.read_text(encoding="utf-8") == page()


def test_every_row_has_its_command() -> None:
    for cell in cells(FULL):
        if cell.seed == 0:
            assert command_of(cell) in COMMANDS


@pytest.mark.parametrize("text", sorted({" ".join(text.split()) for text in COMMANDS}))
def test_a_command_parses(text: str) -> None:
    python, flag, module, *words = shlex.split(text)
    assert (python, flag) == ("python", "-m")
    if module in PARSERS:
        options = PARSERS[module]().parse_args(words)
        config = getattr(options, "config", None)
        assert config is None or (README.parents[1] / config).is_file()
    else:
        assert (README.parent / f"{module.partition('.')[2]}.py").is_file() and not words
