"""The table of published values: complete, honest about what differs, and written whole."""

from __future__ import annotations

import csv
import functools
import itertools
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from powered_walker_env import PRESETS, GaitNotFoundError, find_gait, stride
from powered_walker_env.cli import main
from powered_walker_env.literature import (
    FAMILIES,
    Kind,
    Row,
    table_csv,
    table_data,
    table_text,
    validate,
)
from powered_walker_env.literature.values import compass, li_yang, simplest
from powered_walker_env.literature.values.published import PRINTED, half_unit, load
from powered_walker_env.literature.values.rows import Family, compare, printed_rows
from powered_walker_env.poincare.branches.cascades import DELTA, doubling_cascade
from tests.helpers.derivation import Array


@functools.cache
def rows(family: str) -> list[Row]:
    return validate([family])


@pytest.mark.parametrize("family", FAMILIES)
def test_every_value_agrees_or_differs_for_the_reason_given(family: str) -> None:
    assert rows(family)
    for row in rows(family):
        assert row.passes, f"{row.walker}: {row.quantity} {row.published}, here {row.ours}"


def test_what_differs_is_what_is_known_to_differ() -> None:
    """By name: a value that stops agreeing cannot hide behind a new reason unseen."""
    differing = sorted({(entry.origin.family, entry.name) for entry in PRINTED if entry.differs})
    assert differing == [
        ("compass", "doubling_1"),
        ("compass", "two_step_pair"),
        ("compass", "two_step_real"),
        ("kneed", "interleg"),
        ("kneed", "locked_pair"),
        ("kneed", "locked_real"),
        ("kneed", "machine_angle"),
        ("kneed", "machine_first"),
        ("kneed", "machine_second"),
        ("kneed", "machine_size"),
        ("kneed", "pair"),
        ("kneed", "q1"),
        ("kneed", "q1_rate"),
        ("kneed", "q2"),
        ("kneed", "q2_rate"),
        ("kneed", "real"),
        ("mcgeer", "speed_mode"),
        ("mcgeer", "swing_mode"),
        ("mcgeer", "totter_mode"),
        ("passive", "round_angle"),
        ("passive", "round_hip_rate"),
        ("passive", "round_rate"),
        ("simplest", "law_long_angle_1"),
        ("simplest", "long_angle"),
        ("simplest", "long_multiplier"),
        ("simplest", "short_angle"),
        ("simplest", "short_multiplier"),
        ("simplest", "short_multiplier_2"),
        ("simplest", "short_rate"),
        ("toe-off", "creeping_angle"),
        ("toe-off", "creeping_rate"),
    ]


def test_every_printed_value_has_a_check_a_source_and_a_family() -> None:
    for entry in PRINTED:
        assert entry.name in FAMILIES[entry.origin.family].measures
        assert entry.origin.source and entry.origin.walker and entry.quantity
        assert 0 < entry.allowed < math.inf
        assert np.isfinite(entry.value)


@pytest.mark.parametrize(
    ("printed", "unit"),
    [
        ("0.65", 0.01), ("4.000", 1e-3), ("5", 1.0), ("-0.270837", 1e-6), ("1.20e-3", 1e-5),
        ("-0.19120868949940+0.55633363687106j", 1e-14), ("0.5+0.25j", 0.1),
    ],
)  # fmt: skip
def test_precision_is_that_of_the_last_digit(printed: str, unit: float) -> None:
    assert half_unit(printed) == pytest.approx(0.5 * unit, rel=1e-12)


def test_the_digits_decide() -> None:
    entry = next(e for e in PRINTED if e.name == "radius_4")
    assert compare(entry, 0.6546).agrees
    assert compare(entry, 0.655).agrees  # on the edge
    assert not compare(entry, 0.6551).agrees
    assert compare(entry, 0.6551).verdict == "DIFFERS"
    explained = replace(entry, differs="of something else")
    assert compare(explained, 0.7).passes
    assert not compare(explained, 0.65).passes
    assert compare(explained, 0.65).verdict == "AGREES, though said to differ"
    assert not compare(explained, complex(np.nan)).passes  # found nothing to differ
    with pytest.raises(ValueError, match="printed must hold a number"):
        half_unit("about half")


def test_a_walker_that_is_not_found_is_a_line_that_fails() -> None:
    def lost() -> complex:
        raise GaitNotFoundError("no gait")

    (row,) = printed_rows("thesis", {"radius_4": lost}, long=False)
    assert not row.passes
    assert row.ours == "nan"
    assert "1 fail" in table_text([row])
    assert (
        json.loads(json.dumps(table_data([row]), allow_nan=False))["rows"][0]["difference"] is None
    )


def massless_step(x: Array, slope: float, duration: float) -> Array:
    """(θ, θ', φ, φ') of Garcia's massless walker before the strike, by another integrator."""
    return massless_swing(slope, (0, duration), after_strike(x))


def after_strike(x: Array) -> Array:
    """(θ, θ', φ, φ') just after the strike that leads to θ and θ'."""
    angle, rate = x
    return np.array([angle, rate, 2 * angle, rate * (1 - math.cos(2 * angle))])


def massless_swing(slope: float, span: tuple[float, float], start: Array, **events: Any) -> Array:
    """Where Garcia's equations lead."""

    def flow(_: float, y: Array) -> list[float]:
        pull = math.sin(y[0] - slope)
        swing = y[1] ** 2 * math.sin(y[2]) - math.cos(y[0] - slope) * math.sin(y[2])
        return [y[1], pull, y[3], pull + swing]

    run = solve_ivp(flow, span, start, method="DOP853", rtol=1e-12, atol=1e-14, **events)
    end: Array = run.y[:, -1]
    return end


def massless_stride(x: Array, slope: float) -> Array:
    """(θ, θ') after one stride: the first strike at which the legs are well apart again."""

    def strike(_: float, y: Array) -> float:
        return float(y[2] - 2 * y[0])

    strike.terminal, strike.direction = True, 1.0  # type: ignore[attr-defined]
    apart = massless_swing(slope, (0, 1.5), after_strike(x))  # the legs have not yet passed
    theta, rate, *_ = massless_swing(slope, (1.5, 6), apart, events=strike)
    return np.array([-theta, math.cos(2 * theta) * rate])


@pytest.mark.parametrize(
    ("length", "guess"), [("long", (0.2, -0.2, 3.9)), ("short", (0.194, -0.204, 3.1))]
)
def test_the_limits_are_the_massless_walker_s(
    length: str, guess: tuple[float, float, float]
) -> None:
    def equations(v: Array, slope: float) -> list[float]:
        theta, rate, phi, _ = massless_step(v[:2], slope, v[2])
        return [phi - 2 * theta, -theta - v[0], math.cos(2 * theta) * rate - v[1]]

    exact = root(equations, guess, args=(0.009,), tol=1e-13).x
    assert np.abs(equations(exact, 0.009)).max() < 1e-10
    ours = simplest.cycle(0.009, length)
    assert ours["angle"] == pytest.approx(exact[0], abs=1e-9)
    assert ours["rate"] == pytest.approx(exact[1], abs=1e-9)
    assert ours["duration"] == pytest.approx(exact[2], abs=1e-8)
    # The laws of small slopes, two terms: what they leave shrinks like the next power.
    law, missed = simplest.law(length), []
    for slope in (8e-4, 1e-4):
        scaled = [exact[0] * (slope / 0.009) ** (1 / 3), exact[1] * (slope / 0.009) ** (1 / 3)]
        at = root(equations, [*scaled, law["tau"]], args=(slope,), tol=1e-13).x
        assert np.abs(equations(at, slope)).max() < 1e-11
        two_terms = law["angle"] * slope ** (1 / 3) + law["angle_1"] * slope
        missed.append(abs(at[0] - two_terms))
    assert missed[0] < 0.3 * 8e-4 ** (5 / 3)
    assert missed[1] < 1.5 * missed[0] / 8 ** (5 / 3)


def test_garcia_s_printed_coefficient_misses_the_gait_and_ours_does_not() -> None:
    theta, slope = simplest.cycle(0.009, "long")["angle"].real, 0.009
    law = simplest.law("long")
    printed = next(e for e in PRINTED if e.name == "law_long_angle_1").value.real
    first = law["angle"] * slope ** (1 / 3)
    assert abs(first + printed * slope - theta) == pytest.approx(7.8e-4, abs=2e-5)
    assert abs(first + law["angle_1"] * slope - theta) < 3e-5


def test_bhounsule_s_leftover_fixed_point_is_that_of_another_slope() -> None:
    params = PRESETS["bhounsule-round-feet"].params.replace(foot_radius=0.0)
    state = (-0.162597833780041, 0.162597833780041, 0.231869638058930, 0.193891169985187)
    there = stride(state, None, params, rtol=1e-12).state
    assert there == pytest.approx(state, abs=1e-12)
    said = stride(state, None, params.replace(slope=0.052), rtol=1e-12).state
    assert np.abs(np.subtract(said, state)).max() > 0.01 or not np.isfinite(said).all()


def test_the_first_two_doublings_follow_their_branches() -> None:
    preset = PRESETS["compass"]
    gait = find_gait(preset.params, None, preset.state)
    cascade = doubling_cascade(gait, "slope", compass.BOUNDS, doublings=2, step=0.05)
    assert cascade.ratios == ()
    assert [g.period for g in cascade.gaits] == [1, 2]
    assert np.degrees(cascade.values) == pytest.approx([4.3908982496, 4.914056762], abs=1e-8)
    for found in cascade.gaits:
        assert np.abs(found.multipliers + 1.0).min() < 1e-8
    with pytest.raises(GaitNotFoundError, match="no doubling of 1 strides between the bounds"):
        doubling_cascade(gait, "slope", (0.05, 0.06))
    with pytest.raises(ValueError, match="doublings must be at least 1"):
        doubling_cascade(gait, "slope", compass.BOUNDS, doublings=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "bounds"), [("compass", (0.03, 0.095)), ("nearly-simplest", (0.005, 0.0195))]
)
def test_a_cascade_tends_to_feigenbaum_s_ratio(name: str, bounds: tuple[float, float]) -> None:
    preset = PRESETS[name]
    gait = find_gait(preset.params, None, preset.state)
    cascade = doubling_cascade(gait, "slope", bounds, doublings=7, step=0.05)
    assert not cascade.stopped
    assert [g.period for g in cascade.gaits] == [2**k for k in range(7)]
    errors = [abs(ratio - DELTA) for ratio in cascade.ratios[2:]]
    assert all(b < a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("family", ["simplest", "compass"])
def test_the_long_values_agree_too(family: str) -> None:
    found = validate([family], long=True)
    assert len(found) > len(rows(family))
    assert all(row.passes for row in found)


def test_tables_hold_every_value() -> None:
    found = [*rows("wheel"), *rows("mcgeer")]
    text = table_text(found)
    for row in found:
        assert row.published in text and row.source in text and row.differs in text
    counted = "9 values, 6 agree, 3 differ for the reasons given, 0 fail"
    assert text.endswith(f"values that others printed: {counted}\nin all: {counted}")
    table = list(csv.DictReader(table_csv(found).splitlines()))
    assert [line["published"] for line in table] == [row.published for row in found]
    assert [line["verdict"] for line in table] == [row.verdict for row in found]
    data = table_data(found)
    assert data["values"] == data["agree"] + data["differ_explained"] == len(found)
    assert data["fail"] == 0


def test_three_kinds_of_origin_are_counted_and_titled_apart() -> None:
    found = [row for family in FAMILIES for row in rows(family)]
    counts = table_data(found)["by_kind"]
    assert {kind: (c["values"], c["differ_explained"]) for kind, c in counts.items()} == {
        "values that others printed": (98, 31),
        "runs of other people's programs": (31, 0),
        "this project's independent code": (81, 0),
    }
    for row in found:
        assert ("independent code" in row.source) == (row.kind is Kind.OWN)
    text = table_text(found)
    heads = [text.index(kind.upper()) for kind in Kind]
    assert heads == sorted(heads)
    for row in found:
        after = [head for head in heads if head < text.index(f"[{row.source}]")]
        assert len(after) == 1 + list(Kind).index(row.kind)


@pytest.mark.parametrize("period", li_yang.SLOPES)
def test_gaits_of_three_and_four_strides_close_no_sooner(period: int) -> None:
    """Garcia's massless equations, integrated by scipy, come back after that many strides."""
    gait = li_yang.stable_gait(period)
    x = np.array([-gait.state.stance_angle, -gait.state.stance_rate])
    cycle = [x]
    for _ in range(period):
        cycle.append(massless_stride(cycle[-1], gait.params.slope))
    away = [np.abs(later - x).max() for later in cycle[1:]]
    assert away[-1] < 1e-8
    assert min(away[:-1]) > 1e-4
    assert gait.stable and li_yang.least_period(gait) == gait.period == period


def test_the_least_period_is_told_from_its_multiples() -> None:
    single = find_gait(*PRESETS["simplest"][:3])
    assert li_yang.least_period(replace(single, period=4)) == 1


def test_the_command_prints_saves_and_refuses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = str(tmp_path / "table")
    assert main(["validate", "--only", "wheel", "--out", base]) == 0
    assert "rimless wheel" in capsys.readouterr().out
    saved = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))
    assert saved["values"] == len(rows("wheel")) and "numpy" in saved["versions"]
    assert len((tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()) == 4
    assert main(["validate", "--only", "wheel", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["fail"] == 0
    for arguments, message in (
        (["--out", base], "exists already; choose another --out, or --overwrite"),
        (["--out", str(tmp_path / "no" / "table")], "does not exist; make it first"),
        (["--out", str(tmp_path / "..")], "must end in a name"),
    ):
        status = main(["validate", "--only", "wheel", *arguments])
        assert status == 2
        assert message in capsys.readouterr().err
    assert main(["validate", "--only", "wheel", "--out", base, "--overwrite"]) == 0
    assert sorted(file.name for file in tmp_path.iterdir()) == ["table.csv", "table.json"]


def test_a_failing_value_is_an_exit_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = replace(rows("wheel")[0], agrees=False)
    monkeypatch.setitem(FAMILIES, "wheel", Family("none printed", {}, lambda: [bad]))
    assert main(["validate", "--only", "wheel"]) == 1
    assert "DIFFERS" in capsys.readouterr().out


def test_unknown_families_are_named() -> None:
    with pytest.raises(ValueError, match=r"family must be one of wheel, passive, .* got 'skater'"):
        validate(["skater"])
    assert load("published.json")["accuracy"]["states"] == 1e-12
