"""The thesis's figures 4, 5 and 6 once more, in both physics, and what holds of its text.

    reproduce("reproduce/")

writes for each figure and physics a PNG, an SVG and the numbers as CSV, and `report.txt`
(`report.json` for programs): every published statement with what was found.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from powered_walker_env.files import write_text
from powered_walker_env.literature.figures.figure5 import COLUMNS, Figure5, figure_5
from powered_walker_env.literature.figures.statements import Statement, statements
from powered_walker_env.literature.figures.studies import (
    SETTINGS,
    Figure6,
    Setting,
    control_of,
    figure_4,
    figure_6,
)
from powered_walker_env.pictures.charts import (
    Drawing,
    branch_figure,
    gait_figure,
    save_drawing,
    stability_figure,
)
from powered_walker_env.poincare import Gait
from powered_walker_env.results import versions

NODES = 200  # gaits looked at in the search for figure 5, in each physics
SHARE = 60  # of the progress bar for the rest, in units of one gait of the search

#: Called as the work goes on: units done, units in all, seconds left.
Progress = Callable[[int, int, float], None]


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
    """
    target = Path(out)
    if target.exists() and not overwrite:
        raise FileExistsError(f"{str(target)!r} exists already; choose another or overwrite it")
    if target.exists() and not target.is_dir():
        raise FileExistsError(f"{str(target)!r} is not a folder; choose another name")
    aside = target.with_name(f".{target.name}.{os.getpid()}.part")
    shutil.rmtree(aside, ignore_errors=True)
    aside.mkdir(parents=True)
    try:
        report = _fill(aside, nodes, _Clock(len(SETTINGS) * (nodes + SHARE), progress))
        _move(aside, target)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return report


class _Clock:
    """Counts units of work and tells how long the rest will take."""

    def __init__(self, total: int, progress: Progress | None) -> None:
        self.total, self.progress = total, progress
        self.done, self.began = 0, time.monotonic()

    def __call__(self, units: int = 1) -> None:
        self.done = min(self.done + units, self.total)
        if self.progress is not None:
            taken = time.monotonic() - self.began
            left = taken / self.done * (self.total - self.done) if self.done else math.nan
            self.progress(self.done, self.total, left)


def _move(aside: Path, target: Path) -> None:
    """The finished folder to its name, or its files one by one into the one there is."""
    if not target.exists():
        os.replace(aside, target)
        return
    for file in sorted(aside.iterdir()):
        os.replace(file, target / file.name)


def _fill(folder: Path, nodes: int, clock: _Clock) -> dict[str, Any]:
    report: dict[str, Any] = {"versions": versions()}
    clock(0)
    for setting in SETTINGS:
        begun = clock.done
        gait = figure_4(setting)
        six = figure_6(setting, gait)
        clock(SHARE // 2)
        five = figure_5(six, nodes, clock)
        for name, drawing in _drawings(setting, six, five).items():
            save_drawing(drawing, folder / f"{name}-{setting.physics.replace('_', '-')}")
        found = statements(six, five)
        report[setting.physics] = [dataclasses.asdict(statement) for statement in found]
        clock(begun + nodes + SHARE - clock.done)
    write_text(folder / "report.json", json.dumps(report, indent=2))
    write_text(folder / "report.txt", report_text(report))
    return report


def _drawings(setting: Setting, six: Figure6, five: Figure5) -> dict[str, Drawing]:
    words = setting.physics.replace("_", " ")
    branches = [six.branch, six.doubled]
    onsets = {
        f"foot falls back below {o.stall_torque:.2f} N m": o.stall_torque
        for o in [six.falling_back]
        if o is not None
    }
    angle = control_of(six.gait).switch_angle
    stability = stability_figure(
        branches, onsets=onsets, samples=(six.stall_torques, six.radii), top=2.5,
        title=f"Camp 1997, figure 6, {words}: switch angle {angle:g} rad",
    )  # fmt: skip
    searched = dict(zip(COLUMNS, five.searched.T, strict=True))
    figure5 = gait_figure(five.drawn.gait, title=_title(5, five.drawn.gait, words), foot_panel=True)
    return {
        "figure4": gait_figure(six.gait, title=_title(4, six.gait, words)),
        "figure5": Drawing(figure5.figure, figure5.columns, {"search": searched}),
        "figure6": stability,
        "branch": branch_figure(branches, title=f"Gaits along figure 6, {words}"),
    }


def _title(number: int, gait: Gait, words: str) -> str:
    control = control_of(gait)
    return (
        f"Camp 1997, figure {number}, {words}: stall torque {control.stall_torque:.6g} N m,\n"
        f"switch angle {control.switch_angle:.5g} rad; largest multiplier "
        f"{gait.spectral_radius:.4f}"
    )


def report_text(report: dict[str, Any]) -> str:
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
