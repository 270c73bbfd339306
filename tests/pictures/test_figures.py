"""Figures: what they show, what they write, and that they leave matplotlib as it was."""

from __future__ import annotations

import csv
import dataclasses
import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from powered_walker_env import PRESETS, Control, Gait, Outcome, WalkerParams, find_gait, walk
from powered_walker_env.model.powering import SCHEMES
from powered_walker_env.model.quantities import quantities
from powered_walker_env.pictures.charts import (
    Drawing,
    basin_figure,
    bifurcation_figure,
    boundary_figure,
    branch_figure,
    cycle,
    gait_figure,
    portrait_figure,
    save_drawing,
    stability_figure,
)
from powered_walker_env.pictures.charts.boundaries import STABLE
from powered_walker_env.pictures.charts.branches import MARKS, each_stride
from powered_walker_env.pictures.charts.sheet import label_of
from powered_walker_env.poincare.branches.boundary import Boundary, continue_boundary
from powered_walker_env.poincare.branches.branch import Branch
from powered_walker_env.poincare.branches.continuation import continue_gait, switch_branch
from powered_walker_env.poincare.branches.ramps import BifurcationDiagram, bifurcation_diagram
from powered_walker_env.poincare.regions.basins import FELL, Basin, basin
from powered_walker_env.poincare.regions.slices import Slice

THESIS = PRESETS["camp1997-as-published"]


@cache
def gait() -> Gait:
    return find_gait(THESIS.params, THESIS.control, THESIS.state)


@cache
def branch() -> Branch:
    return continue_gait(gait(), "stall_torque", (688.0, 735.0), step=0.05)


@cache
def boundary() -> Boundary:
    doubling = branch().special_points[-1]
    bounds = ((2.855, 2.87), (725.0, 740.0))
    return continue_boundary(doubling, ("switch_angle", "stall_torque"), bounds, step=0.2)


@cache
def starts() -> Basin:
    ranges = ((-0.5, -0.4), (1.5, 1.8))
    grid = Slice(THESIS.state, ("stance_angle", "stance_rate"), ranges, (12, 8))
    return basin(THESIS.params, THESIS.control, grid, gaits=[gait()], backend="threading")


@cache
def ramps() -> BifurcationDiagram:
    values = [725.0, 730.0, 735.0]
    return bifurcation_diagram(
        THESIS.params, THESIS.control, "stall_torque", values, transient=60, keep=4,
        backend="threading",
    )  # fmt: skip


@cache
def drawings() -> dict[str, Drawing]:
    return {
        "gait": gait_figure(gait(), title="a gait"),
        "foot": gait_figure(gait(), title="a gait", foot_panel=True),
        "stability": stability_figure(
            [branch()], onsets={"onset": 720.0}, samples=([692.0], [0.65]), title="stability"
        ),
        "branch": branch_figure([branch()], title="a branch"),
        "boundary": boundary_figure([boundary()], nominal=(2.8625, 730.0), title="a boundary"),
        "basin": basin_figure(starts(), title="a basin"),
        "bifurcation": bifurcation_figure(ramps(), title="ramps"),
    }


NAMES = ("gait", "foot", "stability", "branch", "boundary", "basin", "bifurcation")


def table(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return dict(zip(rows[0], map(list, zip(*rows[1:], strict=True)), strict=True))


def numbers(cells: Sequence[str]) -> np.ndarray:
    return np.array([float(cell) if cell else math.nan for cell in cells])


@pytest.mark.parametrize("name", NAMES)
def test_every_drawing_is_written_as_png_svg_and_csv(name: str, tmp_path: Path) -> None:
    drawing = drawings()[name]
    written = save_drawing(drawing, tmp_path / name)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in written}
    assert (tmp_path / f"{name}.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert b"<svg" in (tmp_path / f"{name}.svg").read_bytes()
    stored = table(tmp_path / f"{name}.csv")
    assert list(stored) == list(drawing.columns)
    for column, values in drawing.columns.items():
        expected = np.asarray(values)
        if expected.dtype.kind in "fi":  # to the last digit
            np.testing.assert_array_equal(numbers(stored[column]), expected)


@pytest.mark.parametrize("name", NAMES)
def test_every_axis_says_what_it_shows_in_which_unit(name: str) -> None:
    drawing = drawings()[name]
    panels: list[Axes] = drawing.figure.axes
    assert panels[0].get_title(loc="left")
    assert panels[0].get_ylabel()
    labels = [axes.get_xlabel() for axes in panels if axes.get_xlabel()]
    assert labels
    for label in labels:
        assert "(" in label or "sqrt" in label
    assert drawing.figure.legends


def test_the_same_drawing_gives_the_same_svg(tmp_path: Path) -> None:
    for name in ("one", "two"):
        save_drawing(gait_figure(gait()), tmp_path / name, formats=["svg"])
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_drawing_leaves_matplotlibs_settings_alone(tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    save_drawing(gait_figure(gait()), tmp_path / "gait")
    assert dict(matplotlib.rcParams) == before


def test_a_gaits_curves_repeat_after_a_period_and_begin_with_the_motor() -> None:
    columns = {name: np.asarray(v) for name, v in drawings()["gait"].columns.items()}
    period = gait().duration * math.sqrt(10.0)
    t = columns["t_sqrt_g_over_L"]
    assert t[0] == 0
    assert t[-1] == pytest.approx(2 * period, rel=1e-9)
    assert columns["motor_on"][0] == 1
    late = np.linspace(0.3, 0.9, 7) * period
    for name in ("stance_angle_rad", "swing_angle_rad", "foot_from_stop_rad"):
        first, second = (np.interp(late + k * period, t, columns[name]) for k in (0, 1))
        np.testing.assert_allclose(first, second, atol=2e-4)
    assert THESIS.control is not None
    hip = columns["swing_angle_rad"][0] - columns["stance_angle_rad"][0] + math.pi
    assert hip == pytest.approx(THESIS.control.switch_angle, abs=1e-9)


def test_a_branchs_table_holds_its_gaits_and_its_special_points() -> None:
    drawing = drawings()["stability"]
    np.testing.assert_array_equal(drawing.columns["stall_torque"], branch().values)
    np.testing.assert_array_equal(drawing.columns["spectral_radius"], branch().spectral_radius)
    points = drawing.tables["points"]
    assert points["kind"] == [point.kind.value for point in branch().special_points]
    assert drawing.tables["samples"]["spectral_radius"] == [0.65]


def test_solid_lines_are_stable_and_dashed_ones_are_not() -> None:
    axes = drawings()["stability"].figure.axes[0]
    solid = [line for line in axes.get_lines() if line.get_label() == "period 1, stable"]
    assert len(solid) == 1
    assert np.asarray(solid[0].get_ydata())[:-1].max() < 1
    assert solid[0].get_linestyle() == "-"


def test_a_basins_table_has_one_row_for_each_start() -> None:
    columns = drawings()["basin"].columns
    assert len(np.asarray(columns["attractor"])) == 96
    assert 0 < starts().attracted_share < 1
    assert set(columns["outcome"]) > {"walked"}  # type: ignore[arg-type]


def test_a_basin_without_picture_and_a_wrong_component_are_refused() -> None:
    listed = dataclasses.replace(starts(), grid=None)
    with pytest.raises(ValueError, match="picture needs a basin over a Slice"):
        basin_figure(listed)
    with pytest.raises(ValueError, match="component must be one of stance_angle"):
        bifurcation_figure(ramps(), component="speed")


def test_gaits_that_have_no_such_figure_are_refused() -> None:
    with pytest.raises(ValueError, match="gait must have a constant control, got a policy"):
        row = np.array([[2.8625, 692.0]])
        gait_figure(
            find_gait(THESIS.params, lambda states: np.repeat(row, len(states), 0), THESIS.state)
        )
    lighter = dataclasses.replace(gait(), params=WalkerParams(gravity=1.0))
    with pytest.raises(ValueError, match="gait must walk 3 strides to be drawn"):
        gait_figure(lighter)


def test_a_missing_folder_and_an_unknown_format_are_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="does not exist; make it first"):
        save_drawing(drawings()["gait"], tmp_path / "nowhere" / "gait")
    with pytest.raises(ValueError, match="xyz"):
        save_drawing(drawings()["gait"], tmp_path / "gait", formats=["xyz"])
    assert not list(tmp_path.iterdir())


# What a reader must see -------------------------------------------------------------------


def test_labels_and_units_are_those_of_the_numbers_own_class() -> None:
    for owner in (WalkerParams, *(scheme.control for scheme in SCHEMES.values())):
        for name, number in quantities(owner).items() if owner else ():
            label = label_of(name).replace("\n", " ").replace("\u00a0", " ")
            assert number.unit in label
    assert label_of("hip_stiffness").endswith("(N\u00a0m/rad)")
    assert label_of("torque_limit").endswith("(N\u00a0m)")
    assert label_of("stance_rate") == "stance rate (rad/s)"


def test_a_doubled_gait_forks_in_the_picture() -> None:
    """Every stride of the period has its own line, and they part from the branch's at the fork."""
    doubling = branch().special_points[-1]
    doubled = switch_branch(doubling, (688.0, 735.0), step=0.1)
    lengths, speeds = each_stride(doubled)
    assert lengths.shape == speeds.shape == (len(doubled), 2)
    np.testing.assert_allclose(lengths.sum(axis=1), doubled.step_length, rtol=1e-7)
    far = int(np.argmax(np.abs(lengths[:, 0] - lengths[:, 1])))
    here = doubled.gait(far)
    walked = walk(here.state, here.control, here.params, 2)
    np.testing.assert_allclose(np.diff(walked.landings), lengths[far], rtol=1e-6)
    panel = branch_figure([branch(), doubled]).figure.axes[0]
    drawn = np.concatenate([np.asarray(line.get_ydata(), float) for line in panel.get_lines()])
    for length in lengths[far]:
        assert np.abs(drawn - length).min() < 1e-12
    columns = branch_figure([branch(), doubled]).columns
    assert np.isnan(np.asarray(columns["step_length_2_m"])[: len(branch())]).all()


def test_two_special_points_at_one_place_are_both_seen() -> None:
    """The marker below is larger than the one above it, and hollow."""
    sizes = [size for _, _, size in MARKS.values()]
    assert sorted(sizes, reverse=True) == sizes and min(np.diff(sizes)) < 0
    axes = drawings()["stability"].figure.axes[0]
    folds = [line for line in axes.get_lines() if line.get_label() == "fold"]
    assert folds and all(line.get_markerfacecolor() == "none" for line in folds)


def test_the_shaded_side_of_a_boundary_is_stable() -> None:
    """Against gaits found again at points of the band and beyond the curve."""
    axes = drawings()["boundary"].figure.axes[0]
    bands = [p for p in axes.patches if p.get_facecolor() == to_rgba(STABLE)]
    assert bands
    x, y = boundary().values[len(boundary()) // 2]
    for side, stable in ((-1.0, True), (1.0, False)):  # the doubling is lost upwards
        where = (x, y + side * 0.1)
        found = find_gait(THESIS.params, Control(*where), THESIS.state)
        assert found.stable == stable
        inside = any(band.get_path().contains_point(where) for band in bands)
        assert inside == stable
    labels = [text.get_text() for text in drawings()["boundary"].figure.legends[0].get_texts()]
    assert "the stable side of an edge" in labels


def test_a_basin_names_its_falls_its_marker_and_what_it_keeps() -> None:
    figure = drawings()["basin"].figure
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    met = {Outcome(value).label for value in starts().outcome[starts().attractor == FELL].tolist()}
    assert {f"{label}*" for label in met} < set(labels)
    assert "the gait" in labels
    title = figure.axes[0].get_title(loc="left")
    assert "at swing angle 0.5672 rad, swing rate 1 rad/s" in title
    image = np.asarray(figure.axes[0].get_images()[0].get_array())
    ends = starts().picture("attractor") >= 0
    assert len(np.unique(image[ends], axis=0)) == 1
    assert not (image[~ends] == image[ends][0]).all(axis=-1).any()


@pytest.mark.parametrize("preset", PRESETS)
def test_every_gait_has_a_figure_and_a_portrait(preset: str) -> None:
    params, control, state, _ = PRESETS[preset]
    found = find_gait(params, control, state)
    drawing = gait_figure(found)
    t = np.asarray(drawing.columns["t_s"])
    assert t[-1] == pytest.approx(2 * found.duration, rel=1e-6)
    legend = [text.get_text() for text in drawing.figure.legends[0].get_texts()]
    assert any(word in " ".join(legend) for word in ("motor on", "hip torque on", "heel strike"))
    portrait = portrait_figure({"gait": cycle(found, found.period + 1)}).columns
    first = np.asarray(portrait["stride"]) == 0
    for name, value in zip(found.state._fields, found.state, strict=True):
        unit = "rad_s" if name.endswith("rate") else "rad"
        assert np.asarray(portrait[f"{name}_{unit}"])[first][0] == pytest.approx(value, abs=1e-9)


def test_no_walk_is_shaded_in_a_bifurcation_diagram() -> None:
    diagram = ramps()
    gone = np.full_like(diagram.up.states, np.nan)
    fallen = dataclasses.replace(diagram.up, states=gone)
    nowhere = dataclasses.replace(diagram, up=fallen, down=fallen)
    texts = bifurcation_figure(nowhere).figure.legends[0].get_texts()
    assert "no walk, up or down" in [text.get_text() for text in texts]
    texts = bifurcation_figure(diagram).figure.legends[0].get_texts()
    assert "no walk, up or down" not in [text.get_text() for text in texts]


def test_a_users_style_changes_no_picture(tmp_path: Path) -> None:
    plain = save_drawing(gait_figure(gait()), tmp_path / "plain", formats=["svg"])[0]
    with matplotlib.rc_context({"text.usetex": True, "lines.linewidth": 9, "font.size": 30}):
        styled = save_drawing(gait_figure(gait()), tmp_path / "styled", formats=["svg"])[0]
    assert plain.read_bytes() == styled.read_bytes()
