"""The command line with every scheme."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from powered_walker_env import PRESETS
from powered_walker_env.cli import main
from powered_walker_env.model.powering import scheme_of
from tests.helpers.samples import POWERED

FEW = ("--backend", "threading", "--json")


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0, capsys.readouterr().err
    return capsys.readouterr().out


@pytest.mark.parametrize("preset", POWERED)
def test_a_gait_names_its_scheme_and_its_work(
    preset: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scheme = scheme_of(PRESETS[preset].control)
    text = run(capsys, "gait", "--preset", preset)
    assert f"scheme                            {scheme.name}, " in text
    assert "positive work " in text
    assert ("of electricity" in text) == scheme.moves_ankle
    data = json.loads(run(capsys, "gait", "--preset", preset, "--json"))
    assert data["scheme"] == scheme.name and len(data["control"]) == len(scheme.numbers)
    assert data["positive_work_J"] > 0
    assert (data["electrical_energy_J"] is not None) == scheme.moves_ankle


def test_a_scheme_and_its_numbers_can_be_chosen(capsys: pytest.CaptureFixture[str]) -> None:
    push = ("--scheme", "late-toe-off", "--preset", "toe-off", "--impulse", "0.11")
    late = json.loads(run(capsys, "gait", *push, "--json"))
    assert (late["scheme"], late["control"]) == ("late-toe-off", [0.11])
    stop = json.loads(run(capsys, "gait", "--scheme", "motor-with-stop", "--json"))
    assert stop["control"] == [2.9068, 729.8]  # the preset's numbers
    assert stop["state"] == pytest.approx(PRESETS["motor-with-stop"].state, abs=1e-9)
    hip = ("--preset", "bhounsule-round-feet", "--scheme", "hip-torque", "--set", "slope=0.005")
    numbers = ("--switch-angle", "3.1", "--hip-torque", "0.01")
    pulled = json.loads(run(capsys, "gait", *hip, *numbers, "--json"))
    assert pulled["control"] == [3.1, 0.01] and pulled["params"]["slope"] == 0.005
    off = ("--preset", "toe-off", "--scheme", "passive", "--set", "slope=0.01", "--json")
    assert json.loads(run(capsys, "gait", *off))["control"] is None


def test_every_study_takes_the_toe_off_walker(capsys: pytest.CaptureFixture[str]) -> None:
    walker = ("--preset", "toe-off")
    walked = run(capsys, "walk", *walker, "--strides", "2")
    assert walked.startswith("scheme: toe-off, impulse 0.1\n")
    branch = json.loads(run(capsys, "branch", *walker, "--step", "0.2", "--json"))
    assert branch["branches"][0]["parameter"] == "impulse"
    ramps = ("--points", "3", "--transient", "2", "--keep", "4")
    assert json.loads(run(capsys, "bifurcation", *walker, *ramps, *FEW))["parameter"] == "impulse"
    points = ("--points", "3", "3", "--strides", "10")
    assert json.loads(run(capsys, "basin", *walker, *points, *FEW))["points"] == [3, 3]


def test_the_hip_walkers_stability_ends_somewhere(capsys: pytest.CaptureFixture[str]) -> None:
    bounds = ("--bounds", "3.05", "3.15", "0.01", "0.15", "--step", "0.2", "--json")
    data = json.loads(run(capsys, "boundary", "--preset", "hip-torque", *bounds))
    assert data["boundaries"][0]["parameters"] == ["switch_angle", "hip_torque"]


def test_presets_show_their_schemes(capsys: pytest.CaptureFixture[str]) -> None:
    text, data = run(capsys, "presets"), json.loads(run(capsys, "presets", "--json"))
    for name, preset in PRESETS.items():
        assert data[name]["scheme"] == scheme_of(preset.control).name
        (line,) = [line for line in text.splitlines() if line.startswith(f"{name} ")]
        assert line.split()[1] == data[name]["scheme"]


def test_a_stopped_gait_is_drawn_with_its_motor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    run(capsys, "gait", "--preset", "motor-with-stop", "--out", str(tmp_path / "gait"))
    assert (tmp_path / "gait.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["gait", "--scheme", "toe-off"], "--impulse must be given for --scheme toe-off"),
        (["gait", "--impulse", "0.1"], "--scheme motor has no impulse"),
        (["walk", "--preset", "toe-off", "--stall-torque", "1"], "toe-off has no stall_torque"),
        (["walk", "--scheme", "passive", "--switch-angle", "3"], "passive has no switch_angle"),
        (["walk", "--preset", "toe-off", "--impulse", "-1"], "impulse must not be negative"),
        (["walk", "--preset", "toe-off", "--scheme", "motor"], "--switch-angle must be given"),
        (
            ["walk", "--preset", "compass", "--scheme", "motor", "--switch-angle", "3",
             "--stall-torque", "1"],
            "foot_length must be positive for a powered walker",
        ),
        (["branch", "--preset", "toe-off", "--parameter", "stall_torque"], "must not be 'stall"),
        (["gait", "--preset", "hip-torque", "--out", "gait"], "add --no-plot"),
        (["gait", "--preset", "hip-torque", "--set", "impulse=1"], "hip-torque has no impulse"),
    ],
)  # fmt: skip
def test_silly_combinations_get_one_line_and_status_2(
    arguments: list[str], message: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert not list(tmp_path.iterdir())
