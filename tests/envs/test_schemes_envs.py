"""Environments of every scheme: the same contract, with another control."""

from __future__ import annotations

import json
import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env

from powered_walker_env import PRESETS, PoweredWalkerEnv, PoweredWalkerVectorEnv, WalkerParams
from powered_walker_env.model.powering import (
    SCHEMES,
    Control,
    HipTorque,
    LateToeOff,
    StoppedControl,
    ToeOff,
    scheme_of,
)
from powered_walker_env.poincare.gaits import GaitNotFoundError
from tests.helpers.episodes import assert_same
from tests.helpers.samples import DECIDING, scheme_arguments

OWN_ID = "SchemeWalker-v0"
#: Gentle for all of them; the push in their own units of time.
KINDS = {"push": 0.002, "torque": 0.02, "sensor": 0.1, "ground": 1e-4, "parameters": 0.01}
BASIC_INFO = {
    "state", "control", "outcome", "duration", "step_length", "step_height", "energy_in",
    "positive_work", "energy_lost", "distance", "reward_stability", "reward_effort",
    "reward_fall",
}  # fmt: skip


def make(name: str, **changes: Any) -> PoweredWalkerEnv:
    return PoweredWalkerEnv(**(scheme_arguments(name) | changes))


def actions(name: str, count: int) -> np.ndarray:
    size = (count, len(SCHEMES[name].numbers))
    return np.random.default_rng(0).uniform(-0.1, 0.1, size).astype(np.float32)


@pytest.fixture
def own_id() -> Any:
    gym.register(
        OWN_ID,
        entry_point="powered_walker_env:PoweredWalkerEnv",
        vector_entry_point="powered_walker_env:PoweredWalkerVectorEnv",
        max_episode_steps=50,
    )
    yield OWN_ID
    gym.registry.pop(OWN_ID)


@pytest.mark.parametrize("name", DECIDING)
def test_gymnasiums_checker_finds_nothing(name: str) -> None:
    env = make(name, disturbance=KINDS)
    assert env.task.scheme.name == name
    check_env(env, skip_render_check=True)


@pytest.mark.parametrize("name", DECIDING)
def test_the_open_loop_stays_on_the_gait(name: str) -> None:
    env = make(name, disturbance="none")
    env.reset(seed=0)
    for _ in range(5):
        _, reward, terminated, _, info = env.step(np.zeros_like(actions(name, 1)[0]))
        assert not terminated and reward == pytest.approx(1.0, abs=1e-6)
    assert info["distance"] < 1e-4
    assert info["positive_work"] > 0


@pytest.mark.parametrize("name", DECIDING)
def test_a_vector_environment_is_single_ones_bit_for_bit(name: str) -> None:
    arguments = scheme_arguments(name) | {"disturbance": KINDS}
    envs = PoweredWalkerVectorEnv(num_envs=3, autoreset_mode="Disabled", **arguments)
    singles = [PoweredWalkerEnv(**arguments) for _ in range(3)]
    assert envs.action_space.shape == (3, *singles[0].action_space.shape)
    first, _ = envs.reset(seed=5)
    starts = [env.reset(seed=5 + i)[0] for i, env in enumerate(singles)]
    assert_same(first, np.array(starts))
    for _ in range(2):
        action = 0.01 * actions(name, 3)
        observation, reward, terminated, _, info = envs.step(action)
        for i, env in enumerate(singles):
            one = env.step(action[i])
            assert_same(observation[i], one[0])
            assert (float(reward[i]), bool(terminated[i])) == (one[1], one[2])
            for key, value in one[4].items():
                np.testing.assert_array_equal(info[key][i], value)


@pytest.mark.parametrize("name", DECIDING)
def test_actions_are_affine_about_the_nominal_control(name: str) -> None:
    env, scheme = make(name, disturbance="none"), SCHEMES[name]
    nominal, reach = env.task.nominal, env.task.half_range
    count = len(scheme.numbers)
    assert env.action_space == gym.spaces.Box(-1.0, 1.0, (count,), np.float32)
    assert env.control(np.zeros(count)) == env.task.control
    for action in (np.ones(count), -np.ones(count), np.linspace(-0.5, 0.3, count)):
        control = env.control(action)
        assert type(control) is scheme.control
        found = [getattr(control, number) for number in scheme.numbers]
        np.testing.assert_allclose(found, nominal + action * reach, rtol=1e-15)
        env.reset(seed=0)
        assert env.step(action.astype(np.float32))[4]["control"] == pytest.approx(
            nominal + action.astype(np.float32) * reach
        )
    assert env.control(np.full(count, 9.0)) == env.control(np.ones(count))
    with pytest.raises(ValueError, match=rf"action must have shape .*{scheme.numbers[-1][:3]}"):
        env.control(np.zeros(count + 1))


def test_default_ranges_are_those_documented() -> None:
    assert make("toe-off").task.half_range.tolist() == [0.3 * 0.1]
    assert make("hip-torque").task.half_range.tolist() == [0.15, 0.3 * 0.02]
    backwards = HipTorque(3.1, -0.02)
    env = PoweredWalkerEnv(
        params=PRESETS["hip-torque"].params, control=backwards, gait=PRESETS["hip-torque"].state
    )
    assert env.task.half_range.tolist() == [0.15, 0.3 * 0.02]  # of its absolute value
    assert make("toe-off", action_range=[0.5]).task.half_range.tolist() == [0.5 * 0.1]


@pytest.mark.parametrize("name", DECIDING)
def test_info_has_the_same_keys_always_and_the_numbers_by_name(name: str) -> None:
    env = make(name, disturbance="none")
    _, start = env.reset(seed=0)
    stepped = env.step(actions(name, 1)[0])[4]
    named = () if name == "motor" else SCHEMES[name].numbers
    assert start.keys() == stepped.keys() == BASIC_INFO | set(named)
    for info in (start, stepped):
        assert [info[number] for number in named] == info["control"].tolist()[: len(named)]


@pytest.mark.parametrize("name", DECIDING)
def test_torque_noise_multiplies_the_strength_whatever_it_is(name: str) -> None:
    env = make(name, disturbance={"torque": 0.02})
    env.reset(seed=0)
    *angle, strength = env.step(0 * actions(name, 1)[0])[4]["control"]
    assert angle == env.task.nominal.tolist()[:-1]
    assert 0 < abs(strength / env.task.nominal[-1] - 1) < 0.1


@pytest.mark.parametrize("name", DECIDING)
def test_a_spec_survives_json_and_makes_the_same_environment(name: str, own_id: str) -> None:
    env = gym.make(own_id, **scheme_arguments(name), disturbance=KINDS)
    assert env.spec is not None
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    json.dumps(env.spec.kwargs)
    assert_same(env.reset(seed=1), again.reset(seed=1))
    for action in 0.01 * actions(name, 3):
        one = env.step(action)
        assert_same(one, again.step(action))
        if one[2]:
            assert_same(env.reset(), again.reset())


@pytest.mark.parametrize("name", DECIDING)
def test_states_can_be_saved_and_restored(name: str) -> None:
    env = make(name, disturbance=KINDS)
    env.reset(seed=2)
    saved = json.loads(json.dumps(env.get_state()))
    one = env.step(actions(name, 1)[0])
    env.set_state(saved)
    assert_same(env.step(actions(name, 1)[0]), one)


def test_a_scheme_by_name_brings_its_preset() -> None:
    env = PoweredWalkerEnv(scheme="hip-torque", disturbance="none")
    assert env.task.params == PRESETS["hip-torque"].params
    assert PoweredWalkerEnv(scheme="motor").task.control == PRESETS["camp1997"].control
    with pytest.raises(ValueError, match="no preset has scheme 'late-toe-off'"):
        PoweredWalkerEnv(scheme="late-toe-off")


def test_a_walker_of_ones_own_takes_a_scheme_by_its_control_or_by_name() -> None:
    params, control, state, _ = PRESETS["toe-off"]
    by_type = PoweredWalkerEnv(params=params, control=LateToeOff(0.11))
    by_name = PoweredWalkerEnv(params=params, scheme="late-toe-off", control=[0.11])
    assert by_type.task.control == by_name.task.control == LateToeOff(0.11)
    np.testing.assert_array_equal(by_type.task.gait, by_name.task.gait)
    known = PoweredWalkerEnv(params=params, scheme="toe-off")  # under the preset's control
    assert known.task.control == control
    np.testing.assert_allclose(known.task.gait, [state], atol=1e-9)


NOT_ALLOWED: list[tuple[dict[str, Any], str]] = [
    ({"scheme": "passive"}, "scheme must power the walker, got 'passive'"),
    ({"scheme": "rocket"}, "scheme must be one of motor, .* got 'rocket'"),
    ({"preset": "toe-off", "scheme": "motor"}, "scheme must be 'toe-off' or left out"),
    ({"preset": "camp1997", "scheme": "toe-off"}, "one with this scheme: toe-off"),
    ({"preset": "camp1997", "control": StoppedControl(2.9, 700.0)}, "control must be a Control"),
    ({"preset": "toe-off", "control": [3.0, 0.1]}, "control must be one number, .*impulse"),
    ({"preset": "toe-off", "control": [-0.1]}, "impulse must not be negative"),
    ({"preset": "toe-off", "control": [0.0], "gait": [-0.2, 0.2, 0.3, 0.2]}, "nothing to decide"),
    ({"preset": "toe-off", "action_range": [0.1, 0.1]}, "action_range must be one number"),
    ({"preset": "toe-off", "action_range": [1.5]}, r"action_range\[0\] must lie in \(0, 1\]"),
    ({"preset": "hip-torque", "control": [7.0, 0.1]}, "switch_angle must lie in"),
    (
        {"params": PRESETS["toe-off"].params, "scheme": "motor", "control": ToeOff(0.1)},
        "control must be a Control",
    ),
    (
        {"params": WalkerParams(leg_inertia=0.0, com_along=1.0), "control": ToeOff(0.1)},
        "leg_inertia must be positive for a push-off",
    ),
]


@pytest.mark.parametrize(("arguments", "message"), NOT_ALLOWED, ids=str)
def test_contradictions_are_refused(arguments: dict[str, Any], message: str) -> None:
    for kind in (PoweredWalkerEnv, PoweredWalkerVectorEnv):
        with pytest.raises(ValueError, match=message):
            kind(**arguments)


def test_a_scheme_without_a_known_control_asks_for_one() -> None:
    with pytest.raises(GaitNotFoundError, match="give control"):
        PoweredWalkerEnv(params=PRESETS["toe-off"].params, scheme="late-toe-off")


@pytest.mark.parametrize("name", DECIDING)
def test_every_scheme_is_drawn(name: str) -> None:
    pytest.importorskip("pygame")
    env = make(name, disturbance="none", render_mode="rgb_array_list")
    env.reset(seed=0)
    env.step(actions(name, 1)[0])
    frames = env.render()
    assert len(frames) > 5 and frames[0].dtype == np.uint8
    env.close()


@pytest.mark.parametrize("name", DECIDING)
def test_an_episode_of_every_scheme_is_recorded(name: str, own_id: str) -> None:
    pytest.importorskip("stable_baselines3")
    from agents.recording import nominal_stride, record
    from powered_walker_env.controllers import LQR, OpenLoop, evaluate

    env = gym.make(own_id, **scheme_arguments(name)).unwrapped
    assert isinstance(env, PoweredWalkerEnv)
    controller, arguments = LQR(env.task), scheme_arguments(name) | {"disturbance": KINDS}
    walked = record(controller, own_id, 3, 2, **arguments)
    assert len(walked.states) == 3
    assert walked.motor_on.any() == SCHEMES[name].moves_ankle
    assert math.isfinite(nominal_stride(env.task).states[-1][0])
    result = evaluate(OpenLoop(len(env.task.nominal)), own_id, 4, disturbance="none",
                      **scheme_arguments(name))  # fmt: skip
    assert result.survived == 4


@pytest.mark.parametrize("name", DECIDING)
def test_stable_baselines3_takes_every_scheme(name: str, own_id: str) -> None:
    pytest.importorskip("stable_baselines3")
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    envs = PoweredWalkerVecEnv(own_id, 2, seed=0, **scheme_arguments(name))
    envs.reset()
    action = actions(name, 2)
    observation, _, _, infos = envs.step(action)
    assert np.shape(observation) == (2, 4)
    assert all(len(info["control"]) == len(SCHEMES[name].numbers) for info in infos)


def test_ppo_learns_on_the_toe_off_walker(own_id: str) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    envs = PoweredWalkerVecEnv(own_id, 4, preset="toe-off", disturbance="light")
    model = stable_baselines3.PPO("MlpPolicy", envs, n_steps=64, batch_size=64, seed=0)
    model.learn(512)
    assert model.predict(np.zeros(4, np.float32))[0].shape == (1,)


def test_the_motors_environments_know_nothing_of_it() -> None:
    """Version 0 as it was: action, control and keys of `info` (see the other tests)."""
    env = gym.make("PoweredWalker-v0").unwrapped
    assert isinstance(env, PoweredWalkerEnv)
    assert scheme_of(env.task.control).name == "motor"
    assert type(env.control([0.0, 0.0])) is Control
    assert env.reset()[1].keys() == BASIC_INFO
