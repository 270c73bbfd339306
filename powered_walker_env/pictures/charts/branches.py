"""Branches: stability and gait along one parameter, as in the thesis's figure 6 and more."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    RED,
    VIOLET,
    Drawing,
    label_of,
    sheet,
    styled,
)
from powered_walker_env.poincare import Branch, Gait, SpecialKind, SpecialPoint, StrideMap
from powered_walker_env.simulation.strides import Array

HUES = (BLUE, GREEN, VIOLET, ORANGE)  # of branches and gaits, by number
TALLEST = 3.0  # multiplier that a figure still shows
#: Colour of each kind of special point, marker and its size: two at one place are both seen.
MARKS = {
    SpecialKind.FOLD: (INK, "s", 9.5),
    SpecialKind.PERIOD_DOUBLING: (RED, "v", 6.5),
    SpecialKind.NEIMARK_SACKER: (ORANGE, "D", 4.5),
}


@styled
def stability_figure(
    branches: Sequence[Branch],
    *,
    onsets: Mapping[str, float] | None = None,
    samples: tuple[ArrayLike, ArrayLike] | None = None,
    title: str = "",
    top: float | None = None,
) -> Drawing:
    """Modulus of the largest multiplier along branches of the same parameter.

    Args:
        branches: drawn in order; solid where stable, dashed where not.
        onsets: values of the parameter to mark by a vertical line, by label.
        samples: values of the parameter and moduli, drawn as dots.
        top: of the vertical axis; at most 3 if left out.
    """
    figure, (axes,) = sheet()
    for number, branch in enumerate(branches):
        colour = HUES[number % len(HUES)]
        radius = branch.spectral_radius
        _draw(axes, branch.values, radius, branch.stable, colour, _name(branch))
    if samples is not None:
        axes.plot(*samples, "o", color=INK, markersize=3.2, label="single gaits", zorder=3)
    _limit_of_stability(axes)
    _mark(axes, [(p, abs(p.multipliers[0])) for b in branches for p in b.special_points])
    for label, value in (onsets or {}).items():
        axes.axvline(value, color=GREY, linestyle=":", linewidth=1.4, label=label)
    axes.set(ylabel="largest multiplier, modulus", title=title)
    axes.set_ylim(0, _top(branches) if top is None else top)
    _finish(axes, branches)
    figure.legend(loc="outside lower center", ncols=3, columnspacing=1.4)
    tables = {"points": points_table(branches)}
    if samples is not None:
        tables["samples"] = {branches[0].parameter: samples[0], "spectral_radius": samples[1]}
    return Drawing(figure, branch_table(branches), tables)


@styled
def branch_figure(branches: Sequence[Branch], *, title: str = "") -> Drawing:
    """Step length, speed and largest multiplier along branches of the same parameter."""
    figure, panels = sheet(3, 6.4, sharex=True)
    labels = ("step length (m)", "speed (m/s)", "largest multiplier,\nmodulus")
    for number, branch in enumerate(branches):
        lengths, speeds = each_stride(branch)
        rows = (lengths.T, speeds.T, branch.spectral_radius[np.newaxis])
        for axes, curves in zip(panels, rows, strict=True):
            for k, curve in enumerate(curves):
                named = _name(branch) if axes is panels[0] and k == 0 else None
                hue = HUES[number % len(HUES)]
                _draw(axes, branch.values, curve, branch.stable, hue, named)
    points = [p for b in branches for p in b.special_points]
    strides = [(p, *_strides(p.gait)) for p in points]
    _mark(panels[0], [(p, length) for p, lengths, _ in strides for length in lengths])
    _mark(panels[1], [(p, v) for p, _, speeds in strides for v in speeds], named=False)
    _mark(panels[2], [(p, abs(p.multipliers[0])) for p in points], named=False)
    _limit_of_stability(panels[2])
    for axes, label in zip(panels, labels, strict=True):
        axes.set_ylabel(label)
    panels[0].set_title(title)
    panels[2].set_ylim(0, _top(branches))
    _finish(panels[2], branches)
    figure.align_ylabels()
    figure.legend(loc="outside lower center", ncols=3, columnspacing=1.4)
    table = branch_table(branches)
    for k in range(max(b.period for b in branches)):
        columns = [_column(each_stride(b)[0], k) for b in branches]
        table[f"step_length_{k + 1}_m"] = np.concatenate(columns)
    return Drawing(figure, table, {"points": points_table(branches)})


def each_stride(branch: Branch) -> tuple[Array, Array]:
    """(n, period) step lengths, m, and speeds, m/s: the strides of a period differ."""
    if branch.period == 1:
        return branch.step_length[:, np.newaxis], branch.speed[:, np.newaxis]
    rows = [_strides(branch.gait(i)) for i in range(len(branch))]
    return np.array([lengths for lengths, _ in rows]), np.array([speeds for _, speeds in rows])


def _strides(gait: Gait) -> tuple[Array, Array]:
    batch = StrideMap(gait.params, gait.control).strides(gait.states)
    return batch.step_length, batch.step_length / batch.duration


def _column(values: Array, k: int) -> Array:
    return values[:, k] if k < values.shape[1] else np.full(len(values), np.nan)


def branch_table(branches: Sequence[Branch]) -> dict[str, ArrayLike]:
    """All that is drawn of branches, one row a gait."""
    number = np.repeat(np.arange(len(branches)), [len(b) for b in branches])
    table: dict[str, ArrayLike] = {
        "branch": number,
        "period": np.concatenate([np.full(len(b), b.period) for b in branches]),
        branches[0].parameter: np.concatenate([b.values for b in branches]),
        "spectral_radius": np.concatenate([b.spectral_radius for b in branches]),
        "stable": np.concatenate([b.stable for b in branches]).astype(int),
        "step_length_m": np.concatenate([b.step_length / b.period for b in branches]),
        "speed_m_s": np.concatenate([b.speed for b in branches]),
        "cost_of_transport": np.concatenate([b.cost_of_transport for b in branches]),
    }
    states = np.concatenate([b.states for b in branches])
    multipliers = np.concatenate([b.multipliers for b in branches])
    names = ("stance_angle_rad", "swing_angle_rad", "stance_rate_rad_s", "swing_rate_rad_s")
    table.update(dict(zip(names, states.T, strict=True)))
    for k, column in enumerate(multipliers.T[:3], start=1):
        table[f"multiplier_{k}_real"], table[f"multiplier_{k}_imaginary"] = column.real, column.imag
    return table


def points_table(branches: Sequence[Branch]) -> dict[str, ArrayLike]:
    """The special points of branches, one row each."""
    points = [(n, p) for n, b in enumerate(branches) for p in b.special_points]
    return {
        "branch": [n for n, _ in points],
        "kind": [p.kind.value for _, p in points],
        branches[0].parameter: [p.value for _, p in points],
        "period": [p.period for _, p in points],
        "limits_stability": [int(p.limits_stability) for _, p in points],
    }


def _name(branch: Branch) -> str:
    return "period 1" if branch.period == 1 else f"period {branch.period}"


def _pieces(stable: NDArray[np.bool_]) -> Iterator[slice]:
    """Stretches of equal stability, each with the first point of the next."""
    changes = [0, *(np.flatnonzero(np.diff(stable)) + 1).tolist(), len(stable)]
    for low, high in itertools.pairwise(changes):
        yield slice(low, min(high + 1, len(stable)))


def _draw(
    axes: Axes, x: Array, y: Array, stable: NDArray[np.bool_], colour: str, label: str | None
) -> None:
    """Solid where stable, dashed where not; one entry in the legend for each."""
    dashes: Any
    for kind, words, dashes in ((True, "stable", "-"), (False, "unstable", (0, (4, 2)))):
        named = None if label is None else f"{label}, {words}"
        for piece in _pieces(stable):
            if stable[piece.start] == kind:
                axes.plot(x[piece], y[piece], color=colour, ls=dashes, label=named)
                named = None


def _mark(axes: Axes, points: Sequence[tuple[SpecialPoint, float]], *, named: bool = True) -> None:
    for kind, (colour, marker, size) in MARKS.items():
        here = [(p.value, y) for p, y in points if p.kind is kind]
        if here:
            label = kind.value.replace("Neimark-", "Neimark–") if named else None
            x, y = np.array(here).T
            face = "none" if kind is SpecialKind.FOLD else colour
            axes.plot(
                x, y, marker, color=colour, markersize=size, label=label, zorder=4,
                markerfacecolor=face, markeredgecolor=colour if face == "none" else "white",
            )  # fmt: skip


def _limit_of_stability(axes: Axes) -> None:
    axes.axhline(1.0, color=INK, linewidth=0.8, zorder=1, label="limit of stability")


def _top(branches: Sequence[Branch]) -> float:
    """Of the axis of multipliers: not so high that stability cannot be read off."""
    return min(TALLEST, max(1.2, 1.05 * max(float(b.spectral_radius.max()) for b in branches)))


def _finish(axes: Axes, branches: Sequence[Branch]) -> None:
    axes.set_xlabel(label_of(branches[0].parameter))
    low, high = min(b.values.min() for b in branches), max(b.values.max() for b in branches)
    margin = 0.015 * (high - low)
    axes.set_xlim(low - margin, high + margin)
