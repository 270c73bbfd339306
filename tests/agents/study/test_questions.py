"""The commands behind the question pages, on small sizes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from agents.study import geometry, ladder, viability
from agents.study.asking import answered
from agents.study.viability_figure import kernel_figure, marks_of
from powered_walker_env import ENVIRONMENTS, find_gait
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.poincare import StrideMap

ROUND_FOOT = "PoweredWalkerRoundFoot-v0"
SMALL = {"starts": 60, "points": 7, "grid": 3, "width": 4, "depth": 5}


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_kernels_hold_every_basin(env_id: str, tmp_path: Path) -> None:
    found = viability.saved_and_kept(env_id, tmp_path, **SMALL)  # type: ignore[arg-type]
    low, high = found["kernel"]
    assert 0.0 < low <= high <= 1.0 and set(found["kept"]) == {"open-loop", "lqr", "optimal"}
    assert all(share <= low for share in found["kept"].values())
    assert all(0.0 <= a <= b <= 1.0 for a, b in found["of_kernel"].values())
    plane = found["plane"]
    middle = marks_of(plane, "lqr")[3, 3]  # the gait itself
    assert middle and marks_of(plane, "saved")[3, 3]
    drawing = kernel_figure({env_id: json.loads(json.dumps(found))})
    assert len(drawing.figure.axes) == 4
    assert sum(len(axes.images) for axes in drawing.figure.axes) == 3  # there is no network


def test_shares_are_counted_by_hand() -> None:
    def marks(text: str) -> np.ndarray:
        return np.array([each == "1" for each in text])

    found = viability.shares({
        "saved": marks("110000"), "lost": marks("000011"), "lqr": marks("101000"),
        "open-loop": marks("100010"),
    })  # fmt: skip
    assert found["kernel"] == pytest.approx([4 / 6, 5 / 6])  # kept by any: saved
    assert found["refuted"] == 1
    assert found["of_kernel"]["lqr"] == pytest.approx([2 / 5, 2 / 4])


def test_starts_lie_where_strides_land() -> None:
    task = task_of(ROUND_FOOT)
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    near = gait.states[0] + 1e-6 * np.random.default_rng(0).normal(size=(30, 4))
    ends = StrideMap(task.params, task.control)(near)
    assert np.abs(ends - gait.states[0]).max() > 1e-7
    assert np.abs(viability.landed(gait, ends) - ends).max() < 1e-9


def test_rungs_and_bodies_are_answered_and_kept(tmp_path: Path) -> None:
    answered(tmp_path, "x.json", [ROUND_FOOT], lambda env_id: {"is": env_id})
    found = answered(tmp_path, "x.json", ["PoweredWalker-v0"], lambda env_id: {"is": env_id})
    assert list(found) == ["PoweredWalker-v0", ROUND_FOOT]
    assert json.loads((tmp_path / "x.json").read_text("utf-8")) == found
    (tmp_path / "x.json").write_text("[]", "utf-8")
    with pytest.raises(ValueError, match="must hold answers by id"):
        answered(tmp_path, "x.json", [ROUND_FOOT], lambda env_id: {})


@pytest.mark.slow
def test_a_body_is_walked_under_the_same_pushes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(geometry, "WALKS", 200)
    found = geometry.body("PoweredWalkerAsPublished-v1")
    assert found["norm"]["tuned"] < found["norm"]["own"]
    own, tuned = found["walked"]["own"], found["walked"]["tuned"]
    assert own["falls"] == 200 and own["mean_first_passage"] == own["walked"] / 200
    assert tuned["falls"] == 0 and tuned["mean_first_passage"] is None
    assert set(found["changed"]) == set(geometry.GEOMETRY)


@pytest.mark.slow
def test_every_rung_is_there() -> None:
    found = ladder.rungs(ROUND_FOOT)
    assert len(found["pairs"]) == 8 and len(found["subsets"]) == 16
    assert found["deadbeat"]["strides"] == 2
    json.dumps(found, allow_nan=False)
