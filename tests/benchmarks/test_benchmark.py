"""The benchmarks: their equations are right, their counts count, the command runs."""

from __future__ import annotations

import csv
import itertools
import json
import math
import re
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks import contenders as contenders_module
from benchmarks.command import main
from benchmarks.contenders import contenders, scipy_strides
from benchmarks.counting import (
    Counted,
    count,
    evaluation_flops,
    sine_and_cosine,
    step_flops,
)
from benchmarks.equations import constants, equations
from benchmarks.precision import Precision, precision, speed_at
from benchmarks.problem import STARTS, make_problem
from benchmarks.scaling import core_counts
from benchmarks.startup import startup
from benchmarks.tables import precision_text
from benchmarks.timing import Case, Timing, measure
from powered_walker_env import Control, WalkerParams
from tests.helpers.derivation import locked_system, powered_system
from tests.helpers.samples import landing_state, random_motion, random_walkers, relative
from tests.helpers.second_integrator import Landing, strike

WALKERS = ("camp1997", "round-foot")
QUICK = ("--seconds", "0.001", "--walkers", "50")


@pytest.mark.parametrize("name", WALKERS)
def test_the_equations_for_others_walk_the_packages_stride(name: str) -> None:
    problem = make_problem(name)
    starts = problem.starts[:STARTS]
    assert problem.error(scipy_strides(problem, 1e-12, jitted=True)(starts)) < 1e-10
    # The same functions uncompiled, on fewer starts.
    assert problem.error(scipy_strides(problem, 1e-12, jitted=False)(starts[:2])) < 1e-10


def test_the_equations_are_those_of_kane_for_any_walker() -> None:
    """Slope, round foot, inertia, a centre of mass off the leg: nothing in them is zero."""
    rng = np.random.default_rng(3)
    control = Control(switch_angle=2.9, stall_torque=50.0)
    for params in random_walkers(4, 20):
        functions = equations(constants(params, control), jitted=False)
        lock = params.locked_ankle_angle
        q, u = relative(random_motion(rng))
        torque = control.stall_torque * (1.0 + u[1] / params.no_load_speed)
        free = np.cumsum(np.linalg.solve(*powered_system(q, u, torque, params)))
        y = np.concatenate([np.cumsum(q), np.cumsum(u)])
        assert functions.extension(0.0, y) == pytest.approx([*y[3:], *free], rel=1e-9)
        locked = np.cumsum(
            np.linalg.solve(*locked_system([q[0], lock, q[2]], [u[0], 0.0, u[2]], params))
        )
        y = np.array([q[0] + lock, q[0] + lock + q[2], u[0], u[0] + u[2]])
        assert functions.swing(0.0, y) == pytest.approx([*y[2:], *locked], rel=1e-9)


def test_the_strike_keeps_the_momenta_of_any_walker() -> None:
    rng = np.random.default_rng(5)
    for params in random_walkers(6, 20):
        functions = equations(constants(params, Control(2.9, 50.0)), jitted=False)
        y = landing_state(rng, params)
        assert functions.landed(0.0, y) == pytest.approx(0.0, abs=1e-12)
        expected = strike(Landing(0.0, *relative(y)), params)
        assert functions.strike(y) == pytest.approx(list(expected), rel=1e-9)


def test_heyoka_walks_the_same_stride() -> None:
    pytest.importorskip("heyoka")
    problem = make_problem("camp1997")
    (heyoka,) = (c for c in contenders() if c.name.startswith("heyoka"))
    assert problem.error(heyoka.make(problem, 1e-13)(problem.starts[:STARTS])) < 1e-11


def test_the_physics_of_the_listing_is_refused() -> None:
    with pytest.raises(ValueError, match="physics must be 'conserving'"):
        make_problem("camp1997-as-published")


def test_counted_numbers_count_a_formula() -> None:
    def horner(x: Counted) -> Counted:
        return (2.0 * x + 3.0) * x - 1.0 / x  # two products, a sum, a quotient, a difference

    assert count(horner, Counted(0.5)) == 5
    assert count(lambda x: -x, Counted(0.5)) == 0
    a, b = Counted(3.0), Counted(2.0)
    assert [(a + b).value, (a - b).value, (a * b).value, (a / b).value] == [5.0, 1.0, 6.0, 1.5]
    assert [(1 + b).value, (1 - b).value, (4 * b).value, (1 / b).value] == [3.0, -1.0, 8.0, 0.5]


@pytest.mark.parametrize("x", [0.0, 0.3, -0.7, math.pi / 4])
def test_the_sines_that_are_counted_are_sines(x: float) -> None:
    assert sine_and_cosine(x) == pytest.approx((math.sin(x), math.cos(x)), abs=1e-15)


def test_sines_are_reduced_by_quarter_turns() -> None:
    sine, cosine = sine_and_cosine(3.6)  # two quarter turns: both change their sign
    assert (-sine, -cosine) == pytest.approx((math.sin(3.6), math.cos(3.6)), abs=1e-15)


def test_flops_do_not_depend_on_the_walker() -> None:
    flops = {evaluation_flops(make_problem(name).constants) for name in WALKERS}
    ((locked, free),) = flops
    assert 3 * 37 < locked < free < 300
    assert step_flops(6) == 6 * step_flops(1)


def test_speeds_are_read_between_the_rungs() -> None:
    errors, speeds = np.array([1e-4, 1e-8]), np.array([400.0, 100.0])
    assert speed_at(1e-6, errors, speeds) == pytest.approx(200.0)
    assert speed_at(1e-12, errors, speeds) == pytest.approx(100.0)
    assert math.isnan(speed_at(math.inf, errors, speeds))
    assert math.isnan(speed_at(1e-6, np.array([math.inf]), np.array([1.0])))


def test_every_case_takes_its_turn_in_every_round() -> None:
    calls: list[str] = []
    cases = [Case(lambda name=name: calls.append(name), 10) for name in "ab"]  # type: ignore[misc]
    timings = measure(cases, 0.01, rounds=4)
    turns = [name for name, _ in itertools.groupby(calls)]
    assert turns[-8:] == ["a", "b"] * 4
    assert all(timing.wall.shape == (4,) and timing.rate > 0 for timing in timings)


def test_rounds_are_given_up_where_there_is_no_time_for_them() -> None:
    (timing,) = measure([Case(lambda: time.sleep(0.01), 1)], 0.001)
    assert timing.wall.shape == (1,)
    assert timing.rate < 100


def test_rates_are_medians_of_the_rounds() -> None:
    timing = Timing(np.array([0.1, 0.2, 10.0]), np.array([0.1, 0.1, 0.1]))
    assert timing.rate == pytest.approx(5.0)
    assert timing.rate_per_core == pytest.approx(10.0)
    assert timing.cores == pytest.approx(0.5)


def test_cores_double_up_to_all() -> None:
    assert core_counts(1) == (1,)
    assert core_counts(2) == (1, 2)
    assert core_counts(6) == (1, 2, 4, 6)


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contenders_module.importlib.util, "find_spec", lambda _: None)
    found = precision(make_problem("camp1997"), [1e-4], 0.001)
    assert isinstance(found, Precision)
    assert "heyoka, scalar" in found.missing
    assert "not installed: pip install heyoka" in precision_text(found)


def test_the_command_measures_writes_and_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "bench"
    sections = ["precision", "roofline", "scaling"]
    arguments = [*QUICK, "--rtol", "1e-6", "--only", *sections, "--json", "--out", str(folder)]
    assert main(arguments) == 0
    data = json.loads(capsys.readouterr().out)
    assert set(sections) < set(data)
    assert {Path(file) for file in data["written"]} == set(folder.iterdir())
    assert {"bench.json", "bench.txt", "work_precision.svg", "scaling-cores.csv"} <= {
        path.name for path in folder.iterdir()
    }
    own = [rung for rung in data["precision"]["rungs"] if rung["method"] == "ours, a batch"]
    assert 0 < own[0]["error"] < 1e-5
    assert data["roofline"]["bound"] > own[0]["strides_per_second"] > 0
    assert data["scaling"]["cores"][0] == 1
    with (folder / "work_precision.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(data["precision"]["rungs"])
    assert json.loads((folder / "bench.json").read_text())["preset"] == "camp1997"
    assert main(arguments) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.filterwarnings("ignore")  # of other people's environments, if they are installed
def test_the_environments_are_measured(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*QUICK, "--preset", "round-foot", "--only", "environments"]) == 0
    text = capsys.readouterr().out
    assert "PoweredWalkerRoundFoot-v0" in text
    assert re.search(r"50 walkers: memory +\d+ bytes each", text)
    assert re.search(r"BipedalWalker-v3 +.*(µs a step|not installed: pip install)", text)


def test_a_new_process_reaches_its_first_stride() -> None:
    found = startup(processes=1)
    assert all(seconds > 0 for seconds in (*found.environment.values(), *found.stride.values()))
    assert found.environment["second env.step"] < found.first_process


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seconds", "-1"], "seconds must be positive and finite, got -1.0"),
        (["--seconds", "nan"], "seconds must be positive and finite, got nan"),
        (["--rtol", "2"], r"rtol must lie in \[1e-13, 0.001\], got 2.0"),
        (["--walkers", "0"], "--walkers must be at least 1, got 0"),
        (["--out", "no/such"], "does not exist; make it first"),
    ],
)
def test_silly_arguments_are_refused_before_any_work(
    arguments: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*arguments]) == 2
    assert re.search(message, capsys.readouterr().err)


@pytest.mark.parametrize(
    "arguments", [["--only", "weather"], ["--preset", "camp1997-as-published"]]
)
def test_unknown_sections_and_walkers_are_refused(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main([*arguments])
    assert stopped.value.code == 2
    assert "invalid choice" in capsys.readouterr().err


@pytest.mark.slow
def test_a_batch_is_faster_than_scipy_by_far() -> None:
    found = precision(make_problem("camp1997"), [1e-6, 1e-8, 1e-10], 2.0)
    own = [rung.ratio for rung in found.rungs if rung.method == "ours, a batch"]
    assert min(own) > 20


def test_constants_need_the_conserving_physics() -> None:
    with pytest.raises(ValueError, match="equations to compare with"):
        constants(WalkerParams(physics="as_published"), Control(2.9, 700.0))
