"""Passive walkers with knees: Chen (2007) on point feet, McGeer's test machine (1990).

**Chen.** Her printed fixed point is that of explicit Euler steps of 1 ms (`euler.py`): the program
of her supervisor carries it in fifteen digits, and they come out. As the step goes to zero that
gait tends to ours with first order. Her multipliers are, as they are transcribed, a fit by least
squares to 25 perturbed walks. Their complex pair is, to 0.006, the square of the pair of the
stepped map, so probably of two strides; the real one, whose square is 0.022, is not explained,
and how large the perturbations were is not known. The straight-legged walker that she compares
with is here the same walker with its knees locked; what hers is, our sources do not say.

**McGeer.** His multipliers need three momenta at heel strike: with the trailing knee free there
(the trailing shank keeps its own about the knee) the geometry of `mcgeer_machine` gives 0.4606 at
±0.9443 rad, 0.0670 and 0, contact angle 0.350, knee strike at 1.659, period 2.655; a test has it.
In this package both knees are locked at heel strike, and the same geometry walks differently.
The transcription leaves open what the lengths c, the offset w and the angle ε_K = 0.2 mean.
Tried: c of the thigh from hip or knee, c of the shank from knee or sole, w forward or backward,
ε_K 0 or ±0.2 between the thigh and the line from knee to the foot's centre, c and w along and
across that line or the thigh's; each searched from 20 starts. With the trailing knee free:

- c from the proximal joints, w backward, ε_K = 0.2 forward, all along the line from the knee to
  the foot's centre: the above, 3 % from the printed pair; with the thigh's c from the knee 0.413
  at 1.181 rad and 0.093; with the shank's c from the sole, or w forward, no gait;
- along the thigh's line: none that is stable (1.3 to 2.5 at π rad, or above 2);
- without ε_K, or with it turned back: no gait.

With it locked, w backward and along the line from knee to foot, 0.323 at 2.234 rad, 0.309 at 2.382,
0.375 at 1.785 and 0.369 at 1.763 (thigh's c from the hip, the knee; shank's from the sole, the
same), without ε_K 0.574 at 0.964, 0.634 at 0.750, 0.523 at 1.126 and 0.619 at 0.730; the rest as
above. No offset rounded as printed closes the 3 %; differences one-sided over 2.3e-4 give 0.4477
at 0.947 rad and 0.0702, which may be chance.
"""

from __future__ import annotations

import cmath
import functools
import math
from collections.abc import Sequence

from powered_walker_env.literature.values.euler import chens_walker, stepped_gait
from powered_walker_env.literature.values.passive import STATE, gait_rows
from powered_walker_env.literature.values.published import (
    KNEED_GAITS,
    Kind,
    Origin,
    half_unit,
    load,
)
from powered_walker_env.literature.values.rows import Family, Row, digits_rows
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare import Gait, find_gait
from powered_walker_env.simulation.strides import stride
from powered_walker_env.simulation.trajectory import walk

LOCKED_GUESS = (-0.24, 0.24, 1.08, 0.04)  # Chen's walker with straight legs
MACHINE_GUESS = (-0.27, 0.44, 0.37, 0.18)
RTOL = 1e-13  # of strides beside values in full precision


def mcgeer_machine() -> WalkerParams:
    """McGeer's test machine, total mass, leg length and gravity 1; both knees lock.

    The foot's centre is 0.34 (shank 0.54 less radius 0.2) from the knee along a line turned
    forward from the leg's by ε_K = 0.2. The shank's centre of mass is 0.24 along that line and
    0.01 behind it, the thigh's 0.2 below the hip; radii of gyration are about them. The hip has
    0.676 (0.68 is rounded), so that all masses add up to 1.
    """
    reach, turned = 0.34, 0.2
    shank = reach * math.cos(turned)
    com = 0.24 * math.cos(turned) + 0.01 * math.sin(turned)
    return WalkerParams.from_kneed_leg(
        hip_mass=0.338,
        thigh_mass=0.1,
        thigh_length=0.46,
        thigh_com_along=0.26,
        thigh_inertia=0.1 * 0.135**2,
        shank_mass=0.062,
        shank_length=shank,
        shank_com_along=shank - com,
        shank_com_across=0.24 * math.sin(turned) - 0.01 * math.cos(turned),
        shank_inertia=0.062 * 0.186**2,
        foot_radius=0.2,
        foot_length=reach * math.sin(turned),
        locked_ankle_angle=0.5 * math.pi,
        gravity=1.0,
        slope=0.0456,
    )


@functools.cache
def _chen() -> Gait:
    params, control, state, _ = PRESETS["chen2007"]
    return find_gait(params, control, state)


@functools.cache
def _locked() -> Gait:
    return find_gait(PRESETS["chen2007"].params.replace(knee=None), None, LOCKED_GUESS)


@functools.cache
def _machine() -> Gait:
    return find_gait(mcgeer_machine(), None, MACHINE_GUESS)


def knee_strike_time(gait: Gait) -> float:
    """When the swing knee of a gait strikes, s."""
    return walk(gait.state, gait.control, gait.params, 1, sample_interval=0, rtol=RTOL).events[0].t


def _from_vertical(state: Sequence[float], slope: float, number: int) -> float:
    """q1, q2, q1' or q2' as Chen counts them: from the vertical, backward positive."""
    return float(-state[number] - (slope if number < 2 else 0.0))


def _exact(number: int) -> float:
    return _from_vertical(_chen().state, _chen().params.slope, number)


def _stepped(number: int) -> float:
    return _from_vertical(stepped_gait().state.tolist(), chens_walker().slope, number)


def _contact_angle(gait: Gait) -> float:
    """Of the line from the foot's centre to the hip, at heel strike, rad."""
    params = gait.params
    foot = params.foot_length * cmath.exp(-1j * params.locked_ankle_angle)
    return -gait.state.stance_angle - cmath.phase(params.leg_length + foot)


def _known() -> list[Row]:
    accuracy = load("published.json")["kneed"]["accuracy"]
    rows = [row for gait in KNEED_GAITS for row in gait_rows(FAMILY.name, gait, accuracy)]
    (data,) = load("published.json")["kneed"]["gaits"]
    origin = Origin(Kind.OWN, FAMILY.name, data["walker"], data["source"])
    struck = ("knee strike, s", data["knee_strike_time"], knee_strike_time(_chen()))
    return rows + digits_rows(origin, [struck], accuracy["states"]) + _from_the_printed_state()


def _from_the_printed_state() -> list[Row]:
    data = load("published.json")["kneed"]["one_stride"]
    origin = Origin(Kind.OWN, FAMILY.name, data["walker"], data["source"])
    ours = stride(data["from"], None, PRESETS["chen2007"].params, rtol=RTOL).state
    pairs = zip(STATE, map(float, data["to"]), ours, strict=True)
    return digits_rows(origin, pairs, half_unit(data["to"][0]))


_CHEN = ("q1", "q2", "q1_rate", "q2_rate")

FAMILY = Family(
    "kneed",
    {
        **{name: functools.partial(_exact, n) for n, name in enumerate(_CHEN)},
        "interleg": lambda: _exact(0) - _exact(1),
        "duration": lambda: _chen().duration,
        "pair": lambda: complex(_chen().multipliers[0]),
        "real": lambda: complex(_chen().multipliers[2]),
        "locked_pair": lambda: complex(_locked().multipliers[0]),
        "locked_real": lambda: complex(_locked().multipliers[2]),
        **{f"stepped_{name}": functools.partial(_stepped, n) for n, name in enumerate(_CHEN)},
        "stepped_interleg": lambda: _stepped(0) - _stepped(1),
        "machine_size": lambda: abs(_machine().multipliers[0]),
        "machine_angle": lambda: abs(cmath.phase(_machine().multipliers[0])),
        "machine_second": lambda: complex(_machine().multipliers[2]),
        "machine_first": lambda: complex(_machine().multipliers[3]),
        "machine_contact": lambda: _contact_angle(_machine()),
        "machine_knee": lambda: knee_strike_time(_machine()),
        "machine_duration": lambda: _machine().duration,
    },
    _known,
)
