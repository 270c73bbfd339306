"""What does walking cost, what must it, and what do floor and joints bear?

- work, gravity and current of gaits, one scheme beside the other: `energetics`;
- the same legs under another scheme, at the same speed: `matched`;
- what a step must cost at least: `least_cost`;
- is the contact what the model takes it for? `contact`, with the forces of `ground_force`.
"""

from powered_walker_env.poincare.energy.assumptions import ContactReport
from powered_walker_env.poincare.energy.contact import contact_of, contact_report, foot_motion
from powered_walker_env.poincare.energy.energetics import (
    TIMINGS,
    Costs,
    at_equal_gait,
    comparison,
    costs,
    family_costs,
    first_gait,
    schemes_for,
    start_on_the_level,
)
from powered_walker_env.poincare.energy.ground_force import GroundForce, ground_force
from powered_walker_env.poincare.energy.least_cost import ideal_push, least_cost
from powered_walker_env.poincare.energy.matched import gait_at, passive_gaits

__all__ = [
    "TIMINGS",
    "ContactReport",
    "Costs",
    "GroundForce",
    "at_equal_gait",
    "comparison",
    "contact_of",
    "contact_report",
    "costs",
    "family_costs",
    "first_gait",
    "foot_motion",
    "gait_at",
    "ground_force",
    "ideal_push",
    "least_cost",
    "passive_gaits",
    "schemes_for",
    "start_on_the_level",
]
