"""The pages of the thesis's questions: their numbers are those of the files, their words true."""

from __future__ import annotations

import importlib
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from powered_walker_env import ENVIRONMENTS

pytest.importorskip("matplotlib")
pytest.importorskip("pygame")
pytest.importorskip("stable_baselines3")

DOCS = Path(__file__).parents[2] / "docs"
QUESTIONS, STUDY = DOCS / "questions", DOCS / "benchmark" / "study.json"
PAGES = ("simplest", "stable", "computation")
MODULES = ("answers", "answer_tables", "answer_words", "answer_figures", "study_rows", "generate")
LIGHT, ROUGH = "light", "rough"
THESIS, ROUND, PUBLISHED, KNEED = ENVIRONMENTS


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module of `docs/`, by name."""
    monkeypatch.syspath_prepend(str(DOCS))
    yield importlib.import_module
    for name in MODULES:
        sys.modules.pop(name, None)


def read(name: str) -> Any:
    return json.loads((QUESTIONS / f"{name}.json").read_text("utf-8"))


def made_up() -> dict[str, Any]:
    """A study of no walker: strides 10 more for each controller, every number told apart."""
    names = ["open-loop", "tuned-open-loop", "trial-open-loop", "one-number", "numbers-1",
             "numbers-2", "numbers-3", "lqr", "look-ahead-3", "ppo", "optimal"]  # fmt: skip
    rows = []
    for i, env_id in enumerate(ENVIRONMENTS):
        for level in (LIGHT, ROUGH):
            for j, name in enumerate(names):
                strides = 3.0 + 8.1 * j + 0.3 * i + (0.05 if level == ROUGH else 0.0)
                never = name == "optimal"
                medians = {
                    "mean_first_passage": None if never else 2.0 * strides,
                    "at_least": 1.9 * strides, "spectral_radius": 0.9 - 0.05 * j,
                    "flops": float(10**j), "basin": 0.1,
                }  # fmt: skip
                rows.append({
                    "env_id": env_id, "level": level, "controller": name, "runs": 1,
                    "strides": [strides, strides - 1, strides + 1],
                    "returns": [strides, strides, strides],
                    "score": [j / 10, j / 10 - 0.01, j / 10 + 0.01],
                    "medians": medians, "having": {}, "refused": {},
                })  # fmt: skip
    return {"rows": rows, "tables": [], "method": ""}


def test_all_walkers_are_answered_and_hardly_a_start_refutes_the_search() -> None:
    for name in ("ladder", "geometry", "viability"):
        assert list(read(name)) == list(ENVIRONMENTS)
    for answer in read("viability").values():
        low, high = answer["kernel"]
        assert answer["refuted"] <= 0.002 * answer["starts"] and 0.0 < low <= high < 1.0
        assert set(answer["kept"]) == {"open-loop", "lqr", "ppo", "optimal"}
        for name, share in answer["kept"].items():
            assert answer["of_kernel"][name] == pytest.approx([share / high, share / low])


def test_pages_include_what_is_written_and_say_where_it_comes_from(
    beside: Any, tmp_path: Path
) -> None:
    answers = beside("answers")
    (tmp_path / "benchmark").mkdir()
    (tmp_path / "generated").mkdir()
    (tmp_path / "questions").symlink_to(QUESTIONS)
    (tmp_path / "benchmark" / "study.json").write_text(json.dumps(made_up()), "utf-8")
    answers.answers(tmp_path / "generated", tmp_path)
    included = set()
    for page in PAGES:
        text = (QUESTIONS / f"{page}.md").read_text("utf-8")
        fragments = re.findall(r"\{include\} \.\./generated/([\w-]+)\.md", text)
        assert fragments[0] == f"{page}-answer" and len(fragments) > 2
        assert "python -m agents" in text and "## What it does not show" in text
        assert text.count("\n") <= 120
        included |= set(fragments)
    written = {path.stem for path in (tmp_path / "generated").glob("*.md")}
    assert written == included
    for name in included:
        text = (tmp_path / "generated" / f"{name}.md").read_text("utf-8")
        assert answers.MISSING not in text and "None" not in text and "nan" not in text
    for name in ("ladder.png", "cost.png"):
        assert (tmp_path / "generated" / name).stat().st_size > 10_000


def test_numbers_are_those_of_the_study(beside: Any, tmp_path: Path) -> None:
    words, tables, rows = beside("answer_words"), beside("answer_tables"), beside("study_rows")
    path = tmp_path / "study.json"
    path.write_text(json.dumps(made_up()), "utf-8")
    study = rows.Study(path)
    assert "| 4 numbers (LQR) | `lqr` | 59.7, 0.70 | 60.0, 0.70 |" in tables.ladder(study)
    assert "of 100 strides these walk 3, 3, 4 and 4." in words.simplest(study, read("ladder"))
    assert "none (19 of 60)" not in words.simplest(study, read("ladder"))
    assert "with knees four (61 of 61)" in words.simplest(study, read("ladder"))
    assert "> 160" in tables.lasting(study)  # no fall: a lower bound
    assert "round feet (light) `ppo` has 0.90 of it" in words.stable(study, read("viability"))
    front = tables.fronts(study)
    assert all(f"`{name}`" in front for name in ("open-loop", "tuned-open-loop", "one-number"))


def test_without_a_study_pages_say_how_to_make_one(beside: Any, tmp_path: Path) -> None:
    answers = beside("answers")
    (tmp_path / "generated").mkdir()
    answers.answers(tmp_path / "generated", tmp_path)
    texts = {path.stem: path.read_text("utf-8") for path in (tmp_path / "generated").glob("*.md")}
    assert texts["ladder"] == texts["kernels"] == texts["simplest-answer"] == answers.MISSING
    assert "resolved" in texts["optima"]  # the package's own tables
    assert not list((tmp_path / "generated").glob("*.png"))


def test_what_the_pages_say_in_words_is_so() -> None:
    geometry, ladder = read("geometry"), read("ladder")
    shares = read("viability")[ROUND]["of_kernel"]
    assert shares["ppo"][0] > shares["optimal"][1] > shares["lqr"][0] > shares["open-loop"][1]
    for env_id in (THESIS, PUBLISHED):
        assert geometry[env_id]["walked"]["tuned"]["falls"] == 0
    strides = {env_id: [each["walked"][name]["strides"] for name in ("own", "tuned")]
               for env_id, each in geometry.items()}  # fmt: skip
    assert strides[ROUND][0] < strides[ROUND][1] < 1.5 * strides[ROUND][0]
    assert strides[KNEED][1] < strides[KNEED][0]
    assert geometry[KNEED]["norm"]["tuned"] < geometry[KNEED]["norm"]["own"]
    for answer in ladder.values():
        assert answer["deadbeat"]["strides"] == 2 and answer["deadbeat"]["rank"] == 3
    pairs = {(row["number"], row["action"]): row["strides"] for row in ladder[THESIS]["pairs"]}
    by_angle = [walked for (_, action), walked in pairs.items() if action == "switch_angle"]
    by_torque = [walked for (_, action), walked in pairs.items() if action == "stall_torque"]
    assert min(by_angle) > 1.5 * max(by_torque)
    best = max(ladder[ROUND]["pairs"], key=lambda row: row["strides"])
    alone = {row["numbers"][0]: row["strides"] for row in ladder[ROUND]["subsets"]
             if len(row["numbers"]) == 1}  # fmt: skip
    assert best["number"] == "stance_rate" == max(alone, key=lambda name: alone[name])
    assert alone["stance_rate"] > 2.0 * best["strides"]
    for env_id in (PUBLISHED, KNEED):
        none = next(row["strides"] for row in ladder[env_id]["subsets"] if not row["numbers"])
        assert max(row["strides"] for row in ladder[env_id]["pairs"]) < 1.25 * none


def test_what_the_pages_say_of_the_study_is_so(beside: Any) -> None:
    if not STUDY.is_file():
        pytest.skip("no study is published with this version")
    study = beside("study_rows").Study(STUDY)

    def strides(env_id: str, name: str) -> float:
        found = study.value(env_id, LIGHT, name, "strides")
        assert isinstance(found, float)
        return found

    assert strides(THESIS, "trial-open-loop") > strides(THESIS, "lqr")
    assert strides(THESIS, "tuned-open-loop") < 0.5 * strides(THESIS, "trial-open-loop")
    assert strides(ROUND, "numbers-2") > 0.95 * strides(ROUND, "lqr")
    basins = [
        study.value(THESIS, LIGHT, name, "basin") for name in ("open-loop", "trial-open-loop")
    ]
    assert basins[0] < basins[1]
    lasts = {(env_id, name): study.lasts(env_id, LIGHT, name)[0] for env_id in ENVIRONMENTS
             for name in ("ppo", "look-ahead-1", "lqr", "deadbeat", "open-loop")}  # fmt: skip
    for env_id in ENVIRONMENTS:
        assert lasts[env_id, "ppo"] > max(lasts[env_id, "look-ahead-1"], lasts[env_id, "lqr"])
        assert study.value(env_id, LIGHT, "open-loop", "spectral_radius") < 1.0
        assert study.value(env_id, LIGHT, "deadbeat", "spectral_radius") < 1e-3
    assert lasts[THESIS, "deadbeat"] < lasts[THESIS, "open-loop"]
