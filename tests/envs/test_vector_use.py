"""The native vector environment in use: make_vec, wrappers, copies, bad input, its memory."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import NormalizeObservation, RecordEpisodeStatistics

from powered_walker_env import Outcome, PoweredWalkerVectorEnv
from tests.helpers.episodes import EVERYTHING, FORWARD_FALL, ROUND_FOOT, assert_same

ZEROS = np.zeros((3, 2), np.float32)
BYTES = 1300  # of memory for each walker, at most: its row, with three chains, takes 930


def make(count: int = 3, **arguments: Any) -> PoweredWalkerVectorEnv:
    envs = gym.make_vec(
        ROUND_FOOT, count, vectorization_mode="vector_entry_point", **arguments
    ).unwrapped
    assert isinstance(envs, PoweredWalkerVectorEnv)
    return envs


def test_make_vec_injects_the_registered_limit_or_ones_own() -> None:
    for arguments, limit in (({}, 100), ({"max_episode_steps": 5}, 5)):
        envs = make(disturbance="none", **arguments)
        assert envs.max_episode_steps == limit
        envs.reset(seed=0)
        ends = [envs.step(ZEROS)[3].all() for _ in range(limit)]
        assert ends == [False] * (limit - 1) + [True]
    unlimited = PoweredWalkerVectorEnv(3, preset="round-foot", disturbance="none")
    unlimited.reset(seed=0)
    assert not any(unlimited.step(ZEROS)[3].any() for _ in range(120))


def test_spaces_metadata_and_spec_are_those_of_a_vector_environment() -> None:
    envs = make(autoreset_mode="SameStep")
    assert envs.autoreset_mode == envs.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    assert envs.single_observation_space == gym.spaces.Box(-20, 20, (4,), np.float32)
    assert envs.observation_space.shape == (3, 4) and envs.action_space.shape == (3, 2)
    assert envs.spec is not None and envs.spec.id == ROUND_FOOT
    again = gym.make_vec(envs.spec).unwrapped
    assert_same(again.reset(seed=1), envs.reset(seed=1))


def test_observations_are_in_the_space_and_rewards_are_float64() -> None:
    envs = make(64, disturbance="rough")
    observation, _ = envs.reset(seed=0)
    envs.action_space.seed(0)
    for _ in range(20):
        assert observation in envs.observation_space
        observation, reward, terminated, truncated, _ = envs.step(envs.action_space.sample())
        assert reward.dtype == np.float64
        assert terminated.dtype == truncated.dtype == np.bool_


@pytest.mark.parametrize("copies", [lambda envs: pickle.loads(pickle.dumps(envs)), copy.deepcopy])
@pytest.mark.parametrize("mode", list(AutoresetMode)[:2])
def test_a_copy_made_in_the_middle_of_a_walk_goes_on_alike(copies: Any, mode: Any) -> None:
    envs = make(disturbance=EVERYTHING, autoreset_mode=mode)
    envs.reset(seed=0)
    envs.step(ZEROS)
    twin = copies(envs)
    for _ in range(40):
        assert_same(envs.step(ZEROS), twin.step(ZEROS))


def test_what_is_given_is_the_callers_own() -> None:
    envs, untouched = make(), make()
    given = [envs.reset(seed=0)]
    untouched.reset(seed=0)
    for _ in range(5):
        given.append(envs.step(ZEROS))
        kept = copy.deepcopy(given)
        expected = untouched.step(ZEROS)
        assert_same(given[-1], expected)
        for value in (*given[-1][:4], *given[-1][4].values()):
            value.fill(1)  # spoils nothing inside, and nothing given before
        assert_same(given[:-1], kept[:-1])


def test_statistics_of_episodes_are_recorded() -> None:
    envs = RecordEpisodeStatistics(make(64, disturbance="rough"))
    envs.reset(seed=0)
    lengths: list[int] = []
    for _ in range(60):
        info = envs.step(np.zeros((64, 2), np.float32))[4]
        if "episode" in info:
            lengths += info["episode"]["l"][info["_episode"]].tolist()
    assert len(lengths) > 300
    assert 2.0 < np.mean(lengths) < 6.0  # with the fall: rough pushes leave two or three strides


def test_observations_are_normalised() -> None:
    envs = NormalizeObservation(make(64))
    envs.reset(seed=0)
    observations = [envs.step(np.zeros((64, 2), np.float32))[0] for _ in range(60)]
    late = np.concatenate(observations[30:])
    assert late.std(axis=0) == pytest.approx(np.ones(4), abs=0.2)


def test_disabled_autoreset_waits_for_the_reset() -> None:
    envs = make(autoreset_mode="Disabled", disturbance="none")
    envs.reset(seed=0)
    mask = np.array([False, True, False])
    envs.reset(options={"state": FORWARD_FALL, "reset_mask": mask})
    assert envs.step(ZEROS)[2].tolist() == [False, True, False]
    for _ in range(2):
        with pytest.warns(UserWarning, match=r"after walkers \[1\] fell"):
            observation, reward, fell, _, info = envs.step(ZEROS)
        assert fell.tolist() == [False, True, False]
        assert reward == pytest.approx([1.0, 0.0, 1.0], abs=1e-9)
        assert info["duration"][1] == 0.0 and info["outcome"][1] == Outcome.FELL_FORWARD
        assert observation in envs.observation_space
    envs.reset(options={"reset_mask": mask})
    assert not envs.step(ZEROS)[2].any()


def test_a_walk_begins_with_a_reset_of_all() -> None:
    envs = make()
    with pytest.raises(gym.error.ResetNeeded, match=r"call reset\(\)"):
        envs.step(ZEROS)
    envs.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(gym.error.ResetNeeded, match=r"call reset\(\)"):
        envs.step(ZEROS)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_envs": 0}, "num_envs must be at least 1, got 0"),
        ({"max_episode_steps": 0}, "max_episode_steps must be at least 1, got 0"),
        ({"render_mode": "ansi"}, "render_mode must be one of .* got 'ansi'"),
        ({"preset": "simplest"}, "preset must be a powered walker, got 'simplest'"),
        ({"autoreset_mode": "Sometimes"}, "Sometimes"),
    ],
)
def test_bad_arguments_of_its_own_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PoweredWalkerVectorEnv(**arguments)


@pytest.mark.parametrize(
    "actions", [np.zeros(2), np.zeros((2, 2)), np.zeros((3, 3)), np.full((3, 2), np.nan), None]
)
def test_bad_actions_are_refused(actions: Any) -> None:
    envs = make()
    envs.reset(seed=0)
    with pytest.raises(ValueError, match="action must"):
        envs.step(actions)


@pytest.mark.parametrize(
    ("reset", "message"),
    [
        ({"seed": [1, 2]}, "seed must be one or 3 seeds, got 2"),
        ({"options": {"states": 1}}, "reset options are state"),
        ({"options": {"reset_mask": [True, True, False]}}, "reset_mask"),
        ({"options": {"reset_mask": np.zeros(3, np.bool_)}}, "reset_mask"),
        ({"options": {"reset_mask": np.ones(2, np.bool_)}}, "reset_mask"),
    ],
)
def test_bad_resets_are_refused(reset: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make().reset(**reset)


@pytest.mark.parametrize("disturbance", ["light", EVERYTHING], ids=["pushes", "all"])
def test_a_walker_takes_little_memory(disturbance: Any) -> None:
    count = 20_000
    envs = make(count, disturbance=disturbance)
    envs.reset(seed=0)
    assert len(pickle.dumps(envs)) < count * BYTES


def test_the_kernels_are_compiled_once_for_single_and_batch() -> None:
    code = """
        import gymnasium, numpy as np
        import powered_walker_env
        from powered_walker_env.simulation import kernel
        from powered_walker_env.envs import noise, stepping

        kinds = ("push", "ground", "slope", "torque", "sensor", "parameters")
        everything = dict.fromkeys(kinds, 0.01)
        for disturbance in ("light", everything):
            env = gymnasium.make("PoweredWalker-v0", disturbance=disturbance).unwrapped
            env.reset(seed=0)
            for action in ([0, 0], np.zeros(2, np.float32), np.ones(2)):
                env.reset()
                env.step(action)
            for mode in ("NextStep", "SameStep"):
                envs = gymnasium.make_vec(
                    "PoweredWalker-v0", 70, disturbance=disturbance, autoreset_mode=mode
                )
                envs.reset(seed=0)
                for _ in range(4):
                    envs.step(np.asfortranarray(envs.action_space.sample()))
        for each in (
            stepping.begin_episodes, stepping.begin_strides, stepping.end_strides,
            noise.draw_normals,
            kernel.run_strides,
        ):
            assert len(each.signatures) == 1, (each, each.signatures)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_a_first_step_compiles_the_steppings_own_functions_and_nothing_else(
    tmp_path: Path,
) -> None:
    """A `min`, an index by an array or a copied row would bring numba's error messages along."""
    code = """
        from numba.core import event
        from powered_walker_env import PoweredWalkerEnv
        from powered_walker_env.envs import walkers

        def land(code, starts, acting, packed, heights, rtol, results):
            results.fill(0.0)  # in the place of the stride kernel, which takes long to compile

        walkers.run_rows = land
        env = PoweredWalkerEnv(disturbance={"push": 0.01, "parameters": 0.01})
        with event.install_recorder("numba:compile") as recorder:
            env.reset(seed=0)
            assert not env.step([0.0, 0.0])[2]
        compiled = [each.data["dispatcher"].py_func for _, each in recorder.buffer if each.is_start]
        rooms = {"powered_walker_env.envs." + room for room in ("noise", "rewards", "stepping")}
        assert {each.__module__ for each in compiled} == rooms, compiled
        assert len(compiled) == len(set(compiled)), compiled
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
    )
    assert done.returncode == 0, done.stderr
