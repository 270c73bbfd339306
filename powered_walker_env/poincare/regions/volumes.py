"""How much of the state space a gait attracts, by Monte Carlo with an exact interval.

Measured on the section of the walker (`sections.py`): a box in all four coordinates is mostly
states that no stride makes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Unpack

import numpy as np
import scipy.stats

from powered_walker_env.model.checks import real_number, require, whole_number
from powered_walker_env.model.powering import AnyControl, Policy
from powered_walker_env.model.walker import WalkerParams
from powered_walker_env.poincare.gaits import Gait, GaitNotFoundError
from powered_walker_env.poincare.regions.basins import Basin, basin, gaits_of
from powered_walker_env.poincare.regions.slices import COORDINATES, box_around
from powered_walker_env.poincare.sections import Section, known_section
from powered_walker_env.poincare.work.pieces import RunOptions
from powered_walker_env.simulation.strides import Array


@dataclass(frozen=True, eq=False)
class BasinVolume:
    """The share of a box of starts from which the walker converges to a gait."""

    basin: Basin = field(repr=False)  # of the random starts
    coordinates: tuple[str, ...]  # of the box: those of the walker's section, or all four
    low: Array  # (k,) corners of the box, rad and rad/s
    high: Array
    seed: int
    confidence: float
    share: float  # of the box
    share_low: float  # Clopper–Pearson bounds
    share_high: float
    section: Section | None = None  # that the starts lie on; None: on none

    @property
    def box_volume(self) -> float:
        """Of the box, in units of its coordinates: on a section rad³/s², of all four rad⁴/s²."""
        return float(np.prod(self.high - self.low))

    @property
    def volume(self) -> tuple[float, float, float]:
        """Estimate, lower and upper bound, in the same units."""
        box = self.box_volume
        return self.share * box, self.share_low * box, self.share_high * box


def basin_volume(
    params: WalkerParams,
    control: AnyControl | Policy | None,
    low: Sequence[float] | None = None,
    high: Sequence[float] | None = None,
    *,
    samples: int = 10_000,
    seed: int = 0,
    confidence: float = 0.95,
    strides: int = 100,
    gaits: Sequence[Gait] | None = None,
    section: Section | None = None,
    **run: Unpack[RunOptions],
) -> BasinVolume:
    """Share of a box of starts that converge to a gait, by seeded Monte Carlo.

    Args:
        low, high: corners of the box, rad and rad/s: three numbers (stance angle, stance
            rate, swing rate) on the walker's section (two with massless point feet on the
            floor, `Section.coordinates`), or all four of the state for a box that leaves it.
            Left out: 0.1 (0.1 √(g/L) of a rate) around the gait, on the section.
        section: left out, both feet on the floor where the foot stays locked, else the
            switch (`section_of`).
        samples: uniform random starts.
        confidence: of the exact binomial interval (Clopper and Pearson 1934), which
            covers at least that often. It covers chance, not the limit of strides: a
            walker still under way counts as not converged.
        The rest as in `basin`.

    Raises:
        ValueError: corners that do not rise or of a wrong length; as `basin`.
        GaitNotFoundError: no box, and no gait to put one around.
    """
    samples = whole_number("samples", samples, 1)
    require(0 < confidence < 1, "confidence", "lie in (0, 1)", confidence)
    known = gaits_of(params, control, gaits)
    on = known_section(params, control) if section is None else section
    names, bottom, top = _box(on, low, high, known)
    if names == COORDINATES:
        on = None
    drawn = np.random.default_rng(seed).uniform(bottom, top, (samples, len(names)))
    starts = drawn if on is None else on.states(drawn)
    stable = known if gaits is not None else tuple(gait for gait in known if gait.stable)
    found = basin(params, control, starts, strides=strides, gaits=stable, **run)
    hits = int(np.count_nonzero(found.attractor >= 0))
    bounds = scipy.stats.binomtest(hits, samples).proportion_ci(confidence)
    share_low, share_high = float(bounds.low), float(bounds.high)
    return BasinVolume(
        found, names, bottom, top, seed, confidence, hits / samples, share_low, share_high, on
    )


def _box(
    section: Section | None,
    low: Sequence[float] | None,
    high: Sequence[float] | None,
    gaits: tuple[Gait, ...],
) -> tuple[tuple[str, ...], Array, Array]:
    """Coordinates and corners of the box."""
    names = COORDINATES if section is None else section.coordinates
    if low is None and high is None:
        if not gaits:
            raise GaitNotFoundError("low and high must be given for a walker without a gait")
        here = np.array([gaits[0].state])
        if section is not None:
            here = section.states(section.points(here))
        columns = [COORDINATES.index(name) for name in names]
        bottom, top = (corner[columns] for corner in box_around(gaits[0], here[0]))
        return names, bottom, top
    if low is None or high is None:
        raise ValueError(f"low and high must be given both or not at all, got {low!r}, {high!r}")
    lengths = {len(low), len(high)}
    if lengths not in ({len(names)}, {len(COORDINATES)}):
        wanted = "4 numbers" if names == COORDINATES else f"4 numbers, or {len(names)}"
        raise ValueError(
            f"low and high must be {wanted} ({', '.join(names)}), got {low!r} and {high!r}"
        )
    bottom, top = (
        np.array([real_number(name, value) for value in corner])
        for name, corner in (("low", low), ("high", high))
    )
    if (bottom >= top).any():
        raise ValueError(f"low must be below high in all, got {low!r} and {high!r}")
    return names if len(bottom) == len(names) else COORDINATES, bottom, top
