"""What the site says of the package comes from the package, and says all of it."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import pytest

import powered_walker_env
from powered_walker_env import ENVIRONMENTS, PRESETS, Gait, WalkerParams

pytest.importorskip("matplotlib")
pytest.importorskip("pygame")
pytest.importorskip("stable_baselines3")

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module of `docs/`, by name."""
    monkeypatch.syspath_prepend(str(DOCS))
    yield importlib.import_module
    for name in ("generate", "docstrings"):
        sys.modules.pop(name, None)


def test_every_public_name_has_a_page(beside: Any) -> None:
    generate = beside("generate")
    rooms = generate.documented_in()
    assert set(powered_walker_env.__all__) - {"__version__"} <= set(rooms)
    for room in powered_walker_env._ROOMS:
        assert set(getattr(room, "__all__", ())) <= set(rooms), room.__name__
    for name, room in rooms.items():
        module, _, last = generate.home(room, name).rpartition(".")
        assert last == name
        assert hasattr(importlib.import_module(module), name)


def test_every_environment_has_a_page_with_its_facts(beside: Any) -> None:
    generate = beside("generate")
    pages = "\n".join(page.read_text("utf-8") for page in (DOCS / "environments").glob("*.md"))
    for env_id, (preset, threshold) in ENVIRONMENTS.items():
        assert f"generated/{env_id}.md" in pages
        facts = generate.environment(env_id, preset, threshold)
        control = PRESETS[preset].control
        assert f"{control.stall_torque:g} N m" in facts
        assert f"Solved at return | {threshold:g}" in facts


def test_fields_are_explained_by_their_comments(beside: Any) -> None:
    fields = dict(beside("docstrings").commented_fields(Gait))
    assert fields["step_length"] == "m, of the whole period"
    assert fields["control_jacobian"].endswith("by what is added to them)")  # on the next line
    walker = dict(beside("docstrings").commented_fields(WalkerParams))
    assert list(walker) == ["physics", "knee"]  # of its numbers the docstring itself tells


def test_the_page_of_the_study_is_made_of_what_was_published(beside: Any, tmp_path: Path) -> None:
    study = beside("generate").study
    assert "No results are published" in study(tmp_path)
    rows = [["lqr", "80.1 [79, 81]"], ["ppo", "98"]]
    tables = [{"title": "How long", "header": ["controller", "strides"], "rows": rows}]
    content = {"method": "by bootstrap", "tables": tables}
    (tmp_path / "study.json").write_text(json.dumps(content), encoding="utf-8")
    (tmp_path / "survival-kneed.png").write_bytes(b"")
    text = study(tmp_path)
    assert "### How long" in text and "| lqr | 80.1 [79, 81] |" in text
    assert "![survival, kneed](benchmark/survival-kneed.png)" in text
