"""What a table of steps asks of its grid's section, and of a policy on it."""

from __future__ import annotations

from powered_walker_env.model.powering import AnyControl, Policy, decides_on_section
from powered_walker_env.poincare.stochastic.grid import DIMENSIONS, AnySection, Grid


def check_section(grid: Grid, *, level: bool, pushed: bool) -> None:
    """Refuse a grid that the steps leave for other states.

    Raises:
        ValueError: no section, or the feet where the ground is not level or pushes leave them.
    """
    section = grid.section
    if section is None:
        raise ValueError("grid must lie on the section of a walker (`section_of`), got none")
    if section.hip_angle is None and not level:
        raise ValueError(
            f"grid must lie on a hip angle for ground that is not level, got {section}; "
            "take section_of(params, control, level=False)"
        )
    if section.hip_angle is None and pushed and len(section.coordinates) < DIMENSIONS:
        raise ValueError(
            "grid must lie on a hip angle for pushes on a massless point foot, got "
            f"{section}; take section_of(params, control, level=False)"
        )


def check_policy(section: AnySection, control: AnyControl | Policy | None) -> None:
    """Refuse a policy that would be asked in mid-swing what it decides at heel strike.

    Raises:
        ValueError: a hip angle, and a policy that does not say it is `on_section`.
    """
    if section.hip_angle is not None and not decides_on_section(control):
        raise ValueError(
            "control must decide alike all along the swing for a table on a hip angle, got "
            f"{control!r}, which decides at heel strike by four numbers: walk it "
            "(disturbed_walks); a policy that sees the section alone says on_section = True"
        )
