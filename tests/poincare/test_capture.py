"""What can be kept from falling, from both sides, and the largest single disturbance."""

from __future__ import annotations

import numpy as np
import pytest

from powered_walker_env import PRESETS, find_gait, regulate, stride_batch
from powered_walker_env.poincare import Capture, capture, largest_push, largest_step, viable_states
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regions.capture import REACH as AROUND
from powered_walker_env.simulation.strides import stride

PARAMS, CONTROL, STATE, _ = PRESETS["round-foot"]
assert CONTROL is not None
GAIT = find_gait(PARAMS, CONTROL, STATE)
HALF = (0.2, 0.3 * CONTROL.stall_torque)


@pytest.fixture(scope="module")
def found() -> Capture:
    return capture(GAIT, HALF, shape=12, counts=7, strides=8)


def test_the_bounds_are_bounds_and_the_gait_is_saved(found: Capture) -> None:
    saved, possible = found.bounds
    assert 0.5 < saved < possible < 1.0
    assert (found.at_least <= found.at_most).all()
    assert found.grid.section is not None and found.grid.section.hip_angle == found.high[0]
    here = found.grid.section.points([STATE])
    nearest = np.argmin(np.linalg.norm(found.grid.points - here, axis=1))
    assert found.fate[nearest] == 1
    assert 0.0 < found.viability_measure < saved
    assert (found.control_share[found.at_least >= found.strides] > 0).all()


def test_a_search_saves_what_is_called_saved_and_nothing_of_what_is_lost(found: Capture) -> None:
    rng = np.random.default_rng(0)
    saved = rng.choice(np.flatnonzero(found.fate == 1), 40, replace=False)
    lost = np.flatnonzero(found.fate == -1)
    states = found.grid.states
    search = viable_states(GAIT, HALF, states[saved], grid=7, backend="threading")
    assert (search.saved >= 0).mean() > 0.9 and not (search.lost >= 0).any()
    search = viable_states(GAIT, HALF, states[lost[:40]], grid=7, backend="threading")
    assert len(lost) > 40 and not (search.saved >= 0).any()


def test_who_falls_at_once_is_found_by_trying_every_control(found: Capture) -> None:
    at_once = np.flatnonzero(found.at_most == 0)[:10]
    assert len(at_once)
    axes = [np.linspace(*ends, 31) for ends in zip(found.low, found.high, strict=True)]
    controls = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    for state in found.grid.states[at_once]:
        batch = stride_batch(np.tile(state, (len(controls), 1)), controls, PARAMS, rtol=1e-8)
        assert not batch.walked.any()


def test_a_finer_grid_leaves_less_open_and_pushes_cost(found: Capture) -> None:
    finer = capture(GAIT, HALF, shape=18, counts=9, strides=8)
    open_share = [k.bounds[1] - k.bounds[0] for k in (found, finer)]
    assert open_share[1] < open_share[0]
    robust = capture(GAIT, HALF, shape=12, counts=7, strides=8, push=0.02)
    assert robust.bounds[0] < found.bounds[0]
    assert (robust.at_least <= found.at_least).all()


def test_bad_captures_are_refused() -> None:
    with pytest.raises(ValueError, match="push must not be negative"):
        capture(GAIT, HALF, push=-1.0)
    with pytest.raises(ValueError, match="counts must be one or 2"):
        capture(GAIT, HALF, counts=(3, 3, 3))
    with pytest.raises(ValueError, match="strides must be at least 1"):
        capture(GAIT, HALF, strides=0)
    assert AROUND == 0.1


@pytest.mark.parametrize("name", ["compass", "round-foot", "toe-off", "hip-torque"])
def test_the_largest_step_is_the_edge_of_survival(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    found = largest_step(params, control, state)

    def survives(height: float) -> bool:
        after = stride(state, control, params, step_height=height, rtol=1e-8).state
        walked = StrideMap(params, control, 1e-8)(np.array([after]), 50)
        return bool(np.isfinite(walked).all())

    assert survives(found.up) and not survives(found.up + 1e-6 * params.leg_length)
    assert survives(found.down) and not survives(found.down - 1e-6 * params.leg_length)


def test_the_compass_gait_survives_the_steps_known_of_it() -> None:
    params, control, state, _ = PRESETS["compass"]
    found = largest_step(params, control, state)
    assert found.up == pytest.approx(0.0059, abs=1e-4)
    assert found.down == pytest.approx(-0.0143, abs=1e-4)
    assert "step, m: +0.005" in repr(found)


def test_a_regulator_survives_another_push_than_the_open_loop() -> None:
    open_loop = largest_push(PARAMS, CONTROL, STATE)
    closed = largest_push(PARAMS, regulate(GAIT, HALF), STATE)
    assert closed.down < open_loop.down < 0 < open_loop.up
    swing = largest_push(PARAMS, CONTROL, STATE, direction=(0.0, -2.0))
    assert swing.up != open_loop.up and swing.down < 0
    with pytest.raises(ValueError, match="direction must be two numbers"):
        largest_push(PARAMS, CONTROL, STATE, direction=(0.0, 0.0))
    with pytest.raises(ValueError, match="start must walk 50 strides undisturbed"):
        largest_step(PARAMS, CONTROL, (-1.0, 0.2, 0.0, 0.0))
