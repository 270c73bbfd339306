"""The regulator: of all linear laws the one of least cost, whatever powers the walker."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, find_gait, regulate
from powered_walker_env.model.state import natural_units
from powered_walker_env.poincare.gaits import Gait
from tests.helpers.derivation import Array
from tests.helpers.samples import DECIDING
from tests.poincare.test_schemes_laboratory import gait_of, half_range

Q = np.array(
    [[2.0, 0.3, 0.0, 0.0], [0.3, 1.0, 0.0, 0.1], [0.0, 0.0, 0.5, 0.0], [0.0, 0.1, 0.0, 3.0]]
)
START = np.array([1e-3, -2e-3, 3e-3, 1e-3])  # natural units


def linear_cost(gait: Gait, gain: Array, state_cost: Array, action_cost: Array) -> float:
    """Σ x'ᵀQx' + aᵀRa along x⁺ = (A + BK)x from START, summed stride by stride."""
    units, reach = natural_units(gait.params), np.array(half_range(gait))
    A = gait.jacobian * units / units[:, np.newaxis]
    B = gait.control_jacobian * reach / units[:, np.newaxis]
    K = gain * units / reach[:, np.newaxis]
    x, total = START.copy(), 0.0
    for _ in range(3000):
        a = K @ x
        total += float(x @ state_cost @ x + a @ action_cost @ a)
        x = A @ x + B @ a
    return total


@pytest.mark.parametrize("name", DECIDING)
def test_no_other_gain_costs_less_and_the_cost_is_that_of_the_strides_to_come(name: str) -> None:
    gait, rng = gait_of(name), np.random.default_rng(0)
    R = 0.2 * np.eye(len(half_range(gait)))
    law = regulate(gait, half_range(gait), action_cost=R, state_cost=Q)
    least = linear_cost(gait, law.gain, Q, R)
    x = np.array(gait.state) + START * natural_units(gait.params)
    assert law.costs(x[np.newaxis])[0] == pytest.approx(least, rel=1e-9)
    for _ in range(5):
        other = law.gain * (1.0 + 0.02 * rng.normal(size=law.gain.shape))
        assert linear_cost(gait, other, Q, R) > least


def test_weights_are_a_number_a_diagonal_or_a_matrix() -> None:
    gait = gait_of("motor")
    known = regulate(gait, half_range(gait))
    for costs in (
        {"action_cost": 0.1, "state_cost": 1.0},
        {"action_cost": (0.1, 0.1), "state_cost": (1.0, 1.0, 1.0, 1.0)},
        {"action_cost": 0.1 * np.eye(2), "state_cost": np.eye(4)},
    ):
        np.testing.assert_array_equal(regulate(gait, half_range(gait), **costs).gain, known.gain)  # type: ignore[arg-type]
    lazy = regulate(gait, half_range(gait), action_cost=1e4)
    assert np.abs(lazy.gain).max() < 0.1 * np.abs(known.gain).max()  # the gait is stable by itself
    stance = regulate(gait, half_range(gait), action_cost=0.03, state_cost=(1.0, 0.0, 1.0, 0.0))
    assert not np.allclose(stance.gain, known.gain)


@pytest.mark.parametrize(
    ("costs", "message"),
    [
        ({"state_cost": (1.0, 1.0)}, "state_cost must be a number, 4 weights or a symmetric 4x4"),
        ({"state_cost": np.triu(np.ones((4, 4)))}, "symmetric 4x4 matrix"),
        ({"state_cost": (1.0, 1.0, -1.0, 1.0)}, "state_cost must not be negative"),
        ({"state_cost": np.nan}, "state_cost must be a number"),
        ({"action_cost": 0.0}, "action_cost must be positive"),
        ({"action_cost": (1.0, 1.0, 1.0)}, "action_cost must be a number, 2 weights"),
    ],
)
def test_costs_that_will_not_do_are_named(costs: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        regulate(gait_of("motor"), half_range(gait_of("motor")), **costs)


def test_gaits_that_cannot_be_regulated_are_named() -> None:
    compass = PRESETS["compass"]
    with pytest.raises(ValueError, match="a constant control, got period 1 and control None"):
        regulate(find_gait(compass.params, None, compass.state), [])
    with pytest.raises(ValueError, match="half_range must be 2 positive numbers, one for each of"):
        regulate(gait_of("motor"), [0.1])
