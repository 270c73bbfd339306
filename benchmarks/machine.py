"""What a benchmark ran on."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import Any

from powered_walker_env.results import versions
from powered_walker_env.simulation.threads import cores

OPTIONAL = ("gymnasium", "heyoka", "stable-baselines3", "box2d-py", "box2d", "mujoco")


def machine() -> dict[str, Any]:
    """Processor, cores, load and versions."""
    return {
        "processor": processor(),
        "cores": cores(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "system": platform.system(),
        "versions": versions() | {name: v for name in OPTIONAL if (v := _version(name))},
    }


def processor() -> str:
    """The processor's name, as far as the system tells."""
    try:
        described = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:  # another system than Linux
        described = ""
    fields = {
        key.strip(): value.strip()
        for key, _, value in (line.partition(":") for line in described.splitlines())
    }
    name = fields.get("model name") or platform.processor() or platform.machine()
    family, model = fields.get("cpu family"), fields.get("model")
    return f"{name} (family {family}, model {model})" if family and model else name


def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
