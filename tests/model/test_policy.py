"""A policy goes wherever a control goes, whatever powers the walker."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env import (
    PRESETS,
    Control,
    PostStrikeState,
    StrideMap,
    ToeOff,
    find_gait,
    regulate,
    stride,
    stride_batch,
    walk,
)
from powered_walker_env.model.powering import (
    SCHEMES,
    FunctionPolicy,
    as_policy,
    check_walkable,
    numbers_for,
    scheme_of,
)
from powered_walker_env.simulation.derivatives import differentiate_batch
from tests.helpers.derivation import Array
from tests.helpers.samples import DECIDING
from tests.poincare.test_schemes_laboratory import gait_of, half_range

ROUND = PRESETS["round-foot"]
TOE = PRESETS["toe-off"]


def feedback(name: str) -> tuple[Any, Any]:
    """The same control law twice: of states, and of one state."""
    gait = gait_of(name)
    law = regulate(gait, half_range(gait))

    def of_many(states: Array) -> Array:
        return law(np.asarray(states)[:, :])

    def of_one(state: PostStrikeState) -> Any:
        return SCHEMES[name].of_numbers(law(np.array([state]))[0])

    return FunctionPolicy(of_many, name), of_one


def starts(name: str) -> Array:
    noise = np.random.default_rng(0).normal(0.0, 1e-4, (3, 4))
    return np.array(gait_of(name).state) + noise


def strides_one_by_one(name: str, control: Any) -> Array:
    params = gait_of(name).params
    return np.array([stride(state, control, params).state for state in starts(name)])


def strides_in_a_batch(name: str, control: Any) -> Array:
    return stride_batch(starts(name), control, gait_of(name).params).state


def strides_with_derivatives(name: str, control: Any) -> Array:
    return differentiate_batch(starts(name), control, gait_of(name).params).strides.state


def strides_of_the_map(name: str, control: Any) -> Array:
    return StrideMap(gait_of(name).params, control, 1e-9)(starts(name))


def first_strides_of_walks(name: str, control: Any) -> Array:
    params = gait_of(name).params
    walks = [walk(state, control, params, 1, sample_interval=0) for state in starts(name)]
    return np.array([each.states[1] for each in walks])


def strides_for_torch(name: str, control: Any) -> Array:
    torch = pytest.importorskip("torch")
    from powered_walker_env.torch import differentiable_strides

    params = gait_of(name).params
    return differentiable_strides(torch.tensor(starts(name)), control, params).state.numpy()


WAYS: list[Callable[[str, Any], Array]] = [
    strides_in_a_batch, strides_with_derivatives, strides_of_the_map, first_strides_of_walks,
    strides_for_torch,
]  # fmt: skip


@pytest.mark.parametrize("way", WAYS, ids=lambda way: way.__name__)
@pytest.mark.parametrize("name", DECIDING)
def test_controls_and_both_kinds_of_policies_walk_the_same_strides_everywhere(
    name: str, way: Callable[[str, Any], Array]
) -> None:
    control = gait_of(name).control
    np.testing.assert_array_equal(way(name, control), strides_one_by_one(name, control))
    many, one = feedback(name)
    walked = strides_one_by_one(name, many)
    assert np.abs(walked - strides_one_by_one(name, control)).max() > 1e-9  # it does something
    np.testing.assert_array_equal(way(name, many), walked)
    np.testing.assert_array_equal(way(name, one), walked)


@pytest.mark.parametrize("name", DECIDING)
def test_numbers_with_a_scheme_are_its_controls(name: str) -> None:
    gait = gait_of(name)
    numbers = [getattr(gait.control, each) for each in SCHEMES[name].numbers]
    batch = stride_batch(starts(name), numbers, gait.params, scheme=name)
    np.testing.assert_array_equal(batch.state, strides_one_by_one(name, gait.control))
    by_numbers = differentiate_batch(starts(name), numbers, gait.params, scheme=name)
    by_control = differentiate_batch(starts(name), gait.control, gait.params)
    np.testing.assert_array_equal(by_numbers.by, by_control.by)
    assert by_numbers.names[4:] == SCHEMES[name].numbers
    assert by_numbers.by_control.shape == (3, 4, len(numbers))


@pytest.mark.parametrize("name", DECIDING)
def test_derivatives_under_a_policy_are_those_of_the_closed_loop(name: str) -> None:
    params = gait_of(name).params
    for control in feedback(name):
        found = differentiate_batch(starts(name), control, params, rtol=1e-13)
        closed = StrideMap(params, control)
        for state, by_state in zip(starts(name), found.by_state, strict=True):
            np.testing.assert_allclose(by_state, closed.differentiate(state).by_state, rtol=1e-12)
        h = 1e-6
        for j in range(4):
            there, back = (closed(starts(name) + sign * h * np.eye(4)[j]) for sign in (1, -1))
            expected = (there - back) / (2 * h)
            scale = np.abs(found.by_state).max()
            np.testing.assert_allclose(found.by_state[:, :, j], expected, atol=1e-6 * scale)


@pytest.mark.parametrize("name", DECIDING)
def test_a_walker_has_the_numbers_of_its_own_control_only(name: str) -> None:
    gait = gait_of(name)
    for other in {n for scheme in SCHEMES.values() for n in scheme.numbers}:
        if other in SCHEMES[name].numbers:
            found = differentiate_batch(starts(name), gait.control, gait.params, by=[other])
            column = SCHEMES[name].numbers.index(other)
            np.testing.assert_array_equal(
                found.by_parameters[..., 0], found.by_control[..., column]
            )
            continue
        with pytest.raises(ValueError, match=f"parameter must be one of .* got '{other}'"):
            differentiate_batch(starts(name), gait.control, gait.params, by=[other])
        with pytest.raises(ValueError, match=f"got '{other}'"):
            StrideMap(gait.params, gait.control).differentiate(gait.state, by=[other])


def test_toe_offs_are_differentiated_by_name() -> None:
    found = differentiate_batch([TOE.state], [0.1], TOE.params, scheme="toe-off")
    same = differentiate_batch([TOE.state], ToeOff(0.1), TOE.params)
    np.testing.assert_array_equal(found.by, same.by)
    assert found.names[4] == "impulse" and found.by_control.any()


def test_a_function_of_one_state_is_asked_once_a_stride() -> None:
    schedule = [Control(2.704, 3371.8 + k) for k in range(3)]
    left = iter(schedule)
    walked = walk(ROUND.state, lambda state: next(left), ROUND.params, 3)
    state: Any = ROUND.state
    for control in schedule:
        state = stride(state, control, ROUND.params).state
    np.testing.assert_array_equal(walked.states[-1], state)


def test_a_gait_under_a_function_of_one_state_is_that_of_its_law() -> None:
    for name in DECIDING:
        many, one = feedback(name)
        gaits = [find_gait(gait_of(name).params, law, gait_of(name).state) for law in (many, one)]
        assert gaits[1].control.scheme == name  # type: ignore[union-attr]
        assert gaits[0].state == gaits[1].state
        np.testing.assert_array_equal(gaits[0].jacobian, gaits[1].jacobian)


@pytest.mark.parametrize(
    ("policy", "error", "message"),
    [
        (lambda _: (2.7, 1.0), ValueError, r"controls of shape \(1, 2\), got \(2,\)"),
        (lambda states: states.no_such, TypeError, "must take states .* or one PostStrikeState"),
        (lambda states: np.full((len(states), 2), -1.0), ValueError, "switch_angle must lie in"),
        (lambda states: np.full((len(states), 2), np.nan), ValueError, "must be finite"),
        (FunctionPolicy(lambda _: None, one_by_one=True), TypeError, "must return a Control at"),
        (FunctionPolicy(len, "rocket"), ValueError, "scheme must be one of"),
        (FunctionPolicy(len, "passive"), ValueError, "must have a control"),
    ],
)
def test_policies_that_will_not_do_are_named(
    policy: Any, error: type[Exception], message: str
) -> None:
    for way in (stride, lambda state, *rest: stride_batch([state], *rest)):
        with pytest.raises(error, match=message):
            way(ROUND.state, policy, ROUND.params)


def test_a_policy_that_changes_its_scheme_is_refused() -> None:
    changing = iter([Control(2.704, 3371.8), ToeOff(0.1)])
    with pytest.raises(TypeError, match="must return a Control at every state, got ToeOff"):
        walk(ROUND.state, lambda _: next(changing), ROUND.params, 2)


def test_a_derivative_of_another_shape_is_refused() -> None:
    law = regulate(gait_of("motor"), [0.1, 10.0])

    class Transposed:
        def __call__(self, states: Array) -> Array:
            return law(states)

        def derivative(self, states: Array) -> Array:
            return law.derivative(states).swapaxes(1, 2)

    with pytest.raises(
        ValueError, match=r"derivative must have shape \(1, 2, 4\), got \(1, 4, 2\)"
    ):
        differentiate_batch([ROUND.state], Transposed(), ROUND.params)


def test_contradictions_of_control_and_scheme_are_named() -> None:
    with pytest.raises(ValueError, match="of scheme 'motor', got one of scheme 'toe-off'"):
        stride_batch([TOE.state], ToeOff(0.1), TOE.params, scheme="motor")
    with pytest.raises(ValueError, match="of scheme 'toe-off', got None, which is passive"):
        stride_batch([TOE.state], None, TOE.params, scheme="toe-off")
    with pytest.raises(TypeError, match="params must be a WalkerParams or several, got 'legs'"):
        stride_batch([TOE.state], ToeOff(0.1), ["legs"])  # type: ignore[list-item]


@pytest.mark.parametrize("name", SCHEMES)
def test_each_scheme_says_itself_which_legs_it_cannot_power(name: str) -> None:
    scheme = SCHEMES[name]
    control = None if scheme.control is None else scheme.control_of((2.9, 1.0))
    point = ROUND.params.replace(foot_length=0.0, foot_radius=0.0)
    massless = TOE.params.replace(foot_radius=0.1)
    for params in (ROUND.params, point, massless):
        walker = dataclasses.replace(params)
        refused = (params is point and scheme.moves_ankle) or (
            params is massless and name.endswith(("toe-off", "strike"))
        )
        if params is massless and not massless.massless_foot:
            continue
        if refused:
            with pytest.raises(ValueError, match="be positive for a"):
                check_walkable(walker, control)
        else:
            check_walkable(walker, control)


def test_constants_and_none_are_no_policies() -> None:
    for preset in PRESETS.values():
        assert as_policy(preset.control) is preset.control
        numbers = numbers_for(preset.control, np.zeros((2, 4)))
        assert numbers.shape == (2, len(scheme_of(preset.control).numbers))


def test_a_policy_may_return_its_numbers_in_any_order_of_memory() -> None:
    params, control, state, _ = PRESETS["round-foot"]
    numbers = np.array([control.switch_angle, control.stall_torque])

    def column_major(states: np.ndarray) -> np.ndarray:
        return np.asfortranarray(np.tile(numbers, (len(states), 1)))

    states = np.tile(np.array(state), (3, 1))
    np.testing.assert_array_equal(
        StrideMap(params, column_major)(states), StrideMap(params, control)(states)
    )
