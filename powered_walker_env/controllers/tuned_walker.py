"""The walker that feels pushes least: what geometry and constant control do together.

Another walker is another environment, so this is no controller: it returns the parameters, the
control and the gait, to register or to compare. The search is local, from the control of the walker
as it is and from its tuned one, and the norm that of the linear map: how far it walks is another
question.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from powered_walker_env.controllers.following import Search, gait_near, norm_of
from powered_walker_env.controllers.linear import linearise, nominal_gait
from powered_walker_env.controllers.tuned_open_loop import tune_control
from powered_walker_env.envs.task import Task
from powered_walker_env.model.checks import real_number, require
from powered_walker_env.model.powering import AnyControl
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.simulation.strides import Array

EVALUATIONS = 1500  # of the search, at most
FIRST_STEP = 0.25  # of the way to the bounds
#: What may be chosen besides the control, where nothing is said.
GEOMETRY = ("foot_length", "foot_radius", "com_along", "leg_inertia")


class TunedWalker(NamedTuple):
    """The walker and constant control of least sensitivity."""

    params: WalkerParams
    control: AnyControl
    gait: Gait
    sensitivity: float
    nominal_sensitivity: float  # of the environment's own walker and control


def tune_walker(
    task: Task, fields: Sequence[str] = GEOMETRY, *, reach: float = 0.05
) -> TunedWalker:  # fmt: skip
    """The walker that feels pushes least: geometry and constant control chosen together.

    Local searches from the environment's control and from the tuned one, within the action bounds,
    the bounds of the fields and their domains; the better of the two.

    Args:
        task: of the environment; its action bounds hold.
        fields: numbers of `WalkerParams` (m, rad or kg m²) that may change.
        reach: how far each may go from its own: leg lengths of one in m, radians of an angle,
            leg masses times the square of the leg length of an inertia.

    Raises:
        ValueError: a field that is none, or has another unit; a gait of several strides.
    """
    reach = real_number("reach", reach)
    require(reach > 0, "reach", "be positive", reach)
    own = task.params
    units = np.array([_unit(own, name) for name in fields])
    middle, linear = np.array([own.number(name) for name in fields]), linearise(task)
    k, first = len(task.nominal), tune_control(task)

    def changed(x: Array) -> WalkerParams:
        numbers = middle + reach * x[k:] * units
        return own.replace(**dict(zip(fields, numbers.tolist(), strict=True)))

    def follow(x: Array, near: Gait) -> Gait | None:
        try:
            return gait_near(changed(x), task.control_of(x[:k]), near)
        except ValueError:  # no such walker
            return None

    def search_from(action: Array, gait: Gait) -> Search:
        start = np.concatenate([action, np.zeros(len(fields))])
        search = Search(follow, lambda gait: norm_of(task, linear, gait), (start, gait))
        search.run(np.full(len(start), FIRST_STEP), EVALUATIONS)
        return search

    starts = ((np.zeros(k), nominal_gait(task, "the tuned walker")), (first.action, first.gait))
    best = min((search_from(*start) for start in starts), key=lambda search: search.least)
    return TunedWalker(
        changed(best.x), task.control_of(best.x[:k]), best.gait, best.least,
        first.nominal_sensitivity,
    )  # fmt: skip


def _unit(params: WalkerParams, name: str) -> float:
    known = quantities(WalkerParams)
    length = params.leg_length
    units = {"m": length, "rad": 1.0, "kg m²": params.leg_mass * length**2}
    unit = known[name].unit if name in known else None
    if unit not in units:
        choice = [each for each, number in known.items() if number.unit in units]
        raise ValueError(f"fields must be out of {', '.join(choice)}, got {name!r}")
    return units[unit]
