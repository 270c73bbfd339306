"""The figures of the study, from its records alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from agents.study.cells import CONTROLLERS, LEARNERS, LIGHT, OPEN_LOOP, OPTIMAL
from agents.study.records import DONE, Record
from agents.study.summary import grouped, median_of
from powered_walker_env.envs.registration import family
from powered_walker_env.pictures.charts import Drawing, save_drawing
from powered_walker_env.pictures.charts.sheet import GREY, INK, WIDTH, sheet, styled

Groups = dict[str, list[Record]]  # controller to its runs, at one environment
_EVERY = (*CONTROLLERS, *LEARNERS)
MARKERS = "osD^v<>phX*P8dH"  # with the colour they tell controllers apart
SPREAD = 1.2  # over the largest multiplier, of the plane that is shown


def figures(records: Sequence[Record], folder: Path) -> list[Path]:
    """Draw what there are records for; every environment its own.

    Args:
        folder: exists.

    Returns:
        The pictures, each with a CSV beside it.
    """
    written: list[Path] = []
    light = [each for each in records if each.cell.level == LIGHT and each.status == DONE]
    for env_id in dict.fromkeys(each.cell.env_id for each in light):
        some = [each for each in light if each.cell.env_id == env_id]
        groups = {name: group for (_, _, name), group in grouped(some).items()}
        for name, draw in DRAWN.items():
            drawing = draw(groups, env_id)
            if drawing is not None:
                base = folder / f"{name}-{family(env_id).lower()}"
                written += save_drawing(drawing, base, ("png",))
    return [path for path in written if path.suffix == ".png"]


def _key(axes: Axes) -> None:
    """The legend, beside what is drawn: there are too many names to stand in it."""
    axes.legend(fontsize=7.5, loc="upper left", bbox_to_anchor=(1.01, 1.0))


@styled
def survival(groups: Groups, env_id: str) -> Drawing | None:
    """Strides survived against the size of the pushes; medians over seeds."""
    having = {name: [each for each in group if each.get("sweep", "push")]
              for name, group in groups.items()}  # fmt: skip
    having = {name: group for name, group in having.items() if group}
    if not having:
        return None
    figure, (axes,) = sheet()
    push = next(iter(having.values()))[0].get("sweep", "push")
    columns: dict[str, Any] = {"push (rad/s)": push}
    for name, group in having.items():
        columns[name] = np.median([each.get("sweep", "strides") for each in group], axis=0)
        axes.plot(push, columns[name], label=name, **_look(name))
    axes.axvline(push[1], color=GREY, linewidth=0.8)
    axes.set(xlabel="pushes, standard deviation (rad/s); the line is the level it was made for",
             ylabel="strides survived, of 100", title=env_id, ylim=0)  # fmt: skip
    _key(axes)
    return Drawing(figure, columns)


@styled
def learning(groups: Groups, env_id: str) -> Drawing | None:
    """Strides survived against strides trained, of every seed, with the optimum as a line."""
    trained = {name: group for name, group in groups.items() if group[0].training}
    if not trained:
        return None
    figure, (axes,) = sheet()
    tables: dict[str, dict[str, Any]] = {}
    for name, group in trained.items():
        look = _look(name)
        curves = [each.training["curve"] for each in group]
        for curve in curves:
            axes.plot(np.maximum(curve["steps"], 10), curve["strides"], color=look["color"],
                      alpha=0.3, linewidth=0.8)  # fmt: skip
        least = min(len(curve["steps"]) for curve in curves)
        steps = np.median([curve["steps"][:least] for curve in curves], axis=0)
        middle = np.median([curve["strides"][:least] for curve in curves], axis=0)
        axes.plot(np.maximum(steps, 10), middle, label=name, **look)
        tables[name] = {"strides_trained": steps, "strides": middle}
    for name in (OPEN_LOOP, "lqr", OPTIMAL):
        if name in groups:
            value = float(np.mean(groups[name][0].get("episodes", "strides")))
            axes.axhline(value, color=INK if name == OPTIMAL else GREY,
                         linestyle="-" if name == OPTIMAL else "--", linewidth=1.0)  # fmt: skip
            axes.annotate(f"{name}: {value:.1f}", (0.01, value),
                          xycoords=axes.get_yaxis_transform(), fontsize=8,
                          xytext=(0, 2), textcoords="offset points")  # fmt: skip
    axes.set(xscale="log", xlabel="strides walked in training (the first at 10)",
             ylabel="strides survived, of 100; medians of seeds", title=env_id,
             ylim=(0, 105))  # fmt: skip
    _key(axes)
    first = next(iter(tables))
    return Drawing(figure, tables.pop(first), tables)


@styled
def energy(groups: Groups, env_id: str) -> Drawing | None:
    """Cost of transport against mean first passage time."""
    points = _points(groups, ("gait", "cost_of_transport"))
    return _scatter(points, "cost of transport of the closed loop's gait", env_id, "linear")


@styled
def computation(groups: Groups, env_id: str) -> Drawing | None:
    """Floating-point operations a decision against mean first passage time, with the front."""
    points = _points(groups, ("decision", "flops"))
    return _scatter(points, "floating-point operations a decision, and one", env_id, "log", 1.0)


@styled
def multipliers(groups: Groups, env_id: str) -> Drawing | None:
    """Multipliers of the closed loops in the complex plane, all seeds."""
    found = {
        name: np.array([value for each in group for value in each.get("gait", "multipliers") or []])
        for name, group in groups.items()
    }
    found = {name: values for name, values in found.items() if len(values)}
    if not found:
        return None
    figure = Figure(figsize=(WIDTH, 4.6), layout="constrained")
    axes = figure.subplots()
    turn = np.linspace(0, 2 * np.pi, 200)
    axes.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8)
    tables = {}
    for name, values in found.items():
        look = _look(name)
        axes.scatter(
            values[:, 0], values[:, 1], s=22, label=name, color=look["color"],
            marker=look["marker"], alpha=0.7, linewidths=0,
        )  # fmt: skip
        tables[name] = {"real": values[:, 0], "imaginary": values[:, 1]}
    reach = SPREAD * max(1.0, *(float(np.abs(values).max()) for values in found.values()))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), box_aspect=1, title=env_id,
             xlabel="real part of a multiplier", ylabel="imaginary part")  # fmt: skip
    _key(axes)
    first = next(iter(tables))
    return Drawing(figure, tables.pop(first), tables)


@styled
def actions(groups: Groups, env_id: str) -> Drawing | None:
    """Decisions over a slice of the state space: the optimum's, a regulator's, learners'."""
    wanted = [name for name in (OPTIMAL, "lqr", "ppo", "sac", "cmaes") if name in groups]
    shown = {name: groups[name][0] for name in wanted if groups[name][0].get("decided", "axis")}
    if not shown:
        return None
    some = next(iter(shown.values()))
    axis, kinds = some.get("decided", "axis"), len(some.get("decided", "actions"))
    figure = Figure(figsize=(WIDTH, 1.0 + 2.0 * kinds), layout="constrained")
    panels = figure.subplots(kinds, len(shown), squeeze=False, sharex=True, sharey=True)
    columns: dict[str, Any] = dict(
        zip(("stance_rate", "stance_angle"),
            (values.ravel() for values in np.meshgrid(axis, axis, indexing="ij")), strict=True)
    )  # fmt: skip
    for k, (name, record) in enumerate(shown.items()):
        for j, values in enumerate(record.get("decided", "actions")):
            image = panels[j, k].pcolormesh(axis, axis, values, cmap="RdBu", vmin=-1, vmax=1)
            columns[f"{name}_{j}"] = np.ravel(values)
        panels[0, k].set_title(name)
    for j in range(kinds):
        panels[j, 0].set_ylabel(f"{some.get('decided', 'numbers')[j]}:\nstance rate")
    figure.supxlabel("stance angle")
    figure.colorbar(image, ax=panels, label="action")
    figure.suptitle(f"{env_id}: deviations from the gait, as observed", fontsize=9.5)
    return Drawing(figure, columns)


DRAWN: dict[str, Callable[[Groups, str], Drawing | None]] = {
    "survival": survival,
    "learning": learning,
    "energy": energy,
    "computation": computation,
    "multipliers": multipliers,
    "actions": actions,
}


def _points(groups: Groups, place: tuple[str, str]) -> dict[str, tuple[float, float]]:
    """A value and the mean first passage time (its lower bound without falls), in the median."""
    found = {}
    for name, group in groups.items():
        x, y = median_of(group, *place)[0], median_of(group, "passage", "mean")[0]
        y = median_of(group, "passage", "low")[0] if y is None else y
        if x is not None and y is not None:
            found[name] = (x, y)
    return found


def _scatter(
    points: dict[str, tuple[float, float]], label: str, env_id: str, scale: str, shift: float = 0.0
) -> Drawing | None:
    if not points:
        return None
    figure, (axes,) = sheet()
    x, y = np.array(list(points.values())).T
    for name, (one, other) in points.items():
        look = _look(name)
        axes.plot(one + shift, other, linestyle="none", label=name, **{**look, "markersize": 7})
    order = np.lexsort((-y, x))
    front = [k for place, k in enumerate(order) if y[k] > max([0.0, *y[order[:place]]])]
    axes.step(x[front] + shift, y[front], where="post", color=GREY, linewidth=0.8, zorder=0)
    axes.set(xscale=scale, yscale="log", xlabel=label,
             ylabel="mean first passage time (strides)", title=env_id)  # fmt: skip
    _key(axes)
    best = [name in {list(points)[k] for k in front} for name in points]
    return Drawing(figure, {"controller": list(points), "x": x, "strides": y, "on_front": best})


def _look(name: str) -> dict[str, Any]:
    """One colour and marker for each, in every figure."""
    place = _EVERY.index(name)
    colour = matplotlib.colormaps["turbo"](0.05 + 0.9 * place / (len(_EVERY) - 1))
    return {"color": colour, "marker": MARKERS[place % len(MARKERS)], "markersize": 4}
