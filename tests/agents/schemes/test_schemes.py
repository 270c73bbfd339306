"""The measures of the schemes, and that pages, tables and figures say what they are."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.schemes.cases import CASES, Case, Found, gaits, wanted
from agents.schemes.command import CONTENT, PAGES, main, rounded
from agents.schemes.control_map import best, control_map
from agents.schemes.figures import DRAWN, figures
from agents.schemes.measures import measured
from agents.schemes.tables import coordination, coordination_row, efficiency, efficiency_row
from agents.schemes.timing import clocked, timing
from powered_walker_env import PRESETS, Control, find_gait
from powered_walker_env.poincare import FunctionPolicy
from powered_walker_env.simulation.trajectory import log_stride

PUBLISHED: dict[str, Any] = json.loads((PAGES / CONTENT).read_text(encoding="utf-8"))
NUMBER = re.compile(r"\d+\.\d{3,}")


def rows() -> list[dict[str, Any]]:
    return [row for case in PUBLISHED["cases"] for row in case["schemes"] if "reason" not in row]


def of(legs: str) -> Any:
    params, control, state, _ = PRESETS[legs]
    return find_gait(params, control, state)


@pytest.mark.parametrize("legs", ["camp1997", "round-foot", "kneed"])
def test_a_published_row_is_measured_again(legs: str) -> None:
    case = next(each for each in PUBLISHED["cases"] if each["case"] == legs)
    row = measured(legs, Found("motor", of(legs)), PUBLISHED["samples"])
    before = next(each for each in case["schemes"] if each["scheme"] == "motor")
    assert efficiency_row(rounded(row)) == efficiency_row(before)
    assert coordination_row(rounded(row)) == coordination_row(before)


def test_tables_follow_from_the_measures() -> None:
    tables = PUBLISHED["tables"]
    assert tables == {"coordination": coordination(PUBLISHED), "efficiency": efficiency(PUBLISHED)}
    assert [case["case"] for case in PUBLISHED["cases"]] == [case.name for case in CASES]


@pytest.mark.parametrize("page", ["coordination", "efficiency"])
def test_numbers_in_the_pages_stand_in_the_tables(page: str) -> None:
    tables = PUBLISHED["tables"]
    written = {cell for name in tables for each in tables[name] for row in each["rows"]
               for cell in row}  # fmt: skip
    known = set(NUMBER.findall(" ".join(written)))
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    quoted = set(NUMBER.findall(text)) - {"0.004"}  # how far the foot falls back: below
    assert len(quoted) > 5 and quoted <= known, quoted - known
    assert len(text.splitlines()) <= 120
    for name in re.findall(r"!\[.*\]\((.*)\)", text):
        assert (PAGES / name).is_file()


def test_the_foot_falls_back_as_the_page_says() -> None:
    assert timing(of("camp1997"))["foot"]["falls_back"] == pytest.approx(0.004, abs=5e-5)


def test_all_that_is_put_in_is_lost_or_braked() -> None:
    for row in rows():
        put_in, gone = row["work"] + row["gravity"], row["lost"] + row["braked"]
        assert put_in == pytest.approx(gone, rel=1e-5, abs=1e-8), row["scheme"]


def test_speeds_are_equal_and_phases_fill_the_stride() -> None:
    for case in PUBLISHED["cases"]:
        for row in case["schemes"]:
            if "reason" in row:
                continue
            assert row["speed"] == pytest.approx(case["speed"], rel=1e-6)
            phases = row["timing"]["phases"]
            assert phases[0]["from"] == 0.0 and phases[-1]["to"] == pytest.approx(1.0, abs=1e-6)
            for one, other in itertools.pairwise(phases):
                assert one["to"] == other["from"]
            assert 0.0 < row["timing"]["legs_pass"] < 1.0


def test_a_clock_is_what_a_policy_of_one_would_be() -> None:
    gait = of("round-foot")
    at = timing(gait)["switch"] * gait.duration

    def clock(state: Any) -> Control:
        log = log_stride(tuple(state), None, gait.params, 0.0, 1e-12, at).log
        row = log[np.argmin(abs(log[:, 0] - at))]
        return Control(float(row[3] - row[2]), gait.control.stall_torque)

    loop = find_gait(gait.params, FunctionPolicy(clock, one_by_one=True), gait.state)
    assert loop.state == pytest.approx(gait.state, abs=1e-8)
    linear = clocked(gait)
    assert linear is not None
    assert loop.spectral_radius == pytest.approx(abs(linear[0]), abs=1e-5)


def test_what_has_no_switch_has_no_clock() -> None:
    assert clocked(of("toe-off")) is None and clocked(of("kneed")) is None


def test_best_controls_are_stable_and_best() -> None:
    table = control_map("kneed", 4)
    radius = np.array(table["spectral_radius"], float)
    found = best(table)
    assert found["spectral_radius"]["spectral_radius"] == np.nanmin(radius) < 1.0
    stable = np.array(table["mechanical"], float)[radius < 1.0]
    assert found["mechanical"]["mechanical"] == stable.min()


def test_schemes_without_a_gait_say_why() -> None:
    found = {each.scheme: each for each in gaits(Case("kneed"))}
    assert found["motor"].gait is not None
    assert found["passive"].gait is None and "no passive gait" in found["passive"].reason
    assert wanted(Case("round-foot", 0.75))[1] == pytest.approx(0.9593, abs=1e-4)
    with pytest.raises(ValueError, match="speed must be one of passive legs 'kneed'"):
        wanted(Case("kneed", 5.0))


def test_the_command_writes_a_folder_whole(tmp_path: Path) -> None:
    out = tmp_path / "schemes"
    main(["--out", str(out), "--small"])
    content = json.loads((out / CONTENT).read_text(encoding="utf-8"))
    assert content["cases"][0]["case"] == "camp1997"
    names = {path.name for path in out.iterdir()}
    assert names == {CONTENT, *(f"{name}.png" for name in DRAWN)}
    with pytest.raises(FileExistsError, match="must not exist yet"):
        main(["--out", str(out), "--small"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "give either --out FOLDER or --publish"),
        (["--publish", "--small"], "must be left out with --small"),
        (["--out", "x", "--redraw"], "--redraw must go with --publish"),
        (["--out", "x", "--legs", "camel"], "--legs must be of .*, got camel"),
        (["--out", "nowhere/x", "--small"], "does not exist"),
    ],
)
def test_bad_arguments_are_named(
    arguments: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ValueError, OSError), match=message):
        main(arguments)
    assert not list(tmp_path.iterdir())


def test_figures_are_drawn_of_what_there_is(tmp_path: Path) -> None:
    assert {path.stem for path in figures(PUBLISHED, tmp_path)} == set(DRAWN)
    assert figures({"cases": [], "feedback": [], "maps": []}, tmp_path) == []


def test_numbers_that_are_none_are_refused() -> None:
    assert rounded({"a": [1.23456789, (2,)]}) == {"a": [1.234568, [2]]}
    with pytest.raises(ValueError, match="must be finite, got nan"):
        rounded([float("nan")])
