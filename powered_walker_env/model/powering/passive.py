"""McGeer's walker: the foot stays locked for the whole stride; a slope powers it (1990)."""

from powered_walker_env.model.phases import (
    Cycle,
    Exit,
    Guard,
    Joints,
    Outcome,
    Phase,
    Reset,
    Torque,
)
from powered_walker_env.model.powering.scheme import Scheme

#: The one phase of a passive stride.
PASSIVE_WALKER: Cycle = (
    Phase(
        "swing",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),),
    ),
)

#: Nothing but the slope.
PASSIVE = Scheme("passive", PASSIVE_WALKER, None)
