"""Saved policies become models of Stable-Baselines3 that act as they do, and learn on."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("sb3_contrib")

from powered_walker_env.controllers import (
    Network,
    evaluate,
    load_network,
    save_network,
    shipped_policies,
)
from powered_walker_env.controllers.sb3_models import KINDS, sb3_model
from powered_walker_env.controllers.shipped import FOLDER
from powered_walker_env.sb3 import PoweredWalkerVecEnv

ENV_ID = "PoweredWalkerKneed-v0"
SEEN = np.random.default_rng(1).normal(size=(50, 4)).astype(np.float32)


def a_network(squash: str, algo: str = "", activation: str = "Tanh") -> Network:
    rng, sizes = np.random.default_rng(0), (4, 9, 7, 2)
    layers = [
        (0.6 * rng.normal(size=(n, m)), 0.1 * rng.normal(size=n))
        for m, n in itertools.pairwise(sizes)
    ]
    return Network(layers, activation, squash, {"algo": algo})


def small(algo: str) -> dict[str, Any]:
    if algo in ("ppo", "a2c"):
        return {"n_steps": 8} | ({"batch_size": 16} if algo == "ppo" else {})
    return {"buffer_size": 200, "learning_starts": 8}


@pytest.mark.parametrize("activation", ["Tanh", "ReLU"])
@pytest.mark.parametrize("algo", KINDS)
def test_a_model_acts_as_the_file_does_and_learns_on(
    algo: str, activation: str, tmp_path: Path
) -> None:
    network = a_network(KINDS[algo][1], algo.upper(), activation)
    save_network(network, tmp_path / "p.npz", single=True)
    saved, env = load_network(tmp_path / "p.npz"), PoweredWalkerVecEnv(ENV_ID, 2)
    model = sb3_model(saved, env, seed=0, **small(algo))
    np.testing.assert_allclose(
        model.predict(SEEN, deterministic=True)[0], saved.predict(SEEN)[0], atol=3e-6
    )
    model.learn(32)
    assert model.num_timesteps >= 32
    env.close()


@pytest.mark.parametrize("algo", ["ppo", "sac", "tqc"])
def test_there_and_back_nothing_is_lost(algo: str, tmp_path: Path) -> None:
    from powered_walker_env.controllers.stable_baselines import double_precision

    save_network(a_network(KINDS[algo][1], algo), tmp_path / "p.npz", single=True)
    saved = load_network(tmp_path / "p.npz")
    again = double_precision(sb3_model(saved, PoweredWalkerVecEnv(ENV_ID, 2), **small(algo)))
    for one, other in zip(saved.layers, again.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def test_a_model_scores_as_the_file_does() -> None:
    network = a_network("tanh", "crossq")
    model = sb3_model(network, PoweredWalkerVecEnv(ENV_ID, 1), **small("crossq"))
    ours, theirs = (evaluate(each, ENV_ID, 20).strides.mean() for each in (network, model))
    assert theirs == pytest.approx(ours, abs=0.5)


@pytest.mark.parametrize(
    ("algo", "squash", "message"),
    [
        ("dqn", "clip", "algo must be one of ppo, a2c, sac, tqc, crossq, got 'dqn'"),
        ("", "clip", "algo must be one of .*, got ''"),
        ("sac", "clip", "must squash its actions by 'clip' as the network does, got 'sac'"),
    ],
)
def test_what_does_not_fit_is_refused(algo: str, squash: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        sb3_model(a_network(squash), PoweredWalkerVecEnv(ENV_ID, 1), algo or None)


def test_another_task_is_refused() -> None:
    env = PoweredWalkerVecEnv("PoweredWalkerKneed-v0", 1)
    network = a_network("clip")
    one = Network([*network.layers[:-1], (np.ones((1, 7)), np.ones(1))], settings={"algo": "ppo"})
    with pytest.raises(ValueError, match=r"actions of shape \(4,\) and \(1,\), as the network"):
        sb3_model(one, env)


@pytest.mark.parametrize("name", shipped_policies())
def test_what_comes_with_the_package_goes_into_plain_sb3(name: str) -> None:
    network, about = load_network(FOLDER / name), shipped_policies()[name]
    algo = about["learner"] if about["learner"] in ("sac", "tqc", "crossq") else "ppo"
    model = sb3_model(network, PoweredWalkerVecEnv(about["env_id"], 1), algo)
    x = np.random.default_rng(0).normal(size=(50, 4)).astype(np.float32)
    np.testing.assert_allclose(
        model.predict(x, deterministic=True)[0], network.predict(x)[0], atol=1e-4
    )
