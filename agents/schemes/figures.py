"""The figures of the pages, from the JSON alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from powered_walker_env.pictures.charts import Drawing
from powered_walker_env.pictures.charts.energetics import COLOURS, LABELS
from powered_walker_env.pictures.charts.sheet import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    RED,
    VIOLET,
    WIDTH,
    save_figure,
    styled,
)

COMPARED = ("camp1997", "camp1997 at 0.15 m/s", "kneed at 0.85 m/s", "bhounsule-round-feet")
TIMED = ("camp1997", "round-foot", "kneed", "bhounsule-round-feet")
LOOPS = {"open loop": INK, "one number": ORANGE, "LQR": BLUE}


def figures(content: dict[str, Any], folder: Path) -> list[Path]:
    """Draw what there is into a folder that exists; each file whole or not at all."""
    drawn = ((name, draw(content)) for name, draw in DRAWN.items())
    return [
        save_figure(drawing, folder / f"{name}.png") for name, drawing in drawn
        if drawing is not None
    ]  # fmt: skip


def _cases(content: dict[str, Any], names: Sequence[str]) -> list[dict[str, Any]]:
    """Those of these names, and of their schemes those with a gait."""
    found = {case["case"]: case for case in content["cases"]}
    return [
        {**found[name], "schemes": [row for row in found[name]["schemes"] if "reason" not in row]}
        for name in names if name in found
    ]  # fmt: skip


def _panels(
    cases: Sequence[dict[str, Any]], columns: int, **arguments: Any
) -> tuple[Figure, Any]:  # fmt: skip
    """A row of panels for each case, as high as it has schemes."""
    counts = [max(len(case["schemes"]), 1) for case in cases]
    figure = Figure(figsize=(WIDTH, 0.8 * len(cases) + 0.25 * sum(counts)), layout="constrained")
    panels = figure.subplots(
        len(cases), columns, squeeze=False, height_ratios=counts, **{"sharex": "col", **arguments}
    )
    for case, row in zip(cases, panels, strict=True):
        row[0].set_title(f"{case['legs']}: {case['speed']:.3g} m/s")
        for axes in row:
            axes.set(yticks=range(len(case["schemes"])), ylim=(len(case["schemes"]) - 0.4, -0.6))
            axes.tick_params(left=False, labelleft=axes is row[0])
            axes.grid(axis="x", color=PALE, linewidth=0.6)
            axes.set_axisbelow(True)
        row[0].set_yticklabels([LABELS[each["scheme"]] for each in case["schemes"]])
    return figure, panels


@styled
def costs(content: dict[str, Any]) -> Drawing | None:
    """Mechanical cost of transport at equal speed as bars, the spectral radius beside."""
    cases = _cases(content, COMPARED)
    if not cases:
        return None
    figure, panels = _panels(cases, 2, width_ratios=[3, 2])
    for case, (left, right) in zip(cases, panels, strict=True):
        for place, row in enumerate(case["schemes"]):
            stable = row["spectral_radius"] < 1.0
            look = {"color": COLOURS[row["scheme"]], "alpha": 1.0 if stable else 0.35}
            left.barh(place, row["mechanical"], height=0.65, **look)
            left.text(
                row["mechanical"], place, f" {row['mechanical']:.4f}", va="center", fontsize=8
            )
            right.plot(row["spectral_radius"], place, "o", **look)
        right.axvline(1.0, color=GREY, linewidth=0.8)
    left.set(xscale="log", xlabel="mechanical cost of transport")
    low, high = left.get_xlim()
    left.set_xlim(low, 2.2 * high)
    right.set(xlabel="largest multiplier", xlim=(0, None))
    return Drawing(figure, {})


@styled
def energy(content: dict[str, Any]) -> Drawing | None:
    """What is put in and where it goes, over weight times distance; every case on its own scale."""
    cases = _cases(content, COMPARED)
    if not cases:
        return None
    figure, panels = _panels(cases, 1, sharex=False)
    parts = (("work", 1, VIOLET, "in: work of motor, push or hip"),
             ("gravity", 1, INK, "in: gravity, on a slope"),
             ("lost", -1, RED, "out: at heel and knee strikes"),
             ("braked", -1, ORANGE, "out: braked by the motor"))  # fmt: skip
    for case, (axes,) in zip(cases, panels, strict=True):
        for place, row in enumerate(case["schemes"]):
            ends = {1: 0.0, -1: 0.0}
            for name, sign, colour, label in parts:
                axes.barh(place, sign * row[name], left=ends[sign], height=0.65, color=colour,
                          label=label if case is cases[0] and place == 0 else None)  # fmt: skip
                ends[sign] += sign * row[name]
        axes.axvline(0.0, color=INK, linewidth=0.8)
        reach = 1.05 * max(row["work"] + row["gravity"] for row in case["schemes"])
        axes.set_xlim(-reach, reach)
        axes.locator_params(axis="x", nbins=7)
    axes.set_xlabel("energy over weight × distance")
    figure.legend(loc="outside lower center", ncols=2)
    return Drawing(figure, {})


@styled
def coordination(content: dict[str, Any]) -> Drawing | None:
    """What happens when in a stride, a bar for each scheme."""
    cases = _cases(content, TIMED)
    for case in cases:  # a push before, with or after the strike has one and the same gait
        case["schemes"] = [row for row in case["schemes"] if "-strike" not in row["scheme"]
                           and row["scheme"] != "late-toe-off"]  # fmt: skip
    if not cases:
        return None
    figure, panels = _panels(cases, 1)
    for case, (axes,) in zip(cases, panels, strict=True):
        for place, row in enumerate(case["schemes"]):
            _stride(axes, place, row)
    axes.set(xlim=(0, 1.005), xlabel="share of the stride, from heel strike to heel strike")
    for label, look in {
        "no torque": {"color": PALE, "linewidth": 8}, "torque on, foot held": {"color": ORANGE,
        "linewidth": 8}, "torque on": {"color": VIOLET, "linewidth": 8},
        "legs pass": {"color": INK, "marker": "|", "markersize": 11, "linestyle": "none"},
        "foot extends, for good": {"color": GREEN, "marker": "D", "linestyle": "none"},
        "push-off": {"color": RED, "marker": "^", "linestyle": "none"},
    }.items():  # fmt: skip
        axes.plot([], [], label=label, **look)  # type: ignore[arg-type]
    figure.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, {})


def _stride(axes: Axes, place: int, row: dict[str, Any]) -> None:
    timing = row["timing"]
    for phase in timing["phases"]:
        held = phase["name"] == "held"
        colour = (ORANGE if held else VIOLET) if phase["torque"] else PALE
        axes.barh(place, phase["to"] - phase["from"], left=phase["from"], height=0.55, color=colour)
    axes.plot(timing["legs_pass"], place, "|", color=INK, markersize=11, markeredgewidth=1.5)
    if timing["foot"]:
        axes.plot(timing["foot"]["extends_from"], place, "D", color=GREEN, markersize=5)
    if row["scheme"] == "toe-off":
        axes.plot(1.0, place, "^", color=RED, markersize=7, clip_on=False)


@styled
def control_map(content: dict[str, Any]) -> Drawing | None:
    """Spectral radius and cost over switch angle and stall torque; blank: no gait, or unstable."""
    maps = content["maps"]
    if not maps:
        return None
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    panels = figure.subplots(2, len(maps), squeeze=False, sharex="col", sharey="col")
    for table, (upper, lower) in zip(maps, panels.T, strict=True):
        x, y = table["switch_angle"], table["stall_torque"]
        radius = np.array(table["spectral_radius"], np.float64)
        cost = np.where(radius < 1.0, np.array(table["mechanical"], np.float64), np.nan)
        seen = upper.pcolormesh(x, y, np.minimum(radius, 2.0).T, cmap="RdBu_r", shading="nearest",
                                norm=TwoSlopeNorm(1.0, 0.0, 2.0), rasterized=True)  # fmt: skip
        paid = lower.pcolormesh(
            x, y, 1e3 * cost.T, cmap="viridis_r", shading="nearest", rasterized=True
        )
        for axes in (upper, lower):
            axes.plot(*table["own"], "o", color=INK, markersize=4, markerfacecolor="none")
        upper.set_title(table["legs"])
        lower.set_xlabel("switch angle (rad)")
        figure.colorbar(paid, ax=lower, location="bottom", label="1000 × cost, if stable")
    figure.colorbar(seen, ax=panels[0].tolist(), label="largest multiplier, to 2")
    panels[0, 0].set_ylabel("stall torque (N m)")
    panels[1, 0].set_ylabel("stall torque (N m)")
    return Drawing(figure, {})


@styled
def feedback(content: dict[str, Any]) -> Drawing | None:
    """Multipliers in the complex plane: open loop, one number fed back, the regulator."""
    found = content["feedback"]
    if not found:
        return None
    rows = (len(found) + 3) // 4
    figure = Figure(figsize=(WIDTH, 0.6 + 1.8 * rows), layout="constrained")
    panels = figure.subplots(rows, 4, squeeze=False).ravel()
    turn = np.linspace(0, 2 * np.pi, 200)
    for axes, case in zip(panels, found, strict=False):
        axes.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8)
        for name, loop in case["loops"].items():
            kind = name.partition(":")[0]
            if "reason" not in loop:
                axes.scatter(*np.array(loop["multipliers"]).T, s=20, color=LOOPS[kind], alpha=0.8,
                             linewidths=0)  # fmt: skip
        axes.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1), aspect="equal", xticks=(-1, 0, 1),
                 yticks=(-1, 0, 1))  # fmt: skip
        axes.set_title(case["legs"], fontsize=8)
    for axes in panels[len(found) :]:
        axes.set_visible(False)
    for name, colour in LOOPS.items():
        panels[0].plot([], [], "o", color=colour, label=name)
    figure.legend(loc="outside lower center", ncols=3)
    return Drawing(figure, {})


DRAWN: dict[str, Callable[[dict[str, Any]], Drawing | None]] = {
    "costs": costs,
    "energy": energy,
    "coordination": coordination,
    "control-map": control_map,
    "feedback": feedback,
}
