"""What walking costs: balances of gaits, what a transition costs at least, table and figure."""

from __future__ import annotations

import csv
import functools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from powered_walker_env import PRESETS, Control, WalkerParams, find_gait, stride
from powered_walker_env.cli import main
from powered_walker_env.literature.values.toe_off import NORMAL, SLOW, kuos_gait
from powered_walker_env.model.powering import SCHEMES, ToeOff, scheme_of
from powered_walker_env.poincare.energy.energetics import (
    Costs,
    at_equal_gait,
    comparison,
    costs,
    first_gait,
    schemes_for,
    start_on_the_level,
)
from powered_walker_env.poincare.energy.least_cost import ideal_push, least_cost, leg, strike_rate
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError
from tests.model.test_push_off import simplest

STEP = 0.1  # of arclength: fewer gaits than the command's
COMPASS = schemes_for("compass")


@functools.cache
def families() -> dict[str, list[Costs]]:
    return comparison("compass", step=STEP)


def every() -> list[Costs]:
    return [row for rows in families().values() for row in rows]


def before_strike(gait: Gait) -> np.ndarray:
    final = stride(gait.state, gait.control, gait.params, rtol=1e-13).final  # type: ignore[arg-type]
    return np.concatenate([np.cumsum(final.q), np.cumsum(final.u)])


def test_on_a_gait_all_that_is_put_in_is_lost() -> None:
    for row in every():
        assert row.net == pytest.approx(row.lost, abs=1e-10)
        assert row.mechanical >= row.net - 1e-10
        assert math.isnan(row.electrical)


def test_a_slope_costs_its_sine() -> None:
    for row in families()["passive"]:
        assert row.gravity == row.mechanical == math.sin(row.value)
        assert row.work == 0.0


def test_schemes_but_the_passive_one_walk_on_the_level() -> None:
    assert tuple(families()) == COMPASS
    for name in COMPASS[1:]:
        assert len(families()[name]) > 5
        assert all(row.gravity == 0.0 and row.work > 0 for row in families()[name])


def test_costs_are_those_of_the_gait_and_its_stride() -> None:
    gait = start_on_the_level("compass", "hip-torque")
    ours = stride(gait.state, gait.control, gait.params, rtol=1e-13)  # type: ignore[arg-type]
    weight = 2 * gait.params.leg_mass * gait.params.gravity
    row = costs(gait, "hip_torque")
    assert row.work == pytest.approx(gait.cost_of_transport, rel=1e-13)
    assert row.lost == pytest.approx(ours.energy_lost / (weight * ours.step_length), rel=1e-9)
    assert row.value == gait.control.hip_torque  # type: ignore[union-attr]
    assert (row.speed, row.step_length) == (gait.speed, gait.step_length)


def test_a_motor_draws_more_than_it_does() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    row = costs(find_gait(params, control, state))
    ours = stride(state, control, params, rtol=1e-13)
    carried = 2 * params.leg_mass * params.gravity * ours.step_length
    assert row.electrical == pytest.approx(ours.electrical_energy / carried, rel=1e-9)
    assert row.electrical > row.work > 0


def test_rate_at_the_strike_is_that_of_a_pendulum_integrated_otherwise() -> None:
    for time, half_angle in ((3.8, 0.2), (1.74, 0.355), (0.5, 0.4), (8.0, 0.1)):
        rate = strike_rate(time, half_angle)
        run = solve_ivp(
            lambda _, y: [y[1], math.sin(y[0])], (0, time), [-half_angle, rate],
            method="DOP853", rtol=1e-12, atol=1e-13,
        )  # fmt: skip
        # Over the top and away: what is missed grows as e^time.
        assert run.y[0, -1] == pytest.approx(half_angle, abs=1e-11 * math.exp(time))


@pytest.mark.parametrize("seed", [SLOW, NORMAL], ids=["slow", "normal"])
def test_kuos_walker_which_pushes_just_before_costs_the_least(seed: tuple) -> None:  # type: ignore[type-arg]
    gait = kuos_gait(*seed)
    least = least_cost(gait.speed, gait.step_length, gait.params)
    assert gait.cost_of_transport == pytest.approx(least, rel=1e-11)
    assert costs(gait).ideal == pytest.approx(least, rel=1e-11)


def test_least_cost_is_half_v_squared_tan_squared_over_weight_times_distance() -> None:
    params = WalkerParams(foot_length=0.0, leg_length=2.0, gravity=9.0)
    half_angle, time = 0.3, 1.5
    rate = strike_rate(time, half_angle)
    length, unit = 2 * 2.0 * math.sin(half_angle), math.sqrt(2.0 / 9.0)
    v = rate * 2.0 / unit
    expected = 0.5 * (v * math.tan(half_angle)) ** 2 / (9.0 * length)
    assert least_cost(length / (time * unit), length, params) == pytest.approx(expected, rel=1e-10)


def test_least_cost_grows_as_speed_squared_times_step_length_for_quick_short_steps() -> None:
    """v²α²/2gl with α = l/2L and v the speed: v²l/8gL²."""
    params = simplest()
    for speed, length in ((1.0, 0.02), (2.0, 0.02), (1.0, 0.04)):
        expected = speed**2 * length / 8
        assert least_cost(speed, length, params) == pytest.approx(expected, rel=1e-3)


def test_no_walker_on_point_feet_does_with_less() -> None:
    for row in every():
        assert row.mechanical > row.least


def test_ideal_push_of_a_toe_off_gait_on_the_level_is_its_own() -> None:
    """The gait's swing keeps the energy, so its push has to keep it over the strike."""
    gait = start_on_the_level("compass", "toe-off")
    impulse, work = ideal_push(before_strike(gait), gait.params)
    assert impulse == pytest.approx(gait.control.impulse, rel=1e-10)  # type: ignore[union-attr]
    assert work == pytest.approx(gait.positive_work, rel=1e-10)
    for row in families()["toe-off"]:
        assert row.ideal == pytest.approx(row.work, rel=1e-8)


def test_a_later_push_costs_more_for_the_same_gait() -> None:
    found = at_equal_gait(start_on_the_level("compass", "toe-off"))
    before, along, late = found.values()
    assert before.speed == along.speed == late.speed
    assert before.step_length == along.step_length == late.step_length
    assert 1.5 * before.work < along.work
    assert 1.5 * along.work < late.work
    for name in found:
        alone = start_on_the_level("compass", name)
        assert costs(alone).work == pytest.approx(found[name].work, rel=1e-8)


def test_a_push_before_costs_about_a_quarter_of_gravity_where_steps_are_short() -> None:
    """Exactly, for a mass on ever shorter steps (Kuo 2002); these legs have masses."""
    speeds = np.array([row.speed for row in families()["toe-off"]])
    work = np.array([row.work for row in families()["toe-off"]])
    slow = [row for row in families()["passive"] if row.speed < 0.5]
    assert slow
    for row in slow:
        ratio = np.interp(row.speed, speeds, work) / row.mechanical
        assert ratio == pytest.approx(0.25, rel=0.15)


@pytest.mark.parametrize("name", ["camp1997", "round-foot"])
def test_a_motors_gaits_balance_along_their_family(name: str) -> None:
    (rows,) = comparison(name, ["motor"], step=STEP).values()
    # A branch's gaits are fixed points to 1e-11 in the state, which a stride multiplies.
    sure = [row for row in rows if row.spectral_radius < 1e3]
    assert len(sure) > 10
    for row in sure:
        assert row.net == pytest.approx(row.lost, abs=1e-9)
        assert row.electrical > row.work >= row.net - 1e-9


def test_what_cannot_be_compared_is_refused_with_a_remedy() -> None:
    with pytest.raises(ValueError, match="which walks with motor, motor-with-stop"):
        start_on_the_level("camp1997", "toe-off")
    with pytest.raises(ValueError, match="motor, motor-with-stop on the legs of 'round-foot'"):
        first_gait("passive", "round-foot")
    with pytest.raises(ValueError, match=r"scheme must be one of motor, .* got 'wind'"):
        comparison("compass", ["wind"])
    with pytest.raises(ValueError, match=r"step_length must lie in \(0, 2.0\), got 3.0"):
        least_cost(1.0, 3.0, simplest())
    with pytest.raises(ValueError, match=r"speed must be positive, got 0\.0"):
        least_cost(0.0, 0.3, simplest())
    with pytest.raises(ValueError, match="give a speed that a leg can walk at"):
        least_cost(1e-3, 0.3, simplest())
    with pytest.raises(ValueError, match="gait must be one with a toe-off"):
        at_equal_gait(find_gait(PRESETS["compass"].params, None, PRESETS["compass"].state))
    standing = [0.0, 0.0, math.pi, 0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="a push along the trailing leg makes up for"):
        ideal_push(standing, PRESETS["compass"].params)


def test_leg_reaches_from_the_sole_to_the_hip() -> None:
    assert leg(PRESETS["compass"].params) == pytest.approx(1.0, abs=1e-15)
    ranger = PRESETS["ranger-locked"].params
    bent = ranger.replace(locked_ankle_angle=2.5)
    position = ranger.leg_length + ranger.foot_length * complex(math.cos(2.5), -math.sin(2.5))
    assert leg(bent) == pytest.approx(abs(position) + ranger.foot_radius, rel=1e-14)


@pytest.mark.parametrize("preset", PRESETS)
def test_every_presets_legs_have_first_gaits_under_their_schemes_and_no_others(preset: str) -> None:
    _, control, state, _ = PRESETS[preset]
    mine = schemes_for(preset)
    assert scheme_of(control).name in mine
    for name in SCHEMES:
        if name not in mine:
            with pytest.raises(ValueError, match=f"on the legs of '{preset}', got '{name}'"):
                first_gait(name, preset)
            continue
        try:
            gait, parameter = first_gait(name, preset)
        except GaitNotFoundError:  # light feet have little for a hip to push with
            assert control is None and name != "passive"
            continue
        assert scheme_of(gait.control).name == name
        assert parameter in ("slope", *scheme_of(gait.control).numbers)
        if name == scheme_of(control).name:
            assert gait.state == pytest.approx(state, abs=1e-9)
        found = costs(gait, parameter)
        assert found.net == pytest.approx(found.lost, abs=1e-9)


@pytest.mark.parametrize("preset", ["toe-off", "hip-torque"])
def test_powered_presets_on_the_level_are_compared(preset: str) -> None:
    families = comparison(preset, step=0.3)
    assert tuple(families) == schemes_for(preset)
    for rows in families.values():
        assert len(rows) > 2
        assert all(row.gravity == 0.0 < row.work for row in rows)


def test_presets_with_a_motor_walk_with_it() -> None:
    assert schemes_for("round-foot") == ("motor", "motor-with-stop")
    gait, parameter = first_gait("motor", "round-foot")
    assert parameter == "stall_torque"
    assert isinstance(gait.control, Control)
    assert isinstance(first_gait("toe-off", "compass")[0].control, ToeOff)


def test_the_command_prints_and_saves_table_and_figure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base, short = str(tmp_path / "costs"), ("--scheme", "passive", "toe-off", "--step", "0.2")
    assert main(["energetics", *short, "--out", base]) == 0
    text = capsys.readouterr().out
    assert "pushed before, with or after" in text
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == ["costs.csv", "costs.json", "costs.png", "costs.svg"]
    saved = json.loads((tmp_path / "costs.json").read_text(encoding="utf-8"))
    rows = [row for found in saved["families"].values() for row in found]
    table = list(csv.DictReader((tmp_path / "costs.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(line["mechanical"]) for line in table] == [row["mechanical"] for row in rows]
    assert {line["scheme"] for line in table} == {"passive", "toe-off"}
    assert all(row["electrical"] is None for row in rows)
    assert main(["energetics", *short, "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["families"] == saved["families"]


def test_legs_that_a_hip_cannot_drive_are_compared_without_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["energetics", "--preset", "nearly-simplest", "--step", "0.3"]) == 0
    assert "hip-torque: no gait found" in capsys.readouterr().out
    assert main(["energetics", "--preset", "nearly-simplest", "--scheme", "hip-torque"]) == 1
    assert "no gait of period 1 found" in capsys.readouterr().err


def test_the_command_refuses_what_it_cannot_write_before_it_works(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "costs.json").write_text("mine", encoding="utf-8")
    for arguments, message in (
        (["--out", str(tmp_path / "costs")], "exists already; choose another --out"),
        (["--out", str(tmp_path / "no" / "costs")], "does not exist; make it first"),
        (["--out", str(tmp_path / "..")], "must end in a name"),
        (["--step", "0"], "--step must be positive"),
        (["--preset", "camp1997", "--scheme", "passive"], "motor, motor-with-stop on the legs"),
    ):
        assert main(["energetics", *arguments]) == 2
        assert message in capsys.readouterr().err
    assert (tmp_path / "costs.json").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("name", "schemes"),
    [
        ("toe-off", ("toe-off", "toe-off-at-strike", "late-toe-off")),
        ("hip-torque", ("hip-torque",)),
        ("motor-with-stop", ("motor", "motor-with-stop")),
    ],
)
def test_powered_walkers_are_compared_by_what_their_own_numbers_mean(
    name: str, schemes: tuple[str, ...]
) -> None:
    assert schemes_for(name) == schemes
    families = comparison(name, step=0.5)
    assert tuple(families) == schemes and all(families.values())
    own = getattr(PRESETS[name].control, families[schemes[0]][0].parameter)
    values = [row.value for row in families[schemes[0]]]
    assert min(values) <= own <= max(values)
