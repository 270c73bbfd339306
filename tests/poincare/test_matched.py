"""The same legs under other schemes at the same speed: over all presets."""

from __future__ import annotations

import pytest

from powered_walker_env import PRESETS, GaitNotFoundError, find_gait
from powered_walker_env.model.powering import scheme_of
from powered_walker_env.poincare.energy import costs, gait_at, passive_gaits

SCHEMES = ("passive", "motor", "motor-with-stop", "toe-off", "hip-torque")
#: Presets to the schemes under which their legs walk at the preset's speed.
WALKING = {
    "camp1997": ("passive", "motor", "motor-with-stop", "toe-off"),
    "camp1997-as-published": ("passive", "motor", "motor-with-stop"),
    "round-foot": ("passive", "motor", "motor-with-stop"),
    "motor-with-stop": ("passive", "motor", "motor-with-stop", "toe-off"),
    "kneed": ("motor", "motor-with-stop"),
    "simplest": ("passive", "toe-off"),
    "compass": ("passive", "toe-off"),
    "toe-off": ("passive", "toe-off", "hip-torque"),
    "mcgeer1990": ("passive", "toe-off", "hip-torque"),
    "hip-torque": ("passive", "toe-off", "hip-torque"),
    "ranger-locked": ("passive", "toe-off", "hip-torque"),
}


@pytest.mark.parametrize("name", WALKING)
def test_legs_walk_at_one_speed_or_say_why_not(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    speed = find_gait(params, control, state).speed
    for scheme in SCHEMES:
        try:
            gait = gait_at(name, scheme, speed)
        except ValueError as refused:
            assert scheme not in WALKING[name], refused
            assert any(word in str(refused) for word in ("no gait", "no passive", "foot_length"))
            continue
        assert scheme in WALKING[name]
        assert scheme_of(gait.control).name == scheme
        assert gait.speed == pytest.approx(speed, rel=1e-9)
        assert gait.params.replace(slope=0.0) == params.replace(slope=0.0)
        assert (gait.params.slope > 0) == (scheme == "passive")
        found = costs(gait)
        assert found.net == pytest.approx(found.lost, rel=1e-6, abs=1e-9)


def test_two_numbers_give_the_step_length_too() -> None:
    passive = gait_at("bhounsule-round-feet", "passive", 0.1863)
    hip = gait_at("bhounsule-round-feet", "hip-torque", 0.1863, passive.step_length)
    assert hip.speed == pytest.approx(passive.speed, rel=1e-9)
    assert hip.step_length == pytest.approx(passive.step_length, rel=1e-9)
    assert costs(hip).mechanical > costs(passive).mechanical
    again = find_gait(hip.params, hip.control, hip.state)
    assert again.state == pytest.approx(hip.state, abs=1e-9)


def test_passive_gaits_are_sorted_and_distinct() -> None:
    found = passive_gaits(PRESETS["camp1997"].params, 0.21)
    assert len(found) >= 2
    radii = [gait.spectral_radius for gait in found]
    assert radii == sorted(radii)
    slopes = [gait.params.slope for gait in found]
    assert min(slopes) > 0 and len({round(slope, 9) for slope in slopes}) == len(slopes)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="preset"):
        gait_at("camel", "passive", 0.2)
    with pytest.raises(ValueError, match="scheme"):
        gait_at("camp1997", "sail", 0.2)
    with pytest.raises(ValueError, match="speed must be positive"):
        gait_at("camp1997", "motor", -0.2)
    with pytest.raises(GaitNotFoundError, match="preset has no such motor"):
        gait_at("ranger-locked", "motor", 0.4)
    with pytest.raises(GaitNotFoundError, match="on the level: on the way there"):
        gait_at("round-foot", "toe-off", 0.75)


def test_behind_a_stop_the_switch_does_nothing_to_camps_walker() -> None:
    gait = gait_at("camp1997", "motor-with-stop", 0.21)
    by_switch, by_torque = abs(gait.control_jacobian).max(axis=0)
    assert by_switch < 1e-9 and by_torque > 1e-4
