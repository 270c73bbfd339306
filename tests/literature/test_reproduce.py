"""The thesis's figures: published numbers, onsets by other means, files and refusals."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import walk
from powered_walker_env.literature import report_text, reproduce
from powered_walker_env.literature.figures.figure5 import Figure5, figure_5
from powered_walker_env.literature.figures.statements import statements
from powered_walker_env.literature.figures.studies import (
    SETTINGS,
    Figure6,
    control_of,
    figure_4,
    figure_6,
    torque_of,
    upper_part,
)
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING
from powered_walker_env.poincare.energy.contact import contact_of
from tests.helpers.published import limit_cycle

BY_PHYSICS = {setting.physics: setting for setting in SETTINGS}
NODES = 40  # of the search: 0.61 is nearby
FIGURE_5 = {  # what is solved for the multiplier that its caption gives
    "figure 5, on the branch of figure 6": "stall torque",
    "figure 5, at another switch angle": "switch angle",
}


@cache
def six(physics: str) -> Figure6:
    return figure_6(BY_PHYSICS[physics], figure_4(BY_PHYSICS[physics]))


@cache
def five(physics: str) -> Figure5:
    return figure_5(six(physics), NODES, lambda: None)


def test_figure_6_has_the_published_24_gaits_and_agrees_with_the_independent_code() -> None:
    figure = six(AS_PUBLISHED)
    assert len(figure.gaits) == 24
    assert (figure.stall_torques[0], figure.stall_torques[-1]) == (692.0, 760.0)
    at = upper_part(figure.gait, figure.branch)
    for torque in (692.0, 725.0, 732.0):
        expected = limit_cycle(AS_PUBLISHED, torque).spectral_radius
        assert at(torque).spectral_radius == pytest.approx(expected, abs=1e-6)
    assert at(732.0).spectral_radius < 1 < at(732.4).spectral_radius


@pytest.mark.parametrize(
    ("physics", "low", "high"),
    [(AS_PUBLISHED, 688.7991, 732.198466), (CONSERVING, 727.842648, 733.346357)],
)
def test_windows_of_stability(physics: str, low: float, high: float) -> None:
    assert six(physics).stable_range == pytest.approx((low, high), abs=1e-4)
    assert six(physics).doubling.value == pytest.approx(high, abs=1e-5)
    assert six(physics).doubled.period == 2


@pytest.mark.parametrize("physics", BY_PHYSICS)
def test_below_the_onset_the_foot_passes_its_stop_and_above_it_does_not(physics: str) -> None:
    figure = six(physics)
    onset = figure.falling_back
    assert onset is not None
    at = upper_part(figure.gait, figure.branch)
    width = 1e-2 * (figure.stable_range[1] - figure.stable_range[0])
    assert contact_of(at(onset.stall_torque - width)).falls_back
    assert not contact_of(at(onset.stall_torque + width)).falls_back
    assert onset.radius == pytest.approx(at(onset.stall_torque).spectral_radius)


@pytest.mark.parametrize("physics", BY_PHYSICS)
def test_figure_5_is_a_stable_gait_of_0_61_whose_foot_turns(physics: str) -> None:
    found = five(physics).on_branch
    assert found.gait.spectral_radius == pytest.approx(0.61, abs=1e-6)
    assert control_of(found.gait).switch_angle == control_of(six(physics).gait).switch_angle
    gait = found.gait
    walked = walk(gait.state, control_of(gait), gait.params, 1, sample_interval=1e-3)
    foot = walked.q[walked.phase == 1, 1] - gait.params.locked_ankle_angle
    assert foot.max() == pytest.approx(found.overrun, abs=1e-5)
    assert foot.max() > 1e-3
    assert foot[-1] < 0


def test_a_foot_that_rises_and_falls_more_than_once_walks_stably_at_0_61() -> None:
    found = five(AS_PUBLISHED).at_torque
    assert found is not None
    assert found.reversals == 3
    assert found.gait.spectral_radius == pytest.approx(0.61, abs=1e-6)
    assert torque_of(found.gait) == 692.0
    assert five(AS_PUBLISHED).drawn is found


@pytest.mark.parametrize("physics", BY_PHYSICS)
def test_statements_carry_their_numbers(physics: str) -> None:
    found = {s.topic: s for s in statements(six(physics), five(physics))}
    assert found["period doubling"].holds
    assert found["figure 5, on the branch of figure 6"].holds
    solved = {s.topic: s.numbers.get("solved_for_it", "") for s in found.values()}
    for topic, number in solved.items():
        assert number == FIGURE_5.get(topic, "")
        assert ("by construction" in found[topic].found) == bool(number)
    assert found["foot at heel strike"].holds
    assert found["which way first"].holds
    assert found["figure 4"].holds is (True if physics == AS_PUBLISHED else None)
    assert found["figure 6"].numbers["radii"][0] == six(physics).radii[0]


@cache
def reproduced(folder: Path) -> tuple[dict[str, Any], list[tuple[int, int, float]]]:
    """A whole run, with the studies of the tests above put in place of its own."""
    seen: list[tuple[int, int, float]] = []
    module = "powered_walker_env.literature.figures"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(f"{module}.figure_6", lambda setting, _: six(setting.physics))
        patch.setattr(f"{module}.figure_5", lambda figure, *_: five(figure.setting.physics))
        report = reproduce(folder, progress=lambda *state: seen.append(state))
    return report, seen


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("thesis") / "reproduce"
    target.with_name(".reproduce.part").mkdir()  # as a killed run leaves it
    reproduced(target)
    return target


def test_every_figure_is_there_in_both_physics_and_three_formats(folder: Path) -> None:
    names = {path.name for path in folder.iterdir()}
    for physics in ("as-published", "conserving"):
        for figure in ("figure4", "figure5", "figure6", "branch"):
            assert {f"{figure}-{physics}.{s}" for s in ("png", "svg", "csv")} <= names
    assert {"report.txt", "report.json"} <= names
    assert [path.name for path in folder.parent.iterdir()] == ["reproduce"]


def test_the_report_is_on_disk_as_returned(folder: Path) -> None:
    report, _ = reproduced(folder)
    stored = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    assert stored == json.loads(json.dumps(report))
    text = (folder / "report.txt").read_text(encoding="utf-8")
    assert text == report_text(report)
    assert "0.6546" in text
    assert "732.198466" in text
    assert "does not hold" not in text


def test_progress_runs_from_nothing_to_everything(folder: Path) -> None:
    _, seen = reproduced(folder)
    done = [state[0] for state in seen]
    assert done == sorted(done)
    assert done[-1] == seen[-1][1]
    assert seen[-1][2] == 0


def test_figure_6_data_are_the_24_gaits(folder: Path) -> None:
    rows = np.loadtxt(folder / "figure6-as-published-samples.csv", delimiter=",", skiprows=1)
    assert rows.shape == (24, 2)
    assert rows[0] == pytest.approx([692.0, 0.654577], abs=1e-6)


def test_an_existing_folder_is_refused_and_an_interruption_leaves_nothing(
    folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(FileExistsError, match="exists already; choose another or overwrite"):
        reproduce(folder)
    (tmp_path / "file").write_text("")
    with pytest.raises(FileExistsError, match="is not a folder"):
        reproduce(tmp_path / "file", overwrite=True)

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path / "new", nodes=2, progress=interrupt)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_folder_that_cannot_be_made_is_said_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    worked: list[tuple[int, int, float]] = []
    with pytest.raises(OSError, match="file"):
        reproduce(tmp_path / "file" / "again", progress=lambda *state: worked.append(state))
    assert not worked
