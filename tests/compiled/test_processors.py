"""Other processors: kernels compiled as for an older one give the same walks, to the tolerance.

Not bit for bit: without fused multiply-adds nearly every last digit differs. With them (AVX2 beside
AVX-512), four lanes give the bits of eight but for a few strides in ten thousand.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from llvmlite.binding import get_host_cpu_features, get_process_triple

from powered_walker_env import PRESETS
from powered_walker_env.compiled.lanes import LANES
from powered_walker_env.model.phases import Outcome
from powered_walker_env.simulation.strides import stride_batch

RTOL, COUNT = 1e-10, 40
SPREAD = 0.003, 0.003, 0.01, 0.01  # rad, rad/s about the gaits
#: Processors by the names of LLVM, what they need of this one, and how many lanes they have.
PROCESSORS = {"haswell": (("avx2", "fma"), 4), "x86-64": ((), 2)}
SCRIPT = """
import json
from powered_walker_env.compiled.lanes import LANES
from tests.compiled.test_processors import walked
print(json.dumps([LANES, walked()]))
"""


def walked() -> dict[str, list[list[float]]]:
    """Rows of results of strides about every preset's gait."""
    rng = np.random.default_rng(11)
    return {
        name: stride_batch(
            np.array(state) + np.array(SPREAD) * rng.uniform(-1, 1, (COUNT, 4)),
            control,
            params,
            rtol=RTOL,
        ).results.tolist()
        for name, (params, control, state, _) in PRESETS.items()
    }


@pytest.mark.skipif(not get_process_triple().startswith("x86_64"), reason="made for x86-64")
@pytest.mark.parametrize("name", ["haswell", pytest.param("x86-64", marks=pytest.mark.slow)])
def test_an_older_processor_walks_the_same_strides_to_the_tolerance(name: str) -> None:
    needed, lanes = PROCESSORS[name]
    if not all(get_host_cpu_features().get(feature) for feature in needed):
        pytest.skip(f"this processor runs no code for {name}")
    environment = os.environ | {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
    found = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True
    )
    assert found.returncode == 0, found.stderr
    width, theirs = json.loads(found.stdout)
    assert width == lanes
    for preset, rows in walked().items():
        ours, other = np.array(rows), np.array(theirs[preset])
        np.testing.assert_array_equal(other[:, -1], ours[:, -1])
        good = ours[:, -1] == Outcome.WALKED
        assert good.sum() > COUNT // 2
        np.testing.assert_allclose(other[good, :4], ours[good, :4], rtol=0, atol=10 * RTOL)


def test_lanes_are_as_many_as_a_register_holds_doubles() -> None:
    features = get_host_cpu_features()
    if "NUMBA_CPU_NAME" not in os.environ and get_process_triple().startswith("x86_64"):
        wide = 8 if features.get("avx512f") else 4 if features.get("avx") else 2
        assert wide == LANES
