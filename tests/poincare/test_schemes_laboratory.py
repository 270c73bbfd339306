"""Every question of the laboratory for every scheme, under constant controls and policies."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Gait,
    GaitNotFoundError,
    Outcome,
    PoweredWalkerEnv,
    continue_gait,
    find_gait,
    load_result,
    save_result,
    walk,
)
from powered_walker_env.controllers.policies import policy_of
from powered_walker_env.model.powering import SCHEMES, LateToeOff, ToeOff, ToeOffAtStrike, scheme_of
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.cascades import doubling_cascade
from powered_walker_env.poincare.branches.ramps import bifurcation_diagram
from powered_walker_env.poincare.energy.contact import contact_of, contact_report
from powered_walker_env.poincare.energy.energetics import costs
from powered_walker_env.poincare.energy.ground_force import ground_force
from powered_walker_env.poincare.maps import StrideMap
from powered_walker_env.poincare.regions.basins import basin
from powered_walker_env.poincare.regions.viability import viable_states
from powered_walker_env.poincare.regions.volumes import basin_volume
from powered_walker_env.poincare.regulator import regulate
from powered_walker_env.poincare.search import find_gaits
from powered_walker_env.poincare.stability.lyapunov import lyapunov_exponent
from powered_walker_env.poincare.stability.robustness import gait_sensitivity
from powered_walker_env.poincare.stability.transitions import transition_times
from powered_walker_env.poincare.wanted import find_gait_with
from tests.helpers.samples import DECIDING, scheme_arguments

NAMES = [*DECIDING, "passive"]


@functools.cache
def gait_of(name: str) -> Gait:
    if name == "passive":
        params, control, state, _ = PRESETS["bhounsule-round-feet"]
        return find_gait(params, control, state)
    task = PoweredWalkerEnv(**scheme_arguments(name)).task
    return find_gait(task.params, task.control, task.gait[0].tolist())


def half_range(gait: Gait) -> list[float]:
    """A tenth of a radian of an angle, a tenth of a strength."""
    scheme = scheme_of(gait.control)
    row = np.array(scheme.row(gait.control))
    return [0.1 if column == 0 else 0.1 * row[1] for column in scheme.columns]


def strongest(gait: Gait) -> str:
    """The parameter that powers the walker."""
    return ("slope", *scheme_of(gait.control).numbers)[-1]


def near(gait: Gait) -> tuple[float, float]:
    name = strongest(gait)
    value = getattr(gait.params if name == "slope" else gait.control, name)
    return 0.999 * value, 1.001 * value


def starts(gait: Gait) -> np.ndarray:
    return np.array(gait.state) + 1e-5 * np.eye(4)


def basin_of(gait: Gait, control: Any) -> None:
    found = basin(gait.params, control, starts(gait), strides=2, gaits=[], backend="threading")
    assert (found.strides == 2).all()


def volume_of(gait: Gait, control: Any) -> None:
    low, high = np.array(gait.state) - 1e-5, np.array(gait.state) + 1e-5
    found = basin_volume(
        gait.params, control, low, high, samples=4, strides=2, gaits=[], backend="threading"
    )
    assert found.basin.walking_share == 1.0


def lyapunov_of(gait: Gait, control: Any) -> None:
    found = lyapunov_exponent(
        gait.params, control, gait.state, strides=6, transient=0, blocks=2, rtol=1e-9
    )
    assert math.isfinite(found.exponent)


def ramp_of(gait: Gait, control: Any) -> None:
    values = gait.params.slope + np.array([0.0, 1e-6])
    found = bifurcation_diagram(
        gait.params, control, "slope", values, state=gait.state, transient=0, keep=2,
        backend="threading",
    )  # fmt: skip
    assert found.up.walked.all()


def contact_under(gait: Gait, control: Any) -> None:
    report = contact_report(gait.params, control, gait.state)
    assert report.outcome == Outcome.WALKED and report.min_normal_force > 0


def force_under(gait: Gait, control: Any) -> None:
    force = ground_force(gait.params, control, gait.state)
    assert np.isfinite(force.normal).all() and force.impulse[0] > 0


def gaits_of(gait: Gait, control: Any) -> None:
    found = find_gaits(gait.params, control, starts=64, backend="threading")
    sections = {each.section for each in found}
    assert sections <= {"switch" if scheme_of(control).switches else "post-strike"}


QUESTIONS: list[Callable[[Gait, Any], None]] = [
    basin_of, volume_of, lyapunov_of, ramp_of, contact_under, force_under, gaits_of,
]  # fmt: skip


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: question.__name__)
@pytest.mark.parametrize("name", NAMES)
def test_constant_controls_of_every_scheme(
    name: str, question: Callable[[Gait, Any], None]
) -> None:
    question(gait_of(name), gait_of(name).control)


@functools.cache
def closed(name: str) -> Gait:
    gait = gait_of(name)
    return find_gait(gait.params, regulate(gait, half_range(gait)), gait.state)


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: question.__name__)
@pytest.mark.parametrize("name", DECIDING)
def test_policies_of_every_scheme(name: str, question: Callable[[Gait, Any], None]) -> None:
    question(closed(name), closed(name).control)


def sensitivity_of(gait: Gait) -> None:
    causes = {"stance_rate": 0.01, "step_height": 0.01 * gait.params.leg_length}
    if not callable(gait.control) and gait.control is not None:
        causes |= {number: 0.01 for number in scheme_of(gait.control).numbers}
    assert gait_sensitivity(gait, causes).norm > 0


def transitions_of(gait: Gait) -> None:
    times = transition_times(gait, (0.5,), size=1e-6, deviations=2, limit=3)
    assert times.growth > 0


def costs_of(gait: Gait) -> None:
    found = costs(gait)
    assert found.mechanical == pytest.approx(gait.cost_of_transport, rel=1e-12)
    assert found.net == pytest.approx(found.lost, rel=1e-6, abs=1e-9)  # what is put in is lost
    assert found.scheme == scheme_of(gait.control).name


def saved(gait: Gait) -> None:
    path = Path(f"{gait.section}.npz")
    save_result(gait, path)
    again: Gait = load_result(path)
    assert again.state == gait.state
    assert callable(gait.control) or again.control == gait.control
    assert again.electrical_energy == gait.electrical_energy


@pytest.mark.parametrize("question", [sensitivity_of, transitions_of, costs_of, saved])
@pytest.mark.parametrize("name", NAMES)
def test_gaits_of_every_scheme(
    name: str,
    question: Callable[[Gait], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    question(gait_of(name))
    if name != "passive":
        question(closed(name))


@pytest.mark.parametrize("name", NAMES)
def test_every_schemes_gait_is_stable_and_follows_what_powers_it(name: str) -> None:
    gait = gait_of(name)
    assert gait.stable
    assert (gait.section == "switch") == scheme_of(gait.control).switches
    assert (gait.section_state is not None) == scheme_of(gait.control).switches
    assert (gait.electrical_energy > 0) == scheme_of(gait.control).moves_ankle
    branch = continue_gait(gait, strongest(gait), near(gait), step=0.5)
    assert isinstance(branch, Branch) and branch.stable.all()
    longer = find_gait_with(
        gait.params, gait.control, step_length=1.0001 * gait.step_length, by=strongest(gait),
        guess=gait.state,
    )  # fmt: skip
    assert longer.step_length == pytest.approx(1.0001 * gait.step_length, rel=1e-9)
    with pytest.raises(GaitNotFoundError, match="wider bounds"):
        doubling_cascade(gait, strongest(gait), near(gait), doublings=1, step=0.5)


@pytest.mark.parametrize("name", DECIDING)
def test_every_scheme_can_be_saved_by_its_own_controls(name: str) -> None:
    gait = gait_of(name)
    found = viable_states(
        gait, half_range(gait), starts(gait), grid=2, depth=3, width=2, backend="threading"
    )
    count = len(SCHEMES[name].numbers)
    assert found.first_control.shape == (4, count) and found.grid == (2,) * count
    assert (found.lost < 0).all()


@pytest.mark.parametrize("name", DECIDING)
def test_a_regulator_knows_its_scheme_and_calms_the_gait(name: str) -> None:
    gait, loop = gait_of(name), closed(name)
    assert scheme_of(loop.control).name == name
    assert loop.state == pytest.approx(gait.state, abs=1e-9)
    np.testing.assert_allclose(loop.control(np.array([gait.state]))[0], nominal_of(gait))  # type: ignore[operator, misc, arg-type]
    expected = gait.jacobian + gait.control_jacobian @ loop.control.gain  # type: ignore[union-attr]
    np.testing.assert_allclose(loop.jacobian, expected, atol=1e-6 * np.abs(expected).max())


def nominal_of(gait: Gait) -> list[float]:
    return [getattr(gait.control, name) for name in scheme_of(gait.control).numbers]


@pytest.mark.parametrize("name", DECIDING)
def test_a_controller_of_an_environment_is_a_policy_of_its_scheme(name: str) -> None:
    env = PoweredWalkerEnv(**scheme_arguments(name))

    class Proportional:
        def predict(self, observation: Any, *, deterministic: bool = True) -> tuple[Any, Any]:
            return np.repeat(0.01 * observation[:, :1], len(env.task.nominal), axis=1), None

    policy = policy_of(env, Proportional())
    assert policy.scheme == name
    gait = gait_of(name)
    loop = find_gait(gait.params, policy, gait.state)
    assert loop.state == pytest.approx(gait.state, abs=1e-8)
    steering = np.zeros((len(env.task.nominal), 4))
    steering[:, :1] = env.task.half_range[:, np.newaxis] * 0.01 / env.task.scale[0]
    expected = gait.jacobian + gait.control_jacobian @ steering
    np.testing.assert_allclose(loop.jacobian, expected, atol=1e-6 * np.abs(expected).max())


def test_a_policy_without_a_scheme_is_the_motors() -> None:
    gait = gait_of("toe-off")
    with pytest.raises(ValueError, match="foot_length must be positive for a powered walker"):
        StrideMap(gait.params, lambda states: np.full((len(states), 1), 0.1))


@pytest.mark.parametrize(
    ("scheme", "message"), [("rocket", "scheme must be one of"), ("passive", "must have a control")]
)
def test_policies_of_no_scheme_are_refused(scheme: str, message: str) -> None:
    class Strange:
        def __call__(self, states: Any, /) -> Any:
            return states

    policy = Strange()
    policy.scheme = scheme  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=message):
        StrideMap(gait_of("toe-off").params, policy)


def test_a_switch_section_is_refused_where_there_is_no_switch() -> None:
    gait = gait_of("toe-off")
    with pytest.raises(ValueError, match="'post-strike' for scheme 'toe-off', which has no switch"):
        find_gait(gait.params, gait.control, gait.state, section="switch")


@pytest.mark.parametrize("name", DECIDING)
def test_gaits_are_found_without_a_guess(name: str) -> None:
    gait = gait_of(name)
    assert find_gait(gait.params, gait.control).period == 1


@pytest.mark.parametrize("preset", ["toe-off", "motor-with-stop", "hip-torque"])
def test_the_presets_gaits_are_exact(preset: str) -> None:
    params, control, state, source = PRESETS[preset]
    gait = find_gait(params, control, [round(x, 4) for x in state])
    assert gait.state == pytest.approx(state, abs=1e-12)
    assert gait.stable and params.slope == 0.0
    assert "find_gait" in source


def test_the_hip_walker_is_the_slope_walker_on_the_level() -> None:
    slope, level = PRESETS["bhounsule-round-feet"].params, PRESETS["hip-torque"].params
    assert level == slope.replace(slope=0.0)


def test_a_stop_makes_the_thesis_walkers_steps_longer() -> None:
    """Its foot falls back past a stop that is not there (0.004 rad); with one it cannot."""
    loose, stopped = gait_of("motor"), gait_of("motor-with-stop")
    assert contact_of(loose).stop_overrun > 0.003
    report = contact_of(stopped)
    assert report.stop_overrun < 1e-9 and report.stop_suffices
    assert stopped.step_length / loose.step_length == pytest.approx(1.05, abs=0.005)


def test_a_push_costs_more_work_the_later_it_comes() -> None:
    """Kuo 2002: the state after it is the same, the work is not."""
    gait = gait_of("toe-off")
    work = []
    for kind in (ToeOff, ToeOffAtStrike, LateToeOff):
        later = find_gait(gait.params, kind(0.1), gait.state)
        assert later.state == pytest.approx(gait.state, abs=1e-12)
        work.append(later.positive_work)
    assert work[0] < work[1] < work[2]


def test_the_floors_impulse_in_a_push_off_lies_along_the_trailing_leg() -> None:
    """Over a period weight, floor force, push and strike balance (see test_contact.py)."""
    gait = gait_of("toe-off")
    force = ground_force(gait.params, gait.control, gait.state)
    walked = walk(gait.state, gait.control, gait.params, 1, sample_interval=0.0)
    stance = float(walked.q[-1, 0] + walked.q[-1, 1])
    assert force.push == pytest.approx((0.1 * math.cos(stance), 0.1 * math.sin(stance)), rel=1e-9)
    none = dataclasses.replace(gait, control=ToeOff(0.0))
    assert ground_force(none.params, none.control, none.state).push == (0.0, 0.0)
