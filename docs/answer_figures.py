"""The figures of the thesis's questions that the study's rows give."""

from __future__ import annotations

import matplotlib
from answer_tables import LADDER
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter
from study_rows import LEVELS, WALKERS, Study, points

from powered_walker_env.pictures.charts import Drawing
from powered_walker_env.pictures.charts.sheet import BLUE, GREEN, GREY, INK, RED, VIOLET, styled

COLOURS = dict(zip(WALKERS, (RED, BLUE, VIOLET, GREEN), strict=True))
MARKERS = dict(zip(WALKERS, "osD^", strict=True))
SHORT = ("4", "3", "2", "1", "1 to 1\naction", "0, by\ntrials", "0, least\nsensitive",
         "0, the\ngait's")  # fmt: skip
SHAPES = "osD^v<>phX*P8dH"  # of controllers, with a colour each
BEST = "the optimum, or the best known"


@styled
def ladder_figure(study: Study) -> Drawing:
    """Strides against measured numbers, a line for each walker; the optimum as a short line."""
    figure = Figure(figsize=(8.6, 4.2), layout="constrained")
    panels = figure.subplots(1, 2)
    places = range(len(LADDER))
    for axes, level in zip(panels, LEVELS, strict=True):
        for env_id, label in WALKERS.items():
            values = [study.value(env_id, level, name, "strides") for name in LADDER]
            heights = [float("nan") if value is None else value for value in values]
            axes.plot(places, heights, color=COLOURS[env_id], marker=MARKERS[env_id], label=label)
            best = study.value(env_id, level, "optimal", "strides")
            if best is not None:
                axes.plot([-1.0, -0.4], [best, best], color=COLOURS[env_id], linewidth=2.5)
        axes.set_xticks(list(places), SHORT, fontsize=7.5)
        axes.set(xlabel="numbers measured", ylabel="strides survived, of 100",
                 title=f"pushes: {level}", xlim=-1.1, ylim=0)  # fmt: skip
    lines, _ = panels[0].get_legend_handles_labels()
    short = Line2D([], [], color=INK, linewidth=2.5, label=f"at the left: {BEST}")
    figure.legend(handles=[*lines, short], loc="outside lower center", ncols=5, fontsize=8)
    return Drawing(figure, {"controller": list(LADDER)})


@styled
def cost_figure(study: Study) -> Drawing:
    """Mean first passage time against operations a stride; the front of each walker."""
    figure = Figure(figsize=(8.6, 8.0), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    everyone = list(dict.fromkeys(name for _, _, name in study.rows))
    looks = {
        name: {"color": matplotlib.colormaps["turbo"](0.05 + 0.9 * i / max(1, len(everyone) - 1)),
               "marker": SHAPES[i % len(SHAPES)], "linestyle": "none"}
        for i, name in enumerate(everyone)
    }  # fmt: skip
    for axes, (env_id, label) in zip(panels.ravel(), WALKERS.items(), strict=True):
        front: list[tuple[float, float]] = []
        for flops, time, name in points(study, env_id):
            best = time > max([0.0, *(each[1] for each in front)])
            front += [(flops + 1.0, time)] if best else []
            face = looks[name]["color"] if best else "white"
            axes.plot(flops + 1.0, time, **looks[name], markersize=6.5, markerfacecolor=face)
            if not study.lasts(env_id, "light", name)[1]:
                axes.annotate("↑", (flops + 1.0, time), xytext=(0, 4), ha="center",
                              textcoords="offset points")  # fmt: skip
        if front:
            axes.step(*zip(*front, strict=True), where="post", color=GREY, linewidth=0.9, zorder=0)
        axes.set(xscale="log", yscale="log", title=label)
        axes.yaxis.set_minor_formatter(NullFormatter())
    for axes in panels[-1]:
        axes.set_xlabel("floating-point operations a stride, and one")
    figure.supylabel("mean first passage time (strides; ↑: at least)", fontsize=10)
    handles = [Line2D([], [], label=name, **looks[name]) for name in everyone]
    figure.legend(handles=handles, loc="outside lower center", ncols=6, fontsize=8)
    return Drawing(figure, {"walker": list(WALKERS)})
