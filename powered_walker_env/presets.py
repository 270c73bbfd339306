"""Walkers with known gaits: parameters, nominal control, post-strike state and source."""

from __future__ import annotations

from typing import NamedTuple

from powered_walker_env.params import AS_PUBLISHED, Control, PostStrikeState, WalkerParams


class Preset(NamedTuple):
    """A walker and one of its limit cycles."""

    params: WalkerParams
    control: Control | None
    state: PostStrikeState
    source: str


_FIGURE_6 = WalkerParams()  # the thesis's figure 6: the defaults
_OURS = "found with this package: powered_walker_env.find_gait"

PRESETS: dict[str, Preset] = {
    "camp1997": Preset(
        _FIGURE_6,
        Control(switch_angle=2.9068, stall_torque=729.8),
        PostStrikeState(
            -0.10820777922752273, 0.1887158794835512, 0.47867085266483983, 0.4599938980583482
        ),
        f"geometry of Camp 1997, figure 6, with the physics of its text; gait {_OURS}",
    ),
    "camp1997-as-published": Preset(
        _FIGURE_6.replace(physics=AS_PUBLISHED),
        Control(switch_angle=2.8625, stall_torque=692.0),
        PostStrikeState(
            -0.46078495398981834, 0.5672048470866654, 1.6301457531864154, 1.0003707800014154
        ),
        f"Camp 1997, figures 4 and 6, physics of its listing; gait {_OURS}",
    ),
    "round-foot": Preset(
        WalkerParams(
            foot_length=0.078,
            foot_radius=0.429,
            locked_ankle_angle=0.611,
            no_load_speed=3.43,
        ),
        Control(switch_angle=2.704, stall_torque=3371.8),
        PostStrikeState(
            -0.35972933326976586, 0.4378246226474532, 1.1851372755204743, 0.277635029913339
        ),
        f"this project: round feet, with the thesis's masses; gait {_OURS}",
    ),
}


def preset(name: str) -> Preset:
    """The preset of that name.

    Raises:
        ValueError: no such preset; the message lists them.
    """
    if name not in PRESETS:
        raise ValueError(f"preset must be one of {', '.join(PRESETS)}, got {name!r}")
    return PRESETS[name]
