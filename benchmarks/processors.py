"""Other processors: this package's kernels compiled as for older ones, and run on this one.

A walker is a lane of a register, and there are as many lanes as it holds doubles: eight with
AVX-512, four with AVX2, two with plain x86-64, which has no fused multiply-add either. So last
digits differ; by how much is told in tolerances.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.startup import in_new_process
from benchmarks.strides import Problem, make_problem, methods
from benchmarks.timing import Case, Section, measure
from powered_walker_env.compiled.lanes import LANES
from powered_walker_env.tabular import aligned

#: Names of LLVM (`NUMBA_CPU_NAME`); the first is this machine's own.
PROCESSORS = ("native", "haswell", "x86-64")
RTOL, RUNS = 1e-8, 3
OURS = {"batch": "ours, a batch", "single": "ours, stride by stride"}
SCRIPT = "import json; from benchmarks.processors import walked; print(json.dumps(walked({}, {})))"


def processors(problem: Problem, seconds: float = 1.0) -> Section:
    """Start processes in turn, as many rounds of them as `RUNS`; medians.

    Args:
        seconds: for each measurement.

    Raises:
        RuntimeError: a processor whose code this one does not run.
    """
    script = SCRIPT.format(repr(problem.name), seconds / RUNS)
    found: dict[str, list[Any]] = {}
    for _ in range(RUNS):
        for name in PROCESSORS:
            chosen = {} if name == "native" else {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
            found.setdefault(name, []).append(in_new_process(script, chosen))
    native = found["native"]
    rows: list[tuple[str, ...]] = [
        ("processor", "lanes", *(f"{kind}, strides/s" for kind in OURS), "to native", "",
         "off by rtol times", "equal bits")
    ]  # fmt: skip
    data = {}
    for name, runs in found.items():
        rates = {kind: [run[kind] for run in runs] for kind in OURS}
        ratios = {
            kind: float(np.median([a / b[kind] for a, b in zip(own, native, strict=True)]))
            for kind, own in rates.items()
        }
        ends, known = np.array(runs[0]["ends"]), np.array(native[0]["ends"])
        off, equal = float(np.abs(ends - known).max()) / RTOL, float((ends == known).mean())
        speeds = {kind: float(np.median(own)) for kind, own in rates.items()}
        data[name] = {
            "lanes": runs[0]["lanes"], "rates": speeds, "to_native": ratios,
            "off": off, "equal": equal,
        }  # fmt: skip
        rows.append((
            name, str(runs[0]["lanes"]), *(f"{speed:,.0f}" for speed in speeds.values()),
            *(f"{ratio:.2f}" for ratio in ratios.values()), f"{off:.1g}", f"{100 * equal:.0f} %",
        ))  # fmt: skip
    head = f"Other processors: kernels compiled for them, run here at rtol {RTOL:.0e}, CPU time"
    return Section("\n".join([head, "", *aligned(rows)]), data)


def walked(name: str, seconds: float) -> dict[str, object]:
    """Speeds and ends in this process, of strides of a preset."""
    problem = make_problem(name)
    own = {method.name: method for method in methods()}
    cases = []
    for label in OURS.values():
        advance, starts = own[label].make(problem, RTOL), problem.starts[: own[label].batch]
        cases.append(Case(lambda f=advance, s=starts: f(s), len(starts)))  # type: ignore[misc]
    rates = [timing.rate_per_core for timing in measure(cases, seconds)]
    ends = problem.walked(problem.starts, RTOL).tolist()
    return {"lanes": LANES, "ends": ends, **dict(zip(OURS, rates, strict=True))}
