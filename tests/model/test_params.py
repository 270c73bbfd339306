"""What a walker, a control and a state may be, and what is said of those that may not."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.knee import thigh_of
from powered_walker_env.model.powering.motor import Control
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams
from tests.helpers.samples import constants, kneed_walkers, random_walkers

NUMBERS = list(quantities(WalkerParams))
POSITIVE = ["leg_length", "leg_mass", "gravity", "no_load_speed"]
NOT_NEGATIVE = ["foot_length", "foot_radius", "leg_inertia", "hip_stiffness"]
PI = math.pi


def test_defaults_are_the_walker_of_figure_6() -> None:
    """Hip 1000 kg and ankle 1 kg per leg, L = 1 m, D = 0.05 m, R = 0, ω_noload = 100 rad/s."""
    assembled = WalkerParams.from_composite_leg(hip_mass=1000, foot_mass=1)
    for name in NUMBERS:
        expected = pytest.approx(getattr(assembled, name), rel=1e-15)
        assert getattr(WalkerParams(), name) == expected, name
    walker = WalkerParams()
    assert (walker.leg_length, walker.foot_length, walker.foot_radius) == (1.0, 0.05, 0.0)
    assert (walker.locked_ankle_angle, walker.no_load_speed) == (0.75 * PI, 100.0)
    assert (walker.gravity, walker.slope, walker.physics) == (10.0, 0.0, CONSERVING)


OUTSIDE = [
    *((name, value, "be positive") for name in POSITIVE for value in (0.0, -1.0)),
    *((name, -1e-9, "not be negative") for name in NOT_NEGATIVE),
    *((name, value, "be finite") for name in NUMBERS for value in (math.nan, math.inf, -math.inf)),
    *(("locked_ankle_angle", value, "lie in (-pi, pi]") for value in (-PI, 3.2, 135.0)),
    *(("slope", value, "lie in (-pi/2, pi/2)") for value in (0.5 * PI, -0.5 * PI, 3.0)),
    *(("physics", value, "be 'conserving' or 'as_published'") for value in ("newton", "", None)),
]


@pytest.mark.parametrize(("name", "value", "need"), OUTSIDE)
def test_field_outside_its_domain_is_named_with_its_need_and_value(
    name: str, value: Any, need: str
) -> None:
    message = re.escape(f"{name} must {need}, got {value!r}")
    with pytest.raises(ValueError, match=message):
        WalkerParams(**{name: value})
    with pytest.raises(ValueError, match=message):
        WalkerParams().replace(**{name: value})


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", ["1", None, True, 1j, [1.0], np.ones(1)])
def test_field_that_is_no_number_is_a_type_error(name: str, value: Any) -> None:
    message = re.escape(f"{name} must be a real number, got {value!r}")
    with pytest.raises(TypeError, match=message):
        WalkerParams(**{name: value})


def test_number_too_large_for_a_float_is_not_finite() -> None:
    with pytest.raises(ValueError, match="leg_mass must be finite, got 1000"):
        WalkerParams(leg_mass=10**400)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("locked_ankle_angle", PI),
        ("locked_ankle_angle", math.nextafter(-PI, 0)),
        ("slope", math.nextafter(0.5 * PI, 0)),
        ("foot_length", 0.0),
        ("foot_radius", 0.0),
        ("leg_inertia", 0.0),
        ("hip_stiffness", 0.0),
        ("com_along", -0.5),
        ("physics", AS_PUBLISHED),
    ],
)
def test_edge_of_a_domain_is_inside(name: str, value: Any) -> None:
    assert getattr(WalkerParams(**{name: value}), name) == value


def test_leg_with_all_its_mass_at_the_hip_is_the_limit_of_a_massless_foot() -> None:
    """Its swing leg still has an equation of motion: that of any mass at the ankle, divided by it.

    The kernels then take the swing leg as a unit mass at the ankle that does not pull at the
    rest; off that limit, however little, a leg is what its fields say.
    """
    massless = constants(WalkerParams(com_along=1.0, leg_inertia=0.0))
    assert (massless.swing_mass, massless.swing_inertia, massless.reaction) == (1.0, 0.0, 0.0)
    assert massless.hip_to_com == massless.L
    little: dict[str, float]
    for little in ({"leg_inertia": 1e-300}, {"com_across": 1e-300}, {"com_along": 1.0 + 2**-52}):
        walker = WalkerParams(**{"com_along": 1.0, "leg_inertia": 0.0, **little})
        leg = constants(walker)
        assert (leg.swing_mass, leg.reaction) == (walker.leg_mass, 1.0)
        assert leg.hip_to_com == complex(1.0 - walker.com_along, -walker.com_across)


@pytest.mark.parametrize("value", [1, np.float32(1), np.float64(1), np.int64(1)])
def test_every_kind_of_number_becomes_a_float(value: Any) -> None:
    for name in NUMBERS:
        assert type(getattr(WalkerParams(**{name: value}), name)) is float


def test_unknown_field_is_named_with_the_fields_there_are() -> None:
    walker = WalkerParams()
    known = ".*leg_length.*physics"
    with pytest.raises(TypeError, match=f"no field 'mass'{known}"):
        walker.replace(mass=1.0)
    with pytest.raises(TypeError, match=f"no field 'mass'{known}"):
        WalkerParams.from_dict({"mass": 1.0})
    with pytest.raises(TypeError, match="mass"):
        WalkerParams(mass=1.0)  # type: ignore[call-arg]


def test_walker_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        WalkerParams().slope = 0.1  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        Control(2.9, 700.0).switch_angle = 3.0  # type: ignore[misc]


def test_equal_walkers_hash_alike_and_replace_changes_nothing_else() -> None:
    one, same = WalkerParams(slope=0.1), WalkerParams().replace(slope=0.1)
    assert one == same
    assert len({one, same, WalkerParams()}) == 2
    assert one.replace(slope=0.0) == WalkerParams()
    assert {Control(2.9, 700): "gait"}[Control(2.9, 700.0)] == "gait"


def test_json_gives_back_every_walker_to_the_last_bit() -> None:
    for walker in [
        *random_walkers(1, 50),
        *kneed_walkers(1, 20),
        WalkerParams(physics=AS_PUBLISHED),
    ]:
        assert WalkerParams.from_json(walker.to_json()) == walker
        assert WalkerParams.from_dict(walker.to_dict()) == walker
        assert json.loads(walker.to_json()) == walker.to_dict()


def test_json_that_leaves_fields_out_takes_their_defaults() -> None:
    assert WalkerParams.from_json('{"slope": 0.1}') == WalkerParams(slope=0.1)


def test_json_of_something_else_is_rejected() -> None:
    with pytest.raises(TypeError, match=r"params must be a mapping of field to value, got \[1\]"):
        WalkerParams.from_json("[1]")
    with pytest.raises(ValueError, match="leg_mass must be positive, got -1"):
        WalkerParams.from_json('{"leg_mass": -1}')


# The knee.


def kneed_leg(**changes: float) -> WalkerParams:
    """Rods of 2 and 1 kg under a hip of 10 kg."""
    return WalkerParams.from_kneed_leg(
        hip_mass=10.0, **{"thigh_mass": 2.0, "shank_mass": 1.0, **changes}
    )


def test_a_kneed_leg_is_the_composite_of_its_parts() -> None:
    params = kneed_leg(foot_mass=0.5, thigh_length=0.6, shank_length=0.4)
    rods = WalkerParams.from_composite_leg(
        hip_mass=10.0, frame_mass=3.0, foot_mass=0.5, frame_com_along=(2.0 * 0.7 + 1.0 * 0.2) / 3,
        frame_inertia=2.0 * 0.36 / 12 + 1.0 * 0.16 / 12 + 2.0 / 3.0 * 0.25,
    )  # fmt: skip
    for name in ("leg_length", "leg_mass", "leg_inertia", "com_along", "com_across"):
        assert getattr(params, name) == pytest.approx(getattr(rods, name), abs=1e-15)
    knee = params.knee
    assert knee is not None
    assert knee.shank_mass == 1.5
    assert knee.shank_com_along == pytest.approx(1.0 * 0.2 / 1.5)
    assert params.number("shank_length") == knee.shank_length == 0.4


def test_thigh_and_shank_give_back_the_parts() -> None:
    thigh = thigh_of(kneed_leg(thigh_com_across=0.01))
    assert thigh.length == 0.5
    assert thigh.mass == pytest.approx(12.0)
    assert thigh.com_along == pytest.approx((10.0 * 1.0 + 2.0 * 0.75) / 12)
    assert thigh.com_across == pytest.approx(2.0 * 0.01 / 12)
    apart = 10.0 * 2.0 / 12 * (0.25**2 + 0.01**2)
    assert thigh.inertia == pytest.approx(2.0 * 0.25 / 12 + apart)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shank_length": 1.0}, "shank_length must be less than leg_length, got 1.0"),
        ({"shank_mass": 13.0}, r"shank_mass must be less than leg_mass, which is 13.0, got 13.0"),
        ({"shank_inertia": 5.0}, r"leg_inertia must leave the thigh an inertia.* at least"),
        ({"shank_mass": 0.0}, "shank_mass must be positive, got 0.0"),
        ({"shank_length": math.nan}, "shank_length must be finite, got nan"),
        ({"shank_inertia": -1.0}, "shank_inertia must not be negative, got -1.0"),
        ({"shank_inertia": 0.0, "shank_com_along": 0.5}, "shank_inertia must be positive for"),
    ],
)
def test_a_bad_split_is_refused_by_name(changes: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        kneed_leg().replace(**changes)


def test_numbers_of_a_knee_that_is_not_there_are_refused() -> None:
    for wrong in (lambda w: w.replace(shank_mass=1.0), lambda w: w.number("shank_mass")):
        with pytest.raises(ValueError, match=r"shank_mass must be of a walker with knees"):
            wrong(WalkerParams())
    with pytest.raises(ValueError, match=r"name must be one of leg_length.*shank_inertia, got 'x'"):
        WalkerParams().number("x")
    with pytest.raises(TypeError, match=r"knee must be a Knee or None, got 0.5"):
        WalkerParams(knee=0.5)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"Knee has no field 'shin'"):
        WalkerParams.from_dict({"knee": {"shin": 1.0}})


def test_replacing_a_number_of_the_knee_changes_nothing_else() -> None:
    params = kneed_leg()
    lighter = params.replace(shank_mass=0.9, slope=0.1)
    assert lighter.knee is not None
    assert lighter.knee.shank_mass == 0.9
    assert lighter.replace(shank_mass=1.0, slope=0.0) == params
    assert params.replace(knee=None).knee is None
    assert len({params, lighter, kneed_leg()}) == 2
    assert "knee" not in WalkerParams().to_dict()


@pytest.mark.parametrize(
    ("part", "value", "message"),
    [
        ("thigh_length", 0.0, "thigh_length must be positive, got 0.0"),
        ("shank_length", -1.0, "shank_length must be positive, got -1.0"),
        ("thigh_mass", -1.0, "thigh_mass must not be negative, got -1.0"),
        ("shank_inertia", -1.0, "shank_inertia must not be negative, got -1.0"),
        ("shank_mass", 0.0, r"shank_mass \+ foot_mass must be positive, got 0.0"),
    ],
)
def test_a_bad_part_of_a_leg_is_refused(part: str, value: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        kneed_leg(**{part: value})
