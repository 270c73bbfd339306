"""Walkers with known gaits: parameters, nominal control, post-strike state and source.

Walkers with `control=None` are passive: the foot stays locked and a slope powers them. They
have no action, so the environments refuse them; everything else takes them. The type of
the control says how a walker is powered (`powering/`). Gravity and
lengths are as each source has them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from powered_walker_env.model.checks import one_of
from powered_walker_env.model.powering import AnyControl, HipTorque, StoppedControl, ToeOff
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.state import PostStrikeState
from powered_walker_env.model.walker import AS_PUBLISHED, WalkerParams


class Preset(NamedTuple):
    """A walker and one of its limit cycles."""

    params: WalkerParams
    control: AnyControl | None
    state: PostStrikeState
    source: str


_FIGURE_6 = WalkerParams()  # the thesis's figure 6: the defaults
_OURS = "found with this package: powered_walker_env.find_gait"
_STRAIGHT: dict[str, Any] = {
    "foot_length": 0.0,
    "locked_ankle_angle": math.pi,
}  # no ankle: the foot's centre


def _mcgeer(com_across: float = 0.0) -> WalkerParams:
    """McGeer's nominal biped, as the legends of his figures 8 to 10 give it (lengths over l).

    Both legs' masses are 1/2, the hip has none; the leg's centre of mass is c = 0.63 above
    the sole, its radius of gyration 0.32, the foot's radius R = 0.3; so the foot's centre,
    our ankle, is 0.7 below the hip. The slope, 2.5 %, is that of his test machine.
    """
    mass, radius, height, gyration = 0.5, 0.3, 0.63, 0.32
    return WalkerParams.from_composite_leg(
        hip_mass=0.0,
        frame_mass=mass,
        frame_com_along=height - radius,
        frame_com_across=com_across,
        frame_inertia=mass * gyration**2,
        leg_length=1.0 - radius,
        foot_radius=radius,
        gravity=1.0,
        slope=0.025,
        **_STRAIGHT,
    )


def _bhounsule_round(slope: float) -> WalkerParams:
    """The round-footed walker of P. Bhounsule, passivewalker.m (2019)."""
    return WalkerParams.from_composite_leg(
        hip_mass=0.5,
        frame_mass=0.5,
        frame_inertia=0.02,
        foot_radius=0.2,
        gravity=1.0,
        slope=slope,
        **_STRAIGHT,
    )


def _chen() -> WalkerParams:
    """The kneed walker of V. F. Hsu Chen (2007): point masses on massless links, point feet."""
    return WalkerParams.from_kneed_leg(
        hip_mass=0.25,
        thigh_mass=0.5,
        thigh_com_along=0.175,
        thigh_inertia=0.0,
        shank_mass=0.05,
        shank_com_along=0.375,
        shank_inertia=0.0,
        gravity=9.81,
        slope=0.0504,
        **_STRAIGHT,
    )


#: Walkers with known gaits, by name.
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
    "simplest": Preset(
        WalkerParams.from_composite_leg(hip_mass=0.5, gravity=1.0, slope=0.009, **_STRAIGHT),
        None,
        PostStrikeState(
            -0.20031090054424586, 0.20031090054424586, 0.19983247300495147, 0.18400947305664236
        ),
        "the simplest walker of Garcia, Chatterjee, Ruina and Coleman 1998 (ASME J. Biomech. "
        f"Eng. 120(2), 281-288): feet without mass, slope 0.009; long gait {_OURS}",
    ),
    "nearly-simplest": Preset(
        WalkerParams.from_composite_leg(
            hip_mass=0.5, foot_mass=0.001, gravity=1.0, slope=0.009, **_STRAIGHT
        ),
        None,
        PostStrikeState(
            -0.20016107216970558, 0.20016107216970552, 0.19990606008763723, 0.18410058685967906
        ),
        "nearly the simplest walker of Garcia et al. 1998: foot to hip mass 0.001 (as in "
        f"P. Bhounsule, passivewalker.m), slope 0.009; long gait {_OURS}",
    ),
    "compass": Preset(
        WalkerParams.from_composite_leg(
            hip_mass=5.0,
            frame_mass=5.0,
            frame_inertia=0.0,
            gravity=9.81,
            slope=math.radians(3.0),
            **_STRAIGHT,
        ),
        None,
        PostStrikeState(
            -0.2710286804988209, 0.2710286804988209, 1.0923835898836005, 0.3773739489071896
        ),
        f"compass gait of Goswami, Thuilot and Espiau 1996 (RR-2996), 3 degrees; gait {_OURS}",
    ),
    "mcgeer1990": Preset(
        _mcgeer(),
        None,
        PostStrikeState(
            -0.2881823097732309, 0.2881823097732309, 0.38536213469182395, 0.2829797838299854
        ),
        "McGeer 1990 (Passive dynamic walking), nominal round-foot biped of his figures 8 to "
        f"10, slope 2.5 %; long gait {_OURS}",
    ),
    "mcgeer1990-offset": Preset(
        _mcgeer(com_across=-0.005),
        None,
        PostStrikeState(
            -0.2832494156143018, 0.2832494156143018, 0.37480312322918286, 0.2673372801701081
        ),
        "McGeer 1990 with the legs' masses 0.005 of the leg behind the leg line (this "
        f"project's choice: his w, of which his test machine had -0.001); gait {_OURS}",
    ),
    "bhounsule-round-feet": Preset(
        _bhounsule_round(slope=0.01),
        None,
        PostStrikeState(
            -0.18943828325270257, 0.18943828325270212, 0.23901098781294272, 0.1876139814681526
        ),
        f"round feet of P. Bhounsule, passivewalker.m (2019), slope 0.01; gait {_OURS}",
    ),
    "ranger-locked": Preset(
        WalkerParams.from_composite_leg(
            hip_mass=2.25,
            frame_mass=2.0,
            frame_com_along=0.66,
            frame_inertia=0.238,
            leg_length=0.96,
            foot_length=0.11,
            foot_radius=0.2,
            locked_ankle_angle=math.pi,
            gravity=10.0,
            slope=0.005,
        ),
        None,
        PostStrikeState(
            -0.1774162181650448, 0.1774162181650448, 0.6192085757796357, 0.5555176345799467
        ),
        "Ranger with locked ankles, long step (Bhounsule, PhD thesis, Cornell 2012, appendix "
        f"D.1; leg inertia 0.238, printed as 0.24), slope 0.005; gait {_OURS}",
    ),
    "toe-off": Preset(
        WalkerParams(leg_mass=1.0, leg_inertia=0.0825, com_along=0.75, gravity=1.0, **_STRAIGHT),
        ToeOff(impulse=0.1),
        PostStrikeState(
            -0.18350081824624714, 0.18350081824624714, 0.2733359921240272, 0.2419529708980044
        ),
        "level ground, point feet, toe-off impulse 0.1 (P. Bhounsule, lecture 20, "
        "poweredwalker.m: there with the heel strike, which gives the same gait, at nearly "
        f"twice the work); gait {_OURS}",
    ),
    "motor-with-stop": Preset(
        _FIGURE_6,
        StoppedControl(switch_angle=2.9068, stall_torque=729.8),
        PostStrikeState(
            -0.11546700222961093, 0.19714308799333058, 0.5027903789753727, 0.48172239711236314
        ),
        "this project: camp1997 with a stop that the foot cannot pass backwards (there it falls "
        f"back 0.004 rad), which makes its steps 5 % longer; gait {_OURS}",
    ),
    "hip-torque": Preset(
        _bhounsule_round(slope=0.0),
        HipTorque(switch_angle=3.1, hip_torque=0.02),
        PostStrikeState(
            -0.1420494984819677, 0.1420494984819675, 0.17837898881478287, 0.1359089208429408
        ),
        "this project: bhounsule-round-feet on level ground, powered by a torque between the "
        f"legs (continued there from its slope as the torque rose); gait {_OURS}",
    ),
    "kneed": Preset(
        WalkerParams.from_kneed_leg(
            hip_mass=23.7,
            thigh_mass=7.0,
            thigh_length=0.49,
            thigh_com_along=0.27,
            thigh_inertia=0.175,
            shank_mass=4.3,
            shank_length=0.51,
            shank_com_along=0.205,
            shank_inertia=0.137,
            foot_length=0.1,
            foot_radius=0.3,
            locked_ankle_angle=0.52,
            no_load_speed=5.3,
            hip_stiffness=11.0,
            gravity=9.81,
        ),
        Control(switch_angle=2.49, stall_torque=220.0),
        PostStrikeState(
            -0.28590004383524537, 0.3798074336757658, 1.3419545258459145, -0.24100580338351446
        ),
        "this project: Camp's motor on a walker with knees, as his section 9 proposes; masses, "
        "places and inertias of human thighs and shanks (10 % and 6 % of 70 kg each), round feet, "
        f"a soft spring between the legs; gait {_OURS}, from the passive walker's on a slope",
    ),
    "chen2007": Preset(
        _chen(),
        None,
        PostStrikeState(
            -0.23858546025339808, 0.23858546025339808, 1.109587331176566, 0.0571481063375414
        ),
        "passive walker with knees of V. F. Hsu Chen, Passive dynamic walking with knees: a point "
        f"foot model, MEng thesis, MIT 2007, slope 0.0504; gait {_OURS}",
    ),
}


def preset(name: str) -> Preset:
    """The preset of that name.

    Raises:
        ValueError: no such preset; the message lists them.
    """
    return one_of("preset", name, PRESETS)
