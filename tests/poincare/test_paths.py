"""Continuation along a path: as by one parameter where it is one, and through several at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import PRESETS, Control, WalkerParams, continue_gait, find_gait, save_result
from powered_walker_env.poincare import SpecialKind, continue_path
from powered_walker_env.poincare.branches.paths import PathFamily
from powered_walker_env.results import UnsavedPolicy, load_result

COMPASS = PRESETS["compass"]


def slopes(value: float) -> tuple[WalkerParams, None]:
    return COMPASS.params.replace(slope=value), None


def test_a_path_by_one_parameter_is_the_branch_by_it() -> None:
    gait = find_gait(COMPASS.params, None, COMPASS.state)
    bounds, start = (0.04, 0.09), COMPASS.params.slope
    path = continue_path(slopes, gait, bounds, start=start, step=0.05)
    plain = continue_gait(gait, "slope", bounds, step=0.05)
    for kind in SpecialKind:
        ours, known = ([p.value for p in b.of_kind(kind)] for b in (path, plain))
        np.testing.assert_allclose(ours, known, rtol=1e-7)
    assert path.of_kind(SpecialKind.PERIOD_DOUBLING)
    (one,), (other,) = path.at(0.06), plain.at(0.06)
    np.testing.assert_allclose(one.state, other.state, atol=1e-10)
    np.testing.assert_allclose(path.values[[0, -1]], plain.values[[0, -1]], rtol=1e-9)


def legs(value: float) -> tuple[WalkerParams, None]:
    """Mass moved from the legs to the hip, the whole the same: three fields of the walker."""
    share = 0.5 + value
    return (
        WalkerParams.from_composite_leg(
            leg_length=1.0, hip_mass=10.0 * share, frame_mass=10.0 * (1 - share), foot_mass=0.0,
            foot_length=0.0, foot_radius=0.0, gravity=9.8, slope=0.05,
        ),
        None,
    )  # fmt: skip


def test_a_mass_ratio_moves_several_fields() -> None:
    gait = find_gait(*legs(0.1))
    branch = continue_path(legs, gait, (0.0, 0.3), start=0.1, step=0.1)
    assert branch.values.min() == 0.0 and branch.values.max() == 0.3
    for index in (0, len(branch) - 1):
        found = branch.gait(index)
        known = find_gait(*legs(branch.values[index]), branch.states[index].tolist())
        np.testing.assert_allclose(found.state, known.state, atol=1e-9)
        assert found.params == legs(branch.values[index])[0]


@pytest.mark.parametrize("name", ["camp1997", "round-foot", "toe-off", "hip-torque"])
def test_the_derivative_along_a_path_is_that_of_its_equations(name: str) -> None:
    params, control, state, _ = PRESETS[name]
    gait = find_gait(params, control, state)

    def path(value: float) -> tuple[WalkerParams, Any]:
        grown = params.replace(
            leg_mass=params.leg_mass * (1 + value), gravity=params.gravity * (1 - 0.1 * value)
        )
        if isinstance(control, Control):
            return grown, Control(control.switch_angle * (1 - 0.01 * value), control.stall_torque)
        return grown, control

    family = PathFamily(
        params, control, ("lambda",), np.array([0.2]), path=path, bounds=(-0.1, 0.1), value=0.0
    )
    u = family.unknowns(gait.state, [0.0])
    step = np.zeros(5)
    step[-1] = 1e-5
    differenced = (family.evaluate(u + step).residual - family.evaluate(u - step).residual) / 2e-5
    exact = family.evaluate(u).jacobian[:, -1]
    np.testing.assert_allclose(exact, differenced, rtol=1e-5, atol=1e-7 * np.abs(exact).max())
    at_end = family.evaluate(family.unknowns(gait.state, [-0.1])).jacobian[:, -1]
    assert np.isfinite(at_end).all()


def test_a_branch_along_a_path_is_saved_without_the_path(tmp_path: Path) -> None:
    gait = find_gait(COMPASS.params, None, COMPASS.state)
    branch = continue_path(slopes, gait, (0.05, 0.055), start=COMPASS.params.slope, step=0.5)
    loaded = load_result(save_result(branch, tmp_path / "branch.npz"))
    np.testing.assert_array_equal(loaded.states, branch.states)
    assert isinstance(loaded.path, UnsavedPolicy) and loaded.parameter == "lambda"


def test_paths_that_make_no_sense_are_refused() -> None:
    gait = find_gait(COMPASS.params, None, COMPASS.state)
    start = COMPASS.params.slope
    with pytest.raises(ValueError, match="bounds must rise"):
        continue_path(slopes, gait, (0.1, 0.0))
    with pytest.raises(ValueError, match="start must lie within the bounds"):
        continue_path(slopes, gait, (0.06, 0.07), start=start)
    with pytest.raises(ValueError, match="gait must be of the walker and control at lambda"):
        continue_path(slopes, gait, (0.04, 0.07), start=0.05)
    with pytest.raises(ValueError, match=r"path must lead to \(walker, control\) with scheme"):
        continue_path(lambda value: value, gait, (0.0, 1.0))  # type: ignore[arg-type, return-value]
