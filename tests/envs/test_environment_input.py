"""What the environments make of their arguments, good and bad."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    Disturbance,
    GaitNotFoundError,
    Outcome,
    PoweredWalkerEnv,
    PoweredWalkerVectorEnv,
    WalkerParams,
    find_gait,
    stride,
)
from powered_walker_env.envs.rewards import REWARDS
from tests.helpers.episodes import FORWARD_FALL, ROUND_FOOT, assert_same, make, record
from tests.helpers.samples import MOTORS

CAMP, ROUND = PRESETS["camp1997"], PRESETS["round-foot"]
ZERO = np.zeros(2, np.float32)

# (arguments, what the message must name)
BAD_ARGUMENTS: list[tuple[dict[str, Any], str]] = [
    ({"preset": "camp1998"}, "preset must be one of camp1997, .* got 'camp1998'"),
    ({"preset": "camp1997", "params": {}}, "preset=None"),
    ({"params": {"leg_length": -1.0}}, "leg_length must be positive, got -1.0"),
    ({"params": {}, "gait": ROUND.state}, "control must be given"),
    ({"params": {"foot_length": 0.0}, "control": (2.9, 700.0)}, "foot_length"),
    ({"control": (7.1, 700.0)}, r"switch_angle must lie in \(0, 2\*pi\), got 7.1"),
    ({"control": (2.9, -1.0)}, "stall_torque must not be negative, got -1.0"),
    ({"control": 2.9}, "control must be two numbers, got 2.9"),
    ({"control": "29"}, "control must be two numbers, got '29'"),
    ({"control": (2.9, "much")}, "control must be a number, got 'much'"),
    ({"gait": (0.1, 0.2)}, "four"),
    ({"gait": (0.1, 0.2, 0.3, float("nan"))}, "finite"),
    ({"gait": []}, "gait must be"),
    ({"gait": "round"}, "gait must be"),
    ({"action_range": (0.2,)}, r"action_range must be two numbers, got \(0.2,\)"),
    ({"action_range": (0.0, 0.1)}, r"action_range\[0\] must lie in \(0, "),
    ({"action_range": (3.0, 0.1)}, r"action_range\[0\] must lie in \(0, "),
    ({"action_range": (0.1, 1.1)}, r"action_range\[1\] must lie in \(0, 1\], got 1.1"),
    ({"reward": "distance"}, "reward must be one of deviation, .* got 'distance'"),
    ({"effort_weight": -0.1}, "effort_weight must be finite and not negative, got -0.1"),
    ({"effort_weight": float("nan")}, "effort_weight must be finite"),
    ({"effort_weight": None}, "effort_weight must be a number, got None"),
    (
        {"disturbance": "heavy"},
        "disturbance must be one of none, light, medium, rough.* got 'heavy'",
    ),
    ({"disturbance": "light-wind"}, "ground.* got 'light-wind'"),
    ({"disturbance": {"wind": 1.0}}, "disturbance kinds are push, .* got 'wind'"),
    ({"disturbance": {"push": -1.0}}, "disturbance push must be .* got -1.0"),
    ({"disturbance": {"push": float("inf")}}, "disturbance push must be"),
    ({"disturbance": {"push": "0.1"}}, "disturbance push must be .* got '0.1'"),
    ({"disturbance": {"push": True}}, "disturbance push must be .* got True"),
    ({"disturbance": 0.01}, "disturbance must be a level .* got 0.01"),
    ({"disturbance": None}, "disturbance must be a level .* got None"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD_ARGUMENTS, ids=str)
@pytest.mark.parametrize("maker", [PoweredWalkerEnv, PoweredWalkerVectorEnv])
def test_a_bad_argument_is_named_with_its_need(
    maker: Any, arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        maker(**arguments)


@pytest.mark.parametrize("maker", [PoweredWalkerEnv, PoweredWalkerVectorEnv])
def test_an_unknown_field_of_params_is_named_with_the_known_ones(maker: Any) -> None:
    with pytest.raises(TypeError, match=r"no field 'leg_lenght'.*leg_length"):
        maker(params={"leg_lenght": 1.0})


def test_the_render_mode_must_be_known() -> None:
    with pytest.raises(ValueError, match=r"render_mode must be one of .* got 'ansi'"):
        PoweredWalkerEnv(render_mode="ansi")


@pytest.mark.parametrize(
    "action", [[0.1], 0.1, [0.1, 0.2, 0.3], [[0.1, 0.2]], None, "left", [float("nan"), 0.0]]
)
def test_an_action_must_be_two_finite_numbers(action: Any) -> None:
    env = make()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action must"):
        env.step(action)
    with pytest.raises(ValueError, match="action must"):
        env.control(action)
    untouched = make()
    untouched.reset(seed=0)
    assert_same(env.step(ZERO), untouched.step(ZERO))


def test_actions_beyond_the_box_are_clipped() -> None:
    one, two = make(), make()
    one.reset(seed=0), two.reset(seed=0)
    assert_same(one.step(np.array([5.0, -3.0])), two.step(np.array([1.0, -1.0])))
    assert one.control([5.0, -3.0]) == one.control([1.0, -1.0])


@pytest.mark.parametrize("options", [{"start": 1}, {"state": (1.0, 2.0)}, {"state": "gait"}])
def test_bad_reset_options_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises((ValueError, TypeError), match="state"):
        make().reset(options=options)


def test_a_walk_begins_with_a_reset() -> None:
    env = make(render_mode="rgb_array")
    with pytest.raises(gym.error.ResetNeeded, match=r"call reset\(\)"):
        env.step(ZERO)
    with pytest.raises(gym.error.ResetNeeded, match=r"call reset\(\)"):
        env.render()


@pytest.mark.parametrize("reward", REWARDS)
def test_a_step_after_a_fall_warns_once_and_changes_nothing(reward: str) -> None:
    env = make(reward=reward, disturbance={"push": 0.02, "slope": 0.01})
    env.reset(seed=0, options={"state": FORWARD_FALL})
    last, _, fell, _, info = env.step(ZERO)
    assert fell and env.outcome is Outcome.FELL_FORWARD
    before = env.get_state()
    with pytest.warns(UserWarning, match=r"after a fall: nothing happens until reset\(\)"):
        given = env.step(ZERO)
    assert_same(given, env.step(np.ones(2, np.float32)))  # a second warning would be an error
    observation, value, terminated, truncated, again = given
    np.testing.assert_array_equal(observation, last)
    assert (value, terminated, truncated) == (0.0, True, False)
    assert again["outcome"] == info["outcome"] and again["duration"] == 0.0
    assert again.keys() == info.keys()
    assert env.get_state() == before
    env.reset()
    assert env.outcome is Outcome.WALKED
    untouched = make(reward=reward, disturbance={"push": 0.02, "slope": 0.01})
    untouched.reset(seed=0, options={"state": FORWARD_FALL})
    untouched.step(ZERO)
    untouched.reset()
    assert_same(env.step(ZERO), untouched.step(ZERO))  # no random number was spent


BAD_STATES: list[tuple[Any, str]] = [
    ({}, "without begun, seeded"),
    (None, "got None without begun, seeded"),
    ({"random": None}, r"saved random must be an integer in \[0, 18446744073709551616\), got None"),
    ({"random": -1}, "saved random must be an integer"),
    ({"outcome": 99}, "saved outcome must be an integer"),
    ({"state": [0.0]}, r"saved state must be 4 finite numbers, got \[0.0\]"),
    ({"observation": "far"}, "saved observation must be 4 finite numbers, got 'far'"),
    ({"walker": [1.0]}, "saved walker must be"),
    ({"level": float("nan")}, "saved level must be 1 finite numbers, got nan"),
]


@pytest.mark.parametrize(("change", "message"), BAD_STATES, ids=str)
def test_a_saved_state_that_is_none_is_refused_and_changes_nothing(
    change: Any, message: str
) -> None:
    env = make()
    env.reset(seed=0)
    before = env.get_state()
    saved = {**before, **change} if change else change
    with pytest.raises(ValueError, match=message):
        env.set_state(saved)
    assert env.get_state() == before
    for name in before:
        without = {key: value for key, value in before.items() if key != name}
        with pytest.raises(ValueError, match=f"without {name}"):
            env.set_state(without)


@pytest.mark.parametrize("maker", [PoweredWalkerEnv, PoweredWalkerVectorEnv])
def test_an_argument_that_does_not_exist_is_named_with_those_that_do(maker: Any) -> None:
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'distrubance'.*disturbance"):
        maker(distrubance="light")


@pytest.mark.parametrize("name", MOTORS)
def test_the_action_mapping_is_affine_about_the_nominal_control(name: str) -> None:
    env = PoweredWalkerEnv(preset=name, disturbance="none")
    nominal, (angle, torque) = PRESETS[name].control, env.task.action_range
    assert nominal is not None
    assert env.control([0.0, 0.0]) == nominal
    for action in ([1.0, 1.0], [-1.0, 0.5], [0.3, -0.7]):
        control = env.control(action)
        assert control.switch_angle == pytest.approx(nominal.switch_angle + action[0] * angle)
        assert control.stall_torque == pytest.approx(
            nominal.stall_torque * (1 + action[1] * torque)
        )
        env.reset(seed=0)
        info = env.step(np.array(action))[4]
        assert info["control"].tolist() == [control.switch_angle, control.stall_torque]


def test_a_stride_is_that_of_the_package_under_the_actions_control() -> None:
    env = make(disturbance="none")
    _, info = env.reset(options={"state": [x + 0.003 for x in ROUND.state]})
    for action in ([0.0, 0.0], [0.1, -0.1]):
        expected = stride(info["state"].tolist(), env.control(action), ROUND.params, rtol=1e-8)
        info = env.step(np.array(action))[4]
        assert info["state"].tolist() == list(expected.state)
        for name in ("duration", "step_length", "energy_in", "positive_work", "energy_lost"):
            assert info[name] == getattr(expected, name)


def test_params_control_and_gait_as_json_make_the_presets_environment() -> None:
    own = PoweredWalkerEnv(
        params=ROUND.params.to_dict(),
        control=[2.704, 3371.8],
        gait=list(ROUND.state),
        action_range=[0.2, 0.3],
        disturbance={"push": 0.02},
    )
    assert_same(record(own, 20, seed=1), record(make(), 20, seed=1))
    typed = PoweredWalkerEnv(
        params=ROUND.params,
        control=Control(2.704, 3371.8),
        gait=ROUND.state,
        action_range=np.array([0.2, 0.3]),  # type: ignore[arg-type]
        disturbance=Disturbance(push=0.02),
    )
    assert_same(record(typed, 20, seed=1), record(make(), 20, seed=1))


def test_the_gait_is_found_when_it_is_not_given() -> None:
    own = PoweredWalkerEnv(params=ROUND.params.to_dict(), control=[2.704, 3371.8])
    assert own.task.gait == pytest.approx(np.array([ROUND.state]), abs=1e-9)
    stronger = PoweredWalkerEnv(preset="round-foot", control=[2.704, 3390.0], disturbance="none")
    assert stronger.task.gait[0] == pytest.approx(
        find_gait(ROUND.params, Control(2.704, 3390.0)).state, abs=1e-12
    )
    stronger.reset(seed=0)
    assert stronger.step(ZERO)[1] == pytest.approx(1.0, abs=1e-9)


def test_control_and_gait_are_found_when_neither_is_given() -> None:
    longer = PoweredWalkerEnv(params={"leg_length": 1.0, "foot_length": 0.0501})
    assert longer.task.control == CAMP.control
    assert longer.task.gait.shape == (1, 4)


def test_a_gait_of_several_strides_is_as_near_as_its_nearest_point() -> None:
    points = [list(ROUND.state), [x + 0.01 for x in ROUND.state]]
    env = PoweredWalkerEnv(preset="round-foot", gait=points, disturbance="none")
    observation, _ = env.reset(options={"state": points[1]})
    assert observation == pytest.approx([0.2, 0.2, 0.01 / 0.15, 0.01 / 0.3], rel=1e-6)
    assert env.step(ZERO)[4]["distance"] < 0.31  # of either point


@pytest.mark.parametrize("control", [None, (2.9, 0.0)])
def test_a_walker_without_a_gait_is_refused_with_the_reason(control: Any) -> None:
    uphill = WalkerParams(slope=-0.4)
    with pytest.raises(GaitNotFoundError, match="no gait"):
        PoweredWalkerEnv(params=uphill, control=control)


def test_a_registered_id_takes_params_in_place_of_its_preset() -> None:
    fields = ROUND.params.replace(slope=0.002).to_dict()
    env = make(ROUND_FOOT, preset=None, params=fields, control=[2.704, 3371.8])
    assert env.task.params.slope == 0.002
