"""The thesis's figures 4, 5 and 6 once more, in both physics, and what holds of its text.

    reproduce("reproduce/")

writes for each figure and physics a PNG, an SVG and the numbers as CSV, and `report.txt`
(`report.json` for programs): every published statement with what was found.
"""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from powered_walker_env.files import write_text
from powered_walker_env.literature.clock import Clock, Progress
from powered_walker_env.literature.figures.figure5 import COLUMNS, Figure5, figure_5
from powered_walker_env.literature.figures.statements import Statement, statements
from powered_walker_env.literature.figures.studies import (
    SETTINGS,
    Figure6,
    control_of,
    figure_4,
    figure_6,
)
from powered_walker_env.poincare import Gait
from powered_walker_env.results import versions

if TYPE_CHECKING:
    from powered_walker_env.pictures.charts import Drawing

NODES = 200  # gaits looked at in the search for figure 5, in each physics
SHARE = 60  # of the progress for the rest, in units of one gait of the search


def reproduce(
    out: str | os.PathLike[str],
    *,
    overwrite: bool = False,
    nodes: int = NODES,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Redraw the figures into a folder, which appears when all is done.

    Args:
        out: the folder; made.
        overwrite: replace the files of an existing folder.
        nodes: gaits looked at in the search for figure 5, in each physics.
        progress: called as the work goes on.

    Returns:
        What `report.json` holds.

    Raises:
        FileExistsError: the folder exists, and `overwrite` is not set.
        OSError: no folder can be made there.
        ImportError: without matplotlib.
    """
    from powered_walker_env.pictures.charts import save_drawing

    target = Path(out)
    if target.exists() and not overwrite:
        raise FileExistsError(f"{str(target)!r} exists already; choose another or overwrite it")
    if target.exists() and not target.is_dir():
        raise FileExistsError(f"{str(target)!r} is not a folder; choose another name")
    # Always the same name: what a killed run has left, the next one takes away.
    aside = target.with_name(f".{target.name}.part")
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir(parents=True)  # before the work, which would be lost if that were impossible
    try:
        report, drawings = _studied(nodes, Clock(len(SETTINGS) * (nodes + SHARE), progress))
        for name, drawing in drawings.items():
            save_drawing(drawing, aside / name)
        write_text(aside / "report.json", json.dumps(report, indent=2))
        write_text(aside / "report.txt", report_text(report))
        _move(aside, target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return report


def _move(aside: Path, target: Path) -> None:
    """The finished folder to its name, or its files one by one into the one there is."""
    if not target.exists():
        os.replace(aside, target)
        return
    for file in sorted(aside.iterdir()):
        os.replace(file, target / file.name)


def _studied(nodes: int, clock: Clock) -> tuple[dict[str, Any], dict[str, Drawing]]:
    """The report, and the drawings by name."""
    report: dict[str, Any] = {"versions": versions()}
    drawings: dict[str, Drawing] = {}
    for number, setting in enumerate(SETTINGS, start=1):
        six = figure_6(setting, figure_4(setting))
        clock.tick(SHARE // 2)
        five = figure_5(six, nodes, clock.tick)
        drawings |= _drawings(setting.physics.replace("_", "-"), six, five)
        report[setting.physics] = [dataclasses.asdict(s) for s in statements(six, five)]
        clock.tick(number * (nodes + SHARE) - clock.done)
    return report, drawings


def _drawings(physics: str, six: Figure6, five: Figure5) -> Mapping[str, Drawing]:
    from powered_walker_env.pictures import charts

    words, onset = physics.replace("-", " "), six.falling_back
    branches = [six.branch, six.doubled]
    torque = {} if onset is None else {
        f"foot falls back below {onset.stall_torque:.2f} N m": onset.stall_torque
    }  # fmt: skip
    angle = control_of(six.gait).switch_angle
    stability = charts.stability_figure(
        branches, onsets=torque, samples=(six.stall_torques, six.radii), top=2.5,
        title=f"Camp 1997, figure 6, {words}: switch angle {angle:g} rad",
    )  # fmt: skip
    title = _title(5, five.drawn.gait, words) + (five.drawn.solved and ", by construction")
    gait = charts.gait_figure(five.drawn.gait, title=title, foot_panel=True)
    searched = dict(zip(COLUMNS, five.searched.T, strict=True))
    return {
        f"figure4-{physics}": charts.gait_figure(six.gait, title=_title(4, six.gait, words)),
        f"figure5-{physics}": charts.Drawing(gait.figure, gait.columns, {"search": searched}),
        f"figure6-{physics}": stability,
        f"branch-{physics}": charts.branch_figure(branches, title=f"Gaits along figure 6, {words}"),
    }


def _title(number: int, gait: Gait, words: str) -> str:
    control = control_of(gait)
    return (
        f"Camp 1997, figure {number}, {words}: stall torque {control.stall_torque:.6g} N m,\n"
        f"switch angle {control.switch_angle:.5g} rad; largest multiplier "
        f"{gait.spectral_radius:.4f}"
    )


def report_text(report: Mapping[str, Any]) -> str:
    """The report for people."""
    lines = ["Camp 1997, figures 4 to 6: what holds", ""]
    verdicts = {True: "holds", False: "does not hold", None: "for information"}
    for physics in (setting.physics for setting in SETTINGS):
        lines += [f"{physics.replace('_', ' ')} physics", ""]
        for item in report[physics]:
            lines += [f"  {item['topic']}: {verdicts[item['holds']]}"]
            lines += [f"    thesis: {item['says']}", f"    found:  {item['found']}", ""]
    lines.append("versions: " + ", ".join(f"{k} {v}" for k, v in report["versions"].items()))
    return "\n".join(lines) + "\n"


__all__ = ["Progress", "Statement", "report_text", "reproduce"]
