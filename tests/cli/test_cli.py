"""The command line, with sensible and with silly arguments."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from powered_walker_env import PRESETS, WalkerParams
from powered_walker_env.cli import main, options
from powered_walker_env.model.powering import CONTROL_NUMBERS, SCHEMES, scheme_of
from powered_walker_env.model.quantities import quantities


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    return capsys.readouterr().out


def test_a_bare_walk_walks_ten_strides(capsys: pytest.CaptureFixture[str]) -> None:
    lines = run(capsys, "walk").splitlines()
    assert len(lines) == 14
    assert lines[0] == "scheme: motor, switch angle 2.9068 rad, stall torque 729.8 N m"
    assert lines[2].split() == ["rad", "rad", "rad/s", "rad/s", "m"]
    assert lines[-1].startswith("walked: ")


def test_a_push_makes_the_walker_fall_and_says_how(capsys: pytest.CaptureFixture[str]) -> None:
    data = json.loads(run(capsys, "walk", "--push", "0.3", "0.3", "--json"))
    assert data["outcome"] != "walked"
    assert data["strides"] == len(data["states"]) - 1 < 10
    assert len(data["heel_strikes_s"]) == data["strides"]  # a fall is no strike
    assert data["heel_strikes_s"] == sorted(data["heel_strikes_s"])


@pytest.mark.parametrize("preset", PRESETS)
def test_a_gait_strikes_once_a_duration(preset: str, capsys: pytest.CaptureFixture[str]) -> None:
    gait = json.loads(run(capsys, "gait", "--preset", preset, "--json"))
    walk = json.loads(run(capsys, "walk", "--preset", preset, "--strides", "3", "--json"))
    expected = [gait["duration_s"] * k for k in (1, 2, 3)]
    assert walk["heel_strikes_s"] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("preset", PRESETS)
def test_gait_prints_the_multipliers_of_a_preset(
    preset: str, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(run(capsys, "gait", "--preset", preset, "--json"))
    assert data["stable"]
    switches = scheme_of(PRESETS[preset].control).switches
    assert len(data["multipliers"]) == (3 if switches else 4)  # of their sections
    assert "stable" in run(capsys, "gait", "--preset", preset)


def test_presets_name_their_source(capsys: pytest.CaptureFixture[str]) -> None:
    text, data = run(capsys, "presets"), json.loads(run(capsys, "presets", "--json"))
    assert "Camp 1997" in text
    assert set(data) == set(PRESETS)
    (line,) = [line for line in text.splitlines() if line.startswith("simplest ")]
    assert line.split() == ["simplest", "passive", "0.009", "rad", "0.5891", "stable"]
    assert data["simplest"]["spectral_radius"] == pytest.approx(0.5891, abs=1e-4)


def test_help_has_every_number_with_its_unit(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("walk", "gait", "branch", "basin", "boundary", "bifurcation"):
        with pytest.raises(SystemExit):
            main([command, "--help"])
        text = "".join(capsys.readouterr().out.split())  # lines break at hyphens, too
        for owner in (WalkerParams, *(scheme.control for scheme in SCHEMES.values())):
            for number in quantities(owner).values() if owner else ():
                assert number.axis.replace(" ", "") in text or number.name in CONTROL_NUMBERS
                assert number.label.replace(" ", "") in text
                assert number.unit.replace(" ", "") in text
    with pytest.raises(SystemExit):
        main(["bifurcation", "--help"])
    assert "1% to either side" in " ".join(capsys.readouterr().out.split())


def test_negative_numbers_are_numbers_however_they_are_written(
    capsys: pytest.CaptureFixture[str],
) -> None:
    told = [
        run(capsys, "walk", "--strides", "2", "--push", written, "0", "--json")
        for written in ("-1e-3", "-0.001", "-.001", "-1E-03")
    ]
    assert len(set(told)) == 1
    pushed = json.loads(told[0])["states"][0][2]
    assert pushed == PRESETS["camp1997"].state.stance_rate - 1e-3
    whole = json.loads(run(capsys, "walk", "--strides", "1", "--push", "-0", "-0e5", "--json"))
    assert whole["states"][0] == list(PRESETS["camp1997"].state)
    slope = ("--parameter", "slope", "--bounds", "-1e-3", "1e-3", "--no-doubled", "--step", "0.2")
    assert json.loads(run(capsys, "branch", *slope, "--json"))["branches"][0]["values"][0] < 0


def test_a_walk_can_be_written_as_an_animation(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(capsys, "walk", "--strides", "1", "--animation", str(tmp_path / "walk.gif"))
    assert (tmp_path / "walk.gif").read_bytes()[:4] == b"GIF8"
    assert main(["walk", "--animation", str(tmp_path / "walk.gif")]) == 2
    assert "choose another --animation, or --overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["walk", "--strides", "0"], 2, "strides must be at least 1"),
        (["walk", "--switch-angle", "7"], 2, r"switch_angle must lie in \(0, 2\*pi\), got 7.0"),
        (["walk", "--stall-torque", "nan"], 2, "stall_torque must be finite"),
        (["walk", "--animation", "walk.xyz"], 2, "gif"),
        (["gait", "--period", "0"], 2, "period must be at least 1"),
        (["gait", "--stall-torque", "1"], 1, "no gait of period 1 found"),
        (["gait", "--set", "wheels=2"], 2, "--set must be NAME=VALUE with NAME one of"),
        (["gait", "--set", "slope"], 2, "--set must be NAME=VALUE"),
        (["gait", "--set", "slope=steep"], 2, "--set slope must be a number, got 'steep'"),
        (["gait", "--set", "slope=2"], 2, "slope must lie in"),
        (["gait", "--set", "physics=magic"], 2, "physics must be 'conserving'"),
        (["gait", "--out", "nowhere/gait"], 2, "folder 'nowhere' does not exist"),
        (["branch", "--bounds", "800", "700"], 2, "--bounds must rise"),
        (["branch", "--bounds", "800", "900"], 2, "bounds must hold the gait's stall_torque"),
        (["branch", "--step", "0"], 2, "step must lie in"),
        (["boundary", "--bounds", "2.9", "2.91", "729", "730"], 1, "no limit of stability"),
        (["boundary", "--parameters", "slope", "slope"], 2, "parameters"),
        (["basin", "--points", "0", "5"], 2, "shape must be two positive numbers"),
        (["basin", "--axes", "stance_angle", "stance_angle"], 2, "axes must be two of"),
        (["basin", "--strides", "0"], 2, "strides must be at least 1"),
        (["basin", "--address", "here:1"], 2, "address must be left out for 'loky'"),
        (["bifurcation", "--points", "1"], 2, "--points must be at least 2"),
        (["bifurcation", "--keep", "1"], 2, "keep must be at least 2"),
        (["branch", "--set", "stall_torque=1"], 1, "no gait of period 1 found"),
    ],
)
def test_silly_arguments_get_one_line_and_a_status(
    arguments: list[str],
    status: int,
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == status
    captured = capsys.readouterr()
    assert not captured.out
    assert captured.err.startswith("powered-walker: ")
    assert captured.err.count("\n") == 1
    assert re.search(message, captured.err)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["boundary", "--step", "nan"], "step must lie in"),
        (["branch", "--step", "-1"], "step must lie in"),
        (["bifurcation", "--jobs", "0"], "jobs must be at least 1"),
        (["basin", "--address", "here:1"], "address must be left out for 'loky'"),
        (["gait", "--out", "gait\0"], "cannot hold a NUL character"),
    ],
)
def test_what_cannot_be_is_refused_before_a_gait_is_looked_for(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(options, "find_gait", lambda *_: pytest.fail("it was looked for"))
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["fly"], ["walk", "--preset", "nobody"]])
def test_unknown_commands_and_presets_are_refused(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert "usage" in capsys.readouterr().err


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--version"])
    assert capsys.readouterr().out.startswith("powered-walker ")
