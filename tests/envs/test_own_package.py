"""Walkers, rewards and ids of other people: used by name, in worker processes, in SB3."""

from __future__ import annotations

import json
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

from powered_walker_env import PRESETS, Disturbance, PoweredWalkerEnv, PoweredWalkerVectorEnv
from powered_walker_env.envs import TaskArguments, make_walkers, register_walker
from powered_walker_env.model.powering import LateToeOff
from tests.helpers.episodes import EVERYTHING, ROUND_FOOT, assert_same, make, record
from tests.helpers.samples import DECIDING, PASSIVE, POWERED, scheme_arguments

PACKAGE = """
import gymnasium as gym
import numpy as np
from powered_walker_env.envs import register_walker

def smooth(before, after, strides):
    '''One for a stride that ends as it began; a fall costs two.'''
    change = np.abs(after - before).sum(axis=1) + strides.duration
    return np.where(strides.walked, np.exp(-change), -2.0)

register_walker("SmoothWalker-v0", max_episode_steps=9, preset="round-foot",
                reward="own_walkers:smooth", effort_weight=0.5)
gym.register(  # as README has it
    id="PlainWalker-v0",
    entry_point="powered_walker_env:PoweredWalkerEnv",
    max_episode_steps=7,
    kwargs={"preset": "round-foot", "reward": "contraction", "disturbance": {"push": 0.01}},
)

class Crooked(gym.Env):
    observation_space = action_space = gym.spaces.Box(-1, 1, (4,))

gym.register(id="Crooked-v0", entry_point=Crooked)
"""
OWN_IDS = ("SmoothWalker-v0", "PlainWalker-v0", "Crooked-v0")


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of somebody else's in a folder of its own."""
    (tmp_path / "own_walkers.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for env_id in OWN_IDS:
        gym.registry.pop(env_id, None)
    sys.modules.pop("own_walkers", None)


@pytest.fixture
def new_id() -> Iterator[str]:
    yield "NewWalker-v0"
    gym.registry.pop("NewWalker-v0", None)


def test_a_reward_of_ones_own_is_what_the_function_says(own: Path) -> None:
    env = gym.make("own_walkers:SmoothWalker-v0", disturbance=EVERYTHING)
    walker = env.unwrapped
    assert isinstance(walker, PoweredWalkerEnv)
    weight = 2 * walker.task.params.leg_mass * walker.task.params.gravity
    _, info = env.reset(seed=0)
    fell = 0
    rng = np.random.default_rng(1)
    for _ in range(60):
        before = info["state"]
        _, reward, terminated, truncated, info = env.step(rng.uniform(-0.3, 0.3, 2))
        expected = -2.0
        if not terminated:
            change = abs(info["state"] - before).sum() + info["duration"]
            # The mass, for which the weight counts, differs by episode: as the effort does.
            transport = info["positive_work"] / (weight * info["step_length"])
            assert info["reward_effort"] == pytest.approx(-0.5 * transport, rel=0.2)
            expected = np.exp(-change)
        assert info["reward_stability"] == pytest.approx(expected, rel=1e-12)
        assert float(reward) == info["reward_stability"] + info["reward_effort"]
        fell += terminated
        if terminated or truncated:
            _, info = env.reset()
    assert fell > 2


def test_a_reward_of_ones_own_is_the_same_in_a_batch(own: Path) -> None:
    """So large that threads share it."""
    arguments: dict[str, Any] = {"autoreset_mode": "SameStep", "disturbance": "rough"}
    envs = gym.make_vec("own_walkers:SmoothWalker-v0", 150, **arguments)
    assert isinstance(envs, PoweredWalkerVectorEnv) and envs.max_episode_steps == 9
    envs.reset(seed=3)
    rewards = [envs.step(np.zeros((150, 2)))[1] for _ in range(6)]
    for i in (0, 70, 149):
        env = gym.make("own_walkers:SmoothWalker-v0", disturbance="rough")
        env.reset(seed=3 + i)
        for reward in rewards:
            _, value, terminated, truncated, _ = env.step(np.zeros(2, np.float32))
            assert value == reward[i]
            if terminated or truncated:
                env.reset()


@pytest.mark.parametrize("name", DECIDING)
def test_a_reward_may_be_a_function_for_every_scheme(name: str) -> None:
    def constant(before: Any, after: Any, strides: Any) -> Any:
        return np.full(len(before), 3.0)

    env = PoweredWalkerEnv(**scheme_arguments(name), reward=constant, disturbance="none")
    env.reset(seed=0)
    assert env.step(np.zeros(env.action_space.shape, np.float32))[1] == 3.0


def bad(before: Any, after: Any, strides: Any) -> Any:
    return np.zeros(7)


def no_number(before: Any, after: Any, strides: Any) -> Any:
    return np.full(len(before), np.nan)


@pytest.mark.parametrize("reward", [bad, no_number])
def test_a_reward_that_gives_something_else_is_named(reward: Any) -> None:
    env = make(reward=reward)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"reward must give \(1,\) finite numbers"):
        env.step(np.zeros(2, np.float32))


@pytest.mark.parametrize(
    ("reward", "message"),
    [
        ("nowhere_at_all:reward", "got 'nowhere_at_all:reward': No module named"),
        ("math:nothing", "got 'math:nothing': module 'math' has no attribute"),
        ("math:pi", "which is 3.14"),
        (":", "reward must lead to a function, got ':'"),
        (3.0, "a function of .* or its path 'module:function', got 3.0"),
    ],
)
def test_a_path_that_leads_to_no_function_is_named(reward: Any, message: str) -> None:
    for maker in (PoweredWalkerEnv, PoweredWalkerVectorEnv):
        with pytest.raises(ValueError, match=message):
            maker(reward=reward)


def test_a_spec_with_a_path_survives_json(own: Path) -> None:
    env = gym.make("own_walkers:SmoothWalker-v0", disturbance=EVERYTHING)
    assert env.spec is not None
    restored = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert_same(record(env, 12, seed=2), record(restored, 12, seed=2))


WORKERS = """
    import gymnasium as gym, numpy as np
    if __name__ == "__main__":
        envs = gym.make_vec("own_walkers:SmoothWalker-v0", 2, vectorization_mode="async",
                            vector_kwargs={"context": "spawn"})
        native = gym.make_vec("own_walkers:SmoothWalker-v0", 2)
        for each in (envs, native):
            each.reset(seed=1)
        there, here = (each.step(np.zeros((2, 2), np.float32))[1] for each in (envs, native))
        envs.close()
        assert (there == here).all() and (there > 0).all(), (there, here)
"""


def test_worker_processes_find_id_and_reward(own: Path) -> None:
    (own / "main.py").write_text(textwrap.dedent(WORKERS))
    command = [sys.executable, str(own / "main.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=own)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("env_id", "limit"), [("SmoothWalker-v0", 9), ("PlainWalker-v0", 7)])
def test_stable_baselines3_takes_ids_of_ones_own(own: Path, env_id: str, limit: int) -> None:
    """A plain `gym.register`, without a vector entry point, too."""
    pytest.importorskip("stable_baselines3")
    from powered_walker_env.sb3 import PoweredWalkerVecEnv

    name = f"own_walkers:{env_id}"
    envs = PoweredWalkerVecEnv(name, 3, seed=4, disturbance="none")
    first = envs.reset()
    singles = [gym.make(name, disturbance="none") for _ in range(3)]
    starts = [env.reset(seed=4 + i)[0] for i, env in enumerate(singles)]
    np.testing.assert_array_equal(first, starts)
    for k in range(limit):
        _, rewards, done, _ = envs.step(np.zeros((3, 2)))
        given = [env.step(np.zeros(2, np.float32)) for env in singles]
        assert rewards.tolist() == [one[1] for one in given]
        assert done.tolist() == [k == limit - 1] * 3
    walkers = make_walkers(name, 2, disturbance="rough")
    assert walkers.task.disturbance == Disturbance(push=0.05)
    assert walkers.max_episode_steps == limit


def test_environments_of_another_class_are_refused(own: Path) -> None:
    for env_id in ("own_walkers:Crooked-v0", "CartPole-v1"):
        with pytest.raises(ValueError, match=rf"environment of this package.* got '{env_id}'"):
            make_walkers(env_id, 2)
    with pytest.raises(gym.error.Error):
        make_walkers("NeverRegistered-v0", 2)


@pytest.mark.parametrize("name", POWERED)
def test_every_preset_can_be_registered_single_and_in_batches(name: str, new_id: str) -> None:
    register_walker(new_id, preset=name, disturbance=Disturbance(push=1e-3), max_episode_steps=3)
    spec = EnvSpec.from_json(gym.spec(new_id).to_json())
    single, batch = gym.make(spec, **spec.kwargs), gym.make_vec(new_id, 2)
    assert isinstance(batch, PoweredWalkerVectorEnv)
    assert_same(single.reset(seed=1)[0], batch.reset(seed=[1, 2])[0][0])
    assert batch.max_episode_steps == 3
    with pytest.raises(ValueError, match="env_id must be new, got 'NewWalker-v0'"):
        register_walker(new_id, preset=name)


def test_objects_are_registered_as_json(new_id: str) -> None:
    walker = PRESETS["toe-off"]
    register_walker(
        new_id,
        params=walker.params,
        control=LateToeOff(0.1),
        gait=np.array(walker.state),
        reward=no_number,
    )
    kwargs = json.loads(json.dumps(gym.spec(new_id).kwargs))
    assert kwargs["scheme"] == "late-toe-off" and kwargs["control"] == [0.1]
    assert kwargs["reward"] == "tests.envs.test_own_package:no_number"
    env = gym.make(new_id).unwrapped
    assert isinstance(env, PoweredWalkerEnv)
    assert env.task.control == LateToeOff(0.1) and env.task.reward is no_number


BAD: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"preset": "camp1998"}, ValueError, "got 'camp1998'"),
    ({"presets": "camp1997"}, TypeError, "unexpected keyword argument 'presets'"),
    ({"reward": lambda before, after, strides: 0.0}, ValueError, "reward must be importable"),
    ({"params": object()}, ValueError, "arguments must be JSON"),
    ({"effort_weight": float("nan")}, ValueError, "arguments must be JSON"),
    ({"disturbance": {"parameters": 1e6}}, ValueError, "disturbance parameters must"),
    *(({"preset": name}, ValueError, "preset must be a powered walker") for name in PASSIVE),
    ({"scheme": "passive"}, ValueError, "scheme must power the walker"),
]


@pytest.mark.parametrize(("arguments", "error", "message"), BAD)
def test_what_cannot_be_made_is_not_registered(
    arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        register_walker("NeverRegistered-v0", **arguments)
    assert "NeverRegistered-v0" not in gym.registry


@pytest.mark.parametrize("name", DECIDING)
def test_arguments_as_a_dictionary_make_the_same_task(name: str) -> None:
    given = TaskArguments.of({**scheme_arguments(name), "effort_weight": 0.5})
    again = TaskArguments.of(json.loads(json.dumps(given.to_dict())))
    assert again.to_dict() == given.to_dict()
    one, two = (PoweredWalkerEnv(**each.to_dict()) for each in (given, again))
    assert one.task.control == two.task.control and one.task.params == two.task.params
    assert one.task.effort_weight == 0.5


def test_all_environments_take_the_same_arguments() -> None:
    """Every one of the record, by name, single, in a batch and registered."""
    walker = PRESETS["round-foot"]
    arguments: dict[str, Any] = {
        "preset": None,
        "params": walker.params,
        "scheme": "motor",
        "control": (2.704, 3371.8),
        "gait": list(walker.state),
        "action_range": (0.1, 0.2),
        "reward": "periodicity",
        "effort_weight": 0.1,
        "disturbance": "none",
    }
    assert list(arguments) == list(TaskArguments.__dataclass_fields__)
    tasks = [PoweredWalkerEnv(**arguments).task, PoweredWalkerVectorEnv(2, **arguments).task]
    tasks.append(make_walkers(ROUND_FOOT, 2, **arguments).task)
    for task in tasks:
        assert (task.reward, task.effort_weight) == ("periodicity", 0.1)
        assert task.action_range == (0.1, 0.2) and task.disturbance == Disturbance()
        assert task.params == walker.params and task.control == walker.control
