"""The presets: walkers of the literature as they are described, and where each may be used."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    Outcome,
    PoweredWalkerEnv,
    WalkerParams,
    find_gait,
    stride,
)
from powered_walker_env.cli import main
from powered_walker_env.literature.values.published import PASSIVE_GAITS, PassiveGait
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.ground import swing_foot
from powered_walker_env.model.mechanics.packing import constants_of
from powered_walker_env.model.presets import preset
from tests.helpers.samples import PASSIVE, POWERED, pose


@pytest.mark.parametrize("name", PASSIVE)
def test_passive_gaits_are_exact_and_stable(name: str) -> None:
    params, control, state, source = PRESETS[name]
    assert control is None
    assert np.abs(np.subtract(stride(state, None, params, rtol=1e-13).state, state)).max() < 1e-12
    gait = find_gait(params, None, [round(x, 3) for x in state])
    assert gait.state == pytest.approx(state, abs=1e-12)
    assert gait.stable
    assert "find_gait" in source


@pytest.mark.parametrize("published", PASSIVE_GAITS, ids=str)
def test_every_published_passive_walker_is_a_preset_put_together_from_its_parts(
    published: PassiveGait,
) -> None:
    (known,) = [PRESETS[name] for name in PASSIVE if PRESETS[name].params == published.params]
    assert known.state == pytest.approx(published.state, abs=1e-12)


@pytest.mark.parametrize("name", ["mcgeer1990", "mcgeer1990-offset"])
def test_mcgeer_s_walker_has_his_dimensions(name: str) -> None:
    """Leg from sole to hip 1, R = 0.3, c = 0.63 above the sole, r_gyr = 0.32, no hip mass."""
    params = PRESETS[name].params
    assert params.leg_length + params.foot_radius == pytest.approx(1.0)
    assert params.com_along + params.foot_radius == pytest.approx(0.63)
    assert math.sqrt(params.leg_inertia / params.leg_mass) == pytest.approx(0.32)
    assert params.com_across == (0.0 if name == "mcgeer1990" else -0.005)
    assert params.slope == 0.025


def test_an_offset_of_the_mass_changes_the_modes() -> None:
    """A complex pair becomes a totter mode near −0.69: McGeer found w to matter most."""
    without, offset = (
        find_gait(PRESETS[name].params, None, PRESETS[name].state)
        for name in ("mcgeer1990", "mcgeer1990-offset")
    )
    assert abs(without.multipliers[1].imag) > 0.2
    assert offset.multipliers[0].real == pytest.approx(-0.68589, abs=1e-5)
    assert np.abs(offset.multipliers.imag).max() < 1e-12


def twice(knee: Knee | None) -> dict[str, float]:
    """The numbers of a knee of a leg twice as long."""
    if knee is None:
        return {}
    lengths = ("shank_length", "shank_com_along", "shank_com_across")
    return {name: 2 * getattr(knee, name) for name in lengths} | {
        "shank_inertia": 4 * knee.shank_inertia
    }


@pytest.mark.parametrize("name", PASSIVE)
def test_a_passive_gait_is_found_without_a_guess(name: str) -> None:
    params = PRESETS[name].params
    bigger = params.replace(  # the same walker, twice as long and in stronger gravity
        leg_length=2 * params.leg_length, foot_length=2 * params.foot_length,
        foot_radius=2 * params.foot_radius, com_along=2 * params.com_along,
        com_across=2 * params.com_across, leg_inertia=4 * params.leg_inertia,
        gravity=3 * params.gravity, **twice(params.knee),
    )  # fmt: skip
    gait = find_gait(bigger, None)
    angle, swing, *rates = gait.state
    assert (angle, swing) == pytest.approx(PRESETS[name].state[:2], abs=1e-10)
    scaled = [rate / math.sqrt(1.5) for rate in rates]
    assert scaled == pytest.approx(PRESETS[name].state[2:], abs=1e-10)


@pytest.mark.parametrize("name", PASSIVE)
def test_environments_refuse_a_walker_that_has_nothing_to_decide(name: str) -> None:
    wanted = f"preset must be a powered walker, got '{name}', .* choose one of {', '.join(POWERED)}"
    with pytest.raises(ValueError, match=wanted):
        PoweredWalkerEnv(preset=name)
    with pytest.raises(ValueError, match=wanted):
        PoweredWalkerEnv(preset=name, control=(2.9, 700.0))


def test_a_passive_walker_s_legs_take_a_motor_if_they_have_feet() -> None:
    params = PRESETS["ranger-locked"].params
    walked = stride(PRESETS["ranger-locked"].state, Control(2.9, 1.0), params)
    assert np.isfinite(walked.final.q).all()
    with pytest.raises(ValueError, match="foot_length must be positive for a powered walker"):
        stride(PRESETS["compass"].state, Control(2.9, 1.0), PRESETS["compass"].params)


def test_unknown_presets_are_named() -> None:
    with pytest.raises(ValueError, match=r"preset must be one of camp1997, .* got 'nobody'"):
        preset("nobody")


def test_the_command_line_takes_passive_presets(capsys: pytest.CaptureFixture[str]) -> None:
    def run(*arguments: str) -> str:
        assert main(arguments) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    data = json.loads(run("presets", "--json"))
    assert [name for name, found in data.items() if found["control"] is None] == PASSIVE
    assert WalkerParams(**data["compass"]["params"]) == PRESETS["compass"].params
    assert "walked" in run("walk", "--preset", "compass", "--strides", "2")
    branch = json.loads(run("branch", "--preset", "compass", "--step", "0.1", "--json"))
    assert branch["branches"][0]["parameter"] == "slope"
    doubled = run("branch", "--preset", "compass", "--bounds", "0.04", "0.09", "--step", "0.1")
    assert "period doubling at 0.07663563, a limit of stability" in doubled
    assert "gaits of 2 strides" in doubled
    changed = json.loads(run("gait", "--preset", "mcgeer1990", "--set", "slope=0.03", "--json"))
    assert changed["control"] is None and changed["stable"]
    points = ("--points", "3", "3", "--strides", "10", "--backend", "threading", "--json")
    assert json.loads(run("basin", "--preset", "compass", *points))["points"] == [3, 3]
    few = ("--points", "3", "--backend", "threading", "--json")
    assert json.loads(run("bifurcation", "--preset", "compass", *few))["parameter"] == "slope"
    bounds = ("--bounds", "-0.002", "0.002", "0.05", "0.08", "--step", "0.1")
    edge = json.loads(run("boundary", "--preset", "compass", *bounds, "--json"))
    assert edge["boundaries"][0]["parameters"] == ["com_across", "slope"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["gait", "--stall-torque", "3"], "is a passive walker and has no stall_torque"),
        (["walk", "--set", "switch_angle=3"], "is a passive walker and has no switch_angle"),
        (["branch", "--parameter", "stall_torque"], "parameter must not be 'stall_torque'"),
        (["bifurcation", "--parameter", "switch_angle"], "parameter must not be 'switch_angle'"),
        (["boundary", "--parameters", "slope", "stall_torque"], "must not be 'stall_torque'"),
    ],
)  # fmt: skip
def test_what_a_passive_walker_has_not_is_refused_at_once(
    arguments: list[str], message: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "--preset", "compass"]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_presets_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        PRESETS["compass"].params.slope = 0.0  # type: ignore[misc]


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("share", [-1e-3, 1e-3])
def test_every_walker_lands_on_ground_of_another_height(name: str, share: float) -> None:
    params, control, state, _ = PRESETS[name]
    height = share * params.leg_length
    walked = stride(state, control, params, step_height=height)
    assert walked.outcome == Outcome.WALKED
    final = pose([*np.cumsum(walked.final.q), *np.cumsum(walked.final.u)])
    assert swing_foot(final, constants_of(params)).real == pytest.approx(height, abs=1e-14)


@pytest.mark.parametrize("name", PRESETS)
def test_every_walker_walks_a_stride_where_the_slope_changes(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    steeper = stride(state, control, params.replace(slope=params.slope + 1e-3))
    level = stride(state, control, params)
    assert steeper.outcome == level.outcome == Outcome.WALKED
    assert steeper.state.stance_rate > level.state.stance_rate  # downhill is faster
