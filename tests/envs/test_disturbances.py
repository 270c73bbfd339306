"""Disturbances: each kind does what it says and no more; levels; paired seeds."""

from __future__ import annotations

import functools
import itertools
import math
import re
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Disturbance,
    Outcome,
    PoweredWalkerEnv,
    PoweredWalkerVectorEnv,
    WalkerParams,
    stride_batch,
)
from powered_walker_env.envs.disturbances import KINDS, SPREAD_FIELDS, episode_params
from powered_walker_env.envs.levels import LEVELS, SIZES, disturbance_of
from powered_walker_env.envs.task import state_scale
from powered_walker_env.model.knee import thigh_of
from powered_walker_env.model.mechanics.packing import params_of
from powered_walker_env.model.quantities import quantities
from tests.helpers.episodes import EVERYTHING, make
from tests.helpers.samples import MOTORS, POWERED

COUNT = 4000
ROUND = PRESETS["round-foot"]
PUSHES = {  # rad/s, (light, medium, rough): fixed
    "camp1997": (0.005, 0.007, 0.01),
    "camp1997-as-published": (0.02, 0.028, 0.04),
    "round-foot": (0.02, 0.032, 0.05),
    "kneed": (0.025, 0.035, 0.05),
}


def walkers(disturbance: Any, count: int = COUNT, **arguments: Any) -> PoweredWalkerVectorEnv:
    arguments = {"preset": "round-foot", **arguments}
    return PoweredWalkerVectorEnv(count, disturbance=disturbance, **arguments)


def is_normal(sample: np.ndarray, deviation: float) -> bool:
    """Whether mean and deviation are those of a normal sample within 4 standard errors."""
    error = deviation / math.sqrt(len(sample))
    return abs(sample.mean()) < 4 * error and abs(sample.std() - deviation) < 3 * error


def test_without_disturbance_every_walker_walks_the_gait() -> None:
    envs = walkers("none", 5)
    _, info = envs.reset(seed=0)
    for _ in range(3):
        np.testing.assert_allclose(info["state"], np.tile(ROUND.state, (5, 1)), atol=1e-7)
        observation, *_, info = envs.step(np.zeros((5, 2)))
        assert abs(observation).max() < 1e-5
        np.testing.assert_array_equal(info["step_height"], np.zeros(5))


def test_pushes_hit_both_rates_after_every_heel_strike() -> None:
    envs = walkers({"push": 0.02})
    observation, info = envs.reset(seed=0)
    at_start = info["state"] - np.array(ROUND.state)
    *_, info = envs.step(np.zeros((COUNT, 2)))
    unpushed = walkers("none", 1)
    for pushes in (at_start,):
        assert not pushes[:, :2].any()
        assert is_normal(pushes[:, 2], 0.02) and is_normal(pushes[:, 3], 0.02)
        assert abs(np.corrcoef(pushes[:, 2:].T)[0, 1]) < 4 / math.sqrt(COUNT)
    np.testing.assert_allclose(observation, at_start / state_scale(ROUND.params), atol=1e-6)
    # After the stride the push comes on top of where the undisturbed map leads.
    for i in range(3):
        unpushed.reset(options={"state": (np.array(ROUND.state) + at_start[i]).tolist()})
        *_, free = unpushed.step(np.zeros((1, 2)))
        push = info["state"][i] - free["state"][0]
        assert not push[:2].any()
        assert 0 < abs(push[2:]).max() < 0.1


def test_the_ground_is_level_but_for_a_new_height_at_every_landing() -> None:
    envs = walkers({"ground": 0.001}, preset="camp1997-as-published")
    envs.reset(seed=0)
    levels = np.zeros(COUNT)
    for _ in range(2):
        _, _, fell, _, info = envs.step(np.zeros((COUNT, 2)))
        levels += info["step_height"]
        assert is_normal(levels, 0.001)
        assert not fell.any()
    assert info["step_height"].std() == pytest.approx(0.001 * math.sqrt(2), rel=0.1)


def test_heights_of_the_ground_are_in_leg_lengths() -> None:
    half = WalkerParams(leg_length=0.5, com_along=0.499)
    assert Disturbance(ground=0.1).sizes(half)[2] == 0.05


def test_torque_noise_is_a_fraction_of_the_torque_wanted() -> None:
    envs = walkers({"torque": 0.03})
    envs.reset(seed=0)
    *_, info = envs.step(np.full((COUNT, 2), 0.5))
    angle, torque = info["control"].T
    wanted = make().control([0.5, 0.5])
    assert (angle == wanted.switch_angle).all()
    assert is_normal(torque / wanted.stall_torque - 1, 0.03)


def test_torque_noise_never_turns_the_motor_round() -> None:
    envs = walkers({"torque": 5.0})
    envs.reset(seed=0)
    *_, info = envs.step(np.zeros((COUNT, 2)))
    assert info["control"][:, 1].min() == 0.0


def test_sensor_noise_is_seen_and_not_felt() -> None:
    envs = walkers({"sensor": 0.3})
    observation, info = envs.reset(seed=0)
    for _ in range(2):
        seen = (info["state"] - np.array(ROUND.state)) / state_scale(ROUND.params)
        assert abs(seen).max() < 1e-5
        for column in (observation - seen).T:
            assert is_normal(column, 0.3)
        observation, *_, info = envs.step(np.zeros((COUNT, 2)))


@pytest.mark.parametrize("kind", ["slope", "parameters"])
def test_slope_and_parameters_stay_for_an_episode_and_change_with_it(kind: str) -> None:
    envs = walkers({kind: 0.01}, 300, autoreset_mode="SameStep")
    envs.reset(seed=0)
    before = envs.walkers.rows.copy()
    for _ in range(5):
        _, _, fell, _, _ = envs.step(np.zeros((300, 2)))
        changed = (envs.walkers.rows != before).any(axis=1)
        np.testing.assert_array_equal(changed, fell)
        before = envs.walkers.rows.copy()
    chosen = [params_of(row) for row in before]
    for name, value in ROUND.params.to_dict().items():
        if (name == "slope") if kind == "slope" else (name in SPREAD_FIELDS):
            values = np.array([getattr(params, name) for params in chosen])
            assert len(set(values)) == 300
            assert is_normal(np.log(values / value) if value else values, 0.01)
        else:
            assert all(getattr(params, name) == value for params in chosen)


def test_the_steepest_slope_is_no_wall_and_no_parameter_turns_negative() -> None:
    draws = np.array([40.0, -40.0, -40.0, 3.0, -40.0, 0.0])
    wild = episode_params(ROUND.params, Disturbance(slope=1.0, parameters=1.0), draws)
    assert wild.slope == 1.5
    assert 0 < wild.foot_length < 1e-16


@pytest.mark.parametrize("signs", list(itertools.product((-1, 0, 1), repeat=4)))
def test_a_leg_with_a_knee_bears_the_wildest_draw(signs: tuple[int, ...]) -> None:
    """A draw may be 8.6 deviations: thigh and shank change by one factor each, and walk or fall."""
    params, control, state, _ = PRESETS["kneed"]
    size = SIZES["kneed"]["parameters"][-1]
    wild = episode_params(params, Disturbance(parameters=size), 8.6 * np.array([0, *signs, 0]))
    factors = np.exp(8.6 * size * np.array(signs))
    before, after = thigh_of(params), thigh_of(wild)
    assert params.knee is not None and wild.knee is not None
    assert wild.foot_length == pytest.approx(factors[0] * params.foot_length)
    assert wild.no_load_speed == pytest.approx(factors[3] * params.no_load_speed)
    assert after.mass == pytest.approx(factors[1] * before.mass)
    assert wild.knee.shank_mass == pytest.approx(factors[1] * params.knee.shank_mass)
    assert after.inertia == pytest.approx(factors[2] * before.inertia, rel=1e-9)
    assert wild.knee.shank_inertia == pytest.approx(factors[2] * params.knee.shank_inertia)
    for place in ("length", "com_along", "com_across"):
        assert getattr(after, place) == pytest.approx(getattr(before, place), abs=1e-12)
    assert wild.knee.shank_com_along == params.knee.shank_com_along
    (outcome,) = stride_batch([state], control, wild).outcome
    assert outcome not in (Outcome.NOT_FINITE, Outcome.STEP_LIMIT)


def test_every_controller_meets_the_same_disturbances() -> None:
    """Also after their walks have become different ones."""
    one, two = walkers(EVERYTHING, 20), walkers(EVERYTHING, 20)
    for envs in (one, two):
        envs.reset(seed=7)
    np.testing.assert_array_equal(one.walkers.rows, two.walkers.rows)
    alike = np.ones(20, np.bool_)  # neither has fallen
    for _ in range(2):
        a = one.step(np.zeros((20, 2)))
        b = two.step(np.full((20, 2), 0.02))
        alike &= ~(a[2] | b[2])
        assert alike.any()
        np.testing.assert_array_equal(a[4]["step_height"][alike], b[4]["step_height"][alike])
        torques = (a[4]["control"][alike, 1], b[4]["control"][alike, 1])
        np.testing.assert_allclose(torques[1] / torques[0], 1.006, rtol=1e-12)


@pytest.mark.parametrize("preset", MOTORS)
def test_every_preset_has_three_levels_of_every_kind(preset: str) -> None:
    params = PRESETS[preset].params
    assert disturbance_of("none", preset, params) == Disturbance()
    pushes = [disturbance_of(level, preset, params) for level in LEVELS[1:]]
    assert pushes == [Disturbance(push=size) for size in PUSHES[preset]]
    for kind in KINDS:
        sizes = []
        for level in LEVELS:
            chosen = disturbance_of(f"{level}-{kind}", preset, params)
            sizes.append(getattr(chosen, kind))
            assert chosen == Disturbance(**{kind: sizes[-1]})
        assert sizes == sorted(set(sizes)) and sizes[0] == 0.0


def test_a_walker_of_ones_own_takes_the_theses_levels_at_its_own_pace() -> None:
    small = WalkerParams(leg_length=0.25, com_along=0.2)
    assert disturbance_of("light", None, small).push == pytest.approx(0.01)
    assert disturbance_of("light", None, WalkerParams()).push == pytest.approx(0.005)
    for kind in set(KINDS) - {"push"}:
        own = disturbance_of(f"rough-{kind}", None, small)
        assert own == disturbance_of(f"rough-{kind}", "camp1997", small)


def test_a_disturbance_can_be_given_as_it_is() -> None:
    given = Disturbance(push=0.01, torque=0.02)
    assert disturbance_of(given, "camp1997", WalkerParams()) is given
    assert disturbance_of({"push": 0.01, "torque": 0.02}, None, WalkerParams()) == given
    assert make(disturbance=given).task.disturbance == given
    assert type(Disturbance(push=np.float32(1)).push) is float


@functools.cache
def typical(preset: str, disturbance: str) -> float:
    """Geometric mean of 1 + the strides that the open loop survives."""
    envs = walkers(disturbance, 250, preset=preset)
    envs.reset(seed=1)
    walking, strides = np.ones(250, np.bool_), np.zeros(250)
    for _ in range(100):
        walking &= ~envs.walkers.step(np.zeros(envs.action_space.shape), walking).terminated
        strides += walking
        if not walking.any():
            break
    return float(np.exp(np.log1p(strides).mean()))


@pytest.mark.parametrize("level", ["light", "medium", "rough"])
@pytest.mark.parametrize("kind", ["ground", "slope", "torque", "parameters"])
@pytest.mark.parametrize("preset", POWERED)
def test_a_level_is_about_as_hard_in_every_kind(preset: str, kind: str, level: str) -> None:
    """`python -m agents.severity` has the numbers."""
    if preset == "hip-torque" and kind in ("torque", "parameters"):
        pytest.skip("it bears any of them: the pushes are the harder disturbance")
    assert typical(preset, f"{level}-{kind}") == pytest.approx(typical(preset, level), rel=0.35)


def test_the_documentation_has_the_sizes_of_all_levels_and_what_they_are_of() -> None:
    """It is made from them: this reads it as a user does."""
    document = PoweredWalkerEnv.__doc__ or ""
    for preset, sizes in SIZES.items():
        (row,) = [x for x in document.splitlines() if re.search(rf"`{preset}` .*, .*, .*, .*, ", x)]
        cells = [re.findall(r"[\d.]+", cell) for cell in row.split("|")[2:-1]]
        assert [[float(size) for size in cell] for cell in cells] == [
            list(sizes[kind]) for kind in KINDS
        ]
    for preset in PUSHES:
        control = PRESETS[preset].control
        assert control is not None
        assert f"{control.switch_angle} rad, {control.stall_torque:g} N m" in document
    assert max(map(len, document.splitlines())) <= 180


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("preset", POWERED)
def test_the_largest_deviation_allowed_fells_the_walker_and_nothing_else(
    preset: str, kind: str
) -> None:
    """And a larger one is refused when the environment is made, not at a reset."""
    most = quantities(Disturbance)[kind].domain.high
    envs = walkers({kind: most}, 50, preset=preset, autoreset_mode="SameStep")
    envs.reset(seed=0)
    for _ in range(20):
        observation, reward, *_, info = envs.step(np.zeros(envs.action_space.shape))
        assert observation in envs.observation_space and np.isfinite(reward).all()
        assert np.isfinite(info["state"]).all()
    with pytest.raises(ValueError, match=rf"disturbance {kind} must be .* in \[0, .* got"):
        walkers({kind: 1.01 * most}, 1, preset=preset)
    with pytest.raises(ValueError, match=rf"disturbance {kind} must be .* got 1000000.0"):
        walkers({kind: 1e6}, 1, preset=preset)


@pytest.mark.parametrize("preset", POWERED)
def test_sensor_noise_is_added_before_the_observation_is_clipped(preset: str) -> None:
    """At the bound itself half of the noise is cut off; far outside all of it is."""
    envs = walkers({"sensor": 0.5}, COUNT, preset=preset)
    gait, scale = np.array(PRESETS[preset].state), state_scale(PRESETS[preset].params)
    bound = np.array([20.0, -20.0, 20.0, -20.0])
    at_bound, _ = envs.reset(seed=0, options={"state": gait + bound * scale})
    assert at_bound in envs.observation_space
    for column, edge in zip((at_bound * np.sign(bound)).T, abs(bound), strict=True):
        assert column.max() == edge
        assert np.mean(column < edge) == pytest.approx(0.5, abs=0.04)
    outside, _ = envs.reset(seed=0, options={"state": gait + 2 * bound * scale})
    np.testing.assert_array_equal(outside, np.tile(bound, (COUNT, 1)))
