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
from powered_walker_env.controllers import optimal

pytest.importorskip("matplotlib")
pytest.importorskip("pygame")
pytest.importorskip("stable_baselines3")

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module of `docs/`, by name."""
    monkeypatch.syspath_prepend(str(DOCS))
    yield importlib.import_module
    for name in ("generate", "docstrings", "study_pages", "tabulated"):
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


def a_row(controller: str, level: str = "light", **more: Any) -> dict[str, Any]:
    """Of a study, as JSON has it."""
    row = {"env_id": "PoweredWalkerRoundFoot-v0", "level": level, "controller": controller,
           "runs": 1, "strides": [81.2, 79.6, 83.1], "returns": [79.0, 77.4, 80.9],
           "score": None}  # fmt: skip
    return row | more


def test_the_baselines_of_an_environment_are_the_study_s(
    beside: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    baselines = beside("study_pages").baselines
    env_id = "PoweredWalkerRoundFoot-v0"
    missing = baselines(env_id, tmp_path)
    assert "The control study is not published with this version" in missing
    assert "| controller |" not in missing
    for text in (missing, baselines("PoweredWalker-v0", tmp_path)):
        assert "### Light pushes" in text and "### Rough pushes" in text
    assert "The optimum is resolved: **97.4 ± 0.2**" in missing
    thesis = baselines("PoweredWalker-v0", tmp_path)
    assert "The optimum is resolved: **59.3 ± 1.7**" in thesis
    as_published = baselines("PoweredWalkerAsPublished-v1", tmp_path)
    assert "The optimum is not resolved. Best known: **" in as_published
    monkeypatch.setattr(optimal, "SHIPPED", ())
    without = baselines("PoweredWalker-v0", tmp_path)
    assert "The optimum is not known here, and no table comes with the package" in without
    monkeypatch.undo()
    rows = [
        a_row("lqr", score=[0.79, 0.77, 0.81]),
        a_row("ppo", runs=5),
        a_row("deadbeat", "rough", runs=0, strides=None, returns=None),
        a_row("tuned-open-loop", "rough"),
        a_row("open-loop", env_id="PoweredWalker-v0"),
    ]
    (tmp_path / "study.json").write_text(json.dumps({"rows": rows}), encoding="utf-8")
    text = baselines(env_id, tmp_path)
    assert "| lqr | 81.2 [79.6, 83.1] | 79.0 [77.4, 80.9] | 0.790 [0.770, 0.810] |" in text
    assert "| ppo (5 seeds) | 81.2 [79.6, 83.1] | 79.0 [77.4, 80.9] | – |" in text
    assert "| tuned-open-loop | 81.2 [79.6, 83.1] | 79.0 [77.4, 80.9] |\n" in text  # no score
    assert "| open-loop" not in text and "{doc}`../benchmark` (deadbeat)" in text
    assert "python -m agents.train --algo ppo --env PoweredWalkerRoundFoot-v0 --seed 0" in text
    assert "agents.analytic_gradient" not in text
    for page in (DOCS / "environments").glob("*.md"):
        words = page.read_text("utf-8")
        if "generated/PoweredWalker" in words:
            assert words.count("-baselines.md") == 1
