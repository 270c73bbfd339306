"""The native batch against Gymnasium's Sync and Async over hundreds of falls, bit for bit."""

from __future__ import annotations

import functools
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from powered_walker_env import PRESETS, PoweredWalkerEnv, PoweredWalkerVectorEnv
from tests.helpers.episodes import EVERYTHING, IDS, ROUND_FOOT, assert_same

pytestmark = pytest.mark.slow
WALKERS, FALLS, MOST = 8, 300, 2000
FORMS = {
    "sync": gym.vector.SyncVectorEnv,
    "async": functools.partial(gym.vector.AsyncVectorEnv, context="spawn"),
}
MODES = (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED)


def both_walk(native: Any, theirs: Any, mode: AutoresetMode) -> None:
    """Compare all that the two give, until enough walkers have fallen."""
    assert_same(native.reset(seed=11), theirs.reset(seed=11))
    rng, falls, steps = np.random.default_rng(0), 0, 0
    shape = native.action_space.shape
    while falls < FALLS:
        assert steps < MOST, f"only {falls} falls"
        steps += 1
        actions = rng.uniform(-0.3, 0.3, shape).astype(np.float32)
        given, expected = native.step(actions), theirs.step(actions)
        assert_same(given, expected, f"step {steps}")
        over = given[2] | given[3]
        falls += int(given[2].sum())
        if mode is AutoresetMode.DISABLED and over.any():
            options = {"reset_mask": over}
            assert_same(
                native.reset(options=dict(options)), theirs.reset(options=dict(options)),
                f"reset {steps}",
            )  # fmt: skip
    native.close()
    theirs.close()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("form", "env_id"), [*(("sync", i) for i in IDS), ("async", ROUND_FOOT)])
def test_the_native_batch_is_theirs_bit_for_bit(
    mode: AutoresetMode, form: str, env_id: str
) -> None:
    native = gym.make_vec(
        env_id, WALKERS, vectorization_mode="vector_entry_point", autoreset_mode=mode.value
    )
    theirs = FORMS[form](
        [functools.partial(gym.make, f"powered_walker_env:{env_id}")] * WALKERS,
        autoreset_mode=mode,
    )
    both_walk(native, theirs, mode)


@pytest.mark.parametrize("name", [n for n, p in PRESETS.items() if p.control is not None])
def test_every_powered_preset_with_all_that_disturbs(name: str) -> None:
    arguments: dict[str, Any] = {"preset": name, "disturbance": EVERYTHING}
    mode = AutoresetMode.NEXT_STEP
    native = PoweredWalkerVectorEnv(WALKERS, autoreset_mode=mode.value, **arguments)
    single = functools.partial(PoweredWalkerEnv, **arguments)
    both_walk(native, gym.vector.SyncVectorEnv([single] * WALKERS, autoreset_mode=mode), mode)
