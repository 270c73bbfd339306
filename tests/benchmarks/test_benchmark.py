"""The benchmarks: their equations are right, their counts are those of the equations, they run."""

from __future__ import annotations

import csv
import importlib.util
import itertools
import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853

from benchmarks import processors as processors_module
from benchmarks import startup as startup_module
from benchmarks import timing as timing_module
from benchmarks.__main__ import main
from benchmarks.environments import environments
from benchmarks.equations import (
    Constants,
    constants,
    equations,
    free_accelerations,
    locked_accelerations,
)
from benchmarks.precision import leads, precision, speed_at
from benchmarks.roofline import EVALUATION, SINE_AND_COSINE, STEP
from benchmarks.scaling import core_counts
from benchmarks.startup import startup, times
from benchmarks.strides import STARTS, make_problem, methods, scipy_strides
from benchmarks.timing import Case, Timing, measure
from benchmarks.training import training
from powered_walker_env import Control, WalkerParams
from tests.helpers.derivation import locked_system, powered_system
from tests.helpers.samples import landing_state, random_motion, random_walkers, relative
from tests.helpers.second_integrator import Landing, strike

WALKERS = ("camp1997", "round-foot")
QUICK = ("--seconds", "0.001")


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


@pytest.mark.parametrize("name", WALKERS)
def test_heyoka_walks_the_same_strides_one_by_one_and_in_its_lanes(name: str) -> None:
    pytest.importorskip("heyoka")
    problem = make_problem(name)
    for method in methods():
        if method.name.startswith("heyoka"):
            advance = method.make(problem, 1e-13)
            for count in (STARTS, 3):  # more than there are lanes, and fewer; the second run anew
                assert problem.error(advance(problem.starts[:count])) < 1e-11


def test_a_start_that_never_lands_ends_with_nan_in_heyokas_lanes() -> None:
    pytest.importorskip("heyoka")
    from benchmarks.taylor import batch_strides

    problem = make_problem("camp1997")
    starts = problem.starts[:20].copy()
    starts[4, 2:] = 0.0, 0.0  # at rest: it falls back
    ends = batch_strides(problem.constants, 1e-8)(starts)
    assert np.isnan(ends[4]).all()
    walked = np.arange(20) != 4
    np.testing.assert_allclose(ends[walked], problem.ends[:20][walked], atol=1e-8)


def test_the_physics_of_the_listing_is_refused() -> None:
    with pytest.raises(ValueError, match="physics must be 'conserving'"):
        make_problem("camp1997-as-published")
    with pytest.raises(ValueError, match="equations to compare with"):
        constants(WalkerParams(physics="as_published"), Control(2.9, 700.0))


class Counted:
    """A number that counts the additions, multiplications, divisions and roundings it is in."""

    done = 0

    def __init__(self, value: float) -> None:
        self.value = value

    def _counted(self, other: Any) -> Counted:
        Counted.done += 1
        return Counted(1.0)  # only the count is asked for

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _counted
    __truediv__ = __rtruediv__ = _counted

    def __round__(self) -> Counted:
        return self._counted(None)

    def __neg__(self) -> Counted:
        return self  # a sign is no work: the next operation takes it in


def count(function: Callable[..., Any], *arguments: Any) -> int:
    """Operations that a function does."""
    before = Counted.done
    function(*arguments)
    return Counted.done - before


def sine_and_cosine(x: Any, sine: tuple[float, ...], cosine: tuple[float, ...]) -> tuple[Any, Any]:
    """Both to rounding, up to the quadrant: x + x³P(x²) and 1 - x²/2 + x⁴Q(x²) (Cephes, 1984)."""
    turns = round(x * (2.0 / math.pi))
    r = ((x - turns * 1.57079625129699707031) - turns * 7.54978941586159635335e-8) - (
        turns * 5.39030285815811905290e-15
    )
    z = r * r
    p, q = sine[0], cosine[0]
    for s, c in zip(sine[1:], cosine[1:], strict=True):
        p, q = p * z + s, q * z + c
    return r + r * z * p, (1.0 - 0.5 * z) + z * z * q


def test_the_flops_stated_are_those_of_the_equations() -> None:
    numbers = [Counted(1.0) for _ in Constants._fields]
    c, turns, rates = Constants(*numbers), numbers[:6], numbers[:3]  # type: ignore[arg-type]
    coefficients = (1.0,) * 6  # of each polynomial
    assert count(sine_and_cosine, Counted(1.0), coefficients, coefficients) == SINE_AND_COSINE
    # The foot's angle is the leg's less the lock: one more with the foot locked.
    assert count(locked_accelerations, c, turns, rates) + 1 == EVALUATION[0] - 3 * SINE_AND_COSINE
    assert count(free_accelerations, c, turns, rates) == EVALUATION[1] - 3 * SINE_AND_COSINE


def test_the_flops_of_a_step_are_those_of_the_tableau() -> None:
    stages = sum(2 * int(np.count_nonzero(row)) + 1 for row in DOP853.A[1:])
    end = 2 * int(np.count_nonzero(DOP853.B)) + 1
    errors = 2 * int(np.count_nonzero(DOP853.E3) + np.count_nonzero(DOP853.E5))
    norms = 3 + 2 * 3  # tolerance·max(...) and the quotients by it; squares and sums
    assert ((stages + end + errors + norms) * np.array([4, 6]) == STEP).all()


def test_speeds_are_read_between_the_rungs() -> None:
    errors, speeds = np.array([1e-4, 1e-8]), np.array([400.0, 100.0])
    assert speed_at(1e-6, errors, speeds) == pytest.approx(200.0)
    assert speed_at(1e-12, errors, speeds) == pytest.approx(100.0)
    assert math.isnan(speed_at(math.inf, errors, speeds))
    assert math.isnan(speed_at(1e-6, np.array([math.inf]), np.array([1.0])))


def test_leads_are_read_at_an_error_that_both_reach() -> None:
    errors = np.array([[1e-6, 1e-9], [1e-7, 1e-8]])  # of another, and of ours
    speeds = np.array([[[10.0], [5.0]], [[100.0], [80.0]]])
    ahead = leads(["another", "ours, a batch"], errors, speeds)
    assert list(ahead) == ["another"]
    slower = 10.0 * 0.5 ** (2 / 3)  # of the other at 1e-8, two thirds of the way to 1e-9
    assert ahead["another"] == pytest.approx([100.0 / 10.0, 80.0 / slower])


class Clock:
    """A clock that goes on only when somebody works."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        for name in ("perf_counter", "process_time"):
            monkeypatch.setattr(timing_module.time, name, lambda: self.now)

    def work(self, seconds: float) -> None:
        self.now += seconds


def test_every_case_takes_its_turn_in_every_round(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, calls = Clock(monkeypatch), []

    def case(name: str, seconds: float) -> Case:
        return Case(lambda: (calls.append(name), clock.work(seconds)), 10)

    quick, slow = measure([case("quick", 1e-4), case("slow", 5e-4)], 0.01, rounds=4)
    turns = [(name, len(list(group))) for name, group in itertools.groupby(calls)]
    assert turns == [("quick", 2), ("slow", 2), *[("quick", 25), ("slow", 5)] * 4]
    assert quick.wall == pytest.approx([1e-5] * 4)
    assert slow.cpu == pytest.approx([5e-5] * 4)


def test_rounds_are_given_up_where_there_is_no_time_for_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock(monkeypatch)
    (timing,) = measure([Case(lambda: clock.work(0.01))], 0.001)
    assert timing.wall == pytest.approx([0.01])


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
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    found = precision(make_problem("camp1997"), [1e-4], 0.001)
    remedy = "not installed: pip install heyoka"
    assert found.data["missing"] == {"heyoka, scalar": remedy, "heyoka, a batch": remedy}
    assert f"heyoka, a batch: {remedy}" in found.text


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
    named = {path.name for path in folder.iterdir()}
    assert {"bench.json", "bench.txt", "work_precision.svg"} <= named
    own = [rung for rung in data["precision"]["rungs"] if rung["method"] == "ours, a batch"]
    assert 0 < own[0]["error"] < 1e-5
    assert data["roofline"]["flops"] == pytest.approx(73_490, abs=100)  # of one stride
    assert data["scaling"]["by_cores"]["cores"][0] == 1
    with (folder / "work_precision.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(data["precision"]["rungs"])
    assert json.loads((folder / "bench.json").read_text())["preset"] == "camp1997"
    assert main(arguments) == 2
    assert "exists already" in capsys.readouterr().err


def test_the_environments_are_measured() -> None:
    text = environments("round-foot", 0.001, crowd=50).text
    assert "PoweredWalkerRoundFoot-v0" in text
    assert re.search(r"env\.step, with its resets +[\d.,]+ µs", text)
    assert re.search(r"50 walkers: memory +\d+ bytes each", text)


def test_a_training_is_told_part_by_part() -> None:
    told = training("round-foot", 2048)
    assert told.data["strides"] == 2048
    assert all(seconds > 0 for seconds in told.data["seconds"].values())
    shares = [float(share) for share in re.findall(r"([\d.]+)%", told.text)]
    assert len(shares) == 5
    assert sum(shares) == pytest.approx(100.0, abs=0.5)


def test_a_cold_start_is_told_part_by_part(monkeypatch: pytest.MonkeyPatch) -> None:
    found = times({})  # over the kernels that there are
    for part in ("imports", "first stride", "first find_gait"):
        assert all(seconds >= 0 for seconds in found[part])
    caches: list[str] = []

    def remembered(environment: Mapping[str, str]) -> Any:
        caches.append(environment["NUMBA_CACHE_DIR"])
        assert Path(caches[-1]).is_dir() and not list(Path(caches[-1]).iterdir())
        return found

    monkeypatch.setattr(startup_module, "times", remembered)
    told = startup()
    assert caches[0] == caches[1]  # the second run finds what the first has left
    assert not Path(caches[0]).exists()
    assert set(told.data) == {"empty cache", "kernels on disk"}
    assert "first env.step, with make and reset" in told.text


def test_a_process_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(startup_module, "PARTS", "raise SystemExit('no floor')")
    with pytest.raises(RuntimeError, match="a new process failed to walk: no floor"):
        times({})


def test_processors_are_told_beside_the_native_one(monkeypatch: pytest.MonkeyPatch) -> None:
    names: list[str] = []

    def here(script: str, environment: Mapping[str, str]) -> Any:
        assert "walked('camp1997', 0.0" in script
        names.append(environment.get("NUMBA_CPU_NAME", "native"))
        return processors_module.walked("camp1997", 0.001)

    monkeypatch.setattr(processors_module, "in_new_process", here)
    found = processors_module.processors(make_problem("camp1997"), 0.001)
    assert names == [*processors_module.PROCESSORS] * processors_module.RUNS
    assert found.data["haswell"]["equal"] == 1.0
    assert found.data["haswell"]["off"] == 0.0
    assert re.search(r"native +\d+ +[\d,]+ +[\d,]+ +1\.00 +1\.00 +0 +100 %", found.text)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--seconds", "-1"], "--seconds must be positive and finite, got -1.0"),
        (["--seconds", "nan"], "--seconds must be positive and finite, got nan"),
        (["--rtol", "2"], r"rtol must lie in \[1e-13, 0.001\], got 2.0"),
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
