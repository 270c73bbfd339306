"""`powered-walker compile`: the kernels' machine code, here or to be carried elsewhere."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import binding

from powered_walker_env.cli.options import add_command
from powered_walker_env.cli.output import Report
from powered_walker_env.compiled.cache import is_kept
from powered_walker_env.envs import PoweredWalkerEnv
from powered_walker_env.envs.noise import draw_normals
from powered_walker_env.envs.stepping import begin_episodes, begin_strides, end_strides
from powered_walker_env.files import folder_aside
from powered_walker_env.model.presets import PRESETS
from powered_walker_env.simulation.kernel import run_strides
from powered_walker_env.simulation.strides import stride

PACKAGE = Path(__file__).parents[1]
ROOM = PACKAGE.name  # the only thing in a folder of compiled code
KERNELS = (run_strides, draw_normals, begin_episodes, begin_strides, end_strides)
COMPILE = "from powered_walker_env.cli.compiling import compile_all; compile_all()"
#: Makes LLVM, which takes any name, complain of one that it does not know.
TRY = """
import sys
from llvmlite import binding
try:
    binding.initialize()
except RuntimeError:  # newer releases do it themselves
    pass
binding.initialize_native_target()
binding.Target.from_default_triple().create_target_machine(cpu=sys.argv[1])
"""


def add_commands(commands: Any) -> None:
    """Add this family's command."""
    command = add_command(
        commands, "compile", _compile, "compile the kernels: for this machine, or to be carried"
    )
    command.add_argument(
        "--to", metavar="FOLDER",
        help="put the machine code there, for NUMBA_CACHE_DIR on machines of the same kind; made, "
        "or added to (default: where it is looked for on this machine)",
    )  # fmt: skip
    command.add_argument(
        "--processor", metavar="NAME",
        help="for this processor, by LLVM's name, as x86-64-v3, and no extras (default: this one)",
    )  # fmt: skip


def compile_all() -> None:
    """Use every kernel once: those that are not on disk are compiled and put there.

    Raises:
        SystemExit: there is no place for them.
    """
    params, control, state, _ = PRESETS["camp1997"]
    stride(state, control, params)
    env = PoweredWalkerEnv(disturbance={"push": 0.01, "parameters": 0.01})
    env.reset(seed=0)
    env.step(np.zeros(2, np.float32))
    if not all(map(is_kept, KERNELS)):
        sys.exit("powered_walker_env: the kernels were compiled, but not kept")


def _compile(options: argparse.Namespace) -> Report:
    variables = {}
    if options.processor is not None:
        _check_processor(options.processor)
        variables = {"NUMBA_CPU_NAME": options.processor, "NUMBA_CPU_FEATURES": ""}
    processor = options.processor or numba.config.CPU_NAME or binding.get_host_cpu_name()
    if options.to is not None:
        target = Path(options.to)
        variables["NUMBA_CACHE_DIR"] = str(target.absolute())
        _carry(target, processor, variables)
    else:
        _in_new_process(processor, variables)
    setting = " ".join(f"{name}={value}" for name, value in variables.items())
    text = f"compiled for {processor}" + (f"; use it with {setting}" if setting else "")
    return Report(text, {"processor": processor, "folder": options.to, "environment": variables})


def _carry(target: Path, processor: str, variables: dict[str, str]) -> None:
    """Make the folder, or add to it: whole or not at all."""
    _check(target)
    with folder_aside(target) as aside:
        if target.is_dir():
            shutil.copytree(target, aside, dirs_exist_ok=True)
        _in_new_process(processor, {**variables, "NUMBA_CACHE_DIR": str(aside.absolute())})


def _check(target: Path) -> None:
    """Find out before the work begins whether the folder can be made or added to."""
    if not target.absolute().parent.is_dir():
        raise FileNotFoundError(f"the folder {str(target.parent)!r} does not exist; make it first")
    if target.exists() and not target.is_dir():
        raise FileExistsError(f"{str(target)!r} is a file; choose another --to")
    if target.name in ("", ".."):
        raise ValueError(f"--to must end in the folder's name, got {str(target)!r}")
    others = [path.name for path in target.glob("*") if path.name != ROOM]
    if others:
        raise FileExistsError(
            f"{str(target)!r} must hold compiled kernels only, got {others[0]!r}; choose another "
            "--to"
        )


def _check_processor(name: str) -> None:
    said = subprocess.run(
        [sys.executable, "-c", TRY, name], capture_output=True, text=True, check=False
    )
    if said.returncode or "not a recognized processor" in said.stderr:
        raise ValueError(
            f"--processor must be a name that LLVM knows, as generic, x86-64-v3 or znver4, got "
            f"{name!r}"
        )


def _in_new_process(processor: str, variables: dict[str, str]) -> None:
    """`compile_all`, with these variables of the environment, which numba reads as it starts."""
    path = os.pathsep.join(filter(None, [str(PACKAGE.parent), os.environ.get("PYTHONPATH")]))
    status = subprocess.run(
        [sys.executable, "-P", "-c", COMPILE],
        env={**os.environ, "PYTHONPATH": path, **variables},
        check=False,
    ).returncode
    if status == -getattr(signal, "SIGILL", 0):
        raise ValueError(
            f"this machine cannot run code for {processor!r}; compile on one that can, or for a "
            "processor that both know"
        )
    if status:
        raise ValueError(f"the kernels could not be compiled and kept for {processor!r}; see above")
