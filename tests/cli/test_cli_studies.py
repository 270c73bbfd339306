"""The command line's studies: files, JSON, resuming after Ctrl-C, what is refused."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Gait
from powered_walker_env.cli import main
from powered_walker_env.cli.output import Progress
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.sections import section_of
from powered_walker_env.results import load_result, result_info

PUBLISHED = ("--preset", "camp1997-as-published")
BRANCH = ("branch", *PUBLISHED, "--bounds", "690", "735", "--step", "0.05")
BOUNDARY = ("boundary", *PUBLISHED, "--bounds", "2.855", "2.87", "690", "740", "--step", "0.2")
BASIN = ("basin", *PUBLISHED, "--points", "12", "10", "--strides", "30", "--backend", "threading")
RAMPS = (
    "bifurcation", *PUBLISHED, "--bounds", "728", "736", "--points", "5", "--transient", "40",
    "--keep", "4", "--backend", "threading",
)  # fmt: skip
STUDIES = {"gait": ("gait", *PUBLISHED), "branch": BRANCH, "basin": BASIN, "bifurcation": RAMPS}


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    captured = capsys.readouterr()
    assert not captured.err  # no progress where there is no terminal
    return captured.out


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_is_saved_drawn_and_told(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = tmp_path / name
    data = json.loads(run(capsys, *STUDIES[name], "--json", "--out", str(base)))
    assert {Path(file) for file in data["written"]} == set(tmp_path.iterdir())
    suffixes = {path.suffix for path in tmp_path.iterdir()}
    assert suffixes == {".npz", ".png", ".svg", ".csv"}
    assert main([*STUDIES[name], "--out", str(base)]) == 2  # nothing of it is overwritten
    for path in tmp_path.iterdir():  # not even one file of all
        others = [other for other in tmp_path.iterdir() if other != path]
        kept = [(other, other.read_bytes()) for other in others]
        for other in others:
            other.unlink()
        assert main([*STUDIES[name], "--out", str(base)]) == 2
        assert "exists already" in capsys.readouterr().err
        assert [*tmp_path.iterdir()] == [path]
        for other, content in kept:
            other.write_bytes(content)
    assert result_info(f"{base}.npz")["settings"]["preset"] == "camp1997-as-published"
    load_result(f"{base}.npz")


def test_a_branch_tells_its_special_points_to_eight_digits(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = run(capsys, *BRANCH)
    assert "period doubling at 732.198466" in text
    assert "gaits of 2 strides" in text
    data = json.loads(run(capsys, *BRANCH, "--no-doubled", "--json"))
    (branch,) = data["branches"]
    (doubling,) = (p for p in branch["special_points"] if p["kind"] == "period doubling")
    assert doubling["limits_stability"]
    assert branch["stable_ranges"][0][1] == doubling["value"]


def test_what_a_branch_saves_is_the_branch(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(run(capsys, *BRANCH, "--json", "--no-plot", "--out", str(tmp_path / "b")))
    assert [path.name for path in tmp_path.iterdir()] == ["b.npz"]
    first, doubled = load_result(tmp_path / "b.npz")
    assert isinstance(first, Branch)
    assert first.values.tolist() == data["branches"][0]["values"]
    assert doubled.period == 2


def test_a_boundary_goes_through_the_branchs_limit(capsys: pytest.CaptureFixture[str]) -> None:
    data = json.loads(run(capsys, *BOUNDARY, "--json"))
    curves = {curve["kind"]: np.array(curve["values"]) for curve in data["boundaries"]}
    assert len(curves) == len(data["boundaries"])
    x, y = curves["period doubling"].T
    order = np.argsort(x)
    assert np.interp(2.8625, x[order], y[order]) == pytest.approx(732.1985, abs=0.05)


def test_a_gait_is_told_with_its_contact(capsys: pytest.CaptureFixture[str]) -> None:
    text = run(capsys, "gait")
    assert "friction needed" in text
    assert "falls back past its stop" in text
    data = json.loads(run(capsys, "gait", "--json"))
    assert data["contact"]["stop_overrun"] == pytest.approx(0.004, abs=5e-5)
    assert len(data["contact"]["violations"]) == 2


def test_parameters_can_be_set_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changes = ["--set", "stall_torque=730", "--set", "slope=1e-5", "--set", "leg_mass=1001.5"]
    out = ["--no-plot", "--out", str(tmp_path / "gait")]
    run(capsys, "gait", *changes, *out)
    gait: Gait = load_result(tmp_path / "gait.npz")
    assert (gait.params.slope, gait.params.leg_mass) == (1e-5, 1001.5)
    assert gait.control.stall_torque == 730  # type: ignore[union-attr]
    data = json.loads(
        run(capsys, "gait", "--set", "physics=as_published", "--set", "switch_angle=2.8625",
            "--stall-torque", "692", "--json")
    )  # fmt: skip
    assert data["params"]["physics"] == "as_published"
    assert data["control"] == [2.8625, 692.0]


def test_json_has_no_numbers_that_json_does_not_know(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(name: str) -> Any:
        raise AssertionError(name)

    text = run(capsys, *RAMPS, "--json")
    data = json.loads(text, parse_constant=refuse)
    assert data["up"]["periods"][0] == 1


def interrupting(after: int, work: Callable[..., Any]) -> Callable[..., Any]:
    """A function that Ctrl-C hits when it has been called a few times."""
    calls = 0

    def called(*arguments: Any, **_: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls > after:
            raise KeyboardInterrupt
        return work(*arguments)

    return called


def test_an_interrupted_basin_goes_on_where_it_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = "powered_walker_env.poincare.regions.basins"
    monkeypatch.setattr(f"{module}.ROWS", 40)  # three pieces
    out = ("--out", str(tmp_path / "basin"), "--no-plot", "--jobs", "1")
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "__call__", interrupting(1, lambda *_: None))
        assert main([*BASIN, *out]) == 130
    error = capsys.readouterr().err
    assert error == "powered-walker: interrupted; the same command goes on from here\n"
    left = sorted((tmp_path / "basin.unfinished").glob("*.npz"))
    assert 1 <= len(left) < 3
    told: list[tuple[int, int]] = []
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "__call__", lambda _, done, total, __: told.append((done, total)))
        run(capsys, *BASIN, *out)
    assert told[0][0] == len(left) + 1
    assert [path.name for path in tmp_path.iterdir()] == ["basin.npz"]
    resumed = load_result(tmp_path / "basin.npz")
    run(capsys, *BASIN, "--out", str(tmp_path / "whole"), "--no-plot")
    whole = load_result(tmp_path / "whole.npz")
    np.testing.assert_array_equal(resumed.attractor, whole.attractor)
    np.testing.assert_array_equal(resumed.strides, whole.strides)


def test_interruption_is_quiet_and_has_its_status(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "powered_walker_env.cli.studies.continue_gait", interrupting(0, lambda *_: None)
    )
    assert main(BRANCH) == 128 + signal.SIGINT
    assert capsys.readouterr().err == "powered-walker: interrupted\n"


def test_files_are_not_overwritten_unless_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ("gait", "--no-plot", "--out", str(tmp_path / "gait"))
    run(capsys, *out)
    assert main(out) == 2
    assert "exists already; choose another --out, or --overwrite" in capsys.readouterr().err
    run(capsys, *out, "--overwrite")
    (tmp_path / "figures").mkdir()
    assert main(["reproduce", "--out", str(tmp_path / "figures")]) == 2
    assert "exists already" in capsys.readouterr().err


def test_without_matplotlib_plots_are_refused_with_the_remedy_and_results_are_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [
        name for name in sys.modules if name.startswith("powered_walker_env.pictures.charts")
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delattr("powered_walker_env.pictures.charts", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["gait", "--out", str(tmp_path / "gait")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "pip install 'powered-walker-env[render]'" in error
    assert not list(tmp_path.iterdir())
    run(capsys, "gait", "--out", str(tmp_path / "gait"), "--no-plot")
    assert [path.name for path in tmp_path.iterdir()] == ["gait.npz"]


def test_progress_is_for_terminals_and_cleans_up(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Progress("basin") as progress:
        progress(1, 2, 3.0)
    assert not capsys.readouterr().err
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with Progress("basin") as progress:
        progress(1, 2, 3.0)
        progress(2, 2, 0.0)
    error = capsys.readouterr().err
    assert "basin:  50%" in error and "1/2" in error
    assert error.endswith("\r")  # nothing is left of it


def test_the_plane_of_schwab_and_wisse_is_had_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = ("--points", "60", "60", "--strides", "60", "--backend", "threading", "--no-plot")
    out = ("--out", str(tmp_path / "plane"), "--json")
    data = json.loads(run(capsys, "basin", "--slice", "schwab-wisse", *few, *out))
    assert data["ranges"] == [[-0.5, 0.0], [0.0, 0.5]]
    assert 0 < data["attracted_share"] < 0.02  # a thin strip, as they found
    found = load_result(tmp_path / "plane.npz")
    assert found.params.slope == 0.004 and found.params.massless_foot
    np.testing.assert_allclose(found.states[:, 1], -found.states[:, 0], atol=1e-12)


@pytest.mark.parametrize("preset", ["round-foot", "camp1997-as-published", "hip-torque"])
def test_a_basin_is_looked_at_whole(preset: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Without bounds the window holds the gait, and all but strays of what ends on it."""
    few = ("--points", "60", "60", "--backend", "threading", "--json")
    data = json.loads(run(capsys, "basin", "--preset", preset, *few))
    params, control, state, _ = PRESETS[preset]
    on = section_of(params, control).points([state])[0]  # stance angle, stance rate, ...
    for (low, high), value in zip(data["ranges"], on[:2].tolist(), strict=True):
        assert low < value < high
    ends = np.array(data["attractor"]) >= 0
    border = np.concatenate([ends[0], ends[-1], ends[:, 0], ends[:, -1]])
    assert ends.sum() > 30
    assert border.sum() < 0.1 * ends.sum()
