"""The task as formulas: rewards, scales, random numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.stats

from powered_walker_env import PRESETS, PoweredWalkerEnv, WalkerParams
from powered_walker_env.envs.noise import ADVANCE, draw_normals, mixed
from powered_walker_env.envs.rewards import REWARDS
from powered_walker_env.envs.task import state_scale
from tests.helpers.episodes import EVERYTHING, IDS, gentle_actions, make, record

SCALE = np.array([0.05, 0.05, 0.15, 0.3])  # where √(g/10L) is 1, as of all but the kneed walker
FLOOR = 0.01  # ε of the contraction


def distance(state: Any, gait: Any, pace: float = 1.0) -> float:
    scale = SCALE * (1.0, 1.0, pace, pace)
    return float(np.linalg.norm((np.asarray(state) - gait) / scale))


@pytest.mark.parametrize("effort_weight", [0.0, 0.5])
@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("env_id", IDS)
def test_the_terms_of_the_reward_sum_to_it(env_id: str, reward: str, effort_weight: float) -> None:
    env = make(env_id, reward=reward, effort_weight=effort_weight, disturbance=EVERYTHING)
    for step in record(env, 30, seed=0):
        if len(step) == 5:
            info = step[4]
            terms = [value for name, value in info.items() if name.startswith("reward_")]
            assert len(terms) == 3
            assert math.fsum(terms) == pytest.approx(step[1], abs=1e-15)


@pytest.mark.parametrize("reward", REWARDS)
def test_rewards_follow_their_formulas(reward: str) -> None:
    env = make(reward=reward)
    gait = PRESETS["round-foot"].state
    _, info = env.reset(seed=4)
    for action in gentle_actions(20):
        before = info["state"]
        _, value, terminated, _, info = env.step(action)
        if terminated:
            break
        d, landed = distance(before, gait), distance(info["state"], gait)
        expected = {
            "deviation": math.exp(-(landed**2) / 2),
            "contraction": math.log((d + FLOOR) / (landed + FLOOR)),
            "periodicity": math.exp(-(distance(before, info["state"]) ** 2) / 2),
        }[reward]
        assert value == pytest.approx(expected, rel=1e-12)
        assert info["distance"] == pytest.approx(landed, rel=1e-12)


@pytest.mark.parametrize("env_id", IDS)
def test_the_contraction_telescopes(env_id: str) -> None:
    env = make(env_id, reward="contraction")
    _, info = env.reset(seed=1)
    params = env.task.params
    pace = math.sqrt(params.gravity / (10 * params.leg_length))
    first = distance(info["state"], env.task.gait[0], pace)
    total, last = 0.0, first
    for _ in range(100):
        _, reward, terminated, _, info = env.step(np.zeros(2, np.float32))
        if terminated:
            assert reward == -10.0
            break
        total, last = total + reward, info["distance"]
    assert total == pytest.approx(math.log((first + FLOOR) / (last + FLOOR)), abs=1e-12)


def test_effort_is_the_mechanical_cost_of_transport() -> None:
    env = make(effort_weight=2.0, disturbance="none")
    plain = make(disturbance="none")
    for each in (env, plain):
        each.reset(seed=0)
    weight = 2 * env.task.params.leg_mass * env.task.params.gravity
    for action in 0.1 * gentle_actions(5):
        value = env.step(action)[1]
        _, deviation, terminated, _, info = plain.step(action)
        assert not terminated
        transport = info["positive_work"] / (weight * info["step_length"])
        assert value == pytest.approx(deviation - 2.0 * transport, abs=1e-14)
        assert 0.0 < transport < 1.0


def test_the_scale_goes_with_the_walkers_own_time() -> None:
    np.testing.assert_array_equal(state_scale(WalkerParams()), SCALE)
    small = state_scale(WalkerParams(leg_length=0.25, com_along=0.2))
    np.testing.assert_allclose(small, SCALE * [1, 1, 2, 2])


def test_the_same_walker_at_another_size_earns_the_same() -> None:
    """Lengths over 4, masses over 8: dynamic similarity."""
    big = PRESETS["round-foot"]
    assert big.control is not None
    p = big.params
    small = p.replace(
        leg_length=p.leg_length / 4,
        foot_length=p.foot_length / 4,
        foot_radius=p.foot_radius / 4,
        com_along=p.com_along / 4,
        leg_mass=p.leg_mass / 8,
        leg_inertia=p.leg_inertia / 128,
        no_load_speed=p.no_load_speed * 2,
    )
    gait = np.array(big.state) * [1, 1, 2, 2]
    one = make(disturbance="none")
    two = PoweredWalkerEnv(
        params=small,
        control=(big.control.switch_angle, big.control.stall_torque / 32),
        gait=gait.tolist(),
        action_range=(0.2, 0.3),
        disturbance="none",
        effort_weight=1.0,
    )
    one = make(disturbance="none", effort_weight=1.0)
    start = np.array(big.state) + 0.001
    a, _ = one.reset(options={"state": start.tolist()})
    b, _ = two.reset(options={"state": (start * [1, 1, 2, 2]).tolist()})
    for action in gentle_actions(3):
        assert b == pytest.approx(a, abs=1e-5)
        a, reward, *_ = one.step(action)
        b, other, *_ = two.step(action)
        assert other == pytest.approx(reward, abs=1e-6)


def test_the_mixer_gives_the_published_numbers_of_splitmix64() -> None:
    """Seed 1234567, as other implementations print it."""
    seed = 1234567
    states = [np.uint64((seed + k * int(ADVANCE)) % 2**64) for k in range(1, 6)]
    with np.errstate(over="ignore"):  # the product is that modulo 2⁶⁴
        mixes = [int(mixed.py_func(state)) for state in states]
    assert mixes == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


def test_the_draws_are_normal_and_independent() -> None:
    words = np.random.default_rng(0).integers(2**64, size=20_000, dtype=np.uint64)
    sizes = np.array([1.0, 1.0, 2.0, 0.0])
    draws = np.empty((len(words), 4))
    draw_normals(words, sizes, draws)
    assert not draws[:, 3].any()
    unit = draws[:, :3] / sizes[:3]
    for column in unit.T:
        assert scipy.stats.kstest(column, "norm").pvalue > 1e-3
    later = np.empty_like(draws)
    draw_normals(words, sizes, later)
    together = np.corrcoef(np.hstack([unit, unit**2, later[:, :2], later[:, :2] ** 2]).T)
    assert abs(together - np.eye(len(together))).max() < 4 / math.sqrt(len(words))


def test_a_walkers_draws_do_not_depend_on_its_neighbours() -> None:
    words = np.arange(7, dtype=np.uint64)
    together, alone = np.empty((7, 8)), np.empty((1, 8))
    draw_normals(words.copy(), np.ones(8), together)
    for i, word in enumerate(words):
        draw_normals(np.array([word]), np.ones(8), alone)
        np.testing.assert_array_equal(alone[0], together[i])
