"""The environments as others find them: ids, specs, worker processes, a bare installation."""

from __future__ import annotations

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
from gymnasium.utils.env_checker import check_env

import powered_walker_env
from powered_walker_env import ENVIRONMENTS, PRESETS, PoweredWalkerEnv, PoweredWalkerVectorEnv
from powered_walker_env.envs.registration import (
    MAX_EPISODE_STEPS,
    PREVIOUS,
    family,
    register_environments,
)
from tests.helpers.episodes import EVERYTHING, IDS, ROUND_FOOT, assert_same, record

NOT_NEEDED = ("torch", "stable_baselines3", "sb3_contrib", "pygame", "matplotlib", "PIL", "yaml")


def run(code: str, *arguments: str) -> str:
    """What a fresh Python prints."""
    command = [sys.executable, "-W", "error", "-c", textwrap.dedent(code), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("env_id", IDS)
def test_every_id_makes_its_walker_with_its_limit(env_id: str) -> None:
    preset, threshold = ENVIRONMENTS[env_id]
    spec = gym.spec(env_id)
    assert spec.max_episode_steps == MAX_EPISODE_STEPS
    assert spec.reward_threshold == threshold
    assert not spec.nondeterministic
    env = gym.make(env_id).unwrapped
    assert isinstance(env, PoweredWalkerEnv)
    assert env.task.params == PRESETS[preset].params
    assert env.task.control == PRESETS[preset].control
    np.testing.assert_array_equal(env.task.gait, [PRESETS[preset].state])
    envs = gym.make_vec(env_id, 2)  # the native batch is the default
    assert isinstance(envs, PoweredWalkerVectorEnv)
    assert envs.task.params == env.task.params
    assert envs.max_episode_steps == MAX_EPISODE_STEPS


@pytest.mark.parametrize("env_id", PREVIOUS)
def test_an_older_version_is_what_it_was_and_names_the_newer(env_id: str) -> None:
    with pytest.warns(DeprecationWarning, match="out of date"):
        env = gym.make(env_id)
    threshold, arguments = PREVIOUS[env_id]
    assert env.spec is not None and env.spec.reward_threshold == threshold
    check_env(env.unwrapped, skip_render_check=True)
    newer = next(each for each in ENVIRONMENTS if family(each) == family(env_id))
    assert_same(record(env, 20, seed=0), record(gym.make(newer, **arguments), 20, seed=0))


def test_as_published_v0_has_the_ranges_that_it_had() -> None:
    arguments = PREVIOUS["PoweredWalkerAsPublished-v0"][1]
    task = PoweredWalkerEnv(**arguments).task
    np.testing.assert_allclose(task.half_range, [0.15, 0.03 * 692.0], rtol=1e-15)


def test_registering_again_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    before = dict(gym.registry)
    register_environments()
    assert gym.registry == before
    own = EnvSpec(ROUND_FOOT, entry_point="elsewhere:Env")
    monkeypatch.setitem(gym.registry, ROUND_FOOT, own)
    register_environments()
    assert gym.registry[ROUND_FOOT] is own


ARGUMENTS: list[dict[str, Any]] = [
    {},
    {"disturbance": EVERYTHING, "reward": "contraction", "effort_weight": 0.1},
    {
        "preset": None,
        "params": PRESETS["round-foot"].params.to_dict(),
        "control": [2.704, 3371.8],
        "gait": [list(PRESETS["round-foot"].state)],
        "action_range": [0.1, 0.2],
    },
]


@pytest.mark.parametrize("arguments", ARGUMENTS, ids=str)
def test_a_spec_survives_json_and_makes_the_same_environment(arguments: dict[str, Any]) -> None:
    env = gym.make(ROUND_FOOT, **arguments)
    assert env.spec is not None
    restored = EnvSpec.from_json(env.spec.to_json())
    expected = record(env, 20, seed=0)
    assert_same(record(gym.make(restored), 20, seed=0), expected)
    assert_same(record(gym.make(env.spec), 20, seed=0), expected)
    plain = EnvSpec.from_json(gym.spec(ROUND_FOOT).to_json())
    assert_same(record(gym.make(plain, **arguments), 20, seed=0), expected)


OWN_MODULE = """
import gymnasium as gym

gym.register(
    id="MyWalker-v3",
    entry_point="powered_walker_env:PoweredWalkerEnv",
    vector_entry_point="powered_walker_env:PoweredWalkerVectorEnv",
    max_episode_steps=7,
    kwargs={"preset": "round-foot", "disturbance": {"push": 0.01}, "reward": "periodicity"},
)
"""


@pytest.fixture
def own_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "my_walkers.py").write_text(OWN_MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield "my_walkers"
    gym.registry.pop("MyWalker-v3", None)
    sys.modules.pop("my_walkers", None)


def test_other_peoples_modules_register_walkers_of_their_own(own_module: str) -> None:
    env = gym.make(f"{own_module}:MyWalker-v3")
    assert isinstance(env.unwrapped, PoweredWalkerEnv)
    env.reset(seed=0, options={"state": PRESETS["round-foot"].state})
    ends = [env.step(np.zeros(2, np.float32))[3] for _ in range(7)]
    assert ends == [False] * 6 + [True]
    envs = gym.make_vec(f"{own_module}:MyWalker-v3", 3)
    assert isinstance(envs, PoweredWalkerVectorEnv)
    assert envs.max_episode_steps == 7
    assert envs.task.reward == "periodicity" and envs.task.disturbance.push == 0.01


WORKERS = """
    import gymnasium as gym

    def make():
        return gym.make("powered_walker_env:PoweredWalker-v0")

    def walk(seed):
        env = make()
        env.reset(seed=seed)
        return env.step([0.0, 0.0])[4]["state"].tolist()
"""

POOL = """
import multiprocessing, sys
from workers import walk
if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        there = pool.map(walk, [1, 2])
    assert there == [walk(1), walk(2)], there
"""

SUBPROC = """
import numpy as np
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv
from workers import walk
if __name__ == "__main__":
    envs = make_vec_env(
        "powered_walker_env:PoweredWalker-v0", n_envs=2, seed=1,
        vec_env_cls=SubprocVecEnv, vec_env_kwargs={"start_method": "spawn"},
    )
    envs.reset()
    there = [info["state"].tolist() for info in envs.step(np.zeros((2, 2), np.float32))[3]]
    envs.close()
    assert there == [walk(1), walk(2)], there
"""


@pytest.mark.parametrize("script", [POOL, SUBPROC], ids=["pool", "subproc"])
def test_spawned_workers_find_the_environment(tmp_path: Path, script: str) -> None:
    if "stable_baselines3" in script:
        pytest.importorskip("stable_baselines3")
    (tmp_path / "workers.py").write_text(textwrap.dedent(WORKERS))
    (tmp_path / "main.py").write_text(script)
    command = [sys.executable, str(tmp_path / "main.py")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr


def test_nothing_that_trains_or_draws_is_needed() -> None:
    run(
        """
        import sys

        class Blocked:
            def find_spec(self, name, path=None, target=None):
                if name.split(".")[0] in sys.argv[1:]:
                    raise ImportError(f"{name} is blocked")

        sys.meta_path.insert(0, Blocked())
        import gymnasium, powered_walker_env
        for env_id in powered_walker_env.ENVIRONMENTS:
            env = gymnasium.make(env_id)
            env.reset(seed=0)
            env.step(env.action_space.sample())
        envs = gymnasium.make_vec(env_id, 3)
        envs.reset(seed=0)
        envs.step(envs.action_space.sample())
        try:
            gymnasium.make(env_id, render_mode="rgb_array").reset()
        except ImportError as error:
            assert "powered-walker-env[render]" in str(error), error
        else:
            raise AssertionError("drawn without pygame")
        """,
        *NOT_NEEDED,
    )


def test_the_import_compiles_nothing_and_loads_nothing_that_trains_or_draws() -> None:
    run(
        """
        import sys
        from numba.core import event

        with event.install_recorder("numba:compile") as recorder:
            import powered_walker_env
        assert not recorder.buffer, recorder.buffer
        assert not set(sys.argv[1:]) & set(sys.modules), sys.modules
        """,
        *(name for name in NOT_NEEDED if name != "yaml"),  # numba's own
    )


def test_everything_public_is_there() -> None:
    for name in powered_walker_env.__all__:
        assert getattr(powered_walker_env, name) is not None
