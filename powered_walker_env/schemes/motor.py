"""Camp's walker: a passive swing, then a constant voltage extends the stance foot (1997)."""

from powered_walker_env.params import Control
from powered_walker_env.phases import Cycle, Exit, Guard, Joints, Outcome, Phase, Reset, Torque
from powered_walker_env.schemes.scheme import ANGLE, STRENGTH, Scheme

POWERED_WALKER: Cycle = (
    Phase(
        "swing",
        Joints.ANKLE_LOCKED,
        Torque.NONE,
        (
            Exit(Guard.SWITCH_ANGLE, Reset.CONTINUE, "powered"),
            Exit(Guard.LANDING, Reset.CONTINUE, Outcome.NO_SWITCH),
        ),
    ),
    Phase(
        "powered",
        Joints.ANKLE_FREE,
        Torque.MOTOR,
        (Exit(Guard.LANDING, Reset.HEEL_STRIKE, Outcome.WALKED),),
    ),
)

MOTOR = Scheme("motor", POWERED_WALKER, Control, (ANGLE, STRENGTH))
