"""How stable is a gait, beyond its multipliers, and how fast do deviations die out?

- do neighbouring walks part for good? `lyapunov`;
- how much does a disturbance show? `robustness`;
- how many strides does a deviation last? `transitions`;
- from where has a walker surely converged? `trapping`.
"""

from powered_walker_env.poincare.stability.lyapunov import LyapunovExponent, lyapunov_exponent
from powered_walker_env.poincare.stability.robustness import (
    DISTURBANCES,
    INDICATORS,
    GaitSensitivity,
    gait_sensitivity,
    require_stable,
)
from powered_walker_env.poincare.stability.transitions import TransitionTimes, transition_times
from powered_walker_env.poincare.stability.trapping import Trap, trap_around, traps_of

__all__ = [
    "DISTURBANCES",
    "INDICATORS",
    "GaitSensitivity",
    "LyapunovExponent",
    "TransitionTimes",
    "Trap",
    "gait_sensitivity",
    "lyapunov_exponent",
    "require_stable",
    "transition_times",
    "trap_around",
    "traps_of",
]
