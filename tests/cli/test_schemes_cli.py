"""The command line with every scheme."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from powered_walker_env import PRESETS
from powered_walker_env.cli import main
from powered_walker_env.model.powering import SCHEMES, scheme_of
from tests.helpers.samples import POWERED


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


#: Every study of a walker, small.
STUDIES = {
    "walk": ("--strides", "2"),
    "gait": (),
    "branch": ("--step", "0.2", "--no-doubled"),
    "bifurcation": ("--points", "3", "--transient", "2", "--keep", "4", "--backend", "threading"),
    "boundary": ("--step", "0.4", "--backend", "threading"),
    "basin": ("--points", "3", "3", "--strides", "5", "--backend", "threading"),
    "energetics": ("--step", "0.5"),
}
#: A walker for each scheme that no preset has.
OTHERS = {
    "toe-off-at-strike": ("--preset", "toe-off", "--scheme", "toe-off-at-strike"),
    "late-toe-off": ("--preset", "toe-off", "--scheme", "late-toe-off"),
}
WALKERS = {name: ("--preset", name) for name in PRESETS} | OTHERS
#: The first walker of each scheme, whose studies are drawn, too.
DRAWN = {scheme_of(preset.control).name: name for name, preset in reversed(PRESETS.items())}


def test_the_walkers_have_every_scheme() -> None:
    own = {scheme_of(preset.control).name for preset in PRESETS.values()}
    assert own | set(OTHERS) == set(SCHEMES)


@pytest.mark.parametrize("walker", WALKERS)
@pytest.mark.parametrize("study", STUDIES)
def test_every_study_takes_every_walker_and_draws_every_scheme(
    study: str, walker: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    drawn = walker in (*OTHERS, *DRAWN.values())
    plot = () if drawn else ("--no-plot",)
    out = ("--json", "--out", str(tmp_path / "x"), *plot)
    data = json.loads(run(capsys, study, *WALKERS[walker], *STUDIES[study], *out))
    assert {Path(file) for file in data["written"]} == set(tmp_path.iterdir())
    assert (tmp_path / "x.png").is_file() == drawn
    assert (tmp_path / ("x.json" if study == "energetics" else "x.npz")).is_file()


def test_presets_show_their_schemes(capsys: pytest.CaptureFixture[str]) -> None:
    text, data = run(capsys, "presets"), json.loads(run(capsys, "presets", "--json"))
    for name, preset in PRESETS.items():
        assert data[name]["scheme"] == scheme_of(preset.control).name
        (line,) = [line for line in text.splitlines() if line.startswith(f"{name} ")]
        assert line.split()[1] == data[name]["scheme"]


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
