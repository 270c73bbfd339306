"""Stability boundaries in the plane of two parameters, with the side on which a gait is stable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike, NDArray

from powered_walker_env.pictures.charts.branches import MARKS
from powered_walker_env.pictures.charts.sheet import INK, Drawing, label_of, sheet, styled
from powered_walker_env.poincare import Boundary, GaitNotFoundError, SpecialKind, find_gait
from powered_walker_env.poincare.families import Family
from powered_walker_env.simulation.strides import Array

STABLE = "#cfe3c0"  # the stable side of a boundary
BAND = 0.03  # of the bounds' widths: how far the stable side is shaded
ASIDE = 0.004  # of the bounds' widths: how far from a boundary its sides are looked at
ON_CURVE = 1e-9  # of the bounds' widths: a crossing so near is the point's own
ASKED = 5  # points of a piece of boundary whose sides are looked at


@styled
def boundary_figure(
    boundaries: Sequence[Boundary],
    *,
    nominal: tuple[float, float] | None = None,
    title: str = "",
) -> Drawing:
    """Curves in the plane of two parameters where a gait loses its stability.

    Args:
        boundaries: of the same two parameters; thick where the curve is the edge of
            stability, with its stable side shaded, thin where another multiplier is outside
            already.
        nominal: a point to mark, as the values of the two parameters.
    """
    figure, (axes,) = sheet(1, 4.4)
    names: dict[str, None] = {}
    for boundary in boundaries:
        name = boundary.kind.value.replace("Neimark-", "Neimark–")
        name += "" if boundary.period == 1 else f" of period {boundary.period}"
        colour = MARKS[boundary.kind][0]
        axes.plot(*boundary.values.T, color=colour, linewidth=0.7)
        edge = np.where(boundary.limits_stability[:, np.newaxis], boundary.values, np.nan)
        axes.plot(*edge.T, color=colour, lw=2.2, label=None if name in names else name)
        names[name] = None
        _shade_stable_side(axes, boundary, boundaries)
    if nominal is not None:
        axes.plot(*nominal, "o", color=INK, markersize=6, label="the gait asked for")
    first, second = boundaries[0].parameters
    axes.set(xlabel=label_of(first), ylabel=label_of(second), title=title)
    handles, _ = axes.get_legend_handles_labels()
    handles.append(Patch(color=STABLE, label="the stable side of an edge"))
    if not all(b.limits_stability.all() for b in boundaries):
        thin = "thin: no edge, another multiplier is outside already"
        handles.append(Line2D([], [], color=INK, lw=0.7, label=thin))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    rows = np.concatenate([b.values for b in boundaries])
    edges = np.concatenate([b.limits_stability for b in boundaries])
    columns: dict[str, ArrayLike] = {
        "kind": [b.kind.value for b in boundaries for _ in range(len(b))],
        first: rows[:, 0],
        second: rows[:, 1],
        "limits_stability": edges.astype(int),
        "critical_angle_rad": np.concatenate([b.angle for b in boundaries]),
    }
    return Drawing(figure, columns)


def _shade_stable_side(axes: Axes, boundary: Boundary, others: Sequence[Boundary]) -> None:
    """A band along each edge of stability, on the side where the gait is stable.

    It ends where it meets another curve: beyond, the gait may be unstable again; where two
    curves all but coincide there is none.
    """
    widths = np.array([high - low for low, high in boundary.bounds])
    curves = [b.values / widths for b in others]
    apart = [b.values / widths for b in others if b is not boundary]
    for piece in _edges(boundary.limits_stability):
        points = boundary.values[piece] / widths
        along = np.gradient(points, axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        normals = along @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        asked = np.unique(np.linspace(0, len(points) - 1, ASKED + 2)[1:-1].round().astype(int))
        side = np.sign(sum(
            _stable_side(boundary, normals[k] * widths, piece.start + k) for k in asked.tolist()
        ))  # fmt: skip
        if side:
            reach = np.minimum(BAND, _free_way(points, side * normals, curves))
            reach[_free_way(points, -side * normals, apart) < ASIDE] = 0.0
            far = points + reach[:, np.newaxis] * side * normals
            band = np.concatenate([points, far[::-1]]) * widths
            axes.fill(*band.T, color=STABLE, lw=0, zorder=0.5)


def _free_way(points: Array, ways: Array, curves: Sequence[Array]) -> Array:
    """(n,) how far each point can go its way (n, 2) until it meets a curve."""
    if not curves:
        return np.full(len(points), np.inf)
    starts = np.concatenate([curve[:-1] for curve in curves])
    steps = np.concatenate([np.diff(curve, axis=0) for curve in curves])
    apart = starts - points[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = _cross(ways[:, np.newaxis], steps)
        distance, share = _cross(apart, steps) / turn, _cross(apart, ways[:, np.newaxis]) / turn
    met = (share >= 0) & (share <= 1) & (distance > ON_CURVE)
    free: Array = np.where(met, distance, np.inf).min(axis=1)
    return free


def _cross(a: Array, b: Array) -> Array:
    turn: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return turn


def _edges(edge: NDArray[np.bool_]) -> Iterator[slice]:
    """Stretches of two points and more that are edges of stability."""
    flips = np.flatnonzero(np.diff(np.concatenate([[0], edge.astype(int), [0]]))).tolist()
    for begin, end in zip(flips[::2], flips[1::2], strict=True):
        if end - begin > 1:
            yield slice(begin, end)


def _stable_side(boundary: Boundary, normal: Array, index: int) -> int:
    """+1 where the gait is stable along the normal, −1 against it, 0 if that is not seen.

    A fold has gaits on one side only, a stable and an unstable one.
    """
    radii = []
    for sign in (1.0, -1.0):
        where = boundary.values[index] + sign * ASIDE * normal
        try:
            family = Family(boundary.params, boundary.control, boundary.parameters, np.ones(2))
            params, control = family.walker(where)
            state = boundary.states[index].tolist()
            found = find_gait(params, control, state, period=boundary.period)
            radii.append(found.spectral_radius)
        except (GaitNotFoundError, ValueError):
            radii.append(np.inf)
    if boundary.kind is SpecialKind.FOLD:
        there = np.isfinite(radii)
        return int(there[0]) - int(there[1])
    return int(radii[0] < 1.0) - int(radii[1] < 1.0)
