"""Where to look in the state space: planes in it, and in the section of a walker (`sections.py`).

A plane of the four-number space that leaves the section is mostly states that no stride makes:
of a walker with both feet on the floor, one that keeps the swing angle as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from powered_walker_env.model.checks import real_number, require
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.model.state import PostStrikeState, check_state, natural_units
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait
from powered_walker_env.poincare.sections import Section, known_section
from powered_walker_env.simulation.strides import Array

COORDINATES = PostStrikeState._fields
AXES = ("stance_angle", "stance_rate")  # of a slice if none are given
REACH = 0.1  # natural units to either side of a gait: the range if none is given
MOST_POINTS = 10_000_000  # of a slice: a gigabyte or so


@dataclass(frozen=True)
class Slice:
    """A rectangle in two coordinates of the post-strike state.

    The other two are kept, or, on the section of a walker, such as its strides end with.

    Raises:
        ValueError, TypeError: axes, ranges or a shape that make no sense.
    """

    base: PostStrikeState | Sequence[float]  # the point whose other coordinates are kept
    axes: tuple[str, str]  # across, up: names out of PostStrikeState's fields
    ranges: tuple[tuple[float, float], tuple[float, float]]  # rad or rad/s, ends included
    shape: tuple[int, int] = (200, 200)  # points across, up
    section: WalkerParams | Section | None = None  # whose section it lies on; None: on none
    hip_angle: float | None = None  # rad, of that section; None: both feet on the floor

    def __post_init__(self) -> None:
        object.__setattr__(self, "base", check_state(self.base))
        if isinstance(self.section, Section):
            object.__setattr__(self, "hip_angle", self.section.hip_angle)
            object.__setattr__(self, "section", self.section.params)
        free = COORDINATES if self.on is None else self.on.coordinates
        known = {*free, "swing_angle"}  # on a section in place of the stance angle
        axes, angles = set(self.axes), {"stance_angle", "swing_angle"}
        good = len(self.axes) == len(axes) == 2 and axes <= known
        if not good or (self.section is not None and axes == angles):
            raise ValueError(
                f"axes must be two of {', '.join(n for n in COORDINATES if n in known)}"
                f"{'' if self.section is None else ' and one angle only'}, got {self.axes!r}"
            )
        object.__setattr__(self, "ranges", _checked_ranges(self.ranges))
        object.__setattr__(self, "shape", _checked_shape(self.shape))

    @property
    def on(self) -> Section | None:
        """The section that it lies on."""
        if self.section is None:
            return None
        assert isinstance(self.section, WalkerParams)
        return Section(self.section, self.hip_angle)

    @property
    def ticks(self) -> tuple[Array, Array]:
        """The values across and up."""
        across, up = (
            np.linspace(low, high, number)
            for (low, high), number in zip(self.ranges, self.shape, strict=True)
        )
        return across, up

    @property
    def states(self) -> Array:
        """(across·up, 4); `values.reshape(up, across)` makes a picture of one number a state."""
        across, up = np.meshgrid(*self.ticks)
        states = np.tile(np.array(self.base), (across.size, 1))
        states[:, COORDINATES.index(self.axes[0])] = across.ravel()
        states[:, COORDINATES.index(self.axes[1])] = up.ravel()
        if self.on is None:
            return states
        if "swing_angle" in self.axes:
            states[:, 0] = self.on.stance_angles(states[:, 1])
        return self.on.laid(states)


def _checked_ranges(ranges: Any) -> tuple[tuple[float, float], ...]:
    try:
        pairs = tuple((real_number("ranges", a), real_number("ranges", b)) for a, b in ranges)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"ranges must be two pairs of finite numbers (low, high), got {ranges!r}"
        ) from error
    rising = len(pairs) == 2 and all(low < high for low, high in pairs)
    require(rising, "ranges", "be two pairs (low, high) that rise", ranges)
    return pairs


def _checked_shape(shape: Any) -> tuple[int, ...]:
    whole = [isinstance(n, int | np.integer) and not isinstance(n, bool) and n > 0 for n in shape]
    require(whole == [True, True], "shape", "be two positive numbers, whole ones", shape)
    points = math.prod(map(int, shape))
    if points > MOST_POINTS:
        raise ValueError(
            f"shape must give at most {MOST_POINTS:,} points, got {shape!r}, {points:,} points; "
            "take fewer, or look at parts of the ranges one after the other"
        )
    return tuple(map(int, shape))


def slice_through(
    gait: Gait,
    axes: tuple[str, str] = AXES,
    ranges: tuple[tuple[float, float], tuple[float, float]] | None = None,
    shape: tuple[int, int] = (200, 200),
    *,
    section: Section | None = None,
) -> Slice:
    """The plane through a gait to look at, on its section.

    Args:
        gait: of the walker.
        axes: across, up.
        ranges: of both, rad or rad/s; 0.1 (0.1 √(g/L) of a rate) around the gait if left out.
        shape: points across, up.
        section: left out, both feet on the floor where the foot stays locked, else the switch
            (`section_of`); where controls are chosen, one ahead of all of them. A walker that
            has none is looked at in the plane through its post-strike state.
    """
    on = known_section(gait.params, gait.control) if section is None else section
    here = np.array([gait.state]) if on is None else on.states(on.points([gait.state]))
    if ranges is None:
        corners = [corner.tolist() for corner in box_around(gait, here[0])]
        low, high = (dict(zip(COORDINATES, corner, strict=True)) for corner in corners)
        ranges = tuple((low.get(n, 0.0), high.get(n, 1.0)) for n in axes)  # type: ignore[assignment]
    return Slice(here[0].tolist(), axes, ranges, shape, on)  # type: ignore[arg-type]


def box_around(gait: Gait, state: Array) -> tuple[Array, Array]:
    """Lowest and highest states (4,) of the box that is looked at by default."""
    reach = REACH * natural_units(gait.params)
    return state - reach, state + reach


def schwab_wisse_slice(shape: tuple[int, int] = (200, 200)) -> Slice:
    """The plane in which Schwab and Wisse (2001) drew the simplest walker's basin.

    Stance angle against stance rate on the section, which has no other coordinates, at a
    slope of 0.004 (A. L. Schwab and M. Wisse, Basin of attraction of the simplest walking
    model, ASME DETC2001/VIB-21363; their angle and rate are ours with the other sign).
    The walker is `section`: `basin(plane.section, None, plane)`.
    """
    preset = PRESETS["simplest"]
    return Slice(
        preset.state, AXES, ((-0.5, 0.0), (0.0, 0.5)), shape, preset.params.replace(slope=0.004)
    )


#: Planes of the literature, by name.
SLICES: dict[str, Callable[[tuple[int, int]], Slice]] = {"schwab-wisse": schwab_wisse_slice}


def starts_of(grid: Slice | ArrayLike) -> Array:
    """(N, 4) the states of a slice, or a list of states, checked.

    Raises:
        ValueError: a wrong shape, or a state that is not finite.
    """
    states = grid.states if isinstance(grid, Slice) else np.asarray(grid, np.float64)
    if states.ndim != 2 or states.shape[1] != 4 or not len(states):
        raise ValueError(f"grid must be a Slice or states (N, 4), got shape {states.shape}")
    if not np.isfinite(states).all():
        raise ValueError("grid must hold finite states, got one that is not")
    return np.ascontiguousarray(states)
