"""What decides the control of a stride: a constant control, none, or a policy.

One kind of each, so that a policy goes wherever a control goes, whatever powers the walker:

- a control is a frozen dataclass of numbers (`Control`, `ToeOff`, ...), None a passive walker;
- a policy maps post-strike states (N, 4) to the numbers of its scheme's control, (N, k).

A function of ONE `PostStrikeState` that returns a control is taken for a policy, too. Where
one without a `scheme` or a `derivative` is given, it is called once with one state to see
which of the two it is (`as_policy`); `FunctionPolicy` says so without a trial.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.model.powering.motor import MOTOR
from powered_walker_env.model.powering.scheme import Scheme
from powered_walker_env.model.powering.schemes import BY_CONTROL, scheme_named
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import WalkerParams

Array = NDArray[np.float64]
SOME_STATE = PostStrikeState(-0.2, 0.2, 0.7, 0.3)  # of no walker, to try a function with


class AnyControl(Protocol):
    """The control of any scheme: a frozen dataclass of numbers."""

    __dataclass_fields__: ClassVar[dict[str, Any]]


class Policy(Protocol):
    """A control law: post-strike states (N, 4) to the numbers of its scheme's control (N, k).

    An attribute `scheme`, the name of one of `SCHEMES`, says what the numbers control; left
    out, it is the motor's switch angle, rad, and stall torque, N m.

    An attribute `on_section = True` says that it decides alike at all states on one orbit of the
    locked swing, so that three numbers of a section are all it sees (`poincare.sections`). What
    is tabulated on a hip angle, where the leg is in mid-swing, asks for it (`first_passage`).

    A policy that knows its derivative, or calculates in less than double precision, has
    a method `derivative(states)`, (N, 4) to (N, k, 4): it is used in place of differences.
    """

    def __call__(self, states: Array, /) -> Array:
        """The controls of the strides that begin at these states."""


@dataclass(frozen=True, eq=False)
class FunctionPolicy:
    """A plain function as a policy.

    Args:
        function: of states (N, 4), that returns numbers (N, k); or of one
            `PostStrikeState`, that returns a control.
        scheme: what it controls, by name.
        one_by_one: whether it is of the second kind.
    """

    function: Callable[..., Any]
    scheme: str = MOTOR.name
    one_by_one: bool = False
    # The state and the answer of the trial: a function with a memory is not asked twice.
    _tried: list[tuple[PostStrikeState, Any]] = field(default_factory=list, init=False, repr=False)

    def __call__(self, states: Array) -> Array:
        """(N, k) numbers of the controls.

        Raises:
            TypeError: a function of one state that returns no control of the scheme.
        """
        if not self.one_by_one:
            return np.asarray(self.function(states), np.float64)
        named = scheme_named(self.scheme)
        chosen = [self._control(PostStrikeState(*row), named) for row in states.tolist()]
        rows = [[getattr(control, name) for name in named.numbers] for control in chosen]
        return np.array(rows, np.float64).reshape(len(states), len(named.numbers))

    def _control(self, state: PostStrikeState, named: Scheme) -> Any:
        known = self._tried and self._tried[0][0] == state
        control = self._tried.pop()[1] if known else self.function(state)
        if BY_CONTROL.get(type(control)) is not named:
            kind = getattr(named.control, "__name__", None)
            raise TypeError(
                f"a policy of one state must return a {kind} at every state, got {control!r}"
            )
        return control


def as_policy(control: Any, state: Sequence[float] = SOME_STATE) -> Any:
    """A control or None as it is; a function as the policy that it is meant for.

    Args:
        state: where to try a function that does not say what it is.

    Raises:
        TypeError: a function that takes neither one state nor many.
    """
    plain = callable(control) and not hasattr(control, "scheme")
    if not plain or hasattr(control, "derivative"):
        return control
    one = PostStrikeState(*(float(value) for value in state))
    try:
        answer = control(one)
    except Exception as error:
        return _of_many(control, one, error)
    if BY_CONTROL.get(type(answer)) is None or answer is None:
        return FunctionPolicy(control)
    policy = FunctionPolicy(control, BY_CONTROL[type(answer)].name, one_by_one=True)
    policy._tried.append((one, answer))
    return policy


def _of_many(control: Any, one: PostStrikeState, first: Exception) -> FunctionPolicy:
    """A function that will not take one state."""
    try:
        control(np.array([one]))
    except Exception as second:
        if str(first) == str(second):  # it takes both, and refuses for a reason of its own
            raise
        raise TypeError(
            f"a policy must take states (N, 4), or one PostStrikeState, got {control!r}; "
            f"of one it says {first!r}, of states {second!r}"
        ) from first
    return FunctionPolicy(control)


def scheme_of(control: Any) -> Scheme:
    """The scheme of a control, of None (a passive walker), or of a policy.

    Raises:
        TypeError: something that is no control.
        ValueError: a policy whose scheme does not exist, or has nothing to decide.
    """
    if callable(control):
        found = scheme_named(getattr(control, "scheme", MOTOR.name))
        if found.control is None:
            raise ValueError(f"a policy's scheme must have a control, got {found.name!r}")
        return found
    kind = None if control is None else type(control)
    if kind not in BY_CONTROL:
        known = ", ".join(each.__name__ for each in BY_CONTROL if each is not None)
        raise TypeError(
            f"control must be one of {known}, None for a passive walker, or a policy, "
            f"got {control!r}"
        )
    return BY_CONTROL[kind]


def numbers_for(control: AnyControl | Policy | None, states: Array) -> Array:
    """(N, k) the numbers that a control or a policy gives for the strides from states (N, 4).

    Raises:
        ValueError: a policy that returns another shape.
    """
    named = scheme_of(control)
    if not callable(control):
        numbers = np.array([getattr(control, name) for name in named.numbers], np.float64)
        return np.tile(numbers, (len(states), 1))
    chosen = np.ascontiguousarray(control(states), dtype=np.float64)
    wanted = (len(states), len(named.columns))
    if chosen.shape != wanted:
        raise ValueError(
            f"a policy must return controls of shape {wanted}, got {chosen.shape}; scheme "
            f"{named.name!r} has {', '.join(named.numbers)}"
        )
    return chosen


def decides_on_section(control: AnyControl | Policy | None) -> bool:
    """Whether a control is the same all along the swing: one that is constant, or says so."""
    return not callable(control) or bool(getattr(control, "on_section", False))


def check_walkable(params: WalkerParams, control: AnyControl | Policy | None) -> Scheme:
    """The control's scheme, which can power the walker.

    Raises:
        ValueError: an ankle motor on D = R = 0, whose foot has no lever on the floor; a
            push-off from a massless foot that is not a point.
        TypeError: an argument of the wrong type.
    """
    if not isinstance(params, WalkerParams):
        raise TypeError(f"params must be a WalkerParams, got {params!r}")
    powered = scheme_of(control)
    powered.check_walker(params)
    return powered
