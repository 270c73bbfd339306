"""A way to power a walker that is defined outside: registered, it goes everywhere by name."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    HipTorque,
    PoweredWalkerEnv,
    PoweredWalkerVectorEnv,
    continue_gait,
    find_gait,
    load_result,
    regulate,
    save_result,
    stride,
    stride_batch,
    walk,
)
from powered_walker_env.model.powering import (
    ANGLE,
    CONTROL_NUMBERS,
    MOTOR,
    SCHEMES,
    STRENGTH,
    FunctionPolicy,
    Scheme,
    register_scheme,
    schemes,
)
from powered_walker_env.poincare.branches.ramps import bifurcation_diagram
from powered_walker_env.poincare.stability.robustness import gait_sensitivity
from powered_walker_env.simulation.derivatives import PARAMETERS, differentiate_batch

COMPASS = PRESETS["compass"]
SOURCE = '''
"""Legs pulled together by a constant torque for the whole swing."""
from dataclasses import dataclass

from powered_walker_env.model.phases import Exit, Guard, Joints, Outcome, Phase, Reset, Torque
from powered_walker_env.model.powering import STRENGTH, Scheme, register_scheme
from powered_walker_env.model.quantities import ANY, check_numbers, quantity


@dataclass(frozen=True)
class Pull:
    pull: float = quantity("T", "N m", "torque between the legs", ANY)

    def __post_init__(self):
        check_numbers(self)


LANDING = Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED)
PHASES = (Phase("pulled", Joints.ANKLE_LOCKED, Torque.HIP, (LANDING,)),)
PULL = register_scheme(Scheme("pull", PHASES, Pull, (STRENGTH,)))
'''


@pytest.fixture
def pull(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The throw-away package, imported; its scheme is forgotten afterwards."""
    tables = (SCHEMES, schemes.BY_CONTROL, CONTROL_NUMBERS)
    before = [dict(table) for table in tables]  # type: ignore[call-overload]
    (tmp_path / "pulled_walker.py").write_text(SOURCE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("pulled_walker")
    del sys.modules["pulled_walker"]
    for table, known in zip(tables, before, strict=True):
        table.clear()  # type: ignore[attr-defined]
        table.update(known)  # type: ignore[attr-defined]


def strength() -> float:
    """A hundredth of a leg's weight times its length."""
    return 0.01 * COMPASS.params.leg_mass * COMPASS.params.gravity * COMPASS.params.leg_length


def test_its_strides_are_those_of_a_torque_that_never_ends(pull: Any) -> None:
    torque = strength()
    ours = stride(COMPASS.state, pull.Pull(torque), COMPASS.params)
    theirs = stride(COMPASS.state, HipTorque(0.5, torque), COMPASS.params)
    assert ours.state == pytest.approx(theirs.state, abs=1e-9)
    assert ours.energy_in == pytest.approx(theirs.energy_in, rel=1e-7)
    batch = stride_batch([COMPASS.state], [torque], COMPASS.params, scheme="pull")
    np.testing.assert_array_equal(batch.state[0], ours.state)
    walked = walk(COMPASS.state, lambda _: pull.Pull(torque), COMPASS.params, 1)
    np.testing.assert_array_equal(walked.states[1], ours.state)
    found = differentiate_batch([COMPASS.state], [torque], COMPASS.params, scheme="pull")
    assert found.names[4:] == ("pull",) and found.by_control.any()
    assert "pull" in PARAMETERS and len(PARAMETERS) == len(set(PARAMETERS))
    with pytest.raises(ValueError, match="controls must be finite"):
        stride_batch([COMPASS.state], [np.nan], COMPASS.params, scheme="pull")


def test_it_has_gaits_branches_regulators_and_ramps(pull: Any) -> None:
    gait = find_gait(COMPASS.params, pull.Pull(0.1 * strength()), COMPASS.state)
    assert gait.section == "post-strike" and gait.control_jacobian.shape == (4, 1)
    law = regulate(gait, [0.1 * strength()])
    assert law.scheme == "pull"
    closed = find_gait(gait.params, law, gait.state)
    assert closed.state == pytest.approx(gait.state, abs=1e-10)
    assert closed.spectral_radius < gait.spectral_radius
    branch = continue_gait(gait, "pull", (0.0, 0.2 * strength()), step=0.3)
    assert len(branch) > 2
    ramp = bifurcation_diagram(
        gait.params, gait.control, "pull", [0.1 * strength()], state=gait.state, transient=0,
        keep=2, backend="threading",
    )  # fmt: skip
    assert ramp.up.walked.all()
    assert gait_sensitivity(gait, {"pull": 0.01 * strength()}).norm > 0
    constant = FunctionPolicy(lambda x: np.full((len(x), 1), 0.1 * strength()), scheme="pull")
    assert find_gait(gait.params, constant, gait.state).state == pytest.approx(gait.state)


def test_its_gaits_are_saved_and_loaded_where_it_is_registered(pull: Any, tmp_path: Path) -> None:
    gait = find_gait(COMPASS.params, pull.Pull(0.1 * strength()), COMPASS.state)
    path = save_result(gait, tmp_path / "gait.npz")
    assert load_result(path).control == gait.control
    del SCHEMES["pull"]
    with pytest.raises(ValueError, match="Pull: no type of this package, nor the control of"):
        load_result(path)


def test_environments_take_it_by_name(pull: Any) -> None:
    gait = find_gait(COMPASS.params, pull.Pull(0.1 * strength()), COMPASS.state)
    walker = {
        "params": gait.params.to_dict(), "scheme": "pull", "control": [0.1 * strength()],
        "gait": list(gait.state), "disturbance": "none",
    }  # fmt: skip
    env = PoweredWalkerEnv(**walker)
    env.reset(seed=0, options={"state": gait.state})
    _, reward, terminated, _, info = env.step(np.zeros(1, np.float32))
    assert not terminated and reward == pytest.approx(1.0)
    assert info["pull"] == pytest.approx(0.1 * strength())
    envs = PoweredWalkerVectorEnv(2, **walker)
    envs.reset(seed=0)
    assert not envs.step(np.zeros((2, 1), np.float32))[2].any()


def test_the_same_definition_may_come_again(pull: Any) -> None:
    again = importlib.reload(pull)
    assert SCHEMES["pull"] is again.PULL
    stride(COMPASS.state, again.Pull(0.0), COMPASS.params)


@dataclass(frozen=True)
class Twist:
    twist: float


@dataclass(frozen=True)
class Borrowed:
    switch_angle: float


@dataclass
class Loose:
    twist: float


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"name": "motor"}, ValueError, "a name and a control of its own, got 'motor'"),
        ({"control": MOTOR.control, "columns": (ANGLE, STRENGTH)}, ValueError, "'motor' has"),
        ({"columns": (ANGLE, STRENGTH)}, ValueError, "each of the control's 1 numbers"),
        ({"columns": (7,)}, ValueError, "columns must say ANGLE or STRENGTH"),
        ({"control": Loose}, TypeError, "control must be a frozen dataclass"),
        ({"control": Borrowed}, ValueError, "must not call its strength 'switch_angle'"),
        ({"cycle": ()}, ValueError, "cycle must have at least one phase"),
    ],
)
def test_what_cannot_be_registered_is_named_and_leaves_nothing(
    changes: dict[str, Any], error: type[Exception], message: str
) -> None:
    before = dict(SCHEMES), dict(schemes.BY_CONTROL), dict(CONTROL_NUMBERS)
    good = Scheme("twist", SCHEMES["hip-torque"].cycle, Twist, (STRENGTH,))
    with pytest.raises(error, match=message):
        register_scheme(good._replace(**changes))
    assert before == (SCHEMES, schemes.BY_CONTROL, CONTROL_NUMBERS)
