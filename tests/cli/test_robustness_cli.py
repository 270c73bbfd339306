"""The commands about robustness, with every walker."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from powered_walker_env import PRESETS, load_result
from powered_walker_env.cli import main
from tests.helpers.samples import POWERED

SMALL = {
    "sensitivity": (),
    "lyapunov": ("--strides", "40", "--transient", "5"),
    "volume": ("--samples", "60", "--strides", "20", "--backend", "threading"),
    "largest": ("--strides", "20"),
    "passage": ("--nodes", "6", "--walks", "600"),
}


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0, capsys.readouterr().err
    return capsys.readouterr().out


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("command", SMALL)
def test_every_command_takes_every_walker_and_saves(
    command: str, preset: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if command == "passage" and preset == "kneed":
        pytest.skip("a motor's section is a hip angle, which walkers with knees have not")
    plot = ("--no-plot",) if command == "passage" else ()
    out = ("--json", "--out", str(tmp_path / "x"), *plot)
    data = json.loads(run(capsys, command, "--preset", preset, *SMALL[command], *out))
    assert {Path(file) for file in data["written"]} == set(tmp_path.iterdir())
    assert load_result(tmp_path / "x.npz") is not None


@pytest.mark.parametrize("preset", [name for name in POWERED if name != "kneed"])
def test_viability_takes_every_powered_walker(
    preset: str, capsys: pytest.CaptureFixture[str]
) -> None:
    small = ("--nodes", "5", "--controls", "3", "--strides", "3")
    data = json.loads(run(capsys, "viability", "--preset", preset, *small, "--json"))
    assert 0.0 <= data["saved"] <= data["possible"] <= 1.0


def test_passages_and_kernels_are_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    noise = ("--step-height", "0.004", "--nodes", "8", "--walks", "600")
    run(capsys, "passage", "--preset", "compass", *noise, "--out", str(tmp_path / "p"))
    text = run(capsys, "viability", "--preset", "round-foot", "--nodes", "6", "--controls", "3",
               "--out", str(tmp_path / "v"))  # fmt: skip
    assert "left open by the grid" in text and "hip angle 2.854 rad" in text
    for name in "pv":
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    rows = np.genfromtxt(tmp_path / "v.csv", delimiter=",", names=True)
    assert set(np.unique(rows["fate"])) <= {-1.0, 0.0, 1.0}


def test_a_volume_says_where_it_was_measured(capsys: pytest.CaptureFixture[str]) -> None:
    box = ("--low", "-0.5", "0", "-0.5", "--high", "0", "2", "1.5")
    few = ("--samples", "200", "--backend", "threading")
    text = run(capsys, "volume", "--preset", "compass", *box, *few)
    assert "both feet on the floor" in text
    assert "hip angle 2.704 rad" in run(capsys, "volume", "--preset", "round-foot", *few)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["viability", "--preset", "compass"], "a constant control"),
        (["viability", "--preset", "kneed"], "params must have no knee"),
        (["passage", "--preset", "kneed"], "params must have no knee"),
        (["viability", "--half-range", "0.1"], "half_range must be 2 positive numbers"),
        (["passage", "--nodes", "2"], "--nodes must be at least 6"),
        (["passage", "--push", "-1"], "push must not be negative"),
        (["passage", "--preset", "hip-torque", "--step-height", "0.001"], "level ground"),
        (["lyapunov", "--strides", "3"], "--strides must be at least 40"),
        (["volume", "--low", "1"], "low and high must be given both"),
        (["largest", "--strides", "0"], "strides must be at least 1"),
    ],
)
def test_silly_arguments_get_one_line_and_status_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
