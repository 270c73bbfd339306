"""What the laboratory says of a choice: its gait and multipliers, a basin, a diagram.

Each is a function of the choice alone, so that a page can compute it aside and drop it when
the choice has changed meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from powered_walker_env.controllers import (
    Controller,
    Optimal,
    TaskPolicy,
    load_controller,
    policy_of,
    shipped_policy,
)
from powered_walker_env.controllers.loading import OPEN_LOOP
from powered_walker_env.controllers.shipped import LEARNERS
from powered_walker_env.envs.arguments import TaskArguments
from powered_walker_env.envs.setup import default_range, make_task
from powered_walker_env.envs.task import Task
from powered_walker_env.explore.choice import Choice
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.poincare import (
    Basin,
    BifurcationDiagram,
    Gait,
    GaitNotFoundError,
    Optimum,
    StrideMap,
    basin,
    bifurcation_diagram,
    find_gait,
    slice_through,
    stable_gait,
)
from powered_walker_env.poincare.families import check_parameter

POINTS = 72  # of the basin's picture, across and up
SETTLED = 200  # strides after which a controller's gait is looked for where they lead
WALKED = 60  # strides at most from each of them
VALUES, TRANSIENT, KEPT = 81, 120, 24  # of the diagram: values, strides unseen and seen at each

#: Called between pieces of work; raises if nobody wants the answer any more.
Check = Callable[[], None]


@dataclass(frozen=True, eq=False)
class Prospect:
    """The gait of a choice, and the policy it walks under."""

    choice: Choice
    gait: Gait | None  # of the closed loop; None: there is none, and `problem` says why
    policy: AnyControl | Policy | None  # what decides: a control, None (passive), a controller
    start: PostStrikeState  # the gait's state, or the one looked around
    problem: str = ""  # why there is no gait, or no controller


def prospect(choice: Choice, near: Sequence[float] | None = None) -> Prospect:
    """Find the gait of a choice, near a state or anywhere, and set its controller around it.

    A controller acts around the present gait and control: the environment's task with these
    numbers, whose zero action is the slider's control. A trained policy does so as one of another
    walker would; the optimum is one of the preset as it is. Without a gait, or where the
    controller cannot be set up, the loop is open, and `problem` says so; where the controller's
    own loop has no gait, it acts all the same.
    """
    start = PostStrikeState(*(choice.known.state if near is None else near))
    try:
        gait = _gait(choice, start)
    except GaitNotFoundError as error:
        return Prospect(choice, None, choice.control, start, f"no gait: {error}")
    if choice.controller == OPEN_LOOP:
        return Prospect(choice, gait, choice.control, gait.state)
    try:
        policy = _controlled(choice, gait)
        closed = _closed_gait(choice, policy, gait)
    except (ValueError, TypeError, OSError, ImportError) as error:
        words = f"open loop, since {choice.controller} cannot act: {error}"
        return Prospect(choice, gait, choice.control, gait.state, words)
    if closed is None:
        words = f"{choice.controller} decides; its own gait of one stride is not found"
        return Prospect(choice, None, policy, gait.state, words)
    return Prospect(choice, closed, policy, closed.state)


def _gait(choice: Choice, start: PostStrikeState) -> Gait:
    """Near the state; near the preset's; else the most stable one that a search finds."""
    for guess in dict.fromkeys([start, choice.known.state]):
        try:
            return find_gait(choice.params, choice.control, guess)
        except GaitNotFoundError:
            continue
    return stable_gait(choice.params, choice.control)


def _closed_gait(choice: Choice, policy: TaskPolicy, gait: Gait) -> Gait | None:
    """Of the closed loop: near the open loop's, or where it settles; None if there is none."""
    for strides in (0, SETTLED):
        state = StrideMap(choice.params, policy)(np.array([gait.state]), strides)[0]
        try:
            return find_gait(choice.params, policy, state.tolist())
        except ValueError:  # it fell on the way, or no gait
            continue
    return None


def _controlled(choice: Choice, gait: Gait) -> TaskPolicy:
    """The controller's policy at the task whose nominal control and gait are these.

    Raises:
        ValueError, TypeError, OSError, ImportError: a passive walker, or no such controller.
    """
    if choice.control is None:
        raise ValueError("a passive walker has nothing to decide")
    task = make_task(
        TaskArguments(
            params=choice.params,
            control=choice.control,
            gait=gait.states.tolist(),
            action_range=default_range(choice.scheme, choice.preset),
            disturbance={"push": choice.usual_push},
        )
    )
    return policy_of(task, _controller(choice, task))


def _controller(choice: Choice, task: Task) -> Controller:
    """By name or file; a trained policy of the preset's environment, whatever the sliders say."""
    if choice.controller in LEARNERS and choice.env_id is not None:
        own = make_task(TaskArguments(preset=choice.preset))
        return shipped_policy(choice.controller, own, choice.env_id)
    return load_controller(choice.controller, task)[1]


def basin_view(found: Prospect, check: Check) -> Basin:
    """From where the gait is reached, in the plane through it.

    Raises:
        GaitNotFoundError: there is no gait to look around.
        ValueError: an optimum that walks the map to decide.
    """
    best, gait = _optimum_of(found), found.gait
    if best is not None and best.looks_ahead:
        raise ValueError("this optimum looks ahead: minutes")
    if gait is None:
        raise GaitNotFoundError("there is no gait to look around")
    plane = slice_through(gait, shape=(POINTS, POINTS))
    return basin(
        found.choice.params,
        found.policy,
        plane,
        strides=WALKED,
        gaits=[gait] if gait.stable else [],
        backend="threading",
        jobs=1,
        progress=lambda *_: check(),
    )


def _optimum_of(found: Prospect) -> Optimum | None:
    """What decides, if it is an optimum."""
    controller = getattr(found.policy, "controller", None)
    return controller.found if isinstance(controller, Optimal) else None


def parameters_of(found: Prospect) -> list[str]:
    """What the diagram can be drawn against: a controller leaves the walker's numbers only."""
    names = []
    for name in found.choice.numbers:
        try:
            check_parameter(name, found.policy)
        except ValueError:
            continue
        names.append(name)
    return names


def diagram_view(found: Prospect, parameter: str, check: Check) -> BifurcationDiagram:
    """What is walked at each value that the parameter's slider can take.

    Raises:
        ValueError: a parameter that the walker has no use for, or the optimum, a table for this
            walker as it is.
    """
    if _optimum_of(found) is not None:
        raise ValueError("the optimum is of this walker alone")
    low, high, _ = found.choice.reach(parameter)
    return bifurcation_diagram(
        found.choice.params,
        found.policy,
        parameter,
        np.linspace(low, high, VALUES),
        state=found.start,
        transient=TRANSIENT,
        keep=KEPT,
        backend="threading",
        jobs=1,
        progress=lambda *_: check(),
    )
